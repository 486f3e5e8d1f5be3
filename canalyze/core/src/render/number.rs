//! The value of a signal as a bare number, for machines: no unit, no words.

use crate::services::pdo::mapping::{Mapped, Mapping, Number, number};
use crate::text::digits::{Joined, put};
use crate::text::signal::product;

/// Numbers beyond this are strings in JSON, since a double holds no more.
const EXACT: u64 = 1 << 53;

/// What a value is, so that each format can mark it.
pub(super) enum Shape {
    /// A decimal number that a double holds exactly, or a real.
    Number,
    /// A whole number beyond 2^53.
    Long,
    /// Bytes in hexadecimal.
    Bytes,
    /// There is none: the payload does not reach, or it is no finite number.
    Missing,
}

/// Appends the unsigned number in the payload, or the bytes of an entry longer than 64 bits.
pub(super) fn raw(out: &mut Vec<u8>, mapping: &Mapping, mapped: &Mapped, payload: &[u8]) -> Shape {
    match mapping.raw(mapped, payload) {
        Some(raw) => whole(out, false, raw),
        None => bytes(out, mapping, mapped, payload),
    }
}

/// Appends the value with sign, type and factor applied.
pub(super) fn value(out: &mut Vec<u8>, mapping: &Mapping, mapped: &Mapped, payload: &[u8]) -> Shape {
    let Some(raw) = mapping.raw(mapped, payload) else { return bytes(out, mapping, mapped, payload) };
    let scaled = mapped.factor != 1.0;
    match number(mapped.data_type, raw, mapped.bits) {
        Number::Bool(on) => whole(out, false, u64::from(on)),
        Number::Unsigned(read) if !scaled => whole(out, false, read),
        Number::Signed(read) if !scaled => whole(out, read < 0, read.unsigned_abs()),
        Number::Unsigned(read) => real(out, product(read as f64, mapped.factor)),
        Number::Signed(read) => real(out, product(read as f64, mapped.factor)),
        // The shortest decimal of the single precision number, not of its double.
        Number::Real32(read) if !scaled => shortest(out, read.is_finite(), read.to_string()),
        Number::Real32(read) => real(out, f64::from(read) * mapped.factor),
        Number::Real64(read) => real(out, read * mapped.factor),
        Number::Bytes => bytes(out, mapping, mapped, payload),
    }
}

fn whole(out: &mut Vec<u8>, negative: bool, magnitude: u64) -> Shape {
    if negative {
        out.push(b'-');
    }
    put!(out; magnitude);
    if magnitude <= EXACT { Shape::Number } else { Shape::Long }
}

fn real(out: &mut Vec<u8>, read: f64) -> Shape {
    shortest(out, read.is_finite(), read.to_string())
}

fn shortest(out: &mut Vec<u8>, finite: bool, text: String) -> Shape {
    if !finite {
        return Shape::Missing;
    }
    out.extend_from_slice(text.as_bytes());
    Shape::Number
}

fn bytes(out: &mut Vec<u8>, mapping: &Mapping, mapped: &Mapped, payload: &[u8]) -> Shape {
    match mapping.octets(mapped, payload) {
        Some(octets) => {
            put!(out; Joined(octets));
            Shape::Bytes
        }
        None => Shape::Missing,
    }
}

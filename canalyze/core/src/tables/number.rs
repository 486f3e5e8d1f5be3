//! The value of a signal as a bare number, for machines: no unit, no words.

use std::fmt::Display;
use std::io::Write;

use crate::wire::pdo::mapping::{Mapped, Mapping, Number, number};
use crate::words::digits::{Joined, put};
use crate::words::signal::{self, product};

/// The factors that are written by hand.
const POWERS: [f64; 6] = [0.1, 0.01, 0.001, 0.0001, 0.00001, 0.000_001];
/// The least number of 16 digits.
const DIGITS_15: u64 = 1_000_000_000_000_000;
/// Numbers beyond this are strings in JSON, since a double holds no more.
const EXACT: u64 = 1 << 53;

/// The shape of a value, by which each format marks it.
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

/// An entry of a mapping and its bits in a payload.
#[derive(Clone, Copy)]
pub(super) struct EntryBits<'a> {
    pub(super) mapping: &'a Mapping,
    pub(super) mapped: &'a Mapped,
    pub(super) payload: &'a [u8],
    /// Its bits, as [`Mapping::raw`] has them.
    pub(super) raw: Option<u64>,
}

impl<'a> EntryBits<'a> {
    /// Reads an entry in a payload.
    pub(super) fn new(mapping: &'a Mapping, mapped: &'a Mapped, payload: &'a [u8]) -> Self {
        Self { mapping, mapped, payload, raw: mapping.raw(mapped, payload) }
    }
}

/// Appends the unsigned number in the payload, or the bytes of an entry longer than 64 bits.
pub(super) fn raw(out: &mut Vec<u8>, entry: EntryBits<'_>) -> Shape {
    match entry.raw {
        Some(raw) => whole(out, false, raw),
        None => bytes(out, entry),
    }
}

/// Appends the value with sign, type and factor applied.
pub(super) fn value(out: &mut Vec<u8>, entry: EntryBits<'_>) -> Shape {
    let EntryBits { mapped, raw: Some(raw), .. } = entry else { return bytes(out, entry) };
    let scaled = mapped.factor != 1.0;
    match number(mapped.data_type, raw, mapped.bits) {
        Number::Bool(on) => whole(out, false, u64::from(on)),
        Number::Unsigned(read) if !scaled => whole(out, false, read),
        Number::Signed(read) if !scaled => whole(out, read < 0, read.unsigned_abs()),
        Number::Unsigned(read) => scaled_whole(out, false, read, mapped.factor),
        Number::Signed(read) => scaled_whole(out, read < 0, read.unsigned_abs(), mapped.factor),
        // The shortest decimal of the single precision number, not of its double.
        Number::Real32(read) if !scaled => shortest(out, read.is_finite(), read),
        Number::Real32(read) => real(out, f64::from(read) * mapped.factor),
        Number::Real64(read) => real(out, read * mapped.factor),
        Number::Bytes => bytes(out, entry),
    }
}

/// Appends a value as JSON: bare where a double holds it, else in quotes.
pub(super) fn marked(out: &mut Vec<u8>, write: impl FnOnce(&mut Vec<u8>) -> Shape) {
    let start = out.len();
    match write(out) {
        Shape::Number => {}
        Shape::Missing => put!(out; "null"),
        Shape::Long | Shape::Bytes => {
            out.insert(start, b'"');
            out.push(b'"');
        }
    }
}

fn whole(out: &mut Vec<u8>, negative: bool, magnitude: u64) -> Shape {
    if negative {
        out.push(b'-');
    }
    put!(out; magnitude);
    if magnitude <= EXACT { Shape::Number } else { Shape::Long }
}

/// A whole number times a factor. Such a power of ten as is the rule is written by hand: up to 15 digits are those of
/// the double, too.
fn scaled_whole(out: &mut Vec<u8>, negative: bool, magnitude: u64, factor: f64) -> Shape {
    let digits = POWERS.iter().position(|power| factor == *power);
    match digits {
        Some(digits) if magnitude < DIGITS_15 && magnitude != 0 => {
            signal::fixed(out, negative, magnitude, digits as u8 + 1);
            Shape::Number
        }
        _ => {
            let read = magnitude as f64;
            real(out, product(if negative { -read } else { read }, factor))
        }
    }
}

fn real(out: &mut Vec<u8>, read: f64) -> Shape {
    shortest(out, read.is_finite(), read)
}

fn shortest(out: &mut Vec<u8>, finite: bool, read: impl Display) -> Shape {
    if !finite {
        return Shape::Missing;
    }
    // Writing to a vector cannot fail.
    let _ = write!(out, "{read}");
    Shape::Number
}

fn bytes(out: &mut Vec<u8>, entry: EntryBits<'_>) -> Shape {
    match entry.mapping.octets(entry.mapped, entry.payload) {
        Some(octets) => {
            put!(out; Joined(octets));
            Shape::Bytes
        }
        None => Shape::Missing,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn by_hand_as_the_double_is_written(magnitude in 0u64..2_000_000_000_000_000, negative: bool, digits in 1i32..8) {
            let factor = 1.0 / 10f64.powi(digits);
            let mut out = Vec::new();
            scaled_whole(&mut out, negative, magnitude, factor);
            let read = if negative { -(magnitude as f64) } else { magnitude as f64 };
            prop_assert_eq!(String::from_utf8_lossy(&out), product(read, factor).to_string());
        }
    }
}

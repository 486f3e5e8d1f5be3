//! Values in words: the content of an object's bytes, by its standard data type or by their appearance.
//!
//! They are the same in both languages except for units. The object is determined by the caller.

use std::sync::Arc;

use super::digits::{Hex, Spaced, put};
pub use super::lang::Size;
use super::{Lang, escape, parameter, signal, terms};
use crate::sdo::wire::Mux;
use crate::wire::pdo::Multiplexed;
use crate::wire::pdo::mapping::{Mapped, Mapping, extract};
use crate::wire::time::Clock;
use crate::words::profiles::Profile;
use crate::world::dictionary::{Described, Object};
use crate::world::drive;
use crate::world::od::{self, DataType, Value};

/// Maximum number of bytes of a text that are shown.
const TEXT: usize = 512;
/// Maximum number of bytes that are shown in hexadecimal.
pub(super) const BYTES: usize = 32;

/// A value. `bytes` may be only the beginning of `size` bytes.
pub fn value(out: &mut Vec<u8>, lang: Lang, data_type: Option<DataType>, bytes: &[u8], size: u64) {
    let whole = bytes.len() as u64 == size;
    match od::decode(data_type, bytes) {
        Value::Empty => put!(out; lang.pick("(空)", "(empty)")),
        Value::Bool(value) => put!(out; if value { "TRUE" } else { "FALSE" }),
        Value::Signed(value) => {
            put!(out; value);
            hexadecimal(out, bytes);
        }
        Value::Unsigned(value) => {
            put!(out; value);
            hexadecimal(out, bytes);
        }
        Value::Real(value) => out.extend_from_slice(value.to_string().as_bytes()),
        Value::Text(text) => quoted(out, text.as_bytes(), whole),
        Value::Time { ms, days } => put!(out; days, "d ", Clock(ms)),
        Value::Difference { ms, days } => put!(out; days, "d ", Clock(ms)),
        Value::Bytes(bytes) if data_type == Some(DataType::UnicodeString) && bytes.len() % 2 == 0 => {
            quoted(out, od::unicode(bytes.get(..TEXT).unwrap_or(bytes)).as_bytes(), whole && bytes.len() <= TEXT);
        }
        Value::Bytes(bytes) => {
            put!(out; Spaced(bytes.get(..BYTES).unwrap_or(bytes)));
            if bytes.len() > BYTES || !whole {
                put!(out; " ...");
            }
        }
    }
}

/// Appends a blank and the name of an object, if it has one: the standard's, or the manufacturer's as it is.
pub fn name(out: &mut Vec<u8>, lang: Lang, mux: Mux, described: &Described) {
    match &described.object {
        Some(object) => {
            put!(out; " ");
            signal::name_beside_object(out, lang, &as_mapped(object, described.profile));
        }
        None => {
            if let Some(name) = terms::object_name(lang, described.profile, mux.index, mux.sub) {
                put!(out; " ", name);
            }
        }
    }
}

/// Returns a described object as if a PDO carried all of it.
pub(crate) fn as_mapped(object: &Object, profile: Profile) -> Mapped {
    Mapped {
        name: Some(Arc::clone(&object.name)),
        unit: object.unit.clone(),
        factor: object.factor,
        ..undescribed(Mux { index: object.index, sub: object.sub }, object.data_type(), profile)
    }
}

/// Returns an object without a description as if a PDO carried all of it.
pub(crate) fn undescribed(mux: Mux, data_type: Option<DataType>, profile: Profile) -> Mapped {
    Mapped {
        index: mux.index,
        sub: mux.sub,
        bits: data_type.and_then(DataType::size).map_or(0, |bytes| 8 * bytes as u8),
        offset: 0,
        data_type,
        profile,
        dummy: false,
        name: None,
        unit: None,
        factor: 1.0,
    }
}

/// Appends the value of an object that was transferred completely.
pub fn of_object(out: &mut Vec<u8>, lang: Lang, mux: Mux, described: &Described, bytes: &[u8]) {
    let profile = described.profile;
    let standard = profile.data_type(mux.index, mux.sub);
    let data_type = described.data_type(mux.index, mux.sub);
    // With a description, numbers have units and factors, as in a PDO; the standard's forms of objects are kept.
    if let Some(object) = &described.object
        && (standard.is_none() || object.unit.is_some() || object.factor != 1.0)
        && matches!(data_type.and_then(DataType::size), Some(size) if size == bytes.len() && size <= 8)
        && let Some(raw) = extract(bytes, 0, 8 * bytes.len())
    {
        signal::value(out, lang, &as_mapped(object, profile), raw);
        if bytes.len() > 1 || object.factor != 1.0 {
            hexadecimal(out, bytes);
        }
        return;
    }
    if profile.is_bit_field(mux.index, mux.sub) && matches!(bytes.len(), 1..=4) {
        for byte in bytes.iter().rev() {
            put!(out; Hex::<2>(u64::from(*byte)));
        }
        put!(out; "h");
    } else {
        value(out, lang, data_type, bytes, bytes.len() as u64);
    }
    // Some objects of a drive have words of their own.
    let own = described.object.as_deref();
    let drives = own.map_or(profile.may_be_drive(), |object| as_mapped(object, profile).is_drives());
    if drives && drive::DriveObject::at(mux.index).is_some() && standard.and_then(DataType::size) == Some(bytes.len()) {
        let raw = bytes.iter().rev().fold(0, |raw, byte| raw << 8 | u64::from(*byte));
        put!(out; " ");
        signal::annotation(out, lang, mux.index, raw);
    }
    parameter::words(out, lang, mux, bytes);
    // Store and restore parameters are written as a word: "save", "load" (CiA 301, 7.5.2.13).
    if matches!(mux.index, 0x1010 | 0x1011) && matches!(bytes, b"save" | b"load") {
        put!(out; " \"");
        escape::terminal(out, bytes);
        put!(out; "\"");
    }
}

/// Appends the object of a multiplex PDO and its value: `2000h:01 电机温度 = 4.2 degC`; without a type its bytes. `mapping`
/// is the known mapping of the object.
pub fn multiplexed(out: &mut Vec<u8>, lang: Lang, content: &Multiplexed, mapping: Option<&Mapping>) {
    let mux = Mux { index: content.index, sub: content.sub };
    put!(out; mux);
    let known = mapping.and_then(|mapping| mapping.entries.first());
    if let Some(mapped) = known.filter(|mapped| signal::has_name(lang, mapped)) {
        put!(out; " ");
        signal::name_beside_object(out, lang, mapped);
    }
    put!(out; " = ");
    let whole = known.filter(|mapped| mapped.is_whole());
    match whole.and_then(|mapped| Some((mapped, content.data.get(..usize::from(mapped.bits / 8))?))) {
        Some((mapped, bytes)) => {
            signal::value(out, lang, mapped, extract(bytes, 0, 8 * bytes.len()).unwrap_or(0));
            parameter::words(out, lang, mux, bytes);
        }
        None => put!(out; Spaced(&content.data), " (", u32::from_le_bytes(content.data), ")"),
    }
}

/// Appends `" (0FA0h)"` to a number of several bytes or beyond one digit, as wide as its bytes.
fn hexadecimal(out: &mut Vec<u8>, bytes: &[u8]) {
    put!(out; " (");
    for byte in bytes.iter().rev() {
        put!(out; Hex::<2>(u64::from(*byte)));
    }
    put!(out; "h)");
}

fn quoted(out: &mut Vec<u8>, text: &[u8], whole: bool) {
    put!(out; "\"");
    escape::terminal(out, text.get(..TEXT).unwrap_or(text));
    put!(out; "\"");
    if !whole || text.len() > TEXT {
        put!(out; " ...");
    }
}

/// Appends the bytes of one segment: as text if all of them are printable, else in hexadecimal.
pub fn segment(out: &mut Vec<u8>, bytes: &[u8]) {
    if !bytes.is_empty() && bytes.iter().all(|byte| (0x20..0x7F).contains(byte)) {
        quoted(out, bytes, true);
    } else {
        put!(out; Spaced(bytes));
    }
}

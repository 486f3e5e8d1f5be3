//! Values of objects in words, from any service.

use super::value::{as_mapped, of_object, undescribed, value};
use super::{Lang, signal, transferred};
use crate::sdo::wire::Mux;
use crate::views::inventory::sighting::{ObjectSighting, Shown};
use crate::views::inventory::{ObservedObject, SeenValue, TypeFrom};
use crate::wire::pdo::mapping::Mapped;
use crate::world::dictionary::Described;

/// Appends a value of an object, with its unit and its meaning if they are known.
pub fn held(out: &mut Vec<u8>, lang: Lang, mux: Mux, object: &ObservedObject, held: &SeenValue) {
    match held {
        SeenValue::Bits(raw, bits) => signal::value(out, lang, &Mapped { bits: *bits, ..mapped(mux, object) }, *raw),
        SeenValue::Bytes(bytes, size) => {
            let known = object.data_type(mux);
            let typed = object.described.data_type(mux.index, mux.sub).is_some();
            // Without a description or a standard, the values determine the type.
            let inferred = known.is_some_and(|(_, from)| from == TypeFrom::Inferred) && !typed;
            match bytes.len() as u64 == *size && !inferred {
                true => of_object(out, lang, mux, &object.described, bytes),
                false => value(out, lang, known.map(|known| known.0), bytes, *size),
            }
        }
    }
}

/// Returns an object as if a PDO carried it, by all that is known of it.
pub(crate) fn mapped(mux: Mux, object: &ObservedObject) -> Mapped {
    let profile = object.described.profile;
    match &object.described.object {
        Some(one) => as_mapped(one, profile),
        None => undescribed(mux, object.data_type(mux).map(|known| known.0), profile),
    }
}

/// Appends a number of an object, as wide as its type.
pub fn number(out: &mut Vec<u8>, lang: Lang, mux: Mux, described: &Described, number: u64) {
    let size = described.data_type(mux.index, mux.sub).and_then(|data_type| data_type.size()).unwrap_or(4).min(8);
    let bytes = number.to_le_bytes();
    of_object(out, lang, mux, described, bytes.get(..size).unwrap_or(&bytes));
}

/// Appends the value that a frame or a transfer shows.
pub fn seen(out: &mut Vec<u8>, lang: Lang, sighting: &ObjectSighting<'_>) {
    match sighting.shown {
        Shown::Transfer(transfer) => transferred::transferred(out, lang, transfer),
        Shown::Bits(mapped, raw) => signal::value(out, lang, mapped, raw),
        Shown::Octets(mapped, bytes) => value(out, lang, mapped.data_type, bytes, bytes.len() as u64),
        Shown::Register(register, profile) => {
            number(out, lang, sighting.object, &Described { profile, ..Described::default() }, u64::from(register));
        }
    }
}

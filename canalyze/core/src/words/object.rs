//! Objects of the dictionary in CiA's notation: `1008h:00`.

use super::digits::{Hex, Put, put};
use crate::rules::finding::{Measured, Quantity};
use crate::sdo::wire::Mux;

impl Put for Mux {
    fn put(&self, out: &mut Vec<u8>) {
        put!(out; Hex::<4>(u64::from(self.index)), "h:", Hex::<2>(u64::from(self.sub)));
    }
}

/// Appends an object and a blank before a sentence that does not name it by itself.
pub fn before(out: &mut Vec<u8>, object: Option<Mux>, sentence: Option<&Measured>) {
    let named = sentence.is_some_and(|all| all.facts().any(|(_, fact)| matches!(fact, Quantity::Object(_))));
    if let Some(object) = object.filter(|_| !named) {
        put!(out; object);
        pdo_of(out, object);
        put!(out; " ");
    }
}

/// Appends the PDO of a parameter: ` (TPDO1)` behind 1800h or 1A00h. Nothing for other objects.
pub fn pdo_of(out: &mut Vec<u8>, mux: Mux) {
    let (name, number) = match mux.index {
        0x1400..=0x17FF => (" (RPDO", mux.index % 0x200),
        0x1800..=0x1BFF => (" (TPDO", mux.index % 0x200),
        _ => return,
    };
    put!(out; name, number + 1, ")");
}

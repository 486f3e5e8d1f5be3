//! Which object something is about: its index and sub-index, and the PDO that it is a parameter of. The same in both
//! languages. It must not say what it holds: `value` does.

use super::digits::{Hex, put};
use crate::services::sdo::wire::Mux;

/// An object as CiA writes it: `1008h:00`.
pub fn number(out: &mut Vec<u8>, mux: Mux) {
    put!(out; Hex::<4>(u64::from(mux.index)), "h:", Hex::<2>(u64::from(mux.sub)));
}

/// Which PDO a parameter is of: ` (TPDO1)` behind 1800h or 1A00h. Nothing for other objects.
pub fn pdo_of(out: &mut Vec<u8>, mux: Mux) {
    let (name, number) = match mux.index {
        0x1400..=0x17FF => (" (RPDO", mux.index % 0x200),
        0x1800..=0x1BFF => (" (TPDO", mux.index % 0x200),
        _ => return,
    };
    put!(out; name, number + 1, ")");
}

//! What a finding measured, as an object: the keys are the names that stand in the rule's sentence.
//!
//! Times have `_ns` appended to their key, hexadecimal quantities are strings, a PDO is `TPDO1`.

use crate::finding::Quantity;
use crate::text::digits::{Hex, put};

/// Appends the object.
pub(super) fn told(out: &mut Vec<u8>, measured: &[(&'static str, Quantity)]) {
    let mut before = "{\"";
    for (name, quantity) in measured {
        if *quantity == Quantity::Nothing {
            continue;
        }
        put!(out; before, *name);
        before = ",\"";
        if matches!(quantity, Quantity::Ns(_)) {
            put!(out; "_ns");
        }
        put!(out; "\":");
        match *quantity {
            Quantity::Nothing => {}
            Quantity::Count(number) => put!(out; number),
            Quantity::Signed(number) => put!(out; number),
            Quantity::Ns(ns) => put!(out; ns),
            Quantity::Hex2(number)
            | Quantity::State(number)
            | Quantity::Command(number)
            | Quantity::Lss(number)
            | Quantity::LssError(_, number) => {
                put!(out; "\"", Hex::<2>(u64::from(number)), "\"");
            }
            Quantity::Hex4(number)
            | Quantity::Statusword(number)
            | Quantity::Controlword(number)
            | Quantity::Emcy(number)
            | Quantity::Type(number) => put!(out; "\"", Hex::<4>(u64::from(number)), "\""),
            Quantity::Hex8(number) => put!(out; "\"", Hex::<8>(u64::from(number)), "\""),
            Quantity::Object(mux) => {
                put!(out; "\"", Hex::<4>(u64::from(mux.index)), ":", Hex::<2>(u64::from(mux.sub)), "\"");
            }
            Quantity::Id(id) if id.is_extended() => put!(out; "\"", Hex::<8>(u64::from(id.raw())), "\""),
            Quantity::Id(id) => put!(out; "\"", Hex::<3>(u64::from(id.raw())), "\""),
            Quantity::Pdo(transmit, number) => put!(out; if transmit { "\"TPDO" } else { "\"RPDO" }, number, "\""),
            Quantity::Mode(mode) => put!(out; i64::from(mode)),
        }
    }
    put!(out; if before == "{\"" { "{}" } else { "}" });
}

//! What a finding measured, as an object: the keys are the names that stand in the rule's sentence.
//!
//! Times have `_ns` appended to their key, hexadecimal quantities are strings, a PDO is `TPDO1`.

use super::{number_or_null, sdo, truth};
use crate::rules::finding::{CrcMatch, Facts, Finding, Measured, Problem, Quantity, Said, Unmet};
use crate::words::digits::{Hex, Joined, put};
use crate::words::escape;
use crate::world::drive;
use crate::world::event::{Note, Scanned};

/// The parts of an LSS address.
const PARTS: [&str; 4] = ["vendor", "product", "revision", "serial"];

/// Appends `,"facts":{...}` to a note; most have none.
pub(super) fn note(out: &mut Vec<u8>, note: Note) {
    match note {
        Note::RequestNotCaptured | Note::LostByReset => put!(out; ",\"facts\":{}"),
        Note::LssSelected { address } => {
            put!(out; ",\"facts\":{");
            parts(out, address.map(Some));
            put!(out; "}");
        }
        Note::Fastscan(Scanned { address, frames, duration_ns, .. }) => {
            put!(out; ",\"facts\":{");
            parts(out, address);
            put!(out; ",\"requests\":", frames, ",\"duration_ns\":");
            match duration_ns {
                Some(ns) => put!(out; ns),
                None => put!(out; "null"),
            }
            put!(out; "}");
        }
        Note::BitTimingActivated { delay, rate } => {
            put!(out; ",\"facts\":{\"delay_ms\":", delay, ",\"kbit_s\":");
            number_or_null(out, rate.map(u64::from));
            put!(out; "}");
        }
        Note::NodeIdChanged { from, to } => put!(out; ",\"facts\":{\"from\":", from, ",\"to\":", to, "}"),
    }
}

fn parts(out: &mut Vec<u8>, address: [Option<u32>; 4]) {
    let mut before = "\"";
    for (name, part) in PARTS.into_iter().zip(address) {
        put!(out; before, name, "\":");
        before = ",\"";
        match part {
            Some(part) => put!(out; "\"", Hex::<8>(u64::from(part)), "\""),
            None => put!(out; "null"),
        }
    }
}

/// Appends what a finding measured, as an object whose keys depend on the rule.
pub fn facts(out: &mut Vec<u8>, finding: &Finding) {
    match (&finding.facts, finding.measured()) {
        (Facts::Unmet(deviation), _) => unmet(out, deviation),
        (Facts::Repeated { count }, _) => put!(out; "{\"repeated\":", *count, "}"),
        (_, Some(measured)) => told(out, &measured),
        (_, None) => put!(out; "{}"),
    }
}

fn told(out: &mut Vec<u8>, measured: &Measured) {
    let mut before = "{\"";
    for (name, value) in measured.variant.constants {
        put!(out; before, *name, "\":", *value);
        before = ",\"";
    }
    for (name, quantity) in measured.facts().filter(|(_, quantity)| *quantity != Quantity::Nothing) {
        put!(out; before);
        before = ",\"";
        pair(out, name, quantity);
    }
    put!(out; if before == "{\"" { "{}" } else { "}" });
}

/// Appends the object of an expectation: `expectation` is its file and line; the rest as above, mostly `expected` and
/// `found`. Bytes are a hex string.
fn unmet(out: &mut Vec<u8>, unmet: &Unmet) {
    put!(out; "{\"expectation\":");
    escape::json(out, unmet.expectation.as_bytes());
    for (name, value) in unmet.variant.constants.iter().filter(|_| unmet.repeated == 0) {
        put!(out; ",\"", *name, "\":", *value);
    }
    for (name, said) in unmet.facts() {
        put!(out; ",\"");
        if let Said::Quantity(quantity) = said {
            pair(out, name, *quantity);
            continue;
        }
        put!(out; name, "\":");
        match said {
            Said::Quantity(_) => {}
            Said::Real(number) if number.is_finite() => out.extend_from_slice(number.to_string().as_bytes()),
            Said::Real(_) => put!(out; "null"),
            Said::Bool(on) => put!(out; truth(*on)),
            Said::Text(text) => escape::json(out, text.as_bytes()),
            Said::Bytes(bytes) => put!(out; "\"", Joined(bytes), "\""),
            Said::Word(word) => put!(out; "\"", *word, "\""),
            Said::Problems(named, _) => problems(out, named),
        }
    }
    if unmet.repeated > 0 {
        put!(out; ",\"repeated\":", unmet.repeated);
    }
    put!(out; "}");
}

/// Appends a list of what went wrong: `{"incident","node","frame"}` each, the node only where no other key says it.
fn problems(out: &mut Vec<u8>, named: &[Problem]) {
    for (place, one) in named.iter().enumerate() {
        put!(out; if place > 0 { ",{" } else { "[{" }, "\"incident\":\"", one.name, "\"");
        if let Some(node) = one.node {
            put!(out; ",\"node\":", node);
        }
        put!(out; ",\"frame\":", one.frame, "}");
    }
    put!(out; if named.is_empty() { "[]" } else { "]" });
}

/// Appends `name":value`.
pub(super) fn pair(out: &mut Vec<u8>, name: &str, quantity: Quantity) {
    put!(out; name);
    if matches!(quantity, Quantity::Ns(_)) {
        put!(out; "_ns");
    }
    put!(out; "\":");
    match quantity {
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
        | Quantity::Emcy(number, _)
        | Quantity::Type(number) => put!(out; "\"", Hex::<4>(u64::from(number)), "\""),
        Quantity::Hex8(number) | Quantity::Abort(number) => put!(out; "\"", Hex::<8>(u64::from(number)), "\""),
        Quantity::Object(mux) => {
            put!(out; "\"", Hex::<4>(u64::from(mux.index)), ":", Hex::<2>(u64::from(mux.sub)), "\"");
        }
        Quantity::Id(id) if id.is_extended() => put!(out; "\"", Hex::<8>(u64::from(id.raw())), "\""),
        Quantity::Id(id) => put!(out; "\"", Hex::<3>(u64::from(id.raw())), "\""),
        Quantity::Pdo(transmit, number) => put!(out; if transmit { "\"TPDO" } else { "\"RPDO" }, number, "\""),
        Quantity::Side(side) => put!(out; "\"", sdo::side(side), "\""),
        Quantity::Size(bytes) => put!(out; bytes),
        Quantity::Crc(matches) => put!(out; match matches {
            CrcMatch::Nothing => "null",
            CrcMatch::WithPadding => "\"with_padding\"",
            CrcMatch::InitialFfff => "\"initial_ffff\"",
            CrcMatch::Reflected => "\"reflected\"",
        }),
        Quantity::Mode(mode) => put!(out; i64::from(mode)),
        Quantity::Drive(word) => put!(out; "\"", drive::State::of(word).map_or("", drive::State::name), "\""),
    }
}

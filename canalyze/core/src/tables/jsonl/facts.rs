//! The measured facts of a finding, as an object: the keys are the names in the rule's sentence.
//!
//! Times have `_ns` appended to their key, hexadecimal quantities are strings, a PDO is `TPDO1`.

use super::obj::{Given, Obj, Values, WriteJson, array, hex2, hex4, hex8, members, obj, pdo, raw, text};
use super::sdo;
use crate::rules::finding::{CrcMatch, Facts, Finding, NamedProblem, Quantity, Said};
use crate::words::digits::{Joined, Put, put};
use crate::world::drive;
use crate::world::event::{Note, Scanned};

/// Appends `,"facts":{...}` to a note; most have none.
pub(super) fn note(out: &mut Vec<u8>, note: Note) {
    let facts = raw(|out| match note {
        Note::RequestNotCaptured | Note::LostByReset => obj! {}.write_json(out),
        Note::LssSelected { address } => address_of(address.map(Some)).write_json(out),
        Note::Fastscan(Scanned { address, frames, duration_ns, .. }) => obj! {
            _: address_of(address).inline(), "requests": frames, "duration_ns": duration_ns,
        }
        .write_json(out),
        Note::BitTimingActivated { delay, rate } => obj! { "delay_ms": delay, "kbit_s": rate }.write_json(out),
        Note::NodeIdChanged { from, to } => obj! { "from": from, "to": to }.write_json(out),
    });
    members([("facts", facts)]).write_json(out);
}

/// Returns an LSS address.
fn address_of([vendor, product, revision, serial]: [Option<u32>; 4]) -> Obj<impl Values> {
    obj! {
        "vendor": vendor.map(hex8), "product": product.map(hex8), "revision": revision.map(hex8), "serial": serial.map(hex8),
    }
}

/// Appends the measured facts of a finding, as an object whose keys depend on the rule. That of an expectation begins with
/// the file and line of the expectation.
pub fn facts(out: &mut Vec<u8>, finding: &Finding) {
    match (&finding.facts, finding.measured()) {
        (Facts::Unmet(unmet), _) => obj! {
            "expectation": &*unmet.expectation,
            _: constants(if unmet.repeated == 0 { unmet.variant.constants } else { &[] }),
            _: members(unmet.facts().map(|(name, said)| (key(name, quantity_of(said)), self::said(said)))),
            "repeated": Given(Some(unmet.repeated).filter(|times| *times > 0)),
        }
        .write_json(out),
        (Facts::Repeated { count }, _) => obj! { "repeated": *count }.write_json(out),
        (_, Some(measured)) => obj! {
            _: constants(measured.variant.constants), _: quantities(measured.facts()),
        }
        .write_json(out),
        (_, None) => obj! {}.write_json(out),
    }
}

fn constants(constants: &'static [(&'static str, &'static str)]) -> impl WriteJson {
    members(constants.iter().map(|(name, value)| (*name, raw(|out| put!(out; *value)))))
}

/// Returns quantities with their keys, for the key `_`.
pub(super) fn quantities<'a>(facts: impl IntoIterator<Item = (&'a str, Quantity)>) -> impl WriteJson {
    let facts = facts.into_iter().filter(|(_, one)| *one != Quantity::Nothing);
    members(facts.map(|(name, one)| (key(name, Some(one)), quantity(one))))
}

/// Returns the key of a fact, with its unit.
fn key(name: &str, quantity: Option<Quantity>) -> impl Put {
    let unit = if matches!(quantity, Some(Quantity::Ns(_))) { "_ns" } else { "" };
    move |out: &mut Vec<u8>| put!(out; name, unit)
}

fn quantity_of(said: &Said) -> Option<Quantity> {
    if let Said::Quantity(quantity) = said { Some(*quantity) } else { None }
}

/// Returns a fact of an expectation, mostly `expected` or `found`.
fn said(said: &Said) -> impl WriteJson {
    raw(move |out| match said {
        Said::Quantity(one) => quantity(*one).write_json(out),
        Said::Real(number) => number.write_json(out),
        Said::Bool(on) => on.write_json(out),
        Said::Text(text) => (**text).write_json(out),
        Said::Bytes(bytes) => Joined(bytes).write_json(out),
        Said::Word(word) => word.write_json(out),
        Said::Problems(named, _) => array(named.iter().map(problem)).write_json(out),
    })
}

fn problem(one: &NamedProblem) -> impl WriteJson {
    // The node only where no other key has it.
    obj! { "problem": one.name, "node": Given(one.node), "frame": one.frame }
}

fn quantity(quantity: Quantity) -> impl WriteJson {
    raw(move |out| match quantity {
        Quantity::Nothing => {}
        Quantity::Count(number) => number.write_json(out),
        Quantity::Signed(number) => number.write_json(out),
        Quantity::Ns(ns) => ns.write_json(out),
        Quantity::Hex2(number)
        | Quantity::State(number)
        | Quantity::Command(number)
        | Quantity::Lss(number)
        | Quantity::LssError(_, number) => hex2(number).write_json(out),
        Quantity::Hex4(number)
        | Quantity::Statusword(number)
        | Quantity::Controlword(number)
        | Quantity::Emcy(number, _)
        | Quantity::Type(number) => hex4(number).write_json(out),
        Quantity::Hex8(number) => hex8(number).write_json(out),
        Quantity::Abort(code) => code.write_json(out),
        Quantity::Object(mux) => text(|out| put!(out; hex4(mux.index), ":", hex2(mux.sub))).write_json(out),
        Quantity::Id(id) => id.write_json(out),
        Quantity::Pdo(transmit, number) => pdo(transmit, number).write_json(out),
        Quantity::Side(side) => sdo::side(side).write_json(out),
        Quantity::Size(bytes) => bytes.write_json(out),
        Quantity::Crc(matches) => match matches {
            CrcMatch::Nothing => None,
            CrcMatch::WithPadding => Some("with_padding"),
            CrcMatch::InitialFfff => Some("initial_ffff"),
            CrcMatch::Reflected => Some("reflected"),
        }
        .write_json(out),
        Quantity::Mode(mode) => i64::from(mode).write_json(out),
        Quantity::Drive(word) => drive::DriveState::of(word).map_or("", drive::DriveState::name).write_json(out),
    })
}

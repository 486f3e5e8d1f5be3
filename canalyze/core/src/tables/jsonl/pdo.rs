//! The `pdo` object of a PDO frame with data.
//!
//! Keys: `direction` transmit/receive, `number`, `remote` false, `communication_parameter` and `mapping_parameter`
//! hex, `pdo` (`TPDO1`), `state` NMT state of the node as hex or null, `provenance` of the mapping (`observed`,
//! `option`, `dcf`, `eds`, `unconfirmed`) or null, `mapped_at` frame that completed an observed mapping or null, `unmapped`
//! (`unknown`, `contradicted` by the frames, `disabled`, `multiplex`) or null, `consumer` (`{"node","number"}` of the RPDO whose mapping was used)
//! or null, `sync` (`{"cycle","delay_us"}`, the latter with three decimals or null) or null, and `signals`: a list of
//! `{"index","sub","name","bit","bits","raw","value","unit","text","provenance"}`. `raw` is the unsigned number in the
//! payload; `value` has sign, type and factor applied; both are strings beyond 2^53 and hex strings for bytes, null
//! where the payload does not reach. Dummy entries are not listed.

use super::object::Object;
use crate::bytes::frame::Frame;
use crate::tables::number::{self, Shape};
use crate::wire::pdo;
use crate::wire::pdo::mapping::Mapping;
use crate::words::digits::{Hex, Padded, put};
use crate::words::{Lang, escape, signal};
use crate::world::configuration::Provenance;
use crate::world::event::{Placement, ProcessData, Signals, Unmapped};

/// Appends the object.
pub(super) fn fields(out: &mut Vec<u8>, lang: Lang, data: &ProcessData, frame: &Frame) {
    let mut object = Object::open(out);
    object.word("direction", if data.transmit { "transmit" } else { "receive" });
    object.number("number", data.number);
    object.flag("remote", false);
    object.hex::<4>("communication_parameter", u64::from(pdo::communication_parameter(data.transmit, data.number)));
    object.hex::<4>("mapping_parameter", u64::from(pdo::mapping_parameter(data.transmit, data.number)));
    put!(object.key("pdo"); if data.transmit { "\"TPDO" } else { "\"RPDO" }, data.number, "\"");
    object.maybe_hex("state", data.state.is_some(), data.state.unwrap_or(0));
    let (mapping, from, consumer) = match &data.content {
        Signals::Mapped(mapping, from) => (Some(mapping), Some(*from), None),
        Signals::ByConsumer(mapping, from, node, number) => (Some(mapping), Some(*from), Some((*node, *number))),
        Signals::None(_) => (None, None, None),
    };
    let unconfirmed = matches!(data.content, Signals::None(Unmapped::Unconfirmed)).then_some("unconfirmed");
    object.optional("provenance", from.map(Provenance::name).or(unconfirmed));
    object.maybe("mapped_at", from.and_then(Provenance::frame));
    object.optional(
        "unmapped",
        match &data.content {
            Signals::None(Unmapped::Unknown | Unmapped::Unconfirmed) => Some("unknown"),
            Signals::None(Unmapped::Contradicted) => Some("contradicted"),
            Signals::None(Unmapped::Disabled) => Some("disabled"),
            Signals::None(Unmapped::Multiplex) => Some("multiplex"),
            Signals::Mapped(..) | Signals::ByConsumer(..) => None,
        },
    );
    match consumer {
        Some((node, number)) => put!(object.key("consumer"); "{\"node\":", node, ",\"number\":", number, "}"),
        None => put!(object.key("consumer"); "null"),
    }
    match &data.sync {
        Some(sync) => placement(object.key("sync"), sync),
        None => put!(object.key("sync"); "null"),
    }
    let list = object.key("signals");
    list.push(b'[');
    if let (Some(mapping), Some(from)) = (mapping, from) {
        signals(list, lang, mapping, from, frame.payload());
    }
    list.push(b']');
    object.close();
}

fn placement(out: &mut Vec<u8>, sync: &Placement) {
    put!(out; "{\"cycle\":", sync.cycle, ",\"delay_us\":");
    match sync.delay_ns {
        Some(ns) => {
            put!(out; if ns < 0 { "-" } else { "" }, ns.unsigned_abs() / 1000, ".");
            put!(out; Padded::<3>(ns.unsigned_abs() % 1000), "}");
        }
        None => put!(out; "null}"),
    }
}

fn signals(out: &mut Vec<u8>, lang: Lang, mapping: &Mapping, from: Provenance, payload: &[u8]) {
    let mut before = "{\"index\":\"";
    for mapped in mapping.entries.iter().filter(|mapped| !mapped.dummy) {
        put!(out; before, Hex::<4>(u64::from(mapped.index)), "\",\"sub\":", mapped.sub, ",\"name\":");
        before = ",{\"index\":\"";
        super::quoted(out, |text| signal::name(text, super::NAMES, mapped));
        put!(out; ",\"bit\":", mapped.offset, ",\"bits\":", mapped.bits, ",\"raw\":");
        marked(out, |out| number::raw(out, mapping, mapped, payload));
        put!(out; ",\"value\":");
        marked(out, |out| number::value(out, mapping, mapped, payload));
        put!(out; ",\"unit\":");
        match mapped.unit.as_deref() {
            Some(unit) => escape::json(out, unit.as_bytes()),
            None => put!(out; "null"),
        }
        put!(out; ",\"text\":");
        match mapping.raw(mapped, payload) {
            Some(raw) => super::quoted(out, |text| signal::value(text, lang, mapped, raw)),
            None => put!(out; "null"),
        }
        put!(out; ",\"provenance\":\"", from.name(), "\"}");
    }
}

/// A value as JSON has it: bare where a double holds it, else in quotes.
pub(in crate::tables) fn marked(out: &mut Vec<u8>, write: impl FnOnce(&mut Vec<u8>) -> Shape) {
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

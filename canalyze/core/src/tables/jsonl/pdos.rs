//! PDOs with their mappings, as JSON lines of kind `pdo`, by bus and identifier.
//!
//! Keys: `bus` (null where it has no name), `id` hex and `ext`, `node`, `transmit`, `pdo` (`TPDO1`), `frames`; `content`:
//! `mapped`, `source` and `destination` (multiplex PDOs), `disabled`, `contradicted` or `unknown`; `from` whence that is
//! known, or null; `changes`: how often it had another mapping; `further`: how often a multiplex PDO carried an object for
//! which there was no room; `type`, `inhibit` (100 us), `event_timer` (ms), `sync_ns`,
//! each null where it is not known; `bits`: of the payload; `signals`: of
//! `{"node","address","index","sub","name","offset","bits","number","unit","factor","words"}`. `node` is that whose object
//! it is, null where any may be. `address` is that of a multiplex PDO, its first four bytes as one little-endian number,
//! else null. `number` is `unsigned`, `signed`, `real`, or `bytes` for what is none. `words` are of
//! `{"value","text"}`, in English. Dummy entries are not listed. A last line of kind `pdos` has `further`: how often there
//! was no room for a PDO; it is not there where there was. Must not: decide anything.

use std::sync::Arc;

use super::object::Object;
use super::{NAMES, name_or_null, quoted};
use crate::bytes::frame::Buses;
use crate::views::inventory::pdos::{Address, KnownPdo, PdoInventory, PdoOwner};
use crate::wire::pdo::mapping::{Mapped, Mapping, Number, number};
use crate::words::digits::put;
use crate::words::{escape, signal, terms};
use crate::world::drive;
use crate::world::node::Content;

/// Bit of the first byte of a multiplex PDO by which it has a destination.
const DESTINATION: u32 = 1 << 7;

/// Appends all of them.
pub fn write(out: &mut Vec<u8>, buses: &Buses, all: &PdoInventory) {
    for (whose, pdo) in &all.pdos {
        line(out, buses.name(whose.bus), *whose, pdo);
    }
    if all.further > 0 {
        put!(out; "{\"kind\":\"pdos\",\"further\":", all.further, "}\n");
    }
}

fn line(out: &mut Vec<u8>, bus: &[u8], whose: PdoOwner, pdo: &KnownPdo) {
    let mut object = Object::open(out);
    object.word("kind", "pdo");
    name_or_null(object.key("bus"), bus);
    match whose.id.is_extended() {
        true => object.hex::<8>("id", u64::from(whose.id.raw())),
        false => object.hex::<3>("id", u64::from(whose.id.raw())),
    }
    object.flag("ext", whose.id.is_extended());
    object.number("node", whose.node);
    object.flag("transmit", whose.transmit);
    put!(object.key("pdo"); if whose.transmit { "\"TPDO" } else { "\"RPDO" }, whose.number, "\"");
    object.number("frames", pdo.frames);
    let (content, from) = match &pdo.content {
        Content::Mapped(_, from) => ("mapped", Some(*from)),
        Content::Multiplex { destination, from } => (if *destination { "destination" } else { "source" }, Some(*from)),
        Content::Disabled(from) => ("disabled", Some(*from)),
        Content::Unknown => (if pdo.contradicted { "contradicted" } else { "unknown" }, None),
    };
    object.word("content", content);
    object.optional("from", from.map(|from| from.name()));
    object.number("changes", pdo.changes);
    object.number("further", pdo.further);
    object.maybe("type", pdo.timing.transmission);
    object.maybe("inhibit", pdo.timing.inhibit);
    object.maybe("event_timer", pdo.timing.event_timer);
    object.maybe("sync_ns", pdo.timing.sync_ns.map(i64::unsigned_abs));
    let none = Arc::default();
    let mapping: &Arc<Mapping> = if let Content::Mapped(mapping, _) = &pdo.content { mapping } else { &none };
    object.number("bits", mapping.bits);
    let written = signal::written(mapping, NAMES).iter().map(|how| how.name.clone());
    let mapped = mapping.entries.iter().zip(written).filter(|(mapped, _)| !mapped.dummy);
    let mapped = mapped.map(|(mapped, name)| (None, mapped, name));
    let addressed = pdo.objects.iter().map(|(address, mapped)| {
        let mut name = Vec::new();
        signal::name(&mut name, NAMES, mapped);
        (Some(*address), mapped, name)
    });
    object.list("signals", mapped.chain(addressed), |out, (address, mapped, name)| {
        self::signal(out, whose.node, address, mapped, &name);
    });
    object.close();
    out.push(b'\n');
}

fn signal(out: &mut Vec<u8>, node: u8, address: Option<Address>, mapped: &Mapped, name: &[u8]) {
    let mut object = Object::open(out);
    object.maybe("node", Some(address.map_or(node, |address| address.node)).filter(|node| *node != 0));
    object.maybe("address", address.map(number_of));
    object.hex::<4>("index", u64::from(mapped.index));
    object.number("sub", mapped.sub);
    escape::json(object.key("name"), name);
    object.number("offset", mapped.offset);
    object.number("bits", mapped.bits);
    object.word("number", kind(mapped));
    name_or_null(object.key("unit"), mapped.unit.as_deref().unwrap_or("").as_bytes());
    quoted(object.key("factor"), |text| put!(text; mapped.factor.to_string().as_str()));
    object.list("words", words(mapped), |out, (value, word)| {
        put!(out; "{\"value\":", i64::from(value), ",\"text\":");
        escape::json(out, word.as_bytes());
        put!(out; "}");
    });
    object.close();
}

/// The first four bytes of a multiplex PDO with this address.
fn number_of(Address { destination, node, object }: Address) -> u32 {
    let first = u32::from(node) | if destination { DESTINATION } else { 0 };
    first | u32::from(object.index) << 8 | u32::from(object.sub) << 24
}

fn kind(mapped: &Mapped) -> &'static str {
    match number(mapped.data_type, 0, mapped.bits) {
        _ if mapped.bits > 64 => "bytes",
        Number::Bytes => "bytes",
        Number::Unsigned(_) | Number::Bool(_) => "unsigned",
        Number::Signed(_) => "signed",
        Number::Real32(_) | Number::Real64(_) => "real",
    }
}

/// What the values of a mode of operation are called.
fn words(mapped: &Mapped) -> impl Iterator<Item = (i8, &'static str)> {
    let object = drive::DriveObject::at(mapped.index).filter(|_| signal::is_drives(mapped));
    let modes =
        matches!(object, Some(drive::DriveObject::ModesOfOperation | drive::DriveObject::ModesOfOperationDisplay));
    (i8::MIN..=i8::MAX)
        .filter(move |mode| modes && terms::drive::abbreviation(*mode).is_some())
        .map(|mode| (mode, terms::drive::mode(NAMES, mode)))
}

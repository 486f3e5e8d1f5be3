//! The page of one node: its identity, by the objects that were read of it, and its PDOs.
//!
//! | of | keys |
//! |---|---|
//! | the object | `identity pdos` |
//! | `identity` | `index sub name text`, in the order of the objects |
//! | `pdos` | `pdo id valid type from objects`: `from` is the source of the mapping, null if it is unknown |
//! | `objects` | `index sub name bits` |
//!
//! Nothing is judged here, and values of other objects are not kept.

use std::collections::BTreeMap;

use crate::bytes::frame::BusId;
use crate::sdo::transfer::{Direction, Status, Transfer};
use crate::sdo::wire::Mux;
use crate::tables::jsonl::{self, Setting};
use crate::words::digits::{Hex, put};
use crate::words::profiles::Profile;
use crate::words::{escape, transferred};
use crate::world::bus::Bus;
use crate::world::dictionary::Described;
use crate::world::node::{Content, Node, Pdo};

/// Maximum number of nodes whose identity is kept.
const NODES: usize = 1024;

/// The identity of nodes, by the objects that were read of them.
#[derive(Debug, Default)]
pub(super) struct Identity {
    /// In JSON, by node and object.
    read: BTreeMap<(BusId, u8), BTreeMap<Mux, Vec<u8>>>,
}

impl Identity {
    /// Takes a transfer that has ended.
    pub(super) fn take(&mut self, setting: Setting<'_>, transfer: &Transfer) {
        let ok = transfer.direction == Direction::Upload && transfer.outcome.status == Status::Ok;
        let Some(mux) = transfer.mux.filter(|mux| ok && is_identity(*mux)) else { return };
        let key = (transfer.bus, transfer.node);
        if self.read.len() >= NODES && !self.read.contains_key(&key) {
            return;
        }
        let mut out = b"{".to_vec();
        let name = transfer.described.object.as_deref().map(|object| object.name.as_ref());
        object(&mut out, setting, transfer.described.profile, mux, name);
        put!(&mut out; ",\"text\":");
        jsonl::quoted(&mut out, |text| transferred::transferred(text, setting.lang, transfer));
        put!(&mut out; "}");
        self.read.entry(key).or_default().insert(mux, out);
    }

    /// Writes the object.
    pub(super) fn page(&self, setting: Setting<'_>, bus: Option<&Bus>, (id, node): (BusId, u8)) -> Vec<u8> {
        let mut out = b"{\"identity\":[".to_vec();
        for (place, one) in self.read.get(&(id, node)).into_iter().flat_map(BTreeMap::values).enumerate() {
            put!(&mut out; if place > 0 { "," } else { "" });
            out.extend_from_slice(one);
        }
        put!(&mut out; "],\"pdos\":[");
        let node = bus.and_then(|bus| bus.node(node));
        let profile = node.map_or(Profile::UNKNOWN, Node::profile);
        let pdos = node.map(|node| node.pdos()).unwrap_or_default();
        for (place, pdo) in pdos.iter().enumerate() {
            put!(&mut out; if place > 0 { "," } else { "" });
            self::pdo(&mut out, setting, profile, pdo);
        }
        put!(&mut out; "]}");
        out
    }
}

/// Returns true if an object identifies a device: type, names and versions, identity.
fn is_identity(mux: Mux) -> bool {
    matches!((mux.index, mux.sub), (0x1000 | 0x1008..=0x100A, 0) | (0x1018, 1..=4))
}

fn pdo(out: &mut Vec<u8>, setting: Setting<'_>, profile: Profile, pdo: &Pdo) {
    let (cob, _) = pdo.cob;
    put!(out; "{\"pdo\":\"", if pdo.transmit { "TPDO" } else { "RPDO" }, pdo.number, "\",\"id\":\"");
    match cob.id.is_extended() {
        true => put!(out; Hex::<8>(u64::from(cob.id.raw()))),
        false => put!(out; Hex::<3>(u64::from(cob.id.raw()))),
    }
    put!(out; "\",\"valid\":", jsonl::truth(cob.valid), ",\"type\":");
    jsonl::number_or_null(out, pdo.transmission.map(|(kind, _)| u64::from(kind)));
    let (mapping, from) = match &pdo.content {
        Content::Mapped(mapping, from) => (Some(mapping), Some(*from)),
        Content::Multiplex { from, .. } | Content::Disabled(from) => (None, Some(*from)),
        Content::Unknown => (None, None),
    };
    put!(out; ",\"from\":");
    jsonl::name_or_null(out, from.map_or("", |from| from.name()).as_bytes());
    put!(out; ",\"objects\":[");
    for (place, one) in mapping.into_iter().flat_map(|mapping| &mapping.entries).enumerate() {
        put!(out; if place > 0 { ",{" } else { "{" });
        object(out, setting, profile, Mux { index: one.index, sub: one.sub }, one.name.as_deref());
        put!(out; ",\"bits\":", one.bits, "}");
    }
    put!(out; "]}");
}

/// Appends an object with its name: the device's own, else the standard's.
fn object(out: &mut Vec<u8>, setting: Setting<'_>, profile: Profile, mux: Mux, name: Option<&str>) {
    let Some(name) = name else {
        let mut standard = Vec::new();
        jsonl::sdo::object(&mut standard, setting.lang, Some(mux), &Described { object: None, profile });
        return out.extend_from_slice(standard.get(1..).unwrap_or(&[]));
    };
    put!(out; "\"index\":\"", Hex::<4>(u64::from(mux.index)), "\",\"sub\":", mux.sub, ",\"name\":");
    escape::json(out, name.as_bytes());
}

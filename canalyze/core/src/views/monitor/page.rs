//! The page of one node: its identity, by the objects that were read of it, and its PDOs.
//!
//! Nothing is judged here, and values of other objects are not kept.

use std::collections::BTreeMap;

use crate::bytes::frame::BusId;
use crate::sdo::transfer::{Direction, Status, Transfer};
use crate::sdo::wire::Mux;
use crate::tables::jsonl::obj::{self, WriteJson, array, hex4, obj, raw, text, written};
use crate::tables::jsonl::{Setting, sdo};
use crate::words::profiles::Profile;
use crate::words::transferred;
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
        let name = transfer.described.object.as_deref().map(|object| object.name.as_ref());
        let mut out = Vec::new();
        obj! {
            _: raw(|out| object(out, setting, transfer.described.profile, mux, name)),
            "text": text(|out| transferred::transferred(out, setting.lang, transfer)),
        }
        .write_json(&mut out);
        self.read.entry(key).or_default().insert(mux, out);
    }

    /// Writes the object.
    pub(super) fn page(&self, setting: Setting<'_>, bus: Option<&Bus>, (id, node): (BusId, u8)) -> Vec<u8> {
        let read = self.read.get(&(id, node)).into_iter().flat_map(BTreeMap::values);
        let node = bus.and_then(|bus| bus.node(node));
        let profile = node.map_or(Profile::UNKNOWN, Node::profile);
        let pdos = node.map(|node| node.pdos()).unwrap_or_default();
        let mut out = Vec::new();
        obj! {
            /// In the order of the objects.
            "identity": array(read.map(|one| written(one))),
            "pdos": array(pdos.iter().map(|one| pdo(setting, profile, one))),
        }
        .write_json(&mut out);
        out
    }
}

/// Returns true if an object identifies a device: type, names and versions, identity.
fn is_identity(mux: Mux) -> bool {
    matches!((mux.index, mux.sub), (0x1000 | 0x1008..=0x100A, 0) | (0x1018, 1..=4))
}

fn pdo<'a>(setting: Setting<'a>, profile: Profile, pdo: &'a Pdo) -> impl WriteJson {
    let (cob, _) = pdo.cob;
    let (mapping, from) = match &pdo.content {
        Content::Mapped(mapping, from) => (Some(mapping), Some(*from)),
        Content::Multiplex { from, .. } | Content::Disabled(from) => (None, Some(*from)),
        Content::Unknown => (None, None),
    };
    let objects = mapping.into_iter().flat_map(|mapping| &mapping.entries);
    obj! {
        "pdo": obj::pdo(pdo.transmit, pdo.number),
        "id": cob.id, "valid": cob.valid,
        "type": pdo.transmission.map(|(kind, _)| kind),
        /// The source of the mapping, null where it is not known.
        "from": from.map(|from| from.name()),
        "objects": array(objects.map(move |one| obj! {
            _: raw(move |out| object(out, setting, profile, Mux { index: one.index, sub: one.sub }, one.name.as_deref())),
            "bits": one.bits,
        })),
    }
}

/// Appends the keys of an object with its name: the device's own, else the standard's.
fn object(out: &mut Vec<u8>, setting: Setting<'_>, profile: Profile, mux: Mux, name: Option<&str>) {
    match name {
        Some(name) => obj! { "index": hex4(mux.index), "sub": mux.sub, "name": name }.inline().write_json(out),
        None => sdo::object(out, setting.lang, Some(mux), &Described { profile, ..Described::default() }),
    }
}

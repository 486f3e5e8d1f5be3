//! Compares SDO transfers with the node's EDS or DCF. Without one, only the lengths of CiA 301 data types are judged.
//!
//! Completed transfers are judged before the bus model takes the value; refused ones only for missing objects. The
//! description may be at fault as well as the device: a finding reports that they disagree, not which one is right.

use std::collections::BTreeSet;

use crate::rules::description::{Eds001, Eds002, Eds003, Eds004, Eds005};
use crate::rules::finding::{Quantity, Verdict};
use crate::rules::sdo::{Sdo013, Sdo014};
use crate::sdo::transfer::{Direction, Mode, Transfer};
use crate::sdo::wire::{Mux, Side};
use crate::world::configuration::{Provenance, number};
use crate::world::context::Context;
use crate::world::dictionary::Object;
use crate::world::node::{Node, PerNode};
use crate::world::od::{self, DataType};

/// Maximum number of addresses kept per node (invariant 6).
const KEPT: usize = 4096;
/// First index after the data types, which descriptions seldom list.
const OBJECTS: u16 = 0x1000;
/// Sub-index at which a server may offer the structure of any object.
const STRUCTURE: u8 = 0xFF;

/// The objects that identify a node, and those in which a controller holds what it expects, by the node-ID as sub-index
/// (CiA 302-2).
const EXPECTED: [(u16, u8, u16); 5] =
    [(0x1000, 0, 0x1F84), (0x1018, 1, 0x1F85), (0x1018, 2, 0x1F86), (0x1018, 3, REVISIONS), (0x1018, 4, 0x1F88)];
const REVISIONS: u16 = 0x1F87;

/// Abort codes for a missing object and for a missing sub-index.
const NO_INDEX: u32 = 0x0602_0000;
const NO_SUB: u32 = 0x0609_0011;

/// The addresses of each node that were written or reported.
#[derive(Debug, Default)]
pub struct Descriptions {
    nodes: PerNode<BTreeSet<(u16, u8)>>,
    /// Per node, for downloads and uploads: true if an expedited transfer carried fewer than four bytes.
    short: PerNode<[bool; 2]>,
}

impl Descriptions {
    /// Compares the identity that a node answers with the one that the configuration of its controller expects
    /// (CiA 302-2, boot of an NMT slave).
    pub fn expected(&mut self, nodes: &PerNode<Node>, transfer: &Transfer, mux: Mux, cx: &mut Context<'_>) {
        let answered = transfer.direction == Direction::Upload;
        let Some((_, _, index)) = EXPECTED.iter().find(|(of, sub, _)| answered && (*of, *sub) == (mux.index, mux.sub))
        else {
            return;
        };
        let Some(found) = number(&transfer.data.kept) else { return };
        let expects = |controller: &Node| {
            let (value, from) = controller.value(*index, transfer.node)?;
            let counts = value != 0 && from > Provenance::Eds && controller.id() != transfer.node;
            counts.then_some((controller.id(), value))
        };
        let Some((controller, expected)) = nodes.iter().find_map(|(_, node)| expects(node)) else { return };
        // Of a revision the minor number, in the lower half, may be another one.
        let lower = if *index == REVISIONS { 0xFFFF } else { 0 };
        if (found | lower) != (expected | lower) && self.first(transfer.node, mux) {
            let (found, expected) = (found as u32, expected as u32);
            cx.raise(
                Eds004::Expected { found, expected, controller: controller.into() },
                Some(transfer.node),
                Some(mux),
                None,
            );
        }
    }

    /// Judges a successful transfer before its value is taken.
    pub fn judge(&mut self, node: Option<&Node>, transfer: &Transfer, mux: Mux, cx: &mut Context<'_>) {
        let upload = transfer.direction == Direction::Upload;
        let [downloads, uploads] = self.short.entry(transfer.node);
        let short = if upload { uploads } else { downloads };
        *short |= transfer.mode == Mode::Expedited && transfer.data.size_indicated.is_some_and(|size| size < 4);
        // Many devices and clients send four bytes for every type; only a description contradicts that.
        let habit = !*short && transfer.mode == Mode::Expedited && transfer.data.size == 4;
        let described = node.and_then(|node| Some((node, node.configuration.description()?)));
        let Some((node, description)) = described else {
            if let Some(code) = standard_type(mux).filter(|_| !habit) {
                length(code, transfer, mux, cx);
            }
            return;
        };
        match description.get(mux.index, mux.sub) {
            Some(object) => {
                length(object.data_type, transfer, mux, cx);
                access(object, transfer, mux, cx);
            }
            None if mux.index >= OBJECTS && mux.sub != STRUCTURE && self.first(node.id(), mux) => {
                let what = if description.has(mux.index) { Eds003::SubIndex } else { Eds003::Index };
                cx.raise(what, Some(node.id()), Some(mux), None);
            }
            None => {}
        }
        let configuration = presets(mux);
        if transfer.direction == Direction::Download {
            if configuration {
                self.first(node.id(), mux);
            }
        } else if (configuration || identity(mux))
            && let Some(found) = number(&transfer.data.kept)
            && let Some(preset) = node.configuration.described(node.id(), mux.index, mux.sub)
            && found != preset.value
            // Templates leave the identity 0.
            && (configuration || preset.value != 0)
            && self.first(node.id(), mux)
        {
            let quantity = |value| if word(mux) { Quantity::Hex8(value as u32) } else { Quantity::Count(value) };
            let (found, described) = (quantity(found), quantity(preset.value));
            let what: Verdict = match preset.from {
                _ if !configuration => Eds004::Value { found, described }.into(),
                Provenance::Dcf => Eds002::Value { found, described }.into(),
                _ => Eds001::Value { found, described }.into(),
            };
            cx.raise(what, Some(node.id()), Some(mux), None);
        }
    }

    /// Reports an object that the description contains and the device refuses as missing.
    pub fn refused(&mut self, node: Option<&Node>, transfer: &Transfer, cx: &mut Context<'_>) {
        let abort = transfer.outcome.abort.filter(|abort| abort.by == Side::Server && !transfer.outcome.bad);
        let what = match abort.map(|abort| abort.code.meaning()) {
            Some(NO_INDEX) => Eds005::Index,
            Some(NO_SUB) => Eds005::SubIndex,
            _ => return,
        };
        if let (Some(node), Some(mux)) = (node, transfer.mux)
            && node.configuration.object(mux.index, mux.sub).is_some()
            && self.first(node.id(), mux)
        {
            cx.raise(what, Some(node.id()), Some(mux), None);
        }
    }

    /// Marks an address as settled; returns true if it was not settled before.
    fn first(&mut self, node: u8, mux: Mux) -> bool {
        let settled = self.nodes.entry(node);
        settled.len() < KEPT && settled.insert((mux.index, mux.sub))
    }
}

/// Returns true for PDO communication and mapping objects that descriptions preset.
fn presets(mux: Mux) -> bool {
    match mux.index {
        0x1400..=0x15FF | 0x1800..=0x19FF => matches!(mux.sub, 1..=3 | 5 | 6),
        0x1600..=0x17FF | 0x1A00..=0x1BFF => true,
        _ => false,
    }
}

/// Returns true if a value is a word of fields, not a number such as a count, a time or a type.
fn word(mux: Mux) -> bool {
    match mux.index {
        0x1400..=0x15FF | 0x1800..=0x19FF => mux.sub == 1,
        0x1600..=0x17FF | 0x1A00..=0x1BFF => mux.sub != 0,
        _ => true,
    }
}

/// Returns true for the objects that identify the device: device type, vendor-ID, product code.
fn identity(mux: Mux) -> bool {
    matches!((mux.index, mux.sub), (0x1000, 0) | (0x1018, 1 | 2))
}

/// Returns the data type code of a communication profile object that is the same in every device (CiA 301, 7.5.2).
fn standard_type(mux: Mux) -> Option<u16> {
    let of_every_device = matches!(mux.index, 0x1000..=0x101F | 0x1400..=0x1BFF);
    match od::communication(mux.index, mux.sub).filter(|_| of_every_device)? {
        DataType::Unsigned8 => Some(0x05),
        DataType::Unsigned16 => Some(0x06),
        DataType::Unsigned32 => Some(0x07),
        _ => None,
    }
}

/// Judges the length of a number. An expedited transfer without a size is not judged; strings have any length.
fn length(data_type: u16, transfer: &Transfer, mux: Mux, cx: &mut Context<'_>) {
    let unsized_value = transfer.mode == Mode::Expedited && transfer.data.size_indicated.is_none();
    let size = DataType::from_code(data_type).and_then(DataType::size);
    let Some(size) = size.map(|size| size as u64).filter(|_| !unsized_value) else { return };
    if transfer.data.size != size {
        let upload = transfer.direction == Direction::Upload;
        let (found, r#type, length) = (transfer.data.size, data_type, size);
        let read = Sdo013::Read { found, r#type, length };
        let what = if upload { read } else { Sdo013::Written { found, r#type, length } };
        let cause = if upload { transfer.data.initiated } else { Some(transfer.first) };
        let cause = cause.filter(|cause| cause.no != cx.at.no);
        cx.raise(what, Some(transfer.node), Some(mux), cause);
    }
}

fn access(object: &Object, transfer: &Transfer, mux: Mux, cx: &mut Context<'_>) {
    let upload = transfer.direction == Direction::Upload;
    let allowed = if upload { object.access.is_readable() } else { object.access.is_writable() };
    if !allowed {
        let cause = (transfer.first.no != cx.at.no).then_some(transfer.first);
        let what = if upload { Sdo014::Read } else { Sdo014::Written };
        cx.raise(what, Some(transfer.node), Some(mux), cause);
    }
}

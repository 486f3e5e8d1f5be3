//! States of axes (CiA 402) by their statuswords: in TPDOs of any mapping, and in uploads.
//!
//! Each statusword is published with the source of its meaning. Views choose by it; checks use sure mappings only.

use std::sync::Arc;

use super::Bus;
use crate::bytes::frame::Frame;
use crate::sdo::transfer::{Direction, Status, Transfer};
use crate::sdo::wire::Mux;
use crate::wire::pdo::mapping::Mapping;
use crate::world::change::{DriveEvidence, Publisher};
use crate::world::configuration::Provenance;
use crate::world::context::Context;
use crate::world::drive::DriveState;
use crate::world::event::{Event, Signals, What};
use crate::world::node::Node;

/// Returns the mapping of a TPDO if it has a statusword.
pub(super) fn reporting(transmit: bool, content: &Signals) -> Option<(Arc<Mapping>, Provenance)> {
    match content {
        Signals::Mapped(mapping, from) if transmit && !mapping.statuswords.is_empty() => {
            Some((Arc::clone(mapping), *from))
        }
        _ => None,
    }
}

/// Publishes the states that a TPDO shows.
pub(super) fn reported(
    publisher: &mut Publisher,
    node: u8,
    (mapping, from): &(Arc<Mapping>, Provenance),
    frame: &Frame,
    cx: &mut Context<'_>,
) {
    for place in &mapping.statuswords {
        let Some(mapped) = mapping.entries.get(usize::from(*place)) else { continue };
        let Some(word) = mapping.raw(mapped, frame.payload()) else { continue };
        let by = DriveEvidence::Pdo(*from);
        if let Some(change) = publisher.statusword(node, mapped.index, word as u16, cx.at, by) {
            cx.push(None, Some(node), What::Change(change));
        }
    }
}

impl Bus {
    /// Returns the last reported state of an axis of a drive; the number of the axis is from 0.
    pub fn axis_state(&self, node: u8, axis: u8) -> Option<DriveState> {
        self.drive_states(node).find(|(number, _)| *number == usize::from(axis)).map(|(_, state)| state)
    }

    /// Publishes the state that an upload shows, at its last frame.
    pub(super) fn uploaded(&mut self, transfer: &Transfer, cx: &mut Context<'_>) {
        let whole = transfer.outcome.status == Status::Ok && !transfer.outcome.bad && !transfer.data.hole;
        let (Some(Mux { index: index @ 0x6000.., sub: 0 }), &[low, high], Direction::Upload, true) =
            (transfer.mux, transfer.data.kept.as_slice(), transfer.direction, whole)
        else {
            return;
        };
        let (node, at) = (transfer.node, transfer.last);
        let is_statusword = |known: &Node| known.mapped(index, 0, 16, 0).is_statusword();
        if !self.nodes.get(node).map_or_else(|| is_statusword(&Node::new(node)), is_statusword) {
            return;
        }
        let word = u16::from_le_bytes([low, high]);
        if let Some(change) = self.publisher.statusword(node, index, word, at, DriveEvidence::Sdo) {
            let what = What::Change(change);
            cx.events.push(Event { at, about: None, bus: cx.bus, node: Some(node), transfer: None, what });
        }
    }
}

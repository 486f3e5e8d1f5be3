//! States of axes (CiA 402) by their statuswords: in TPDOs of any mapping, and in uploads.
//!
//! Each statusword is published with the source of its meaning. Views choose by it; checks use sure mappings only.

use super::Bus;
use crate::bytes::frame::Frame;
use crate::sdo::transfer::{Direction, Status, Transfer};
use crate::sdo::wire::Mux;
use crate::world::change::{DriveEvidence, Publisher};
use crate::world::context::Context;
use crate::world::drive::DriveState;
use crate::world::event::{Event, ProcessData, Signals, What};
use crate::world::node::Node;

/// Publishes the states that a PDO shows, whose event is at a place.
#[inline]
pub(super) fn reported(publisher: &mut Publisher, place: usize, frame: &Frame, cx: &mut Context<'_>) {
    let mut nth = 0;
    while let Some(What::Pdo(ProcessData { transmit: true, node, content: Signals::Mapped(mapping, from), .. })) =
        cx.events.get(place).map(|event| &event.what)
        && let Some(entry) = mapping.statuswords.get(nth)
    {
        nth += 1;
        let (node, by) = (*node, DriveEvidence::Pdo(*from));
        let mapped = mapping.entries.get(*entry);
        let word = mapped.and_then(|mapped| Some((mapped.index, mapping.raw(mapped, frame.payload())? as u16)));
        let change = word.and_then(|(index, word)| publisher.statusword(node, index, word, cx.at, by));
        let change = change.filter(|change| !cx.news_only || change.is_news());
        change.into_iter().for_each(|change| cx.push(None, Some(node), What::Change(change)));
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
        let (node, at, word) = (transfer.node, transfer.last, u16::from_le_bytes([low, high]));
        let is_statusword = |known: &Node| known.mapped(index, 0, 16, 0).is_statusword();
        if !self.nodes.get(node).map_or_else(|| is_statusword(&Node::new(node)), is_statusword) {
            return;
        }
        if let Some(change) = self.publisher.statusword(node, index, word, at, DriveEvidence::Sdo) {
            let what = What::Change(change);
            cx.events.push(Event { at, about: None, bus: cx.bus, node: Some(node), transfer: None, what });
        }
    }
}

//! Mappings and COB-IDs of writes without a response in the capture: the server's direction is not recorded, or the
//! response was lost.
//!
//! PDOs are decoded by them while the frames agree; a later response, or a frame that disagrees, ends that. Checks
//! never use them.

use super::Bus;
use super::drives::reported;
use super::learning::known;
use crate::bytes::frame::Frame;
use crate::bytes::ns::Ns;
use crate::checks::PdoName;
use crate::evidence::When;
use crate::evidence::duplicates::Sighting;
use crate::sdo::limits::UNANSWERED_NS;
use crate::sdo::wire::Mux;
use crate::wire::cob_id::Role;
use crate::wire::pdo;
use crate::world::configuration;
use crate::world::context::Context;
use crate::world::event::{ProcessData, Signals, What};
use crate::world::node::Pdo;

impl Bus {
    /// Takes a PDO whose identifier comes only from an unanswered write: it is decoded and not checked.
    #[cold]
    pub(super) fn unconfirmed(&mut self, name: PdoName, content: Signals, frame: &Frame, cx: &mut Context<'_>) {
        let PdoName { transmit, number, node } = name;
        let is_off = self.nodes.get(node).and_then(|known| known.pdo(transmit, number)).is_some_and(Pdo::is_off);
        let state = self.checks.nodes.state(node);
        let data = ProcessData { transmit, number, node, content, state, sync: None, is_off };
        let own = cx.events.len();
        cx.push(None, Some(node), What::Pdo(data));
        if cx.sighting == Sighting::Duplicate {
            return;
        }
        self.checks.due(frame, cx);
        reported(&mut self.publisher, own, frame, cx);
        if !transmit {
            self.checks.drives.blind(node, cx);
        }
        let asked = self.nodes.get(node).and_then(|node| node.unconfirmed_pdo(transmit, number));
        if asked.is_some_and(|asked| asked.is_refuted_by(frame.len)) {
            self.refute(name, false, true);
        }
    }

    /// Drops unanswered writes to a PDO that a frame refutes: it is sent on its old identifier, or has another length.
    #[cold]
    pub(super) fn refute(&mut self, name: PdoName, cob: bool, mapping: bool) {
        let index = pdo::communication_parameter(name.transmit, name.number);
        if cob {
            self.withdraw(name.node, index, Some(1));
        }
        if mapping {
            self.withdraw(name.node, index + 0x200, None);
        }
    }

    /// Takes a requested write. `unanswered`: the capture lacks the server's direction.
    pub(super) fn request(&mut self, node: u8, mux: Mux, bytes: &[u8], unanswered: bool, cx: &Context<'_>) {
        if !configuration::concerns(mux.index) {
            return;
        }
        let before = known(&mut self.nodes, node).configuration.request(mux, bytes, cx.at.no);
        if before {
            self.asked_otherwise(node);
        }
        if unanswered {
            self.unanswered(node, mux);
        } else {
            self.open_writes.insert(node, (mux, cx.when));
            self.writes_since_ns = self.writes_since_ns.min(cx.when.at.t_ns.unwrap_or(Ns::MAX));
        }
    }

    /// Takes a write without an answer in the capture, whose value may hold.
    pub(super) fn unanswered(&mut self, node: u8, mux: Mux) {
        if self.open_writes.get(&node).is_some_and(|(open, _)| *open == mux) {
            self.open_writes.remove(&node);
        }
        if self.nodes.get_mut(node).is_some_and(|one| one.configuration.unanswered(mux)) {
            self.asked_otherwise(node);
        }
    }

    /// Drops the unanswered writes to an object, or to one sub-index.
    pub(super) fn withdraw(&mut self, node: u8, index: u16, sub: Option<u8>) {
        if self.nodes.get_mut(node).is_some_and(|one| one.configuration.withdraw(index, sub)) {
            self.asked_otherwise(node);
        }
    }

    /// Applies a change of the unanswered writes.
    fn asked_otherwise(&mut self, node: u8) {
        if let Some(one) = self.nodes.get_mut(node) {
            one.compile();
            self.assign();
        }
    }

    /// Returns the role of a frame after overdue earlier writes count as unanswered.
    #[cold]
    pub(super) fn role_after_writes(&mut self, frame: &Frame, cx: &Context<'_>) -> Role {
        let recording = &cx.evidence.recording;
        let late = |(_, (_, since)): &(&u8, &(Mux, When))| recording.certainly_later(cx.when, *since, UNANSWERED_NS);
        let overdue: Vec<_> = self.open_writes.iter().filter(late).map(|(node, (mux, _))| (*node, *mux)).collect();
        for (node, mux) in overdue {
            self.unanswered(node, mux);
        }
        let times = self.open_writes.values().filter_map(|(_, since)| since.at.t_ns);
        self.writes_since_ns = times.min().unwrap_or(Ns::MAX);
        self.roles.of(frame.id)
    }
}

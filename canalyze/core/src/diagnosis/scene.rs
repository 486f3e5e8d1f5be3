//! What trackers see: the frame at hand, what was heard of the nodes, and what the bus knows.
//!
//! Must not: open an incident.

use super::incident::bit;
use super::ledger::Ledger;
use crate::bus::Bus;
use crate::configuration::Provenance;
use crate::frame::{BusId, FrameRef};

/// Node-IDs and 0.
const SLOTS: usize = 128;

/// What was heard of the nodes of a bus.
#[derive(Clone, Debug)]
pub(super) struct Heard {
    frames: Vec<FrameRef>,
    heartbeats: Vec<FrameRef>,
    /// Nodes that were heard, a bit each.
    pub(super) known: u128,
    /// Those of them that are Operational.
    pub(super) operational: u128,
    /// The last SYNC.
    pub(super) sync: FrameRef,
    /// Nodes that have sent more than heartbeats, a bit each: the others are hosts that only control.
    pub(super) serving: u128,
    /// The last frame of whoever controls: a command, a SYNC, an RPDO, an SDO request.
    pub(super) control: FrameRef,
    /// The time between the last two of them, in ns.
    pub(super) sync_period_ns: Option<i64>,
    /// Error frames so far, and the last one.
    pub(super) errors: (u64, FrameRef),
}

impl Default for Heard {
    fn default() -> Self {
        Self {
            frames: vec![FrameRef::default(); SLOTS],
            heartbeats: vec![FrameRef::default(); SLOTS],
            known: 0,
            operational: 0,
            sync: FrameRef::default(),
            serving: 0,
            control: FrameRef::default(),
            sync_period_ns: None,
            errors: (0, FrameRef::default()),
        }
    }
}

impl Heard {
    /// A node has sent a frame.
    #[inline]
    pub(super) fn frame(&mut self, node: u8, at: FrameRef) {
        if let Some(slot) = self.frames.get_mut(usize::from(node)) {
            *slot = at;
            self.known |= bit(node);
        }
    }

    /// A node has sent something that only a device sends.
    pub(super) fn serves(&mut self, node: u8) {
        self.serving |= bit(node);
    }

    /// A node has sent a heartbeat, or answered guarding.
    pub(super) fn heartbeat(&mut self, node: u8, at: FrameRef) {
        if let Some(slot) = self.heartbeats.get_mut(usize::from(node)) {
            *slot = at;
        }
    }

    /// The last frame of a node.
    pub(super) fn last(&self, node: u8) -> Option<FrameRef> {
        self.frames.get(usize::from(node)).copied().filter(|at| at.no > 0)
    }

    /// The last heartbeat of a node.
    pub(super) fn last_heartbeat(&self, node: u8) -> Option<FrameRef> {
        self.heartbeats.get(usize::from(node)).copied().filter(|at| at.no > 0)
    }

    /// Whether a node is Operational, as far as was seen.
    pub(super) fn is_operational(&self, node: u8) -> bool {
        self.operational & bit(node) != 0
    }
}

/// What a tracker is handed.
pub(super) struct Scene<'a> {
    pub(super) ledger: &'a mut Ledger,
    pub(super) bus: &'a Bus,
    pub(super) id: BusId,
    pub(super) heard: &'a Heard,
    /// The frame at hand.
    pub(super) at: FrameRef,
}

impl Scene<'_> {
    /// The value of an object, as far as more than an EDS says so, and the frame that showed it.
    pub(super) fn value(&self, node: u8, index: u16, sub: u8) -> Option<(u64, Provenance)> {
        self.bus.node(node)?.value(index, sub).filter(|(_, from)| *from > Provenance::Eds)
    }

    /// The nodes that a node watches by 1016h, with its times in ns and the entry's sub-index.
    pub(super) fn watched(&self, node: u8) -> Vec<(u8, i64, u8)> {
        let known = (1..=127).filter_map(|sub| Some((self.value(node, 0x1016, sub)?.0, sub)));
        let entries = known.map(|(value, sub)| ((value >> 16 & 0x7F) as u8, (value & 0xFFFF) as i64 * 1_000_000, sub));
        entries.filter(|(watched, time, _)| *watched > 0 && *time > 0).collect()
    }

    /// Whether a node is known to produce SYNC, or is the only one of which that is known.
    pub(super) fn produces_sync(&self, node: u8) -> bool {
        self.value(node, 0x1005, 0).is_some_and(|(value, _)| value & 1 << 30 != 0)
    }

    /// The producers of the PDOs whose reception a node watches (event timer, sub-index 05h), a bit each.
    pub(super) fn sources(&self, node: u8) -> u128 {
        let Some(known) = self.bus.node(node) else { return 0 };
        let timed = known.pdos().iter().filter(|pdo| !pdo.transmit && pdo.cob.0.valid);
        let timed = timed.filter(|pdo| pdo.event_timer.is_some_and(|(time, _)| time > 0));
        timed.fold(0, |all, pdo| all | self.bus.producers(pdo.cob.0.id))
    }
}

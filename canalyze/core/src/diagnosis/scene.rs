//! What trackers see: the frame at hand, what was heard of the nodes, and what the bus knows.
//!
//! Must not: open an incident.

use super::incident::bit;
use super::ledger::Ledger;
use crate::bus::Bus;
use crate::configuration::Provenance;
use crate::frame::{BusId, FrameRef};

/// How late a node may report that an RPDO did not come, in ns.
const WATCH_NS: i64 = 50_000_000;
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
    /// Error frames so far, and the first one.
    pub(super) errors: (u64, FrameRef),
    /// The last one.
    pub(super) last_error: FrameRef,
    /// The last write or NMT command to each node.
    asked: Vec<FrameRef>,
    /// The last TPDO of each node.
    pdos: Vec<FrameRef>,
    /// The last write to each node.
    written: Vec<FrameRef>,
    /// The last order to store, restore or program something, to each node.
    stored: Vec<FrameRef>,
    /// In bit/s, where it is given.
    pub(super) bit_rate: Option<u32>,
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
            last_error: FrameRef::default(),
            asked: vec![FrameRef::default(); SLOTS],
            pdos: vec![FrameRef::default(); SLOTS],
            written: vec![FrameRef::default(); SLOTS],
            stored: vec![FrameRef::default(); SLOTS],
            bit_rate: None,
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

    /// A node was told something: by a write, or by an NMT command.
    #[inline]
    pub(super) fn tells(&mut self, node: u8, at: FrameRef) {
        if let Some(slot) = self.asked.get_mut(usize::from(node)) {
            *slot = at;
        }
    }

    /// The last time that a node, or all of them (0), were told something.
    pub(super) fn asked(&self, node: u8) -> Option<FrameRef> {
        let of = |node: u8| self.asked.get(usize::from(node)).copied().filter(|at| at.no > 0);
        [of(node), of(0)].into_iter().flatten().max_by_key(|at| at.no)
    }

    /// A node has sent a TPDO.
    #[inline]
    pub(super) fn pdo(&mut self, node: u8, at: FrameRef) {
        if let Some(slot) = self.pdos.get_mut(usize::from(node)) {
            *slot = at;
        }
    }

    /// A node was written to by SDO.
    pub(super) fn writes(&mut self, node: u8, at: FrameRef) {
        self.tells(node, at);
        if let Some(slot) = self.written.get_mut(usize::from(node)) {
            *slot = at;
        }
    }

    /// The last write to a node.
    pub(super) fn written(&self, node: u8) -> Option<FrameRef> {
        self.written.get(usize::from(node)).copied().filter(|at| at.no > 0)
    }

    /// A node was told to store, restore or program something.
    pub(super) fn stores(&mut self, node: u8, at: FrameRef) {
        if let Some(slot) = self.stored.get_mut(usize::from(node)) {
            *slot = at;
        }
    }

    /// The last time that a node was told so.
    pub(super) fn stored(&self, node: u8) -> Option<FrameRef> {
        self.stored.get(usize::from(node)).copied().filter(|at| at.no > 0)
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

    /// The producers of all PDOs that a node takes, a bit each.
    pub(super) fn taken(&self, node: u8) -> u128 {
        let pdos = self.bus.node(node).map(|known| known.pdos()).unwrap_or_default();
        let taken = pdos.iter().filter(|pdo| !pdo.transmit && pdo.cob.0.valid);
        taken.fold(0, |all, pdo| all | self.bus.producers(pdo.cob.0.id))
    }

    /// The nodes whose last TPDO is as old as a time by which a node waits for an RPDO (event timer, sub-index 05h).
    pub(super) fn suspects(&self, node: u8) -> u128 {
        let times = (0x1400..=0x15FF).filter_map(|index| Some(self.value(node, index, 5)?.0 as i64 * 1_000_000));
        let times: Vec<i64> = times.filter(|time| *time > 0).collect();
        let fits = |other: &u8| {
            let last = self.heard.pdos.get(usize::from(*other)).copied().filter(|at| at.no > 0);
            let rest = last.and_then(|last| self.at.since(last)).unwrap_or(-1);
            times.iter().any(|time| (*time - time / 10..=time + time / 3 + WATCH_NS).contains(&rest))
        };
        (1..=127).filter(|other| *other != node).filter(fits).fold(0, |all, other| all | bit(other))
    }
}

//! The view of a tracker: the current frame, the frames seen from each node, and the state of the bus.

use super::ledger::Ledger;
use super::problem::bit;
use crate::bytes::frame::{BusId, FrameRef};
use crate::bytes::ns::Ns;
use crate::world::bus::Bus;
use crate::world::configuration::Provenance;

/// Maximum delay with which a node reports a missing RPDO, in ns.
const WATCH_NS: Ns = Ns::from_ms(50);
/// Number of node-IDs, including 0.
const SLOTS: usize = 128;

/// The last frame of a node or to it that is of interest later.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Last {
    /// A frame that it sent.
    Frame,
    /// A heartbeat or a response to guarding.
    Heartbeat,
    /// A TPDO.
    Pdo,
    /// An SDO response.
    Answer,
    /// An SDO request that has no response.
    Request,
    /// A write or an NMT command to it, or to all (0).
    Asked,
    /// A write to it.
    Written,
    /// An order to store, restore or program something.
    Stored,
    /// The report that it has no error left.
    NoError,
}

/// The silences of a node between its heartbeats.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Silences {
    /// The longest one since its last heartbeat, and between that and the one before.
    open: (FrameRef, FrameRef),
    closed: (FrameRef, FrameRef),
    /// The last frame that was no answer, and the longest time between two of them since the last heartbeat, in ns.
    own: FrameRef,
    own_ns: Ns,
    /// The same between the last two heartbeats, the usual one before, and the number of heartbeats that show it.
    before_ns: Ns,
    usual_ns: Ns,
    beats: u8,
}

impl Silences {
    /// Number of heartbeats after which the usual silence is known, and the multiple of it that is unusual.
    const KNOWN: u8 = 6;
    const UNUSUAL: i64 = 3;

    /// Takes a frame of the node behind its last one; true if it is an answer, and if it is a heartbeat.
    fn take(&mut self, silence: (FrameRef, FrameRef), answers: bool, beats: bool) {
        let (_, at) = silence;
        if length(silence) > length(self.open) {
            self.open = silence;
        }
        if !answers {
            let before = std::mem::replace(&mut self.own, at);
            let gap = at.since(before).filter(|_| before.no > 0);
            self.own_ns = self.own_ns.max(gap.unwrap_or_default());
        }
        if beats {
            // That of the interval that ends here is compared with those before.
            let own_ns = std::mem::take(&mut self.own_ns);
            self.closed = std::mem::take(&mut self.open);
            self.beats = self.beats.saturating_add(1);
            (self.before_ns, self.usual_ns) = (own_ns, (self.usual_ns - self.usual_ns / 16).max(self.before_ns));
        }
    }
}

fn length((from, to): (FrameRef, FrameRef)) -> Ns {
    to.since(from).unwrap_or(Ns::ZERO)
}

/// The frames seen from the nodes of a bus.
#[derive(Clone, Debug)]
pub(super) struct Heard {
    /// By [`Last`], then by node.
    last: [Vec<FrameRef>; 9],
    /// By node.
    silences: Vec<Silences>,
    /// Nodes seen, and those that have answered node guarding, one bit each.
    pub(super) known: u128,
    pub(super) guarded: u128,
    /// The state that each node has reported last; `None` if it has not, or has been lost since.
    pub(super) states: Vec<Option<u8>>,
    /// The number of responses of default SDOs behind their requests, and the longest time until one, in ns.
    pub(super) responses: (u64, Ns),
    /// The last error code that each node has reported and not cleared.
    pub(super) errors_of: Vec<Option<u16>>,
    /// Operational nodes, one bit each.
    pub(super) operational: u128,
    /// The last SYNC.
    pub(super) sync: FrameRef,
    /// Nodes that have sent more than heartbeats, one bit each; the others are hosts that only control.
    pub(super) serving: u128,
    /// The last frame of a controller: a command, a SYNC, an RPDO, an SDO request.
    pub(super) control: FrameRef,
    /// Time between the last two SYNCs, in ns.
    pub(super) sync_period_ns: Option<Ns>,
    /// Number of error frames so far, and the first one.
    pub(super) errors: (u64, FrameRef),
    /// The last error frame.
    pub(super) last_error: FrameRef,
    /// The bit rate in bit/s, if given.
    pub(super) bit_rate: Option<u32>,
}

impl Default for Heard {
    fn default() -> Self {
        Self {
            last: std::array::from_fn(|_| vec![FrameRef::default(); SLOTS]),
            silences: vec![Silences::default(); SLOTS],
            known: 0,
            guarded: 0,
            states: vec![None; SLOTS],
            responses: (0, Ns::ZERO),
            errors_of: vec![None; SLOTS],
            operational: 0,
            sync: FrameRef::default(),
            serving: 0,
            control: FrameRef::default(),
            sync_period_ns: None,
            errors: (0, FrameRef::default()),
            last_error: FrameRef::default(),
            bit_rate: None,
        }
    }
}

impl Heard {
    /// Records a frame of a node, or to it.
    #[inline]
    pub(super) fn note(&mut self, last: Last, node: u8, at: FrameRef) {
        if let Some(slot) = self.last.get_mut(last as usize).and_then(|of| of.get_mut(usize::from(node))) {
            *slot = at;
        }
    }

    /// Returns the last frame of a node or to it.
    #[inline]
    pub(super) fn noted(&self, last: Last, node: u8) -> Option<FrameRef> {
        self.last.get(last as usize)?.get(usize::from(node)).copied().filter(|at| at.no > 0)
    }

    /// Records a frame of a node.
    #[inline]
    pub(super) fn frame(&mut self, node: u8, at: FrameRef) {
        let [answers, beats] = [Last::Answer, Last::Heartbeat].map(|last| self.noted(last, node) == Some(at));
        if let (Some(last), Some(silences)) = (self.last(node), self.silences.get_mut(usize::from(node))) {
            silences.take((last, at), answers, beats);
        }
        self.note(Last::Frame, node, at);
        self.known |= bit(node);
    }

    /// Returns the last and the first frame of a node around its silence before its last heartbeat, if it was longer than `ns`
    /// and several times longer than usual, and if another frame ended it: not only heartbeats were missing.
    pub(super) fn silence(&self, node: u8, ns: Ns) -> Option<(FrameRef, FrameRef)> {
        let Silences { closed, usual_ns, beats, .. } = *self.silences.get(usize::from(node))?;
        let unusual = beats > Silences::KNOWN && length(closed) > Silences::UNUSUAL * usual_ns;
        let other = Some(closed.1) != self.last_heartbeat(node);
        Some(closed).filter(|_| unusual && other && length(closed) > ns)
    }

    /// Records a node that has sent something that only a device sends.
    pub(super) fn serves(&mut self, node: u8) {
        self.serving |= bit(node);
    }

    /// Records a reported state, or that it is not known any more.
    pub(super) fn state(&mut self, node: u8, state: Option<u8>) {
        if let Some(slot) = self.states.get_mut(usize::from(node)) {
            *slot = state;
        }
    }

    /// Records a frame of a default SDO by the client, or by the server.
    pub(super) fn exchanged(&mut self, node: u8, client: bool, at: FrameRef) {
        let asked = self.noted(Last::Request, node);
        self.note(Last::Request, node, if client { at } else { FrameRef::default() });
        if let Some(waited) = at.since(asked).filter(|ns| *ns >= Ns::ZERO && !client) {
            self.responses = (self.responses.0 + 1, self.responses.1.max(waited));
        }
    }

    /// Returns the number of nodes with heartbeats, and of those with responses to guarding.
    pub(super) fn beating(&self) -> (u64, u64) {
        let beats = |node: &u8| self.noted(Last::Heartbeat, *node).is_some();
        let all = (1..=127).filter(beats).fold(0_u128, |all, node| all | bit(node));
        ((all & !self.guarded).count_ones().into(), self.guarded.count_ones().into())
    }

    /// Records an error code that a node reports; `None`: it has none left.
    pub(super) fn reports(&mut self, node: u8, code: Option<u16>, at: FrameRef) {
        if code.is_none() {
            self.note(Last::NoError, node, at);
        }
        if let Some(slot) = self.errors_of.get_mut(usize::from(node)) {
            *slot = code;
        }
    }

    /// Returns the last frame of a node.
    pub(super) fn last(&self, node: u8) -> Option<FrameRef> {
        self.noted(Last::Frame, node)
    }

    /// Returns true if a node has sent heartbeats alone and no client has asked it for anything.
    pub(super) fn is_beating(&self, node: u8) -> bool {
        let asked = [Last::Request, Last::Asked].into_iter().any(|last| self.noted(last, node).is_some());
        self.last_heartbeat(node).is_some() && self.serving & bit(node) == 0 && !asked
    }

    /// Returns the last heartbeat of a node.
    pub(super) fn last_heartbeat(&self, node: u8) -> Option<FrameRef> {
        self.noted(Last::Heartbeat, node)
    }

    /// Returns the last write or NMT command to a node or to all (0).
    pub(super) fn asked(&self, node: u8) -> Option<FrameRef> {
        [node, 0].into_iter().filter_map(|node| self.noted(Last::Asked, node)).max_by_key(|at| at.no)
    }

    /// Records an SDO write to a node.
    pub(super) fn writes(&mut self, node: u8, at: FrameRef) {
        self.note(Last::Asked, node, at);
        self.note(Last::Written, node, at);
    }

    /// Records an SDO response of a node.
    pub(super) fn answers(&mut self, node: u8, at: FrameRef) {
        self.serves(node);
        self.note(Last::Answer, node, at);
    }

    /// Returns true if a node is Operational, as far as seen.
    pub(super) fn is_operational(&self, node: u8) -> bool {
        self.operational & bit(node) != 0
    }
}

/// The context of a call to a tracker.
pub(super) struct Scene<'a> {
    pub(super) ledger: &'a mut Ledger,
    pub(super) bus: &'a Bus,
    pub(super) id: BusId,
    pub(super) heard: &'a Heard,
    /// The current frame.
    pub(super) at: FrameRef,
}

impl Scene<'_> {
    /// Returns the value of an object and its source, unless only an EDS gives it.
    pub(super) fn value(&self, node: u8, index: u16, sub: u8) -> Option<(u64, Provenance)> {
        self.bus.node(node)?.value(index, sub).filter(|(_, from)| *from > Provenance::Eds)
    }

    /// Returns the nodes that a node monitors by 1016h, with their times in ns and the sub-index of the entry.
    pub(super) fn watched(&self, node: u8) -> Vec<(u8, Ns, u8)> {
        let known = (1..=127).filter_map(|sub| Some((self.value(node, 0x1016, sub)?.0, sub)));
        let entries = known.map(|(value, sub)| ((value >> 16 & 0x7F) as u8, Ns::from_ms((value & 0xFFFF) as i64), sub));
        entries.filter(|(watched, time, _)| *watched > 0 && *time > Ns::ZERO).collect()
    }

    /// Returns true if a node is known to produce SYNC.
    pub(super) fn produces_sync(&self, node: u8) -> bool {
        self.value(node, 0x1005, 0).is_some_and(|(value, _)| value & 1 << 30 != 0)
    }

    /// Returns the producers of the PDOs whose reception a node monitors (event timer, sub-index 05h), one bit each.
    pub(super) fn sources(&self, node: u8) -> u128 {
        let Some(known) = self.bus.node(node) else { return 0 };
        let timed = known.pdos().iter().filter(|pdo| !pdo.transmit && pdo.cob.0.valid);
        let timed = timed.filter(|pdo| pdo.event_timer.is_some_and(|(time, _)| time > 0));
        timed.fold(0, |all, pdo| all | self.bus.producers(pdo.cob.0.id))
    }

    /// Returns the producers of all PDOs that a node receives, one bit each.
    pub(super) fn taken(&self, node: u8) -> u128 {
        let pdos = self.bus.node(node).map(|known| known.pdos()).unwrap_or_default();
        let taken = pdos.iter().filter(|pdo| !pdo.transmit && pdo.cob.0.valid);
        taken.fold(0, |all, pdo| all | self.bus.producers(pdo.cob.0.id))
    }

    /// Returns the nodes whose last TPDO is as old as a time for which a node waits for an RPDO (event timer, sub-index
    /// 05h), one bit each.
    pub(super) fn suspects(&self, node: u8) -> u128 {
        let times = (0x1400..=0x15FF).filter_map(|index| Some(Ns::from_ms(self.value(node, index, 5)?.0 as i64)));
        let times: Vec<Ns> = times.filter(|time| *time > Ns::ZERO).collect();
        let fits = |other: &u8| {
            let last = self.heard.noted(Last::Pdo, *other);
            let rest = last.and_then(|last| self.at.since(last)).unwrap_or(Ns(-1));
            times.iter().any(|time| (*time - *time / 10..=*time + *time / 3 + WATCH_NS).contains(&rest))
        };
        (1..=127).filter(|other| *other != node).filter(fits).fold(0, |all, other| all | bit(other))
    }
}

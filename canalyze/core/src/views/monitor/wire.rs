//! The present state of a bus and its nodes, beyond the figures of `summary`. Nothing is judged, and no words are
//! written here.

use super::recent::Recent;
use crate::bytes::frame::{Frame, Kind};
use crate::bytes::ns::Ns;
use crate::rules::finding::Severity;
use crate::wire::error_frame;
use crate::words::profiles::Profile;
use crate::world::change::{Change, EmcyChange};
use crate::world::event::{Event, What};
use crate::world::node::PerNode;

/// Length of the time window of the load, in ns.
const LOAD_NS: Ns = Ns::from_s(1);
/// Length of the time window of rates, in ns.
const RATE_NS: Ns = Ns::from_s(2);
/// Bits of byte 1 of an error frame: warning level, passive level (received and sent frames), back to active.
const WARNING: u8 = 0x0C;
const PASSIVE: u8 = 0x30;
const ACTIVE: u8 = 0x40;
/// Error counters from which the controller is at the warning level, and error passive (ISO 11898-1).
const WARNING_FROM: u8 = 96;
const PASSIVE_FROM: u8 = 128;
/// Emergency error codes up to here clear errors.
const RESET: u16 = 0xFF;

/// The state of the listening controller, by its error frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ErrorState {
    Warning,
    Passive,
    BusOff,
}

impl ErrorState {
    /// The word in machine output.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Warning => "error-warning",
            Self::Passive => "error-passive",
            Self::BusOff => "bus-off",
        }
    }

    /// Returns the state that a frame reports; `None` if it reports nothing.
    fn of(frame: &Frame) -> Option<Option<Self>> {
        let class = error_frame::class(frame);
        let has = |bit| class & bit != 0;
        let [_, status, ..] = frame.head();
        let status = if has(error_frame::CONTROLLER) { status } else { 0 };
        let (tx, rx) = error_frame::counters(frame).filter(|_| has(error_frame::COUNTERS)).unwrap_or((0, 0));
        if has(error_frame::BUS_OFF) {
            Some(Some(Self::BusOff))
        } else if status & PASSIVE != 0 || tx.max(rx) >= PASSIVE_FROM {
            Some(Some(Self::Passive))
        } else if status & WARNING != 0 || tx.max(rx) >= WARNING_FROM {
            Some(Some(Self::Warning))
        } else if status & ACTIVE != 0 || has(error_frame::RESTARTED) || has(error_frame::COUNTERS) {
            Some(None)
        } else {
            None
        }
    }
}

/// The last emergency.
#[derive(Clone, Copy, Debug)]
pub(super) struct LastEmergency {
    /// The last error code that was reported and not cleared; if all are, the last of them.
    pub(super) code: u16,
    /// The profile that defines its meaning.
    pub(super) profile: Profile,
    /// The time of the report, in ns.
    pub(super) t_ns: Option<Ns>,
    /// The number of active errors, including it.
    pub(super) active: usize,
}

/// One node.
#[derive(Debug)]
pub(super) struct Live {
    /// Frames of its identifiers.
    pub(super) rate: Recent,
    /// Its last boot-up, heartbeat or response to node guarding, in ns.
    pub(super) beat_ns: Option<Ns>,
    pub(super) emergency: Option<LastEmergency>,
    /// By severity.
    pub(super) findings: [u64; 3],
    /// The bus was away since its state was last seen, so that it is unknown.
    pub(super) unknown: bool,
}

impl Default for Live {
    fn default() -> Self {
        Self { rate: Recent::new(RATE_NS), beat_ns: None, emergency: None, findings: [0; 3], unknown: false }
    }
}

impl Live {
    fn change(&mut self, change: &Change, t_ns: Option<Ns>) {
        self.unknown &= !matches!(change, Change::BootUp { .. } | Change::State { .. } | Change::Command { .. });
        match *change {
            Change::BootUp { .. } => {
                self.beat_ns = t_ns;
                self.taken_back();
            }
            Change::State { .. } => self.beat_ns = t_ns,
            Change::Error(EmcyChange { code, profile, active, .. }) => {
                let latest = if code > RESET { Some(code) } else { active.iter().last() };
                let Some(code_now) = latest else { return self.taken_back() };
                let before = self.emergency.filter(|before| code <= RESET && before.code == code_now);
                let t_ns = before.map_or(t_ns, |before| before.t_ns);
                // A full list does not contain the latest one any more.
                let count = active.iter().count();
                self.emergency = Some(LastEmergency { code: code_now, profile, t_ns, active: count.max(1) });
            }
            _ => {}
        }
    }

    /// Marks all errors as cleared; the last one is still shown.
    fn taken_back(&mut self) {
        if let Some(last) = &mut self.emergency {
            last.active = 0;
        }
    }
}

/// One bus.
#[derive(Debug)]
pub(super) struct Wire {
    /// Bits.
    pub(super) load: Recent,
    /// Frames.
    pub(super) rate: Recent,
    pub(super) state: Option<ErrorState>,
    pub(super) nodes: PerNode<Live>,
    /// Bits on the wire so far.
    bits: u64,
}

impl Default for Wire {
    fn default() -> Self {
        Self { load: Recent::new(LOAD_NS), rate: Recent::new(RATE_NS), state: None, nodes: PerNode::default(), bits: 0 }
    }
}

impl Wire {
    /// Takes a frame with its own event and the others. `bits`: of this bus, with this frame.
    pub(super) fn take(&mut self, frame: &Frame, own: Option<&Event>, events: &[Event], bits: u64) {
        let more = bits.saturating_sub(std::mem::replace(&mut self.bits, bits));
        if let Some(now) = frame.t_ns {
            self.load.add(now, more as u32);
            self.rate.add(now, 1);
        }
        if frame.kind == Kind::Error {
            self.state = ErrorState::of(frame).unwrap_or(self.state);
        } else if self.state == Some(ErrorState::BusOff) {
            // A controller that is off receives nothing.
            self.state = None;
        }
        if let Some((node, now)) = own.and_then(|event| event.node).zip(frame.t_ns) {
            self.nodes.entry(node).rate.add(now, 1);
        }
        for event in events {
            if let (What::Change(change), Some(node)) = (&event.what, event.node) {
                self.nodes.entry(node).change(change, frame.t_ns);
            }
        }
    }

    /// Notes that the bus is away: its nodes may change meanwhile, and its controller may be restarted.
    pub(super) fn leave(&mut self) {
        self.state = None;
        self.nodes.iter_mut().for_each(|(_, live)| live.unknown = true);
    }

    /// Counts a finding about one of its nodes.
    pub(super) fn find(&mut self, node: u8, severity: Severity) {
        if let Some(count) = self.nodes.entry(node).findings.get_mut(severity as usize) {
            *count += 1;
        }
    }
}

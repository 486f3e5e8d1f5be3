//! When event-driven PDOs come: the inhibit time, the event timer, and the deadline of an RPDO (CiA 301, 7.5.2.35
//! and .37).
//!
//! Stamps of a PC are late by a millisecond or two, at times by much more, and never early. So a short gap is judged
//! by how much a frame comes before the earliest time that all frames before it allow, and a long one only while the
//! bus shows other traffic. Nothing is judged by what an EDS presets, nor of a node that was told not to send.

use super::nodes::PAUSE_NS;
use crate::configuration::Provenance;
use crate::context::Context;
use crate::finding::{Code, Facts, Quantity};
use crate::frame::{Frame, FrameRef};
use crate::node::{Pdo, PerNode};
use crate::services::sdo::wire::Mux;

/// Lateness of a PC's stamps that is nothing special, in ns.
const LATENESS: i64 = 2_000_000;
/// Lateness of a node on a PC, whose programs wait for their turn, in ns: less is no missing PDO.
const HELD_UP: i64 = 10_000_000;
/// A bus that is silent for less than this may have been held up with its capture, in ns.
const STALL: i64 = 100_000_000;
/// A silence of the bus that ends a bunch of frames, in ns.
const BREAK: i64 = 3_000_000;
/// Frames in a row that come too early before a moderate earliness counts.
const REPEATED: u8 = 2;
/// NMT command: start remote node.
const START: u8 = 1;
/// NMT state: Operational.
const OPERATIONAL: u8 = 5;

/// Event-driven PDOs of a bus and when they came.
#[derive(Debug)]
pub struct PdoTiming {
    nodes: PerNode<Sending>,
    /// No watched PDO is due before this.
    next_ns: i64,
    /// The bus's last frame, and the silence before it.
    last_ns: Option<i64>,
    quiet_ns: i64,
    /// The silence before the frames that came without a break up to now, and the longest that was usual.
    burst_ns: i64,
    usual_ns: i64,
    /// Tolerance by option.
    jitter_ns: Option<i64>,
}

/// The PDOs of a node that are watched.
#[derive(Debug, Default)]
struct Sending {
    /// It was told not to send, or says itself that it does not.
    halted: bool,
    watches: Vec<Watch>,
}

/// One watched PDO.
#[derive(Debug)]
struct Watch {
    transmit: bool,
    number: u16,
    last: FrameRef,
    last_ns: i64,
    /// Silence of the whole bus before the last frame: it may have been held up that long.
    quiet_ns: i64,
    /// Before this the next one is too early.
    earliest_ns: i64,
    /// Frames in a row that came within the inhibit time.
    early: u8,
    /// A remote frame has asked for it.
    requested: bool,
    /// Event timer or deadline, and when it is exceeded.
    timer_ns: i64,
    due_ns: i64,
}

impl PdoTiming {
    /// Nothing seen yet; the tolerance by option.
    pub fn new(jitter_ns: Option<i64>) -> Self {
        Self {
            nodes: PerNode::default(),
            next_ns: i64::MAX,
            last_ns: None,
            quiet_ns: 0,
            burst_ns: 0,
            usual_ns: 0,
            jitter_ns,
        }
    }

    /// The larger of what stamps are late by, and a tenth of the limit; or as the option says.
    fn tolerance(&self, limit_ns: i64) -> i64 {
        self.jitter_ns.unwrap_or_else(|| LATENESS.max(limit_ns / 10))
    }

    /// A data frame of a PDO.
    pub fn sent(&mut self, node: u8, pdo: &Pdo, frame: &Frame, cx: &mut Context<'_>) {
        let timed = pdo.inhibit.is_some_and(trusted) || pdo.event_timer.is_some_and(trusted);
        if !timed || pdo.transmission.is_none_or(|(kind, from)| kind < 254 || from.is_doubted()) {
            return;
        }
        let Some(now) = frame.t_ns else { return };
        let inhibit = match pdo.inhibit {
            Some(time) if pdo.transmit && trusted(time) => i64::from(time.0) * 100_000,
            _ => 0,
        };
        let timer = match pdo.event_timer {
            Some(time) if trusted(time) => i64::from(time.0) * 1_000_000,
            _ => 0,
        };
        let tolerance = self.tolerance(inhibit);
        let lateness = self.jitter_ns.unwrap_or_else(|| HELD_UP.max(timer / 10));
        let quiet_ns = self.quiet_ns;
        let sending = self.nodes.entry(node);
        let due_ns = match pdo.transmit {
            _ if timer == 0 || sending.halted => i64::MAX,
            true => now.saturating_add(timer.saturating_add((timer / 2).max(lateness))),
            false => now.saturating_add(timer.saturating_add(lateness)),
        };
        self.next_ns = self.next_ns.min(due_ns);
        let same = |watch: &&mut Watch| (watch.transmit, watch.number) == (pdo.transmit, pdo.number);
        let Some(watch) = sending.watches.iter_mut().find(same) else {
            let (transmit, number) = (pdo.transmit, pdo.number);
            let (last, last_ns, earliest_ns) = (cx.at, now, now.saturating_add(inhibit));
            let (early, requested, timer_ns) = (0, false, timer);
            sending.watches.push(Watch {
                transmit,
                number,
                last,
                last_ns,
                quiet_ns,
                earliest_ns,
                early,
                requested,
                timer_ns,
                due_ns,
            });
            return;
        };
        // Frames that were held up with the capture come in a bunch, after a silence that is not usual.
        let held_up = self.usual_ns > 0 && self.burst_ns > self.usual_ns.saturating_mul(2);
        if let Some(gap) = watch.follow(now, inhibit, tolerance).filter(|_| !held_up) {
            let object = Mux { index: pdo.communication(), sub: 3 };
            let measured = [
                ("found", Quantity::Ns(gap)),
                ("limit", Quantity::Ns(inhibit)),
                ("tolerance", Quantity::Ns(tolerance)),
            ];
            cx.find(Code::Pdo004, Some(node), Some(object), Some(watch.last), Facts::told(0, &measured));
        }
        (watch.last, watch.last_ns, watch.quiet_ns) = (cx.at, now, quiet_ns);
        (watch.timer_ns, watch.due_ns) = (timer, due_ns);
    }

    /// A remote frame that asks for a TPDO: its answer is not bound to the inhibit time.
    pub fn requested(&mut self, node: u8, number: u16) {
        let sending = self.nodes.get_mut(node);
        let same = |watch: &&mut Watch| watch.transmit && watch.number == number;
        if let Some(watch) = sending.and_then(|sending| sending.watches.iter_mut().find(same)) {
            watch.requested = true;
        }
    }

    /// It is `now`: which PDOs should have come by now and have not. `heard`: a frame says so; the clock alone does not
    /// tell a PDO that is missing from a bus that is silent.
    pub fn advance(&mut self, now: i64, heard: bool, cx: &mut Context<'_>) {
        if now < self.next_ns {
            return;
        }
        let last_of_bus = self.last_ns.unwrap_or(now);
        let mut next = i64::MAX;
        for (node, sending) in self.nodes.iter_mut() {
            for watch in &mut sending.watches {
                if watch.due_ns <= now && !heard && watch.waits(last_of_bus) {
                    // Judged by the next frame.
                } else if watch.due_ns <= now && watch.unrecorded(now, last_of_bus) {
                    watch.due_ns = now.saturating_add(watch.timer_ns + (watch.timer_ns / 2).max(HELD_UP));
                } else if watch.due_ns <= now && watch.stalled(now, last_of_bus) {
                    watch.due_ns = now.saturating_add((watch.timer_ns / 2).max(LATENESS));
                } else if watch.due_ns <= now {
                    watch.due_ns = i64::MAX;
                    watch.overdue(node, now, cx);
                }
                next = next.min(watch.due_ns);
            }
        }
        self.next_ns = next;
    }

    /// A frame of the bus was seen.
    pub fn seen(&mut self, now: i64) {
        self.quiet_ns = self.last_ns.map_or(i64::MAX, |last| now.saturating_sub(last));
        if (BREAK..i64::MAX).contains(&self.quiet_ns) {
            self.usual_ns = (self.usual_ns - self.usual_ns / 16).max(self.burst_ns);
            self.burst_ns = self.quiet_ns;
        }
        self.last_ns = Some(now);
    }

    /// An NMT command to a node, or to all.
    pub fn commanded(&mut self, node: Option<u8>, command: u8) {
        match command {
            START => self.each(node, |sending| sending.halted = false),
            _ => self.each(node, |sending| (sending.halted, sending.watches) = (true, Vec::new())),
        }
        if let Some(node) = node.filter(|_| command != START) {
            self.nodes.entry(node).halted = true;
        }
    }

    /// A node says in which NMT state it is; 0 with its boot-up.
    pub fn state(&mut self, node: u8, state: u8) {
        let Some(sending) = self.nodes.get_mut(node) else { return };
        sending.halted = state != OPERATIONAL && state != 0;
        if state != OPERATIONAL {
            sending.watches.clear();
        }
    }

    /// What was measured so far of one node, or of all, does not count: its parameters changed, or frames were lost.
    pub fn forget(&mut self, node: Option<u8>) {
        self.each(node, |sending| sending.watches.clear());
    }

    fn each(&mut self, node: Option<u8>, mut act: impl FnMut(&mut Sending)) {
        for (id, sending) in self.nodes.iter_mut() {
            if node.is_none_or(|node| node == id) {
                act(sending);
            }
        }
    }
}

impl Watch {
    /// The PDO comes again at `now`: the gap, where it is shorter than the inhibit time for certain.
    fn follow(&mut self, now: i64, inhibit: i64, tolerance: i64) -> Option<i64> {
        let gap = now.saturating_sub(self.last_ns);
        let requested = std::mem::take(&mut self.requested);
        if inhibit == 0 || requested || gap < 0 || gap >= inhibit {
            self.earliest_ns = now.saturating_add(inhibit);
            self.early = 0;
            return None;
        }
        self.early = self.early.saturating_add(1);
        let before = self.earliest_ns.saturating_sub(now);
        // The frame before may have been stamped late, but then the bus had been silent for that long.
        let certain = gap < inhibit / 2 || self.early >= REPEATED || self.quiet_ns < before;
        if before <= tolerance || !certain {
            self.earliest_ns = self.earliest_ns.max(now).saturating_add(inhibit);
            return None;
        }
        self.earliest_ns = now.saturating_add(inhibit);
        Some(gap)
    }

    /// Whether the whole bus has been silent since before the PDO was due.
    fn waits(&self, last_of_bus: i64) -> bool {
        last_of_bus < self.last_ns.saturating_add(self.timer_ns)
    }

    /// Whether nothing was recorded from before it was overdue: a bus is not silent for so long.
    fn unrecorded(&self, now: i64, last_of_bus: i64) -> bool {
        last_of_bus < self.due_ns && now.saturating_sub(last_of_bus) > PAUSE_NS
    }

    /// Whether that is so: where there is other traffic, the capture
    /// or the bus was held up, whatever the time; where there is none, only a long silence is the PDO's own.
    fn stalled(&self, now: i64, last_of_bus: i64) -> bool {
        let expected = self.last_ns.saturating_add(self.timer_ns);
        let busy = self.quiet_ns < self.timer_ns / 2;
        self.waits(last_of_bus) && (busy || now.saturating_sub(expected) < STALL)
    }

    fn overdue(&self, node: u8, now: i64, cx: &mut Context<'_>) {
        let code = if self.transmit { Code::Pdo005 } else { Code::Pdo013 };
        let index = crate::services::pdo::communication_parameter(self.transmit, self.number);
        let gap = now.saturating_sub(self.last_ns);
        let measured = [("found", Quantity::Ns(gap)), ("limit", Quantity::Ns(self.timer_ns))];
        cx.find(code, Some(node), Some(Mux { index, sub: 5 }), Some(self.last), Facts::told(0, &measured));
    }
}

/// Whether a time is in use and is more than an EDS's preset.
fn trusted((value, from): (u16, Provenance)) -> bool {
    value != 0 && from > Provenance::Eds
}

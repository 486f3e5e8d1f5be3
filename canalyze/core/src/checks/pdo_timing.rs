//! When event-driven PDOs come: the inhibit time, the event timer, and the deadline of an RPDO (CiA 301, 7.5.2.35
//! and .37).
//!
//! Nothing is judged by what an EDS presets, nor of a node that was told not to send. What is not recorded is no
//! breach: where the whole bus was silent, a timer runs on from the end of the silence. It must not know the mapping.

use std::collections::{BTreeMap, BTreeSet};

use super::series::Series;
use crate::configuration::Provenance;
use crate::context::Context;
use crate::evidence::obligation::Owed;
use crate::evidence::{Obligations, Rules, When};
use crate::finding::{Code, Facts, Finding, Quantity};
use crate::node::Pdo;
use crate::services::pdo::communication_parameter;
use crate::services::sdo::wire::Mux;

/// What a node's own timers are off by, in ns and as a part of the time: it counts in ticks of 1 ms, by an oscillator
/// that differs from the recorder's by up to 1 %.
const TICK_NS: i64 = 1_000_000;
const CLOCK_PART: i64 = 100;
/// How late a node on a PC is, whose programs wait for their turn, in ns: less is no missing PDO.
const HELD_UP_NS: i64 = 10_000_000;
/// The part of the inhibit time, and the least time in ns, by which the stamp of the frame before may have been late,
/// where the bus was silent for that long before it.
const LATE_PART: i64 = 3;
const LATE_NS: i64 = 2_000_000;
/// NMT command: start remote node.
const START: u8 = 1;
/// NMT state: Operational.
const OPERATIONAL: u8 = 5;
/// Transmission types from this one on are event-driven.
const EVENT_DRIVEN: u8 = 254;

/// A PDO: its node, whether it is a TPDO, its number.
type Name = (u8, bool, u16);

/// Event-driven PDOs of a bus and when they came.
#[derive(Debug, Default)]
pub struct PdoTiming {
    sent: BTreeMap<Name, Sent>,
    /// The next frame of each, by its event timer or deadline.
    due: Obligations<Name>,
    /// Nodes that were told not to send, or say themselves that they do not.
    halted: BTreeSet<u8>,
}

/// The last frame of a PDO.
#[derive(Debug)]
struct Sent {
    when: When,
    /// By how much it may have been stamped late, in ns.
    late_ns: i64,
    /// A remote frame has asked for the next one.
    requested: bool,
    /// Its event timer or deadline in ns; 0: none.
    timer_ns: i64,
    /// Frames within the inhibit time, and frames that came late.
    early: Series,
    overdue: Series,
}

impl PdoTiming {
    /// A data frame of a PDO.
    pub fn sent(&mut self, node: u8, pdo: &Pdo, cx: &mut Context<'_>) {
        let event_driven = pdo.transmission.is_some_and(|(kind, from)| kind >= EVENT_DRIVEN && !from.is_doubted());
        if !event_driven || cx.at.t_ns.is_none() {
            return;
        }
        let name = (node, pdo.transmit, pdo.number);
        let inhibit = pdo.inhibit.filter(|_| pdo.transmit).map_or(0, trusted) * 100_000;
        let timer = pdo.event_timer.map_or(0, trusted) * 1_000_000;
        if let Some(owed) = self.due.met(name)
            && !self.overdue(name, owed, cx)
            && let Some(sent) = self.sent.get_mut(&name)
        {
            sent.overdue.keep();
        }
        if timer > 0 && !self.halted.contains(&node) {
            self.due.open(name, Owed { since: cx.when, limit_ns: patience(pdo.transmit, timer), why: None });
        }
        let late_ns = cx.evidence.recording.lateness_ns(cx.when).min(LATE_NS.max(inhibit / LATE_PART));
        match self.sent.get_mut(&name) {
            Some(sent) => {
                sent.timer_ns = timer;
                sent.follow(name, inhibit, late_ns, cx);
            }
            None => {
                let (early, overdue) = (Series::default(), Series::default());
                let sent = Sent { when: cx.when, late_ns, requested: false, timer_ns: timer, early, overdue };
                self.sent.insert(name, sent);
            }
        }
    }

    /// A remote frame that asks for a TPDO: its answer is not bound to the inhibit time.
    pub fn requested(&mut self, node: u8, number: u16) {
        if let Some(sent) = self.sent.get_mut(&(node, true, number)) {
            sent.requested = true;
        }
    }

    /// A frame has come: which PDOs should have come before it.
    pub fn advance(&mut self, cx: &mut Context<'_>) {
        for (name, owed) in self.due.due(cx.when, &cx.evidence.recording) {
            if !self.overdue(name, owed, cx) {
                // Only the silence of the bus was too long: it is owed from its end on.
                self.due.open(name, Owed { since: cx.when, ..owed });
            }
        }
    }

    /// Reports that the next frame of a PDO has not come by the frame at hand, where that is certain.
    fn overdue(&mut self, name: Name, owed: Owed, cx: &mut Context<'_>) -> bool {
        let (node, transmit, number) = name;
        let recording = &cx.evidence.recording;
        let Some(sent) = self.sent.get_mut(&name) else { return false };
        let Some(gap) = recording.between(sent.when, cx.when) else { return false };
        // While the bus is silent one frame may wait with the recorder, but not two.
        let silent = cx.when.silent_ns >= gap - sent.timer_ns;
        let limit =
            if silent { owed.limit_ns.max(2 * sent.timer_ns - tolerance(sent.timer_ns)) } else { owed.limit_ns };
        let excused = cx.evidence.circumstances.excuse(Rules::EventPdo, Some(node), owed.since, recording).is_some();
        if excused || !recording.certainly_later(cx.when, owed.since, limit) {
            return false;
        }
        let code = if transmit { Code::Pdo005 } else { Code::Pdo013 };
        let object = Mux { index: communication_parameter(transmit, number), sub: 5 };
        let measured = [("found", Quantity::Ns(gap)), ("limit", Quantity::Ns(sent.timer_ns))];
        let finding = cx.finding(code, Some(node), Some(object), Some(sent.when.at), Facts::told(0, &measured));
        cx.report_of_node(Finding { because_of: sent.overdue.fault(cx.at), ..finding });
        true
    }

    /// An NMT command to a node, or to all.
    pub fn commanded(&mut self, node: Option<u8>, command: u8) {
        let nodes = node.map_or(1..=127, |node| node..=node);
        if command == START {
            self.halted.retain(|halted| !nodes.contains(halted));
        } else {
            self.halted.extend(nodes);
            self.forget(node);
        }
    }

    /// A node says in which NMT state it is; 0 with its boot-up.
    pub fn state(&mut self, node: u8, state: u8) {
        if matches!(state, 0 | OPERATIONAL) {
            self.halted.remove(&node);
        } else {
            self.halted.insert(node);
        }
        if state != OPERATIONAL {
            self.forget(Some(node));
        }
    }

    /// What was seen so far of one node, or of all, does not count: it was reset, or frames were lost.
    pub fn forget(&mut self, node: Option<u8>) {
        let concerned = |name: &Name| node.is_none_or(|node| node == name.0);
        self.sent.retain(|name, _| !concerned(name));
        self.due.void(concerned);
    }

    /// A parameter of a PDO was written.
    pub fn reconfigured(&mut self, node: u8, transmit: bool, number: u16) {
        self.sent.remove(&(node, transmit, number));
        self.due.met((node, transmit, number));
    }
}

impl Sent {
    /// The PDO comes again, with the frame at hand.
    fn follow(&mut self, (node, transmit, number): Name, inhibit: i64, late_ns: i64, cx: &mut Context<'_>) {
        let before = std::mem::replace(&mut self.when, cx.when);
        let requested = std::mem::take(&mut self.requested);
        let gap = cx.evidence.recording.between(before, cx.when).filter(|gap| *gap >= 0);
        let Some(gap) = gap.filter(|_| inhibit > 0 && !requested) else {
            self.late_ns = late_ns;
            return;
        };
        let tolerance = tolerance(inhibit);
        let limit = inhibit - tolerance - self.late_ns;
        // It is as late as the one before, but for what it came too late or too early.
        // What one frame was late by shows once, and not in every gap of a steady train.
        self.late_ns = (self.late_ns / 2).saturating_add(gap - inhibit).clamp(0, late_ns);
        if !cx.evidence.recording.certainly_within(cx.when, before, limit) {
            return self.early.keep();
        }
        let object = Mux { index: communication_parameter(transmit, number), sub: 3 };
        let measured =
            [("found", Quantity::Ns(gap)), ("limit", Quantity::Ns(inhibit)), ("tolerance", Quantity::Ns(tolerance))];
        let finding = cx.finding(Code::Pdo004, Some(node), Some(object), Some(before.at), Facts::told(0, &measured));
        cx.report_timed(Finding { because_of: self.early.fault(cx.at), ..finding });
    }
}

/// By how much a node's timer may be off, in ns.
pub(super) fn tolerance(time_ns: i64) -> i64 {
    TICK_NS + time_ns / CLOCK_PART
}

/// How long the next frame may take by an event timer, or by an RPDO's deadline, in ns. A node whose event timer runs
/// may send half a period late under load.
fn patience(transmit: bool, timer_ns: i64) -> i64 {
    let part = if transmit { 2 } else { 10 };
    timer_ns + HELD_UP_NS.max(timer_ns / part)
}

/// A time that is in use and is more than an EDS's preset; 0: none.
fn trusted((value, from): (u16, Provenance)) -> i64 {
    if from > Provenance::Eds { i64::from(value) } else { 0 }
}

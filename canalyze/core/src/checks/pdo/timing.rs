//! The times of event-driven PDOs: inhibit time, event timer, and deadline of an RPDO (CiA 301, 7.5.2.35 and .37).
//!
//! EDS presets are not judged, nor are nodes that were commanded not to send. A gap in the recording is no fault: after
//! a silence of the whole bus a timer runs on from its end.
//!
//! An event timer that nobody has named is learnt ([`Timer`]). As the sender may have other reasons to wait, only many
//! of its times without the TPDO count, while its node gives signs of life and SYNC, if any, goes on.
//!
//! A TPDO that comes at one longer interval is one fault, and that interval is awaited then. This is judged at the end, as
//! is a TPDO that the configuration in the capture asks for, by its event timer or with SYNC, and that never comes. The
//! recorder may have left PDOs out: only where another one, or SYNC, is in the capture.

use std::collections::{BTreeMap, BTreeSet};

use super::series::Series;
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::checks::PdoName;
use crate::checks::limits::NO_SYNC_NS;
use crate::checks::pdo::configuration::pdo_parameter;
use crate::evidence::obligation::Owed;
use crate::evidence::period::Timer;
use crate::evidence::{Obligations, Rules, When};
use crate::rules::finding::{Code, Finding, Verdict};
use crate::rules::pdo::{Pdo004, Pdo005, Pdo013, Pdo022, Pdo023};
use crate::rules::sync::Syn014;
use crate::sdo::wire::Mux;
use crate::wire::error_control::OPERATIONAL;
use crate::wire::nmt::START;
use crate::wire::pdo::communication_parameter;
use crate::world::configuration::Provenance;
use crate::world::context::Context;
use crate::world::node::{Content, Node, Pdo, PerNode, PerPdo};

/// Error of a node's timers: its tick of 1 ms, and the fraction by which its oscillator differs (up to 1 %).
const TICK_NS: Ns = Ns::from_ms(1);
const CLOCK_PART: i64 = 100;
/// Delay of a node on a PC, whose programs wait for their turn, in ns; less is no missing PDO.
const HELD_UP_NS: Ns = Ns::from_ms(10);
/// Number of gaps that show a sender's punctuality; before, it may be late by half its period under load.
const KNOWN: u32 = 5;
/// Maximum lateness of a punctual sender: a fraction of its period, and a multiple of its usual lateness.
const PUNCTUAL_PART: i64 = 6;
const USUAL: i64 = 3;
/// First event-driven transmission type.
const EVENT_DRIVEN: u8 = 254;
/// Number of learnt event timers, and minimum time in ns, without a TPDO after which it has stopped.
const STOPPED: i64 = 10;
const STOPPED_NS: Ns = Ns::from_s(1);
/// Number of those timers behind a TPDO that may be sent by changes, after which a frame of its node shows that it rests.
const RESTS: i64 = 2;
/// Part by which a TPDO that is sent with each SYNC may differ from the cycle.
const CYCLE_PART: i64 = 8;
/// Number of gaps in a row, alike up to this part of them, that show a longer interval than that of the event timer, and
/// the number if it is twice as long; and the least by which it is longer, in ns.
const LONGER: u32 = 5;
const TWICE: u32 = 3;
const ALIKE_PART: i64 = 12;
const LONGER_NS: Ns = Ns::from_ms(5);
/// Number of SYNCs with which a TPDO was due after which it is never sent.
const NEVER: u64 = 20;

/// The key of a PDO: its node, true for a TPDO, its number.
type TimingKey = (u8, bool, u16);

/// Event-driven PDOs of a bus, and their times.
#[derive(Debug, Default)]
pub struct PdoTiming {
    sent: PerNode<PerPdo<Sent>>,
    /// The next frame of each, by its event timer or deadline.
    due: Obligations<TimingKey>,
    /// Nodes commanded not to send, or reporting a state in which they do not.
    halted: BTreeSet<u8>,
    /// The last SYNC.
    sync: Option<When>,
    /// The time between the last two, in ns.
    cycle_ns: Option<Ns>,
    /// Number of SYNCs so far.
    syncs: u64,
    /// A data frame of a PDO is in the capture.
    seen: bool,
    /// Nodes that report Operational: the first and the last time in a row.
    operational: BTreeMap<u8, (Moment, Moment)>,
    /// Nodes that left Operational without a command: as behind a restart, their configuration is not known.
    fallen: BTreeMap<u8, FrameRef>,
}

/// A report of a node's state, and the number of SYNCs before it.
#[derive(Clone, Copy, Debug)]
struct Moment {
    when: When,
    syncs: u64,
}

/// The last frame of a PDO.
#[derive(Debug, Default)]
struct Sent {
    /// The time of the frame; `None` if the PDO was stopped since.
    when: Option<When>,
    /// Maximum delay of its stamp, in ns.
    late_ns: Ns,
    /// The next frame was requested by a remote frame.
    requested: bool,
    /// Its event timer or deadline in ns; 0 is none.
    timer_ns: Ns,
    /// Its inhibit time in ns.
    inhibit_ns: Ns,
    /// The event timer as learnt from its frames, if nobody has named it.
    learnt: Option<LearntTimer>,
    /// The usual excess over the timer, in ns, and the number of gaps that showed it.
    usual_ns: Ns,
    gaps: u32,
    /// Frames within the inhibit time, and frames that came late.
    early: Series,
    overdue: Series,
    /// The last gap in ns, if it was longer than the event timer, the number of such gaps in a row that are alike, and the
    /// frame before the first of them.
    longer_ns: Ns,
    longer: u32,
    longer_since: FrameRef,
}

/// An event timer that nobody has named, with the data and the time of the last frame; no time if the PDO was stopped
/// since.
#[derive(Debug, Default)]
struct LearntTimer {
    timer: Timer,
    head: [u8; 8],
    when: Option<When>,
}

impl PdoTiming {
    /// Takes a data frame of a PDO, and learns the event timer of a TPDO unless that, or a transmission with SYNC, is
    /// known. `pdo`: its configuration; `head`: its first bytes, except for a multiplex PDO.
    pub fn sent(&mut self, name: PdoName, pdo: Option<&Pdo>, head: Option<[u8; 8]>, cx: &mut Context<'_>) {
        let PdoName { transmit, number, node } = name;
        let name = (node, transmit, number);
        self.seen = true;
        let timed = cx.at.t_ns.is_some();
        let event_driven =
            |pdo: &&Pdo| pdo.transmission.is_some_and(|(kind, from)| kind >= EVENT_DRIVEN && !from.is_doubted());
        let judged = pdo.filter(|_| timed).filter(event_driven);
        let head = head.filter(|_| transmit);
        let learns = head.filter(|_| timed && !pdo.is_some_and(is_named));
        if judged.is_some() || learns.is_some() {
            self.came(name, cx);
        } else if !transmit {
            return;
        }
        let sent = self.sent.entry(node).entry(transmit, number);
        let mut owed = None;
        if let Some(pdo) = judged {
            let inhibit = Ns::from_us(100 * pdo.inhibit.filter(|_| transmit).map_or(0, trusted));
            let late_ns = cx.evidence.recording.shortens_ns(cx.when, inhibit);
            sent.timer_ns = Ns::from_ms(pdo.event_timer.map_or(0, trusted));
            sent.inhibit_ns = inhibit;
            sent.follow(name, inhibit, late_ns, cx);
            owed = (sent.timer_ns > Ns::ZERO).then(|| sent.patience(transmit));
        }
        match learns {
            Some(head) => {
                sent.when = Some(cx.when);
                let learnt = sent.learnt.get_or_insert_default().take(head, cx);
                let in_step = |ns: Ns, cycle: Ns| cycle.abs_diff(ns) <= (cycle / CYCLE_PART).abs();
                let cyclic = |ns: &Ns| self.cycle_ns.is_some_and(|cycle| in_step(*ns, cycle));
                if let Some(timer_ns) = learnt.filter(|ns| !self.halted.contains(&node) && !cyclic(ns)) {
                    sent.timer_ns = timer_ns;
                    owed = Some((timer_ns * STOPPED).max(STOPPED_NS));
                }
            }
            // It may have been named since.
            None if head.is_some() => sent.learnt = None,
            None => {}
        }
        if let Some(limit_ns) = owed.filter(|_| !self.halted.contains(&node)) {
            self.due.open(name, Owed { since: cx.when, limit_ns, why: None });
        }
    }

    fn get_mut(&mut self, (node, transmit, number): TimingKey) -> Option<&mut Sent> {
        self.sent.get_mut(node)?.get_mut(transmit, number)
    }

    /// Judges the time up to a frame.
    fn came(&mut self, name: TimingKey, cx: &mut Context<'_>) {
        if let Some(owed) = self.due.met(name)
            && (self.rests(name, Some(cx.at)) || !self.overdue(name, owed, cx))
            && let Some(sent) = self.get_mut(name)
        {
            sent.overdue.keep();
        }
    }

    /// Takes a SYNC.
    pub fn synced(&mut self, cx: &Context<'_>) {
        self.syncs += 1;
        let last = self.sync.replace(cx.when);
        self.cycle_ns = last.and_then(|last| cx.evidence.recording.between(last, cx.when));
    }

    /// Takes a remote frame for a TPDO: the inhibit time does not bind the answer.
    pub fn requested(&mut self, node: u8, number: u16) {
        if let Some(sent) = self.get_mut((node, true, number)) {
            sent.requested = true;
        }
    }

    /// Reports PDOs that should have come before the current frame.
    #[inline]
    pub fn advance(&mut self, now_ns: Ns, heard: impl Fn(u8) -> Option<FrameRef>, cx: &mut Context<'_>) {
        if self.due.may_be_due(now_ns) {
            self.judge_due(heard, cx);
        }
    }

    fn judge_due(&mut self, heard: impl Fn(u8) -> Option<FrameRef>, cx: &mut Context<'_>) {
        for (name, owed) in self.due.due(cx.when, &cx.evidence.recording) {
            if self.rests(name, heard(name.0)) || !self.overdue(name, owed, cx) {
                // Only the silence of the bus was too long, so the time restarts at its end.
                self.due.open(name, Owed { since: cx.when, ..owed });
            }
        }
    }

    /// Returns true if a TPDO may have been sent by changes, which rest: its node was `heard` long behind it.
    fn rests(&mut self, name: TimingKey, heard: Option<FrameRef>) -> bool {
        let Some(sent) = self.get_mut(name) else { return false };
        let changes = sent.learnt.as_ref().is_some_and(|learnt| learnt.timer.may_be_changes());
        let since = heard.zip(sent.when).and_then(|(heard, last)| heard.since(last.at));
        changes && since.is_some_and(|since| since > sent.timer_ns * RESTS)
    }

    /// Reports a PDO that has certainly not come in time; returns true if it did.
    fn overdue(&mut self, name: TimingKey, owed: Owed, cx: &mut Context<'_>) -> bool {
        let (node, transmit, number) = name;
        let recording = &cx.evidence.recording;
        let Some(sent) = self.sent.get_mut(node).and_then(|sent| sent.get_mut(transmit, number)) else { return false };
        let Some(last) = sent.when else { return false };
        let Some(gap) = recording.between(last, cx.when) else { return false };
        // During a silence of the bus the recorder may hold one frame, but not two.
        let silent = cx.when.silent_ns >= gap - sent.timer_ns;
        let limit =
            if silent { owed.limit_ns.max(2 * sent.timer_ns - tolerance(sent.timer_ns)) } else { owed.limit_ns };
        let now_ns = cx.at.t_ns.unwrap_or(Ns::ZERO);
        // One long silence may be the recorder's; a PDO missing in two of them has stopped.
        let period_ns = if owed.since.at == last.at { sent.timer_ns } else { Ns::MAX };
        let held_back = recording.was_silent(node, now_ns - (gap - sent.timer_ns), period_ns, now_ns);
        // A TPDO that is learnt may come with SYNC.
        let learnt = sent.learnt.is_some();
        let without_sync = |sync: When| recording.between(sync, cx.when).is_none_or(|ns| ns > owed.limit_ns / 2);
        if learnt && (!cx.evidence.pending.is_watched(Some(node)) || self.sync.is_some_and(without_sync)) {
            return false;
        }
        let excused = held_back
            || cx.evidence.circumstances.excuse(Rules::EventPdo, Some(node), (owed.since, cx.at), recording).is_some();
        if excused || !recording.certainly_later(cx.when, owed.since, limit) {
            return false;
        }
        let object = Mux { index: communication_parameter(transmit, number), sub: 5 };
        let (found, limit) = (gap, sent.timer_ns);
        let what: Verdict = match transmit {
            true if learnt => Pdo005::Stopped { found, limit }.into(),
            true => Pdo005::Overdue { found, limit }.into(),
            false => Pdo013::Overdue { found, limit }.into(),
        };
        let finding = cx.verdict(what, Some(node), Some(object), Some(last.at));
        let finding = Finding { because_of: sent.overdue.fault(cx.at), ..finding };
        // A node that has reported its state will do so again, though its period may not be known yet.
        let reports = self.operational.contains_key(&node);
        if sent.learnt.as_ref().is_some_and(|learnt| learnt.timer.may_be_changes()) && reports {
            cx.report_if_lost(finding);
        } else {
            cx.report_of_node(finding);
        }
        true
    }

    /// Takes an NMT command to a node, or to all.
    pub fn commanded(&mut self, node: Option<u8>, command: u8) {
        let nodes = node.map_or(1..=127, |node| node..=node);
        if command == START {
            self.halted.retain(|halted| !nodes.contains(halted));
        } else {
            self.operational.retain(|one, _| !nodes.contains(one));
            self.halted.extend(nodes);
            self.pause(node);
        }
    }

    /// Takes a node's reported NMT state; 0 is its boot-up. A node that is no longer Operational has stopped its PDOs.
    pub fn state(&mut self, node: u8, state: u8, cx: &mut Context<'_>) {
        let halted = match state {
            0 | OPERATIONAL => self.halted.remove(&node),
            _ => !self.halted.insert(node),
        };
        if state == OPERATIONAL {
            let now = Moment { when: cx.when, syncs: self.syncs };
            self.operational.entry(node).or_insert((now, now)).1 = now;
            if cx.evidence.pending.holds(Code::Pdo005, Some(node)) {
                self.withdraw_resting(node, cx);
            }
        } else {
            if self.operational.remove(&node).is_some() && !halted {
                self.fallen.insert(node, cx.at);
            }
            self.pause(Some(node));
            cx.evidence.pending.explain(cx.at, |it| it.code == Code::Pdo005 && it.node == Some(node));
        }
    }

    /// Withdraws what waits for a sign of life of a node about TPDOs that may rest.
    #[cold]
    fn withdraw_resting(&mut self, node: u8, cx: &mut Context<'_>) {
        let mut resting = |finding: &Finding| {
            let number = finding.object.and_then(|mux| pdo_parameter(mux.index)).map(|(_, _, number)| number);
            number.is_some_and(|number| self.rests((node, true, number), Some(cx.at)))
        };
        cx.evidence.pending.withdraw(|one| one.code == Code::Pdo005 && one.node == Some(node) && resting(one));
    }

    /// Stops one node, or all: the next time is unknown, the punctuality is kept.
    fn pause(&mut self, node: Option<u8>) {
        let concerned = |of: u8| node.is_none_or(|node| node == of);
        let sent = self.sent.iter_mut().filter(|(of, _)| concerned(*of));
        for sent in sent.flat_map(|(_, sent)| sent.values_mut()) {
            sent.when = None;
            sent.learnt.iter_mut().for_each(|learnt| learnt.when = None);
        }
        self.due.void(|name| concerned(name.0));
    }

    /// Forgets one node, or all, after a reset or lost frames.
    pub fn forget(&mut self, node: Option<u8>) {
        let concerned = |of: u8| node.is_none_or(|node| node == of);
        self.sent.iter_mut().filter(|(of, _)| concerned(*of)).for_each(|(_, sent)| *sent = PerPdo::default());
        self.operational.retain(|of, _| !concerned(*of));
        self.due.void(|name| concerned(name.0));
    }

    /// Takes a write to a PDO parameter.
    pub fn reconfigured(&mut self, node: u8, transmit: bool, number: u16) {
        if let Some(sent) = self.sent.get_mut(node) {
            sent.take(transmit, number);
        }
        self.operational.remove(&node);
        self.due.met((node, transmit, number));
    }

    /// Returns the frame by which a node last left Operational without a command.
    pub fn fallen(&self, node: u8) -> Option<FrameRef> {
        self.fallen.get(&node).copied()
    }

    /// Reports at the end of the capture what does not come as configured. `configured`: true for a TPDO of a node whose
    /// configuration is known, and whose frames are its own; `unproduced`: SYNC is known to be missing.
    pub fn finish(
        &mut self,
        nodes: &PerNode<Node>,
        configured: impl Fn(u8, &Pdo) -> bool,
        unproduced: bool,
        cx: &mut Context<'_>,
    ) {
        if self.seen || self.syncs > 0 {
            self.judge_absent(nodes, &configured, unproduced, cx);
        }
        for (node, pdo) in nodes.iter().flat_map(|(id, node)| node.pdos().iter().map(move |pdo| (id, pdo))) {
            let Some(sent) = self.get_mut((node, true, pdo.number)).filter(|_| pdo.transmit) else { continue };
            let (limit, longer_since) = (sent.timer_ns, sent.longer_since);
            if let Some(found) = sent.interval_ns()
                && configured(node, pdo)
            {
                let object = Mux { index: communication_parameter(true, pdo.number), sub: 5 };
                cx.raise(Pdo023::Slower { found, limit }, Some(node), Some(object), Some(longer_since));
            }
        }
    }

    /// Reports TPDOs that never came although their nodes were Operational for long.
    fn judge_absent(
        &mut self,
        nodes: &PerNode<Node>,
        configured: impl Fn(u8, &Pdo) -> bool,
        unproduced: bool,
        cx: &mut Context<'_>,
    ) {
        let mut without_sync: Option<(Moment, u64)> = None;
        for (&node, &(since, last)) in &self.operational {
            let mut came = self.sent.get_mut(node);
            for pdo in nodes.get(node).map(Node::pdos).unwrap_or_default() {
                let came = came.as_mut().is_some_and(|sent| sent.get_mut(true, pdo.number).is_some());
                let Some(kind) = asked_for(pdo).filter(|_| !came && configured(node, pdo)) else { continue };
                let recording = &cx.evidence.recording;
                let lasts = |limit: Ns| recording.certainly_later(last.when, since.when, limit);
                let found = recording.between(since.when, last.when).unwrap_or(Ns::ZERO);
                let timer = Ns::from_ms(pdo.event_timer.map_or(0, trusted));
                let (what, sub) = match kind {
                    1..=240 if self.syncs == 0 => {
                        if lasts(NO_SYNC_NS) {
                            let (first, count) = without_sync.unwrap_or((since, 0));
                            without_sync = Some((first, count + 1));
                        }
                        continue;
                    }
                    1..=240 if (last.syncs - since.syncs) / u64::from(kind) >= NEVER => {
                        (Pdo022::NeverWithSync { cycles: last.syncs - since.syncs, expected: kind.into() }, 2)
                    }
                    EVENT_DRIVEN.. if timer > Ns::ZERO && lasts((timer * STOPPED).max(STOPPED_NS)) => {
                        (Pdo022::Never { found, limit: timer }, 5)
                    }
                    _ => continue,
                };
                let object = Mux { index: communication_parameter(true, pdo.number), sub };
                cx.raise(what, Some(node), Some(object), Some(since.when.at));
            }
        }
        if let Some((since, pdos)) = without_sync.filter(|_| !unproduced) {
            cx.raise(Syn014::Never { pdos }, None, None, Some(since.when.at));
        }
    }
}

impl LearntTimer {
    /// Takes the next frame; returns the event timer in ns, if it is learnt.
    fn take(&mut self, head: [u8; 8], cx: &Context<'_>) -> Option<Ns> {
        let unchanged = std::mem::replace(&mut self.head, head) == head;
        let recording = &cx.evidence.recording;
        if let Some(last) = self.when.replace(cx.when)
            && let Some(gap) = recording.between(last, cx.when)
            && recording.teaches(last)
            && recording.teaches(cx.when)
        {
            self.timer.take(gap, unchanged);
        }
        self.timer.ns()
    }
}

impl Sent {
    /// Returns the maximum time to the next frame by its event timer, or by an RPDO's deadline, in ns.
    fn patience(&self, transmit: bool) -> Ns {
        let timer_ns = self.interval_ns().unwrap_or(self.timer_ns.max(self.inhibit_ns));
        let late_ns = match (transmit, self.gaps) {
            (false, _) => timer_ns / 10,
            (true, ..KNOWN) => timer_ns / 2,
            (true, _) => (timer_ns / PUNCTUAL_PART).max(USUAL * self.usual_ns).min(timer_ns / 2),
        };
        timer_ns + HELD_UP_NS.max(late_ns)
    }

    /// Takes the next frame of the PDO.
    fn follow(&mut self, name: TimingKey, inhibit: Ns, late_ns: Ns, cx: &mut Context<'_>) {
        let requested = std::mem::take(&mut self.requested);
        let Some(before) = self.when.replace(cx.when) else {
            self.late_ns = late_ns;
            return;
        };
        let recording = &cx.evidence.recording;
        let gap = recording.between(before, cx.when).filter(|gap| *gap >= Ns::ZERO);
        if let Some(gap) = gap.filter(|_| recording.teaches(before) && recording.teaches(cx.when)) {
            let late = (gap - self.timer_ns).clamp(Ns::ZERO, self.timer_ns / 2);
            self.usual_ns = late.max(self.usual_ns - self.usual_ns / 16);
            self.gaps = self.gaps.saturating_add(1);
            if name.1 {
                self.compare(before.at, gap, recording.resolution_ns());
            }
        }
        let Some(gap) = gap.filter(|_| inhibit > Ns::ZERO && !requested) else {
            self.late_ns = late_ns;
            return;
        };
        let tolerance = tolerance(inhibit);
        let limit = inhibit - tolerance - self.late_ns;
        // It is as late as the one before, changed by its own deviation. A late stamp shortens one gap, not every gap.
        self.late_ns = ((self.late_ns / 2) + (gap - inhibit)).clamp(Ns::ZERO, late_ns);
        if !cx.evidence.recording.certainly_within(cx.when, before, limit) {
            return self.early.keep();
        }
        self.too_close(name, before, Pdo004::TooClose { found: gap, limit: inhibit, tolerance }, cx);
    }

    /// Compares a gap behind a frame with the times of a TPDO: it may always be the same longer one.
    #[inline]
    fn compare(&mut self, before: FrameRef, gap: Ns, resolution: Ns) {
        let due = self.timer_ns.max(self.inhibit_ns);
        if self.timer_ns <= Ns::ZERO || gap - due <= LONGER_NS.max(due / PUNCTUAL_PART).max(resolution * 2) {
            self.longer = 0;
            return;
        }
        if self.longer == 0 || gap.abs_diff(self.longer_ns) > self.longer_ns / ALIKE_PART {
            (self.longer, self.longer_since) = (0, before);
        }
        (self.longer_ns, self.longer) = (gap, self.longer.saturating_add(1));
    }

    /// Returns the interval at which a TPDO comes, if that is always longer than its event timer.
    fn interval_ns(&self) -> Option<Ns> {
        let due = self.timer_ns.max(self.inhibit_ns);
        let least = if self.longer_ns / 2 >= due { TWICE } else { LONGER };
        (self.longer >= least).then_some(self.longer_ns)
    }

    /// Reports a PDO within its inhibit time.
    #[cold]
    fn too_close(&mut self, (node, transmit, number): TimingKey, before: When, what: Pdo004, cx: &mut Context<'_>) {
        let object = Mux { index: communication_parameter(transmit, number), sub: 3 };
        let finding = cx.verdict(what, Some(node), Some(object), Some(before.at));
        let because_of = self.early.fault(cx.at);
        cx.report_timed(cx.excused(Rules::EventPdo, before, Finding { because_of, ..finding }));
    }
}

/// Returns the transmission type of a TPDO that is in use, as more than an EDS says.
fn asked_for(pdo: &Pdo) -> Option<u8> {
    // It may wait for the SYNC with its start value.
    let waits = pdo.sync_start.is_some_and(|(start, _)| start != 0);
    let told = pdo.transmit && pdo.cob.0.valid && pdo.cob.1 > Provenance::Eds && !waits;
    pdo.transmission.filter(|_| told && !matches!(pdo.content, Content::Disabled(_))).map(|(kind, _)| kind)
}

/// Returns true if more than an EDS says that a TPDO is sent with SYNC, or names its event timer.
fn is_named(pdo: &Pdo) -> bool {
    let told = |from: Provenance| from > Provenance::Eds;
    pdo.transmission.is_some_and(|(kind, from)| told(from) && kind < EVENT_DRIVEN)
        || pdo.event_timer.is_some_and(|(_, from)| told(from))
}

/// Returns the maximum error of a node's timer, in ns.
pub fn tolerance(time_ns: Ns) -> Ns {
    TICK_NS + time_ns / CLOCK_PART
}

/// Returns a time that is in use and more than an EDS preset; 0 if none.
fn trusted((value, from): (u16, Provenance)) -> i64 {
    if from > Provenance::Eds { i64::from(value) } else { 0 }
}

//! Heartbeats (CiA 301, 7.2.8.3.2): late, lost, in an unknown state, or with another period than before.
//!
//! A producer is watched from its first heartbeat on, as consumers do. How often it sends is what the capture shows of
//! 1017h (or a DCF says) and what its heartbeats themselves show; where both disagree the heartbeats are right. It owes
//! the next one, and counts as lost when a consumer's time (1016h) is over, or after three periods. Additional
//! heartbeats are legal. A silence of the whole bus loses nobody: who does not come back after it is lost. Verdicts
//! need stamps, but for states. Two nodes with one node-ID are found in `duplicate_id`.

use super::duplicate_id::{DuplicateId, Place};
use crate::configuration::Provenance;
use crate::context::Context;
use crate::evidence::circumstance::Kind;
use crate::evidence::duplicates::Sighting;
use crate::evidence::obligation::Owed;
use crate::evidence::period::{Confidence, Learnt};
use crate::evidence::recording::{Silence, Verdict};
use crate::evidence::{Obligations, Period, When};
use crate::finding::{Code, Facts, Finding, Quantity};
use crate::frame::FrameRef;
use crate::node::{Node, PerNode};
use crate::services::heartbeat::{OPERATIONAL, PRE_OPERATIONAL, STOPPED};

/// How late a producer may always be, in ns: what hosts and small controllers are by now and then.
const LEAST_SLACK_NS: i64 = 20_000_000;
/// Heartbeats closer than this come out of a buffer, in ns.
const BUFFERED_NS: i64 = 5_000_000;
/// Nodes that are switched on together are back within this time, in ns.
const POWER_UP_NS: i64 = 5_000_000_000;
/// Sub-indices of 1016h.
const CONSUMED: std::ops::RangeInclusive<u8> = 1..=127;

/// One producer.
#[derive(Debug, Default)]
struct Producer {
    /// The last heartbeat, or the boot-up where 1017h is known; `None` while the node is not watched.
    last: Option<When>,
    /// The last heartbeat before those of a burst, and how many came since.
    held: Option<(When, i64)>,
    state: Option<u8>,
    /// The last state, where CiA 301 does not know it.
    unknown: Option<u8>,
    period: Period,
    /// 1017h holds 0.
    off: bool,
    /// The time of the consumer that waits shortest, in ns.
    consumer: Option<i64>,
    start: Start,
    /// The last gap where it was late, in ns, and the heartbeat that ended it.
    late: Option<(i64, FrameRef)>,
    /// The last frame that explains another period: a reset, or a write to 1017h.
    reconfigured: Option<FrameRef>,
    lost: bool,
    /// The last heartbeat may be one that stands in the capture a second time: its time teaches nothing.
    suspect: bool,
    duplicate: DuplicateId,
}

/// The beginning of a producer whose 1017h is not known: a boot-up, after which the period may be another one. The
/// second heartbeat tells.
#[derive(Clone, Copy, Debug, Default)]
enum Start {
    #[default]
    Over,
    Booted(When),
    /// The gap from the boot-up to the first heartbeat, in ns, and that.
    First(i64, FrameRef),
}

/// The heartbeat producers of a bus.
#[derive(Debug, Default)]
pub struct Heartbeats {
    producers: PerNode<Producer>,
    owed: Obligations<u8>,
    /// The last silence of the whole bus in which heartbeats were due, and the frame at which that was seen.
    silence: Option<(Silence, FrameRef)>,
    /// How many nodes had one due, until it is reported.
    missing: u64,
    /// The end of the last silence that was looked at, in ns.
    looked_ns: i64,
}

impl Heartbeats {
    /// How often a node sends heartbeats, in ns.
    pub fn period(&self, node: u8) -> Option<i64> {
        self.producers.get(node)?.expected()
    }

    /// Whether no heartbeat of a node has come within its time, at `now_ns`: it counts as lost, or would if it were not
    /// the whole bus that is silent. Not of a node that was reset, or is not watched for another reason.
    pub fn is_overdue(&self, node: u8, now_ns: i64) -> bool {
        let Some(producer) = self.producers.get(node) else { return false };
        let last = producer.last.and_then(|last| last.at.t_ns);
        let late = |limit: i64| last.is_some_and(|last| now_ns.saturating_sub(last) > limit);
        producer.lost || producer.limit().is_some_and(late)
    }

    /// Whether a node's heartbeats are even: it is a producer, not one that answers guarding.
    pub fn is_producer(&self, node: u8) -> bool {
        self.producers.get(node).is_some_and(|producer| producer.period.learnt_ns().is_some())
    }

    /// Whether 1017h is known to be other than 0: the node sends heartbeats.
    pub fn is_configured(&self, node: u8) -> bool {
        self.producers.get(node).is_some_and(|producer| producer.period.configured_ns().is_some())
    }

    /// What is known of 1016h and 1017h of the bus's nodes, after a change.
    pub fn configure(&mut self, nodes: &PerNode<Node>) {
        let mut consumers = [None; 128];
        for (_, node) in nodes.iter() {
            for sub in CONSUMED {
                let Some((value, from)) = node.value(0x1016, sub) else { continue };
                let (watched, ms) = ((value >> 16) as usize & 0x7F, (value & 0xFFFF) as i64);
                if from > Provenance::Eds
                    && ms > 0
                    && let Some(slot) = consumers.get_mut(watched)
                {
                    let time = ms * 1_000_000;
                    *slot = Some(slot.map_or(time, |before: i64| before.min(time)));
                }
            }
        }
        for (id, consumer) in (0..).zip(consumers) {
            let produced = nodes.get(id).and_then(|node| node.value(0x1017, 0));
            let configured = produced.filter(|(_, from)| *from > Provenance::Eds);
            let configured = configured.map(|(ms, _)| (ms & 0xFFFF) as i64 * 1_000_000);
            if consumer.is_none() && configured.is_none() && self.producers.get(id).is_none() {
                continue;
            }
            let producer = self.producers.entry(id);
            producer.consumer = consumer;
            producer.configure(configured);
            if producer.off && producer.period.learnt_ns().is_none() {
                self.owed.met(id);
            }
        }
    }

    /// 1017h of a node is being written; `ns`: the new period.
    pub fn written(&mut self, node: u8, ns: i64, cx: &Context<'_>) {
        let Some(producer) = self.producers.get_mut(node) else { return };
        (producer.reconfigured, producer.start) = (Some(cx.at), Start::Over);
        let before = producer.expected().unwrap_or(0);
        // The write starts the period anew.
        (producer.last, producer.held) = (None, None);
        if !alike(before, ns) {
            producer.period.forget();
        }
        // Where the server refuses it, the old period goes on.
        if self.owed.met(node).is_some() && ns > 0 {
            let limit_ns = 3 * before.max(ns) + slack(before.max(ns), Confidence::Configured);
            self.owed.open(node, Owed { since: cx.when, limit_ns, why: Some(cx.at) });
        }
    }

    /// A node (or all, 0) is reset or goes silent by command: it is watched again from its next heartbeat on.
    pub fn pause(&mut self, node: u8, at: FrameRef) {
        for (id, producer) in self.producers.iter_mut() {
            if node == 0 || node == id {
                producer.pause();
                producer.reconfigured = Some(at);
            }
        }
        self.owed.void(|id| node == 0 || node == *id);
    }

    /// A node has booted: where it is known to send heartbeats it owes the first one from here on.
    pub fn booted(&mut self, node: u8, cx: &mut Context<'_>) {
        self.pause(node, cx.at);
        let Some(producer) = self.producers.get_mut(node) else { return };
        cx.evidence.circumstances.over(Kind::NodeLost, node);
        if producer.period.configured_ns().is_some() {
            producer.last = Some(cx.when);
            if let Some(limit_ns) = producer.limit() {
                self.owed.open(node, Owed { since: cx.when, limit_ns, why: Some(cx.at) });
            }
        } else if producer.period.learnt_ns().is_some() {
            producer.start = Start::Booted(cx.when);
        }
    }

    /// A frame with bit 7 from a node that sends heartbeats: no guarding answer where nobody asks.
    /// It is a heartbeat all the same, but its state counts for nothing.
    pub fn bit_7(&mut self, byte: u8, node: u8, cx: &mut Context<'_>) {
        cx.find(Code::Hbt003, Some(node), None, None, Facts::told(1, &[("found", Quantity::Hex2(byte))]));
        self.alive(node, cx);
    }

    /// A heartbeat whose state counts for nothing.
    pub fn alive(&mut self, node: u8, cx: &mut Context<'_>) {
        if let Some(state) = self.producers.get(node).and_then(|producer| producer.state) {
            self.heartbeat(node, state, cx);
        }
    }

    /// The network was switched on: all nodes have their time to boot.
    pub fn power_up(&mut self, cx: &Context<'_>) {
        let owing: Vec<(u8, Owed)> =
            self.producers.iter().filter_map(|(id, _)| Some((id, *self.owed.get(id)?))).collect();
        for (id, owed) in owing {
            self.owed.open(id, Owed { since: cx.when, limit_ns: owed.limit_ns.max(POWER_UP_NS), ..owed });
        }
    }

    /// A command: a change of state says nothing of a second node.
    pub fn commanded(&mut self, node: u8) {
        for (id, producer) in self.producers.iter_mut() {
            if node == 0 || node == id {
                producer.duplicate.commanded();
            }
        }
    }

    /// Says whether a state is one that CiA 301 knows; the first of several of another one is a finding.
    pub fn known_state(&mut self, node: u8, state: u8, cx: &mut Context<'_>) -> bool {
        let known = matches!(state, STOPPED | OPERATIONAL | PRE_OPERATIONAL);
        let producer = self.producers.entry(node);
        let unknown = Some(state).filter(|_| !known);
        if let Some(state) = unknown
            && producer.unknown != unknown
        {
            cx.find(Code::Hbt003, Some(node), None, None, Facts::told(0, &[("found", Quantity::Hex2(state))]));
        }
        producer.unknown = unknown;
        known
    }

    /// A heartbeat of a node.
    pub fn heartbeat(&mut self, node: u8, state: u8, cx: &mut Context<'_>) {
        let known = self.known_state(node, state, cx);
        let silence = self.silence.map(|(silence, _)| silence);
        let producer = self.producers.entry(node);
        let before = producer.state.replace(state);
        let changed = before.is_some_and(|before| before != state);
        if std::mem::take(&mut producer.lost) {
            producer.last = None;
            cx.evidence.circumstances.over(Kind::NodeLost, node);
        }
        let last = producer.last.replace(cx.when);
        if let Some(last) = last {
            producer.duplicate.state(node, changed && known, (before, state), last.at, cx);
            producer.gap(node, last, changed, silence, cx);
        }
        producer.begin(node, last.is_some(), cx);
        match producer.limit() {
            Some(limit_ns) => self.owed.open(node, Owed { since: cx.when, limit_ns, why: None }),
            None => drop(self.owed.met(node)),
        }
    }

    /// It is `now_ns`: who should have been heard and was not. `heard`: a frame says so, and not only the clock.
    #[inline]
    pub fn advance(&mut self, now_ns: i64, heard: bool, cx: &mut Context<'_>) {
        let now = match heard {
            true => cx.when,
            false => When { at: FrameRef { t_ns: Some(now_ns), ..cx.at }, ..cx.evidence.recording.at(cx.at) },
        };
        self.look(now_ns, cx);
        let due = self.owed.due(now, &cx.evidence.recording);
        if !due.is_empty() {
            self.overdue(now, due, heard, cx);
        }
    }

    /// Looks at a silence of the whole bus, once: in how many nodes' heartbeats were due.
    fn look(&mut self, now_ns: i64, cx: &Context<'_>) {
        let Some(silence) = cx.evidence.recording.silence(now_ns) else { return };
        if let Some((known, _)) = &mut self.silence
            && known.from_ns == silence.from_ns
        {
            *known = silence;
        }
        if std::mem::replace(&mut self.looked_ns, silence.to_ns) == silence.to_ns {
            return;
        }
        let owing = self.producers.iter().filter(|(id, _)| self.owed.get(*id).is_some());
        let missing = owing.filter(|(_, producer)| producer.misses(silence)).count() as u64;
        if missing > 1 || missing > 0 && silence.long {
            (self.silence, self.missing) = (Some((silence, cx.at)), missing);
        }
    }

    /// Judges what is overdue: who should have come in a silence of the whole bus has as long as anew.
    fn overdue(&mut self, now: When, due: Vec<(u8, Owed)>, heard: bool, cx: &mut Context<'_>) {
        for (node, owed) in due {
            let fell = owed.since.at.t_ns.map(|since| since.saturating_add(owed.limit_ns));
            let within = |silence: &Silence| fell.is_some_and(|fell| silence.from_ns < fell && fell <= silence.to_ns);
            if let Some((silence, at)) = self.silence.filter(|(silence, _)| within(silence)) {
                let missing = std::mem::take(&mut self.missing);
                if missing > 0 && !silence.stalled {
                    let facts = [("silence", Quantity::Ns(silence.ns())), ("nodes", Quantity::Count(missing))];
                    cx.find_at(at, Code::Hbt005, None, None, None, Facts::told(0, &facts));
                }
                self.owed.open(node, Owed { since: now, ..owed });
            } else if !heard && self.producers.iter().filter(|(id, _)| self.owed.get(*id).is_some()).count() > 0 {
                // Where nobody else is heard either, it shows soon whether the others are silent as well.
                self.owed.open(node, owed);
            } else {
                self.lose(node, now, owed, cx);
            }
        }
    }

    fn lose(&mut self, node: u8, now: When, owed: Owed, cx: &mut Context<'_>) {
        let Some(producer) = self.producers.get_mut(node) else { return };
        producer.lost = true;
        let last = producer.last.unwrap_or(owed.since);
        let age = cx.evidence.recording.between(last, now).unwrap_or(0);
        let facts = [("silence", Quantity::Ns(age)), ("limit", Quantity::Ns(owed.limit_ns))];
        let face = u8::from(producer.consumer.is_none_or(|time| time < owed.limit_ns));
        cx.find(Code::Hbt002, Some(node), None, Some(last.at), Facts::told(face, &facts));
        cx.evidence.circumstances.note(Kind::NodeLost, Some(node), cx.when);
    }

    /// Frames were lost: heartbeats may be among them.
    pub fn forget(&mut self) {
        for (_, producer) in self.producers.iter_mut() {
            producer.pause();
        }
        self.owed.void(|_| true);
    }
}

impl Producer {
    fn configure(&mut self, configured: Option<i64>) {
        let before = self.period.configured_ns();
        self.off = configured == Some(0);
        self.period.configure(configured);
        let same =
            configured == before || configured.is_some_and(|ns| self.period.learnt_ns().is_some_and(|l| alike(l, ns)));
        if !same {
            self.period.forget();
            (self.held, self.late) = (None, None);
            self.last = self.last.filter(|_| configured.is_some_and(|ns| ns > 0));
            self.duplicate = DuplicateId::default();
        }
    }

    /// It is not watched until its next heartbeat.
    fn pause(&mut self) {
        self.period.distrust();
        (self.last, self.held, self.state, self.late) = (None, None, None, None);
        (self.lost, self.start) = (false, Start::Over);
        self.duplicate = DuplicateId::default();
    }

    fn expected(&self) -> Option<i64> {
        Some(self.period.expected()?.ns)
    }

    /// By how much a heartbeat may be late, in ns.
    fn slack(&self) -> i64 {
        self.period.expected().map_or(LEAST_SLACK_NS, |known| slack(known.ns, known.confidence) + known.deviation_ns)
    }

    /// How long it may be silent, in ns; `None`: for ever.
    fn limit(&self) -> Option<i64> {
        if self.off && self.period.learnt_ns().is_none() {
            return None;
        }
        match (self.consumer, self.expected()) {
            (Some(time), Some(period)) => Some(time.max(period + self.slack())),
            (None, Some(period)) => Some(3 * period + self.slack()),
            (time, None) => time,
        }
    }

    /// Whether a heartbeat was due in a silence.
    fn misses(&self, silence: Silence) -> bool {
        let wait = self.expected().or(self.consumer).unwrap_or(0);
        let due = self.last.and_then(|last| last.at.t_ns).map(|last| last.saturating_add(wait));
        let missed =
            |due: i64| due.saturating_add(self.slack()) > silence.from_ns && due + LEAST_SLACK_NS < silence.to_ns;
        due.is_some_and(missed)
    }

    /// Judges the gap between two heartbeats, and learns from it. Those of a burst have no times of their own: the gap
    /// from the last one before it is judged, with as many heartbeats in it as the burst has brought.
    fn gap(&mut self, node: u8, last: When, changed: bool, silence: Option<Silence>, cx: &mut Context<'_>) {
        let recording = &cx.evidence.recording;
        let stalled = |when: When| recording.verdict(when.burst) == Some(Verdict::Confirmed);
        let held = self.held.take();
        let (since, count) = held.filter(|_| stalled(last)).map_or((last, 1), |(since, count)| (since, count + 1));
        if !recording.teaches(cx.when) {
            self.held = Some(held.filter(|_| stalled(last)).map_or((last, 1), |(since, count)| (since, count + 1)));
        }
        let Some(gap) = recording.between(since, cx.when).filter(|gap| *gap > 0 && !stalled(cx.when)) else {
            return self.duplicate.interrupt();
        };
        let across = self.across(since, silence, cx).filter(|silence| !(silence.stalled && count > 1));
        if let Some(period) = self.expected() {
            let due = count * (period + if count > 1 { period / 32 } else { 0 });
            let limit = due + self.slack() + across.map_or(0, Silence::ns);
            let late = recording.certainly_later(cx.when, since, limit);
            self.judge(node, (gap, period, count), late, cx);
        }
        let recording = &cx.evidence.recording;
        let suspect = cx.sighting == Sighting::Suspect;
        let suspect = std::mem::replace(&mut self.suspect, suspect) || suspect;
        if count == 1
            && gap > BUFFERED_NS
            && !suspect
            && !changed
            && across.is_none()
            && recording.teaches(cx.when)
            && recording.teaches(last)
        {
            self.learn(node, gap, last, cx);
        } else {
            self.duplicate.interrupt();
        }
    }

    /// The silence of the whole bus in which a heartbeat was due: one that others missed theirs in as well, that was
    /// longer than the period, or that has ended with this heartbeat.
    fn across(&self, since: When, known: Option<Silence>, cx: &Context<'_>) -> Option<Silence> {
        let (from, to) = (since.at.t_ns?, cx.at.t_ns?);
        let fits = |silence: &Silence| from <= silence.from_ns && silence.to_ns <= to;
        let period = self.expected().unwrap_or(i64::MAX);
        let its_own = |silence: &Silence| silence.ns() > period || to - silence.to_ns <= LEAST_SLACK_NS;
        let last = cx.evidence.recording.silence(to).filter(|silence| fits(silence) && its_own(silence));
        known.filter(fits).or(last)
    }

    fn judge(&mut self, node: u8, (gap, period, count): (i64, i64, i64), late: bool, cx: &mut Context<'_>) {
        // Gaps that stay as long are one fault.
        let again = self.late.is_some_and(|(before, _)| alike(before, gap));
        let first = self.late.filter(|_| again).map_or(cx.at, |(_, first)| first);
        self.late = late.then_some((gap, first));
        if !late || again || self.duplicate.is_found() {
            return;
        }
        let mut facts = vec![("found", Quantity::Ns(gap)), ("expected", Quantity::Ns(period))];
        if count > 1 {
            facts.push(("heartbeats", Quantity::Count(count as u64)));
        }
        let finding = cx.finding(Code::Hbt001, Some(node), None, None, Facts::told(u8::from(count > 1), &facts));
        cx.report_timed(finding);
    }

    /// Takes the gap between two heartbeats in the same state.
    fn learn(&mut self, node: u8, gap: i64, last: When, cx: &mut Context<'_>) {
        let uncertain = cx.evidence.recording.grain_ns();
        let gap = match self.duplicate.gap(node, gap, last.at, &self.period, uncertain, cx) {
            Place::InTurn(gap) => gap,
            Place::Additional => return,
        };
        let Learnt::Changed { from_ns, to_ns, since } = self.period.take(gap, uncertain, cx.at) else { return };
        let began = since.t_ns.unwrap_or(0).saturating_sub(to_ns + 2 * from_ns);
        let explained = self.reconfigured.is_some_and(|at| at.t_ns.unwrap_or(0) >= began);
        if explained || alike(from_ns, to_ns) || self.duplicate.is_found() {
            return;
        }
        if alike(from_ns, 2 * to_ns) {
            return self.duplicate.halved(node, from_ns, last.at, cx);
        }
        let facts = [("from", Quantity::Ns(from_ns)), ("to", Quantity::Ns(to_ns))];
        let finding = cx.finding(Code::Hbt007, Some(node), None, None, Facts::told(0, &facts));
        // Its first gap was late already.
        let because_of = self.late.map(|(_, first)| first);
        cx.report_timed(Finding { at: since, because_of, ..finding });
    }

    /// The first heartbeats after a boot-up. Where the second shows that the period is the one before, the first was
    /// due after that.
    fn begin(&mut self, node: u8, second: bool, cx: &mut Context<'_>) {
        match self.start {
            Start::Booted(boot) if !second => {
                let gap = cx.evidence.recording.between(boot, cx.when);
                self.start = gap.map_or(Start::Over, |gap| Start::First(gap, cx.at));
            }
            Start::First(gap, at) => {
                self.start = Start::Over;
                let Some(period) = self.expected() else { return };
                let late = gap > period + self.slack() && self.late.is_none();
                if late && cx.evidence.recording.teaches(cx.when) {
                    let facts = [("found", Quantity::Ns(gap)), ("expected", Quantity::Ns(period))];
                    let finding = cx.finding(Code::Hbt001, Some(node), None, None, Facts::told(0, &facts));
                    cx.report_timed(Finding { at, ..finding });
                }
            }
            Start::Over | Start::Booted(_) => {}
        }
    }
}

/// What a gap may exceed its period by, in ns.
fn slack(period: i64, confidence: Confidence) -> i64 {
    let percent = if confidence == Confidence::Certain { 30 } else { 45 };
    (period * percent / 100).max(LEAST_SLACK_NS)
}

/// Whether two times differ by no more than an eighth.
fn alike(one: i64, other: i64) -> bool {
    one.abs_diff(other) <= (one.max(other) / 8).unsigned_abs()
}

//! Heartbeats (CiA 301, 7.2.8.3.2): late, lost, in an unknown state, or of two nodes with one node-ID.
//!
//! A producer is watched from its first heartbeat on, as consumers do. How often it sends is what the capture shows of
//! 1017h (or a DCF says), else what its heartbeats themselves show once they are even; where both disagree the
//! heartbeats are right. It counts as lost when a consumer's time (1016h) is over, or after three periods. More
//! heartbeats than due are legal. Where the whole bus falls silent nobody is lost yet: a recording may have stalled.
//! Verdicts need stamps, but for states.

use crate::configuration::Provenance;
use crate::context::Context;
use crate::evidence::recording::Verdict;
use crate::finding::{Code, Facts, Quantity};
use crate::frame::FrameRef;
use crate::node::{Node, PerNode};
use crate::services::heartbeat::{OPERATIONAL, PRE_OPERATIONAL, STOPPED};

/// No heartbeat has a longer period: 1017h holds 65.535 s at most. Longer gaps say nothing more.
const LONGEST_NS: i64 = 600_000_000_000;
/// Gaps between heartbeats that are kept.
const GAPS: usize = 8;
/// Even gaps that make a period.
const EVEN: usize = 3;
/// Even gaps that tell a rate.
const RATE: usize = 6;
/// Least tolerance of a period in ns: what hosts and small controllers are late by now and then.
const LEAST_SLACK_NS: i64 = 20_000_000;
/// A bus silent for this long was not recorded, whoever else might have spoken.
pub(super) const PAUSE_NS: i64 = 10_000_000_000;
/// A silence of so many mean gaps between frames concerns the whole bus.
const UNUSUAL: i64 = 10;
/// Gaps that alternate differ by more than this: below, a loaded host's stamps do the same.
const APART_NS: i64 = 10_000_000;
/// Two heartbeats closer than this may be one that was captured twice, in ns.
pub(super) const TWICE_NS: i64 = 5_000_000;
/// Sub-indices of 1016h.
const CONSUMED: std::ops::RangeInclusive<u8> = 1..=127;

/// One producer.
#[derive(Debug)]
struct Producer {
    last: FrameRef,
    /// Time of the last heartbeat; `None` while the node is not watched.
    last_ns: Option<i64>,
    state: Option<u8>,
    /// The last state, where CiA 301 does not know it.
    unknown: Option<u8>,
    /// Gaps between heartbeats without change of state, latest last.
    gaps: Vec<i64>,
    /// What the gaps have shown.
    learnt: Option<i64>,
    /// What 1017h holds, by the capture or a DCF; 0 = off.
    configured: Option<i64>,
    /// The time of the consumer that waits shortest, in ns.
    consumer: Option<i64>,
    /// When it is lost.
    deadline: i64,
    lost: bool,
    /// By how much gaps have lately differed from the period, in ns: what the stamps are worth.
    wobble: i64,
    /// Nothing was judged yet since it is watched anew.
    fresh: bool,
    /// The next gap is not judged: it was lost, the bus was silent, or it has just been late.
    excused: bool,
    /// Changes of state in a row, each to the state before.
    alternations: u8,
    before: Option<u8>,
    /// It was said that two nodes share the node-ID.
    doubled: bool,
}

impl Default for Producer {
    fn default() -> Self {
        Self {
            last: FrameRef::default(),
            last_ns: None,
            state: None,
            unknown: None,
            gaps: Vec::new(),
            learnt: None,
            configured: None,
            consumer: None,
            deadline: i64::MAX,
            lost: false,
            wobble: 0,
            fresh: false,
            excused: false,
            alternations: 0,
            before: None,
            doubled: false,
        }
    }
}

/// How lively the bus is: what a silence is measured by.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pulse {
    /// Time of the last frame.
    pub last_ns: Option<i64>,
    /// Mean gap between frames in ns.
    pub gap_ns: i64,
    /// How many gaps it is the mean of.
    gaps: u8,
    /// From when to when the recording stood still last: what was sent meanwhile comes in a burst after it.
    pub stall: Option<(i64, i64)>,
}

impl Pulse {
    /// Takes the time of a frame.
    #[inline]
    pub fn beat(&mut self, now_ns: i64) {
        if let Some(last) = self.last_ns {
            let gap = now_ns.saturating_sub(last).clamp(0, PAUSE_NS);
            // At first of all gaps so far, then of the latest.
            self.gap_ns += if self.gaps < 16 {
                self.gaps += 1;
                (gap - self.gap_ns) / i64::from(self.gaps)
            } else {
                (gap - self.gap_ns) / 16
            };
        }
        self.last_ns = Some(now_ns);
    }

    /// For how long the bus was silent, in ns.
    pub fn silence(&self, now_ns: i64) -> i64 {
        self.last_ns.map_or(0, |last| now_ns.saturating_sub(last).max(0))
    }
}

/// The heartbeat producers of a bus.
#[derive(Debug)]
pub struct Heartbeats {
    producers: PerNode<Producer>,
    /// The earliest deadline, or earlier.
    next: i64,
    /// The silence that was said: the time of the frame before it.
    silence: Option<i64>,
    jitter_ns: i64,
}

impl Default for Heartbeats {
    fn default() -> Self {
        Self { producers: PerNode::default(), next: i64::MAX, silence: None, jitter_ns: 0 }
    }
}

impl Heartbeats {
    /// Producers that are judged with at least this tolerance (`--jitter`).
    pub fn new(jitter_ns: Option<i64>) -> Self {
        Self { jitter_ns: jitter_ns.unwrap_or(0), ..Self::default() }
    }

    /// How often a node sends heartbeats, in ns.
    pub fn period(&self, node: u8) -> Option<i64> {
        self.producers.get(node)?.period()
    }

    /// Whether no heartbeat of a node has come within its time, at `now_ns`: it counts as lost, or would if it were not
    /// the whole bus that is silent. Not of a node that was reset, or is not watched for another reason.
    pub fn is_overdue(&self, node: u8, now_ns: i64) -> bool {
        let Some(producer) = self.producers.get(node) else { return false };
        let off = producer.configured == Some(0) && producer.learnt.is_none();
        let limit = producer.limit(self.jitter_ns.max(LEAST_SLACK_NS) + producer.wobble);
        let late = |last: i64| !off && now_ns.saturating_sub(last) > limit;
        producer.lost || producer.last_ns.is_some_and(late)
    }

    /// Whether a node's heartbeats are even: it is a producer, not one that answers guarding.
    pub fn is_producer(&self, node: u8) -> bool {
        self.producers.get(node).is_some_and(|producer| producer.learnt.is_some())
    }

    /// Whether 1017h is known to be other than 0: the node sends heartbeats.
    pub fn is_configured(&self, node: u8) -> bool {
        self.producers.get(node).is_some_and(|producer| producer.configured.is_some_and(|period| period > 0))
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
            if producer.configured != configured {
                producer.configured = configured;
                producer.restart();
            }
        }
    }

    /// A node's 1017h is being written: what its heartbeats have shown holds no more.
    pub fn unsettle(&mut self, node: u8) {
        if let Some(producer) = self.producers.get_mut(node) {
            producer.restart();
        }
    }

    /// A node (or all, 0) is reset or goes silent by command: it is watched again from its next heartbeat on.
    pub fn pause(&mut self, node: u8) {
        for (id, producer) in self.producers.iter_mut() {
            if node == 0 || node == id {
                producer.restart();
                (producer.last_ns, producer.state, producer.before, producer.alternations) = (None, None, None, 0);
            }
        }
    }

    /// A frame with bit 7 from a node that sends heartbeats: no guarding answer where nobody asks.
    /// It is a heartbeat all the same, but its state counts for nothing.
    pub fn bit_7(&mut self, byte: u8, node: u8, pulse: Pulse, cx: &mut Context<'_>) {
        cx.find(Code::Hbt003, Some(node), None, None, Facts::told(1, &[("found", Quantity::Hex2(byte))]));
        self.alive(node, pulse, cx);
    }

    /// A heartbeat whose state counts for nothing.
    pub fn alive(&mut self, node: u8, pulse: Pulse, cx: &mut Context<'_>) {
        if let Some(state) = self.producers.get(node).and_then(|producer| producer.state) {
            self.beat(node, state, pulse, cx);
        }
    }

    /// The network was switched on: nobody is lost before `until`.
    pub fn grant(&mut self, until: i64) {
        for (_, producer) in self.producers.iter_mut().filter(|(_, producer)| producer.deadline < i64::MAX) {
            producer.deadline = producer.deadline.max(until);
        }
    }

    /// A command: a change of state says nothing of a second node.
    pub fn commanded(&mut self, node: u8) {
        for (id, producer) in self.producers.iter_mut() {
            if node == 0 || node == id {
                producer.alternations = 0;
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
    pub fn beat(&mut self, node: u8, state: u8, pulse: Pulse, cx: &mut Context<'_>) {
        let known = self.known_state(node, state, cx);
        let producer = self.producers.entry(node);
        let slack_ns = self.jitter_ns.max(LEAST_SLACK_NS) + producer.wobble;
        let changed = producer.state.is_some_and(|before| before != state);
        let (last, before) = (producer.last, producer.state.replace(state));
        producer.alternate(node, changed && known, before, state, last, cx);
        producer.last = cx.at;
        let Some(now) = cx.at.t_ns else { return };
        if !changed && producer.is_twice(now) {
            return;
        }
        if cx.evidence.recording.verdict(cx.when.burst) == Some(Verdict::Confirmed) {
            // The recorder stood still: the time tells nothing of the node but that it is there.
            producer.gaps.clear();
            producer.last_ns = Some(now);
            (producer.excused, producer.lost) = (true, false);
            return producer.await_next(slack_ns, &mut self.next);
        }
        let Some(last_ns) = producer.last_ns.replace(now) else { return producer.await_next(slack_ns, &mut self.next) };
        let gap = now.saturating_sub(last_ns);
        let excused = std::mem::take(&mut producer.excused) | std::mem::take(&mut producer.lost);
        let fresh = std::mem::take(&mut producer.fresh);
        if gap <= 0 {
            producer.gaps.clear();
        } else if let Some(period) = producer.period()
            && gap > period + slack(period, slack_ns)
        {
            // It was not the node but the recording that stood still.
            let stalled = pulse.stall.is_some_and(|(from, to)| {
                producer.missed(last_ns.saturating_add(period), from, to) && now.saturating_sub(to) <= LEAST_SLACK_NS
            });
            if !excused && !stalled && !producer.doubled {
                let facts = [("found", Quantity::Ns(gap)), ("expected", Quantity::Ns(period))];
                let finding = cx.finding(Code::Hbt001, Some(node), None, None, Facts::told(0, &facts));
                cx.report_timed(finding);
            }
            // Gaps that stay long are another period, learnt in time.
            if !excused {
                producer.gaps.clear();
            }
            if !stalled {
                producer.learn(node, gap, last, cx);
            }
            // The gap after a change is no excuse for the next.
            producer.excused = !fresh;
        } else if changed || excused {
            producer.gaps.clear();
        } else {
            producer.waver(gap);
            producer.learn(node, gap, last, cx);
        }
        producer.await_next(slack_ns, &mut self.next);
    }

    /// It is `now_ns`: who should have been heard and was not. `heard`: a frame says so, and not only the clock.
    #[inline]
    pub fn advance(&mut self, now_ns: i64, heard: bool, pulse: Pulse, cx: &mut Context<'_>) {
        if now_ns >= self.next {
            self.sweep(now_ns, heard, pulse, cx);
        }
    }

    /// The bus is heard again at `now_ns`, of which it was said that it is silent: who was due meanwhile has as long as
    /// anew.
    pub fn resume(&mut self, now_ns: i64, pulse: Pulse) {
        if self.silence.is_none() || self.silence != pulse.last_ns {
            return;
        }
        let slack_ns = self.jitter_ns.max(LEAST_SLACK_NS);
        for (_, producer) in self.producers.iter_mut().filter(|(_, producer)| producer.deadline < i64::MAX) {
            let limit = producer.limit(slack_ns);
            if producer.last_ns.is_some_and(|last| last.saturating_add(limit) <= now_ns) {
                producer.deadline = now_ns.saturating_add(limit);
            }
        }
    }

    fn sweep(&mut self, now_ns: i64, frame: bool, pulse: Pulse, cx: &mut Context<'_>) {
        let heard = pulse.last_ns.unwrap_or(now_ns);
        let silence = pulse.silence(now_ns);
        let overdue =
            |producer: &Producer| producer.deadline <= now_ns && producer.missed(producer.due(), heard, now_ns);
        let silent = self.missing(heard, now_ns);
        let everybody =
            silent > 1 || silent > 0 && (silence > PAUSE_NS || silence > pulse.gap_ns.saturating_mul(UNUSUAL));
        let everybody = everybody && self.producers.iter().any(|(_, producer)| overdue(producer));
        if everybody && self.silence != Some(heard) {
            self.silence = Some(heard);
            let facts = [("silence", Quantity::Ns(silence)), ("nodes", Quantity::Count(silent as u64))];
            cx.find(Code::Hbt005, None, None, None, Facts::told(0, &facts));
        }
        // Where nobody else is heard either, it shows soon whether the others are silent as well.
        let others = self.producers.iter().filter(|(_, producer)| producer.deadline < i64::MAX).count() > 1;
        let open = !frame && others && !everybody;
        let mut next = i64::MAX;
        for (node, producer) in self.producers.iter_mut() {
            if producer.deadline <= now_ns && !(open && overdue(producer)) {
                if everybody && overdue(producer) {
                    // Who does not come back now is lost.
                    producer.excused = true;
                    producer.deadline = now_ns.saturating_add(producer.limit(self.jitter_ns.max(LEAST_SLACK_NS)));
                } else {
                    producer.deadline = i64::MAX;
                    producer.lost = true;
                    let age = now_ns.saturating_sub(producer.last_ns.unwrap_or(now_ns));
                    let limit = producer.limit(self.jitter_ns.max(LEAST_SLACK_NS));
                    let facts = [("silence", Quantity::Ns(age)), ("limit", Quantity::Ns(limit))];
                    let face = u8::from(producer.consumer.is_none_or(|time| time < limit));
                    let finding =
                        cx.finding(Code::Hbt002, Some(node), None, Some(producer.last), Facts::told(face, &facts));
                    cx.report_timed(finding);
                }
            }
            next = next.min(producer.deadline);
        }
        self.next = next;
    }

    /// Frames were lost.
    pub fn forget(&mut self) {
        self.pause(0);
    }

    /// Whether it was the recording that stood still, and not the bus, while nothing was heard from `from` to `to`:
    /// several heartbeats were due, or one on a bus that else is lively.
    pub fn stalled(&self, from: i64, to: i64, pulse: Pulse) -> bool {
        let silence = to.saturating_sub(from);
        silence > LEAST_SLACK_NS && {
            let missing = self.missing(from, to);
            missing > 1 || missing > 0 && silence > pulse.gap_ns.saturating_mul(UNUSUAL)
        }
    }

    /// How many heartbeats were due while nothing was heard from `from` to `to`.
    fn missing(&self, from: i64, to: i64) -> usize {
        let watched = self.producers.iter().filter(|(_, producer)| producer.deadline < i64::MAX);
        watched.filter(|(_, producer)| producer.missed(producer.due(), from, to)).count()
    }
}

impl Producer {
    /// What was learnt holds no more.
    fn restart(&mut self) {
        self.gaps.clear();
        (self.learnt, self.deadline) = (None, i64::MAX);
        (self.lost, self.excused, self.doubled, self.fresh) = (false, true, false, true);
    }

    fn period(&self) -> Option<i64> {
        self.learnt.or(self.configured.filter(|period| *period > 0))
    }

    /// Whether a heartbeat that was due at `due` is missing from a silence.
    fn missed(&self, due: i64, from: i64, to: i64) -> bool {
        let slack = slack(self.period().unwrap_or(0), LEAST_SLACK_NS);
        due.saturating_add(slack) > from && due.saturating_add(LEAST_SLACK_NS) < to
    }

    /// Whether a heartbeat is the last one captured twice, or one of several that a recording kept back and gave at
    /// once.
    fn is_twice(&self, now: i64) -> bool {
        let limit = self.period().map_or(TWICE_NS, |period| TWICE_NS.min(period / 2));
        self.last_ns.is_some_and(|last| (0..limit).contains(&now.saturating_sub(last)))
    }

    /// Takes by how much a gap differs from the period.
    fn waver(&mut self, gap: i64) {
        if let Some(period) = self.period() {
            let off = gap.saturating_sub(period).saturating_abs().min(LEAST_SLACK_NS);
            self.wobble = off.max(self.wobble - self.wobble / 16);
        }
    }

    /// When its next heartbeat should come.
    fn due(&self) -> i64 {
        let wait = self.period().or(self.consumer).unwrap_or(0);
        self.last_ns.unwrap_or(i64::MAX).saturating_add(wait)
    }

    /// How long it may be silent.
    fn limit(&self, slack_ns: i64) -> i64 {
        match (self.consumer, self.period()) {
            (Some(time), Some(period)) => time.max(period + slack(period, slack_ns)),
            (Some(time), None) => time,
            (None, Some(period)) => 3 * period + slack(period, slack_ns),
            (None, None) => i64::MAX,
        }
    }

    fn await_next(&mut self, slack_ns: i64, next: &mut i64) {
        let off = self.configured == Some(0) && self.learnt.is_none();
        let limit = if off { i64::MAX } else { self.limit(slack_ns) };
        self.deadline = self.last_ns.map_or(i64::MAX, |last| last.saturating_add(limit));
        *next = (*next).min(self.deadline);
    }

    /// Takes a gap between two heartbeats in the same state.
    fn learn(&mut self, node: u8, gap: i64, last: FrameRef, cx: &mut Context<'_>) {
        if self.gaps.len() == GAPS {
            self.gaps.remove(0);
        }
        // So that sums of them stay small, whatever the stamps.
        self.gaps.push(gap.min(LONGEST_NS));
        let recent = self.gaps.iter().rev().take(EVEN);
        if self.gaps.len() >= EVEN && even(recent.clone()) {
            let mean = recent.sum::<i64>() / EVEN as i64;
            // Stamps may waver; a period that has changed is another one at once.
            let same = self.learnt.filter(|learnt| (mean - learnt).abs() * 4 < *learnt);
            self.learnt = Some(same.map_or(mean, |learnt| learnt + (mean - learnt) / 4));
        }
        if self.doubled {
            return;
        }
        let odd = || self.gaps.iter().step_by(2);
        let other = || self.gaps.iter().skip(1).step_by(2);
        let half = (GAPS / 2) as i64;
        let (one, two) = (odd().sum::<i64>() / half, other().sum::<i64>() / half);
        let (whole, apart) = (one + two, (one - two).abs());
        let steady = spread(odd()).max(spread(other())) <= (whole / 40).max(2_000_000);
        let latest = || self.gaps.iter().rev().take(RATE);
        let mean = latest().sum::<i64>() / RATE as i64;
        if self.gaps.len() == GAPS && steady && one.min(two) > TWICE_NS && apart > APART_NS && apart * 4 > whole {
            self.doubled = true;
            let gaps = [("one", Quantity::Ns(one)), ("other", Quantity::Ns(two))];
            cx.find(Code::Hbt004, Some(node), None, Some(last), Facts::told(1, &gaps));
        } else if let Some(period) = self.configured.filter(|period| *period > 0)
            && self.gaps.len() >= RATE
            && even(latest())
            && (period * 2 / 5..=period * 3 / 5).contains(&mean)
        {
            self.doubled = true;
            let facts = [("found", Quantity::Ns(mean)), ("expected", Quantity::Ns(period))];
            cx.find(Code::Hbt004, Some(node), None, Some(last), Facts::told(2, &facts));
        }
    }

    /// Two nodes that share a node-ID show their states in turns.
    fn alternate(
        &mut self,
        node: u8,
        changed: bool,
        before: Option<u8>,
        state: u8,
        last: FrameRef,
        cx: &mut Context<'_>,
    ) {
        let back = changed && self.before.is_none_or(|earlier| earlier == state);
        self.alternations = if back { self.alternations.saturating_add(1) } else { 0 };
        if changed {
            self.before = before;
        }
        if self.alternations < 4 || self.doubled {
            return;
        }
        self.doubled = true;
        let facts = [("one", Quantity::State(before.unwrap_or(0))), ("other", Quantity::State(state))];
        cx.find(Code::Hbt004, Some(node), None, Some(last), Facts::told(0, &facts));
    }
}

/// What a gap may exceed its period by.
fn slack(period: i64, least_ns: i64) -> i64 {
    (period * 3 / 10).max(least_ns)
}

/// Whether gaps differ by no more than an eighth, or 4 ms.
fn even<'a>(gaps: impl Iterator<Item = &'a i64> + Clone) -> bool {
    let most = gaps.clone().max().copied().unwrap_or(0);
    spread(gaps) <= (most / 8).max(4_000_000)
}

/// By how much gaps differ.
fn spread<'a>(gaps: impl Iterator<Item = &'a i64> + Clone) -> i64 {
    let least = gaps.clone().min().copied().unwrap_or(0);
    gaps.max().copied().unwrap_or(0) - least
}

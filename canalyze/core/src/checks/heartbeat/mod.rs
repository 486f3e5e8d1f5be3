//! Heartbeats (CiA 301, 7.2.8.3.2): late, lost, in an unknown state, or with another period than before.
//!
//! A producer is watched from its first heartbeat on, as consumers do. How often it sends is what its heartbeats show,
//! and until they do, what the capture or a DCF shows of 1017h. It owes the next one, and counts as lost when a
//! consumer's time (1016h) is over, or after three periods. Additional heartbeats are legal. A silence of the whole bus
//! is nobody's fault: the time of a heartbeat that was expected in it starts again. Verdicts need stamps, but for
//! states. Two nodes with one node-ID are found in `duplicate_id`.

mod duplicate_id;

use std::collections::{BTreeMap, BTreeSet};

use self::duplicate_id::{DuplicateId, Place};
use crate::configuration::Provenance;
use crate::context::Context;
use crate::evidence::circumstance::Kind;
use crate::evidence::duplicates::Sighting;
use crate::evidence::obligation::Owed;
use crate::evidence::period::{Confidence, Expected, Learnt};
use crate::evidence::recording::Silence;
use crate::evidence::{Obligations, Period, When};
use crate::finding::Finding;
use crate::frame::FrameRef;
use crate::node::{Node, PerNode};
use crate::rules::heartbeat::{Hbt001, Hbt002, Hbt003, Hbt005, Hbt007};
use crate::wire::error_control::{OPERATIONAL, PRE_OPERATIONAL, STOPPED};

/// How late a producer may always be, in ns: what hosts and small controllers are by now and then.
const LEAST_SLACK_NS: i64 = 20_000_000;
/// Nodes that are switched on together are back within this time, in ns.
const POWER_UP_NS: i64 = 5_000_000_000;
/// The shortest period, in ns: 1017h counts in ms. What comes sooner was kept in a buffer, and shows no period.
const SHORTEST_NS: i64 = 1_000_000;
/// Gaps between heartbeats that show what the period was before it changed, where they differ from it by no more than this
/// part of it.
const SHOWN: usize = 3;
const EVEN_PART: i64 = 16;
/// Sub-indices of 1016h.
const CONSUMED: std::ops::RangeInclusive<u8> = 1..=127;

/// One producer.
#[derive(Debug, Default)]
struct Producer {
    /// The last heartbeat; `None` while the node is not watched.
    last: Option<When>,
    state: Option<u8>,
    /// The last state, where CiA 301 does not know it.
    unknown: Option<u8>,
    period: Period,
    /// The resolution of the stamps that it was learnt from, in ns.
    resolution_ns: i64,
    /// 1017h holds 0.
    off: bool,
    /// The time of the consumer that waits shortest, in ns.
    consumer: Option<i64>,
    start: Start,
    /// The last gap that was late, in ns, the heartbeat that ended the first like it, and gaps in time since.
    late: Option<(i64, FrameRef, u8)>,
    /// The frame that showed that it is lost, and how many heartbeats have come since. Two in time, and it is back.
    lost: Option<(FrameRef, u8)>,
    /// For how long the whole bus was silent since the last heartbeat while the next was expected, in ns.
    paused_ns: i64,
    /// The last heartbeat may be a duplicate.
    suspect: bool,
    duplicate: DuplicateId,
}

/// The beginning of a producer: a boot-up, after which the period may be another one. The second heartbeat shows which.
#[derive(Clone, Copy, Debug, Default)]
enum Start {
    #[default]
    Over,
    Booted(When),
    /// The gap from the boot-up to the first heartbeat, in ns, and that.
    First(i64, When),
}

/// The nodes that a node watches, with its times in ns, as far as more than an EDS says so.
fn consumed(node: &Node) -> Vec<(usize, i64)> {
    let known = CONSUMED.filter_map(|sub| node.value(0x1016, sub)).filter(|(_, from)| *from > Provenance::Eds);
    let watched = known.map(|(value, _)| ((value >> 16) as usize & 0x7F, (value & 0xFFFF) as i64 * 1_000_000));
    watched.filter(|(_, time)| *time > 0).collect()
}

/// The heartbeat producers of a bus.
#[derive(Debug, Default)]
pub struct Heartbeats {
    producers: PerNode<Producer>,
    owed: Obligations<u8>,
    /// When the last silence of the whole bus that was looked at ended, and when the last one that was reported began,
    /// in ns.
    looked_ns: i64,
    reported_ns: Option<i64>,
    /// What each node watches by 1016h: which nodes, and their times in ns.
    consumed: BTreeMap<u8, Vec<(usize, i64)>>,
    /// Nodes of which that is another thing by now.
    stale: BTreeSet<u8>,
}

impl Heartbeats {
    /// What a node watches is another thing now.
    pub fn watches_others(&mut self, node: u8) {
        self.stale.insert(node);
    }

    /// How often a node sends heartbeats, in ns.
    pub fn period(&self, node: u8) -> Option<i64> {
        let producer = self.producers.get(node)?;
        // Coarse stamps show a unit of theirs, whatever the period.
        let learnt = producer.expected().filter(|ns| *ns > producer.resolution_ns);
        learnt.or(producer.period.configured_ns())
    }

    /// Whether no heartbeat of a node has come within its time, at `now_ns`: it counts as lost, or would if it were not
    /// the whole bus that is silent. Not of a node that was reset, or is not watched for another reason.
    pub fn is_overdue(&self, node: u8, now_ns: i64) -> bool {
        let Some(producer) = self.producers.get(node) else { return false };
        let last = producer.last.and_then(|last| last.at.t_ns);
        let late = |limit: i64| last.is_some_and(|last| now_ns.saturating_sub(last) > limit);
        producer.is_lost() || producer.limit().is_some_and(late)
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
        for id in std::mem::take(&mut self.stale) {
            match nodes.get(id).map(consumed) {
                Some(watched) if !watched.is_empty() => _ = self.consumed.insert(id, watched),
                _ => _ = self.consumed.remove(&id),
            }
        }
        let mut consumers = [None; 128];
        for (watched, time) in self.consumed.values().flatten() {
            if let Some(slot) = consumers.get_mut(*watched) {
                *slot = Some(slot.map_or(*time, |before: i64| before.min(*time)));
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
        let before = producer.expected().unwrap_or(0);
        producer.period.doubt();
        (producer.last, producer.start, producer.late) = (None, Start::Over, None);
        // The write restarts the period. Where the server refuses it, the old one goes on.
        if self.owed.met(node).is_some() && ns > 0 {
            let period = before.max(ns);
            let limit_ns = period.saturating_mul(3).saturating_add(slack(period, Confidence::Configured));
            self.owed.open(node, Owed { since: cx.when, limit_ns, why: Some(cx.at) });
        }
    }

    /// A write of 1017h was acknowledged. Where its request was not seen the period may be any.
    pub fn acknowledged(&mut self, node: u8) {
        let Some(producer) = self.producers.get_mut(node) else { return };
        if self.owed.get(node).is_some_and(|owed| owed.why.is_none()) {
            producer.period.forget();
            producer.last = None;
            self.owed.met(node);
        }
    }

    /// A node (or all, 0) is reset or goes silent by command: it is watched again from its next heartbeat on.
    pub fn pause(&mut self, node: u8, cx: &mut Context<'_>) {
        for (id, producer) in self.producers.iter_mut().filter(|(id, _)| node == 0 || node == *id) {
            producer.pause();
            cx.evidence.pending.alive(id, false);
        }
        self.owed.void(|id| node == 0 || node == *id);
    }

    /// A node has booted.
    pub fn booted(&mut self, node: u8, cx: &mut Context<'_>) {
        self.pause(node, cx);
        cx.evidence.circumstances.over(Kind::NodeLost, node);
        if let Some(producer) = self.producers.get_mut(node).filter(|producer| producer.expected().is_some()) {
            producer.start = Start::Booted(cx.when);
        }
    }

    /// A frame with bit 7 from a node that sends heartbeats: no guarding answer where nobody asks.
    /// It is still a heartbeat, but its state does not count.
    pub fn bit_7(&mut self, found: u8, node: u8, cx: &mut Context<'_>) {
        cx.raise(Hbt003::ToggleBit { found }, Some(node), None, None);
        self.alive(node, cx);
    }

    /// A heartbeat whose state does not count.
    pub fn alive(&mut self, node: u8, cx: &mut Context<'_>) {
        if let Some(state) = self.producers.get(node).and_then(|producer| producer.state) {
            self.heartbeat(node, state, cx);
        }
    }

    /// The network was switched on: all nodes have their time to boot.
    pub fn power_up(&mut self, cx: &Context<'_>) {
        for (id, _) in self.producers.iter() {
            if let Some(owed) = self.owed.get(id).copied() {
                self.owed.open(id, Owed { since: cx.when, limit_ns: owed.limit_ns.max(POWER_UP_NS), ..owed });
            }
        }
    }

    /// A command: a change of state is no sign of a second node.
    pub fn commanded(&mut self, node: u8) {
        let meant = |(id, _): &(u8, &mut Producer)| node == 0 || node == *id;
        self.producers.iter_mut().filter(meant).for_each(|(_, producer)| producer.duplicate.commanded());
    }

    /// Says whether a state is one that CiA 301 knows; the first of several of another one is a finding.
    pub fn known_state(&mut self, node: u8, state: u8, cx: &mut Context<'_>) -> bool {
        let known = matches!(state, STOPPED | OPERATIONAL | PRE_OPERATIONAL);
        let producer = self.producers.entry(node);
        let unknown = Some(state).filter(|_| !known);
        if let Some(found) = unknown
            && producer.unknown != unknown
        {
            cx.raise(Hbt003::State { found }, Some(node), None, None);
        }
        producer.unknown = unknown;
        known
    }

    /// A heartbeat of a node. One that may be a duplicate teaches nothing.
    pub fn heartbeat(&mut self, node: u8, state: u8, cx: &mut Context<'_>) {
        let known = self.known_state(node, state, cx);
        let producer = self.producers.entry(node);
        let before = producer.state.replace(state);
        let changed = before.is_some_and(|before| before != state);
        let last = producer.last.replace(cx.when);
        if let Some(last) = last {
            producer.duplicate.state(node, changed && known, (before, state), last.at, cx);
            producer.gap(node, last, changed, cx);
        }
        if producer.is_lost() {
            cx.evidence.circumstances.over(Kind::NodeLost, node);
        }
        producer.lost = producer.lost.filter(|(_, since)| *since == 0).map(|(at, _)| (at, 1));
        producer.begin(node, cx);
        producer.paused_ns = 0;
        let limit = producer.limit();
        cx.evidence.pending.alive(node, limit.is_some());
        match limit {
            Some(limit_ns) => self.owed.open(node, Owed { since: cx.when, limit_ns, why: None }),
            None => drop(self.owed.met(node)),
        }
    }

    /// It is `now_ns`: who should have been heard and was not. `heard`: by a frame, not by the clock alone.
    #[inline]
    pub fn advance(&mut self, now_ns: i64, heard: bool, cx: &mut Context<'_>) {
        let ended = cx.evidence.recording.ended_silence(now_ns).is_some();
        if !heard || ended || self.owed.may_be_due(now_ns) {
            self.judge(now_ns, heard, cx);
        }
    }

    fn judge(&mut self, now_ns: i64, heard: bool, cx: &mut Context<'_>) {
        let silence = cx.evidence.recording.silence(now_ns).filter(|silence| silence.to_ns == now_ns);
        let silence = silence.map(|silence| self.with_producers(silence));
        let now = cx.clock(now_ns);
        if let Some(silence) = silence.filter(|_| heard && self.looked_ns != now_ns) {
            self.looked_ns = now_ns;
            self.resume(silence, cx);
        }
        for (node, owed) in self.owed.due(now, &cx.evidence.recording) {
            if heard || !self.waits(node, silence, cx) {
                self.lose(node, now, owed, cx);
            } else {
                self.owed.open(node, owed);
            }
        }
    }

    /// A silence, with the producers of which a heartbeat was expected in it, as far as is known here.
    fn with_producers(&self, silence: Silence) -> Silence {
        let due =
            |one: &Producer| Some(one.last?.at.t_ns?.saturating_add(one.expected()?.saturating_add(LEAST_SLACK_NS)));
        let within = |due: i64| silence.from_ns < due && due < silence.to_ns;
        let missing = self.producers.iter().filter(|(_, one)| due(one).is_some_and(within));
        missing.fold(silence, |silence, (id, _)| Silence { missing: silence.missing | 1 << (id & 0x7F), ..silence })
    }

    /// The bus is heard again: the time of a heartbeat that was expected in its silence starts again.
    fn resume(&mut self, silence: Silence, cx: &mut Context<'_>) {
        let (mut missing, mut overdue) = (0, false);
        for (node, producer) in self.producers.iter_mut() {
            if !producer.misses(node, silence) {
                continue;
            }
            producer.paused_ns = producer.paused_ns.saturating_add(silence.ns());
            let Some(owed) = self.owed.get(node).copied() else { continue };
            missing += 1;
            overdue |= owed.since.at.t_ns.is_some_and(|since| since.saturating_add(owed.limit_ns) < silence.to_ns);
            self.owed.open(node, Owed { since: cx.when, ..owed });
        }
        if overdue {
            self.report_silence(silence, missing, cx);
        }
    }

    /// Reports that the whole bus is silent, once for each silence.
    fn report_silence(&mut self, silence: Silence, nodes: u64, cx: &mut Context<'_>) {
        if self.reported_ns.replace(silence.from_ns) != Some(silence.from_ns) {
            cx.report_timed(cx.verdict(Hbt005::Silent { silence: silence.ns(), nodes }, None, None, None));
        }
    }

    /// Whether a heartbeat that is overdue while no frame comes may turn out to be missing as all others are.
    fn waits(&mut self, node: u8, silence: Option<Silence>, cx: &mut Context<'_>) -> bool {
        let others = self.producers.iter().any(|(id, _)| id != node && self.owed.get(id).is_some());
        let Some(silence) = silence else { return others };
        if self.producers.get(node).is_none_or(|one| !one.misses(node, silence)) {
            return others;
        }
        let missing = self.producers.iter().filter(|(id, one)| one.misses(*id, silence)).count();
        self.report_silence(silence, missing as u64, cx);
        true
    }

    fn lose(&mut self, node: u8, now: When, owed: Owed, cx: &mut Context<'_>) {
        let Some(producer) = self.producers.get_mut(node) else { return };
        // One that comes back for a single heartbeat is lost still.
        let because_of = producer.lost.map(|(at, _)| at);
        producer.lost = Some((because_of.unwrap_or(cx.at), 0));
        let last = producer.last.unwrap_or(owed.since);
        let (silence, limit) = (cx.evidence.recording.between(last, now).unwrap_or(0), owed.limit_ns);
        let what = match producer.consumer {
            Some(time) if time >= limit => Hbt002::ConsumerTime { silence, limit },
            _ => Hbt002::Limit { silence, limit },
        };
        let finding = cx.verdict(what, Some(node), None, Some(last.at));
        cx.report(Finding { because_of, ..finding });
        cx.evidence.circumstances.note(Kind::NodeLost, Some(node), cx.when);
        cx.evidence.pending.lost(node, cx.at);
    }

    /// Frames were lost: heartbeats may be among them.
    pub fn forget(&mut self, cx: &mut Context<'_>) {
        self.pause(0, cx);
    }

    /// The capture is over: who should have been heard by its last frame.
    pub fn finish(&mut self, cx: &mut Context<'_>) {
        if let Some(now_ns) = cx.at.t_ns {
            self.advance(now_ns, true, cx);
        }
    }
}

impl Producer {
    fn configure(&mut self, configured: Option<i64>) {
        let before = self.period.configured_ns();
        self.off = configured == Some(0);
        self.period.configure(configured);
        let known = self.period.learnt_ns();
        if configured != before && !configured.is_some_and(|ns| known.is_some_and(|known| alike(known, ns))) {
            self.period.doubt();
            self.late = None;
            self.last = self.last.filter(|_| !self.off);
            self.duplicate = DuplicateId::default();
        }
    }

    /// It is not watched until its next heartbeat.
    fn pause(&mut self) {
        self.period.doubt();
        (self.last, self.state, self.late, self.lost) = (None, None, None, None);
        (self.start, self.paused_ns) = (Start::Over, 0);
        self.duplicate = DuplicateId::default();
    }

    fn is_lost(&self) -> bool {
        self.lost.is_some_and(|(_, since)| since == 0)
    }

    fn expected(&self) -> Option<i64> {
        Some(self.period.expected()?.ns)
    }

    /// By how much a heartbeat may be late, in ns.
    fn slack(&self) -> i64 {
        self.period
            .expected()
            .map_or(LEAST_SLACK_NS, |known| slack(known.ns, known.confidence).saturating_add(known.deviation_ns))
    }

    /// How long it may be silent, in ns; `None`: without limit.
    fn limit(&self) -> Option<i64> {
        if self.off && self.period.learnt_ns().is_none() {
            return None;
        }
        match (self.consumer, self.expected()) {
            (Some(time), Some(period)) => Some(time.max(period.saturating_add(self.slack()))),
            (None, Some(period)) => Some(period.saturating_mul(3).saturating_add(self.slack())),
            (time, None) => time,
        }
    }

    /// Whether a heartbeat was expected in a silence, and it is not the node's own fault that it did not come.
    fn misses(&self, node: u8, silence: Silence) -> bool {
        let booted = if let Start::Booted(boot) = self.start { Some(boot) } else { None };
        let Some(last) = self.last.or(booted).and_then(|last| last.at.t_ns) else { return false };
        let Some(wait) = self.expected().or(self.consumer) else { return false };
        let due = last.saturating_add(wait);
        silence.is_of_all(node, wait) && due < silence.to_ns && due.saturating_add(self.slack()) > silence.from_ns
    }

    /// Judges the gap between two heartbeats, and learns from it.
    fn gap(&mut self, node: u8, last: When, changed: bool, cx: &mut Context<'_>) {
        let recording = &cx.evidence.recording;
        let Some(gap) = recording.between(last, cx.when).filter(|gap| *gap > 0) else {
            return self.duplicate.interrupt();
        };
        let suspect = std::mem::replace(&mut self.suspect, cx.sighting == Sighting::Suspect) || self.suspect;
        let teaches = gap >= SHORTEST_NS
            && recording.teaches(cx.when)
            && recording.teaches(last)
            && self.paused_ns == 0
            && !suspect;
        let held_back = cx.at.t_ns.and_then(|now| recording.ended_silence(now)).is_some_and(|silence| silence.odd);
        let mut verdict = None;
        if let Some(period) = self.expected().filter(|_| !self.is_lost() && self.period.is_known()) {
            // After a pause it may come a whole period later: its clock went on meanwhile.
            let paused_ns = if self.paused_ns > 0 { self.paused_ns.saturating_add(period) } else { 0 };
            let limit = period.saturating_add(self.slack()).saturating_add(paused_ns);
            let late = recording.certainly_later(cx.when, last, limit) && !held_back;
            verdict = Some((period, late));
        }
        if teaches && !changed && !held_back {
            self.learn(node, gap, last, cx);
        } else {
            self.duplicate.interrupt();
        }
        if let Some((period, late)) = verdict {
            self.judge(node, (gap, period), late, cx);
        }
    }

    fn judge(&mut self, node: u8, (found, expected): (i64, i64), late: bool, cx: &mut Context<'_>) {
        if !late {
            self.late = self.late.filter(|(.., since)| *since == 0).map(|(gap, first, _)| (gap, first, 1));
            return;
        }
        // Gaps that stay as long, or alternate, are one fault.
        let again = self.late.filter(|(before, ..)| alike(*before, found));
        self.late = Some((found, again.map_or(cx.at, |(_, first, _)| first), 0));
        if again.is_some() || !self.period.is_even() || self.duplicate.is_found() {
            return;
        }
        cx.report_timed(cx.verdict(Hbt001::Late { found, expected }, Some(node), None, None));
    }

    /// Takes the gap between two heartbeats in the same state.
    fn learn(&mut self, node: u8, gap: i64, last: When, cx: &mut Context<'_>) {
        let uncertain = cx.evidence.recording.resolution_ns();
        self.resolution_ns = uncertain;
        let gap = match self.duplicate.gap(node, gap, last.at, &self.period, uncertain, cx) {
            Place::InTurn(gap) => gap,
            Place::Additional => return,
        };
        let before = self.period.expected();
        let Learnt::Changed { from_ns: from, to_ns: to, since } = self.period.take(gap, uncertain, cx.at) else {
            return;
        };
        let halved = alike(from, to.saturating_mul(2));
        // Few heartbeats do not show what the period was: the change may be older than what is recorded. That another node
        // sends in half phase, fewer show if they are even.
        let configured = self.period.configured_ns().is_some_and(|ns| alike(ns, from));
        let even = |known: &Expected| known.gaps >= SHOWN && known.deviation_ns <= known.ns / EVEN_PART;
        let certain = |known: &Expected| known.confidence == Confidence::Certain;
        let shown = before.is_some_and(|known| certain(&known) || halved && even(&known));
        if !(configured || shown) || alike(from, to) || self.duplicate.is_found() {
            return;
        }
        if halved {
            return self.duplicate.halved(node, from, last.at, cx);
        }
        // Its first gap was late already.
        let because_of = self.late.map(|(_, first, _)| first).or(self.lost.map(|(at, _)| at));
        let finding = cx.verdict(Hbt007::Changed { from, to }, Some(node), None, None);
        cx.report_timed(Finding { at: since, because_of, ..finding });
    }

    /// The first heartbeats after a boot-up. Where the second shows that the period is the one before, the first was
    /// due after that.
    fn begin(&mut self, node: u8, cx: &mut Context<'_>) {
        let recording = &cx.evidence.recording;
        match std::mem::take(&mut self.start) {
            Start::Booted(boot) if recording.teaches(boot) && recording.teaches(cx.when) => {
                self.start = recording
                    .between(boot, cx.when)
                    .map_or(Start::Over, |gap| Start::First(gap.saturating_sub(self.paused_ns), cx.when));
            }
            Start::First(found, first) if recording.teaches(cx.when) => {
                let second = recording.between(first, cx.when);
                let Some((expected, second)) = self.expected().zip(second) else { return };
                if alike(expected, second) && found > expected.saturating_add(self.slack()) {
                    let finding = cx.verdict(Hbt001::Late { found, expected }, Some(node), None, None);
                    cx.report_timed(Finding { at: first.at, ..finding });
                }
            }
            _ => {}
        }
    }
}

/// What a gap may exceed its period by, in ns.
fn slack(period: i64, confidence: Confidence) -> i64 {
    let percent = if confidence == Confidence::Certain { 30 } else { 45 };
    (period.saturating_mul(percent) / 100).max(LEAST_SLACK_NS)
}

/// Whether two times differ by no more than an eighth.
fn alike(one: i64, other: i64) -> bool {
    one.abs_diff(other) <= (one.max(other) / 8).unsigned_abs()
}

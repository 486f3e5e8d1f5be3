//! Heartbeats (CiA 301, 7.2.8.3.2): late, lost, in an unknown state, or with a changed period.
//!
//! A producer is monitored from its first heartbeat on, as consumers do. Its period is learnt from its heartbeats, and
//! until then taken from 1017h in the capture or a DCF. A node counts as lost after the consumer time (1016h), or after
//! three periods. Behind a boot-up another program may run, so that a period learnt before it is a guess until heartbeats
//! show it again. A period that does not follow 1017h, slower or faster, or that changes, is one fault. Additional
//! heartbeats are legal. A silence of the whole bus is blamed on no node: heartbeats expected in it are due again after it.
//! Verdicts need stamps, except those on states. Two nodes with one node-ID are found in `duplicate_id`.

mod duplicate_id;

use std::collections::{BTreeMap, BTreeSet};

use self::duplicate_id::{DuplicateId, SeriesPlace};
use super::limits::POWER_UP_NS;
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::evidence::circumstance::CircumstanceKind;
use crate::evidence::duplicates::Sighting;
use crate::evidence::obligation::Owed;
use crate::evidence::period::{Confidence, Expected, Learnt};
use crate::evidence::recording::Silence;
use crate::evidence::{Obligations, Period, When};
use crate::rules::finding::Finding;
use crate::rules::heartbeat::{Hbt001, Hbt002, Hbt003, Hbt005, Hbt007};
use crate::wire::error_control::{OPERATIONAL, PRE_OPERATIONAL, STOPPED};
use crate::world::configuration::Provenance;
use crate::world::context::Context;
use crate::world::node::{Node, PerNode};

/// Minimum tolerance for a late heartbeat, in ns: hosts and small controllers are late by this now and then.
const LEAST_SLACK_NS: Ns = Ns::from_ms(20);
/// The shortest period, in ns (1017h counts in ms). Shorter gaps come from a buffer and show no period.
const SHORTEST_NS: Ns = Ns::from_ms(1);
/// Number of gaps that show a period; and the part of a time by which equal ones differ at most.
const SHOWN: usize = 3;
const EVEN_PART: i64 = 16;
/// Number of periods from before a boot-up, and minimum time in ns, without a heartbeat after which a node is lost that has
/// not shown its new period.
const GUESSED: i64 = 10;
const GUESSED_NS: Ns = Ns::from_s(5);
/// Sub-indices of 1016h.
const CONSUMED: std::ops::RangeInclusive<u8> = 1..=127;

/// The state of one producer.
#[derive(Debug, Default)]
struct Producer {
    /// The last heartbeat; `None` while the node is not monitored.
    last: Option<When>,
    state: Option<u8>,
    /// The last state if CiA 301 does not define it.
    unknown: Option<u8>,
    period: Period,
    /// The node has booted since its period was learnt.
    rebooted: bool,
    /// The period was judged against 1017h.
    compared: bool,
    /// The resolution of the stamps that the period was learnt from, in ns.
    resolution_ns: Ns,
    /// 1017h holds 0.
    off: bool,
    /// The shortest consumer time, in ns.
    consumer: Option<Ns>,
    start: Start,
    /// A command has reset the node, and it has not booted since.
    reset: bool,
    /// True once an error control frame of the node was seen.
    seen: bool,
    /// The longest gap before the period was known in ns, the heartbeat that ended it, and the longest silence of the
    /// whole bus in it, in ns.
    unjudged: Option<(Ns, FrameRef, Ns)>,
    /// The longest silence of the whole bus since the last heartbeat, in ns.
    silent_ns: Ns,
    /// The value of 1017h in ns that a request not yet acknowledged writes.
    requested_ns: Option<Ns>,
    /// True while all gaps since the first heartbeat that was owed are late, and that was reported: one fault.
    begins_late: bool,
    /// The frame of the first report of its being late or lost since the period was last doubted.
    reported: Option<FrameRef>,
    /// The last late gap in ns, the heartbeat that ended the first like it, and the number of punctual gaps since.
    late: Option<(Ns, FrameRef, u8)>,
    /// The frame at which it counted as lost, and the number of heartbeats since; two punctual ones end the loss.
    lost: Option<(FrameRef, u8)>,
    /// Duration of silences of the whole bus while the next heartbeat was due, in ns.
    paused_ns: Ns,
    /// The last heartbeat may be a duplicate.
    suspect: bool,
    duplicate: DuplicateId,
}

/// The phase before the first heartbeats. A boot-up may change the period, which the second heartbeat shows.
#[derive(Clone, Copy, Debug, Default)]
enum Start {
    #[default]
    Over,
    /// Behind a boot-up; true if a command asked for it.
    Booted(When, bool),
    /// The time from the boot-up to the first heartbeat in ns, that heartbeat, and true as above.
    First(Ns, When, bool),
    /// The acknowledged write of 1017h that begins the heartbeats, and its value in ns.
    Written(When, Ns),
}

/// Returns the nodes that a node monitors, with times in ns, as far as a better source than an EDS shows.
fn consumed(node: &Node) -> Vec<(usize, Ns)> {
    let known = CONSUMED.filter_map(|sub| node.value(0x1016, sub)).filter(|(_, from)| *from > Provenance::Eds);
    let watched = known.map(|(value, _)| ((value >> 16) as usize & 0x7F, Ns::from_ms((value & 0xFFFF) as i64)));
    watched.filter(|(_, time)| *time > Ns::ZERO).collect()
}

/// The heartbeat producers of a bus.
#[derive(Debug, Default)]
pub struct Heartbeats {
    producers: PerNode<Producer>,
    owed: Obligations<u8>,
    /// End of the last examined silence of the whole bus, and start of the last reported one, in ns.
    looked_ns: Ns,
    reported_ns: Option<Ns>,
    /// The nodes that each node monitors by 1016h, and the times in ns.
    consumed: BTreeMap<u8, Vec<(usize, Ns)>>,
    /// Producers that are expected behind lost frames, and within which time in ns.
    again: Vec<(u8, Ns)>,
    /// Nodes whose entry in `consumed` is outdated.
    stale: BTreeSet<u8>,
}

impl Heartbeats {
    /// Marks a change of 1016h of a node.
    pub fn watches_others(&mut self, node: u8) {
        self.stale.insert(node);
    }

    /// Returns the heartbeat period of a node, in ns.
    pub fn period(&self, node: u8) -> Option<Ns> {
        let producer = self.producers.get(node)?;
        // Coarse stamps show multiples of their unit, whatever the period.
        let learnt = producer.expected().filter(|ns| *ns > producer.resolution_ns);
        learnt.or(producer.period.configured_ns())
    }

    /// Returns true if a node's heartbeat is overdue at `now_ns`: it counts as lost, or would if the whole bus were not
    /// silent. False for a node that was reset or is not monitored for another reason.
    pub fn is_overdue(&self, node: u8, now_ns: Ns) -> bool {
        let Some(producer) = self.producers.get(node) else { return false };
        let last = producer.last.and_then(|last| last.at.t_ns);
        let late = |limit: Ns| last.is_some_and(|last| now_ns - last > limit);
        producer.is_lost() || producer.limit().is_some_and(late)
    }

    /// Returns true if a node's heartbeats are even.
    pub fn is_producer(&self, node: u8) -> bool {
        self.producers.get(node).is_some_and(|producer| producer.period.learnt_ns().is_some())
    }

    /// Returns true if a node sends heartbeats, by 1017h or as its frames show, and does not answer guarding.
    pub fn produces(&self, node: u8) -> bool {
        self.is_producer(node) || self.is_configured(node)
    }

    /// Returns true if 1017h is known to be other than 0.
    pub fn is_configured(&self, node: u8) -> bool {
        self.producers.get(node).is_some_and(|producer| producer.period.configured_ns().is_some())
    }

    /// Updates the times after a change of 1016h or 1017h.
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
                *slot = Some(slot.map_or(*time, |before: Ns| before.min(*time)));
            }
        }
        for (id, consumer) in (0..).zip(consumers) {
            let produced = nodes.get(id).and_then(|node| node.value(0x1017, 0));
            let configured = produced.filter(|(_, from)| *from > Provenance::Eds);
            let configured = configured.map(|(ms, _)| Ns::from_ms((ms & 0xFFFF) as i64));
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

    /// Takes a write request to 1017h; `ns` is the new period.
    pub fn written(&mut self, node: u8, ns: Ns, cx: &Context<'_>) {
        let Some(producer) = self.producers.get_mut(node) else { return };
        let before = producer.expected().unwrap_or(Ns::ZERO);
        producer.period.doubt();
        (producer.last, producer.start, producer.late, producer.unjudged) = (None, Start::Over, None, None);
        (producer.requested_ns, producer.begins_late, producer.reported) = (Some(ns), false, None);
        producer.compared = false;
        // The write restarts the period. If the server refuses it, the old one continues.
        if self.owed.met(node).is_some() && ns > Ns::ZERO {
            let period = before.max(ns);
            let limit_ns = period * 3 + slack(period, Confidence::Configured);
            self.owed.open(node, Owed { since: cx.when, limit_ns, why: Some(cx.at) });
        }
    }

    /// Takes an acknowledged write of 1017h; without its request in the capture the new period is unknown.
    pub fn acknowledged(&mut self, node: u8, cx: &Context<'_>) {
        let Some(producer) = self.producers.get_mut(node) else { return };
        // Only a node whose error control is in the capture is known to owe its heartbeats there.
        if let Some(ns) = producer.requested_ns.take().filter(|ns| *ns > Ns::ZERO && producer.seen) {
            (producer.start, producer.paused_ns) = (Start::Written(cx.when, ns), Ns::ZERO);
            if self.owed.get(node).is_none() {
                let limit_ns = ns * 3 + slack(ns, Confidence::Configured);
                self.owed.open(node, Owed { since: cx.when, limit_ns, why: Some(cx.at) });
            }
        }
        if self.owed.get(node).is_some_and(|owed| owed.why.is_none()) {
            producer.period.forget();
            (producer.last, producer.compared) = (None, false);
            self.owed.met(node);
        }
    }

    /// Stops monitoring a node (or all, 0) that is reset or silenced by command, until its next heartbeat.
    pub fn pause(&mut self, node: u8, cx: &mut Context<'_>) {
        for (id, producer) in self.producers.iter_mut().filter(|(id, _)| node == 0 || node == *id) {
            producer.pause();
            cx.evidence.pending.alive(id, false);
        }
        self.owed.void(|id| node == 0 || node == *id);
    }

    /// Takes a command that resets a node (or all, 0).
    pub fn reset(&mut self, node: u8, cx: &mut Context<'_>) {
        self.pause(node, cx);
        let meant = |(id, _): &(u8, &mut Producer)| node == 0 || node == *id;
        self.producers.iter_mut().filter(meant).for_each(|(_, producer)| producer.reset = true);
    }

    /// Takes a boot-up.
    pub fn booted(&mut self, node: u8, cx: &mut Context<'_>) {
        self.pause(node, cx);
        cx.evidence.circumstances.over(CircumstanceKind::NodeLost, node);
        let producer = self.producers.entry(node);
        let asked = std::mem::take(&mut producer.reset);
        (producer.seen, producer.start) = (true, Start::Booted(cx.when, asked));
        producer.rebooted = true;
    }

    /// Takes a frame with bit 7 from a node that sends heartbeats and is not guarded: a heartbeat whose state does not
    /// count.
    pub fn bit_7(&mut self, found: u8, node: u8, cx: &mut Context<'_>) {
        cx.raise(Hbt003::ToggleBit { found }, Some(node), None, None);
        self.alive(node, cx);
    }

    /// Takes a heartbeat whose state does not count.
    pub fn alive(&mut self, node: u8, cx: &mut Context<'_>) {
        if let Some(state) = self.producers.get(node).and_then(|producer| producer.state) {
            self.heartbeat(node, state, cx);
        } else {
            self.answers(node);
        }
    }

    /// Takes an error control frame of a node that is monitored otherwise: it is not silent.
    pub fn answers(&mut self, node: u8) {
        if let Some(producer) = self.producers.get_mut(node).filter(|producer| producer.last.is_none()) {
            producer.start = Start::Over;
            self.owed.met(node);
        }
    }

    /// Gives all nodes time to boot after the network was switched on.
    pub fn power_up(&mut self, cx: &Context<'_>) {
        for (id, _) in self.producers.iter() {
            if let Some(owed) = self.owed.get(id).copied() {
                self.owed.open(id, Owed { since: cx.when, limit_ns: owed.limit_ns.max(POWER_UP_NS), ..owed });
            }
        }
    }

    /// Takes a command, after which a change of state is no sign of a second node.
    pub fn commanded(&mut self, node: u8) {
        let meant = |(id, _): &(u8, &mut Producer)| node == 0 || node == *id;
        self.producers.iter_mut().filter(meant).for_each(|(_, producer)| producer.duplicate.commanded());
    }

    /// Returns true if CiA 301 defines a state; reports the first of a series of the same undefined state.
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

    /// Takes a heartbeat. A possible duplicate teaches nothing.
    pub fn heartbeat(&mut self, node: u8, state: u8, cx: &mut Context<'_>) {
        let known = self.known_state(node, state, cx);
        let producer = self.producers.entry(node);
        producer.seen = true;
        let before = producer.state.replace(state);
        let changed = before.is_some_and(|before| before != state);
        let last = producer.last.replace(cx.when);
        if let Some(last) = last {
            producer.duplicate.state(node, changed && known, (before, state), last.at, cx);
            producer.gap(node, last, changed, cx);
        }
        if producer.is_lost() {
            cx.evidence.circumstances.over(CircumstanceKind::NodeLost, node);
            // The first one after a write of 1017h was owed, and reported.
            producer.begins_late = matches!(producer.start, Start::Written(..));
            producer.start = if producer.begins_late { Start::Over } else { producer.start };
        }
        producer.lost = producer.lost.filter(|(_, since)| *since == 0).map(|(at, _)| (at, 1));
        producer.begin(node, cx);
        (producer.paused_ns, producer.silent_ns) = (Ns::ZERO, Ns::ZERO);
        let limit = producer.limit();
        cx.evidence.pending.alive(node, limit.is_some());
        match limit {
            Some(limit_ns) => self.owed.open(node, Owed { since: cx.when, limit_ns, why: None }),
            None => drop(self.owed.met(node)),
        }
    }

    /// Reports heartbeats missing at `now_ns`. `heard`: the time comes from a frame, not from the clock alone.
    #[inline]
    pub fn advance(&mut self, now_ns: Ns, heard: bool, cx: &mut Context<'_>) {
        let ended = cx.evidence.recording.ended_silence(now_ns).is_some();
        if !heard || ended || self.owed.may_be_due(now_ns) {
            self.judge(now_ns, heard, cx);
        }
    }

    fn judge(&mut self, now_ns: Ns, heard: bool, cx: &mut Context<'_>) {
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

    /// Adds the producers whose heartbeat was due in a silence.
    fn with_producers(&self, silence: Silence) -> Silence {
        let due = |one: &Producer| Some(one.since()?.at.t_ns? + (one.expected()? + LEAST_SLACK_NS));
        let within = |due: Ns| silence.from_ns < due && due < silence.to_ns;
        let missing = self.producers.iter().filter(|(_, one)| due(one).is_some_and(within));
        missing.fold(silence, |silence, (id, _)| Silence { missing: silence.missing | 1 << (id & 0x7F), ..silence })
    }

    /// Restarts the time of heartbeats that were due in a silence of the bus that has ended.
    fn resume(&mut self, silence: Silence, cx: &mut Context<'_>) {
        let (mut missing, mut overdue) = (0, false);
        for (node, producer) in self.producers.iter_mut() {
            producer.silent_ns = producer.silent_ns.max(silence.ns());
            if !producer.misses(node, silence) {
                continue;
            }
            producer.paused_ns += silence.ns();
            let Some(owed) = self.owed.get(node).copied() else { continue };
            missing += 1;
            overdue |= owed.since.at.t_ns.is_some_and(|since| since + owed.limit_ns < silence.to_ns);
            self.owed.open(node, Owed { since: cx.when, ..owed });
        }
        if overdue {
            self.report_silence(silence, missing, cx);
        }
    }

    /// Reports a silence of the whole bus, once.
    fn report_silence(&mut self, silence: Silence, nodes: u64, cx: &mut Context<'_>) {
        if self.reported_ns.replace(silence.from_ns) != Some(silence.from_ns) {
            cx.report_timed(cx.verdict(Hbt005::Silent { silence: silence.ns(), nodes }, None, None, None));
        }
    }

    /// Returns true if an overdue heartbeat may be missing only because the whole bus is silent.
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
        // A node that returns for a single heartbeat is still lost.
        let because_of = producer.lost.map(|(at, _)| at).or(producer.reported.filter(|_| producer.begins_late));
        producer.lost = Some((because_of.unwrap_or(cx.at), 0));
        producer.reported.get_or_insert(cx.at);
        let last = producer.last.unwrap_or(owed.since);
        let (silence, limit) = (cx.evidence.recording.between(last, now).unwrap_or(Ns::ZERO), owed.limit_ns);
        let what = match (producer.start, producer.consumer) {
            (Start::Written(_, expected), _) => Hbt002::AfterWrite { silence, expected },
            (_, Some(time)) if time >= limit => Hbt002::ConsumerTime { silence, limit },
            _ if producer.is_guessed() => {
                let period = producer.expected().unwrap_or(Ns::ZERO);
                Hbt002::AfterBoot { silence, limit, period }
            }
            _ => Hbt002::Limit { silence, limit },
        };
        let finding = cx.verdict(what, Some(node), None, Some(last.at));
        cx.report(Finding { because_of, ..finding });
        cx.evidence.circumstances.note(CircumstanceKind::NodeLost, Some(node), cx.when);
        cx.evidence.pending.lost(node, cx.at);
    }

    /// Expects the producers behind lost frames, which are forgotten next: a node that was heard before and is not behind
    /// them is lost, too. It may have booted where frames are missing.
    pub fn expect_again(&mut self) {
        let limit_ns = |one: &Producer| Some(one.last.and(one.limit())?.max(one.expected()? * GUESSED).max(GUESSED_NS));
        self.again = self.producers.iter().filter_map(|(id, one)| Some((id, limit_ns(one)?))).collect();
    }

    /// Stops monitoring after lost frames, until the next heartbeats.
    pub fn forget(&mut self, cx: &mut Context<'_>) {
        self.pause(0, cx);
        for (node, limit_ns) in std::mem::take(&mut self.again) {
            self.owed.open(node, Owed { since: cx.when, limit_ns, why: None });
        }
        self.owed.restart();
    }

    /// Reports heartbeats missing at the last frame of the capture.
    pub fn finish(&mut self, cx: &mut Context<'_>) {
        if let Some(now_ns) = cx.at.t_ns {
            self.advance(now_ns, true, cx);
        }
    }
}

impl Producer {
    fn configure(&mut self, configured: Option<Ns>) {
        let before = self.period.configured_ns();
        self.off = configured == Some(Ns::ZERO);
        self.period.configure(configured);
        let known = self.period.learnt_ns();
        if configured != before && !configured.is_some_and(|ns| known.is_some_and(|known| alike(known, ns))) {
            self.period.doubt();
            (self.late, self.compared) = (None, false);
            self.last = self.last.filter(|_| !self.off);
            self.duplicate = DuplicateId::default();
        }
    }

    /// Stops monitoring until the next heartbeat.
    fn pause(&mut self) {
        self.period.doubt();
        (self.last, self.state, self.late, self.lost) = (None, None, None, None);
        (self.start, self.paused_ns, self.unjudged, self.requested_ns) = (Start::Over, Ns::ZERO, None, None);
        (self.begins_late, self.reported, self.compared) = (false, None, false);
        self.duplicate = DuplicateId::default();
    }

    fn is_lost(&self) -> bool {
        self.lost.is_some_and(|(_, since)| since == 0)
    }

    /// Returns the place from which the next heartbeat is expected.
    fn since(&self) -> Option<When> {
        match self.start {
            Start::Booted(at, _) | Start::Written(at, _) => self.last.or(Some(at)),
            _ => self.last,
        }
    }

    /// Returns the period, in ns. Two short gaps, as behind a boot-up, may be anything.
    fn expected(&self) -> Option<Ns> {
        let known = self.period.expected()?;
        (known.ns >= LEAST_SLACK_NS || known.confidence != Confidence::Likely).then_some(known.ns)
    }

    /// Returns true if the period is known from before a boot-up only.
    fn is_guessed(&self) -> bool {
        self.rebooted && !self.period.is_known()
    }

    /// Returns the tolerance for a late heartbeat, in ns.
    fn slack(&self) -> Ns {
        self.period.expected().map_or(LEAST_SLACK_NS, |known| slack(known.ns, known.confidence) + known.deviation_ns)
    }

    /// Returns the maximum time of silence, in ns; `None` if unlimited.
    fn limit(&self) -> Option<Ns> {
        if self.off && self.period.learnt_ns().is_none() {
            return None;
        }
        match (self.consumer, self.expected()) {
            (Some(time), Some(period)) => Some(time.max(period + self.slack())),
            (None, Some(period)) if self.is_guessed() => Some((period * GUESSED).max(GUESSED_NS)),
            (None, Some(period)) => Some(period * 3 + self.slack()),
            (time, None) => time,
        }
    }

    /// Returns true if a heartbeat was due in a silence, and the node is not to blame for its absence.
    fn misses(&self, node: u8, silence: Silence) -> bool {
        let Some(last) = self.since().and_then(|last| last.at.t_ns) else { return false };
        let Some(wait) = self.expected().or(self.consumer) else { return false };
        let due = last + wait;
        silence.is_of_all(node, wait) && due < silence.to_ns && due + self.slack() > silence.from_ns
    }

    /// Judges the gap between two heartbeats, and learns from it.
    fn gap(&mut self, node: u8, last: When, changed: bool, cx: &mut Context<'_>) {
        let recording = &cx.evidence.recording;
        let Some(gap) = recording.between(last, cx.when).filter(|gap| *gap > Ns::ZERO) else {
            return self.duplicate.interrupt();
        };
        let suspect = std::mem::replace(&mut self.suspect, cx.sighting == Sighting::Suspect) || self.suspect;
        let teaches = gap >= SHORTEST_NS
            && recording.teaches(cx.when)
            && recording.teaches(last)
            && self.paused_ns == Ns::ZERO
            && !suspect;
        let held_back = cx.at.t_ns.and_then(|now| recording.ended_silence(now)).is_some_and(|silence| silence.odd);
        let mut verdict = None;
        if let Some(period) = self.expected().filter(|_| !self.is_lost() && self.period.is_known()) {
            // After a pause it may be a whole period late, because its clock went on meanwhile.
            let paused_ns = if self.paused_ns > Ns::ZERO { self.paused_ns + period } else { Ns::ZERO };
            let limit = period + self.slack() + paused_ns;
            let late = recording.certainly_later(cx.when, last, limit) && !held_back;
            verdict = Some((period, late));
        } else if teaches && !held_back && !self.is_lost() && self.unjudged.is_none_or(|(most, ..)| most < gap) {
            self.unjudged = Some((gap, cx.at, self.silent_ns));
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

    fn judge(&mut self, node: u8, (found, expected): (Ns, Ns), late: bool, cx: &mut Context<'_>) {
        self.begins_late &= !alike(found, expected);
        if !late {
            self.late = self.late.filter(|(.., since)| *since == 0).map(|(gap, first, _)| (gap, first, 1));
            return;
        }
        // Gaps that stay as long, or alternate, are one fault.
        let again = self.late.filter(|(before, ..)| alike(*before, found));
        self.late = Some((found, again.map_or(cx.at, |(_, first, _)| first), 0));
        if again.is_some() || self.begins_late || !self.period.is_even() || self.duplicate.is_found() {
            return;
        }
        self.reported.get_or_insert(cx.at);
        cx.report_timed(cx.verdict(Hbt001::Late { found, expected }, Some(node), None, None));
    }

    /// Learns from the gap between two heartbeats in the same state.
    fn learn(&mut self, node: u8, gap: Ns, last: When, cx: &mut Context<'_>) {
        let uncertain = cx.evidence.recording.resolution_ns();
        self.resolution_ns = uncertain;
        let gap = match self.duplicate.gap(node, gap, last.at, &self.period, uncertain, cx) {
            SeriesPlace::InTurn(gap) => gap,
            SeriesPlace::Additional => return,
        };
        let before = self.period.expected();
        let learnt = self.period.take(gap, uncertain, cx.at);
        self.rebooted &= self.period.learnt_ns().is_none();
        let (from, to, since) = match learnt {
            Learnt::Changed { from_ns, to_ns, since } => (from_ns, to_ns, since),
            Learnt::First | Learnt::Nothing => {
                self.known(node, cx);
                return self.compare(node, learnt == Learnt::First, cx);
            }
        };
        // A few heartbeats do not show the period: the change may be older than the recording.
        let configured = self.period.configured_ns().is_some_and(|ns| alike(ns, from));
        let certain = before.is_some_and(|known| known.confidence == Confidence::Certain);
        if !(configured || certain) || alike(from, to) || self.duplicate.is_found() {
            return;
        }
        self.compared = true;
        // Its first gap was late already.
        let because_of = self.late.map(|(_, first, _)| first).or(self.lost.map(|(at, _)| at));
        let finding = cx.verdict(Hbt007::Changed { from, to }, Some(node), None, None);
        cx.report_timed(Finding { at: since, because_of, ..finding });
    }

    /// Judges a certain period against 1017h, once: the `first`. A shorter one may be that of two nodes, until many gaps
    /// agree.
    fn compare(&mut self, node: u8, first: bool, cx: &mut Context<'_>) {
        let certain = self.period.expected().filter(|known| known.confidence == Confidence::Certain);
        let (Some(known), Some(expected)) = (certain, self.period.configured_ns()) else { return };
        let found = known.ns;
        let (least, most) = (found - self.resolution_ns, found + self.resolution_ns);
        let slower = first && least > expected && !alike(least, expected);
        let faster = most < expected && !alike(most, expected);
        if self.compared || self.duplicate.is_found() || faster && !self.duplicate.is_one_series(expected) {
            return;
        }
        self.compared = first || faster;
        if slower {
            let finding = cx.verdict(Hbt001::Slower { found, expected }, Some(node), None, None);
            cx.report_timed(Finding { because_of: self.reported, ..finding });
        } else if faster {
            cx.report_timed(cx.verdict(Hbt007::Faster { found, expected }, Some(node), None, None));
        }
    }

    /// Judges the longest gap from before the period was known, once some even gaps show that.
    fn known(&mut self, node: u8, cx: &mut Context<'_>) {
        let known = |known: &Expected| known.gaps >= SHOWN && known.confidence >= Confidence::Likely;
        if self.unjudged.is_none() || !self.period.expected().is_some_and(|expected| known(&expected)) {
            return;
        }
        let (Some((found, at, silent_ns)), Some(expected)) = (self.unjudged.take(), self.expected()) else { return };
        let slack = self.slack().max(slack(expected, Confidence::Likely));
        // The gap may seem longer by one step of the stamps, and the few others shorter.
        let limit = expected + slack + self.resolution_ns * 2;
        if found <= limit || silent_ns > limit || self.late.is_some() || self.duplicate.is_found() {
            return;
        }
        let finding = cx.verdict(Hbt001::Late { found, expected }, Some(node), None, None);
        cx.report_timed(Finding { at, ..finding });
    }

    /// Judges the first heartbeats after a write of 1017h or a boot-up. If the second shows the previous period, the first was due after
    /// that. A node that boots by itself has another fault, and its heartbeats may have to be configured again.
    fn begin(&mut self, node: u8, cx: &mut Context<'_>) {
        let recording = &cx.evidence.recording;
        match std::mem::take(&mut self.start) {
            Start::Booted(boot, asked) if recording.teaches(boot) && recording.teaches(cx.when) => {
                let Some(found) = recording.between(boot, cx.when) else { return };
                let found = found - self.paused_ns;
                self.start = Start::First(found, cx.when, asked);
                if self.paused_ns == Ns::ZERO && self.expected().is_some_and(|expected| equal(expected, found)) {
                    self.period.take(found, recording.resolution_ns(), cx.at);
                }
            }
            Start::First(found, first, asked) if recording.teaches(cx.when) => {
                let Some(second) = recording.between(first, cx.when) else { return };
                let Some(expected) = self.expected().filter(|_| self.period.is_known()) else {
                    // A boot-up is the first heartbeat of a node that sends them from then on.
                    if equal(found, second) {
                        self.period.take(found, recording.resolution_ns(), cx.at);
                    }
                    return;
                };
                if asked && alike(expected, second) && found > expected + self.slack() {
                    let finding = cx.verdict(Hbt001::AfterBoot { found, expected }, Some(node), None, None);
                    cx.report_timed(Finding { at: first.at, ..finding });
                }
            }
            Start::Written(since, expected) if recording.teaches(since) && recording.teaches(cx.when) => {
                let Some(found) = recording.between(since, cx.when) else { return };
                let found = found - self.paused_ns;
                // The former period may run to its end. A node may begin the new one with a delay, but by a whole
                // period one heartbeat is missing.
                let period = expected.max(self.expected().unwrap_or(Ns::ZERO));
                let limit = period + (expected / 4 * 3).max(LEAST_SLACK_NS);
                // The recorder may have held it back.
                let ended = cx.at.t_ns.and_then(|now| recording.ended_silence(now)).filter(|silence| silence.odd);
                let limit = limit + self.paused_ns.max(ended.map_or(Ns::ZERO, |silence| silence.ns()));
                if recording.certainly_later(cx.when, since, limit) {
                    self.begins_late = true;
                    self.reported.get_or_insert(cx.at);
                    cx.report_timed(cx.verdict(
                        Hbt001::AfterWrite { found, expected },
                        Some(node),
                        None,
                        Some(since.at),
                    ));
                }
            }
            _ => {}
        }
    }
}

/// Returns the tolerance of a period, in ns.
fn slack(period: Ns, confidence: Confidence) -> Ns {
    let percent = if confidence == Confidence::Certain { 30 } else { 45 };
    (period * percent / 100).max(LEAST_SLACK_NS)
}

/// Returns true if two times differ by no more than even gaps do.
fn equal(one: Ns, other: Ns) -> bool {
    one.abs_diff(other) <= (one.max(other) / EVEN_PART).abs()
}

/// Returns true if two times differ by no more than an eighth.
fn alike(one: Ns, other: Ns) -> bool {
    one.abs_diff(other) <= (one.max(other) / 8).abs()
}

//! SRDO (CiA 304, EN 50325-5): the two frames of a pair, in data, order and time.
//!
//! A pair is judged once it is proved, by a known record 1301h to 1340h or by two pairs of inverse frames; on other
//! networks these identifiers carry other data. Artefacts of the capture are no fault: its edges cut pairs, and a frame
//! of the recording host may be listed one place later.
//!
//! Configured times are judged. Where there are none, the period is learnt as an event timer is ([`Timer`]): SRDOs are sent
//! periodically, and a receiver does not wait for many periods. The next pair is owed: a pause is reported when it ends,
//! and a pair that does not come again when it has certainly stopped, or at the end of the capture.

use std::collections::{BTreeMap, BTreeSet};

use super::pdo::timing::tolerance;
use crate::bytes::frame::{CanId, Frame};
use crate::bytes::ns::Ns;
use crate::evidence::obligation::Owed;
use crate::evidence::period::Timer;
use crate::evidence::{Obligations, Recording, Rules, When};
use crate::rules::finding::{Code, Verdict};
use crate::rules::srdo::{Srd001, Srd002, Srd003, Srd004, Srd005};
use crate::sdo::wire::Mux;
use crate::wire::error_control::OPERATIONAL;
use crate::world::configuration::Provenance;
use crate::world::context::Context;
use crate::world::node::{CobId, Node, PerNode};

/// Pairs: 101h and 102h to 17Fh and 180h.
const PAIRS: usize = 64;
/// Number of pairs that prove an SRDO, and after which the capture's edge cuts off no half.
const PROOF: u64 = 2;

/// Number of cycle times, and minimum time in ns, without a pair after which it has stopped.
const STOPPED: i64 = 10;
const STOPPED_NS: Ns = Ns::from_s(1);
/// Number of learnt periods within which the next pair, and the second half of a pair, come in any case; and the delay of
/// a busy node beside them, in ns.
const PERIODS: i64 = 3;
const PERIODS_OF_HALF: i64 = 2;
const HELD_UP_NS: Ns = Ns::from_ms(20);
/// Part of the learnt period by which a gap is longer that shows no other period.
const EVEN_PART: i64 = 16;

/// One frame of a pair.
#[derive(Clone, Copy, Debug)]
struct Half {
    data: u64,
    len: u8,
    when: When,
}

impl Half {
    fn of(frame: &Frame, when: When) -> Self {
        Self { data: u64::from_le_bytes(frame.head()), len: frame.len, when }
    }

    fn is_inverse(&self, other: &Self) -> bool {
        let mask = u64::MAX >> (64 - 8 * u32::from(self.len.clamp(1, 8)));
        self.len == other.len && (self.data ^ other.data) & mask == mask
    }
}

/// A configured time: node, record, and value.
type Limit = (u8, u16, Ns);

/// The time after which the next pair is due.
#[derive(Clone, Copy, Debug)]
enum Cycle {
    Configured(Limit),
    /// A period in ns.
    Learnt(Ns),
}

impl Cycle {
    fn ns(self) -> Ns {
        match self {
            Self::Configured((_, _, ns)) | Self::Learnt(ns) => ns,
        }
    }

    /// Returns the allowance beside it, in ns.
    fn allowance_ns(self) -> Ns {
        match self {
            Self::Configured((_, _, ns)) => tolerance(ns).max(ns / 10),
            Self::Learnt(ns) => ns * (PERIODS - 1) + HELD_UP_NS,
        }
    }

    /// Returns the maximum time to the next pair, in ns.
    fn limit_ns(self) -> Ns {
        self.ns() + self.allowance_ns()
    }
}

/// The configuration of a pair.
#[derive(Clone, Copy, Debug, Default)]
struct Limits {
    /// The identifiers of normal and inverted data, if a record names the pair.
    identifiers: Option<(CanId, CanId)>,
    /// The node configured to send it, and the record.
    producer: Option<(u8, u16)>,
    /// The frame in which the capture showed the record.
    shown: Option<u64>,
    /// Validation time (SRVT, sub-index 3), of a receiver if known, else of the producer.
    validation: Option<Limit>,
    /// Safeguard cycle time (SCT, sub-index 2), likewise.
    cycle: Option<Limit>,
}

/// One record of a node about a pair.
#[derive(Clone, Copy, Debug)]
struct Record {
    number: u8,
    /// True if the node sends the pair, false if it receives it.
    sends: bool,
    identifiers: (CanId, CanId),
    shown: Option<u64>,
    cycle: Option<Limit>,
    validation: Option<Limit>,
}

/// Frames of a pair that wait for their other half. In the right order each normal frame is `open` until its inverse
/// comes; the other fields hold the remains of a loss, a swap or a late frame.
#[derive(Clone, Copy, Debug, Default)]
struct Halves {
    /// Normal data that wait for their inverse.
    open: Option<Half>,
    /// Earlier normal data whose inverse may still come.
    older: Option<Half>,
    /// Earlier normal data whose inverse seems to have come before them.
    spare: Option<Half>,
    /// Former `older` data after later data have got their inverse.
    missing: Option<Half>,
    /// The last inverted data that had no normal data before them.
    early: Option<Half>,
    /// They came directly before the open ones.
    adjacent: bool,
    /// Inverted data without partner, until the next complete pair proves that half of one is missing.
    lone: Option<Half>,
}

/// The observations of a pair.
#[derive(Clone, Debug, Default)]
struct SrdoPair {
    halves: Halves,
    /// Number of pairs in a row that came in the wrong order.
    swaps: u8,
    /// Its first frame since the capture's edge or a loss of frames.
    first: Option<u64>,
    /// It is proved to be an SRDO.
    proven: bool,
    /// Number of pairs that were not inverse, since the capture's edge or a loss of frames.
    wrong: u64,
    /// Number of correct pairs since then, and the normal data of the last.
    valid: u64,
    last: Option<Half>,
    /// It has the data of the one before.
    repeats: bool,
    /// The last frame with normal data.
    heard: Option<When>,
    /// The start of the last pair if it was correct and uninterrupted since.
    began: Option<When>,
    /// The period, from pairs that repeat their data.
    timer: Timer,
    /// A pair came while the producer was known not to be Operational.
    idle: bool,
    /// The producer has since confirmed that state.
    confirmed: bool,
}

/// A fault shown by a frame.
#[derive(Clone, Copy, Debug)]
enum Report {
    /// The normal data, and the length of the second frame.
    NotInverse(Half, u8),
    Swapped(Half),
    InverseMissing(Half),
    NormalMissing(Half),
    Late(Half, Ns, Ns, Limit),
    /// The inverse came later than the next pairs, in ns, by the learnt period.
    Behind(Half, Ns, Ns),
    /// The time since the pair before, in ns.
    Slow(When, Ns, Cycle),
    /// The time for which none has come, in ns.
    Stopped(When, Ns, Cycle),
    Idle(u8),
}

/// The result for a frame, until its event exists.
#[derive(Debug, Default)]
pub struct SrdoResult {
    /// True if the data are the inverse of the normal data before them; `None` if unknown.
    pub valid: Option<bool>,
    number: u8,
    reports: Vec<Report>,
}

/// The SRDOs of a bus.
#[derive(Debug, Default)]
pub struct Srdos {
    /// The pairs by number, created with the first frame.
    pairs: Vec<SrdoPair>,
    /// The next pair of each, by number.
    due: Obligations<u8>,
    limits: Vec<Limits>,
    records: BTreeMap<(u8, u16), Record>,
    /// Records that have changed.
    stale: BTreeSet<(u8, u16)>,
    /// The frame before which frames were lost.
    lost: u64,
    /// The frame of the last command that changed states, or of the last start of a node.
    began: u64,
}

impl Srdos {
    /// Marks a changed record of a node.
    pub fn renewed(&mut self, node: u8, index: u16) {
        self.stale.insert((node, index));
    }

    /// Updates the configuration, by pair number.
    #[cold]
    fn compile(&mut self, nodes: &PerNode<Node>) {
        for (id, index) in std::mem::take(&mut self.stale) {
            match nodes.get(id).and_then(|node| record(id, node, index)) {
                Some(record) => _ = self.records.insert((id, index), record),
                None => _ = self.records.remove(&(id, index)),
            }
        }
        self.limits = vec![Limits::default(); PAIRS + 1];
        // Producers first, because receivers' values overrule them.
        for sends in [true, false] {
            for (place, record) in self.records.iter().filter(|(_, record)| record.sends == sends) {
                let Some(limits) = self.limits.get_mut(usize::from(record.number)) else { continue };
                limits.identifiers = Some(record.identifiers);
                limits.shown = record.shown.or(limits.shown);
                limits.cycle = record.cycle.or(limits.cycle);
                limits.validation = record.validation.or(limits.validation);
                if sends {
                    limits.producer = Some(*place);
                }
            }
        }
    }

    /// Takes a data frame of pair `number`. `state` returns a node's NMT state if known.
    pub fn follow(
        &mut self,
        number: u8,
        inverted: bool,
        frame: &Frame,
        nodes: &PerNode<Node>,
        cx: &Context<'_>,
        state: impl Fn(u8) -> Option<u8>,
    ) -> SrdoResult {
        if !self.stale.is_empty() {
            self.compile(nodes);
        }
        if self.pairs.is_empty() {
            self.pairs = vec![SrdoPair::default(); PAIRS + 1];
        }
        let limits = self.limits.get(usize::from(number)).copied().unwrap_or_default();
        let mut seen = SrdoResult { valid: None, number, reports: Vec::new() };
        let Some(pair) = self.pairs.get_mut(usize::from(number)) else { return seen };
        if !(1..=8).contains(&frame.len) {
            *pair = SrdoPair { proven: pair.proven, ..SrdoPair::default() };
            return seen;
        }
        let before = pair.valid;
        let half = Half::of(frame, cx.when);
        let recording = &cx.evidence.recording;
        if inverted {
            pair.inverse(half, recording, &mut seen);
        } else {
            pair.normal(half, recording, &mut seen);
        }
        if pair.valid > before {
            let idle = limits.producer.and_then(|(node, _)| state(node)).filter(|state| *state != OPERATIONAL);
            pair.idle = idle.is_some();
            match idle {
                Some(state) if pair.confirmed => seen.reports.push(Report::Idle(state)),
                Some(_) => {}
                None => pair.confirmed = false,
            }
            pair.timing(half, recording, &limits, &mut seen);
        }
        pair.proven |= pair.valid >= PROOF;
        let known = pair.proven || limits.identifiers.is_some();
        let producer = limits.producer.map_or(number, |(node, _)| node);
        let runs = state(producer).is_none_or(|state| state == OPERATIONAL);
        // Whether its halves fit is another question.
        let owed = pair.cycle(&limits).filter(|_| !inverted && known && runs && pair.valid >= PROOF);
        if let Some(cycle) = owed {
            let limit_ns = (cycle.ns() * STOPPED).max(STOPPED_NS).max(cycle.limit_ns());
            self.due.open(number, Owed { since: cx.when, limit_ns, why: None });
        }
        // A half cut off by an edge may make one pair wrong.
        let first = *pair.first.get_or_insert(frame.no);
        // A pair that began after its record and a command has lost nothing to an edge.
        let whole = limits.shown.is_some_and(|shown| shown > self.lost && first > self.began.max(shown));
        let whole = whole && self.began > self.lost;
        let settled = pair.valid > 0 || pair.wrong > 1 || whole;
        if !settled || !known {
            seen.reports.clear();
            seen.valid = seen.valid.filter(|valid| *valid);
        }
        seen
    }

    /// Raises the findings of [`Self::follow`].
    pub fn judge(&self, seen: &SrdoResult, cx: &mut Context<'_>) {
        for report in &seen.reports {
            self.raise(seen.number, *report, cx);
        }
    }

    fn raise(&self, number: u8, report: Report, cx: &mut Context<'_>) {
        let limits = self.limits.get(usize::from(number)).copied().unwrap_or_default();
        let (node, record) = match limits.producer {
            Some((node, index)) => (node, Some(index)),
            None => (number, None),
        };
        let object = |sub| record.map(|index| Mux { index, sub });
        let (normal, inverse) = limits.identifiers.unwrap_or_else(|| identifiers(number));
        let srdo = u64::from(number);
        let (what, object, node, cause): (Verdict, _, _, _) = match report {
            Report::NotInverse(half, len) => {
                let (normal, inverted) = (half.len.into(), len.into());
                let lengths = Srd001::Lengths { srdo, normal, inverted };
                let what = if half.len == len { Srd001::NotInverse { srdo } } else { lengths };
                (what.into(), object(6), node, Some(half.when))
            }
            Report::Swapped(half) => (Srd004::Swapped { srdo }.into(), object(5), node, Some(half.when)),
            Report::InverseMissing(half) => {
                (Srd004::NoInverted { srdo, id: inverse }.into(), object(6), node, Some(half.when))
            }
            Report::NormalMissing(half) => {
                (Srd004::NoNormal { srdo, id: normal }.into(), object(5), node, Some(half.when))
            }
            Report::Late(half, delay, tolerance, (node, index, limit)) => {
                let what = Srd002::Late { srdo, delay, limit, tolerance };
                (what.into(), Some(Mux { index, sub: 3 }), node, Some(half.when))
            }
            Report::Behind(half, delay, period) => {
                (Srd002::Behind { srdo, delay, period }.into(), object(3), node, Some(half.when))
            }
            Report::Slow(_, gap, cycle @ Cycle::Configured((node, index, limit))) => {
                let what = Srd003::Late { srdo, gap, limit, tolerance: cycle.allowance_ns() };
                (what.into(), Some(Mux { index, sub: 2 }), node, None)
            }
            Report::Slow(_, gap, Cycle::Learnt(period)) => {
                (Srd003::Paused { srdo, gap, period }.into(), object(2), node, None)
            }
            Report::Stopped(since, silence, Cycle::Configured((_, index, limit))) => {
                let what = Srd003::Stopped { srdo, silence, limit };
                (what.into(), Some(Mux { index, sub: 2 }), node, Some(since))
            }
            Report::Stopped(since, silence, Cycle::Learnt(period)) => {
                (Srd003::Gone { srdo, silence, period }.into(), object(2), node, Some(since))
            }
            Report::Idle(state) => (Srd005::InState { srdo, state }.into(), object(1), node, None),
        };
        let cause = cause.map(|when| when.at).filter(|cause| cause.no != cx.at.no);
        let finding = cx.verdict(what, Some(node), object, cause);
        match report {
            Report::Late(Half { when: since, .. }, ..)
            | Report::Behind(Half { when: since, .. }, ..)
            | Report::Slow(since, ..) => cx.report_timed(cx.excused(Rules::Srdo, since, finding)),
            Report::Stopped(..) => cx.report_of_node(finding),
            _ => cx.report(finding),
        }
    }

    /// Reports pairs that have not come for long at the current frame.
    #[inline]
    pub fn advance(&mut self, now_ns: Ns, cx: &mut Context<'_>) {
        if self.due.may_be_due(now_ns) {
            for (number, owed) in self.due.due(cx.when, &cx.evidence.recording) {
                if !self.stopped(number, owed, cx) {
                    self.due.open(number, Owed { since: cx.when, ..owed });
                }
            }
        }
    }

    /// Reports pairs that have not come by the end of the capture although they were due.
    pub fn finish(&mut self, cx: &mut Context<'_>) {
        let Self { due, pairs, limits, .. } = self;
        let cycle = |number: u8| {
            let place = usize::from(number);
            pairs.get(place)?.cycle(&limits.get(place).copied().unwrap_or_default())
        };
        let limit = |number: u8, owed: &Owed| cycle(number).map_or(owed.limit_ns, Cycle::limit_ns);
        for (number, owed) in due.overdue(cx.when, &cx.evidence.recording, limit) {
            self.stopped(number, owed, cx);
        }
    }

    /// Reports a pair that does not come any more; returns false if its absence shows nothing.
    #[cold]
    fn stopped(&mut self, number: u8, owed: Owed, cx: &mut Context<'_>) -> bool {
        let limits = self.limits.get(usize::from(number)).copied().unwrap_or_default();
        let Some(pair) = self.pairs.get_mut(usize::from(number)) else { return true };
        let (Some(cycle), Some(last)) = (pair.cycle(&limits), pair.heard) else { return true };
        let recording = &cx.evidence.recording;
        let Some(silence) = recording.between(last, cx.when) else { return true };
        let node = limits.producer.map_or(number, |(node, _)| node);
        // The recorder, or the whole bus, may have been silent.
        let now_ns = cx.at.t_ns.unwrap_or(Ns::ZERO);
        let period_ns = if owed.since.at == last.at { cycle.ns() } else { Ns::MAX };
        let held_back = recording.was_silent(node, now_ns - (silence - cycle.ns()), period_ns, now_ns);
        if held_back
            || cx.evidence.circumstances.excuse(Rules::Srdo, Some(node), (owed.since, cx.at), recording).is_some()
        {
            return false;
        }
        pair.began = None;
        self.raise(number, Report::Stopped(last, silence, cycle), cx);
        true
    }

    /// Takes a command or a reset after which a node, or all (`None`), send no pairs: none is owed.
    pub fn halted(&mut self, node: Option<u8>) {
        let limits = &self.limits;
        // Where no record is known, any node may be the producer.
        let producer = |number: u8| limits.get(usize::from(number)).and_then(|limits| limits.producer);
        let concerned = |number: &u8| node.is_none_or(|node| producer(*number).is_none_or(|(other, _)| other == node));
        self.due.void(concerned);
    }

    /// Restarts the time of all pairs after a silence of the whole bus.
    pub fn paused(&mut self, cx: &Context<'_>) {
        self.interrupt(cx.at.no, false);
        self.due.renew(cx.when);
    }

    /// Takes a node's report that it is not Operational. Only pairs before and after it are faults: the node may have
    /// changed its state since the last report, or been commanded during a pair.
    pub fn not_operational(&mut self, node: u8, cx: &mut Context<'_>) {
        let limits = &self.limits;
        let producer = |number: u8| limits.get(usize::from(number)).and_then(|limits| limits.producer);
        self.due.void(|number| producer(*number).map_or(*number, |(producer, _)| producer) == node);
        cx.evidence.pending.explain(cx.at, |it| it.code == Code::Srd003 && it.node == Some(node));
        for (pair, limits) in self.pairs.iter_mut().zip(&self.limits) {
            if pair.idle && limits.producer.is_some_and(|(producer, _)| producer == node) {
                pair.confirmed = true;
            }
        }
    }

    /// Takes a command that changes states, a start of a node, or a loss of frames: no gap is judged, and after a loss
    /// no half. `at` is the number of the current frame.
    pub fn interrupt(&mut self, at: u64, lost: bool) {
        *if lost { &mut self.lost } else { &mut self.began } = at;
        if lost {
            self.due = Obligations::default();
        }
        for pair in &mut self.pairs {
            if lost {
                *pair = SrdoPair { proven: pair.proven, ..SrdoPair::default() };
            }
            pair.began = None;
            (pair.idle, pair.confirmed) = (false, false);
        }
    }
}

impl SrdoPair {
    fn normal(&mut self, half: Half, recording: &Recording, seen: &mut SrdoResult) {
        self.heard = Some(half.when);
        if let Some(missing) = self.halves.missing.take().filter(|_| self.valid > PROOF) {
            self.began = None;
            seen.reports.push(Report::InverseMissing(missing));
        }
        if let Some(open) = self.halves.open.replace(half) {
            self.began = None;
            if std::mem::take(&mut self.halves.adjacent)
                && self.halves.early.is_some_and(|early| early.is_inverse(&open))
            {
                self.swapped(open, recording, seen);
                self.halves.early = None;
                self.halves.spare = Some(open);
            } else if let Some(older) = self.halves.older.replace(open).filter(|_| self.valid >= PROOF) {
                seen.reports.push(Report::InverseMissing(older));
            }
        }
    }

    fn inverse(&mut self, half: Half, recording: &Recording, seen: &mut SrdoResult) {
        match self.halves.open {
            Some(open) if open.is_inverse(&half) => {
                self.halves.open = None;
                self.halves.adjacent = false;
                self.halves.spare = None;
                self.valid = self.valid.saturating_add(1);
                self.repeats = self.last.is_some_and(|last| last.data == open.data && last.len == open.len);
                self.last = Some(open);
                self.halves.missing = self.halves.older.take();
                if let Some(lone) = self.halves.lone.take() {
                    self.began = None;
                    seen.reports.push(Report::NormalMissing(lone));
                }
                // With constant data the wrong order looks like the right one, shifted.
                if !self.halves.early.is_some_and(|early| early.is_inverse(&open)) {
                    self.swaps = 0;
                    self.halves.early = None;
                }
                seen.valid = Some(true);
            }
            Some(open) if self.halves.early.is_some_and(|early| early.is_inverse(&open)) => {
                self.halves.open = None;
                self.swapped(open, recording, seen);
                (self.halves.early, self.halves.adjacent) = (Some(half), true);
            }
            Some(_) if self.halves.older.or(self.halves.spare).is_some_and(|older| older.is_inverse(&half)) => {
                (self.halves.older, self.halves.spare) = (None, None);
                seen.valid = Some(true);
            }
            Some(open) => {
                self.halves.open = None;
                (self.halves.older, self.halves.spare) = (None, None);
                self.began = None;
                seen.valid = Some(false);
                self.wrong = self.wrong.saturating_add(1);
                seen.reports.push(Report::NotInverse(open, half.len));
            }
            // The inverse of earlier data, one frame late.
            None if self.halves.missing.take().is_some() => {}
            None => {
                if self.valid >= PROOF {
                    self.halves.lone = Some(half);
                }
                self.began = None;
                (self.halves.early, self.halves.adjacent) = (Some(half), true);
            }
        }
    }

    /// Takes inverted data before their normal data. Once, and close together, it may be a late frame.
    fn swapped(&mut self, normal: Half, recording: &Recording, seen: &mut SrdoResult) {
        let apart = self.halves.early.and_then(|early| recording.between(early.when, normal.when)).unwrap_or(Ns::ZERO);
        self.swaps = self.swaps.saturating_add(1);
        self.halves.lone = None;
        self.began = None;
        // Both are in the queue of one sender: the host's delay explains it once, not repeatedly, and rarely by more
        // than half.
        if self.swaps >= 2 || apart > recording.lag_ns() / 2 {
            seen.reports.push(Report::Swapped(normal));
        }
    }

    /// Judges the times of a pair completed by `half`.
    fn timing(&mut self, half: Half, recording: &Recording, limits: &Limits, seen: &mut SrdoResult) {
        let Some(normal) = self.last.filter(|normal| normal.when.at.t_ns.is_some()) else { return };
        let cycle = self.cycle(limits);
        if let (None, Some(Cycle::Learnt(period))) = (limits.validation, cycle) {
            let limit = period * PERIODS_OF_HALF;
            if recording.certainly_later(half.when, normal.when, limit + tolerance(limit)) {
                let delay = recording.between(normal.when, half.when).unwrap_or(Ns::ZERO);
                seen.reports.push(Report::Behind(normal, delay, period));
            }
        }
        if let Some(limit) = limits.validation {
            let allowance = tolerance(limit.2);
            if recording.certainly_later(half.when, normal.when, limit.2 + allowance) {
                let delay = recording.between(normal.when, half.when).unwrap_or(Ns::ZERO);
                seen.reports.push(Report::Late(normal, delay, allowance, limit));
            }
        }
        let before = self.began.replace(normal.when);
        let Some((before, gap)) = before.and_then(|at| Some((at, recording.between(at, normal.when)?))) else { return };
        if let Some(cycle) = cycle.filter(|cycle| recording.certainly_later(normal.when, before, cycle.limit_ns())) {
            seen.reports.push(Report::Slow(before, gap, cycle));
            self.timer = Timer::default();
        } else if recording.teaches(before)
            && recording.teaches(normal.when)
            && self.timer.ns().is_none_or(|known| gap <= known + known / EVEN_PART)
        {
            self.timer.take(gap, self.repeats);
        }
    }

    /// Returns the time after which the next pair is due: as configured, else as learnt.
    fn cycle(&self, limits: &Limits) -> Option<Cycle> {
        limits.cycle.map(Cycle::Configured).or_else(|| self.timer.ns().map(Cycle::Learnt))
    }
}

/// Returns the identifiers of a pair.
fn identifiers(number: u8) -> (CanId, CanId) {
    let normal = 0xFF + 2 * u16::from(number);
    (CanId::standard(normal), CanId::standard(normal + 1))
}

/// Returns a record; `None` if it names no pair or is not used.
fn record(id: u8, node: &Node, index: u16) -> Option<Record> {
    let (number, identifiers) = pair(id, node, index)?;
    let direction = node.value(index, 1).map(|(value, _)| value).filter(|direction| matches!(direction, 1 | 2))?;
    let time = |sub| {
        let ms = node.value(index, sub).map(|(ms, _)| (ms & 0xFFFF) as i64);
        ms.filter(|ms| *ms > 0).map(|ms| (id, index, Ns::from_ms(ms)))
    };
    let shown = [1, 5, 6].into_iter().filter_map(|sub| observed(node, index, sub)).max();
    Some(Record { number, sends: direction == 1, identifiers, shown, cycle: time(2), validation: time(3) })
}

/// Returns the frame in which the capture showed an object.
fn observed(node: &Node, index: u16, sub: u8) -> Option<u64> {
    match node.value(index, sub)?.1 {
        Provenance::Observed(frame) => Some(frame),
        _ => None,
    }
}

/// Returns the number and the identifiers of a record's pair; the first record has a default.
fn pair(id: u8, node: &Node, index: u16) -> Option<(u8, (CanId, CanId))> {
    let named = |sub| node.value(index, sub).map(|(value, _)| CobId::from_entry(value).id);
    let normal = match named(5) {
        Some(id) => id,
        None if index == 0x1301 && usize::from(id) <= PAIRS => identifiers(id).0,
        None => return None,
    };
    if !(0x101..=0x180).contains(&normal.raw()) || normal.is_extended() {
        return None;
    }
    let number = ((normal.raw() - 0xFF) / 2) as u8;
    let inverted = named(6).filter(|id| (0x101..=0x180).contains(&id.raw()));
    Some((number, (normal, inverted.unwrap_or(identifiers(number).1))))
}

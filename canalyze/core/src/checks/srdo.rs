//! SRDO (CiA 304, EN 50325-5): whether the two frames of a pair fit, in data, order and time.
//!
//! A pair is judged once it has shown that it is one: by a record 1301h to 1340h that is known, or by two pairs of
//! frames that were each other's inverse; on other networks these identifiers carry other things. What a capture
//! shows wrongly by itself is no fault: its edges cut pairs, and a frame of the capturing host may stand one later.
//! It must not decode; and no time is judged that is not configured.

use std::collections::{BTreeMap, BTreeSet};

use super::pdo::timing::tolerance;
use crate::configuration::Provenance;
use crate::context::Context;
use crate::evidence::{Recording, Rules, When};
use crate::finding::Verdict;
use crate::frame::{CanId, Frame};
use crate::node::{CobId, Node, PerNode};
use crate::rules::srdo::{Srd001, Srd002, Srd003, Srd004, Srd005};
use crate::services::sdo::wire::Mux;
use crate::wire::error_control::OPERATIONAL;

/// Pairs: 101h and 102h to 17Fh and 180h.
const PAIRS: usize = 64;
/// Pairs of frames that show that identifiers carry an SRDO, and after which no half is cut off by the capture's edge.
const PROOF: u64 = 2;
const MS: i64 = 1_000_000;

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

/// A configured time: whose, in which record, in ms.
type Limit = (u8, u16, i64);

/// What is configured for a pair.
#[derive(Clone, Copy, Debug, Default)]
struct Limits {
    /// Some record names the pair: the identifiers of normal and inverted data.
    identifiers: Option<(CanId, CanId)>,
    /// The node that is configured to send it, and its record.
    producer: Option<(u8, u16)>,
    /// The frame with which the capture has shown the record.
    shown: Option<u64>,
    /// Validation time (SRVT, sub-index 3): a receiver's, else the producer's.
    validation: Option<Limit>,
    /// Safeguard cycle time (SCT, sub-index 2), likewise.
    cycle: Option<Limit>,
}

/// What one record of a node says of a pair.
#[derive(Clone, Copy, Debug)]
struct Record {
    number: u8,
    /// The node sends the pair, and does not receive it.
    sends: bool,
    identifiers: (CanId, CanId),
    shown: Option<u64>,
    cycle: Option<Limit>,
    validation: Option<Limit>,
}

/// Frames of a pair that wait for their other half. In the right order each normal frame is `open` until its inverted
/// one comes; the others are what a loss, a swap or a late frame leaves.
#[derive(Clone, Copy, Debug, Default)]
struct Halves {
    /// Normal data that wait for their inverse.
    open: Option<Half>,
    /// Normal data before those, whose inverse has not come: it may still.
    older: Option<Half>,
    /// Normal data before the open ones that seem to have had their inverse before them.
    spare: Option<Half>,
    /// As `older`, when later data have got theirs.
    missing: Option<Half>,
    /// The last inverted data that had no normal data before them.
    early: Option<Half>,
    /// They came right before the open ones.
    adjacent: bool,
    /// Inverted data in a pair that was complete before, until the next complete pair proves that half of one is gone.
    lone: Option<Half>,
}

/// What was seen of a pair.
#[derive(Clone, Debug, Default)]
struct Pair {
    halves: Halves,
    /// Pairs in a row that came in the wrong order.
    swaps: u8,
    /// Its first frame since the capture's edge or a loss of frames.
    first: Option<u64>,
    /// It has shown that it is an SRDO.
    proven: bool,
    /// Pairs that were not each other's inverse, since the capture's edge or a loss of frames.
    wrong: u64,
    /// Pairs that were right since then, and the normal data of the last of them.
    valid: u64,
    last: Option<Half>,
    /// Where the last pair began, if it was right and nothing has happened since.
    began: Option<When>,
    /// A pair came though the producer is known not to be Operational.
    idle: bool,
    /// And the producer has reported since that it is not.
    confirmed: bool,
}

/// What a frame has shown.
#[derive(Clone, Copy, Debug)]
enum Report {
    /// And the length of the second frame.
    NotInverse(Half, u8),
    Swapped(Half),
    InverseMissing(Half),
    NormalMissing(Half),
    Late(Half, i64, i64, Limit),
    Slow(When, i64, i64, Limit),
    Idle(u8),
}

/// What a frame has shown, until its event is there.
#[derive(Debug, Default)]
pub struct Seen {
    /// Whether these are the inverse of the normal data before them; `None` where that is not known.
    pub valid: Option<bool>,
    number: u8,
    reports: Vec<Report>,
}

/// The SRDOs of a bus.
#[derive(Debug, Default)]
pub struct Srdos {
    /// By number, made with the first frame.
    pairs: Vec<Pair>,
    limits: Vec<Limits>,
    records: BTreeMap<(u8, u16), Record>,
    /// Records that are other ones by now.
    stale: BTreeSet<(u8, u16)>,
    /// Frames were lost before this one.
    lost: u64,
    /// A command has changed states with this one, or a node has started.
    began: u64,
}

impl Srdos {
    /// A node's record is another one now.
    pub fn renewed(&mut self, node: u8, index: u16) {
        self.stale.insert((node, index));
    }

    /// Finds what is configured, by the number of the pair.
    #[cold]
    fn compile(&mut self, nodes: &PerNode<Node>) {
        for (id, index) in std::mem::take(&mut self.stale) {
            match nodes.get(id).and_then(|node| record(id, node, index)) {
                Some(record) => _ = self.records.insert((id, index), record),
                None => _ = self.records.remove(&(id, index)),
            }
        }
        self.limits = vec![Limits::default(); PAIRS + 1];
        // Producers first: what receivers are configured to overrules.
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

    /// Follows a data frame of pair `number`. `state` is the NMT state of a node, where known.
    pub fn follow(
        &mut self,
        number: u8,
        inverted: bool,
        frame: &Frame,
        nodes: &PerNode<Node>,
        cx: &Context<'_>,
        state: impl Fn(u8) -> Option<u8>,
    ) -> Seen {
        if !self.stale.is_empty() {
            self.compile(nodes);
        }
        if self.pairs.is_empty() {
            self.pairs = vec![Pair::default(); PAIRS + 1];
        }
        let limits = self.limits.get(usize::from(number)).copied().unwrap_or_default();
        let mut seen = Seen { valid: None, number, reports: Vec::new() };
        let Some(pair) = self.pairs.get_mut(usize::from(number)) else { return seen };
        if !(1..=8).contains(&frame.len) {
            *pair = Pair { proven: pair.proven, ..Pair::default() };
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
            let state = limits.producer.and_then(|(node, _)| state(node)).filter(|state| *state != OPERATIONAL);
            pair.idle = state.is_some();
            match state {
                Some(state) if pair.confirmed => seen.reports.push(Report::Idle(state)),
                Some(_) => {}
                None => pair.confirmed = false,
            }
            pair.timing(half, recording, &limits, &mut seen);
        }
        pair.proven |= pair.valid >= PROOF;
        // What an edge has cut off may make one pair wrong.
        let first = *pair.first.get_or_insert(frame.no);
        // One that began after its record was shown and a command was given has lost nothing to an edge.
        let whole = limits.shown.is_some_and(|shown| shown > self.lost && first > self.began.max(shown));
        let whole = whole && self.began > self.lost;
        let settled = pair.valid > 0 || pair.wrong > 1 || whole;
        if !settled || !(pair.proven || limits.identifiers.is_some()) {
            seen.reports.clear();
            seen.valid = seen.valid.filter(|valid| *valid);
        }
        seen
    }

    /// Raises what [`Self::follow`] has found.
    pub fn judge(&self, seen: &Seen, cx: &mut Context<'_>) {
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
            Report::Late(half, delay, tolerance, (node, index, ms)) => {
                let what = Srd002::Late { srdo, delay, limit: ms * MS, tolerance };
                (what.into(), Some(Mux { index, sub: 3 }), node, Some(half.when))
            }
            Report::Slow(_, gap, tolerance, (node, index, ms)) => {
                let what = Srd003::Late { srdo, gap, limit: ms * MS, tolerance };
                (what.into(), Some(Mux { index, sub: 2 }), node, None)
            }
            Report::Idle(state) => (Srd005::InState { srdo, state }.into(), object(1), node, None),
        };
        let cause = cause.map(|when| when.at).filter(|cause| cause.no != cx.at.no);
        let finding = cx.verdict(what, Some(node), object, cause);
        let (Report::Late(Half { when: since, .. }, ..) | Report::Slow(since, ..)) = report else {
            return cx.report(finding);
        };
        cx.report_timed(cx.excused(Rules::Srdo, since, finding));
    }

    /// A node shows that it is not Operational. Only what it sends before and after that is its fault: it may have
    /// changed its state by itself since it reported it last, or have been commanded to while a pair was under way.
    pub fn not_operational(&mut self, node: u8) {
        for (pair, limits) in self.pairs.iter_mut().zip(&self.limits) {
            if pair.idle && limits.producer.is_some_and(|(producer, _)| producer == node) {
                pair.confirmed = true;
            }
        }
    }

    /// A command has changed states, a node has started, or frames were lost: no gap can be judged, and after a
    /// loss no half. `at`: the number of the frame at hand.
    pub fn interrupt(&mut self, at: u64, lost: bool) {
        *if lost { &mut self.lost } else { &mut self.began } = at;
        for pair in &mut self.pairs {
            if lost {
                *pair = Pair { proven: pair.proven, ..Pair::default() };
            }
            pair.began = None;
            (pair.idle, pair.confirmed) = (false, false);
        }
    }
}

impl Pair {
    fn normal(&mut self, half: Half, recording: &Recording, seen: &mut Seen) {
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

    fn inverse(&mut self, half: Half, recording: &Recording, seen: &mut Seen) {
        match self.halves.open {
            Some(open) if open.is_inverse(&half) => {
                self.halves.open = None;
                self.halves.adjacent = false;
                self.halves.spare = None;
                self.valid = self.valid.saturating_add(1);
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

    /// Inverted data came before their normal data. Once is what a late frame looks like, if they are close.
    fn swapped(&mut self, normal: Half, recording: &Recording, seen: &mut Seen) {
        let apart = self.halves.early.and_then(|early| recording.between(early.when, normal.when)).unwrap_or(0);
        self.swaps = self.swaps.saturating_add(1);
        self.halves.lone = None;
        self.began = None;
        // Both are of one sender, and wait in one queue: the host's lag explains it once, and not again and again; and
        // one is hardly overtaken by more than half of it.
        if self.swaps >= 2 || apart > recording.lag_ns() / 2 {
            seen.reports.push(Report::Swapped(normal));
        }
    }

    /// The times of a pair that has become complete with `half`.
    fn timing(&mut self, half: Half, recording: &Recording, limits: &Limits, seen: &mut Seen) {
        let Some(normal) = self.last.filter(|normal| normal.when.at.t_ns.is_some()) else { return };
        if let Some(limit) = limits.validation {
            let allowance = tolerance(limit.2 * MS);
            if recording.certainly_later(half.when, normal.when, limit.2 * MS + allowance) {
                let delay = recording.between(normal.when, half.when).unwrap_or(0);
                seen.reports.push(Report::Late(normal, delay, allowance, limit));
            }
        }
        if let (Some(before), Some(limit)) = (self.began, limits.cycle) {
            let allowance = tolerance(limit.2 * MS).max(limit.2 * MS / 10);
            if recording.certainly_later(normal.when, before, limit.2 * MS + allowance) {
                let gap = recording.between(before, normal.when).unwrap_or(0);
                seen.reports.push(Report::Slow(before, gap, allowance, limit));
            }
        }
        self.began = Some(normal.when);
    }
}

/// The identifiers of a pair.
fn identifiers(number: u8) -> (CanId, CanId) {
    let normal = 0xFF + 2 * u16::from(number);
    (CanId::standard(normal), CanId::standard(normal + 1))
}

/// What a record says of a pair; `None` if it names none, or is not used.
fn record(id: u8, node: &Node, index: u16) -> Option<Record> {
    let (number, identifiers) = pair(id, node, index)?;
    let direction = node.value(index, 1).map(|(value, _)| value).filter(|direction| matches!(direction, 1 | 2))?;
    let time = |sub| {
        let ms = node.value(index, sub).map(|(ms, _)| (ms & 0xFFFF) as i64);
        ms.filter(|ms| *ms > 0).map(|ms| (id, index, ms))
    };
    let shown = [1, 5, 6].into_iter().filter_map(|sub| observed(node, index, sub)).max();
    Some(Record { number, sends: direction == 1, identifiers, shown, cycle: time(2), validation: time(3) })
}

/// The frame with which the capture has shown an object.
fn observed(node: &Node, index: u16, sub: u8) -> Option<u64> {
    match node.value(index, sub)?.1 {
        Provenance::Observed(frame) => Some(frame),
        _ => None,
    }
}

/// The number and the identifiers of the pair that a record names; the first record has a default.
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

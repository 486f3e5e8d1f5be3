//! The comparison of problems: problems matched by kind, bus, subject and object.
//!
//! Matching problems are paired in order. Only the range that both captures cover is judged, and only if both have
//! timestamps: without them silence does not show. A consequence of a problem that one capture lacks is not a
//! difference of its own. Nothing is put into words here.

use std::collections::{BTreeMap, BTreeSet};

use super::DiffSettings;
use super::alignment::Alignment;
use super::digest::{CapturePlace, Digest};
use crate::bytes::frame::{BusId, FrameRef};
use crate::bytes::ns::Ns;
use crate::problems::kinds::ProblemKind;
use crate::problems::problem::{Problem, Status};
use crate::problems::roles::KindRole;
use crate::rules::finding::Quantity;
use crate::sdo::wire::Mux;

/// Commands and repeated frames this long before a problem may explain it, in ns.
const CONTEXT_NS: Ns = Ns::from_s(3);
/// Durations that differ by no more than this are equal, in ns.
const CLOSE_NS: Ns = Ns::from_ms(10);
/// Maximum number of steps from a problem to its first cause.
const CHAIN: usize = 16;

/// A problem of one capture only, or one that differs.
#[derive(Clone, Debug)]
pub struct ProblemDifference {
    /// The bus, in A and in B.
    pub bus: [Option<BusId>; 2],
    /// The index of the problem in each capture.
    pub sides: [Option<usize>; 2],
    /// The properties that differ; empty if only one has it.
    pub differs: Vec<Differs>,
}

/// A property of a problem that differs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Differs {
    /// The status.
    Status,
    /// The duration.
    Duration,
    /// The number of occurrences.
    Count,
    /// The cause.
    Cause,
}

impl Differs {
    /// The word in machine output.
    pub fn name(self) -> &'static str {
        match self {
            Self::Status => "status",
            Self::Duration => "duration",
            Self::Count => "count",
            Self::Cause => "cause",
        }
    }
}

/// The key of matching problems.
type StoryKey = (ProblemKind, (Option<u8>, u128), (Option<u8>, u8), Option<(bool, u16)>, Option<(u16, u8)>);

fn key(one: &Problem) -> StoryKey {
    let object = one.facts.iter().find_map(|(name, value)| match value {
        Quantity::Object(Mux { index, sub }) if *name == "object" => Some((*index, *sub)),
        _ => None,
    });
    let subject = one.subject;
    (one.kind, (subject.node, subject.nodes), (subject.axis, subject.axes), subject.pdo, object)
}

/// The frames that have to be captured for a problem to show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Needs {
    /// Its own frames.
    Nothing,
    /// Commands and repeated frames shortly before.
    Context,
    /// The configuration of nodes, or all earlier occurrences.
    Everything,
}

fn needs(kind: ProblemKind) -> Needs {
    match kind {
        _ if kind.is(KindRole::Refusal) || kind.is(KindRole::ComparedAlone) => Needs::Nothing,
        _ if kind.is(KindRole::ComparedInContext) => Needs::Context,
        _ => Needs::Everything,
    }
}

/// Kinds that may be mistaken for one another, depending on what was seen before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Family {
    Refusal,
    Error,
    Service,
    Own(ProblemKind),
}

fn family(kind: ProblemKind) -> Family {
    match kind {
        _ if kind.is(KindRole::Refusal) => Family::Refusal,
        _ if kind.is(KindRole::Error) => Family::Error,
        _ if kind.is(KindRole::Sdo) => Family::Service,
        other => Family::Own(other),
    }
}

/// One capture during the comparison.
struct Compared<'a> {
    /// 0 or 1.
    number: usize,
    digest: &'a Digest,
    alignment: &'a Alignment,
}

impl<'a> Compared<'a> {
    fn get(&self, place: usize) -> Option<&'a Problem> {
        self.digest.problems.get(place)
    }

    /// Returns true if the other capture surely covers a problem from its start to a frame.
    fn covers(&self, one: &Problem, to: FrameRef) -> bool {
        let needs = needs(one.kind);
        if needs == Needs::Everything && self.is_apart() {
            return false;
        }
        let before = if self.alignment.begins_apart() && needs == Needs::Context { CONTEXT_NS } else { Ns::ZERO };
        let (from, to) = (CapturePlace::of(one.begin).on(true), CapturePlace::of(to).on(true));
        self.alignment.covers(self.number, from - before, to)
    }

    /// Returns true if one capture begins before the other one, or ends after it.
    fn is_apart(&self) -> bool {
        self.alignment.beyond.iter().any(|(before, after)| *before || *after)
    }

    /// Returns the position of a frame on the scale of A.
    fn on_a(&self, at: FrameRef) -> Ns {
        match self.number {
            0 => CapturePlace::of(at).on(true),
            _ => self.alignment.to_a(CapturePlace::of(at).on(true)),
        }
    }

    /// Returns true if this capture has a problem of the same node and family on a bus around a position on the scale
    /// of A, and the captures do not begin and end together: the other one's problem may be a part of it, or be
    /// reported as another kind.
    fn has_around(&self, bus: Option<BusId>, one: &Problem, position: Ns) -> bool {
        let around = |other: &Problem| {
            let lasts = other.end.is_none_or(|end| self.on_a(end) + CONTEXT_NS >= position);
            lasts && self.on_a(other.begin) <= position + CONTEXT_NS
        };
        let same = |other: &&Problem| {
            Some(other.bus) == bus && other.subject.node == one.subject.node && family(other.kind) == family(one.kind)
        };
        self.is_apart() && self.digest.problems.iter().filter(same).any(around)
    }

    /// Returns the problems of a bus that the other capture may have, too, by their keys.
    fn of_bus(&self, bus: Option<BusId>) -> BTreeMap<StoryKey, Vec<usize>> {
        let mut found: BTreeMap<StoryKey, Vec<usize>> = BTreeMap::new();
        for (place, one) in self.digest.problems.iter().enumerate().filter(|(_, one)| Some(one.bus) == bus) {
            if self.alignment.may_cover(self.number, CapturePlace::of(one.begin).on(true)) {
                found.entry(key(one)).or_default().push(place);
            }
        }
        found
    }

    /// Returns the index of the first cause of a problem.
    fn root(&self, place: usize) -> usize {
        let mut at = place;
        for _ in 0..CHAIN {
            let cause = self.get(at).and_then(|one| self.digest.cause(one)).map(|cause| cause.id);
            let place = cause.and_then(|id| self.digest.problems.iter().position(|one| one.id == id));
            let Some(place) = place else { break };
            at = place;
        }
        at
    }

    /// Returns true if it is surely in the other capture's time and not harmless.
    fn counts(&self, place: usize) -> bool {
        self.get(place).is_some_and(|one| one.status != Status::Harmless && self.covers(one, one.noticed))
    }
}

/// Compares the problems of two captures. Also returns the numbers of those in ranges that the other one does not
/// cover.
pub(super) fn compare(
    a: &Digest,
    b: &Digest,
    pairs: &[(Option<BusId>, Option<BusId>)],
    settings: &DiffSettings,
    alignment: &Alignment,
) -> (Vec<ProblemDifference>, [u64; 2]) {
    let (mut found, mut outside) = (Vec::new(), [0; 2]);
    if !alignment.by_time || alignment.is_blurred() || !(a.diagnosed && b.diagnosed) {
        return (found, outside);
    }
    let sides = [Compared { number: 0, digest: a, alignment }, Compared { number: 1, digest: b, alignment }];
    let [of_a, of_b] = &sides;
    for (one, other) in pairs {
        let bus = [*one, *other];
        let (mut mine, mut others) = (of_a.of_bus(*one), of_b.of_bus(*other));
        let keys: BTreeSet<StoryKey> = mine.keys().chain(others.keys()).copied().collect();
        let mut matched: [BTreeSet<usize>; 2] = Default::default();
        let mut left: [Vec<usize>; 2] = Default::default();
        for key in keys {
            let (mut mine, mut others) =
                (mine.remove(&key).unwrap_or_default(), others.remove(&key).unwrap_or_default());
            let common = mine.len().min(others.len());
            let (more, further) = (mine.split_off(common), others.split_off(common));
            for (in_a, in_b) in mine.into_iter().zip(others) {
                let [of_a_matched, of_b_matched] = &mut matched;
                of_a_matched.insert(in_a);
                of_b_matched.insert(in_b);
                let differs = differing([of_a, of_b], [in_a, in_b], settings.tolerance);
                if !differs.is_empty() {
                    found.push(ProblemDifference { bus, sides: [Some(in_a), Some(in_b)], differs });
                }
            }
            let [left_a, left_b] = &mut left;
            left_a.extend(more);
            left_b.extend(further);
        }
        for (((side, left), matched), outside) in sides.iter().zip(left).zip(&matched).zip(&mut outside) {
            for place in left {
                let root = side.root(place);
                if side.get(place).is_none_or(|one| one.status == Status::Harmless)
                    || (root != place && !matched.contains(&root))
                {
                    continue;
                }
                let other = if side.number == 0 { of_b } else { of_a };
                let its_bus = bus.get(other.number).copied().flatten();
                let parted = side.get(place).is_some_and(|one| other.has_around(its_bus, one, side.on_a(one.begin)));
                // Frames beyond a cut may make it another consequence.
                let is_sure = root == place || !side.is_apart();
                if side.counts(place) && is_sure && !parted {
                    let mut sides = [None; 2];
                    if let Some(slot) = sides.get_mut(side.number) {
                        *slot = Some(place);
                    }
                    found.push(ProblemDifference { bus, sides, differs: Vec::new() });
                } else {
                    *outside += 1;
                }
            }
        }
    }
    found.sort_by_key(|one| match one.sides {
        [Some(place), None] => (0, place),
        [None, Some(place)] => (1, place),
        [in_a, _] => (2, in_a.unwrap_or(usize::MAX)),
    });
    (found, outside)
}

/// Returns the properties in which a problem of A differs from its counterpart in B, as far as both captures show
/// them.
fn differing(sides: [&Compared<'_>; 2], places: [usize; 2], tolerance: f64) -> Vec<Differs> {
    let [of_a, of_b] = sides;
    let [in_a, in_b] = places;
    let (Some(a), Some(b)) = (of_a.get(in_a), of_b.get(in_b)) else { return Vec::new() };
    let mut differs = Vec::new();
    if [a, b].iter().all(|one| one.status == Status::Harmless) {
        return differs;
    }
    let shown = |side: &Compared<'_>, one: &Problem| one.end.is_none_or(|end| side.covers(one, end));
    let both_shown = shown(of_a, a) && shown(of_b, b);
    let is_known = [a, b].iter().all(|one| one.status != Status::Unknown);
    if a.status != b.status && is_known && both_shown {
        differs.push(Differs::Status);
    }
    let lasted = [a, b].map(lasted_ns);
    if let [Some(one), Some(other)] = lasted
        && both_shown
        && a.status == b.status
        && apart(one.as_ns() as f64, other.as_ns() as f64, tolerance)
        && one.abs_diff(other) > CLOSE_NS.abs()
    {
        differs.push(Differs::Duration);
    }
    let ends_apart = of_a.alignment.beyond.iter().any(|(_, after)| *after);
    let often = a.repeats.count != b.repeats.count;
    if often && both_shown && !ends_apart && apart(a.repeats.count as f64, b.repeats.count as f64, tolerance) {
        differs.push(Differs::Count);
    }
    let causes = [(of_a, a), (of_b, b)].map(|(side, one)| side.digest.cause(one).map(|cause| (side, cause)));
    let covered = causes.iter().flatten().all(|(side, cause)| side.covers(cause, cause.begin));
    let [cause_a, cause_b] = causes.map(|cause| cause.map(|(_, cause)| cause.kind));
    if cause_a != cause_b && covered && of_a.covers(a, a.noticed) && of_b.covers(b, b.noticed) {
        differs.push(Differs::Cause);
    }
    differs
}

/// Returns true if two figures differ by more than a fraction of the smaller one.
fn apart(one: f64, other: f64, tolerance: f64) -> bool {
    (one - other).abs() > tolerance * one.min(other)
}

/// Returns the duration of a problem, or the longest one if it repeated, in ns; `None` while it is not over.
pub fn lasted_ns(one: &Problem) -> Option<Ns> {
    let end = one.end?;
    match one.repeats.count {
        1 => end.since(one.begin),
        _ => Some(one.repeats.longest_ns),
    }
}

//! What went wrong in one capture and not in the other, or otherwise: incidents matched by kind, bus, subject and object.
//!
//! Of those that match, the first of one belongs to the first of the other. Only what both captures cover is judged, and
//! only with stamps on both sides: without them silence does not show. What follows from a story that one capture lacks is
//! no difference of its own. It must not put anything into words.

use std::collections::{BTreeMap, BTreeSet};

use super::Settings;
use super::alignment::Alignment;
use super::digest::{Digest, Place};
use crate::diagnosis::incident::{Incident, Status};
use crate::diagnosis::kinds::Kind;
use crate::finding::Quantity;
use crate::frame::{BusId, FrameRef};
use crate::services::sdo::wire::Mux;

/// What was commanded so long before an incident may explain it, in ns.
const CONTEXT_NS: i64 = 3_000_000_000;
/// Durations that part by no more than this are the same, in ns.
const CLOSE_NS: i64 = 10_000_000;
/// Causes of causes that are followed.
const CHAIN: usize = 16;

/// An incident of one capture only, or one that both have and that is another one in each.
#[derive(Clone, Debug)]
pub struct StoryDifference {
    /// The bus, in A and in B.
    pub bus: [Option<BusId>; 2],
    /// The place of the incident among those of each capture.
    pub sides: [Option<usize>; 2],
    /// In what both differ; nothing where only one has it.
    pub differs: Vec<Differs>,
}

/// In what respect an incident is another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Differs {
    /// How it stands.
    Status,
    /// How long it lasted.
    Duration,
    /// How often it came.
    Count,
    /// From what it comes.
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

/// What incidents have in common that are the same.
type Key = (Kind, (Option<u8>, u128), (Option<u8>, u8), Option<(bool, u16)>, Option<(u16, u8)>);

fn key(one: &Incident) -> Key {
    let object = one.facts.iter().find_map(|(name, value)| match value {
        Quantity::Object(Mux { index, sub }) if *name == "object" => Some((*index, *sub)),
        _ => None,
    });
    let subject = one.subject;
    (one.kind, (subject.node, subject.nodes), (subject.axis, subject.axes), subject.pdo, object)
}

/// One capture while it is compared.
struct Side<'a> {
    /// 0 or 1.
    number: usize,
    digest: &'a Digest,
    alignment: &'a Alignment,
}

impl<'a> Side<'a> {
    fn get(&self, place: usize) -> Option<&'a Incident> {
        self.digest.incidents.get(place)
    }

    fn covers(&self, from: FrameRef, to: FrameRef) -> bool {
        let before = if self.alignment.begins_apart() { CONTEXT_NS } else { 0 };
        let (from, to) = (Place::of(from).on(true), Place::of(to).on(true));
        self.alignment.covers(self.number, from.saturating_sub(before), to)
    }

    /// The incidents of a bus that the other capture may have, too, by what they have in common.
    fn of_bus(&self, bus: Option<BusId>) -> BTreeMap<Key, Vec<usize>> {
        let mut found: BTreeMap<Key, Vec<usize>> = BTreeMap::new();
        for (place, one) in self.digest.incidents.iter().enumerate().filter(|(_, one)| Some(one.bus) == bus) {
            if self.alignment.may_cover(self.number, Place::of(one.begin).on(true)) {
                found.entry(key(one)).or_default().push(place);
            }
        }
        found
    }

    /// The place of the incident that is the root of one.
    fn root(&self, place: usize) -> usize {
        let mut at = place;
        for _ in 0..CHAIN {
            let cause = self.get(at).and_then(|one| self.digest.cause(one)).map(|cause| cause.id);
            let place = cause.and_then(|id| self.digest.incidents.iter().position(|one| one.id == id));
            let Some(place) = place else { break };
            at = place;
        }
        at
    }

    /// Whether it is surely in the other capture's time and more than harmless.
    fn counts(&self, place: usize) -> bool {
        self.get(place).is_some_and(|one| one.status != Status::Harmless && self.covers(one.begin, one.noticed))
    }
}

/// Compares what went wrong in two captures; and how much of it lies where the other one shows nothing.
pub(super) fn compare(
    a: &Digest,
    b: &Digest,
    pairs: &[(Option<BusId>, Option<BusId>)],
    settings: &Settings,
    alignment: &Alignment,
) -> (Vec<StoryDifference>, [u64; 2]) {
    let (mut found, mut outside) = (Vec::new(), [0; 2]);
    if !alignment.by_time || alignment.is_blurred() || !(a.diagnosed && b.diagnosed) {
        return (found, outside);
    }
    let sides = [Side { number: 0, digest: a, alignment }, Side { number: 1, digest: b, alignment }];
    let [of_a, of_b] = &sides;
    for (one, other) in pairs {
        let bus = [*one, *other];
        let (mut mine, mut others) = (of_a.of_bus(*one), of_b.of_bus(*other));
        let keys: BTreeSet<Key> = mine.keys().chain(others.keys()).copied().collect();
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
                    found.push(StoryDifference { bus, sides: [Some(in_a), Some(in_b)], differs });
                }
            }
            let [left_a, left_b] = &mut left;
            left_a.extend(more);
            left_b.extend(further);
        }
        for (((side, left), matched), outside) in sides.iter().zip(left).zip(&matched).zip(&mut outside) {
            for place in left {
                let root = side.root(place);
                if !side.get(place).is_some_and(|one| one.status != Status::Harmless)
                    || (root != place && !matched.contains(&root))
                {
                    continue;
                }
                if side.counts(place) {
                    let mut sides = [None; 2];
                    if let Some(slot) = sides.get_mut(side.number) {
                        *slot = Some(place);
                    }
                    found.push(StoryDifference { bus, sides, differs: Vec::new() });
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

/// In what an incident of A differs from the same one of B, as far as both captures show it.
fn differing(sides: [&Side<'_>; 2], places: [usize; 2], tolerance: f64) -> Vec<Differs> {
    let [of_a, of_b] = sides;
    let [in_a, in_b] = places;
    let (Some(a), Some(b)) = (of_a.get(in_a), of_b.get(in_b)) else { return Vec::new() };
    let mut differs = Vec::new();
    if [a, b].iter().all(|one| one.status == Status::Harmless) {
        return differs;
    }
    let shown = |side: &Side<'_>, one: &Incident| one.end.is_none_or(|end| side.covers(one.begin, end));
    let both_shown = shown(of_a, a) && shown(of_b, b);
    let is_known = [a, b].iter().all(|one| one.status != Status::Unknown);
    if a.status != b.status && is_known && both_shown {
        differs.push(Differs::Status);
    }
    let lasted = [a, b].map(lasted_ns);
    if let [Some(one), Some(other)] = lasted
        && both_shown
        && a.status == b.status
        && apart(one as f64, other as f64, tolerance)
        && one.abs_diff(other) > CLOSE_NS.unsigned_abs()
    {
        differs.push(Differs::Duration);
    }
    let ends_apart = of_a.alignment.beyond.iter().any(|(_, after)| *after);
    let often = a.repeats.count != b.repeats.count;
    if often && both_shown && !ends_apart && apart(a.repeats.count as f64, b.repeats.count as f64, tolerance) {
        differs.push(Differs::Count);
    }
    let causes = [(of_a, a), (of_b, b)].map(|(side, one)| side.digest.cause(one).map(|cause| (side, cause)));
    let covered = causes.iter().flatten().all(|(side, cause)| side.covers(cause.begin, cause.begin));
    let [cause_a, cause_b] = causes.map(|cause| cause.map(|(_, cause)| cause.kind));
    if cause_a != cause_b && covered && of_a.covers(a.begin, a.noticed) && of_b.covers(b.begin, b.noticed) {
        differs.push(Differs::Cause);
    }
    differs
}

/// Whether two figures part by more than a part of the smaller one.
fn apart(one: f64, other: f64, tolerance: f64) -> bool {
    (one - other).abs() > tolerance * one.min(other)
}

/// How long it lasted, of one that came again the longest time, in ns; `None` where it is not over.
pub fn lasted_ns(one: &Incident) -> Option<i64> {
    let end = one.end?;
    match one.repeats.count {
        1 => end.since(one.begin),
        _ => Some(one.repeats.longest_ns),
    }
}

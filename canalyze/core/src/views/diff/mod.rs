//! The comparison of two captures as CANopen: actions of nodes, not bytes or times.
//!
//! `digest` keeps the data of one capture while it streams by. `alignment` relates the two and finds the range that
//! both cover. `items` compares actions in order (`align`), `cyclic` periodic frames, `problems` problems; `found`
//! collects the differences. What a capture cannot show (frames before its beginning, times without timestamps) is not
//! a difference. Nothing is put into words here.

use crate::bytes::ns::Ns;

mod align;
pub mod alignment;
mod cyclic;
pub mod difference;
pub mod digest;
mod found;
mod items;
mod likeness;
pub mod problems;
#[cfg(test)]
mod tests;

use std::borrow::Cow;
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};

use self::alignment::{Alignment, Anchor, Sessions};
use self::cyclic::StreamPair;
use self::difference::{CaptureSide, Difference, DifferenceKind, Shows};
use self::digest::{BusDigest, CapturePlace, CyclicStream, Digest, ItemKind, Service, Version};
use self::found::Found;
use self::items::Streams;
use self::problems::ProblemDifference;
use crate::bytes::frame::{BusId, CanId};
use crate::rules::finding::{Code, Finding, Quantity, Severity};
use crate::sdo::wire::Mux;

/// Settings of a comparison.
#[derive(Clone, Debug)]
pub struct DiffSettings {
    /// The tolerance of periods, as a fraction of the shorter one.
    pub tolerance: f64,
    /// Names of buses that are one bus: in A, in B.
    pub buses: Vec<(String, String)>,
}

/// The result of a comparison.
#[derive(Debug)]
pub struct Comparison {
    /// The differences, in order.
    pub differences: Vec<Difference>,
    /// The number of further ones, which are not kept.
    pub more: u64,
    /// Problems that only one capture has, or that differ.
    pub stories: Vec<ProblemDifference>,
    /// The relation of both.
    pub alignment: Alignment,
    /// The number of transfers, commands, states and the like of each in ranges that the other one does not cover.
    pub outside: [u64; 2],
}

impl Comparison {
    /// Returns the number of differences, including those of problems.
    pub fn count(&self) -> u64 {
        (self.differences.len() + self.stories.len()) as u64 + self.more
    }
}

/// If no more than one in this many varying values is equal in both captures, it is a coincidence.
const CHANCE: usize = 20;

/// The rule, node and object of a finding.
type Raised = (Code, Option<u8>, Option<Mux>);

/// Compares two captures.
pub fn compare(a: &Digest, b: &Digest, settings: &DiffSettings) -> Comparison {
    let pairs = paired(a, b, &settings.buses);
    let (anchors, sessions, vague) = anchors(a, b, &pairs);
    let mut alignment = Alignment::new(a, b, anchors, sessions);
    if vague && !alignment.by_time {
        alignment.blur();
    }
    let mut found = Found::new(&alignment);
    for (in_a, in_b) in &pairs {
        found.bus = [*in_a, *in_b];
        let of_a = in_a.and_then(|bus| a.lines.get(&bus));
        let of_b = in_b.and_then(|bus| b.lines.get(&bus));
        match (of_a, of_b) {
            (Some(one), Some(other)) => lines([one, other], [a, b], settings, &mut found),
            (one, other) => absent([one, other], &mut found),
        }
    }
    let Found { mut all, more, mut outside, .. } = found;
    let (stories, beyond) = problems::compare(a, b, &pairs, settings, &alignment);
    outside.iter_mut().zip(beyond).for_each(|(sum, more)| *sum += more);
    all.sort_by(|one, other| one.order.cmp(&other.order).then(one.what.cmp(&other.what)));
    Comparison { differences: all, more, stories, alignment, outside }
}

/// Pairs the buses of both: as given, by name, then by their common content.
fn paired(a: &Digest, b: &Digest, given: &[(String, String)]) -> Vec<(Option<BusId>, Option<BusId>)> {
    let mut left_a: Vec<BusId> = a.lines.keys().copied().collect();
    let mut left_b: Vec<BusId> = b.lines.keys().copied().collect();
    let mut pairs = Vec::new();
    let mut take = |left_a: &mut Vec<BusId>, left_b: &mut Vec<BusId>, one: BusId, other: BusId| {
        left_a.retain(|bus| *bus != one);
        left_b.retain(|bus| *bus != other);
        pairs.push((Some(one), Some(other)));
    };
    let named =
        |digest: &Digest, left: &[BusId], name: &[u8]| left.iter().copied().find(|bus| digest.buses.name(*bus) == name);
    for (one, other) in given {
        if let (Some(one), Some(other)) = (named(a, &left_a, one.as_bytes()), named(b, &left_b, other.as_bytes())) {
            take(&mut left_a, &mut left_b, one, other);
        }
    }
    for one in left_a.clone() {
        if let Some(other) = named(b, &left_b, a.buses.name(one)) {
            take(&mut left_a, &mut left_b, one, other);
        }
    }
    while !left_a.is_empty() && !left_b.is_empty() {
        let common = |one: BusId, other: BusId| match (a.lines.get(&one), b.lines.get(&other)) {
            (Some(one), Some(other)) => one.nodes.keys().filter(|node| other.nodes.contains_key(node)).count(),
            _ => 0,
        };
        let all = left_a.iter().flat_map(|one| left_b.iter().map(move |other| (*one, *other)));
        // Of equal pairs the first buses come first.
        let best = all.min_by_key(|(one, other)| (usize::MAX - common(*one, *other), *one, *other));
        let Some((one, other)) = best else { break };
        take(&mut left_a, &mut left_b, one, other);
    }
    pairs.extend(left_a.into_iter().map(|bus| (Some(bus), None)));
    pairs.extend(left_b.into_iter().map(|bus| (None, Some(bus))));
    pairs
}

/// Returns the anchors that relate the captures in time: items that are unique in both and in step; else those that are
/// unique in both; else those that match in order, which is vague if one has more repetitions than the other.
fn anchors(a: &Digest, b: &Digest, pairs: &[(Option<BusId>, Option<BusId>)]) -> (Vec<Anchor>, Sessions, bool) {
    let mut streams = Vec::new();
    for (one, other) in pairs {
        let lines = one.and_then(|bus| a.lines.get(&bus)).zip(other.and_then(|bus| b.lines.get(&bus)));
        let Some((one, other)) = lines else { continue };
        streams.extend(one.items.iter().filter_map(|(key, items)| Some((items, other.items.get(key)?))));
    }
    let mut shared = Vec::new();
    let telling = streams.iter().map(|(one, other)| items::shared(one, other, &mut shared)).sum::<usize>();
    let (steps, sessions) = alignment::in_step(&shared, telling, a.stamped && b.stamped);
    // Of two sessions a part may be in step by coincidence, and the rest would be lost.
    if sessions == Sessions::One && !steps.is_empty() {
        return (steps, sessions, false);
    }
    let plain: Vec<Anchor> = shared.iter().filter(|one| !one.varied).map(|one| one.anchor).collect();
    if plain.len() > 1 {
        return (plain, sessions, false);
    }
    // Of many varying values some are equal by coincidence.
    let items = streams.iter().map(|(one, other)| one.len().min(other.len())).sum::<usize>();
    if shared.len() > 1 && shared.len() > items / CHANCE {
        return (shared.iter().map(|one| one.anchor).collect(), sessions, false);
    }
    let mut found = Vec::new();
    let mut vague = false;
    if !alignment::simultaneous(a, b) {
        vague = streams.iter().any(|(one, other)| one.len() != other.len());
        for (one, other) in &streams {
            items::matched(one, other, &mut found);
        }
    }
    (found, sessions, vague)
}

/// Compares one bus of both captures.
fn lines(lines: [&BusDigest; 2], digests: [&Digest; 2], settings: &DiffSettings, found: &mut Found<'_>) {
    let [a, b] = lines;
    let apart = strangers(lines, found);
    let alignment = found.alignment;
    let keys: BTreeSet<(u8, ItemKind)> = a.items.keys().chain(b.items.keys()).copied().collect();
    for (node, kind) in keys.into_iter().filter(|(node, _)| !apart.contains(node)) {
        let items = lines.map(|line| line.items.get(&(node, kind)).map_or(&[][..], |items| items));
        let known = lines.map(|line| line.known.get(&(node, kind)).copied());
        Streams { kind, node, items, known, alignment }.compare(settings.tolerance, found);
    }
    let cyclic = named(lines, alignment);
    let keys: BTreeSet<(u8, Service)> = cyclic.iter().flat_map(|cyclic| cyclic.keys().copied()).collect();
    let none = CyclicStream::default();
    for (node, service) in keys.into_iter().filter(|(node, _)| !apart.contains(node)) {
        let cyclic = cyclic.each_ref().map(|cyclic| cyclic.get(&(node, service)).map_or(&none, |stream| &**stream));
        let node = (node > 0).then_some(node);
        let configured = found.configured(node);
        StreamPair { node, service, cyclic, configured, alignment }.compare(settings.tolerance, found);
    }
    findings(lines, digests, &apart, found);
}

/// Returns the nodes that only one capture has although the other one covers them.
fn strangers(lines: [&BusDigest; 2], found: &mut Found<'_>) -> BTreeSet<u8> {
    let by_time = found.alignment.by_time;
    let mut apart = BTreeSet::new();
    for (side, other) in [(0, 1), (1, 0)] {
        let (Some(mine), Some(others)) = (lines.get(side), lines.get(other)) else { continue };
        for (node, (first, frames)) in mine.nodes.iter().filter(|(node, _)| !others.nodes.contains_key(node)) {
            apart.insert(*node);
            // The node of an identifier may have been configured before the other capture began, or may become known
            // later.
            let mut ids = mine.cyclic.iter().filter(|((of, _), _)| of == node);
            let known = |id: &CanId| others.ids.contains_key(id);
            let silent = mine.items.keys().all(|(of, _)| of != node);
            if silent && ids.all(|(_, stream)| stream.versions.iter().all(|version| known(&version.id))) {
                continue;
            }
            let sent =
                mine.cyclic.iter().filter(|((of, _), _)| of == node).flat_map(|(_, stream)| stream.places.iter());
            let done = mine.items.iter().filter(|((of, _), _)| of == node).flat_map(|(_, items)| items.iter());
            let mut places: Vec<CapturePlace> = sent.copied().chain(done.map(|item| item.since)).collect();
            places.push(*first);
            places.sort_by_key(|place| place.on(false));
            let covers = |place: &&CapturePlace| found.alignment.covers(side, place.on(by_time), place.on(by_time));
            let last = found.alignment.covered.get(side).map_or(Ns::MAX, |covered| covered.1);
            let blurred = |place: &&CapturePlace| found.alignment.is_blurred() && place.on(by_time) <= last;
            let covered = places.iter().find(covers).or(places.first().filter(blurred));
            match covered {
                Some(at) => {
                    let mut sides = [None, None];
                    if let Some(slot) = sides.get_mut(side) {
                        *slot = Some(CaptureSide::new(*at, *at, Shows::Count(*frames)));
                    }
                    found.add(DifferenceKind::Node, Some(*node), sides);
                }
                None => found.outside(side, 1),
            }
        }
    }
    apart
}

/// Returns the cyclic streams of both captures by node and service. A stream that only one capture has although the
/// other one has its identifiers is one that they assign to different PDOs, since one of them does not know, or not
/// yet, its configuration. It gets its name from the capture that knows more.
fn named<'a>(lines: [&'a BusDigest; 2], alignment: &Alignment) -> [BTreeMap<(u8, Service), Cow<'a, CyclicStream>>; 2] {
    let [a, b] = lines;
    let b_knows = alignment.beyond.last().is_some_and(|(before, _)| *before);
    [renamed(a, b, b_knows), renamed(b, a, !b_knows)]
}

fn renamed<'a>(mine: &'a BusDigest, other: &BusDigest, yields: bool) -> BTreeMap<(u8, Service), Cow<'a, CyclicStream>> {
    let mut named: BTreeMap<(u8, Service), Cow<'a, CyclicStream>> = BTreeMap::new();
    let mut strange = Vec::new();
    for (key, stream) in &mine.cyclic {
        if other.cyclic.contains_key(key) {
            named.insert(*key, Cow::Borrowed(stream));
        } else {
            strange.push((key, stream));
        }
    }
    for (key, stream) in strange {
        let carries = |(name, other): &(&(u8, Service), &CyclicStream)| {
            let own = |mine: &Version| other.versions.iter().any(|other| other.id == mine.id);
            stream.versions.iter().all(own) && (yields || mine.cyclic.contains_key(name))
        };
        let name = other.cyclic.iter().find(carries).map_or(*key, |(name, _)| *name);
        match named.entry(name) {
            Entry::Vacant(entry) => _ = entry.insert(Cow::Borrowed(stream)),
            Entry::Occupied(mut entry) => entry.get_mut().to_mut().join(stream),
        }
    }
    named
}

/// Reports a bus that only one capture has.
fn absent(lines: [Option<&BusDigest>; 2], found: &mut Found<'_>) {
    let first = |line: &BusDigest| line.nodes.values().map(|(place, _)| *place).min_by_key(|place| place.on(false));
    let mut sides = [None, None];
    for (side, (slot, line)) in sides.iter_mut().zip(lines).enumerate() {
        let Some(line) = line else { continue };
        let at = found
            .alignment
            .first_covered(side, line.places())
            .or(first(line).filter(|_| line.places().next().is_none()));
        *slot = at.map(|at| CaptureSide::new(at, at, Shows::Count(line.frames)));
    }
    match sides {
        [None, None] => found.outside(usize::from(lines.first().is_none_or(Option::is_none)), 1),
        sides => found.add(DifferenceKind::Bus, None, sides),
    }
}

/// Compares findings.
fn findings(lines: [&BusDigest; 2], digests: [&Digest; 2], apart: &BTreeSet<u8>, found: &mut Found<'_>) {
    let by_time = found.alignment.by_time;
    let timed = |digest: &Digest| digest.stamped && digest.decimals >= 4;
    let all_timed = digests.iter().all(|digest| timed(digest));
    for (side, other) in [(0, 1), (1, 0)] {
        let (Some(mine), Some(others)) = (lines.get(side), lines.get(other)) else { continue };
        let lacking: BTreeMap<&Raised, &Vec<Finding>> =
            mine.findings.iter().filter(|(kind, _)| !others.findings.contains_key(kind)).collect();
        for ((code, node, _), raised) in lacking {
            let rule = code.rule();
            if raised.iter().all(|one| one.severity() < Severity::Warning)
                || rule.id.starts_with("CAP")
                || node.is_some_and(|node| apart.contains(&node))
            {
                continue;
            }
            let covered = |finding: &&Finding| {
                let at = CapturePlace::of(finding.at).on(by_time);
                let since = finding.cause.map_or(at, |cause| CapturePlace::of(cause).on(by_time));
                finding.at.no > 0 && found.alignment.covers(side, since.min(at), at)
            };
            let counts = |one: &&Finding| one.severity() >= Severity::Warning && (all_timed || !is_timed(one));
            let Some(first) = raised.iter().filter(counts).find(covered) else { continue };
            // A finding may depend on frames from before the start of one of them.
            if found.alignment.begins_apart() && !rule.id.starts_with("SDO") {
                found.outside(side, 1);
                continue;
            }
            let at = CapturePlace::of(first.at);
            if is_of_cut(mine, *node, at, side, found.alignment) {
                found.outside(side, 1);
                continue;
            }
            let mut sides = [None, None];
            if let Some(slot) = sides.get_mut(side) {
                *slot = Some(CaptureSide::new(at, at, Shows::Finding(Box::new((*first).clone()))));
            }
            found.add(DifferenceKind::Finding, *node, sides);
        }
    }
}

/// Returns true if a finding is about a transfer that the other capture does not show completely.
fn is_of_cut(line: &BusDigest, node: Option<u8>, at: CapturePlace, side: usize, alignment: &Alignment) -> bool {
    let by_time = alignment.by_time;
    let streams = line.items.iter().filter(|((of, kind), _)| Some(*of) == node && matches!(kind, ItemKind::Sdo(_)));
    let mut around = streams
        .flat_map(|(_, items)| items)
        .filter(|item| item.since.on(false) <= at.on(false) && at.on(false) <= item.at.on(false) + Ns(1));
    around.any(|item| !alignment.covers(side, item.since.on(by_time), at.on(by_time)))
}

/// Returns true if a finding depends on times, which captures without timestamps, or with coarse ones, cannot show.
fn is_timed(finding: &Finding) -> bool {
    finding.measured().is_some_and(|all| all.facts().any(|(_, quantity)| matches!(quantity, Quantity::Ns(_))))
}

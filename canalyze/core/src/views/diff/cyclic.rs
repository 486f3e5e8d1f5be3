//! The comparison of periodic frames: their presence, rate, jitter, identifier, mapping and length.
//!
//! In two captures of one session ([`Alignment::rigid`]) frames are counted exactly within the range that both surely
//! cover. Of two sessions only the period is compared, since the start of each is arbitrary. Payload is not compared.

use std::ops::RangeInclusive;

use super::alignment::Alignment;
use super::difference::{CaptureSide, DifferenceKind, Shows};
use super::digest::{CapturePlace, CyclicStream, Service, Version, alike};
use super::found::Found;
use crate::bytes::ns::Ns;
use crate::evidence::period::pace::Pace;

/// Minimum number of intervals to estimate their variation.
const JITTER: usize = 50;
/// Delay of frames by a machine, in ns: a smaller variation does not describe a node.
const DELAYED_NS: Ns = Ns::from_ms(1);

/// One stream in both captures.
pub(super) struct StreamPair<'a> {
    pub(super) node: Option<u8>,
    pub(super) service: Service,
    pub(super) cyclic: [&'a CyclicStream; 2],
    /// The node was configured, or reset, differently: identifiers and mappings may differ.
    pub(super) configured: bool,
    pub(super) alignment: &'a Alignment,
}

impl StreamPair<'_> {
    /// Compares them.
    pub(super) fn compare(&self, tolerance: f64, found: &mut Found<'_>) {
        let [a, b] = self.cyclic;
        let counted = [self.counted(0), self.counted(1)];
        let paces = [self.pace(0), self.pace(1)];
        let presence = self.presence(&counted, &paces);
        if let Some(sides) = presence {
            return found.add(DifferenceKind::Frames(self.service), self.node, sides);
        }
        let [sure_a, sure_b] = counted.map(|(sure, _)| sure);
        if sure_a == 0 || sure_b == 0 {
            return;
        }
        self.versions([a, b], found);
        if self.alignment.by_time
            && let [Some(mine), Some(others)] = &paces
        {
            if parts(mine, others, tolerance, self.alignment) {
                let shown = [mine.median_ns, others.median_ns];
                return self.say(DifferenceKind::Period(self.service), shown, [mine, others], found);
            }
            if varies(mine, others, tolerance, self.alignment) {
                let shown = [mine.spread_ns, others.spread_ns];
                return self.say(DifferenceKind::Jitter(self.service), shown, [mine, others], found);
            }
        }
        self.lost(&counted, &paces, tolerance, found);
    }

    fn places(&self, side: usize) -> &[CapturePlace] {
        self.cyclic.get(side).map_or(&[], |stream| &stream.places)
    }

    /// Counts the frames that the other capture surely covers, and those that it may cover.
    fn counted(&self, side: usize) -> (u64, u64) {
        let by_time = self.alignment.by_time;
        let positions = self.places(side).iter().map(|place| place.on(by_time));
        positions.fold((0, 0), |(sure, most), at| {
            (
                sure + u64::from(self.alignment.covers(side, at, at)),
                most + u64::from(self.alignment.may_cover(side, at)),
            )
        })
    }

    /// Returns the first frame that the other capture covers.
    fn first(&self, side: usize) -> Option<CapturePlace> {
        let by_time = self.alignment.by_time;
        let covered = |place: &&CapturePlace| self.alignment.covers(side, place.on(by_time), place.on(by_time));
        self.places(side).iter().find(covered).copied()
    }

    fn pace(&self, side: usize) -> Option<Pace> {
        let by_time = self.alignment.by_time;
        let inside =
            self.places(side).iter().map(|place| place.on(by_time)).filter(|at| self.alignment.may_cover(side, *at));
        Pace::of(inside)
    }

    /// Compares a stream that is in one capture only.
    fn presence(&self, counted: &[(u64, u64); 2], paces: &[Option<Pace>; 2]) -> Option<[Option<CaptureSide>; 2]> {
        for side in [0, 1] {
            let ((sure, _), (_, other)) = (*counted.get(side)?, *counted.get(1 - side)?);
            if sure == 0 || other > 0 {
                continue;
            }
            // Of two sessions, a slow stream may be between two frames.
            let long = paces.get(side)?.is_some();
            if !self.alignment.rigid && !long && sure < 2 && !self.places(1 - side).is_empty() {
                continue;
            }
            let at = self.first(side)?;
            let mut sides = [None, None];
            if let Some(slot) = sides.get_mut(side) {
                *slot = Some(CaptureSide::new(at, at, Shows::Count(sure)));
            }
            return Some(sides);
        }
        None
    }

    /// Compares the numbers of frames: frames that one of two captures of the same session lacks, or a difference
    /// between two sessions that is too large for a coincidence.
    fn lost(&self, counted: &[(u64, u64); 2], paces: &[Option<Pace>; 2], tolerance: f64, found: &mut Found<'_>) {
        let [(sure_a, most_a), (sure_b, most_b)] = *counted;
        let regular = paces.iter().any(|pace| pace.as_ref().is_some_and(|pace| pace.regular));
        if !self.alignment.rigid && !self.alignment.by_time {
            return;
        }
        if !self.alignment.rigid {
            let (less, more) = (sure_a.min(sure_b), most_a.max(most_b));
            let apart = more.saturating_sub(less) as f64;
            // A regular stream was judged by its period; the duration of each session is not judged.
            if regular || apart <= 2.0 + 2.0 * tolerance * more as f64 {
                return;
            }
        } else if sure_a <= most_b && sure_b <= most_a {
            return;
        }
        let more = if sure_a > most_b || (sure_b <= most_a && sure_a >= sure_b) { 0 } else { 1 };
        let within = paces.get(more).and_then(Option::as_ref).map_or(DELAYED_NS, |pace| pace.median_ns / 2);
        let place = self.unmatched(more, within);
        let Some(at) = place.or_else(|| self.first(more)) else { return };
        let shows = |side: usize, sure: u64| {
            let nearest = if side == more { Some(at) } else { self.nearest(side, at) };
            nearest.map(|place| CaptureSide::new(place, place, Shows::Count(sure)))
        };
        found.add(DifferenceKind::Frames(self.service), self.node, [shows(0, sure_a), shows(1, sure_b)]);
    }

    /// Converts a place of the other capture to the scale of this one.
    fn here(&self, side: usize, place: CapturePlace) -> Ns {
        let position = place.on(self.alignment.by_time);
        if side == 0 { self.alignment.to_a(position) } else { self.alignment.to_b(position) }
    }

    /// Returns the frame of one capture nearest to a frame of the other one, at or behind it if possible.
    fn nearest(&self, side: usize, other: CapturePlace) -> Option<CapturePlace> {
        let (by_time, at) = (self.alignment.by_time, self.here(side, other));
        let places = self.places(side);
        let after = places.partition_point(|place| place.on(by_time) < at);
        places.get(after).or_else(|| places.last()).copied()
    }

    /// Returns the first frame of a capture that the other one lacks, if both show the same session.
    fn unmatched(&self, side: usize, within: Ns) -> Option<CapturePlace> {
        if !self.alignment.rigid {
            return None;
        }
        let by_time = self.alignment.by_time;
        let others = self.places(1 - side);
        let mut next = 0;
        for place in self.places(side) {
            let at = place.on(by_time);
            if !self.alignment.covers(side, at, at) {
                continue;
            }
            let there = |at: usize| others.get(at).map(|other| self.here(side, *other));
            while there(next).is_some_and(|other| other < at - within) {
                next += 1;
            }
            match there(next) {
                Some(other) if other <= at + within => next += 1,
                _ => return Some(*place),
            }
        }
        None
    }

    fn say(&self, what: DifferenceKind, ns: [Ns; 2], paces: [&Pace; 2], found: &mut Found<'_>) {
        // It is at the first interval that the other one lacks.
        let [mine, others] = paces;
        let side = usize::from(others.spread_ns > mine.spread_ns);
        let (own, other) = if side == 0 { (mine, others) } else { (others, mine) };
        let by_time = self.alignment.by_time;
        let usual = (own.median_ns - other.median_ns).abs() / 2;
        let most = usual.max(other.spread_ns.max(own.spread_ns / 2)).max(self.alignment.resolution);
        let places = self.places(side);
        let odd = places.iter().zip(places.iter().skip(1)).find(|(one, next)| {
            let interval = next.on(by_time) - one.on(by_time);
            self.alignment.covers(side, one.on(by_time), next.on(by_time)) && (interval - other.median_ns).abs() > most
        });
        let Some(at) = odd.map(|(_, next)| *next).or_else(|| self.first(side)) else { return };
        let show = |which: usize| {
            let place = if which == side { Some(at) } else { self.nearest(which, at) };
            place.zip(ns.get(which)).map(|(place, ns)| CaptureSide::new(place, place, Shows::Time(*ns)))
        };
        found.add(what, self.node, [show(0), show(1)]);
    }

    /// Compares identifiers, mappings and lengths, one after the other.
    fn versions(&self, cyclic: [&CyclicStream; 2], found: &mut Found<'_>) {
        let by_time = self.alignment.by_time;
        let inside = |side: usize| -> Vec<&Version> {
            let versions = cyclic.get(side).map_or(&[][..], |stream| &stream.versions);
            let meets = |version: &&Version| {
                let covered: RangeInclusive<Ns> = match self.alignment.covered.get(side) {
                    Some((first, last)) => *first..=*last,
                    None => return false,
                };
                version.first.on(by_time) <= *covered.end() && version.last.on(by_time) >= *covered.start()
            };
            versions.iter().filter(meets).collect()
        };
        let sides = [inside(0), inside(1)];
        let mut say = |what, pair: Option<[(&Version, Shows); 2]>| {
            let Some(pair) = pair else { return };
            let sides = pair.map(|(version, shows)| Some(CaptureSide::new(version.first, version.first, shows)));
            found.add(what, self.node, sides);
        };
        let ids = first_apart(&sides, |version| Some(version.id), |one, other| one == other);
        let ids = ids.filter(|_| self.configured);
        say(DifferenceKind::CobId(self.service), ids.map(|pair| pair.map(|version| (version, Shows::Id(version.id)))));
        let mapped = |version: &Version| version.mapping.clone();
        let mappings = first_apart(&sides, mapped, |one, other| alike(one, other));
        let words = |version: &Version| -> Vec<u32> {
            version.mapping.iter().flat_map(|mapping| mapping.entries.iter().map(|entry| entry.word())).collect()
        };
        // A configuration from before a capture is unknown there; later ones are in its SDO transfers.
        let unknown = |versions: &Vec<&Version>| versions.iter().any(|version| version.mapping.is_none());
        let judged = self.configured && !self.alignment.begins_apart() && !sides.iter().any(unknown);
        let mappings = mappings.filter(|_| judged);
        let differ = mappings.is_some();
        say(
            DifferenceKind::Mapping(self.service),
            mappings.map(|pair| pair.map(|version| (version, Shows::Mapping(words(version))))),
        );
        if !differ {
            let lengths = first_apart(&sides, |version| Some(version.len), |one, other| one == other);
            say(
                DifferenceKind::Length(self.service),
                lengths.map(|pair| pair.map(|version| (version, Shows::Length(version.len)))),
            );
        }
    }
}

/// Returns the first versions in which two captures differ, each change counted once; unknown ones are skipped. A
/// change that only one capture has is compared with the value that the other one keeps.
fn first_apart<'a, K>(
    sides: &[Vec<&'a Version>; 2],
    key: impl Fn(&Version) -> Option<K>,
    same: impl Fn(&K, &K) -> bool,
) -> Option<[&'a Version; 2]> {
    let runs = |versions: &[&'a Version]| {
        let mut runs: Vec<(K, &'a Version)> = Vec::new();
        for version in versions {
            if let Some(key) = key(version)
                && runs.last().is_none_or(|(last, _)| !same(last, &key))
            {
                runs.push((key, version));
            }
        }
        runs
    };
    let [a, b] = sides;
    let (a, b) = (runs(a), runs(b));
    if a.is_empty() || b.is_empty() {
        return None;
    }
    for place in 0..a.len().max(b.len()) {
        let (one, other) = (a.get(place).or(a.last())?, b.get(place).or(b.last())?);
        if !same(&one.0, &other.0) {
            return Some([one.1, other.1]);
        }
        if a.get(place).is_none() != b.get(place).is_none() {
            return Some([one.1, other.1]);
        }
    }
    None
}

/// Returns true if two periods differ.
fn parts(one: &Pace, other: &Pace, tolerance: f64, alignment: &Alignment) -> bool {
    let allowed = Ns((tolerance * one.median_ns.min(other.median_ns).as_ns() as f64) as i64);
    let apart = (one.median_ns - other.median_ns).abs();
    one.regular && other.regular && apart > allowed.max(2 * alignment.resolution)
}

/// Returns true if one varies much more than the other.
fn varies(one: &Pace, other: &Pace, tolerance: f64, alignment: &Alignment) -> bool {
    let allowed = Ns((tolerance * one.median_ns.min(other.median_ns).as_ns() as f64) as i64);
    let apart = (one.spread_ns - other.spread_ns).abs();
    let enough = one.gaps.min(other.gaps) >= JITTER;
    enough
        && (one.regular || other.regular)
        && apart > (2 * allowed).max(4 * alignment.resolution).max(DELAYED_NS)
        && one.spread_ns.max(other.spread_ns) / 3 > one.spread_ns.min(other.spread_ns)
}

/// Returns the periods of two polls in ns, if they differ.
pub(super) fn paces(a: &[CapturePlace], b: &[CapturePlace], alignment: &Alignment, tolerance: f64) -> Option<(Ns, Ns)> {
    let pace = |side: usize, places: &[CapturePlace]| {
        Pace::of(places.iter().map(|place| place.on(true)).filter(|at| alignment.may_cover(side, *at)))
    };
    let (mine, other) = (pace(0, a)?, pace(1, b)?);
    let enough = mine.gaps.min(other.gaps) >= 8;
    (enough && parts(&mine, &other, tolerance, alignment)).then_some((mine.median_ns, other.median_ns))
}

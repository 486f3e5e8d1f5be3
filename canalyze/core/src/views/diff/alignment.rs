//! The time that both captures cover, and the mapping of times of one to the other.
//!
//! The clocks of two captures are unrelated, so they are mapped by anchors: items that each capture has exactly once,
//! in the same order in both. Between anchors the offset of the clocks is interpolated; without timestamps, frames are
//! counted instead. Differences are not judged here.

use super::digest::{CapturePlace, Digest};

/// Timestamps from here on (in ns: 1973) are those of a clock.
const EPOCH_NS: i64 = 100_000_000_000_000_000;
/// Maximum drift between two anchors of clocks that run alike ...
const RIGID_NS: i64 = 2_000_000;
/// ... plus a thousandth of the time between them.
const DRIFT: i64 = 1000;
/// Over the whole common time, clocks drift by no more than one part in this many.
const QUARTZ: i64 = 5000;
/// Uncertainty of the mapping of clocks without two anchors, in ns.
const UNSURE_NS: i64 = 1_000_000;
/// The counterpart of [`RIGID_NS`] in frames.
const RIGID_FRAMES: i64 = 3;
/// Number of anchors at an edge from which the uncertainty there is estimated.
const EDGE: usize = 5;

/// Number of ends of items in step from which on they are not a coincidence.
const STEPS: usize = 6;
/// Anchors are ignored if no more than one in this many is in the same order in both captures.
const CONTRADICTED: usize = 4;
/// Number of equal varying values in step from which on both captures show one session.
const SAME: usize = 6;
/// Maximum displacement at an edge of a late echo of a frame that the capturing host sends: in ns, in frames.
const LATE_NS: i64 = 2_000_000;
const LATE_FRAMES: i64 = 2;

/// The number of sessions that two captures show, by the values that vary from session to session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sessions {
    /// One session.
    One,
    /// Two sessions.
    Two,
    /// Unknown.
    Unknown,
}

/// A moment that both captures have: its place in A and in B.
pub type Anchor = (CapturePlace, CapturePlace);

/// An end of an item that each capture has exactly once.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shared {
    pub(super) anchor: Anchor,
    /// Its value varies: equal values in both captures may be a coincidence, many in step are not.
    pub(super) varied: bool,
}

/// The relation of places in both captures.
#[derive(Clone, Debug)]
pub struct Alignment {
    /// Positions are timestamps in ns, else numbers of frames.
    pub by_time: bool,
    /// Both captures show the same session: the offset of their clocks does not vary.
    pub rigid: bool,
    /// The range that both cover, in positions of each: first and last.
    pub covered: [(i64, i64); 2],
    /// The uncertainty of that, at the beginning and at the end.
    pub slack: (i64, i64),
    /// For each capture: true if it begins before the other one, and true if it ends after it.
    pub beyond: [(bool, bool); 2],
    /// The resolution of timestamps.
    pub resolution: i64,
    /// The number of each capture's first frame.
    pub first: [i64; 2],
    /// The number of the last frame of each.
    pub last: [i64; 2],
    /// Positions in A and in B, ascending.
    chain: Vec<(i64, i64)>,
    /// Frames of the same, for a place that the other capture does not have.
    frames: Vec<(CapturePlace, CapturePlace)>,
}

impl Alignment {
    /// Relates two captures by these anchors, in any order.
    pub fn new(a: &Digest, b: &Digest, anchors: Vec<Anchor>, sessions: Sessions) -> Self {
        let by_time = a.stamped && b.stamped;
        let anchors = ordered(anchors);
        let mut chain: Vec<(i64, i64)> =
            anchors.iter().map(|(in_a, in_b)| (in_a.on(by_time), in_b.on(by_time))).collect();
        // Timestamps may step back although frames do not.
        let mut high = (i64::MIN, i64::MIN);
        chain.retain(|&(in_a, in_b)| {
            let rises = in_a >= high.0 && in_b >= high.1;
            if rises {
                high = (in_a, in_b);
            }
            rises
        });
        let ends = |digest: &Digest| (digest.first.on(by_time), digest.last.on(by_time));
        let (of_a, of_b) = (ends(a), ends(b));
        if chain.is_empty() {
            chain.push(unanchored(by_time, of_a, of_b));
        }
        let mut alignment = Self {
            by_time,
            rigid: false,
            covered: [of_a, of_b],
            slack: (0, 0),
            beyond: [(false, false); 2],
            resolution: if by_time { 10_i64.pow(9 - u32::from(a.decimals.min(b.decimals).min(9))) } else { 1 },
            first: [a.first.on(false), b.first.on(false)],
            last: [a.last.on(false), b.last.on(false)],
            chain,
            frames: anchors,
        };
        let differ = if a.decimals == b.decimals || !by_time { 0 } else { alignment.resolution };
        let parts = alignment.parts();
        alignment.rigid = sessions != Sessions::Two && alignment.is_even(&parts, differ);
        let together = alignment.frames.is_empty() && simultaneous(a, b);
        let slack =
            |parts: &mut dyn Iterator<Item = &(i64, i64)>| slack(parts, by_time, together).saturating_add(differ);
        alignment.slack = (slack(&mut parts.iter().take(EDGE)), slack(&mut parts.iter().rev().take(EDGE)));
        alignment.cover(of_a, of_b);
        alignment
    }

    /// Computes the range that both cover, and its uncertainty. `of_a`, `of_b`: the first and the last position of
    /// each.
    fn cover(&mut self, of_a: (i64, i64), of_b: (i64, i64)) {
        let (first, last) = (self.to_a(of_b.0), self.to_a(of_b.1));
        self.covered[0] = (of_a.0.max(first), of_a.1.min(last));
        self.covered[1] = (of_b.0.max(self.to_b(of_a.0)), of_b.1.min(self.to_b(of_a.1)));
        let (begins, ends) = self.slack;
        self.beyond = [
            (of_a.0.saturating_add(begins) < first, of_a.1 > last.saturating_add(ends)),
            (of_a.0 > first.saturating_add(begins), of_a.1.saturating_add(ends) < last),
        ];
        // If both begin, or end, with the same frames, a late echo is on the same side in both.
        let late = if self.by_time { LATE_NS } else { LATE_FRAMES };
        if self.begins_apart() {
            self.slack.0 = self.slack.0.max(late);
        }
        if self.beyond.iter().any(|(_, after)| *after) {
            self.slack.1 = self.slack.1.max(late);
        }
    }

    /// Returns true if the offset of the clocks hardly varies. `parts`: see [`Self::parts`]; `differ`: the difference
    /// of timestamps of different resolution.
    fn is_even(&self, parts: &[(i64, i64)], differ: i64) -> bool {
        // One step that a fault has moved makes two uneven parts; two runs of one script differ everywhere.
        let odd = if parts.len() >= STEPS { (parts.len() / 8).max(2) } else { 0 };
        let uneven = parts.iter().filter(|(parted, apart)| {
            let most = if self.by_time { RIGID_NS.saturating_add(apart / DRIFT) } else { RIGID_FRAMES };
            *parted > most.saturating_add(2 * differ)
        });
        // Over the whole time, clocks differ by no more than the error of their quartzes.
        let mut offsets: Vec<i64> = self.chain.iter().map(|(in_a, in_b)| in_b.saturating_sub(*in_a)).collect();
        offsets.sort_unstable();
        let inner = offsets.get(odd..offsets.len().saturating_sub(odd)).unwrap_or(&offsets);
        let spread = inner.last().zip(inner.first()).map_or(0, |(most, least)| most.saturating_sub(*least));
        let long = parts.iter().fold(0_i64, |sum, (_, apart)| sum.saturating_add(*apart));
        let allowed = RIGID_NS.saturating_add(long / QUARTZ).saturating_add(2 * differ);
        uneven.count() <= odd && (!self.by_time || spread <= allowed)
    }

    /// Returns the change of the offset from each anchor to the next, and the distance between them.
    fn parts(&self) -> Vec<(i64, i64)> {
        let offset = |(in_a, in_b): (i64, i64)| in_b.saturating_sub(in_a);
        let pairs = self.chain.iter().zip(self.chain.iter().skip(1));
        pairs
            .map(|(one, next)| {
                let parted = offset(*next).saturating_sub(offset(*one)).saturating_abs();
                (parted, next.0.saturating_sub(one.0).saturating_abs())
            })
            .collect()
    }

    /// Returns true if one capture contains time before the other one began.
    pub fn begins_apart(&self) -> bool {
        self.beyond.iter().any(|(before, _)| *before)
    }

    /// Marks the relation as unknown: nothing is surely covered.
    pub fn blur(&mut self) {
        self.slack = (i64::MAX / 4, i64::MAX / 4);
    }

    /// Returns true if the relation of the captures is unknown.
    pub fn is_blurred(&self) -> bool {
        self.slack.0 == i64::MAX / 4
    }

    /// Converts a position of B to the scale of A.
    pub fn to_a(&self, position: i64) -> i64 {
        related(&self.chain, position, |(in_a, in_b)| (in_b, in_a))
    }

    /// Converts a position of A to the scale of B.
    pub fn to_b(&self, position: i64) -> i64 {
        related(&self.chain, position, |pair| pair)
    }

    /// Returns the frame of the other capture at or before a place of this one, by the nearest anchor.
    pub fn beside(&self, side: usize, place: CapturePlace) -> Option<CapturePlace> {
        let mine = |pair: &Anchor| if side == 0 { pair.0 } else { pair.1 };
        let after = self.frames.partition_point(|pair| mine(pair).on(false) <= place.on(false));
        let nearest = after.checked_sub(1).and_then(|at| self.frames.get(at)).or_else(|| self.frames.first())?;
        Some(if side == 0 { nearest.1 } else { nearest.0 })
    }

    /// Returns true if the other capture surely covers a time of this one.
    pub fn covers(&self, side: usize, from: i64, to: i64) -> bool {
        let Some((first, last)) = self.covered.get(side) else { return false };
        let (begins, ends) = self.slack;
        from >= first.saturating_add(begins) && to <= last.saturating_sub(ends)
    }

    /// Returns the first of these places that both captures surely cover.
    pub fn first_covered(&self, side: usize, places: impl Iterator<Item = CapturePlace>) -> Option<CapturePlace> {
        let inside = |place: &CapturePlace| self.covers(side, place.on(self.by_time), place.on(self.by_time));
        places.filter(inside).min_by_key(|place| place.on(false))
    }

    /// Returns true if the other capture may cover a position of this one.
    pub fn may_cover(&self, side: usize, position: i64) -> bool {
        let Some((first, last)) = self.covered.get(side) else { return false };
        let (begins, ends) = self.slack;
        position >= first.saturating_sub(begins) && position <= last.saturating_add(ends)
    }
}

/// Returns the uncertainty of clocks that vary by these parts. `together`: they are one clock.
fn slack(parts: &mut dyn Iterator<Item = &(i64, i64)>, by_time: bool, together: bool) -> i64 {
    let unsure = if by_time { UNSURE_NS } else { 1 };
    match parts.map(|(parted, _)| *parted).max() {
        None if together => 0,
        None => unsure,
        Some(0) => 0,
        // A few anchors do not show the worst case.
        Some(worst) => worst.saturating_add(unsure / 5),
    }
}

/// Returns true if the clocks of two captures show that they were taken at the same time.
pub fn simultaneous(a: &Digest, b: &Digest) -> bool {
    let ends = |digest: &Digest| (digest.first.on(true), digest.last.on(true));
    a.stamped && b.stamped && overlap(ends(a), ends(b))
}

fn overlap(a: (i64, i64), b: (i64, i64)) -> bool {
    a.0 >= EPOCH_NS && b.0 >= EPOCH_NS && a.0 <= b.1 && b.0 <= a.1
}

/// Relates captures without anchors: those that were taken at the same time have one clock, others begin together.
fn unanchored(by_time: bool, a: (i64, i64), b: (i64, i64)) -> (i64, i64) {
    if by_time && overlap(a, b) { (a.0, a.0) } else { (a.0, b.0) }
}

/// Converts a position to the other scale. `turn` returns an anchor's position on this one and on the other.
fn related(chain: &[(i64, i64)], position: i64, turn: impl Fn((i64, i64)) -> (i64, i64)) -> i64 {
    let after = chain.partition_point(|pair| turn(*pair).0 <= position);
    let before = after.checked_sub(1).and_then(|at| chain.get(at)).map(|pair| turn(*pair));
    let next = chain.get(after).map(|pair| turn(*pair));
    match (before, next) {
        (Some((here, there)), Some((here_next, there_next))) if here_next > here => {
            let part = i128::from(position.saturating_sub(here)) * i128::from(there_next.saturating_sub(there));
            let part = part / i128::from(here_next.saturating_sub(here)).max(1);
            there.saturating_add(i64::try_from(part).unwrap_or(0))
        }
        (Some((here, there)), _) | (None, Some((here, there))) => there.saturating_add(position.saturating_sub(here)),
        (None, None) => position,
    }
}

/// Returns the anchors whose offset hardly varies, if these are most of those that are unique in both: the others match
/// by coincidence, or are different repetitions, one in each capture. `telling`: values that could be equal.
pub(super) fn in_step(shared: &[Shared], telling: usize, by_time: bool) -> (Vec<Anchor>, Sessions) {
    let offset = |one: &Shared| one.anchor.1.on(by_time).saturating_sub(one.anchor.0.on(by_time));
    let width = if by_time { RIGID_NS } else { RIGID_FRAMES };
    let mut offsets: Vec<i64> = shared.iter().map(offset).collect();
    offsets.sort_unstable();
    // The offset that most of them share, and their number.
    let mut best = (0, 0);
    let mut from = 0;
    for (to, last) in offsets.iter().enumerate() {
        while offsets.get(from).is_some_and(|first| last.saturating_sub(*first) > width) {
            from += 1;
        }
        let about = offsets.get((from + to) / 2).copied().unwrap_or(*last);
        best = best.max((to + 1 - from, about));
    }
    let mut ordered: Vec<&Shared> = shared.iter().collect();
    ordered.sort_by_key(|one| one.anchor.0.on(by_time));
    let first = ordered.iter().position(|one| offset(one).saturating_sub(best.1).saturating_abs() <= width);
    // Clocks drift slowly: from there on, to both sides, each may differ a little from the last one.
    let (before, after) = ordered.split_at(first.unwrap_or(0));
    let mut steps: Vec<&Shared> = Vec::new();
    for way in [&mut after.iter() as &mut dyn Iterator<Item = &&Shared>, &mut before.iter().rev()] {
        let mut last: Option<(i64, i64)> =
            first.and_then(|at| ordered.get(at)).map(|one| (one.anchor.0.on(by_time), best.1));
        for one in way {
            let (at, own) = (one.anchor.0.on(by_time), offset(one));
            let Some((then, expected)) = last else { break };
            let drift = if by_time { at.saturating_sub(then).saturating_abs() / DRIFT } else { 0 };
            if own.saturating_sub(expected).saturating_abs() <= width.saturating_add(drift) {
                steps.push(one);
                // An item that is a little late itself must not mislead the next ones.
                let known = i64::try_from(steps.len().min(8)).unwrap_or(1);
                last = Some((at, expected.saturating_add(own.saturating_sub(expected) / known)));
            }
        }
    }
    let varied = steps.iter().filter(|one| one.varied).count();
    let sessions = if varied >= SAME {
        Sessions::One
    } else if telling >= SAME && varied * 4 < telling {
        Sessions::Two
    } else {
        Sessions::Unknown
    };
    let anchors: Vec<Anchor> = steps.into_iter().map(|one| one.anchor).collect();
    if anchors.len() >= STEPS && 2 * anchors.len() >= shared.len() {
        (anchors, sessions)
    } else {
        (Vec::new(), sessions)
    }
}

/// Returns the longest part of the anchors that is in the same order in both captures.
fn ordered(mut anchors: Vec<Anchor>) -> Vec<Anchor> {
    anchors.sort_by_key(|(in_a, in_b)| (in_a.on(false), in_b.on(false)));
    // The last anchor of the best row of each length, and for each anchor the one before it.
    let mut ends: Vec<usize> = Vec::new();
    let mut before: Vec<Option<usize>> = Vec::with_capacity(anchors.len());
    let number = |at: usize| anchors.get(at).map_or(0, |pair| pair.1.on(false));
    for at in 0..anchors.len() {
        let length = ends.partition_point(|end| number(*end) < number(at));
        before.push(length.checked_sub(1).and_then(|length| ends.get(length)).copied());
        match ends.get_mut(length) {
            Some(end) => *end = at,
            None => ends.push(at),
        }
    }
    let mut row = Vec::with_capacity(ends.len());
    let mut next = ends.last().copied();
    while let Some(at) = next {
        row.extend(anchors.get(at).copied());
        next = before.get(at).copied().flatten();
    }
    // If hardly any are in the same order, the order itself differs and does not show a relation.
    if row.len() * CONTRADICTED < anchors.len() {
        return Vec::new();
    }
    row.reverse();
    row
}

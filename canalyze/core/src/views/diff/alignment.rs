//! The time that both captures cover, and the mapping of times of one to the other.
//!
//! The clocks of two captures are unrelated, so they are mapped by anchors: items that each capture has exactly once,
//! in the same order in both. Between anchors the offset of the clocks is interpolated; without timestamps, frames are
//! counted instead. Differences are not judged here.

use crate::bytes::ns::Ns;

use super::digest::{CapturePlace, Digest};

/// Timestamps from here on (in ns: 1973) are those of a clock.
const EPOCH_NS: Ns = Ns::from_s(100000000);
/// Maximum drift between two anchors of clocks that run alike ...
const RIGID_NS: Ns = Ns::from_ms(2);
/// ... plus a thousandth of the time between them.
const DRIFT: i64 = 1000;
/// Over the whole common time, clocks drift by no more than one part in this many.
const QUARTZ: i64 = 5000;
/// Uncertainty of the mapping of clocks without two anchors, in ns.
const UNSURE_NS: Ns = Ns::from_ms(1);
/// The counterpart of [`RIGID_NS`] in frames.
const RIGID_FRAMES: Ns = Ns(3);
/// Number of anchors at an edge from which the uncertainty there is estimated.
const EDGE: usize = 5;

/// Number of ends of items in step from which on they are not a coincidence.
const STEPS: usize = 6;
/// Anchors are ignored if no more than one in this many is in the same order in both captures.
const CONTRADICTED: usize = 4;
/// Number of equal varying values in step from which on both captures show one session.
const SAME: usize = 6;
/// Maximum displacement at an edge of a late echo of a frame that the capturing host sends: in ns, in frames.
const LATE_NS: Ns = Ns::from_ms(2);
const LATE_FRAMES: Ns = Ns(2);

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
    pub covered: [(Ns, Ns); 2],
    /// The uncertainty of that, at the beginning and at the end.
    pub slack: (Ns, Ns),
    /// For each capture: true if it begins before the other one, and true if it ends after it.
    pub beyond: [(bool, bool); 2],
    /// The resolution of timestamps.
    pub resolution: Ns,
    /// The number of each capture's first frame.
    pub first: [Ns; 2],
    /// The number of the last frame of each.
    pub last: [Ns; 2],
    /// Positions in A and in B, ascending.
    chain: Vec<(Ns, Ns)>,
    /// Frames of the same, for a place that the other capture does not have.
    frames: Vec<(CapturePlace, CapturePlace)>,
}

impl Alignment {
    /// Relates two captures by these anchors, in any order.
    pub fn new(a: &Digest, b: &Digest, anchors: Vec<Anchor>, sessions: Sessions) -> Self {
        let by_time = a.stamped && b.stamped;
        let anchors = ordered(anchors);
        let mut chain: Vec<(Ns, Ns)> =
            anchors.iter().map(|(in_a, in_b)| (in_a.on(by_time), in_b.on(by_time))).collect();
        // Timestamps may step back although frames do not.
        let mut high = (Ns::MIN, Ns::MIN);
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
            slack: (Ns::ZERO, Ns::ZERO),
            beyond: [(false, false); 2],
            resolution: Ns(if by_time { 10_i64.pow(9 - u32::from(a.decimals.min(b.decimals).min(9))) } else { 1 }),
            first: [a.first.on(false), b.first.on(false)],
            last: [a.last.on(false), b.last.on(false)],
            chain,
            frames: anchors,
        };
        let differ = if a.decimals == b.decimals || !by_time { Ns::ZERO } else { alignment.resolution };
        let parts = alignment.parts();
        alignment.rigid = sessions != Sessions::Two && alignment.is_even(&parts, differ);
        let together = alignment.frames.is_empty() && simultaneous(a, b);
        let slack = |parts: &mut dyn Iterator<Item = &(Ns, Ns)>| slack(parts, by_time, together) + differ;
        alignment.slack = (slack(&mut parts.iter().take(EDGE)), slack(&mut parts.iter().rev().take(EDGE)));
        alignment.cover(of_a, of_b);
        alignment
    }

    /// Computes the range that both cover, and its uncertainty. `of_a`, `of_b`: the first and the last position of
    /// each.
    fn cover(&mut self, of_a: (Ns, Ns), of_b: (Ns, Ns)) {
        let (first, last) = (self.to_a(of_b.0), self.to_a(of_b.1));
        self.covered[0] = (of_a.0.max(first), of_a.1.min(last));
        self.covered[1] = (of_b.0.max(self.to_b(of_a.0)), of_b.1.min(self.to_b(of_a.1)));
        let (begins, ends) = self.slack;
        self.beyond =
            [(of_a.0 + begins < first, of_a.1 > last + ends), (of_a.0 > first + begins, of_a.1 + ends < last)];
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
    fn is_even(&self, parts: &[(Ns, Ns)], differ: Ns) -> bool {
        // One step that a fault has moved makes two uneven parts; two runs of one script differ everywhere.
        let odd = if parts.len() >= STEPS { (parts.len() / 8).max(2) } else { 0 };
        let uneven = parts.iter().filter(|(parted, apart)| {
            let most = if self.by_time { RIGID_NS + *apart / DRIFT } else { RIGID_FRAMES };
            *parted > most + 2 * differ
        });
        // Over the whole time, clocks differ by no more than the error of their quartzes.
        let mut offsets: Vec<Ns> = self.chain.iter().map(|(in_a, in_b)| *in_b - *in_a).collect();
        offsets.sort_unstable();
        let inner = offsets.get(odd..offsets.len().saturating_sub(odd)).unwrap_or(&offsets);
        let spread = inner.last().zip(inner.first()).map_or(Ns::ZERO, |(most, least)| *most - *least);
        let long = parts.iter().fold(Ns::ZERO, |sum, (_, apart)| sum + *apart);
        let allowed = RIGID_NS + long / QUARTZ + 2 * differ;
        uneven.count() <= odd && (!self.by_time || spread <= allowed)
    }

    /// Returns the change of the offset from each anchor to the next, and the distance between them.
    fn parts(&self) -> Vec<(Ns, Ns)> {
        let offset = |(in_a, in_b): (Ns, Ns)| in_b - in_a;
        let pairs = self.chain.iter().zip(self.chain.iter().skip(1));
        pairs
            .map(|(one, next)| {
                let parted = (offset(*next) - offset(*one)).abs();
                (parted, (next.0 - one.0).abs())
            })
            .collect()
    }

    /// Returns true if one capture contains time before the other one began.
    pub fn begins_apart(&self) -> bool {
        self.beyond.iter().any(|(before, _)| *before)
    }

    /// Marks the relation as unknown: nothing is surely covered.
    pub fn blur(&mut self) {
        self.slack = (Ns::MAX / 4, Ns::MAX / 4);
    }

    /// Returns true if the relation of the captures is unknown.
    pub fn is_blurred(&self) -> bool {
        self.slack.0 == Ns::MAX / 4
    }

    /// Converts a position of B to the scale of A.
    pub fn to_a(&self, position: Ns) -> Ns {
        related(&self.chain, position, |(in_a, in_b)| (in_b, in_a))
    }

    /// Converts a position of A to the scale of B.
    pub fn to_b(&self, position: Ns) -> Ns {
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
    pub fn covers(&self, side: usize, from: Ns, to: Ns) -> bool {
        let Some((first, last)) = self.covered.get(side) else { return false };
        let (begins, ends) = self.slack;
        from >= *first + begins && to <= *last - ends
    }

    /// Returns the first of these places that both captures surely cover.
    pub fn first_covered(&self, side: usize, places: impl Iterator<Item = CapturePlace>) -> Option<CapturePlace> {
        let inside = |place: &CapturePlace| self.covers(side, place.on(self.by_time), place.on(self.by_time));
        places.filter(inside).min_by_key(|place| place.on(false))
    }

    /// Returns true if the other capture may cover a position of this one.
    pub fn may_cover(&self, side: usize, position: Ns) -> bool {
        let Some((first, last)) = self.covered.get(side) else { return false };
        let (begins, ends) = self.slack;
        position >= *first - begins && position <= *last + ends
    }
}

/// Returns the uncertainty of clocks that vary by these parts. `together`: they are one clock.
fn slack(parts: &mut dyn Iterator<Item = &(Ns, Ns)>, by_time: bool, together: bool) -> Ns {
    let unsure = if by_time { UNSURE_NS } else { Ns(1) };
    match parts.map(|(parted, _)| *parted).max() {
        None if together => Ns::ZERO,
        None => unsure,
        Some(Ns::ZERO) => Ns::ZERO,
        // A few anchors do not show the worst case.
        Some(worst) => worst + unsure / 5,
    }
}

/// Returns true if the clocks of two captures show that they were taken at the same time.
pub fn simultaneous(a: &Digest, b: &Digest) -> bool {
    let ends = |digest: &Digest| (digest.first.on(true), digest.last.on(true));
    a.stamped && b.stamped && overlap(ends(a), ends(b))
}

fn overlap(a: (Ns, Ns), b: (Ns, Ns)) -> bool {
    a.0 >= EPOCH_NS && b.0 >= EPOCH_NS && a.0 <= b.1 && b.0 <= a.1
}

/// Relates captures without anchors: those that were taken at the same time have one clock, others begin together.
fn unanchored(by_time: bool, a: (Ns, Ns), b: (Ns, Ns)) -> (Ns, Ns) {
    if by_time && overlap(a, b) { (a.0, a.0) } else { (a.0, b.0) }
}

/// Converts a position to the other scale. `turn` returns an anchor's position on this one and on the other.
fn related(chain: &[(Ns, Ns)], position: Ns, turn: impl Fn((Ns, Ns)) -> (Ns, Ns)) -> Ns {
    let after = chain.partition_point(|pair| turn(*pair).0 <= position);
    let before = after.checked_sub(1).and_then(|at| chain.get(at)).map(|pair| turn(*pair));
    let next = chain.get(after).map(|pair| turn(*pair));
    match (before, next) {
        (Some((here, there)), Some((here_next, there_next))) if here_next > here => {
            let part = i128::from((position - here).as_ns()) * i128::from((there_next - there).as_ns());
            let part = part / i128::from((here_next - here).as_ns()).max(1);
            there + Ns(i64::try_from(part).unwrap_or(0))
        }
        (Some((here, there)), _) | (None, Some((here, there))) => there + (position - here),
        (None, None) => position,
    }
}

/// Returns the anchors whose offset hardly varies, if these are most of those that are unique in both: the others match
/// by coincidence, or are different repetitions, one in each capture. `telling`: values that could be equal.
pub(super) fn in_step(shared: &[Shared], telling: usize, by_time: bool) -> (Vec<Anchor>, Sessions) {
    let offset = |one: &Shared| one.anchor.1.on(by_time) - one.anchor.0.on(by_time);
    let width = if by_time { RIGID_NS } else { RIGID_FRAMES };
    let mut offsets: Vec<Ns> = shared.iter().map(offset).collect();
    offsets.sort_unstable();
    // The offset that most of them share, and their number.
    let mut best = (0, Ns::ZERO);
    let mut from = 0;
    for (to, last) in offsets.iter().enumerate() {
        while offsets.get(from).is_some_and(|first| *last - *first > width) {
            from += 1;
        }
        let about = offsets.get((from + to) / 2).copied().unwrap_or(*last);
        best = best.max((to + 1 - from, about));
    }
    let mut ordered: Vec<&Shared> = shared.iter().collect();
    ordered.sort_by_key(|one| one.anchor.0.on(by_time));
    let first = ordered.iter().position(|one| (offset(one) - best.1).abs() <= width);
    // Clocks drift slowly: from there on, to both sides, each may differ a little from the last one.
    let (before, after) = ordered.split_at(first.unwrap_or(0));
    let mut steps: Vec<&Shared> = Vec::new();
    for way in [&mut after.iter() as &mut dyn Iterator<Item = &&Shared>, &mut before.iter().rev()] {
        let mut last: Option<(Ns, Ns)> =
            first.and_then(|at| ordered.get(at)).map(|one| (one.anchor.0.on(by_time), best.1));
        for one in way {
            let (at, own) = (one.anchor.0.on(by_time), offset(one));
            let Some((then, expected)) = last else { break };
            let drift = if by_time { (at - then).abs() / DRIFT } else { Ns::ZERO };
            if (own - expected).abs() <= width + drift {
                steps.push(one);
                // An item that is a little late itself must not mislead the next ones.
                let known = i64::try_from(steps.len().min(8)).unwrap_or(1);
                last = Some((at, expected + (own - expected) / known));
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
    let number = |at: usize| anchors.get(at).map_or(Ns::ZERO, |pair| pair.1.on(false));
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

//! The comparison of actions in order: transfers, commands, states, emergencies.
//!
//! Two items are equal if everything that a CANopen engineer would compare is equal: object, direction, mode, outcome
//! and value of a transfer, the code of a command. Two kinds of repetition are exceptions:
//!
//! * The value of an object that is read with different values within one capture is process data: such uploads are
//!   compared by outcome only, and by size if that does not vary either. The same applies to downloads to 2000h and
//!   above that occur [`CYCLIC`] times or more with different values.
//! * The number of repetitions of a poll: an object read [`POLLED`] times or more, or [`WAITED`] times or more with
//!   varying values (a loop that waits for something), and any other item that occurs [`POLLED`] times. One more or
//!   less is not a difference; another rate is.
//!
//! The order of buses is not known here, and nothing is put into words.

use std::collections::BTreeMap;

use super::align::align;
use super::alignment::{Alignment, Anchor, Shared};
use super::cyclic;
use super::difference::{Aspect, CaptureSide, DifferenceKind, Shows};
use super::digest::{Action, CapturePlace, Item, ItemKind, TransferDigest};
use super::found::Found;
use super::likeness::{likeness, symbol};
use crate::bytes::ns::Ns;
use crate::sdo::transfer::{Direction, Status};
use crate::sdo::wire::Mux;

/// Number of uploads of one object, or of the same item, from which on it is a poll.
const POLLED: usize = 16;
/// The same for an object whose value varies.
const WAITED: usize = 3;
/// Number of downloads of one object from which on it is a cyclic set value.
const CYCLIC: usize = 64;
/// The first index of the application's own objects.
const APPLICATION: u16 = 0x2000;
/// Items no further apart than this may be the same, in ns.
const CLOSE_NS: Ns = Ns::from_ms(2);
/// Number of frames at the beginning of a capture in which a late echo may hide the start of a transfer.
const EDGE: Ns = Ns(3);

/// The varying and the repeated items of a stream, in both captures.
#[derive(Debug, Default)]
pub(super) struct Habits {
    /// By access: true if its value varies, true if its size does, and its number in each.
    accesses: BTreeMap<(bool, Option<Mux>), Habit>,
    /// The number of each other item in each.
    others: BTreeMap<u64, [usize; 2]>,
}

#[derive(Debug, Default)]
struct Habit {
    varies: bool,
    resizes: bool,
    counts: [usize; 2],
    seen: [Option<(u64, u64)>; 2],
}

/// The key of accesses to the same object in the same direction.
fn access(moved: &TransferDigest) -> (bool, Option<Mux>) {
    (moved.direction == Direction::Upload, moved.mux)
}

impl Habits {
    /// Determines the habits of both captures.
    pub(super) fn of<'a>(sides: [impl Iterator<Item = &'a Item>; 2]) -> Self {
        let mut habits = Self::default();
        for (side, items) in sides.into_iter().enumerate() {
            for item in items {
                habits.take(side, item);
            }
        }
        habits
    }

    fn take(&mut self, side: usize, item: &Item) {
        let Action::Transfer(moved) = &item.action else {
            if let Some(count) = self.others.entry(symbol(&item.action, false, false)).or_default().get_mut(side) {
                *count += 1;
            }
            return;
        };
        let known = self.accesses.entry(access(moved)).or_default();
        if let Some(count) = known.counts.get_mut(side) {
            *count += 1;
        }
        if moved.status == Status::Ok
            && !moved.holed
            && let Some(seen) = known.seen.get_mut(side)
        {
            let (size, hash) = *seen.get_or_insert((moved.size, moved.hash));
            known.varies |= hash != moved.hash;
            known.resizes |= size != moved.size;
        }
    }

    fn of_access(&self, moved: &TransferDigest) -> Option<&Habit> {
        self.accesses.get(&access(moved))
    }

    /// Returns true if the value of a transfer varies and is not compared; and true if its size does.
    pub(super) fn varies(&self, item: &Item) -> (bool, bool) {
        let Action::Transfer(moved) = &item.action else { return (false, false) };
        let Some(known) = self.of_access(moved) else { return (false, false) };
        let often = known.counts.iter().any(|count| *count >= CYCLIC);
        let own = moved.mux.is_some_and(|mux| mux.index >= APPLICATION);
        let process = moved.direction == Direction::Upload || (often && own);
        (known.varies && process, known.resizes && process)
    }

    /// Returns true if the number of occurrences is not compared.
    fn is_poll(&self, item: &Item) -> bool {
        let least = |counts: &[usize; 2]| *counts.iter().min().unwrap_or(&0);
        let most = |counts: &[usize; 2]| *counts.iter().max().unwrap_or(&0);
        match &item.action {
            Action::Transfer(moved) => {
                let Some(known) = self.of_access(moved) else { return false };
                let (varies, _) = self.varies(item);
                let enough = match moved.direction {
                    Direction::Upload => most(&known.counts) >= if varies { WAITED } else { POLLED },
                    Direction::Download => varies,
                };
                enough && moved.status == Status::Ok && least(&known.counts) > 0
            }
            _ => self
                .others
                .get(&symbol(&item.action, false, false))
                .is_some_and(|counts| most(counts) >= POLLED && least(counts) > 0),
        }
    }
}

/// Collects the items that each capture has exactly once. Returns the number of varying values that could be equal.
pub(super) fn shared(a: &[Item], b: &[Item], into: &mut Vec<Shared>) -> usize {
    let habits = Habits::of([a.iter(), b.iter()]);
    let unique = |items: &[Item]| {
        let mut symbols: Vec<(u64, bool, [CapturePlace; 2])> = items
            .iter()
            .filter(|item| !is_cut(item))
            .map(|item| (symbol(&item.action, false, false), habits.varies(item).0, [item.since, item.at]))
            .collect();
        symbols.sort_by_key(|(symbol, _, [since, _])| (*symbol, since.on(false)));
        let mut once: Vec<(u64, bool, [CapturePlace; 2])> = Vec::new();
        for group in symbols.chunk_by(|one, other| one.0 == other.0) {
            if let [only] = group {
                once.push(*only);
            }
        }
        once
    };
    let (of_a, of_b) = (unique(a), unique(b));
    let varied = |once: &[(u64, bool, [CapturePlace; 2])]| once.iter().filter(|(_, varied, _)| *varied).count();
    let telling = varied(&of_a).min(varied(&of_b));
    for (symbol, varied, ends) in of_a {
        if let Ok(place) = of_b.binary_search_by_key(&symbol, |(symbol, ..)| *symbol)
            && let Some((.., others)) = of_b.get(place)
        {
            into.extend(ends.into_iter().zip(*others).map(|anchor| Shared { anchor, varied }));
        }
    }
    telling
}

/// Collects matching items in order, for captures without unique items.
pub(super) fn matched(a: &[Item], b: &[Item], into: &mut Vec<Anchor>) {
    let habits = Habits::of([a.iter(), b.iter()]);
    let symbols = |items: &[Item]| -> Vec<u64> {
        items
            .iter()
            .map(|item| habits.varies(item))
            .zip(items)
            .map(|((v, r), item)| symbol(&item.action, v, r))
            .collect()
    };
    for (i, j) in align(&symbols(a), &symbols(b)) {
        if let (Some(one), Some(other)) = (a.get(i), b.get(j)) {
            into.extend([(one.since, other.since), (one.at, other.at)]);
        }
    }
}

/// Returns true if a capture does not show all of a transfer.
fn is_cut(item: &Item) -> bool {
    matches!(&item.action, Action::Transfer(moved) if moved.holed || moved.unended)
}

/// The items that are compared at once: one kind of items of one node.
pub(super) struct Streams<'a> {
    pub(super) kind: ItemKind,
    pub(super) node: u8,
    pub(super) items: [&'a [Item]; 2],
    /// The place from which on each capture knows the state.
    pub(super) known: [Option<CapturePlace>; 2],
    pub(super) alignment: &'a Alignment,
}

impl Streams<'_> {
    /// Compares them.
    pub(super) fn compare(&self, tolerance: f64, found: &mut Found<'_>) {
        let windows = [self.window(0, found), self.window(1, found)];
        let [a, b] = &windows;
        let habits = Habits::of([a.iter().copied(), b.iter().copied()]);
        let symbols = |items: &[&Item]| -> Vec<u64> {
            items
                .iter()
                .map(|item| habits.varies(item))
                .zip(items)
                .map(|((v, r), item)| symbol(&item.action, v, r))
                .collect()
        };
        let mut left: [Vec<&Item>; 2] = Default::default();
        let (mut x, mut y) = (0, 0);
        let ends = (a.len(), b.len());
        for (i, j) in self.pairs(&windows, [&symbols(a), &symbols(b)], &habits).into_iter().chain([ends]) {
            let gap = [a.get(x..i).unwrap_or(&[]), b.get(y..j).unwrap_or(&[])];
            self.gap(gap, &habits, &mut left, found);
            (x, y) = (i + 1, j + 1);
        }
        self.polls(&windows, &habits, tolerance, found);
        for (side, items) in left.iter().enumerate() {
            for item in items {
                self.single(side, item, &habits, found);
            }
        }
    }

    /// Returns the pairs of equal items. Without timestamps the same items in the same order fit in several positions:
    /// they are matched from the beginning, or from the end if fewer items that both captures surely show are missing
    /// then.
    fn pairs(&self, windows: &[Vec<&Item>; 2], symbols: [&[u64]; 2], habits: &Habits) -> Vec<(usize, usize)> {
        let [a, b] = symbols;
        let first = align(a, b);
        let missing = if self.alignment.by_time { 0 } else { self.missing(windows, &first, habits) };
        if missing == 0 {
            return first;
        }
        let backward = |symbols: &[u64]| -> Vec<u64> { symbols.iter().rev().copied().collect() };
        let mirrored = |(i, j): (usize, usize)| Some((a.len().checked_sub(i + 1)?, b.len().checked_sub(j + 1)?));
        let last: Vec<_> = align(&backward(a), &backward(b)).into_iter().rev().filter_map(mirrored).collect();
        if self.missing(windows, &last, habits) < missing { last } else { first }
    }

    /// Counts the items without a partner where both captures surely show what happened.
    fn missing(&self, windows: &[Vec<&Item>; 2], pairs: &[(usize, usize)], habits: &Habits) -> usize {
        let mut missing = 0;
        for (side, items) in windows.iter().enumerate() {
            let mut paired = pairs.iter().map(|(i, j)| if side == 0 { *i } else { *j }).peekable();
            for (place, item) in items.iter().enumerate() {
                let alone = paired.next_if_eq(&place).is_none();
                missing += usize::from(alone && self.is_sure(side, item) && !habits.is_poll(item));
            }
        }
        missing
    }

    /// Returns the items that the other capture may have as well, from beginning to end.
    fn window(&self, side: usize, found: &mut Found<'_>) -> Vec<&Item> {
        let by_time = self.alignment.by_time;
        let items = self.items.get(side).copied().unwrap_or(&[]);
        let inside: Vec<&Item> = items
            .iter()
            .filter(|item| {
                self.alignment.may_cover(side, item.at.on(by_time))
                    && self.alignment.may_cover(side, item.since.on(by_time))
            })
            .collect();
        found.outside(side, items.len() - inside.len());
        inside
    }

    /// Compares the items between two pairs: first the same actions with another content, then the rest.
    fn gap<'b>(&self, gap: [&[&'b Item]; 2], habits: &Habits, left: &mut [Vec<&'b Item>; 2], found: &mut Found<'_>) {
        let [a, b] = gap;
        if a.is_empty() && b.is_empty() {
            return;
        }
        let alike = |items: &[&Item]| -> Vec<u64> { items.iter().map(|item| likeness(&item.action)).collect() };
        let mut rest: [Vec<&'b Item>; 2] = Default::default();
        let (mut x, mut y) = (0, 0);
        for (i, j) in align(&alike(a), &alike(b)).into_iter().chain([(a.len(), b.len())]) {
            let [rest_a, rest_b] = &mut rest;
            rest_a.extend(a.get(x..i).unwrap_or(&[]));
            rest_b.extend(b.get(y..j).unwrap_or(&[]));
            if let (Some(one), Some(other)) = (a.get(i), b.get(j)) {
                self.both(one, other, habits, found);
            }
            (x, y) = (i + 1, j + 1);
        }
        // An item that a capture shows only in part may be any transfer of the other one.
        for side in [0, 1] {
            let [mine, others] = if side == 0 { [0, 1] } else { [1, 0] };
            let cut: Vec<&Item> = rest.get(mine).into_iter().flatten().copied().filter(|item| is_cut(item)).collect();
            for item in cut {
                let object = |item: &Item| match &item.action {
                    Action::Transfer(moved) => moved.mux,
                    _ => None,
                };
                let fits = |other: &&Item| object(item).is_none() || object(item) == object(other);
                let place = rest.get(others).and_then(|items| items.iter().position(fits));
                if let Some(items) = rest.get_mut(mine) {
                    items.retain(|other| !std::ptr::eq(*other, item));
                }
                match place.zip(rest.get_mut(others)) {
                    Some((place, items)) if place < items.len() => {
                        let other = items.remove(place);
                        let pair = if side == 0 { (item, other) } else { (other, item) };
                        self.both(pair.0, pair.1, habits, found);
                    }
                    _ => {}
                }
            }
        }
        for (all, rest) in left.iter_mut().zip(rest) {
            all.extend(rest);
        }
    }

    /// Compares two items of the same action with different content.
    fn both(&self, a: &Item, b: &Item, habits: &Habits, found: &mut Found<'_>) {
        let sides = || [Some(side_of(a)), Some(side_of(b))];
        let (Action::Transfer(one), Action::Transfer(other)) = (&a.action, &b.action) else {
            found.add(DifferenceKind::Item(self.kind, Aspect::Value), Some(self.node), sides());
            return;
        };
        if self.hides(0, a, one, b) || self.hides(1, b, other, a) {
            return;
        }
        let (varies, resizes) = habits.varies(a);
        let outcome = (one.status, one.abort.map(|abort| (abort.code, abort.by)));
        let aspect =
            if outcome != (other.status, other.abort.map(|abort| (abort.code, abort.by))) || one.mux != other.mux {
                Aspect::Outcome
            } else if one.mode != other.mode {
                Aspect::Mode
            } else if one.status == Status::Ok
                && ((!varies && one.hash != other.hash) || (!resizes && one.size != other.size))
            {
                Aspect::Value
            } else {
                return;
            };
        found.add(DifferenceKind::Item(self.kind, aspect), Some(self.node), sides());
    }

    /// Returns true if a capture shows `item` only in part, since the rest of it is beyond its edge: `other` is its
    /// counterpart in the other capture.
    fn hides(&self, side: usize, item: &Item, moved: &TransferDigest, other: &Item) -> bool {
        let by_time = self.alignment.by_time;
        let others = 1 - side;
        let last = self.alignment.covered.get(others).map_or(Ns::MAX, |covered| covered.1);
        // Of equal repetitions, the one that the end cuts may be paired with another one.
        let cut = self.alignment.last.get(side).is_some_and(|last| item.at.on(false) > *last - EDGE);
        let ends = moved.unended && (cut || other.at.on(by_time) > last - self.alignment.slack.1);
        let (first, begun) = (
            self.alignment.first.get(side).copied().unwrap_or_default(),
            self.alignment.covered.get(others).map_or(Ns::MIN, |covered| covered.0),
        );
        let early = other.since.on(by_time) < begun + self.alignment.slack.0;
        let begins = moved.holed && (early || item.since.on(false) <= first + EDGE);
        ends || begins || (moved.holed && matches!(&other.action, Action::Transfer(other) if other.holed))
    }

    /// Reports an item that the other capture lacks.
    fn single(&self, side: usize, item: &Item, habits: &Habits, found: &mut Found<'_>) {
        if !self.is_sure(side, item) {
            return found.outside(side, 1);
        }
        if habits.is_poll(item) {
            return;
        }
        let mut sides = [None, None];
        if let Some(slot) = sides.get_mut(side) {
            *slot = Some(side_of(item));
        }
        found.add(DifferenceKind::Item(self.kind, Aspect::Presence), Some(self.node), sides);
    }

    /// Returns true if the other capture would surely show it.
    fn is_sure(&self, side: usize, item: &Item) -> bool {
        let by_time = self.alignment.by_time;
        let since = item.since.on(by_time);
        let other_knows = self.known.get(1 - side).copied().flatten().map(|place| place.on(by_time));
        let here = |known: Ns| if side == 0 { self.alignment.to_a(known) } else { self.alignment.to_b(known) };
        let close = self.alignment.slack.0 + (if by_time { CLOSE_NS } else { EDGE });
        let unknown = matches!(self.kind, ItemKind::State | ItemKind::Drive(_))
            && !matches!(item.action, Action::BootUp)
            && other_knows.is_none_or(|known| since <= here(known) + close);
        // A channel that was configured before the other capture began is unknown there.
        let unknown = unknown || (self.alignment.begins_apart() && matches!(self.kind, ItemKind::Sdo(Some(_))));
        !unknown && !is_cut(item) && self.alignment.covers(side, since, item.at.on(by_time))
    }

    /// Compares the rates of polls.
    fn polls(&self, windows: &[Vec<&Item>; 2], habits: &Habits, tolerance: f64, found: &mut Found<'_>) {
        let mut polls: BTreeMap<u64, [Vec<&Item>; 2]> = BTreeMap::new();
        for (side, items) in windows.iter().enumerate() {
            for item in items.iter().filter(|item| habits.is_poll(item)) {
                if let Some(all) = polls.entry(likeness(&item.action)).or_default().get_mut(side) {
                    all.push(item);
                }
            }
        }
        for [a, b] in polls.values() {
            let places = |items: &[&Item]| -> Vec<CapturePlace> { items.iter().map(|item| item.at).collect() };
            let (Some(one), Some(other)) = (a.first(), b.first()) else { continue };
            if !self.alignment.by_time {
                continue;
            }
            if let Some((mine, others)) = cyclic::paces(&places(a), &places(b), self.alignment, tolerance) {
                let sides = [(one, mine), (other, others)].map(|(item, ns)| {
                    let mut side = side_of(item);
                    side.pace_ns = Some(ns);
                    Some(side)
                });
                found.add(DifferenceKind::Poll, Some(self.node), sides);
            }
        }
    }
}

fn side_of(item: &Item) -> CaptureSide {
    CaptureSide::new(item.at, item.since, Shows::Action(item.action.clone()))
}

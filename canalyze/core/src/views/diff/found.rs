//! The list of differences, with the position and the number of each. Nothing is compared here.

use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};

use super::alignment::Alignment;
use super::difference::{Aspect, CaptureSide, Difference, DifferenceKind, Shows};
use super::digest::{Action, CapturePlace, ItemKind};
use super::likeness::symbol;
use crate::bytes::frame::BusId;
use crate::bytes::ns::Ns;

/// Maximum number of differences that are kept; further ones are only counted.
const MOST: usize = 20_000;

/// All differences.
#[derive(Debug)]
pub(super) struct Found<'a> {
    pub(super) alignment: &'a Alignment,
    /// The bus that is being compared, in each capture.
    pub(super) bus: [Option<BusId>; 2],
    pub(super) all: Vec<Difference>,
    /// The number of differences that were not kept.
    pub(super) more: u64,
    /// The number of items of each capture in ranges that the other one does not cover.
    pub(super) outside: [u64; 2],
    known: BTreeMap<u64, usize>,
}

impl<'a> Found<'a> {
    /// Creates an empty list.
    pub(super) fn new(alignment: &'a Alignment) -> Self {
        Self { alignment, bus: [None; 2], all: Vec::new(), more: 0, outside: [0; 2], known: BTreeMap::new() }
    }

    /// Counts items of a capture in ranges that the other one does not cover.
    pub(super) fn outside(&mut self, side: usize, count: usize) {
        if let Some(outside) = self.outside.get_mut(side) {
            *outside += count as u64;
        }
    }

    /// Adds a difference.
    pub(super) fn add(&mut self, what: DifferenceKind, node: Option<u8>, sides: [Option<CaptureSide>; 2]) {
        let key = self.key(what, node, &sides);
        let by_time = self.alignment.by_time;
        let place = |side: usize| sides.get(side).and_then(Option::as_ref).map(|side| CapturePlace::of(side.since));
        let shown = |side: usize| sides.get(side).and_then(Option::as_ref);
        let on_a = |side: usize, place: CapturePlace| match side {
            0 => place.on(by_time),
            _ => self.alignment.to_a(place.on(by_time)),
        };
        let is_cyclic = matches!(what, DifferenceKind::Period(_) | DifferenceKind::Jitter(_));
        let order =
            match (place(0).map(|place| on_a(0, place)), place(1).map(|place| on_a(1, place))) {
                // Numbers of frames: the position is that of a frame that only the capture with more of them has.
                (Some(a), Some(b)) if matches!(what, DifferenceKind::Frames(_)) => {
                    if count(shown(0)) >= count(shown(1)) { a } else { b }
                }
                // The outcome of a transfer shows at its end; the reason of an interruption came before.
                (Some(_), Some(_)) if matches!(what, DifferenceKind::Item(ItemKind::Sdo(_), Aspect::Outcome)) => {
                    let ends = [0, 1].map(|side| shown(side).map(|one| on_a(side, CapturePlace::of(one.at))));
                    ends.into_iter().flatten().max().unwrap_or(Ns::MIN)
                }
                // If one capture has a frame and the other one has none, the other one's is shown beside it.
                (Some(a), Some(b)) if is_cyclic => a.max(b),
                (Some(a), Some(b)) => a.min(b),
                (Some(one), None) | (None, Some(one)) => one,
                (None, None) => Ns::MIN,
            };
        // A missing bus, or node, comes before its missing content; a finding behind its subject.
        let rank = match what {
            DifferenceKind::Bus => 0,
            DifferenceKind::Node => 1,
            DifferenceKind::Finding => 3,
            _ => 2,
        };
        let order = (order, rank, place(0).or(place(1)).map_or(0, |place| place.on(false).as_ns() as u32));
        if let Some(one) = self.known.get(&key).and_then(|at| self.all.get_mut(*at)) {
            let count = one.count + 1;
            if order >= one.order {
                one.count = count;
                return;
            }
            (one.order, one.sides, one.count) = (order, sides, count);
            return;
        }
        if self.all.len() >= MOST {
            self.more += 1;
            return;
        }
        let mut beside = [None; 2];
        for (side, slot) in beside.iter_mut().enumerate() {
            if place(side).is_none() {
                *slot =
                    place(1 - side).and_then(|other| self.alignment.beside(1 - side, other)).map(CapturePlace::frame);
            }
        }
        self.known.insert(key, self.all.len());
        self.all.push(Difference { what, bus: self.bus, node, sides, beside, count: 1, order });
    }

    /// Returns true if a node of this bus was configured, commanded or reset differently.
    pub(super) fn configured(&self, node: Option<u8>) -> bool {
        let concerns = |side: &CaptureSide| match &side.shows {
            Shows::Action(Action::Transfer(moved)) => {
                moved.mux.is_none_or(|mux| matches!(mux.index, 0x1005 | 0x1010 | 0x1011 | 0x1400..=0x1BFF | 0x1F22))
            }
            Shows::Action(action) => matches!(action, Action::Nmt(_) | Action::BootUp),
            _ => false,
        };
        let about = |one: &&Difference| one.bus == self.bus && (one.node == node || one.node == Some(0));
        self.all.iter().filter(about).any(|one| one.sides.iter().flatten().any(concerns))
    }

    /// Returns a key that is equal for differences with the same content.
    fn key(&self, what: DifferenceKind, node: Option<u8>, sides: &[Option<CaptureSide>; 2]) -> u64 {
        let mut hasher = DefaultHasher::new();
        (what, node, self.bus).hash(&mut hasher);
        for side in sides {
            match side.as_ref().map(|side| &side.shows) {
                None => 0.hash(&mut hasher),
                // An object is reported once, with the number of occurrences.
                Some(Shows::Action(Action::Transfer(moved))) => {
                    (1, moved.mux, moved.direction.name(), moved.status.name()).hash(&mut hasher);
                }
                Some(Shows::Action(action)) => (2, symbol(action, false, false)).hash(&mut hasher),
                Some(Shows::Finding(finding)) => (3, finding.code, finding.object).hash(&mut hasher),
                Some(_) => 4.hash(&mut hasher),
            }
        }
        hasher.finish()
    }
}

fn count(side: Option<&CaptureSide>) -> u64 {
    match side.map(|side| &side.shows) {
        Some(Shows::Count(frames)) => *frames,
        _ => 0,
    }
}

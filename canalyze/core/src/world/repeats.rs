//! Findings of one kind on one object: the first ones are shown and the others only counted.
//!
//! A fault in every cycle would otherwise hide all others. Each finding is counted.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::bytes::frame::{BusId, FrameRef};
use crate::rules::finding::{Code, Finding};
use crate::sdo::wire::Mux;
use crate::world::event::{Event, What};

/// Number of findings of one rule on one object that are shown.
const SHOWN: u64 = 10;
/// Maximum number of distinct (rule, bus, node, object) that are counted; findings beyond it are all shown.
const COUNTED: usize = 4096;
/// Number of kinds from which on consequences are counted by rule, bus, node and object only, to leave room for causes.
const BY_CAUSE: usize = COUNTED / 2;
/// Number of kinds that are found without a search.
const RECENT: usize = 256;

/// Findings of one kind: same rule, bus, node and object, of the same expectation, and because of the same frame.
type RepeatKey = (Code, BusId, Option<u8>, Option<Mux>, Option<Arc<str>>, Option<u64>);

/// The number of findings of each kind.
#[derive(Debug)]
pub struct Repeats {
    /// The place of each kind in `counted`.
    places: BTreeMap<RepeatKey, usize>,
    counted: Vec<(u64, Finding)>,
    /// Places of kinds that come often, by a part of what tells them apart: a fault may be in every frame.
    recent: [usize; RECENT],
}

impl Default for Repeats {
    fn default() -> Self {
        Self { places: BTreeMap::new(), counted: Vec::new(), recent: [0; RECENT] }
    }
}

impl Repeats {
    /// Removes findings from `events` that were shown often enough.
    pub fn fold(&mut self, events: &mut Vec<Event>) {
        if events.len() < 2 && !matches!(events.first(), Some(Event { what: What::Finding(_), .. })) {
            return;
        }
        events.retain(|event| if let What::Finding(finding) = &event.what { self.shows(finding) } else { true });
    }

    /// Counts a finding that is certainly not shown, since its kind was shown often enough. Returns false if it is not
    /// known to be one; it is then not counted.
    pub fn counts(&mut self, finding: &Finding) -> bool {
        let count = self.recent(slot(finding), finding).filter(|count| **count >= SHOWN);
        count.map(|count| *count += 1).is_some()
    }

    /// Returns the count of the kind of a finding, if it is found without a search.
    fn recent(&mut self, slot: usize, finding: &Finding) -> Option<&mut u64> {
        let (count, known) = self.recent.get(slot).and_then(|place| self.counted.get_mut(*place))?;
        is_alike(known, finding).then_some(count)
    }

    /// Counts a finding. Returns true if it is shown.
    pub fn shows(&mut self, finding: &Finding) -> bool {
        let slot = slot(finding);
        if let Some(count) = self.recent(slot, finding) {
            *count += 1;
            return *count <= SHOWN;
        }
        let expectation = finding.expectation().map(Arc::clone);
        let because_of = finding.because_of.map(|at| at.no);
        let mut key = (finding.code, finding.bus, finding.node, finding.object, expectation, because_of);
        if self.places.len() >= BY_CAUSE && because_of.is_some() && !self.places.contains_key(&key) {
            key.5 = Some(0);
        }
        if self.places.len() >= COUNTED && !self.places.contains_key(&key) {
            return true;
        }
        let alone = key.5 == because_of;
        let place = *self.places.entry(key).or_insert(self.counted.len());
        if place == self.counted.len() {
            self.counted.push((0, finding.clone()));
        }
        if let Some(recent) = self.recent.get_mut(slot).filter(|_| alone) {
            *recent = place;
        }
        let Some((count, _)) = self.counted.get_mut(place) else { return true };
        *count += 1;
        *count <= SHOWN
    }

    /// Appends the counts of findings that were not shown; `at` is the last frame of the capture.
    pub fn finish(&mut self, at: FrameRef, events: &mut Vec<Event>) {
        let Self { places, counted, .. } = std::mem::take(self);
        for place in places.into_values() {
            let Some((count, finding)) = counted.get(place) else { continue };
            if *count > SHOWN {
                let Finding { bus, node, .. } = *finding;
                let facts = finding.facts.repeated(*count - SHOWN);
                let what = What::Finding(Box::new(Finding { at, cause: None, facts, ..finding.clone() }));
                events.push(Event { at, about: None, bus, node, transfer: None, what });
            }
        }
    }
}

/// Returns the place in [`Repeats::recent`] of the kind of a finding.
fn slot(finding: &Finding) -> usize {
    let Finding { code, node, object, .. } = finding;
    let object = object.map_or(0, |object| u64::from(object.index) << 8 | u64::from(object.sub));
    let kind = *code as u64 | u64::from(node.unwrap_or(0)) << 16 | object << 24;
    // Multiplied by 2^64 by the golden ratio, kinds that are close to each other differ in the highest bits.
    (kind.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 56) as usize % RECENT
}

/// Returns true if two findings are of one kind, neither of an expectation.
fn is_alike(one: &Finding, other: &Finding) -> bool {
    let because_of = |finding: &Finding| finding.because_of.map(|at| at.no);
    one.code == other.code
        && (one.bus, one.node, one.object) == (other.bus, other.node, other.object)
        && because_of(one) == because_of(other)
        && one.expectation().is_none()
        && other.expectation().is_none()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::rules::finding::Facts;

    /// A consequence about a PDO of a node, by the index of its parameter.
    fn finding(node: u8, index: u16, because_of: u64) -> Finding {
        let at = FrameRef { no: because_of, ..FrameRef::default() };
        let (object, because_of) = (Some(Mux { index, sub: 0 }), Some(at));
        Finding {
            code: Code::Eds001,
            at,
            cause: None,
            bus: BusId(0),
            node: Some(node),
            object,
            facts: Facts::None,
            because_of,
        }
    }

    #[test]
    fn what_was_shown_often_enough_is_counted_at_once() {
        let (mut repeats, own) = (Repeats::default(), finding(5, 0x1800, 7));
        for _ in 0..SHOWN {
            assert!(!repeats.counts(&own), "it is shown");
            assert!(repeats.shows(&own));
        }
        assert!(repeats.counts(&own));
        let elsewhere = Finding { bus: BusId(1), ..own.clone() };
        for other in [elsewhere, finding(6, 0x1800, 7), finding(5, 0x1801, 7), finding(5, 0x1800, 8)] {
            assert!(!repeats.counts(&other), "{other:?}");
            assert!(repeats.shows(&other), "{other:?}");
        }
        // It is still known behind other kinds.
        assert!(!repeats.shows(&own));
        let mut events = Vec::new();
        repeats.finish(FrameRef::default(), &mut events);
        let counted = events.iter().filter_map(|event| match &event.what {
            What::Finding(finding) => Some((finding.node, format!("{:?}", finding.facts))),
            _ => None,
        });
        assert_eq!(counted.collect::<Vec<_>>(), [(Some(5), format!("{:?}", Facts::None.repeated(2)))]);
    }

    #[test]
    fn kinds_of_neighbours_hardly_share_a_place() {
        let pdos = (1..=8).flat_map(|node| (0..4).map(move |pdo| (node, pdo)));
        let kinds = pdos.flat_map(|(node, pdo)| [finding(node, 0x1400 + pdo, 1), finding(node, 0x1800 + pdo, 1)]);
        let places: BTreeSet<_> = kinds.map(|kind| slot(&kind)).collect();
        assert!(places.len() > 60, "{} places of 64 kinds", places.len());
    }
}

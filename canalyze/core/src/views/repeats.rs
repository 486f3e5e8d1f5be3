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

/// Findings of one kind: same rule, bus, node and object, of the same expectation, and because of the same frame.
type RepeatKey = (Code, BusId, Option<u8>, Option<Mux>, Option<Arc<str>>, Option<u64>);

/// The number of findings of each kind.
#[derive(Debug, Default)]
pub struct Repeats {
    counted: BTreeMap<RepeatKey, (u64, Finding)>,
}

impl Repeats {
    /// Removes findings from `events` that were shown often enough.
    pub fn fold(&mut self, events: &mut Vec<Event>) {
        if events.len() < 2 && !matches!(events.first(), Some(Event { what: What::Finding(_), .. })) {
            return;
        }
        events.retain(|event| if let What::Finding(finding) = &event.what { self.shows(finding) } else { true });
    }

    /// Counts a finding. Returns true if it is shown.
    pub fn shows(&mut self, finding: &Finding) -> bool {
        let counted = &mut self.counted;
        let expectation = finding.expectation().map(Arc::clone);
        let because_of = finding.because_of.map(|at| at.no);
        let mut key = (finding.code, finding.bus, finding.node, finding.object, expectation, because_of);
        if counted.len() >= BY_CAUSE && because_of.is_some() && !counted.contains_key(&key) {
            key.5 = Some(0);
        }
        if counted.len() >= COUNTED && !counted.contains_key(&key) {
            return true;
        }
        let (count, _) = counted.entry(key).or_insert_with(|| (0, finding.clone()));
        *count += 1;
        *count <= SHOWN
    }

    /// Appends the counts of findings that were not shown; `at` is the last frame of the capture.
    pub fn finish(&mut self, at: FrameRef, events: &mut Vec<Event>) {
        for (_, (count, finding)) in std::mem::take(&mut self.counted) {
            if count > SHOWN {
                let Finding { bus, node, .. } = finding;
                let facts = finding.facts.repeated(count - SHOWN);
                let what = What::Finding(Box::new(Finding { at, cause: None, facts, ..finding }));
                events.push(Event { at, about: None, bus, node, transfer: None, what });
            }
        }
    }
}

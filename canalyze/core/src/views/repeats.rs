//! Findings of one kind on one object, of which the first are shown and the rest only counted.
//!
//! A fault that stands in every cycle would else bury all others. Must not: judge, or forget a count.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::bytes::frame::{BusId, FrameRef};
use crate::rules::finding::{Code, Finding};
use crate::sdo::wire::Mux;
use crate::world::event::{Event, What};

/// Findings of one rule on one object that are shown before the rest is only counted.
const SHOWN: u64 = 10;
/// Distinct (rule, bus, node, object) that are counted apart; more are shown one by one.
const COUNTED: usize = 4096;
/// From so many on, consequences are counted apart by rule, bus, node and object only: they leave room for causes.
const BY_CAUSE: usize = COUNTED / 2;

/// Findings of one kind: same rule, bus, node and object, of the same expectation, and because of the same frame.
type Kind = (Code, BusId, Option<u8>, Option<Mux>, Option<Arc<str>>, Option<u64>);

/// How often which finding was raised.
#[derive(Debug, Default)]
pub struct Repeats {
    counted: BTreeMap<Kind, (u64, Finding)>,
}

impl Repeats {
    /// Takes out of `events` what was shown often enough.
    pub fn fold(&mut self, events: &mut Vec<Event>) {
        if events.len() < 2 && !matches!(events.first(), Some(Event { what: What::Finding(_), .. })) {
            return;
        }
        events.retain(|event| if let What::Finding(finding) = &event.what { self.shows(finding) } else { true });
    }

    /// Counts a finding, and says whether it is shown.
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

    /// Appends what was only counted; `at` is the last frame of the capture.
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

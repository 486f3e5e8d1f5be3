//! Transfers as soon as they are shown, each once.
//!
//! A pair whose request was captured late is told of only when its channel goes on, which may be much later; the line of
//! its later frame shows its result at once. What has a time or a place in an order is judged by that. Must not: judge.

use std::sync::Arc;

use crate::sdo::transfer::Transfer;
use crate::world::event::What;

/// Transfers that are shown and of which nobody has told yet, at most: one a channel is usual.
const KEPT: usize = 1024;

/// Those transfers.
#[derive(Debug, Default)]
pub(super) struct Shown {
    waiting: Vec<Arc<Transfer>>,
}

impl Shown {
    /// The transfer that an event shows, unless it was shown before.
    pub(super) fn next(&mut self, what: &What) -> Option<Arc<Transfer>> {
        match what {
            What::Sdo(step) => {
                let shown = Arc::clone(step.result.as_ref()?);
                if self.waiting.len() >= KEPT {
                    self.waiting.remove(0);
                }
                self.waiting.push(Arc::clone(&shown));
                Some(shown)
            }
            What::Transfer(told) => {
                let place = self.waiting.iter().position(|shown| shown.id == told.id);
                let shown = place.map(|place| self.waiting.remove(place));
                // Its pair may have been dissolved meanwhile: then it is another one.
                let same = |shown: Arc<Transfer>| {
                    shown.outcome.status == told.outcome.status && shown.data.kept == told.data.kept
                };
                (!shown.is_some_and(same)).then(|| Arc::clone(told))
            }
            _ => None,
        }
    }
}

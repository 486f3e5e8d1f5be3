//! Transfers as soon as they are shown, each once.
//!
//! A pair whose request was captured late is announced only when its channel continues, possibly much later; the line
//! of its later frame shows its result at once. Expectations of times and orders are judged by that.

use std::sync::Arc;

use crate::sdo::transfer::Transfer;
use crate::world::event::What;

/// Maximum number of transfers that are shown and not announced yet; one a channel is usual.
const KEPT: usize = 1024;

/// Shown transfers that are not announced yet.
#[derive(Debug, Default)]
pub(super) struct ShownTransfers {
    waiting: Vec<Arc<Transfer>>,
}

impl ShownTransfers {
    /// Returns the transfer that an event shows, unless it was shown before.
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
                // Its pair may have been dissolved meanwhile, and is then another transfer.
                let same = |shown: Arc<Transfer>| {
                    shown.outcome.status == told.outcome.status && shown.data.kept == told.data.kept
                };
                (!shown.is_some_and(same)).then(|| Arc::clone(told))
            }
            _ => None,
        }
    }
}

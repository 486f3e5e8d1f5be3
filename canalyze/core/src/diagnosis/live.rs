//! What can be said of incidents while the capture goes on: what is certain by now, and how all of it would stand.
//!
//! It must not decide anything by itself: the end of a capture is judged by `mod` alone, of a copy where it is not over.

use super::causes::WINDOW_NS;
use super::incident::{Grade, Incident, IncidentId};
use super::rank::is_root;
use super::{CLOSED, Diagnosis, Phase};
use crate::bus::Bus;

impl Diagnosis {
    /// Adds whose cause has changed since it was told. Those that have just begun to show are told with theirs.
    pub(super) fn linked(&mut self, changes: &mut Vec<(Phase, IncidentId)>) {
        let mut linking = std::mem::take(&mut self.linking);
        linking.retain_mut(|(place, told)| {
            let Some(one) = self.ledger.get(*place) else { return false };
            let settled = self.is_settled_by_now(one);
            let known = one.cause.filter(|_| !is_root(one)).map(|link| (link.cause, settled));
            if known.is_some() && known != *told {
                changes.push((Phase::Linked, one.id));
            }
            *told = known;
            !settled
        });
        for (phase, id) in changes.iter() {
            let Some(one) = self.ledger.by_id(*id).filter(|_| *phase == Phase::Opened) else { continue };
            if self.is_settled_by_now(one) {
                continue;
            }
            let known = one.cause.filter(|_| !is_root(one)).map(|link| (link.cause, false));
            linking.push_back(((id.0 as usize).saturating_sub(1), known));
        }
        while linking.len() > CLOSED {
            linking.pop_front();
        }
        self.linking = linking;
    }

    /// Whether what is said of the cause of an incident will stay: it is certain, the time is over in which another one
    /// may be found, or the capture is. `now_ns`: the time; without stamps only the end settles what is not certain.
    pub fn is_settled(&self, one: &Incident, now_ns: Option<i64>) -> bool {
        let certain = one.cause.is_some_and(|link| link.grade == Grade::Certain);
        let since = now_ns.zip(one.noticed.t_ns).map(|(now, noticed)| now.saturating_sub(noticed));
        self.over || certain || since.is_some_and(|since| since > WINDOW_NS)
    }

    /// The same by the last frame.
    pub fn is_settled_by_now(&self, one: &Incident) -> bool {
        self.is_settled(one, self.last.t_ns)
    }

    /// Whether nothing went wrong so far, and no end of the capture could change that.
    pub fn is_empty(&self) -> bool {
        self.ledger.all.is_empty() && self.buses.iter().all(|one| one.heard.errors.0 == 0)
    }

    /// Whether the capture is over.
    pub fn is_over(&self) -> bool {
        self.over
    }

    /// How all of it would stand if the capture were over now. Whom that shows keeps its number from then on.
    pub fn by_now(&mut self, state: &[Bus]) -> Self {
        let mut copy = self.clone();
        copy.finish(state);
        self.ledger.take_numbers(&copy.ledger);
        copy
    }
}

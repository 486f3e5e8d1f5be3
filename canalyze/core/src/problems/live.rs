//! The state of problems while the capture goes on: certain facts, and the status if the capture ended now.
//!
//! Only `mod` judges the end of a capture; for one that goes on it judges a copy.

use super::causes::WINDOW_NS;
use super::problem::{Grade, Problem, ProblemId};
use super::rank::is_root;
use super::{CLOSED, Diagnosis, Phase};
use crate::bytes::ns::Ns;
use crate::evidence::services::Nature;
use crate::world::bus::Bus;

impl Diagnosis {
    /// Adds problems whose cause has changed since it was reported. New ones are reported together with their cause.
    pub(super) fn linked(&mut self, changes: &mut Vec<(Phase, ProblemId)>) {
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

    /// Returns true if the cause of a problem is final: it is certain, the time for finding another one is over, or
    /// the capture is. `now_ns`: the time; without stamps, an uncertain cause becomes final only at the end.
    pub fn is_settled(&self, one: &Problem, now_ns: Option<Ns>) -> bool {
        let certain = one.cause.is_some_and(|link| link.grade == Grade::Certain);
        let since = now_ns.zip(one.noticed.t_ns).map(|(now, noticed)| now - noticed);
        self.over || certain || since.is_some_and(|since| since > WINDOW_NS)
    }

    /// Returns the same at the time of the last frame.
    pub fn is_settled_by_now(&self, one: &Problem) -> bool {
        self.is_settled(one, self.last.t_ns)
    }

    /// Returns true if there are no problems so far and the end of the capture cannot add any.
    pub fn is_empty(&self) -> bool {
        self.ledger.all.is_empty() && self.buses.iter().all(|one| one.heard.errors.0 == 0)
    }

    /// Returns true if the capture is over.
    pub fn is_over(&self) -> bool {
        self.over
    }

    /// Returns the diagnosis as if the capture ended now. Numbers assigned in it are kept.
    pub fn by_now(&mut self, state: &[Bus], nature: Nature) -> Self {
        let mut copy = self.clone();
        copy.finish(state, nature);
        self.ledger.take_numbers(&copy.ledger);
        copy
    }
}

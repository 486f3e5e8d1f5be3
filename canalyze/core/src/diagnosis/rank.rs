//! The order in which a person reads: what stands first, then by what it means for the machine, how far it reaches, how
//! sure it is, and when it began.
//!
//! Must not: leave anything out.

use super::incident::{Grade, Incident, IncidentId};
use super::ledger::Ledger;
use super::links::spread;

/// Whether an incident is a root: nothing is known to have caused it, beyond what is only possible.
pub fn is_root(one: &Incident) -> bool {
    one.cause.is_none_or(|link| link.grade == Grade::Possible)
}

/// The roots, in the order in which they are read.
pub fn roots(ledger: &Ledger) -> Vec<IncidentId> {
    let mut roots: Vec<_> = ledger.told().filter(|one| is_root(one)).collect();
    roots.sort_by_cached_key(|one| {
        let spread = std::cmp::Reverse(spread(ledger, one));
        (one.status, one.impact(), spread, std::cmp::Reverse(one.grade), one.begin.no, one.id)
    });
    roots.into_iter().map(|one| one.id).collect()
}

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

/// Causes that stand above an incident at most.
const DEPTH: u64 = 16;

/// All incidents in the order in which they are read, each with how many causes stand above it: a cause comes before
/// what it has caused.
pub fn stories(ledger: &Ledger) -> Vec<(IncidentId, u64)> {
    let mut order = Vec::new();
    for root in roots(ledger) {
        story(&mut order, ledger, root, 0);
    }
    order
}

/// Adds an incident and what it has caused, in the order of their numbers.
fn story(order: &mut Vec<(IncidentId, u64)>, ledger: &Ledger, id: IncidentId, depth: u64) {
    order.push((id, depth));
    let caused = |one: &&Incident| !is_root(one) && one.cause.is_some_and(|link| link.cause == id);
    for one in ledger.told().filter(caused).filter(|_| depth < DEPTH) {
        story(order, ledger, one.id, depth + 1);
    }
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

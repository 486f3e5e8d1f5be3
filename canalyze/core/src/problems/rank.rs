//! The reading order of problems: by status, effect on the machine, extent, certainty and beginning.

use super::ledger::Ledger;
use super::links::spread;
use super::problem::{Grade, Problem, ProblemId};

/// Returns true if a problem is a root: without a cause, or with one that is only possible.
pub fn is_root(one: &Problem) -> bool {
    one.cause.is_none_or(|link| link.grade == Grade::Possible)
}

/// Maximum number of causes above a problem.
const DEPTH: u64 = 16;

/// Returns all problems in reading order with the number of causes above each; a cause precedes its consequences.
pub fn stories(ledger: &Ledger) -> Vec<(ProblemId, u64)> {
    let mut order = Vec::new();
    for root in roots(ledger) {
        story(&mut order, ledger, root, 0);
    }
    order
}

/// Appends a problem and its consequences, in the order of their numbers.
fn story(order: &mut Vec<(ProblemId, u64)>, ledger: &Ledger, id: ProblemId, depth: u64) {
    order.push((id, depth));
    let caused = |one: &&Problem| !is_root(one) && one.cause.is_some_and(|link| link.cause == id);
    for one in ledger.told().filter(caused).filter(|_| depth < DEPTH) {
        story(order, ledger, one.id, depth + 1);
    }
}

/// Returns the roots in reading order.
pub fn roots(ledger: &Ledger) -> Vec<ProblemId> {
    let mut roots: Vec<_> = ledger.told().filter(|one| is_root(one)).collect();
    roots.sort_by_cached_key(|one| {
        let spread = std::cmp::Reverse(spread(ledger, one));
        (one.status, one.impact(), spread, std::cmp::Reverse(one.grade), one.begin.no, one.id)
    });
    roots.into_iter().map(|one| one.id).collect()
}

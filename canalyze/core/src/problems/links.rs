//! Links between problems: consequences to causes, and one problem for the same trouble of several nodes.
//!
//! `causes` decides if one problem can have caused another. A consequence has one cause; others are kept as possible.
//! There is never a cycle.

use super::causes::{Found, LATE_NS, PERIODS, WINDOW_NS, relate};
use super::kinds::ProblemKind;
use super::ledger::{Ledger, LedgerPlace};
use super::problem::{Grade, Link, Problem, Status, bit};
use super::roles::KindRole;
use crate::bytes::frame::BusId;
use crate::bytes::ns::Ns;

/// Links a new problem with earlier ones, and problems of the last seconds with it.
pub(super) fn link(ledger: &mut Ledger, place: LedgerPlace, bus: BusId) {
    let recent = ledger.recent(bus);
    if let Some(link) = best(ledger, place, &recent) {
        set(ledger, place, link);
    }
    let Some(new) = ledger.get(place).cloned() else { return };
    for other in recent {
        let Some(one) = ledger.get(other) else { continue };
        let late = new.noticed.since(one.noticed).is_none_or(|since| since <= WINDOW_NS);
        if other == place || !late || one.cause.is_some_and(|link| link.grade == Grade::Certain) {
            continue;
        }
        if let Some(link) = best(ledger, other, &[place]) {
            set(ledger, other, link);
        }
    }
}

fn set(ledger: &mut Ledger, place: LedgerPlace, link: Link) {
    if let Some(one) = ledger.get_mut(place) {
        one.link(link);
    }
}

/// Returns the best cause of a problem among others.
fn best(ledger: &Ledger, place: LedgerPlace, others: &[LedgerPlace]) -> Option<Link> {
    // A problem that began before its first evidence has no cause in the capture.
    let effect = ledger.get(place).filter(|effect| !effect.has("seen_in_fault"))?;
    let mut found: Option<(Found, &Problem)> = None;
    for other in others.iter().filter(|other| **other != place) {
        let Some(cause) = ledger.get(*other) else { continue };
        if !touches(cause, effect) || ledger.comes_from(cause.id, effect.id) {
            continue;
        }
        let Some(one) = relate(cause, effect) else { continue };
        let better = found.is_none_or(|(before, problem)| {
            (one.1, -one.2, std::cmp::Reverse(cause.begin.no))
                > (before.1, -before.2, std::cmp::Reverse(problem.begin.no))
        });
        if better {
            found = Some((one, cause));
        }
    }
    let ((rule, grade, far_ns), cause) = found?;
    Some(Link { cause: cause.id, rule, grade, delay_ns: effect.begin.since(cause.begin), far_ns })
}

/// Returns true if one problem was open, or had just ended, when the other began.
fn touches(cause: &Problem, effect: &Problem) -> bool {
    if let Some(frame) = effect.clue.because_of
        && cause.holds(frame)
    {
        return true;
    }
    // A changed period is known some periods after it was the cause of something.
    let early = match (cause.kind, cause.slow_ns()) {
        (kind, Some(period)) if kind.is(KindRole::Slower) => period * PERIODS,
        // Two devices show only after some frames of both.
        (kind, _) if kind.is(KindRole::SecondDevice) => WINDOW_NS,
        // The node was off before its boot-up.
        (kind, _) if kind.is(KindRole::Restart) || kind.is(KindRole::Loop) => WINDOW_NS,
        _ => LATE_NS,
    };
    // A node that is never started goes on waiting.
    let waits = effect.kind.is(KindRole::AwaitsStart);
    let before = waits || effect.noticed.since(cause.begin).is_none_or(|since| since >= -early);
    let after = cause.end.is_none_or(|end| effect.begin.since(end).is_none_or(|since| since <= WINDOW_NS));
    before && after
}

/// Number of nodes requested in vain in a row from which it is a scan, and maximum time between two of them in ns.
const SCANNED: usize = 8;
const SCAN_NS: Ns = Ns::from_s(3);
/// Maximum distance of consequences of one cause and kind that are one problem, in ns.
const TOGETHER_NS: Ns = Ns::from_ms(100);

/// Concludes scans at the end of the capture: a scan requests many nodes that do not exist, and none of them is
/// missing.
pub(super) fn scanned(ledger: &mut Ledger, bus: BusId) {
    let absent: Vec<LedgerPlace> = (0..ledger.all.len())
        .filter(|place| {
            ledger
                .get(*place)
                .is_some_and(|one| one.bus == bus && one.kind.is(KindRole::NeverHeard) && one.end.is_none())
        })
        .collect();
    let mut run: Vec<LedgerPlace> = Vec::new();
    for place in absent.iter().copied().map(Some).chain([None]) {
        let follows = place.zip(run.last().copied()).is_some_and(|(place, last)| {
            let (one, last) = (ledger.get(place), ledger.get(last));
            one.zip(last).is_some_and(|(one, last)| {
                let ascends = last.subject.node < one.subject.node;
                ascends && one.begin.since(last.begin).is_none_or(|since| since <= SCAN_NS)
            })
        });
        if !follows {
            if let Some((first, others)) = run.split_first().filter(|_| run.len() >= SCANNED) {
                others.iter().for_each(|other| ledger.merge(*other, *first));
                if let Some(one) = ledger.get_mut(*first) {
                    (one.kind, one.subject.node) = (ProblemKind::Scan, None);
                    one.repeats.count = run.len() as u64;
                }
            }
            run.clear();
        }
        run.extend(place);
    }
}

/// Joins problems at the end of the capture: the same consequence of one cause for several nodes, and a stopped SYNC
/// with the loss of its producer.
pub(super) fn join(ledger: &mut Ledger) {
    for place in 0..ledger.all.len() {
        let Some(one) = ledger.get(place) else { continue };
        let Some(link) = one.cause.filter(|link| link.grade >= Grade::Likely) else { continue };
        let into = match one.kind {
            kind if kind.is(KindRole::NoSync) && link.rule == 6 && link.grade == Grade::Certain => Some(place_of(link)),
            // A node's report with the reaction of its axis; a PDO with the failed writes to configure it.
            kind if link.rule == 17 && !kind.is(KindRole::Restart) && one.status == Status::Harmless => {
                Some(place_of(link))
            }
            kind if kind.is(KindRole::Reaction) && link.rule == 7 && link.grade == Grade::Certain => {
                Some(place_of(link))
            }
            kind if kind.is(KindRole::WrongLength) && link.rule == 13 && is_same_pdo(ledger, one, link) => {
                Some(place_of(link))
            }
            kind if kind.is(KindRole::Violation) && link.rule == 11 && link.grade == Grade::Likely => {
                Some(place_of(link))
            }
            _ => (0..place).find(|other| ledger.get(*other).is_some_and(|other| is_alike(other, one, link))),
        };
        if let Some(into) = into {
            ledger.merge(place, into);
        }
    }
}

fn is_same_pdo(ledger: &Ledger, one: &Problem, link: Link) -> bool {
    let cause = ledger.by_id(link.cause);
    cause.is_some_and(|cause| cause.subject.node == one.subject.node && cause.subject.pdo == one.subject.pdo)
}

fn place_of(link: Link) -> LedgerPlace {
    (link.cause.0 as usize).saturating_sub(1)
}

/// Returns true if the same happened to another node at the same time by the same cause.
fn is_alike(other: &Problem, one: &Problem, link: Link) -> bool {
    let near = one.begin.since(other.begin).is_some_and(|since| since.abs() <= TOGETHER_NS);
    let same = other.kind == one.kind && other.bus == one.bus && other.status == one.status && !other.merged;
    let subject = one.subject.node.is_some() && one.subject.pdo.is_none() && one.subject.axis == other.subject.axis;
    same && near
        && subject
        && other.clue.reported == one.clue.reported
        && other.cause.is_some_and(|cause| cause.cause == link.cause)
}

/// Concludes at the end of the capture: consequences of harmless problems are harmless, too.
pub(super) fn settle(ledger: &mut Ledger) {
    // The stop of a single node is not intended if other nodes are waiting for it.
    for place in 0..ledger.all.len() {
        let Some(one) = ledger.get(place).filter(|one| one.kind.is(KindRole::Stop) && !one.clue.everyone) else {
            continue;
        };
        let reported = |other: &&Problem| !other.clue.reported.is_empty() || other.kind.is(KindRole::Fault);
        let follows = ledger.told().filter(reported).any(|other| other.cause.is_some_and(|link| link.cause == one.id));
        let over = follows && one.status == Status::Harmless && one.end.is_some();
        if let Some(one) = ledger.get_mut(place).filter(|_| over) {
            one.status = Status::Ended;
        }
    }
    // Whether it should go on is no question where others suffer from it.
    for place in 0..ledger.all.len() {
        let Some(one) = ledger.get(place).filter(|one| one.clue.unsettled && one.status == Status::Unknown) else {
            continue;
        };
        let suffers = |other: &Problem| {
            let of_it = |link: Link| link.cause == one.id && link.grade >= Grade::Likely;
            other.status == Status::Open && other.cause.is_some_and(of_it)
        };
        let open = ledger.told().any(suffers);
        if let Some(one) = ledger.get_mut(place).filter(|_| open) {
            one.status = Status::Open;
        }
    }
    // A consequence may precede its cause in the list, so this repeats for each link in a chain.
    let mut changed = true;
    while changed {
        changed = false;
        for place in 0..ledger.all.len() {
            let Some(one) = ledger.get(place) else { continue };
            let Some(link) = one.cause.filter(|link| link.grade >= Grade::Likely) else { continue };
            let harmless = ledger.by_id(link.cause).is_some_and(|cause| cause.status == Status::Harmless);
            if harmless
                && one.status == Status::Ended
                && let Some(one) = ledger.get_mut(place)
            {
                one.status = Status::Harmless;
                changed = true;
            }
        }
    }
    // A cause that is not reported cannot be named.
    let told: Vec<bool> = ledger.all.iter().map(Problem::counts).collect();
    for one in &mut ledger.all {
        let is_told = |link: &Link| told.get((link.cause.0 as usize).wrapping_sub(1)).copied().unwrap_or(false);
        one.cause = one.cause.filter(is_told);
        one.possible.retain(is_told);
    }
}

/// Returns the number of nodes concerned by a problem and its consequences.
pub(super) fn spread(ledger: &Ledger, root: &Problem) -> u32 {
    let parts = ledger.told().filter(|one| ledger.comes_from(one.id, root.id));
    parts.fold(0, |nodes, one| nodes | one.subject.nodes | one.subject.node.map_or(0, bit)).count_ones()
}

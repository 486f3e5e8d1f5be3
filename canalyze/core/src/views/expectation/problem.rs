//! Problems that must, may and must not occur, how soon each has to end, and their causes.
//!
//! They are judged at the end of the capture, when their states and causes are known. An expectation that something
//! must not occur is overruled by one that it may occur, if that is as specific or more so: "none but that node 9 is
//! silent". An expectation without a kind is about problems without a cause. Kinds are names here; their meaning does
//! not matter.

use std::sync::Arc;

use serde::Deserialize;

use super::{Breach, Closing, EntryPlace, check_node, check_times, mistake};
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::bytes::select::Select;
use crate::problems::Diagnosis;
use crate::problems::problem::{Grade, Problem, Status};
use crate::problems::rank::{is_root, roots};
use crate::rules::NamedProblem;
use crate::rules::expectation::{Exp015, Exp017, Exp018, Exp019, Exp020};

/// Maximum number of problems that are named one by one.
const NAMED: usize = 5;
/// Maximum number of steps from a problem to its first cause.
const CHAIN: usize = 16;

/// Problems, and the number of further ones.
type NamedProblems = (Arc<[NamedProblem]>, u64);

/// An expectation in the form of the file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ProblemEntry {
    line: u32,
    bus: Option<String>,
    node: Option<u8>,
    /// A kind, or a glob of kinds.
    kind: Option<String>,
    /// The least and the greatest number of occurrences.
    occurs: Option<(u64, Option<u64>)>,
    ends_within_ns: Option<Ns>,
    /// The kind of the cause, or a glob of kinds.
    cause: Option<String>,
}

impl ProblemEntry {
    pub(super) fn check(&self) -> Result<(), String> {
        check_node(self.line, self.node)?;
        check_times(self.line, &[self.ends_within_ns], &[])?;
        if self.occurs.is_some_and(|(least, most)| most.is_some_and(|most| most < least)) {
            return mistake(self.line, "occurs");
        }
        if self.occurs.is_none() && self.ends_within_ns.is_none() && self.cause.is_none() {
            return mistake(self.line, "occurs, ends_within_ns or cause");
        }
        Ok(())
    }

    fn forbids(&self) -> bool {
        matches!(self.occurs, Some((_, Some(0))))
    }

    /// The number of conditions that it names: more specific expectations overrule others.
    fn weight(&self) -> usize {
        let letters = self.kind.as_ref().map_or(0, |kind| kind.bytes().filter(|byte| !is_wild(*byte)).count());
        4 * letters + 2 * usize::from(self.node.is_some()) + usize::from(self.bus.is_some())
    }
}

fn is_wild(byte: u8) -> bool {
    matches!(byte, b'*' | b'?')
}

/// An expectation, ready for use.
#[derive(Debug)]
struct Expected {
    entry: ProblemEntry,
    place: EntryPlace,
    kind: Option<Select>,
    cause: Option<Select>,
}

impl Expected {
    fn new(file: &str, entry: &ProblemEntry) -> Self {
        Self {
            place: EntryPlace::new(file, entry.line, entry.bus.as_ref(), entry.node),
            kind: entry.kind.as_deref().map(Select::parse),
            cause: entry.cause.as_deref().map(Select::parse),
            entry: entry.clone(),
        }
    }

    /// Returns true if it is about a problem on a bus of this name. A harmless problem has to be expected by its kind.
    fn fits(&self, one: &Problem, bus: &[u8]) -> bool {
        let asked = self.entry.kind.as_deref() == Some(one.kind.row().name);
        let kind = match &self.kind {
            Some(kinds) => kinds.takes([one.kind.row().name]),
            None => is_root(one),
        };
        let node = self.entry.node.is_none_or(|node| one.subject.concerns(node));
        kind && node && self.place.is_on(bus) && (asked || one.status != Status::Harmless)
    }

    /// The kind in the form of the file.
    fn named(&self) -> Arc<str> {
        self.entry.kind.as_deref().unwrap_or("*").into()
    }
}

/// All expectations of problems.
#[derive(Debug)]
pub(super) struct ProblemExpectations {
    all: Vec<Expected>,
}

impl ProblemExpectations {
    pub(super) fn new(file: &str, entries: &[ProblemEntry]) -> Self {
        Self { all: entries.iter().map(|entry| Expected::new(file, entry)).collect() }
    }

    /// Reports at the end of the capture, by its diagnosis.
    pub(super) fn finish(&self, diagnosis: &Diagnosis, closing: &mut Closing<'_>) {
        self.forbidden(diagnosis, closing);
        for expected in &self.all {
            let fitting: Vec<_> =
                diagnosis.ledger().told().filter(|one| expected.fits(one, closing.buses.name(one.bus))).collect();
            expected.counted(&fitting, diagnosis, closing);
            for one in fitting {
                expected.ended(one, closing);
                expected.caused(one, diagnosis, closing);
            }
        }
    }

    fn forbidden(&self, diagnosis: &Diagnosis, closing: &mut Closing<'_>) {
        for one in diagnosis.ledger().told() {
            let bus = closing.buses.name(one.bus);
            let fitting = || self.all.iter().filter(|expected| expected.fits(one, bus));
            let weights =
                fitting().filter(|expected| !expected.entry.forbids()).map(|expected| expected.entry.weight());
            let allowed = weights.max();
            let forbidding = fitting().filter(|expected| expected.entry.forbids());
            let strictest = forbidding
                .filter(|expected| Some(expected.entry.weight()) > allowed)
                .max_by_key(|expected| expected.entry.weight());
            if let Some(expected) = strictest {
                let breach = Breach::new(Exp018::Occurred { found: alone(one) }, closing.last, one.bus);
                closing.raise(&expected.place, about(breach, one));
            }
        }
    }
}

impl Expected {
    /// Reports a number of occurrences that differs.
    fn counted(&self, fitting: &[&Problem], diagnosis: &Diagnosis, closing: &mut Closing<'_>) {
        let Some((least, most)) = self.entry.occurs else { return };
        let count = fitting.iter().fold(0_u64, |sum, one| sum.saturating_add(one.repeats.count));
        let breach = if count == 0 && least > 0 {
            let found = self.instead(diagnosis);
            match found.0.is_empty() {
                true => closing.breach(&self.place, Exp017::Nothing { expected: self.named() }),
                false => closing.breach(&self.place, Exp017::NoneOf { expected: self.named(), found }),
            }
        } else if count < least {
            let found = problems(fitting.iter().copied());
            closing.breach(&self.place, Exp017::TooFew { expected: least, count, found })
        } else if let Some(most) = most.filter(|most| *most > 0 && *most < count) {
            let found = problems(fitting.iter().copied());
            closing.breach(&self.place, Exp018::TooMany { expected: most, count, found })
        } else {
            return;
        };
        closing.raise(&self.place, breach);
    }

    /// Returns the problems that occurred instead of a missing one: those of the node first, then by impact.
    fn instead(&self, diagnosis: &Diagnosis) -> NamedProblems {
        let ledger = diagnosis.ledger();
        let mut found: Vec<_> = roots(ledger).into_iter().filter_map(|id| ledger.by_id(id)).collect();
        found.retain(|one| one.status != Status::Harmless);
        found.sort_by_key(|one| !self.entry.node.is_some_and(|node| one.subject.concerns(node)));
        problems(found)
    }

    /// Reports a problem that did not end in time.
    fn ended(&self, one: &Problem, closing: &mut Closing<'_>) {
        let Some(expected) = self.entry.ends_within_ns else { return };
        let problem = alone(one);
        let breach = |what: Exp019| Breach::new(what, closing.last, one.bus);
        let unchecked = |why: Exp015| Breach::new(why, closing.last, one.bus);
        let lasted = one.end.map(|end| (end.listed().no, lasted(one, end)));
        let breach = match lasted {
            Some((_, Some(found))) if found <= expected => return,
            Some((end, Some(found))) => breach(Exp019::Late { expected, found, problem, end }),
            Some((_, None)) => unchecked(Exp015::NoStamps),
            None => match closing.end_ns.zip(one.repeats.since.t_ns).map(|(end, since)| end - since) {
                None => unchecked(Exp015::NoStamps),
                Some(found) if found > expected => breach(Exp019::Standing { expected, found, problem }),
                Some(_) => unchecked(Exp015::NotOverYet { problem }),
            },
        };
        closing.raise(&self.place, about(breach, one));
    }

    /// Reports a problem without the expected cause, direct or indirect.
    fn caused(&self, one: &Problem, diagnosis: &Diagnosis, closing: &mut Closing<'_>) {
        let Some(kinds) = &self.cause else { return };
        let chain = causes(one, diagnosis);
        if chain.iter().any(|cause| kinds.takes([cause.kind.row().name])) {
            return;
        }
        let (problem, expected) = (alone(one), self.entry.cause.as_deref().unwrap_or_default().into());
        let possible = one.cause.iter().chain(&one.possible).filter(|link| link.grade == Grade::Possible);
        let possible: Vec<_> = possible.filter_map(|link| diagnosis.ledger().by_id(link.cause)).collect();
        let what = if !chain.is_empty() {
            Exp020::Other { expected, problem, found: problems(chain) }
        } else if !possible.is_empty() {
            Exp020::NotSure { expected, problem, found: problems(possible) }
        } else {
            Exp020::Unknown { expected, problem }
        };
        closing.raise(&self.place, about(Breach::new(what, closing.last, one.bus), one));
    }
}

/// Returns a finding about the frame at which a problem begins, and about its node.
fn about(breach: Breach, one: &Problem) -> Breach {
    let breach = breach.about(one.begin);
    match one.subject.node {
        Some(node) => breach.of(node),
        None => breach,
    }
}

/// The longest time that it lasted, in ns; `None` without timestamps.
fn lasted(one: &Problem, end: FrameRef) -> Option<Ns> {
    match one.repeats.count {
        1 => end.since(one.begin),
        _ => one.begin.t_ns.map(|_| one.repeats.longest_ns),
    }
}

/// Returns its causes, the nearest first; possible causes do not count.
fn causes<'a>(one: &'a Problem, diagnosis: &'a Diagnosis) -> Vec<&'a Problem> {
    let mut chain = Vec::new();
    let mut at = one;
    while let Some(link) = at.cause.filter(|_| !is_root(at) && chain.len() < CHAIN) {
        let Some(cause) = diagnosis.ledger().by_id(link.cause) else { break };
        chain.push(cause);
        at = cause;
    }
    chain
}

fn problem(one: &Problem, node: Option<u8>) -> NamedProblem {
    let row = one.kind.row();
    NamedProblem { name: row.name, words: row.words, node, frame: one.begin.listed().no }
}

/// A problem of a node that has been named.
fn alone(one: &Problem) -> NamedProblems {
    ([problem(one, None)].into(), 0)
}

/// Problems with their nodes.
fn problems<'a>(all: impl IntoIterator<Item = &'a Problem>) -> NamedProblems {
    let mut all = all.into_iter();
    let named: Vec<_> = all.by_ref().take(NAMED).map(|one| problem(one, one.subject.node)).collect();
    (named.into(), all.count() as u64)
}

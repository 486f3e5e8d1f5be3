//! A problem: a problem of one subject from its beginning to its end, with its cause.
//!
//! It consists of facts at frames and holds no words of a language.

use super::kinds::{Impact, ProblemKind};
use super::roles::KindRole;
use crate::bytes::frame::{BusId, FrameRef};
use crate::bytes::ns::Ns;
use crate::rules::finding::Finding;
use crate::rules::{Code, Measured, Quantity};
use crate::sdo::wire::Mux;

/// Maximum number of kept steps of a problem; further ones are counted.
pub const STEPS: usize = 16;
/// Maximum number of kept findings of a problem.
const FINDINGS: usize = 32;
/// Maximum number of further possible causes.
const POSSIBLE: usize = 3;

/// The internal ID of a problem: its place in the ledger, from 1. People see [`Problem::number`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ProblemId(pub u32);

/// The status of a problem at the end of the capture, in reading order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Status {
    /// Not ended, although its subject was observed until the end.
    #[default]
    Open,
    /// The capture ends before it could have ended, or its subject cannot be heard any more.
    Unknown,
    /// Ended, as shown by a frame.
    Ended,
    /// Explained by a command, the recording or the edge of the capture.
    Harmless,
}

impl Status {
    /// Returns the word used in machine output.
    pub fn name(self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::Unknown => "unknown",
            Self::Ended => "ended",
            Self::Harmless => "harmless",
        }
    }
}

/// The certainty of a statement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Grade {
    /// Nothing contradicts it.
    Possible,
    /// Known facts about the devices support it.
    Likely,
    /// The capture shows it.
    #[default]
    Certain,
}

impl Grade {
    /// Returns the word used in machine output.
    pub fn name(self) -> &'static str {
        match self {
            Self::Possible => "possible",
            Self::Likely => "likely",
            Self::Certain => "certain",
        }
    }
}

/// The role of a step in its problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepRole {
    /// A sign that something is wrong.
    Sign,
    /// A reaction of the subject.
    Reaction,
    /// An attempt to recover.
    Attempt,
    /// A sign of its end, or of nearly so.
    Recovery,
}

impl StepRole {
    /// Returns the word used in machine output.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sign => "sign",
            Self::Reaction => "reaction",
            Self::Attempt => "attempt",
            Self::Recovery => "recovery",
        }
    }
}

/// The subject of a problem. Without a node or nodes it is the bus or the capture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Subject {
    /// The node.
    pub node: Option<u8>,
    /// All nodes concerned, one bit each.
    pub nodes: u128,
    /// The axis of a drive, from 1, if it is one.
    pub axis: Option<u8>,
    /// All axes concerned, one bit each.
    pub axes: u8,
    /// A PDO of the node: true for a TPDO, and its number.
    pub pdo: Option<(bool, u16)>,
}

impl Subject {
    /// Makes a subject of one node.
    pub fn node(node: u8) -> Self {
        Self { node: Some(node), nodes: bit(node), ..Self::default() }
    }

    /// Makes a subject of a node, or else of the bus.
    pub fn of(node: Option<u8>) -> Self {
        node.map_or_else(Self::default, Self::node)
    }

    /// Makes a subject of several nodes.
    pub fn nodes(nodes: u128) -> Self {
        Self { nodes, ..Self::default() }
    }

    /// Returns true if a node is concerned.
    pub fn concerns(&self, node: u8) -> bool {
        self.nodes & bit(node) != 0
    }
}

/// Returns the bit of a node in a set of nodes.
pub fn bit(node: u8) -> u128 {
    1 << (node & 0x7F)
}

/// Iterates over the nodes of a set in ascending order.
pub fn members(nodes: u128) -> impl Iterator<Item = u8> {
    (1..=127).filter(move |node| nodes & bit(*node) != 0)
}

/// A fact of a problem at a frame.
#[derive(Clone, Copy, Debug)]
pub struct ProblemStep {
    /// The frame.
    pub at: FrameRef,
    /// Its role in the problem.
    pub role: StepRole,
    /// Its content.
    pub said: Measured,
    /// The rule that found it, if any.
    pub from: Option<Code>,
}

/// The cause of a problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Link {
    /// The causing problem.
    pub cause: ProblemId,
    /// The number of the rule in `causes`.
    pub rule: u8,
    /// Its certainty.
    pub grade: Grade,
    /// Time from the beginning of the cause to that of the consequence, in ns; `None` without stamps.
    pub delay_ns: Option<Ns>,
    /// Deviation from the expected time, in ns.
    pub(super) far_ns: Ns,
}

/// The repetitions of a problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Repeats {
    /// Number of times, including the first one.
    pub count: u64,
    /// Longest duration, in ns.
    pub longest_ns: Ns,
    /// Total duration, in ns.
    pub total_ns: Ns,
    /// The last beginning.
    pub since: FrameRef,
}

/// A finding of a problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cited {
    /// The rule.
    pub code: Code,
    /// The frame at which it was noticed.
    pub frame: FrameRef,
    /// The frame that it concerns. For something missing this is the last one before, since the frame at which it was
    /// noticed depends only on the limit. `check` places it there, too.
    pub about: FrameRef,
    /// The number of the frame that explains it, if one does.
    pub(super) because_of: Option<u64>,
}

impl Cited {
    fn of(finding: &Finding) -> Self {
        let about = finding.about().unwrap_or(finding.at);
        let because_of = finding.because_of.map(|frame| frame.no);
        Self { code: finding.code, frame: finding.at, about, because_of }
    }
}

/// A problem of one subject.
#[derive(Clone, Debug)]
pub struct Problem {
    /// Its internal ID.
    pub id: ProblemId,
    /// Its number for people, from 1 without gaps: in reading order or, if problems are reported while the capture is
    /// read, in the order of reports. 0 until it has one.
    pub number: u32,
    /// Its kind.
    pub kind: ProblemKind,
    /// The bus.
    pub bus: BusId,
    /// Its subject.
    pub subject: Subject,
    /// The first evidence: the last sign of life, or the wrong frame.
    pub begin: FrameRef,
    /// The frame at which it could be noticed.
    pub noticed: FrameRef,
    /// The frame that ended it; `None` while it is open.
    pub end: Option<FrameRef>,
    /// Its status; final at the end of the capture.
    pub status: Status,
    /// The certainty of the statement.
    pub grade: Grade,
    /// Its facts in order, at most [`STEPS`].
    pub steps: Vec<ProblemStep>,
    /// Further steps that are not kept.
    pub left_out: u32,
    /// Its measured facts by name.
    pub facts: Vec<(&'static str, Quantity)>,
    /// Its repetitions.
    pub repeats: Repeats,
    /// Its cause, if known.
    pub cause: Option<Link>,
    /// Further possible causes.
    pub possible: Vec<Link>,
    /// Its findings.
    pub findings: Vec<Cited>,
    /// The problems merged into it.
    pub parts: Vec<ProblemId>,
    /// True if it is merged into another problem and not reported by itself.
    pub(super) merged: bool,
    /// Facts for links.
    pub(super) clue: Clue,
    /// Its own status at the end, whatever follows from it.
    pub(super) alone: Status,
    /// The measurements of its first finding.
    pub(super) measured: Option<Measured>,
}

/// Facts known at the beginning of a problem that are needed to find its cause.
#[derive(Clone, Debug, Default)]
pub(super) struct Clue {
    /// Nodes that the subject monitors by 1016h, with their times in ns.
    pub(super) watched: Vec<(u8, Ns)>,
    /// Node-IDs that the vendor's bytes of its report of a loss may name, one bit each.
    pub(super) named: u128,
    /// Producers of the PDOs that the subject waits for, one bit each.
    pub(super) sources: u128,
    /// True if the command addressed all nodes.
    pub(super) everyone: bool,
    /// Nodes whose PDOs stopped as long ago as the subject waits for one, one bit each.
    pub(super) suspects: u128,
    /// True if its error register shows a communication error (bit 4).
    pub(super) communication: bool,
    /// True if the subject is a pure controller: it sends no PDO, no answers and no reports.
    pub(super) controller: bool,
    /// True if the subject produces SYNC.
    pub(super) sync_producer: bool,
    /// The last SYNC before it, and the period of SYNC in ns.
    pub(super) sync: Option<(FrameRef, Ns)>,
    /// Active error codes.
    pub(super) codes: Vec<u16>,
    /// True if a request was repeated in vain until the end.
    pub(super) not_served: bool,
    /// All error codes ever reported in it.
    pub(super) reported: Vec<u16>,
    /// The number of the frame that explains it, as given by a finding.
    pub(super) because_of: Option<u64>,
    /// Minimum number of times from which it counts.
    pub(super) least: u64,
    /// The frame by which a client shows that it does not wait for a response any longer.
    pub(super) given_up: Option<FrameRef>,
    /// True if no frame shows at the end of the capture whether it goes on.
    pub(super) unsettled: bool,
    /// True if the last frames show that it goes on.
    pub(super) lasts: bool,
    /// Lost nodes that were heard again since, one bit each.
    pub(super) back: u128,
}

impl Problem {
    /// Adds a step.
    pub fn step(&mut self, at: FrameRef, role: StepRole, said: impl Into<Measured>, from: Option<&Finding>) {
        self.add(ProblemStep { at, role, said: said.into(), from: from.map(|finding| finding.code) });
        if let Some(finding) = from {
            self.found(finding);
        }
    }

    pub(super) fn add(&mut self, step: ProblemStep) {
        let same = |other: &ProblemStep| other.at.no == step.at.no && other.said == step.said;
        if self.steps.last().is_some_and(same) {
            return;
        }
        if self.steps.len() < STEPS {
            self.steps.push(step);
        } else {
            self.left_out = self.left_out.saturating_add(1);
        }
    }

    /// Adds a finding.
    pub fn found(&mut self, finding: &Finding) {
        self.cite(Cited::of(finding));
    }

    pub(super) fn cite(&mut self, cited: Cited) {
        if self.findings.len() < FINDINGS && !self.findings.contains(&cited) {
            self.findings.push(cited);
        }
    }

    /// Sets a fact, replacing one of the same name. Values that a rule could not measure are left out.
    pub fn fact(&mut self, name: &'static str, value: Quantity) {
        if value == Quantity::Nothing {
            return;
        }
        match self.facts.iter_mut().find(|(known, _)| *known == name) {
            Some(slot) => slot.1 = value,
            None => self.facts.push((name, value)),
        }
    }

    /// Returns a fact by its name.
    pub fn get(&self, name: &str) -> Option<Quantity> {
        self.facts.iter().find(|(known, _)| *known == name).map(|(_, value)| *value)
    }

    /// Returns true if there is a fact of this name.
    pub fn has(&self, name: &str) -> bool {
        self.get(name).is_some()
    }

    /// Returns the time of this name, in ns.
    pub fn ns(&self, name: &str) -> Option<Ns> {
        match self.get(name) {
            Some(Quantity::Ns(ns)) => Some(ns),
            _ => None,
        }
    }

    /// Returns the count of this name, or 0.
    pub fn count(&self, name: &str) -> u64 {
        match self.get(name) {
            Some(Quantity::Count(count)) => count,
            _ => 0,
        }
    }

    /// Ends it with this frame.
    pub fn ends(&mut self, at: FrameRef) {
        if self.end.is_none() {
            self.end = Some(at);
            let lasted = at.since(self.repeats.since).unwrap_or(Ns::ZERO).max(Ns::ZERO);
            self.repeats.longest_ns = self.repeats.longest_ns.max(lasted);
            self.repeats.total_ns += lasted;
        }
    }

    /// Begins it again with this frame.
    pub fn again(&mut self, since: FrameRef) {
        (self.end, self.clue.back) = (None, 0);
        self.repeats.count += 1;
        self.repeats.since = since;
    }

    /// Returns true if it began, or began again, at most `ns` before a frame.
    pub fn began_within(&self, at: FrameRef, ns: Ns) -> bool {
        at.since(self.repeats.since).is_some_and(|since| (Ns::ZERO..=ns).contains(&since))
    }

    /// Returns true if it has ended, at most `ns` before a frame; or after that, if it had begun: a finding may come late.
    pub fn ended_within(&self, at: FrameRef, ns: Ns) -> bool {
        let since = self.end.and_then(|end| at.since(end));
        since.is_some_and(|since| since <= ns && (since >= Ns::ZERO || at.no >= self.begin.no))
    }

    /// Returns the time between heartbeats that come more slowly, or too late, in ns.
    pub(super) fn slow_ns(&self) -> Option<Ns> {
        ["to", "period", "found"].iter().find_map(|name| self.ns(name))
    }

    /// Returns true if all its nodes were heard again after they were lost.
    pub(super) fn is_back(&self) -> bool {
        self.end.is_some() || self.subject.nodes & !self.clue.back == 0
    }

    /// Returns true if a frame belongs to its facts.
    pub fn holds(&self, frame: u64) -> bool {
        self.begin.no == frame
            || self.noticed.no == frame
            || self.steps.iter().any(|step| step.at.no == frame)
            || self.findings.iter().any(|cited| cited.frame.no == frame)
    }

    /// Returns its effect on the machine.
    pub fn impact(&self) -> Impact {
        let unintended = self.kind.is(KindRole::Stop) && self.status == Status::Open;
        if unintended { Impact::A } else { self.kind.row().impact }
    }

    /// Returns the limit by which it follows from its cause, in ns, and the index of the object with the limit: a
    /// consumer heartbeat time.
    pub fn limit(&self, cause: &Problem) -> Option<(u16, Ns)> {
        let rule = self.cause.filter(|link| link.cause == cause.id && matches!(link.rule, 1 | 7))?;
        let watched = self.clue.watched.iter().find(|(node, _)| cause.subject.concerns(*node))?;
        (rule.delay_ns >= Some(Ns::ZERO)).then_some((0x1016, watched.1))
    }

    /// Returns the measurements of its first finding, if no tracker has a headline of its own for it.
    pub fn measured(&self) -> Option<&Measured> {
        self.measured.as_ref()
    }

    /// Returns the object of its first finding.
    pub fn object(&self) -> Option<Mux> {
        match self.get("object") {
            Some(Quantity::Object(object)) => Some(object),
            _ => None,
        }
    }

    /// Returns true if it is to be reported: it has happened often enough and is not merged. The checks report each
    /// emergency of a device, and set aside what another protocol carries.
    pub fn counts(&self) -> bool {
        let set_aside = !self.clue.reported.is_empty() && self.findings.is_empty();
        !self.merged && !set_aside && self.repeats.count >= self.clue.least
    }

    pub(super) fn link(&mut self, link: Link) {
        match self.cause {
            Some(known) if known.cause == link.cause => {
                self.cause = Some(if known.grade >= link.grade { known } else { link })
            }
            Some(known) if (known.grade, -known.far_ns) >= (link.grade, -link.far_ns) => {
                if known.cause != link.cause
                    && self.possible.len() < POSSIBLE
                    && !self.possible.iter().any(|one| one.cause == link.cause)
                {
                    self.possible.push(link);
                }
            }
            known => {
                if let Some(known) = known.filter(|_| self.possible.len() < POSSIBLE) {
                    self.possible.push(known);
                }
                self.cause = Some(link);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problems::Ledger;

    #[test]
    fn what_could_not_be_measured_is_no_fact() {
        let mut ledger = Ledger::default();
        let at = FrameRef::default();
        let place = ledger.open(ProblemKind::CaptureGap, BusId::default(), Subject::default(), at, at);
        let one = place.and_then(|place| ledger.get_mut(place)).map(|one| {
            one.fact("bytes", Quantity::Nothing);
            one.fact("frames", Quantity::Count(3));
            &one.facts
        });
        assert_eq!(one, Some(&vec![("frames", Quantity::Count(3))]));
    }
}

//! An incident: what happened to one subject, from begin to end, and what it came from.
//!
//! It is made of facts at frames. Must not: hold words of a language, or decide anything.

use super::kinds::{Impact, Kind};
use crate::finding::Finding;
use crate::frame::{BusId, FrameRef};
use crate::rules::{Code, Measured, Quantity};

/// Most steps of one incident that are kept; further ones are counted.
pub const STEPS: usize = 16;
/// Most findings of one incident that are kept.
const FINDINGS: usize = 32;
/// Most further causes that are possible, too.
const POSSIBLE: usize = 3;

/// What an incident is known by in here: its place in the ledger, from 1. People see [`Incident::number`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct IncidentId(pub u32);

/// How an incident stands at the end of the capture, in the order in which a person wants to read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Status {
    /// It has not ended, and its subject was watched until the end.
    #[default]
    Stands,
    /// The capture ends before it could have ended, or its subject cannot be heard any more.
    Unknown,
    /// Something shows that it ended.
    Over,
    /// A command, the recording or the edge of the capture explains it.
    Harmless,
}

impl Status {
    /// The word in machine output.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stands => "stands",
            Self::Unknown => "unknown",
            Self::Over => "over",
            Self::Harmless => "harmless",
        }
    }
}

/// How sure a statement is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Grade {
    /// Nothing speaks against it.
    Possible,
    /// What is known of the devices speaks for it.
    Likely,
    /// The capture shows it.
    #[default]
    Certain,
}

impl Grade {
    /// The word in machine output.
    pub fn name(self) -> &'static str {
        match self {
            Self::Possible => "possible",
            Self::Likely => "likely",
            Self::Certain => "certain",
        }
    }
}

/// What a step is to its incident.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// It shows that something is wrong.
    Sign,
    /// What the subject did because of it.
    Reaction,
    /// Somebody tried to mend it.
    Attempt,
    /// It shows that it is over, or nearly.
    Recovery,
}

impl Role {
    /// The word in machine output.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sign => "sign",
            Self::Reaction => "reaction",
            Self::Attempt => "attempt",
            Self::Recovery => "recovery",
        }
    }
}

/// To whom it happened. Neither a node nor nodes: to the bus, or to the capture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Subject {
    /// The node.
    pub node: Option<u8>,
    /// All nodes concerned, a bit each.
    pub nodes: u128,
    /// The axis of a drive, from 1, where it is one.
    pub axis: Option<u8>,
    /// All axes concerned, a bit each.
    pub axes: u8,
    /// A PDO of the node: whether it is a TPDO, and its number.
    pub pdo: Option<(bool, u16)>,
}

impl Subject {
    /// A node.
    pub fn node(node: u8) -> Self {
        Self { node: Some(node), nodes: bit(node), ..Self::default() }
    }

    /// A node where there is one, else the bus.
    pub fn of(node: Option<u8>) -> Self {
        node.map_or_else(Self::default, Self::node)
    }

    /// Several nodes.
    pub fn nodes(nodes: u128) -> Self {
        Self { nodes, ..Self::default() }
    }

    /// Whether a node is concerned.
    pub fn concerns(&self, node: u8) -> bool {
        self.nodes & bit(node) != 0
    }
}

/// The bit of a node in a set of nodes.
pub fn bit(node: u8) -> u128 {
    1 << (node & 0x7F)
}

/// The nodes of a set, ascending.
pub fn members(nodes: u128) -> impl Iterator<Item = u8> {
    (1..=127).filter(move |node| nodes & bit(*node) != 0)
}

/// A fact of an incident at a frame.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// The frame.
    pub at: FrameRef,
    /// What it is to the incident.
    pub role: Role,
    /// What it says.
    pub said: Measured,
    /// The rule that found it, if one did.
    pub from: Option<Code>,
}

/// From what an incident comes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Link {
    /// The incident that caused it.
    pub cause: IncidentId,
    /// The rule of cause, by its number in `links`.
    pub rule: u8,
    /// How sure that is.
    pub grade: Grade,
    /// From the begin of the cause to that of the consequence, in ns; `None` without stamps.
    pub delay_ns: Option<i64>,
    /// How far that is from the time that was to be expected, in ns.
    pub(super) far_ns: i64,
}

/// What happened again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Repeats {
    /// How often, the first time included.
    pub count: u64,
    /// The longest time it lasted, in ns.
    pub longest_ns: i64,
    /// All of it, in ns.
    pub total_ns: i64,
    /// When it began last.
    pub since: FrameRef,
}

/// A finding that belongs to an incident.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cited {
    /// The rule.
    pub code: Code,
    /// The frame that shows it: where it was noticed.
    pub frame: u64,
    /// The frame that it is about. Where something is missing that is the last one before, which is where whoever reads
    /// the capture looks first; where it was noticed depends on the limit alone. `check` places it there, too.
    pub about: u64,
}

impl Cited {
    fn of(finding: &Finding) -> Self {
        let frame = finding.at.no;
        Self { code: finding.code, frame, about: finding.about().map_or(frame, |about| about.no) }
    }
}

/// What happened to one subject.
#[derive(Clone, Debug)]
pub struct Incident {
    /// What it is known by.
    pub id: IncidentId,
    /// Its number for people, from 1 and without gaps: in the order of reading, or, where problems are reported while the
    /// capture is read, in the order in which they are reported. 0 as long as it was not.
    pub number: u32,
    /// What it is.
    pub kind: Kind,
    /// The bus.
    pub bus: BusId,
    /// To whom it happened.
    pub subject: Subject,
    /// The first evidence: the last sign of life, the frame that is wrong.
    pub begin: FrameRef,
    /// The frame by which it could be told.
    pub noticed: FrameRef,
    /// The frame by which it is over; `None` while it is not.
    pub end: Option<FrameRef>,
    /// How it stands; final once the capture is over.
    pub status: Status,
    /// How sure the statement is.
    pub grade: Grade,
    /// Its facts in order, at most [`STEPS`].
    pub steps: Vec<Step>,
    /// Further steps that are not kept.
    pub left_out: u32,
    /// What was measured.
    pub facts: Vec<(&'static str, Quantity)>,
    /// How often it happened.
    pub repeats: Repeats,
    /// What caused it, as far as that is known.
    pub cause: Option<Link>,
    /// What may have caused it, too.
    pub possible: Vec<Link>,
    /// The findings that belong to it.
    pub findings: Vec<Cited>,
    /// Those that turned out to be one with it.
    pub parts: Vec<IncidentId>,
    /// It is part of another incident, and not told by itself.
    pub(super) merged: bool,
    /// What links ask for.
    pub(super) clue: Clue,
}

/// What is known at the begin of an incident and needed to find its cause.
#[derive(Clone, Debug, Default)]
pub(super) struct Clue {
    /// Nodes that the subject watches by 1016h, with its times in ns.
    pub(super) watched: Vec<(u8, i64)>,
    /// Producers of the PDOs that the subject waits for.
    pub(super) sources: u128,
    /// It was commanded to all nodes.
    pub(super) everyone: bool,
    /// Nodes whose PDOs stopped as long ago as the subject waits for one, a bit each.
    pub(super) suspects: u128,
    /// Its error register says that communication failed (bit 4).
    pub(super) communication: bool,
    /// The subject only controls: it sends no PDO, answers nothing and reports nothing.
    pub(super) controller: bool,
    /// The subject produces SYNC.
    pub(super) sync_producer: bool,
    /// The last SYNC before it, and the period of SYNC in ns.
    pub(super) sync: Option<(FrameRef, i64)>,
    /// Error codes that stand.
    pub(super) codes: Vec<u16>,
    /// Error codes that were ever reported in it.
    pub(super) reported: Vec<u16>,
    /// A finding says that the frame of this number explains it.
    pub(super) because_of: Option<u64>,
    /// It counts only once it has happened so often.
    pub(super) least: u64,
}

impl Incident {
    /// Adds a step.
    pub fn step(&mut self, at: FrameRef, role: Role, said: impl Into<Measured>, from: Option<&Finding>) {
        self.add(Step { at, role, said: said.into(), from: from.map(|finding| finding.code) });
        if let Some(finding) = from {
            self.found(finding);
        }
    }

    pub(super) fn add(&mut self, step: Step) {
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

    /// Adds what was measured; what is known by this name already is replaced. What a rule could not measure is left out.
    pub fn fact(&mut self, name: &'static str, value: Quantity) {
        if value == Quantity::Nothing {
            return;
        }
        match self.facts.iter_mut().find(|(known, _)| *known == name) {
            Some(slot) => slot.1 = value,
            None => self.facts.push((name, value)),
        }
    }

    /// What was measured by this name.
    pub fn get(&self, name: &str) -> Option<Quantity> {
        self.facts.iter().find(|(known, _)| *known == name).map(|(_, value)| *value)
    }

    /// Whether anything was measured by this name.
    pub fn has(&self, name: &str) -> bool {
        self.get(name).is_some()
    }

    /// The time that was measured by this name, in ns.
    pub fn ns(&self, name: &str) -> Option<i64> {
        match self.get(name) {
            Some(Quantity::Ns(ns)) => Some(ns),
            _ => None,
        }
    }

    /// The number that was counted by this name; 0 where none was.
    pub fn count(&self, name: &str) -> u64 {
        match self.get(name) {
            Some(Quantity::Count(count)) => count,
            _ => 0,
        }
    }

    /// It is over, by this frame.
    pub fn ends(&mut self, at: FrameRef) {
        if self.end.is_none() {
            self.end = Some(at);
            let lasted = at.since(self.repeats.since).unwrap_or(0).max(0);
            self.repeats.longest_ns = self.repeats.longest_ns.max(lasted);
            self.repeats.total_ns = self.repeats.total_ns.saturating_add(lasted);
        }
    }

    /// The same happens again, since this frame.
    pub fn again(&mut self, since: FrameRef) {
        self.end = None;
        self.repeats.count += 1;
        self.repeats.since = since;
    }

    /// Whether it has begun, or begun again, at most so many ns before a frame.
    pub fn began_within(&self, at: FrameRef, ns: i64) -> bool {
        at.since(self.repeats.since).is_some_and(|since| (0..=ns).contains(&since))
    }

    /// Whether it ended at most so many ns before a frame.
    pub fn ended_within(&self, at: FrameRef, ns: i64) -> bool {
        self.end.and_then(|end| at.since(end)).is_some_and(|since| (0..=ns).contains(&since))
    }

    /// Whether a frame is one of its facts.
    pub fn holds(&self, frame: u64) -> bool {
        self.begin.no == frame
            || self.noticed.no == frame
            || self.steps.iter().any(|step| step.at.no == frame)
            || self.findings.iter().any(|cited| cited.frame == frame)
    }

    /// What it means for the machine.
    pub fn impact(&self) -> Impact {
        match (self.kind, self.status) {
            (Kind::CommandedStop, Status::Stands) => Impact::A,
            (kind, _) => kind.row().impact,
        }
    }

    /// The limit by which it follows from an incident, in ns, and the object that holds it: a consumer heartbeat time.
    pub fn limit(&self, cause: &Incident) -> Option<(u16, i64)> {
        let rule = self.cause.filter(|link| link.cause == cause.id && matches!(link.rule, 1 | 7))?;
        let watched = self.clue.watched.iter().find(|(node, _)| cause.subject.concerns(*node))?;
        (rule.delay_ns >= Some(0)).then_some((0x1016, watched.1))
    }

    /// Whether it is worth telling: it has happened often enough, or has not ended.
    pub fn counts(&self) -> bool {
        !self.merged && self.repeats.count >= self.clue.least
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
    use crate::diagnosis::Ledger;

    #[test]
    fn what_could_not_be_measured_is_no_fact() {
        let mut ledger = Ledger::default();
        let at = FrameRef::default();
        let place = ledger.open(Kind::CaptureGap, BusId::default(), Subject::default(), at, at);
        let one = place.and_then(|place| ledger.get_mut(place)).map(|one| {
            one.fact("bytes", Quantity::Nothing);
            one.fact("frames", Quantity::Count(3));
            &one.facts
        });
        assert_eq!(one, Some(&vec![("frames", Quantity::Count(3))]));
    }
}

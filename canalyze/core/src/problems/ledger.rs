//! All problems of a capture, in the order in which they were opened.
//!
//! Memory is bounded: after [`KEPT`] problems, further ones are only counted.

use std::collections::{BTreeMap, BTreeSet};

use super::kinds::ProblemKind;
use super::problem::Grade;
use super::problem::{Clue, Problem, ProblemId, Repeats, Status, Subject};
use super::roles::KindRole;
use crate::bytes::frame::{BusId, FrameRef};
use crate::bytes::ns::Ns;
use crate::rules::finding::Finding;
use crate::rules::{Code, Measured, Severity};

/// Maximum number of kept problems (invariant 6).
const KEPT: usize = 1024;
/// Number of latest problems that are searched.
const RECENT: usize = 128;

/// The place of a problem in the ledger.
pub(super) type LedgerPlace = usize;
/// Maximum time from the first sign of a second node with the same node-ID to its proof, in ns.
pub(super) const DOUBLE_NS: Ns = Ns::from_s(15);

/// All problems so far.
#[derive(Clone, Debug, Default)]
pub struct Ledger {
    pub(super) all: Vec<Problem>,
    /// Number of further ones.
    pub(super) beyond: u64,
    /// Number of findings above info by rule, consequences apart.
    found: BTreeMap<Code, u64>,
    /// Number of numbers assigned for people.
    numbered: u32,
    /// Problems with new facts since their causes were last looked up.
    pub(super) grown: Vec<LedgerPlace>,
}

impl Ledger {
    /// Opens a problem; `None` if there are too many.
    pub(super) fn open(
        &mut self,
        kind: ProblemKind,
        bus: BusId,
        subject: Subject,
        begin: FrameRef,
        noticed: FrameRef,
    ) -> Option<LedgerPlace> {
        if self.all.len() >= KEPT {
            self.beyond += 1;
            return None;
        }
        self.all.push(Problem {
            id: ProblemId(self.all.len() as u32 + 1),
            number: 0,
            kind,
            bus,
            subject,
            begin,
            noticed,
            end: None,
            status: Status::Open,
            grade: Grade::Certain,
            steps: Vec::new(),
            left_out: 0,
            facts: Vec::new(),
            repeats: Repeats { count: 1, longest_ns: Ns::ZERO, total_ns: Ns::ZERO, since: begin },
            cause: None,
            possible: Vec::new(),
            findings: Vec::new(),
            parts: Vec::new(),
            merged: false,
            clue: Clue::default(),
            alone: Status::default(),
            measured: None,
        });
        Some(self.all.len() - 1)
    }

    pub(super) fn get(&self, place: LedgerPlace) -> Option<&Problem> {
        self.all.get(place)
    }

    pub(super) fn get_mut(&mut self, place: LedgerPlace) -> Option<&mut Problem> {
        self.all.get_mut(place)
    }

    /// Returns the problem with this ID.
    pub fn by_id(&self, id: ProblemId) -> Option<&Problem> {
        self.all.get((id.0 as usize).checked_sub(1)?)
    }

    /// Returns the number of a problem for people; 0 if it has none.
    pub fn number(&self, id: ProblemId) -> u32 {
        self.by_id(id).map_or(0, |one| one.number)
    }

    /// Assigns the next numbers to problems that have none.
    pub(super) fn give_numbers(&mut self, ids: impl IntoIterator<Item = ProblemId>) {
        for id in ids {
            let place = (id.0 as usize).wrapping_sub(1);
            if let Some(one) = self.all.get_mut(place).filter(|one| one.number == 0) {
                self.numbered += 1;
                one.number = self.numbered;
            }
        }
    }

    /// Takes the numbers assigned in a copy of this ledger that has advanced further.
    pub(super) fn take_numbers(&mut self, copy: &Self) {
        for (one, other) in self.all.iter_mut().zip(&copy.all) {
            one.number = other.number;
        }
        self.numbered = self.all.iter().map(|one| one.number).max().unwrap_or(0);
    }

    /// Returns the latest problem of a bus that `fits`, among the recent ones.
    pub(super) fn last(&self, bus: BusId, fits: impl Fn(&Problem) -> bool) -> Option<LedgerPlace> {
        let recent = self.all.iter().enumerate().rev().take(RECENT);
        recent.filter(|(_, one)| one.bus == bus && !one.merged).find(|(_, one)| fits(one)).map(|(place, _)| place)
    }

    /// Returns the places of the recent problems of a bus, the latest first.
    pub(super) fn recent(&self, bus: BusId) -> Vec<LedgerPlace> {
        let recent = self.all.iter().enumerate().rev().take(RECENT);
        recent.filter(|(_, one)| one.bus == bus && !one.merged).map(|(place, _)| place).collect()
    }

    /// Iterates over a problem and its direct and indirect causes, at most [`RECENT`] in all.
    pub(super) fn causes(&self, one: ProblemId) -> impl Iterator<Item = ProblemId> {
        let cause = |id: &ProblemId| self.by_id(*id).and_then(|one| one.cause).map(|link| link.cause);
        std::iter::successors(Some(one), cause).take(RECENT)
    }

    /// Returns true if `one` is `other` or has it among its direct and indirect causes, or has too many of them.
    pub(super) fn comes_from(&self, one: ProblemId, other: ProblemId) -> bool {
        let mut count = 0;
        self.causes(one).inspect(|_| count += 1).any(|id| id == other) || count == RECENT
    }

    /// Takes back a problem that was none.
    pub(super) fn withdraw(&mut self, id: ProblemId) {
        for one in &mut self.all {
            one.merged |= one.id == id;
            one.cause = one.cause.filter(|link| link.cause != id);
            one.possible.retain(|link| link.cause != id);
        }
    }

    /// Merges a problem into another one.
    pub(super) fn merge(&mut self, place: LedgerPlace, into: LedgerPlace) {
        let Some(one) = self.all.get_mut(place).filter(|_| place != into) else { return };
        one.merged = true;
        let (gone, one) = (one.id, one.clone());
        let Some(other) = self.all.get_mut(into) else { return };
        let stays = other.id;
        other.parts.push(gone);
        other.parts.extend(&one.parts);
        if one.subject.node.is_some() {
            other.subject.nodes |= one.subject.nodes;
            if other.kind == one.kind && other.subject.nodes.count_ones() > 1 {
                other.subject.node = None;
            }
        }
        if other.kind == one.kind {
            other.end = other.end.zip(one.end).map(|(end, last)| if last.no > end.no { last } else { end });
        }
        if one.end.is_some() && other.end.is_none() && other.kind.is(KindRole::Storing) {
            other.end = one.end;
        }
        one.steps.into_iter().for_each(|step| other.add(step));
        other.steps.sort_by_key(|step| step.at.no);
        one.findings.into_iter().for_each(|cited| other.cite(cited));
        for one in &mut self.all {
            for link in one.cause.iter_mut().chain(&mut one.possible).filter(|link| link.cause == gone) {
                link.cause = stays;
            }
            if one.id == stays {
                one.cause = one.cause.filter(|link| link.cause != stays);
                one.possible.retain(|link| link.cause != stays);
            }
        }
    }

    /// Opens the problem of a node that was never heard.
    pub(super) fn absent(&mut self, bus: BusId, node: u8, begin: FrameRef, noticed: FrameRef) -> Option<LedgerPlace> {
        self.open(ProblemKind::NodeAbsent, bus, Subject::node(node), begin, noticed)
    }

    /// Opens the problem of a second device with a node-ID.
    pub(super) fn double(&mut self, bus: BusId, node: u8, begin: FrameRef, noticed: FrameRef) -> Option<LedgerPlace> {
        self.open(ProblemKind::DuplicateNodeId, bus, Subject::node(node), begin, noticed)
    }

    /// Makes a problem that of a second device with its node-ID, or merges it into that: `measured` says what shows it at
    /// a frame. The other device's boot-up belongs to it. Returns its place.
    pub(super) fn doubles(&mut self, place: LedgerPlace, at: FrameRef, measured: Option<Measured>) -> LedgerPlace {
        let Some(one) = self.all.get_mut(place) else { return place };
        let (bus, subject) = (one.bus, one.subject.node);
        let is_told = |one: &Problem| one.kind.is(KindRole::SecondDevice) && one.subject.node == subject;
        let told = self.last(bus, is_told).unwrap_or(place);
        for other in self.recent(bus).into_iter().filter(|other| *other != told) {
            let Some(one) = self.all.get(other) else { continue };
            let booted = one.kind.is(KindRole::Booted) && one.began_within(at, DOUBLE_NS);
            let begin = one.begin;
            if other == place || booted && one.subject.node == subject {
                self.merge(other, told);
                if let Some(one) = self.all.get_mut(told).filter(|one| begin.no < one.begin.no) {
                    one.begin = begin;
                }
            }
        }
        let Some(one) = self.all.get_mut(told) else { return told };
        (one.kind, one.end, one.clue.least, one.cause) = (ProblemKind::DuplicateNodeId, None, 1, None);
        one.possible.clear();
        if let Some(measured) = measured {
            one.facts = measured.facts().collect();
            (one.measured, one.repeats.count) = (Some(measured), 1);
        }
        self.grown.push(told);
        told
    }

    /// Returns the number of problems that are not kept.
    pub fn beyond(&self) -> u64 {
        self.beyond
    }

    /// Returns all reported problems by their numbers.
    pub fn numbered(&self) -> Vec<&Problem> {
        let mut told: Vec<_> = self.told().collect();
        told.sort_by_key(|one| one.number);
        told
    }

    /// Counts a finding.
    pub(super) fn count(&mut self, finding: &Finding) {
        if finding.severity() > Severity::Info {
            *self.found.entry(finding.code).or_default() += 1;
        }
    }

    /// Iterates over the rules with findings above info that no reported problem cites, with the number of findings: each
    /// of them is no problem by itself.
    pub fn loose(&self) -> impl Iterator<Item = (Code, u64)> {
        let cited: BTreeSet<Code> = self.told().flat_map(|one| &one.findings).map(|cited| cited.code).collect();
        self.found.iter().filter(move |(code, _)| !cited.contains(code)).map(|(code, count)| (*code, *count))
    }

    /// Iterates over all reported problems in the order in which they were opened.
    pub fn told(&self) -> impl Iterator<Item = &Problem> {
        self.all.iter().filter(|one| one.counts())
    }
}

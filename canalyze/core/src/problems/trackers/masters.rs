//! Two masters on one bus: NMT commands that contradict each other, and SDO clients that use one server at the same
//! time.
//!
//! A single master that stops a node to configure it writes to it before starting it again. If stops are contradicted
//! within moments, repeatedly and with nothing in between, two different masters send them.

use std::collections::BTreeMap;

use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::problems::kinds::ProblemKind;
use crate::problems::ledger::LedgerPlace;
use crate::problems::problem::{Grade, StepRole, Subject, bit, members};
use crate::problems::roles::KindRole;
use crate::problems::sayings::Saying;
use crate::problems::scene::{Last, Scene};
use crate::sdo::wire::Mux;

/// Maximum time from a stop to the start that contradicts it, in ns.
const CONTRARY_NS: Ns = Ns::from_s(2);
/// Number of contradictions for one node, this close together in ns, that show a second master.
const CONTRADICTIONS: usize = 2;
const WITHIN_NS: Ns = Ns::from_s(15);
/// Minimum time after which a client gives up and requests something else, in ns.
const SOON_NS: Ns = Ns::from_ms(50);
/// Time with only one client after which the other one is gone, in ns.
const QUIET_NS: Ns = Ns::from_s(5);
/// Maximum number of kept contradictions of a node.
const KEPT: usize = 8;

/// A command and the frame that carried it.
type CommandGiven = (u8, FrameRef);

/// The commands to one node.
#[derive(Clone, Debug, Default)]
struct Commanded {
    last: Option<CommandGiven>,
    /// Stops that were contradicted, with the starts.
    contrary: Vec<(CommandGiven, CommandGiven)>,
}

/// The commands of a bus.
#[derive(Clone, Debug, Default)]
pub(in crate::problems) struct Masters {
    /// By node; 0 for all.
    nodes: BTreeMap<u8, Commanded>,
    open: Option<LedgerPlace>,
    /// The last SDO request to each node, and the previous one if it was still unanswered.
    asked: BTreeMap<u8, (Asked, Option<Asked>)>,
    /// Number of times that requests of two clients were both answered.
    both: usize,
    /// The first of them.
    first_both: Option<FrameRef>,
    /// Their problem.
    clients: Option<LedgerPlace>,
}

/// A request: object, frame, and true once it is answered.
type Asked = (Mux, FrameRef, bool);

impl Masters {
    /// Forgets the commands of a recording behind which another one begins.
    pub(in crate::problems) fn part(&mut self) {
        self.nodes.clear();
        self.asked.clear();
    }

    /// Records a client's request for an object.
    pub(in crate::problems) fn asked(&mut self, node: u8, mux: Mux, at: FrameRef) {
        let before = self.asked.get(&node).map(|(last, _)| *last).filter(|(other, since, answered)| {
            !answered && *other != mux && at.since(*since).is_some_and(|since| (Ns::ZERO..=SOON_NS).contains(&since))
        });
        self.asked.insert(node, ((mux, at, false), before));
    }

    /// Records an answer; if two overlapping requests for different objects are both answered, there are two clients.
    pub(in crate::problems) fn answered(&mut self, node: u8, mux: Mux, scene: &mut Scene<'_>) {
        let Some((last, before)) = self.asked.get_mut(&node) else { return };
        let Some((first, begin, answered)) = before else {
            last.2 = true;
            return;
        };
        if *first == mux {
            *answered = true;
        } else if last.0 == mux {
            last.2 = true;
        }
        if !*answered || !last.2 {
            return;
        }
        let (begin, object, at) = (*begin, last.0, last.1);
        *before = None;
        self.both += 1;
        let begin = *self.first_both.get_or_insert(begin);
        if self.both < CONTRADICTIONS && self.open.is_none() {
            return;
        }
        let kind = ProblemKind::TwoClients;
        // Requests that are listed late overlap, too; a client that waits for its responses then has no finding.
        let found = scene.ledger.last(scene.id, |one| {
            let asked = one.kind.is(KindRole::Service);
            (asked || one.kind == kind) && one.subject.node == Some(node)
        });
        if found.is_none() && self.open.is_none() {
            return;
        }
        let known = scene.ledger.last(scene.id, |one| one.kind == kind && one.subject.node == Some(node));
        let place =
            self.open.or(known).or_else(|| scene.ledger.open(kind, scene.id, Subject::node(node), begin, scene.at));
        if let Some(one) = place.and_then(|place| scene.ledger.get_mut(place)) {
            one.subject.nodes |= bit(node);
            one.step(at, StepRole::Sign, Saying::SameTime { object }, None);
            if one.kind == kind {
                one.repeats.count = self.both as u64;
                self.clients = place;
            }
            one.repeats.since = scene.at;
        }
        // Both were answered after all.
        let unanswered = scene.ledger.last(scene.id, |one| {
            let asked = one.kind.is(KindRole::Service);
            asked && one.subject.node == Some(node) && one.began_within(scene.at, CONTRARY_NS)
        });
        if let (Some(place), Some(unanswered)) = (place, unanswered) {
            scene.ledger.merge(unanswered, place);
        }
    }

    /// Processes an NMT command to a node or to all (0).
    pub(in crate::problems) fn commanded(&mut self, command: u8, node: u8, scene: &mut Scene<'_>) {
        let at = scene.at;
        let one = self.nodes.entry(node).or_default();
        let Some(stop) =
            one.last.replace((command, at)).filter(|(last, _)| command == 0x01 && matches!(last, 0x02 | 0x80))
        else {
            return;
        };
        let soon = at.since(stop.1).is_some_and(|since| (Ns::ZERO..=CONTRARY_NS).contains(&since));
        let told = |node: u8| scene.heard.noted(Last::Written, node).is_some_and(|written| written.no > stop.1.no);
        let for_a_reason = if node == 0 { members(scene.heard.known).any(told) } else { told(node) };
        if !soon || for_a_reason {
            return;
        }
        one.contrary
            .retain(|(_, (_, start))| at.since(*start).is_some_and(|since| (Ns::ZERO..=WITHIN_NS).contains(&since)));
        if one.contrary.len() < KEPT {
            one.contrary.push((stop, (command, at)));
        }
        if one.contrary.len() < CONTRADICTIONS {
            return;
        }
        let told = match self.open {
            Some(_) => one.contrary.len() - 1,
            None => 0,
        };
        let Some((first, _)) = one.contrary.first().copied() else { return };
        let nodes = if node == 0 { scene.heard.known } else { bit(node) };
        let place = self
            .open
            .or_else(|| scene.ledger.open(ProblemKind::TwoMasters, scene.id, Subject::nodes(nodes), first.1, at));
        self.open = place;
        let Some(problem) = place.and_then(|place| scene.ledger.get_mut(place)) else { return };
        problem.grade = Grade::Likely;
        problem.subject.nodes |= nodes;
        problem.repeats.count = problem.repeats.count.max(one.contrary.len() as u64);
        problem.repeats.since = at;
        for (command, at) in one.contrary.iter().skip(told).flat_map(|(stop, start)| [*stop, *start]) {
            problem.step(at, StepRole::Sign, Saying::Commanded { command }, None);
        }
    }

    /// Ends problems at the end of the capture without a recent contradiction.
    pub(in crate::problems) fn finish(&mut self, scene: &mut Scene<'_>) {
        if let Some(one) = self.clients.take().and_then(|place| scene.ledger.get_mut(place)) {
            let last = one.repeats.since;
            if scene.at.since(last).is_some_and(|rest| rest > QUIET_NS) {
                one.ends(last);
            }
        }
        if let Some(one) = self.open.take().and_then(|place| scene.ledger.get_mut(place)) {
            let last = one.repeats.since;
            if scene.at.since(last).is_some_and(|rest| rest > CONTRARY_NS) {
                one.ends(last);
            }
        }
    }
}

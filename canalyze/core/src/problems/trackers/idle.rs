//! Nodes that are there and do not run at the end of the capture: they report Pre-operational or Stopped while others are
//! Operational, or have booted by themselves and were not started again.
//!
//! An NMT command that leads there is intended, and so is a state in which a node is being written to. Without any command in
//! the capture nobody says that the node should run: its status is unknown then. A node with another open problem has that
//! one alone. The steps of a master before it starts a node are followed in `boots`.

use std::collections::BTreeMap;

use super::boots::WAITING_NS;
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::problems::kinds::{Impact, ProblemKind};
use crate::problems::problem::{Grade, Problem, StepRole, Subject, bit, members};
use crate::problems::sayings::Saying;
use crate::problems::scene::{Last, Scene};
use crate::rules::finding::Quantity;
use crate::wire::error_control::{OPERATIONAL, PRE_OPERATIONAL, STOPPED};
use crate::wire::nmt::START;

/// Maximum time between two reports that counts, in ns: the recording may have paused.
const BETWEEN_NS: Ns = Ns::from_s(1);

/// A node, as far as the capture shows whether it should run.
#[derive(Clone, Copy, Debug, Default)]
struct Idle {
    /// The state reported last, and the first frame that reported it.
    state: Option<(u8, FrameRef)>,
    /// The last report, and the time that is covered by reports of that state, in ns.
    last: FrameRef,
    lasts_ns: Ns,
    /// The last NMT command to it while it was known, and its frame.
    command: Option<(u8, FrameRef)>,
    /// Its last boot-up, and true if it was Operational before.
    booted: Option<(FrameRef, bool)>,
}

/// The nodes of a bus by their states.
#[derive(Clone, Debug, Default)]
pub(in crate::problems) struct IdleNodes {
    nodes: BTreeMap<u8, Idle>,
    /// True once the NMT master has started a node.
    starts: bool,
}

impl IdleNodes {
    /// Records a boot-up; `was`: the node was Operational before it.
    pub(in crate::problems) fn booted(&mut self, node: u8, was: bool, at: FrameRef) {
        let one = self.nodes.entry(node).or_default();
        // It may boot several times before it is started.
        let was = was || one.booted.is_some_and(|(_, was)| was);
        (one.state, one.booted) = (None, Some((at, was)));
    }

    /// Records a state that a node reports.
    #[inline]
    pub(in crate::problems) fn reports(&mut self, node: u8, state: u8, at: FrameRef) {
        let one = self.nodes.entry(node).or_default();
        if one.state.is_none_or(|(before, _)| before != state) {
            (one.state, one.lasts_ns) = (Some((state, at)), Ns::ZERO);
        } else {
            one.lasts_ns += at.since(one.last).unwrap_or(Ns::ZERO).clamp(Ns::ZERO, BETWEEN_NS);
        }
        one.last = at;
        if state == OPERATIONAL {
            one.booted = None;
        }
    }

    /// Forgets the state of a node that is lost.
    pub(in crate::problems) fn lost(&mut self, node: u8) {
        self.nodes.get_mut(&node).into_iter().for_each(|one| one.state = None);
    }

    /// Records an NMT command to known nodes, one bit each.
    pub(in crate::problems) fn commanded(&mut self, command: u8, nodes: u128, at: FrameRef) {
        self.starts |= command == START;
        for node in members(nodes) {
            let one = self.nodes.entry(node).or_default();
            one.command = Some((command, at));
            if command != START {
                one.booted = None;
            }
        }
    }

    /// Reports the nodes that do not run at the end of the capture.
    pub(in crate::problems) fn finish(&self, scene: &mut Scene<'_>) {
        let runs = |(_, one): &(&u8, &Idle)| one.state.is_some_and(|(state, _)| state == OPERATIONAL);
        let running = self.nodes.iter().filter(runs).fold(0, |all, (node, _)| all | bit(*node));
        let mut fallen = 0;
        let mut first = None;
        for (&node, one) in &self.nodes {
            let Some((state @ (STOPPED | PRE_OPERATIONAL), since)) = one.state else { continue };
            let others = running & scene.heard.serving & !bit(node) != 0;
            let fell = one.booted.filter(|(boot, was)| *was && one.command.is_none_or(|(_, at)| at.no < boot.no));
            let wanted = one.command.is_some_and(|(command, _)| command != START);
            let long = one.lasts_ns >= WAITING_NS;
            if wanted || !long || !(others || fell.is_some()) || !waits(node, scene) {
                continue;
            }
            if let Some((boot, _)) = fell {
                fallen |= bit(node);
                first = first.or(Some(boot));
                continue;
            }
            let begin = one.booted.map_or(since, |(boot, _)| boot);
            let ignores = one.command.is_some_and(|(_, at)| at.no > since.no);
            // The master sends heartbeats, too, and need not obey itself.
            let sure = one.booted.is_some() && self.starts && (one.command.is_none() || !scene.heard.is_beating(node));
            self.open(Subject::node(node), begin, (state, sure, ignores), scene);
        }
        if let Some(begin) = first {
            self.open(Subject::nodes(fallen), begin, (PRE_OPERATIONAL, true, false), scene);
        }
    }

    fn open(&self, subject: Subject, begin: FrameRef, (state, sure, ignores): (u8, bool, bool), scene: &mut Scene<'_>) {
        let place = scene.ledger.open(ProblemKind::NotRunning, scene.id, subject, begin, scene.at);
        let Some(one) = place.and_then(|place| scene.ledger.get_mut(place)) else { return };
        one.grade = Grade::Likely;
        one.fact("state", Quantity::State(state));
        one.clue.unsettled = !sure;
        if self.nodes.values().any(|one| one.booted.is_some_and(|(boot, _)| boot.no == begin.no)) {
            one.fact("boot_up", Quantity::Count(1));
            one.step(begin, StepRole::Sign, Saying::Booted, None);
        }
        if ignores {
            one.fact("command", Quantity::Command(START));
        }
    }
}

/// Returns true if a node is still heard, and neither written to nor in another problem that keeps a node from running.
fn waits(node: u8, scene: &Scene<'_>) -> bool {
    let age = |at: Option<FrameRef>| at.and_then(|at| scene.at.since(at)).unwrap_or(Ns::MAX);
    let here = (scene.bus.heartbeat_period(node).unwrap_or(Ns::ZERO) * 2).max(WAITING_NS / 2);
    let keeps = |one: &Problem| one.impact() < Impact::C || !one.clue.reported.is_empty();
    let of_node = |one: &&Problem| one.bus == scene.id && one.subject.concerns(node) && one.end.is_none();
    let told = scene.ledger.all.iter().filter(of_node).any(keeps);
    !told && age(scene.heard.last(node)) <= here && age(scene.heard.noted(Last::Written, node)) > WAITING_NS
}

//! Nodes that restart or leave Operational without a command.
//!
//! `checks/nmt` decides if there was a command.

use super::NodeProblems;
use super::losses::lost_with;
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::problems::kinds::ProblemKind;
use crate::problems::ledger::LedgerPlace;
use crate::problems::problem::{Problem, StepRole, Subject, bit, members};
use crate::problems::roles::KindRole;
use crate::problems::sayings::Saying;
use crate::problems::scene::Scene;
use crate::problems::trackers::AGAIN_NS;
use crate::rules::finding::{Finding, Quantity};
use crate::wire::error_control::OPERATIONAL;

/// Maximum time from an emergency to a change of state caused by it, in ns.
const REACTION_NS: Ns = Ns::from_s(2);
/// Number of boot-ups without a command that are a loop.
pub(in crate::problems) const LOOP: u64 = 3;
/// Maximum distance of boot-ups of nodes that were lost together, in ns.
const BACK_NS: Ns = Ns::from_s(1);

/// Nodes that were Operational and have booted at about the same time: one bit each, and those that still do not run.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Together {
    begin: FrameRef,
    last: FrameRef,
    nodes: u128,
    idle: u128,
}

impl Together {
    /// Records a boot-up; `fell`: the node was Operational before it, and nothing but its supply explains it.
    pub(super) fn booted(&mut self, node: u8, fell: bool, at: FrameRef) {
        if at.since(self.last).is_none_or(|since| since > BACK_NS) {
            *self = Self { begin: at, ..Self::default() };
        }
        if fell {
            (self.last, self.nodes, self.idle) = (at, self.nodes | bit(node), self.idle | bit(node));
        }
    }

    /// Returns true if a node of the group does not run again.
    pub(super) fn waits_for(&self, node: u8) -> bool {
        self.idle & bit(node) != 0
    }
}

impl NodeProblems {
    /// Records that a node is Operational. If it is the last of several that have booted together, that is reported
    /// unless it was: no rule blames nodes that all boot, since the network was switched off. A capture without the command that has
    /// started them lacks resets as well.
    pub(super) fn runs_again(&mut self, node: u8, scene: &mut Scene<'_>) {
        if !self.together.waits_for(node) {
            return;
        }
        self.together.idle &= !bit(node);
        if self.waiting.contains_key(&node) {
            self.together.nodes &= !bit(node);
        }
        let Together { last, nodes, idle, .. } = self.together;
        if idle == 0 && nodes.count_ones() > 1 && self.is_ordered(nodes, last) {
            self.tell_restart(scene);
        }
    }

    /// The same of nodes that do not run until the end of the capture, and are in no other problem.
    pub(in crate::problems) fn restarted_last(&mut self, scene: &mut Scene<'_>) {
        let open = scene.ledger.all.iter().filter(|one| one.bus == scene.id && one.end.is_none());
        self.together.nodes &= !open.fold(0, |all, one| all | one.subject.nodes);
        let Together { nodes, idle, .. } = self.together;
        if idle & nodes != 0 && nodes.count_ones() > 1 && self.is_ordered(nodes, FrameRef::default()) {
            self.tell_restart(scene);
        }
    }

    /// Returns true if a start command to one of these nodes, or to all, is recorded behind a frame.
    fn is_ordered(&self, nodes: u128, behind: FrameRef) -> bool {
        let meant = |node: u8| node == 0 || nodes & bit(node) != 0;
        self.ordered.iter().any(|(node, order)| meant(*node) && order.no > behind.no)
    }

    fn tell_restart(&self, scene: &mut Scene<'_>) {
        let Together { begin, last, nodes, idle } = self.together;
        let near = |one: &Problem| begin.since(one.begin).is_some_and(|since| since.abs() <= BACK_NS);
        let told = scene.ledger.last(scene.id, |one| one.kind.is(KindRole::Restart) && near(one));
        if let Some(one) = told.and_then(|place| scene.ledger.get_mut(place)) {
            (one.subject.nodes, one.subject.node) = (one.subject.nodes | nodes, None);
            return;
        }
        let subject = Subject::nodes(nodes);
        let place = scene.ledger.open(ProblemKind::NodeRestarted, scene.id, subject, begin, last);
        if let Some(one) = place.and_then(|place| scene.ledger.get_mut(place)) {
            one.step(begin, StepRole::Sign, Saying::BootedUnasked, None);
            if idle == 0 {
                one.step(scene.at, StepRole::Recovery, Saying::OperationalAgain, None);
                one.ends(scene.at);
            }
        }
    }

    /// Reports the boot-ups of the only node in a capture, at its end, if they follow each other like problems that return: neither a
    /// rule nor a command explains them. A node that is there for as long since the last one is up.
    pub(in crate::problems) fn boots_alone(
        &self,
        (node, count, [begin, last]): (u8, u64, [FrameRef; 2]),
        scene: &mut Scene<'_>,
    ) {
        let boots = |one: &Problem| one.kind.is(KindRole::Booted) || one.has("boot_up");
        let told = scene.ledger.last(scene.id, |one| one.subject.concerns(node) && boots(one)).is_some();
        let mean = last.since(begin).map(|all| all / count.saturating_sub(1).max(1) as i64);
        if told || mean.is_some_and(|mean| mean > AGAIN_NS) {
            return;
        }
        let place = scene.ledger.open(ProblemKind::RestartLoop, scene.id, Subject::node(node), begin, last);
        if let Some(one) = place.and_then(|place| scene.ledger.get_mut(place)) {
            (one.repeats.count, one.repeats.since) = (count, last);
            one.fact("alone", Quantity::Count(1));
            one.step(begin, StepRole::Sign, Saying::Booted, None);
            one.step(last, StepRole::Sign, Saying::Booted, None);
            if scene.at.since(last).is_some_and(|up| up > AGAIN_NS) {
                one.ends(last);
            }
        }
    }

    /// Records a boot-up without a command (NMT003).
    pub(in crate::problems) fn restarted(&mut self, node: u8, finding: &Finding, was: bool, scene: &mut Scene<'_>) {
        let at = finding.at;
        if let Some(place) = self.waiting.get(&node).and_then(|places| places.last()).copied()
            && let Some(one) = scene.ledger.get_mut(place)
            && one.kind.is(KindRole::Outage)
        {
            let back = self.returned.get(&node) == Some(&at.no);
            if !back {
                one.again(at);
                one.step(at, StepRole::Sign, Saying::BootedUnasked, Some(finding));
            }
            if one.repeats.count >= LOOP && one.kind.is(KindRole::MayLoop) {
                one.kind = ProblemKind::RestartLoop;
            }
            return one.found(finding);
        }
        let back = self.returned.get(&node) == Some(&at.no);
        let silent = scene.ledger.last(scene.id, |one| {
            let ended = one.kind.is(KindRole::AloneSilent) && one.end.is_some_and(|end| end.no == at.no);
            let loops = one.kind.is(KindRole::Restart) || one.kind.is(KindRole::Loop);
            one.subject.concerns(node) && (ended || back && loops)
        });
        if let Some(one) = silent.and_then(|place| scene.ledger.get_mut(place)) {
            if one.repeats.count >= LOOP {
                one.kind = ProblemKind::RestartLoop;
            }
            return one.found(finding);
        }
        if self.comes_with_others(node, finding, scene) {
            return;
        }
        if self.restarts_with_others(node, finding, was, scene) {
            return;
        }
        // It was the boot-up of the other device.
        let double =
            scene.ledger.last(scene.id, |one| one.kind.is(KindRole::SecondDevice) && one.subject.node == Some(node));
        if let Some(one) = double.filter(|_| finding.because_of.is_some()).and_then(|place| scene.ledger.get_mut(place))
        {
            one.begin = if at.no < one.begin.no { at } else { one.begin };
            return one.step(at, StepRole::Sign, Saying::BootedUnasked, Some(finding));
        }
        let again = scene.ledger.last(scene.id, |one| one.subject.node == Some(node) && one.kind.is(KindRole::Booted));
        let again = again.filter(|place| scene.ledger.get(*place).is_some_and(|one| one.ended_within(at, AGAIN_NS)));
        let place = match again {
            Some(place) => {
                if let Some(one) = scene.ledger.get_mut(place) {
                    one.again(at);
                    if one.repeats.count >= LOOP {
                        one.kind = ProblemKind::RestartLoop;
                    }
                }
                Some(place)
            }
            None => scene.ledger.open(ProblemKind::NodeRestarted, scene.id, Subject::node(node), at, at),
        };
        let Some(place) = place else { return };
        if let Some(one) = scene.ledger.get_mut(place) {
            one.step(at, StepRole::Sign, Saying::BootedUnasked, Some(finding));
            one.clue.because_of = finding.because_of.map(|at| at.no);
            // The finding may come after the node has started itself.
            let started = scene.heard.is_operational(node).then(|| scene.heard.last_heartbeat(node)).flatten();
            match started.filter(|started| started.no > at.no) {
                Some(started) if was => {
                    one.step(started, StepRole::Recovery, Saying::OperationalAgain, None);
                    one.ends(started);
                    return;
                }
                _ if !was => one.ends(at),
                _ => {}
            }
        }
        if was {
            self.wait(node, place);
        }
    }

    /// Adds a boot-up to the loss of other nodes that boot together: a node with so few frames that it was not missed
    /// was lost with them.
    fn comes_with_others(&mut self, node: u8, finding: &Finding, scene: &mut Scene<'_>) -> bool {
        let (at, Some(before)) = (finding.at, self.before.get(&node).copied()) else { return false };
        let others = scene.ledger.last(scene.id, |one| {
            let lost = one.kind.is(KindRole::Silent) && one.has("boot_up");
            let back = members(one.subject.nodes).filter_map(|other| self.booted.get(&other));
            let near = back.into_iter().any(|other| at.since(*other).is_some_and(|ns| ns.abs() <= BACK_NS));
            // Its last frame is older than the loss, or came while the others were being lost.
            let period = one.ns("period").unwrap_or(Ns::ZERO);
            lost && near && before.since(one.begin).is_some_and(|since| since <= period)
        });
        let Some(one) = others.and_then(|place| scene.ledger.get_mut(place)) else { return false };
        lost_with(one, node);
        one.clue.back |= bit(node);
        one.step(at, StepRole::Recovery, Saying::BootedUnasked, Some(finding));
        true
    }

    /// Adds a boot-up to that of other nodes at the same time: one supply, or one unseen command.
    fn restarts_with_others(&mut self, node: u8, finding: &Finding, was: bool, scene: &mut Scene<'_>) -> bool {
        let at = finding.at;
        let others = scene.ledger.last(scene.id, |one| {
            let near = at.since(one.begin).is_some_and(|since| since.abs() <= BACK_NS);
            let several = !one.subject.concerns(node) || one.subject.node.is_none();
            one.kind.is(KindRole::Restart) && one.repeats.count == 1 && near && several
        });
        let Some(one) = others.and_then(|place| scene.ledger.get_mut(place)) else { return false };
        if one.subject.concerns(node) {
            one.found(finding);
            return true;
        }
        (one.subject.nodes, one.subject.node) = (one.subject.nodes | bit(node), None);
        one.step(at, StepRole::Sign, Saying::BootedUnasked, Some(finding));
        if let Some(place) = others.filter(|_| was && !scene.heard.is_operational(node)) {
            one.end = None;
            self.wait(node, place);
        }
        true
    }

    /// Records a change of state without a command (NMT004, NMT005).
    pub(in crate::problems) fn changed(&mut self, node: u8, finding: &Finding, scene: &mut Scene<'_>) {
        let Some(measured) = finding.measured() else { return };
        let (Some(Quantity::State(from)), Some(Quantity::State(to))) = (measured.get("from"), measured.get("to"))
        else {
            return;
        };
        if from != OPERATIONAL {
            return;
        }
        let at = finding.about().unwrap_or(finding.at);
        let trouble = scene.ledger.last(scene.id, |one| {
            // It could hear no node while it could not be heard. Others of its segment may still be away.
            let lost = one.kind.is(KindRole::Silent) && (one.end.is_none() || one.ended_within(at, REACTION_NS));
            lost && one.subject.concerns(node)
        });
        let trouble = trouble.or_else(|| {
            scene.ledger.last(scene.id, |one| {
                one.subject.node == Some(node)
                    && !one.clue.reported.is_empty()
                    && at.since(one.repeats.since).is_none_or(|since| since.abs() <= REACTION_NS)
            })
        });
        let trouble = trouble.or_else(|| self.left_again(node, at, scene));
        // A controller that stops all others stops as well.
        let trouble = trouble.or_else(|| {
            scene.ledger.last(scene.id, |one| {
                let ordered = one.kind.is(KindRole::Commanded);
                let others = ordered && one.clue.everyone && scene.heard.serving & bit(node) == 0;
                others && one.began_within(at, REACTION_NS)
            })
        });
        let place = trouble.or_else(|| {
            let place =
                scene.ledger.open(ProblemKind::LeftOperational, scene.id, Subject::node(node), at, finding.at)?;
            scene.ledger.get_mut(place)?.fact("state", Quantity::State(to));
            Some(place)
        });
        let Some(place) = place else { return };
        if let Some(one) = scene.ledger.get_mut(place) {
            one.step(at, StepRole::Reaction, Saying::Went { from, to }, Some(finding));
            one.fact("left_operational", Quantity::Count(1));
            if one.clue.because_of.is_none() {
                one.clue.because_of = finding.because_of.map(|at| at.no);
            }
            one.end = None;
        }
        scene.ledger.grown.push(place);
        // The finding may come after the node is Operational again.
        let back = scene.heard.is_operational(node).then(|| scene.heard.last_heartbeat(node)).flatten();
        match back.filter(|back| back.no > at.no) {
            Some(back) if !self.waiting.values().flatten().any(|other| *other == place) => {
                self.close(place, back, Saying::OperationalAgain, scene);
            }
            _ => self.wait(node, place),
        }
    }

    /// Returns the recent problem of the same node leaving Operational. If it became Operational in between without a
    /// command, and repeatedly so, two nodes share the node-ID.
    fn left_again(&mut self, node: u8, at: FrameRef, scene: &mut Scene<'_>) -> Option<LedgerPlace> {
        let place = scene.ledger.last(scene.id, |one| {
            let left = one.kind.is(KindRole::StateUnasked);
            left && one.subject.node == Some(node) && (one.end.is_none() || one.ended_within(at, AGAIN_NS))
        })?;
        let since = scene.ledger.get(place)?.repeats.since;
        let ordered = [node, 0].into_iter().filter_map(|key| self.ordered.get(&key)).any(|order| order.no > since.no);
        let one = scene.ledger.get_mut(place)?;
        one.again(at);
        if one.repeats.count < LOOP || ordered {
            return Some(place);
        }
        Some(scene.ledger.doubles(place, at, None))
    }
}

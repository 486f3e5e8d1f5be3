//! Commands to nodes by NMT and RPDOs, and their outcome.
//!
//! `checks/nmt` decides if a command had no effect.

use super::{IgnoredRpdos, NodeProblems};
use crate::bytes::ns::Ns;
use crate::problems::kinds::ProblemKind;
use crate::problems::problem::{StepRole, Subject, bit, members};
use crate::problems::roles::KindRole;
use crate::problems::sayings::Saying;
use crate::problems::scene::Scene;
use crate::problems::trackers::AGAIN_NS;
use crate::problems::trackers::commanded::Commanded;
use crate::problems::trackers::rules::constant;
use crate::rules::finding::{Code, Finding, Quantity};

/// Number of RPDOs to a node that is not Operational beyond the start of a controller.
const COMMANDS: u64 = 50;
/// The same at the end of the capture, and the time from the first to the last of them in ns.
const FEW: u64 = 5;
const WAITS_NS: Ns = Ns::from_ms(1_500);
/// Maximum distance of resets that are one restart of the plant, in ns.
const ONE_RESET_NS: Ns = Ns::from_s(3);

impl NodeProblems {
    /// Processes an NMT command to a node or to all (0); `before`: the nodes that were Operational until now.
    pub(in crate::problems) fn commanded(&mut self, command: u8, node: u8, before: u128, scene: &mut Scene<'_>) {
        let meant = if node == 0 { scene.heard.known } else { bit(node) & scene.heard.known };
        let hit = meant & before;
        if hit != 0 && command != 0x01 {
            let at = scene.at;
            let kind =
                if matches!(command, 0x81 | 0x82) { ProblemKind::CommandedReset } else { ProblemKind::CommandedStop };
            let place = match &mut self.commanded {
                Some(commanded)
                    if scene.ledger.get(commanded.place).is_some_and(|one| one.began_within(at, ONE_RESET_NS)) =>
                {
                    commanded.hits(hit);
                    Some(commanded.place)
                }
                _ => {
                    let place = scene.ledger.open(kind, scene.id, Subject::nodes(hit), at, at);
                    self.commanded = place.map(|place| Commanded::new(place, hit));
                    place
                }
            };
            if let Some(one) = place.and_then(|place| scene.ledger.get_mut(place)) {
                one.subject.nodes |= hit;
                if kind.is(KindRole::Reset) {
                    one.kind = kind;
                }
                one.clue.everyone |= node == 0;
                one.fact("command", Quantity::Command(command));
                one.step(at, StepRole::Sign, Saying::Commanded { command }, None);
            }
        }
        if command == 0x01 {
            self.ordered.insert(node, scene.at);
        }
        for node in members(meant & !before).filter(|_| command == 0x01) {
            self.started.entry(node).or_insert(scene.at);
        }
        if let (0x01, Some(commanded)) = (command, &self.commanded)
            && commanded.waits_only_for(meant)
            && let Some(one) = scene.ledger.get_mut(commanded.place)
        {
            one.fact("started_again", Quantity::Count(scene.at.listed().no));
        }
        if matches!(command, 0x81 | 0x82) {
            self.was_operational &= !meant;
        }
        let at = scene.at;
        for node in members(meant) {
            for place in self.waiting.get(&node).into_iter().flatten() {
                if let Some(one) = scene.ledger.get_mut(*place) {
                    one.step(at, StepRole::Attempt, Saying::Commanded { command }, None);
                }
            }
        }
    }

    /// Processes an RPDO to a node; `taken`: the node is Operational as far as known.
    #[inline]
    pub(in crate::problems) fn controlled(&mut self, node: u8, taken: bool, scene: &mut Scene<'_>) {
        if taken {
            if !self.ignored.is_empty()
                && let Some(place) = self.ignored.remove(&node).and_then(|ignored| ignored.place)
            {
                self.close(place, scene.at, Saying::OperationalAgain, scene);
            }
            return;
        }
        let at = scene.at;
        let ignored = self.ignored.entry(node).or_insert(IgnoredRpdos { first: at, last: at, count: 0, place: None });
        (ignored.last, ignored.count) = (at, ignored.count + 1);
        if ignored.count == COMMANDS {
            let kind = ProblemKind::CommandsNotTaken;
            ignored.place = scene.ledger.open(kind, scene.id, Subject::node(node), ignored.first, at);
        }
    }

    /// Records RPDOs to nodes that have not been started until the end of the capture.
    pub(in crate::problems) fn never_started(&self, scene: &mut Scene<'_>) {
        for (node, IgnoredRpdos { first, last, count, place }) in self.ignored.iter().map(|(node, one)| (*node, *one)) {
            let long = last.since(first).is_some_and(|since| since >= WAITS_NS);
            if place.is_some() || count < FEW || !long {
                continue;
            }
            let kind = ProblemKind::CommandsNotTaken;
            let place = scene.ledger.open(kind, scene.id, Subject::node(node), first, scene.at);
            if let Some(one) = place.and_then(|place| scene.ledger.get_mut(place)) {
                // The controller may be about to start it.
                one.clue.unsettled = true;
            }
        }
    }

    /// Records a command without effect (NMT002) or a missing boot-up (NMT006).
    pub(in crate::problems) fn owes(&mut self, node: u8, finding: &Finding, scene: &mut Scene<'_>) {
        let kind = if finding.code == Code::Nmt006 { ProblemKind::NoBootUp } else { ProblemKind::StartWithoutEffect };
        let mut begin = finding.cause.unwrap_or(finding.at);
        if kind.is(KindRole::IgnoresCommand)
            && finding.measured().and_then(|all| all.get("command")) == Some(Quantity::Command(0x01))
            && let Some(first) = self.started.get(&node).filter(|_| !self.owing.contains_key(&node))
        {
            begin = *first;
        }
        // Further attempts of the master belong to the same problem.
        if let Some(one) = self.owing.get(&node).and_then(|place| scene.ledger.get_mut(*place))
            && one.kind == kind
        {
            one.again(begin);
            if let Some(Quantity::Command(command)) = finding.measured().and_then(|all| all.get("command")) {
                one.step(begin, StepRole::Attempt, Saying::Commanded { command }, Some(finding));
            }
            return;
        }
        let again = scene.ledger.last(scene.id, |one| {
            one.kind == kind && one.subject.node == Some(node) && one.ended_within(begin, AGAIN_NS)
        });
        if let Some(place) = again
            && let Some(one) = scene.ledger.get_mut(place)
        {
            one.again(begin);
            one.found(finding);
            self.owing.insert(node, place);
            return;
        }
        let Some(place) = scene.ledger.open(kind, scene.id, Subject::node(node), begin, finding.at) else { return };
        if let Some(one) = scene.ledger.get_mut(place) {
            one.clue.because_of = finding.because_of.map(|at| at.no);
            one.clue.unsettled = constant(finding, "sender").is_some();
            if let Some(command) = finding.measured().and_then(|all| all.get("command")) {
                one.fact("command", command);
                if let Quantity::Command(command) = command {
                    one.step(begin, StepRole::Sign, Saying::Commanded { command }, Some(finding));
                }
            }
        }
        self.owing.insert(node, place);
    }
}

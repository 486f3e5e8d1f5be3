//! Nodes that are lost, restart, leave Operational or are commanded to: who was heard, and what it did then.
//!
//! A silence begins with the last frame of the node, not with the moment at which it is noticed. It ends when the node is
//! heard again; where that is a boot-up of a node that was Operational, when it is Operational again. Must not: decide
//! when a heartbeat is overdue (`checks/heartbeat` does).

use std::collections::BTreeMap;

use super::AGAIN_NS;
use super::commanded::Commanded;
use crate::diagnosis::incident::{Grade, Incident, Role, Subject, bit, members};
use crate::diagnosis::kinds::Kind;
use crate::diagnosis::ledger::Place;
use crate::diagnosis::sayings::Saying;
use crate::diagnosis::scene::Scene;
use crate::finding::{Code, Finding, Quantity};
use crate::frame::FrameRef;
use crate::services::heartbeat::OPERATIONAL;

/// Nodes that fall silent within this time of each other, in ns, have one cause.
const TOGETHER_NS: i64 = 100_000_000;
/// A state that is left within this time of an emergency, in ns, is left because of it.
const REACTION_NS: i64 = 2_000_000_000;
/// Boot-ups without a command from which on they are a loop.
const LOOP: u64 = 3;
/// A node of which nothing was heard for so long may be the one that a consumer misses, in ns.
const UNHEARD_NS: i64 = 400_000_000;
/// Boot-ups of nodes that were lost together come within this time, in ns.
const BACK_NS: i64 = 1_000_000_000;
/// What a second node with a node-ID shows comes within this time, in ns.
const DOUBLE_NS: i64 = 15_000_000_000;
/// RPDOs to a node that is not Operational that are more than a controller's start.
const COMMANDS: u64 = 50;
/// Resets within this time are one restart of the plant, in ns.
const ONE_RESET_NS: i64 = 3_000_000_000;

/// What is open about the nodes of a bus.
#[derive(Clone, Debug, Default)]
pub(in crate::diagnosis) struct Nodes {
    silent: BTreeMap<u8, Place>,
    /// Nodes that are back, or left Operational, and are over it once they are Operational again.
    waiting: BTreeMap<u8, Vec<Place>>,
    /// Nodes that were to boot or to reach a state.
    owing: BTreeMap<u8, Place>,
    commanded: Option<Commanded>,
    /// Which of the nodes were Operational before their last boot-up or reset.
    was_operational: u128,
    /// The first start of each node that it has not obeyed yet.
    started: BTreeMap<u8, FrameRef>,
    /// The boot-up of each node that ended its last silence.
    returned: BTreeMap<u8, u64>,
    /// The last frame of each node before its last boot-up.
    before: BTreeMap<u8, FrameRef>,
    /// The last start of each node, and of all (0), by command.
    ordered: BTreeMap<u8, FrameRef>,
    /// RPDOs to nodes that are not Operational: the first, how many, and what was opened.
    ignored: BTreeMap<u8, (FrameRef, u64, Option<Place>)>,
    /// The last boot-up of each node.
    booted: BTreeMap<u8, FrameRef>,
}

impl Nodes {
    /// A node has sent something that is no boot-up.
    pub(in crate::diagnosis) fn heard(&mut self, node: u8, heartbeat: bool, scene: &mut Scene<'_>) {
        if self.silent.is_empty() {
            return;
        }
        let Some(place) = self.silent.get(&node).copied() else { return self.was_away(node, scene) };
        let at = scene.at;
        let Some(one) = scene.ledger.get_mut(place) else { return };
        gone(one, scene.heard.last(node), at);
        if one.kind == Kind::HeartbeatStopped && !heartbeat {
            return;
        }
        one.step(at, Role::Recovery, Saying::HeardAgain, None);
        if let Some(silence) = at.since(one.repeats.since) {
            one.fact("silence", Quantity::Ns(silence));
        }
        self.silent.remove(&node);
        if !self.silent.values().any(|other| *other == place) {
            one.ends(at);
        }
    }

    /// A node has booted; `asked`: by command.
    pub(in crate::diagnosis) fn booted(&mut self, node: u8, scene: &mut Scene<'_>) {
        let at = scene.at;
        let was = scene.heard.is_operational(node) || self.was_operational & bit(node) != 0;
        self.booted.insert(node, at);
        if let Some(commanded) = &mut self.commanded {
            commanded.boots(node, scene.ledger);
        }
        match scene.heard.last(node) {
            Some(last) => self.before.insert(node, last),
            None => self.before.remove(&node),
        };
        self.started.remove(&node);
        if let Some(place) = self.owing.remove(&node) {
            self.close(place, at, Saying::Booted, scene);
        }
        let waits = self.waiting.remove(&node).unwrap_or_default();
        for place in &waits {
            if let Some(one) = scene.ledger.get_mut(*place) {
                one.step(at, Role::Reaction, Saying::Booted, None);
            }
        }
        if !waits.is_empty() {
            self.waiting.insert(node, waits);
        }
        if let Some(place) = self.silent.remove(&node)
            && let Some(one) = scene.ledger.get_mut(place)
        {
            self.returned.insert(node, at.no);
            one.step(at, Role::Recovery, Saying::BootedUnasked, None);
            one.fact("boot_up", Quantity::Count(1));
            if let Some(silence) = at.since(one.repeats.since) {
                one.fact("silence", Quantity::Ns(silence));
            }
            if was {
                self.wait(node, place);
            } else if !self.silent.values().any(|other| *other == place) {
                one.ends(at);
            }
        }
    }

    /// Error control has shown a state.
    pub(in crate::diagnosis) fn state(&mut self, node: u8, state: u8, scene: &mut Scene<'_>) {
        if state != OPERATIONAL {
            return;
        }
        self.was_operational &= !bit(node);
        self.started.remove(&node);
        self.controlled(node, true, scene);
        let at = scene.at;
        for place in self.waiting.remove(&node).unwrap_or_default() {
            let others = self.waiting.values().flatten().any(|other| *other == place)
                || self.silent.values().any(|other| *other == place);
            if let Some(one) = scene.ledger.get_mut(place) {
                one.step(at, Role::Recovery, Saying::OperationalAgain, None);
                if !others && one.clue.codes.is_empty() && one.kind != Kind::AxisFault {
                    one.ends(at);
                }
            }
        }
        if let Some(place) = self.owing.get(&node).copied()
            && scene.ledger.get(place).is_some_and(|one| one.kind == Kind::StartWithoutEffect)
        {
            self.owing.remove(&node);
            self.close(place, at, Saying::OperationalAgain, scene);
        }
        let booted = self.booted.get(&node).copied();
        if self.commanded.as_mut().is_some_and(|commanded| commanded.is_over_with(node, booted, scene)) {
            self.commanded = None;
        }
    }

    /// The NMT master has commanded a node, or all (0); `before`: the nodes that were Operational until now.
    pub(in crate::diagnosis) fn commanded(&mut self, command: u8, node: u8, before: u128, scene: &mut Scene<'_>) {
        let meant = if node == 0 { scene.heard.known } else { bit(node) & scene.heard.known };
        let hit = meant & before;
        if hit != 0 && command != 0x01 {
            let at = scene.at;
            let kind = if matches!(command, 0x81 | 0x82) { Kind::CommandedReset } else { Kind::CommandedStop };
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
                if kind == Kind::CommandedReset {
                    one.kind = kind;
                }
                one.clue.everyone |= node == 0;
                one.fact("command", Quantity::Command(command));
                one.step(at, Role::Sign, Saying::Commanded { command }, None);
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
            one.fact("started_again", Quantity::Count(scene.at.no));
        }
        if matches!(command, 0x81 | 0x82) {
            self.was_operational &= !meant;
        }
        let at = scene.at;
        for node in members(meant) {
            for place in self.waiting.get(&node).into_iter().flatten() {
                if let Some(one) = scene.ledger.get_mut(*place) {
                    one.step(at, Role::Attempt, Saying::Commanded { command }, None);
                }
            }
        }
    }

    /// An RPDO was sent to a node; `taken`: the node is Operational, for all that is known.
    #[inline]
    pub(in crate::diagnosis) fn controlled(&mut self, node: u8, taken: bool, scene: &mut Scene<'_>) {
        if taken {
            if !self.ignored.is_empty()
                && let Some((_, _, Some(place))) = self.ignored.remove(&node)
            {
                self.close(place, scene.at, Saying::OperationalAgain, scene);
            }
            return;
        }
        let (first, count, place) = self.ignored.entry(node).or_insert((scene.at, 0, None));
        *count += 1;
        if *count != COMMANDS {
            return;
        }
        let kind = Kind::CommandsNotTaken;
        *place = scene.ledger.open(kind, scene.id, Subject::node(node), *first, scene.at);
    }

    /// A heartbeat is overdue (HBT002).
    pub(in crate::diagnosis) fn lost(&mut self, node: u8, finding: &Finding, scene: &mut Scene<'_>) {
        if let Some(one) = self.silent.get(&node).and_then(|place| scene.ledger.get_mut(*place)) {
            return one.found(finding.code, finding.at.no);
        }
        let heartbeat = finding.cause.or_else(|| scene.heard.last_heartbeat(node)).unwrap_or(finding.at);
        let period = scene.bus.heartbeat_period(node);
        let sync = scene.heard.sync;
        let (begin, producer) = last_sign(node, heartbeat, finding.at, scene);
        // Other frames that come after the next heartbeat was due show that the node goes on.
        let rest = finding.at.since(begin).unwrap_or(i64::MAX);
        let beyond = begin.since(heartbeat).unwrap_or(0);
        let goes_on = period.is_some_and(|period| beyond > period.saturating_add(period / 2) && rest < beyond);
        let kind = if goes_on { Kind::HeartbeatStopped } else { Kind::NodeSilent };
        let begin = if goes_on { heartbeat } else { begin };
        let place = self.again(kind, node, begin, scene).or_else(|| self.join(node, kind, begin, period, scene));
        let place = place.or_else(|| scene.ledger.open(kind, scene.id, Subject::node(node), begin, finding.at));
        let Some(place) = place else { return };
        let (sync_clue, clue_limit) = (scene.heard.sync_period_ns.map(|period| (sync, period)), finding.measured());
        let at_sync = producer && has_stopped(sync, finding.at, scene);
        if let Some(one) = scene.ledger.get_mut(place) {
            one.clue.controller |= scene.heard.serving & bit(node) == 0;
            one.clue.sync_producer |= producer && !goes_on;
            one.clue.sync = sync_clue;
            one.clue.because_of = finding.because_of.map(|at| at.no);
            if one.steps.is_empty() {
                one.step(begin, Role::Sign, Saying::LastSign, None);
            }
            if at_sync {
                one.step(sync, Role::Reaction, Saying::SyncGone, None);
            }
            if let Some(period) = period {
                one.fact("period", Quantity::Ns(rounded(period)));
            }
            for (name, value) in clue_limit.iter().flat_map(|all| all.facts()) {
                one.fact(if name == "silence" { "noticed_after" } else { name }, value);
            }
            one.found(finding.code, finding.at.no);
        }
        self.silent.insert(node, place);
        self.remember(node, scene);
    }

    /// A boot-up that nobody had asked for (NMT003).
    pub(in crate::diagnosis) fn restarted(&mut self, node: u8, finding: &Finding, was: bool, scene: &mut Scene<'_>) {
        let at = finding.at;
        if let Some(place) = self.waiting.get(&node).and_then(|places| places.last()).copied()
            && let Some(one) = scene.ledger.get_mut(place)
            && matches!(one.kind, Kind::NodeSilent | Kind::SegmentLost | Kind::NodeRestarted | Kind::RestartLoop)
        {
            let back = self.returned.get(&node) == Some(&at.no);
            if !back {
                one.again(at);
                one.step(at, Role::Sign, Saying::BootedUnasked, Some(finding.code));
                if one.repeats.count >= LOOP {
                    one.kind = Kind::RestartLoop;
                }
            }
            return one.found(finding.code, at.no);
        }
        let silent = scene.ledger.last(scene.id, |one| {
            one.subject.concerns(node) && one.end.is_some_and(|end| end.no == at.no) && one.kind == Kind::NodeSilent
        });
        if let Some(one) = silent.and_then(|place| scene.ledger.get_mut(place)) {
            if one.repeats.count >= LOOP {
                one.kind = Kind::RestartLoop;
            }
            return one.found(finding.code, at.no);
        }
        if self.comes_with_others(node, finding, scene) {
            return;
        }
        let again = scene.ledger.last(scene.id, |one| {
            one.subject.node == Some(node) && matches!(one.kind, Kind::NodeRestarted | Kind::RestartLoop)
        });
        let again = again.filter(|place| scene.ledger.get(*place).is_some_and(|one| one.ended_within(at, AGAIN_NS)));
        let place = match again {
            Some(place) => {
                if let Some(one) = scene.ledger.get_mut(place) {
                    one.again(at);
                    if one.repeats.count >= LOOP {
                        one.kind = Kind::RestartLoop;
                    }
                }
                Some(place)
            }
            None => scene.ledger.open(Kind::NodeRestarted, scene.id, Subject::node(node), at, at),
        };
        let Some(place) = place else { return };
        if let Some(one) = scene.ledger.get_mut(place) {
            one.step(at, Role::Sign, Saying::BootedUnasked, Some(finding.code));
            one.clue.because_of = finding.because_of.map(|at| at.no);
            if !was {
                one.ends(at);
            }
        }
        if was {
            self.wait(node, place);
        }
    }

    /// A node that was not heard since others were lost was lost with them, though nobody has missed it.
    fn was_away(&self, node: u8, scene: &mut Scene<'_>) {
        let Some(last) = scene.heard.last(node) else { return };
        let away = scene.at.since(last).unwrap_or(0);
        if scene.bus.heartbeat_period(node).is_none_or(|period| away < period.saturating_add(period / 2)) {
            return;
        }
        for place in self.silent.values() {
            let Some(one) = scene.ledger.get_mut(*place).filter(|one| one.kind == Kind::SegmentLost) else { continue };
            let period = one.ns("period").unwrap_or(0);
            if last.since(one.begin).is_some_and(|since| since <= period) && away > period {
                one.subject.nodes |= bit(node);
                one.step(scene.at, Role::Recovery, Saying::HeardAgain, None);
                return;
            }
        }
    }

    /// Whether a node that is gone was Operational: one that waits to be started was, before.
    fn remember(&mut self, node: u8, scene: &Scene<'_>) {
        if !self.waiting.contains_key(&node) {
            self.was_operational = self.was_operational & !bit(node) | scene.heard.operational & bit(node);
        }
    }

    /// A boot-up that comes with those of other nodes that were lost together: a node that is heard so seldom that it was not
    /// missed was lost with them.
    fn comes_with_others(&mut self, node: u8, finding: &Finding, scene: &mut Scene<'_>) -> bool {
        let (at, Some(before)) = (finding.at, self.before.get(&node).copied()) else { return false };
        let others = scene.ledger.last(scene.id, |one| {
            let lost = matches!(one.kind, Kind::SegmentLost | Kind::NodeSilent) && one.has("boot_up");
            let back = members(one.subject.nodes).filter_map(|other| self.booted.get(&other));
            let near = back.into_iter().any(|other| at.since(*other).is_some_and(|ns| ns.saturating_abs() <= BACK_NS));
            // Its last frame is older than the loss, or came within the time in which the others were lost.
            let period = one.ns("period").unwrap_or(0);
            lost && near && before.since(one.begin).is_some_and(|since| since <= period)
        });
        let Some(one) = others.and_then(|place| scene.ledger.get_mut(place)) else { return false };
        lost_with(one, node);
        one.step(at, Role::Recovery, Saying::BootedUnasked, Some(finding.code));
        true
    }

    /// A consumer reports a loss, and no rule has found one: the node of which nothing was heard for longest, where one
    /// alone is missed. `watched`: whom the consumer is known to watch, with its times in ns; `named`: the bytes of the
    /// emergency that may name it.
    pub(in crate::diagnosis) fn missed(
        &mut self,
        consumer: u8,
        watched: &[(u8, i64)],
        named: [u8; 5],
        scene: &mut Scene<'_>,
    ) {
        let at = scene.at;
        let age = |node: u8| scene.heard.last(node).and_then(|last| at.since(last)).unwrap_or(0);
        let is_missed = |node: &u8| {
            let limit = match (watched.iter().find(|(other, _)| other == node), watched.is_empty()) {
                (Some((_, time)), _) => *time,
                (None, false) => return false,
                (None, true) => {
                    scene.bus.heartbeat_period(*node).map_or(UNHEARD_NS, |period| period.saturating_add(period / 8))
                }
            };
            let beats = scene.heard.last_heartbeat(*node).is_some_and(|beat| {
                self.booted.get(node).is_none_or(|boot| beat.no >= boot.no) || scene.heard.last(*node) == Some(beat)
            });
            // Who was reset by command boots.
            let reset = self.commanded.as_ref().is_some_and(|commanded| {
                let kind = scene.ledger.get(commanded.place).map(|one| one.kind);
                commanded.waits_for(*node) && kind == Some(Kind::CommandedReset)
            });
            *node != consumer && beats && !reset && age(*node) >= limit
        };
        let missed: Vec<u8> = members(scene.heard.known).filter(is_missed).collect();
        if missed.iter().any(|node| self.silent.contains_key(node)) {
            return;
        }
        let named = missed.iter().copied().find(|node| named.iter().filter(|byte| **byte != 0).eq([node]));
        let alone = if let [node] = missed.as_slice() { Some(*node) } else { None };
        let Some(node) = named.or(alone) else { return };
        let Some(beat) = scene.heard.last_heartbeat(node) else { return };
        let (begin, producer) = last_sign(node, beat, at, scene);
        let kind = Kind::NodeSilent;
        let again = self.again(kind, node, begin, scene);
        let Some(place) = again.or_else(|| scene.ledger.open(kind, scene.id, Subject::node(node), begin, at)) else {
            return;
        };
        let clue = scene.heard.sync_period_ns.map(|period| (scene.heard.sync, period));
        if let Some(one) = scene.ledger.get_mut(place) {
            one.grade = Grade::Likely;
            one.clue.controller = scene.heard.serving & bit(node) == 0;
            (one.clue.sync_producer, one.clue.sync) = (producer, clue);
            if one.steps.is_empty() {
                one.step(begin, Role::Sign, Saying::LastSign, None);
            }
            if let Some(period) = scene.bus.heartbeat_period(node) {
                one.fact("period", Quantity::Ns(rounded(period)));
            }
        }
        self.silent.insert(node, place);
        self.remember(node, scene);
    }

    /// A node has changed its state by itself (NMT004, NMT005).
    pub(in crate::diagnosis) fn changed(&mut self, node: u8, finding: &Finding, scene: &mut Scene<'_>) {
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
            // It could hear nobody while nobody could hear it.
            let lost = matches!(one.kind, Kind::NodeSilent | Kind::SegmentLost) && one.ended_within(at, REACTION_NS);
            lost && one.subject.concerns(node)
        });
        let trouble = trouble.or_else(|| {
            scene.ledger.last(scene.id, |one| {
                one.subject.node == Some(node)
                    && !one.clue.reported.is_empty()
                    && at.since(one.repeats.since).is_none_or(|since| since.saturating_abs() <= REACTION_NS)
            })
        });
        let trouble = trouble.or_else(|| self.left_again(node, at, scene));
        let place = trouble.or_else(|| {
            let place = scene.ledger.open(Kind::LeftOperational, scene.id, Subject::node(node), at, finding.at)?;
            scene.ledger.get_mut(place)?.fact("state", Quantity::State(to));
            Some(place)
        });
        let Some(place) = place else { return };
        if let Some(one) = scene.ledger.get_mut(place) {
            one.step(at, Role::Reaction, Saying::Went { from, to }, Some(finding.code));
            one.fact("left_operational", Quantity::Count(1));
            if one.clue.because_of.is_none() {
                one.clue.because_of = finding.because_of.map(|at| at.no);
            }
            one.end = None;
        }
        self.wait(node, place);
    }

    /// The same node has left Operational shortly before. Where it was Operational in between though nobody had started it,
    /// and does so again and again, two nodes answer by one node-ID.
    fn left_again(&mut self, node: u8, at: FrameRef, scene: &mut Scene<'_>) -> Option<Place> {
        let place = scene.ledger.last(scene.id, |one| {
            let left = matches!(one.kind, Kind::LeftOperational | Kind::DuplicateNodeId);
            left && one.subject.node == Some(node) && (one.end.is_none() || one.ended_within(at, AGAIN_NS))
        })?;
        let since = scene.ledger.get(place)?.repeats.since;
        let ordered = [node, 0].into_iter().filter_map(|key| self.ordered.get(&key)).any(|order| order.no > since.no);
        let one = scene.ledger.get_mut(place)?;
        one.again(at);
        if one.repeats.count < LOOP || ordered {
            return Some(place);
        }
        one.kind = Kind::DuplicateNodeId;
        let begin = one.begin;
        let boot = scene.ledger.last(scene.id, |one| {
            let booted = matches!(one.kind, Kind::NodeRestarted | Kind::RestartLoop);
            booted && one.subject.node == Some(node) && one.began_within(at, DOUBLE_NS)
        });
        if let Some(boot) = boot {
            let first = scene.ledger.get(boot)?.begin;
            scene.ledger.merge(boot, place);
            let one = scene.ledger.get_mut(place)?;
            if first.no < begin.no {
                one.begin = first;
            }
        }
        Some(place)
    }

    /// A command had no effect (NMT002), or no boot-up has come (NMT006).
    pub(in crate::diagnosis) fn owes(&mut self, node: u8, finding: &Finding, scene: &mut Scene<'_>) {
        let kind = if finding.code == Code::Nmt006 { Kind::NoBootUp } else { Kind::StartWithoutEffect };
        let mut begin = finding.cause.unwrap_or(finding.at);
        if kind == Kind::StartWithoutEffect
            && finding.measured().and_then(|all| all.get("command")) == Some(Quantity::Command(0x01))
            && let Some(first) = self.started.get(&node).filter(|_| !self.owing.contains_key(&node))
        {
            begin = *first;
        }
        // A master that tries again does not make it another trouble.
        if let Some(one) = self.owing.get(&node).and_then(|place| scene.ledger.get_mut(*place))
            && one.kind == kind
        {
            one.again(begin);
            if let Some(Quantity::Command(command)) = finding.measured().and_then(|all| all.get("command")) {
                one.step(begin, Role::Attempt, Saying::Commanded { command }, Some(finding.code));
            }
            return;
        }
        let Some(place) = scene.ledger.open(kind, scene.id, Subject::node(node), begin, finding.at) else { return };
        if let Some(one) = scene.ledger.get_mut(place) {
            one.clue.because_of = finding.because_of.map(|at| at.no);
            if let Some(command) = finding.measured().and_then(|all| all.get("command")) {
                one.fact("command", command);
                if let Quantity::Command(command) = command {
                    one.step(begin, Role::Sign, Saying::Commanded { command }, Some(finding.code));
                }
            }
        }
        self.owing.insert(node, place);
    }

    /// The capture is over: nodes whose other frames have stopped, too.
    pub(in crate::diagnosis) fn finish(&mut self, scene: &mut Scene<'_>) {
        for (node, place) in &self.silent {
            let last = scene.heard.last(*node);
            if let Some(one) = scene.ledger.get_mut(*place) {
                gone(one, last, scene.at);
            }
        }
    }

    /// Whether an incident of a node is over only once the node is Operational again.
    pub(in crate::diagnosis) fn waits(&self, place: Place) -> bool {
        self.waiting.values().flatten().any(|other| *other == place)
    }

    /// Whether a node is waited for to be Operational.
    pub(in crate::diagnosis) fn is_waiting(&self, node: u8) -> bool {
        self.waiting.contains_key(&node)
            || self.owing.contains_key(&node)
            || self.ignored.contains_key(&node)
            || self.commanded.is_some()
    }

    /// Whether a node is silent.
    pub(in crate::diagnosis) fn is_silent(&self, node: u8) -> bool {
        self.silent.contains_key(&node)
    }

    /// Since when nodes are back without being Operational again.
    pub(in crate::diagnosis) fn back(&self, place: Place) -> Option<FrameRef> {
        let waiting = self.waiting.iter().filter(|(_, places)| places.contains(&place));
        waiting.filter_map(|(node, _)| self.booted.get(node).copied()).max_by_key(|at| at.no)
    }

    fn wait(&mut self, node: u8, place: Place) {
        let places = self.waiting.entry(node).or_default();
        if !places.contains(&place) {
            places.push(place);
        }
    }

    fn close(&mut self, place: Place, at: FrameRef, said: Saying, scene: &mut Scene<'_>) {
        if let Some(one) = scene.ledger.get_mut(place) {
            one.step(at, Role::Recovery, said, None);
            one.ends(at);
        }
    }

    /// The same trouble of the node, where it has come again soon.
    fn again(&mut self, kind: Kind, node: u8, begin: FrameRef, scene: &mut Scene<'_>) -> Option<Place> {
        let place = scene.ledger.last(scene.id, |one| one.kind == kind && one.subject.node == Some(node))?;
        let one = scene.ledger.get_mut(place)?;
        let soon = one.repeats.longest_ns.saturating_mul(10).max(AGAIN_NS);
        if one.end.is_some() && !one.ended_within(begin, soon) {
            return None;
        }
        one.again(begin);
        one.step(begin, Role::Sign, Saying::LastSign, None);
        Some(place)
    }

    /// The silence of other nodes that began when this one's did.
    fn join(
        &mut self,
        node: u8,
        kind: Kind,
        begin: FrameRef,
        period: Option<i64>,
        scene: &mut Scene<'_>,
    ) -> Option<Place> {
        let place = self.silent.values().copied().max()?;
        let since = scene.heard.last(node)?;
        // When the other's next heartbeat was due it was gone already, and so was this one.
        let one = scene.ledger.get_mut(place).filter(|one| kind == Kind::NodeSilent && one.end.is_none())?;
        if !matches!(one.kind, Kind::NodeSilent | Kind::SegmentLost) {
            return None;
        }
        let other_period = one.ns("period")?;
        let (first, then) = (one.begin.t_ns?, begin.t_ns.or(since.t_ns)?);
        let earliest = first.max(then);
        let latest = first.saturating_add(other_period).min(then.saturating_add(period?));
        if earliest > latest.saturating_add(TOGETHER_NS)
            || then.saturating_sub(first).saturating_abs() > other_period.max(period?)
        {
            return None;
        }
        lost_with(one, node);
        if then < first {
            (one.begin, one.repeats.since) = (begin, begin);
        }
        one.step(begin, Role::Sign, Saying::LastSign, None);
        Some(place)
    }
}

/// A node was lost with the others of an incident; what is its own stays so.
fn lost_with(one: &mut Incident, node: u8) {
    one.subject.nodes |= bit(node);
    if one.subject.nodes.count_ones() > 1 {
        one.kind = Kind::SegmentLost;
        one.subject.node = None;
    }
}

/// Whether what comes with SYNC, and came last at a frame, has stopped.
fn has_stopped(last: FrameRef, at: FrameRef, scene: &Scene<'_>) -> bool {
    let since = at.since(last).zip(scene.heard.sync_period_ns);
    last.no > 0 && since.is_some_and(|(since, period)| since > 2 * period)
}

/// The last sign of a node that is missed, whose last heartbeat is known, and whether it produces SYNC.
fn last_sign(node: u8, heartbeat: FrameRef, at: FrameRef, scene: &Scene<'_>) -> (FrameRef, bool) {
    let begin = scene.heard.last(node).filter(|last| last.no > heartbeat.no).unwrap_or(heartbeat);
    let (sync, control) = (scene.heard.sync, scene.heard.control);
    // Who only sends heartbeats controls the others: where that has stopped with them, it went on until then.
    let controls = scene.heard.serving & bit(node) == 0 && has_stopped(control, at, scene);
    let producer = scene.produces_sync(node) || controls && has_stopped(sync, at, scene);
    let last = if controls { control } else { sync };
    (if producer && last.no > begin.no { last } else { begin }, producer)
}

/// A period as a person says it: in whole ms, where it is not a short one.
fn rounded(ns: i64) -> i64 {
    const MS: i64 = 1_000_000;
    if ns < 10 * MS { ns } else { ns.saturating_add(MS / 2) / MS * MS }
}

/// A node of which only heartbeats were missing is silent where nothing else of it has come for as long.
fn gone(one: &mut Incident, last: Option<FrameRef>, at: FrameRef) {
    let limit = one.ns("limit");
    let Some(last) = last.filter(|last| one.kind == Kind::HeartbeatStopped && last.no >= one.begin.no) else { return };
    if limit.is_some_and(|limit| at.since(last) > Some(limit)) && one.repeats.count == 1 {
        one.kind = Kind::NodeSilent;
        (one.begin, one.repeats.since) = (last, last);
        one.step(last, Role::Sign, Saying::LastSign, None);
    }
}

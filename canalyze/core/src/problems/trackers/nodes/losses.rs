//! Nodes that are not heard any more: their last frames, common losses, and the consumers that miss them.
//!
//! `checks/heartbeat` decides if a heartbeat is overdue.

use super::NodeProblems;
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::problems::kinds::ProblemKind;
use crate::problems::ledger::LedgerPlace;
use crate::problems::problem::{Grade, Problem, StepRole, Subject, bit, members};
use crate::problems::roles::KindRole;
use crate::problems::sayings::Saying;
use crate::problems::scene::Scene;
use crate::problems::trackers::AGAIN_NS;
use crate::rules::finding::{Finding, Quantity};

/// Maximum distance of silences with one cause, in ns.
const TOGETHER_NS: Ns = Ns::from_ms(100);
/// Minimum time without a frame after which a node may be the one that a consumer misses, in ns.
const UNHEARD_NS: Ns = Ns::from_ms(400);

impl NodeProblems {
    /// Processes a frame of a node that is not a boot-up.
    pub(in crate::problems) fn heard(&mut self, node: u8, heartbeat: bool, scene: &mut Scene<'_>) {
        if heartbeat && !self.mute.is_empty() {
            self.mute.remove(&node);
        }
        if self.silent.is_empty() {
            return;
        }
        let Some(place) = self.silent.get(&node).copied() else { return self.was_away(node, scene) };
        let at = scene.at;
        let Some(one) = scene.ledger.get_mut(place) else { return };
        gone(one, scene.heard.last(node), at);
        if one.kind == ProblemKind::HeartbeatStopped && !heartbeat {
            return;
        }
        one.step(at, StepRole::Recovery, Saying::HeardAgain, None);
        one.clue.back |= bit(node);
        if let Some(silence) = at.since(one.repeats.since) {
            one.fact("silence", Quantity::Ns(silence));
        }
        self.silent.remove(&node);
        if !heartbeat && one.kind.is(KindRole::AloneSilent) {
            self.mute.insert(node, (place, at));
        }
        if !self.silent.values().any(|other| *other == place) {
            one.ends(at);
        }
    }

    /// Records an overdue heartbeat (HBT002).
    pub(in crate::problems) fn lost(&mut self, node: u8, finding: &Finding, scene: &mut Scene<'_>) {
        if let Some(one) = self.silent.get(&node).and_then(|place| scene.ledger.get_mut(*place)) {
            return one.found(finding);
        }
        let heartbeat = finding.cause.or_else(|| scene.heard.last_heartbeat(node)).unwrap_or(finding.at);
        let period = scene.bus.heartbeat_period(node);
        let sync = scene.heard.sync;
        let (begin, producer) = last_sign(node, heartbeat, finding.at, scene);
        // Other frames after the next heartbeat was due show that the node goes on.
        let rest = finding.at.since(begin).unwrap_or(Ns::MAX);
        let beyond = begin.since(heartbeat).unwrap_or(Ns::ZERO);
        let goes_on = period.is_some_and(|period| beyond > period + period / 2 && rest < beyond);
        let kind = if goes_on { ProblemKind::HeartbeatStopped } else { ProblemKind::NodeSilent };
        let begin = if goes_on { heartbeat } else { begin };
        // A silence that ended after the last heartbeat is the same outage.
        let outage = scene.ledger.last(scene.id, |one| {
            let after = one.end.is_some_and(|end| end.no > heartbeat.no);
            one.kind == ProblemKind::NodeSilent && one.subject.node == Some(node) && after
        });
        if let Some(one) = outage.filter(|_| goes_on).and_then(|place| scene.ledger.get_mut(place)) {
            return one.found(finding);
        }
        let place = self.again(kind, node, begin, scene).or_else(|| self.join(node, kind, begin, period, scene));
        let place = place.or_else(|| scene.ledger.open(kind, scene.id, Subject::node(node), begin, finding.at));
        let Some(place) = place else { return };
        // The late heartbeats before it are its beginning.
        let late = scene.ledger.last(scene.id, |one| {
            one.kind == ProblemKind::HeartbeatIrregular
                && one.subject.node == Some(node)
                && one.has("found")
                && one.began_within(begin, AGAIN_NS)
        });
        if let Some(late) = late {
            scene.ledger.merge(late, place);
        }
        let (sync_clue, clue_limit) = (scene.heard.sync_period_ns.map(|period| (sync, period)), finding.measured());
        let at_sync = producer && has_stopped(sync, finding.at, scene);
        let controller = is_controller(node, period, finding.at, scene);
        if let Some(one) = scene.ledger.get_mut(place) {
            one.clue.controller |= controller;
            one.clue.sync_producer |= producer && !goes_on;
            one.clue.sync = sync_clue;
            one.clue.because_of = finding.because_of.map(|at| at.no);
            if one.steps.is_empty() {
                one.step(begin, StepRole::Sign, Saying::LastSign, None);
            }
            if at_sync {
                one.step(sync, StepRole::Reaction, Saying::SyncGone, None);
            }
            if let Some(period) = period {
                one.fact("period", Quantity::Ns(rounded(period)));
            }
            for (name, value) in clue_limit.iter().flat_map(|all| all.facts()) {
                one.fact(if name == "silence" { "noticed_after" } else { name }, value);
            }
            one.found(finding);
        }
        self.silent.insert(node, place);
        self.remember(node, scene);
    }

    /// Records a late heartbeat (HBT001) behind a silence of its whole node; returns false if other frames came meanwhile.
    pub(in crate::problems) fn was_silent(&mut self, node: u8, finding: &Finding, scene: &mut Scene<'_>) -> bool {
        let Some(Quantity::Ns(period)) = finding.measured().and_then(|all| all.get("expected")) else { return false };
        let Some((from, to)) = scene.heard.silence(node, period).filter(|(_, to)| to.no > 0) else { return false };
        let near = |one: FrameRef, other: FrameRef| one.since(other).is_some_and(|apart| apart.abs() <= period);
        let with = scene.ledger.last(scene.id, |one| {
            one.kind.is(KindRole::Silent) && near(one.begin, from) && one.end.is_some_and(|end| near(end, to))
        });
        let place = with.or_else(|| self.again(ProblemKind::NodeSilent, node, from, scene));
        let open = || scene.ledger.open(ProblemKind::NodeSilent, scene.id, Subject::node(node), from, finding.at);
        let Some(one) = place.or_else(open).and_then(|place| scene.ledger.get_mut(place)) else { return false };
        lost_with(one, node);
        if place.is_none() {
            one.step(from, StepRole::Sign, Saying::LastSign, None);
            one.fact("period", Quantity::Ns(rounded(period)));
            one.fact("silence", Quantity::Ns(to.since(from).unwrap_or_default()));
        }
        one.step(to, StepRole::Recovery, Saying::HeardAgain, None);
        one.clue.back |= bit(node);
        one.found(finding);
        one.ends(to);
        if one.begin.no > from.no {
            (one.begin, one.repeats.since) = (from, from);
        }
        // It is over when the last node of a segment is back.
        one.end = one.end.into_iter().chain([to]).max_by_key(|end| end.no);
        true
    }

    /// Attributes a loss reported by a consumer, but found by no rule, to the node that has not been heard for longest,
    /// if only one is missing. `watched`: the nodes that the consumer monitors, with their times in ns; `named`: the
    /// bytes of the emergency that may name the node.
    pub(in crate::problems) fn missed(
        &mut self,
        consumer: u8,
        watched: &[(u8, Ns)],
        named: [u8; 5],
        scene: &mut Scene<'_>,
    ) {
        let at = scene.at;
        let names = |node: u8| named.iter().filter(|byte| **byte != 0).eq([&node]);
        let age = |node: u8| scene.heard.last(node).and_then(|last| at.since(last)).unwrap_or(Ns::ZERO);
        let is_missed = |node: &u8| {
            let limit = match (watched.iter().find(|(other, _)| other == node), watched.is_empty()) {
                (Some((_, time)), _) => *time,
                (None, false) => return false,
                // Without a period nobody knows when its heartbeat was due, unless the emergency names it.
                (None, true) => match scene.bus.heartbeat_period(*node) {
                    Some(period) => period + period / 8,
                    None if names(*node) => UNHEARD_NS,
                    None => return false,
                },
            };
            let beats = scene.heard.last_heartbeat(*node).is_some_and(|beat| {
                self.booted.get(node).is_none_or(|boot| beat.no >= boot.no) || scene.heard.last(*node) == Some(beat)
            });
            // A node reset by command is booting.
            let reset = self.commanded.as_ref().is_some_and(|commanded| {
                let kind = scene.ledger.get(commanded.place).map(|one| one.kind);
                commanded.waits_for(*node) && kind.is_some_and(|kind| kind.is(KindRole::Reset))
            });
            *node != consumer && beats && !reset && age(*node) >= limit
        };
        let missed: Vec<u8> = members(scene.heard.known).filter(is_missed).collect();
        if missed.iter().any(|node| self.silent.contains_key(node)) {
            return;
        }
        let named = missed.iter().copied().find(|node| names(*node));
        let alone = if let [node] = missed.as_slice() { Some(*node) } else { None };
        let Some(node) = named.or(alone) else { return };
        let Some(beat) = scene.heard.last_heartbeat(node) else { return };
        let (begin, producer) = last_sign(node, beat, at, scene);
        let kind = ProblemKind::NodeSilent;
        let again = self.again(kind, node, begin, scene);
        let Some(place) = again.or_else(|| scene.ledger.open(kind, scene.id, Subject::node(node), begin, at)) else {
            return;
        };
        let clue = scene.heard.sync_period_ns.map(|period| (scene.heard.sync, period));
        let controller = is_controller(node, scene.bus.heartbeat_period(node), at, scene);
        if let Some(one) = scene.ledger.get_mut(place) {
            one.grade = Grade::Likely;
            one.clue.controller = controller;
            (one.clue.sync_producer, one.clue.sync) = (producer, clue);
            if one.steps.is_empty() {
                one.step(begin, StepRole::Sign, Saying::LastSign, None);
            }
            if let Some(period) = scene.bus.heartbeat_period(node) {
                one.fact("period", Quantity::Ns(rounded(period)));
            }
        }
        self.silent.insert(node, place);
        self.remember(node, scene);
    }

    /// Withdraws silences that a consumer reported before the period of the node was known, and that are no longer than it.
    fn withdraw(&self, scene: &mut Scene<'_>) {
        let reported = |one: &Problem| {
            let node = one.subject.node.filter(|_| one.kind.is(KindRole::AloneSilent) && one.findings.is_empty());
            let (node, silence) = node.zip(one.ns("silence"))?;
            let period = scene.bus.heartbeat_period(node)?;
            (one.bus == scene.id && silence <= period + period / 2).then_some(one.id)
        };
        let gone: Vec<_> = scene.ledger.all.iter().filter_map(reported).collect();
        gone.into_iter().for_each(|id| scene.ledger.withdraw(id));
    }

    /// Completes nodes whose other frames have stopped as well, at the end of the capture.
    pub(in crate::problems) fn finish(&mut self, scene: &mut Scene<'_>) {
        // Other frames have come, but no heartbeat: it has stopped.
        for (node, (place, since)) in std::mem::take(&mut self.mute) {
            let (beat, end) = (scene.heard.last_heartbeat(node), scene.at);
            let Some(one) = scene.ledger.get_mut(place).filter(|one| one.kind.is(KindRole::AloneSilent)) else {
                continue;
            };
            let limit = one.ns("limit").or_else(|| one.ns("period")).unwrap_or(Ns::MAX);
            if let Some(beat) = beat.filter(|_| end.since(since).is_some_and(|rest| rest > limit)) {
                (one.kind, one.end) = (ProblemKind::HeartbeatStopped, None);
                one.steps.retain(|step| step.role != StepRole::Recovery || step.at.no < since.no);
                (one.begin, one.repeats.since, one.repeats.count) = (beat, beat, 1);
            }
        }
        self.withdraw(scene);
        for (node, place) in &self.silent {
            let last = scene.heard.last(*node);
            if let Some(one) = scene.ledger.get_mut(*place) {
                gone(one, last, scene.at);
            }
        }
    }

    /// Adds a node to the loss of others if it has not been heard since then, although it was not missed.
    fn was_away(&self, node: u8, scene: &mut Scene<'_>) {
        let Some(last) = scene.heard.last(node) else { return };
        let away = scene.at.since(last).unwrap_or(Ns::ZERO);
        if scene.bus.heartbeat_period(node).is_none_or(|period| away < period + period / 2) {
            return;
        }
        for place in self.silent.values() {
            let Some(one) = scene.ledger.get_mut(*place).filter(|one| one.kind.is(KindRole::Segment)) else {
                continue;
            };
            let period = one.ns("period").unwrap_or(Ns::ZERO);
            if last.since(one.begin).is_some_and(|since| since <= period) && away > period {
                one.subject.nodes |= bit(node);
                one.step(scene.at, StepRole::Recovery, Saying::HeardAgain, None);
                one.clue.back |= bit(node);
                return;
            }
        }
    }

    /// Remembers if a lost node was Operational; one that waits to be started was so before.
    fn remember(&mut self, node: u8, scene: &Scene<'_>) {
        if !self.waiting.contains_key(&node) {
            self.was_operational = self.was_operational & !bit(node) | scene.heard.operational & bit(node);
        }
    }

    /// Returns the same problem of the node if it recurs soon.
    fn again(&mut self, kind: ProblemKind, node: u8, begin: FrameRef, scene: &mut Scene<'_>) -> Option<LedgerPlace> {
        let same = |one: &Problem| {
            // A node that restarts again and again is silent meanwhile.
            let again = one.kind.is(KindRole::Restart) && one.repeats.count > 1;
            let loops = kind.is(KindRole::AloneSilent) && (again || one.kind.is(KindRole::Loop));
            (one.kind == kind || loops) && one.subject.node == Some(node)
        };
        let place = scene.ledger.last(scene.id, same)?;
        let one = scene.ledger.get_mut(place)?;
        let soon = (one.repeats.longest_ns * 10).max(AGAIN_NS);
        if one.end.is_some() && !one.ended_within(begin, soon) {
            return None;
        }
        one.again(begin);
        one.step(begin, StepRole::Sign, Saying::LastSign, None);
        Some(place)
    }

    /// Returns the silence of other nodes that began together with this one.
    fn join(
        &mut self,
        node: u8,
        kind: ProblemKind,
        begin: FrameRef,
        period: Option<Ns>,
        scene: &mut Scene<'_>,
    ) -> Option<LedgerPlace> {
        let place = self.silent.values().copied().max()?;
        let since = scene.heard.last(node)?;
        // When the next heartbeat of the other was due, it was already lost, and so was this one.
        let one = scene.ledger.get_mut(place).filter(|one| kind.is(KindRole::AloneSilent) && one.end.is_none())?;
        if !one.kind.is(KindRole::Silent) {
            return None;
        }
        let other_period = one.ns("period")?;
        let (first, then) = (one.begin.t_ns?, begin.t_ns.or(since.t_ns)?);
        let earliest = first.max(then);
        let latest = (first + other_period).min(then + period?);
        if earliest > latest + TOGETHER_NS || (then - first).abs() > other_period.max(period?) {
            return None;
        }
        lost_with(one, node);
        if then < first {
            (one.begin, one.repeats.since) = (begin, begin);
        }
        one.step(begin, StepRole::Sign, Saying::LastSign, None);
        Some(place)
    }
}

/// Returns true if a silent node is the controller: it has sent nothing but heartbeats, and what controls has ended with them.
fn is_controller(node: u8, period: Option<Ns>, at: FrameRef, scene: &Scene<'_>) -> bool {
    let (control, alone) = (scene.heard.control, scene.heard.serving & bit(node) == 0);
    let goes_on = at.since(control).zip(period).is_some_and(|(since, period)| since < period);
    alone && control.no > 0 && !goes_on
}

/// Returns true if messages that accompany SYNC, the last of them at a frame, have stopped.
fn has_stopped(last: FrameRef, at: FrameRef, scene: &Scene<'_>) -> bool {
    let since = at.since(last).zip(scene.heard.sync_period_ns);
    last.no > 0 && since.is_some_and(|(since, period)| since > 2 * period)
}

/// Returns the last sign of a missed node with a known last heartbeat, and true if it produces SYNC.
fn last_sign(node: u8, heartbeat: FrameRef, at: FrameRef, scene: &Scene<'_>) -> (FrameRef, bool) {
    let begin = scene.heard.last(node).filter(|last| last.no > heartbeat.no).unwrap_or(heartbeat);
    let (sync, control) = (scene.heard.sync, scene.heard.control);
    // A node that sends only heartbeats is the controller; if control traffic has stopped with its heartbeats, it lived
    // until then.
    let controls = scene.heard.serving & bit(node) == 0 && has_stopped(control, at, scene);
    let producer = scene.produces_sync(node) || controls && has_stopped(sync, at, scene);
    let last = if controls { control } else { sync };
    (if producer && last.no > begin.no { last } else { begin }, producer)
}

/// Rounds a period for people: to whole ms unless it is short.
fn rounded(ns: Ns) -> Ns {
    const MS: Ns = Ns::from_ms(1);
    if ns < 10 * MS { ns } else { (ns + MS / 2) / MS * MS }
}

/// Turns a loss of heartbeats into a silence if the node has sent nothing else for as long.
fn gone(one: &mut Problem, last: Option<FrameRef>, at: FrameRef) {
    // Without a limit it was a written period that no heartbeat has followed.
    let limit = one.ns("limit").or_else(|| Some(one.ns("expected")? * 3));
    let Some(last) = last.filter(|last| one.kind == ProblemKind::HeartbeatStopped && last.no >= one.begin.no) else {
        return;
    };
    if limit.is_some_and(|limit| at.since(last) > Some(limit)) && one.repeats.count == 1 {
        if one.ns("period").is_some_and(|period| last.since(one.begin) > Some(2 * period)) {
            // Its heartbeats had ended before, so they came not until then.
            one.facts.retain(|(name, _)| *name != "period");
        }
        one.kind = ProblemKind::NodeSilent;
        (one.begin, one.repeats.since) = (last, last);
        one.step(last, StepRole::Sign, Saying::LastSign, None);
    }
}

/// Adds a node to a problem of lost nodes; its own facts stay.
pub(super) fn lost_with(one: &mut Problem, node: u8) {
    one.subject.nodes |= bit(node);
    if one.subject.nodes.count_ones() > 1 {
        one.kind = ProblemKind::SegmentLost;
        one.subject.node = None;
    }
}

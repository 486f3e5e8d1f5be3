//! Drives that are in fault or do not do what they are told (CiA 402).
//!
//! That a drive is in fault, and that a command had no effect, is found by `checks/drive`; here it is followed until the
//! axis has left the fault. Must not: decode a statusword.

use std::collections::BTreeMap;

use crate::diagnosis::incident::{Role, Subject};
use crate::diagnosis::kinds::Kind;
use crate::diagnosis::ledger::Place;
use crate::diagnosis::sayings::Saying;
use crate::diagnosis::scene::Scene;
use crate::drive::State;
use crate::finding::{Finding, Quantity};
use crate::frame::FrameRef;

/// An emergency and a fault of one node within this time, in ns, are one trouble, whichever comes first.
const SAME_NS: i64 = 500_000_000;
/// Axes of one device that fault within this time, in ns, have one cause.
const TOGETHER_NS: i64 = 100_000_000;

/// What is open about the drives of a bus.
#[derive(Debug, Default)]
pub(in crate::diagnosis) struct Drives {
    /// Faults, by node.
    faults: BTreeMap<u8, Place>,
    /// Commands without effect, with the state in which the axis stayed.
    stuck: BTreeMap<u8, (Place, Option<State>)>,
}

/// The axis of a finding, from 1.
fn axis(finding: &Finding) -> u8 {
    let index = finding.object.map_or(0x6041, |mux| mux.index);
    (index.saturating_sub(0x6000) / 0x800).min(7) as u8 + 1
}

impl Drives {
    /// Whether anything is open: only then it matters what state an axis is in.
    pub(in crate::diagnosis) fn is_empty(&self) -> bool {
        self.faults.is_empty() && self.stuck.is_empty()
    }

    /// The drive is in fault (DRV005).
    pub(in crate::diagnosis) fn fault(&mut self, node: u8, finding: &Finding, scene: &mut Scene<'_>) {
        let at = finding.about().unwrap_or(finding.at);
        let axis = axis(finding);
        let because = finding.because_of.map(|frame| frame.no);
        let place = self.faults.get(&node).copied().filter(|place| {
            scene.ledger.get(*place).is_some_and(|one| one.end.is_none() && one.began_within(at, TOGETHER_NS))
        });
        let place = place.or_else(|| {
            scene.ledger.last(scene.id, |one| {
                let near = at.since(one.repeats.since).is_some_and(|since| since.abs() <= SAME_NS);
                let reported = !one.clue.reported.is_empty();
                one.subject.node == Some(node) && reported && (near || because.is_some_and(|frame| one.holds(frame)))
            })
        });
        let place = match place {
            Some(place) => place,
            None => {
                let Some(place) = scene.ledger.open(Kind::AxisFault, scene.id, Subject::node(node), at, at) else { return };
                let watched = scene.watched(node).iter().map(|(node, time, _)| (*node, *time)).collect();
                let sync = scene.heard.sync_period_ns.map(|period| (scene.heard.sync, period));
                let sources = scene.sources(node);
                if let Some(one) = scene.ledger.get_mut(place) {
                    (one.clue.watched, one.clue.sync, one.clue.sources) = (watched, sync, sources);
                    one.clue.because_of = because;
                }
                place
            }
        };
        if let Some(one) = scene.ledger.get_mut(place) {
            one.kind = Kind::AxisFault;
            one.end = None;
            one.subject.axis = one.subject.axis.or(Some(axis));
            if let Some(Quantity::Statusword(statusword)) = finding.measured().and_then(|all| all.get("statusword")) {
                one.step(at, Role::Sign, Saying::InFault { statusword }, Some(finding.code));
            }
            one.found(finding.code, finding.at.no);
        }
        self.faults.insert(node, place);
    }

    /// A command had no effect (DRV002).
    pub(in crate::diagnosis) fn stuck(&mut self, node: u8, finding: &Finding, scene: &mut Scene<'_>) {
        let at = finding.about().unwrap_or(finding.at);
        if let Some(one) = self.faults.get(&node).and_then(|place| scene.ledger.get_mut(*place)) {
            one.fact("reset_in_vain", Quantity::Count(at.no));
            return one.step(at, Role::Attempt, Saying::ResetInVain, Some(finding.code));
        }
        let state = scene.bus.drive_states(node).find(|(number, _)| number + 1 == usize::from(axis(finding)));
        let state = state.map(|(_, state)| state);
        let kind = if state == Some(State::Fault) { Kind::FaultResetWithoutEffect } else { Kind::NotEnabled };
        if let Some((place, _)) = self.stuck.get(&node)
            && let Some(one) = scene.ledger.get_mut(*place)
        {
            return one.step(at, Role::Attempt, Saying::ResetInVain, Some(finding.code));
        }
        let subject = Subject { axis: Some(axis(finding)), ..Subject::node(node) };
        let Some(place) = scene.ledger.open(kind, scene.id, subject, at, finding.at) else { return };
        if let Some(one) = scene.ledger.get_mut(place) {
            one.clue.because_of = finding.because_of.map(|frame| frame.no);
            for (name, value) in finding.measured().iter().flat_map(|all| all.facts()) {
                one.fact(name, value);
            }
            one.found(finding.code, finding.at.no);
        }
        self.stuck.insert(node, (place, state));
    }

    /// A node has sent something: whether its axes are out of what is open. Says whether that has changed.
    pub(in crate::diagnosis) fn heard(&mut self, node: u8, at: FrameRef, scene: &mut Scene<'_>) -> bool {
        let mut changed = false;
        let states = || scene.bus.drive_states(node).map(|(_, state)| state);
        let is_known = states().next().is_some();
        let in_fault = states().any(|state| matches!(state, State::Fault | State::FaultReactionActive));
        let enabled = states().any(|state| state == State::OperationEnabled);
        if let Some(place) = self.faults.get(&node).copied()
            && is_known
            && !in_fault
            && let Some(one) = scene.ledger.get_mut(place)
        {
            if !one.facts.iter().any(|(name, _)| *name == "left_fault") {
                one.step(at, Role::Recovery, Saying::LeftFault, None);
                one.fact("left_fault", Quantity::Count(at.no));
            }
            // An error that stands may keep the axis from being enabled.
            if enabled || one.clue.codes.is_empty() {
                self.faults.remove(&node);
                changed = true;
            }
        }
        if let Some((place, state)) = self.stuck.get(&node).copied() {
            let stays = scene.bus.drive_states(node).any(|(_, now)| Some(now) == state);
            if !stays && is_known {
                self.stuck.remove(&node);
                if let Some(one) = scene.ledger.get_mut(place) {
                    one.step(at, Role::Recovery, Saying::Recovered, None);
                    one.ends(at);
                }
            }
        }
        changed
    }

    /// Whether a fault is open.
    pub(in crate::diagnosis) fn holds(&self, place: Place) -> bool {
        self.faults.values().any(|other| *other == place)
    }

    /// A node has booted, or was reset: its axes are in no state.
    pub(in crate::diagnosis) fn booted(&mut self, node: u8, scene: &mut Scene<'_>) {
        let at = scene.at;
        if let Some(place) = self.faults.remove(&node)
            && let Some(one) = scene.ledger.get_mut(place)
        {
            one.fact("left_fault", Quantity::Count(at.no));
        }
        if let Some((place, _)) = self.stuck.remove(&node)
            && let Some(one) = scene.ledger.get_mut(place)
        {
            one.ends(at);
        }
    }
}

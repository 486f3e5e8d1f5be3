//! Drives in fault, and drives that do not obey commands (CiA 402).
//!
//! `checks/drive` finds that a drive is in fault or that a command had no effect; this tracker follows it until the
//! axis has left the fault.

use std::collections::BTreeMap;

use super::AGAIN_NS;
use crate::bytes::frame::{Frame, FrameRef};
use crate::bytes::ns::Ns;
use crate::checks::limits::{FAULT_EMCY_NS, FAULTS_TOGETHER_NS};
use crate::problems::kinds::{ProblemKind, signed};
use crate::problems::ledger::LedgerPlace;
use crate::problems::problem::{Grade, Problem, StepRole, Subject, bit};
use crate::problems::roles::KindRole;
use crate::problems::sayings::Saying;
use crate::problems::scene::Scene;
use crate::rules::finding::{Code, Finding, Quantity};
use crate::sdo::transfer::{Status, Transfer};
use crate::wire::pdo::mapping::extract;
use crate::world::drive::{DriveObject, DriveState, PROFILE};
use crate::world::event::{ProcessData, Signals, Unmapped};
use crate::world::node::PerNode;

/// Time after which a drive in fault when first seen is reported, in ns; one that was just switched on is reset before.
const SEEN_NS: Ns = Ns::from_s(3);

/// The open problems of the drives of a bus.
#[derive(Clone, Debug, Default)]
pub(in crate::problems) struct Drives {
    /// Nodes known to be drives, one bit each: by their device type, or by an object of drives in SDO.
    drives: u128,
    /// The states of drives without a known mapping, by the default mapping of CiA 402: the statusword comes first. That
    /// is a guess of this tracker, of a lower grade, so the bus does not publish it.
    assumed: BTreeMap<u8, DriveState>,
    /// The last controlword of each node.
    controlwords: PerNode<Option<u16>>,
    /// Faults, by node.
    faults: BTreeMap<u8, LedgerPlace>,
    /// Nodes with an axis that has reported a fault, one bit each.
    reported: u128,
    /// Commands without effect, with the state that the axis kept.
    stuck: BTreeMap<u8, (LedgerPlace, Option<DriveState>)>,
}

/// Returns the axis of a finding, from 1.
fn axis(finding: &Finding) -> u8 {
    let index = finding.object.map_or(0x6041, |mux| mux.index);
    (index.saturating_sub(0x6000) / 0x800).min(7) as u8 + 1
}

/// Bit 7 of the controlword: fault reset.
const FAULT_RESET: u16 = 1 << 7;

/// Returns the value of an object in a PDO and false, or, without a known mapping, the first two bytes of the first PDO
/// (default mapping of CiA 402) and true.
fn word(data: &ProcessData, frame: &Frame, object: DriveObject) -> Option<(u16, bool)> {
    match &data.content {
        Signals::Mapped(mapping, _) | Signals::ByConsumer(mapping, ..) => {
            let mut entries = mapping.entries.iter();
            let part = entries.find(|entry| DriveObject::at(entry.index) == Some(object) && entry.bits == 16)?;
            let raw = extract(frame.payload(), usize::from(part.offset), 16)?;
            Some((raw as u16, false))
        }
        Signals::None(Unmapped::Unknown) if data.number == 1 => match frame.payload() {
            [low, high, ..] => Some((u16::from_le_bytes([*low, *high]), true)),
            _ => None,
        },
        Signals::None(_) => None,
    }
}

impl Drives {
    /// Checks if an SDO transfer shows that a node is a drive.
    pub(in crate::problems) fn transfer(&mut self, transfer: &Transfer) {
        let Some(mux) = transfer.mux.filter(|_| transfer.outcome.status == Status::Ok) else { return };
        let of_type = mux.index == 0x1000
            && matches!(transfer.data.kept.as_slice(), [low, high, ..] if u16::from_le_bytes([*low, *high]) == PROFILE);
        if of_type || DriveObject::at(mux.index).is_some() || matches!(mux.index, 0x6502 | 0x607A | 0x60FF | 0x6071) {
            self.drives |= bit(transfer.node);
        }
    }

    /// Processes a PDO: its commands, and its state if only the default mapping gives that.
    pub(in crate::problems) fn pdo(&mut self, data: &ProcessData, frame: &Frame, scene: &mut Scene<'_>) {
        if self.drives & bit(data.node) == 0 && !self.faults.contains_key(&data.node) {
            return;
        }
        let at = scene.at;
        if !data.transmit {
            let Some((word, _)) = word(data, frame, DriveObject::Controlword) else { return };
            let before = self.controlwords.entry(data.node).replace(word).unwrap_or(FAULT_RESET);
            if word & !before & FAULT_RESET != 0
                && let Some(one) = self.faults.get(&data.node).and_then(|place| scene.ledger.get_mut(*place))
            {
                one.fact("resets", Quantity::Count(one.count("resets") + 1));
                one.step(at, StepRole::Attempt, Saying::FaultReset, None);
            }
            return;
        }
        if scene.bus.drive_states(data.node).next().is_some() {
            return;
        }
        let Some((word, true)) = word(data, frame, DriveObject::Statusword) else { return };
        let Some(state) = DriveState::of(word) else { return };
        let before = self.assumed.insert(data.node, state);
        let is_fault = |state: DriveState| matches!(state, DriveState::Fault | DriveState::FaultReactionActive);
        if is_fault(state) && before.is_some_and(|before| !is_fault(before)) {
            self.enter(data.node, (at, 1), None, None, scene);
            if let Some(one) = self.faults.get(&data.node).and_then(|place| scene.ledger.get_mut(*place)) {
                one.grade = Grade::Likely;
                one.step(at, StepRole::Sign, Saying::InFault { statusword: word }, None);
            }
        }
    }

    /// Returns the states of a node's axes.
    fn states(&self, node: u8, scene: &Scene<'_>) -> Vec<DriveState> {
        let known: Vec<DriveState> = scene.bus.drive_states(node).map(|(_, state)| state).collect();
        if known.is_empty() { self.assumed.get(&node).copied().into_iter().collect() } else { known }
    }

    /// Returns true if a node is known to be a drive.
    pub(in crate::problems) fn is_drive(&self, node: u8) -> bool {
        self.drives & bit(node) != 0
    }

    /// Returns true if nothing is open, so that the states of axes do not matter.
    pub(in crate::problems) fn is_empty(&self) -> bool {
        self.faults.is_empty() && self.stuck.is_empty()
    }

    /// Records a drive in fault (DRV005).
    pub(in crate::problems) fn fault(&mut self, node: u8, finding: &Finding, scene: &mut Scene<'_>) {
        let at = finding.about().unwrap_or(finding.at);
        self.enter(node, (at, axis(finding)), finding.because_of, Some(finding.code), scene);
        if let Some(one) = self.faults.get(&node).and_then(|place| scene.ledger.get_mut(*place)) {
            if let Some(Quantity::Statusword(statusword)) = finding.measured().and_then(|all| all.get("statusword")) {
                one.step(at, StepRole::Sign, Saying::InFault { statusword }, Some(finding));
            }
            one.found(finding);
        }
    }

    /// Opens or extends a problem of an axis that entered the fault state.
    fn enter(
        &mut self,
        node: u8,
        (at, axis): (FrameRef, u8),
        because_of: Option<FrameRef>,
        from: Option<Code>,
        scene: &mut Scene<'_>,
    ) {
        let because = because_of.map(|frame| frame.no);
        let near = |one: &Problem, ns: Ns| at.since(one.repeats.since).is_some_and(|since| since.abs() <= ns);
        let open = self.faults.get(&node).copied();
        let open = open.filter(|place| {
            scene.ledger.get(*place).is_some_and(|one| one.end.is_none() && near(one, FAULTS_TOGETHER_NS))
        });
        let place = open.or_else(|| {
            scene.ledger.last(scene.id, |one| {
                let reported = !one.clue.reported.is_empty();
                let explains = because.is_some_and(|frame| one.holds(frame));
                one.subject.node == Some(node) && reported && (near(one, FAULT_EMCY_NS) || explains)
            })
        });
        let again = || {
            scene.ledger.last(scene.id, |one| {
                let same = one.kind.is(KindRole::Fault) && one.subject.node == Some(node);
                same && one.ended_within(at, AGAIN_NS) && one.clue.reported.is_empty() && from.is_some()
            })
        };
        let place = match place.or_else(again) {
            Some(place) => place,
            None => {
                let Some(place) = scene.ledger.open(ProblemKind::AxisFault, scene.id, Subject::node(node), at, at)
                else {
                    return;
                };
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
            one.kind = ProblemKind::AxisFault;
            if one.end.is_some() {
                one.again(at);
            }
            if one.begin.no > at.no {
                (one.begin, one.repeats.since) = (at, at);
            }
            one.facts.retain(|(name, _)| *name != "left_fault");
            one.subject.axes |= 1 << (axis - 1);
            let axes: u32 = one.subject.axes.count_ones();
            one.subject.axis = if axes == 1 { Some(axis) } else { None };
        }
        self.faults.insert(node, place);
    }

    /// Records a command without effect (DRV002).
    pub(in crate::problems) fn stuck(&mut self, node: u8, finding: &Finding, scene: &mut Scene<'_>) {
        let at = finding.about().unwrap_or(finding.at);
        if let Some(one) = self.faults.get(&node).and_then(|place| scene.ledger.get_mut(*place)) {
            one.fact("reset_in_vain", Quantity::Count(at.listed().no));
            return one.step(at, StepRole::Attempt, Saying::ResetInVain, Some(finding));
        }
        let state = scene.bus.drive_states(node).find(|(number, _)| number + 1 == usize::from(axis(finding)));
        let state = state.map(|(_, state)| state);
        let kind = match signed(finding.code) {
            Some((kind, _)) if state != Some(DriveState::Fault) => kind,
            _ => ProblemKind::FaultResetWithoutEffect,
        };
        if let Some((place, _)) = self.stuck.get(&node)
            && let Some(one) = scene.ledger.get_mut(*place)
        {
            return one.step(at, StepRole::Attempt, Saying::ResetInVain, Some(finding));
        }
        let axes = 1 << (axis(finding) - 1);
        let subject = Subject { axis: Some(axis(finding)), axes, ..Subject::node(node) };
        let Some(place) = scene.ledger.open(kind, scene.id, subject, at, finding.at) else { return };
        if let Some(one) = scene.ledger.get_mut(place) {
            one.clue.because_of = finding.because_of.map(|frame| frame.no);
            for (name, value) in finding.measured().iter().flat_map(|all| all.facts()) {
                one.fact(name, value);
            }
            one.found(finding);
        }
        self.stuck.insert(node, (place, state));
    }

    /// Checks after a frame of a node if its axes have left their open problems; returns true if that has changed.
    pub(in crate::problems) fn heard(&mut self, node: u8, at: FrameRef, scene: &mut Scene<'_>) -> bool {
        let mut changed = false;
        let states = self.states(node, scene);
        let is_known = !states.is_empty();
        let in_fault = states.iter().any(|state| matches!(state, DriveState::Fault | DriveState::FaultReactionActive));
        let enabled = states.contains(&DriveState::OperationEnabled);
        if let Some(place) = self.faults.get(&node).copied()
            && is_known
            && !in_fault
            && let Some(one) = scene.ledger.get_mut(place)
        {
            if !one.has("left_fault") {
                one.step(at, StepRole::Recovery, Saying::LeftFault, None);
                one.fact("left_fault", Quantity::Count(at.listed().no));
            }
            // An active error may keep the axis from being enabled.
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
                    one.step(at, StepRole::Recovery, Saying::Recovered, None);
                    one.ends(at);
                }
            }
        }
        changed
    }

    /// Reports an axis, after a statusword, that has been in fault since it was first seen for longer than a drive just
    /// switched on.
    pub(in crate::problems) fn stays(&mut self, node: u8, scene: &mut Scene<'_>) {
        let at = scene.at;
        let long = |(_, _, since): &(usize, u16, FrameRef)| at.since(*since).is_some_and(|lasts| lasts >= SEEN_NS);
        if self.reported & bit(node) != 0
            && !self.faults.contains_key(&node)
            && scene.bus.found_in_fault(node).any(|found| long(&found))
        {
            self.seen(node, scene);
        }
    }

    /// Records a reported state of an axis.
    pub(in crate::problems) fn reports(&mut self, node: u8, state: DriveState) {
        if matches!(state, DriveState::Fault | DriveState::FaultReactionActive) {
            self.reported |= bit(node);
        }
    }

    /// Reports the axes that have been in fault since they were first seen, at the end of the capture.
    pub(in crate::problems) fn finish(&mut self, scene: &mut Scene<'_>) {
        for node in 1..=127 {
            self.seen(node, scene);
        }
    }

    /// Opens problems of axes that have been in fault since they were first seen, unless a fault reset without effect
    /// is reported already.
    fn seen(&mut self, node: u8, scene: &mut Scene<'_>) {
        let told =
            |one: &Problem| one.subject.node == Some(node) && one.end.is_none() && one.kind.is(KindRole::FaultSeen);
        let found: Vec<_> = scene.bus.found_in_fault(node).collect();
        if found.is_empty() || scene.ledger.last(scene.id, told).is_some() {
            return;
        }
        // All errors were gone later: whether the axis still is in fault is not known.
        let gone = |one: &Problem, at: FrameRef| {
            let reported = one.subject.node == Some(node) && !one.clue.reported.is_empty();
            reported && one.clue.codes.is_empty() && one.end.is_some_and(|end| end.no > at.no)
        };
        for (axis, statusword, at) in found {
            if scene.ledger.last(scene.id, |one| gone(one, at)).is_some() {
                continue;
            }
            self.enter(node, (at, axis as u8 + 1), None, None, scene);
            if let Some(one) = self.faults.get(&node).and_then(|place| scene.ledger.get_mut(*place)) {
                one.step(at, StepRole::Sign, Saying::InFault { statusword }, None);
                if one.clue.reported.is_empty() {
                    one.fact("seen_in_fault", Quantity::Statusword(statusword));
                }
            }
        }
    }

    /// Returns true if a fault is open.
    pub(in crate::problems) fn holds(&self, place: LedgerPlace) -> bool {
        self.faults.values().any(|other| *other == place)
    }

    /// Forgets the states of the axes of a node that booted or was reset.
    pub(in crate::problems) fn booted(&mut self, node: u8, scene: &mut Scene<'_>) {
        let at = scene.at;
        self.assumed.remove(&node);
        self.controlwords.take(node);
        if let Some(place) = self.faults.remove(&node)
            && let Some(one) = scene.ledger.get_mut(place)
        {
            one.fact("left_fault", Quantity::Count(at.listed().no));
        }
        if let Some((place, _)) = self.stuck.remove(&node)
            && let Some(one) = scene.ledger.get_mut(place)
        {
            one.ends(at);
        }
    }
}

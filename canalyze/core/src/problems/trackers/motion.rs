//! Motion of drives (CiA 402-2): bits of the statusword that mean trouble in a mode, commands without effect, and late
//! targets.
//!
//! The sources are PDOs with a known mapping, and SDO. Faults are followed in `drive`. A bit whose meaning depends on
//! the mode of operation is ignored while the mode is not known.

use crate::bytes::frame::{Frame, FrameRef};
use crate::bytes::ns::Ns;
use crate::evidence::period::recent::UsualGap;
use crate::problems::kinds::ProblemKind;
use crate::problems::ledger::LedgerPlace;
use crate::problems::problem::{Grade, StepRole, Subject};
use crate::problems::roles::KindRole;
use crate::problems::sayings::Saying;
use crate::problems::scene::Scene;
use crate::rules::finding::Quantity;
use crate::sdo::transfer::{Status, Transfer};
use crate::wire::error_control::OPERATIONAL;
use crate::wire::pdo::mapping::extract;
use crate::world::change::Change;
use crate::world::drive::{self, DriveState};
use crate::world::event::{ProcessData, Signals};
use crate::world::node::PerNode;
use crate::world::od::first_axis;

/// Bits of the statusword: voltage enabled, internal limit active, and those with a meaning given by the mode.
const VOLTAGE: u16 = 1 << 4;
/// The bit of the controlword that enables the voltage.
const ENABLE_VOLTAGE: u16 = 1 << 1;
const LIMIT: u16 = 1 << 11;
const ACKNOWLEDGED: u16 = 1 << 12;
const ERROR: u16 = 1 << 13;
/// Bits of the controlword: quick stop (active low), new set-point, fault reset.
const QUICK_STOP: u16 = 1 << 2;
const NEW_SET_POINT: u16 = 1 << 4;
const FAULT_RESET: u16 = 1 << 7;
/// Modes of operation.
const PROFILE_POSITION: i8 = 1;
const HOMING: i8 = 6;
/// Modes with a target in each cycle: interpolated position, and cyclic synchronous position, velocity, torque.
const CYCLIC: [i8; 4] = [7, 8, 9, 10];
/// Modes in which bit 13 is the following error.
const FOLLOWS: [i8; 3] = [PROFILE_POSITION, 7, 8];

/// Minimum time for which a bit has to be set to mean trouble, in ns: a single sample may be a transition.
const STANDS_NS: Ns = Ns::from_s(1);
/// Maximum time until a set-point is acknowledged, in ns; and the number of statuswords that have to show that it is
/// not.
const ACKNOWLEDGE_NS: Ns = Ns::from_ms(500);
const SAMPLES: u32 = 3;
/// Time in ns after which an axis that is commanded to be ready, but stays disabled, has a reason that no command
/// shows.
const ENABLE_NS: Ns = Ns::from_s(5);
/// Ratio to the period of targets from which on one is missing.
const MISSING: i64 = 3;
/// Ratio of the time without a target at the end of the capture from which on they have stopped.
const GONE: i64 = 10;

/// Number of axes of a node (CiA 402-1).
const AXES: usize = 8;

/// An axis of a node: its node-ID, and its number from 0.
type AxisKey = (u8, u8);

/// The known state of an axis.
#[derive(Clone, Debug, Default)]
struct AxisMotion {
    control: Option<u16>,
    /// True if controlwords come in a PDO, so that none is missing in a complete capture.
    by_pdo: bool,
    mode: Option<i8>,
    /// The first frame with a bit set that means trouble only if it stays set.
    limit: Option<FrameRef>,
    /// A set-point that waits for its acknowledgement, and the number of statuswords since.
    set_point: Option<(FrameRef, u32)>,
    /// True if it left Operation enabled against its command.
    left: bool,
    /// True if a fault reset came as an edge during the current fault.
    reset: bool,
    /// Fault resets without an edge: the first one and their number.
    held: Option<(FrameRef, u32)>,
    /// Beginning of the commands to be enabled; true if these include enable operation.
    upward: Option<(FrameRef, bool)>,
    /// Steps to Operation enabled that were commanded by SDO without effect, one bit each, and the first of them.
    vain: (u8, Option<FrameRef>),
    /// The statusword, the controlword and the mode with which nothing is open and nothing waits for its time: as long as
    /// they stay, reports change nothing.
    settled: Option<(u16, Option<u16>, Option<i8>)>,
    /// Its targets, while it needs one in each cycle.
    targets: Option<Targets>,
    open: Vec<(ProblemKind, LedgerPlace)>,
}

/// The targets of an axis: the last one, and their usual gap.
#[derive(Clone, Copy, Debug, Default)]
struct Targets {
    last: FrameRef,
    usual: UsualGap,
}

/// The axes of a bus.
#[derive(Clone, Debug, Default)]
pub(in crate::problems) struct Motions {
    axes: PerNode<[AxisMotion; AXES]>,
}

/// The steps to operation enabled: shutdown, switch on, enable operation.
const ALL_STEPS: u8 = 7;

/// Returns the step that a controlword commands, as a bit of [`ALL_STEPS`].
fn step(controlword: u16) -> Option<u8> {
    match controlword & 0x8F {
        0x06 => Some(1),
        0x07 => Some(2),
        0x0F => Some(4),
        _ => None,
    }
}

/// Ends an open request for the displayed mode of operation.
fn displayed(node: u8, mode: i8, scene: &mut Scene<'_>) {
    let waits = scene.ledger.last(scene.id, |one| {
        let asked = one.get("requested") == Some(Quantity::Mode(mode));
        one.kind == ProblemKind::ModeNotTaken && one.subject.node == Some(node) && one.end.is_none() && asked
    });
    if let Some(one) = waits.and_then(|place| scene.ledger.get_mut(place)) {
        one.step(scene.at, StepRole::Recovery, Saying::Recovered, None);
        one.ends(scene.at);
    }
}

impl Motions {
    /// Returns the state of an axis of a node that has one.
    #[inline]
    fn known(&mut self, (node, axis): AxisKey) -> Option<&mut AxisMotion> {
        self.axes.get_mut(node)?.get_mut(usize::from(axis))
    }

    /// Returns the state of an axis.
    #[inline]
    fn axis(&mut self, name: AxisKey) -> Option<&mut AxisMotion> {
        self.axes.entry(name.0).get_mut(usize::from(name.1))
    }

    /// Processes a PDO of a drive with a known mapping.
    pub(in crate::problems) fn pdo(&mut self, data: &ProcessData, frame: &Frame, scene: &mut Scene<'_>) {
        let (Signals::Mapped(mapping, _) | Signals::ByConsumer(mapping, ..)) = &data.content else { return };
        let mut target = None;
        // Commands precede reports; a PDO carries only one of them.
        for entry in &mapping.entries {
            let Some(axis) = drive::axis(entry.index) else { continue };
            let name = (data.node, axis);
            let object = first_axis(entry.index);
            if !data.transmit && matches!(object, 0x607A | 0x60C1 | 0x60FF | 0x6071) {
                target = Some(name);
                continue;
            }
            if !matches!(object, 0x6040 | 0x6060 | 0x6061) {
                continue;
            }
            if let Some(raw) = extract(frame.payload(), usize::from(entry.offset), usize::from(entry.bits)) {
                if let Some(axis) = self.axis(name) {
                    axis.by_pdo |= !data.transmit;
                }
                self.value(name, object, raw, scene);
            }
        }
        if let Some(name) = target {
            self.target(name, (data.transmit, data.number), scene);
        }
    }

    /// Processes a value that was read or written by SDO.
    pub(in crate::problems) fn transfer(&mut self, transfer: &Transfer, scene: &mut Scene<'_>) {
        let Some(mux) = transfer.mux.filter(|_| transfer.outcome.status == Status::Ok) else { return };
        let (Some(axis), object) = (drive::axis(mux.index), first_axis(mux.index)) else { return };
        let raw = match transfer.data.kept.as_slice() {
            [low] if matches!(object, 0x6060 | 0x6061) => u64::from(*low),
            [low, high] if object == 0x6040 => u64::from(u16::from_le_bytes([*low, *high])),
            _ => return,
        };
        self.value((transfer.node, axis), object, raw, scene);
    }

    /// Forgets the controlword while a client writes it.
    pub(in crate::problems) fn asked(&mut self, node: u8, index: u16) {
        if let Some(axis) = drive::axis(index).filter(|_| first_axis(index) == 0x6040)
            && let Some(axis) = self.known((node, axis))
        {
            axis.control = None;
        }
    }

    /// Forgets the axes of a node that booted or was lost, and ends their problems.
    pub(in crate::problems) fn booted(&mut self, node: u8, scene: &mut Scene<'_>) {
        for axis in self.axes.get_mut(node).into_iter().flatten() {
            for (_, place) in std::mem::take(axis).open {
                if let Some(one) = scene.ledger.get_mut(place) {
                    one.step(scene.at, StepRole::Recovery, Saying::Booted, None);
                    one.ends(scene.at);
                }
            }
        }
    }

    fn value(&mut self, name: AxisKey, object: u16, raw: u64, scene: &mut Scene<'_>) {
        match object {
            0x6040 => self.controlled(name, raw as u16, scene),
            _ => {
                let Some(axis) = self.axis(name) else { return };
                // The displayed mode counts; a requested one only before the first display.
                let mode = raw as u8 as i8;
                if object == 0x6061 || axis.mode.is_none() {
                    axis.mode = Some(mode);
                }
                if object == 0x6061 {
                    displayed(name.0, mode, scene);
                }
            }
        }
    }

    fn controlled(&mut self, name: AxisKey, word: u16, scene: &mut Scene<'_>) {
        let at = scene.at;
        let Some(axis) = self.axis(name) else { return };
        let before = axis.control.replace(word);
        let asks = word & (NEW_SET_POINT | FAULT_RESET) != 0;
        let state = asks.then(|| scene.bus.axis_state(name.0, name.1)).flatten();
        let rises = |bit: u16| word & bit != 0 && before.is_some_and(|before| before & bit == 0);
        if rises(NEW_SET_POINT) && axis.mode == Some(PROFILE_POSITION) && state == Some(DriveState::OperationEnabled) {
            axis.set_point = Some((at, 0));
        } else if word & NEW_SET_POINT == 0 {
            axis.set_point = None;
        }
        axis.upward = match (word & 0x8F, axis.upward) {
            (0x06 | 0x07 | 0x0F, upward) => {
                Some(upward.map_or((at, word & 0x8F == 0x0F), |(since, enable)| (since, enable || word & 0x8F == 0x0F)))
            }
            _ => None,
        };
        if step(word).is_none() {
            axis.vain = (0, None);
        }
        // A fault reset is a rising edge; a bit set since before the fault is none.
        let holds = word & FAULT_RESET != 0 && before.is_some_and(|before| before & FAULT_RESET != 0);
        axis.reset |= rises(FAULT_RESET) && state == Some(DriveState::Fault);
        if axis.reset || word & FAULT_RESET == 0 || state != Some(DriveState::Fault) {
            axis.held = None;
            self.set(name, ProblemKind::FaultResetWithoutEdge, false, at, scene);
        } else if holds {
            let (since, count) = axis.held.map_or((at, 1), |(since, count)| (since, count + 1));
            axis.held = Some((since, count));
            let long = at.since(since).is_some_and(|since| since >= STANDS_NS);
            if count >= SAMPLES && long {
                self.set(name, ProblemKind::FaultResetWithoutEdge, true, since, scene);
            }
        }
    }

    /// Processes a statusword.
    pub(in crate::problems) fn reported(&mut self, change: &Change, scene: &mut Scene<'_>) {
        let Change::Drive { node, axis, statusword: word, state: Some(state), previous, .. } = *change else { return };
        let (at, name, before) = (scene.at, (node, axis), previous.and_then(DriveState::of));
        let Some(axis) = self.axis(name) else { return };
        if axis.settled == Some((word, axis.control, axis.mode)) && axis.set_point.is_none() {
            axis.upward = None;
            return;
        }
        let enabled = state == DriveState::OperationEnabled;
        axis.reset &= state == DriveState::Fault;
        let held = axis.by_pdo && axis.control.is_some_and(|word| word & 0x8F == 0x0F);
        let down = matches!(state, DriveState::SwitchedOn | DriveState::ReadyToSwitchOn | DriveState::SwitchOnDisabled);
        // What the controller commands then is a reaction: it has left it until it is back.
        axis.left = down && (axis.left || held && before == Some(DriveState::OperationEnabled));
        let (left, mode) = (axis.left, axis.mode);
        let limit = enabled && word & LIMIT != 0;
        axis.limit = limit.then(|| axis.limit.unwrap_or(at));
        let limit_since = axis.limit;
        let limit = limit_since.filter(|since| at.since(*since).is_some_and(|since| since >= STANDS_NS));
        if !enabled || word & ACKNOWLEDGED != 0 {
            axis.set_point = None;
        }
        let ignored = axis.set_point.as_mut().and_then(|(since, samples)| {
            *samples += 1;
            let late = at.since(*since).is_some_and(|since| since >= ACKNOWLEDGE_NS);
            (late && *samples >= SAMPLES).then_some(*since)
        });
        // An axis that left that state starts anew.
        let stays = state == DriveState::SwitchOnDisabled;
        axis.upward = axis.upward.filter(|_| stays);
        let voltage = word & VOLTAGE != 0;
        // A client that has commanded each step by SDO and read the state shows it without a clock. PDOs must have
        // commanded each for longer than that takes.
        axis.vain = match axis.control.and_then(step) {
            _ if axis.by_pdo && axis.control.is_some_and(|word| word & ENABLE_VOLTAGE == 0) => (0, None),
            _ if state != DriveState::SwitchOnDisabled => (0, None),
            Some(step) => (axis.vain.0 | step, axis.vain.1.or(Some(at))),
            None => axis.vain,
        };
        let by_pdo = axis.by_pdo;
        let long = |since: FrameRef| at.since(since).is_some_and(|since| since >= ENABLE_NS);
        let vain = axis.vain.1.filter(|since| axis.vain.0 == ALL_STEPS && (!by_pdo || long(*since)));
        let told = axis.upward.filter(|(since, enable)| {
            let least = if *enable && !voltage { STANDS_NS } else { ENABLE_NS };
            (*enable || !voltage) && at.since(*since).is_some_and(|since| since >= least)
        });
        let open = axis.open.iter().any(|(kind, _)| *kind == ProblemKind::NotEnabled);
        let disabled = told.map(|(since, _)| since).or((open && stays).then_some(at)).or(vain);
        let control = axis.control;
        let error = |modes: &[i8]| enabled && word & ERROR != 0 && mode.is_some_and(|mode| modes.contains(&mode));
        let waits = left || limit_since.is_some() || axis.set_point.is_some() || axis.vain.1.is_some();
        let settles = before == Some(state) && !stays && !waits;
        if !enabled {
            axis.targets = None;
        }
        self.set(name, ProblemKind::FollowingError, error(&FOLLOWS), at, scene);
        self.set(name, ProblemKind::StateLeft, left, at, scene);
        self.set(name, ProblemKind::HomingFailed, error(&[HOMING]), at, scene);
        self.set(name, ProblemKind::InternalLimit, limit.is_some(), limit.unwrap_or(at), scene);
        self.set(name, ProblemKind::SetPointIgnored, ignored.is_some(), ignored.unwrap_or(at), scene);
        self.set(name, ProblemKind::NotEnabled, disabled.is_some(), disabled.unwrap_or(at), scene);
        let stopping = state == DriveState::QuickStopActive;
        if let Some(control) = control
            && (!stopping || before == Some(DriveState::OperationEnabled))
        {
            let commanded = stopping && control & QUICK_STOP == 0;
            self.set(name, ProblemKind::QuickStop, stopping, at, scene);
            if commanded && let Some(one) = self.opened(name, ProblemKind::QuickStop, scene) {
                one.fact("controlword", Quantity::Controlword(control));
            }
        }
        for kind in [
            ProblemKind::NotEnabled,
            ProblemKind::QuickStop,
            ProblemKind::FollowingError,
            ProblemKind::HomingFailed,
            ProblemKind::InternalLimit,
        ] {
            if let Some(one) = self.opened(name, kind, scene).filter(|one| !one.has("statusword")) {
                one.fact("statusword", Quantity::Statusword(word));
                one.step(at, StepRole::Sign, Saying::Reports { statusword: word }, None);
            }
        }
        if let Some(axis) = self.known(name) {
            axis.settled = Some((word, control, mode)).filter(|_| settles && axis.open.is_empty());
        }
    }

    /// Returns the open problem of a kind for an axis.
    fn opened<'a>(
        &mut self,
        name: AxisKey,
        kind: ProblemKind,
        scene: &'a mut Scene<'_>,
    ) -> Option<&'a mut crate::problems::problem::Problem> {
        let open = &self.known(name)?.open;
        let (_, place) = open.iter().find(|(other, _)| *other == kind)?;
        scene.ledger.get_mut(*place)
    }

    /// Opens or ends the problem of a kind for an axis; `since`: its beginning.
    fn set(&mut self, name: AxisKey, kind: ProblemKind, holds: bool, since: FrameRef, scene: &mut Scene<'_>) {
        let Some(axis) = self.known(name) else { return };
        let open = axis.open.iter().position(|(other, _)| *other == kind);
        match (open, holds) {
            (None, true) => {
                let (node, number) = name;
                let subject = Subject { axis: Some(number + 1), axes: 1 << number, ..Subject::node(node) };
                let again = scene.ledger.last(scene.id, |one| {
                    // An emergency reports the same without an axis.
                    let axis = one.subject.axes & 1 << number != 0 || one.subject.axes == 0;
                    let same = one.kind == kind && one.subject.node == Some(node) && axis;
                    same && (one.end.is_none() || one.ended_within(since, super::AGAIN_NS))
                });
                let place = again.or_else(|| scene.ledger.open(kind, scene.id, subject, since, scene.at));
                let Some(place) = place else { return };
                let watched = scene.watched(node).iter().map(|(node, time, _)| (*node, *time)).collect();
                axis.open.push((kind, place));
                let Some(one) = scene.ledger.get_mut(place) else { return };
                if again.is_some() && one.end.is_some() {
                    one.again(since);
                }
                one.clue.watched = watched;
                if kind == ProblemKind::InternalLimit {
                    one.grade = Grade::Likely;
                }
            }
            (Some(at), false) => {
                let (_, place) = axis.open.swap_remove(at);
                if let Some(one) = scene.ledger.get_mut(place) {
                    one.step(scene.at, StepRole::Recovery, Saying::Recovered, None);
                    one.ends(scene.at);
                }
            }
            _ => {}
        }
    }

    /// Records targets that have stopped although the axis is enabled, at the end of the capture.
    pub(in crate::problems) fn finish(&mut self, scene: &mut Scene<'_>) {
        let axes =
            self.axes.iter_mut().flat_map(|(node, axes)| (0..).zip(axes).map(move |(axis, one)| ((node, axis), one)));
        for (name, one) in axes.filter_map(|(name, axis)| Some((name, axis.targets.take()?))) {
            let rest = scene.at.since(one.last).unwrap_or(Ns::ZERO);
            let told = scene
                .ledger
                .last(scene.id, |other| other.kind == ProblemKind::TargetsLate && other.subject.node == Some(name.0));
            // A node that is not Operational is owed none, and an RPDO that has stopped is a problem of its own.
            let stopped = scene.ledger.last(scene.id, |other| {
                other.kind.is(KindRole::NoRpdo) && other.subject.concerns(name.0) && other.end.is_none()
            });
            // With its controller everything has stopped, or the capture ends.
            let controlled = scene.heard.control.since(one.last).unwrap_or(Ns::ZERO);
            if !one.usual.is_known()
                || controlled < one.usual.ns * GONE
                || stopped.is_some()
                || scene.bus.state(name.0).is_some_and(|state| state != OPERATIONAL)
                || rest < one.usual.ns * GONE
                || scene.heard.last(name.0).is_none_or(|last| last.no < one.last.no)
            {
                continue;
            }
            let subject = Subject { axis: Some(name.1 + 1), axes: 1 << name.1, ..Subject::node(name.0) };
            let place =
                told.or_else(|| scene.ledger.open(ProblemKind::TargetsLate, scene.id, subject, one.last, scene.at));
            if let Some(late) = place.and_then(|place| scene.ledger.get_mut(place)) {
                (late.end, late.clue.least) = (None, 1);
                late.step(one.last, StepRole::Sign, Saying::NoTarget { gap: rest, period: one.usual.ns }, None);
            }
        }
    }

    /// Processes a target of an axis.
    fn target(&mut self, name: AxisKey, pdo: (bool, u16), scene: &mut Scene<'_>) {
        let at = scene.at;
        let Some(axis) = self.known(name) else { return };
        let cyclic = axis.mode.is_some_and(|mode| CYCLIC.contains(&mode));
        if !cyclic || scene.bus.axis_state(name.0, name.1) != Some(DriveState::OperationEnabled) {
            axis.targets = None;
            return;
        }
        let one = axis.targets.get_or_insert_default();
        let last = std::mem::replace(&mut one.last, at);
        let Some(gap) = at.since(last).filter(|gap| last.no > 0 && *gap > Ns::ZERO) else { return };
        let period = one.usual.ns;
        // A recorder that was held back delivers many at once.
        if one.usual.is_known() && gap * MISSING < period {
            return;
        }
        if !one.usual.is_known() || gap < period * MISSING {
            return one.usual.learn(gap);
        }
        let again =
            scene.ledger.last(scene.id, |one| one.kind == ProblemKind::TargetsLate && one.subject.node == Some(name.0));
        let place = again.or_else(|| {
            let subject =
                Subject { pdo: Some(pdo), axis: Some(name.1 + 1), axes: 1 << name.1, ..Subject::node(name.0) };
            scene.ledger.open(ProblemKind::TargetsLate, scene.id, subject, last, at)
        });
        if let Some(one) = place.and_then(|place| scene.ledger.get_mut(place)) {
            if again.is_some() {
                one.again(last);
            }
            one.clue.least = SAMPLES.into();
            one.fact("period", Quantity::Ns(period));
            one.step(last, StepRole::Sign, Saying::NoTarget { gap, period }, None);
            one.ends(at);
        }
    }
}

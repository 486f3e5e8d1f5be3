//! Reports drive commands (CiA 402) that should lead out of a state and do not.

use super::{Axis, AxisPlace, PROMPT, Sample, controlword, elapsed};
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::rules::drive::Drv002;
use crate::rules::finding::Finding;
use crate::wire::error_control::OPERATIONAL;
use crate::world::context::Context;
use crate::world::drive::{self, DriveCommand, DriveState};

/// Time for a command that leads towards operation enabled, in ns: capacitors charge, brakes release; and for one that
/// brakes first (605Bh, 605Ch).
const SLOW: Ns = Ns::from_s(5);
/// The same for switching on, in ns: only the power stage is charged.
const SWITCH_ON: Ns = Ns::from_ms(1_500);

/// A command that should lead out of a state.
#[derive(Clone, Copy, Debug)]
pub(super) struct PendingOrder {
    pub(super) word: u16,
    pub(super) command: DriveCommand,
    pub(super) from: DriveState,
    pub(super) at: FrameRef,
    /// Number of reports of that state since then.
    pub(super) reports: u8,
    /// True if a change would be reported at once: the statusword is sent by events alone.
    pub(super) reported_at_once: bool,
}

impl PendingOrder {
    /// Returns true if it leads towards operation enabled.
    fn is_upward(self) -> bool {
        matches!(self.command, DriveCommand::SwitchOn | DriveCommand::EnableOperation)
            || (self.command == DriveCommand::Shutdown && self.from == DriveState::SwitchOnDisabled)
    }

    /// Returns the time at which its effect is due, in ns, if that would be reported at once.
    pub(super) fn due_ns(self) -> Option<Ns> {
        self.at.t_ns.filter(|_| self.reported_at_once).map(|at| at + self.limit_ns())
    }

    /// Returns the time after which the state must have changed, in ns.
    fn limit_ns(self) -> Ns {
        let brakes = self.from == DriveState::OperationEnabled
            && !matches!(self.command, DriveCommand::DisableVoltage | DriveCommand::QuickStop);
        match self.command {
            DriveCommand::SwitchOn => SWITCH_ON,
            _ if brakes || self.is_upward() => SLOW,
            _ => PROMPT,
        }
    }
}

impl Axis {
    /// Judges the effect of the last command.
    pub(super) fn effect(&mut self, place: AxisPlace<'_>, sample: Sample, cx: &mut Context<'_>) {
        let Some(order) = &mut self.order else { return };
        order.reports = order.reports.saturating_add(1);
        let order = *order;
        // Operated locally, no supply, or PDOs not received.
        let excused = !drive::remote(sample.word)
            || (order.is_upward() && !voltage_enabled(sample.word))
            || place.state.is_some_and(|state| state != OPERATIONAL);
        if sample.state != order.from || excused {
            self.order = None;
            return;
        }
        let limit_ns = order.limit_ns();
        let Some(after) = elapsed(order.at.t_ns, sample.at.t_ns).filter(|after| *after > limit_ns) else { return };
        if order.reports < 2 {
            return;
        }
        self.order = None;
        if !self.is_drive(place) {
            return;
        }
        self.still_in(order, (place.node.id(), place.axis), (sample.word, after), cx);
    }

    /// Judges a command by a statusword that has not come: it is sent when it changes, and the node goes on.
    pub(super) fn unchanged(&mut self, of: (u8, u8), now_ns: Ns, cx: &mut Context<'_>) {
        let Some((order, sample)) = self.order.zip(self.sample) else { return };
        let after = elapsed(order.at.t_ns, Some(now_ns)).filter(|after| *after > order.limit_ns());
        let Some(after) = after.filter(|_| order.reported_at_once && sample.state == order.from) else { return };
        self.order = None;
        if drive::remote(sample.word) && (!order.is_upward() || voltage_enabled(sample.word)) {
            self.still_in(order, of, (sample.word, after), cx);
        }
    }

    fn still_in(
        &mut self,
        order: PendingOrder,
        (node, axis): (u8, u8),
        (statusword, after): (u16, Ns),
        cx: &mut Context<'_>,
    ) {
        let what = Drv002::StillIn { controlword: order.word, statusword, after };
        let finding = cx.verdict(what, Some(node), Some(controlword(axis)), Some(order.at));
        // The cause of the fault remains, so failed resets after the first follow from it.
        let because_of = self.vain.filter(|_| order.command == DriveCommand::FaultReset);
        if order.command == DriveCommand::FaultReset {
            self.vain = because_of.or(Some(order.at));
        }
        cx.report(Finding { because_of, ..finding });
    }
}

/// Returns bit 4 of the statusword.
const fn voltage_enabled(statusword: u16) -> bool {
    statusword & 1 << 4 != 0
}

/// Returns true if a drive without a fault must leave a state by a command. A fault reset without effect counts, too.
/// Excluded are commands that not every drive obeys (enable operation out of quick stop or ready to switch on, quick stop at
/// standstill).
pub(super) const fn leads_out(state: DriveState, command: DriveCommand) -> bool {
    matches!(
        (state, command),
        (DriveState::Fault, DriveCommand::FaultReset)
            | (
                DriveState::SwitchOnDisabled | DriveState::SwitchedOn | DriveState::OperationEnabled,
                DriveCommand::Shutdown
            )
            | (DriveState::OperationEnabled, DriveCommand::DisableOperation | DriveCommand::SwitchOnOrDisableOperation)
            | (DriveState::ReadyToSwitchOn, DriveCommand::SwitchOn)
            | (DriveState::SwitchedOn, DriveCommand::EnableOperation)
            | (DriveState::OperationEnabled, DriveCommand::QuickStop)
            | (
                DriveState::ReadyToSwitchOn | DriveState::SwitchedOn | DriveState::OperationEnabled,
                DriveCommand::DisableVoltage
            )
    )
}

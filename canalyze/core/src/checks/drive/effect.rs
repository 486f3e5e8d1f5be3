//! Reports drive commands (CiA 402) that should lead out of a state and do not.

use super::{Axis, AxisPlace, PROMPT, Sample, controlword, elapsed};
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::rules::drive::Drv002;
use crate::rules::finding::Finding;
use crate::wire::error_control::OPERATIONAL;
use crate::world::context::Context;
use crate::world::drive::{self, DriveCommand, DriveState};

/// Time for a command that leads towards operation enabled, in ns: capacitors charge, brakes release.
const UPWARD: Ns = Ns::from_s(5);
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
}

impl Axis {
    /// Judges the effect of the last command.
    pub(super) fn effect(&mut self, place: AxisPlace<'_>, sample: Sample, cx: &mut Context<'_>) {
        let Some(order) = &mut self.order else { return };
        order.reports = order.reports.saturating_add(1);
        let order = *order;
        let upward = matches!(order.command, DriveCommand::SwitchOn | DriveCommand::EnableOperation)
            || (order.command == DriveCommand::Shutdown && order.from == DriveState::SwitchOnDisabled);
        // Operated locally, no supply, or PDOs not received.
        let excused = !drive::remote(sample.word)
            || (upward && !voltage_enabled(sample.word))
            || place.state.is_some_and(|state| state != OPERATIONAL);
        if sample.state != order.from || excused {
            self.order = None;
            return;
        }
        let least = match order.command {
            DriveCommand::SwitchOn => SWITCH_ON,
            _ if upward => UPWARD,
            _ => PROMPT,
        };
        let Some(after) = elapsed(order.at.t_ns, sample.at.t_ns).filter(|after| *after > least) else { return };
        if order.reports < 2 {
            return;
        }
        self.order = None;
        if !self.is_drive(place) {
            return;
        }
        let what = Drv002::StillIn { controlword: order.word, statusword: sample.word, after };
        let finding = cx.verdict(what, Some(place.node.id()), Some(controlword(place.axis)), Some(order.at));
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
/// Excluded are commands that brake first (shutdown and disable operation by 605Bh and 605Ch) and those that not every
/// drive obeys (enable operation out of quick stop or ready to switch on, quick stop at standstill).
pub(super) const fn leads_out(state: DriveState, command: DriveCommand) -> bool {
    matches!(
        (state, command),
        (DriveState::Fault, DriveCommand::FaultReset)
            | (DriveState::SwitchOnDisabled | DriveState::SwitchedOn, DriveCommand::Shutdown)
            | (DriveState::ReadyToSwitchOn, DriveCommand::SwitchOn)
            | (DriveState::SwitchedOn, DriveCommand::EnableOperation)
            | (DriveState::OperationEnabled, DriveCommand::QuickStop)
            | (
                DriveState::ReadyToSwitchOn | DriveState::SwitchedOn | DriveState::OperationEnabled,
                DriveCommand::DisableVoltage
            )
    )
}

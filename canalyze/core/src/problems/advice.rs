//! The first things to check, by the facts of the capture and not by a list for each kind.

use super::kinds::ProblemKind;
use super::problem::{Grade, Problem, Status};
use super::sayings::{self as say, Check};
use crate::checks::pdo::configuration::pdo_parameter;
use crate::rules::finding::{Code, Quantity};
use crate::sdo::abort_code::AbortCode;

/// The facts of the whole capture that advice depends on.
#[derive(Clone, Copy, Debug, Default)]
pub struct AdviceFacts {
    /// True if it has error frames.
    pub error_frames: bool,
    /// Number of nodes seen.
    pub nodes: u32,
}

/// Emergency error codes of too high a voltage, without their last digit (CiA 402-2: mains, DC link).
const OVER: [u16; 2] = [0x3110, 0x3210];
/// Bit of the statusword: voltage enabled (CiA 402-2).
const VOLTAGE: u16 = 1 << 4;

/// Returns true for an abort because of the state of the device.
fn is_state(code: AbortCode) -> bool {
    (0x0800_0020..=0x0800_0022).contains(&code.meaning())
}

/// Returns true if a transfer was aborted with such a code.
fn aborted(one: &Problem, such: fn(AbortCode) -> bool) -> bool {
    matches!(one.get("abort"), Some(Quantity::Abort(code)) if such(code))
}

/// Returns the things to check, the first one first.
pub fn of(one: &Problem, shown: AdviceFacts) -> Vec<Check> {
    if one.status == Status::Harmless {
        return vec![if one.kind == ProblemKind::CaptureGap { say::RECORDER } else { say::NOTHING }];
    }
    if one.cause.is_some_and(|link| link.grade >= Grade::Likely) {
        let mut checks = vec![say::CAUSE];
        if one.has("left_operational") {
            checks.push(say::ERROR_BEHAVIOUR);
        }
        return checks;
    }
    let boot_up = one.has("boot_up");
    let wires = if shown.error_frames { say::WIRING } else { say::ERROR_FRAMES_OFF };
    match one.kind {
        ProblemKind::NodeSilent if one.clue.controller && one.end.is_none() => vec![say::HOST, say::NO_SIGN, wires],
        ProblemKind::NodeSilent | ProblemKind::GuardingUnanswered | ProblemKind::NodeAbsent | ProblemKind::NoBootUp => {
            match (boot_up, one.end) {
                (true, _) => vec![say::SUPPLY, say::WATCHDOG],
                (false, _) if one.has("left_operational") => vec![say::CONNECTOR, say::SUPPLY, say::FELL_BACK, wires],
                (false, Some(_)) if one.kind == ProblemKind::NodeSilent => vec![say::CONNECTOR, say::CABLE_ONLY, wires],
                (false, Some(_)) => vec![say::SERVER, say::CONNECTOR, wires],
                (false, None) if one.kind != ProblemKind::NodeSilent => {
                    vec![say::SUPPLY, say::CONNECTOR, say::LEDS, wires]
                }
                (false, None) => vec![say::SUPPLY, say::CONNECTOR, say::LEDS, say::NO_SIGN, wires],
            }
        }
        ProblemKind::SegmentLost if boot_up => vec![say::SUPPLY, say::SEGMENT],
        ProblemKind::SegmentLost => vec![say::SEGMENT, wires],
        ProblemKind::HeartbeatStopped => vec![say::FIRMWARE],
        ProblemKind::NodeRestarted if one.has("waits_to_be_started") => {
            vec![say::SUPPLY, say::WATCHDOG, say::MASTER_BOOT]
        }
        ProblemKind::NodeRestarted | ProblemKind::RestartLoop => vec![say::SUPPLY, say::WATCHDOG],
        ProblemKind::LeftOperational => vec![say::ERROR_BEHAVIOUR],
        ProblemKind::StartWithoutEffect => vec![say::STATE],
        ProblemKind::WatchedAbsent => vec![say::UNHEARD],
        ProblemKind::MuteAfterBoot => vec![say::PRODUCER_TIME, say::FIRMWARE],
        ProblemKind::ResetAgain => vec![say::MASTER_BOOT],
        ProblemKind::AnotherDevice => vec![say::DEVICE],
        ProblemKind::AnswerElsewhere => vec![say::SDO_PARAMETER],
        ProblemKind::ReadInVain if aborted(one, |code| code.meaning() == 0x0606_0000) => vec![say::MANUAL],
        ProblemKind::ReadInVain => vec![say::EDS],
        ProblemKind::RpdoStopped => vec![say::CONTROL_PROGRAM],
        ProblemKind::NotTaken => vec![say::COB_IDS],
        ProblemKind::HeartbeatConsumerError => vec![say::WATCHED],
        ProblemKind::ConsumerTimeTooShort => vec![say::CONSUMER_TIME],
        ProblemKind::GuardingStopped => vec![say::MASTER],
        ProblemKind::DuplicateNodeId => vec![say::NODE_ID],
        ProblemKind::RequestUnanswered if one.findings.first().is_some_and(|cited| cited.code == Code::Sdo011) => {
            vec![say::STATE]
        }
        ProblemKind::RequestUnanswered | ProblemKind::LateAnswer => vec![say::SERVER, say::CLIENT],
        ProblemKind::ObjectRefused | ProblemKind::IdentityMismatch | ProblemKind::LengthRefused => vec![say::EDS],
        ProblemKind::MappingRefused if one.has("others") => vec![say::EDS, say::MAPPING],
        ProblemKind::MappingRefused => vec![match one.get("abort") {
            Some(Quantity::Abort(code)) => match code.meaning() {
                0x0601_0000..=0x0601_00FF => say::MAPPING_FIXED,
                0x0604_0041 => say::MAPPABLE,
                0x0604_0042 => say::PDO_SIZE,
                0x0800_0020..=0x0800_0022 => say::STATE,
                _ => say::PDO_ORDER,
            },
            _ => say::PDO_ORDER,
        }],
        ProblemKind::WriteRefused if aborted(one, AbortCode::is_violation) => vec![say::SDO_PROTOCOL],
        ProblemKind::WriteRefused if aborted(one, AbortCode::is_busy) => vec![say::SERVER],
        ProblemKind::AccessRefused
        | ProblemKind::StateRefused
        | ProblemKind::ValueRefused
        | ProblemKind::WriteRefused => {
            vec![say::STATE, say::EDS]
        }
        ProblemKind::SharedCobId if one.has("alternates") => vec![say::OTHER_MASTER],
        ProblemKind::SharedCobId => vec![say::MAPPING],
        ProblemKind::RpdoTimeout => vec![say::PRODUCER],
        ProblemKind::PdoConfiguration if one.object().is_none_or(|mux| pdo_parameter(mux.index).is_none()) => {
            vec![say::EDS]
        }
        ProblemKind::PdoNotAllowed if one.findings.iter().any(|cited| cited.code == Code::Pdo002) => {
            vec![say::PDO_STATE]
        }
        ProblemKind::PdoLength | ProblemKind::PdoConfiguration | ProblemKind::PdoNotAllowed => vec![say::MAPPING],
        ProblemKind::PdoMissing => vec![say::STATE, say::MAPPING],
        ProblemKind::SyncIrregular if one.subject.pdo.is_some() => vec![say::EVENT_RATE],
        ProblemKind::SyncStopped
        | ProblemKind::SyncIrregular
        | ProblemKind::TwoSyncProducers
        | ProblemKind::SyncLength => vec![say::SYNC_PRODUCER],
        ProblemKind::NotAcknowledged => vec![say::NO_ACK, say::TERMINATION],
        ProblemKind::BusOff
        | ProblemKind::ErrorPassive
        | ProblemKind::BusErrors
        | ProblemKind::TransceiverFault
        | ProblemKind::WrongBitRate
        | ProblemKind::BusTrouble => vec![say::TERMINATION],
        ProblemKind::AxisFault | ProblemKind::DeviceError => {
            let unannounced = one.clue.reported.is_empty() && one.subject.axes.count_ones() > 1;
            let mut checks = vec![if unannounced { say::ALL_AXES } else { say::MANUAL }];
            if one.has("reset_in_vain") {
                checks.push(say::FAULT_CAUSE);
            }
            checks
        }
        ProblemKind::FaultResetWithoutEffect => vec![say::FAULT_CAUSE],
        ProblemKind::FaultResetWithoutEdge => vec![say::EDGE],
        ProblemKind::NotStarted | ProblemKind::BootStuck => vec![say::MASTER_BOOT],
        ProblemKind::TwoMasters | ProblemKind::TwoClients => vec![say::OTHER_MASTER],
        ProblemKind::Flood => vec![say::EVENT_RATE],
        ProblemKind::Overload => vec![say::LOAD, say::EVENT_RATE],
        ProblemKind::PdoMultiplied => vec![say::REPEATED_START],
        ProblemKind::CommandsNotTaken => vec![say::STATE],
        ProblemKind::HalfConfigured => vec![say::EDS, say::STATE],
        ProblemKind::StoreFailed if aborted(one, is_state) => vec![say::STATE],
        ProblemKind::StoreFailed => vec![say::SIGNATURE],
        ProblemKind::ProgramFailed => vec![say::PROGRAM],
        ProblemKind::FollowingError | ProblemKind::InternalLimit => vec![say::MECHANICS],
        ProblemKind::HomingFailed => vec![say::HOMING],
        ProblemKind::SetPointIgnored => vec![say::SET_POINT],
        ProblemKind::TargetsLate => vec![say::CYCLE, say::LOAD],
        ProblemKind::Temperature => vec![say::COOLING],
        ProblemKind::SupplyVoltage if one.clue.reported.iter().any(|code| OVER.contains(&(code & 0xFFF0))) => {
            vec![say::OVERVOLTAGE]
        }
        ProblemKind::SupplyVoltage => vec![say::MAINS],
        ProblemKind::ModuleFailed => vec![say::IO_MODULE],
        ProblemKind::RegisterWithoutEmcy => vec![say::MANUAL],
        ProblemKind::ModeNotTaken => vec![say::STATE],
        ProblemKind::NotEnabled => match one.get("statusword") {
            Some(Quantity::Statusword(word)) if word & VOLTAGE != 0 => vec![say::STEPS, say::POWER_STAGE],
            Some(_) => vec![say::POWER_STAGE],
            None => vec![say::ENABLE],
        },
        ProblemKind::QuickStop | ProblemKind::StateLeft => vec![say::ENABLE],
        ProblemKind::Overrun | ProblemKind::HeartbeatIrregular | ProblemKind::InhibitTime | ProblemKind::EmcyFlood => {
            vec![say::LOAD]
        }
        _ => Vec::new(),
    }
}

//! The first things to check, by the facts of the capture and not by a list for each kind.

use super::incident::{Grade, Incident, Status};
use super::kinds::IncidentKind;
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
fn aborted(one: &Incident, such: fn(AbortCode) -> bool) -> bool {
    matches!(one.get("abort"), Some(Quantity::Abort(code)) if such(code))
}

/// Returns the things to check, the first one first.
pub fn of(one: &Incident, shown: AdviceFacts) -> Vec<Check> {
    if one.status == Status::Harmless {
        return vec![if one.kind == IncidentKind::CaptureGap { say::RECORDER } else { say::NOTHING }];
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
        IncidentKind::NodeSilent if one.clue.controller && one.end.is_none() => vec![say::HOST, say::NO_SIGN, wires],
        IncidentKind::NodeSilent
        | IncidentKind::GuardingUnanswered
        | IncidentKind::NodeAbsent
        | IncidentKind::NoBootUp => match (boot_up, one.end) {
            (true, _) => vec![say::SUPPLY, say::WATCHDOG],
            (false, _) if one.has("left_operational") => vec![say::CONNECTOR, say::SUPPLY, say::FELL_BACK, wires],
            (false, Some(_)) if one.kind == IncidentKind::NodeSilent => vec![say::CONNECTOR, say::CABLE_ONLY, wires],
            (false, Some(_)) => vec![say::SERVER, say::CONNECTOR, wires],
            (false, None) if one.kind != IncidentKind::NodeSilent => {
                vec![say::SUPPLY, say::CONNECTOR, say::LEDS, wires]
            }
            (false, None) => vec![say::SUPPLY, say::CONNECTOR, say::LEDS, say::NO_SIGN, wires],
        },
        IncidentKind::SegmentLost if boot_up => vec![say::SUPPLY, say::SEGMENT],
        IncidentKind::SegmentLost => vec![say::SEGMENT, wires],
        IncidentKind::HeartbeatStopped => vec![say::FIRMWARE],
        IncidentKind::NodeRestarted if one.has("waits_to_be_started") => {
            vec![say::SUPPLY, say::WATCHDOG, say::MASTER_BOOT]
        }
        IncidentKind::NodeRestarted | IncidentKind::RestartLoop => vec![say::SUPPLY, say::WATCHDOG],
        IncidentKind::LeftOperational => vec![say::ERROR_BEHAVIOUR],
        IncidentKind::StartWithoutEffect => vec![say::STATE],
        IncidentKind::WatchedAbsent => vec![say::UNHEARD],
        IncidentKind::MuteAfterBoot => vec![say::PRODUCER_TIME, say::FIRMWARE],
        IncidentKind::ResetAgain => vec![say::MASTER_BOOT],
        IncidentKind::AnotherDevice => vec![say::DEVICE],
        IncidentKind::AnswerElsewhere => vec![say::SDO_PARAMETER],
        IncidentKind::ReadInVain if aborted(one, |code| code.meaning() == 0x0606_0000) => vec![say::MANUAL],
        IncidentKind::ReadInVain => vec![say::EDS],
        IncidentKind::RpdoStopped => vec![say::CONTROL_PROGRAM],
        IncidentKind::NotTaken => vec![say::COB_IDS],
        IncidentKind::HeartbeatConsumerError => vec![say::WATCHED],
        IncidentKind::ConsumerTimeTooShort => vec![say::CONSUMER_TIME],
        IncidentKind::GuardingStopped => vec![say::MASTER],
        IncidentKind::DuplicateNodeId => vec![say::NODE_ID],
        IncidentKind::RequestUnanswered if one.findings.first().is_some_and(|cited| cited.code == Code::Sdo011) => {
            vec![say::STATE]
        }
        IncidentKind::RequestUnanswered | IncidentKind::LateAnswer => vec![say::SERVER, say::CLIENT],
        IncidentKind::ObjectRefused | IncidentKind::IdentityMismatch | IncidentKind::LengthRefused => vec![say::EDS],
        IncidentKind::MappingRefused if one.has("others") => vec![say::EDS, say::MAPPING],
        IncidentKind::MappingRefused => vec![match one.get("abort") {
            Some(Quantity::Abort(code)) => match code.meaning() {
                0x0601_0000..=0x0601_00FF => say::MAPPING_FIXED,
                0x0604_0041 => say::MAPPABLE,
                0x0604_0042 => say::PDO_SIZE,
                0x0800_0020..=0x0800_0022 => say::STATE,
                _ => say::PDO_ORDER,
            },
            _ => say::PDO_ORDER,
        }],
        IncidentKind::WriteRefused if aborted(one, AbortCode::is_violation) => vec![say::SDO_PROTOCOL],
        IncidentKind::WriteRefused if aborted(one, AbortCode::is_busy) => vec![say::SERVER],
        IncidentKind::AccessRefused
        | IncidentKind::StateRefused
        | IncidentKind::ValueRefused
        | IncidentKind::WriteRefused => {
            vec![say::STATE, say::EDS]
        }
        IncidentKind::SharedCobId if one.has("alternates") => vec![say::OTHER_MASTER],
        IncidentKind::SharedCobId => vec![say::MAPPING],
        IncidentKind::RpdoTimeout => vec![say::PRODUCER],
        IncidentKind::PdoConfiguration if one.object().is_none_or(|mux| pdo_parameter(mux.index).is_none()) => {
            vec![say::EDS]
        }
        IncidentKind::PdoNotAllowed if one.findings.iter().any(|cited| cited.code == Code::Pdo002) => {
            vec![say::PDO_STATE]
        }
        IncidentKind::PdoLength | IncidentKind::PdoConfiguration | IncidentKind::PdoNotAllowed => vec![say::MAPPING],
        IncidentKind::PdoMissing => vec![say::STATE, say::MAPPING],
        IncidentKind::SyncIrregular if one.subject.pdo.is_some() => vec![say::EVENT_RATE],
        IncidentKind::SyncStopped
        | IncidentKind::SyncIrregular
        | IncidentKind::TwoSyncProducers
        | IncidentKind::SyncLength => vec![say::SYNC_PRODUCER],
        IncidentKind::NotAcknowledged => vec![say::NO_ACK, say::TERMINATION],
        IncidentKind::BusOff
        | IncidentKind::ErrorPassive
        | IncidentKind::BusErrors
        | IncidentKind::TransceiverFault
        | IncidentKind::WrongBitRate
        | IncidentKind::BusTrouble => vec![say::TERMINATION],
        IncidentKind::AxisFault | IncidentKind::DeviceError => {
            let unannounced = one.clue.reported.is_empty() && one.subject.axes.count_ones() > 1;
            let mut checks = vec![if unannounced { say::ALL_AXES } else { say::MANUAL }];
            if one.has("reset_in_vain") {
                checks.push(say::FAULT_CAUSE);
            }
            checks
        }
        IncidentKind::FaultResetWithoutEffect => vec![say::FAULT_CAUSE],
        IncidentKind::FaultResetWithoutEdge => vec![say::EDGE],
        IncidentKind::NotStarted | IncidentKind::BootStuck => vec![say::MASTER_BOOT],
        IncidentKind::TwoMasters | IncidentKind::TwoClients => vec![say::OTHER_MASTER],
        IncidentKind::Flood => vec![say::EVENT_RATE],
        IncidentKind::Overload => vec![say::LOAD, say::EVENT_RATE],
        IncidentKind::PdoMultiplied => vec![say::REPEATED_START],
        IncidentKind::CommandsNotTaken => vec![say::STATE],
        IncidentKind::HalfConfigured => vec![say::EDS, say::STATE],
        IncidentKind::StoreFailed if aborted(one, is_state) => vec![say::STATE],
        IncidentKind::StoreFailed => vec![say::SIGNATURE],
        IncidentKind::ProgramFailed => vec![say::PROGRAM],
        IncidentKind::FollowingError | IncidentKind::InternalLimit => vec![say::MECHANICS],
        IncidentKind::HomingFailed => vec![say::HOMING],
        IncidentKind::SetPointIgnored => vec![say::SET_POINT],
        IncidentKind::TargetsLate => vec![say::CYCLE, say::LOAD],
        IncidentKind::Temperature => vec![say::COOLING],
        IncidentKind::SupplyVoltage if one.clue.reported.iter().any(|code| OVER.contains(&(code & 0xFFF0))) => {
            vec![say::OVERVOLTAGE]
        }
        IncidentKind::SupplyVoltage => vec![say::MAINS],
        IncidentKind::ModuleFailed => vec![say::IO_MODULE],
        IncidentKind::RegisterWithoutEmcy => vec![say::MANUAL],
        IncidentKind::ModeNotTaken => vec![say::STATE],
        IncidentKind::NotEnabled => match one.get("statusword") {
            Some(Quantity::Statusword(word)) if word & VOLTAGE != 0 => vec![say::STEPS, say::POWER_STAGE],
            Some(_) => vec![say::POWER_STAGE],
            None => vec![say::ENABLE],
        },
        IncidentKind::QuickStop | IncidentKind::StateLeft => vec![say::ENABLE],
        IncidentKind::Overrun
        | IncidentKind::HeartbeatIrregular
        | IncidentKind::InhibitTime
        | IncidentKind::EmcyFlood => vec![say::LOAD],
        _ => Vec::new(),
    }
}

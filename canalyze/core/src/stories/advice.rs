//! The first things to check, by the facts of the capture and not by a list for each kind.

use super::incident::{Grade, Incident, Status};
use super::kinds::Kind;
use super::sayings::{self as say, Check};

/// The facts of the whole capture that advice depends on.
#[derive(Clone, Copy, Debug, Default)]
pub struct Shown {
    /// True if it has error frames.
    pub error_frames: bool,
}

/// Returns the things to check, the first one first.
pub fn of(one: &Incident, shown: Shown) -> Vec<Check> {
    if one.status == Status::Harmless {
        return vec![if one.kind == Kind::CaptureGap { say::RECORDER } else { say::NOTHING }];
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
        Kind::NodeSilent if one.clue.controller && one.end.is_none() => vec![say::HOST, say::NO_SIGN, wires],
        Kind::NodeSilent | Kind::GuardingUnanswered | Kind::NodeAbsent | Kind::NoBootUp => match (boot_up, one.end) {
            (true, _) => vec![say::SUPPLY, say::WATCHDOG],
            (false, _) if one.has("left_operational") => vec![say::CONNECTOR, say::SUPPLY, say::FELL_BACK, wires],
            (false, Some(_)) => vec![say::CONNECTOR, say::CABLE_ONLY, wires],
            (false, None) => vec![say::SUPPLY, say::CONNECTOR, say::LEDS, say::NO_SIGN, wires],
        },
        Kind::SegmentLost if boot_up => vec![say::SUPPLY, say::SEGMENT],
        Kind::SegmentLost => vec![say::SEGMENT, wires],
        Kind::HeartbeatStopped => vec![say::FIRMWARE],
        Kind::NodeRestarted if one.has("waits_to_be_started") => vec![say::SUPPLY, say::WATCHDOG, say::MASTER_BOOT],
        Kind::NodeRestarted | Kind::RestartLoop => vec![say::SUPPLY, say::WATCHDOG],
        Kind::LeftOperational => vec![say::ERROR_BEHAVIOUR],
        Kind::StartWithoutEffect => vec![say::STATE],
        Kind::WatchedAbsent => vec![say::UNHEARD],
        Kind::HeartbeatConsumerError => vec![say::WATCHED],
        Kind::ConsumerTimeTooShort => vec![say::CONSUMER_TIME],
        Kind::GuardingStopped => vec![say::MASTER],
        Kind::DuplicateNodeId => vec![say::NODE_ID],
        Kind::RequestUnanswered | Kind::LateAnswer => vec![say::SERVER, say::CLIENT],
        Kind::ObjectRefused | Kind::IdentityMismatch | Kind::LengthRefused => vec![say::EDS],
        Kind::MappingRefused if one.has("others") => vec![say::EDS, say::MAPPING],
        Kind::MappingRefused => vec![say::PDO_ORDER],
        Kind::AccessRefused | Kind::StateRefused | Kind::ValueRefused | Kind::WriteRefused => {
            vec![say::STATE, say::EDS]
        }
        Kind::RpdoTimeout => vec![say::PRODUCER],
        Kind::PdoLength | Kind::SharedCobId | Kind::PdoConfiguration | Kind::PdoNotAllowed => vec![say::MAPPING],
        Kind::PdoMissing => vec![say::STATE, say::MAPPING],
        Kind::SyncStopped | Kind::SyncIrregular | Kind::TwoSyncProducers | Kind::SyncLength => vec![say::SYNC_PRODUCER],
        Kind::BusOff
        | Kind::ErrorPassive
        | Kind::BusErrors
        | Kind::NotAcknowledged
        | Kind::TransceiverFault
        | Kind::WrongBitRate
        | Kind::BusTrouble => vec![say::TERMINATION],
        Kind::AxisFault | Kind::DeviceError => {
            let unannounced = one.clue.reported.is_empty() && one.subject.axes.count_ones() > 1;
            let mut checks = vec![if unannounced { say::ALL_AXES } else { say::MANUAL }];
            if one.has("reset_in_vain") {
                checks.push(say::FAULT_CAUSE);
            }
            checks
        }
        Kind::FaultResetWithoutEffect => vec![say::FAULT_CAUSE],
        Kind::FaultResetWithoutEdge => vec![say::EDGE],
        Kind::NotStarted | Kind::BootStuck => vec![say::MASTER_BOOT],
        Kind::TwoMasters | Kind::TwoClients => vec![say::OTHER_MASTER],
        Kind::Flood => vec![say::EVENT_RATE],
        Kind::Overload => vec![say::LOAD, say::EVENT_RATE],
        Kind::PdoMultiplied => vec![say::REPEATED_START],
        Kind::CommandsNotTaken => vec![say::STATE],
        Kind::HalfConfigured => vec![say::EDS, say::STATE],
        Kind::StoreFailed => vec![say::SIGNATURE],
        Kind::ProgramFailed => vec![say::PROGRAM],
        Kind::FollowingError | Kind::InternalLimit => vec![say::MECHANICS],
        Kind::HomingFailed => vec![say::HOMING],
        Kind::SetPointIgnored => vec![say::SET_POINT],
        Kind::TargetsLate => vec![say::CYCLE, say::LOAD],
        Kind::Temperature => vec![say::COOLING],
        Kind::SupplyVoltage => vec![say::MAINS],
        Kind::ModuleFailed => vec![say::IO_MODULE],
        Kind::RegisterWithoutEmcy => vec![say::MANUAL],
        Kind::ModeNotTaken => vec![say::STATE],
        Kind::NotEnabled if one.has("statusword") => vec![say::POWER_STAGE],
        Kind::NotEnabled | Kind::QuickStop | Kind::StateLeft => vec![say::ENABLE],
        Kind::Overrun | Kind::HeartbeatIrregular | Kind::InhibitTime | Kind::EmcyFlood => vec![say::LOAD],
        _ => Vec::new(),
    }
}

//! The findings that are problems by themselves, one row for each rule.
//!
//! Lost and restarting nodes, emergencies and drives in fault have trackers of their own. Findings of rules without a
//! row are worth knowing, but nothing went wrong.

use super::kinds::ProblemKind;
use crate::rules::Code;

/// The sign that ends a problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ends {
    /// Ends at once each time; continues if it recurs.
    Once,
    /// No known sign.
    Never,
    /// A frame of the node.
    Heard,
    /// A boot-up, heartbeat or guarding answer of the node.
    Controlled,
    /// An answer of the server.
    Answered,
    /// A successful transfer of the node.
    Transferred,
    /// A write to the same object.
    Written,
    /// A SYNC.
    Sync,
    /// The PDO.
    Pdo,
    /// The PDO with the length of its mapping.
    Length,
    /// The PDO with the length that it had before.
    Former,
    /// An active controller.
    Controller,
    /// An active controller or any frame, since a controller that is off receives none.
    Traffic,
    /// A positive answer of an LSS slave.
    Lss,
    /// A boot-up, the state Operational, or a guarding request.
    Guarded,
    /// The state Operational, or that the PDO is no longer sent.
    Operational,
}

/// A rule, its kind of problem, the number of findings from which it counts, and its end.
pub(super) type SignRow = (Code, ProblemKind, u64, Ends);

/// The rows. Problems that one late frame may cause count from the third time on.
pub(super) const SIGNS: &[SignRow] = &[
    (Code::Bus001, ProblemKind::BusOff, 1, Ends::Traffic),
    (Code::Bus002, ProblemKind::ErrorPassive, 1, Ends::Controller),
    (Code::Bus003, ProblemKind::ErrorPassive, 1, Ends::Controller),
    (Code::Bus004, ProblemKind::NotAcknowledged, 1, Ends::Once),
    (Code::Bus005, ProblemKind::CaptureGap, 1, Ends::Once),
    (Code::Bus007, ProblemKind::BusErrors, 3, Ends::Once),
    (Code::Bus008, ProblemKind::TransceiverFault, 1, Ends::Controller),
    (Code::Bus009, ProblemKind::NotCanopen, 1, Ends::Once),
    (Code::Cap002, ProblemKind::CaptureGap, 1, Ends::Once),
    (Code::Cap004, ProblemKind::CaptureGap, 1, Ends::Once),
    (Code::Cap006, ProblemKind::CaptureGap, 1, Ends::Once),
    (Code::Cap007, ProblemKind::CaptureGap, 1, Ends::Once),
    (Code::Cap008, ProblemKind::CaptureGap, 1, Ends::Once),
    (Code::Cap009, ProblemKind::CaptureGap, 1, Ends::Once),
    (Code::Drv001, ProblemKind::IllegalTransition, 1, Ends::Once),
    (Code::Drv004, ProblemKind::ModeNotTaken, 1, Ends::Never),
    (Code::Eds004, ProblemKind::IdentityMismatch, 1, Ends::Never),
    (Code::Emc001, ProblemKind::WireError, 1, Ends::Once),
    (Code::Emc003, ProblemKind::WireError, 1, Ends::Once),
    (Code::Emc004, ProblemKind::WireError, 1, Ends::Once),
    (Code::Emc005, ProblemKind::WireError, 1, Ends::Once),
    (Code::Emc006, ProblemKind::WireError, 1, Ends::Once),
    (Code::Emc010, ProblemKind::EmcyFlood, 1, Ends::Once),
    (Code::Grd001, ProblemKind::WireError, 1, Ends::Once),
    (Code::Grd002, ProblemKind::GuardingUnanswered, 1, Ends::Controlled),
    (Code::Grd003, ProblemKind::GuardingAndHeartbeat, 1, Ends::Never),
    (Code::Grd004, ProblemKind::NodeAbsent, 1, Ends::Heard),
    (Code::Grd005, ProblemKind::GuardingStopped, 1, Ends::Guarded),
    (Code::Hbt001, ProblemKind::HeartbeatIrregular, 3, Ends::Once),
    (Code::Hbt003, ProblemKind::WireError, 1, Ends::Once),
    (Code::Hbt004, ProblemKind::DuplicateNodeId, 1, Ends::Never),
    (Code::Hbt005, ProblemKind::BusSilent, 1, Ends::Once),
    (Code::Hbt006, ProblemKind::WireError, 1, Ends::Once),
    (Code::Hbt007, ProblemKind::HeartbeatIrregular, 1, Ends::Never),
    (Code::Lss001, ProblemKind::WireError, 1, Ends::Once),
    (Code::Lss002, ProblemKind::WireError, 1, Ends::Once),
    (Code::Lss003, ProblemKind::LssRefused, 1, Ends::Once),
    (Code::Lss004, ProblemKind::LssRefused, 1, Ends::Lss),
    (Code::Lss007, ProblemKind::LssRefused, 1, Ends::Once),
    (Code::Lss008, ProblemKind::WireError, 1, Ends::Once),
    (Code::Lss009, ProblemKind::LssUnanswered, 1, Ends::Once),
    (Code::Lss011, ProblemKind::WireError, 1, Ends::Once),
    (Code::Lss012, ProblemKind::LssUnanswered, 2, Ends::Never),
    (Code::Mpd001, ProblemKind::PdoLength, 1, Ends::Once),
    (Code::Nmt001, ProblemKind::WireError, 1, Ends::Once),
    (Code::Pdo001, ProblemKind::PdoLength, 1, Ends::Length),
    (Code::Pdo002, ProblemKind::PdoNotAllowed, 1, Ends::Operational),
    (Code::Pdo004, ProblemKind::InhibitTime, 3, Ends::Once),
    (Code::Pdo005, ProblemKind::PdoMissing, 3, Ends::Pdo),
    (Code::Pdo006, ProblemKind::PdoLength, 1, Ends::Length),
    (Code::Pdo008, ProblemKind::PdoConfiguration, 1, Ends::Never),
    (Code::Pdo009, ProblemKind::PdoConfiguration, 1, Ends::Once),
    (Code::Pdo010, ProblemKind::PdoConfiguration, 1, Ends::Once),
    (Code::Pdo011, ProblemKind::WireError, 1, Ends::Once),
    (Code::Pdo012, ProblemKind::PdoLength, 1, Ends::Length),
    (Code::Pdo014, ProblemKind::PdoConfiguration, 1, Ends::Never),
    (Code::Pdo016, ProblemKind::PdoConfiguration, 1, Ends::Never),
    (Code::Pdo018, ProblemKind::PdoNotAllowed, 1, Ends::Written),
    (Code::Pdo020, ProblemKind::SharedCobId, 1, Ends::Never),
    (Code::Pdo021, ProblemKind::PdoLength, 1, Ends::Former),
    (Code::Sdo001, ProblemKind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo002, ProblemKind::RequestUnanswered, 1, Ends::Answered),
    (Code::Sdo003, ProblemKind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo004, ProblemKind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo006, ProblemKind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo007, ProblemKind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo008, ProblemKind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo010, ProblemKind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo011, ProblemKind::RequestUnanswered, 1, Ends::Answered),
    (Code::Sdo012, ProblemKind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo013, ProblemKind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo015, ProblemKind::RequestUnanswered, 1, Ends::Answered),
    (Code::Sdo016, ProblemKind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo019, ProblemKind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo020, ProblemKind::LateAnswer, 1, Ends::Once),
    (Code::Sdo021, ProblemKind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo022, ProblemKind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo023, ProblemKind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo024, ProblemKind::CaptureGap, 1, Ends::Once),
    (Code::Sdo031, ProblemKind::NodeAbsent, 1, Ends::Heard),
    (Code::Srd001, ProblemKind::SrdoInvalid, 1, Ends::Once),
    (Code::Srd002, ProblemKind::SrdoInvalid, 1, Ends::Once),
    (Code::Srd003, ProblemKind::SrdoInvalid, 1, Ends::Once),
    (Code::Srd004, ProblemKind::SrdoInvalid, 1, Ends::Once),
    (Code::Srd005, ProblemKind::SrdoInvalid, 1, Ends::Once),
    (Code::Syn001, ProblemKind::SyncLength, 1, Ends::Once),
    (Code::Syn002, ProblemKind::SyncIrregular, 1, Ends::Once),
    (Code::Syn003, ProblemKind::SyncIrregular, 3, Ends::Once),
    (Code::Syn004, ProblemKind::SyncIrregular, 3, Ends::Once),
    (Code::Syn006, ProblemKind::TwoSyncProducers, 1, Ends::Never),
    (Code::Syn008, ProblemKind::PdoMissing, 3, Ends::Pdo),
    (Code::Syn009, ProblemKind::SyncIrregular, 3, Ends::Once),
    (Code::Syn010, ProblemKind::SyncIrregular, 3, Ends::Once),
    (Code::Syn013, ProblemKind::SyncStopped, 1, Ends::Sync),
    (Code::Tim001, ProblemKind::WireError, 1, Ends::Once),
    (Code::Tim002, ProblemKind::TimeJump, 1, Ends::Once),
];

/// Returns the row of a rule.
pub(super) fn of(code: Code) -> Option<SignRow> {
    SIGNS.iter().find(|row| row.0 == code).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rule_has_one_row_and_rows_are_in_order() {
        assert!(SIGNS.windows(2).all(|two| matches!(two, [one, next] if one.0 < next.0)));
    }
}

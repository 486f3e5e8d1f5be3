//! The findings that are incidents by themselves, one row for each rule.
//!
//! Lost and restarting nodes, emergencies and drives in fault have trackers of their own. Findings of rules without a
//! row are worth knowing, but nothing went wrong.

use super::kinds::IncidentKind;
use crate::rules::Code;

/// The sign that ends an incident.
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

/// A rule, its kind of incident, the number of findings from which it counts, and its end.
pub(super) type SignRow = (Code, IncidentKind, u64, Ends);

/// The rows. Incidents that one late frame may cause count from the third time on.
pub(super) const SIGNS: &[SignRow] = &[
    (Code::Bus001, IncidentKind::BusOff, 1, Ends::Traffic),
    (Code::Bus002, IncidentKind::ErrorPassive, 1, Ends::Controller),
    (Code::Bus003, IncidentKind::ErrorPassive, 1, Ends::Controller),
    (Code::Bus004, IncidentKind::NotAcknowledged, 1, Ends::Once),
    (Code::Bus005, IncidentKind::CaptureGap, 1, Ends::Once),
    (Code::Bus007, IncidentKind::BusErrors, 3, Ends::Once),
    (Code::Bus008, IncidentKind::TransceiverFault, 1, Ends::Controller),
    (Code::Bus009, IncidentKind::NotCanopen, 1, Ends::Once),
    (Code::Cap002, IncidentKind::CaptureGap, 1, Ends::Once),
    (Code::Cap004, IncidentKind::CaptureGap, 1, Ends::Once),
    (Code::Cap006, IncidentKind::CaptureGap, 1, Ends::Once),
    (Code::Cap007, IncidentKind::CaptureGap, 1, Ends::Once),
    (Code::Cap008, IncidentKind::CaptureGap, 1, Ends::Once),
    (Code::Cap009, IncidentKind::CaptureGap, 1, Ends::Once),
    (Code::Drv001, IncidentKind::IllegalTransition, 1, Ends::Once),
    (Code::Drv004, IncidentKind::ModeNotTaken, 1, Ends::Never),
    (Code::Eds004, IncidentKind::IdentityMismatch, 1, Ends::Never),
    (Code::Emc001, IncidentKind::WireError, 1, Ends::Once),
    (Code::Emc003, IncidentKind::WireError, 1, Ends::Once),
    (Code::Emc004, IncidentKind::WireError, 1, Ends::Once),
    (Code::Emc005, IncidentKind::WireError, 1, Ends::Once),
    (Code::Emc006, IncidentKind::WireError, 1, Ends::Once),
    (Code::Emc010, IncidentKind::EmcyFlood, 1, Ends::Once),
    (Code::Grd001, IncidentKind::WireError, 1, Ends::Once),
    (Code::Grd002, IncidentKind::GuardingUnanswered, 1, Ends::Controlled),
    (Code::Grd003, IncidentKind::GuardingAndHeartbeat, 1, Ends::Never),
    (Code::Grd004, IncidentKind::NodeAbsent, 1, Ends::Heard),
    (Code::Grd005, IncidentKind::GuardingStopped, 1, Ends::Guarded),
    (Code::Hbt001, IncidentKind::HeartbeatIrregular, 3, Ends::Once),
    (Code::Hbt003, IncidentKind::WireError, 1, Ends::Once),
    (Code::Hbt004, IncidentKind::DuplicateNodeId, 1, Ends::Never),
    (Code::Hbt005, IncidentKind::BusSilent, 1, Ends::Once),
    (Code::Hbt006, IncidentKind::WireError, 1, Ends::Once),
    (Code::Hbt007, IncidentKind::HeartbeatIrregular, 1, Ends::Never),
    (Code::Lss001, IncidentKind::WireError, 1, Ends::Once),
    (Code::Lss002, IncidentKind::WireError, 1, Ends::Once),
    (Code::Lss003, IncidentKind::LssRefused, 1, Ends::Once),
    (Code::Lss004, IncidentKind::LssRefused, 1, Ends::Lss),
    (Code::Lss007, IncidentKind::LssRefused, 1, Ends::Once),
    (Code::Lss008, IncidentKind::WireError, 1, Ends::Once),
    (Code::Lss009, IncidentKind::LssUnanswered, 1, Ends::Once),
    (Code::Lss011, IncidentKind::WireError, 1, Ends::Once),
    (Code::Lss012, IncidentKind::LssUnanswered, 2, Ends::Never),
    (Code::Mpd001, IncidentKind::PdoLength, 1, Ends::Once),
    (Code::Nmt001, IncidentKind::WireError, 1, Ends::Once),
    (Code::Pdo001, IncidentKind::PdoLength, 1, Ends::Length),
    (Code::Pdo002, IncidentKind::PdoNotAllowed, 1, Ends::Operational),
    (Code::Pdo004, IncidentKind::InhibitTime, 3, Ends::Once),
    (Code::Pdo005, IncidentKind::PdoMissing, 3, Ends::Pdo),
    (Code::Pdo006, IncidentKind::PdoLength, 1, Ends::Length),
    (Code::Pdo008, IncidentKind::PdoConfiguration, 1, Ends::Never),
    (Code::Pdo009, IncidentKind::PdoConfiguration, 1, Ends::Once),
    (Code::Pdo010, IncidentKind::PdoConfiguration, 1, Ends::Once),
    (Code::Pdo011, IncidentKind::WireError, 1, Ends::Once),
    (Code::Pdo012, IncidentKind::PdoLength, 1, Ends::Length),
    (Code::Pdo014, IncidentKind::PdoConfiguration, 1, Ends::Never),
    (Code::Pdo016, IncidentKind::PdoConfiguration, 1, Ends::Never),
    (Code::Pdo018, IncidentKind::PdoNotAllowed, 1, Ends::Written),
    (Code::Pdo020, IncidentKind::SharedCobId, 1, Ends::Never),
    (Code::Pdo021, IncidentKind::PdoLength, 1, Ends::Former),
    (Code::Sdo001, IncidentKind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo002, IncidentKind::RequestUnanswered, 1, Ends::Answered),
    (Code::Sdo003, IncidentKind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo004, IncidentKind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo006, IncidentKind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo007, IncidentKind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo008, IncidentKind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo010, IncidentKind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo011, IncidentKind::RequestUnanswered, 1, Ends::Answered),
    (Code::Sdo012, IncidentKind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo013, IncidentKind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo015, IncidentKind::RequestUnanswered, 1, Ends::Answered),
    (Code::Sdo016, IncidentKind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo019, IncidentKind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo020, IncidentKind::LateAnswer, 1, Ends::Once),
    (Code::Sdo021, IncidentKind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo022, IncidentKind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo023, IncidentKind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo024, IncidentKind::CaptureGap, 1, Ends::Once),
    (Code::Sdo031, IncidentKind::NodeAbsent, 1, Ends::Heard),
    (Code::Srd001, IncidentKind::SrdoInvalid, 1, Ends::Once),
    (Code::Srd002, IncidentKind::SrdoInvalid, 1, Ends::Once),
    (Code::Srd003, IncidentKind::SrdoInvalid, 1, Ends::Once),
    (Code::Srd004, IncidentKind::SrdoInvalid, 1, Ends::Once),
    (Code::Srd005, IncidentKind::SrdoInvalid, 1, Ends::Once),
    (Code::Syn001, IncidentKind::SyncLength, 1, Ends::Once),
    (Code::Syn002, IncidentKind::SyncIrregular, 1, Ends::Once),
    (Code::Syn003, IncidentKind::SyncIrregular, 3, Ends::Once),
    (Code::Syn004, IncidentKind::SyncIrregular, 3, Ends::Once),
    (Code::Syn006, IncidentKind::TwoSyncProducers, 1, Ends::Never),
    (Code::Syn008, IncidentKind::PdoMissing, 3, Ends::Pdo),
    (Code::Syn009, IncidentKind::SyncIrregular, 3, Ends::Once),
    (Code::Syn010, IncidentKind::SyncIrregular, 3, Ends::Once),
    (Code::Syn013, IncidentKind::SyncStopped, 1, Ends::Sync),
    (Code::Tim001, IncidentKind::WireError, 1, Ends::Once),
    (Code::Tim002, IncidentKind::TimeJump, 1, Ends::Once),
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

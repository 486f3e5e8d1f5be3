//! The findings that are incidents by themselves, one row for each rule.
//!
//! Lost and restarting nodes, emergencies and drives in fault have trackers of their own. Findings of rules without a
//! row are worth knowing, but nothing went wrong.

use super::kinds::Kind;
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
    /// An active controller.
    Controller,
    /// An active controller or any frame, since a controller that is off receives none.
    Traffic,
    /// A positive answer of an LSS slave.
    Lss,
    /// A boot-up, or the state Operational.
    Guarded,
}

/// A rule, its kind of incident, the number of findings from which it counts, and its end.
pub(super) type Row = (Code, Kind, u64, Ends);

/// The rows. Incidents that one late frame may cause count from the third time on.
pub(super) const SIGNS: &[Row] = &[
    (Code::Bus001, Kind::BusOff, 1, Ends::Traffic),
    (Code::Bus002, Kind::ErrorPassive, 1, Ends::Controller),
    (Code::Bus003, Kind::ErrorPassive, 1, Ends::Controller),
    (Code::Bus004, Kind::NotAcknowledged, 1, Ends::Once),
    (Code::Bus005, Kind::CaptureGap, 1, Ends::Once),
    (Code::Bus007, Kind::BusErrors, 3, Ends::Once),
    (Code::Bus008, Kind::TransceiverFault, 1, Ends::Controller),
    (Code::Bus009, Kind::NotCanopen, 1, Ends::Once),
    (Code::Cap002, Kind::CaptureGap, 1, Ends::Once),
    (Code::Cap004, Kind::CaptureGap, 1, Ends::Once),
    (Code::Cap006, Kind::CaptureGap, 1, Ends::Once),
    (Code::Cap007, Kind::CaptureGap, 1, Ends::Once),
    (Code::Cap008, Kind::CaptureGap, 1, Ends::Once),
    (Code::Drv001, Kind::IllegalTransition, 1, Ends::Once),
    (Code::Drv004, Kind::ModeNotTaken, 1, Ends::Never),
    (Code::Eds004, Kind::IdentityMismatch, 1, Ends::Never),
    (Code::Emc001, Kind::WireError, 1, Ends::Once),
    (Code::Emc003, Kind::WireError, 1, Ends::Once),
    (Code::Emc004, Kind::WireError, 1, Ends::Once),
    (Code::Emc005, Kind::WireError, 1, Ends::Once),
    (Code::Emc006, Kind::WireError, 1, Ends::Once),
    (Code::Emc010, Kind::EmcyFlood, 1, Ends::Once),
    (Code::Grd001, Kind::WireError, 1, Ends::Once),
    (Code::Grd002, Kind::GuardingUnanswered, 1, Ends::Heard),
    (Code::Grd003, Kind::GuardingAndHeartbeat, 1, Ends::Never),
    (Code::Grd004, Kind::NodeAbsent, 1, Ends::Heard),
    (Code::Grd005, Kind::GuardingStopped, 1, Ends::Guarded),
    (Code::Hbt001, Kind::HeartbeatIrregular, 3, Ends::Once),
    (Code::Hbt003, Kind::WireError, 1, Ends::Once),
    (Code::Hbt004, Kind::DuplicateNodeId, 1, Ends::Never),
    (Code::Hbt005, Kind::BusSilent, 1, Ends::Once),
    (Code::Hbt006, Kind::WireError, 1, Ends::Once),
    (Code::Hbt007, Kind::HeartbeatIrregular, 1, Ends::Once),
    (Code::Lss001, Kind::WireError, 1, Ends::Once),
    (Code::Lss002, Kind::WireError, 1, Ends::Once),
    (Code::Lss003, Kind::LssRefused, 1, Ends::Once),
    (Code::Lss004, Kind::LssRefused, 1, Ends::Lss),
    (Code::Lss007, Kind::LssRefused, 1, Ends::Once),
    (Code::Lss008, Kind::WireError, 1, Ends::Once),
    (Code::Lss009, Kind::LssUnanswered, 1, Ends::Once),
    (Code::Lss011, Kind::WireError, 1, Ends::Once),
    (Code::Lss012, Kind::LssUnanswered, 2, Ends::Never),
    (Code::Mpd001, Kind::PdoLength, 1, Ends::Once),
    (Code::Nmt001, Kind::WireError, 1, Ends::Once),
    (Code::Pdo001, Kind::PdoLength, 1, Ends::Length),
    (Code::Pdo002, Kind::PdoNotAllowed, 1, Ends::Once),
    (Code::Pdo004, Kind::InhibitTime, 3, Ends::Once),
    (Code::Pdo005, Kind::PdoMissing, 3, Ends::Pdo),
    (Code::Pdo006, Kind::PdoLength, 1, Ends::Length),
    (Code::Pdo008, Kind::PdoConfiguration, 1, Ends::Never),
    (Code::Pdo009, Kind::PdoConfiguration, 1, Ends::Once),
    (Code::Pdo010, Kind::PdoConfiguration, 1, Ends::Once),
    (Code::Pdo011, Kind::WireError, 1, Ends::Once),
    (Code::Pdo012, Kind::PdoLength, 1, Ends::Length),
    (Code::Pdo014, Kind::PdoConfiguration, 1, Ends::Never),
    (Code::Pdo016, Kind::PdoConfiguration, 1, Ends::Never),
    (Code::Pdo018, Kind::PdoNotAllowed, 1, Ends::Never),
    (Code::Pdo020, Kind::SharedCobId, 1, Ends::Never),
    (Code::Pdo021, Kind::PdoLength, 1, Ends::Once),
    (Code::Sdo001, Kind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo002, Kind::RequestUnanswered, 1, Ends::Answered),
    (Code::Sdo003, Kind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo004, Kind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo006, Kind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo007, Kind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo008, Kind::RequestUnanswered, 1, Ends::Answered),
    (Code::Sdo010, Kind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo011, Kind::RequestUnanswered, 1, Ends::Answered),
    (Code::Sdo012, Kind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo013, Kind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo015, Kind::RequestUnanswered, 1, Ends::Answered),
    (Code::Sdo016, Kind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo019, Kind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo020, Kind::LateAnswer, 1, Ends::Once),
    (Code::Sdo021, Kind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo022, Kind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo023, Kind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo024, Kind::DamagedTransfer, 1, Ends::Transferred),
    (Code::Sdo031, Kind::NodeAbsent, 1, Ends::Heard),
    (Code::Srd001, Kind::SrdoInvalid, 1, Ends::Once),
    (Code::Srd002, Kind::SrdoInvalid, 1, Ends::Once),
    (Code::Srd003, Kind::SrdoInvalid, 1, Ends::Once),
    (Code::Srd004, Kind::SrdoInvalid, 1, Ends::Once),
    (Code::Srd005, Kind::SrdoInvalid, 1, Ends::Once),
    (Code::Syn001, Kind::SyncLength, 1, Ends::Once),
    (Code::Syn002, Kind::SyncIrregular, 1, Ends::Once),
    (Code::Syn003, Kind::SyncIrregular, 3, Ends::Once),
    (Code::Syn004, Kind::SyncIrregular, 3, Ends::Once),
    (Code::Syn006, Kind::TwoSyncProducers, 1, Ends::Never),
    (Code::Syn008, Kind::PdoMissing, 3, Ends::Pdo),
    (Code::Syn009, Kind::SyncIrregular, 3, Ends::Once),
    (Code::Syn010, Kind::SyncIrregular, 3, Ends::Once),
    (Code::Syn013, Kind::SyncStopped, 1, Ends::Sync),
    (Code::Tim001, Kind::WireError, 1, Ends::Once),
    (Code::Tim002, Kind::TimeJump, 1, Ends::Once),
];

/// Returns the row of a rule.
pub(super) fn of(code: Code) -> Option<Row> {
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

//! The findings that are problems by themselves, the ends of problems, and the conditions of advice, as the table of kinds
//! has them in its columns `signs` and `checks`.
//!
//! Lost and restarting nodes, emergencies and drives in fault have trackers of their own. Findings of other rules
//! are worth knowing, but nothing went wrong.

use crate::rules::{Code, Variant};

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
    /// The same with a state that CiA 301 defines.
    State,
    /// An answer of the server.
    Answered,
    /// A successful transfer of the node.
    Transferred,
    /// A write to the same object.
    Written,
    /// A SYNC.
    Sync,
    /// A SYNC of the length that is due.
    SyncLength,
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
    /// A valid pair of the SRDO.
    Srdo,
    /// The state Operational, or that the PDO is no longer sent.
    Operational,
}

/// A rule whose findings are a problem by themselves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sign {
    pub(super) code: Code,
    pub(super) ends: Ends,
    /// The number of findings from which it counts; 3 for frames that are late.
    pub(super) least: u64,
}

/// Titles, each with its conditions.
pub(super) type Titles = &'static [(&'static [When], &'static Variant)];

/// A condition on the facts of a problem, by which its title and the first things to check are chosen.
#[derive(Clone, Copy, Debug)]
pub(super) enum When {
    /// There is a fact of this name.
    Has(&'static str),
    /// The silent node is a pure controller.
    Controller,
    /// It has ended.
    Ended,
    /// It has not ended.
    Open,
    /// It has ended, and its status says so.
    Over,
    /// Its nodes are back.
    Back,
    /// It came once.
    Once,
    /// It had ended when it was noticed.
    AtOnce,
    /// It came several times.
    Often,
    /// It concerns one node at most.
    Single,
    /// It concerns several nodes.
    Several,
    /// An emergency reported it.
    Reported,
    /// The time of its beginning is known.
    Timed,
    /// That time is not known.
    Untimed,
    /// The abort code says that the hardware failed.
    Hardware,
    /// The request went to a Stopped node.
    ToStopped,
    /// The object cannot be written.
    Fixed,
    /// The object cannot be mapped.
    NotMappable,
    /// The mapped objects are longer than a PDO.
    TooLong,
    /// The state of the device does not allow it.
    WrongState,
    /// The abort code says that the other side did not go on.
    TimedOut,
    /// The abort code says that the protocol was violated.
    Violation,
    /// The abort code says that the server was busy.
    Busy,
    /// It is about no parameter of a PDO.
    NoPdoParameter,
    /// The PDO came from a node that is not Operational.
    NotOperational,
    /// It is about a PDO.
    OfPdo,
    /// Several axes are in fault without an emergency.
    UnannouncedAxes,
    /// The node reported too high a voltage.
    Overvoltage,
    /// The statusword shows local operation (bit 9 is 0).
    OperatedLocally,
    /// The statusword shows operation enabled.
    StaysEnabled,
    /// The statusword says that the power stage has its voltage.
    VoltageEnabled,
}

//! What two captures differ in: values without words.

use super::digest::{Action, Kind, Place, Service};
use crate::bytes::frame::{BusId, CanId, FrameRef};
use crate::rules::finding::Finding;

/// One difference, or several of the same.
#[derive(Clone, Debug)]
pub struct Difference {
    /// What differs.
    pub what: What,
    /// The bus, in A and in B.
    pub bus: [Option<BusId>; 2],
    /// The node; `None` for what is no node's.
    pub node: Option<u8>,
    /// What each capture has; `None` where it has nothing.
    pub sides: [Option<Side>; 2],
    /// Where it would be in the capture that has nothing: the nearest frame before that both have.
    pub beside: [Option<FrameRef>; 2],
    /// How often; the first is shown.
    pub count: u64,
    /// Where it stands among all, on the scale of A.
    pub(super) order: (i64, u8, u32),
}

/// What can differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum What {
    /// A bus is in one capture only.
    Bus,
    /// A node is in one capture only.
    Node,
    /// Something was done in one capture only, or is of another kind: see [`Aspect`].
    Item(Kind, Aspect),
    /// A service is in one capture only, or has more frames in one.
    Frames(Service),
    /// The time between frames.
    Period(Service),
    /// How far it varies.
    Jitter(Service),
    /// The CAN-ID.
    CobId(Service),
    /// The mapping of a PDO.
    Mapping(Service),
    /// The length of frames.
    Length(Service),
    /// The time between SDO transfers of one object.
    Poll,
    /// A finding is in one capture only.
    Finding,
}

/// In what respect the same thing is another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Aspect {
    /// It is in one capture only.
    Presence,
    /// How a transfer ended.
    Outcome,
    /// Expedited, segmented or block.
    Mode,
    /// The bytes of a transfer; the code of a command, an emergency, a state.
    Value,
}

/// What one capture has.
#[derive(Clone, Debug)]
pub struct Side {
    /// The frame that shows it: of a transfer the last one.
    pub at: FrameRef,
    /// Where it begins.
    pub since: FrameRef,
    /// What it is.
    pub shows: Shows,
    /// The time in ns from one to the next, of a poll.
    pub pace_ns: Option<i64>,
}

/// The content of a side.
#[derive(Clone, Debug)]
pub enum Shows {
    /// Something done.
    Action(Action),
    /// Frames.
    Count(u64),
    /// A period, or how far it varies, in ns.
    Time(i64),
    /// An identifier.
    Id(CanId),
    /// The entries of a mapping.
    Mapping(Vec<u32>),
    /// Bytes.
    Length(u8),
    /// A finding.
    Finding(Box<Finding>),
}

impl Side {
    /// Something at these places.
    pub fn new(at: Place, since: Place, shows: Shows) -> Self {
        Self { at: at.frame(), since: since.frame(), shows, pace_ns: None }
    }
}

impl What {
    /// The word in machine output.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bus => "bus",
            Self::Node => "node",
            Self::Item(Kind::Sdo(_), Aspect::Presence) => "transfer",
            Self::Item(Kind::Sdo(_), Aspect::Outcome) => "outcome",
            Self::Item(Kind::Sdo(_), Aspect::Mode) => "mode",
            Self::Item(Kind::Sdo(_), Aspect::Value) => "value",
            Self::Item(Kind::Nmt, _) => "nmt",
            Self::Item(Kind::State, _) => "state",
            Self::Item(Kind::Emcy, _) => "emcy",
            Self::Item(Kind::Drive(_), _) => "drive_state",
            Self::Item(Kind::LssMaster | Kind::LssSlave, _) => "lss",
            Self::Frames(_) => "frames",
            Self::Period(_) => "period",
            Self::Jitter(_) => "jitter",
            Self::CobId(_) => "cob_id",
            Self::Mapping(_) => "mapping",
            Self::Length(_) => "length",
            Self::Poll => "poll",
            Self::Finding => "finding",
        }
    }

    /// The service that it is about, where it is one that comes again and again.
    pub fn service(self) -> Option<Service> {
        match self {
            Self::Frames(service) | Self::Period(service) | Self::Jitter(service) => Some(service),
            Self::CobId(service) | Self::Mapping(service) | Self::Length(service) => Some(service),
            _ => None,
        }
    }
}

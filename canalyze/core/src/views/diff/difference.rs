//! Differences of two captures: values without words.

use super::digest::{Action, CapturePlace, ItemKind, Service};
use crate::bytes::frame::{BusId, CanId, FrameRef};
use crate::bytes::ns::Ns;
use crate::rules::finding::Finding;

/// One difference, or several of the same.
#[derive(Clone, Debug)]
pub struct Difference {
    /// The property that differs.
    pub what: DifferenceKind,
    /// The bus, in A and in B.
    pub bus: [Option<BusId>; 2],
    /// The node; `None` if it is not about a node.
    pub node: Option<u8>,
    /// The content of each capture; `None` if it has nothing.
    pub sides: [Option<CaptureSide>; 2],
    /// The corresponding position in a capture that has nothing: the nearest frame before it that both have.
    pub beside: [Option<FrameRef>; 2],
    /// The number of occurrences; the first one is shown.
    pub count: u64,
    /// The sort key among all, on the scale of A.
    pub(super) order: (Ns, u8, u32),
}

/// A property that can differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum DifferenceKind {
    /// A bus is in one capture only.
    Bus,
    /// A node is in one capture only.
    Node,
    /// An action is in one capture only, or differs: see [`Aspect`].
    Item(ItemKind, Aspect),
    /// A service is in one capture only, or has more frames in one.
    Frames(Service),
    /// The time between frames.
    Period(Service),
    /// The variation of the period.
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

/// The property of an action that differs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Aspect {
    /// It is in one capture only.
    Presence,
    /// The outcome of a transfer.
    Outcome,
    /// Expedited, segmented or block.
    Mode,
    /// The bytes of a transfer; the code of a command, an emergency, a state.
    Value,
}

/// The content of one capture.
#[derive(Clone, Debug)]
pub struct CaptureSide {
    /// The frame that shows it: of a transfer the last one.
    pub at: FrameRef,
    /// The frame at which it begins.
    pub since: FrameRef,
    /// The content.
    pub shows: Shows,
    /// The period of a poll in ns.
    pub pace_ns: Option<Ns>,
}

/// The content of a side.
#[derive(Clone, Debug)]
pub enum Shows {
    /// An action.
    Action(Action),
    /// Frames.
    Count(u64),
    /// A period, or its variation, in ns.
    Time(Ns),
    /// An identifier.
    Id(CanId),
    /// The entries of a mapping.
    Mapping(Vec<u32>),
    /// Bytes.
    Length(u8),
    /// A finding.
    Finding(Box<Finding>),
}

impl CaptureSide {
    /// Creates a side with these places.
    pub fn new(at: CapturePlace, since: CapturePlace, shows: Shows) -> Self {
        Self { at: at.frame(), since: since.frame(), shows, pace_ns: None }
    }
}

impl DifferenceKind {
    /// The word in machine output.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bus => "bus",
            Self::Node => "node",
            Self::Item(ItemKind::Sdo(_), Aspect::Presence) => "transfer",
            Self::Item(ItemKind::Sdo(_), Aspect::Outcome) => "outcome",
            Self::Item(ItemKind::Sdo(_), Aspect::Mode) => "mode",
            Self::Item(ItemKind::Sdo(_), Aspect::Value) => "value",
            Self::Item(ItemKind::Nmt, _) => "nmt",
            Self::Item(ItemKind::State, _) => "state",
            Self::Item(ItemKind::Emcy, _) => "emcy",
            Self::Item(ItemKind::Drive(_), _) => "drive_state",
            Self::Item(ItemKind::LssMaster | ItemKind::LssSlave, _) => "lss",
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

    /// Returns the service that it is about, if that is periodic.
    pub fn service(self) -> Option<Service> {
        match self {
            Self::Frames(service) | Self::Period(service) | Self::Jitter(service) => Some(service),
            Self::CobId(service) | Self::Mapping(service) | Self::Length(service) => Some(service),
            _ => None,
        }
    }
}

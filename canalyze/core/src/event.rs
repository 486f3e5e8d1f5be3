//! What a frame means given everything seen before it. Events are values: they hold no words and no state.

use std::sync::Arc;

use crate::configuration::Provenance;
use crate::dictionary::Described;
use crate::finding::Finding;
use crate::frame::{BusId, Frame, FrameRef};
use crate::message::Message;
use crate::services::pdo::Multiplexed;
use crate::services::pdo::mapping::Mapping;
use crate::services::sdo::transfer::{Transfer, TransferId};
use crate::services::sdo::wire::{Command, Mux, Side, decode_frame};

/// Something that a frame says or proves.
#[derive(Clone, Debug)]
pub struct Event {
    /// The frame that shows it.
    pub at: FrameRef,
    /// The earlier frame it speaks of, if another. Rare: apart, so that events stay small.
    pub about: Option<Box<FrameRef>>,
    /// The bus.
    pub bus: BusId,
    /// The node, where one is concerned.
    pub node: Option<u8>,
    /// The SDO transfer, where one is concerned.
    pub transfer: Option<TransferId>,
    /// What it is.
    pub what: What,
}

/// Returns the service that a frame belongs to and the node that it is about, by the first of its events.
pub fn service(events: &[Event]) -> (&'static str, Option<u8>) {
    events.first().map_or(("foreign", None), |event| match &event.what {
        What::Message(message) => (message.service(), event.node),
        What::Pdo(_) | What::Mpdo(_) => ("pdo", event.node),
        _ => ("sdo", event.node),
    })
}

/// The kinds of event.
#[derive(Clone, Debug)]
pub enum What {
    /// A frame of a service other than SDO and PDO: every such frame has exactly one.
    Message(Message),
    /// A PDO with data: every such frame has exactly one.
    Pdo(ProcessData),
    /// A multiplex PDO: every complete one has exactly one. Rare, and large: apart, so that events stay small.
    Mpdo(Box<Addressed>),
    /// A frame of an SDO channel: every such frame has exactly one.
    Sdo(Step),
    /// An SDO transfer has ended.
    Transfer(Arc<Transfer>),
    /// Something that has become known of an earlier frame, and is no finding.
    Note(Note),
    /// A rule has been raised. Rare, and large: apart, so that events stay small.
    Finding(Box<Finding>),
}

/// A PDO and what its bytes are, as far as that is known.
#[derive(Clone, Debug)]
pub struct ProcessData {
    /// Transmit or receive, seen from the node.
    pub transmit: bool,
    /// PDO number, from 1.
    pub number: u16,
    /// The node whose PDO it is.
    pub node: u8,
    /// What the bytes are.
    pub content: Signals,
    /// The NMT state of the node, where known: 04, 05, 7F.
    pub state: Option<u8>,
    /// The SYNC cycle it belongs to, where it is a synchronous PDO.
    pub sync: Option<Placement>,
}

/// A multiplex PDO and the object in it.
#[derive(Clone, Debug)]
pub struct Addressed {
    /// Transmit or receive, seen from the node.
    pub transmit: bool,
    /// PDO number, from 1.
    pub number: u16,
    /// The node whose PDO it is.
    pub node: u8,
    /// What it carries.
    pub content: Multiplexed,
    /// Its only entry is the object in the data (bytes 4 to 7), with what is known of it.
    pub mapping: Mapping,
    /// From where it is known that the PDO is a multiplex one.
    pub from: Provenance,
}

impl Addressed {
    /// What the frame says by itself.
    pub fn message(&self) -> Message {
        let Self { transmit, number, node, content, .. } = *self;
        Message::Mpdo { transmit, number, node, content }
    }
}

/// What the bytes of a PDO are.
#[derive(Clone, Debug)]
pub enum Signals {
    /// Mapped objects, by a mapping known from there.
    Mapped(Arc<Mapping>, Provenance),
    /// The node's own mapping is not known, but that of a node that receives the PDO: its node-ID and RPDO.
    ByConsumer(Arc<Mapping>, Provenance, u8, u16),
    /// No signals.
    None(Unmapped),
}

impl Signals {
    /// The same, where it is known only from there that they are those of the PDO.
    pub fn by(self, from: Provenance) -> Self {
        match self {
            Self::Mapped(mapping, _) => Self::Mapped(mapping, from),
            Self::ByConsumer(mapping, _, node, number) => Self::ByConsumer(mapping, from, node, number),
            Self::None(_) => Self::None(Unmapped::Unconfirmed),
        }
    }
}

/// Why a PDO shows no signals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unmapped {
    /// No mapping is known, or not all of it.
    Unknown,
    /// The same, and only a write that nothing has confirmed gives the PDO its identifier.
    Unconfirmed,
    /// Only the default mapping of an EDS is known, and the PDO's frames contradict it.
    Contradicted,
    /// Sub-index 0 of the mapping is 0.
    Disabled,
    /// A multiplex PDO without its address.
    Multiplex,
}

/// Where a synchronous PDO stands in its SYNC cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Placement {
    /// Number of the cycle in the capture, from 1: the number of SYNCs seen.
    pub cycle: u64,
    /// Time since the SYNC in ns, negative where its late echo came after the PDO; `None` without stamps.
    pub delay_ns: Option<i64>,
}

/// An SDO frame and its place in its transfer.
#[derive(Clone, Debug)]
pub struct Step {
    /// Who sent it.
    pub side: Side,
    /// What it says.
    pub command: Command,
    /// The object of the transfer it belongs to.
    pub mux: Option<Mux>,
    /// What is known of that object.
    pub described: Described,
    /// Which segment of the transfer it is, from 1; 0 when it is none.
    pub ordinal: u32,
    /// The answer that was captured before this request. Rare: apart, as well.
    pub answered_by: Option<Box<FrameRef>>,
    /// What is special about it.
    pub place: Place,
    /// The transfer that completes with this frame.
    pub result: Option<Arc<Transfer>>,
}

impl Step {
    /// A frame by itself: its command as it stands, its place not judged.
    pub fn alone(side: Side, frame: &Frame) -> Self {
        Self {
            side,
            command: decode_frame(side, frame.head(), frame.len),
            mux: None,
            described: Described::default(),
            ordinal: 0,
            answered_by: None,
            place: Place::Due,
            result: None,
        }
    }
}

/// How an SDO frame stands to its transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// In its due place.
    Due,
    /// A request that was sent before and not answered.
    Repeated,
    /// The answer to a request that had been given up.
    Late,
    /// Its request, or the beginning of its transfer, is not in the capture (or not yet).
    Uncaptured,
    /// A block segment that does not count: it was under way when the acknowledgement, or an abort, was sent.
    InFlight,
    /// A block segment out of sequence; the number that was due.
    OutOfSequence(u8),
    /// It belongs to no transfer.
    Outside,
    /// The frame before, captured a second time.
    Duplicate,
}

/// What becomes known later.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Note {
    /// The request that a response answers is not in the capture.
    RequestNotCaptured,
    /// A reset or boot-up of the server ended the transfer.
    LostByReset,
    /// LSS: the slave with this address has entered the configuration state.
    LssSelected {
        /// Vendor-ID, product code, revision number, serial number.
        address: [u32; 4],
    },
    /// LSS: a Fastscan is over.
    Fastscan(Scanned),
    /// LSS: bit timing is activated.
    BitTimingActivated {
        /// The switch delay in ms: twice as long the bus is silent.
        delay: u16,
        /// The new bit rate in kbit/s, where known.
        rate: Option<u16>,
    },
    /// LSS: a node has another node-ID now.
    NodeIdChanged {
        /// The one it had.
        from: u8,
        /// The one it has.
        to: u8,
    },
}

/// What a Fastscan has found (CiA 305).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scanned {
    /// Whether its last confirmation was answered: the slave is in the configuration state.
    pub found: bool,
    /// Vendor-ID, product code, revision number, serial number, as far as confirmed in the capture.
    pub address: [Option<u32>; 4],
    /// Fastscan frames of the master.
    pub frames: u32,
    /// From its first frame to its last one or the last answer, in ns; `None` without stamps.
    pub duration_ns: Option<i64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_are_small() {
        // Each is moved for every frame.
        assert!(size_of::<Event>() <= 144, "{}", size_of::<Event>());
    }
}

//! The meaning of a frame in the light of all frames before it. Events are plain values without state or words for
//! people.

use std::sync::Arc;

use crate::bytes::frame::{BusId, Frame, FrameRef};
use crate::bytes::ns::Ns;
use crate::rules::finding::Finding;
use crate::sdo::transfer::{Transfer, TransferId};
use crate::sdo::wire::{Command, Mux, Side, decode_frame};
use crate::wire::message::Message;
use crate::wire::pdo::Multiplexed;
use crate::wire::pdo::mapping::Mapping;
use crate::world::change::Change;
use crate::world::configuration::Provenance;
use crate::world::dictionary::Described;

/// Something that a frame shows or proves.
#[derive(Clone, Debug)]
pub struct Event {
    /// The frame that shows it.
    pub at: FrameRef,
    /// The earlier frame that it concerns, if another. Boxed, since it is rare and events have to be small.
    pub about: Option<Box<FrameRef>>,
    /// The bus of the frame.
    pub bus: BusId,
    /// The node concerned, if any.
    pub node: Option<u8>,
    /// The SDO transfer concerned, if any.
    pub transfer: Option<TransferId>,
    /// The content of the event.
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

/// The kinds of events.
#[derive(Clone, Debug)]
pub enum What {
    /// A frame of a service other than SDO and PDO; exactly one for each such frame.
    Message(Message),
    /// A PDO with data; exactly one for each such frame.
    Pdo(ProcessData),
    /// A multiplex PDO; exactly one for each complete one. Boxed, since it is rare and large.
    Mpdo(Box<Addressed>),
    /// A frame of an SDO channel; exactly one for each such frame.
    Sdo(Step),
    /// The end of an SDO transfer.
    Transfer(Arc<Transfer>),
    /// Later knowledge of an earlier frame that is not a finding.
    Note(Note),
    /// A change of a state. No output lists it by itself.
    Change(Change),
    /// A raised rule. Boxed, since it is rare and large.
    Finding(Box<Finding>),
}

/// A PDO and the meaning of its bytes, as far as known.
#[derive(Clone, Debug)]
pub struct ProcessData {
    /// Transmit or receive, seen from the node.
    pub transmit: bool,
    /// PDO number, from 1.
    pub number: u16,
    /// The node that owns the PDO.
    pub node: u8,
    /// The meaning of the bytes.
    pub content: Signals,
    /// The NMT state of the node, if known: 04, 05, 7F.
    pub state: Option<u8>,
    /// The place in the SYNC cycle, if the PDO is synchronous.
    pub sync: Option<Placement>,
    /// True if the capture shows that the node has the PDO disabled.
    pub is_off: bool,
}

/// A multiplex PDO and the object in it.
#[derive(Clone, Debug)]
pub struct Addressed {
    /// Transmit or receive, seen from the node.
    pub transmit: bool,
    /// PDO number, from 1.
    pub number: u16,
    /// The node that owns the PDO.
    pub node: u8,
    /// The destination or source address and the data that it carries.
    pub content: Multiplexed,
    /// A mapping with one entry: the object in the data (bytes 4 to 7), as far as known.
    pub mapping: Mapping,
    /// The source that shows the PDO to be a multiplex one.
    pub from: Provenance,
}

impl Addressed {
    /// Returns the content of the frame by itself.
    pub fn message(&self) -> Message {
        let Self { transmit, number, node, content, .. } = *self;
        Message::Mpdo { transmit, number, node, content }
    }
}

/// The meaning of the bytes of a PDO.
#[derive(Clone, Debug)]
pub enum Signals {
    /// Mapped objects, with the source of the mapping.
    Mapped(Arc<Mapping>, Provenance),
    /// Mapped objects by the mapping of a node that receives the PDO: its node-ID and RPDO. The producer's own mapping
    /// is not known.
    ByConsumer(Arc<Mapping>, Provenance, u8, u16),
    /// No signals.
    None(Unmapped),
}

impl Signals {
    /// Returns the same signals, with `from` as the source that assigns them to the PDO.
    pub fn by(self, from: Provenance) -> Self {
        match self {
            Self::Mapped(mapping, _) => Self::Mapped(mapping, from),
            Self::ByConsumer(mapping, _, node, number) => Self::ByConsumer(mapping, from, node, number),
            Self::None(_) => Self::None(Unmapped::Unconfirmed),
        }
    }
}

/// The reason for a PDO without signals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unmapped {
    /// The mapping is not known completely.
    Unknown,
    /// The mapping is not known completely, and only an unconfirmed write gives the PDO its identifier.
    Unconfirmed,
    /// Only the default mapping of an EDS is known, and the frames of the PDO contradict it.
    Contradicted,
    /// Sub-index 0 of the mapping is 0.
    Disabled,
    /// The PDO is a multiplex one without an address.
    Multiplex,
}

/// The place of a synchronous PDO in its SYNC cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Placement {
    /// Number of the cycle in the capture, from 1, counted in SYNCs.
    pub cycle: u64,
    /// Time since the SYNC in ns, negative if its late echo was captured after the PDO; `None` without stamps.
    pub delay_ns: Option<Ns>,
}

/// An SDO frame and its place in its transfer.
#[derive(Clone, Debug)]
pub struct Step {
    /// The sender.
    pub side: Side,
    /// The decoded command.
    pub command: Command,
    /// The object of its transfer.
    pub mux: Option<Mux>,
    /// The description of that object, as far as known.
    pub described: Described,
    /// Number of the segment in the transfer, from 1; 0 for other frames.
    pub ordinal: u32,
    /// The answer, if it was captured before this request. Boxed, since it is rare.
    pub answered_by: Option<Box<FrameRef>>,
    /// The relation to the transfer.
    pub place: Place,
    /// The transfer that this frame completes.
    pub result: Option<Arc<Transfer>>,
}

impl Step {
    /// Makes a step of a frame alone, decoded but not judged by its channel.
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

/// The relation of an SDO frame to its transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Expected here.
    Due,
    /// A repetition of an unanswered request.
    Repeated,
    /// The answer to a request that has been given up.
    Late,
    /// A frame without its request or the beginning of its transfer in the capture (so far).
    Uncaptured,
    /// A block segment that does not count, because the acknowledgement or an abort was sent while it was under way.
    InFlight,
    /// A block segment out of sequence; the expected number.
    OutOfSequence(u8),
    /// Part of no transfer.
    Outside,
    /// A second capture of the previous frame.
    Duplicate,
}

/// Knowledge of an earlier frame that becomes available later.
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
        /// The switch delay in ms; the bus is silent for twice that time.
        delay: u16,
        /// The new bit rate in kbit/s, where known.
        rate: Option<u16>,
    },
    /// LSS: a node has changed its node-ID.
    NodeIdChanged {
        /// The old node-ID.
        from: u8,
        /// The new node-ID.
        to: u8,
    },
}

/// The result of a Fastscan (CiA 305).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scanned {
    /// True if its last confirmation was answered, so that the slave is in the configuration state.
    pub found: bool,
    /// Vendor-ID, product code, revision number, serial number, as far as confirmed in the capture.
    pub address: [Option<u32>; 4],
    /// Number of Fastscan frames of the master.
    pub frames: u32,
    /// Time from the first frame to the last frame or answer, in ns; `None` without stamps.
    pub duration_ns: Option<Ns>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_are_small() {
        // An event is moved for every frame.
        assert!(size_of::<Event>() <= 144, "{}", size_of::<Event>());
    }
}

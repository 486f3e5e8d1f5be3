//! What a frame means given everything seen before it. Events are values: they hold no words and no state.

use std::sync::Arc;

use crate::finding::Finding;
use crate::frame::{BusId, Frame, FrameRef};
use crate::message::Message;
use crate::services::sdo::transfer::{Transfer, TransferId};
use crate::services::sdo::wire::{Command, Mux, Side, decode_frame};

/// Something that a frame says or proves.
#[derive(Clone, Debug)]
pub struct Event {
    /// The frame that shows it.
    pub at: FrameRef,
    /// The earlier frame it speaks of, if another.
    pub about: Option<FrameRef>,
    /// The bus.
    pub bus: BusId,
    /// The node, where one is concerned.
    pub node: Option<u8>,
    /// The SDO transfer, where one is concerned.
    pub transfer: Option<TransferId>,
    /// What it is.
    pub what: What,
}

/// The kinds of event.
#[derive(Clone, Debug)]
pub enum What {
    /// A frame of a service other than SDO: every such frame has exactly one.
    Message(Message),
    /// A frame of an SDO channel: every such frame has exactly one.
    Sdo(Step),
    /// An SDO transfer has ended.
    Transfer(Arc<Transfer>),
    /// Something that has become known of an earlier frame, and is no finding.
    Note(Note),
    /// A rule has been raised.
    Finding(Finding),
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
    /// Which segment of the transfer it is, from 1; 0 when it is none.
    pub ordinal: u32,
    /// The answer that was captured before this request.
    pub answered_by: Option<FrameRef>,
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
}

/// What becomes known later.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Note {
    /// The request that a response answers is not in the capture.
    RequestNotCaptured,
    /// The request was answered by the abort that was captured before it.
    AnsweredByAbort,
    /// A reset or boot-up of the server ended the transfer.
    LostByReset,
}

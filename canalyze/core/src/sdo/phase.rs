//! The phase of a channel's transfer, and the frame that waits for its other half.

use super::block::Block;
use super::pace::Pace;
use super::wire::{Command, Initiate, Mux};
use crate::bytes::frame::FrameRef;
use crate::evidence::When;

/// One frame of the channel, kept until the other half of its exchange is known.
#[derive(Clone, Copy, Debug)]
pub(super) struct Half {
    pub(super) at: FrameRef,
    pub(super) when: When,
    pub(super) command: Command,
    /// Its reading while the state is unknown.
    pub(super) reading: Option<Command>,
    pub(super) bytes: [u8; 8],
    pub(super) len: u8,
}

impl Half {
    /// Creates a frame without a place in the capture.
    pub(super) fn of(bytes: [u8; 8]) -> Self {
        Self {
            at: FrameRef::default(),
            when: When::default(),
            command: Command::Unknown(0),
            reading: None,
            bytes,
            len: 8,
        }
    }
}

/// The state of a segmented transfer.
#[derive(Debug)]
pub(super) struct Segments {
    /// The toggle bit of the next request.
    pub(super) toggle: bool,
    /// The request that waits for its response.
    pub(super) asked: Option<Half>,
    /// The initiate with e = s = 0 that began the transfer, until a segment explains it.
    pub(super) unmarked: Option<(Half, Initiate)>,
    /// The last response had another toggle bit than its request; the next request decides.
    pub(super) doubtful: bool,
    pub(super) pace: Box<Pace>,
}

impl From<bool> for Segments {
    fn from(toggle: bool) -> Self {
        Self { toggle, asked: None, unmarked: None, doubtful: false, pace: Box::default() }
    }
}

/// The phase of a transfer.
#[derive(Debug)]
pub(super) enum Phase {
    /// No transfer.
    Idle,
    /// The initiate request waits for its response.
    Initiated(Half),
    /// Segmented transfer.
    Segments(Segments),
    /// Block transfer, and the end frame of a download that waits for its confirmation.
    Block(Box<Block>, Option<Half>),
}

/// Returns true for an unmistakable initiate request: a communication or device object, no reserved bits.
pub(super) fn strict_initiate(half: &Half) -> bool {
    half.command.is_initiate()
        && half.command.mux().is_some_and(|Mux { index, .. }| index >= 0x1000)
        && !half.command.has_reserved_bits(half.bytes)
        && match half.command {
            Command::InitiateDownload(_, i) => i.expedited || i.size_indicated,
            _ => true,
        }
}

/// Returns true for an unmistakable response to an initiate request.
pub(super) fn is_strict_answer(half: &Half) -> bool {
    !half.command.is_initiate()
        && half.command.mux().is_some_and(|mux| mux.index >= 0x1000)
        && !half.command.has_reserved_bits(half.bytes)
        && half.len == 8
}

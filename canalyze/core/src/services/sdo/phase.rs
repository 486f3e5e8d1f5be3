//! Where a transfer stands on its channel, and the frame that waits for its other half.
//!
//! Must not: take a frame; that does the channel.

use super::block::Block;
use super::pace::Pace;
use super::wire::{Command, Initiate};
use crate::evidence::When;
use crate::frame::FrameRef;

/// One frame of the channel, kept until the other half of its exchange is known.
#[derive(Clone, Copy, Debug)]
pub(super) struct Half {
    pub(super) at: FrameRef,
    pub(super) when: When,
    pub(super) command: Command,
    /// How it is read while the channel may be in the midst of anything.
    pub(super) reading: Option<Command>,
    pub(super) bytes: [u8; 8],
    pub(super) len: u8,
}

impl Half {
    /// Eight bytes without a place in the capture.
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

/// Segments of a transfer.
#[derive(Debug)]
pub(super) struct Segments {
    /// The toggle bit of the next request.
    pub(super) toggle: bool,
    /// The request that awaits its response.
    pub(super) asked: Option<Half>,
    /// The initiate with e = s = 0 that began the transfer, until a segment shows what it means.
    pub(super) unmarked: Option<(Half, Initiate)>,
    /// The last response had another toggle bit than its request: the next request tells which was right.
    pub(super) doubtful: bool,
    pub(super) pace: Box<Pace>,
}

impl From<bool> for Segments {
    fn from(toggle: bool) -> Self {
        Self { toggle, asked: None, unmarked: None, doubtful: false, pace: Box::default() }
    }
}

/// Where the transfer stands.
#[derive(Debug)]
pub(super) enum Phase {
    /// No transfer.
    Idle,
    /// The initiate request awaits its response.
    Initiated(Half),
    /// Segmented transfer.
    Segments(Segments),
    /// Block transfer; the end frame of a download that awaits its confirmation.
    Block(Box<Block>, Option<Half>),
}

//! Capture formats: one file (or folder) a format, each a push parser that takes bytes in any chunking.
//!
//! A reader sees only `frame`: it knows no CANopen, does no I/O, and never fails. What it cannot read it says.

pub mod candump;

use crate::frame::{BusId, Frame, Stamp};

/// What a reader finds in a capture, in order.
#[derive(Clone, Copy, Debug)]
pub enum Item {
    /// A frame; its `no` is 0 and is given by the session.
    Frame(Frame),
    /// A line that is no frame but says something of the capture.
    Marker(Marker),
    /// Something that should have been a frame and cannot be read.
    Unreadable {
        /// Line in the file, from 1.
        line: u64,
        /// Why not.
        reason: Unreadable,
    },
}

/// A line of a capture that speaks of the capture itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    /// The capturing program lost frames: a gap.
    Dropped {
        /// The bus they were lost on.
        bus: BusId,
        /// How many, as said there.
        count: u64,
        /// How many in total so far, as said there.
        total: u64,
        /// Line in the file, from 1.
        line: u64,
    },
    /// An error marker without any content (`can0  ERROR`).
    Error {
        /// The bus it was seen on.
        bus: BusId,
        /// Its stamp, if any.
        stamp: Option<Stamp>,
        /// Line in the file, from 1.
        line: u64,
    },
    /// Stamps of a pipe were taken as counted from zero, and went backwards: they may be differences (`-t d`).
    Backward {
        /// Line in the file, from 1.
        line: u64,
    },
}

/// Why a line could not be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unreadable {
    /// The line is no frame of any known dialect, nor a comment.
    NoFrame,
    /// The identifier is out of range for its number of digits, or has flag bits that no frame has.
    Identifier,
    /// The length is out of range, or not a length of a CAN FD frame.
    Length,
    /// Fewer data bytes than the length says, or a byte that is no hexadecimal number.
    Data,
    /// The line ends in the middle of a frame: the capture was cut.
    Cut,
    /// A CAN XL frame.
    CanXl,
}

//! A persistent fault is one finding: later faults are consequences of the first.
//!
//! A PDO sent by a second node, or mapped otherwise, is wrong in every frame or every other one.

use crate::bytes::frame::FrameRef;

/// Number of correct frames in a row after which the next fault is new; a second sender leaves fewer between its own.
const ENOUGH: u8 = 8;

/// The faults of one kind of one PDO.
#[derive(Clone, Copy, Debug, Default)]
pub struct Series {
    first: Option<FrameRef>,
    kept: u8,
}

impl Series {
    /// Adds a fault; returns the frame of the first if this is a further one.
    pub fn fault(&mut self, at: FrameRef) -> Option<FrameRef> {
        self.kept = 0;
        let first = self.first;
        self.first = first.or(Some(at));
        first
    }

    /// Adds a correct frame.
    pub fn keep(&mut self) {
        self.kept = self.kept.saturating_add(1);
        if self.kept >= ENOUGH {
            *self = Self::default();
        }
    }
}

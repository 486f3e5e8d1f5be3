//! A fault that goes on is one finding: those that follow the first are its consequences.
//!
//! A PDO that a second node sends, or that is mapped otherwise, is wrong with every frame, or with every other one. It
//! must not judge.

use crate::frame::FrameRef;

/// Correct frames in a row after which the next fault is a new one: a second sender leaves fewer between its own.
const ENOUGH: u8 = 8;

/// Faults of one kind of one PDO.
#[derive(Clone, Copy, Debug, Default)]
pub struct Series {
    first: Option<FrameRef>,
    kept: u8,
}

impl Series {
    /// One more fault. Gives the frame of the first, where it is a further one.
    pub fn fault(&mut self, at: FrameRef) -> Option<FrameRef> {
        self.kept = 0;
        let first = self.first;
        self.first = first.or(Some(at));
        first
    }

    /// A right one.
    pub fn keep(&mut self) {
        self.kept = self.kept.saturating_add(1);
        if self.kept >= ENOUGH {
            *self = Self::default();
        }
    }
}

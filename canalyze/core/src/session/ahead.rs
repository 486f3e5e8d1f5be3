//! Frames that were read and wait until it is known what the recording did with them: whether the recorder had stood
//! still before them, and whether the capture shows them a second time.
//!
//! Verdicts never see a frame whose place is open: where the next few frames tell, they are read first. Nothing is held
//! back in a capture that leaves no doubt. How long a doubt lasts at most says the recording
//! ([`Recording::undecided_since`](crate::evidence::Recording::undecided_since)). It must not decide.

use std::collections::VecDeque;

use super::capture::Origin;
use crate::evidence::When;
use crate::evidence::recording::Happened;
use crate::frame::{Frame, FrameRef};

/// A frame and its place.
#[derive(Debug)]
pub(super) struct Placed {
    pub(super) frame: Frame,
    /// The frame before it on its bus, where their stamps can be compared.
    pub(super) before: Option<FrameRef>,
    /// Its place in the recording; `None` where nobody asks what frames mean.
    pub(super) seen: Option<(When, Happened)>,
}

/// Frames that wait, in the order of the capture.
#[derive(Debug, Default)]
pub(super) struct Ahead {
    held: VecDeque<(Placed, Origin)>,
}

impl Ahead {
    pub(super) fn is_empty(&self) -> bool {
        self.held.is_empty()
    }

    pub(super) fn hold(&mut self, placed: Placed, origin: Origin) {
        self.held.push_back((placed, origin));
    }

    /// The first frame, if its number is below this.
    pub(super) fn take_before(&mut self, number: u64) -> Option<(Placed, Origin)> {
        if self.held.front()?.0.frame.no < number { self.held.pop_front() } else { None }
    }
}

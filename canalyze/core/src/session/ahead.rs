//! Frames that were read and wait until it is known what the recording did with them: whether the recorder had stood
//! still before them, and whether the capture shows them a second time.
//!
//! Verdicts never see a frame whose place is open: where the next few frames tell, they are read first. Nothing is held
//! back in a capture that leaves no doubt. An SDO frame waits, too, where the capture does not show its transfer's
//! beginning: the next one of its channel may show what it is. How long a doubt lasts at most says the recording
//! ([`Recording::undecided_since`](crate::evidence::Recording::undecided_since)). It must not decide.

use std::collections::VecDeque;

use super::capture::Origin;
use crate::bytes::frame::{Frame, FrameRef};
use crate::bytes::ns::Ns;
use crate::evidence::recording::RecordedFrame;

/// For how long the next frame of an SDO channel is awaited, in ns, and in frames where there are no stamps: servers
/// answer sooner.
const AHEAD_NS: Ns = Ns::from_ms(100);
const FRAMES: usize = 32;
/// Most frames that wait for that.
const MOST: usize = 4096;

/// A frame and its place.
#[derive(Debug)]
pub(super) struct Placed {
    pub(super) frame: Frame,
    /// The frame before it on its bus, where their stamps can be compared.
    pub(super) before: Option<FrameRef>,
    /// Its place in the recording; `None` where nobody asks what frames mean.
    pub(super) seen: Option<RecordedFrame>,
}

/// Frames that wait, in the order of the capture.
#[derive(Debug, Default)]
pub(super) struct Ahead {
    held: VecDeque<(Placed, Origin)>,
    /// Frames behind the first of which it is known that they are not the next one of its channel.
    passed: usize,
}

impl Ahead {
    pub(super) fn is_empty(&self) -> bool {
        self.held.is_empty()
    }

    pub(super) fn hold(&mut self, placed: Placed, origin: Origin) {
        self.held.push_back((placed, origin));
    }

    /// The first frame, if its number is below this.
    pub(super) fn first_before(&self, number: u64) -> Option<&Frame> {
        Some(&self.held.front()?.0.frame).filter(|frame| frame.no < number)
    }

    pub(super) fn take(&mut self) -> Option<(Placed, Origin)> {
        self.passed = 0;
        self.held.pop_front()
    }

    /// Returns true if the first frame has waited long enough by `now_ns` for the next one of its channel.
    pub(super) fn is_over(&self, now_ns: Ns) -> bool {
        let first = self.held.front().and_then(|(placed, _)| placed.frame.t_ns);
        first.is_some_and(|first| now_ns - first > AHEAD_NS)
    }

    /// Returns the next frame that belongs to the channel of the first one and is no copy of it.
    pub(super) fn next(&mut self, belongs: impl Fn(&Frame, &Frame) -> bool) -> Behind {
        let (Some((first, _)), Some((newest, _))) = (self.held.front(), self.held.back()) else { return Behind::None };
        let first = first.frame;
        let copy = |frame: &Frame| frame.id == first.id && frame.payload() == first.payload();
        let mut behind = self.held.iter().skip(1 + self.passed).map(|(placed, _)| &placed.frame);
        if let Some(next) = behind.find(|frame| belongs(&first, frame) && !copy(frame)) {
            return Behind::Frame(Box::new(*next));
        }
        self.passed = self.held.len() - 1;
        let over = |now: FrameRef| now.since(first.reference()).map_or(self.held.len() > FRAMES, |ns| ns > AHEAD_NS);
        if over(newest.frame.reference()) || self.held.len() > MOST { Behind::None } else { Behind::Open }
    }
}

/// The next frame of a channel.
pub(super) enum Behind {
    /// This one.
    Frame(Box<Frame>),
    /// None, as far as is read ahead.
    None,
    /// It has not been read yet.
    Open,
}

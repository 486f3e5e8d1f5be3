//! The time of a frame on the bus, as far as the recording shows it.
//!
//! A stamp is not the time on the wire. Its interval may be known only later (frames after a burst prove it), so a
//! [`When`] keeps the facts, and [`Recording`](super::recording::Recording) derives the interval and compares.

use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;

/// The place of a frame in the recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct When {
    /// The frame.
    pub at: FrameRef,
    /// Incremented if frames may be missing or the clock was set; times of two epochs are not comparable.
    pub epoch: u32,
    /// The number of the burst of the frame, from 1, or 0.
    pub burst: u32,
    /// True if it may be the recording host's own frame and listed late.
    pub own: bool,
    /// Silence of the whole bus before the run of frames without a pause that contains it, in ns.
    pub silent_ns: Ns,
}

//! When a frame was on the bus, as far as the recording tells.
//!
//! A stamp is not the time on the wire. Which interval it stands for may be known only later (a burst shows itself as
//! one by the frames after it), so a [`When`] keeps what is needed to tell, and
//! [`Recording`](super::recording::Recording) turns it into an interval when it is asked. It must not compare: the
//! recording does.

use crate::frame::FrameRef;

/// The place of a frame in the recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct When {
    /// The frame.
    pub at: FrameRef,
    /// Counts up where frames may be missing, or where the clock was set: times of two epochs are not comparable.
    pub epoch: u32,
    /// The burst that the frame is in, from 1; 0: none.
    pub burst: u32,
    /// It may be the recording host's own, and be listed late.
    pub own: bool,
    /// How long the whole bus was silent before the run of frames that it is in, in ns: those that followed without a
    /// pause.
    pub silent_ns: i64,
}

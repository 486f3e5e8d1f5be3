//! The time, by the timestamps of frames and by a live source while no frames come.
//!
//! Timestamps of several buses may be a little out of order; time does not go back then. No clock is read.

use crate::bytes::ns::Ns;

/// A timestamp that is earlier by this much means that the clock was set back.
const SET_BACK_NS: Ns = Ns::from_s(1);

/// The time of a capture; `None` without timestamps.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CaptureClock {
    /// Now, in ns.
    pub(super) now_ns: Option<Ns>,
    /// The first timestamp, in ns.
    pub(super) start_ns: Option<Ns>,
}

impl CaptureClock {
    /// Takes the time of a frame.
    pub(super) fn frame(&mut self, t_ns: Ns) {
        let back = self.now_ns.is_some_and(|now| now - t_ns >= SET_BACK_NS);
        self.start_ns = Some(self.start_ns.map_or(t_ns, |start| start.min(t_ns)));
        if back || self.now_ns.is_none_or(|now| t_ns > now) {
            self.now_ns = Some(t_ns);
        }
    }

    /// Advances the time without a frame. Before the first frame there is no time.
    pub(super) fn advance(&mut self, now_ns: Ns) {
        self.now_ns = self.now_ns.map(|now| now.max(now_ns));
    }

    /// Returns the time since a timestamp, in ns.
    pub(super) fn since(&self, ns: Option<Ns>) -> Option<Ns> {
        Some((self.now_ns? - ns?).max(Ns::ZERO))
    }
}

//! Frames that should repeat: the time from one to the next.
//!
//! The period is given, by an expectation; nothing is learnt here.

use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;

/// An expected period and its tolerance, in ns.
#[derive(Clone, Copy, Debug)]
pub struct AllowedPeriod {
    /// The period, in ns.
    pub ns: Ns,
    /// The allowed deviation, in ns.
    pub tolerance_ns: Ns,
}

/// The time from one frame to the next.
#[derive(Clone, Copy, Debug)]
pub struct Interval {
    /// Its length, in ns.
    pub ns: Ns,
    /// It may be short.
    pub loose: bool,
}

/// The last of the frames.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rhythm {
    /// `None` if the next one begins anew.
    pub last: Option<FrameRef>,
    /// Its absence was reported.
    told: bool,
    /// The next interval may be short.
    loose: bool,
}

impl Rhythm {
    /// Takes the next frame. Returns the time since the one before if that is outside the period. `extra`: the frame
    /// may come at any time, and the one after it too soon.
    pub fn beat(&mut self, at: FrameRef, extra: bool, period: AllowedPeriod) -> Option<Ns> {
        let told = self.told;
        let Interval { ns, loose } = self.next(at, extra)?;
        let late = ns - period.ns > period.tolerance_ns;
        let early = !loose && period.ns - ns > period.tolerance_ns;
        (late && !told || early).then_some(ns)
    }

    /// Takes the next frame without a period. Returns the interval to be judged.
    pub fn next(&mut self, at: FrameRef, extra: bool) -> Option<Interval> {
        let before = self.last.replace(at);
        self.told = false;
        let loose = std::mem::replace(&mut self.loose, extra) || extra;
        let ns = at.t_ns? - before?.t_ns?;
        (ns >= Ns::ZERO).then_some(Interval { ns, loose })
    }

    /// Returns, once, the time since the last frame and that frame, if the next one is overdue at `now_ns`.
    pub fn overdue(&mut self, now_ns: Ns, period: AllowedPeriod) -> Option<(Ns, FrameRef)> {
        let last = self.last?;
        let gap = now_ns - last.t_ns?;
        let late = gap - period.ns > period.tolerance_ns;
        (late && !std::mem::replace(&mut self.told, true)).then_some((gap, last))
    }

    /// Separates the frames to come from those before.
    pub fn interrupt(&mut self) {
        *self = Self::default();
    }
}

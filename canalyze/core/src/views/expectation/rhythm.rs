//! What should come again and again: the time from one frame to the next.
//!
//! Its period is given: `evidence::period` learns one, with all that may disturb it, and `diff::cyclic` tells two paces apart.
//! It must not know what the frames are.

use crate::bytes::frame::FrameRef;

/// An expected period, and what it may be off by, in ns.
#[derive(Clone, Copy, Debug)]
pub(super) struct Period {
    pub(super) ns: i64,
    pub(super) tolerance_ns: i64,
}

/// The time from one frame to the next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interval {
    pub(super) ns: i64,
    /// It may be short.
    pub(super) loose: bool,
}

/// The last of the frames.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Rhythm {
    /// `None` where the next one begins anew.
    pub(super) last: Option<FrameRef>,
    /// It was said that it stays away.
    told: bool,
    /// The next interval may be short.
    loose: bool,
}

impl Rhythm {
    /// The next frame. Gives the time since the one before, where that is beyond the period. `extra`: it may come at
    /// any time, and the one after it too soon.
    pub(super) fn beat(&mut self, at: FrameRef, extra: bool, period: Period) -> Option<i64> {
        let told = self.told;
        let Interval { ns, loose } = self.next(at, extra)?;
        let late = ns.saturating_sub(period.ns) > period.tolerance_ns;
        let early = !loose && period.ns.saturating_sub(ns) > period.tolerance_ns;
        (late && !told || early).then_some(ns)
    }

    /// The same without a period: what there is to judge.
    pub(super) fn next(&mut self, at: FrameRef, extra: bool) -> Option<Interval> {
        let before = self.last.replace(at);
        self.told = false;
        let loose = std::mem::replace(&mut self.loose, extra) || extra;
        let ns = at.t_ns?.saturating_sub(before?.t_ns?);
        (ns >= 0).then_some(Interval { ns, loose })
    }

    /// It is `now_ns`. Gives the time since the last frame and that frame, once, where the next one is overdue.
    pub(super) fn overdue(&mut self, now_ns: i64, period: Period) -> Option<(i64, FrameRef)> {
        let last = self.last?;
        let gap = now_ns.saturating_sub(last.t_ns?);
        let late = gap.saturating_sub(period.ns) > period.tolerance_ns;
        (late && !std::mem::replace(&mut self.told, true)).then_some((gap, last))
    }

    /// What comes next has nothing to do with what came before.
    pub(super) fn interrupt(&mut self) {
        *self = Self::default();
    }
}

//! The choice of a frame's time among the three times of its message.
//!
//! Each topic begins with its driver's time (`header.stamp`) and switches for good to the time of publishing, then of
//! recording, at a stamp that is zero, that is neither near the time of recording nor in this century, or that steps
//! back while the recording went on. The clock of a topic thus changes at most twice, and never back.

use super::choice::Clock;

/// Maximum distance of a stamp to the time of recording that shows the same clock, whatever its origin.
const NEAR_NS: i64 = 60_000_000_000;
/// 2000-01-01; later times are absolute.
const CENTURY_NS: i64 = 946_684_800_000_000_000;
/// Maximum backward step of a stamp: messages of one driver are not always published in order.
const BACK_NS: i64 = 1_000_000_000;

/// The clock of one topic.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source {
    now: Clock,
    /// True if the user chose it.
    fixed: bool,
    /// The chosen time and the time of recording of the last message.
    last_ns: (i64, i64),
}

impl Source {
    pub(super) fn new(asked: Option<Clock>) -> Self {
        Self { now: asked.unwrap_or(Clock::Stamp), fixed: asked.is_some(), last_ns: (i64::MIN, i64::MIN) }
    }

    /// Returns the time of a frame, in ns. `stamp` is `None` for a message without one.
    #[inline(always)]
    pub(super) fn time(&mut self, stamp: Option<i64>, publish: i64, log: i64) -> i64 {
        loop {
            let time = match self.now {
                Clock::Stamp => stamp.filter(|stamp| *stamp > 0),
                Clock::Publish => Some(publish).filter(|publish| *publish > 0),
                Clock::Log => Some(log),
            };
            if self.fixed {
                let published = if publish > 0 { publish } else { log };
                return time.unwrap_or(published);
            }
            if let Some(time) = time
                && (self.now == Clock::Log || self.believes(time, log))
            {
                self.last_ns = (time, log);
                return time;
            }
            self.now = if self.now == Clock::Stamp { Clock::Publish } else { Clock::Log };
            self.last_ns = (i64::MIN, i64::MIN);
        }
    }

    #[inline(always)]
    fn believes(&self, time: i64, log: i64) -> bool {
        let dated = time >= CENTURY_NS || time.abs_diff(log) <= NEAR_NS as u64;
        let (last, last_log) = self.last_ns;
        dated && (time >= last.saturating_sub(BACK_NS) || log < last_log)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_is_left_for_good() {
        const DAY: i64 = 1_700_000_000_000_000_000;
        let mut source = Source::new(None);
        assert_eq!(source.time(Some(DAY), DAY + 5, DAY + 9), DAY);
        assert_eq!(source.time(Some(DAY + 10), DAY + 15, DAY + 19), DAY + 10);
        assert_eq!(source.time(Some(0), DAY + 25, DAY + 29), DAY + 25);
        assert_eq!(source.time(Some(DAY + 30), DAY + 35, DAY + 39), DAY + 35);
        assert_eq!(source.time(Some(DAY + 40), 0, DAY + 49), DAY + 49);
        assert_eq!(source.time(Some(DAY + 50), DAY + 55, DAY + 59), DAY + 59);

        // Time since boot beside time of day; time from zero beside the same.
        assert_eq!(Source::new(None).time(Some(5_000), DAY, DAY + 1), DAY);
        assert_eq!(Source::new(None).time(Some(5_000), 6_000, 7_000), 5_000);
        // An old stamp in a file that was converted today.
        assert_eq!(Source::new(None).time(Some(DAY / 2 + CENTURY_NS / 2), DAY, DAY), DAY / 2 + CENTURY_NS / 2);
    }

    #[test]
    fn a_clock_that_was_asked_for() {
        let times = |clock, stamp| Source::new(Some(clock)).time(stamp, 20, 30);
        assert_eq!(times(Clock::Stamp, Some(10)), 10);
        assert_eq!(times(Clock::Stamp, None), 20);
        assert_eq!(times(Clock::Publish, Some(10)), 20);
        assert_eq!(times(Clock::Log, Some(10)), 30);
    }
}

//! The origin of a file's stamps: the start or the previous event, and a date.
//!
//! Each block between triggers has its own date. Files do not say if its stamps continue from the date of the file
//! (Vector's programs, absolute stamps) or restart at that of the block (split and joined files, python-can): the date
//! that brings the first event of the block nearer to the block's date is used.

/// Maximum time in ns from the header to the first event of a file whose stamps are taken as times of day.
const LATE_NS: i64 = 10_000_000_000;
const SECOND_NS: i64 = 1_000_000_000;
const MILLISECOND_NS: i64 = 1_000_000;
const DAY_NS: i64 = 86_400_000_000_000;

/// The clock of a file.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct AscClock {
    relative: bool,
    /// The last time, for stamps that count from the previous event.
    sum: i64,
    /// The date from which stamps count.
    origin: Option<i64>,
    /// A date since the last stamp.
    block: Option<i64>,
    /// False until the first stamp.
    begun: bool,
    /// True if the dates are not real: they only separate blocks, and stamps count from 1970.
    undated: bool,
    /// True until the origin has been returned.
    unsaid: bool,
}

impl AscClock {
    /// Sets the kind of stamps by the header.
    pub(super) fn set_relative(&mut self, relative: bool) {
        self.relative = relative;
    }

    /// Sets a date of the header or of a block.
    pub(super) fn set_date(&mut self, date_ns: i64) {
        if self.begun || self.origin.is_some() {
            self.block = Some(date_ns);
        } else {
            self.set_origin(date_ns);
        }
    }

    /// Marks the dates of this file as not real.
    pub(super) fn set_undated(&mut self) {
        self.undated = true;
    }

    fn set_origin(&mut self, date_ns: i64) {
        self.origin = Some(date_ns);
        self.unsaid = true;
    }

    /// Returns the time of a stamp. Has to be called for every stamped line, whatever it contains.
    #[inline(always)]
    pub(super) fn moment(&mut self, ns: i64) -> i64 {
        if self.begun && self.block.is_none() && !self.relative && !self.undated {
            self.sum = ns;
            return ns;
        }
        self.any_moment(ns)
    }

    fn any_moment(&mut self, ns: i64) -> i64 {
        let mut moment = if self.relative { self.sum.saturating_add(ns) } else { ns };
        if let Some(date) = self.block.take() {
            let behind = self.origin.map(|origin| date.saturating_sub(origin));
            // A date is no more precise than its last digit; differences continue across it.
            let digit = if date % SECOND_NS == 0 { SECOND_NS } else { MILLISECOND_NS };
            let digit = if self.relative { digit } else { 0 };
            let near = |behind: i64| {
                let off = moment.saturating_sub(behind);
                off.saturating_abs() < ns.saturating_abs() || (0..digit).contains(&off)
            };
            if !behind.is_some_and(|behind| behind == 0 || near(behind)) {
                self.set_origin(date);
                moment = ns;
            }
        }
        if !self.begun {
            self.begun = true;
            self.time_of_day(ns);
        }
        self.sum = moment;
        if self.undated { moment.saturating_add(self.origin.unwrap_or(0)) } else { moment }
    }

    /// Detects a first stamp that is the time of day in the header's date: the stamps count from midnight, as in
    /// BusMaster.
    fn time_of_day(&mut self, ns: i64) {
        let Some(origin) = self.origin else { return };
        let time = origin.rem_euclid(DAY_NS);
        if !self.relative && time > LATE_NS && (0..LATE_NS).contains(&ns.saturating_sub(time)) {
            self.set_origin(origin.saturating_sub(time));
        }
    }

    /// Returns the date from which stamps count, once. Called after [`Self::moment`].
    #[inline(always)]
    pub(super) fn start(&mut self) -> Option<i64> {
        if self.unsaid && !self.undated {
            self.unsaid = false;
            return self.origin;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::AscClock;

    const S: i64 = 1_000_000_000;
    const DATE: i64 = 1_506_784_000 * S;

    #[test]
    fn a_block_goes_on_or_begins_anew() {
        let mut clock = AscClock::default();
        clock.set_date(DATE);
        clock.set_date(DATE + 3 * S);
        // Three seconds after the header, and the first event agrees.
        assert_eq!((clock.moment(3 * S + 1), clock.start()), (3 * S + 1, Some(DATE)));
        assert_eq!((clock.moment(4 * S), clock.start()), (4 * S, None));
        clock.set_date(DATE + 60 * S);
        assert_eq!((clock.moment(61 * S), clock.start()), (61 * S, None));
        clock.set_date(DATE + 90 * S);
        assert_eq!((clock.moment(0), clock.start()), (0, Some(DATE + 90 * S)));
        clock.set_date(DATE - 5 * S);
        assert_eq!((clock.moment(10), clock.start()), (10, Some(DATE - 5 * S)));
    }

    #[test]
    fn stamps_since_the_event_before() {
        let mut clock = AscClock::default();
        clock.set_relative(true);
        clock.set_date(DATE);
        let moments: Vec<i64> = [0, 5, 5, 10].map(|ns| clock.moment(ns)).to_vec();
        assert_eq!(moments, [0, 5, 10, 20]);
        clock.set_date(DATE + 100 * S);
        assert_eq!((clock.moment(7), clock.start()), (7, Some(DATE + 100 * S)));
        assert_eq!(clock.moment(7), 14);
        // A block begins between two events, with a date in ms: no event is earlier than the previous one.
        clock.set_date(DATE + 100 * S + 191_000_000);
        assert_eq!((clock.moment(191_000_800), clock.start()), (191_000_814, None));
        clock.set_date(DATE + 100 * S + 191_000_000);
        assert_eq!((clock.moment(0), clock.start()), (191_000_814, None));
        clock.set_date(DATE + 101 * S);
        assert_eq!((clock.moment(900_000_000), clock.start()), (1_091_000_814, None));
        clock.set_date(DATE + 101 * S);
        assert_eq!((clock.moment(5), clock.start()), (1_091_000_819, None));
        clock.set_date(DATE + 109 * S);
        assert_eq!((clock.moment(5), clock.start()), (5, Some(DATE + 109 * S)));
    }

    #[test]
    fn stamps_that_are_the_time_of_day() {
        let mut clock = AscClock::default();
        let midnight = DATE - DATE % (86_400 * S);
        clock.set_date(midnight + 40_873 * S);
        let stamp = 40_874_800_000_000;
        assert_eq!((clock.moment(stamp), clock.start()), (stamp, Some(midnight)));
    }

    #[test]
    fn no_date() {
        let mut clock = AscClock::default();
        assert_eq!((clock.moment(7), clock.start()), (7, None));
        let mut clock = AscClock::default();
        clock.set_date(0);
        clock.set_undated();
        assert_eq!((clock.moment(7), clock.start()), (7, None));
        clock.set_date(-S);
        assert_eq!((clock.moment(1), clock.start()), (1 - S, None));
    }
}

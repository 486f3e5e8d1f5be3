//! The longest time that a sender waits although nothing changes: an event timer that nobody has named.
//!
//! A sender that only reports changes does not repeat what it has said. If it does, always after the same time, and
//! never waits for longer, then a timer makes it send. So it does if many frames in a row come after the same time, whatever
//! they say.

use crate::bytes::ns::Ns;

/// Part of the longest gap by which the gaps of one timer differ.
const EVEN_PART: i64 = 16;
/// Number of unchanged frames after the longest gap that show a timer.
const SHOWN: u32 = 10;

/// Number of frames in a row after gaps of that length that show a timer, even if each frame is changed.
const EVEN: u32 = 40;

/// A timer that is being learnt.
#[derive(Clone, Copy, Debug, Default)]
pub struct Timer {
    longest_ns: Ns,
    /// Number of unchanged frames after a gap of that length.
    reached: u32,
    /// Number of frames in a row after a gap of that length, whatever they say.
    even: u32,
}

impl Timer {
    /// Learns from a gap in ns; `unchanged`: the frame behind it says the same as the one before.
    pub fn take(&mut self, gap_ns: Ns, unchanged: bool) {
        let room_ns = self.longest_ns / EVEN_PART;
        if gap_ns > self.longest_ns + room_ns {
            (self.longest_ns, self.reached, self.even) = (gap_ns, 0, 0);
        }
        let reaches = gap_ns > Ns::ZERO && gap_ns >= self.longest_ns - room_ns;
        self.reached = self.reached.saturating_add(u32::from(unchanged && reaches));
        self.even = if reaches { self.even.saturating_add(1) } else { 0 };
    }

    /// Returns true if changes alone may have made the even times: a signal that is sampled, and rests later.
    pub fn may_be_changes(&self) -> bool {
        self.reached < SHOWN
    }

    /// Returns the time in ns, once it is shown.
    pub fn ns(&self) -> Option<Ns> {
        (self.reached >= SHOWN || self.even >= EVEN).then_some(self.longest_ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn taught(gaps: &[(i64, bool)]) -> Option<i64> {
        let mut timer = Timer::default();
        gaps.iter().for_each(|(gap_ns, unchanged)| timer.take(Ns(*gap_ns), *unchanged));
        timer.ns().map(Ns::as_ns)
    }

    #[test]
    fn changes_between_hide_no_timer() {
        let gaps: Vec<_> = (0..30).map(|at| if at % 3 == 0 { (17, false) } else { (200, true) }).collect();
        assert_eq!(taught(&gaps), Some(200));
    }

    #[test]
    fn few_changes_show_none() {
        assert_eq!(taught(&[(200, false); 39]), None);
        assert_eq!(taught(&[(200, false); 40]), Some(200));
        let uneven: Vec<_> = (0..400).map(|at| (200 - at % 40, false)).collect();
        assert_eq!(taught(&uneven), None);
        assert_eq!(taught(&[(200, true); 9]), None);
    }

    #[test]
    fn a_longer_gap_shows_that_there_was_none() {
        let mut gaps = vec![(200, true); 20];
        gaps.push((700, false));
        assert_eq!(taught(&gaps), None);
    }
}

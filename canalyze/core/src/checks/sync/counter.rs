//! The synchronous counter (CiA 301, 7.2.5.3.1): 1 in the first SYNC, then one more in each, and 1 again after the
//! overflow value (1019h).
//!
//! An unexpected value is held until the next one explains it: a gap, one wrong byte, or a SYNC of another producer.

use crate::bytes::frame::FrameRef;

/// Number of fitting SYNCs in a row after which a foreign one is not from a producer seen before.
const ALONE: u8 = 3;
/// The highest counter value.
const HIGHEST: u8 = 240;

/// A fault of a counter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Miscount {
    /// Another value than expected, with its frame.
    Gap {
        /// The value.
        found: u8,
        /// The expected value.
        expected: u8,
        /// Its frame.
        at: FrameRef,
    },
    /// 0, or above the overflow value.
    Outside {
        /// The value.
        found: u8,
        /// The highest value allowed.
        limit: u8,
    },
    /// Two counters side by side: a value of each.
    Two {
        /// The value of the SYNC outside the first sequence.
        found: u8,
        /// The value expected in the first sequence.
        expected: u8,
        /// The frame of `found`.
        at: FrameRef,
    },
}

#[derive(Clone, Copy, Debug)]
struct HeldCount {
    value: u8,
    expected: u8,
    at: FrameRef,
}

/// The state of the counter.
#[derive(Debug, Default)]
pub struct Counter {
    /// The next value.
    expected: Option<u8>,
    last: u8,
    /// The overflow value learnt from the traffic.
    learnt: Option<u8>,
    held: Option<HeldCount>,
    /// The first overflow, believed once the next value follows from it.
    run_over: Option<HeldCount>,
    /// The next value of a second sequence.
    second: Option<u8>,
    /// Number of fitting SYNCs in a row since one outside the sequence; `None` if there was none.
    fitted: Option<u8>,
    /// Two producers were reported.
    two: bool,
}

impl Counter {
    /// Forgets the next value, because frames were lost or a SYNC had no counter.
    pub fn forget(&mut self) {
        *self = Self { learnt: self.learnt, ..Self::default() };
    }

    /// Takes a change of the configured overflow value.
    pub fn reconfigured(&mut self) {
        *self = Self::default();
    }

    /// Returns true if a second producer has recently counted beside the first.
    pub fn are_two(&self) -> bool {
        self.two
    }

    /// Returns true if each value so far has followed from the one before, so that one producer sent all SYNCs.
    pub fn is_single(&self) -> bool {
        self.expected.is_some() && self.held.is_none() && self.second.is_none() && self.fitted.is_none()
    }

    /// Returns true if a value begins a sequence anew, before the one so far has come to its end.
    pub fn begins_again(&self, value: u8) -> bool {
        value == 1 && self.expected.is_some_and(|expected| expected != 1)
    }

    /// Takes a value. `exact`: the producer's overflow value. `restarted`: the producer may begin again with 1.
    pub fn step(&mut self, value: u8, at: FrameRef, exact: Option<u8>, restarted: bool) -> [Option<Miscount>; 2] {
        let overflow = exact.or(self.learnt);
        let limit = exact.unwrap_or(HIGHEST);
        if value == 0 || value > limit {
            let held = self.held.take().map(gap);
            self.run_over = None;
            self.expected = self.expected.map(|expected| next(expected, overflow));
            return [held, Some(Miscount::Outside { found: value, limit })];
        }
        let Some(expected) = self.expected else {
            self.accept(value, overflow);
            return [None, None];
        };
        if restarted && value == 1 {
            let held = self.held.take().map(gap);
            self.accept(value, overflow);
            return [held, None];
        }
        if let Some(held) = self.held.take() {
            return [self.settle(held, value, overflow), None];
        }
        if let Some(doubt) = self.run_over.take()
            && (value == doubt.expected || value == next(doubt.expected, None))
            && value != 2
        {
            // It was one wrong byte that read 1, or a 1 beside the sequence.
            self.learnt = None;
            return [self.settle(doubt, value, exact), None];
        }
        if value == expected {
            self.accept(value, overflow);
        } else if exact.is_none() && self.learnt.is_none() && value == 1 && self.last >= 2 {
            self.run_over = Some(HeldCount { value, expected: next(self.last, None), at });
            self.learnt = Some(self.last);
            self.accept(value, self.learnt);
        } else if exact.is_none() && self.learnt == Some(self.last) && value == next(self.last, None) {
            // The supposed overflow value was a restart.
            self.learnt = None;
            self.accept(value, None);
        } else if self.two && self.second == Some(value) {
            self.second = Some(next(value, overflow));
            self.fitted = Some(0);
        } else {
            self.held = Some(HeldCount { value, expected, at });
        }
        [None, None]
    }

    /// Returns the held value at the end of the capture.
    pub fn finish(&mut self) -> Option<Miscount> {
        self.held.take().map(gap)
    }

    fn settle(&mut self, held: HeldCount, value: u8, overflow: Option<u8>) -> Option<Miscount> {
        // The sequence goes on, so `held` was beside it.
        if value == held.expected {
            let alone = if self.two { 2 * ALONE } else { ALONE };
            let again = self.fitted.is_some_and(|fitted| fitted < alone);
            self.second = Some(next(held.value, overflow));
            self.accept(value, overflow);
            self.fitted = Some(1);
            if std::mem::replace(&mut self.two, again) && again {
                return None;
            }
            let HeldCount { value: found, expected, at } = held;
            return Some(if again { Miscount::Two { found, expected, at } } else { gap(held) });
        }
        self.accept(value, overflow);
        Some(gap(held))
    }

    fn accept(&mut self, value: u8, overflow: Option<u8>) {
        self.last = value;
        self.expected = Some(next(value, overflow));
        self.fitted = self.fitted.map(|fitted| fitted.saturating_add(1));
        self.two &= self.fitted.is_some_and(|fitted| fitted <= 2 * ALONE);
    }
}

fn gap(held: HeldCount) -> Miscount {
    Miscount::Gap { found: held.value, expected: held.expected, at: held.at }
}

fn next(value: u8, overflow: Option<u8>) -> u8 {
    if overflow == Some(value) || value >= HIGHEST { 1 } else { value + 1 }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::indexing_slicing)]
    use super::*;

    /// Returns the faults of a sequence: number of the value that reveals it, kind, frame at fault.
    fn shown(values: &[u8], exact: Option<u8>) -> Vec<(usize, char, u64)> {
        let mut counter = Counter::default();
        let mut out = Vec::new();
        let mut say = |number: usize, miscount: Option<Miscount>| match miscount {
            Some(Miscount::Gap { at, .. }) => out.push((number, 'g', at.no)),
            Some(Miscount::Outside { .. }) => out.push((number, 'o', number as u64)),
            Some(Miscount::Two { at, .. }) => out.push((number, '2', at.no)),
            None => {}
        };
        for (number, value) in values.iter().enumerate() {
            let at = FrameRef { no: number as u64, ..FrameRef::default() };
            for miscount in counter.step(*value, at, exact, false) {
                say(number, miscount);
            }
        }
        say(values.len(), counter.finish());
        out
    }

    #[test]
    fn what_counters_show() {
        let none: Vec<(usize, char, u64)> = Vec::new();
        for (values, exact, want) in [
            (&[7, 8, 9, 1, 2, 3][..], None, none.clone()),
            (&[1, 2, 3, 4, 1, 2], Some(4), none.clone()),
            (&[239, 240, 1, 2], None, none.clone()),
            (&[8, 9, 1, 2, 8, 9, 1, 2], None, vec![(5, 'g', 4)]),
            // A restart taken for the overflow value.
            (&[4, 5, 1, 2, 3, 4, 5, 6, 7, 8, 1, 2], None, none.clone()),
            (&[1, 2, 3, 5, 6, 7], None, vec![(4, 'g', 3)]),
            (&[1, 2, 3, 99, 5, 6], None, vec![(4, 'g', 3)]),
            (&[1, 2, 3, 1, 5, 6], None, vec![(4, 'g', 3)]),
            (&[1, 2, 3, 0, 5, 6], None, vec![(3, 'o', 3)]),
            (&[1, 2, 3, 9, 1, 2], Some(4), vec![(3, 'o', 3)]),
            (&[1, 2, 3, 3, 4, 5], None, vec![(4, 'g', 3)]),
            (&[1, 2, 3, 4, 1, 2, 1, 2, 3], Some(4), vec![(7, 'g', 6)]),
            (&[1, 2, 3, 7], None, vec![(4, 'g', 3)]),
            (&[5, 12, 6, 13, 7, 14, 8, 15], None, vec![(2, 'g', 1), (4, '2', 3)]),
            (&[3, 9, 40, 41], None, vec![(2, 'g', 1)]),
            // Another producer whose counter does not count.
            (&[1, 7, 2, 7, 3, 7, 4, 7, 5], None, vec![(2, 'g', 1), (4, '2', 3)]),
        ] {
            assert_eq!(shown(values, exact), want, "{values:?}");
        }
    }
}

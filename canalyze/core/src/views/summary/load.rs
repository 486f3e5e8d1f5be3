//! The load of a bus: bits and frames in total and in the busiest window, and the longest burst.
//!
//! A window slides by a tenth of its length, so that its peak does not depend on the start of seconds. The meaning of
//! frames does not matter here.

use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;

/// Lengths in ns of the windows whose peaks are measured.
pub const WINDOWS: [Ns; 2] = [Ns::from_s(1), Ns::from_ms(100)];
/// Steps of a window.
const STEPS: usize = 10;
/// Bit times between two frames, beyond the three of the intermission, that still count as back to back, since
/// timestamps are inexact.
const SLACK: i64 = 20;

/// The duration of a bit, in ns / 65536: a product per frame costs less than a division.
#[derive(Clone, Copy, Debug)]
pub struct BitTime(i64);

impl BitTime {
    /// Returns the duration of a bit at a bit rate in bit/s.
    pub fn at(bit_rate: u32) -> Self {
        Self((1_000_000_000 << 16) / i64::from(bit_rate.max(1)))
    }

    /// Returns the duration of a number of bits in ns.
    fn of(self, bits: i64) -> Ns {
        Ns(bits.saturating_mul(self.0) >> 16)
    }
}

/// The maximum of a window.
#[derive(Clone, Copy, Debug, Default)]
pub struct Peak {
    /// The amount.
    pub amount: u64,
    /// The frame with which it was reached.
    pub at: FrameRef,
}

/// A sliding window.
#[derive(Clone, Debug)]
pub struct Window {
    step_ns: Ns,
    /// The end of the current step.
    end_ns: Ns,
    /// Bits and frames of the last steps; the current one is at `now`.
    steps: [(u64, u64); STEPS],
    now: usize,
    sum: (u64, u64),
    bits: Peak,
    frames: Peak,
}

impl Window {
    /// Creates a window of this length, which is at least ten ns.
    pub fn new(length_ns: Ns) -> Self {
        let step_ns = (length_ns / STEPS as i64).max(Ns(1));
        Self {
            step_ns,
            end_ns: step_ns,
            steps: [(0, 0); STEPS],
            now: 0,
            sum: (0, 0),
            bits: Peak::default(),
            frames: Peak::default(),
        }
    }

    /// Takes a frame of `bits` bits, at `at_ns` since the first one.
    pub fn add(&mut self, at_ns: Ns, bits: u64, frame: FrameRef) {
        if at_ns >= self.end_ns {
            self.slide(at_ns);
        }
        if let Some(step) = self.steps.get_mut(self.now) {
            *step = (step.0 + bits, step.1 + 1);
        }
        self.sum = (self.sum.0 + bits, self.sum.1 + 1);
        for (peak, sum) in [(&mut self.bits, self.sum.0), (&mut self.frames, self.sum.1)] {
            if sum > peak.amount {
                *peak = Peak { amount: sum, at: frame };
            }
        }
    }

    /// Returns the number of bits in it, with the last frame.
    pub fn bits_now(&self) -> u64 {
        self.sum.0
    }

    fn slide(&mut self, at_ns: Ns) {
        let passed = (at_ns - self.end_ns) / self.step_ns + 1;
        self.end_ns += self.step_ns * passed;
        for _ in 0..passed.min(STEPS as i64) {
            self.now = (self.now + 1) % STEPS;
            if let Some(step) = self.steps.get_mut(self.now) {
                self.sum = (self.sum.0 - step.0, self.sum.1 - step.1);
                *step = (0, 0);
            }
        }
    }
}

/// Frames back to back.
#[derive(Clone, Copy, Debug, Default)]
pub struct Burst {
    /// The number of frames.
    pub frames: u64,
    /// From the beginning of the first to the end of the last, in ns.
    pub length_ns: Ns,
    /// The first one.
    pub first: FrameRef,
}

/// The load of one bus.
#[derive(Clone, Debug)]
pub struct Load {
    /// Bits on the wire.
    pub bits: u64,
    /// Bits without those of the capture's first timestamp, which were sent before the measured time.
    pub timed_bits: u64,
    /// Frames, likewise.
    pub timed_frames: u64,
    windows: [Window; 2],
    burst: Burst,
    longest: Burst,
    /// Time of the last frame in ns.
    last_ns: Ns,
}

impl Default for Load {
    fn default() -> Self {
        Self {
            bits: 0,
            timed_bits: 0,
            timed_frames: 0,
            windows: WINDOWS.map(Window::new),
            burst: Burst::default(),
            longest: Burst::default(),
            last_ns: Ns::ZERO,
        }
    }
}

impl Load {
    /// Takes a frame of `bits` bits, at `at_ns` since the capture's first frame; `None` without timestamps.
    pub fn add(&mut self, bits: u32, at_ns: Option<Ns>, bit_time: Option<BitTime>, frame: FrameRef) {
        self.bits += u64::from(bits);
        let Some(at_ns) = at_ns else { return };
        if at_ns > Ns::ZERO {
            self.timed_bits += u64::from(bits);
            self.timed_frames += 1;
        }
        for window in &mut self.windows {
            window.add(at_ns, u64::from(bits), frame);
        }
        if let Some(bit_time) = bit_time {
            self.follow(bit_time.of(i64::from(bits)), bit_time.of(SLACK), at_ns, frame);
        }
    }

    fn follow(&mut self, took_ns: Ns, slack_ns: Ns, at_ns: Ns, frame: FrameRef) {
        if self.burst.frames > 0 && at_ns - self.last_ns <= took_ns + slack_ns {
            self.burst.frames += 1;
            self.burst.length_ns += at_ns - self.last_ns;
        } else {
            self.burst = Burst { frames: 1, length_ns: took_ns, first: frame };
        }
        self.last_ns = at_ns;
        if self.burst.frames > self.longest.frames {
            self.longest = self.burst;
        }
    }

    /// The maximum number of bits, and of frames, in each of [`WINDOWS`].
    pub fn peaks(&self) -> [(Ns, Peak, Peak); WINDOWS.len()] {
        let [second, tenth] = &self.windows;
        let [of_second, of_tenth] = WINDOWS;
        [(of_second, second.bits, second.frames), (of_tenth, tenth.bits, tenth.frames)]
    }

    /// The longest burst of two frames or more, if the bit rate is known and there are timestamps.
    pub fn longest_burst(&self) -> Option<Burst> {
        (self.longest.frames > 1).then_some(self.longest)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;

    fn at(no: u64) -> FrameRef {
        FrameRef { no, ..FrameRef::default() }
    }

    #[test]
    fn the_peak_is_found_wherever_seconds_begin() {
        let mut load = Load::default();
        // 50 frames around the end of the first second, then silence, then one.
        for no in 0..50 {
            load.add(100, Some(Ns(960_000_000 + no * 1_600_000)), None, at(no as u64 + 1));
        }
        load.add(100, Some(Ns(7_000_000_000)), None, at(51));
        let peaks = load.peaks().map(|(length, bits, frames)| (length, bits.amount, frames.amount));
        assert_eq!(peaks, [(Ns::from_s(1), 5_000, 50), (Ns::from_ms(100), 5_000, 50)]);
        assert_eq!((load.bits, load.timed_bits, load.timed_frames), (5_100, 5_100, 51));
    }

    #[test]
    fn what_is_past_leaves_the_window() {
        let mut load = Load::default();
        for no in 0..1_000 {
            load.add(10, Some(Ns::from_ms(no * 10)), None, at(no as u64 + 1));
        }
        let peaks = load.peaks().map(|(_, bits, frames)| (bits.amount, frames.amount, frames.at.no));
        assert_eq!(peaks, [(1_000, 100, 100), (100, 10, 10)]);
    }

    #[test]
    fn bursts_are_back_to_back() {
        let mut load = Load::default();
        // 100 bits at 500 kbit/s are 200 µs; 20 bits more are 40 µs.
        let mut now = 0;
        for (no, gap) in [1_000, 200, 240, 241, 200, 5_000, 200, 200, 220, 900].into_iter().enumerate() {
            now += gap * 1_000;
            load.add(100, Some(Ns(now)), Some(BitTime::at(500_000)), at(no as u64 + 1));
        }
        let burst = load.longest_burst().unwrap();
        assert_eq!((burst.frames, burst.length_ns, burst.first.no), (4, Ns::from_us(820), 6));
        assert!(Load::default().longest_burst().is_none());
    }
}

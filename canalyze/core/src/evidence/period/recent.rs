//! The latest gaps of a stream, and its usual gap.

use crate::bytes::ns::Ns;

use std::cmp::Ordering;

/// Number of gaps from which period and jitter are computed.
const KEPT: usize = 16;

/// The last gaps of a stream.
#[derive(Clone, Copy, Debug, Default)]
pub struct RecentGaps {
    gaps: [Ns; KEPT],
    measured: usize,
}

impl RecentGaps {
    /// Adds a gap, in ns.
    pub fn add(&mut self, gap_ns: Ns) {
        if let Some(slot) = self.gaps.get_mut(self.measured % KEPT) {
            *slot = gap_ns;
        }
        self.measured += 1;
    }

    /// Returns the mean of the gaps in ns, and the greatest deviation from it if there are several.
    pub fn period(&self) -> Option<(Ns, Option<Ns>)> {
        let gaps = self.gaps.get(..self.measured.min(KEPT)).filter(|gaps| !gaps.is_empty())?;
        let mean = gaps.iter().map(|gap| i128::from(gap.as_ns())).sum::<i128>() / gaps.len() as i128;
        let mean = Ns(mean as i64);
        let jitter = gaps.iter().map(|gap| (*gap - mean).abs()).max()?;
        Some((mean, Some(jitter).filter(|_| gaps.len() > 1)))
    }
}

/// Number of gaps that show how often a stream usually comes.
const TAUGHT: u32 = 8;
/// Ratio to the median gap from which on a gap does not count: a pause, or a frame between two others.
const ODD: i64 = 3;
/// Part of the median by which one gap changes it: for the first gaps, their number, and after them.
const FIRST_STEP: i64 = 4;
const FIRST: u32 = 32;
const STEP: i64 = 64;
/// Even traffic deviates by less than this part of its period.
const EVEN: i64 = 8;

/// The mean gap of a stream, without its pauses, and without what comes between.
#[derive(Clone, Copy, Debug, Default)]
pub struct UsualGap {
    /// The mean in ns.
    pub ns: Ns,
    /// The mean deviation of gaps from it, in ns.
    off_ns: Ns,
    /// Number of gaps in the mean.
    count: u32,
    /// The median of all gaps in ns, about, and their number.
    median_ns: Ns,
    seen: u32,
}

impl UsualGap {
    /// Returns true if enough gaps have shown it.
    pub fn is_known(&self) -> bool {
        self.count >= TAUGHT
    }

    /// Returns true if it is known and the stream keeps it.
    pub fn is_even(&self) -> bool {
        self.is_known() && self.off_ns * EVEN < self.ns
    }

    /// Learns from a gap in ns.
    #[inline]
    pub fn learn(&mut self, gap_ns: Ns) {
        // Not one division by the one or the other: by a constant each is a shift.
        let step = if self.seen < FIRST { self.median_ns / FIRST_STEP } else { self.median_ns / STEP };
        self.median_ns = match gap_ns.cmp(&self.median_ns) {
            _ if self.seen == 0 => gap_ns,
            Ordering::Greater => gap_ns.min(self.median_ns + step),
            Ordering::Less => gap_ns.max(self.median_ns - step),
            Ordering::Equal => gap_ns,
        };
        self.seen = self.seen.saturating_add(1);
        let near = |ns: Ns| ns * ODD > self.median_ns && ns < self.median_ns * ODD;
        if !near(gap_ns) {
            return;
        }
        if self.count > 0 && !near(self.ns) {
            self.count = 0;
        }
        let mean = if self.count == 0 { gap_ns } else { self.ns };
        self.ns = mean + (gap_ns - mean) / 8;
        let off_ns = (gap_ns - self.ns).abs();
        self.off_ns += (off_ns - self.off_ns) / 8;
        self.count = self.count.saturating_add(1);
    }
}

//! The latest gaps of a stream, and its usual gap.

/// Number of gaps from which period and jitter are computed.
const KEPT: usize = 16;

/// The last gaps of a stream.
#[derive(Clone, Copy, Debug, Default)]
pub struct RecentGaps {
    gaps: [i64; KEPT],
    measured: usize,
}

impl RecentGaps {
    /// Adds a gap, in ns.
    pub fn add(&mut self, gap_ns: i64) {
        if let Some(slot) = self.gaps.get_mut(self.measured % KEPT) {
            *slot = gap_ns;
        }
        self.measured += 1;
    }

    /// Returns the mean of the gaps in ns, and the greatest deviation from it if there are several.
    pub fn period(&self) -> Option<(i64, Option<i64>)> {
        let gaps = self.gaps.get(..self.measured.min(KEPT)).filter(|gaps| !gaps.is_empty())?;
        let mean = gaps.iter().map(|gap| i128::from(*gap)).sum::<i128>() / gaps.len() as i128;
        let mean = mean as i64;
        let jitter = gaps.iter().map(|gap| gap.saturating_sub(mean).saturating_abs()).max()?;
        Some((mean, Some(jitter).filter(|_| gaps.len() > 1)))
    }
}

/// Number of gaps that show how often a stream usually comes.
const TAUGHT: u32 = 8;
/// Ratio to the usual gap from which on a gap is a pause.
const PAUSE: i64 = 3;
/// Even traffic deviates by less than this part of its period.
const EVEN: i64 = 8;

/// The mean gap of a stream, without its pauses.
#[derive(Clone, Copy, Debug, Default)]
pub struct UsualGap {
    /// The mean in ns.
    pub ns: i64,
    /// The mean deviation of gaps from it, in ns.
    off_ns: i64,
    /// Number of gaps.
    count: u32,
}

impl UsualGap {
    /// Returns true if enough gaps have shown it.
    pub fn is_known(&self) -> bool {
        self.count >= TAUGHT
    }

    /// Returns true if it is known and the stream keeps it.
    pub fn is_even(&self) -> bool {
        self.is_known() && self.off_ns.saturating_mul(EVEN) < self.ns
    }

    /// Learns from a gap in ns; pauses do not count.
    pub fn learn(&mut self, gap_ns: i64) {
        // The first gap may have been a pause.
        if self.count > 0 && !self.is_known() && gap_ns.saturating_mul(PAUSE) < self.ns {
            self.count = 0;
        }
        if self.count > 0 && gap_ns >= self.ns.saturating_mul(PAUSE) {
            return;
        }
        let mean = if self.count == 0 { gap_ns } else { self.ns };
        self.ns = mean.saturating_add(gap_ns.saturating_sub(mean) / 8);
        let off_ns = gap_ns.saturating_sub(self.ns).saturating_abs();
        self.off_ns = self.off_ns.saturating_add(off_ns.saturating_sub(self.off_ns) / 8);
        self.count = self.count.saturating_add(1);
    }
}

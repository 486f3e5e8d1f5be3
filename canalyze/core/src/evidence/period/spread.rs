//! Distributions of times: count, least, mean, greatest, standard deviation and percentiles, in memory that does not
//! grow with their number.
//!
//! Percentiles come from logarithmic buckets: each power of two of nanoseconds is divided into [`PARTS`] equal parts,
//! and a percentile is the upper end of its bucket (never above the greatest time). It is therefore at most 1/32 = 3.2
//! % above the true one, and never below it. The caller has to exclude negative times.

use crate::bytes::ns::Ns;

/// Parts of a power of two.
const PARTS: u64 = 32;
/// log2 of [`PARTS`].
const PARTS_BITS: u32 = 5;
/// Times up to 2^40 ns (18 minutes) have buckets of their own; longer ones share the last one.
const MOST_BITS: u32 = 40;
/// log2 of the width in ns of the buckets of small times: up to 1 µs they are 32 ns wide.
const LEAST_BITS: u32 = 5;

/// Times without percentiles.
#[derive(Clone, Copy, Debug, Default)]
pub struct Spread {
    /// The number of times.
    pub count: u64,
    /// The least in ns; 0 if there is none.
    pub min_ns: Ns,
    /// The greatest in ns; 0 if there is none.
    pub max_ns: Ns,
    /// The first one: the others are summed as differences from it, which keeps their squares exact.
    first_ns: Ns,
    sum: f64,
    squares: f64,
}

impl Spread {
    /// Takes one time in ns.
    pub fn add(&mut self, ns: Ns) {
        if self.count == 0 {
            (self.first_ns, self.min_ns, self.max_ns) = (ns, ns, ns);
        }
        self.count += 1;
        self.min_ns = self.min_ns.min(ns);
        self.max_ns = self.max_ns.max(ns);
        let difference = (ns - self.first_ns).as_ns() as f64;
        self.sum += difference;
        self.squares += difference * difference;
    }

    /// The mean in ns.
    pub fn mean_ns(&self) -> Ns {
        if self.count == 0 {
            return Ns::ZERO;
        }
        self.first_ns + Ns((self.sum / self.count as f64).round() as i64)
    }

    /// The standard deviation (of all times, divisor n) in ns.
    pub fn sigma_ns(&self) -> Ns {
        if self.count == 0 {
            return Ns::ZERO;
        }
        let mean = self.sum / self.count as f64;
        Ns((self.squares / self.count as f64 - mean * mean).max(0.0).sqrt().round() as i64)
    }
}

/// Times with percentiles.
#[derive(Clone, Debug, Default)]
pub struct Ranked {
    /// All figures except percentiles.
    pub spread: Spread,
    /// Number of the first bucket that is kept.
    lowest: usize,
    /// The buckets from there on, as many as the times span.
    buckets: Vec<u32>,
}

impl Ranked {
    /// Takes one time in ns, which is not negative.
    pub fn add(&mut self, ns: Ns) {
        self.spread.add(ns);
        let bucket = bucket(ns.max(Ns::ZERO).as_ns().unsigned_abs());
        if self.buckets.is_empty() {
            self.lowest = bucket;
        } else if bucket < self.lowest {
            let more = self.lowest - bucket;
            self.buckets.splice(..0, std::iter::repeat_n(0, more));
            self.lowest = bucket;
        }
        let place = bucket - self.lowest;
        if place >= self.buckets.len() {
            self.buckets.resize(place + 1, 0);
        }
        if let Some(count) = self.buckets.get_mut(place) {
            *count = count.saturating_add(1);
        }
    }

    /// Returns the time in ns that `percent` percent of all times do not exceed.
    pub fn percentile_ns(&self, percent: u64) -> Ns {
        let wanted = (self.spread.count.saturating_mul(percent)).div_ceil(100).max(1);
        let mut seen = 0;
        for (place, count) in self.buckets.iter().enumerate() {
            seen += u64::from(*count);
            if seen >= wanted {
                return upper(self.lowest + place).clamp(self.spread.min_ns, self.spread.max_ns);
            }
        }
        self.spread.max_ns
    }
}

/// Returns the bucket of a time.
fn bucket(ns: u64) -> usize {
    let unit = ns >> LEAST_BITS;
    if unit < PARTS {
        return unit as usize;
    }
    let power = unit.ilog2().min(MOST_BITS - LEAST_BITS);
    let part = (unit >> (power - PARTS_BITS)).min(2 * PARTS - 1) - PARTS;
    (u64::from(power - PARTS_BITS + 1) * PARTS + part) as usize
}

/// Returns the greatest time of a bucket in ns.
fn upper(bucket: usize) -> Ns {
    let (octave, part) = (bucket as u64 / PARTS, bucket as u64 % PARTS);
    let end = if octave == 0 { part + 1 } else { (PARTS + part + 1) << (octave - 1) };
    Ns(((end << LEAST_BITS) - 1) as i64)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;

    #[test]
    fn buckets_are_in_order_and_narrow() {
        let mut before = 0;
        for exponent in 0..43 {
            for step in 0..97 {
                let ns = (1u64 << exponent) + (step << exponent) / 97;
                let found = bucket(ns);
                assert!(found >= before, "{ns}");
                before = found;
                if exponent <= MOST_BITS {
                    let top = upper(found).as_ns() as u64;
                    assert!(top >= ns, "{ns} above {top}");
                    assert!(top - ns <= (ns / PARTS).max(31), "{ns}: {top}");
                }
            }
        }
        assert!(before < 1200);
        assert_eq!(bucket(u64::MAX), before);
    }

    #[test]
    fn nothing_and_one() {
        let mut times = Ranked::default();
        assert_eq!(
            (times.spread.mean_ns(), times.spread.sigma_ns(), times.percentile_ns(99)),
            (Ns::ZERO, Ns::ZERO, Ns::ZERO)
        );
        times.add(Ns(1_000_000));
        assert_eq!([times.spread.min_ns, times.spread.mean_ns(), times.spread.max_ns], [Ns(1_000_000); 3]);
        assert_eq!(times.percentile_ns(99), Ns(1_000_000));
    }

    #[test]
    fn figures_of_a_hundred_times() {
        let mut times = Ranked::default();
        for ms in (1..=100).rev() {
            times.add(Ns::from_ms(ms));
        }
        assert_eq!(times.spread.count, 100);
        assert_eq!((times.spread.min_ns, times.spread.max_ns), (Ns::from_ms(1), Ns::from_ms(100)));
        assert_eq!(times.spread.mean_ns(), Ns(50_500_000));
        assert_eq!(times.spread.sigma_ns(), Ns(28_866_070));
        for (percent, truth) in [(1, 1_000_000i64), (50, 50_000_000), (99, 99_000_000), (100, 100_000_000)] {
            let found = times.percentile_ns(percent);
            assert!(found >= Ns(truth) && found <= Ns(truth + truth / 31), "{percent} %: {found:?}");
        }
    }

    #[test]
    fn a_long_capture_at_the_epoch_keeps_its_deviation() {
        let mut period = Spread::default();
        for turn in 0..1_000_000 {
            period.add(Ns(10_000_000 + if turn % 2 == 0 { 1_000 } else { -1_000 }));
        }
        assert_eq!((period.mean_ns(), period.sigma_ns()), (Ns::from_ms(10), Ns::from_us(1)));
    }

    #[test]
    fn extremes_do_not_panic() {
        let mut times = Ranked::default();
        for ns in [0, i64::MAX, 1, i64::MAX - 1] {
            times.add(Ns(ns));
        }
        assert!(times.percentile_ns(100) > Ns(1_000_000_000_000));
        assert!(times.buckets.len() < 1200);
    }
}

//! How far measured times spread, for verdicts: count, width, 99th percentile.
//!
//! Of fixed size whatever the number of values (invariant 6): percentiles come from buckets, eight to a power of two,
//! so they are at most an eighth too high, which makes a tolerance wider. Figures for people are finer, and cost more:
//! those of `summary::spread`. It must not know what was measured.

/// Buckets of one power of two.
const STEPS: usize = 8;
/// Values below 2^10 ns share the first bucket.
const LEAST_BITS: usize = 10;
/// Powers of two above it; the last bucket takes everything from 2^38 ns (275 s) on.
const POWERS: usize = 28;

/// What is known of a set of times in ns.
#[derive(Clone, Debug, Default)]
pub struct Spread {
    count: u64,
    least: i64,
    most: i64,
    /// Made with the first value.
    buckets: Vec<u32>,
}

impl Spread {
    /// Takes one value. Negative ones count as the least bucket.
    pub fn record(&mut self, ns: i64) {
        if self.count == 0 {
            self.buckets = vec![0; 1 + STEPS * POWERS];
            (self.least, self.most) = (ns, ns);
        }
        self.count += 1;
        self.least = self.least.min(ns);
        self.most = self.most.max(ns);
        if let Some(bucket) = self.buckets.get_mut(bucket(ns)) {
            *bucket = bucket.saturating_add(1);
        }
    }

    /// How many values.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The 99th percentile; 0 without values.
    pub fn p99_ns(&self) -> i64 {
        let above = self.count / 100;
        let mut seen = 0;
        for (number, count) in self.buckets.iter().enumerate().rev() {
            seen += u64::from(*count);
            if seen > above {
                return upper_edge(number).clamp(self.least, self.most);
            }
        }
        0
    }
}

fn bucket(ns: i64) -> usize {
    if ns < 1 << LEAST_BITS {
        return 0;
    }
    let power = ns.ilog2() as usize;
    let step = (ns >> (power - 3)) as usize & (STEPS - 1);
    (1 + (power - LEAST_BITS) * STEPS + step).min(STEPS * POWERS)
}

fn upper_edge(bucket: usize) -> i64 {
    let Some(above) = bucket.checked_sub(1) else { return 1 << LEAST_BITS };
    let (power, step) = (above / STEPS + LEAST_BITS, above % STEPS);
    if bucket == STEPS * POWERS { i64::MAX } else { (1 << power) + ((step as i64 + 1) << (power - 3)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_right_to_an_eighth() {
        let mut spread = Spread::default();
        assert_eq!((spread.count(), spread.p99_ns()), (0, 0));
        for ns in 1..=1000 {
            spread.record(ns * 1000);
        }
        assert_eq!(spread.count(), 1000);
        assert!((990_000..=1_000_000).contains(&spread.p99_ns()), "{}", spread.p99_ns());
    }

    #[test]
    fn any_value_has_a_bucket() {
        let mut spread = Spread::default();
        for ns in [i64::MIN, -1, 0, 1023, 1024, 1 << 37, 1 << 38, i64::MAX] {
            spread.record(ns);
        }
        assert_eq!(spread.p99_ns(), i64::MAX);
        for ns in [1024_i64, 1151, 1152, 5000, 123_456, 99_999_999] {
            assert!(upper_edge(bucket(ns)) > ns && upper_edge(bucket(ns)) - ns <= ns / 8 + 1, "{ns}");
        }
    }
}

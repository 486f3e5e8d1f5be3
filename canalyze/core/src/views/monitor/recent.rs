//! Recent amounts, on the clock of the frames.
//!
//! The window slides in ten steps, so that amounts expire even if no frame comes. The meaning of the amounts does not
//! matter here.

/// Number of steps of the window.
const STEPS: i64 = 10;

/// Amounts of the last steps.
#[derive(Clone, Debug)]
pub(super) struct Recent {
    step_ns: i64,
    /// The number of the current step, counted from the clock's zero.
    at: i64,
    steps: [u32; STEPS as usize],
}

impl Recent {
    /// Creates a window of this length in ns, which is at least ten.
    pub(super) fn new(length_ns: i64) -> Self {
        Self { step_ns: (length_ns / STEPS).max(1), at: i64::MIN, steps: [0; STEPS as usize] }
    }

    /// Adds an amount at `now_ns`. A slightly late one belongs to the current step.
    pub(super) fn add(&mut self, now_ns: i64, amount: u32) {
        let step = now_ns.div_euclid(self.step_ns);
        if step > self.at || self.at.saturating_sub(step) >= STEPS {
            let passed = step.saturating_sub(self.at);
            if (0..STEPS).contains(&passed) {
                for old in self.at.saturating_add(1)..=step {
                    self.put(old, |slot| *slot = 0);
                }
            } else {
                self.steps = [0; STEPS as usize];
            }
            self.at = step;
        }
        self.put(self.at, |slot| *slot = slot.saturating_add(amount));
    }

    fn put(&mut self, step: i64, act: impl FnOnce(&mut u32)) {
        if let Some(slot) = self.steps.get_mut(step.rem_euclid(STEPS) as usize) {
            act(slot);
        }
    }

    /// Returns the amount a second in tenths at `now_ns`, in a capture that began at `start_ns`.
    pub(super) fn tenths_per_s(&self, now_ns: i64, start_ns: i64) -> u64 {
        let now = now_ns.div_euclid(self.step_ns).max(self.at);
        let oldest = now.saturating_sub(STEPS - 1);
        let counts = (oldest..=self.at).filter_map(|step| self.steps.get(step.rem_euclid(STEPS) as usize));
        let sum: u64 = if oldest > self.at { 0 } else { counts.map(|count| u64::from(*count)).sum() };
        let whole = (STEPS - 1).saturating_mul(self.step_ns).saturating_add(now_ns.rem_euclid(self.step_ns));
        let time = whole.min(now_ns.saturating_sub(start_ns)).max(self.step_ns);
        (u128::from(sum) * 10_000_000_000 / u128::from(time.unsigned_abs())) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;

    #[test]
    fn what_is_past_leaves() {
        let mut recent = Recent::new(2_000 * MS);
        for no in 0..1_000 {
            recent.add(no * 10 * MS, 1);
        }
        let rate = recent.tenths_per_s(9_990 * MS, 0);
        assert!((995..=1005).contains(&rate), "{rate}");
        assert!(recent.tenths_per_s(10_990 * MS, 0) < 600);
        assert_eq!(recent.tenths_per_s(12_200 * MS, 0), 0);
        assert_eq!(recent.tenths_per_s(i64::MAX, 0), 0);
    }

    #[test]
    fn a_beginning_and_a_clock_that_was_set_back() {
        let mut recent = Recent::new(2_000 * MS);
        for no in 0..50 {
            recent.add(i64::MAX / 2 + no * 10 * MS, 1);
        }
        let now = i64::MAX / 2 + 490 * MS;
        assert!((950..=1050).contains(&recent.tenths_per_s(now, i64::MAX / 2)));
        recent.add(5, 1);
        assert_eq!(recent.tenths_per_s(5, 5), 50);
        recent.add(i64::MIN, 1);
        recent.add(i64::MAX, 1);
        assert!(recent.tenths_per_s(i64::MAX, i64::MIN) > 0);
    }
}

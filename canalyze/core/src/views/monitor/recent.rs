//! Recent amounts, on the clock of the frames.
//!
//! The window slides in ten steps, so that amounts expire even if no frame comes. The meaning of the amounts does not
//! matter here.

use crate::bytes::ns::Ns;

/// Number of steps of the window.
const STEPS: i64 = 10;

/// Amounts of the last steps.
#[derive(Clone, Debug)]
pub(super) struct Recent {
    step_ns: Ns,
    /// The number of the current step, counted from the clock's zero.
    at: i64,
    steps: [u32; STEPS as usize],
}

impl Recent {
    /// Creates a window of this length in ns, which is at least ten.
    pub(super) fn new(length_ns: Ns) -> Self {
        Self { step_ns: (length_ns / STEPS).max(Ns(1)), at: i64::MIN, steps: [0; STEPS as usize] }
    }

    /// Adds an amount at `now_ns`. A slightly late one belongs to the current step.
    pub(super) fn add(&mut self, now_ns: Ns, amount: u32) {
        let step = now_ns.as_ns().div_euclid(self.step_ns.as_ns());
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
    pub(super) fn tenths_per_s(&self, now_ns: Ns, start_ns: Ns) -> u64 {
        let now = now_ns.as_ns().div_euclid(self.step_ns.as_ns()).max(self.at);
        let oldest = now.saturating_sub(STEPS - 1);
        let counts = (oldest..=self.at).filter_map(|step| self.steps.get(step.rem_euclid(STEPS) as usize));
        let sum: u64 = if oldest > self.at { 0 } else { counts.map(|count| u64::from(*count)).sum() };
        let whole = self.step_ns * (STEPS - 1) + Ns(now_ns.as_ns().rem_euclid(self.step_ns.as_ns()));
        let time = whole.min(now_ns - start_ns).max(self.step_ns);
        (u128::from(sum) * 10_000_000_000 / u128::from(time.as_ns().unsigned_abs())) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;

    #[test]
    fn what_is_past_leaves() {
        let mut recent = Recent::new(Ns(2_000 * MS));
        for no in 0..1_000 {
            recent.add(Ns(no * 10 * MS), 1);
        }
        let rate = recent.tenths_per_s(Ns(9_990 * MS), Ns::ZERO);
        assert!((995..=1005).contains(&rate), "{rate}");
        assert!(recent.tenths_per_s(Ns(10_990 * MS), Ns::ZERO) < 600);
        assert_eq!(recent.tenths_per_s(Ns(12_200 * MS), Ns::ZERO), 0);
        assert_eq!(recent.tenths_per_s(Ns::MAX, Ns::ZERO), 0);
    }

    #[test]
    fn a_beginning_and_a_clock_that_was_set_back() {
        let mut recent = Recent::new(Ns(2_000 * MS));
        for no in 0..50 {
            recent.add(Ns(i64::MAX / 2 + no * 10 * MS), 1);
        }
        let now = i64::MAX / 2 + 490 * MS;
        assert!((950..=1050).contains(&recent.tenths_per_s(Ns(now), Ns(i64::MAX / 2))));
        recent.add(Ns(5), 1);
        assert_eq!(recent.tenths_per_s(Ns(5), Ns(5)), 50);
        recent.add(Ns::MIN, 1);
        recent.add(Ns::MAX, 1);
        assert!(recent.tenths_per_s(Ns::MAX, Ns::MIN) > 0);
    }
}

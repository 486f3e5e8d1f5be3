//! A time in nanoseconds, with arithmetic that cannot overflow.
//!
//! One type is both a moment and a duration: a capture's moments count from the epoch or from its beginning, so a moment
//! is a duration since then, and a difference of two may be negative, as clocks step back. Results beyond the range of
//! an `i64` are its ends, 292 years away.

use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Rem, Sub, SubAssign};

/// A time in nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Deserialize)]
#[serde(transparent)]
pub struct Ns(pub i64);

impl Ns {
    /// No time.
    pub const ZERO: Self = Self(0);
    /// The earliest time.
    pub const MIN: Self = Self(i64::MIN);
    /// The latest time.
    pub const MAX: Self = Self(i64::MAX);

    /// Makes a time of microseconds.
    #[inline]
    pub const fn from_us(us: i64) -> Self {
        Self(us.saturating_mul(1_000))
    }

    /// Makes a time of milliseconds.
    #[inline]
    pub const fn from_ms(ms: i64) -> Self {
        Self(ms.saturating_mul(1_000_000))
    }

    /// Makes a time of seconds.
    #[inline]
    pub const fn from_s(s: i64) -> Self {
        Self(s.saturating_mul(1_000_000_000))
    }

    /// Returns the number of nanoseconds.
    #[inline]
    pub const fn as_ns(self) -> i64 {
        self.0
    }

    /// Returns the time without its sign.
    #[inline]
    pub const fn abs(self) -> Self {
        Self(self.0.saturating_abs())
    }

    /// Returns the time between two moments, whichever is the earlier one.
    #[inline]
    pub const fn abs_diff(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0).saturating_abs())
    }
}

impl Add for Ns {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }
}

impl Sub for Ns {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0))
    }
}

impl Neg for Ns {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self(self.0.saturating_neg())
    }
}

impl Mul<i64> for Ns {
    type Output = Self;

    #[inline]
    fn mul(self, times: i64) -> Self {
        Self(self.0.saturating_mul(times))
    }
}

impl Mul<Ns> for i64 {
    type Output = Ns;

    #[inline]
    fn mul(self, time: Ns) -> Ns {
        time * self
    }
}

impl Div<i64> for Ns {
    type Output = Self;

    #[inline]
    fn div(self, parts: i64) -> Self {
        Self(self.0.saturating_div(parts))
    }
}

impl Div for Ns {
    type Output = i64;

    #[inline]
    fn div(self, other: Self) -> i64 {
        self.0.saturating_div(other.0)
    }
}

impl Rem for Ns {
    type Output = Self;

    #[inline]
    fn rem(self, other: Self) -> Self {
        Self(self.0.wrapping_rem(other.0))
    }
}

impl AddAssign for Ns {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Ns {
    #[inline]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl Sum for Ns {
    fn sum<I: Iterator<Item = Self>>(times: I) -> Self {
        times.fold(Self::ZERO, Self::add)
    }
}

impl<'a> Sum<&'a Self> for Ns {
    fn sum<I: Iterator<Item = &'a Self>>(times: I) -> Self {
        times.copied().sum()
    }
}

#[cfg(test)]
mod tests {
    use super::Ns;

    #[test]
    fn nothing_overflows() {
        assert_eq!((Ns::MAX + Ns(1), Ns::MIN - Ns(1), -Ns::MIN, Ns::MIN.abs()), (Ns::MAX, Ns::MIN, Ns::MAX, Ns::MAX));
        assert_eq!((Ns::MAX * 2, -2 * Ns::MAX, Ns::MIN / -1, Ns::MIN / Ns(-1)), (Ns::MAX, Ns::MIN, Ns::MAX, i64::MAX));
        assert_eq!((Ns::MIN % Ns(-1), Ns::MIN.abs_diff(Ns::MAX), Ns::from_s(i64::MIN)), (Ns::ZERO, Ns::MAX, Ns::MIN));
        assert_eq!([Ns::MAX, Ns(1), Ns(-1)].iter().sum::<Ns>(), Ns(i64::MAX - 1));
    }
}

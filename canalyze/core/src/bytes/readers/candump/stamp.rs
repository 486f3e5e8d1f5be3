//! Time stamps of candump: their digits and their meaning.
//!
//! Digits become exact integer nanoseconds (a double loses 238 ns at today's epoch) and can be printed again unchanged.
//! A single line does not show the meaning of small numbers, since `-t d` and `-t z` look alike; it is derived from
//! their order (`Clock`). Stamps are never repaired or sorted.

use super::Stamps;
use super::lex::is_blank;
use crate::bytes::calendar::{days_of, days_to};
use crate::bytes::frame::{LAST_SECOND_NS, Stamp, StampForm};
use crate::bytes::ns::Ns;

const SECOND: i64 = 1_000_000_000;
/// Lower limit of console stamps that are an epoch (1973), in ns; smaller ones may be differences or count from zero.
const AMBIGUOUS: Ns = Ns::from_s(100_000_000);
const DAY: i64 = 86_400;

/// Parses the stamp at the beginning of a line; returns the text after its closing parenthesis as well.
#[inline]
pub(super) fn read(text: &[u8]) -> Option<(Stamp, &[u8])> {
    if let Some(found) = microseconds(text) {
        return Some(found);
    }
    let inner = text.strip_prefix(b"(")?;
    seconds(inner).or_else(|| calendar(inner))
}

/// Parses a pasted stamp without parentheses: `0.001000 601#40`. It needs decimals and a blank after it.
pub(super) fn bare(text: &[u8]) -> Option<(Stamp, &[u8])> {
    let (whole, width, rest) = digits(text);
    let (fraction, decimals, rest) = fraction(rest.strip_prefix(b".")?)?;
    if !(1..=20).contains(&width) || !rest.first().is_some_and(|&byte| is_blank(byte)) {
        return None;
    }
    let ns = nanoseconds(i64::try_from(whole).unwrap_or(i64::MAX), fraction);
    Some((Stamp { form: StampForm::Seconds, ns: Ns(ns), width: width as u8, decimals }, rest))
}

/// Parses `(1549455524.265601)`, the form of nearly every log file, with the result of [`seconds`], eight digits at
/// once.
#[inline(always)]
fn microseconds(text: &[u8]) -> Option<(Stamp, &[u8])> {
    let (stamp, rest) = text.split_first_chunk::<19>()?;
    let [b'(', s0, s1, s2, s3, s4, s5, s6, s7, s8, s9, b'.', u0, u1, u2, u3, u4, u5, b')'] = *stamp else {
        return None;
    };
    let high = eight_digits([s0, s1, s2, s3, s4, s5, s6, s7])?;
    let low = eight_digits([s8, s9, u0, u1, u2, u3, u4, u5])?;
    let ns = (high * 100_000_000 + low).checked_mul(1_000).unwrap_or_else(|| nanoseconds(i64::MAX, 0));
    Some((Stamp { form: StampForm::Seconds, ns: Ns(ns), width: 10, decimals: 6 }, rest))
}

/// Returns the number that eight digits represent, the first one highest; `None` if one is not a digit.
#[inline(always)]
fn eight_digits(text: [u8; 8]) -> Option<i64> {
    const DIGIT: u64 = 0x3030_3030_3030_3030;
    const HIGH: u64 = 0xF0F0_F0F0_F0F0_F0F0;
    const SIX: u64 = 0x0606_0606_0606_0606;
    let word = u64::from_le_bytes(text);
    // A digit is 30h to 39h: its high half is 3, also with 6 added.
    if word & HIGH != DIGIT || (word + SIX) & HIGH != DIGIT {
        return None;
    }
    // Neighbours are combined: digits into two-digit numbers, those into four digits, those into eight.
    let two = (word - DIGIT).wrapping_mul(10 << 8 | 1) >> 8 & 0x00FF_00FF_00FF_00FF;
    let four = two.wrapping_mul(100 << 16 | 1) >> 16 & 0x0000_FFFF_0000_FFFF;
    let eight = four.wrapping_mul(10_000 << 32 | 1) >> 32;
    Some(eight as i64)
}

/// Parses `1549455524.265601)`. Only nine decimals are kept, since nothing on a CAN bus is finer than 1 ns.
#[inline(always)]
fn seconds(text: &[u8]) -> Option<(Stamp, &[u8])> {
    let (whole, width, rest) = digits(text);
    if !(1..=20).contains(&width) {
        return None;
    }
    let (fraction, decimals, rest) = match rest {
        [b'.', rest @ ..] => fraction(rest)?,
        _ => (0, 0, rest),
    };
    let ns = nanoseconds(i64::try_from(whole).unwrap_or(i64::MAX), fraction);
    let rest = rest.strip_prefix(b")")?;
    Some((Stamp { form: StampForm::Seconds, ns: Ns(ns), width: width as u8, decimals }, rest))
}

/// Returns the sum in ns, or if it does not fit the last whole second that does, which survives writing and reading.
#[inline(always)]
pub(in crate::bytes::readers) fn nanoseconds(seconds: i64, fraction: i64) -> i64 {
    let exact = seconds.checked_mul(SECOND).and_then(|ns| ns.checked_add(fraction));
    exact.unwrap_or(if seconds < 0 { -LAST_SECOND_NS } else { LAST_SECOND_NS }.as_ns())
}

/// Parses a number, saturating; returns its value, its number of digits, and the rest.
#[inline(always)]
pub(in crate::bytes::readers) fn digits(mut text: &[u8]) -> (u64, usize, &[u8]) {
    let (mut value, mut count) = (0u64, 0);
    while let [digit, rest @ ..] = text {
        let digit = digit.wrapping_sub(b'0');
        if digit > 9 {
            break;
        }
        value = if count < 19 {
            value * 10 + u64::from(digit)
        } else {
            value.saturating_mul(10).saturating_add(u64::from(digit))
        };
        count += 1;
        text = rest;
    }
    (value, count, text)
}

/// Parses at least one decimal; returns ns, the number of decimals used, and the rest.
#[inline(always)]
pub(in crate::bytes::readers) fn fraction(mut text: &[u8]) -> Option<(i64, u8, &[u8])> {
    const SCALE: [i64; 10] = [1_000_000_000, 100_000_000, 10_000_000, 1_000_000, 100_000, 10_000, 1_000, 100, 10, 1];
    let (mut value, mut count) = (0i64, 0u8);
    while let [digit, rest @ ..] = text {
        let digit = digit.wrapping_sub(b'0');
        if digit > 9 {
            break;
        }
        if count < 9 {
            value = value * 10 + i64::from(digit);
            count += 1;
        }
        text = rest;
    }
    let scale = SCALE.get(usize::from(count))?;
    (count > 0).then_some((value * scale, count, text))
}

/// Parses `2026-09-15 18:44:56.479963)`: local time without a zone, counted as if it were UTC.
fn calendar(text: &[u8]) -> Option<(Stamp, &[u8])> {
    let (year, rest) = field(text, 4, b'-')?;
    let (month, rest) = field(rest, 2, b'-')?;
    let (day, rest) = field(rest, 2, b' ')?;
    let (hour, rest) = field(rest, 2, b':')?;
    let (minute, rest) = field(rest, 2, b':')?;
    let (second, width, rest) = digits(rest);
    let second = i64::try_from(second).ok()?;
    if !(1..=12).contains(&month) || !(1..=days_of(year, month)).contains(&day) {
        return None;
    }
    if hour > 23 || minute > 59 || second > 59 || width != 2 {
        return None;
    }
    let (fraction, decimals, rest) = match rest {
        [b'.', rest @ ..] => fraction(rest)?,
        _ => (0, 0, rest),
    };
    let rest = rest.strip_prefix(b")")?;
    let seconds = days_to(year, month, day) * DAY + hour * 3600 + minute * 60 + second;
    let ns = nanoseconds(seconds, fraction);
    Some((Stamp { form: StampForm::Calendar, ns: Ns(ns), width: 0, decimals }, rest))
}

/// Parses a number of exactly `width` digits and the mark after it.
fn field(text: &[u8], width: usize, mark: u8) -> Option<(i64, &[u8])> {
    let (value, count, rest) = digits(text);
    let rest = rest.strip_prefix(&[mark])?;
    (count == width).then_some((i64::try_from(value).ok()?, rest))
}

/// Returns true if the line was meant to begin with a stamp. `(254)` and `(COB-ID 018A)` are comments.
pub(super) fn is_meant(text: &[u8]) -> bool {
    let Some(inner) = text.strip_prefix(b"(") else { return false };
    let (_, width, rest) = digits(inner);
    match rest {
        [b'.', rest @ ..] => width > 0 && rest.first().is_none_or(u8::is_ascii_digit),
        [b'-', rest @ ..] => width == 4 && rest.first().is_none_or(u8::is_ascii_digit),
        rest => width > 0 && rest.is_empty(),
    }
}

/// Returns true if the line begins with a stamp that lacks only its opening parenthesis: `1549455524.265601) `.
pub(super) fn is_closed(text: &[u8]) -> bool {
    seconds(text).or_else(|| calendar(text)).is_some_and(|(stamp, _)| stamp.decimals > 0)
}

/// The meaning of a capture's stamps, and the time of each line.
#[derive(Clone, Copy, Debug)]
pub(super) struct CandumpClock {
    deltas: bool,
    /// True if counting from zero is only assumed, so that a backward step has to be reported.
    assumed: bool,
    sum: Ns,
    last: Option<Ns>,
}

impl CandumpClock {
    pub(super) fn new(stamps: Stamps) -> Self {
        Self { deltas: stamps == Stamps::Delta, assumed: stamps == Stamps::Auto, sum: Ns::ZERO, last: None }
    }

    /// Decides the meaning by the stamps at the beginning of a file. Fewer than two decide nothing.
    pub(super) fn decide(&mut self, beginning: impl Iterator<Item = Stamp>) {
        let mut last = None;
        for stamp in beginning.filter(is_ambiguous) {
            if let Some(last) = last {
                self.assumed = false;
                self.deltas |= stamp.ns < last;
            }
            last = Some(stamp.ns);
        }
    }

    /// Returns the time of a line, and true if its stamp is the first to contradict the assumption.
    ///
    /// Has to be called for every stamped console line, readable or not: a difference counts from the line before.
    #[inline(always)]
    pub(super) fn moment(&mut self, stamp: Stamp, console: bool) -> (Ns, bool) {
        if !console || !is_ambiguous(&stamp) {
            return (stamp.ns, false);
        }
        if self.deltas {
            self.sum += stamp.ns;
            return (self.sum, false);
        }
        let backward = self.assumed && self.last.is_some_and(|last| stamp.ns < last);
        if backward {
            self.assumed = false;
        }
        self.last = Some(stamp.ns);
        (stamp.ns, backward)
    }
}

fn is_ambiguous(stamp: &Stamp) -> bool {
    stamp.form == StampForm::Seconds && stamp.ns < AMBIGUOUS
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]

    use proptest::prelude::*;

    use super::*;

    fn written(stamp: &Stamp) -> String {
        let (seconds, fraction) = (stamp.ns.as_ns().div_euclid(SECOND), stamp.ns.as_ns().rem_euclid(SECOND));
        let whole = match stamp.form {
            StampForm::Seconds => format!("{seconds:0width$}", width = usize::from(stamp.width)),
            StampForm::Calendar => {
                let date = (0..3_000_000)
                    .map(|day| day - 720_000)
                    .find(|&day| day == seconds.div_euclid(DAY))
                    .map(|day| {
                        let year = (1..=9999).rev().find(|&year| days_to(year, 1, 1) <= day).unwrap();
                        let month = (1..=12).rev().find(|&month| days_to(year, month, 1) <= day).unwrap();
                        format!("{year:04}-{month:02}-{:02}", day - days_to(year, month, 1) + 1)
                    })
                    .unwrap();
                let s = seconds.rem_euclid(DAY);
                format!("{date} {:02}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60)
            }
        };
        match stamp.decimals {
            0 => format!("({whole})"),
            decimals => format!("({whole}.{})", &format!("{fraction:09}")[..usize::from(decimals)]),
        }
    }

    #[test]
    fn digits_are_exact_and_come_back() {
        for (text, ns, decimals) in [
            ("(1549455524.265601)", 1_549_455_524_265_601_000, 6),
            ("(1795221516.618476123)", 1_795_221_516_618_476_123, 9),
            ("(000.304418)", 304_418_000, 6),
            ("(76720.535362)", 76_720_535_362_000, 6),
            ("(0.000000)", 0, 6),
            ("(1.1)", 1_100_000_000, 1),
            ("(7)", 7_000_000_000, 0),
            ("(00000000000000000001.5)", 1_500_000_000, 1),
            ("(1970-01-01 00:00:00.000001)", 1_000, 6),
            ("(1969-12-31 23:59:59.999999999)", -1, 9),
            ("(2026-09-15 18:44:56.479963)", 1_789_497_896_479_963_000, 6),
            ("(2000-02-29 00:00:00)", 951_782_400_000_000_000, 0),
        ] {
            let (stamp, rest) = read(text.as_bytes()).unwrap();
            assert_eq!((stamp.ns, stamp.decimals, rest), (Ns(ns), decimals, &b""[..]), "{text}");
            assert_eq!(written(&stamp), text);
        }
    }

    #[test]
    fn too_fine_and_too_large_stamps_still_read() {
        let (stamp, rest) = read(b"(0.1234567891999) x").unwrap();
        assert_eq!((stamp.ns, stamp.decimals, rest), (Ns(123_456_789), 9, &b" x"[..]));
        for (text, written_again) in [
            ("(99999999999999999999.999999)", "(00000000009223372036.000000)"),
            ("(9223372036.9)", "(9223372036.0)"),
            ("(9999-12-31 23:59:59.9)", "(2262-04-11 23:47:16.0)"),
            ("(0001-01-01 00:00:00.0)", "(1677-09-21 00:12:44.0)"),
            ("(1111-11-21 00:51:58.764679)", "(1677-09-21 00:12:44.000000)"),
        ] {
            let (stamp, _) = read(text.as_bytes()).unwrap();
            assert_eq!(written(&stamp), written_again);
            assert_eq!(read(written_again.as_bytes()).unwrap().0, stamp, "{text}");
        }
    }

    #[test]
    fn what_is_no_stamp() {
        for text in [
            "",
            "(",
            "()",
            "(.5)",
            "(1.)",
            "(1.5",
            "1.5)",
            "(-1.5)",
            "(1.5.5)",
            "(1,5)",
            "(a)",
            "(999999999999999999999.5)",
            "(2026-02-29 00:00:00.0)",
            "(2026-13-01 00:00:00.0)",
            "(2026-01-00 00:00:00.0)",
            "(2026-01-01 24:00:00.0)",
            "(2026-01-01 00:60:00.0)",
            "(2026-01-01 00:00:60.0)",
            "(2026-1-01 00:00:00.0)",
            "(2026-01-01T00:00:00.0)",
        ] {
            assert_eq!(read(text.as_bytes()), None, "{text}");
        }
    }

    proptest! {
        #[test]
        fn eight_digits_at_once_are_the_same(whole in "[0-9]{10}", micros in "[0-9]{6}", place in 0usize..40, odd in any::<u8>()) {
            let mut text = format!("({whole}.{micros}) can0").into_bytes();
            for place in [usize::MAX, place] {
                if let Some(byte) = text.get_mut(place) {
                    *byte = odd;
                }
                let slow = text.strip_prefix(b"(").and_then(seconds);
                let fast = microseconds(&text);
                prop_assert!(fast.is_none() || fast == slow);
                prop_assert!(fast.is_some() || place < 19);
            }
        }

        #[test]
        fn seconds_are_stable(whole in 0u64..9_000_000_000, width in 1usize..=20, fraction in 0u64..1_000_000_000, decimals in 0usize..=9) {
            let fraction = format!("{fraction:09}");
            let text = match decimals {
                0 => format!("({whole:0width$})"),
                n => format!("({whole:0width$}.{})", &fraction[..n]),
            };
            let (stamp, _) = read(text.as_bytes()).unwrap();
            prop_assert_eq!(written(&stamp), text);
        }

        #[test]
        fn any_bytes(text in prop::collection::vec(any::<u8>(), 0..40)) {
            let _ = read(&text);
            let _ = is_meant(&text);
        }
    }
}

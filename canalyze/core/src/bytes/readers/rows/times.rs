//! Numbers and times in cells: seconds and other units, times of day, dates.

use super::columns::{MICROSECOND, MILLISECOND, SECOND};
use crate::bytes::calendar::{days_of, days_to};
use crate::bytes::frame::{Stamp, StampForm};
use crate::bytes::ns::Ns;
use crate::bytes::readers::candump::lex::{is_blank, is_hex, nibble};
use crate::bytes::readers::candump::stamp::{digits, fraction, nanoseconds};

/// Marks of hexadecimal digits in programs and PLCs.
const PREFIXES: [&[u8]; 8] = [b"0x", b"0X", b"16#", b"B#16#", b"W#16#", b"DW#16#", b"$", b"&H"];

/// Returns the digits behind a mark of hexadecimal ones; the whole word without one.
pub(super) fn unprefixed(word: &[u8]) -> &[u8] {
    PREFIXES.iter().find_map(|prefix| word.strip_prefix(*prefix)).unwrap_or(word)
}

/// Parses a whole word as a number, with or without `0x`, which makes it hexadecimal.
pub(super) fn number(word: &[u8], base: u32) -> Option<u32> {
    let digits = unprefixed(word);
    let base = if digits.len() < word.len() { 16 } else { base };
    let add = |sum: Option<u32>, digit: &u8| {
        let digit = Some(u32::from(nibble(*digit))).filter(|digit| *digit < base)?;
        sum?.checked_mul(base)?.checked_add(digit)
    };
    if digits.is_empty() { None } else { digits.iter().fold(Some(0), add) }
}

/// Returns true if a row between blanks begins with a number that has a decimal comma, `1,012  Rx  70A  1  00`, and not
/// with an identifier and bytes.
pub(super) fn begins_with_comma(text: &[u8]) -> bool {
    let mut words = text.split(|byte| is_blank(*byte)).filter(|word| !word.is_empty());
    let mut parts = words.next().unwrap_or_default().split(|byte| *byte == b',');
    let number = |part: Option<&[u8]>| part.is_some_and(|part| !part.is_empty() && part.iter().all(u8::is_ascii_digit));
    let one = number(parts.next()) && number(parts.next()) && parts.next().is_none();
    let other = words.clone().any(|word| word.len() != 2 || !is_hex(word));
    one && other && !words.any(|word| word.contains(&b',') || word.contains(&b';'))
}

/// Parses a time: a number in units of so many ns; or a time of day, with a date before it or not, with a point, comma or
/// colon before the fraction, of 24 hours or with AM or PM behind it.
pub(super) fn time(word: &[u8], unit: i64) -> Option<Stamp> {
    let (word, half) = match word {
        [rest @ .., b' ', b'A' | b'a', b'M' | b'm'] => (rest, Some(0)),
        [rest @ .., b' ', b'P' | b'p', b'M' | b'm'] => (rest, Some(12)),
        _ => (word, None),
    };
    if let Some(place) = word.iter().position(|byte| is_blank(*byte) || *byte == b'T') {
        let (day, rest) = word.split_at_checked(place)?;
        let (rest, zone_ns) = zone(rest);
        let stamp = time(rest.get(1..)?, unit).filter(|_| rest.contains(&b':'))?;
        return Some(Stamp {
            form: StampForm::Calendar,
            ns: Ns(date(day)?.checked_add(stamp.ns.as_ns())?.checked_sub(zone_ns)?),
            ..stamp
        });
    }
    // Microseconds may follow a comma behind the milliseconds.
    if let Some((front, [b',' | b'.', micro @ ..])) = word.split_at_checked(word.len().saturating_sub(4))
        && front.contains(&b':')
        && front.contains(&b'.')
        && let ([a, b, c], Some(stamp)) = (micro, time(front, unit).filter(|stamp| stamp.decimals == 3))
        && let Some(micro) = number(&[*a, *b, *c], 10)
    {
        return Some(Stamp { ns: stamp.ns + Ns::from_us(micro.into()), decimals: 6, ..stamp });
    }
    let mut parts = word.split(|byte| *byte == b':');
    let (first, second, third, fourth) = (parts.next()?, parts.next(), parts.next(), parts.next());
    let last = third.or(second).unwrap_or(first);
    let (whole, count, rest) = digits(last);
    let (part, decimals, rest) = match (rest, fourth) {
        ([b'.' | b',', rest @ ..], None) => fraction(rest)?,
        ([], Some(after)) => fraction(after)?,
        _ => (0, 0, rest),
    };
    if count == 0 || count > 18 || !rest.is_empty() || parts.next().is_some() {
        return None;
    }
    let whole = i64::try_from(whole).ok()?;
    let small = |part: &[u8], most: u64| {
        let (value, count, rest) = digits(part);
        ((1..=2).contains(&count) && rest.is_empty() && value <= most).then_some(value as i64)
    };
    let (ns, decimals, width) = match (second, third) {
        (Some(minutes), Some(_)) => {
            let hours = small(first, 23)?;
            let hours = half.map_or(hours, |half| hours % 12 + half);
            (nanoseconds(hours * 3600 + small(minutes, 59)? * 60 + whole, part), decimals, 5)
        }
        (Some(_), None) => (nanoseconds(small(first, 59)? * 60 + whole, part), decimals, 4),
        // A whole number this large counts smaller units since 1970.
        (None, _) if decimals == 0 && unit == SECOND && whole >= 100_000_000_000 => {
            let (unit, decimals) = match whole {
                100_000_000_000_000_000.. => (1, 9),
                100_000_000_000_000.. => (MICROSECOND, 6),
                _ => (MILLISECOND, 3),
            };
            (whole.checked_mul(unit)?, decimals, 10)
        }
        (None, _) if unit == SECOND => (nanoseconds(whole, part), decimals, count.min(20) as u8),
        (None, _) => {
            let more = match unit {
                MILLISECOND => 3,
                MICROSECOND => 6,
                _ => 9,
            };
            let ns = whole.checked_mul(unit)?.checked_add(part / (SECOND / unit))?;
            (ns, (decimals + more).min(9), 1)
        }
    };
    Some(Stamp { form: StampForm::Seconds, ns: Ns(ns), width, decimals })
}

/// Returns a time of day without the time zone behind it, and that in ns.
fn zone(text: &[u8]) -> (&[u8], i64) {
    if let Some(text) = text.strip_suffix(b"Z") {
        return (text, 0);
    }
    let place = text.iter().rposition(|byte| matches!(byte, b'+' | b'-')).filter(|place| *place > 5);
    let Some((time, [sign, offset @ ..])) = place.and_then(|place| text.split_at_checked(place)) else {
        return (text, 0);
    };
    let digits: Vec<u8> = offset.iter().copied().filter(u8::is_ascii_digit).collect();
    let (hours, minutes) = digits.split_at_checked(2).unwrap_or((&digits, &[]));
    match (number(hours, 10), number(minutes, 10)) {
        (Some(hours @ 0..=14), Some(minutes @ 0..=59)) if digits.len() == 4 => {
            let ns = (i64::from(hours) * 3600 + i64::from(minutes) * 60) * SECOND;
            (time, if *sign == b'+' { ns } else { -ns })
        }
        _ => (text, 0),
    }
}

/// Parses a date, `2024-03-12`, `2024/3/12` or `12.03.2024`, as ns since 1970.
fn date(text: &[u8]) -> Option<i64> {
    if let [day @ .., b'.', m1, m2, b'.', y1, y2, y3, y4] = text {
        return date(&[&[*y1, *y2, *y3, *y4, b'-', *m1, *m2, b'-'][..], day].concat());
    }
    if let Some(chinese) = std::str::from_utf8(text).ok().and_then(|text| text.strip_suffix('日')) {
        return date(chinese.replace(['年', '月'], "-").as_bytes());
    }
    let mut parts = text.split(|byte| matches!(byte, b'-' | b'/'));
    let mut next = || number(parts.next()?, 10).map(i64::from);
    let (year, month, day) = (next()?, next()?, next()?);
    let known = (1970..=2200).contains(&year) && (1..=12).contains(&month) && (1..=days_of(year, month)).contains(&day);
    known.then(|| days_to(year, month, day) * 86_400 * SECOND)
}

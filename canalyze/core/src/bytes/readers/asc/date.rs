//! Dates of Vector's programs: `Sam Sep 30 15:06:13.191 2017`, `Thu Apr 28 10:44:52.480 am 2022`.
//!
//! English and German in any encoding: months are recognized by their first letters, and the weekday is ignored. Local
//! civil time is counted as if it were UTC. An incomplete date is rejected.

use super::words::LineWords;
use crate::bytes::calendar::{days_of, days_to};
use crate::bytes::readers::candump::stamp::{digits, nanoseconds};

/// The first letters of months in lower case and their numbers. The umlaut is in UTF-8, Latin-1, code page 850 or
/// without dots.
const MONTHS: &[(&[u8], i64)] = &[
    (b"jan", 1),
    (b"feb", 2),
    (b"mar", 3),
    (b"m\xC3\xA4r", 3),
    (b"m\xE4r", 3),
    (b"m\x84r", 3),
    (b"mrz", 3),
    (b"mae", 3),
    (b"apr", 4),
    (b"may", 5),
    (b"mai", 5),
    (b"jun", 6),
    (b"jul", 7),
    (b"aug", 8),
    (b"sep", 9),
    (b"oct", 10),
    (b"okt", 10),
    (b"nov", 11),
    (b"dec", 12),
    (b"dez", 12),
];

/// Returns a date in ns since 1970-01-01.
pub(super) fn read(text: &[u8]) -> Option<i64> {
    let mut words = LineWords::new(text);
    let mut word = words.next()?;
    let month = match month(word) {
        Some(month) => month,
        None => {
            word = words.next()?;
            month(word)?
        }
    };
    let day = whole(words.next()?.strip_suffix(b".").unwrap_or(words.last()))?;
    let time = words.next()?;
    let mut word = words.next()?;
    let afternoon = match word.to_ascii_lowercase().as_slice() {
        b"am" | b"a.m." => Some(false),
        b"pm" | b"p.m." => Some(true),
        _ => None,
    };
    if afternoon.is_some() {
        word = words.next()?;
    }
    let year = whole(word).filter(|year| (1..=9999).contains(year) && word.len() == 4)?;
    if !(1..=days_of(year, month)).contains(&day) {
        return None;
    }
    let (seconds, fraction) = time_of_day(time, afternoon)?;
    Some(nanoseconds(days_to(year, month, day) * 86_400 + seconds, fraction))
}

fn month(word: &[u8]) -> Option<i64> {
    let word = word.to_ascii_lowercase();
    MONTHS.iter().find(|(name, _)| word.starts_with(name)).map(|(_, month)| *month)
}

/// Parses `15:06:13.191` into seconds of the day and ns.
fn time_of_day(text: &[u8], afternoon: Option<bool>) -> Option<(i64, i64)> {
    let (hour, _, rest) = digits(text);
    let (minute, _, rest) = digits(rest.strip_prefix(b":")?);
    let (second, _, rest) = digits(rest.strip_prefix(b":")?);
    let fraction = match rest {
        [] => 0,
        [b'.' | b',', rest @ ..] => fraction(rest)?,
        _ => return None,
    };
    // Twelve hours with am or pm; a 24-hour time needs neither and is taken unchanged.
    let hour = match (afternoon, hour) {
        (Some(false), 12) => 0,
        (Some(true), 0..12) => hour + 12,
        _ => hour,
    };
    if hour > 23 || minute > 59 || second > 59 {
        return None;
    }
    Some((i64::try_from(hour * 3600 + minute * 60 + second).ok()?, fraction))
}

/// Parses up to three digits as a number of ms, like Vector's programs (python-can omits leading zeros), and more
/// digits as decimals.
fn fraction(text: &[u8]) -> Option<i64> {
    let (number, count, rest) = digits(text);
    let number = i64::try_from(number).ok()?;
    if !rest.is_empty() {
        return None;
    }
    match count {
        1..=3 => Some(number * 1_000_000),
        4..=9 => Some(number * 10_i64.pow(9 - count as u32)),
        _ => None,
    }
}

fn whole(word: &[u8]) -> Option<i64> {
    let (number, count, rest) = digits(word);
    (count > 0 && rest.is_empty()).then(|| i64::try_from(number).ok()).flatten()
}

#[cfg(test)]
mod tests {
    use super::read;

    #[test]
    fn dates() {
        let midnight = 1_506_729_600_000_000_000; // 2017-09-30
        let at = |h: i64, m: i64, s: i64, ns: i64| Some(midnight + (h * 3600 + m * 60 + s) * 1_000_000_000 + ns);
        let rows: &[(&[u8], Option<i64>)] = &[
            (b"Sam Sep 30 15:06:13.191 2017", at(15, 6, 13, 191_000_000)),
            (b"Sat Sep 30 10:06:13.191 PM 2017", at(22, 6, 13, 191_000_000)),
            (b"Sat Sep 30 04:09:35.000 pm 2017", at(16, 9, 35, 0)),
            (b"Sat Sep 30 10:44:52.480 am 2017", at(10, 44, 52, 480_000_000)),
            (b"Sat Sep 30 12:00:00 am 2017", at(0, 0, 0, 0)),
            (b"Sat Sep 30 12:00:00 PM 2017", at(12, 0, 0, 0)),
            (b"Sat Sep 30 15:06:13.191234 2017", at(15, 6, 13, 191_234_000)),
            (b"Sat Sep 30 15:06:13.7 2017", at(15, 6, 13, 7_000_000)),
            (b"Sep 30 15:06:13 2017", at(15, 6, 13, 0)),
            (b"Samstag September 30. 15:06:13,191 2017", at(15, 6, 13, 191_000_000)),
            (b"Sa M\xC3\xA4r 26 00:00:00 2022", Some(1_648_252_800_000_000_000)),
            (b"Sa M\xE4r 26 00:00:00 2022", Some(1_648_252_800_000_000_000)),
            (b"Sa Mrz 26 00:00:00 2022", Some(1_648_252_800_000_000_000)),
            (b"Die Dez 21 11:29:01 2004", Some(1_103_628_541_000_000_000)),
            (b"Tue Dec 21 11:29:01 2004", Some(1_103_628_541_000_000_000)),
            (b"Sat Feb 29 15:06:13 2017", None),
            (b"Sat Sep 31 15:06:13 2017", None),
            (b"Sat Sep 30 25:06:13 2017", None),
            (b"Sat Sep 30 15:06:13", None),
            (b"Sat Foo 30 15:06:13 2017", None),
            (b"Sat Sep 30 15:06 2017", None),
            (b"", None),
        ];
        for (text, expected) in rows {
            assert_eq!(read(text), *expected, "{}", String::from_utf8_lossy(text));
        }
    }
}

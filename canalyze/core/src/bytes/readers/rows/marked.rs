//! Rows whose words or marks say what they are: of python-can's printer, of socketcand, of slcan, of BUSMASTER's logs and of
//! Kvaser's CanKing.

use super::columns::Column::{Channel, Id, Length, Time};
use super::columns::{MICROSECOND, MILLISECOND, SECOND};
use super::row::{CLASSIC, LONGER, Row, direction, length};
use super::times::number;
use crate::bytes::frame::{Stamp, StampForm};
use crate::bytes::ns::Ns;
use crate::bytes::readers::candump::lex::{is_blank, is_hex, nibble};

/// Reads a row whose words say what it is, with the name of its program.
pub(super) fn self_describing(text: &[u8]) -> Option<(Row<'_>, &'static str)> {
    if let Some(place) = memchr::memmem::find(text, b"Timestamp: ") {
        return printed(text.get(place..)?).map(|row| (row, "python-can"));
    }
    if let Some(inner) = text.strip_prefix(b"< frame ").and_then(|text| text.strip_suffix(b" >")) {
        return streamed(inner).map(|row| (row, "socketcand"));
    }
    let busmaster = || busmaster(text).map(|row| (row, "BUSMASTER"));
    let canking = || canking(text).map(|row| (row, "CanKing"));
    slcan(text).map(|row| (row, "slcan")).or_else(busmaster).or_else(canking)
}

/// Returns true if a line that cannot be read begins like a row of one of these programs.
pub(super) fn is_meant(text: &[u8]) -> bool {
    let has = |word: &[u8]| memchr::memmem::find(text, word).is_some();
    let adapter = matches!(text, [b't' | b'T' | b'r' | b'R', rest @ ..] if rest.len() > 3 && is_hex(rest));
    let mut words = words(text);
    let (first, second) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    let busmaster = is_time(first) && direction(second).is_some();
    let canking = matches!(first, [b'0'..=b'7']) && second.len() == 8 && is_hex(second);
    let printed = has(b"Timestamp: ") && has(b"ID: ");
    printed || text.starts_with(b"< frame ") || adapter && text.iter().any(u8::is_ascii_digit) || busmaster || canking
}

/// Returns true for a time with a colon before the fraction.
fn is_time(word: &[u8]) -> bool {
    word.iter().filter(|byte| **byte == b':').count() == 3
}

/// `60A 1.5 40 08`: the inner part of socketcand's rows.
fn streamed(text: &[u8]) -> Option<Row<'_>> {
    let mut row = Row::default();
    let mut words = words(text);
    row.take(Id(16), words.next()?)?;
    row.take(Time(SECOND), words.next()?)?;
    words.try_for_each(|word| row.bytes(word))?;
    row.whole()
}

fn words(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    text.split(|byte| is_blank(*byte)).filter(|word| !word.is_empty())
}

/// `11:22:33:4567 Rx 1 0x601 s 8 40 08 10 00 00 00 00 00`: all numbers are decimal in a row without `0x`.
fn busmaster(text: &[u8]) -> Option<Row<'_>> {
    let mut words = words(text);
    let stamp = words.next().filter(|word| is_time(word))?;
    let mut row = Row { direction: Some(direction(words.next()?)?), ..Row::default() };
    row.take(Time(SECOND), stamp)?;
    row.stamp?;
    row.take(Channel(1), words.next().filter(|word| matches!(word, [b'1'..=b'8']))?)?;
    let id = words.next()?;
    row.decimal = !id.starts_with(b"0x") && !id.starts_with(b"0X");
    row.take(Id(if row.decimal { 10 } else { 16 }), id)?;
    (row.extended, row.remote) = match words.next()?.to_ascii_lowercase().as_slice() {
        b"s" => (Some(false), false),
        b"x" => (Some(true), false),
        b"sr" => (Some(false), true),
        b"xr" => (Some(true), true),
        _ => return None,
    };
    row.length = Some(length(words.next().filter(|word| word.len() == 1)?)?);
    words.try_for_each(|word| row.exact_byte(word))?;
    row.whole().filter(Row::is_in_range)
}

/// `0    00000601         8  40 08 10 00 00 00 00 00   12.345678 R`: channel, identifier, flags, length, bytes, seconds,
/// direction. All numbers are decimal in a row whose identifier is not filled with zeros.
fn canking(text: &[u8]) -> Option<Row<'_>> {
    let mut words = words(text).peekable();
    let mut row = Row::default();
    row.take(Channel(0), words.next().filter(|word| matches!(word, [b'0'..=b'7']))?)?;
    let id = words.next()?;
    row.decimal = id.len() < 8;
    row.take(Id(if row.decimal { 10 } else { 16 }), id)?;
    let flags = words.next_if(|word| word.iter().all(|flag| matches!(flag, b'X' | b'R'))).unwrap_or_default();
    (row.extended, row.remote) = (Some(flags.contains(&b'X')), flags.contains(&b'R'));
    row.error = words.next_if(|word| *word == b"ErrorFrame").is_some();
    if !row.error {
        row.length = Some(length(words.next().filter(|word| word.len() == 1)?)?);
    }
    while row.count < row.length.filter(|_| !row.remote).unwrap_or_default() {
        row.exact_byte(words.next()?)?;
    }
    row.take(Time(SECOND), words.next().filter(|word| word.contains(&b'.'))?)?;
    row.stamp?;
    row.direction = match words.next() {
        None => None,
        Some(word) => Some(direction(word).filter(|_| word.len() == 1)?),
    };
    row.whole().filter(|row| words.next().is_none() && row.is_in_range())
}

/// `Timestamp: 1.5    ID: 070a    S Rx    DL:  1    00    Channel: can0`.
fn printed(text: &[u8]) -> Option<Row<'_>> {
    let mut row = Row::default();
    let mut words = words(text);
    (words.next()? == b"Timestamp:").then_some(())?;
    row.take(Time(SECOND), words.next()?)?;
    (words.next()? == b"ID:").then_some(())?;
    row.take(Id(16), words.next()?)?;
    let mut data = false;
    while let Some(word) = words.next() {
        match word {
            b"S" | b"X" if !data => row.extended = Some(word == b"X"),
            b"R" if !data => row.remote = true,
            b"E" if !data => row.error = true,
            b"F" if !data => row.fd = Some(row.fd.unwrap_or_default()),
            b"BS" if !data => row.fd = row.fd.map(|(_, esi)| (true, esi)),
            b"EI" if !data => row.fd = row.fd.map(|(brs, _)| (brs, true)),
            b"DL:" => {
                row.take(Length, words.next()?)?;
                data = true;
            }
            b"Channel:" => {
                row.take(Channel(0), words.next()?)?;
                break;
            }
            _ if data && row.length.is_some_and(|length| row.count < length) && !row.remote => row.bytes(word)?,
            // Behind the bytes they are printed as text.
            _ if data => {}
            _ => row.direction = Some(direction(word)?),
        }
    }
    row.whole()
}

/// `t60A84017100000000000`: type, identifier, code of the length, bytes, and a stamp of the adapter in ms or us.
pub(super) fn slcan(text: &[u8]) -> Option<Row<'_>> {
    let (kind, rest) = text.split_first()?;
    let extended = kind.is_ascii_uppercase();
    let (remote, fd) = match kind.to_ascii_lowercase() {
        b't' => (false, None),
        b'r' => (true, None),
        b'd' => (false, Some((false, false))),
        b'b' => (false, Some((true, false))),
        _ => return None,
    };
    let (id, rest) = rest.split_at_checked(if extended { 8 } else { 3 })?;
    let (code, rest) = rest.split_first()?;
    let length = match usize::from(nibble(*code)) {
        count @ 0..=CLASSIC => count,
        code => *LONGER.get(code - CLASSIC - 1).filter(|_| fd.is_some())?,
    };
    let mut row = Row { extended: Some(extended), remote, fd, length: Some(length), ..Row::default() };
    row.take(Id(16), id)?;
    let (data, after) = rest.split_at_checked(if remote { 0 } else { 2 * length })?;
    if !data.is_empty() {
        row.bytes(data)?;
    }
    let value = i64::from(number(after, 16).unwrap_or_default());
    let (unit, decimals) = match after.len() {
        0 => return row.whole().filter(|row| row.fd.is_none() || row.count > 0),
        4 => (MILLISECOND, 3),
        8 => (MICROSECOND, 6),
        _ => return None,
    };
    let ns = value * unit;
    row.stamp = Some(Stamp { form: StampForm::Seconds, ns: Ns(ns), width: 1, decimals });
    // Milliseconds begin again after a minute, or when their digits end; microseconds after an hour.
    row.wraps_ns = Ns(match after.len() {
        4 if value < 60_000 => 60_000 * unit,
        4 => 65_536 * unit,
        _ => 3600 * SECOND,
    });
    row.whole().filter(|_| is_hex(after))
}

#[cfg(test)]
mod tests {
    use super::self_describing;
    use crate::bytes::frame::Direction;

    type Read = (i64, Option<u32>, Option<bool>, bool, Option<Direction>, Vec<u8>);

    fn read(text: &str) -> Option<Read> {
        let (row, _) = self_describing(text.as_bytes())?;
        let data = row.data.get(..row.count)?.to_vec();
        Some((row.stamp?.ns.as_ns(), row.id.map(|(id, _)| id), row.extended, row.remote, row.direction, data))
    }

    #[test]
    fn rows_of_busmaster_and_canking() {
        let (rx, tx, standard) = (Some(Direction::Rx), Some(Direction::Tx), Some(false));
        let (sdo, data, day) = (Some(0x601), vec![0x40, 0x08, 0x10, 0], 40_953_456_700_000);
        for (text, row) in [
            ("11:22:33:4567 Rx 1 0x601 s 4 40 08 10 00", (day, sdo, standard, false, rx, data.clone())),
            ("11:22:33:4567 Tx 2 1537 s 4 064 008 016 000", (day, sdo, standard, false, tx, data.clone())),
            ("11:22:33:4567 Rx 1 0x601 sr 8", (day, sdo, standard, true, rx, vec![])),
            ("1:2:3:045 Rx 1 0x12345678 x 0", (3_723_045_000_000, Some(0x1234_5678), Some(true), false, rx, vec![])),
            (
                "0    00000601         4  40 08 10 00    12.345678 R",
                (12_345_678_000, sdo, standard, false, rx, data.clone()),
            ),
            ("1    1537   4  64   8  16   0    12.345678 T", (12_345_678_000, sdo, standard, false, tx, data)),
            (
                "0    12345678 X       1  40    0.5",
                (500_000_000, Some(0x1234_5678), Some(true), false, None, vec![0x40]),
            ),
            ("0    00000704 R       0    0.500000 R", (500_000_000, Some(0x704), standard, true, rx, vec![])),
            ("0    00000000      ErrorFrame      0.500000 R", (500_000_000, Some(0), standard, false, rx, vec![])),
        ] {
            assert_eq!(read(text), Some(row), "{text}");
        }
    }

    #[test]
    fn what_does_not_fit_is_no_row() {
        for text in [
            "11:22:33 Rx 1 0x601 s 1 40",
            "11:22:33:4567 Rx 1 0x601 s 2 40",
            "11:22:33:4567 Rx 1 0x601 s 1 40 08",
            "11:22:33:4567 Rx 1 0x801 s 1 40",
            "11:22:33:4567 Rx 1 0x601 q 1 40",
            "25:22:33:4567 Rx 1 0x601 s 1 40",
            "11:22:33:4567 601 1 40",
            "11:22:33:4567 it is 5 o'clock",
            "0    00000601         2  40    12.345678 R",
            "0    00000601         1  40 08    12.345678 R",
            "0    00000601         1  40    12 R",
            "0    00000601         1  40    12.345678 Q",
            "0    00000801         1  40    12.345678 R",
            "0    601 1 4G 1.5 R",
            "0 1 2 3",
            "0 601 8",
        ] {
            assert_eq!(read(text), None, "{text}");
        }
    }
}

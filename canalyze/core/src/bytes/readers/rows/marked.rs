//! Rows whose words or marks say what they are: of python-can's printer, of socketcand, and of slcan.

use super::columns::Column::{Channel, Id, Length, Time};
use super::columns::{MICROSECOND, MILLISECOND, SECOND};
use super::row::{CLASSIC, LONGER, Row, direction};
use super::times::number;
use crate::bytes::frame::{Stamp, StampForm};
use crate::bytes::readers::candump::lex::{is_blank, is_hex, nibble};

/// Reads rows whose words say what they are: of python-can's printer, of socketcand, and of slcan.
pub(super) fn self_describing(text: &[u8]) -> Option<Row<'_>> {
    if let Some(place) = memchr::memmem::find(text, b"Timestamp: ") {
        return printed(text.get(place..)?);
    }
    if let Some(inner) = text.strip_prefix(b"< frame ").and_then(|text| text.strip_suffix(b" >")) {
        let mut row = Row::default();
        let mut words = inner.split(|byte| is_blank(*byte)).filter(|word| !word.is_empty());
        row.take(Id(16), words.next()?)?;
        row.take(Time(SECOND), words.next()?)?;
        words.try_for_each(|word| row.bytes(word))?;
        return row.whole();
    }
    slcan(text)
}

/// `Timestamp: 1.5    ID: 070a    S Rx    DL:  1    00    Channel: can0`.
fn printed(text: &[u8]) -> Option<Row<'_>> {
    let mut row = Row::default();
    let mut words = text.split(|byte| is_blank(*byte)).filter(|word| !word.is_empty());
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
    row.stamp = Some(Stamp { form: StampForm::Seconds, ns, width: 1, decimals });
    // Milliseconds begin again after a minute, or when their digits end; microseconds after an hour.
    row.wraps_ns = match after.len() {
        4 if value < 60_000 => 60_000 * unit,
        4 => 65_536 * unit,
        _ => 3600 * SECOND,
    };
    row.whole().filter(|_| is_hex(after))
}

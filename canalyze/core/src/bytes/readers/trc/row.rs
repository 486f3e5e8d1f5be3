//! The columns of one row.

use super::super::Unreadable;
use super::super::asc::fd_code;
use super::super::candump::lex;
use super::header::{COLUMNS, TrcHeader};
use super::words;
use crate::bytes::frame::{CanId, Kind};

/// Lengths of CAN FD by their codes.
const LENGTHS: [u8; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64];
/// Maximum time of a row, in ms.
const LATEST: u64 = 9_000_000_000_000;

/// The sender of a frame, seen from the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TrcWay {
    Unknown,
    Received,
    Sent,
}

/// A frame in a row.
#[derive(Clone, Copy, Debug)]
pub(super) struct TrcRow {
    pub(super) ns: i64,
    /// Digits of the stamp behind the point, in seconds.
    pub(super) decimals: u8,
    pub(super) channel: u32,
    pub(super) id: CanId,
    pub(super) kind: Kind,
    pub(super) way: TrcWay,
    pub(super) len: u8,
    pub(super) raw_dlc: u8,
    pub(super) data: [u8; 64],
    /// Number of data bytes.
    pub(super) size: u8,
}

/// The reason that a row is no frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TrcFail<'a> {
    /// It is of another type.
    Other(&'a [u8]),
    /// It cannot be read.
    Because(Unreadable),
}

/// Returns the number of a row: `12)`, or a number before a stamp.
pub(super) fn number(text: &[u8]) -> Option<u64> {
    let end = text.iter().position(|byte| !byte.is_ascii_digit()).unwrap_or(text.len());
    let (digits, rest) = text.split_at_checked(end).filter(|(digits, _)| (1..=12).contains(&digits.len()))?;
    let marked = matches!(rest, [b')', b' ' | b'\t', ..]);
    let stamp = words(rest).next().unwrap_or_default();
    let timed = rest.first().is_some_and(|byte| matches!(byte, b' ' | b'\t'))
        && stamp.iter().all(|byte| byte.is_ascii_digit() || *byte == b'.')
        && words(rest).nth(1).is_some();
    (marked || timed).then(|| digits.iter().fold(0, |sum: u64, digit| sum * 10 + u64::from(digit - b'0')))
}

/// Reads a row; `last`: its line has no end.
pub(super) fn read<'a>(text: &'a [u8], header: &TrcHeader, last: bool) -> Result<TrcRow, TrcFail<'a>> {
    const NONE: TrcFail<'_> = TrcFail::Because(Unreadable::NoFrame);
    let second = header.is_second();
    // The data of later versions have a column of their own, those of version 1 follow the length.
    let data_at = if second { header.at(b'D') } else { header.at(b'L').map(|at| at + 1) };
    let mut row: [&[u8]; COLUMNS] = [&[]; COLUMNS];
    let mut rest = text;
    for slot in row.iter_mut().take(data_at.unwrap_or(COLUMNS)) {
        (*slot, rest) = lex::word(lex::skip_blanks(rest));
    }
    if holds_two(text, second) {
        return Err(NONE);
    }
    let word = |letter: u8| header.at(letter).and_then(|at| row.get(at)).copied().unwrap_or_default();
    let kind = match (header.at(b'T'), word(b'I')) {
        (None, b"FFFFFFFF") => return Err(TrcFail::Other(b"FFFFFFFF")),
        (None, _) => b"".as_slice(),
        _ => word(b'T'),
    };
    let (ns, decimals) = stamp(word(b'O')).ok_or(NONE)?;
    let channel = if header.at(b'B').is_some() { decimal(word(b'B')) } else { Some(1) };
    let error = matches!(kind, b"ER" | b"Error");
    if error {
        let (id, way, data) = (CanId::standard(0), TrcWay::Unknown, [0; 64]);
        let channel = channel.unwrap_or(1);
        return Ok(TrcRow { ns, decimals, channel, id, kind: Kind::Error, way, len: 0, raw_dlc: 0, data, size: 0 });
    }
    let fd = match kind {
        b"" | b"Rx" | b"Tx" if !second => None,
        b"DT" | b"RR" if second => None,
        b"FD" | b"FB" | b"FE" | b"BI" if second => {
            Some(Kind::Fd { brs: matches!(kind, b"FB" | b"FE"), esi: matches!(kind, b"FE" | b"BI") })
        }
        _ => return Err(TrcFail::Other(kind)),
    };
    let channel = channel.ok_or(NONE)?;
    let id = identifier(word(b'I')).ok_or(NONE)?.ok_or(TrcFail::Because(Unreadable::Identifier))?;
    let way = match if second { word(b'd') } else { kind } {
        _ if !header.has_directions() => TrcWay::Unknown,
        b"Rx" => TrcWay::Received,
        _ => TrcWay::Sent,
    };
    let (length, coded) = match decimal(word(b'l')) {
        Some(length) => (length, false),
        None => (decimal(word(b'L')).ok_or(NONE)?, true),
    };
    data_at.ok_or(NONE)?;
    let remote = if second { kind == b"RR" } else { words(rest).next() == Some(b"RTR".as_slice()) };
    let wanted = usize::try_from(length).map_err(|_| NONE)?;
    let (data, size) = match () {
        () if remote || second && wanted == 0 => ([0; 64], 0),
        () if second => bytes(words(rest).take_while(|word| !is_remark(word)), false).ok_or(NONE)?.0,
        () => {
            let (data, count) = bytes(words(rest).take(wanted), true).ok_or(NONE)?;
            (count == wanted).then_some(data).ok_or(NONE)?
        }
    };
    let code = u8::try_from(length).unwrap_or(u8::MAX);
    if last && !second && may_go_on(text) {
        return Err(TrcFail::Because(Unreadable::Cut));
    }
    let row = TrcRow { ns, decimals, channel, id, kind: Kind::Data, way, len: size, raw_dlc: 0, data, size };
    let raw = |code: u8| if (9..16).contains(&code) { code } else { 0 };
    let bad = Err(TrcFail::Because(Unreadable::Data));
    match fd {
        _ if remote => Ok(TrcRow { kind: Kind::Remote, len: code.min(8), raw_dlc: raw(code), ..row }),
        Some(kind) => {
            let said = if coded { LENGTHS.get(wanted.min(15)).copied().unwrap_or(64) } else { code };
            if said == size { Ok(TrcRow { kind, ..row }) } else { bad }
        }
        // Only a frame of CAN FD holds more.
        None if size > 8 && second => bad,
        None if size > 8 => Ok(TrcRow { kind: Kind::Fd { brs: false, esi: false }, ..row }),
        None => {
            let code = if coded { code } else { u8::try_from(fd_code(length.into())).unwrap_or(code) };
            if code != size && (size < 8 || code < 8) { bad } else { Ok(TrcRow { raw_dlc: raw(code), ..row }) }
        }
    }
}

/// Returns true if a second row begins in a line: damage has made something else of the newline between them.
fn holds_two(text: &[u8], second: bool) -> bool {
    if memchr::memchr_iter(b'.', text).nth(1).is_none() {
        return false;
    }
    let number = |word: &[u8]| if second { word.iter().all(u8::is_ascii_digit) } else { word.ends_with(b")") };
    let stamped = |word: &[u8]| {
        let points = word.iter().filter(|byte| **byte == b'.').count();
        points == 1 && word.len() > 1 && word.iter().all(|byte| byte.is_ascii_digit() || *byte == b'.')
    };
    let told = words(text).take_while(|word| !second || !is_remark(word));
    words(text).zip(told.skip(1)).skip(1).any(|(one, two)| number(one) && stamped(two))
}

/// Returns true for the word with which a remark begins.
fn is_remark(word: &[u8]) -> bool {
    let arrow = "\u{2190}".as_bytes();
    matches!(word, [b';' | b'#', ..] | [b'/', b'/', ..] | [b'<', b'-', ..]) || word.starts_with(arrow)
}

/// Returns true if a line that lacks its end may be the beginning of another frame's: half a byte, or a length of 0
/// behind which `RTR` may have been.
fn may_go_on(text: &[u8]) -> bool {
    words(text).last().is_some_and(|last| last.len() < 2 || last == b"RT")
}

/// Returns the data bytes, of two digits each or written together, and the number of words; `lone`: also of one digit.
fn bytes<'a>(words: impl Iterator<Item = &'a [u8]>, lone: bool) -> Option<(([u8; 64], u8), usize)> {
    let (mut data, mut size, mut count) = ([0; 64], 0_usize, 0);
    for word in words {
        count += 1;
        for pair in word.chunks(2) {
            let byte = match pair {
                [high, low] => lex::byte(*high, *low)?,
                [low] if lone && word.len() == 1 => lex::byte(b'0', *low)?,
                _ => return None,
            };
            *data.get_mut(size)? = byte;
            size += 1;
        }
    }
    Some(((data, u8::try_from(size).ok()?), count))
}

/// Returns an identifier; `Some(None)` if it is too large.
fn identifier(word: &[u8]) -> Option<Option<CanId>> {
    let digits = (1..=8).contains(&word.len()) && lex::is_hex(word);
    let raw = digits.then(|| word.iter().fold(0, |sum, digit| sum << 4 | u32::from(lex::nibble(*digit))))?;
    Some(match u16::try_from(raw) {
        Ok(short) if short <= 0x7FF && word.len() <= 4 => Some(CanId::standard(short)),
        _ => (raw <= 0x1FFF_FFFF).then(|| CanId::extended(raw)),
    })
}

fn decimal(word: &[u8]) -> Option<u32> {
    let digits = (1..=9).contains(&word.len()) && word.iter().all(u8::is_ascii_digit);
    digits.then(|| word.iter().fold(0, |sum, digit| sum * 10 + u32::from(digit - b'0')))
}

/// Returns a time in ms as ns, and its digits behind the point in seconds.
fn stamp(word: &[u8]) -> Option<(i64, u8)> {
    let point = word.iter().position(|byte| *byte == b'.').unwrap_or(word.len());
    let (whole, fraction) = word.split_at_checked(point)?;
    let fraction = fraction.get(1..).unwrap_or_default();
    let digits = whole.len() <= 15 && whole.iter().chain(fraction).all(u8::is_ascii_digit);
    if !digits || whole.is_empty() && fraction.is_empty() {
        return None;
    }
    let ms = whole.iter().fold(0_u64, |sum, digit| sum * 10 + u64::from(digit - b'0'));
    let part = |at: usize| fraction.get(at).map_or(0, |digit| i64::from(digit - b'0'));
    let below = (0..6).fold(0, |sum, at| sum * 10 + part(at)) + i64::from(part(6) >= 5);
    let ns = i64::try_from(ms).ok().filter(|_| ms < LATEST)?.checked_mul(1_000_000)?.checked_add(below)?;
    Some((ns, (3 + fraction.len().min(6)) as u8))
}

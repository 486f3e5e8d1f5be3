//! Lines of events on a classic channel: `12.500000 1  601  Rx   d 8 40 08 10 00 00 00 00 00  Length = .. ID = ..`.
//!
//! The plain line of large files has a faster path with exactly the same result. A line is a frame only if all its
//! columns fit.

use super::words::{Fail, LineWords, Way, data_byte, fd_length, identifier, is_fd_length, number, stamp, way};
use super::{AscChannel, Event};
use crate::bytes::frame::{BusId, CanId, Direction, Frame, Kind, LengthForm, Stamp};
use crate::bytes::readers::Unreadable;
use crate::bytes::readers::candump::lex::{is_stray_byte, nibble, skip_blanks};

/// Parses the plain line: stamp, channel, identifier, direction, a hexadecimal data frame, and optionally Vector's
/// columns after it. `None` for anything else.
#[inline(always)]
pub(super) fn plain(line: &[u8]) -> Option<(Frame, AscChannel)> {
    let (stamp, rest) = stamp(skip_blanks(line))?;
    let (channel, rest) = match skip_blanks(rest) {
        [ones @ b'1'..=b'9', b' ', rest @ ..] => (AscChannel::from(ones - b'0'), rest),
        [tens @ b'1'..=b'9', ones @ b'0'..=b'9', b' ', rest @ ..] => {
            (AscChannel::from((tens - b'0') * 10 + (ones - b'0')), rest)
        }
        _ => return None,
    };
    let (id, rest) = plain_identifier(skip_blanks(rest))?;
    let (dir, rest) = match skip_blanks(rest) {
        [b'R', b'x', b' ', rest @ ..] => (Direction::Rx, rest),
        [b'T', b'x', b' ', rest @ ..] => (Direction::Tx, rest),
        _ => return None,
    };
    let [b'd', b' ', len @ b'0'..=b'8', rest @ ..] = skip_blanks(rest) else { return None };
    let len = len - b'0';
    let (bytes, tail) = rest.split_at_checked(3 * usize::from(len))?;
    let mut data = [0; 64];
    let mut check = 0;
    let (triples, _) = bytes.as_chunks::<3>();
    for (slot, &[blank, high, low]) in data.iter_mut().zip(triples) {
        let (high, low) = (nibble(high), nibble(low));
        check |= high | low | if blank == b' ' { 0 } else { 0xFF };
        *slot = high << 4 | low & 0xF;
    }
    if check > 15 || !matches!(tail, [] | [b'\r'] | [b' ']) && !is_plain_tail(tail) {
        return None;
    }
    Some((frame(stamp, id, Kind::Data, Some(dir), len, data), channel))
}

/// Returns true for Vector's columns after a frame, without a further event.
#[inline(always)]
fn is_plain_tail(tail: &[u8]) -> bool {
    // `  Length = 24401600 BitCount = 1250 ID = 419363071x`: this length leaves no room for another event.
    const LONGEST: usize = 52;
    let ends = matches!(tail, [.., b'0'..=b'9' | b'x'] | [.., b'0'..=b'9' | b'x', b'\r']);
    tail.starts_with(b"  Length = ") && tail.len() <= LONGEST && ends
}

/// Parses hexadecimal digits, an optional `x`, and a blank.
#[inline(always)]
fn plain_identifier(mut text: &[u8]) -> Option<(CanId, &[u8])> {
    let mut value = 0u32;
    let mut count = 0;
    while let [digit, rest @ ..] = text {
        let digit = nibble(*digit);
        if digit > 15 {
            break;
        }
        value = value << 4 | u32::from(digit);
        count += 1;
        text = rest;
    }
    if !(1..=8).contains(&count) {
        return None;
    }
    match text {
        [b' ', rest @ ..] if value <= 0x7FF => Some((CanId::standard(value as u16), rest)),
        [b'x', b' ', rest @ ..] if value <= 0x1FFF_FFFF => Some((CanId::extended(value), rest)),
        _ => None,
    }
}

/// Makes a frame of these parts; the caller sets its bus.
pub(super) fn frame(stamp: Stamp, id: CanId, kind: Kind, dir: Option<Direction>, len: u8, data: [u8; 64]) -> Frame {
    Frame {
        no: 0,
        moved: 0,
        corrected_ns: 0,
        line: None,
        t_ns: None,
        stamp: Some(stamp),
        bus: BusId(0),
        id,
        kind,
        dir,
        len,
        length_form: LengthForm::default(),
        data,
    }
}

/// Makes an error frame; the details of Vector's programs are not a class of SocketCAN.
pub(super) fn error(stamp: Stamp, dir: Option<Direction>) -> Frame {
    frame(stamp, CanId::extended(0), Kind::Error, dir, 0, [0; 64])
}

/// Returns true if the word begins the line of an error frame.
pub(super) fn is_error(word: &[u8]) -> bool {
    word.get(..10).is_some_and(|name| name.eq_ignore_ascii_case(b"ErrorFrame"))
}

/// Parses an event after its channel. `decimal`: the base of the header; `last`: the line has no newline.
pub(super) fn event<'a>(mut words: LineWords<'a>, stamp: Stamp, decimal: bool, last: bool) -> Result<Event<'a>, Fail> {
    let first = words.need(Unreadable::NoFrame)?;
    if is_error(first) {
        return Ok(Event::Frame(error(stamp, None)));
    }
    let id = identifier(first, decimal);
    let numeric = id != Err(Unreadable::NoFrame);
    // Directions may be missing, and a symbolic name may precede them or replace the identifier.
    let dir = match way(words.peek()) {
        Some(way) => {
            words.next();
            Some(way)
        }
        None if numeric && matches!(words.peek(), b"d" | b"r") => None,
        None => {
            let mut named = words;
            named.next();
            match way(named.peek()) {
                Some(way) => {
                    named.next();
                    words = named;
                    Some(way)
                }
                None if numeric => {
                    return Err(Fail { reason: Unreadable::NoFrame, end: named.is_empty() });
                }
                None => return Ok(Event::Passed(first)),
            }
        }
    };
    let dir = match dir {
        Some(Way::Request) => return Ok(Event::Passed(b"TxRq")),
        Some(Way::Frame(dir)) => Some(dir),
        None => None,
    };
    let id = match id {
        Ok(id) => id,
        Err(reason) => match symbolic(words, last) {
            Some(id) => id?,
            None => return Err(Fail { reason: if numeric { reason } else { Unreadable::Identifier }, end: false }),
        },
    };
    let empty = frame(stamp, id, Kind::Data, dir, 0, [0; 64]);
    match words.need(Unreadable::NoFrame)? {
        b"d" | b"D" => data(words, empty, decimal, last),
        // The end of the file may have cut off the length.
        b"r" | b"R" if last && words.is_empty() => words.fail(Unreadable::Length),
        b"r" | b"R" => remote(words, empty, decimal),
        _ => words.fail(Unreadable::NoFrame),
    }
}

/// Finds `ID = 418119424x` at the end of the line: the number of an identifier written by name, always decimal.
fn symbolic(mut words: LineWords<'_>, last: bool) -> Option<Result<CanId, Fail>> {
    while let Some(word) = words.next() {
        if word != b"ID" || words.peek() != b"=" {
            continue;
        }
        words.next();
        let id = words.next()?;
        // A number cut by the end of the file is another number.
        if last && words.is_empty() {
            return Some(words.fail(Unreadable::Identifier));
        }
        return Some(identifier(id, true).map_err(|reason| Fail { reason, end: false }));
    }
    None
}

/// Parses the length and the data. The bytes show the meaning of the length: `8`, the raw code `D` before eight bytes,
/// `40` before the 64 bytes of a frame that can only be CAN FD.
fn data<'a>(mut words: LineWords<'a>, mut frame: Frame, decimal: bool, last: bool) -> Result<Event<'a>, Fail> {
    let code = words.need(Unreadable::Length)?;
    if code.len() > 2 {
        return words.fail(Unreadable::Length);
    }
    // A code of one letter is hexadecimal in any base.
    let bases = if decimal { [true, false] } else { [false, false] };
    let count = bytes(words, decimal);
    let mut meant = false;
    let mut found = None;
    for code in bases.iter().filter_map(|&decimal| number(code, decimal)) {
        let candidates = [
            (code <= 8).then_some((code, 0)),
            (9..16).contains(&code).then_some((8, code)),
            fd_length(code).filter(|_| code > 8).map(|len| (len, 0)),
            (code > 8 && is_fd_length(code)).then_some((code, 0)),
        ];
        meant |= candidates.iter().any(Option::is_some);
        let fits = candidates.into_iter().flatten().filter(|(len, _)| *len <= count);
        // The longest one, since leftover bytes would mean that the line does not fit.
        if let Some(best) = fits.max_by_key(|(len, _)| *len)
            && found.is_none()
        {
            found = Some(best);
        }
    }
    let Some((len, raw)) = found else {
        if !meant {
            return words.fail(Unreadable::Length);
        }
        // The last of the bytes may be half a byte.
        for _ in 0..count {
            words.next();
        }
        words.next();
        return words.fail(Unreadable::Data);
    };
    for slot in frame.data.iter_mut().take(len as usize) {
        *slot = words.next().and_then(|word| data_byte(word, decimal)).unwrap_or_default();
    }
    if last && may_go_on(words, decimal) {
        return words.fail(Unreadable::Data);
    }
    frame.len = len as u8;
    frame.length_form.raw_dlc = raw as u8;
    if len > 8 {
        frame.kind = Kind::Fd { brs: false, esi: false };
    }
    no_more_bytes(words, decimal)?;
    Ok(Event::Frame(frame))
}

/// Returns true if the last byte of a line without a newline may have had more digits.
pub(super) fn may_go_on(words: LineWords<'_>, decimal: bool) -> bool {
    decimal && words.is_empty() && matches!(words.last(), [b'1'..=b'9'] | [b'1'..=b'2', _])
}

/// Returns the number of data bytes that follow, at most 65.
fn bytes(mut words: LineWords<'_>, decimal: bool) -> u64 {
    let mut count = 0;
    while count < 65 && words.next().is_some_and(|word| data_byte(word, decimal).is_some()) {
        count += 1;
    }
    count
}

/// Fails if another byte follows a complete frame, since its length would be wrong.
fn no_more_bytes(words: LineWords<'_>, decimal: bool) -> Result<(), Fail> {
    let next = words.peek();
    let stray = if decimal { data_byte(next, true).is_some() } else { is_stray_byte(next) };
    if stray { Err(Fail { reason: Unreadable::Length, end: false }) } else { Ok(()) }
}

/// Parses `r`, `r 8`, `r Length = ..`.
fn remote<'a>(mut words: LineWords<'a>, mut frame: Frame, decimal: bool) -> Result<Event<'a>, Fail> {
    frame.kind = Kind::Remote;
    let code = words.peek();
    if code.first().is_some_and(u8::is_ascii_digit) || code.len() == 1 {
        words.next();
        match number(code, false).or_else(|| number(code, decimal)) {
            Some(code @ 0..=8) => frame.len = code as u8,
            Some(code @ 9..=15) => {
                frame.len = 8;
                frame.length_form.raw_dlc = code as u8;
            }
            _ => return words.fail(Unreadable::Length),
        }
        no_more_bytes(words, decimal)?;
    }
    Ok(Event::Frame(frame))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]

    use proptest::prelude::*;

    use super::super::words::{LineWords, number, stamp};
    use super::super::{AscChannel, Event};
    use super::{event, plain, skip_blanks};

    proptest! {
        // If the two paths differed, a column after the data would change the frame.
        #[test]
        fn plain_is_general(line in " {0,2}[0-9]{1,2}\\.[0-9]{1,7} [0-9]{1,2} {1,2}([0-7][0-9A-Fa-f]{0,3}|[01][0-9A-F]{7})x? {1,9}[RT]xR? {1,3}[dr] [0-9]( [0-9A-Fa-f]{2}){0,9}(\r| |  Length = 244016 BitCount = 125 ID = 384x| 1)?") {
            let Some((frame, channel)) = plain(line.as_bytes()) else { return Ok(()) };
            let text = line.trim_ascii_end().as_bytes();
            let (stamp, rest) = stamp(skip_blanks(text)).unwrap();
            let mut words = LineWords::new(rest);
            prop_assert_eq!(number(words.next().unwrap(), true), Some(u64::from(channel)));
            let Ok(Event::Frame(general)) = event(words, stamp, false, false) else { panic!("{line:?}") };
            prop_assert_eq!(format!("{:?}", frame), format!("{:?}", general));
        }
    }

    #[test]
    fn the_common_line_is_plain() {
        for line in [
            "   0.000000 1  601             Rx   d 8 40 08 10 00 00 00 00 00",
            "  13.258199 12  18EBFF00x       Tx   d 8 6A 00 00 00 00 00 00 00  Length = 244016 BitCount = 125 ID = 384x\r",
            "0.1 1 80 Rx d 0\r",
            "0.1 1 80 Rx d 0 ",
        ] {
            assert!(plain(line.as_bytes()).is_some(), "{line}");
        }
        let (frame, channel) = plain(b" 1.5 2 80x Rx d 1 fE").unwrap();
        assert_eq!(
            (frame.id, channel, frame.payload()),
            (crate::bytes::frame::CanId::extended(0x80), AscChannel::from(2u8), &[0xFE][..])
        );
    }
}

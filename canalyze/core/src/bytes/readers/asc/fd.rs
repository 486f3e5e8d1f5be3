//! Lines of frames on channels of CAN FD and CAN XL. Both may carry classic frames.
//!
//! `CANFD ch Rx id [name] brs esi dlc length data.. duration bits flags ..`, the older order `CANFD ch id Tx brs esi d
//! dlc length data..` and `.. r dlc`, and `CANXL ch Rx format duration bits id [name] dlc length data.. crc flags ..`.

use super::Event;
use super::classic::{error, frame, is_error, may_go_on};
use super::words::{Fail, LineWords, Way, data_byte, fd_code, identifier, number, way};
use crate::bytes::frame::{CanId, Frame, Kind, Stamp};
use crate::bytes::readers::Unreadable;

/// Flag of a remote frame.
const RTR: u64 = 0x10;
/// Flag of the CAN FD format; without it the frame is a classic one.
const FDF: u64 = 0x1000;
/// Flag of the bit rate switch.
const BRS: u64 = 0x2000;
/// Flag of the error state indicator.
const ESI: u64 = 0x4000;

/// Parses a line of CAN FD after its channel. `decimal`: its numbers are decimal; `last`: it has no newline.
pub(super) fn event<'a>(mut words: LineWords<'a>, stamp: Stamp, decimal: bool, last: bool) -> Result<Event<'a>, Fail> {
    let mut first = words.need(Unreadable::NoFrame)?;
    let mut direction = way(first);
    let old = direction.is_none() && !is_error(first);
    if old {
        direction = way(words.need(Unreadable::NoFrame)?);
        if direction.is_none() {
            return words.fail(Unreadable::NoFrame);
        }
    } else if direction.is_some() {
        first = words.need(Unreadable::NoFrame)?;
    }
    let dir = match direction {
        Some(Way::Request) => return Ok(Event::Passed(b"TxRq")),
        Some(Way::Frame(dir)) => Some(dir),
        None => None,
    };
    if is_error(first) {
        return Ok(Event::Frame(error(stamp, dir)));
    }
    let id = identifier(first, decimal).map_err(|reason| Fail {
        reason: if reason == Unreadable::NoFrame { Unreadable::Identifier } else { reason },
        end: words.is_empty(),
    })?;
    // A symbolic name is never a bit.
    if !matches!(words.peek(), b"0" | b"1") && words.next().is_none() {
        return words.fail(Unreadable::NoFrame);
    }
    let brs = bit(&mut words)?;
    let esi = bit(&mut words)?;
    let mut remote = false;
    if old || matches!(words.peek(), b"r" | b"R") {
        match words.need(Unreadable::NoFrame)? {
            b"d" | b"D" => {}
            b"r" | b"R" => remote = true,
            _ => return words.fail(Unreadable::NoFrame),
        }
    }
    let code = words.need(Unreadable::Length)?;
    let mut frame = frame(stamp, id, Kind::Fd { brs, esi }, dir, 0, [0; 64]);
    if remote {
        let code = number(code, false).filter(|code| *code < 16);
        classic(&mut frame, code.map_or_else(|| words.fail(Unreadable::Length), Ok)?, true);
        return Ok(Event::Frame(frame));
    }
    let len = data(&mut words, &mut frame, decimal)?;
    if last && may_go_on(words, decimal) {
        return words.fail(Unreadable::Data);
    }
    let flags = flags(words, 2, last)?;
    // The flag of a classic frame comes after the data.
    if last && flags.is_none() && !old && !brs && !esi && len <= 8 {
        return Err(Fail { reason: Unreadable::Data, end: true });
    }
    let codes = [number(code, false), number(code, true)];
    // Some programs write the length instead of its code. A length between two codes has the code of the next one.
    let fits = |len: u64| codes.iter().flatten().any(|code| *code == len || *code == fd_code(len));
    let raw = number(code, false).filter(|code| *code < 16);
    match (flags, raw) {
        (Some(flags), Some(code)) if flags & (FDF | RTR) == RTR => classic(&mut frame, code, true),
        (Some(flags), Some(code)) if flags & FDF == 0 && len == code.min(8) && !brs && !esi => {
            classic(&mut frame, code, false);
        }
        // A length code without data is a remote frame.
        (None, Some(code @ 1..)) if len == 0 => classic(&mut frame, code, true),
        _ if fits(len) => {}
        _ => return Err(Fail { reason: Unreadable::Length, end: false }),
    }
    Ok(Event::Frame(frame))
}

/// Parses a line of CAN XL after its channel.
pub(super) fn xl_event<'a>(mut words: LineWords<'a>, stamp: Stamp, last: bool) -> Result<Event<'a>, Fail> {
    let dir = match way(words.need(Unreadable::NoFrame)?) {
        Some(Way::Request) => return Ok(Event::Passed(b"TxRq")),
        Some(Way::Frame(dir)) => dir,
        None => return words.fail(Unreadable::NoFrame),
    };
    let format = words.need(Unreadable::NoFrame)?;
    if is_error(format) {
        return Ok(Event::Frame(error(stamp, Some(dir))));
    }
    match format {
        b"CBFF" | b"CEFF" | b"FBFF" | b"FEFF" => {}
        _ => return Err(Fail { reason: Unreadable::CanXl, end: false }),
    }
    // Duration and number of bits.
    words.need(Unreadable::NoFrame)?;
    words.need(Unreadable::NoFrame)?;
    let id = xl_identifier(words.need(Unreadable::NoFrame)?, format.get(1) == Some(&b'E'));
    let id = id.map_or_else(|| words.fail(Unreadable::Identifier), Ok)?;
    if number(words.peek(), false).is_none_or(|code| code > 15) {
        words.next();
    }
    let code = words.need(Unreadable::Length)?;
    let Some(code) = number(code, false).filter(|code| *code < 16) else { return words.fail(Unreadable::Length) };
    xl_frame(words, frame(stamp, id, Kind::Data, Some(dir), 0, [0; 64]), code, format.starts_with(b"F"), last)
}

fn xl_identifier(word: &[u8], extended: bool) -> Option<CanId> {
    let digits = word.strip_suffix(b"x").or_else(|| word.strip_suffix(b"X")).unwrap_or(word);
    match number(digits, false)? {
        raw @ 0..=0x1FFF_FFFF if extended => Some(CanId::extended(raw as u32)),
        raw @ 0..=0x7FF => Some(CanId::standard(raw as u16)),
        _ => None,
    }
}

fn xl_frame<'a>(
    mut words: LineWords<'a>,
    mut frame: Frame,
    code: u64,
    fd: bool,
    last: bool,
) -> Result<Event<'a>, Fail> {
    let len = data(&mut words, &mut frame, false)?;
    let flags = flags(words, if fd { 2 } else { 1 }, last)?.unwrap_or_default();
    let remote = !fd && flags & RTR != 0;
    let fits = if fd { code == fd_code(len) } else { len == code.min(8) };
    if remote || fits && !fd {
        classic(&mut frame, code, remote);
    } else if fits {
        frame.kind = Kind::Fd { brs: flags & BRS != 0, esi: flags & ESI != 0 };
    } else {
        return Err(Fail { reason: Unreadable::Length, end: false });
    }
    Ok(Event::Frame(frame))
}

fn bit(words: &mut LineWords<'_>) -> Result<bool, Fail> {
    match words.need(Unreadable::NoFrame)? {
        b"0" => Ok(false),
        b"1" => Ok(true),
        _ => words.fail(Unreadable::NoFrame),
    }
}

/// Parses the number of bytes, always decimal, and the bytes.
fn data(words: &mut LineWords<'_>, frame: &mut Frame, decimal: bool) -> Result<u64, Fail> {
    let word = words.need(Unreadable::Length)?;
    let Some(len) = number(word, true).filter(|len| *len <= 64) else {
        return words.fail(Unreadable::Length);
    };
    for slot in frame.data.iter_mut().take(len as usize) {
        *slot = match words.next().and_then(|word| data_byte(word, decimal)) {
            Some(byte) => byte,
            None => return words.fail(Unreadable::Data),
        };
    }
    frame.len = len as u8;
    Ok(len)
}

/// Turns it into a classic frame with its length code.
fn classic(frame: &mut Frame, code: u64, remote: bool) {
    frame.kind = if remote { Kind::Remote } else { Kind::Data };
    frame.len = code.min(8) as u8;
    frame.length_form.raw_dlc = if code > 8 { code as u8 } else { 0 };
    if remote {
        frame.data = [0; 64];
    }
}

/// Parses the flags, which are `columns` columns after the data; `None` if the line ends with the data.
fn flags(mut words: LineWords<'_>, columns: usize, last: bool) -> Result<Option<u64>, Fail> {
    if words.is_empty() {
        return Ok(None);
    }
    for _ in 0..columns {
        words.next();
    }
    let flags = words.next().and_then(|word| number(word, false));
    // If the end of the file cut off digits, the flags would be others.
    if last && words.is_empty() { words.fail(Unreadable::Data) } else { Ok(flags) }
}

/// Returns true if the numbers of a line are hexadecimal although the header says decimal, as in many programs; `None`
/// if the line does not show it.
pub(super) fn is_hexadecimal(mut words: LineWords<'_>) -> Option<bool> {
    // The direction is the first or second word; the data follow the first decimal number with as many bytes after it.
    let letters = |word: &[u8]| word.iter().any(u8::is_ascii_alphabetic);
    let first = words.next()?;
    let id = if way(first).is_some() { words.next()? } else { first };
    let digits = id.strip_suffix(b"x").unwrap_or(id);
    if number(digits, false).is_some() && letters(digits) {
        return Some(true);
    }
    let mut brs = words.next()?;
    while !matches!(brs, b"0" | b"1") {
        brs = words.next()?;
    }
    words.next()?;
    let code = words.next()?;
    if matches!(code, b"d" | b"r") {
        words.next()?;
    }
    let len = number(words.next()?, true)?;
    let mut shown = None;
    for _ in 0..len {
        let word = words.next()?;
        match word {
            [b'0', _] => return Some(true),
            [_, _] if letters(word) => return Some(true),
            [_] | [_, _, _] => shown = Some(false),
            _ => {}
        }
    }
    shown
}

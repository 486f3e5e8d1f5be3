//! The compact family: `candump -L`, its log files, and the arguments of cansend.
//!
//! `(1579857014.345944) can2 486#82967A6B006B07F8`, with or without stamp and interface, and with dots, colons or blanks
//! between the bytes. Log files are the large inputs, so the plain line has a faster path with exactly the same result.

use super::lex::{Fail, byte, identifier, is_blank, is_hex, is_name, is_stray_byte, nibble, pairs, skip_blanks, word};
use super::stamp;
use crate::bytes::frame::{BusId, CanId, Direction, Frame, Kind, LengthForm, Stamp};
use crate::bytes::ns::Ns;
use crate::bytes::readers::Unreadable;

/// A plain line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plain<'a> {
    pub(super) stamp: Stamp,
    /// The interface, if it is not that of the plain line before.
    pub(super) interface: Option<&'a [u8]>,
    id: CanId,
    kind: Kind,
    len: u8,
    head: [u8; 8],
}

impl<'a> Plain<'a> {
    /// Parses a plain line up to the end of its data: stamp, one blank, interface, one blank, classic data frame. Also returns
    /// the text behind it, where the line may go on. `None` for anything else. `last`: the interface of the previous plain
    /// line.
    #[inline(always)]
    pub(super) fn parse(text: &'a [u8], last: &[u8]) -> Option<(Self, &'a [u8])> {
        let (stamp, rest) = stamp::read(text)?;
        let rest = rest.strip_prefix(b" ")?;
        let (interface, rest) = match rest.split_at_checked(last.len()) {
            Some((bus, [b' ', after @ ..])) if !bus.is_empty() && bus == last => (None, after),
            _ => {
                let (bus, after) = word(rest);
                if !is_name(bus) || bus.ends_with(b":") {
                    return None;
                }
                (Some(bus), after.strip_prefix(b" ")?)
            }
        };
        let (digits, rest) = match rest {
            [a, b, c, b'#', rest @ ..] => (&[*a, *b, *c][..], rest),
            [a, b, c, d, e, f, g, h, b'#', rest @ ..] => (&[*a, *b, *c, *d, *e, *f, *g, *h][..], rest),
            _ => return None,
        };
        let (id, error) = identifier(digits).ok()?;
        let (digits, head) = match rest.first_chunk() {
            Some(sixteen) => pairs(*sixteen),
            None => {
                let mut sixteen = [0; 16];
                sixteen.iter_mut().zip(rest).for_each(|(slot, byte)| *slot = *byte);
                pairs(sixteen)
            }
        };
        let rest = rest.get(digits as usize..).filter(|_| digits.is_multiple_of(2))?;
        let kind = if error { Kind::Error } else { Kind::Data };
        Some((Self { stamp, interface, id, kind, len: (digits / 2) as u8, head: head.to_le_bytes() }, rest))
    }

    /// Returns its frame.
    #[inline(always)]
    pub(super) fn frame(&self, bus: BusId, line: u64, t_ns: Option<Ns>) -> Frame {
        let Self { stamp, id, kind, len, head, .. } = *self;
        let mut data = [0; 64];
        if let Some(slot) = data.first_chunk_mut() {
            *slot = head;
        }
        Frame {
            no: 0,
            moved: 0,
            corrected_ns: 0,
            line: Some(line),
            t_ns,
            stamp: Some(stamp),
            bus,
            id,
            kind,
            dir: None,
            len,
            length_form: LengthForm::default(),
            data,
        }
    }
}

/// Parses a frame, from the word `ID#...` and the text after it, into an empty one; returns the rest.
pub(super) fn frame<'a>(text: &[u8], after: &'a [u8], frame: &mut Frame) -> Result<&'a [u8], Fail> {
    let mark = text.iter().position(|&byte| byte == b'#').unwrap_or(text.len());
    let (id, rest) = text.split_at_checked(mark).unwrap_or((text, &[]));
    let rest = rest.strip_prefix(b"#").unwrap_or(rest);
    let begun =
        || rest.iter().all(|&byte| nibble(byte) < 16 || matches!(byte, b'.' | b':' | b'#' | b'R' | b'r' | b'_'));
    let fail = |reason| Fail { reason, end: reason == Unreadable::Data && after.is_empty() && begun() };
    // Flags, type and acceptance field of CAN XL, and its data behind a second mark; the network of its identifier is
    // left out if it is 0, and then the line may be a classic frame with colons between its bytes.
    if let (3 | 5, [_, _, b':', _, _, b':', field @ ..]) = (id.len(), rest)
        && (id.len() == 5 || field.contains(&b'#'))
    {
        return Err(fail(if is_hex(id) { Unreadable::CanXl } else { Unreadable::NoFrame }));
    }
    let (id, error) = identifier(id).map_err(|reason| Fail { reason, end: false })?;

    frame.id = id;
    match rest {
        [b'R' | b'r', rest @ ..] => remote(rest, frame).map_err(fail)?,
        [b'#', flags, rest @ ..] if nibble(*flags) < 16 => {
            // 4 only marks an FD frame.
            frame.kind = Kind::Fd { brs: nibble(*flags) & 1 != 0, esi: nibble(*flags) & 2 != 0 };
            if !data(rest, frame).map_err(fail)?.is_empty() {
                return Err(fail(Unreadable::Data));
            }
        }
        [b'#', ..] => return Err(fail(Unreadable::Data)),
        _ => {
            let rest = data(rest, frame).map_err(fail)?;
            raw_dlc(rest, frame).map_err(fail)?;
        }
    }
    if error {
        if frame.kind != Kind::Data {
            return Err(fail(Unreadable::Identifier));
        }
        frame.kind = Kind::Error;
    }

    let after = if frame.len == 1 && frame.kind == Kind::Data { separated(after, frame)? } else { after };
    let (tail, behind) = word(skip_blanks(after));
    match tail {
        b"T" => frame.dir = Some(Direction::Tx),
        b"R" => frame.dir = Some(Direction::Rx),
        // The data before it alone would be another frame.
        tail if is_stray_byte(tail) => return Err(Fail { reason: Unreadable::Data, end: false }),
        _ => return Ok(after),
    }
    Ok(behind)
}

/// Returns true if more digits at the end of a line would make another frame: `601#40` may be the beginning of eight
/// bytes.
pub(super) fn may_go_on(frame: &Frame) -> bool {
    match frame.kind {
        Kind::Data | Kind::Error => frame.len < 8,
        Kind::Fd { .. } => frame.len < 64,
        Kind::Remote => frame.len == 0,
    }
}

/// Parses the text after the `R` of `R`, `R4`, `R8_C`.
fn remote(text: &[u8], frame: &mut Frame) -> Result<(), Unreadable> {
    frame.kind = Kind::Remote;
    match text {
        [] => Ok(()),
        [digit, rest @ ..] => match nibble(*digit) {
            len @ 0..=8 => {
                frame.len = len;
                raw_dlc(rest, frame)
            }
            9..=15 => Err(Unreadable::Length),
            _ => Err(Unreadable::Data),
        },
    }
}

/// Parses the bytes after the first one if blanks separate them, as people write them; returns the rest. Words of
/// letters alone are a remark, and what follows bytes must not be another one.
fn separated<'a>(after: &'a [u8], frame: &mut Frame) -> Result<&'a [u8], Fail> {
    let fail = |reason, end| Err(Fail { reason, end });
    let words = after.split(|&byte| is_blank(byte)).filter(|word| !word.is_empty());
    let first = words.clone().next().unwrap_or_default();
    let mut bytes = words.take_while(|word| word.len() == 2 && is_hex(word));
    if !bytes.any(is_stray_byte) {
        // Half a byte.
        let half = first == after.trim_ascii() && matches!(first, [b'0'..=b'9' | b'A'..=b'F']);
        return if half { fail(Unreadable::Data, true) } else { Ok(after) };
    }
    let mut rest = after;
    loop {
        let (word, behind) = word(skip_blanks(rest));
        let value = if let &[high, low] = word { byte(high, low) } else { None };
        match value {
            Some(_) if frame.len == 8 => return fail(Unreadable::Length, false),
            Some(value) => {
                if let Some(slot) = frame.data.get_mut(usize::from(frame.len)) {
                    *slot = value;
                }
                frame.len += 1;
                rest = behind;
            }
            None if matches!(word, b"T" | b"R") || is_meant(word) => return Ok(rest),
            None if word.first().is_some_and(u8::is_ascii_alphanumeric) => {
                return fail(Unreadable::Data, behind.is_empty() && word.len() == 1);
            }
            None => return Ok(rest),
        }
    }
}

/// Parses bytes, each with an optional dot before it or all with colons between them, as far as possible; returns the
/// rest.
fn data<'a>(mut text: &'a [u8], frame: &mut Frame) -> Result<&'a [u8], Unreadable> {
    let limit = if matches!(frame.kind, Kind::Fd { .. }) { 64 } else { 8 };
    let colons = limit == 8 && text.get(2) == Some(&b':');
    let mut len = 0;
    loop {
        let pair = match text {
            [b':', rest @ ..] if colons && len > 0 && !rest.is_empty() => rest,
            [_, ..] if colons && len > 0 => break Ok(text),
            [b'.', rest @ ..] if !colons => rest,
            pair => pair,
        };
        let [high, low, rest @ ..] = pair else {
            break if pair.is_empty() { Ok(pair) } else { Err(Unreadable::Data) };
        };
        let Some(value) = byte(*high, *low) else { break Ok(pair) };
        if len == limit {
            break Err(Unreadable::Length);
        }
        if let Some(slot) = frame.data.get_mut(len) {
            *slot = value;
        }
        len += 1;
        frame.len = len as u8;
        text = rest;
    }
}

/// Parses `_C` after eight bytes: the real length code on the bus.
fn raw_dlc(text: &[u8], frame: &mut Frame) -> Result<(), Unreadable> {
    match text {
        [] => Ok(()),
        [b'_', code] if frame.len == 8 && (9..16).contains(&nibble(*code)) => {
            frame.length_form.raw_dlc = nibble(*code);
            Ok(())
        }
        [b'_', code] if nibble(*code) < 16 => Err(Unreadable::Length),
        _ => Err(Unreadable::Data),
    }
}

/// Returns true if the word can only be meant as a frame: hexadecimal digits before the first `#`.
#[inline(always)]
pub(super) fn is_meant(text: &[u8]) -> bool {
    let digits = text.iter().position(|&byte| nibble(byte) > 15).unwrap_or(0);
    digits > 0 && text.get(digits) == Some(&b'#')
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]

    use proptest::prelude::*;

    use super::super::general::{LineContent, general};
    use super::*;

    proptest! {
        // If the two paths differed, a comment at the end of a line would change its frame.
        #[test]
        fn plain_is_general(line in "(\\((0|1[0-9]{9})\\.[0-9]{1,7}\\)|\\(\\)) ?[!#a-z]{0,2}can[0-9]:{0,2} [0-9a-fA-F]{3}([0-9a-f]{5})?#([0-9A-Fa-f]{2}){0,9}[0-9a-gR]?") {
            for last in [&b""[..], b"can0"] {
                let Some((plain, b"")) = Plain::parse(line.as_bytes(), last) else { continue };
                let (bus, plain) = (plain.interface, plain.frame(BusId(0), 1, None));
                let line = general(line.as_bytes(), false);
                prop_assert_eq!(line.bus, bus.unwrap_or(last));
                let frame = line.frame;
                prop_assert!(matches!(line.what, LineContent::Frame));
                prop_assert_eq!((frame.id, frame.kind, frame.len, frame.data), (plain.id, plain.kind, plain.len, plain.data));
                prop_assert_eq!((line.stamp, frame.length_form, frame.dir), (plain.stamp, plain.length_form, plain.dir));
            }
        }
    }

    #[test]
    fn standard_identifiers_are_told_from_extended_ones() {
        let (Plain { id, interface, .. }, _) = Plain::parse(b"(0.5) can0 00000601#40", b"").unwrap();
        assert_eq!((id, interface), (CanId::extended(0x601), Some(&b"can0"[..])));
    }
}

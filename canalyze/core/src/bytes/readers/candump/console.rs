//! The wide family: candump's console output, and pastes of it.
//!
//! `(000.304418)  can0  TX B E  601   [8]  40 08 10 00 00 00 00 00   '@.......'`, where all but identifier, length and
//! data may be missing. It resembles prose more than the other family, so it is parsed strictly: exactly as many bytes
//! as the length says, all in one notation, or no frame.

use super::lex::{Fail, byte, identifier, is_blank, is_hex, is_stray_byte, nibble, skip_blanks, word};
use crate::bytes::frame::{Direction, Frame, Kind, LengthForm};
use crate::bytes::readers::Unreadable;
use crate::bytes::readers::listing::{self, Digits};

/// Returns true if the text is `ID [length]` or begins with a direction, without an interface before it.
pub(super) fn is_meant(text: &[u8]) -> bool {
    let (first, rest) = word(text);
    way(first).is_some() || is_hex(unprefixed(first)) && matches!(skip_blanks(rest), [b'[' | b'{', ..])
}

/// Parses a frame, from its direction or identifier on, into an empty one; returns the rest.
pub(super) fn frame<'a>(text: &'a [u8], frame: &mut Frame) -> Result<&'a [u8], Fail> {
    let (dir, flags, text) = direction(text);
    let (digits, rest) = word(text);
    let (digits, rest) = (unprefixed(digits), skip_blanks(rest));
    if rest.is_empty() {
        // Possibly cut inside or right after the identifier or the columns before it.
        let end = is_hex(digits) || matches!(digits, b"" | b"T" | b"TX" | b"R" | b"RX" | b"-" | b"B");
        return Err(Fail { reason: Unreadable::NoFrame, end });
    }
    if dir.is_some() && matches!(text, [b'-' | b'B', b' ', b'-' | b'E']) {
        return Err(Fail { reason: Unreadable::NoFrame, end: true });
    }
    if !is_hex(digits) || !matches!(rest, [b'[' | b'{', ..]) {
        return Err(Fail { reason: Unreadable::NoFrame, end: false });
    }
    let length = Length::read(rest);
    if let Err(Fail { reason: Unreadable::CanXl, .. }) = length {
        return Err(Fail { reason: Unreadable::CanXl, end: false });
    }
    let (id, error) = identifier(digits).map_err(|reason| Fail { reason, end: false })?;
    let (Length { len, form }, rest) = length?;

    frame.id = id;
    frame.dir = dir;
    frame.len = len;
    frame.length_form = form;
    frame.kind = match (error, form.two_digits) {
        (true, false) => Kind::Error,
        (true, true) => return Err(Fail { reason: Unreadable::Identifier, end: false }),
        (false, true) => Kind::Fd { brs: flags.0, esi: flags.1 },
        (false, false) => Kind::Data,
    };
    // Bytes are separated from the length by blanks; candump prints one even after an empty frame.
    if !rest.first().is_none_or(|&byte| is_blank(byte)) {
        return Err(Fail { reason: Unreadable::Length, end: false });
    }
    let rest = skip_blanks(rest);
    if let Some(after) = rest.strip_prefix(b"remote") {
        return remote(after, frame);
    }
    let after = data(rest, frame)?;
    if is_stray_byte(word(skip_blanks(after)).0) {
        return Err(Fail { reason: Unreadable::Length, end: false });
    }
    Ok(after)
}

/// Removes the prefix of an identifier written as `0x601`.
fn unprefixed(digits: &[u8]) -> &[u8] {
    match digits {
        [b'0', b'x' | b'X', rest @ ..] => rest,
        _ => digits,
    }
}

/// Returns the form of the bytes after `ID [length]`, if the line shows it.
pub(super) fn digits(text: &[u8]) -> Option<Digits> {
    let at = memchr::memchr(b'[', text)?;
    let [count @ b'1'..=b'8', b']', rest @ ..] = text.get(at + 1..)? else { return None };
    let bytes = rest.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    listing::digits(bytes.take(usize::from(count - b'0')))
}

/// Parses `TX` and `RX` of candump, and as people write them: `Rx`, `rx:`.
#[inline(always)]
pub(super) fn way(word: &[u8]) -> Option<Direction> {
    match word {
        [b'T' | b't', b'X' | b'x'] | [b'T' | b't', b'X' | b'x', b':'] => Some(Direction::Tx),
        [b'R' | b'r', b'X' | b'x'] | [b'R' | b'r', b'X' | b'x', b':'] => Some(Direction::Rx),
        _ => None,
    }
}

/// Parses `TX - -`, `RX B E`: direction, bit rate switch, error state. The flags may be missing, since people cut them
/// off.
#[inline(always)]
fn direction(text: &[u8]) -> (Option<Direction>, (bool, bool), &[u8]) {
    let (dir, rest) = match text {
        [b'T' | b't' | b'R' | b'r', b'X' | b'x', ..] => {
            let (first, rest) = word(text);
            match way(first).filter(|_| !rest.is_empty()) {
                Some(dir) => (dir, rest),
                None => return (None, (false, false), text),
            }
        }
        _ => return (None, (false, false), text),
    };
    let rest = skip_blanks(rest);
    match rest {
        [brs @ (b'-' | b'B'), b' ', esi @ (b'-' | b'E'), b' ' | b'\t', rest @ ..] => {
            (Some(dir), (*brs == b'B', *esi == b'E'), skip_blanks(rest))
        }
        _ => (Some(dir), (false, false), rest),
    }
}

struct Length {
    len: u8,
    form: LengthForm,
}

impl Length {
    /// Parses `[8]`, `[08]` of FD, `[0064]` of XL, `{8}` and `{C}` of option `-8`; returns the rest as well.
    ///
    /// Two digits may be any length up to 64: people paste `[10]`, which no FD frame can have.
    #[inline(always)]
    fn read(text: &[u8]) -> Result<(Self, &[u8]), Fail> {
        let fail = |reason| Err(Fail { reason, end: false });
        let mut form = LengthForm::default();
        let (len, rest) = match text {
            [b'[', n @ b'0'..=b'8', b']', rest @ ..] => (n - b'0', rest),
            [b'[', tens @ b'0'..=b'9', ones @ b'0'..=b'9', b']', rest @ ..] => {
                form.two_digits = true;
                let len = (tens - b'0') * 10 + (ones - b'0');
                if len > 64 {
                    return fail(Unreadable::Length);
                }
                (len, rest)
            }
            [b'[', a, b, c, d, b']', ..] if [a, b, c, d].iter().all(|digit| digit.is_ascii_digit()) => {
                return fail(Unreadable::CanXl);
            }
            [b'{', code, b'}', rest @ ..] if nibble(*code) < 16 => {
                form.braces = true;
                let code = nibble(*code);
                form.raw_dlc = if code > 8 { code } else { 0 };
                (code.min(8), rest)
            }
            _ => {
                let end = text.len() < 6 && text.iter().skip(1).all(u8::is_ascii_hexdigit);
                return Err(Fail { reason: Unreadable::Length, end });
            }
        };
        Ok((Self { len, form }, rest))
    }
}

/// Parses the text after the word `remote`.
fn remote<'a>(text: &'a [u8], frame: &mut Frame) -> Result<&'a [u8], Fail> {
    let full = b" request";
    if text.len() < full.len() && full.starts_with(text) {
        return Err(Fail { reason: Unreadable::Data, end: true });
    }
    let after = text.strip_prefix(full).filter(|rest| !rest.first().is_some_and(u8::is_ascii_alphanumeric));
    let after = after.filter(|_| frame.kind == Kind::Data).ok_or(Fail { reason: Unreadable::Data, end: false })?;
    frame.kind = Kind::Remote;
    Ok(after)
}

/// Parses exactly `frame.len` bytes in one of the four notations; returns the rest.
#[inline(always)]
fn data<'a>(text: &'a [u8], frame: &mut Frame) -> Result<&'a [u8], Fail> {
    let len = usize::from(frame.len);
    if len == 0 {
        return Ok(text);
    }
    if let Some(rest) = plain(text, frame.data.get_mut(..len).unwrap_or_default()) {
        return Ok(rest);
    }
    let (first, _) = word(text);
    // Option -i prints eight digits for a byte; -S prints a back-tick between bytes.
    let binary = first.len() >= 8 && first.iter().take(8).all(|digit| matches!(digit, b'0' | b'1'));
    let width = if binary { 8 } else { 2 };
    let swapped = first.get(width) == Some(&b'`');
    // People use other separators.
    let mark = first.get(2).copied().filter(|mark| !binary && matches!(mark, b'.' | b':' | b'-' | b','));

    let mut text = text;
    let mut first = true;
    for slot in frame.data.iter_mut().take(len) {
        if !first {
            text = match text {
                [b'`', rest @ ..] if swapped => rest,
                [found, rest @ ..] if mark == Some(*found) => rest,
                rest if mark.is_some() => return Err(Fail { reason: Unreadable::Data, end: rest.is_empty() }),
                [b' ' | b'\t', rest @ ..] if !swapped => skip_blanks(rest),
                rest => return Err(Fail { reason: Unreadable::Data, end: rest.is_empty() }),
            };
        }
        first = false;
        (*slot, text) = if binary { bits(text)? } else { hex(text)? };
    }
    if text.first().is_some_and(|&byte| byte.is_ascii_alphanumeric() || matches!(byte, b'`' | b'.')) {
        return Err(Fail { reason: Unreadable::Data, end: false });
    }
    if swapped && let Some(bytes) = frame.data.get_mut(..len) {
        bytes.reverse();
    }
    Ok(text)
}

/// Parses bytes as candump prints them without options: two digits and one blank. Anything else is left to `data`.
#[inline(always)]
fn plain<'a>(text: &'a [u8], slots: &mut [u8]) -> Option<&'a [u8]> {
    let (bytes, rest) = text.split_at_checked(3 * slots.len() - 1)?;
    if !rest.first().is_none_or(|&byte| is_blank(byte)) {
        return None;
    }
    let (triples, last) = bytes.as_chunks::<3>();
    let [high, low] = last else { return None };
    let (last, slots) = slots.split_last_mut()?;
    let mut check = nibble(*high) | nibble(*low);
    *last = nibble(*high) << 4 | nibble(*low) & 0xF;
    for (slot, &[high, low, blank]) in slots.iter_mut().zip(triples) {
        check |= nibble(high) | nibble(low) | if blank == b' ' { 0 } else { 0xFF };
        *slot = nibble(high) << 4 | nibble(low) & 0xF;
    }
    (check < 16).then_some(rest)
}

#[inline(always)]
fn hex(text: &[u8]) -> Result<(u8, &[u8]), Fail> {
    match text {
        [high, low, rest @ ..] => match byte(*high, *low) {
            Some(value) => Ok((value, rest)),
            None => Err(Fail { reason: Unreadable::Data, end: false }),
        },
        rest => Err(Fail { reason: Unreadable::Data, end: rest.iter().all(|&digit| nibble(digit) < 16) }),
    }
}

fn bits(text: &[u8]) -> Result<(u8, &[u8]), Fail> {
    let mut value = 0;
    let mut rest = text;
    for _ in 0..8 {
        rest = match rest {
            [bit @ (b'0' | b'1'), rest @ ..] => {
                value = value << 1 | (bit - b'0');
                rest
            }
            rest => return Err(Fail { reason: Unreadable::Data, end: rest.is_empty() }),
        };
    }
    Ok((value, rest))
}

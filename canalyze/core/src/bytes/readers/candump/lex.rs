//! The smallest pieces of a candump line: blanks, words, hexadecimal digits, identifiers.
//!
//! Both families of lines consist of them and have to agree on identifiers. Nothing here allocates or looks beyond its
//! piece.

use crate::bytes::frame::CanId;
use crate::bytes::readers::Unreadable;

/// Values of hexadecimal digits; 0xFF for every other byte, so that digits can be checked by OR-ing them.
static HEX: [u8; 256] = table();

#[allow(clippy::indexing_slicing)] // run by the compiler: an index out of range would not build
const fn table() -> [u8; 256] {
    let mut table = [0xFF; 256];
    let mut digit = 0;
    while digit < 16 {
        table[b"0123456789ABCDEF"[digit] as usize] = digit as u8;
        table[b"0123456789abcdef"[digit] as usize] = digit as u8;
        digit += 1;
    }
    table
}

/// The reason why a line is not a frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fail {
    pub(super) reason: Unreadable,
    /// True if nothing was wrong up to the end of the line, so that more text could have made it a frame.
    pub(super) end: bool,
}

/// Returns the value of a hexadecimal digit; above 15 for other bytes.
#[inline(always)]
pub(in crate::bytes::readers) fn nibble(byte: u8) -> u8 {
    HEX.get(usize::from(byte)).copied().unwrap_or(0xFF)
}

/// Returns the byte of two hexadecimal digits.
#[inline(always)]
pub(in crate::bytes::readers) fn byte(high: u8, low: u8) -> Option<u8> {
    let (high, low) = (nibble(high), nibble(low));
    (high | low < 16).then_some(high << 4 | low & 0xF)
}

/// Returns the number of hexadecimal digits that a text begins with, and the bytes of its pairs of digits, the first one
/// lowest. All are computed at once within two numbers: every frame has some.
#[inline(always)]
pub(in crate::bytes::readers) fn pairs(text: [u8; 16]) -> (u32, u64) {
    const ONE: u64 = 0x0101_0101_0101_0101;
    let text = u128::from_le_bytes(text);
    let half = |word: u64| {
        // Letters have bit 6, and bit 5 if they are small.
        let letter = word >> 6 & ONE;
        let word = word & !(letter << 5);
        let value = (word & (0x0F * ONE)) + 9 * letter;
        // A digit is what its value is written as; other bytes are not, or have a value above 15.
        let above_nine = (value + 6 * ONE) >> 4 & ONE;
        let wrong = (value + 0x30 * ONE + 7 * above_nine) ^ word | value & (0xF0 * ONE);
        // Pairs, then two and four of them.
        let two = (value << 4 | value >> 8) & 0x00FF_00FF_00FF_00FF;
        let four = (two | two >> 8) & 0x0000_FFFF_0000_FFFF;
        (wrong.trailing_zeros() / 8, u64::from((four | four >> 16) as u32))
    };
    let ((low, bytes), (high, more)) = (half(text as u64), half((text >> 64) as u64));
    let digits = if low < 8 { low } else { 8 + high };
    let unused = 64 - 8 * (digits / 2);
    let bytes = bytes | more << 32;
    (digits, if unused < 64 { bytes << unused >> unused } else { 0 })
}

#[inline(always)]
pub(in crate::bytes::readers) fn is_blank(byte: u8) -> bool {
    byte == b' ' || byte == b'\t'
}

/// Returns the text after leading blanks.
#[inline(always)]
pub(in crate::bytes::readers) fn skip_blanks(mut text: &[u8]) -> &[u8] {
    while let [first, rest @ ..] = text {
        if !is_blank(*first) {
            break;
        }
        text = rest;
    }
    text
}

/// Returns the first word and the rest, which begins with a blank or is empty.
#[inline(always)]
pub(in crate::bytes::readers) fn word(text: &[u8]) -> (&[u8], &[u8]) {
    let end = text.iter().position(|&byte| is_blank(byte)).unwrap_or(text.len());
    text.split_at_checked(end).unwrap_or((text, &[]))
}

/// Returns true if the word could name an interface. Comment marks, quotes and arrows cannot.
#[inline(always)]
pub(in crate::bytes::readers) fn is_name(word: &[u8]) -> bool {
    word.first().is_some_and(u8::is_ascii_alphanumeric)
        && word.len() <= crate::bytes::frame::MAX_BUS_NAME
        && word.iter().all(|&byte| byte.is_ascii_graphic() && byte != b'#')
}

/// Returns true if the word consists of one or more hexadecimal digits.
pub(in crate::bytes::readers) fn is_hex(word: &[u8]) -> bool {
    !word.is_empty() && word.iter().all(|&byte| nibble(byte) < 16)
}

/// Returns true if the word after the data is another data byte and not a comment. `be`, `ad` and `de` are words, too.
pub(in crate::bytes::readers) fn is_stray_byte(word: &[u8]) -> bool {
    word.len() == 2 && is_hex(word) && !word.iter().all(u8::is_ascii_lowercase)
}

/// Parses an identifier; also returns true if it is that of an error frame.
///
/// Three digits are a standard identifier, eight an extended one or an error class with its flag. Other flags of
/// SocketCAN are never printed, so any other high bit is damage.
#[inline(always)]
pub(in crate::bytes::readers) fn identifier(word: &[u8]) -> Result<(CanId, bool), Unreadable> {
    const ERROR: u32 = 0x2000_0000;
    let mut value = 0u32;
    let mut check = 0;
    for &digit in word.iter().take(8) {
        let digit = nibble(digit);
        check |= digit;
        value = value << 4 | u32::from(digit & 0xF);
    }
    if check > 15 {
        return Err(Unreadable::NoFrame);
    }
    match word.len() {
        3 if value <= 0x7FF => Ok((CanId::standard(value as u16), false)),
        8 if value < ERROR => Ok((CanId::extended(value), false)),
        8 if value < 2 * ERROR => Ok((CanId::extended(value), true)),
        0 => Err(Unreadable::NoFrame),
        _ => Err(Unreadable::Identifier),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::indexing_slicing)]

    use super::*;

    /// Returns what [`pairs`] returns, digit by digit.
    fn one_by_one(text: [u8; 16]) -> (u32, u64) {
        let digits = text.iter().take_while(|byte| nibble(**byte) < 16).count();
        let bytes = text[..digits].as_chunks::<2>().0.iter().map(|[high, low]| nibble(*high) << 4 | nibble(*low));
        (digits as u32, bytes.rev().fold(0, |all, byte| all << 8 | u64::from(byte)))
    }

    #[test]
    fn every_byte_in_every_place() {
        for digits in [*b"0123456789ABCDEF", *b"fedcba9876543210", *b"0000000000000000", *b"ffffffffffffffff"] {
            for (place, byte) in (0..16).flat_map(|place| (0..=255).map(move |byte| (place, byte))) {
                let mut text = digits;
                text[place] = byte;
                assert_eq!(pairs(text), one_by_one(text), "{:?}", text.escape_ascii().to_string());
                // What is behind it does not matter.
                text[place..].fill(byte);
                assert_eq!(pairs(text), one_by_one(text), "{:?}", text.escape_ascii().to_string());
            }
        }
    }
}

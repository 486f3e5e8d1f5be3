//! The words of a line, the numbers in them, and the reasons why a line is not a frame.

use crate::bytes::frame::{CanId, Direction, Stamp, StampForm};
use crate::bytes::ns::Ns;
use crate::bytes::readers::Unreadable;
use crate::bytes::readers::candump::lex::{byte, nibble, skip_blanks, word};
use crate::bytes::readers::candump::stamp::{digits, fraction, nanoseconds};

/// The reason why a line is not a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Fail {
    pub(super) reason: Unreadable,
    /// True if nothing before the last word was wrong, so that more text could have made it a frame.
    pub(super) end: bool,
}

/// An iterator over the words of a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct LineWords<'a> {
    last: &'a [u8],
    rest: &'a [u8],
}

impl<'a> LineWords<'a> {
    pub(super) fn new(text: &'a [u8]) -> Self {
        Self { last: b"", rest: skip_blanks(text) }
    }

    pub(super) fn next(&mut self) -> Option<&'a [u8]> {
        let (first, rest) = word(self.rest);
        self.last = first;
        self.rest = skip_blanks(rest);
        (!first.is_empty()).then_some(first)
    }

    /// Returns the last word taken; empty before the first one.
    pub(super) fn last(&self) -> &'a [u8] {
        self.last
    }

    /// Returns the next word without taking it.
    pub(super) fn peek(&self) -> &'a [u8] {
        word(self.rest).0
    }

    /// Returns the text after the last word taken.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.rest
    }

    /// Returns true if all words are taken.
    pub(super) fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }

    /// Fails because the last word taken is wrong or missing.
    pub(super) fn fail<T>(&self, reason: Unreadable) -> Result<T, Fail> {
        Err(Fail { reason, end: self.is_empty() })
    }

    /// Takes the next word, or fails.
    pub(super) fn need(&mut self, reason: Unreadable) -> Result<&'a [u8], Fail> {
        match self.next() {
            Some(word) => Ok(word),
            None => self.fail(reason),
        }
    }
}

/// Parses `12.345678` at the end or before a blank; returns the rest as well.
#[inline(always)]
pub(super) fn stamp(text: &[u8]) -> Option<(Stamp, &[u8])> {
    let (negative, rest) = match text {
        [b'-', rest @ ..] => (true, rest),
        _ => (false, text),
    };
    let (whole, width, rest) = digits(rest);
    let (fraction, decimals, rest) = fraction(rest.strip_prefix(b".")?)?;
    if !(1..=20).contains(&width) || !matches!(rest, [] | [b' ' | b'\t', ..]) {
        return None;
    }
    let ns = nanoseconds(i64::try_from(whole).unwrap_or(i64::MAX), fraction);
    let ns = if negative { -ns } else { ns };
    Some((Stamp { form: StampForm::Seconds, ns: Ns(ns), width: width as u8, decimals }, rest))
}

/// The meaning of a word in the column of directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// A frame on the bus.
    Frame(Direction),
    /// A request to send; the frame follows when it is on the bus.
    Request,
}

pub(super) fn way(word: &[u8]) -> Option<Way> {
    let is = |name: &[u8]| word.eq_ignore_ascii_case(name);
    match word.len() {
        2 if is(b"rx") => Some(Way::Frame(Direction::Rx)),
        2 if is(b"tx") => Some(Way::Frame(Direction::Tx)),
        4 if is(b"txrq") => Some(Way::Request),
        _ => None,
    }
}

/// Parses a whole word as a number of base 10 or 16, with at most ten digits.
pub(super) fn number(word: &[u8], decimal: bool) -> Option<u64> {
    if !(1..=10).contains(&word.len()) {
        return None;
    }
    let limit = if decimal { 10 } else { 16 };
    let mut value = 0u64;
    for digit in word {
        let digit = nibble(*digit);
        if digit >= limit {
            return None;
        }
        value = value * u64::from(limit) + u64::from(digit);
    }
    Some(value)
}

/// Parses `601` or `18EBFF00x`. [`Unreadable::NoFrame`] if it is not a number.
pub(super) fn identifier(word: &[u8], decimal: bool) -> Result<CanId, Unreadable> {
    let digits = word.strip_suffix(b"x").or_else(|| word.strip_suffix(b"X"));
    let value = number(digits.unwrap_or(word), decimal).ok_or(Unreadable::NoFrame)?;
    match (digits, value) {
        (None, 0..=0x7FF) => Ok(CanId::standard(value as u16)),
        (Some(_), 0..=0x1FFF_FFFF) => Ok(CanId::extended(value as u32)),
        _ => Err(Unreadable::Identifier),
    }
}

/// Parses a data byte: two hexadecimal or one to three decimal digits.
pub(super) fn data_byte(word: &[u8], decimal: bool) -> Option<u8> {
    match word {
        [high, low] if !decimal => byte(*high, *low),
        [_] | [_, _] | [_, _, _] if decimal => number(word, true).and_then(|value| u8::try_from(value).ok()),
        _ => None,
    }
}

/// Returns the data length of a length code of CAN FD.
pub(super) fn fd_length(code: u64) -> Option<u64> {
    const LENGTHS: [u64; 7] = [12, 16, 20, 24, 32, 48, 64];
    match code {
        0..=8 => Some(code),
        _ => LENGTHS.get(usize::try_from(code - 9).ok()?).copied(),
    }
}

/// Returns the smallest length code of CAN FD that holds `len` bytes.
pub(crate) fn fd_code(len: u64) -> u64 {
    (0..15).find(|code| fd_length(*code).is_some_and(|limit| len <= limit)).unwrap_or(15)
}

/// Returns true if a CAN FD frame can have this length.
pub(super) fn is_fd_length(len: u64) -> bool {
    (0..16).any(|code| fd_length(code) == Some(len))
}

//! Detection of decimal numbers in a file without a header.
//!
//! A piece of a log lacks the line with the base, and 385 is another identifier in hexadecimal. Hexadecimal bytes
//! always have two digits, decimal ones no leading zero: the first line that fits only one base decides. A header takes
//! precedence.

use super::words::stamp;
use crate::bytes::readers::candump::lex::{is_hex, skip_blanks};
use crate::bytes::readers::listing::{self, Base, Digits};

/// Maximum number of bytes held back.
const MOST: usize = 64 * 1024;

/// The beginning of a file.
#[derive(Debug, Default)]
pub(super) struct AscHead {
    held: Vec<u8>,
    /// Number of examined bytes, in whole lines.
    looked: usize,
    base: Base,
    over: bool,
}

impl AscHead {
    /// Returns true while it is held back.
    pub(super) fn is_open(&self) -> bool {
        !self.over
    }

    /// Feeds the next bytes. Returns all of them once the base is known, and true if it is 10.
    pub(super) fn feed(&mut self, bytes: &[u8]) -> Option<(Vec<u8>, bool)> {
        self.held.extend_from_slice(bytes);
        while let Some(rest) = self.held.get(self.looked..)
            && let Some(end) = memchr::memchr(b'\n', rest)
        {
            let row = of(rest.get(..end).unwrap_or_default());
            self.looked += end + 1;
            if let Some(decimal) = row.and_then(|row| self.base.take(row)) {
                return self.give(decimal);
            }
            if self.looked >= MOST {
                return self.give(false);
            }
        }
        // Too long for a line.
        (self.held.len() >= 2 * MOST).then(|| self.give(false)).flatten()
    }

    /// Ends the input and returns the bytes held back.
    pub(super) fn finish(&mut self) -> Option<(Vec<u8>, bool)> {
        if self.over {
            return None;
        }
        let row = of(self.held.get(self.looked..).unwrap_or_default());
        let decimal = row.and_then(|row| self.base.take(row));
        self.give(decimal == Some(true))
    }

    fn give(&mut self, decimal: bool) -> Option<(Vec<u8>, bool)> {
        self.over = true;
        Some((std::mem::take(&mut self.held), decimal))
    }
}

/// Returns the form of a line's numbers, if it shows one. A header line is left to the header.
fn of(line: &[u8]) -> Option<Digits> {
    let line = listing::unmarked(listing::unquoted(skip_blanks(line.trim_ascii_end())));
    let Some((_, rest)) = stamp(line) else {
        let header = line.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"base "));
        return header.then_some(Digits::Hexadecimal);
    };
    let mut words = rest.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    if !words.next()?.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let id = words.next()?;
    let id = id.strip_suffix(b"x").unwrap_or(id);
    if is_hex(id) && id.iter().any(u8::is_ascii_alphabetic) {
        return Some(Digits::Hexadecimal);
    }
    words.find(|word| *word == b"d")?;
    let count = std::str::from_utf8(words.next()?).ok()?.parse().ok().filter(|count| *count <= 8)?;
    listing::digits(words.take(count))
}

#[cfg(test)]
mod tests {
    use super::{Digits, of};

    #[test]
    fn lines_tell_their_base() {
        for (line, digits) in [
            ("0.1 1 385 Rx d 4 55 2 16 0", Some(Digits::Single)),
            ("0.1 1 385 Rx d 2 55 146", Some(Digits::Decimal)),
            ("> 0.1 1 385x Name Tx d 1 155", Some(Digits::Decimal)),
            ("0.1 1 385 Rx d 4 55 12 16 10", None),
            ("0.1 1 385 Rx d 4 55 02 16 1", Some(Digits::Hexadecimal)),
            ("0.1 1 385 Rx d 2 55 A2  Length = 100", Some(Digits::Hexadecimal)),
            ("0.1 1 385 Rx d 2 55 12  Length = 100", None),
            ("0.1 1 58A Rx d 1 55", Some(Digits::Hexadecimal)),
            ("0.1 1 385 Rx r 8", None),
            ("0.1 CAN 1 Status:chip status error active", None),
            ("base dec timestamps absolute", Some(Digits::Hexadecimal)),
            ("date Tue Nov 14 10:13:20.123 pm 2023", None),
            ("0.1 1 Statistic: D 1 R 0 XD 0 XR 0 E 0 O 0 B 0.10%", None),
        ] {
            assert_eq!(of(line.as_bytes()), digits, "{line}");
        }
    }
}

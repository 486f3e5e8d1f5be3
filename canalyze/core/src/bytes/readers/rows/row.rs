//! One row: what its cells say of a frame.

use super::columns::Column::{self, Attribute, Channel, Data, Extended, Id, Length, Other, Ticks, Time};
use super::columns::{MICROSECOND, MILLISECOND, SECOND};
use super::times::{number, time};
use crate::bytes::frame::{Direction, Stamp, StampForm};
use crate::bytes::readers::candump::lex::{byte, is_blank, is_hex, nibble};
use crate::bytes::readers::listing;

/// Maximum number of bytes of a frame, and of a classic one.
const BYTES: usize = 64;
pub(super) const CLASSIC: usize = 8;
/// Lengths of CAN FD frames beyond those of classic ones, in bytes.
const LONGER: [usize; 7] = [12, 16, 20, 24, 32, 48, 64];

/// The parts of a row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row<'a> {
    pub(super) stamp: Option<Stamp>,
    pub(super) id: Option<(u32, usize)>,
    pub(super) direction: Option<Direction>,
    pub(super) length: Option<usize>,
    pub(super) data: [u8; BYTES],
    pub(super) count: usize,
    pub(super) extended: Option<bool>,
    pub(super) remote: bool,
    pub(super) error: bool,
    /// CAN FD: bit rate switch, error state indicator.
    pub(super) fd: Option<(bool, bool)>,
    /// The channel as written, and the number of the first one.
    pub(super) channel: &'a [u8],
    pub(super) first: u8,
    /// Bytes are decimal, and identifiers unless the heading says what each is.
    pub(super) decimal: bool,
    pub(super) told: bool,
}

impl Default for Row<'_> {
    fn default() -> Self {
        Self {
            stamp: None,
            id: None,
            direction: None,
            length: None,
            data: [0; BYTES],
            count: 0,
            extended: None,
            remote: false,
            error: false,
            fd: None,
            channel: b"",
            first: 0,
            decimal: false,
            told: false,
        }
    }
}

impl<'a> Row<'a> {
    /// Takes the cell of a column; `None` if it cannot be one.
    pub(super) fn take(&mut self, column: Column, cell: &'a [u8]) -> Option<()> {
        match column {
            // A time that cannot be read is none, and the frame is there.
            // A number with a point is one of seconds, whatever programs count whole ones in.
            Time(MICROSECOND) if cell.contains(&b'.') => self.stamp = time(cell, SECOND),
            Time(unit) => self.stamp = time(cell, unit),
            Ticks if !cell.starts_with(b"0x") => self.stamp = time(cell, SECOND),
            Ticks => {
                let ticks = number(cell, 16);
                let ns = |ticks| i64::from(ticks) * (MILLISECOND / 10);
                self.stamp =
                    ticks.map(|ticks| Stamp { form: StampForm::Seconds, ns: ns(ticks), width: 1, decimals: 4 });
            }
            Id(base) => {
                let inner = cell.strip_prefix(b"(").and_then(|cell| cell.strip_suffix(b")"));
                let hex = cell.split(|byte| *byte == b'(').nth(1).and_then(|cell| cell.strip_suffix(b")"));
                let cell = inner.or(hex).unwrap_or(cell);
                let (word, extended) = match cell {
                    [word @ .., b'x' | b'X'] if word.len() >= 3 => (word, Some(true)),
                    [word @ .., b'h' | b'H' | b':'] => (word, None),
                    _ => (cell, None),
                };
                self.extended = self.extended.or(extended);
                let digits = word.strip_prefix(b"0x").or_else(|| word.strip_prefix(b"0X")).unwrap_or(word);
                let base = if self.decimal && !self.told { 10 } else { base };
                self.id = Some((number(word, base)?, if base == 16 { digits.len() } else { 0 }));
            }
            Column::Direction => self.direction = direction(cell),
            Length if cell.is_empty() => {}
            Length => self.length = Some(number(cell, 10).filter(|length| *length <= 64)? as usize),
            Data => {
                let between = |byte: &u8| is_blank(*byte) || matches!(byte, b',' | b'-' | b':' | b'|');
                for part in cell.split(between).filter(|part| !part.is_empty()) {
                    self.bytes(part)?;
                }
            }
            Column::Byte if cell.is_empty() => {}
            Column::Byte => self.bytes(cell)?,
            Attribute => self.attribute(cell),
            Extended => {
                let words: [&[u8]; 3] = [b"true", b"ext", b"extended"];
                let said = words.iter().any(|word| cell.eq_ignore_ascii_case(word));
                self.extended = Some(said || matches!(cell, b"1" | b"x" | b"X"));
            }
            Column::Number if !self.channel.is_empty() => {}
            Column::Number => (self.channel, self.first) = (cell, 1),
            Channel(first) => (self.channel, self.first) = (cell, first),
            Other => {}
        }
        Some(())
    }

    /// Adds bytes: two digits each, or one digit.
    pub(super) fn bytes(&mut self, text: &[u8]) -> Option<()> {
        let text = text.strip_prefix(b"0x").unwrap_or(text);
        if self.decimal {
            let byte = u8::try_from(number(text, 10)?).ok()?;
            *self.data.get_mut(self.count)? = byte;
            self.count += 1;
            return Some(());
        }
        let pairs: Vec<u8> = match text {
            [digit] => vec![Some(nibble(*digit)).filter(|digit| *digit < 16)?],
            _ if text.len().is_multiple_of(2) => {
                let pair = |pair: &[u8]| byte(*pair.first()?, *pair.get(1)?);
                text.chunks(2).map(pair).collect::<Option<_>>()?
            }
            _ => return None,
        };
        for byte in pairs {
            *self.data.get_mut(self.count)? = byte;
            self.count += 1;
        }
        Some(())
    }

    fn attribute(&mut self, cell: &[u8]) {
        let word = String::from_utf8_lossy(cell).to_lowercase();
        match word.as_str() {
            "true" | "ext" | "extended" | "extended frame" | "x" | "扩展帧" | "扩展" => self.extended = Some(true),
            "false" | "std" | "standard" | "standard frame" | "s" | "标准帧" | "标准" => {
                self.extended = Some(false)
            }
            "can fd frame" | "canfd" | "canfd加速" | "can fd" | "fd" => {
                self.fd = Some((word.ends_with("加速"), false));
            }
            "error" | "error frame" | "errorframe" | "错误帧" | "错误" => self.error = true,
            "远程帧" | "远程" | "remote" | "rtr" | "r" => self.remote = true,
            _ => {}
        }
    }

    /// Returns the row if it is one: it has an identifier, and as many bytes as it says.
    pub(super) fn whole(self) -> Option<Self> {
        let fits = self.length.is_none_or(|length| self.remote || self.error || length == self.count);
        // Without a listed length many bytes may be a dump of something else.
        let long = self.count <= CLASSIC || LONGER.contains(&self.count) && self.length.is_some();
        (self.id.is_some() && fits && long).then_some(self)
    }
}

/// Parses a length: `8`, `[8]`, `DLC=8`.
pub(super) fn length(word: &[u8]) -> Option<usize> {
    let inner = word.strip_prefix(b"[").and_then(|word| word.strip_suffix(b"]"));
    let named = word.strip_prefix(b"DLC=").or_else(|| word.strip_prefix(b"DLC:"));
    match inner.or(named).unwrap_or(word) {
        [digit @ b'0'..=b'8'] => Some(usize::from(digit - b'0')),
        // Of CAN FD.
        digits => LONGER.into_iter().find(|length| number(digits, 10) == Some(*length as u32) && digits.len() == 2),
    }
}

/// Returns true if a word has the form of an identifier: three or eight hexadecimal digits, or a prefix.
pub(super) fn identifier(word: &[u8]) -> bool {
    let prefixed = word.strip_prefix(b"0x").or_else(|| word.strip_prefix(b"0X"));
    let digits = prefixed.unwrap_or(word);
    let digits = digits.strip_suffix(b":").unwrap_or(digits);
    let digits = digits.strip_suffix(b"h").or_else(|| digits.strip_suffix(b"x")).unwrap_or(digits);
    let prefixed = prefixed.or((digits.len() < word.len()).then_some(digits));
    let padded = digits.len() == 4 && digits.starts_with(b"0");
    let long = padded || matches!(digits.len(), 3 | 8) || prefixed.is_some() && (1..=8).contains(&digits.len());
    long && is_hex(digits)
}

/// Parses the cell of a direction: a word, or its first letter.
pub(super) fn direction(cell: &[u8]) -> Option<Direction> {
    match cell {
        b"R" => Some(Direction::Rx),
        b"T" => Some(Direction::Tx),
        _ => listing::direction(cell),
    }
}

/// Returns the name of the bus of a channel; channels are counted from `first`.
pub(super) fn channel(cell: &[u8], first: u8) -> &[u8] {
    const BUSES: [&[u8]; 10] =
        [b"can0", b"can1", b"can2", b"can3", b"can4", b"can5", b"can6", b"can7", b"can8", b"can9"];
    let (digit, first) = match cell {
        [b'C' | b'c', b'A' | b'a', b'N' | b'n', digit] => (&[*digit][..], 0),
        [b'C', b'A', b'N', b' ', digit] => (&[*digit][..], 1),
        _ => (cell.strip_prefix(b"ch").unwrap_or(cell), first),
    };
    let number = match digit {
        [digit @ b'0'..=b'9'] => (digit - b'0').checked_sub(first),
        _ => None,
    };
    number.and_then(|number| BUSES.get(usize::from(number))).copied().unwrap_or(cell)
}

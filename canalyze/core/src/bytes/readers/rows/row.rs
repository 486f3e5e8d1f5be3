//! One row: what its cells say of a frame.

use std::iter::Peekable;

use super::columns::Column::{self, Attribute, Channel, Data, Extended, Id, Length, Other, Part, Remote, Ticks, Time};
use super::columns::{MICROSECOND, SECOND};
use super::times::{number, time, unprefixed};
use crate::bytes::frame::{Direction, Stamp, StampForm};
use crate::bytes::ns::Ns;
use crate::bytes::readers::candump::lex::{byte, is_blank, is_hex, nibble};
use crate::bytes::readers::listing;

/// Maximum number of bytes of a frame, and of a classic one.
const BYTES: usize = 64;
pub(super) const CLASSIC: usize = 8;
/// Lengths of CAN FD frames beyond those of classic ones, in bytes.
pub(super) const LONGER: [usize; 7] = [12, 16, 20, 24, 32, 48, 64];

/// The parts of a row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row<'a> {
    pub(super) stamp: Option<Stamp>,
    pub(super) id: Option<(u32, usize)>,
    pub(super) direction: Option<Direction>,
    pub(super) length: Option<usize>,
    /// The code of the length, if it is listed, too.
    pub(super) code: Option<usize>,
    pub(super) data: [u8; BYTES],
    pub(super) count: usize,
    pub(super) extended: Option<bool>,
    pub(super) remote: bool,
    pub(super) error: bool,
    /// CAN FD: bit rate switch, error state indicator.
    pub(super) fd: Option<(bool, bool)>,
    /// The time after which the clock of the stamp begins again; 0 if it does not.
    pub(super) wraps_ns: Ns,
    /// The end of the row in its line, if text may follow; 0 for the whole line.
    pub(super) end: usize,
    /// The channel as written, and the number of the first one.
    pub(super) channel: &'a [u8],
    pub(super) first: u8,
    /// Bytes are decimal.
    pub(super) decimal: bool,
}

impl Default for Row<'_> {
    fn default() -> Self {
        Self {
            stamp: None,
            id: None,
            direction: None,
            length: None,
            code: None,
            data: [0; BYTES],
            count: 0,
            extended: None,
            remote: false,
            error: false,
            fd: None,
            wraps_ns: Ns::ZERO,
            end: 0,
            channel: b"",
            first: 0,
            decimal: false,
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
                let ns = |ticks| Ns::from_us(i64::from(ticks) * 100);
                self.stamp =
                    ticks.map(|ticks| Stamp { form: StampForm::Seconds, ns: ns(ticks), width: 1, decimals: 4 });
            }
            Id(base) => {
                let (digits, hex, extended) = id_digits(cell);
                self.extended = self.extended.or(extended);
                let base = if base == 10 && !hex { 10 } else { 16 };
                self.id = Some((number(digits, base)?, if base == 16 { digits.len() } else { 0 }));
            }
            Column::Direction => self.direction = side(cell),
            Column::Sent => self.direction = sent(cell),
            Length if cell.is_empty() => {}
            Length => {
                // A unit may follow: `8 B`.
                let word = cell.split(|byte| is_blank(*byte)).next()?;
                self.length = Some(number(word, 10).filter(|length| *length <= 64)? as usize);
            }
            Column::Code => self.code = number(cell, 10).map(|code| code as usize),
            Data => {
                let between = |byte: &u8| is_blank(*byte) || b",-:|\"'".contains(byte);
                for part in cell.split(between).filter(|part| !part.is_empty()) {
                    self.bytes(part)?;
                }
            }
            Column::Byte if cell.is_empty() => {}
            Column::Byte => self.bytes(cell)?,
            Attribute => self.attribute(cell),
            Extended => self.extended = Some(is_said(cell, &["ext", "extended"])),
            Remote => self.remote = is_said(cell, &["rtr", "remote", "r", "远程帧", "远程"]),
            Column::Number if !self.channel.is_empty() => {}
            Column::Number => (self.channel, self.first) = (cell, 1),
            Channel(first) => (self.channel, self.first) = (cell, first),
            Other | Part => {}
        }
        Some(())
    }

    /// Takes the cells of the bytes. If they are the last ones of the row, more than are listed belong to it, too, so that it
    /// is not one.
    pub(super) fn cells<'b>(&mut self, rest: &mut Peekable<impl Iterator<Item = &'b [u8]>>, last: bool) -> Option<()> {
        while let Some(cell) = rest.next_if(|cell| {
            let wanted = self.count < self.length.unwrap_or(CLASSIC);
            let digits = unprefixed(cell);
            let fits = match digits.len() {
                _ if self.decimal => digits.len() <= 3 && (wanted || last),
                1 => wanted,
                2 => wanted || last,
                count => wanted && count.is_multiple_of(2),
            };
            fits && is_hex(digits)
        }) {
            self.bytes(cell)?;
        }
        Some(())
    }

    /// Adds bytes: two digits each, or one digit.
    pub(super) fn bytes(&mut self, text: &[u8]) -> Option<()> {
        let text = unprefixed(text);
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

    /// Adds a byte of two hexadecimal digits, or one to three decimal ones.
    pub(super) fn exact_byte(&mut self, word: &[u8]) -> Option<()> {
        let fits = if self.decimal { word.len() <= 3 && word.iter().all(u8::is_ascii_digit) } else { word.len() == 2 };
        fits.then(|| self.bytes(word)).flatten()
    }

    /// Returns true if the identifier can be one of its kind.
    pub(super) fn is_in_range(&self) -> bool {
        let most = if self.extended == Some(true) { 0x1FFF_FFFF } else { 0x7FF };
        self.id.is_some_and(|(id, _)| id <= most)
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
    let inner = inner.or(word.strip_suffix("字节".as_bytes()));
    let named = word.strip_prefix(b"DLC=").or_else(|| word.strip_prefix(b"DLC:"));
    match inner.or(named).unwrap_or(word) {
        [digit @ b'0'..=b'8'] => Some(usize::from(digit - b'0')),
        // Of CAN FD.
        digits => LONGER.into_iter().find(|length| number(digits, 10) == Some(*length as u32) && digits.len() == 2),
    }
}

/// Returns true if a word has the form of an identifier: three or eight hexadecimal digits, or a prefix.
pub(super) fn identifier(word: &[u8]) -> bool {
    let prefixed = Some(unprefixed(word)).filter(|digits| digits.len() < word.len() && !word.starts_with(b"$"));
    let digits = prefixed.unwrap_or(word);
    let digits = digits.strip_suffix(b":").unwrap_or(digits);
    let digits = digits.strip_suffix(b"h").or_else(|| digits.strip_suffix(b"x")).unwrap_or(digits);
    let prefixed = prefixed.or((digits.len() < word.len()).then_some(digits));
    let padded = digits.len() == 4 && digits.starts_with(b"0");
    let long = padded || matches!(digits.len(), 3 | 8) || prefixed.is_some() && (1..=8).contains(&digits.len());
    long && is_hex(digits)
}

/// Returns the digits of an identifier, true if they are marked as hexadecimal, and true if as an extended one. Of two,
/// `1802 (0x70a)`, the second one counts.
pub(super) fn id_digits(cell: &[u8]) -> (&[u8], bool, Option<bool>) {
    let inner = cell.strip_prefix(b"(").and_then(|cell| cell.strip_suffix(b")"));
    let hex = cell.split(|byte| *byte == b'(').nth(1).and_then(|cell| cell.strip_suffix(b")"));
    let (word, hex, extended) = match inner.or(hex).unwrap_or(cell) {
        [word @ .., b'x' | b'X'] if word.len() >= 3 => (word, false, Some(true)),
        [word @ .., b'h' | b'H'] => (word, true, None),
        [word @ .., b':'] | word => (word, false, None),
    };
    let digits = unprefixed(word);
    (digits, hex || digits.len() < word.len(), extended)
}

/// Returns true if a cell affirms its column, by one of these words or another.
fn is_said(cell: &[u8], words: &[&str]) -> bool {
    let is = |word: &&str| cell.eq_ignore_ascii_case(word.as_bytes());
    words.iter().chain(&["1", "x", "true", "yes", "y"]).any(is)
}

/// Words for a direction that are something else outside a column for it, in lower case.
const SIDES: &[(&str, Direction)] = &[
    ("in", Direction::Rx),
    ("e", Direction::Rx),
    ("r", Direction::Rx),
    ("out", Direction::Tx),
    ("s", Direction::Tx),
    ("t", Direction::Tx),
];

/// Parses a cell of a column for directions.
pub(super) fn side(cell: &[u8]) -> Option<Direction> {
    let is = |word: &str| cell.eq_ignore_ascii_case(word.as_bytes());
    direction(cell).or_else(|| SIDES.iter().find(|(word, _)| is(word)).map(|(_, side)| *side))
}

fn sent(cell: &[u8]) -> Option<Direction> {
    match cell {
        b"0" => Some(Direction::Rx),
        b"1" => Some(Direction::Tx),
        _ => side(cell),
    }
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

//! Pasted rows of other programs: logs of BUSMASTER and of Kvaser's CanKing.
//!
//! `11:22:33:4567 Rx 1 0x601 s 8 40 08 10 00 00 00 00 00`: time of day with tenths of a millisecond, direction,
//! channel, identifier, kind, length, bytes. `0    00000601         8  40 08 10 00 00 00 00 00   12.345678 R`: channel,
//! identifier, flags, length, bytes, seconds, direction. The row shows if it is decimal. Neither form has a mark that
//! prose lacks, so every column has to fit.

use super::lex::{byte, nibble, skip_blanks, word};
use super::stamp::{bare, digits, nanoseconds};
use crate::bytes::frame::{CanId, Direction, Frame, Kind, Stamp, StampForm};

/// The bus of a channel, the first being 0.
const BUSES: [&[u8]; 8] = [b"can0", b"can1", b"can2", b"can3", b"can4", b"can5", b"can6", b"can7"];
/// Number of digits of a hexadecimal identifier of CanKing, padded with zeros.
const FILLED: usize = 8;

/// A row: its stamp, the name of its bus, and the frame.
pub(super) type LogRow = (Stamp, &'static [u8], Frame);

/// Parses a row of either program.
pub(super) fn row(text: &[u8]) -> Option<LogRow> {
    let (first, rest) = word(text);
    match first {
        [b'0'..=b'9', ..] if first.contains(&b':') => busmaster(first, skip_blanks(rest)),
        [channel @ b'0'..=b'7'] => canking(usize::from(channel - b'0'), skip_blanks(rest)),
        _ => None,
    }
}

/// Returns true for the heading of CanKing's columns, and for its last line.
pub(super) fn is_head(text: &[u8]) -> bool {
    text.starts_with(b"Chn ") && skip_blanks(word(text).1).starts_with(b"Identifier ") || text == b"Logging stopped."
}

fn busmaster(time: &[u8], rest: &[u8]) -> Option<LogRow> {
    let stamp = time_of_day(time)?;
    let (side, rest) = next(rest);
    let (channel, rest) = next(rest);
    let (id, rest) = next(rest);
    let dir = super::console::way(side)?;
    let [channel @ b'1'..=b'8'] = channel else { return None };
    let (kind, rest) = next(rest);
    let (extended, remote) = match kind {
        b"s" | b"S" => (false, false),
        b"x" | b"X" => (true, false),
        b"sr" | b"SR" => (false, true),
        b"xr" | b"XR" => (true, true),
        _ => return None,
    };
    let prefixed = id.strip_prefix(b"0x").or_else(|| id.strip_prefix(b"0X"));
    let decimal = prefixed.is_none();
    let id = identifier(prefixed.unwrap_or(id), decimal, extended)?;
    let (frame, rest) = frame(id, remote, decimal, rest)?;
    let bus = BUSES.get(usize::from(channel - b'1'))?;
    rest.is_empty().then_some((stamp, *bus, Frame { dir: Some(dir), ..frame }))
}

fn canking(channel: usize, rest: &[u8]) -> Option<LogRow> {
    let (digits, rest) = next(rest);
    let (flags, after) = next(rest);
    let named = flags.iter().all(|flag| matches!(flag, b'X' | b'R')) && !flags.is_empty();
    let (extended, remote) = (named && flags.contains(&b'X'), named && flags.contains(&b'R'));
    let decimal = digits.len() < FILLED;
    let id = identifier(digits, decimal, extended)?;
    let (frame, rest) = frame(id, remote, decimal, if named { after } else { rest })?;
    let (stamp, rest) = match bare(rest) {
        Some((stamp, rest)) => (stamp, skip_blanks(rest)),
        // It is the last word of a row without a direction.
        None => (bare(&[rest, b" "].concat())?.0, &b""[..]),
    };
    let dir = match rest {
        b"R" => Some(Direction::Rx),
        b"T" => Some(Direction::Tx),
        b"" => None,
        _ => return None,
    };
    Some((stamp, BUSES.get(channel)?, Frame { dir, ..frame }))
}

/// Parses length and bytes; returns the rest as well.
fn frame(id: CanId, remote: bool, decimal: bool, rest: &[u8]) -> Option<(Frame, &[u8])> {
    let (length, mut rest) = next(rest);
    let [length @ b'0'..=b'8'] = length else { return None };
    let len = length - b'0';
    let mut frame = Frame::classic(id, &[]);
    frame.len = len;
    if remote {
        frame.kind = Kind::Remote;
        return Some((frame, rest));
    }
    for slot in frame.data.iter_mut().take(usize::from(len)) {
        let (digits, after) = next(rest);
        *slot = match digits {
            [high, low] if !decimal => byte(*high, *low)?,
            [_] | [_, _] | [_, _, _] if decimal => u8::try_from(number(digits, 10)?).ok()?,
            _ => return None,
        };
        rest = after;
    }
    Some((frame, rest))
}

fn identifier(digits: &[u8], decimal: bool, extended: bool) -> Option<CanId> {
    let value = number(digits, if decimal { 10 } else { 16 })?;
    match extended {
        false => (value <= 0x7FF).then(|| CanId::standard(value as u16)),
        true => (value <= 0x1FFF_FFFF).then(|| CanId::extended(value)),
    }
}

/// Parses a whole word as a number.
fn number(digits: &[u8], base: u32) -> Option<u32> {
    let value = |sum: Option<u32>, digit: &u8| {
        let digit = u32::from(nibble(*digit));
        sum?.checked_mul(base)?.checked_add(Some(digit).filter(|digit| *digit < base)?)
    };
    if digits.is_empty() { None } else { digits.iter().fold(Some(0), value) }
}

/// Parses `11:22:33:4567`: the part after the last colon is a fraction of a second.
fn time_of_day(text: &[u8]) -> Option<Stamp> {
    let (hours, hour_digits, rest) = digits(text);
    let (minutes, minute_digits, rest) = digits(rest.strip_prefix(b":")?);
    let (seconds, second_digits, rest) = digits(rest.strip_prefix(b":")?);
    let (fraction, decimals, rest) = super::stamp::fraction(rest.strip_prefix(b":")?)?;
    let whole = [hour_digits, minute_digits, second_digits].iter().all(|count| (1..=2).contains(count));
    if !whole || !rest.is_empty() || hours > 23 || minutes > 59 || seconds > 59 || decimals > 6 {
        return None;
    }
    let ns = nanoseconds((hours * 3600 + minutes * 60 + seconds) as i64, fraction);
    Some(Stamp { form: StampForm::Seconds, ns, width: 5, decimals })
}

/// Returns the next word and the text after the blanks that follow it.
fn next(text: &[u8]) -> (&[u8], &[u8]) {
    let (first, rest) = word(text);
    (first, skip_blanks(rest))
}

#[cfg(test)]
mod tests {
    use super::{LogRow, row};
    use crate::bytes::frame::{CanId, Direction, Kind};

    type Read = (i64, String, CanId, Kind, Option<Direction>, Vec<u8>);

    fn read(text: &str) -> Option<Read> {
        let (stamp, bus, frame): LogRow = row(text.as_bytes())?;
        let data = if frame.kind == Kind::Remote { Vec::new() } else { frame.payload().to_vec() };
        Some((stamp.ns, String::from_utf8_lossy(bus).into_owned(), frame.id, frame.kind, frame.dir, data))
    }

    #[test]
    fn rows_of_both_programs() {
        let (rx, tx) = (Some(Direction::Rx), Some(Direction::Tx));
        let (sdo, data) = (CanId::standard(0x601), vec![0x40, 0x08, 0x10, 0]);
        let day = 40_953_456_700_000;
        for (text, ns, bus, id, kind, dir, data) in [
            ("11:22:33:4567 Rx 1 0x601 s 4 40 08 10 00", day, "can0", sdo, Kind::Data, rx, data.clone()),
            ("11:22:33:4567 Tx 2 1537 s 4 064 008 016 000", day, "can1", sdo, Kind::Data, tx, data.clone()),
            ("11:22:33:4567 Rx 1 0x601 sr 8", day, "can0", sdo, Kind::Remote, rx, vec![]),
            (
                "1:2:3:045 Rx 1 0x12345678 x 0",
                3_723_045_000_000,
                "can0",
                CanId::extended(0x1234_5678),
                Kind::Data,
                rx,
                vec![],
            ),
            (
                "0    00000601         4  40 08 10 00    12.345678 R",
                12_345_678_000,
                "can0",
                sdo,
                Kind::Data,
                rx,
                data.clone(),
            ),
            ("1    1537   4  64   8  16   0    12.345678 T", 12_345_678_000, "can1", sdo, Kind::Data, tx, data.clone()),
            (
                "0    12345678 X       1  40    0.5",
                500_000_000,
                "can0",
                CanId::extended(0x1234_5678),
                Kind::Data,
                None,
                vec![0x40],
            ),
            (
                "0    00000704 R       0    0.500000 R",
                500_000_000,
                "can0",
                CanId::standard(0x704),
                Kind::Remote,
                rx,
                vec![],
            ),
        ] {
            assert_eq!(read(text), Some((ns, bus.to_owned(), id, kind, dir, data)), "{text}");
        }
    }

    #[test]
    fn what_does_not_fit_is_no_row() {
        for text in [
            "11:22:33 Rx 1 0x601 s 1 40",
            "11:22:33:4567 Rx 1 0x601 s 2 40",
            "11:22:33:4567 Rx 1 0x601 s 1 40 08",
            "11:22:33:4567 Rx 1 0x801 s 1 40",
            "11:22:33:4567 Rx 1 0x601 q 1 40",
            "25:22:33:4567 Rx 1 0x601 s 1 40",
            "11:22:33:4567 601 1 40",
            "11:22:33:4567 it is 5 o'clock",
            "0    00000601         2  40    12.345678 R",
            "0    00000601         1  40 08    12.345678 R",
            "0    00000601         1  40    12 R",
            "0    00000601         1  40    12.345678 Q",
            "0    00000801         1  40    12.345678 R",
            "0    601 1 4G 1.5 R",
            "0 1 2 3",
            "0 601 8",
        ] {
            assert_eq!(read(text), None, "{text}");
        }
    }
}

//! candump's console form: ` (1549455524.265601)  can0  60A   [8]  40 08 10 00 00 00 00 00`, as `candump -ta` prints
//! it.
//!
//! This is the line of the frame alone; `render::text` appends words to the same columns. Numbers are formatted by
//! hand, since formatting costs more than decoding. Stamps keep all their digits.

use super::{CaptureFacts, Loss, Losses, name_of};
use crate::bytes::calendar::date_of;
use crate::bytes::frame::{Direction, Frame, Kind, Stamp, StampForm};
use crate::bytes::ns::Ns;
use crate::bytes::readers::Marker;
use crate::words::digits::{Hex, KnownTexts, Padded, filled, fraction, hex_digits, put, put_beginning};
use crate::words::escape;

const SECOND: i64 = 1_000_000_000;
/// Maximum width of a bus name to which columns are aligned.
const NAME_WIDTH: usize = 16;

/// A writer of candump's console form.
///
/// Stamps keep their form and digits but are never differences, since those of a part of a capture would add up to
/// other times.
#[derive(Debug, Default)]
pub struct Console {
    /// The losses.
    pub losses: Losses,
    columns: ConsoleColumns,
}

impl Console {
    /// Appends a frame's line.
    pub fn frame(&mut self, out: &mut Vec<u8>, setting: CaptureFacts<'_>, frame: &Frame) {
        let stamp = frame.stamp.map(|stamp| Stamp { ns: setting.moment(frame).unwrap_or(stamp.ns), ..stamp });
        let name = name_of(setting.buses, frame.bus, &mut self.losses);
        if frame.dir.is_none() && matches!(frame.kind, Kind::Fd { brs, esi } if brs || esi) {
            self.losses.count(Loss::FdFlags);
        }
        out.extend_from_slice(if stamp.is_some() { b" " } else { b"  " });
        self.columns.head(out, stamp.as_ref(), &name, frame);
        match frame.kind {
            Kind::Remote => put!(out; " remote request"),
            _ => {
                for byte in frame.payload() {
                    out.push(b' ');
                    out.extend_from_slice(&hex_digits(*byte));
                }
            }
        }
        put!(out; if frame.kind == Kind::Error { "   ERRORFRAME\n" } else { "\n" });
    }

    /// Appends the line of a gap or an error marker.
    pub fn marker(&mut self, out: &mut Vec<u8>, setting: CaptureFacts<'_>, marker: &Marker) {
        match *marker {
            Marker::Dropped { bus, count, total, .. } => {
                dropped(out, &name_of(setting.buses, bus, &mut self.losses), count, total);
            }
            Marker::Error { bus, stamp, .. } => {
                let shift = setting.date_ns.unwrap_or_default();
                let stamp = stamp.map(|stamp| Stamp { ns: stamp.ns + shift, ..stamp });
                out.extend_from_slice(if stamp.is_some() { b" " } else { b"  " });
                self.columns.error(out, stamp.as_ref(), &name_of(setting.buses, bus, &mut self.losses));
            }
            Marker::LeftOut { count, .. } => left_out(out, count),
            Marker::Start { .. } | Marker::Backward { .. } | Marker::Swapped => {}
        }
    }
}

/// The columns before the data, whose layout depends on the lines so far.
#[derive(Debug, Default)]
pub struct ConsoleColumns {
    /// Width of the widest bus name so far; candump aligns names to the right.
    width: usize,
    /// True after a 29-bit identifier, from which on candump indents 11-bit ones.
    indent: bool,
    /// The columns from the bus to the length by what decides them, but for the layout.
    known: KnownTexts,
    second: Second,
}

/// The whole second of the last stamp and its text, since most stamps have that of the one before.
#[derive(Clone, Copy, Debug, Default)]
struct Second {
    /// Its beginning.
    from_ns: Ns,
    /// The width of its text, in digits; 0 before the first.
    width: u8,
    /// Its text behind an opening parenthesis, and the number of bytes of both.
    digits: [u8; 21],
    len: u8,
}

impl ConsoleColumns {
    /// Appends stamp, bus, direction, identifier and length of a frame, up to the blank after the length.
    pub fn head(&mut self, out: &mut Vec<u8>, stamp: Option<&Stamp>, name: &[u8], frame: &Frame) {
        if let Some(stamp) = stamp {
            self.stamp(out, stamp);
        }
        self.known_columns(out, name, frame);
    }

    /// Appends the columns from the bus to the length, up to the blank after it.
    pub fn known_columns(&mut self, out: &mut Vec<u8>, name: &[u8], frame: &Frame) {
        let key = key(name, frame);
        if self.known.put(out, key) {
            return;
        }
        let (start, layout) = (out.len(), (self.width, self.indent));
        self.bus(out, name);
        direction(out, frame);
        self.identifier(out, frame);
        length(out, frame);
        if layout != (self.width, self.indent) {
            self.known.clear();
        }
        self.known.keep(key, out.get(start..).unwrap_or_default());
    }

    /// Appends the columns before the identifier.
    pub fn source(&mut self, out: &mut Vec<u8>, stamp: Option<&Stamp>, name: &[u8], frame: &Frame) {
        if let Some(stamp) = stamp {
            self.stamp(out, stamp);
        }
        self.bus(out, name);
        direction(out, frame);
    }

    /// Appends the line of an error marker without content.
    pub fn error(&mut self, out: &mut Vec<u8>, stamp: Option<&Stamp>, name: &[u8]) {
        if let Some(stamp) = stamp {
            self.stamp(out, stamp);
        }
        self.bus(out, name);
        put!(out; "ERROR\n");
    }

    /// Appends a stamp in parentheses with its digits as written.
    #[inline]
    pub fn stamp(&mut self, out: &mut Vec<u8>, stamp: &Stamp) {
        let Second { from_ns, width, digits, len } = &self.second;
        let within = (stamp.ns - *from_ns).as_ns();
        if stamp.form == StampForm::Seconds && *width == stamp.width && (0..SECOND).contains(&within) {
            put_beginning(out, digits, usize::from(*len));
            fraction(out, within as u32, stamp.decimals);
            put!(out; ")  ");
        } else {
            self.other_stamp(out, stamp);
        }
    }

    /// Appends a stamp of another second than the last one.
    #[inline(never)]
    fn other_stamp(&mut self, out: &mut Vec<u8>, stamp: &Stamp) {
        let start = out.len();
        put!(out; "(");
        if stamp.form != StampForm::Seconds || stamp.ns < Ns::ZERO {
            self::digits(out, stamp);
        } else {
            let whole = stamp.ns.as_ns() / SECOND;
            filled(out, whole.unsigned_abs(), usize::from(stamp.width), b'0');
            let text = out.get(start..).unwrap_or_default();
            let mut second = Second { from_ns: Ns::from_s(whole), width: stamp.width, ..Second::default() };
            if let Some(digits) = second.digits.get_mut(..text.len()) {
                digits.copy_from_slice(text);
                second.len = text.len() as u8;
                self.second = second;
            }
            fraction(out, (stamp.ns - second.from_ns).as_ns() as u32, stamp.decimals);
        }
        put!(out; ")  ");
    }

    /// Returns the layout of the columns, which only changes with a wider bus name or a longer identifier.
    #[inline]
    pub fn layout(&self) -> (usize, bool) {
        (self.width, self.indent)
    }

    fn bus(&mut self, out: &mut Vec<u8>, name: &[u8]) {
        if name.is_empty() {
            return;
        }
        self.width = self.width.max(name.len().min(NAME_WIDTH));
        for _ in name.len()..self.width {
            out.push(b' ');
        }
        if name.iter().all(u8::is_ascii_graphic) {
            out.extend_from_slice(name);
        } else {
            escape::terminal(out, name);
        }
        put!(out; "  ");
    }

    /// Appends the identifier.
    pub fn identifier(&mut self, out: &mut Vec<u8>, frame: &Frame) {
        let raw = u64::from(frame.id.raw());
        if frame.kind == Kind::Error {
            put!(out; Hex::<8>(raw | 0x2000_0000));
        } else if frame.id.is_extended() {
            self.indent = true;
            put!(out; Hex::<8>(raw));
        } else {
            if self.indent {
                put!(out; "     ");
            }
            put!(out; Hex::<3>(raw));
        }
    }
}

/// Appends the line of a gap, for both forms of candump.
pub fn dropped(out: &mut Vec<u8>, name: &[u8], count: u64, total: u64) {
    put!(out; "DROPCOUNT: dropped ", count, if count == 1 { " CAN frame on '" } else { " CAN frames on '" });
    escape::terminal(out, name);
    put!(out; "' socket (total drops ", total, ")\n");
}

/// Appends the line of rows left out, as people write it and readers accept it.
pub fn left_out(out: &mut Vec<u8>, count: Option<u64>) {
    match count {
        Some(count) => put!(out; "... ", count, if count == 1 { " row" } else { " rows" }, " left out ...\n"),
        None => put!(out; "...\n"),
    }
}

/// Returns all that decides the columns from the bus to the length, but for the layout. A bus has one name in a
/// capture, or none where it is not shown.
pub fn key(name: &[u8], frame: &Frame) -> u64 {
    let Frame { bus, id, kind, dir, len, length_form: form, .. } = *frame;
    let kind = match kind {
        Kind::Data => 0,
        Kind::Remote => 1,
        Kind::Error => 2,
        Kind::Fd { brs, esi } => 4 | u64::from(brs) | u64::from(esi) << 1,
    };
    let dir = match dir {
        None => 0,
        Some(Direction::Rx) => 1,
        Some(Direction::Tx) => 2,
    };
    let form = u64::from(form.raw_dlc & 15) | u64::from(form.braces) << 4 | u64::from(form.two_digits) << 5;
    let id = u64::from(id.raw()) | u64::from(id.is_extended()) << 29;
    let of = kind | dir << 3 | form << 5 | u64::from(len & 127) << 11 | u64::from(bus.0) << 18;
    id | of << 30 | u64::from(name.is_empty()) << 56
}

/// Appends a stamp with its digits as written.
pub fn digits(out: &mut Vec<u8>, stamp: &Stamp) {
    let (seconds, ns) = (stamp.ns.as_ns().div_euclid(SECOND), stamp.ns.as_ns().rem_euclid(SECOND) as u32);
    match stamp.form {
        StampForm::Seconds => filled(out, seconds.unsigned_abs(), usize::from(stamp.width), b'0'),
        StampForm::Calendar => calendar(out, seconds),
    }
    fraction(out, ns, stamp.decimals);
}

/// Appends `2026-09-15 18:44:56` for seconds since 1970-01-01.
fn calendar(out: &mut Vec<u8>, seconds: i64) {
    let (year, month, day) = date_of(seconds.div_euclid(86_400));
    let second = seconds.rem_euclid(86_400).unsigned_abs();
    put!(out; Padded::<4>(year.unsigned_abs()), "-", Padded::<2>(month.unsigned_abs()), "-");
    put!(out; Padded::<2>(day.unsigned_abs()), " ", Padded::<2>(second / 3600), ":");
    put!(out; Padded::<2>(second / 60 % 60), ":", Padded::<2>(second % 60));
}

/// Appends `TX - -  ` if the direction is known; B and E are the flags of an FD frame.
fn direction(out: &mut Vec<u8>, frame: &Frame) {
    let Some(dir) = frame.dir else { return };
    let (brs, esi) = match frame.kind {
        Kind::Fd { brs, esi } => (brs, esi),
        _ => (false, false),
    };
    // Written at once, since every line has it if one has.
    let [b, e] = [if brs { b'B' } else { b'-' }, if esi { b'E' } else { b'-' }];
    let first = if dir == Direction::Rx { b'R' } else { b'T' };
    out.extend_from_slice(&[first, b'X', b' ', b, b' ', e, b' ', b' ']);
}

/// Appends the length or raw DLC and a blank; candump prints another one before each byte.
pub fn length(out: &mut Vec<u8>, frame: &Frame) {
    let form = frame.length_form;
    if matches!(frame.kind, Kind::Fd { .. }) || form.two_digits {
        put!(out; "  [", Padded::<2>(u64::from(frame.len)), "] ");
    } else if form.braces || form.raw_dlc > 8 {
        put!(out; "   {", Hex::<1>(u64::from(form.raw_dlc.max(frame.len))), "} ");
    } else {
        put!(out; "   [", frame.len, "] ");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bytes::frame::{BusId, CanId, LengthForm};

    /// Frames of all forms, first those that leave the columns as they are.
    fn frames() -> Vec<(&'static [u8], Frame)> {
        let frame = Frame::classic(CanId::standard(0x181), &[1, 2, 3]);
        let fd = |brs, esi| Frame { kind: Kind::Fd { brs, esi }, ..frame };
        let of = |bus| Frame { bus: BusId(bus), ..frame };
        let form = |raw_dlc, braces, two_digits| LengthForm { raw_dlc, braces, two_digits };
        vec![
            (b"can0", frame),
            (b"can0", Frame { id: CanId::standard(0x281), ..frame }),
            (b"can0", Frame { len: 2, ..frame }),
            (b"can0", Frame { dir: Some(Direction::Rx), ..frame }),
            (b"can0", Frame { dir: Some(Direction::Tx), ..frame }),
            (b"can0", Frame { kind: Kind::Remote, ..frame }),
            (b"can0", Frame { kind: Kind::Error, ..frame }),
            (b"can0", fd(false, false)),
            (b"can0", Frame { dir: Some(Direction::Rx), ..fd(true, false) }),
            (b"can0", Frame { dir: Some(Direction::Rx), ..fd(false, true) }),
            (b"can0", Frame { length_form: form(12, false, false), ..frame }),
            (b"can0", Frame { length_form: form(0, true, false), ..frame }),
            (b"can0", Frame { length_form: form(0, false, true), ..frame }),
            (b"can1", of(1)),
            (b"", of(1)),
            (b"vcan12", of(2)),
            (b"can0", Frame { id: CanId::extended(0x181), ..frame }),
        ]
    }

    #[test]
    fn columns_that_are_known_are_those_that_would_be_written() {
        let (mut known, mut written) = (ConsoleColumns::default(), ConsoleColumns::default());
        let all = frames();
        // Each form is added when those before it are known, so that a change of the layout reaches them.
        for count in 1..=all.len() {
            for (name, frame) in all.iter().take(count).cycle().take(8 * count + 40) {
                let (mut one, mut other) = (Vec::new(), Vec::new());
                known.head(&mut one, None, name, frame);
                written.source(&mut other, None, name, frame);
                written.identifier(&mut other, frame);
                length(&mut other, frame);
                assert_eq!(String::from_utf8_lossy(&one), String::from_utf8_lossy(&other), "{frame:?}");
            }
        }
    }

    #[test]
    fn stamps_have_their_digits_whatever_came_before() {
        let stamp = |ns, width, decimals, form| Stamp { form, ns: Ns(ns), width, decimals };
        let (seconds, date) = (StampForm::Seconds, StampForm::Calendar);
        let mut columns = ConsoleColumns::default();
        for (stamp, text) in [
            (stamp(1_549_455_524_265_601_000, 10, 6, seconds), "(1549455524.265601)  "),
            (stamp(1_549_455_524_999_999_000, 10, 6, seconds), "(1549455524.999999)  "),
            (stamp(1_549_455_525_000_000_000, 10, 6, seconds), "(1549455525.000000)  "),
            (stamp(1_549_455_525_000_000_001, 10, 9, seconds), "(1549455525.000000001)  "),
            (stamp(1_549_455_524_265_601_000, 10, 0, seconds), "(1549455524)  "),
            (stamp(304_418_000, 3, 6, seconds), "(000.304418)  "),
            (stamp(304_418_000, 1, 6, seconds), "(0.304418)  "),
            (stamp(0, 1, 1, seconds), "(0.0)  "),
            (stamp(1_789_497_896_479_963_000, 0, 6, date), "(2026-09-15 18:44:56.479963)  "),
            (stamp(304_418_000, 1, 6, seconds), "(0.304418)  "),
            (stamp(i64::MAX, 10, 9, seconds), "(9223372036.854775807)  "),
        ] {
            let mut out = Vec::new();
            columns.stamp(&mut out, &stamp);
            assert_eq!(String::from_utf8_lossy(&out), text);
        }
    }
}

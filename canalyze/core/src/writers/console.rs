//! candump's console form: ` (1549455524.265601)  can0  60A   [8]  40 08 10 00 00 00 00 00`, as `candump -ta` prints it.
//!
//! The line of a frame without anything said about it; `render::text` puts its words behind the same columns.
//! Formatting is by hand: it costs more than decoding. Must not: lose a digit of a stamp.

use super::{Loss, Losses, Setting, name_of};
use crate::calendar::date_of;
use crate::frame::{Direction, Frame, Kind, Stamp, StampForm};
use crate::readers::Marker;
use crate::text::digits::{Hex, Padded, filled, fraction, hex_digits, put};
use crate::text::escape;

const SECOND: i64 = 1_000_000_000;
/// Longest bus name for which columns are aligned.
const NAME_WIDTH: usize = 16;

/// A writer of candump's console form.
///
/// Stamps keep their form and digits, but never are differences: those of a part of a capture would add up to other
/// times.
#[derive(Debug, Default)]
pub struct Console {
    /// What could not be written.
    pub losses: Losses,
    columns: Columns,
}

impl Console {
    /// Appends a frame's line.
    pub fn frame(&mut self, out: &mut Vec<u8>, setting: Setting<'_>, frame: &Frame) {
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

    /// Appends a gap, or an error marker.
    pub fn marker(&mut self, out: &mut Vec<u8>, setting: Setting<'_>, marker: &Marker) {
        match *marker {
            Marker::Dropped { bus, count, total, .. } => {
                dropped(out, &name_of(setting.buses, bus, &mut self.losses), count, total);
            }
            Marker::Error { bus, stamp, .. } => {
                let shift = setting.date_ns.unwrap_or(0);
                let stamp = stamp.map(|stamp| Stamp { ns: stamp.ns.saturating_add(shift), ..stamp });
                out.extend_from_slice(if stamp.is_some() { b" " } else { b"  " });
                self.columns.error(out, stamp.as_ref(), &name_of(setting.buses, bus, &mut self.losses));
            }
            Marker::LeftOut { count, .. } => left_out(out, count),
            Marker::Start { .. } | Marker::Backward { .. } | Marker::Swapped => {}
        }
    }
}

/// The columns before the data: what the lines so far decide of the next ones.
#[derive(Debug, Default)]
pub struct Columns {
    /// Widest bus name so far; candump aligns them to the right.
    width: usize,
    /// A 29-bit identifier was seen: 11-bit ones are indented from then on, as candump does.
    indent: bool,
}

impl Columns {
    /// Stamp, bus, direction, identifier and length of a frame, to the blank behind the length.
    pub fn head(&mut self, out: &mut Vec<u8>, stamp: Option<&Stamp>, name: &[u8], frame: &Frame) {
        self.source(out, stamp, name, frame);
        self.identifier(out, frame);
        length(out, frame);
    }

    /// Of these the columns before the identifier.
    pub fn source(&mut self, out: &mut Vec<u8>, stamp: Option<&Stamp>, name: &[u8], frame: &Frame) {
        if let Some(stamp) = stamp {
            written(out, stamp);
        }
        self.bus(out, name);
        direction(out, frame);
    }

    /// The line of an error marker without content.
    pub fn error(&mut self, out: &mut Vec<u8>, stamp: Option<&Stamp>, name: &[u8]) {
        if let Some(stamp) = stamp {
            written(out, stamp);
        }
        self.bus(out, name);
        put!(out; "ERROR\n");
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

    /// The identifier.
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

/// The line of a gap, in both of candump's forms.
pub fn dropped(out: &mut Vec<u8>, name: &[u8], count: u64, total: u64) {
    put!(out; "DROPCOUNT: dropped ", count, if count == 1 { " CAN frame on '" } else { " CAN frames on '" });
    escape::terminal(out, name);
    put!(out; "' socket (total drops ", total, ")\n");
}

/// The line of rows that are left out, as people write it and readers take it.
pub fn left_out(out: &mut Vec<u8>, count: Option<u64>) {
    match count {
        Some(count) => put!(out; "... ", count, if count == 1 { " row" } else { " rows" }, " left out ...\n"),
        None => put!(out; "...\n"),
    }
}

/// A stamp with its digits as they were written.
fn written(out: &mut Vec<u8>, stamp: &Stamp) {
    put!(out; "(");
    digits(out, stamp);
    put!(out; ")  ");
}

/// The same without its parentheses.
pub fn digits(out: &mut Vec<u8>, stamp: &Stamp) {
    let (seconds, ns) = (stamp.ns.div_euclid(SECOND), stamp.ns.rem_euclid(SECOND) as u32);
    match stamp.form {
        StampForm::Seconds => filled(out, seconds.unsigned_abs(), usize::from(stamp.width), b'0'),
        StampForm::Calendar => calendar(out, seconds),
    }
    fraction(out, ns, stamp.decimals);
}

/// `2026-09-15 18:44:56` of seconds since 1970-01-01.
fn calendar(out: &mut Vec<u8>, seconds: i64) {
    let (year, month, day) = date_of(seconds.div_euclid(86_400));
    let second = seconds.rem_euclid(86_400).unsigned_abs();
    put!(out; Padded::<4>(year.unsigned_abs()), "-", Padded::<2>(month.unsigned_abs()), "-");
    put!(out; Padded::<2>(day.unsigned_abs()), " ", Padded::<2>(second / 3600), ":");
    put!(out; Padded::<2>(second / 60 % 60), ":", Padded::<2>(second % 60));
}

/// `TX - -  `, where the capture tells; B and E are the flags of an FD frame.
fn direction(out: &mut Vec<u8>, frame: &Frame) {
    let Some(dir) = frame.dir else { return };
    let (brs, esi) = match frame.kind {
        Kind::Fd { brs, esi } => (brs, esi),
        _ => (false, false),
    };
    // In one piece: every line has it where one has.
    let [b, e] = [if brs { b'B' } else { b'-' }, if esi { b'E' } else { b'-' }];
    let first = if dir == Direction::Rx { b'R' } else { b'T' };
    out.extend_from_slice(&[first, b'X', b' ', b, b' ', e, b' ', b' ']);
}

/// Length or raw DLC, and a blank behind it: candump prints one before each byte, too.
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

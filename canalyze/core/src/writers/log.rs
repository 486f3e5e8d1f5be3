//! candump's log form: `(1549455524.265601) can0 60A#4008100000000000`, as `candump -l` writes it.
//!
//! Direction stands at the line's end as `candump -l -x` has it. Must not: lose a digit of a stamp.

use super::{Loss, Losses, Setting, console, name_of};
use crate::frame::{Direction, Frame, Kind};
use crate::readers::Marker;
use crate::text::digits::{hex, hex_byte};

/// Between the stamps that are invented for frames without any.
const SPACING_NS: i64 = 1_000_000;

/// A writer of candump logs. Its stamps are never negative, which its readers do not know.
#[derive(Debug, Default)]
pub struct Log {
    /// What could not be written.
    pub losses: Losses,
    /// The last stamp that was written.
    last_ns: Option<i64>,
}

impl Log {
    /// Appends a frame's line.
    pub fn frame(&mut self, out: &mut Vec<u8>, setting: Setting<'_>, frame: &Frame) {
        let moment = setting.moment(frame).filter(|moment| *moment >= 0).unwrap_or_else(|| {
            self.losses.count(Loss::NoStamp);
            self.last_ns.map_or(0, |last| last.saturating_add(SPACING_NS))
        });
        self.last_ns = Some(moment);
        stamp(out, moment.unsigned_abs(), frame.stamp.map_or(6, |stamp| stamp.decimals));
        let name = name_of(setting.buses, frame.bus, &mut self.losses);
        out.extend_from_slice(if name.is_empty() { b"can0" } else { &name });
        out.push(b' ');
        let raw = frame.id.raw();
        match frame.kind {
            Kind::Error => hex(out, u64::from(raw | 0x2000_0000), 8),
            _ if frame.id.is_extended() => hex(out, u64::from(raw), 8),
            _ => hex(out, u64::from(raw), 3),
        }
        out.push(b'#');
        match frame.kind {
            Kind::Fd { brs, esi } => {
                out.push(b'#');
                hex(out, u64::from(u8::from(brs) | u8::from(esi) << 1), 1);
            }
            Kind::Remote => {
                out.push(b'R');
                if frame.len > 0 {
                    hex(out, u64::from(frame.len.min(8)), 1);
                }
            }
            Kind::Data | Kind::Error => {}
        }
        for byte in frame.payload() {
            hex_byte(out, *byte);
        }
        if frame.length_form.raw_dlc > 8 && !matches!(frame.kind, Kind::Fd { .. }) {
            out.push(b'_');
            hex(out, u64::from(frame.length_form.raw_dlc), 1);
        }
        out.extend_from_slice(match frame.dir {
            Some(Direction::Rx) => b" R\n",
            Some(Direction::Tx) => b" T\n",
            None => b"\n",
        });
    }

    /// Only a gap has a line in this form.
    pub fn marker(&mut self, out: &mut Vec<u8>, setting: Setting<'_>, marker: &Marker) {
        match *marker {
            Marker::Dropped { bus, count, total, .. } => {
                console::dropped(out, &name_of(setting.buses, bus, &mut self.losses), count, total);
            }
            Marker::Error { .. } => self.losses.count(Loss::ErrorFrame),
            Marker::Start { .. } | Marker::Backward { .. } => {}
        }
    }
}

/// `(0000000001.500000) `: at least ten digits before the point, as candump writes them, and six behind it.
fn stamp(out: &mut Vec<u8>, ns: u64, decimals: u8) {
    out.push(b'(');
    decimal(out, ns / 1_000_000_000, 10);
    out.push(b'.');
    let mut digits = [b'0'; 9];
    let mut rest = ns % 1_000_000_000;
    for digit in digits.iter_mut().rev() {
        *digit = b'0' + (rest % 10) as u8;
        rest /= 10;
    }
    out.extend_from_slice(digits.get(..usize::from(decimals.clamp(6, 9))).unwrap_or(&digits));
    out.extend_from_slice(b") ");
}

/// A decimal number of at least so many digits, at most 20.
fn decimal(out: &mut Vec<u8>, number: u64, width: usize) {
    let mut digits = [b'0'; 20];
    let mut rest = number;
    let mut count = 0;
    for digit in digits.iter_mut().rev() {
        *digit = b'0' + (rest % 10) as u8;
        rest /= 10;
        count += 1;
        if rest == 0 {
            break;
        }
    }
    out.extend_from_slice(digits.get(digits.len() - count.max(width.min(20))..).unwrap_or(&digits));
}

//! candump's log form: `(1549455524.265601) can0 60A#4008100000000000`, as `candump -l` writes it.
//!
//! Direction stands at the line's end as `candump -l -x` has it. Must not: lose a digit of a stamp.

use super::{Loss, Losses, Setting};
use crate::frame::{Direction, Frame, Kind};
use crate::readers::Marker;

/// A writer of candump logs.
#[derive(Debug, Default)]
pub struct Log {
    /// What could not be written.
    pub losses: Losses,
    frames: u64,
}

impl Log {
    /// Appends a frame's line.
    pub fn frame(&mut self, out: &mut Vec<u8>, setting: Setting<'_>, frame: &Frame) {
        self.frames += 1;
        let moment = setting.moment(frame).unwrap_or_else(|| {
            self.losses.count(Loss::NoStamp);
            (self.frames as i64 - 1).saturating_mul(1_000_000)
        });
        stamp(out, moment, frame.stamp.map_or(6, |stamp| stamp.decimals));
        let name = setting.buses.name(frame.bus);
        out.extend_from_slice(if name.is_empty() { b"can0" } else { name });
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
            hex(out, u64::from(*byte), 2);
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
                let words = format!(
                    "DROPCOUNT: dropped {count} CAN frame{} on '{}' socket (total drops {total})\n",
                    if count == 1 { "" } else { "s" },
                    String::from_utf8_lossy(setting.buses.name(bus))
                );
                out.extend_from_slice(words.as_bytes());
            }
            Marker::Error { .. } => self.losses.count(Loss::ErrorFrame),
            Marker::Start { .. } | Marker::Backward { .. } => {}
        }
    }
}

/// `(0000000001.500000) `: at least ten digits before the point, as candump writes them, and six behind it.
fn stamp(out: &mut Vec<u8>, ns: i64, decimals: u8) {
    let (seconds, fraction) = (ns.div_euclid(1_000_000_000), ns.rem_euclid(1_000_000_000) as u64);
    out.push(b'(');
    if seconds < 0 {
        out.push(b'-');
    }
    decimal(out, seconds.unsigned_abs(), 10);
    out.push(b'.');
    let mut digits = [b'0'; 9];
    let mut rest = fraction;
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

/// A number in so many hexadecimal digits, at most 16.
fn hex(out: &mut Vec<u8>, number: u64, digits: u32) {
    for place in (0..digits.min(16)).rev() {
        let nibble = (number >> (4 * place)) as u8 & 0xF;
        out.push(if nibble < 10 { b'0' + nibble } else { b'A' + nibble - 10 });
    }
}

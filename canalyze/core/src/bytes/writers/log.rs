//! candump's log form: `(1549455524.265601) can0 60A#4008100000000000`, as `candump -l` writes it.
//!
//! The direction is at the end of the line as with `candump -l -x`. Stamps keep all their digits.

use super::{CaptureFacts, Loss, Losses, console, name_of};
use crate::bytes::frame::{Direction, Frame, Kind};
use crate::bytes::ns::Ns;
use crate::bytes::readers::Marker;
use crate::words::digits::{Hex, Joined, Padded, fraction, put};

const SECOND: u64 = 1_000_000_000;
/// Distance of the stamps invented for frames without any, in ns.
const SPACING_NS: Ns = Ns::from_ms(1);

/// A writer of candump logs. Stamps are never negative, since readers of this form do not know such.
#[derive(Debug, Default)]
pub struct Log {
    /// The losses.
    pub losses: Losses,
    /// The last written stamp, in ns.
    last_ns: Option<Ns>,
}

impl Log {
    /// Appends a frame's line.
    pub fn frame(&mut self, out: &mut Vec<u8>, setting: CaptureFacts<'_>, frame: &Frame) {
        let moment = setting.moment(frame).filter(|moment| *moment >= Ns::ZERO).unwrap_or_else(|| {
            self.losses.count(Loss::NoStamp);
            self.last_ns.map_or(Ns::ZERO, |last| last + SPACING_NS)
        });
        self.last_ns = Some(moment);
        let ns = moment.as_ns().unsigned_abs();
        // At least ten digits before the point and six after it, like candump.
        put!(out; "(", Padded::<10>(ns / SECOND));
        fraction(out, (ns % SECOND) as u32, frame.stamp.map_or(6, |stamp| stamp.decimals.max(6)));
        put!(out; ") ");
        let name = name_of(setting.buses, frame.bus, &mut self.losses);
        out.extend_from_slice(if name.is_empty() { b"can0" } else { &name });
        let raw = u64::from(frame.id.raw());
        match frame.kind {
            Kind::Error => put!(out; " ", Hex::<8>(raw | 0x2000_0000), "#"),
            _ if frame.id.is_extended() => put!(out; " ", Hex::<8>(raw), "#"),
            _ => put!(out; " ", Hex::<3>(raw), "#"),
        }
        match frame.kind {
            Kind::Fd { brs, esi } => put!(out; "#", Hex::<1>(u64::from(brs) | u64::from(esi) << 1)),
            Kind::Remote if frame.len > 0 => put!(out; "R", frame.len.min(8)),
            Kind::Remote => put!(out; "R"),
            Kind::Data | Kind::Error => {}
        }
        put!(out; Joined(frame.payload()));
        if frame.length_form.raw_dlc > 8 && !matches!(frame.kind, Kind::Fd { .. }) {
            put!(out; "_", Hex::<1>(u64::from(frame.length_form.raw_dlc)));
        }
        put!(out; match frame.dir {
            Some(Direction::Rx) => " R\n",
            Some(Direction::Tx) => " T\n",
            None => "\n",
        });
    }

    /// Appends the line of a gap; other markers have none.
    pub fn marker(&mut self, out: &mut Vec<u8>, setting: CaptureFacts<'_>, marker: &Marker) {
        match *marker {
            Marker::Dropped { bus, count, total, .. } => {
                console::dropped(out, &name_of(setting.buses, bus, &mut self.losses), count, total);
            }
            Marker::Error { .. } => self.losses.count(Loss::ErrorFrame),
            Marker::LeftOut { count, .. } => console::left_out(out, count),
            Marker::Start { .. } | Marker::Backward { .. } | Marker::Swapped => {}
        }
    }
}

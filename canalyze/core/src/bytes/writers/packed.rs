//! The records that hand frames to programs in another language; `readers::packed` describes them.
//!
//! Stamps are absolute: if the capture has a date, they count from 1970-01-01. The writer of the final format counts
//! the losses of that format.

use super::{CaptureFacts, Loss, Losses};
use crate::bytes::frame::{BusId, Direction, Frame, Kind};
use crate::bytes::readers::Marker;
use crate::bytes::readers::packed::{EFF, ERR, HEAD, RTR, flag, kind};

/// A writer of records.
#[derive(Debug, Default)]
pub struct Packed {
    /// The losses.
    pub losses: Losses,
    /// Buses whose name has been written, one bit each.
    named: u64,
}

impl Packed {
    /// Appends a frame, preceded by the name of its bus if that is new.
    pub fn frame(&mut self, out: &mut Vec<u8>, setting: CaptureFacts<'_>, frame: &Frame) {
        self.name(out, setting, frame.bus);
        let mut flags = match frame.dir {
            Some(Direction::Rx) => flag::RX,
            Some(Direction::Tx) => flag::TX,
            None => 0,
        };
        let mut id = frame.id.raw();
        match frame.kind {
            Kind::Data => {}
            Kind::Remote => id |= RTR,
            Kind::Error => id |= ERR,
            Kind::Fd { brs, esi } => {
                flags |= flag::FD | if brs { flag::BRS } else { 0 } | if esi { flag::ESI } else { 0 };
            }
        }
        if frame.id.is_extended() {
            id |= EFF;
        }
        let moment = setting.moment(frame);
        if moment.is_some() {
            flags |= flag::STAMP;
        }
        let decimals = frame.stamp.map_or(9, |stamp| stamp.decimals.min(9));
        let payload = frame.payload();
        let size = payload.len() as u8;
        let raw = frame.length_form.raw_dlc;
        out.extend_from_slice(&[kind::FRAME, flags, frame.bus.0, frame.len, raw, decimals, size, 0]);
        out.extend_from_slice(&id.to_le_bytes());
        out.extend_from_slice(&frame.line.and_then(|line| u32::try_from(line).ok()).unwrap_or(0).to_le_bytes());
        out.extend_from_slice(&moment.unwrap_or_default().as_ns().to_le_bytes());
        out.extend_from_slice(payload);
    }

    /// Appends a marker. An error marker becomes an error frame without a class. A gap gets a record for live
    /// consumers, and is still counted as a loss, since no file format behind these records holds it.
    pub fn marker(&mut self, out: &mut Vec<u8>, setting: CaptureFacts<'_>, marker: &Marker) {
        match *marker {
            Marker::Dropped { bus, count, .. } => {
                self.losses.count(Loss::Gap);
                self.name(out, setting, bus);
                let mut head = [0; HEAD];
                let [record, which, _, _, _, _, _, _, number @ ..] = &mut head;
                (*record, *which) = (kind::DROPPED, bus.0);
                let dropped = i64::try_from(count).unwrap_or(i64::MAX).to_le_bytes();
                number.iter_mut().zip(dropped).for_each(|(byte, value)| *byte = value);
                out.extend_from_slice(&head);
            }
            Marker::Error { bus, stamp, .. } => {
                let frame = Frame {
                    bus,
                    t_ns: stamp.map(|stamp| stamp.ns),
                    stamp,
                    kind: Kind::Error,
                    ..Frame::classic(crate::bytes::frame::CanId::standard(0), &[])
                };
                self.frame(out, setting, &frame);
            }
            Marker::LeftOut { count, rows, .. } => {
                self.losses.count(Loss::Gap);
                left_out(out, count, rows);
            }
            Marker::Start { .. } | Marker::Backward { .. } | Marker::Swapped => {}
        }
    }

    fn name(&mut self, out: &mut Vec<u8>, setting: CaptureFacts<'_>, bus: BusId) {
        let bit = 1 << (bus.0 & 63);
        if self.named & bit != 0 {
            return;
        }
        self.named |= bit;
        let name = setting.buses.name(bus);
        let mut head = [0; HEAD];
        let [record, which, low, ..] = &mut head;
        (*record, *which, *low) = (kind::BUS, bus.0, name.len() as u8);
        out.extend_from_slice(&head);
        out.extend_from_slice(name);
    }
}

/// Appends the record of rows left out; they have no line here.
fn left_out(out: &mut Vec<u8>, count: Option<u64>, rows: Option<(u64, u64)>) {
    let signed = |number: Option<u64>| number.and_then(|number| i64::try_from(number).ok()).unwrap_or(-1);
    out.extend_from_slice(&[kind::LEFT_OUT, 0, 0, 0, 0, 0, 0, 0]);
    out.extend_from_slice(&signed(count).to_le_bytes());
    out.extend_from_slice(&signed(rows.map(|(last, _)| last)).to_le_bytes());
}

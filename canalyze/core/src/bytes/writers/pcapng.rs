//! pcapng: one section, an interface for each bus (LINKTYPE_CAN_SOCKETCAN, stamps in ns), a block for each frame.
//!
//! An interface is described before the first block of its bus. Frames have the full structure of SocketCAN, classic or
//! FD, with the flag for FD. An unknown direction is left out.

use super::{CaptureFacts, Loss, Losses};
use crate::bytes::frame::{BusId, Direction, Frame, Kind};
use crate::bytes::ns::Ns;
use crate::bytes::readers::Marker;

const LINKTYPE_CAN_SOCKETCAN: u16 = 227;
const EXTENDED: u32 = 0x8000_0000;
const REMOTE: u32 = 0x4000_0000;
const ERROR: u32 = 0x2000_0000;
const FDF: u8 = 4;

/// A writer of pcapng files.
#[derive(Debug, Default)]
pub struct Pcapng {
    /// The losses.
    pub losses: Losses,
    begun: bool,
    frames: u64,
    /// The buses with an interface, in the order of interfaces.
    interfaces: Vec<Interface>,
}

#[derive(Debug)]
struct Interface {
    bus: BusId,
    /// Frames lost since its last frame.
    lost: u64,
    /// Frames lost in total.
    lost_in_all: u64,
    /// Its last stamp, in ns.
    last_ns: u64,
}

impl Pcapng {
    /// Appends a frame's block.
    pub fn frame(&mut self, out: &mut Vec<u8>, setting: CaptureFacts<'_>, frame: &Frame) {
        self.frames += 1;
        let moment = setting.moment(frame).unwrap_or_else(|| {
            self.losses.count(Loss::NoStamp);
            Ns::from_ms(self.frames as i64 - 1)
        });
        let moment = u64::try_from(moment.as_ns()).unwrap_or_else(|_| {
            self.losses.count(Loss::StampDigits);
            0
        });
        let index = self.interface(out, setting, frame.bus);
        let mut lost = 0;
        if let Some(interface) = self.interfaces.get_mut(index) {
            interface.last_ns = moment;
            lost = std::mem::take(&mut interface.lost);
        }
        block(out, 6, |out| {
            out.extend_from_slice(&(index as u32).to_le_bytes());
            stamp(out, moment);
            let fd = matches!(frame.kind, Kind::Fd { .. });
            let size: u32 = if fd { 72 } else { 16 };
            out.extend_from_slice(&size.to_le_bytes());
            out.extend_from_slice(&size.to_le_bytes());
            socketcan(out, frame);
            let flags: u32 = match frame.dir {
                Some(Direction::Rx) => 1,
                Some(Direction::Tx) => 2,
                None => 0,
            };
            if flags != 0 {
                option(out, 2, &flags.to_le_bytes());
            }
            if lost > 0 {
                option(out, 4, &lost.to_le_bytes());
            }
            if flags != 0 || lost > 0 {
                option(out, 0, &[]);
            }
        });
    }

    /// Counts a gap, which is written with the next frame of its bus.
    pub fn marker(&mut self, out: &mut Vec<u8>, setting: CaptureFacts<'_>, marker: &Marker) {
        match *marker {
            Marker::Dropped { bus, count, .. } => {
                let index = self.interface(out, setting, bus);
                if let Some(interface) = self.interfaces.get_mut(index) {
                    interface.lost = interface.lost.saturating_add(count);
                    interface.lost_in_all = interface.lost_in_all.saturating_add(count);
                }
            }
            Marker::Error { .. } => self.losses.count(Loss::ErrorFrame),
            Marker::LeftOut { .. } => self.losses.count(Loss::Gap),
            Marker::Start { .. } | Marker::Backward { .. } | Marker::Swapped => {}
        }
    }

    /// Appends the losses after the last frames; a file without frames gets its header.
    pub fn finish(&mut self, out: &mut Vec<u8>) {
        self.begin(out);
        for (index, interface) in self.interfaces.iter().enumerate() {
            if interface.lost > 0 {
                block(out, 5, |out| {
                    out.extend_from_slice(&(index as u32).to_le_bytes());
                    stamp(out, interface.last_ns);
                    option(out, 5, &interface.lost_in_all.to_le_bytes());
                    option(out, 0, &[]);
                });
            }
        }
    }

    fn begin(&mut self, out: &mut Vec<u8>) {
        if std::mem::replace(&mut self.begun, true) {
            return;
        }
        block(out, 0x0A0D_0D0A, |out| {
            out.extend_from_slice(&0x1A2B_3C4D_u32.to_le_bytes());
            out.extend_from_slice(&1u16.to_le_bytes());
            out.extend_from_slice(&0u16.to_le_bytes());
            // The length of the section is not known yet.
            out.extend_from_slice(&u64::MAX.to_le_bytes());
            option(out, 4, concat!("canalyze ", env!("CARGO_PKG_VERSION")).as_bytes());
            option(out, 0, &[]);
        });
    }

    /// Returns the index of a bus's interface, describing it if it is new.
    fn interface(&mut self, out: &mut Vec<u8>, setting: CaptureFacts<'_>, bus: BusId) -> usize {
        if let Some(index) = self.interfaces.iter().position(|interface| interface.bus == bus) {
            return index;
        }
        self.begin(out);
        let name = setting.buses.name(bus);
        block(out, 1, |out| {
            out.extend_from_slice(&LINKTYPE_CAN_SOCKETCAN.to_le_bytes());
            // Reserved, and no limit on the length of packets.
            out.extend_from_slice(&[0; 6]);
            option(out, 2, if name.is_empty() { b"can0" } else { name });
            option(out, 9, &[9]);
            option(out, 0, &[]);
        });
        self.interfaces.push(Interface { bus, lost: 0, lost_in_all: 0, last_ns: 0 });
        self.interfaces.len() - 1
    }
}

/// Appends a frame in the structure of SocketCAN, with a big-endian identifier.
fn socketcan(out: &mut Vec<u8>, frame: &Frame) {
    let raw = frame.id.raw();
    let id = match frame.kind {
        Kind::Error => raw | ERROR,
        _ if frame.id.is_extended() => raw | EXTENDED,
        _ => raw,
    };
    let (id, flags, room) = match frame.kind {
        Kind::Fd { brs, esi } => (id, FDF | u8::from(brs) | u8::from(esi) << 1, 64),
        Kind::Remote => (id | REMOTE, 0, 8),
        Kind::Data | Kind::Error => (id, 0, 8),
    };
    let raw_dlc = if flags == 0 { frame.length_form.raw_dlc } else { 0 };
    out.extend_from_slice(&id.to_be_bytes());
    out.extend_from_slice(&[frame.len, flags, 0, raw_dlc]);
    let payload = frame.payload();
    let payload = payload.get(..room).unwrap_or(payload);
    out.extend_from_slice(payload);
    out.resize(out.len() + room - payload.len(), 0);
}

/// Appends a block with its length at both ends.
fn block(out: &mut Vec<u8>, kind: u32, body: impl FnOnce(&mut Vec<u8>)) {
    let start = out.len();
    out.extend_from_slice(&kind.to_le_bytes());
    out.extend_from_slice(&[0; 4]);
    body(out);
    let len = ((out.len() - start + 4) as u32).to_le_bytes();
    out.extend_from_slice(&len);
    if let Some(room) = out.get_mut(start + 4..start + 8) {
        room.copy_from_slice(&len);
    }
}

/// Appends a stamp in two halves, the upper one first.
fn stamp(out: &mut Vec<u8>, units: u64) {
    out.extend_from_slice(&((units >> 32) as u32).to_le_bytes());
    out.extend_from_slice(&(units as u32).to_le_bytes());
}

/// Appends an option, padded to 32 bits.
fn option(out: &mut Vec<u8>, code: u16, value: &[u8]) {
    out.extend_from_slice(&code.to_le_bytes());
    out.extend_from_slice(&(value.len() as u16).to_le_bytes());
    out.extend_from_slice(value);
    out.resize(out.len() + value.len().next_multiple_of(4) - value.len(), 0);
}

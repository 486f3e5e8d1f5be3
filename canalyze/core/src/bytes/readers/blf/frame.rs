//! The frame in an object: CAN messages and errors, classic and CAN FD.

use super::head::{ObjectHead, u16_at, u32_at, u64_at};
use crate::bytes::frame::{Buses, CanId, Direction, Frame, Kind, LengthForm, Stamp, StampForm};
use crate::bytes::ns::Ns;

/// Objects with a frame: type, least number of bytes behind the header, and the bytes that they may have beyond them.
const FRAMES: [(u32, usize, usize); 5] = [(1, 16, 8), (86, 16, 16), (73, 32, 8), (100, 84, 8), (101, 40, 96)];
/// Error frames without details: type and size of the channel that they begin with, in bytes.
const ERRORS: [(u32, usize); 2] = [(2, 2), (104, 1)];
/// The number of python-can's writer, whose error frames are those of SocketCAN.
const PYTHON_CAN: u8 = 5;
/// The flag of a stamp of 10 µs.
const TEN_MICROSECONDS: u32 = 1;
/// The flags of an identifier of 29 bits, of a remote and of a sent frame.
const EXTENDED: u32 = 0x8000_0000;
const REMOTE: u8 = 0x80;
const SENT: u8 = 0x01;
/// Lengths of CAN FD by their codes.
const LENGTHS: [u8; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64];

/// The facts of a file that its frames need.
#[derive(Clone, Copy, Debug)]
pub(super) struct FileFacts {
    pub(super) application: u8,
    /// Stamps are of ns.
    pub(super) fine: bool,
}

/// Returns least and most bytes behind the header of an object with a frame.
pub(super) fn sizes(kind: u32) -> Option<(usize, usize)> {
    FRAMES.iter().find(|(known, ..)| *known == kind).map(|(_, least, more)| (*least, least + more))
}

/// Returns true for an error frame without details.
pub(super) fn is_bare_error(kind: u32) -> bool {
    ERRORS.iter().any(|(known, _)| *known == kind)
}

/// Returns true if the stamp of an object is of ns.
pub(super) fn is_fine(object: &[u8]) -> bool {
    u32_at(object, 16) != TEN_MICROSECONDS
}

/// Returns the bus of a channel: channel 1 is `can0`.
pub(super) fn bus(channel: u16) -> Vec<u8> {
    format!("can{}", channel.saturating_sub(1)).into_bytes()
}

/// Returns true if an object of another type has the form of a frame, so that its type is wrong.
pub(super) fn is_disguised(object: &[u8], head: ObjectHead) -> bool {
    let body = object.get(32..).unwrap_or_default();
    let (channel, dlc, id) = (u16_at(body, 0), body.get(3).copied().unwrap_or(0xFF), u32_at(body, 4));
    let identified = id & 0x6000_0000 == 0 && (id & EXTENDED != 0 || id <= 0x7FF);
    let known = (1..=16).contains(&channel) && identified && head.header == 32 && head.version == 1;
    let zero = |from: usize, to: usize| body.get(from..to).is_some_and(|rest| rest.iter().all(|byte| *byte == 0));
    match head.size {
        48 => known && dlc <= 8 && zero(8 + usize::from(dlc), 16),
        116 => known && dlc <= 15 && body.get(14).is_some_and(|valid| LENGTHS.contains(valid)) && zero(15, 20),
        _ => false,
    }
}

/// Returns the frame of an object and its channel; `None` if its fields contradict each other.
pub(super) fn frame(object: &[u8], head: ObjectHead, source: FileFacts, buses: &mut Buses) -> Option<(Frame, u16)> {
    let behind = if head.version == 1 { 32 } else { 40 };
    let body = object.get(behind..)?;
    let byte = |at: usize| body.get(at).copied().unwrap_or(0);
    let fields = match head.kind {
        1 | 86 => Fields {
            channel: u16_at(body, 0),
            kind: if byte(2) & REMOTE != 0 { Kind::Remote } else { Kind::Data },
            sent: byte(2) & SENT != 0,
            id: u32_at(body, 4),
            dlc: byte(3),
            data: body.get(8..16)?.get(..usize::from(byte(3).min(8)))?,
            size: byte(3).min(8),
        },
        73 if source.application == PYTHON_CAN => {
            let data = body.get(24..32)?;
            Fields {
                channel: u16_at(body, 0),
                kind: Kind::Error,
                sent: false,
                id: u32_at(body, 16),
                dlc: byte(10),
                data: data.get(..usize::from(byte(10).min(8)))?,
                size: byte(10).min(8),
            }
        }
        73 | 2 => Fields::error(u16_at(body, 0)),
        104 => Fields::error(byte(0).into()),
        100 => {
            let (flags, fd, valid) = (byte(2), byte(13), byte(14).min(64));
            Fields {
                channel: u16_at(body, 0),
                kind: match () {
                    () if fd & 1 != 0 => Kind::Fd { brs: fd & 2 != 0, esi: fd & 4 != 0 },
                    () if flags & REMOTE != 0 => Kind::Remote,
                    () => Kind::Data,
                },
                sent: flags & SENT != 0,
                id: u32_at(body, 4),
                dlc: if fd & 1 != 0 { length(byte(3)) } else { byte(3) },
                data: body.get(20..84)?.get(..usize::from(valid))?,
                size: valid,
            }
        }
        _ => {
            let (flags, valid) = (u32_at(body, 12), byte(2));
            let end = match usize::from(byte(35)) {
                0 => head.size,
                offset => offset,
            };
            let there = end.saturating_sub(head.header).saturating_sub(40).min(valid.into());
            let held = body.get(40..).unwrap_or_default();
            Fields {
                channel: byte(0).into(),
                kind: match () {
                    () if flags & 0x1000 != 0 => Kind::Fd { brs: flags & 0x2000 != 0, esi: flags & 0x4000 != 0 },
                    () if flags & 0x10 != 0 => Kind::Remote,
                    () => Kind::Data,
                },
                sent: byte(34) != 0,
                id: u32_at(body, 4),
                dlc: if flags & 0x1000 != 0 { length(byte(1)) } else { byte(1) },
                data: held.get(..there).unwrap_or(held),
                size: valid,
            }
        }
    };
    Some((fields.frame(stamp(object, source.fine), buses)?, fields.channel))
}

/// The fields of a frame, whatever its object.
struct Fields<'a> {
    channel: u16,
    kind: Kind,
    sent: bool,
    id: u32,
    /// Its length, by the DLC.
    dlc: u8,
    data: &'a [u8],
    /// The number of its data bytes; those that the object lacks are 0.
    size: u8,
}

impl Fields<'_> {
    fn error(channel: u16) -> Self {
        Self { channel, kind: Kind::Error, sent: false, id: 0, dlc: 0, data: &[], size: 0 }
    }

    fn frame(&self, stamp: Option<Stamp>, buses: &mut Buses) -> Option<Frame> {
        let (dlc, size) = (self.dlc, self.size);
        // A classic frame may have a DLC above 8.
        let kind = if self.kind == Kind::Data && size > 8 { Kind::Fd { brs: false, esi: false } } else { self.kind };
        let (len, raw_dlc) = match kind {
            Kind::Remote => (dlc.min(8), dlc),
            Kind::Data if dlc != size && (size < 8 || dlc < 8) => return None,
            Kind::Data => (size, dlc),
            Kind::Fd { .. } | Kind::Error => (size, 0),
        };
        if size > 64 {
            return None;
        }
        let mut data = [0; 64];
        let held = if kind == Kind::Remote { &[] } else { self.data };
        for (slot, byte) in data.iter_mut().zip(held) {
            *slot = *byte;
        }
        let (raw, extended) = (self.id & 0x1FFF_FFFF, self.id & EXTENDED != 0);
        Some(Frame {
            no: 0,
            moved: 0,
            corrected_ns: 0,
            line: None,
            t_ns: stamp.map(|stamp| stamp.ns),
            stamp,
            bus: buses.intern(&bus(self.channel)),
            id: match u16::try_from(raw) {
                Ok(short) if !extended && short <= 0x7FF => CanId::standard(short),
                _ => CanId::extended(raw),
            },
            kind,
            dir: Some(if self.sent { Direction::Tx } else { Direction::Rx }),
            len,
            length_form: LengthForm {
                raw_dlc: if (9..16).contains(&raw_dlc) { raw_dlc } else { 0 },
                ..LengthForm::default()
            },
            data,
        })
    }
}

fn length(dlc: u8) -> u8 {
    LENGTHS.get(usize::from(dlc)).copied().unwrap_or(64)
}

/// Returns the stamp since the start of the measurement; `None` if no time has so many ns.
fn stamp(object: &[u8], fine: bool) -> Option<Stamp> {
    let unit = if is_fine(object) { 1 } else { 10_000 };
    let ns = i64::try_from(u64_at(object, 24).checked_mul(unit)?).ok()?;
    Some(Stamp { form: StampForm::Seconds, ns: Ns(ns), width: 1, decimals: if fine { 9 } else { 5 } })
}

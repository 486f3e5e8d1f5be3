//! The content of a packet: a CAN frame after SocketCAN's header, bare or in a cooked capture.
//!
//! In LINKTYPE_CAN_SOCKETCAN the identifier is big-endian (but see `identifiers`). After a cooked header it is in the
//! order of the host that wrote the file, like the file's own numbers: libpcap swaps it accordingly for files from
//! other hosts. Frames with missing bytes are rejected.

use super::ByteOrder;
use super::tally::Passed;
use crate::bytes::frame::{BusId, CanId, Direction, Frame, Kind, LengthForm};
use crate::bytes::readers::Unreadable;

const EXTENDED: u32 = 0x8000_0000;
const REMOTE: u32 = 0x4000_0000;
const ERROR: u32 = 0x2000_0000;

const BRS: u8 = 1;
const ESI: u8 = 2;
const FDF: u8 = 4;
/// The flag of a CAN XL frame, in the byte that holds the length of other frames.
const XLF: u8 = 0x80;

/// Sizes of SocketCAN's full structures in bytes: a classic frame, an FD frame.
const CLASSIC_SIZE: u32 = 16;
const FD_SIZE: u32 = 72;

/// Link types that can carry frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Link {
    /// LINKTYPE_CAN_SOCKETCAN.
    SocketCan,
    /// LINKTYPE_LINUX_SLL: captures on `any`, with the kind of packet and its protocol.
    Cooked,
    /// LINKTYPE_LINUX_SLL2: the same with the number of the interface.
    Cooked2,
    /// LINKTYPE_WIRESHARK_UPPER_PDU: Wireshark's form of logs of candump and BUSMASTER.
    Upper,
    /// Another link type.
    Other(u16),
}

impl Link {
    pub(super) fn new(link_type: u16) -> Self {
        match link_type {
            227 => Self::SocketCan,
            113 => Self::Cooked,
            252 => Self::Upper,
            276 => Self::Cooked2,
            other => Self::Other(other),
        }
    }

    pub(super) fn is_can(self) -> bool {
        !matches!(self, Self::Other(_))
    }
}

/// The frame of a packet.
#[derive(Debug)]
pub(super) struct LinkFrame {
    /// The frame without its bus and time.
    pub(super) frame: Frame,
    /// The host's number of the interface, if the packet has it.
    pub(super) interface: Option<u32>,
}

/// The reason for a packet without a frame.
#[derive(Debug)]
pub(super) enum Failed {
    Passed(Passed),
    Unreadable(Unreadable),
}

/// Returns the frame of a packet with `bytes` captured of `size` on the wire. `orders`: the byte orders of the file's
/// numbers, and of identifiers of LINKTYPE_CAN_SOCKETCAN.
#[inline(always)]
pub(super) fn frame(link: Link, bytes: &[u8], size: u32, orders: (ByteOrder, ByteOrder)) -> Result<LinkFrame, Failed> {
    let (order, identifiers) = orders;
    if link == Link::SocketCan {
        let frame = socketcan(bytes, size, identifiers, None).map_err(Failed::Unreadable)?;
        return Ok(LinkFrame { frame, interface: None });
    }
    if link == Link::Upper { upper(bytes, size, order) } else { cooked(link, bytes, size, order) }
}

fn cooked(link: Link, bytes: &[u8], size: u32, order: ByteOrder) -> Result<LinkFrame, Failed> {
    let short = Failed::Unreadable(Unreadable::Data);
    let (head, protocol, kind, interface, rest) = match link {
        Link::Cooked => {
            let Some((head @ [k0, k1, .., p0, p1], rest)) = bytes.split_first_chunk::<16>() else { return Err(short) };
            (head.len(), [*p0, *p1], u16::from_be_bytes([*k0, *k1]), None, rest)
        }
        Link::Cooked2 => {
            let Some((head, rest)) = bytes.split_first_chunk::<20>() else { return Err(short) };
            let [p0, p1, _, _, i0, i1, i2, i3, _, _, kind, ..] = *head;
            (head.len(), [p0, p1], u16::from(kind), Some(u32::from_be_bytes([i0, i1, i2, i3])), rest)
        }
        Link::Other(link_type) => return Err(Failed::Passed(Passed::Packet(link_type))),
        Link::SocketCan | Link::Upper => return Err(short),
    };
    let fd = match u16::from_be_bytes(protocol) {
        0x000C => false,
        0x000D => true,
        0x000E => return Err(Failed::Unreadable(Unreadable::CanXl)),
        other => return Err(Failed::Passed(Passed::Protocol(other))),
    };
    let mut frame =
        socketcan(rest, size.saturating_sub(head as u32), order, fd.then_some(true)).map_err(Failed::Unreadable)?;
    frame.dir = match kind {
        0 | 2 | 3 => Some(Direction::Rx),
        4 => Some(Direction::Tx),
        // A frame that a CAN driver receives is a broadcast, and so is the host's own frame that is looped back.
        // libpcap drops the outgoing packet for that reason, so this kind shows no direction.
        _ => None,
    };
    Ok(LinkFrame { frame, interface })
}

/// Parses a frame after tags, one of which names its kind.
fn upper(bytes: &[u8], size: u32, order: ByteOrder) -> Result<LinkFrame, Failed> {
    const NAME: u16 = 12;
    let other = Failed::Passed(Passed::Packet(252));
    let (mut rest, mut fd) = (bytes, None);
    loop {
        let Some(([t0, t1, l0, l1], after)) = rest.split_first_chunk::<4>() else { return Err(other) };
        let (tag, len) = (u16::from_be_bytes([*t0, *t1]), u16::from_be_bytes([*l0, *l1]));
        let Some((value, after)) = after.split_at_checked(usize::from(len)) else { return Err(other) };
        rest = after;
        match tag {
            0 => break,
            NAME => {
                let end = value.iter().position(|byte| *byte == 0).unwrap_or(value.len());
                fd = match value.get(..end) {
                    Some(b"can-hostendian") => Some(false),
                    Some(b"canfd") => Some(true),
                    _ => None,
                };
            }
            _ => {}
        }
    }
    let head = (bytes.len() - rest.len()) as u32;
    let frame = socketcan(rest, size.saturating_sub(head), order, fd.ok_or(other)?.then_some(true))
        .map_err(Failed::Unreadable)?;
    Ok(LinkFrame { frame, interface: None })
}

/// Parses a frame after SocketCAN's header. `fd`: true for an FD frame, if known from elsewhere.
#[inline(always)]
pub(super) fn socketcan(bytes: &[u8], size: u32, order: ByteOrder, fd: Option<bool>) -> Result<Frame, Unreadable> {
    let (head, payload) = bytes.split_first_chunk::<8>().ok_or(Unreadable::Data)?;
    let [i0, i1, i2, i3, len, flags, reserved, dlc] = *head;
    let id = order.u32([i0, i1, i2, i3]);
    if len & XLF != 0 {
        return Err(Unreadable::CanXl);
    }
    // Old programs left the bytes after the length uninitialized.
    let clean = flags & !(BRS | ESI | FDF) == 0 && reserved == 0;
    // Without a flag, the size of the structure decides; only FD has more than 8 bytes.
    let fd = fd.unwrap_or(
        clean && dlc == 0 && flags & FDF != 0
            || size == FD_SIZE && id & (REMOTE | ERROR) == 0
            || len > 8 && size > CLASSIC_SIZE,
    );
    let kind = match id & (REMOTE | ERROR) {
        0 if fd => Kind::Fd { brs: clean && flags & BRS != 0, esi: clean && flags & ESI != 0 },
        0 => Kind::Data,
        REMOTE if !fd => Kind::Remote,
        ERROR if !fd => Kind::Error,
        _ => return Err(Unreadable::Identifier),
    };
    if len > if fd { 64 } else { 8 } {
        return Err(Unreadable::Length);
    }
    let raw = id & 0x1FFF_FFFF;
    let id = match raw {
        _ if id & EXTENDED != 0 || kind == Kind::Error => CanId::extended(raw),
        0..=0x7FF => CanId::standard(raw as u16),
        _ => return Err(Unreadable::Identifier),
    };
    let mut data = [0; 64];
    if kind != Kind::Remote {
        let taken = payload.get(..usize::from(len)).ok_or(Unreadable::Data)?;
        data.get_mut(..usize::from(len)).ok_or(Unreadable::Length)?.copy_from_slice(taken);
    }
    let raw_dlc = matches!(kind, Kind::Data | Kind::Remote) && len == 8 && flags == 0 && reserved == 0;
    let raw_dlc = if raw_dlc && (9..=15).contains(&dlc) { dlc } else { 0 };
    Ok(Frame {
        no: 0,
        moved: 0,
        corrected_ns: 0,
        line: None,
        t_ns: None,
        stamp: None,
        bus: BusId(0),
        id,
        kind,
        dir: None,
        len,
        length_form: LengthForm { raw_dlc, ..LengthForm::default() },
        data,
    })
}

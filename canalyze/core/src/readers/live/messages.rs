//! What one `recvmmsg(2)` leaves, in this host's own layout: `n` structures `mmsghdr`, then `n` slots of [`SLOT`] bytes.
//!
//! A slot has 72 bytes for the frame (`struct can_frame`, 16 bytes, or `struct canfd_frame`, 72) and 128 for the control
//! messages: SO_TIMESTAMPNS, SO_TIMESTAMPING, SO_RXQ_OVFL. Pointers in the headers mean nothing any more and are not
//! looked at. Must not: take a frame that was cut, or trust a length.

use crate::frame::{Direction, Frame, Stamp, StampForm};
use crate::readers::{Unreadable, pcap};

/// Bytes of a slot.
pub(super) const SLOT: usize = FRAME + CONTROL;
/// Bytes of a slot for the frame.
pub(super) const FRAME: usize = 72;
/// Bytes of a slot for control messages.
pub(super) const CONTROL: usize = 128;
/// Bytes of `struct can_frame`.
const CLASSIC: usize = 16;
/// Bytes of a pointer and of `size_t`.
const WORD: usize = size_of::<usize>();
/// Where in `struct mmsghdr` its fields are, in bytes: `msg_controllen`, `msg_flags`, `msg_len`; and its own size.
const LAYOUT: [usize; 4] = if WORD == 8 { [40, 48, 56, 64] } else { [20, 24, 28, 32] };

/// `MSG_DONTROUTE`: this host has sent the frame.
const SENT: u32 = 0x4;
/// `MSG_CTRUNC`: control messages had no room.
const CONTROL_CUT: u32 = 0x8;
/// `MSG_TRUNC`: the frame had no room.
const CUT: u32 = 0x20;
const SOL_SOCKET: u32 = 1;
/// `SO_TIMESTAMPNS` with times as wide as a word, and with 64 bits.
const TIMESTAMPNS: [u32; 2] = [35, 64];
/// `SO_TIMESTAMPING`, the same.
const TIMESTAMPING: [u32; 2] = [37, 65];
const RXQ_OVFL: u32 = 40;

/// Bytes of so many messages; `None` if they would be more than there can be.
pub(super) fn size(count: i64) -> Option<u64> {
    let [.., header] = LAYOUT;
    u64::try_from(count).ok()?.checked_mul((header + SLOT) as u64)
}

/// The messages of a block; `None` for one whose header cannot be.
pub(super) fn of(body: &[u8], count: i64) -> impl Iterator<Item = Option<Message<'_>>> {
    let [.., header] = LAYOUT;
    let headers = body.len() / (header + SLOT) * header;
    let (headers, slots) = body.split_at_checked(headers).unwrap_or_default();
    let count = usize::try_from(count).unwrap_or(0);
    headers
        .chunks_exact(header)
        .zip(slots.chunks_exact(SLOT))
        .take(count)
        .map(|(header, slot)| Message::new(header, slot))
}

/// One message.
#[derive(Debug)]
pub(super) struct Message<'a> {
    /// The bytes that were received, if they are of a frame.
    frame: Option<&'a [u8]>,
    flags: u32,
    /// Kernel's time and adapter's, in ns.
    kernel: Option<i64>,
    hardware: Option<i64>,
    /// What the socket has lost before it, since it was opened, in 32 bits.
    pub(super) overflow: Option<u32>,
}

impl<'a> Message<'a> {
    fn new(header: &[u8], slot: &'a [u8]) -> Option<Self> {
        let [control_at, flags_at, len_at, _] = LAYOUT;
        let (frame, control) = slot.split_at_checked(FRAME)?;
        let (flags, len) = (u32_at(header, flags_at)?, u32_at(header, len_at)? as usize);
        let frame = frame.get(..len).filter(|_| matches!(len, CLASSIC | FRAME) && flags & CUT == 0);
        let mut message = Self { frame, flags, kernel: None, hardware: None, overflow: None };
        let control = control.get(..word_at(header, control_at)?).filter(|_| flags & CONTROL_CUT == 0);
        message.control(control.unwrap_or_default());
        Some(message)
    }

    /// Takes the control messages: each a length (that of its head too), a level and a kind, its data behind, and filled
    /// up to whole words.
    fn control(&mut self, mut rest: &[u8]) {
        const HEAD: usize = (WORD + 8).next_multiple_of(WORD);
        loop {
            let (Some(len), Some(level), Some(kind)) = (word_at(rest, 0), u32_at(rest, WORD), u32_at(rest, WORD + 4))
            else {
                return;
            };
            let Some(data) = rest.get(HEAD..len) else { return };
            if level == SOL_SOCKET {
                match kind {
                    RXQ_OVFL => self.overflow = u32_at(data, 0),
                    _ if TIMESTAMPNS.contains(&kind) => self.kernel = time(data, 1, 0),
                    _ if TIMESTAMPING.contains(&kind) => {
                        self.hardware = time(data, 3, 2);
                        self.kernel = self.kernel.or_else(|| time(data, 3, 0));
                    }
                    _ => {}
                }
            }
            let Some(behind) = rest.get(len.next_multiple_of(WORD)..) else { return };
            rest = behind;
        }
    }

    /// The frame, on no bus yet. `hardware`: with the adapter's stamp if it has one.
    pub(super) fn frame(&self, hardware: bool) -> Result<Frame, Unreadable> {
        let bytes = self.frame.ok_or(Unreadable::Data)?;
        let frame = pcap::native(bytes, bytes.len() == FRAME)?;
        let stamp = match (self.hardware.filter(|_| hardware), self.kernel) {
            (Some(ns), _) => Some((ns, 9)),
            // As candump writes them: the kernel's own are no finer than that anyway.
            (None, Some(ns)) => Some((ns.saturating_sub(ns.rem_euclid(1_000)), 6)),
            (None, None) => None,
        };
        let stamp = stamp.map(|(ns, decimals)| Stamp { form: StampForm::Seconds, ns, width: 10, decimals });
        let dir = Some(if self.flags & SENT != 0 { Direction::Tx } else { Direction::Rx });
        Ok(Frame { t_ns: stamp.map(|stamp| stamp.ns), stamp, dir, ..frame })
    }
}

/// The time at a place among `times` structures `timespec`, in ns; `None` where it is zero, which is none.
fn time(data: &[u8], times: usize, place: usize) -> Option<i64> {
    let size = data.len() / times;
    let one = data.get(place * size..)?;
    let (seconds, ns) = match size {
        16 => (i64_at(one, 0)?, i64_at(one, 8)?),
        8 => (i64::from(u32_at(one, 0)? as i32), i64::from(u32_at(one, 4)? as i32)),
        _ => return None,
    };
    seconds.checked_mul(1_000_000_000)?.checked_add(ns).filter(|ns| *ns != 0)
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..)?.first_chunk().map(|bytes| u32::from_ne_bytes(*bytes))
}

fn i64_at(bytes: &[u8], at: usize) -> Option<i64> {
    bytes.get(at..)?.first_chunk().map(|bytes| i64::from_ne_bytes(*bytes))
}

fn word_at(bytes: &[u8], at: usize) -> Option<usize> {
    bytes.get(at..)?.first_chunk().map(|bytes| usize::from_ne_bytes(*bytes))
}

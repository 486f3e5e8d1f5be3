//! The result of one `recvmmsg(2)` in this host's layout: `n` structures `mmsghdr`, then `n` slots of [`SLOT`] bytes.
//!
//! A slot has 72 bytes for the frame (`struct can_frame`, 16 bytes, or `struct canfd_frame`, 72) and 128 for the
//! control messages: SO_TIMESTAMPNS, SO_TIMESTAMPING, SO_RXQ_OVFL. Pointers in the headers are invalid and ignored.
//! Lengths are checked, and truncated frames rejected.

use crate::bytes::frame::{Direction, Frame, Stamp, StampForm};
use crate::bytes::ns::Ns;
use crate::bytes::readers::{Unreadable, pcap};

/// Size of a slot in bytes.
pub(super) const SLOT: usize = FRAME + CONTROL;
/// Size of a slot's part for the frame, in bytes.
pub(super) const FRAME: usize = 72;
/// Size of a slot's part for control messages, in bytes.
pub(super) const CONTROL: usize = 128;
/// Size of `struct can_frame` in bytes.
const CLASSIC: usize = 16;

/// The layout of this host's structures.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    /// Size of a pointer and of `size_t` in bytes, to which everything is padded.
    word: usize,
    /// Offsets in `struct mmsghdr` of `msg_controllen`, `msg_flags` and `msg_len`; and its size.
    control_len: usize,
    flags: usize,
    len: usize,
    size: usize,
}

impl Layout {
    pub(super) const WIDE: Self = Self { word: 8, control_len: 40, flags: 48, len: 56, size: 64 };
    pub(super) const NARROW: Self = Self { word: 4, control_len: 20, flags: 24, len: 28, size: 32 };
    /// The layout of this host.
    pub(super) const NATIVE: Self = if size_of::<usize>() == 8 { Self::WIDE } else { Self::NARROW };

    /// Returns the size of `count` messages in bytes; `None` if it is impossible.
    pub(super) fn bytes(self, count: i64) -> Option<u64> {
        u64::try_from(count).ok()?.checked_mul((self.size + SLOT) as u64)
    }

    /// Iterates over the messages of a block.
    pub(super) fn messages(self, body: &[u8]) -> impl Iterator<Item = LiveMessage<'_>> {
        let headers = body.len() / (self.size + SLOT) * self.size;
        let (headers, slots) = body.split_at_checked(headers).unwrap_or_default();
        let both = headers.chunks_exact(self.size).zip(slots.chunks_exact(SLOT));
        both.filter_map(move |(header, slot)| self.message(header, slot))
    }

    fn message<'a>(self, header: &[u8], slot: &'a [u8]) -> Option<LiveMessage<'a>> {
        let (frame, control) = slot.split_at_checked(FRAME)?;
        let (flags, len) = (u32_at(header, self.flags)?, u32_at(header, self.len)? as usize);
        let frame = frame.get(..len).filter(|_| matches!(len, CLASSIC | FRAME) && flags & CUT == 0);
        let mut message = LiveMessage { frame, flags, kernel: None, hardware: None, overflow: None };
        let control = control.get(..self.word(header, self.control_len)?).filter(|_| flags & CONTROL_CUT == 0);
        self.control(control.unwrap_or_default(), &mut message);
        Some(message)
    }

    /// Parses the control messages: a length (including its head), a level and a kind, and the data, padded to whole
    /// words.
    fn control(self, mut rest: &[u8], message: &mut LiveMessage<'_>) {
        let head = (self.word + 8).next_multiple_of(self.word);
        loop {
            let level = u32_at(rest, self.word);
            let (Some(len), Some(level), Some(kind)) = (self.word(rest, 0), level, u32_at(rest, self.word + 4)) else {
                return;
            };
            let Some(data) = rest.get(head..len) else { return };
            if level == SOL_SOCKET {
                match kind {
                    RXQ_OVFL => message.overflow = u32_at(data, 0),
                    _ if TIMESTAMPNS.contains(&kind) => message.kernel = time(data, 1, 0),
                    _ if TIMESTAMPING.contains(&kind) => {
                        message.hardware = time(data, 3, 2);
                        message.kernel = message.kernel.or_else(|| time(data, 3, 0));
                    }
                    _ => {}
                }
            }
            let Some(behind) = rest.get(len.next_multiple_of(self.word)..) else { return };
            rest = behind;
        }
    }

    fn word(self, bytes: &[u8], at: usize) -> Option<usize> {
        let word = if self.word == 8 { i64_at(bytes, at)? as u64 } else { u64::from(u32_at(bytes, at)?) };
        usize::try_from(word).ok()
    }
}

/// `MSG_DONTROUTE`: this host sent the frame.
const SENT: u32 = 0x4;
/// `MSG_CTRUNC`: control messages were truncated.
const CONTROL_CUT: u32 = 0x8;
/// `MSG_TRUNC`: the frame was truncated.
const CUT: u32 = 0x20;
const SOL_SOCKET: u32 = 1;
/// `SO_TIMESTAMPNS` with times of word size, and of 64 bits.
const TIMESTAMPNS: [u32; 2] = [35, 64];
/// `SO_TIMESTAMPING` with times of word size, and of 64 bits.
const TIMESTAMPING: [u32; 2] = [37, 65];
const RXQ_OVFL: u32 = 40;

/// One message.
#[derive(Debug)]
pub(super) struct LiveMessage<'a> {
    /// The received bytes, if they are a frame.
    frame: Option<&'a [u8]>,
    flags: u32,
    /// Times of the kernel and of the adapter, in ns.
    kernel: Option<i64>,
    hardware: Option<i64>,
    /// Number of frames that the socket had lost before, since it was opened, modulo 2^32.
    pub(super) overflow: Option<u32>,
}

impl LiveMessage<'_> {
    /// Returns the frame with the kernel's stamp, without a bus.
    pub(super) fn frame(&self) -> Result<Frame, Unreadable> {
        // In µs, as candump writes it.
        let cut = |ns: i64| (ns.saturating_sub(ns.rem_euclid(1_000)), 6);
        self.stamped(self.kernel.map(cut))
    }

    /// Returns the frame with the adapter's stamp. `ahead`: the lead of the adapter's clock over the kernel's, from a
    /// message with both; with it, frames without an adapter stamp (sent frames, errors made by the driver) keep their
    /// place.
    pub(super) fn frame_by_hardware(&self, ahead: &mut Option<i64>) -> Result<Frame, Unreadable> {
        if let (Some(hardware), Some(kernel)) = (self.hardware, self.kernel) {
            *ahead = Some(hardware.saturating_sub(kernel));
        }
        match self.hardware.or_else(|| Some(self.kernel?.saturating_add((*ahead)?))) {
            Some(ns) => self.stamped(Some((ns, 9))),
            None => self.frame(),
        }
    }

    /// Returns the frame with this stamp in ns and number of decimals.
    fn stamped(&self, stamp: Option<(i64, u8)>) -> Result<Frame, Unreadable> {
        let bytes = self.frame.ok_or(Unreadable::Data)?;
        let frame = pcap::native(bytes, bytes.len() == FRAME)?;
        let stamp = stamp.map(|(ns, decimals)| Stamp { form: StampForm::Seconds, ns: Ns(ns), width: 10, decimals });
        let dir = Some(if self.flags & SENT != 0 { Direction::Tx } else { Direction::Rx });
        Ok(Frame { t_ns: stamp.map(|stamp| stamp.ns), stamp, dir, ..frame })
    }
}

/// Returns the time at an index among `times` structures `timespec`, in ns; `None` for zero.
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

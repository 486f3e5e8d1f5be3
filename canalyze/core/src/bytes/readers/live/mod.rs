//! Live buses: blocks of the program's own receivers, as passed on by `sources/live.py`.
//!
//! This is not a file format: it is not recognized by its first bytes, and users cannot select it. A block is a head of
//! 16 bytes, little-endian, followed by data that depend on its kind.
//!
//! | offset | head |
//! |---|---|
//! | 0 | `u8` kind |
//! | 1 | `u8` bus, an index of the stream's own |
//! | 2 | `u8` which |
//! | 3 | `u8` 0 |
//! | 4 | `u32` bytes after the head |
//! | 8 | `i64` number |
//!
//! | kind | which | number | after the head |
//! |---|---|---|---|
//! | 1 bus: the name of an index, before the first use of each of its sockets | 0 | 0 | the name |
//! | 2 messages: the result of one `recvmmsg` of SocketCAN | 0 kernel stamps, 1 hardware stamps if available | count | see `messages` |
//! | 3 records: frames of `packed`; its buses and other records are ignored | 0 | 0 | whole records |
//! | 4 dropped: frames are missing | 0 lost by kernel or driver, 1 discarded since the output was not read | count | |
//! | 5 until: all frames with this stamp or an earlier one have come; `i64::MAX`: all have, and time stops | 0 | ns | |
//! | 6 gap: the bus cannot be received from here on | 0 frames may be missing, 1 the bus is away | 0 | |
//!
//! Frames of one bus keep their order. Those of several buses are joined by their stamps among the items `held` until
//! the next `until`. The stream is not trusted: anything else ends it with one damage.

use crate::bytes::ns::Ns;

mod held;
mod messages;
#[cfg(test)]
mod tests;

use self::held::HeldItems;
use self::messages::Layout;
use super::packed::Packed;
use super::{Damage, DamageKind, FilePlace, Item, Marker, in_pieces};
use crate::bytes::frame::{BusId, Buses, Frame};

/// Size of a head in bytes.
pub const HEAD: usize = 16;
/// Maximum number of bytes after a head, many times the size that a receiver delivers at once.
const LONGEST: u32 = 1 << 24;
/// Number of bus indexes.
const BUSES: usize = 256;

/// The kinds of blocks.
pub mod kind {
    /// The name of a bus.
    pub const BUS: u8 = 1;
    /// The result of one `recvmmsg`.
    pub const MESSAGES: u8 = 2;
    /// Records of `packed`.
    pub const RECORDS: u8 = 3;
    /// Frames are missing.
    pub const DROPPED: u8 = 4;
    /// The current time.
    pub const UNTIL: u8 = 5;
    /// The bus cannot be received.
    pub const GAP: u8 = 6;
}

/// The state of one bus.
#[derive(Clone, Copy, Debug)]
struct LiveChannel {
    id: BusId,
    /// The count of losses of its socket, since it was opened.
    overflow: u32,
    /// Total number of lost frames.
    lost: u64,
    /// The lead of its adapter's clock over the kernel's in ns, if it has one.
    ahead: Option<i64>,
}

/// The reader of live buses.
#[derive(Debug)]
pub struct Live {
    /// The beginning of an incomplete block.
    rest: Vec<u8>,
    /// Number of bytes of the stream before `rest`.
    taken: u64,
    /// Buses by the stream's own index.
    channels: Vec<Option<LiveChannel>>,
    held: HeldItems,
    broken: bool,
}

impl Default for Live {
    fn default() -> Self {
        Self { rest: Vec::new(), taken: 0, channels: vec![None; BUSES], held: HeldItems::default(), broken: false }
    }
}

/// The head of a block.
#[derive(Clone, Copy, Debug)]
struct Head {
    kind: u8,
    bus: u8,
    which: u8,
    zero: u8,
    length: u32,
    number: i64,
}

impl Head {
    fn new(bytes: &[u8; HEAD]) -> Self {
        let [kind, bus, which, zero, l0, l1, l2, l3, n0, n1, n2, n3, n4, n5, n6, n7] = *bytes;
        let length = u32::from_le_bytes([l0, l1, l2, l3]);
        Self { kind, bus, which, zero, length, number: i64::from_le_bytes([n0, n1, n2, n3, n4, n5, n6, n7]) }
    }

    /// Returns true if it is a valid head.
    fn is_sound(self) -> bool {
        let Self { kind, which, zero, length, number, .. } = self;
        zero == 0
            && length <= LONGEST
            && match kind {
                kind::BUS | kind::RECORDS => which == 0,
                kind::MESSAGES => which <= 1 && number >= 0 && Layout::NATIVE.bytes(number) == Some(u64::from(length)),
                kind::DROPPED => which <= 1 && length == 0 && number >= 0,
                kind::UNTIL => which == 0 && length == 0,
                kind::GAP => which <= 1 && length == 0,
                _ => false,
            }
    }
}

impl Live {
    /// Feeds the next bytes, in any chunking.
    pub fn feed(&mut self, bytes: &[u8], buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        if self.broken {
            return;
        }
        let rest = std::mem::take(&mut self.rest);
        self.rest = in_pieces(rest, bytes, |bytes| self.blocks(bytes, buses, sink));
    }

    /// Ends the stream.
    pub fn finish(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let cut = (!self.rest.is_empty()).then_some(self.rest.len() as u64);
        self.interrupt(buses, sink);
        if let Some(bytes) = cut.filter(|_| !self.broken) {
            let place = FilePlace::Byte(self.taken);
            sink(Item::Damaged(Damage { place, kind: DamageKind::Cut, bytes: Some(bytes), frames: None }), buses);
        }
    }

    /// Ends an interrupted stream, ignoring an incomplete block.
    pub fn interrupt(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.rest.clear();
        self.held.release(None, |item| sink(item, buses));
    }

    /// Reads complete blocks and returns the number of bytes consumed.
    fn blocks(&mut self, bytes: &[u8], buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) -> usize {
        let mut used = 0;
        while let Some((head, behind)) = bytes.get(used..).and_then(<[u8]>::split_first_chunk::<HEAD>) {
            let head = Head::new(head);
            let sound = head.is_sound();
            let size = head.length as usize;
            if sound && behind.len() < size {
                break;
            }
            let body = behind.get(..size).filter(|_| sound);
            if body.and_then(|body| self.block(head, body, buses, sink)).is_none() {
                self.held.release(None, |item| sink(item, buses));
                let place = FilePlace::Byte(self.taken);
                sink(Item::Damaged(Damage { place, kind: DamageKind::Rest, bytes: None, frames: None }), buses);
                self.broken = true;
                return bytes.len();
            }
            used += HEAD + size;
            self.taken += (HEAD + size) as u64;
        }
        used
    }

    /// Processes a block; `None` if it is invalid.
    fn block(&mut self, head: Head, body: &[u8], buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) -> Option<()> {
        let index = usize::from(head.bus);
        match head.kind {
            kind::BUS => {
                let slot = self.channels.get_mut(index)?;
                let id = buses.intern(body);
                // Its total of losses continues after a gap.
                let lost = slot.filter(|known| known.id == id).map_or(0, |known| known.lost);
                *slot = Some(LiveChannel { id, overflow: 0, lost, ahead: None });
                self.held.joins = self.channels.iter().flatten().count() > 1;
                return Some(());
            }
            kind::UNTIL => {
                let moment = (head.number < i64::MAX).then_some(Ns(head.number));
                self.held.release(moment, |item| sink(item, buses));
                if let Some(now_ns) = moment {
                    sink(Item::Until { now_ns }, buses);
                }
                return Some(());
            }
            _ => {}
        }
        // A bus that has not been named makes the block invalid.
        let channel = self.channels.get_mut(index)?.as_mut()?;
        let held = &mut self.held;
        let mut give = |item: Item| held.take(head.bus, item, |item| sink(item, buses));
        match head.kind {
            kind::MESSAGES => {
                for message in Layout::NATIVE.messages(body) {
                    if let Some(total) = message.overflow {
                        channel.overflowed(total).map(&mut give);
                    }
                    let frame = match head.which {
                        0 => message.frame(),
                        _ => message.frame_by_hardware(&mut channel.ahead),
                    };
                    give(match frame {
                        Ok(frame) => Item::Frame(Frame { bus: channel.id, ..frame }),
                        Err(reason) => Item::Unreadable { place: FilePlace::Live, reason },
                    });
                }
            }
            kind::RECORDS => {
                let (mut records, mut own, mut whole) = (Packed::default(), Buses::default(), true);
                let mut take = |item, _: &Buses| match item {
                    Item::Frame(frame) => give(Item::Frame(Frame { bus: channel.id, line: None, ..frame })),
                    Item::Damaged(_) => whole = false,
                    _ => {}
                };
                records.feed(body, &mut own, &mut take);
                records.finish(&mut own, &mut take);
                return whole.then_some(());
            }
            kind::DROPPED => give(channel.dropped(head.number.unsigned_abs())),
            kind::GAP => give(Item::Gap { bus: channel.id, away: head.which > 0 }),
            _ => return None,
        }
        Some(())
    }
}

impl LiveChannel {
    /// Adds lost frames and returns their marker.
    fn dropped(&mut self, count: u64) -> Item {
        self.lost = self.lost.saturating_add(count);
        Item::Marker(Marker::Dropped { bus: self.id, count, total: self.lost, place: FilePlace::Live })
    }

    /// Processes the socket's count of losses, modulo 2^32.
    fn overflowed(&mut self, total: u32) -> Option<Item> {
        let before = std::mem::replace(&mut self.overflow, total);
        let count = total.wrapping_sub(before);
        // A socket that was opened anew counts from zero.
        let count = if count > u32::MAX / 2 { total } else { count };
        (count > 0).then(|| self.dropped(u64::from(count)))
    }
}

//! pcapng files: sections of blocks, each with its length at both ends.
//!
//! If the two lengths of a block differ, the search continues for the next valid block: one of a known type with the
//! same length at both ends. Packets are parsed here; blocks of interfaces are left to pcap-parser, except for numbers
//! in their options, which it always reads as little-endian.

use pcap_parser::{
    PcapNGOption, parse_interfacedescriptionblock_be, parse_interfacedescriptionblock_le,
    parse_interfacestatisticsblock_be, parse_interfacestatisticsblock_le, parse_sectionheaderblock,
};

use super::interface::{Interface, InterfaceClock, Packet};
use super::tally::{Passed, Tally};
use super::{ByteOrder, RecordStep};
use crate::bytes::frame::{Buses, Direction};
use crate::bytes::readers::{Damage, DamageKind, FilePlace, Item, Unreadable};

const SECTION: u32 = 0x0A0D_0D0A;
const INTERFACE: u32 = 1;
/// The packet block of old drafts.
const OBSOLETE_PACKET: u32 = 2;
const SIMPLE_PACKET: u32 = 3;
const STATISTICS: u32 = 5;
const ENHANCED_PACKET: u32 = 6;
/// Types searched for after a damaged block.
const SOUGHT: &[u32] =
    &[SECTION, INTERFACE, OBSOLETE_PACKET, SIMPLE_PACKET, 4, STATISTICS, ENHANCED_PACKET, 9, 10, 0xBAD, 0x4000_0BAD];

/// Size of type, length, and the length again (in a section header its byte-order mark instead), in bytes.
const SHORTEST: usize = 12;
/// Maximum length of a valid block, in bytes.
const LONGEST: usize = 16 << 20;
/// Maximum length of a block in a search, in bytes.
const LONGEST_SOUGHT: usize = 64 << 10;
/// Maximum number of interfaces of a section.
const MAX_INTERFACES: usize = 4096;

/// The section that is being read.
#[derive(Debug, Default)]
pub(super) struct Blocks {
    /// `None` before the first section header.
    order: Option<ByteOrder>,
    interfaces: Vec<Interface>,
    seeking: Option<Seeking>,
}

/// A damaged part of the file.
#[derive(Clone, Copy, Debug)]
struct Seeking {
    from: u64,
    /// True if the file may just end within a block.
    cut: bool,
}

/// The beginning of a block.
#[derive(Clone, Copy, Debug)]
struct BlockHead {
    kind: u32,
    len: usize,
    order: ByteOrder,
}

impl Blocks {
    /// Returns true while it searches for a valid block.
    pub(super) fn seeks(&self) -> bool {
        self.seeking.is_some()
    }

    /// Reads a block. `last`: there are no further bytes.
    #[inline(always)]
    pub(super) fn step(
        &mut self,
        bytes: &[u8],
        at: u64,
        last: bool,
        tally: &mut Tally,
        buses: &mut Buses,
        sink: &mut impl FnMut(Item, &Buses),
    ) -> RecordStep {
        if self.seeking.is_some() {
            return self.seek(bytes, at, last, buses, sink);
        }
        let Some(start) = bytes.first_chunk::<SHORTEST>() else {
            return self.incomplete(bytes, at, last, SHORTEST, buses, sink);
        };
        let Some(head) = self.head(start).filter(|head| (SHORTEST..=LONGEST).contains(&head.len)) else {
            return self.damaged(bytes, at, last, buses, sink);
        };
        let Some(block) = bytes.get(..head.len) else {
            return self.incomplete(bytes, at, last, head.len, buses, sink);
        };
        let Some(body) = body(block, head) else { return self.damaged(bytes, at, last, buses, sink) };
        let sound = match head.kind {
            ENHANCED_PACKET | OBSOLETE_PACKET => self.packet(body, head, at, tally, buses, sink),
            _ => self.other(block, body, head, at, tally, buses, sink),
        };
        if sound.is_none() {
            let bytes = Some(head.len as u64);
            let damage = Damage { place: FilePlace::Byte(at), kind: DamageKind::Structure, bytes, frames: None };
            sink(Item::Damaged(damage), buses);
        }
        RecordStep::Took(head.len)
    }

    /// Parses the beginning of a block; `None` if it is invalid.
    #[inline(always)]
    fn head(&self, [k0, k1, k2, k3, l0, l1, l2, l3, mark @ ..]: &[u8; SHORTEST]) -> Option<BlockHead> {
        let [kind, len] = [[*k0, *k1, *k2, *k3], [*l0, *l1, *l2, *l3]];
        let order = match self.order {
            // The type of a section header is the same in both orders.
            _ if u32::from_le_bytes(kind) == SECTION => order(*mark)?,
            order => order?,
        };
        Some(BlockHead { kind: order.u32(kind), len: order.u32(len) as usize, order })
    }

    /// Reads a packet block of the old or the new form; `None` if it is invalid.
    #[inline(always)]
    fn packet(
        &mut self,
        body: &[u8],
        head: BlockHead,
        at: u64,
        tally: &mut Tally,
        buses: &mut Buses,
        sink: &mut impl FnMut(Item, &Buses),
    ) -> Option<()> {
        let order = head.order;
        let (start, rest) = body.split_first_chunk::<20>()?;
        let (words, _) = start.as_chunks::<4>();
        let [interface, high, low, captured, size] = words else { return None };
        let units = u64::from(order.u32(*high)) << 32 | u64::from(order.u32(*low));
        let captured = order.u32(*captured) as usize;
        let data = rest.get(..captured)?;
        let options = rest.get(captured.next_multiple_of(4)..).unwrap_or_default();
        let (number, mut lost) = if head.kind == ENHANCED_PACKET {
            (order.u32(*interface), 0)
        } else {
            let [n0, n1, d0, d1] = *interface;
            let lost = order.u16([d0, d1]);
            (u32::from(order.u16([n0, n1])), if lost == u16::MAX { 0 } else { u64::from(lost) })
        };
        let mut dir = None;
        for (code, value) in Options::new(options, order) {
            match (code, value) {
                (2, [a, b, c, d]) => {
                    dir = match order.u32([*a, *b, *c, *d]) & 3 {
                        1 => Some(Direction::Rx),
                        2 => Some(Direction::Tx),
                        _ => None,
                    };
                }
                (4, value) if head.kind == ENHANCED_PACKET => lost = number_of(value, order),
                _ => {}
            }
        }
        let packet = Packet { units: Some(units), data, size: order.u32(*size), dir, at };
        let Some(interface) = self.interfaces.get_mut(number as usize) else {
            sink(Item::Unreadable { place: FilePlace::Byte(at), reason: Unreadable::NoFrame }, buses);
            return Some(());
        };
        if lost > 0 {
            interface.lost(lost, at, buses, sink);
        }
        interface.packet(packet, order, tally, buses, sink);
        Some(())
    }

    #[allow(clippy::too_many_arguments, reason = "one block and what it may change")]
    #[inline(never)]
    fn other(
        &mut self,
        block: &[u8],
        body: &[u8],
        head: BlockHead,
        at: u64,
        tally: &mut Tally,
        buses: &mut Buses,
        sink: &mut impl FnMut(Item, &Buses),
    ) -> Option<()> {
        if head.kind != SECTION && self.is_like_packet(body, head.order) {
            tally.pass(Passed::Block(head.kind));
            sink(Item::Unreadable { place: FilePlace::Byte(at), reason: Unreadable::NoFrame }, buses);
            return Some(());
        }
        match head.kind {
            SECTION => self.section(block, head.order, tally),
            INTERFACE => self.interface(block, head.order, tally),
            SIMPLE_PACKET => {
                let (size, rest) = body.split_first_chunk::<4>()?;
                let size = head.order.u32(*size);
                let Some(interface) = self.interfaces.first_mut() else {
                    sink(Item::Unreadable { place: FilePlace::Byte(at), reason: Unreadable::NoFrame }, buses);
                    return Some(());
                };
                let most = if interface.snaplen > 0 { size.min(interface.snaplen) } else { size };
                let data = rest.get(..most as usize).unwrap_or(rest);
                let packet = Packet { units: None, data, size, dir: None, at };
                interface.packet(packet, head.order, tally, buses, sink);
                Some(())
            }
            STATISTICS => self.statistics(block, head.order, at, buses, sink),
            kind => {
                tally.pass(Passed::Block(kind));
                if !is_assigned(kind) {
                    sink(Item::Unreadable { place: FilePlace::Byte(at), reason: Unreadable::NoFrame }, buses);
                }
                Some(())
            }
        }
    }

    /// Returns true if a block of another type has the structure of a packet of one of the interfaces, so that its type
    /// is damaged.
    fn is_like_packet(&self, body: &[u8], order: ByteOrder) -> bool {
        let word = |at: usize| body.get(at..at + 4).and_then(|word| word.try_into().ok()).map(|word| order.u32(word));
        let (Some(interface), Some(captured), Some(size)) = (word(0), word(12), word(16)) else { return false };
        (interface as usize) < self.interfaces.len()
            && captured <= size
            && (captured as usize) <= body.len().saturating_sub(20)
    }

    fn section(&mut self, block: &[u8], order: ByteOrder, tally: &mut Tally) -> Option<()> {
        self.order = Some(order);
        self.interfaces.clear();
        let (_, section) = parse_sectionheaderblock(block).ok()?;
        tally.version(section.major_version, section.minor_version, order);
        for (name, code) in [("hardware", 2), ("operating system", 3), ("application", 4)] {
            if let Some(text) = option(&section.options, code) {
                tally.note(name, text);
            }
        }
        Some(())
    }

    fn interface(&mut self, block: &[u8], order: ByteOrder, tally: &mut Tally) -> Option<()> {
        if self.interfaces.len() >= MAX_INTERFACES {
            return Some(());
        }
        let parsed = match order {
            ByteOrder::Little => parse_interfacedescriptionblock_le(block),
            ByteOrder::Big => parse_interfacedescriptionblock_be(block),
        };
        let Ok((_, described)) = parsed else {
            self.unknown_interface();
            return None;
        };
        let resolution = option(&described.options, 9).and_then(<[u8]>::first).copied().unwrap_or(6);
        let offset_s = option(&described.options, 14).map_or(0, |value| number_of(value, order) as i64);
        let name = match option(&described.options, 2).map(<[u8]>::trim_ascii) {
            // The name of a bus is a single word.
            Some(name @ [_, ..]) => name.iter().map(|b| if b.is_ascii_whitespace() { b'_' } else { *b }).collect(),
            _ => format!("can{}", self.interfaces.len()).into_bytes(),
        };
        let (link_type, snaplen) = (described.linktype.0 as u16, described.snaplen);
        self.interfaces.push(Interface::new(
            &name,
            link_type,
            snaplen,
            InterfaceClock::new(resolution, offset_s),
            tally,
        ));
        Some(())
    }

    /// Keeps the index of an interface with an unreadable description, since later ones are known by their number.
    fn unknown_interface(&mut self) {
        if self.interfaces.len() < MAX_INTERFACES {
            self.interfaces.push(Interface::new(b"", u16::MAX, 0, InterfaceClock::new(6, 0), &mut Tally::default()));
        }
    }

    fn statistics(
        &mut self,
        block: &[u8],
        order: ByteOrder,
        at: u64,
        buses: &mut Buses,
        sink: &mut impl FnMut(Item, &Buses),
    ) -> Option<()> {
        let parsed = match order {
            ByteOrder::Little => parse_interfacestatisticsblock_le(block),
            ByteOrder::Big => parse_interfacestatisticsblock_be(block),
        };
        let (_, statistics) = parsed.ok()?;
        // Lost by the interface, lost by the operating system.
        let total = [5, 7].iter().filter_map(|code| option(&statistics.options, *code));
        let total = total.fold(0u64, |sum, value| sum.saturating_add(number_of(value, order)));
        if let Some(interface) = self.interfaces.get_mut(statistics.if_id as usize) {
            interface.lost_in_all(total, at, buses, sink);
        }
        Some(())
    }

    /// Handles a block whose end is missing.
    #[cold]
    fn incomplete(
        &mut self,
        bytes: &[u8],
        at: u64,
        last: bool,
        need: usize,
        buses: &mut Buses,
        sink: &mut impl FnMut(Item, &Buses),
    ) -> RecordStep {
        if !last {
            return RecordStep::Need(need);
        }
        // Either the file was cut, or the length is wrong and covers other blocks.
        self.seeking = Some(Seeking { from: at, cut: true });
        self.seek(bytes, at, last, buses, sink)
    }

    #[cold]
    fn damaged(
        &mut self,
        bytes: &[u8],
        at: u64,
        last: bool,
        buses: &mut Buses,
        sink: &mut impl FnMut(Item, &Buses),
    ) -> RecordStep {
        let head = bytes.first_chunk().and_then(|start| self.head(start));
        if head.is_some_and(|head| head.kind == INTERFACE) {
            self.unknown_interface();
        }
        self.seeking = Some(Seeking { from: at, cut: false });
        self.seek(bytes, at, last, buses, sink)
    }

    /// Searches for the next valid block and reports the skipped part.
    #[cold]
    fn seek(
        &mut self,
        bytes: &[u8],
        at: u64,
        last: bool,
        buses: &mut Buses,
        sink: &mut impl FnMut(Item, &Buses),
    ) -> RecordStep {
        let mut passed = bytes.len();
        let mut found = false;
        for (place, start) in bytes.windows(SHORTEST).enumerate() {
            let Some(head) = start.first_chunk().and_then(|start| self.head(start)) else { continue };
            if !SOUGHT.contains(&head.kind) || !(SHORTEST..=LONGEST_SOUGHT).contains(&head.len) {
                continue;
            }
            match bytes.get(place..place + head.len) {
                Some(block) if body(block, head).is_some() => (passed, found) = (place, true),
                None if !last => return if place > 0 { RecordStep::Took(place) } else { RecordStep::Need(head.len) },
                _ => continue,
            }
            break;
        }
        if !found && !last {
            let kept = SHORTEST - 1;
            return if bytes.len() > kept { RecordStep::Took(bytes.len() - kept) } else { RecordStep::Need(SHORTEST) };
        }
        if let Some(Seeking { from, cut }) = self.seeking.take() {
            let kind = match (found, cut) {
                (true, _) => DamageKind::Structure,
                (false, true) => DamageKind::Cut,
                (false, false) => DamageKind::Rest,
            };
            let bytes = Some(at + passed as u64 - from);
            sink(Item::Damaged(Damage { place: FilePlace::Byte(from), kind, bytes, frames: None }), buses);
        }
        RecordStep::Took(passed)
    }
}

/// Returns the content between the two lengths of a whole block; `None` if they differ.
#[inline(always)]
fn body(block: &[u8], head: BlockHead) -> Option<&[u8]> {
    let (rest, length) = block.split_last_chunk::<4>()?;
    (head.order.u32(*length) as usize == head.len).then_some(rest.get(8..)?)
}

fn order(mark: [u8; 4]) -> Option<ByteOrder> {
    match mark {
        [0x4D, 0x3C, 0x2B, 0x1A] => Some(ByteOrder::Little),
        [0x1A, 0x2B, 0x3C, 0x4D] => Some(ByteOrder::Big),
        _ => None,
    }
}

/// The options of a packet, up to the first incomplete one.
struct Options<'a> {
    rest: &'a [u8],
    order: ByteOrder,
}

impl<'a> Options<'a> {
    fn new(rest: &'a [u8], order: ByteOrder) -> Self {
        Self { rest, order }
    }
}

impl<'a> Iterator for Options<'a> {
    type Item = (u16, &'a [u8]);

    #[inline(always)]
    fn next(&mut self) -> Option<Self::Item> {
        let ([c0, c1, l0, l1], rest) = self.rest.split_first_chunk::<4>()?;
        let (code, len) = (self.order.u16([*c0, *c1]), usize::from(self.order.u16([*l0, *l1])));
        self.rest = rest.get(len.next_multiple_of(4)..).unwrap_or_default();
        (code != 0).then_some((code, rest.get(..len)?))
    }
}

/// Returns the first option of this code.
fn option<'a>(options: &'a [PcapNGOption<'_>], code: u16) -> Option<&'a [u8]> {
    options.iter().take_while(|option| option.code.0 != 0).find(|option| option.code.0 == code)?.as_bytes().ok()
}

/// Returns a number of 64 bits, or 0 if it is invalid.
fn number_of(value: &[u8], order: ByteOrder) -> u64 {
    value.try_into().map_or(0, |value| order.u64(value))
}

/// Returns true if a type of blocks is assigned (the registry in draft-ietf-opsawg-pcapng) or open to everyone. A block
/// of any other type may have been a frame.
fn is_assigned(kind: u32) -> bool {
    matches!(kind, 0x1..=0xB | 0x101..=0x10F | 0x201..=0x2FF | 0xBAD | 0x4000_0BAD | 0x0A0D_0A00..=0x0A0D_0AFF)
        || kind >= 0x8000_0000
}

//! An interface of a capture: its bus, its clock, and its packets, which become frames without allocations.
//!
//! pcap files have one, pcapng files any number.

use std::io::Write;

use super::ByteOrder;
use super::identifiers::Reading;
use super::link::{self, Failed, Link};
use super::tally::{Passed, Tally};
use crate::bytes::frame::{BusId, Buses, Direction, MAX_BUS_NAME, Stamp, StampForm};
use crate::bytes::ns::Ns;
use crate::bytes::readers::{FilePlace, Item, Marker, Unreadable};

/// The unit and offset of an interface's stamps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct InterfaceClock {
    /// if_tsresol: a power of ten, or of two if the upper bit is set.
    resolution: u8,
    scale: Scale,
    offset_ns: i64,
}

/// The conversion from units to ns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scale {
    Times(u64),
    Over(u64),
    /// Units of 2^-n s.
    Binary(u8),
}

impl InterfaceClock {
    /// Creates a clock from if_tsresol and if_tsoffset, the latter in s.
    pub(super) fn new(resolution: u8, offset_s: i64) -> Self {
        let scale = match resolution {
            0..=9 => Scale::Times(10u64.pow(9 - u32::from(resolution))),
            10..=28 => Scale::Over(10u64.pow(u32::from(resolution) - 9)),
            // 2^64 units are less than a ns.
            29..=127 => Scale::Times(0),
            _ => Scale::Binary(resolution & 0x7F),
        };
        Self { resolution, scale, offset_ns: offset_s.saturating_mul(1_000_000_000) }
    }

    /// Returns the units in a second, for a clock in µs or ns.
    pub(super) fn per_second(self) -> u64 {
        if self.resolution == 9 { 1_000_000_000 } else { 1_000_000 }
    }

    /// Returns the time of `units` after the epoch, in ns.
    #[inline(always)]
    fn moment(self, units: u64) -> i64 {
        let ns = match self.scale {
            Scale::Times(ns) => units.checked_mul(ns),
            Scale::Over(units_per_ns) => Some(units / units_per_ns),
            Scale::Binary(power) => u64::try_from((u128::from(units) * 1_000_000_000) >> power).ok(),
        };
        ns.and_then(|ns| i64::try_from(ns).ok()).unwrap_or(i64::MAX).saturating_add(self.offset_ns)
    }

    /// Returns the number of decimals of its stamps.
    fn decimals(self) -> u8 {
        (self.resolution & 0x7F).min(9)
    }

    fn name(self) -> String {
        let power = self.resolution & 0x7F;
        if self.resolution == power { format!("1e-{power} s") } else { format!("2^-{power} s") }
    }
}

/// A packet of a record.
#[derive(Clone, Copy, Debug)]
pub(super) struct Packet<'a> {
    /// Its stamp in units of the interface's clock.
    pub(super) units: Option<u64>,
    /// The captured bytes.
    pub(super) data: &'a [u8],
    /// Number of bytes on the wire.
    pub(super) size: u32,
    pub(super) dir: Option<Direction>,
    /// Offset of its record.
    pub(super) at: u64,
}

/// An interface.
#[derive(Debug)]
pub(super) struct Interface {
    pub(super) clock: InterfaceClock,
    pub(super) snaplen: u32,
    link: Link,
    name: Box<[u8]>,
    bus: Option<BusId>,
    /// The last bus of a cooked capture, with the host's number of the interface.
    numbered: Option<(u32, BusId)>,
    /// Number of packets reported as lost so far.
    dropped: u64,
}

impl Interface {
    pub(super) fn new(name: &[u8], link_type: u16, snaplen: u32, clock: InterfaceClock, tally: &mut Tally) -> Self {
        let name = name.get(..MAX_BUS_NAME).unwrap_or(name);
        tally.interface(name, link_type, &clock.name(), snaplen);
        let link = Link::new(link_type);
        Self { clock, snaplen, link, name: name.into(), bus: None, numbered: None, dropped: 0 }
    }

    /// Emits the frame of a packet, or the reason why there is none.
    #[inline(always)]
    pub(super) fn packet(
        &mut self,
        packet: Packet<'_>,
        order: ByteOrder,
        tally: &mut Tally,
        buses: &mut Buses,
        sink: &mut impl FnMut(Item, &Buses),
    ) {
        if let Some(votes) = &mut tally.votes {
            if self.link == Link::SocketCan {
                votes.take(packet.data, packet.at);
            }
            return;
        }
        if tally.reading == Reading::Neither && self.link == Link::SocketCan {
            return tally.pass(Passed::Packet(227));
        }
        let found = link::frame(self.link, packet.data, packet.size, (order, tally.reading.order()));
        let found = found.and_then(|found| {
            let frame = tally.orders.take(found.frame).map_err(Failed::Unreadable)?;
            Ok((frame, found.interface))
        });
        match found {
            Ok((mut frame, interface)) => {
                frame.bus = self.bus(interface, buses);
                if frame.bus == BusId::BEYOND {
                    let place = FilePlace::Byte(packet.at);
                    return sink(Item::Unreadable { place, reason: Unreadable::Bus }, buses);
                }
                frame.dir = packet.dir.or(frame.dir);
                frame.t_ns = packet.units.map(|units| Ns(self.clock.moment(units)));
                let decimals = self.clock.decimals();
                frame.stamp = frame.t_ns.map(|ns| Stamp { form: StampForm::Seconds, ns, width: 1, decimals });
                sink(Item::Frame(frame), buses);
            }
            Err(Failed::Passed(kind)) => tally.pass(kind),
            Err(Failed::Unreadable(reason)) => {
                tally.orders.failed(reason);
                sink(Item::Unreadable { place: FilePlace::Byte(packet.at), reason }, buses);
            }
        }
    }

    /// Emits a gap of `count` lost packets.
    #[cold]
    pub(super) fn lost(&mut self, count: u64, at: u64, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        if count == 0 || !self.link.is_can() {
            return;
        }
        self.dropped = self.dropped.saturating_add(count);
        let bus = self.numbered.map_or_else(|| self.bus(None, buses), |(_, bus)| bus);
        let place = FilePlace::Byte(at);
        sink(Item::Marker(Marker::Dropped { bus, count, total: self.dropped, place }), buses);
    }

    /// Emits a gap for packets lost since the beginning of the capture, unless already reported.
    pub(super) fn lost_in_all(&mut self, total: u64, at: u64, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.lost(total.saturating_sub(self.dropped), at, buses, sink);
    }

    #[inline(always)]
    fn bus(&mut self, number: Option<u32>, buses: &mut Buses) -> BusId {
        match (number, self.bus, self.numbered) {
            (None, Some(bus), _) => bus,
            (Some(number), _, Some((last, bus))) if number == last => bus,
            _ => self.new_bus(number, buses),
        }
    }

    /// Adds a bus; a cooked capture has no names but the host's numbers.
    fn new_bus(&mut self, number: Option<u32>, buses: &mut Buses) -> BusId {
        let Some(number) = number else { return *self.bus.insert(buses.intern(&self.name)) };
        let mut name = [0; 12];
        let mut rest = &mut name[..];
        // "if" and ten digits fit.
        let _ = write!(rest, "if{number}");
        let unused = rest.len();
        let bus = buses.intern(name.get(..name.len() - unused).unwrap_or_default());
        self.numbered = Some((number, bus));
        bus
    }
}

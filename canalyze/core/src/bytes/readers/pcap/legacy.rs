//! pcap files: a header, then packets of one link type, with stamps in µs or ns.
//!
//! Nothing confirms the length of a packet, so an impossible one ends the reading: anything found after it would be a
//! guess.

use pcap_parser::parse_pcap_header;

use super::interface::{Interface, InterfaceClock, Packet};
use super::tally::Tally;
use super::{ByteOrder, RecordStep};
use crate::bytes::frame::Buses;
use crate::bytes::readers::Item;

/// Maximum length of a packet in any program, in bytes.
const LONGEST: u32 = 262_144;
const HEADER: usize = 24;
const RECORD: usize = 16;

/// The header of the file, once read.
#[derive(Debug, Default)]
pub(super) struct Legacy {
    open: Option<(ByteOrder, Interface)>,
}

impl Legacy {
    #[inline(always)]
    pub(super) fn step(
        &mut self,
        bytes: &[u8],
        at: u64,
        tally: &mut Tally,
        buses: &mut Buses,
        sink: &mut impl FnMut(Item, &Buses),
    ) -> RecordStep {
        let Some((order, interface)) = &mut self.open else { return self.header(bytes, tally) };
        let order = *order;
        let Some((head, rest)) = bytes.split_first_chunk::<RECORD>() else { return RecordStep::Need(RECORD) };
        let (words, _) = head.as_chunks::<4>();
        let [seconds, fraction, captured, size] = *words else { return RecordStep::Lost };
        let [seconds, fraction, captured, size] = [seconds, fraction, captured, size].map(|word| order.u32(word));
        if captured > size || captured > LONGEST {
            return RecordStep::Lost;
        }
        let Some(data) = rest.get(..captured as usize) else { return RecordStep::Need(RECORD + captured as usize) };
        let units = u64::from(seconds) * interface.clock.per_second() + u64::from(fraction);
        interface.packet(Packet { units: Some(units), data, size, dir: None, at }, order, tally, buses, sink);
        RecordStep::Took(RECORD + captured as usize)
    }

    fn header(&mut self, bytes: &[u8], tally: &mut Tally) -> RecordStep {
        let Some(head) = bytes.get(..HEADER) else { return RecordStep::Need(HEADER) };
        let Ok((_, header)) = parse_pcap_header(head) else { return RecordStep::Lost };
        let order = if header.is_bigendian() { ByteOrder::Big } else { ByteOrder::Little };
        if header.is_modified_format() {
            return RecordStep::Lost;
        }
        // The upper half is the length of the check sums at the end of packets.
        let link_type = header.network.0 as u16;
        let clock = InterfaceClock::new(if header.is_nanosecond_precision() { 9 } else { 6 }, 0);
        tally.version(header.version_major, header.version_minor, order);
        self.open = Some((order, Interface::new(b"can0", link_type, header.snaplen, clock, tally)));
        RecordStep::Took(HEADER)
    }
}

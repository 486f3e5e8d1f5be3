//! Records that exchange frames with programs in another language: python-can's bridge.
//!
//! This is not a file format: it is not recognized by its first bytes, and users cannot select it. A record is a head
//! of 24 bytes, little-endian, followed by data that depend on its kind.
//!
//! | offset | frame (kind 1) | every other kind |
//! |---|---|---|
//! | 0 | `u8` 1 | `u8` kind |
//! | 1 | `u8` flags: 1 has a stamp, 2 FD, 4 BRS, 8 ESI, 16 received, 32 sent | `u8` which |
//! | 2 | `u8` bus | `u16` bytes of text after the head |
//! | 3 | `u8` length, of data or requested | |
//! | 4 | `u8` raw DLC 9 to 15 of a classic frame, else 0 | `u32` 0 |
//! | 5 | `u8` digits after the point of the stamp, 0 to 9 | |
//! | 6 | `u8` bytes of data after the head, 0 to 64 | |
//! | 7 | `u8` 0 | |
//! | 8 | `u32` identifier with the flag bits of SocketCAN: EFF, RTR, ERR | `i64` number |
//! | 12 | `u32` line in the file, 0 for none | |
//! | 16 | `i64` stamp in ns | `i64` further number, -1 for none |
//!
//! | kind | which | number | further | text |
//! |---|---|---|---|---|
//! | 2 bus | its index | 0 | 0 | its name |
//! | 3 start | 0 | date in ns since 1970-01-01 | 0 | |
//! | 4 damage | 0 cut, 1 checksum, 2 structure, 3 compression, 4 rest | offset in bytes | bytes lost | |
//! | 5 unreadable | 0 no frame, 1 identifier, 2 length, 3 data, 4 cut, 5 CAN XL | line | 0 | |
//! | 6 passed over | 0 | count | 0 | their kind |
//! | 7 dialect | a row of [`PROPERTIES`] | 0 | 0 | its value |
//! | 8 dropped | index of the bus | frames lost on it | 0 | |
//! | 9 left out | 0 | rows, -1 if unknown | number of the row before, -1 for none | decimal number of the line |
//!
//! The stream is not trusted: anything else ends it with one damage.

use super::{Contents, Damage, DamageKind, FilePlace, Item, Marker, Unreadable, in_pieces};
use crate::bytes::frame::{BusId, Buses, CanId, Direction, Frame, Kind, LengthForm, Stamp, StampForm};
use crate::bytes::ns::Ns;

/// Size of a head in bytes.
pub const HEAD: usize = 24;
/// Names of dialect properties by the index used in records.
pub const PROPERTIES: &[&str] = &["reader", "version", "application", "channels"];

/// The kinds of records.
pub mod kind {
    /// A frame.
    pub const FRAME: u8 = 1;
    /// The name of a bus.
    pub const BUS: u8 = 2;
    /// The date from which stamps count.
    pub const START: u8 = 3;
    /// A lost part of the file.
    pub const DAMAGE: u8 = 4;
    /// An unreadable line.
    pub const UNREADABLE: u8 = 5;
    /// A count of something that is not a frame.
    pub const PASSED_OVER: u8 = 6;
    /// A property of the dialect.
    pub const DIALECT: u8 = 7;
    /// Frames lost by the capturing program.
    pub const DROPPED: u8 = 8;
    /// Rows that the file itself shows to be missing.
    pub const LEFT_OUT: u8 = 9;
}

/// The bits of a frame's flags.
pub mod flag {
    /// The frame has a stamp.
    pub const STAMP: u8 = 1;
    /// CAN FD.
    pub const FD: u8 = 2;
    /// Bit rate switch.
    pub const BRS: u8 = 4;
    /// Error state indicator.
    pub const ESI: u8 = 8;
    /// Received.
    pub const RX: u8 = 16;
    /// Sent.
    pub const TX: u8 = 32;
}

/// Extended frame format, a flag of the identifier.
pub const EFF: u32 = 0x8000_0000;
/// Remote frame, a flag of the identifier.
pub const RTR: u32 = 0x4000_0000;
/// Error frame, a flag of the identifier.
pub const ERR: u32 = 0x2000_0000;

/// Maximum number of separately counted kinds of other content.
const KINDS: usize = 64;
/// Maximum length of a record's text, in bytes; the rest is cut off.
const TEXT: usize = 256;

/// The reader of a stream of records.
#[derive(Debug, Default)]
pub struct Packed {
    /// The beginning of an incomplete record.
    rest: Vec<u8>,
    /// Number of bytes of the stream before `rest`.
    taken: u64,
    /// The stream's buses by its own index.
    buses: Vec<Option<BusId>>,
    contents: Contents,
    /// Number of frames reported as lost.
    lost: u64,
    broken: bool,
}

impl Packed {
    /// Feeds the next bytes, in any chunking.
    pub fn feed(&mut self, bytes: &[u8], buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        if self.broken {
            return;
        }
        let rest = std::mem::take(&mut self.rest);
        self.rest = in_pieces(rest, bytes, |bytes| self.records(bytes, buses, sink));
    }

    /// Ends the stream.
    pub fn finish(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        if !self.rest.is_empty() && !self.broken {
            let bytes = Some(self.rest.len() as u64);
            let place = FilePlace::Byte(self.taken);
            sink(Item::Damaged(Damage { place, kind: DamageKind::Cut, bytes, frames: None }), buses);
        }
        self.interrupt(buses, sink);
    }

    /// Ends an interrupted stream, ignoring an incomplete record.
    pub fn interrupt(&mut self, _: &mut Buses, _: &mut impl FnMut(Item, &Buses)) {
        self.rest.clear();
    }

    /// Returns the facts about the file beyond its frames.
    pub fn contents(&self) -> Contents {
        self.contents.clone()
    }

    /// Reads complete records and returns the number of bytes consumed.
    fn records(&mut self, bytes: &[u8], buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) -> usize {
        let mut used = 0;
        while let Some((head, behind)) = bytes.get(used..).and_then(<[u8]>::split_first_chunk::<HEAD>) {
            let size = size(head);
            let Some((body, _)) = behind.split_at_checked(size) else { break };
            let item = if head.first() == Some(&kind::FRAME) {
                self.frame(head, body, buses).map(|frame| Some(Item::Frame(frame)))
            } else {
                self.other(head, body, buses)
            };
            match item {
                Some(Some(item)) => sink(item, buses),
                Some(None) => {}
                None => {
                    let place = FilePlace::Byte(self.taken);
                    sink(Item::Damaged(Damage { place, kind: DamageKind::Rest, bytes: None, frames: None }), buses);
                    self.broken = true;
                    return bytes.len();
                }
            }
            used += HEAD + size;
            self.taken += (HEAD + size) as u64;
        }
        used
    }

    fn frame(&self, head: &[u8; HEAD], body: &[u8], buses: &mut Buses) -> Option<Frame> {
        let [_, flags, bus, len, raw_dlc, decimals, _, zero, ..] = *head;
        let (id, line, ns) = (u32_at(head, 8), u32_at(head, 12), i64_at(head, 16));
        let has = |flag| flags & flag != 0;
        if zero != 0 || len > 64 || decimals > 9 || raw_dlc > 15 || body.len() > 64 {
            return None;
        }
        let kind = match () {
            () if id & ERR != 0 => Kind::Error,
            () if has(flag::FD) => Kind::Fd { brs: has(flag::BRS), esi: has(flag::ESI) },
            () if id & RTR != 0 => Kind::Remote,
            () => Kind::Data,
        };
        let raw = id & 0x1FFF_FFFF;
        let mut data = [0; 64];
        for (slot, byte) in data.iter_mut().zip(body) {
            *slot = *byte;
        }
        let dir = match (has(flag::RX), has(flag::TX)) {
            (true, false) => Some(Direction::Rx),
            (false, true) => Some(Direction::Tx),
            _ => None,
        };
        let known = self.buses.get(usize::from(bus)).copied().flatten();
        let stamped = has(flag::STAMP);
        Some(Frame {
            no: 0,
            moved: 0,
            corrected_ns: 0,
            line: (line != 0).then_some(u64::from(line)),
            t_ns: stamped.then_some(Ns(ns)),
            stamp: stamped.then_some(Stamp { form: StampForm::Seconds, ns: Ns(ns), width: 1, decimals }),
            bus: known.unwrap_or_else(|| buses.intern(b"")),
            // An error class is a number of 29 bits regardless of the flag.
            id: match u16::try_from(raw) {
                Ok(short) if id & EFF == 0 && short <= 0x7FF => CanId::standard(short),
                _ => CanId::extended(raw),
            },
            kind,
            dir,
            len: if kind == Kind::Remote { len.min(8) } else { len },
            length_form: LengthForm { raw_dlc: if raw_dlc > 8 { raw_dlc } else { 0 }, ..LengthForm::default() },
            data,
        })
    }

    /// Reads a record of another kind; `None` if the kind is unknown.
    fn other(&mut self, head: &[u8; HEAD], body: &[u8], buses: &mut Buses) -> Option<Option<Item>> {
        let [record, which, ..] = *head;
        let (number, further) = (i64_at(head, 8), i64_at(head, 16));
        let text = body.get(..TEXT).unwrap_or(body);
        let count = u64::try_from(number).unwrap_or(0);
        Some(match record {
            kind::BUS => {
                let index = usize::from(which);
                if self.buses.len() <= index {
                    self.buses.resize(index + 1, None);
                }
                let id = buses.intern(text);
                if let Some(slot) = self.buses.get_mut(index) {
                    *slot = Some(id);
                }
                None
            }
            kind::START => Some(Item::Marker(Marker::Start { date_ns: Ns(number) })),
            kind::DAMAGE => {
                let kind = *DAMAGES.get(usize::from(which))?;
                let place = FilePlace::Byte(count);
                Some(Item::Damaged(Damage { place, kind, bytes: u64::try_from(further).ok(), frames: None }))
            }
            kind::UNREADABLE => {
                let reason = *REASONS.get(usize::from(which))?;
                Some(Item::Unreadable { place: FilePlace::Line(count), reason })
            }
            kind::PASSED_OVER => {
                self.pass_over(text, count);
                None
            }
            kind::DIALECT => {
                self.contents.dialect.push((PROPERTIES.get(usize::from(which)).copied()?, text.to_vec()));
                self.contents.dialect.truncate(KINDS);
                None
            }
            kind::DROPPED => {
                let bus = self.buses.get(usize::from(which)).copied().flatten()?;
                self.lost = self.lost.saturating_add(count);
                let place = FilePlace::Byte(self.taken);
                Some(Item::Marker(Marker::Dropped { bus, count, total: self.lost, place }))
            }
            kind::LEFT_OUT => {
                let count = u64::try_from(number).ok();
                let last = u64::try_from(further).ok();
                let rows = last.zip(count).map(|(last, count)| (last, last.saturating_add(count).saturating_add(1)));
                let line = std::str::from_utf8(text).ok().and_then(|digits| digits.parse().ok());
                let place = line.map_or(FilePlace::Byte(self.taken), FilePlace::Line);
                Some(Item::Marker(Marker::LeftOut { count, rows, place }))
            }
            _ => return None,
        })
    }

    fn pass_over(&mut self, what: &[u8], count: u64) {
        let kinds = &mut self.contents.passed_over;
        let what = if kinds.len() + 1 < KINDS || kinds.iter().any(|(known, _)| known == what) { what } else { b"..." };
        match kinds.iter_mut().find(|(known, _)| known == what) {
            Some((_, total)) => *total = total.saturating_add(count),
            None => kinds.push((what.to_vec(), count)),
        }
    }
}

/// Kinds of damage by `which`.
const DAMAGES: &[DamageKind] =
    &[DamageKind::Cut, DamageKind::Checksum, DamageKind::Structure, DamageKind::Compression, DamageKind::Rest];
/// Reasons by `which`.
const REASONS: &[Unreadable] = &[
    Unreadable::NoFrame,
    Unreadable::Identifier,
    Unreadable::Length,
    Unreadable::Data,
    Unreadable::Cut,
    Unreadable::CanXl,
];

/// Returns the number of bytes after the head.
fn size(head: &[u8; HEAD]) -> usize {
    let [record, _, low, high, _, _, data, ..] = *head;
    if record == kind::FRAME { usize::from(data) } else { usize::from(u16::from_le_bytes([low, high])) }
}

fn u32_at(head: &[u8; HEAD], at: usize) -> u32 {
    head.get(at..).and_then(<[u8]>::first_chunk).map_or(0, |bytes| u32::from_le_bytes(*bytes))
}

fn i64_at(head: &[u8; HEAD], at: usize) -> i64 {
    head.get(at..).and_then(<[u8]>::first_chunk).map_or(0, |bytes| i64::from_le_bytes(*bytes))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]

    use crate::bytes::ns::Ns;
    use proptest::prelude::*;

    use super::Packed;
    use crate::bytes::frame::{Buses, CanId, Direction, Frame, Kind, LengthForm, Stamp, StampForm};
    use crate::bytes::readers::{DamageKind, FilePlace, Item, Marker};
    use crate::bytes::writers::CaptureFacts;
    use crate::bytes::writers::packed::Packed as Writer;

    fn read(chunks: &[&[u8]]) -> (Vec<Item>, Buses) {
        let (mut reader, mut buses, mut items) = (Packed::default(), Buses::default(), Vec::new());
        for chunk in chunks {
            reader.feed(chunk, &mut buses, &mut |item, _| items.push(item));
        }
        reader.finish(&mut buses, &mut |item, _| items.push(item));
        (items, buses)
    }

    fn shown(items: &[Item]) -> String {
        format!("{items:?}")
    }

    fn frames() -> impl Strategy<Value = Frame> {
        let kinds = prop_oneof![
            Just(Kind::Data),
            Just(Kind::Remote),
            Just(Kind::Error),
            (any::<bool>(), any::<bool>()).prop_map(|(brs, esi)| Kind::Fd { brs, esi }),
        ];
        let ids = prop_oneof![(0..0x800_u16).prop_map(CanId::standard), (0..0x2000_0000_u32).prop_map(CanId::extended)];
        let dirs = prop_oneof![Just(None), Just(Some(Direction::Rx)), Just(Some(Direction::Tx))];
        let data = prop::collection::vec(any::<u8>(), 0..=64);
        (kinds, ids, dirs, data, prop::option::of((any::<i64>(), 0..=9_u8)), 0..3_u8, 9..=15_u8).prop_map(
            |(kind, id, dir, bytes, stamp, bus, raw)| {
                let most = if matches!(kind, Kind::Fd { .. }) { 64 } else { 8 };
                let len = bytes.len().min(most);
                let mut data = [0; 64];
                if kind != Kind::Remote {
                    data[..len].copy_from_slice(&bytes[..len]);
                }
                let raw_dlc = if kind == Kind::Data && len == 8 { raw } else { 0 };
                Frame {
                    no: 0,
                    moved: 0,
                    corrected_ns: 0,
                    line: None,
                    t_ns: stamp.map(|(ns, _)| ns).map(Ns),
                    stamp: stamp.map(|(ns, decimals)| Stamp {
                        form: StampForm::Seconds,
                        ns: Ns(ns),
                        width: 1,
                        decimals,
                    }),
                    bus: crate::bytes::frame::BusId(bus),
                    id,
                    kind,
                    dir,
                    len: len as u8,
                    length_form: LengthForm { raw_dlc, ..LengthForm::default() },
                    data,
                }
            },
        )
    }

    proptest! {
        #[test]
        fn what_is_written_is_read(frames in prop::collection::vec(frames(), 1..20), cut in 1..40_usize) {
            let mut buses = Buses::default();
            for name in [&b"can0"[..], b"vcan1", b""] {
                buses.intern(name);
            }
            let (mut writer, mut out) = (Writer::default(), Vec::new());
            for frame in &frames {
                writer.frame(&mut out, CaptureFacts { buses: &buses, date_ns: None }, frame);
            }
            let (items, read_buses) = read(&[&out]);
            let chunks: Vec<&[u8]> = out.chunks(cut).collect();
            prop_assert_eq!(shown(&read(&chunks).0), shown(&items));
            prop_assert_eq!(items.len(), frames.len());
            for (item, frame) in items.iter().zip(&frames) {
                let Item::Frame(read) = item else { panic!("{item:?}") };
                prop_assert_eq!(read_buses.name(read.bus), buses.name(frame.bus));
                let same = Frame { bus: frame.bus, ..*read };
                prop_assert_eq!(format!("{same:?}"), format!("{frame:?}"));
            }
        }

        #[test]
        fn anything_is_read_without_panic(bytes in prop::collection::vec(0..9_u8, 0..400), cut in 1..40_usize) {
            let chunks: Vec<&[u8]> = bytes.chunks(cut).collect();
            prop_assert_eq!(shown(&read(&chunks).0), shown(&read(&[&bytes]).0));
        }
    }

    #[test]
    fn a_gap_is_written_and_read() {
        let mut buses = Buses::default();
        let (first, second) = (buses.intern(b"can0"), buses.intern(b"can1"));
        let (mut writer, mut out) = (Writer::default(), Vec::new());
        let setting = CaptureFacts { buses: &buses, date_ns: None };
        for (bus, count) in [(second, 3), (first, 4)] {
            writer.marker(&mut out, setting, &Marker::Dropped { bus, count, total: 99, place: FilePlace::Line(7) });
        }
        let (items, read_buses) = read(&[&out]);
        let gaps: Vec<_> = items
            .iter()
            .map(|item| match item {
                Item::Marker(Marker::Dropped { bus, count, total, .. }) => (read_buses.name(*bus), *count, *total),
                _ => panic!("{item:?}"),
            })
            .collect();
        assert_eq!(gaps, [(&b"can1"[..], 3, 3), (&b"can0"[..], 4, 7)]);
        assert_eq!(writer.losses.iter().count(), 1);
    }

    fn record(kind: u8, which: u8, number: i64, further: i64, text: &[u8]) -> Vec<u8> {
        let mut out = vec![kind, which];
        out.extend_from_slice(&(text.len() as u16).to_le_bytes());
        out.extend_from_slice(&[0; 4]);
        out.extend_from_slice(&number.to_le_bytes());
        out.extend_from_slice(&further.to_le_bytes());
        out.extend_from_slice(text);
        out
    }

    #[test]
    fn every_kind_of_record() {
        let (mut reader, mut buses, mut items) = (Packed::default(), Buses::default(), Vec::new());
        let stream = [
            record(7, 1, 0, 0, b"2.1"),
            record(3, 0, 1_700_000_000_000_000_000, 0, b""),
            record(5, 3, 12, 0, b""),
            record(9, 0, 5, 14, b"12"),
            record(9, 0, -1, -1, b"13"),
            record(6, 0, 2, 0, b"ST"),
            record(6, 0, 3, 0, b"ST"),
            record(4, 4, 99, -1, b""),
        ];
        reader.feed(&stream.concat(), &mut buses, &mut |item, _| items.push(item));
        reader.finish(&mut buses, &mut |item, _| items.push(item));
        assert!(matches!(items[0], Item::Marker(Marker::Start { date_ns: Ns(1_700_000_000_000_000_000) })));
        assert!(matches!(items[1], Item::Unreadable { place: FilePlace::Line(12), .. }));
        let [Item::Marker(jump), Item::Marker(mark)] = items[2..4] else { panic!("{items:?}") };
        assert_eq!(jump, Marker::LeftOut { count: Some(5), rows: Some((14, 20)), place: FilePlace::Line(12) });
        assert_eq!(mark, Marker::LeftOut { count: None, rows: None, place: FilePlace::Line(13) });
        let Item::Damaged(damage) = items[4] else { panic!("{items:?}") };
        assert_eq!((damage.place, damage.kind, damage.bytes), (FilePlace::Byte(99), DamageKind::Rest, None));
        let contents = reader.contents();
        assert_eq!(contents.dialect, [("version", b"2.1".to_vec())]);
        assert_eq!(contents.passed_over, [(b"ST".to_vec(), 5)]);
    }

    #[test]
    fn a_stream_that_is_none_is_said_once() {
        let stream = [record(3, 0, 5, 0, b""), record(200, 0, 0, 0, b""), record(3, 0, 6, 0, b"")].concat();
        let (items, _) = read(&[&stream]);
        assert_eq!(items.len(), 2, "{items:?}");
        assert!(matches!(items[1], Item::Damaged(damage) if damage.kind == DamageKind::Rest));
        let (items, _) = read(&[&stream[..30]]);
        assert!(matches!(items[1], Item::Damaged(damage) if damage.kind == DamageKind::Cut));
    }
}

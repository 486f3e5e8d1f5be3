//! Captures of libpcap and Wireshark in both formats: pcap (one link type, one resolution) and pcapng (blocks, several
//! interfaces).
//!
//! This file passes complete records to the format and keeps incomplete ones; `legacy` and `blocks` know the records,
//! `link` the packets. The first bytes show the format. A claimed length allocates nothing and never causes a skip by
//! itself. Packets of other link types are not faults.

mod blocks;
mod identifiers;
mod interface;
mod legacy;
mod link;
mod tally;
#[cfg(test)]
mod tests;

use self::blocks::Blocks;
use self::identifiers::{Reading, Votes};
use self::legacy::Legacy;
use self::tally::Tally;
use super::{Contents, Damage, DamageKind, FilePlace, Item, Marker, Unreadable};
use crate::bytes::frame::{Buses, Frame};

/// A reader of one pcap or pcapng file.
#[derive(Debug)]
pub struct Pcap {
    records: Records,
    /// The beginning of the file, until the byte order of its identifiers is known.
    trial: Option<Box<Trial>>,
}

/// A beginning that is examined before it is emitted.
#[derive(Debug, Default)]
struct Trial {
    head: Vec<u8>,
    records: Records,
}

/// A stream of records.
#[derive(Debug, Default)]
struct Records {
    form: PcapForm,
    /// The bytes of an incomplete record; those before `gone` are consumed.
    held: Vec<u8>,
    gone: usize,
    /// Number of bytes that the record needs in total, as far as known.
    need: usize,
    /// Offset of the next record in the file.
    at: u64,
    tally: Tally,
}

#[derive(Debug, Default)]
enum PcapForm {
    /// Before the first bytes.
    #[default]
    Unknown,
    Legacy(Legacy),
    Blocks(Box<Blocks>),
    /// Unreadable from this offset on.
    Lost(u64),
}

/// The result of reading a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum RecordStep {
    /// Number of bytes consumed.
    Took(usize),
    /// Total number of bytes needed, more than available.
    Need(usize),
    /// No record of this format can follow or be found.
    Lost,
}

impl Default for Pcap {
    fn default() -> Self {
        let mut trial = Box::<Trial>::default();
        trial.records.tally.votes = Some(Votes::default());
        Self { records: Records::default(), trial: Some(trial) }
    }
}

impl Pcap {
    /// Feeds the next bytes, in any chunking.
    pub fn feed(&mut self, bytes: &[u8], buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let Some(trial) = &mut self.trial else { return self.records.feed(bytes, buses, sink) };
        trial.head.extend_from_slice(bytes);
        trial.records.feed(bytes, &mut Buses::default(), &mut |_, _| {});
        let votes = trial.records.tally.votes.as_ref();
        if let Some(reading) = votes.and_then(|votes| votes.decided(trial.records.at)) {
            self.begin(reading, buses, sink);
        }
    }

    /// Ends the file; an incomplete record was cut off.
    pub fn finish(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.settle(buses, sink);
        self.records.finish(buses, sink);
    }

    /// Ends an interrupted file, ignoring an incomplete last record.
    pub fn interrupt(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.settle(buses, sink);
        self.records.interrupt(buses, sink);
    }

    /// Returns version, resolution and interfaces, and the counts of packets and blocks without a frame.
    pub fn contents(&self) -> Contents {
        self.trial.as_ref().map_or(&self.records, |trial| &trial.records).tally.contents()
    }

    /// Decides the byte order of identifiers at the end of a file that was too short for certainty.
    fn settle(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let votes = self.trial.as_ref().and_then(|trial| trial.records.tally.votes.as_ref());
        if let Some(reading) = votes.map(Votes::judge) {
            self.begin(reading, buses, sink);
        }
    }

    /// Emits the records held back.
    fn begin(&mut self, reading: Reading, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let Some(trial) = self.trial.take() else { return };
        self.records.tally.identifiers(reading);
        if reading == Reading::Little {
            sink(Item::Marker(Marker::Swapped), buses);
        }
        self.records.feed(&trial.head, buses, sink);
    }
}

impl Records {
    /// Feeds the next bytes, in any chunking.
    fn feed(&mut self, mut bytes: &[u8], buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        // An incomplete record gets only the bytes that it needs, so that all others are read in place.
        while self.gone < self.held.len() {
            let lacking = self.need.saturating_sub(self.held.len() - self.gone);
            let (taken, rest) = bytes.split_at_checked(lacking).unwrap_or((bytes, &[]));
            self.held.extend_from_slice(taken);
            bytes = rest;
            if taken.len() < lacking {
                return;
            }
            let held = std::mem::take(&mut self.held);
            self.gone += self.run(held.get(self.gone..).unwrap_or_default(), false, buses, sink);
            self.held = held;
            if self.gone * 2 > self.held.len() {
                self.held.drain(..self.gone);
                self.gone = 0;
            }
        }
        let done = self.run(bytes, false, buses, sink);
        self.held.extend_from_slice(bytes.get(done..).unwrap_or_default());
    }

    /// Ends the file; an incomplete record was cut off.
    fn finish(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let held = std::mem::take(&mut self.held);
        self.run(held.get(self.gone..).unwrap_or_default(), true, buses, sink);
        self.gone = 0;
        if let PcapForm::Lost(from) = self.form {
            self.rest(from, buses, sink);
            self.form = PcapForm::Unknown;
        }
    }

    /// Ends an interrupted file, ignoring an incomplete last record.
    fn interrupt(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let sought = matches!(&self.form, PcapForm::Blocks(blocks) if blocks.seeks());
        if !sought {
            self.held.clear();
            self.gone = 0;
        }
        self.finish(buses, sink);
    }

    /// Reads all complete records; returns the number of bytes consumed.
    fn run(&mut self, bytes: &[u8], last: bool, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) -> usize {
        let mut done = 0;
        while let Some(rest) = bytes.get(done..)
            && !rest.is_empty()
        {
            let step = match &mut self.form {
                PcapForm::Unknown => match begin(rest) {
                    Some(form) => {
                        self.form = form;
                        continue;
                    }
                    None => RecordStep::Need(4),
                },
                PcapForm::Legacy(legacy) => legacy.step(rest, self.at, &mut self.tally, buses, sink),
                PcapForm::Blocks(blocks) => blocks.step(rest, self.at, last, &mut self.tally, buses, sink),
                PcapForm::Lost(_) => RecordStep::Took(rest.len()),
            };
            let taken = match step {
                RecordStep::Took(taken) => taken,
                RecordStep::Need(_) if last => {
                    let bytes = Some(rest.len() as u64);
                    let damage = Damage { place: FilePlace::Byte(self.at), kind: DamageKind::Cut, bytes, frames: None };
                    sink(Item::Damaged(damage), buses);
                    rest.len()
                }
                RecordStep::Need(need) => {
                    self.need = need;
                    break;
                }
                RecordStep::Lost => {
                    self.form = PcapForm::Lost(self.at);
                    rest.len()
                }
            };
            done += taken;
            self.at += taken as u64;
        }
        done
    }

    #[cold]
    fn rest(&self, from: u64, buses: &Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let bytes = Some(self.at - from);
        sink(
            Item::Damaged(Damage { place: FilePlace::Byte(from), kind: DamageKind::Rest, bytes, frames: None }),
            buses,
        );
    }
}

/// Detects the format by the first four bytes.
fn begin(bytes: &[u8]) -> Option<PcapForm> {
    Some(match bytes.first_chunk::<4>()? {
        b"\n\r\r\n" => PcapForm::Blocks(Box::default()),
        _ => PcapForm::Legacy(Legacy::default()),
    })
}

/// Returns a frame as delivered by this host's kernel: `struct can_frame`, or `struct canfd_frame` with `fd`.
#[inline(always)]
pub(super) fn native(bytes: &[u8], fd: bool) -> Result<Frame, Unreadable> {
    let order = if cfg!(target_endian = "big") { ByteOrder::Big } else { ByteOrder::Little };
    link::socketcan(bytes, bytes.len() as u32, order, Some(fd))
}

/// The byte order of numbers: that of the host that wrote the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ByteOrder {
    Little,
    Big,
}

impl ByteOrder {
    fn u16(self, bytes: [u8; 2]) -> u16 {
        match self {
            Self::Little => u16::from_le_bytes(bytes),
            Self::Big => u16::from_be_bytes(bytes),
        }
    }

    #[inline(always)]
    fn u32(self, bytes: [u8; 4]) -> u32 {
        match self {
            Self::Little => u32::from_le_bytes(bytes),
            Self::Big => u32::from_be_bytes(bytes),
        }
    }

    fn u64(self, bytes: [u8; 8]) -> u64 {
        match self {
            Self::Little => u64::from_le_bytes(bytes),
            Self::Big => u64::from_be_bytes(bytes),
        }
    }
}

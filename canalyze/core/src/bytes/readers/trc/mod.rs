//! PEAK's traces (TRC), versions 1.0 to 2.1.
//!
//! | file | purpose |
//! |---|---|
//! | `mod` | lines, what waits for the version, and items |
//! | `header` | version, date and columns, from the header or from the form of the rows |
//! | `row` | the columns of one row |
//!
//! A header may be missing or incomplete, as in an excerpt: lines wait until the form of a row shows the version. A line
//! that cannot be read costs only itself. Rows of other types are counted.

use crate::bytes::ns::Ns;

mod header;
mod row;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use self::header::TrcHeader;
use self::row::{TrcFail, TrcRow, TrcWay};
use super::candump::lex;
use super::lines::Begun;
use super::listing::{self, Gaps};
use super::{Contents, Damage, DamageKind, FilePlace, Item, Marker, Unreadable};
use crate::bytes::frame::{BusId, Buses, Direction, Frame, Kind, LengthForm, Stamp, StampForm};

/// Maximum number of lines that wait for the version.
const UNDECIDED: usize = 1000;
/// Maximum number of channels of which the bus is told.
const CHANNELS: usize = 64;
/// Types of rows that are no frames.
const OTHERS: [&str; 5] = ["ST", "EC", "EV", "Warng", "FFFFFFFF"];

/// The reader of one file.
#[derive(Debug, Default)]
pub struct Trc {
    begun: Begun,
    lines: u64,
    header: TrcHeader,
    /// Lines behind the header before the version is known.
    waiting: Vec<(u64, Vec<u8>)>,
    /// The version is known, or there is no row to tell it.
    started: bool,
    /// The version cannot be read.
    unknown: bool,
    gaps: Gaps,
    channels: Vec<(u32, BusId)>,
    decimals: u8,
    passed_over: BTreeMap<&'static str, u64>,
}

impl Trc {
    /// Feeds the next bytes, in any chunking.
    pub fn feed(&mut self, bytes: &[u8], buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let mut begun = std::mem::take(&mut self.begun);
        begun.cut(bytes, &mut |line| self.take(line, false, buses, sink));
        self.begun = begun;
    }

    /// Ends the file; its last line may lack its end.
    pub fn finish(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let last = self.begun.end();
        if !last.is_empty() {
            self.take(Some(&last), true, buses, sink);
        }
        self.start(!last.is_empty(), buses, sink);
        self.gaps.settle(buses, sink);
    }

    /// Ends an interrupted file, ignoring an incomplete last line.
    pub fn interrupt(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.begun.end();
        self.start(false, buses, sink);
        self.gaps.settle(buses, sink);
    }

    /// Returns version and channels, and the counts of rows of other types.
    pub fn contents(&self) -> Contents {
        let mut dialect = Vec::new();
        if self.started {
            dialect.push(("version", self.header.version().to_owned()));
        }
        if !self.channels.is_empty() {
            let named = |(channel, _): &(u32, BusId)| format!("{channel} = can{}", channel.saturating_sub(1));
            let all: Vec<String> = self.channels.iter().map(named).collect();
            dialect.push(("channels", all.join(", ").into_bytes()));
        }
        let passed_over = self.passed_over.iter().map(|(kind, count)| (kind.as_bytes().to_vec(), *count)).collect();
        Contents { dialect, passed_over, topics: Vec::new() }
    }

    fn take(&mut self, line: Option<&[u8]>, last: bool, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.lines += 1;
        let text = line.map(<[u8]>::trim_ascii);
        let text =
            if self.lines == 1 { text.map(|text| text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text)) } else { text };
        let text = match text {
            Some(text) if listing::is_damaged(text) => None,
            Some([]) => return,
            Some(text @ [b'>' | b'`' | b'|' | b'<', ..] | text @ [.., b'`' | b'|' | b'>']) => {
                Some(listing::unmarked(listing::unquoted(text)))
            }
            _ => text,
        };
        if let Some(text @ [b';', ..]) = text {
            if !self.header.is_complete() && self.header.take(text).is_none() {
                self.unreadable(self.lines, Unreadable::NoFrame, last, buses, sink);
            }
            return;
        }
        let Some(text) = text else { return self.unreadable(self.lines, Unreadable::NoFrame, last, buses, sink) };
        if text.is_empty() {
            return;
        }
        self.header.complete();
        if self.started {
            return self.line(self.lines, text, last, buses, sink);
        }
        self.header.decide(text);
        self.waiting.push((self.lines, text.to_vec()));
        if self.header.is_decided() || self.waiting.len() >= UNDECIDED {
            self.start(last, buses, sink);
        }
    }

    /// Reads the lines that have waited; `last`: the last of them has no end.
    fn start(&mut self, last: bool, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        if self.started {
            return;
        }
        self.started = true;
        self.header.settle();
        if let Some(date_ns) = self.header.date_ns() {
            sink(Item::Marker(Marker::Start { date_ns: Ns(date_ns) }), buses);
        }
        self.unknown = !self.header.is_readable();
        if self.unknown {
            let place = self.waiting.first().map_or(FilePlace::Line(self.lines), |(line, _)| FilePlace::Line(*line));
            sink(Item::Damaged(Damage { place, kind: DamageKind::Rest, bytes: None, frames: None }), buses);
        }
        let waiting = std::mem::take(&mut self.waiting);
        let end = waiting.len();
        for (place, (number, text)) in waiting.into_iter().enumerate() {
            self.line(number, &text, last && place + 1 == end && number == self.lines, buses, sink);
        }
    }

    fn unreadable(
        &mut self,
        line: u64,
        reason: Unreadable,
        last: bool,
        buses: &mut Buses,
        sink: &mut impl FnMut(Item, &Buses),
    ) {
        let reason = if last { Unreadable::Cut } else { reason };
        sink(Item::Unreadable { place: FilePlace::Line(line), reason }, buses);
    }

    /// Reads one line behind the header; `last`: it has no end.
    fn line(&mut self, number: u64, text: &[u8], last: bool, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        if self.unknown {
            return;
        }
        let place = FilePlace::Line(number);
        match row::number(text) {
            Some(own) => self.gaps.numbered(own, place, buses, sink),
            None => match listing::omission(text) {
                Some(omission) => return self.gaps.mark(omission, place),
                // A row that cannot be read is one.
                None => self.gaps.uncounted(buses, sink),
            },
        }
        match row::read(text, &self.header, last) {
            Ok(row) => {
                let frame = self.frame(number, &row, buses);
                sink(Item::Frame(frame), buses);
            }
            Err(TrcFail::Other(kind)) => match OTHERS.iter().find(|known| known.as_bytes() == kind) {
                Some(known) if row::number(text).is_some() || !self.header.is_numbered() => {
                    *self.passed_over.entry(known).or_default() += 1;
                }
                _ => self.unreadable(number, Unreadable::NoFrame, last, buses, sink),
            },
            Err(TrcFail::Because(reason)) => self.unreadable(number, reason, last, buses, sink),
        }
    }

    /// Returns the bus of a channel: channel 1 is `can0`.
    fn bus(&mut self, channel: u32, buses: &mut Buses) -> BusId {
        if let Some((_, bus)) = self.channels.iter().find(|(known, _)| *known == channel) {
            return *bus;
        }
        let bus = buses.intern(format!("can{}", channel.saturating_sub(1)).as_bytes());
        if self.channels.len() < CHANNELS {
            self.channels.push((channel, bus));
        }
        bus
    }

    fn frame(&mut self, line: u64, row: &TrcRow, buses: &mut Buses) -> Frame {
        self.decimals = self.decimals.max(row.decimals);
        let bus = self.bus(row.channel, buses);
        let mut data = [0; 64];
        for (slot, byte) in data.iter_mut().zip(row.data.iter().take(usize::from(row.size))) {
            *slot = *byte;
        }
        let stamp = Stamp { form: StampForm::Seconds, ns: Ns(row.ns), width: 1, decimals: self.decimals };
        Frame {
            no: 0,
            moved: 0,
            corrected_ns: 0,
            line: Some(line),
            t_ns: Some(Ns(row.ns)),
            stamp: Some(stamp),
            bus,
            id: row.id,
            kind: row.kind,
            dir: match row.way {
                TrcWay::Unknown => None,
                TrcWay::Received => Some(Direction::Rx),
                TrcWay::Sent => Some(Direction::Tx),
            },
            len: if row.kind == Kind::Remote { row.len.min(8) } else { row.len },
            length_form: LengthForm { raw_dlc: row.raw_dlc, ..LengthForm::default() },
            data,
        }
    }
}

/// Iterates over the words of a line.
fn words(mut text: &[u8]) -> impl Iterator<Item = &[u8]> {
    std::iter::from_fn(move || {
        let (word, rest) = lex::word(lex::skip_blanks(text));
        text = rest;
        Some(word).filter(|word| !word.is_empty())
    })
}

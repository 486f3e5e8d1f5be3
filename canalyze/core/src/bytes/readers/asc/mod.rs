//! Vector's ASC logs, and those of the many programs that write similar ones.
//!
//! This file cuts the input into lines and classifies each by its content alone: headers, blocks and comments may be
//! anywhere or missing. Prose never becomes a frame, a damaged frame never passes as another one or as another kind of
//! event, and other content is counted by kind. That includes requests to send (`TxRq`), whose frame follows as `Tx`
//! when it is on the bus. Memory is bounded for any input.

use crate::bytes::ns::Ns;

mod base;
mod classic;
mod clock;
mod date;
mod fd;
mod header;
mod kinds;
pub(crate) mod notes;
#[cfg(test)]
mod tests;
mod words;

use memchr::memchr;

use self::clock::AscClock;
use self::header::{Header, Said};
use self::notes::Note;
pub(crate) use self::words::fd_code;
use self::words::{Fail, LineWords};
use super::candump::lex::skip_blanks;
use super::lines::Begun;
use super::listing::{self, Gaps, Omission};
use super::{Contents, FilePlace, Item, Marker, Unreadable};
use crate::bytes::frame::{BusId, Buses, Frame, Kind, Stamp};

/// The number of a channel in the file.
pub(crate) type AscChannel = u16;
/// Maximum number of channels whose bus is remembered.
const MAX_CHANNELS: usize = 256;

/// A reader of one ASC log.
#[derive(Debug, Default)]
pub struct Asc {
    /// The beginning of the file, held back until its header or its numbers show their base.
    head: base::AscHead,
    header: Header,
    clock: AscClock,
    channels: Vec<(AscChannel, BusId)>,
    /// Index of the channel of the last frame.
    last: usize,
    begun: Begun,
    lines: u64,
    /// True if the directions are only placeholders of the format.
    without_directions: bool,
    /// True if the stamps are only placeholders of the format.
    without_stamps: bool,
    /// The preceding comment on an error frame.
    error: Option<Note>,
    gaps: Gaps,
    /// True if the last numbers of CAN FD were hexadecimal in a decimal file.
    fd_hexadecimal: bool,
}

/// The content of the columns after the stamp.
#[derive(Clone, Copy, Debug)]
#[allow(clippy::large_enum_variant, reason = "made once a line, never kept")]
enum Event<'a> {
    /// A frame without its bus and time.
    Frame(Frame),
    /// Another event: the word that names its kind.
    Passed(&'a [u8]),
}

impl Asc {
    /// Feeds the next bytes, in any chunking.
    pub fn feed(&mut self, bytes: &[u8], buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        if self.head.is_open() {
            let held = self.head.feed(bytes);
            self.release(held, buses, sink);
        } else {
            self.split(bytes, buses, sink);
        }
    }

    /// Reads the bytes held back, once their base is known.
    fn release(&mut self, held: Option<(Vec<u8>, bool)>, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let Some((bytes, decimal)) = held else { return };
        if decimal {
            self.header.set_decimal();
        }
        self.split(&bytes, buses, sink);
    }

    fn split(&mut self, bytes: &[u8], buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let mut begun = std::mem::take(&mut self.begun);
        begun.cut(bytes, &mut |line| match line {
            Some(line) => self.line(line, false, buses, sink),
            None => self.too_long(buses, sink),
        });
        self.begun = begun;
    }

    /// Ends the file, reading a last line without a newline.
    pub fn finish(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let held = self.head.finish();
        self.release(held, buses, sink);
        let last = self.begun.end();
        if !last.is_empty() {
            self.line(&last, true, buses, sink);
        }
        self.gaps.settle(buses, sink);
    }

    /// Ends an interrupted file, ignoring an incomplete last line.
    pub fn interrupt(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let held = self.head.finish();
        self.release(held, buses, sink);
        self.gaps.settle(buses, sink);
        self.begun.end();
    }

    /// Returns the facts about the file beyond its frames.
    pub fn contents(&self) -> Contents {
        self.header.contents()
    }

    /// Returns the number of lines so far.
    pub fn lines(&self) -> u64 {
        self.lines
    }

    #[cold]
    fn too_long(&mut self, buses: &Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.lines += 1;
        self.error = None;
        sink(Item::Unreadable { place: FilePlace::Line(self.lines), reason: Unreadable::NoFrame }, buses);
    }

    /// Reads one line without its newline; `last` if it had none.
    #[inline(always)]
    fn line(&mut self, text: &[u8], last: bool, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.lines += 1;
        match classic::plain(text) {
            Some((mut frame, channel)) if !self.header.decimal => {
                self.error = None;
                if let Some(stamp) = &mut frame.stamp {
                    stamp.ns = Ns(self.clock.moment(stamp.ns.as_ns()));
                    frame.t_ns = Some(stamp.ns);
                }
                self.give(frame, channel, buses, sink);
            }
            _ => self.other_line(text, last, buses, sink),
        }
    }

    fn other_line(&mut self, text: &[u8], last: bool, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let text = skip_blanks(text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text)).trim_ascii_end();
        let text = listing::unmarked(listing::unquoted(text));
        let undamaged = listing::undamaged(text);
        // Damage, like the end of the file, may leave the beginning of something else.
        let (text, cut) = undamaged.map_or((text, last), |text| (text, true));
        let result = match text {
            [b'#', ..] | [b'/', b'/', ..] if undamaged.is_some() => Ok(()),
            [] | [b'#', ..] | [b'`', b'`', b'`', ..] => Ok(()),
            [b'/', b'/', ..] => {
                self.comment(text, buses, sink);
                return;
            }
            _ => match words::stamp(text) {
                Some((stamp, rest)) => {
                    let event = self.event(stamp, LineWords::new(rest), cut, buses, sink);
                    event.and_then(|()| without_further_event(rest))
                }
                None => match listing::omission(text) {
                    Some(omission) => {
                        self.gaps.mark(omission, FilePlace::Line(self.lines));
                        Ok(())
                    }
                    None => self.header_line(text).and_then(|()| without_further_event(text)),
                },
            },
        };
        self.error = None;
        let damaged = Fail { reason: Unreadable::NoFrame, end: false };
        if let Err(Fail { reason, end }) = if undamaged.is_some() { result.and(Err(damaged)) } else { result } {
            let reason = if last && end && undamaged.is_none() { Unreadable::Cut } else { reason };
            sink(Item::Unreadable { place: FilePlace::Line(self.lines), reason }, buses);
        }
    }

    fn header_line(&mut self, text: &[u8]) -> Result<(), Fail> {
        match self.header.line(text)? {
            Said::Nothing => {}
            Said::Relative(relative) => self.clock.set_relative(relative),
            Said::Date(date_ns) => self.clock.set_date(date_ns),
        }
        Ok(())
    }

    fn comment(&mut self, text: &[u8], buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let Some(note) = Note::read(text) else { return self.header.comment(text) };
        self.error = None;
        match note {
            Note::Channel(channel, name) => {
                let bus = buses.intern(&name);
                self.header.channel(channel, &name);
                self.channels.retain(|(known, _)| *known != channel);
                self.channels.truncate(MAX_CHANNELS - 1);
                self.channels.push((channel, bus));
            }
            Note::NoDate => self.clock.set_undated(),
            Note::Directions(known) => self.without_directions = !known,
            Note::Stamps(known) => self.without_stamps = !known,
            Note::Error(..) => self.error = Some(note),
            Note::LeftOut(count) => self.gaps.mark(Omission { count }, FilePlace::Line(self.lines)),
            Note::Dropped(count, channel, total) => {
                let place = FilePlace::Line(self.lines);
                let bus = self.bus(channel, buses);
                sink(Item::Marker(Marker::Dropped { bus, count, total, place }), buses);
            }
        }
    }

    /// Parses the words after a stamp.
    fn event(
        &mut self,
        mut stamp: Stamp,
        mut words: LineWords<'_>,
        last: bool,
        buses: &mut Buses,
        sink: &mut impl FnMut(Item, &Buses),
    ) -> Result<(), Fail> {
        // A difference is shown as the time that it means, since a file may have both kinds.
        stamp.ns = Ns(self.clock.moment(stamp.ns.as_ns()));
        let first = words.need(Unreadable::NoFrame)?;
        let is = |name: &[u8]| first.eq_ignore_ascii_case(name);
        let (fd, xl) = (is(b"canfd"), is(b"canxl"));
        let channel = match fd || xl {
            true => notes::channel(words.need(Unreadable::NoFrame)?),
            false if first.iter().all(u8::is_ascii_digit) => notes::channel(first),
            false => {
                self.other_event(first, words, last)?;
                return Ok(());
            }
        };
        let Some(channel) = channel else { return words.fail(Unreadable::NoFrame) };
        let event = if fd {
            let decimal = self.header.decimal && {
                self.fd_hexadecimal = fd::is_hexadecimal(words).unwrap_or(self.fd_hexadecimal);
                !self.fd_hexadecimal
            };
            fd::event(words, stamp, decimal, last)
        } else if xl {
            fd::xl_event(words, stamp, last)
        } else {
            classic::event(words, stamp, self.header.decimal, last)
        };
        match event? {
            Event::Frame(mut frame) => {
                frame.t_ns = Some(stamp.ns);
                self.give(frame, channel, buses, sink);
            }
            Event::Passed(name) => {
                words.next();
                self.other_event(name, words, last)?;
            }
        }
        Ok(())
    }

    /// Counts an event that is not a frame, if its kind is known; `words` follow the kind.
    fn other_event(&mut self, kind: &[u8], words: LineWords<'_>, last: bool) -> Result<(), Fail> {
        match kinds::of(kind, words, last) {
            Some(kind) => self.header.pass(kind),
            None => return Err(Fail { reason: Unreadable::NoFrame, end: words.is_empty() }),
        }
        Ok(())
    }

    /// Emits a frame.
    #[inline(always)]
    fn give(&mut self, mut frame: Frame, channel: AscChannel, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        frame.line = Some(self.lines);
        frame.bus = match self.channels.get(self.last) {
            Some((known, bus)) if *known == channel => *bus,
            _ => self.bus(channel, buses),
        };
        if self.without_directions || self.without_stamps || frame.kind == Kind::Error {
            self.restore(&mut frame);
        }
        if let Some(date_ns) = self.clock.start() {
            sink(Item::Marker(Marker::Start { date_ns: Ns(date_ns) }), buses);
        }
        self.gaps.row(buses, sink);
        sink(Item::Frame(frame), buses);
    }

    /// Restores the facts that this program's own comments give for a frame.
    fn restore(&mut self, frame: &mut Frame) {
        if self.without_directions {
            frame.dir = None;
        }
        if self.without_stamps {
            (frame.stamp, frame.t_ns) = (None, None);
        }
        if let Some(Note::Error(class, data)) = self.error.take()
            && frame.kind == Kind::Error
        {
            frame.id = class;
            frame.len = data.len() as u8;
            for (slot, byte) in frame.data.iter_mut().zip(data) {
                *slot = byte;
            }
        }
    }

    /// Returns the bus of a channel: `can0` for the first one. The invalid channel 0 has its own bus.
    fn bus(&mut self, channel: AscChannel, buses: &mut Buses) -> BusId {
        if let Some(index) = self.channels.iter().position(|(known, _)| *known == channel) {
            self.last = index;
        } else {
            let name = channel.checked_sub(1).map_or_else(|| "canX".to_owned(), |number| format!("can{number}"));
            let bus = buses.intern(name.as_bytes());
            self.header.channel(channel, name.as_bytes());
            self.last = self.channels.len().min(MAX_CHANNELS - 1);
            self.channels.truncate(MAX_CHANNELS - 1);
            self.channels.push((channel, bus));
        }
        self.channels.get(self.last).map_or(BusId(0), |(_, bus)| *bus)
    }
}

/// Fails if another event follows on the line because damage has changed the newline between them.
fn without_further_event(text: &[u8]) -> Result<(), Fail> {
    if memchr(b'.', text).is_none() {
        return Ok(());
    }
    let mut words = LineWords::new(text);
    while let Some(word) = words.next() {
        if words::stamp(word).is_none() {
            continue;
        }
        let mut event = words;
        let channel = event.next().unwrap_or_default();
        let is_channel = channel.iter().all(u8::is_ascii_digit) || channel.eq_ignore_ascii_case(b"canfd");
        if is_channel && event.next().is_some() && !event.is_empty() {
            return Err(Fail { reason: Unreadable::NoFrame, end: false });
        }
    }
    Ok(())
}

/// Returns the frame of a single line, if it has one in hexadecimal digits.
pub fn line(text: &[u8], buses: &mut Buses) -> Option<Frame> {
    let mut found = None;
    let mut reader = Asc::default();
    let text = text.strip_suffix(b"\n").unwrap_or(text);
    if memchr(b'\n', text).is_none() {
        reader.line(text, false, buses, &mut |item, _| {
            if let Item::Frame(frame) = item {
                found = Some(Frame { line: None, ..frame });
            }
        });
    }
    found
}

//! Text captures of can-utils: log files, console output, and pastes of both.
//!
//! This file cuts the input into lines and classifies each by its content alone: a file may mix both families, comments
//! and pasted prompts. Prose never becomes a frame, and a damaged frame never passes as a comment or another frame.
//! Memory is bounded for any input.

mod console;
mod general;
pub(super) mod lex;
mod log;
pub(super) mod stamp;
#[cfg(test)]
mod tests;
mod wreck;

use memchr::memchr;

use self::general::{Line, LineContent, Numbers, general, is_begun_name, plain_text};
use self::lex::{Fail, skip_blanks, word};
use self::log::Plain;
use self::stamp::CandumpClock;
use self::wreck::Behind;
use super::lines::{self, Begun};
use super::listing::{Base, Gaps};
use super::{FilePlace, Item, Marker, Unreadable};
use crate::bytes::frame::{BusId, Buses, CanId, Frame, Kind, Stamp};
use crate::bytes::ns::Ns;

/// Number of bytes of a file that are examined for the meaning of its stamps.
const HEAD: usize = 64 * 1024;

/// Arrows that people write between a request and its response in one line.
const ARROWS: [&[u8]; 3] = [b"->", b"=>", b"\xE2\x86\x92"];

/// The meaning of small stamps of console lines (option `--stamps`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stamps {
    /// Detected: a backward step means differences.
    #[default]
    Auto,
    /// Seconds of a clock.
    Absolute,
    /// Seconds since the first frame of the capture (`-t z`).
    Zero,
    /// Seconds since the previous line (`-t d`).
    Delta,
}

impl Stamps {
    /// All meanings, with their names.
    pub const NAMES: &[(&str, Self)] =
        &[("auto", Self::Auto), ("absolute", Self::Absolute), ("zero", Self::Zero), ("delta", Self::Delta)];
}

/// A reader of one file of candump text.
#[derive(Debug)]
pub struct Candump {
    clock: CandumpClock,
    /// The beginning of a file, held back until the meaning of its stamps is known.
    head: Option<Vec<u8>>,
    begun: Begun,
    /// Buffer for a line without its colours.
    plain: Vec<u8>,
    /// The interface of the last plain line and its bus.
    interface: Vec<u8>,
    bus: BusId,
    lines: u64,
    /// The error frame whose explanation (`-e`) may follow on separate lines.
    explained: Option<Frame>,
    gaps: Gaps,
    /// True if the beginning of the file shows that a number before a frame is a row number and not an interface.
    rows: bool,
    /// True if its bytes are decimal, which is not supported.
    decimal: bool,
    behind: Behind,
}

impl Candump {
    /// Creates a reader. `regular`: it is a complete file, so ambiguous stamps are decided by its first 64 KiB.
    pub fn new(stamps: Stamps, regular: bool) -> Self {
        Self {
            clock: CandumpClock::new(stamps),
            head: (regular && stamps == Stamps::Auto).then(Vec::new),
            begun: Begun::default(),
            plain: Vec::new(),
            interface: Vec::new(),
            bus: BusId::default(),
            lines: 0,
            explained: None,
            gaps: Gaps::default(),
            rows: false,
            decimal: false,
            behind: Behind::default(),
        }
    }

    /// Feeds the next bytes, in any chunking.
    pub fn feed(&mut self, bytes: &[u8], buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.behind.feed(bytes);
        let Some(head) = &mut self.head else { return self.split(bytes, buses, sink) };
        let (taken, rest) = bytes.split_at_checked(HEAD - head.len()).unwrap_or((bytes, &[]));
        head.extend_from_slice(taken);
        if head.len() == HEAD {
            self.release_head(buses, sink);
            self.split(rest, buses, sink);
        }
    }

    /// Ends the file, reading the bytes held back and a last line without a newline.
    pub fn finish(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.release_head(buses, sink);
        let last = self.begun.end();
        if !last.is_empty() {
            self.line(&last, true, buses, sink);
        }
        self.gaps.settle(buses, sink);
    }

    /// Ends an interrupted file, ignoring an incomplete last line.
    pub fn interrupt(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.release_head(buses, sink);
        self.gaps.settle(buses, sink);
        self.begun.end();
    }

    /// Returns the number of lines so far.
    pub fn lines(&self) -> u64 {
        self.lines
    }

    fn release_head(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let Some(head) = self.head.take() else { return };
        // A last line cut by the limit is left out, since half a stamp is another stamp.
        let end = if head.len() < HEAD { head.len() } else { memchr::memrchr(b'\n', &head).unwrap_or(0) };
        let mut plain = Vec::new();
        let mut numbers = Numbers::default();
        let (mut base, mut decimal) = (Base::default(), None);
        let lines = head.get(..end).unwrap_or(&head).split(|&byte| byte == b'\n');
        self.clock.decide(lines.filter_map(|text| {
            let line = general(plain_text(text, &mut plain), false);
            numbers.take(&line);
            decimal = decimal.or_else(|| base.take(console::digits(text)?));
            line.stamp.filter(|_| line.console)
        }));
        self.rows = numbers.are_rows();
        self.decimal = decimal == Some(true);
        self.split(&head, buses, sink);
    }

    fn split(&mut self, bytes: &[u8], buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let mut begun = std::mem::take(&mut self.begun);
        let mut take = |line: Option<&[u8]>| self.line_or_not(line, buses, sink);
        let mut rest = begun.complete(bytes, &mut take);
        loop {
            // Where a plain line ends need not be looked for.
            if let Some(behind) = self.plain_line(rest, buses, sink) {
                rest = behind;
            } else if let Some((line, behind)) = lines::first(rest) {
                self.line_or_not(line, buses, sink);
                rest = behind;
            } else {
                break;
            }
        }
        begun.keep(rest, &mut |line| self.line_or_not(line, buses, sink));
        self.begun = begun;
    }

    /// Reads the first line of a text if it is a plain one that ends there; returns the text behind it.
    #[inline(always)]
    fn plain_line<'a>(
        &mut self,
        text: &'a [u8],
        buses: &mut Buses,
        sink: &mut impl FnMut(Item, &Buses),
    ) -> Option<&'a [u8]> {
        let (plain, [b'\n', behind @ ..] | [b'\r', b'\n', behind @ ..]) = Plain::parse(text, &self.interface)? else {
            return None;
        };
        if text.len() - behind.len() > lines::MAX_LINE + 1 {
            return None;
        }
        self.plain(&plain, buses, sink);
        Some(behind)
    }

    #[inline(always)]
    fn plain(&mut self, plain: &Plain<'_>, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.pass(plain, buses);
        let t_ns = self.timed(Some(plain.stamp), false, buses, sink);
        self.gaps.row(buses, sink);
        sink(Item::Frame(plain.frame(self.bus, self.lines, t_ns)), buses);
    }

    /// Counts a plain line, and takes its interface for those behind it.
    #[inline(always)]
    fn pass(&mut self, plain: &Plain<'_>, buses: &mut Buses) {
        self.lines += 1;
        self.explained = None;
        if let Some(name) = plain.interface {
            self.interface.clear();
            self.interface.extend_from_slice(name);
            self.bus = buses.intern(name);
        }
    }

    /// Reads one line without its newline; `None` for one that is too long.
    fn line_or_not(&mut self, line: Option<&[u8]>, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        match line {
            Some(line) => self.line(line, false, buses, sink),
            None => self.too_long(buses, sink),
        }
    }

    #[cold]
    fn too_long(&mut self, buses: &Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.lines += 1;
        self.explained = None;
        self.no_frame(buses, sink);
    }

    #[cold]
    #[inline(never)]
    fn no_frame(&self, buses: &Buses, sink: &mut impl FnMut(Item, &Buses)) {
        sink(Item::Unreadable { place: FilePlace::Line(self.lines), reason: Unreadable::NoFrame }, buses);
    }

    /// Reads one line without its newline; `last` if it had none.
    fn line(&mut self, text: &[u8], last: bool, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let plain = Plain::parse(text.strip_suffix(b"\r").unwrap_or(text), &self.interface);
        if let Some((plain, b"")) = plain {
            if !(last && self.behind.may_go_on(&plain.frame(self.bus, self.lines, None), text, false)) {
                return self.plain(&plain, buses, sink);
            }
            self.pass(&plain, buses);
            sink(Item::Unreadable { place: FilePlace::Line(self.lines), reason: Unreadable::Cut }, buses);
        } else if memchr(b'\r', text.trim_ascii()).is_some() {
            // Lines that end with a carriage return only.
            let mut lines = text.trim_ascii_end().split(|&byte| byte == b'\r').peekable();
            while let Some(line) = lines.next() {
                self.other_line(line, last && lines.peek().is_none(), buses, sink);
            }
        } else {
            self.other_line(text, last, buses, sink);
        }
    }

    fn other_line(&mut self, text: &[u8], last: bool, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.lines += 1;
        let mut plain = std::mem::take(&mut self.plain);
        let mut line = general(plain_text(text, &mut plain), self.rows);
        let indented = text.first() == Some(&b'\t');
        if indented && let Some(error) = &self.explained {
            let (frame, bare) = (&line.frame, line.stamp.is_none() && line.bus.is_empty());
            match line.what {
                LineContent::Unreadable(Fail { reason: Unreadable::NoFrame, .. }) => line.what = LineContent::Nothing,
                // candump -e has no words for some classes and prints the frame a second time.
                LineContent::Frame
                    if bare && (frame.kind, frame.id, frame.data) == (error.kind, error.id, error.data) =>
                {
                    line.what = LineContent::Nothing;
                }
                _ => {}
            }
        }
        match line.what {
            LineContent::Frame if line.frame.kind == Kind::Error && line.console && !indented => {
                self.explained = Some(line.frame);
            }
            LineContent::Nothing if indented => {}
            _ => self.explained = None,
        }
        if let LineContent::Unreadable(fail) = &mut line.what
            && last
            && (fail.end || is_begun_name(text, buses))
        {
            fail.reason = Unreadable::Cut;
        }
        let mut tail_damaged = false;
        match line.what {
            LineContent::Frame if self.decimal && line.console => {
                line.what = LineContent::Unreadable(Fail { reason: Unreadable::Data, end: false });
            }
            LineContent::Frame
                if last && line.tail.is_empty() && self.behind.may_go_on(&line.frame, text, line.console) =>
            {
                line.what = LineContent::Unreadable(Fail { reason: Unreadable::Cut, end: true });
            }
            LineContent::Frame => {
                line.frame.bus = buses.intern(line.bus);
                tail_damaged = !line.tail.is_empty() && wreck::is_tail_damaged(line.tail);
            }
            LineContent::Nothing if wreck::is_comment_damaged(plain_text(text, &mut Vec::new()), buses) => {
                line.what = LineContent::Unreadable(Fail { reason: Unreadable::NoFrame, end: false });
            }
            _ => {}
        }
        let (stamp, bus, tail) = (line.stamp, line.frame.bus, line.tail);
        let compact = matches!(line.what, LineContent::Frame) && !line.console;
        self.give(line, buses, sink);
        if tail_damaged {
            self.no_frame(buses, sink);
        } else if !tail.is_empty() {
            self.further((stamp, bus), (tail, compact), buses, sink);
        }
        self.plain = plain;
    }

    /// Hands on further frames in the text after one, `compact` or not; they have its time and bus, if no own ones.
    fn further(
        &mut self,
        (stamp, bus): (Option<Stamp>, BusId),
        (mut tail, compact): (&[u8], bool),
        buses: &mut Buses,
        sink: &mut impl FnMut(Item, &Buses),
    ) {
        loop {
            let text = tail.trim_ascii_start();
            if let Some(answer) = ARROWS.iter().find_map(|arrow| text.strip_prefix(*arrow)) {
                let mut line = general(answer, false);
                if !matches!(line.what, LineContent::Frame) {
                    return;
                }
                line.frame.bus = if line.bus.is_empty() { bus } else { buses.intern(line.bus) };
                (line.stamp, tail) = (line.stamp.or(stamp), line.tail);
                self.give(line, buses, sink);
                continue;
            }
            if !compact {
                return;
            }
            let text = skip_blanks(text.strip_prefix(b";").or(text.strip_prefix(b",")).unwrap_or(text));
            let (first, after) = word(text);
            let mut frame = Frame { bus, ..Frame::classic(CanId::standard(0), &[]) };
            if !log::is_meant(first) {
                return;
            }
            let Ok(rest) = log::frame(first, after, &mut frame) else { return };
            let what = LineContent::Frame;
            self.give(Line { stamp, console: false, bus: b"", row: None, what, frame, tail: b"" }, buses, sink);
            tail = rest;
        }
    }

    /// Returns the time of a stamp. `console`: it may be a difference.
    #[inline(always)]
    fn timed(
        &mut self,
        stamp: Option<Stamp>,
        console: bool,
        buses: &Buses,
        sink: &mut impl FnMut(Item, &Buses),
    ) -> Option<Ns> {
        let (moment, backward) = self.clock.moment(stamp?, console);
        if backward {
            sink(Item::Marker(Marker::Backward { place: FilePlace::Line(self.lines) }), buses);
        }
        Some(moment)
    }

    #[inline(always)]
    fn give(&mut self, line: Line<'_>, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let t_ns = self.timed(line.stamp, line.console, buses, sink);
        match (&line.what, line.row) {
            (LineContent::Frame | LineContent::Dropped { .. } | LineContent::Error, None) => self.gaps.row(buses, sink),
            (LineContent::Nothing | LineContent::LeftOut(_), _) | (_, None) => {}
            (_, Some(row)) => self.gaps.numbered(row, FilePlace::Line(self.lines), buses, sink),
        }
        let item = match line.what {
            LineContent::Nothing => return,
            LineContent::LeftOut(omission) => return self.gaps.mark(omission, FilePlace::Line(self.lines)),
            LineContent::Frame => Item::Frame(Frame { line: Some(self.lines), t_ns, stamp: line.stamp, ..line.frame }),
            LineContent::Dropped { count, total } => Item::Marker(Marker::Dropped {
                bus: buses.intern(line.bus),
                count,
                total,
                place: FilePlace::Line(self.lines),
            }),
            LineContent::Error => Item::Marker(Marker::Error {
                bus: buses.intern(line.bus),
                stamp: line.stamp,
                place: FilePlace::Line(self.lines),
            }),
            LineContent::Unreadable(Fail { reason, .. }) => {
                Item::Unreadable { place: FilePlace::Line(self.lines), reason }
            }
        };
        sink(item, buses);
    }
}

/// Parses a single line (for `canalyze explain`): returns its frame, or the reason if it is meant as one.
pub fn line(text: &[u8], buses: &mut Buses) -> Result<Frame, Option<Unreadable>> {
    let text = text.strip_suffix(b"\n").unwrap_or(text);
    let mut plain = Vec::new();
    let line = general(plain_text(text, &mut plain), false);
    match line.what {
        LineContent::Frame => {}
        LineContent::Unreadable(fail) if fail.reason != Unreadable::NoFrame => return Err(Some(fail.reason)),
        _ => return Err(None),
    }
    Ok(Frame { t_ns: line.stamp.map(|stamp| stamp.ns), stamp: line.stamp, bus: buses.intern(line.bus), ..line.frame })
}

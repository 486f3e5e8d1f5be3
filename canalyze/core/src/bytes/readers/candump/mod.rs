//! Text captures of can-utils: log files, console output, and pastes of both.
//!
//! This file cuts the input into lines and classifies each by its content alone: a file may mix both families, comments
//! and pasted prompts. Prose never becomes a frame, and a damaged frame never passes as a comment or another frame.
//! Memory is bounded for any input.

mod console;
pub(super) mod lex;
mod log;
pub(super) mod stamp;
#[cfg(test)]
mod tests;
mod wreck;

use memchr::{memchr, memchr3};

use self::lex::{is_blank, is_hex, is_name, skip_blanks, word};
use self::log::Plain;
use self::stamp::CandumpClock;
use self::wreck::Behind;
use super::lines::{self, Begun};
use super::listing::{self, Base, Gaps, Omission};
use super::{FilePlace, Item, Marker, Unreadable};
use crate::bytes::frame::{BusId, Buses, CanId, Direction, Frame, Kind, Stamp, StampForm};
use crate::bytes::ns::Ns;

/// Number of bytes of a file that are examined for the meaning of its stamps.
const HEAD: usize = 64 * 1024;

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
        } else if compact {
            self.further((stamp, bus), tail, buses, sink);
        }
        self.plain = plain;
    }

    /// Hands on further frames in the text after one; they have its time and bus.
    fn further(
        &mut self,
        (stamp, bus): (Option<Stamp>, BusId),
        mut tail: &[u8],
        buses: &mut Buses,
        sink: &mut impl FnMut(Item, &Buses),
    ) {
        loop {
            let text = tail.trim_ascii_start();
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

/// The content of a line.
#[derive(Debug)]
struct Line<'a> {
    stamp: Option<Stamp>,
    /// True if its stamp may be a difference; the compact family never prints differences.
    console: bool,
    /// The interface; empty if there is none.
    bus: &'a [u8],
    /// The number of the row, if any.
    row: Option<u64>,
    what: LineContent,
    /// The frame, if any, without line, stamp and time.
    frame: Frame,
    /// The text after the frame.
    tail: &'a [u8],
}

impl<'a> Line<'a> {
    /// Takes the result of parsing a frame; `Ok` is the text after it.
    fn made(&mut self, frame: Result<&'a [u8], Fail>) -> LineContent {
        match frame {
            Ok(tail) => {
                self.tail = tail;
                LineContent::Frame
            }
            Err(fail) => LineContent::Unreadable(fail),
        }
    }

    /// Returns true if it was meant as a frame or a marker of candump.
    fn is_meant(&self) -> bool {
        match self.what {
            LineContent::Frame | LineContent::Dropped { .. } | LineContent::Error => true,
            LineContent::Unreadable(fail) => fail.reason != Unreadable::NoFrame || self.stamp.is_some(),
            LineContent::Nothing | LineContent::LeftOut(_) => false,
        }
    }
}

#[derive(Clone, Copy, Debug)]
enum LineContent {
    /// Blank, a comment, a prompt.
    Nothing,
    Frame,
    Dropped {
        count: u64,
        total: u64,
    },
    Error,
    /// Rows left out here.
    LeftOut(Omission),
    Unreadable(Fail),
}

/// The reason why a line is not a frame.
#[derive(Clone, Copy, Debug)]
struct Fail {
    reason: Unreadable,
    /// True if nothing was wrong up to the end of the line, so that more text could have made it a frame.
    end: bool,
}

/// Parses any line, already without colours. `rows`: a bare number before a frame is a row number.
fn general(text: &[u8], rows: bool) -> Line<'_> {
    let text = skip_blanks(text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text)).trim_ascii_end();
    let whole = text;
    let unquoted = listing::unquoted(text);
    let text = listing::unmarked(unquoted);
    if text.len() < unquoted.len() {
        let line = general(text, rows);
        // Mark-up around anything else is part of it.
        if line.is_meant() || matches!(line.what, LineContent::LeftOut(_)) {
            return line;
        }
    }
    let text = unquoted;
    if let Some((number, rest, bare)) = listing::numbered(text) {
        let line = unnumbered(rest);
        // `1  601   [8] ...` may also have an interface named by a number.
        if line.is_meant() && (!bare || rows || line.stamp.is_some() || !line.bus.is_empty()) {
            return Line { row: Some(number), ..line };
        }
    }
    if let Some(item) = listing::item(text)
        && let line @ Line { what: LineContent::Frame, .. } = unnumbered(listing::unmarked(item))
    {
        return line;
    }
    let mut line = unnumbered(text);
    if let LineContent::Nothing | LineContent::Unreadable(Fail { reason: Unreadable::NoFrame, .. }) = line.what {
        match listing::omission(text) {
            Some(omission) => (line.stamp, line.what) = (None, LineContent::LeftOut(omission)),
            // A quotation without a frame is prose.
            None if text.len() < whole.len() && line.stamp.is_none() && !holds_frame(text) => {
                line.what = LineContent::Nothing
            }
            None if matches!(line.what, LineContent::Nothing) && !listing::is_comment(text) && holds_frame(text) => {
                line.what = LineContent::Unreadable(Fail { reason: Unreadable::NoFrame, end: false });
            }
            None => {}
        }
    }
    line
}

/// Parses a line after its number.
fn unnumbered(text: &[u8]) -> Line<'_> {
    let frame = Frame::classic(CanId::standard(0), &[]);
    let mut line =
        Line { stamp: None, console: false, bus: b"", row: None, what: LineContent::Nothing, frame, tail: b"" };
    let Some(first) = text.first() else { return line };
    let rest = match stamp::read(text) {
        Some((stamp, rest)) if rest.first().is_none_or(|&byte| is_blank(byte)) => {
            line.stamp = Some(stamp);
            skip_blanks(rest)
        }
        _ if first.is_ascii_alphanumeric() => text,
        _ => {
            line.what = without_frame(text);
            return line;
        }
    };
    if line.stamp.is_none()
        && let Some((stamp, rest)) = stamp::bare(text)
    {
        let mut stamped = Line { stamp: Some(stamp), what: LineContent::Nothing, ..line };
        if let what @ LineContent::Frame = words(skip_blanks(rest), &mut stamped) {
            return Line { what, ..stamped };
        }
    }
    if let Some(dropped) = rest.strip_prefix(b"DROPCOUNT: ") {
        (line.bus, line.what) = drops(dropped);
        return line;
    }
    line.what = words(rest, &mut line);
    if let LineContent::Unreadable(Fail { reason: Unreadable::NoFrame, .. }) = line.what {
        let comment = match line.stamp {
            // (254) and the text after it.
            Some(stamp) => stamp.form == StampForm::Seconds && stamp.decimals == 0,
            None => is_prompt(text),
        };
        if comment {
            (line.stamp, line.what) = (None, LineContent::Nothing);
        }
    }
    line
}

/// Returns true if a frame follows other words of the line, none of them a command: it is neither a valid frame nor a
/// comment.
fn holds_frame(text: &[u8]) -> bool {
    const WORDS: usize = 16;
    let mut rest = text;
    for _ in 0..WORDS {
        let (first, after) = word(rest);
        let mut frame = Frame::classic(CanId::standard(0), &[]);
        let console = console::is_meant(rest) && console::frame(rest, &mut frame).is_ok();
        if TOOLS.contains(&first) {
            return false;
        }
        if console || log::is_meant(first) && log::frame(first, b"", &mut frame).is_ok() {
            return true;
        }
        rest = skip_blanks(after);
        if rest.is_empty() {
            break;
        }
    }
    false
}

/// The words in place of an interface, in the lines at the beginning of a file.
#[derive(Debug, Default)]
struct Numbers {
    last: u64,
    count: u64,
    /// True if any is not an increasing number.
    other: bool,
}

impl Numbers {
    fn take(&mut self, line: &Line<'_>) {
        if !line.console || !matches!(line.what, LineContent::Frame) {
            return;
        }
        let number = std::str::from_utf8(line.bus).ok().and_then(|name| name.parse().ok());
        self.other |= number.is_none_or(|number| self.count > 0 && number <= self.last);
        self.last = number.unwrap_or(0);
        self.count += 1;
    }

    /// Returns true if they are row numbers, since no bus has another name on each line.
    fn are_rows(&self) -> bool {
        self.count >= 3 && !self.other
    }
}

/// Parses the words after the stamp: interface and frame, or frame alone, in either family.
fn words<'a>(text: &'a [u8], line: &mut Line<'a>) -> LineContent {
    let (first, after) = word(text);
    if log::is_meant(first) {
        let frame = log::frame(first, after, &mut line.frame);
        return line.made(frame);
    }
    let rest = skip_blanks(after);
    let (second, after) = word(rest);
    if log::is_meant(second) && is_name(first) {
        let frame = log::frame(second, after, &mut line.frame);
        let what = line.made(frame);
        match console::way(first) {
            Some(way) => _ = line.frame.dir.get_or_insert(way),
            None => line.bus = interface(first),
        }
        return what;
    }
    if console::is_meant(text) {
        line.console = true;
        let frame = console::frame(text, &mut line.frame);
        return line.made(frame);
    }
    let stamped = line.stamp.is_some();
    if is_label(first) && console::is_meant(rest) {
        line.console = true;
        let frame = console::frame(rest, &mut line.frame);
        return line.made(frame);
    }
    if rest.is_empty() || !is_name(first) {
        line.console = stamped;
        return LineContent::Unreadable(Fail { reason: Unreadable::NoFrame, end: rest.is_empty() && stamped });
    }
    line.console = true;
    if second == b"ERROR" && after.is_empty() && (stamped || first.iter().any(u8::is_ascii_digit)) {
        line.bus = interface(first);
        return LineContent::Error;
    }
    let frame = console::frame(rest, &mut line.frame);
    let mut what = line.made(frame);
    match &mut what {
        LineContent::Frame => match said(first) {
            Some(way) => line.frame.dir = line.frame.dir.or(way),
            None => line.bus = interface(first),
        },
        // Two words of prose are not a cut frame: a stamp, a direction or a numbered interface is required.
        LineContent::Unreadable(fail) => fail.end &= stamped || first.iter().any(u8::is_ascii_digit),
        _ => {}
    }
    what
}

/// Returns the interface that a word names: colons behind a name are no part of it.
fn interface(word: &[u8]) -> &[u8] {
    let end = word.iter().rposition(|byte| *byte != b':').map_or(word.len(), |end| end + 1);
    word.get(..end).unwrap_or(word)
}

/// Words before a frame that say what it is, beside those for its direction; no interface has such a name.
const KINDS: [&str; 12] = [
    "request",
    "response",
    "answer",
    "reply",
    "client",
    "server",
    "master",
    "slave",
    "sdo",
    "pdo",
    "emcy",
    "heartbeat",
];

/// Returns the direction, if any, in a word that says what a frame is; `None` for other words.
fn said(word: &[u8]) -> Option<Option<Direction>> {
    let end = word.iter().rposition(|byte| byte.is_ascii_alphanumeric()).map_or(0, |end| end + 1);
    let word = word.get(..end)?.to_ascii_lowercase();
    match word.as_slice() {
        b"t" | b"out" => Some(Some(Direction::Tx)),
        b"r" | b"in" => Some(Some(Direction::Rx)),
        _ if KINDS.iter().any(|kind| kind.as_bytes() == word) => Some(None),
        _ => listing::direction(&word).map(Some),
    }
}

/// Returns true for a word before an identifier that labels the column and is not an interface.
fn is_label(word: &[u8]) -> bool {
    let word = word.strip_suffix(b":").unwrap_or(word);
    [&b"id"[..], b"cob-id", b"cobid", b"can-id"].iter().any(|label| word.eq_ignore_ascii_case(label))
}

/// Classifies a line that begins with neither a stamp nor a letter nor a digit.
fn without_frame(text: &[u8]) -> LineContent {
    if is_clock(text) {
        return LineContent::Unreadable(Fail { reason: Unreadable::NoFrame, end: false });
    }
    if stamp::is_meant(text) {
        return LineContent::Unreadable(Fail { reason: Unreadable::NoFrame, end: memchr(b')', text).is_none() });
    }
    let mark = match text.first() {
        Some(first) if first.is_ascii() => first.is_ascii_punctuation(),
        // An arrow or a bullet begins a comment; a letter of another script is prose, like a Latin one.
        _ => first_char(text).is_some_and(|char| !char.is_alphanumeric() && !char.is_control()),
    };
    if mark { LineContent::Nothing } else { LineContent::Unreadable(Fail { reason: Unreadable::NoFrame, end: false }) }
}

/// Returns true for `[12:34:56.789] ...`, a time of other loggers: the text after it is meant but never candump's.
fn is_clock(text: &[u8]) -> bool {
    let Some(inner) = text.strip_prefix(b"[") else { return false };
    let digits = inner.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let behind = inner.get(digits..).unwrap_or_default();
    digits > 0 && matches!(behind, [b':' | b'.' | b'-', digit, ..] if digit.is_ascii_digit())
}

fn first_char(text: &[u8]) -> Option<char> {
    (2..=4).find_map(|len| std::str::from_utf8(text.get(..len)?).ok()?.chars().next())
}

/// Parses `dropped 3 CAN frames on 'can0' socket (total drops 5)`, where the name may include candump's filters.
fn drops(text: &[u8]) -> (&[u8], LineContent) {
    let read = || {
        let (count, rest) = number(text.strip_prefix(b"dropped ")?)?;
        let rest = rest.strip_prefix(b" CAN frame")?;
        let rest = rest.strip_prefix(b"s").unwrap_or(rest).strip_prefix(b" on '")?;
        let end = memchr(b'\'', rest)?;
        let name = rest.get(..end)?.split(|&byte| byte == b',').next()?;
        let rest = rest.get(end..)?.strip_prefix(b"' socket (total drops ")?;
        let (total, rest) = number(rest)?;
        rest.starts_with(b")").then_some((name, LineContent::Dropped { count, total }))
    };
    read().unwrap_or((b"", LineContent::Unreadable(Fail { reason: Unreadable::NoFrame, end: false })))
}

fn number(text: &[u8]) -> Option<(u64, &[u8])> {
    let end = text.iter().position(|byte| !byte.is_ascii_digit()).unwrap_or(text.len());
    let (digits, rest) = text.split_at_checked(end)?;
    Some((std::str::from_utf8(digits).ok()?.parse().ok()?, rest))
}

/// Commands whose arguments are not recorded frames.
const TOOLS: [&[u8]; 7] = [b"candump", b"cansend", b"cangen", b"canplayer", b"cansniffer", b"canopend", b"sudo"];

/// Returns true for a command line of a shell, pasted together with its output.
fn is_prompt(text: &[u8]) -> bool {
    let (first, rest) = word(text);
    // user@host:~$ candump can0, and with a blank before the dollar
    let at = memchr(b'@', first).is_some();
    let mark = |word: &[u8]| matches!(word.last(), Some(b'$' | b'#' | b'%' | b'>'));
    let command = TOOLS.contains(&first) && !rest.is_empty();
    command || at && (mark(first) || mark(word(skip_blanks(rest)).0)) || first.ends_with(b"$") && !rest.is_empty()
}

/// Returns true if the line is the beginning of a known interface name.
fn is_begun_name(text: &[u8], buses: &Buses) -> bool {
    let text = text.trim_ascii();
    !text.is_empty() && buses.names().any(|name| name.starts_with(text)) && !is_hex(text)
}

/// Returns the line without ANSI escapes (`-c`), and with plain blanks instead of those of web pages.
#[inline]
fn plain_text<'a>(text: &'a [u8], room: &'a mut Vec<u8>) -> &'a [u8] {
    const ESC: u8 = 0x1B;
    if memchr3(ESC, 0xC2, 0xE2, text).is_none() {
        return text;
    }
    room.clear();
    let mut rest = text;
    while let Some(at) = memchr3(ESC, 0xC2, 0xE2, rest) {
        room.extend_from_slice(rest.get(..at).unwrap_or_default());
        rest = rest.get(at..).unwrap_or_default();
        // ESC [ parameters letter; any other ESC is removed by itself.
        if let [ESC, b'[', sequence @ ..] = rest {
            let end = sequence.iter().position(|byte| !matches!(byte, b'0'..=b'?' | b' '..=b'/'));
            rest = sequence.get(end.map_or(sequence.len(), |end| end + 1)..).unwrap_or_default();
            continue;
        }
        let (kept, after) = match rest {
            [ESC, after @ ..] => (&b""[..], after),
            // U+00A0, U+2000 to U+200A and U+202F have a width; U+200B to U+200F have none.
            [0xC2, 0xA0, after @ ..] | [0xE2, 0x80, 0x80..=0x8A | 0xAF, after @ ..] => (&b" "[..], after),
            [0xE2, 0x80, 0x8B..=0x8F, after @ ..] => (&b""[..], after),
            _ => rest.split_at_checked(1).unwrap_or((rest, &[])),
        };
        room.extend_from_slice(kept);
        rest = after;
    }
    room.extend_from_slice(rest);
    room
}

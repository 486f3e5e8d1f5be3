//! Rows of frames that other programs list: an identifier and bytes, with time, direction, length and channel in some
//! order.
//!
//! A heading names the columns (`columns`), in a table with commas, semicolons, tabs, bars or blanks between them. Without
//! one, the rows themselves show their columns: the first rows wait until all of them agree on a layout. A length that
//! is listed must be the number of the bytes. Rows may stand inside other text (`prose`). Lines around the rows are no
//! damage; a line that looks like a row and does not fit is unreadable.

mod columns;
mod echoed;
mod layout;
mod learnt;
mod marked;
mod objects;
mod pairs;
mod prose;
mod row;
mod times;
mod words;

use std::borrow::Cow;

use self::columns::Column::{self, Id, Other, Time};
use self::columns::{SECOND, Separator};
use self::echoed::Echoed;
use self::layout::{RowLayout, heading};
use self::learnt::{guess, learn};
use self::marked::self_describing;
use self::row::{CLASSIC, Row, channel};
use super::candump::Stamps;
use super::lines::Begun;
use super::listing::{Gaps, is_damaged, omission, unmarked, unquoted};
use super::{Contents, FilePlace, Item, Unreadable};
use crate::bytes::frame::{Buses, CanId, Frame, Kind};
use crate::bytes::ns::Ns;

/// Number of lines that wait until their layout is known, of a file and of a pipe, doubled until something shows that they
/// are rows, and the most.
const LEARNT: usize = 64;
const LEARNT_OF_PIPE: usize = 8;
const KEPT: usize = 16_384;
/// Maximum length of a row, in bytes.
const LONGEST: usize = 1024;
/// The width of a time of day, which needs no unit.
const CLOCK: u8 = 5;

/// A reader of one file of rows.
#[derive(Debug, Default)]
pub struct Rows {
    begun: Begun,
    lines: u64,
    layout: Option<RowLayout>,
    /// The first lines, with their numbers, until their layout is known.
    waiting: Vec<(u64, Vec<u8>)>,
    /// The layout is complete.
    learnt: bool,
    /// It is a complete file, and no pipe.
    regular: bool,
    /// The begin of an object that is spread over several lines.
    object: Vec<u8>,
    echoed: Echoed,
    clock: AdapterClock,
    gaps: Gaps,
    /// The last line that was a row, or meant as one.
    read_line: u64,
    /// The last line, if it has no end.
    open_line: u64,
    /// The program whose rows say that they are its own.
    program: Option<&'static str>,
}

/// The clock of an adapter that begins again.
#[derive(Debug, Default)]
struct AdapterClock {
    last_ns: Ns,
    wraps_ns: Ns,
    /// Each stamp counts from the one before it.
    relative: bool,
    /// The time of the turns so far, or of relative stamps.
    turns_ns: Ns,
}

impl AdapterClock {
    /// Returns the time of a stamp, counted from the first turn.
    fn moment(&mut self, ns: Ns, wraps_ns: Ns) -> Ns {
        if self.relative {
            self.turns_ns += ns;
            return self.turns_ns;
        }
        self.wraps_ns = self.wraps_ns.max(wraps_ns);
        if wraps_ns > Ns::ZERO && ns < std::mem::replace(&mut self.last_ns, ns) {
            self.turns_ns += self.wraps_ns;
        }
        if wraps_ns > Ns::ZERO { self.turns_ns + ns } else { ns }
    }
}

impl Rows {
    /// Creates a reader. `regular`: it is a complete file, so more rows may decide their layout.
    pub fn new(stamps: Stamps, regular: bool) -> Self {
        let clock = AdapterClock { relative: stamps == Stamps::Delta, ..AdapterClock::default() };
        Self { clock, regular, ..Self::default() }
    }

    /// Returns true if rows wait until their layout is known.
    pub fn holds(&self) -> bool {
        !self.learnt && !self.waiting.is_empty()
    }

    /// Reads the rows that wait, since no others come for now. A heading may still be followed by its first row.
    pub fn rest(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        if self.holds() {
            self.decide(false, buses, sink);
        }
    }

    /// Feeds the next bytes, in any chunking.
    pub fn feed(&mut self, bytes: &[u8], buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let mut begun = std::mem::take(&mut self.begun);
        begun.cut(bytes, &mut |line| {
            self.lines += 1;
            match line {
                Some(line) => self.line(line, buses, sink),
                None => sink(unreadable(self.lines, Unreadable::NoFrame), buses),
            }
        });
        self.begun = begun;
    }

    /// Ends the file.
    pub fn finish(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let last = self.begun.end();
        if !last.is_empty() {
            self.lines += 1;
            self.open_line = self.lines;
            self.line(&last, buses, sink);
        }
        self.end_echoed(buses, sink);
        self.decide(false, buses, sink);
        // A last line without its end begins like a row.
        let begun = last.first().is_some_and(u8::is_ascii_digit) && self.learnt;
        if begun && self.read_line < self.lines {
            sink(unreadable(self.lines, Unreadable::Cut), buses);
        }
        self.gaps.settle(buses, sink);
        if pairs::pairs(&self.object).any(|pair| matches!(Column::of(&pair), Id(_))) {
            sink(unreadable(self.lines, Unreadable::Cut), buses);
        }
    }

    /// Ends an interrupted file, ignoring an incomplete last line.
    pub fn interrupt(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.begun.end();
        self.decide(false, buses, sink);
        self.gaps.settle(buses, sink);
    }

    /// Returns the columns, for `info`.
    pub fn contents(&self) -> Contents {
        let columns = self.layout.iter().flat_map(|layout| &layout.columns).map(|column| column.word());
        let mut words: Vec<&str> = columns.filter(|word| *word != Other.word()).collect();
        words.dedup();
        let columns = (!words.is_empty()).then(|| ("columns", words.join(" ").into_bytes()));
        let program = self.program.map(|name| ("program", name.as_bytes().to_vec()));
        let dialect = program.into_iter().chain(columns).collect();
        Contents { dialect, ..Contents::default() }
    }

    /// Takes a line, or several that only their form parts: with a carriage return, or as socketcand writes them.
    fn line(&mut self, text: &[u8], buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        for part in parts(text) {
            let plain = plain(part);
            let mut text = plain.trim_ascii();
            if self.echoed.take(text) {
                continue;
            }
            self.end_echoed(buses, sink);
            if Echoed::begins(text) {
                self.echoed.begin();
                continue;
            }
            let object;
            // A line with an open brace begins an object, until a row is in it.
            let braced = text.ends_with(b"{") || text.starts_with(b"{") && pairs::is_open(text);
            let begins = braced && !pairs::pairs(&self.object).any(|pair| matches!(Column::of(&pair), Id(_)));
            if begins || !self.object.is_empty() && !is_row_alone(text, true) {
                self.object.truncate(if begins || self.object.len() > LONGEST { 0 } else { LONGEST });
                self.object.extend_from_slice(text);
                self.object.push(b' ');
                if pairs::is_open(&self.object) {
                    continue;
                }
                object = std::mem::take(&mut self.object);
                text = &object;
            }
            for row in objects::rows(text) {
                self.part(row, buses, sink);
            }
        }
    }

    fn end_echoed(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        if let Some(row) = self.echoed.end() {
            self.part(&row, buses, sink);
        }
    }

    fn part(&mut self, text: &[u8], buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let by_names = objects::layout(text);
        let text = if by_names.is_some() { text.trim_ascii() } else { stripped(text) };
        if let Some((row, program)) = self_describing(text) {
            self.decide(false, buses, sink);
            self.program.get_or_insert(program);
            self.read_line = self.lines;
            self.gaps.row(buses, sink);
            return self.clock.give(&row, self.lines, false, buses, sink);
        }
        self.clock.relative |= text == b"***RELATIVE MODE***";
        let goes_on = self.layout.as_ref().is_some_and(|layout| layout.separator == Separator::Pairs);
        let named = by_names.is_some();
        if let Some(layout) = by_names.filter(|_| !goes_on).or_else(|| heading(text).filter(|_| !named)) {
            self.decide(false, buses, sink);
            self.waiting.clear();
            (self.layout, self.learnt) = (Some(layout), false);
            if !named {
                return;
            }
        }
        if text.is_empty() || text.first() == Some(&b'#') {
            return;
        }
        if self.learnt {
            return self.row(text, self.lines, buses, sink);
        }
        // Between rows that need no layout.
        if self.program.is_some() {
            if let Some(omission) = omission(text) {
                return self.gaps.mark(omission, FilePlace::Line(self.lines));
            }
            if marked::is_meant(text) {
                return sink(unreadable(self.lines, Unreadable::Data), buses);
            }
        }
        if text.len() <= LONGEST && self.waiting.len() < KEPT {
            self.waiting.push((self.lines, text.to_vec()));
            let count = self.waiting.len();
            let least = if self.regular { LEARNT } else { LEARNT_OF_PIPE };
            if count >= least && count.is_power_of_two() {
                self.decide(count < KEPT, buses, sink);
            }
        } else if is_damaged(text) {
            sink(unreadable(self.lines, Unreadable::NoFrame), buses);
        }
    }

    /// Learns from the lines that wait what the layout of the rows is, and reads them. Without any sign of one they wait on,
    /// and if `more` lines may show the base of the identifiers.
    fn decide(&mut self, more: bool, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        if self.learnt {
            return;
        }
        let texts: Vec<&[u8]> = self.waiting.iter().map(|(_, text)| text.as_slice()).collect();
        // A heading whose columns are not those of its rows names nothing.
        let fits = |layout: &RowLayout| {
            texts.is_empty() || layout.refused.is_some() || texts.iter().any(|text| layout.reads(text))
        };
        let named = match &self.layout {
            None => None,
            Some(layout) => {
                // Its first word may only mark it as a comment.
                let unmarked = layout.without_first().and_then(|layout| layout.completed(&texts, more)).filter(fits);
                let Some(layout) = layout.clone().completed(&texts, more) else { return };
                Some(layout).filter(|layout| fits(layout) || unmarked.is_none()).or(unmarked)
            }
        };
        let named = named.filter(|layout| layout.separator != Separator::Pairs || layout.shows(&texts));
        let unit = |column: &Column| matches!(column, Time(unit) if *unit != SECOND);
        let untimed = named.as_ref().is_some_and(|layout| layout.columns.iter().any(unit));
        let learned = |texts: &[&[u8]]| learn(texts).map(|layout| RowLayout { untimed, ..layout });
        let Some(layout) = named.clone().filter(fits).or_else(|| learned(&texts)).or(named) else { return };
        (self.layout, self.learnt) = (Some(layout), true);
        for (line, text) in std::mem::take(&mut self.waiting).iter() {
            self.row(text, *line, buses, sink);
        }
    }

    fn row(&mut self, text: &[u8], line: u64, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let Self { layout: Some(layout), clock, gaps, read_line, open_line, .. } = self else { return };
        let before = std::mem::replace(read_line, line);
        if line == *open_line && (layout.ends_before_data(text) || !layout.decimal && ends_in_a_byte(text)) {
            return sink(unreadable(line, Unreadable::Cut), buses);
        }
        let (mut text, mut first): (&[u8], Option<Row<'_>>) = (text, None);
        loop {
            let found = if layout.named { layout.read(text) } else { layout.reads_again(text) };
            // Rows of another form may stand among them.
            let other =
                || prose::guess(text, false).map(|(_, row)| row).filter(|row| !layout.named && row.length.is_some());
            let read = found.is_some();
            let Some(row) = found.and_then(Row::whole).or_else(other).filter(|_| layout.refused.is_none()) else {
                if layout.is_meant(text) || is_damaged(text) || !read && prose::is_meant(text) {
                    sink(unreadable(line, layout.reason(text, read)), buses);
                    return;
                }
                *read_line = before;
                if let Some(omission) = omission(text) {
                    gaps.mark(omission, FilePlace::Line(line));
                }
                return;
            };
            let stamp = row.stamp.filter(|stamp| !layout.untimed || stamp.width == CLOCK);
            // The frames of one line have its time and its bus.
            let stamp = stamp.or(first.and_then(|first| first.stamp));
            let channel = first.map_or(row.channel, |first| first.channel);
            let row = Row { stamp, channel: if row.channel.is_empty() { channel } else { row.channel }, ..row };
            gaps.row(buses, sink);
            clock.give(&row, line, layout.filled, buses, sink);
            text = text.get(row.end..).filter(|_| row.end > 0).unwrap_or_default();
            if text.is_empty() {
                return;
            }
            first = first.or(Some(row));
        }
    }
}

impl AdapterClock {
    /// Hands on the frame of a row.
    fn give(&mut self, row: &Row<'_>, line: u64, filled: bool, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let Some((value, count)) = row.id else { return };
        let extended = row.extended.unwrap_or(value > 0x7FF || count > 4 && !filled);
        let id = match extended {
            false if value <= 0x7FF => CanId::standard(value as u16),
            true if value <= 0x1FFF_FFFF => CanId::extended(value),
            _ => return sink(unreadable(line, Unreadable::Identifier), buses),
        };
        let mut frame = Frame::classic(id, &[]);
        (frame.data, frame.len) = (row.data, row.count as u8);
        if row.error {
            // The classes of SocketCAN, if it has them.
            (frame.id, frame.kind) = (CanId::extended(value & 0x1FFF_FFFF), Kind::Error);
        } else if row.remote {
            (frame.kind, frame.len) = (Kind::Remote, row.code.or(row.length).unwrap_or(0).min(CLASSIC) as u8);
        } else if row.fd.is_some() || row.count > CLASSIC {
            let (brs, esi) = row.fd.unwrap_or_default();
            frame.kind = Kind::Fd { brs, esi };
        }
        frame.bus = buses.intern(channel(row.channel, row.first));
        (frame.line, frame.stamp, frame.dir) = (Some(line), row.stamp, row.direction);
        frame.t_ns = row.stamp.map(|stamp| self.moment(stamp.ns, row.wraps_ns));
        sink(Item::Frame(frame), buses);
    }
}

/// Iterates over the parts of a line: behind each carriage return, and each frame of socketcand, a line begins.
fn parts(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    let text = text.trim_ascii();
    let end = if text.starts_with(b"< ") && text.ends_with(b" >") { b'>' } else { b'\r' };
    text.split_inclusive(move |byte| *byte == end).map(move |part| part.strip_suffix(b"\r").unwrap_or(part))
}

/// Returns true if the last byte of a text has one digit, and the one before it two.
fn ends_in_a_byte(text: &[u8]) -> bool {
    let mut words = text.rsplit(|byte| !byte.is_ascii_hexdigit());
    let (last, before) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    last.len() == 1 && before.len() == 2
}

/// Returns true if a line of text is a heading or a row that only this reader reads; `alone`: whatever its columns.
pub(in crate::bytes::readers) fn is_row(text: &[u8], alone: bool) -> bool {
    parts(text).any(|part| objects::rows(&plain(part)).into_iter().any(|row| is_row_alone(row, alone)))
}

fn is_row_alone(text: &[u8], alone: bool) -> bool {
    if let Some(layout) = objects::layout(text) {
        return alone && layout.completed(&[text], false).is_some_and(|layout| layout.shows(&[text]));
    }
    let text = stripped(text);
    let shows = |(layout, row): &(RowLayout, Row<'_>)| layout.is_evident(row);
    heading(text).is_some()
        || self_describing(text).is_some()
        || alone
            && (guess(text, true).or_else(|| guess(text, false)).is_some_and(|found| shows(&found))
                || prose::guess(text, false).is_some_and(|found| shows(&found)))
}

/// Returns true if a text has an object, or a printed message, of several lines that is a row.
pub(in crate::bytes::readers) fn has_object(text: &[u8]) -> bool {
    let mut found = false;
    let braces = text.split(|byte| *byte == b'\n').any(|line| {
        let line = line.trim_ascii();
        Echoed::begins(line) || line.ends_with(b"{") || line.starts_with(b"{") && pairs::is_open(line)
    });
    if braces {
        let (mut rows, mut buses) = (Rows::default(), Buses::default());
        let mut take = |item: Item, _: &Buses| found |= matches!(item, Item::Frame(_));
        rows.feed(text, &mut buses, &mut take);
        rows.finish(&mut buses, &mut take);
    }
    found
}

/// Returns a line without what colours it on a terminal, and with digits and punctuation of ASCII in place of the wide ones of
/// Chinese editors.
fn plain(text: &[u8]) -> Cow<'_, [u8]> {
    const ESC: u8 = 0x1B;
    if memchr::memchr3(ESC, 0xE3, 0xEF, text).is_none() {
        return Cow::Borrowed(text);
    }
    let mut plain = Vec::new();
    let mut rest = text;
    while let Some(place) = memchr::memchr3(ESC, 0xE3, 0xEF, rest) {
        let (before, marked) = rest.split_at_checked(place).unwrap_or((rest, &[]));
        plain.extend_from_slice(before);
        let (sign, behind) = match marked {
            [0xEF, 0xBC, sign @ 0x81..=0xBF, behind @ ..] => (Some(sign - 0x60), behind),
            [0xEF, 0xBD, sign @ 0x80..=0x9E, behind @ ..] => (Some(sign - 0x20), behind),
            [0xE3, 0x80, 0x80, behind @ ..] => (Some(b' '), behind),
            [0xE3, 0x80, 0x81, behind @ ..] => (Some(b','), behind),
            [0xE3, 0x80, 0x90, behind @ ..] => (Some(b'['), behind),
            [0xE3, 0x80, 0x91, behind @ ..] => (Some(b']'), behind),
            [ESC, ..] => {
                let end = memchr::memchr(b'm', marked).map_or(marked.len(), |end| end + 1);
                (None, marked.get(end..).unwrap_or_default())
            }
            [other, behind @ ..] => (Some(*other), behind),
            [] => (None, marked),
        };
        plain.extend(sign);
        rest = behind;
    }
    plain.extend_from_slice(rest);
    Cow::Owned(plain)
}

fn unreadable(line: u64, reason: Unreadable) -> Item {
    Item::Unreadable { place: FilePlace::Line(line), reason }
}

fn stripped(text: &[u8]) -> &[u8] {
    let text = unquoted(text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text).trim_ascii());
    match text {
        // The cells of a table may be marked, too.
        [b'|', inner @ .., b'|'] | [b'|', inner @ ..] => inner.trim_ascii(),
        [b'`' | b'<', ..] | [.., b'>'] => unmarked(text),
        _ => text,
    }
}

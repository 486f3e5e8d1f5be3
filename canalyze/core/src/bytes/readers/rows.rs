//! Rows of frames that other programs list: an identifier and bytes, with time, direction, length and channel in some order.
//!
//! A heading names the columns ([`NAMES`]), in a table with commas, semicolons, tabs, bars or blanks between them. Without
//! one, the rows themselves show their columns: the first rows wait until all of them agree on a layout. A length that
//! is listed must be the number of the bytes. Lines around the rows are prose and no damage; a line that looks like a
//! row and does not fit is unreadable.

use super::candump::lex::{byte, is_blank, is_hex, nibble};
use super::candump::stamp::{digits, fraction, nanoseconds};
use super::lines::Begun;
use super::listing::{unmarked, unquoted};
use super::{Contents, FilePlace, Item, Unreadable};
use crate::bytes::calendar::{days_of, days_to};
use crate::bytes::frame::{Buses, CanId, Direction, Frame, Kind, Stamp, StampForm};

/// Number of rows that wait until their layout is known.
const LEARNT: usize = 64;
/// Maximum number of cells of a row.
const CELLS: usize = 96;
/// Maximum number of bytes of a frame, and of a classic one.
const BYTES: usize = 64;
const CLASSIC: usize = 8;
/// Lengths of CAN FD frames beyond those of classic ones, in bytes.
const LONGER: [usize; 7] = [12, 16, 20, 24, 32, 48, 64];

/// The content of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Column {
    /// A time in units of so many ns, as a decimal number or a time of day.
    Time(i64),
    /// Ticks of 0.1 ms, in hexadecimal digits (ZLG's adapters).
    Ticks,
    /// The identifier, in this base.
    Id(u32),
    Direction,
    Length,
    /// All bytes.
    Data,
    /// One byte.
    Byte,
    /// Words for standard or extended, data or remote.
    Attribute,
    /// True for an extended identifier.
    Extended,
    /// The channel, counted from this number.
    Channel(u8),
    Other,
}

use Column::{Attribute, Channel, Data, Extended, Id, Length, Other, Ticks, Time};

const SECOND: i64 = 1_000_000_000;
const MILLISECOND: i64 = 1_000_000;
const MICROSECOND: i64 = 1_000;

/// The names of columns in headings, in lower case and without what brackets say of them. Others have no meaning.
const NAMES: &[(&str, Column)] = &[
    ("time", Time(SECOND)),
    ("timestamp", Time(SECOND)),
    ("time stamp", Time(MICROSECOND)),
    ("time offset", Time(SECOND)),
    ("时间", Time(SECOND)),
    ("系统时间", Time(SECOND)),
    ("时间标识", Ticks),
    ("id", Id(16)),
    ("can id", Id(16)),
    ("can-id", Id(16)),
    ("canid", Id(16)),
    ("cob-id", Id(16)),
    ("identifier", Id(16)),
    ("message id", Id(16)),
    ("arbitration id", Id(16)),
    ("帧id", Id(16)),
    ("id号", Id(16)),
    ("dir", Column::Direction),
    ("direction", Column::Direction),
    ("rx/tx", Column::Direction),
    ("tx/rx", Column::Direction),
    ("传输方向", Column::Direction),
    ("方向", Column::Direction),
    ("len", Length),
    ("length", Length),
    ("dlc", Length),
    ("dl", Length),
    ("数据长度", Length),
    ("长度", Length),
    ("data", Data),
    ("data bytes", Data),
    ("payload", Data),
    ("数据", Data),
    ("extended", Extended),
    ("ext", Extended),
    ("ide", Extended),
    ("format", Attribute),
    ("type", Attribute),
    ("frame type", Attribute),
    ("帧格式", Attribute),
    ("帧类型", Attribute),
    ("bus", Channel(0)),
    ("channel", Channel(1)),
    ("chn", Channel(0)),
    ("通道", Channel(1)),
    ("通道号", Channel(1)),
    ("源通道", Channel(1)),
    ("can通道", Channel(1)),
];

/// The separator of the cells of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Separator {
    Byte(u8),
    Blanks,
}

/// The columns of a listing.
#[derive(Clone, Debug, PartialEq, Eq)]
struct RowLayout {
    separator: Separator,
    columns: Vec<Column>,
    /// The listed identifiers with eight digits are standard ones that were filled up with zeros.
    filled: bool,
    /// Hexadecimal digits of the length count before the bytes, as `08`.
    long_length: bool,
    /// The heading named the columns.
    named: bool,
    /// Identifiers and bytes are decimal.
    decimal: bool,
    /// The first numbers count the rows, and name no channel.
    counted: bool,
}

/// The parts of a row.
#[derive(Clone, Copy, Debug)]
struct Row<'a> {
    stamp: Option<Stamp>,
    id: Option<(u32, usize)>,
    direction: Option<Direction>,
    length: Option<usize>,
    data: [u8; BYTES],
    count: usize,
    extended: Option<bool>,
    remote: bool,
    /// CAN FD: bit rate switch, error state indicator.
    fd: Option<(bool, bool)>,
    /// The channel as written, and the number of the first one.
    channel: &'a [u8],
    first: u8,
    /// Identifiers and bytes are decimal.
    decimal: bool,
}

impl Default for Row<'_> {
    fn default() -> Self {
        Self {
            stamp: None,
            id: None,
            direction: None,
            length: None,
            data: [0; BYTES],
            count: 0,
            extended: None,
            remote: false,
            fd: None,
            channel: b"",
            first: 0,
            decimal: false,
        }
    }
}

/// A reader of one file of rows.
#[derive(Debug, Default)]
pub struct Rows {
    begun: Begun,
    lines: u64,
    layout: Option<RowLayout>,
    /// The first rows, with their line numbers, until their layout is known.
    waiting: Vec<(u64, Vec<u8>)>,
    /// The layout is complete.
    learnt: bool,
}

impl Rows {
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
            self.line(&last, buses, sink);
        }
        self.decide(buses, sink);
    }

    /// Ends an interrupted file, ignoring an incomplete last line.
    pub fn interrupt(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.begun.end();
        self.decide(buses, sink);
    }

    /// Returns the columns, for `info`.
    pub fn contents(&self) -> Contents {
        let columns = self.layout.iter().flat_map(|layout| &layout.columns).filter(|column| **column != Other);
        let mut words: Vec<&str> = columns.map(|column| column.word()).collect();
        words.dedup();
        let dialect = if words.is_empty() { Vec::new() } else { vec![("columns", words.join(" ").into_bytes())] };
        Contents { dialect, ..Contents::default() }
    }

    fn line(&mut self, text: &[u8], buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let text = stripped(text);
        if text.is_empty() || text.first() == Some(&b'#') {
            return;
        }
        if let Some(row) = self_describing(text) {
            return self.give(&row, self.lines, false, buses, sink);
        }
        if let Some(layout) = heading(text) {
            self.decide(buses, sink);
            (self.layout, self.learnt) = (Some(layout), false);
            return;
        }
        if self.learnt {
            return self.row(text, self.lines, buses, sink);
        }
        let named = self.layout.is_some();
        if named || is_alone(text) || guess(text, true).or_else(|| guess(text, false)).is_some() {
            self.waiting.push((self.lines, text.to_vec()));
            if self.waiting.len() >= LEARNT {
                self.decide(buses, sink);
            }
        }
    }

    /// Learns from the rows that wait what their layout is, and reads them.
    fn decide(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let waiting = std::mem::take(&mut self.waiting);
        let texts: Vec<&[u8]> = waiting.iter().map(|(_, text)| text.as_slice()).collect();
        let Some(layout) = self.layout.take().map(|layout| layout.completed(&texts)).or_else(|| learn(&texts)) else {
            return;
        };
        (self.layout, self.learnt) = (Some(layout), true);
        for (line, text) in &waiting {
            self.row(text, *line, buses, sink);
        }
    }

    fn row(&self, text: &[u8], line: u64, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let Some(layout) = &self.layout else { return };
        let found = if layout.named { layout.read(text) } else { layout.reads_again(text) };
        match found {
            Some(row) if row.whole().is_some() => self.give(&row, line, layout.filled, buses, sink),
            Some(_) if layout.is_meant(text) => sink(unreadable(line, Unreadable::Data), buses),
            // As many cells as a row has, and an identifier: it was meant as one.
            None if layout.is_meant(text) => sink(unreadable(line, Unreadable::NoFrame), buses),
            _ => {}
        }
    }

    fn give(&self, row: &Row<'_>, line: u64, filled: bool, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let Some((value, count)) = row.id else { return };
        let extended = row.extended.unwrap_or(value > 0x7FF || count > 4 && !filled);
        let id = match extended {
            false if value <= 0x7FF => CanId::standard(value as u16),
            true if value <= 0x1FFF_FFFF => CanId::extended(value),
            _ => return sink(unreadable(line, Unreadable::Identifier), buses),
        };
        let mut frame = Frame::classic(id, &[]);
        (frame.data, frame.len) = (row.data, row.count as u8);
        if row.remote {
            (frame.kind, frame.len) = (Kind::Remote, row.length.unwrap_or(0).min(CLASSIC) as u8);
        } else if row.fd.is_some() || row.count > CLASSIC {
            let (brs, esi) = row.fd.unwrap_or_default();
            frame.kind = Kind::Fd { brs, esi };
        }
        frame.bus = buses.intern(channel(row.channel, row.first));
        (frame.line, frame.stamp, frame.dir) = (Some(line), row.stamp, row.direction);
        frame.t_ns = row.stamp.map(|stamp| stamp.ns);
        sink(Item::Frame(frame), buses);
    }
}

/// Learns the layout of rows without a heading; `None` if nothing shows that they are frames.
fn learn(texts: &[&[u8]]) -> Option<RowLayout> {
    // A first byte that is the number of those behind it in every row is a length.
    let count = |long: bool| texts.iter().filter(|text| guess(text, long).is_some()).count();
    let counted = |text: &&[u8]| guess(text, true).is_some_and(|(_, row)| row.count > 0);
    let long = count(true) >= count(false) && texts.iter().any(counted);
    let rows: Vec<(RowLayout, Row<'_>)> = texts.iter().filter_map(|text| guess(text, long)).collect();
    if !rows.iter().any(|(layout, row)| layout.is_evident(row)) || rises_by_length(&rows) {
        return None;
    }
    let (layout, _) = rows.iter().find(|(_, row)| row.count > 0 || row.length.is_some())?;
    let small = rows.iter().all(|(_, row)| row.id.is_some_and(|(id, _)| id <= 0x7FF));
    // Numbers that rise by one from row to row count the rows.
    let channels: Vec<u32> = rows.iter().filter_map(|(_, row)| number(row.channel, 10)).collect();
    let rising = channels.len() > 1 && channels.iter().zip(channels.iter().skip(1)).all(|(one, next)| one + 1 == *next);
    let counted = rising || channels.iter().any(|channel| *channel > 8);
    Some(RowLayout { filled: small, counted, ..layout.clone() })
}

/// Returns true if a line is an identifier alone, as of a SYNC without data.
fn is_alone(text: &[u8]) -> bool {
    matches!(text.len(), 1..=3) && is_hex(text) && text.iter().any(u8::is_ascii_digit)
}

/// Returns true if each identifier is that of the row before plus the number of its bytes, as in a dump of memory.
fn rises_by_length(rows: &[(RowLayout, Row<'_>)]) -> bool {
    let ids: Vec<(u32, usize)> = rows.iter().filter_map(|(_, row)| Some((row.id?.0, row.count))).collect();
    let pairs = ids.iter().zip(ids.iter().skip(1));
    ids.len() > 1 && pairs.into_iter().all(|((id, count), (next, _))| *count > 0 && id + *count as u32 == *next)
}

/// Returns true if a line of text is a heading or a row that only this reader reads; `alone`: whatever its columns.
pub(super) fn is_row(text: &[u8], alone: bool) -> bool {
    let text = stripped(text);
    let shows = |(layout, row): &(RowLayout, Row<'_>)| layout.is_evident(row);
    heading(text).is_some()
        || self_describing(text).is_some()
        || alone && guess(text, true).or_else(|| guess(text, false)).is_some_and(|found| shows(&found))
}

fn unreadable(line: u64, reason: Unreadable) -> Item {
    Item::Unreadable { place: FilePlace::Line(line), reason }
}

fn stripped(text: &[u8]) -> &[u8] {
    let text = unquoted(text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text).trim_ascii());
    if matches!(text.first(), Some(b'|' | b'`' | b'<')) { unmarked(text) } else { text }
}

impl Column {
    /// The word in `info`.
    fn word(self) -> &'static str {
        match self {
            Time(_) | Ticks => "time",
            Id(_) => "id",
            Self::Direction => "direction",
            Length => "length",
            Data | Self::Byte => "data",
            Attribute | Extended => "format",
            Channel(_) => "channel",
            Other => "-",
        }
    }

    /// Returns the column with this name in a heading.
    fn named(name: &[u8]) -> Self {
        let name = String::from_utf8_lossy(name).to_lowercase();
        let (bare, said) = name.split_once(['(', '[']).unwrap_or((&name, ""));
        let said = said.trim_end_matches([')', ']']);
        let (bare, said) = match bare.trim().rsplit_once('_') {
            Some((bare, unit @ ("s" | "ms" | "us" | "ns"))) => (bare, unit),
            _ => (bare.trim(), said),
        };
        if let Some((_, column)) = NAMES.iter().find(|(known, _)| *known == bare) {
            return match (column, said) {
                (Id(_), "dec") => Id(10),
                (Time(_), "s") => Time(SECOND),
                (Time(_), "ms") => Time(MILLISECOND),
                (Time(_), "us" | "µs") => Time(MICROSECOND),
                (Time(_), "ns") => Time(1),
                _ => *column,
            };
        }
        let number = ["data", "byte", "d", "b"].iter().find_map(|prefix| name.strip_prefix(prefix));
        let number = number.map(str::trim).filter(|number| !number.is_empty() && number.len() <= 2);
        if number.is_some_and(|number| number.bytes().all(|digit| digit.is_ascii_digit())) { Self::Byte } else { Other }
    }
}

/// Returns the cells of a line, without quotation marks and blanks around them.
fn cells(text: &[u8], separator: Separator) -> Vec<&[u8]> {
    let parts: Vec<&[u8]> = match separator {
        Separator::Byte(sign) => {
            let mut quoted = false;
            let between = |byte: &u8| {
                quoted ^= *byte == b'"';
                *byte == sign && !quoted
            };
            text.split(between).take(CELLS).collect()
        }
        Separator::Blanks => text.split(|byte| is_blank(*byte)).filter(|cell| !cell.is_empty()).take(CELLS).collect(),
    };
    parts.into_iter().map(bare).collect()
}

/// Returns a cell without what spreadsheets put around it: blanks, quotation marks, `=`, `x|`.
fn bare(mut cell: &[u8]) -> &[u8] {
    loop {
        cell = cell.trim_ascii();
        cell = match cell {
            [b'=', b'"', inner @ .., b'"'] | [b'"', inner @ .., b'"'] => inner,
            [b'x' | b'X', b'|', inner @ ..] => inner,
            _ => return cell,
        };
    }
}

/// Reads a line as a heading: it names an identifier and bytes.
fn heading(text: &[u8]) -> Option<RowLayout> {
    // Each name of an identifier has these letters, and rows mostly begin with a digit.
    let named = text.windows(2).any(|pair| pair.eq_ignore_ascii_case(b"id"));
    if !named || text.first().is_some_and(u8::is_ascii_digit) {
        return None;
    }
    let separators = [b';', b',', b'\t', b'|'].map(Separator::Byte);
    separators.into_iter().chain([Separator::Blanks]).find_map(|separator| {
        let names = cells(text, separator);
        let mut columns: Vec<Column> = names.iter().map(|name| Column::named(name)).collect();
        let count = |of: fn(&Column) -> bool| columns.iter().filter(|column| of(column)).count();
        let ids = count(|column| matches!(column, Id(_)));
        let bytes = count(|column| matches!(column, Data | Column::Byte));
        let known = count(|column| *column != Other);
        // Between blanks there may be prose.
        let prose = separator == Separator::Blanks && (known < 3 || known * 2 < names.len());
        if ids != 1 || bytes == 0 || prose {
            return None;
        }
        let has = |name: &[u8]| names.iter().any(|known| known.eq_ignore_ascii_case(name));
        if has(b"protocol") {
            // Wireshark's length is that of the captured record.
            columns.iter_mut().filter(|column| **column == Length).for_each(|column| *column = Other);
        }
        if columns.contains(&Ticks) {
            // The clock of the adapter is finer than that of the system.
            columns.iter_mut().filter(|column| matches!(column, Time(_))).for_each(|column| *column = Other);
        }
        Some(RowLayout { separator, columns, named: true, ..RowLayout::new(separator) })
    })
}

impl RowLayout {
    fn new(separator: Separator) -> Self {
        let (filled, long_length, named, decimal, counted) = Default::default();
        Self { separator, columns: Vec::new(), filled, long_length, named, decimal, counted }
    }

    /// Reads a row below a heading, whose length may not be that of its bytes.
    fn read<'a>(&self, text: &'a [u8]) -> Option<Row<'a>> {
        let mut row = Row { decimal: self.decimal, ..Row::default() };
        let found = cells(text, self.separator);
        let mut rest = found.iter().copied().peekable();
        for column in &self.columns {
            match (column, self.separator) {
                (Data, Separator::Blanks) => {
                    let wanted = row.length.unwrap_or(CLASSIC);
                    while row.count < wanted
                        && let Some(cell) = rest.next_if(|cell| cell.len().is_multiple_of(2) && is_hex(cell))
                    {
                        row.bytes(cell)?;
                    }
                }
                _ => {
                    let Some(cell) = rest.next() else { break };
                    row.take(*column, cell)?;
                    if matches!(column, Id(_)) {
                        // `1802 (0x70a)`.
                        rest.next_if(|cell| cell.starts_with(b"(0x"))
                            .map(|hex| row.take(*column, hex))
                            .unwrap_or(Some(()))?;
                    }
                }
            }
        }
        row.id.is_some().then_some(row)
    }

    /// Completes the layout of a heading by the rows below it.
    fn completed(self, texts: &[&[u8]]) -> Self {
        let mut small = true;
        let (mut letters, mut decimal) = (false, false);
        for text in texts {
            let Some(found) = self.read(text) else { continue };
            small &= found.id.is_some_and(|(id, _)| id <= 0x7FF);
        }
        for text in texts {
            let found = cells(text, self.separator);
            let data = self.columns.iter().zip(&found).filter(|(column, _)| matches!(column, Data | Column::Byte));
            let parts = data.flat_map(|(_, cell)| cell.split(|byte| is_blank(*byte))).filter(|part| !part.is_empty());
            for part in parts.filter(|_| self.separator != Separator::Blanks) {
                letters |= part.iter().any(|byte| !byte.is_ascii_digit());
                // Bytes in hexadecimal digits have two of them.
                decimal |= matches!(part.len(), 1 | 3);
            }
        }
        Self { filled: small, decimal: decimal && !letters, ..self }
    }

    /// Returns true if a row without a heading shows that it is a frame: by its length and a time, a direction or the word
    /// CAN, or by a service of CANopen.
    fn is_evident(&self, row: &Row<'_>) -> bool {
        let told = self.columns.iter().any(|column| matches!(column, Time(_) | Column::Direction));
        let (id, data) = (row.id.map_or(0, |(id, _)| id), row.data.get(..row.count).unwrap_or_default());
        let sdo = matches!(id, 0x581..=0x5FF | 0x601..=0x67F) && data.len() == 8;
        let control = matches!(id, 0x701..=0x77F) && matches!(data, [0 | 4 | 5 | 0x7F]);
        row.length.is_some() && told || sdo || control
    }

    /// Reads a row without a heading, which must have the columns of the first one.
    fn reads_again<'a>(&self, text: &'a [u8]) -> Option<Row<'a>> {
        if self.columns == [Id(16), Data] && is_alone(text) {
            return number(text, 16).map(|id| Row { id: Some((id, 3)), ..Row::default() });
        }
        let (layout, row) = guess(text, self.long_length)?;
        let channel = if self.counted { &b""[..] } else { row.channel };
        (layout.columns == self.columns).then_some(Row { channel, ..row })
    }

    /// Returns true if a line has as many cells as a row, one of them an identifier.
    fn is_meant(&self, text: &[u8]) -> bool {
        let found = cells(text, self.separator);
        let least = self.columns.iter().filter(|column| !matches!(column, Column::Byte | Data)).count();
        let id = self.columns.iter().zip(&found).any(|(column, cell)| match column {
            Id(base) => number(cell, *base).is_some(),
            _ => false,
        });
        let bytes = |cell: &&[u8]| cell.len() <= 2 && is_hex(cell);
        found.len() >= least.max(2) && id && (self.named || found.last().is_some_and(bytes))
    }
}

impl<'a> Row<'a> {
    /// Takes the cell of a column; `None` if it cannot be one.
    fn take(&mut self, column: Column, cell: &'a [u8]) -> Option<()> {
        match column {
            // A time that cannot be read is none, and the frame is there.
            Time(unit) => self.stamp = time(cell, unit),
            Ticks if !cell.starts_with(b"0x") => self.stamp = time(cell, SECOND),
            Ticks => {
                let ticks = number(cell, 16);
                let ns = |ticks| i64::from(ticks) * (MILLISECOND / 10);
                self.stamp =
                    ticks.map(|ticks| Stamp { form: StampForm::Seconds, ns: ns(ticks), width: 1, decimals: 4 });
            }
            Id(base) => {
                let inner = cell.strip_prefix(b"(").and_then(|cell| cell.strip_suffix(b")"));
                let hex = cell.split(|byte| *byte == b'(').nth(1).and_then(|cell| cell.strip_suffix(b")"));
                let cell = inner.or(hex).unwrap_or(cell);
                let (word, extended) = match cell {
                    [word @ .., b'x' | b'X'] if word.len() >= 3 => (word, Some(true)),
                    [word @ .., b'h' | b'H' | b':'] => (word, None),
                    _ => (cell, None),
                };
                self.extended = self.extended.or(extended);
                let digits = word.strip_prefix(b"0x").or_else(|| word.strip_prefix(b"0X")).unwrap_or(word);
                let base = if self.decimal { 10 } else { base };
                self.id = Some((number(word, base)?, if base == 16 { digits.len() } else { 0 }));
            }
            Column::Direction if is_absent(cell) => {}
            Column::Direction => self.direction = Some(direction(cell)?),
            Length if cell.is_empty() => {}
            Length => self.length = Some(number(cell, 10).filter(|length| *length <= 64)? as usize),
            Data => {
                let between = |byte: &u8| is_blank(*byte) || matches!(byte, b',' | b'-' | b':');
                for part in cell.split(between).filter(|part| !part.is_empty()) {
                    self.bytes(part)?;
                }
            }
            Column::Byte if cell.is_empty() => {}
            Column::Byte => self.bytes(cell)?,
            Attribute => self.attribute(cell),
            Extended => self.extended = Some(matches!(cell, b"1" | b"x" | b"X") || cell.eq_ignore_ascii_case(b"true")),
            Channel(first) => (self.channel, self.first) = (cell, first),
            Other => {}
        }
        Some(())
    }

    /// Adds bytes: two digits each, or one digit.
    fn bytes(&mut self, text: &[u8]) -> Option<()> {
        let text = text.strip_prefix(b"0x").unwrap_or(text);
        if self.decimal {
            let byte = u8::try_from(number(text, 10)?).ok()?;
            *self.data.get_mut(self.count)? = byte;
            self.count += 1;
            return Some(());
        }
        let pairs: Vec<u8> = match text {
            [digit] => vec![Some(nibble(*digit)).filter(|digit| *digit < 16)?],
            _ if text.len().is_multiple_of(2) => {
                let pair = |pair: &[u8]| byte(*pair.first()?, *pair.get(1)?);
                text.chunks(2).map(pair).collect::<Option<_>>()?
            }
            _ => return None,
        };
        for byte in pairs {
            *self.data.get_mut(self.count)? = byte;
            self.count += 1;
        }
        Some(())
    }

    fn attribute(&mut self, cell: &[u8]) {
        let word = String::from_utf8_lossy(cell).to_lowercase();
        match word.as_str() {
            "true" | "ext" | "extended" | "x" | "扩展帧" | "扩展" => self.extended = Some(true),
            "false" | "std" | "standard" | "s" | "标准帧" | "标准" => self.extended = Some(false),
            "远程帧" | "远程" | "remote" | "rtr" | "r" => self.remote = true,
            _ => {}
        }
    }

    /// Returns the row if it is one: it has an identifier, and as many bytes as it says.
    fn whole(self) -> Option<Self> {
        let fits = self.length.is_none_or(|length| self.remote || length == self.count);
        // Without a listed length many bytes may be a dump of something else.
        let long = self.count <= CLASSIC || LONGER.contains(&self.count) && self.length.is_some();
        (self.id.is_some() && fits && long).then_some(self)
    }
}

/// Reads a row without a heading by the form of its words. `long_length`: the first of the bytes is their number.
fn guess(text: &[u8], long_length: bool) -> Option<(RowLayout, Row<'_>)> {
    let sign = [b';', b','].into_iter().find(|sign| text.contains(sign));
    let separator = sign.map_or(Separator::Blanks, Separator::Byte);
    let mut words = cells(text, separator);
    let mut tail = Vec::new();
    while let Some(column) = words.last().and_then(|word| trailing(word)) {
        tail.insert(0, (column, words.pop()?));
    }
    let run = words.iter().rev().take_while(|word| word.len() == 2 && is_hex(word)).count();
    let mut begin = words.len() - run;
    let mut row = Row::default();
    let mut columns = Vec::new();
    let head = words.get(..begin)?;
    // The length is the last word before the bytes, or the first of them.
    let listed = head.last().and_then(|word| length(word)).filter(|length| *length == run);
    let (head, length) = match listed {
        Some(length) => (head.get(..head.len() - 1)?, Some(length)),
        None if long_length => {
            let length = number(words.get(begin)?, 16)? as usize;
            begin += 1;
            (length + 1 == run).then_some((head, Some(length)))?
        }
        None => (head, None),
    };
    let place = head.iter().rposition(|word| identifier(word))?;
    for (number, word) in head.iter().enumerate() {
        let column = if number == place { Id(16) } else { leading(word, number)? };
        // A number behind the identifier would be a length, and a second one of a kind is something else.
        let again = column != Other && columns.contains(&column);
        if again || number > place && matches!(column, Channel(_) | Other) {
            return None;
        }
        row.take(column, word)?;
        columns.push(column);
    }
    if length.is_some() {
        columns.push(Length);
        row.length = length;
    }
    columns.push(Data);
    for word in words.get(begin..)? {
        row.bytes(word)?;
    }
    for (column, word) in tail {
        row.take(column, word)?;
        columns.push(column);
    }
    // Letters alone are a word.
    let word = head.get(place).is_some_and(|word| word.iter().all(u8::is_ascii_alphabetic));
    let layout = RowLayout { columns, long_length, ..RowLayout::new(separator) };
    row.whole().filter(|_| !word).map(|row| (layout, row))
}

/// Returns the column of a word behind the bytes.
fn trailing(word: &[u8]) -> Option<Column> {
    let timed = word.contains(&b'.') && time(word, SECOND).is_some();
    if timed { Some(Time(SECOND)) } else { direction(word).map(|_| Column::Direction) }
}

/// Returns the column of a word before the length.
fn leading(word: &[u8], number: usize) -> Option<Column> {
    if word.iter().any(|byte| matches!(byte, b'.' | b':')) && time(word, SECOND).is_some() {
        return Some(Time(SECOND));
    }
    if direction(word).is_some() {
        return Some(Column::Direction);
    }
    match word {
        b"CAN" | b"can" | b"d" | b"D" => Some(Other),
        b"r" | b"R" | b"s" | b"S" | b"x" | b"X" | b"Std" | b"Ext" | b"STD" | b"EXT" => Some(Attribute),
        // The first number of a row may count the rows.
        _ if number == 0 && word.len() > 2 && word.iter().all(u8::is_ascii_digit) => Some(Other),
        _ if word.len() <= 2 && word.iter().all(u8::is_ascii_digit) => Some(Channel(1)),
        _ => {
            let name = word.strip_prefix(b"v").unwrap_or(word);
            let of_bus = name.strip_prefix(b"can").or_else(|| name.strip_prefix(b"CAN"))?;
            (of_bus.len() <= 3 && of_bus.iter().all(u8::is_ascii_digit)).then_some(Channel(1))
        }
    }
}

/// Returns true if a word has the form of an identifier: three or eight hexadecimal digits, or a prefix.
fn identifier(word: &[u8]) -> bool {
    let prefixed = word.strip_prefix(b"0x").or_else(|| word.strip_prefix(b"0X"));
    let digits = prefixed.unwrap_or(word);
    let digits = digits.strip_suffix(b":").unwrap_or(digits);
    let digits = digits.strip_suffix(b"h").or_else(|| digits.strip_suffix(b"x")).unwrap_or(digits);
    let padded = digits.len() == 4 && digits.starts_with(b"0");
    let long = padded || matches!(digits.len(), 3 | 8) || prefixed.is_some() && (1..=8).contains(&digits.len());
    long && is_hex(digits)
}

/// Parses a length: `8`, `[8]`, `DLC=8`.
fn length(word: &[u8]) -> Option<usize> {
    let inner = word.strip_prefix(b"[").and_then(|word| word.strip_suffix(b"]"));
    let named = word.strip_prefix(b"DLC=").or_else(|| word.strip_prefix(b"DLC:"));
    match inner.or(named).unwrap_or(word) {
        [digit @ b'0'..=b'8'] => Some(usize::from(digit - b'0')),
        _ => None,
    }
}

/// Parses a direction, seen from the host.
fn direction(word: &[u8]) -> Option<Direction> {
    match word {
        b"Rx" | b"RX" | b"rx" | b"Receive" => Some(Direction::Rx),
        b"Tx" | b"TX" | b"tx" | b"Transmit" => Some(Direction::Tx),
        _ if word == "接收".as_bytes() => Some(Direction::Rx),
        _ if word == "发送".as_bytes() => Some(Direction::Tx),
        _ => None,
    }
}

/// Returns true if a cell says that it has no value.
fn is_absent(cell: &[u8]) -> bool {
    cell.is_empty() || cell == b"-" || cell == "无".as_bytes()
}

/// Returns the name of the bus of a channel; channels are counted from `first`.
fn channel(cell: &[u8], first: u8) -> &[u8] {
    const BUSES: [&[u8]; 10] =
        [b"can0", b"can1", b"can2", b"can3", b"can4", b"can5", b"can6", b"can7", b"can8", b"can9"];
    let (digit, first) = match cell {
        [b'C' | b'c', b'A' | b'a', b'N' | b'n', digit] => (&[*digit][..], 0),
        [b'C', b'A', b'N', b' ', digit] => (&[*digit][..], 1),
        _ => (cell.strip_prefix(b"ch").unwrap_or(cell), first),
    };
    let number = match digit {
        [digit @ b'0'..=b'9'] => (digit - b'0').checked_sub(first),
        _ => None,
    };
    number.and_then(|number| BUSES.get(usize::from(number))).copied().unwrap_or(cell)
}

/// Parses a whole word as a number, with or without `0x`, which makes it hexadecimal.
fn number(word: &[u8], base: u32) -> Option<u32> {
    let prefixed = word.strip_prefix(b"0x").or_else(|| word.strip_prefix(b"0X"));
    let (digits, base) = prefixed.map_or((word, base), |digits| (digits, 16));
    let add = |sum: Option<u32>, digit: &u8| {
        let digit = Some(u32::from(nibble(*digit))).filter(|digit| *digit < base)?;
        sum?.checked_mul(base)?.checked_add(digit)
    };
    if digits.is_empty() { None } else { digits.iter().fold(Some(0), add) }
}

/// Parses a time: a number in units of so many ns; or a time of day, with a date before it or not, with a point, comma or
/// colon before the fraction, of 24 hours or with AM or PM behind it.
fn time(word: &[u8], unit: i64) -> Option<Stamp> {
    let (word, half) = match word {
        [rest @ .., b' ', b'A' | b'a', b'M' | b'm'] => (rest, Some(0)),
        [rest @ .., b' ', b'P' | b'p', b'M' | b'm'] => (rest, Some(12)),
        _ => (word, None),
    };
    if let Some(place) = word.iter().position(|byte| is_blank(*byte) || *byte == b'T') {
        let (day, rest) = word.split_at_checked(place)?;
        let stamp = time(rest.get(1..)?, unit).filter(|_| rest.contains(&b':'))?;
        return Some(Stamp { form: StampForm::Calendar, ns: date(day)?.checked_add(stamp.ns)?, ..stamp });
    }
    let mut parts = word.split(|byte| *byte == b':');
    let (first, second, third, fourth) = (parts.next()?, parts.next(), parts.next(), parts.next());
    let last = third.or(second).unwrap_or(first);
    let (whole, count, rest) = digits(last);
    let (part, decimals, rest) = match (rest, fourth) {
        ([b'.' | b',', rest @ ..], None) => fraction(rest)?,
        ([], Some(after)) => fraction(after)?,
        _ => (0, 0, rest),
    };
    if count == 0 || count > 18 || !rest.is_empty() || parts.next().is_some() {
        return None;
    }
    let whole = i64::try_from(whole).ok()?;
    let small = |part: &[u8], most: u64| {
        let (value, count, rest) = digits(part);
        ((1..=2).contains(&count) && rest.is_empty() && value <= most).then_some(value as i64)
    };
    let (ns, decimals, width) = match (second, third) {
        (Some(minutes), Some(_)) => {
            let hours = small(first, 23)?;
            let hours = half.map_or(hours, |half| hours % 12 + half);
            (nanoseconds(hours * 3600 + small(minutes, 59)? * 60 + whole, part), decimals, 5)
        }
        (Some(_), None) => (nanoseconds(small(first, 59)? * 60 + whole, part), decimals, 4),
        // A whole number this large counts smaller units since 1970.
        (None, _) if decimals == 0 && unit == SECOND && whole >= 100_000_000_000 => {
            let (unit, decimals) = match whole {
                100_000_000_000_000_000.. => (1, 9),
                100_000_000_000_000.. => (MICROSECOND, 6),
                _ => (MILLISECOND, 3),
            };
            (whole.checked_mul(unit)?, decimals, 10)
        }
        (None, _) if unit == SECOND => (nanoseconds(whole, part), decimals, count.min(20) as u8),
        (None, _) => {
            let more = match unit {
                MILLISECOND => 3,
                MICROSECOND => 6,
                _ => 9,
            };
            let ns = whole.checked_mul(unit)?.checked_add(part / (SECOND / unit))?;
            (ns, (decimals + more).min(9), 1)
        }
    };
    Some(Stamp { form: StampForm::Seconds, ns, width, decimals })
}

/// Parses a date, `2024-03-12` or `2024/3/12`, as ns since 1970.
fn date(text: &[u8]) -> Option<i64> {
    let mut parts = text.split(|byte| matches!(byte, b'-' | b'/'));
    let mut next = || number(parts.next()?, 10).map(i64::from);
    let (year, month, day) = (next()?, next()?, next()?);
    let known = (1970..=2200).contains(&year) && (1..=12).contains(&month) && (1..=days_of(year, month)).contains(&day);
    known.then(|| days_to(year, month, day) * 86_400 * SECOND)
}

/// Reads rows whose words say what they are: of python-can's printer, of socketcand, and of slcan.
fn self_describing(text: &[u8]) -> Option<Row<'_>> {
    if let Some(place) = memchr::memmem::find(text, b"Timestamp: ") {
        return printed(text.get(place..)?);
    }
    if let Some(inner) = text.strip_prefix(b"< frame ").and_then(|text| text.strip_suffix(b" >")) {
        let mut row = Row::default();
        let mut words = inner.split(|byte| is_blank(*byte)).filter(|word| !word.is_empty());
        row.take(Id(16), words.next()?)?;
        row.take(Time(SECOND), words.next()?)?;
        words.try_for_each(|word| row.bytes(word))?;
        return row.whole();
    }
    slcan(text)
}

/// `Timestamp: 1.5    ID: 070a    S Rx    DL:  1    00    Channel: can0`.
fn printed(text: &[u8]) -> Option<Row<'_>> {
    let mut row = Row::default();
    let mut words = text.split(|byte| is_blank(*byte)).filter(|word| !word.is_empty());
    (words.next()? == b"Timestamp:").then_some(())?;
    row.take(Time(SECOND), words.next()?)?;
    (words.next()? == b"ID:").then_some(())?;
    row.take(Id(16), words.next()?)?;
    let mut data = false;
    while let Some(word) = words.next() {
        match word {
            b"S" | b"X" if !data => row.extended = Some(word == b"X"),
            b"R" if !data => row.remote = true,
            b"F" if !data => row.fd = Some(row.fd.unwrap_or_default()),
            b"BS" if !data => row.fd = row.fd.map(|(_, esi)| (true, esi)),
            b"EI" if !data => row.fd = row.fd.map(|(brs, _)| (brs, true)),
            b"DL:" => {
                row.take(Length, words.next()?)?;
                data = true;
            }
            b"Channel:" => {
                row.take(Channel(0), words.next()?)?;
                break;
            }
            _ if data && row.length.is_some_and(|length| row.count < length) && !row.remote => row.bytes(word)?,
            // Behind the bytes they are printed as text.
            _ if data => {}
            _ => row.direction = Some(direction(word)?),
        }
    }
    row.whole()
}

/// `t60A84017100000000000`: type, identifier, length, bytes.
fn slcan(text: &[u8]) -> Option<Row<'_>> {
    let (kind, rest) = text.split_first()?;
    let (extended, remote) = match kind {
        b't' => (false, false),
        b'T' => (true, false),
        b'r' => (false, true),
        b'R' => (true, true),
        _ => return None,
    };
    let (id, rest) = rest.split_at_checked(if extended { 8 } else { 3 })?;
    let (count, rest) = rest.split_first()?;
    let mut row = Row { extended: Some(extended), remote, length: length(&[*count]), ..Row::default() };
    row.take(Id(16), id)?;
    let (data, after) = rest.split_at_checked(if remote { 0 } else { 2 * row.length? })?;
    if !data.is_empty() {
        row.bytes(data)?;
    }
    // Four digits of a stamp may follow.
    let stamped = after.is_empty() || after.len() == 4 && is_hex(after);
    row.whole().filter(|_| stamped)
}

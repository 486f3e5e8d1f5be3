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
    /// The channel, counted from this number.
    Channel(u8),
    Other,
}

use Column::{Attribute, Channel, Data, Id, Length, Other, Ticks, Time};

const SECOND: i64 = 1_000_000_000;
const MILLISECOND: i64 = 1_000_000;
const MICROSECOND: i64 = 1_000;

/// The names of columns in headings, in lower case. A name that is no row is a column without a meaning.
const NAMES: &[(&str, Column)] = &[
    ("time", Time(SECOND)),
    ("time (s)", Time(SECOND)),
    ("time(s)", Time(SECOND)),
    ("time [s]", Time(SECOND)),
    ("time (ms)", Time(MILLISECOND)),
    ("time(ms)", Time(MILLISECOND)),
    ("time [ms]", Time(MILLISECOND)),
    ("time (us)", Time(MICROSECOND)),
    ("timestamp", Time(SECOND)),
    ("time stamp", Time(MICROSECOND)),
    ("时间", Time(SECOND)),
    ("系统时间", Time(SECOND)),
    ("时间标识", Ticks),
    ("id", Id(16)),
    ("id (hex)", Id(16)),
    ("id(hex)", Id(16)),
    ("id (dec)", Id(10)),
    ("id(dec)", Id(10)),
    ("can id", Id(16)),
    ("can-id", Id(16)),
    ("canid", Id(16)),
    ("cob-id", Id(16)),
    ("identifier", Id(16)),
    ("identifier (hex)", Id(16)),
    ("identifier (dec)", Id(10)),
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
    ("data (hex)", Data),
    ("data(hex)", Data),
    ("data bytes", Data),
    ("payload", Data),
    ("数据", Data),
    ("数据(hex)", Data),
    ("extended", Attribute),
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
    channel: &'a [u8],
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
        }
    }
}

/// A reader of one file of rows.
#[derive(Debug, Default)]
pub struct Rows {
    begun: Begun,
    lines: u64,
    layout: Option<RowLayout>,
    /// Rows without a heading, with their line numbers, until their layout is known.
    waiting: Vec<(u64, Vec<u8>)>,
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
            self.layout = Some(layout);
            return;
        }
        if self.layout.is_some() {
            return self.row(text, self.lines, buses, sink);
        }
        if guess(text, true).or_else(|| guess(text, false)).is_some() {
            self.waiting.push((self.lines, text.to_vec()));
            if self.waiting.len() >= LEARNT {
                self.decide(buses, sink);
            }
        }
    }

    /// Learns the layout of the rows that wait, and reads them.
    fn decide(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let waiting = std::mem::take(&mut self.waiting);
        let texts = || waiting.iter().map(|(_, text)| text.as_slice());
        // A first byte that is the number of those behind it in every row is a length.
        let count = |long: bool| texts().filter(|text| guess(text, long).is_some()).count();
        let counted = |text: &[u8]| guess(text, true).is_some_and(|(_, row)| row.count > 0);
        let long = count(true) >= count(false) && texts().any(counted);
        let shows = |(_, row): &(RowLayout, Row<'_>)| row.count > 0 || row.length.is_some();
        let Some((layout, _)) = texts().find_map(|text| guess(text, long).filter(shows)) else { return };
        let small = |text: &[u8]| guess(text, long).and_then(|(_, row)| row.id).is_some_and(|(id, _)| id <= 0x7FF);
        self.layout = Some(RowLayout { filled: texts().all(small), ..layout });
        for (line, text) in &waiting {
            self.row(text, *line, buses, sink);
        }
    }

    fn row(&self, text: &[u8], line: u64, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let Some(layout) = &self.layout else { return };
        let found = if layout.named { layout.read(text) } else { layout.reads_again(text) };
        match found {
            Some(row) => self.give(&row, line, layout.filled, buses, sink),
            // As many cells as a row has, and an identifier: it was meant as one.
            None if layout.is_meant(text) => sink(unreadable(line, Unreadable::NoFrame), buses),
            None => {}
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
        frame.bus = buses.intern(row.channel);
        (frame.line, frame.stamp, frame.dir) = (Some(line), row.stamp, row.direction);
        frame.t_ns = row.stamp.map(|stamp| stamp.ns);
        sink(Item::Frame(frame), buses);
    }
}

/// Returns true if a line of text is a heading or a row that only this reader reads; `alone`: whatever its columns.
pub(super) fn is_row(text: &[u8], alone: bool) -> bool {
    let text = stripped(text);
    let shows = |(_, row): &(RowLayout, Row<'_>)| row.count > 0 || row.length.is_some();
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
            Attribute => "format",
            Channel(_) => "channel",
            Other => "-",
        }
    }

    /// Returns the column with this name in a heading.
    fn named(name: &[u8]) -> Self {
        let name = String::from_utf8_lossy(name).to_lowercase();
        if let Some((_, column)) = NAMES.iter().find(|(known, _)| *known == name) {
            return *column;
        }
        let number = ["data", "byte", "d", "b"].iter().find_map(|prefix| name.strip_prefix(prefix));
        let number = number.map(str::trim).filter(|number| !number.is_empty() && number.len() <= 2);
        if number.is_some_and(|number| number.bytes().all(|digit| digit.is_ascii_digit())) { Self::Byte } else { Other }
    }
}

/// Returns the cells of a line, without quotation marks and blanks around them.
fn cells(text: &[u8], separator: Separator) -> Vec<&[u8]> {
    let parts: Vec<&[u8]> = match separator {
        Separator::Byte(sign) => text.split(|byte| *byte == sign).take(CELLS).collect(),
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
        if ids != 1 || bytes == 0 || names.len() < 3 || prose {
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
        Some(RowLayout { separator, columns, filled: false, long_length: false, named: true })
    })
}

impl RowLayout {
    /// Reads a row below a heading.
    fn read<'a>(&self, text: &'a [u8]) -> Option<Row<'a>> {
        let mut row = Row::default();
        let found = cells(text, self.separator);
        let mut rest = found.iter().copied().peekable();
        for column in &self.columns {
            match (column, self.separator) {
                (Data, Separator::Blanks) => {
                    let wanted = row.length.unwrap_or(CLASSIC);
                    while row.count < wanted
                        && let Some(cell) = rest.next_if(|cell| cell.len() % 2 == 0 && is_hex(cell))
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
        row.whole()
    }

    /// Reads a row without a heading, which must have the columns of the first one.
    fn reads_again<'a>(&self, text: &'a [u8]) -> Option<Row<'a>> {
        let (layout, row) = guess(text, self.long_length)?;
        (layout.columns == self.columns).then_some(row)
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
            Time(unit) => self.stamp = if is_absent(cell) { None } else { Some(time(cell, unit)?) },
            Ticks => {
                let ticks = if is_absent(cell) { None } else { Some(number(cell, 16)?) };
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
                    [word @ .., b'h' | b'H'] => (word, None),
                    _ => (cell, None),
                };
                self.extended = self.extended.or(extended);
                let digits = word.strip_prefix(b"0x").or_else(|| word.strip_prefix(b"0X")).unwrap_or(word);
                self.id = Some((number(word, base)?, if base == 16 { digits.len() } else { 0 }));
            }
            Column::Direction if is_absent(cell) => {}
            Column::Direction => self.direction = Some(direction(cell)?),
            Length if cell.is_empty() => {}
            Length => self.length = Some(number(cell, 10).filter(|length| *length <= 64)? as usize),
            Data => {
                for part in cell.split(|byte| is_blank(*byte)).filter(|part| !part.is_empty()) {
                    self.bytes(part)?;
                }
            }
            Column::Byte if cell.is_empty() => {}
            Column::Byte => self.bytes(cell)?,
            Attribute => self.attribute(cell),
            Channel(first) => self.channel = channel(cell, first),
            Other => {}
        }
        Some(())
    }

    /// Adds bytes: two digits each, or one digit.
    fn bytes(&mut self, text: &[u8]) -> Option<()> {
        let text = text.strip_prefix(b"0x").unwrap_or(text);
        let pairs: Vec<u8> = match text {
            [digit] => vec![Some(nibble(*digit)).filter(|digit| *digit < 16)?],
            _ if text.len() % 2 == 0 => {
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
    let separator = if text.contains(&b',') { Separator::Byte(b',') } else { Separator::Blanks };
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
    // Letters alone are a word, and no frame without bytes.
    let word = head.get(place).is_some_and(|word| word.iter().all(u8::is_ascii_alphabetic));
    let layout = RowLayout { separator, columns, filled: false, long_length, named: false };
    row.whole().filter(|row| !word || row.count > 0 || length.is_some()).map(|row| (layout, row))
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
    let digits = digits.strip_suffix(b"h").or_else(|| digits.strip_suffix(b"x")).unwrap_or(digits);
    let long = matches!(digits.len(), 3 | 8) || prefixed.is_some() && (1..=8).contains(&digits.len());
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
    let number = match cell.strip_prefix(b"ch").unwrap_or(cell) {
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

/// Parses a time: a number in units of so many ns, or a time of day with a point or comma before the fraction.
fn time(word: &[u8], unit: i64) -> Option<Stamp> {
    let mut parts = word.split(|byte| *byte == b':');
    let (first, second, third) = (parts.next()?, parts.next(), parts.next());
    let last = third.or(second).unwrap_or(first);
    let (whole, count, rest) = digits(last);
    let (part, decimals, rest) = match rest {
        [b'.' | b',', rest @ ..] => fraction(rest)?,
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
            let seconds = small(first, 23)? * 3600 + small(minutes, 59)? * 60 + whole;
            (nanoseconds(seconds, part), decimals, 5)
        }
        (Some(_), None) => (nanoseconds(small(first, 59)? * 60 + whole, part), decimals, 4),
        (None, _) if unit == SECOND => (nanoseconds(whole, part), decimals, count.min(20) as u8),
        (None, _) => {
            let more = if unit == MILLISECOND { 3 } else { 6 };
            let ns = whole.checked_mul(unit)?.checked_add(part / (SECOND / unit))?;
            (ns, (decimals + more).min(9), 1)
        }
    };
    Some(Stamp { form: StampForm::Seconds, ns, width, decimals })
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

//! The layout of a listing: by its heading, or learnt from rows that agree and show that they are frames.

use super::columns::Column::{self, Attribute, Channel, Data, Id, Length, Other, Ticks, Time};
use super::columns::{SECOND, Separator, cells};
use super::row::{CLASSIC, Row, direction, length};
use super::times::{number, time};
use crate::bytes::readers::candump::lex::{is_blank, is_hex};

/// The columns of a listing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct RowLayout {
    pub(super) separator: Separator,
    pub(super) columns: Vec<Column>,
    /// The listed identifiers with eight digits are standard ones that were filled up with zeros.
    pub(super) filled: bool,
    /// Hexadecimal digits of the length count before the bytes, as `08`.
    pub(super) long_length: bool,
    /// The heading named the columns.
    pub(super) named: bool,
    /// Identifiers and bytes are decimal.
    pub(super) decimal: bool,
    /// The first numbers count the rows, and name no channel.
    pub(super) counted: bool,
}

/// Reads a line as a heading: it names an identifier and bytes.
pub(super) fn heading(text: &[u8]) -> Option<RowLayout> {
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
    pub(super) fn read<'a>(&self, text: &'a [u8]) -> Option<Row<'a>> {
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
    pub(super) fn completed(self, texts: &[&[u8]]) -> Self {
        let decimal = self.separator != Separator::Blanks && self.is_decimal(texts);
        let layout = Self { decimal, ..self };
        let small = |text: &&[u8]| layout.read(text).is_none_or(|row| row.id.is_some_and(|(id, _)| id <= 0x7FF));
        Self { filled: texts.iter().all(small), ..layout }
    }

    /// Returns true if identifiers and bytes are decimal, although the heading does not say so: none has a letter, and a
    /// byte has three digits, or bytes of one digit stand beside identifiers of four.
    fn is_decimal(&self, texts: &[&[u8]]) -> bool {
        let (mut letters, mut three, mut one, mut long) = (false, false, false, false);
        for text in texts {
            let found = cells(text, self.separator);
            for (column, cell) in self.columns.iter().zip(&found) {
                for part in cell.split(|byte| is_blank(*byte)).filter(|part| !part.is_empty()) {
                    match column {
                        Id(_) => long |= part.len() == 4 && !part.starts_with(b"0"),
                        Data | Column::Byte => (three, one) = (three || part.len() == 3, one || part.len() == 1),
                        _ => continue,
                    }
                    letters |= !part.iter().all(u8::is_ascii_digit);
                }
            }
        }
        !letters && (three || one && long)
    }

    /// Returns true if a row without a heading shows that it is a frame: by its length and a time, a direction or the word
    /// CAN, or by a service of CANopen.
    pub(super) fn is_evident(&self, row: &Row<'_>) -> bool {
        let told = self.columns.iter().any(|column| matches!(column, Time(_) | Column::Direction));
        let (id, data) = (row.id.map_or(0, |(id, _)| id), row.data.get(..row.count).unwrap_or_default());
        let sdo = matches!(id, 0x581..=0x5FF | 0x601..=0x67F) && data.len() == 8;
        let control = matches!(id, 0x701..=0x77F) && matches!(data, [0 | 4 | 5 | 0x7F]);
        row.length.is_some() && told || sdo || control
    }

    /// Reads a row without a heading, which must have the columns of the first one.
    pub(super) fn reads_again<'a>(&self, text: &'a [u8]) -> Option<Row<'a>> {
        if self.columns == [Id(16), Data] && is_alone(text) {
            return number(text, 16).map(|id| Row { id: Some((id, 3)), ..Row::default() });
        }
        let (layout, row) = guess(text, self.long_length)?;
        let channel = if self.counted { &b""[..] } else { row.channel };
        (layout.columns == self.columns).then_some(Row { channel, ..row })
    }

    /// Returns true if a line has as many cells as a row, one of them an identifier.
    pub(super) fn is_meant(&self, text: &[u8]) -> bool {
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

/// Reads a row without a heading by the form of its words. `long_length`: the first of the bytes is their number.
pub(super) fn guess(text: &[u8], long_length: bool) -> Option<(RowLayout, Row<'_>)> {
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
    let remote = run == 0 && head.iter().any(|word| matches!(*word, b"r" | b"R" | b"RTR"));
    let listed = head.last().and_then(|word| length(word)).filter(|length| *length == run || remote);
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
        b"CAN" | b"can" => Some(Other),
        b"d" | b"D" | b"r" | b"R" | b"s" | b"S" | b"x" | b"X" | b"Std" | b"Ext" | b"STD" | b"EXT" | b"RTR" => {
            Some(Attribute)
        }
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

/// Learns the layout of rows without a heading; `None` if nothing shows that they are frames.
pub(super) fn learn(texts: &[&[u8]]) -> Option<RowLayout> {
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
    let rising = channels.len() > 1
        && channels.iter().zip(channels.iter().skip(1)).all(|(one, next)| one.checked_add(1) == Some(*next));
    let counted = rising || channels.iter().any(|channel| *channel > 8);
    Some(RowLayout { filled: small, counted, ..layout.clone() })
}

/// Returns true if a line is an identifier alone, as of a SYNC without data.
pub(super) fn is_alone(text: &[u8]) -> bool {
    matches!(text.len(), 1..=3) && is_hex(text) && text.iter().any(u8::is_ascii_digit)
}

/// Returns true if each identifier is that of the row before plus the number of its bytes, as in a dump of memory.
fn rises_by_length(rows: &[(RowLayout, Row<'_>)]) -> bool {
    let ids: Vec<(u32, usize)> = rows.iter().filter_map(|(_, row)| Some((row.id?.0, row.count))).collect();
    let pairs = ids.iter().zip(ids.iter().skip(1));
    ids.len() > 1
        && pairs.into_iter().all(|((id, count), (next, _))| *count > 0 && id.checked_add(*count as u32) == Some(*next))
}

//! The layout of rows without a heading: learnt from rows that agree and show that they are frames.

use super::columns::Column::{self, Attribute, Channel, Data, Id, Length, Other, Time};
use super::columns::{SECOND, Separator, cells};
use super::layout::RowLayout;
use super::objects;
use super::prose;
use super::row::{CLASSIC, Row, direction, id_digits, identifier, length};
use super::times::{begins_with_comma, number, time};
use crate::bytes::readers::Unreadable;
use crate::bytes::readers::candump::lex::{is_blank, is_hex};

/// Number of identifiers that rise by one from which on they count something.
const COUNTED: usize = 5;
/// Number of identifiers in order from which on they are those of a table.
const SORTED: usize = 20;

impl RowLayout {
    /// Returns true if a line is a row of this layout.
    pub(super) fn reads(&self, text: &[u8]) -> bool {
        let found = if self.named { self.read(text) } else { self.reads_again(text) };
        found.is_some_and(|row| row.whole().is_some())
    }

    /// Reads a row without a heading, which must have the columns of the first one.
    pub(super) fn reads_again<'a>(&self, text: &'a [u8]) -> Option<Row<'a>> {
        if self.columns == [Id(16), Data] && is_alone(text) {
            return number(text, 16).map(|id| Row { id: Some((id, 3)), ..Row::default() });
        }
        if self.prose {
            let (layout, row) = prose::guess(text, true)?;
            return (layout.columns.contains(&Length) == self.columns.contains(&Length)).then_some(row);
        }
        let guessed = guess(text, self.long_length).filter(|(layout, _)| layout.columns == self.columns);
        let row = guessed.map(|(_, row)| row).or_else(|| self.read_in_order(text))?;
        let channel = if self.counted { &b""[..] } else { row.channel };
        Some(Row { channel, ..row })
    }

    /// Reads a row whose words have the order of the columns, whatever its identifier; text may follow the bytes.
    fn read_in_order<'a>(&self, text: &'a [u8]) -> Option<Row<'a>> {
        let mut row = Row::default();
        let found = cells(text, self.separator);
        let mut rest = found.iter().copied().peekable();
        let dated = self.columns.iter().any(|column| matches!(column, Time(_) | Column::Direction));
        for (place, column) in self.columns.iter().enumerate() {
            if *column == Data {
                row.cells(&mut rest, place + 1 == self.columns.len())?;
                continue;
            }
            let word = rest.next()?;
            let fits = match column {
                // A short number is an identifier only beside something else that shows a row.
                Id(_) => identifier(word) || dated && word.len() <= 8 && is_hex(word),
                Length => is_hex(word),
                _ if row.count > 0 => trailing(word) == Some(*column),
                _ => leading(word, place).or_else(|| is_name(word).then_some(Other)) == Some(*column),
            };
            fits.then(|| row.take(*column, word))??;
        }
        let id = row.id.map_or(0, |(id, _)| id);
        let shown = match row.length {
            // A number and a zero before other words are text, but for a SYNC.
            Some(0) => dated || id == 0x80,
            Some(_) => true,
            None => row.count == CLASSIC || rest.peek().is_some_and(|word| !word.iter().all(u8::is_ascii_alphanumeric)),
        };
        (shown || rest.peek().is_none()).then_some(row)
    }

    /// Returns true if a line has the cells of a row: an identifier, and bytes or at least as many cells as the heading.
    pub(super) fn is_meant(&self, text: &[u8]) -> bool {
        if self.prose {
            return prose::is_meant(text);
        }
        if self.separator == Separator::Pairs {
            return objects::layout(text).is_some();
        }
        let found = cells(text, self.separator);
        // Rows of a table begin with a number.
        let numbered = found.len() > 1 && text.first().is_some_and(u8::is_ascii_digit);
        if self.named && numbered && matches!(self.separator, Separator::Byte(_)) {
            return true;
        }
        let least = self.columns.iter().filter(|column| !matches!(column, Column::Byte | Data)).count();
        let cell = |of: fn(&Column) -> bool| self.columns.iter().position(of).and_then(|place| found.get(place));
        let id = cell(|column| matches!(column, Id(_))).is_some_and(|cell| number(id_digits(cell).0, 16).is_some());
        let is_byte = |cell: &&[u8]| (1..=2).contains(&cell.len()) && is_hex(cell);
        let bytes = || cell(|column| *column == Data).is_some_and(is_byte) || found.last().is_some_and(is_byte);
        let none = || cell(|column| *column == Length).is_some_and(|cell| *cell == b"0");
        // Below a heading, the rest of a row shows that something else stands where its identifier should.
        let mut row = Row { decimal: self.decimal, ..Row::default() };
        let mut rest =
            self.columns.iter().zip(&found).filter(|(column, _)| matches!(column, Length | Data | Column::Byte));
        let whole = self.separator != Separator::Blanks
            && rest.all(|(column, cell)| row.take(*column, cell).is_some())
            && row.count >= row.length.unwrap_or(2).max(1);
        found.len() >= least.max(2) && if self.named { id || whole } else { id && (bytes() || none()) }
    }

    /// Returns true if a row of a table ends before the cell of its bytes.
    pub(super) fn ends_before_data(&self, text: &[u8]) -> bool {
        let place = self.columns.iter().position(|column| *column == Data);
        let found = cells(text, self.separator).len();
        let between = matches!(self.separator, Separator::Byte(_));
        self.named && between && found > 1 && place.is_some_and(|place| place >= found)
    }

    /// Returns the reason why a row that was meant cannot be read; `read`: its cells could be.
    pub(super) fn reason(&self, text: &[u8], read: bool) -> Unreadable {
        let place = self.columns.iter().position(|column| matches!(column, Id(_))).unwrap_or_default();
        let cell = cells(text, self.separator).get(place).copied().unwrap_or_default();
        match self.refused {
            Some(reason) => reason,
            None if read => Unreadable::Data,
            None if self.named
                && matches!(self.separator, Separator::Byte(_))
                && number(id_digits(cell).0, 16).is_none() =>
            {
                Unreadable::NoIdentifier { cell: place as u64 + 1 }
            }
            None => Unreadable::NoFrame,
        }
    }
}

/// Reads a row without a heading by the form of its words. `long_length`: the first of the bytes is their number.
pub(super) fn guess(text: &[u8], long_length: bool) -> Option<(RowLayout, Row<'_>)> {
    let sign = [b';', b','].into_iter().find(|sign| text.contains(sign)).filter(|_| !begins_with_comma(text));
    let separator = sign.map_or(Separator::Blanks, Separator::Byte);
    let mut words = cells(text, separator);
    if matches!(separator, Separator::Byte(_)) && words.last().is_some_and(|last| last.is_empty()) {
        words.pop();
    }
    if let (Separator::Byte(_), Some(last)) = (separator, words.last().copied().filter(|last| last.contains(&b' '))) {
        // All bytes are in the last cell.
        words.pop();
        words.extend(last.split(|byte| is_blank(*byte)).filter(|word| !word.is_empty()));
    }
    let mut tail = Vec::new();
    while let Some(column) = words.last().and_then(|word| trailing(word)) {
        tail.insert(0, (column, words.pop()?));
    }
    if let Some((last, before)) = words.split_last().map(|(last, before)| (*last, before.to_vec()))
        && matches!(last.len(), 4..=16)
        && last.len().is_multiple_of(2)
        && is_hex(last)
        && before.iter().any(|word| identifier(word))
    {
        // All bytes are in one word.
        words = before.into_iter().chain(last.chunks(2)).collect();
    }
    let run = words.iter().rev().take_while(|word| word.len() == 2 && is_hex(word)).count();
    let mut begin = words.len() - run;
    let mut row = Row::default();
    let mut columns = Vec::new();
    let mut head = words.get(..begin)?;
    let (mut rtr, before) = (false, head.split_last());
    if let Some((word, before)) = before.filter(|_| run == 0)
        && matches!(*word, b"RTR" | b"rtr" | b"Remote" | b"remote")
    {
        (head, rtr) = (before, true);
    }
    // The length is the last word before the bytes, or the first of them.
    let remote = rtr || run == 0 && head.iter().any(|word| matches!(*word, b"r" | b"RTR"));
    let prefixed = |word: &&[u8]| number(word.strip_prefix(b"0x").filter(|digits| digits.len() == 2)?, 16);
    let listed = head.last().and_then(|word| length(word).or_else(|| Some(prefixed(word)? as usize)));
    let listed = listed.filter(|length| *length == run || remote);
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
    // Other protocols have numbers with names and bytes, too.
    let mut weak = false;
    for (number, word) in head.iter().enumerate() {
        let name = number > place && is_name(word);
        let column = match leading(word, number) {
            _ if number == place => Id(16),
            None if name => Other,
            column => column?,
        };
        // A number behind the identifier would be a length, and a second one of a kind is something else.
        let again = !matches!(column, Other | Attribute) && columns.contains(&column);
        if again || number > place && (matches!(column, Channel(_)) || column == Other && (!name || weak)) {
            return None;
        }
        weak |= name && column == Other;
        row.take(column, word)?;
        columns.push(column);
    }
    if length.is_some() {
        columns.push(Length);
        row.length = length;
    }
    columns.push(Data);
    row.remote |= rtr;
    for word in words.get(begin..)?.iter().filter(|_| !rtr) {
        row.bytes(word)?;
    }
    for (column, word) in tail {
        row.take(column, word)?;
        columns.push(column);
    }
    // Letters alone are a word.
    let word = head.get(place).is_some_and(|word| word.iter().all(u8::is_ascii_alphabetic));
    let layout = RowLayout { columns, long_length, weak, ..RowLayout::new(separator) };
    row.whole().filter(|_| !word).map(|row| (layout, row))
}

/// Returns true for the name of an identifier.
fn is_name(word: &[u8]) -> bool {
    word.first().is_some_and(u8::is_ascii_alphabetic) && !is_hex(word)
}

/// Words for the kind of a frame.
const CHINESE: [&str; 4] = ["数据帧", "远程帧", "标准帧", "扩展帧"];

/// Returns the column of a word behind the bytes.
fn trailing(word: &[u8]) -> Option<Column> {
    let timed = word.contains(&b'.') && time(word, SECOND).is_some();
    if timed { Some(Time(SECOND)) } else { direction(word).map(|_| Column::Direction) }
}

/// Returns the column of a word before the length.
fn leading(word: &[u8], number: usize) -> Option<Column> {
    if word.iter().any(|byte| matches!(byte, b'.' | b':' | b',')) && time(word, SECOND).is_some() {
        return Some(Time(SECOND));
    }
    if direction(word).is_some() {
        return Some(Column::Direction);
    }
    match word {
        b"CAN" | b"can" => Some(Other),
        b"d" | b"D" | b"r" | b"s" | b"S" | b"x" | b"X" | b"Std" | b"Ext" | b"STD" | b"EXT" | b"RTR" => Some(Attribute),
        _ if CHINESE.iter().any(|known| known.as_bytes() == word) => Some(Attribute),
        // The ticks of ZLG's adapters, which no heading names.
        [b'0', b'x', digits @ ..] if digits.len() == 8 => Some(Other),
        // The first number of a row may count the rows.
        _ if number == 0 && word.iter().all(u8::is_ascii_digit) => Some(Column::Number),
        _ if word.len() <= 2 && word.iter().all(u8::is_ascii_digit) => Some(Channel(1)),
        _ => {
            let name = word.strip_prefix(b"v").unwrap_or(word);
            let of_bus = ["can", "CAN", "ch"].iter().find_map(|prefix| name.strip_prefix(prefix.as_bytes()))?;
            (of_bus.len() <= 3 && of_bus.iter().all(u8::is_ascii_digit)).then_some(Channel(1))
        }
    }
}

/// Learns the layout of rows without a heading; `None` if nothing shows that they are frames.
pub(super) fn learn(texts: &[&[u8]]) -> Option<RowLayout> {
    // A first byte that is the number of those behind it in every row is a length.
    let count = |long: bool| texts.iter().filter(|text| guess(text, long).is_some()).count();
    let counted = |text: &&[u8]| guess(text, true).is_some_and(|(_, row)| row.count > 0);
    let long = count(true) >= count(false) && texts.iter().any(counted);
    let rows: Vec<_> = texts.iter().filter_map(|text| guess(text, long)).collect();
    let inside: Vec<_> = texts.iter().filter_map(|text| prose::guess(text, false)).collect();
    let (first, second) = if inside.len() > rows.len() { (inside, rows) } else { (rows, inside) };
    agreed(&first).or_else(|| agreed(&second))
}

/// Returns the layout of rows if something shows that they are frames.
fn agreed(rows: &[(RowLayout, Row<'_>)]) -> Option<RowLayout> {
    if !rows.iter().any(|(layout, row)| layout.is_evident(row)) || rises_by_length(rows) {
        return None;
    }
    // That of most rows, the first of several.
    let shown = |(_, row): &&(RowLayout, Row<'_>)| row.count > 0 || row.length.is_some();
    let mut layouts: Vec<(&RowLayout, usize)> = Vec::new();
    for (layout, _) in rows.iter().filter(shown) {
        match layouts.iter_mut().find(|(known, _)| known.columns == layout.columns) {
            Some((_, count)) => *count += 1,
            None => layouts.push((layout, 1)),
        }
    }
    let (layout, _) = layouts.into_iter().rev().max_by_key(|(_, count)| *count)?;
    let small = rows.iter().all(|(_, row)| row.id.is_some_and(|(id, _)| id <= 0x7FF));
    // Numbers that rise from row to row count the rows.
    let channels: Vec<u32> = rows.iter().filter_map(|(_, row)| number(row.channel, 10)).collect();
    let pairs = || channels.iter().zip(channels.iter().skip(1));
    let rising = channels.len() > 1 && pairs().all(|(one, next)| one.checked_add(1) == Some(*next));
    // Those of a listing that was filtered rise, too.
    let filtered = channels.len() > 2 && pairs().all(|(one, next)| one < next);
    let counted = rising || filtered || channels.iter().any(|channel| *channel > 8);
    let digits = rows.first().and_then(|(_, row)| row.id).map_or(0, |(_, digits)| digits);
    let filled = small || digits > 4 && rows.iter().all(|(_, row)| row.id.is_some_and(|(_, count)| count == digits));
    Some(RowLayout { filled, counted, ..layout.clone() })
}

/// Returns true if a line is an identifier alone, as of a SYNC without data.
pub(super) fn is_alone(text: &[u8]) -> bool {
    matches!(text.len(), 1..=3) && is_hex(text) && text.iter().any(u8::is_ascii_digit)
}

/// Returns true if each identifier is that of the row before plus the number of its bytes, as in a dump of memory, or if many
/// are in order, as in a table.
fn rises_by_length(rows: &[(RowLayout, Row<'_>)]) -> bool {
    let ids: Vec<(u32, usize)> = rows.iter().filter_map(|(_, row)| Some((row.id?.0, row.count))).collect();
    let pairs = || ids.iter().zip(ids.iter().skip(1));
    let one = ids.len() > COUNTED && pairs().all(|((id, _), (next, _))| id.checked_add(1) == Some(*next));
    if one || ids.len() > SORTED && pairs().all(|((id, _), (next, _))| id < next) {
        return true;
    }
    ids.len() > 1
        && pairs()
            .into_iter()
            .all(|((id, count), (next, _))| *count > 0 && id.checked_add(*count as u32) == Some(*next))
}

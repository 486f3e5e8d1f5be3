//! The layout of a listing, and that of a heading.

use super::columns::Column::{self, Data, Id, Length, Other, Ticks, Time};
use super::columns::{Separator, cells};
use super::row::{CLASSIC, Row};
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
    /// Bytes are decimal, and identifiers whose heading does not say what they are.
    pub(super) decimal: bool,
    /// The base of the bytes, if the heading says it.
    pub(super) base: Option<u32>,
    /// The first numbers count the rows, and name no channel.
    pub(super) counted: bool,
    /// The rows stand inside other text.
    pub(super) prose: bool,
    /// Only a service of CANopen shows that the rows are frames.
    pub(super) weak: bool,
}

/// Reads a line as a heading: it names an identifier and bytes.
pub(super) fn heading(text: &[u8]) -> Option<RowLayout> {
    // Each English name of an identifier has these letters, and rows mostly begin with a digit.
    let named = text.windows(2).any(|pair| pair.eq_ignore_ascii_case(b"id")) || !text.is_ascii();
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
        let mut timed = false;
        for column in columns.iter_mut().filter(|column| matches!(column, Time(_))) {
            // The first of several counts from the begin, or is that of the day; others may be gaps.
            if std::mem::replace(&mut timed, true) {
                *column = Other;
            }
        }
        // The code of the length is not the length of a long frame.
        if let Some(last) = columns.iter().rposition(|column| *column == Length) {
            columns.iter_mut().take(last).filter(|column| **column == Length).for_each(|column| *column = Other);
        }
        if columns.contains(&Ticks) {
            // The clock of the adapter is finer than that of the system.
            columns.iter_mut().filter(|column| matches!(column, Time(_))).for_each(|column| *column = Other);
        }
        let base = columns.iter().zip(&names).find(|(column, _)| matches!(column, Data | Column::Byte));
        let said = base.map_or(String::new(), |(_, name)| String::from_utf8_lossy(name).to_lowercase());
        let base = [("hex", 16), ("dec", 10)].iter().find(|(word, _)| said.contains(word)).map(|(_, base)| *base);
        Some(RowLayout { separator, columns, named: true, base, ..RowLayout::new(separator) })
    })
}

impl RowLayout {
    pub(super) fn new(separator: Separator) -> Self {
        let (filled, long_length, named, decimal, base, counted, (prose, weak)) = Default::default();
        Self { separator, columns: Vec::new(), filled, long_length, named, decimal, base, counted, prose, weak }
    }

    /// Reads a row below a heading, whose length may not be that of its bytes.
    pub(super) fn read<'a>(&self, text: &'a [u8]) -> Option<Row<'a>> {
        let mut row = Row { decimal: self.decimal, told: self.base.is_some(), ..Row::default() };
        let found = cells(text, self.separator);
        let mut rest = found.iter().copied().peekable();
        for column in &self.columns {
            match (column, self.separator) {
                (Data, Separator::Blanks) => {
                    let wanted = row.length.unwrap_or(CLASSIC);
                    let decimal = row.decimal;
                    while row.count < wanted
                        && let Some(cell) = rest.next_if(|cell| {
                            let fits =
                                if decimal { cell.len() <= 3 } else { cell.len() == 1 || cell.len().is_multiple_of(2) };
                            fits && is_hex(cell)
                        })
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
        let decimal = self.base.map_or_else(|| self.is_decimal(texts), |base| base == 10);
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
        row.length.is_some() && told && !self.weak || sdo || control
    }
}

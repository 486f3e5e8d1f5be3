//! The layout of a listing, and that of a heading.

use super::columns::Column::{self, Channel, Code, Data, Direction, Id, Length, Other, Part, Sent, Ticks, Time};
use super::columns::{Separator, UNSAID, cells, names};
use super::pairs::pairs;
use super::row::{CLASSIC, Row, id_digits, side};
use super::times::unprefixed;
use super::words;
use crate::bytes::readers::Unreadable;
use crate::bytes::readers::candump::lex::{is_blank, is_hex};

/// The columns of a listing.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct RowLayout {
    pub(super) separator: Separator,
    pub(super) columns: Vec<Column>,
    /// The listed identifiers with eight digits are standard ones that were filled up with zeros.
    pub(super) filled: bool,
    /// Hexadecimal digits of the length count before the bytes, as `08`.
    pub(super) long_length: bool,
    /// The heading named the columns.
    pub(super) named: bool,
    /// Bytes are decimal.
    pub(super) decimal: bool,
    /// The base of the bytes, if the heading says it.
    pub(super) base: Option<u32>,
    /// The first numbers count the rows, and name no channel.
    pub(super) counted: bool,
    /// The rows stand inside other text.
    pub(super) prose: bool,
    /// Only a service of CANopen shows that the rows are frames.
    pub(super) weak: bool,
    /// A heading that does not fit the rows names a unit of times, which are unknown without one.
    pub(super) untimed: bool,
    /// The reason why no row can be read, although all have the columns.
    pub(super) refused: Option<Unreadable>,
}

/// The signs of a base in words for identifiers and bytes.
#[derive(Clone, Copy, Debug, Default)]
struct BaseSigns {
    /// An identifier has a letter, a prefix, or a leading zero.
    hex_ids: bool,
    /// An identifier has four digits.
    long: bool,
    /// A byte has a letter, three digits, one digit, a leading zero.
    letters: bool,
    three: bool,
    one: bool,
    padded: bool,
}

impl BaseSigns {
    /// Returns true if bytes are decimal, although the heading does not say so: one has three digits, or some have one
    /// digit beside identifiers of four.
    fn decimal(self) -> bool {
        !self.hex_ids && !self.letters && (self.three || self.one && self.long)
    }

    /// Returns true if the numbers of a list are decimal: hexadecimal ones have two digits each, or a prefix.
    fn list_is_decimal(self) -> bool {
        !self.letters && !self.padded && (self.three || self.one)
    }
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
        let names = names(text, separator);
        let mut columns: Vec<Column> = names.iter().map(|name| Column::named(name)).collect();
        let count = |of: fn(&Column) -> bool| columns.iter().filter(|column| of(column)).count();
        let ids = count(|column| matches!(column, Id(_)));
        let bytes = count(|column| matches!(column, Data | Column::Byte));
        let known = count(|column| *column != Other);
        // Between blanks there may be prose.
        let number = |name: &String| name.len() > 1 && name.starts_with(|first: char| first.is_ascii_digit());
        let prose = known < 3 || known * 2 < names.len() || names.iter().any(number);
        let prose = separator == Separator::Blanks && prose;
        if ids != 1 || bytes == 0 || prose {
            return None;
        }
        let has = |name: &str| names.iter().any(|known| known == name);
        if has("protocol") {
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
            columns.iter_mut().take(last).filter(|column| **column == Length).for_each(|column| *column = Code);
        }
        if columns.contains(&Ticks) {
            // The clock of the adapter is finer than that of the system.
            columns.iter_mut().filter(|column| matches!(column, Time(_))).for_each(|column| *column = Other);
        }
        if has("timestampepoch") {
            // The loggers of CSS Electronics count directions, too.
            columns.iter_mut().filter(|column| **column == Direction).for_each(|column| *column = Sent);
        }
        let said = columns.iter().zip(&names).find(|(column, _)| matches!(column, Data | Column::Byte));
        let bases = [("hex", 16), ("dec", 10), ("dez", 10)];
        let base = said.and_then(|(_, name)| bases.iter().find(|(word, _)| name.contains(word))).map(|(_, base)| *base);
        let refused = (has("t_ns") && has("capture")).then_some(Unreadable::Exported);
        Some(RowLayout { columns, named: true, base, refused, ..RowLayout::new(separator) })
    })
}

impl RowLayout {
    pub(super) fn new(separator: Separator) -> Self {
        Self { separator, ..Self::default() }
    }

    /// Reads a row below a heading, whose length may not be that of its bytes. Between blanks the columns are those of the
    /// heading only if each cell fits its own.
    pub(super) fn read<'a>(&self, text: &'a [u8]) -> Option<Row<'a>> {
        if self.separator == Separator::Pairs {
            return self.read_pairs(text);
        }
        let mut row = Row { decimal: self.decimal, ..Row::default() };
        let found = cells(text, self.separator);
        let blanks = self.separator == Separator::Blanks;
        let mut rest = found.iter().copied().peekable();
        for (place, column) in self.columns.iter().enumerate() {
            if *column == Data && blanks {
                row.cells(&mut rest, place + 1 == self.columns.len())?;
                continue;
            }
            let Some(cell) = rest.next() else {
                // A row that ends before its length is cut.
                let mut lacks = self.columns.iter().skip(place);
                if lacks.any(|column| *column == Length || *column == Data && blanks && row.count == 0) {
                    return None;
                }
                break;
            };
            row.take(*column, cell)?;
            let fits = match column {
                Time(_) => row.stamp.is_some(),
                Direction => row.direction.is_some(),
                _ => true,
            };
            (fits || !blanks).then_some(())?;
            if matches!(column, Channel(_)) && blanks && cell.eq_ignore_ascii_case(b"can") {
                // `CAN 1` is one cell.
                let number = rest.next_if(|cell| cell.len() <= 2 && cell.iter().all(u8::is_ascii_digit));
                number.map_or(Some(()), |number| row.take(Channel(1), number))?;
            }
            if matches!(column, Id(_)) {
                // `1802 (0x70a)`.
                let hex = rest.next_if(|cell| cell.starts_with(b"(0x"));
                hex.map_or(Some(()), |hex| row.take(*column, hex))?;
            }
        }
        row.id.is_some().then_some(row)
    }

    /// Reads a row that names its values, in any order.
    fn read_pairs<'a>(&self, text: &'a [u8]) -> Option<Row<'a>> {
        let mut row = Row { decimal: self.decimal, ..Row::default() };
        let id = self.columns.iter().find(|column| matches!(column, Id(_)))?;
        let begin = pairs(text).next().map_or(0, |pair| pair.begin);
        let mut timed = false;
        words::take_before(&mut row, text.get(..begin)?);
        for pair in pairs(text) {
            let column = Column::of(&pair);
            match column {
                Id(UNSAID) => row.take(*id, pair.value)?,
                Time(_) if timed => {}
                _ => row.take(column, pair.value)?,
            }
            timed |= matches!(column, Time(_));
        }
        row.id.is_some().then_some(row)
    }

    /// Completes the layout of a heading by the rows below it; `None` if `more` of them may show the base.
    pub(super) fn completed(self, texts: &[&[u8]], more: bool) -> Option<Self> {
        let signs = self.signs(texts);
        let shown = if self.separator == Separator::Pairs { signs.list_is_decimal() } else { signs.decimal() };
        let decimal = self.base.map_or(shown, |base| base == 10);
        let mut layout = Self { decimal, ..self };
        if let Some(place) = layout.columns.iter().position(|column| *column == Id(UNSAID)) {
            let base = layout.id_base(place, texts, &signs);
            layout = layout.with_base(place, base.unwrap_or(16));
            if more && !signs.hex_ids && base != Ok(10) && texts.iter().any(|text| layout.reads(text)) {
                return None;
            }
            layout.refused = layout.refused.or(base.err());
        }
        let rows: Vec<Row<'_>> = texts.iter().filter_map(|text| layout.read(text)).collect();
        let listed = layout.columns.contains(&Length);
        let spread = layout.columns.contains(&Part) && !listed && rows.iter().any(|row| row.count < CLASSIC);
        if spread || layout.lies_apart(texts) {
            layout.refused = layout.refused.or(Some(Unreadable::Spread));
        }
        let sides = layout.cells_of(texts, |column| column == Direction);
        if !sides.is_empty() && sides.iter().all(|word| side(word).is_none()) {
            layout.columns.iter_mut().filter(|column| **column == Direction).for_each(|column| *column = Other);
        }
        let filled = rows.iter().all(|row| row.id.is_some_and(|(id, _)| id <= 0x7FF));
        Some(Self { filled, ..layout })
    }

    /// Returns the layout between blanks without a first column that has no meaning.
    pub(super) fn without_first(&self) -> Option<Self> {
        let (first, columns) = self.columns.split_first()?;
        let marked = *first == Other && self.separator == Separator::Blanks;
        marked.then(|| Self { columns: columns.to_vec(), ..self.clone() })
    }

    fn with_base(&self, place: usize, base: u32) -> Self {
        let mut layout = self.clone();
        layout.columns.iter_mut().skip(place).take(1).for_each(|column| *column = Id(base));
        layout
    }

    /// Returns the cells of some columns, those of the bytes as words.
    fn cells_of<'a>(&self, texts: &[&'a [u8]], of: fn(Column) -> bool) -> Vec<&'a [u8]> {
        let mut words = Vec::new();
        if self.separator == Separator::Pairs {
            let own = texts.iter().flat_map(|text| pairs(text)).filter(|pair| of(Column::of(pair)));
            let between = |byte: &u8| b" ,\"'".contains(byte);
            return own.flat_map(|pair| pair.value.split(between)).filter(|word| !word.is_empty()).collect();
        }
        for text in texts {
            let found = cells(text, self.separator);
            for (place, column) in self.columns.iter().enumerate().filter(|(_, column)| of(**column)) {
                let own = match (column, self.separator) {
                    (Data, Separator::Blanks) => found.iter().skip(place).take_while(|cell| is_hex(cell)).count(),
                    _ => 1,
                };
                let between = |byte: &u8| is_blank(*byte) && *column == Data;
                let own = found.iter().skip(place).take(own);
                words.extend(own.flat_map(|cell| cell.split(between)).filter(|word| !word.is_empty()));
            }
        }
        words
    }

    /// Returns what the words for identifiers and bytes show of their base.
    fn signs(&self, texts: &[&[u8]]) -> BaseSigns {
        let mut signs = BaseSigns::default();
        for cell in self.cells_of(texts, |column| matches!(column, Id(_))) {
            let (digits, hex, _) = id_digits(cell);
            let letter = digits.iter().any(u8::is_ascii_alphabetic);
            signs.hex_ids |= is_hex(digits) && (hex || letter || digits.len() > 1 && digits.starts_with(b"0"));
            signs.long |= digits.len() == 4 && !digits.starts_with(b"0");
        }
        let words = self.cells_of(texts, |column| matches!(column, Data | Column::Byte));
        for word in words.iter().filter(|word| is_hex(word)) {
            signs.letters |= word.iter().any(u8::is_ascii_alphabetic);
            (signs.three, signs.one) = (signs.three || word.len() == 3, signs.one || word.len() == 1);
            signs.padded |= word.len() == 2 && word.starts_with(b"0");
        }
        signs
    }

    /// Returns the base of the identifiers, one for the whole column; both readings of an identifier if they are as likely.
    fn id_base(&self, place: usize, texts: &[&[u8]], signs: &BaseSigns) -> Result<u32, Unreadable> {
        if signs.hex_ids || self.decimal && self.base.is_none() {
            return Ok(if signs.hex_ids { 16 } else { 10 });
        }
        let rows = |base| {
            let layout = self.with_base(place, base);
            let read = texts.iter().filter_map(|text| layout.read(text));
            read.filter(|row| row.extended != Some(true)).collect::<Vec<Row<'_>>>()
        };
        let (hex, dec) = (rows(16), rows(10));
        let id = |row: &Row<'_>| row.id.map_or(0, |(id, _)| id);
        let services = |rows: &[Row<'_>]| rows.iter().filter(|row| is_service(row)).count();
        let single = signs.one && !signs.letters && !signs.padded;
        let service = |row: &Row<'_>| matches!(id(row), 0x581..=0x5FF | 0x601..=0x67F | 0x701..=0x77F);
        let mut pairs = hex.iter().zip(&dec);
        // An identifier that is too long for hexadecimal digits, or else single digits of bytes, may be decimal.
        let pair = match pairs.clone().find(|(hex, _)| id(hex) > 0x7FF) {
            Some(pair) => Some(pair).filter(|_| dec.iter().all(|row| id(row) <= 0x7FF)),
            None => pairs.find(|(row, _)| single && id(row) > 9).filter(|_| !hex.iter().any(service)),
        };
        match pair {
            None => Ok(16),
            Some(_) if services(&dec) > services(&hex) => Ok(10),
            Some((hex, dec)) => Err(Unreadable::Base { hexadecimal: id(hex), decimal: id(dec) }),
        }
    }

    /// Returns true if no row has both an identifier and bytes, as where each byte has a row of its own.
    fn lies_apart(&self, texts: &[&[u8]]) -> bool {
        let Separator::Byte(_) = self.separator else { return false };
        let (mut apart, mut together) = (false, false);
        for text in texts {
            let found = cells(text, self.separator);
            let has = |of: fn(Column) -> bool| {
                let own = self.columns.iter().zip(&found).filter(|(column, _)| of(**column));
                own.into_iter().any(|(_, cell)| unprefixed(cell).first().is_some_and(u8::is_ascii_hexdigit))
            };
            let (id, data) =
                (has(|column| matches!(column, Id(_))), has(|column| matches!(column, Data | Column::Byte)));
            (apart, together) = (apart || data && !id, together || data && id);
        }
        apart && !together
    }

    /// Returns true if one of some rows shows that it is a frame.
    pub(super) fn shows(&self, texts: &[&[u8]]) -> bool {
        let mut rows = texts.iter().filter_map(|text| self.read(text).and_then(Row::whole));
        rows.any(|row| self.is_evident(&row))
    }

    /// Returns true if a row without a heading shows that it is a frame: by its length and a time, a direction or the word
    /// CAN, or by a service of CANopen.
    pub(super) fn is_evident(&self, row: &Row<'_>) -> bool {
        let told = self.columns.iter().any(|column| matches!(column, Time(_) | Direction));
        let shown = self.separator == Separator::Pairs || row.length.is_some() && told;
        shown && !self.weak || is_service(row)
    }
}

/// Returns true if a row is a service of CANopen by its identifier and bytes.
pub(super) fn is_service(row: &Row<'_>) -> bool {
    let (id, data) = (row.id.map_or(0, |(id, _)| id), row.data.get(..row.count).unwrap_or_default());
    let sdo = matches!(id, 0x581..=0x5FF | 0x601..=0x67F) && data.len() == 8;
    let control = matches!(id, 0x701..=0x77F) && matches!(data, [0 | 4 | 5 | 0x7F]);
    sdo || control
}

//! Rows that name each of their values: objects of JSON, dictionaries, initializers of structures, tags.
//!
//! `{"id": 1546, "data": [64, 23]}`, `{.can_id = 0x60A, .data = {0x40, 0x17}}`, `<frame id="0x60A" data="40 17"/>`. The names
//! are those of columns, so that each row is its own heading; an object may be spread over several lines.

use super::columns::Column::{self, Data, Id, Length, Time};
use super::columns::{Separator, UNSAID};
use super::layout::RowLayout;
use crate::bytes::readers::Unreadable;
use crate::bytes::readers::candump::lex::skip_blanks;

/// Maximum number of values of a row.
const PAIRS: usize = 48;

/// A value with its name.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair<'a> {
    name: &'a [u8],
    pub(super) value: &'a [u8],
    /// The value is in quotation marks or brackets.
    enclosed: bool,
    /// The notation has prefixes for hexadecimal numbers, so that one without is decimal.
    exact: bool,
    /// The end of the value in the text.
    end: usize,
}

impl Pair<'_> {
    pub(super) fn column(&self) -> Column {
        Column::named(&String::from_utf8_lossy(self.name).to_lowercase())
    }
}

/// Iterates over the values of a text with their names.
pub(super) fn pairs(text: &[u8]) -> impl Iterator<Item = Pair<'_>> {
    let mut end = 0;
    memchr::memchr2_iter(b':', b'=', text).filter_map(move |sign| {
        let pair = pair(text, sign).filter(|_| end <= sign)?;
        end = pair.end;
        Some(pair)
    })
}

/// Reads the pair whose sign is at this place.
fn pair(text: &[u8], sign: usize) -> Option<Pair<'_>> {
    let before = text.get(..sign)?.trim_ascii_end();
    let (name, exact) = match before {
        [inner @ .., quote @ (b'"' | b'\'')] => {
            let begin = memchr::memrchr(*quote, inner).map(|place| place + 1)?;
            (inner.get(begin..)?, true)
        }
        _ => {
            let is_part = |byte: &u8| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'-') || *byte >= 0x80;
            let begin = before.iter().rposition(|byte| !is_part(byte)).map_or(0, |place| place + 1);
            (before.get(begin..)?, begin.checked_sub(1).and_then(|place| before.get(place)) == Some(&b'.'))
        }
    };
    name.first().filter(|byte| !byte.is_ascii_digit())?;
    let rest = skip_blanks(text.get(sign + 1..)?);
    let (value, after) = match rest {
        [quote @ (b'"' | b'\''), inner @ ..] => inner.split_at_checked(memchr::memchr(*quote, inner)?)?,
        [b'[' | b'{' | b'(', ..] => {
            let (value, after) = enclosed(rest)?;
            // What has names inside is an object of its own.
            (!value.contains(&b':') && !value.contains(&b'=')).then_some((value, after))?
        }
        _ => {
            let end = rest.iter().position(|byte| matches!(byte, b',' | b';' | b'}' | b']' | b'>' | b' ' | b'\t'));
            let (word, after) = rest.split_at_checked(end.unwrap_or(rest.len()))?;
            // Of a call, `StandardId(0x60A)`, the argument counts.
            let begin = memchr::memrchr(b'(', word).map_or(0, |place| place + 1);
            let argument = word.get(begin..)?;
            (argument.split(|byte| *byte == b')').next()?, after)
        }
    };
    let is_quote = |byte: &u8| matches!(byte, b'"' | b'\'');
    let quoted = rest.first().is_some_and(is_quote);
    let enclosed = quoted || matches!(rest, [b'[' | b'{' | b'(', ..]);
    let exact = exact && !quoted && !value.iter().any(is_quote);
    Some(Pair { name, value, enclosed, exact, end: text.len() - after.len() + usize::from(enclosed) })
}

/// Splits a text that begins with a bracket behind what it encloses.
fn enclosed(text: &[u8]) -> Option<(&[u8], &[u8])> {
    let mut depth = 0i32;
    let end = text.iter().position(|byte| {
        depth += depth_of(*byte);
        depth == 0
    })?;
    Some((text.get(1..end)?, text.get(end..)?))
}

fn depth_of(byte: u8) -> i32 {
    match byte {
        b'[' | b'{' | b'(' => 1,
        b']' | b'}' | b')' => -1,
        _ => 0,
    }
}

/// Returns true if brackets of a text are open at its end.
pub(super) fn is_open(text: &[u8]) -> bool {
    text.iter().map(|byte| depth_of(*byte)).sum::<i32>() > 0
}

/// Returns the layout of a row that names its values: an identifier once, and its bytes in quotation marks or brackets.
pub(super) fn layout(text: &[u8]) -> Option<RowLayout> {
    let all: Vec<(Pair<'_>, Column)> = pairs(text).take(PAIRS).map(|pair| (pair, pair.column())).collect();
    let mut ids = all.iter().filter(|(_, column)| matches!(column, Id(_)));
    let ((id, _), None) = (ids.next()?, ids.next()) else { return None };
    let (bytes, _) = all.iter().find(|(pair, column)| *column == Data && pair.enclosed)?;
    let columns = all.iter().map(|(_, column)| match column {
        Id(UNSAID) if id.exact => Id(10),
        column => *column,
    });
    let columns: Vec<Column> = columns.collect();
    let has = |name: &[u8]| all.iter().any(|(pair, _)| pair.name == name);
    let name = String::from_utf8_lossy(id.name).to_lowercase();
    let timed = columns.iter().any(|column| matches!(column, Time(_) | Column::Direction));
    let prefixed = memchr::memmem::find(bytes.value, b"0x").is_some();
    Some(RowLayout {
        named: true,
        base: bytes.exact.then_some(if prefixed { 16 } else { 10 }),
        refused: (has(b"kind") && has(b"service")).then_some(Unreadable::Exported),
        // Other names may be those of anything.
        weak: !(["can", "arb", "cob"].iter().any(|word| name.contains(word)) || timed && columns.contains(&Length)),
        columns,
        ..RowLayout::new(Separator::Pairs)
    })
}

/// Returns the rows of a text, each of which names its values; the whole text if there are not several.
pub(super) fn rows(text: &[u8]) -> Vec<&[u8]> {
    let mut names: Vec<&[u8]> = Vec::new();
    let (mut rows, mut begin, mut end) = (Vec::new(), 0, 0);
    for pair in pairs(text) {
        // A row has each name once.
        if names.contains(&pair.name) || names.len() >= PAIRS {
            rows.extend(text.get(begin..end));
            begin = end;
            names.clear();
        }
        names.push(pair.name);
        end = pair.end;
    }
    rows.extend(text.get(begin..));
    if rows.iter().filter(|row| layout(row).is_some()).count() > 1 { rows } else { vec![text] }
}

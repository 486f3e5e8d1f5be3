//! Rows that name each of their values.
//!
//! `{"id": 1546, "data": [64, 23]}`, `{.can_id = 0x60A, .data = {0x40, 0x17}}`, `<frame id="0x60A" data="40 17"/>`. The names
//! are those of columns, so that each row is its own heading; an object may be spread over several lines.

use super::columns::Column::{self, Data, Id, Length, Time};
use super::columns::{Separator, UNSAID};
use super::layout::RowLayout;
use super::pairs::{Pair, pairs};
use crate::bytes::readers::Unreadable;

/// Maximum number of values of a row.
const PAIRS: usize = 48;

/// Returns the layout of a row that names its values: an identifier once, and its bytes in quotation marks or brackets.
pub(super) fn layout(text: &[u8]) -> Option<RowLayout> {
    let all: Vec<(Pair<'_>, Column)> = pairs(text).take(PAIRS).map(|pair| (pair, Column::of(&pair))).collect();
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

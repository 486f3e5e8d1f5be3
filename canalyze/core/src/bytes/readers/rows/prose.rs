//! Rows inside other text: the lines of a log, of a console, or of a printed trace.
//!
//! `Mar  2 10:11:12 host candump[123]:  can0  60A   [8]  40 08 10 ..`, `DEBUG canopen.network Sending 0x60A: 40 08 10 ..`,
//! `I (1234) TWAI: RX id=0x58A dlc=8 data=43 00 10 ..`, `$ cansend can0 60A#40081000..`. Words before the identifier and
//! behind listed bytes are text. A number is an identifier only with a mark: a prefix, a label, a bus before it, a listed
//! length in brackets, or as an SDO of eight bytes.

use super::columns::Column::{self, Channel, Data, Id, Length, Time};
use super::columns::{SECOND, Separator};
use super::layout::RowLayout;
use super::row::{CLASSIC, Row, direction, identifier, length};
use super::times::time;
use crate::bytes::frame::Direction;
use crate::bytes::readers::candump::lex::{is_blank, is_hex};

/// Maximum number of words of a line.
const WORDS: usize = 96;
/// Maximum number of words from the identifier to the bytes.
const BETWEEN: usize = 5;
/// Words before an identifier.
const LABELS: [&str; 9] = ["id", "can-id", "can_id", "canid", "cob-id", "cobid", "std", "ext", "xtd"];

/// A word without its label and the signs around it.
#[derive(Clone, Copy, Debug)]
struct Word<'a> {
    text: &'a [u8],
    /// The word as written, up to the signs around it.
    whole: &'a [u8],
    /// The place of its first byte in the line.
    begin: usize,
    labelled: bool,
    bracketed: bool,
    /// A colon follows.
    colon: bool,
}

fn words(line: &[u8]) -> Vec<Word<'_>> {
    let between = |byte: &u8| is_blank(*byte) || matches!(byte, b'"' | b';' | b'|');
    let mut begin = 0;
    let mut all = Vec::new();
    for piece in line.split(between) {
        let place = begin;
        begin += piece.len() + 1;
        let opening = piece.iter().take_while(|byte| matches!(byte, b'[' | b'(' | b'{')).count();
        let inner = piece.get(opening..).unwrap_or_default();
        let closing =
            inner.iter().rev().take_while(|byte| matches!(byte, b']' | b')' | b'}' | b',' | b':' | b'.')).count();
        let whole = inner.get(..inner.len() - closing).unwrap_or_default();
        let text = whole.rsplit(|byte| *byte == b'=').next().unwrap_or(whole);
        if !text.is_empty() && all.len() < WORDS {
            all.push(Word {
                text,
                whole,
                begin: place + opening,
                labelled: text.len() < whole.len(),
                bracketed: opening > 0 && closing > 0,
                colon: piece.ends_with(b":"),
            });
        }
    }
    all
}

/// Reads a row inside other text; `known`: others of its form are rows, so that it may have no bytes.
pub(super) fn guess(line: &[u8], known: bool) -> Option<(RowLayout, Row<'_>)> {
    if line.starts_with(b"{") {
        return None;
    }
    let words = words(line);
    let (place, mut row) = (0..words.len()).find_map(|place| Some((place, found(&words, place, known)?)))?;
    let head = words.get(..place)?;
    let mut columns = Vec::new();
    if let Some(cell) = stamp(line, head) {
        row.take(Time(SECOND), cell)?;
        columns.push(Time(SECOND));
    }
    if let Some(bus) = head.iter().rev().find(|word| is_bus(word.text)) {
        row.take(Channel(1), bus.text)?;
        columns.push(Channel(1));
    }
    row.direction = row.direction.or_else(|| head.iter().rev().find_map(|word| side(word.text)));
    columns.extend(row.direction.map(|_| Column::Direction));
    columns.push(Id(16));
    columns.extend(row.length.map(|_| Length));
    columns.push(Data);
    let layout = RowLayout { columns, prose: true, ..RowLayout::new(Separator::Blanks) };
    row.whole().map(|row| (layout, row))
}

/// Returns true if a line that cannot be read was meant as a row: bytes follow an identifier with a mark.
pub(super) fn is_meant(line: &[u8]) -> bool {
    let words = words(line);
    let place = (0..words.len()).find(|place| is_marked(&words, *place));
    let behind = place.and_then(|place| words.get(place + 1..)).unwrap_or_default();
    behind.iter().filter(|word| is_byte(word.text)).count() > 1
}

/// Reads the row whose identifier is the word at a place.
fn found<'a>(words: &[Word<'a>], place: usize, known: bool) -> Option<Row<'a>> {
    let word = words.get(place)?;
    if word.text.contains(&b'#') {
        return as_sent(word.text);
    }
    if !identifier(word.text) || word.text.iter().all(u8::is_ascii_alphabetic) {
        return None;
    }
    let mut row = Row::default();
    row.take(Id(16), word.text)?;
    let marked = is_marked(words, place);
    if known && word.colon && place + 1 == words.len() {
        return Some(row);
    }
    for at in place + 1..=place + BETWEEN {
        let (next, rest) = words.get(at..)?.split_first()?;
        // A zero alone is one of many numbers.
        let length = length(next.text).filter(|count| *count > 0 || known || next.bracketed || next.labelled);
        let listed = length.and_then(|count| Some((count, bytes(rest, Some(count))?)));
        let count = match listed {
            Some((count, used)) => {
                row.length = Some(count);
                rest.get(..used)?.iter().try_for_each(|word| row.bytes(word.text))?;
                return Some(row).filter(|row| marked || known || next.bracketed || is_service(row));
            }
            None => bytes(words.get(at..)?, None),
        };
        if let Some(used) = count {
            words.get(at..at + used)?.iter().try_for_each(|word| row.bytes(word.text))?;
            return Some(row).filter(|row| marked || is_service(row));
        }
        match side(next.text) {
            Some(side) => row.direction = Some(side),
            // A name.
            None if next.text.iter().any(u8::is_ascii_alphabetic) && !is_byte(next.text) => {}
            None => return None,
        }
    }
    None
}

/// Reads a frame as cansend takes it: `60A#4008100000000000`.
fn as_sent(text: &[u8]) -> Option<Row<'_>> {
    let at = text.iter().position(|byte| *byte == b'#')?;
    let (id, data) = text.split_at_checked(at)?;
    let data = data.get(1..).filter(|data| data.len().is_multiple_of(2) && data.len() <= 2 * CLASSIC)?;
    if !matches!(id.len(), 3 | 8) || !is_hex(id) || !data.iter().all(u8::is_ascii_hexdigit) {
        return None;
    }
    let mut row = Row { extended: Some(id.len() > 3), ..Row::default() };
    row.take(Id(16), id)?;
    if !data.is_empty() {
        row.bytes(data)?;
    }
    Some(row)
}

/// Returns the number of words that hold the bytes: so many as listed, with text behind them, or all up to the end of
/// the row. They are words of two digits, or one word.
fn bytes(words: &[Word<'_>], listed: Option<usize>) -> Option<usize> {
    let run = words.iter().take_while(|word| is_byte(word.text)).count();
    let joined = words.first().map(|word| word.text).filter(|word| {
        let digit = word.iter().any(u8::is_ascii_digit);
        (4..=2 * CLASSIC).contains(&word.len()) && word.len().is_multiple_of(2) && is_hex(word) && digit
    });
    match (listed, joined) {
        (Some(count), Some(word)) if word.len() == 2 * count => Some(1),
        (Some(count), _) => (run == count).then_some(run),
        (None, Some(_)) if is_end(words.get(1)) => Some(1),
        (None, _) => ((1..=CLASSIC).contains(&run) && is_end(words.get(run))).then_some(run),
    }
}

/// Returns true if a row ends before a word: there is none, or a remark follows.
fn is_end(word: Option<&Word<'_>>) -> bool {
    word.is_none_or(|word| word.text.starts_with(b"#") || word.text.starts_with(b"//") || word.text.starts_with(b"--"))
}

/// Returns true for a byte: two digits, with or without `0x`.
fn is_byte(word: &[u8]) -> bool {
    let digits = word.strip_prefix(b"0x").unwrap_or(word);
    digits.len() == 2 && is_hex(digits)
}

/// Returns true if the word at a place is marked as an identifier.
fn is_marked(words: &[Word<'_>], place: usize) -> bool {
    let Some(word) = words.get(place).filter(|word| identifier(word.text)) else { return false };
    let before = place.checked_sub(1).and_then(|place| words.get(place));
    let named = before.is_some_and(|before| {
        let label = LABELS.iter().any(|label| before.whole.eq_ignore_ascii_case(label.as_bytes()));
        is_bus(before.text) || label
    });
    let form = word.text.starts_with(b"0x") || word.text.starts_with(b"0X") || matches!(word.text, [.., b'h' | b'H']);
    form || word.colon || word.labelled || named
}

/// Returns true if a row is a service of CANopen by its identifier and bytes.
fn is_service(row: &Row<'_>) -> bool {
    RowLayout::new(Separator::Blanks).is_evident(row)
}

/// Returns the time in the words before an identifier, with the date before it.
fn stamp<'a>(line: &'a [u8], head: &[Word<'a>]) -> Option<&'a [u8]> {
    let timed =
        |word: &Word<'_>| word.text.iter().any(|byte| matches!(byte, b'.' | b':')) && time(word.text, SECOND).is_some();
    let at = head.iter().rposition(timed)?;
    let word = head.get(at)?;
    let date = at.checked_sub(1).and_then(|before| head.get(before));
    let both = date.and_then(|date| line.get(date.begin..word.begin + word.text.len()));
    both.filter(|both| time(both, SECOND).is_some()).or(Some(word.text))
}

/// Returns the direction that a word says.
fn side(word: &[u8]) -> Option<Direction> {
    let sent = ["->", "=>", ">>", "send", "sending", "sent", "transmit", "transmitted"];
    let received = ["<-", "<=", "<<", "recv", "receive", "received", "receiving"];
    let is = |known: &[&str]| known.iter().any(|known| word.eq_ignore_ascii_case(known.as_bytes()));
    match () {
        () if is(&sent) => Some(Direction::Tx),
        () if is(&received) => Some(Direction::Rx),
        () => direction(word),
    }
}

/// Returns true for the name of a bus: `can0`, `vcan1`, `CAN2`.
fn is_bus(word: &[u8]) -> bool {
    let name = word.strip_prefix(b"v").or_else(|| word.strip_prefix(b"sl")).unwrap_or(word);
    let number = name.strip_prefix(b"can").or_else(|| name.strip_prefix(b"CAN")).unwrap_or_default();
    (1..=3).contains(&number.len()) && number.iter().all(u8::is_ascii_digit)
}

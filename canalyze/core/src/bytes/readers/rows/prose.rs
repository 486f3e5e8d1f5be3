//! Rows inside other text: the lines of a log, of a console, or of a printed trace.
//!
//! `Mar  2 10:11:12 host candump[123]:  can0  60A   [8]  40 08 10 ..`, `DEBUG canopen.network Sending 0x60A: 40 08 10 ..`,
//! `I (1234) TWAI: RX id=0x58A dlc=8 data=43 00 10 ..`, `$ cansend can0 60A#40081000..`. Words before the identifier and
//! behind listed bytes are text. A number is an identifier only with a mark: a prefix, a label, a bus before it, a listed
//! length in brackets, or as an SDO of eight bytes. Once a file has shown a layout (`known`), rows need no mark.

use super::columns::Column::{self, Channel, Data, Id, Length, Time};
use super::columns::Separator;
use super::layout::{RowLayout, is_service};
use super::marked::slcan;
use super::objects;
use super::row::{CLASSIC, Row, identifier, length};
use super::times::{number, unprefixed};
use super::words::{Word, is_bus, is_time, side, stamp, words};
use crate::bytes::ns::Ns;
use crate::bytes::readers::candump::lex::is_hex;

/// Maximum number of words from the identifier to the bytes.
const BETWEEN: usize = 9;
/// Words before an identifier.
const LABELS: [&str; 11] =
    ["id", "can-id", "can_id", "canid", "cob-id", "cobid", "cob_id", "arbitration_id", "std", "ext", "xtd"];

/// Labels of an identifier that say what it is.
const KINDS: [&str; 3] = ["std", "ext", "xtd"];
/// Words before the bytes.
const BYTES: [&str; 4] = ["data", "bytes", "payload", "数据"];
/// Names of services that people write before an identifier, without the number of a PDO.
const SERVICES: [&str; 12] =
    ["nmt", "sync", "emcy", "time", "pdo", "tpdo", "rpdo", "sdo", "tsdo", "rsdo", "hb", "heartbeat"];
/// Labels of a length.
const LENGTHS: [&str; 5] = ["dlc", "len", "length", "dl", "size"];

/// Reads a row inside other text; `known`: others of its form are rows, so that it may have no bytes.
pub(super) fn guess(line: &[u8], known: bool) -> Option<(RowLayout, Row<'_>)> {
    if line.starts_with(b"{\"") || line.starts_with(b"{'") || objects::layout(line).is_some() {
        return None;
    }
    let words = words(line);
    let rows: Vec<(usize, Row<'_>)> =
        (0..words.len()).filter_map(|place| Some((place, found(&words, place, known)?))).collect();
    // A label or a listed length tells the identifier from other numbers, as the last one before it.
    let named = |(place, _): &&(usize, Row<'_>)| words.get(*place).is_some_and(|word| is_named(word, *place, &words));
    let sized = || rows.iter().rev().find(|(_, row)| row.length.is_some());
    let (mut place, mut row) = *rows.iter().find(named).or_else(sized).or(rows.first())?;
    // The first of several frames in a line.
    while let Some(before) = rows.iter().find(|(_, before)| before.end <= place && follows(&words, before.end, place)) {
        (place, row) = *before;
    }
    let last = row.end.checked_sub(1).and_then(|last| words.get(last));
    let several = rows.iter().any(|(place, _)| follows(&words, row.end, *place));
    row.end = last.filter(|_| several).map_or(0, |last| last.begin + last.text.len());
    let head = words.get(..place)?;
    let mut columns = Vec::new();
    if let Some((cell, unit)) = stamp(line, head) {
        row.take(Time(unit), cell)?;
        row.wraps_ns = Ns::ZERO;
        columns.push(Time(unit));
    }
    if let Some(bus) = head.iter().rev().find(|word| is_bus(word.text)) {
        row.take(Channel(1), bus.text)?;
        columns.push(Channel(1));
    }
    let label = head.last().map_or(b"".as_slice(), |word| word.whole);
    if row.extended.is_none() && (label.eq_ignore_ascii_case(b"std") || label.eq_ignore_ascii_case(b"xtd")) {
        row.extended = Some(label.eq_ignore_ascii_case(b"xtd"));
    }
    let own = words.get(place).and_then(|word| word.whole.split(|byte| matches!(byte, b':' | b'=')).next());
    row.direction = row.direction.or_else(|| own.and_then(side)).or_else(|| {
        // An arrow points at the identifier, or it stands between something else.
        let arrow = |place: usize| head.get(place + 1..).is_some_and(<[Word<'_>]>::is_empty);
        let timed = |place: usize| {
            place.checked_sub(1).and_then(|place| head.get(place)).is_some_and(|word| is_time(word.text))
        };
        let mut sides = head.iter().enumerate().rev().filter_map(|(place, word)| Some((place, word, side(word.text)?)));
        let alone = |word: &Word<'_>| word.text.iter().all(u8::is_ascii_punctuation);
        sides.find(|(place, word, _)| !alone(word) || arrow(*place) && !timed(*place)).map(|(.., side)| side)
    });
    columns.extend(row.direction.map(|_| Column::Direction));
    columns.push(Id(16));
    columns.extend(row.length.map(|_| Length));
    columns.push(Data);
    // Other protocols have numbers and bytes, too.
    let said = words.get(place).is_some_and(|word| is_named(word, place, &words))
        || columns.contains(&Channel(1))
        || words.get(place).is_some_and(|word| slcan(word.text).is_some())
        || line.windows(3).any(|word| word.eq_ignore_ascii_case(b"can"));
    let layout = RowLayout { columns, prose: true, weak: !said, ..RowLayout::new(Separator::Blanks) };
    row.whole().map(|row| (layout, row))
}

/// Returns true if a line that cannot be read was meant as a row: bytes follow an identifier with a mark.
pub(super) fn is_meant(line: &[u8]) -> bool {
    let words = words(line);
    let named = |place: &usize| {
        let word = words.get(*place).filter(|word| is_hex(pure(word.text)));
        word.is_some_and(|word| is_named(word, *place, &words))
    };
    let place = (0..words.len()).find(|place| is_marked(&words, *place) || named(place));
    let behind = place.and_then(|place| words.get(place + 1..)).unwrap_or_default();
    behind.iter().filter(|word| is_byte(word.text)).count() > 1
}

/// Returns true if the second word is the first one, a decimal number, in hexadecimal form.
fn is_same_in_hex(decimal: &[u8], hex: &[u8]) -> bool {
    let hex = hex.strip_prefix(b"0x").and_then(|digits| number(digits, 16));
    hex.is_some() && hex == number(decimal, 10)
}

/// Reads the row whose identifier is the word at a place.
fn found<'a>(words: &[Word<'a>], place: usize, known: bool) -> Option<Row<'a>> {
    let word = words.get(place)?;
    if word.text.contains(&b'#') && unprefixed(word.text).len() == word.text.len() {
        return as_sent(word.text).map(|row| Row { end: place + 1, ..row });
    }
    if let Some(row) = slcan(word.text).filter(|row| row.count > 1 || known) {
        return Some(Row { end: place + 1, ..row });
    }
    if !identifier(word.text) || word.text.iter().all(u8::is_ascii_alphabetic) {
        return None;
    }
    let marked = is_marked(words, place);
    // `ID: 133 (0x085)`.
    let again = words.get(place + 1).filter(|next| is_same_in_hex(word.text, next.text));
    let (word, place) = again.map_or((word, place), |again| (again, place + 1));
    let mut row = Row { end: place + 1, ..Row::default() };
    row.take(Id(16), word.text)?;
    // Wireshark names the kind of an identifier, and lists no length.
    let kind = place.checked_sub(1).and_then(|before| words.get(before)).filter(|kind| kind.colon);
    let kind = kind.is_some_and(|kind| {
        KINDS.iter().any(|known| kind.text.eq_ignore_ascii_case(known.as_bytes())) || is_service_name(kind.text)
    });
    match words.get(place + 1..) {
        Some([]) if known && (word.colon || kind) => return Some(row),
        Some([remote]) if known && kind && remote.text == b"RTR" => {
            return Some(Row { remote: true, end: place + 2, ..row });
        }
        _ => {}
    }
    for at in place + 1..=place + BETWEEN {
        let (next, rest) = words.get(at..)?.split_first()?;
        // A zero alone is one of many numbers.
        let label = at.checked_sub(1).and_then(|before| words.get(before)).filter(|word| is_label(word));
        if label.is_some_and(|label| {
            at > place + 1 && !LENGTHS.iter().any(|known| label.text.eq_ignore_ascii_case(known.as_bytes()))
        }) && next.text.iter().all(u8::is_ascii_digit)
            && !is_byte(next.text)
        {
            // The value of a label that says something else.
            continue;
        }
        let length = length(next.text).filter(|count| *count > 0 || known || next.bracketed || next.labelled);
        // Between the length and the bytes may be a label.
        let rest = match rest {
            [word, behind @ ..] if length.is_some() && is_label(word) => behind,
            _ => rest,
        };
        // The code of the length and the length may be listed.
        let rest = match rest {
            [word, behind @ ..] if length.is_some() && word.text == next.text => behind,
            _ => rest,
        };
        if length.is_some() && rest.first().is_some_and(|word| matches!(word.text, b"RTR" | b"rtr" | b"remote")) {
            (row.length, row.remote, row.end) = (length, true, words.len() - rest.len() + 1);
            return Some(row).filter(|_| marked || known);
        }
        let listed = length.and_then(|count| Some((count, bytes(rest, Some(count))?)));
        let count = match listed {
            Some((count, used)) => {
                (row.length, row.end) = (Some(count), words.len() - rest.len() + used);
                rest.get(..used)?.iter().try_for_each(|word| take(&mut row, word.text))?;
                return Some(row).filter(|row| marked || known || next.bracketed || is_service(row));
            }
            None => {
                let said = label
                    .is_some_and(|label| BYTES.iter().any(|word| label.text.eq_ignore_ascii_case(word.as_bytes())));
                let all = words.get(at..)?;
                let short = marked && said && (1..=CLASSIC).contains(&all.len()) && is_short(all);
                if short { Some(all.len()) } else { bytes(all, None) }
            }
        };
        if let Some(used) = count {
            row.end = at + used;
            words.get(at..at + used)?.iter().try_for_each(|word| take(&mut row, word.text))?;
            return Some(row)
                .filter(|row| marked || is_service(row) || known && at == place + 1 && plain(words, place));
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

/// Returns true if only a time, a bus or a direction is between the end of one row and the identifier of the next one.
fn follows(words: &[Word<'_>], end: usize, place: usize) -> bool {
    let is_known = |word: &Word<'_>| is_time(word.text) || is_bus(word.text) || side(word.text).is_some();
    end <= place && words.get(end..place).is_some_and(|between| between.iter().all(is_known))
}

/// Returns true for letters with a colon behind them, and for a word for bytes.
fn is_label(word: &Word<'_>) -> bool {
    let bytes = BYTES.iter().any(|known| word.text.eq_ignore_ascii_case(known.as_bytes()));
    bytes || word.colon && word.text.iter().all(u8::is_ascii_alphabetic)
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

/// Returns the number of words that hold the bytes: as many as listed, with text behind them, or all up to the end of
/// the row. They are words of two digits, or one word.
fn bytes(words: &[Word<'_>], listed: Option<usize>) -> Option<usize> {
    let run = words.iter().take_while(|word| is_byte(word.text)).count();
    let joined = words.first().map(|word| pure(word.text)).filter(|digits| {
        let digit = digits.iter().any(u8::is_ascii_digit);
        (4..=2 * CLASSIC).contains(&digits.len()) && digits.len().is_multiple_of(2) && is_hex(digits) && digit
    });
    let grouped = words.first().map_or(0, |word| groups(word.text).count());
    match (listed, joined) {
        (Some(count), _) if grouped > 1 && grouped == count => Some(1),
        (None, _) if (2..=CLASSIC).contains(&grouped) && is_end(words.get(1..), grouped) => Some(1),
        (Some(count), Some(word)) if word.len() == 2 * count => Some(1),
        (Some(count), _) if run == count => Some(run),
        // Programs that print numbers leave zeros out.
        (Some(count), _) => (words.len() == count && is_short(words)).then_some(count),
        // A long number with a prefix may be any.
        (None, Some(digits)) if is_end(words.get(1..), digits.len() / 2) => {
            (digits.len() == 2 * CLASSIC || words.first().is_some_and(|word| word.text == digits)).then_some(1)
        }
        (None, _) => ((1..=CLASSIC).contains(&run) && is_end(words.get(run..), run)).then_some(run),
    }
}

/// Returns true if all words are bytes of one or two digits, without zeros before them.
fn is_short(words: &[Word<'_>]) -> bool {
    words.iter().all(|word| (1..=2).contains(&word.text.len()) && is_hex(word.text))
}

/// Returns true if a row ends before words: there are none, a remark follows, the bytes as text, or no more bytes fit.
fn is_end(rest: Option<&[Word<'_>]>, count: usize) -> bool {
    let Some((first, others)) = rest.and_then(<[Word<'_>]>::split_first) else { return true };
    let remark = first.text.starts_with(b"#") || first.text.starts_with(b"//") || first.text.starts_with(b"--");
    remark || count == CLASSIC && !is_byte(first.text) || others.is_empty() && first.whole.len() == count && count > 2
}

/// Iterates over the bytes of a word that has signs between them; of none if it is no such word.
fn groups(word: &[u8]) -> impl Iterator<Item = &[u8]> {
    let sign = word.get(2).copied().filter(|sign| matches!(sign, b'-' | b':' | b'.' | b'_'));
    let valid =
        sign.is_some_and(|sign| word.split(|byte| *byte == sign).all(|group| group.len() == 2 && is_hex(group)));
    let sign = sign.unwrap_or_default();
    word.split(move |byte| *byte == sign).filter(move |_| valid)
}

/// Adds the bytes of a word.
fn take<'a>(row: &mut Row<'a>, word: &'a [u8]) -> Option<()> {
    if groups(word).next().is_some() {
        groups(word).try_for_each(|group| row.bytes(group))
    } else {
        row.bytes(pure(word))
    }
}

/// Returns true for the name of a service, with or without a number.
fn is_service_name(word: &[u8]) -> bool {
    let end = word.iter().rposition(|byte| !byte.is_ascii_digit()).map_or(0, |last| last + 1);
    let name = word.get(..end).unwrap_or_default();
    SERVICES.iter().any(|known| name.eq_ignore_ascii_case(known.as_bytes()))
}

/// Returns true if nothing but times, numbers, directions, buses and names of services stands before a word.
fn plain(words: &[Word<'_>], place: usize) -> bool {
    let known = |word: &Word<'_>| {
        let number = word.text.iter().all(|byte| byte.is_ascii_digit() || matches!(byte, b'.' | b':' | b'-' | b'/'));
        number || is_bus(word.text) || side(word.text).is_some() || is_service_name(word.text)
    };
    words.get(..place).is_some_and(|head| head.iter().all(known))
}

/// Returns the digits of a word without `0x` before them or `h` behind them.
fn pure(word: &[u8]) -> &[u8] {
    let digits = word.strip_prefix(b"0x").or_else(|| word.strip_prefix(b"0X")).unwrap_or(word);
    digits.strip_suffix(b"h").or_else(|| digits.strip_suffix(b"H")).unwrap_or(digits)
}

/// Returns true for a byte: two digits, with or without `0x` or `h`.
fn is_byte(word: &[u8]) -> bool {
    let digits = pure(word);
    (digits.len() == 2 || digits.len() == 1 && word.starts_with(b"0x")) && is_hex(digits)
}

/// Returns true if an identifier has a label.
fn is_named(word: &Word<'_>, place: usize, words: &[Word<'_>]) -> bool {
    let label = |label: &[u8]| {
        let label = label.strip_suffix(b"=").or_else(|| label.strip_suffix(b":")).unwrap_or(label);
        let label = label.rsplit(|byte| matches!(byte, b'=' | b':')).next().unwrap_or(label);
        let label = label.split(|byte| *byte == b'(').next().unwrap_or(label);
        LABELS.iter().any(|known| label.eq_ignore_ascii_case(known.as_bytes()))
    };
    let before = place.checked_sub(1).and_then(|place| words.get(place));
    let own = word.whole.get(..word.whole.len() - word.text.len()).unwrap_or_default();
    label(own) || before.is_some_and(|before| label(before.whole))
}

/// Returns true if the word at a place is marked as an identifier.
fn is_marked(words: &[Word<'_>], place: usize) -> bool {
    let Some(word) = words.get(place).filter(|word| identifier(word.text)) else { return false };
    let before = place.checked_sub(1).and_then(|place| words.get(place));
    let named = is_named(word, place, words) || before.is_some_and(|before| is_bus(before.text));
    let form = word.text.starts_with(b"0x") || word.text.starts_with(b"0X") || matches!(word.text, [.., b'h' | b'H']);
    form || word.colon || word.labelled || named
}

//! The words of a line with text around a row: without labels and signs, and what they say of time, bus and direction.

use super::columns::{MILLISECOND, SECOND};
use super::row::{Row, direction};
use super::times::{begins_with_comma, time};
use crate::bytes::frame::Direction;
use crate::bytes::readers::candump::lex::is_blank;

/// Maximum number of words of a line.
const WORDS: usize = 96;

/// A word without its label and the signs around it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Word<'a> {
    pub(super) text: &'a [u8],
    /// The word as written, up to the signs around it.
    pub(super) whole: &'a [u8],
    /// The place of its first byte in the line.
    pub(super) begin: usize,
    pub(super) labelled: bool,
    pub(super) bracketed: bool,
    /// A colon follows.
    pub(super) colon: bool,
}

pub(super) fn words(line: &[u8]) -> Vec<Word<'_>> {
    let mut all = Vec::new();
    let mut begin = 0;
    let decimal = begins_with_comma(line);
    for (place, byte) in line.iter().chain(b" ").enumerate() {
        let (before, after) = (place.checked_sub(1).and_then(|place| line.get(place)), line.get(place + 1));
        let digits = before.is_some_and(u8::is_ascii_digit) && after.is_some_and(u8::is_ascii_digit);
        let piece = line.get(begin..place).unwrap_or_default();
        // A comma may be that of a number, as behind a time of day.
        let time = piece.contains(&b':') && piece.iter().all(|byte| byte.is_ascii_digit() || b"[(:.-T".contains(byte));
        let comma = *byte == b',' && !(digits && (time || decimal));
        // `60A(8)`, `send(60A`, `[TX]60A`.
        let called = piece.iter().all(|byte| byte.is_ascii_alphanumeric() || *byte == b'_') && !piece.is_empty();
        let opened = *byte == b'(' && called && after.is_some_and(u8::is_ascii_hexdigit);
        let closed = before == Some(&b']') && byte.is_ascii_alphanumeric();
        let behind = opened || closed && !piece.is_empty();
        if !(behind || is_blank(*byte) || matches!(byte, b'"' | b';' | b'|' | b'`' | b'\'') || comma) {
            continue;
        }
        let opening = piece.iter().take_while(|byte| is_opening(**byte)).count();
        let inner = piece.get(opening..).unwrap_or_default();
        let closing =
            inner.iter().rev().take_while(|byte| matches!(byte, b']' | b')' | b'}' | b',' | b':' | b'.')).count();
        let whole = inner.get(..inner.len() - closing).unwrap_or_default();
        let mut text = whole;
        while let label @ 1.. = label(text) {
            text = text.get(label..).unwrap_or_default();
        }
        let label = whole.len() - text.len();
        while let [first, rest @ ..] = text
            && is_opening(*first)
        {
            text = rest;
        }
        if piece == b":"
            && let Some(last) = all.last_mut()
        {
            let last: &mut Word<'_> = last;
            last.colon = true;
        }
        if !text.is_empty() && all.len() < WORDS {
            all.push(Word {
                text,
                whole,
                begin: begin + opening + whole.len() - text.len(),
                labelled: label > 0,
                bracketed: opening > 0 && closing > 0,
                colon: piece.ends_with(b":"),
            });
        }
        begin = place + usize::from(!behind);
    }
    all
}

fn is_opening(byte: u8) -> bool {
    matches!(byte, b'[' | b'(' | b'{')
}

/// Returns the length of a label before a word: `id=`, `ID:`, letters before an equals sign or a colon.
fn label(word: &[u8]) -> usize {
    let sign = word.iter().position(|byte| matches!(byte, b'=' | b':')).unwrap_or(0);
    let letters = word.get(..sign).unwrap_or_default();
    let named = letters
        .iter()
        .all(|byte| byte.is_ascii_alphabetic() || *byte >= 0x80 || matches!(byte, b'-' | b'_' | b'.' | b'(' | b')'));
    if sign > 0 && sign + 1 < word.len() && named { sign + 1 } else { 0 }
}

/// Returns true for a time of day, or a number with a point.
pub(super) fn is_time(word: &[u8]) -> bool {
    word.iter().any(|byte| matches!(byte, b'.' | b':' | b',')) && time(word, SECOND).is_some()
}

/// Returns the time in the words before an identifier, with the date before it and the half of the day behind it: a
/// number of seconds since 1970, else the first time of day, else a number at the begin of the line or in brackets. With it
/// comes its unit in ns, seconds without one.
pub(super) fn stamp<'a>(line: &'a [u8], head: &[Word<'a>]) -> Option<(&'a [u8], i64)> {
    let labelled = |word: &Word<'_>| {
        let label = word.whole.get(..word.whole.len() - word.text.len()).unwrap_or_default();
        word.labelled && !matches!(label.first(), Some(b't' | b'T'))
    };
    let is = |of: &dyn Fn(usize, &Word<'_>) -> bool| {
        head.iter().enumerate().position(|(place, word)| is_time(word.text) && !labelled(word) && of(place, word))
    };
    let epoch = |_: usize, word: &Word<'_>| word.text.iter().position(|byte| *byte == b'.') == Some(10);
    let of_day = |_: usize, word: &Word<'_>| word.text.contains(&b':');
    let number = |place: usize, word: &Word<'_>| place == 0 || word.bracketed || word.labelled || word.colon;
    // A number of the row may be before it.
    let second = |place: usize, _: &Word<'_>| {
        place == 1 && head.first().is_some_and(|word| word.text.iter().all(u8::is_ascii_digit))
    };
    let at = is(&epoch).or_else(|| is(&of_day)).or_else(|| is(&number)).or_else(|| is(&second))?;
    let word = head.get(at)?;
    let (from, to) = (word.begin, word.begin + word.text.len());
    let date = at.checked_sub(1).and_then(|before| head.get(before)).map_or(from, |date| date.begin);
    let half = head.get(at + 1).filter(|half| matches!(half.text, b"AM" | b"PM" | b"am" | b"pm"));
    let end = half.map_or(to, |half| half.begin + half.text.len());
    let spans = [(date, end), (from, end), (date, to)];
    let mut longer = spans.iter().filter_map(|(from, to)| line.get(*from..*to));
    let in_ms = head.get(at + 1).is_some_and(|word| matches!(word.text, b"ms" | b"msec"));
    let unit = if in_ms { MILLISECOND } else { SECOND };
    longer.find(|cell| time(cell, SECOND).is_some()).or(Some(word.text)).map(|cell| (cell, unit))
}

/// Returns the direction that a word or an arrow shows.
pub(super) fn side(word: &[u8]) -> Option<Direction> {
    match word {
        b"->" | b"=>" | b">>" => Some(Direction::Tx),
        b"<-" | b"<=" | b"<<" => Some(Direction::Rx),
        _ => direction(word),
    }
}

/// Returns true for the name of a bus: `can0`, `vcan1`, `CAN2`.
pub(super) fn is_bus(word: &[u8]) -> bool {
    let name = word.strip_prefix(b"v").or_else(|| word.strip_prefix(b"sl")).unwrap_or(word);
    let number = name.strip_prefix(b"can").or_else(|| name.strip_prefix(b"CAN")).unwrap_or_default();
    (1..=3).contains(&number.len()) && number.iter().all(u8::is_ascii_digit)
}

/// Takes time, bus and direction from the text before a row.
pub(super) fn take_before<'a>(row: &mut Row<'a>, text: &'a [u8]) {
    let words = words(text);
    row.stamp = stamp(text, &words).and_then(|(cell, unit)| time(cell, unit));
    let bus = words.iter().rev().find(|word| is_bus(word.text));
    (row.channel, row.first) = bus.map_or((&b""[..], 1), |bus| (bus.text, 1));
    row.direction = words.iter().rev().find_map(|word| direction(word.text));
}

//! Values with their names: of objects of JSON, dictionaries, initializers of structures, tags.

use crate::bytes::readers::candump::lex::skip_blanks;

/// A value with its name.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair<'a> {
    pub(super) name: &'a [u8],
    pub(super) value: &'a [u8],
    /// The value is in quotation marks or brackets.
    pub(super) enclosed: bool,
    /// The notation has prefixes for hexadecimal numbers, so that one without is decimal.
    pub(super) exact: bool,
    /// The begin of the name and the end of the value in the text.
    pub(super) begin: usize,
    pub(super) end: usize,
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
    let (name, begin, exact) = match before {
        [inner @ .., quote @ (b'"' | b'\'')] => {
            let begin = memchr::memrchr(*quote, inner).map(|place| place + 1)?;
            (inner.get(begin..)?, begin, true)
        }
        _ => {
            let is_part = |byte: &u8| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'-') || *byte >= 0x80;
            let begin = before.iter().rposition(|byte| !is_part(byte)).map_or(0, |place| place + 1);
            let dotted = begin.checked_sub(1).and_then(|place| before.get(place)) == Some(&b'.');
            (before.get(begin..)?, begin, dotted)
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
    Some(Pair { name, value, enclosed, exact, begin, end: text.len() - after.len() + usize::from(enclosed) })
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

//! Strings from a capture, made safe for their destination (invariant 9).
//!
//! A device name may contain escape sequences, bidirectional overrides or broken UTF-8. None of it may reach a terminal
//! or break a JSON line. Backslashes are not doubled: the text is for reading, not for parsing back.

use std::cell::RefCell;

use super::digits::{KnownTexts, hex, hex_byte};

thread_local! {
    /// Texts that JSON writes as they are, but not ASCII: most are the same in many lines.
    static PLAIN: RefCell<KnownTexts> = RefCell::default();
}

/// Returns true if JSON writes a text as it is.
fn is_as_it_is(text: &[u8]) -> bool {
    if is_bare(text) {
        return true;
    }
    let key = hash(text);
    if PLAIN.with_borrow(|known| known.holds(key, text)) {
        return true;
    }
    let plain = text.iter().all(|byte| is_plain(*byte)) && std::str::from_utf8(text).is_ok();
    if plain {
        PLAIN.with_borrow_mut(|known| known.keep(key, text));
    }
    plain
}

/// Returns a number for a text, by eight bytes at a time.
fn hash(text: &[u8]) -> u64 {
    let mix = |hash: u64, word: u64| (hash.rotate_left(5) ^ word).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let (words, rest) = text.as_chunks::<8>();
    let hash = words.iter().fold(text.len() as u64, |hash, word| mix(hash, u64::from_le_bytes(*word)));
    rest.iter().fold(hash, |hash, byte| mix(hash, u64::from(*byte)))
}

/// Ends the JSON string whose text begins at `start`, behind its opening quote.
pub fn close(out: &mut Vec<u8>, start: usize) {
    if out.get(start..).is_some_and(is_as_it_is) {
        return out.push(b'"');
    }
    let text = out.split_off(start);
    out.pop();
    json(out, &text);
}

/// Returns true if all of `bytes` are ASCII that JSON writes as it is. Looks at eight bytes at a time: most text is such.
#[inline]
fn is_bare(bytes: &[u8]) -> bool {
    const ONES: u64 = 0x0101_0101_0101_0101;
    const HIGH: u64 = 0x80 * ONES;
    // In a word of bytes below 128, a borrow into the highest bit shows a byte that is less.
    let less = |word: u64, limit: u64| word.wrapping_sub(limit * ONES) & !word;
    let equal = |word: u64, byte: u8| less(word ^ (u64::from(byte) * ONES), 1);
    let bare = |word: [u8; 8]| {
        let word = u64::from_le_bytes(word);
        let marks = equal(word, b'"') | equal(word, b'[') | equal(word, b'\\') | equal(word, 0x7F);
        (word | less(word, 0x20) | marks) & HIGH == 0
    };
    let (words, rest) = bytes.as_chunks::<8>();
    let last = bytes.last_chunk::<8>().copied().unwrap_or_else(|| {
        let mut last = [b' '; 8];
        last.iter_mut().zip(rest).for_each(|(slot, byte)| *slot = *byte);
        last
    });
    words.iter().all(|word| bare(*word)) && bare(last)
}

/// Appends `bytes` as a JSON string, with its quotes. Invalid UTF-8 becomes U+FFFD.
pub fn json(out: &mut Vec<u8>, bytes: &[u8]) {
    out.push(b'"');
    if is_bare(bytes) {
        out.extend_from_slice(bytes);
    } else if let Ok(text) = std::str::from_utf8(bytes) {
        valid(out, text);
    } else {
        for chunk in bytes.utf8_chunks() {
            valid(out, chunk.valid());
            if !chunk.invalid().is_empty() {
                push(out, char::REPLACEMENT_CHARACTER);
            }
        }
    }
    out.push(b'"');
}

/// Appends the text between the quotes. Runs without escapes are copied at once, since this is much of the time of a
/// JSON line.
fn valid(out: &mut Vec<u8>, text: &str) {
    let (mut start, mut at) = (0, 0);
    while let Some(plain) = text.as_bytes().get(at..).and_then(|rest| rest.iter().position(|byte| !is_plain(*byte))) {
        at += plain;
        let (Some(before), Some(c)) = (text.get(start..at), text.get(at..).and_then(|rest| rest.chars().next())) else {
            break;
        };
        let here = at;
        at += c.len_utf8();
        let command =
            c == '[' && text.get(..here).is_some_and(|before| before.ends_with("##") || before.ends_with("##vso"));
        if c != '"' && c != '\\' && !unsafe_on_a_terminal(c) && !command {
            continue;
        }
        out.extend_from_slice(before.as_bytes());
        start = at;
        match c {
            '"' => out.extend_from_slice(b"\\\""),
            '\\' => out.extend_from_slice(b"\\\\"),
            '\n' => out.extend_from_slice(b"\\n"),
            '\r' => out.extend_from_slice(b"\\r"),
            '\t' => out.extend_from_slice(b"\\t"),
            // A JSON line may also be read on a terminal, so unsafe characters are escaped here, and so are the
            // commands of GitHub's and Azure's runners, anywhere in a line.
            c => {
                for unit in c.encode_utf16(&mut [0; 2]) {
                    out.extend_from_slice(b"\\u");
                    hex(out, u64::from(*unit), 4);
                }
            }
        }
    }
    out.extend_from_slice(text.get(start..).unwrap_or("").as_bytes());
}

/// Returns true if no character that contains this byte needs an escape in JSON. For a character of several bytes only
/// the first byte indicates that it has to be checked.
#[inline]
fn is_plain(byte: u8) -> bool {
    !matches!(byte, 0..=0x1F | b'"' | b'[' | b'\\' | 0x7F | 0xC2 | 0xD8 | 0xE1 | 0xE2 | 0xEF | 0xF3..=0xFF)
}

/// Appends `bytes` for a terminal or a report: control characters are written `\xNN` or `\u{NNNN}`, and so is every
/// byte that is not UTF-8.
pub fn terminal(out: &mut Vec<u8>, bytes: &[u8]) {
    if bytes.iter().all(|byte| matches!(byte, b' '..=b'~')) {
        return out.extend_from_slice(bytes);
    }
    for chunk in bytes.utf8_chunks() {
        for c in chunk.valid().chars() {
            if !unsafe_on_a_terminal(c) {
                push(out, c);
            } else if c.is_ascii() {
                out.extend_from_slice(b"\\x");
                hex_byte(out, c as u8);
            } else {
                out.extend_from_slice(b"\\u{");
                let code = u64::from(c as u32);
                hex(out, code, if code > 0xFFFF { 6 } else { 4 });
                out.push(b'}');
            }
        }
        for byte in chunk.invalid() {
            out.extend_from_slice(b"\\x");
            hex_byte(out, *byte);
        }
    }
}

/// Returns true if a character can move the cursor, start a sequence, reorder or hide other text.
pub fn unsafe_on_a_terminal(c: char) -> bool {
    c.is_control()
        || matches!(c,
            '\u{AD}' | '\u{61C}' | '\u{180E}' | '\u{200B}'..='\u{200F}' | '\u{2028}'..='\u{202E}'
            | '\u{2060}'..='\u{206F}' | '\u{FEFF}' | '\u{FFF9}'..='\u{FFFB}' | '\u{E0000}'..='\u{E0FFF}')
}

fn push(out: &mut Vec<u8>, c: char) {
    out.extend_from_slice(c.encode_utf8(&mut [0; 4]).as_bytes());
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;
    use proptest::prelude::*;

    fn shown(bytes: &[u8]) -> String {
        let mut out = Vec::new();
        terminal(&mut out, bytes);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn what_a_terminal_must_not_see() {
        assert_eq!(shown("Zephyr \u{8BBE}\u{5907}".as_bytes()), "Zephyr \u{8BBE}\u{5907}");
        assert_eq!(shown(b"\x1b[31mred\x7f\r\n"), "\\x1B[31mred\\x7F\\x0D\\x0A");
        assert_eq!(shown("a\u{202e}b\u{9b}c".as_bytes()), "a\\u{202E}b\\u{009B}c");
        assert_eq!(shown(b"\xC3\x28"), "\\xC3(");
    }

    #[test]
    fn every_unsafe_character_is_looked_at() {
        for c in (0..=0x0010_FFFF).filter_map(char::from_u32).filter(|c| unsafe_on_a_terminal(*c)) {
            let mut out = Vec::new();
            json(&mut out, format!("a{c}").as_bytes());
            let written = String::from_utf8(out).unwrap();
            assert!(written.starts_with(r#""a\"#) && !written.chars().any(unsafe_on_a_terminal), "{c:?}: {written}");
        }
    }

    #[test]
    fn json_strings() {
        let mut out = Vec::new();
        json(&mut out, "a\"b\\c\n\u{1}\u{202e}".as_bytes());
        assert_eq!(String::from_utf8(out).unwrap(), r#""a\"b\\c\n\u0001\u202E""#);
        let mut out = Vec::new();
        json(&mut out, b"[#[##[error]x");
        assert_eq!(String::from_utf8(out).unwrap(), r###""[#[##\u005Berror]x""###);
    }

    #[test]
    fn bare_text_is_what_needs_no_escape() {
        for byte in 0..=255 {
            for place in 0..20 {
                let mut text = *b"a plain text, of 20.";
                text[place] = byte;
                let bare = matches!(byte, b' '..=b'~') && !matches!(byte, b'"' | b'[' | b'\\');
                assert_eq!(is_bare(&text), bare, "{byte:02X} at {place}");
            }
        }
    }

    #[test]
    fn a_text_seen_before_is_closed_alike() {
        for text in ["\u{8282}\u{70B9}3", "\u{8282}\u{70B9}3[", "\u{202E}abc"] {
            let closed = |_| {
                let mut out = b"\"".to_vec();
                out.extend_from_slice(text.as_bytes());
                close(&mut out, 1);
                out
            };
            let all: Vec<_> = (0..100).map(closed).collect();
            let mut alone = Vec::new();
            json(&mut alone, text.as_bytes());
            assert!(all.iter().all(|one| *one == alone), "{text}");
        }
    }

    proptest! {
        #[test]
        fn any_bytes_are_made_safe(bytes in proptest::collection::vec(any::<u8>(), 0..64)) {
            prop_assert!(!shown(&bytes).chars().any(unsafe_on_a_terminal));
            let mut out = Vec::new();
            json(&mut out, &bytes);
            let read: String = serde_json::from_slice(&out).unwrap();
            prop_assert_eq!(read, String::from_utf8_lossy(&bytes));
        }
    }
}

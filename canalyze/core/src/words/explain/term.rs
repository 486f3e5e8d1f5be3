//! Terms of CANopen: what they are, where they are defined, and what usually goes wrong with them.
//!
//! A term is found by any of its names, whatever their case, in either language. Must not: look at a frame.

use crate::rules::Words;
use crate::words::Lang;
use crate::words::digits::{Hex, put};

/// A term: its names with single spaces (the first, in English, and the second, in Chinese, are shown); the clause; the
/// meaning; the usual mistakes.
type Term = (&'static [&'static str], &'static str, Words, Words);

static TERMS: &[Term] = words!("glossary");

/// Appends what a term is; `false`, and nothing, where it is none that is known.
pub(super) fn term(out: &mut Vec<u8>, lang: Lang, text: &str) -> bool {
    let wanted: Vec<String> =
        text.split(|one: char| one.is_whitespace() || one == '-').map(str::to_lowercase).collect();
    let wanted = wanted.iter().filter(|one| !one.is_empty()).map(String::as_str).collect::<Vec<_>>().join(" ");
    let known = |name: &str| !is_object(name) && name.to_lowercase().replace('-', " ") == wanted;
    let Some((names, clause, what, wrong)) = TERMS.iter().find(|one| one.0.iter().any(|name| known(name))) else {
        return false;
    };
    let (english, chinese) = (names.first().copied().unwrap_or(""), names.get(1).copied().unwrap_or(""));
    put!(out; lang.pick(chinese, english), " (", lang.pick(english, chinese), "): ");
    put!(out; lang.of(*what), "\n  ");
    put!(out; lang.pick("常见错误: ", "Usual mistakes: "), lang.of(*wrong), "\n  ");
    put!(out; *clause, "\n");
    true
}

/// Appends what is to be known of an object, where it is that of a term.
pub(super) fn of_object(out: &mut Vec<u8>, lang: Lang, index: u16) {
    let index = match index {
        0x1200..=0x12FF => 0x1200,
        0x1400..=0x15FF => 0x1400,
        0x1600..=0x17FF | 0x1A00..=0x1BFF => 0x1600,
        0x1800..=0x19FF => 0x1800,
        other => other,
    };
    let mut name = Vec::new();
    put!(&mut name; Hex::<4>(u64::from(index)), "h");
    let of = |one: &&Term| one.0.iter().any(|known| known.as_bytes().eq_ignore_ascii_case(&name));
    if let Some((.., what, wrong)) = TERMS.iter().find(of) {
        put!(out; "  ", lang.of(*what), "\n");
        put!(out; lang.pick("  常见错误: ", "  Usual mistakes: "), lang.of(*wrong), "\n");
    }
}

/// Returns true if a name is the index of an object, which is not a term.
fn is_object(name: &str) -> bool {
    matches!(name.as_bytes(), [digits @ .., b'h'] if digits.len() == 4 && digits.iter().all(u8::is_ascii_hexdigit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_belongs_to_one_term_and_every_term_is_found() {
        let mut names = std::collections::BTreeSet::new();
        for (one, ..) in TERMS {
            assert!(one.len() >= 2 && !one.get(1).is_some_and(|name| name.is_ascii()), "{one:?}");
            for name in *one {
                assert!(names.insert(name.to_lowercase().replace('-', " ")), "{name}");
                let (mut zh, mut en) = (Vec::new(), Vec::new());
                if is_object(name) {
                    let index = u16::from_str_radix(name.trim_end_matches('h'), 16).unwrap_or_default();
                    of_object(&mut en, Lang::En, index);
                    assert!(!en.is_empty(), "{name}");
                    continue;
                }
                assert!(term(&mut zh, Lang::Zh, name) && term(&mut en, Lang::En, &name.to_uppercase()), "{name}");
                assert_ne!(zh, en);
            }
        }
    }

    #[test]
    fn what_is_no_term_is_none() {
        for text in ["", "foo", "sync foo", "-"] {
            assert!(!term(&mut Vec::new(), Lang::En, text), "{text}");
        }
    }
}

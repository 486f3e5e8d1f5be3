//! Sentences of rules, filled with measured facts: `SYNC 计数为{found}, 应为{expected}`.
//!
//! The finding names its sentence. Facts are printed here, for all rules alike.

use super::digits::{Hex, Spaced, put};
use super::services::sdo;
use super::value::Size;
use super::{Lang, escape, signal, terms};
use crate::bytes::ns::Ns;
use crate::rules::finding::{CrcMatch, NamedProblem, Quantity, Said};
use crate::sdo::wire::Side;
use crate::wire::error_control;
use crate::wire::{emcy, lss, nmt};

/// Maximum number of bytes of one value in a sentence.
const BYTES: usize = 16;
/// Maximum number of characters of one text in a sentence.
const CHARACTERS: usize = 64;

/// Appends a sentence. A name in braces is replaced by its fact in a suitable unit, `{frames|frame|frames}` by a number
/// with its noun.
pub fn fill(out: &mut Vec<u8>, lang: Lang, sentence: &str, named: impl Fn(&str) -> Option<Said>) {
    let mut rest = sentence;
    while let Some((before, after)) = rest.split_once('{') {
        put!(out; before);
        let Some((name, after)) = after.split_once('}') else { return };
        let (name, nouns) = name.split_once('|').map_or((name, None), |(name, nouns)| (name, nouns.split_once('|')));
        let fact = named(name);
        if let Some(fact) = &fact {
            say(out, lang, fact);
        }
        if let Some((one, more)) = nouns {
            put!(out; " ", if fact == Some(Said::Quantity(Quantity::Count(1))) { one } else { more });
        }
        rest = after;
    }
    put!(out; rest);
}

/// Appends one fact.
fn say(out: &mut Vec<u8>, lang: Lang, said: &Said) {
    match said {
        Said::Quantity(quantity) => print(out, lang, *quantity),
        Said::Real(number) => out.extend_from_slice(number.to_string().as_bytes()),
        Said::Bool(on) => put!(out; if *on { "TRUE" } else { "FALSE" }),
        Said::Text(text) => quoted(out, text),
        Said::Bytes(bytes) => {
            put!(out; Spaced(bytes.get(..BYTES).unwrap_or(bytes)), if bytes.len() > BYTES { " ..." } else { "" });
        }
        Said::Word(word) => put!(out; *word),
        Said::Problems(named, more) => problems(out, lang, named, *more),
    }
}

/// Appends text of a capture or a file in quotes; long text is cut.
fn quoted(out: &mut Vec<u8>, text: &str) {
    put!(out; "\"");
    let end = text.char_indices().nth(CHARACTERS).map(|(end, _)| end);
    escape::terminal(out, text.get(..end.unwrap_or(text.len())).unwrap_or(text).as_bytes());
    put!(out; if end.is_some() { "...\"" } else { "\"" });
}

/// Appends problems: their kinds as written in files, with the node and the first frame of each.
fn problems(out: &mut Vec<u8>, lang: Lang, named: &[NamedProblem], more: u64) {
    for (place, one) in named.iter().enumerate() {
        put!(out; if place > 0 { lang.pick("、", ", ") } else { "" });
        if let Some(node) = one.node {
            put!(out; lang.pick("节点", "node "), node, " ");
        }
        // The name is English.
        put!(out; one.name, lang.pick(" ", ""), lang.pick(one.words.zh, ""));
        put!(out; lang.pick(" (第", " (frame "), one.frame, lang.pick("帧)", ")"));
    }
    if more > 0 {
        put!(out; lang.pick(", 另有", " and "), more, lang.pick("个问题", " more"));
    }
}

/// Appends one quantity.
pub fn print(out: &mut Vec<u8>, lang: Lang, quantity: Quantity) {
    match quantity {
        Quantity::Nothing => {}
        Quantity::Count(number) => put!(out; number),
        Quantity::Signed(number) => put!(out; number),
        Quantity::Ns(ns) => duration(out, ns),
        Quantity::Hex2(number) => put!(out; Hex::<2>(u64::from(number)), "h"),
        Quantity::Hex4(number) => put!(out; Hex::<4>(u64::from(number)), "h"),
        Quantity::Hex8(number) => put!(out; Hex::<8>(u64::from(number)), "h"),
        Quantity::Object(mux) => put!(out; mux),
        Quantity::Id(id) if id.is_extended() => put!(out; Hex::<8>(u64::from(id.raw())), "h"),
        Quantity::Id(id) => put!(out; Hex::<3>(u64::from(id.raw())), "h"),
        Quantity::State(state) => match error_control::state(lang, state) {
            Some(word) => put!(out; word),
            None => put!(out; Hex::<2>(u64::from(state)), "h"),
        },
        Quantity::Command(command) => match nmt::command(lang, command) {
            Some(word) => put!(out; word),
            None => put!(out; Hex::<2>(u64::from(command)), "h"),
        },
        Quantity::Pdo(transmit, number) => put!(out; if transmit { "TPDO" } else { "RPDO" }, number),
        Quantity::Lss(command) => {
            put!(out; Hex::<2>(u64::from(command)), "h");
            if let Some(word) = lss::command(lang, command) {
                put!(out; " ", word);
            }
        }
        Quantity::LssError(command, code) => {
            put!(out; Hex::<2>(u64::from(code)), "h");
            if let Some(word) = lss::error_of(lang, command, code) {
                put!(out; " ", word);
            }
        }
        Quantity::Statusword(word) => drive_word(out, lang, 0x6041, word),
        Quantity::Controlword(word) => drive_word(out, lang, 0x6040, word),
        Quantity::Drive(word) => {
            put!(out; crate::world::drive::DriveState::of(word).map_or("", |state| terms::drive::state(lang, state)));
        }
        Quantity::Abort(code) => sdo::abort(out, lang, code),
        Quantity::Mode(mode) => put!(out; i64::from(mode), " ", terms::drive::mode(lang, mode)),
        Quantity::Emcy(code, profile) => {
            put!(out; Hex::<4>(u64::from(code)), "h");
            if let Some(word) = emcy::code(lang, profile, code) {
                put!(out; " ", word);
            }
        }
        Quantity::Side(Side::Client) => put!(out; lang.pick("主站", "client")),
        Quantity::Side(Side::Server) => put!(out; lang.pick("从站", "server")),
        Quantity::Size(bytes) => put!(out; Size(lang, bytes)),
        Quantity::Crc(matches) => put!(out; crc(lang, matches)),
        Quantity::Type(code) => match crate::world::od::DataType::from_code(code) {
            Some(data_type) => put!(out; data_type.name()),
            None => put!(out; Hex::<4>(u64::from(code)), "h"),
        },
    }
}

/// Returns the data that a wrong CRC would match.
fn crc(lang: Lang, matches: CrcMatch) -> &'static str {
    match matches {
        CrcMatch::Nothing => "",
        CrcMatch::WithPadding => {
            lang.pick(" (计入最后一段的填充字节时相符)", " (matches with the padding of the last segment included)")
        }
        CrcMatch::InitialFfff => lang.pick(" (初值为FFFFh时相符)", " (matches with initial value FFFFh)"),
        CrcMatch::Reflected => lang.pick(" (按位反转的算法时相符)", " (matches the reflected variant)"),
    }
}

/// Appends a controlword or a statusword and its meaning: `0637h 运行使能`.
fn drive_word(out: &mut Vec<u8>, lang: Lang, index: u16, word: u16) {
    put!(out; Hex::<4>(u64::from(word)), "h ");
    signal::annotation(out, lang, index, u64::from(word));
}

/// Appends a duration in its usual unit: `350 µs`, `1.2 ms`, `1.5 s`. At most three digits after the point, without
/// trailing zeros.
pub fn duration(out: &mut Vec<u8>, ns: Ns) {
    let (unit, name) = match ns.as_ns().unsigned_abs() {
        0 => (1_000_000_000, " s"),
        1..1_000_000 => (1_000, " µs"),
        1_000_000..1_000_000_000 => (1_000_000, " ms"),
        _ => (1_000_000_000, " s"),
    };
    if ns < Ns::ZERO {
        out.push(b'-');
    }
    let thousandths = (u128::from(ns.as_ns().unsigned_abs()) * 1000 + unit / 2) / unit;
    put!(out; (thousandths / 1000) as u64);
    let fraction = (thousandths % 1000) as u64;
    if fraction != 0 {
        let digits = [fraction / 100, fraction / 10 % 10, fraction % 10];
        let shown = 3 - digits.iter().rev().take_while(|digit| **digit == 0).count();
        out.push(b'.');
        out.extend(digits.iter().take(shown).map(|digit| b'0' + *digit as u8));
    }
    put!(out; name);
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;

    fn says(ns: Ns) -> String {
        let mut out = Vec::new();
        duration(&mut out, ns);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn durations() {
        for (ns, text) in [
            (0, "0 s"),
            (350_000, "350 µs"),
            (1_500, "1.5 µs"),
            (1_200_000, "1.2 ms"),
            (-800_000, "-800 µs"),
            (10_000_000, "10 ms"),
            (1_500_000_000, "1.5 s"),
            (10_250_125_000, "10.25 s"),
        ] {
            assert_eq!(says(Ns(ns)), text);
        }
    }

    #[test]
    fn sentences() {
        let mut out = Vec::new();
        let named = |name: &str| match name {
            "found" => Some(Said::Quantity(Quantity::Count(7))),
            "one" => Some(Said::Quantity(Quantity::Count(1))),
            "expected" => Some(Said::Quantity(Quantity::Ns(Ns(1_000_000)))),
            _ => None,
        };
        fill(&mut out, Lang::En, "{found} instead of {expected}: {found|frame|frames}, {one|bit|bits}.", named);
        assert_eq!(out, b"7 instead of 1 ms: 7 frames, 1 bit.");
    }
}

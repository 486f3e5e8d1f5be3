//! Bytes of a description as text. An EDS names no encoding, so anything but UTF-8 is recognized by its letters.
//!
//! GB18030, the ANSI code page 1252 and the DOS code pages 850 and 437 accept nearly any bytes; the encoding is the one
//! that makes words. A byte 94h between two small letters is an ö of code page 850, because a closing quotation mark of
//! 1252 does not occur there.

use encoding_rs::{Encoding, GB18030, UTF_8};

use super::ini::line_at;

/// Code pages by name, with the characters from 80h, in the order in which a tie is decided.
const SINGLE: [(&str, &str); 3] = [
    (
        "cp1252",
        "€\u{FFFD}‚ƒ„…†‡ˆ‰Š‹Œ\u{FFFD}Ž\u{FFFD}\u{FFFD}‘’“”•–—˜™š›œ\u{FFFD}žŸ\u{A0}¡¢£¤¥¦§¨©ª«¬\u{AD}®¯°±²³´µ¶·¸¹º»¼½¾¿\
     ÀÁÂÃÄÅÆÇÈÉÊËÌÍÎÏÐÑÒÓÔÕÖ×ØÙÚÛÜÝÞßàáâãäåæçèéêëìíîïðñòóôõö÷øùúûüýþÿ",
    ),
    (
        "cp850",
        "ÇüéâäàåçêëèïîìÄÅÉæÆôöòûùÿÖÜø£Ø×ƒáíóúñÑªº¿®¬½¼¡«»░▒▓│┤ÁÂÀ©╣║╗╝¢¥┐\
     └┴┬├─┼ãÃ╚╔╩╦╠═╬¤ðÐÊËÈıÍÎÏ┘┌█▄¦Ì▀ÓßÔÒõÕµþÞÚÛÙýÝ¯´\u{AD}±‗¾¶§÷¸°¨·¹³²■\u{A0}",
    ),
    (
        "cp437",
        "ÇüéâäàåçêëèïîìÄÅÉæÆôöòûùÿÖÜ¢£¥₧ƒáíóúñÑªº¿⌐¬½¼¡«»░▒▓│┤╡╢╖╕╣║╗╝╜╛┐\
     └┴┬├─┼╞╟╚╔╩╦╠═╬╧╨╤╥╙╘╒╓╫╪┘┌█▄▌▐▀αßΓπΣσµτΦΘΩδ∞φε∩≡±≥≤⌠⌡÷≈°∙·√ⁿ²■\u{A0}",
    ),
];
/// Bytes of lines beyond ASCII that are enough to judge by.
const JUDGED: usize = 1 << 16;
const LETTERS: &str = "äöüßéèêëàâáåæøœçñíìîïóòôõúùûãčšžýÿ";
const SIGNS: &str = "®©™–—“”‘’„…²³±·«»€§";

/// Text with the name of its encoding.
pub(super) struct Decoded {
    pub(super) text: String,
    pub(super) encoding: &'static str,
    /// It began with a byte order mark.
    pub(super) marked: bool,
}

/// Returns the text of any bytes; bytes that are invalid in every encoding become U+FFFD.
pub(super) fn decode(data: &[u8]) -> Decoded {
    if let Some((text, encoding)) = marked(data) {
        return Decoded { text, encoding, marked: true };
    }
    let (text, encoding) = match std::str::from_utf8(data) {
        Ok(text) => (text.to_owned(), "utf-8"),
        Err(_) => chinese(data).map_or_else(|| european(data), |text| (text, "gb18030")),
    };
    Decoded { text, encoding, marked: false }
}

/// Returns the text behind a byte order mark.
fn marked(data: &[u8]) -> Option<(String, &'static str)> {
    if let Some(rest) = data.strip_prefix(b"\xEF\xBB\xBF") {
        return Some((String::from_utf8_lossy(rest).into_owned(), "utf-8"));
    }
    if let Some(rest) = data.strip_prefix(b"\xFF\xFE") {
        return Some((utf16(rest, u16::from_le_bytes), "utf-16-le"));
    }
    data.strip_prefix(b"\xFE\xFF").map(|rest| (utf16(rest, u16::from_be_bytes), "utf-16-be"))
}

/// Returns UTF-16 as text; unpaired surrogates and an odd last byte become U+FFFD.
pub(super) fn utf16(data: &[u8], unit: fn([u8; 2]) -> u16) -> String {
    let (units, rest) = data.as_chunks::<2>();
    let decoded = char::decode_utf16(units.iter().map(|bytes| unit(*bytes)));
    let odd = rest.iter().map(|_| char::REPLACEMENT_CHARACTER);
    decoded.map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).chain(odd).collect()
}

/// Returns the text of an XML document, whose declaration names its encoding; else the line and the problem.
pub(super) fn document(data: &[u8]) -> Result<String, (usize, &'static str)> {
    if let Some((text, _)) = marked(data) {
        return Ok(text);
    }
    if data.starts_with(b"<\0") {
        return Ok(utf16(data, u16::from_le_bytes));
    }
    let encoding = match declared(data) {
        None => UTF_8,
        Some(label) => Encoding::for_label(label).ok_or((1, "unknown encoding"))?,
    };
    if encoding == UTF_8 {
        let text = std::str::from_utf8(data).map(str::to_owned);
        return text.map_err(|error| (line_at(data, error.valid_up_to()), "not well-formed (invalid token)"));
    }
    let text = encoding.decode_without_bom_handling_and_without_replacement(data);
    let text = text.filter(|_| encoding.is_ascii_compatible()).map(std::borrow::Cow::into_owned);
    text.ok_or((1, "encoding specified in XML declaration is incorrect"))
}

/// Returns the name of the encoding in an XML declaration.
fn declared(data: &[u8]) -> Option<&[u8]> {
    let inside = data.trim_ascii_start().strip_prefix(b"<?xml")?;
    let end = inside.windows(2).position(|pair| pair == b"?>")?;
    let inside = inside.get(..end)?;
    let key = b"encoding";
    let at = inside.windows(key.len()).position(|word| word == key)? + key.len();
    let value = inside.get(at..)?.trim_ascii_start().strip_prefix(b"=")?.trim_ascii_start();
    let (quote, value) = value.split_first()?;
    value.split(|byte| byte == quote).next()
}

/// Returns GB18030 as text if the bytes from 80h come in pairs that are common Chinese characters.
fn chinese(data: &[u8]) -> Option<String> {
    if !is_gb18030(data) {
        return None;
    }
    let text = GB18030.decode_without_bom_handling_and_without_replacement(data)?;
    let (mut pairs, mut strangers, mut at) = (0, 0, 0);
    let is_letter = |at: Option<usize>| at.and_then(|at| data.get(at)).is_some_and(u8::is_ascii_alphabetic);
    for run in data.chunk_by(|one, next| one.is_ascii() == next.is_ascii()) {
        let (start, end) = (at, at + run.len());
        at = end;
        if run.first().is_none_or(u8::is_ascii) {
            continue;
        }
        // Two letters of Latin, as in "ção", make a pair too, but inside a word.
        let within_word = run.len() == 2 && (is_letter(start.checked_sub(1)) || is_letter(Some(end)));
        if run.len() % 2 == 1 || within_word {
            strangers += 1;
        } else {
            pairs += common(run);
        }
    }
    (pairs > strangers).then(|| text.into_owned())
}

/// Returns true if the bytes have the form of GB18030. A lone 80h, which decoders take for a euro sign, has not.
fn is_gb18030(data: &[u8]) -> bool {
    let mut at = 0;
    while let Some(byte) = data.get(at) {
        at += match byte {
            0..=0x7F => 1,
            0x80 | 0xFF => return false,
            _ if data.get(at + 1).is_some_and(u8::is_ascii_digit) => 4,
            _ => 2,
        };
    }
    true
}

/// Returns the number of pairs in a run that are of the first level of GB 2312, which most of any text is, or its signs.
fn common(run: &[u8]) -> usize {
    let (mut count, mut rest) = (0, run);
    while let [first, after @ ..] = rest {
        rest = match after {
            [0xA1..=0xFE, behind @ ..] if matches!(first, 0xA1 | 0xA3 | 0xB0..=0xD7) => {
                count += 1;
                behind
            }
            _ => after,
        };
    }
    count
}

/// Returns the text in the code page of Europe that makes the most sense of it.
fn european(data: &[u8]) -> (String, &'static str) {
    let lines = data.split(|byte| matches!(byte, b'\n' | b'\r')).filter(|line| !line.is_ascii());
    let mut telling = lines.collect::<Vec<_>>().join(&b'\n');
    telling.truncate(JUDGED);
    let page = |table: &str, data: &[u8]| -> Vec<char> {
        let upper: Vec<char> = table.chars().collect();
        let character = |byte: u8| byte.checked_sub(0x80).and_then(|place| upper.get(usize::from(place)).copied());
        data.iter().map(|byte| character(*byte).unwrap_or(char::from(*byte))).collect()
    };
    let best = SINGLE.iter().rev().max_by_key(|(_, table)| sense(&page(table, &telling)));
    let (encoding, table) = best.copied().unwrap_or_default();
    (page(table, data).into_iter().collect(), encoding)
}

/// Returns how much the letters beyond ASCII look like words of a European language.
fn sense(text: &[char]) -> i64 {
    let around = |place: Option<usize>| place.and_then(|place| text.get(place)).copied();
    let judged = text.iter().enumerate().filter(|(_, c)| !c.is_ascii()).map(|(place, c)| {
        let (before, after) = (around(place.checked_sub(1)), around(Some(place + 1)));
        if c.is_alphabetic() && !"ªºµƒ".contains(*c) { letter(*c, before, after) } else { sign(*c, before, after) }
    });
    judged.sum()
}

fn is_letter(c: Option<char>) -> bool {
    c.is_some_and(char::is_alphabetic)
}

fn letter(c: char, before: Option<char>, after: Option<char>) -> i64 {
    // Greek is in units, such as 10 kΩ.
    if matches!(c, '\u{370}'..='\u{3FF}') {
        let fits = !is_letter(after) && before.is_none_or(|before| "kM 0123456789".contains(before));
        return if fits { 2 } else { -2 };
    }
    let behind_digit = before.is_some_and(|before| before.is_ascii_digit() || "¹²³".contains(before));
    let alone = !is_letter(before) && !is_letter(after);
    let mixed = c.is_uppercase() && before.is_some_and(char::is_lowercase)
        || c.is_lowercase() && after.is_some_and(char::is_uppercase);
    if behind_digit || alone || mixed {
        return -2;
    }
    if c.to_lowercase().all(|c| LETTERS.contains(c)) { 3 } else { 1 }
}

fn sign(c: char, before: Option<char>, after: Option<char>) -> i64 {
    match c {
        '°' => {
            if is_letter(before) {
                -1
            } else {
                3
            }
        }
        'µ' => {
            if !is_letter(before) && after.is_some_and(|after| "smAVFHg".contains(after)) {
                3
            } else {
                1
            }
        }
        _ if SIGNS.contains(c) && (!(is_letter(before) && is_letter(after)) || matches!(c, '’' | '·')) => 1,
        _ => -2,
    }
}

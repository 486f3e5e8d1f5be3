//! Text around the rows of a listing: quotation marks, row numbers, and marks for omitted rows.
//!
//! Both text readers need it, and so does the one in Python. A mark of omission is a separate line: an ellipsis, a word
//! for cutting, or a number of rows with such a word. A line with any other word is a comment, since a false gap
//! suspends verdicts although nothing is missing.

use super::candump::lex::{is_blank, is_hex, skip_blanks};
use super::{FilePlace, Item, Marker};
use crate::bytes::frame::{Buses, Direction};

/// A line that marks omitted rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Omission {
    /// The number of rows, if given.
    pub count: Option<u64>,
}

/// Maximum length of a mark, in bytes.
const LONGEST: usize = 80;

/// Returns the text without quotation marks, `> ` or `> > `.
pub fn unquoted(mut text: &[u8]) -> &[u8] {
    while let [b'>', rest @ ..] = text {
        if !rest.first().is_none_or(|&byte| is_blank(byte) || byte == b'>') {
            break;
        }
        text = skip_blanks(rest);
    }
    text
}

/// Returns the text without surrounding mark-up: back-ticks, bars of a table, tags.
pub fn unmarked(mut text: &[u8]) -> &[u8] {
    loop {
        text = skip_blanks(text).trim_ascii_end();
        text = match text {
            [b'`' | b'|', rest @ ..] | [rest @ .., b'`' | b'|'] => rest,
            [b'<', rest @ ..] if let Some(end) = tag(rest) => rest.get(end + 1..).unwrap_or_default(),
            [rest @ .., b'>']
                if let Some(begin) = rest.iter().rposition(|&byte| byte == b'<')
                    && tag(text.get(begin + 1..).unwrap_or_default()).is_some() =>
            {
                rest.get(..begin).unwrap_or_default()
            }
            _ => return text,
        };
    }
}

/// Returns the end of the tag that begins before this text: `pre>`, `/code>`, `br/>`, `span class="x">`.
fn tag(text: &[u8]) -> Option<usize> {
    let name = text.strip_prefix(b"/").unwrap_or(text);
    let end = text.iter().position(|&byte| matches!(byte, b'<' | b'>'))?;
    let is_tag = name.first().is_some_and(u8::is_ascii_alphabetic) && text.get(end) == Some(&b'>');
    is_tag.then_some(end)
}

/// Returns true if the line begins like a comment, including an arrow, so that its content is not recorded.
pub fn is_comment(text: &[u8]) -> bool {
    matches!(
        text,
        [b'#' | b';' | b'%' | 0x80.., ..] | [b'/', b'/' | b'*', ..] | [b'-' | b'<', b'-', ..] | [b'-' | b'=', b'>', ..]
    )
}

/// Returns true if a line has bytes that no text has: a block of zeros, a piece of another file. Tabs, carriage returns
/// and escapes of colours are text.
pub fn is_damaged(line: &[u8]) -> bool {
    let odd = |byte: u8| byte < b' ' && !matches!(byte, b'\t' | b'\r' | 0x1B) || byte == 0x7F;
    line.iter().fold(false, |found, &byte| found | odd(byte))
}

/// Returns the part of a line before the first such byte; `None` without one.
pub fn undamaged(line: &[u8]) -> Option<&[u8]> {
    let damaged = is_damaged(line);
    let end = line.iter().position(|byte| damaged && is_damaged(std::slice::from_ref(byte)))?;
    line.get(..end)
}

/// The form of a row's bytes, if visible.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Digits {
    /// Two digits, as hexadecimal bytes always have, with a letter or a leading zero.
    Hexadecimal,
    /// A byte of three digits, and none as above.
    Decimal,
    /// A byte of a single digit, and none as above: decimal, or damaged.
    Single,
}

/// Words for the direction of a frame, seen from the host, in lower case.
const DIRECTIONS: &[(Direction, &[&str])] = &[
    (
        Direction::Tx,
        &["tx", "txrq", "send", "sending", "sent", "transmit", "transmitted", "senden", "gesendet", "发送", "发送帧"],
    ),
    (Direction::Rx, &["rx", "recv", "receive", "receiving", "received", "empfangen", "empfang", "接收", "接收帧"]),
];

/// Returns the direction that a word names, in capital or small letters.
pub fn direction(word: &[u8]) -> Option<Direction> {
    let is = |known: &&str| word.eq_ignore_ascii_case(known.as_bytes());
    DIRECTIONS.iter().find(|(_, names)| names.iter().any(is)).map(|(way, _)| *way)
}

/// Returns the form that the words for bytes show together.
pub fn digits<'a>(bytes: impl Iterator<Item = &'a [u8]>) -> Option<Digits> {
    let mut found = None;
    for byte in bytes {
        match byte {
            [high, low] if is_hex(byte) && (*high == b'0' || !(high.is_ascii_digit() && low.is_ascii_digit())) => {
                return Some(Digits::Hexadecimal);
            }
            [b'1' | b'2', _, _] if byte.iter().all(u8::is_ascii_digit) => found = Some(Digits::Decimal),
            [b'0'..=b'9'] if found.is_none() => found = Some(Digits::Single),
            _ => {}
        }
    }
    found
}

/// The decision on decimal rows in a file.
#[derive(Clone, Copy, Debug, Default)]
pub struct Base {
    single: u8,
}

impl Base {
    /// Adds a row; returns true for decimal, false for hexadecimal, `None` while unknown.
    pub fn take(&mut self, row: Digits) -> Option<bool> {
        const SURE: u8 = 3;
        self.single += u8::from(row == Digits::Single);
        match row {
            Digits::Hexadecimal => Some(false),
            Digits::Single if self.single < SURE => None,
            Digits::Decimal | Digits::Single => Some(true),
        }
    }
}

/// Returns the text after the bullet of a list, `- ` or `* `.
pub fn item(text: &[u8]) -> Option<&[u8]> {
    match text {
        [b'-' | b'*' | b'+', rest @ ..] => Some(skip_blanks(rest)).filter(|after| after.len() < rest.len()),
        _ => None,
    }
}

/// Parses a row number `14)`, `14.`, `14:` or `[14]` before a blank; returns it with the text after it, and true if it
/// has no mark.
pub fn numbered(text: &[u8]) -> Option<(u64, &[u8], bool)> {
    let (inner, bracket) = match text {
        [b'[', rest @ ..] => (rest, true),
        _ => (text, false),
    };
    let end = inner.iter().position(|byte| !byte.is_ascii_digit()).unwrap_or(inner.len());
    let (digits, rest) = inner.split_at_checked(end)?;
    let number = std::str::from_utf8(digits).ok().filter(|digits| digits.len() <= 12)?.parse().ok()?;
    let (rest, bare) = match rest {
        [b']', rest @ ..] if bracket => (rest, false),
        _ if bracket => return None,
        [b')' | b'.' | b':', rest @ ..] => (rest, false),
        _ => (rest, true),
    };
    let after = skip_blanks(rest);
    (after.len() < rest.len() && !after.is_empty()).then_some((number, after, bare))
}

/// Parses a line of text as a mark of omission.
pub fn omission(line: &[u8]) -> Option<Omission> {
    let line = unquoted(line.trim_ascii());
    if line.is_empty() || line.len() > LONGEST {
        return None;
    }
    let text = std::str::from_utf8(line).ok()?;
    if matches!(text, "." | "\u{22EE}" | "\u{FE19}") {
        return Some(Omission { count: None }); // a vertical ellipsis
    }
    let scissors = ["8<", ">8", "%<", ">%"].iter().any(|mark| text.contains(mark));
    if scissors && text.chars().all(|char| matches!(char, '-' | ' ' | '8' | '%' | '<' | '>')) {
        return Some(Omission { count: None });
    }
    let inner = text.trim_matches(is_decoration);
    let dots = text.matches('.').count() >= 3 || text.contains('\u{2026}');
    if inner.is_empty() {
        let only_dots = text.chars().all(|char| !matches!(char, '/' | '#' | ';') && is_decoration(char));
        return (dots && only_dots).then_some(Omission { count: None });
    }
    in_english(inner, text, dots).or_else(|| in_chinese(inner))
}

fn is_decoration(char: char) -> bool {
    matches!(
        char,
        '.' | '\u{2026}' | '-' | '_' | '*' | '=' | '~' | '<' | '>' | '(' | ')' | '[' | ']' | '{' | '}' | '#' | '/'
    ) || matches!(char, ';' | ' ' | '\t' | '\u{FF08}' | '\u{FF09}' | '\u{3010}' | '\u{3011}' | '\u{3002}' | '\u{2014}')
}

/// Parses `25 frames omitted`, `snip`, `... 25 more lines ...`: every word has to be in the lists. `whole`: the text
/// with its decoration; `dots`: it has an ellipsis.
fn in_english(text: &str, whole: &str, dots: bool) -> Option<Omission> {
    const CUTS: &[&str] = &[
        "dropped",
        "omitted",
        "omit",
        "skipped",
        "skip",
        "snip",
        "snipped",
        "snippet",
        "cut",
        "removed",
        "deleted",
        "missing",
        "lost",
        "truncated",
        "elided",
        "hidden",
        "left",
        "shortened",
        "shown",
        "gap",
    ];
    const ROWS: &[&str] = &[
        "frame", "frames", "message", "messages", "line", "lines", "row", "rows", "packet", "packets", "record",
        "records", "entry", "entries",
    ];
    const OTHER: &[&str] = &[
        "can", "other", "some", "many", "several", "are", "were", "was", "is", "of", "the", "here", "not", "out", "a",
        "few", "and", "so", "these", "such", "similar", "same", "times", "log", "output", "trace", "listing",
    ];
    // Words for continuing without being shown.
    const ON: &[&str] =
        &["more", "on", "etc", "until", "till", "continues", "continued", "repeat", "repeats", "repeated", "repeating"];
    let (mut count, mut cuts, mut rows, mut on, mut words) = (None, 0, 0, false, 0);
    for word in text.split([' ', '\t', ',']).filter(|word| !word.is_empty()) {
        let word = word.trim_matches(is_decoration).to_ascii_lowercase();
        let is = |list: &[&str]| list.contains(&word.as_str());
        words += 1;
        match word.parse::<u64>() {
            Ok(number) if count.is_none() => count = Some(number),
            Ok(_) => return None,
            Err(_) if is(CUTS) => cuts += 1,
            Err(_) if is(ROWS) => rows += 1,
            Err(_) if is(ON) => on = true,
            Err(_) if is(OTHER) || word.is_empty() => {}
            Err(_) => return None,
        }
    }
    let decorated = dots || !whole.starts_with(char::is_alphanumeric);
    let enclosed = dots || whole.starts_with(['[', '(', '<', '{', '-', '*', '=', '~']);
    let count = count.filter(|count| *count > 0);
    let said = match (cuts, rows) {
        (1.., 1..) => true,
        (1.., 0) => decorated && words <= 3 || matches!(text, "snip" | "SNIP" | "omitted" | "snipped"),
        (0, 1..) => on && (enclosed || count.is_some()) || dots && count.is_some(),
        _ => on && enclosed,
    };
    // Without a word for rows the number counts something else.
    (said && words <= 8).then_some(Omission { count: count.filter(|_| cuts + rows > 0) })
}

/// Parses `省略25帧`, `中间略`: composed of listed pieces, one of them a word for omitting.
fn in_chinese(text: &str) -> Option<Omission> {
    const CUTS: &[&str] = &["省略", "略去", "略", "丢失", "丢弃", "丢", "删节", "删去", "删除", "跳过"];
    const OTHER: &[&str] = &[
        "中间", "此处", "这里", "以下", "以上", "其余", "其他", "后面", "前面", "部分", "下面", "若干", "中", "后",
        "前", "下", "上", "共", "帧", "条", "行", "个", "报文", "消息", "数据", "记录", "了", "已", "被", "的", "CAN",
        " ", "\u{2026}", ".", ",", "\u{FF0C}",
    ];
    let (mut rest, mut cuts, mut count) = (text, 0, None);
    while !rest.is_empty() {
        let digits = rest.find(|char: char| !char.is_ascii_digit()).unwrap_or(rest.len());
        if let (1.., Some((number, after))) = (digits, rest.split_at_checked(digits)) {
            if count.is_some() {
                return None;
            }
            count = Some(number.parse::<u64>().ok()?);
            rest = after;
            continue;
        }
        let piece = |list: &[&str]| list.iter().find_map(|piece| rest.strip_prefix(piece));
        rest = match piece(CUTS) {
            Some(after) => {
                cuts += 1;
                after
            }
            None => piece(OTHER)?,
        };
    }
    (cuts > 0).then_some(Omission { count: count.filter(|count| *count > 0) })
}

/// Places where a file itself shows omitted rows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LeftOut {
    /// Number of places.
    pub places: u64,
    /// Number of places without a number of rows.
    pub uncounted: u64,
    /// Number of rows at the other places.
    pub rows: u64,
}

impl LeftOut {
    /// Adds a place and its number of rows, if known.
    pub fn add(&mut self, rows: Option<u64>) {
        self.places += 1;
        self.uncounted += u64::from(rows.is_none());
        self.rows = self.rows.saturating_add(rows.unwrap_or(0));
    }
}

/// The signs of missing rows in a listing, until the next row completes them.
#[derive(Clone, Debug, Default)]
pub(super) struct Gaps {
    /// The last row number.
    last: Option<u64>,
    /// A mark of omission since the last row, and its place.
    marked: Option<(Omission, FilePlace)>,
}

impl Gaps {
    /// Adds a mark of omission; several in a row are one.
    pub(super) fn mark(&mut self, omission: Omission, place: FilePlace) {
        let (known, _) = self.marked.get_or_insert((omission, place));
        known.count = known.count.or(omission.count);
    }

    /// Processes a row without a number, reporting an omission before it.
    #[inline(always)]
    pub(super) fn row(&mut self, buses: &Buses, sink: &mut impl FnMut(Item, &Buses)) {
        if self.marked.is_some() {
            self.settle(buses, sink);
        }
    }

    /// Processes a row whose number cannot be read: it is the next one.
    pub(super) fn uncounted(&mut self, buses: &Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.last = self.last.and_then(|last| last.checked_add(1));
        self.settle(buses, sink);
    }

    /// Processes a row with this number. A number that is not greater than the last one starts anew.
    pub(super) fn numbered(
        &mut self,
        number: u64,
        place: FilePlace,
        buses: &Buses,
        sink: &mut impl FnMut(Item, &Buses),
    ) {
        let last = self.last.replace(number);
        match last.and_then(|last| Some((last, number.checked_sub(last)?.checked_sub(1)?))) {
            Some((last, missing @ 1..)) => {
                self.marked = None;
                let rows = Some((last, number));
                sink(Item::Marker(Marker::LeftOut { count: Some(missing), rows, place }), buses);
            }
            _ => self.settle(buses, sink),
        }
    }

    /// Reports a mark that no row follows.
    pub(super) fn settle(&mut self, buses: &Buses, sink: &mut impl FnMut(Item, &Buses)) {
        if let Some((Omission { count }, place)) = self.marked.take() {
            sink(Item::Marker(Marker::LeftOut { count, rows: None, place }), buses);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Omission, numbered, omission, unmarked, unquoted};

    #[test]
    fn marks_of_omission() {
        for (line, count) in [
            ("...", None),
            ("  ... ", None),
            ("....", None),
            ("\u{2026}", None),
            ("[...]", None),
            ("(\u{2026})", None),
            (". . .", None),
            (".", None),
            ("\u{22EE}", None),
            ("> ...", None),
            ("* ... *", None),
            ("<snip>", None),
            ("-- snip --", None),
            ("[SNIP]", None),
            ("snip", None),
            ("--- 8< ---", None),
            ("----->8-----", None),
            ("[cut]", None),
            ("<truncated>", None),
            ("(12 frames dropped)", Some(12)),
            ("12 frames omitted", Some(12)),
            ("1 line skipped", Some(1)),
            ("... 25 frames ...", Some(25)),
            ("... 25 more lines ...", Some(25)),
            ("[25 more messages]", Some(25)),
            ("... 25 frames left out ...", Some(25)),
            ("# 7 CAN frames lost", Some(7)),
            ("(some lines were removed here)", None),
            ("[many more of these]", None),
            ("<more frames>", None),
            ("... until ...", None),
            ("... and so on", None),
            ("... (repeats 100 times)", None),
            ("[gap]", None),
            ("<log truncated>", None),
            ("*** output truncated ***", None),
            ("... (omitted) ...", None),
            ("省略", None),
            ("(略)", None),
            ("……", None),
            ("（中间省略25帧）", Some(25)),
            ("以下略", None),
            ("... 省略 25 条报文 ...", Some(25)),
            ("丢失3帧", Some(3)),
            ("【此处省略若干行】", None),
        ] {
            assert_eq!(omission(line.as_bytes()), Some(Omission { count }), "{line}");
        }
    }

    #[test]
    fn comments_and_frames_are_none() {
        for line in [
            "",
            "-----",
            "---",
            "# ",
            "//",
            "..",
            "->",
            "(254)",
            "5",
            "12 frames",
            "... and then the node is silent",
            "no frames were lost",
            "nothing dropped",
            "all 12 frames of the node are shown here, none is missing",
            "the frame is dropped by the node",
            "cut",
            "lost",
            "# more frames",
            "more frames",
            "until",
            "(the same)",
            "the log",
            "gap",
            "--- 5 seconds later ---",
            "// 5 of 7",
            "can0  601   [8]  40 18 10 01 00 00 00 00",
            "601#4018100100000000",
            "DROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 5)",
            "省电模式",
            "战略",
            "没有丢失",
        ] {
            assert_eq!(omission(line.as_bytes()), None, "{line}");
        }
    }

    #[test]
    fn mark_up() {
        for text in
            ["`601#40`", "| 601#40 |", "<p>601#40</p>", "<pre><code class=\"x\">601#40", "601#40<br/>", "601#40"]
        {
            assert_eq!(unmarked(text.as_bytes()), b"601#40", "{text}");
        }
        for text in ["<---- 601#40", "-> 601#40", "# 601#40", "601#40 <- here", "a > b", "1 < 2"] {
            assert_eq!(unmarked(text.as_bytes()), text.as_bytes());
        }
    }

    #[test]
    fn rows_and_quotations() {
        assert_eq!(unquoted(b"> > can0"), b"can0");
        assert_eq!(unquoted(b">> can0"), b"can0");
        assert_eq!(unquoted(b">can0"), b">can0");
        assert_eq!(numbered(b"14) can0"), Some((14, &b"can0"[..], false)));
        assert_eq!(numbered(b"[14]  601"), Some((14, &b"601"[..], false)));
        assert_eq!(numbered(b"14: 601"), Some((14, &b"601"[..], false)));
        assert_eq!(numbered(b"14 601"), Some((14, &b"601"[..], true)));
        for text in [&b"14"[..], b"14) ", b"14)x", b"[14 x", b"(14) x", b"14,5 x", b"0.123 x", b"1234567890123 x"] {
            assert_eq!(numbered(text), None, "{}", String::from_utf8_lossy(text));
        }
    }
}

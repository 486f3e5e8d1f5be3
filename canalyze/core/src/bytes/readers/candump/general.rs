//! Any line of candump text: the words before a frame, what is no frame, and why.
//!
//! A line is classified by its content alone. Must not: know the lines before it.

use memchr::{memchr, memchr3};

use super::lex::{Fail, is_blank, is_hex, is_name, skip_blanks, word};
use super::{console, log, stamp};
use crate::bytes::frame::{Buses, CanId, Direction, Frame, Stamp, StampForm};
use crate::bytes::readers::Unreadable;
use crate::bytes::readers::listing::{self, Omission};

/// The content of a line.
#[derive(Debug)]
pub(super) struct Line<'a> {
    pub(super) stamp: Option<Stamp>,
    /// True if its stamp may be a difference; the compact family never prints differences.
    pub(super) console: bool,
    /// The interface; empty if there is none.
    pub(super) bus: &'a [u8],
    /// The number of the row, if any.
    pub(super) row: Option<u64>,
    pub(super) what: LineContent,
    /// The frame, if any, without line, stamp and time.
    pub(super) frame: Frame,
    /// The text after the frame.
    pub(super) tail: &'a [u8],
}

impl<'a> Line<'a> {
    /// Takes the result of parsing a frame; `Ok` is the text after it.
    fn made(&mut self, frame: Result<&'a [u8], Fail>) -> LineContent {
        match frame {
            Ok(tail) => {
                self.tail = tail;
                LineContent::Frame
            }
            Err(fail) => LineContent::Unreadable(fail),
        }
    }

    /// Returns true if it was meant as a frame or a marker of candump.
    pub(super) fn is_meant(&self) -> bool {
        match self.what {
            LineContent::Frame | LineContent::Dropped { .. } | LineContent::Error => true,
            LineContent::Unreadable(fail) => fail.reason != Unreadable::NoFrame || self.stamp.is_some(),
            LineContent::Nothing | LineContent::LeftOut(_) => false,
        }
    }
}

#[derive(Clone, Copy, Debug)]
pub(super) enum LineContent {
    /// Blank, a comment, a prompt.
    Nothing,
    Frame,
    Dropped {
        count: u64,
        total: u64,
    },
    Error,
    /// Rows left out here.
    LeftOut(Omission),
    Unreadable(Fail),
}

/// Parses any line, already without colours. `rows`: a bare number before a frame is a row number.
pub(super) fn general(text: &[u8], rows: bool) -> Line<'_> {
    let text = skip_blanks(text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text)).trim_ascii_end();
    let whole = text;
    let unquoted = listing::unquoted(text);
    let text = listing::unmarked(unquoted);
    if text.len() < unquoted.len() {
        let line = general(text, rows);
        // Mark-up around anything else is part of it.
        if line.is_meant() || matches!(line.what, LineContent::LeftOut(_)) {
            return line;
        }
    }
    let text = unquoted;
    if let Some((number, rest, bare)) = listing::numbered(text) {
        let line = unnumbered(rest);
        // `1  601   [8] ...` may also have an interface named by a number.
        if line.is_meant() && (!bare || rows || line.stamp.is_some() || !line.bus.is_empty()) {
            return Line { row: Some(number), ..line };
        }
    }
    if let Some(item) = listing::item(text)
        && let line @ Line { what: LineContent::Frame, .. } = unnumbered(listing::unmarked(item))
    {
        return line;
    }
    let mut line = unnumbered(text);
    if let LineContent::Nothing | LineContent::Unreadable(Fail { reason: Unreadable::NoFrame, .. }) = line.what {
        match listing::omission(text) {
            Some(omission) => (line.stamp, line.what) = (None, LineContent::LeftOut(omission)),
            // A quotation without a frame is prose.
            None if text.len() < whole.len() && line.stamp.is_none() && !holds_frame(text) => {
                line.what = LineContent::Nothing
            }
            None if matches!(line.what, LineContent::Nothing) && !listing::is_comment(text) && holds_frame(text) => {
                line.what = LineContent::Unreadable(Fail { reason: Unreadable::NoFrame, end: false });
            }
            None => {}
        }
    }
    line
}

/// Parses a line after its number.
pub(super) fn unnumbered(text: &[u8]) -> Line<'_> {
    let frame = Frame::classic(CanId::standard(0), &[]);
    let mut line =
        Line { stamp: None, console: false, bus: b"", row: None, what: LineContent::Nothing, frame, tail: b"" };
    let Some(first) = text.first() else { return line };
    let rest = match stamp::read(text) {
        Some((stamp, rest)) if rest.first().is_none_or(|&byte| is_blank(byte)) => {
            line.stamp = Some(stamp);
            skip_blanks(rest)
        }
        _ if first.is_ascii_alphanumeric() => text,
        _ => {
            line.what = without_frame(text);
            return line;
        }
    };
    if line.stamp.is_none()
        && let Some((stamp, rest)) = stamp::bare(text)
    {
        let mut stamped = Line { stamp: Some(stamp), what: LineContent::Nothing, ..line };
        if let what @ LineContent::Frame = words(skip_blanks(rest), &mut stamped) {
            return Line { what, ..stamped };
        }
    }
    if let Some(dropped) = rest.strip_prefix(b"DROPCOUNT: ") {
        (line.bus, line.what) = drops(dropped);
        return line;
    }
    line.what = words(rest, &mut line);
    if let LineContent::Unreadable(Fail { reason: Unreadable::NoFrame, .. }) = line.what {
        let comment = match line.stamp {
            // (254) and the text after it.
            Some(stamp) => stamp.form == StampForm::Seconds && stamp.decimals == 0,
            None => is_prompt(text),
        };
        if comment {
            (line.stamp, line.what) = (None, LineContent::Nothing);
        }
    }
    line
}

/// Returns true if a frame follows other words of the line, none of them a command: it is neither a valid frame nor a
/// comment.
pub(super) fn holds_frame(text: &[u8]) -> bool {
    const WORDS: usize = 16;
    let mut rest = text;
    for _ in 0..WORDS {
        let (first, after) = word(rest);
        let mut frame = Frame::classic(CanId::standard(0), &[]);
        let console = console::is_meant(rest) && console::frame(rest, &mut frame).is_ok();
        if TOOLS.contains(&first) {
            return false;
        }
        if console || log::is_meant(first) && log::frame(first, b"", &mut frame).is_ok() {
            return true;
        }
        rest = skip_blanks(after);
        if rest.is_empty() {
            break;
        }
    }
    false
}

/// The words in place of an interface, in the lines at the beginning of a file.
#[derive(Debug, Default)]
pub(super) struct Numbers {
    last: u64,
    count: u64,
    /// True if any is not an increasing number.
    other: bool,
}

impl Numbers {
    pub(super) fn take(&mut self, line: &Line<'_>) {
        if !line.console || !matches!(line.what, LineContent::Frame) {
            return;
        }
        let number = std::str::from_utf8(line.bus).ok().and_then(|name| name.parse().ok());
        self.other |= number.is_none_or(|number| self.count > 0 && number <= self.last);
        self.last = number.unwrap_or(0);
        self.count += 1;
    }

    /// Returns true if they are row numbers, since no bus has another name on each line.
    pub(super) fn are_rows(&self) -> bool {
        self.count >= 3 && !self.other
    }
}

/// Parses the words after the stamp: interface and frame, or frame alone, in either family.
fn words<'a>(text: &'a [u8], line: &mut Line<'a>) -> LineContent {
    let (first, after) = word(text);
    if log::is_meant(first) {
        let frame = log::frame(first, after, &mut line.frame);
        return line.made(frame);
    }
    let rest = skip_blanks(after);
    let (second, after) = word(rest);
    if log::is_meant(second) && is_name(first) {
        let frame = log::frame(second, after, &mut line.frame);
        let what = line.made(frame);
        match console::way(first) {
            Some(way) => _ = line.frame.dir.get_or_insert(way),
            None => line.bus = interface(first),
        }
        return what;
    }
    if console::is_meant(text) {
        line.console = true;
        let frame = console::frame(text, &mut line.frame);
        return line.made(frame);
    }
    let stamped = line.stamp.is_some();
    if is_label(first) && console::is_meant(rest) {
        line.console = true;
        let frame = console::frame(rest, &mut line.frame);
        return line.made(frame);
    }
    if rest.is_empty() || !is_name(first) {
        line.console = stamped;
        return LineContent::Unreadable(Fail { reason: Unreadable::NoFrame, end: rest.is_empty() && stamped });
    }
    line.console = true;
    if second == b"ERROR" && after.is_empty() && (stamped || first.iter().any(u8::is_ascii_digit)) {
        line.bus = interface(first);
        return LineContent::Error;
    }
    let frame = console::frame(rest, &mut line.frame);
    let mut what = line.made(frame);
    match &mut what {
        LineContent::Frame => match said(first) {
            Some(way) => line.frame.dir = line.frame.dir.or(way),
            None => line.bus = interface(first),
        },
        // Two words of prose are not a cut frame: a stamp, a direction or a numbered interface is required.
        LineContent::Unreadable(fail) => fail.end &= stamped || first.iter().any(u8::is_ascii_digit),
        _ => {}
    }
    what
}

/// Returns the interface that a word names: colons behind a name are no part of it.
fn interface(word: &[u8]) -> &[u8] {
    let end = word.iter().rposition(|byte| *byte != b':').map_or(word.len(), |end| end + 1);
    word.get(..end).unwrap_or(word)
}

/// Words before a frame that say what it is, beside those for its direction; no interface has such a name.
const KINDS: [&str; 12] = [
    "request",
    "response",
    "answer",
    "reply",
    "client",
    "server",
    "master",
    "slave",
    "sdo",
    "pdo",
    "emcy",
    "heartbeat",
];

/// Returns the direction, if any, in a word that says what a frame is; `None` for other words.
fn said(word: &[u8]) -> Option<Option<Direction>> {
    let end = word.iter().rposition(|byte| byte.is_ascii_alphanumeric()).map_or(0, |end| end + 1);
    let word = word.get(..end)?.to_ascii_lowercase();
    match word.as_slice() {
        b"t" | b"out" => Some(Some(Direction::Tx)),
        b"r" | b"in" => Some(Some(Direction::Rx)),
        _ if KINDS.iter().any(|kind| kind.as_bytes() == word) => Some(None),
        _ => listing::direction(&word).map(Some),
    }
}

/// Returns true for a word before an identifier that labels the column and is not an interface.
fn is_label(word: &[u8]) -> bool {
    let word = word.strip_suffix(b":").unwrap_or(word);
    [&b"id"[..], b"cob-id", b"cobid", b"can-id"].iter().any(|label| word.eq_ignore_ascii_case(label))
}

/// Classifies a line that begins with neither a stamp nor a letter nor a digit.
fn without_frame(text: &[u8]) -> LineContent {
    if is_clock(text) {
        return LineContent::Unreadable(Fail { reason: Unreadable::NoFrame, end: false });
    }
    if stamp::is_meant(text) {
        return LineContent::Unreadable(Fail { reason: Unreadable::NoFrame, end: memchr(b')', text).is_none() });
    }
    let mark = match text.first() {
        Some(first) if first.is_ascii() => first.is_ascii_punctuation(),
        // An arrow or a bullet begins a comment; a letter of another script is prose, like a Latin one.
        _ => first_char(text).is_some_and(|char| !char.is_alphanumeric() && !char.is_control()),
    };
    if mark { LineContent::Nothing } else { LineContent::Unreadable(Fail { reason: Unreadable::NoFrame, end: false }) }
}

/// Returns true for `[12:34:56.789] ...`, a time of other loggers: the text after it is meant but never candump's.
fn is_clock(text: &[u8]) -> bool {
    let Some(inner) = text.strip_prefix(b"[") else { return false };
    let digits = inner.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let behind = inner.get(digits..).unwrap_or_default();
    digits > 0 && matches!(behind, [b':' | b'.' | b'-', digit, ..] if digit.is_ascii_digit())
}

fn first_char(text: &[u8]) -> Option<char> {
    (2..=4).find_map(|len| std::str::from_utf8(text.get(..len)?).ok()?.chars().next())
}

/// Parses `dropped 3 CAN frames on 'can0' socket (total drops 5)`, where the name may include candump's filters.
fn drops(text: &[u8]) -> (&[u8], LineContent) {
    let read = || {
        let (count, rest) = number(text.strip_prefix(b"dropped ")?)?;
        let rest = rest.strip_prefix(b" CAN frame")?;
        let rest = rest.strip_prefix(b"s").unwrap_or(rest).strip_prefix(b" on '")?;
        let end = memchr(b'\'', rest)?;
        let name = rest.get(..end)?.split(|&byte| byte == b',').next()?;
        let rest = rest.get(end..)?.strip_prefix(b"' socket (total drops ")?;
        let (total, rest) = number(rest)?;
        rest.starts_with(b")").then_some((name, LineContent::Dropped { count, total }))
    };
    read().unwrap_or((b"", LineContent::Unreadable(Fail { reason: Unreadable::NoFrame, end: false })))
}

fn number(text: &[u8]) -> Option<(u64, &[u8])> {
    let end = text.iter().position(|byte| !byte.is_ascii_digit()).unwrap_or(text.len());
    let (digits, rest) = text.split_at_checked(end)?;
    Some((std::str::from_utf8(digits).ok()?.parse().ok()?, rest))
}

/// Commands whose arguments are not recorded frames.
const TOOLS: [&[u8]; 7] = [b"candump", b"cansend", b"cangen", b"canplayer", b"cansniffer", b"canopend", b"sudo"];

/// Returns true for a command line of a shell, pasted together with its output.
fn is_prompt(text: &[u8]) -> bool {
    let (first, rest) = word(text);
    // user@host:~$ candump can0, and with a blank before the dollar
    let at = memchr(b'@', first).is_some();
    let mark = |word: &[u8]| matches!(word.last(), Some(b'$' | b'#' | b'%' | b'>'));
    let command = TOOLS.contains(&first) && !rest.is_empty();
    command || at && (mark(first) || mark(word(skip_blanks(rest)).0)) || first.ends_with(b"$") && !rest.is_empty()
}

/// Returns true if the line is the beginning of a known interface name.
pub(super) fn is_begun_name(text: &[u8], buses: &Buses) -> bool {
    let text = text.trim_ascii();
    !text.is_empty() && buses.names().any(|name| name.starts_with(text)) && !is_hex(text)
}

/// Returns the line without ANSI escapes (`-c`), and with plain blanks instead of those of web pages.
#[inline]
pub(super) fn plain_text<'a>(text: &'a [u8], room: &'a mut Vec<u8>) -> &'a [u8] {
    const ESC: u8 = 0x1B;
    if memchr3(ESC, 0xC2, 0xE2, text).is_none() {
        return text;
    }
    room.clear();
    let mut rest = text;
    while let Some(at) = memchr3(ESC, 0xC2, 0xE2, rest) {
        room.extend_from_slice(rest.get(..at).unwrap_or_default());
        rest = rest.get(at..).unwrap_or_default();
        // ESC [ parameters letter; any other ESC is removed by itself.
        if let [ESC, b'[', sequence @ ..] = rest {
            let end = sequence.iter().position(|byte| !matches!(byte, b'0'..=b'?' | b' '..=b'/'));
            rest = sequence.get(end.map_or(sequence.len(), |end| end + 1)..).unwrap_or_default();
            continue;
        }
        let (kept, after) = match rest {
            [ESC, after @ ..] => (&b""[..], after),
            // U+00A0, U+2000 to U+200A and U+202F have a width; U+200B to U+200F have none.
            [0xC2, 0xA0, after @ ..] | [0xE2, 0x80, 0x80..=0x8A | 0xAF, after @ ..] => (&b" "[..], after),
            [0xE2, 0x80, 0x8B..=0x8F, after @ ..] => (&b""[..], after),
            _ => rest.split_at_checked(1).unwrap_or((rest, &[])),
        };
        room.extend_from_slice(kept);
        rest = after;
    }
    room.extend_from_slice(rest);
    room
}

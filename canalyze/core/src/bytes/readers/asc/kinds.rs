//! Kinds of events that are not frames, by the word that names them.
//!
//! A line with a time that is none of these is reported as unreadable; otherwise, frames of a program with other
//! columns would be missed silently.

use super::words::{self, LineWords};

/// Kinds with a direction or a single word, in lower case.
const BARE: &[&[u8]] = &[b"j1939tp", b"overloadframe", b"txrq", b"li"];
/// Kinds with more words, up to a colon, in lower case.
const KNOWN: &[&[u8]] = &[
    b"a429",
    b"ad",
    b"afdx",
    b"can",
    b"comment",
    b"diag",
    b"end",
    b"eth",
    b"ethernet",
    b"ethernetstatus",
    b"fr",
    b"gps",
    b"isotp",
    b"j1587",
    b"j1708",
    b"log",
    b"most",
    b"n2k",
    b"signal",
    b"start",
    b"statistic",
    b"status",
    b"stop",
    b"sv",
    b"sys",
    b"tfs",
    b"tp",
    b"trigger",
    b"watermark",
    b"wlan",
];
/// Maximum length of a compared word.
const LONGEST: usize = 16;

/// Returns the name under which an event is counted, by its first word and the words after it; `None` for an unknown
/// kind. `last`: the file may be cut after it.
pub(super) fn of<'a>(word: &'a [u8], behind: LineWords<'_>, last: bool) -> Option<&'a [u8]> {
    let name = word.split(|&byte| byte == b':').next().filter(|name| !name.is_empty()).unwrap_or(word);
    let lower = name.get(..name.len().min(LONGEST)).unwrap_or(name).to_ascii_lowercase();
    let is = |kinds: &[&[u8]]| kinds.contains(&lower.as_slice());
    // An environment variable has its own name: `Lamp := 1`.
    let variable = matches!(behind.peek(), b":=");
    // A global marker: `GMR_Group: name`.
    let marker = lower.starts_with(b"gm");
    if lower == b"can" && !is_status(behind) {
        return None; // a row of a trace window, `CAN 1  601  Rx ...`
    }
    // LIN with its channel: `L1 3C Rx 8 ...`.
    let lin = matches!(lower.as_slice(), [b'l', b'1'..=b'9']);
    if is(BARE) || lin {
        return Some(word);
    }
    if !(is(KNOWN) || variable || marker) || is_meant_as_frame(behind) || last && behind.is_empty() {
        return None;
    }
    Some(match lower.as_slice() {
        // `CAN 1 Status:`
        b"can" => b"CAN Status",
        b"start" => b"Start of measurement",
        _ if variable => b"environment variable",
        _ => word,
    })
}

/// Returns true if `1 Status:chip status error active` follows.
fn is_status(mut words: LineWords<'_>) -> bool {
    words.next().is_some_and(|channel| channel.iter().all(u8::is_ascii_digit))
        && words.peek().get(..6).is_some_and(|word| word.eq_ignore_ascii_case(b"status"))
}

/// Returns true if the line contains a direction and the letter of a data or remote frame.
fn is_meant_as_frame(mut words: LineWords<'_>) -> bool {
    let mut before = false;
    while let Some(word) = words.next() {
        if before && matches!(word, b"d" | b"r") {
            return true;
        }
        before = words::way(word).is_some();
    }
    false
}

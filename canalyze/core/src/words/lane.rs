//! The lanes of a timeline in few words: a state, a transfer, the errors of a node.
//!
//! The facts are the same as in the lines of the frames. The content of a lane is not decided here.

use super::digits::{Hex, put};
use super::transferred;
use super::value::Size;
use super::{Lang, terms};
use crate::sdo::transfer::{Direction, Status, Transfer};
use crate::wire::emcy;
use crate::wire::error_control;
use crate::wire::message::Errors;
use crate::words::profiles::Profile;
use crate::world::od::{self, Value};
use terms::{Row, find};

/// Maximum number of characters of a value.
const VALUE: usize = 40;
/// Maximum number of bytes of a value that is neither a number nor text; of a longer one only their count is shown.
const BYTES: usize = 8;

/// Words for a node beside the names of the NMT states.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Word {
    /// The master commanded the state; the node has not shown it.
    Commanded,
    /// The node was commanded to reset, and has not booted again.
    Reset,
    /// Its heartbeats have stopped.
    HeartbeatLost,
    /// It leaves the master's requests unanswered.
    GuardingLost,
    /// Frames are missing from the capture.
    Gap,
    /// No frame was seen on the bus.
    Silence,
    /// All nodes were commanded, and it may be the one that did.
    All,
    /// It sends PDOs after its boot-up, and its state is not known.
    Sends,
}

static WORDS: &[Row<Word>] = words!("lane_states");

static OUTCOMES: &[Row<&str>] = words!("lane_transfers");

/// Appends the name of an NMT state (00, 04, 05, 7F) with a remark: `操作状态 (已命令)`. Other states are shown by number.
pub fn state(out: &mut Vec<u8>, lang: Lang, state: u8, how: Option<Word>) {
    match error_control::state(lang, state) {
        Some(name) => put!(out; name),
        None => put!(out; Hex::<2>(u64::from(state)), "h"),
    }
    if let Some(how) = how {
        put!(out; " (");
        word(out, lang, how);
        put!(out; ")");
    }
}

/// Appends a word.
pub fn word(out: &mut Vec<u8>, lang: Lang, word: Word) {
    put!(out; find(WORDS, lang, word).unwrap_or_default());
}

/// Appends the errors of a node: `8130h 寿命保护错误或心跳错误 + 3210h 直流母线过压`.
pub fn errors(out: &mut Vec<u8>, lang: Lang, profile: Profile, errors: Errors) {
    for (place, code) in errors.iter().enumerate() {
        put!(out; if place > 0 { " + " } else { "" }, Hex::<4>(u64::from(code)), "h");
        if let Some(name) = emcy::code(lang, profile, code) {
            put!(out; " ", name);
        }
    }
}

/// Appends a transfer that has ended, its object first: `1008h:00 读 "Zephyr"`, `1601h:00 写: 中止 06010002h`. Without
/// `valued` no value is written.
pub fn transfer(out: &mut Vec<u8>, lang: Lang, transfer: &Transfer, valued: bool) {
    let said = |key| find(OUTCOMES, lang, key).unwrap_or_default();
    match transfer.mux {
        Some(mux) => put!(out; mux),
        None => put!(out; said("object unknown")),
    }
    put!(out; " ", said(if transfer.direction == Direction::Upload { "read" } else { "write" }));
    match (transfer.outcome.status, transfer.outcome.abort) {
        (Status::Ok, _) if valued => {
            put!(out; " ");
            moved(out, lang, transfer);
        }
        (Status::Ok, _) => {}
        (Status::Aborted, Some(abort)) => put!(out; ": ", said("abort"), " ", abort.code, "h"),
        (Status::Aborted, None) => put!(out; ": ", said("abort")),
        (Status::Failed, _) => put!(out; ": ", said("failed")),
        (Status::Open | Status::Incomplete, _) => put!(out; ": ", said("incomplete")),
    }
}

/// Appends the value, cut if it is long; for long binary data the number of bytes.
fn moved(out: &mut Vec<u8>, lang: Lang, transfer: &Transfer) {
    let data_type = transfer.data_type();
    if transfer.data.size > BYTES as u64 && matches!(od::decode(data_type, &transfer.data.kept), Value::Bytes(_)) {
        return put!(out; Size(lang, transfer.data.size));
    }
    let mut whole = Vec::new();
    transferred::transferred(&mut whole, lang, transfer);
    let text = String::from_utf8_lossy(&whole);
    match text.char_indices().nth(VALUE) {
        Some((end, _)) => put!(out; text.get(..end).unwrap_or(&text), "..."),
        None => put!(out; &*text),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;
    use crate::words::lang::tests::sound;

    #[test]
    fn complete_and_sorted() {
        sound(WORDS);
        sound(OUTCOMES);
    }

    #[test]
    fn states() {
        for (code, how, zh, en) in [
            (0x05, None, "操作状态", "Operational"),
            (0x7F, Some(Word::Commanded), "预操作状态 (已命令)", "Pre-operational (commanded)"),
            (0x00, None, "启动(Boot-up)", "Pre-operational (boot-up)"),
            (0x2A, None, "2Ah", "2Ah"),
        ] {
            for (lang, expected) in [(Lang::Zh, zh), (Lang::En, en)] {
                let mut out = Vec::new();
                state(&mut out, lang, code, how);
                assert_eq!(String::from_utf8(out).unwrap(), expected);
            }
        }
    }
}

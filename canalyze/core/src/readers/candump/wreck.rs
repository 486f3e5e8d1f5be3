//! What is damage, where a line would else pass as a comment, or as a whole frame with a remark behind it.
//!
//! A comment is what people write: control bytes, the wreck of a stamp and a second frame behind the first are none.
//! The end of a file may cut a frame to a shorter one that looks whole: what frames before it show tells. Must not:
//! repair anything.

use memchr::{memchr, memchr_iter};

use super::lex::{is_blank, skip_blanks, word};
use super::{What, general, holds_frame, plain_text, stamp, unnumbered};
use crate::frame::{Buses, Frame, Kind};
use crate::readers::{Unreadable, listing};

/// Whether a line without a frame is what damage has left of one.
#[cold]
pub(super) fn is_comment_damaged(text: &[u8], buses: &Buses) -> bool {
    if listing::is_damaged(text) {
        return true;
    }
    let [first, rest @ ..] = skip_blanks(text) else { return false };
    if !first.is_ascii_punctuation() && first.is_ascii() {
        return false;
    }
    // `;1700000000.035555) can0 ...`: the mark stands where the parenthesis was.
    if stamp::is_closed(rest) && holds_frame(rest) {
        return true;
    }
    // `(17\xE3...`: no byte of a stamp, and none of a text.
    if *first == b'(' && rest.first().is_some_and(u8::is_ascii_digit) && std::str::from_utf8(rest).is_err() {
        return true;
    }
    // `#an0  601  [1]  40`, where `can0` is known.
    let (name, behind) = word(rest);
    let known = |known: &[u8]| known.split_first().is_some_and(|(_, rest)| rest == name);
    !name.is_empty() && buses.names().any(known) && is_frame(skip_blanks(behind))
}

/// Whether what follows a frame is no remark: control bytes, or the next line, whose newline was changed.
#[inline(never)]
pub(super) fn is_tail_damaged(tail: &[u8]) -> bool {
    if tail.iter().all(|&byte| is_blank(byte)) {
        return false;
    }
    if listing::is_damaged(tail) {
        return true;
    }
    let apart = tail.first().is_some_and(|&byte| is_blank(byte)) && std::str::from_utf8(tail).is_ok();
    if apart && listing::is_comment(skip_blanks(tail)) {
        return false;
    }
    // A stamp, and what it belongs to.
    let behind = |at: usize| tail.get(at..).unwrap_or_default();
    let stamped = |at: usize| {
        let line = unnumbered(behind(at));
        let meant = match line.what {
            What::Unreadable(fail) => fail.reason != Unreadable::NoFrame,
            _ => line.is_meant(),
        };
        meant && line.stamp.is_some_and(|stamp| stamp.decimals > 0)
    };
    if memchr_iter(b'(', tail).any(stamped) {
        return true;
    }
    // A whole line without a stamp, behind the one byte that was its newline.
    match tail {
        [first, rest @ ..] if !is_blank(*first) => is_frame(skip_blanks(rest)),
        _ => false,
    }
}

fn is_frame(text: &[u8]) -> bool {
    matches!(unnumbered(text).what, What::Frame)
}

/// The end of what was read, for what it shows of how long frames are and of whether their direction is told. Nothing is
/// looked at while there are further lines.
#[derive(Debug, Default)]
pub(super) struct Behind {
    bytes: Vec<u8>,
}

/// How much is looked back at.
const REACH: usize = 64 * 1024;

impl Behind {
    /// Takes the next bytes of the file.
    pub(super) fn feed(&mut self, bytes: &[u8]) {
        if bytes.len() >= REACH {
            self.bytes.clear();
        } else if self.bytes.len() + bytes.len() > 2 * REACH {
            let kept = REACH - bytes.len();
            self.bytes.drain(..self.bytes.len().saturating_sub(kept));
        }
        self.bytes.extend_from_slice(last(bytes));
    }

    /// Whether a frame at the end of the file, with neither newline nor remark behind it, may be the beginning of another
    /// one. `text`: its line; `console`: in the form that tells the length first.
    #[cold]
    pub(super) fn may_go_on(&self, frame: &Frame, text: &[u8], console: bool) -> bool {
        let (known, directed) = self.shown(frame, text);
        if console {
            // `[0]`, behind which `remote request` may have stood.
            let at_length = text.trim_ascii_end().ends_with(b"]");
            return at_length && frame.kind == Kind::Data && !known;
        }
        let last = text.rsplit(|&byte| is_blank(byte)).next().unwrap_or_default();
        let at_digits = super::log::is_meant(last) && last.iter().all(|byte| byte.is_ascii_graphic());
        directed && frame.dir.is_none() || at_digits && super::log::may_go_on(frame) && !known
    }

    /// Whether other frames of its identifier are as long as this one and none is longer, and whether the line before it
    /// ends with a direction.
    fn shown(&self, frame: &Frame, text: &[u8]) -> (bool, bool) {
        let bytes = last(&self.bytes);
        let before = bytes.get(..bytes.len().saturating_sub(text.len())).unwrap_or_default();
        // The first of them may have lost its beginning.
        let whole =
            if before.len() + text.len() < REACH { 0 } else { memchr(b'\n', before).map_or(REACH, |at| at + 1) };
        let (mut longest, mut directed, mut plain) = (None, false, Vec::new());
        for line in before.get(whole..).unwrap_or_default().split(|&byte| byte == b'\n') {
            let line = general(plain_text(line, &mut plain), false);
            if let What::Frame = line.what {
                if line.frame.id == frame.id {
                    longest = longest.max(Some(line.frame.len));
                }
                if !line.console {
                    directed = line.frame.dir.is_some();
                }
            }
        }
        (longest == Some(frame.len), directed)
    }
}

/// The last bytes, as far as is looked back.
fn last(bytes: &[u8]) -> &[u8] {
    bytes.get(bytes.len().saturating_sub(REACH)..).unwrap_or(bytes)
}

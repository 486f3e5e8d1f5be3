//! Detection of damaged lines that would otherwise pass as a comment, or as a complete frame with a remark.
//!
//! People do not write comments with control bytes, the remains of a stamp, or a second frame after the first. The end
//! of a file may cut a frame to a shorter one that looks complete; earlier frames show that. Nothing is repaired.

use memchr::{memchr, memchr_iter};

use super::general::{LineContent, general, holds_frame, plain_text, unnumbered};
use super::lex::{is_blank, is_hex, skip_blanks, word};
use super::stamp;
use crate::bytes::frame::{Buses, Frame, Kind};
use crate::bytes::readers::{Unreadable, listing};

/// Returns true if a line without a frame is the damaged remainder of one.
#[cold]
pub(super) fn is_comment_damaged(text: &[u8], buses: &Buses) -> bool {
    if listing::is_damaged(text) {
        return true;
    }
    let [first, rest @ ..] = skip_blanks(text) else { return false };
    if !first.is_ascii_punctuation() && first.is_ascii() {
        return false;
    }
    // `;1700000000.035555) can0 ...`: the mark replaces the parenthesis.
    if stamp::is_closed(rest) && holds_frame(rest) {
        return true;
    }
    // `(17\xE3...`: not a byte of a stamp, nor of a text.
    if *first == b'(' && rest.first().is_some_and(u8::is_ascii_digit) && std::str::from_utf8(rest).is_err() {
        return true;
    }
    // `(17000000086#FF`: as many digits as in a stamp.
    if *first == b'(' && rest.iter().take_while(|byte| byte.is_ascii_digit()).count() >= STAMP {
        return true;
    }
    // `#an0  601  [1]  40`, while `can0` is known.
    let (name, behind) = word(rest);
    let known = |known: &[u8]| known.split_first().is_some_and(|(_, rest)| rest == name);
    !name.is_empty() && buses.names().any(known) && is_frame(skip_blanks(behind))
}

/// Returns true if the text after a frame is not a remark: control bytes, or the next line after a damaged newline.
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
    // A stamp and its line.
    let behind = |at: usize| tail.get(at..).unwrap_or_default();
    let stamped = |at: usize| {
        let line = unnumbered(behind(at));
        let meant = match line.what {
            LineContent::Unreadable(fail) => fail.reason != Unreadable::NoFrame,
            _ => line.is_meant(),
        };
        meant && line.stamp.is_some_and(|stamp| stamp.decimals > 0)
    };
    if memchr_iter(b'(', tail).any(stamped) {
        return true;
    }
    // A complete line without a stamp, after the byte that was its newline.
    match tail {
        [first, rest @ ..] if !is_blank(*first) => is_frame(skip_blanks(rest)),
        _ => false,
    }
}

fn is_frame(text: &[u8]) -> bool {
    matches!(unnumbered(text).what, LineContent::Frame)
}

/// The end of the bytes so far, which shows the usual length of frames and the presence of directions. It is not
/// examined while lines follow.
#[derive(Debug, Default)]
pub(super) struct Behind {
    bytes: Vec<u8>,
}

/// Least number of digits that only a stamp has.
const STAMP: usize = 8;

/// Number of bytes that are examined.
const REACH: usize = 64 * 1024;

impl Behind {
    /// Adds the next bytes of the file.
    pub(super) fn feed(&mut self, bytes: &[u8]) {
        if bytes.len() >= REACH {
            self.bytes.clear();
        } else if self.bytes.len() + bytes.len() > 2 * REACH {
            let kept = REACH - bytes.len();
            self.bytes.drain(..self.bytes.len().saturating_sub(kept));
        }
        self.bytes.extend_from_slice(last(bytes));
    }

    /// Returns true if a frame at the end of the file, without a newline or remark, may be the beginning of another
    /// one. `text`: its line; `console`: in the form with the length first.
    #[cold]
    pub(super) fn may_go_on(&self, frame: &Frame, text: &[u8], console: bool) -> bool {
        let (known, directed) = self.shown(frame, text);
        if console {
            // `[0]`, which `remote request` may have followed.
            let at_length = text.trim_ascii_end().ends_with(b"]");
            return at_length && frame.kind == Kind::Data && !known;
        }
        // Blanks may separate the bytes.
        let mut words = text.rsplit(|&byte| is_blank(byte));
        let last = words.find(|word| word.len() != 2 || !is_hex(word)).unwrap_or_default();
        let at_digits = super::log::is_meant(last) && last.iter().all(|byte| byte.is_ascii_graphic());
        directed && frame.dir.is_none() || at_digits && super::log::may_go_on(frame) && !known
    }

    /// Returns true if other frames of its identifier have the same length and none is longer, and true if the line
    /// before it ends with a direction.
    fn shown(&self, frame: &Frame, text: &[u8]) -> (bool, bool) {
        let bytes = last(&self.bytes);
        let before = bytes.get(..bytes.len().saturating_sub(text.len())).unwrap_or_default();
        // The first one may have lost its beginning.
        let whole =
            if before.len() + text.len() < REACH { 0 } else { memchr(b'\n', before).map_or(REACH, |at| at + 1) };
        let (mut longest, mut directed, mut plain) = (None, false, Vec::new());
        for line in before.get(whole..).unwrap_or_default().split(|&byte| byte == b'\n') {
            let line = general(plain_text(line, &mut plain), false);
            if let LineContent::Frame = line.what {
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

/// Returns the last bytes, up to [`REACH`].
fn last(bytes: &[u8]) -> &[u8] {
    bytes.get(bytes.len().saturating_sub(REACH)..).unwrap_or(bytes)
}

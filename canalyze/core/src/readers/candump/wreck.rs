//! What is damage, where a line would else pass as a comment, or as a whole frame with a remark behind it.
//!
//! A comment is what people write: control bytes, the wreck of a stamp and a second frame behind the first are none.
//! The end of a file may cut a frame to a shorter one that looks whole: what frames before it show tells. Must not:
//! repair anything.

use memchr::memchr_iter;

use super::lex::{is_blank, skip_blanks, word};
use super::{What, holds_frame, stamp, unnumbered};
use crate::frame::{Buses, CanId, Frame, Kind};
use crate::readers::{Unreadable, listing};

/// Whether a line without a frame is what damage has left of one.
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

/// Whether what stands behind a frame is no remark: control bytes, or the next line, whose newline was changed.
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

/// What the lines of a file show of how long its frames are, and of whether their direction is told.
#[derive(Debug)]
pub(super) struct Shown {
    /// The longest frame of an identifier, by a part of the identifier: identifier and length.
    longest: Vec<(u32, u8)>,
    /// The line before ended with a direction.
    pub(super) directed: bool,
}

const SLOTS: usize = 1024;

impl Default for Shown {
    fn default() -> Self {
        Self { longest: vec![(u32::MAX, 0); SLOTS], directed: false }
    }
}

impl Shown {
    fn slot(id: CanId) -> (usize, u32) {
        let key = id.raw() | u32::from(id.is_extended()) << 31;
        ((key ^ key >> 10) as usize % SLOTS, key)
    }

    /// Takes a frame.
    #[inline(always)]
    pub(super) fn take(&mut self, frame: &Frame) {
        let (slot, key) = Self::slot(frame.id);
        if let Some((known, len)) = self.longest.get_mut(slot) {
            *len = if *known == key { frame.len.max(*len) } else { frame.len };
            *known = key;
        }
    }

    /// Whether other frames of the identifier were as long as this one, and none was longer.
    fn is_known(&self, frame: &Frame) -> bool {
        let (slot, key) = Self::slot(frame.id);
        self.longest.get(slot) == Some(&(key, frame.len))
    }

    /// Whether a frame at the end of the file, with neither newline nor remark behind it, may be the beginning of another
    /// one. `text`: its line; `console`: in the form that tells the length first.
    pub(super) fn may_go_on(&self, frame: &Frame, text: &[u8], console: bool) -> bool {
        if console {
            // `[0]`, behind which `remote request` may have stood.
            let at_length = text.trim_ascii_end().ends_with(b"]");
            return at_length && frame.kind == Kind::Data && !self.is_known(frame);
        }
        let last = text.rsplit(|&byte| is_blank(byte)).next().unwrap_or_default();
        let at_digits = super::log::is_meant(last) && last.iter().all(|byte| byte.is_ascii_graphic());
        self.directed && frame.dir.is_none() || at_digits && super::log::may_go_on(frame) && !self.is_known(frame)
    }
}

//! Text in pieces, cut into lines. Memory is bounded: nothing is kept of a line that is too long.

use memchr::memchr;

/// Maximum length of a line in bytes, ten times that of a CAN XL frame with 2048 bytes.
pub(super) const MAX_LINE: usize = 64 * 1024;

/// The unfinished line of a text.
#[derive(Debug, Default)]
pub(super) struct Begun {
    line: Vec<u8>,
    /// True while the rest of a line that is too long is skipped.
    skipping: bool,
}

impl Begun {
    /// Calls `take` with each line that these bytes complete, without its newline, and once with `None` for a line that
    /// is too long.
    #[inline(always)]
    pub(super) fn cut(&mut self, bytes: &[u8], take: &mut impl FnMut(Option<&[u8]>)) {
        let mut rest = self.complete(bytes, take);
        while let Some((line, behind)) = first(rest) {
            take(line);
            rest = behind;
        }
        self.keep(rest, take);
    }

    /// Does so with the line that is unfinished, and returns the bytes behind it.
    pub(super) fn complete<'a>(&mut self, bytes: &'a [u8], take: &mut impl FnMut(Option<&[u8]>)) -> &'a [u8] {
        if !self.skipping && self.line.is_empty() {
            return bytes;
        }
        let Some(end) = memchr(b'\n', bytes) else {
            self.keep(bytes, take);
            return &[];
        };
        let (piece, rest) = bytes.split_at_checked(end).unwrap_or((bytes, &[]));
        self.keep(piece, take);
        if !std::mem::take(&mut self.skipping) {
            take(checked(&self.line));
        }
        self.line.clear();
        rest.get(1..).unwrap_or_default()
    }

    /// Keeps a piece of a line. An empty one does not begin a line, so that the result does not depend on the pieces.
    pub(super) fn keep(&mut self, piece: &[u8], take: &mut impl FnMut(Option<&[u8]>)) {
        if self.skipping || piece.is_empty() {
            return;
        }
        if self.line.len() + piece.len() > MAX_LINE {
            self.line.clear();
            self.skipping = true;
            take(None);
        } else {
            self.line.extend_from_slice(piece);
        }
    }

    /// Ends the text and returns the last line without a newline; empty for none.
    pub(super) fn end(&mut self) -> Vec<u8> {
        self.skipping = false;
        std::mem::take(&mut self.line)
    }

    /// Returns the current capacity of the buffer in bytes.
    #[cfg(test)]
    pub(super) fn capacity(&self) -> usize {
        self.line.capacity()
    }
}

/// Returns the first line of a text without its newline (`None` for one that is too long) and the text behind it, if its
/// newline is there.
#[inline(always)]
pub(super) fn first(text: &[u8]) -> Option<(Option<&[u8]>, &[u8])> {
    let (line, rest) = text.split_at_checked(memchr(b'\n', text)?)?;
    Some((checked(line), rest.get(1..).unwrap_or_default()))
}

#[inline(always)]
fn checked(line: &[u8]) -> Option<&[u8]> {
    Some(line).filter(|line| line.len() <= MAX_LINE)
}

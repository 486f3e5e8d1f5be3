//! The bytes of a text, in any pieces, cut into its lines.
//!
//! Must not: read what a line says. Memory is bounded: of a line that is too long nothing is kept.

use memchr::memchr;

/// The longest line, in bytes; a longer one is none of a capture: a CAN XL frame of 2048 bytes takes a tenth of it.
pub(super) const MAX_LINE: usize = 64 * 1024;

/// What of a text has no end of a line yet.
#[derive(Debug, Default)]
pub(super) struct Begun {
    line: Vec<u8>,
    /// Whether the rest of the line is thrown away: it was too long.
    skipping: bool,
}

impl Begun {
    /// Hands on each line that these bytes complete, without its newline; `None`, once, for one that is too long.
    #[inline(always)]
    pub(super) fn cut(&mut self, mut bytes: &[u8], take: &mut impl FnMut(Option<&[u8]>)) {
        if self.skipping || !self.line.is_empty() {
            let Some(end) = memchr(b'\n', bytes) else { return self.keep(bytes, take) };
            let (piece, rest) = bytes.split_at_checked(end).unwrap_or((bytes, &[]));
            self.keep(piece, take);
            if !std::mem::take(&mut self.skipping) {
                hand(&self.line, take);
            }
            self.line.clear();
            bytes = rest.get(1..).unwrap_or_default();
        }
        while let Some(end) = memchr(b'\n', bytes) {
            let (line, rest) = bytes.split_at_checked(end).unwrap_or((bytes, &[]));
            hand(line, take);
            bytes = rest.get(1..).unwrap_or_default();
        }
        self.keep(bytes, take);
    }

    /// Keeps a piece of a line. An empty one is none: it must not depend on the pieces whether a line was begun.
    fn keep(&mut self, piece: &[u8], take: &mut impl FnMut(Option<&[u8]>)) {
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

    /// The text is over: gives the last line, which had no newline; empty for none.
    pub(super) fn end(&mut self) -> Vec<u8> {
        self.skipping = false;
        std::mem::take(&mut self.line)
    }

    /// Bytes that are held at most, as it stands.
    #[cfg(test)]
    pub(super) fn capacity(&self) -> usize {
        self.line.capacity()
    }
}

#[inline(always)]
fn hand(line: &[u8], take: &mut impl FnMut(Option<&[u8]>)) {
    take((line.len() <= MAX_LINE).then_some(line));
}

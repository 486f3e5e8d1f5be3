//! Little-endian numbers and counted texts, as in records of MCAP, and the encodings of messages. Nothing here panics
//! or allocates.

/// The encoding of messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wire {
    /// Little-endian without padding.
    Ros1,
    /// Aligned, in either byte order, which the first four bytes give.
    Cdr,
}

/// The rest of a record.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bytes<'a>(pub(super) &'a [u8]);

impl<'a> Bytes<'a> {
    /// Takes the next `count` bytes, or none if there are fewer.
    #[inline(always)]
    pub(super) fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (head, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(head)
    }

    #[inline(always)]
    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (head, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*head)
    }

    #[inline(always)]
    pub(super) fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    #[inline(always)]
    pub(super) fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    #[inline(always)]
    pub(super) fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    /// Takes a text or byte array after its 32-bit length.
    #[inline(always)]
    pub(super) fn counted(&mut self) -> Option<&'a [u8]> {
        let mut rest = *self;
        let count = rest.u32()?;
        let text = rest.take(usize::try_from(count).ok()?)?;
        *self = rest;
        Some(text)
    }
}

//! Little-endian numbers and counted texts, as MCAP's records are made of them, and how messages in them are encoded. Nothing here may panic or allocate.

/// How messages are encoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wire {
    /// Without padding, little-endian.
    Ros1,
    /// Aligned, of either byte order, with four bytes before it that say which.
    Cdr,
}

/// What is left of a record.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bytes<'a>(pub(super) &'a [u8]);

impl<'a> Bytes<'a> {
    /// The next `count` bytes; nothing is taken where there are fewer.
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

    /// A text or byte array with its length before it in 32 bits.
    #[inline(always)]
    pub(super) fn counted(&mut self) -> Option<&'a [u8]> {
        let mut rest = *self;
        let count = rest.u32()?;
        let text = rest.take(usize::try_from(count).ok()?)?;
        *self = rest;
        Some(text)
    }
}

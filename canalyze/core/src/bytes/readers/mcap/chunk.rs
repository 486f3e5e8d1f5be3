//! Chunks, which are decompressed and checked before their content is used.
//!
//! Claimed lengths allocate no memory in advance: data that decompress to more than [`EARNED`] times their size are
//! decompressed piece by piece, up to [`MAX_UNPACKED`].

use std::io::Read;

use super::bytes::Bytes;
use crate::bytes::readers::DamageKind;

/// Maximum decompressed size of a chunk, in bytes (256 MiB).
pub(super) const MAX_UNPACKED: u64 = 256 << 20;
/// Maximum ratio of the decompressed size to the bytes received for which memory is allocated at once.
const EARNED: u64 = 64;
/// Maximum length of the name of a compression; known ones have four letters at most.
const MAX_NAME: usize = 14;

/// The head of a chunk before its records.
#[derive(Clone, Copy, Debug)]
pub(super) struct Head {
    pub(super) start_ns: u64,
    pub(super) end_ns: u64,
    /// Decompressed size in bytes.
    pub(super) unpacked: u64,
    /// CRC-32 of the decompressed data; 0 for none.
    pub(super) crc: u32,
    /// The compression; `None` if unknown.
    pub(super) packing: Option<Packing>,
    /// Size of this head in bytes.
    pub(super) size: usize,
    /// Size of the compressed records in bytes.
    pub(super) len: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Packing {
    None,
    Zstd,
    Lz4,
}

impl Packing {
    /// All compressions: name in a chunk, name for people.
    pub(super) const ALL: [(&'static [u8], &'static str, Packing); 3] =
        [(b"", "none", Packing::None), (b"zstd", "zstd", Packing::Zstd), (b"lz4", "lz4", Packing::Lz4)];
}

/// Parses a head; `None` if it is incomplete or the name is too long.
pub(super) fn head(body: &[u8]) -> Option<Head> {
    let mut rest = Bytes(body);
    let (start_ns, end_ns, unpacked, crc) = (rest.u64()?, rest.u64()?, rest.u64()?, rest.u32()?);
    let name = rest.counted().filter(|name| name.len() <= MAX_NAME)?;
    let len = rest.u64()?;
    let packing = Packing::ALL.iter().find(|(word, ..)| *word == name).map(|(.., packing)| *packing);
    Some(Head { start_ns, end_ns, unpacked, crc, packing, size: body.len() - rest.0.len(), len })
}

impl Head {
    /// Returns true if its values are possible.
    pub(super) fn is_sound(&self) -> bool {
        let fits = self.packing != Some(Packing::None) || self.unpacked == self.len;
        self.packing.is_some() && self.start_ns <= self.end_ns && self.unpacked <= MAX_UNPACKED && fits
    }
}

/// A decompressor that reuses its memory.
#[derive(Default)]
pub(super) struct Unpacker {
    zstd: Option<zstd::bulk::Decompressor<'static>>,
    room: Vec<u8>,
}

impl std::fmt::Debug for Unpacker {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Unpacker {{ room: {} }}", self.room.capacity())
    }
}

impl Unpacker {
    /// Returns the checked records of a whole chunk, or the kind of damage.
    pub(super) fn unpack<'a>(&'a mut self, head: &Head, packed: &'a [u8]) -> Result<&'a [u8], DamageKind> {
        let packing = head.packing.ok_or(DamageKind::Compression)?;
        if head.unpacked > MAX_UNPACKED {
            return Err(DamageKind::Structure);
        }
        let records = if packing == Packing::None {
            packed
        } else {
            if !self.bulk(packing, head.unpacked, packed) && !self.stream(packing, head.unpacked, packed) {
                return Err(DamageKind::Compression);
            }
            &self.room
        };
        if head.crc != 0 && crc32fast::hash(records) != head.crc {
            return Err(DamageKind::Checksum);
        }
        if records.len() as u64 != head.unpacked {
            return Err(DamageKind::Structure);
        }
        Ok(records)
    }

    /// Returns the decompressible beginning of an incomplete chunk, unchecked.
    pub(super) fn rescue<'a>(&'a mut self, head: &Head, packed: &'a [u8]) -> &'a [u8] {
        match head.packing {
            None => &[],
            Some(Packing::None) => packed,
            Some(packing) => {
                self.stream(packing, head.unpacked.min(MAX_UNPACKED), packed);
                &self.room
            }
        }
    }

    /// Decompresses at once if the size is in proportion; returns false if it did not.
    fn bulk(&mut self, packing: Packing, unpacked: u64, packed: &[u8]) -> bool {
        let earned = unpacked <= EARNED.saturating_mul(packed.len() as u64);
        if packing != Packing::Zstd || !earned {
            return false;
        }
        if self.zstd.is_none() {
            self.zstd = zstd::bulk::Decompressor::new().ok();
        }
        let Some(zstd) = &mut self.zstd else { return false };
        self.room.clear();
        self.room.reserve_exact(unpacked as usize);
        zstd.decompress_to_buffer(packed, &mut self.room).is_ok()
    }

    /// Decompresses in steps, keeping the data before a fault; returns true without a fault.
    fn stream(&mut self, packing: Packing, unpacked: u64, packed: &[u8]) -> bool {
        self.room.clear();
        // One byte beyond the claimed size shows that there is more.
        let most = unpacked + 1;
        match packing {
            Packing::Zstd => zstd::stream::read::Decoder::with_buffer(packed)
                .is_ok_and(|decoder| pour(decoder.take(most), &mut self.room)),
            Packing::Lz4 => pour(lz4_flex::frame::FrameDecoder::new(packed).take(most), &mut self.room),
            Packing::None => false,
        }
    }
}

/// Reads everything; returns true without a fault.
fn pour(mut from: impl Read, to: &mut Vec<u8>) -> bool {
    from.read_to_end(to).is_ok()
}

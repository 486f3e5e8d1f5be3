//! Chunks: unpacked, and checked before anything of them is believed.
//!
//! Claimed lengths allocate nothing that has not been earned: what unpacks to more than [`EARNED`] times its size is
//! unpacked piece by piece, and nothing beyond [`MAX_UNPACKED`]. Must not: know what records are in a chunk.

use std::io::Read;

use super::bytes::Bytes;
use crate::readers::DamageKind;

/// Most that a chunk unpacks to (256 MiB).
pub(super) const MAX_UNPACKED: u64 = 256 << 20;
/// Memory for so many times the bytes that have arrived is taken at once.
const EARNED: u64 = 64;
/// The longest name of a compression; no known one is longer than four letters.
const MAX_NAME: usize = 14;

/// What a chunk says of itself before its records.
#[derive(Clone, Copy, Debug)]
pub(super) struct Head {
    pub(super) start_ns: u64,
    pub(super) end_ns: u64,
    /// Bytes when unpacked.
    pub(super) unpacked: u64,
    /// CRC-32 of what is unpacked; 0 for none.
    pub(super) crc: u32,
    /// `None`: one that is not known.
    pub(super) packing: Option<Packing>,
    /// Bytes of this head.
    pub(super) size: usize,
    /// Bytes of records, packed.
    pub(super) len: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Packing {
    None,
    Zstd,
    Lz4,
}

impl Packing {
    /// All, with their names in a chunk and the ones for people.
    pub(super) const ALL: [(&'static [u8], &'static str, Packing); 3] =
        [(b"", "none", Packing::None), (b"zstd", "zstd", Packing::Zstd), (b"lz4", "lz4", Packing::Lz4)];
}

/// Reads it; `None` where it is not all there, or a name is longer than any.
pub(super) fn head(body: &[u8]) -> Option<Head> {
    let mut rest = Bytes(body);
    let (start_ns, end_ns, unpacked, crc) = (rest.u64()?, rest.u64()?, rest.u64()?, rest.u32()?);
    let name = rest.counted().filter(|name| name.len() <= MAX_NAME)?;
    let len = rest.u64()?;
    let packing = Packing::ALL.iter().find(|(word, ..)| *word == name).map(|(.., packing)| *packing);
    Some(Head { start_ns, end_ns, unpacked, crc, packing, size: body.len() - rest.0.len(), len })
}

impl Head {
    /// Whether all that it says can be.
    pub(super) fn is_sound(&self) -> bool {
        let fits = self.packing != Some(Packing::None) || self.unpacked == self.len;
        self.packing.is_some() && self.start_ns <= self.end_ns && self.unpacked <= MAX_UNPACKED && fits
    }
}

/// Unpacks chunks one after the other into the same memory.
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
    /// The records of a whole chunk, checked; or what is wrong with it.
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

    /// What can be unpacked of the beginning of a chunk, unchecked.
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

    /// The fast way, for what earns its memory.
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

    /// The way of small steps: keeps what came before a fault. Whether there was none.
    fn stream(&mut self, packing: Packing, unpacked: u64, packed: &[u8]) -> bool {
        self.room.clear();
        // One byte more than is claimed shows that there is more.
        let most = unpacked + 1;
        match packing {
            Packing::Zstd => zstd::stream::read::Decoder::with_buffer(packed)
                .is_ok_and(|decoder| pour(decoder.take(most), &mut self.room)),
            Packing::Lz4 => pour(lz4_flex::frame::FrameDecoder::new(packed).take(most), &mut self.room),
            Packing::None => false,
        }
    }
}

/// Reads all there is. Whether it ended without a fault.
fn pour(mut from: impl Read, to: &mut Vec<u8>) -> bool {
    from.read_to_end(to).is_ok()
}

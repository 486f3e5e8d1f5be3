//! Properties that a description of the device may define otherwise: the value of an object before any write, the
//! lengths of its values, the least and the greatest of them, and the lengths of PDOs.
//!
//! All of it is in terms of bytes, since the types with which it is compared are not known here. Descriptions are not
//! used.

use super::sighting::{Content, ObjectSighting, Source};
use super::{HeldValue, hold};
use crate::sdo::transfer::Direction;
use crate::world::configuration::number;

/// Properties of an object by SDO.
#[derive(Clone, Debug, Default)]
pub struct MeasuredObject {
    /// The first value read, unless something had written the object before.
    pub first: Option<HeldValue>,
    /// It was read after a boot-up of the node without lost frames in between.
    pub booted: bool,
    /// Something may have written the object.
    touched: bool,
    /// Least and greatest size in bytes of values read and written, if transfers indicate their sizes.
    sizes: [Option<(u64, u64)>; 2],
    extremes: Option<Extremes>,
}

/// The least and the greatest numbers of one width in each interpretation of their bytes.
#[derive(Clone, Copy, Debug)]
struct Extremes {
    width: u64,
    unsigned: [u64; 2],
    signed: [u64; 2],
    /// As reals, if the width is that of a real and one of the values is a number.
    real: Option<[u64; 2]>,
}

impl MeasuredObject {
    /// Takes a sighting of the object. `booted`: the capture shows a boot-up of its node before.
    pub(super) fn take(&mut self, sighting: &ObjectSighting<'_>, booted: bool) {
        let direction = match sighting.source {
            Source::Read => Direction::Upload,
            Source::Written => Direction::Download,
            Source::Rpdo | Source::Unconfirmed => {
                self.touched |= sighting.source == Source::Rpdo || sighting.content() != Content::None;
                return;
            }
            Source::Tpdo | Source::Emcy | Source::Refused => return,
        };
        let content = sighting.content();
        self.touched |= direction == Direction::Download;
        let Content::Bytes(bytes, size) = content else { return };
        if !self.touched && self.first.is_none() {
            hold(&mut self.first, content, sighting.source, sighting.at);
            self.booted = booted;
        }
        if !sighting.is_sized() {
            return;
        }
        if let Some(sizes) = self.sizes.get_mut(direction as usize) {
            *sizes = Some(sizes.map_or((size, size), |(least, most)| (least.min(size), most.max(size))));
        }
        if let Some(raw) = number(bytes).filter(|_| bytes.len() as u64 == size) {
            self.extremes = Some(Extremes::with(self.extremes.filter(|known| known.width == size), raw, size));
        }
    }

    /// Returns least and greatest size in bytes of values read or written, if transfers indicate it.
    pub fn sizes(&self, direction: Direction) -> Option<(u64, u64)> {
        self.sizes.get(direction as usize).copied().flatten()
    }

    /// Returns the values of up to eight bytes that are the least or the greatest in any interpretation of their bytes,
    /// each once, and their size.
    pub fn extremes(&self) -> Option<(Vec<u64>, usize)> {
        let known = self.extremes?;
        let mut all = [known.unsigned, known.signed, known.real.unwrap_or(known.unsigned)].concat();
        all.sort_unstable();
        all.dedup();
        Some((all, known.width as usize))
    }
}

impl Extremes {
    fn with(known: Option<Self>, raw: u64, width: u64) -> Self {
        let fresh = [raw; 2];
        let unused = 64 - 8 * width.clamp(1, 8) as u32;
        let signed = |raw: u64| (raw << unused).cast_signed();
        let mut all = known.unwrap_or(Self { width, unsigned: fresh, signed: fresh, real: None });
        all.unsigned = widened(all.unsigned, raw, |raw| raw);
        all.signed = widened(all.signed, raw, signed);
        if real(raw, width).is_some_and(|real| !real.is_nan()) {
            all.real = Some(widened(all.real.unwrap_or(fresh), raw, |raw| real(raw, width).unwrap_or(0.0)));
        }
        all
    }
}

fn real(raw: u64, width: u64) -> Option<f64> {
    match width {
        4 => Some(f32::from_bits(raw as u32).into()),
        8 => Some(f64::from_bits(raw)),
        _ => None,
    }
}

fn widened<T: PartialOrd>([least, most]: [u64; 2], raw: u64, of: impl Fn(u64) -> T) -> [u64; 2] {
    [if of(raw) < of(least) { raw } else { least }, if of(raw) > of(most) { raw } else { most }]
}

/// Frames of one identifier that carry a PDO.
#[derive(Clone, Copy, Debug)]
pub struct PdoFrames {
    /// The last node that had the PDO.
    pub node: u8,
    /// Transmit or receive, seen from the node.
    pub transmit: bool,
    /// PDO number, from 1.
    pub number: u16,
    /// The number of frames.
    pub frames: u64,
    /// Least and greatest length in bytes.
    pub lengths: (u8, u8),
}

impl PdoFrames {
    pub(super) fn new((node, transmit, number): (u8, bool, u16), length: u8) -> Self {
        Self { node, transmit, number, frames: 0, lengths: (length, length) }
    }

    pub(super) fn take(&mut self, length: u8) {
        self.frames += 1;
        self.lengths = (self.lengths.0.min(length), self.lengths.1.max(length));
    }
}

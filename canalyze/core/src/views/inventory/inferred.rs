//! The type of an object by its values alone: their size, and whether they look like text or have a sign.
//!
//! An integer has a sign if some values are a little below zero and others at or above it, so that they are closer
//! together with a sign; an object with only 0 and all bits set may be a mask. A number may always be a real or a
//! string of four characters, which is not guessed. The object itself is not known here.

use super::sighting::Content;
use crate::world::od::{self, DataType, Value};

/// Factor by which the values must be closer together with a sign than without.
const CLOSER: u64 = 4;

/// Properties of the values of an object.
#[derive(Clone, Debug, Default)]
pub(super) struct Looks {
    /// Least and greatest size in bytes by SDO.
    sizes: Option<(u64, u64)>,
    /// The size of the last value by SDO.
    size: u64,
    /// Number of its bits that a PDO carries.
    mapped: Option<u8>,
    /// All values are text.
    text: bool,
    /// Numbers of the greatest width.
    numbers: Option<NumberSeries>,
}

/// Numbers of one width.
#[derive(Clone, Copy, Debug)]
struct NumberSeries {
    bits: u32,
    /// Least and greatest, read as unsigned.
    unsigned: (u64, u64),
    /// Least and greatest, read as signed.
    signed: (i64, i64),
}

impl Looks {
    /// Takes a value.
    pub(super) fn take(&mut self, content: Content<'_>) {
        match content {
            Content::None => {}
            Content::Bits(raw, bits) => {
                self.mapped = Some(bits);
                self.number(raw, u32::from(bits));
            }
            Content::Bytes(bytes, size) => {
                let text = matches!(od::decode(None, bytes), Value::Text(_));
                self.text = text && (self.text || self.sizes.is_none());
                self.sizes = Some(self.sizes.map_or((size, size), |(least, most)| (least.min(size), most.max(size))));
                self.size = size;
                if let 1..=8 = bytes.len() {
                    let raw = bytes.iter().rev().fold(0, |raw, byte| raw << 8 | u64::from(*byte));
                    self.number(raw, 8 * bytes.len() as u32);
                }
            }
        }
    }

    fn number(&mut self, raw: u64, bits: u32) {
        let unused = 64 - bits.clamp(1, 64);
        let signed = (raw << unused).cast_signed() >> unused;
        self.numbers = Some(match self.numbers {
            Some(known) if known.bits > bits => known,
            Some(NumberSeries { bits: width, unsigned: (least, most), signed: (low, high) }) if width == bits => {
                NumberSeries {
                    bits,
                    unsigned: (least.min(raw), most.max(raw)),
                    signed: (low.min(signed), high.max(signed)),
                }
            }
            _ => NumberSeries { bits, unsigned: (raw, raw), signed: (signed, signed) },
        });
    }

    /// Returns its size in bits.
    pub(super) fn bits(&self) -> Option<u64> {
        self.sizes.map(|_| self.size.saturating_mul(8)).or(self.mapped.map(u64::from))
    }

    /// Returns true if the values may be of a type.
    pub(super) fn fits(&self, data_type: DataType) -> bool {
        let Some(size) = data_type.size().map(|size| size as u64) else { return true };
        match (self.sizes, self.mapped) {
            (Some((least, most)), _) => least == size && most == size,
            (None, Some(1)) => data_type == DataType::Boolean,
            (None, Some(bits)) => u64::from(bits) == 8 * size,
            (None, None) => true,
        }
    }

    /// Returns the type that the values suggest.
    pub(super) fn inferred(&self) -> Option<DataType> {
        use DataType as T;
        let bits = match self.sizes {
            Some(_) if self.text => return Some(T::VisibleString),
            Some((least, most)) if least != most => return Some(T::Domain),
            Some((0, _)) => return None,
            Some((size, _)) if size > 8 => return Some(T::OctetString),
            Some((size, _)) => 8 * size,
            None => u64::from(self.mapped?),
        };
        let signed = self.has_sign();
        Some(match (bits, signed) {
            (1, _) => T::Boolean,
            (8, true) => T::Integer8,
            (16, true) => T::Integer16,
            (24, true) => T::Integer24,
            (32, true) => T::Integer32,
            (40, true) => T::Integer40,
            (48, true) => T::Integer48,
            (56, true) => T::Integer56,
            (64, true) => T::Integer64,
            (8, false) => T::Unsigned8,
            (16, false) => T::Unsigned16,
            (24, false) => T::Unsigned24,
            (32, false) => T::Unsigned32,
            (40, false) => T::Unsigned40,
            (48, false) => T::Unsigned48,
            (56, false) => T::Unsigned56,
            (64, false) => T::Unsigned64,
            _ => return None,
        })
    }

    fn has_sign(&self) -> bool {
        self.numbers.is_some_and(|NumberSeries { unsigned: (least, most), signed: (low, high), .. }| {
            low < -1 && high >= 0 && low.abs_diff(high).saturating_mul(CLOSER) < most - least
        })
    }
}

//! The content of a PDO (CiA 301, 7.5.2.36 and 7.5.2.38): the entries of its mapping, and the bits of each.
//!
//! | bits of an entry | field |
//! |---|---|
//! | 31-16 | index |
//! | 15-8 | sub-index |
//! | 7-0 | length in bits |
//!
//! Entries fill the payload from bit 0 of byte 0 upward, without gaps: of the payload read as one little-endian number,
//! an entry of L bits at offset o is bits o to o+L-1. Every signal of every PDO comes through here, so only building a
//! mapping allocates. The bus decides which mapping is in force.

use std::sync::{Arc, OnceLock};

use crate::words::profiles::Profile;
use crate::world::od::{DataType, first_axis};

/// End of the data type indices, which are dummy entries (CiA 301, 7.4.3, 7.4.7).
const DUMMIES_END: u16 = 0x20;

/// One entry of a mapping.
#[derive(Clone, Debug, PartialEq)]
pub struct Mapped {
    /// Index of the object; of a dummy, the code of a data type.
    pub index: u16,
    /// Sub-index of the object.
    pub sub: u8,
    /// Length in bits, 0..=255 as in the entry; more than 64 only in CANopen FD.
    pub bits: u8,
    /// First bit, counted from bit 0 of byte 0.
    pub offset: u16,
    /// The object's type if known, from a description, else from the standard by the device's profile.
    pub data_type: Option<DataType>,
    /// The profile of the device.
    pub profile: Profile,
    /// Nothing is mapped here, and the bits are skipped.
    pub dummy: bool,
    /// The name in the device's description. It comes from a file and must be escaped for a terminal.
    pub name: Option<Arc<str>>,
    /// The unit in the device's description or configuration; to be escaped as well.
    pub unit: Option<Arc<str>>,
    /// The factor that converts the number to `unit`; 1 by default.
    pub factor: f64,
}

impl Mapped {
    /// Returns true if its type is known and mapped entirely, so that its value is the object's.
    pub fn is_whole(&self) -> bool {
        self.data_type.and_then(DataType::size).is_some_and(|bytes| 8 * bytes == usize::from(self.bits))
    }

    /// Returns true if it is an object of CiA 402: the device is a drive, or its profile is unknown.
    pub fn is_drives(&self) -> bool {
        self.profile.may_be_drive() && self.is_of_profile()
    }

    /// Returns true if it is the statusword of an axis of a drive.
    pub fn is_statusword(&self) -> bool {
        self.sub == 0 && self.index >= 0x6000 && first_axis(self.index) == 0x6041 && self.is_drives()
    }

    /// Returns true if it is the object that the device's profile has at its index: it has the same size, and no other
    /// name if the profile of the device is unknown.
    pub fn is_of_profile(&self) -> bool {
        if self.index < 0x6000 {
            return false;
        }
        let standard = self.profile.data_type(self.index, self.sub);
        let Some(size) = standard.and_then(DataType::size) else { return false };
        if self.data_type.and_then(DataType::size) != Some(size) {
            return false;
        }
        // A truth value is one bit of a PDO.
        let bits = usize::from(self.bits);
        if bits != 8 * size && !(bits == 1 && standard == Some(DataType::Boolean)) {
            return false;
        }
        self.profile != Profile::UNKNOWN || self.is_called_so()
    }

    /// Returns true if the description, if there is one, gives it the profile's name.
    pub fn is_called_so(&self) -> bool {
        let standard = self.profile.name(self.index, self.sub);
        match self.name.as_deref() {
            None | Some("") => true,
            Some(given) => standard.is_some_and(|(_, standard)| same(given, standard)),
        }
    }

    /// Returns the entry as in the mapping parameter, for example `60410010h`.
    pub fn word(&self) -> u32 {
        u32::from(self.index) << 16 | u32::from(self.sub) << 8 | u32::from(self.bits)
    }
}

/// The mapping of a PDO.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mapping {
    /// Entries in the order of the payload, without empty ones (00000000h).
    pub entries: Vec<Mapped>,
    /// Length of all entries, in bits.
    pub bits: u16,
    /// The places of the entries that are statuswords of drives (6041h of any axis).
    pub statuswords: Vec<usize>,
    /// The constant text of each entry by language, created by `text` on first use, since these names and units are in
    /// nine tenths of all lines.
    pub written: [OnceLock<Vec<Written>>; 2],
}

/// The constant text of an entry.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Written {
    /// Its name, escaped for a terminal.
    pub name: Vec<u8>,
    /// The length of `name` without the object that tells it from others of one name.
    pub own: usize,
    /// The name between a comma and an equals sign.
    pub lead: Vec<u8>,
    /// Its unit, escaped for a terminal; empty if none.
    pub unit: Vec<u8>,
    /// The first-axis index of a CiA 402 object whose value has words, else 0.
    pub words: u16,
    /// Its value is shown as bits.
    pub bit_field: bool,
    /// The factor is 10 to the power of minus this; 0 if it is another one.
    pub decimals: u8,
}

impl Mapping {
    /// Creates a mapping of `bits` bits from its entries.
    pub fn new(entries: Vec<Mapped>, bits: u16) -> Self {
        let places = entries.iter().enumerate();
        let statuswords = places.filter_map(|(place, one)| one.is_statusword().then_some(place)).collect();
        Self { entries, bits, statuswords, written: Default::default() }
    }

    /// Creates a mapping from sub-indices 1 to n, with the standards' types and without names and units.
    pub fn from_words(words: &[u32]) -> Self {
        let mut mapping = Self::default();
        let profile = Profile::UNKNOWN;
        for word in words.iter().filter(|word| **word != 0) {
            let (index, sub, bits) = decode_entry(*word);
            let dummy = is_dummy(index, sub);
            let data_type = if dummy { DataType::from_code(index) } else { profile.data_type(index, sub) };
            let offset = mapping.bits;
            mapping.bits = offset.saturating_add(u16::from(bits));
            let (name, unit) = (None, None);
            mapping.entries.push(Mapped {
                index,
                sub,
                bits,
                offset,
                data_type,
                profile,
                dummy,
                name,
                unit,
                factor: 1.0,
            });
        }
        Self::new(mapping.entries, mapping.bits)
    }

    /// Returns the minimum frame length for all entries, in bytes.
    pub fn bytes(&self) -> usize {
        usize::from(self.bits).div_ceil(8)
    }

    /// Returns the bits of an entry; `None` if the payload is too short, and for 0 or more than 64 bits.
    pub fn raw(&self, entry: &Mapped, payload: &[u8]) -> Option<u64> {
        extract(payload, usize::from(entry.offset), usize::from(entry.bits))
    }

    /// Returns the bytes of an entry of whole, aligned bytes, for strings and more than 64 bits; `None` otherwise, or
    /// if the payload is too short.
    pub fn octets<'a>(&self, entry: &Mapped, payload: &'a [u8]) -> Option<&'a [u8]> {
        if entry.bits == 0 || !entry.offset.is_multiple_of(8) || !entry.bits.is_multiple_of(8) {
            return None;
        }
        let start = usize::from(entry.offset / 8);
        payload.get(start..start + usize::from(entry.bits / 8))
    }
}

/// Returns true if two names are equal except for case, blanks and signs: `Position_Actual_Value`.
fn same(given: &str, standard: &str) -> bool {
    fn letters(name: &str) -> impl Iterator<Item = char> {
        name.chars().filter(|c| c.is_alphanumeric()).map(|c| c.to_ascii_lowercase())
    }
    letters(given).eq(letters(standard))
}

/// Returns index, sub-index and length in bits of an entry of a mapping parameter.
pub fn decode_entry(word: u32) -> (u16, u8, u8) {
    let [bits, sub, low, high] = word.to_le_bytes();
    (u16::from_le_bytes([low, high]), sub, bits)
}

/// Returns true if an entry is a dummy: a data type in an object's place.
pub fn is_dummy(index: u16, sub: u8) -> bool {
    index < DUMMIES_END && sub == 0
}

/// Returns `bits` bits (1..=64) of the payload from bit `offset` on; `None` if it is too short.
#[inline]
pub fn extract(payload: &[u8], offset: usize, bits: usize) -> Option<u64> {
    if bits == 0 || bits > 64 || offset.checked_add(bits)? > payload.len().checked_mul(8)? {
        return None;
    }
    let mask = u64::MAX >> (64 - bits);
    // Nearly all frames are classic frames of eight bytes.
    if let Ok(whole) = <[u8; 8]>::try_from(payload) {
        return Some(u64::from_le_bytes(whole) >> offset & mask);
    }
    if payload.len() < 8 {
        // Four bytes or more are two numbers of four, which may overlap.
        let whole = match (payload.first_chunk(), payload.last_chunk()) {
            (Some(low), Some(high)) => {
                let high = u64::from(u32::from_le_bytes(*high)) << (8 * (payload.len() - 4));
                u64::from(u32::from_le_bytes(*low)) | high
            }
            _ => payload.iter().rev().fold(0, |whole, byte| whole << 8 | u64::from(*byte)),
        };
        return Some(whole >> offset & mask);
    }
    // 64 bits at any position span at most nine bytes.
    let from = payload.get(offset / 8..)?;
    let mut window = [0; 16];
    for (to, byte) in window.iter_mut().zip(from) {
        *to = *byte;
    }
    Some((u128::from_le_bytes(window) >> (offset % 8)) as u64 & mask)
}

/// The value of an entry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Number {
    /// UNSIGNEDn, an unknown type, or a real of another length than its type's.
    Unsigned(u64),
    /// INTEGERn.
    Signed(i64),
    /// REAL32.
    Real32(f32),
    /// REAL64.
    Real64(f64),
    /// BOOLEAN.
    Bool(bool),
    /// Strings, DOMAIN and dates: the raw bits are the bytes, the first one lowest.
    Bytes,
}

/// Returns the value of the lowest `bits` bits of `raw`, with the sign at the mapped length, which may be shorter than
/// the type's.
pub fn number(data_type: Option<DataType>, raw: u64, bits: u8) -> Number {
    use DataType as T;
    let unused = 64 - u32::from(bits.clamp(1, 64));
    let raw = raw << unused >> unused;
    match data_type {
        Some(kind) if kind.is_signed() => Number::Signed((raw << unused).cast_signed() >> unused),
        // With more than one bit, a value other than 0 and 1 is not shown as "true".
        Some(T::Boolean) if raw <= 1 => Number::Bool(raw == 1),
        Some(T::Real32) if bits == 32 => Number::Real32(f32::from_bits(raw as u32)),
        Some(T::Real64) if bits == 64 => Number::Real64(f64::from_bits(raw)),
        Some(T::VisibleString | T::OctetString | T::UnicodeString | T::Domain | T::TimeOfDay | T::TimeDifference) => {
            Number::Bytes
        }
        _ => Number::Unsigned(raw),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;
    use proptest::prelude::*;

    fn numbers(words: &[u32], types: &[DataType], payload: &[u8]) -> Vec<Option<Number>> {
        let mapping = Mapping::from_words(words);
        let read = |(entry, data_type): (&Mapped, &DataType)| {
            mapping.raw(entry, payload).map(|raw| number(Some(*data_type), raw, entry.bits))
        };
        mapping.entries.iter().zip(types).map(read).collect()
    }

    #[test]
    fn four_entries_two_of_them_within_bytes() {
        let words = [0x2000_0120, 0x2001_0010, 0x2002_0003, 0x2003_000D];
        let types = [DataType::Integer32, DataType::Unsigned16, DataType::Unsigned8, DataType::Integer16];
        let payload = [0x9C, 0xFF, 0xFF, 0xFF, 0x34, 0x12, 0x15, 0xF8];
        let read = [Number::Signed(-100), Number::Unsigned(0x1234), Number::Unsigned(5), Number::Signed(-254)];
        assert_eq!(numbers(&words, &types, &payload), read.map(Some));
        let mapping = Mapping::from_words(&words);
        assert_eq!((mapping.bits, mapping.bytes()), (64, 8));
        assert_eq!(mapping.entries.iter().map(|entry| entry.offset).collect::<Vec<_>>(), [0, 32, 48, 51]);
        assert_eq!(mapping.entries.iter().map(Mapped::word).collect::<Vec<_>>(), words);
        let mut short = read.map(Some);
        short[3] = None;
        assert_eq!(numbers(&words, &types, &payload[..7]), short);
    }

    #[test]
    fn bits_of_payloads_of_any_length() {
        let all: Vec<u8> = (1..=12_u8).map(|byte| byte.wrapping_mul(0x9D)).collect();
        for (len, offset, bits) in
            (0..=12).flat_map(|len| (0..99).flat_map(move |from| (1..=64).map(move |n| (len, from, n))))
        {
            let bit = |at: usize| u64::from(all[at / 8] >> (at % 8) & 1);
            let one_by_one =
                (offset + bits <= 8 * len).then(|| (0..bits).fold(0, |raw, at| raw | bit(offset + at) << at));
            assert_eq!(extract(&all[..len], offset, bits), one_by_one, "{bits} from {offset} of {len} bytes");
        }
    }

    #[test]
    fn lengths_that_are_not_the_types() {
        // An aligned entry shorter than its type takes only its own bits.
        assert_eq!(extract(&[0xAA, 0xBB, 0xCC, 0xDD], 0, 16), Some(0xBBAA));
        // The most negative value of a bit field has a sign too.
        assert_eq!(number(Some(DataType::Integer8), 0b1000, 4), Number::Signed(-8));
        assert_eq!(number(Some(DataType::Integer8), 0b1001, 4), Number::Signed(-7));
        assert_eq!(number(Some(DataType::Integer8), 0b0111, 4), Number::Signed(7));
        assert_eq!(number(Some(DataType::Integer64), u64::MAX, 64), Number::Signed(-1));
        assert_eq!(number(Some(DataType::Integer16), 1, 1), Number::Signed(-1));
        // A field may cross the storage size of its type.
        assert_eq!(extract(&[0xE0, 0x03], 5, 5), Some(31));
    }

    #[test]
    fn types() {
        assert_eq!(number(Some(DataType::Real32), 0x3FC0_0000, 32), Number::Real32(1.5));
        assert_eq!(number(Some(DataType::Real32), 0x3FC0, 16), Number::Unsigned(0x3FC0));
        assert_eq!(number(Some(DataType::Real64), 0xC000_0000_0000_0000, 64), Number::Real64(-2.0));
        assert_eq!(number(Some(DataType::Boolean), 1, 1), Number::Bool(true));
        assert_eq!(number(Some(DataType::Boolean), 0, 8), Number::Bool(false));
        assert_eq!(number(Some(DataType::Boolean), 2, 8), Number::Unsigned(2));
        assert_eq!(number(Some(DataType::Unsigned8), 0xFFFF, 8), Number::Unsigned(0xFF));
        assert_eq!(number(Some(DataType::VisibleString), 0x41, 8), Number::Bytes);
        assert_eq!(number(Some(DataType::TimeOfDay), 0, 48), Number::Bytes);
        assert_eq!(number(None, 0xFFFF_FF9C, 32), Number::Unsigned(4_294_967_196));
        assert_eq!(number(Some(DataType::Integer8), 0, 0), Number::Signed(0));
    }

    #[test]
    fn dummies_and_empty_entries() {
        let mapping = Mapping::from_words(&[0x0005_0008, 0, 0x0001_0001, 0x6041_0010, 0x0005_0108]);
        let seen: Vec<_> = mapping.entries.iter().map(|e| (e.index, e.offset, e.dummy, e.data_type)).collect();
        assert_eq!(
            seen,
            [
                (5, 0, true, Some(DataType::Unsigned8)),
                (1, 8, true, Some(DataType::Boolean)),
                (0x6041, 9, false, Some(DataType::Unsigned16)),
                (5, 25, false, None),
            ]
        );
        assert_eq!((mapping.bits, mapping.bytes()), (33, 5));
        assert_eq!(Mapping::from_words(&[]), Mapping::default());
        assert_eq!(decode_entry(0x6041_0010), (0x6041, 0, 16));
        assert!(is_dummy(0x1F, 0) && !is_dummy(0x20, 0) && !is_dummy(7, 1));
    }

    #[test]
    fn longer_than_a_number() {
        let mapping = Mapping::from_words(&[0x2000_0008, 0x2001_0080, 0x2002_0004, 0x2003_0008]);
        let payload: Vec<u8> = (0..19).collect();
        let entry = |no: usize| &mapping.entries[no];
        assert_eq!(mapping.raw(entry(1), &payload), None);
        assert_eq!(mapping.octets(entry(1), &payload), Some(&payload[1..17]));
        assert_eq!(mapping.octets(entry(1), &payload[..16]), None);
        assert_eq!(mapping.octets(entry(2), &payload), None);
        assert_eq!(mapping.octets(entry(3), &payload), None);
        assert_eq!(mapping.raw(entry(3), &payload), Some(0x21));
    }

    #[test]
    fn what_does_not_reach() {
        assert_eq!(extract(&[], 0, 1), None);
        assert_eq!(extract(&[0xFF], 8, 1), None);
        assert_eq!(extract(&[0xFF], 7, 1), Some(1));
        assert_eq!(extract(&[0xFF; 8], 0, 0), None);
        assert_eq!(extract(&[0xFF; 64], 0, 65), None);
        assert_eq!(extract(&[0xFF; 8], usize::MAX, 1), None);
        assert_eq!(extract(&[0xFF; 64], 448, 64), Some(u64::MAX));
        assert_eq!(Mapping::from_words(&[u32::MAX; 1000]).bits, u16::MAX);
    }

    /// The formula: the payload as one little-endian number, shifted and masked, bit by bit.
    fn formula(payload: &[u8], offset: usize, bits: usize) -> u64 {
        (0..bits).fold(0, |value, bit| {
            let at = offset + bit;
            value | u64::from(payload[at / 8] >> (at % 8) & 1) << bit
        })
    }

    proptest! {
        #[test]
        fn bits_by_the_formula(payload in proptest::collection::vec(any::<u8>(), 0..=64), offset in 0..520_usize, bits in 0..70_usize) {
            let reached = (1..=64).contains(&bits) && offset + bits <= 8 * payload.len();
            let expected = reached.then(|| formula(&payload, offset, bits));
            prop_assert_eq!(extract(&payload, offset, bits), expected);
        }

        #[test]
        fn signs_by_the_formula(raw: u64, bits in 1..=64_u8) {
            let masked = i128::from(raw) & ((1 << bits) - 1);
            let expected = if masked >> (bits - 1) == 1 { masked - (1 << bits) } else { masked };
            let read = number(Some(DataType::Integer32), raw, bits);
            prop_assert_eq!(read, Number::Signed(i64::try_from(expected).unwrap()));
        }

        #[test]
        fn entries_follow_each_other(words: Vec<u32>, payload in proptest::collection::vec(any::<u8>(), 0..=64)) {
            let mapping = Mapping::from_words(&words);
            let mut offset = 0_u16;
            for entry in &mapping.entries {
                prop_assert_eq!(entry.offset, offset);
                offset = offset.saturating_add(u16::from(entry.bits));
                prop_assert_eq!(entry.word() >> 16, u32::from(entry.index));
                let _ = mapping.raw(entry, &payload).map(|raw| number(entry.data_type, raw, entry.bits));
                let _ = mapping.octets(entry, &payload);
            }
            prop_assert_eq!(mapping.bits, offset);
        }
    }
}

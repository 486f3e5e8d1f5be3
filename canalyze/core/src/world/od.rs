//! The object dictionary: data types (CiA 301, 7.4.7), the types of the communication objects, and values of bytes.
//!
//! Descriptions of particular devices (EDS) are elsewhere, and so are names (`text::terms`). The type of a standard
//! object is the standard's. A device may differ, so a value whose size does not match its type is shown by its bytes,
//! and never is an error.

/// A static data type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DataType {
    /// 0001: one byte in SDO, one bit in a PDO.
    Boolean,
    /// 0002.
    Integer8,
    /// 0003.
    Integer16,
    /// 0004.
    Integer32,
    /// 0005.
    Unsigned8,
    /// 0006.
    Unsigned16,
    /// 0007.
    Unsigned32,
    /// 0008: IEEE 754 single precision.
    Real32,
    /// 0009: ISO 646, no terminator.
    VisibleString,
    /// 000A.
    OctetString,
    /// 000B: 16-bit units, little-endian.
    UnicodeString,
    /// 000C: 48 bits.
    TimeOfDay,
    /// 000D: 48 bits.
    TimeDifference,
    /// 000F: any bytes.
    Domain,
    /// 0010.
    Integer24,
    /// 0011: IEEE 754 double precision.
    Real64,
    /// 0012.
    Integer40,
    /// 0013.
    Integer48,
    /// 0014.
    Integer56,
    /// 0015.
    Integer64,
    /// 0016.
    Unsigned24,
    /// 0018.
    Unsigned40,
    /// 0019.
    Unsigned48,
    /// 001A.
    Unsigned56,
    /// 001B.
    Unsigned64,
}

use DataType::{
    Boolean, Domain, Integer8, Integer16, Integer24, Integer32, Integer40, Integer48, Integer56, Integer64,
    OctetString, Real32, Real64, TimeDifference, TimeOfDay, UnicodeString, Unsigned8, Unsigned16, Unsigned24,
    Unsigned32, Unsigned40, Unsigned48, Unsigned56, Unsigned64, VisibleString,
};

impl DataType {
    /// Returns true if it is one of the INTEGER types, whose values may be negative.
    pub const fn is_signed(self) -> bool {
        matches!(self, Integer8 | Integer16 | Integer24 | Integer32 | Integer40 | Integer48 | Integer56 | Integer64)
    }

    /// Returns the type of a code in the object dictionary and in an EDS; `None` for reserved and complex ones.
    pub const fn from_code(code: u16) -> Option<Self> {
        Some(match code {
            0x01 => Boolean,
            0x02 => Integer8,
            0x03 => Integer16,
            0x04 => Integer32,
            0x05 => Unsigned8,
            0x06 => Unsigned16,
            0x07 => Unsigned32,
            0x08 => Real32,
            0x09 => VisibleString,
            0x0A => OctetString,
            0x0B => UnicodeString,
            0x0C => TimeOfDay,
            0x0D => TimeDifference,
            0x0F => Domain,
            0x10 => Integer24,
            0x11 => Real64,
            0x12 => Integer40,
            0x13 => Integer48,
            0x14 => Integer56,
            0x15 => Integer64,
            0x16 => Unsigned24,
            0x18 => Unsigned40,
            0x19 => Unsigned48,
            0x1A => Unsigned56,
            0x1B => Unsigned64,
            _ => return None,
        })
    }

    /// Returns CiA 301's name, the same in every language.
    pub const fn name(self) -> &'static str {
        match self {
            Boolean => "BOOLEAN",
            Integer8 => "INTEGER8",
            Integer16 => "INTEGER16",
            Integer24 => "INTEGER24",
            Integer32 => "INTEGER32",
            Integer40 => "INTEGER40",
            Integer48 => "INTEGER48",
            Integer56 => "INTEGER56",
            Integer64 => "INTEGER64",
            Unsigned8 => "UNSIGNED8",
            Unsigned16 => "UNSIGNED16",
            Unsigned24 => "UNSIGNED24",
            Unsigned32 => "UNSIGNED32",
            Unsigned40 => "UNSIGNED40",
            Unsigned48 => "UNSIGNED48",
            Unsigned56 => "UNSIGNED56",
            Unsigned64 => "UNSIGNED64",
            Real32 => "REAL32",
            Real64 => "REAL64",
            VisibleString => "VISIBLE_STRING",
            OctetString => "OCTET_STRING",
            UnicodeString => "UNICODE_STRING",
            TimeOfDay => "TIME_OF_DAY",
            TimeDifference => "TIME_DIFFERENCE",
            Domain => "DOMAIN",
        }
    }

    /// Returns the size in bytes of its values in SDO transfers; `None` if the size is not fixed.
    pub const fn size(self) -> Option<usize> {
        match self {
            Boolean | Integer8 | Unsigned8 => Some(1),
            Integer16 | Unsigned16 => Some(2),
            Integer24 | Unsigned24 => Some(3),
            Integer32 | Unsigned32 | Real32 => Some(4),
            Integer40 | Unsigned40 => Some(5),
            Integer48 | Unsigned48 | TimeOfDay | TimeDifference => Some(6),
            Integer56 | Unsigned56 => Some(7),
            Integer64 | Unsigned64 | Real64 => Some(8),
            VisibleString | OctetString | UnicodeString | Domain => None,
        }
    }

    /// Returns the number of bits of its values in a PDO: one for BOOLEAN; `None` if the size is not fixed.
    pub const fn bits(self) -> Option<u8> {
        match (self, self.size()) {
            (Boolean, _) => Some(1),
            (_, Some(bytes)) => Some(8 * bytes as u8),
            (_, None) => None,
        }
    }
}

/// Returns the index on the first logical device: 6000h-9FFFh hold eight of them, 800h apart. Others are unchanged.
pub const fn first_axis(index: u16) -> u16 {
    match index {
        0x6000..=0x9FFF => 0x6000 + index % 0x800,
        _ => index,
    }
}

/// Returns the data type of a standard object in 1000h-1FFFh: CiA 301, 302 and 304. Sub-index 0 of an object with
/// sub-indices is their count. Types of device profiles are in `profiles`.
pub const fn communication(index: u16, sub: u8) -> Option<DataType> {
    Some(match (index, sub) {
        (0x1000 | 0x1002 | 0x1005 | 0x1006 | 0x1007 | 0x1012 | 0x1013 | 0x1014, 0) => Unsigned32,
        (0x1001 | 0x100D | 0x1019 | 0x1024, 0) => Unsigned8,
        (0x1008..=0x100A, 0) => VisibleString,
        (0x100C | 0x1015 | 0x1017 | 0x1022 | 0x102A, 0) => Unsigned16,
        (0x1021, 0) => Domain,
        (0x1003 | 0x1010 | 0x1011 | 0x1016 | 0x1018 | 0x1020 | 0x1023 | 0x1025..=0x1029, 0) => Unsigned8,
        (0x1003 | 0x1010 | 0x1011 | 0x1016 | 0x1028, 1..=0xFE) => Unsigned32,
        (0x1018, 1..=4) => Unsigned32,
        (0x1020, 1..=2) => Unsigned32,
        (0x1023 | 0x1025, 1 | 3) => OctetString,
        (0x1023 | 0x1025, 2) => Unsigned8,
        (0x1026, 1..=3) => Unsigned8,
        (0x1027, 1..=0xFE) => Unsigned16,
        (0x1029, 1..=0xFE) => Unsigned8,
        (0x1200..=0x12FF, 0 | 3) => Unsigned8,
        (0x1200..=0x12FF, 1 | 2) => Unsigned32,
        (0x1300, 0) => Unsigned8,
        (0x1301..=0x1340, 0 | 1 | 3 | 4) => Unsigned8,
        (0x1301..=0x1340, 2) => Unsigned16,
        (0x1301..=0x1340, 5 | 6) => Unsigned32,
        (0x13FE, 0) | (0x13FF, 0) | (0x1381..=0x13C0, 0) => Unsigned8,
        (0x1381..=0x13C0, 1..=0xFE) => Unsigned32,
        (0x13FF, 1..=0xFE) => Unsigned16,
        (0x1400..=0x15FF | 0x1800..=0x19FF, 0 | 2 | 4 | 6) => Unsigned8,
        (0x1400..=0x15FF | 0x1800..=0x19FF, 1) => Unsigned32,
        (0x1400..=0x15FF | 0x1800..=0x19FF, 3 | 5) => Unsigned16,
        (0x1600..=0x17FF | 0x1A00..=0x1BFF, 0) => Unsigned8,
        (0x1600..=0x17FF | 0x1A00..=0x1BFF, 1..=64) => Unsigned32,
        (0x1F80 | 0x1F89, 0) => Unsigned32,
        (0x1F20..=0x1F27 | 0x1F50..=0x1F57 | 0x1F81..=0x1F88 | 0x1F90 | 0x1F91 | 0x1FA0..=0x1FFF, 0) => Unsigned8,
        (0x1F20 | 0x1F22 | 0x1F23 | 0x1F50, 1..=0xFE) => Domain,
        (0x1F21 | 0x1F24 | 0x1F51 | 0x1F82 | 0x1F83, 1..=0xFE) => Unsigned8,
        (0x1F25..=0x1F27 | 0x1F52..=0x1F57 | 0x1F81 | 0x1F84..=0x1F88, 1..=0xFE) => Unsigned32,
        (0x1F90 | 0x1F91, 1..=0xFE) => Unsigned16,
        (0x1FA0..=0x1FCF, 1..=0xFE) => Unsigned32,
        (0x1FD0..=0x1FFF, 1..=0xFE) => Unsigned64,
        _ => return None,
    })
}

/// A value, read from the bytes of a transfer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value<'a> {
    /// BOOLEAN.
    Bool(bool),
    /// INTEGERn.
    Signed(i64),
    /// UNSIGNEDn, and short bytes without a fitting type, little-endian.
    Unsigned(u64),
    /// REAL32, REAL64.
    Real(f64),
    /// Text, without trailing NULs. It comes from the capture and has to be escaped before it reaches a terminal.
    Text(&'a str),
    /// TIME_OF_DAY.
    Time {
        /// Milliseconds since midnight, 28 bits.
        ms: u32,
        /// Days since 1984-01-01.
        days: u16,
    },
    /// TIME_DIFFERENCE.
    Difference {
        /// Milliseconds, 28 bits.
        ms: u32,
        /// Days.
        days: u16,
    },
    /// Anything else: shown in hexadecimal.
    Bytes(&'a [u8]),
    /// No bytes.
    Empty,
}

/// Minimum number of bytes without a type that are taken for text. A printable value of at most four bytes ("save",
/// 1000, 12345) is as likely a number; one of five rarely is.
const LEAST_TEXT: usize = 5;

/// Returns the value of `bytes`.
///
/// With a type of matching size, by the type. A VISIBLE_STRING that is not text, and octet and UNICODE strings, are
/// `Bytes` ([`unicode`] reads the latter).
///
/// Without a type, or if its size does not match, NULs at the end are ignored: five bytes or more of printable UTF-8
/// are `Text`; any other value of up to eight bytes is a little-endian `Unsigned`; a longer one is `Text` if it is
/// printable and `Bytes` otherwise. A DOMAIN is never a number: `Text` as above, else `Bytes`.
pub fn decode(data_type: Option<DataType>, bytes: &[u8]) -> Value<'_> {
    if bytes.is_empty() {
        return Value::Empty;
    }
    match data_type {
        Some(VisibleString) => text(bytes, true).map_or(Value::Bytes(bytes), Value::Text),
        Some(OctetString | UnicodeString) => Value::Bytes(bytes),
        Some(Domain) => long_text(bytes).map_or(Value::Bytes(bytes), Value::Text),
        Some(fixed) if fixed.size() == Some(bytes.len()) => sized(fixed, bytes),
        _ => untyped(bytes),
    }
}

/// Returns the text of a UNICODE_STRING; unpaired surrogates become U+FFFD, an odd last byte is ignored.
pub fn unicode(bytes: &[u8]) -> String {
    let (units, _) = bytes.as_chunks::<2>();
    char::decode_utf16(units.iter().map(|unit| u16::from_le_bytes(*unit)))
        .map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER))
        .collect()
}

/// Reads bytes of exactly the type's size.
fn sized(data_type: DataType, bytes: &[u8]) -> Value<'_> {
    let unsigned = little_endian(bytes);
    match data_type {
        Boolean => Value::Bool(unsigned != 0),
        Integer8 | Integer16 | Integer24 | Integer32 | Integer40 | Integer48 | Integer56 | Integer64 => {
            // At most 8 bytes: shift the sign bit to the top and back.
            let unused = 64 - 8 * bytes.len().min(8) as u32;
            Value::Signed((unsigned.wrapping_shl(unused) as i64).wrapping_shr(unused))
        }
        Real32 => Value::Real(f64::from(f32::from_bits(unsigned as u32))),
        Real64 => Value::Real(f64::from_bits(unsigned)),
        TimeOfDay => Value::Time { ms: unsigned as u32 & 0x0FFF_FFFF, days: (unsigned >> 32) as u16 },
        TimeDifference => Value::Difference { ms: unsigned as u32 & 0x0FFF_FFFF, days: (unsigned >> 32) as u16 },
        _ => Value::Unsigned(unsigned),
    }
}

fn untyped(bytes: &[u8]) -> Value<'_> {
    if let Some(text) = long_text(bytes) {
        return Value::Text(text);
    }
    if bytes.len() <= 8 {
        return Value::Unsigned(little_endian(bytes));
    }
    match text(bytes, false) {
        Some(text) if !text.is_empty() => Value::Text(text),
        _ => Value::Bytes(bytes),
    }
}

/// Returns text that is too long for a number.
fn long_text(bytes: &[u8]) -> Option<&str> {
    text(bytes, false).filter(|text| text.len() >= LEAST_TEXT)
}

/// Returns UTF-8 without control characters (`lines`: except tab and line ends), without trailing NULs.
fn text(bytes: &[u8], lines: bool) -> Option<&str> {
    let end = bytes.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
    let text = std::str::from_utf8(bytes.get(..end)?).ok()?;
    let fits = |c: char| !c.is_control() || lines && matches!(c, '\t' | '\r' | '\n');
    text.chars().all(fits).then_some(text)
}

/// Returns the first eight bytes as a little-endian number.
fn little_endian(bytes: &[u8]) -> u64 {
    bytes.iter().take(8).rev().fold(0, |number, byte| number << 8 | u64::from(*byte))
}

/// Returns true if a number in 1000h-1FFFh is read as bits rather than as a quantity: COB-IDs, identities, mappings,
/// error codes.
pub fn is_bit_field(index: u16, sub: u8) -> bool {
    match index {
        0x1000..=0x1002 | 0x1005 | 0x1012 | 0x1014 | 0x1020 | 0x1023..=0x1026 => true,
        0x1003 | 0x1016 | 0x1018 | 0x1028 => sub > 0,
        0x1200..=0x12FF => sub == 1 || sub == 2,
        0x1301..=0x1340 => sub == 5 || sub == 6,
        0x1400..=0x15FF | 0x1800..=0x19FF => sub == 1,
        0x1600..=0x17FF | 0x1A00..=0x1BFF => sub > 0,
        0x1F80..=0x1F82 => true,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn by_type() {
        assert_eq!(decode(Some(Unsigned32), &[0x78, 0x56, 0x34, 0x12]), Value::Unsigned(0x1234_5678));
        assert_eq!(decode(Some(Integer24), &[0xFE, 0xFF, 0xFF]), Value::Signed(-2));
        assert_eq!(decode(Some(Integer64), &[0xFF; 8]), Value::Signed(-1));
        assert_eq!(decode(Some(Integer8), &[0x80]), Value::Signed(-128));
        assert_eq!(decode(Some(Unsigned24), &[0x56, 0x34, 0x12]), Value::Unsigned(0x12_3456));
        assert_eq!(decode(Some(Real32), &[0, 0, 0xC0, 0x3F]), Value::Real(1.5));
        assert_eq!(decode(Some(Real64), &[0, 0, 0, 0, 0, 0, 0, 0xC0]), Value::Real(-2.0));
        assert_eq!(decode(Some(Boolean), &[2]), Value::Bool(true));
        assert_eq!(decode(Some(VisibleString), b"ab"), Value::Text("ab"));
        assert_eq!(decode(Some(VisibleString), b"ab\r\n\0\0"), Value::Text("ab\r\n"));
        assert_eq!(decode(Some(VisibleString), "\u{8BBE}\u{5907}".as_bytes()), Value::Text("\u{8BBE}\u{5907}"));
        assert_eq!(decode(Some(VisibleString), b"\x01\x02"), Value::Bytes(b"\x01\x02"));
        assert_eq!(decode(Some(OctetString), b"abcdef"), Value::Bytes(b"abcdef"));
        assert_eq!(decode(Some(Domain), &[1, 0]), Value::Bytes(&[1, 0]));
        assert_eq!(
            decode(Some(TimeOfDay), &[0x95, 0x2C, 0xB3, 0x02, 0x9E, 0x39]),
            Value::Time { ms: 45_296_789, days: 14_750 }
        );
        assert_eq!(decode(Some(TimeDifference), &[1, 0, 0, 0xF0, 2, 0]), Value::Difference { ms: 1, days: 2 });
        assert_eq!(decode(Some(Unsigned32), &[]), Value::Empty);
        assert_eq!(unicode(&[0x5A, 0x00, 0xE9, 0x00]), "Zé");
    }

    #[test]
    fn without_a_fitting_type() {
        assert_eq!(decode(None, b"Zephyr RTOS/CANopenNode"), Value::Text("Zephyr RTOS/CANopenNode"));
        assert_eq!(decode(None, "\u{8BBE}\u{5907}\u{540D}".as_bytes()), Value::Text("\u{8BBE}\u{5907}\u{540D}"));
        assert_eq!(decode(None, b"save"), Value::Unsigned(0x6576_6173));
        assert_eq!(decode(None, b"12345"), Value::Text("12345"));
        assert_eq!(decode(None, &[0x41, 0, 0, 0, 0, 0, 0, 0]), Value::Unsigned(0x41));
        assert_eq!(decode(None, b"A\0\0\0\0\0\0\0\0"), Value::Text("A"));
        assert_eq!(decode(None, &[0; 9]), Value::Bytes(&[0; 9]));
        assert_eq!(decode(None, &[1; 9]), Value::Bytes(&[1; 9]));
        assert_eq!(decode(Some(Unsigned32), &[0xEF, 0xBE]), Value::Unsigned(0xBEEF));
        assert_eq!(decode(Some(Unsigned8), b"device"), Value::Text("device"));
    }

    #[test]
    fn codes_and_names() {
        let all: Vec<_> = (0..0x100).filter_map(DataType::from_code).collect();
        assert_eq!(all.len(), 25);
        assert_eq!(DataType::from_code(0x07), Some(Unsigned32));
        assert_eq!(DataType::from_code(0x0E), None);
        assert_eq!(DataType::from_code(0x17), None);
        let mut names: Vec<_> = all.iter().map(|data_type| data_type.name()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), 25);
        for data_type in all {
            let bits: String = data_type.name().chars().filter(char::is_ascii_digit).collect();
            if !bits.is_empty() {
                assert_eq!(data_type.size(), Some(bits.parse::<usize>().unwrap() / 8), "{}", data_type.name());
            }
        }
    }

    #[test]
    fn standard_objects() {
        assert_eq!(communication(0x1008, 0), Some(VisibleString));
        assert_eq!(communication(0x1018, 4), Some(Unsigned32));
        assert_eq!(communication(0x1018, 5), None);
        assert_eq!(communication(0x1801, 2), Some(Unsigned8));
        assert_eq!(communication(0x1801, 5), Some(Unsigned16));
        assert_eq!(communication(0x1A01, 1), Some(Unsigned32));
        assert_eq!(communication(0x2000, 0), None);
        assert_eq!(communication(0x6041, 0), None);
    }

    proptest! {
        #[test]
        fn total(code in 0u16..0x30, bytes in proptest::collection::vec(any::<u8>(), 0..32)) {
            let value = decode(DataType::from_code(code), &bytes);
            if bytes.is_empty() {
                prop_assert_eq!(value, Value::Empty);
            }
        }
    }
}

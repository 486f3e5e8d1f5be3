//! The value that an SDO transfer is expected to carry.
//!
//! Numbers are those of the object's type as they are transferred, without factor and unit. Ambiguity counts as
//! equality: if the same bytes can be read in two ways, the one that matches counts. Only complete transfers are
//! compared.

use std::sync::Arc;

use serde::Deserialize;
use serde_json::Number;

use crate::rules::finding::{Quantity, Said};
use crate::sdo::transfer::Transfer;
use crate::world::od::{self, DataType, Value as Read};

/// Maximum number of characters of a text, or of bytes, that are kept of a found value.
const SHOWN: usize = 256;
/// Tolerance of a REAL32 to a number that was written in decimal: a few units in its last place.
const SINGLE: f64 = 1.0 / (1 << 21) as f64;
/// Tolerance of a REAL64.
const DOUBLE: f64 = 1.0 / (1_u64 << 50) as f64;

/// An expected value.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum ExpectedValue {
    /// A number, by value.
    Number(Number),
    /// Text, without NULs at its end.
    Text(String),
    /// A truth value.
    Bool(bool),
    /// Exactly these bytes.
    Data(Bytes),
}

/// Bytes as hexadecimal digits.
#[derive(Clone, Debug, Deserialize)]
#[serde(try_from = "String")]
pub(super) struct Bytes(Arc<[u8]>);

impl TryFrom<String> for Bytes {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let (pairs, rest) = text.as_bytes().as_chunks::<2>();
        let byte = |[high, low]: &[u8; 2]| {
            let digit = |byte: u8| char::from(byte).to_digit(16);
            Some((digit(*high)? << 4 | digit(*low)?) as u8)
        };
        let bytes: Option<Arc<[u8]>> = pairs.iter().map(byte).collect();
        bytes.filter(|_| rest.is_empty()).map(Self).ok_or_else(|| format!("data={text:?}"))
    }
}

/// The result of comparing a value with the expected one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Same {
    Yes,
    No,
    /// Some of its bytes are missing.
    Unknown,
}

impl From<bool> for Same {
    fn from(same: bool) -> Self {
        if same { Self::Yes } else { Self::No }
    }
}

impl ExpectedValue {
    /// Compares a successful transfer with it.
    pub(super) fn is_of(&self, transfer: &Transfer) -> Same {
        if transfer.data.hole {
            return Same::Unknown;
        }
        let kept = transfer.data.kept.as_slice();
        let whole = kept.len() as u64 == transfer.data.size;
        let beginning = |same: bool| match (same, whole) {
            (false, _) => Same::No,
            (true, true) => Same::Yes,
            (true, false) => Same::Unknown,
        };
        match self {
            Self::Data(Bytes(bytes)) => {
                beginning(bytes.len() as u64 == transfer.data.size && bytes.get(..kept.len()) == Some(kept))
            }
            Self::Text(text) if transfer.data_type() == Some(DataType::UnicodeString) => {
                beginning(od::unicode(kept).trim_end_matches('\0') == text.trim_end_matches('\0'))
            }
            Self::Text(text) => {
                let text = text.trim_end_matches('\0').as_bytes();
                let rest = kept.strip_prefix(text);
                beginning(rest.is_some_and(|rest| rest.iter().all(|byte| *byte == 0)))
            }
            Self::Bool(on) => {
                let number = if whole { little_endian(kept) } else { None };
                let byte = kept.len() == 1;
                number.is_some_and(|number| (number != 0) == *on && (byte || number <= 1)).into()
            }
            Self::Number(number) => (whole && is_number(number, transfer.data_type(), kept)).into(),
        }
    }

    /// Its form in a finding.
    pub(super) fn said(&self) -> Said {
        match self {
            Self::Number(number) => match (number.as_u64(), number.as_i64()) {
                (Some(number), _) => Said::Quantity(Quantity::Count(number)),
                (None, Some(number)) => Said::Quantity(Quantity::Signed(number)),
                (None, None) => Said::Real(number.as_f64().unwrap_or(f64::NAN)),
            },
            Self::Text(text) => cut(text),
            Self::Bool(on) => Said::Bool(*on),
            Self::Data(Bytes(bytes)) => Said::Bytes(bytes.get(..SHOWN).map_or_else(|| Arc::clone(bytes), Arc::from)),
        }
    }
}

/// Returns the value of a transfer for a finding, in the form of the expected one.
pub(super) fn found(transfer: &Transfer, expected: Option<&ExpectedValue>) -> Said {
    let kept = transfer.data.kept.as_slice();
    let bytes = || Said::Bytes(kept.get(..SHOWN).unwrap_or(kept).into());
    if let Some(ExpectedValue::Data(_)) = expected {
        return bytes();
    }
    match od::decode(transfer.data_type(), kept) {
        Read::Bool(on) => Said::Bool(on),
        Read::Signed(number) => Said::Quantity(Quantity::Signed(number)),
        Read::Unsigned(number) => Said::Quantity(Quantity::Count(number)),
        Read::Real(number) => Said::Real(number),
        Read::Text(text) => cut(text),
        Read::Bytes(units) if transfer.data_type() == Some(DataType::UnicodeString) => cut(&od::unicode(units)),
        Read::Time { .. } | Read::Difference { .. } | Read::Bytes(_) | Read::Empty => bytes(),
    }
}

fn cut(text: &str) -> Said {
    let end = text.char_indices().nth(SHOWN).map_or(text.len(), |(end, _)| end);
    Said::Text(text.get(..end).unwrap_or(text).into())
}

fn little_endian(bytes: &[u8]) -> Option<u64> {
    let fits = (1..=8).contains(&bytes.len());
    fits.then(|| bytes.iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte)))
}

/// Interprets a number of `bytes` bytes as signed.
fn signed(number: u64, bytes: usize) -> i64 {
    let unused = 64 - 8 * bytes.clamp(1, 8) as u32;
    (number << unused).cast_signed() >> unused
}

fn is_number(expected: &Number, data_type: Option<DataType>, bytes: &[u8]) -> bool {
    let Some(unsigned) = little_endian(bytes) else { return false };
    let typed = data_type.filter(|known| known.size() == Some(bytes.len()));
    let wanted = expected.as_f64().unwrap_or(f64::NAN);
    let single = || near(f64::from(f32::from_bits(unsigned as u32)), wanted, SINGLE);
    let double = || near(f64::from_bits(unsigned), wanted, DOUBLE);
    match typed {
        Some(DataType::Real32) => single(),
        Some(DataType::Real64) => double(),
        // A number with a decimal point is not an integer: without a type it may be a real.
        None if expected.is_f64() && bytes.len() == 4 => single() || is_integer(expected, typed, unsigned, bytes.len()),
        None if expected.is_f64() && bytes.len() == 8 => double() || is_integer(expected, typed, unsigned, bytes.len()),
        _ => is_integer(expected, typed, unsigned, bytes.len()),
    }
}

/// Compares an integer with its value by the type; or with its bits if no such number fits into the bytes.
fn is_integer(expected: &Number, typed: Option<DataType>, unsigned: u64, bytes: usize) -> bool {
    let wanted = match (expected.as_u64(), expected.as_i64(), expected.as_f64()) {
        (Some(number), ..) => i128::from(number),
        (None, Some(number), _) => i128::from(number),
        (None, None, Some(number)) if number.fract() == 0.0 && number.abs() < 1e18 => number as i128,
        _ => return false,
    };
    let (natural, integer) = (i128::from(unsigned), i128::from(signed(unsigned, bytes)));
    let half = 1_i128 << (8 * bytes.clamp(1, 8) - 1);
    match typed {
        Some(kind) if kind.is_signed() => wanted == integer || wanted >= half && wanted == natural,
        Some(_) => wanted == natural || wanted < 0 && wanted == integer,
        None => wanted == natural || wanted == integer,
    }
}

fn near(found: f64, wanted: f64, precision: f64) -> bool {
    found == wanted || (found - wanted).abs() <= wanted.abs() * precision
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;
    use crate::bytes::frame::{BusId, FrameRef};
    use crate::sdo::transfer::{Beginning, Direction, Mode, Status, TransferId};
    use crate::sdo::wire::Mux;

    fn transfer(index: u16, bytes: &[u8]) -> Transfer {
        let beginning = Beginning {
            id: TransferId(1),
            bus: BusId(0),
            node: 5,
            channel: None,
            extract: false,
            at: FrameRef::default(),
        };
        let mut made = Transfer::new(beginning, Direction::Download, Mode::Segmented, Some(Mux { index, sub: 0 }));
        made.append(bytes);
        made.outcome.status = Status::Ok;
        made
    }

    fn is(json: &str, index: u16, bytes: &[u8]) -> Same {
        let value: ExpectedValue = serde_json::from_str(json).unwrap();
        value.is_of(&transfer(index, bytes))
    }

    #[test]
    fn values() {
        // 1017h is UNSIGNED16, 6060h INTEGER8, 1008h text, 2000h not known.
        for (json, index, bytes, same) in [
            (r#"{"number":1000}"#, 0x1017, &[0xE8, 3][..], true),
            (r#"{"number":1000.0}"#, 0x1017, &[0xE8, 3], true),
            (r#"{"number":1000.5}"#, 0x1017, &[0xE8, 3], false),
            (r#"{"number":1000}"#, 0x1017, &[0xE8, 3, 0, 0], true),
            (r#"{"number":65535}"#, 0x1017, &[0xFF, 0xFF], true),
            (r#"{"number":-1}"#, 0x1017, &[0xFF, 0xFF], true),
            (r#"{"number":-1}"#, 0x1017, &[0xFE, 0xFF], false),
            (r#"{"number":-3}"#, 0x6060, &[0xFD], true),
            (r#"{"number":253}"#, 0x6060, &[0xFD], true),
            (r#"{"number":3}"#, 0x6060, &[0xFD], false),
            (r#"{"number":1.5}"#, 0x2000, &[0, 0, 0xC0, 0x3F], true),
            (r#"{"number":0.1}"#, 0x2000, &0.1_f32.to_le_bytes(), true),
            (r#"{"number":0.1}"#, 0x2000, &0.1_f64.to_le_bytes(), true),
            (r#"{"number":0.1}"#, 0x2000, &0.10001_f32.to_le_bytes(), false),
            (r#"{"number":18446744073709551615}"#, 0x2000, &[0xFF; 8], true),
            (r#"{"number":0}"#, 0x2000, &[], false),
            (r#"{"number":0}"#, 0x2000, &[0; 9], false),
            (r#"{"text":"abc"}"#, 0x1008, b"abc", true),
            (r#"{"text":"abc"}"#, 0x1008, b"abc\0\0", true),
            (r#"{"text":"abc"}"#, 0x1008, b"abcd", false),
            (r#"{"text":"abc"}"#, 0x1008, b"ab", false),
            (r#"{"text":""}"#, 0x1008, b"\0", true),
            (r#"{"bool":true}"#, 0x2000, &[1], true),
            (r#"{"bool":true}"#, 0x2000, &[2], true),
            (r#"{"bool":true}"#, 0x2000, &[2, 0], false),
            (r#"{"bool":false}"#, 0x2000, &[0, 0, 0, 0], true),
            (r#"{"data":"e803"}"#, 0x1017, &[0xE8, 3], true),
            (r#"{"data":"E803"}"#, 0x1017, &[0xE8, 3, 0], false),
            (r#"{"data":""}"#, 0x1017, &[], true),
        ] {
            assert_eq!(is(json, index, bytes), Same::from(same), "{json} {index:04X} {bytes:02X?}");
        }
        for json in [r#"{"data":"E80"}"#, r#"{"data":"x0"}"#, r#"{"number":"1"}"#, r#"{"other":1}"#, "1"] {
            assert!(serde_json::from_str::<ExpectedValue>(json).is_err(), "{json}");
        }
    }

    #[test]
    fn what_is_not_whole_cannot_be_decided() {
        let mut long = transfer(0x2000, &[0x41; 70_000]);
        let value = |json| serde_json::from_str::<ExpectedValue>(json).unwrap();
        assert_eq!(value(r#"{"text":"A"}"#).is_of(&long), Same::No);
        let same = format!(r#"{{"data":"{}"}}"#, "41".repeat(70_000));
        assert_eq!(value(&same).is_of(&long), Same::Unknown);
        long.data.hole = true;
        assert_eq!(value(r#"{"text":"A"}"#).is_of(&long), Same::Unknown);
    }
}

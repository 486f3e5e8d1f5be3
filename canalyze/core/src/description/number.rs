//! Numbers and values as files write them, read; and bytes of transfers, written as files have them.
//!
//! Numbers are decimal, hexadecimal (0x) or octal (leading 0); signed ones may be the two's complement of their width;
//! `$NODEID` may be a summand (CiA 306, 4.6 and 4.7). A value that has to be changed is noted as a defect, and one that
//! cannot be understood is none.

use super::ini::{Given, is_space};
use super::{DefectFact, Defects, FiledValue, short};
use crate::world::od::{self, DataType};

/// Maximum number of characters of a number.
const LONGEST: usize = 40;
const MOST_SUMMANDS: usize = 16;

/// An integer as a file has it.
pub(super) struct Whole {
    pub(super) value: i128,
    /// The defect of its spelling.
    odd: Option<&'static str>,
    decimal: bool,
    /// The node-ID is to be added.
    relative: bool,
}

/// Returns an integer without `$NODEID`.
pub(super) fn integer(text: &str) -> Option<Whole> {
    let bare = without_comment(text);
    let unsigned = bare.strip_prefix(['+', '-']).unwrap_or(bare);
    let hexadecimal = unsigned.strip_prefix("0x").or_else(|| unsigned.strip_prefix("0X"));
    let (digits, base) = hexadecimal.map_or((unsigned, 10), |digits| (digits, 16));
    if bare.len() > LONGEST || digits.is_empty() || !digits.chars().all(|digit| digit.is_digit(base)) {
        return None;
    }
    // A number beyond 128 bits fits no type.
    let magnitude = |base| i128::from_str_radix(digits, base).unwrap_or(i128::MAX);
    let (mut value, mut odd) = (magnitude(base), None);
    if base == 10 && digits.len() > 1 && digits.starts_with('0') && value > 7 {
        odd = Some("octal");
        if !digits.contains(['8', '9']) {
            value = magnitude(8);
        }
    }
    if bare.len() != text.len() {
        odd = Some("trailing-comment");
    }
    let value = if bare.starts_with('-') { -value } else { value };
    Some(Whole { value, odd, decimal: base == 10, relative: false })
}

/// Returns an integer that may have `$NODEID` among its summands, in any order and case.
fn with_node(text: &str) -> Option<Whole> {
    if !text.as_bytes().windows(6).any(|word| word.eq_ignore_ascii_case(b"NODEID")) {
        return integer(text);
    }
    let bare = without_comment(text);
    let mut odd = (bare.len() != text.len()).then_some("trailing-comment");
    let joined: String = bare.chars().filter(|c| !is_space(*c)).collect();
    let (mut nodes, mut offset, mut count, mut rest) = (0, 0_i128, 0, joined.as_str());
    while !rest.is_empty() {
        let unsigned = rest.strip_prefix(['+', '-']).unwrap_or(rest);
        let length = rest.len() - unsigned.len() + unsigned.find(['+', '-']).unwrap_or(unsigned.len());
        let (summand, behind) = rest.split_at_checked(length)?;
        rest = behind;
        count += 1;
        if count > MOST_SUMMANDS {
            return None;
        }
        let name = summand.strip_prefix('+').unwrap_or(summand);
        if name.strip_prefix('$').unwrap_or(name).eq_ignore_ascii_case("NODEID") {
            nodes += 1;
        } else {
            let number = integer(summand)?;
            offset = offset.saturating_add(number.value);
            odd = odd.or(number.odd);
        }
    }
    if nodes != 1 {
        return None;
    }
    if count > 2 || !joined.contains('$') || joined.contains('-') {
        odd = odd.or(Some("nodeid-form"));
    }
    Some(Whole { value: offset, odd, decimal: true, relative: true })
}

/// Returns the text before a comment behind a value.
pub(super) fn without_comment(text: &str) -> &str {
    let sign = text.find([';', '#']).into_iter().chain(text.find("//")).min();
    sign.and_then(|at| text.get(..at)).map_or(text, |bare| bare.trim_end_matches(is_space))
}

/// Notes a defect of a value. One of a copy is left to the original.
fn odd(given: Given<'_>, code: &'static str, fact: Option<(&'static str, DefectFact)>, defects: &mut Defects) {
    if given.line != 0 {
        let facts = [("key", given.name.into()), ("value", short(given.value).into())];
        defects.note(given.line, code, facts.into_iter().chain(fact).collect());
    }
}

/// Reads a count, a code, a flag: an integer of no particular type.
pub(super) fn whole(given: Option<Given<'_>>, defects: &mut Defects) -> Option<i128> {
    let given = given.filter(|given| !given.value.is_empty())?;
    let Some(number) = integer(given.value) else {
        odd(given, "not-a-number", None, defects);
        return None;
    };
    if let Some(code) = number.odd {
        odd(given, code, Some(("read", number.value.into())), defects);
    }
    Some(number.value)
}

/// Reads a value of a type; `None` if it is empty or cannot be used.
pub(super) fn value(given: Option<Given<'_>>, data_type: DataType, defects: &mut Defects) -> Option<FiledValue> {
    let given = given.filter(|given| !given.value.is_empty())?;
    match data_type {
        DataType::VisibleString | DataType::UnicodeString => Some(FiledValue::Text(given.value.to_owned())),
        DataType::OctetString | DataType::Domain => bytes(given, defects).map(FiledValue::Bytes),
        DataType::Real32 | DataType::Real64 => real_of(given, data_type, defects).map(FiledValue::Real),
        _ => number(given, data_type, defects).map(|number| match number.relative {
            true => FiledValue::Offset(number.value),
            false => FiledValue::Whole(number.value),
        }),
    }
}

/// Reads a number of no particular type that may have a fraction.
pub(super) fn real(given: Option<Given<'_>>, defects: &mut Defects) -> Option<f64> {
    real_of(given?, DataType::Real64, defects)
}

/// Reads a LowLimit or HighLimit, which may not depend on the node-ID.
pub(super) fn limit(given: Option<Given<'_>>, data_type: DataType, defects: &mut Defects) -> Option<FiledValue> {
    match data_type {
        DataType::VisibleString | DataType::UnicodeString | DataType::OctetString | DataType::Domain => None,
        _ => value(given, data_type, defects).filter(|value| !matches!(value, FiledValue::Offset(_))),
    }
}

fn number(given: Given<'_>, data_type: DataType, defects: &mut Defects) -> Option<Whole> {
    let Some(number) = with_node(given.value) else {
        odd(given, "not-a-number", None, defects);
        return None;
    };
    let bits = data_type.bits().unwrap_or(64);
    let fitted = fitted(number, data_type.is_signed(), bits);
    match &fitted {
        None => odd(given, "out-of-range", Some(("bits", i128::from(bits).into())), defects),
        Some(Whole { value, odd: Some(code), relative, .. }) => {
            let sign = if *value < 0 { "-" } else { "" };
            let read = match relative {
                true => format!("$NODEID+{sign}{:X}h", value.unsigned_abs()),
                false => value.to_string(),
            };
            odd(given, code, Some(("read", read.into())), defects);
        }
        Some(_) => {}
    }
    fitted
}

/// Returns the number in the range of its type; `None` if it does not fit into its bits.
fn fitted(number: Whole, signed: bool, bits: u8) -> Option<Whole> {
    let Whole { mut value, mut odd, decimal, relative } = number;
    let beyond = 1_i128 << bits;
    let fits = if signed {
        // Two's complement is the usual spelling if it is hexadecimal.
        if (beyond / 2..beyond).contains(&value) {
            value -= beyond;
            odd = odd.or(decimal.then_some("wrapped"));
        }
        (-beyond / 2..beyond / 2).contains(&value)
    } else {
        if (-beyond / 2..0).contains(&value) && bits > 1 && !relative {
            value += beyond;
            odd = odd.or(Some("wrapped"));
        }
        (0..beyond).contains(&value) || relative && (1 - beyond..beyond).contains(&value)
    };
    fits.then_some(Whole { value, odd, decimal, relative })
}

fn real_of(given: Given<'_>, data_type: DataType, defects: &mut Defects) -> Option<f64> {
    let bare = without_comment(given.value);
    let bits = data_type.bits().unwrap_or(64);
    let decimal = bare.parse::<f64>().ok();
    let pattern = integer(bare).map(|number| number.value).filter(|value| (0..1_i128 << bits).contains(value));
    let value = decimal.or(pattern.map(|pattern| match data_type {
        DataType::Real32 => f64::from(f32::from_bits(pattern as u32)),
        _ => f64::from_bits(pattern as u64),
    }));
    let code = match (decimal, pattern) {
        (None, Some(1..)) => Some("real-as-hex"),
        _ => (bare.len() != given.value.len()).then_some("trailing-comment"),
    };
    let Some(value) = value.filter(|value| value.is_finite()) else {
        odd(given, "not-a-number", None, defects);
        return None;
    };
    if let Some(code) = code {
        odd(given, code, Some(("read", DefectFact::Real(value))), defects);
    }
    Some(value)
}

fn bytes(given: Given<'_>, defects: &mut Defects) -> Option<Vec<u8>> {
    let bare = without_comment(given.value);
    // Exporters write this as the default of bytes or of a domain without one.
    if matches!(bare, "0" | "0x0") {
        return None;
    }
    let words = bare.split_ascii_whitespace().map(|word| from_hexadecimal(word.as_bytes()));
    let Some(data) = words.collect::<Option<Vec<_>>>().map(|words| words.concat()) else {
        odd(given, "not-bytes", None, defects);
        return None;
    };
    if bare.len() != given.value.len() {
        odd(given, "trailing-comment", Some(("read", hexadecimal(&data).into())), defects);
    }
    Some(data)
}

fn from_hexadecimal(digits: &[u8]) -> Option<Vec<u8>> {
    let digit = |byte: u8| char::from(byte).to_digit(16).map(|digit| digit as u8);
    let (pairs, rest) = digits.as_chunks::<2>();
    let bytes = pairs.iter().map(|[high, low]| Some(digit(*high)? << 4 | digit(*low)?));
    bytes.collect::<Option<Vec<u8>>>().filter(|_| rest.is_empty())
}

fn hexadecimal(data: &[u8]) -> String {
    data.iter().map(|byte| format!("{byte:02X}")).collect::<Vec<_>>().join(" ")
}

/// Returns a transferred value as a file has it; `None` for a wrong length, and for text that is not one printable line.
pub(super) fn spelled(data: &[u8], data_type: DataType) -> Option<String> {
    match data_type {
        DataType::VisibleString => line(&String::from_utf8_lossy(data)),
        DataType::UnicodeString => line(&super::encoding::utf16(data, u16::from_le_bytes)),
        DataType::OctetString | DataType::Domain => Some(hexadecimal(data)).filter(|text| !text.is_empty()),
        DataType::Real32 | DataType::Real64 => match od::decode(Some(data_type), data) {
            od::Value::Real(real) => real.is_finite().then(|| shortest(real)),
            _ => None,
        },
        _ => whole_of(data, data_type),
    }
}

fn line(text: &str) -> Option<String> {
    let text = text.trim_end_matches('\0');
    let fits = !text.is_empty() && text.trim() == text && text.chars().all(is_printable);
    fits.then(|| text.to_owned())
}

/// Returns true for letters, marks, signs and the space.
fn is_printable(c: char) -> bool {
    // Behind a letter only characters that cannot be shown are escaped, and the quotes.
    matches!(c, '\\' | '\'' | '"') || format!("a{c}").escape_debug().eq(['a', c])
}

/// Returns an integer of at most eight bytes whose value its type has.
fn whole_of(data: &[u8], data_type: DataType) -> Option<String> {
    let bits = u32::from(data_type.bits()?);
    if data.is_empty() || data.len() > 8 {
        return None;
    }
    let number = data.iter().rev().fold(0_u64, |number, byte| number << 8 | u64::from(*byte));
    if !data_type.is_signed() {
        return (u128::from(number) < 1_u128 << bits).then(|| format!("{number:#x}"));
    }
    let unused = 64 - 8 * data.len() as u32;
    let number = (number << unused).cast_signed() >> unused;
    (-(1_i128 << (bits - 1))..1_i128 << (bits - 1)).contains(&i128::from(number)).then(|| number.to_string())
}

/// Returns the shortest decimal number that is read as the same value.
fn shortest(real: f64) -> String {
    let scientific = format!("{real:e}");
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent = exponent.parse().unwrap_or(0);
    if !(-4..16).contains(&exponent) {
        return format!("{mantissa}e{}{:02}", if exponent < 0 { '-' } else { '+' }, i32::abs(exponent));
    }
    let plain = real.to_string();
    if plain.contains('.') { plain } else { plain + ".0" }
}

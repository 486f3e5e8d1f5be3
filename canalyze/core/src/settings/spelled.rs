//! The syntax of nodes, identifiers, objects, times and rates, on the command line and in files.
//!
//! COB-IDs and objects are hexadecimal; node-IDs are decimal, or hexadecimal with 0x. A text that cannot be read is
//! `None`; mistakes are not described here.

use std::collections::BTreeSet;

use crate::bytes::frame::CanId;
use crate::wire::cob_id::{Role, predefined};
use crate::wire::pdo::mapping_parameter;
use crate::world::profile_defaults;

/// Maximum number of PDOs of a node in a direction.
const PDOS: u16 = 512;
/// The range of 1006h and 1007h, which are UNSIGNED32 in microseconds.
pub(super) const LONGEST_US: u32 = u32::MAX;
/// Maximum number of digits before the point of an amount, and behind it.
const DIGITS: usize = 12;
/// Maximum length of a mapping, in bits.
const LONGEST_PDO: u64 = 64;

/// Returns true if these are at most `most` digits to this base.
fn are_digits(text: &str, base: u32, most: usize) -> bool {
    (1..=most).contains(&text.len()) && text.chars().all(|c| c.is_digit(base))
}

/// Returns the text without a prefix, in any case.
pub(super) fn without<'a>(text: &'a str, prefix: &str) -> Option<&'a str> {
    let (head, rest) = text.split_at_checked(prefix.len())?;
    head.eq_ignore_ascii_case(prefix).then_some(rest)
}

/// Returns hexadecimal digits without `0x` before them and `h` behind.
fn bare(text: &str) -> &str {
    let text = without(text, "0x").unwrap_or(text);
    text.strip_suffix(['h', 'H']).unwrap_or(text)
}

/// Returns a number whose count of hexadecimal digits is in this range; `0x` before them and `h` behind do not count.
pub(super) fn hexadecimal(text: &str, digits: std::ops::RangeInclusive<usize>) -> Option<u32> {
    let text = bare(text);
    let fits = digits.contains(&text.len()) && are_digits(text, 16, 8);
    fits.then(|| u32::from_str_radix(text, 16).ok()).flatten()
}

/// Reads a node-ID.
pub fn node(text: &str) -> Option<u8> {
    let number = match without(text, "0x") {
        Some(digits) if are_digits(digits, 16, 8) => u32::from_str_radix(digits, 16).ok()?,
        None if are_digits(text, 10, 8) => text.parse().ok()?,
        _ => return None,
    };
    u8::try_from(number).ok().filter(|node| (1..=127).contains(node))
}

/// Reads node-IDs: a list of single ones and of ranges such as `1-4`, each once.
pub fn nodes(text: &str) -> Option<Vec<u8>> {
    let mut found = Vec::new();
    for part in text.split(',') {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        let (low, high) = (node(first.trim())?, node(last.trim())?);
        if low > high {
            return None;
        }
        found.extend(low..=high);
    }
    Some(once(found))
}

/// Returns each element once, in the order of first occurrences.
pub(super) fn once<T: Clone + Ord>(all: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut seen = BTreeSet::new();
    all.into_iter().filter(|one| seen.insert(one.clone())).collect()
}

/// Reads an identifier of up to three hexadecimal digits, or of eight for the 29-bit format; true for the latter.
pub fn can_id(text: &str) -> Option<(u32, bool)> {
    let digits = without(text, "0x").unwrap_or(text);
    if !are_digits(digits, 16, 8) || (4..8).contains(&digits.len()) {
        return None;
    }
    let (value, extended) = (u32::from_str_radix(digits, 16).ok()?, digits.len() == 8);
    (value <= if extended { 0x1FFF_FFFF } else { 0x7FF }).then_some((value, extended))
}

/// Reads the name of a PDO, such as `TPDO1`: true for a TPDO, and its number.
pub fn pdo(text: &str) -> Option<(bool, u16)> {
    let (transmit, digits) = match (without(text, "tpdo"), without(text, "rpdo")) {
        (Some(digits), _) => (true, digits),
        (_, digits) => (false, digits?),
    };
    let number = are_digits(digits, 10, 3).then(|| digits.parse().ok()).flatten()?;
    (1..=PDOS).contains(&number).then_some((transmit, number))
}

/// Reads index and sub-index of an object, `1017:00` in hexadecimal (`1017h:0`, `0x1017:00`). Without a sub-index: all
/// of them.
pub fn address(text: &str) -> Option<(u16, Option<u8>)> {
    let (index, sub) = text.split_once(':').map_or((text, None), |(index, sub)| (index, Some(sub)));
    let index = hexadecimal(index, 4..=4).and_then(|index| u16::try_from(index).ok())?;
    let sub = match sub {
        Some(sub) => Some(hexadecimal(sub, 1..=2).and_then(|sub| u8::try_from(sub).ok())?),
        None => None,
    };
    Some((index, sub))
}

/// A PDO and the objects of its mapping parameter: index, sub-index, value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PdoMapping {
    /// Node-ID, 1..=127.
    pub node: u8,
    /// Transmit or receive, seen from the node.
    pub transmit: bool,
    /// PDO number, 1..=512.
    pub number: u16,
    /// The objects.
    pub objects: Vec<(u16, u8, u64)>,
}

/// Reads a PDO with its mapping, `185=6041:16,6064:32`: the PDO as an identifier of the pre-defined connection set or as
/// `5.TPDO1`, and `INDEX:BITS` or `INDEX:SUB:BITS` for each object, 1 to 64 bits in all.
pub fn pdo_mapping(text: &str) -> Option<PdoMapping> {
    let (named, mapping) = text.split_once('=')?;
    let (node, transmit, number) = match named.split_once('.') {
        Some((owner, name)) => {
            let (transmit, number) = pdo(name)?;
            (node(owner)?, transmit, number)
        }
        None => match can_id(named)
            .filter(|(_, extended)| !extended)
            .map(|(id, _)| predefined(CanId::standard(id as u16)))?
        {
            Role::Tpdo { node, number } => (node, true, number),
            Role::Rpdo { node, number } => (node, false, number),
            _ => return None,
        },
    };
    let entries: Vec<u64> = mapping.split(',').map(|entry| mapped(entry.trim())).collect::<Option<_>>()?;
    let bits: u64 = entries.iter().map(|entry| entry & 0xFF).sum();
    let index = mapping_parameter(transmit, number);
    let objects = std::iter::once(entries.len() as u64).chain(entries);
    let objects = (0u8..).zip(objects).map(|(sub, value)| (index, sub, value)).collect();
    (1..=LONGEST_PDO).contains(&bits).then_some(PdoMapping { node, transmit, number, objects })
}

/// Reads an entry of a mapping as it stands in 1600h and 1A00h.
fn mapped(text: &str) -> Option<u64> {
    let (object, length) = text.rsplit_once(':')?;
    let (index, sub) = address(object)?;
    let bits = are_digits(length, 10, 2).then(|| length.parse::<u64>().ok()).flatten()?;
    let entry = u64::from(index) << 16 | u64::from(sub.unwrap_or(0)) << 8 | bits;
    (1..=LONGEST_PDO).contains(&bits).then_some(entry)
}

/// Reads the number of a device profile whose default mappings are known.
pub fn profile(text: &str) -> Option<u16> {
    let number = are_digits(text, 10, 3).then(|| text.parse().ok()).flatten()?;
    profile_defaults::is_known(number).then_some(number)
}

/// Reads codes of rules, or their beginnings, separated by commas: `SDO001,HBT`; each once.
pub fn codes(text: &str) -> Option<Vec<String>> {
    let mut found = Vec::new();
    for part in text.split(',') {
        let code = part.trim().to_uppercase();
        let letters = code.chars().take_while(char::is_ascii_uppercase).count();
        let digits = code.get(letters..)?;
        if !(1..=3).contains(&letters) || !digits.is_empty() && (letters < 3 || !are_digits(digits, 10, 3)) {
            return None;
        }
        found.push(code);
    }
    Some(once(found))
}

/// Reads a time in microseconds, or with the suffix us, ms or s. Returns ns.
pub fn tolerance(text: &str) -> Option<i64> {
    let ns = |unit: &str| match unit {
        "" | "us" | "\u{b5}s" | "\u{3bc}s" => Some(1_000),
        "ms" => Some(1_000_000),
        "s" => Some(1_000_000_000),
        _ => None,
    };
    let (above, below) = amount(text, ns)?;
    if above > u128::from(LONGEST_US) * 1_000 * below {
        return None;
    }
    i64::try_from(rounded(above, below)).ok()
}

/// Reads a bit rate in bit/s, or with the suffix k or M. Rates below those of classic CAN are refused: 125 instead of
/// 125k is a slip.
pub fn bit_rate(text: &str) -> Option<u32> {
    let bits = |unit: &str| match unit {
        "" => Some(1),
        "k" => Some(1_000),
        "m" => Some(1_000_000),
        _ => None,
    };
    let (above, below) = amount(text, bits)?;
    let rate = u32::try_from(above.checked_div(below)?).ok()?;
    (above % below == 0 && (1_000..=1_000_000).contains(&rate)).then_some(rate)
}

/// Reads a number with a unit; `worth` is the value of the unit. Returns a fraction, so that 0.1 ms is exact.
fn amount(text: &str, worth: impl Fn(&str) -> Option<u128>) -> Option<(u128, u128)> {
    let end = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    let (number, unit) = text.split_at_checked(end)?;
    let (whole, decimals) = number.split_once('.').map_or((number, None), |(whole, rest)| (whole, Some(rest)));
    let whole_fits = are_digits(whole, 10, DIGITS) || whole.is_empty() && decimals.is_some();
    if !whole_fits || !decimals.is_none_or(|rest| are_digits(rest, 10, DIGITS)) {
        return None;
    }
    let decimals = decimals.unwrap_or_default();
    let digits: u128 = format!("{whole}{decimals}").parse().ok()?;
    let below = 10_u128.checked_pow(u32::try_from(decimals.len()).ok()?)?;
    Some((digits.checked_mul(worth(&unit.trim_start().to_lowercase())?)?, below))
}

/// Rounds a fraction to a whole number, half to even.
fn rounded(above: u128, below: u128) -> u128 {
    let (whole, twice) = (above / below, above % below * 2);
    whole + u128::from(twice > below || twice == below && whole % 2 == 1)
}

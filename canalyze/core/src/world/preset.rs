//! The PDOs that a device description presets, and its inconsistencies about them.
//!
//! Each is compiled as the bus does for a node whose node-ID is 0, so that an identifier that depends on the node-ID is
//! an offset to it. The syntax of files and names are not known here.

use std::sync::Arc;

use crate::wire::pdo::mapping::{Mapped, Mapping};
use crate::world::configuration::Provenance;
use crate::world::dictionary::Dictionary;
use crate::world::node::{CobId, Node, Pdo};
use crate::world::od::DataType;

/// Maximum number of entries of a mapping: of one bit each.
const MOST_ENTRIES: u8 = 64;
/// Bits of the payload of a classic frame.
pub const MOST_BITS: u16 = 64;

/// One PDO of a description.
#[derive(Clone, Debug)]
pub struct Preset {
    /// Its number, identifier and times, for node-ID 0.
    pub pdo: Pdo,
    /// The node-ID is to be added to the identifier.
    pub relative: bool,
    /// The description has no COB-ID: it is the one of the pre-defined connection set, or the PDO does not exist.
    pub assumed: bool,
    /// A multiplex PDO, which has no mapping; true for destination address mode.
    pub multiplex: Option<bool>,
    /// The mapped objects, as far as the description defines them.
    pub mapped: Vec<Mapped>,
}

/// An inconsistency of a description.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Doubt {
    /// The index of the object that is in doubt.
    pub index: u16,
    /// Its sub-index; `None`: the whole object.
    pub sub: Option<u8>,
    /// The kind of inconsistency.
    pub what: Doubted,
}

/// A kind of inconsistency.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Doubted {
    /// A COB-ID of 11 bits has further bits set.
    CobId {
        /// The entry.
        value: u64,
    },
    /// There is no mapping parameter.
    NoMapping,
    /// The number of entries is greater than the entries that it has.
    Count {
        /// The number given.
        said: u64,
        /// The number of entries that it has.
        found: usize,
    },
    /// All entries together are longer than a payload.
    Length {
        /// In bits.
        bits: u16,
    },
    /// The description lacks a mapped object, or does not allow such a dummy.
    Unknown {
        /// Index of the mapped object.
        index: u16,
        /// Sub-index of the mapped object.
        sub: u8,
    },
    /// A mapped object has another length.
    Size {
        /// Index of the mapped object.
        index: u16,
        /// Sub-index of the mapped object.
        sub: u8,
        /// Length of the entry.
        bits: u8,
        /// Length of the object.
        width: u8,
    },
}

/// Returns the PDOs of all communication parameters of a description, receive first, by number, with the
/// inconsistencies of each. `dummies` are codes of data types that it allows as dummies, beside integers.
pub fn presets(dictionary: &Arc<Dictionary>, dummies: &[u16]) -> Vec<(Preset, Vec<Doubt>)> {
    let mut node = Node::new(0);
    node.configuration.describe(Arc::clone(dictionary));
    node.compile_all();
    let described = node.pdos().iter().filter(|pdo| dictionary.has(pdo.communication()));
    described.map(|pdo| preset(pdo, dictionary, dummies)).collect()
}

fn preset(pdo: &Pdo, dictionary: &Dictionary, dummies: &[u16]) -> (Preset, Vec<Doubt>) {
    let mut doubts = Vec::new();
    let mut doubt = |index, sub, what| doubts.push(Doubt { index, sub, what });
    let (communication, index) = (pdo.communication(), pdo.mapping());
    let value = |index, sub| dictionary.get(index, sub).and_then(|object| object.preset_at(0));
    let entry = dictionary.get(communication, 1).and_then(|object| object.preset);
    let assumed = pdo.cob.1 == Provenance::Default;
    let relative = entry.map_or(assumed && pdo.cob.0.valid, |entry| entry.relative);
    if let Some(value) = entry.map(|entry| entry.value).filter(|value| !relative && CobId::is_beyond_standard(*value)) {
        doubt(communication, Some(1), Doubted::CobId { value });
    }
    if !dictionary.has(index) {
        doubt(communication, None, Doubted::NoMapping);
    }
    let count = value(index, 0);
    let multiplex = count.filter(|count| matches!(count, 254 | 255)).map(|count| count == 255);
    let said = if multiplex.is_some() { 0 } else { count.unwrap_or(u64::MAX).min(u64::from(MOST_ENTRIES)) as u8 };
    let found = (1..=said).filter(|sub| value(index, *sub).is_some()).count();
    if let Some(count) = count.filter(|_| found < usize::from(said)) {
        doubt(index, None, Doubted::Count { said: count, found });
    }
    // The position of the bits behind a missing entry is unknown.
    let words = (1..=said).map_while(|sub| Some((sub, value(index, sub)? as u32)));
    let (subs, words): (Vec<_>, Vec<_>) = words.filter(|(_, word)| *word != 0).unzip();
    let mapping = Mapping::from_words(&words);
    for (sub, entry) in subs.into_iter().zip(&mapping.entries) {
        if let Some(what) = odd(entry, dictionary, dummies) {
            doubt(index, Some(sub), what);
        }
    }
    if mapping.bits > MOST_BITS {
        doubt(index, None, Doubted::Length { bits: mapping.bits });
    }
    (Preset { pdo: pdo.clone(), relative, assumed, multiplex, mapped: mapping.entries }, doubts)
}

/// Returns the inconsistency of a mapped object or a dummy.
fn odd(&Mapped { index, sub, bits, dummy, .. }: &Mapped, dictionary: &Dictionary, dummies: &[u16]) -> Option<Doubted> {
    let object = dictionary.get(index, sub).filter(|_| !dummy);
    let data_type = if dummy { DataType::from_code(index) } else { object.and_then(|object| object.data_type()) };
    if object.is_none() && !(dummy && (dummies.contains(&index) || data_type.is_some_and(is_plain))) {
        return Some(Doubted::Unknown { index, sub });
    }
    let width = data_type.and_then(DataType::bits).filter(|width| *width != bits)?;
    Some(Doubted::Size { index, sub, bits, width })
}

/// Returns true if it skips bits in every device: an unsigned number.
fn is_plain(data_type: DataType) -> bool {
    data_type.bits().is_some() && !data_type.is_signed() && !matches!(data_type, DataType::Real32 | DataType::Real64)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;
    use crate::world::dictionary::{Access, Form, Object, Preset as Value};

    fn presets_of(values: &[(u16, u8, u16, u64, bool)]) -> Vec<(Preset, Vec<Doubted>)> {
        let object = |&(index, sub, data_type, value, relative): &(u16, u8, u16, u64, bool)| Object {
            index,
            sub,
            name: "x".into(),
            data_type,
            access: Access::Rw,
            preset: Some(Value { value, relative, configured: false }),
            mappable: true,
            unit: None,
            factor: 1.0,
        };
        let objects = values.iter().map(object).collect();
        let dictionary = Arc::new(Dictionary::new(String::new(), Form::Eds, String::new(), objects));
        let without_place = |(preset, doubts): (Preset, Vec<Doubt>)| {
            (preset, doubts.into_iter().map(|doubt| doubt.what).collect::<Vec<_>>())
        };
        presets(&dictionary, &[]).into_iter().map(without_place).collect()
    }

    #[test]
    fn identifiers() {
        let found = presets_of(&[
            (0x1400, 1, 7, 0x8000_0200, true),
            (0x1401, 2, 5, 255, false),
            (0x1404, 2, 5, 255, false),
            (0x1800, 1, 7, 0x0000_1181, false),
            (0x1801, 1, 7, 0x2001_2345, false),
            (0x1A05, 0, 5, 0, false),
        ]);
        let shown: Vec<_> = found
            .iter()
            .map(|(preset, _)| (&preset.pdo, preset.pdo.cob.0))
            .map(|(pdo, cob)| (pdo.transmit, pdo.number, cob.valid, cob.id.raw(), cob.id.is_extended()))
            .collect();
        assert_eq!(
            shown,
            [
                (false, 1, false, 0x200, false),
                (false, 2, true, 0x300, false),
                (false, 5, false, 0, false),
                (true, 1, true, 0x181, false),
                (true, 2, true, 0x1_2345, true),
            ]
        );
        let origins: Vec<_> = found.iter().map(|(preset, _)| (preset.relative, preset.assumed)).collect();
        assert_eq!(origins, [(true, false), (true, true), (false, true), (false, false), (false, false)]);
        assert_eq!(found[0].1, [Doubted::NoMapping]);
        assert_eq!(found[3].1, [Doubted::CobId { value: 0x1181 }, Doubted::NoMapping]);
        assert_eq!(found[4].1, [Doubted::NoMapping]);
    }

    #[test]
    fn mappings() {
        let mapped = |count: Option<u64>, words: &[u64]| {
            let mut values = vec![(0x1800, 1, 7, 0x181, false), (0x2000, 0, 6, 0, false), (0x2001, 0, 4, 0, false)];
            values.extend(count.map(|count| (0x1A00, 0, 5, count, false)));
            values.extend((1..).zip(words).map(|(sub, word)| (0x1A00, sub, 7, *word, false)));
            let (preset, doubts) = presets_of(&values).remove(0);
            let places: Vec<_> =
                preset.mapped.iter().map(|mapped| (mapped.index, mapped.offset, mapped.bits)).collect();
            (places, preset.multiplex, doubts)
        };
        let two = [0x2000_0010, 0x2001_0020];
        assert_eq!(mapped(Some(2), &two), (vec![(0x2000, 0, 16), (0x2001, 16, 32)], None, vec![]));
        assert_eq!(mapped(Some(1), &two).0, [(0x2000, 0, 16)]);
        assert_eq!(mapped(Some(0), &two), (vec![], None, vec![]));
        assert_eq!(mapped(None, &two).0.len(), 2);
        assert_eq!(mapped(Some(3), &two).2, [Doubted::Count { said: 3, found: 2 }]);
        assert_eq!(mapped(Some(254), &two), (vec![], Some(false), vec![]));
        assert_eq!(mapped(Some(255), &two).1, Some(true));
        let dummies = mapped(Some(3), &[0x0005_0008, 0, 0x2000_0010]);
        assert_eq!(dummies, (vec![(5, 0, 8), (0x2000, 8, 16)], None, vec![]));
        let (index, sub) = (0x0009, 0);
        assert_eq!(mapped(Some(1), &[0x0009_0008]).2, [Doubted::Unknown { index, sub }]);
        assert_eq!(mapped(Some(1), &[0x0004_0020]).2, [Doubted::Unknown { index: 4, sub }]);
        assert_eq!(mapped(Some(1), &[0x2003_0010]).2, [Doubted::Unknown { index: 0x2003, sub }]);
        assert_eq!(mapped(Some(1), &[0x2000_0008]).2, [Doubted::Size { index: 0x2000, sub, bits: 8, width: 16 }]);
        assert_eq!(mapped(Some(3), &[0x2001_0020; 3]).2, [Doubted::Length { bits: 96 }]);
    }
}

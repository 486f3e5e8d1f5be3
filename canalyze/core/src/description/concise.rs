//! Concise DCF (object 1F22h, CiA 302-3): values in the order in which a configuration manager writes them to a device.
//!
//! It has the number of entries (4 bytes), then of each entry index (2), sub-index (1), size (4) and data, the least byte
//! first. It has neither types nor names: those of the standard are used.

use std::collections::BTreeMap;

use super::ini::{Section, Sections};
use super::number::spelled;
use crate::words::Lang;
use crate::words::profiles::Profile;
use crate::words::terms::object_name;
use crate::world::od::DataType;

/// The first index that is no data type.
const FIRST_OBJECT: u16 = 0x1000;

/// A written value: index, sub-index and data.
type ConciseEntry<'a> = (u16, u8, &'a [u8]);

/// Returns the values that a concise DCF writes, in its order; `None` for other bytes.
pub(super) fn entries(data: &[u8]) -> Option<Vec<ConciseEntry<'_>>> {
    let (count, mut rest) = data.split_first_chunk::<4>()?;
    let count = u32::from_le_bytes(*count) as usize;
    let mut found = Vec::new();
    while !rest.is_empty() {
        let ([low, high, sub, size @ ..], behind) = rest.split_first_chunk::<7>()?;
        let index = u16::from_le_bytes([*low, *high]);
        let (data, behind) = behind.split_at_checked(u32::from_le_bytes(*size) as usize)?;
        if index < FIRST_OBJECT || found.len() == count {
            return None;
        }
        found.push((index, *sub, data));
        rest = behind;
    }
    (!found.is_empty() && found.len() == count).then_some(found)
}

/// Returns the sections of a DCF with the same values; of an object that is written twice the last one counts.
pub(super) fn sections(entries: &[ConciseEntry<'_>]) -> Sections {
    let mut objects: BTreeMap<u16, BTreeMap<u8, &[u8]>> = BTreeMap::new();
    for (index, sub, data) in entries {
        objects.entry(*index).or_default().insert(*sub, data);
    }
    let mut sections = Sections::default();
    for (index, subs) in objects {
        let head = format!("{index:04X}");
        if let (Some(data), 1) = (subs.get(&0), subs.len()) {
            sections.put(section(&head, "7", index, 0, data));
            continue;
        }
        let standard = object_name(Lang::En, Profile::of(0), index, 0);
        let name = standard.map_or_else(|| format!("{head}h"), str::to_owned);
        sections.put(Section::of(&head, 0, &[("ObjectType", "9"), ("ParameterName", &name)]));
        for (sub, data) in subs {
            sections.put(section(&format!("{head}sub{sub:X}"), "", index, sub, data));
        }
    }
    sections
}

/// Returns the code of a data type.
fn code(of: DataType) -> u16 {
    (0..0x20).find(|code| DataType::from_code(*code) == Some(of)).unwrap_or_default()
}

fn section(title: &str, object_type: &str, index: u16, sub: u8, data: &[u8]) -> Section {
    let profile = Profile::of(0);
    let standard = object_name(Lang::En, profile, index, sub);
    let name = standard.map_or_else(|| format!("{index:04X}h:{sub:02X}"), str::to_owned);
    let other = if data.is_ascii() { DataType::VisibleString } else { DataType::OctetString };
    let by_width = match data.len() {
        1 => DataType::Unsigned8,
        2 => DataType::Unsigned16,
        3 => DataType::Unsigned24,
        4 => DataType::Unsigned32,
        5 => DataType::Unsigned40,
        6 => DataType::Unsigned48,
        7 => DataType::Unsigned56,
        8 => DataType::Unsigned64,
        _ => other,
    };
    let types = [profile.data_type(index, sub), Some(by_width), Some(DataType::OctetString)].into_iter().flatten();
    let fits = |data_type: &DataType| data_type.size().is_none_or(|size| size == data.len());
    let found = types.filter(fits).find_map(|data_type| Some((data_type, spelled(data, data_type)?)));
    let (data_type, value) = found.unwrap_or((DataType::OctetString, String::new()));
    let keys = [
        ("ObjectType", object_type),
        ("ParameterName", &name),
        ("DataType", &format!("{:#06x}", code(data_type))),
        ("AccessType", "rw"),
        ("ParameterValue", &value),
    ];
    Section::of(title, 0, keys.get(usize::from(object_type.is_empty())..).unwrap_or_default())
}

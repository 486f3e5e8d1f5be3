//! CompactPDO of a description as the keys of the objects that exist by it alone (CiA 306, 4.5.2).

use super::ini::Section;
use crate::wire::pdo::{communication_parameter, mapping_parameter, predefined_id};
use crate::world::node::CobId;

/// Sub-indices 1 to 6 of a communication parameter, with their types.
const SUBS: [(&str, &str); 6] = [
    ("COB-ID", "0x0007"),
    ("Transmission type", "0x0005"),
    ("Inhibit time", "0x0006"),
    ("Compatibility entry", "0x0005"),
    ("Event timer", "0x0006"),
    ("SYNC start value", "0x0005"),
];
/// Maximum number of PDOs of each direction.
const MOST_PDOS: i128 = 512;
const MOST_MAPPED: u8 = 64;

/// An object: index, name, and the keys of each sub-index.
type Implied = (u16, String, Vec<(u8, Section)>);

/// Returns the objects that the numbers of RPDOs and TPDOs imply, beside those that exist; bit k-1 of the mask stands
/// for sub-index k.
pub(super) fn implied(mask: i128, numbers: (i128, i128), exists: impl Fn(u16) -> bool) -> Vec<Implied> {
    let mask = mask as u8 & 0x3F;
    let mut found = Vec::new();
    if mask == 0 {
        return found;
    }
    for (direction, transmit, count) in [("RPDO", false, numbers.0), ("TPDO", true, numbers.1)] {
        for number in 1..=count.clamp(0, MOST_PDOS) as u16 {
            let (communication, mapping) =
                (communication_parameter(transmit, number), mapping_parameter(transmit, number));
            if !exists(communication) {
                let highest = (8 - mask.leading_zeros()).to_string();
                let mut subs = vec![(0, keys("Highest sub-index supported", "0x0005", "const", &highest))];
                for (sub, (name, data_type)) in (1..).zip(SUBS).filter(|(sub, _)| mask & 1 << (sub - 1) != 0) {
                    let default = if sub == 1 { preset_cob_id(transmit, number) } else { String::new() };
                    subs.push((sub, keys(name, data_type, "rw", &default)));
                }
                found.push((communication, format!("{direction} communication parameter"), subs));
            }
            if !exists(mapping) {
                let mut subs = vec![(0, keys("Number of mapped objects", "0x0005", "rw", "0"))];
                let mapped = |sub| (sub, keys(&format!("Application object {sub}"), "0x0007", "rw", ""));
                subs.extend((1..=MOST_MAPPED).map(mapped));
                found.push((mapping, format!("{direction} mapping parameter"), subs));
            }
        }
    }
    found
}

/// Returns the COB-ID of a PDO in the pre-defined connection set as a file has it; invalid from the fifth PDO on.
fn preset_cob_id(transmit: bool, number: u16) -> String {
    let base = predefined_id(transmit, number);
    base.map_or_else(|| format!("{:#x}", CobId::INVALID), |base| format!("$NODEID+{base:#x}"))
}

fn keys(name: &str, data_type: &str, access: &str, default: &str) -> Section {
    let keys = [("ParameterName", name), ("DataType", data_type), ("AccessType", access), ("DefaultValue", default)];
    Section::of(name, 0, &keys)
}

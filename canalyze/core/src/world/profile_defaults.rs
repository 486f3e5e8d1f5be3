//! The default mappings of device profiles, for nodes without a description whose profile the user has named.

use crate::wire::pdo::mapping_parameter;

/// The default mapping of a PDO: its number, true for a TPDO, and its entries as in 1600h or 1A00h.
type DefaultMapping = (u16, bool, &'static [u32]);

/// The default mappings of CiA 401 for the first four PDOs, each of them with eight bytes.
const OF_IO: &[DefaultMapping] = &[
    (
        1,
        false,
        &[0x6200_0108, 0x6200_0208, 0x6200_0308, 0x6200_0408, 0x6200_0508, 0x6200_0608, 0x6200_0708, 0x6200_0808],
    ),
    (2, false, &[0x6411_0110, 0x6411_0210, 0x6411_0310, 0x6411_0410]),
    (3, false, &[0x6411_0510, 0x6411_0610, 0x6411_0710, 0x6411_0810]),
    (4, false, &[0x6411_0910, 0x6411_0A10, 0x6411_0B10, 0x6411_0C10]),
    (
        1,
        true,
        &[0x6000_0108, 0x6000_0208, 0x6000_0308, 0x6000_0408, 0x6000_0508, 0x6000_0608, 0x6000_0708, 0x6000_0808],
    ),
    (2, true, &[0x6401_0110, 0x6401_0210, 0x6401_0310, 0x6401_0410]),
    (3, true, &[0x6401_0510, 0x6401_0610, 0x6401_0710, 0x6401_0810]),
    (4, true, &[0x6401_0910, 0x6401_0A10, 0x6401_0B10, 0x6401_0C10]),
];

/// The default mappings of CiA 402 for the first four PDOs: controlword and statusword, with the mode of operation, the
/// position and the velocity.
const OF_DRIVE: &[DefaultMapping] = &[
    (1, false, &[0x6040_0010]),
    (2, false, &[0x6040_0010, 0x6060_0008]),
    (3, false, &[0x6040_0010, 0x607A_0020]),
    (4, false, &[0x6040_0010, 0x60FF_0020]),
    (1, true, &[0x6041_0010]),
    (2, true, &[0x6041_0010, 0x6061_0008]),
    (3, true, &[0x6041_0010, 0x6064_0020]),
    (4, true, &[0x6041_0010, 0x606C_0020]),
];

/// Returns true if the default mappings of a profile are known.
pub fn is_known(number: u16) -> bool {
    PROFILES.iter().any(|(known, _)| *known == number)
}

/// The profiles whose default mappings are known, with them.
const PROFILES: &[(u16, &[DefaultMapping])] = &[(401, OF_IO), (402, OF_DRIVE)];

/// Returns the objects of a profile's default mappings with their values.
pub(super) fn objects(number: u16) -> impl Iterator<Item = ((u16, u8), u64)> {
    let mappings = PROFILES.iter().filter(move |(of, _)| *of == number).flat_map(|(_, mappings)| *mappings);
    let objects = mappings.flat_map(|(pdo, transmit, entries)| {
        let index = mapping_parameter(*transmit, *pdo);
        let count = std::iter::once(((index, 0), entries.len() as u64));
        count.chain((1u8..).zip(*entries).map(move |(sub, entry)| ((index, sub), u64::from(*entry))))
    });
    objects.chain(std::iter::once(((0x1000, 0), u64::from(number))))
}

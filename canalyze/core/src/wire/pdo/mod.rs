//! PDO (CiA 301, 7.2.2): process data. A mapping gives the bytes of an ordinary PDO their meaning; a multiplex PDO
//! carries its own address.
//!
//! | bytes of an MPDO | field |
//! |---|---|
//! | 0 | bit 7: 1 = destination address mode (DAM), 0 = source address mode (SAM); bits 6..0: node-ID |
//! | 1-2 | index |
//! | 3 | sub-index |
//! | 4-7 | data |
//!
//! The mapping parameter marks a multiplex PDO (sub-index 0 = 254 SAM, 255 DAM), its frame does not. So
//! `wire::decode` never yields an MPDO: the bus asks for one by the mapping.

pub mod mapping;
pub mod multiplexed;

pub use self::multiplexed::{Multiplexed, multiplexed};
use crate::bytes::frame::Frame;
use crate::wire::message::{Flaw, Message};

/// Maximum number of PDOs of each direction of a node.
pub const MOST: u16 = 512;
/// Number of PDOs of each direction with pre-defined COB-IDs.
pub const PREDEFINED: u16 = 4;

/// Returns the message of a frame that its mapping declares a multiplex PDO.
pub fn decode_multiplexed(
    role: crate::wire::cob_id::Role,
    transmit: bool,
    number: u16,
    node: u8,
    frame: &Frame,
) -> Message {
    match multiplexed(frame.payload()) {
        Some(content) => Message::Mpdo { transmit, number, node, content },
        None => Message::Malformed { role, flaw: Flaw::Length { least: 8, most: 8 } },
    }
}

/// Returns the index of a PDO's communication parameter: 1400h + n-1 or 1800h + n-1.
pub fn communication_parameter(transmit: bool, number: u16) -> u16 {
    (if transmit { 0x1800 } else { 0x1400 }) + number.clamp(1, MOST) - 1
}

/// Returns the index of a PDO's mapping parameter: 1600h + n-1 or 1A00h + n-1.
pub fn mapping_parameter(transmit: bool, number: u16) -> u16 {
    communication_parameter(transmit, number) + 0x200
}

/// Returns the base of the pre-defined identifier of one of the first four PDOs, without node-ID (CiA 301, 7.3.5).
pub fn predefined_id(transmit: bool, number: u16) -> Option<u16> {
    let first = if transmit { 0x180 } else { 0x200 };
    (1..=PREDEFINED).contains(&number).then(|| first + 0x100 * (number - 1))
}

/// Returns the PDO of a communication or mapping parameter: true for transmit, and the number.
pub fn of_parameter(index: u16) -> Option<(bool, u16)> {
    matches!(index, 0x1400..=0x1BFF).then_some((index >= 0x1800, (index & (MOST - 1)) + 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn destination_and_source_address_mode() {
        let content = Multiplexed { destination: true, node: 10, index: 0x2000, sub: 1, data: [42, 0, 0, 0] };
        assert_eq!(multiplexed(&[0x8A, 0x00, 0x20, 0x01, 0x2A, 0, 0, 0]), Some(content));
        let content = Multiplexed { destination: false, ..content };
        assert_eq!(multiplexed(&[0x0A, 0x00, 0x20, 0x01, 0x2A, 0, 0, 0]), Some(content));
        assert_eq!(multiplexed(&[0x0A, 0x00, 0x20, 0x01]), None);
    }

    #[test]
    fn parameters() {
        assert_eq!(communication_parameter(true, 1), 0x1800);
        assert_eq!(mapping_parameter(false, 512), 0x17FF);
        assert_eq!(mapping_parameter(true, 0), 0x1A00);
        let predefined = |transmit| (0..=5).filter_map(|number| predefined_id(transmit, number)).collect::<Vec<_>>();
        assert_eq!(predefined(true), [0x180, 0x280, 0x380, 0x480]);
        assert_eq!(predefined(false), [0x200, 0x300, 0x400, 0x500]);
    }
}

//! EMCY, the emergency object (CiA 301, 7.2.7): sent once when an error appears or goes.
//!
//! | bytes | field |
//! |---|---|
//! | 0-1 | emergency error code; 00xx: error reset or no error |
//! | 2 | error register, a copy of 1001h |
//! | 3-7 | manufacturer-specific |
//!
//! The words for codes and register bits are terms; of which profile the device is, is the bus's part.

use super::length;
use crate::wire::cob_id::Role;
use crate::wire::message::{Errors, Message};
use crate::words::profiles::Profile;

/// Decodes a frame on a node's EMCY identifier.
pub fn decode(role: Role, node: u8, payload: &[u8]) -> Message {
    let [low, high, register, a, b, c, d, e] = *payload else {
        return length(role, 8, 8);
    };
    Message::Emcy {
        node,
        code: u16::from_le_bytes([low, high]),
        profile: Profile::UNKNOWN,
        register,
        manufacturer: [a, b, c, d, e],
        active: Errors::default(),
        cleared: Errors::default(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn emcy(code: u16, register: u8, manufacturer: [u8; 5]) -> Message {
        let (active, cleared) = (Errors::default(), Errors::default());
        Message::Emcy { node: 10, code, profile: Profile::UNKNOWN, register, manufacturer, active, cleared }
    }

    #[test]
    fn frames() {
        assert_eq!(
            decode(Role::Emcy(10), 10, &[0x30, 0x81, 0x11, 0x05, 0, 0, 0, 0]),
            emcy(0x8130, 0x11, [5, 0, 0, 0, 0])
        );
        assert_eq!(decode(Role::Emcy(10), 10, &[0; 8]), emcy(0, 0, [0; 5]));
        assert_eq!(decode(Role::Emcy(10), 10, &[0x30, 0x81]), length(Role::Emcy(10), 8, 8));
    }
}

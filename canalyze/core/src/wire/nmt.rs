//! NMT node control (CiA 301, 7.2.8.3.1): the master commands a node or all nodes. Never confirmed.
//!
//! | byte | field |
//! |---|---|
//! | 0 | command specifier: 01 start, 02 stop, 80 enter pre-operational, 81 reset node, 82 reset communication |
//! | 1 | node-ID 1..127, 0 = all nodes |
//!
//! An unknown command or a node-ID above 127 is still an NMT frame; only another length is not.

use super::length;
use crate::wire::cob_id::Role;
use crate::wire::message::Message;

/// Start remote node: to Operational.
pub const START: u8 = 0x01;
/// Stop remote node: to Stopped.
pub const STOP: u8 = 0x02;
/// Enter Pre-operational.
pub const PRE_OPERATIONAL: u8 = 0x80;
/// Reset node: to Initialisation, application included.
pub const RESET_NODE: u8 = 0x81;
/// Reset communication: to Initialisation, communication profile area only.
pub const RESET_COMMUNICATION: u8 = 0x82;

/// Whether a command resets the node, or its communication at least.
pub const fn is_reset(command: u8) -> bool {
    matches!(command, RESET_NODE | RESET_COMMUNICATION)
}

/// Decodes a frame on 000.
pub fn decode(role: Role, payload: &[u8]) -> Message {
    match *payload {
        [command, node] => Message::Nmt { command, node },
        _ => length(role, 2, 2),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames() {
        assert_eq!(decode(Role::Nmt, &[0x01, 0x0A]), Message::Nmt { command: START, node: 10 });
        assert_eq!(decode(Role::Nmt, &[0x82, 0x00]), Message::Nmt { command: RESET_COMMUNICATION, node: 0 });
        assert_eq!(decode(Role::Nmt, &[0x50, 0xC8]), Message::Nmt { command: 0x50, node: 200 });
        assert_eq!(decode(Role::Nmt, &[0x01]), length(Role::Nmt, 2, 2));
        assert_eq!(decode(Role::Nmt, &[0x01, 0x0A, 0x00]), length(Role::Nmt, 2, 2));
    }
}

//! NMT error control (CiA 301, 7.2.8.3.2 and 7.2.8.3.3): boot-up, heartbeat and the answer to node guarding.
//!
//! | byte | field |
//! |---|---|
//! | 0 | bit 7: toggle bit of node guarding, 0 in a heartbeat; bits 6..0: NMT state, 00 = boot-up |
//!
//! A value without bit 7 may be either of the two protocols: which one runs is seen from the history, not here.

use super::length;
use crate::wire::cob_id::Role;
use crate::wire::message::Message;

/// Initialisation: sent once, as the boot-up message.
pub const BOOT_UP: u8 = 0x00;
/// Stopped.
pub const STOPPED: u8 = 0x04;
/// Operational.
pub const OPERATIONAL: u8 = 0x05;
/// Pre-operational.
pub const PRE_OPERATIONAL: u8 = 0x7F;

/// Decodes a data frame on a node's error-control identifier.
pub fn decode(role: Role, node: u8, payload: &[u8]) -> Message {
    match *payload {
        [BOOT_UP] => Message::BootUp { node },
        [byte] => {
            let toggle = byte & 0x80 != 0;
            Message::Heartbeat { node, state: byte & 0x7F, toggle, guarding: toggle, previous: None }
        }
        _ => length(role, 1, 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames() {
        let decode = |payload: &[u8]| decode(Role::ErrorControl(10), 10, payload);
        let shows = |state, toggle| Message::Heartbeat { node: 10, state, toggle, guarding: toggle, previous: None };
        assert_eq!(decode(&[0x00]), Message::BootUp { node: 10 });
        assert_eq!(decode(&[0x05]), shows(OPERATIONAL, false));
        assert_eq!(decode(&[0x7F]), shows(PRE_OPERATIONAL, false));
        assert_eq!(decode(&[0xFF]), shows(PRE_OPERATIONAL, true));
        assert_eq!(decode(&[0x85]), shows(OPERATIONAL, true));
        assert_eq!(decode(&[]), length(Role::ErrorControl(10), 1, 1));
        assert_eq!(decode(&[0x05, 0x00]), length(Role::ErrorControl(10), 1, 1));
    }
}

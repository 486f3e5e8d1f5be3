//! Flying master (CiA 302-2): which of several NMT masters is the active one is negotiated on 071..076.
//!
//! | CAN-ID | meaning | bytes |
//! |---|---|---|
//! | 071 | the active NMT master answers | 0: priority (0 is the highest), 1: node-ID |
//! | 072 | NMT flying-master negotiation request | - |
//! | 073 | request: who is the active NMT master? | - |
//! | 074 | answer: a device capable of NMT master is present | - |
//! | 075 | request: are there devices capable of NMT master? | - |
//! | 076 | force a flying-master negotiation | - |

use super::length;
use crate::wire::cob_id::Role;
use crate::wire::message::Message;

/// Decodes a frame on 070h + `kind`.
pub fn decode(role: Role, kind: u8, payload: &[u8]) -> Message {
    match (kind, payload) {
        (1, &[priority, node]) => Message::FlyingMaster { kind, master: Some((priority, node)) },
        (1, _) => length(role, 2, 2),
        (_, []) => Message::FlyingMaster { kind, master: None },
        _ => length(role, 0, 0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames() {
        let decode = |kind, payload: &[u8]| decode(Role::FlyingMaster(kind), kind, payload);
        assert_eq!(decode(1, &[0, 1]), Message::FlyingMaster { kind: 1, master: Some((0, 1)) });
        assert_eq!(decode(3, &[]), Message::FlyingMaster { kind: 3, master: None });
        assert_eq!(decode(1, &[]), length(Role::FlyingMaster(1), 2, 2));
        assert_eq!(decode(6, &[1]), length(Role::FlyingMaster(6), 0, 0));
    }
}

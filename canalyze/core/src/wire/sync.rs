//! SYNC (CiA 301, 7.2.5): the beat of the synchronous PDOs.
//!
//! | byte | field |
//! |---|---|
//! | 0 | counter, 1..240; present only where 1019h is not 0 |
//!
//! Whether the counter runs on as it should is the bus's question: it needs the frame before and 1019h.

use super::length;
use crate::wire::cob_id::Role;
use crate::wire::message::Message;

/// Decodes a frame on the SYNC identifier.
pub fn decode(role: Role, payload: &[u8]) -> Message {
    match *payload {
        [] => Message::Sync { counter: None },
        [counter] => Message::Sync { counter: Some(counter) },
        _ => length(role, 0, 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn with_and_without_counter() {
        assert_eq!(decode(Role::Sync, &[]), Message::Sync { counter: None });
        for counter in [1, 2, 3, 4, 1] {
            assert_eq!(decode(Role::Sync, &[counter]), Message::Sync { counter: Some(counter) });
        }
        assert_eq!(decode(Role::Sync, &[1, 2]), length(Role::Sync, 0, 1));
    }
}

//! SYNC (CiA 301, 7.2.5): the beat of the synchronous PDOs.
//!
//! Whether the counter continues as it should depends on the frame before and on 1019h, and is the bus's part.

use super::fields::line;
use super::prelude::*;

/// The counter, 1..=240; absent if 1019h is 0.
static COUNTER: &[FieldRow] = &[field(
    0,
    1,
    ("同步计数器 (1019h不为0时才有)", "synchronous counter (only if 1019h is not 0)"),
    Decimal,
    &[JsonKey::Decimal("counter")],
)];

/// Decodes a frame on the SYNC identifier.
pub fn decode(role: Role, payload: &[u8]) -> Message {
    match *payload {
        [] => Message::Sync { counter: None },
        [counter] => Message::Sync { counter: Some(counter) },
        _ => length(role, 0, 1),
    }
}

/// The forms of SYNC.
pub(super) struct SyncService;

impl WireService for SyncService {
    fn line(&self, out: &mut Vec<u8>, lang: Lang, full: bool, message: &Message, _: &Frame) {
        put!(out; Named(lang, Role::Sync));
        if let (true, Message::Sync { counter: Some(counter) }) = (full, *message) {
            put!(out; lang.pick(": 计数=", ": counter="), counter);
        }
    }

    fn breakdown(&self, out: &mut Vec<u8>, lang: Lang, message: &Message, frame: &Frame) {
        match frame.len {
            0 => {
                line!(out; lang.pick("无数据: 不带同步计数器 (1019h = 0)", "no data: no synchronous counter (1019h = 0)"))
            }
            _ => fields::breakdown(out, lang, COUNTER, message, frame),
        }
    }

    fn json(&self, object: &mut Object<'_>, message: &Message, frame: &Frame) {
        match frame.len {
            0 => object.maybe("counter", None::<u8>),
            _ => fields::json(object, COUNTER, message, frame),
        }
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

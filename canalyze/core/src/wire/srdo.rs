//! SRDO, safety-relevant data objects, and the global fail-safe command (CiA 304, EN 50325-5).
//!
//! | CAN-ID | length | content |
//! |---|---|---|
//! | odd, 101..17F | 1-8 | safety data |
//! | the next even one, 102..180 | the same | the same data, each bit inverted |
//! | 001 | 0 | GFC |
//!
//! Whether the two frames of a pair fit (inversion, delay) is the bus's question: it needs both.

use super::fields::line;
use super::prelude::*;

/// Decodes one frame of an SRDO pair.
pub fn decode(role: Role, number: u8, inverted: bool, payload: &[u8]) -> Message {
    if (1..=8).contains(&payload.len()) { Message::Srdo { number, inverted, valid: None } } else { length(role, 1, 8) }
}

/// Decodes a frame on 001.
pub fn decode_gfc(role: Role, payload: &[u8]) -> Message {
    if payload.is_empty() { Message::Gfc } else { length(role, 0, 0) }
}

/// The forms of safety data and of GFC.
pub(super) struct SrdoService;

impl WireService for SrdoService {
    fn line(&self, out: &mut Vec<u8>, lang: Lang, full: bool, message: &Message, frame: &Frame) {
        put!(out; Named(lang, message.role()));
        if let (true, Message::Srdo { valid, .. }) = (full, *message) {
            put!(out; ": ", Size(lang, frame.len.into()), match valid {
                Some(true) => lang.pick(", 与正常数据一致", ", the inverse of the normal data"),
                Some(false) => lang.pick(", 与正常数据不一致", ", not the inverse of the normal data"),
                None => "",
            });
        }
    }

    fn breakdown(&self, out: &mut Vec<u8>, lang: Lang, message: &Message, frame: &Frame) {
        match message {
            Message::Gfc => line!(out; lang.pick("无数据", "no data")),
            _ => fields::data(out, lang, frame.payload()),
        }
    }

    fn json(&self, object: &mut Object<'_>, message: &Message, _: &Frame) {
        let Message::Srdo { number, inverted, valid } = *message else { return };
        object.number("number", number);
        object.flag("inverted", inverted);
        object.maybe("valid", valid.map(|valid| if valid { "true" } else { "false" }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames() {
        let role = Role::Srdo { number: 1, inverted: true };
        assert_eq!(decode(role, 1, true, &[0xFE]), Message::Srdo { number: 1, inverted: true, valid: None });
        assert_eq!(decode(role, 1, true, &[]), length(role, 1, 8));
        assert_eq!(decode_gfc(Role::Gfc, &[]), Message::Gfc);
        assert_eq!(decode_gfc(Role::Gfc, &[0]), length(Role::Gfc, 0, 0));
    }
}

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

use super::prelude::*;

static KINDS: &[Term<u8>] = words!("flying_master");

static ANSWER: &[FieldRow] = &[
    field(0, 1, ("优先级 (0最高)", "priority (0 is the highest)"), Breakdown::Decimal, &[JsonKey::Decimal("priority")]),
    field(
        1,
        1,
        ("", ""),
        Breakdown::Only(|out, lang, read| fields::node_id(out, lang, read.byte())),
        &[JsonKey::Decimal("master")],
    ),
];

/// Decodes a frame on 070h + `kind`.
pub fn decode(role: Role, kind: u8, payload: &[u8]) -> Message {
    match (kind, payload) {
        (1, &[priority, node]) => Message::FlyingMaster { kind, master: Some((priority, node)) },
        (1, _) => length(role, 2, 2),
        (_, []) => Message::FlyingMaster { kind, master: None },
        _ => length(role, 0, 0),
    }
}

/// The forms of the flying master's messages.
pub(super) struct FlyingMasterService;

impl WireService for FlyingMasterService {
    fn line(&self, out: &mut Vec<u8>, lang: Lang, full: bool, message: &Message, _: &Frame) {
        let Message::FlyingMaster { kind, master } = *message else { return };
        let kind = find(KINDS, lang, kind).unwrap_or(lang.pick("未知报文", "unknown message"));
        put!(out; lang.pick("飞行主站: ", "flying master: "), kind);
        if let (true, Some((priority, node))) = (full, master) {
            say!(out, lang; zh: ": 节点", node, ", 优先级=", priority; en: ": node ", node, ", priority=", priority);
        }
    }

    fn breakdown(&self, out: &mut Vec<u8>, lang: Lang, message: &Message, frame: &Frame) {
        if frame.len > 0 {
            return fields::breakdown(out, lang, ANSWER, message, frame);
        }
        put!(out; "#   ");
        self.line(out, lang, true, message, frame);
        put!(out; "\n");
    }

    fn json(&self, object: &mut Object<'_>, message: &Message, frame: &Frame) {
        let Message::FlyingMaster { kind, master } = *message else { return };
        object.number("kind", kind);
        match master {
            Some(_) => fields::json(object, ANSWER, message, frame),
            None => ["priority", "master"].into_iter().for_each(|key| object.maybe(key, None::<u8>)),
        }
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

//! NMT error control (CiA 301, 7.2.8.3.2 and 7.2.8.3.3): boot-up, heartbeat, and node guarding with its answer.
//!
//! The one byte has the toggle bit of node guarding in bit 7, 0 in a heartbeat, and the NMT state in bits 6..0, 00 for
//! boot-up. A value without bit 7 fits both protocols: only the history shows which of them runs.

use super::prelude::*;

/// Initialisation: sent once, as the boot-up message.
pub const BOOT_UP: u8 = 0x00;
/// Stopped.
pub const STOPPED: u8 = 0x04;
/// Operational.
pub const OPERATIONAL: u8 = 0x05;
/// Pre-operational.
pub const PRE_OPERATIONAL: u8 = 0x7F;

/// NMT states: with 00h, a node reports that it has left Initialisation (CiA 301, 7.3.2).
static STATES: &[Term<u8>] = &[
    (BOOT_UP, "启动(Boot-up)", "Pre-operational (boot-up)"),
    (STOPPED, "停止状态", "Stopped"),
    (OPERATIONAL, "操作状态", "Operational"),
    (PRE_OPERATIONAL, "预操作状态", "Pre-operational"),
];

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

/// Returns the name of a state (without the toggle bit).
pub fn state(lang: Lang, state: u8) -> Option<&'static str> {
    find(STATES, lang, state)
}

/// The forms of error control.
pub(super) struct ErrorControlService;

impl WireService for ErrorControlService {
    /// `节点5的心跳: 操作状态 (此前: 预操作状态)`.
    fn line(&self, out: &mut Vec<u8>, lang: Lang, full: bool, message: &Message, frame: &Frame) {
        match *message {
            Message::BootUp { node } => say!(out, lang; zh: "节点", node, "的启动报文"; en: "boot-up of node ", node),
            Message::GuardingRequest { node } => {
                say!(out, lang;
                    zh: "NMT主站对节点", node, "的节点保护请求";
                    en: "node guarding request of the NMT master to node ", node);
                if full && frame.len > 1 {
                    let size = Size(lang, frame.len.into());
                    say!(out, lang;
                        zh: " (请求长度", size, ", 应为0或1)";
                        en: " (requested length ", size, ", expected 0 or 1)");
                }
            }
            Message::Heartbeat { node, state, toggle, guarding, previous } => {
                if guarding {
                    say!(out, lang; zh: "节点", node, "的节点保护应答"; en: "node guarding response of node ", node);
                } else {
                    say!(out, lang; zh: "节点", node, "的心跳"; en: "heartbeat of node ", node);
                }
                if full {
                    shown_state(out, lang, state, guarding.then_some(toggle), previous);
                }
            }
            _ => {}
        }
    }

    fn breakdown(&self, out: &mut Vec<u8>, lang: Lang, message: &Message, frame: &Frame) {
        if let Message::GuardingRequest { .. } = message {
            return fields::requested(out, lang, frame.len);
        }
        let [byte, ..] = frame.head();
        let (toggle, state) = (byte >> 7, byte & 0x7F);
        put!(out; "#   ", Hex::<2>(u64::from(byte)), " = ", Nibbles(byte), lang.pick("  位7: ", "  bit 7: "), toggle);
        put!(out; match toggle {
            0 => lang.pick(" (心跳中恒为0; 节点保护中为toggle位)", " (always 0 in a heartbeat; the toggle bit of node guarding)"),
            _ => lang.pick(" toggle (节点保护)", " toggle (node guarding)"),
        });
        put!(out; lang.pick(" | 位6-0: ", " | bits 6-0: "), Hex::<2>(u64::from(state)), "h ");
        put!(out; self::state(lang, state).unwrap_or(lang.pick("未知状态", "unknown state")), "\n");
    }

    fn json(&self, object: &mut Object<'_>, message: &Message, _: &Frame) {
        let guarding = message.service() == "guarding";
        if guarding {
            object.flag("request", matches!(message, Message::GuardingRequest { .. }));
        }
        let (state, toggle, previous) = match *message {
            Message::BootUp { .. } => (BOOT_UP, false, None),
            Message::Heartbeat { state, toggle, previous, .. } => (state, toggle, previous),
            _ => return,
        };
        object.hex::<2>("state", u64::from(state));
        object.optional("name", self::state(Lang::En, state));
        let boot_up = matches!(message, Message::BootUp { .. });
        if guarding {
            object.number("toggle", u8::from(toggle));
        } else {
            object.flag("boot_up", boot_up);
        }
        if !boot_up {
            object.maybe_hex("previous", previous.is_some(), previous.unwrap_or(0));
            object.flag("changed", previous.is_some_and(|previous| previous != state));
        }
    }
}

/// Appends a state: `: 操作状态 (toggle=1) (此前: 预操作状态)`.
fn shown_state(out: &mut Vec<u8>, lang: Lang, state: u8, toggle: Option<bool>, previous: Option<u8>) {
    match self::state(lang, state) {
        Some(word) => put!(out; ": ", word),
        None => put!(out; lang.pick(": 未知状态 ", ": unknown state "), Hex::<2>(u64::from(state)), "h"),
    }
    if let Some(toggle) = toggle {
        put!(out; " (toggle=", u8::from(toggle), ")");
    }
    let before = previous.filter(|before| *before != state);
    if let Some(before) = before.and_then(|before| self::state(lang, before)) {
        put!(out; lang.pick(" (此前: ", " (previously: "), before, ")");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::lang::tests::sound;

    #[test]
    fn frames() {
        sound(STATES);
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

//! NMT node control (CiA 301, 7.2.8.3.1): the master commands a node or all nodes. Never confirmed.
//!
//! An unknown command or a node-ID above 127 is still an NMT frame; a frame of another length is not.

use super::error_control;
use super::prelude::*;

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

/// Command specifiers.
static COMMANDS: &[Term<u8>] = words!("nmt_commands");

static FIELDS: &[FieldRow] = &[
    field(
        0,
        1,
        ("命令字", "command specifier"),
        Word(COMMANDS, ("未知", "unknown")),
        &[JsonKey::Hex("command"), JsonKey::Name("name", COMMANDS)],
    ),
    field(1, 1, ("", ""), Only(target), &[JsonKey::Decimal("target")]),
];

/// Returns true if a command resets the node, or its communication at least.
pub const fn is_reset(command: u8) -> bool {
    matches!(command, RESET_NODE | RESET_COMMUNICATION)
}

/// Returns the state that a command asks for, in the encoding of error control; a reset ends in a boot-up.
pub const fn commanded_state(command: u8) -> Option<u8> {
    match command {
        START => Some(error_control::OPERATIONAL),
        STOP => Some(error_control::STOPPED),
        PRE_OPERATIONAL => Some(error_control::PRE_OPERATIONAL),
        RESET_NODE | RESET_COMMUNICATION => Some(error_control::BOOT_UP),
        _ => None,
    }
}

/// Decodes a frame on 000.
pub fn decode(role: Role, payload: &[u8]) -> Message {
    match *payload {
        [command, node] => Message::Nmt { command, node },
        _ => length(role, 2, 2),
    }
}

/// Returns the name of a command.
pub fn command(lang: Lang, command: u8) -> Option<&'static str> {
    find(COMMANDS, lang, command)
}

/// The forms of node control.
pub(super) struct NmtService;

impl WireService for NmtService {
    /// `NMT主站命令: 启动节点5 (进入操作状态)`.
    fn line(&self, out: &mut Vec<u8>, lang: Lang, full: bool, message: &Message, _: &Frame) {
        let Message::Nmt { command, node } = *message else { return };
        let whom = |out: &mut Vec<u8>| match node {
            0..=127 => put!(out; Nodes(lang, node)),
            _ => put!(out; lang.pick("无效的节点ID ", "invalid node-ID "), node),
        };
        let Some((before, behind, effect)) = phrase(command) else {
            let unknown = Hex::<2>(u64::from(command));
            return say!(out, lang;
                zh: "NMT主站命令: 未知命令 ", unknown, "h, ", whom; en: "NMT unknown command ", unknown, "h: ", whom);
        };
        let name = self::command(lang, command).unwrap_or_default();
        say!(out, lang; zh: "NMT主站命令: ", before, whom, behind; en: "NMT ", name, ": ", whom);
        if full {
            put!(out; " (", lang.word(effect), ")");
        }
    }

    fn fields(&self) -> &'static [FieldRow] {
        FIELDS
    }
}

/// Returns the Chinese words around the addressed node, and the effect of a command.
const fn phrase(command: u8) -> Option<(&'static str, &'static str, Bilingual)> {
    Some(match command {
        START => ("启动", "", ("进入操作状态", "to Operational")),
        STOP => ("停止", "", ("进入停止状态", "to Stopped")),
        PRE_OPERATIONAL => ("", "进入预操作状态", ("停止PDO", "PDO off")),
        RESET_NODE => ("复位", "", ("复位应用, 进入初始化状态", "resets the application, to Initialisation")),
        RESET_COMMUNICATION => ("", "复位通信", ("进入初始化状态", "to Initialisation")),
        _ => return None,
    })
}

fn target(out: &mut Vec<u8>, lang: Lang, read: &FieldValue<'_>) {
    match read.byte() {
        0 => put!(out; lang.pick("  所有节点", "  all nodes")),
        node => fields::node_id(out, lang, node),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::lang::tests::sound;

    #[test]
    fn frames() {
        sound(COMMANDS);
        assert_eq!(decode(Role::Nmt, &[0x01, 0x0A]), Message::Nmt { command: START, node: 10 });
        assert_eq!(decode(Role::Nmt, &[0x82, 0x00]), Message::Nmt { command: RESET_COMMUNICATION, node: 0 });
        assert_eq!(decode(Role::Nmt, &[0x50, 0xC8]), Message::Nmt { command: 0x50, node: 200 });
        assert_eq!(decode(Role::Nmt, &[0x01]), length(Role::Nmt, 2, 2));
        assert_eq!(decode(Role::Nmt, &[0x01, 0x0A, 0x00]), length(Role::Nmt, 2, 2));
    }
}

//! NMT in words: node control, heartbeats and node guarding (CiA 301, 7.2.8). Must not judge a state.

use crate::wire::nmt;
use crate::words::digits::{Hex, put};
use crate::words::services::role::Nodes;
use crate::words::value::Size;
use crate::words::{Lang, say, terms};

/// A command to one node or to all: `NMT主站命令: 启动节点5 (进入操作状态)`.
pub fn node_control(out: &mut Vec<u8>, lang: Lang, full: bool, command: u8, node: u8) {
    let name = terms::nmt::command(lang, command).unwrap_or_default();
    let whom = |out: &mut Vec<u8>| match node {
        0..=127 => put!(out; Nodes(lang, node)),
        _ => say!(out, lang; zh: "无效的节点ID ", node; en: "invalid node-ID ", node),
    };
    match command {
        nmt::START => say!(out, lang; zh: "NMT主站命令: 启动", whom; en: "NMT ", name, ": ", whom),
        nmt::STOP => say!(out, lang; zh: "NMT主站命令: 停止", whom; en: "NMT ", name, ": ", whom),
        nmt::PRE_OPERATIONAL => {
            say!(out, lang; zh: "NMT主站命令: ", whom, "进入预操作状态"; en: "NMT ", name, ": ", whom);
        }
        nmt::RESET_NODE => say!(out, lang; zh: "NMT主站命令: 复位", whom; en: "NMT ", name, ": ", whom),
        nmt::RESET_COMMUNICATION => {
            say!(out, lang; zh: "NMT主站命令: ", whom, "复位通信"; en: "NMT ", name, ": ", whom);
        }
        _ => {
            let unknown = Hex::<2>(u64::from(command));
            say!(out, lang;
                zh: "NMT主站命令: 未知命令 ", unknown, "h, ", whom;
                en: "NMT unknown command ", unknown, "h: ", whom);
        }
    }
    if full {
        effect(out, lang, command);
    }
}

fn effect(out: &mut Vec<u8>, lang: Lang, command: u8) {
    match command {
        nmt::START => say!(out, lang; zh: " (进入操作状态)"; en: " (to Operational)"),
        nmt::STOP => say!(out, lang; zh: " (进入停止状态)"; en: " (to Stopped)"),
        nmt::PRE_OPERATIONAL => say!(out, lang; zh: " (停止PDO)"; en: " (PDO off)"),
        nmt::RESET_NODE => {
            say!(out, lang; zh: " (复位应用, 进入初始化状态)"; en: " (resets the application, to Initialisation)");
        }
        nmt::RESET_COMMUNICATION => say!(out, lang; zh: " (进入初始化状态)"; en: " (to Initialisation)"),
        _ => {}
    }
}

/// A heartbeat or the answer to a guarding request.
pub fn error_control(out: &mut Vec<u8>, lang: Lang, node: u8, guarding: bool) {
    if guarding {
        say!(out, lang; zh: "节点", node, "的节点保护应答"; en: "node guarding response of node ", node);
    } else {
        say!(out, lang; zh: "节点", node, "的心跳"; en: "heartbeat of node ", node);
    }
}

/// A guarding request; `len`: the length that it asks for.
pub fn guarding_request(out: &mut Vec<u8>, lang: Lang, full: bool, node: u8, len: u8) {
    say!(out, lang;
        zh: "NMT主站对节点", node, "的节点保护请求";
        en: "node guarding request of the NMT master to node ", node);
    if full && len > 1 {
        let size = Size(lang, len.into());
        say!(out, lang; zh: " (请求长度", size, ", 应为0或1)"; en: " (requested length ", size, ", expected 0 or 1)");
    }
}

/// The state that they carry: `: 操作状态 (toggle=1) (此前: 预操作状态)`.
pub fn state(out: &mut Vec<u8>, lang: Lang, state: u8, toggle: Option<bool>, previous: Option<u8>) {
    match terms::nmt::state(lang, state) {
        Some(word) => put!(out; ": ", word),
        None => {
            let unknown = Hex::<2>(u64::from(state));
            say!(out, lang; zh: ": 未知状态 ", unknown, "h"; en: ": unknown state ", unknown, "h");
        }
    }
    if let Some(toggle) = toggle {
        put!(out; " (toggle=", u8::from(toggle), ")");
    }
    let before = previous.filter(|before| *before != state);
    if let Some(before) = before.and_then(|before| terms::nmt::state(lang, before)) {
        say!(out, lang; zh: " (此前: ", before, ")"; en: " (previously: ", before, ")");
    }
}

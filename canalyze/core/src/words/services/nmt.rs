//! NMT in words: node control, heartbeats and node guarding (CiA 301, 7.2.8). Must not judge a state.

use crate::words::digits::{Hex, put};
use crate::words::value::Size;
use crate::words::{Lang, say, terms};

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
    say!(out, lang; zh: "NMT主站对节点", node, "的节点保护请求"; en: "node guarding request of the NMT master to node ", node);
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

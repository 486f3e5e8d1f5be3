//! USDO in words (CiA 1301): what its first frames carry.

use crate::wire::role::Nodes;
use crate::wire::usdo;
use crate::words::digits::{Hex, Spaced, put};
use crate::words::value::Size;
use crate::words::{Lang, say, terms};
use crate::world::od::DataType;

/// Who asks or answers whom.
pub fn parties(out: &mut Vec<u8>, lang: Lang, request: bool, source: u8, to: Nodes) {
    if request {
        say!(out, lang; zh: "USDO请求, 节点", source, " -> ", to; en: "USDO request, node ", source, " -> ", to);
    } else {
        say!(out, lang; zh: "USDO响应, 节点", source, " -> ", to; en: "USDO response, node ", source, " -> ", to);
    }
}

/// Appends the content of a frame: `: 加速下载请求, 会话=7, 2000h:01, 类型 UNSIGNED32, 4字节: 2A 00 00 00`.
pub fn content(out: &mut Vec<u8>, lang: Lang, command: u8, payload: &[u8]) {
    match terms::usdo::command(lang, command) {
        Some(word) => put!(out; ": ", word),
        None => {
            let unknown = Hex::<2>(u64::from(command));
            say!(out, lang; zh: ": 未知命令字 ", unknown, "h"; en: ": unknown command specifier ", unknown, "h");
        }
    }
    if command & 0x80 != 0 {
        say!(out, lang; zh: " (远程网络)"; en: " (remote network)");
    }
    if let Some(session) = payload.get(2) {
        say!(out, lang; zh: ", 会话=", *session; en: ", session=", *session);
    }
    let Some(object) = usdo::object(payload) else {
        return;
    };
    put!(out; ", ", Hex::<4>(u64::from(object.index)), "h:", Hex::<2>(u64::from(object.sub)));
    if let Some(code) = object.abort {
        let meaning = terms::usdo::abort(lang, code).unwrap_or(lang.pick("未知", "unknown"));
        put!(out; lang.pick(", 中止码 ", ", abort code "), Hex::<2>(u64::from(code)), "h ", meaning);
    }
    if let Some(data_type) = object.data_type {
        put!(out; lang.pick(", 类型 ", ", type "));
        match DataType::from_code(u16::from(data_type)) {
            Some(known) => put!(out; known.name()),
            None => put!(out; Hex::<2>(u64::from(data_type)), "h"),
        }
    }
    if let Some(size) = object.size {
        put!(out; ", ", Size(lang, size.into()));
        if !object.data.is_empty() {
            put!(out; ": ", Spaced(object.data));
        }
    }
}

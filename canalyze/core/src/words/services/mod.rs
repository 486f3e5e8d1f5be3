//! The text of a single frame, with a file for each service.
//!
//! A new service gets its arm in [`message`] (the compiler asks for it) and, where it has more than a phrase, a file
//! here. A phrase is one `say!`: the languages beside each other, each in its own order of words. What has a name, such
//! as a state or an error code, stands in `terms`. Must not decide anything. No `format!` and no allocation: these are
//! the lines of the hot path.

pub mod nmt;
pub mod pdo;
pub mod sdo;
pub mod time;

use super::digits::put;
use super::value::Size;
use super::{Depth, Lang, say};
use crate::bytes::frame::{Frame, Kind};
use crate::wire;
use crate::wire::cob_id::Role;
use crate::wire::message::{Flaw, Message};
use crate::wire::role::{Named, PdoLabel};

/// Appends the phrase of a message, and at other depths than brief its content. No line end.
pub fn message(out: &mut Vec<u8>, lang: Lang, depth: Depth, message: &Message, frame: &Frame) {
    let full = depth != Depth::Brief;
    match *message {
        Message::Pdo { transmit, number, node } => {
            pdo::undecoded(out, lang, full, PdoLabel { lang, transmit, number, node }, frame.len);
        }
        Message::Mpdo { transmit, number, node, content } => {
            put!(out; PdoLabel { lang, transmit, number, node });
            if full {
                put!(out; ": ");
                pdo::multiplexed(out, lang, &content, None);
            }
        }
        Message::PdoRequest { transmit, number, node } => {
            pdo::request(out, lang, full, PdoLabel { lang, transmit, number, node }, frame.len);
        }
        Message::BootUp { node } => say!(out, lang; zh: "节点", node, "的启动报文"; en: "boot-up of node ", node),
        Message::Heartbeat { node, state, toggle, guarding, previous } => {
            nmt::error_control(out, lang, node, guarding);
            if full {
                nmt::state(out, lang, state, guarding.then_some(toggle), previous);
            }
        }
        Message::GuardingRequest { node } => nmt::guarding_request(out, lang, full, node, frame.len),
        Message::Time { ms, days, reserved } => time::time_of_day(out, lang, full, ms, days, reserved),
        Message::Foreign { role } => put!(out; Named(lang, role)),
        Message::Malformed { role, flaw } => malformed(out, lang, full, role, flaw, frame),
        _ => wire::line(out, lang, full, message, frame),
    }
}

/// A frame that has not the form of its service.
fn malformed(out: &mut Vec<u8>, lang: Lang, full: bool, role: Role, flaw: Flaw, frame: &Frame) {
    let (named, size) = (Named(lang, role), Size(lang, frame.len.into()));
    say!(out, lang; zh: "格式错误 (", named, ")"; en: "malformed (", named, ")");
    if !full {
        return;
    }
    match flaw {
        Flaw::Length { least, most } => {
            say!(out, lang; zh: ": 长度", size, ", 应为"; en: ": length ", size, ", expected ");
            if most == least.saturating_add(1) {
                say!(out, lang; zh: least, "或"; en: least, " or ");
            } else if most != least {
                say!(out, lang; zh: least, "至"; en: least, " to ");
            }
            put!(out; Size(lang, most.into()));
            if matches!(role, Role::Emcy(_)) && frame.len == 0 && frame.kind == Kind::Data {
                say!(out, lang; zh: " (可能是DS 301 V3的启动报文)"; en: " (may be the boot-up message of DS 301 V3)");
            }
        }
        Flaw::Remote => say!(out, lang;
            zh: ": 该服务没有远程帧 (请求长度", size, ")";
            en: ": this service has no remote frames (requested length ", size, ")"),
        Flaw::Fd => say!(out, lang;
            zh: ": 该服务没有CAN FD帧 (", size, ")";
            en: ": this service has no CAN FD frames (", size, ")"),
    }
}

//! What one frame says by itself, with a file for each service.
//!
//! A new service gets its arm in [`message`] (the compiler asks for it) and, where it has more than a phrase, a file
//! here. A phrase is one `say!`: the languages beside each other, each in its own order of words. What has a name, such
//! as a state or an error code, stands in `terms`. Must not decide anything. No `format!` and no allocation: these are
//! the lines of the hot path.

pub mod error_frame;
pub mod pdo;
pub mod sdo;
pub mod usdo;

use super::digits::put;
use super::value::Size;
use super::{Depth, Lang, say};
use crate::bytes::frame::{Frame, Kind};
use crate::wire;
use crate::wire::cob_id::Role;
use crate::wire::message::{Flaw, Message};
use crate::wire::role::{Named, Nodes, Pdo};

/// Appends the phrase of a message, and at other depths than brief its content. No line end.
pub fn message(out: &mut Vec<u8>, lang: Lang, depth: Depth, message: &Message, frame: &Frame) {
    let full = depth != Depth::Brief;
    match *message {
        Message::Pdo { transmit, number, node } => {
            pdo::undecoded(out, lang, full, Pdo { lang, transmit, number, node }, frame.len);
        }
        Message::Mpdo { transmit, number, node, content } => {
            put!(out; Pdo { lang, transmit, number, node });
            if full {
                put!(out; ": ");
                pdo::multiplexed(out, lang, &content, None);
            }
        }
        Message::PdoRequest { transmit, number, node } => {
            pdo::request(out, lang, full, Pdo { lang, transmit, number, node }, frame.len);
        }
        Message::Nmt { .. }
        | Message::Sync { .. }
        | Message::Time { .. }
        | Message::Emcy { .. }
        | Message::BootUp { .. }
        | Message::Heartbeat { .. }
        | Message::GuardingRequest { .. }
        | Message::Lss { .. } => wire::line(out, lang, full, message, frame),
        Message::Srdo { number, inverted, valid } => {
            put!(out; Named(lang, Role::Srdo { number, inverted }));
            if full {
                put!(out; ": ", Size(lang, frame.len.into()), inverse(lang, valid));
            }
        }
        Message::Gfc => put!(out; Named(lang, Role::Gfc)),
        Message::FlyingMaster { kind, master } => flying_master(out, lang, full, kind, master),
        Message::Usdo { request, source, destination, command } => {
            usdo::parties(out, lang, request, source, Nodes(lang, destination));
            if full {
                usdo::content(out, lang, command, frame.payload());
            }
        }
        Message::ErrorFrame => error_frame::errors(out, lang, full, frame),
        Message::Foreign { role } => put!(out; Named(lang, role)),
        Message::Malformed { role, flaw } => malformed(out, lang, full, role, flaw, frame),
    }
}

/// Whether the second frame of an SRDO is the inverse of the first.
fn inverse(lang: Lang, valid: Option<bool>) -> &'static str {
    match valid {
        Some(true) => lang.pick(", 与正常数据一致", ", the inverse of the normal data"),
        Some(false) => lang.pick(", 与正常数据不一致", ", not the inverse of the normal data"),
        None => "",
    }
}

/// The flying master's messages (CiA 302-2), by the last digit of the identifier.
fn flying_master(out: &mut Vec<u8>, lang: Lang, full: bool, kind: u8, master: Option<(u8, u8)>) {
    say!(out, lang; zh: "飞行主站: "; en: "flying master: ");
    match kind {
        1 => say!(out, lang; zh: "活动NMT主站的响应"; en: "response of the active NMT master"),
        2 => say!(out, lang; zh: "协商请求"; en: "negotiation request"),
        3 => say!(out, lang; zh: "查询活动NMT主站"; en: "request for the active NMT master"),
        4 => say!(out, lang; zh: "存在可作NMT主站的设备"; en: "a device capable of NMT master is present"),
        5 => say!(out, lang; zh: "查询可作NMT主站的设备"; en: "request for devices capable of NMT master"),
        6 => say!(out, lang; zh: "强制重新协商"; en: "force negotiation"),
        _ => say!(out, lang; zh: "未知报文"; en: "unknown message"),
    }
    if let (true, Some((priority, node))) = (full, master) {
        say!(out, lang; zh: ": 节点", node, ", 优先级=", priority; en: ": node ", node, ", priority=", priority);
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

//! Frames without a message: identifiers without a CANopen meaning, and frames that do not have their service's form.

use super::fields::line;
use super::prelude::*;
use crate::bytes::frame::Kind;
use crate::wire::message::Flaw;

/// The forms of a frame without a message.
pub(super) struct UndecodedService;

impl WireService for UndecodedService {
    fn line(&self, out: &mut Vec<u8>, lang: Lang, full: bool, message: &Message, frame: &Frame) {
        match *message {
            Message::Malformed { role, flaw } => malformed(out, lang, full, role, flaw, frame),
            _ => put!(out; Named(lang, message.role())),
        }
    }

    fn breakdown(&self, out: &mut Vec<u8>, lang: Lang, message: &Message, frame: &Frame) {
        if let Message::Malformed { .. } = message {
            line!(out; |out: &mut Vec<u8>| self.line(out, lang, true, message, frame));
        }
        fields::data(out, lang, frame.payload());
    }

    fn json(&self, object: &mut Object<'_>, message: &Message, _: &Frame) {
        let Message::Malformed { flaw, .. } = *message else {
            return object.word(
                "reason",
                match message.role() {
                    Role::DynamicSdo => "dynamic_sdo",
                    Role::Reserved => "reserved",
                    Role::Foreign => "extended",
                    _ => "unassigned",
                },
            );
        };
        object.word(
            "malformed",
            match flaw {
                Flaw::Length { .. } => "length",
                Flaw::Remote => "remote",
                Flaw::Fd => "fd",
            },
        );
        if let Flaw::Length { least, most } = flaw {
            object.number("least", least);
            object.number("most", most);
        }
    }
}

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

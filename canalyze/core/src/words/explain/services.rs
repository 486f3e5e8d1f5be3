//! The breakdown of every service but SDO and LSS: after the COB-ID, each field with its bytes, in the order of the frame.

use super::{cob_id, data, line};
use crate::bytes::frame::Frame;
use crate::wire;
use crate::wire::message::Message;
use crate::wire::pdo::{Multiplexed, communication_parameter, mapping_parameter};
use crate::words::digits::{Bin, Hex, Nibbles, Spaced, put};
use crate::words::services::time::{Clock, Date};
use crate::words::{Depth, Lang, say, services as words, terms};

/// Appends the breakdown of a frame, whole lines.
pub fn message(out: &mut Vec<u8>, lang: Lang, message: &Message, frame: &Frame) {
    match *message {
        Message::Usdo { .. } | Message::ErrorFrame => {}
        _ => cob_id(out, lang, message.role(), frame),
    }
    let payload = frame.payload();
    match *message {
        Message::Time { ms, days, reserved } => time_of_day(out, lang, ms, days, reserved, payload),
        Message::Pdo { transmit, number, .. } => {
            parameters(out, lang, transmit, number);
            data(out, lang, payload);
        }
        Message::Mpdo { transmit, number, content, .. } => {
            parameters(out, lang, transmit, number);
            multiplexed(out, lang, &content);
        }
        Message::PdoRequest { .. } | Message::GuardingRequest { .. } => {
            say!(out, lang;
                zh: "#   远程帧: 无数据, 请求长度(字节)=", frame.len, "\n";
                en: "#   remote frame: no data, requested length (bytes)=", frame.len, "\n");
        }
        Message::BootUp { .. } => error_control(out, lang, 0, false),
        Message::Heartbeat { state, toggle, .. } => error_control(out, lang, state, toggle),
        Message::Foreign { .. } => data(out, lang, payload),
        Message::Malformed { .. } => {
            phrase(out, lang, message, frame);
            data(out, lang, payload);
        }
        _ => wire::breakdown(out, lang, message, frame),
    }
}

/// The line's own sentence, as a line of the breakdown.
fn phrase(out: &mut Vec<u8>, lang: Lang, message: &Message, frame: &Frame) {
    put!(out; "#   ");
    words::message(out, lang, Depth::Default, message, frame);
    put!(out; "\n");
}

/// `#   00 20  索引2000h (小端格式)` and the sub-index.
fn object(out: &mut Vec<u8>, lang: Lang, index: u16, sub: u8) {
    put!(out; "#   ", Spaced(&index.to_le_bytes()), lang.pick("  索引", "  index "), Hex::<4>(u64::from(index)));
    put!(out; lang.pick("h (小端格式)\n", "h (little-endian)\n"));
    sub_index(out, lang, sub);
}

fn sub_index(out: &mut Vec<u8>, lang: Lang, sub: u8) {
    let hex = Hex::<2>(u64::from(sub));
    line!(out; hex, lang.pick("  子索引", "  sub-index "), hex, "h");
}

fn time_of_day(out: &mut Vec<u8>, lang: Lang, ms: u32, days: u16, reserved: u8, payload: &[u8]) {
    let word = u64::from(ms) | u64::from(reserved) << 28;
    put!(out; "#   ", Spaced(payload.get(..4).unwrap_or_default()), " = ", Hex::<8>(word));
    put!(out; lang.pick("h (小端格式)  位31-28: ", "h (little-endian)  bits 31-28: "), Bin::<4>(u64::from(reserved)));
    say!(out, lang;
        zh: "b 保留 | 位27-0: 午夜起", ms, " ms = ", Clock(ms), "\n";
        en: "b reserved | bits 27-0: since midnight ", ms, " ms = ", Clock(ms), "\n");
    put!(out; "#   ", Spaced(&days.to_le_bytes()), " = ", Hex::<4>(u64::from(days)));
    say!(out, lang;
        zh: "h (小端格式)  1984-01-01起", days, "天 = ", Date(days), "\n";
        en: "h (little-endian)  since 1984-01-01: ", days, " days = ", Date(days), "\n");
}

fn error_control(out: &mut Vec<u8>, lang: Lang, state: u8, toggle: bool) {
    let byte = state | u8::from(toggle) << 7;
    put!(out; "#   ", Hex::<2>(u64::from(byte)), " = ", Nibbles(byte), lang.pick("  位7: ", "  bit 7: "), u8::from(toggle));
    put!(out; if toggle {
        lang.pick(" toggle (节点保护)", " toggle (node guarding)")
    } else {
        lang.pick(" (心跳中恒为0; 节点保护中为toggle位)", " (always 0 in a heartbeat; the toggle bit of node guarding)")
    });
    put!(out; lang.pick(" | 位6-0: ", " | bits 6-0: "), Hex::<2>(u64::from(state)), "h ");
    put!(out; terms::nmt::state(lang, state).unwrap_or(lang.pick("未知状态", "unknown state")));
    put!(out; "\n");
}

pub(super) fn parameters(out: &mut Vec<u8>, lang: Lang, transmit: bool, number: u16) {
    put!(out; "#   ", lang.pick("通信参数 ", "communication parameter "));
    put!(out; Hex::<4>(u64::from(communication_parameter(transmit, number))));
    put!(out; lang.pick("h, 映射参数 ", "h, mapping parameter "));
    put!(out; Hex::<4>(u64::from(mapping_parameter(transmit, number))));
    put!(out; lang.pick("h: 数据的含义由映射决定\n", "h: the mapping defines the data\n"));
}

fn multiplexed(out: &mut Vec<u8>, lang: Lang, content: &Multiplexed) {
    let byte = content.node | u8::from(content.destination) << 7;
    put!(out; "#   ", Hex::<2>(u64::from(byte)), " = ", Nibbles(byte), lang.pick("  位7: ", "  bit 7: "));
    put!(out; if content.destination {
        lang.pick("1 目标地址模式(DAM)", "1 destination address mode (DAM)")
    } else {
        lang.pick("0 源地址模式(SAM)", "0 source address mode (SAM)")
    });
    put!(out; lang.pick(" | 位6-0: ", " | bits 6-0: "), Hex::<2>(u64::from(content.node)));
    put!(out; lang.pick("h 节点ID (", "h node-ID ("), content.node, ")\n");
    object(out, lang, content.index, content.sub);
    put!(out; "#   ", Spaced(&content.data), lang.pick("  数据(4字节) = ", "  data (4 bytes) = "));
    put!(out; u32::from_le_bytes(content.data), lang.pick(" (小端格式)\n", " (little-endian)\n"));
}

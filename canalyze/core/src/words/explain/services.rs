//! The breakdown of every service but SDO and LSS: after the COB-ID, each field with its bytes, in the order of the frame.

use super::{cob_id, data, line};
use crate::bytes::frame::Frame;
use crate::wire;
use crate::wire::fields::requested;
use crate::wire::message::Message;
use crate::wire::pdo::{Multiplexed, communication_parameter, mapping_parameter};
use crate::words::Lang;
use crate::words::digits::{Hex, Nibbles, Spaced, put};

/// Appends the breakdown of a frame, whole lines.
pub fn message(out: &mut Vec<u8>, lang: Lang, message: &Message, frame: &Frame) {
    match *message {
        Message::Usdo { .. } | Message::ErrorFrame => {}
        _ => cob_id(out, lang, message.role(), frame),
    }
    let payload = frame.payload();
    match *message {
        Message::Pdo { transmit, number, .. } => {
            parameters(out, lang, transmit, number);
            data(out, lang, payload);
        }
        Message::Mpdo { transmit, number, content, .. } => {
            parameters(out, lang, transmit, number);
            multiplexed(out, lang, &content);
        }
        Message::PdoRequest { .. } => requested(out, lang, frame.len),
        _ => wire::breakdown(out, lang, message, frame),
    }
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

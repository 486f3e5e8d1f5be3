//! The breakdown of every service but SDO and LSS: after the COB-ID, each field with its bytes, in the order of the frame.

use super::{cob_id, data, line};
use crate::bytes::frame::Frame;
use crate::wire;
use crate::wire::fields::{requested, reserved};
use crate::wire::message::Message;
use crate::wire::pdo::{Multiplexed, communication_parameter, mapping_parameter};
use crate::wire::{error_frame, usdo};
use crate::words::digits::{Hex, Nibbles, Spaced, put};
use crate::words::{Lang, say, terms};

/// Appends the breakdown of a frame, whole lines.
pub fn message(out: &mut Vec<u8>, lang: Lang, message: &Message, frame: &Frame) {
    match *message {
        Message::Usdo { request, source, .. } => {
            put!(out; "#   COB-ID ", Hex::<3>(u64::from(frame.id.raw())), if request { "h = 600h + " } else { "h = 580h + " });
            put!(out; lang.pick("源节点ID ", "source node-ID "), Hex::<2>(u64::from(source)), "h (", source, "): ");
            put!(out; if request {
                lang.pick("USDO请求, 客户端 -> 服务器\n", "USDO request, client -> server\n")
            } else {
                lang.pick("USDO响应, 服务器 -> 客户端\n", "USDO response, server -> client\n")
            });
        }
        Message::ErrorFrame => {}
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
        Message::Usdo { destination, command, .. } => usdo_header(out, lang, destination, command, payload),
        Message::ErrorFrame => errors(out, lang, frame),
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

fn usdo_header(out: &mut Vec<u8>, lang: Lang, destination: u8, command: u8, payload: &[u8]) {
    put!(out; "#   ", Hex::<2>(u64::from(destination)), lang.pick("  目标节点ID: ", "  destination node-ID: "));
    match destination {
        0 => put!(out; lang.pick("所有节点\n", "all nodes\n")),
        _ => put!(out; destination, "\n"),
    }
    put!(out; "#   ", Hex::<2>(u64::from(command)), lang.pick("  命令字: ", "  command specifier: "));
    put!(out; terms::usdo::command(lang, command).unwrap_or(lang.pick("未知", "unknown")));
    if command & 0x80 != 0 {
        put!(out; lang.pick(" (远程网络)", " (remote network)"));
    }
    put!(out; "\n");
    if let Some(session) = payload.get(2) {
        line!(out; Hex::<2>(u64::from(*session)), lang.pick("  会话ID = ", "  session-ID = "), *session);
    }
    let Some(object) = usdo::object(payload) else {
        data(out, lang, payload.get(3..).unwrap_or_default());
        return;
    };
    // Byte 3 is the sub-index and comes before the index here, other than in SDO.
    sub_index(out, lang, object.sub);
    put!(out; "#   ", Spaced(&object.index.to_le_bytes()), lang.pick("  索引", "  index "));
    put!(out; Hex::<4>(u64::from(object.index)), lang.pick("h (小端格式)\n", "h (little-endian)\n"));
    let mut rest = payload.get(6..).unwrap_or_default();
    if let Some(code) = object.abort {
        let word = terms::usdo::abort(lang, code).unwrap_or(lang.pick("未知", "unknown"));
        line!(out; Hex::<2>(u64::from(code)), lang.pick("  中止码: ", "  abort code: "), word);
        rest = payload.get(7..).unwrap_or_default();
    }
    if let (Some(data_type), Some(size)) = (object.data_type, object.size) {
        let word =
            crate::world::od::DataType::from_code(u16::from(data_type)).map_or("-", crate::world::od::DataType::name);
        line!(out; Hex::<2>(u64::from(data_type)), lang.pick("  数据类型: ", "  data type: "), word);
        line!(out; Hex::<2>(u64::from(size)), lang.pick("  数据长度(字节) = ", "  size (bytes) = "), size);
        data(out, lang, object.data);
        rest = payload.get(8 + object.data.len()..).unwrap_or_default();
    }
    reserved(out, lang, rest);
}

fn errors(out: &mut Vec<u8>, lang: Lang, frame: &Frame) {
    let class = error_frame::class(frame);
    line!(out; lang.pick("错误帧, 类别 ", "error frame, class "), Hex::<8>(u64::from(class)), "h");
    for bit in error_frame::classes(frame) {
        let word = terms::find(terms::error_frame::CLASSES, lang, bit).unwrap_or(lang.pick("未知", "unknown"));
        line!(out; "  ", Hex::<8>(u64::from(bit)), "h  ", word);
    }
    let [arbitration, controller, protocol, location, transceiver, ..] = frame.head();
    if class & error_frame::LOST_ARBITRATION != 0 {
        put!(out; "#   d0: ", Hex::<2>(u64::from(arbitration)));
        say!(out, lang;
            zh: "  仲裁丢失的位 (0未指明) = ", arbitration, "\n";
            en: "  lost at bit (0 unspecified) = ", arbitration, "\n");
    }
    if class & error_frame::CONTROLLER != 0 {
        detail(out, lang, "d1: ", controller, terms::error_frame::CONTROLLER);
    }
    if class & error_frame::PROTOCOL != 0 {
        detail(out, lang, "d2: ", protocol, terms::error_frame::PROTOCOL);
        let unknown =
            if location == 0 { lang.pick("未指明", "unspecified") } else { lang.pick("未知", "unknown") };
        let word = terms::find(terms::error_frame::LOCATION, lang, location).unwrap_or(unknown);
        line!(out; "d3: ", Hex::<2>(u64::from(location)), lang.pick("  位置: ", "  location: "), word);
    }
    if class & error_frame::TRANSCEIVER != 0 {
        put!(out; "#   d4: ", Hex::<2>(u64::from(transceiver)), " = ", Nibbles(transceiver));
        let nibbles = [
            (transceiver & 0x0F, lang.pick("  位3-0: ", "  bits 3-0: ")),
            (transceiver & 0xF0, lang.pick(" | 位7-4: ", " | bits 7-4: ")),
        ];
        for (wire, bits) in nibbles {
            let unknown =
                if wire == 0 { lang.pick("未指明", "unspecified") } else { lang.pick("未知", "unknown") };
            let word = terms::find(terms::error_frame::TRANSCEIVER, lang, wire).unwrap_or(unknown);
            put!(out; bits, word);
        }
        put!(out; "\n");
    }
    if let Some((tx, rx)) = error_frame::counters(frame) {
        line!(out; "d6: ", Hex::<2>(u64::from(tx)), lang.pick("  发送错误计数 = ", "  TX error counter = "), tx);
        line!(out; "d7: ", Hex::<2>(u64::from(rx)), lang.pick("  接收错误计数 = ", "  RX error counter = "), rx);
    }
}

/// A byte of flags: `#   d1: 08 = 0000 1000b  位3: 1 发送错误达到警告水平`.
fn detail(out: &mut Vec<u8>, lang: Lang, name: &'static str, byte: u8, rows: &'static [terms::Row<u8>]) {
    put!(out; "#   ", name, Hex::<2>(u64::from(byte)), " = ", Nibbles(byte));
    let mut between = "  ";
    for bit in (0..8u8).filter(|bit| byte & 1 << bit != 0) {
        let word = terms::find(rows, lang, 1 << bit).unwrap_or(lang.pick("未知", "unknown"));
        put!(out; between, lang.pick("位", "bit "), bit, ": 1 ", word);
        between = " | ";
    }
    if byte == 0 {
        put!(out; lang.pick("  未指明", "  unspecified"));
    }
    put!(out; "\n");
}

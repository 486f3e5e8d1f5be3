//! SocketCAN's error frames in words: classes, details and error counters.

use crate::bytes::frame::Frame;
use crate::wire::error_frame;
use crate::words::digits::{Hex, put};
use crate::words::{Lang, say, terms};

/// `错误帧: 控制器问题 (发送错误达到警告水平), 发送错误计数=96, 接收错误计数=0`; only its first word unless `full`.
pub fn errors(out: &mut Vec<u8>, lang: Lang, full: bool, frame: &Frame) {
    say!(out, lang; zh: "错误帧"; en: "error frame");
    if !full {
        return;
    }
    let mut between = ": ";
    for class in error_frame::classes(frame).filter(|class| *class != error_frame::COUNTERS) {
        put!(out; between);
        between = ", ";
        match terms::find(terms::error_frame::CLASSES, lang, class) {
            Some(word) => put!(out; word),
            None => put!(out; lang.pick("未知类别 ", "unknown class "), Hex::<8>(u64::from(class)), "h"),
        }
        details(out, lang, class, &frame.head());
    }
    if let Some((tx, rx)) = error_frame::counters(frame) {
        say!(out, lang;
            zh: between, "发送错误计数=", tx, ", 接收错误计数=", rx;
            en: between, "TX error counter=", tx, ", RX error counter=", rx);
    }
}

fn details(out: &mut Vec<u8>, lang: Lang, class: u32, head: &[u8; 8]) {
    let [bit, controller, protocol, location, transceiver, ..] = *head;
    match class {
        error_frame::LOST_ARBITRATION if bit == 0 => {
            say!(out, lang; zh: " (位置未指明)"; en: " (position unspecified)")
        }
        error_frame::LOST_ARBITRATION => say!(out, lang; zh: " (第", bit, "位)"; en: " (bit ", bit, ")"),
        error_frame::CONTROLLER => set_bits(out, lang, terms::error_frame::CONTROLLER, controller),
        error_frame::PROTOCOL => {
            set_bits(out, lang, terms::error_frame::PROTOCOL, protocol);
            match terms::find(terms::error_frame::LOCATION, lang, location) {
                Some(word) => put!(out; lang.pick(", 位置: ", ", location: "), word),
                None if location == 0 => say!(out, lang; zh: ", 位置未指明"; en: ", location unspecified"),
                None => {
                    let unknown = Hex::<2>(u64::from(location));
                    say!(out, lang; zh: ", 位置: 未知 ", unknown, "h"; en: ", location: unknown ", unknown, "h");
                }
            }
        }
        error_frame::TRANSCEIVER => {
            let wires = [transceiver & 0x0F, transceiver & 0xF0];
            listed(out, lang, terms::error_frame::TRANSCEIVER, wires.into_iter().filter(|wire| *wire != 0));
        }
        _ => {}
    }
}

fn set_bits(out: &mut Vec<u8>, lang: Lang, rows: &'static [terms::Row<u8>], byte: u8) {
    listed(out, lang, rows, (0..8).map(|bit| 1 << bit).filter(|bit| byte & bit != 0));
}

/// In brackets the words for some codes.
fn listed(out: &mut Vec<u8>, lang: Lang, rows: &'static [terms::Row<u8>], codes: impl Iterator<Item = u8>) {
    let mut between = " (";
    for code in codes {
        match terms::find(rows, lang, code) {
            Some(word) => put!(out; between, word),
            None => put!(out; between, lang.pick("未知 ", "unknown "), Hex::<2>(u64::from(code)), "h"),
        }
        between = ", ";
    }
    put!(out; if between == " (" { lang.pick(" (未指明)", " (unspecified)") } else { ")" });
}

//! PDOs in words: the signals of a mapped one, the object of a multiplex one. Nine tenths of a capture are these lines.

use std::cell::RefCell;

use crate::bytes::frame::Frame;
use crate::bytes::ns::Ns;
use crate::wire::pdo::Multiplexed;
use crate::wire::pdo::mapping::Mapping;
use crate::wire::role::{Nodes, PdoLabel};
use crate::words::digits::{KnownTexts, put};
use crate::words::value::{self, Size};
use crate::words::{Depth, Lang, say, sentence, signal};
use crate::world::configuration::Provenance;
use crate::world::event::{Addressed, Placement, ProcessData, Signals, Unmapped};

thread_local! {
    /// The beginnings of phrases, by what decides them: nearly all are those of an earlier frame.
    static BEGINNINGS: RefCell<KnownTexts> = RefCell::default();
}

/// Appends the phrase of a PDO, and at other depths than brief its signals. No line end.
pub fn process_data(out: &mut Vec<u8>, lang: Lang, depth: Depth, data: &ProcessData, frame: &Frame) {
    let key = beginning_key(lang, depth, data, frame.len);
    BEGINNINGS.with_borrow_mut(|known| known.put_or(out, key, |out| beginning(out, lang, depth, data, frame.len)));
    if depth != Depth::Brief {
        signals(out, lang, data, frame);
    }
}

/// Appends the part of the phrase behind [`beginning`]: the signals, and the place after SYNC.
pub fn signals(out: &mut Vec<u8>, lang: Lang, data: &ProcessData, frame: &Frame) {
    match &data.content {
        Signals::Mapped(mapping, from) => {
            signal::all(out, lang, mapping, frame.payload());
            preset(out, lang, *from);
        }
        Signals::ByConsumer(mapping, from, node, number) => {
            signal::all(out, lang, mapping, frame.payload());
            let consumer = PdoLabel { lang, transmit: false, number: *number, node: *node };
            say!(out, lang; zh: " (按", consumer, "的映射)"; en: " (mapped as ", consumer, ")");
            preset(out, lang, *from);
        }
        Signals::None(_) => {}
    }
    if let Some(sync) = &data.sync {
        placement(out, sync);
    }
}

/// Appends the part of the phrase that the bytes of the PDO do not change.
pub fn beginning(out: &mut Vec<u8>, lang: Lang, depth: Depth, data: &ProcessData, len: u8) {
    put!(out; PdoLabel { lang, transmit: data.transmit, number: data.number, node: data.node });
    if depth == Depth::Brief {
        return;
    }
    put!(out; ": ");
    if let Signals::None(why) = data.content {
        put!(out; Size(lang, len.into()), match why {
            Unmapped::Unknown => lang.pick(", 映射未知", ", mapping unknown"),
            Unmapped::Unconfirmed => lang.pick(", 映射未知, COB-ID未确认", ", mapping unknown, COB-ID unconfirmed"),
            Unmapped::Contradicted => lang.pick(", 与EDS默认映射不符", ", does not fit the EDS default mapping"),
            Unmapped::Disabled => lang.pick(", 映射已禁用", ", mapping disabled"),
            Unmapped::Multiplex => lang.pick(", 不是完整的MPDO", ", not a complete MPDO"),
        });
    }
}

/// Returns all that decides that part; the phrase of a PDO without a mapping and its SYNC has no other. The highest 24
/// bits are 0.
pub fn beginning_key(lang: Lang, depth: Depth, data: &ProcessData, len: u8) -> u64 {
    let why = match data.content {
        Signals::Mapped(..) | Signals::ByConsumer(..) => 0,
        Signals::None(why) => 1 + why as u64,
    };
    let how = u64::from(lang == Lang::En) | u64::from(depth == Depth::Brief) << 1 | u64::from(data.transmit) << 2;
    u64::from(data.node) | u64::from(data.number) << 8 | how << 24 | why << 27 | u64::from(len) << 32
}

/// Appends the phrase of a multiplex PDO, and at other depths than brief what it carries. No line end.
pub fn multiplex(out: &mut Vec<u8>, lang: Lang, depth: Depth, data: &Addressed) {
    put!(out; PdoLabel { lang, transmit: data.transmit, number: data.number, node: data.node });
    if depth != Depth::Brief {
        put!(out; ": ");
        multiplexed(out, lang, &data.content, Some(&data.mapping));
    }
}

/// A PDO without its mapping: its length.
pub fn undecoded(out: &mut Vec<u8>, lang: Lang, full: bool, pdo: PdoLabel, len: u8) {
    put!(out; pdo);
    if full {
        put!(out; ": ", Size(lang, len.into()));
    }
}

/// A remote request for a PDO; `len`: the length that it asks for.
pub fn request(out: &mut Vec<u8>, lang: Lang, full: bool, pdo: PdoLabel, len: u8) {
    say!(out, lang; zh: "对", pdo, "的远程请求"; en: "remote request for ", pdo);
    if full {
        let size = Size(lang, len.into());
        say!(out, lang; zh: ": 请求长度", size; en: ": requested length ", size);
    }
}

/// Appends the content of a multiplex PDO: `DAM-MPDO, 写节点10的2000h:01 = 2A 00 00 00`, with name and value by
/// `mapping`.
pub fn multiplexed(out: &mut Vec<u8>, lang: Lang, content: &Multiplexed, mapping: Option<&Mapping>) {
    let node = Nodes(lang, content.node);
    if content.destination {
        say!(out, lang; zh: "DAM-MPDO, 写", node, "的"; en: "DAM-MPDO, write to ", node, ": ");
    } else if content.node == 0 {
        say!(out, lang; zh: "SAM-MPDO, 无效的生产者节点ID 0 的"; en: "SAM-MPDO, invalid producer node-ID 0: ");
    } else {
        say!(out, lang; zh: "SAM-MPDO, 生产者", node, "的"; en: "SAM-MPDO, producer ", node, ": ");
    }
    value::multiplexed(out, lang, content, mapping);
}

/// Appends a note on a mapping only preset or requested, which the device may not use.
fn preset(out: &mut Vec<u8>, lang: Lang, from: Provenance) {
    match from {
        Provenance::Profile => say!(out, lang; zh: " (设备规范默认映射)"; en: " (default mapping of the profile)"),
        Provenance::Eds => say!(out, lang; zh: " (EDS默认映射)"; en: " (EDS default mapping)"),
        Provenance::Unconfirmed(_) => say!(out, lang; zh: " (PDO配置未确认)"; en: " (PDO configuration unconfirmed)"),
        _ => {}
    }
}

/// `[SYNC 41 +0.8 ms]`.
fn placement(out: &mut Vec<u8>, sync: &Placement) {
    put!(out; " [SYNC ", sync.cycle);
    if let Some(delay) = sync.delay_ns {
        put!(out; if delay < Ns::ZERO { " " } else { " +" });
        sentence::duration(out, delay);
    }
    put!(out; "]");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bytes::frame::CanId;

    #[test]
    fn a_phrase_does_not_depend_on_those_before() {
        let whys = [Unmapped::Unknown, Unmapped::Unconfirmed, Unmapped::Contradicted, Unmapped::Disabled];
        for _ in 0..3 {
            for (lang, depth) in [Lang::Zh, Lang::En].into_iter().flat_map(|l| [(l, Depth::Default), (l, Depth::Brief)])
            {
                for (node, number, len) in [(1, 1, 8), (1, 2, 8), (2, 1, 8), (127, 512, 0), (1, 1, 7)] {
                    for (why, transmit) in whys.into_iter().flat_map(|why| [(why, true), (why, false)]) {
                        let content = Signals::None(why);
                        let data =
                            ProcessData { transmit, number, node, content, state: None, sync: None, is_off: false };
                        let frame = Frame::classic(CanId::standard(0x181), &vec![0; len]);
                        let (mut known, mut written) = (Vec::new(), Vec::new());
                        process_data(&mut known, lang, depth, &data, &frame);
                        beginning(&mut written, lang, depth, &data, frame.len);
                        assert_eq!(String::from_utf8_lossy(&known), String::from_utf8_lossy(&written));
                    }
                }
            }
        }
    }
}

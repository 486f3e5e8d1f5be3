//! Notes about earlier frames, in both languages.

use super::digits::{Hex, put};
use super::{Lang, say, sentence};
use crate::wire::lss::{self, Part};
use crate::world::event::{Note, Scanned};

/// Appends a note; `about` is the number of the earlier frame.
pub fn note(out: &mut Vec<u8>, lang: Lang, note: Note, about: u64) {
    match note {
        Note::RequestNotCaptured => say!(out, lang;
            zh: "第", about, "帧所响应的请求不在记录中";
            en: "the request answered by frame ", about, " is not in the capture"),
        Note::LostByReset => say!(out, lang;
            zh: "第", about, "帧开始的SDO传输因节点复位而中断";
            en: "SDO transfer started in frame ", about, " was terminated by a node reset"),
        Note::LssSelected { address } => {
            say!(out, lang; zh: "从站已进入配置状态: "; en: "slave in configuration state: ");
            parts(out, lang, address.map(Some));
        }
        Note::Fastscan(scanned) => fastscan(out, lang, scanned, about),
        Note::BitTimingActivated { delay, rate } => bit_timing(out, lang, u32::from(delay) * 2, rate),
        Note::NodeIdChanged { from, to } => say!(out, lang;
            zh: "节点", from, "的节点ID改为", to, " (第", about, "帧接受)";
            en: "node-ID of node ", from, " changed to ", to, " (accepted in frame ", about, ")"),
    }
}

/// Appends the change of the bit rate of a bus, after a silence in ms.
fn bit_timing(out: &mut Vec<u8>, lang: Lang, silence: u32, rate: Option<u16>) {
    say!(out, lang; zh: "此后总线应静默", silence, " ms, 之后"; en: "the bus should be silent for ", silence, " ms, then ");
    match rate {
        Some(rate) => say!(out, lang; zh: "波特率为", rate, " kbit/s: "; en: "the bit rate is ", rate, " kbit/s: "),
        None => say!(out, lang; zh: "波特率改变: "; en: "the bit rate changes: "),
    }
    say!(out, lang;
        zh: "仍用原波特率记录只会看到错误帧或静默";
        en: "a capture at the old bit rate shows only errors or nothing");
}

/// Appends the result of a Fastscan.
fn fastscan(out: &mut Vec<u8>, lang: Lang, scanned: Scanned, about: u64) {
    say!(out, lang; zh: "第", about, "帧开始的快速扫描"; en: "Fastscan started in frame ", about);
    if scanned.found {
        say!(out, lang; zh: "找到从站: "; en: " found a slave: ");
        parts(out, lang, scanned.address);
        if scanned.address.iter().any(Option::is_none) {
            say!(out, lang; zh: ", 其余部分不在记录中"; en: ", rest not in the capture");
        }
    } else {
        say!(out, lang; zh: "未完成"; en: " is incomplete");
        if scanned.address.iter().any(Option::is_some) {
            say!(out, lang; zh: ", 已确认: "; en: ", confirmed: ");
            parts(out, lang, scanned.address);
        }
    }
    let requests = if scanned.frames == 1 { " request" } else { " requests" };
    put!(out; " (", scanned.frames, lang.pick("个请求", requests));
    if let Some(ns) = scanned.duration_ns {
        say!(out, lang; zh: ", 用时"; en: " in ");
        sentence::duration(out, ns);
    }
    put!(out; ")");
}

fn parts(out: &mut Vec<u8>, lang: Lang, address: [Option<u32>; 4]) {
    let mut between = "";
    for (number, value) in (0..).zip(address) {
        if let (Some(part), Some(value)) = (Part::from_number(number), value) {
            put!(out; between, lss::part(lang, part), "=", Hex::<8>(u64::from(value)), "h");
            between = ", ";
        }
    }
}

//! Notes of what has become known of an earlier frame, in both languages.

use super::digits::{Hex, put};
use super::{Lang, sentence, terms};
use crate::event::{Note, Scanned};
use crate::services::lss::Part;

/// Appends a note; `about` is the number of the earlier frame.
pub fn note(out: &mut Vec<u8>, lang: Lang, note: Note, about: u64) {
    match note {
        Note::RequestNotCaptured => {
            put!(out; lang.pick("第", "the request that frame "), about);
            put!(out; lang.pick("帧所应答的请求不在记录中", " answers is not in the capture"));
        }
        Note::AnsweredByAbort => {
            put!(out; lang.pick("第", "the request in frame "), about);
            put!(out; lang.pick("帧的请求已由在它之前记录到的中止应答", " was answered by the abort captured before it"));
        }
        Note::LostByReset => {
            put!(out; lang.pick("第", "the SDO transfer that began in frame "), about);
            put!(out; lang.pick("帧开始的SDO传输因节点复位而终止", " was ended by a reset of the node"));
        }
        Note::LssSelected { address } => {
            put!(out; lang.pick("从站已进入配置状态: ", "slave in configuration state: "));
            parts(out, lang, address.map(Some));
        }
        Note::Fastscan(scanned) => fastscan(out, lang, scanned, about),
        Note::BitTimingActivated { delay, rate } => {
            put!(out; lang.pick("此后", "the bus has to be silent for "), u32::from(delay) * 2);
            put!(out; lang.pick("ms总线应静默, 之后", " ms, then "));
            match rate {
                Some(rate) => put!(out; lang.pick("波特率为", "the bit rate is "), rate, " kbit/s: "),
                None => put!(out; lang.pick("波特率改变: ", "the bit rate is another one: ")),
            }
            let old = "captured at the old one there are only errors, or nothing";
            put!(out; lang.pick("仍用旧波特率记录只会看到错误或静默", old));
        }
        Note::NodeIdChanged { from, to } => {
            put!(out; lang.pick("节点", "the node-ID of node "), from, lang.pick("的节点ID改为", " is "), to);
            put!(out; lang.pick(" (第", " now (accepted in frame "), about, lang.pick("帧接受)", ")"));
        }
    }
}

/// A Fastscan is over.
fn fastscan(out: &mut Vec<u8>, lang: Lang, scanned: Scanned, about: u64) {
    put!(out; lang.pick("第", "the Fastscan that began in frame "), about, lang.pick("帧开始的快速扫描", ""));
    if scanned.found {
        put!(out; lang.pick("找到从站: ", " has found a slave: "));
        parts(out, lang, scanned.address);
        if scanned.address.iter().any(Option::is_none) {
            put!(out; lang.pick(", 其余部分不在记录中", ", the rest is not in the capture"));
        }
    } else {
        put!(out; lang.pick("未完成", " is incomplete"));
        if scanned.address.iter().any(Option::is_some) {
            put!(out; lang.pick(", 已确认: ", ", confirmed: "));
            parts(out, lang, scanned.address);
        }
    }
    let requests = if scanned.frames == 1 { " request" } else { " requests" };
    put!(out; " (", scanned.frames, lang.pick("个请求", requests));
    if let Some(ns) = scanned.duration_ns {
        put!(out; lang.pick(", 历时", " in "));
        sentence::duration(out, ns);
    }
    put!(out; ")");
}

fn parts(out: &mut Vec<u8>, lang: Lang, address: [Option<u32>; 4]) {
    let mut between = "";
    for (number, value) in (0..).zip(address) {
        if let (Some(part), Some(value)) = (Part::from_number(number), value) {
            put!(out; between, terms::lss::part(lang, part), "=", Hex::<8>(u64::from(value)), "h");
            between = ", ";
        }
    }
}

//! The meaning of numbers in a device's communication parameters (CiA 301, 7.5.2): identifiers and their flags,
//! transmission types, mapped objects, consumer heartbeat times, the device profile. It is appended to the number, so
//! that a configuration can be read line by line.

use super::Lang;
use super::digits::{Hex, put};
use crate::sdo::wire::Mux;
use crate::wire::pdo::mapping::decode_entry;

const INVALID: u32 = 1 << 31;
const NO_RTR: u32 = 1 << 30;
const EXTENDED: u32 = 1 << 29;
/// In the COB-IDs of SYNC and TIME: the device produces it.
const PRODUCES: u32 = 1 << 30;

/// Appends ` (6041h:00, 16位)`, ` (185h, 有效, 不允许RTR)`, ` 同步循环`: nothing for other objects.
pub fn words(out: &mut Vec<u8>, lang: Lang, mux: Mux, bytes: &[u8]) {
    match (mux.index, mux.sub, bytes) {
        (0x1400..=0x15FF, 1, &[a, b, c, d]) => cob_id(out, lang, u32::from_le_bytes([a, b, c, d]), false),
        (0x1800..=0x19FF, 1, &[a, b, c, d]) => cob_id(out, lang, u32::from_le_bytes([a, b, c, d]), true),
        (0x1400..=0x15FF | 0x1800..=0x19FF, 2, &[kind]) => put!(out; " ", transmission(lang, kind)),
        (0x1600..=0x17FF | 0x1A00..=0x1BFF, 1..=64, &[a, b, c, d]) => {
            entry(out, lang, u32::from_le_bytes([a, b, c, d]))
        }
        (0x1000, 0, &[a, b, c, d]) => {
            device_type(out, lang, u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d]));
        }
        (0x1018, 3, &[a, b, c, d]) => {
            put!(out; " (", u16::from_le_bytes([c, d]), ".", u16::from_le_bytes([a, b]), ")");
        }
        (0x1016, 1..=127, &[a, b, c, d]) => consumer_time(out, lang, u16::from_le_bytes([a, b]), c, d),
        (0x1005, 0, &[a, b, c, d]) => {
            let made =
                |entry| if entry & PRODUCES == 0 { ("消费者", "consumer") } else { ("生产者", "producer") };
            used(out, lang, u32::from_le_bytes([a, b, c, d]), made);
        }
        (0x1012, 0, &[a, b, c, d]) => used(out, lang, u32::from_le_bytes([a, b, c, d]), |entry| {
            match (entry & INVALID != 0, entry & PRODUCES != 0) {
                (true, true) => ("生产者和消费者", "producer and consumer"),
                (true, false) => ("消费者", "consumer"),
                (false, true) => ("生产者", "producer"),
                (false, false) => ("未使用", "not used"),
            }
        }),
        (0x1014, 0, &[a, b, c, d]) | (0x1028, 1..=127, &[a, b, c, d]) => {
            cob_id(out, lang, u32::from_le_bytes([a, b, c, d]), false);
        }
        (0x1200..=0x12FF, 1 | 2, &[a, b, c, d]) => cob_id(out, lang, u32::from_le_bytes([a, b, c, d]), false),
        _ => {}
    }
}

/// Appends the device profile, and the additional information of the other half (CiA 301, 7.5.2.1).
fn device_type(out: &mut Vec<u8>, lang: Lang, profile: u16, info: u16) {
    match profile {
        0 => put!(out; lang.pick(" (无设备规范)", " (no device profile)")),
        0xFFFF => put!(out; lang.pick(" (多个设备规范)", " (several device profiles)")),
        _ => {
            put!(out; lang.pick(" (设备规范", " (device profile "), profile);
            if info != 0 {
                put!(out; lang.pick(", 附加信息", ", additional information "), Hex::<4>(u64::from(info)), "h");
            }
            put!(out; ")");
        }
    }
}

/// Appends the monitored node and the limit of a consumer heartbeat time (CiA 301, 7.5.2.17).
fn consumer_time(out: &mut Vec<u8>, lang: Lang, ms: u16, node: u8, reserved: u8) {
    match node {
        1..=127 if reserved == 0 && ms > 0 => put!(out; lang.pick(" (节点", " (node "), node, ", ", ms, " ms)"),
        _ => put!(out; lang.pick(" (未使用)", " (not used)")),
    }
}

/// Appends an identifier and its use by the device.
fn used(out: &mut Vec<u8>, lang: Lang, entry: u32, made: impl Fn(u32) -> (&'static str, &'static str)) {
    let (zh, en) = made(entry);
    put!(out; " (");
    identifier(out, entry);
    put!(out; "h, ", lang.pick(zh, en), ")");
}

fn identifier(out: &mut Vec<u8>, entry: u32) {
    let id = u64::from(entry & 0x1FFF_FFFF);
    if entry & EXTENDED == 0 { put!(out; Hex::<3>(id & 0x7FF)) } else { put!(out; Hex::<8>(id)) }
}

fn cob_id(out: &mut Vec<u8>, lang: Lang, entry: u32, transmit: bool) {
    put!(out; " (");
    identifier(out, entry);
    let valid = entry & INVALID == 0;
    put!(out; if valid { lang.pick("h, 有效", "h, valid") } else { lang.pick("h, 无效", "h, invalid") });
    if transmit {
        let rtr = entry & NO_RTR == 0;
        put!(out; if rtr { lang.pick(", 允许RTR", ", RTR allowed") } else { lang.pick(", 不允许RTR", ", no RTR") });
    }
    put!(out; ")");
}

fn entry(out: &mut Vec<u8>, lang: Lang, word: u32) {
    let (index, sub, bits) = decode_entry(word);
    if word == 0 {
        return;
    }
    put!(out; " (", Mux { index, sub }, ", ", bits, lang.pick("位)", if bits == 1 { " bit)" } else { " bits)" }));
}

/// Returns the meaning of a transmission type (CiA 301, tables 67 and 71).
pub fn transmission(lang: Lang, kind: u8) -> &'static str {
    match kind {
        0 => lang.pick("同步非循环", "synchronous acyclic"),
        1..=240 => lang.pick("同步循环", "synchronous cyclic"),
        241..=251 => lang.pick("保留", "reserved"),
        252 => lang.pick("仅远程帧, 同步", "RTR-only, synchronous"),
        253 => lang.pick("仅远程帧, 事件", "RTR-only, event"),
        254 => lang.pick("事件驱动(制造商定义)", "event-driven (manufacturer)"),
        255 => lang.pick("事件驱动(设备规范定义)", "event-driven (device profile)"),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;

    #[test]
    fn configuration_in_words() {
        for (index, sub, bytes, zh, en) in [
            (0x1800, 1, &[0x85, 1, 0, 0x40][..], " (185h, 有效, 不允许RTR)", " (185h, valid, no RTR)"),
            (0x1803, 1, &[0x85, 1, 0, 0x80], " (185h, 无效, 允许RTR)", " (185h, invalid, RTR allowed)"),
            (0x1400, 1, &[0x78, 0x56, 0x34, 0x32], " (12345678h, 有效)", " (12345678h, valid)"),
            (0x1800, 2, &[1], " 同步循环", " synchronous cyclic"),
            (0x1400, 2, &[0xFE], " 事件驱动(制造商定义)", " event-driven (manufacturer)"),
            (0x1A00, 1, &[0x10, 0, 0x41, 0x60], " (6041h:00, 16位)", " (6041h:00, 16 bits)"),
            (0x1600, 64, &[1, 0, 1, 0], " (0001h:00, 1位)", " (0001h:00, 1 bit)"),
            (
                0x1000,
                0,
                &[0x92, 1, 2, 0],
                " (设备规范402, 附加信息0002h)",
                " (device profile 402, additional information 0002h)",
            ),
            (0x1000, 0, &[0; 4], " (无设备规范)", " (no device profile)"),
            (0x1005, 0, &[0x80, 0, 0, 0x40], " (080h, 生产者)", " (080h, producer)"),
            (0x1005, 0, &[0x80, 0, 0, 0], " (080h, 消费者)", " (080h, consumer)"),
            (0x1012, 0, &[0, 1, 0, 0xC0], " (100h, 生产者和消费者)", " (100h, producer and consumer)"),
            (0x1014, 0, &[0x85, 0, 0, 0x80], " (085h, 无效)", " (085h, invalid)"),
            (0x1016, 1, &[0xF4, 1, 5, 0], " (节点5, 500 ms)", " (node 5, 500 ms)"),
            (0x1016, 2, &[0; 4], " (未使用)", " (not used)"),
            (0x1018, 3, &[1, 0, 2, 0], " (2.1)", " (2.1)"),
            (0x1200, 2, &[0x85, 5, 0, 0], " (585h, 有效)", " (585h, valid)"),
            (0x1A00, 0, &[2], "", ""),
            (0x1A00, 1, &[0; 4], "", ""),
            (0x1A00, 1, &[0; 3], "", ""),
            (0x1017, 0, &[0xE8, 3], "", ""),
        ] {
            for (lang, text) in [(Lang::Zh, zh), (Lang::En, en)] {
                let mut out = Vec::new();
                words(&mut out, lang, Mux { index, sub }, bytes);
                assert_eq!(String::from_utf8(out).unwrap(), text, "{index:04X}:{sub}");
            }
        }
    }
}

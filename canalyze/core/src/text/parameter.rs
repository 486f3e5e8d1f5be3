//! What the numbers in a PDO's parameters say (CiA 301, 7.5.2.35 to .38): the identifier and its flags, the
//! transmission type, the mapped object. Appended behind the number, so that a configuration can be read line by line.

use super::Lang;
use super::digits::{Hex, put};
use crate::services::pdo::mapping::decode_entry;
use crate::services::sdo::wire::Mux;

const INVALID: u32 = 1 << 31;
const NO_RTR: u32 = 1 << 30;
const EXTENDED: u32 = 1 << 29;

/// Appends ` (6041h:00, 16位)`, ` (185h, 有效, 不允许RTR)`, ` 同步循环`: nothing for other objects.
pub fn words(out: &mut Vec<u8>, lang: Lang, mux: Mux, bytes: &[u8]) {
    match (mux.index, mux.sub, bytes) {
        (0x1400..=0x15FF, 1, &[a, b, c, d]) => cob_id(out, lang, u32::from_le_bytes([a, b, c, d]), false),
        (0x1800..=0x19FF, 1, &[a, b, c, d]) => cob_id(out, lang, u32::from_le_bytes([a, b, c, d]), true),
        (0x1400..=0x15FF | 0x1800..=0x19FF, 2, &[kind]) => put!(out; " ", transmission(lang, kind)),
        (0x1600..=0x17FF | 0x1A00..=0x1BFF, 1..=64, &[a, b, c, d]) => {
            entry(out, lang, u32::from_le_bytes([a, b, c, d]))
        }
        _ => {}
    }
}

fn cob_id(out: &mut Vec<u8>, lang: Lang, entry: u32, transmit: bool) {
    let id = u64::from(entry & 0x1FFF_FFFF);
    put!(out; " (");
    if entry & EXTENDED == 0 {
        put!(out; Hex::<3>(id & 0x7FF))
    } else {
        put!(out; Hex::<8>(id))
    }
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

/// What a transmission type means (CiA 301, tables 67 and 71).
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

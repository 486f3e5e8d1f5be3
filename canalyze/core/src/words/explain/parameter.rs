//! The bits of what an SDO carries for a communication parameter (CiA 301, 7.5.2), as one line under its data: COB-IDs,
//! consumer heartbeat times, mapped objects, the device type.
//!
//! Bits are those of the number that the bytes make, read little-endian. Other objects have no line. Must not judge.

use crate::sdo::wire::Mux;
use crate::words::Lang;
use crate::words::digits::{Hex, Put, put};

/// The meaning of the upper bits of a COB-ID.
#[derive(Clone, Copy)]
enum Flags {
    /// Bit 31: it is not used.
    Valid,
    /// The same, and bit 30: no remote frames.
    Transmit,
    /// Bit 30: the device produces it.
    Sync,
    /// Bit 31: the device consumes it; bit 30: it produces it.
    Time,
}

/// Appends the line, where the object has one and the data are whole.
pub fn bits(out: &mut Vec<u8>, lang: Lang, mux: Mux, data: &[u8]) {
    let Some(word) = data.first_chunk::<4>().filter(|_| data.len() == 4).copied().map(u32::from_le_bytes) else {
        return;
    };
    let flags = match (mux.index, mux.sub) {
        (0x1005, 0) => Flags::Sync,
        (0x1012, 0) => Flags::Time,
        (0x1800..=0x19FF, 1) => Flags::Transmit,
        (0x1014, 0) | (0x1028, 1..=127) | (0x1200..=0x12FF, 1 | 2) | (0x1400..=0x15FF, 1) => Flags::Valid,
        _ => return other(out, lang, mux, word),
    };
    put!(out; "#     ", Hex::<8>(u64::from(word)), "h: ");
    let (upper, next) = (word >> 31 & 1, word >> 30 & 1);
    let pick = |bit: u32, set: (&'static str, &'static str), clear: (&'static str, &'static str)| {
        let (zh, en) = if bit == 1 { set } else { clear };
        lang.pick(zh, en)
    };
    let valid = || pick(upper, ("无效", "invalid"), ("有效", "valid"));
    let produces = || pick(next, ("生产者", "producer"), ("不是生产者", "no producer"));
    match flags {
        Flags::Valid => {
            put!(out; Bit(lang, 31), upper, " ", valid(), " | ", Bit(lang, 30), next, lang.pick(" 保留", " reserved"))
        }
        Flags::Transmit => {
            let rtr = pick(next, ("不允许RTR", "no RTR"), ("允许RTR", "RTR allowed"));
            put!(out; Bit(lang, 31), upper, " ", valid(), " | ", Bit(lang, 30), next, " ", rtr);
        }
        Flags::Sync => {
            put!(out; Bit(lang, 31), upper, lang.pick(" 无意义", " do not care"), " | ", Bit(lang, 30), next, " ", produces())
        }
        Flags::Time => {
            let consumes = pick(upper, ("消费者", "consumer"), ("不是消费者", "no consumer"));
            put!(out; Bit(lang, 31), upper, " ", consumes, " | ", Bit(lang, 30), next, " ", produces());
        }
    }
    let extended = word >> 29 & 1;
    let frame = pick(extended, ("29位", "29-bit"), ("11位", "11-bit"));
    put!(out; " | ", Bit(lang, 29), extended, " ", frame, " | ");
    let id = u64::from(word & 0x1FFF_FFFF);
    match extended {
        0 => put!(out; BitRange(lang, 10, 0), Hex::<3>(id & 0x7FF), "h\n"),
        _ => put!(out; BitRange(lang, 28, 0), Hex::<8>(id), "h\n"),
    }
}

fn other(out: &mut Vec<u8>, lang: Lang, mux: Mux, word: u32) {
    let (upper, lower) = (u64::from(word >> 16), word & 0xFFFF);
    let head = |out: &mut Vec<u8>| put!(out; "#     ", Hex::<8>(u64::from(word)), "h: ");
    match (mux.index, mux.sub) {
        (0x1000, 0) => {
            head(out);
            put!(out; BitRange(lang, 31, 16), Hex::<4>(upper), lang.pick("h 附加信息 | ", "h additional information | "));
            put!(out; BitRange(lang, 15, 0), Hex::<4>(u64::from(lower)), lang.pick("h = 设备规范", "h = device profile "), lower, "\n");
        }
        (0x1016, 1..=127) => {
            head(out);
            let node = word >> 16 & 0xFF;
            put!(out; BitRange(lang, 23, 16), Hex::<2>(u64::from(node)), lang.pick("h = 节点", "h = node "), node, " | ");
            put!(out; BitRange(lang, 15, 0), Hex::<4>(u64::from(lower)), "h = ", lower, " ms\n");
        }
        (0x1018, 3) => {
            head(out);
            put!(out; BitRange(lang, 31, 16), lang.pick("主版本", "major revision "), upper, " | ");
            put!(out; BitRange(lang, 15, 0), lang.pick("次版本", "minor revision "), lower, "\n");
        }
        (0x1600..=0x17FF | 0x1A00..=0x1BFF, 1..=64) => {
            head(out);
            let (sub, length) = (u64::from(word >> 8 & 0xFF), word & 0xFF);
            put!(out; BitRange(lang, 31, 16), lang.pick("索引", "index "), Hex::<4>(upper), "h | ");
            put!(out; BitRange(lang, 15, 8), lang.pick("子索引", "sub-index "), Hex::<2>(sub), "h | ");
            put!(out; BitRange(lang, 7, 0), lang.pick("长度", "length "), length, lang.pick("位\n", if length == 1 { " bit\n" } else { " bits\n" }));
        }
        _ => {}
    }
}

/// `bit 31: `
struct Bit(Lang, u8);

impl Put for Bit {
    fn put(&self, out: &mut Vec<u8>) {
        put!(out; self.0.pick("位", "bit "), self.1, ": ");
    }
}

/// `bits 15-0: `
struct BitRange(Lang, u8, u8);

impl Put for BitRange {
    fn put(&self, out: &mut Vec<u8>) {
        put!(out; self.0.pick("位", "bits "), self.1, "-", self.2, ": ");
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;

    fn line(lang: Lang, index: u16, sub: u8, word: u32) -> String {
        let mut out = Vec::new();
        bits(&mut out, lang, Mux { index, sub }, &word.to_le_bytes());
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn bits_of_communication_parameters() {
        for (index, sub, word, zh, en) in [
            (
                0x1800,
                1,
                0x4000_0181,
                "位31: 0 有效 | 位30: 1 不允许RTR | 位29: 0 11位 | 位10-0: 181h",
                "bit 31: 0 valid | bit 30: 1 no RTR | bit 29: 0 11-bit | bits 10-0: 181h",
            ),
            (
                0x1400,
                1,
                0xA012_3456,
                "位31: 1 无效 | 位30: 0 保留 | 位29: 1 29位 | 位28-0: 00123456h",
                "bit 31: 1 invalid | bit 30: 0 reserved | bit 29: 1 29-bit | bits 28-0: 00123456h",
            ),
            (
                0x1005,
                0,
                0x4000_0080,
                "位31: 0 无意义 | 位30: 1 生产者 | 位29: 0 11位 | 位10-0: 080h",
                "bit 31: 0 do not care | bit 30: 1 producer | bit 29: 0 11-bit | bits 10-0: 080h",
            ),
            (
                0x1012,
                0,
                0x8000_0100,
                "位31: 1 消费者 | 位30: 0 不是生产者 | 位29: 0 11位 | 位10-0: 100h",
                "bit 31: 1 consumer | bit 30: 0 no producer | bit 29: 0 11-bit | bits 10-0: 100h",
            ),
            (
                0x1016,
                1,
                0x0003_0032,
                "位23-16: 03h = 节点3 | 位15-0: 0032h = 50 ms",
                "bits 23-16: 03h = node 3 | bits 15-0: 0032h = 50 ms",
            ),
            (
                0x1000,
                0,
                0x0002_0192,
                "位31-16: 0002h 附加信息 | 位15-0: 0192h = 设备规范402",
                "bits 31-16: 0002h additional information | bits 15-0: 0192h = device profile 402",
            ),
            (
                0x1018,
                3,
                0x0001_0033,
                "位31-16: 主版本1 | 位15-0: 次版本51",
                "bits 31-16: major revision 1 | bits 15-0: minor revision 51",
            ),
            (
                0x1A00,
                2,
                0x6041_0010,
                "位31-16: 索引6041h | 位15-8: 子索引00h | 位7-0: 长度16位",
                "bits 31-16: index 6041h | bits 15-8: sub-index 00h | bits 7-0: length 16 bits",
            ),
        ] {
            assert_eq!(line(Lang::Zh, index, sub, word), format!("#     {word:08X}h: {zh}\n"));
            assert_eq!(line(Lang::En, index, sub, word), format!("#     {word:08X}h: {en}\n"));
        }
        for (index, sub) in [(0x1400, 2), (0x2000, 1), (0x1016, 0), (0x1018, 1)] {
            assert_eq!(line(Lang::En, index, sub, 5), "", "{index:X}:{sub}");
        }
        let mut out = Vec::new();
        bits(&mut out, Lang::En, Mux { index: 0x1400, sub: 1 }, &[1, 2]);
        assert!(out.is_empty(), "half a COB-ID is none");
    }
}

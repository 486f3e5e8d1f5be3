//! The breakdown of a PDO by its mapping: of each entry its bytes and bits, the mapping parameter's word, and the
//! value; then what the mapping leaves over.
//!
//! ```text
//! #   映射: 2个对象, 19位, 需3字节
//! #   37 06 = 0637h (小端格式)  字节0-1 | 60410010h: 索引6041h, 子索引00h, 16位 | 状态字=0637h 运行使能
//! #     0637h & 006Fh = 0027h: 运行使能
//! #     位0: 1 准备接通 | 位1: 1 已接通 | ...
//! #   15 = 0001 0101b  字节2 位2-0: 101b | 20020003h: 索引2002h, 子索引00h, 3位 | 2002h:00=5
//! #   15 = 0001 0101b  字节2 位7-3: 00010b | 映射之外
//! ```
//!
//! Bits are counted as in the number that the shown bytes make, read little-endian. Which mapping holds is given;
//! a payload that does not reach an entry is called short, which is no verdict on the frame.

use crate::wire::pdo::mapping::{Mapped, Mapping, Number, number};
use crate::words::digits::{Hex, Nibbles, Put, Spaced, binary, put};
use crate::words::value::{self, Size};
use crate::words::{Lang, say, signal, terms};
use crate::world::drive::{self, DriveObject, DriveState};

/// Most bytes of a bit field that are shown in binary.
const BINARY: usize = 4;
/// Most bytes in one line.
const LINE: usize = 16;

/// Appends the breakdown of a payload, whole lines.
pub fn mapping(out: &mut Vec<u8>, lang: Lang, mapping: &Mapping, payload: &[u8]) {
    let (count, size) = (mapping.entries.len(), Size(lang, mapping.bytes() as u64));
    let bits = Bits(lang, mapping.bits);
    say!(out, lang;
        zh: "#   映射: ", count, "个对象, ", bits, ", 需", size, "\n";
        en: "#   mapping: ", count, if count == 1 { " entry, " } else { " entries, " }, bits, ", takes ", size, "\n");
    for mapped in &mapping.entries {
        entry(out, lang, mapping, mapped, payload);
    }
    let end = usize::from(mapping.bits);
    let (whole, rest) = (end.div_ceil(8), 8 * end.div_ceil(8) - end);
    if rest > 0 && whole <= payload.len() {
        field(out, lang, payload, end, rest);
        put!(out; lang.pick(" | 映射之外\n", " | beyond the mapping\n"));
    }
    for (no, beyond) in payload.get(whole..).unwrap_or_default().chunks(LINE).enumerate() {
        field(out, lang, payload, 8 * (whole + LINE * no), 8 * beyond.len());
        put!(out; lang.pick(" | 映射之外\n", " | beyond the mapping\n"));
    }
}

fn entry(out: &mut Vec<u8>, lang: Lang, mapping: &Mapping, mapped: &Mapped, payload: &[u8]) {
    field(out, lang, payload, usize::from(mapped.offset), usize::from(mapped.bits));
    put!(out; " | ", Hex::<8>(u64::from(mapped.word())), "h: ");
    match mapped.data_type {
        Some(data_type) if mapped.dummy => put!(out; lang.pick("虚映射 ", "dummy "), data_type.name()),
        _ if mapped.dummy => put!(out; lang.pick("虚映射 ", "dummy "), Hex::<4>(u64::from(mapped.index)), "h"),
        _ => {
            put!(out; lang.pick("索引", "index "), Hex::<4>(u64::from(mapped.index)));
            put!(out; lang.pick("h, 子索引", "h, sub-index "), Hex::<2>(u64::from(mapped.sub)), "h");
        }
    }
    put!(out; ", ", Bits(lang, u16::from(mapped.bits)), " | ");
    match (mapping.raw(mapped, payload), mapping.octets(mapped, payload)) {
        _ if mapped.bits == 0 => put!(out; lang.pick("没有数据位", "no bits")),
        (None, None) if reaches(mapped, payload) => put!(out; lang.pick("超过64位", "more than 64 bits")),
        (None, None) => put!(out; lang.pick("数据不足", "beyond the end of the data")),
        _ if mapped.dummy => put!(out; lang.pick("跳过", "skipped")),
        (None, Some(octets)) => {
            signal::name(out, lang, mapped);
            put!(out; "=");
            value::value(out, lang, mapped.data_type, octets, octets.len() as u64);
        }
        (Some(raw), _) => {
            signal::signal(out, lang, mapped, raw);
            scale(out, mapped, raw);
            put!(out; "\n");
            if mapped.is_drives() {
                words(out, lang, mapped, raw);
            }
            return;
        }
    }
    put!(out; "\n");
}

fn reaches(mapped: &Mapped, payload: &[u8]) -> bool {
    usize::from(mapped.offset) + usize::from(mapped.bits) <= 8 * payload.len()
}

/// The bytes that `count` bits from bit `offset` of the payload on touch, and where they lie:
/// `#   15 F8 = F815h = 1111 1000 0001 0101b (小端格式)  字节6-7 位15-3: 1111100000010b`.
///
/// Of what the payload does not reach only the place.
fn field(out: &mut Vec<u8>, lang: Lang, payload: &[u8], offset: usize, count: usize) {
    put!(out; "#   ");
    if count == 0 {
        put!(out; "-");
        return;
    }
    let (first, end) = (offset / 8, (offset + count).div_ceil(8));
    let low = offset % 8;
    let aligned = low == 0 && count.is_multiple_of(8);
    let bytes = payload.get(first..end).unwrap_or_default();
    if !bytes.is_empty() {
        put!(out; Spaced(bytes.get(..LINE).unwrap_or(bytes)));
        if bytes.len() > LINE {
            put!(out; " ...");
        }
        if (2..=8).contains(&bytes.len()) {
            put!(out; " = ");
            for byte in bytes.iter().rev() {
                put!(out; Hex::<2>(u64::from(*byte)));
            }
            put!(out; "h");
        }
        if !aligned && bytes.len() <= BINARY {
            put!(out; " = ");
            for (no, byte) in bytes.iter().rev().enumerate() {
                if no > 0 {
                    // Each byte's own `b` is taken back: one number, one mark.
                    out.pop();
                    put!(out; " ");
                }
                put!(out; Nibbles(*byte));
            }
        }
        if (2..=8).contains(&bytes.len()) {
            put!(out; lang.pick(" (小端格式)", " (little-endian)"));
        }
        put!(out; "  ");
    }
    match end.saturating_sub(first) {
        0 | 1 => put!(out; lang.pick("字节", "byte "), first),
        _ => put!(out; lang.pick("字节", "bytes "), first, "-", end - 1),
    }
    if aligned {
        return;
    }
    match count {
        1 => put!(out; lang.pick(" 位", " bit "), low),
        _ => put!(out; lang.pick(" 位", " bits "), low + count - 1, "-", low),
    }
    if let Some(raw) = crate::wire::pdo::mapping::extract(payload, offset, count) {
        put!(out; ": ");
        binary(out, raw, count);
        put!(out; "b");
    }
}

/// Appends the factor of a number: ` (3 x 0.1)`.
fn scale(out: &mut Vec<u8>, mapped: &Mapped, raw: u64) {
    if mapped.factor == 1.0 {
        return;
    }
    match number(mapped.data_type, raw, mapped.bits) {
        Number::Signed(read) => put!(out; " (", read, " x "),
        Number::Unsigned(read) => put!(out; " (", read, " x "),
        _ => return,
    }
    signal::real64(out, mapped.factor);
    put!(out; ")");
}

/// CiA 402's words, bit by bit.
fn words(out: &mut Vec<u8>, lang: Lang, mapped: &Mapped, raw: u64) {
    let word = raw as u16;
    match DriveObject::at(mapped.index) {
        Some(DriveObject::Statusword) => {
            if let Some(state) = DriveState::of(word) {
                let (mask, left) = state.coding();
                put!(out; "#     ", Hex::<4>(u64::from(word)), "h & ", Hex::<4>(u64::from(mask)), "h = ");
                put!(out; Hex::<4>(u64::from(left)), "h: ", terms::drive::state(lang, state), "\n");
            }
            set_bits(out, lang, raw, |bit| terms::find(terms::drive::STATUSWORD, lang, bit));
        }
        Some(DriveObject::Controlword) => {
            put!(out; lang.pick("#     位7: ", "#     bit 7: "), word >> 7 & 1);
            put!(out; lang.pick(" | 位3-0: ", " | bits 3-0: "));
            binary(out, raw, 4);
            put!(out; "b = ");
            put!(out; drive::command(word, None).map_or("", |command| terms::drive::command(lang, command)), "\n");
            set_bits(out, lang, raw, |bit| terms::find(terms::drive::CONTROLWORD, lang, bit));
        }
        Some(DriveObject::SupportedModes) => set_bits(out, lang, raw, |bit| match bit {
            16.. => Some(lang.pick("制造商定义的模式", "manufacturer-specific mode")),
            _ => Some(terms::drive::mode(lang, i8::try_from(bit).unwrap_or(i8::MAX).saturating_add(1))),
        }),
        Some(DriveObject::ModesOfOperation | DriveObject::ModesOfOperationDisplay) | None => {}
    }
}

/// `#     位0: 1 准备接通 | 位5: 1 快速停止(0有效)`; nothing where no bit is set.
fn set_bits(out: &mut Vec<u8>, lang: Lang, raw: u64, name: impl Fn(u8) -> Option<&'static str>) {
    let mut between = "#     ";
    for bit in (0..32_u8).filter(|bit| raw >> bit & 1 != 0) {
        put!(out; between, lang.pick("位", "bit "), bit, ": 1 ", name(bit).unwrap_or_default());
        between = " | ";
    }
    if between == " | " {
        put!(out; "\n");
    }
}

/// A number of bits: `16位`, `16 bits`.
struct Bits(Lang, u16);

impl Put for Bits {
    fn put(&self, out: &mut Vec<u8>) {
        put!(out; self.1, self.0.pick("位", if self.1 == 1 { " bit" } else { " bits" }));
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;
    use crate::world::od::DataType;
    use proptest::prelude::*;

    fn shown(lang: Lang, of: &Mapping, payload: &[u8]) -> String {
        let mut out = Vec::new();
        mapping(&mut out, lang, of, payload);
        String::from_utf8(out).unwrap()
    }

    fn check(lang: Lang, of: &Mapping, payload: &[u8], lines: &[&str]) {
        let text = shown(lang, of, payload);
        assert_eq!(text.lines().collect::<Vec<_>>(), lines, "{text}");
    }

    #[test]
    fn entries_within_bytes() {
        let mut four = Mapping::from_words(&[0x2000_0120, 0x2001_0010, 0x2002_0003, 0x2003_000D]);
        let types = [DataType::Integer32, DataType::Unsigned16, DataType::Unsigned8, DataType::Integer16];
        for (entry, data_type) in four.entries.iter_mut().zip(types) {
            entry.data_type = Some(data_type);
        }
        let payload = [0x9C, 0xFF, 0xFF, 0xFF, 0x34, 0x12, 0x15, 0xF8];
        check(
            Lang::Zh,
            &four,
            &payload,
            &[
                "#   映射: 4个对象, 64位, 需8字节",
                "#   9C FF FF FF = FFFFFF9Ch (小端格式)  字节0-3 | 20000120h: 索引2000h, 子索引01h, 32位 | 2000h:01=-100",
                "#   34 12 = 1234h (小端格式)  字节4-5 | 20010010h: 索引2001h, 子索引00h, 16位 | 2001h:00=4660",
                "#   15 = 0001 0101b  字节6 位2-0: 101b | 20020003h: 索引2002h, 子索引00h, 3位 | 2002h:00=5",
                "#   15 F8 = F815h = 1111 1000 0001 0101b (小端格式)  字节6-7 位15-3: 1111100000010b | 2003000Dh: 索引2003h, 子索引00h, 13位 | 2003h:00=-254",
            ],
        );
        check(
            Lang::En,
            &four,
            &payload[..7],
            &[
                "#   mapping: 4 entries, 64 bits, takes 8 bytes",
                "#   9C FF FF FF = FFFFFF9Ch (little-endian)  bytes 0-3 | 20000120h: index 2000h, sub-index 01h, 32 bits | 2000h:01=-100",
                "#   34 12 = 1234h (little-endian)  bytes 4-5 | 20010010h: index 2001h, sub-index 00h, 16 bits | 2001h:00=4660",
                "#   15 = 0001 0101b  byte 6 bits 2-0: 101b | 20020003h: index 2002h, sub-index 00h, 3 bits | 2002h:00=5",
                "#   bytes 6-7 bits 15-3 | 2003000Dh: index 2003h, sub-index 00h, 13 bits | beyond the end of the data",
            ],
        );
    }

    #[test]
    fn drives() {
        let words = Mapping::from_words(&[0x6041_0010, 0x6061_0008]);
        check(
            Lang::Zh,
            &words,
            &[0x37, 0x06, 0x08],
            &[
                "#   映射: 2个对象, 24位, 需3字节",
                "#   37 06 = 0637h (小端格式)  字节0-1 | 60410010h: 索引6041h, 子索引00h, 16位 | 状态字=0637h 运行使能",
                "#     0637h & 006Fh = 0027h: 运行使能",
                "#     位0: 1 准备接通 | 位1: 1 已接通 | 位2: 1 运行使能 | 位4: 1 主电源已接入 | 位5: 1 快速停止(0有效) | 位9: 1 远程(接受控制字) | 位10: 1 目标到达",
                "#   08  字节2 | 60610008h: 索引6061h, 子索引00h, 8位 | 操作模式显示=8 循环同步位置(CSP)",
            ],
        );
        check(
            Lang::En,
            &words,
            &[0x00, 0x00, 0x00],
            &[
                "#   mapping: 2 entries, 24 bits, takes 3 bytes",
                "#   00 00 = 0000h (little-endian)  bytes 0-1 | 60410010h: index 6041h, sub-index 00h, 16 bits | statusword=0000h not ready to switch on",
                "#     0000h & 004Fh = 0000h: not ready to switch on",
                "#   00  byte 2 | 60610008h: index 6061h, sub-index 00h, 8 bits | modes of operation display=0 no mode",
            ],
        );
        check(
            Lang::En,
            &Mapping::from_words(&[0x6040_0010]),
            &[0x0F, 0x01],
            &[
                "#   mapping: 1 entry, 16 bits, takes 2 bytes",
                "#   0F 01 = 010Fh (little-endian)  bytes 0-1 | 60400010h: index 6040h, sub-index 00h, 16 bits | controlword=010Fh enable operation (halt)",
                "#     bit 7: 0 | bits 3-0: 1111b = enable operation",
                "#     bit 0: 1 switch on | bit 1: 1 enable voltage | bit 2: 1 quick stop (active at 0) | bit 3: 1 enable operation | bit 8: 1 halt",
            ],
        );
        let text = shown(Lang::Zh, &Mapping::from_words(&[0x6502_0020]), &[0x81, 0, 1, 0]);
        assert_eq!(
            text.lines().nth(2),
            Some("#     位0: 1 轮廓位置(PP) | 位7: 1 循环同步位置(CSP) | 位16: 1 制造商定义的模式")
        );
    }

    #[test]
    fn dummies_and_what_is_left_over() {
        let sparse = Mapping::from_words(&[0x0005_0008, 0x2002_0003]);
        check(
            Lang::Zh,
            &sparse,
            &[0x00, 0x15, 0xAA, 0xBB],
            &[
                "#   映射: 2个对象, 11位, 需2字节",
                "#   00  字节0 | 00050008h: 虚映射 UNSIGNED8, 8位 | 跳过",
                "#   15 = 0001 0101b  字节1 位2-0: 101b | 20020003h: 索引2002h, 子索引00h, 3位 | 2002h:00=5",
                "#   15 = 0001 0101b  字节1 位7-3: 00010b | 映射之外",
                "#   AA BB = BBAAh (小端格式)  字节2-3 | 映射之外",
            ],
        );
        check(
            Lang::En,
            &Mapping::from_words(&[0x0001_0001, 0x2000_0000]),
            &[0x01],
            &[
                "#   mapping: 2 entries, 1 bit, takes 1 byte",
                "#   01 = 0000 0001b  byte 0 bit 0: 1b | 00010001h: dummy BOOLEAN, 1 bit | skipped",
                "#   - | 20000000h: index 2000h, sub-index 00h, 0 bits | no bits",
                "#   01 = 0000 0001b  byte 0 bits 7-1: 0000000b | beyond the mapping",
            ],
        );
        check(
            Lang::En,
            &Mapping::default(),
            &[1, 2],
            &[
                "#   mapping: 0 entries, 0 bits, takes 0 bytes",
                "#   01 02 = 0201h (little-endian)  bytes 0-1 | beyond the mapping",
            ],
        );
    }

    #[test]
    fn factors_and_long_entries() {
        let mut of = Mapping::from_words(&[0x2000_0110, 0x2001_0080]);
        of.entries[0].factor = 0.1;
        of.entries[0].data_type = Some(DataType::Integer16);
        of.entries[0].unit = Some("V".into());
        of.entries[1].data_type = Some(DataType::VisibleString);
        let payload: Vec<u8> = [3, 0].into_iter().chain(b'A'..=b'P').collect();
        check(
            Lang::En,
            &of,
            &payload,
            &[
                "#   mapping: 2 entries, 144 bits, takes 18 bytes",
                "#   03 00 = 0003h (little-endian)  bytes 0-1 | 20000110h: index 2000h, sub-index 01h, 16 bits | 2000h:01=0.3 V (3 x 0.1)",
                "#   41 42 43 44 45 46 47 48 49 4A 4B 4C 4D 4E 4F 50  bytes 2-17 | 20010080h: index 2001h, sub-index 00h, 128 bits | 2001h:00=\"ABCDEFGHIJKLMNOP\"",
            ],
        );
    }

    proptest! {
        #[test]
        fn any_mapping_of_any_payload(words: Vec<u32>, small in proptest::collection::vec(0..24_u32, 0..12), payload in proptest::collection::vec(any::<u8>(), 0..=64)) {
            let all: Vec<u32> = small.iter().map(|bits| 0x6041_0000 | bits).chain(words).collect();
            let of = Mapping::from_words(&all);
            for lang in [Lang::Zh, Lang::En] {
                let text = shown(lang, &of, &payload);
                prop_assert!(text.ends_with('\n'));
                prop_assert!(text.lines().all(|line| line.starts_with("#   ")));
                prop_assert!(text.lines().count() > of.entries.len());
            }
        }
    }
}

//! One signal in words, `名称=值 单位`: an entry of a mapping, in a line of its PDO.
//!
//! The communication objects (1000h-1FFFh) have the standard's names. The meanings of 6000h-9FFFh depend on the device's
//! profile, and profiles conflict: 6040h is a drive's controlword, an encoder's acceleration and a hydraulic valve's
//! device control word; 6000h and 6004h are different in each. An object counts as CiA 402's if:
//!
//! 1. CiA 402 has its index and sub-index, and both the mapped length and its known type have the size of CiA 402's type
//!    (no type: the caller knows of another profile, see [`Mapped::data_type`]);
//! 2. a name in a description is CiA 402's English name, except for case, blanks and signs.
//!
//! It then has the standard's name in the chosen language, and words for states, commands and modes. Otherwise it
//! has the description's name as it is; without one, its index: `6401h:01`. Mappings are not decided here.

use std::io::Write;

use crate::sdo::wire::Mux;
use crate::wire::pdo::mapping::{Mapped, Mapping, Number, Written, number};
use crate::words::digits::{Hex, fraction, hex, put};
use crate::words::{Lang, escape, say, terms, value as bytes};
use crate::world::drive::{self, DriveObject, DriveState};
use crate::world::od::{self, DataType};

/// Appends a signal, `速度实际值=120 rpm`. `raw` is the entry's bits, the first lowest.
pub fn signal(out: &mut Vec<u8>, lang: Lang, mapped: &Mapped, raw: u64) {
    name(out, lang, mapped);
    put!(out; "=");
    value(out, lang, mapped, raw);
}

/// Appends every signal of a PDO, with commas between. Dummy entries are skipped; entries beyond the payload are `?`.
pub fn all(out: &mut Vec<u8>, lang: Lang, mapping: &Mapping, payload: &[u8]) {
    let mut first = true;
    for (mapped, how) in mapping.entries.iter().zip(written(mapping, lang)).filter(|(mapped, _)| !mapped.dummy) {
        // Comma, name and equals sign in one piece, without the comma before the first.
        out.extend_from_slice(how.lead.get(if std::mem::take(&mut first) { 2 } else { 0 }..).unwrap_or(&[]));
        match mapping.raw(mapped, payload) {
            Some(raw) => worded(out, lang, mapped, how, raw),
            None => put!(out; "?"),
        }
    }
}

/// Returns the written form of the entries of a mapping, in their order.
pub fn written(mapping: &Mapping, lang: Lang) -> &[Written] {
    let [zh, en] = &mapping.written;
    let kept = match lang {
        Lang::Zh => zh,
        Lang::En => en,
    };
    kept.get_or_init(|| {
        let mut found: Vec<_> = mapping.entries.iter().map(|mapped| write(mapped, lang)).collect();
        tell_apart(mapping, lang, &mut found);
        for how in &mut found {
            how.lead = [b", ", &*how.name, b"="].concat();
        }
        found
    })
}

/// Returns the name of the entry at a place in its mapping, as [`name`] writes it.
pub fn own_name(mapping: &Mapping, lang: Lang, place: usize) -> &[u8] {
    written(mapping, lang).get(place).and_then(|how| how.name.get(..how.own)).unwrap_or(&[])
}

/// Adds its object to each name that occurs more than once (descriptions may repeat names), and its position if the
/// object is mapped more than once.
fn tell_apart(mapping: &Mapping, lang: Lang, found: &mut [Written]) {
    let names: Vec<_> = found.iter().map(|how| how.name.clone()).collect();
    for (place, (how, mapped)) in found.iter_mut().zip(&mapping.entries).enumerate() {
        if mapped.dummy || names.iter().filter(|name| **name == how.name).count() < 2 {
            continue;
        }
        let mux = Mux { index: mapped.index, sub: mapped.sub };
        if has_name(lang, mapped) {
            put!(&mut how.name; " ", mux);
        }
        let before =
            mapping.entries.iter().take(place).filter(|one| (one.index, one.sub) == (mux.index, mux.sub)).count();
        if before > 0 {
            put!(&mut how.name; " (", before + 1, ")");
        }
    }
}

fn write(mapped: &Mapped, lang: Lang) -> Written {
    let mut found = Written::default();
    name(&mut found.name, lang, mapped);
    found.own = found.name.len();
    escape::terminal(&mut found.unit, mapped.unit.as_deref().unwrap_or("").as_bytes());
    if mapped.is_drives() && DriveObject::at(mapped.index).is_some() {
        found.words = od::first_axis(mapped.index);
    }
    found.bit_field = is_bit_field(mapped);
    found.decimals = (1..=9).find(|digits| mapped.factor == 1.0 / 10f64.powi(i32::from(*digits))).unwrap_or(0);
    found
}

/// Appends the name of an entry, as described at the head of this file. The second and further axes of CiA 402 are
/// distinguished from the first: `状态字(轴2)`.
pub fn name(out: &mut Vec<u8>, lang: Lang, mapped: &Mapped) {
    named(out, lang, mapped, true);
}

/// Likewise for a line that already has the object: `1A01h:02 TPDO映射参数`, without a second `:02`.
pub fn name_beside_object(out: &mut Vec<u8>, lang: Lang, mapped: &Mapped) {
    named(out, lang, mapped, false);
}

/// Returns true if an entry has a name: the standard's or the description's.
pub fn has_name(lang: Lang, mapped: &Mapped) -> bool {
    standard_name(lang, mapped).is_some() || mapped.name.as_deref().is_some_and(|given| !given.is_empty())
}

/// Returns all names by which a signal of a PDO may be selected: its own in both languages, that of the description and
/// its object, each by itself, behind the node, and behind node and PDO.
pub fn names(transmit: bool, number: u16, node: u8, mapped: &Mapped) -> Vec<String> {
    let (index, sub) = (mapped.index, mapped.sub);
    let mut own = vec![format!("{index:04X}"), format!("{index:04X}:{sub:02X}"), format!("{index:04X}h:{sub:02X}")];
    for lang in [Lang::Zh, Lang::En] {
        let mut written = Vec::new();
        name(&mut written, lang, mapped);
        own.push(String::from_utf8_lossy(&written).into_owned());
    }
    own.extend(mapped.name.as_deref().map(str::to_owned));
    let pdo = format!("{}{number}", if transmit { "TPDO" } else { "RPDO" });
    let mut all = Vec::new();
    for name in own {
        all.push(format!("{node}.{name}"));
        all.push(format!("{node}.{pdo}.{name}"));
        all.push(name);
    }
    all
}

/// Returns the value of an entry as a number with sign, type and factor; `None` if it is not a number. BOOLEAN is 0 or
/// 1.
pub fn physical(mapped: &Mapped, raw: u64) -> Option<f64> {
    let scaled = |read: f64| if mapped.factor == 1.0 { read } else { product(read, mapped.factor) };
    match number(mapped.data_type, raw, mapped.bits) {
        Number::Bool(on) => Some(f64::from(u8::from(on))),
        Number::Unsigned(read) => Some(scaled(read as f64)),
        Number::Signed(read) => Some(scaled(read as f64)),
        // The shortest decimal of the single precision number, not of its double.
        Number::Real32(read) => read.to_string().parse().ok().map(|read: f64| read * mapped.factor),
        Number::Real64(read) => Some(read * mapped.factor),
        Number::Bytes => None,
    }
}

/// Returns true if its value is a quantity: not a choice, a truth value, bits or text, whose least and greatest values
/// are meaningless.
pub fn is_quantity(mapped: &Mapped) -> bool {
    if mapped.bits > 64 || number(mapped.data_type, 0, mapped.bits) == Number::Bytes {
        return false;
    }
    let choice = mapped.is_drives() && DriveObject::at(mapped.index).is_some();
    !choice && !is_bit_field(mapped) && mapped.bits > 1 && mapped.data_type != Some(DataType::Boolean)
}

fn named(out: &mut Vec<u8>, lang: Lang, mapped: &Mapped, alone: bool) {
    let (index, sub) = (mapped.index, mapped.sub);
    if mapped.dummy {
        say!(out, lang; zh: "虚映射"; en: "dummy");
    } else if let Some(word) = standard_name(lang, mapped) {
        put!(out; word);
        // A sub-index without a name of its own has the object's, like one that does not exist.
        if alone && sub > 0 && Some(word) == terms::object_name(lang, mapped.profile, index, 0xFF) {
            put!(out; ":", Hex::<2>(u64::from(sub)));
        }
        if let Some(axis) = drive::axis(index).filter(|axis| *axis > 0 && mapped.profile.may_be_drive()) {
            say!(out, lang; zh: "(轴", axis + 1, ")"; en: " (axis ", axis + 1, ")");
        }
    } else if let Some(given) = mapped.name.as_deref().filter(|given| !given.is_empty()) {
        escape::terminal(out, given.as_bytes());
    } else {
        put!(out; Hex::<4>(u64::from(index)), "h:", Hex::<2>(u64::from(sub)));
    }
}

/// Appends the value of an entry with its unit, and the meaning of a statusword, a controlword or a mode.
///
/// Bit fields are hexadecimal, as long as they are mapped; a number without a type has that form too, behind the
/// decimal one. BOOLEAN is 0 or 1, as on the wire.
pub fn value(out: &mut Vec<u8>, lang: Lang, mapped: &Mapped, raw: u64) {
    worded(out, lang, mapped, &write(mapped, lang), raw);
}

/// Likewise for the entry at an index of its mapping: what is the same in every frame is not computed again.
pub fn value_at(out: &mut Vec<u8>, lang: Lang, mapping: &Mapping, place: usize, raw: u64) {
    if let (Some(mapped), Some(how)) = (mapping.entries.get(place), written(mapping, lang).get(place)) {
        worded(out, lang, mapped, how, raw);
    }
}

fn worded(out: &mut Vec<u8>, lang: Lang, mapped: &Mapped, how: &Written, raw: u64) {
    let digits = usize::from(mapped.bits.clamp(1, 64)).div_ceil(4);
    let scaled = mapped.factor != 1.0;
    if !scaled && how.bit_field {
        hex(out, raw, digits);
        put!(out; "h");
    } else {
        match number(mapped.data_type, raw, mapped.bits) {
            Number::Bytes => octets(out, lang, mapped, raw),
            Number::Bool(on) => put!(out; u8::from(on)),
            Number::Real32(read) if scaled => real32(out, (f64::from(read) * mapped.factor) as f32),
            Number::Real32(read) => real32(out, read),
            Number::Real64(read) => real64(out, read * mapped.factor),
            Number::Signed(read) if how.decimals > 0 => fixed(out, read < 0, read.unsigned_abs(), how.decimals),
            Number::Unsigned(read) if how.decimals > 0 => fixed(out, false, read, how.decimals),
            Number::Signed(read) if scaled => real64(out, product(read as f64, mapped.factor)),
            Number::Unsigned(read) if scaled => real64(out, product(read as f64, mapped.factor)),
            Number::Signed(read) => put!(out; read),
            Number::Unsigned(read) => {
                put!(out; read);
                if mapped.data_type.is_none() && mapped.bits >= 8 {
                    put!(out; " (");
                    hex(out, read, digits);
                    put!(out; "h)");
                }
            }
        }
    }
    if !how.unit.is_empty() {
        put!(out; " ");
        out.extend_from_slice(&how.unit);
    }
    if how.words != 0 {
        put!(out; " ");
        annotation(out, lang, how.words, raw);
    }
}

/// Appends the meaning of an object's value by CiA 402: `运行使能`, `使能运行`, `循环同步位置(CSP)`. Nothing for other objects. The
/// caller has to know that the device is a drive.
pub fn annotation(out: &mut Vec<u8>, lang: Lang, index: u16, raw: u64) {
    let word = raw as u16;
    match DriveObject::at(index) {
        None => {}
        Some(DriveObject::Statusword) => {
            let undefined = lang.pick("未定义的状态", "undefined state");
            put!(out; DriveState::of(word).map_or(undefined, |state| terms::drive::state(lang, state)));
            if drive::warning(word) {
                say!(out, lang; zh: " (警告)"; en: " (warning)");
            }
        }
        Some(DriveObject::Controlword) => {
            // Without a previous word, bit 7 counts as an edge, so that there always is a command.
            put!(out; drive::command(word, None).map_or("", |command| terms::drive::command(lang, command)));
            if drive::halt(word) {
                say!(out, lang; zh: " (暂停)"; en: " (halt)");
            }
        }
        Some(DriveObject::ModesOfOperation | DriveObject::ModesOfOperationDisplay) => {
            put!(out; terms::drive::mode(lang, (raw as u8).cast_signed()));
        }
        Some(DriveObject::SupportedModes) => {
            let start = out.len();
            for mode in drive::supported_modes(raw as u32).filter_map(terms::drive::abbreviation) {
                if out.len() > start {
                    put!(out; " ");
                }
                put!(out; mode);
            }
            if out.len() == start {
                say!(out, lang; zh: "无标准模式"; en: "no standard mode");
            }
        }
    }
}

/// Returns the standard's name, if the object is certainly the standard's.
fn standard_name(lang: Lang, mapped: &Mapped) -> Option<&'static str> {
    let given = mapped.name.as_deref().is_some_and(|given| !given.is_empty());
    let certain = match mapped.index {
        0x1000..=0x1FFF => true,
        // Names of a description are kept; only those of a drive's objects are well known and translated.
        _ if given => mapped.is_drives() && mapped.is_called_so(),
        _ => mapped.is_of_profile(),
    };
    certain.then(|| terms::object_name(lang, mapped.profile, mapped.index, mapped.sub)).flatten()
}

/// Returns true if the value is read as bits: the standard's bit fields, and a drive's digital inputs and outputs.
fn is_bit_field(mapped: &Mapped) -> bool {
    if mapped.index < 0x6000 {
        return od::is_bit_field(mapped.index, mapped.sub);
    }
    let digital = mapped.profile.may_be_drive() && matches!(od::first_axis(mapped.index), 0x60FD | 0x60FE);
    mapped.is_of_profile() && (digital || mapped.profile.is_bit_field(mapped.index, mapped.sub))
}

/// Appends strings, DOMAINs and dates in the form of SDO's values.
fn octets(out: &mut Vec<u8>, lang: Lang, mapped: &Mapped, raw: u64) {
    let all = raw.to_le_bytes();
    let count = usize::from(mapped.bits).div_ceil(8);
    let whole = all.get(..count).unwrap_or(&all);
    bytes::value(out, lang, mapped.data_type, whole, whole.len() as u64);
}

/// Appends a whole number times a power of ten below 1 with 1 to 9 digits, digit by digit, since such factors are common.
/// `-7534` with one digit is `-753.4`.
pub(crate) fn fixed(out: &mut Vec<u8>, negative: bool, magnitude: u64, digits: u8) {
    if negative {
        out.push(b'-');
    }
    let one = 10u64.pow(u32::from(digits));
    put!(out; magnitude / one);
    // As if it were a fraction of a second.
    let ns = magnitude % one * (1_000_000_000 / one);
    if ns > 0 {
        fraction(out, ns as u32, digits);
        while out.pop_if(|digit| *digit == b'0').is_some() {}
    }
}

/// Multiplies a whole number by its factor: 3 x 0.1 is 0.3. The usual factors are whole or, like 0.01, one divided by a
/// whole number, and a division is exact to the last digit. Otherwise 15 digits suffice for two factors of a few
/// digits.
pub(crate) fn product(read: f64, factor: f64) -> f64 {
    let exact = read * factor;
    let inverse = (1.0 / factor).round();
    if factor == factor.trunc() {
        return exact;
    }
    if 1.0 / inverse == factor {
        return read / inverse;
    }
    format!("{exact:.14e}").parse().unwrap_or(exact)
}

/// Appends the shortest decimal that is read back as the same number; with an exponent if it would be long.
fn real32(out: &mut Vec<u8>, read: f32) {
    // Writing to a vector cannot fail.
    let _ = match read.abs() {
        0.0 | 1e-5..1e10 => write!(out, "{read}"),
        _ if read.is_finite() => write!(out, "{read:e}"),
        _ => write!(out, "{read}"),
    };
}

/// Likewise for double precision.
pub(crate) fn real64(out: &mut Vec<u8>, read: f64) {
    let _ = match read.abs() {
        0.0 | 1e-5..1e16 => write!(out, "{read}"),
        _ if read.is_finite() => write!(out, "{read:e}"),
        _ => write!(out, "{read}"),
    };
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;
    use crate::wire::pdo::mapping::Mapping;
    use proptest::prelude::*;

    fn mapped(word: u32) -> Mapped {
        Mapping::from_words(&[word]).entries.remove(0)
    }

    fn described(word: u32, data_type: DataType, name: &str, unit: &str, factor: f64) -> Mapped {
        let (name, unit) = (Some(name.into()), Some(unit.into()));
        Mapped { data_type: Some(data_type), name, unit, factor, ..mapped(word) }
    }

    fn said(lang: Lang, mapped: &Mapped, raw: u64) -> String {
        let mut out = Vec::new();
        signal(&mut out, lang, mapped, raw);
        String::from_utf8(out).unwrap()
    }

    fn both(mapped: &Mapped, raw: u64, zh: &str, en: &str) {
        assert_eq!(said(Lang::Zh, mapped, raw), zh);
        assert_eq!(said(Lang::En, mapped, raw), en);
    }

    #[test]
    fn no_two_signals_of_a_pdo_have_the_same_name() {
        let channel = |word| described(word, DataType::Unsigned8, "Channel", "", 1.0);
        let mut mapping = Mapping::from_words(&[0x2000_0108, 0x2000_0208, 0x2000_0208, 0x2001_0008, 0x2001_0008]);
        for (place, word) in [0x2000_0108, 0x2000_0208, 0x2000_0208].into_iter().enumerate() {
            let offset = mapping.entries[place].offset;
            mapping.entries[place] = Mapped { offset, ..channel(word) };
        }
        let mut out = Vec::new();
        all(&mut out, Lang::En, &mapping, &[1, 2, 3, 4, 5]);
        let text = String::from_utf8(out).unwrap();
        let names: Vec<_> = text.split(", ").map(|one| one.split('=').next().unwrap()).collect();
        assert_eq!(names, ["Channel 2000h:01", "Channel 2000h:02", "Channel 2000h:02 (2)", "2001h:00", "2001h:00 (2)"]);
    }

    #[test]
    fn a_drive_without_a_description() {
        both(&mapped(0x6041_0010), 0x0637, "状态字=0637h 运行使能", "statusword=0637h operation enabled");
        both(&mapped(0x6041_0010), 0x0298, "状态字=0298h 故障 (警告)", "statusword=0298h fault (warning)");
        both(&mapped(0x6041_0010), 0x0022, "状态字=0022h 未定义的状态", "statusword=0022h undefined state");
        both(&mapped(0x6040_0010), 0x000F, "控制字=000Fh 使能运行", "controlword=000Fh enable operation");
        both(&mapped(0x6040_0010), 0x0106, "控制字=0106h 关闭(Shutdown) (暂停)", "controlword=0106h shutdown (halt)");
        both(&mapped(0x6040_0010), 7, "控制字=0007h 接通/禁止运行", "controlword=0007h switch on / disable operation");
        both(&mapped(0x6040_0010), 0x80, "控制字=0080h 故障复位", "controlword=0080h fault reset");
        both(
            &mapped(0x6060_0008),
            8,
            "操作模式=8 循环同步位置(CSP)",
            "modes of operation=8 cyclic synchronous position (CSP)",
        );
        both(
            &mapped(0x6061_0008),
            0xFF,
            "操作模式显示=-1 制造商定义的模式",
            "modes of operation display=-1 manufacturer-specific mode",
        );
        both(
            &mapped(0x6502_0020),
            0x3ED,
            "支持的驱动模式=000003EDh PP PV TQ HM IP CSP CSV CST",
            "supported drive modes=000003EDh PP PV TQ HM IP CSP CSV CST",
        );
        both(&mapped(0x606C_0020), 0xFFFF_FF88, "速度实际值=-120", "velocity actual value=-120");
        both(&mapped(0x60FD_0020), 5, "数字输入=00000005h", "digital inputs=00000005h");
        both(&mapped(0x60FE_0120), 0x10000, "数字输出值=00010000h", "physical outputs=00010000h");
        both(&mapped(0x603F_0010), 0x8130, "错误码=8130h", "error code=8130h");
        both(
            &mapped(0x6841_0010),
            0x0250,
            "状态字(轴2)=0250h 禁止接通",
            "statusword (axis 2)=0250h switch on disabled",
        );
    }

    #[test]
    fn communication_objects() {
        both(&mapped(0x1001_0008), 0x11, "错误寄存器=11h", "error register=11h");
        both(&mapped(0x1003_0220), 0x8130, "预定义错误区:02=00008130h", "pre-defined error field:02=00008130h");
        both(&mapped(0x1013_0020), 1000, "高分辨率时间戳=1000", "high resolution time stamp=1000");
    }

    #[test]
    fn other_profiles_are_no_drives() {
        // I/O modules (CiA 401), encoders (CiA 406), hydraulics (CiA 408): by sub-index, length or description.
        both(&mapped(0x6000_0108), 0xA5, "6000h:01=165 (A5h)", "6000h:01=165 (A5h)");
        both(&mapped(0x6401_0110), 0x7FFF, "6401h:01=32767 (7FFFh)", "6401h:01=32767 (7FFFh)");
        both(&mapped(0x6004_0020), 1, "6004h:00=1 (00000001h)", "6004h:00=1 (00000001h)");
        both(&mapped(0x6040_0110), 0x000F, "6040h:01=15 (000Fh)", "6040h:01=15 (000Fh)");
        both(&mapped(0x6502_0010), 7, "6502h:00=7", "6502h:00=7");
        let valve = described(0x6040_0010, DataType::Unsigned16, "Device control word", "", 1.0);
        both(&valve, 0x000F, "Device control word=15", "Device control word=15");
        let unknown = Mapped { data_type: None, ..mapped(0x6040_0010) };
        both(&unknown, 0x000F, "6040h:00=15 (000Fh)", "6040h:00=15 (000Fh)");
        let encoder = described(0x6004_0020, DataType::Unsigned32, "Position value", "", 1.0);
        both(&encoder, 12345, "Position value=12345", "Position value=12345");
    }

    #[test]
    fn descriptions() {
        let name = "Position_Actual_Value";
        let position = described(0x6064_0020, DataType::Integer32, name, "°", 0.1);
        both(&position, 3, "位置实际值=0.3 °", "position actual value=0.3 °");
        let speed = described(0x2000_0110, DataType::Integer16, "Speed\u{1b}[31m", "rpm", 1.0);
        both(&speed, 120, "Speed\\x1B[31m=120 rpm", "Speed\\x1B[31m=120 rpm");
        let unsigned = described(0x6060_0008, DataType::Unsigned8, "Modes of operation", "", 1.0);
        both(&unsigned, 8, "操作模式=8 循环同步位置(CSP)", "modes of operation=8 cyclic synchronous position (CSP)");
        let nameless = described(0x2000_0110, DataType::Integer16, "", "", 1.0);
        both(&nameless, 0xFFFF, "2000h:01=-1", "2000h:01=-1");
    }

    #[test]
    fn numbers() {
        let value = |data_type, bits: u32, factor, raw| {
            let text = said(Lang::En, &described(0x2000_0100 | bits, data_type, "x", "", factor), raw);
            text.strip_prefix("x=").unwrap().to_owned()
        };
        assert_eq!(value(DataType::Boolean, 1, 1.0, 1), "1");
        assert_eq!(value(DataType::Boolean, 8, 1.0, 0), "0");
        assert_eq!(value(DataType::Boolean, 8, 1.0, 3), "3");
        assert_eq!(value(DataType::Unsigned64, 64, 1.0, u64::MAX), "18446744073709551615");
        assert_eq!(value(DataType::Integer8, 4, 1.0, 0b1000), "-8");
        assert_eq!(value(DataType::Integer16, 16, 0.01, 0xFFFF), "-0.01");
        assert_eq!(value(DataType::Unsigned16, 16, 0.07, 3), "0.21");
        assert_eq!(value(DataType::Unsigned16, 16, 10.0, 12), "120");
        assert_eq!(value(DataType::Unsigned32, 32, 1.0 / 3.0, 2), "0.6666666666666666");
        assert_eq!(value(DataType::Real32, 32, 1.0, u64::from(0.1_f32.to_bits())), "0.1");
        assert_eq!(value(DataType::Real32, 32, 10.0, u64::from(0.1_f32.to_bits())), "1");
        assert_eq!(value(DataType::Real32, 32, 1.0, u64::from(f32::MAX.to_bits())), "3.4028235e38");
        assert_eq!(value(DataType::Real32, 32, 1.0, u64::from(f32::NAN.to_bits())), "NaN");
        assert_eq!(value(DataType::Real64, 64, 1.0, (-2.5_f64).to_bits()), "-2.5");
        assert_eq!(value(DataType::Real64, 64, 1.0, 0), "0");
        assert_eq!(value(DataType::VisibleString, 32, 1.0, 0x6576_6173), "\"save\"");
        assert_eq!(value(DataType::OctetString, 16, 1.0, 0x1234), "34 12");
        assert_eq!(value(DataType::TimeOfDay, 48, 1.0, 14750 << 32 | 45_296_789), "14750d 12:34:56.789");
    }

    #[test]
    fn without_a_type() {
        both(&mapped(0x2000_0120), 0xFFFF_FF9C, "2000h:01=4294967196 (FFFFFF9Ch)", "2000h:01=4294967196 (FFFFFF9Ch)");
        both(&mapped(0x2000_0101), 1, "2000h:01=1", "2000h:01=1");
        both(&mapped(0x0005_0008), 0, "虚映射=0", "dummy=0");
    }

    #[test]
    fn words_alone() {
        let word = |lang, index, raw| {
            let mut out = Vec::new();
            annotation(&mut out, lang, index, raw);
            String::from_utf8(out).unwrap()
        };
        assert_eq!(word(Lang::Zh, 0x6041, 0x0218), "故障");
        assert_eq!(word(Lang::En, 0x7041, 0x0217), "quick stop active");
        assert_eq!(word(Lang::En, 0x6061, 0xFFFF_FFF8), "manufacturer-specific mode");
        assert_eq!(word(Lang::En, 0x6502, 0x0001_0000), "no standard mode");
        assert_eq!(word(Lang::Zh, 0x6064, 1), "");
    }

    proptest! {
        #[test]
        fn any_entry_has_words(word: u32, raw: u64, code: u16, name: Option<String>, factor: f64) {
            let data_type = DataType::from_code(code % 0x1C);
            let name = name.map(Into::into);
            for entry in Mapping::from_words(&[word]).entries {
                let entry = Mapped { data_type, name: name.clone(), factor, ..entry };
                for lang in [Lang::Zh, Lang::En] {
                    let text = said(lang, &entry, raw);
                    prop_assert!(text.contains('='));
                    prop_assert!(!text.chars().any(escape::unsafe_on_a_terminal));
                }
            }
        }
    }
}

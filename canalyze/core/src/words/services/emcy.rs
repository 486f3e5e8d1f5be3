//! Emergencies in words (CiA 301, 7.2.7).

use crate::wire::message::Errors;
use crate::words::digits::{Hex, Spaced, put};
use crate::words::profiles::Profile;
use crate::words::{Lang, say, terms};

/// What an emergency carries: `: 8130h 寿命保护错误或心跳错误, 错误寄存器=11h (一般错误, 通信错误), 制造商数据 00 ...`.
pub fn content(out: &mut Vec<u8>, lang: Lang, (code, profile): (u16, Profile), register: u8, manufacturer: &[u8; 5]) {
    let meaning = terms::emcy::code(lang, profile, code).unwrap_or(lang.pick("未知错误码", "unknown error code"));
    put!(out; ": ", Hex::<4>(u64::from(code)), "h ", meaning);
    put!(out; lang.pick(", 错误寄存器=", ", error register="), Hex::<2>(u64::from(register)), "h");
    register_bits(out, lang, register);
    say!(out, lang; zh: ", 制造商数据 ", Spaced(manufacturer); en: ", manufacturer data ", Spaced(manufacturer));
}

/// Which errors a reset takes back.
pub fn cleared(out: &mut Vec<u8>, lang: Lang, cleared: Errors) {
    let mut between = lang.pick(", 清除 ", ", clears ");
    for code in cleared.iter() {
        put!(out; between, Hex::<4>(u64::from(code)), "h");
        between = ", ";
    }
}

fn register_bits(out: &mut Vec<u8>, lang: Lang, register: u8) {
    let mut between = " (";
    for bit in (0..8).filter(|bit| register & 1 << bit != 0) {
        put!(out; between, terms::emcy::register_bit(lang, bit).unwrap_or_default());
        between = ", ";
    }
    if register != 0 {
        put!(out; ")");
    }
}

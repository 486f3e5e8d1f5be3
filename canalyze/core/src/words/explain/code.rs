//! A code by itself, as a person reads it in a manual or on a display: what it is, where it is defined, what usually
//! causes it.
//!
//! A word before it says of what kind it is (`emcy 8130`, `statusword 0218`); without one, its form does: eight digits are
//! an abort code, an index with a sub-index is an object, four digits are an object of CiA 301 that is known, else an
//! emergency error code and an object, up to three are a COB-ID; what is no code may be a term (`heartbeat consumer
//! time`). Must not: look at a frame or a device description.

use crate::bytes::frame::CanId;
use crate::problems::kinds::{Impact, KINDS};
use crate::rules::{Code, RULES};
use crate::sdo::abort_code::AbortCode;
use crate::wire::cob_id::predefined;
use crate::wire::emcy;
use crate::wire::error_control;
use crate::wire::role::Named;
use crate::words::digits::{Hex, put};
use crate::words::explain::{described, term};
use crate::words::profiles::Profile;
use crate::words::{Lang, say, signal, terms};
use crate::world::drive::DriveState;
use crate::world::network::Description;
use crate::world::od::{self, DataType};

/// The kind of a code by the word before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sort {
    Emcy,
    Register,
    Abort,
    Statusword,
    Controlword,
    CobId,
    Object,
    State,
}

/// The words, in both languages.
const SORTS: &[(&str, Sort)] = &[
    ("emcy", Sort::Emcy),
    ("紧急报文", Sort::Emcy),
    ("register", Sort::Register),
    ("错误寄存器", Sort::Register),
    ("abort", Sort::Abort),
    ("中止码", Sort::Abort),
    ("statusword", Sort::Statusword),
    ("状态字", Sort::Statusword),
    ("controlword", Sort::Controlword),
    ("控制字", Sort::Controlword),
    ("cob-id", Sort::CobId),
    ("cob", Sort::CobId),
    ("object", Sort::Object),
    ("对象", Sort::Object),
    ("state", Sort::State),
    ("状态", Sort::State),
];

/// Appends what a code is; `false`, and nothing, where it is none that is known. `devices`: descriptions that were given,
/// of nodes; of node 0 where it is not known which.
pub fn code(out: &mut Vec<u8>, lang: Lang, text: &str, devices: &[Description]) -> bool {
    let text = text.trim();
    // One name may be that of a rule, of a kind and of a term: inhibit-time.
    if rule(out, lang, text) | problem(out, lang, text) | term::term(out, lang, text) {
        return true;
    }
    let (sort, rest) = match text.split_once(char::is_whitespace) {
        Some((word, rest)) => match SORTS.iter().find(|(known, _)| known.eq_ignore_ascii_case(word)) {
            Some((_, sort)) => (Some(*sort), rest.trim()),
            None => return false,
        },
        None => (None, text),
    };
    let (number, sub) = match rest.split_once(':') {
        Some((index, sub)) => (index, Some(sub)),
        None => (rest, None),
    };
    let Some((value, digits)) = hexadecimal(number) else { return false };
    let sub = match sub.map(hexadecimal) {
        Some(Some((sub, _))) => Some(sub),
        Some(None) => return false,
        None => None,
    };
    let before = out.len();
    match (sort, sub, digits) {
        (Some(Sort::Emcy), None, _) => emcy(out, lang, value),
        (Some(Sort::Register), None, _) => register(out, lang, value),
        (Some(Sort::Abort), None, 1..=2) => abort(out, lang, AbortCode::of(value)),
        (Some(Sort::Abort), None, _) | (None, None, 8) => abort(out, lang, AbortCode::Sdo(value)),
        (Some(Sort::Statusword), None, _) => word(out, lang, 0x6041, value),
        (Some(Sort::Controlword), None, _) => word(out, lang, 0x6040, value),
        (Some(Sort::CobId), None, _) | (None, None, 1..=3) => cob_id(out, lang, value, devices),
        (Some(Sort::State), None, _) => state(out, lang, value),
        (Some(Sort::Object), ..) | (None, Some(_), _) => object(out, lang, value, sub, devices),
        // Each of these is in the class of generic errors, too: of an object that is known this would say nothing.
        (None, None, 4) if (0x1000..=0x1FFF).contains(&value) => {
            object(out, lang, value, None, devices);
            if out.len() == before {
                emcy(out, lang, value);
            }
        }
        (None, None, 4) => {
            emcy(out, lang, value);
            object(out, lang, value, None, devices);
        }
        _ => {}
    }
    out.len() > before
}

/// A hexadecimal number as people write it (`8130h`, `0x8130`, `8130`), and how many digits it has.
fn hexadecimal(text: &str) -> Option<(u32, usize)> {
    let text = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")).unwrap_or(text);
    let text = text.strip_suffix(['h', 'H']).unwrap_or(text);
    let fits = (1..=8).contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_hexdigit());
    Some((u32::from_str_radix(text, 16).ok().filter(|_| fits)?, text.len()))
}

fn rule(out: &mut Vec<u8>, lang: Lang, text: &str) -> bool {
    let by_name = || RULES.iter().find(|rule| rule.name.eq_ignore_ascii_case(text)).map(|rule| rule.code);
    let Some(rule) = Code::parse(text).or_else(by_name).map(Code::rule) else { return false };
    let (message, meaning, cause) = (lang.of(rule.message), lang.of(rule.meaning), lang.of(rule.cause));
    put!(out; rule.id, " ", rule.name, ": ", message, "\n  ", meaning, "\n  ");
    say!(out, lang; zh: "常见原因: ", cause; en: "Usual cause: ", cause);
    if rule.clause != "-" {
        put!(out; "\n  ", rule.clause);
    }
    put!(out; "\n");
    true
}

fn problem(out: &mut Vec<u8>, lang: Lang, text: &str) -> bool {
    let Some(row) = KINDS.iter().find(|row| row.name.eq_ignore_ascii_case(text)) else { return false };
    put!(out; row.name, ": ", lang.of(row.words), "\n  ");
    let impact = match row.impact {
        Impact::A => ("设备或功能停止", "something stopped"),
        Impact::B => ("设备或功能未能启动", "something does not start"),
        Impact::C => ("工作性能下降", "degraded operation"),
        Impact::D => ("总线上的报文有误", "wrong frames on the bus"),
        Impact::E => ("供参考", "for information"),
    };
    put!(out; lang.pick("影响", "impact "), row.impact.name(), ": ", lang.pick(impact.0, impact.1), "\n");
    put!(out; lang.pick("  常见原因: ", "  Usual cause: "), lang.of(row.cause), "\n");
    for (place, check) in row.checked_first().enumerate() {
        put!(out; if place > 0 { "; " } else { lang.pick("  先查: ", "  Check first: ") }, lang.of(check));
    }
    put!(out; if row.checked_first().next().is_some() { "\n" } else { "" });
    put!(out; lang.pick("  恢复条件: ", "  Ended when: "), lang.of(row.end), "\n");
    for (place, code) in row.shown_by().enumerate() {
        put!(out; if place > 0 { lang.pick("、", ", ") } else { lang.pick("  相关规则: ", "  Rules: ") });
        put!(out; code.rule().id, " ", code.rule().name);
    }
    put!(out; if row.shown_by().next().is_some() { "\n" } else { "" });
    if row.clause != "-" {
        put!(out; "  ", row.clause, "\n");
    }
    true
}

fn emcy(out: &mut Vec<u8>, lang: Lang, value: u32) {
    let Ok(code) = u16::try_from(value) else { return };
    let Some(words) = emcy::code(lang, Profile::UNKNOWN, code) else { return };
    let hex = Hex::<4>(u64::from(code));
    say!(out, lang; zh: "EMCY错误码 ", hex, "h: ", words; en: "EMCY error code ", hex, "h: ", words);
    put!(out; "\n  CiA 301 7.2.7.1\n");
    for profile in Profile::KNOWN {
        if let Some((zh, en)) = profile.emergency(code) {
            put!(out; "  CiA ", profile.number(), ": ", lang.pick(zh, en), "\n");
        }
    }
}

fn register(out: &mut Vec<u8>, lang: Lang, value: u32) {
    let Ok(register) = u8::try_from(value) else { return };
    put!(out; lang.pick("错误寄存器 ", "error register "), Hex::<2>(u64::from(register)), "h (1001h)\n");
    let bits = (0..8).filter(|bit| register >> bit & 1 != 0);
    for bit in bits {
        let words = emcy::register_bit(lang, bit).unwrap_or(lang.pick("保留", "reserved"));
        put!(out; lang.pick("  位", "  bit "), bit, ": ", words, "\n");
    }
    if register == 0 {
        put!(out; lang.pick("  没有错误\n", "  no error\n"));
    }
}

fn abort(out: &mut Vec<u8>, lang: Lang, code: AbortCode) {
    let Some(words) = terms::abort_code(lang, code) else { return };
    let (service, clause) = match code {
        AbortCode::Sdo(_) => ("SDO", "CiA 301 7.2.4.3.17"),
        AbortCode::Usdo(_) => ("USDO", "CiA 1301"),
    };
    say!(out, lang; zh: service, "中止码 ", code, "h: ", words; en: service, " abort code ", code, "h: ", words);
    put!(out; "\n  ", clause, "\n");
}

fn word(out: &mut Vec<u8>, lang: Lang, index: u16, value: u32) {
    let Ok(word) = u16::try_from(value) else { return };
    let name =
        if index == 0x6041 { lang.pick("状态字 ", "statusword ") } else { lang.pick("控制字 ", "controlword ") };
    put!(out; name, Hex::<4>(u64::from(word)), "h (", Hex::<4>(u64::from(index)), "h): ");
    signal::annotation(out, lang, index, u64::from(word));
    if index == 0x6041 && DriveState::of(word).is_none() {
        put!(out; lang.pick("不是CiA 402的状态", "no state of CiA 402"));
    }
    put!(out; "\n  CiA 402-2\n");
}

fn state(out: &mut Vec<u8>, lang: Lang, value: u32) {
    let words = u8::try_from(value).ok().and_then(|state| error_control::state(lang, state));
    if let Some(words) = words {
        put!(out; lang.pick("NMT状态 ", "NMT state "), Hex::<2>(u64::from(value)), "h: ", words);
        put!(out; "\n  CiA 301 7.2.8.3.2\n");
    }
}

fn object(out: &mut Vec<u8>, lang: Lang, value: u32, sub: Option<u32>, devices: &[Description]) {
    let (Ok(index), Ok(number)) = (u16::try_from(value), u8::try_from(sub.unwrap_or(0))) else { return };
    let of_profiles =
        || Profile::KNOWN.into_iter().filter(|profile| index >= 0x6000 && profile.name(index, number).is_some());
    let name = terms::object_name(lang, Profile::UNKNOWN, index, number);
    let own = || devices.iter().filter(|one| described::has(&one.dictionary, index, sub.map(|_| number)));
    if name.is_none() && of_profiles().next().is_none() && own().next().is_none() {
        return;
    }
    put!(out; lang.pick("对象 ", "object "), Hex::<4>(u64::from(index)), "h");
    if sub.is_some() {
        put!(out; ":", Hex::<2>(u64::from(number)));
    }
    put!(out; ": ", name.unwrap_or(lang.pick("制造商或设备规范的对象", "manufacturer-specific or of a device profile")), "\n");
    own().for_each(|one| described::object(out, lang, one, index, sub.map(|_| number)));
    if name.is_some() {
        term::of_object(out, lang, index);
        // Sub-index 0 of what has others only counts them.
        let counts = sub.is_none() && od::communication(index, 1).is_some();
        if let Some(data_type) = od::communication(index, number).filter(|_| !counts) {
            put!(out; "  ", data_type.name(), "\n");
        }
    }
    if of_profiles().next().is_none() {
        put!(out; "  ", clause(lang, index), "\n");
    }
    for profile in of_profiles() {
        let of = |sub| profile.data_type(index, sub);
        let words = terms::object_name(lang, profile, index, number);
        // Sub-index 0 of what has others only counts them.
        let data_type = if sub.is_some() { of(number) } else { of(1).or_else(|| of(0)) };
        put!(out; "  CiA ", profile.number(), ": ", words.unwrap_or_default());
        put!(out; if data_type.is_some() { ", " } else { "" }, data_type.map_or("", DataType::name), "\n");
    }
}

/// Returns the clause that defines an object.
fn clause(lang: Lang, index: u16) -> &'static str {
    let row = CLAUSES.iter().find(|row| (row.0..=row.1).contains(&index));
    row.map_or_else(
        || match index {
            0x1000..=0x1FFF => "CiA 301, CiA 302",
            0x2000..=0x5FFF => lang.pick("制造商区: 见设备手册", "manufacturer-specific area: see the device manual"),
            _ => lang.pick("设备规范 (CiA 4xx)", "device profile (CiA 4xx)"),
        },
        |row| row.2,
    )
}

/// First and last index, and the clause.
static CLAUSES: &[(u16, u16, &str)] = words!("clauses");

fn cob_id(out: &mut Vec<u8>, lang: Lang, value: u32, devices: &[Description]) {
    let Some(id) = u16::try_from(value).ok().filter(|id| *id <= 0x7FF) else { return };
    let role = predefined(CanId::standard(id));
    put!(out; "COB-ID ", Hex::<3>(u64::from(id)), "h: ", Named(lang, role));
    put!(out; lang.pick("\n  预定义连接集 (CiA 301 7.3.5)\n", "\n  pre-defined connection set (CiA 301 7.3.5)\n"));
    devices.iter().for_each(|one| described::cob_id(out, lang, one, id));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_is_explained_in_both_languages() {
        for row in KINDS {
            let (mut zh, mut en) = (Vec::new(), Vec::new());
            assert!(code(&mut zh, Lang::Zh, row.name, &[]) && code(&mut en, Lang::En, row.name, &[]), "{}", row.name);
            let (zh, en) = (String::from_utf8_lossy(&zh), String::from_utf8_lossy(&en));
            for (said, parts) in
                [(&zh, ["影响", "常见原因: ", "恢复条件: "]), (&en, ["impact ", "Usual cause: ", "Ended when: "])]
            {
                assert!(parts.iter().all(|part| said.contains(part)), "{said}");
            }
        }
    }
}

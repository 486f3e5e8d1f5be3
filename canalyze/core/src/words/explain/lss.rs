//! The breakdown of an LSS frame: the command specifier with its phrase, then each field.

use super::{data, line, node_id, reserved};
use crate::bytes::frame::Frame;
use crate::wire::lss::{BIT_CHECK_ANY, Command, Part, Setting, UNCONFIGURED, bit_rate};
use crate::words::digits::{Hex, Spaced, put};
use crate::words::services::lss;
use crate::words::{Lang, say, terms};

/// Appends the breakdown, whole lines.
pub fn command(out: &mut Vec<u8>, lang: Lang, from_master: bool, command: Command, frame: &Frame) {
    let [cs, rest @ ..] = frame.head();
    let [a, b, c, d, e, f, g] = rest;
    put!(out; "#   ", Hex::<2>(u64::from(cs)), lang.pick("  命令字: ", "  command specifier: "));
    lss::command(out, lang, false, from_master, command);
    put!(out; "\n");
    match command {
        Command::SwitchGlobal { mode } => {
            let word = match mode {
                0 => lang.pick("等待状态", "waiting state"),
                1 => lang.pick("配置状态", "configuration state"),
                _ => lang.pick("保留", "reserved"),
            };
            line!(out; Hex::<2>(u64::from(mode)), lang.pick("  模式: ", "  mode: "), word);
            reserved(out, lang, &[b, c, d, e, f, g]);
        }
        Command::SwitchSelective { part, value } | Command::InquireResponse { part, value } => {
            number(out, lang, terms::lss::part(lang, part), value);
            reserved(out, lang, &[e, f, g]);
        }
        Command::Identify { bound, value } => {
            number(out, lang, terms::lss::bound(lang, bound), value);
            reserved(out, lang, &[e, f, g]);
        }
        Command::ConfigureNodeId { node } | Command::InquireNodeIdResponse { node } => {
            match node {
                UNCONFIGURED => line!(out; "FF", lang.pick("  节点ID FFh: 未配置", "  node-ID FFh: unconfigured")),
                _ => node_id(out, lang, node),
            }
            reserved(out, lang, &[b, c, d, e, f, g]);
        }
        Command::ConfigureBitTiming { selector, index } => {
            bit_timing(out, lang, selector, index);
            reserved(out, lang, &[c, d, e, f, g]);
        }
        Command::Confirmation { of, error, specific } => {
            confirmation(out, lang, of, error, specific);
            reserved(out, lang, &[c, d, e, f, g]);
        }
        Command::ActivateBitTiming { delay } => {
            put!(out; "#   ", Spaced(&[a, b]), lang.pick("  切换延迟 ", "  switch delay "), Hex::<4>(u64::from(delay)));
            put!(out; "h = ", delay, lang.pick(" ms (小端格式)\n", " ms (little-endian)\n"));
            reserved(out, lang, &[c, d, e, f, g]);
        }
        Command::Fastscan { id_number, bit_check, sub, next } => fastscan(out, lang, id_number, bit_check, [sub, next]),
        Command::SwitchSelectiveResponse
        | Command::Store
        | Command::IdentifyNonConfigured
        | Command::IdentifySlave
        | Command::IdentifyNonConfiguredSlave
        | Command::Inquire { .. }
        | Command::InquireNodeId => reserved(out, lang, &rest),
        Command::Unknown(_) => data(out, lang, &rest),
    }
}

fn bit_timing(out: &mut Vec<u8>, lang: Lang, selector: u8, index: u8) {
    let table = match selector {
        0 => lang.pick("CiA位定时表", "CiA bit timing table"),
        1..128 => lang.pick("保留的位定时表", "reserved bit timing table"),
        128.. => lang.pick("制造商定义的位定时表", "manufacturer-specific bit timing table"),
    };
    line!(out; Hex::<2>(u64::from(selector)), lang.pick("  表选择: ", "  table selector: "), table);
    put!(out; "#   ", Hex::<2>(u64::from(index)), lang.pick("  表内序号: ", "  table index: "), index);
    match (selector, bit_rate(index)) {
        (1.., _) => {}
        (0, Some(rate)) => put!(out; " = ", rate, " kbit/s"),
        (0, None) if index == 9 => say!(out, lang; zh: " = 自动检测"; en: " = automatic detection"),
        (0, None) => say!(out, lang; zh: " = 保留"; en: " = reserved"),
    }
    put!(out; "\n");
}

fn confirmation(out: &mut Vec<u8>, lang: Lang, of: Setting, error: u8, specific: u8) {
    let word = terms::lss::error(lang, of, error).unwrap_or(lang.pick("未知", "unknown"));
    line!(out; Hex::<2>(u64::from(error)), lang.pick("  错误码: ", "  error code: "), word);
    put!(out; "#   ", Hex::<2>(u64::from(specific)));
    say!(out, lang;
        zh: "  特定错误码 (错误码为FFh时有效)\n";
        en: "  specific error code (valid where the error code is FFh)\n");
}

/// `parts`: of the address, LSSSub and LSSNext.
fn fastscan(out: &mut Vec<u8>, lang: Lang, id_number: u32, bit_check: u8, parts: [u8; 2]) {
    number(out, lang, "IDNumber", id_number);
    put!(out; "#   ", Hex::<2>(u64::from(bit_check)), "  BitCheck: ");
    match bit_check {
        BIT_CHECK_ANY => say!(out, lang; zh: "询问是否有未配置的从站"; en: "is there any non-configured slave?"),
        32.. => say!(out, lang; zh: "无效"; en: "invalid"),
        31 => say!(out, lang; zh: "比较位31"; en: "compare bit 31"),
        _ => say!(out, lang; zh: "比较位31-", bit_check; en: "compare bits 31-", bit_check),
    }
    put!(out; "\n");
    for (name, part) in ["  LSSSub: ", "  LSSNext: "].into_iter().zip(parts) {
        let known = Part::from_number(part).map(|part| terms::lss::part(lang, part));
        line!(out; Hex::<2>(u64::from(part)), name, known.unwrap_or(lang.pick("未知", "unknown")));
    }
}

/// `#   78 56 34 12  制造商ID 12345678h (小端格式)`.
fn number(out: &mut Vec<u8>, lang: Lang, name: &'static str, value: u32) {
    put!(out; "#   ", Spaced(&value.to_le_bytes()), "  ", name, " ", Hex::<8>(u64::from(value)));
    say!(out, lang; zh: "h (小端格式)\n"; en: "h (little-endian)\n");
}

//! LSS in words (CiA 305): switching, configuring, inquiring and Fastscan.

use crate::wire::lss::{BIT_CHECK_ANY, Command, Part, Setting, UNCONFIGURED, bit_rate};
use crate::words::digits::{Hex, put};
use crate::words::{Lang, say, terms};

/// Who speaks and what it asks or answers; where `full`, also the values.
pub fn command(out: &mut Vec<u8>, lang: Lang, full: bool, from_master: bool, command: Command) {
    if from_master {
        say!(out, lang; zh: "LSS主站: "; en: "LSS master: ");
    } else {
        say!(out, lang; zh: "LSS从站: "; en: "LSS slave: ");
    }
    phrase(out, lang, command);
    if full {
        content(out, lang, command);
    }
}

fn phrase(out: &mut Vec<u8>, lang: Lang, command: Command) {
    let part_of = |part| terms::lss::part(lang, part);
    match command {
        Command::SwitchGlobal { .. } => say!(out, lang; zh: "全局切换状态"; en: "switch state global"),
        Command::SwitchSelective { part, .. } => {
            say!(out, lang; zh: "选择性切换状态, ", part_of(part); en: "switch state selective, ", part_of(part));
        }
        Command::SwitchSelectiveResponse => say!(out, lang;
            zh: "选择性切换状态响应 (已进入配置状态)";
            en: "switch state selective response (in configuration state)"),
        Command::ConfigureNodeId { .. } => say!(out, lang; zh: "配置节点ID"; en: "configure node-ID"),
        Command::ConfigureBitTiming { .. } => say!(out, lang; zh: "配置位定时"; en: "configure bit timing"),
        Command::Store => say!(out, lang; zh: "存储配置"; en: "store configuration"),
        Command::Confirmation { of, .. } => {
            let setting = terms::lss::setting(lang, of);
            say!(out, lang; zh: setting, "响应"; en: setting, " response");
        }
        Command::ActivateBitTiming { .. } => say!(out, lang; zh: "激活位定时"; en: "activate bit timing"),
        Command::Identify { bound, .. } => {
            let bound = terms::lss::bound(lang, bound);
            say!(out, lang; zh: "识别从站, ", bound; en: "identify remote slave, ", bound);
        }
        Command::IdentifyNonConfigured => {
            say!(out, lang; zh: "识别未配置的从站"; en: "identify non-configured remote slave");
        }
        Command::IdentifySlave => say!(out, lang; zh: "从站识别响应"; en: "identify slave"),
        Command::IdentifyNonConfiguredSlave => {
            say!(out, lang; zh: "未配置从站的识别响应"; en: "identify non-configured slave");
        }
        Command::Fastscan { .. } => say!(out, lang; zh: "快速扫描(Fastscan)"; en: "Fastscan"),
        Command::Inquire { part } => say!(out, lang; zh: "查询", part_of(part); en: "inquire ", part_of(part)),
        Command::InquireResponse { part, .. } => {
            say!(out, lang; zh: part_of(part), "查询响应"; en: "inquire response, ", part_of(part));
        }
        Command::InquireNodeId => say!(out, lang; zh: "查询节点ID"; en: "inquire node-ID"),
        Command::InquireNodeIdResponse { .. } => say!(out, lang; zh: "节点ID查询响应"; en: "inquire response, node-ID"),
        Command::Unknown(cs) => {
            let cs = Hex::<2>(u64::from(cs));
            say!(out, lang; zh: "未知命令字 ", cs, "h"; en: "unknown command specifier ", cs, "h");
        }
    }
}

fn content(out: &mut Vec<u8>, lang: Lang, command: Command) {
    match command {
        Command::SwitchGlobal { mode: 0 } => say!(out, lang; zh: ": 等待状态"; en: ": waiting state"),
        Command::SwitchGlobal { mode: 1 } => say!(out, lang; zh: ": 配置状态"; en: ": configuration state"),
        Command::SwitchGlobal { mode } => {
            let mode = Hex::<2>(u64::from(mode));
            say!(out, lang; zh: ": 保留的模式 ", mode, "h"; en: ": reserved mode ", mode, "h");
        }
        Command::SwitchSelective { value, .. }
        | Command::Identify { value, .. }
        | Command::InquireResponse { value, .. } => put!(out; " = ", Hex::<8>(u64::from(value)), "h"),
        Command::ConfigureNodeId { node } | Command::InquireNodeIdResponse { node } => match node {
            1..=127 => put!(out; " = ", node),
            UNCONFIGURED => say!(out, lang; zh: " = FFh (未配置)"; en: " = FFh (unconfigured)"),
            _ => say!(out, lang; zh: " = ", node, " (无效)"; en: " = ", node, " (invalid)"),
        },
        Command::ConfigureBitTiming { selector, index } => bit_timing(out, lang, selector, index),
        Command::Confirmation { of, error, specific } => confirmation(out, lang, of, error, specific),
        Command::ActivateBitTiming { delay } => {
            say!(out, lang; zh: ": 切换延迟=", delay, " ms"; en: ": switch delay=", delay, " ms");
        }
        Command::Fastscan { id_number, bit_check, sub, next } => fastscan(out, lang, id_number, bit_check, sub, next),
        Command::SwitchSelectiveResponse
        | Command::Store
        | Command::IdentifyNonConfigured
        | Command::IdentifySlave
        | Command::IdentifyNonConfiguredSlave
        | Command::Inquire { .. }
        | Command::InquireNodeId
        | Command::Unknown(_) => {}
    }
}

fn bit_timing(out: &mut Vec<u8>, lang: Lang, selector: u8, index: u8) {
    match (selector, bit_rate(index)) {
        (0, Some(rate)) => say!(out, lang; zh: ": 波特率 ", rate, " kbit/s"; en: ": bit rate ", rate, " kbit/s"),
        (0, None) if index == 9 => say!(out, lang; zh: ": 自动检测波特率"; en: ": automatic bit rate detection"),
        (0, None) => say!(out, lang; zh: ": 保留的波特率"; en: ": reserved bit rate"),
        (1..128, _) => say!(out, lang; zh: ": 保留的位定时表"; en: ": reserved bit timing table"),
        (128.., _) => say!(out, lang; zh: ": 制造商定义的位定时表"; en: ": manufacturer-specific bit timing table"),
    }
    say!(out, lang;
        zh: " (表=", selector, ", 序号=", index, ")";
        en: " (table=", selector, ", index=", index, ")");
}

fn confirmation(out: &mut Vec<u8>, lang: Lang, of: Setting, error: u8, specific: u8) {
    let reserved = lang.pick("保留的错误码", "reserved error code");
    put!(out; ": ", terms::lss::error(lang, of, error).unwrap_or(reserved));
    if error != 0 {
        put!(out; lang.pick(" (错误码 ", " (error code "), Hex::<2>(u64::from(error)), "h");
        if error == 0xFF {
            put!(out; lang.pick(", 特定错误码 ", ", specific error code "), Hex::<2>(u64::from(specific)), "h");
        }
        put!(out; ")");
    }
}

fn fastscan(out: &mut Vec<u8>, lang: Lang, id_number: u32, bit_check: u8, sub: u8, next: u8) {
    match bit_check {
        BIT_CHECK_ANY => say!(out, lang; zh: ": 询问是否有未配置的从站"; en: ": is there any non-configured slave?"),
        32.. => say!(out, lang; zh: ": 无效的BitCheck"; en: ": invalid BitCheck"),
        _ => {
            let part = address_part(lang, sub);
            say!(out, lang;
                zh: ": ", part, ", 比较位31";
                en: ": ", part, if bit_check == 31 { ", compare bit 31" } else { ", compare bits 31" });
            if bit_check < 31 {
                put!(out; "-", bit_check);
            }
            if sub != next && bit_check == 0 {
                put!(out; lang.pick(", 确认并转到", ", confirm and continue with "), address_part(lang, next));
            }
        }
    }
    put!(out; " (IDNumber=", Hex::<8>(u64::from(id_number)), "h, BitCheck=");
    match bit_check {
        32.. => put!(out; Hex::<2>(u64::from(bit_check)), "h"),
        _ => put!(out; bit_check),
    }
    put!(out; ", LSSSub=", sub, ", LSSNext=", next, ")");
}

fn address_part(lang: Lang, number: u8) -> &'static str {
    match Part::from_number(number) {
        Some(part) => terms::lss::part(lang, part),
        None => lang.pick("无效的LSS地址部分", "invalid part of the LSS address"),
    }
}

//! LSS's terms (CiA 305): the parts of an address, settings and their error codes.

use super::{Row, find};
use crate::wire::lss::{Bound, Part, Setting};
use crate::words::Lang;

/// Parts of the LSS address.
pub static PARTS: &[Row<Part>] = &[
    (Part::Vendor, "制造商ID", "vendor-ID"),
    (Part::Product, "产品码", "product code"),
    (Part::Revision, "修订号", "revision number"),
    (Part::Serial, "序列号", "serial number"),
];

/// Bounds of a search.
pub static BOUNDS: &[Row<Bound>] = &[
    (Bound::Vendor, "制造商ID", "vendor-ID"),
    (Bound::Product, "产品码", "product code"),
    (Bound::RevisionLow, "修订号下限", "revision number, low"),
    (Bound::RevisionHigh, "修订号上限", "revision number, high"),
    (Bound::SerialLow, "序列号下限", "serial number, low"),
    (Bound::SerialHigh, "序列号上限", "serial number, high"),
];

/// Settings that a slave confirms.
pub static SETTINGS: &[Row<Setting>] = &[
    (Setting::NodeId, "配置节点ID", "configure node-ID"),
    (Setting::BitTiming, "配置位定时", "configure bit timing"),
    (Setting::Store, "存储配置", "store configuration"),
];

/// Error codes of "configure node-ID".
pub static NODE_ID_ERRORS: &[Row<u8>] = &[
    (0, "成功", "done"),
    (1, "节点ID超出范围", "node-ID out of range"),
    (255, "制造商定义的错误", "implementation-specific error"),
];

/// Error codes of "configure bit timing".
pub static BIT_TIMING_ERRORS: &[Row<u8>] = &[
    (0, "成功", "done"),
    (1, "不支持该波特率", "bit rate not supported"),
    (255, "制造商定义的错误", "implementation-specific error"),
];

/// Error codes of "store configuration".
pub static STORE_ERRORS: &[Row<u8>] = &[
    (0, "成功", "done"),
    (1, "不支持存储", "store not supported"),
    (2, "存储介质访问错误", "storage media access error"),
    (255, "制造商定义的错误", "implementation-specific error"),
];

/// Commands, by their specifier.
pub static COMMANDS: &[Row<u8>] = &[
    (0x04, "全局切换状态", "switch state global"),
    (0x11, "配置节点ID", "configure node-ID"),
    (0x13, "配置位定时", "configure bit timing"),
    (0x15, "激活位定时", "activate bit timing"),
    (0x17, "存储配置", "store configuration"),
    (0x40, "选择性切换状态(制造商ID)", "switch state selective (vendor-ID)"),
    (0x41, "选择性切换状态(产品码)", "switch state selective (product code)"),
    (0x42, "选择性切换状态(修订号)", "switch state selective (revision number)"),
    (0x43, "选择性切换状态(序列号)", "switch state selective (serial number)"),
    (0x44, "选择性切换状态响应", "switch state selective response"),
    (0x46, "识别从站(制造商ID)", "identify remote slave (vendor-ID)"),
    (0x47, "识别从站(产品码)", "identify remote slave (product code)"),
    (0x48, "识别从站(修订号下限)", "identify remote slave (revision number, low)"),
    (0x49, "识别从站(修订号上限)", "identify remote slave (revision number, high)"),
    (0x4A, "识别从站(序列号下限)", "identify remote slave (serial number, low)"),
    (0x4B, "识别从站(序列号上限)", "identify remote slave (serial number, high)"),
    (0x4C, "识别未配置的从站", "identify non-configured remote slave"),
    (0x4F, "从站识别响应", "identify slave"),
    (0x50, "未配置从站的识别响应", "identify non-configured slave"),
    (0x51, "快速扫描", "Fastscan"),
    (0x5A, "查询制造商ID", "inquire vendor-ID"),
    (0x5B, "查询产品码", "inquire product code"),
    (0x5C, "查询修订号", "inquire revision number"),
    (0x5D, "查询序列号", "inquire serial number"),
    (0x5E, "查询节点ID", "inquire node-ID"),
];

/// The name of a command specifier.
pub fn command(lang: Lang, command: u8) -> Option<&'static str> {
    find(COMMANDS, lang, command)
}

/// What an error code in the answer to a command specifier means.
pub fn error_of(lang: Lang, command: u8, code: u8) -> Option<&'static str> {
    match command {
        0x11 => error(lang, Setting::NodeId, code),
        0x13 => error(lang, Setting::BitTiming, code),
        0x17 => error(lang, Setting::Store, code),
        _ => None,
    }
}

/// The name of a part of the address.
pub fn part(lang: Lang, part: Part) -> &'static str {
    find(PARTS, lang, part).unwrap_or_default()
}

/// The name of a bound.
pub fn bound(lang: Lang, bound: Bound) -> &'static str {
    find(BOUNDS, lang, bound).unwrap_or_default()
}

/// The name of a setting.
pub fn setting(lang: Lang, setting: Setting) -> &'static str {
    find(SETTINGS, lang, setting).unwrap_or_default()
}

/// What the error code of a setting's confirmation means.
pub fn error(lang: Lang, of: Setting, code: u8) -> Option<&'static str> {
    let rows = match of {
        Setting::NodeId => NODE_ID_ERRORS,
        Setting::BitTiming => BIT_TIMING_ERRORS,
        Setting::Store => STORE_ERRORS,
    };
    find(rows, lang, code)
}

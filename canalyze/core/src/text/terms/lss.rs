//! LSS's terms (CiA 305): the parts of an address, settings and their error codes.

use super::{Row, find};
use crate::services::lss::{Bound, Part, Setting};
use crate::text::Lang;

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

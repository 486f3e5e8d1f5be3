//! Terms: what has one name in each language. Rows `(code, zh, en)`, sorted by code, complete in both.
//!
//! The Chinese words follow the notes' vocabulary, the English ones CiA 301's. No sentence stands here.

pub mod drive;
pub mod emcy;
pub mod error_frame;
pub mod lss;
pub mod nmt;
pub mod objects;
pub mod sdo_abort;
pub mod service;
pub mod usdo;

use super::Lang;

pub use objects::object_name;
pub use sdo_abort::abort_code;

/// A term: its code, its Chinese word, its English word.
pub type Row<K> = (K, &'static str, &'static str);

/// The word for `code` in rows sorted by code.
pub fn find<K: Ord + Copy>(rows: &'static [Row<K>], lang: Lang, code: K) -> Option<&'static str> {
    let at = rows.binary_search_by_key(&code, |row| row.0).ok()?;
    rows.get(at).map(|row| word(lang, row))
}

/// One row's word.
pub fn word<K>(lang: Lang, row: &Row<K>) -> &'static str {
    lang.pick(row.1, row.2)
}

#[cfg(test)]
pub(crate) mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;
    use crate::words::profiles::Profile;

    /// Rows are strictly ascending, and each has both words, the English one in ASCII.
    pub(crate) fn sound<K: Ord + Copy + std::fmt::Debug>(rows: &[Row<K>]) {
        for pair in rows.windows(2) {
            assert!(pair[0].0 < pair[1].0, "{:?} before {:?}", pair[0].0, pair[1].0);
        }
        for (code, zh, en) in rows {
            assert!(!zh.is_empty() && !en.is_empty(), "{code:?}");
            assert!(en.is_ascii(), "{code:?}: {en}");
            assert!(zh.chars().all(|c| !c.is_control()), "{code:?}");
            // Terms stand within sentences that use half-width punctuation, as the notes do.
            assert!(!zh.contains(['，', '（', '）', '：', '；']), "{code:?}: {zh}");
        }
    }

    #[test]
    fn complete_and_sorted() {
        sound(nmt::COMMANDS);
        sound(nmt::STATES);
        sound(emcy::CODES);
        sound(emcy::REGISTER);
        sound(sdo_abort::CODES);
        sound(lss::COMMANDS);
        sound(lss::PARTS);
        sound(lss::BOUNDS);
        sound(lss::SETTINGS);
        sound(lss::NODE_ID_ERRORS);
        sound(lss::BIT_TIMING_ERRORS);
        sound(lss::STORE_ERRORS);
        sound(error_frame::CLASSES);
        sound(error_frame::CONTROLLER);
        sound(error_frame::PROTOCOL);
        sound(error_frame::LOCATION);
        sound(error_frame::TRANSCEIVER);
        sound(usdo::COMMANDS);
        sound(usdo::ABORTS);
        sound(service::SERVICES);
        sound(service::SDO);
        sound(service::INVERTED);
        assert_eq!(sdo_abort::CODES.len(), 31);
    }

    #[test]
    fn emergency_codes_from_special_to_general() {
        assert_eq!(emcy::code(Lang::Zh, Profile::UNKNOWN, 0x8130), Some("寿命保护错误或心跳错误"));
        assert_eq!(emcy::code(Lang::En, Profile::UNKNOWN, 0x8131), Some("communication"));
        assert_eq!(emcy::code(Lang::En, Profile::UNKNOWN, 0x5530), Some("device hardware"));
        assert_eq!(emcy::code(Lang::En, Profile::UNKNOWN, 0x7305), Some("additional modules"));
        assert_eq!(emcy::code(Lang::En, Profile::UNKNOWN, 0x0012), Some("error reset or no error"));
        assert_eq!(emcy::code(Lang::En, Profile::UNKNOWN, 0x0100), None);
        assert_eq!(emcy::code(Lang::En, Profile::UNKNOWN, 0xFF12), Some("device specific"));
        assert_eq!(emcy::code(Lang::En, Profile::UNKNOWN, 0xF112), Some("additional functions"));
        assert_eq!(emcy::code(Lang::En, Profile::UNKNOWN, 0xA000), None);
    }

    #[test]
    fn words_of_the_notes() {
        let states: Vec<_> = nmt::STATES.iter().map(|row| row.1).collect();
        assert_eq!(states, ["启动(Boot-up)", "停止状态", "操作状态", "预操作状态"]);
        let parts: Vec<_> = lss::PARTS.iter().map(|row| row.1).collect();
        assert_eq!(parts, ["制造商ID", "产品码", "修订号", "序列号"]);
        let objects = [
            (0x1001, 0, "错误寄存器"),
            (0x1006, 0, "同步周期"),
            (0x1019, 0, "同步计数器溢出值"),
            (0x1018, 1, "制造商ID"),
            (0x1800, 0, "TPDO通信参数"),
            (0x1800, 2, "TPDO传输类型"),
            (0x1800, 3, "TPDO抑制时间"),
            (0x1800, 5, "TPDO事件定时器"),
            (0x1800, 6, "TPDO同步起始值"),
            (0x1A00, 1, "TPDO映射参数"),
            (0x6040, 0, "控制字"),
            (0x6041, 0, "状态字"),
            (0x6060, 0, "操作模式"),
        ];
        for (index, sub, word) in objects {
            assert_eq!(object_name(Lang::Zh, Profile::UNKNOWN, index, sub), Some(word));
        }
        assert_eq!(abort_code(Lang::Zh, 0x0503_0000), Some("toggle位未交替"));
        assert_eq!(abort_code(Lang::Zh, 0x0602_0000), Some("对象字典中不存在该对象"));
        assert_eq!(abort_code(Lang::Zh, 0), None);
    }
}

//! Terms with one name in each language: rows `(code, zh, en)`, sorted by code. Most are tables of `words/`.
//!
//! The Chinese words follow the notes' vocabulary, the English ones CiA 301's.

pub mod drive;
pub mod objects;
pub mod sdo_abort;
pub mod service;

pub use objects::object_name;
pub use sdo_abort::abort_code;

pub use super::lang::{Term as Row, find};

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;
    use crate::sdo::abort_code::AbortCode;
    use crate::words::Lang;
    use crate::words::lang::tests::sound;
    use crate::words::profiles::Profile;

    #[test]
    fn complete_and_sorted() {
        sound(sdo_abort::CODES);
        sound(service::SERVICES);
        sound(service::SDO);
        sound(service::INVERTED);
        assert_eq!(sdo_abort::CODES.len(), 31);
    }

    #[test]
    fn words_of_the_notes() {
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
        assert_eq!(abort_code(Lang::Zh, AbortCode::Sdo(0x0503_0000)), Some("toggle位未交替"));
        assert_eq!(abort_code(Lang::Zh, AbortCode::Sdo(0x0602_0000)), Some("对象字典中不存在该对象"));
        assert_eq!(abort_code(Lang::Zh, AbortCode::Sdo(0)), None);
    }
}

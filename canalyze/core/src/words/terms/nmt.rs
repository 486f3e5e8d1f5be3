//! NMT's terms: commands and states.

use super::{Row, find};
use crate::words::Lang;

/// NMT states, as error control carries them: with 00h, a node says that it has left Initialisation (CiA 301, 7.3.2).
pub static STATES: &[Row<u8>] = &[
    (0x00, "启动(Boot-up)", "Pre-operational (boot-up)"),
    (0x04, "停止状态", "Stopped"),
    (0x05, "操作状态", "Operational"),
    (0x7F, "预操作状态", "Pre-operational"),
];

/// The name of a state (without the toggle bit).
pub fn state(lang: Lang, state: u8) -> Option<&'static str> {
    find(STATES, lang, state)
}

//! SDO abort codes (CiA 301, table 22).

use super::{Row, find};
use crate::words::Lang;

/// All codes that CiA 301 defines. Device profiles and manufacturers have others.
pub static CODES: &[Row<u32>] = words!("abort_codes");

/// Returns the meaning of an abort code; `None` for one that CiA 301 does not define.
pub fn abort_code(lang: Lang, code: u32) -> Option<&'static str> {
    find(CODES, lang, code)
}

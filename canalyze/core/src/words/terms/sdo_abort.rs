//! Abort codes of SDO (CiA 301, table 22) and of USDO (CiA 1301).

use super::{Row, find};
use crate::sdo::abort_code::AbortCode;
use crate::words::Lang;

/// All codes that CiA 301 defines. Device profiles and manufacturers have others.
pub static CODES: &[Row<u32>] = words!("abort_codes");

/// All codes that are known of USDO.
pub static USDO_CODES: &[Row<u8>] = words!("usdo_abort_codes");

/// Returns the meaning of an abort code; `None` for one that the standard does not define.
pub fn abort_code(lang: Lang, code: AbortCode) -> Option<&'static str> {
    match code {
        AbortCode::Sdo(code) => find(CODES, lang, code),
        AbortCode::Usdo(code) => find(USDO_CODES, lang, code),
    }
}

//! Abort codes of SDO (CiA 301, table 22) and of USDO (CiA 1301).

use super::{Row, find};
use crate::sdo::abort_code::AbortCode;
use crate::wire::usdo;
use crate::words::Lang;

/// All codes that CiA 301 defines. Device profiles and manufacturers have others.
pub static CODES: &[Row<u32>] = words!("abort_codes");

/// Returns the meaning of an abort code; `None` for one that the standard does not define.
pub fn abort_code(lang: Lang, code: AbortCode) -> Option<&'static str> {
    match code {
        AbortCode::Sdo(code) => find(CODES, lang, code),
        AbortCode::Usdo(code) => find(usdo::ABORT_CODES, lang, code),
    }
}

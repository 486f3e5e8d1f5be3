//! Reports once what of a bus is not CANopen.
//!
//! [`evidence::services`](crate::evidence::services), SDO channels and LSS show whether it is. It must not judge a frame.

use crate::context::Context;
use crate::evidence::services::{Alien, Other};
use crate::finding::Finding;
use crate::rules::bus::Bus009;

/// The capture is over. `sdo`: of each channel whether it is SDO, where that is known, and its frames. `lss`: frames on
/// the identifiers of LSS that are none; `proven`: others are LSS.
pub fn conclude(sdo: impl Iterator<Item = (Option<bool>, u64)>, lss: u64, proven: bool, cx: &mut Context<'_>) {
    let (mut further, mut canopen) = (lss, proven);
    for (is_sdo, frames) in sdo {
        canopen |= is_sdo == Some(true);
        further += if is_sdo == Some(false) { frames } else { 0 };
    }
    if let Some(Alien { first, frames, extended }) = cx.evidence.services.conclude(further, canopen) {
        let what = if extended { Bus009::Extended { frames } } else { Bus009::Bus { frames } };
        let found = cx.verdict(what, None, None, None);
        return cx.report(Finding { at: first, ..found });
    }
    for Other { id, first, frames } in cx.evidence.services.others().collect::<Vec<_>>() {
        let found = cx.verdict(Bus009::Identifier { id, frames }, None, None, None);
        cx.report(Finding { at: first, ..found });
    }
}

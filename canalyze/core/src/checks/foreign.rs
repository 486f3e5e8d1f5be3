//! Reports once the traffic of a bus that is not CANopen, by the evidence of SDO channels, LSS and
//! [`evidence::services`](crate::evidence::services).

use crate::evidence::services::{Alien, Other};
use crate::rules::bus::Bus009;
use crate::rules::finding::Finding;
use crate::world::context::Context;

/// Reports foreign traffic at the end of the capture. `sdo`: for each channel whether it is SDO, if known, and its
/// frame count. `lss`: number of foreign frames on the identifiers of LSS. `proven`: LSS itself was seen.
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

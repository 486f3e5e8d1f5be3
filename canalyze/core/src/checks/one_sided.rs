//! Reports once per bus that only one direction of SDO was recorded.

use crate::rules::finding::{Finding, Verdict};
use crate::rules::sdo::Sdo032;
use crate::sdo::proof::OneSided;
use crate::sdo::wire::Side;
use crate::world::context::Context;

/// Reports one-sided channels at the end of the capture.
pub fn conclude(found: &[OneSided], cx: &mut Context<'_>) {
    for side in [Side::Client, Side::Server] {
        let of_side = || found.iter().filter(|one| one.side == side);
        let Some(earliest) = of_side().min_by_key(|one| one.first.no) else { continue };
        let servers = of_side().count() as u64;
        let frames: u64 = of_side().map(|one| one.frames).sum();
        let what: Verdict = match (side, servers) {
            (Side::Client, 1) => Sdo032::Answers { requests: frames }.into(),
            (Side::Client, _) => Sdo032::AnswersOfAll { requests: frames, servers }.into(),
            (Side::Server, 1) => Sdo032::Requests { answers: frames }.into(),
            (Side::Server, _) => Sdo032::RequestsOfAll { answers: frames, servers }.into(),
        };
        let node = Some(earliest.node).filter(|_| servers == 1);
        let finding = cx.verdict(what, node, None, None);
        cx.report(Finding { at: earliest.first, ..finding });
    }
}

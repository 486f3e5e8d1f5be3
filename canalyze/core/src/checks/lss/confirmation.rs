//! Whether the traffic on LSS's identifiers is LSS.
//!
//! A network that is no CANopen may use any identifier for something else, and a verdict on it would be wrong: findings
//! wait to be confirmed. An answer to a request shows it; at the end of the capture, enough valid frames do. It must not
//! judge.

use crate::context::Context;
use crate::finding::{Code, Finding, Verdict};
use crate::frame::FrameRef;

/// Valid LSS frames for each finding, before the traffic counts as LSS.
const VALID: usize = 3;

/// What shows that it is LSS.
#[derive(Debug, Default)]
pub struct Confirmation {
    /// It is.
    confirmed: bool,
    /// The first LSS frame.
    first: Option<FrameRef>,
    /// Frames with a known command and unused bytes 0; and whether one of a slave is among them.
    valid: usize,
    answered: bool,
}

impl Confirmation {
    /// A frame on LSS's identifiers; `valid`: with a known command and unused bytes 0.
    pub fn follow(&mut self, at: FrameRef, from_master: bool, valid: bool) {
        self.first.get_or_insert(at);
        self.valid += usize::from(valid);
        self.answered |= valid && !from_master;
    }

    /// Reports a finding at the frame at hand, once it is known to be one.
    pub fn raise(&self, what: impl Into<Verdict>, node: Option<u8>, cause: Option<FrameRef>, cx: &mut Context<'_>) {
        let finding = cx.verdict(what, node, None, cause);
        if self.confirmed {
            cx.report(finding);
        } else {
            cx.evidence.pending.keep_unconfirmed(finding);
        }
    }

    /// The same of what rests on a deadline (see [`Context::report_timed`]).
    pub fn raise_timed(
        &self,
        what: impl Into<Verdict>,
        node: Option<u8>,
        cause: Option<FrameRef>,
        cx: &mut Context<'_>,
    ) {
        if cx.is_timed() {
            self.raise(what, node, cause, cx);
        }
    }

    /// The traffic is LSS.
    pub fn confirm(&mut self, cx: &mut Context<'_>) {
        if !std::mem::replace(&mut self.confirmed, true) {
            cx.decide(|one| is_of_lss(one).then_some(true));
        }
    }

    /// The capture is over. Where nothing has shown that it is LSS, only that a slave did not answer is reported, or
    /// once, at the first frame, that it does not look like LSS.
    pub fn finish(&mut self, cx: &mut Context<'_>) {
        let Some(first) = self.first else { return };
        let waiting = || cx.evidence.pending.unconfirmed().iter().filter(|one| is_of_lss(one));
        let enough = self.answered && self.valid >= VALID.max(waiting().count() * VALID);
        if enough || waiting().all(|one| one.code == Code::Lss012) {
            self.confirm(cx);
        } else {
            cx.report(Finding { at: first, ..cx.verdict(Code::Lss030, None, None, None) });
        }
    }
}

fn is_of_lss(finding: &Finding) -> bool {
    finding.code.rule().id.starts_with("LSS")
}

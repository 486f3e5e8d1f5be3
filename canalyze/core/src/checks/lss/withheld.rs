//! Findings that wait until the traffic on their identifiers has shown that it is of their service.
//!
//! A network that is no CANopen may use any identifier for something else, and a verdict on it would be wrong. It must
//! not know what shows that: the check says so.

use crate::context::Context;
use crate::finding::{Code, Finding, Verdict};
use crate::frame::FrameRef;

/// Findings kept while they wait.
const KEPT: usize = 16;

/// The findings of one check.
#[derive(Debug, Default)]
pub struct Withheld {
    /// The service has shown itself: nothing is withheld any more.
    shown: bool,
    waiting: Vec<Finding>,
}

impl Withheld {
    /// Reports a finding at the frame at hand, or keeps it.
    pub fn raise(&mut self, what: impl Into<Verdict>, node: Option<u8>, cause: Option<FrameRef>, cx: &mut Context<'_>) {
        let finding = cx.verdict(what, node, None, cause);
        if self.shown {
            cx.report(finding);
        } else {
            self.keep(finding);
        }
    }

    /// The same of what rests on a deadline (see [`Context::report_timed`]).
    pub fn raise_timed(
        &mut self,
        what: impl Into<Verdict>,
        node: Option<u8>,
        cause: Option<FrameRef>,
        cx: &mut Context<'_>,
    ) {
        let finding = cx.verdict(what, node, None, cause);
        if self.shown {
            cx.report_timed(finding);
        } else {
            self.keep(finding);
        }
    }

    fn keep(&mut self, finding: Finding) {
        if self.waiting.len() < KEPT {
            self.waiting.push(finding);
        }
    }

    /// How many wait.
    pub fn waiting(&self) -> usize {
        self.waiting.len()
    }

    /// The traffic is of the service.
    pub fn show(&mut self, cx: &mut Context<'_>) {
        self.shown = true;
        for finding in std::mem::take(&mut self.waiting) {
            cx.emit(finding);
        }
    }

    /// The capture is over. Where the service never showed itself, findings of which all are `harmless` are raised;
    /// otherwise it is reported once that the traffic is `foreign`, at its first frame.
    pub fn finish(&mut self, harmless: Code, foreign: Code, first: FrameRef, cx: &mut Context<'_>) {
        let waiting = std::mem::take(&mut self.waiting);
        if waiting.iter().all(|finding| finding.code == harmless) {
            waiting.into_iter().for_each(|finding| cx.emit(finding));
        } else {
            cx.emit(Finding { at: first, ..cx.verdict(foreign, None, None, None) });
        }
    }
}

//! Findings that wait until the traffic on LSS's identifiers has shown that it is LSS.
//!
//! A network that is no CANopen may use any identifier for something else, and a verdict on it would be wrong. An
//! answer to a request shows it; at the end of the capture, enough valid frames do. It must not judge.

use crate::context::Context;
use crate::finding::{Code, Finding, Verdict};
use crate::frame::FrameRef;

/// Findings kept while they wait.
const KEPT: usize = 16;
/// Valid LSS frames for each finding, before the traffic counts as LSS.
const VALID: usize = 3;

/// The findings of LSS on a bus.
#[derive(Debug, Default)]
pub struct Withheld {
    /// It is LSS: nothing is withheld any more.
    shown: bool,
    waiting: Vec<Finding>,
    /// The first LSS frame.
    first: Option<FrameRef>,
    /// Frames with a known command and unused bytes 0; and whether one of a slave is among them.
    valid: usize,
    answered: bool,
    frames: u64,
}

impl Withheld {
    /// A frame on LSS's identifiers; `valid`: with a known command and unused bytes 0.
    pub fn follow(&mut self, at: FrameRef, from_master: bool, valid: bool) {
        self.first.get_or_insert(at);
        self.frames += 1;
        self.valid += usize::from(valid);
        self.answered |= valid && !from_master;
    }

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

    /// The frames, and whether they have shown that they are LSS: by an answer, or since most can be LSS.
    pub fn shown(&self) -> (u64, bool) {
        (self.frames, self.shown || self.valid as u64 > self.frames / 2)
    }

    /// The traffic is LSS.
    pub fn show(&mut self, cx: &mut Context<'_>) {
        self.shown = true;
        for finding in std::mem::take(&mut self.waiting) {
            cx.report(finding);
        }
    }

    /// The capture is over. Where nothing has shown that it is LSS, only that a slave did not answer is reported, or
    /// once, at the first frame, that it does not look like LSS.
    pub fn finish(&mut self, cx: &mut Context<'_>) {
        let Some(first) = self.first else { return };
        let waiting = std::mem::take(&mut self.waiting);
        let enough = self.answered && self.valid >= VALID.max(waiting.len() * VALID);
        if enough || waiting.iter().all(|finding| finding.code == Code::Lss012) {
            waiting.into_iter().for_each(|finding| cx.report(finding));
        } else {
            cx.report(Finding { at: first, ..cx.verdict(Code::Lss030, None, None, None) });
        }
    }
}

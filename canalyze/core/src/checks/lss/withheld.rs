//! Findings withheld until the traffic on the LSS identifiers has proved to be LSS.
//!
//! A network other than CANopen may use any identifier for something else. An answer to a request is proof; at the end
//! of the capture, a sufficient number of valid frames is.

use crate::bytes::frame::FrameRef;
use crate::rules::finding::{Code, Finding, Verdict};
use crate::world::context::Context;

/// Maximum number of withheld findings.
const KEPT: usize = 16;
/// Number of valid LSS frames per finding that make the traffic LSS.
const VALID: usize = 3;

/// The LSS findings of a bus.
#[derive(Debug, Default)]
pub struct Withheld {
    /// The traffic is LSS, and findings are no longer withheld.
    shown: bool,
    waiting: Vec<Finding>,
    /// The first LSS frame.
    first: Option<FrameRef>,
    /// Number of frames with a known command and unused bytes 0; true if a slave's is among them.
    valid: usize,
    answered: bool,
    frames: u64,
}

impl Withheld {
    /// Takes a frame on an LSS identifier; `valid`: it has a known command and unused bytes 0.
    pub fn follow(&mut self, at: FrameRef, from_master: bool, valid: bool) {
        self.first.get_or_insert(at);
        self.frames += 1;
        self.valid += usize::from(valid);
        self.answered |= valid && !from_master;
    }

    /// Reports a finding at the current frame, or withholds it.
    pub fn raise(&mut self, what: impl Into<Verdict>, node: Option<u8>, cause: Option<FrameRef>, cx: &mut Context<'_>) {
        let finding = cx.verdict(what, node, None, cause);
        if self.shown {
            cx.report(finding);
        } else {
            self.keep(finding);
        }
    }

    /// Does the same for a finding that rests on a deadline (see [`Context::report_timed`]).
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

    /// Returns the number of frames, and true if an answer or the majority of frames shows them to be LSS.
    pub fn shown(&self) -> (u64, bool) {
        (self.frames, self.shown || self.valid as u64 > self.frames / 2)
    }

    /// Reports the withheld findings and all later ones, because the traffic is LSS.
    pub fn show(&mut self, cx: &mut Context<'_>) {
        self.shown = true;
        for finding in std::mem::take(&mut self.waiting) {
            cx.report(finding);
        }
    }

    /// Reports the withheld findings at the end of the capture. Without proof of LSS, reports only missing answers, or
    /// once, at the first frame, that the traffic does not look like LSS.
    pub fn finish(&mut self, cx: &mut Context<'_>) {
        let Some(first) = self.first else { return };
        let waiting = std::mem::take(&mut self.waiting);
        // Requests of a master alone are LSS if each of them is valid; their responses may be filtered.
        let alone = !self.answered && self.valid as u64 == self.frames && self.valid >= VALID;
        let enough = self.answered && self.valid >= VALID.max(waiting.len() * VALID);
        if alone {
            waiting.into_iter().filter(|finding| finding.code == Code::Lss012).for_each(|finding| cx.report(finding));
        } else if enough || waiting.iter().all(|finding| finding.code == Code::Lss012) {
            waiting.into_iter().for_each(|finding| cx.report(finding));
        } else {
            cx.report(Finding { at: first, ..cx.verdict(Code::Lss030, None, None, None) });
        }
    }
}

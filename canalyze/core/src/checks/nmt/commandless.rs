//! Findings that no NMT command explains while no command was seen at all: 000h may have been filtered out.
//!
//! Such findings wait for the first command, which shows that commands are captured, or until they are old. If states
//! change as only a master changes them, commands are missing and nothing is reported. Spontaneous changes are found in
//! `nmt`.

use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::evidence::Rules;
use crate::rules::finding::{Code, Finding};
use crate::wire::error_control::PRE_OPERATIONAL;
use crate::world::context::Context;

/// Maximum time that findings wait without a command, in ns, and their maximum number.
const WAIT_NS: Ns = Ns::from_s(10);
const KEPT: usize = 64;
/// Time within which changes of state count as simultaneous, in ns: heartbeats show them one after the other.
const TOGETHER_NS: Ns = Ns::from_s(1);

/// The waiting findings of a bus.
#[derive(Debug, Default)]
pub struct Commandless {
    /// A command was seen.
    commanded: bool,
    /// States have changed as only commands explain: the capture lacks them.
    filtered: bool,
    waiting: Vec<Finding>,
}

impl Commandless {
    /// Takes a command.
    pub fn command(&mut self, cx: &mut Context<'_>) {
        self.commanded = true;
        self.report(cx);
    }

    /// Returns true if a command was seen.
    pub fn commanded(&self) -> bool {
        self.commanded
    }

    /// Reports old findings; called for each frame before it is followed.
    #[inline]
    pub fn settle(&mut self, cx: &mut Context<'_>) {
        let old = |first: &Finding| cx.at.since(first.at).is_some_and(|age| age > WAIT_NS);
        if !self.filtered && self.waiting.first().is_some_and(old) {
            self.report(cx);
        }
    }

    /// Reports the waiting findings at the end of the capture.
    pub fn finish(&mut self, cx: &mut Context<'_>) {
        if !self.filtered {
            self.report(cx);
        }
    }

    /// Drops the waiting findings after lost frames, which may include commands.
    pub fn forget(&mut self) {
        self.waiting.clear();
    }

    /// Takes a change to the state `to` without command. By themselves, nodes only leave Operational for
    /// Pre-operational, each for its own reasons.
    pub fn changed(&mut self, node: u8, to: u8, finding: &Finding) {
        let alike = |other: &Finding| {
            other.code == Code::Nmt004
                && other.node != Some(node)
                && other.facts == finding.facts
                && finding.at.since(other.at).is_none_or(|age| age < TOGETHER_NS)
        };
        self.filtered |= !self.commanded && (to != PRE_OPERATIONAL || self.waiting.iter().any(alike));
    }

    /// Takes the return of a node to Operational; `booted`: its last boot-up. Without one since it has left that state only a
    /// command does so.
    pub fn returned(&mut self, node: u8, booted: Option<FrameRef>) {
        let since = booted.map_or(0, |boot| boot.no);
        let left = |one: &Finding| one.code == Code::Nmt004 && one.node == Some(node) && one.at.no > since;
        self.filtered |= !self.commanded && self.waiting.iter().any(left);
    }

    /// Takes a finding that no command explains. `wait_ns`: time in which something else may explain it.
    pub fn find(&mut self, finding: Finding, wait_ns: Ns, cx: &mut Context<'_>) {
        if self.commanded && wait_ns > Ns::ZERO && finding.because_of.is_none() {
            cx.report_later(finding, wait_ns);
        } else if self.commanded {
            cx.report(finding);
        } else if self.waiting.len() < KEPT {
            self.waiting.push(finding);
        }
    }

    fn report(&mut self, cx: &mut Context<'_>) {
        for finding in std::mem::take(&mut self.waiting) {
            // Two nodes with one node-ID may have been found since.
            cx.report(cx.excused(Rules::Nmt, cx.when, finding));
        }
    }
}

//! What no NMT command explains, while no command was seen at all: 000h may have been filtered out of the capture.
//!
//! Such findings wait for the first command, which shows that commands are captured, or until they are old. Where
//! states change as only a master makes them change, and no command was seen, commands are missing, and nothing is
//! reported. It must not decide what is spontaneous: that is `nmt`.

use crate::context::Context;
use crate::evidence::Rules;
use crate::finding::{Code, Finding};
use crate::wire::error_control::PRE_OPERATIONAL;

/// How long findings are kept while no command was seen, in ns, and how many.
const WAIT_NS: i64 = 10_000_000_000;
const KEPT: usize = 64;
/// Nodes change their states together within this time, in ns: their heartbeats show it one after the other.
const TOGETHER_NS: i64 = 1_000_000_000;

/// The findings of a bus that wait.
#[derive(Debug, Default)]
pub struct Commandless {
    /// A command was seen.
    commanded: bool,
    /// States have changed as only commands can explain: the capture lacks them.
    filtered: bool,
    waiting: Vec<Finding>,
}

impl Commandless {
    /// A command.
    pub fn command(&mut self, cx: &mut Context<'_>) {
        self.commanded = true;
        self.report(cx);
    }

    /// Whether any command was seen.
    pub fn commanded(&self) -> bool {
        self.commanded
    }

    /// With each frame, before it is followed.
    #[inline]
    pub fn settle(&mut self, cx: &mut Context<'_>) {
        let old = |first: &Finding| cx.at.since(first.at).is_some_and(|age| age > WAIT_NS);
        if !self.filtered && self.waiting.first().is_some_and(old) {
            self.report(cx);
        }
    }

    /// The capture is over.
    pub fn finish(&mut self, cx: &mut Context<'_>) {
        if !self.filtered {
            self.report(cx);
        }
    }

    /// Frames were lost: commands may be among them.
    pub fn forget(&mut self) {
        self.waiting.clear();
    }

    /// A node has gone to the state `to` without command. What nodes do by themselves is to leave Operational for
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

    /// A node's frame that no command explains. `wait_ns`: how long something else may explain it.
    pub fn find(&mut self, finding: Finding, wait_ns: i64, cx: &mut Context<'_>) {
        if self.commanded && wait_ns > 0 && finding.because_of.is_none() {
            cx.report_later(finding, wait_ns);
        } else if self.commanded {
            cx.report(finding);
        } else if self.waiting.len() < KEPT {
            self.waiting.push(finding);
        }
    }

    fn report(&mut self, cx: &mut Context<'_>) {
        for finding in std::mem::take(&mut self.waiting) {
            // What has become known since: two nodes with one node-ID.
            cx.report(cx.excused(Rules::Nmt, cx.when, finding));
        }
    }
}

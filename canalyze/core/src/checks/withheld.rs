//! Findings that wait until the traffic on their identifiers has shown that it is of their service.
//!
//! A network that is no CANopen may use any identifier for something else, and a verdict on it would be wrong. It must
//! not know what shows that: the check says so.

use crate::context::Context;
use crate::event::{Event, What};
use crate::finding::{Code, Facts, Finding};
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
    /// Raises a finding at the frame at hand, or keeps it.
    pub fn find(&mut self, code: Code, node: Option<u8>, cause: Option<FrameRef>, facts: Facts, cx: &mut Context<'_>) {
        if self.shown {
            cx.find(code, node, None, cause, facts);
        } else if self.waiting.len() < KEPT {
            self.waiting.push(Finding {
                code,
                at: cx.at,
                cause,
                bus: cx.bus,
                node,
                object: None,
                facts,
                because_of: None,
            });
        }
    }

    /// The same of what rests on a deadline (see [`Context::report_timed`]).
    pub fn find_timed(
        &mut self,
        code: Code,
        node: Option<u8>,
        cause: Option<FrameRef>,
        facts: Facts,
        cx: &mut Context<'_>,
    ) {
        if self.shown {
            cx.report_timed(cx.finding(code, node, None, cause, facts));
        } else {
            self.find(code, node, cause, facts, cx);
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
            raise(finding, cx);
        }
    }

    /// The capture is over. Where the service never showed itself, findings of which all are `harmless` are raised;
    /// otherwise it is said once that the traffic is `foreign`, at its first frame.
    pub fn finish(&mut self, harmless: Code, foreign: Code, first: FrameRef, cx: &mut Context<'_>) {
        let waiting = std::mem::take(&mut self.waiting);
        if waiting.iter().all(|finding| finding.code == harmless) {
            waiting.into_iter().for_each(|finding| raise(finding, cx));
        } else {
            let facts = Facts::None;
            let bus = cx.bus;
            raise(
                Finding {
                    code: foreign,
                    at: first,
                    cause: None,
                    bus,
                    node: None,
                    object: None,
                    facts,
                    because_of: None,
                },
                cx,
            );
        }
    }
}

/// Raises a finding where it stands.
pub(super) fn raise(finding: Finding, cx: &mut Context<'_>) {
    let Finding { at, cause, bus, node, .. } = finding;
    cx.events.push(Event { at, about: cause, bus, node, transfer: None, what: What::Finding(Box::new(finding)) });
}

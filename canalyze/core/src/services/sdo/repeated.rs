//! Requests that a client sends again since no answer came: was each of them answered?
//!
//! A server answers in the order in which it is asked, so what it owes is known once it answers another request, or
//! has had time. Until then a late answer may still come. Without stamps nothing is said: a request that was captured
//! twice cannot be told from one that was sent again.

use super::channel::{Channel, Half, Outside, UNANSWERED_NS};
use super::pairing::may_answer;
use super::sequence::within;
use super::wire::{self, Command, Side};
use crate::context::Context;
use crate::finding::{Code, Facts, Finding};
use crate::frame::FrameRef;

/// A client gives a request up no sooner than this, in ns.
const PATIENCE_NS: i64 = 20_000_000;
/// After an answer, the others of the same run have come by then, in ns.
const SETTLED_NS: i64 = 100_000_000;

/// A run of requests that are the same, of which the first was not answered when the second came.
#[derive(Clone, Copy, Debug)]
pub(super) struct Repeated {
    first: Half,
    second: FrameRef,
    newest: FrameRef,
    requests: u32,
    answers: u32,
    /// The newest answer.
    answered: Option<FrameRef>,
}

impl Repeated {
    /// Whether a response, or an abort for the same object, may be meant for a request of the run.
    fn is_for(&self, response: &Command) -> bool {
        match response {
            Command::Abort(object, _) => self.first.command.mux().is_none_or(|mux| mux == *object),
            _ => wire::fits(&self.first.command, response),
        }
    }

    /// Whether one request at least was not answered, and another was.
    fn owes(&self) -> bool {
        (1..self.requests).contains(&self.answers)
    }
}

impl Channel {
    /// A request comes again before the one before it was answered.
    pub(super) fn repeat(&mut self, before: &Half, half: &Half) {
        let known = self.trusted || self.is_idle_from_start();
        let edge = self.is_edge(before) || self.outside == Outside::Uncaptured;
        // Something else came in the answer's place, or it may be listed before its request.
        let answered = self.is_unanswerable(before)
            || self.pairing.heard.is_some_and(|heard| {
                let ahead = self.sequence.within_lag(heard.at, before.at);
                heard.at.no > before.at.no || (ahead && may_answer(&before.command, &heard.command))
            });
        if !known || edge || answered || within(before.at, half.at, PATIENCE_NS) || self.pairing.repeated.is_some() {
            return;
        }
        self.pairing.repeated = Some(Repeated {
            first: *before,
            second: half.at,
            newest: half.at,
            requests: 2,
            answers: 0,
            answered: None,
        });
    }

    /// A client frame: does it belong to the run, or end it?
    pub(super) fn repeated_by_client(&mut self, half: &Half, cx: &mut Context<'_>) {
        let Some(run) = &mut self.pairing.repeated else { return };
        if run.answered.is_some_and(|answer| !within(answer, half.at, SETTLED_NS)) {
            self.end_repeated(cx);
            return;
        }
        let abort = matches!(half.command, Command::Abort(..));
        let same = half.bytes == run.first.bytes;
        if abort || (half.command.is_initiate() && run.answers == 0 && !same) {
            // Without an answer, the request that waits is told of like any other.
            self.pairing.repeated = None;
            return;
        }
        if !same || within(run.newest, half.at, PATIENCE_NS) {
            return;
        }
        (run.requests, run.newest) = (run.requests.saturating_add(1), half.at);
    }

    /// A server frame: does it answer the run, or another request?
    pub(super) fn repeated_by_server(&mut self, half: &Half, cx: &mut Context<'_>) {
        let pending = self.pairing.pending;
        let Some(run) = &mut self.pairing.repeated else { return };
        if run.is_for(&half.command) {
            (run.answers, run.answered) = (run.answers.saturating_add(1), Some(half.at));
            if run.answers >= run.requests {
                self.pairing.repeated = None;
            }
        } else if pending.is_some_and(|pending| wire::fits(&pending.command, &half.command)) {
            self.end_repeated(cx);
        }
    }

    /// The capture is over.
    pub(super) fn repeated_at_end(&mut self, cx: &mut Context<'_>) {
        let settled = |run: &Repeated| {
            let old = |from: FrameRef, to: FrameRef| !within(from, to, UNANSWERED_NS);
            old(run.first.at, run.second) || run.answered.is_some_and(|answer| old(answer, cx.at))
        };
        if self.pairing.repeated.as_ref().is_some_and(settled) {
            self.end_repeated(cx);
        }
    }

    /// No answer of the run can come any more.
    fn end_repeated(&mut self, cx: &mut Context<'_>) {
        let Some(run) = self.pairing.repeated.take().filter(Repeated::owes) else { return };
        let finding = Finding {
            code: Code::Sdo002,
            at: run.second,
            cause: Some(run.first.at),
            bus: self.bus,
            node: Some(self.node),
            object: run.first.command.mux(),
            facts: Facts::Missing { by: Side::Server },
            because_of: None,
        };
        self.say(finding, cx);
    }
}

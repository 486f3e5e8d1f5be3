//! Requests that are listed late: to which of the frames of the server, before or behind them, they belong.
//!
//! Must not: keep frames back (`mod` does), or judge.

use super::super::channel::{Channel, UNANSWERED_NS, strict_initiate};
use super::super::phase::{Half, Phase};
use super::super::transfer::{Direction, Status};
use super::super::wire::{self, Command, Side};
use super::{Held, UnderWay, within};
use crate::context::Context;
use crate::event::{Note, Place};
use crate::evidence::recording::USUAL_ECHO_NS;
use crate::finding::Code;

impl Channel {
    /// Whether a request that fits the first frame that waits may as well be answered by the next: that one is the
    /// first of the channel, or the client reads one object again and again.
    pub(super) fn fits_next_as_well(&self, half: &Half, front: &Held) -> bool {
        if !half.command.is_initiate() || matches!(self.phase, Phase::Block(..)) {
            return false;
        }
        let stamped = front.half.at.t_ns.is_some() && half.at.t_ns.is_some();
        let again = self.history.last_request == Some(half.command);
        front.first || (stamped && again && !within(front.half.at, half.at, USUAL_ECHO_NS))
    }

    /// The frame behind an undecided request shows which response is its own: a second one that fits, soon after it and
    /// long after the first, or where the first may belong to a request before the capture.
    pub(super) fn decide(&mut self, next: Option<(Side, &Half)>, cx: &mut Context<'_>) {
        let Some(request) = self.sequence.undecided.take() else { return };
        let lag_ns = self.sequence.lag_ns;
        let rather = |front: &Held| match next {
            Some((Side::Server, next)) => is_rather(&request, front, next, lag_ns),
            // A client that goes on has its answer.
            Some((Side::Client, next)) if within(request.at, next.at, UNANSWERED_NS) => false,
            _ => front.first && !within(front.half.at, request.at, USUAL_ECHO_NS),
        };
        if let Some(front) = self.sequence.held.front().copied()
            && rather(&front)
        {
            if front.first {
                self.sequence.held.pop_front();
                self.note(Note::RequestNotCaptured, front.half.at, cx);
            } else {
                self.release(cx);
            }
        }
        self.aside(|channel| {
            channel.client(request, cx);
            channel.follow(cx);
        });
    }

    /// What a client frame is that was on its way when the server aborted.
    pub(in crate::services::sdo) fn is_under_way(&mut self, half: &Half) -> Option<Command> {
        let (idle, lag_ns) = (matches!(self.phase, Phase::Idle), self.sequence.lag_ns);
        let sent_before = |it: &&mut UnderWay| it.side == Side::Client && !half.command.is_initiate();
        let under_way = self.sequence.under_way.as_mut().filter(sent_before)?;
        if under_way.continues(half) {
            return Some(wire::block_segment(half.bytes));
        }
        let late = under_way.is_owed(half)
            || (idle && std::mem::take(&mut under_way.unasked) && within(under_way.at, half.at, lag_ns));
        late.then_some(half.command)
    }

    /// What a client frame shows of its last request and of the response before it. Returns the frame as it is read
    /// then; none where it needs nothing more.
    pub(in crate::services::sdo) fn reconsider(&mut self, half: Half, cx: &mut Context<'_>) -> Option<Half> {
        if matches!(self.phase, Phase::Block(..)) && !half.command.is_initiate() {
            return Some(half);
        }
        if let Some(pending) = self.pending()
            && self.settle_pending(&pending, &half, cx)
        {
            return None;
        }
        let half = if half.reading.is_some() { self.decoded(Side::Client, half) } else { half };
        self.step.command = half.command;
        if let Some(released) = self.history.released.take()
            && self.begin_from_response(&released, &half, cx)
        {
            let half = self.decoded(Side::Client, half);
            self.step.command = half.command;
            return Some(half);
        }
        if self.has_begun(&half)
            && let Some(answer) = self.sequence.answered.take()
        {
            self.leave_answered(cx);
            self.step.answered_by = Some(Box::new(answer.at));
            self.take(Side::Client, half, cx);
            self.server(answer, cx);
            return None;
        }
        Some(half)
    }

    /// A client frame while its last request was not answered: was it, before it was captured? Returns whether the
    /// frame needs nothing more.
    pub(in crate::services::sdo) fn settle_pending(
        &mut self,
        pending: &Half,
        half: &Half,
        cx: &mut Context<'_>,
    ) -> bool {
        if half.command.is_initiate() && self.sequence.may_be_answered(pending) {
            self.leave_answered(cx);
            return false;
        }
        if pending.bytes == half.bytes && pending.len == half.len {
            self.repeated(pending, half, cx);
            return true;
        }
        // Of initiates only those with reserved bytes can be told from data.
        let initiate = strict_initiate(half) && !matches!(half.command, Command::InitiateDownload(..));
        let midway = !initiate && self.is_midway_block(pending, half);
        if midway {
            self.forget_beginning();
            self.begin_midway_block(half, cx);
            return true;
        }
        let edge = self.is_edge(pending) || self.hypotheses.are_open();
        let goes_on = matches!(pending.command, Command::InitiateBlockDownload { .. }) && half.bytes[0] & 0x7F == 1;
        if edge && pending.command.is_block_initiate() && !goes_on && !half.command.is_initiate() {
            self.forget_beginning();
        }
        false
    }

    /// The pending request comes again.
    fn repeated(&mut self, pending: &Half, half: &Half, cx: &mut Context<'_>) {
        self.step.place = Place::Repeated;
        // Both may still be answered.
        (self.history.given_up, self.history.booted) = (Some(*pending), false);
        if self.is_sent_again(pending, half, cx) {
            self.find(Code::Sdo015, pending.at, cx);
        }
        self.step.ordinal = self.segment_ordinal(&half.command);
        self.set_pending(*half);
    }

    /// Whether a request was sent again, and not captured twice, though no response to the first can be meant by
    /// anything that came.
    fn is_sent_again(&self, before: &Half, half: &Half, cx: &Context<'_>) -> bool {
        let known = self.proof.trusted || self.hypotheses.is_whole();
        let edge = self.is_edge(before) || self.hypotheses.are_open();
        // Something else came in the response's place, or it may be listed before its request.
        let answered = self.is_unanswerable(before)
            || self.history.heard.is_some_and(|heard| {
                let ahead = self.sequence.within_lag(heard.at, before.at);
                heard.at.no > before.at.no || (ahead && wire::may_answer(&before.command, &heard.command))
            });
        known && !edge && !answered && cx.evidence.recording.is_sent_again(before.at, half.at)
    }

    /// Whether the segments that are about to come may be those of this request, captured after the response to it, and
    /// not those of the request before, whose response is not in the capture.
    fn has_begun(&self, half: &Half) -> bool {
        matches!(self.phase, Phase::Segments(_)) && self.pending().is_none() && self.sequence.may_be_answered(half)
    }

    /// The pending request was answered before it was captured, by what was taken for the response to another request.
    pub(super) fn leave_answered(&mut self, cx: &mut Context<'_>) {
        self.sequence.certain = true;
        self.complete_before(Status::Incomplete, cx);
    }

    /// Whether a response that does not fit the pending request belongs to another one, or to a transfer that began
    /// before the capture.
    pub(in crate::services::sdo) fn belongs_elsewhere(
        &mut self,
        pending: &Half,
        half: &Half,
        cx: &mut Context<'_>,
    ) -> bool {
        let midway = self.hypotheses.are_open() || (self.is_edge(pending) && pending.command.is_block_initiate());
        if midway && matches!(half.command, Command::BlockAck { .. }) {
            self.forget_beginning();
            self.step.place = Place::Uncaptured;
            self.join_block(half, Direction::Download, cx);
            return true;
        }
        let late = self.is_late(half);
        if late {
            self.late(half, cx);
        }
        late
    }
}

/// Whether the response at `next` is rather the request's own than the one that waits.
fn is_rather(request: &Half, front: &Held, next: &Half, lag_ns: i64) -> bool {
    // An abort may still follow a response that begins a segmented transfer.
    let over = match (request.command, front.half.command) {
        (_, Command::Abort(..)) => true,
        (Command::InitiateDownload(_, i), _) | (_, Command::UploadInitiated(_, i)) => i.expedited,
        _ => false,
    };
    let fits = if over { wire::may_answer } else { wire::fits };
    if !fits(&request.command, &next.command) {
        return false;
    }
    let (Some(response), Some(asked), Some(following)) = (front.half.at.t_ns, request.at.t_ns, next.at.t_ns) else {
        return front.first;
    };
    let (late, taken) = (asked.saturating_sub(response), following.saturating_sub(asked));
    let refused = !matches!(front.half.command, Command::Abort(..)) && matches!(next.command, Command::Abort(..));
    if front.first && !refused { late > lag_ns || taken <= lag_ns } else { late > taken }
}

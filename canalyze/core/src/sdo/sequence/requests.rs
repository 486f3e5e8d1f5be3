//! Assigns requests listed late to frames of the server before or after them.

use super::super::limits::{UNANSWERED_NS, within};
use super::super::phase::{Half, Phase, strict_initiate};
use super::super::state::{Held, SdoChannel, UnderWay};
use super::super::transfer::{Direction, Status};
use super::super::wire::{self, Command, Side};
use crate::bytes::ns::Ns;
use crate::evidence::recording::USUAL_ECHO_NS;
use crate::rules::finding::Code;
use crate::world::context::Context;
use crate::world::event::{Note, Place};

impl SdoChannel {
    /// Returns true if a request fits the first and the next waiting frame alike: the first is the channel's first, or
    /// the client polls one object.
    pub(super) fn fits_next_as_well(&self, half: &Half, front: &Held) -> bool {
        if !half.command.is_initiate() || matches!(self.phase, Phase::Block(..)) {
            return false;
        }
        let stamped = front.half.at.t_ns.is_some() && half.at.t_ns.is_some();
        let again = self.history.last_request == Some(half.command);
        front.first || (stamped && again && !within(front.half.at, half.at, USUAL_ECHO_NS))
    }

    /// Assigns a response to an undecided request by the following frame: the second that fits if it is soon after the
    /// request and long after the first, or if the first may answer a request before the capture.
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

    /// Returns the command of a client frame that was on its way when the server aborted.
    pub(in crate::sdo) fn is_under_way(&mut self, half: &Half) -> Option<Command> {
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

    /// Takes the evidence of a client frame on its last request and the response before it; returns the frame with its
    /// reading, or `None` if it is settled.
    pub(in crate::sdo) fn reconsider(&mut self, half: Half, cx: &mut Context<'_>) -> Option<Half> {
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

    /// Decides by a client frame if its unanswered request was answered before it was captured; returns true if the
    /// frame is settled.
    pub(in crate::sdo) fn settle_pending(&mut self, pending: &Half, half: &Half, cx: &mut Context<'_>) -> bool {
        if half.command.is_initiate() && self.sequence.may_be_answered(pending) {
            self.leave_answered(cx);
            return false;
        }
        if pending.bytes == half.bytes && pending.len == half.len {
            self.repeated(pending, half, cx);
            return true;
        }
        // Only initiates with reserved bytes differ from data.
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

    /// Takes a repetition of the pending request.
    fn repeated(&mut self, pending: &Half, half: &Half, cx: &mut Context<'_>) {
        self.step.place = Place::Repeated;
        // Either may still be answered.
        (self.history.given_up, self.history.booted) = (Some(*pending), false);
        if self.is_sent_again(pending, half, cx) {
            self.find(Code::Sdo015, pending.at, cx);
        }
        self.step.ordinal = self.segment_ordinal(&half.command);
        self.set_pending(*half);
    }

    /// Returns true if a request was sent again, not captured twice, although no frame can be a response to the first.
    fn is_sent_again(&self, before: &Half, half: &Half, cx: &Context<'_>) -> bool {
        let known = self.proof.trusted || self.hypotheses.is_whole();
        let edge = self.is_edge(before) || self.hypotheses.are_open();
        // Another frame came in the response's place, or it may be listed before its request.
        let answered = self.is_unanswerable(before)
            || self.history.heard.is_some_and(|heard| {
                let ahead = self.sequence.within_lag(heard.at, before.at);
                heard.at.no > before.at.no || (ahead && wire::may_answer(&before.command, &heard.command))
            });
        known && !edge && !answered && cx.evidence.recording.is_sent_again(before.at, half.at)
    }

    /// Returns true if the coming segments may belong to this request, captured after its response, rather than to the
    /// request before it.
    fn has_begun(&self, half: &Half) -> bool {
        matches!(self.phase, Phase::Segments(_)) && self.pending().is_none() && self.sequence.may_be_answered(half)
    }

    /// Ends the transfer: its request was answered before it was captured, by a frame assigned to another request.
    pub(super) fn leave_answered(&mut self, cx: &mut Context<'_>) {
        self.sequence.certain = true;
        self.complete_before(Status::Incomplete, cx);
    }

    /// Returns true if a response that does not fit the pending request belongs to another one, or to a transfer from
    /// before the capture.
    pub(in crate::sdo) fn belongs_elsewhere(&mut self, pending: &Half, half: &Half, cx: &mut Context<'_>) -> bool {
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

/// Returns true if the response at `next` is the request's own rather than the waiting one.
fn is_rather(request: &Half, front: &Held, next: &Half, lag_ns: Ns) -> bool {
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
    let (late, taken) = (asked - response, following - asked);
    let refused = !matches!(front.half.command, Command::Abort(..)) && matches!(next.command, Command::Abort(..));
    if front.first && !refused { late > lag_ns || taken <= lag_ns } else { late > taken }
}

//! The order of a channel's frames on the bus, where the capture lists the client's late.
//!
//! A host lists the frames that it sends itself later than those that it receives: a response may stand before its
//! request, several exchanges deep. Each side's own frames stay in order. So a frame of the server that answers nothing
//! yet waits here for the client's frames, as long as these may still come, and the machine behind takes all frames as
//! they were on the bus. A capture in causal order is never held up.
//!
//! It must not judge: a frame whose turn never comes is handed to the machine as it is.

use std::collections::VecDeque;

use super::channel::{Channel, Half, Phase};
use super::wire::{self, Command, Side};
use crate::context::Context;
use crate::event::{Note, Place};
use crate::evidence::recording::USUAL_ECHO_NS;
use crate::frame::FrameRef;
use crate::rules::sdo::Sdo017;

/// Without stamps, so many later frames of the channel may stand before the request.
pub(super) const FRAMES: u8 = 2;
/// Most frames that wait.
const MOST_HELD: usize = 256;

/// A frame of the server that came before its turn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Held {
    pub(super) half: Half,
    /// Its request may be before the capture.
    pub(super) first: bool,
    /// Frames of the channel since.
    age: u8,
}

/// Frames whose turn has not come.
#[derive(Debug, Default)]
pub(super) struct Sequence {
    held: VecDeque<Held>,
    /// A request that fits the first of them, and may as well be the next: the frame behind it tells.
    undecided: Option<Half>,
    /// How late the recording host lists its own frames at most, in ns.
    lag_ns: i64,
}

impl Sequence {
    /// Whether two frames are close enough for the second to be a late echo; without stamps, always.
    pub(super) fn within_lag(&self, from: FrameRef, to: FrameRef) -> bool {
        within(from, to, self.lag_ns)
    }
}

impl Channel {
    /// A frame has come: what it says of those that wait. Returns the frame as it is read after that.
    pub(super) fn order_before(&mut self, side: Side, half: Half, cx: &mut Context<'_>) -> Half {
        if side == Side::Client {
            self.pairing.released = None;
        }
        self.sequence.lag_ns = cx.evidence.recording.lag_ns();
        if self.sequence.held.is_empty() {
            return half;
        }
        self.decide(Some(&half).filter(|_| side == Side::Server), cx);
        self.release_expired(cx);
        self.decoded(side, half)
    }

    /// Takes a frame of the client.
    pub(super) fn order_client(&mut self, half: Half, cx: &mut Context<'_>) {
        while let Some(front) = self.sequence.held.front()
            && !self.may_precede(&half, front)
        {
            self.release(cx);
        }
        let ends = matches!(half.command, Command::EndBlock { .. });
        let half = if ends { half } else { self.decoded(Side::Client, half) };
        self.step.command = half.command;
        if let Some(front) = self.sequence.held.front()
            && self.is_ambiguous(&half, front)
        {
            self.step.answered_by = Some(front.half.at);
            self.sequence.undecided = Some(half);
            return;
        }
        self.client(half, cx);
        self.follow(cx);
    }

    /// Takes a frame of the server.
    pub(super) fn order_server(&mut self, half: Half, fresh: bool, cx: &mut Context<'_>) {
        let answers = self.pairing.pending.is_some_and(|pending| wire::fits(&pending.command, &half.command));
        if answers && self.pairing.pending.is_some_and(|pending| self.is_edge(&pending)) {
            // What waits answers requests before the capture.
            self.sequence.held.clear();
        }
        if answers || self.ends(&half) {
            self.release_all(cx);
        } else if self.sequence.held.len() == MOST_HELD {
            self.release(cx);
        }
        if !self.sequence.held.is_empty() || !self.is_due(&half) {
            if self.pairing.pending.is_some_and(|pending| self.pairing.may_be_answered(&pending)) {
                self.leave_answered(cx);
            }
            if let Command::Abort(_, code) = half.command {
                self.find(Sdo017::Abort { abort: code, by: Side::Server }, half.at, cx);
            }
            self.hold(half, fresh);
            return;
        }
        // Before the transfer completes with this frame: the finding is the transfer's.
        self.judge_frame(&half, cx);
        self.server(half, cx);
    }

    /// The capture is over, or interrupted: what waits is taken as it stands.
    pub(super) fn order_rest(&mut self, cx: &mut Context<'_>) {
        self.decide(None, cx);
        while let Some(held) = self.sequence.held.front() {
            // The frame it waits for may lie beyond the edge, unless there was time enough.
            if within(held.half.at, cx.at, super::channel::UNANSWERED_NS) {
                let Some(held) = self.sequence.held.pop_front() else { return };
                self.at_the_edge(&held.half, cx);
            } else {
                self.release(cx);
            }
        }
    }

    /// The frame as it is read where the transfer stands now.
    fn decoded(&self, side: Side, half: Half) -> Half {
        Half { command: self.decode(side, half.bytes, half.len), ..half }
    }

    /// Whether an abort ends a transfer that runs, so that it waits for nothing.
    fn ends(&self, half: &Half) -> bool {
        matches!(half.command, Command::Abort(..)) && self.is_due(half)
    }

    /// The line of a frame that waits: what it is if its request comes.
    fn hold(&mut self, half: Half, fresh: bool) {
        let before = self.sequence.held.len() as u32;
        self.step.ordinal = match (&self.phase, half.command) {
            (Phase::Block(block), Command::BlockSegment { .. }) => block.ordinal() + before,
            _ => self.segment_ordinal(&half.command),
        };
        let half = match (&self.phase, half.command) {
            // In a transfer met in its midst it may be the answer to a late request.
            (Phase::Block(block), Command::BlockSegment { .. }) if !block.owes_ack() => {
                self.step.place = Place::Uncaptured;
                Half { command: wire::decode(Side::Server, half.bytes), ..half }
            }
            _ => half,
        };
        if fresh {
            self.step.place = Place::Uncaptured;
        }
        // Where nothing of the channel can lie before it, an answer without a request counts as the first request does.
        self.proof.begun |= self.is_idle_from_start() && super::pairing::is_strict_answer(&half);
        self.sequence.held.push_back(Held { half, first: fresh || !self.proof.begun, age: 0 });
    }

    /// Hands on what waited and is due now.
    fn follow(&mut self, cx: &mut Context<'_>) {
        while let Some(held) = self.sequence.held.front().copied() {
            let half = self.decoded(Side::Server, held.half);
            if !self.is_due(&half) {
                return;
            }
            self.sequence.held.pop_front();
            let step = self.step.clone();
            let answers = self.pairing.pending.is_some();
            if let Some(transfer) = &mut self.transfer {
                transfer.reordered = true;
            }
            self.step.place = Place::Due;
            self.judge_frame(&half, cx);
            self.server(half, cx);
            let result = self.step.result.take();
            self.step = step;
            self.step.result = result.or(self.step.result.take());
            if answers {
                self.step.answered_by = self.step.answered_by.or(Some(held.half.at));
            }
        }
    }

    /// Hands on the first of the frames that wait: the client's frame before it is not in the capture.
    fn release(&mut self, cx: &mut Context<'_>) {
        let Some(held) = self.sequence.held.pop_front() else { return };
        self.aside(|channel| {
            let half = channel.decoded(Side::Server, held.half);
            channel.step.place = if held.first { Place::Uncaptured } else { Place::Due };
            channel.judge_frame(&half, cx);
            channel.unrequested(&half, held.first, cx);
            channel.follow(cx);
        });
    }

    pub(super) fn release_all(&mut self, cx: &mut Context<'_>) {
        while !self.sequence.held.is_empty() {
            self.release(cx);
        }
    }

    /// Does something that is not about the frame at hand.
    pub(super) fn aside(&mut self, act: impl FnOnce(&mut Self)) {
        let step = self.step.clone();
        let own = std::mem::replace(&mut self.own, false);
        act(self);
        (self.step, self.own) = (step, own);
    }

    fn release_expired(&mut self, cx: &mut Context<'_>) {
        for held in &mut self.sequence.held {
            held.age = held.age.saturating_add(1);
        }
        while let Some(front) = self.sequence.held.front() {
            let late = match (front.half.at.t_ns, cx.at.t_ns) {
                (Some(_), Some(_)) => !self.sequence.within_lag(front.half.at, cx.at),
                _ => front.age > FRAMES,
            };
            if !late {
                return;
            }
            self.release(cx);
        }
    }

    /// Whether the first frame that waits may come after this one of the client.
    fn may_precede(&self, half: &Half, front: &Held) -> bool {
        let half = self.decoded(Side::Client, *half);
        let answer = match half.command.is_initiate() {
            // A request ends the block transfer, and its answer is no segment of it.
            true => wire::decode_frame(Side::Server, front.half.bytes, front.half.len),
            false => self.decoded(Side::Server, front.half).command,
        };
        if let (Phase::Block(block), false) = (&self.phase, half.command.is_initiate()) {
            return match (half.command, answer) {
                (Command::BlockSegment { seqno, .. }, Command::BlockAck { .. }) => seqno == block.expected(),
                (Command::EndBlock { .. }, Command::BlockEnded) | (Command::StartBlockUpload, _) => true,
                (Command::BlockAck { ackseq, .. }, _) => {
                    block.owes_ack() && (block.owed_ack() == Some(ackseq) || !self.holds_sub_block(ackseq))
                }
                (Command::Truncated(_), _) => block.owes_ack() || block.end.is_some(),
                (Command::BlockEnded, _) => block.end.is_some(),
                _ => false,
            };
        }
        let refused = matches!(answer, Command::Abort(object, _) if half.command.mux() == Some(object));
        (refused || wire::fits(&half.command, &answer))
            && (self.can_request(&half) || self.may_join(&half) || self.pairing.pending.is_some())
    }

    /// Whether the frames that wait are a whole sub-block of so many segments, the last of them marked.
    fn holds_sub_block(&self, segments: u8) -> bool {
        let mut held = self.sequence.held.iter().filter_map(|held| match held.half.command {
            Command::BlockSegment { seqno, last, .. } => Some((seqno, last)),
            _ => None,
        });
        held.any(|(seqno, last)| last && seqno == segments)
    }

    /// Whether an acknowledgement waits for block segments that may be late.
    pub(super) fn awaits_segments(&self) -> bool {
        self.sequence.held.front().is_some_and(|held| matches!(held.half.command, Command::BlockAck { .. }))
    }

    /// Whether a request that fits the first frame that waits may as well be answered by the next: that one is the first
    /// of the channel, or the client reads one object again and again.
    fn is_ambiguous(&self, half: &Half, front: &Held) -> bool {
        if !half.command.is_initiate() || matches!(self.phase, Phase::Block(_)) {
            return false;
        }
        let stamped = front.half.at.t_ns.is_some() && half.at.t_ns.is_some();
        let again = self.pairing.last_request == Some(half.command);
        front.first || (stamped && again && !within(front.half.at, half.at, USUAL_ECHO_NS))
    }

    /// The frame behind an undecided request shows which response is its own: a second one that fits, soon after it and
    /// long after the first, or where the first may belong to a request before the capture.
    fn decide(&mut self, next: Option<&Half>, cx: &mut Context<'_>) {
        let Some(request) = self.sequence.undecided.take() else { return };
        if let (Some(front), Some(next)) = (self.sequence.held.front().copied(), next)
            && is_rather(&request, &front, next, self.sequence.lag_ns)
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
}

/// Whether the response at `next` is rather the request's own than the one that waits.
fn is_rather(request: &Half, front: &Held, next: &Half, lag_ns: i64) -> bool {
    let fits = match front.half.command {
        Command::Abort(..) => super::pairing::may_answer(&request.command, &next.command),
        _ => wire::fits(&request.command, &next.command),
    };
    if !fits {
        return false;
    }
    let (Some(response), Some(asked), Some(following)) = (front.half.at.t_ns, request.at.t_ns, next.at.t_ns) else {
        return front.first;
    };
    let (late, taken) = (asked.saturating_sub(response), following.saturating_sub(asked));
    if front.first { late > lag_ns || taken <= lag_ns } else { late > taken }
}

/// Whether a frame follows another by no more than a time in ns; without stamps, always.
pub(super) fn within(from: FrameRef, to: FrameRef, limit_ns: i64) -> bool {
    match (from.t_ns, to.t_ns) {
        (Some(from), Some(to)) => to.saturating_sub(from) <= limit_ns,
        _ => true,
    }
}

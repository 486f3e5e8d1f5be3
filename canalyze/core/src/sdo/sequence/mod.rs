//! The order of a channel's frames on the bus, if the capture lists the client's late.
//!
//! A host lists its own frames later than received ones: a response may precede its request, by several exchanges. The
//! frames of each side stay in order. So a server's frame that answers nothing yet waits here while client frames may
//! still come, and `machine` takes all frames in their order on the bus. A capture in causal order is never delayed.
//!
//! Late requests are assigned in `requests`. A frame whose turn never comes is passed on unchanged.

mod requests;

use super::abort_code::AbortCode;
use super::limits::{UNANSWERED_NS, within};
use super::phase::{Half, Phase, is_strict_answer, strict_initiate};
use super::state::{Held, SdoChannel, Sequence, UnderWay};
use super::wire::{self, Command, Side};
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::rules::sdo::Sdo017;
use crate::world::context::Context;
use crate::world::event::Place;

/// Maximum number of later frames of the channel listed before the request, used without stamps.
pub(super) const FRAMES: u8 = 2;
/// Maximum number of waiting frames.
const MOST_HELD: usize = 256;

impl UnderWay {
    /// Returns true if a frame is the next block segment, and counts it.
    fn continues(&mut self, half: &Half) -> bool {
        let [command, ..] = half.bytes;
        let continues = self.seqno != 0 && command & 0x7F == self.seqno;
        if continues {
            self.seqno = (self.seqno + 1) & 0x7F;
        }
        continues
    }

    /// Returns true if a client frame is the owed acknowledgement in time.
    fn is_owed(&mut self, half: &Half) -> bool {
        let Command::BlockAck { ackseq, .. } = half.command else { return false };
        self.owed.take() == Some(ackseq) && within(self.at, half.at, UNANSWERED_NS)
    }
}

impl Sequence {
    /// Returns true if the second of two frames may be a late echo; without stamps, always.
    pub(super) fn within_lag(&self, from: FrameRef, to: FrameRef) -> bool {
        within(from, to, self.lag_ns)
    }

    /// Takes a client frame that assigns the last response: it is later than an echo, or names another object.
    pub(super) fn ascertain(&mut self, next: &Half) {
        let own =
            |answer: Half| !self.within_lag(answer.at, next.at) || !wire::may_answer(&next.command, &answer.command);
        self.certain |= self.answered.is_some_and(own);
    }

    /// Returns true if the response before this request may be its own.
    pub(super) fn may_be_answered(&self, request: &Half) -> bool {
        !self.certain
            && request.command.is_initiate()
            && self.answered.is_some_and(|answer| wire::may_answer(&request.command, &answer.command))
    }

    /// Returns true if a waiting frame can answer a request.
    pub(super) fn holds_answer(&self, request: &Command) -> bool {
        self.held.iter().any(|held| wire::may_answer(request, &held.half.command))
    }

    /// Returns true if a waiting frame begins a segmented upload.
    pub(super) fn holds_upload(&self) -> bool {
        let begins = |held: &Held| matches!(held.half.command, Command::UploadInitiated(_, i) if !i.expedited);
        self.held.iter().any(begins)
    }

    /// Returns the time at which the first waiting frame is released without further frames, in ns.
    pub(super) fn due(&self) -> Option<Ns> {
        let front = self.held.front().filter(|_| self.undecided.is_none())?;
        Some(front.half.at.t_ns? + UNANSWERED_NS)
    }

    /// Returns true if the newest waiting frame is the last segment of a block transfer.
    pub(super) fn holds_last(&self) -> bool {
        let newest = self.held.back().filter(|held| !matches!(held.half.command, Command::Abort(..)));
        newest.is_some_and(|held| held.half.bytes[0] & 0x80 != 0)
    }

    /// Returns true if frames of the server wait for a late client frame.
    pub(super) fn is_waiting(&self) -> bool {
        !self.held.is_empty()
    }

    /// Returns true if a frame of the server was on its way when the client aborted.
    pub(super) fn is_in_flight(&mut self, half: &Half) -> bool {
        self.under_way.as_mut().is_some_and(|it| it.side == Side::Server && it.continues(half))
    }
}

impl SdoChannel {
    /// Settles the waiting frames by a new one; returns that with its reading.
    pub(super) fn order_before(&mut self, side: Side, half: Half, cx: &mut Context<'_>) -> Half {
        if side == Side::Client {
            self.history.released = None;
        }
        self.sequence.lag_ns = cx.evidence.recording.lag_ns();
        if !self.sequence.held.is_empty() {
            self.decide(Some((side, &half)), cx);
            self.release_expired(cx);
        }
        self.leave_midway(side, &half, cx);
        self.decoded(side, half)
    }

    /// Takes a frame of the client.
    pub(super) fn order_client(&mut self, half: Half, cx: &mut Context<'_>) {
        while let Some(front) = self.sequence.held.front()
            && !self.may_precede(&half, front)
        {
            self.release(cx);
        }
        self.end_unasked(cx);
        let ends = matches!(half.command, Command::EndBlock { .. });
        let half = if ends { half } else { self.decoded(Side::Client, half) };
        self.step.command = half.command;
        if let Some(front) = self.sequence.held.front()
            && self.fits_next_as_well(&half, front)
        {
            self.step.answered_by = Some(Box::new(front.half.at));
            self.sequence.undecided = Some(half);
            return;
        }
        self.client(half, cx);
        self.follow(cx);
    }

    /// Takes a frame of the server.
    pub(super) fn order_server(&mut self, half: Half, fresh: bool, cx: &mut Context<'_>) {
        let answers = self.pending().is_some_and(|pending| wire::fits(&pending.command, &half.command));
        if answers {
            self.release_all(cx);
        } else if self.sequence.held.len() == MOST_HELD {
            self.release(cx);
        }
        if !self.sequence.held.is_empty() || !self.is_due(&half) {
            if self.pending().is_some_and(|pending| self.sequence.may_be_answered(&pending)) {
                self.leave_answered(cx);
            }
            if let Command::Abort(object, code) = half.command {
                let what = Sdo017::Abort { abort: AbortCode::Sdo(code), by: Side::Server };
                if self.is_about_other(&half.command) {
                    self.verdicts.about = Some(object);
                    let found = self.finding(what.into(), half.at, cx);
                    found.into_iter().for_each(|finding| self.report(finding, cx));
                } else {
                    self.find(what, half.at, cx);
                }
            }
            self.hold(half, fresh);
            return;
        }
        // Before the frame completes the transfer, so that the finding belongs to it.
        self.judge_frame(&half, cx);
        self.server(half, cx);
    }

    /// Takes the waiting frames unchanged at the end or an interruption of the capture.
    pub(super) fn order_rest(&mut self, cx: &mut Context<'_>) {
        self.decide(None, cx);
        while let Some(held) = self.sequence.held.front() {
            // The frame it waits for may be beyond the edge, unless there was time enough.
            if within(held.half.at, cx.at, UNANSWERED_NS) && !self.is_flooded() {
                let Some(held) = self.sequence.held.pop_front() else { return };
                if self.pending().is_some_and(|pending| strict_initiate(&pending)) {
                    self.respond(held.half, cx);
                }
            } else {
                self.release(cx);
            }
        }
        self.end_unasked(cx);
    }

    /// Returns a frame with its reading in the present state.
    pub(super) fn decoded(&self, side: Side, half: Half) -> Half {
        let reading = half.reading.filter(|_| self.hypotheses.are_open() && matches!(self.phase, Phase::Idle));
        let command = reading.unwrap_or_else(|| self.decode(side, half.bytes, half.len));
        // The response to a request at the start of the capture may precede it, followed by data.
        let data = matches!(half.reading, Some(Command::BlockSegment { .. })) && side == Side::Server;
        let edge = |request: &Half| self.is_edge(request) && !wire::may_answer(&request.command, &command);
        let unknown = data && matches!(&self.phase, Phase::Initiated(request) if edge(request));
        Half { command: if unknown { Command::Undetermined(half.bytes) } else { command }, ..half }
    }

    /// Returns true if a frame names another object than the running transfer.
    fn is_about_other(&self, command: &Command) -> bool {
        let runs = self.transfer.as_ref().and_then(|transfer| transfer.mux);
        let named = if let Command::Abort(object, _) = command { Some(*object) } else { command.mux() };
        runs.is_some() && named.is_some() && named != runs
    }

    /// Returns true if the current frame waits and does not belong to the running transfer.
    pub(super) fn waits_for_other(&self, half: &Half) -> bool {
        let held = self.sequence.held.back().map(|held| held.half.at.no);
        let undecided = self.sequence.undecided.map(|request| request.at.no);
        [held, undecided].contains(&Some(half.at.no)) && self.is_about_other(&half.command)
    }

    /// Makes a frame wait; its line shows its meaning if its request comes.
    fn hold(&mut self, half: Half, fresh: bool) {
        let before = self.sequence.held.len() as u32;
        self.step.ordinal = match (&self.phase, half.command) {
            (Phase::Block(block, _), Command::BlockSegment { .. }) => {
                let acknowledged = self.transfer.as_ref().map_or(0, |transfer| transfer.data.segments);
                block.ordinal(acknowledged).saturating_add(before)
            }
            _ => self.segment_ordinal(&half.command),
        };
        let half = match (&self.phase, half.command) {
            // In a transfer joined midway it may answer a late request.
            (Phase::Block(block, _), Command::BlockSegment { .. }) if !block.owes_ack() => {
                self.step.place = Place::Uncaptured;
                Half { command: wire::decode(Side::Server, half.bytes), ..half }
            }
            _ => half,
        };
        if fresh {
            self.step.place = Place::Uncaptured;
        }
        // If no frame can precede it, an answer without request begins the proof like a request.
        self.proof.begun |= self.hypotheses.is_whole() && is_strict_answer(&half);
        self.sequence.held.push_back(Held { half, first: fresh || !self.proof.begun, age: 0 });
    }

    /// Passes on waiting frames that are expected now.
    fn follow(&mut self, cx: &mut Context<'_>) {
        while let Some(held) = self.sequence.held.front().copied() {
            let half = self.decoded(Side::Server, held.half);
            if !self.is_due(&half) {
                return;
            }
            self.sequence.held.pop_front();
            let step = self.step.clone();
            let answers = self.pending().is_some();
            if let Some(transfer) = &mut self.transfer {
                transfer.outcome.reordered = true;
            }
            self.step.place = Place::Due;
            self.judge_frame(&half, cx);
            self.server(half, cx);
            let result = self.step.result.take();
            self.step = step;
            self.step.result = result.or(self.step.result.take());
            if answers {
                self.step.answered_by.get_or_insert_with(|| Box::new(held.half.at));
            }
        }
    }

    /// Passes on the first waiting frame: the capture lacks the client's frame before it.
    pub(super) fn release(&mut self, cx: &mut Context<'_>) {
        let Some(held) = self.sequence.held.pop_front() else { return };
        self.aside(|channel| {
            channel.leave_midway(Side::Server, &held.half, cx);
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

    /// Runs an action that does not concern the current frame.
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

    /// Returns true if the first waiting frame may follow this one of the client.
    fn may_precede(&self, half: &Half, front: &Held) -> bool {
        let half = self.decoded(Side::Client, *half);
        let answer = match half.command.is_initiate() {
            // A request ends the block transfer, so its answer is no segment.
            true => wire::decode_frame(Side::Server, front.half.bytes, front.half.len),
            false => self.decoded(Side::Server, front.half).command,
        };
        if let (Phase::Block(block, _), false) = (&self.phase, half.command.is_initiate()) {
            return match (half.command, answer) {
                (Command::BlockSegment { seqno, .. }, Command::BlockAck { .. }) => block.is_next(seqno),
                (Command::EndBlock { .. }, Command::BlockEnded) | (Command::StartBlockUpload, _) => true,
                (Command::BlockAck { ackseq, .. }, _) if block.may_owe(ackseq) => true,
                (Command::BlockAck { ackseq, .. }, _) => {
                    let own = block.owed_ack() == Some(ackseq) || !self.holds_sub_block(ackseq);
                    block.asks_again(ackseq, &front.half.bytes[1..]) || block.owes_ack() && own
                }
                (Command::BlockEnded, _) => block.end.is_some(),
                _ => false,
            };
        }
        let refused = matches!(answer, Command::Abort(object, _) if half.command.mux() == Some(object));
        refused || wire::fits(&half.command, &answer)
    }

    /// Returns true if the waiting frames are a whole sub-block of this number of segments, with the last one marked.
    fn holds_sub_block(&self, segments: u8) -> bool {
        let mut held = self.sequence.held.iter().filter_map(|held| match held.half.command {
            Command::BlockSegment { seqno, last, .. } => Some((seqno, last)),
            _ => None,
        });
        held.any(|(seqno, last)| last && seqno == segments)
    }

    /// Returns true if a frame of the server is expected, or a fault in any case. Otherwise it may precede the client's
    /// frame that it answers.
    pub(super) fn is_due(&self, half: &Half) -> bool {
        let in_flight = |mut it: UnderWay| it.side == Side::Server && it.continues(half);
        if half.command.is_unreadable() || self.sequence.under_way.is_some_and(in_flight) {
            return true;
        }
        let pending = self.pending();
        if let Command::Abort(object, _) = half.command {
            // At the start of the capture it may answer a request listed after it.
            let ends = match pending {
                Some(pending) if self.is_edge(&pending) => pending.command.mux() == Some(object),
                _ => self.transfer.as_ref().is_some_and(|transfer| transfer.mux.is_some()),
            };
            return ends || self.history.given_up.is_some() || self.history.stray.is_some();
        }
        if let Phase::Block(block, _) = &self.phase
            && let Some(due) = self.is_due_in_block(block, half)
        {
            return due;
        }
        let joins = self.hypotheses.are_open()
            && matches!(half.command, Command::BlockAck { .. } | Command::BlockSegment { .. });
        if joins || self.is_late(half) {
            return true;
        }
        let Some(pending) = pending else {
            return self.history.stray.is_some_and(|stray| wire::kind_fits(&stray.command, &half.command));
        };
        let misfit = wire::kind_fits(&pending.command, &half.command)
            && !self.is_edge(&pending)
            && !self.sequence.may_be_answered(&pending);
        let block = self.is_edge(&pending)
            && pending.command.is_block_initiate()
            && matches!(half.command, Command::BlockAck { .. });
        misfit || block || wire::fits(&pending.command, &half.command)
    }

    /// Takes a server's frame without the client's frame before it, in the capture or on the bus. `first`: that may
    /// precede the capture.
    fn unrequested(&mut self, half: &Half, first: bool, cx: &mut Context<'_>) {
        let in_turn = self.pending().is_some() || matches!(half.command, Command::Abort(..));
        if in_turn || matches!(self.phase, Phase::Block(..)) {
            self.server(*half, cx);
            return;
        }
        self.history.heard = Some(*half);
        self.without_request(half, first, cx);
    }
}

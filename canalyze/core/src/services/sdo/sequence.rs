//! The order of a channel's frames on the bus, where the capture lists the client's late.
//!
//! A host lists the frames that it sends itself later than those that it receives: a response may stand before its
//! request, several exchanges deep. Each side's own frames stay in order. So a frame of the server that answers nothing
//! yet waits here for the client's frames, as long as these may still come, and `machine` takes all frames as they were
//! on the bus. A capture in causal order is never held up.
//!
//! It must not judge: a frame whose turn never comes is handed to the machine as it is.

use std::collections::VecDeque;

use super::channel::{Channel, UNANSWERED_NS, strict_initiate};
use super::phase::{Half, Phase};
use super::transfer::{Direction, Status};
use super::wire::{self, Command, Side};
use crate::context::Context;
use crate::event::{Note, Place};
use crate::evidence::recording::USUAL_ECHO_NS;
use crate::finding::Code;
use crate::frame::FrameRef;
use crate::rules::sdo::Sdo017;

/// Without stamps, as many later frames of the channel may stand before the request.
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

/// After an abort: frames of the other side may still be under way.
#[derive(Clone, Copy, Debug)]
pub(super) struct UnderWay {
    pub(super) side: Side,
    /// The abort.
    pub(super) at: FrameRef,
    /// The next sequence number of a block transfer's segments; 0 outside block transfers.
    pub(super) seqno: u8,
    /// The number in the acknowledgement that the client owed: it may be slow.
    pub(super) owed: Option<u8>,
    /// No request was pending when the server aborted: the one that it refuses may be late.
    pub(super) unasked: bool,
}

impl UnderWay {
    /// Whether a frame is the next block segment; the one behind it is the next then.
    fn continues(&mut self, half: &Half) -> bool {
        let [command, ..] = half.bytes;
        let continues = self.seqno != 0 && command & 0x7F == self.seqno;
        if continues {
            self.seqno = (self.seqno + 1) & 0x7F;
        }
        continues
    }

    /// Whether a client frame is the acknowledgement that was owed, still in time.
    fn is_owed(&mut self, half: &Half) -> bool {
        let Command::BlockAck { ackseq, .. } = half.command else { return false };
        self.owed.take() == Some(ackseq) && within(self.at, half.at, UNANSWERED_NS)
    }
}

/// Frames whose turn has not come, and what is known of the order of the others.
#[derive(Debug, Default)]
pub(super) struct Sequence {
    held: VecDeque<Held>,
    /// A request that fits the first of them, and may as well be the next: the frame behind it decides.
    undecided: Option<Half>,
    /// How late the recording host lists its own frames at most, in ns.
    lag_ns: i64,
    pub(super) under_way: Option<UnderWay>,
    /// The last response or refusal, where its request was captured before it.
    pub(super) answered: Option<Half>,
    /// It is known which responses belong to which requests: where a capture begins with requests for one object that
    /// are late, each may stand before the response to the next.
    certain: bool,
}

impl Sequence {
    /// Whether two frames are close enough for the second to be a late echo; without stamps, always.
    pub(super) fn within_lag(&self, from: FrameRef, to: FrameRef) -> bool {
        within(from, to, self.lag_ns)
    }

    /// A client frame shows which request the last response belongs to, where it follows later than an echo, or is for
    /// another object.
    pub(super) fn ascertain(&mut self, next: &Half) {
        let own =
            |answer: Half| !self.within_lag(answer.at, next.at) || !wire::may_answer(&next.command, &answer.command);
        self.certain |= self.answered.is_some_and(own);
    }

    /// Whether the response before this request may be its own, captured before it.
    pub(super) fn may_be_answered(&self, request: &Half) -> bool {
        !self.certain
            && request.command.is_initiate()
            && self.answered.is_some_and(|answer| wire::may_answer(&request.command, &answer.command))
    }

    /// Whether one of the frames that wait can be the answer to a request.
    pub(super) fn holds_answer(&self, request: &Command) -> bool {
        self.held.iter().any(|held| wire::may_answer(request, &held.half.command))
    }

    /// Whether one of the frames that wait begins a segmented upload.
    pub(super) fn holds_upload(&self) -> bool {
        let begins = |held: &Held| matches!(held.half.command, Command::UploadInitiated(_, i) if !i.expedited);
        self.held.iter().any(begins)
    }

    /// When the first frame that waits has waited long enough though none of the channel comes, in ns.
    pub(super) fn due(&self) -> Option<i64> {
        let front = self.held.front().filter(|_| self.undecided.is_none())?;
        Some(front.half.at.t_ns?.saturating_add(UNANSWERED_NS))
    }

    /// Whether the newest of the frames that wait is the last segment of a block transfer.
    pub(super) fn holds_last(&self) -> bool {
        let newest = self.held.back().filter(|held| !matches!(held.half.command, Command::Abort(..)));
        newest.is_some_and(|held| held.half.bytes[0] & 0x80 != 0)
    }

    /// Whether frames of the server wait for a client frame that is listed late.
    pub(super) fn is_waiting(&self) -> bool {
        !self.held.is_empty()
    }

    /// Whether a frame of the server was on its way when the client aborted.
    pub(super) fn is_in_flight(&mut self, half: &Half) -> bool {
        self.under_way.as_mut().is_some_and(|it| it.side == Side::Server && it.continues(half))
    }
}

impl Channel {
    /// A frame has come: what it shows about those that wait. Returns the frame as it is read after that.
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
                let what = Sdo017::Abort { abort: code, by: Side::Server };
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
        // Before the transfer completes with this frame: the finding is the transfer's.
        self.judge_frame(&half, cx);
        self.server(half, cx);
    }

    /// The capture is over, or interrupted: what waits is taken as it stands.
    pub(super) fn order_rest(&mut self, cx: &mut Context<'_>) {
        self.decide(None, cx);
        while let Some(held) = self.sequence.held.front() {
            // The frame it waits for may lie beyond the edge, unless there was time enough.
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

    /// The frame as it is read where the transfer stands now.
    pub(super) fn decoded(&self, side: Side, half: Half) -> Half {
        let reading = half.reading.filter(|_| self.hypotheses.are_open() && matches!(self.phase, Phase::Idle));
        let command = reading.unwrap_or_else(|| self.decode(side, half.bytes, half.len));
        // Where the capture begins with a request, its response may lie before it, and data follow.
        let data = matches!(half.reading, Some(Command::BlockSegment { .. })) && side == Side::Server;
        let edge = |request: &Half| self.is_edge(request) && !wire::may_answer(&request.command, &command);
        let unknown = data && matches!(&self.phase, Phase::Initiated(request) if edge(request));
        Half { command: if unknown { Command::Undetermined(half.bytes) } else { command }, ..half }
    }

    /// Whether a frame names another object than that of the transfer that runs.
    fn is_about_other(&self, command: &Command) -> bool {
        let runs = self.transfer.as_ref().and_then(|transfer| transfer.mux);
        let named = if let Command::Abort(object, _) = command { Some(*object) } else { command.mux() };
        runs.is_some() && named.is_some() && named != runs
    }

    /// Whether the frame at hand waits, and is no part of the transfer that runs.
    pub(super) fn waits_for_other(&self, half: &Half) -> bool {
        let held = self.sequence.held.back().map(|held| held.half.at.no);
        let undecided = self.sequence.undecided.map(|request| request.at.no);
        [held, undecided].contains(&Some(half.at.no)) && self.is_about_other(&half.command)
    }

    /// The line of a frame that waits: what it is if its request comes.
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
            // In a transfer met in its midst it may be the answer to a late request.
            (Phase::Block(block, _), Command::BlockSegment { .. }) if !block.owes_ack() => {
                self.step.place = Place::Uncaptured;
                Half { command: wire::decode(Side::Server, half.bytes), ..half }
            }
            _ => half,
        };
        if fresh {
            self.step.place = Place::Uncaptured;
        }
        // Where nothing of the channel can lie before it, an answer without a request counts as the first request does.
        self.proof.begun |= self.hypotheses.is_whole() && is_strict_answer(&half);
        self.sequence.held.push_back(Held { half, first: fresh || !self.proof.begun, age: 0 });
    }

    /// Hands on what waited and is expected now.
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

    /// Hands on the first of the frames that wait: the client's frame before it is not in the capture.
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

    /// Whether the frames that wait are a whole sub-block of this number of segments, the last of them marked.
    fn holds_sub_block(&self, segments: u8) -> bool {
        let mut held = self.sequence.held.iter().filter_map(|held| match held.half.command {
            Command::BlockSegment { seqno, last, .. } => Some((seqno, last)),
            _ => None,
        });
        held.any(|(seqno, last)| last && seqno == segments)
    }

    /// Whether a request that fits the first frame that waits may as well be answered by the next: that one is the
    /// first of the channel, or the client reads one object again and again.
    fn fits_next_as_well(&self, half: &Half, front: &Held) -> bool {
        if !half.command.is_initiate() || matches!(self.phase, Phase::Block(..)) {
            return false;
        }
        let stamped = front.half.at.t_ns.is_some() && half.at.t_ns.is_some();
        let again = self.history.last_request == Some(half.command);
        front.first || (stamped && again && !within(front.half.at, half.at, USUAL_ECHO_NS))
    }

    /// The frame behind an undecided request shows which response is its own: a second one that fits, soon after it and
    /// long after the first, or where the first may belong to a request before the capture.
    fn decide(&mut self, next: Option<(Side, &Half)>, cx: &mut Context<'_>) {
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

    /// Whether a frame of the server is expected, or a fault whatever the client sends: one that is not may have come
    /// before the client's frame that it answers.
    pub(super) fn is_due(&self, half: &Half) -> bool {
        let in_flight = |mut it: UnderWay| it.side == Side::Server && it.continues(half);
        if half.command.is_unreadable() || self.sequence.under_way.is_some_and(in_flight) {
            return true;
        }
        let pending = self.pending();
        if let Command::Abort(object, _) = half.command {
            // Where the capture begins, it may be the answer to a request that is listed behind it.
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

    /// What a client frame is that was on its way when the server aborted.
    pub(super) fn is_under_way(&mut self, half: &Half) -> Option<Command> {
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
    pub(super) fn reconsider(&mut self, half: Half, cx: &mut Context<'_>) -> Option<Half> {
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
    pub(super) fn settle_pending(&mut self, pending: &Half, half: &Half, cx: &mut Context<'_>) -> bool {
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
    fn leave_answered(&mut self, cx: &mut Context<'_>) {
        self.sequence.certain = true;
        self.complete_before(Status::Incomplete, cx);
    }

    /// Whether a response that does not fit the pending request belongs to another one, or to a transfer that began
    /// before the capture.
    pub(super) fn belongs_elsewhere(&mut self, pending: &Half, half: &Half, cx: &mut Context<'_>) -> bool {
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

    /// The client's frame before a frame of the server is not in the capture, or not on the bus.
    /// `first`: it may be before the capture.
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

/// Whether a frame can only be meant as the response to an initiate request.
pub(super) fn is_strict_answer(half: &Half) -> bool {
    !half.command.is_initiate()
        && half.command.mux().is_some_and(|mux| mux.index >= 0x1000)
        && !half.command.has_reserved_bits(half.bytes)
        && half.len == 8
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

/// Whether a frame follows another by no more than a time in ns; without stamps, always.
pub(super) fn within(from: FrameRef, to: FrameRef, limit_ns: i64) -> bool {
    match (from.t_ns, to.t_ns) {
        (Some(from), Some(to)) => to.saturating_sub(from) <= limit_ns,
        _ => true,
    }
}

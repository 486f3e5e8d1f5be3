//! Requests and responses, in the order in which they were on the bus (`sequence`): which frame is due, which answers
//! which, and what becomes of a request without an answer.
//!
//! The exchange is stop-and-wait: at most one request is pending. Aborts are never pending: they end the transfer,
//! whoever sends them. What a pair does to the transfer stands in `exchange`.

use super::block::MOST;
use super::channel::{Channel, Half, Outside, Phase, UNANSWERED_NS, strict_initiate};
use super::sequence::{Sequence, within};
use super::transfer::{Direction, Mode, Status, Transfer};
use super::wire::{self, Command, Mux, Side};
use crate::context::Context;
use crate::event::Place;
use crate::finding::Code;
use crate::frame::FrameRef;
use crate::rules::sdo::{Sdo002, Sdo007, Sdo012};

/// A client that goes on later than this, in ns, has given up what it waited for.
pub(super) const GIVEN_UP_NS: i64 = 20_000_000;

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
    /// Whether a client frame is the acknowledgement that was owed, still in time.
    pub(super) fn is_owed(&mut self, half: &Half) -> bool {
        let Command::BlockAck { ackseq, .. } = half.command else { return false };
        self.owed.take() == Some(ackseq) && within(self.at, half.at, UNANSWERED_NS)
    }
}

/// Requests and responses of a channel.
#[derive(Debug, Default)]
pub(super) struct Pairing {
    /// The request that awaits its response.
    pub(super) pending: Option<Half>,
    /// The last request that was aborted by its client or overtaken by the next one.
    pub(super) given_up: Option<Half>,
    /// The server's newest frame.
    pub(super) heard: Option<Half>,
    /// The response that was released last, at this frame.
    pub(super) released: Option<Half>,
    /// A client frame outside any transfer: what answers it is no news.
    pub(super) stray: Option<Half>,
    pub(super) under_way: Option<UnderWay>,
    /// The pending request may be what the server's abort before it answered.
    pub(super) abort_may_answer: bool,
    /// The object and code of the server's last abort.
    pub(super) last_abort: Option<(Mux, u32)>,
    /// The last request that was answered, and its response.
    pub(super) last_request: Option<Command>,
    pub(super) last_response: Option<[u8; 8]>,
    /// Number of the channel's first frame (or of the first since frames were lost).
    pub(super) first: Option<u64>,
    /// The last response or refusal, where its request was captured before it.
    pub(super) answered: Option<Half>,
    /// It is known which responses belong to which requests: where a capture begins with requests of one object that
    /// are late, each may stand before the answer to the next.
    pub(super) certain: bool,
    /// The longest that the server has taken for an answer, in ns.
    pub(super) slowest_ns: i64,
}

impl Pairing {
    /// A transfer was initiated: a segment of the one before can no longer come.
    pub(super) fn initiated(&mut self) {
        self.given_up = self.given_up.filter(|request| request.command.is_initiate());
    }

    /// A client frame has come: it shows whose the last answer was, where it follows later than an echo, or is for
    /// another object.
    pub(super) fn ascertain(&mut self, next: &Half, order: &Sequence) {
        let own = |answer: Half| !order.within_lag(answer.at, next.at) || !may_answer(&next.command, &answer.command);
        self.certain |= self.answered.is_some_and(own);
    }

    /// Whether the answer before this request may be its own, captured before it.
    pub(super) fn may_be_answered(&self, request: &Half) -> bool {
        !self.certain
            && request.command.is_initiate()
            && self.answered.is_some_and(|answer| may_answer(&request.command, &answer.command))
    }
}

/// Whether a response, or an abort for the same object, can be the answer to a request.
pub(super) fn may_answer(request: &Command, answer: &Command) -> bool {
    match answer {
        Command::Abort(object, _) => request.mux() == Some(*object),
        _ => wire::fits(request, answer),
    }
}

impl Channel {
    /// A frame by the client, in its turn. The order of the questions is the rule: does it abort, is it still under way,
    /// does it belong to sub-blocks, does it overtake a request; else it is a request.
    pub(super) fn client(&mut self, half: Half, cx: &mut Context<'_>) {
        self.pairing.first.get_or_insert(half.at.no);
        self.pairing.ascertain(&half, &self.sequence);
        if let Command::Abort(mux, code) = half.command {
            self.client_abort(&half, mux, code, cx);
            return;
        }
        if self.is_under_way(&half) {
            self.step.place = Place::InFlight;
            return;
        }
        if matches!(self.phase, Phase::Block(_)) && self.block_client(&half, cx) {
            return;
        }
        if self.pairing.pending.is_some() && self.supersede(&half, cx) {
            return;
        }
        if let Some(released) = self.pairing.released.take()
            && self.begin_from_response(&released, &half, cx)
            && matches!(self.phase, Phase::Block(_))
        {
            let half = Half { command: self.decode(Side::Client, half.bytes, half.len), ..half };
            self.step.command = half.command;
            self.block_client(&half, cx);
            return;
        }
        if self.has_begun(&half)
            && let Some(answer) = self.pairing.answered.take()
        {
            self.leave_answered(cx);
            self.step.answered_by = Some(answer.at);
            self.request(half, cx);
            self.server(answer, cx);
            return;
        }
        self.request(half, cx);
    }

    /// Whether a client frame was on its way when the server aborted.
    fn is_under_way(&mut self, half: &Half) -> bool {
        let idle = matches!(self.phase, Phase::Idle);
        let Some(under_way) = &mut self.pairing.under_way else { return false };
        let soon = self.sequence.within_lag(under_way.at, half.at);
        if under_way.side != Side::Client || half.command.is_initiate() {
            return false;
        }
        let [command, ..] = half.bytes;
        let continues = under_way.seqno != 0 && command & 0x7F == under_way.seqno;
        if continues {
            under_way.seqno = (under_way.seqno + 1) & 0x7F;
        }
        let refused = idle && std::mem::take(&mut under_way.unasked) && soon;
        continues || under_way.is_owed(half) || refused
    }

    /// Whether the segments that are about to come may be those of this request, captured after the answer to it, and not
    /// those of the request before, whose answer is not in the capture.
    fn has_begun(&self, half: &Half) -> bool {
        matches!(self.phase, Phase::Segments { .. })
            && self.pairing.pending.is_none()
            && self.pairing.may_be_answered(half)
            && self.transfer.as_ref().is_some_and(|transfer| transfer.segments == 0)
    }

    /// A request with nothing before it that could answer it.
    fn request(&mut self, half: Half, cx: &mut Context<'_>) {
        if half.command.is_initiate() {
            if !self.leave_open_transfer(&half, cx) {
                self.verdicts.fault = None;
            }
            self.begin(&half, cx);
            let under_way = self.pairing.under_way.take();
            self.pairing.abort_may_answer =
                under_way.is_some_and(|it| it.unasked && self.sequence.within_lag(it.at, half.at));
            self.pairing.stray = None;
            self.pairing.pending = Some(half);
            return;
        }
        if !self.can_request(&half) {
            self.stray(&half, cx);
            return;
        }
        self.step.ordinal = self.segment_ordinal(&half.command);
        self.pairing.pending = Some(half);
    }

    /// Whether the open transfer is one in which a client sends this.
    pub(super) fn can_request(&self, half: &Half) -> bool {
        if half.command.is_initiate() {
            return true;
        }
        let direction = self.transfer.as_ref().map(|transfer| transfer.direction);
        match (&self.phase, &half.command) {
            (Phase::Segments { .. }, Command::SegmentRequest { .. }) => direction == Some(Direction::Upload),
            (Phase::Segments { .. }, Command::Segment(_)) => direction == Some(Direction::Download),
            (Phase::Block(block), Command::EndBlock { .. }) => {
                direction == Some(Direction::Download) && block.may_end()
            }
            _ => false,
        }
    }

    /// A frame that is not due here.
    pub(super) fn violation_outside(&mut self, half: &Half, cx: &mut Context<'_>) {
        self.step.place = Place::Outside;
        if half.command.is_unreadable() || self.outside == Outside::Said {
            return;
        }
        self.find(Sdo007::Outside, half.at, cx);
        if self.transfer.is_none() {
            self.outside = Outside::Said;
        }
    }

    /// Whether a frame of the server is due, or a fault whatever the client sends: one that is not may have come before
    /// the client's frame that it answers.
    pub(super) fn is_due(&self, half: &Half) -> bool {
        let unreadable = half.command.is_unreadable();
        let in_flight = |it: UnderWay| it.side == Side::Server && it.seqno != 0 && half.bytes[0] & 0x7F == it.seqno;
        if unreadable || self.pairing.under_way.is_some_and(in_flight) {
            return true;
        }
        if let Command::Abort(..) = half.command {
            let Pairing { pending, given_up, stray, .. } = &self.pairing;
            let other = |it: Half| self.pairing.may_be_answered(&it) && !may_answer(&it.command, &half.command);
            let ends = pending.is_some() || given_up.is_some() || stray.is_some() || self.transfer.is_some();
            return ends && !pending.is_some_and(other);
        }
        if let Phase::Block(block) = &self.phase
            && let Some(due) = self.is_due_in_block(block, half)
        {
            return due;
        }
        let midway = self.outside == Outside::Uncaptured && matches!(half.command, Command::BlockAck { .. });
        if midway || self.is_late(half) {
            return true;
        }
        let Some(pending) = self.pairing.pending else {
            return self.pairing.stray.is_some_and(|stray| wire::kind_fits(&stray.command, &half.command));
        };
        let again = matches!(half.command, Command::Segment(_)) && self.pairing.last_response == Some(half.bytes);
        wire::fits(&pending.command, &half.command)
            || again
            || (wire::kind_fits(&pending.command, &half.command)
                && !self.is_edge(&pending)
                && !self.pairing.abort_may_answer
                && !self.pairing.may_be_answered(&pending))
            || (is_block_initiate(&pending)
                && self.is_edge(&pending)
                && matches!(half.command, Command::BlockAck { .. }))
    }

    /// A frame by the server, in its turn: does it abort, is it still under way, does it belong to sub-blocks; else it
    /// answers the pending request.
    pub(super) fn server(&mut self, half: Half, cx: &mut Context<'_>) {
        self.pairing.heard = Some(half);
        if let Command::Abort(mux, code) = half.command {
            self.server_abort(&half, mux, code, cx);
            return;
        }
        if let Some(under_way) = &mut self.pairing.under_way
            && under_way.side == Side::Server
            && under_way.seqno != 0
            && half.bytes[0] & 0x7F == under_way.seqno
        {
            under_way.seqno = (under_way.seqno + 1) & 0x7F;
            self.step.place = Place::InFlight;
            return;
        }
        if matches!(self.phase, Phase::Block(_)) && self.block_server(&half, cx) {
            return;
        }
        match self.pairing.pending {
            Some(pending) => self.respond(pending, half, cx),
            None => self.respond_unasked(half, cx),
        }
    }

    /// A response while a request is pending.
    fn respond(&mut self, pending: Half, half: Half, cx: &mut Context<'_>) {
        // A server may switch the protocol where the client allows it; where not, an ordinary answer to a request
        // that was given up is just that.
        let unasked_switch = matches!(
            (pending.command, half.command),
            (Command::InitiateBlockUpload { threshold: 0, .. }, Command::UploadInitiated(..))
        );
        if unasked_switch && self.is_late(&half) {
            self.late(&half, cx);
            return;
        }
        if wire::fits(&pending.command, &half.command) {
            self.pairing.abort_may_answer = false;
            self.step.ordinal = self.segment_ordinal(&half.command);
            self.answer(pending, half, cx);
            return;
        }
        let midway = self.outside == Outside::Uncaptured || (self.is_edge(&pending) && is_block_initiate(&pending));
        if midway && matches!(half.command, Command::BlockAck { .. }) {
            self.forget_beginning();
            self.step.place = Place::Uncaptured;
            self.join_block(&half, Direction::Download, cx);
            return;
        }
        if self.is_late(&half) {
            self.late(&half, cx);
            return;
        }
        if self.pairing.abort_may_answer {
            self.answered_by_abort(cx);
            self.respond_unasked(half, cx);
            return;
        }
        if self.pairing.may_be_answered(&pending) {
            self.leave_answered(cx);
            self.respond_unasked(half, cx);
            return;
        }
        self.respond_otherwise(pending, half, cx);
    }

    /// A response that is not the one the pending request asks for, nor one to another request.
    fn respond_otherwise(&mut self, pending: Half, half: Half, cx: &mut Context<'_>) {
        if matches!(half.command, Command::Segment(_)) && self.pairing.last_response == Some(half.bytes) {
            self.step.place = Place::Outside;
            self.find(Sdo002::Duplicate, half.at, cx);
            return;
        }
        if self.is_edge(&pending) && !(strict_initiate(&pending) && wire::kind_fits(&pending.command, &half.command)) {
            self.step.place = Place::Uncaptured;
            return;
        }
        if wire::kind_fits(&pending.command, &half.command) {
            self.proof.begun |= self.is_edge(&pending);
            self.step.ordinal = self.segment_ordinal(&half.command);
            self.answer(pending, half, cx);
            return;
        }
        if self.outside == Outside::Uncaptured {
            self.step.place = Place::Uncaptured;
            return;
        }
        self.step.place = Place::Outside;
        if !half.command.is_unreadable() {
            self.find(Sdo002::NoRequest, half.at, cx);
        }
    }

    /// A response while no request is pending, which waited for its request if one could still come.
    fn respond_unasked(&mut self, half: Half, cx: &mut Context<'_>) {
        if half.command.is_unreadable() {
            self.step.place = Place::Outside;
            return;
        }
        if let Some(stray) = self.pairing.stray.take()
            && wire::kind_fits(&stray.command, &half.command)
        {
            self.step.place = Place::Outside;
            return;
        }
        if self.is_late(&half) {
            self.late(&half, cx);
            return;
        }
        self.step.ordinal = self.segment_ordinal(&half.command);
        if self.outside == Outside::Uncaptured && matches!(half.command, Command::BlockAck { .. }) {
            self.step.place = Place::Uncaptured;
            self.join_block(&half, Direction::Download, cx);
            return;
        }
        self.without_request(&half, !self.proof.begun, cx);
    }

    /// The client's frame before a frame of the server is not in the capture, or not on the bus.
    /// `first`: it may be before the capture.
    pub(super) fn unrequested(&mut self, half: &Half, first: bool, cx: &mut Context<'_>) {
        let in_turn = self.pairing.pending.is_some() || matches!(half.command, Command::Abort(..));
        if in_turn || matches!(self.phase, Phase::Block(_)) {
            self.server(*half, cx);
            return;
        }
        self.pairing.heard = Some(*half);
        self.without_request(half, first, cx);
    }

    fn without_request(&mut self, half: &Half, first: bool, cx: &mut Context<'_>) {
        if !first {
            let duplicate = self.pairing.last_response == Some(half.bytes);
            self.find(if duplicate { Sdo002::Duplicate } else { Sdo002::NoRequest }, half.at, cx);
        }
        self.continue_without_request(half, cx);
        self.pairing.released = Some(*half);
    }

    /// A response whose request is not in the capture still carries its data.
    fn continue_without_request(&mut self, half: &Half, cx: &mut Context<'_>) {
        let Phase::Segments { toggle: due } = self.phase else { return };
        if self.pairing.pending.is_some() {
            return;
        }
        let upload = self.transfer.as_ref().is_some_and(|transfer| transfer.direction == Direction::Upload);
        match half.command {
            Command::Segment(segment) if upload && segment.toggle == due => {
                self.phase = Phase::Segments { toggle: !due };
                self.aside(|channel| channel.add_segment(*half, segment, cx));
            }
            Command::SegmentResponse { toggle } if !upload && toggle == due => {
                // The server takes it for segmented, so it is.
                self.unmarked = None;
                self.phase = Phase::Segments { toggle: !due };
                if let Some(transfer) = &mut self.transfer {
                    transfer.hole = true;
                }
            }
            _ => {}
        }
    }

    /// A frame that waits where the capture ends: what it answers may lie beyond the edge.
    pub(super) fn at_the_edge(&mut self, half: &Half, cx: &mut Context<'_>) {
        match (&mut self.phase, &mut self.transfer, half.command) {
            (Phase::Block(block), Some(transfer), Command::BlockAck { ackseq, blksize }) => {
                let _: super::block::Acked = block.ack(transfer, half.at, ackseq, blksize);
            }
            (_, _, Command::Abort(..)) => self.server(*half, cx),
            _ => match self.pairing.pending {
                Some(pending) if strict_initiate(&pending) => self.respond(pending, *half, cx),
                Some(_) => {}
                None => self.continue_without_request(half, cx),
            },
        }
    }

    /// The pending request was answered before it was captured, by what was taken for the answer to another.
    pub(super) fn leave_answered(&mut self, cx: &mut Context<'_>) {
        if self.pairing.abort_may_answer {
            self.answered_by_abort(cx);
            return;
        }
        self.pairing.pending = None;
        self.pairing.certain = true;
        let own = std::mem::replace(&mut self.own, false);
        self.complete(Status::Incomplete, cx);
        self.own = own;
    }

    /// A client frame while its last request was not answered. Returns whether the frame needs nothing more.
    fn supersede(&mut self, half: &Half, cx: &mut Context<'_>) -> bool {
        let Some(pending) = self.pairing.pending else { return false };
        let refused = self.pairing.abort_may_answer
            && self.pairing.last_abort.is_some_and(|(object, _)| pending.command.mux() == Some(object));
        if half.command.is_initiate() && !refused && self.pairing.may_be_answered(&pending) {
            self.leave_answered(cx);
            return false;
        }
        if pending.bytes == half.bytes && pending.len == half.len && !self.pairing.abort_may_answer {
            self.step.place = Place::Repeated;
            // Both may still be answered.
            self.pairing.given_up = Some(pending);
            if self.is_sent_again(&pending, half, cx) {
                self.find(Code::Sdo015, pending.at, cx);
            }
            self.step.ordinal = self.segment_ordinal(&half.command);
            self.pairing.pending = Some(*half);
            return true;
        }
        self.pairing.pending = None;
        if self.pairing.abort_may_answer {
            self.pairing.pending = Some(pending);
            self.answered_by_abort(cx);
            return false;
        }
        // Of initiates only those with reserved bytes can be told from data.
        let initiate = strict_initiate(half)
            && !half.command.has_invalid_block_size()
            && !matches!(half.command, Command::InitiateDownload(..));
        if !initiate && self.is_midway_block(&pending, half) {
            self.forget_beginning();
            self.begin_midway_block(half, cx);
            return true;
        }
        let edge = self.is_edge(&pending) || self.outside == Outside::Uncaptured;
        if edge && is_block_initiate(&pending) && !half.command.is_initiate() {
            self.forget_beginning();
            return false;
        }
        if half.command.is_initiate() {
            self.pairing.given_up = (!edge).then_some(pending);
            if matches!(pending.command, Command::EndBlock { .. }) {
                self.find(Sdo012::EndNotConfirmed, pending.at, cx);
                self.end_unconfirmed(pending, cx);
            } else {
                self.unanswered(&pending, edge, cx);
                self.abandon(&pending, edge, cx);
            }
            return false;
        }
        self.go_on_unanswered(&pending, edge, half, cx)
    }

    /// The client goes on as if its last request had been answered: the answer is not in the capture. Returns whether the
    /// frame needs nothing more.
    fn go_on_unanswered(&mut self, pending: &Half, edge: bool, half: &Half, cx: &mut Context<'_>) -> bool {
        match (pending.command, half.command) {
            (Command::InitiateUpload(_), Command::SegmentRequest { .. })
            | (Command::InitiateDownload(..), Command::Segment(_)) => {
                self.unanswered(pending, edge, cx);
                if let Some(transfer) = &mut self.transfer
                    && transfer.mode == Mode::Expedited
                {
                    transfer.mode = Mode::Segmented;
                }
                self.phase = Phase::Segments { toggle: false };
            }
            (Command::InitiateBlockUpload { blksize, .. }, Command::StartBlockUpload | Command::BlockAck { .. }) => {
                self.unanswered(pending, edge, cx);
                self.block_initiated(pending.at, blksize, false, None);
                return self.block_client(half, cx);
            }
            (Command::SegmentRequest { toggle }, Command::SegmentRequest { toggle: next }) if toggle != next => {
                self.unanswered(pending, edge, cx);
                self.phase = Phase::Segments { toggle: next };
                if let Some(transfer) = &mut self.transfer {
                    transfer.hole = true;
                }
            }
            (Command::Segment(sent), Command::Segment(next)) if sent.toggle != next.toggle => {
                self.unanswered(pending, edge, cx);
                self.phase = Phase::Segments { toggle: next.toggle };
                self.add_segment(*pending, sent, cx);
            }
            (Command::InitiateBlockUpload { .. }, Command::SegmentRequest { .. }) => {
                self.unanswered(pending, edge, cx);
                if let Some(transfer) = &mut self.transfer {
                    transfer.mode = Mode::Segmented;
                }
                self.phase = Phase::Segments { toggle: false };
            }
            (Command::InitiateBlockDownload { .. }, _) if half.bytes[0] & 0x7F == 1 => {
                self.unanswered(pending, edge, cx);
                self.block_initiated(pending.at, MOST, false, None);
                let segment = Half { command: wire::block_segment(half.bytes), ..*half };
                self.step.command = segment.command;
                return self.block_client(&segment, cx);
            }
            // Nothing that a client sends after its request: the request still awaits its answer.
            _ => {
                self.pairing.pending = Some(*pending);
                self.violation_outside(half, cx);
                return true;
            }
        }
        false
    }

    /// Whether a request was sent again, and not captured twice, though no answer to the first can be meant by anything that
    /// came.
    fn is_sent_again(&self, before: &Half, half: &Half, cx: &Context<'_>) -> bool {
        let known = self.proof.trusted || self.is_idle_from_start();
        let edge = self.is_edge(before) || self.outside == Outside::Uncaptured;
        // Something else came in the answer's place, or it may be listed before its request.
        let answered = self.is_unanswerable(before)
            || self.pairing.heard.is_some_and(|heard| {
                let ahead = self.sequence.within_lag(heard.at, before.at);
                heard.at.no > before.at.no || (ahead && may_answer(&before.command, &heard.command))
            });
        known && !edge && !answered && cx.evidence.recording.is_sent_again(before.at, half.at)
    }

    fn unanswered(&mut self, pending: &Half, edge: bool, cx: &mut Context<'_>) {
        if !edge {
            self.find(Sdo002::NoResponse, pending.at, cx);
        }
    }

    /// A transfer whose request was not answered, and which the client left.
    fn abandon(&mut self, pending: &Half, edge: bool, cx: &mut Context<'_>) {
        let nameless = !self.is_trusted() && !strict_initiate(pending);
        if nameless {
            self.transfer = None;
            self.phase = Phase::Idle;
            return;
        }
        let own = std::mem::replace(&mut self.own, false);
        self.complete(if edge { Status::Incomplete } else { Status::Failed }, cx);
        self.own = own;
    }

    /// A new initiate request comes: what becomes of a transfer that is still open?
    /// Returns whether it was left in its midst.
    fn leave_open_transfer(&mut self, half: &Half, cx: &mut Context<'_>) -> bool {
        let Some(transfer) = &self.transfer else { return false };
        let (last, newest, uncaptured) = (transfer.last, self.newest(transfer), transfer.mux.is_none());
        if self.is_meant_as_data() && matches!(self.phase, Phase::Segments { .. }) {
            self.recognise_unmarked(cx);
            return false;
        }
        if self.leave_ended_block(cx) {
            return false;
        }
        if self.all_bytes_without_last() {
            self.find(Sdo007::NoLast, last, cx);
        } else if !uncaptured && !matches!(self.phase, Phase::Initiated) {
            let stalled = !within(newest, half.at, GIVEN_UP_NS);
            if stalled {
                self.judge_stalled_block(cx);
            }
            self.find(Code::Sdo008, if stalled { newest } else { half.at }, cx);
        }
        let own = std::mem::replace(&mut self.own, false);
        self.complete(if uncaptured { Status::Incomplete } else { Status::Failed }, cx);
        self.own = own;
        true
    }

    /// The newest frame of a transfer.
    pub(super) fn newest(&self, transfer: &Transfer) -> FrameRef {
        match &self.phase {
            Phase::Block(block) => block.newest_at.filter(|at| at.no > transfer.last.no).unwrap_or(transfer.last),
            _ => transfer.last,
        }
    }

    pub(super) fn segment_ordinal(&self, command: &Command) -> u32 {
        match (&self.phase, command) {
            (Phase::Segments { .. }, Command::Segment(_)) => {
                // Where the beginning, or a part, was not captured, no number would be true.
                let whole = self.transfer.as_ref().filter(|transfer| !transfer.midway && !transfer.hole);
                whole.map_or(0, |transfer| transfer.segments.saturating_add(1))
            }
            _ => 0,
        }
    }
}

/// Whether a frame can only be meant as the answer to an initiate request.
pub(super) fn is_strict_answer(half: &Half) -> bool {
    !half.command.is_initiate()
        && half.command.mux().is_some_and(|mux| mux.index >= 0x1000)
        && !half.command.has_reserved_bits(half.bytes)
        && half.len == 8
}

fn is_block_initiate(half: &Half) -> bool {
    matches!(half.command, Command::InitiateBlockDownload { .. } | Command::InitiateBlockUpload { .. })
}

//! Pairs: which response answers which request, when a capture may show a client's frame one frame late.
//!
//! The exchange is stop-and-wait, so at most one request is pending and at most one response is held. A held
//! response waits for the channel's next frames (at most `HOLD_NS` where there are stamps): its request may be
//! late. A pair found that way is tentative while a second response could answer the same request.
//!
//! Aborts are never pending and never held: they end the transfer, whoever sends them. The request that one refuses
//! may be late as well: the pair is tentative in the same way.
//!
//! This file decides who belongs to whom. What a pair does to the transfer stands in `channel`.

use super::block::MOST;
use super::channel::{Channel, Half, Outside, Phase, UNANSWERED_NS, strict_initiate};
use super::transfer::{Abort, Direction, Mode, Status};
use super::waiting::{Held, Tentative, Unprovoked, within, within_hold};
use super::wire::{self, Command, Side};
use crate::context::Context;
use crate::event::{Note, Place};
use crate::finding::{Code, Facts};
use crate::frame::FrameRef;

impl Channel {
    /// A frame by the client. The order of the questions is the rule: does it abort, is it still under way, does it
    /// belong to sub-blocks, does it overtake a request, does a held response wait for it; else it is a request.
    pub(super) fn client(&mut self, half: Half, cx: &mut Context<'_>) {
        self.pairing.first.get_or_insert(half.at.no);
        self.pairing.ascertain(&half);
        self.repeated_by_client(&half, cx);
        self.pairing.released = None;
        let rival = self.pairing.held.is_some_and(|held| held.rival);
        self.release_expired(cx);
        if !rival || self.pairing.held.is_none() {
            self.settle(cx);
        }
        let unprovoked = self.pairing.unprovoked.take().filter(|abort| within_hold(abort.at, half.at));
        if let Command::Abort(_, code) = half.command {
            self.release_held(cx);
            self.settle(cx);
            self.client_abort(&half, code, cx);
            return;
        }
        if let Some(under_way) = &mut self.pairing.under_way
            && under_way.side == Side::Client
            && !half.command.is_initiate()
        {
            let [command, ..] = half.bytes;
            let continues = under_way.seqno != 0 && command & 0x7F == under_way.seqno;
            let owed = under_way.is_owed(&half) || (unprovoked.is_some() && matches!(self.phase, Phase::Idle));
            if continues || owed {
                under_way.seqno = if continues { (under_way.seqno + 1) & 0x7F } else { under_way.seqno };
                self.step.place = Place::InFlight;
                return;
            }
        }
        if matches!(self.phase, Phase::Block(_)) && self.block_client(&half, cx) {
            return;
        }
        if self.pairing.pending.is_some() && self.supersede(&half, cx) {
            return;
        }
        if let Some(held) = self.pairing.held.take() {
            if wire::fits(&half.command, &held.half.command)
                && (self.can_request(&half) || self.join_segments(&half, cx))
            {
                self.settle(cx);
                self.pair_backwards(half, held, cx);
                return;
            }
            self.pairing.held = Some(held);
            self.release_held(cx);
            self.settle(cx);
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
            self.pair_backwards(half, Held { half: answer, first: true, rival: false }, cx);
            return;
        }
        self.request(half, unprovoked, cx);
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
    fn request(&mut self, half: Half, unprovoked: Option<Unprovoked>, cx: &mut Context<'_>) {
        if half.command.is_initiate() {
            self.leave_open_transfer(&half, cx);
            self.begin(&half, cx);
            self.pairing.under_way = None;
            self.pairing.stray = None;
            if let Some(Unprovoked { at, refusal: Some((object, code)) }) = unprovoked
                && half.command.mux() == Some(object)
            {
                self.refused(half, at, code, cx);
                return;
            }
            self.pairing.abort_may_answer = unprovoked.is_some();
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

    /// A late request and the abort, captured before it, that refused its object: a pair, unless the next response
    /// answers the same request and no other comes for it.
    fn refused(&mut self, request: Half, response: FrameRef, code: u32, cx: &mut Context<'_>) {
        self.step.answered_by = Some(response);
        self.pairing.abort_may_answer = false;
        self.pairing.tentative = Some(Tentative { request, response, first: false, refused: true });
        if strict_initiate(&request) {
            self.trust(cx);
        }
        self.attempted(&request);
        if let Some(transfer) = &mut self.transfer {
            transfer.reordered = true;
            transfer.abort = Some(Abort { code, by: Side::Server });
        }
        self.complete(Status::Aborted, cx);
    }

    /// Whether the open transfer is one in which a client sends this.
    fn can_request(&self, half: &Half) -> bool {
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
        self.find(Code::Sdo007, half.at, Facts::Outside, cx);
        if self.transfer.is_none() {
            self.outside = Outside::Said;
        }
    }

    /// A frame by the server: does it abort, is it still under way, does it belong to sub-blocks; else it answers the
    /// pending request, or is held for a late one.
    pub(super) fn server(&mut self, half: Half, cx: &mut Context<'_>) {
        let fresh = *self.pairing.first.get_or_insert(half.at.no) == half.at.no;
        self.repeated_by_server(&half, cx);
        self.pairing.heard = Some(half);
        self.release_expired(cx);
        if let Command::Abort(mux, code) = half.command {
            self.release_held(cx);
            self.settle(cx);
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
        self.release_held(cx);
        if let Some(pending) = self.pairing.pending {
            self.respond(pending, half, cx);
            return;
        }
        self.respond_unasked(half, fresh, cx);
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
            self.settle(cx);
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
            self.respond_unasked(half, false, cx);
            return;
        }
        if self.pairing.may_be_answered(&pending) {
            self.leave_answered(cx);
            self.respond_unasked(half, false, cx);
            return;
        }
        if matches!(half.command, Command::Segment(_)) && self.pairing.last_response == Some(half.bytes) {
            self.step.place = Place::Outside;
            self.find(Code::Sdo002, half.at, Facts::Duplicate, cx);
            return;
        }
        let uncaptured = self.outside == Outside::Uncaptured && !wire::kind_fits(&pending.command, &half.command);
        if self.is_edge(&pending) || uncaptured {
            self.step.place = Place::Uncaptured;
            self.pairing.held = Some(Held { half, first: true, rival: false });
            return;
        }
        if wire::kind_fits(&pending.command, &half.command) {
            self.settle(cx);
            self.step.ordinal = self.segment_ordinal(&half.command);
            self.answer(pending, half, cx);
            return;
        }
        self.step.place = Place::Outside;
        if !half.command.is_unreadable() {
            self.find(Code::Sdo002, half.at, Facts::Missing { by: Side::Client }, cx);
        }
    }

    /// A response while no request is pending.
    fn respond_unasked(&mut self, half: Half, fresh: bool, cx: &mut Context<'_>) {
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
        let rival = match self.pairing.tentative {
            Some(tentative) if wire::fits(&tentative.request.command, &half.command) => {
                let first = tentative.first && !tentative.is_likely(half.at);
                if first || (!tentative.refused && tentative.is_unlikely(half.at)) {
                    self.dissolve(tentative, cx);
                    self.answer(tentative.request, half, cx);
                    return;
                }
                true
            }
            _ => false,
        };
        if !rival {
            self.settle(cx);
            if self.is_late(&half) {
                self.late(&half, cx);
                return;
            }
        }
        self.step.ordinal = self.segment_ordinal(&half.command);
        // Where nothing of the channel can lie before it, an answer without a request counts as the first request does.
        self.begun |= self.is_idle_from_start() && is_strict_answer(&half);
        if fresh {
            self.step.place = Place::Uncaptured;
        } else if self.outside == Outside::Uncaptured && matches!(half.command, Command::BlockAck { .. }) {
            self.step.place = Place::Uncaptured;
            self.join_block(&half, Direction::Download, cx);
            return;
        }
        self.pairing.held = Some(Held { half, first: fresh || !self.begun, rival });
    }

    /// The response was held and its request has come.
    fn pair_backwards(&mut self, request: Half, held: Held, cx: &mut Context<'_>) {
        self.step.answered_by = Some(held.half.at);
        let initiate = request.command.is_initiate();
        if initiate {
            self.leave_open_transfer(&request, cx);
            self.begin(&request, cx);
            self.pairing.under_way = None;
            let (response, first) = (held.half.at, held.first);
            self.pairing.tentative = Some(Tentative { request, response, first, refused: false });
        }
        self.answer(request, held.half, cx);
    }

    /// The tentative pair was none: its response answers a request that is not in the capture.
    fn dissolve(&mut self, tentative: Tentative, cx: &mut Context<'_>) {
        self.pairing.tentative = None;
        let unsettled = self.unsettled.take().map(|transfer| transfer.id);
        if tentative.first {
            self.note(Note::RequestNotCaptured, tentative.response, cx);
        } else if !tentative.refused {
            self.find_about = tentative.request.command.mux();
            self.find(Code::Sdo002, tentative.response, Facts::Missing { by: Side::Client }, cx);
        }
        match unsettled.or(self.transfer.as_ref().map(|transfer| transfer.id)) {
            Some(id) => self.begin_as(id, &tentative.request, cx),
            None => self.begin(&tentative.request, cx),
        }
        self.pairing.pending = Some(tentative.request);
    }

    /// No second response came: the tentative pair stands.
    pub(super) fn settle(&mut self, cx: &mut Context<'_>) {
        self.pairing.tentative = None;
        if let Some(transfer) = self.unsettled.take() {
            let own = std::mem::replace(&mut self.own, true);
            self.announce(transfer, cx);
            self.own = own;
        }
    }

    fn release_expired(&mut self, cx: &mut Context<'_>) {
        if self.pairing.held.is_some_and(|held| !within_hold(held.half.at, cx.at)) {
            self.release_held(cx);
        }
    }

    /// The held response gets no late request.
    fn release_held(&mut self, cx: &mut Context<'_>) {
        let Some(held) = self.pairing.held.take() else { return };
        if held.rival
            && let Some(tentative) = self.pairing.tentative
        {
            self.dissolve(tentative, cx);
            let own = std::mem::replace(&mut self.own, false);
            self.answer(tentative.request, held.half, cx);
            self.own = own;
            return;
        }
        let duplicate = self.pairing.last_response == Some(held.half.bytes);
        if !held.first {
            let facts = if duplicate { Facts::Duplicate } else { Facts::Missing { by: Side::Client } };
            self.find(Code::Sdo002, held.half.at, facts, cx);
        }
        self.continue_without_request(&held.half, cx);
        self.pairing.released = Some(held.half);
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
                let own = std::mem::replace(&mut self.own, false);
                self.add_segment(*half, segment, cx);
                self.own = own;
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

    /// The capture ends while a response is held: its request may lie beyond the edge.
    pub(super) fn settle_held_at_end(&mut self, cx: &mut Context<'_>) {
        self.settle_ack_at_end();
        match self.pairing.held.take() {
            // Long after it, no late request will come any more.
            Some(held) if !within(held.half.at, cx.at, UNANSWERED_NS) => {
                self.pairing.held = Some(held);
                self.release_held(cx);
            }
            Some(held) => self.continue_without_request(&held.half, cx),
            None => {}
        }
    }

    /// The pending request was answered before it was captured, by what was taken for the answer to another.
    pub(super) fn leave_answered(&mut self, cx: &mut Context<'_>) {
        self.pairing.pending = None;
        self.pairing.certain = true;
        let own = std::mem::replace(&mut self.own, false);
        self.complete(Status::Incomplete, cx);
        self.own = own;
    }

    /// A client frame while its last request was not answered. Returns whether the frame needs nothing more.
    fn supersede(&mut self, half: &Half, cx: &mut Context<'_>) -> bool {
        let Some(pending) = self.pairing.pending else { return false };
        if half.command.is_initiate() && self.pairing.may_be_answered(&pending) {
            self.leave_answered(cx);
            return false;
        }
        if pending.bytes == half.bytes && pending.len == half.len && !self.pairing.abort_may_answer {
            self.step.place = Place::Repeated;
            // Both may still be answered.
            self.pairing.given_up = Some(pending);
            self.repeat(&pending, half);
            self.find(Code::Sdo015, pending.at, Facts::None, cx);
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
        let answered = self.pairing.held.is_some_and(|held| wire::fits(&half.command, &held.half.command));
        if !answered && !initiate && self.is_midway_block(&pending, half) {
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
                self.find(Code::Sdo012, pending.at, Facts::EndNotConfirmed, cx);
                self.end_unconfirmed(pending, cx);
            } else {
                self.unanswered(&pending, edge, cx);
                self.abandon(&pending, edge, cx);
            }
            return false;
        }
        match (pending.command, half.command) {
            (Command::InitiateUpload(_), Command::SegmentRequest { .. })
            | (Command::InitiateDownload(..), Command::Segment(_)) => {
                self.unanswered(&pending, edge, cx);
                if let Some(transfer) = &mut self.transfer
                    && transfer.mode == Mode::Expedited
                {
                    transfer.mode = Mode::Segmented;
                }
                self.phase = Phase::Segments { toggle: false };
            }
            (Command::InitiateBlockUpload { blksize, .. }, Command::StartBlockUpload | Command::BlockAck { .. }) => {
                self.unanswered(&pending, edge, cx);
                self.block_initiated(pending.at, blksize, false, None);
                return self.block_client(half, cx);
            }
            (Command::SegmentRequest { toggle }, Command::SegmentRequest { toggle: next }) if toggle != next => {
                self.unanswered(&pending, edge, cx);
                self.phase = Phase::Segments { toggle: next };
                if let Some(transfer) = &mut self.transfer {
                    transfer.hole = true;
                }
            }
            (Command::Segment(sent), Command::Segment(next)) if sent.toggle != next.toggle => {
                self.unanswered(&pending, edge, cx);
                self.phase = Phase::Segments { toggle: next.toggle };
                self.add_segment(pending, sent, cx);
            }
            (Command::InitiateBlockUpload { .. }, Command::SegmentRequest { .. }) => {
                self.unanswered(&pending, edge, cx);
                if let Some(transfer) = &mut self.transfer {
                    transfer.mode = Mode::Segmented;
                }
                self.phase = Phase::Segments { toggle: false };
            }
            (Command::InitiateBlockDownload { .. }, _) if half.bytes[0] & 0x7F == 1 => {
                self.unanswered(&pending, edge, cx);
                self.block_initiated(pending.at, MOST, false, None);
                let segment = Half { command: wire::block_segment(half.bytes), ..*half };
                self.step.command = segment.command;
                return self.block_client(&segment, cx);
            }
            // Nothing that a client sends after its request: the request still awaits its answer.
            _ => {
                self.pairing.pending = Some(pending);
                self.violation_outside(half, cx);
                return true;
            }
        }
        false
    }

    fn unanswered(&mut self, pending: &Half, edge: bool, cx: &mut Context<'_>) {
        if !edge {
            self.find(Code::Sdo002, pending.at, Facts::Missing { by: Side::Server }, cx);
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
    fn leave_open_transfer(&mut self, half: &Half, cx: &mut Context<'_>) {
        let Some(transfer) = &self.transfer else { return };
        let (last, uncaptured) = (transfer.last, transfer.mux.is_none());
        if self.is_meant_as_data() && matches!(self.phase, Phase::Segments { .. }) {
            self.recognise_unmarked(cx);
            return;
        }
        if self.leave_ended_block(cx) {
            return;
        }
        if self.all_bytes_without_last() {
            self.find(Code::Sdo007, last, Facts::NoLast, cx);
        } else if !uncaptured && !matches!(self.phase, Phase::Initiated) {
            self.find(Code::Sdo008, half.at, Facts::None, cx);
        }
        let own = std::mem::replace(&mut self.own, false);
        self.complete(if uncaptured { Status::Incomplete } else { Status::Failed }, cx);
        self.own = own;
    }

    fn segment_ordinal(&self, command: &Command) -> u32 {
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
fn is_strict_answer(half: &Half) -> bool {
    matches!(half.command, Command::UploadInitiated(..) | Command::DownloadInitiated(_))
        && half.command.mux().is_some_and(|mux| mux.index >= 0x1000)
        && !half.command.has_reserved_bits(half.bytes)
        && half.len == 8
}

fn is_block_initiate(half: &Half) -> bool {
    matches!(half.command, Command::InitiateBlockDownload { .. } | Command::InitiateBlockUpload { .. })
}

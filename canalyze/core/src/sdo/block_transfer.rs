//! Effects of the frames of a block transfer (CiA 301, 7.2.4.3.8 to 7.2.4.3.16).
//!
//! The sender's frames are segments here, not commands. In an upload the client's acknowledgement may be captured after
//! the next segment or the end frame; in a download the server may acknowledge one segment more than was seen, which is
//! then late. `block` decides which segments count, `machine` which frames come here.

use super::block::{Block, End, Resume};
use super::exchange::wrong_size;
use super::limits::{SHORTEST_TIMEOUT_NS, within};
use super::phase::{Half, Phase, is_strict_answer, strict_initiate};
use super::sequence::FRAMES;
use super::state::SdoChannel;
use super::sub_block::{Segment, Taken};
use super::transfer::{Direction, Mode, Status};
use super::wire::{self, Command, Side};
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::rules::finding::Code;
use crate::rules::sdo::{Sdo002, Sdo012, Sdo019, Sdo024, Sdo025};
use crate::world::context::Context;
use crate::world::event::Place;

/// Minimum time of a segment on the bus, in ns: eight bytes at 1 Mbit/s.
const SEGMENT_NS: Ns = Ns::from_us(100);

impl SdoChannel {
    /// Decodes a frame of the data's sender.
    pub(super) fn decode_in_block(&self, block: &Block, side: Side, bytes: [u8; 8]) -> Command {
        let plain = wire::decode(side, bytes);
        let [command, ..] = bytes;
        if self.pending().is_some_and(|pending| matches!(pending.command, Command::EndBlock { .. })) {
            // All segments were sent.
            return plain;
        }
        if let Command::EndBlock { .. } = plain {
            let [_, _, _, rest @ ..] = bytes;
            // A premature end follows an acknowledgement. Within a sub-block it is rather a segment after a lost one,
            // or one on its way during a partial acknowledgement.
            let open = matches!(block.resume, Resume::Unknown | Resume::BehindInFlight);
            let known = !open || block.is_off(command & 0x7F);
            let early = known && block.expected() == 1 && command & 0x7F != 1 && rest == [0; 5];
            if block.may_end() || early || side == Side::Server && self.sequence.holds_last() {
                return plain;
            }
        }
        // The sub-block is complete, and this is neither the next one nor a segment too many.
        let restarts = block.finished || (block.owes_ack() && !block.goes_on(command & 0x7F));
        if side == Side::Client && restarts && strict_initiate(&Half { command: plain, ..Half::of(bytes) }) {
            return plain;
        }
        // The server's answer repeated before any segment.
        if matches!(plain, Command::BlockUploadInitiated { .. })
            && block.marks.first.is_none()
            && self.history.last_response == Some(bytes)
        {
            return plain;
        }
        // After the end, the answer to the client's next request after its confirmation.
        if side == Side::Server && block.end.is_some() && plain.mux().is_some() && !plain.has_reserved_bits(bytes) {
            return plain;
        }
        // A client that restarts midway: only a read, whose bytes 4..7 are 0, differs from data.
        if let Command::InitiateUpload(mux) = plain
            && bytes[0] == 0x40
            && block.expected() != 0x40
            && mux.index >= 0x1000
            && !plain.has_reserved_bits(bytes)
        {
            return plain;
        }
        wire::block_segment(bytes)
    }

    pub(super) fn block_initiated(&mut self, at: FrameRef, blksize: u8, crc: bool, size: Option<u32>) {
        if let Some(transfer) = &mut self.transfer {
            transfer.mode = Mode::Block;
            transfer.data.initiated = Some(at);
            transfer.outcome.crc_negotiated = Some(crc);
            if size.is_some() {
                transfer.data.size_indicated = size;
            }
        }
        self.phase = Phase::Block(Box::new(Block::new(blksize)), None);
    }

    pub(super) fn is_upload(&self) -> bool {
        self.transfer.as_ref().is_some_and(|transfer| transfer.direction == Direction::Upload)
    }

    /// Returns true if the capture lacks the initiate request of the transfer.
    pub(super) fn is_nameless(&self) -> bool {
        self.transfer.as_ref().is_some_and(|transfer| transfer.mux.is_none())
    }

    pub(super) fn block(&self) -> Option<&Block> {
        if let Phase::Block(block, _) = &self.phase { Some(block) } else { None }
    }

    /// Returns the frame, or the expected segment if the frame is empty; its length was reported.
    pub(super) fn unless_empty(&self, side: Side, half: Half) -> Half {
        match &self.phase {
            Phase::Block(block, _) if half.len == 0 && self.sends_data(side) => {
                let segment = |seqno| Command::BlockSegment { seqno, last: false, data: [0; 7] };
                Half { command: block.unread().map_or(half.command, segment), ..half }
            }
            _ => half,
        }
    }

    /// Returns true if a frame of the server is expected in a sub-block; `None` if it does not belong to one.
    pub(super) fn is_due_in_block(&self, block: &Block, half: &Half) -> Option<bool> {
        let midway = self.is_nameless();
        match half.command {
            Command::BlockSegment { seqno: 1, .. } if (midway || self.proof.requests > 0) && block.restarts_early() => {
                Some(false)
            }
            // Before the first segment, it may be the response to a late request.
            Command::BlockSegment { .. } if midway && (block.resume != Resume::Now || block.marks.first.is_none()) => {
                let plain = Half { command: wire::decode(Side::Server, half.bytes), ..*half };
                Some(!is_strict_answer(&plain))
            }
            Command::BlockSegment { seqno, .. } => Some(seqno != 1 || !block.owes_ack()),
            Command::EndBlock { .. } => Some(!block.owes_ack()),
            Command::BlockAck { ackseq, .. } => Some(!self.may_be_sent(block.not_seen(ackseq), half)),
            Command::BlockUploadInitiated { .. } => Some(block.end.is_none()),
            Command::BlockEnded if midway => Some(true),
            _ => None,
        }
    }

    /// Returns true if this number of segments may have been sent before an acknowledgement and be listed after it.
    fn may_be_sent(&self, segments: u8, ack: &Half) -> bool {
        // The server's frames are listed in time; the client's last one may itself be late.
        let heard = self.history.heard.map(|heard| heard.at);
        let since = heard.or(self.transfer.as_ref().map(|transfer| transfer.last)).and_then(|at| at.t_ns);
        let time = i64::from(segments) * SEGMENT_NS;
        let fits = |(since, now): (Ns, Ns)| now - since >= time;
        segments > 0 && since.zip(ack.at.t_ns).map_or(segments <= FRAMES, fits)
    }

    /// Takes the client's start of the upload.
    pub(super) fn start_upload(&mut self, half: &Half, cx: &mut Context<'_>) {
        let (Phase::Block(block, _), Some(transfer)) = (&mut self.phase, &mut self.transfer) else { return };
        if !std::mem::replace(&mut block.started, true) {
            transfer.last = half.at;
            return;
        }
        self.step.place = Place::Repeated;
        let before = transfer.last;
        if cx.evidence.recording.is_sent_again(before, half.at) {
            self.find(Code::Sdo015, before, cx);
        }
    }

    /// Reports an acknowledgement by a client that has not started the upload.
    fn judge_start(&mut self, half: &Half, cx: &mut Context<'_>) {
        let upload = self.is_upload();
        if let Phase::Block(block, _) = &mut self.phase
            && upload
            && !std::mem::replace(&mut block.started, true)
        {
            let first = block.marks.first.unwrap_or(half.at);
            self.find(Sdo002::NoRequest, first, cx);
        }
    }

    /// Reports a client's confirmation without an end frame.
    pub(super) fn confirm_unseen(&mut self, half: &Half, cx: &mut Context<'_>) {
        let finished = self.block().is_some_and(|block| block.finished);
        if self.is_nameless() {
            self.complete(Status::Incomplete, cx);
        } else if finished {
            let asked = self.transfer.as_ref().map_or(half.at, |transfer| transfer.last);
            self.find(Sdo002::NoResponse, asked, cx);
            self.complete(Status::Incomplete, cx);
        } else {
            self.violation_outside(half, cx);
        }
    }

    pub(super) fn block_segment(&mut self, half: &Half, cx: &mut Context<'_>) {
        let Command::BlockSegment { seqno, last, data } = half.command else { return };
        let midway = self.is_nameless();
        let Phase::Block(block, _) = &mut self.phase else { return };
        if block.finished {
            if seqno != 1 || block.end.is_some() {
                self.step.place = Place::Outside;
                self.find(Sdo012::Outside, half.at, cx);
                return;
            }
            let marked = block.reopen().unwrap_or(half.at);
            if block.is_answered() {
                self.find(Sdo012::Outside, marked, cx);
            } else if let Some(transfer) = &mut self.transfer {
                // The receiver has requested them again, which the capture lacks.
                block.miss(transfer);
            }
        }
        let (Phase::Block(block, _), Some(transfer)) = (&mut self.phase, &mut self.transfer) else { return };
        self.step.ordinal = block.ordinal(transfer.data.segments);
        block.pace.take(half.at, transfer.data.size);
        let segment = Segment { seqno, last, data, len: half.len };
        let (taken, ack_missing) = block.segment(transfer, half.at, segment);
        let not_resent = block.not_resent.take();
        self.step.place = match taken {
            Taken::InSequence => Place::Due,
            Taken::InFlight if midway => Place::Uncaptured,
            Taken::InFlight => Place::InFlight,
            Taken::OutOfSequence(expected) => Place::OutOfSequence(expected),
        };
        if taken != Taken::InSequence {
            self.step.ordinal = 0;
        }
        if let Some(due_since) = ack_missing {
            // A sender that goes on without having waited was acknowledged.
            if within(due_since, half.at, SHORTEST_TIMEOUT_NS) {
                self.find(Sdo024::Acknowledgement, due_since, cx);
            } else {
                self.find(Sdo002::NotAcknowledged, due_since, cx);
            }
        }
        if let Some((ack, ackseq)) = not_resent {
            self.doubt(Sdo012::NotResent { ackseq: ackseq.into() }, ack, false, cx);
        }
    }

    /// Takes the end frame of the data's sender; in a download it is a request, which the server confirms.
    pub(super) fn end_block(&mut self, half: Half, cx: &mut Context<'_>) {
        if !self.may_end_here(&half, cx) {
            return;
        }
        let upload = self.is_upload();
        if let Some(block) = self.block()
            && (block.owes_ack() || (!upload && !block.finished))
        {
            let due_since = block.marks.complete.unwrap_or(half.at);
            self.find(Sdo002::NotAcknowledged, due_since, cx);
            if let (Phase::Block(block, _), Some(transfer)) = (&mut self.phase, &mut self.transfer) {
                block.settle_whole(transfer);
            }
        }
        if !upload {
            return self.request_end(half, cx);
        }
        self.put_end(&half);
        if self.block().is_some_and(|block| block.finished) {
            self.judge_end(cx);
        }
    }

    /// Returns true if the transfer can go on with this end frame; reports a premature one.
    fn may_end_here(&mut self, half: &Half, cx: &mut Context<'_>) -> bool {
        let upload = self.is_upload();
        let (Phase::Block(block, _), Some(transfer)) = (&mut self.phase, &mut self.transfer) else { return false };
        let again = upload && block.end.is_some();
        if block.may_end() {
        } else if block.last_sent && !transfer.data.hole {
            let goes_on = block.finish_unacknowledged(transfer);
            self.find(Sdo012::EarlyEnd, half.at, cx);
            if !goes_on {
                self.step.place = Place::Outside;
                return false;
            }
        } else {
            let (newest, unsure) = (block.marks.newest.unwrap_or(half.at), block.unsure);
            let hole = transfer.data.hole;
            block.finish_early(transfer);
            block.unseen = block.marks.newest.is_none() && transfer.data.size == 0;
            // If segments are missing, the last is among them, and that was reported.
            if !hole && !unsure {
                self.doubt(Sdo012::NoLast, newest, false, cx);
            }
        }
        if again {
            self.step.place = Place::Outside;
            self.find(Sdo002::Duplicate, half.at, cx);
        }
        !again
    }

    /// Makes the end frame of a download wait for its confirmation.
    fn request_end(&mut self, half: Half, cx: &mut Context<'_>) {
        if let Some(pending) = self.pending() {
            if !self.settle_pending(&pending, &half, cx) {
                self.violation_outside(&half, cx);
            }
        } else if self.block().is_some_and(Block::may_end) {
            self.set_pending(half);
        } else {
            self.stray(&half, cx);
        }
    }

    /// Takes an unreadable frame in the place of an upload's end: the amount of data in the last segment is unknown.
    pub(super) fn end_unread(&mut self, half: Half, cx: &mut Context<'_>) {
        let (Phase::Block(block, _), Some(transfer)) = (&mut self.phase, &mut self.transfer) else { return };
        if block.may_end() && block.end.is_none() {
            transfer.data.hole = true;
            block.end = Some(End { at: half.at, unused: None, crc: None });
        } else {
            self.respond_unasked(half, cx);
        }
    }

    /// Takes an unreadable frame in the place of an acknowledgement or a confirmation.
    pub(super) fn acknowledge_unread(&mut self, side: Side, half: Half, cx: &mut Context<'_>) {
        let (Phase::Block(block, _), Some(transfer)) = (&mut self.phase, &mut self.transfer) else { return };
        if side == Side::Client && block.finished && block.end.is_some() {
            self.confirm_end(cx);
        } else if block.ack_unread(transfer) {
            if block.finished {
                self.judge_end(cx);
            }
        } else if side == Side::Server {
            self.respond_unasked(half, cx);
        }
    }

    pub(super) fn acknowledge(&mut self, half: &Half, cx: &mut Context<'_>) {
        let Command::BlockAck { ackseq, blksize } = half.command else { return };
        self.judge_start(half, cx);
        let (Phase::Block(block, _), Some(transfer)) = (&mut self.phase, &mut self.transfer) else { return };
        if block.finished {
            self.violation_outside(half, cx);
            return;
        }
        self.proof.paired |= !half.command.has_reserved_bits(half.bytes);
        let late = block.marks.first.is_some_and(|first| self.sequence.within_lag(first, half.at));
        let nameless = transfer.mux.is_none() && transfer.direction == Direction::Upload;
        let next = self.ahead.filter(|(by, _)| *by == Side::Server).map(|(_, first)| first & 0x7F);
        if nameless && block.is_of_before(ackseq, next, late) {
            block.set_size(blksize);
            return;
        }
        let most = u64::from(block.most());
        let owed = block.marks.complete.filter(|_| transfer.direction == Direction::Download);
        let acked = block.ack(transfer, half.at, ackseq, blksize);
        transfer.last = half.at;
        if let Some(owed) = owed {
            self.judge_delay(cx.evidence.recording.at(owed), false, half, cx);
        }
        if acked.missing > 0 {
            self.find(Sdo024::Missing { missing: acked.missing.into() }, half.at, cx);
        }
        let (Phase::Block(block, _), Some(transfer)) = (&mut self.phase, &mut self.transfer) else { return };
        if acked.retransmission {
            transfer.outcome.retransmissions = transfer.outcome.retransmissions.saturating_add(1);
        }
        let (finished, end, not_resent) = (block.finished, block.end, block.not_resent.take());
        if let Some((first, last)) = acked.again.filter(|_| acked.fault.is_none()) {
            let range = Sdo025::Again { first: first.into(), last: last.into() };
            let again = if first == last { Sdo025::One { segment: first.into() } } else { range };
            self.find(again, half.at, cx);
        }
        if let Some((ack, ackseq)) = not_resent {
            self.doubt(Sdo012::NotResent { ackseq: ackseq.into() }, ack, false, cx);
        }
        if let Some((what, cause)) = acked.fault {
            // Lost frames do not explain a number beyond the size of a sub-block.
            let beyond = matches!(what, Sdo012::Sequence { found, .. } if found > most);
            let (at, bad) =
                (cause.unwrap_or(half.at), matches!(what, Sdo012::Sequence { .. } | Sdo012::Acknowledged { .. }));
            if bad && !beyond { self.doubt(what, at, bad, cx) } else { self.find(what, at, cx) }
        }
        match end {
            Some(_) if finished => self.judge_end(cx),
            Some(end) => {
                self.find(Sdo012::EarlyEnd, end.at, cx);
                if let Phase::Block(block, _) = &mut self.phase {
                    block.end = None;
                }
            }
            None => {}
        }
    }

    /// Judges size and CRC, once the end frame is seen and all segments are acknowledged.
    fn judge_end(&mut self, cx: &mut Context<'_>) {
        let doubted = self.is_doubted();
        let (Phase::Block(block, _), Some(transfer)) = (&mut self.phase, &mut self.transfer) else { return };
        let Some(end) = block.end else { return };
        let padding = block.close(transfer, end.unused);
        if transfer.data.hole || transfer.mux.is_none() {
            return;
        }
        let right = transfer.size_is_right();
        let padding = padding.get(..usize::from(end.unused.unwrap_or(0).min(7))).unwrap_or(&[]);
        let crc = end.crc.map(|found| (found, transfer.check_crc(found, padding)));
        let wrong_crc = crc.filter(|(found, (computed, _))| computed != found);
        // Without a readable acknowledgement, repeated segments are unknown.
        if (block.unsure || !block.is_answered()) && !(right && wrong_crc.is_none()) {
            transfer.data.hole = true;
            return;
        }
        let wrong_crc = wrong_crc.filter(|_| transfer.outcome.crc_negotiated == Some(true));
        if !right {
            let cause = transfer.data.initiated.unwrap_or(end.at);
            let (size, at) = (wrong_size(transfer), if end.at.no == cx.at.no { cause } else { end.at });
            // If the CRC contradicts the bytes as well, another fault exists, or the time leaves room for more,
            // segments are rather missing.
            let lack = transfer.data.size_indicated.map_or(0, u64::from).saturating_sub(transfer.data.size);
            let checked = transfer.outcome.crc_negotiated == Some(true);
            let room = !checked && lack > 0 && lack % 7 == 0 && block.pace.room_for(lack / 7).is_some();
            let doubted = doubted || wrong_crc.is_some() || room;
            transfer.outcome.bad |= !doubted;
            if doubted { self.doubt(size, at, true, cx) } else { self.find(size, at, cx) }
        } else if let Some((found, (computed, matches))) = wrong_crc {
            transfer.outcome.bad = true;
            self.find(Sdo019::Crc { computed, found, matches }, end.at, cx);
        }
    }

    /// Decides the doubts after a transfer that both sides took as complete. If indicated bytes are missing, the
    /// recording lost them.
    pub(super) fn weigh_doubts(&mut self, cx: &mut Context<'_>) {
        let doubted = self.is_doubted();
        let Some(transfer) = self.transfer.as_mut().filter(|_| doubted) else { return };
        let indicated = transfer.data.size_indicated.map_or(0, u64::from);
        let uncounted = if let Phase::Block(block, _) = &self.phase { block.uncounted() } else { 0 };
        let bytes = indicated.saturating_sub(transfer.data.size);
        let missing = bytes.div_ceil(7).saturating_sub(uncounted);
        let whole = !transfer.data.even || bytes % 7 == 0;
        if missing > 0 && whole && !transfer.outcome.bad {
            self.dismiss_doubts(Sdo024::Missing { missing }, cx);
        } else {
            self.confirm_doubts(cx);
        }
    }

    /// Takes the confirmation of a block transfer's end. Where no segment was captured, the other side has them.
    pub(super) fn agree_on_end(&mut self, cx: &mut Context<'_>) {
        if self.is_doubted() && self.block().is_some_and(|block| block.unseen) {
            self.dismiss_doubts(Sdo024::Data, cx);
        }
        self.confirm_end(cx);
    }

    pub(super) fn confirm_end(&mut self, cx: &mut Context<'_>) {
        self.weigh_doubts(cx);
        let status = match &self.transfer {
            Some(transfer) if transfer.outcome.bad => Status::Failed,
            Some(transfer) if transfer.data.hole || transfer.outcome.midway => Status::Incomplete,
            _ => Status::Ok,
        };
        // No request from before the capture waits for its answer any more.
        self.proof.begun = true;
        self.complete(status, cx);
    }

    fn put_end(&mut self, half: &Half) {
        if let (Phase::Block(block, _), Command::EndBlock { unused, crc }) = (&mut self.phase, half.command) {
            block.end = Some(End { at: half.at, unused: Some(unused), crc: (half.len > 2).then_some(crc) });
        }
    }

    /// Takes the end of a download, once its confirmation is known.
    pub(super) fn settle_end(&mut self, end: &Half, cx: &mut Context<'_>) {
        self.put_end(end);
        self.judge_end(cx);
    }

    /// Closes an upload whose end the client did not confirm before it went on; returns true if it was one.
    pub(super) fn leave_ended_block(&mut self, cx: &mut Context<'_>) -> bool {
        let Some(end) = self.block().filter(|block| block.finished).and_then(|block| block.end) else {
            return false;
        };
        self.find(Sdo012::EndNotConfirmed, end.at, cx);
        self.before_frame(|channel| channel.confirm_end(cx));
        true
    }

    /// Reports an unconfirmed end of an upload long before the end of the capture.
    pub(super) fn judge_unconfirmed_end(&mut self, cx: &mut Context<'_>) {
        if let Some(end) = self.block().and_then(|block| block.end) {
            self.find(Sdo012::EndNotConfirmed, end.at, cx);
        }
    }

    /// Reports an acknowledgement or segments of the server for which the client has waited in vain.
    pub(super) fn judge_stalled_block(&mut self, cx: &mut Context<'_>) {
        let Some(block) = self.block() else { return };
        let Some(transfer) = self.transfer.as_ref().filter(|transfer| transfer.mux.is_some() && !transfer.data.hole)
        else {
            return;
        };
        if block.end.is_some() || self.pending().is_some() {
            return;
        }
        let asked = transfer.last;
        match block.marks.complete.filter(|_| block.owes_ack()) {
            Some(due_since) if !self.is_upload() => self.find(Sdo002::NotAcknowledged, due_since, cx),
            None if self.is_upload() && block.started => {
                self.find(Sdo002::NoResponse, asked, cx);
            }
            _ => {}
        }
    }

    /// Returns true if the client is the next to send in a block transfer.
    pub(super) fn is_block_left(&self, block: &Block) -> bool {
        let acknowledges = block.marks.complete.is_some() && block.owes_ack();
        block.end.is_none() && if self.is_upload() { acknowledges || !block.started } else { !acknowledges }
    }

    /// Reports a segment out of sequence before an abort.
    pub(super) fn judge_aborted_block(&mut self, cx: &mut Context<'_>) {
        if let Some((what, at)) = self.block().and_then(Block::wrong) {
            self.find(what, at, cx);
        }
    }

    /// Returns the next sequence number of the side that sends the data; 0 outside block transfers.
    pub(super) fn block_seqno(&self, side: Side) -> u8 {
        self.block().filter(|_| self.sends_data(side)).map_or(0, Block::expected)
    }
}

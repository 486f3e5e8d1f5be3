//! The channel while sub-blocks of a block transfer run (CiA 301, 7.2.4.3.9 to 7.2.4.3.15).
//!
//! The sender's frames are segments here, not commands. In an upload the client's acknowledgement may be captured
//! after the next segment, or after the end frame; in a download the server may acknowledge one segment more than
//! was seen, which is then late. Which segments count stands in `block`; pairs of request and response stand in
//! `pairing`.

use super::block::{Block, End, Segment, Taken};
use super::channel::{Channel, Half, Phase, strict_initiate};
use super::exchange::wrong_size;
use super::sequence::FRAMES;
use super::transfer::{Direction, Mode, Status};
use super::wire::{self, Command, Side};
use crate::context::Context;
use crate::event::Place;
use crate::finding::Code;
use crate::frame::FrameRef;
use crate::rules::sdo::{Sdo002, Sdo012, Sdo019};

/// A segment takes at least so long on the bus, in ns: eight bytes at 1 Mbit/s.
const SEGMENT_NS: i64 = 100_000;

impl Channel {
    /// The command of a frame by the sender of the data.
    pub(super) fn decode_in_block(&self, block: &Block, side: Side, bytes: [u8; 8]) -> Command {
        let plain = wire::decode(side, bytes);
        let [command, ..] = bytes;
        if self.pairing.pending.is_some_and(|pending| matches!(pending.command, Command::EndBlock { .. })) {
            // All segments were sent.
            return plain;
        }
        if let Command::EndBlock { .. } = plain {
            let [_, _, _, rest @ ..] = bytes;
            // An end that comes too early follows an acknowledgement; within a sub-block it is rather a segment
            // after a lost one.
            let known = block.last_was_sent() || !block.may_be_in_flight();
            let early = known && block.expected() == 1 && command & 0x7F != 1 && rest == [0; 5];
            let missed = self.awaits_segments() && command & 0x7F != block.expected() && rest == [0; 5];
            let due = command & 0x7F == block.expected() && block.ends_unread();
            if (block.may_end() && !due) || early || missed {
                return plain;
            }
        }
        // The sub-block is complete, and what comes is neither the next one nor a segment too many.
        let restarts = block.owes_ack() && !block.goes_on(command & 0x7F);
        if side == Side::Client && restarts && strict_initiate(&Half { command: plain, ..Half::of(bytes) }) {
            return plain;
        }
        // The server's answer once more, before any segment.
        if matches!(plain, Command::BlockUploadInitiated { .. })
            && block.first_at.is_none()
            && self.pairing.last_response == Some(bytes)
        {
            return plain;
        }
        // Behind the last sub-block only segment 1 could come, if it was not the last one.
        if block.is_finished() && side == Side::Client && plain.is_initiate() && !plain.has_reserved_bits(bytes) {
            return plain;
        }
        // After the end, the answer to the request that the client sends once it has confirmed.
        if side == Side::Server && block.end.is_some() && plain.mux().is_some() && !plain.has_reserved_bits(bytes) {
            return plain;
        }
        // A client that starts anew in mid-transfer: only a read, whose bytes 4..7 are 0, can be told from data.
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
            transfer.initiated = Some(at);
            transfer.crc_negotiated = Some(crc);
            if size.is_some() {
                transfer.size_indicated = size;
            }
        }
        self.phase = Phase::Block(Box::new(Block::new(blksize)));
    }

    fn is_upload(&self) -> bool {
        self.transfer.as_ref().is_some_and(|transfer| transfer.direction == Direction::Upload)
    }

    /// The frame, or, where an empty one stands for the segment that is due, that segment: what it was is said already.
    fn unless_empty(&self, side: Side, half: &Half) -> Half {
        match &self.phase {
            Phase::Block(block) if half.len == 0 && self.sends_data(side) => {
                let segment = |seqno| Command::BlockSegment { seqno, last: false, data: [0; 7] };
                Half { command: block.unread().map_or(half.command, segment), ..*half }
            }
            _ => *half,
        }
    }

    /// Whether a frame of the server is due while sub-blocks run; `None` where it is no part of them.
    pub(super) fn is_due_in_block(&self, block: &Block, half: &Half) -> Option<bool> {
        let midway = self.transfer.as_ref().is_some_and(|transfer| transfer.mux.is_none());
        match half.command {
            Command::BlockSegment { .. } if midway && block.is_skipping() => {
                let plain = Half { command: wire::decode(Side::Server, half.bytes), ..*half };
                Some(!super::pairing::is_strict_answer(&plain))
            }
            Command::BlockSegment { seqno, .. } => Some(seqno != 1 || !block.owes_ack()),
            Command::EndBlock { .. } => Some(!block.owes_ack()),
            Command::BlockAck { ackseq, .. } => {
                Some(self.rejects_end() || !self.may_be_sent(block.not_seen(ackseq), half))
            }
            Command::BlockUploadInitiated { .. } => Some(block.end.is_none()),
            Command::BlockEnded if midway => Some(true),
            _ => None,
        }
    }

    /// Whether so many segments can have been sent before an acknowledgement, and be listed behind it.
    fn may_be_sent(&self, segments: u8, ack: &Half) -> bool {
        // The server's frames are listed in time, while the client's last one may be late itself.
        let heard = self.pairing.heard.map(|heard| heard.at);
        let since = heard.or(self.transfer.as_ref().map(|transfer| transfer.last)).and_then(|at| at.t_ns);
        let time = i64::from(segments) * SEGMENT_NS;
        let fits = |(since, now): (i64, i64)| now.saturating_sub(since) >= time;
        segments > 0 && since.zip(ack.at.t_ns).map_or(segments <= FRAMES, fits)
    }

    /// A client frame while sub-blocks run. Returns whether it was taken.
    pub(super) fn block_client(&mut self, half: &Half, cx: &mut Context<'_>) -> bool {
        let half = &self.unless_empty(Side::Client, half);
        if half.command.is_initiate() {
            return false;
        }
        if self.is_upload() {
            self.block_upload_client(half, cx);
            return true;
        }
        match half.command {
            Command::BlockSegment { .. } => {
                self.block_segment(half, cx);
                true
            }
            Command::EndBlock { .. } => self.end_block(half, cx),
            _ => {
                self.violation_outside(half, cx);
                true
            }
        }
    }

    fn block_upload_client(&mut self, half: &Half, cx: &mut Context<'_>) {
        let Phase::Block(block) = &mut self.phase else { return };
        match half.command {
            Command::StartBlockUpload if block.started => {
                self.step.place = Place::Repeated;
                let before = self.transfer.as_ref().map_or(half.at, |transfer| transfer.last);
                if cx.evidence.recording.is_sent_again(before, half.at) {
                    self.find(Code::Sdo015, before, cx);
                }
            }
            Command::StartBlockUpload => {
                block.started = true;
                if let Some(transfer) = &mut self.transfer {
                    transfer.last = half.at;
                }
            }
            Command::BlockAck { .. } => {
                if !std::mem::replace(&mut block.started, true) {
                    let first = block.first_at.unwrap_or(half.at);
                    self.find(Sdo002::NoRequest, first, cx);
                }
                self.acknowledge(half, cx);
            }
            Command::BlockEnded => {
                let midway = self.transfer.as_ref().is_none_or(|transfer| transfer.mux.is_none());
                let end = block.end;
                if midway && end.is_none() {
                    self.complete(Status::Incomplete, cx);
                } else if end.is_some() {
                    self.confirm_end(cx);
                } else if block.is_finished() {
                    let asked = self.transfer.as_ref().map_or(half.at, |transfer| transfer.last);
                    self.find(Sdo002::NoResponse, asked, cx);
                    self.complete(Status::Incomplete, cx);
                } else {
                    self.violation_outside(half, cx);
                }
            }
            // The confirmation, or an acknowledgement, of which nothing can be read.
            Command::Truncated(_) if block.is_finished() && block.end.is_some() => self.confirm_end(cx),
            Command::Truncated(_) => {
                self.ack_unread(cx);
            }
            _ => self.violation_outside(half, cx),
        }
    }

    /// A server frame while sub-blocks run. Returns whether it was taken.
    pub(super) fn block_server(&mut self, half: &Half, cx: &mut Context<'_>) -> bool {
        let half = &self.unless_empty(Side::Server, half);
        match half.command {
            Command::BlockSegment { .. } => {
                self.block_segment(half, cx);
                true
            }
            Command::EndBlock { .. } if self.is_upload() => self.end_block(half, cx),
            Command::Truncated(_) if self.is_upload() => self.end_unread(half),
            Command::Truncated(_) if self.pairing.pending.is_none() => self.ack_unread(cx),
            Command::BlockUploadInitiated { .. } => {
                self.step.place = Place::Outside;
                self.find(Sdo002::Duplicate, half.at, cx);
                true
            }
            Command::BlockAck { .. } if !self.is_upload() => {
                let Phase::Block(block) = &self.phase else { return false };
                if self.rejects_end() {
                    // It may do so again, whatever the client asks for next.
                    self.step.place = Place::Outside;
                    self.verdicts.odd_exchange.astray = true;
                } else if block.is_finished() {
                    self.violation_outside(half, cx);
                } else {
                    self.acknowledge(half, cx);
                }
                true
            }
            Command::BlockEnded
                if self.pairing.pending.is_none()
                    && self.transfer.as_ref().is_some_and(|transfer| transfer.mux.is_none()) =>
            {
                self.complete(Status::Incomplete, cx);
                true
            }
            _ => false,
        }
    }

    fn block_segment(&mut self, half: &Half, cx: &mut Context<'_>) {
        let Command::BlockSegment { seqno, last, data } = half.command else { return };
        let midway = self.transfer.as_ref().is_some_and(|transfer| transfer.mux.is_none());
        let Phase::Block(block) = &mut self.phase else { return };
        if block.is_finished() {
            if seqno != 1 || block.end.is_some() {
                self.step.place = Place::Outside;
                self.find(Sdo012::Outside, half.at, cx);
                self.instead_of_end(half);
                return;
            }
            let guessed = block.guessed;
            let marked = block.reopen().unwrap_or(half.at);
            if !guessed {
                self.find(Sdo012::Outside, marked, cx);
            }
        }
        let (Phase::Block(block), Some(transfer)) = (&mut self.phase, &mut self.transfer) else { return };
        self.step.ordinal = block.ordinal();
        let segment = Segment { seqno, last, data, len: half.len };
        let (taken, ack_missing) = block.segment(transfer, half.at, segment);
        let not_resent = block.take_not_resent();
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
            self.find(Sdo002::NotAcknowledged, due_since, cx);
        }
        if let Some((ack, ackseq)) = not_resent {
            self.find(Sdo012::NotResent { ackseq: ackseq.into() }, ack, cx);
        }
    }

    /// The end frame by the sender of the data. Returns whether it was taken: that of a download goes on as a
    /// request, which the server confirms.
    fn end_block(&mut self, half: &Half, cx: &mut Context<'_>) -> bool {
        let Command::EndBlock { unused, crc } = half.command else { return false };
        let upload = self.is_upload();
        let Phase::Block(block) = &mut self.phase else { return false };
        if !block.may_end() {
            let hole = self.transfer.as_ref().is_some_and(|transfer| transfer.hole);
            if block.last_was_sent() && !hole {
                let goes_on = self.transfer.as_mut().is_some_and(|transfer| block.finish_unacknowledged(transfer));
                self.find(Sdo012::EarlyEnd, half.at, cx);
                if !goes_on {
                    self.step.place = Place::Outside;
                    return true;
                }
            } else {
                let (newest, unsure) = (block.newest_at.unwrap_or(half.at), block.unsure);
                if let Some(transfer) = &mut self.transfer {
                    block.finish_early(transfer);
                }
                // Where segments are missing, the last one is among them, and it was said.
                if !hole && !unsure {
                    self.find(Sdo012::NoLast, newest, cx);
                    if !upload {
                        // What the server makes of it only follows.
                        self.unanswerable(half);
                    }
                }
            }
        }
        let Phase::Block(block) = &mut self.phase else { return false };
        if upload && block.end.is_some() {
            self.step.place = Place::Outside;
            self.find(Sdo002::Duplicate, half.at, cx);
            return true;
        }
        if block.owes_ack() || (!upload && !block.is_finished()) {
            let due_since = block.due_since().unwrap_or(half.at);
            self.find(Sdo002::NotAcknowledged, due_since, cx);
            self.settle_without_ack();
        }
        let Phase::Block(block) = &mut self.phase else { return upload };
        if upload {
            block.end = Some(End { at: half.at, unused, crc: (half.len > 2).then_some(crc) });
            if block.is_finished() {
                self.judge_end(cx);
            }
        }
        upload
    }

    /// A frame of which nothing can be read, where the end of an upload is due: how much of the last segment is data is
    /// not known. Returns whether it was.
    fn end_unread(&mut self, half: &Half) -> bool {
        let (Phase::Block(block), Some(transfer)) = (&mut self.phase, &mut self.transfer) else { return false };
        let due = block.may_end() && block.end.is_none();
        if due {
            transfer.hole = true;
            block.end = Some(End { at: half.at, unused: 0, crc: None });
        }
        due
    }

    /// A frame of which nothing can be read, where an acknowledgement is due. Returns whether it was.
    fn ack_unread(&mut self, cx: &mut Context<'_>) -> bool {
        let (Phase::Block(block), Some(transfer)) = (&mut self.phase, &mut self.transfer) else { return false };
        let due = block.ack_unread(transfer);
        if due && block.is_finished() {
            self.judge_end(cx);
        }
        due
    }

    fn settle_without_ack(&mut self) {
        if let (Phase::Block(block), Some(transfer)) = (&mut self.phase, &mut self.transfer) {
            block.settle_whole(transfer);
        }
    }

    fn acknowledge(&mut self, half: &Half, cx: &mut Context<'_>) {
        let Command::BlockAck { ackseq, blksize } = half.command else { return };
        let (Phase::Block(block), Some(transfer)) = (&mut self.phase, &mut self.transfer) else { return };
        if block.is_finished() {
            self.violation_outside(half, cx);
            return;
        }
        let acked = block.ack(transfer, half.at, ackseq, blksize);
        transfer.last = half.at;
        transfer.bad |= matches!(acked.fault, Some((Sdo012::Sequence { .. } | Sdo012::Acknowledged { .. }, _)));
        if acked.retransmission {
            transfer.retransmissions = transfer.retransmissions.saturating_add(1);
        }
        let (finished, end, not_resent) = (block.is_finished(), block.end, block.take_not_resent());
        if let Some((ack, ackseq)) = not_resent {
            self.find(Sdo012::NotResent { ackseq: ackseq.into() }, ack, cx);
        }
        if let Some((what, cause)) = acked.fault {
            self.find(what, cause.unwrap_or(half.at), cx);
        }
        match end {
            Some(_) if finished => self.judge_end(cx),
            Some(end) => {
                self.find(Sdo012::EarlyEnd, end.at, cx);
                if let Phase::Block(block) = &mut self.phase {
                    block.end = None;
                }
            }
            None => {}
        }
    }

    /// Size and CRC, once the end frame is seen and all segments are acknowledged.
    fn judge_end(&mut self, cx: &mut Context<'_>) {
        let (Phase::Block(block), Some(transfer)) = (&mut self.phase, &mut self.transfer) else { return };
        let Some(end) = block.end else { return };
        let padding = block.close(transfer, end.unused);
        if transfer.hole || transfer.mux.is_none() {
            return;
        }
        let right = transfer.size_is_right();
        if block.unsure && !(right && end.crc.is_none_or(|found| transfer.check_crc(found, &[]).0 == found)) {
            transfer.hole = true;
            return;
        }
        if !right {
            block.bad = true;
            let cause = transfer.initiated.unwrap_or(end.at);
            let size = wrong_size(transfer);
            self.find(size, if end.at.no == cx.at.no { cause } else { end.at }, cx);
            return;
        }
        if let (Some(true), Some(found)) = (transfer.crc_negotiated, end.crc) {
            let padding = padding.get(..usize::from(end.unused.min(7))).unwrap_or(&[]);
            let (computed, matches) = transfer.check_crc(found, padding);
            if computed != found {
                block.bad = true;
                self.find(Sdo019::Crc { computed, found, matches }, end.at, cx);
            }
        }
    }

    fn confirm_end(&mut self, cx: &mut Context<'_>) {
        let bad = matches!(&self.phase, Phase::Block(block) if block.bad);
        let status = match &self.transfer {
            _ if bad => Status::Failed,
            Some(transfer) if transfer.bad => Status::Failed,
            Some(transfer) if transfer.hole || transfer.midway => Status::Incomplete,
            _ => Status::Ok,
        };
        self.complete(status, cx);
    }

    fn put_end(&mut self, half: &Half) {
        if let (Phase::Block(block), Command::EndBlock { unused, crc }) = (&mut self.phase, half.command) {
            block.end = Some(End { at: half.at, unused, crc: (half.len > 2).then_some(crc) });
        }
    }

    /// The end of a download, confirmed by the server.
    pub(super) fn end_block_download(&mut self, end: Half, cx: &mut Context<'_>) {
        self.put_end(&end);
        self.judge_end(cx);
        self.confirm_end(cx);
    }

    /// The end of a download, which the server answered with an abort.
    pub(super) fn judge_refused_end(&mut self, end: Half, cx: &mut Context<'_>) {
        self.put_end(&end);
        self.judge_end(cx);
    }

    /// Whether an acknowledgement comes instead of the confirmation of an end before which no segment was marked as the
    /// last one: the server still waits for that.
    fn rejects_end(&self) -> bool {
        matches!(&self.phase, Phase::Block(block) if !block.last_was_sent())
            && self.pairing.pending.is_some_and(|pending| self.is_unanswerable(&pending))
    }

    /// The end of a download, after which the client went on without the server's confirmation.
    pub(super) fn end_unconfirmed(&mut self, end: Half, cx: &mut Context<'_>) {
        self.put_end(&end);
        let unanswerable = self.is_unanswerable(&end);
        let own = std::mem::replace(&mut self.own, false);
        match &mut self.phase {
            // The server was not told which segment is the last one: it had no reason to take what it has.
            Phase::Block(block) if unanswerable && !block.last_was_sent() => block.bad = true,
            _ => self.judge_end(cx),
        }
        self.confirm_end(cx);
        self.own = own;
    }

    /// An upload whose end the client did not confirm before it went on. Returns whether it was one.
    pub(super) fn leave_ended_block(&mut self, cx: &mut Context<'_>) -> bool {
        let Phase::Block(block) = &self.phase else { return false };
        let (Some(end), true) = (block.end, block.is_finished()) else { return false };
        self.find(Sdo012::EndNotConfirmed, end.at, cx);
        let own = std::mem::replace(&mut self.own, false);
        self.confirm_end(cx);
        self.own = own;
        true
    }

    /// The capture ends long after the end frame of an upload, and nothing confirmed it.
    pub(super) fn judge_unconfirmed_end(&mut self, cx: &mut Context<'_>) {
        if let Phase::Block(block) = &self.phase
            && let Some(end) = block.end
        {
            self.find(Sdo012::EndNotConfirmed, end.at, cx);
        }
    }

    /// The client has waited in vain for what the server owes while sub-blocks run: an acknowledgement, or segments.
    pub(super) fn judge_stalled_block(&mut self, cx: &mut Context<'_>) {
        let Phase::Block(block) = &self.phase else { return };
        let Some(transfer) = self.transfer.as_ref().filter(|transfer| transfer.mux.is_some() && !transfer.hole) else {
            return;
        };
        if block.wrong().is_some() || block.end.is_some() || self.pairing.pending.is_some() {
            return;
        }
        let asked = transfer.last;
        match block.due_since().filter(|_| block.owes_ack()) {
            Some(due_since) if !self.is_upload() => self.find(Sdo002::NotAcknowledged, due_since, cx),
            None if self.is_upload() && block.started => {
                self.find(Sdo002::NoResponse, asked, cx);
            }
            _ => {}
        }
    }

    /// A block transfer is aborted: was a segment out of sequence before?
    pub(super) fn judge_aborted_block(&mut self, cx: &mut Context<'_>) {
        if let Phase::Block(block) = &self.phase
            && let Some((what, at)) = block.wrong()
        {
            self.find(what, at, cx);
        }
    }

    /// The number in the acknowledgement that the client owes.
    pub(super) fn owed_ack(&self) -> Option<u8> {
        match &self.phase {
            Phase::Block(block) if self.is_upload() => block.owed_ack(),
            _ => None,
        }
    }

    /// The next sequence number of the side that sends the data; 0 outside block transfers.
    pub(super) fn block_seqno(&self, side: Side) -> u8 {
        match &self.phase {
            Phase::Block(block) if self.sends_data(side) => block.expected(),
            _ => 0,
        }
    }
}

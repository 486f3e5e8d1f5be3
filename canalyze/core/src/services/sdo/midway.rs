//! Transfers met in their midst: a capture begins, or goes on after lost frames, between any two frames.
//!
//! Until the channel's first whole transfer, nothing here is a violation, and nothing is taken for what it may not
//! be: a block segment can look like any command. What was cut is incomplete.

use super::block::{Block, MOST};
use super::channel::{Channel, Half, Outside, Phase, strict_initiate};
use super::transfer::{Direction, Mode, Transfer};
use super::waiting::Held;
use super::wire::{self, Command, Side};
use crate::context::Context;
use crate::event::Place;
use crate::frame::FrameRef;

impl Channel {
    /// A transfer met in its midst: its initiate request is not in the capture.
    pub(super) fn begin_midway(&mut self, at: FrameRef, direction: Direction, phase: Phase, cx: &mut Context<'_>) {
        let mode = if matches!(phase, Phase::Block(_)) { Mode::Block } else { Mode::Segmented };
        let id = self.next_id(cx);
        let mut transfer = Box::new(Transfer::new(self.beginning(id, at, cx), direction, mode, None));
        transfer.midway = true;
        self.transfer = Some(transfer);
        self.phase = phase;
    }

    /// What was seen so far belonged to a transfer that began before the capture.
    pub(super) fn forget_beginning(&mut self) {
        self.transfer = None;
        self.phase = Phase::Idle;
        self.outside = Outside::Uncaptured;
        self.pairing.pending = None;
        if !self.trusted {
            self.withheld.clear();
            self.begun = false;
        }
    }

    /// The channel's first frame is a request and a response of its kind was held, since its own request might
    /// still have come: it has not, so it is the answer after all, though for another object or toggle bit.
    /// Returns the client's next frame as it is read after that.
    pub(super) fn answer_edge(&mut self, half: Half, cx: &mut Context<'_>) -> Half {
        let (Some(pending), Some(held)) = (self.pairing.pending, self.pairing.held) else { return half };
        let late = wire::fits(&half.command, &held.half.command);
        if late || !strict_initiate(&pending) || !wire::kind_fits(&pending.command, &held.half.command) {
            return half;
        }
        self.pairing.held = None;
        self.begun = true;
        let own = std::mem::replace(&mut self.own, false);
        self.answer(pending, held.half, cx);
        self.own = own;
        Half { command: self.decode(Side::Client, half.bytes, half.len), ..half }
    }

    /// The capture is over, and the channel has shown one request and one response of its kind, nothing else.
    pub(super) fn answer_only_request(&mut self, cx: &mut Context<'_>) {
        if self.requests != 1 || self.responses != 1 {
            return;
        }
        let (Some(pending), Some(held)) = (self.pairing.pending, self.pairing.held) else { return };
        if strict_initiate(&pending) && wire::kind_fits(&pending.command, &held.half.command) {
            self.pairing.held = None;
            self.begun = true;
            self.answer(pending, held.half, cx);
        }
    }

    /// An initiate response without its request, and the client goes on as if it had asked: it had. Returns whether a
    /// transfer begins so.
    pub(super) fn begin_from_response(&mut self, response: &Half, next: &Half, cx: &mut Context<'_>) -> bool {
        if self.transfer.is_some() {
            return false;
        }
        let [first, ..] = next.bytes;
        let (direction, phase, size) = match (response.command, next.command) {
            (Command::UploadInitiated(_, i), Command::SegmentRequest { toggle }) if !i.expedited => {
                (Direction::Upload, Phase::Segments { toggle }, i.size())
            }
            (Command::DownloadInitiated(_), Command::Segment(segment)) => {
                (Direction::Download, Phase::Segments { toggle: segment.toggle }, None)
            }
            (Command::BlockUploadInitiated { size, .. }, Command::StartBlockUpload) => {
                (Direction::Upload, Phase::Block(Box::new(Block::new(MOST))), size)
            }
            (Command::BlockDownloadInitiated { blksize, .. }, _) if first & 0x7F == 1 => {
                (Direction::Download, Phase::Block(Box::new(Block::new(blksize))), None)
            }
            _ => return false,
        };
        self.begin_midway(response.at, direction, phase, cx);
        if let Some(transfer) = &mut self.transfer {
            transfer.mux = response.command.mux();
            transfer.size_indicated = size;
            transfer.initiated = Some(response.at);
        }
        self.outside = Outside::Violation;
        true
    }

    /// A client frame that belongs to no open transfer.
    pub(super) fn stray(&mut self, half: &Half, cx: &mut Context<'_>) {
        if self.outside == Outside::Uncaptured {
            self.step.place = Place::Uncaptured;
            if self.join_segments(half, cx) {
                self.pairing.pending = Some(*half);
            } else if half.command == Command::StartBlockUpload && self.transfer.is_none() {
                let mut block = Block::new(MOST);
                block.started = true;
                self.begin_midway(half.at, Direction::Upload, Phase::Block(Box::new(block)), cx);
            } else if matches!(half.command, Command::BlockAck { .. }) {
                self.join_block(half, Direction::Upload, cx);
            }
            return;
        }
        self.violation_outside(half, cx);
        self.pairing.stray = Some(*half);
    }

    /// A segment, or a request for one, of a transfer that began before the capture.
    pub(super) fn join_segments(&mut self, half: &Half, cx: &mut Context<'_>) -> bool {
        let (direction, toggle) = match half.command {
            Command::SegmentRequest { toggle } => (Direction::Upload, toggle),
            Command::Segment(segment) => (Direction::Download, segment.toggle),
            _ => return false,
        };
        if self.outside != Outside::Uncaptured || self.transfer.is_some() {
            return false;
        }
        self.begin_midway(half.at, direction, Phase::Segments { toggle }, cx);
        true
    }

    /// In the midst of a block upload that began before the capture, a frame by the server may still be the answer
    /// to a late initiate request.
    pub(super) fn hold_midway(&mut self, half: &Half) {
        let half = Half { command: wire::decode(Side::Server, half.bytes), ..*half };
        self.pairing.held = Some(Held { half, first: true, rival: false });
    }

    /// Whether a request is the channel's first frame: its answer may lie before the capture.
    pub(super) fn is_edge(&self, request: &Half) -> bool {
        self.pairing.first == Some(request.at.no)
    }

    /// An acknowledgement without a transfer, at the beginning of the capture: a block transfer is under way.
    pub(super) fn join_block(&mut self, half: &Half, direction: Direction, cx: &mut Context<'_>) {
        let Command::BlockAck { ackseq, blksize } = half.command else { return };
        if ackseq <= MOST && (1..=MOST).contains(&blksize) && !half.command.has_reserved_bits(half.bytes) {
            self.paired = true;
            self.begin_midway(half.at, direction, Phase::Block(Box::new(Block::midway())), cx);
        }
    }

    /// Whether two client frames in a row, before any valid exchange, are segments of a block download that began
    /// before the capture: their first bytes count up.
    pub(super) fn is_midway_block(&self, before: &Half, half: &Half) -> bool {
        !self.is_trusted() && before.bytes[0] < MOST && before.bytes[0] + 1 == half.bytes[0] & 0x7F
    }

    pub(super) fn begin_midway_block(&mut self, half: &Half, cx: &mut Context<'_>) {
        self.step.place = Place::Uncaptured;
        self.outside = Outside::Uncaptured;
        let block = Phase::Block(Box::new(Block::midway()));
        self.begin_midway(half.at, Direction::Download, block, cx);
    }
}

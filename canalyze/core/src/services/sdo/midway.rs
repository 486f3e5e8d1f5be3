//! Transfers met in their midst: a capture begins, or goes on after lost frames, between any two frames.
//!
//! Until the channel's first whole transfer, nothing here is a violation, and nothing is taken for what it may not
//! be: a block segment can look like any command. What was cut is incomplete.

use super::block::{Block, MOST};
use super::channel::{Channel, Half, Outside, Phase};
use super::transfer::{Direction, Mode, Transfer};
use super::wire::Command;
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
        if !self.proof.trusted {
            self.verdicts.withheld.clear();
            self.proof.begun = false;
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

    /// Whether a client frame may be a segment, or a request for one, of a transfer that began before the capture.
    pub(super) fn may_join(&self, half: &Half) -> bool {
        self.outside == Outside::Uncaptured
            && self.transfer.is_none()
            && matches!(half.command, Command::SegmentRequest { .. } | Command::Segment(_))
    }

    fn join_segments(&mut self, half: &Half, cx: &mut Context<'_>) -> bool {
        let (direction, toggle) = match half.command {
            Command::SegmentRequest { toggle } => (Direction::Upload, toggle),
            Command::Segment(segment) => (Direction::Download, segment.toggle),
            _ => return false,
        };
        let joins = self.may_join(half);
        if joins {
            self.begin_midway(half.at, direction, Phase::Segments { toggle }, cx);
        }
        joins
    }

    /// Whether a request is the channel's first frame: its answer may lie before the capture.
    pub(super) fn is_edge(&self, request: &Half) -> bool {
        self.pairing.first == Some(request.at.no)
    }

    /// An acknowledgement without a transfer, at the beginning of the capture: a block transfer is under way.
    pub(super) fn join_block(&mut self, half: &Half, direction: Direction, cx: &mut Context<'_>) {
        let Command::BlockAck { ackseq, blksize } = half.command else { return };
        if ackseq <= MOST && (1..=MOST).contains(&blksize) && !half.command.has_reserved_bits(half.bytes) {
            self.proof.paired = true;
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

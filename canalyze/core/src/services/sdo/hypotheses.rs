//! What a channel may be in the midst of where the capture begins, or goes on after lost frames.
//!
//! Until the channel's first whole transfer several hypotheses stand: it is idle, a segmented transfer runs, a block
//! transfer runs. While they do, nothing is a violation and nothing is a value: a block segment can look like any
//! command. A transfer whose beginning is not in the capture is incomplete.

use super::block::{Block, MOST};
use super::channel::{Channel, strict_initiate};
use super::machine::{Action, State, transition};
use super::phase::{Half, Phase, Segments};
use super::sequence::is_strict_answer;
use super::transfer::{Direction, Mode, Status, Transfer};
use super::wire::{self, Command, Mux, Side};
use crate::context::Context;
use crate::event::Place;
use crate::frame::{Frame, FrameRef};
use crate::profiles::Profile;
use crate::rules::sdo::Sdo024;

/// Whether anything but idleness is possible.
#[derive(Debug)]
pub(super) struct Hypotheses {
    open: bool,
    /// Number of the channel's first frame, or of the first since frames were lost.
    first: Option<u64>,
    /// The capture shows the channel from its first frame on.
    whole: bool,
    /// A frame that belongs to no transfer was reported since the channel was idle.
    reported: bool,
    /// The frame before: who sent it, its first byte, and whether it is known to be no segment of a block.
    before: Option<(Side, u8, bool)>,
}

impl Default for Hypotheses {
    fn default() -> Self {
        Self { open: true, first: None, whole: false, reported: false, before: None }
    }
}

impl Hypotheses {
    /// Whether a transfer may run that the capture does not show from its beginning.
    pub(super) fn are_open(&self) -> bool {
        self.open
    }

    /// All hypotheses stand again.
    pub(super) fn open(&mut self) {
        (self.open, self.reported) = (true, false);
    }

    /// No transfer runs but one that the capture shows.
    pub(super) fn settle(&mut self) {
        (self.open, self.reported) = (false, false);
    }

    /// The same; that frames belong to no transfer was reported.
    pub(super) fn report(&mut self) {
        (self.open, self.reported) = (false, true);
    }

    /// Whether it was reported that frames belong to no transfer.
    pub(super) fn is_reported(&self) -> bool {
        self.reported
    }

    /// What comes first does not belong to what came before the capture.
    pub(super) fn begin_whole(&mut self) {
        self.whole = true;
    }

    /// Whether the capture shows the channel from its first frame on.
    pub(super) fn is_whole(&self) -> bool {
        self.whole
    }

    /// Whether this frame is the first one, behind which something may be cut off.
    pub(super) fn is_first(&mut self, no: u64) -> bool {
        !self.whole && *self.first.get_or_insert(no) == no
    }

    /// Whether another frame than this one was the first.
    pub(super) fn is_later(&self, no: u64) -> bool {
        self.whole || self.first.is_some_and(|first| first != no)
    }
}

impl Channel {
    /// Whether what its next frame is may show only by the one behind it: a transfer may run that began before the
    /// capture, or of which the capture shows one side only; or it has no place where the channel stands.
    pub fn is_ambiguous(&self, side: Side, frame: &Frame) -> bool {
        self.is_midway() || self.has_no_place(side, frame)
    }

    /// Whether the channel may be in the midst of anything.
    fn is_midway(&self) -> bool {
        match &self.phase {
            Phase::Idle => self.hypotheses.open && (!self.hypotheses.whole || self.is_one_sided()),
            Phase::Initiated(request) => self.is_edge(request),
            Phase::Segments(_) => false,
            Phase::Block(..) => self.is_nameless(),
        }
    }

    /// Whether a frame is no part of what runs on a channel that is known, nor a request that some stack would send.
    fn has_no_place(&self, side: Side, frame: &Frame) -> bool {
        // What follows a fault, or an abort, belongs to that.
        let waits = self.sequence.under_way.is_some() || self.sequence.is_waiting() || self.hypotheses.reported;
        if waits || self.hypotheses.open || !self.proof.trusted || frame.len != 8 {
            return false;
        }
        let (state, bytes) = (self.state(), frame.head());
        let command = self.decode(side, bytes, frame.len);
        if let (Command::BlockSegment { seqno, .. }, Some(block)) = (command, self.block()) {
            return block.is_off(seqno);
        }
        let odd = state == State::Idle && command.has_reserved_bits(bytes);
        let action = transition(state, side, &command).action;
        odd || matches!(action, Action::Stray | Action::Outside | Action::Misfit | Action::Unasked)
    }

    /// Whether requests were seen, more than the one that may still be answered, and no response.
    pub fn is_unanswered(&self) -> bool {
        self.proof.responses == 0 && self.proof.requests > 1
    }

    /// Whether only requests, or only responses, are in the capture.
    pub(super) fn is_one_sided(&self) -> bool {
        (self.proof.requests == 0) != (self.proof.responses == 0)
    }

    /// Whether nothing was seen of the channel before that could be another reading of its frame.
    fn is_alone(&self) -> bool {
        self.hypotheses.whole && self.hypotheses.before.is_none()
    }

    /// How the next frame is read where it is ambiguous.
    pub(super) fn reading(&mut self, side: Side, frame: &Frame, next: Option<&(Side, Frame)>) -> Option<Command> {
        let [first, ..] = frame.head();
        let reading = if self.is_midway() {
            Some(self.read_open(side, frame, next))
        } else {
            self.read_elsewhere(side, frame, next)
        };
        let plain = !matches!(reading, Some(Command::BlockSegment { .. } | Command::Undetermined(_)));
        self.hypotheses.before = Some((side, first, plain && self.block().is_none()));
        reading
    }

    /// A block transfer met in its midst has ended unseen where a frame does not belong to it.
    pub(super) fn leave_midway(&mut self, side: Side, half: &Half, cx: &mut Context<'_>) {
        let sends = self.sends_data(side);
        let belongs = |block: &Block| match half.reading {
            Some(reading) if !sends => reading.is_of_receiver(),
            Some(reading) => block.end.is_none() && (reading.is_of_sender() || !block.is_off(half.bytes[0] & 0x7F)),
            None => true,
        };
        if self.is_nameless() && self.block().is_some_and(|block| !belongs(block)) {
            self.complete_before(Status::Incomplete, cx);
            self.hypotheses.open();
        }
    }

    /// How a frame is read while the channel may be in the midst of anything: by its command byte, as a segment of a
    /// block transfer, or not at all. The frames before and behind it tell.
    fn read_open(&self, side: Side, frame: &Frame, next: Option<&(Side, Frame)>) -> Command {
        let bytes = frame.head();
        let plain = wire::decode_frame(side, bytes, frame.len);
        let before = self.hypotheses.before;
        if frame.len != 8 || bytes[0] & 0x7F == 0 || matches!(plain, Command::Abort(..)) {
            return plain;
        }
        let next = next.map(|(by, next)| (*by, next.head(), wire::decode_frame(*by, next.head(), next.len)));
        let block = is_segment(side, bytes[0], before, next.as_ref());
        // One neighbour alone may count up by chance.
        let weak = is_segment(side, bytes[0], None, next.as_ref()) != Some(true)
            || is_segment(side, bytes[0], before, None) != Some(true);
        let half = Half { command: plain, ..Half::of(bytes) };
        let request = weak && side == Side::Client && strict_initiate(&half) && plain.mux().is_some_and(is_usable);
        let answer = side == Side::Client && self.sequence.holds_answer(&plain);
        let fits = answer || next.is_some_and(|(by, next, other)| by != side && follows(&plain, &other, next[0]));
        let sound = !plain.is_unreadable() && !plain.has_reserved_bits(bytes);
        match block {
            // An answer that names the object is no coincidence.
            _ if fits && (block != Some(true) || plain.mux().is_some()) => plain,
            Some(true) if !request => wire::block_segment(bytes),
            Some(false) if sound && plain.mux().is_none_or(is_usable) => plain,
            None if sound && (self.is_alone() || is_unlike_data(side, &plain, bytes)) => plain,
            _ => Command::Undetermined(bytes),
        }
    }

    /// How a frame is read that has no place where the channel stands, but agrees with the next one: both sides are
    /// elsewhere.
    fn read_elsewhere(&self, side: Side, frame: &Frame, next: Option<&(Side, Frame)>) -> Option<Command> {
        let (by, next) = next.filter(|_| self.has_no_place(side, frame))?;
        let bytes = frame.head();
        let plain = wire::decode_frame(side, bytes, frame.len);
        let other = wire::decode_frame(*by, next.head(), next.len);
        let odd = plain.has_reserved_bits(bytes) || other.has_reserved_bits(next.head());
        if self.block().is_some() && self.sends_data(side) {
            // Data may look like anything, but not together with a response that names the object.
            let answered = *by != side && !odd && plain.is_initiate() && other.mux().is_some();
            return (answered && wire::may_answer(&plain, &other)).then_some(plain);
        }
        if *by != side && !odd && !self.is_of_kind(&plain) && goes_on(&plain, &other, next.head()[0]) {
            return Some(plain);
        }
        let segment = is_segment(side, bytes[0], None, Some(&(*by, next.head(), other))) == Some(true);
        segment.then(|| wire::block_segment(bytes))
    }

    /// Whether a frame is of a kind that the transfer consists of, or about its object. Where none runs, a response that
    /// names its object begins one without its request.
    fn is_of_kind(&self, plain: &Command) -> bool {
        use Command as C;
        let object = self.transfer.as_ref().and_then(|transfer| transfer.mux);
        match &self.phase {
            Phase::Idle => plain.mux().is_some(),
            _ if plain.mux().is_some() && plain.mux() == object => true,
            Phase::Initiated(request) => wire::kind_fits(&request.command, plain),
            Phase::Segments(_) => {
                matches!(plain, C::Segment(_) | C::SegmentRequest { .. } | C::SegmentResponse { .. })
            }
            Phase::Block(..) => plain.is_of_sender() || plain.is_of_receiver(),
        }
    }

    /// A frame that has no place where the channel stood, and agrees with the next one, shows that the recording lost
    /// what lies between. Nothing before it tells any more, as behind a gap that is announced.
    pub(super) fn leave_behind(&mut self, half: &Half, cx: &mut Context<'_>) {
        if half.reading.is_some() && !self.is_midway() {
            self.find(Sdo024::Elsewhere, half.at, cx);
            self.lost(false, cx);
        }
    }

    /// Whether a request is the channel's first frame: its response may lie before the capture.
    pub(super) fn is_edge(&self, request: &Half) -> bool {
        !self.hypotheses.whole && self.hypotheses.first == Some(request.at.no)
    }

    /// A transfer met in its midst: its initiate request is not in the capture.
    fn begin_midway(&mut self, at: FrameRef, direction: Direction, phase: Phase, cx: &mut Context<'_>) {
        let mode = if matches!(phase, Phase::Block(..)) { Mode::Block } else { Mode::Segmented };
        let id = self.next_id(cx);
        let mut transfer = Box::new(Transfer::new(self.beginning(id, at, cx), direction, mode, None));
        transfer.outcome.midway = true;
        transfer.miss_beginning();
        self.transfer = Some(transfer);
        self.phase = phase;
    }

    /// What was seen so far belonged to a transfer that began before the capture.
    pub(super) fn forget_beginning(&mut self) {
        self.verdicts.drop_doubts();
        self.transfer = None;
        self.phase = Phase::Idle;
        self.hypotheses.open();
        if !self.proof.trusted {
            self.verdicts.withheld.clear();
            self.proof.begun = false;
        }
    }

    /// An initiate response without its request, and the client goes on as if it had sent one. Returns whether a
    /// transfer begins so.
    pub(super) fn begin_from_response(&mut self, response: &Half, next: &Half, cx: &mut Context<'_>) -> bool {
        if self.transfer.is_some() {
            return false;
        }
        let [first, ..] = next.bytes;
        let (direction, phase, size) = match (response.command, next.command) {
            (Command::UploadInitiated(_, i), Command::SegmentRequest { toggle }) if !i.expedited => {
                (Direction::Upload, Phase::Segments(Segments::from(toggle)), i.size())
            }
            (Command::DownloadInitiated(_), Command::Segment(segment)) => {
                (Direction::Download, Phase::Segments(Segments::from(segment.toggle)), None)
            }
            (Command::BlockUploadInitiated { size, .. }, Command::StartBlockUpload) => {
                (Direction::Upload, Phase::Block(Box::new(Block::new(0)), None), size)
            }
            (Command::BlockDownloadInitiated { blksize, .. }, _) if first & 0x7F == 1 => {
                (Direction::Download, Phase::Block(Box::new(Block::new(blksize)), None), None)
            }
            _ => return false,
        };
        self.begin_midway(response.at, direction, phase, cx);
        if let Some(transfer) = &mut self.transfer {
            transfer.mux = response.command.mux();
            transfer.data.size_indicated = size;
            transfer.data.initiated = Some(response.at);
            if !matches!(&self.phase, Phase::Segments(segments) if segments.toggle) {
                transfer.begin_with_first();
            }
        }
        self.hypotheses.settle();
        true
    }

    /// A frame that may belong to a transfer that began before the capture.
    pub(super) fn join(&mut self, side: Side, half: &Half, cx: &mut Context<'_>) {
        self.step.place = Place::Uncaptured;
        if matches!(half.command, Command::BlockSegment { .. }) {
            let direction = if side == Side::Client { Direction::Download } else { Direction::Upload };
            self.begin_midway(half.at, direction, Phase::Block(Box::new(Block::midway()), None), cx);
            self.block_segment(half, cx);
        } else if self.may_join(half) {
            let (direction, toggle) = match half.command {
                Command::Segment(segment) => (Direction::Download, segment.toggle),
                Command::SegmentRequest { toggle } => (Direction::Upload, toggle),
                _ => return,
            };
            let segments = Segments { asked: Some(*half), ..Segments::from(toggle) };
            self.begin_midway(half.at, direction, Phase::Segments(segments), cx);
        } else if half.command == Command::StartBlockUpload && self.transfer.is_none() {
            let mut block = Block::new(0);
            block.started = true;
            self.begin_midway(half.at, Direction::Upload, Phase::Block(Box::new(block), None), cx);
        } else if matches!(half.command, Command::BlockAck { .. }) {
            self.join_block(half, Direction::Upload, cx);
        }
    }

    /// Whether a client frame may be a segment, or a request for one, of a transfer that began before the capture.
    pub(super) fn may_join(&self, half: &Half) -> bool {
        self.hypotheses.open
            && self.transfer.is_none()
            && matches!(half.command, Command::SegmentRequest { .. } | Command::Segment(_))
    }

    /// An acknowledgement without a transfer, at the beginning of the capture: a block transfer runs.
    pub(super) fn join_block(&mut self, half: &Half, direction: Direction, cx: &mut Context<'_>) {
        let Command::BlockAck { ackseq, blksize } = half.command else { return };
        let valid = ackseq <= MOST && (1..=MOST).contains(&blksize) && !half.command.has_reserved_bits(half.bytes);
        if valid && self.hypotheses.open {
            self.proof.paired = true;
            self.begin_midway(half.at, direction, Phase::Block(Box::new(Block::midway()), None), cx);
        }
    }

    /// Whether two client frames in a row, before any valid exchange, are segments of a block download that began
    /// before the capture: their first bytes count up.
    pub(super) fn is_midway_block(&self, before: &Half, half: &Half) -> bool {
        !self.proof.trusted && before.bytes[0] < MOST && before.bytes[0] + 1 == half.bytes[0] & 0x7F
    }

    pub(super) fn begin_midway_block(&mut self, half: &Half, cx: &mut Context<'_>) {
        self.step.place = Place::Uncaptured;
        self.hypotheses.open();
        self.begin_midway(half.at, Direction::Download, Phase::Block(Box::new(Block::midway()), None), cx);
    }
}

/// Whether a frame is a segment of a block transfer, by the frames of its channel before and behind it: their numbers
/// count up, and the receiver acknowledges the last one. `None`: they do not tell.
fn is_segment(
    side: Side,
    first: u8,
    before: Option<(Side, u8, bool)>,
    next: Option<&(Side, [u8; 8], Command)>,
) -> Option<bool> {
    let (seqno, last) = (first & 0x7F, first & 0x80 != 0);
    if seqno == 0 {
        return Some(false);
    }
    let counts = |(_, before, plain): (Side, u8, bool)| !plain && before < MOST && before + 1 == seqno;
    let goes_on = before.filter(|(by, ..)| *by == side).map(counts);
    let ends = next.map(|(by, bytes, other)| match other {
        Command::Abort(..) => None,
        _ if *by == side => Some(!last && bytes[0] & 0x7F == seqno + 1),
        Command::BlockAck { ackseq, blksize } if (1..=MOST).contains(blksize) && !other.has_reserved_bits(*bytes) => {
            (*ackseq == seqno).then_some(true)
        }
        Command::StartBlockUpload if seqno == 1 => Some(true),
        _ => Some(false),
    });
    // Behind the acknowledgement, which may not be recorded, numbers begin again.
    let begins = next.is_some_and(|(by, bytes, _)| *by == side && bytes[0] & 0x7F == 1);
    match (goes_on, ends.flatten()) {
        (Some(true), _) | (_, Some(true)) => Some(true),
        (_, Some(false)) if !begins => Some(false),
        (Some(false), _) if seqno != 1 => Some(false),
        _ => None,
    }
}

/// Whether the other side's next frame, with this first byte, is what follows a frame: its answer, the request that it
/// answers and that is listed late, or what the other side sends next.
fn follows(plain: &Command, other: &Command, first: u8) -> bool {
    wire::may_answer(plain, other) || wire::may_answer(other, plain) || goes_on(plain, other, first)
}

/// Whether the other side's next frame, with this first byte, is its answer to a request for a segment, or to one, or what
/// it sends next.
fn goes_on(plain: &Command, other: &Command, first: u8) -> bool {
    use Command as C;
    let answers = !plain.is_initiate() && !matches!(other, C::Abort(..)) && wire::fits(plain, other);
    answers
        || match (plain, other) {
            (C::UploadInitiated(_, i), C::SegmentRequest { toggle }) => !i.expedited && !toggle,
            (C::Segment(segment), C::SegmentRequest { toggle }) => segment.toggle != *toggle,
            (C::SegmentResponse { toggle }, C::Segment(segment)) => segment.toggle != *toggle,
            (C::DownloadInitiated(_), C::Segment(segment)) => !segment.toggle,
            (C::BlockUploadInitiated { .. }, C::StartBlockUpload) | (C::EndBlock { .. }, C::BlockEnded) => true,
            (C::BlockDownloadInitiated { .. } | C::StartBlockUpload, _) => first & 0x7F == 1,
            (C::BlockAck { .. }, C::EndBlock { .. }) => true,
            (C::BlockAck { .. }, _) => first & 0x7F == 1,
            _ => false,
        }
}

/// Whether bytes are hardly data that happen to look like a command: they name an object, and others of them that have
/// to be 0 are.
fn is_unlike_data(side: Side, plain: &Command, bytes: [u8; 8]) -> bool {
    let half = Half { command: *plain, ..Half::of(bytes) };
    match plain {
        _ if plain.mux().is_some_and(is_standard) => true,
        Command::InitiateDownload(_, i) | Command::UploadInitiated(_, i) => {
            let strict = if side == Side::Client { strict_initiate(&half) } else { is_strict_answer(&half) };
            strict && i.expedited && i.size_indicated && i.unused > 0
        }
        Command::BlockAck { ackseq, blksize } => *ackseq <= MOST && (1..=MOST).contains(blksize),
        Command::Segment(_) | Command::SegmentRequest { .. } | Command::SegmentResponse { .. } => false,
        Command::EndBlock { .. } | Command::BlockEnded | Command::StartBlockUpload => false,
        _ => strict_initiate(&half) || is_strict_answer(&half),
    }
}

/// Whether a device may have an object (CiA 301, table 36).
fn is_usable(object: Mux) -> bool {
    (0x1000..0xA000).contains(&object.index)
}

/// Whether CiA 301 or a profile knows an object.
fn is_standard(object: Mux) -> bool {
    Profile::UNKNOWN.data_type(object.index, object.sub).is_some()
}

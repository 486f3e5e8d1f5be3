//! Possible states of a channel at the start of the capture, or after lost frames.
//!
//! Until the channel's first complete transfer several hypotheses are open: it is idle, or a segmented or a block
//! transfer runs. Until then nothing is a violation and nothing a value, because a block segment can look like any
//! command. A transfer without its beginning in the capture is incomplete.

use super::block::{Block, MOST};
use super::channel::Interruption;
use super::machine::{Action, ChannelState, transition};
use super::phase::{Half, Phase, Segments, is_strict_answer, strict_initiate};
use super::state::{Hypotheses, SdoChannel};
use super::transfer::{Direction, Mode, Status, Transfer};
use super::wire::{self, Command, Mux, Side};
use crate::bytes::frame::{Frame, FrameRef};
use crate::rules::sdo::Sdo024;
use crate::words::profiles::Profile;
use crate::world::context::Context;
use crate::world::event::Place;

impl Hypotheses {
    /// Returns true if a transfer may run whose beginning the capture lacks.
    pub(super) fn are_open(&self) -> bool {
        self.open
    }

    /// Opens all hypotheses again.
    pub(super) fn open(&mut self) {
        (self.open, self.reported) = (true, false);
    }

    /// Excludes transfers that the capture does not show.
    pub(super) fn settle(&mut self) {
        (self.open, self.reported) = (false, false);
    }

    /// Does the same, and notes that frames outside any transfer were reported.
    pub(super) fn report(&mut self) {
        (self.open, self.reported) = (false, true);
    }

    /// Returns true if frames outside any transfer were reported.
    pub(super) fn is_reported(&self) -> bool {
        self.reported
    }

    /// Notes that the first frame continues nothing from before the capture.
    pub(super) fn begin_whole(&mut self) {
        self.whole = true;
    }

    /// Returns true if the capture contains the channel's first frame.
    pub(super) fn is_whole(&self) -> bool {
        self.whole
    }

    /// Returns true if this frame is the first one, before which something may be cut off.
    pub(super) fn is_first(&mut self, no: u64) -> bool {
        !self.whole && *self.first.get_or_insert(no) == no
    }

    /// Returns true if the first frame was another than this one.
    pub(super) fn is_later(&self, no: u64) -> bool {
        self.whole || self.first.is_some_and(|first| first != no)
    }
}

impl SdoChannel {
    /// Returns true if only the following frame may show the meaning of the next one: a transfer may run that began
    /// before the capture or is recorded one-sided, or the frame does not fit the channel's state.
    pub fn is_ambiguous(&self, side: Side, frame: &Frame) -> bool {
        self.is_midway() || self.has_no_place(side, frame)
    }

    /// Returns true if an unknown transfer may run.
    fn is_midway(&self) -> bool {
        match &self.phase {
            Phase::Idle => self.hypotheses.open && (!self.hypotheses.whole || self.is_one_sided()),
            Phase::Initiated(request) => self.is_edge(request),
            Phase::Segments(_) => false,
            Phase::Block(..) => self.is_nameless(),
        }
    }

    /// Returns true if a frame fits neither the state of a known channel nor a request that some stack would send.
    fn has_no_place(&self, side: Side, frame: &Frame) -> bool {
        // Frames after a fault or an abort belong to that.
        let waits = self.sequence.under_way.is_some() || self.sequence.is_waiting() || self.hypotheses.reported;
        if waits || self.hypotheses.open || !self.proof.trusted || frame.len != 8 {
            return false;
        }
        let (state, bytes) = (self.state(), frame.head());
        let command = self.decode(side, bytes, frame.len);
        if let (Command::BlockSegment { seqno, .. }, Some(block)) = (command, self.block()) {
            return block.is_off(seqno);
        }
        let odd = state == ChannelState::Idle && command.has_reserved_bits(bytes);
        let action = transition(state, side, &command).action;
        odd || matches!(action, Action::Stray | Action::Outside | Action::Misfit | Action::Unasked)
    }

    /// Returns true if several requests were seen and no response.
    pub fn is_unanswered(&self) -> bool {
        self.proof.responses == 0 && self.proof.requests > 1
    }

    /// Returns true if the capture contains only requests or only responses.
    pub(super) fn is_one_sided(&self) -> bool {
        (self.proof.requests == 0) != (self.proof.responses == 0)
    }

    /// Returns true if no earlier frame of the channel suggests another reading.
    fn is_alone(&self) -> bool {
        self.hypotheses.whole && self.hypotheses.before.is_none()
    }

    /// Returns the reading of the next frame if it is ambiguous.
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

    /// Ends a block transfer joined midway if a frame does not belong to it.
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

    /// Returns the reading of a frame in an unknown state, by its neighbours: by its command byte, as a block segment,
    /// or undetermined.
    fn read_open(&self, side: Side, frame: &Frame, next: Option<&(Side, Frame)>) -> Command {
        let bytes = frame.head();
        let plain = wire::decode_frame(side, bytes, frame.len);
        let before = self.hypotheses.before;
        if frame.len != 8 || bytes[0] & 0x7F == 0 || matches!(plain, Command::Abort(..)) {
            return plain;
        }
        let next = next.map(|(by, next)| (*by, next.head(), wire::decode_frame(*by, next.head(), next.len)));
        let block = is_segment(side, bytes[0], before, next.as_ref());
        // A single neighbour may count up by chance.
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

    /// Returns the reading of a frame that does not fit the state but agrees with the next one: both sides are in
    /// another state.
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

    /// Returns true if a frame is of a kind used in the transfer, or names its object. Without a transfer, a response
    /// that names its object begins one.
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

    /// Takes a frame that does not fit the state and agrees with the next one: the recording lost the frames between.
    /// The state is then unknown, as after an announced gap.
    pub(super) fn leave_behind(&mut self, half: &Half, cx: &mut Context<'_>) {
        if half.reading.is_some() && !self.is_midway() {
            self.find(Sdo024::Elsewhere, half.at, cx);
            self.lost(Interruption::LostFrames, cx);
        }
    }

    /// Returns true if a request is the channel's first frame, whose response may precede the capture.
    pub(super) fn is_edge(&self, request: &Half) -> bool {
        !self.hypotheses.whole && self.hypotheses.first == Some(request.at.no)
    }

    /// Begins a transfer whose initiate request the capture lacks.
    fn begin_midway(&mut self, at: FrameRef, direction: Direction, phase: Phase, cx: &mut Context<'_>) {
        let mode = if matches!(phase, Phase::Block(..)) { Mode::Block } else { Mode::Segmented };
        let id = self.next_id(cx);
        let mut transfer = Box::new(Transfer::new(self.beginning(id, at, cx), direction, mode, None));
        transfer.outcome.midway = true;
        transfer.miss_beginning();
        self.transfer = Some(transfer);
        self.phase = phase;
    }

    /// Drops the frames so far, which belonged to a transfer from before the capture.
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

    /// Begins a transfer with an initiate response whose request the capture lacks, if the client goes on accordingly;
    /// returns true if it does.
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

    /// Takes a frame that may belong to a transfer from before the capture.
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

    /// Returns true if a client frame may be a segment, or request one, of a transfer from before the capture.
    pub(super) fn may_join(&self, half: &Half) -> bool {
        self.hypotheses.open
            && self.transfer.is_none()
            && matches!(half.command, Command::SegmentRequest { .. } | Command::Segment(_))
    }

    /// Takes an acknowledgement without transfer at the start of the capture: a block transfer runs.
    pub(super) fn join_block(&mut self, half: &Half, direction: Direction, cx: &mut Context<'_>) {
        let Command::BlockAck { ackseq, blksize } = half.command else { return };
        let valid = ackseq <= MOST && (1..=MOST).contains(&blksize) && !half.command.has_reserved_bits(half.bytes);
        if valid && self.hypotheses.open {
            self.proof.paired = true;
            self.begin_midway(half.at, direction, Phase::Block(Box::new(Block::midway()), None), cx);
        }
    }

    /// Returns true if two client frames in a row, before any valid exchange, are segments of a block download from
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

/// Returns true if the neighbouring frames show a block segment: numbers count up, and the receiver acknowledges the
/// last one. `None` if undecided.
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
    // Numbers restart after the acknowledgement, which may not be recorded.
    let begins = next.is_some_and(|(by, bytes, _)| *by == side && bytes[0] & 0x7F == 1);
    match (goes_on, ends.flatten()) {
        (Some(true), _) | (_, Some(true)) => Some(true),
        (_, Some(false)) if !begins => Some(false),
        (Some(false), _) if seqno != 1 => Some(false),
        _ => None,
    }
}

/// Returns true if the other side's next frame, with this first byte, belongs to a frame: its answer, its request
/// listed late, or the next step.
fn follows(plain: &Command, other: &Command, first: u8) -> bool {
    wire::may_answer(plain, other) || wire::may_answer(other, plain) || goes_on(plain, other, first)
}

/// Returns true if the other side's next frame, with this first byte, answers a segment or a request for one, or is the
/// next step.
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

/// Returns true if bytes are unlikely to be data that look like a command: they name an object, and their unused bytes
/// are 0.
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

/// Returns true if a device may have an object (CiA 301, table 36).
fn is_usable(object: Mux) -> bool {
    (0x1000..0xA000).contains(&object.index)
}

/// Returns true if CiA 301 or a profile defines an object.
fn is_standard(object: Mux) -> bool {
    Profile::UNKNOWN.data_type(object.index, object.sub).is_some()
}

//! The driver of one SDO channel.
//!
//! It takes a frame, publishes its meaning, and begins and ends transfers.

use std::collections::VecDeque;
use std::sync::Arc;

use super::exchange::{expedited, lacks_data};
use super::limits::{LEFT_NS, UNANSWERED_NS, within};
use super::phase::{Half, Phase, Segments, strict_initiate};
use super::state::{GivenUpWrite, History, Hypotheses, Proof, SdoChannel, Sequence, Server, Verdicts};
use super::transfer::{Beginning, Direction, Mode, Status, Transfer, TransferId};
use super::wire::{self, Command, Mux, Side};
use crate::bytes::frame::{BusId, CanId, Frame, FrameRef};
use crate::bytes::ns::Ns;
use crate::evidence::duplicates::Sighting;
use crate::rules::sdo::{Sdo002, Sdo007, Sdo026};
use crate::words::profiles::Profile;
use crate::world::context::{Chunk, Context};
use crate::world::dictionary::{Described, Dictionary};
use crate::world::event::{Note, Place, Step, What};

/// Number of bytes of a running transfer collected before they are passed on.
const CHUNK: usize = 4096;
/// Maximum number of requests in a search for a server.
const PROBES: u64 = 3;

/// Number of frames kept to find the first reading of a duplicate.
const RECENT: usize = 128;

/// Returns true if the capture started early enough to contain the channel's first frame.
pub fn is_whole(heard_ns: Ns) -> bool {
    heard_ns > UNANSWERED_NS
}

fn empty_step() -> Step {
    Step {
        side: Side::Client,
        command: Command::Unknown(0),
        mux: None,
        described: Described::default(),
        ordinal: 0,
        answered_by: None,
        place: Place::Due,
        result: None,
    }
}

/// An event that interrupts the transfers of a server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interruption {
    /// Frames are missing from the recording.
    LostFrames,
    /// The server has booted, and may still answer what it was asked before.
    BootUp,
    /// An NMT command resets the server.
    Command,
}

impl SdoChannel {
    /// Creates a channel of the server `node` on `bus`.
    pub fn new(bus: BusId, node: u8, id: Option<CanId>) -> Self {
        Self {
            server: Server { bus, node, id, description: None, profile: Profile::UNKNOWN, segments_unmarked: None },
            phase: Phase::Idle,
            transfer: None,
            hypotheses: Hypotheses::default(),
            sequence: Sequence::default(),
            history: History::default(),
            proof: Proof::default(),
            verdicts: Verdicts::default(),
            unlisted: Vec::new(),
            step: empty_step(),
            own: true,
            given_up_write: GivenUpWrite::default(),
            ahead: None,
            recent: VecDeque::new(),
        }
    }

    /// Takes the time `heard_ns` since the capture's start without a frame of the channel, or a boot-up of its server:
    /// the first frame then continues nothing from before the capture.
    pub fn idle_for(&mut self, heard_ns: Ns, booted: bool) {
        if booted || is_whole(heard_ns) {
            self.hypotheses.begin_whole();
        }
    }

    /// Takes the last request to this server that it must not answer.
    pub fn asked_in_vain(&mut self, request: Option<FrameRef>) {
        let pending = self.pending().map(|pending| pending.at.no);
        if request.is_some_and(|request| pending == Some(request.no)) {
            self.verdicts.unanswerable = request;
        }
    }

    /// Takes whether the capture has answers of other servers by now.
    pub fn others_answer(&mut self, cx: &Context<'_>) {
        self.proof.others_answer = cx.evidence.recording.has_answers_beside(self.server.node);
    }

    /// Takes that the server was only looked for, like all others.
    pub fn scanned(&mut self, scanned: bool) {
        self.verdicts.scanned |= scanned;
    }

    /// Returns the server's node-ID.
    pub fn node(&self) -> u8 {
        self.server.node
    }

    /// Returns true if a server was looked for and has not answered.
    pub fn is_probed(&self) -> bool {
        self.proof.responses == 0
            && (1..=PROBES).contains(&self.proof.requests)
            && self.proof.plausible == self.proof.requests
    }

    /// Returns the completed transfer that the current frame confirms late.
    pub fn confirmed(&self) -> Option<&Arc<Transfer>> {
        self.given_up_write.confirmed.as_ref()
    }

    /// Returns the running transfer with the description of its object; `None` if the channel is not SDO.
    pub fn running(&self) -> Option<(&Transfer, Described)> {
        let transfer = self.transfer.as_deref().filter(|_| !self.is_foreign())?;
        Some((transfer, self.described(transfer.mux)))
    }

    /// Sets the description that gives the server's objects names and types.
    pub fn describe(&mut self, description: Option<Arc<Dictionary>>) {
        self.server.description = description;
    }

    /// Sets the profile that gives the server's other objects names and types.
    pub fn follows(&mut self, profile: Profile) {
        self.server.profile = profile;
    }

    /// Takes whether it is the default channel of a node that reports its state, so that its CAN-IDs are those of SDO.
    pub fn is_of_node(&mut self, of_node: bool) {
        self.proof.of_node |= of_node;
    }

    pub(super) fn described(&self, mux: Option<Mux>) -> Described {
        let of = |description: &Arc<Dictionary>, mux: Mux| description.get(mux.index, mux.sub).cloned();
        let object = mux.and_then(|mux| of(self.server.description.as_ref()?, mux));
        Described { object, profile: self.server.profile, told: None }
    }

    /// Takes one frame of the channel (classic, data); appends a `What::Sdo` event and its consequences. `next`: the
    /// channel's next frame if it was read ahead.
    pub fn step(&mut self, side: Side, frame: &Frame, next: Option<&(Side, Frame)>, cx: &mut Context<'_>) {
        let half = Half {
            at: frame.reference(),
            when: cx.when,
            command: Command::Unknown(0),
            reading: self.reading(side, frame, next),
            bytes: frame.head(),
            len: frame.len,
        };
        self.ahead = next.map(|(by, frame)| (*by, frame.head()[0]));
        self.given_up_write.confirmed = None;
        if cx.sighting == Sighting::Duplicate {
            let step = self.duplicate(side, &half);
            cx.push(None, Some(self.server.node), What::Sdo(step));
            return;
        }
        let slot = cx.events.len();
        cx.push(None, Some(self.server.node), What::Note(Note::RequestNotCaptured));
        self.leave_behind(&half, cx);
        let half = self.decoded(side, half);
        self.step = Step { side, command: half.command, ..empty_step() };
        let before = self.sight(side, half, cx);
        let done = self.step.result.as_ref().map(|transfer| (transfer.id, transfer.mux));
        let of = if self.waits_for_other(&half) { None } else { done.or_else(|| self.identity()).or(before) };
        self.step.mux = of.and_then(|(_, mux)| mux);
        self.step.described = self.described(self.step.mux.or(self.step.command.mux()));
        let step = std::mem::replace(&mut self.step, empty_step());
        if !cx.evidence.recording.shows_once() {
            if self.recent.len() == RECENT {
                self.recent.pop_front();
            }
            self.recent
                .push_back((half, Step { place: Place::Duplicate, answered_by: None, result: None, ..step.clone() }));
        }
        if let Some(event) = cx.events.get_mut(slot) {
            event.transfer = of.map(|(id, _)| id);
            event.what = What::Sdo(step);
        }
        if let Some(transfer) = &mut self.transfer
            && transfer.data.fresh.len() >= CHUNK
        {
            cx.chunks.push(chunk(transfer, transfer.data.fresh.clone()));
            transfer.data.fresh.clear();
        }
    }

    /// Takes a frame that is no duplicate; returns the transfer that ran before it.
    fn sight(&mut self, side: Side, half: Half, cx: &mut Context<'_>) -> Option<(TransferId, Option<Mux>)> {
        self.proof.count(side, half.at);
        let half = self.order_before(side, half, cx);
        self.step.command = half.command;
        let later = self.proof.first != Some(half.at) || self.hypotheses.is_later(half.at.no);
        self.proof.weigh(&half, later);
        self.others_answer(cx);
        if self.proof.responses == 0 && self.proof.goes_on() {
            cx.evidence.recording.client_goes_on();
        }
        let before = self.identity();
        match side {
            Side::Client => {
                self.history.sent = half.at.no;
                self.order_client(half, cx);
                self.judge_frame(&Half { command: self.step.command, ..half }, cx);
            }
            Side::Server => {
                let first = self.hypotheses.is_first(half.at.no);
                let stray = self.is_stray_segment(&half);
                self.order_server(half, first, cx);
                if stray {
                    (self.step.command, self.step.place) = (Command::Undetermined(half.bytes), Place::Outside);
                }
            }
        }
        before
    }

    /// Returns the first reading of a duplicate: that of the first equal frame without one so far.
    fn duplicate(&mut self, side: Side, half: &Half) -> Step {
        let equal =
            |(before, step): &(Half, Step)| step.side == side && before.bytes == half.bytes && before.len == half.len;
        let first = self.recent.iter().position(equal).and_then(|place| self.recent.drain(..=place).next_back());
        first.map_or(Step { side, command: half.command, place: Place::Duplicate, ..empty_step() }, |(_, step)| step)
    }

    fn identity(&self) -> Option<(TransferId, Option<Mux>)> {
        self.transfer.as_ref().map(|transfer| (transfer.id, transfer.mux))
    }

    /// Returns the request that waits for its response.
    pub(super) fn pending(&self) -> Option<Half> {
        match &self.phase {
            Phase::Idle => None,
            Phase::Initiated(request) => Some(*request),
            Phase::Segments(segments) => segments.asked,
            Phase::Block(_, end) => *end,
        }
    }

    /// Makes a request wait for its response.
    pub(super) fn set_pending(&mut self, half: Half) {
        match &mut self.phase {
            Phase::Idle => {}
            Phase::Initiated(request) => *request = half,
            Phase::Segments(segments) => segments.asked = Some(half),
            Phase::Block(_, end) => *end = Some(half),
        }
    }

    /// Marks the pending request as answered, without the effect of an initiate response.
    pub(super) fn clear_pending(&mut self) {
        match &mut self.phase {
            Phase::Idle | Phase::Initiated(_) => {}
            Phase::Segments(segments) => segments.asked = None,
            Phase::Block(_, end) => *end = None,
        }
    }

    /// Returns the command of a frame in the present phase.
    pub(super) fn decode(&self, side: Side, bytes: [u8; 8], len: u8) -> Command {
        if let Phase::Block(block, _) = &self.phase
            && self.sends_data(side)
            && len > 0
        {
            return self.decode_in_block(block, side, bytes);
        }
        wire::decode_frame(side, bytes, len)
    }

    pub(super) fn sends_data(&self, side: Side) -> bool {
        self.is_upload() == (side == Side::Server)
    }

    /// Begins a transfer with a client's initiate request.
    pub(super) fn begin(&mut self, request: &Half, cx: &mut Context<'_>) {
        let id = self.next_id(cx);
        let (direction, mode) = match request.command {
            Command::InitiateDownload(_, i) if i.expedited => (Direction::Download, Mode::Expedited),
            Command::InitiateDownload(..) => (Direction::Download, Mode::Segmented),
            Command::InitiateBlockDownload { .. } => (Direction::Download, Mode::Block),
            Command::InitiateBlockUpload { .. } => (Direction::Upload, Mode::Block),
            _ => (Direction::Upload, Mode::Expedited),
        };
        let mut transfer =
            Box::new(Transfer::new(self.beginning(id, request.at, cx), direction, mode, request.command.mux()));
        transfer.data.size_indicated = match request.command {
            Command::InitiateDownload(_, i) if i.expedited && i.size_indicated => Some(4 - u32::from(i.unused & 3)),
            Command::InitiateDownload(_, i) => i.size().filter(|_| request.len == 8),
            Command::InitiateBlockDownload { size, .. } => size.filter(|_| request.len == 8),
            _ => None,
        };
        if let Command::InitiateDownload(mux, i) = request.command
            && i.expedited
            && !lacks_data(&i, request.len)
        {
            transfer.data.requested = expedited(Some(mux), self.server.profile, &i, request.len).to_vec();
        }
        self.transfer = Some(transfer);
        self.phase = Phase::Initiated(*request);
        self.hypotheses.settle();
    }

    pub(super) fn next_id(&self, cx: &mut Context<'_>) -> TransferId {
        *cx.next_transfer = cx.next_transfer.saturating_add(1);
        TransferId(*cx.next_transfer)
    }

    pub(super) fn beginning(&self, id: TransferId, at: FrameRef, cx: &Context<'_>) -> Beginning {
        let Server { bus, node, id: channel, .. } = self.server;
        Beginning { id, bus, node, channel, extract: cx.extract, at }
    }

    /// Ends the transfer in any phase.
    pub(super) fn complete(&mut self, status: Status, cx: &mut Context<'_>) {
        self.confirm_doubts(cx);
        let Some(mut transfer) = self.transfer.take() else {
            self.phase = Phase::Idle;
            return;
        };
        transfer.described = self.described(transfer.mux);
        let status = if transfer.outcome.bad && status == Status::Ok { Status::Failed } else { status };
        // A transfer from before the capture cannot be judged as a whole.
        let judged = status != Status::Failed || !transfer.outcome.midway;
        let status = if judged { status } else { Status::Incomplete };
        transfer.outcome.status = status;
        if status == Status::Incomplete {
            self.count_seen(&mut transfer);
        }
        transfer.settle_holes();
        transfer.last = match status {
            Status::Incomplete => transfer.last,
            // The current frame belongs to what follows.
            Status::Failed if !self.own => self.newest(&transfer),
            _ if cx.at.no > transfer.last.no => cx.at,
            _ => transfer.last,
        };
        self.phase = Phase::Idle;
        if self.is_one_sided() {
            self.hypotheses.open();
        }
        let transfer = Arc::new(*transfer);
        let left = transfer.outcome.status != Status::Ok && transfer.mode == Mode::Expedited;
        self.given_up_write.left = left.then(|| Arc::clone(&transfer));
        if self.own {
            self.step.result = Some(Arc::clone(&transfer));
        }
        self.announce(transfer, cx);
    }

    /// Counts data sent and not confirmed, because the capture shows no more of the transfer.
    fn count_seen(&mut self, transfer: &mut Transfer) {
        match &mut self.phase {
            Phase::Block(block, asked) => {
                let end = match asked.map(|end| end.command) {
                    Some(Command::EndBlock { unused, .. }) => Some(unused),
                    _ => block.end.and_then(|end| end.unused),
                };
                block.cut_off(transfer, end);
            }
            Phase::Segments(Segments { asked: Some(Half { command: Command::Segment(segment), len, .. }), .. }) => {
                transfer.append_segment(segment, *len);
                if segment.last {
                    transfer.reach_end();
                }
            }
            _ => {}
        }
    }

    /// Ends the transfer before the current frame.
    pub(super) fn complete_before(&mut self, status: Status, cx: &mut Context<'_>) {
        self.before_frame(|channel| channel.complete(status, cx));
    }

    /// Runs an action whose results do not belong to the current frame.
    pub(super) fn before_frame(&mut self, act: impl FnOnce(&mut Self)) {
        let own = std::mem::replace(&mut self.own, false);
        act(self);
        self.own = own;
    }

    /// Returns the newest frame of a transfer.
    pub(super) fn newest(&self, transfer: &Transfer) -> FrameRef {
        let segment = self.block().and_then(|block| block.marks.newest);
        segment.filter(|at| at.no > transfer.last.no).unwrap_or(transfer.last)
    }

    /// Returns the number of a segment in the transfer, from 1; 0 if it is no segment, or unknown because of a hole.
    pub(super) fn segment_ordinal(&self, command: &Command) -> u32 {
        match (&self.phase, command, &self.transfer) {
            (Phase::Segments(_), Command::Segment(_), Some(transfer))
                if !transfer.outcome.midway && !transfer.data.hole =>
            {
                transfer.data.segments.saturating_add(1)
            }
            _ => 0,
        }
    }

    /// Reports the end of a transfer.
    pub(super) fn announce(&mut self, transfer: Arc<Transfer>, cx: &mut Context<'_>) {
        if self.is_foreign() {
            self.step.result = None;
            return;
        }
        if transfer.outcome.status == Status::Ok && transfer.direction == Direction::Download {
            self.verdicts.refused.retain(|refused| Some(refused.object) != transfer.mux);
        }
        if !transfer.data.fresh.is_empty() {
            cx.chunks.push(chunk(&transfer, transfer.data.fresh.clone()));
        } else if cx.extract && transfer.data.size == 0 && transfer.outcome.status != Status::Ok {
            // The data to be written were seen, if not their confirmation.
            cx.chunks.push(chunk(&transfer, transfer.data.requested.clone()));
        }
        self.list(transfer, cx);
    }

    /// Closes what was open after a reset of the server or lost frames.
    pub fn lost(&mut self, by: Interruption, cx: &mut Context<'_>) {
        let reset = by != Interruption::LostFrames;
        self.own = false;
        self.order_rest(cx);
        let pending = self.pending();
        if reset
            && let Some(pending) = self.pending()
            && match by {
                Interruption::Command => self.is_overdue(&pending, cx),
                _ => !within(pending.at, cx.at, UNANSWERED_NS),
            }
            && !self.is_edge(&pending)
            && !self.sequence.may_be_answered(&pending)
        {
            self.find(Sdo002::NoResponse, pending.at, cx);
        }
        if !reset {
            self.verdicts.drop_doubts();
        }
        if self.transfer.is_some() {
            if let Some(about) = self.transfer.as_ref().map(|transfer| transfer.first)
                && reset
            {
                self.note(Note::LostByReset, about, cx);
            }
            self.complete(Status::Incomplete, cx);
        }
        self.own = true;
        let before_reset = pending.or(self.history.before_reset).filter(|_| reset);
        let last_response = self.history.last_response.filter(|_| reset);
        self.phase = Phase::Idle;
        self.history = History { before_reset, last_response, ..History::default() };
        self.given_up_write = GivenUpWrite::default();
        self.sequence = Sequence::default();
        self.verdicts.fault = None;
        self.hypotheses = Hypotheses::default();
        if reset {
            self.hypotheses.report();
        } else {
            self.restart();
        }
    }

    /// Takes a boot-up of the server that is the second one for no reason, if it is one.
    pub fn booted_twice(&mut self, second: Option<FrameRef>) {
        self.history.booted_twice = second;
    }

    /// Takes a boot-up of the server: later frames answer no earlier request.
    pub fn boot_up(&mut self) {
        self.history.given_up = self.history.before_reset.take();
        self.history.booted = true;
        self.hypotheses.begin_whole();
    }

    /// Resets the proof after a gap: as at the capture's start, block data look like commands until an exchange shows
    /// the channel's state.
    fn restart(&mut self) {
        self.proof = Proof { proven: self.proof.proven, of_node: self.proof.of_node, ..Proof::default() };
        self.verdicts.withheld.clear();
    }

    /// Closes open transfers and reports withheld findings at the end of the capture.
    pub fn finish(&mut self, cx: &mut Context<'_>) {
        self.own = false;
        self.order_rest(cx);
        let aged = |from: FrameRef| match (from.t_ns, cx.at.t_ns) {
            (Some(from), Some(to)) => to - from > UNANSWERED_NS,
            _ => false,
        };
        let idle_is_old = self.transfer.as_ref().is_some_and(|transfer| aged(transfer.last));
        if let Some(pending) = self.pending()
            && self.is_overdue(&pending, cx)
            && !self.sequence.may_be_answered(&pending)
        {
            self.find(Sdo002::NoResponse, pending.at, cx);
        }
        if let Some((_, i)) = self.unmarked()
            && self.is_meant_as_data()
            && (i.unused != 0 || i.data != [0; 4] || idle_is_old)
        {
            self.recognise_unmarked(cx);
        }
        if idle_is_old {
            self.judge_unconfirmed_end(cx);
            self.judge_stalled_block(cx);
        }
        if idle_is_old && self.all_bytes_without_last() {
            let last = self.transfer.as_ref().map_or(cx.at, |transfer| transfer.last);
            self.find(Sdo007::NoLast, last, cx);
        }
        self.judge_left_transfer(cx);
        let nameless = !self.proof.trusted && !self.pending().is_some_and(|pending| strict_initiate(&pending));
        if nameless {
            self.transfer = None;
        } else {
            self.complete(Status::Incomplete, cx);
        }
        self.find_refused(cx);
        self.report_distrust(cx.at.t_ns, cx);
        if self.is_sdo() == Some(true) {
            let both = self.proof.requests > 0 && self.proof.responses > 0;
            if self.proof.of_node && both && !self.verdicts.scanned {
                self.report_withheld(cx);
            }
            self.list_withheld(cx);
        }
    }

    /// Reports a transfer in which the client is the next to send, and has not for long.
    fn judge_left_transfer(&mut self, cx: &mut Context<'_>) {
        let Some(transfer) = self.transfer.as_ref().filter(|transfer| transfer.mux.is_some() && !transfer.data.hole)
        else {
            return;
        };
        let owes = match &self.phase {
            Phase::Segments(segments) => segments.asked.is_none() && !self.all_bytes_without_last(),
            Phase::Block(block, None) => self.is_block_left(block),
            _ => false,
        };
        let last = self.newest(transfer);
        if let Some(idle) = cx.at.since(last).filter(|idle| owes && *idle > LEFT_NS) {
            self.find(Sdo026::Left { idle }, last, cx);
        }
    }
}

/// Returns the next bytes of a transfer that is extracted.
pub fn chunk(transfer: &Transfer, bytes: Vec<u8>) -> Chunk {
    Chunk { id: transfer.id, bus: transfer.bus, node: transfer.node, mux: transfer.mux, bytes }
}

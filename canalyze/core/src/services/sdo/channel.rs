//! One SDO channel: the owner of its pairing and of its transfer, and what pairs of frames do to the transfer.
//!
//! A channel judges only what it has seen begin: findings are withheld until it has shown one valid request with
//! its response, and dropped before the first request that can be one. It must not look at other channels.

use std::sync::Arc;

use super::block::Block;
use super::pairing::Pairing;
use super::transfer::{Abort, Beginning, Direction, Mode, Status, Transfer, TransferId};
use super::wire::{self, Command, Initiate, Mux, Segment, Side};
use crate::event::{Event, Note, Place, Step, What};
use crate::finding::{Code, Facts, Finding};
use crate::frame::{BusId, Frame, FrameRef};

/// Findings withheld at most; more of the same say nothing new.
const WITHHELD: usize = 32;
/// Bytes of a running transfer that are gathered before they are handed out.
const CHUNK: usize = 4096;
/// Age in ns at which a request at the capture's end counts as unanswered (CiA 301 leaves the time to the client).
const UNANSWERED_NS: i64 = 1_000_000_000;

/// One frame of the channel, kept until the other half of its exchange is known.
#[derive(Clone, Copy, Debug)]
pub(super) struct Half {
    pub(super) at: FrameRef,
    pub(super) command: Command,
    pub(super) bytes: [u8; 8],
    pub(super) len: u8,
}

/// What the channel writes to while it takes a frame.
pub struct Context<'a> {
    /// Events of this frame.
    pub events: &'a mut Vec<Event>,
    /// The number the next transfer gets.
    pub next_transfer: &'a mut u64,
    /// Whether transferred bytes are handed out.
    pub extract: bool,
    /// Bytes handed out.
    pub chunks: &'a mut Vec<Chunk>,
    /// The frame at hand (or the last one, at the capture's end).
    pub at: FrameRef,
}

/// Bytes of a transfer that are handed out while it runs.
#[derive(Clone, Debug)]
pub struct Chunk {
    /// Number of the transfer.
    pub id: TransferId,
    /// The bus.
    pub bus: BusId,
    /// The server's node-ID.
    pub node: u8,
    /// The object, if known.
    pub mux: Option<Mux>,
    /// The next bytes.
    pub bytes: Vec<u8>,
}

/// Where the transfer stands.
#[derive(Debug)]
pub(super) enum Phase {
    /// No transfer.
    Idle,
    /// The initiate request awaits its response.
    Initiated,
    /// Segments, with the toggle bit that is due.
    Segments { toggle: bool },
    /// Sub-blocks of a block transfer.
    Block(Box<Block>),
}

/// The last word on segments outside a transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outside {
    /// They belong to a transfer that began before the capture.
    Uncaptured,
    /// They are a violation.
    Violation,
    /// The violation was said already.
    Said,
}

/// One SDO channel.
#[derive(Debug)]
pub struct Channel {
    pub(super) bus: BusId,
    pub(super) node: u8,
    pub(super) pairing: Pairing,
    pub(super) phase: Phase,
    pub(super) transfer: Option<Box<Transfer>>,
    /// Initiate with e = s = 0, until a segment shows what was meant.
    pub(super) unmarked: Option<(Half, Initiate)>,
    /// A server's acknowledgement of one block segment more than was seen.
    pub(super) held_ack: Option<Half>,
    pub(super) outside: Outside,
    /// The step of the frame at hand.
    pub(super) step: Step,
    /// Whether completed transfers belong to the frame at hand.
    pub(super) own: bool,
    /// A completed transfer whose pair may still be dissolved.
    pub(super) unsettled: Option<Arc<Transfer>>,
    /// A valid request with its response was seen.
    trusted: bool,
    /// A request that can be one was seen: from here on there is something to judge.
    pub(super) begun: bool,
    withheld: Vec<Finding>,
    requests: u64,
    responses: u64,
    /// Requests among them that can only be meant as such.
    plausible: u64,
    first: Option<FrameRef>,
}

fn empty_step() -> Step {
    Step {
        side: Side::Client,
        command: Command::Unknown(0),
        mux: None,
        ordinal: 0,
        answered_by: None,
        place: Place::Due,
        result: None,
    }
}

impl Channel {
    /// A channel of the server `node` on `bus`, of which nothing was seen.
    pub fn new(bus: BusId, node: u8) -> Self {
        Self {
            bus,
            node,
            pairing: Pairing::default(),
            phase: Phase::Idle,
            transfer: None,
            unmarked: None,
            held_ack: None,
            outside: Outside::Uncaptured,
            step: empty_step(),
            own: true,
            unsettled: None,
            trusted: false,
            begun: false,
            withheld: Vec::new(),
            requests: 0,
            responses: 0,
            plausible: 0,
            first: None,
        }
    }

    /// A frame of the channel without any byte: it says nothing, but it is no SDO frame.
    pub fn empty(&mut self, at: FrameRef, cx: &mut Context<'_>) {
        self.find(Code::Sdo010, at, Facts::Length(0), cx);
    }

    /// The server's node-ID.
    pub fn node(&self) -> u8 {
        self.node
    }

    /// Takes one frame of the channel (classic, data): appends one `What::Sdo` event and what follows from it.
    pub fn step(&mut self, side: Side, frame: &Frame, cx: &mut Context<'_>) {
        let half = Half {
            at: frame.reference(),
            command: self.decode(side, frame.head()),
            bytes: frame.head(),
            len: frame.len,
        };
        self.first.get_or_insert(half.at);
        match side {
            Side::Client => self.requests = self.requests.saturating_add(1),
            Side::Server => self.responses = self.responses.saturating_add(1),
        }
        self.step = Step { side, command: half.command, ..empty_step() };
        let slot = cx.events.len();
        cx.events.push(Event {
            at: half.at,
            about: None,
            bus: self.bus,
            node: Some(self.node),
            transfer: None,
            what: What::Note(Note::RequestNotCaptured),
        });
        self.plausible = self.plausible.saturating_add(u64::from(strict_initiate(&half)));
        if half.command.is_initiate() && strict_initiate(&half) && self.first.is_some_and(|first| first != half.at) {
            self.begun = true;
        }
        let before = self.transfer.as_ref().map(|transfer| (transfer.id, transfer.mux));
        match side {
            Side::Client => self.client(half, cx),
            Side::Server => self.server(half, cx),
        }
        self.judge_frame(&half, cx);
        let after = self.transfer.as_ref().map(|transfer| (transfer.id, transfer.mux));
        let done = self.step.result.as_ref().map(|transfer| (transfer.id, transfer.mux));
        let of = done.or(after).or(before);
        self.step.mux = of.and_then(|(_, mux)| mux);
        let step = std::mem::replace(&mut self.step, empty_step());
        if let Some(event) = cx.events.get_mut(slot) {
            event.transfer = of.map(|(id, _)| id);
            event.what = What::Sdo(step);
        }
        if let Some(transfer) = &mut self.transfer
            && transfer.fresh.len() >= CHUNK
        {
            cx.chunks.push(chunk(transfer, transfer.fresh.clone()));
            transfer.fresh.clear();
        }
    }

    /// Which command the frame is, given where the transfer stands.
    fn decode(&self, side: Side, bytes: [u8; 8]) -> Command {
        if let Phase::Block(block) = &self.phase
            && self.sends_data(side)
        {
            return self.decode_in_block(block, side, bytes);
        }
        wire::decode(side, bytes)
    }

    pub(super) fn sends_data(&self, side: Side) -> bool {
        let upload = self.transfer.as_ref().is_some_and(|transfer| transfer.direction == Direction::Upload);
        upload == (side == Side::Server)
    }

    /// Flaws of the frame itself, whatever its place.
    fn judge_frame(&mut self, half: &Half, cx: &mut Context<'_>) {
        if half.len != 8 {
            self.find(Code::Sdo010, half.at, Facts::Length(half.len), cx);
        }
        if matches!(self.step.place, Place::Uncaptured | Place::InFlight) {
            return;
        }
        match half.command {
            Command::Unknown(command) => self.find(Code::Sdo023, half.at, Facts::Command(command), cx),
            Command::Segment(Segment { last: false, unused, .. }) if unused != 0 => {
                self.find(Code::Sdo005, half.at, Facts::Unused(unused), cx);
            }
            Command::InitiateDownload(_, i) | Command::UploadInitiated(_, i)
                if half.command.has_invalid_unused() && (i.expedited || i.size_indicated) =>
            {
                self.find(Code::Sdo004, half.at, Facts::Unused(i.unused), cx);
            }
            Command::InitiateBlockUpload { blksize, .. } | Command::BlockDownloadInitiated { blksize, .. }
                if half.command.has_invalid_block_size() =>
            {
                self.find(Code::Sdo012, half.at, Facts::BlockSize(blksize), cx);
            }
            _ => {}
        }
        if half.command.has_reserved_bits(half.bytes) {
            self.find(Code::Sdo009, half.at, Facts::None, cx);
        }
    }

    /// A request and the response that answers it, in causal order.
    pub(super) fn answer(&mut self, request: Half, response: Half, cx: &mut Context<'_>) {
        self.pairing.pending = None;
        self.pairing.last_response = Some(response.bytes);
        if request.command.is_initiate() {
            self.pairing.initiated();
        }
        if request.command.is_initiate() && wire::fits(&request.command, &response.command) && !self.trusted {
            self.trust(cx);
        }
        if let Some(transfer) = &mut self.transfer {
            transfer.last = if response.at.no > request.at.no { response.at } else { request.at };
            transfer.reordered |= response.at.no < request.at.no;
        }
        if let (Some(expected), Some(found)) = (request.command.mux(), response.command.mux())
            && expected != found
        {
            self.find(Code::Sdo003, response.at, Facts::Objects { expected, found }, cx);
        }
        match (request.command, response.command) {
            (Command::InitiateUpload(_) | Command::InitiateBlockUpload { .. }, Command::UploadInitiated(_, i)) => {
                self.upload_initiated(response, i, cx);
            }
            (Command::InitiateDownload(_, i), _) => self.download_initiated(request, i, cx),
            (Command::SegmentRequest { toggle }, Command::Segment(segment)) => {
                self.check_toggle((request.at, toggle), (response.at, segment.toggle), cx);
                self.add_segment(response, segment, cx);
            }
            (Command::Segment(segment), Command::SegmentResponse { toggle }) => {
                self.check_toggle((request.at, segment.toggle), (response.at, toggle), cx);
                self.add_segment(request, segment, cx);
            }
            (
                Command::InitiateBlockUpload { crc: client, blksize, .. },
                Command::BlockUploadInitiated { crc: server, size, .. },
            ) => self.block_initiated(response.at, blksize, client && server, size),
            (
                Command::InitiateBlockDownload { crc: client, size, .. },
                Command::BlockDownloadInitiated { crc: server, blksize, .. },
            ) => self.block_initiated(request.at, blksize, client && server, size),
            (Command::EndBlock { .. }, _) => self.end_block_download(request, cx),
            _ => {}
        }
    }

    fn upload_initiated(&mut self, response: Half, i: Initiate, cx: &mut Context<'_>) {
        let Some(transfer) = &mut self.transfer else { return };
        transfer.initiated = Some(response.at);
        if i.expedited {
            transfer.mode = Mode::Expedited;
            transfer.size_indicated = i.size_indicated.then_some(4 - u32::from(i.unused & 3));
            transfer.append(i.data.get(..i.expedited_len(response.len)).unwrap_or(&[]));
            self.complete(Status::Ok, cx);
            return;
        }
        transfer.mode = Mode::Segmented;
        transfer.size_indicated = i.size();
        self.unmarked = i.size().is_none().then_some((response, i));
        self.phase = Phase::Segments { toggle: false };
    }

    fn download_initiated(&mut self, request: Half, i: Initiate, cx: &mut Context<'_>) {
        let Some(transfer) = &mut self.transfer else { return };
        transfer.initiated = Some(request.at);
        if i.expedited {
            transfer.append(i.data.get(..i.expedited_len(request.len)).unwrap_or(&[]));
            self.complete(Status::Ok, cx);
            return;
        }
        self.unmarked = i.size().is_none().then_some((request, i));
        self.phase = Phase::Segments { toggle: false };
    }

    fn check_toggle(&mut self, request: (FrameRef, bool), response: (FrameRef, bool), cx: &mut Context<'_>) {
        let Phase::Segments { toggle: expected } = &mut self.phase else { return };
        let due = *expected;
        let first_seen = self.transfer.as_ref().is_some_and(|t| t.mux.is_none() && t.segments == 0);
        *expected = if request.1 == response.1 { !request.1 } else { !due };
        if first_seen {
            return;
        }
        let wrong = if request.1 != due {
            Some((request, Side::Client))
        } else if response.1 != due {
            Some((response, Side::Server))
        } else {
            None
        };
        if let Some(((at, found), by)) = wrong {
            self.find(Code::Sdo001, at, Facts::Toggle { expected: due, found, by }, cx);
        }
    }

    /// The data of a segment that was confirmed (or whose request is not in the capture).
    pub(super) fn add_segment(&mut self, half: Half, segment: Segment, cx: &mut Context<'_>) {
        if let Some((initiate, i)) = self.unmarked.take()
            && i.unused != 0
        {
            self.find(Code::Sdo004, initiate.at, Facts::Unused(i.unused), cx);
        }
        let Some(transfer) = &mut self.transfer else { return };
        let carried = (7 - usize::from(segment.unused)).min(usize::from(half.len.saturating_sub(1)));
        transfer.append(segment.data.get(..carried).unwrap_or(&[]));
        transfer.segments = transfer.segments.saturating_add(1);
        transfer.even &= segment.last || segment.unused == 0;
        if segment.last {
            self.close_sized(half.at, cx);
        }
    }

    /// Ends a transfer whose data are all there: judges its size.
    pub(super) fn close_sized(&mut self, end: FrameRef, cx: &mut Context<'_>) {
        let Some(transfer) = &self.transfer else { return };
        let mut status = if transfer.hole || transfer.mux.is_none() { Status::Incomplete } else { Status::Ok };
        if !transfer.size_is_right() {
            let facts =
                Facts::Size { indicated: transfer.size_indicated.map_or(0, u64::from), transferred: transfer.size };
            let cause = transfer.initiated.unwrap_or(end);
            self.find(Code::Sdo006, if end.no == cx.at.no { cause } else { end }, facts, cx);
            status = Status::Failed;
        }
        self.complete(status, cx);
    }

    /// A transfer begins with a client's initiate request.
    pub(super) fn begin(&mut self, request: &Half, cx: &mut Context<'_>) {
        let id = self.next_id(cx);
        self.begin_as(id, request, cx);
    }

    /// The same, with a number that was given before.
    pub(super) fn begin_as(&mut self, id: TransferId, request: &Half, cx: &mut Context<'_>) {
        let (direction, mode) = match request.command {
            Command::InitiateDownload(_, i) if i.expedited => (Direction::Download, Mode::Expedited),
            Command::InitiateDownload(..) => (Direction::Download, Mode::Segmented),
            Command::InitiateBlockDownload { .. } => (Direction::Download, Mode::Block),
            Command::InitiateBlockUpload { .. } => (Direction::Upload, Mode::Block),
            _ => (Direction::Upload, Mode::Expedited),
        };
        let mut transfer =
            Box::new(Transfer::new(self.beginning(id, request.at, cx), direction, mode, request.command.mux()));
        transfer.size_indicated = match request.command {
            Command::InitiateDownload(_, i) if i.expedited && i.size_indicated => Some(4 - u32::from(i.unused & 3)),
            Command::InitiateDownload(_, i) => i.size(),
            Command::InitiateBlockDownload { size, .. } => size,
            _ => None,
        };
        self.transfer = Some(transfer);
        self.unmarked = None;
        self.phase = Phase::Initiated;
        self.outside = Outside::Violation;
    }

    /// A transfer met in its midst: its initiate request is not in the capture.
    pub(super) fn begin_midway(&mut self, at: FrameRef, direction: Direction, phase: Phase, cx: &mut Context<'_>) {
        let mode = if matches!(phase, Phase::Block(_)) { Mode::Block } else { Mode::Segmented };
        let id = self.next_id(cx);
        self.transfer = Some(Box::new(Transfer::new(self.beginning(id, at, cx), direction, mode, None)));
        self.phase = phase;
    }

    fn next_id(&self, cx: &mut Context<'_>) -> TransferId {
        *cx.next_transfer = cx.next_transfer.saturating_add(1);
        TransferId(*cx.next_transfer)
    }

    fn beginning(&self, id: TransferId, at: FrameRef, cx: &Context<'_>) -> Beginning {
        Beginning { id, bus: self.bus, node: self.node, extract: cx.extract, at }
    }

    /// Ends the transfer, whatever its phase.
    pub(super) fn complete(&mut self, status: Status, cx: &mut Context<'_>) {
        self.phase = Phase::Idle;
        self.unmarked = None;
        let Some(mut transfer) = self.transfer.take() else { return };
        transfer.status = status;
        transfer.last = if cx.at.no > transfer.last.no && status != Status::Incomplete { cx.at } else { transfer.last };
        let transfer = Arc::new(*transfer);
        if self.own {
            self.step.result = Some(Arc::clone(&transfer));
        }
        if self.pairing.is_tentative() {
            self.unsettled = Some(transfer);
        } else {
            self.announce(transfer, cx);
        }
    }

    /// Says that a transfer has ended.
    pub(super) fn announce(&mut self, transfer: Arc<Transfer>, cx: &mut Context<'_>) {
        if !transfer.fresh.is_empty() {
            cx.chunks.push(chunk(&transfer, transfer.fresh.clone()));
        }
        let about = (!self.own).then_some(transfer.last);
        cx.events.push(Event {
            at: cx.at,
            about,
            bus: self.bus,
            node: Some(self.node),
            transfer: Some(transfer.id),
            what: What::Transfer(transfer),
        });
    }

    pub(super) fn note(&mut self, note: Note, about: FrameRef, cx: &mut Context<'_>) {
        if !self.trusted {
            return;
        }
        cx.events.push(Event {
            at: cx.at,
            about: Some(about),
            bus: self.bus,
            node: Some(self.node),
            transfer: self.transfer.as_ref().map(|transfer| transfer.id),
            what: What::Note(note),
        });
    }

    /// A finding at the frame at hand, about `offender`.
    pub(super) fn find(&mut self, code: Code, offender: FrameRef, facts: Facts, cx: &mut Context<'_>) {
        // What is wrong with the channel's first frame itself counts if it can only be a request.
        let first = self.first == Some(cx.at) && self.plausible > 0;
        if !self.begun && !first && code != Code::Sdo017 {
            return;
        }
        let object = match &mut self.transfer {
            Some(transfer) => {
                transfer.note_finding(code);
                transfer.mux
            }
            None => self.step.result.as_ref().and_then(|transfer| transfer.mux),
        };
        let finding = Finding {
            code,
            at: cx.at,
            cause: (offender.no != cx.at.no).then_some(offender),
            bus: self.bus,
            node: Some(self.node),
            object,
            facts,
        };
        if self.trusted {
            push_finding(finding, cx);
        } else if self.withheld.len() < WITHHELD {
            self.withheld.push(finding);
        }
    }

    fn trust(&mut self, cx: &mut Context<'_>) {
        self.trusted = true;
        self.begun = true;
        for finding in std::mem::take(&mut self.withheld) {
            push_finding(finding, cx);
        }
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

    pub(super) fn is_trusted(&self) -> bool {
        self.trusted
    }

    /// An abort, from either side: it ends the transfer, and is never answered.
    pub(super) fn abort(&mut self, side: Side, at: FrameRef, code: u32, cx: &mut Context<'_>) {
        if let Some(pending) = self.pairing.pending {
            match (side, pending.command) {
                (Side::Client, _) if code == super::TIMED_OUT => {
                    self.find(Code::Sdo002, pending.at, Facts::Missing { by: Side::Server }, cx);
                }
                (Side::Server, Command::SegmentRequest { toggle } | Command::Segment(Segment { toggle, .. })) => {
                    if let Phase::Segments { toggle: due } = self.phase
                        && due != toggle
                    {
                        let facts = Facts::Toggle { expected: due, found: toggle, by: Side::Client };
                        self.find(Code::Sdo001, pending.at, facts, cx);
                    }
                    self.judge_refused_segment(pending, cx);
                }
                (Side::Server, Command::EndBlock { .. }) => self.judge_refused_end(pending, cx),
                _ => {}
            }
        }
        self.judge_aborted_block(cx);
        self.find(Code::Sdo017, at, Facts::Abort { code, by: side }, cx);
        if let Some(transfer) = &mut self.transfer {
            transfer.abort = Some(Abort { code, by: side });
            transfer.last = at;
        }
        self.complete(Status::Aborted, cx);
        self.outside = if self.begun { Outside::Violation } else { Outside::Uncaptured };
    }

    /// A last segment that the server refused: was it for its size?
    fn judge_refused_segment(&mut self, pending: Half, cx: &mut Context<'_>) {
        let (Command::Segment(segment), Some(transfer)) = (pending.command, &self.transfer) else { return };
        let Some(indicated) = transfer.size_indicated.map(u64::from) else { return };
        let transferred = transfer.size.saturating_add(u64::from(7 - segment.unused));
        if !transfer.hole && (transferred > indicated || (segment.last && transferred != indicated)) {
            self.find(Code::Sdo006, pending.at, Facts::Size { indicated, transferred }, cx);
        }
    }

    /// The server was reset, or frames were lost: nothing that was open can be judged.
    pub fn lost(&mut self, reset: bool, cx: &mut Context<'_>) {
        self.own = false;
        self.settle(cx);
        if self.transfer.is_some() {
            if let Some(about) = self.transfer.as_ref().map(|transfer| transfer.first)
                && reset
            {
                self.note(Note::LostByReset, about, cx);
            }
            self.complete(Status::Incomplete, cx);
        }
        self.own = true;
        self.pairing = Pairing::default();
        self.held_ack = None;
        self.phase = Phase::Idle;
        self.outside = if reset { Outside::Said } else { Outside::Uncaptured };
    }

    /// The capture is over: what is still open is incomplete, and what was withheld is said once.
    pub fn finish(&mut self, cx: &mut Context<'_>) {
        self.own = false;
        self.settle_held_at_end(cx);
        self.settle(cx);
        let aged = |from: FrameRef| match (from.t_ns, cx.at.t_ns) {
            (Some(from), Some(to)) => to.saturating_sub(from) > UNANSWERED_NS,
            _ => false,
        };
        let pending_is_old = self.pairing.pending.is_some_and(|pending| aged(pending.at));
        let idle_is_old = self.transfer.as_ref().is_some_and(|transfer| aged(transfer.last));
        if let Some(pending) = self.pairing.pending
            && pending_is_old
            && !self.pairing.abort_may_answer
        {
            self.find(Code::Sdo002, pending.at, Facts::Missing { by: Side::Server }, cx);
        }
        if let Some((_, i)) = self.unmarked
            && (i.unused != 0 || i.data != [0; 4] || idle_is_old)
        {
            self.recognise_unmarked(cx);
        }
        if idle_is_old && self.all_bytes_without_last() {
            let last = self.transfer.as_ref().map_or(cx.at, |transfer| transfer.last);
            self.find(Code::Sdo007, last, Facts::NoLast, cx);
        }
        let nameless = !self.trusted && !self.pairing.pending.is_some_and(|pending| strict_initiate(&pending));
        if nameless {
            self.transfer = None;
        } else if self.pairing.abort_may_answer {
            self.answered_by_abort(cx);
        } else {
            self.complete(Status::Incomplete, cx);
        }
        self.say_distrust(cx);
    }

    fn say_distrust(&mut self, cx: &mut Context<'_>) {
        let Some(first) = self.first else { return };
        if self.trusted {
            return;
        }
        let unanswered = self.requests > 0 && self.responses == 0 && self.plausible > 0;
        let nothing_odd =
            self.withheld.iter().all(|finding| finding.code.rule().severity == crate::finding::Severity::Info);
        let code = if unanswered { Code::Sdo031 } else { Code::Sdo030 };
        let few = self.requests.saturating_add(self.responses) < 2;
        if (!unanswered && few) || (unanswered && !nothing_odd && self.requests < 2) {
            return;
        }
        let finding = Finding {
            code,
            at: first,
            cause: None,
            bus: self.bus,
            node: Some(self.node),
            object: None,
            facts: Facts::Frames { count: self.requests.saturating_add(self.responses) },
        };
        push_finding(finding, cx);
    }

    /// Whether all indicated bytes were transferred though no segment was marked as the last one.
    pub(super) fn all_bytes_without_last(&self) -> bool {
        matches!(self.phase, Phase::Segments { .. })
            && self.transfer.as_ref().is_some_and(|transfer| {
                !transfer.hole
                    && transfer.segments > 0
                    && transfer.size_indicated.is_some_and(|size| u64::from(size) <= transfer.size)
            })
    }

    /// An initiate with e = s = 0 that no segment followed: its four bytes were meant as data.
    pub(super) fn recognise_unmarked(&mut self, cx: &mut Context<'_>) {
        let Some((initiate, i)) = self.unmarked.take() else { return };
        let code = match self.transfer.as_ref().map(|transfer| transfer.direction) {
            Some(Direction::Upload) => Code::Sdo022,
            _ => Code::Sdo021,
        };
        self.find(code, initiate.at, Facts::Unused(i.unused), cx);
        if let Some(transfer) = &mut self.transfer {
            transfer.mode = Mode::Expedited;
            let carried = 4 - usize::from(i.unused & 3);
            transfer.append(i.data.get(..carried).unwrap_or(&[]));
        }
        let own = std::mem::replace(&mut self.own, false);
        let last = self.transfer.as_ref().map(|transfer| transfer.last);
        if let (Some(transfer), Some(last)) = (self.transfer.take(), last) {
            let mut transfer = *transfer;
            transfer.status = Status::Ok;
            transfer.last = last;
            self.announce(Arc::new(transfer), cx);
        }
        self.phase = Phase::Idle;
        self.own = own;
    }
}

fn chunk(transfer: &Transfer, bytes: Vec<u8>) -> Chunk {
    Chunk { id: transfer.id, bus: transfer.bus, node: transfer.node, mux: transfer.mux, bytes }
}

fn push_finding(finding: Finding, cx: &mut Context<'_>) {
    cx.events.push(Event {
        at: finding.at,
        about: finding.cause,
        bus: finding.bus,
        node: finding.node,
        transfer: None,
        what: What::Finding(finding),
    });
}

/// Whether a frame can only be meant as an initiate request: a communication or device object, no reserved bits.
pub(super) fn strict_initiate(half: &Half) -> bool {
    half.command.is_initiate()
        && half.command.mux().is_some_and(|Mux { index, .. }| index >= 0x1000)
        && !half.command.has_reserved_bits(half.bytes)
        && match half.command {
            Command::InitiateDownload(_, i) => i.expedited || i.size_indicated,
            _ => true,
        }
}

//! One SDO channel: the owner of its pairing and of its transfer.
//!
//! It takes a frame, says what it is, and begins and ends transfers. It must not look at other channels.

use std::collections::VecDeque;
use std::sync::Arc;

use super::block::Block;
use super::judgement::{OddExchange, Proof, Verdicts};
use super::pairing::Pairing;
use super::sequence::{Sequence, within};
use super::transfer::{Beginning, Direction, Mode, Status, Transfer, TransferId};
use super::wire::{self, Command, Initiate, Mux, Side};
use crate::context::{Chunk, Context};
use crate::dictionary::{Dictionary, Object};
use crate::event::{Event, Note, Place, Step, What};
use crate::evidence::When;
use crate::evidence::duplicates::Sighting;
use crate::frame::{BusId, CanId, Frame, FrameRef};
use crate::rules::sdo::{Sdo002, Sdo007};

/// Bytes of a running transfer that are gathered before they are handed out.
const CHUNK: usize = 4096;
/// Age in ns at which a request at the capture's end counts as unanswered (CiA 301 leaves the time to the client).
pub(super) const UNANSWERED_NS: i64 = 1_000_000_000;

/// Who looks for a server sends it so many requests at most.
const PROBES: u64 = 3;
/// Frames that are kept since they may be shown a second time.
const ONCE: usize = 128;

/// One frame of the channel, kept until the other half of its exchange is known.
#[derive(Clone, Copy, Debug)]
pub(super) struct Half {
    pub(super) at: FrameRef,
    pub(super) when: When,
    pub(super) command: Command,
    pub(super) bytes: [u8; 8],
    pub(super) len: u8,
}

impl Half {
    /// Eight bytes without a place in the capture.
    pub(super) fn of(bytes: [u8; 8]) -> Self {
        Self { at: FrameRef::default(), when: When::default(), command: Command::Unknown(0), bytes, len: 8 }
    }
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
    /// Its identifier from client to server, where it is not the server's default channel.
    id: Option<CanId>,
    /// The server's description.
    description: Option<Arc<Dictionary>>,
    pub(super) pairing: Pairing,
    pub(super) phase: Phase,
    pub(super) transfer: Option<Box<Transfer>>,
    /// Initiate with e = s = 0, until a segment shows what was meant.
    pub(super) unmarked: Option<(Half, Initiate)>,
    /// The server has sent segments after one of those; whether that one had other bytes than 0 in the place of data.
    pub(super) segments_unmarked: Option<bool>,
    pub(super) sequence: Sequence,
    pub(super) proof: Proof,
    pub(super) verdicts: Verdicts,
    pub(super) outside: Outside,
    /// The step of the frame at hand.
    pub(super) step: Step,
    /// Whether completed transfers belong to the frame at hand.
    pub(super) own: bool,
    /// The last expedited write, where it was given up and nothing was answered since.
    pub(super) left: Option<Arc<Transfer>>,
    /// The same, confirmed by the frame at hand after all.
    pub(super) confirmed: Option<Arc<Transfer>>,
    /// The last request was one to a server that must not answer.
    pub in_vain: Option<FrameRef>,
    /// Its server was only looked for, as all others were.
    pub scanned: bool,
    /// The last frames and their steps, which may be captured a second time.
    once: VecDeque<(Half, Step)>,
}

fn empty_step() -> Step {
    Step {
        side: Side::Client,
        command: Command::Unknown(0),
        mux: None,
        described: None,
        ordinal: 0,
        answered_by: None,
        place: Place::Due,
        result: None,
    }
}

impl Channel {
    /// A channel of the server `node` on `bus`, of which nothing was seen.
    pub fn new(bus: BusId, node: u8, id: Option<CanId>) -> Self {
        Self {
            bus,
            node,
            id,
            description: None,
            pairing: Pairing::default(),
            phase: Phase::Idle,
            transfer: None,
            unmarked: None,
            segments_unmarked: None,
            sequence: Sequence::default(),
            proof: Proof::default(),
            verdicts: Verdicts::default(),
            outside: Outside::Uncaptured,
            step: empty_step(),
            own: true,
            left: None,
            confirmed: None,
            in_vain: None,
            scanned: false,
            once: VecDeque::new(),
        }
    }

    /// The capture has run for `heard_ns` without a frame of the channel, or its server has `booted` since it began:
    /// what comes first does not belong to what came before the capture.
    pub fn idle_for(&mut self, heard_ns: i64, booted: bool) {
        if booted || heard_ns > UNANSWERED_NS {
            self.pairing.first = Some(u64::MAX);
        }
    }

    /// Whether the capture is known to show the channel from its first frame on.
    pub(super) fn is_idle_from_start(&self) -> bool {
        self.pairing.first == Some(u64::MAX)
    }

    /// The server's node-ID.
    pub fn node(&self) -> u8 {
        self.node
    }

    /// Whether a server was looked for, and none has answered.
    pub fn is_probed(&self) -> bool {
        self.proof.responses == 0
            && (1..=PROBES).contains(&self.proof.requests)
            && self.proof.plausible == self.proof.requests
    }

    /// The completed transfer that the frame at hand confirms late.
    pub fn confirmed(&self) -> Option<&Arc<Transfer>> {
        self.confirmed.as_ref()
    }

    /// The transfer that runs, with what the description says of its object; none where the channel's frames are no SDO.
    pub fn running(&self) -> Option<(&Transfer, Option<Arc<Object>>)> {
        let transfer = self.transfer.as_deref().filter(|_| !self.is_foreign())?;
        Some((transfer, self.described(transfer.mux)))
    }

    /// Gives the server's objects names and types.
    pub fn describe(&mut self, description: Option<Arc<Dictionary>>) {
        self.description = description;
    }

    pub(super) fn described(&self, mux: Option<Mux>) -> Option<Arc<Object>> {
        let Mux { index, sub } = mux?;
        self.description.as_ref()?.get(index, sub).cloned()
    }

    /// Takes one frame of the channel (classic, data): appends one `What::Sdo` event and what follows from it.
    pub fn step(&mut self, side: Side, frame: &Frame, cx: &mut Context<'_>) {
        let half = Half {
            at: frame.reference(),
            when: cx.when,
            command: self.decode(side, frame.head(), frame.len),
            bytes: frame.head(),
            len: frame.len,
        };
        self.confirmed = None;
        if cx.sighting == Sighting::Duplicate
            && let Some(step) = self.twin(side, &half)
        {
            cx.events.push(Event {
                at: half.at,
                about: None,
                bus: self.bus,
                node: Some(self.node),
                transfer: None,
                what: What::Sdo(step),
            });
            return;
        }
        self.proof.first.get_or_insert(half.at);
        self.excuse_answer();
        match side {
            Side::Client => self.proof.requests = self.proof.requests.saturating_add(1),
            Side::Server => self.proof.responses = self.proof.responses.saturating_add(1),
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
        let half = self.order_before(side, half, cx);
        self.step.command = half.command;
        self.proof.plausible = self.proof.plausible.saturating_add(u64::from(strict_initiate(&half)));
        let odd = matches!(half.command, Command::Unknown(_)) || half.command.has_reserved_bits(half.bytes);
        self.proof.odd = self.proof.odd.saturating_add(u64::from(odd));
        if strict_initiate(&half) && !matches!(half.command, Command::InitiateDownload(..)) {
            // What was odd may have been block data of a transfer that began before the capture.
            self.proof.odd = 0;
        }
        let later = self.proof.first != Some(half.at) || self.pairing.first.is_some_and(|first| first != half.at.no);
        if half.command.is_initiate() && strict_initiate(&half) && later {
            self.proof.begun = true;
        }
        let before = self.transfer.as_ref().map(|transfer| (transfer.id, transfer.mux));
        self.note_unreadable(side, &half);
        match side {
            Side::Client => {
                self.order_client(half, cx);
                self.judge_frame(&Half { command: self.step.command, ..half }, cx);
            }
            Side::Server => {
                let fresh = *self.pairing.first.get_or_insert(half.at.no) == half.at.no;
                self.order_server(half, fresh, cx);
            }
        }
        let after = self.transfer.as_ref().map(|transfer| (transfer.id, transfer.mux));
        let done = self.step.result.as_ref().map(|transfer| (transfer.id, transfer.mux));
        let of = done.or(after).or(before);
        self.step.mux = of.and_then(|(_, mux)| mux);
        self.step.described = self.described(self.step.mux.or(self.step.command.mux()));
        let step = std::mem::replace(&mut self.step, empty_step());
        if !cx.evidence.recording.shows_once() {
            if self.once.len() == ONCE {
                self.once.pop_front();
            }
            self.once.push_back((half, Step { place: Place::Twin, answered_by: None, result: None, ..step.clone() }));
        }
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

    /// The step of a frame that the capture shows a second time: that of the first equal one which was not shown again.
    fn twin(&mut self, side: Side, half: &Half) -> Option<Step> {
        let equal =
            |(before, step): &(Half, Step)| step.side == side && before.bytes == half.bytes && before.len == half.len;
        let place = self.once.iter().position(equal)?;
        self.once.drain(..=place).next_back().map(|(_, step)| step)
    }

    /// Which command the frame is, given where the transfer stands.
    pub(super) fn decode(&self, side: Side, bytes: [u8; 8], len: u8) -> Command {
        if let Phase::Block(block) = &self.phase
            && self.sends_data(side)
            && len > 0
        {
            return self.decode_in_block(block, side, bytes);
        }
        wire::decode_frame(side, bytes, len)
    }

    pub(super) fn sends_data(&self, side: Side) -> bool {
        let upload = self.transfer.as_ref().is_some_and(|transfer| transfer.direction == Direction::Upload);
        upload == (side == Side::Server)
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
            Command::InitiateDownload(_, i) => i.size().filter(|_| request.len == 8),
            Command::InitiateBlockDownload { size, .. } => size.filter(|_| request.len == 8),
            _ => None,
        };
        self.transfer = Some(transfer);
        self.unmarked = None;
        self.phase = Phase::Initiated;
        self.outside = Outside::Violation;
    }

    pub(super) fn next_id(&self, cx: &mut Context<'_>) -> TransferId {
        *cx.next_transfer = cx.next_transfer.saturating_add(1);
        TransferId(*cx.next_transfer)
    }

    pub(super) fn beginning(&self, id: TransferId, at: FrameRef, cx: &Context<'_>) -> Beginning {
        Beginning { id, bus: self.bus, node: self.node, channel: self.id, extract: cx.extract, at }
    }

    /// Ends the transfer, whatever its phase.
    pub(super) fn complete(&mut self, status: Status, cx: &mut Context<'_>) {
        self.phase = Phase::Idle;
        self.unmarked = None;
        let Some(mut transfer) = self.transfer.take() else { return };
        transfer.described = self.described(transfer.mux);
        transfer.status = if transfer.bad && status == Status::Ok { Status::Failed } else { status };
        transfer.last = if cx.at.no > transfer.last.no && status != Status::Incomplete { cx.at } else { transfer.last };
        let transfer = Arc::new(*transfer);
        let left = matches!(transfer.status, Status::Failed | Status::Aborted) && transfer.mode == Mode::Expedited;
        self.left = left.then(|| Arc::clone(&transfer));
        if self.own {
            self.step.result = Some(Arc::clone(&transfer));
        }
        self.announce(transfer, cx);
    }

    /// Says that a transfer has ended.
    pub(super) fn announce(&mut self, transfer: Arc<Transfer>, cx: &mut Context<'_>) {
        if self.is_foreign() {
            self.step.result = None;
            return;
        }
        if transfer.status == Status::Ok && transfer.direction == Direction::Download {
            self.verdicts.refused.retain(|refused| Some(refused.object) != transfer.mux);
        }
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

    /// The server was reset, or frames were lost: nothing that was open can be judged.
    pub fn lost(&mut self, reset: bool, cx: &mut Context<'_>) {
        self.own = false;
        self.order_rest(cx);
        if reset
            && let Some(pending) = self.pairing.pending
            && !within(pending.at, cx.at, UNANSWERED_NS)
            && !self.is_edge(&pending)
            && !self.pairing.may_be_answered(&pending)
        {
            self.find(Sdo002::NoResponse, pending.at, cx);
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
        self.pairing = Pairing::default();
        (self.left, self.confirmed) = (None, None);
        self.sequence = Sequence::default();
        self.verdicts.odd_exchange = OddExchange::default();
        self.verdicts.fault = None;
        self.phase = Phase::Idle;
        self.outside = if reset { Outside::Said } else { Outside::Uncaptured };
        if !reset {
            self.restart();
        }
    }

    /// Behind a gap a transfer may be half-way, as at the capture's beginning: block data look like commands until an
    /// exchange shows where the channel stands.
    fn restart(&mut self) {
        self.proof = Proof { proven: self.proof.proven, ..Proof::default() };
        self.verdicts.withheld.clear();
    }

    /// The capture is over: what is still open is incomplete, and what was withheld is said once.
    pub fn finish(&mut self, cx: &mut Context<'_>) {
        self.own = false;
        self.excuse_answer();
        self.order_rest(cx);
        let aged = |from: FrameRef| match (from.t_ns, cx.at.t_ns) {
            (Some(from), Some(to)) => to.saturating_sub(from) > UNANSWERED_NS,
            _ => false,
        };
        let pending_is_old = self.pairing.pending.is_some_and(|pending| self.is_overdue(&pending, cx));
        let idle_is_old = self.transfer.as_ref().is_some_and(|transfer| aged(transfer.last));
        if let Some(pending) = self.pairing.pending
            && pending_is_old
            && !self.pairing.abort_may_answer
            && !self.pairing.may_be_answered(&pending)
        {
            self.find(Sdo002::NoResponse, pending.at, cx);
        }
        if let Some((_, i)) = self.unmarked
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
        let nameless = !self.proof.trusted && !self.pairing.pending.is_some_and(|pending| strict_initiate(&pending));
        if nameless {
            self.transfer = None;
        } else if self.pairing.abort_may_answer {
            self.answered_by_abort(cx);
        } else {
            self.complete(Status::Incomplete, cx);
        }
        self.find_refused(cx);
        self.say_distrust(cx);
    }
}

fn chunk(transfer: &Transfer, bytes: Vec<u8>) -> Chunk {
    Chunk { id: transfer.id, bus: transfer.bus, node: transfer.node, mux: transfer.mux, bytes }
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

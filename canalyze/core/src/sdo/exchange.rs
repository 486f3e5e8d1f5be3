//! Effects of responses and aborts outside sub-blocks (CiA 301, 7.2.4.3.2 to 7.2.4.3.7 and 7.2.4.3.17).
//!
//! Request and response come here in causal order, regardless of the capture's; toggle bits and sizes are judged only
//! here. An abort by either side ends the transfer and is never answered. Its multiplexor is unreliable, so it belongs
//! to its channel's transfer, not to an object. Frames that were on their way may follow it.

use std::sync::Arc;

use super::abort_code::AbortCode;
use super::block::Block;
use super::limits::{GIVEN_UP_NS, within};
use super::phase::{Half, Phase, Segments, strict_initiate};
use super::state::{Refused, SdoChannel, UnderWay};
use super::transfer::{Abort, Direction, Mode, Status, Transfer};
use super::wire::{self, Command, Initiate, Mux, Segment, Side};
use crate::bytes::frame::FrameRef;
use crate::rules::sdo::{
    Sdo001, Sdo002, Sdo003, Sdo004, Sdo006, Sdo007, Sdo016, Sdo017, Sdo020, Sdo021, Sdo022, Sdo024,
};
use crate::words::profiles::Profile;
use crate::world::context::Context;
use crate::world::event::Place;
use crate::world::od::DataType;

/// Abort code: SDO protocol timed out.
/// Number of bytes in two segments.
const PAIR: u64 = 14;
/// Maximum number of refused writes that are remembered.
const REFUSED: usize = 64;

impl SdoChannel {
    /// Takes a request and its response, in causal order.
    pub(super) fn answer(&mut self, request: Half, response: Half, cx: &mut Context<'_>) {
        self.end_unasked(cx);
        self.clear_pending();
        self.given_up_write.left = None;
        self.pair(&request, &response, cx);
        self.compare_objects(&request, &response, cx);
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
            ) => self.block_initiated(response.at, blksize, client && server, size.filter(|_| response.len == 8)),
            (
                Command::InitiateBlockDownload { crc: client, size, .. },
                Command::BlockDownloadInitiated { crc: server, blksize, .. },
            ) => self.block_initiated(request.at, blksize, client && server, size.filter(|_| request.len == 8)),
            (Command::EndBlock { .. }, _) => {
                self.settle_end(&request, cx);
                self.agree_on_end(cx);
            }
            _ => {}
        }
    }

    /// Learns from a pair about the recording, the channel, and the order of its frames.
    fn pair(&mut self, request: &Half, response: &Half, cx: &mut Context<'_>) {
        let fits = wire::fits(&request.command, &response.command);
        if let (Some(asked), Some(answered), true) = (request.at.t_ns, response.at.t_ns, fits) {
            let in_order = request.at.no < response.at.no;
            cx.evidence.recording.exchanged((answered - asked).abs(), in_order);
        }
        self.judge_time(request, response, cx);
        self.history.last_request = Some(request.command);
        self.history.last_response = Some(response.bytes);
        self.sequence.answered = (request.at.no < response.at.no).then_some(*response);
        if fits {
            self.proof.paired = true;
            if request.command.is_initiate() && !self.proof.trusted {
                self.trust(cx);
            }
        }
        if let Some(transfer) = &mut self.transfer {
            transfer.last = if response.at.no > request.at.no { response.at } else { request.at };
            transfer.outcome.reordered |= response.at.no < request.at.no;
        }
    }

    /// Compares the objects of an initiate response and its request.
    fn compare_objects(&mut self, request: &Half, response: &Half, cx: &mut Context<'_>) {
        if let (Some(expected), Some(found)) = (request.command.mux(), response.command.mux())
            && expected != found
        {
            if !self.proof.trusted && strict_initiate(request) && !response.command.has_reserved_bits(response.bytes) {
                // Only the object differs, so it is a request and its response.
                self.trust(cx);
            }
            self.find(Sdo003::Objects { expected, found }, response.at, cx);
            if let Some(transfer) = &mut self.transfer {
                transfer.outcome.bad = true;
            }
        }
    }

    fn upload_initiated(&mut self, response: Half, i: Initiate, cx: &mut Context<'_>) {
        let Some(transfer) = &mut self.transfer else { return };
        transfer.data.initiated = Some(response.at);
        if i.expedited {
            transfer.mode = Mode::Expedited;
            transfer.data.size_indicated = i.size_indicated.then_some(4 - u32::from(i.unused & 3));
            if transfer.outcome.bad {
                self.complete(Status::Failed, cx);
                return;
            }
            transfer.append(expedited(transfer.mux, self.server.profile, &i, response.len));
            transfer.miss(Some(lacking(&i, response.len)));
            self.close_sized(response.at, cx);
            return;
        }
        transfer.mode = Mode::Segmented;
        transfer.data.size_indicated = i.size().filter(|_| response.len == 8);
        let unmarked = i.size().is_none().then_some((response, i));
        self.phase = Phase::Segments(Segments { unmarked, ..Segments::from(false) });
    }

    fn download_initiated(&mut self, request: Half, i: Initiate, cx: &mut Context<'_>) {
        let Some(transfer) = &mut self.transfer else { return };
        transfer.data.initiated = Some(request.at);
        if i.expedited {
            transfer.append(expedited(transfer.mux, self.server.profile, &i, request.len));
            transfer.miss(Some(lacking(&i, request.len)));
            self.close_sized(request.at, cx);
            return;
        }
        let unmarked = i.size().is_none().then_some((request, i));
        self.phase = Phase::Segments(Segments { unmarked, ..Segments::from(false) });
    }

    /// Returns true if a response answers the abandoned request.
    pub(super) fn is_late(&self, half: &Half) -> bool {
        self.history.given_up.is_some_and(|request| wire::fits(&request.command, &half.command))
    }

    pub(super) fn late(&mut self, half: &Half, cx: &mut Context<'_>) {
        self.step.place = Place::Late;
        let request = self.history.given_up.take();
        self.step.answered_by = request.map(|request| Box::new(request.at));
        if let Some(request) = request {
            let same = strict_initiate(&request) && request.command.mux() == half.command.mux();
            if same && !self.proof.trusted && self.proof.given_up > 0 && !self.history.booted {
                // A response behind the client's abort proves the channel like one in time.
                self.proof.paired = true;
                self.trust(cx);
            }
            self.confirm_late(&request);
        }
        self.verdicts.about = half.command.mux();
        let late = if self.history.booted { Sdo020::Booted } else { Sdo020::GivenUp };
        self.find(late, self.step.answered_by.as_deref().copied().unwrap_or(half.at), cx);
    }

    /// Takes the late answer to an abandoned request: its write has succeeded. The server answers in order, so this
    /// holds until it answers another.
    fn confirm_late(&mut self, request: &Half) {
        let left = self.given_up_write.left.take().filter(|left| left.first == request.at);
        if let (Some(left), Command::InitiateDownload(mux, i)) = (left, request.command)
            && i.expedited
            && left.data.kept.is_empty()
            && !lacks_data(&i, request.len)
        {
            let mut transfer = Transfer::clone(&left);
            transfer.append(expedited(Some(mux), self.server.profile, &i, request.len));
            (transfer.outcome.status, transfer.outcome.abort) = (Status::Ok, None);
            self.given_up_write.confirmed = Some(Arc::new(transfer));
        }
    }

    fn check_toggle(&mut self, request: (FrameRef, bool), response: (FrameRef, bool), cx: &mut Context<'_>) {
        let Phase::Segments(segments) = &mut self.phase else { return };
        let due = segments.toggle;
        segments.toggle = if request.1 == response.1 { !request.1 } else { !due };
        let wrong = if request.1 != due {
            Some((request, Side::Client))
        } else if response.1 != due {
            Some((response, Side::Server))
        } else {
            None
        };
        let Some(((at, found), by)) = wrong else { return };
        let toggle = Sdo001::Toggle { expected: due, found, by };
        if request.1 != due && response.1 == due {
            return self.find(toggle, at, cx);
        }
        // A frame lost between them, or two before them, would look the same.
        segments.doubtful = by == Side::Server;
        self.doubt(toggle, at, false, cx);
    }

    /// Takes a request for the next segment, or that segment; it shows if the client accepted the one before.
    pub(super) fn request(&mut self, half: Half, cx: &mut Context<'_>) {
        if let (Phase::Segments(segments), Some(transfer)) = (&mut self.phase, &self.transfer) {
            segments.pace.take(half.at, transfer.data.size);
        }
        if let Phase::Segments(segments) = &mut self.phase
            && std::mem::take(&mut segments.doubtful)
            && let Command::SegmentRequest { toggle } | Command::Segment(Segment { toggle, .. }) = half.command
        {
            if segments.toggle == toggle {
                self.confirm_doubts(cx);
            } else {
                segments.toggle = toggle;
            }
        }
        self.step.ordinal = self.segment_ordinal(&half.command);
        self.set_pending(half);
    }

    /// Adds the data of a confirmed segment (or one whose request is not in the capture).
    pub(super) fn add_segment(&mut self, half: Half, segment: Segment, cx: &mut Context<'_>) {
        if let Some((initiate, i)) = self.take_unmarked() {
            if matches!(initiate.command, Command::UploadInitiated(..)) {
                let before = self.server.segments_unmarked.unwrap_or(false);
                self.server.segments_unmarked = Some(before | has_data(&i));
            }
            if i.unused != 0 {
                self.find(Sdo004::Unused { unused: i.unused.into() }, initiate.at, cx);
            }
        }
        let Some(transfer) = &mut self.transfer else { return };
        transfer.append_segment(&segment, half.len);
        transfer.data.segments = transfer.data.segments.saturating_add(1);
        transfer.data.even &= segment.last || segment.unused == 0;
        if segment.last {
            self.close_sized(half.at, cx);
        }
    }

    /// Ends a transfer with all its data; judges its size.
    fn close_sized(&mut self, end: FrameRef, cx: &mut Context<'_>) {
        self.weigh_doubts(cx);
        self.weigh_pace(cx);
        let Some(transfer) = &mut self.transfer else { return };
        transfer.reach_end();
        let mut status = if transfer.data.hole || transfer.outcome.midway { Status::Incomplete } else { Status::Ok };
        if !transfer.size_is_right() {
            let cause = transfer.data.initiated.unwrap_or(end);
            let size = wrong_size(transfer);
            self.find(size, if end.no == cx.at.no { cause } else { end }, cx);
            status = Status::Failed;
        }
        self.complete(status, cx);
        if status == Status::Failed && !self.is_one_sided() {
            // If it was not the last segment, later ones belong to nothing.
            self.hypotheses.report();
        }
    }

    /// Explains missing bytes by lost segments: an even number leaves the toggle bits unchanged, and one interval must
    /// have room for their exchanges.
    fn weigh_pace(&mut self, cx: &mut Context<'_>) {
        let (Phase::Segments(segments), Some(transfer)) = (&self.phase, &mut self.transfer) else { return };
        let indicated = transfer.data.size_indicated.map_or(0, u64::from);
        let bytes = indicated.saturating_sub(transfer.data.size);
        let whole =
            bytes > 0 && bytes % PAIR == 0 && transfer.data.even && !transfer.data.hole && !transfer.outcome.bad;
        if let Some(offset) = segments.pace.room_for(bytes / 7).filter(|_| whole) {
            transfer.miss_before(offset);
            self.find(Sdo024::Missing { missing: bytes / 7 }, cx.at, cx);
        }
    }

    /// Returns true if all indicated bytes were transferred without a segment marked as last.
    pub(super) fn all_bytes_without_last(&self) -> bool {
        matches!(self.phase, Phase::Segments(_))
            && self.transfer.as_ref().is_some_and(|transfer| {
                !transfer.data.hole
                    && transfer.data.segments > 0
                    && transfer.data.size_indicated.is_some_and(|size| u64::from(size) <= transfer.data.size)
            })
    }

    /// Returns true if an initiate with e = s = 0 and no segments was meant as data. It is not if the server has sent
    /// segments after the same; bytes that it does not leave in them otherwise are data.
    pub(super) fn is_meant_as_data(&self) -> bool {
        let announces = |i: &Initiate| self.server.segments_unmarked.is_some_and(|other| other || !has_data(i));
        self.unmarked()
            .is_some_and(|(initiate, i)| !(matches!(initiate.command, Command::UploadInitiated(..)) && announces(&i)))
    }

    /// Returns the initiate with e = s = 0 that no segment has followed.
    pub(super) fn unmarked(&self) -> Option<(Half, Initiate)> {
        if let Phase::Segments(segments) = &self.phase { segments.unmarked } else { None }
    }

    fn take_unmarked(&mut self) -> Option<(Half, Initiate)> {
        if let Phase::Segments(segments) = &mut self.phase { segments.unmarked.take() } else { None }
    }

    /// Takes the four bytes of an initiate with e = s = 0 and no segments as data.
    pub(super) fn recognise_unmarked(&mut self, cx: &mut Context<'_>) {
        let Some((initiate, i)) = self.take_unmarked() else { return };
        let unused = i.unused.into();
        match self.transfer.as_ref().map(|transfer| transfer.direction) {
            Some(Direction::Upload) => self.find(Sdo022::Unused { unused }, initiate.at, cx),
            _ => self.find(Sdo021::Unused { unused }, initiate.at, cx),
        }
        if let Some(transfer) = &mut self.transfer {
            transfer.mode = Mode::Expedited;
            let carried = 4 - usize::from(i.unused & 3);
            transfer.append(i.data.get(..carried).unwrap_or(&[]));
        }
        self.phase = Phase::Idle;
        let Some(mut transfer) = self.transfer.take() else { return };
        transfer.described = self.described(transfer.mux);
        transfer.outcome.status = Status::Ok;
        let own = std::mem::replace(&mut self.own, false);
        self.announce(Arc::new(*transfer), cx);
        self.own = own;
    }

    /// Takes an abort from either side: it ends the transfer and is never answered.
    fn abort(&mut self, side: Side, at: FrameRef, code: AbortCode, cx: &mut Context<'_>) {
        if let Some(pending) = self.pending() {
            match (side, pending.command) {
                (Side::Client, _) if code.is_timeout() => {
                    self.find(Sdo002::NoResponse, pending.at, cx);
                }
                (Side::Server, Command::SegmentRequest { toggle } | Command::Segment(Segment { toggle, .. })) => {
                    if let Phase::Segments(Segments { toggle: due, .. }) = self.phase
                        && due != toggle
                    {
                        let wrong = Sdo001::Toggle { expected: due, found: toggle, by: Side::Client };
                        self.find(wrong, pending.at, cx);
                    }
                    self.judge_refused_segment(pending, cx);
                }
                (Side::Server, Command::EndBlock { .. }) => self.settle_end(&pending, cx),
                _ => {}
            }
        }
        if side == Side::Client && code.is_timeout() {
            self.judge_stalled_block(cx);
        }
        self.judge_aborted_block(cx);
        self.confirm_doubts(cx);
        if side == Side::Client && code.is_timeout() {
            self.judge_timed_out(cx);
        }
        if self.all_bytes_without_last() {
            let last = self.transfer.as_ref().map_or(at, |transfer| transfer.last);
            self.find(Sdo007::NoLast, last, cx);
        }
        // One that waited for its request was reported at its own frame.
        if at.no == cx.at.no {
            self.find(Sdo017::Abort { abort: code, by: side }, at, cx);
        }
        if let Some(transfer) = &mut self.transfer {
            transfer.outcome.abort = Some(Abort { code, by: side });
            transfer.last = at;
        }
        self.complete(Status::Aborted, cx);
        if !self.is_one_sided() {
            self.hypotheses.settle();
        }
    }

    /// Reports a client's timeout without a pending response.
    fn judge_timed_out(&mut self, cx: &mut Context<'_>) {
        if self.verdicts.fault.is_none()
            && let Some(transfer) = self.transfer.as_deref().filter(|it| it.mux.is_some() && !it.data.hole)
            && let newest = self.newest(transfer)
            && !within(newest, cx.at, GIVEN_UP_NS)
        {
            self.find(Sdo002::TimedOut, newest, cx);
        }
    }

    /// Judges the object named by an abort; index 0 is accepted.
    fn judge_object(&mut self, half: &Half, by: Side, found: Mux, cx: &mut Context<'_>) {
        let object = self.transfer.as_ref().and_then(|transfer| transfer.mux);
        if let Some(expected) = object.filter(|object| *object != found && found.index != 0) {
            self.find(Sdo016::Objects { expected, found, by }, half.at, cx);
        }
    }

    /// Reports the size of a last segment that the server refused.
    fn judge_refused_segment(&mut self, pending: Half, cx: &mut Context<'_>) {
        let (Command::Segment(segment), Some(transfer)) = (pending.command, &self.transfer) else { return };
        let Some(indicated) = transfer.data.size_indicated.map(u64::from) else { return };
        let transferred = transfer.data.size.saturating_add(u64::from(7 - segment.unused));
        if !transfer.data.hole && (transferred > indicated || (segment.last && transferred != indicated)) {
            self.find(Sdo006::Size { indicated, transferred }, pending.at, cx);
        }
    }

    pub(super) fn client_abort(&mut self, half: &Half, cx: &mut Context<'_>) {
        let Command::Abort(mux, code) = half.command else { return };
        self.judge_object(half, Side::Client, mux, cx);
        let seqno = self.block_seqno(Side::Server);
        let pending = self.pending();
        self.abort(Side::Client, half.at, AbortCode::Sdo(code), cx);
        self.history.given_up = pending.or(self.history.given_up);
        self.history.booted &= pending.is_none();
        self.sequence.under_way = Some(UnderWay { side: Side::Server, at: half.at, seqno, owed: None, unasked: false });
    }

    pub(super) fn server_abort(&mut self, half: &Half, cx: &mut Context<'_>) {
        let Command::Abort(mux, code) = half.command else { return };
        let again = |before: Half| before.bytes == half.bytes && before.at.no > self.history.sent;
        let duplicate = self.history.aborted.replace(*half).is_some_and(again);
        if duplicate && matches!(self.phase, Phase::Idle) && self.history.given_up.is_none() {
            self.step.place = Place::Outside;
            return self.find_unasked(Sdo002::Duplicate, half, cx);
        }
        self.end_unasked(cx);
        let pending = self.pending();
        let seqno = self.block_seqno(Side::Client);
        let owed = self.block().filter(|_| self.is_upload()).and_then(Block::owed_ack);
        let unasked = pending.is_none_or(|pending| self.is_edge(&pending));
        if pending.is_none() {
            // Both sides gave up, or the server refuses late.
            self.history.given_up = None;
        }
        if let Some(pending) = pending {
            self.attempted(&pending);
            if pending.command.mux() == Some(mux) {
                self.proof.paired = true;
                if strict_initiate(&pending) {
                    // The refusal of a request proves the channel like any response.
                    self.trust(cx);
                }
            }
        }
        if !unasked {
            self.judge_object(half, Side::Server, mux, cx);
        }
        let written = self.written();
        self.abort(Side::Server, half.at, AbortCode::Sdo(code), cx);
        self.refuse(written, half.at, AbortCode::Sdo(code));
        self.sequence.answered = pending.map(|_| *half);
        self.sequence.under_way = Some(UnderWay { side: Side::Client, at: half.at, seqno, owed, unasked });
    }

    /// Returns the object that the transfer writes.
    fn written(&self) -> Option<Mux> {
        self.transfer.as_ref().filter(|it| it.direction == Direction::Download)?.mux
    }

    /// Keeps a refused write of `object` until the object is written after all.
    fn refuse(&mut self, object: Option<Mux>, at: FrameRef, code: AbortCode) {
        if let Some(object) = object.filter(|object| self.verdicts.refused.iter().all(|it| it.object != *object))
            && self.verdicts.refused.len() < REFUSED
        {
            self.verdicts.refused.push(Refused { object, at, code, because_of: self.verdicts.fault });
        }
    }

    /// Adds the data of a refused write, which the client intended.
    fn attempted(&mut self, request: &Half) {
        if let Command::InitiateDownload(object, i) = request.command
            && let Some(transfer) = &mut self.transfer
            && i.expedited
        {
            transfer.append(expedited(Some(object), self.server.profile, &i, request.len));
        }
    }
}

/// Returns the verdict on a number of bytes other than indicated.
pub(super) fn wrong_size(transfer: &Transfer) -> Sdo006 {
    Sdo006::Size { indicated: transfer.data.size_indicated.map_or(0, u64::from), transferred: transfer.data.size }
}

/// Returns true if an initiate that announces segments has bytes in place of data.
fn has_data(i: &Initiate) -> bool {
    i.unused != 0 || i.data != [0; 4]
}

/// Returns true if the frame of an expedited transfer is too short for its announced data.
pub(super) fn lacks_data(i: &Initiate, len: u8) -> bool {
    lacking(i, len) > 0
}

/// Returns the number of announced data bytes missing in the frame of an expedited transfer.
fn lacking(i: &Initiate, len: u8) -> u64 {
    if i.size_indicated { i.expedited_len(8).saturating_sub(i.expedited_len(len)) as u64 } else { 0 }
}

/// Returns the data of an expedited transfer. If the size is not indicated (e = 1, s = 0), the data type of a standard
/// object decides.
pub fn expedited(mux: Option<Mux>, profile: Profile, i: &Initiate, len: u8) -> &[u8] {
    let carried = i.expedited_len(len);
    let typed = mux.and_then(|mux| profile.data_type(mux.index, mux.sub)).and_then(DataType::size);
    let count = if i.size_indicated { carried } else { typed.unwrap_or(carried).min(carried) };
    i.data.get(..count).unwrap_or(&[])
}

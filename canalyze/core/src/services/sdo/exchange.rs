//! What an answered request does to the transfer, outside sub-blocks (CiA 301, 7.2.4.3.3 to 7.2.4.3.8).
//!
//! Request and response come here in causal order, whatever order the capture showed them in; toggle bits and
//! sizes are judged here and nowhere else.

use std::sync::Arc;

use super::channel::{Channel, Half, Outside, Phase, strict_initiate};
use super::transfer::{Direction, Mode, Status, Transfer};
use super::wire::{self, Command, Initiate, Mux, Segment, Side};
use crate::context::Context;
use crate::event::Place;
use crate::frame::FrameRef;
use crate::od::{self, DataType};
use crate::rules::sdo::{Sdo001, Sdo003, Sdo004, Sdo006, Sdo020, Sdo021, Sdo022};

impl Channel {
    /// A request and the response that answers it, in causal order.
    pub(super) fn answer(&mut self, request: Half, response: Half, cx: &mut Context<'_>) {
        self.pairing.pending = None;
        self.left = None;
        if let (Some(asked), Some(answered), true) =
            (request.at.t_ns, response.at.t_ns, wire::fits(&request.command, &response.command))
        {
            let late = if response.at.no < request.at.no { asked.saturating_sub(answered) } else { 0 };
            cx.evidence.recording.exchanged(late);
        }
        self.judge_time(&request, &response, cx);
        self.pairing.last_request = Some(request.command);
        self.pairing.last_response = Some(response.bytes);
        self.pairing.answered = (request.at.no < response.at.no).then_some(response);
        if request.command.is_initiate() {
            self.pairing.initiated();
        }
        if wire::fits(&request.command, &response.command) {
            self.proof.paired = true;
            self.verdicts.odd_exchange.astray = false;
            if request.command.is_initiate() && !self.proof.trusted {
                self.trust(cx);
            }
        }
        if let Some(transfer) = &mut self.transfer {
            transfer.last = if response.at.no > request.at.no { response.at } else { request.at };
            transfer.reordered |= response.at.no < request.at.no;
        }
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
            (Command::EndBlock { .. }, _) => self.end_block_download(request, cx),
            _ => {}
        }
    }

    /// An initiate response names the object of its request.
    fn compare_objects(&mut self, request: &Half, response: &Half, cx: &mut Context<'_>) {
        if let (Some(expected), Some(found)) = (request.command.mux(), response.command.mux())
            && expected != found
        {
            if !self.proof.trusted && strict_initiate(request) && !response.command.has_reserved_bits(response.bytes) {
                // Only the object differs: the rest is a request and its response.
                self.trust(cx);
            }
            self.find(Sdo003::Objects { expected, found }, response.at, cx);
            if let Some(transfer) = &mut self.transfer {
                transfer.bad = true;
            }
        }
    }

    pub(super) fn upload_initiated(&mut self, response: Half, i: Initiate, cx: &mut Context<'_>) {
        let Some(transfer) = &mut self.transfer else { return };
        transfer.initiated = Some(response.at);
        if i.expedited {
            transfer.mode = Mode::Expedited;
            transfer.size_indicated = i.size_indicated.then_some(4 - u32::from(i.unused & 3));
            if transfer.bad {
                self.complete(Status::Failed, cx);
                return;
            }
            transfer.append(expedited(transfer.mux, &i, response.len));
            transfer.hole |= lacks_data(&i, response.len);
            self.close_sized(response.at, cx);
            return;
        }
        transfer.mode = Mode::Segmented;
        transfer.size_indicated = i.size().filter(|_| response.len == 8);
        self.unmarked = i.size().is_none().then_some((response, i));
        self.phase = Phase::Segments { toggle: false };
    }

    pub(super) fn download_initiated(&mut self, request: Half, i: Initiate, cx: &mut Context<'_>) {
        let Some(transfer) = &mut self.transfer else { return };
        transfer.initiated = Some(request.at);
        if i.expedited {
            transfer.append(expedited(transfer.mux, &i, request.len));
            transfer.hole |= lacks_data(&i, request.len);
            self.close_sized(request.at, cx);
            return;
        }
        self.unmarked = i.size().is_none().then_some((request, i));
        self.phase = Phase::Segments { toggle: false };
    }

    /// Whether a response answers the request that was given up.
    pub(super) fn is_late(&self, half: &Half) -> bool {
        self.pairing.given_up.is_some_and(|request| wire::fits(&request.command, &half.command))
    }

    pub(super) fn late(&mut self, half: &Half, cx: &mut Context<'_>) {
        self.step.place = Place::Late;
        let request = self.pairing.given_up.take();
        self.step.answered_by = request.map(|request| request.at);
        if let Some(request) = request {
            self.confirm_late(&request);
        }
        self.verdicts.about = half.command.mux();
        self.find(Sdo020::GivenUp, self.step.answered_by.unwrap_or(half.at), cx);
    }

    /// The late answer to a request that was given up: what it should write is written. The server answers in order, so
    /// this holds until it answers another.
    fn confirm_late(&mut self, request: &Half) {
        let left = self.left.take().filter(|left| left.first == request.at);
        if let (Some(left), Command::InitiateDownload(mux, i)) = (left, request.command)
            && i.expedited
            && left.kept.is_empty()
            && !lacks_data(&i, request.len)
        {
            let mut transfer = Transfer::clone(&left);
            transfer.append(expedited(Some(mux), &i, request.len));
            (transfer.status, transfer.abort) = (Status::Ok, None);
            self.confirmed = Some(Arc::new(transfer));
        }
    }

    pub(super) fn check_toggle(&mut self, request: (FrameRef, bool), response: (FrameRef, bool), cx: &mut Context<'_>) {
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
            self.find(Sdo001::Toggle { expected: due, found, by }, at, cx);
        }
    }

    /// The data of a segment that was confirmed (or whose request is not in the capture).
    pub(super) fn add_segment(&mut self, half: Half, segment: Segment, cx: &mut Context<'_>) {
        if let Some((initiate, i)) = self.unmarked.take() {
            if matches!(initiate.command, Command::UploadInitiated(..)) {
                self.segments_unmarked = Some(self.segments_unmarked.unwrap_or(false) | has_data(&i));
            }
            if i.unused != 0 {
                self.find(Sdo004::Unused { unused: i.unused.into() }, initiate.at, cx);
            }
        }
        let Some(transfer) = &mut self.transfer else { return };
        let carried = (7 - usize::from(segment.unused)).min(usize::from(half.len.saturating_sub(1)));
        transfer.append(segment.data.get(..carried).unwrap_or(&[]));
        // What a short frame should have carried is missing.
        transfer.hole |= carried + usize::from(segment.unused) < 7;
        transfer.segments = transfer.segments.saturating_add(1);
        transfer.even &= segment.last || segment.unused == 0;
        if segment.last {
            self.close_sized(half.at, cx);
        }
    }

    /// Ends a transfer whose data are all there: judges its size.
    pub(super) fn close_sized(&mut self, end: FrameRef, cx: &mut Context<'_>) {
        let Some(transfer) = &self.transfer else { return };
        let mut status = if transfer.hole || transfer.midway { Status::Incomplete } else { Status::Ok };
        if !transfer.size_is_right() {
            let cause = transfer.initiated.unwrap_or(end);
            let size = wrong_size(transfer);
            self.find(size, if end.no == cx.at.no { cause } else { end }, cx);
            status = Status::Failed;
        }
        self.complete(status, cx);
        if status == Status::Failed {
            // Where the last segment was not the last one, the others belong to nothing.
            self.outside = Outside::Said;
        }
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

    /// Whether an initiate with e = s = 0 that no segment has followed was meant as data. The answer of a server that has
    /// sent segments after the same announces them; bytes that it does not leave in them otherwise do not.
    pub(super) fn is_meant_as_data(&self) -> bool {
        let announces = |i: &Initiate| self.segments_unmarked.is_some_and(|other| other || !has_data(i));
        self.unmarked
            .as_ref()
            .is_some_and(|(initiate, i)| !(matches!(initiate.command, Command::UploadInitiated(..)) && announces(i)))
    }

    /// An initiate with e = s = 0 that no segment followed: its four bytes were meant as data.
    pub(super) fn recognise_unmarked(&mut self, cx: &mut Context<'_>) {
        let Some((initiate, i)) = self.unmarked.take() else { return };
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
        let own = std::mem::replace(&mut self.own, false);
        let last = self.transfer.as_ref().map(|transfer| transfer.last);
        if let (Some(transfer), Some(last)) = (self.transfer.take(), last) {
            let mut transfer = *transfer;
            transfer.described = self.described(transfer.mux);
            transfer.status = Status::Ok;
            transfer.last = last;
            self.announce(Arc::new(transfer), cx);
        }
        self.phase = Phase::Idle;
        self.own = own;
    }
}

/// That a transfer has moved another number of bytes than was indicated.
pub(super) fn wrong_size(transfer: &Transfer) -> Sdo006 {
    Sdo006::Size { indicated: transfer.size_indicated.map_or(0, u64::from), transferred: transfer.size }
}

/// Whether an initiate that announces segments has something in the place of data.
fn has_data(i: &Initiate) -> bool {
    i.unused != 0 || i.data != [0; 4]
}

/// Whether the frame of an expedited transfer is too short for the data that it announces.
fn lacks_data(i: &Initiate, len: u8) -> bool {
    i.size_indicated && i.expedited_len(len) < i.expedited_len(8)
}

/// The data of an expedited transfer. Where the size is not indicated (e = 1, s = 0), a standard object's data type
/// tells how many of the four bytes count.
pub fn expedited(mux: Option<Mux>, i: &Initiate, len: u8) -> &[u8] {
    let carried = i.expedited_len(len);
    let typed = mux.and_then(|mux| od::data_type(mux.index, mux.sub)).and_then(DataType::size);
    let count = if i.size_indicated { carried } else { typed.unwrap_or(carried).min(carried) };
    i.data.get(..count).unwrap_or(&[])
}

//! The protocol of a channel as one table (CiA 301, 7.2.4.3): the effect of each frame in each state.
//!
//! [`transition`] is pure; each row names its clause. The actions are in `exchange` (expedited and segmented transfers,
//! aborts) and `block_transfer`. Frames come here in their order on the bus (`sequence`). The exchange is
//! stop-and-wait: at most one request is pending.

use super::limits::{GIVEN_UP_NS, SHORTEST_TIMEOUT_NS, within};
use super::phase::{Half, Phase, Segments, strict_initiate};
use super::state::SdoChannel;
use super::transfer::{Direction, Mode, Status};
use super::wire::{self, Command, Side};
use crate::bytes::frame::FrameRef;
use crate::rules::finding::Code;
use crate::rules::sdo::{Sdo002, Sdo007, Sdo012, Sdo024};
use crate::world::context::Context;
use crate::world::event::Place;

/// The service requested by an initiate request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Service {
    Upload,
    Download,
    BlockUpload,
    BlockDownload,
}

/// The stage of a block transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    /// Initiated without segments; the client has to start an upload.
    Initiated,
    /// A sub-block runs.
    SubBlock,
    /// The sub-block is complete, and its acknowledgement is expected.
    Acknowledge,
    /// The last segment was acknowledged, and the end frame is expected.
    End,
    /// The end frame was sent, and its confirmation is expected.
    Confirm,
}

/// The state of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ChannelState {
    /// Unknown: the capture does not show yet if a transfer runs.
    Unknown,
    /// No transfer.
    Idle,
    /// An initiate request waits for its response.
    Requested(Service),
    /// A segmented upload, and the side whose frame is expected.
    Upload(Side),
    /// A segmented download, likewise.
    Download(Side),
    BlockUpload(Stage),
    BlockDownload(Stage),
}

/// The effect of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Action {
    /// An initiate request while no transfer runs.
    Begin,
    /// An initiate request while a transfer runs: violation, SDO008 or SDO007.
    Restart,
    /// An initiate request while another request is pending: violation, SDO002.
    GiveUp,
    /// A segment, or a request for one, that waits for its response.
    Request,
    /// The client sends the next frame without the response: violation, SDO002.
    GoOn,
    /// A response of the expected kind.
    Answer,
    /// Another frame of the server while a response is expected: violation, SDO002, unless another request explains it.
    Misfit,
    /// A frame of the server while none is expected: violation, SDO002, unless another request explains it.
    Unasked,
    /// An unexpected frame of the client: violation, SDO007, unless the transfer began before the capture.
    Stray,
    /// An unexpected frame of the client while a request is pending or in a block transfer: violation, SDO007.
    Outside,
    /// A transfer is joined midway.
    Join,
    /// An undetermined frame, which changes nothing.
    Pass,
    ClientAbort,
    ServerAbort,
    Start,
    Segment,
    Acknowledge,
    /// An unreadable acknowledgement or confirmation.
    AcknowledgeUnread,
    /// The end frame.
    End,
    EndUnread,
    ConfirmEnd,
    /// The confirmation of a missing end: violation, SDO002 or SDO007.
    ConfirmUnseen,
    /// A repeated response to the initiate request: violation, SDO002.
    Duplicate,
}

/// A row of the table.
#[derive(Clone, Copy)]
pub(super) struct TransitionRow {
    pub(super) action: Action,
    /// The next states in a conformant exchange; if empty, the state does not change.
    #[cfg_attr(not(test), expect(dead_code, reason = "documents the table, and is tested against the machine"))]
    pub(super) to: &'static [ChannelState],
    /// The clause of CiA 301 that defines the row, or that a violation breaks.
    #[cfg_attr(not(test), expect(dead_code, reason = "documents the table"))]
    pub(super) clause: &'static str,
}

/// Returns the first row of the table that applies.
#[rustfmt::skip]
pub(super) fn transition(state: ChannelState, side: Side, command: &Command) -> TransitionRow {
    use Action as A;
    use Command as C;
    use Side::{Client, Server};
    use Stage::{Acknowledge, Confirm, End, Initiated, SubBlock};
    use ChannelState as S;
    let pending = matches!(state, S::Requested(_) | S::Upload(Server) | S::Download(Server) | S::BlockDownload(Confirm));
    let begin = match state {
        S::Unknown | S::Idle => A::Begin,
        _ if pending => A::GiveUp,
        _ => A::Restart,
    };
    let (action, to, clause): (A, &'static [S], &'static str) = match (state, side, command) {
        (_, _, C::Undetermined(_)) => (A::Pass, &[], "7.2.4.1"),

        // Abort.
        (_, Client, C::Abort(..)) => (A::ClientAbort, &[S::Idle, S::Unknown], "7.2.4.3.17"),
        (_, Server, C::Abort(..)) => (A::ServerAbort, &[S::Idle, S::Unknown], "7.2.4.3.17"),

        // Initiate requests.
        (_, Client, C::InitiateDownload(..)) => (begin, &[S::Requested(Service::Download)], "7.2.4.3.3"),
        (_, Client, C::InitiateUpload(_)) => (begin, &[S::Requested(Service::Upload)], "7.2.4.3.6"),
        (_, Client, C::InitiateBlockDownload { .. }) => (begin, &[S::Requested(Service::BlockDownload)], "7.2.4.3.9"),
        (_, Client, C::InitiateBlockUpload { .. }) => (begin, &[S::Requested(Service::BlockUpload)], "7.2.4.3.13"),

        // Download, expedited or segmented.
        (S::Requested(Service::Download), Server, C::DownloadInitiated(_)) => (A::Answer, &[S::Download(Client), S::Idle], "7.2.4.3.3"),
        (S::Download(Client), Client, C::Segment(_)) => (A::Request, &[S::Download(Server)], "7.2.4.3.4"),
        (S::Download(Server), Server, C::SegmentResponse { .. }) => (A::Answer, &[S::Download(Client), S::Idle], "7.2.4.3.4"),
        (S::Requested(Service::Download) | S::Download(Server), Client, C::Segment(_)) => (A::GoOn, &[S::Download(Server)], "7.2.4.3.4"),

        // Upload, expedited or segmented.
        (S::Requested(Service::Upload), Server, C::UploadInitiated(..)) => (A::Answer, &[S::Upload(Client), S::Idle], "7.2.4.3.6"),
        (S::Upload(Client), Client, C::SegmentRequest { .. }) => (A::Request, &[S::Upload(Server)], "7.2.4.3.7"),
        (S::Upload(Server), Server, C::Segment(_)) => (A::Answer, &[S::Upload(Client), S::Idle], "7.2.4.3.7"),
        (S::Requested(Service::Upload) | S::Upload(Server), Client, C::SegmentRequest { .. }) => (A::GoOn, &[S::Upload(Server)], "7.2.4.3.7"),

        // Block download.
        (S::Requested(Service::BlockDownload), Server, C::BlockDownloadInitiated { .. }) => (A::Answer, &[S::BlockDownload(Initiated)], "7.2.4.3.9"),
        (S::BlockDownload(_), Client, C::BlockSegment { .. }) => (A::Segment, &[S::BlockDownload(SubBlock), S::BlockDownload(Acknowledge)], "7.2.4.3.10"),
        (S::BlockDownload(End | Confirm), Server, C::BlockAck { .. }) => (A::Outside, &[], "7.2.4.3.10"),
        (S::BlockDownload(_), Server, C::BlockAck { .. }) => (A::Acknowledge, &[S::BlockDownload(SubBlock), S::BlockDownload(End)], "7.2.4.3.10"),
        (S::BlockDownload(_), Client, C::EndBlock { .. }) => (A::End, &[S::BlockDownload(Confirm)], "7.2.4.3.11"),
        (S::BlockDownload(_) | S::BlockUpload(_), Server, C::BlockUploadInitiated { .. }) => (A::Duplicate, &[], "7.2.4.3.13"),
        (S::BlockDownload(Confirm), Server, C::BlockEnded) => (A::Answer, &[S::Idle], "7.2.4.3.11"),
        (S::BlockDownload(Confirm), Server, _) => (A::Misfit, &[], "7.2.4.3.11"),
        (S::BlockDownload(_), Server, C::Truncated(_)) => (A::AcknowledgeUnread, &[S::BlockDownload(SubBlock), S::BlockDownload(End)], "7.2.4.3.10"),
        (S::Requested(Service::BlockDownload), Client, _) => (A::GoOn, &[S::BlockDownload(SubBlock)], "7.2.4.3.9"),

        // Block upload. The server may answer as in an upload (protocol switch).
        (S::Requested(Service::BlockUpload), Server, C::BlockUploadInitiated { .. }) => (A::Answer, &[S::BlockUpload(Initiated)], "7.2.4.3.13"),
        (S::Requested(Service::BlockUpload), Server, C::UploadInitiated(..)) => (A::Answer, &[S::Upload(Client), S::Idle], "7.2.4.3.13"),
        (S::Requested(Service::BlockUpload), Client, C::StartBlockUpload | C::BlockAck { .. }) => (A::GoOn, &[S::BlockUpload(SubBlock)], "7.2.4.3.13"),
        (S::Requested(Service::BlockUpload), Client, C::SegmentRequest { .. }) => (A::GoOn, &[S::Upload(Server)], "7.2.4.3.13"),
        (S::BlockUpload(_), Client, C::StartBlockUpload) => (A::Start, &[S::BlockUpload(SubBlock)], "7.2.4.3.13"),
        (S::BlockUpload(_), Server, C::BlockSegment { .. }) => (A::Segment, &[S::BlockUpload(SubBlock), S::BlockUpload(Acknowledge)], "7.2.4.3.14"),
        (S::BlockUpload(_), Client, C::BlockAck { .. }) => (A::Acknowledge, &[S::BlockUpload(SubBlock), S::BlockUpload(End)], "7.2.4.3.14"),
        (S::BlockUpload(_), Server, C::EndBlock { .. }) => (A::End, &[S::BlockUpload(Confirm)], "7.2.4.3.15"),
        (S::BlockUpload(_), Server, C::Truncated(_)) => (A::EndUnread, &[S::BlockUpload(Confirm)], "7.2.4.3.15"),
        (S::BlockUpload(Confirm), Client, C::BlockEnded) => (A::ConfirmEnd, &[S::Idle], "7.2.4.3.15"),
        (S::BlockUpload(_), Client, C::BlockEnded) => (A::ConfirmUnseen, &[S::Idle], "7.2.4.3.15"),
        (S::BlockUpload(_), Client, C::Truncated(_)) => (A::AcknowledgeUnread, &[S::BlockUpload(SubBlock), S::BlockUpload(End), S::Idle], "7.2.4.3.14"),

        // Joined midway.
        (S::Unknown, Client, C::SegmentRequest { .. }) => (A::Join, &[S::Upload(Server)], "7.2.4.3.7"),
        (S::Unknown, Client, C::Segment(_)) => (A::Join, &[S::Download(Server)], "7.2.4.3.4"),
        (S::Unknown, Client, C::BlockSegment { .. }) => (A::Join, &[S::BlockDownload(SubBlock)], "7.2.4.3.10"),
        (S::Unknown, Server, C::BlockSegment { .. }) => (A::Join, &[S::BlockUpload(SubBlock)], "7.2.4.3.14"),
        (S::Unknown, Client, C::StartBlockUpload | C::BlockAck { .. }) => (A::Join, &[S::BlockUpload(SubBlock)], "7.2.4.3.14"),

        // Unexpected frames.
        (S::BlockDownload(_) | S::BlockUpload(_), Client, _) => (A::Outside, &[], "7.2.4.3.8, 7.2.4.3.12"),
        (_, Client, _) if pending => (A::Outside, &[], "7.2.4.1"),
        (_, Client, _) => (A::Stray, &[], "7.2.4.1"),
        (_, Server, _) if pending => (A::Misfit, &[], "7.2.4.1"),
        (_, Server, _) => (A::Unasked, &[], "7.2.4.1"),
    };
    TransitionRow { action, to, clause }
}

impl SdoChannel {
    /// Returns the state of the channel for the table.
    pub(super) fn state(&self) -> ChannelState {
        let upload = self.is_upload();
        match &self.phase {
            Phase::Idle if self.hypotheses.are_open() => ChannelState::Unknown,
            Phase::Idle => ChannelState::Idle,
            Phase::Initiated(request) => ChannelState::Requested(match request.command {
                Command::InitiateDownload(..) => Service::Download,
                Command::InitiateBlockDownload { .. } => Service::BlockDownload,
                Command::InitiateBlockUpload { .. } => Service::BlockUpload,
                _ => Service::Upload,
            }),
            Phase::Segments(segments) => {
                let due = if segments.asked.is_some() { Side::Server } else { Side::Client };
                if upload { ChannelState::Upload(due) } else { ChannelState::Download(due) }
            }
            Phase::Block(block, asked) => {
                let stage = if block.end.is_some() || asked.is_some() {
                    Stage::Confirm
                } else if block.finished {
                    Stage::End
                } else if block.owes_ack() {
                    Stage::Acknowledge
                } else if block.marks.first.is_none() && !block.started {
                    Stage::Initiated
                } else {
                    Stage::SubBlock
                };
                if upload { ChannelState::BlockUpload(stage) } else { ChannelState::BlockDownload(stage) }
            }
        }
    }

    /// Takes a client's frame in its turn.
    pub(super) fn client(&mut self, half: Half, cx: &mut Context<'_>) {
        self.hypotheses.is_first(half.at.no);
        self.sequence.ascertain(&half);
        if matches!(half.command, Command::Abort(..)) {
            self.take(Side::Client, half, cx);
        } else if let Some(command) = self.is_under_way(&half) {
            (self.step.place, self.step.command) = (Place::InFlight, command);
        } else if let Some(half) = self.reconsider(half, cx) {
            self.take(Side::Client, half, cx);
        }
    }

    /// Takes a server's frame in its turn.
    pub(super) fn server(&mut self, half: Half, cx: &mut Context<'_>) {
        self.history.heard = Some(half);
        if !matches!(half.command, Command::Abort(..)) && self.sequence.is_in_flight(&half) {
            (self.step.place, self.step.command) = (Place::InFlight, wire::block_segment(half.bytes));
            return;
        }
        self.take(Side::Server, half, cx);
    }

    /// Performs the action of the table's row.
    pub(super) fn take(&mut self, side: Side, half: Half, cx: &mut Context<'_>) {
        let half = self.unless_empty(side, half);
        let row = transition(self.state(), side, &half.command);
        match row.action {
            Action::Begin => self.begin_request(half, false, cx),
            Action::Restart => {
                let left = self.leave_open_transfer(&half, cx);
                self.begin_request(half, left, cx);
            }
            Action::GiveUp => {
                let left = self.give_up(cx);
                self.begin_request(half, left, cx);
            }
            Action::Request => self.request(half, cx),
            Action::GoOn => self.go_on(half, cx),
            Action::Answer | Action::Misfit => self.respond(half, cx),
            Action::Unasked => self.respond_unasked(half, cx),
            Action::Join => self.join(side, &half, cx),
            Action::Pass => self.step.place = Place::Uncaptured,
            Action::Stray => self.stray(&half, cx),
            Action::Outside => self.violation_outside(&half, cx),
            Action::ClientAbort => self.client_abort(&half, cx),
            Action::ServerAbort => self.server_abort(&half, cx),
            Action::Start => self.start_upload(&half, cx),
            Action::Segment => self.block_segment(&half, cx),
            Action::Acknowledge => self.acknowledge(&half, cx),
            Action::AcknowledgeUnread => self.acknowledge_unread(side, half, cx),
            Action::End => self.end_block(half, cx),
            Action::EndUnread => self.end_unread(half, cx),
            Action::ConfirmEnd => self.agree_on_end(cx),
            Action::ConfirmUnseen => self.confirm_unseen(&half, cx),
            Action::Duplicate => {
                self.step.place = Place::Outside;
                self.find_unasked(Sdo002::Duplicate, &half, cx);
            }
        }
    }

    /// Takes an initiate request. `left`: it abandons a transfer.
    pub(super) fn begin_request(&mut self, half: Half, left: bool, cx: &mut Context<'_>) {
        if !left {
            self.verdicts.fault = None;
        }
        self.begin(&half, cx);
        self.sequence.under_way = None;
        self.history.stray = None;
    }

    /// Reports an unexpected frame.
    pub(super) fn violation_outside(&mut self, half: &Half, cx: &mut Context<'_>) {
        self.step.place = Place::Outside;
        if half.command.is_unreadable() || self.hypotheses.is_reported() {
            return;
        }
        if matches!((&self.phase, half.command), (Phase::Block(..), Command::BlockAck { .. })) {
            self.doubt(Sdo007::Outside, half.at, false, cx);
        } else {
            self.find(Sdo007::Outside, half.at, cx);
        }
        if self.transfer.is_none() && !self.is_one_sided() {
            self.hypotheses.report();
        }
    }

    /// Takes a client frame that belongs to no open transfer.
    pub(super) fn stray(&mut self, half: &Half, cx: &mut Context<'_>) {
        if self.hypotheses.are_open() {
            self.join(Side::Client, half, cx);
            return;
        }
        self.violation_outside(half, cx);
        self.history.stray = Some(*half);
    }

    /// Takes a new initiate request while another is unanswered; returns true if it abandons a transfer.
    fn give_up(&mut self, cx: &mut Context<'_>) -> bool {
        let Some(pending) = self.pending() else { return false };
        let edge = self.is_edge(&pending) || self.hypotheses.are_open();
        self.history.given_up = (!edge).then_some(pending);
        self.history.booted = false;
        if matches!(pending.command, Command::EndBlock { .. }) {
            self.find(Sdo012::EndNotConfirmed, pending.at, cx);
            if let (Phase::Block(block, _), Some(transfer)) = (&self.phase, &mut self.transfer) {
                // Without knowing the last segment, the server had no reason to accept the data.
                transfer.outcome.bad |= !block.last_sent && !block.unsure && !transfer.data.hole;
            }
            self.settle_end(&pending, cx);
            self.before_frame(|channel| channel.confirm_end(cx));
            return true;
        }
        self.unanswered(&pending, (edge, false), cx);
        self.complete_before(if edge { Status::Incomplete } else { self.given_up(pending.at, cx) }, cx);
        false
    }

    /// Reports a request without response. `same`: the client goes on in the transfer.
    fn unanswered(&mut self, pending: &Half, (edge, same): (bool, bool), cx: &mut Context<'_>) {
        if edge {
            return;
        }
        let soon = self.went_on(pending, same, cx);
        if soon && same {
            // A client that goes on without having waited had its answer.
            return self.find(Sdo024::Response, pending.at, cx);
        }
        self.verdicts.lost = soon.then_some(false);
        self.find(Sdo002::NoResponse, pending.at, cx);
    }

    /// Takes a client frame that implies an answer to its last request: the capture lacks the response.
    fn go_on(&mut self, half: Half, cx: &mut Context<'_>) {
        let Some(pending) = self.pending() else { return };
        let edge = self.is_edge(&pending) || self.hypotheses.are_open();
        let mut half = half;
        match (pending.command, half.command) {
            (Command::SegmentRequest { toggle }, Command::SegmentRequest { toggle: next }) if toggle != next => {
                self.unanswered(&pending, (edge, true), cx);
                self.continue_segments(next);
                if let Some(transfer) = &mut self.transfer {
                    transfer.miss(None);
                }
            }
            (Command::Segment(sent), Command::Segment(next)) if sent.toggle != next.toggle => {
                self.unanswered(&pending, (edge, true), cx);
                self.continue_segments(next.toggle);
                self.add_segment(pending, sent, cx);
            }
            (Command::InitiateUpload(_) | Command::InitiateBlockUpload { .. }, Command::SegmentRequest { .. })
            | (Command::InitiateDownload(..), Command::Segment(_)) => {
                self.unanswered(&pending, (edge, true), cx);
                if let Some(transfer) = &mut self.transfer {
                    transfer.mode = Mode::Segmented;
                    let behind = match half.command {
                        Command::Segment(segment) => segment.toggle,
                        Command::SegmentRequest { toggle } => toggle,
                        _ => false,
                    };
                    if behind {
                        // The capture lacks the first segment as well.
                        transfer.miss_beginning();
                    }
                }
                self.phase = Phase::Segments(Segments::from(false));
            }
            (Command::InitiateBlockUpload { blksize, .. }, _) => {
                self.unanswered(&pending, (edge, true), cx);
                self.block_initiated(pending.at, blksize, false, None);
            }
            (Command::InitiateBlockDownload { .. }, _) if half.bytes[0] & 0x7F == 1 || self.is_one_sided() => {
                self.unanswered(&pending, (edge, true), cx);
                self.block_initiated(pending.at, 0, false, None);
                half.command = wire::block_segment(half.bytes);
                self.step.command = half.command;
            }
            _ => return self.violation_outside(&half, cx),
        }
        self.take(Side::Client, half, cx);
    }

    /// Continues with this toggle bit after frames that the capture lacks.
    fn continue_segments(&mut self, next: bool) {
        if let Phase::Segments(segments) = &mut self.phase {
            (segments.toggle, segments.asked) = (next, None);
        }
    }

    /// Takes a new initiate request while a transfer is open; returns true if that is abandoned.
    fn leave_open_transfer(&mut self, half: &Half, cx: &mut Context<'_>) -> bool {
        let Some(transfer) = &self.transfer else { return false };
        let (last, newest, uncaptured) = (transfer.last, self.newest(transfer), transfer.mux.is_none());
        if self.is_meant_as_data() {
            self.recognise_unmarked(cx);
            return false;
        }
        if self.leave_ended_block(cx) {
            return false;
        }
        if self.all_bytes_without_last() {
            self.find(Sdo007::NoLast, last, cx);
        } else if !uncaptured {
            let stalled = !within(newest, half.at, GIVEN_UP_NS);
            if stalled {
                self.judge_stalled_block(cx);
            }
            self.find(Code::Sdo008, if stalled { newest } else { half.at }, cx);
        }
        self.complete_before(if uncaptured { Status::Incomplete } else { self.given_up(newest, cx) }, cx);
        true
    }

    /// Returns the status of a transfer abandoned after this frame: within the shortest time-out, or with an unseen
    /// server, frames may not be recorded.
    fn given_up(&self, newest: FrameRef, cx: &Context<'_>) -> Status {
        let soon = within(newest, cx.at, SHORTEST_TIMEOUT_NS);
        if soon || self.proof.responses == 0 { Status::Incomplete } else { Status::Failed }
    }

    /// Takes a server's frame while a response is expected.
    pub(super) fn respond(&mut self, half: Half, cx: &mut Context<'_>) {
        let Some(pending) = self.pending() else { return self.respond_unasked(half, cx) };
        if wire::fits(&pending.command, &half.command) {
            self.step.ordinal = self.segment_ordinal(&half.command);
            self.answer(pending, half, cx);
        } else if !self.belongs_elsewhere(&pending, &half, cx) {
            self.misfit(pending, half, cx);
        }
    }

    /// Takes a response that answers neither the pending nor another request.
    fn misfit(&mut self, pending: Half, half: Half, cx: &mut Context<'_>) {
        let fits = wire::kind_fits(&pending.command, &half.command);
        if matches!(half.command, Command::Segment(_)) && self.history.last_response == Some(half.bytes) {
            self.step.place = Place::Outside;
            self.find_unasked(Sdo002::Duplicate, &half, cx);
        } else if self.is_edge(&pending) && !(strict_initiate(&pending) && fits) {
            self.step.place = Place::Uncaptured;
        } else if fits {
            self.step.ordinal = self.segment_ordinal(&half.command);
            self.answer(pending, half, cx);
        } else {
            self.step.place = Place::Outside;
            if half.command.is_unreadable() {
                self.count_unreadable(&half, cx);
            } else {
                self.find_unasked(Sdo002::NoRequest, &half, cx);
            }
        }
    }

    /// Takes a server's frame while no response is expected.
    pub(super) fn respond_unasked(&mut self, half: Half, cx: &mut Context<'_>) {
        let midway = self.transfer.as_ref().is_some_and(|transfer| transfer.mux.is_none());
        if matches!(self.phase, Phase::Block(..)) && midway && half.command == Command::BlockEnded {
            self.complete(Status::Incomplete, cx);
            return;
        }
        if half.command.is_unreadable() {
            self.step.place = Place::Outside;
            self.count_unreadable(&half, cx);
            return;
        }
        if let Some(stray) = self.history.stray.take()
            && wire::kind_fits(&stray.command, &half.command)
        {
            self.step.place = Place::Outside;
            return;
        }
        if self.is_late(&half) {
            self.late(&half, cx);
            return;
        }
        self.step.ordinal = self.segment_ordinal(&half.command);
        if self.hypotheses.are_open() && matches!(half.command, Command::BlockAck { .. }) {
            self.step.place = Place::Uncaptured;
            self.join_block(&half, Direction::Download, cx);
            return;
        }
        self.without_request(&half, false, cx);
    }

    /// Takes a response without its request. `first`: the request may precede the capture.
    pub(super) fn without_request(&mut self, half: &Half, first: bool, cx: &mut Context<'_>) {
        if !first {
            let duplicate = self.history.last_response == Some(half.bytes);
            self.find_unasked(if duplicate { Sdo002::Duplicate } else { Sdo002::NoRequest }, half, cx);
        }
        self.continue_without_request(half, cx);
        self.history.released = Some(*half);
    }

    /// Takes the data of a response whose request the capture lacks.
    pub(super) fn continue_without_request(&mut self, half: &Half, cx: &mut Context<'_>) {
        let upload = self.is_upload();
        let Phase::Segments(segments) = &mut self.phase else { return };
        match half.command {
            Command::Segment(segment) if upload && segment.toggle == segments.toggle => {
                segments.toggle = !segments.toggle;
                self.aside(|channel| channel.add_segment(*half, segment, cx));
            }
            Command::SegmentResponse { toggle } if !upload && toggle == segments.toggle => {
                // The server takes the transfer for segmented.
                (segments.unmarked, segments.toggle) = (None, !toggle);
                if let Some(transfer) = &mut self.transfer {
                    transfer.miss(None);
                }
            }
            _ => {}
        }
    }
}

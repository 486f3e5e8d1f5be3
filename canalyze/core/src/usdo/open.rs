//! A running USDO transfer and its state.

use crate::bytes::frame::FrameRef;
use crate::evidence::When;
use crate::rules::finding::Verdict;
use crate::rules::sdo::{Sdo002, Sdo024};
use crate::sdo::transfer::{Direction, Transfer};
use crate::wire::usdo::{Body, SEGMENT};
use crate::world::od::DataType;

/// The identity of a transfer: client, server and session-ID.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct TransferKey {
    pub(super) client: u8,
    pub(super) server: u8,
    pub(super) session: u8,
}

/// The next frame of a transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum UsdoPhase {
    /// The response to the initiate request with this command.
    Initiated(u8),
    /// The next segment, its request or its response.
    Segments,
    /// The response to the last segment of a download.
    Ending,
    /// Nothing: it has ended.
    Over,
}

/// A segment whose counter skips others. They are missing in the capture if the server takes it.
#[derive(Debug)]
pub(super) struct Jump {
    pub(super) at: FrameRef,
    pub(super) found: u8,
    pub(super) data: Vec<u8>,
}

/// A transfer and its state.
#[derive(Debug)]
pub(super) struct OpenTransfer {
    pub(super) transfer: Transfer,
    pub(super) phase: UsdoPhase,
    /// The request that waits for its response.
    pub(super) asked: Option<When>,
    /// The counter that this request carries.
    pub(super) counter: Option<u8>,
    /// The counter of the next segment, and true once it has wrapped around, which no source describes.
    pub(super) due: u8,
    pub(super) wrapped: bool,
    pub(super) jump: Option<Jump>,
    /// The missing response was reported at this frame.
    pub(super) reported: Option<FrameRef>,
    /// The client has asked for the same in another session.
    pub(super) given_up: bool,
    /// The client went on in another session so soon that it had its response.
    pub(super) went_on: bool,
}

impl OpenTransfer {
    pub(super) fn new(transfer: Transfer, phase: UsdoPhase, asked: Option<When>) -> Self {
        let (counter, due, wrapped, jump) = (None, 0, false, None);
        let (reported, given_up, went_on) = (None, false, false);
        Self { transfer, phase, asked, counter, due, wrapped, jump, reported, given_up, went_on }
    }

    pub(super) fn is_upload(&self) -> bool {
        self.transfer.direction == Direction::Upload
    }

    /// Lists the verdict on a request without response and returns it.
    pub(super) fn unanswered(&mut self) -> Verdict {
        let verdict: Verdict = if self.went_on { Sdo024::Response.into() } else { Sdo002::NoResponse.into() };
        self.transfer.note_finding(verdict.code);
        verdict
    }

    /// Takes the data of a segment.
    pub(super) fn append(&mut self, data: &[u8]) {
        self.transfer.append(data);
        self.transfer.data.segments = self.transfer.data.segments.saturating_add(1);
        let (due, wrapped) = self.due.overflowing_add(1);
        (self.due, self.wrapped) = (due, self.wrapped | wrapped);
    }

    /// Marks the segments before the one with this counter as missing; returns their number.
    pub(super) fn miss_until(&mut self, counter: u8) -> u64 {
        let missing = u64::from(counter.saturating_sub(self.due));
        if !self.wrapped && missing > 0 {
            self.transfer.miss(Some(missing.saturating_mul(SEGMENT as u64)));
            self.due = counter;
            return missing;
        }
        0
    }

    /// Takes a held segment, and those before it as missing; returns their number.
    pub(super) fn take_jump(&mut self) -> u64 {
        let Some(jump) = self.jump.take() else { return 0 };
        let missing = self.miss_until(jump.found);
        self.append(&jump.data);
        missing
    }
}

/// Returns the data type that a frame names.
pub(super) fn told(body: &Body<'_>) -> Option<DataType> {
    match body {
        Body::Expedited(_, code, ..) | Body::Initiate(_, code, _) => DataType::from_code(u16::from(*code)),
        _ => None,
    }
}

/// Returns the counter that a client's frame carries.
pub(super) fn counter(body: &Body<'_>) -> Option<u8> {
    match body {
        Body::Segment(counter, _) | Body::Counter(counter) => Some(*counter),
        _ => None,
    }
}

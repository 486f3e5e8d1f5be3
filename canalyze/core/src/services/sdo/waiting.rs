//! What pairing remembers: the request that is pending, the response that is held, the pair that is tentative, and what
//! would make another reading of them right.
//!
//! It says what may belong together by the frames alone. What is made of it stands in `pairing`.

use super::channel::{Half, UNANSWERED_NS};
use super::repeated::Repeated;
use super::wire::{self, Command, Side};
use crate::frame::FrameRef;

/// How long a response waits for its late request, in ns.
const HOLD_NS: i64 = 5_000_000;
/// An echo is late by this much on any host, and stamps are no finer on some, in ns.
const ECHO_NS: i64 = 1_000_000;

/// A response whose request was not seen yet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Held {
    pub(super) half: Half,
    /// It is among the channel's first frames (or the first after lost frames): its request may be before the capture.
    pub(super) first: bool,
    /// It also answers the request of the tentative pair.
    pub(super) rival: bool,
}

/// A pair whose request was captured after its response.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tentative {
    pub(super) request: Half,
    pub(super) response: FrameRef,
    /// The response was the channel's first frame: a second one that fits is rather the answer.
    pub(super) first: bool,
    /// The response is an abort.
    pub(super) refused: bool,
}

impl Tentative {
    /// Whether the stamps speak for a late echo: the request came right after the response, and long before the one at
    /// `next`.
    pub(super) fn is_likely(&self, next: FrameRef) -> bool {
        let stamped = self.request.at.t_ns.is_some() && next.t_ns.is_some();
        stamped && within(self.response, self.request.at, ECHO_NS) && !within_hold(self.request.at, next)
    }

    /// Whether the stamps speak against a late echo: the request came long after the response it would belong to
    /// ([`ECHO_NS`] says nothing yet), and soon before the one at `next`.
    pub(super) fn is_unlikely(&self, next: FrameRef) -> bool {
        match (self.response.t_ns, self.request.at.t_ns, next.t_ns) {
            (Some(response), Some(request), Some(next)) => {
                let late = request.saturating_sub(response);
                late > ECHO_NS && late > next.saturating_sub(request)
            }
            _ => false,
        }
    }
}

/// An abort by the server, met when no request was pending: its request may be late.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unprovoked {
    pub(super) at: FrameRef,
    /// What can only be the refusal of an initiate request that is late: no transfer was open.
    pub(super) refusal: Option<(wire::Mux, u32)>,
}

/// After an abort: frames of the other side may still be under way.
#[derive(Clone, Copy, Debug)]
pub(super) struct UnderWay {
    pub(super) side: Side,
    /// The abort.
    pub(super) at: FrameRef,
    /// The next sequence number of a block transfer's segments; 0 outside block transfers.
    pub(super) seqno: u8,
    /// The number in the acknowledgement that the client owed: it may be slow.
    pub(super) owed: Option<u8>,
}

impl UnderWay {
    /// Whether a client frame is the acknowledgement that was owed, still in time.
    pub(super) fn is_owed(&mut self, half: &Half) -> bool {
        let Command::BlockAck { ackseq, .. } = half.command else { return false };
        self.owed.take() == Some(ackseq) && within(self.at, half.at, UNANSWERED_NS)
    }
}

/// The pairing state of a channel.
#[derive(Debug, Default)]
pub(super) struct Pairing {
    /// The request that awaits its response.
    pub(super) pending: Option<Half>,
    pub(super) held: Option<Held>,
    pub(super) tentative: Option<Tentative>,
    /// The last request that was aborted by its client or overtaken by the next one.
    pub(super) given_up: Option<Half>,
    /// Requests that came again before they were answered.
    pub(super) repeated: Option<Repeated>,
    /// The server's newest frame.
    pub(super) heard: Option<Half>,
    /// The response that was released last, at this frame.
    pub(super) released: Option<Half>,
    /// A client frame outside any transfer: what answers it is no news.
    pub(super) stray: Option<Half>,
    pub(super) unprovoked: Option<Unprovoked>,
    pub(super) under_way: Option<UnderWay>,
    /// The pending request may be what the abort before it answered.
    pub(super) abort_may_answer: bool,
    /// The object and code of the server's last abort.
    pub(super) last_abort: Option<(wire::Mux, u32)>,
    /// The last response that answered a request.
    pub(super) last_response: Option<[u8; 8]>,
    /// Number of the channel's first frame (or of the first since frames were lost).
    pub(super) first: Option<u64>,
    /// The last response or refusal, where its request was captured before it.
    pub(super) answered: Option<Half>,
    /// It is known which responses belong to which requests: where a capture begins with requests of one object that
    /// are late, each may stand before the answer to the next.
    pub(super) certain: bool,
}

impl Pairing {
    /// A transfer was initiated: a segment of the one before can no longer come.
    pub(super) fn initiated(&mut self) {
        self.given_up = self.given_up.filter(|request| request.command.is_initiate());
    }

    /// A client frame has come: it shows whose the last answer was, where it follows later than an echo, or is for
    /// another object.
    pub(super) fn ascertain(&mut self, next: &Half) {
        let own = |answer: Half| !within_hold(answer.at, next.at) || !may_answer(&next.command, &answer.command);
        self.certain |= self.answered.is_some_and(own);
    }

    /// Whether the answer before this request may be its own, captured before it.
    pub(super) fn may_be_answered(&self, request: &Half) -> bool {
        !self.certain
            && request.command.is_initiate()
            && self.answered.is_some_and(|answer| may_answer(&request.command, &answer.command))
    }

    /// Whether the last pair may still be dissolved.
    pub(super) fn is_tentative(&self) -> bool {
        self.tentative.is_some()
    }
}

/// Whether a response, or an abort for the same object, can be the answer to a request.
fn may_answer(request: &Command, answer: &Command) -> bool {
    match answer {
        Command::Abort(object, _) => request.mux() == Some(*object),
        _ => wire::fits(request, answer),
    }
}

/// Whether a response that stands soon before a request may be its answer, as where echoes are late.
pub(super) fn may_be_ahead(response: &Half, request: &Half) -> bool {
    within_hold(response.at, request.at) && may_answer(&request.command, &response.command)
}

/// Whether two frames are close enough for the second to be a late echo; without stamps, always.
pub(super) fn within_hold(from: FrameRef, to: FrameRef) -> bool {
    within(from, to, HOLD_NS)
}

/// Whether a frame follows another by no more than a time in ns; without stamps, always.
pub(super) fn within(from: FrameRef, to: FrameRef, limit_ns: i64) -> bool {
    match (from.t_ns, to.t_ns) {
        (Some(from), Some(to)) => to.saturating_sub(from) <= limit_ns,
        _ => true,
    }
}

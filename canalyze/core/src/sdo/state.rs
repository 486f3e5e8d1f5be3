//! The state of one SDO channel, which the other files of this folder read and change.

use std::collections::VecDeque;
use std::sync::Arc;

use super::abort_code::AbortCode;
use super::phase::{Half, Phase};
use super::transfer::Transfer;
use super::wire::{Command, Mux, Side};
use crate::bytes::frame::{BusId, CanId, FrameRef};
use crate::bytes::ns::Ns;
use crate::rules::finding::Finding;
use crate::words::profiles::Profile;
use crate::world::dictionary::Dictionary;
use crate::world::event::Step;

/// The server of a channel.
#[derive(Debug)]
pub(super) struct Server {
    pub(super) bus: BusId,
    pub(super) node: u8,
    /// The identifier from client to server unless it is the default channel.
    pub(super) id: Option<CanId>,
    pub(super) description: Option<Arc<Dictionary>>,
    pub(super) profile: Profile,
    /// Set if it has sent segments after an initiate with e = s = 0; true if that one had bytes other than 0 in place
    /// of data.
    pub(super) segments_unmarked: Option<bool>,
}

/// Frames that later ones are compared with.
#[derive(Debug, Default)]
pub(super) struct History {
    /// The last request that its client aborted or replaced, or that came before a boot-up.
    pub(super) given_up: Option<Half>,
    /// The request that was pending when the server was reset.
    pub(super) before_reset: Option<Half>,
    /// The server has booted since `given_up`.
    pub(super) booted: bool,
    /// The last boot-up of the server, if it is the second one for no reason.
    pub(super) booted_twice: Option<FrameRef>,
    /// Number of the client's newest frame.
    pub(super) sent: u64,
    /// The server's last abort.
    pub(super) aborted: Option<Half>,
    /// The server's newest frame.
    pub(super) heard: Option<Half>,
    /// The last released response.
    pub(super) released: Option<Half>,
    /// A client frame outside any transfer, whose response is outside as well.
    pub(super) stray: Option<Half>,
    /// The last answered request, and its response.
    pub(super) last_request: Option<Command>,
    pub(super) last_response: Option<[u8; 8]>,
    /// The server's longest response time, in ns.
    pub(super) slowest_ns: Ns,
}

/// An expedited write abandoned by the client.
#[derive(Debug, Default)]
pub(super) struct GivenUpWrite {
    /// The last one if no request was answered since.
    pub(super) left: Option<Arc<Transfer>>,
    /// The one that the current frame confirms after all.
    pub(super) confirmed: Option<Arc<Transfer>>,
}

/// A server's frame that waits for its turn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Held {
    pub(super) half: Half,
    /// Its request may precede the capture.
    pub(super) first: bool,
    /// Number of frames of the channel since.
    pub(super) age: u8,
}

/// The state after an abort, while frames of the other side may be on their way.
#[derive(Clone, Copy, Debug)]
pub(super) struct UnderWay {
    pub(super) side: Side,
    /// The abort.
    pub(super) at: FrameRef,
    /// The next sequence number of a block transfer's segments; 0 outside block transfers.
    pub(super) seqno: u8,
    /// The number in the acknowledgement that the client owed and may send late.
    pub(super) owed: Option<u8>,
    /// No request was pending when the server aborted; the refused one may be late.
    pub(super) unasked: bool,
}

/// The waiting frames, and knowledge of the order of the others.
#[derive(Debug, Default)]
pub(super) struct Sequence {
    pub(super) held: VecDeque<Held>,
    /// A request that fits the first or the next of them; the following frame decides.
    pub(super) undecided: Option<Half>,
    /// Maximum delay with which the recording host lists its own frames, in ns.
    pub(super) lag_ns: Ns,
    pub(super) under_way: Option<UnderWay>,
    /// The last response or refusal if its request was captured before it.
    pub(super) answered: Option<Half>,
    /// The assignment of responses to requests is known. At the start of a capture, late requests for one object may
    /// each precede the response to the next.
    pub(super) certain: bool,
}

/// The possibility of a transfer that the capture does not show.
#[derive(Debug)]
pub(super) struct Hypotheses {
    pub(super) open: bool,
    /// Number of the channel's first frame, or of the first after lost frames.
    pub(super) first: Option<u64>,
    /// The capture contains the channel's first frame.
    pub(super) whole: bool,
    /// A frame outside any transfer was reported since the channel was idle.
    pub(super) reported: bool,
    /// The previous frame: its side, its first byte, and true if it is known to be no block segment.
    pub(super) before: Option<(Side, u8, bool)>,
}

impl Default for Hypotheses {
    fn default() -> Self {
        Self { open: true, first: None, whole: false, reported: false, before: None }
    }
}

/// The evidence that a channel's frames are SDO.
#[derive(Debug, Default)]
pub(super) struct Proof {
    /// A valid request with its response was seen since the last loss of frames.
    pub(super) trusted: bool,
    /// A valid request with its response was seen at any time.
    pub(super) proven: bool,
    /// A plausible request was seen, from which on frames are judged.
    pub(super) begun: bool,
    /// A matching request and response were seen, about any object.
    pub(super) paired: bool,
    pub(super) requests: u64,
    pub(super) responses: u64,
    /// Number of frames that no stack would send: undefined commands, reserved bits.
    pub(super) odd: u64,
    /// The same number for the whole capture.
    pub(super) strange: u64,
    /// Number of unmistakable requests.
    pub(super) plausible: u64,
    /// Number of requests and responses about objects that devices usually have.
    pub(super) usual: u64,
    /// The client's last request while nothing is answered; the number of requests sooner than a client gives up, of
    /// those sooner than any client does, and of those abandoned.
    pub(super) last_request: Option<(Mux, FrameRef)>,
    pub(super) went_on: u64,
    pub(super) went_on_at_once: u64,
    pub(super) given_up: u64,
    /// Answers of another server are in the capture.
    pub(super) others_answer: bool,
    /// It is the default channel of a node that reports its state.
    pub(super) of_node: bool,
    pub(super) first: Option<FrameRef>,
    pub(super) last: FrameRef,
}

/// A write refused by the server.
#[derive(Clone, Copy, Debug)]
pub(super) struct Refused {
    pub(super) object: Mux,
    /// The abort and its code.
    pub(super) at: FrameRef,
    pub(super) code: AbortCode,
    /// The cause of the refusal.
    pub(super) because_of: Option<FrameRef>,
}

/// A possible fault, or a hole of the recording.
#[derive(Debug)]
pub(super) struct Doubt {
    pub(super) finding: Finding,
    /// The fault makes the transfer fail although both sides took it as complete.
    pub(super) bad: bool,
    /// Number of data bytes of the transfer before it.
    pub(super) offset: u64,
}

/// Frames of the server without a request, and their findings.
#[derive(Debug)]
pub(super) struct Unasked {
    pub(super) first: FrameRef,
    pub(super) last: FrameRef,
    pub(super) frames: u64,
    /// Number of frames that lost requests do not explain.
    pub(super) unexplained: u64,
    /// The object named by the last of them.
    pub(super) object: Option<Mux>,
    pub(super) findings: Vec<Finding>,
    /// Number of frames when a flood was reported.
    pub(super) reported: Option<u64>,
}

/// The findings of a channel, and the reasons to withhold them.
#[derive(Debug, Default)]
pub(super) struct Verdicts {
    /// Findings that wait for the proof of the channel.
    pub(super) withheld: Vec<Finding>,
    /// The first finding above info since the channel was last idle, which explains later ones.
    pub(super) fault: Option<FrameRef>,
    /// Possible faults of the running transfer, or lost frames; its end decides.
    pub(super) doubted: Vec<Doubt>,
    /// Refused writes not yet repeated with success.
    pub(super) refused: Vec<Refused>,
    /// The next finding is about a frame that may be missing from the recording; true if it was certainly sent.
    pub(super) lost: Option<bool>,
    /// The object of the next finding if not the transfer's.
    pub(super) about: Option<Mux>,
    /// The last request to the server while it must not answer.
    pub(super) unanswerable: Option<FrameRef>,
    /// The server was only looked for, like all others.
    pub(super) scanned: bool,
    /// Frames of the server without request since the client's last frame.
    pub(super) unasked: Option<Unasked>,
    /// The overdue request that was reported: its number, and the frame at that time.
    pub(super) overdue: Option<(u64, FrameRef)>,
    /// The first finding on a missing answer since the server's last frame.
    pub(super) mute: Option<FrameRef>,
    /// The complete lack of answers was reported.
    pub(super) distrusted: bool,
}

/// One SDO channel.
#[derive(Debug)]
pub struct SdoChannel {
    pub(super) server: Server,
    pub(super) phase: Phase,
    pub(super) transfer: Option<Box<Transfer>>,
    pub(super) hypotheses: Hypotheses,
    pub(super) sequence: Sequence,
    pub(super) history: History,
    pub(super) proof: Proof,
    pub(super) verdicts: Verdicts,
    /// Transfers listed only if the channel proves to be SDO.
    pub(super) unlisted: Vec<Arc<Transfer>>,
    /// The step of the current frame.
    pub(super) step: Step,
    /// True if completed transfers belong to the current frame.
    pub(super) own: bool,
    pub(super) given_up_write: GivenUpWrite,
    /// Side and first byte of the channel's next frame if it was read ahead.
    pub(super) ahead: Option<(Side, u8)>,
    /// The last frames and their readings, while the capture may contain duplicates.
    pub(super) recent: VecDeque<(Half, Step)>,
}

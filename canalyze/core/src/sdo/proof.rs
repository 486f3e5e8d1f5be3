//! Evidence that the frames of a channel are SDO, and reports on a channel that is not SDO or is recorded one-sided.
//!
//! Nothing is judged before the first plausible request; findings are withheld until the channel has shown a valid
//! request with its response.

use super::limits::{GIVEN_UP_NS, SHORTEST_TIMEOUT_NS, UNANSWERED_NS};
use super::phase::{Half, strict_initiate};
use super::state::{Proof, SdoChannel};
use super::unasked::APART_NS;
use super::wire::{Command, Mux, Side};
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::rules::finding::{Finding, Verdict};
use crate::rules::sdo::{Sdo030, Sdo031};
use crate::world::context::Context;

/// Number of odd frames without any valid exchange that make a channel foreign.
const FOREIGN: u64 = 16;
/// Number of frames among which one impossible frame is not explained by lost answers.
const ODD: u64 = 8;
/// Minimum number of frames that describe a channel.
const FEW: u64 = 20;
/// Number of requests never answered by any of the responses that shows both to be foreign.
const IN_VAIN: u64 = 4;
/// Frames are SDO if more than three out of this number are plausible.
const PART: u64 = 4;
/// Number of requests sooner than a client gives up that shows answers outside the capture.
pub const WENT_ON: u64 = 2;
/// Number of server frames in a flood without any request in the capture.
const FLOOD: u64 = 100;

/// A channel recorded in one direction only.
#[derive(Clone, Copy, Debug)]
pub struct OneSided {
    /// The recorded side.
    pub side: Side,
    /// Number of frames.
    pub frames: u64,
    /// The first frame.
    pub first: FrameRef,
    /// The server's node-ID.
    pub node: u8,
}

impl Proof {
    /// Counts a frame.
    pub(super) fn count(&mut self, side: Side, at: FrameRef) {
        self.first.get_or_insert(at);
        self.last = at;
        let frames = if side == Side::Client { &mut self.requests } else { &mut self.responses };
        *frames = frames.saturating_add(1);
    }

    /// Takes a frame as evidence. `later`: it is not the channel's first one.
    pub(super) fn weigh(&mut self, half: &Half, later: bool) {
        let odd = matches!(half.command, Command::Unknown(_)) || half.command.has_reserved_bits(half.bytes);
        self.odd = self.odd.saturating_add(u64::from(odd));
        self.strange = self.strange.saturating_add(u64::from(odd));
        if let Command::Abort(object, _) = half.command {
            self.given_up += 1;
            // No other protocol names what it asked for again.
            let named = self.last_request.is_some_and(|(asked, _)| asked == object);
            self.usual = self.usual.saturating_add(u64::from(named && !odd && half.len == 8));
        }
        let answers = matches!(half.command, Command::UploadInitiated(..) | Command::DownloadInitiated(_));
        self.usual = self.usual.saturating_add(u64::from(answers && !odd && is_usual(half)));
        if !strict_initiate(half) {
            return;
        }
        if let Some(object) = half.command.mux() {
            let before = self.last_request.replace((object, half.at));
            let within = |limit_ns: Ns| {
                let soon = |at: FrameRef| half.at.since(at).is_none_or(|apart| (Ns::ZERO..limit_ns).contains(&apart));
                u64::from(before.is_some_and(|(other, at)| other != object && soon(at)))
            };
            self.went_on += within(SHORTEST_TIMEOUT_NS);
            self.went_on_at_once += within(GIVEN_UP_NS);
        }
        self.plausible = self.plausible.saturating_add(1);
        self.usual = self.usual.saturating_add(u64::from(is_usual(half)));
        self.begun |= later;
        if !matches!(half.command, Command::InitiateDownload(..)) {
            // Odd frames may have been block data of a transfer from before the capture.
            self.odd = 0;
        }
    }

    /// Returns the number of requests that show that the one before was answered: they name a new object and come soon.
    /// If the capture has the answers of others, this server's would be there, too, and a client with a short time-out
    /// explains all that does not come at once.
    fn shown_answered(&self) -> u64 {
        if self.others_answer { self.went_on_at_once } else { self.went_on }
    }

    /// Returns true if the client goes on as if answered: at least every other request shows an answer, and none was
    /// abandoned.
    pub(super) fn goes_on(&self) -> bool {
        let answered = self.shown_answered();
        self.given_up == 0 && answered > 0 && 2 * answered + 1 >= self.plausible
    }

    /// Returns true if a node that reports its state is asked by requests that are unmistakable but for their length: its
    /// CAN-IDs are those of SDO, whatever it answers.
    fn asks_node(&self) -> bool {
        self.of_node && self.plausible > 0 && self.plausible * PART > self.requests * 3
    }

    /// Returns true if the channel's first frame is an unmistakable request, so that its flaws and those of its answer
    /// count.
    pub(super) fn is_first_exchange(&self) -> bool {
        self.plausible > 0 && self.requests <= 1 && self.responses <= 1
    }
}

impl SdoChannel {
    pub(super) fn trust(&mut self, cx: &mut Context<'_>) {
        (self.proof.trusted, self.proof.proven, self.proof.begun) = (true, true, true);
        cx.evidence.services.prove(self.server.node);
        cx.evidence.recording.shows_answer_of(self.server.node);
        self.report_withheld(cx);
        self.list_withheld(cx);
    }

    /// Reports what was withheld.
    pub(super) fn report_withheld(&mut self, cx: &mut Context<'_>) {
        for finding in std::mem::take(&mut self.verdicts.withheld) {
            cx.emit(finding);
        }
    }

    /// Returns true if the traffic is too unlike SDO to form transfers.
    pub(super) fn is_foreign(&self) -> bool {
        let frames = self.proof.requests.saturating_add(self.proof.responses);
        !self.proof.proven && self.proof.odd >= FOREIGN && self.proof.odd > frames / 2
    }

    /// Returns the number of frames.
    pub fn frames(&self) -> u64 {
        self.proof.requests.saturating_add(self.proof.responses)
    }

    /// Returns true if the frames are SDO, by an exchange or by the number of plausible ones; `None` if undecided.
    pub fn is_sdo(&self) -> Option<bool> {
        let Proof { usual, odd, .. } = self.proof;
        let frames = self.frames();
        let most = if frames < PART { 0 } else { frames * 3 / PART };
        let paired = self.proof.paired && !self.is_strange();
        if self.proof.proven || paired || usual > most || self.proof.asks_node() {
            return Some(true);
        }
        (odd > frames / ODD || self.is_strange()).then_some(false)
    }

    /// Returns true if matching frames are chance: many are implausible, or none of several requests was answered by a
    /// server's response.
    fn is_strange(&self) -> bool {
        let Proof { strange, plausible, responses, .. } = self.proof;
        let in_vain = responses > 0 && plausible >= IN_VAIN;
        let unlike = self.frames() >= FEW && (in_vain || strange > self.frames() / ODD);
        unlike && !self.proof.proven && !self.proof.asks_node()
    }

    /// Returns true if the channel is known to be SDO before the capture's end: by an exchange, or because all its
    /// frames are plausible.
    pub(super) fn is_certain(&self) -> bool {
        self.proof.proven || self.proof.usual == self.frames()
    }

    /// Returns the only recorded side if the recording is the cause: answers without any request, or a client that goes
    /// on as if answered.
    pub fn one_sided(&self) -> Option<OneSided> {
        let Proof { requests, responses, first, .. } = self.proof;
        if !self.is_one_sided() || self.is_sdo() != Some(true) || self.verdicts.scanned {
            return None;
        }
        let side = if requests == 0 { Side::Server } else { Side::Client };
        let shown = if side == Side::Client {
            self.proof.shown_answered() >= WENT_ON && self.proof.goes_on()
        } else {
            responses > 1
        };
        Some(OneSided { side, frames: self.frames(), first: first?, node: self.server.node }).filter(|_| shown)
    }

    /// Reports at the capture's end, or at `now_ns`, that a channel is not SDO or was never answered.
    pub(super) fn report_distrust(&mut self, now_ns: Option<Ns>, cx: &mut Context<'_>) {
        let Some(first) = self.proof.first.filter(|_| !self.verdicts.distrusted) else { return };
        if self.proof.proven || self.verdicts.scanned || self.proof.paired && !self.is_strange() {
            return;
        }
        let unanswered = self.proof.responses == 0 && self.is_sdo() == Some(true);
        let frames = self.proof.requests.saturating_add(self.proof.responses);
        // A request at either edge of the capture may have been answered beyond it.
        let waited = first.t_ns.zip(now_ns).map_or(Ns::ZERO, |(first, now)| now - first) > UNANSWERED_NS;
        if frames < 2 && !(unanswered && waited) || unanswered && self.proof.goes_on() {
            return;
        }
        let lasted = self.proof.last.since(first).unwrap_or(Ns::ZERO);
        let flood = self.proof.requests == 0 && frames >= FLOOD && (Ns(1)..APART_NS * frames as i64).contains(&lasted);
        // A few undecided frames are no sign of another protocol while each may be SDO.
        let other = self.is_sdo().map_or(self.proof.odd > 0 || frames >= FEW, |is_sdo| !is_sdo);
        // A capture of requests alone may not contain the answers.
        if !unanswered && !flood && !other || unanswered && !cx.evidence.recording.contains_answers() {
            return;
        }
        let what: Verdict = match (unanswered, flood) {
            (true, _) => Sdo031::Frames { frames: frames.saturating_sub(self.proof.given_up) }.into(),
            (false, true) => Sdo030::Flood { frames, duration: lasted }.into(),
            (false, false) => Sdo030::Frames { frames }.into(),
        };
        self.verdicts.distrusted = true;
        let found = cx.verdict(what, Some(self.server.node), None, None);
        cx.emit(Finding { at: first, ..found });
    }
}

/// Returns true if stacks send such an initiate about an object that devices have: indices from C000h on are reserved,
/// and sub-indices beyond the node-IDs unused, except FFh.
fn is_usual(half: &Half) -> bool {
    let usual = |object: Mux| object.index < 0xC000 && matches!(object.sub, 0..=0x7F | 0xFF);
    half.len == 8 && !half.command.has_invalid_unused() && half.command.mux().is_some_and(usual)
}

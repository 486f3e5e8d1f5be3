//! How sure it is that the frames of a channel are SDO, and what is reported of a channel that is none, or of which one
//! side is not in the capture.
//!
//! Nothing is judged before the first request that can be one; findings are withheld until the channel has shown one valid
//! request with its response. It must not judge a transfer.

use super::channel::{Channel, UNANSWERED_NS, strict_initiate};
use super::judgement::SHORTEST_TIMEOUT_NS;
use super::phase::Half;
use super::unasked::APART_NS;
use super::wire::{Command, Mux, Side};
use crate::context::Context;
use crate::finding::{Finding, Verdict};
use crate::frame::FrameRef;
use crate::rules::sdo::{Sdo030, Sdo031};

/// Odd frames on a channel that has shown no valid exchange, from which on it is not taken for SDO.
const FOREIGN: u64 = 16;
/// Lost answers do not explain that one of this number of frames is one that no stack would send.
const ODD: u64 = 8;
/// Fewer frames say nothing of the whole channel.
const FEW: u64 = 20;
/// Requests beside responses of which none answers them: neither is SDO.
const IN_VAIN: u64 = 4;
/// Frames are SDO where more than three of this number are such as stacks send.
const PART: u64 = 4;
/// Requests that follow others sooner than a client gives up: the answers were there.
const WENT_ON: u64 = 2;
/// Where no request is in the capture: frames of the server in a flood.
const FLOOD: u64 = 100;

/// How sure it is that a channel's frames are SDO.
#[derive(Debug, Default)]
pub(super) struct Proof {
    /// A valid request with its response was seen, since frames were lost if they were.
    pub(super) trusted: bool,
    /// The same was seen at any time.
    pub(super) proven: bool,
    /// A request that can be one was seen: from here on there is something to judge.
    pub(super) begun: bool,
    /// Some request and response were seen that fit each other, whatever they are about.
    pub(super) paired: bool,
    pub(super) requests: u64,
    pub(super) responses: u64,
    /// Frames among them that no stack would send: undefined commands, reserved bits.
    pub(super) odd: u64,
    /// The same, of the whole capture.
    pub(super) strange: u64,
    /// Requests among them that can only be meant as such.
    pub(super) plausible: u64,
    /// The same, and responses, of an object such as devices have.
    pub(super) usual: u64,
    /// The client's last request, while nothing is answered; how often another one followed sooner than a client gives up,
    /// and how often it gave up.
    pub(super) last_request: Option<(Mux, FrameRef)>,
    pub(super) went_on: u64,
    pub(super) given_up: u64,
    pub(super) first: Option<FrameRef>,
    pub(super) last: FrameRef,
}

/// A channel of which the capture shows one direction only.
#[derive(Clone, Copy, Debug)]
pub struct OneSided {
    /// The side that is there.
    pub side: Side,
    /// Its frames.
    pub frames: u64,
    /// The first of them.
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

    /// Takes what a frame shows of whether the channel is SDO. `later`: it is not the channel's first one.
    pub(super) fn weigh(&mut self, half: &Half, later: bool) {
        let odd = matches!(half.command, Command::Unknown(_)) || half.command.has_reserved_bits(half.bytes);
        self.odd = self.odd.saturating_add(u64::from(odd));
        self.strange = self.strange.saturating_add(u64::from(odd));
        self.given_up += u64::from(matches!(half.command, Command::Abort(..)));
        let answers = matches!(half.command, Command::UploadInitiated(..) | Command::DownloadInitiated(_));
        self.usual = self.usual.saturating_add(u64::from(answers && !odd && is_usual(half)));
        if !strict_initiate(half) {
            return;
        }
        if let Some(object) = half.command.mux() {
            let before = self.last_request.replace((object, half.at));
            let soon = |at: FrameRef| half.at.since(at).is_none_or(|apart| (0..SHORTEST_TIMEOUT_NS).contains(&apart));
            self.went_on += u64::from(before.is_some_and(|(other, at)| other != object && soon(at)));
        }
        self.plausible = self.plausible.saturating_add(1);
        self.usual = self.usual.saturating_add(u64::from(is_usual(half)));
        self.begun |= later;
        if !matches!(half.command, Command::InitiateDownload(..)) {
            // What was odd may have been block data of a transfer that began before the capture.
            self.odd = 0;
        }
    }

    /// Whether the client goes on as if it were answered: at least every other request is about another object than the one
    /// before, comes soon, and none was given up.
    pub(super) fn goes_on(&self) -> bool {
        self.given_up == 0 && self.went_on > 0 && 2 * self.went_on + 1 >= self.plausible
    }

    /// What is wrong with the channel's first frame itself, or with what answers it, counts if it can only be a
    /// request.
    pub(super) fn is_first_exchange(&self) -> bool {
        self.plausible > 0 && self.requests <= 1 && self.responses <= 1
    }
}

impl Channel {
    pub(super) fn trust(&mut self, cx: &mut Context<'_>) {
        (self.proof.trusted, self.proof.proven, self.proof.begun) = (true, true, true);
        cx.evidence.services.prove(self.server.node);
        for finding in std::mem::take(&mut self.verdicts.withheld) {
            cx.emit(finding);
        }
        self.list_withheld(cx);
    }

    /// Whether the traffic looks so little like SDO that no transfer is made of it.
    pub(super) fn is_foreign(&self) -> bool {
        let frames = self.proof.requests.saturating_add(self.proof.responses);
        !self.proof.proven && self.proof.odd >= FOREIGN && self.proof.odd > frames / 2
    }

    /// Frames of the channel.
    pub fn frames(&self) -> u64 {
        self.proof.requests.saturating_add(self.proof.responses)
    }

    /// Whether the frames are SDO: by an exchange, or by how many of them can be one; `None` where nobody can tell.
    pub fn is_sdo(&self) -> Option<bool> {
        let Proof { usual, odd, .. } = self.proof;
        let frames = self.frames();
        let most = if frames < PART { 0 } else { frames * 3 / PART };
        if self.proof.proven || self.proof.paired && !self.is_strange() || usual > most {
            return Some(true);
        }
        (odd > frames / ODD || self.is_strange()).then_some(false)
    }

    /// Whether frames that fit each other are chance: many frames are such as no stack sends, or none of several requests
    /// was answered by what a server sends.
    fn is_strange(&self) -> bool {
        let Proof { strange, plausible, responses, .. } = self.proof;
        let in_vain = responses > 0 && plausible >= IN_VAIN;
        !self.proof.proven && self.frames() >= FEW && (in_vain || strange > self.frames() / ODD)
    }

    /// Whether the channel is known to be SDO before the capture is over: by an exchange, or since every frame of it is a
    /// request, or a response, such as stacks send.
    pub(super) fn is_certain(&self) -> bool {
        self.proof.proven || self.proof.usual == self.frames()
    }

    /// The side that the capture shows alone, where that is the recording's doing: answers without any request, or a
    /// client that goes on as if it were answered.
    pub fn one_sided(&self) -> Option<OneSided> {
        let Proof { requests, responses, went_on, first, .. } = self.proof;
        if !self.is_one_sided() || self.is_sdo() != Some(true) || self.verdicts.scanned {
            return None;
        }
        let side = if requests == 0 { Side::Server } else { Side::Client };
        let shown = if side == Side::Client { went_on >= WENT_ON && self.proof.goes_on() } else { responses > 1 };
        Some(OneSided { side, frames: self.frames(), first: first?, node: self.server.node }).filter(|_| shown)
    }

    /// The capture is over, or it is `now_ns` and no answer has come: what was withheld is no SDO, or nobody has answered.
    pub(super) fn report_distrust(&mut self, now_ns: Option<i64>, cx: &mut Context<'_>) {
        let Some(first) = self.proof.first.filter(|_| !self.verdicts.distrusted) else { return };
        if self.proof.proven || self.verdicts.scanned || self.proof.paired && !self.is_strange() {
            return;
        }
        let unanswered = self.proof.responses == 0 && self.is_sdo() == Some(true);
        let frames = self.proof.requests.saturating_add(self.proof.responses);
        // A request at the capture's end may still be answered, and its answer may have been before the capture.
        let waited = first.t_ns.zip(now_ns).map_or(0, |(first, now)| now.saturating_sub(first)) > UNANSWERED_NS;
        if frames < 2 && !(unanswered && waited) || unanswered && self.proof.goes_on() {
            return;
        }
        let lasted = self.proof.last.since(first).unwrap_or(0);
        let flood = self.proof.requests == 0 && frames >= FLOOD && (1..APART_NS * frames as i64).contains(&lasted);
        // A few frames that nobody can tell are no sign of another protocol while each of them can be one of SDO.
        let other = self.is_sdo().map_or(self.proof.odd > 0 || frames >= FEW, |is_sdo| !is_sdo);
        if !unanswered && !flood && !other {
            return;
        }
        let what: Verdict = match (unanswered, flood) {
            (true, _) => Sdo031::Frames { frames }.into(),
            (false, true) => Sdo030::Flood { frames, duration: lasted }.into(),
            (false, false) => Sdo030::Frames { frames }.into(),
        };
        self.verdicts.distrusted = true;
        let found = cx.verdict(what, Some(self.server.node), None, None);
        cx.emit(Finding { at: first, ..found });
    }
}

/// Whether stacks send such an initiate, of an object such as devices have: the standard reserves indices from C000h on,
/// and node-IDs are the greatest sub-indices in use but for FFh.
fn is_usual(half: &Half) -> bool {
    let usual = |object: Mux| object.index < 0xC000 && matches!(object.sub, 0..=0x7F | 0xFF);
    half.len == 8 && !half.command.has_invalid_unused() && half.command.mux().is_some_and(usual)
}

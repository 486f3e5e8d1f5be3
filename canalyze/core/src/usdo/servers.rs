//! The knowledge of each USDO server of a bus, and the findings about its transfers.
//!
//! Nothing is reported of a server before one of its responses has been seen: until then its frames may be something
//! else, and a capture may have one direction only.

use std::collections::BTreeMap;

use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::evidence::{Rules, When};
use crate::rules::finding::{Finding, Verdict};
use crate::rules::sdo::{Sdo002, Sdo018, Sdo020, Sdo031};
use crate::sdo::abort_code::AbortCode;
use crate::sdo::channel::is_whole;
use crate::sdo::limits::{LATE_NS, PROMPT, SHORTEST_TIMEOUT_NS, SILENT_NS, UNANSWERED_NS, takes_time};
use crate::sdo::proof::{OneSided, WENT_ON};
use crate::sdo::wire::{Mux, Side};
use crate::wire::usdo::Pdu;
use crate::world::context::Context;

/// Maximum number of refused writes kept of a server (invariant 6).
const REFUSED: usize = 256;

/// The knowledge of one server.
#[derive(Debug, Default)]
struct Server {
    requests: u64,
    responses: u64,
    /// The frames that have the form of USDO.
    fitting: u64,
    /// It was proven before.
    known: bool,
    first: Option<FrameRef>,
    heard: Option<FrameRef>,
    /// The last initiate request, and the number of those sooner than a client gives up.
    last: Option<(Option<Mux>, FrameRef)>,
    went_on: u64,
    slowest_ns: Ns,
    /// The first missing response since the server was heard.
    mute: Option<FrameRef>,
    /// Refused writes that were not repeated successfully.
    refused: Vec<(Mux, AbortCode, FrameRef)>,
}

impl Server {
    fn is_proven(&self) -> bool {
        self.requests > 0 && self.responses > 0 && self.fitting * 2 > self.requests + self.responses
    }
}

/// The knowledge of all servers of a bus.
#[derive(Debug, Default)]
pub(super) struct Servers {
    all: BTreeMap<u8, Server>,
    /// The time of the oldest request without response, in ns.
    waits_ns: Option<Ns>,
    /// Time of the first frame, or of the first after lost frames, in ns.
    began_ns: Option<Ns>,
}

impl Servers {
    /// Counts a frame.
    pub(super) fn count(&mut self, request: bool, server: u8, pdu: &Pdu<'_>, len: usize, cx: &mut Context<'_>) {
        self.began_ns = self.began_ns.or(cx.at.t_ns);
        if request && server == 0 {
            return;
        }
        let one = self.all.entry(server).or_default();
        one.first.get_or_insert(cx.at);
        one.fitting += u64::from(pdu.fits(len));
        if request {
            one.requests += 1;
        } else {
            one.responses += 1;
            (one.heard, one.mute) = (Some(cx.at), None);
        }
        if one.is_proven() && !one.known {
            one.known = true;
            // Its requests so far are judged from now on.
            self.waits_ns = self.began_ns;
        }
        if one.known {
            cx.evidence.services.prove(server);
        }
    }

    /// Counts a request to all nodes, to which a server responds.
    pub(super) fn asked_of_all(&mut self, server: u8) {
        let one = self.all.entry(server).or_default();
        (one.requests, one.fitting) = (one.requests + 1, one.fitting + 1);
    }

    /// Takes an initiate request.
    pub(super) fn asked(&mut self, server: u8, mux: Option<Mux>, at: FrameRef) {
        let one = self.all.entry(server).or_default();
        let before = one.last.replace((mux, at));
        let soon =
            |before: FrameRef| at.since(before).is_none_or(|apart| (Ns::ZERO..SHORTEST_TIMEOUT_NS).contains(&apart));
        one.went_on += u64::from(before.is_some_and(|(other, before)| other != mux && soon(before)));
        self.waits_ns = [self.waits_ns, at.t_ns].into_iter().flatten().min();
    }

    /// Returns true if the server has exchanged frames with a client, so that its transfers are judged.
    pub(super) fn is_known(&self, server: u8) -> bool {
        self.all.get(&server).is_some_and(Server::is_proven)
    }

    /// Returns true if the client goes on so soon after a request that it had its response: within the server's usual
    /// time.
    pub(super) fn goes_on(&self, server: u8, asked: When, cx: &Context<'_>) -> bool {
        let slowest = self.all.get(&server).map_or(Ns::ZERO, |one| one.slowest_ns);
        let waited = cx.evidence.recording.between(asked, cx.when);
        waited.is_some_and(|waited| waited < SHORTEST_TIMEOUT_NS && waited / PROMPT <= slowest)
    }

    /// Reports a finding at the current frame; `offender`: the frame that it is about.
    pub(super) fn find(
        &mut self,
        verdict: impl Into<Verdict>,
        server: u8,
        object: Option<Mux>,
        offender: FrameRef,
        cx: &mut Context<'_>,
    ) {
        self.report(verdict.into(), server, object, (cx.at, Some(offender)), cx);
    }

    /// Reports a finding at an earlier frame, which is wrong.
    pub(super) fn find_at(
        &mut self,
        verdict: impl Into<Verdict>,
        server: u8,
        object: Option<Mux>,
        at: FrameRef,
        cx: &mut Context<'_>,
    ) {
        self.report(verdict.into(), server, object, (at, None), cx);
    }

    /// Reports a response whose request is not in the capture, unless the capture had just begun; returns true if it is
    /// reported.
    pub(super) fn find_lost_request(&mut self, server: u8, object: Option<Mux>, cx: &mut Context<'_>) -> bool {
        let heard_ns = cx.at.t_ns.zip(self.began_ns).map_or(Ns::ZERO, |(now, began)| now - began);
        let reported = self.is_known(server) && is_whole(heard_ns);
        if reported {
            self.report(Sdo002::NoRequest.into(), server, object, (cx.at, None), cx);
        }
        reported
    }

    fn report(
        &mut self,
        verdict: Verdict,
        server: u8,
        object: Option<Mux>,
        (at, offender): (FrameRef, Option<FrameRef>),
        cx: &mut Context<'_>,
    ) {
        if !self.is_known(server) {
            return;
        }
        let missing = verdict == Sdo002::NoResponse.into();
        let given_up = verdict == Sdo020::GivenUp.into();
        let lacking = verdict == Sdo002::NoRequest.into();
        let cause = offender.filter(|offender| offender.no != at.no);
        let mut because_of = cause.filter(|_| given_up);
        if let Some(offender) = offender.filter(|_| missing) {
            let since = cx.evidence.recording.at(offender);
            let evidence = &*cx.evidence;
            let excuse =
                evidence.circumstances.excuse(Rules::SdoAnswer, Some(server), (since, cx.at), &evidence.recording);
            let one = self.all.entry(server).or_default();
            let first = one.mute;
            one.mute = first.or(Some(excuse.unwrap_or(at)));
            because_of = excuse.or(first);
        }
        let mut finding = Finding { because_of, at, cause, ..cx.verdict(verdict, Some(server), object, None) };
        if lacking {
            let lost = cx.evidence.recording.lacks_step(&finding, true);
            finding.because_of = finding.because_of.or(lost);
        }
        cx.emit(finding);
    }

    /// Reports a response later than clients wait; returns true if it is one.
    pub(super) fn judge_time(
        &mut self,
        server: u8,
        object: Option<Mux>,
        asked: When,
        reported: Option<FrameRef>,
        cx: &mut Context<'_>,
    ) -> bool {
        let Some(delay) = cx.evidence.recording.between(asked, cx.when) else { return false };
        let one = self.all.entry(server).or_default();
        one.slowest_ns = one.slowest_ns.max(delay);
        let recording = &cx.evidence.recording;
        let heard = recording.lateness_ns(cx.when) < delay / 2;
        let late = heard && recording.certainly_later(cx.when, asked, LATE_NS) && !object.is_some_and(takes_time);
        if late && self.is_known(server) {
            let found = cx.verdict(Sdo020::Slow { delay }, Some(server), object, Some(asked.at));
            let found = cx.excused(Rules::SdoTime, asked, Finding { because_of: reported, ..found });
            cx.report_timed(found);
        }
        late
    }

    /// Returns true if a request may be overdue at `now_ns`.
    pub(super) fn may_be_due(&self, now_ns: Ns) -> bool {
        self.waits_ns.is_some_and(|waits| now_ns > waits + SILENT_NS)
    }

    /// Takes the time of the oldest request without response, in ns.
    pub(super) fn wait_from(&mut self, waits_ns: Option<Ns>) {
        self.waits_ns = waits_ns;
    }

    /// Returns true if a missing response of a server about an object would be reported.
    pub(super) fn is_awaited(&self, server: u8, object: Option<Mux>) -> bool {
        self.is_known(server) && !object.is_some_and(takes_time)
    }

    /// Returns true if a request of a server that has responded before is overdue at `now_ns`.
    pub(super) fn is_overdue(
        &self,
        server: u8,
        object: Option<Mux>,
        asked: When,
        now_ns: Ns,
        cx: &mut Context<'_>,
    ) -> bool {
        if !self.is_awaited(server, object) {
            return false;
        }
        let Some(since_ns) = asked.at.t_ns else { return false };
        // At the end of a silence of the whole bus, a paused recorder may release its frames now.
        let heard = cx.at.t_ns == Some(now_ns);
        let silence = cx.evidence.recording.silence(now_ns).filter(|silence| heard && silence.to_ns > since_ns);
        let paused_ns = silence.map_or(Ns::ZERO, |silence| silence.to_ns - silence.from_ns.max(since_ns));
        let now = cx.clock(now_ns);
        cx.evidence.recording.certainly_later(now, asked, SILENT_NS + paused_ns)
    }

    /// Returns true if a request at the end of the capture has waited too long for its response.
    pub(super) fn is_old(&self, asked: When, cx: &Context<'_>) -> bool {
        let now = cx.evidence.recording.at(cx.at);
        cx.evidence.recording.between(asked, now).is_some_and(|waited| waited > UNANSWERED_NS)
    }

    /// Keeps a refused write until the object is written after all.
    pub(super) fn refuse(&mut self, server: u8, object: Option<Mux>, code: AbortCode, at: FrameRef) {
        let one = self.all.entry(server).or_default();
        if let Some(object) = object.filter(|object| one.refused.iter().all(|(known, ..)| known != object))
            && one.refused.len() < REFUSED
        {
            one.refused.push((object, code, at));
        }
    }

    /// Takes a successful write.
    pub(super) fn written(&mut self, server: u8, object: Option<Mux>) {
        if let Some(one) = self.all.get_mut(&server) {
            one.refused.retain(|(refused, ..)| Some(*refused) != object);
        }
    }

    /// Begins anew after lost frames.
    pub(super) fn restart(&mut self) {
        (self.waits_ns, self.began_ns) = (None, None);
        for one in self.all.values_mut() {
            (one.last, one.mute) = (None, None);
        }
    }

    /// Returns the number of frames, and whether they are known to be USDO; `None` without any.
    pub(super) fn shown(&self) -> Option<(Option<bool>, u64)> {
        let frames: u64 = self.all.values().map(|one| one.requests + one.responses).sum();
        let fitting: u64 = self.all.values().map(|one| one.fitting).sum();
        let proven = self.all.values().any(Server::is_proven) || frames > 0 && fitting == frames;
        (frames > 0).then_some((proven.then_some(true), frames))
    }

    /// Returns the servers of which one direction only was recorded.
    pub(super) fn one_sided(&self) -> Vec<OneSided> {
        let shown = |(node, one): (&u8, &Server)| {
            let (side, frames, shown) = match (one.requests, one.responses) {
                (0, responses) => (Side::Server, responses, responses > 1),
                (requests, 0) => (Side::Client, requests, one.went_on >= WENT_ON && 2 * one.went_on + 1 >= requests),
                _ => return None,
            };
            let plausible = one.fitting == frames && shown;
            Some(OneSided { side, frames, first: one.first?, node: *node }).filter(|_| plausible)
        };
        self.all.iter().filter_map(shown).collect()
    }

    /// Reports servers that have never responded, and refused writes, at the end of the capture.
    pub(super) fn finish(&mut self, cx: &mut Context<'_>) {
        let one_sided = self.one_sided();
        let age = |from: FrameRef| cx.at.since(from).unwrap_or(Ns::ZERO);
        let mut found = Vec::new();
        for (server, one) in &mut self.all {
            let waited = one.first.is_some_and(|first| age(first) > UNANSWERED_NS);
            let seen = one_sided.iter().any(|known| known.node == *server);
            let plausible = one.requests > 0 && one.fitting == one.requests && !seen;
            if one.responses == 0 && plausible && waited && cx.evidence.recording.contains_answers() {
                let finding = cx.verdict(Sdo031::Frames { frames: one.requests }, Some(*server), None, None);
                found.extend(one.first.map(|at| Finding { at, ..finding }));
            }
            let rests = one.heard.is_some_and(|heard| age(heard) > SHORTEST_TIMEOUT_NS);
            for (object, abort, at) in std::mem::take(&mut one.refused) {
                if rests || age(at) > UNANSWERED_NS {
                    let finding = cx.verdict(Sdo018::Refused { abort }, Some(*server), Some(object), None);
                    found.push(Finding { at, ..finding });
                }
            }
        }
        found.into_iter().for_each(|finding| cx.emit(finding));
    }
}

//! Findings of a channel: reported, withheld, or linked to their explanation.
//!
//! Findings are withheld until the channel has proved to be SDO (`proof`). Consequences are linked to their cause
//! (`because_of`), not dropped.

use super::limits::{LATE_NS, PROMPT, SHORTEST_TIMEOUT_NS, SILENT_NS, UNANSWERED_NS, takes_time};
use super::phase::{Half, Phase};
use super::state::{Doubt, SdoChannel, Verdicts};
use super::transfer::Transfer;
use super::wire::{self, Command, Segment, Side};
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::evidence::{Rules, When};
use crate::rules::finding::{Code, Finding, Severity, Verdict};
use crate::rules::sdo::{Sdo002, Sdo004, Sdo005, Sdo010, Sdo012, Sdo018, Sdo020, Sdo023, Sdo024};
use crate::world::context::Context;
use crate::world::event::{Event, Note, Place, What};

/// Maximum number of withheld findings.
const WITHHELD: usize = 32;

impl Verdicts {
    /// Drops doubts that can no longer be decided.
    pub(super) fn drop_doubts(&mut self) {
        self.doubted.clear();
    }
}

impl SdoChannel {
    /// Reports flaws of the frame itself, regardless of its place.
    pub(super) fn judge_frame(&mut self, half: &Half, cx: &mut Context<'_>) {
        if half.len != 8 {
            let length = half.len.into();
            let what = match self.step.side {
                Side::Client => Sdo010::Request { length },
                Side::Server => Sdo010::Response { length },
            };
            self.find(what, half.at, cx);
        }
        if matches!(self.step.place, Place::Uncaptured | Place::InFlight) {
            return;
        }
        match half.command {
            Command::Unknown(command) => self.find(Sdo023::Command { command }, half.at, cx),
            Command::Segment(Segment { last: false, unused, .. }) if unused != 0 => {
                self.find(Sdo005::Unused { unused: unused.into() }, half.at, cx);
            }
            Command::InitiateDownload(_, i) | Command::UploadInitiated(_, i)
                if half.command.has_invalid_unused() && (i.expedited || i.size_indicated) =>
            {
                self.find(Sdo004::Unused { unused: i.unused.into() }, half.at, cx);
            }
            Command::InitiateBlockUpload { blksize, .. } | Command::BlockDownloadInitiated { blksize, .. }
                if half.command.has_invalid_block_size() && half.len > 4 && self.is_asked_for(half) =>
            {
                self.find(Sdo012::BlockSize { blksize: blksize.into() }, half.at, cx);
            }
            _ => {}
        }
        if half.command.has_reserved_bits(half.bytes) {
            self.find(Code::Sdo009, half.at, cx);
        }
    }

    /// Returns true for a request, and for a response of the kind that the pending request asks for.
    fn is_asked_for(&self, half: &Half) -> bool {
        let fits = |pending: Half| wire::kind_fits(&pending.command, &half.command);
        half.command.is_initiate() || self.pending().is_none_or(fits)
    }

    pub(super) fn note(&mut self, note: Note, about: FrameRef, cx: &mut Context<'_>) {
        if !self.proof.trusted {
            return;
        }
        cx.events.push(Event {
            at: cx.at,
            about: Some(Box::new(about)),
            bus: self.server.bus,
            node: Some(self.server.node),
            transfer: self.transfer.as_ref().map(|transfer| transfer.id),
            what: What::Note(note),
        });
    }

    /// Reports a finding about `offender`: at that frame if it is wrong, at the current frame if something is missing
    /// after it.
    pub(super) fn find(&mut self, verdict: impl Into<Verdict>, offender: FrameRef, cx: &mut Context<'_>) {
        let verdict = verdict.into();
        let missing = is_missing(&verdict);
        if (missing || verdict.code == Code::Sdo015) && self.is_reported(offender) {
            return;
        }
        if let Some(finding) = self.finding(verdict, offender, cx) {
            let finding = self.explained_by_loss(finding, cx);
            self.note_with_transfer(finding.code, missing);
            self.report(finding, cx);
        }
    }

    /// Links a finding about a frame that may be missing from the recording, if that loses frames.
    pub(super) fn explained_by_loss(&mut self, finding: Finding, cx: &mut Context<'_>) -> Finding {
        let Some(sent) = self.verdicts.lost.take() else { return finding };
        let lost = cx.evidence.recording.lacks_step(&finding, sent);
        Finding { because_of: finding.because_of.or(lost), ..finding }
    }

    /// Keeps a finding that lost frames would explain as well; it is reported if the transfer proves complete. `bad`:
    /// the fault makes the transfer fail although both sides took it as complete.
    pub(super) fn doubt(&mut self, verdict: impl Into<Verdict>, offender: FrameRef, bad: bool, cx: &mut Context<'_>) {
        if let Some(finding) = self.finding(verdict.into(), offender, cx) {
            // A download's segment counts once confirmed, so the current one precedes the evidence in its response.
            let (download, awaited) = (!self.is_upload(), matches!(self.phase, Phase::Segments(_)));
            let size = self.transfer.as_ref().map_or(0, |transfer| transfer.data.size);
            let offset = if download && awaited && self.is_of_server(offender) { size.saturating_add(7) } else { size };
            self.verdicts.doubted.push(Doubt { finding, bad, offset });
        }
        if self.verdicts.doubted.len() >= WITHHELD {
            self.confirm_doubts(cx);
        }
    }

    /// Returns true if a frame is the newest one of the server.
    fn is_of_server(&self, at: FrameRef) -> bool {
        self.history.heard.is_some_and(|heard| heard.at.no == at.no)
    }

    /// Returns true if the running transfer has doubts or lacks a frame.
    pub(super) fn is_doubted(&self) -> bool {
        let lacking = |code: &Code| matches!(code, Code::Sdo002 | Code::Sdo024);
        let lacks = |transfer: &Transfer| transfer.outcome.findings.iter().any(lacking);
        !self.verdicts.doubted.is_empty() || self.transfer.as_deref().is_some_and(lacks)
    }

    /// Reports the doubts as faults.
    pub(super) fn confirm_doubts(&mut self, cx: &mut Context<'_>) {
        for Doubt { finding, bad, .. } in std::mem::take(&mut self.verdicts.doubted) {
            if let Some(transfer) = &mut self.transfer {
                transfer.outcome.bad |= bad;
            }
            self.note_with_transfer(finding.code, false);
            self.report(finding, cx);
        }
    }

    /// Explains the doubts by this number of segments missing in the recording.
    pub(super) fn dismiss_doubts(&mut self, lacking: Sdo024, cx: &mut Context<'_>) {
        let doubted = std::mem::take(&mut self.verdicts.doubted);
        let first = doubted.first().map_or(cx.at, |doubt| doubt.finding.at);
        let explains = |fault: &FrameRef| doubted.iter().any(|doubt| doubt.finding.at.no == fault.no);
        self.verdicts.fault = self.verdicts.fault.filter(|fault| !explains(fault));
        if let Some(transfer) = &mut self.transfer {
            transfer.data.hole = true;
            // In a block transfer doubts appear at an acknowledgement or at the end.
            if matches!(self.phase, Phase::Segments(_)) {
                doubted.iter().for_each(|doubt| transfer.miss_before(doubt.offset));
            }
        }
        self.find(lacking, first, cx);
    }

    /// Lists a finding with the running transfer. On a one-sided channel missing answers cannot be judged.
    pub(super) fn note_with_transfer(&mut self, code: Code, missing: bool) {
        let told = !missing || !self.is_one_sided();
        if let Some(transfer) = self.transfer.as_mut().filter(|_| told) {
            transfer.note_finding(code);
        }
    }

    /// Returns a finding about `offender`; `None` while nothing is judged.
    pub(super) fn finding(&mut self, verdict: Verdict, offender: FrameRef, cx: &Context<'_>) -> Option<Finding> {
        let code = verdict.code;
        // No frame of a transfer has another length, in any phase.
        let always = matches!(code, Code::Sdo017 | Code::Sdo010);
        if !self.proof.begun && !self.proof.is_first_exchange() && !always {
            return None;
        }
        let missing = is_missing(&verdict);
        let in_vain = self.verdicts.unanswerable.filter(|request| missing && request.no == offender.no);
        let object = match &self.transfer {
            Some(transfer) => transfer.mux,
            None => self.step.result.as_ref().and_then(|transfer| transfer.mux),
        };
        let object = self.verdicts.about.take().or(object);
        let initiated = self.transfer.as_ref().is_some_and(|transfer| transfer.data.initiated == Some(offender));
        let last = code == Code::Sdo006 && !initiated;
        let at = if last || is_wrong(&verdict) { offender } else { cx.at };
        let unanswered = matches!(code, Code::Sdo002 | Code::Sdo015 | Code::Sdo020 | Code::Sdo031);
        let (evidence, node) = (&cx.evidence, Some(self.server.node));
        let lost = || {
            let since = evidence.recording.at(offender);
            evidence
                .circumstances
                .excuse(Rules::SdoAnswer, node, (since, cx.at), &evidence.recording)
                .filter(|_| unanswered)
        };
        let because_of = in_vain.or_else(|| self.explain(&verdict, at, offender)).or_else(lost);
        let because_of = if missing { self.still_mute(because_of, at) } else { because_of };
        let cause = (offender.no != at.no).then_some(offender);
        let bus = self.server.bus;
        Some(Finding { code, at, cause, bus, node, object, facts: verdict.facts, because_of })
    }

    /// Returns the explanation of a missing answer: a server that has stopped answering is one fault.
    fn still_mute(&mut self, because_of: Option<FrameRef>, at: FrameRef) -> Option<FrameRef> {
        let heard = self.history.heard.map_or(0, |heard| heard.at.no);
        let first = self.verdicts.mute.filter(|first| first.no > heard);
        self.verdicts.mute = first.or(Some(because_of.unwrap_or(at)));
        because_of.or(first)
    }

    /// Returns the explanation of a finding at `at`: the first one since the channel was idle, itself unexplained.
    fn explain(&mut self, verdict: &Verdict, at: FrameRef, offender: FrameRef) -> Option<FrameRef> {
        if *verdict == Sdo020::GivenUp.into() {
            return Some(self.verdicts.fault.unwrap_or(offender));
        }
        if *verdict == Sdo020::Booted.into() && self.history.booted_twice.is_some() {
            return self.history.booted_twice;
        }
        if verdict.code.rule().severity == Severity::Info {
            return None;
        }
        let before = self.verdicts.fault;
        self.verdicts.fault = before.or(Some(at));
        before
    }

    /// Reports an answer later than clients wait.
    pub(super) fn judge_time(&mut self, request: &Half, response: &Half, cx: &mut Context<'_>) {
        self.judge_delay(request.when, self.is_edge(request), response, cx);
    }

    /// Reports the same of what the server owed since a frame. `edge`: an earlier one may have been before the capture.
    pub(super) fn judge_delay(&mut self, since: When, edge: bool, response: &Half, cx: &mut Context<'_>) {
        let (Some(asked), Some(answered)) = (since.at.t_ns, response.at.t_ns) else { return };
        let delay = answered - asked;
        self.history.slowest_ns = self.history.slowest_ns.max(delay);
        let object = self.transfer.as_ref().and_then(|transfer| transfer.mux);
        let recording = &cx.evidence.recording;
        // During a silence of the whole bus the recorder may have paused.
        let heard = recording.lateness_ns(response.when) < delay / 2;
        let late = heard && recording.certainly_later(response.when, since, LATE_NS);
        if late && self.proof.trusted && !edge && !object.is_some_and(takes_time) {
            let evidence = &cx.evidence;
            let because_of = evidence.circumstances.excuse(
                Rules::SdoTime,
                Some(self.server.node),
                (since, cx.at),
                &evidence.recording,
            );
            let because_of =
                self.verdicts.overdue.filter(|(no, _)| *no == since.at.no).map(|(_, at)| at).or(because_of);
            let found = cx.verdict(Sdo020::Slow { delay }, Some(self.server.node), object, Some(since.at));
            cx.report_timed(Finding { because_of, ..found });
        }
    }

    /// Returns true if a request at the capture's end, or at a reset, has waited too long for an answer; for a read this
    /// is shorter if the server has always answered much sooner.
    pub(super) fn is_overdue(&self, request: &Half, cx: &Context<'_>) -> bool {
        let (Some(asked), Some(now)) = (request.at.t_ns, cx.at.t_ns) else { return false };
        let waited = now - asked;
        let reads = matches!(request.command, Command::InitiateUpload(_) | Command::SegmentRequest { .. });
        let prompt = self.proof.trusted && waited / PROMPT > self.history.slowest_ns;
        waited > if reads && prompt { SHORTEST_TIMEOUT_NS } else { UNANSWERED_NS }
    }

    /// Returns true if the client goes on with the current frame so soon after a request that it had its answer: within
    /// a time-out in the same transfer (`same`), and in another one within the server's usual time.
    pub(super) fn went_on(&self, request: &Half, same: bool, cx: &Context<'_>) -> bool {
        let waited = request.at.t_ns.zip(cx.at.t_ns).map(|(asked, now)| now - asked);
        match waited {
            None => same,
            Some(waited) => waited < SHORTEST_TIMEOUT_NS && (same || waited / PROMPT <= self.history.slowest_ns),
        }
    }

    /// Returns true if the missing response to a request was reported.
    fn is_reported(&self, request: FrameRef) -> bool {
        self.verdicts.overdue.is_some_and(|(no, _)| no == request.no)
    }

    /// Returns the request that waits for its response and would be reported without it.
    fn awaited(&self) -> Option<Half> {
        let pending = self.pending().filter(|pending| !self.is_reported(pending.at))?;
        let slow = self.transfer.as_ref().and_then(|transfer| transfer.mux).is_some_and(takes_time);
        let judged = self.proof.trusted && !self.is_one_sided() && !slow;
        (judged && !self.sequence.may_be_answered(&pending)).then_some(pending)
    }

    /// Returns the time at which a silent server is reported without any frame, in ns.
    pub(super) fn overdue_ns(&self) -> Option<Ns> {
        // A client that gives up and asks again is still looking for its server.
        let in_vain = || Some(self.proof.last).filter(|_| self.asks_in_vain());
        let from = self.awaited().map(|pending| pending.at).or_else(in_vain)?;
        Some(from.t_ns? + SILENT_NS)
    }

    /// Returns true if the server was asked and has never answered.
    fn asks_in_vain(&self) -> bool {
        let never = self.proof.requests > 0 && self.proof.responses == 0 && !self.proof.proven;
        never
            && !self.verdicts.distrusted
            && !self.verdicts.scanned
            && !self.proof.goes_on()
            && self.is_sdo() == Some(true)
    }

    /// Reports a server that has not answered by `now_ns`.
    pub(super) fn judge_silence(&mut self, now_ns: Ns, cx: &mut Context<'_>) {
        let Some(due_ns) = self.overdue_ns() else { return };
        // At the end of a silence of the whole bus, a paused recorder may release its frames now.
        let since_ns = due_ns - SILENT_NS;
        let heard = cx.at.t_ns == Some(now_ns);
        let silence = cx.evidence.recording.silence(now_ns).filter(|silence| heard && silence.to_ns > since_ns);
        let paused_ns = silence.map_or(Ns::ZERO, |silence| silence.to_ns - silence.from_ns.max(since_ns));
        if due_ns + paused_ns >= now_ns {
            return;
        }
        let pending = match self.awaited() {
            Some(pending) => {
                self.find(Sdo002::NoResponse, pending.at, cx);
                Some(pending)
            }
            None => {
                self.report_distrust(Some(now_ns), cx);
                self.pending()
            }
        };
        self.verdicts.overdue = pending.map(|pending| (pending.at.no, cx.at)).or(self.verdicts.overdue);
    }

    /// Reports refused writes at the end of the capture, unless the client may have been about to repeat them, which is
    /// unknown without stamps.
    pub(super) fn find_refused(&mut self, cx: &mut Context<'_>) {
        let now = cx.at;
        let older = |from: FrameRef, ns| from.t_ns.zip(now.t_ns).is_some_and(|(from, now)| now - from > ns);
        let rests = self.history.heard.is_some_and(|heard| older(heard.at, SHORTEST_TIMEOUT_NS));
        for refused in std::mem::take(&mut self.verdicts.refused) {
            if !rests && !older(refused.at, UNANSWERED_NS) {
                continue;
            }
            let what = Sdo018::Refused { abort: refused.code };
            let (at, because_of) = (refused.at, refused.because_of);
            let found = cx.verdict(what, Some(self.server.node), Some(refused.object), None);
            self.report(Finding { at, because_of, ..found }, cx);
        }
    }

    /// Reports a finding, or withholds it until the channel is proved, and while the server sends frames without
    /// request.
    pub(super) fn report(&mut self, finding: Finding, cx: &mut Context<'_>) {
        let Some(finding) = self.keep_unasked(finding, cx) else { return };
        if self.proof.trusted {
            cx.emit(finding);
        } else if self.verdicts.withheld.len() < WITHHELD {
            self.verdicts.withheld.push(finding);
        }
    }

    /// Returns true if a request may remain without response.
    pub(super) fn is_unanswerable(&self, request: &Half) -> bool {
        self.verdicts.unanswerable.is_some_and(|unanswerable| unanswerable.no == request.at.no)
    }
}

/// Returns true if a finding is about a missing answer.
fn is_missing(verdict: &Verdict) -> bool {
    [Sdo002::NoResponse.into(), Sdo012::EndNotConfirmed.into(), Sdo024::Response.into()].contains(verdict)
}

/// Returns true if a finding is about a wrong frame, not about one after which something is missing.
fn is_wrong(verdict: &Verdict) -> bool {
    let one_of = |verdicts: [Verdict; 2]| verdicts.contains(verdict);
    match verdict.code {
        Code::Sdo002 => one_of([Sdo002::NoRequest.into(), Sdo002::Duplicate.into()]),
        Code::Sdo012 => !one_of([Sdo012::EndNotConfirmed.into(), Sdo012::NoLast.into()]),
        Code::Sdo005 | Code::Sdo009 | Code::Sdo010 | Code::Sdo023 => true,
        Code::Sdo001 | Code::Sdo003 | Code::Sdo004 | Code::Sdo019 | Code::Sdo021 | Code::Sdo022 => true,
        _ => false,
    }
}

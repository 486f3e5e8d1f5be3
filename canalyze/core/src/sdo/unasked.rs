//! Frames of the server in a row without a request: single ones, or a flood.
//!
//! They wait until the client sends a frame, the server another one, or the channel is quiet: a flood is one finding
//! with its count. A lasting flood is reported while it runs, and its total at the end. Frames that lost requests
//! explain are no flood: responses to one object after another, and segments that continue a transfer.

use super::limits::UNANSWERED_NS;
use super::phase::{Half, Phase, is_strict_answer};
use super::state::{SdoChannel, Unasked};
use super::wire::{Command, Segment};
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::rules::finding::{Finding, Verdict};
use crate::rules::sdo::Sdo002;
use crate::world::context::Context;

/// Number of frames in a row that make a flood; lost requests may explain one out of this number.
const FLOOD: u64 = 4;
/// Maximum mean interval between the frames of a flood, in ns.
pub(super) const APART_NS: Ns = Ns::from_ms(50);
/// Maximum number of waiting findings (invariant 6).
const KEPT: usize = 32;

impl Unasked {
    fn begin(at: FrameRef) -> Self {
        Self { first: at, last: at, frames: 0, unexplained: 0, object: None, findings: Vec::new(), reported: None }
    }

    fn count(&mut self, half: &Half, explained: bool) {
        self.last = half.at;
        self.frames = self.frames.saturating_add(1);
        self.unexplained = self.unexplained.saturating_add(u64::from(!explained));
        self.object = half.command.mux();
    }

    /// Returns true if a flood has lasted long enough to be reported before its end.
    fn lasts(&self) -> bool {
        let long = self.last.since(self.first).is_some_and(|lasted| lasted > UNANSWERED_NS);
        self.reported.is_none() && long && self.is_flood()
    }

    fn is_flood(&self) -> bool {
        let most = APART_NS * i64::try_from(self.frames).unwrap_or(i64::MAX);
        let odd = self.frames >= FLOOD && self.unexplained >= self.frames - self.frames / FLOOD;
        odd && self.last.since(self.first).is_none_or(|lasted| lasted < most)
    }
}

impl SdoChannel {
    /// Reports a frame of the server without a request.
    pub(super) fn find_unasked(&mut self, what: Sdo002, half: &Half, cx: &mut Context<'_>) {
        let object = self.verdicts.unasked.as_ref().and_then(|run| run.object);
        let named = is_strict_answer(half) && half.command.mux() != object;
        let explained = named || self.continues(&half.command);
        let lost = explained && what == Sdo002::NoRequest;
        // Nothing but a request makes a server answer about an object.
        self.verdicts.lost = lost.then_some(true);
        let Some(finding) = self.finding(what.into(), half.at, cx) else { return };
        let finding = self.explained_by_loss(finding, cx);
        self.note_with_transfer(finding.code, false);
        let run = self.verdicts.unasked.get_or_insert_with(|| Unasked::begin(half.at));
        run.count(half, explained);
        self.report(finding, cx);
        self.report_running(cx);
    }

    /// Counts an unreadable frame in a row of frames without a request.
    pub(super) fn count_unreadable(&mut self, half: &Half, cx: &mut Context<'_>) {
        if let Some(run) = &mut self.verdicts.unasked {
            run.count(half, false);
        }
        self.report_running(cx);
    }

    /// Returns true if a frame of the server continues the running segmented transfer, except for the missing request.
    fn continues(&self, command: &Command) -> bool {
        let Phase::Segments(segments) = &self.phase else { return false };
        match command {
            Command::Segment(Segment { toggle, .. }) => self.is_upload() && *toggle == segments.toggle,
            Command::SegmentResponse { toggle } => !self.is_upload() && *toggle == segments.toggle,
            _ => false,
        }
    }

    /// Keeps a finding in a row of frames without a request; returns it otherwise.
    pub(super) fn keep_unasked(&mut self, finding: Finding, cx: &mut Context<'_>) -> Option<Finding> {
        let Some(run) = &mut self.verdicts.unasked else { return Some(finding) };
        if run.reported.is_none() && run.findings.len() < KEPT {
            run.findings.push(finding);
        } else if !run.is_flood() {
            self.end_unasked(cx);
            return Some(finding);
        }
        None
    }

    /// Reports the waiting findings when the client sends a frame, the server an expected one, or the channel is quiet.
    pub(super) fn end_unasked(&mut self, cx: &mut Context<'_>) {
        let Some(run) = self.verdicts.unasked.take() else { return };
        match run.reported {
            Some(reported) if run.frames > reported => {
                let in_all = self.finding(Sdo002::InAll { frames: run.frames }.into(), run.last, cx);
                let told = in_all.map(|found| Finding { cause: Some(run.first), because_of: Some(run.first), ..found });
                told.into_iter().for_each(|finding| self.report(finding, cx));
            }
            Some(_) => {}
            None => {
                let flood = run.is_flood();
                for finding in run.findings {
                    if flood {
                        return self.report_flood(finding, run.frames, cx);
                    }
                    self.report(finding, cx);
                }
            }
        }
    }

    /// Reports a flood with its first finding.
    fn report_flood(&mut self, first: Finding, frames: u64, cx: &mut Context<'_>) {
        let Verdict { code, facts } = Sdo002::Flood { frames }.into();
        self.report(Finding { code, facts, ..first }, cx);
    }

    /// Reports a lasting flood while it runs.
    fn report_running(&mut self, cx: &mut Context<'_>) {
        let Some(mut run) = self.verdicts.unasked.take_if(|run| run.lasts()) else { return };
        let frames = run.frames;
        for first in std::mem::take(&mut run.findings).into_iter().take(1) {
            self.report_flood(first, frames, cx);
        }
        run.reported = Some(frames);
        self.verdicts.unasked = Some(run);
    }

    /// Returns the time of the next decision without a frame, in ns.
    pub fn due(&self) -> Option<Ns> {
        [self.quiet(), self.overdue_ns()].into_iter().flatten().min()
    }

    /// Returns the time at which the channel counts as quiet, if anything waits for that, in ns.
    fn quiet(&self) -> Option<Ns> {
        let unasked = || Some(self.verdicts.unasked.as_ref()?.last.t_ns? + UNANSWERED_NS);
        self.sequence.due().or_else(unasked)
    }

    /// Decides everything that has waited long enough at `now_ns`.
    pub fn rest(&mut self, now_ns: Ns, cx: &mut Context<'_>) {
        while self.sequence.due().is_some_and(|due| due < now_ns) {
            self.release(cx);
        }
        if self.quiet().is_some_and(|due| due < now_ns) {
            self.aside(|channel| channel.end_unasked(cx));
        }
        self.aside(|channel| channel.judge_silence(now_ns, cx));
    }

    /// Returns true during a flood, whose last frames are no responses listed early.
    pub(super) fn is_flooded(&self) -> bool {
        self.verdicts.unasked.as_ref().is_some_and(Unasked::is_flood)
    }

    /// Returns true if the server sends a segment although no segmented upload runs.
    pub(super) fn is_stray_segment(&self, half: &Half) -> bool {
        let duplicate = self.history.last_response == Some(half.bytes);
        let upload = self.is_upload() || self.sequence.holds_upload();
        let known = self.proof.trusted && !self.hypotheses.are_open() && !matches!(self.phase, Phase::Block(..));
        known && matches!(half.command, Command::Segment(_)) && !upload && !duplicate && !self.is_late(half)
    }
}

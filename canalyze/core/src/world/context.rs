//! The outputs of a step of the bus: events, findings, and bytes of extracted transfers.
//!
//! It is passed to everything that judges a frame. Nothing is decided here.

use crate::bytes::frame::{BusId, Frame, FrameRef};
use crate::bytes::ns::Ns;
use crate::evidence::duplicates::Sighting;
use crate::evidence::pending::Until;
use crate::evidence::recording;
use crate::evidence::{Evidence, Rules, When};
use crate::rules::finding::{Finding, Verdict};
use crate::sdo::transfer::TransferId;
use crate::sdo::wire::Mux;
use crate::world::change::Change;
use crate::world::event::{Event, What};
use crate::world::repeats::Repeats;

/// The outputs while one frame is taken.
pub struct Context<'a> {
    /// Events of this frame, its own first.
    pub events: &'a mut Vec<Event>,
    /// The number the next transfer gets.
    pub next_transfer: &'a mut u64,
    /// True if transferred bytes are extracted.
    pub extract: bool,
    /// Extracted bytes.
    pub chunks: &'a mut Vec<Chunk>,
    /// The bus.
    pub bus: BusId,
    /// The current frame (or the last one, at the capture's end and while a live bus is silent).
    pub at: FrameRef,
    /// The behaviour of the bus's recording.
    pub evidence: &'a mut Evidence,
    /// The time of the current frame on the bus.
    pub when: When,
    /// The sighting of the current frame, which the capture may contain a second time.
    pub sighting: Sighting,
    /// The next frame of the current frame's SDO channel, if it was read ahead.
    pub next: Option<&'a Frame>,
    /// The counts of findings, if those that were shown often enough are only counted.
    pub repeats: Option<&'a mut Repeats>,
    /// Statuswords that show the state already known are not published.
    pub news_only: bool,
}

/// Bytes of a transfer that are extracted while it runs.
#[derive(Clone, Debug)]
pub struct Chunk {
    /// Number of the transfer.
    pub id: TransferId,
    /// The bus.
    pub bus: BusId,
    /// The server's node-ID.
    pub node: u8,
    /// The object, if known.
    pub mux: Option<Mux>,
    /// The next bytes.
    pub bytes: Vec<u8>,
}

impl Context<'_> {
    /// Reports the verdict of a rule at the current frame. `cause` is the earlier frame that it is about, if any.
    pub fn raise(&mut self, what: impl Into<Verdict>, node: Option<u8>, object: Option<Mux>, cause: Option<FrameRef>) {
        let finding = self.verdict(what, node, object, cause);
        self.report(finding);
    }

    /// Returns a finding at the current frame without reporting it. `cause` as in [`Self::raise`].
    pub fn verdict(
        &self,
        what: impl Into<Verdict>,
        node: Option<u8>,
        object: Option<Mux>,
        cause: Option<FrameRef>,
    ) -> Finding {
        let Verdict { code, facts } = what.into();
        Finding { code, at: self.at, cause, bus: self.bus, node, object, facts, because_of: None }
    }

    /// Reports a finding.
    pub fn report(&mut self, finding: Finding) {
        self.emit(finding);
    }

    /// Reports a finding that depends on the time of the current frame, or on a deadline that has passed by it; none if
    /// the recorder had paused.
    pub fn report_timed(&mut self, finding: Finding) {
        if self.evidence.recording.verdict(self.when.burst) != Some(recording::Verdict::Confirmed) {
            self.emit(finding);
        }
    }

    /// Returns a finding about an obligation since a frame, linked to the circumstance that excuses it, if there is
    /// one.
    #[inline]
    pub fn excused(&self, rules: Rules, since: When, mut finding: Finding) -> Finding {
        let Evidence { circumstances, recording, .. } = &*self.evidence;
        let excuse = || circumstances.excuse(rules, finding.node, (since, finding.at), recording);
        finding.because_of = finding.because_of.or_else(excuse);
        finding
    }

    /// Reports a finding after `wait_ns`, unless something explains it by then (see
    /// [`Pending::explain`](crate::evidence::Pending::explain)): then it is a consequence of that.
    pub fn report_later(&mut self, finding: Finding, wait_ns: Ns) {
        if let Some(finding) = self.evidence.pending.keep(finding, Until::Explained(wait_ns), self.when) {
            self.emit(finding);
        }
    }

    /// Reports a finding that depends on a deadline of a node. If the node owes a sign of life, it waits for that:
    /// without one, it is a consequence of the node's loss.
    pub fn report_of_node(&mut self, finding: Finding) {
        if !self.evidence.pending.is_watched(finding.node) || !self.evidence.recording.teaches(self.when) {
            return self.report_timed(finding);
        }
        self.report_if_lost(finding);
    }

    /// Reports a finding about a node at its next sign of life, where it is not withdrawn, or at the end.
    pub fn report_if_lost(&mut self, finding: Finding) {
        if let Some(finding) = self.evidence.pending.keep(finding, Until::Alive, self.when) {
            self.report(finding);
        }
    }

    /// Reports a finding unless a command that is listed late permits it (see
    /// [`Pending::withdraw`](crate::evidence::Pending::withdraw)).
    pub fn report_listed(&mut self, finding: Finding) {
        if let Some(finding) = self.evidence.pending.keep(finding, Until::Listed, self.when) {
            self.emit(finding);
        }
    }

    /// Reports the findings that have waited long enough by the current frame.
    #[inline]
    pub fn release(&mut self) {
        if !self.evidence.pending.is_empty() {
            self.release_waiting();
        }
        if self.evidence.services.holds() {
            self.release_proven();
        }
    }

    /// Reports the findings that have waited for a proof of their service.
    #[cold]
    fn release_proven(&mut self) {
        let Evidence { services, recording, .. } = &mut *self.evidence;
        for finding in services.release(self.when, recording) {
            self.put(finding);
        }
    }

    #[cold]
    fn release_waiting(&mut self) {
        for finding in self.evidence.pending.release(self.when, &self.evidence.recording) {
            self.emit(finding);
        }
    }

    /// Reports all waiting findings, at the end of the capture or when frames were lost.
    pub fn release_all(&mut self) {
        for finding in self.evidence.pending.finish(&self.evidence.recording) {
            self.emit(finding);
        }
    }

    /// Reports, at the end of the capture, the findings that wait for a proof and may be about their service.
    pub fn release_unproven(&mut self) {
        for finding in self.evidence.services.finish() {
            self.put(finding);
        }
    }

    /// Returns the time `now_ns`: that of the current frame, or a later one without a frame.
    pub fn clock(&self, now_ns: Ns) -> When {
        if self.at.t_ns == Some(now_ns) {
            return self.when;
        }
        self.evidence.recording.at(FrameRef { t_ns: Some(now_ns), ..self.at })
    }

    /// Appends an event at the current frame.
    #[inline(always)]
    pub fn push(&mut self, about: Option<FrameRef>, node: Option<u8>, what: What) {
        let about = about.map(Box::new);
        self.events.push(Event { at: self.at, about, bus: self.bus, node, transfer: None, what });
    }

    /// Appends a finding as it is, at its frame, unless the identifier of its service carries something else.
    pub fn emit(&mut self, finding: Finding) {
        if let Some(finding) = self.evidence.services.admit(finding, self.when) {
            self.put(finding);
        }
    }

    fn put(&mut self, mut finding: Finding) {
        let lost = self.evidence.recording.explain_by_losses(&finding);
        finding.because_of = finding.because_of.or(lost);
        let Finding { at, cause, bus, node, .. } = finding;
        if let Some(lost) = Change::of_finding(&finding) {
            self.events.push(Event { at, about: None, bus, node, transfer: None, what: What::Change(lost) });
        }
        if self.repeats.as_mut().is_some_and(|repeats| repeats.counts(&finding)) {
            return;
        }
        let what = What::Finding(Box::new(finding));
        self.events.push(Event { at, about: cause.map(Box::new), bus, node, transfer: None, what });
    }
}

//! What a step of the bus writes to: events, findings, and bytes of transfers that are handed out.
//!
//! It is passed down to whoever judges a frame. It must not decide anything.

use crate::bytes::frame::{BusId, Frame, FrameRef};
use crate::evidence::duplicates::Sighting;
use crate::evidence::pending::Until;
use crate::evidence::recording;
use crate::evidence::{Evidence, Rules, When};
use crate::rules::finding::{Finding, Verdict};
use crate::sdo::transfer::TransferId;
use crate::sdo::wire::Mux;
use crate::world::event::{Event, What};

/// Where events go while one frame is taken.
pub struct Context<'a> {
    /// Events of this frame, its own first.
    pub events: &'a mut Vec<Event>,
    /// The number the next transfer gets.
    pub next_transfer: &'a mut u64,
    /// Whether transferred bytes are handed out.
    pub extract: bool,
    /// Bytes handed out.
    pub chunks: &'a mut Vec<Chunk>,
    /// The bus.
    pub bus: BusId,
    /// The frame at hand (or the last one, at the capture's end and while a live bus is silent).
    pub at: FrameRef,
    /// What the recording of the bus did.
    pub evidence: &'a mut Evidence,
    /// When the frame at hand was on the bus.
    pub when: When,
    /// Whether the capture shows the frame at hand a second time.
    pub sighting: Sighting,
    /// The next frame of the SDO channel that the frame at hand belongs to, where it was read ahead.
    pub next: Option<Frame>,
}

/// Bytes of a transfer that are handed out while it runs.
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
    /// Reports what a rule says at the frame at hand. `cause` is the earlier frame it is about, if another.
    pub fn raise(&mut self, what: impl Into<Verdict>, node: Option<u8>, object: Option<Mux>, cause: Option<FrameRef>) {
        let finding = self.verdict(what, node, object, cause);
        self.report(finding);
    }

    /// A finding at the frame at hand that is not reported yet. `cause` as in [`Self::raise`].
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

    /// Reports a finding that rests on the time of the frame at hand, or on a deadline that has passed by it: none
    /// where the recorder had stood still.
    pub fn report_timed(&mut self, finding: Finding) {
        if self.evidence.recording.verdict(self.when.burst) != Some(recording::Verdict::Confirmed) {
            self.emit(finding);
        }
    }

    /// A finding about what was owed since a frame, linked to the circumstance that excuses it, if one does.
    pub fn excused(&self, rules: Rules, since: When, finding: Finding) -> Finding {
        let Evidence { circumstances, recording, .. } = &*self.evidence;
        let excuse = || circumstances.excuse(rules, finding.node, since, recording);
        Finding { because_of: finding.because_of.or_else(excuse), ..finding }
    }

    /// Reports a finding after `wait_ns`, unless something explains it by then (see
    /// [`Pending::explain`](crate::evidence::Pending::explain)): then it is that one's consequence.
    pub fn report_later(&mut self, finding: Finding, wait_ns: i64) {
        if let Some(finding) = self.evidence.pending.keep(finding, Until::Explained(wait_ns), self.when) {
            self.emit(finding);
        }
    }

    /// Reports a finding that rests on a deadline of a node. Where the node owes a sign of life it waits for that: if
    /// none comes, it is a consequence of the node's loss.
    pub fn report_of_node(&mut self, finding: Finding) {
        if !self.evidence.pending.is_watched(finding.node) || !self.evidence.recording.teaches(self.when) {
            return self.report_timed(finding);
        }
        if let Some(finding) = self.evidence.pending.keep(finding, Until::Alive, self.when) {
            self.report(finding);
        }
    }

    /// Reports a finding unless a command, listed late, permits it after all (see
    /// [`Pending::withdraw`](crate::evidence::Pending::withdraw)).
    pub fn report_listed(&mut self, finding: Finding) {
        if let Some(finding) = self.evidence.pending.keep(finding, Until::Listed, self.when) {
            self.emit(finding);
        }
    }

    /// Reports what has waited long enough by the frame at hand.
    #[inline]
    pub fn release(&mut self) {
        if !self.evidence.pending.is_empty() {
            self.release_waiting();
        }
        if self.evidence.services.holds() {
            self.release_proven();
        }
    }

    /// Reports what has waited for a proof that the service is there.
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

    /// The capture is over, or frames were lost: reports what waits and stands.
    pub fn release_all(&mut self) {
        for finding in self.evidence.pending.finish(&self.evidence.recording) {
            self.emit(finding);
        }
    }

    /// The capture is over: reports what waits for a proof and is not certain to be about something else.
    pub fn release_unproven(&mut self) {
        for finding in self.evidence.services.finish() {
            self.put(finding);
        }
    }

    /// The time `now_ns`: that of the frame at hand, or a later one at which none came.
    pub fn clock(&self, now_ns: i64) -> When {
        if self.at.t_ns == Some(now_ns) {
            return self.when;
        }
        self.evidence.recording.at(FrameRef { t_ns: Some(now_ns), ..self.at })
    }

    /// Appends an event at the frame at hand.
    #[inline]
    pub fn push(&mut self, about: Option<FrameRef>, node: Option<u8>, what: What) {
        let about = about.map(Box::new);
        self.events.push(Event { at: self.at, about, bus: self.bus, node, transfer: None, what });
    }

    /// Puts a finding out as it is, where it stands: none of a service whose identifier carries something else.
    pub fn emit(&mut self, finding: Finding) {
        if let Some(finding) = self.evidence.services.admit(finding, self.when) {
            self.put(finding);
        }
    }

    fn put(&mut self, finding: Finding) {
        let Finding { at, cause, bus, node, .. } = finding;
        let what = What::Finding(Box::new(finding));
        self.events.push(Event { at, about: cause.map(Box::new), bus, node, transfer: None, what });
    }
}

//! A queue of findings that later evidence may still explain.
//!
//! A finding waits for a time in which a cause may appear, for a node's next sign of life, or for a command that is
//! listed late. It is then released unchanged, linked to its cause or, if that command permits the observation,
//! dropped. The queue is bounded in time and count; findings beyond the bounds are released at once.

use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::rules::finding::{Code, Finding};

use super::recording::{Recording, Verdict};
use super::when::When;

/// Maximum number of waiting findings (invariant 6).
const KEPT: usize = 256;

/// The end of a finding's wait.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Until {
    /// An explanation within this time in ns (or, without stamps, frames).
    Explained(Ns),
    /// The node's next sign of life; without it, the loss of the node explains the finding.
    Alive,
    /// A frame of the host that was on the bus earlier and is listed late. After a stall of the recorder, the finding
    /// is dropped.
    Listed,
}

/// A waiting finding.
#[derive(Debug)]
struct Waiting {
    finding: Finding,
    until: Until,
    since: When,
}

/// The waiting findings of a bus.
#[derive(Debug, Default)]
pub struct Pending {
    waiting: Vec<Waiting>,
    /// Nodes, one bit each, with a sign of life due.
    watched: u128,
}

/// Number of frames for which a finding waits to be explained, without stamps.
const FRAMES: u64 = 16;

impl Pending {
    /// Keeps a finding, or returns it if there is no room.
    pub fn keep(&mut self, finding: Finding, until: Until, since: When) -> Option<Finding> {
        if self.waiting.len() >= KEPT {
            return Some(finding);
        }
        self.waiting.push(Waiting { finding, until, since });
        None
    }

    /// Returns true if no finding waits.
    pub fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }

    /// Links the waiting findings that `fits` selects to their cause.
    pub fn explain(&mut self, because_of: FrameRef, mut fits: impl FnMut(&Finding) -> bool) {
        for waiting in &mut self.waiting {
            if waiting.finding.because_of.is_none() && fits(&waiting.finding) {
                waiting.finding.because_of = Some(because_of);
            }
        }
    }

    /// Drops the waiting findings that `fits` selects; returns true if there were any.
    pub fn withdraw(&mut self, mut fits: impl FnMut(&Finding) -> bool) -> bool {
        let before = self.waiting.len();
        self.waiting.retain(|waiting| !fits(&waiting.finding));
        self.waiting.len() < before
    }

    /// Records a sign of life of a node; if `watched`, the next one is due.
    pub fn alive(&mut self, node: u8, watched: bool) {
        let bit = 1 << (node & 0x7F);
        self.watched = if watched { self.watched | bit } else { self.watched & !bit };
        for waiting in self.waiting.iter_mut().filter(|one| one.finding.node == Some(node)) {
            if waiting.until == Until::Alive {
                waiting.until = Until::Explained(Ns::ZERO);
            }
        }
    }

    /// Records the loss of a node, reported at the frame `at`, as the cause of findings that wait for its next sign of
    /// life.
    pub fn lost(&mut self, node: u8, at: FrameRef) {
        for waiting in self.waiting.iter_mut().filter(|one| one.finding.node == Some(node)) {
            if waiting.until == Until::Alive {
                waiting.finding.because_of = Some(at);
            }
        }
        self.alive(node, false);
    }

    /// Returns true if a sign of life of the node is due.
    pub fn is_watched(&self, node: Option<u8>) -> bool {
        node.is_some_and(|node| self.watched & 1 << (node & 0x7F) != 0)
    }

    /// Returns true if a finding of a rule waits for a node.
    pub fn holds(&self, code: Code, node: Option<u8>) -> bool {
        self.waiting.iter().any(|waiting| waiting.finding.code == code && waiting.finding.node == node)
    }

    /// Removes and returns the findings that have waited long enough at `now`, oldest first.
    pub fn release(&mut self, now: When, recording: &Recording) -> Vec<Finding> {
        let mut out = Vec::new();
        let mut kept = Vec::new();
        for waiting in std::mem::take(&mut self.waiting) {
            match waiting.outcome(now, recording) {
                Some(true) => out.push(waiting.finding),
                Some(false) => {}
                None => kept.push(waiting),
            }
        }
        self.waiting = kept;
        out
    }

    /// Returns all waiting findings at the end of the capture or before lost frames, except those that a command listed
    /// later might have permitted.
    pub fn finish(&mut self, recording: &Recording) -> Vec<Finding> {
        let waiting = std::mem::take(&mut self.waiting).into_iter();
        let stands = |one: &Waiting| one.until != Until::Listed || recording.lists_in_order();
        waiting.filter(stands).map(|one| one.finding).collect()
    }
}

impl Waiting {
    /// Returns true to release the finding, false to drop it, `None` while it waits.
    fn outcome(&self, now: When, recording: &Recording) -> Option<bool> {
        match self.until {
            Until::Alive => None,
            Until::Listed if recording.verdict(self.since.burst) == Some(Verdict::Confirmed) => Some(false),
            Until::Listed => recording.is_settled(self.since.at, now.at).then_some(true),
            Until::Explained(ns) => {
                let over = match recording.between(self.since, now) {
                    Some(age) => !(Ns::ZERO..=ns).contains(&age),
                    None if now.epoch != self.since.epoch => true,
                    None => now.at.no > self.since.at.no + FRAMES,
                };
                (over || self.finding.because_of.is_some()).then_some(true)
            }
        }
    }
}

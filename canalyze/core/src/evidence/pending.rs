//! Findings that later evidence may still explain, in one queue.
//!
//! A finding waits for a time in which a cause may show itself, for a node's next sign of life, or for a command that is
//! listed late. It then goes out as it is, linked to its cause, or, where that command permits what happened, not at
//! all. The queue is bounded in time and count; what is too much for it goes out at once. It must not judge.

use crate::finding::{Code, Finding};
use crate::frame::FrameRef;

use super::recording::{Recording, Verdict};
use super::when::When;

/// Findings that wait at most (invariant 6).
const KEPT: usize = 256;

/// What a finding waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Until {
    /// Something that explains it, for so many ns (or, without stamps, frames).
    Explained(i64),
    /// The node's next sign of life: without it, the loss of the node explains it.
    Alive,
    /// An own frame that was on the bus before it and is listed late. Where the recorder had stood still, it is none.
    Listed,
}

/// A finding that waits.
#[derive(Debug)]
struct Waiting {
    finding: Finding,
    until: Until,
    since: When,
}

/// Findings that wait.
#[derive(Debug, Default)]
pub struct Pending {
    waiting: Vec<Waiting>,
    /// Nodes, one bit each, that owe a sign of life.
    watched: u128,
}

/// Frames without stamps for which a finding waits to be explained.
const FRAMES: u64 = 16;

impl Pending {
    /// Keeps a finding. Gives it back where there is no room.
    pub fn keep(&mut self, finding: Finding, until: Until, since: When) -> Option<Finding> {
        if self.waiting.len() >= KEPT {
            return Some(finding);
        }
        self.waiting.push(Waiting { finding, until, since });
        None
    }

    /// Whether nothing waits.
    pub fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }

    /// Links what waits and fits to what explains it.
    pub fn explain(&mut self, because_of: FrameRef, mut fits: impl FnMut(&Finding) -> bool) {
        for waiting in &mut self.waiting {
            if waiting.finding.because_of.is_none() && fits(&waiting.finding) {
                waiting.finding.because_of = Some(because_of);
            }
        }
    }

    /// What fits is no finding after all: takes it out, and says whether there was any.
    pub fn withdraw(&mut self, mut fits: impl FnMut(&Finding) -> bool) -> bool {
        let before = self.waiting.len();
        self.waiting.retain(|waiting| !fits(&waiting.finding));
        self.waiting.len() < before
    }

    /// A node has given a sign of life, and owes the next one, or (`watched` is false) none.
    pub fn alive(&mut self, node: u8, watched: bool) {
        let bit = 1 << (node & 0x7F);
        self.watched = if watched { self.watched | bit } else { self.watched & !bit };
        for waiting in self.waiting.iter_mut().filter(|one| one.finding.node == Some(node)) {
            if waiting.until == Until::Alive {
                waiting.until = Until::Explained(0);
            }
        }
    }

    /// A node is lost, as a finding at the frame `at` says: this explains what waits for its next sign of life.
    pub fn lost(&mut self, node: u8, at: FrameRef) {
        for waiting in self.waiting.iter_mut().filter(|one| one.finding.node == Some(node)) {
            if waiting.until == Until::Alive {
                waiting.finding.because_of = Some(at);
            }
        }
        self.alive(node, false);
    }

    /// Whether a node owes a sign of life.
    pub fn is_watched(&self, node: Option<u8>) -> bool {
        node.is_some_and(|node| self.watched & 1 << (node & 0x7F) != 0)
    }

    /// Whether a finding of a rule waits for a node.
    pub fn holds(&self, code: Code, node: Option<u8>) -> bool {
        self.waiting.iter().any(|waiting| waiting.finding.code == code && waiting.finding.node == node)
    }

    /// What has waited long enough at `now`, oldest first.
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

    /// The capture is over, or frames were lost: everything that waits, but for what a command may permit that the
    /// capture would have listed late.
    pub fn finish(&mut self, recording: &Recording) -> Vec<Finding> {
        let waiting = std::mem::take(&mut self.waiting).into_iter();
        let stands = |one: &Waiting| one.until != Until::Listed || recording.lists_in_order();
        waiting.filter(stands).map(|one| one.finding).collect()
    }
}

impl Waiting {
    /// Whether it goes out (true), is none (false), or still waits.
    fn outcome(&self, now: When, recording: &Recording) -> Option<bool> {
        match self.until {
            Until::Alive => None,
            Until::Listed if recording.verdict(self.since.burst) == Some(Verdict::Confirmed) => Some(false),
            Until::Listed => recording.is_settled(self.since.at, now.at).then_some(true),
            Until::Explained(ns) => {
                let over = match recording.between(self.since, now) {
                    Some(age) => !(0..=ns).contains(&age),
                    None if now.epoch != self.since.epoch => true,
                    None => now.at.no > self.since.at.no + FRAMES,
                };
                (over || self.finding.because_of.is_some()).then_some(true)
            }
        }
    }
}

//! Findings that later evidence may still explain, in one queue.
//!
//! A finding waits for a time in which a cause may show itself. It then goes out as it is, or linked to its cause. The
//! queue is bounded in time and count; what is too much for it goes out at once. It must not judge.

use crate::finding::{Code, Finding};
use crate::frame::FrameRef;

use super::recording::Recording;
use super::when::When;

/// Findings that wait at most (invariant 6).
const KEPT: usize = 256;

/// A finding that waits.
#[derive(Debug)]
struct Waiting {
    finding: Finding,
    /// For so many ns.
    wait_ns: i64,
    since: When,
}

/// Findings that wait.
#[derive(Debug, Default)]
pub struct Pending {
    waiting: Vec<Waiting>,
}

/// Frames without stamps for which a finding waits to be explained.
const FRAMES: u64 = 16;

impl Pending {
    /// Keeps a finding for so many ns, or until something explains it. Gives it back where there is no room.
    pub fn keep(&mut self, finding: Finding, wait_ns: i64, since: When) -> Option<Finding> {
        if self.waiting.len() >= KEPT {
            return Some(finding);
        }
        self.waiting.push(Waiting { finding, wait_ns, since });
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

    /// What fits is no finding after all: takes it out.
    pub fn withdraw(&mut self, mut fits: impl FnMut(&Finding) -> bool) {
        self.waiting.retain(|waiting| !fits(&waiting.finding));
    }

    /// Whether a finding of a rule waits for a node.
    pub fn holds(&self, code: Code, node: Option<u8>) -> bool {
        self.waiting.iter().any(|waiting| waiting.finding.code == code && waiting.finding.node == node)
    }

    /// What has waited long enough at `now`, oldest first.
    pub fn release(&mut self, now: When, recording: &Recording) -> Vec<Finding> {
        let (over, waiting) =
            std::mem::take(&mut self.waiting).into_iter().partition(|one| one.is_over(now, recording));
        self.waiting = waiting;
        let over: Vec<Waiting> = over;
        over.into_iter().map(|one| one.finding).collect()
    }

    /// The capture is over, or frames were lost: everything that waits.
    pub fn finish(&mut self) -> Vec<Finding> {
        std::mem::take(&mut self.waiting).into_iter().map(|one| one.finding).collect()
    }
}

impl Waiting {
    fn is_over(&self, now: When, recording: &Recording) -> bool {
        let over = match recording.between(self.since, now) {
            Some(age) => !(0..=self.wait_ns).contains(&age),
            None if now.epoch != self.since.epoch => true,
            None => now.at.no > self.since.at.no + FRAMES,
        };
        over || self.finding.because_of.is_some()
    }
}

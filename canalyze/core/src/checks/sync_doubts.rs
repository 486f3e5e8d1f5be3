//! Findings on synchronous PDOs that wait until the period of SYNC is known.
//!
//! Before it is, nothing tells a PDO in the wrong cycle from one whose SYNC is missing, and the second is a finding on
//! the SYNC alone. It must not judge: which SYNC is missing is `beat`'s question.

use super::withheld;
use crate::checks::beat::Beat;
use crate::context::Context;
use crate::finding::{Code, Facts, Finding};
use crate::frame::FrameRef;
use crate::services::sdo::wire::Mux;

/// Findings kept while they wait (invariant 6).
const KEPT: usize = 16;
/// Cycles that they wait at most: a SYNC that is asked for by a person has no period.
const PATIENCE: u64 = 8;

/// A finding on a PDO.
#[derive(Debug)]
pub struct Doubtful {
    /// Rule.
    pub code: Code,
    /// The node whose PDO it is.
    pub node: u8,
    /// Its communication parameter.
    pub object: Mux,
    /// The earlier frame it is about, if another.
    pub cause: Option<FrameRef>,
    /// What was measured.
    pub facts: Facts,
}

/// What waits, and from which to which cycle a SYNC may be missing.
#[derive(Debug)]
struct Doubt {
    finding: Finding,
    cycles: (u64, u64),
}

/// The findings of one bus.
#[derive(Debug, Default)]
pub struct Doubts {
    waiting: Vec<Doubt>,
}

impl Doubts {
    /// Raises a finding at the frame at hand, or keeps it. `cycles`: from the one that the PDO came in before to the
    /// one that it came in.
    pub fn find(&mut self, what: Doubtful, cycles: (u64, u64), beat: &Beat, cx: &mut Context<'_>) {
        let Doubtful { code, node, object, cause, facts } = what;
        if unsettled(beat) && cx.at.t_ns.is_some() && self.waiting.len() < KEPT {
            let finding = Finding {
                code,
                at: cx.at,
                cause,
                bus: cx.bus,
                node: Some(node),
                object: Some(object),
                facts,
                because_of: None,
            };
            self.waiting.push(Doubt { finding, cycles });
        } else {
            cx.find(code, Some(node), Some(object), cause, facts);
        }
    }

    /// The SYNC that began `cycle` was late, or others are missing before it: what was found there follows from it.
    pub fn explained(&mut self, cycle: u64) {
        self.waiting.retain(|Doubt { cycles: (first, last), .. }| !(*first..=last + 1).contains(&cycle));
    }

    /// A SYNC came: what need not wait any longer is raised.
    pub fn cycle_over(&mut self, beat: &Beat, cx: &mut Context<'_>) {
        if self.waiting.is_empty() {
            return;
        }
        let over = !unsettled(beat);
        let waits = |doubt: &Doubt| !over && beat.cycle() <= doubt.cycles.1 + PATIENCE;
        let (waiting, due) = std::mem::take(&mut self.waiting).into_iter().partition(waits);
        self.waiting = waiting;
        raise(due, cx);
    }

    /// The capture is over.
    pub fn finish(&mut self, cx: &mut Context<'_>) {
        raise(std::mem::take(&mut self.waiting), cx);
    }
}

/// Whether a SYNC may yet turn out to be missing in the cycles so far.
fn unsettled(beat: &Beat) -> bool {
    beat.period_ns().is_none() || beat.catching_up()
}

fn raise(due: Vec<Doubt>, cx: &mut Context<'_>) {
    for doubt in due {
        withheld::raise(doubt.finding, cx);
    }
}

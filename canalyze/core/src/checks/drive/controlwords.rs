//! The controlwords that an axis was given (CiA 402), as far as they are in the capture.
//!
//! It must not judge what they lead to.

use super::Sample;
use crate::drive;
use crate::frame::FrameRef;

/// Controlwords kept for an axis at most.
const KEPT: usize = 16;
/// How long a controlword may be on its way, and a statusword wait to be sent, in ns.
const LAG: i64 = 1_000_000_000;
/// The same in frames of the capture, without stamps.
const LAG_FRAMES: u64 = 256;

/// The controlwords of an axis.
#[derive(Clone, Debug, Default)]
pub(super) struct Controlwords {
    /// Those that ask for something else than the one before, with the frames that brought them.
    list: Vec<(u16, FrameRef)>,
    /// The node has booted up in the capture: no controlword came before the first of them.
    pub(super) fresh: bool,
    /// One of them came in a PDO: those by which the axis is commanded are seen.
    pub(super) by_pdo: bool,
    /// Bits 7 and 3-0 of the last one that the drive must have taken.
    pub(super) given: Option<u16>,
}

impl Controlwords {
    /// None yet.
    pub(super) fn new(fresh: bool) -> Self {
        Self { fresh, ..Self::default() }
    }

    /// Some may have come that nobody can read.
    pub(super) fn forget(&mut self) {
        *self = Self { by_pdo: self.by_pdo, ..Self::default() };
    }

    /// One was sent: the drive may have taken it.
    pub(super) fn send(&mut self, word: u16, at: FrameRef) {
        let asked = word & 0x8F;
        if self.list.last().is_some_and(|(last, _)| *last == asked) {
            return;
        }
        if self.list.len() >= KEPT {
            self.list.remove(0);
            self.fresh = false;
        }
        self.list.push((asked, at));
    }

    /// Those that a drive may have obeyed since it reported `from`; `None` where not all are known.
    fn since(&self, from: &Sample) -> Option<&[(u16, FrameRef)]> {
        let in_force = self.list.iter().rposition(|(_, at)| match (at.t_ns, from.at.t_ns) {
            (Some(began), Some(reported)) => began <= reported.saturating_sub(LAG) && at.no < from.at.no,
            _ => at.no.saturating_add(LAG_FRAMES) <= from.at.no,
        });
        self.list.get(in_force.or(self.fresh.then_some(0))?..)
    }

    /// Whether they explain a change of state; `None` where not all are known.
    pub(super) fn explain(&self, from: &Sample, to: &Sample) -> Option<bool> {
        let words = self.since(from)?;
        Some(drive::explained(from.state, to.state, words.iter().map(|(word, _)| *word)))
    }

    /// The last one before a frame.
    pub(super) fn before(&self, at: FrameRef) -> Option<u16> {
        self.list.iter().rfind(|(_, sent)| sent.no < at.no).map(|(word, _)| *word)
    }
}

//! The controlwords sent to an axis (CiA 402), as far as the capture contains them.

use super::Sample;
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::world::drive;

/// Maximum number of controlwords kept per axis.
const KEPT: usize = 16;
/// Maximum delay of a controlword, and of the statusword that follows, in ns.
const LAG: Ns = Ns::from_s(1);
/// The same delay in frames of the capture, used without stamps.
const LAG_FRAMES: u64 = 256;

/// The controlwords of an axis.
#[derive(Clone, Debug, Default)]
pub(super) struct Controlwords {
    /// Controlwords that differ from the one before in bits 7 and 3-0, with their frames.
    list: Vec<(u16, FrameRef)>,
    /// The node has booted in the capture, so the list begins with its first controlword.
    pub(super) fresh: bool,
    /// A controlword came in a PDO: the PDOs that command the axis are visible.
    pub(super) by_pdo: bool,
    /// Bits 7 and 3-0 of the last controlword that reached the drive.
    pub(super) given: Option<u16>,
}

impl Controlwords {
    /// Returns an empty list.
    pub(super) fn new(fresh: bool) -> Self {
        Self { fresh, ..Self::default() }
    }

    /// Forgets all controlwords, because unreadable ones may have come.
    pub(super) fn forget(&mut self) {
        *self = Self { by_pdo: self.by_pdo, ..Self::default() };
    }

    /// Adds a controlword that the drive may have taken.
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

    /// Returns the controlwords that a drive may have obeyed since it reported `from`; `None` unless all are known.
    fn since(&self, from: &Sample) -> Option<&[(u16, FrameRef)]> {
        let in_force = self.list.iter().rposition(|(_, at)| match (at.t_ns, from.at.t_ns) {
            (Some(began), Some(reported)) => began <= reported - LAG && at.no < from.at.no,
            _ => at.no.saturating_add(LAG_FRAMES) <= from.at.no,
        });
        self.list.get(in_force.or(self.fresh.then_some(0))?..)
    }

    /// Returns true if they explain a change of state; `None` unless all are known.
    pub(super) fn explain(&self, from: &Sample, to: &Sample) -> Option<bool> {
        let words = self.since(from)?;
        Some(drive::explained(from.state, to.state, words.iter().map(|(word, _)| *word)))
    }

    /// Returns the last controlword before a frame.
    pub(super) fn before(&self, at: FrameRef) -> Option<u16> {
        self.list.iter().rfind(|(_, sent)| sent.no < at.no).map(|(word, _)| *word)
    }
}

//! How often each CAN-ID comes: when its next frame is due, and what a silence of the bus has left out.
//!
//! This is what the recording itself is measured by; what a check owes and is owed it learns by itself
//! ([`Period`](super::period::Period)). It must not know what a frame means, beyond which CAN-IDs come by themselves.

use crate::frame::Frame;

/// CAN-IDs of which the usual gap is kept: all 11-bit ones.
const IDENTIFIERS: usize = 0x800;
/// Those that tell nothing of a pause: commands, emergencies, SDO and LSS are sent when there is a reason, and the two
/// frames of an SRDO are one node's.
const APERIODIC: [std::ops::RangeInclusive<usize>; 5] =
    [0x000..=0x07F, 0x081..=0x0FF, 0x101..=0x180, 0x580..=0x67F, 0x7E4..=0x7E5];

/// How often a CAN-ID comes.
#[derive(Clone, Copy, Debug, Default)]
struct Usual {
    last_ns: i64,
    gap_ns: i64,
    /// By how much its gaps differ, in ns.
    off_ns: i64,
    /// Gaps seen, up to a few.
    gaps: u8,
    /// In how short a time it came again in the first burst, in ns; 0: it did not.
    squeezed_ns: i64,
}

impl Usual {
    /// When the next frame is due, of a CAN-ID whose gaps are even, in ns.
    fn due_ns(&self) -> Option<i64> {
        let even = self.gaps > 2 && self.off_ns < self.gap_ns / 8;
        even.then(|| self.last_ns.saturating_add(self.gap_ns))
    }
}

/// The CAN-IDs of a bus.
#[derive(Debug, Default)]
pub(super) struct Senders {
    /// By CAN-ID; empty until the first stamp.
    usual: Vec<Usual>,
    /// CAN-IDs that were seen.
    active: Vec<usize>,
}

impl Senders {
    /// Takes the time of a frame of a CAN-ID; whether it came in less than a quarter of its usual gap, where that is
    /// longer than `least_ns`.
    pub(super) fn see(&mut self, frame: &Frame, now: i64, least_ns: i64) -> bool {
        if self.usual.is_empty() {
            self.usual = vec![Usual::default(); IDENTIFIERS];
        }
        let index = frame.id.raw() as usize;
        let Some(usual) = self.usual.get_mut(index).filter(|_| !frame.id.is_extended()) else { return false };
        let gap = now.saturating_sub(usual.last_ns);
        let known = usual.last_ns != 0;
        usual.last_ns = now;
        if !known {
            self.active.push(index);
        }
        if !known || gap < 0 {
            return false;
        }
        let compressed = usual.gap_ns > least_ns && gap < usual.gap_ns / 4;
        if !compressed {
            usual.gaps = usual.gaps.saturating_add(1);
            if usual.gap_ns == 0 {
                usual.gap_ns = gap;
            }
            usual.off_ns += ((gap - usual.gap_ns).abs() - usual.off_ns) / 4;
            usual.gap_ns += (gap - usual.gap_ns) / 4;
        }
        compressed
    }

    /// How many CAN-IDs came evenly and were overdue by `room_ns` and their jitter when a silence ended, and not when it
    /// began.
    pub(super) fn overdue(&self, from: i64, to: i64, room_ns: i64) -> usize {
        let overdue = |usual: &Usual| {
            let room = (usual.gap_ns / 16).saturating_add(usual.off_ns.saturating_mul(2)).saturating_add(room_ns);
            usual.due_ns().is_some_and(|due| due >= from && due.saturating_add(room) < to)
        };
        self.active.iter().filter(|id| self.usual.get(**id).is_some_and(overdue)).count()
    }

    /// By how much a frame comes later than it was due, in ns; `None` where it was not due since `from`, or comes
    /// unevenly.
    pub(super) fn lateness(&self, frame: &Frame, from: i64, now: i64) -> Option<i64> {
        let usual = self.usual.get(frame.id.raw() as usize).filter(|_| !frame.id.is_extended())?;
        let due = usual.due_ns().filter(|due| *due > from)?;
        (due < now.saturating_add(usual.gap_ns / 4)).then(|| now.saturating_sub(due))
    }

    /// How long ago the CAN-ID of a frame came before, in ns, if it comes by itself.
    pub(super) fn came_before(&self, frame: &Frame, now: i64) -> Option<(usize, i64)> {
        let id = frame.id.raw() as usize;
        let usual = self.usual.get(id).filter(|usual| usual.last_ns != 0 && !frame.id.is_extended())?;
        comes_by_itself(id).then(|| (id, now.saturating_sub(usual.last_ns)))
    }

    /// A CAN-ID came again in a burst.
    pub(super) fn squeeze(&mut self, id: usize, gap_ns: i64) -> bool {
        let Some(usual) = self.usual.get_mut(id) else { return false };
        usual.squeezed_ns = gap_ns;
        true
    }

    /// In how short a time a CAN-ID came again in a burst, in ns; 0: it did not.
    pub(super) fn squeezed_ns(&self, id: usize) -> i64 {
        self.usual.get(id).map_or(0, |usual| usual.squeezed_ns)
    }

    /// The nodes, one bit each, of which a frame had been expected, by so many tenths of its usual gap, during a silence.
    /// A sender that fell silent before does not count.
    pub(super) fn missing(&self, from: i64, now: i64, tenths: i64) -> u128 {
        let due = |usual: &Usual| {
            let due = usual.last_ns.saturating_add(usual.gap_ns.saturating_mul(tenths) / 10);
            usual.gap_ns > 0 && (from..now).contains(&due)
        };
        let mut nodes = 0_u128;
        for id in self.active.iter().filter(|id| comes_by_itself(**id) && self.usual.get(**id).is_some_and(due)) {
            nodes |= 1 << (id % 0x80);
        }
        nodes
    }
}

/// Whether frames of a CAN-ID come when their time has come.
fn comes_by_itself(id: usize) -> bool {
    !APERIODIC.iter().any(|range| range.contains(&id))
}

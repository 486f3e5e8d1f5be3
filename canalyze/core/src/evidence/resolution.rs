//! How coarse stamps are: their digits, what all of them are multiples of, and frames that are handed over in batches.
//!
//! A stamp of a clock that goes on by a second at a time stands for the whole second before it, and that of a frame which
//! was fetched from the adapter every 16 ms for the 16 ms before it. Frames tell: a bus carries one at a time, so frames
//! that share a stamp, or that follow each other faster than the bus can carry them, were on it earlier. Must not: know
//! what a frame means, beyond which CAN-IDs come by themselves.

use super::duplicates::Sighting;
use super::senders::{comes_by_itself, identifier};
use crate::frame::Frame;

/// What the stamps are whole multiples of, in ns, up to which that is taken for their resolution by itself: software that
/// prints hundredths of a second. Frames may come at rounder times.
const ROUND_NS: i64 = 10_000_000;
/// The coarsest resolution of stamps, in ns: a clock that shows minutes.
const COARSEST_NS: i64 = 60_000_000_000;
/// Frames from which on it shows that all of them have one stamp.
const SHARING: u64 = 16;
/// The last digit of a stamp, in ns, by the number of its decimals.
const UNITS_NS: [i64; 10] = [1_000_000_000, 100_000_000, 10_000_000, 1_000_000, 100_000, 10_000, 1_000, 100, 10, 1];
/// CAN-IDs that may come by themselves.
const IDENTIFIERS: usize = 0x800;
/// Batches that are kept, and how many it takes until they are how this recording works, ...
const KEPT: usize = 8;
const USUAL: u64 = 2;
/// ... where no fewer than one run of frames in this many is one: what a recorder that stands still now and then has kept
/// is none.
const SHARE: u64 = 64;

/// The resolution of the stamps of a bus.
#[derive(Clone, Debug, Default)]
pub(super) struct Resolution {
    /// In ns; 0: nothing was seen.
    ns: i64,
    /// What all stamps are whole multiples of, in ns.
    divisor_ns: i64,
    /// Frames with a stamp, and those of them that have the stamp of the one before.
    frames: u64,
    shared: u64,
    last_ns: Option<i64>,
    batches: Batches,
}

/// Frames that a driver hands over at certain times, and that are stamped then.
#[derive(Clone, Debug, Default)]
struct Batches {
    /// The least time that all frames so far take on a bus, in ns.
    wire_ns: i64,
    /// By CAN-ID: when it came last, and what that time was then; empty until the first frame.
    last: Vec<(i64, i64)>,
    /// Runs of frames that follow each other faster than a bus can carry them; how long before this one nothing came,
    /// in ns; and whether it is known to be a batch.
    runs: u64,
    before_ns: i64,
    proven: bool,
    /// Batches, and how long before the last of them nothing came, in ns.
    count: u64,
    apart_ns: [i64; KEPT],
}

impl Resolution {
    /// Takes a stamp: with how many decimals it is written tells less than what all of them are multiples of.
    pub(super) fn narrow(&mut self, frame: &Frame, now: i64) {
        let written = frame.stamp.and_then(|stamp| UNITS_NS.get(usize::from(stamp.decimals)).copied()).unwrap_or(1);
        if self.ns == 0 || self.ns > written && now % self.divisor_ns.max(1) != 0 {
            self.divisor_ns = common_divisor(now.saturating_abs(), self.divisor_ns);
            self.ns = self.divisor_ns.max(written).min(COARSEST_NS);
        }
        self.frames = self.frames.saturating_add(1);
        self.shared = self.shared.saturating_add(u64::from(self.last_ns == Some(now)));
        self.last_ns = Some(now);
    }

    /// Takes a frame that came at `now`, `gap` after the one before, and takes `wire_ns` on a bus at least, all in ns.
    pub(super) fn follow(&mut self, frame: &Frame, times: (i64, Option<i64>, i64), sighting: Sighting) {
        self.batches.follow(frame, times, sighting == Sighting::Original);
    }

    /// How coarse the stamps are, in ns; at least 1. Where frames share a stamp, all of them are as coarse as what they are
    /// multiples of. Where none do, the frames may have come at round times.
    pub(super) fn ns(&self) -> i64 {
        let most_ns = if self.shared > 0 { COARSEST_NS } else { ROUND_NS };
        self.ns.clamp(1, most_ns).max(self.batches.apart_ns().min(COARSEST_NS))
    }

    /// Whether the stamps say when frames were on the bus. Zero is what many write where they have none, and so is one and
    /// the same stamp; but a capture may begin with a burst.
    pub(super) fn is_of_use(&self) -> bool {
        let least = if self.divisor_ns == 0 { 2 } else { SHARING };
        let changes = self.frames.saturating_sub(self.shared) > 1;
        changes || self.frames < least
    }
}

impl Batches {
    fn follow(&mut self, frame: &Frame, (now, gap, wire_ns): (i64, Option<i64>, i64), original: bool) {
        self.wire_ns = self.wire_ns.saturating_add(wire_ns);
        if gap.is_none_or(|gap| !(0..wire_ns).contains(&gap)) {
            self.runs += 1;
            (self.before_ns, self.proven) = (gap.unwrap_or(0), false);
        }
        // What is an answer, or is sent for a reason, may come again at once where there is no wire.
        let Some(id) = identifier(frame).filter(|id| *id < IDENTIFIERS && comes_by_itself(*id)) else { return };
        if self.last.is_empty() {
            self.last = vec![(i64::MIN, 0); IDENTIFIERS];
        }
        let Some(last) = self.last.get_mut(id) else { return };
        let (before, wire_before) = std::mem::replace(last, (now, self.wire_ns));
        let again = now.saturating_sub(before) < self.wire_ns.saturating_sub(wire_before);
        if again && original && self.before_ns > 0 && !std::mem::replace(&mut self.proven, true) {
            if let Some(slot) = self.apart_ns.get_mut(self.count as usize % KEPT) {
                *slot = self.before_ns;
            }
            self.count += 1;
        }
    }

    /// How far apart batches usually are, in ns; 0: frames come one by one.
    fn apart_ns(&self) -> i64 {
        if self.count < USUAL || self.count.saturating_mul(SHARE) < self.runs {
            return 0;
        }
        let mut known = self.apart_ns;
        let count = (self.count as usize).min(KEPT);
        let Some(known) = known.get_mut(..count) else { return 0 };
        known.sort_unstable();
        known.get((count - 1) / 2).copied().unwrap_or(0)
    }
}

/// The greatest common divisor (Euclid's algorithm).
fn common_divisor(mut a: i64, mut b: i64) -> i64 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

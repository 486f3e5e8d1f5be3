//! The resolution of time stamps: their digits, their common divisor, and frames that are handed over in batches.
//!
//! A stamp of a clock that advances once a second stands for the second before it, and the stamp of a frame fetched
//! from the adapter every 16 ms for the 16 ms before it. Frames show that: a bus carries one at a time, so frames that
//! share a stamp, or follow each other faster than the bus can carry them, were sent earlier.

use super::duplicates::Sighting;
use super::senders::{comes_by_itself, identifier};
use crate::bytes::frame::Frame;
use crate::bytes::ns::Ns;

/// Maximum common divisor of the stamps that is taken for their resolution by itself, in ns: software that prints
/// hundredths of a second. Frames may come at rounder times.
const ROUND_NS: Ns = Ns::from_ms(10);
/// The coarsest resolution of stamps, in ns: a clock that shows minutes.
const COARSEST_NS: Ns = Ns::from_s(60);
/// Minimum number of frames from which one common stamp counts as no stamp.
const SHARING: u64 = 16;
/// The last digit of a stamp, in ns, by its number of decimals.
const UNITS_NS: [Ns; 10] = [
    Ns::from_s(1),
    Ns::from_ms(100),
    Ns::from_ms(10),
    Ns::from_ms(1),
    Ns::from_us(100),
    Ns::from_us(10),
    Ns::from_us(1),
    Ns(100),
    Ns(10),
    Ns(1),
];
/// Number of CAN-IDs that may be sent on their own.
const IDENTIFIERS: usize = 0x800;
/// Maximum number of kept batches, and the minimum number that shows them to be usual in this recording, ...
const KEPT: usize = 8;
const USUAL: u64 = 2;
/// ... if at least one run of frames in this many is one; batches of a recorder that stalls now and then do not count.
const SHARE: u64 = 64;

/// The resolution of the stamps of a bus.
#[derive(Clone, Debug, Default)]
pub(super) struct Resolution {
    /// In ns; 0 before the first stamp.
    ns: Ns,
    /// The common divisor of all stamps, in ns.
    divisor_ns: Ns,
    /// Number of frames with a stamp, and of those that share the previous stamp.
    frames: u64,
    shared: u64,
    last_ns: Option<Ns>,
    batches: Batches,
}

/// Frames that a driver hands over, and stamps, at certain times.
#[derive(Clone, Debug, Default)]
struct Batches {
    /// The minimum time that all frames so far take on a bus, in ns.
    wire_ns: Ns,
    /// By CAN-ID: its last time, and `wire_ns` at that time; empty until the first frame.
    last: Vec<(Ns, Ns)>,
    /// Number of runs of frames that follow each other faster than a bus can carry them; the gap before the current
    /// one, in ns; and true if it is known to be a batch.
    runs: u64,
    before_ns: Ns,
    proven: bool,
    /// Number of batches, and the gaps before the last of them, in ns.
    count: u64,
    apart_ns: [Ns; KEPT],
}

impl Resolution {
    /// Adds a stamp: its number of decimals says less than the common divisor.
    #[inline]
    pub(super) fn narrow(&mut self, frame: &Frame, now: Ns) {
        let written = frame.stamp.and_then(|stamp| UNITS_NS.get(usize::from(stamp.decimals)).copied()).unwrap_or(Ns(1));
        if self.ns == Ns::ZERO || self.ns > written && now % self.divisor_ns.max(Ns(1)) != Ns::ZERO {
            self.divisor_ns = common_divisor(now.abs(), self.divisor_ns);
            self.ns = self.divisor_ns.max(written).min(COARSEST_NS);
        }
        self.frames = self.frames.saturating_add(1);
        self.shared = self.shared.saturating_add(u64::from(self.last_ns == Some(now)));
        self.last_ns = Some(now);
    }

    /// Follows a frame by its time, the gap before it, and the minimum time that it takes on a bus, all in ns.
    #[inline]
    pub(super) fn follow(&mut self, frame: &Frame, times: (Ns, Option<Ns>, Ns), sighting: Sighting) {
        self.batches.follow(frame, times, sighting == Sighting::Original);
    }

    /// Returns the resolution of the stamps in ns; at least 1. If frames share a stamp, it is the common divisor;
    /// otherwise the frames may just have come at round times.
    #[inline]
    pub(super) fn ns(&self) -> Ns {
        let most_ns = if self.shared > 0 { COARSEST_NS } else { ROUND_NS };
        self.ns.clamp(Ns(1), most_ns).max(self.batches.apart_ns().min(COARSEST_NS))
    }

    /// Returns true if the stamps show when frames were on the bus. Zero, or one stamp for all frames, often means
    /// none; but a capture may begin with a burst.
    pub(super) fn is_of_use(&self) -> bool {
        let least = if self.divisor_ns == Ns::ZERO { 2 } else { SHARING };
        self.stays_of_use() || self.frames < least
    }

    /// Returns true if no further frame changes that.
    #[inline]
    pub(super) fn stays_of_use(&self) -> bool {
        self.frames.saturating_sub(self.shared) > 1
    }
}

impl Batches {
    #[inline(always)]
    fn follow(&mut self, frame: &Frame, (now, gap, wire_ns): (Ns, Option<Ns>, Ns), original: bool) {
        self.wire_ns += wire_ns;
        if gap.is_none_or(|gap| !(Ns::ZERO..wire_ns).contains(&gap)) {
            self.runs += 1;
            (self.before_ns, self.proven) = (gap.unwrap_or(Ns::ZERO), false);
        }
        // Responses and event-driven frames may repeat at once on a virtual bus.
        let Some(id) = identifier(frame).filter(|id| *id < IDENTIFIERS && comes_by_itself(*id)) else { return };
        if self.last.is_empty() {
            self.last = vec![(Ns::MIN, Ns::ZERO); IDENTIFIERS];
        }
        let Some(last) = self.last.get_mut(id) else { return };
        let (before, wire_before) = std::mem::replace(last, (now, self.wire_ns));
        let again = now - before < self.wire_ns - wire_before;
        if again && original && self.before_ns > Ns::ZERO && !std::mem::replace(&mut self.proven, true) {
            if let Some(slot) = self.apart_ns.get_mut(self.count as usize % KEPT) {
                *slot = self.before_ns;
            }
            self.count += 1;
        }
    }

    /// Returns the usual distance of batches in ns; 0 if frames come one by one.
    fn apart_ns(&self) -> Ns {
        if self.count < USUAL || self.count.saturating_mul(SHARE) < self.runs {
            return Ns::ZERO;
        }
        let mut known = self.apart_ns;
        let count = (self.count as usize).min(KEPT);
        let Some(known) = known.get_mut(..count) else { return Ns::ZERO };
        known.sort_unstable();
        known.get((count - 1) / 2).copied().unwrap_or(Ns::ZERO)
    }
}

/// Returns the greatest common divisor (Euclid's algorithm).
fn common_divisor(mut a: Ns, mut b: Ns) -> Ns {
    while b != Ns::ZERO {
        (a, b) = (b, a % b);
    }
    a
}

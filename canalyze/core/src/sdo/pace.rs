//! The pace of the requests of a segmented transfer, or of the segments of a block transfer.
//!
//! Lost frames leave the time that they took, which shows if there was room for missing bytes.

use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;

/// Number of intervals that show no pace yet.
const FEW: i64 = 3;

/// The intervals between requests, or segments, of a transfer, in ns.
#[derive(Clone, Debug, Default)]
pub struct Pace {
    last_ns: Option<Ns>,
    sum_ns: Ns,
    count: i64,
    longest_ns: Ns,
    /// The second longest interval.
    second_ns: Ns,
    /// Number of data bytes before the frame after the longest interval.
    offset: u64,
}

impl Pace {
    /// Takes a request or a segment after this number of data bytes.
    pub(super) fn take(&mut self, request: FrameRef, offset: u64) {
        let Some(now) = request.t_ns else { return };
        let Some(last) = self.last_ns.replace(now) else { return };
        let interval = (now - last).max(Ns::ZERO);
        (self.sum_ns, self.count) = (self.sum_ns + interval, self.count.saturating_add(1));
        if interval > self.longest_ns {
            (self.second_ns, self.longest_ns, self.offset) = (self.longest_ns, interval, offset);
        } else {
            self.second_ns = self.second_ns.max(interval);
        }
    }

    /// Returns the number of data bytes before this number of missing exchanges or segments; `None` if no interval has
    /// room for them.
    pub(super) fn room_for(&self, exchanges: u64) -> Option<u64> {
        let others = (self.sum_ns - self.longest_ns) / (self.count - 1).max(1);
        let exchanges = i64::try_from(exchanges).unwrap_or(i64::MAX);
        // The pace may vary by half an exchange.
        let taken = others * exchanges + others / 2;
        let stands_out = self.longest_ns / 3 > self.second_ns / 2;
        (self.count > FEW && others > Ns::ZERO && stands_out && self.longest_ns > taken).then_some(self.offset)
    }
}

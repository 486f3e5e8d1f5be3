//! How fast the requests of a segmented transfer, or the segments of a block transfer, follow each other.
//!
//! Frames that the recording lost leave the time that they took. It must not judge: whoever misses bytes asks whether
//! there was room for them.

use crate::frame::FrameRef;

/// Fewer intervals show no pace.
const FEW: i64 = 3;

/// The intervals between requests, or segments, of a transfer, in ns.
#[derive(Clone, Debug, Default)]
pub struct Pace {
    last_ns: Option<i64>,
    sum_ns: i64,
    count: i64,
    longest_ns: i64,
    /// The longest of the others.
    second_ns: i64,
    /// Bytes of the data before the frame behind the longest one.
    offset: u64,
}

impl Pace {
    /// Takes a request or a segment, behind this number of bytes of the data.
    pub(super) fn take(&mut self, request: FrameRef, offset: u64) {
        let Some(now) = request.t_ns else { return };
        let Some(last) = self.last_ns.replace(now) else { return };
        let interval = now.saturating_sub(last).max(0);
        (self.sum_ns, self.count) = (self.sum_ns.saturating_add(interval), self.count.saturating_add(1));
        if interval > self.longest_ns {
            (self.second_ns, self.longest_ns, self.offset) = (self.longest_ns, interval, offset);
        } else {
            self.second_ns = self.second_ns.max(interval);
        }
    }

    /// Where this number of exchanges, or segments, may be missing: bytes of the data before them. None where no interval
    /// is longer than the others by what they take.
    pub(super) fn room_for(&self, exchanges: u64) -> Option<u64> {
        let others = self.sum_ns.saturating_sub(self.longest_ns) / (self.count - 1).max(1);
        let exchanges = i64::try_from(exchanges).unwrap_or(i64::MAX);
        // Half an exchange is what the pace may vary.
        let taken = others.saturating_mul(exchanges).saturating_add(others / 2);
        let stands_out = self.longest_ns / 3 > self.second_ns / 2;
        (self.count > FEW && others > 0 && stands_out && self.longest_ns > taken).then_some(self.offset)
    }
}

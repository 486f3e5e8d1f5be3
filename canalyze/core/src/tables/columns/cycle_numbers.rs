//! The SYNC cycle at a past frame.
//!
//! Of each bus the beginnings of the last cycles are kept. Must not: decide what begins a cycle.

use std::collections::VecDeque;

use crate::bytes::frame::{BusId, Frame};

/// Beginnings that are kept of a bus: at 1 kHz those of four seconds, longer than any SDO time-out that is usual.
const KEPT: usize = 4096;

/// The cycles of one bus.
#[derive(Debug, Default)]
struct OnBus {
    /// The one that runs; 0 before the first.
    cycle: u64,
    /// The frames with which the last ones began, that of `cycle` last.
    begins: VecDeque<u64>,
}

/// The cycles of all buses.
#[derive(Debug, Default)]
pub(super) struct CycleNumbers {
    buses: Vec<OnBus>,
}

impl CycleNumbers {
    /// Takes a frame, and the cycle that runs on its bus now.
    #[inline]
    pub(super) fn frame(&mut self, frame: &Frame, cycle: u64) {
        let index = usize::from(frame.bus.0);
        if self.buses.len() <= index {
            self.buses.resize_with(index + 1, OnBus::default);
        }
        let Some(bus) = self.buses.get_mut(index).filter(|bus| bus.cycle != cycle) else { return };
        if cycle != bus.cycle + 1 {
            bus.begins.clear();
        } else if bus.begins.len() >= KEPT {
            bus.begins.pop_front();
        }
        bus.cycle = cycle;
        bus.begins.push_back(frame.no);
    }

    /// The cycle that ran on a bus at a frame of this number, 0 before the first; the oldest known one before that.
    pub(super) fn at(&self, bus: BusId, frame: u64) -> u64 {
        let Some(bus) = self.buses.get(usize::from(bus.0)) else { return 0 };
        let begun = bus.begins.partition_point(|begin| *begin <= frame);
        bus.cycle.saturating_sub((bus.begins.len() - begun) as u64)
    }
}

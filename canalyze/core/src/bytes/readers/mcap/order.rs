//! Frames in the order of time, with bounded memory.
//!
//! Chunks may overlap in time, and messages within one need not be sorted. Frames are held until nothing earlier can
//! follow, as far as chunks give their beginning; at most [`MOST`] are held. Frames that come too late keep their
//! place. Frames of the same time keep the order of the file.

use super::echo::Echoes;
use super::held::Held;
use crate::bytes::frame::Frame;

/// Maximum number of held frames; beyond it half of them are released.
const MOST: usize = 1 << 17;

/// Frames that wait for earlier ones.
#[derive(Debug)]
pub(super) struct Order {
    held: Vec<Held>,
    sorted: bool,
    last_ns: i64,
    echoes: Echoes,
    /// Number of frames that were removed as echoes.
    gone: u64,
}

impl Order {
    pub(super) fn new() -> Self {
        Self { held: Vec::new(), sorted: true, last_ns: i64::MIN, echoes: Echoes::default(), gone: 0 }
    }

    /// Holds a frame; passes frames to `to` if there are too many.
    #[inline(always)]
    pub(super) fn push(&mut self, frame: Held, to: &mut impl FnMut(Frame)) {
        self.sorted &= frame.t_ns >= self.last_ns;
        self.last_ns = frame.t_ns;
        if self.held.len() >= MOST {
            self.relieve(to);
        }
        self.held.push(frame);
    }

    /// Begins the search for echoes, since a bus may now have sent and received frames.
    pub(super) fn seek_echoes(&mut self) {
        self.echoes.sought = true;
    }

    /// Returns the number of frames removed as echoes.
    pub(super) fn echoes(&self) -> u64 {
        self.gone
    }

    #[cold]
    fn relieve(&mut self, to: &mut impl FnMut(Frame)) {
        self.sort();
        let mut count = MOST / 2;
        if self.echoes.sought {
            self.echoes.look(&mut self.held, MOST / 2);
            self.echoes.decide(&mut self.held, false);
            count = Some(self.echoes.free(&self.held)).filter(|free| *free > 0).unwrap_or(count);
        }
        self.give(count, to);
    }

    /// Releases the frames before a time, since nothing earlier follows.
    pub(super) fn release(&mut self, before_ns: i64, to: &mut impl FnMut(Frame)) {
        self.sort();
        let mut count = self.held.partition_point(|frame| frame.t_ns < before_ns);
        if self.echoes.sought {
            self.echoes.look(&mut self.held, count);
            count = self.echoes.free(&self.held);
        }
        self.give(count, to);
    }

    /// Releases all frames, since nothing follows.
    pub(super) fn release_all(&mut self, to: &mut impl FnMut(Frame)) {
        self.sort();
        if self.echoes.sought {
            let all = self.held.len();
            self.echoes.look(&mut self.held, all);
            self.echoes.decide(&mut self.held, true);
        }
        self.give(self.held.len(), to);
        self.last_ns = i64::MIN;
    }

    fn sort(&mut self) {
        if !self.sorted {
            // Frames examined for echoes stay in place.
            if let Some(rest) = self.held.get_mut(self.echoes.next..) {
                rest.sort_by_key(|frame| frame.t_ns);
            }
            self.sorted = true;
        }
        self.last_ns = self.held.last().map_or(i64::MIN, |frame| frame.t_ns);
    }

    fn give(&mut self, count: usize, to: &mut impl FnMut(Frame)) {
        let count = count.min(self.held.len());
        for held in self.held.drain(..count) {
            if held.gone {
                self.gone += 1;
            } else {
                to(held.frame());
            }
        }
        if self.echoes.sought {
            self.echoes.gone(count);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bytes::frame::CanId;
    use crate::bytes::ns::Ns;

    fn frame(t_ns: i64, id: u16) -> Held {
        Held::new(t_ns, &Frame::classic(CanId::standard(id), &[]))
    }

    #[test]
    fn overlapping_chunks() {
        let mut order = Order::new();
        let mut out = Vec::new();
        let mut to = |frame: Frame| out.push((frame.t_ns.map_or(0, Ns::as_ns), frame.id.raw()));
        for (t, id) in [(5, 1), (3, 2), (9, 3), (3, 4)] {
            order.push(frame(t, id), &mut to);
        }
        order.release(4, &mut to);
        for (t, id) in [(4, 5), (10, 6), (9, 7)] {
            order.push(frame(t, id), &mut to);
        }
        order.release_all(&mut to);
        assert_eq!(out, [(3, 2), (3, 4), (4, 5), (5, 1), (9, 3), (9, 7), (10, 6)]);
    }

    #[test]
    fn memory_is_bounded() {
        let mut order = Order::new();
        let mut given = 0;
        for t in 0..3 * MOST as i64 {
            order.push(frame(-t, 1), &mut |_| given += 1);
            assert!(order.held.len() <= MOST);
        }
        order.release_all(&mut |_| given += 1);
        assert_eq!(given, 3 * MOST);
    }
}

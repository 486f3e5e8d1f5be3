//! A PDO that follows SYNC: the time between them shows the delay with which SYNC is listed.
//!
//! If the recording host sends SYNC, its echo may be listed late, and SYNCs seem unsteady. A PDO of another node that
//! comes at the same distance in every cycle shows that, because it follows the SYNC on the bus.

use crate::bytes::ns::Ns;

/// Number of past cycles in a row that are evaluated.
const CYCLES: usize = 8;

/// The PDO that has come in each of the last cycles.
#[derive(Debug, Default)]
pub(super) struct Follower {
    /// The PDO's node and number.
    pdo: Option<(u8, u16)>,
    /// The last cycle in which it came.
    cycle: u64,
    /// The delays after SYNC in the last cycles, in ns, and their number.
    delays_ns: [Ns; CYCLES],
    count: usize,
}

impl Follower {
    /// Takes a TPDO, `delay_ns` after the SYNC of its cycle.
    pub(super) fn follow(&mut self, pdo: (u8, u16), cycle: u64, delay_ns: Ns) {
        let same = self.pdo == Some(pdo);
        if cycle == self.cycle || (!same && cycle == self.cycle + 1) {
            return;
        }
        if !same || cycle != self.cycle + 1 {
            *self = Self { pdo: Some(pdo), ..Self::default() };
        }
        if let Some(slot) = self.delays_ns.get_mut(self.count % CYCLES) {
            *slot = delay_ns;
        }
        (self.cycle, self.count) = (cycle, self.count + 1);
    }

    /// Returns the maximum difference between the listing delays of the last SYNCs, in ns; `None` if unknown.
    pub(super) fn spread_ns(&self, cycle: u64) -> Option<Ns> {
        if self.count < CYCLES || self.cycle + 2 < cycle {
            return None;
        }
        Some(*self.delays_ns.iter().max()? - *self.delays_ns.iter().min()?)
    }
}

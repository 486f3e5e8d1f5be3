//! A PDO that follows SYNC: the time between the two shows how late SYNC is listed.
//!
//! Where the recording host sends SYNC, its echo may be listed late, and SYNCs that seem unsteady may be none. A PDO
//! of another node that comes in every cycle at the same distance shows that they are: it follows the SYNC on the bus.
//! It must not judge.

/// Cycles in a row that are looked back on.
const CYCLES: usize = 8;

/// The PDO that has come in every cycle of late.
#[derive(Debug, Default)]
pub(super) struct Follower {
    /// Its node and number.
    pdo: Option<(u8, u16)>,
    /// The last cycle in which it came.
    cycle: u64,
    /// How long after the SYNC it came in the last cycles, in ns, and in how many.
    delays_ns: [i64; CYCLES],
    count: usize,
}

impl Follower {
    /// A TPDO has come in a cycle, `delay_ns` after its SYNC.
    pub(super) fn follow(&mut self, pdo: (u8, u16), cycle: u64, delay_ns: i64) {
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

    /// How far apart the listings of the last SYNCs were put off at most, in ns; `None` where that is not known.
    pub(super) fn spread_ns(&self, cycle: u64) -> Option<i64> {
        if self.count < CYCLES || self.cycle + 2 < cycle {
            return None;
        }
        Some(self.delays_ns.iter().max()? - self.delays_ns.iter().min()?)
    }
}

//! Periodic traffic: SYNC, and each PDO with its position in the SYNC cycle.
//!
//! Times are measured between frames as they were captured. If the late echo of a SYNC is captured after its PDO, the
//! delay is negative and does not describe the node; it is only counted.

use std::collections::BTreeMap;

use crate::bytes::frame::{CanId, Frame};
use crate::bytes::ns::Ns;
use crate::evidence::period::Gaps;
use crate::evidence::period::spread::{Ranked, Spread};
use crate::world::event::Placement;

/// Maximum number of PDOs of a bus that are counted apart; further ones count only for their nodes.
const PDOS: usize = 1024;
/// 11-bit identifiers.
const IDS: usize = 2048;

/// The SYNC of a bus.
#[derive(Clone, Debug, Default)]
pub struct Sync {
    /// SYNCs.
    pub frames: u64,
    /// Times from one to the next, in ns.
    pub period: Ranked,
    /// SYNCs with a counter.
    pub counted: u64,
    /// Least and greatest counter.
    pub counters: (u8, u8),
    /// Counters that are neither the one before plus 1, nor 1.
    pub jumps: u64,
    gaps: Gaps,
    last_counter: Option<u8>,
}

impl Sync {
    /// Takes a SYNC.
    pub fn take(&mut self, counter: Option<u8>, t_ns: Option<Ns>) {
        self.frames += 1;
        if let Some(gap) = self.gaps.take(t_ns) {
            self.period.add(gap);
        }
        if let Some(counter) = counter {
            let (least, greatest) = if self.counted == 0 { (counter, counter) } else { self.counters };
            self.counters = (least.min(counter), greatest.max(counter));
            self.counted += 1;
            let follows = |before: u8| counter == 1 || before.checked_add(1) == Some(counter);
            self.jumps += u64::from(self.last_counter.is_some_and(|before| !follows(before)));
        }
        self.last_counter = counter;
    }

    /// Stops the measurement of times, since frames were lost.
    pub fn lost(&mut self) {
        self.gaps.interrupt();
        self.last_counter = None;
    }
}

/// A PDO of a node: the node, true for transmit (seen from the node), and its number.
pub type PdoKey = (u8, bool, u16);

/// One PDO.
#[derive(Clone, Debug)]
pub struct PdoTraffic {
    /// The PDO.
    pub key: PdoKey,
    /// Its last identifier.
    pub id: CanId,
    /// Frames.
    pub frames: u64,
    /// Times from one to the next, in ns.
    pub interval: Spread,
    /// Frames that belong to a SYNC cycle.
    pub synchronous: u64,
    /// Times since the SYNC, in ns.
    pub delay: Ranked,
    /// Frames that were captured before their SYNC.
    pub before_sync: u64,
    gaps: Gaps,
}

/// The PDOs of a bus.
#[derive(Clone, Debug)]
pub struct BusPdos {
    all: Vec<PdoTraffic>,
    places: BTreeMap<PdoKey, usize>,
    /// The index of the PDO that each 11-bit identifier last carried: the fast path of nearly every frame.
    by_id: Vec<u16>,
}

impl Default for BusPdos {
    fn default() -> Self {
        Self { all: Vec::new(), places: BTreeMap::new(), by_id: vec![u16::MAX; IDS] }
    }
}

impl BusPdos {
    /// Takes a frame of a PDO.
    pub fn take(&mut self, key: PdoKey, placement: Option<Placement>, frame: &Frame) {
        let Some(place) = self.place(key, frame.id) else { return };
        let Some(pdo) = self.all.get_mut(place) else { return };
        pdo.id = frame.id;
        pdo.frames += 1;
        if let Some(gap) = pdo.gaps.take(frame.t_ns) {
            pdo.interval.add(gap);
        }
        if let Some(placement) = placement {
            pdo.synchronous += 1;
            match placement.delay_ns {
                Some(delay) if delay >= Ns::ZERO => pdo.delay.add(delay),
                Some(_) => pdo.before_sync += 1,
                None => {}
            }
        }
    }

    fn place(&mut self, key: PdoKey, id: CanId) -> Option<usize> {
        let slot = if id.is_extended() { None } else { self.by_id.get_mut(id.raw() as usize) };
        if let Some(place) = slot.as_deref()
            && self.all.get(usize::from(*place)).is_some_and(|pdo| pdo.key == key)
        {
            return Some(usize::from(*place));
        }
        let place = match self.places.get(&key) {
            Some(place) => *place,
            None if self.all.len() < PDOS => {
                self.all.push(PdoTraffic {
                    key,
                    id,
                    frames: 0,
                    interval: Spread::default(),
                    synchronous: 0,
                    delay: Ranked::default(),
                    before_sync: 0,
                    gaps: Gaps::default(),
                });
                self.places.insert(key, self.all.len() - 1);
                self.all.len() - 1
            }
            None => return None,
        };
        if let Some(slot) = slot {
            *slot = place as u16;
        }
        Some(place)
    }

    /// Stops the measurement of times, since frames were lost.
    pub fn lost(&mut self) {
        for pdo in &mut self.all {
            pdo.gaps.interrupt();
        }
    }

    /// Returns all of them, by node, receive before transmit, and number.
    pub fn iter(&self) -> impl Iterator<Item = &PdoTraffic> {
        self.places.values().filter_map(|place| self.all.get(*place))
    }
}

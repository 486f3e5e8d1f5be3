//! Frames that the capture shows twice, as of two adapters on one bus: which they are, and whether that is proven.
//!
//! A frame is a duplicate where an equal one stood shortly before and no other was taken for its duplicate yet. Equal
//! frames come by themselves too (a SYNC without counter, a constant PDO), so proof comes from *isolated* frames only:
//! those that had no equal one on their CAN-ID for a while. Each of them stands twice in a capture that shows frames
//! twice, and once in any other. It must not know what a frame means.

use crate::frame::{Frame, Kind};

/// The longest that a duplicate follows its original, in ns.
pub(super) const APART_NS: i64 = 10_000_000;
/// The same in frames, where there are no stamps.
const APART_FRAMES: u64 = 8;
/// Nobody sends a frame again this soon, in ns.
const CLOSE_NS: i64 = 300_000;
/// A frame is isolated where no equal one came on its CAN-ID within this many ns or, without stamps, frames.
const ISOLATED_NS: i64 = 3 * APART_NS;
const ISOLATED_FRAMES: u64 = 3 * APART_FRAMES;
/// Isolated frames that must have stood twice, and three times as many as stood once, for a proof.
const PROOF: u32 = 4;
/// Isolated frames that stood once after which nobody looks any more.
const SETTLED: u32 = 256;
/// Frames that are kept to be compared.
const KEPT: usize = 64;
/// CAN-IDs of which the last frame is kept: all 11-bit ones.
const IDENTIFIERS: usize = 0x800;

/// Whether a frame stood in the capture before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sighting {
    /// It is a frame of its own.
    #[default]
    Original,
    /// An equal frame stood shortly before, and it is not known yet whether the capture shows frames twice.
    Suspect,
    /// The capture shows it a second time: it was on the bus once.
    Duplicate,
}

/// A frame that may be seen again.
#[derive(Clone, Copy, Debug)]
struct Seen {
    key: u64,
    t_ns: Option<i64>,
    count: u64,
    /// It had no equal one for a while before it.
    isolated: bool,
    /// It was seen again, or is that second sighting itself.
    paired: bool,
}

impl Seen {
    fn age_ns(&self, now: &Frame) -> Option<i64> {
        Some(now.t_ns?.saturating_sub(self.t_ns?))
    }

    /// Whether a frame follows faster than anybody sends.
    fn is_close(&self, now: &Frame) -> bool {
        self.age_ns(now).is_some_and(|age| age < CLOSE_NS)
    }
}

/// The last frame of a CAN-ID.
#[derive(Clone, Copy, Debug, Default)]
struct Last {
    key: u64,
    t_ns: i64,
    count: u64,
}

/// What is known of a bus.
#[derive(Debug, Default)]
pub struct Duplicates {
    recent: std::collections::VecDeque<Seen>,
    /// By CAN-ID; empty until the first frame.
    last: Vec<Last>,
    count: u64,
    /// Frames that stood twice, right behind each other.
    pairs: u64,
    /// The longest that a frame followed its original, in ns.
    apart_ns: i64,
    /// Isolated frames that stood twice, and once.
    twice: u32,
    once: u32,
    proven: bool,
}

impl Duplicates {
    /// Whether the capture is known to show its frames twice.
    pub fn are_proven(&self) -> bool {
        self.proven
    }

    /// Whether every frame so far, but for the last one, was followed by itself at once.
    pub fn are_all_so_far(&self) -> bool {
        self.pairs > 0 && self.count <= 2 * self.pairs + 1
    }

    /// Whether it is known to show them once.
    pub fn are_refuted(&self) -> bool {
        self.once >= PROOF && !self.proven
    }

    /// Takes the next frame.
    pub fn step(&mut self, frame: &Frame) -> Sighting {
        if self.once >= SETTLED && self.twice < self.once {
            return Sighting::Original;
        }
        self.count += 1;
        self.forget_old(frame);
        let key = key(frame);
        let original = self.pair(key, frame);
        let isolated = original.is_none() && self.is_isolated(key, frame);
        let seen = Seen { key, t_ns: frame.t_ns, count: self.count, isolated, paired: original.is_some() };
        if self.recent.len() == KEPT {
            self.recent.pop_front();
        }
        self.recent.push_back(seen);
        match original {
            None => Sighting::Original,
            Some(_) if self.proven => Sighting::Duplicate,
            // Every frame so far was followed by itself at once: at a capture's beginning that is as good as a proof.
            Some(original) if self.count == 2 * self.pairs && original.is_close(frame) => Sighting::Duplicate,
            Some(_) if self.are_refuted() => Sighting::Original,
            Some(_) => Sighting::Suspect,
        }
    }

    /// The frame that this one may be the duplicate of.
    fn pair(&mut self, key: u64, frame: &Frame) -> Option<Seen> {
        // Without stamps the order is all there is: until there is proof, only what follows itself counts.
        let (far, count) = (frame.t_ns.is_some() || self.proven, self.count);
        let fits = |seen: &&mut Seen| seen.key == key && !seen.paired && (far || seen.count + 1 == count);
        let seen = self.recent.iter_mut().find(fits)?;
        seen.paired = true;
        let original = *seen;
        let adjacent = original.count + 1 == self.count;
        self.pairs += u64::from(adjacent && (frame.t_ns.is_none() || original.is_close(frame)));
        if original.isolated {
            self.twice = self.twice.saturating_add(1);
            self.apart_ns = self.apart_ns.max(original.age_ns(frame).unwrap_or(0));
        }
        // Those that should have been seen again by now count as seen once.
        let overdue = |seen: &&Seen| {
            let late = seen.age_ns(frame).is_none_or(|age| age > self.apart_ns + self.apart_ns / 2);
            seen.isolated && !seen.paired && late
        };
        let once = self.once as usize + self.recent.iter().filter(overdue).count();
        self.proven = self.twice >= PROOF && self.twice as usize > 3 * once;
        Some(original)
    }

    /// Drops what is too old to be seen again, and counts what stood once.
    fn forget_old(&mut self, frame: &Frame) {
        while let Some(seen) = self.recent.front() {
            let old = match (frame.t_ns, seen.t_ns) {
                (Some(now), Some(then)) => !(0..=APART_NS).contains(&now.saturating_sub(then)),
                _ => self.count.saturating_sub(seen.count) > APART_FRAMES,
            };
            if !old {
                return;
            }
            self.once = self.once.saturating_add(u32::from(seen.isolated && !seen.paired));
            self.recent.pop_front();
        }
    }

    /// Whether no equal frame came on the CAN-ID for a while.
    fn is_isolated(&mut self, key: u64, frame: &Frame) -> bool {
        if self.last.is_empty() {
            self.last = vec![Last::default(); IDENTIFIERS];
        }
        let index = frame.id.raw() as usize;
        let Some(last) = self.last.get_mut(index).filter(|_| !frame.id.is_extended()) else { return false };
        let before = std::mem::replace(last, Last { key, t_ns: frame.t_ns.unwrap_or(0), count: self.count });
        before.count == 0
            || before.key != key
            || match frame.t_ns {
                Some(now) => now.saturating_sub(before.t_ns) > ISOLATED_NS,
                None => self.count.saturating_sub(before.count) > ISOLATED_FRAMES,
            }
    }
}

/// A frame's identifier, kind and payload in one number (FNV-1a).
fn key(frame: &Frame) -> u64 {
    let mix = |hash: u64, byte: u64| (hash ^ byte).wrapping_mul(0x0100_0000_01B3);
    let kind = match frame.kind {
        Kind::Data => 0,
        Kind::Remote => 1,
        Kind::Fd { .. } => 2,
        Kind::Error => 3,
    };
    let id = u64::from(frame.id.raw()) << 1 | u64::from(frame.id.is_extended());
    let head = mix(mix(mix(0xCBF2_9CE4_8422_2325, id), kind), u64::from(frame.len));
    frame.payload().chunks(8).fold(head, |hash, chunk| {
        let mut bytes = [0; 8];
        for (slot, byte) in bytes.iter_mut().zip(chunk) {
            *slot = *byte;
        }
        let word = u64::from_le_bytes(bytes);
        mix(mix(hash, word & 0xFFFF_FFFF), word >> 32)
    })
}

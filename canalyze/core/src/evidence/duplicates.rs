//! Frames that the capture shows twice, as of two adapters on one bus: which they are, and whether that is proven.
//!
//! Both adapters see the frames in the same order. So the second sightings follow the first ones in order, too: of the
//! frames that were seen once, the first that equals a new one is its original, and those before it will not be seen
//! again. Equal frames come by themselves as well (a SYNC without counter, a constant PDO, polled objects), so proof
//! comes from *isolated* frames only: those that had no equal one for a while. Each of them stands twice in a capture
//! that shows frames twice, and once in any other. It must not know what a frame means.

use std::collections::VecDeque;

use crate::frame::{Frame, Kind};

/// The longest that a duplicate follows its original, in ns.
const APART_NS: i64 = 10_000_000;
/// The same in frames, where there are no stamps.
const APART_FRAMES: u64 = 8;
/// Nobody sends a frame again this soon, in ns.
const CLOSE_NS: i64 = 300_000;
/// A frame is isolated where no equal one came within this many ns or, without stamps, frames.
const ISOLATED_NS: i64 = 3 * APART_NS;
const ISOLATED_FRAMES: u64 = 3 * APART_FRAMES;
/// Isolated frames that must have stood twice, and three times as many as stood once, for a proof.
const PROOF: u32 = 4;
/// Isolated frames that stood once after which nobody looks any more.
const SETTLED: u32 = 256;
/// Frames that are kept to be compared, and the most by which it must be known whether frames stand twice.
const KEPT: usize = 128;
/// Payloads of which it is kept when they came last, by a part of their key.
const PAYLOADS: usize = 4096;

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
}

impl Seen {
    fn age_ns(&self, now: &Frame) -> Option<i64> {
        Some(now.t_ns?.saturating_sub(self.t_ns?))
    }
}

/// When a frame came last.
#[derive(Clone, Copy, Debug, Default)]
struct Last {
    key: u64,
    t_ns: i64,
    count: u64,
}

/// What is known of a bus.
#[derive(Debug, Default)]
pub struct Duplicates {
    /// Frames that were seen once, oldest first.
    once_seen: VecDeque<Seen>,
    /// By a part of their key; empty until the first frame.
    last: Vec<Last>,
    count: u64,
    /// Frames that stood twice, right behind each other.
    pairs: u64,
    /// The longest that a frame followed its original, in ns.
    apart_ns: i64,
    /// Isolated frames that stood twice, and once.
    twice: u32,
    once: u32,
    /// The first frame that may be a duplicate, since nothing was decided: its number, count and time.
    suspect: Option<(u64, u64, Option<i64>)>,
    proven: bool,
}

impl Duplicates {
    /// Whether the capture is known to show its frames twice.
    pub fn are_proven(&self) -> bool {
        self.proven
    }

    /// Whether it is known to show them once.
    pub fn are_refuted(&self) -> bool {
        self.once >= PROOF && !self.proven
    }

    /// The number of the first frame of which it is not known yet whether it is a duplicate.
    pub fn undecided_since(&self) -> Option<u64> {
        self.suspect.map(|(number, ..)| number)
    }

    /// No further frame tells whether the capture shows frames twice. It does where every frame so far, but for the last
    /// one, was followed by itself at once.
    pub fn settle(&mut self) {
        if self.suspect.take().is_some() {
            self.proven |= self.pairs > 0 && self.count <= 2 * self.pairs + 1;
        }
    }

    /// It is `now_ns`, and no frame has come.
    pub fn advance(&mut self, now_ns: i64) {
        if self.suspect.is_some_and(|(_, _, t_ns)| t_ns.is_some_and(|t_ns| now_ns.saturating_sub(t_ns) > ISOLATED_NS)) {
            self.settle();
        }
    }

    /// Takes the next frame.
    pub fn step(&mut self, frame: &Frame) -> Sighting {
        if self.once >= SETTLED && self.twice < self.once {
            return Sighting::Original;
        }
        self.count += 1;
        self.forget_old(frame);
        let key = key(frame);
        let is_isolated = self.is_isolated(key, frame);
        let pair = self.pair(key, frame);
        if !pair {
            if self.once_seen.len() == KEPT {
                self.drop_first();
            }
            self.once_seen.push_back(Seen { key, t_ns: frame.t_ns, count: self.count, isolated: is_isolated });
        }
        self.judge(frame);
        let sighting = match pair {
            true if self.proven => Sighting::Duplicate,
            true if !self.are_refuted() => Sighting::Suspect,
            _ => Sighting::Original,
        };
        if sighting == Sighting::Suspect && self.suspect.is_none() {
            self.suspect = Some((frame.no, self.count, frame.t_ns));
        }
        if self.proven || self.are_refuted() {
            self.suspect = None;
        }
        if let Some((_, count, t_ns)) = self.suspect
            && (self.count - count >= KEPT as u64 || is_over(t_ns, frame))
        {
            self.settle();
        }
        sighting
    }

    /// Whether a frame is the second sighting of one before.
    fn pair(&mut self, key: u64, frame: &Frame) -> bool {
        // Without stamps the order is all there is: until there is proof, only what follows itself counts.
        let (far, count) = (frame.t_ns.is_some() || self.proven, self.count);
        let fits = |seen: &Seen| seen.key == key && (far || seen.count + 1 == count);
        let Some(place) = self.once_seen.iter().position(fits) else { return false };
        for _ in 0..place {
            self.drop_first();
        }
        let Some(original) = self.once_seen.pop_front() else { return false };
        let age_ns = original.age_ns(frame);
        let adjacent = original.count + 1 == self.count;
        self.pairs += u64::from(adjacent && age_ns.is_none_or(|age| age < CLOSE_NS));
        if original.isolated {
            self.twice = self.twice.saturating_add(1);
            self.apart_ns = self.apart_ns.max(age_ns.unwrap_or(0));
        }
        true
    }

    /// Whether there is proof by now. Those that should have been seen again count as seen once.
    fn judge(&mut self, frame: &Frame) {
        if self.twice < PROOF && self.once < PROOF {
            return;
        }
        let late = |seen: &Seen| seen.age_ns(frame).is_none_or(|age| age > self.apart_ns + self.apart_ns / 2);
        let overdue = self.once_seen.iter().filter(|seen| seen.isolated && late(seen)).count();
        self.proven = self.twice >= PROOF && self.twice as usize > 3 * (self.once as usize + overdue);
    }

    /// Drops what is too old to be seen again.
    fn forget_old(&mut self, frame: &Frame) {
        // Once it is known how far apart they are, what has not come by then does not come.
        let most_ns = if self.proven { (self.apart_ns * 2).clamp(CLOSE_NS, APART_NS) } else { APART_NS };
        while let Some(seen) = self.once_seen.front() {
            let old = match seen.age_ns(frame) {
                Some(age) => !(0..=most_ns).contains(&age),
                None => self.count.saturating_sub(seen.count) > APART_FRAMES,
            };
            if !old {
                return;
            }
            self.drop_first();
        }
    }

    /// The oldest frame was not seen again.
    fn drop_first(&mut self) {
        let seen = self.once_seen.pop_front();
        self.once = self.once.saturating_add(u32::from(seen.is_some_and(|seen| seen.isolated)));
    }

    /// Whether no equal frame came for a while.
    fn is_isolated(&mut self, key: u64, frame: &Frame) -> bool {
        if self.last.is_empty() {
            self.last = vec![Last::default(); PAYLOADS];
        }
        let Some(last) = self.last.get_mut(key as usize % PAYLOADS) else { return false };
        let before = std::mem::replace(last, Last { key, t_ns: frame.t_ns.unwrap_or(0), count: self.count });
        before.count == 0
            || before.key != key
            || match frame.t_ns {
                Some(now) => now.saturating_sub(before.t_ns) > ISOLATED_NS,
                None => self.count.saturating_sub(before.count) > ISOLATED_FRAMES,
            }
    }
}

/// Whether a doubt that began at a time is too old.
fn is_over(since_ns: Option<i64>, frame: &Frame) -> bool {
    since_ns.zip(frame.t_ns).is_some_and(|(since, now)| !(0..=ISOLATED_NS).contains(&now.saturating_sub(since)))
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

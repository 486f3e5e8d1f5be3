//! Frames that the capture shows twice, as of two adapters on one bus: which they are, and whether that is proven.
//!
//! Equal frames come by themselves as well (a SYNC without counter, a constant PDO, polled objects), so proof comes from
//! *isolated* frames only: those that had no equal one for a while. Each of them stands twice in a capture that shows
//! frames twice, and once in any other; and they tell how far apart the two stand. Once that is known, a frame is a
//! duplicate that equals one so long before it. Frames that came before the proof are looked through again by it. It
//! must not know what a frame means.

use std::collections::VecDeque;
use std::ops::RangeInclusive;

use crate::frame::{CanId, Frame, Kind};

/// The longest that a duplicate follows its original, in ns.
pub(super) const APART_NS: i64 = 10_000_000;
/// The same in frames, where there are no stamps.
const APART_FRAMES: u64 = 8;
/// Nobody sends a frame again this soon, in ns.
const CLOSE_NS: i64 = 300_000;
/// A frame is isolated where no equal one came within this many ns or, without stamps, frames.
const ISOLATED_NS: i64 = 3 * APART_NS;
const ISOLATED_FRAMES: u64 = 3 * APART_FRAMES;
/// Isolated frames that must have stood twice for a proof, and how many times as many as stood once: a block that is sent
/// again, or an object that is read again at once, is a row of equal frames as well.
const PROOF: u32 = 8;
const RATIO: usize = 8;
/// How many of them must be of other CAN-IDs than one, unless there are very many.
const OTHERS: usize = 2;
/// How many frames behind its original a duplicate stands where one sender is enough.
const NEAR: u64 = 3;
/// Isolated frames that stood once by which it is known that the capture shows frames once.
const REFUTED: u32 = 4;
/// Isolated frames that stood once after which nobody looks any more.
const SETTLED: u32 = 256;
/// The most frames by which it must be known whether they stand twice.
const KEPT: u64 = 320;
/// The most frames that are compared: more than a bus can carry in the time, and those that wait.
const MOST: usize = 512;
/// Distances that are kept.
const AGES: usize = 16;
/// Live, it must be known after this time, in ns.
pub(super) const PATIENCE_NS: i64 = 250_000_000;
/// Payloads of which it is kept when they came last, by a part of their key.
const PAYLOADS: usize = 4096;

/// Whether a frame stood in the capture before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sighting {
    /// It is a frame of its own.
    #[default]
    Original,
    /// An equal frame stood shortly before, in a capture that does not show enough to tell whether it shows frames twice.
    Suspect,
    /// The capture shows it a second time: it was on the bus once.
    Duplicate,
}

/// A frame that may be seen again.
#[derive(Clone, Copy, Debug)]
struct Seen {
    key: u64,
    id: CanId,
    number: u64,
    t_ns: Option<i64>,
    count: u64,
    /// It had no equal one for a while before it, and it is not known yet whether it stands twice.
    isolated: bool,
    /// An equal one has come.
    again: bool,
}

impl Seen {
    fn age_ns(&self, now: &Seen) -> Option<i64> {
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
    /// The last frames, oldest first; once there is proof, those of them that were not seen again.
    recent: VecDeque<Seen>,
    /// By a part of their key; empty until the first frame.
    last: Vec<Last>,
    count: u64,
    /// The resolution of the stamps, in ns.
    resolution_ns: i64,
    /// Frames that stood twice, right behind each other.
    pairs: u64,
    /// How long isolated frames were before their duplicates, in ns, their CAN-IDs, and when the duplicates came, in ns;
    /// latest last.
    apart_ns: VecDeque<(i64, CanId, i64)>,
    /// How many of the latest of them stood near their duplicates.
    following: usize,
    /// Isolated frames that stood twice, and once.
    twice: u32,
    once: u32,
    /// The first frame that may be a duplicate, since nothing was decided.
    suspect: Option<Seen>,
    proven: bool,
    /// Nobody waits any more until it is decided.
    given_up: bool,
    /// The numbers of the duplicates among the frames that had come by the proof.
    found: Vec<u64>,
}

impl Duplicates {
    /// Whether the capture is known to show its frames twice.
    pub fn are_proven(&self) -> bool {
        self.proven
    }

    /// Whether it is known to show them once.
    pub fn are_refuted(&self) -> bool {
        self.once >= REFUTED && !self.proven
    }

    /// The number of the first frame of which it is not known yet whether it is a duplicate.
    pub fn undecided_since(&self) -> Option<u64> {
        self.suspect.map(|suspect| suspect.number)
    }

    /// What a frame is that was observed as such, once that is decided.
    pub fn decided(&self, number: u64, observed: Sighting) -> Sighting {
        if self.found.binary_search(&number).is_ok() { Sighting::Duplicate } else { observed }
    }

    /// No further frame tells whether the capture shows frames twice. It does where every frame so far, but for the last
    /// one, was followed by itself at once.
    pub fn settle(&mut self) {
        if self.suspect.is_some() {
            let at_once = self.pairs > 0 && self.count <= 2 * self.pairs + 1;
            self.decide(self.proven || at_once);
            self.given_up = true;
        }
    }

    /// It is `now_ns` on a live bus: nobody waits long for what comes.
    pub fn advance(&mut self, now_ns: i64) {
        let since = self.suspect.and_then(|suspect| suspect.t_ns);
        if since.is_some_and(|since| now_ns.saturating_sub(since) > PATIENCE_NS) {
            self.settle();
        }
    }

    /// Takes the next frame. `squeezed`: it stands closer to the one before than it can be on a bus, so its time
    /// shows nothing. `resolution_ns`: the resolution of the stamps.
    #[inline]
    pub fn step(&mut self, frame: &Frame, squeezed: bool, resolution_ns: i64) -> Sighting {
        if self.once >= SETTLED && self.twice < self.once {
            self.suspect = None;
            return Sighting::Original;
        }
        self.resolution_ns = resolution_ns;
        self.compare(frame, squeezed)
    }

    fn compare(&mut self, frame: &Frame, squeezed: bool) -> Sighting {
        self.count += 1;
        let key = key(frame);
        let isolated = self.is_isolated(key, frame) && !squeezed;
        let now =
            Seen { key, id: frame.id, number: frame.no, t_ns: frame.t_ns, count: self.count, isolated, again: false };
        self.forget_old(&now);
        if self.proven {
            let sighting = if self.pair(&now) { Sighting::Duplicate } else { Sighting::Original };
            if sighting == Sighting::Original {
                self.recent.push_back(now);
            }
            return sighting;
        }
        let again = self.resembles(&now);
        if !again {
            self.unlearn(&now);
        }
        self.recent.push_back(Seen { isolated: isolated && !again, again, ..now });
        if again && !self.are_refuted() && !self.given_up {
            self.suspect.get_or_insert(now);
        }
        self.judge(&now);
        if self.suspect.is_some() && again { Sighting::Suspect } else { Sighting::Original }
    }

    /// Whether an equal frame stood shortly before, of which none was seen yet.
    fn resembles(&mut self, now: &Seen) -> bool {
        // Without stamps the order is all there is: only what follows itself counts.
        let near = |seen: &Seen| match seen.age_ns(now) {
            Some(age) => (0..=APART_NS).contains(&age),
            None => seen.count + 1 == now.count,
        };
        let equal = |seen: &&mut Seen| seen.key == now.key && !seen.again && near(seen);
        let Some(original) = self.recent.iter_mut().find(equal) else { return false };
        original.again = true;
        let original = *original;
        let at_once = original.age_ns(now).is_none_or(|age| age < CLOSE_NS);
        self.pairs += u64::from(original.count + 1 == now.count && at_once);
        self.learn(&original, now);
        true
    }

    /// Takes how long after its original a duplicate came.
    fn learn(&mut self, original: &Seen, now: &Seen) {
        if !original.isolated {
            return;
        }
        self.twice = self.twice.saturating_add(1);
        if self.apart_ns.len() == AGES {
            // Some of other CAN-IDs are kept: one sender may send a long row.
            let own = |(_, id, _): &(i64, CanId, i64)| *id == now.id;
            let many = self.apart_ns.iter().filter(|pair| own(pair)).count() + OTHERS >= AGES;
            let oldest = self.apart_ns.iter().position(|pair| !many || own(pair));
            self.apart_ns.remove(oldest.unwrap_or(0));
        }
        self.apart_ns.push_back((original.age_ns(now).unwrap_or(0), now.id, now.t_ns.unwrap_or(0)));
        self.following = if now.count - original.count <= NEAR { self.following + 1 } else { 0 };
    }

    /// A frame that is listed a third time is sent again and again: it does not show that the capture lists frames twice.
    fn unlearn(&mut self, now: &Seen) {
        let near = |seen: &Seen| match seen.age_ns(now) {
            Some(age) => (0..=2 * APART_NS).contains(&age),
            None => now.count - seen.count <= APART_FRAMES,
        };
        let paired = |seen: &&mut Seen| seen.key == now.key && seen.isolated && seen.again && near(seen);
        let Some(original) = self.recent.iter_mut().find(paired) else { return };
        original.isolated = false;
        self.twice = self.twice.saturating_sub(1);
        let began_ns = original.t_ns.unwrap_or(0);
        if let Some(place) = self.apart_ns.iter().rposition(|(age, id, at)| *id == now.id && at - age == began_ns) {
            self.apart_ns.remove(place);
        }
    }

    /// How long after its original a duplicate comes, in ns, with some room: what most of the isolated frames have shown
    /// alike. Some of them have an equal one for another reason. How many they are.
    fn usual_ns(&self) -> (RangeInclusive<i64>, usize) {
        let room = |age: i64| (age / 8).max(CLOSE_NS / 2);
        let around = |age: i64| age - room(age)..=age + room(age);
        let alike = |age: i64| self.apart_ns.iter().filter(move |(other, ..)| around(age).contains(other));
        let most_alike = self.apart_ns.iter().max_by_key(|(age, ..)| alike(*age).count());
        let Some((age, ..)) = most_alike.copied() else { return (0..=APART_NS, 0) };
        let (least, most) = alike(age).fold((age, age), |(least, most), (one, ..)| (least.min(*one), most.max(*one)));
        let count = alike(age).count();
        // One sender repeats itself for reasons of its own, and is confirmed as often: a sub-block of equal data looks like
        // the one before. That each of its frames stands near itself has no such reason.
        let following = count == AGES && self.following >= AGES;
        let others = |id: CanId| alike(age).filter(move |(_, other, _)| *other != id).count();
        let several = following || alike(age).all(|(_, id, _)| others(*id) >= OTHERS);
        let room = (2 * (most - least)).max(most / 32).max(CLOSE_NS / 6);
        ((least - room).max(0)..=(most + room).min(APART_NS), if several { count } else { 0 })
    }

    /// Whether a frame is the duplicate of one before, where it is known how far apart they are. Both sightings are in the
    /// same order: what stood before the original has been seen again, or is overdue and will not be.
    fn pair(&mut self, now: &Seen) -> bool {
        let (usual, _) = self.usual_ns();
        let in_time = |seen: &Seen| match seen.age_ns(now) {
            Some(age) => usual.contains(&age),
            None => now.count - seen.count <= APART_FRAMES,
        };
        let middle = usual.start().midpoint(*usual.end());
        let overdue = |seen: &Seen| seen.age_ns(now).is_none_or(|age| age.saturating_add(self.resolution_ns) >= middle);
        let Some(place) = self.recent.iter().position(|seen| seen.key == now.key && in_time(seen)) else {
            return false;
        };
        if !self.recent.iter().take(place).all(overdue) {
            return false;
        }
        let original = self.recent.drain(..=place).next_back();
        if let Some(original) = original {
            self.learn(&original, now);
        }
        true
    }

    /// Whether there is proof by now, or will be none.
    fn judge(&mut self, now: &Seen) {
        // Those that should have been seen again count as seen once.
        let (usual, alike) = self.usual_ns();
        let late = |seen: &&Seen| seen.isolated && !seen.again && seen.age_ns(now).is_none_or(|age| age > *usual.end());
        // What comes a third time, as sub-blocks of equal data do, shows nothing: that takes as long again.
        let over = |at: i64| now.t_ns.is_none_or(|now| now.saturating_sub(at) > *usual.end());
        let settled = self.apart_ns.iter().filter(|(age, _, at)| usual.contains(age) && over(*at)).count();
        if alike.min(settled) >= PROOF as usize {
            let once = self.once as usize + self.recent.iter().filter(late).count();
            if self.twice as usize > RATIO * once {
                return self.decide(true);
            }
        }
        if self.suspect.is_some_and(|suspect| now.count - suspect.count >= KEPT) {
            self.settle();
        } else if self.are_refuted() {
            self.decide(false);
        }
    }

    /// It is decided whether the capture shows its frames twice. Those that came before and were not taken are looked
    /// through again.
    fn decide(&mut self, proven: bool) {
        self.suspect = None;
        self.proven = proven;
        if !proven {
            return;
        }
        for mut seen in std::mem::take(&mut self.recent) {
            seen.isolated = false;
            if self.pair(&seen) {
                self.found.push(seen.number);
            } else {
                self.recent.push_back(seen);
            }
        }
    }

    /// Drops what is too old to be seen again, and counts what stood once. While frames wait to be decided they are kept.
    fn forget_old(&mut self, now: &Seen) {
        let old = |seen: &Seen| match seen.age_ns(now) {
            Some(age) => !(0..=APART_NS).contains(&age),
            None => now.count - seen.count > APART_FRAMES,
        };
        for seen in self.recent.iter_mut().filter(|seen| seen.isolated && !seen.again) {
            if old(seen) {
                seen.isolated = false;
                self.once = self.once.saturating_add(1);
            }
        }
        // A third one may come as long behind the second.
        let gone = |seen: &Seen| old(seen) && seen.age_ns(now).is_none_or(|age| !(0..=2 * APART_NS).contains(&age));
        while self.recent.len() > MOST || self.recent.front().is_some_and(|seen| self.suspect.is_none() && gone(seen)) {
            let seen = self.recent.pop_front();
            self.once = self.once.saturating_add(u32::from(seen.is_some_and(|seen| seen.isolated && !seen.again)));
        }
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

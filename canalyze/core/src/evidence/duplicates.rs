//! Frames that a capture shows twice, as with two adapters on one bus, and the proof for it.
//!
//! Equal frames are also sent on purpose (a SYNC without counter, a constant PDO, polled objects), so the proof rests
//! on *isolated* frames only: those without an equal one for a while. Each of them appears twice in a capture that
//! shows frames twice, and once in any other; they also show the distance of the two. Once this is known, a frame that
//! equals another at that distance is a duplicate. Frames before the proof are then examined again.
//!
//! Two adapters with clocks of their own are up to some ten milliseconds apart. There a client that repeats its requests
//! looks alike, so that such a distance is proven by frames of several services only.

use std::collections::VecDeque;
use std::ops::RangeInclusive;

use crate::bytes::frame::{CanId, Frame, Kind};
use crate::bytes::ns::Ns;

/// Maximum time from an original to its duplicate, in ns.
pub(super) const APART_NS: Ns = Ns::from_ms(10);
/// Maximum number of frames from an original to its duplicate, without stamps.
const APART_FRAMES: u64 = 8;
/// Minimum time in which a sender repeats a frame, in ns.
const CLOSE_NS: Ns = Ns::from_us(300);
/// Without stamps, a frame is isolated if no equal one came within this many frames.
const ISOLATED_FRAMES: u64 = 3 * APART_FRAMES;
/// Number of isolated frames seen twice that are a proof, and their minimum ratio to those seen once: a block or an
/// object that is sent again gives a row of equal frames, too.
const PROOF: usize = 8;
const RATIO: usize = 8;
/// Minimum number of them with other CAN-IDs, unless there are very many.
const OTHERS: usize = 2;
/// Maximum number of frames from original to duplicate for which one sender is a sufficient proof.
const NEAR: u64 = 3;
/// Number of isolated frames seen once that prove that the capture shows frames once.
const REFUTED: u32 = 4;
/// Number of isolated frames seen once after which the search ends.
const SETTLED: u32 = 256;
/// Maximum number of frames until the decision.
const KEPT: u64 = 320;
/// Maximum number of compared frames: more than a bus can carry in the time, and those that wait.
const MOST: usize = 512;
/// Maximum number of kept distances.
const AGES: usize = 16;
/// Maximum time until the decision on a live bus, in ns.
pub(super) const PATIENCE_NS: Ns = Ns::from_ms(250);
/// Number of slots for the last time of payloads, addressed by a part of their key.
const PAYLOADS: usize = 4096;

/// The distances at which duplicates are searched.
#[derive(Clone, Copy, Debug)]
struct Reach {
    /// The time from an original to its duplicate, in ns.
    apart_ns: (Ns, Ns),
    /// Minimum number of services that the isolated frames seen twice belong to.
    services: u32,
}

const NEARBY: Reach = Reach { apart_ns: (Ns::ZERO, APART_NS), services: 1 };
/// A client that repeats requests, and is answered twice, shows two services.
const FAR: Reach = Reach { apart_ns: (Ns(APART_NS.as_ns() + 1), Ns::from_ms(60)), services: 3 };

impl Reach {
    /// Returns true if a frame is this old and may be seen again now.
    fn contains(&self, age_ns: Ns) -> bool {
        (self.apart_ns.0..=self.apart_ns.1).contains(&age_ns)
    }

    /// Returns the time without an equal frame before an isolated one, in ns.
    fn isolated_ns(&self) -> Ns {
        3 * self.apart_ns.1
    }
}

/// The sighting of a frame in the capture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sighting {
    /// The first or only one.
    #[default]
    Original,
    /// A possible duplicate of an equal frame shortly before, in a capture without proof either way.
    Suspect,
    /// A second sighting of a frame that was on the bus once.
    Duplicate,
}

/// A frame that may be seen again.
#[derive(Clone, Copy, Debug)]
struct SeenFrame {
    key: u64,
    id: CanId,
    number: u64,
    t_ns: Option<Ns>,
    count: u64,
    /// True if no equal one came for a while before it, and it is still open whether it is seen twice.
    isolated: bool,
    /// True if an equal one has followed.
    again: bool,
}

impl SeenFrame {
    fn age_ns(&self, now: &SeenFrame) -> Option<Ns> {
        Some(now.t_ns? - self.t_ns?)
    }
}

/// The last sighting of a payload.
#[derive(Clone, Copy, Debug, Default)]
struct Last {
    key: u64,
    t_ns: Ns,
    count: u64,
}

/// The evidence about one bus.
#[derive(Debug)]
pub struct Duplicates {
    nearby: Copies,
    far: Copies,
}

impl Default for Duplicates {
    fn default() -> Self {
        Self { nearby: Copies::new(NEARBY), far: Copies::new(FAR) }
    }
}

impl Duplicates {
    /// Returns true if the capture is known to show its frames twice.
    pub fn are_proven(&self) -> bool {
        self.nearby.proven || self.far.proven
    }

    /// Returns true if the capture is known to show its frames once.
    pub fn are_refuted(&self) -> bool {
        self.nearby.are_refuted() && !self.far.proven
    }

    /// Returns true if every possible duplicate is decided.
    #[inline]
    pub fn is_decided(&self) -> bool {
        self.nearby.suspect.is_none() && self.far.suspect.is_none()
    }

    /// Returns the number of the first frame that may be a duplicate not decided yet.
    #[inline]
    pub fn undecided_since(&self) -> Option<u64> {
        let suspects = [self.nearby.suspect, self.far.suspect];
        suspects.into_iter().flatten().map(|suspect| suspect.number).min()
    }

    /// Returns the final sighting of a frame that was observed as `observed`.
    pub fn decided(&self, number: u64, observed: Sighting) -> Sighting {
        let found = |copies: &Copies| copies.found.binary_search(&number).is_ok();
        if found(&self.nearby) || found(&self.far) { Sighting::Duplicate } else { observed }
    }

    /// Decides without further frames. `over`: none will follow.
    pub fn settle(&mut self, over: bool) {
        self.nearby.settle(over);
        self.far.settle(over);
    }

    /// Advances a live bus to `now_ns`; the decision is awaited only for a short time.
    pub fn advance(&mut self, now_ns: Ns) {
        self.nearby.advance(now_ns);
        self.far.advance(now_ns);
    }

    /// Examines the next frame. `t_ns`: its time, `None` if the stamps show only the order. `squeezed`: it is closer to
    /// the previous one than possible on a bus, so its time is no evidence. `resolution_ns`: the resolution of the stamps.
    #[inline]
    pub fn step(&mut self, frame: &Frame, t_ns: Option<Ns>, squeezed: bool, resolution_ns: Ns) -> Sighting {
        let sighting = self.nearby.step(frame, t_ns, squeezed, resolution_ns);
        if self.far.are_ended() || self.nearby.proven || t_ns.is_none() {
            return sighting;
        }
        match self.far.step(frame, t_ns, squeezed, resolution_ns) {
            Sighting::Duplicate => Sighting::Duplicate,
            _ => sighting,
        }
    }

    /// Returns true if each further frame is an original, whatever it is.
    #[inline]
    pub fn are_settled(&self) -> bool {
        self.nearby.are_settled() && self.nearby.suspect.is_none() && self.far.are_ended()
    }
}

/// The evidence about one bus at the distances of one reach.
#[derive(Debug)]
struct Copies {
    reach: Reach,
    /// The last frames, oldest first; after the proof, only those not seen again.
    recent: VecDeque<SeenFrame>,
    /// Last sightings by a part of their key; empty until the first frame.
    last: Vec<Last>,
    count: u64,
    /// The resolution of the stamps, in ns.
    resolution_ns: Ns,
    /// Number of frames immediately followed by an equal one.
    pairs: u64,
    /// True if the decision could not be awaited, and every frame is immediately followed by an equal one so far: no
    /// proof, since a few frames may be equal by chance, but what holds until a frame is not.
    in_pairs: bool,
    /// Distance of isolated frames to their duplicates in ns, their CAN-IDs, and the times of the duplicates in ns;
    /// latest last.
    apart_ns: VecDeque<(Ns, CanId, Ns)>,
    /// Number of the latest of them that were near their duplicates.
    following: usize,
    /// Number of isolated frames seen twice, and once.
    twice: u32,
    once: u32,
    /// The first possible duplicate that is not decided.
    suspect: Option<SeenFrame>,
    proven: bool,
    /// True if the decision is no longer awaited.
    given_up: bool,
    /// The numbers of the duplicates among the frames before the proof.
    found: Vec<u64>,
}

impl Copies {
    fn new(reach: Reach) -> Self {
        Self {
            reach,
            recent: VecDeque::new(),
            last: Vec::new(),
            count: 0,
            resolution_ns: Ns::ZERO,
            pairs: 0,
            in_pairs: false,
            apart_ns: VecDeque::new(),
            following: 0,
            twice: 0,
            once: 0,
            suspect: None,
            proven: false,
            given_up: false,
            found: Vec::new(),
        }
    }

    /// Returns true if the capture is known to show its frames once.
    fn are_refuted(&self) -> bool {
        self.once >= REFUTED && !self.proven
    }

    /// Returns true if frames are no longer compared, since too many were seen once.
    #[inline]
    fn are_settled(&self) -> bool {
        self.once >= SETTLED && self.twice < self.once
    }

    /// Returns true if no proof is sought at this distance any more.
    #[inline]
    fn are_ended(&self) -> bool {
        !self.proven && self.suspect.is_none() && (self.are_refuted() || self.given_up)
    }

    /// Decides without further frames. The capture shows frames twice if every frame so far, except the last one, was
    /// immediately followed by an equal one. `over`: no further frames will follow; otherwise those that do may show that
    /// it was chance.
    fn settle(&mut self, over: bool) {
        if self.suspect.is_some() {
            let in_pairs = self.are_in_pairs();
            if in_pairs && !over {
                let mut open = None;
                for seen in &self.recent {
                    if open == Some(seen.key) {
                        self.found.push(seen.number);
                        open = None;
                    } else {
                        open = Some(seen.key);
                    }
                }
            }
            self.in_pairs = in_pairs && !over;
            self.decide(self.proven || in_pairs && over);
            self.given_up = true;
        }
        self.proven |= self.in_pairs && over;
    }

    /// Returns true if every frame so far, except the last one, was immediately followed by an equal one.
    fn are_in_pairs(&self) -> bool {
        self.pairs > 0 && self.count <= 2 * self.pairs + 1
    }

    /// Advances a live bus to `now_ns`.
    fn advance(&mut self, now_ns: Ns) {
        let since = self.suspect.and_then(|suspect| suspect.t_ns);
        if since.is_some_and(|since| now_ns - since > PATIENCE_NS) {
            self.settle(false);
        }
    }

    /// Examines the next frame.
    #[inline]
    fn step(&mut self, frame: &Frame, t_ns: Option<Ns>, squeezed: bool, resolution_ns: Ns) -> Sighting {
        if self.are_settled() {
            self.suspect = None;
            return Sighting::Original;
        }
        self.resolution_ns = resolution_ns;
        self.compare(frame, t_ns, squeezed)
    }

    fn compare(&mut self, frame: &Frame, t_ns: Option<Ns>, squeezed: bool) -> Sighting {
        self.count += 1;
        let key = key(frame);
        let isolated = self.is_isolated(key, t_ns) && !squeezed;
        let now = SeenFrame { key, id: frame.id, number: frame.no, t_ns, count: self.count, isolated, again: false };
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
        self.recent.push_back(SeenFrame { isolated: isolated && !again, again, ..now });
        if again && !self.are_refuted() && !self.given_up {
            self.suspect.get_or_insert(now);
        }
        self.judge(&now);
        self.in_pairs &= self.are_in_pairs();
        match again {
            true if self.in_pairs => Sighting::Duplicate,
            true if self.suspect.is_some() => Sighting::Suspect,
            _ => Sighting::Original,
        }
    }

    /// Returns true if an equal frame came shortly before and has no duplicate yet.
    fn resembles(&mut self, now: &SeenFrame) -> bool {
        // Without stamps there is only the order: an equal frame must follow immediately.
        let near = |seen: &SeenFrame| match seen.age_ns(now) {
            Some(age) => self.reach.contains(age),
            None => seen.count + 1 == now.count,
        };
        let equal = |seen: &&mut SeenFrame| seen.key == now.key && !seen.again && near(seen);
        let Some(original) = self.recent.iter_mut().find(equal) else { return false };
        original.again = true;
        let original = *original;
        let at_once = original.age_ns(now).is_none_or(|age| age < CLOSE_NS);
        self.pairs += u64::from(original.count + 1 == now.count && at_once);
        self.learn(&original, now);
        true
    }

    /// Learns the distance of a duplicate to its original.
    fn learn(&mut self, original: &SeenFrame, now: &SeenFrame) {
        if !original.isolated {
            return;
        }
        self.twice = self.twice.saturating_add(1);
        if self.apart_ns.len() == AGES {
            // Some of other CAN-IDs are kept, since one sender may send a long row.
            let own = |(_, id, _): &(Ns, CanId, Ns)| *id == now.id;
            let many = self.apart_ns.iter().filter(|pair| own(pair)).count() + OTHERS >= AGES;
            let oldest = self.apart_ns.iter().position(|pair| !many || own(pair));
            self.apart_ns.remove(oldest.unwrap_or(0));
        }
        self.apart_ns.push_back((original.age_ns(now).unwrap_or(Ns::ZERO), now.id, now.t_ns.unwrap_or(Ns::ZERO)));
        self.following = if now.count - original.count <= NEAR { self.following + 1 } else { 0 };
    }

    /// Withdraws the evidence of a frame that is listed a third time: it is sent repeatedly.
    fn unlearn(&mut self, now: &SeenFrame) {
        let near = |seen: &SeenFrame| match seen.age_ns(now) {
            Some(age) => (Ns::ZERO..=2 * self.reach.apart_ns.1).contains(&age),
            None => now.count - seen.count <= APART_FRAMES,
        };
        let paired = |seen: &&mut SeenFrame| seen.key == now.key && seen.isolated && seen.again && near(seen);
        let Some(original) = self.recent.iter_mut().find(paired) else { return };
        original.isolated = false;
        self.twice = self.twice.saturating_sub(1);
        let began_ns = original.t_ns.unwrap_or(Ns::ZERO);
        if let Some(place) = self.apart_ns.iter().rposition(|(age, id, at)| *id == now.id && *at - *age == began_ns) {
            self.apart_ns.remove(place);
        }
    }

    /// Returns the usual time from an original to its duplicate, in ns, with some tolerance, and the number of isolated
    /// frames that agree. Some isolated frames have an equal one for another reason.
    fn usual_ns(&self) -> (RangeInclusive<Ns>, usize) {
        let room = |age: Ns| (age / 8).max(CLOSE_NS / 2);
        let around = |age: Ns| age - room(age)..=age + room(age);
        let alike = |age: Ns| self.apart_ns.iter().filter(move |(other, ..)| around(age).contains(other));
        let most_alike = self.apart_ns.iter().max_by_key(|(age, ..)| alike(*age).count());
        let Some((age, ..)) = most_alike.copied() else { return (Ns::ZERO..=self.reach.apart_ns.1, 0) };
        let (least, most) = alike(age).fold((age, age), |(least, most), (one, ..)| (least.min(*one), most.max(*one)));
        let count = alike(age).count();
        // One sender repeats itself for its own reasons, and is confirmed as often: a sub-block of equal data looks
        // like the previous one. They do not explain that each of its frames is near its equal.
        let following = count == AGES && self.following >= AGES;
        let others = |id: CanId| alike(age).filter(move |(_, other, _)| *other != id).count();
        let services = alike(age).fold(0u16, |all, (_, id, _)| all | 1 << (id.raw() >> 7 & 0xF));
        let several = services.count_ones() >= self.reach.services;
        let several = several && (following || alike(age).all(|(_, id, _)| others(*id) >= OTHERS));
        let room = (2 * (most - least)).max(most / 32).max(CLOSE_NS / 6);
        ((least - room).max(Ns::ZERO)..=(most + room).min(self.reach.apart_ns.1), if several { count } else { 0 })
    }

    /// Returns true if a frame is the duplicate of an earlier one at the known distance. Both sightings have the same
    /// order: frames before the original have been seen again, or are overdue.
    fn pair(&mut self, now: &SeenFrame) -> bool {
        let (usual, _) = self.usual_ns();
        let in_time = |seen: &SeenFrame| match seen.age_ns(now) {
            Some(age) => usual.contains(&age),
            None => now.count - seen.count <= APART_FRAMES,
        };
        let middle = (*usual.start() + *usual.end()) / 2;
        let overdue = |seen: &SeenFrame| seen.age_ns(now).is_none_or(|age| age + self.resolution_ns >= middle);
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

    /// Decides if there is a proof by now, or will be none.
    fn judge(&mut self, now: &SeenFrame) {
        // Overdue ones count as seen once.
        let (usual, alike) = self.usual_ns();
        let late =
            |seen: &&SeenFrame| seen.isolated && !seen.again && seen.age_ns(now).is_none_or(|age| age > *usual.end());
        // A frame that comes a third time, like sub-blocks of equal data, is no evidence; that takes as long again.
        let over = |at: Ns| now.t_ns.is_none_or(|now| now - at > *usual.end());
        let settled = self.apart_ns.iter().filter(|(age, _, at)| usual.contains(age) && over(*at)).count();
        if alike.min(settled) >= PROOF {
            let once = self.once as usize + self.recent.iter().filter(late).count();
            if self.twice as usize > RATIO * once {
                return self.decide(true);
            }
        }
        if self.suspect.is_some_and(|suspect| now.count - suspect.count >= KEPT) {
            self.settle(false);
        } else if self.are_refuted() {
            self.decide(false);
        }
    }

    /// Decides whether the capture shows its frames twice, and examines earlier frames again that have not been taken.
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

    /// Removes frames too old to be seen again and counts those seen once. They are kept while frames wait for the
    /// decision.
    fn forget_old(&mut self, now: &SeenFrame) {
        let most_ns = self.reach.apart_ns.1;
        let old = |seen: &SeenFrame| match seen.age_ns(now) {
            Some(age) => !(Ns::ZERO..=most_ns).contains(&age),
            None => now.count - seen.count > APART_FRAMES,
        };
        for seen in self.recent.iter_mut().filter(|seen| seen.isolated && !seen.again) {
            if old(seen) {
                seen.isolated = false;
                self.once = self.once.saturating_add(1);
            }
        }
        // A third one may follow the second at the same distance.
        let gone =
            |seen: &SeenFrame| old(seen) && seen.age_ns(now).is_none_or(|age| !(Ns::ZERO..=2 * most_ns).contains(&age));
        while self.recent.len() > MOST || self.recent.front().is_some_and(|seen| self.suspect.is_none() && gone(seen)) {
            let seen = self.recent.pop_front();
            self.once = self.once.saturating_add(u32::from(seen.is_some_and(|seen| seen.isolated && !seen.again)));
        }
    }

    /// Returns true if no equal frame came for a while.
    fn is_isolated(&mut self, key: u64, t_ns: Option<Ns>) -> bool {
        if self.last.is_empty() {
            self.last = vec![Last::default(); PAYLOADS];
        }
        let isolated_ns = self.reach.isolated_ns();
        let Some(last) = self.last.get_mut(key as usize % PAYLOADS) else { return false };
        let before = std::mem::replace(last, Last { key, t_ns: t_ns.unwrap_or(Ns::ZERO), count: self.count });
        before.count == 0
            || before.key != key
            || match t_ns {
                Some(now) => now - before.t_ns > isolated_ns,
                None => self.count.saturating_sub(before.count) > ISOLATED_FRAMES,
            }
    }
}

/// Returns a hash of a frame's identifier, kind and payload (FNV-1a).
pub(super) fn key(frame: &Frame) -> u64 {
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

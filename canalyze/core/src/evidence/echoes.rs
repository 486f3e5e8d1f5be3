//! CAN-IDs whose frames a capture lists twice: those of the recording host, whose recorder lists what it hands to the
//! adapter and then its echo from the bus, while the frames of others come once.
//!
//! The proof for the whole bus ([`Duplicates`](super::duplicates::Duplicates)) fails there. It is found by CAN-ID: each
//! frame is followed by an equal one, sooner than anybody could have answered, and the distance is short beside the
//! rhythm of the sender. Several such CAN-IDs are one sender whose frames are listed twice. A CAN-ID that only a master
//! uses proves it by itself, after more frames. One that belongs to a node does so only if its copies come sooner than a
//! bus can carry a frame: two nodes may have it by mistake.
//! A request that is answered twice was sent twice. A recorder that fetches frames now and then lists them as close; there
//! senders have come again with other payloads, too.
//!
//! Most frames are alone and only noted here ([`Echoes::pass`]). Two senders whose frames happen to be close at first
//! drift apart, which tells them from an echo.

use std::collections::VecDeque;

use super::duplicates::{PATIENCE_NS, Sighting, key};
use super::senders::{IDENTIFIERS, REMOTE, comes_by_itself, identifier};
use super::stalls::wire_ns;
use crate::bytes::frame::{Frame, Kind};
use crate::bytes::ns::Ns;

/// Maximum time from a frame to its echo, in ns: servers and guarded nodes take longer to answer, and two producers of
/// SYNC are rarely closer.
const REACH_NS: Ns = Ns::from_us(450);
/// Minimum time between equal frames of a sender, as a multiple of the time to the echo, in tenths.
const RHYTHM_TENTHS: i64 = 15;
/// Minimum ratio of frames listed twice to those listed once.
const RATIO: u16 = 8;
/// Number of frames listed twice that are a proof, and the minimum number of those with other CAN-IDs.
const PROOF: u16 = 8;
const OTHERS: u16 = 2;
/// The same for one CAN-ID that only a master uses, or whose copies come sooner than a bus can carry them.
const ALONE: u16 = 16;
/// Minimum number of frames of other CAN-IDs that are listed once.
const ONCE: u32 = 4;
/// Minimum ratio of equal frames that come soon to others that come as soon.
const FETCHED: u32 = 4;
/// Number of frames listed twice after which a CAN-ID of a node belongs to the proven sender.
const OWN: u16 = 2;
/// Number of guarding requests listed twice from which their answers are counted.
const ASKED: u16 = 4;
/// Maximum counts, so that a change shows.
const MOST: u16 = 1_024;
/// Maximum number of frames that wait until it is decided whether one is an echo.
const KEPT: u64 = 4_096;

const NMT: usize = 0x000;
const SYNC: usize = 0x080;
const TIME: usize = 0x100;
const LSS: usize = 0x7E5;
const SDO_ANSWERS: std::ops::RangeInclusive<usize> = 0x581..=0x5FF;
const SDO_REQUESTS: std::ops::RangeInclusive<usize> = 0x601..=0x67F;

/// The frames of one CAN-ID.
#[derive(Clone, Copy, Debug)]
struct ListedFrames {
    /// The last frame: its time in ns, payload, and length and kind.
    t_ns: Ns,
    word: u64,
    form: u16,
    /// Number of frames listed once, the last one included, and twice.
    once: u16,
    twice: u16,
    /// Number of those listed twice sooner than a bus can carry a second one.
    sooner: u16,
    /// The time from the equal frame before it to the last frame, in ns.
    since_ns: Ns,
    /// True if each frame so far was listed twice, so that an equal one may be an echo.
    followed: bool,
    /// True if the decision is no longer awaited.
    given_up: bool,
}

impl ListedFrames {
    const NONE: Self = Self {
        t_ns: Ns::ZERO,
        word: 0,
        form: u16::MAX,
        once: 0,
        twice: 0,
        sooner: 0,
        since_ns: Ns::MAX,
        followed: false,
        given_up: false,
    };

    #[inline]
    fn equals(&self, word: u64, form: u16) -> bool {
        self.word == word && self.form == form
    }

    /// Returns the time since the last frame if it is equal, in ns.
    #[inline]
    fn since_equal(&self, (word, form): (u64, u16), now: Ns) -> Ns {
        if self.equals(word, form) { now - self.t_ns } else { Ns::MAX }
    }

    #[inline]
    fn note(&mut self, (word, form): (u64, u16), now: Ns) {
        self.since_ns = self.since_equal((word, form), now);
        (self.t_ns, self.word, self.form) = (now, word, form);
    }

    /// Returns true if the next frame comes as soon as an echo and equals the last one, or shows that its sender comes again
    /// so soon; or if the CAN-ID is followed.
    #[inline]
    fn concerns(&self, id: usize, (word, form): (u64, u16), now: Ns) -> bool {
        let soon = self.form != u16::MAX && (Ns::ZERO..=REACH_NS).contains(&(now - self.t_ns));
        self.followed || soon && (self.equals(word, form) || comes_by_itself(id))
    }

    /// Notes a frame that is listed once.
    #[inline]
    fn alone(&mut self, content: (u64, u16), now: Ns) {
        self.once = (self.once + 1).min(MOST);
        self.note(content, now);
    }

    /// Counts an equal frame behind another, by the time between them and that before the first one, in ns. `wire_ns`:
    /// the minimum time that it takes on a bus.
    fn pair(&mut self, apart_ns: Ns, since_ns: Ns, wire_ns: Ns) {
        if since_ns / RHYTHM_TENTHS > apart_ns / 10 {
            self.twice = (self.twice + 1).min(MOST);
            self.sooner = (self.sooner + u16::from(apart_ns < wire_ns)).min(MOST);
        } else {
            self.once = self.once.saturating_add(2).min(MOST);
        }
    }

    fn is_consistent(&self) -> bool {
        self.twice > RATIO.saturating_mul(self.once)
    }
}

/// A frame whose echo may follow.
#[derive(Clone, Copy, Debug)]
struct AwaitedEcho {
    id: usize,
    word: u64,
    form: u16,
    t_ns: Ns,
    since_ns: Ns,
}

/// A possible echo that is not decided.
#[derive(Clone, Copy, Debug)]
struct Undecided {
    id: usize,
    number: u64,
    t_ns: Ns,
}

/// The evidence about one bus.
#[derive(Debug, Default)]
pub(super) struct Echoes {
    /// By CAN-ID; empty until the first frame.
    listed: Vec<ListedFrames>,
    /// The CAN-IDs whose frames are followed one by one.
    followed: Vec<usize>,
    waiting: VecDeque<AwaitedEcho>,
    undecided: VecDeque<Undecided>,
    /// The numbers of the echoes among the frames that waited, in order.
    found: Vec<u64>,
    /// Time of the first frame, in ns: the frame before its echo may not be captured.
    began_ns: Option<Ns>,
    /// Number of frames that came soon after one of their CAN-ID that was equal, and of those after another one.
    pairs: u32,
    others: u32,
    proven: bool,
}

impl Echoes {
    /// Returns the number of the first frame that may be an echo not decided yet.
    #[inline]
    pub(super) fn undecided_since(&self) -> Option<u64> {
        self.undecided.front().map(|one| one.number)
    }

    /// Returns true if a frame that waited turned out to be an echo.
    pub(super) fn has_found(&self, number: u64) -> bool {
        self.found.binary_search(&number).is_ok()
    }

    /// Notes a frame by itself; returns false if it comes as soon as an echo, or if its CAN-ID is followed, and has to be
    /// compared.
    #[inline]
    pub(super) fn pass(&mut self, frame: &Frame, now: Ns) -> bool {
        let Some(id) = identifier(frame) else { return true };
        let Some(listed) = self.listed.get_mut(id) else { return true };
        let content = content(frame);
        let passes = !listed.concerns(id, content, now);
        if passes {
            listed.alone(content, now);
        }
        passes
    }

    /// Examines the next frame. `resolution_ns`: the resolution of the stamps; coarse ones show no echo.
    pub(super) fn step(&mut self, frame: &Frame, now: Ns, resolution_ns: Ns) -> Sighting {
        if self.listed.is_empty() {
            self.listed = vec![ListedFrames::NONE; IDENTIFIERS];
        }
        let began_ns = *self.began_ns.get_or_insert(now);
        let coarse = resolution_ns > REACH_NS;
        if !coarse && !self.pass(frame, now) {
            return self.compare(frame, now);
        }
        if let Some(listed) = identifier(frame).and_then(|id| self.listed.get_mut(id)) {
            if coarse {
                listed.alone(content(frame), now);
            }
            if (Ns::ZERO..=REACH_NS).contains(&(now - began_ns)) {
                listed.once = 0;
            }
        }
        Sighting::Original
    }

    fn compare(&mut self, frame: &Frame, now: Ns) -> Sighting {
        self.expire(now);
        if self.undecided.front().is_some_and(|one| frame.no > one.number + KEPT) {
            self.settle();
        }
        let Some(id) = identifier(frame) else { return Sighting::Original };
        let (word, form) = content(frame);
        let Some(listed) = self.listed.get_mut(id) else { return Sighting::Original };
        let soon = (Ns::ZERO..=REACH_NS).contains(&(now - listed.t_ns));
        if !listed.equals(word, form) && !listed.followed && soon && comes_by_itself(id) {
            self.others = self.others.saturating_add(1);
        }
        if !listed.followed && !listed.equals(word, form) {
            listed.alone((word, form), now);
            return Sighting::Original;
        }
        self.pairs = self.pairs.saturating_add(u32::from(listed.equals(word, form) && soon));
        if listed.followed {
            let equal = |one: &AwaitedEcho| one.id == id && (one.word, one.form) == (word, form);
            let original = self.waiting.iter().position(equal).and_then(|place| self.waiting.remove(place));
            let Some(AwaitedEcho { t_ns, since_ns, .. }) = original else {
                let since_ns = listed.since_equal((word, form), now);
                listed.note((word, form), now);
                self.waiting.push_back(AwaitedEcho { id, word, form, t_ns: now, since_ns });
                return Sighting::Original;
            };
            listed.pair(now - t_ns, since_ns, wire_ns(frame));
        } else {
            listed.once = listed.once.saturating_sub(1);
            listed.pair(now - listed.t_ns, listed.since_ns, wire_ns(frame));
        }
        listed.note((word, form), now);
        self.follow(id);
        self.decide(Undecided { id, number: frame.no, t_ns: now })
    }

    /// Follows a CAN-ID as long as its frames are listed twice.
    fn follow(&mut self, id: usize) {
        let Some(listed) = self.listed.get_mut(id) else { return };
        let before = listed.followed;
        listed.followed = listed.is_consistent();
        if listed.followed && !before {
            self.followed.push(id);
        } else if before && !listed.followed {
            self.followed.retain(|one| *one != id);
            self.waiting.retain(|one| one.id != id);
            self.undecided.retain(|one| one.id != id);
        }
    }

    /// Counts frames whose echo has not come as listed once.
    fn expire(&mut self, now: Ns) {
        while let Some(first) = self.waiting.front().copied() {
            let age_ns = now - first.t_ns;
            if (Ns::ZERO..=REACH_NS).contains(&age_ns) {
                return;
            }
            self.waiting.pop_front();
            if let Some(listed) = self.listed.get_mut(first.id).filter(|_| age_ns > REACH_NS) {
                listed.once = (listed.once + 1).min(MOST);
            }
            self.follow(first.id);
        }
    }

    /// Decides whether a frame is an echo, as far as it is known by now.
    fn decide(&mut self, one: Undecided) -> Sighting {
        self.prove();
        let Some(listed) = self.listed.get(one.id).filter(|listed| listed.followed && !self.are_fetched()) else {
            return Sighting::Original;
        };
        if self.proven && self.belongs(one.id) {
            self.resolve();
            return Sighting::Duplicate;
        }
        if listed.given_up || self.is_answered_twice(one.id) {
            self.acquit();
            return Sighting::Original;
        }
        self.undecided.push_back(one);
        Sighting::Suspect
    }

    /// Decides without further frames.
    pub(super) fn settle(&mut self) {
        for one in std::mem::take(&mut self.undecided) {
            let known = self.proven && !self.are_fetched() && !self.is_answered_twice(one.id);
            if known {
                self.found.push(one.number);
            } else if let Some(listed) = self.listed.get_mut(one.id) {
                listed.given_up = true;
            }
        }
        self.found.sort_unstable();
    }

    /// Advances a live bus to `now_ns`; the decision is awaited only for a short time.
    pub(super) fn advance(&mut self, now_ns: Ns) {
        if self.undecided.front().is_some_and(|one| now_ns - one.t_ns > PATIENCE_NS) {
            self.settle();
        }
    }

    /// Looks for the proof among the CAN-IDs that are listed twice.
    fn prove(&mut self) {
        if self.proven || self.are_fetched() {
            return;
        }
        let counts = |id: &usize| {
            let listed = self.listed.get(*id).filter(|_| !self.is_answered_twice(*id))?;
            Some((listed.twice, is_of_master(*id) || listed.sooner >= OTHERS))
        };
        let (mut all, mut most, mut alone) = (0_u16, 0, 0);
        for (twice, shows) in self.followed.iter().filter_map(counts) {
            all = all.saturating_add(twice);
            most = most.max(twice);
            alone = if shows { alone.max(twice) } else { alone };
        }
        self.proven = (all >= PROOF && all - most >= OTHERS || alone >= ALONE) && self.others_come_once();
    }

    /// Decides the frames that wait and were sent twice, as their answers show.
    fn acquit(&mut self) {
        let mut undecided = std::mem::take(&mut self.undecided);
        undecided.retain(|one| !self.is_answered_twice(one.id));
        self.undecided = undecided;
    }

    /// Returns true if frames of other CAN-IDs are listed once, so that it is not the whole bus that is listed twice.
    fn others_come_once(&self) -> bool {
        let others = self.listed.iter().filter(|listed| !listed.followed);
        others.map(|listed| u32::from(listed.once)).sum::<u32>() >= ONCE
    }

    /// Returns true if the recorder fetches frames now and then, and lists those of some time together.
    fn are_fetched(&self) -> bool {
        self.others > self.pairs / FETCHED
    }

    /// Returns true if a CAN-ID belongs to the sender whose frames are listed twice.
    fn belongs(&self, id: usize) -> bool {
        let own = if is_of_master(id) { 1 } else { OWN };
        self.listed.get(id).is_some_and(|listed| listed.followed && listed.twice >= own) && !self.is_answered_twice(id)
    }

    /// Decides the frames that wait and belong to the sender.
    fn resolve(&mut self) {
        if self.undecided.is_empty() {
            return;
        }
        for one in std::mem::take(&mut self.undecided) {
            if self.belongs(one.id) {
                self.found.push(one.number);
            } else {
                self.undecided.push_back(one);
            }
        }
        self.found.sort_unstable();
        let old = self.found.len().saturating_sub(KEPT as usize);
        self.found.drain(..old);
    }

    /// Returns true if the requests of a CAN-ID, or SYNC, have as many answers as they are listed, so that each was sent;
    /// for the answers the same.
    fn is_answered_twice(&self, id: usize) -> bool {
        let followed = |id: usize| self.listed.get(id).is_some_and(|listed| listed.followed);
        if SDO_REQUESTS.contains(&id) {
            return followed(id - 0x80);
        }
        if SDO_ANSWERS.contains(&id) {
            return followed(id + 0x80);
        }
        if id == SYNC {
            return self.followed.iter().any(|id| is_tpdo(*id));
        }
        if is_tpdo(id) {
            return followed(SYNC);
        }
        let Some((asked, answers)) = id.checked_sub(REMOTE).and_then(|data| {
            let (asked, answers) = (self.listed.get(id)?, self.listed.get(data)?);
            Some((asked.twice, answers.once.saturating_add(2 * answers.twice)))
        }) else {
            return false;
        };
        asked >= ASKED && answers / 3 > asked / 2
    }
}

/// Returns true if a node sends a PDO with a CAN-ID, which may answer SYNC, by the pre-defined connection set.
fn is_tpdo(id: usize) -> bool {
    matches!(id & !0x7F, 0x180 | 0x280 | 0x380 | 0x480) && id & 0x7F != 0
}

/// Returns true if only a master sends a CAN-ID; a network has one.
fn is_of_master(id: usize) -> bool {
    let to_node = |group: usize| id & 0x7F != 0 && id & !0x7F == group;
    matches!(id, NMT | SYNC | TIME | LSS)
        || id >= REMOTE
        || SDO_REQUESTS.contains(&id)
        || [0x200, 0x300, 0x400, 0x500].into_iter().any(to_node)
}

/// Returns the payload of a frame, or a hash of a longer one, and its length and kind.
#[inline]
fn content(frame: &Frame) -> (u64, u16) {
    let kind = match frame.kind {
        Kind::Data => 0,
        Kind::Remote => 1,
        Kind::Fd { .. } => 2,
        Kind::Error => 3,
    };
    let word = match frame.data.first_chunk() {
        Some(bytes) if frame.len <= 8 => u64::from_le_bytes(*bytes),
        _ => key(frame),
    };
    (word, u16::from(frame.len) << 2 | kind)
}

//! Lanes of SDO channels: each transfer from its first frame to its last.
//!
//! A transfer of one frame, an unanswered request, lasts until the next frame after it was reported, or to
//! the end: without a length it could not be seen.
//! A transfer is reported at its end, so its rows come behind those of other lanes. Must not: follow the protocol.

use std::collections::hash_map::DefaultHasher;
use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::fmt::Write;
use std::hash::{Hash, Hasher};

use super::rows::{At, DISTINCT, MANY, Pen};
use crate::bytes::frame::{BusId, CanId, Frame};
use crate::sdo::transfer::{Transfer, TransferId};
use crate::sdo::wire::Side;
use crate::tables::columns::cycle_numbers::CycleNumbers;
use crate::words::lane;

/// Most channels that have lanes; further ones have none.
const LANES: usize = 4096;
/// Most lanes of one server whose transfers run at once; further ones share the last.
const AT_ONCE: u8 = 8;
/// Most transfers whose server's identifier is remembered.
const RUNNING: usize = 4096;

/// A channel: the bus, the server, the identifier where it is not the server's default one, and the number of lanes
/// before it where transfers of USDO run at once.
type Key = (BusId, u8, Option<CanId>, u8);

/// A channel's lane.
#[derive(Debug, Default)]
struct Lane {
    name: String,
    /// The number of its last frame.
    last: u64,
    /// The end of its last transfer, until it is written.
    end: Option<At>,
    /// The only frame of its last transfer, until the bus has another one.
    single: Option<u64>,
    /// Hashes of what it has shown, with values and, when those are too many, without.
    distinct: [HashSet<u64>; 2],
}

/// The channels of all buses.
#[derive(Debug, Default)]
pub(super) struct Channels {
    /// The identifier that the server of a transfer under way sends on, where it is not the default one.
    servers: BTreeMap<TransferId, CanId>,
    lanes: BTreeMap<Key, Lane>,
    /// Lanes with a transfer of a single frame that goes on.
    singles: BTreeSet<Key>,
}

impl Channels {
    /// A frame of a transfer.
    pub(super) fn step(&mut self, id: Option<TransferId>, side: Side, node: u8, frame: &Frame) {
        if side == Side::Client || frame.id == CanId::standard(0x580 + u16::from(node)) {
            return;
        }
        let Some(id) = id else { return };
        if self.servers.len() >= RUNNING {
            self.servers.clear();
        }
        self.servers.insert(id, frame.id);
    }

    /// A bus has a frame: transfers of a single one before it are over.
    #[inline]
    pub(super) fn frame(&mut self, bus: BusId, at: At) {
        if !self.singles.is_empty() {
            self.end_singles(bus, at);
        }
    }

    fn end_singles(&mut self, bus: BusId, at: At) {
        let Self { singles, lanes, .. } = self;
        singles.retain(|key| {
            let Some(lane) = lanes.get_mut(key).filter(|lane| key.0 == bus && lane.single < Some(at.frame)) else {
                return true;
            };
            (lane.single, lane.end) = (None, Some(at));
            false
        });
    }

    /// The lane of a transfer: the first that is free from its begin on.
    fn lane_of(&self, transfer: &Transfer) -> Key {
        let lane = |beside| (transfer.bus, transfer.node, transfer.channel, beside);
        if transfer.session.is_none() {
            return lane(0);
        }
        let is_free = |beside: &u8| self.lanes.get(&lane(*beside)).is_none_or(|lane| lane.last <= transfer.first.no);
        lane((0..AT_ONCE).find(is_free).unwrap_or(AT_ONCE - 1))
    }

    /// A transfer has ended.
    pub(super) fn take(&mut self, pen: &mut Pen<'_>, prefix: &str, cycles: &CycleNumbers, transfer: &Transfer) {
        let key = self.lane_of(transfer);
        let server = self.servers.remove(&transfer.id);
        if self.lanes.len() >= LANES && !self.lanes.contains_key(&key) {
            return;
        }
        let lane = self.lanes.entry(key).or_default();
        if lane.name.is_empty() {
            lane.name = name(prefix, key, server);
        }
        let begin = At::of(transfer.first, transfer.bus, cycles);
        lane.last = transfer.last.no;
        // Where the next one begins right there, the lane is never idle.
        if let Some(end) = lane.end.take().filter(|end| end.frame < begin.frame) {
            pen.end(&lane.name, end);
        }
        let class = Some(transfer.outcome.status.name());
        let valued = [true, false].into_iter().zip(&mut lane.distinct).find_map(|(valued, known)| {
            let mut text = Vec::new();
            lane::transfer(&mut text, pen.lang, transfer, valued);
            is_told(known, &text).then_some(text)
        });
        match valued {
            Some(text) => pen.row(&lane.name, begin, Some(&String::from_utf8_lossy(&text)), class),
            None => pen.row(&lane.name, begin, Some(MANY), class),
        }
        if transfer.last.no > transfer.first.no {
            lane.end = Some(At::of(transfer.last, transfer.bus, cycles));
            lane.single = None;
            self.singles.remove(&key);
        } else {
            lane.single = Some(transfer.first.no);
            self.singles.insert(key);
        }
    }

    /// Writes what is held back.
    pub(super) fn flush(&mut self, pen: &mut Pen<'_>) {
        for lane in self.lanes.values_mut() {
            if let Some(at) = lane.end.take() {
                pen.end(&lane.name, at);
            }
        }
    }
}

/// Returns true if a text is one of the first [`DISTINCT`].
fn is_told(known: &mut HashSet<u64>, text: &[u8]) -> bool {
    let mut hasher = DefaultHasher::new();
    text.hash(&mut hasher);
    let hash = hasher.finish();
    known.contains(&hash) || known.len() < DISTINCT && known.insert(hash)
}

/// The name of a channel's lane; one that is not the default channel has its identifiers, client to server first.
fn name(prefix: &str, (_, node, channel, beside): Key, server: Option<CanId>) -> String {
    let mut name = format!("sdo/{prefix}node{node}");
    if beside > 0 {
        // Writing to a string cannot fail.
        let _ = write!(name, "/{}", u16::from(beside) + 1);
    }
    if let Some(client) = channel {
        // Writing to a string cannot fail.
        let _ = write!(name, "/{client:?}");
        if let Some(server) = server {
            let _ = write!(name, "-{server:?}");
        }
    }
    name
}

//! What the lanes of SDO channels show: a transfer from its first frame to its last, and nothing between two.
//!
//! A transfer is told when it has ended, so its rows come behind those of other lanes. Must not: follow the protocol.

use std::collections::hash_map::DefaultHasher;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::fmt::Write;
use std::hash::{Hash, Hasher};

use super::rows::{At, Pen};
use crate::frame::{BusId, CanId, Frame, FrameRef};
use crate::services::sdo::transfer::{Transfer, TransferId};
use crate::services::sdo::wire::Side;
use crate::text::{Lang, lane};

/// Most channels that have lanes; further ones have none.
const LANES: usize = 4096;
/// Most transfers whose first frames are remembered.
const RUNNING: usize = 4096;
/// Distinct texts of a lane with values, then without, before it shows [`MANY`].
const DISTINCT: usize = 512;
/// What stands for further texts.
const MANY: &str = "…";

/// A channel: the bus, the server, and the identifier where it is not the server's default one.
type Key = (BusId, u8, Option<CanId>);

/// A transfer under way.
#[derive(Clone, Copy, Debug)]
struct Running {
    /// The SYNC cycles of its first and its last frame.
    first: u64,
    last: u64,
    /// The identifier that the server sends on.
    server: Option<CanId>,
}

/// A transfer that has ended.
#[derive(Debug)]
struct Ended {
    key: Key,
    id: TransferId,
    first: FrameRef,
    last: FrameRef,
    class: &'static str,
    /// With its value, and without.
    texts: [Vec<u8>; 2],
}

/// A channel's lane.
#[derive(Debug, Default)]
struct Lane {
    /// Its name, once it has had a transfer.
    name: String,
    /// Where its last transfer has ended, until that is written.
    end: Option<At>,
    /// What it has shown.
    distinct: [HashSet<u64>; 2],
}

/// The channels of all buses.
#[derive(Debug, Default)]
pub(super) struct Channels {
    running: HashMap<TransferId, Running>,
    lanes: BTreeMap<Key, Lane>,
    ended: Vec<Ended>,
}

impl Channels {
    /// A frame of a transfer.
    pub(super) fn step(&mut self, id: Option<TransferId>, side: Side, frame: &Frame, cycle: u64) {
        let Some(id) = id else { return };
        if self.running.len() >= RUNNING {
            self.running.clear();
        }
        let running = self.running.entry(id).or_insert(Running { first: cycle, last: cycle, server: None });
        running.last = cycle;
        if side == Side::Server {
            running.server = Some(frame.id);
        }
    }

    /// A transfer has ended; it is written when its last frame is known.
    pub(super) fn take(&mut self, lang: Lang, transfer: &Transfer) {
        let key = (transfer.bus, transfer.node, transfer.channel);
        let texts = [true, false].map(|valued| {
            let mut text = Vec::new();
            lane::transfer(&mut text, lang, transfer, valued);
            text
        });
        let (id, first, last, class) = (transfer.id, transfer.first, transfer.last, transfer.status.name());
        self.ended.push(Ended { key, id, first, last, class, texts });
    }

    /// Writes the transfers that have ended. `cycle` runs now; `prefix` gives the names of buses.
    #[inline]
    pub(super) fn settle(&mut self, pen: &mut Pen<'_>, cycle: u64, prefix: impl Fn(BusId) -> String) {
        if !self.ended.is_empty() {
            self.write(pen, cycle, prefix);
        }
    }

    fn write(&mut self, pen: &mut Pen<'_>, cycle: u64, prefix: impl Fn(BusId) -> String) {
        for ended in std::mem::take(&mut self.ended) {
            let Ended { key, id, first, last, class, texts } = ended;
            let running = self.running.remove(&id);
            if self.lanes.len() >= LANES && !self.lanes.contains_key(&key) {
                continue;
            }
            let lane = self.lanes.entry(key).or_default();
            if lane.name.is_empty() {
                lane.name = name(&prefix(key.0), key, running.and_then(|running| running.server));
            }
            let (begin, end) = running.map_or((cycle, cycle), |running| (running.first, running.last));
            let begin = At::earlier(first, begin);
            // Where the next one begins right there, the lane is never idle.
            if let Some(at) = lane.end.take().filter(|at| at.frame < begin.frame) {
                pen.end(&lane.name, at);
            }
            let text = lane.choose(&texts);
            pen.row(&lane.name, begin, Some(&text), Some(class));
            lane.end = Some(At::earlier(last, end));
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

impl Lane {
    /// The text of a transfer, by how many others there are already.
    fn choose(&mut self, texts: &[Vec<u8>; 2]) -> String {
        for (text, known) in texts.iter().zip(&mut self.distinct) {
            let mut hasher = DefaultHasher::new();
            text.hash(&mut hasher);
            let hash = hasher.finish();
            if known.contains(&hash) || known.len() < DISTINCT {
                known.insert(hash);
                return String::from_utf8_lossy(text).into_owned();
            }
        }
        MANY.to_owned()
    }
}

/// The name of a channel's lane; one that is not the default channel has its identifiers, client to server first.
fn name(prefix: &str, (_, node, channel): Key, server: Option<CanId>) -> String {
    let mut name = format!("sdo/{prefix}node{node}");
    if let Some(client) = channel {
        // Writing to a string cannot fail.
        let _ = write!(name, "/{client:?}");
        if let Some(server) = server {
            let _ = write!(name, "-{server:?}");
        }
    }
    name
}

//! Lanes of signals that are no quantities: truth values, choices, bit fields and their bits.
//!
//! PDOs whose lanes do not change cost a comparison of the payload under a mask. Must not: decide what a mapping is.

use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;

use super::rows::{At, DISTINCT, MANY, Pen, part};
use crate::bytes::frame::{BusId, Frame};
use crate::tables::selection::{Chosen, Selection, Whose};
use crate::wire::pdo::mapping::{Mapped, Mapping};
use crate::words::profiles::Profile;
use crate::words::signal;
use crate::world::drive;
use crate::world::event::{ProcessData, Signals};
use crate::world::od::{self, DataType};

/// Most PDOs that have lanes, and most lanes of all of them but those of bits; further ones have none.
const PDOS: usize = 4096;
const LANES: usize = 4096;
/// Characters of a signal's name that its lane shows: it is a title.
const LONGEST: usize = 64;

/// A signal of a PDO.
#[derive(Debug)]
struct Signal {
    place: usize,
    lane: String,
    /// BOOLEAN, or one bit.
    is_truth: bool,
    /// A drive's statusword.
    is_statusword: bool,
    /// Its bits have lanes of their own.
    has_bits: bool,
    /// The value in its lane; `None` after its end.
    raw: Option<u64>,
    /// The first value since then.
    first: (u64, At),
    /// The bits that have lanes.
    started: u64,
    distinct: HashSet<u64>,
    /// Its lane shows [`MANY`].
    many: bool,
}

impl Signal {
    fn new(one: &Chosen, mapped: &Mapped, lane: String) -> Self {
        Self {
            place: one.place,
            lane,
            is_truth: mapped.bits == 1 || mapped.data_type == Some(DataType::Boolean),
            is_statusword: mapped.is_statusword(),
            has_bits: mapped.factor == 1.0 && has_bits(mapped),
            raw: None,
            first: (0, At::default()),
            started: 0,
            distinct: HashSet::new(),
            many: false,
        }
    }

    fn show(&mut self, pen: &mut Pen<'_>, mapping: &Mapping, raw: u64, at: At) {
        let before = self.raw.replace(raw);
        if before == Some(raw) {
            return;
        }
        if self.distinct.len() < DISTINCT {
            self.distinct.insert(raw);
        }
        let class = match (self.is_truth, self.is_statusword) {
            (true, _) => truth(raw),
            (_, true) => drive::DriveState::of(raw as u16).map(drive::DriveState::name),
            _ => None,
        };
        if self.distinct.contains(&raw) && !self.many {
            pen.says(&self.lane, at, class, |out, lang| signal::value_at(out, lang, mapping, self.place, raw));
        } else if !std::mem::replace(&mut self.many, true) || before.is_none() {
            pen.row(&self.lane, at, Some(MANY), None);
        }
        if self.has_bits {
            self.bits(pen, before, raw, at);
        }
    }

    /// A bit has a lane from its first change on.
    fn bits(&mut self, pen: &mut Pen<'_>, before: Option<u64>, raw: u64, at: At) {
        let changed = match before {
            Some(before) => before ^ raw,
            None => {
                self.first = (raw, at);
                self.started
            }
        };
        for number in (0..64).filter(|number| changed >> number & 1 != 0) {
            let lane = format!("{}.{number}", self.lane);
            let mut row = |raw: u64, at| {
                let bit = truth(raw >> number & 1);
                pen.row(&lane, at, bit, bit);
            };
            if self.started >> number & 1 == 0 {
                self.started |= 1 << number;
                row(self.first.0, self.first.1);
            }
            row(raw, at);
        }
    }

    fn end(&mut self, pen: &mut Pen<'_>, at: At) {
        if self.raw.take().is_none() {
            return;
        }
        pen.end(&self.lane, at);
        for number in (0..64).filter(|number| self.started >> number & 1 != 0) {
            pen.end(&format!("{}.{number}", self.lane), at);
        }
    }
}

fn truth(raw: u64) -> Option<&'static str> {
    match raw {
        0 => Some("0"),
        1 => Some("1"),
        _ => None,
    }
}

/// Returns true if an object of CiA 401 holds digital inputs or outputs themselves, 8, 16 or 32 at once.
fn is_line(index: u16) -> bool {
    matches!(index, 0x6000 | 0x6100 | 0x6120 | 0x6200 | 0x6300 | 0x6320)
}

/// Returns true if single bits of a value have a meaning; those of error codes, COB-IDs and identities have none.
fn has_bits(mapped: &Mapped) -> bool {
    match mapped.index {
        0x1001 | 0x1002 => true,
        0x6000..=0x9FFF => {
            let drives = matches!(od::first_axis(mapped.index), 0x6040 | 0x6041 | 0x60FD | 0x60FE);
            match mapped.profile {
                Profile::IO => mapped.is_of_profile() && is_line(mapped.index),
                _ => drives && mapped.is_drives(),
            }
        }
        _ => false,
    }
}

/// One PDO.
#[derive(Debug)]
pub(super) struct Carrier {
    mapping: Arc<Mapping>,
    /// The name of what is plotted of it; empty where nothing is.
    plot: String,
    /// It is known whose mapping it is, and no frames were lost since.
    is_trusted: bool,
    signals: Vec<Signal>,
    /// It is a TPDO that shows states of drives.
    is_reporting: bool,
    /// The bits of a payload of up to eight bytes that lanes show.
    mask: u64,
    /// Lanes show bits beyond these.
    is_long: bool,
    /// The payload that lanes show, and its length; `None` where they have ended.
    last: Option<(u64, usize)>,
}

impl Carrier {
    fn new(mapping: &Arc<Mapping>, plot: String, transmit: bool, signals: Vec<Signal>) -> Self {
        let is_reporting = transmit && !mapping.statuswords.is_empty();
        let (mut mask, mut is_long) = (0, false);
        for (place, mapped) in mapping.entries.iter().enumerate() {
            if signals.iter().any(|one: &Signal| one.place == place) {
                let (offset, bits) = (u32::from(mapped.offset), u32::from(mapped.bits));
                is_long |= offset + bits > 64;
                mask |= u64::MAX.checked_shr(64 - bits.clamp(1, 64)).unwrap_or(0).checked_shl(offset).unwrap_or(0);
            }
        }
        let mapping = Arc::clone(mapping);
        Self { mapping, plot, is_trusted: true, signals, is_reporting, mask, is_long, last: None }
    }

    /// Statuswords in it are read.
    fn has_statuswords(&self) -> bool {
        self.is_reporting && self.is_trusted && self.last.is_some()
    }

    fn end(&mut self, pen: &mut Pen<'_>, at: At) {
        self.end_both(pen, at, at);
    }

    /// Ends lanes, and what is plotted at another place.
    fn end_both(&mut self, pen: &mut Pen<'_>, at: At, plotted: At) {
        if self.last.take().is_some() {
            self.end_plot(pen, plotted);
            for one in &mut self.signals {
                one.end(pen, at);
            }
        }
    }

    /// Samples that are plotted do not hold on.
    fn end_plot(&self, pen: &mut Pen<'_>, at: At) {
        if !self.plot.is_empty() {
            pen.end(&self.plot, at);
        }
    }
}

/// The mapping of a PDO, and whether it is its own and no frames were lost since it was known; `None` where none is.
fn read(data: &ProcessData) -> Option<(&Arc<Mapping>, bool)> {
    match &data.content {
        Signals::Mapped(mapping, from) => Some((mapping, !from.is_doubted())),
        Signals::ByConsumer(mapping, ..) => Some((mapping, false)),
        Signals::None(_) => None,
    }
}

fn key(frame: &Frame, data: &ProcessData) -> Key {
    (frame.bus, data.node, data.transmit, data.number)
}

/// A PDO of a bus.
type Key = (BusId, u8, bool, u16);

/// The signals of all PDOs.
#[derive(Debug)]
pub(super) struct Values {
    selection: Selection,
    carriers: BTreeMap<Key, Carrier>,
    /// The number of lanes.
    count: usize,
}

impl Values {
    /// None yet.
    pub(super) fn new(selection: Selection) -> Self {
        Self { selection, carriers: BTreeMap::new(), count: 0 }
    }

    /// Returns true if lanes show already what a frame carries.
    #[inline]
    pub(super) fn is_same(&self, frame: &Frame, data: &ProcessData) -> bool {
        let (Some((mapping, is_trusted)), Some(carrier)) = (read(data), self.carriers.get(&key(frame, data))) else {
            return false;
        };
        let payload = frame.payload();
        carrier.last.is_some_and(|(before, len)| {
            Arc::ptr_eq(&carrier.mapping, mapping)
                && carrier.is_trusted == is_trusted
                && !carrier.is_long
                && len == payload.len()
                && (before ^ word(payload)) & carrier.mask == 0
        })
    }

    /// Shows what a frame carries, at `at`; gives whether statuswords that were read before are not read any more.
    pub(super) fn change(
        &mut self,
        pen: &mut Pen<'_>,
        prefix: &str,
        (frame, at, shown): (&Frame, At, bool),
        data: &ProcessData,
    ) -> bool {
        let key = key(frame, data);
        let before = self.carriers.get(&key).is_some_and(Carrier::has_statuswords);
        let Some((mapping, is_trusted)) = read(data).filter(|_| shown) else {
            if let Some(carrier) = self.carriers.get_mut(&key) {
                carrier.end(pen, at);
            }
            return before;
        };
        self.compile(pen, prefix, key, mapping, at);
        let Some(carrier) = self.carriers.get_mut(&key) else { return before };
        let payload = frame.payload();
        carrier.is_trusted = is_trusted;
        carrier.last = Some((word(payload), payload.len()));
        for one in &mut carrier.signals {
            // A payload that is too short says nothing.
            if let Some(mapped) = mapping.entries.get(one.place)
                && let Some(raw) = mapping.raw(mapped, payload)
            {
                one.show(pen, mapping, raw, at);
            }
        }
        before && !carrier.has_statuswords()
    }

    /// Makes the lanes of a PDO, where its mapping is not the one that it had.
    fn compile(&mut self, pen: &mut Pen<'_>, prefix: &str, key: Key, mapping: &Arc<Mapping>, at: At) {
        if let Some(known) = self.carriers.get_mut(&key) {
            if Arc::ptr_eq(&known.mapping, mapping) {
                return;
            }
            if known.mapping.bits == mapping.bits && known.mapping.entries == mapping.entries {
                known.mapping = Arc::clone(mapping);
                return;
            }
        } else if self.carriers.len() >= PDOS {
            return;
        }
        let mut old = self.carriers.remove(&key);
        let before = old.as_ref().map_or(0, |old| old.signals.len());
        let (_, node, transmit, number) = key;
        let whose = Whose { transmit, number, node };
        let chosen = self.selection.choose(whose, mapping);
        let is_plotted = |one: &Chosen| mapping.entries.get(one.place).is_some_and(signal::is_quantity);
        let plotted = chosen.iter().find(|one| is_plotted(one));
        let plot = plotted.map_or_else(String::new, |one| format!("pdo/{prefix}node{node}/{}", one.pdo));
        if let Some(old) = old.as_ref().filter(|old| old.last.is_some()) {
            old.end_plot(pen, at);
        }
        let mut signals: Vec<Signal> = Vec::new();
        for one in chosen {
            let Some(mapped) = mapping.entries.get(one.place).filter(|mapped| is_lane(mapped)) else { continue };
            if self.count - before + signals.len() >= LANES {
                break;
            }
            let lane = lane(prefix, &one, node, &signals);
            let known = old.as_mut().map(|old| &mut old.signals);
            let place = known.as_ref().and_then(|known| known.iter().position(|other| other.lane == lane));
            let mut signal = Signal::new(&one, mapped, lane);
            if let (Some(known), Some(place)) = (known, place) {
                // What was shown may have been other bits; the row that follows says what it is now.
                let mut other = known.remove(place);
                if (other.has_bits, other.is_truth) == (signal.has_bits, signal.is_truth) {
                    other.place = signal.place;
                    signal = other;
                } else {
                    other.end(pen, at);
                }
            }
            signals.push(signal);
        }
        for mut gone in old.into_iter().flat_map(|old| old.signals) {
            gone.end(pen, at);
        }
        self.count = self.count - before + signals.len();
        self.carriers.insert(key, Carrier::new(mapping, plot, transmit, signals));
    }

    /// A PDO that was sent before the node obeyed a command to send none: the last one, as far as anybody knows.
    pub(super) fn late(&self, pen: &mut Pen<'_>, frame: &Frame, data: &ProcessData, at: At) {
        if let Some(carrier) = self.carriers.get(&key(frame, data)) {
            carrier.end_plot(pen, at);
        }
    }

    /// Ends the lanes of a node, or of all nodes of a bus.
    pub(super) fn end(&mut self, pen: &mut Pen<'_>, bus: BusId, node: Option<u8>, at: At) {
        self.end_since(pen, bus, node, at, at);
    }

    /// The same, where that is found out at `at`, but samples have not held on since `plotted`.
    pub(super) fn end_since(&mut self, pen: &mut Pen<'_>, bus: BusId, node: Option<u8>, at: At, plotted: At) {
        let (first, last) = node.map_or((0, u8::MAX), |node| (node, node));
        for (_, carrier) in self.carriers.range_mut((bus, first, false, 0)..=(bus, last, true, u16::MAX)) {
            carrier.end_both(pen, at, plotted);
        }
    }
}

/// Returns true if a signal has a lane: it is no quantity, and its bits can be read.
fn is_lane(mapped: &Mapped) -> bool {
    !signal::is_quantity(mapped) && (1..=64).contains(&mapped.bits)
}

/// The name of a signal's lane, which no other one of the PDO has.
fn lane(prefix: &str, one: &Chosen, node: u8, taken: &[Signal]) -> String {
    let mut lane = format!("value/{prefix}node{node}/{}/", one.pdo);
    match one.name.char_indices().nth(LONGEST) {
        Some((end, _)) => {
            part(&mut lane, one.name.get(..end).unwrap_or_default().as_bytes());
            lane.push('…');
        }
        None => part(&mut lane, one.name.as_bytes()),
    }
    let first = lane.clone();
    let mut number = 1;
    while taken.iter().any(|other| other.lane == lane) {
        lane = format!("{first}({})", one.object);
        if number > 1 {
            lane.push_str(&format!("{number}"));
        }
        number += 1;
    }
    lane
}

/// A payload of up to eight bytes as a number, the first byte lowest; of a longer one its beginning.
#[inline]
fn word(payload: &[u8]) -> u64 {
    if let Ok(whole) = <[u8; 8]>::try_from(payload) {
        return u64::from_le_bytes(whole);
    }
    payload.iter().take(8).rev().fold(0, |word, byte| word << 8 | u64::from(*byte))
}

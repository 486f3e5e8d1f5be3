//! One node: its configuration, and the PDOs that follow from it.
//!
//! PDOs are compiled when the configuration changes, so that a frame costs one look-up. Frames are not looked at here,
//! and nothing is judged.

use std::collections::BTreeSet;
use std::ops::RangeInclusive;
use std::sync::Arc;

use crate::bytes::frame::CanId;
use crate::wire::pdo::mapping::{Mapped, Mapping, decode_entry};
use crate::wire::pdo::{communication_parameter, mapping_parameter, of_parameter, predefined_id};
use crate::words::profiles::Profile;
use crate::world::configuration::{Configuration, Provenance};
use crate::world::od::DataType;

/// Highest number of entries of a mapping; 254 and 255 mark multiplex PDOs.
const MOST_ENTRIES: u64 = 64;
/// The object with the kind of device.
const DEVICE_TYPE: u16 = 0x1000;
/// Mapping parameters of RPDOs and TPDOs.
const MAPPINGS: [std::ops::RangeInclusive<u16>; 2] = [0x1600..=0x17FF, 0x1A00..=0x1BFF];
/// Maximum number of changes of a node's kind of device that are followed: real nodes do not change it, and all PDOs
/// are compiled again for each.
const TURNS: u8 = 16;
/// Communication and mapping parameters of PDOs.
const PARAMETERS: RangeInclusive<u16> = 0x1400..=0x1BFF;
/// Bytes of a multiplex PDO's data, and of its address before them.
const MULTIPLEXED: u8 = 4;

/// A value for every node that needs one, by node-ID 1..=127: one array look-up.
#[derive(Clone, Debug)]
pub struct PerNode<T> {
    slots: Vec<Option<Box<T>>>,
    /// A dummy for impossible node-IDs (a node-ID is at most 127).
    nowhere: T,
}

/// Node-IDs and 0.
const SLOTS: usize = 128;
/// Highest PDO number.
const LAST_PDO: u16 = 512;

impl<T: Default> Default for PerNode<T> {
    fn default() -> Self {
        Self { slots: (0..SLOTS).map(|_| None).collect(), nowhere: T::default() }
    }
}

impl<T: Default> PerNode<T> {
    /// Returns the value of a node.
    pub fn get(&self, node: u8) -> Option<&T> {
        self.slots.get(usize::from(node)).and_then(Option::as_deref)
    }

    /// Returns the value of a node for changing it.
    #[inline]
    pub fn get_mut(&mut self, node: u8) -> Option<&mut T> {
        self.slots.get_mut(usize::from(node)).and_then(Option::as_deref_mut)
    }

    /// Returns the value of a node, which is created if there is none.
    #[inline]
    pub fn entry(&mut self, node: u8) -> &mut T {
        match self.slots.get_mut(usize::from(node)) {
            Some(slot) => slot.get_or_insert_default(),
            None => &mut self.nowhere,
        }
    }

    /// Removes the value of a node.
    pub fn take(&mut self, node: u8) -> Option<Box<T>> {
        self.slots.get_mut(usize::from(node)).and_then(Option::take)
    }

    /// Sets the value of a node.
    pub fn put(&mut self, node: u8, value: Box<T>) {
        if let Some(slot) = self.slots.get_mut(usize::from(node)) {
            *slot = Some(value);
        }
    }

    /// Returns all nodes, ascending.
    pub fn iter(&self) -> impl Iterator<Item = (u8, &T)> {
        self.slots.iter().enumerate().filter_map(|(node, slot)| Some((node as u8, slot.as_deref()?)))
    }

    /// Returns all nodes for changing them, ascending.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = (u8, &mut T)> {
        self.slots.iter_mut().enumerate().filter_map(|(node, slot)| Some((node as u8, slot.as_deref_mut()?)))
    }
}

/// A value for every PDO of a node that needs one, by direction and number 1..=512: one array look-up.
#[derive(Clone, Debug, Default)]
pub struct PerPdo<T> {
    /// By number, RPDO before TPDO.
    slots: Vec<Option<Box<T>>>,
    /// A dummy for impossible numbers.
    nowhere: T,
}

impl<T: Default> PerPdo<T> {
    /// Returns the value of a PDO for changing it.
    #[inline]
    pub fn get_mut(&mut self, transmit: bool, number: u16) -> Option<&mut T> {
        self.slots.get_mut(Self::place(transmit, number)).and_then(Option::as_deref_mut)
    }

    /// Returns the value of a PDO, which is created if there is none.
    #[inline]
    pub fn entry(&mut self, transmit: bool, number: u16) -> &mut T {
        let place = Self::place(transmit, number);
        if place >= self.slots.len() && number <= LAST_PDO {
            self.slots.resize_with(place + 1, || None);
        }
        match self.slots.get_mut(place) {
            Some(slot) => slot.get_or_insert_default(),
            None => &mut self.nowhere,
        }
    }

    /// Removes the value of a PDO.
    pub fn take(&mut self, transmit: bool, number: u16) -> Option<Box<T>> {
        self.slots.get_mut(Self::place(transmit, number)).and_then(Option::take)
    }

    /// Returns all values for changing them.
    pub fn values_mut(&mut self) -> impl Iterator<Item = &mut T> {
        self.slots.iter_mut().filter_map(Option::as_deref_mut)
    }

    fn place(transmit: bool, number: u16) -> usize {
        2 * usize::from(number) + usize::from(transmit)
    }
}

/// The parts of a COB-ID entry (CiA 301, 7.5.2.35 and .37).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CobId {
    /// Bit 31 is 0: it is used.
    pub valid: bool,
    /// Bit 30 is 0: remote frames are answered. Only for a TPDO.
    pub rtr_allowed: bool,
    /// The identifier.
    pub id: CanId,
}

impl CobId {
    /// Bit 31: it is not used.
    pub const INVALID: u64 = 1 << 31;

    /// Splits the value of an entry. Bits beyond an 11-bit identifier are ignored, as devices do.
    pub fn from_entry(value: u64) -> Self {
        let id = match value & 1 << 29 {
            0 => CanId::standard((value & 0x7FF) as u16),
            _ => CanId::extended((value & 0x1FFF_FFFF) as u32),
        };
        Self { valid: value & Self::INVALID == 0, rtr_allowed: value & 1 << 30 == 0, id }
    }

    /// Returns true if an entry has bits beyond its identifier of 11 bits.
    pub fn is_beyond_standard(value: u64) -> bool {
        value & 1 << 29 == 0 && value & 0x1FFF_FFFF & !0x7FF != 0
    }
}

/// One PDO of a node, as it is configured now.
#[derive(Clone, Debug)]
pub struct Pdo {
    /// Transmit or receive, seen from the node.
    pub transmit: bool,
    /// PDO number, 1..=512.
    pub number: u16,
    /// Its COB-ID and the source.
    pub cob: (CobId, Provenance),
    /// Transmission type.
    pub transmission: Option<(u8, Provenance)>,
    /// Inhibit time in 100 µs; 0 = none.
    pub inhibit: Option<(u16, Provenance)>,
    /// Event timer in ms; 0 = none.
    pub event_timer: Option<(u16, Provenance)>,
    /// SYNC start value; 0 = counter not used.
    pub sync_start: Option<(u8, Provenance)>,
    /// The content of its bytes.
    pub content: Content,
}

/// The content of a PDO's bytes.
#[derive(Clone, Debug)]
pub enum Content {
    /// Mapped objects; the provenance is that of the least trusted part.
    Mapped(Arc<Mapping>, Provenance),
    /// A multiplex PDO: sub-index 0 of the mapping is 254 (source) or 255 (destination address mode).
    Multiplex {
        /// Destination address mode.
        destination: bool,
        /// The source of that.
        from: Provenance,
    },
    /// Sub-index 0 of the mapping is 0.
    Disabled(Provenance),
    /// It is unknown, or not completely known.
    Unknown,
}

impl UnconfirmedPdo {
    /// Returns its mapping, if a frame of `len` bytes matches it.
    pub fn mapping_of(&self, len: u8) -> Option<&(Arc<Mapping>, Provenance)> {
        self.mapping.as_ref().filter(|(mapping, _)| mapping.bytes() == usize::from(len))
    }

    /// Returns true if a frame of `len` bytes contradicts its mapping.
    pub fn is_refuted_by(&self, len: u8) -> bool {
        self.mapping.is_some() && self.mapping_of(len).is_none()
    }
}

impl Pdo {
    /// The index of its communication parameter.
    pub fn communication(&self) -> u16 {
        communication_parameter(self.transmit, self.number)
    }

    /// The index of its mapping parameter.
    pub fn mapping(&self) -> u16 {
        mapping_parameter(self.transmit, self.number)
    }

    /// Returns true if a told COB-ID disables it; what only a file says, or what the capture contradicts, does not.
    pub fn is_off(&self) -> bool {
        let (cob, from) = self.cob;
        from.is_told() && !from.is_doubted() && !cob.valid
    }
}

/// One node.
#[derive(Debug, Default)]
pub struct Node {
    id: u8,
    /// The values of its objects.
    pub configuration: Configuration,
    /// Receive first, by number.
    pdos: Vec<Pdo>,
    /// The key of each, apart: they are looked for at every frame of a PDO.
    keys: Vec<u16>,
    /// Those with requests of unanswered writes, in the same order.
    unconfirmed: Vec<UnconfirmedPdo>,
    /// By its device type.
    profile: Profile,
    /// Mapping parameters of PDOs that carry the objects of a drive, and of a device with inputs and outputs: all would have
    /// to be gone through at each write of one.
    of_drive: BTreeSet<u16>,
    of_io: BTreeSet<u16>,
    /// The number of changes of it.
    turned: u8,
    /// PDOs that were compiled again since the last call: transmit or receive, and number.
    renewed: BTreeSet<(bool, u16)>,
}

/// The requests of unanswered writes about a PDO.
#[derive(Clone, Debug)]
pub struct UnconfirmedPdo {
    /// Transmit or receive, seen from the node.
    pub transmit: bool,
    /// PDO number, 1..=512.
    pub number: u16,
    /// Its COB-ID.
    pub cob: Option<(CobId, Provenance)>,
    /// Its mapping, if it is completely known.
    pub mapping: Option<(Arc<Mapping>, Provenance)>,
}

impl Node {
    /// Creates a node without any knowledge.
    pub fn new(id: u8) -> Self {
        Self { id, ..Self::default() }
    }

    /// Its node-ID.
    pub fn id(&self) -> u8 {
        self.id
    }

    /// Changes its node-ID (LSS).
    pub fn rename(&mut self, id: u8) {
        self.id = id;
        self.compile_all();
    }

    /// Returns a number of one of its objects, with the source.
    pub fn value(&self, index: u16, sub: u8) -> Option<(u64, Provenance)> {
        self.configuration.get(self.id, index, sub).map(|known| (known.value, known.from))
    }

    /// Likewise, but ignores pending writes.
    pub fn before_writing(&self, index: u16, sub: u8) -> Option<(u64, Provenance)> {
        self.configuration.before_writing(self.id, index, sub).map(|known| (known.value, known.from))
    }

    /// Returns its known PDOs: receive first, by number.
    pub fn pdos(&self) -> &[Pdo] {
        &self.pdos
    }

    /// Returns the requests of unanswered writes about its PDOs: receive first, by number.
    pub fn unconfirmed_pdos(&self) -> &[UnconfirmedPdo] {
        &self.unconfirmed
    }

    /// Returns the requests of unanswered writes about one PDO.
    pub fn unconfirmed_pdo(&self, transmit: bool, number: u16) -> Option<&UnconfirmedPdo> {
        let found = self.unconfirmed.binary_search_by_key(&key(transmit, number), |pdo| key(pdo.transmit, pdo.number));
        found.ok().and_then(|place| self.unconfirmed.get(place))
    }

    /// Returns its device profile, by its device type, else by what its PDOs carry.
    pub fn profile(&self) -> Profile {
        self.profile
    }

    /// One PDO.
    pub fn pdo(&self, transmit: bool, number: u16) -> Option<&Pdo> {
        let found = self.keys.binary_search(&key(transmit, number));
        found.ok().and_then(|place| self.pdos.get(place))
    }

    /// Returns the PDOs that were compiled again since the last call: transmit or receive, and number.
    pub fn renewed(&mut self) -> BTreeSet<(bool, u16)> {
        std::mem::take(&mut self.renewed)
    }

    /// Compiles the PDOs whose objects have changed.
    pub fn compile(&mut self) {
        let changed = self.configuration.uncompiled();
        changed.iter().for_each(|index| self.mapping_shows(*index));
        // It determines the types of mapped objects.
        let shows = |index: &u16| *index == DEVICE_TYPE || MAPPINGS.iter().any(|range| range.contains(index));
        if changed.iter().any(shows) && self.profile_now() != self.profile && self.turned < TURNS {
            self.turned += 1;
            return self.compile_all();
        }
        let concerned: BTreeSet<_> = changed.into_iter().filter_map(of_parameter).collect();
        for (transmit, number) in concerned {
            self.renew(transmit, number);
        }
    }

    /// Compiles all PDOs.
    pub fn compile_all(&mut self) {
        self.configuration.uncompiled();
        self.configuration.all_untold();
        (self.of_drive, self.of_io) = (BTreeSet::new(), BTreeSet::new());
        let mappings = MAPPINGS.map(|range| self.configuration.indices(range));
        mappings.into_iter().flatten().for_each(|index| self.mapping_shows(index));
        self.profile = self.profile_now();
        let before = self.pdos.iter().map(|pdo| (pdo.transmit, pdo.number));
        let mut concerned: BTreeSet<_> = before.collect();
        concerned.extend(self.unconfirmed.iter().map(|pdo| (pdo.transmit, pdo.number)));
        concerned.extend(self.configuration.indices(PARAMETERS).into_iter().filter_map(of_parameter));
        concerned.extend(self.configuration.requested_indices(PARAMETERS).into_iter().filter_map(of_parameter));
        for (transmit, number) in concerned {
            self.renew(transmit, number);
        }
    }

    fn renew(&mut self, transmit: bool, number: u16) {
        self.renewed.insert((transmit, number));
        let (communication, mapping) = (communication_parameter(transmit, number), mapping_parameter(transmit, number));
        let known = self.configuration.holds(communication) || self.configuration.holds(mapping);
        let pdo = known.then(|| self.compiled(transmit, number));
        let place = key(transmit, number);
        put(&mut self.keys, place, known.then_some(place), |place| *place);
        put(&mut self.pdos, place, pdo, |pdo| key(pdo.transmit, pdo.number));
        let requested = self.configuration.is_requested(communication) || self.configuration.is_requested(mapping);
        let unconfirmed = requested.then(|| self.compiled_unconfirmed(transmit, number));
        put(&mut self.unconfirmed, place, unconfirmed, |pdo| key(pdo.transmit, pdo.number));
    }

    fn compiled_unconfirmed(&self, transmit: bool, number: u16) -> UnconfirmedPdo {
        let index = communication_parameter(transmit, number);
        let cob = self.configuration.requested(index, 1);
        let cob = cob.map(|known| (CobId::from_entry(known.value), known.from));
        UnconfirmedPdo { transmit, number, cob, mapping: self.unconfirmed_mapping(index + 0x200) }
    }

    /// Returns the mapping that unanswered writes request: its number of entries is the last of them, as a master
    /// writes it.
    fn unconfirmed_mapping(&self, index: u16) -> Option<(Arc<Mapping>, Provenance)> {
        let value = |sub| {
            let sure = || self.value(index, sub).filter(|(_, from)| !from.is_doubted());
            self.configuration.requested(index, sub).map(|known| (known.value, known.from)).or_else(sure)
        };
        let (count, since) = value(0)?;
        let later = |(_, from): (u64, Provenance)| from.is_unconfirmed() && from.frame() > since.frame();
        match self.content(value) {
            Content::Mapped(mapping, from @ Provenance::Unconfirmed(_)) => {
                let whole = !(1..=count as u8).any(|sub| value(sub).is_some_and(later));
                whole.then_some((mapping, from))
            }
            _ => None,
        }
    }

    fn compiled(&self, transmit: bool, number: u16) -> Pdo {
        let communication = communication_parameter(transmit, number);
        let cob = match (self.value(communication, 1), predefined_id(transmit, number)) {
            (Some((value, from)), _) => (CobId::from_entry(value), from),
            (None, Some(base)) => {
                let id = CanId::standard(base + u16::from(self.id));
                (CobId { valid: true, rtr_allowed: true, id }, Provenance::Default)
            }
            (None, None) => (CobId { valid: false, rtr_allowed: true, id: CanId::standard(0) }, Provenance::Default),
        };
        Pdo {
            transmit,
            number,
            cob,
            transmission: self.value(communication, 2).map(|(value, from)| (value as u8, from)),
            inhibit: self.value(communication, 3).map(|(value, from)| (value as u16, from)),
            event_timer: self.value(communication, 5).map(|(value, from)| (value as u16, from)),
            sync_start: self.value(communication, 6).map(|(value, from)| (value as u8, from)),
            content: self.content(|sub| self.value(mapping_parameter(transmit, number), sub)),
        }
    }

    /// Returns the content of a PDO by the values of its mapping parameter.
    fn content(&self, value: impl Fn(u8) -> Option<(u64, Provenance)>) -> Content {
        let Some((count, mut least)) = value(0) else { return Content::Unknown };
        match count {
            0 => return Content::Disabled(least),
            254 | 255 => return Content::Multiplex { destination: count == 255, from: least },
            1..=MOST_ENTRIES => {}
            _ => return Content::Unknown,
        }
        let mut entries = Vec::new();
        let mut offset = 0;
        for sub in 1..=count as u8 {
            let Some((word, from)) = value(sub) else { return Content::Unknown };
            least = trusted_less(least, from);
            let (index, sub, bits) = decode_entry(word as u32);
            if bits == 0 {
                continue;
            }
            entries.push(self.mapped(index, sub, bits, offset));
            offset += u16::from(bits);
        }
        Content::Mapped(Arc::new(Mapping::new(entries, offset)), least)
    }

    fn profile_now(&self) -> Profile {
        self.value(DEVICE_TYPE, 0).map_or_else(|| self.profile_by_mappings(), |(device, _)| Profile::of(device as u32))
    }

    /// Returns the profile by what the node's PDOs carry: a drive has a controlword or a statusword, a device with inputs
    /// and outputs their values, of eight or sixteen bits each.
    fn profile_by_mappings(&self) -> Profile {
        match (self.of_drive.is_empty(), self.of_io.is_empty()) {
            (false, _) => Profile::DRIVE,
            (true, false) => Profile::IO,
            (true, true) => Profile::UNKNOWN,
        }
    }

    /// Notes which device an object shows, if it is a mapping parameter.
    fn mapping_shows(&mut self, index: u16) {
        if !MAPPINGS.iter().any(|range| range.contains(&index)) {
            return;
        }
        let count = self.value(index, 0).map_or(0, |(count, _)| count as u8).min(8);
        let (mut drive, mut io) = (false, false);
        for (word, _) in (1..=count).filter_map(|sub| self.value(index, sub)) {
            match (word >> 16 & 0xFFFF, word >> 8 & 0xFF, word & 0xFF) {
                (0x6040 | 0x6041, 0, 16) => drive = true,
                (0x6000 | 0x6200, 1.., 8) | (0x6401 | 0x6411, 1.., 16) => io = true,
                _ => {}
            }
        }
        for (all, shown) in [(&mut self.of_drive, drive), (&mut self.of_io, io)] {
            if shown {
                all.insert(index);
            } else {
                all.remove(&index);
            }
        }
    }

    /// Returns an object of the node as the only entry of a multiplex PDO: from byte 4 on, as long as its type. It has
    /// all four bytes without a type, and with one of more than four bytes or without a fixed size (DOMAIN).
    pub fn multiplexed(&self, index: u16, sub: u8) -> Mapping {
        let mut object = self.mapped(index, sub, 8 * MULTIPLEXED, 8 * u16::from(MULTIPLEXED));
        if std::mem::take(&mut object.dummy) {
            object.data_type = None;
        }
        match object.data_type.map(DataType::size) {
            Some(Some(size)) if size <= usize::from(MULTIPLEXED) => object.bits = 8 * size as u8,
            Some(_) => object.data_type = Some(DataType::Domain),
            None => {}
        }
        Mapping::new(vec![object], 16 * u16::from(MULTIPLEXED))
    }

    /// Returns an object of the node as an entry of a mapping.
    pub fn mapped(&self, index: u16, sub: u8, bits: u8, offset: u16) -> Mapped {
        // Indices below 0020h are data types: bits that are skipped.
        let dummy = index < 0x20;
        let object = self.configuration.object(index, sub).filter(|_| !dummy);
        let described = object.and_then(|object| object.data_type());
        Mapped {
            index,
            sub,
            bits,
            offset,
            data_type: if dummy {
                DataType::from_code(index)
            } else {
                described.or_else(|| self.profile.data_type(index, sub))
            },
            profile: self.profile,
            dummy,
            name: object.map(|object| Arc::clone(&object.name)).filter(|name| !name.is_empty()),
            unit: object.and_then(|object| object.unit.clone()),
            factor: object.map_or(1.0, |object| object.factor),
        }
    }
}

/// Returns a number by which the PDOs of a node are ordered: numbers are compared without a branch.
fn key(transmit: bool, number: u16) -> u16 {
    u16::from(transmit) << 15 | number
}

/// Inserts an element into others that are ordered by their keys, or removes it.
fn put<T, K: Ord>(all: &mut Vec<T>, key: K, one: Option<T>, of: impl Fn(&T) -> K) {
    match (all.binary_search_by_key(&key, of), one) {
        (Ok(place), Some(one)) => {
            if let Some(slot) = all.get_mut(place) {
                *slot = one;
            }
        }
        (Ok(place), None) => _ = all.remove(place),
        (Err(place), Some(one)) => all.insert(place, one),
        (Err(_), None) => {}
    }
}

/// Returns the less trusted of two sources; of two observations the later one, with which the whole was known.
fn trusted_less(one: Provenance, other: Provenance) -> Provenance {
    match (one, other) {
        (Provenance::Observed(one), Provenance::Observed(other)) => Provenance::Observed(one.max(other)),
        (Provenance::Doubted(one), Provenance::Doubted(other)) => Provenance::Doubted(one.max(other)),
        (Provenance::Unconfirmed(one), Provenance::Unconfirmed(other)) => Provenance::Unconfirmed(one.max(other)),
        _ => one.min(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_pdo_has_a_value_of_its_own() {
        let mut pdos = PerPdo::<u16>::default();
        for number in [3, 1, 512] {
            *pdos.entry(true, number) = number;
            *pdos.entry(false, number) = 1000 + number;
        }
        assert_eq!(pdos.values_mut().map(|value| *value).collect::<Vec<_>>(), [1001, 1, 1003, 3, 1512, 512]);
        assert_eq!(pdos.get_mut(true, 2), None);
        assert_eq!(pdos.get_mut(false, 513), None);
        assert_eq!(pdos.take(true, 3).as_deref(), Some(&3));
        assert_eq!(pdos.get_mut(true, 3), None);
        assert_eq!(pdos.get_mut(false, 3), Some(&mut 1003));
    }

    #[test]
    fn impossible_numbers_take_no_room() {
        let mut pdos = PerPdo::<u16>::default();
        *pdos.entry(true, u16::MAX) = 1;
        assert_eq!((pdos.slots.len(), pdos.values_mut().count()), (0, 0));
    }
}

//! One node: its configuration, and the PDOs that follow from it.
//!
//! PDOs are compiled when the configuration changes, so that a frame costs one look-up. It must not look at frames,
//! and judges nothing.

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
/// What kind of device it is.
const DEVICE_TYPE: u16 = 0x1000;
/// So often it is believed that a node is another kind of device now: none is, and all PDOs are made anew by it.
const TURNS: u8 = 16;
/// Communication and mapping parameters of PDOs.
const PARAMETERS: RangeInclusive<u16> = 0x1400..=0x1BFF;
/// Bytes of a multiplex PDO's data, and of its address before them.
const MULTIPLEXED: u8 = 4;

/// Something kept for every node that needs it, by node-ID 1..=127: one array look-up.
#[derive(Debug)]
pub struct PerNode<T> {
    slots: Vec<Option<Box<T>>>,
    /// Stands in where no node can be (never: a node-ID is at most 127).
    nowhere: T,
}

/// Node-IDs and 0.
const SLOTS: usize = 128;

impl<T: Default> Default for PerNode<T> {
    fn default() -> Self {
        Self { slots: (0..SLOTS).map(|_| None).collect(), nowhere: T::default() }
    }
}

impl<T: Default> PerNode<T> {
    /// What is kept for a node.
    pub fn get(&self, node: u8) -> Option<&T> {
        self.slots.get(usize::from(node)).and_then(Option::as_deref)
    }

    /// The same, to change it.
    #[inline]
    pub fn get_mut(&mut self, node: u8) -> Option<&mut T> {
        self.slots.get_mut(usize::from(node)).and_then(Option::as_deref_mut)
    }

    /// What is kept for a node, made where there is nothing yet.
    #[inline]
    pub fn entry(&mut self, node: u8) -> &mut T {
        match self.slots.get_mut(usize::from(node)) {
            Some(slot) => slot.get_or_insert_default(),
            None => &mut self.nowhere,
        }
    }

    /// Takes it out.
    pub fn take(&mut self, node: u8) -> Option<Box<T>> {
        self.slots.get_mut(usize::from(node)).and_then(Option::take)
    }

    /// Puts it in.
    pub fn put(&mut self, node: u8, value: Box<T>) {
        if let Some(slot) = self.slots.get_mut(usize::from(node)) {
            *slot = Some(value);
        }
    }

    /// All nodes, ascending.
    pub fn iter(&self) -> impl Iterator<Item = (u8, &T)> {
        self.slots.iter().enumerate().filter_map(|(node, slot)| Some((node as u8, slot.as_deref()?)))
    }

    /// All nodes, ascending, to change them.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = (u8, &mut T)> {
        self.slots.iter_mut().enumerate().filter_map(|(node, slot)| Some((node as u8, slot.as_deref_mut()?)))
    }
}

/// A COB-ID entry (CiA 301, 7.5.2.35 and .37), taken apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CobId {
    /// Bit 31 is 0: it is used.
    pub valid: bool,
    /// Bit 30 is 0: remote frames are answered. Only of a TPDO.
    pub rtr_allowed: bool,
    /// The identifier.
    pub id: CanId,
}

impl CobId {
    /// Bit 31: it is not used.
    pub const INVALID: u64 = 1 << 31;

    /// From the value of an entry. Bits that an 11-bit identifier has not are left out, as devices do.
    pub fn from_entry(value: u64) -> Self {
        let id = match value & 1 << 29 {
            0 => CanId::standard((value & 0x7FF) as u16),
            _ => CanId::extended((value & 0x1FFF_FFFF) as u32),
        };
        Self { valid: value & Self::INVALID == 0, rtr_allowed: value & 1 << 30 == 0, id }
    }

    /// Whether an entry has bits that its identifier of 11 bits has not.
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
    /// Its COB-ID and from where it is known.
    pub cob: (CobId, Provenance),
    /// Transmission type.
    pub transmission: Option<(u8, Provenance)>,
    /// Inhibit time in 100 µs; 0 = none.
    pub inhibit: Option<(u16, Provenance)>,
    /// Event timer in ms; 0 = none.
    pub event_timer: Option<(u16, Provenance)>,
    /// SYNC start value; 0 = counter not used.
    pub sync_start: Option<(u8, Provenance)>,
    /// What its bytes are.
    pub content: Content,
}

/// What a PDO's bytes are.
#[derive(Clone, Debug)]
pub enum Content {
    /// Mapped objects; the provenance is that of the least trusted part.
    Mapped(Arc<Mapping>, Provenance),
    /// A multiplex PDO: sub-index 0 of the mapping is 254 (source) or 255 (destination address mode).
    Multiplex {
        /// Destination address mode.
        destination: bool,
        /// From where that is known.
        from: Provenance,
    },
    /// Sub-index 0 of the mapping is 0.
    Disabled(Provenance),
    /// Nothing is known, or not all of it.
    Unknown,
}

impl UnconfirmedPdo {
    /// Its mapping, where a frame of `len` bytes agrees with it.
    pub fn mapping_of(&self, len: u8) -> Option<&(Arc<Mapping>, Provenance)> {
        self.mapping.as_ref().filter(|(mapping, _)| mapping.bytes() == usize::from(len))
    }

    /// Whether a frame of `len` bytes shows that its mapping does not hold.
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
}

/// One node.
#[derive(Debug, Default)]
pub struct Node {
    id: u8,
    /// What its objects hold.
    pub configuration: Configuration,
    /// Receive first, by number.
    pdos: Vec<Pdo>,
    /// Those of which unanswered writes ask for something, in the same order.
    unconfirmed: Vec<UnconfirmedPdo>,
    /// By its device type.
    profile: Profile,
    /// How often that was another answer.
    turned: u8,
    /// PDOs that were made anew since it was last asked: transmit or receive, and number.
    renewed: BTreeSet<(bool, u16)>,
}

/// What unanswered writes ask of a PDO.
#[derive(Clone, Debug)]
pub struct UnconfirmedPdo {
    /// Transmit or receive, seen from the node.
    pub transmit: bool,
    /// PDO number, 1..=512.
    pub number: u16,
    /// Its COB-ID.
    pub cob: Option<(CobId, Provenance)>,
    /// Its mapping, where all of it is known.
    pub mapping: Option<(Arc<Mapping>, Provenance)>,
}

impl Node {
    /// A node of which nothing is known.
    pub fn new(id: u8) -> Self {
        Self { id, ..Self::default() }
    }

    /// Its node-ID.
    pub fn id(&self) -> u8 {
        self.id
    }

    /// Its node-ID is another one now (LSS).
    pub fn rename(&mut self, id: u8) {
        self.id = id;
        self.compile_all();
    }

    /// A number that one of its objects holds.
    pub fn value(&self, index: u16, sub: u8) -> Option<(u64, Provenance)> {
        self.configuration.get(self.id, index, sub).map(|known| (known.value, known.from))
    }

    /// The same, whatever is being written to it.
    pub fn before_writing(&self, index: u16, sub: u8) -> Option<(u64, Provenance)> {
        self.configuration.before_writing(self.id, index, sub).map(|known| (known.value, known.from))
    }

    /// Its PDOs, as far as known: receive first, by number.
    pub fn pdos(&self) -> &[Pdo] {
        &self.pdos
    }

    /// What unanswered writes ask of its PDOs: receive first, by number.
    pub fn unconfirmed_pdos(&self) -> &[UnconfirmedPdo] {
        &self.unconfirmed
    }

    /// What unanswered writes ask of one PDO.
    pub fn unconfirmed_pdo(&self, transmit: bool, number: u16) -> Option<&UnconfirmedPdo> {
        let found = self.unconfirmed.binary_search_by_key(&(transmit, number), |pdo| (pdo.transmit, pdo.number));
        found.ok().and_then(|place| self.unconfirmed.get(place))
    }

    /// The device profile that it follows, by its device type.
    pub fn profile(&self) -> Profile {
        self.profile
    }

    /// One PDO.
    pub fn pdo(&self, transmit: bool, number: u16) -> Option<&Pdo> {
        let found = self.pdos.binary_search_by_key(&(transmit, number), |pdo| (pdo.transmit, pdo.number));
        found.ok().and_then(|place| self.pdos.get(place))
    }

    /// PDOs that were made anew since this was last asked: transmit or receive, and number.
    pub fn renewed(&mut self) -> BTreeSet<(bool, u16)> {
        std::mem::take(&mut self.renewed)
    }

    /// Makes the PDOs anew whose objects have changed.
    pub fn compile(&mut self) {
        let changed = self.configuration.uncompiled();
        // By it the types of mapped objects are known.
        if changed.contains(&DEVICE_TYPE) && self.profile_now() != self.profile && self.turned < TURNS {
            self.turned += 1;
            return self.compile_all();
        }
        let concerned: BTreeSet<_> = changed.into_iter().filter_map(of_parameter).collect();
        for (transmit, number) in concerned {
            self.renew(transmit, number);
        }
    }

    /// Makes all PDOs anew.
    pub fn compile_all(&mut self) {
        self.configuration.uncompiled();
        self.configuration.all_untold();
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
        put(&mut self.pdos, (transmit, number), pdo, |pdo| (pdo.transmit, pdo.number));
        let requested = self.configuration.is_requested(communication) || self.configuration.is_requested(mapping);
        let unconfirmed = requested.then(|| self.compiled_unconfirmed(transmit, number));
        put(&mut self.unconfirmed, (transmit, number), unconfirmed, |pdo| (pdo.transmit, pdo.number));
    }

    fn compiled_unconfirmed(&self, transmit: bool, number: u16) -> UnconfirmedPdo {
        let index = communication_parameter(transmit, number);
        let cob = self.configuration.requested(index, 1);
        let cob = cob.map(|known| (CobId::from_entry(known.value), known.from));
        UnconfirmedPdo { transmit, number, cob, mapping: self.unconfirmed_mapping(index + 0x200) }
    }

    /// The mapping that unanswered writes ask for: its number of entries is the last of them, as a master writes it.
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

    /// What the bytes of a PDO are by the values of its mapping parameter.
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
        self.value(DEVICE_TYPE, 0).map_or(Profile::UNKNOWN, |(device, _)| Profile::of(device as u32))
    }

    /// An object of the node as the only entry of a multiplex PDO: from byte 4 on, as long as its type is. Without a
    /// type it is all four bytes; so it is with a type that four bytes do not hold, or of no fixed size, of which they
    /// are only some bytes (DOMAIN).
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

    fn mapped(&self, index: u16, sub: u8, bits: u8, offset: u16) -> Mapped {
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

/// Puts one in its place among others that are in the order of their keys, or takes it out.
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

/// The less trusted of two; of two observations the later one, with which the whole was known.
fn trusted_less(one: Provenance, other: Provenance) -> Provenance {
    match (one, other) {
        (Provenance::Observed(one), Provenance::Observed(other)) => Provenance::Observed(one.max(other)),
        (Provenance::Doubted(one), Provenance::Doubted(other)) => Provenance::Doubted(one.max(other)),
        (Provenance::Unconfirmed(one), Provenance::Unconfirmed(other)) => Provenance::Unconfirmed(one.max(other)),
        _ => one.min(other),
    }
}

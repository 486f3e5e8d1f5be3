//! The signals of a PDO that are listed, and their names.
//!
//! Found once a mapping, PDO and node, and remembered: nine tenths of a capture's frames ask the same again. Must not:
//! write anything.

use std::collections::BTreeMap;
use std::mem::{Discriminant, discriminant};
use std::sync::{Arc, OnceLock};

use super::csv;
use crate::bytes::select::Select;
use crate::wire::pdo::mapping::Mapping;
use crate::words::{Lang, signal};
use crate::world::configuration::Provenance;

/// PDOs whose selection is remembered at most, and mappings of each: every bus has its own, and so has every node that
/// is configured anew.
const PDOS: usize = 4096;
const MAPPINGS: usize = 64;
/// PDOs that are found at once: most captures have fewer.
const FOUND: usize = 256;

/// The PDO that a signal is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Whose {
    pub(super) transmit: bool,
    pub(super) number: u16,
    pub(super) node: u8,
}

impl Whose {
    /// Returns a number that no other PDO has.
    pub(super) fn key(self) -> u64 {
        u64::from(self.node) | u64::from(self.number) << 8 | u64::from(self.transmit) << 24
    }

    /// `TPDO1`.
    pub(super) fn pdo(self) -> String {
        format!("{}{}", if self.transmit { "TPDO" } else { "RPDO" }, self.number)
    }
}

/// A signal that is listed.
#[derive(Clone, Debug)]
pub(super) struct Chosen {
    /// Place of its entry in the mapping.
    pub(super) place: usize,
    /// Its name as it is written.
    pub(super) name: String,
    /// `6041:00`.
    pub(super) object: String,
    /// `TPDO1`.
    pub(super) pdo: String,
    /// Its name and its unit as cells of CSV.
    pub(super) cell: Vec<u8>,
    pub(super) unit_cell: Vec<u8>,
    /// The cells behind its value, which those who write them keep here.
    pub(super) rest: OnceLock<Vec<u8>>,
}

/// The signals of the mappings seen so far.
#[derive(Debug)]
pub(super) struct Selection {
    lang: Lang,
    select: Select,
    /// With their [`Whose::key`]; of each PDO the mapping used last first.
    known: Vec<(u64, Vec<Known>)>,
    /// The place of each PDO there.
    places: BTreeMap<u64, usize>,
    /// Places found last, by a part of the key.
    found: [usize; FOUND],
}

#[derive(Debug)]
struct Known {
    mapping: Arc<Mapping>,
    from: Discriminant<Provenance>,
    chosen: Vec<Chosen>,
}

impl Selection {
    /// Nothing seen yet.
    pub(super) fn new(lang: Lang, select: Select) -> Self {
        Self { lang, select, known: Vec::new(), places: BTreeMap::new(), found: [0; FOUND] }
    }

    /// Returns true if all signals are listed.
    pub(super) fn is_everything(&self) -> bool {
        self.select.is_everything()
    }

    /// The signals of a mapping that are listed, in its order; other ones where it is known in another way.
    pub(super) fn of(&mut self, whose: Whose, mapping: &Arc<Mapping>, from: Provenance) -> &[Chosen] {
        let from = discriminant(&from);
        let is_it = |one: &Known| Arc::ptr_eq(&one.mapping, mapping) && one.from == from;
        let place = self.place(whose.key());
        let Some((_, known)) = self.known.get_mut(place) else { return &[] };
        match known.iter().position(is_it) {
            Some(place) => known.swap(0, place),
            None => {
                if known.len() >= MAPPINGS {
                    known.clear();
                }
                let chosen = choose(self.lang, &self.select, whose, mapping);
                known.insert(0, Known { mapping: Arc::clone(mapping), from, chosen });
            }
        }
        known.first().map_or(&[], |one| &one.chosen)
    }

    /// Returns the place of a PDO.
    #[inline]
    fn place(&mut self, key: u64) -> usize {
        // Multiplied by 2^64 by the golden ratio, numbers that are close to each other have places of their own.
        let part = (key.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32) as usize % FOUND;
        if let Some(place) = self.found.get(part)
            && self.known.get(*place).is_some_and(|(known, _)| *known == key)
        {
            return *place;
        }
        let place = self.find(key);
        if let Some(found) = self.found.get_mut(part) {
            *found = place;
        }
        place
    }

    fn find(&mut self, key: u64) -> usize {
        if let Some(place) = self.places.get(&key) {
            return *place;
        }
        if self.known.len() >= PDOS {
            self.known.clear();
            self.places.clear();
        }
        self.known.push((key, Vec::new()));
        self.places.insert(key, self.known.len() - 1);
        self.known.len() - 1
    }

    /// The same of a mapping that will not come again: that of a multiplex PDO.
    pub(super) fn choose(&self, whose: Whose, mapping: &Mapping) -> Vec<Chosen> {
        choose(self.lang, &self.select, whose, mapping)
    }
}

fn choose(lang: Lang, select: &Select, whose: Whose, mapping: &Mapping) -> Vec<Chosen> {
    let mut chosen = Vec::new();
    for (place, mapped) in mapping.entries.iter().enumerate().filter(|(_, mapped)| !mapped.dummy) {
        let names = || signal::names(whose.transmit, whose.number, whose.node, mapped);
        if select.is_everything() || select.takes(names().iter().map(String::as_str)) {
            let mut name = Vec::new();
            signal::name(&mut name, lang, mapped);
            let name = String::from_utf8_lossy(&name).into_owned();
            let object = format!("{:04X}:{:02X}", mapped.index, mapped.sub);
            let (mut cell, mut unit_cell) = (Vec::new(), Vec::new());
            csv::cell(&mut cell, name.as_bytes());
            csv::cell(&mut unit_cell, mapped.unit.as_deref().unwrap_or("").as_bytes());
            chosen.push(Chosen { place, name, object, pdo: whose.pdo(), cell, unit_cell, rest: OnceLock::new() });
        }
    }
    chosen
}

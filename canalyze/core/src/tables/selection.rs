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
    /// By [`Whose::key`]; the one used last first.
    known: BTreeMap<u64, Vec<Known>>,
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
        Self { lang, select, known: BTreeMap::new() }
    }

    /// Returns true if all signals are listed.
    pub(super) fn is_everything(&self) -> bool {
        self.select.is_everything()
    }

    /// The signals of a mapping that are listed, in its order; other ones where it is known in another way.
    pub(super) fn of(&mut self, whose: Whose, mapping: &Arc<Mapping>, from: Provenance) -> &[Chosen] {
        let from = discriminant(&from);
        let is_it = |one: &Known| Arc::ptr_eq(&one.mapping, mapping) && one.from == from;
        let key = whose.key();
        if self.known.len() >= PDOS && !self.known.contains_key(&key) {
            self.known.clear();
        }
        let known = self.known.entry(key).or_default();
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

//! The signals of a PDO that are listed, and their names.
//!
//! Found once a mapping, PDO and node, and remembered: nine tenths of a capture's frames ask the same again. Must not:
//! write anything.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::csv;
use crate::bytes::select::Select;
use crate::wire::pdo::mapping::Mapping;
use crate::words::{Lang, signal};

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
}

/// The signals of the mappings seen so far.
#[derive(Debug)]
pub(super) struct Selection {
    lang: Lang,
    select: Select,
    /// The one used last first.
    known: BTreeMap<Whose, Vec<Known>>,
}

#[derive(Debug)]
struct Known {
    mapping: Arc<Mapping>,
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

    /// The signals of a mapping that are listed, in its order.
    pub(super) fn of(&mut self, whose: Whose, mapping: &Arc<Mapping>) -> &[Chosen] {
        let is_it = |one: &Known| Arc::ptr_eq(&one.mapping, mapping);
        if self.known.get(&whose).is_none_or(|known| !known.iter().any(is_it)) {
            let chosen = self.choose(whose, mapping);
            if self.known.len() >= PDOS {
                self.known.clear();
            }
            let known = self.known.entry(whose).or_default();
            if known.len() >= MAPPINGS {
                known.clear();
            }
            known.push(Known { mapping: Arc::clone(mapping), chosen });
        }
        let Some(known) = self.known.get_mut(&whose) else { return &[] };
        if let Some(place) = known.iter().position(is_it) {
            known.swap(0, place);
        }
        known.first().map_or(&[], |one| &one.chosen)
    }

    /// The same of a mapping that will not come again: that of a multiplex PDO.
    pub(super) fn choose(&self, whose: Whose, mapping: &Mapping) -> Vec<Chosen> {
        let mut chosen = Vec::new();
        for (place, mapped) in mapping.entries.iter().enumerate().filter(|(_, mapped)| !mapped.dummy) {
            let names = || signal::names(whose.transmit, whose.number, whose.node, mapped);
            if self.select.is_everything() || self.select.takes(names().iter().map(String::as_str)) {
                let mut name = Vec::new();
                signal::name(&mut name, self.lang, mapped);
                let name = String::from_utf8_lossy(&name).into_owned();
                let object = format!("{:04X}:{:02X}", mapped.index, mapped.sub);
                let (mut cell, mut unit_cell) = (Vec::new(), Vec::new());
                csv::cell(&mut cell, name.as_bytes());
                csv::cell(&mut unit_cell, mapped.unit.as_deref().unwrap_or("").as_bytes());
                chosen.push(Chosen { place, name, object, pdo: whose.pdo(), cell, unit_cell });
            }
        }
        chosen
    }
}

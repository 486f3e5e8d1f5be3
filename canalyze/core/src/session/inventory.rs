//! Objects of devices by what the traffic shows of them: at the end what is known of each, or all that is seen as it
//! comes. Must not: judge.

use std::sync::Arc;

use super::capture::View;
use super::options::Format;
use super::sink::{Passing, Sink};
use crate::bytes::frame::{BusId, Buses};
use crate::bytes::readers::Marker;
use crate::sdo::transfer::Transfer;
use crate::tables::columns::{od, od_nodes, od_values};
use crate::tables::jsonl;
use crate::views::filter::Filter;
use crate::views::inventory::Inventory;
use crate::views::inventory::pdos::PdoInventory as Kept;
use crate::views::inventory::sighting::{self, ObjectSighting};
use crate::words::Lang;
use crate::world::bus::Bus;
use crate::world::event::Event;
use crate::world::network::Network;

/// What is known of each object, at the end.
#[derive(Debug)]
pub(super) struct Objects {
    /// The language of names; `None`: CSV.
    names: Option<Lang>,
    inventory: Inventory,
}

impl Objects {
    pub(super) fn new(format: Format, lang: Lang, inventory: Inventory) -> Self {
        Self { names: names(format, lang), inventory }
    }
}

impl Sink for Objects {
    fn frame(&mut self, _out: &mut Vec<u8>, _view: View<'_>, passing: Passing<'_>, events: &mut Vec<Event>) {
        self.inventory.boot_ups(events);
        if passing.shown {
            self.inventory.frame(passing.frame, events);
        }
    }

    fn transfer(&mut self, _out: &mut Vec<u8>, _view: View<'_>, transfer: &Transfer) -> bool {
        self.inventory.transfer(transfer);
        true
    }

    fn marker(&mut self, _out: &mut Vec<u8>, _view: View<'_>, marker: &Marker) {
        match *marker {
            Marker::Dropped { bus, .. } => self.inventory.lost(Some(bus)),
            Marker::LeftOut { .. } => self.inventory.lost(None),
            _ => {}
        }
    }

    fn gap(&mut self, bus: BusId, _away: bool) {
        self.inventory.lost(Some(bus));
    }

    fn settle(&mut self, state: &[Bus]) {
        self.inventory.settle(state);
    }

    fn finish(&mut self, out: &mut Vec<u8>, view: View<'_>, _shown: u64) {
        match self.names {
            Some(names) => od_nodes::lines(out, view.jsonl, &self.inventory, names),
            None if self.inventory.nodes.is_empty() => {}
            None => od::csv(out, view.jsonl, &self.inventory),
        }
    }
}

/// All that is seen of objects, as it comes.
#[derive(Debug)]
pub(super) struct History {
    /// The language of names; `None`: CSV.
    names: Option<Lang>,
    filter: Filter,
    /// The headings of CSV are written.
    headed: bool,
}

impl History {
    pub(super) fn new(format: Format, lang: Lang, filter: Filter) -> Self {
        Self { names: names(format, lang), filter, headed: false }
    }

    fn write(&mut self, out: &mut Vec<u8>, view: View<'_>, sighting: &ObjectSighting<'_>) {
        if !self.filter.takes_object(sighting.node, sighting.object) {
            return;
        }
        match self.names {
            Some(names) => od_values::line(out, view.jsonl, sighting, names),
            None => {
                if !std::mem::replace(&mut self.headed, true) {
                    od_values::head(out);
                }
                od_values::row(out, view.jsonl, sighting);
            }
        }
    }
}

impl Sink for History {
    fn frame(&mut self, out: &mut Vec<u8>, view: View<'_>, passing: Passing<'_>, events: &mut Vec<Event>) {
        if passing.shown {
            sighting::each(passing.frame, events, &mut |sighting| self.write(out, view, &sighting));
        }
    }

    fn transfer(&mut self, out: &mut Vec<u8>, view: View<'_>, transfer: &Transfer) -> bool {
        if let Some(sighting) = ObjectSighting::of(transfer) {
            self.write(out, view, &sighting);
        }
        true
    }
}

/// The PDOs, at the end.
#[derive(Debug)]
pub(super) struct Pdos {
    filter: Filter,
    kept: Kept,
}

impl Pdos {
    pub(super) fn new(filter: Filter) -> Self {
        Self { filter, kept: Kept::default() }
    }
}

impl Sink for Pdos {
    fn frame(&mut self, _out: &mut Vec<u8>, _view: View<'_>, passing: Passing<'_>, events: &mut Vec<Event>) {
        if passing.shown {
            self.kept.frame(passing.frame, events);
        }
    }

    fn settle(&mut self, state: &[Bus]) {
        for (index, bus) in state.iter().enumerate() {
            self.kept.settle(BusId(index as u8), bus);
        }
    }

    fn finish(&mut self, out: &mut Vec<u8>, view: View<'_>, _shown: u64) {
        self.kept
            .pdos
            .retain(|whose, _| self.filter.takes_identifier(whose.node, whose.id, view.buses.name(whose.bus)));
        jsonl::pdos::write(out, view.buses, &self.kept);
    }
}

/// The lines of [`Format::Pdos`] without a capture: what is known before it of a bus without a name.
pub fn known_pdos(network: &Arc<Network>) -> Vec<u8> {
    let mut kept = Kept::default();
    kept.settle(BusId(0), &Bus::new(Arc::clone(network), b""));
    let mut out = Vec::new();
    jsonl::pdos::write(&mut out, &Buses::default(), &kept);
    out
}

/// The language of names in a format; `None`: it is CSV, which has its own.
fn names(format: Format, lang: Lang) -> Option<Lang> {
    match format {
        Format::ObjectsCsv | Format::HistoryCsv => None,
        Format::ObjectsText | Format::HistoryText => Some(lang),
        _ => Some(jsonl::NAMES),
    }
}

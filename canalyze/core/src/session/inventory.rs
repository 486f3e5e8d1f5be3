//! Outputs about objects of devices and PDOs: as they are seen, or at the end.

use std::sync::Arc;

use super::capture::View;
use super::options::Encoding;
use super::sink::{Notice, Passing, Sink};
use crate::bytes::frame::{BusId, Buses};
use crate::bytes::readers::Marker;
use crate::tables::columns::{od, od_nodes, od_values};
use crate::tables::jsonl;
use crate::views::filter::Filter;
use crate::views::inventory::Inventory;
use crate::views::inventory::pdos::PdoInventory;
use crate::views::inventory::sighting::{self, ObjectSighting};
use crate::words::Lang;
use crate::world::bus::Bus;
use crate::world::event::Event;
use crate::world::network::Network;

/// The objects, at the end.
#[derive(Debug)]
pub(super) struct ObjectRows {
    /// The language of names; `None`: CSV.
    names: Option<Lang>,
    inventory: Inventory,
}

impl ObjectRows {
    pub(super) fn new(encoding: Encoding, lang: Lang, inventory: Inventory) -> Self {
        Self { names: encoding.names(lang), inventory }
    }
}

impl Sink for ObjectRows {
    fn frame(&mut self, _out: &mut Vec<u8>, _view: &View<'_>, passing: &Passing<'_>, events: &mut Vec<Event>) {
        self.inventory.boot_ups(events);
        if passing.shown {
            self.inventory.frame(passing.frame, events);
        }
    }

    fn take(&mut self, out: &mut Vec<u8>, view: &View<'_>, notice: Notice<'_>) {
        match (notice, self.names) {
            (Notice::Transfer(transfer), _) => self.inventory.transfer(transfer),
            (Notice::Marker(Marker::Dropped { bus, .. }), _) => self.inventory.lost(Some(*bus)),
            (Notice::Marker(Marker::LeftOut { .. }), _) => self.inventory.lost(None),
            (Notice::Gap(bus, _), _) => self.inventory.lost(Some(bus)),
            (Notice::Settle(state), _) => self.inventory.settle(state),
            (Notice::Finish(_), Some(names)) => od_nodes::lines(out, view.jsonl, &self.inventory, names),
            (Notice::Finish(_), None) if !self.inventory.nodes.is_empty() => {
                od::csv(out, view.jsonl, &self.inventory);
            }
            _ => {}
        }
    }
}

/// Values of objects as they are seen.
#[derive(Debug)]
pub(super) struct HistoryRows {
    /// The language of names; `None`: CSV.
    names: Option<Lang>,
    filter: Filter,
    /// True once the headings of CSV are written.
    headed: bool,
}

impl HistoryRows {
    pub(super) fn new(encoding: Encoding, lang: Lang, filter: Filter) -> Self {
        Self { names: encoding.names(lang), filter, headed: false }
    }

    fn write(&mut self, out: &mut Vec<u8>, view: &View<'_>, sighting: &ObjectSighting<'_>) {
        if !self.filter.takes_object(sighting.node, sighting.object) {
            return;
        }
        if let Some(names) = self.names {
            return od_values::line(out, view.jsonl, sighting, names);
        }
        if !std::mem::replace(&mut self.headed, true) {
            od_values::head(out);
        }
        od_values::row(out, view.jsonl, sighting);
    }
}

impl Sink for HistoryRows {
    fn frame(&mut self, out: &mut Vec<u8>, view: &View<'_>, passing: &Passing<'_>, events: &mut Vec<Event>) {
        if passing.shown {
            sighting::each(passing.frame, events, &mut |sighting| self.write(out, view, &sighting));
        }
    }

    fn take(&mut self, out: &mut Vec<u8>, view: &View<'_>, notice: Notice<'_>) {
        if let Notice::Transfer(transfer) = notice
            && let Some(sighting) = ObjectSighting::of(transfer)
        {
            self.write(out, view, &sighting);
        }
    }
}

/// The PDOs, at the end.
#[derive(Debug)]
pub(super) struct PdoRows {
    filter: Filter,
    kept: PdoInventory,
}

impl PdoRows {
    pub(super) fn new(filter: Filter) -> Self {
        Self { filter, kept: PdoInventory::default() }
    }
}

impl Sink for PdoRows {
    fn frame(&mut self, _out: &mut Vec<u8>, _view: &View<'_>, passing: &Passing<'_>, events: &mut Vec<Event>) {
        if passing.shown {
            self.kept.frame(passing.frame, events);
        }
    }

    fn take(&mut self, out: &mut Vec<u8>, view: &View<'_>, notice: Notice<'_>) {
        let Self { filter, kept } = self;
        match notice {
            Notice::Settle(state) => {
                let buses = state.iter().enumerate();
                buses.for_each(|(index, bus)| kept.settle(BusId(index as u8), bus));
            }
            Notice::Finish(_) => {
                let buses = view.buses;
                kept.pdos.retain(|whose, _| filter.takes_identifier(whose.node, whose.id, buses.name(whose.bus)));
                jsonl::pdos::write(out, view.buses, kept);
            }
            _ => {}
        }
    }
}

/// Returns the records of [`Rows::Pdos`](super::Rows::Pdos) that are known before a capture, of a bus without a name.
pub fn known_pdos(network: &Arc<Network>) -> Vec<u8> {
    let mut kept = PdoInventory::default();
    kept.settle(BusId(0), &Bus::new(Arc::clone(network), b""));
    let mut out = Vec::new();
    jsonl::pdos::write(&mut out, &Buses::default(), &kept);
    out
}

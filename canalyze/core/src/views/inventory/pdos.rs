//! The PDOs of a capture, for descriptions of its buses in other forms: identifier, content and timing of each.
//!
//! For each PDO on each of its identifiers the mapping of its last frame is kept, unless the capture has shown another
//! one since, with the number of changes. At the end, the knowledge of the nodes is added, also that from before a
//! capture. Mappings are not decided or judged here.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::bytes::frame::{BusId, CanId, Frame};
use crate::bytes::ns::Ns;
use crate::sdo::wire::Mux;
use crate::wire::pdo::mapping::{Mapped, Mapping};
use crate::world::bus::Bus;
use crate::world::configuration::Provenance;
use crate::world::event::{Addressed, Event, ProcessData, Signals, Unmapped, What};
use crate::world::node::{Content, Node};

/// Maximum number of PDOs of all buses that are kept; all nodes of four buses cannot use more.
const MOST: usize = 8192;
/// Maximum number of objects of one multiplex PDO that are kept.
const OBJECTS: usize = 1024;
/// Indices of the object scanner list of a source of multiplex PDOs (CiA 301, 7.5.2.38).
const SCANNER_LIST: std::ops::RangeInclusive<u16> = 0x1FA0..=0x1FCF;
/// The last node-ID.
const LAST_NODE: u8 = 127;

/// A PDO on one of its identifiers: its node, direction and number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct PdoOwner {
    /// The bus.
    pub bus: BusId,
    /// The identifier.
    pub id: CanId,
    /// Sent by the node, or received by it.
    pub transmit: bool,
    /// The node.
    pub node: u8,
    /// The number of the PDO, from 1.
    pub number: u16,
}

/// The object that a multiplex PDO addresses in a node, as its destination or as its source.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Address {
    /// True for the destination, false for the source.
    pub destination: bool,
    /// The node-ID; 0: all nodes.
    pub node: u8,
    /// The object.
    pub object: Mux,
}

/// The known timing of a PDO.
#[derive(Clone, Copy, Debug, Default)]
pub struct Timing {
    /// Transmission type.
    pub transmission: Option<u8>,
    /// In 100 us; 0 = none.
    pub inhibit: Option<u16>,
    /// In ms; 0 = none.
    pub event_timer: Option<u16>,
    /// Period of SYNC in ns.
    pub sync_ns: Option<Ns>,
}

/// The properties of a PDO.
#[derive(Clone, Debug)]
pub struct KnownPdo {
    /// The content of its bytes.
    pub content: Content,
    /// The frames contradict its only known mapping, the default one of an EDS.
    pub contradicted: bool,
    /// Its frames.
    pub frames: u64,
    /// The number of changes of its mapping.
    pub changes: u64,
    /// The timing.
    pub timing: Timing,
    /// The objects of a multiplex PDO, each with its position.
    pub objects: BTreeMap<Address, Mapped>,
    /// The number of objects for which there was no room.
    pub further: u64,
}

impl Default for KnownPdo {
    fn default() -> Self {
        Self {
            content: Content::Unknown,
            contradicted: false,
            frames: 0,
            changes: 0,
            timing: Timing::default(),
            objects: BTreeMap::new(),
            further: 0,
        }
    }
}

impl KnownPdo {
    fn read_by(&mut self, mapping: &Arc<Mapping>, from: Provenance) {
        match &self.content {
            Content::Mapped(known, _) if Arc::ptr_eq(known, mapping) => return,
            Content::Mapped(known, _) => self.changes += u64::from(!is_same(known, mapping)),
            Content::Multiplex { .. } => self.changes += 1,
            Content::Disabled(_) | Content::Unknown => {}
        }
        self.content = Content::Mapped(Arc::clone(mapping), from);
    }

    fn addresses(&mut self, address: Address, mapping: &Mapping) {
        if self.objects.len() >= OBJECTS && !self.objects.contains_key(&address) {
            self.further += 1;
        } else if let Some(mapped) = mapping.entries.first() {
            self.objects.insert(address, mapped.clone());
        }
    }
}

/// Returns true if two mappings decode the same frames to the same values.
fn is_same(one: &Mapping, other: &Mapping) -> bool {
    let words = |mapping: &Mapping| mapping.entries.iter().map(Mapped::word).collect::<Vec<_>>();
    one.bits == other.bits && words(one) == words(other)
}

/// The PDOs of all buses.
#[derive(Debug, Default)]
pub struct PdoInventory {
    /// By bus and identifier.
    pub pdos: BTreeMap<PdoOwner, KnownPdo>,
    /// The number of PDOs for which there was no room.
    pub further: u64,
}

impl PdoInventory {
    /// Takes a frame and its events.
    pub fn frame(&mut self, frame: &Frame, events: &[Event]) {
        for event in events {
            match &event.what {
                What::Pdo(data) => self.process_data(frame, data),
                What::Mpdo(data) => self.multiplexed(frame, data),
                _ => {}
            }
        }
    }

    fn process_data(&mut self, frame: &Frame, data: &ProcessData) {
        let ProcessData { transmit, node, number, .. } = *data;
        let Some(pdo) = self.pdo(PdoOwner { bus: frame.bus, id: frame.id, transmit, node, number }) else { return };
        pdo.frames += 1;
        match &data.content {
            Signals::Mapped(mapping, from) | Signals::ByConsumer(mapping, from, ..) => pdo.read_by(mapping, *from),
            Signals::None(why) => pdo.contradicted = *why == Unmapped::Contradicted,
        }
    }

    fn multiplexed(&mut self, frame: &Frame, data: &Addressed) {
        let Addressed { transmit, node, number, content, from, .. } = *data;
        let Some(pdo) = self.pdo(PdoOwner { bus: frame.bus, id: frame.id, transmit, node, number }) else { return };
        pdo.frames += 1;
        pdo.changes += u64::from(matches!(pdo.content, Content::Mapped(..)));
        pdo.content = Content::Multiplex { destination: content.destination, from };
        let object = Mux { index: content.index, sub: content.sub };
        pdo.addresses(Address { destination: content.destination, node: content.node, object }, &data.mapping);
    }

    /// Takes the knowledge of the nodes of a bus.
    pub fn settle(&mut self, bus: BusId, state: &Bus) {
        let sync_ns = state.sync_period_ns();
        for known in (1..=LAST_NODE).filter_map(|id| state.node(id)) {
            for pdo in known.pdos().iter().filter(|pdo| pdo.cob.0.valid) {
                let whose =
                    PdoOwner { bus, id: pdo.cob.0.id, transmit: pdo.transmit, node: known.id(), number: pdo.number };
                let Some(kept) = self.pdo(whose) else { continue };
                let value = |of: Option<(u16, Provenance)>| of.map(|(value, _)| value);
                kept.timing = Timing {
                    transmission: pdo.transmission.map(|(value, _)| value),
                    inhibit: value(pdo.inhibit),
                    event_timer: value(pdo.event_timer),
                    sync_ns,
                };
                let open = matches!(kept.content, Content::Unknown) && !kept.contradicted;
                match &pdo.content {
                    Content::Mapped(mapping, from) if open || is_shown(*from) => kept.read_by(mapping, *from),
                    content if open => kept.content = content.clone(),
                    _ => {}
                }
                if matches!(kept.content, Content::Multiplex { destination: false, .. }) && pdo.transmit {
                    scanned(known, kept);
                }
            }
        }
    }

    fn pdo(&mut self, whose: PdoOwner) -> Option<&mut KnownPdo> {
        if self.pdos.len() >= MOST && !self.pdos.contains_key(&whose) {
            self.further += 1;
            return None;
        }
        Some(self.pdos.entry(whose).or_default())
    }
}

/// Returns true if the capture has shown it and it is not in doubt since.
fn is_shown(from: Provenance) -> bool {
    from.frame().is_some() && !from.is_doubted()
}

/// Adds the blocks of sub-indices in the object scanner list of a source.
fn scanned(node: &Node, pdo: &mut KnownPdo) {
    for (list, entry) in SCANNER_LIST.flat_map(|list| (1..=0xFE).map(move |entry| (list, entry))) {
        let Some((word, _)) = node.value(list, entry) else { continue };
        let [sub, low, high, count, ..] = word.to_le_bytes();
        let index = u16::from_le_bytes([low, high]);
        for sub in (sub..=u8::MAX).take(usize::from(count)) {
            let address = Address { destination: false, node: node.id(), object: Mux { index, sub } };
            pdo.addresses(address, &node.multiplexed(index, sub));
        }
    }
}

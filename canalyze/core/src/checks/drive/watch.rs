//! The identifiers that carry a drive's objects: testing one bit skips all other PDOs.
//!
//! Several nodes may receive one identifier, so it is listed for each of them. Changes of the configuration are applied
//! with the next PDO.

use std::collections::{BTreeMap, BTreeSet};

use crate::bytes::frame::CanId;
use crate::checks::PdoName;
use crate::wire::pdo::mapping::Mapping;
use crate::words::profiles::Profile;
use crate::world::drive::{self, DriveObject};
use crate::world::node::{Content, Node, Pdo, PerNode};
use crate::world::od::DataType;

/// An object of a drive in a PDO.
#[derive(Clone, Copy, Debug)]
pub(super) struct DrivePart {
    /// The logical device.
    pub(super) axis: u8,
    /// The object.
    pub(super) object: DriveObject,
    /// Its first bit.
    pub(super) offset: u16,
    /// Its length in bits.
    pub(super) bits: u8,
}

/// A PDO that carries objects of a drive.
#[derive(Clone, Debug)]
pub(super) struct WatchedPdo {
    /// The drive.
    pub(super) node: u8,
    /// True for its TPDO, false for its RPDO.
    pub(super) transmit: bool,
    /// PDO number.
    pub(super) number: u16,
    /// The drive's objects in it; empty for an RPDO of unknown content.
    pub(super) objects: Vec<DrivePart>,
}

/// Maximum number of PDOs evaluated per identifier (invariant 6), far above what nodes share.
const SHARED: usize = 1024;

/// The key of a PDO, sorted by node: node, transmit or receive, number.
type WatchKey = (u8, bool, u16);

/// The identifiers of a bus.
#[derive(Debug, Default)]
pub(super) struct Watch {
    /// The PDOs of each 11-bit identifier; empty while there are none.
    standard: Vec<Vec<WatchedPdo>>,
    extended: BTreeMap<CanId, Vec<WatchedPdo>>,
    /// The identifier of each PDO.
    ids: BTreeMap<WatchKey, CanId>,
    /// PDOs whose configuration has changed.
    stale: BTreeSet<WatchKey>,
}

impl WatchedPdo {
    fn name(&self) -> WatchKey {
        (self.node, self.transmit, self.number)
    }
}

impl Watch {
    /// Marks PDOs whose configuration has changed.
    pub(super) fn renewed(&mut self, pdos: &[PdoName]) {
        self.stale.extend(pdos.iter().map(|pdo| (pdo.node, pdo.transmit, pdo.number)));
    }

    /// Returns the PDOs of an identifier that carry an object of a drive.
    #[inline]
    pub(super) fn of(&mut self, id: CanId, nodes: &PerNode<Node>) -> &[WatchedPdo] {
        if !self.stale.is_empty() {
            self.compile(nodes);
        }
        let all = if id.is_extended() { self.extended.get(&id) } else { self.standard.get(id.raw() as usize) };
        let all = all.map_or(&[][..], Vec::as_slice);
        all.get(..SHARED).unwrap_or(all)
    }

    /// Returns the place for those of an identifier.
    fn place(&mut self, id: CanId) -> Option<&mut Vec<WatchedPdo>> {
        if id.is_extended() {
            return Some(self.extended.entry(id).or_default());
        }
        if self.standard.is_empty() {
            self.standard.resize(1 << 11, Vec::new());
        }
        self.standard.get_mut(id.raw() as usize)
    }

    #[cold]
    fn compile(&mut self, nodes: &PerNode<Node>) {
        for name in std::mem::take(&mut self.stale) {
            let (node, transmit, number) = name;
            if let Some(id) = self.ids.remove(&name) {
                self.remove(id, name);
            }
            let pdo = nodes.get(node).and_then(|node| node.pdo(transmit, number));
            if let Some(objects) = pdo.and_then(carried) {
                let id = pdo.map_or(CanId::standard(0), |pdo| pdo.cob.0.id);
                self.ids.insert(name, id);
                self.insert(id, WatchedPdo { node, transmit, number, objects });
            }
        }
    }

    fn remove(&mut self, id: CanId, name: WatchKey) {
        let Some(all) = self.place(id) else { return };
        if let Ok(place) = all.binary_search_by_key(&name, WatchedPdo::name) {
            all.remove(place);
        }
        if all.is_empty() {
            self.extended.remove(&id);
        }
    }

    fn insert(&mut self, id: CanId, watched: WatchedPdo) {
        let Some(all) = self.place(id) else { return };
        let place = all.partition_point(|one| one.name() < watched.name());
        all.insert(place, watched);
    }
}

/// Returns the drive's objects in a PDO; `None` if it is not evaluated.
fn carried(pdo: &Pdo) -> Option<Vec<DrivePart>> {
    let objects = match &pdo.content {
        Content::Mapped(mapping, from) if !from.is_doubted() => {
            Some(parts(mapping)).filter(|parts| !parts.is_empty())?
        }
        Content::Disabled(_) => return None,
        // A remapping in progress or missed, or a multiplex PDO.
        _ if pdo.transmit => return None,
        _ => Vec::new(),
    };
    pdo.cob.0.valid.then_some(objects)
}

/// Returns the drive's objects in a mapping that have the size of their type.
fn parts(mapping: &Mapping) -> Vec<DrivePart> {
    let entries = mapping.entries.iter().filter_map(|entry| {
        let (axis, object) = (drive::axis(entry.index)?, DriveObject::at(entry.index).filter(|_| entry.sub == 0)?);
        let size = Profile::DRIVE.data_type(entry.index, 0).and_then(DataType::size)?;
        let fits = entry.data_type.and_then(DataType::size) == Some(size) && usize::from(entry.bits) == 8 * size;
        fits.then_some(DrivePart { axis, object, offset: entry.offset, bits: entry.bits })
    });
    entries.collect()
}

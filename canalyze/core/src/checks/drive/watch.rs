//! Which identifiers carry a drive's objects: one test of a bit for every PDO that carries none.
//!
//! An identifier is looked at for every node whose PDO it is: several may receive the same one. Compiled again with the
//! first PDO after a configuration has changed. It must not look at data.

use std::collections::BTreeMap;

use crate::drive::{self, Object};
use crate::frame::CanId;
use crate::node::{Content, Node, PerNode};
use crate::od::{self, DataType};
use crate::services::pdo::mapping::Mapping;

/// An object of a drive in a PDO.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    /// The logical device.
    pub(super) axis: u8,
    /// What it is.
    pub(super) object: Object,
    /// Its first bit.
    pub(super) offset: u16,
    /// Its length in bits.
    pub(super) bits: u8,
}

/// A PDO that carries objects of a drive.
#[derive(Clone, Debug)]
pub(super) struct Watched {
    /// The drive.
    pub(super) node: u8,
    /// Its TPDO, else its RPDO.
    pub(super) transmit: bool,
    /// PDO number.
    pub(super) number: u16,
    /// What of the drive it carries. Nothing: an RPDO of which not known what it carries.
    pub(super) objects: Vec<Part>,
}

/// The identifiers of a bus.
#[derive(Debug, Default)]
pub(super) struct Watch {
    standard: [u64; 32],
    pdos: BTreeMap<CanId, Vec<Watched>>,
    compiled: bool,
}

impl Watch {
    /// The configuration of some node is another one now.
    pub(super) fn reconfigured(&mut self) {
        self.compiled = false;
    }

    /// Whether an identifier carries anything of a drive.
    #[inline]
    pub(super) fn holds(&mut self, id: CanId, nodes: &PerNode<Node>) -> bool {
        if !self.compiled {
            self.compile(nodes);
        }
        if id.is_extended() {
            return self.pdos.contains_key(&id);
        }
        let raw = id.raw() as usize;
        self.standard.get(raw / 64).is_some_and(|bits| bits >> (raw % 64) & 1 != 0)
    }

    /// The PDOs of an identifier.
    pub(super) fn of(&self, id: CanId) -> &[Watched] {
        self.pdos.get(&id).map_or(&[], Vec::as_slice)
    }

    #[cold]
    fn compile(&mut self, nodes: &PerNode<Node>) {
        *self = Self { compiled: true, ..Self::default() };
        for (id, node) in nodes.iter() {
            for pdo in node.pdos() {
                let objects = match &pdo.content {
                    Content::Mapped(mapping, from) if !from.is_doubted() => parts(mapping),
                    Content::Disabled(_) => continue,
                    // A remapping under way or missed, or a multiplex PDO.
                    _ if pdo.transmit => continue,
                    _ => Vec::new(),
                };
                let mapped = matches!(&pdo.content, Content::Mapped(_, from) if !from.is_doubted());
                let (cob, _) = pdo.cob;
                if !cob.valid || (mapped && objects.is_empty()) {
                    continue;
                }
                let (transmit, number) = (pdo.transmit, pdo.number);
                self.pdos.entry(cob.id).or_default().push(Watched { node: id, transmit, number, objects });
                if !cob.id.is_extended()
                    && let Some(bits) = self.standard.get_mut(cob.id.raw() as usize / 64)
                {
                    *bits |= 1 << (cob.id.raw() % 64);
                }
            }
        }
    }
}

/// The objects of a drive in a mapping that have their type's size.
fn parts(mapping: &Mapping) -> Vec<Part> {
    let entries = mapping.entries.iter().filter_map(|entry| {
        let (axis, object) = (drive::axis(entry.index)?, Object::at(entry.index).filter(|_| entry.sub == 0)?);
        let size = od::data_type(entry.index, 0).and_then(DataType::size)?;
        let fits = entry.data_type.and_then(DataType::size) == Some(size) && usize::from(entry.bits) == 8 * size;
        fits.then_some(Part { axis, object, offset: entry.offset, bits: entry.bits })
    });
    entries.collect()
}

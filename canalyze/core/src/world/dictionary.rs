//! A device description (EDS, DCF) as a flat table: what Python's reader hands over, once a file.
//!
//! `$NODEID` stays unresolved, so that one table serves every node that carries the description, and a node whose
//! ID is changed. It must not know how descriptions are written, nor what any object means.

use std::sync::Arc;

use crate::words::profiles::Profile;
use crate::world::od::DataType;

/// What kind of file it was: what a DCF configures counts more than what an EDS presets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Electronic data sheet: a type of device.
    Eds,
    /// Device configuration file: one device in one network.
    Dcf,
}

/// Access to an object, as seen from the bus (CiA 306).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Read only.
    Ro,
    /// Write only.
    Wo,
    /// Read and write; rwr and rww, which restrict only the mapping, are the same to SDO.
    Rw,
    /// Read only, never changing.
    Const,
}

impl Access {
    /// The access that a word of a description stands for.
    pub fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "ro" => Self::Ro,
            "wo" => Self::Wo,
            "rw" | "rwr" | "rww" => Self::Rw,
            "const" => Self::Const,
            _ => return None,
        })
    }

    /// The word of a description.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ro => "ro",
            Self::Wo => "wo",
            Self::Rw => "rw",
            Self::Const => "const",
        }
    }

    /// Whether an upload must be refused.
    pub fn is_readable(self) -> bool {
        self != Self::Wo
    }

    /// Whether a download may be accepted.
    pub fn is_writable(self) -> bool {
        matches!(self, Self::Wo | Self::Rw)
    }
}

/// A number that a description gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Preset {
    /// The number; two's complement where it is negative.
    pub value: u64,
    /// The node-ID is to be added.
    pub relative: bool,
    /// It is a DCF's ParameterValue, not a default.
    pub configured: bool,
}

impl Object {
    /// Its data type, where it is a static one.
    pub fn data_type(&self) -> Option<DataType> {
        DataType::from_code(self.data_type)
    }

    /// Whether another description says the same of what it is and how its value is read.
    pub fn is_alike(&self, other: &Self) -> bool {
        (&self.name, self.data_type, &self.unit) == (&other.name, other.data_type, &other.unit)
            && self.factor == other.factor
    }

    /// The number that the object starts with on one node; relative ones wrap around at the type's width.
    pub fn preset_at(&self, node: u8) -> Option<u64> {
        let Preset { value, relative, .. } = self.preset?;
        if !relative {
            return Some(value);
        }
        let bits = self.data_type().and_then(DataType::size).map_or(64, |bytes| 8 * bytes as u32);
        Some(value.wrapping_add(u64::from(node)) & u64::MAX >> (64 - bits.clamp(1, 64)))
    }
}

/// One sub-object, or an object that is a single variable (sub-index 0).
#[derive(Clone, Debug)]
pub struct Object {
    /// Index.
    pub index: u16,
    /// Sub-index.
    pub sub: u8,
    /// The vendor's name.
    pub name: Arc<str>,
    /// Data type code (CiA 301, 7.4.7); 0 where the file has none.
    pub data_type: u16,
    /// Access.
    pub access: Access,
    /// What the device starts with, where it is a whole number.
    pub preset: Option<Preset>,
    /// It may be mapped into a PDO.
    pub mappable: bool,
    /// Unit, where the file has one.
    pub unit: Option<Arc<str>>,
    /// What a raw value is multiplied by; 1 by default.
    pub factor: f64,
}

/// A device description.
#[derive(Clone, Debug)]
pub struct Dictionary {
    /// The file's name, for messages.
    pub file: String,
    /// What kind of file.
    pub form: Form,
    /// The product's name; empty where the file has none.
    pub device: String,
    objects: Vec<Arc<Object>>,
}

impl Dictionary {
    /// A description of these objects, in any order; of two with the same address the first counts.
    pub fn new(file: String, form: Form, device: String, mut objects: Vec<Object>) -> Self {
        objects.sort_by_key(|object| (object.index, object.sub));
        objects.dedup_by_key(|object| (object.index, object.sub));
        Self { file, form, device, objects: objects.into_iter().map(Arc::new).collect() }
    }

    /// One object.
    pub fn get(&self, index: u16, sub: u8) -> Option<&Arc<Object>> {
        let found = self.objects.binary_search_by_key(&(index, sub), |object| (object.index, object.sub));
        found.ok().and_then(|place| self.objects.get(place))
    }

    /// The sub-objects of an index, ascending.
    pub fn of(&self, index: u16) -> &[Arc<Object>] {
        let from = self.objects.partition_point(|object| object.index < index);
        let to = self.objects.partition_point(|object| object.index <= index);
        self.objects.get(from..to).unwrap_or(&[])
    }

    /// The objects of several indices, ascending.
    pub fn within(&self, indices: std::ops::RangeInclusive<u16>) -> &[Arc<Object>] {
        let from = self.objects.partition_point(|object| object.index < *indices.start());
        let to = self.objects.partition_point(|object| object.index <= *indices.end());
        self.objects.get(from..to).unwrap_or(&[])
    }

    /// Whether it has any sub-index of an index.
    pub fn has(&self, index: u16) -> bool {
        let place = self.objects.partition_point(|object| object.index < index);
        self.objects.get(place).is_some_and(|object| object.index == index)
    }

    /// All objects, ascending.
    pub fn objects(&self) -> &[Arc<Object>] {
        &self.objects
    }
}

/// What is known of an object that a server is asked for.
#[derive(Clone, Debug, Default)]
pub struct Described {
    /// What the server's description says of it: this wins.
    pub object: Option<Arc<Object>>,
    /// The server's device profile.
    pub profile: Profile,
}

impl Described {
    /// Its data type: the description's, else the standard's.
    pub fn data_type(&self, index: u16, sub: u8) -> Option<DataType> {
        match &self.object {
            Some(object) => object.data_type(),
            None => self.profile.data_type(index, sub),
        }
    }
}

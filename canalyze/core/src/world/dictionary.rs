//! A device description (EDS, DCF) as a flat table, which the reader of `description` makes once a file.
//!
//! `$NODEID` stays unresolved, so that one table serves every node with the description, and a node whose ID changes.
//! The syntax of descriptions and the meaning of objects are not known here.

use std::sync::Arc;

use crate::words::profiles::Profile;
use crate::world::od::DataType;

/// The kind of file: the configuration of a DCF takes precedence over the presets of an EDS.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Electronic data sheet: a type of device.
    Eds,
    /// Device configuration file: one device in one network.
    Dcf,
}

impl Form {
    /// The kinds of file by their names.
    pub const NAMES: &[(&str, Self)] =
        &[("eds", Self::Eds), ("dcf", Self::Dcf), ("xdd", Self::Eds), ("concise", Self::Dcf)];
}

/// A row of a description: index, sub-index, name, type, access, value, relative to the node-ID, configured by a DCF,
/// mappable, unit, factor.
pub type ObjectRow = (u16, u8, String, u16, String, Option<i128>, bool, bool, bool, String, f64);

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
    /// Returns the access for a word of a description.
    pub fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "ro" => Self::Ro,
            "wo" => Self::Wo,
            "rw" | "rwr" | "rww" => Self::Rw,
            "const" => Self::Const,
            _ => return None,
        })
    }

    /// Returns the word of a description.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ro => "ro",
            Self::Wo => "wo",
            Self::Rw => "rw",
            Self::Const => "const",
        }
    }

    /// Returns true if an upload is permitted.
    pub fn is_readable(self) -> bool {
        self != Self::Wo
    }

    /// Returns true if a download is permitted.
    pub fn is_writable(self) -> bool {
        matches!(self, Self::Wo | Self::Rw)
    }
}

/// A number in a description.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Preset {
    /// The number; two's complement if it is negative.
    pub value: u64,
    /// The node-ID has to be added.
    pub relative: bool,
    /// It is a DCF's ParameterValue, not a default.
    pub configured: bool,
}

impl Preset {
    /// Creates a preset of a number that a file has: as many bits of it as its type has, at most 64.
    pub fn new(value: i128, data_type: u16, relative: bool, configured: bool) -> Self {
        let bits = DataType::from_code(data_type).and_then(DataType::bits).unwrap_or(64);
        let mask = u64::MAX >> (64 - u32::from(bits.clamp(1, 64)));
        Self { value: value as u64 & mask, relative, configured }
    }
}

impl Object {
    /// Returns the object of a row, or its access if that is unknown.
    pub fn from_row(row: ObjectRow) -> Result<Self, String> {
        let (index, sub, name, data_type, access, value, relative, configured, mappable, unit, factor) = row;
        let access = Access::from_name(&access).ok_or(access)?;
        let preset = value.map(|value| Preset::new(value, data_type, relative, configured));
        let unit = (!unit.is_empty()).then(|| Arc::from(unit));
        Ok(Self { index, sub, name: Arc::from(name), data_type, access, preset, mappable, unit, factor })
    }

    /// Its data type, if it is a static one.
    pub fn data_type(&self) -> Option<DataType> {
        DataType::from_code(self.data_type)
    }

    /// Returns true if another description has the same type and the same interpretation of values.
    pub fn is_alike(&self, other: &Self) -> bool {
        (&self.name, self.data_type, &self.unit) == (&other.name, other.data_type, &other.unit)
            && self.factor == other.factor
    }

    /// Returns the initial number of the object on one node; relative ones wrap around at the type's width.
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
    /// The manufacturer's name.
    pub name: Arc<str>,
    /// Data type code (CiA 301, 7.4.7); 0 if the file has none.
    pub data_type: u16,
    /// Access.
    pub access: Access,
    /// The initial value, if it is a whole number.
    pub preset: Option<Preset>,
    /// It may be mapped into a PDO.
    pub mappable: bool,
    /// Unit, if the file has one.
    pub unit: Option<Arc<str>>,
    /// Factor of raw values; 1 by default.
    pub factor: f64,
}

/// A device description.
#[derive(Clone, Debug)]
pub struct Dictionary {
    /// The file's name, for messages.
    pub file: String,
    /// The kind of file.
    pub form: Form,
    /// The product's name; empty if the file has none.
    pub device: String,
    /// True if it may hold values that were configured, not only defaults.
    pub configures: bool,
    objects: Vec<Arc<Object>>,
}

impl Dictionary {
    /// Creates a description of these objects, in any order; of two with the same address the first one counts.
    pub fn new(file: String, form: Form, device: String, mut objects: Vec<Object>) -> Self {
        objects.sort_by_key(|object| (object.index, object.sub));
        objects.dedup_by_key(|object| (object.index, object.sub));
        let configured = |object: &Object| object.preset.is_some_and(|preset| preset.configured);
        let configures = form == Form::Dcf || objects.iter().any(configured);
        Self { file, form, device, configures, objects: objects.into_iter().map(Arc::new).collect() }
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

    /// Returns true if it has any sub-index of an index.
    pub fn has(&self, index: u16) -> bool {
        let place = self.objects.partition_point(|object| object.index < index);
        self.objects.get(place).is_some_and(|object| object.index == index)
    }

    /// All objects, ascending.
    pub fn objects(&self) -> &[Arc<Object>] {
        &self.objects
    }
}

/// The knowledge of an object of a server.
#[derive(Clone, Debug, Default)]
pub struct Described {
    /// The object in the server's description, which takes precedence.
    pub object: Option<Arc<Object>>,
    /// The server's device profile.
    pub profile: Profile,
    /// The data type that the frames of the transfer name, as USDO does.
    pub told: Option<DataType>,
}

impl Described {
    /// Its data type: the description's, else the standard's, else that of the frames.
    pub fn data_type(&self, index: u16, sub: u8) -> Option<DataType> {
        match &self.object {
            Some(object) => object.data_type(),
            None => self.profile.data_type(index, sub).or(self.told),
        }
    }
}

//! Device profiles (CiA 4xx): the objects in 6000h-9FFFh of a device, their types and names, and the meanings of its
//! emergency error codes. Each profile is a table in `words/`.
//!
//! The tables hold only what is certain; everything else keeps its number. A name of the device's own description wins:
//! that is the caller's part. The profile of a node comes from its device type (1000h), else from its PDOs. Frames are not looked at here.

use Shape::{Array, Own, Record, Var};

use crate::world::od::DataType::{
    Boolean, Integer8, Integer16, Integer24, Integer32, Real32, TimeOfDay, Unsigned8, Unsigned16, Unsigned32,
    Unsigned64, VisibleString,
};
use crate::world::od::{self, DataType};

/// An object: its index, its shape, its name in Chinese and English, the parts of a record.
type ProfileObject = (u16, Shape, &'static str, &'static str, &'static [SubIndexName]);
/// A sub-index with a name of its own.
type SubIndexName = (u8, DataType, &'static str, &'static str);
/// A kind of quantity: the profile, its first and last object.
type QuantityRange = (u16, u16, u16, &'static str);
/// An emergency error code. A row whose low byte is 00 applies to the whole high byte, as in CiA 301.
type EmergencyCode = (u16, &'static str, &'static str);

static CIA401: &[ProfileObject] = words!("cia401");
static CIA402: &[ProfileObject] = words!("cia402");
static CIA404: &[ProfileObject] = words!("cia404");
static CIA406: &[ProfileObject] = words!("cia406");
static CIA410: &[ProfileObject] = words!("cia410");
static CIA418: &[ProfileObject] = words!("cia418");
static CIA419: &[ProfileObject] = words!("cia419");
static CIA401_EMCY: &[EmergencyCode] = words!("cia401_emcy");
static CIA402_EMCY: &[EmergencyCode] = words!("cia402_emcy");
static KINDS: &[QuantityRange] = words!("quantities");

/// The structure of an object.
#[derive(Clone, Copy, Debug)]
enum Shape {
    /// A variable.
    Var(DataType),
    /// An array: sub-index 0 counts elements of one type.
    Array(DataType),
    /// A record: sub-index 0 counts parts of different types.
    Record,
    /// Known by name only: the manufacturer defines its types.
    Own,
}

/// A device profile by its number; 0 if it is unknown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Profile(u16);

/// Objects that a drive uses differently from other devices: named only if the device is known to be a drive.
const AMBIGUOUS: [std::ops::RangeInclusive<u16>; 3] = [0x6050..=0x6059, 0x6400..=0x64FF, 0x6503..=0x67FF];

impl Profile {
    /// Nothing is known of the device, or it has several profiles.
    pub const UNKNOWN: Self = Self(0);
    /// CiA 401: digital and analogue inputs and outputs.
    pub const IO: Self = Self(401);
    /// CiA 402: drives.
    pub const DRIVE: Self = Self(402);

    /// The profiles with tables of objects.
    pub const KNOWN: [Self; 7] = [Self(401), Self(402), Self(404), Self(406), Self(410), Self(418), Self(419)];

    /// Returns the profile of a device type (1000h); [`Self::UNKNOWN`] if it names none (0) or has several logical
    /// devices (FFFFh), whose profiles are in other objects.
    pub const fn of(device_type: u32) -> Self {
        match device_type as u16 {
            0 | 0xFFFF => Self::UNKNOWN,
            number => Self(number),
        }
    }

    /// Its number, 0 if it is unknown.
    pub const fn number(self) -> u16 {
        self.0
    }

    /// Returns true if its objects are read as those of a drive: it is a drive, or its profile is unknown.
    pub const fn may_be_drive(self) -> bool {
        matches!(self.0, 0 | 402)
    }

    /// The index in the profile's table. The eight logical devices of a drive share their objects.
    const fn home(self, index: u16) -> u16 {
        if self.may_be_drive() { od::first_axis(index) } else { index }
    }

    fn object(self, index: u16) -> Option<&'static ProfileObject> {
        let index = self.home(index);
        let table = match self.0 {
            0 if AMBIGUOUS.iter().any(|range| range.contains(&index)) => return None,
            0 | 402 => CIA402,
            401 => CIA401,
            404 => CIA404,
            406 => CIA406,
            410 => CIA410,
            418 => CIA418,
            419 => CIA419,
            _ => return None,
        };
        table.binary_search_by_key(&index, |row| row.0).ok().and_then(|place| table.get(place))
    }

    /// The data type of an object: in 1000h-1FFFh by CiA 301, 302 and 304, in 6000h-9FFFh by the profile.
    pub fn data_type(self, index: u16, sub: u8) -> Option<DataType> {
        if !(0x6000..=0x9FFF).contains(&index) {
            return od::communication(index, sub);
        }
        let (_, shape, .., parts) = self.object(index)?;
        match (*shape, sub) {
            (Var(data_type), 0) | (Array(data_type), 1..=0xFE) => Some(data_type),
            (Array(_) | Record, 0) => Some(Unsigned8),
            _ => parts.iter().find(|part| part.0 == sub).map(|part| part.1),
        }
    }

    /// The name of an object of 6000h-9FFFh or of one of its sub-indices, in Chinese and English. A sub-index without a
    /// name of its own has the object's.
    pub fn name(self, index: u16, sub: u8) -> Option<(&'static str, &'static str)> {
        let (_, _, zh, en, parts) = self.object(index)?;
        let part = parts.iter().find(|part| part.0 == sub);
        Some(part.map_or((zh, en), |part| (part.2, part.3)))
    }

    /// The kind of quantity that an object holds, in machine words; signals of one kind share a plot. `None` if it is
    /// unknown.
    pub fn kind(self, index: u16) -> Option<&'static str> {
        let (_, _, _, name, _) = self.object(index)?;
        let profile = match self.0 {
            0 | 402 => 402,
            401 => 401,
            _ => return Some(name),
        };
        let index = self.home(index);
        KINDS.iter().find(|row| row.0 == profile && (row.1..=row.2).contains(&index)).map(|row| row.3)
    }

    /// Returns true if a number is read as bits rather than as a quantity: control and status words, error codes, the
    /// inputs and outputs of a module.
    pub fn is_bit_field(self, index: u16, sub: u8) -> bool {
        if index < 0x6000 {
            return od::is_bit_field(index, sub);
        }
        match self.0 {
            0 | 402 => matches!(od::first_axis(index), 0x603F | 0x6040 | 0x6041 | 0x6502),
            401 => sub > 0 && matches!(index, 0x6000..=0x63FF) && self.data_type(index, sub) != Some(Boolean),
            406 => matches!(index, 0x6000 | 0x6500 | 0x6503..=0x6506),
            _ => false,
        }
    }

    /// The meaning of an emergency error code by the profile: that of the code itself, else that of the class of codes
    /// to which it belongs.
    pub fn emergency(self, code: u16) -> Option<(&'static str, &'static str)> {
        let table = self.emergencies();
        let of = |code| table.binary_search_by_key(&code, |row| row.0).ok().and_then(|place| table.get(place));
        of(code).or_else(|| of(code & 0xFFF0)).or_else(|| of(code & 0xFF00)).map(|row| (row.1, row.2))
    }

    const fn emergencies(self) -> &'static [EmergencyCode] {
        match self.0 {
            401 => CIA401_EMCY,
            402 => CIA402_EMCY,
            _ => &[],
        }
    }
}

#[cfg(test)]
mod tests;

//! The objects of devices, as far as traffic shows them: an object dictionary by node, for devices whose EDS is lost.
//!
//! Every SDO transfer, every signal of a PDO and every EMCY shows something of an object ([`sighting`]). Figures and
//! the last value of each object are kept, so that memory depends on the number of objects and not on the length of the
//! capture; objects beyond [`MOST`] are counted. Names and types are determined at the end, when all is known of the
//! device. Transfers are not judged here, mappings are not decided, and no words are written.

mod inferred;
mod measured;
pub mod pdos;
pub mod sighting;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};

use self::inferred::Looks;
pub use self::measured::{MeasuredObject, PdoFrames};
use self::sighting::{Content, ObjectSighting, Shown, Source};
use crate::bytes::frame::{BusId, CanId, Frame, FrameRef};
use crate::sdo::transfer::{Abort, Direction, Transfer};
use crate::sdo::wire::Mux;
use crate::views::filter::Filter;
use crate::words::profiles::Profile;
use crate::world::bus::Bus;
use crate::world::change::Change;
use crate::world::configuration::{self, KnownValue};
use crate::world::dictionary::Described;
use crate::world::drive;
use crate::world::event::{Event, What};
use crate::world::od::{self, DataType};

/// Maximum number of objects of all nodes that are kept; more than all devices of a bus have together.
pub const MOST: usize = 131_072;
/// Maximum number of bytes of a value that are kept.
pub const KEPT: usize = 4096;
/// Maximum number of different aborts of one object that are kept.
const ABORTS: usize = 16;
/// Abort codes that refuse the access itself: the object cannot be read, or not be written.
const WRITE_ONLY: u32 = 0x0601_0001;
const READ_ONLY: u32 = 0x0601_0002;
/// Abort codes for a missing object or sub-index.
const ABSENT: [u32; 2] = [0x0602_0000, 0x0609_0011];
/// Upper halves of abort codes that imply an existing object: about its access, mapping, length or range.
const PRESENT: [u32; 4] = [0x0601, 0x0604, 0x0607, 0x0609];

/// The source of an object's type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TypeFrom {
    /// The description of the device.
    Eds,
    /// The standard: 1000h to 1FFFh.
    Standard,
    /// The device profile that the device reports or whose objects its PDOs carry.
    Profile,
    /// The size of its values, and the values.
    Inferred,
}

impl TypeFrom {
    /// The word in machine output.
    pub fn name(self) -> &'static str {
        match self {
            Self::Eds => "eds",
            Self::Standard => "standard",
            Self::Profile => "profile",
            Self::Inferred => "inferred",
        }
    }
}

/// A value as seen.
#[derive(Clone, Debug)]
pub enum SeenValue {
    /// The first bytes of a value, at most [`KEPT`], and its size in bytes.
    Bytes(Vec<u8>, u64),
    /// Bits of a PDO, the first lowest, and their number.
    Bits(u64, u8),
}

/// A value and its origin.
#[derive(Clone, Debug)]
pub struct HeldValue {
    /// The value.
    pub value: SeenValue,
    /// The service that carried it.
    pub source: Source,
    /// The frame that completed it.
    pub at: FrameRef,
}

impl HeldValue {
    /// The value as seen.
    pub fn content(&self) -> Content<'_> {
        match &self.value {
            SeenValue::Bytes(kept, size) => Content::Bytes(kept, *size),
            SeenValue::Bits(raw, bits) => Content::Bits(*raw, *bits),
        }
    }
}

/// The value of an object that is in force by all that is known; after a reset it may differ from the last value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InForce {
    /// The object does not influence decoding and is not followed.
    #[default]
    Unfollowed,
    /// It is unknown, or no longer known.
    Unknown,
    /// This.
    Value(KnownValue),
}

/// Requests with the same abort.
#[derive(Clone, Copy, Debug)]
pub struct Aborted {
    /// Read or written.
    pub direction: Direction,
    /// The code and its sender.
    pub abort: Abort,
    /// The number of requests.
    pub count: u64,
    /// The last one.
    pub at: FrameRef,
}

/// The observations of one object.
#[derive(Clone, Debug)]
pub struct ObservedObject {
    /// The number of sightings by [`Source`].
    counts: [u64; Source::ALL.len()],
    /// The first frame that shows something of it.
    pub first: FrameRef,
    /// The last frame.
    pub last: FrameRef,
    /// Its last value.
    pub value: Option<HeldValue>,
    /// The last value that was written and accepted.
    written: Option<HeldValue>,
    /// Two of its values differ, although nothing was written in between.
    pub varies: bool,
    /// The value of the last unanswered write, if no value was seen since.
    pub requested: Option<HeldValue>,
    /// Aborted requests by code, in the order of first occurrences.
    pub aborted: Vec<Aborted>,
    /// Properties by SDO that a description may define otherwise.
    pub measured: MeasuredObject,
    looks: Looks,
    /// Its description and profile; known from [`Inventory::settle`] on.
    pub described: Described,
    /// The value in force; known from [`Inventory::settle`] on.
    pub in_force: InForce,
}

impl ObservedObject {
    fn new(at: FrameRef) -> Self {
        Self {
            counts: [0; Source::ALL.len()],
            first: at,
            last: at,
            value: None,
            written: None,
            varies: false,
            requested: None,
            aborted: Vec::new(),
            measured: MeasuredObject::default(),
            looks: Looks::default(),
            described: Described::default(),
            in_force: InForce::default(),
        }
    }

    /// Returns the number of sightings by a source.
    pub fn count(&self, source: Source) -> u64 {
        self.counts.get(source as usize).copied().unwrap_or(0)
    }

    /// Returns the number of values that were seen.
    pub fn values(&self) -> u64 {
        Source::ALL.iter().filter(|source| source.is_value()).map(|source| self.count(*source)).sum()
    }

    /// Returns its size in bits, if a value was seen: the size in SDO transfers, else the mapped size.
    pub fn bits(&self) -> Option<u64> {
        self.looks.bits()
    }

    /// Returns true if it can be read, as far as the capture shows: it was read, or a PDO of the device carries it.
    pub fn is_readable(&self) -> Option<bool> {
        let shown = self.count(Source::Read) + self.count(Source::Tpdo) > 0;
        self.permits(shown, Direction::Upload, WRITE_ONLY)
    }

    /// Returns true if it can be written, as far as the capture shows: it was written, or a PDO to the device carries
    /// it.
    pub fn is_writable(&self) -> Option<bool> {
        let shown = self.count(Source::Written) + self.count(Source::Rpdo) > 0;
        self.permits(shown, Direction::Download, READ_ONLY)
    }

    /// Returns whether an access is permitted. A successful one is, even if it was refused before: a mapping cannot be
    /// written while its PDO is in use.
    fn permits(&self, shown: bool, direction: Direction, code: u32) -> Option<bool> {
        if shown {
            return Some(true);
        }
        self.aborted.iter().any(|one| one.direction == direction && one.abort.code.meaning() == code).then_some(false)
    }

    /// Returns its configured value: the last one that was written and accepted. `None` if it was not written, and for
    /// commands and process data that PDOs also write.
    pub fn configured(&self, mux: Mux) -> Option<&HeldValue> {
        self.written.as_ref().filter(|_| !is_command(mux) && self.count(Source::Rpdo) == 0)
    }

    /// Returns the access in the form of a description; `r`, `w`: the other one is unknown.
    pub fn access(&self) -> Option<&'static str> {
        match (self.is_readable(), self.is_writable()) {
            (Some(true), Some(true)) => Some("rw"),
            (Some(true), Some(false)) => Some("ro"),
            (Some(false), Some(true)) => Some("wo"),
            (Some(true), None) => Some("r"),
            (None, Some(true)) => Some("w"),
            _ => None,
        }
    }

    /// Returns true if the device has it: a value was seen, or the reason of a refusal implies it.
    pub fn exists(&self) -> Option<bool> {
        let codes = || self.aborted.iter().map(|one| one.abort.code.meaning());
        if self.values() > 0 || codes().any(|code| PRESENT.contains(&(code >> 16)) && !ABSENT.contains(&code)) {
            return Some(true);
        }
        codes().any(|code| ABSENT.contains(&code)).then_some(false)
    }

    /// Returns its type and the source of the type.
    pub fn data_type(&self, mux: Mux) -> Option<(DataType, TypeFrom)> {
        if let Some(object) = &self.described.object {
            return Some((object.data_type()?, TypeFrom::Eds));
        }
        let profile = self.described.profile;
        let from = match mux.index {
            0x1000..=0x1FFF => TypeFrom::Standard,
            _ if profile == Profile::UNKNOWN => TypeFrom::Inferred,
            _ => TypeFrom::Profile,
        };
        let standard = profile.data_type(mux.index, mux.sub).filter(|data_type| self.looks.fits(*data_type));
        // The objects of a device without a known profile may differ from those of a drive: only their size supports
        // the type.
        let standard = standard.filter(|_| from != TypeFrom::Inferred || self.looks.bits().is_some());
        standard.map(|data_type| (data_type, from)).or_else(|| Some((self.looks.inferred()?, TypeFrom::Inferred)))
    }

    fn take(&mut self, sighting: &ObjectSighting<'_>, booted: bool) {
        let ObjectSighting { at, source, .. } = *sighting;
        self.last = at;
        self.measured.take(sighting, booted);
        if let Some(count) = self.counts.get_mut(source as usize) {
            *count += 1;
        }
        if let Some((direction, abort)) = sighting.aborted() {
            self.abort(direction, abort, at);
        }
        if let Shown::Transfer(transfer) = sighting.shown {
            self.described.told = transfer.described.told.or(self.described.told);
        }
        let content = sighting.content();
        if source.is_value() {
            self.looks.take(content);
            self.requested = None;
            self.varies |= source.is_given()
                && self.value.as_ref().is_some_and(|held| held.source.is_given() && held.content().differs(content));
            hold(&mut self.value, content, source, at);
            if source == Source::Written {
                hold(&mut self.written, content, source, at);
            }
        } else if source == Source::Unconfirmed {
            hold(&mut self.requested, content, source, at);
        }
    }

    fn abort(&mut self, direction: Direction, abort: Abort, at: FrameRef) {
        let known = self.aborted.iter_mut().find(|one| one.direction == direction && one.abort == abort);
        if let Some(one) = known {
            one.count += 1;
            one.at = at;
        } else if self.aborted.len() < ABORTS {
            self.aborted.push(Aborted { direction, abort, count: 1, at });
        }
    }
}

/// Returns true if writing the object is a command and not configuration: it clears errors, stores or restores
/// parameters, or controls an operating system, a program loader or a drive.
fn is_command(Mux { index, sub }: Mux) -> bool {
    match index {
        0x1003 => sub == 0,
        0x1010 | 0x1011 | 0x1023..=0x1026 | 0x1F50 | 0x1F51 => true,
        _ => drive::DriveObject::at(index) == Some(drive::DriveObject::Controlword),
    }
}

/// Keeps a value, in the memory of the previous one if possible.
fn hold(place: &mut Option<HeldValue>, content: Content<'_>, source: Source, at: FrameRef) {
    let value = match content {
        Content::None => return,
        Content::Bits(raw, bits) => SeenValue::Bits(raw, bits),
        Content::Bytes(bytes, size) => {
            let mut kept = match place.take() {
                Some(HeldValue { value: SeenValue::Bytes(kept, _), .. }) => kept,
                _ => Vec::new(),
            };
            kept.clear();
            kept.extend_from_slice(bytes.get(..KEPT).unwrap_or(bytes));
            SeenValue::Bytes(kept, size)
        }
    };
    *place = Some(HeldValue { value, source, at });
}

/// The objects of one node.
#[derive(Clone, Debug, Default)]
pub struct NodeObjects {
    /// By index and sub-index.
    pub objects: BTreeMap<Mux, ObservedObject>,
    /// The number of sightings of objects for which there was no room.
    pub further: u64,
}

impl NodeObjects {
    /// Returns the last number that an object of at most four bytes was seen to hold.
    pub fn number(&self, index: u16, sub: u8) -> Option<u32> {
        match &self.objects.get(&Mux { index, sub })?.value.as_ref()?.value {
            SeenValue::Bytes(bytes, 1..=4) => {
                configuration::number(bytes).and_then(|number| u32::try_from(number).ok())
            }
            _ => None,
        }
    }

    /// Returns the last text that an object was seen to hold.
    pub fn text(&self, index: u16, sub: u8) -> Option<&str> {
        match &self.objects.get(&Mux { index, sub })?.value.as_ref()?.value {
            SeenValue::Bytes(bytes, _) => match od::decode(Some(DataType::VisibleString), bytes) {
                od::Value::Text(text) => Some(text),
                _ => None,
            },
            SeenValue::Bits(..) => None,
        }
    }
}

/// The objects of all nodes.
#[derive(Debug, Default)]
pub struct Inventory {
    filter: Filter,
    /// By bus and node-ID.
    pub nodes: BTreeMap<(BusId, u8), NodeObjects>,
    /// PDOs by bus and identifier.
    pub pdos: BTreeMap<(BusId, CanId), PdoFrames>,
    /// Nodes whose boot-up the capture shows, with all frames since.
    booted: BTreeSet<(BusId, u8)>,
    kept: usize,
}

impl Inventory {
    /// Creates an inventory of the nodes and objects that the filter accepts.
    pub fn new(filter: Filter) -> Self {
        Self { filter, ..Self::default() }
    }

    /// Takes a frame and its events.
    pub fn frame(&mut self, frame: &Frame, events: &[Event]) {
        sighting::each(frame, events, &mut |sighting| self.take(&sighting));
        for event in events {
            if let What::Pdo(data) = &event.what {
                let new = || PdoFrames::new((data.node, data.transmit, data.number), frame.len);
                self.pdos.entry((frame.bus, frame.id)).or_insert_with(new).take(frame.len);
            }
        }
    }

    /// Takes boot-ups, also those of frames that are not to be shown.
    pub fn boot_ups(&mut self, events: &[Event]) {
        for event in events {
            if let What::Change(Change::BootUp { node }) = &event.what {
                self.booted.insert((event.bus, *node));
            }
        }
    }

    /// Notes that frames of a bus, or of all, were lost: they may have contained writes.
    pub fn lost(&mut self, bus: Option<BusId>) {
        self.booted.retain(|(of, _)| bus.is_some_and(|bus| bus != *of));
    }

    /// Takes a transfer that has ended.
    pub fn transfer(&mut self, transfer: &Transfer) {
        if let Some(sighting) = ObjectSighting::of(transfer) {
            self.take(&sighting);
        }
    }

    /// Returns true if the capture shows a boot-up of a node and no frames were lost since.
    pub fn has_booted(&self, bus: BusId, node: u8) -> bool {
        self.booted.contains(&(bus, node))
    }

    fn take(&mut self, sighting: &ObjectSighting<'_>) {
        let ObjectSighting { bus, node, object, at, .. } = *sighting;
        if !self.filter.takes_object(node, object) {
            return;
        }
        let booted = self.has_booted(bus, node);
        let node = self.nodes.entry((bus, node)).or_default();
        if let Some(known) = node.objects.get_mut(&object) {
            return known.take(sighting, booted);
        }
        if self.kept >= MOST {
            node.further += 1;
            return;
        }
        self.kept += 1;
        node.objects.entry(object).or_insert_with(|| ObservedObject::new(at)).take(sighting, booted);
    }

    /// Takes the present knowledge of the nodes: descriptions of objects and their values in force.
    pub fn settle(&mut self, state: &[Bus]) {
        for ((bus, id), node) in &mut self.nodes {
            let known = state.get(usize::from(bus.0)).and_then(|bus| bus.node(*id));
            for (mux, object) in &mut node.objects {
                object.described = Described {
                    object: known.and_then(|node| node.configuration.object(mux.index, mux.sub)).cloned(),
                    profile: known.map_or(Profile::UNKNOWN, |node| node.profile()),
                    told: object.described.told,
                };
                let held = || known?.configuration.get(*id, mux.index, mux.sub);
                object.in_force = match configuration::concerns(mux.index) {
                    true => held().map_or(InForce::Unknown, InForce::Value),
                    false => InForce::Unfollowed,
                };
            }
        }
    }
}

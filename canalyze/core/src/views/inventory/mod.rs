//! What objects devices have, by what the traffic shows of them: an object dictionary by node, whoever has lost its EDS.
//!
//! Every SDO transfer, every signal of a PDO and every EMCY shows something of an object ([`sighting`]). Of each object
//! figures and the last value are kept, so that memory depends on how many objects there are and not on how long the
//! capture is; those beyond [`MOST`] are counted. What an object is called and which type it has is asked at the end,
//! when all is known of its device. Must not: judge a transfer, decide what a mapping is, or write words.

mod inferred;
mod measured;
pub mod pdos;
pub mod sighting;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};

use self::inferred::Looks;
pub use self::measured::{Measured, Pdo};
use self::sighting::{Content, Sighting, Source};
use crate::bytes::frame::{BusId, CanId, Frame, FrameRef};
use crate::sdo::transfer::{Abort, Direction, Transfer};
use crate::sdo::wire::Mux;
use crate::views::filter::Filter;
use crate::wire::message::Message;
use crate::words::profiles::Profile;
use crate::world::bus::Bus;
use crate::world::configuration::{self, KnownValue};
use crate::world::dictionary::Described;
use crate::world::drive;
use crate::world::event::{Event, What};
use crate::world::od::{self, DataType};

/// Objects that are kept, of all nodes; more than all devices of a bus have together.
pub const MOST: usize = 131_072;
/// Most bytes of a value that are kept.
pub const KEPT: usize = 4096;
/// Most different aborts that are kept of one object.
const ABORTS: usize = 16;
/// Abort codes by which an access itself is refused: the object cannot be read, or not be written.
const WRITE_ONLY: u32 = 0x0601_0001;
const READ_ONLY: u32 = 0x0601_0002;
/// Abort codes by which there is no such object, or no such sub-index.
const ABSENT: [u32; 2] = [0x0602_0000, 0x0609_0011];
/// Beginnings of abort codes that speak of an object that is there: of its access, mapping, length, or range.
const PRESENT: [u32; 4] = [0x0601, 0x0604, 0x0607, 0x0609];

/// From where it is known which type an object has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TypeFrom {
    /// The description of the device.
    Eds,
    /// The standard: 1000h to 1FFFh.
    Standard,
    /// The profile that the device says it follows.
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

/// A value as it was seen.
#[derive(Clone, Debug)]
pub enum Value {
    /// The first bytes of a value, at most [`KEPT`], and its size in bytes.
    Bytes(Vec<u8>, u64),
    /// Bits of a PDO, the first lowest, and their number.
    Bits(u64, u8),
}

/// A value, and where it was seen.
#[derive(Clone, Debug)]
pub struct Held {
    /// The value.
    pub value: Value,
    /// What carried it.
    pub source: Source,
    /// The frame that completed it.
    pub at: FrameRef,
}

impl Held {
    /// The value as it was seen.
    pub fn content(&self) -> Content<'_> {
        match &self.value {
            Value::Bytes(kept, size) => Content::Bytes(kept, *size),
            Value::Bits(raw, bits) => Content::Bits(*raw, *bits),
        }
    }
}

/// What an object holds by all that is known: after a reset that need not be the last value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InForce {
    /// Decoding does not depend on the object: it is not followed.
    #[default]
    Unfollowed,
    /// Nothing is known of it, or no longer.
    Unknown,
    /// This.
    Value(KnownValue),
}

/// Requests that were aborted alike.
#[derive(Clone, Copy, Debug)]
pub struct Aborted {
    /// Read or written.
    pub direction: Direction,
    /// The code, and who sent it.
    pub abort: Abort,
    /// How often.
    pub count: u64,
    /// The last time.
    pub at: FrameRef,
}

/// What was seen of one object.
#[derive(Clone, Debug)]
pub struct Object {
    /// How often, by [`Source`].
    counts: [u64; Source::ALL.len()],
    /// The first frame that shows something of it.
    pub first: FrameRef,
    /// The last one.
    pub last: FrameRef,
    /// Its last value.
    pub value: Option<Held>,
    /// What was last written to it, and accepted.
    written: Option<Held>,
    /// Two values that it gave differ, though nothing was written in between.
    pub varies: bool,
    /// What the last write asked for to which there is no answer, where no value was seen since.
    pub requested: Option<Held>,
    /// Requests that were aborted, by code, in the order in which they came first.
    pub aborted: Vec<Aborted>,
    /// What SDO shows of it that a description may say otherwise.
    pub measured: Measured,
    looks: Looks,
    /// What the device's description and its profile say of it: known from [`Inventory::settle`] on.
    pub described: Described,
    /// What it holds by all that is known: known from [`Inventory::settle`] on.
    pub in_force: InForce,
}

impl Object {
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
            measured: Measured::default(),
            looks: Looks::default(),
            described: Described::default(),
            in_force: InForce::default(),
        }
    }

    /// How often something of it was seen there.
    pub fn count(&self, source: Source) -> u64 {
        self.counts.get(source as usize).copied().unwrap_or(0)
    }

    /// How many values were seen.
    pub fn values(&self) -> u64 {
        Source::ALL.iter().filter(|source| source.is_value()).map(|source| self.count(*source)).sum()
    }

    /// Its size in bits, where a value was seen: what SDO transfers of it have, else what is mapped of it.
    pub fn bits(&self) -> Option<u64> {
        self.looks.bits()
    }

    /// Whether it can be read, as far as the capture shows it: it was read, or a PDO of the device carries it.
    pub fn is_readable(&self) -> Option<bool> {
        let shown = self.count(Source::Read) + self.count(Source::Tpdo) > 0;
        self.permits(shown, Direction::Upload, WRITE_ONLY)
    }

    /// Whether it can be written, as far as the capture shows it: it was written, or a PDO to the device carries it.
    pub fn is_writable(&self) -> Option<bool> {
        let shown = self.count(Source::Written) + self.count(Source::Rpdo) > 0;
        self.permits(shown, Direction::Download, READ_ONLY)
    }

    /// What was done is permitted, though it may have been refused before: a mapping cannot be written while its PDO is
    /// in use.
    fn permits(&self, shown: bool, direction: Direction, code: u32) -> Option<bool> {
        if shown {
            return Some(true);
        }
        self.aborted.iter().any(|one| one.direction == direction && one.abort.code == code).then_some(false)
    }

    /// What it was configured with: the last value that was written and accepted. `None` where it was not written, and
    /// where what is written is a command, or process data that PDOs write, too.
    pub fn configured(&self, mux: Mux) -> Option<&Held> {
        self.written.as_ref().filter(|_| !is_command(mux) && self.count(Source::Rpdo) == 0)
    }

    /// The access of a description that both together are; `r`, `w`: the other one is not known.
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

    /// Whether the device has it: a value was seen, or why a request was refused tells it.
    pub fn exists(&self) -> Option<bool> {
        let codes = || self.aborted.iter().map(|one| one.abort.code);
        if self.values() > 0 || codes().any(|code| PRESENT.contains(&(code >> 16)) && !ABSENT.contains(&code)) {
            return Some(true);
        }
        codes().any(|code| ABSENT.contains(&code)).then_some(false)
    }

    /// Its type, and from where that is known.
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
        // Of a device of which nothing is known the objects of a drive may be others: only their size speaks for them.
        let standard = standard.filter(|_| from != TypeFrom::Inferred || self.looks.bits().is_some());
        standard.map(|data_type| (data_type, from)).or_else(|| Some((self.looks.inferred()?, TypeFrom::Inferred)))
    }

    fn take(&mut self, sighting: &Sighting<'_>, booted: bool) {
        let Sighting { at, source, .. } = *sighting;
        self.last = at;
        self.measured.take(sighting, booted);
        if let Some(count) = self.counts.get_mut(source as usize) {
            *count += 1;
        }
        if let Some((direction, abort)) = sighting.aborted() {
            self.abort(direction, abort, at);
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

/// Whether something is done where an object is written, and nothing is configured: errors are cleared, parameters
/// stored or restored, commands of an operating system, of a program loader or of a drive.
fn is_command(Mux { index, sub }: Mux) -> bool {
    match index {
        0x1003 => sub == 0,
        0x1010 | 0x1011 | 0x1023..=0x1026 | 0x1F50 | 0x1F51 => true,
        _ => drive::Object::at(index) == Some(drive::Object::Controlword),
    }
}

/// Keeps a value, in the memory of the one before it where that has it.
fn hold(place: &mut Option<Held>, content: Content<'_>, source: Source, at: FrameRef) {
    let value = match content {
        Content::None => return,
        Content::Bits(raw, bits) => Value::Bits(raw, bits),
        Content::Bytes(bytes, size) => {
            let mut kept = match place.take() {
                Some(Held { value: Value::Bytes(kept, _), .. }) => kept,
                _ => Vec::new(),
            };
            kept.clear();
            kept.extend_from_slice(bytes.get(..KEPT).unwrap_or(bytes));
            Value::Bytes(kept, size)
        }
    };
    *place = Some(Held { value, source, at });
}

/// The objects of one node.
#[derive(Clone, Debug, Default)]
pub struct Node {
    /// By index and sub-index.
    pub objects: BTreeMap<Mux, Object>,
    /// How often something was seen of an object for which there was no room.
    pub further: u64,
}

impl Node {
    /// The number that an object of four bytes at most was last seen to hold.
    pub fn number(&self, index: u16, sub: u8) -> Option<u32> {
        match &self.objects.get(&Mux { index, sub })?.value.as_ref()?.value {
            Value::Bytes(bytes, 1..=4) => configuration::number(bytes).and_then(|number| u32::try_from(number).ok()),
            _ => None,
        }
    }

    /// The text that an object was last seen to hold.
    pub fn text(&self, index: u16, sub: u8) -> Option<&str> {
        match &self.objects.get(&Mux { index, sub })?.value.as_ref()?.value {
            Value::Bytes(bytes, _) => match od::decode(Some(DataType::VisibleString), bytes) {
                od::Value::Text(text) => Some(text),
                _ => None,
            },
            Value::Bits(..) => None,
        }
    }
}

/// The objects of all nodes.
#[derive(Debug, Default)]
pub struct Inventory {
    filter: Filter,
    /// By bus and node-ID.
    pub nodes: BTreeMap<(BusId, u8), Node>,
    /// PDOs by bus and identifier.
    pub pdos: BTreeMap<(BusId, CanId), Pdo>,
    /// Nodes of which the capture shows a boot-up, and all that came behind it.
    booted: BTreeSet<(BusId, u8)>,
    kept: usize,
}

impl Inventory {
    /// Of those nodes and objects that the filter takes.
    pub fn new(filter: Filter) -> Self {
        Self { filter, ..Self::default() }
    }

    /// Takes what a frame shows.
    pub fn frame(&mut self, frame: &Frame, events: &[Event]) {
        sighting::each(frame, events, &mut |sighting| self.take(&sighting));
        for event in events {
            if let What::Pdo(data) = &event.what {
                let new = || Pdo::new((data.node, data.transmit, data.number), frame.len);
                self.pdos.entry((frame.bus, frame.id)).or_insert_with(new).take(frame.len);
            }
        }
    }

    /// Takes boot-ups, also of frames that are not to be shown.
    pub fn boot_ups(&mut self, events: &[Event]) {
        for event in events {
            if let What::Message(Message::BootUp { node }) = &event.what {
                self.booted.insert((event.bus, *node));
            }
        }
    }

    /// Frames were lost, of a bus or of all: what was written among them nobody knows.
    pub fn lost(&mut self, bus: Option<BusId>) {
        self.booted.retain(|(of, _)| bus.is_some_and(|bus| bus != *of));
    }

    /// Takes a transfer that has ended.
    pub fn transfer(&mut self, transfer: &Transfer) {
        if let Some(sighting) = Sighting::of(transfer) {
            self.take(&sighting);
        }
    }

    /// Whether the capture shows a boot-up of a node, and no frames were lost since.
    pub fn has_booted(&self, bus: BusId, node: u8) -> bool {
        self.booted.contains(&(bus, node))
    }

    fn take(&mut self, sighting: &Sighting<'_>) {
        let Sighting { bus, node, object, at, .. } = *sighting;
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
        node.objects.entry(object).or_insert_with(|| Object::new(at)).take(sighting, booted);
    }

    /// Takes what is known of the nodes by now: what their objects are, and what of them is in force.
    pub fn settle(&mut self, state: &[Bus]) {
        for ((bus, id), node) in &mut self.nodes {
            let known = state.get(usize::from(bus.0)).and_then(|bus| bus.node(*id));
            for (mux, object) in &mut node.objects {
                object.described = Described {
                    object: known.and_then(|node| node.configuration.object(mux.index, mux.sub)).cloned(),
                    profile: known.map_or(Profile::UNKNOWN, |node| node.profile()),
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

//! The data of one capture that are kept for a comparison: actions in order, and the times of periodic frames.
//!
//! Items (SDO transfers, NMT commands, states, emergencies, LSS) are kept by bus, node and kind, each with its frames;
//! periodic frames (PDOs, heartbeats, SYNC, ...) as a stream of places. Memory is bounded: beyond [`ITEMS`] and
//! [`PLACES`] the capture counts as ended there, which is reported. Nothing is judged or compared here.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::bytes::frame::{BusId, Buses, CanId, Frame, FrameRef};
use crate::bytes::ns::Ns;
use crate::problems::Diagnosis;
use crate::problems::problem::Problem;
use crate::problems::rank::is_root;
use crate::rules::finding::{Code, Facts, Finding};
use crate::sdo::transfer::{Abort, Direction, Mode, Status, Transfer};
use crate::sdo::wire::Mux;
use crate::wire::cob_id::Role;
use crate::wire::message::Message;
use crate::wire::pdo::mapping::Mapping;
use crate::world::change::{Change, DriveEvidence, EmcyChange};
use crate::world::dictionary::Described;
use crate::world::drive::DriveState;
use crate::world::event::{Event, ProcessData, Signals, What};

/// Maximum number of items of one capture: some 100 bytes each.
pub const ITEMS: usize = 2_000_000;
/// Maximum number of frames in cyclic streams of one capture: 16 bytes each.
pub const PLACES: usize = 8_000_000;
/// Number of bytes of a value that are kept to be shown; all of them are in its hash.
const SHOWN: usize = 64;
/// A response later than this does not count.
const WAITED_NS: Ns = Ns::from_s(2);
/// Maximum number of findings of one kind whose places are kept.
const FINDINGS: usize = 256;
/// Maximum number of kinds of findings that are kept.
const KINDS: usize = 4096;
/// Maximum number of identifiers of one bus that are kept.
const IDENTIFIERS: usize = 8192;
/// Maximum number of versions of one stream.
const VERSIONS: usize = 256;

/// A position in a capture. Small, since there are many.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CapturePlace {
    no: u32,
    line: u32,
    t_ns: Ns,
}

impl CapturePlace {
    /// Returns the place of a frame. Numbers above 4 billion are not kept.
    pub fn of(at: FrameRef) -> Self {
        let line = at.line().and_then(|line| u32::try_from(line).ok()).unwrap_or(0);
        Self { no: u32::try_from(at.no).unwrap_or(u32::MAX), line, t_ns: at.t_ns.unwrap_or(Ns::MIN) }
    }

    /// Returns the frame.
    pub fn frame(self) -> FrameRef {
        let line = (self.line > 0).then_some(u64::from(self.line));
        let t_ns = (self.t_ns != Ns::MIN).then_some(self.t_ns);
        FrameRef { no: u64::from(self.no), t_ns, ..FrameRef::default() }.with_line(line)
    }

    /// Returns the position on the scale of timestamps, or of numbers of frames.
    pub fn on(self, by_time: bool) -> Ns {
        if by_time { self.t_ns } else { Ns(i64::from(self.no)) }
    }
}

/// An action of a node or a master.
#[derive(Clone, Debug)]
pub enum Action {
    /// An SDO transfer.
    Transfer(Box<TransferDigest>),
    /// An NMT command.
    Nmt(u8),
    /// The node has booted up.
    BootUp,
    /// Error control shows another NMT state.
    State(u8),
    /// A statusword shows another state of an axis.
    Drive(Option<DriveState>),
    /// An emergency: code and error register.
    Emcy(u16, u8),
    /// An LSS frame.
    Lss([u8; 8]),
}

/// The data of an SDO transfer that are kept.
#[derive(Clone, Debug)]
pub struct TransferDigest {
    /// The object.
    pub mux: Option<Mux>,
    /// Upload or download.
    pub direction: Direction,
    /// Expedited, segmented or block.
    pub mode: Mode,
    /// The outcome.
    pub status: Status,
    /// The abort that ended it.
    pub abort: Option<Abort>,
    /// Bytes.
    pub size: u64,
    /// The hash of all of them.
    pub hash: u64,
    /// The first of them.
    pub kept: Box<[u8]>,
    /// The description of the object.
    pub described: Described,
    /// Its beginning, or frames in its middle, are not in the capture.
    pub holed: bool,
    /// The capture, not a frame, ended it.
    pub unended: bool,
}

/// An action and its frames.
#[derive(Clone, Debug)]
pub struct Item {
    /// The last frame of it.
    pub at: CapturePlace,
    /// The first frame of it.
    pub since: CapturePlace,
    /// The action.
    pub action: Action,
}

/// A sequence of items. Items of different senders are in different sequences, since an echo may come late.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ItemKind {
    /// NMT commands.
    Nmt,
    /// Boot-ups and NMT states.
    State,
    /// SDO transfers, by the identifier of the channel unless it is the server's default one.
    Sdo(Option<CanId>),
    /// Emergencies.
    Emcy,
    /// States of a drive's axis, from 0.
    Drive(u8),
    /// Frames of the LSS master.
    LssMaster,
    /// Frames of LSS slaves.
    LssSlave,
}

/// A periodic service.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Service {
    /// SYNC.
    Sync,
    /// TIME.
    Time,
    /// Heartbeats, and responses to node guarding: at first the two look alike.
    ErrorControl,
    /// A PDO: true for a TPDO, and its number.
    Pdo(bool, u16),
    /// A frame of an SRDO: its number, and true for the inverted one.
    Srdo(u8, bool),
}

/// A time during which a stream keeps one form.
#[derive(Clone, Debug)]
pub struct Version {
    /// CAN-ID.
    pub id: CanId,
    /// Bytes.
    pub len: u8,
    /// The mapping of its content, if known.
    pub mapping: Option<Arc<Mapping>>,
    /// Its first frame.
    pub first: CapturePlace,
    /// Its last frame.
    pub last: CapturePlace,
}

/// The frames of one service of one node.
#[derive(Clone, Debug, Default)]
pub struct CyclicStream {
    /// In order.
    pub places: Vec<CapturePlace>,
    /// The forms it had, in order.
    pub versions: Vec<Version>,
}

/// The data of one bus.
#[derive(Clone, Debug, Default)]
pub struct BusDigest {
    /// Frames.
    pub frames: u64,
    /// The first frame of each node and the number of its frames, by node-ID.
    pub nodes: BTreeMap<u8, (CapturePlace, u64)>,
    /// The last node of each identifier.
    pub ids: BTreeMap<CanId, Option<u8>>,
    /// By node and kind.
    pub items: BTreeMap<(u8, ItemKind), Vec<Item>>,
    /// The place from which on the state of a node, or of an axis, is known.
    pub known: BTreeMap<(u8, ItemKind), CapturePlace>,
    /// By node and service.
    pub cyclic: BTreeMap<(u8, Service), CyclicStream>,
    /// By rule, node and object.
    pub findings: BTreeMap<(Code, Option<u8>, Option<Mux>), Vec<Finding>>,
}

/// The data of a capture that are kept.
#[derive(Clone, Debug, Default)]
pub struct Digest {
    /// The names of its buses.
    pub buses: Buses,
    /// By bus.
    pub lines: BTreeMap<BusId, BusDigest>,
    /// Frames.
    pub frames: u64,
    /// Its first frame.
    pub first: CapturePlace,
    /// Its last frame, or the frame at which the digest was full.
    pub last: CapturePlace,
    /// Every frame has a timestamp.
    pub stamped: bool,
    /// The least number of digits of timestamps.
    pub decimals: u8,
    /// It was full before the capture ended.
    pub full: bool,
    /// Problems were diagnosed.
    pub diagnosed: bool,
    /// The problems, in the order in which they showed.
    pub problems: Vec<Problem>,
    /// The first timestamp of the capture, from which titles count.
    pub began_ns: Option<Ns>,
    /// Problems are to be diagnosed.
    diagnoses: bool,
    items: usize,
    places: usize,
}

impl CyclicStream {
    /// Merges another one into it.
    pub fn join(&mut self, other: &Self) {
        self.places.extend(&other.places);
        self.places.sort_by_key(|place| place.no);
        self.versions.extend(other.versions.iter().cloned());
        self.versions.sort_by_key(|version| version.first.no);
    }
}

impl BusDigest {
    /// Returns every place that is kept, in no order.
    pub fn places(&self) -> impl Iterator<Item = CapturePlace> {
        let items = self.items.values().flatten().flat_map(|item| [item.since, item.at]);
        items.chain(self.cyclic.values().flat_map(|stream| stream.places.iter().copied()))
    }
}

impl Digest {
    /// Creates the digest of a capture at its beginning. `diagnoses`: its problems are compared, too.
    pub fn new(diagnoses: bool) -> Self {
        Self { diagnoses, ..Self::default() }
    }

    /// Returns true if problems are to be diagnosed.
    pub fn diagnoses(&self) -> bool {
        self.diagnoses
    }

    /// Returns the cause of one of its problems; a possible cause does not count.
    pub fn cause(&self, one: &Problem) -> Option<&Problem> {
        let link = one.cause.filter(|_| !is_root(one))?;
        self.problems.iter().find(|other| other.id == link.cause)
    }

    /// Takes the diagnosis at the end of the capture.
    pub fn diagnosis(&mut self, diagnosis: &Diagnosis) {
        self.diagnosed = true;
        self.problems = diagnosis.ledger().told().cloned().collect();
        self.began_ns = diagnosis.extent().1.and_then(|first| first.t_ns);
    }

    /// Extends the capture to this frame, whether it is compared or not.
    pub fn extend(&mut self, frame: &Frame) {
        if self.is_full() {
            return;
        }
        let at = CapturePlace::of(frame.reference());
        if self.frames == 0 {
            (self.first, self.stamped, self.decimals) = (at, true, 9);
        }
        (self.frames, self.last) = (self.frames + 1, at);
        self.stamped &= frame.t_ns.is_some();
        self.decimals = self.decimals.min(frame.stamp.map_or(9, |stamp| stamp.decimals));
    }

    /// Takes a frame and its events.
    pub fn frame(&mut self, frame: &Frame, events: &[Event]) {
        if self.is_full() {
            return;
        }
        let at = CapturePlace::of(frame.reference());
        let line = self.lines.entry(frame.bus).or_default();
        line.frames += 1;
        let node = events.first().and_then(|event| event.node);
        if line.ids.len() < IDENTIFIERS || line.ids.contains_key(&frame.id) {
            line.ids.insert(frame.id, node);
        }
        if let Some(node) = node {
            line.nodes.entry(node).or_insert((at, 0)).1 += 1;
        }
        for event in events {
            match &event.what {
                What::Message(message) => self.message(message, frame, event),
                What::Change(change) => self.change(change, frame, event),
                What::Pdo(data) => self.process_data(data, frame, at),
                What::Mpdo(data) => {
                    self.pass(frame, (data.node, Service::Pdo(data.transmit, data.number)), at, None);
                }
                _ => self.event(event, true),
            }
        }
    }

    /// Takes events without a current frame.
    pub fn asides<'a>(&mut self, events: impl Iterator<Item = &'a Event>) {
        if !self.is_full() {
            for event in events {
                self.event(event, false);
            }
        }
    }

    /// Completes the digest at the end of the capture.
    pub fn finish(&mut self, buses: &Buses) {
        self.buses = buses.clone();
    }

    /// Returns every place that is kept, in no order.
    pub fn places(&self) -> impl Iterator<Item = CapturePlace> {
        self.lines.values().flat_map(BusDigest::places)
    }

    fn is_full(&mut self) -> bool {
        self.full |= self.items >= ITEMS || self.places >= PLACES;
        self.full
    }

    fn event(&mut self, event: &Event, framed: bool) {
        match &event.what {
            What::Transfer(transfer) => self.transfer(transfer, framed),
            What::Finding(finding) => {
                let line = self.lines.entry(finding.bus).or_default();
                let key = (finding.code, finding.node, finding.object);
                if line.findings.len() < KINDS || line.findings.contains_key(&key) {
                    let places = line.findings.entry(key).or_default();
                    if places.len() < FINDINGS && !matches!(finding.facts, Facts::Repeated { .. }) {
                        places.push((**finding).clone());
                    }
                }
            }
            _ => {}
        }
    }

    fn transfer(&mut self, transfer: &Transfer, framed: bool) {
        let moved = TransferDigest {
            mux: transfer.mux,
            direction: transfer.direction,
            mode: transfer.mode,
            status: transfer.outcome.status,
            abort: transfer.outcome.abort,
            size: transfer.data.size,
            hash: transfer.data.digest,
            kept: transfer.data.kept.get(..SHOWN).unwrap_or(&transfer.data.kept).into(),
            described: transfer.described.clone(),
            holed: transfer.outcome.midway || transfer.data.hole,
            unended: !framed
                && matches!(transfer.outcome.status, Status::Incomplete | Status::Open)
                && !self.waited(transfer),
        };
        let (at, since) = (CapturePlace::of(transfer.last), CapturePlace::of(transfer.first));
        self.add(
            transfer.bus,
            (transfer.node, ItemKind::Sdo(transfer.channel)),
            Item { at, since, action: Action::Transfer(Box::new(moved)) },
        );
    }

    /// Returns true if the capture continues long enough after a transfer for a response.
    fn waited(&self, transfer: &Transfer) -> bool {
        match (transfer.last.t_ns, self.last.frame().t_ns) {
            (Some(then), Some(now)) => now - then > WAITED_NS,
            _ => false,
        }
    }

    fn add(&mut self, bus: BusId, key: (u8, ItemKind), item: Item) {
        self.items += 1;
        self.lines.entry(bus).or_default().items.entry(key).or_default().push(item);
    }

    fn message(&mut self, message: &Message, frame: &Frame, event: &Event) {
        let at = CapturePlace::of(event.at);
        let one = |action| Item { at, since: at, action };
        match *message {
            Message::Lss { from_master, .. } => {
                let kind = if from_master { ItemKind::LssMaster } else { ItemKind::LssSlave };
                self.add(frame.bus, (0, kind), one(Action::Lss(frame.head())));
            }
            Message::Time { .. } => self.pass(frame, (0, Service::Time), at, None),
            Message::Srdo { number, inverted, .. } => self.pass(frame, (0, Service::Srdo(number, inverted)), at, None),
            Message::Pdo { transmit, number, node } => {
                self.pass(frame, (node, Service::Pdo(transmit, number)), at, None);
            }
            // A frame of another length still belongs to its stream.
            _ if message.role() == Role::Sync => self.pass(frame, (0, Service::Sync), at, None),
            _ => {}
        }
    }

    fn change(&mut self, change: &Change, frame: &Frame, event: &Event) {
        let (bus, at) = (event.bus, CapturePlace::of(event.at));
        let one = |action| Item { at, since: at, action };
        match *change {
            Change::Command { command, .. } => {
                self.add(bus, (change.node().unwrap_or(0), ItemKind::Nmt), one(Action::Nmt(command)));
            }
            Change::BootUp { node } => {
                self.known(bus, (node, ItemKind::State), at);
                self.add(bus, (node, ItemKind::State), one(Action::BootUp));
            }
            Change::State { node, state, previous, .. } => {
                self.known(bus, (node, ItemKind::State), at);
                if previous.is_some_and(|before| before != state) {
                    self.add(bus, (node, ItemKind::State), one(Action::State(state)));
                }
                self.pass(frame, (node, Service::ErrorControl), at, None);
            }
            Change::Drive { node, axis, state, by, .. } => {
                let key = (node, ItemKind::Drive(axis));
                let is_known = self.lines.get(&bus).is_some_and(|line| line.known.contains_key(&key));
                // What only a poll shows is compared by its pace.
                if is_known && change.is_news() {
                    self.add(bus, key, one(Action::Drive(state)));
                } else if by != DriveEvidence::Sdo {
                    self.known(bus, key, at);
                }
            }
            Change::Error(EmcyChange { node, code, register, .. }) => {
                self.add(bus, (node, ItemKind::Emcy), one(Action::Emcy(code, register)));
            }
            _ => {}
        }
    }

    /// Notes that the state of a node, or of an axis, is known from here on.
    fn known(&mut self, bus: BusId, key: (u8, ItemKind), at: CapturePlace) {
        self.lines.entry(bus).or_default().known.entry(key).or_insert(at);
    }

    fn process_data(&mut self, data: &ProcessData, frame: &Frame, at: CapturePlace) {
        let mapping = match &data.content {
            Signals::Mapped(mapping, _) => Some(mapping),
            Signals::ByConsumer(..) | Signals::None(_) => None,
        };
        self.pass(frame, (data.node, Service::Pdo(data.transmit, data.number)), at, mapping);
    }

    /// Takes a frame of a stream.
    fn pass(&mut self, frame: &Frame, key: (u8, Service), at: CapturePlace, mapping: Option<&Arc<Mapping>>) {
        self.places += 1;
        let stream = self.lines.entry(frame.bus).or_default().cyclic.entry(key).or_default();
        stream.places.push(at);
        if let Some(last) = stream.versions.last_mut()
            && last.id == frame.id
            && last.len == frame.len
            && same(last.mapping.as_ref(), mapping)
        {
            last.last = at;
        } else if stream.versions.len() < VERSIONS {
            let (id, len, mapping) = (frame.id, frame.len, mapping.cloned());
            stream.versions.push(Version { id, len, mapping, first: at, last: at });
        }
    }
}

/// Returns true if two mappings have the same entries.
fn same(one: Option<&Arc<Mapping>>, other: Option<&Arc<Mapping>>) -> bool {
    match (one, other) {
        (Some(one), Some(other)) => Arc::ptr_eq(one, other) || alike(one, other),
        (None, None) => true,
        _ => false,
    }
}

/// Returns true if two mappings have the same objects with the same lengths, whatever is known of them.
pub fn alike(one: &Mapping, other: &Mapping) -> bool {
    one.entries.len() == other.entries.len()
        && one.entries.iter().zip(&other.entries).all(|(one, other)| one.word() == other.word())
}

//! MCAP: the container of ROS recordings, of whose topics some hold CAN frames.
//!
//! `walk` cuts the input into records, `chunk` unpacks and checks them, `schema` and `plan` find out once for each type
//! how its messages are frames, `fields` makes the frame, `topic` says its bus, `clock` its time, `order` sorts, and
//! `echo` finds what is there twice.
//! This file keeps what a file says of itself and puts these together. A topic whose messages are no frames is only
//! listed. Of protobuf, FlatBuffers and JSON no messages are read.
//!
//! Nothing of a chunk is believed before its check sum is; only of the last one, that is cut off, what can be unpacked
//! is taken. A damaged chunk is passed over alone, but the types and topics that stand in it are taken where nothing
//! better is known: files name them once, in their first chunk, and mostly again at their end. Messages of a topic
//! that is not named wait for that.
//!
//! Limits: records and chunks up to 256 MiB, see `walk` and `chunk`; definitions of at most [`MOST_TEXT`] bytes are kept.

mod bytes;
mod choice;
mod chunk;
mod clock;
mod echo;
mod fields;
mod held;
mod layout;
mod order;
mod plan;
mod schema;
#[cfg(test)]
mod tests;
mod topic;
mod walk;

use std::collections::BTreeMap;

pub use self::choice::{Choice, Clock, Map, Mistake, Role};

use self::bytes::Bytes;
use self::bytes::Wire;
use self::chunk::{Packing, Unpacker};
use self::clock::Source;
use self::fields::BusField;
use self::held::Held;
use self::order::Order;
use self::plan::Plan;
use self::walk::{HEAD, Record, Step, Walk, op};
use super::{Contents, Damage, DamageKind, Item, Place, Topic, Unreadable};
use crate::frame::{BusId, Buses, Direction};

/// Definitions that are kept, in bytes.
const MOST_TEXT: usize = 16 << 20;
/// Messages of channels that are not known are kept for so many bytes.
const MOST_WAITING: usize = 64 << 20;
/// Topics that are listed.
const MOST_TOPICS: usize = 1024;
/// The longest name of a topic or type that is kept.
const MOST_NAME: usize = 1024;
/// Kinds of records that are counted apart.
const MOST_KINDS: usize = 63;
/// The input is taken in pieces of this size, so that no more of it is held.
const PIECE: usize = 1 << 20;
/// Outside of chunks frames wait for earlier ones for so long, by the time of recording.
const WAIT_NS: i64 = 1_000_000_000;
/// And are looked at whenever so many have come.
const ROUND: u32 = 1024;

/// A reader of MCAP. One for each file.
#[derive(Debug)]
pub struct Mcap {
    walk: Walk,
    file: File,
}

/// What is known of a file, and what of it waits.
#[derive(Debug)]
struct File {
    choice: Choice,
    schemas: BTreeMap<u16, Schema>,
    /// Bytes of their definitions.
    kept: usize,
    channels: Vec<Option<Box<Channel>>>,
    unpacker: Unpacker,
    order: Order,
    /// How far frames lag behind their recording, at most.
    lag_ns: i64,
    /// When the last message outside of chunks was recorded, and how many have come.
    loose: (i64, u32),
    /// A damaged chunk, until it is known how many frames were in it.
    bad: Option<Bad>,
    /// Messages of channels that are not known: their definition was lost, and may be repeated at the end of the file.
    waiting: Vec<(u64, Box<[u8]>)>,
    /// Memory of these.
    waiting_size: usize,
    /// Where the first stood of those that there was no room for.
    unnamed: Option<u64>,
    /// A part is lost up to the end.
    rest_lost: bool,
    over: bool,
    profile: Vec<u8>,
    library: Vec<u8>,
    /// By compression.
    chunks: [u64; 3],
    passed_over: BTreeMap<u8, u64>,
}

#[derive(Debug)]
struct Schema {
    name: String,
    encoding: String,
    text: String,
}

#[derive(Debug)]
struct Channel {
    topic: String,
    schema: String,
    encoding: String,
    messages: u64,
    /// How its messages are read; `None`: they are not.
    plan: Option<Plan>,
    bus: Vec<u8>,
    /// The bus' number, once there was a frame; and of a bus that messages name, the last.
    bus_id: Option<BusId>,
    dir: Option<Direction>,
    source: Source,
}

#[derive(Debug)]
struct Bad {
    damage: Damage,
    /// Frames of it by the indexes so far; `None` where an index is of an unknown channel.
    frames: Option<u64>,
    indexed: bool,
}

impl Mcap {
    /// A reader at the beginning of a file.
    pub fn new(choice: Choice) -> Self {
        let file = File {
            choice,
            schemas: BTreeMap::new(),
            kept: 0,
            channels: Vec::new(),
            unpacker: Unpacker::default(),
            order: Order::new(),
            lag_ns: 0,
            loose: (i64::MIN, 0),
            bad: None,
            waiting: Vec::new(),
            waiting_size: 0,
            unnamed: None,
            rest_lost: false,
            over: false,
            profile: Vec::new(),
            library: Vec::new(),
            chunks: [0; 3],
            passed_over: BTreeMap::new(),
        };
        Self { walk: Walk::new(), file }
    }

    /// Takes the next bytes, in any chunking.
    pub fn feed(&mut self, bytes: &[u8], buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        for piece in bytes.chunks(PIECE) {
            self.walk.push(piece);
            self.turn(false, buses, sink);
        }
    }

    /// Takes the end of the file.
    pub fn finish(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        if std::mem::replace(&mut self.file.over, true) {
            return;
        }
        let cut = self.turn(true, buses, sink);
        self.file.end(buses, sink);
        let whole = self.walk.is_whole() || self.file.rest_lost || self.walk.offset() == 0;
        let (at, bytes) = cut.unwrap_or((self.walk.offset(), 0));
        if !whole || cut.is_some() {
            let (place, bytes) = (Place::Byte(at), Some(bytes));
            sink(Item::Damaged(Damage { place, kind: DamageKind::Cut, bytes, frames: None }), buses);
        }
        self.walk.stop();
    }

    /// Takes the end of what was read so far, where the reading was broken off.
    pub fn interrupt(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.file.over = true;
        self.file.end(buses, sink);
        self.walk.stop();
    }

    /// What it knows of the file beyond frames.
    pub fn contents(&self) -> Contents {
        self.file.contents()
    }

    /// Reads what is there. At the end: where the input is cut, and how much of a record is left there.
    fn turn(&mut self, done: bool, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) -> Option<(u64, u64)> {
        let Self { walk, file } = self;
        loop {
            match walk.next(done) {
                Step::More => return None,
                Step::Begin => file.begin(buses, sink),
                Step::Damaged(damage) => {
                    file.rest_lost |= damage.kind == DamageKind::Rest;
                    file.damaged(damage, buses, sink);
                }
                Step::Cut(record) => {
                    if record.op == op::CHUNK {
                        file.rescue(walk.body(record), record.at, buses, sink);
                    }
                    return Some((record.at, record.len as u64));
                }
                Step::Record(record) => {
                    let went = file.record(record, walk.body(record), buses, sink);
                    match went {
                        Went::Channel(id) => {
                            let frames = file.channel(id).is_some_and(|channel| channel.plan.is_some());
                            walk.mark(id, frames);
                        }
                        Went::Message(log_ns) => walk.near(log_ns),
                        Went::Fine | Went::Wrong => {}
                    }
                    walk.went(record, !matches!(went, Went::Wrong));
                }
            }
        }
    }
}

/// What became of a record.
#[derive(Clone, Copy, Debug)]
enum Went {
    Fine,
    /// It is no record of its type: its length is wrong.
    Wrong,
    /// It defined this channel.
    Channel(u16),
    /// It is a message, recorded then.
    Message(u64),
}

impl File {
    /// A file begins, perhaps after another: nothing of that holds.
    fn begin(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.settle(buses, sink);
        self.order.release_all(&mut |frame| sink(Item::Frame(frame), buses));
        self.schemas.clear();
        self.kept = 0;
    }

    fn end(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.settle(buses, sink);
        self.order.release_all(&mut |frame| sink(Item::Frame(frame), buses));
        let waiting = std::mem::take(&mut self.waiting);
        if let Some(at) = waiting.first().map(|(at, _)| *at).or(self.unnamed.take()) {
            let (place, kind) = (Place::Byte(at), DamageKind::Undefined);
            sink(Item::Damaged(Damage { place, kind, bytes: None, frames: None }), buses);
        }
    }

    /// Reads the messages that waited for their channel, as far as it is known by now.
    fn catch_up(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        if self.waiting.is_empty() {
            return;
        }
        self.waiting_size = 0;
        for (at, body) in std::mem::take(&mut self.waiting) {
            self.message(&body, at, buses, sink);
        }
    }

    #[cold]
    fn wait(&mut self, body: &[u8], at: u64) {
        let size = body.len() + 64;
        if body.len() >= 22 && self.waiting_size + size <= MOST_WAITING {
            self.waiting_size += size;
            self.waiting.push((at, body.into()));
        } else {
            self.unnamed.get_or_insert(at);
        }
    }

    /// Says that a part is lost: what is held came before it.
    fn damaged(&mut self, damage: Damage, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.settle(buses, sink);
        self.order.release_all(&mut |frame| sink(Item::Frame(frame), buses));
        sink(Item::Damaged(damage), buses);
    }

    /// Says what is known by now of a damaged chunk.
    fn settle(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let Some(bad) = self.bad.take() else { return };
        let frames = bad.frames.filter(|_| bad.indexed);
        self.damaged(Damage { frames, ..bad.damage }, buses, sink);
    }

    fn channel(&self, id: u16) -> Option<&Channel> {
        self.channels.get(usize::from(id)).and_then(Option::as_deref)
    }

    fn record(&mut self, record: Record, body: &[u8], buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) -> Went {
        if record.op != op::MESSAGE_INDEX {
            self.settle(buses, sink);
        }
        let fine = |read: Option<()>| if read.is_some() { Went::Fine } else { Went::Wrong };
        match record.op {
            op::HEADER => fine(self.header(body)),
            op::SCHEMA => fine(self.schema(body, true)),
            op::CHANNEL => {
                let defined = self.define(body, true);
                self.catch_up(buses, sink);
                defined.map_or(Went::Wrong, Went::Channel)
            }
            op::MESSAGE => self.loose_message(record, body, buses, sink),
            op::CHUNK => self.chunk(record, body, buses, sink),
            op::MESSAGE_INDEX => {
                self.index(body);
                Went::Fine
            }
            op::FOOTER | op::DATA_END | op::CHUNK_INDEX | op::STATISTICS => Went::Fine,
            op::ATTACHMENT_INDEX | op::METADATA_INDEX | op::SUMMARY_OFFSET => Went::Fine,
            other => {
                let known = self.passed_over.len() < MOST_KINDS || self.passed_over.contains_key(&other);
                *self.passed_over.entry(if known { other } else { 0 }).or_default() += 1;
                Went::Fine
            }
        }
    }

    fn header(&mut self, body: &[u8]) -> Option<()> {
        let mut rest = Bytes(body);
        let (profile, library) = (rest.counted()?, rest.counted()?);
        let cut = |text: &[u8]| text.get(..MOST_NAME).unwrap_or(text).to_vec();
        (self.profile, self.library) = (cut(profile), cut(library));
        Some(())
    }

    /// `better`: it takes the place of one that is known.
    fn schema(&mut self, body: &[u8], better: bool) -> Option<()> {
        let mut rest = Bytes(body);
        let (id, name, encoding, text) = (rest.u16()?, rest.counted()?, rest.counted()?, rest.counted()?);
        if !rest.0.is_empty() {
            return None;
        }
        let known = self.schemas.get(&id).map_or(0, |schema| schema.text.len());
        if id == 0 || !better && self.schemas.contains_key(&id) {
            return Some(());
        }
        let text = String::from_utf8_lossy(text);
        let others = self.kept - known;
        let text = if others + text.len() <= MOST_TEXT { text.into_owned() } else { String::new() };
        self.kept = others + text.len();
        self.schemas.insert(id, Schema { name: name_of(name), encoding: name_of(encoding), text });
        Some(())
    }

    /// A channel; its number. `better`: it takes the place of one that is known.
    fn define(&mut self, body: &[u8], better: bool) -> Option<u16> {
        let mut rest = Bytes(body);
        let (id, schema_id) = (rest.u16()?, rest.u16()?);
        let (topic, encoding, _) = (rest.counted()?, rest.counted()?, rest.counted()?);
        if !rest.0.is_empty() {
            return None;
        }
        let index = usize::from(id);
        if self.channels.len() <= index {
            self.channels.resize_with(index + 1, || None);
        }
        let (topic, encoding) = (name_of(topic), name_of(encoding));
        let schema = self.schemas.get(&schema_id);
        let name = schema.map(|schema| schema.name.as_str()).unwrap_or_default();
        let language = schema.map(|schema| schema.encoding.as_str()).unwrap_or_default();
        let both = if language.is_empty() { encoding.clone() } else { format!("{language}/{encoding}") };
        let slot = self.channels.get_mut(index)?;
        let same = |known: &Channel| known.topic == topic && known.schema == name && known.encoding == both;
        if slot.as_ref().is_some_and(|known| !better || same(known)) {
            return Some(id);
        }
        let plan = schema
            .filter(|_| self.choice.topics.takes([topic.as_str()]))
            .and_then(|schema| plan_of(schema, &encoding, &self.choice.fields(&topic)));
        let (bus, dir) = topic::bus(topic.as_bytes());
        let source = Source::new(self.choice.clock);
        let schema = name.to_owned();
        let channel = Channel { topic, schema, encoding: both, messages: 0, plan, bus, bus_id: None, dir, source };
        *slot = Some(Box::new(channel));
        self.may_echo();
        Some(id)
    }

    /// Echoes are looked for where a bus has topics of both directions; not in files of our own, whose topics tell the
    /// direction of frames that stand there once.
    fn may_echo(&mut self) {
        let frames = || self.channels.iter().flatten().filter(|channel| channel.plan.is_some());
        let with = |dir| frames().filter(move |channel| channel.dir == Some(dir));
        let both = with(Direction::Tx).any(|sent| with(Direction::Rx).any(|heard| heard.bus == sent.bus));
        if both && !self.library.starts_with(b"canalyze") {
            self.order.seek_echoes();
        }
    }

    /// A message outside of chunks.
    fn loose_message(
        &mut self,
        record: Record,
        body: &[u8],
        buses: &mut Buses,
        sink: &mut impl FnMut(Item, &Buses),
    ) -> Went {
        let mut rest = Bytes(body);
        let Some(id) = rest.u16() else { return Went::Wrong };
        if self.channel(id).is_none_or(|channel| channel.plan.is_none()) {
            self.message(body, record.at, buses, sink);
            return Went::Fine;
        }
        rest.u32();
        let Some(log_ns) = rest.u64() else { return Went::Wrong };
        self.message(body, record.at, buses, sink);
        let (newest, count) = &mut self.loose;
        *newest = (*newest).max(signed(log_ns));
        *count += 1;
        if *count >= ROUND {
            *count = 0;
            let before = newest.saturating_sub(WAIT_NS).saturating_sub(self.lag_ns);
            self.order.release(before, &mut |frame| sink(Item::Frame(frame), buses));
        }
        Went::Message(log_ns)
    }

    /// A message, of whose content only the first bytes need to be there where nobody reads it.
    #[inline(always)]
    fn message(&mut self, body: &[u8], at: u64, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let mut rest = Bytes(body);
        let Some(id) = rest.u16() else { return };
        let Some(channel) = self.channels.get_mut(usize::from(id)).and_then(Option::as_deref_mut) else {
            return self.wait(body, at);
        };
        channel.messages += 1;
        let Some(plan) = &channel.plan else { return };
        let times = (rest.u32(), rest.u64(), rest.u64());
        let (Some(_), Some(log), Some(publish)) = times else { return };
        let (log, publish) = (signed(log), signed(publish));
        if plan.is_plain()
            && let Some((stamp_ns, id, len, data)) = layout::plain(rest.0)
        {
            let t_ns = channel.source.time(Some(stamp_ns), publish, log);
            self.lag_ns = self.lag_ns.max(log.saturating_sub(t_ns));
            let bus = *channel.bus_id.get_or_insert_with(|| buses.intern(&channel.bus));
            let frame = Held::classic(t_ns, id, bus, channel.dir, len, data);
            return self.order.push(frame, &mut |frame| sink(Item::Frame(frame), buses));
        }
        let fields = plan.read(rest.0).ok_or(Unreadable::Data);
        let read = fields.and_then(|fields| fields.frame().map(|frame| (fields, frame)));
        let (fields, mut frame) = match read {
            Ok(read) => read,
            Err(reason) => return sink(Item::Unreadable { place: Place::Byte(at), reason }, buses),
        };
        let t_ns = channel.source.time(fields.stamp_ns, publish, log);
        self.lag_ns = self.lag_ns.max(log.saturating_sub(t_ns));
        frame.dir = channel.dir;
        frame.bus = match fields.bus {
            None => *channel.bus_id.get_or_insert_with(|| buses.intern(&channel.bus)),
            Some(BusField::Name(name)) => buses.intern(&topic::word(name)),
            Some(BusField::Number(number)) => buses.intern(format!("can{number}").as_bytes()),
        };
        self.order.push(Held::new(t_ns, &frame), &mut |frame| sink(Item::Frame(frame), buses));
    }

    fn chunk(&mut self, record: Record, body: &[u8], buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) -> Went {
        let Some(head) = chunk::head(body) else { return Went::Wrong };
        let packed = body.get(head.size..).unwrap_or_default();
        let mut unpacker = std::mem::take(&mut self.unpacker);
        let place = Place::Byte(record.at);
        let went = match unpacker.unpack(&head, packed) {
            // Without a check sum nothing says which of the two lengths is right.
            _ if record.doubtful && head.crc == 0 => Went::Wrong,
            Err(_) if record.doubtful => Went::Wrong,
            Ok(records) => {
                if record.doubtful {
                    let (kind, bytes) = (DamageKind::Structure, Some(HEAD as u64 - 1));
                    self.damaged(Damage { place, kind, bytes, frames: Some(0) }, buses, sink);
                }
                if let Some(count) = packing(&head).and_then(|index| self.chunks.get_mut(index)) {
                    *count += 1;
                }
                let before = signed(head.start_ns).saturating_sub(self.lag_ns);
                self.order.release(before, &mut |frame| sink(Item::Frame(frame), buses));
                let left = self.records(records, record.at, buses, sink);
                if left > 0 {
                    let (kind, bytes) = (DamageKind::Structure, Some(left as u64));
                    self.damaged(Damage { place, kind, bytes, frames: None }, buses, sink);
                }
                Went::Fine
            }
            Err(kind) => {
                self.definitions(unpacker.rescue(&head, packed));
                let damage = Damage { place, kind, bytes: Some(record.len as u64), frames: None };
                self.bad = Some(Bad { damage, frames: Some(0), indexed: false });
                Went::Fine
            }
        };
        self.unpacker = unpacker;
        went
    }

    /// The beginning of the last chunk, that is cut off. Its packed bytes may end in zeros that were never written.
    fn rescue(&mut self, body: &[u8], at: u64, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.settle(buses, sink);
        let Some(head) = chunk::head(body) else { return };
        let packed = body.get(head.size..).unwrap_or_default();
        let end = packed.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
        let packed = packed.get(..end).unwrap_or_default();
        let before = signed(head.start_ns).saturating_sub(self.lag_ns);
        self.order.release(before, &mut |frame| sink(Item::Frame(frame), buses));
        let mut unpacker = std::mem::take(&mut self.unpacker);
        self.records(unpacker.rescue(&head, packed), at, buses, sink);
        self.unpacker = unpacker;
    }

    /// The records in a chunk; the bytes at its end that are none.
    fn records(&mut self, records: &[u8], at: u64, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) -> usize {
        let mut rest = records;
        while let Some((op, body, after)) = inner(rest) {
            match op {
                op::MESSAGE => self.message(body, at, buses, sink),
                op::SCHEMA => _ = self.schema(body, true),
                op::CHANNEL => {
                    self.define(body, true);
                    self.catch_up(buses, sink);
                }
                _ => {}
            }
            rest = after;
        }
        rest.len()
    }

    /// Takes only what a damaged chunk defines, where nothing is known of it.
    fn definitions(&mut self, records: &[u8]) {
        let mut rest = records;
        while let Some((op, body, after)) = inner(rest) {
            match op {
                op::SCHEMA => _ = self.schema(body, false),
                op::CHANNEL => _ = self.define(body, false),
                _ => {}
            }
            rest = after;
        }
    }

    /// A message index: it says how many messages were in a chunk that is lost.
    fn index(&mut self, body: &[u8]) {
        let mut rest = Bytes(body);
        let (Some(id), Some(size)) = (rest.u16(), rest.u32()) else { return };
        let frames = self.channel(id).map(|channel| channel.plan.is_some());
        let Some(bad) = &mut self.bad else { return };
        bad.indexed = true;
        let count = frames.map(|frames| if frames { u64::from(size / 16) } else { 0 });
        bad.frames = bad.frames.zip(count).map(|(sum, count)| sum + count);
    }

    fn contents(&self) -> Contents {
        let mut dialect = vec![("profile", self.profile.clone()), ("library", self.library.clone())];
        let used = Packing::ALL.iter().zip(self.chunks).filter(|(_, count)| *count > 0);
        let names: Vec<&str> = used.map(|((_, name, _), _)| *name).collect();
        let chunks: u64 = self.chunks.iter().sum();
        if chunks > 0 {
            dialect.push(("compression", names.join(",").into_bytes()));
        }
        dialect.push(("chunks", chunks.to_string().into_bytes()));
        let echoes = Some((b"Echo".to_vec(), self.order.echoes())).filter(|(_, count)| *count > 0);
        let passed_over = self.passed_over.iter().map(|(op, count)| (kind_name(*op), *count)).chain(echoes).collect();
        let topics = self.channels.iter().flatten().take(MOST_TOPICS).map(|channel| Topic {
            name: channel.topic.clone().into_bytes(),
            schema: channel.schema.clone().into_bytes(),
            encoding: channel.encoding.clone().into_bytes(),
            messages: channel.messages,
            read_as: channel.plan.as_ref().map(|plan| plan.read_as.clone().into_bytes()).unwrap_or_default(),
            bus: if channel.plan.is_some() { channel.bus.clone() } else { Vec::new() },
        });
        Contents { dialect, passed_over, topics: topics.collect() }
    }
}

/// The first of the records in a chunk: its type, its content, what follows.
#[inline(always)]
fn inner(records: &[u8]) -> Option<(u8, &[u8], &[u8])> {
    let mut rest = Bytes(records);
    let op = *rest.take(1)?.first()?;
    let len = rest.u64()?;
    let body = rest.take(usize::try_from(len).ok()?)?;
    Some((op, body, rest.0))
}

fn packing(head: &chunk::Head) -> Option<usize> {
    Packing::ALL.iter().position(|(.., packing)| Some(*packing) == head.packing)
}

/// How messages of a type are read as frames.
fn plan_of(schema: &Schema, encoding: &str, asked: &[(Role, &str)]) -> Option<Plan> {
    let (wire, text) = match (schema.encoding.as_str(), encoding) {
        ("ros2msg", "cdr") => (Wire::Cdr, Some(schema.text.as_str())),
        // Another language: only types that are known by their names.
        ("ros2idl" | "", "cdr") => (Wire::Cdr, None),
        ("ros1msg", "ros1") => (Wire::Ros1, Some(schema.text.as_str())),
        _ => return None,
    };
    Plan::new(&schema::plain(&schema.name), text, wire, asked)
}

fn name_of(text: &[u8]) -> String {
    String::from_utf8_lossy(text.get(..MOST_NAME).unwrap_or(text)).into_owned()
}

fn kind_name(op: u8) -> Vec<u8> {
    match op {
        op::ATTACHMENT => b"Attachment".to_vec(),
        op::METADATA => b"Metadata".to_vec(),
        0 => b"...".to_vec(),
        op => format!("record {op:02X}h").into_bytes(),
    }
}

#[inline(always)]
fn signed(ns: u64) -> i64 {
    i64::try_from(ns).unwrap_or(i64::MAX)
}

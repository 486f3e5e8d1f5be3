//! MCAP: the container of ROS recordings, some of whose topics hold CAN frames.
//!
//! `walk` cuts the input into records, `chunk` decompresses and checks them, `defined` keeps the types and topics,
//! `schema` and `plan` find the frames in a type's messages once for each type, `fields` makes the frame, `topic` finds
//! its bus, `clock` its time, `order` sorts, `echo` finds frames that are there twice, and `lost` counts the missing
//! ones. This file combines them. Topics without frames are only listed. Messages of protobuf, FlatBuffers and JSON are
//! not read.
//!
//! The content of a chunk is used only after its check sum, except for the decompressible beginning of a last chunk
//! that is cut off. A damaged chunk is skipped alone, with its definitions: the messages of topics that it defines are
//! counted and reported, not read.
//!
//! Limits: records and chunks up to 256 MiB, see `walk` and `chunk`; definitions of at most [`MOST_TEXT`] bytes are
//! kept.

mod bytes;
mod choice;
mod chunk;
mod clock;
mod defined;
mod echo;
mod fields;
mod held;
mod kind;
mod layout;
mod lost;
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
#[cfg(test)]
use self::bytes::Wire;
use self::chunk::{Packing, Unpacker};
use self::defined::Defined;
use self::fields::BusField;
use self::held::Held;
use self::lost::Lost;
use self::order::Order;
#[cfg(test)]
use self::plan::Plan;
use self::walk::{HEAD, Record, Step, Walk, inner, op};
use super::{Contents, Damage, DamageKind, FilePlace, Item, Unreadable};
#[cfg(test)]
use crate::bytes::frame::BusId;
use crate::bytes::frame::Buses;

/// Maximum length of a kept text of a header, in bytes.
const MOST_NAME: usize = 1024;
/// Maximum number of separately counted kinds of records.
const MOST_KINDS: usize = 63;
/// Size of the pieces in which the input is processed, to bound the memory, in bytes.
const PIECE: usize = 1 << 20;
/// Time for which frames outside chunks wait for earlier ones, by the time of recording, in ns.
const WAIT_NS: i64 = 1_000_000_000;
/// Number of such frames after which they are examined.
const ROUND: u32 = 1024;

/// A reader of one MCAP file.
#[derive(Debug)]
pub struct Mcap {
    walk: Walk,
    file: File,
}

/// The state of a file, with its waiting frames.
#[derive(Debug)]
struct File {
    defined: Defined,
    unpacker: Unpacker,
    order: Order,
    /// Maximum lag of frames behind their recording, in ns.
    lag_ns: i64,
    /// Time of recording of the last message outside chunks, and the number of such messages.
    loose: (i64, u32),
    lost: Lost,
    /// True if a part up to the end is lost.
    rest_lost: bool,
    over: bool,
    profile: Vec<u8>,
    library: Vec<u8>,
    /// Number of chunks by compression.
    chunks: [u64; 3],
    passed_over: BTreeMap<u8, u64>,
}

impl Mcap {
    /// Creates a reader at the beginning of a file.
    pub fn new(choice: Choice) -> Self {
        let file = File {
            defined: Defined::new(choice),
            unpacker: Unpacker::default(),
            order: Order::new(),
            lag_ns: 0,
            loose: (i64::MIN, 0),
            lost: Lost::default(),
            rest_lost: false,
            over: false,
            profile: Vec::new(),
            library: Vec::new(),
            chunks: [0; 3],
            passed_over: BTreeMap::new(),
        };
        Self { walk: Walk::new(), file }
    }

    /// Feeds the next bytes, in any chunking.
    pub fn feed(&mut self, bytes: &[u8], buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        for piece in bytes.chunks(PIECE) {
            self.walk.push(piece);
            self.turn(false, buses, sink);
        }
    }

    /// Ends the file.
    pub fn finish(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        if std::mem::replace(&mut self.file.over, true) {
            return;
        }
        let cut = self.turn(true, buses, sink);
        self.file.end(true, buses, sink);
        let whole = self.walk.is_whole() || self.file.rest_lost || self.walk.offset() == 0;
        let (at, bytes) = cut.unwrap_or((self.walk.offset(), 0));
        if !whole || cut.is_some() {
            let (place, bytes) = (FilePlace::Byte(at), Some(bytes));
            sink(Item::Damaged(Damage { place, kind: DamageKind::Cut, bytes, frames: None }), buses);
        }
        self.walk.stop();
    }

    /// Ends an interrupted file.
    pub fn interrupt(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.file.over = true;
        self.file.end(false, buses, sink);
        self.walk.stop();
    }

    /// Returns the facts about the file beyond its frames.
    pub fn contents(&self) -> Contents {
        self.file.contents()
    }

    /// Reads the available input. At the end returns the offset at which the input is cut, and the number of bytes of
    /// the incomplete record.
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
                        Went::Message(log_ns) => walk.near(log_ns),
                        Went::Fine | Went::Wrong => {}
                    }
                    file.defined.fresh.drain(..).for_each(|id| walk.mark(id));
                    walk.went(record, !matches!(went, Went::Wrong));
                }
            }
        }
    }
}

/// The result of reading a record.
#[derive(Clone, Copy, Debug)]
enum Went {
    Fine,
    /// Not a valid record of its type: its length is wrong.
    Wrong,
    /// A message with this time of recording.
    Message(u64),
}

impl File {
    /// Begins a file, perhaps after another one.
    fn begin(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.end(true, buses, sink);
        self.lost = Lost::default();
        self.defined.begin();
    }

    /// Ends a file. `whole`: it was read completely.
    fn end(&mut self, whole: bool, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.settle(buses, sink);
        self.order.release_all(&mut |frame| sink(Item::Frame(frame), buses));
        let missing = self.lost.missing(&self.defined).filter(|_| whole);
        let excess = self.lost.excess(&self.defined).filter(|_| whole);
        let found = [
            (DamageKind::Definition, self.defined.contradiction()),
            (DamageKind::Undefined, self.defined.unread()),
            (DamageKind::Missing, missing.map(|missing| (0, missing))),
            (DamageKind::Excess, excess.map(|excess| (0, excess))),
        ];
        for (kind, found) in found {
            if let Some((at, frames)) = found {
                let (place, frames) = (FilePlace::Byte(at), Some(frames));
                sink(Item::Damaged(Damage { place, kind, bytes: None, frames }), buses);
            }
        }
    }

    /// Reports a lost part, after the held frames, which came before it.
    fn damaged(&mut self, damage: Damage, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.settle(buses, sink);
        let reported = std::mem::replace(&mut self.lost.reported, true);
        let unlocated = damage.kind == DamageKind::Unlocated;
        if unlocated && reported {
            return;
        }
        let frames = if unlocated { Some(self.defined.frames()) } else { damage.frames };
        self.order.release_all(&mut |frame| sink(Item::Frame(frame), buses));
        sink(Item::Damaged(Damage { frames, ..damage }), buses);
    }

    /// Reports the known facts about a damaged chunk.
    fn settle(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let Some(damage) = self.lost.settle(&self.defined) else { return };
        self.damaged(damage, buses, sink);
    }

    fn record(&mut self, record: Record, body: &[u8], buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) -> Went {
        if record.op != op::MESSAGE_INDEX {
            self.settle(buses, sink);
        }
        let fine = |read: Option<()>| if read.is_some() { Went::Fine } else { Went::Wrong };
        match record.op {
            op::HEADER => fine(self.header(body)),
            op::SCHEMA | op::CHANNEL => fine(self.definition(record.op, body, record.at, false)),
            op::MESSAGE => self.loose_message(record, body, buses, sink),
            op::CHUNK => self.chunk(record, body, buses, sink),
            op::MESSAGE_INDEX => {
                self.index(body);
                Went::Fine
            }
            op::STATISTICS => {
                self.lost.counted = lost::statistics(body);
                Went::Fine
            }
            op::FOOTER | op::DATA_END | op::CHUNK_INDEX => Went::Fine,
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

    /// Reads the definition of a type or a topic; `None` if it is malformed. `at`: offset of its record or chunk.
    fn definition(&mut self, op: u8, body: &[u8], at: u64, checked: bool) -> Option<()> {
        if op == op::SCHEMA {
            return self.defined.schema(body, at, checked);
        }
        self.defined.define(body, at, checked)?;
        if self.defined.both_sides && !self.library.starts_with(b"canalyze") {
            self.order.seek_echoes();
        }
        Some(())
    }

    /// Reads a message outside chunks.
    fn loose_message(
        &mut self,
        record: Record,
        body: &[u8],
        buses: &mut Buses,
        sink: &mut impl FnMut(Item, &Buses),
    ) -> Went {
        let mut rest = Bytes(body);
        let Some(id) = rest.u16() else { return Went::Wrong };
        if self.defined.channel(id).is_none_or(|channel| channel.plan.is_none()) {
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

    /// Reads a message; if its topic is not read, the first bytes are enough.
    #[inline(always)]
    fn message(&mut self, body: &[u8], at: u64, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let mut rest = Bytes(body);
        let Some(id) = rest.u16() else { return };
        let channel = self.defined.channel_mut(id).filter(|channel| !channel.lacking);
        let Some(channel) = channel else { return self.defined.skip(id, at) };
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
            Err(reason) => return sink(Item::Unreadable { place: FilePlace::Byte(at), reason }, buses),
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
        let place = FilePlace::Byte(record.at);
        let went = match unpacker.unpack(&head, packed) {
            // Without a check sum nothing shows which of the two lengths is right.
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
                let left = self.records(records, record.at, head.crc != 0, buses, sink);
                if left > 0 {
                    let (kind, bytes) = (DamageKind::Structure, Some(left as u64));
                    self.damaged(Damage { place, kind, bytes, frames: None }, buses, sink);
                }
                Went::Fine
            }
            Err(kind) => {
                let damage = Damage { place, kind, bytes: Some(record.len as u64), frames: None };
                self.lost.chunk(damage);
                Went::Fine
            }
        };
        self.unpacker = unpacker;
        went
    }

    /// Reads the beginning of a last chunk that is cut off. Its compressed bytes may end in zeros that were never
    /// written.
    fn rescue(&mut self, body: &[u8], at: u64, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.settle(buses, sink);
        let Some(head) = chunk::head(body) else { return };
        let packed = body.get(head.size..).unwrap_or_default();
        let end = packed.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
        let packed = packed.get(..end).unwrap_or_default();
        let before = signed(head.start_ns).saturating_sub(self.lag_ns);
        self.order.release(before, &mut |frame| sink(Item::Frame(frame), buses));
        let mut unpacker = std::mem::take(&mut self.unpacker);
        self.records(unpacker.rescue(&head, packed), at, false, buses, sink);
        self.unpacker = unpacker;
    }

    /// Reads the records in a chunk; returns the number of bytes at its end that are not a record.
    fn records(
        &mut self,
        records: &[u8],
        at: u64,
        checked: bool,
        buses: &mut Buses,
        sink: &mut impl FnMut(Item, &Buses),
    ) -> usize {
        let mut rest = records;
        while let Some((op, body, after)) = inner(rest) {
            match op {
                op::MESSAGE => self.message(body, at, buses, sink),
                op::SCHEMA | op::CHANNEL => _ = self.definition(op, body, at, checked),
                _ => {}
            }
            rest = after;
        }
        rest.len()
    }

    /// Reads a message index, with the number of messages in a lost chunk.
    fn index(&mut self, body: &[u8]) {
        let mut rest = Bytes(body);
        let (Some(id), Some(size)) = (rest.u16(), rest.u32()) else { return };
        self.lost.index(id, u64::from(size / 16));
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
        Contents { dialect, passed_over, topics: self.defined.topics() }
    }
}

fn packing(head: &chunk::Head) -> Option<usize> {
    Packing::ALL.iter().position(|(.., packing)| Some(*packing) == head.packing)
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

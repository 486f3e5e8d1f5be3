//! The types and topics that a file defines.
//!
//! A file defines each before its first message, and usually again at its end. The first definition of a number
//! applies; a different one later is damage, and frames read by the first may be wrong unless a check sum covers it.
//! Messages of a topic without a definition are counted. A plan is made once for a type, not for each of its topics.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::bytes::Bytes;
use super::choice::Choice;
use super::clock::Source;
use super::kind::Schema;
use super::plan::Plan;
use super::topic;
use crate::bytes::frame::{BusId, Direction};
use crate::bytes::readers::Topic;

/// Maximum size of all kept type definitions, in bytes.
const MOST_TEXT: usize = 16 << 20;
/// Maximum number of listed topics.
const MOST_TOPICS: usize = 1024;
/// Maximum length of a kept name of a topic or type.
const MOST_NAME: usize = 1024;

/// A topic.
#[derive(Debug)]
pub(super) struct Channel {
    topic: String,
    schema_id: u16,
    schema: String,
    /// The encoding of its messages.
    wire: String,
    /// The encodings of its type and its messages, for people.
    encoding: String,
    pub(super) messages: u64,
    /// The way to read its messages; `None` if they are not read as frames.
    pub(super) plan: Option<Arc<Plan>>,
    /// True if its type is not defined.
    pub(super) lacking: bool,
    /// True if one of its definitions names a known type of frames.
    known: bool,
    /// True if a check sum covers its definition.
    checked: bool,
    /// Offset of the record or chunk with its definition.
    at: u64,
    /// Offset of the first definition that contradicts it.
    contested: Option<u64>,
    pub(super) bus: Vec<u8>,
    /// The bus ID, once there is a frame.
    pub(super) bus_id: Option<BusId>,
    pub(super) dir: Option<Direction>,
    pub(super) source: Source,
}

/// All definitions of one file.
#[derive(Debug, Default)]
pub(super) struct Defined {
    choice: Choice,
    schemas: BTreeMap<u16, Schema>,
    /// Size of the kept type definitions, in bytes.
    kept: usize,
    channels: Vec<Option<Box<Channel>>>,
    /// Messages before the definition of their channel: offset of the first one, and their number.
    undefined: BTreeMap<u16, (u64, u64)>,
    /// Buses with channels of frames: true for received, true for sent.
    sides: BTreeMap<Vec<u8>, [bool; 2]>,
    /// True if some bus has both.
    pub(super) both_sides: bool,
    /// Channels of frames that the walk does not know yet.
    pub(super) fresh: Vec<u16>,
    /// Topics of the files before this one.
    former: Vec<Topic>,
}

impl Defined {
    pub(super) fn new(choice: Choice) -> Self {
        Self { choice, ..Self::default() }
    }

    /// Begins a file, perhaps after another one; only the list of topics is kept.
    pub(super) fn begin(&mut self) {
        let former = self.topics();
        *self = Self { former, ..Self::new(std::mem::take(&mut self.choice)) };
    }

    pub(super) fn channel(&self, id: u16) -> Option<&Channel> {
        self.channels.get(usize::from(id)).and_then(Option::as_deref)
    }

    #[inline(always)]
    pub(super) fn channel_mut(&mut self, id: u16) -> Option<&mut Channel> {
        self.channels.get_mut(usize::from(id)).and_then(Option::as_deref_mut)
    }

    fn channels(&self) -> impl Iterator<Item = &Channel> {
        self.channels.iter().flatten().map(Box::as_ref)
    }

    /// Parses the definition of a type; `None` if the record is malformed.
    pub(super) fn schema(&mut self, body: &[u8], at: u64, checked: bool) -> Option<()> {
        let mut rest = Bytes(body);
        let (id, name, encoding, text) = (rest.u16()?, rest.counted()?, rest.counted()?, rest.counted()?);
        if !rest.0.is_empty() {
            return None;
        }
        let text = String::from_utf8_lossy(text);
        let (name, encoding) = (name_of(name), name_of(encoding));
        if let Some(first) = self.schemas.get_mut(&id) {
            first.compare(&name, &encoding, &text, at);
        } else if id != 0 {
            let text = if self.kept + text.len() <= MOST_TEXT { text.into_owned() } else { String::new() };
            self.kept += text.len();
            self.schemas.insert(id, Schema::new(name, encoding, text, checked));
        }
        Some(())
    }

    /// Parses the definition of a channel; `None` if the record is malformed.
    pub(super) fn define(&mut self, body: &[u8], at: u64, checked: bool) -> Option<()> {
        let mut rest = Bytes(body);
        let (id, schema_id) = (rest.u16()?, rest.u16()?);
        let (topic, wire, _) = (rest.counted()?, rest.counted()?, rest.counted()?);
        if !rest.0.is_empty() {
            return None;
        }
        let (topic, wire) = (name_of(topic), name_of(wire));
        let known = self.schemas.get(&schema_id).is_some_and(|schema| schema.known);
        if let Some(first) = self.channel_mut(id).filter(|first| !first.lacking) {
            if (first.schema_id, &first.topic, &first.wire) != (schema_id, &topic, &wire) {
                first.contested.get_or_insert(at);
                first.known |= known;
            }
            return Some(());
        }
        let chosen = self.choice.topics.takes([topic.as_str()]);
        let (bus, dir) = topic::bus(topic.as_bytes());
        let schema = self.schemas.get_mut(&schema_id);
        let lacking = schema_id != 0 && schema.is_none() && chosen;
        let (mut name, mut encoding, mut plan) = (String::new(), wire.clone(), None);
        if let Some(schema) = schema {
            name.clone_from(&schema.name);
            if !schema.encoding.is_empty() {
                encoding = format!("{}/{wire}", schema.encoding);
            }
            plan = if chosen { schema.plan(&wire, &self.choice.fields(&topic)) } else { None };
        }
        if plan.is_some() {
            self.fresh.push(id);
            if let Some(dir) = dir {
                let [heard, sent] = self.sides.entry(bus.clone()).or_default();
                *if dir == Direction::Rx { &mut *heard } else { &mut *sent } = true;
                self.both_sides |= *heard && *sent;
            }
        }
        let source = Source::new(self.choice.clock);
        let channel = Channel {
            topic,
            schema_id,
            schema: name,
            wire,
            encoding,
            messages: 0,
            plan,
            lacking,
            known,
            checked,
            at,
            contested: None,
            bus,
            bus_id: None,
            dir,
            source,
        };
        let index = usize::from(id);
        if self.channels.len() <= index {
            self.channels.resize_with(index + 1, || None);
        }
        if let Some(slot) = self.channels.get_mut(index) {
            *slot = Some(Box::new(channel));
        }
        Some(())
    }

    /// Counts a message of an undefined channel.
    #[cold]
    pub(super) fn skip(&mut self, id: u16, at: u64) {
        self.undefined.entry(id).or_insert((at, 0)).1 += 1;
    }

    /// Returns the number of messages of a channel before its definition.
    pub(super) fn skipped(&self, id: u16) -> u64 {
        self.undefined.get(&id).map_or(0, |(_, count)| *count)
    }

    /// Returns the messages not read because of their definitions: offset of the first one, and their number.
    pub(super) fn unread(&self) -> Option<(u64, u64)> {
        let frames = |channel: &Channel| channel.lacking || channel.plan.is_some() || self.seems_frames(channel);
        let undefined = self.undefined.iter().filter(|(id, _)| self.channel(**id).is_none_or(frames));
        let unfit = self.channels().filter(|channel| channel.messages > 0 && self.seems_frames(channel));
        let all = undefined.map(|(_, lost)| *lost).chain(unfit.map(|channel| (channel.at, channel.messages)));
        all.reduce(|one, other| (one.0.min(other.0), one.1 + other.1))
    }

    /// Returns true if a channel has frames by the name of its type but is not read.
    fn seems_frames(&self, channel: &Channel) -> bool {
        let known = channel.known || self.schemas.get(&channel.schema_id).is_some_and(|schema| schema.known);
        known && channel.plan.is_none() && self.choice.topics.takes([channel.topic.as_str()])
    }

    /// Returns contradictory definitions: offset of the first one, and the number of frames that may be wrong.
    pub(super) fn contradiction(&self) -> Option<(u64, u64)> {
        let of_types = self.schemas.values().filter_map(|schema| schema.contested);
        let at = of_types.chain(self.channels().filter_map(|channel| channel.contested)).min()?;
        let doubtful = |channel: &&Channel| {
            let schema = self.schemas.get(&channel.schema_id);
            channel.contested.is_some() && !channel.checked
                || schema.is_some_and(|schema| schema.contested.is_some() && !schema.checked)
        };
        let frames = self.channels().filter(|channel| channel.plan.is_some()).filter(doubtful);
        Some((at, frames.map(|channel| channel.messages).sum()))
    }

    /// Returns the number of messages of each channel, including those before its definition.
    pub(super) fn messages(&self) -> BTreeMap<u16, u64> {
        let read = self.channels.iter().zip(0u16..=u16::MAX);
        let read = read.filter_map(|(channel, id)| channel.as_ref().map(|channel| (id, channel.messages)));
        let mut all: BTreeMap<u16, u64> = read.collect();
        for (id, (_, count)) in &self.undefined {
            *all.entry(*id).or_default() += count;
        }
        all
    }

    /// Returns the number of frames read so far.
    pub(super) fn frames(&self) -> u64 {
        self.channels().filter(|channel| channel.plan.is_some()).map(|channel| channel.messages).sum()
    }

    /// Returns the topics, up to the maximum number.
    pub(super) fn topics(&self) -> Vec<Topic> {
        let channels = self.channels.iter().zip(0u16..=u16::MAX);
        let mut topics: Vec<Topic> = channels
            .filter_map(|(channel, id)| Some((channel.as_ref()?, id)))
            .take(MOST_TOPICS)
            .map(|(channel, id)| {
                let read_as = channel.plan.as_ref().map(|plan| plan.read_as.clone().into_bytes());
                Topic {
                    name: channel.topic.clone().into_bytes(),
                    schema: channel.schema.clone().into_bytes(),
                    encoding: channel.encoding.clone().into_bytes(),
                    messages: channel.messages + self.skipped(id),
                    bus: if read_as.is_some() { channel.bus.clone() } else { Vec::new() },
                    read_as: read_as.unwrap_or_default(),
                }
            })
            .collect();
        for former in &self.former {
            if let Some(topic) = topics.iter_mut().find(|topic| names(topic) == names(former)) {
                topic.messages += former.messages;
            } else if topics.len() < MOST_TOPICS {
                topics.push(former.clone());
            }
        }
        topics
    }
}

/// Returns the names that identify a topic.
fn names(topic: &Topic) -> [&[u8]; 3] {
    [&topic.name, &topic.schema, &topic.encoding]
}

/// Returns a name, cut to the maximum length.
pub(super) fn name_of(text: &[u8]) -> String {
    String::from_utf8_lossy(text.get(..MOST_NAME).unwrap_or(text)).into_owned()
}

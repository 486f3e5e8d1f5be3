//! The types and topics that a file defines, and how far each definition is to be believed.
//!
//! Files name them where they are first used, and again at their end. One that stands under a check sum that holds is
//! believed; so is one that stands under none, unless the summary says otherwise. What a damaged chunk defines is used
//! only where nothing better is known by the end, and what was read by it is counted then. Every step costs the same
//! however many definitions there are: a plan is made once for a type, not for each of its topics.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::bytes::Bytes;
use super::choice::Choice;
use super::clock::Source;
use super::kind::Schema;
use super::plan::Plan;
use super::summary::Summary;
use super::topic;
use super::walk::Read;
use crate::bytes::frame::{BusId, Direction};
use crate::bytes::readers::Topic;

/// Definitions that are kept, in bytes.
const MOST_TEXT: usize = 16 << 20;
/// Topics that are listed.
const MOST_TOPICS: usize = 1024;
/// The longest name of a topic or type that is kept.
const MOST_NAME: usize = 1024;

/// Damaged parts whose definitions are reported one by one; the others are counted with the last.
const MOST_DOUBTS: usize = 16;

/// What a definition stands under.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Trust {
    /// A check sum that holds.
    Checked,
    /// No check sum; it stands here.
    Plain(u64),
    /// A check sum that fails, in the chunk that begins here.
    Damaged(u64),
}

/// What became of a definition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Took {
    /// It is taken, or says what is known.
    Fine,
    /// It is damaged: the summary knows better, and was taken.
    Corrected,
}

/// How a channel's messages are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// As its plan says.
    Sound,
    /// They wait: its type is not known.
    Lacking,
    /// They wait: only the damaged chunk that begins here tells what they are.
    Doubtful(u64),
    /// As its plan says, since nothing better is known: from so many messages on they are doubtful.
    Accepted { at: u64, from: u64 },
}

/// A topic.
#[derive(Debug)]
pub(super) struct Channel {
    topic: String,
    schema_id: u16,
    schema: String,
    /// Of its messages.
    wire: String,
    /// Of its type and its messages, for people.
    encoding: String,
    pub(super) messages: u64,
    /// How its messages are read; `None`: they are not, or not yet.
    pub(super) plan: Option<Arc<Plan>>,
    /// Its messages wait for a definition that can be believed.
    pub(super) waits: bool,
    state: State,
    /// The damaged chunk that names it.
    doubt: Option<u64>,
    /// Where it is defined without a check sum.
    plain: Option<u64>,
    /// Of how many files it is.
    age: u32,
    /// It seems to hold frames that cannot be read.
    unfit: bool,
    /// Its messages when that was found out.
    since: u64,
    pub(super) bus: Vec<u8>,
    /// The bus' number, once there was a frame; and of a bus that messages name, the last.
    pub(super) bus_id: Option<BusId>,
    pub(super) dir: Option<Direction>,
    pub(super) source: Source,
}

/// All of them.
#[derive(Debug, Default)]
pub(super) struct Defined {
    choice: Choice,
    schemas: BTreeMap<u16, Schema>,
    /// Bytes of their definitions.
    kept: usize,
    channels: Vec<Option<Box<Channel>>>,
    /// Channels that wait for their type, by its number.
    open: BTreeMap<u16, BTreeSet<u16>>,
    /// Channels whose messages wait because of damage.
    doubtful: BTreeSet<u16>,
    /// Channels whose messages need not wait any more.
    pub(super) ready: Vec<u16>,
    /// Channels of frames, by bus: heard, sent.
    sides: BTreeMap<Vec<u8>, [u32; 2]>,
    /// Some bus has both.
    pub(super) both_sides: bool,
    /// Messages of topics that another definition took the place of.
    former: BTreeMap<[String; 3], u64>,
    /// Channels of a type, by its number: each as often as it was defined.
    users: BTreeMap<u16, Vec<u16>>,
    /// Types that were defined twice, and otherwise.
    contested: BTreeSet<u16>,
    /// Channels of which it was found out anew what is read of them.
    pub(super) changed: Vec<u16>,
    /// Frames that were not read since a definition was damaged: where the first stands, and how many.
    unread: Option<(u64, u64)>,
    /// Messages of this file under numbers of channels that another definition took.
    past: BTreeMap<u16, u64>,
    /// Frames that were read by definitions of damaged parts, by where these begin.
    doubts: BTreeMap<u64, u64>,
    pub(super) summary: Option<Summary>,
    /// All that the summary defines was taken.
    recalled: bool,
    /// Files that began.
    pub(super) age: u32,
}

impl Defined {
    pub(super) fn new(choice: Choice) -> Self {
        Self { choice, ..Self::default() }
    }

    /// A file begins, perhaps after another: nothing of that holds.
    pub(super) fn begin(&mut self) {
        self.schemas.clear();
        self.kept = 0;
        self.open.clear();
        self.past.clear();
        self.users.clear();
        self.contested.clear();
        self.age += 1;
    }

    pub(super) fn channel(&self, id: u16) -> Option<&Channel> {
        self.channels.get(usize::from(id)).and_then(Option::as_deref)
    }

    #[inline(always)]
    pub(super) fn channel_mut(&mut self, id: u16) -> Option<&mut Channel> {
        self.channels.get_mut(usize::from(id)).and_then(Option::as_deref_mut)
    }

    /// Reads a type; `None` where it is none.
    pub(super) fn schema(&mut self, body: &[u8], trust: Trust) -> Option<Took> {
        let mut rest = Bytes(body);
        let (id, name, encoding, text) = (rest.u16()?, rest.counted()?, rest.counted()?, rest.counted()?);
        if !rest.0.is_empty() {
            return None;
        }
        let better = self.better(trust, |summary| summary.schema(id).filter(|known| *known != body));
        if let Some(better) = better {
            self.schema(&better, Trust::Checked);
            return Some(Took::Corrected);
        }
        let doubt = match trust {
            Trust::Damaged(at) => Some(at),
            Trust::Checked | Trust::Plain(_) => None,
        };
        let checked = trust == Trust::Checked;
        let known = self.schemas.get(&id);
        if id == 0 || doubt.is_some() && known.is_some() {
            return Some(Took::Fine);
        }
        let others = self.kept - known.map_or(0, |schema| schema.text.len());
        let text = if others + text.len() <= MOST_TEXT { String::from_utf8_lossy(text) } else { "".into() };
        let (name, encoding) = (name_of(name), name_of(encoding));
        let same = |known: &Schema| known.name == name && known.encoding == encoding && known.text == text;
        let same = known.is_some_and(same);
        if !same && !checked && known.is_some_and(|known| known.checked) {
            return Some(Took::Corrected);
        }
        let before = known.filter(|known| !same && !known.checked && known.doubt.is_none());
        let before = before.map(|known| known.plain.unwrap_or_default());
        match self.schemas.get_mut(&id).filter(|_| same) {
            Some(known) => (known.doubt, known.checked) = (None, known.checked || checked),
            None => {
                self.kept = others + text.len();
                let text = text.into_owned();
                let plain = if let Trust::Plain(at) = trust { Some(at) } else { None };
                self.schemas.insert(id, Schema { name, encoding, text, doubt, checked, plain, plans: Vec::new() });
            }
        }
        if let Some(at) = before {
            self.contested(id, at);
        }
        for channel in self.open.remove(&id).unwrap_or_default() {
            self.typed(channel, same);
        }
        Some(Took::Fine)
    }

    /// A type is defined otherwise than before, where no check sum covered that: what was read by it is doubtful, and
    /// what was not read is lost where it could be now.
    fn contested(&mut self, schema: u16, at: u64) {
        // Once is enough to tell it, and files of many contradictions must not take long.
        self.contested.insert(schema);
        for id in self.users.remove(&schema).unwrap_or_default() {
            let known = self.channel(id).filter(|channel| channel.state == State::Sound && channel.age == self.age);
            let Some(known) = known.filter(|channel| channel.schema_id == schema) else { continue };
            let (read, unfit) = (known.plan.is_some(), known.unfit);
            let messages = known.messages - known.since;
            if read && messages > 0 {
                self.doubt(at, messages);
            }
            self.typed(id, false);
            let now = self.channel(id).is_some_and(|channel| channel.plan.is_some());
            if !read && (now || unfit) {
                self.unread(at, messages);
            }
        }
    }

    /// Frames were not read, since what was defined here is damaged.
    fn unread(&mut self, at: u64, messages: u64) {
        if messages > 0 {
            let (first, sum) = self.unread.unwrap_or((at, 0));
            self.unread = Some((first.min(at), sum.saturating_add(messages)));
        }
    }

    /// The type of a channel has come. `same`: it is what was taken for it.
    fn typed(&mut self, id: u16, same: bool) {
        let Some(mut channel) = self.channels.get_mut(usize::from(id)).and_then(Option::take) else { return };
        self.counted(&channel, false);
        self.doubted(&channel, same && channel.doubt.is_none());
        self.plan(id, &mut channel);
        self.counted(&channel, true);
        if let Some(slot) = self.channels.get_mut(usize::from(id)) {
            *slot = Some(channel);
        }
    }

    /// Reads a channel; its number, or `None` where it is none.
    pub(super) fn define(&mut self, body: &[u8], trust: Trust) -> Option<(u16, Took)> {
        let mut rest = Bytes(body);
        let (id, schema_id) = (rest.u16()?, rest.u16()?);
        let (topic, wire, _) = (rest.counted()?, rest.counted()?, rest.counted()?);
        if !rest.0.is_empty() {
            return None;
        }
        let other = |known: &[u8]| named(known) != named(body);
        let better = self.better(trust, |summary| summary.channel(id).filter(|known| other(known)));
        if let Some(better) = better {
            self.define(&better, Trust::Checked);
            return Some((id, Took::Corrected));
        }
        let index = usize::from(id);
        if self.channels.len() <= index {
            self.channels.resize_with(index + 1, || None);
        }
        let mut slot = self.channels.get_mut(index).and_then(Option::take);
        let damaged = matches!(trust, Trust::Damaged(_));
        let current = slot.as_ref().is_some_and(|known| known.age == self.age);
        let sure = slot.as_ref().is_some_and(|known| known.plain.or(known.doubt).is_none() && !known.is(named(body)));
        if current && sure && matches!(trust, Trust::Plain(_)) {
            if let Some(place) = self.channels.get_mut(index) {
                *place = slot;
            }
            return Some((id, Took::Corrected));
        }
        if !(damaged && current) {
            self.recall_schema(schema_id);
            let (topic, wire) = (name_of(topic), name_of(wire));
            slot = Some(self.defined(id, schema_id, (topic, wire), slot, trust));
        }
        if let Some(place) = self.channels.get_mut(index) {
            *place = slot;
        }
        Some((id, Took::Fine))
    }

    /// What takes the place of a channel.
    fn defined(
        &mut self,
        id: u16,
        schema_id: u16,
        (topic, wire): (String, String),
        known: Option<Box<Channel>>,
        trust: Trust,
    ) -> Box<Channel> {
        let schema = self.schemas.get(&schema_id);
        let name = schema.map(|schema| schema.name.as_str()).unwrap_or_default();
        let language = schema.map(|schema| schema.encoding.as_str()).unwrap_or_default();
        let encoding = if language.is_empty() { wire.clone() } else { format!("{language}/{wire}") };
        let same = |known: &Channel| known.topic == topic && known.schema == name && known.encoding == encoding;
        let sure = schema.is_none_or(|schema| schema.doubt.is_none());
        let doubt = if let Trust::Damaged(at) = trust { Some(at) } else { None };
        let mut replaced = None;
        if let Some(mut known) = known {
            if same(&known) {
                if known.state != State::Sound || known.age != self.age {
                    (known.doubt, known.age) = (doubt, self.age);
                    if sure {
                        self.doubted(&known, true);
                        self.counted(&known, false);
                        self.plan(id, &mut known);
                        self.counted(&known, true);
                    }
                }
                return known;
            }
            replaced = Some(known);
        }
        let (bus, dir) = topic::bus(topic.as_bytes());
        let mut channel = Box::new(Channel {
            schema: String::new(),
            topic,
            schema_id,
            wire,
            encoding,
            messages: 0,
            plan: None,
            waits: false,
            state: State::Sound,
            doubt,
            plain: if let Trust::Plain(at) = trust { Some(at) } else { None },
            age: self.age,
            unfit: false,
            since: 0,
            bus,
            bus_id: None,
            dir,
            source: Source::new(self.choice.clock),
        });
        self.plan(id, &mut channel);
        if let Some(known) = replaced {
            self.replaced(id, &known, channel.plan.is_some());
        }
        self.counted(&channel, true);
        channel
    }

    /// Finds out how the messages of a channel are taken.
    fn plan(&mut self, id: u16, channel: &mut Channel) {
        let chosen = self.choice.topics.takes([channel.topic.as_str()]);
        let schema = self.schemas.get_mut(&channel.schema_id).filter(|_| channel.schema_id != 0);
        let doubt = channel.doubt.or(schema.as_ref().and_then(|schema| schema.doubt));
        channel.state = match &schema {
            None if channel.schema_id != 0 && chosen => State::Lacking,
            _ => doubt.map_or(State::Sound, State::Doubtful),
        };
        channel.waits = channel.state != State::Sound;
        if let Some(schema) = schema {
            channel.schema.clone_from(&schema.name);
            channel.encoding = match schema.encoding.as_str() {
                "" => channel.wire.clone(),
                language => format!("{language}/{}", channel.wire),
            };
            channel.plan = schema.plan(&channel.wire, &self.choice.fields(&channel.topic)).filter(|_| chosen);
            if !self.contested.contains(&channel.schema_id) {
                self.users.entry(channel.schema_id).or_default().push(id);
            }
            channel.unfit = chosen && channel.plan.is_none() && schema.seems_frames();
            if schema.doubt.is_some() {
                self.open.entry(channel.schema_id).or_default().insert(id);
            }
        } else if channel.schema_id != 0 {
            self.open.entry(channel.schema_id).or_default().insert(id);
        }
        if matches!(channel.state, State::Doubtful(_)) {
            self.doubtful.insert(id);
        } else {
            self.doubtful.remove(&id);
        }
        channel.since = channel.messages;
        self.changed.push(id);
        if !channel.waits {
            self.ready.push(id);
        }
    }

    /// A channel's definition is known to be right, or wrong: what was read by it is counted.
    fn doubted(&mut self, channel: &Channel, right: bool) {
        if let (State::Accepted { at, from }, false) = (channel.state, right) {
            self.doubt(at, if channel.plan.is_some() { channel.messages - from } else { 0 });
        }
    }

    /// So many frames were read by what was defined here.
    fn doubt(&mut self, at: u64, messages: u64) {
        if messages > 0 {
            let known = self.doubts.len() < MOST_DOUBTS || self.doubts.contains_key(&at);
            let last = self.doubts.last_key_value().map_or(at, |(last, _)| *last);
            *self.doubts.entry(if known { at } else { last }).or_default() += messages;
        }
    }

    /// Another channel takes the number of this one; `frames`: it is one of frames.
    fn replaced(&mut self, id: u16, known: &Channel, frames: bool) {
        self.counted(known, false);
        self.doubted(known, false);
        // Nothing but damage gives a channel a second meaning in the same file.
        if let (Some(at), State::Sound, true) = (known.plain, known.state, known.age == self.age) {
            match &known.plan {
                Some(_) => self.doubt(at, known.messages - known.since),
                None if frames || known.unfit => self.unread(at, known.messages - known.since),
                None => {}
            }
        }
        if known.age == self.age {
            *self.past.entry(id).or_default() += known.messages;
        }
        if known.messages > 0 {
            let names = [known.topic.clone(), known.schema.clone(), known.encoding.clone()];
            if self.former.len() < MOST_TOPICS || self.former.contains_key(&names) {
                *self.former.entry(names).or_default() += known.messages;
            }
        }
    }

    /// Keeps count of the buses that have frames of both directions.
    fn counted(&mut self, channel: &Channel, more: bool) {
        let (Some(_), Some(dir)) = (&channel.plan, channel.dir) else { return };
        let sides = self.sides.entry(channel.bus.clone()).or_default();
        let [heard, sent] = sides;
        let side = if dir == Direction::Rx { heard } else { sent };
        *side = if more { side.saturating_add(1) } else { side.saturating_sub(1) };
        self.both_sides |= *sides != [0, 0] && !sides.contains(&0);
    }

    /// What the summary says where a definition stands under no check sum, and is another one.
    fn better<'a>(&'a self, trust: Trust, find: impl Fn(&'a Summary) -> Option<&'a [u8]>) -> Option<Vec<u8>> {
        let of_it = self.summary.as_ref().filter(|summary| summary.verified && self.age <= 1);
        of_it.filter(|_| matches!(trust, Trust::Plain(_))).and_then(find).map(<[u8]>::to_vec)
    }

    fn recall_schema(&mut self, id: u16) {
        let missing = id != 0 && self.schemas.get(&id).is_none_or(|schema| schema.doubt.is_some());
        let of_it = self.summary.as_ref().filter(|_| missing && self.age <= 1);
        if let Some(body) = of_it.and_then(|summary| summary.schema(id)).map(<[u8]>::to_vec) {
            self.schema(&body, Trust::Checked);
        }
    }

    /// Takes from the summary what it says of a channel that is not known. Whether it is known then.
    pub(super) fn recall(&mut self, id: u16) -> bool {
        let of_it = self.summary.as_ref().filter(|_| self.age <= 1);
        let body = of_it.and_then(|summary| summary.channel(id)).map(<[u8]>::to_vec);
        body.is_some_and(|body| self.define(&body, Trust::Checked).is_some_and(|(known, _)| known == id))
    }

    /// A chunk is damaged that may define channels: what the summary knows of them is taken.
    pub(super) fn recall_all(&mut self) {
        let asked = std::mem::replace(&mut self.recalled, true);
        let summary = self.summary.as_ref().filter(|_| !asked);
        let ids: Vec<u16> = summary.into_iter().flat_map(Summary::channels).collect();
        for id in ids {
            if self.channel(id).is_none() {
                self.recall(id);
            }
        }
    }

    /// Nothing better will be known of the channels that only damaged chunks tell: they are taken as told.
    pub(super) fn accept(&mut self) {
        for id in std::mem::take(&mut self.doubtful) {
            let Some(channel) = self.channel_mut(id) else { continue };
            if let State::Doubtful(at) = channel.state {
                channel.state = State::Accepted { at, from: channel.messages };
                channel.waits = false;
                self.ready.push(id);
            }
        }
    }

    /// What was read by definitions of damaged parts: where these begin, and how many frames. Asked at the end.
    pub(super) fn doubts(&mut self) -> BTreeMap<u64, u64> {
        let channels = std::mem::take(&mut self.channels);
        for channel in channels.iter().flatten() {
            self.doubted(channel, false);
        }
        self.channels = channels;
        std::mem::take(&mut self.doubts)
    }

    /// Messages of each channel.
    pub(super) fn messages(&self) -> impl Iterator<Item = (u16, u64)> {
        let channels = self.channels.iter().zip(0u16..=u16::MAX);
        channels.filter_map(|(channel, id)| channel.as_ref().map(|channel| (id, channel.messages)))
    }

    /// Frames that were read, of all topics that hold any.
    pub(super) fn frames(&self) -> u64 {
        let channels = self.channels.iter().flatten().filter(|channel| channel.plan.is_some());
        channels.map(|channel| channel.messages).sum()
    }

    /// Messages that were read under the number of a channel when it was defined otherwise.
    pub(super) fn past(&self, id: u16) -> u64 {
        self.past.get(&id).copied().unwrap_or_default()
    }

    /// Frames that were not read because of their definitions: where these stand, and how many.
    pub(super) fn unfit(&self) -> impl Iterator<Item = (u64, u64)> {
        let unfit = self.channels.iter().flatten().filter(|channel| channel.unfit && channel.messages > channel.since);
        unfit.map(|channel| (channel.plain.unwrap_or(0), channel.messages - channel.since)).chain(self.unread)
    }

    /// What is known of topics, at most so many as are listed; `waiting` tells the messages of a channel that wait.
    pub(super) fn topics(&self, waiting: impl Fn(u16) -> u64) -> Vec<Topic> {
        let channels = self.channels.iter().zip(0u16..=u16::MAX);
        let mut former = self.former.clone();
        let mut topics: Vec<Topic> = channels
            .filter_map(|(channel, id)| Some((channel.as_ref()?, id)))
            .take(MOST_TOPICS)
            .map(|(channel, id)| {
                let names = [channel.topic.clone(), channel.schema.clone(), channel.encoding.clone()];
                let before = former.remove(&names).unwrap_or_default();
                let read_as = channel.plan.as_ref().map(|plan| plan.read_as.clone().into_bytes());
                let [name, schema, encoding] = names.map(String::into_bytes);
                Topic {
                    name,
                    schema,
                    encoding,
                    messages: channel.messages + waiting(id) + before,
                    bus: if read_as.is_some() { channel.bus.clone() } else { Vec::new() },
                    read_as: read_as.unwrap_or_default(),
                }
            })
            .collect();
        let room = MOST_TOPICS.saturating_sub(topics.len());
        topics.extend(former.into_iter().take(room).map(|(names, messages)| {
            let [name, schema, encoding] = names.map(String::into_bytes);
            Topic { name, schema, encoding, messages, ..Topic::default() }
        }));
        topics
    }
}

impl Channel {
    /// Whether a record says this of it.
    fn is(&self, named: Option<(u16, &[u8], &[u8])>) -> bool {
        let same = |(_, topic, wire)| name_of(topic) == self.topic && name_of(wire) == self.wire;
        named.is_some_and(|said| said.0 == self.schema_id && same(said))
    }

    /// What is read of its messages outside of chunks.
    pub(super) fn read(&self) -> Read {
        match (&self.plan, self.waits) {
            (Some(_), _) => Read::Frames,
            (None, true) => Read::Unknown,
            (None, false) => Read::Nothing,
        }
    }
}

/// What of a channel's record is used: its type, its topic, its encoding.
fn named(body: &[u8]) -> Option<(u16, &[u8], &[u8])> {
    let mut rest = Bytes(body);
    rest.u16()?;
    Some((rest.u16()?, rest.counted()?, rest.counted()?))
}

/// A name, cut where it is too long.
pub(super) fn name_of(text: &[u8]) -> String {
    String::from_utf8_lossy(text.get(..MOST_NAME).unwrap_or(text)).into_owned()
}

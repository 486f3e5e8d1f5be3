//! The signals of PDOs: a type of message for each PDO and mapping, a field for each signal.
//!
//! `/can0/node5/tpdo1` has the mapping seen first, `/can0/node5/tpdo1_v2` the second, since a topic has one type. A
//! frame that is shorter than its mapping shows the signals that it reaches, and they are a mapping of their own.
//! The object in a multiplex PDO has a topic for itself, `/can0/node5/tpdo1/node7_2000_01`.
//!
//! Signals have the type that they have on the bus; with a factor `float64` and the factor applied. Statuswords,
//! controlwords and modes have a second field, `..._text`, with what they say.

use std::sync::Arc;

use super::super::container::ChannelId;
use super::super::message::whole;
use super::super::{Loss, ROS2};
use super::MessagePlace;
use super::fields::{self, FieldForm};
use crate::bytes::frame::{BusId, Frame};
use crate::wire::pdo::mapping::{Mapped, Mapping, Number, number};
use crate::words::Lang;
use crate::words::signal::{self, product};
use crate::world::event::{Addressed, Event, ProcessData, Signals};

/// Most types of message; mappings beyond them are counted as lost.
const MOST: usize = 4096;

/// A PDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Whose {
    bus: BusId,
    node: u8,
    transmit: bool,
    number: u16,
    /// Of a multiplex PDO: the node and the object that it addresses.
    addressed: Option<(u8, u16, u8)>,
}

/// A field of a message.
#[derive(Clone, Copy, Debug)]
struct Field {
    /// Place of its entry in the mapping.
    entry: usize,
    form: FieldForm,
    /// CiA 402's object, on the first axis, where its value has words; else 0.
    words: u16,
}

/// A type of message.
#[derive(Debug)]
struct Type {
    whose: Whose,
    /// The mapping by which it was made; others with the same entries are the same.
    mapping: Arc<Mapping>,
    /// Entries that a frame reaches.
    reach: usize,
    fields: Vec<Field>,
    /// `None` when there was no number left for it.
    channel: Option<ChannelId>,
}

/// The types of message of one file.
#[derive(Debug)]
pub(super) struct PdoTypes {
    lang: Lang,
    types: Vec<Type>,
    words: Vec<u8>,
}

impl PdoTypes {
    /// None yet.
    pub(super) fn new(lang: Lang) -> Self {
        Self { lang, types: Vec::new(), words: Vec::new() }
    }

    /// Appends the signals of a PDO.
    pub(super) fn process_data(
        &mut self,
        place: &mut MessagePlace<'_, '_>,
        bus: &str,
        event: &Event,
        data: &ProcessData,
        frame: &Frame,
    ) {
        let (Signals::Mapped(mapping, _) | Signals::ByConsumer(mapping, ..)) = &data.content else { return };
        let ProcessData { node, transmit, number, .. } = *data;
        let whose = Whose { bus: frame.bus, node, transmit, number, addressed: None };
        self.message(place, bus, event, whose, mapping, frame);
    }

    /// Appends the object of a multiplex PDO.
    pub(super) fn multiplexed(
        &mut self,
        place: &mut MessagePlace<'_, '_>,
        bus: &str,
        event: &Event,
        data: &Addressed,
        frame: &Frame,
    ) {
        let Addressed { node, transmit, number, content, .. } = *data;
        let addressed = Some((content.node, content.index, content.sub));
        let whose = Whose { bus: frame.bus, node, transmit, number, addressed };
        let mapping = Arc::new(data.mapping.clone());
        self.message(place, bus, event, whose, &mapping, frame);
    }

    fn message(
        &mut self,
        place: &mut MessagePlace<'_, '_>,
        bus: &str,
        event: &Event,
        whose: Whose,
        mapping: &Arc<Mapping>,
        frame: &Frame,
    ) {
        let payload = frame.payload();
        let reached = |mapped: &&Mapped| usize::from(mapped.offset) + usize::from(mapped.bits) <= 8 * payload.len();
        let reach = mapping.entries.iter().take_while(reached).count();
        let Some(known) = self.find(place, bus, whose, mapping, reach) else {
            return place.losses.count(Loss::Topics);
        };
        let Self { lang, types, words } = self;
        // The one just used is likely to be used again soon.
        types.swap(0, known);
        let Some(Type { fields, channel: Some(channel), .. }) = types.first() else {
            return place.losses.count(Loss::Topics);
        };
        if fields.is_empty() {
            return;
        }
        let time = place.now;
        let cdr = place.cdr.begin().header(time, bus.as_bytes());
        for field in fields {
            let Some(mapped) = mapping.entries.get(field.entry) else { continue };
            let raw = mapping.raw(mapped, payload).unwrap_or(0);
            match (field.form, number(mapped.data_type, raw, mapped.bits)) {
                (FieldForm::Bool, _) => cdr.bool(raw != 0),
                (FieldForm::Whole { size, .. }, Number::Signed(read)) => cdr.number(read.cast_unsigned(), size),
                (FieldForm::Whole { size, .. }, _) => cdr.number(raw, size),
                (FieldForm::Real32, _) => cdr.u32(raw as u32),
                (FieldForm::Real64, read) => cdr.f64(scaled(read, mapped.factor)),
                (FieldForm::Bytes, _) => cdr.sequence(mapping.octets(mapped, payload).unwrap_or(&[])),
            };
            if field.words != 0 {
                words.clear();
                signal::annotation(words, *lang, field.words, raw);
                cdr.string(words);
            }
        }
        place.send(*channel, event.at, time);
    }

    /// The place of a type, made when it is first needed; `None` when there are too many.
    fn find(
        &mut self,
        place: &mut MessagePlace<'_, '_>,
        bus: &str,
        whose: Whose,
        mapping: &Arc<Mapping>,
        reach: usize,
    ) -> Option<usize> {
        let same = |one: &Type| one.whose == whose && one.reach == reach;
        let known = self.types.iter().position(|one| same(one) && Arc::ptr_eq(&one.mapping, mapping));
        if known.is_some() {
            return known;
        }
        let wanted = mapping.entries.get(..reach);
        let known = self.types.iter().position(|one| same(one) && one.mapping.entries.get(..reach) == wanted);
        if let Some(place) = known {
            // The newer of two that are the same is the one that comes again.
            if let Some(one) = self.types.get_mut(place) {
                one.mapping = Arc::clone(mapping);
            }
            return known;
        }
        if self.types.len() >= MOST {
            return None;
        }
        let version = self.types.iter().filter(|one| one.whose == whose).count() + 1;
        let (fields, text) = definition(self.lang, mapping, reach);
        let (topic, name) = names(bus, whose, version);
        let schema = place.container.schema(&name, ROS2.0, &whole(&text));
        let channel = schema.and_then(|schema| place.container.channel(&topic, schema, ROS2.1, &[]));
        self.types.push(Type { whose, mapping: Arc::clone(mapping), reach, fields, channel });
        Some(self.types.len() - 1)
    }
}

/// A number with its factor.
fn scaled(read: Number, factor: f64) -> f64 {
    match read {
        Number::Unsigned(read) => product(read as f64, factor),
        Number::Signed(read) => product(read as f64, factor),
        Number::Real32(read) => f64::from(read) * factor,
        Number::Real64(read) => read * factor,
        Number::Bool(on) => product(f64::from(u8::from(on)), factor),
        Number::Bytes => f64::NAN,
    }
}

/// Topic and type of message. Buses whose names are the same in a type's letters are told apart by their number.
fn names(bus: &str, whose: Whose, version: usize) -> (String, String) {
    let Whose { node, transmit, number, addressed, .. } = whose;
    let pdo = if transmit { "tpdo" } else { "rpdo" };
    let mut topic = format!("/{bus}/node{node}/{pdo}{number}");
    let mut name = format!("canalyze_msgs/msg/{}Node{node}{}{number}", fields::camel(bus), fields::camel(pdo));
    let plain = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit();
    if !bus.bytes().all(plain) || !bus.starts_with(|c: char| c.is_ascii_lowercase()) {
        name.push_str(&format!("Bus{}", whose.bus.0));
    }
    if let Some((node, index, sub)) = addressed {
        topic.push_str(&format!("/node{node}_{index:04x}_{sub:02x}"));
        name.push_str(&format!("Node{node}Object{index:04X}Sub{sub:02X}"));
    }
    if version > 1 {
        topic.push_str(&format!("_v{version}"));
        name.push_str(&format!("V{version}"));
    }
    (topic, name)
}

/// The fields of a message and their definition, with name, object and unit of each signal beside it.
fn definition(lang: Lang, mapping: &Mapping, reach: usize) -> (Vec<Field>, String) {
    let mut text = "std_msgs/Header header\n".to_owned();
    let mut found = Vec::new();
    let mut taken = Vec::new();
    let written = signal::written(mapping, lang);
    for (entry, (mapped, how)) in mapping.entries.iter().zip(written).enumerate().take(reach) {
        if mapped.dummy {
            continue;
        }
        let Some(form) = FieldForm::of(mapped) else { continue };
        let name = fields::name(mapped, &mut taken);
        text.push_str("# ");
        if signal::has_name(lang, mapped) {
            fields::comment(&mut text, &how.name);
            text.push_str(", ");
        }
        text.push_str(&format!("{:04X}h:{:02X}", mapped.index, mapped.sub));
        if !how.unit.is_empty() {
            text.push_str(", ");
            fields::comment(&mut text, &how.unit);
        }
        text.push_str(&format!("\n{} {name}\n", form.name()));
        let words = if matches!(form, FieldForm::Whole { .. }) { how.words } else { 0 };
        if words != 0 {
            let name = fields::unique(format!("{name}_text"), &mut taken);
            text.push_str(&format!("string {name}\n"));
        }
        found.push(Field { entry, form, words });
    }
    (found, text)
}

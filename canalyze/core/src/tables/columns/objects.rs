//! `objects`: one row a value of an object that the capture shows, whatever service carried it.
//!
//! | `source` | rows | `index`, `sub` |
//! |---|---|---|
//! | `pdo` | each signal of a PDO, at its frame | the mapped object |
//! | `sdo` | each transfer that is ok, at its last frame | the object transferred |
//! | `emcy` | each emergency: its code, and the error register | none of the code; 1001h |
//! | `nmt` | each change of a node's NMT state, as in `states` | none |
//!
//! `value` has sign, type and factor applied, `integer` is the same exactly where it is a whole number without factor;
//! `text` is a string, or what the number means. What is none of these is null: its bytes are in `transfers` and
//! `signals`. Names and words are English whatever the language is. Must not: decide what a mapping is.

use arrow_array::builder::StringBuilder;
use arrow_array::types::{Float64Type, Int64Type, UInt8Type, UInt16Type, UInt64Type};

use super::column::{Batch, Numbers, Table, Words, columns, lossy};
use super::signals::numbers;
use super::states;
use crate::bytes::frame::{BusId, Frame, FrameRef};
use crate::sdo::transfer::{Status, Transfer};
use crate::sdo::wire::Mux;
use crate::tables::jsonl::Setting;
use crate::tables::selection::{Chosen, Selection, Whose};
use crate::wire::emcy;
use crate::wire::error_control;
use crate::wire::message::Message;
use crate::wire::pdo::mapping::{Mapped, Mapping, extract};
use crate::words::terms;
use crate::words::{Lang, signal, value};
use crate::world::drive;
use crate::world::event::{Addressed, Event, Signals as Content, What};
use crate::world::od::{self, DataType, Value};

/// What emergencies and states are called, which are no objects.
const EMERGENCY: &str = "EMCY";
const STATE: &str = "NMT";
/// The error register, which each emergency carries.
const REGISTER: Mux = Mux { index: 0x1001, sub: 0 };

columns! {
    /// The columns.
    Rows {
        t_ns: Numbers<Int64Type>, or_null;
        frame: Numbers<UInt64Type>;
        bus: Words, or_null;
        node: Numbers<UInt8Type>;
        index: Numbers<UInt16Type>, or_null;
        sub: Numbers<UInt8Type>, or_null;
        source: Words;
        name: Words, or_null;
        value: Numbers<Float64Type>, or_null;
        integer: Numbers<Int64Type>, or_null;
        text: StringBuilder, or_null;
        unit: Words, or_null;
    }
}

/// What a value is.
#[derive(Clone, Copy, Debug, Default)]
struct Read<'a> {
    integer: Option<i64>,
    value: Option<f64>,
    text: Option<&'a str>,
}

impl<'a> Read<'a> {
    /// A number, and what it means.
    fn number(number: impl Into<i64>, text: Option<&'a str>) -> Self {
        let number = number.into();
        Self { integer: Some(number), value: Some(number as f64), text }
    }
}

/// Whose value it is, and where it was seen.
#[derive(Clone, Copy, Debug)]
struct Of<'a> {
    source: &'static str,
    at: FrameRef,
    bus: BusId,
    node: u8,
    object: Option<Mux>,
    name: Option<&'a str>,
    unit: Option<&'a str>,
}

impl Table<Rows> {
    fn row(&mut self, done: &mut Vec<Batch>, setting: Setting<'_>, of: Of<'_>, read: Read<'_>) {
        let columns = &mut self.columns;
        columns.t_ns.append_option(of.at.t_ns);
        columns.frame.append_value(of.at.no);
        columns.bus.name(setting.buses.name(of.bus));
        columns.node.append_value(of.node);
        columns.index.append_option(of.object.map(|object| object.index));
        columns.sub.append_option(of.object.map(|object| object.sub));
        columns.source.word(of.source);
        columns.name.maybe(of.name);
        columns.value.append_option(read.value);
        columns.integer.append_option(read.integer);
        columns.text.append_option(read.text);
        columns.unit.maybe(of.unit);
        self.end_row(read.text.map_or(0, str::len), done);
    }
}

/// The table, and which signals are in it.
#[derive(Debug)]
pub(super) struct Objects {
    /// The table.
    pub(super) table: Table<Rows>,
    selection: Selection,
    /// Words being put together.
    text: Vec<u8>,
}

impl Objects {
    /// No row yet.
    pub(super) fn new(table: Table<Rows>, selection: Selection) -> Self {
        Self { table, selection, text: Vec::new() }
    }

    /// Appends the signals of a PDO.
    pub(super) fn process_data(&mut self, done: &mut Vec<Batch>, setting: Setting<'_>, frame: &Frame, event: &Event) {
        let Self { table, selection, text } = self;
        let mut list = |node: u8, mapping: &Mapping, chosen: &[Chosen]| {
            for one in chosen {
                let Some(mapped) = mapping.entries.get(one.place) else { continue };
                let of = Of {
                    source: "pdo",
                    at: frame.reference(),
                    bus: frame.bus,
                    node,
                    object: Some(Mux { index: mapped.index, sub: mapped.sub }),
                    name: Some(&one.name),
                    unit: mapped.unit.as_deref(),
                };
                let Some(raw) = mapping.raw(mapped, frame.payload()) else {
                    let bytes = mapping.octets(mapped, frame.payload()).unwrap_or(&[]);
                    table.row(done, setting, of, Read { text: string(mapped.data_type, bytes), ..Read::default() });
                    continue;
                };
                let words = signal::written(mapping, Lang::En).get(one.place).map_or(0, |how| how.words);
                text.clear();
                if words != 0 {
                    signal::annotation(text, Lang::En, words, raw);
                }
                let (integer, value) = numbers(mapped, raw);
                let bytes = mapping.octets(mapped, frame.payload()).filter(|_| value.is_none()).unwrap_or(&[]);
                let said = lossy(text);
                let text = if said.is_empty() { string(mapped.data_type, bytes) } else { Some(&*said) };
                table.row(done, setting, of, Read { integer, value, text });
            }
        };
        match &event.what {
            What::Pdo(data) => {
                let (Content::Mapped(mapping, _) | Content::ByConsumer(mapping, ..)) = &data.content else { return };
                let whose = Whose { transmit: data.transmit, number: data.number, node: data.node };
                list(data.node, mapping, selection.of(whose, mapping));
            }
            What::Mpdo(data) => {
                let Addressed { transmit, number, node, ref mapping, .. } = **data;
                list(node, mapping, &selection.choose(Whose { transmit, number, node }, mapping));
            }
            _ => {}
        }
    }

    /// Appends what a transfer has moved, if it is a value that is there as a whole.
    pub(super) fn transfer(&mut self, done: &mut Vec<Batch>, setting: Setting<'_>, transfer: &Transfer) {
        let Some(mux) = transfer.mux.filter(|_| transfer.outcome.status == Status::Ok) else { return };
        let bytes = transfer.data.kept.as_slice();
        if bytes.len() as u64 != transfer.data.size {
            return;
        }
        let mapped = mapped(transfer, mux);
        let (mut name, mut words) = (Vec::new(), Vec::new());
        signal::name(&mut name, Lang::En, &mapped);
        let number = usize::from(mapped.bits) == 8 * bytes.len() && (1..=8).contains(&bytes.len());
        let raw = if number { extract(bytes, 0, 8 * bytes.len()) } else { None };
        if let Some(raw) = raw.filter(|_| signal::is_drives(&mapped) && drive::Object::at(mux.index).is_some()) {
            signal::annotation(&mut words, Lang::En, od::first_axis(mux.index), raw);
        }
        let words = lossy(&words);
        let read = match raw.map(|raw| numbers(&mapped, raw)) {
            Some((integer, value)) if value.is_some() => {
                Read { integer, value, text: (!words.is_empty()).then_some(&*words) }
            }
            _ => read(mapped.data_type, bytes),
        };
        let of = Of {
            source: "sdo",
            at: transfer.last,
            bus: transfer.bus,
            node: transfer.node,
            object: Some(mux),
            name: Some(&lossy(&name)),
            unit: mapped.unit.as_deref(),
        };
        self.table.row(done, setting, of, read);
    }

    /// Appends what an emergency, or a change of a state, says.
    pub(super) fn message(&mut self, done: &mut Vec<Batch>, setting: Setting<'_>, event: &Event, message: &Message) {
        let of = |source, node, object, name| {
            let (at, bus) = (event.at, event.bus);
            Of { source, at, bus, node, object, name, unit: None }
        };
        if let Message::Emcy { node, code, profile, register, .. } = *message {
            let read = Read::number(code, emcy::code(Lang::En, profile, code));
            self.table.row(done, setting, of("emcy", node, None, Some(EMERGENCY)), read);
            let name = terms::object_name(Lang::En, profile, REGISTER.index, REGISTER.sub);
            self.table.row(done, setting, of("emcy", node, Some(REGISTER), name), Read::number(register, None));
        } else if let Some((node, state, _)) = states::seen(message) {
            let read = Read::number(state, error_control::state(Lang::En, state));
            self.table.row(done, setting, of("nmt", node, None, Some(STATE)), read);
        }
    }
}

/// The object of a transfer as if a PDO carried it.
fn mapped(transfer: &Transfer, mux: Mux) -> Mapped {
    let described = &transfer.described;
    match &described.object {
        Some(object) => value::as_mapped(object, described.profile),
        None => value::undescribed(mux, transfer.data_type(), described.profile),
    }
}

/// The text that bytes are, if they are any.
fn string(data_type: Option<DataType>, bytes: &[u8]) -> Option<&str> {
    read(data_type, bytes).text
}

/// A value by its type alone.
fn read(data_type: Option<DataType>, bytes: &[u8]) -> Read<'_> {
    match od::decode(data_type, bytes) {
        Value::Bool(on) => Read::number(on, None),
        Value::Signed(number) => Read::number(number, None),
        Value::Unsigned(number) => Read { integer: i64::try_from(number).ok(), value: Some(number as f64), text: None },
        Value::Real(number) => Read { value: Some(number), ..Read::default() },
        Value::Text(text) => Read { text: Some(text), ..Read::default() },
        Value::Empty | Value::Bytes(_) | Value::Time { .. } | Value::Difference { .. } => Read::default(),
    }
}

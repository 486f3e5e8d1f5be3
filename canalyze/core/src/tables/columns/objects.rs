//! `objects`: one row per value of an object that the capture shows, whatever service carried it.
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

use super::column::{Batch, Table, lossy};
use super::signals::{each, numbers};
use super::{Collector, Ends, TableContext, states};
use crate::bytes::frame::{BusId, Frame, FrameRef};
use crate::sdo::transfer::{Status, Transfer};
use crate::sdo::wire::Mux;
use crate::tables::selection::Selection;
use crate::tables::table::{Hex4, I64, Moment, Name, Real, U8, U64, Utf8, Word, table};
use crate::wire::pdo::mapping::{Mapped, extract};
use crate::wire::{emcy, error_control};
use crate::words::{Lang, signal, terms, value};
use crate::world::change::{Change, EmcyChange};
use crate::world::drive;
use crate::world::event::{Event, What};
use crate::world::od::{self, DataType, Value};

/// The names of emergencies and states, which are no objects.
const EMERGENCY: &str = "EMCY";
const STATE: &str = "NMT";
/// The error register, which each emergency carries.
const REGISTER: Mux = Mux { index: 0x1001, sub: 0 };

table! {
    /// One row per value of an object, whatever carried it: PDO, SDO, EMCY (its code and 1001h), NMT state.
    /// 一行是一个对象的值，无论由哪种服务传送：PDO、SDO、EMCY（错误码和1001h）、NMT状态
    Values arrow "objects", |cx, one: (Of<'_>, Read<'_>)| {
        t: Moment or null = one.0.at.t_ns;
        frame: U64 = one.0.at.no;
        bus: Name or null = cx.setting.bus(one.0.bus);
        node: U8 = one.0.node;
        /// index of the object; NMT states and EMCY codes have none
        /// 对象索引；NMT状态和EMCY错误码没有
        index: Hex4 or null = one.0.object.map(|object| object.index);
        sub: U8 or null = one.0.object.map(|object| object.sub);
        /// what carried it: pdo, sdo, emcy or nmt
        /// 由哪种服务传送：pdo、sdo、emcy、nmt
        source: Word = one.0.source;
        /// name, in English
        /// 名称（英文）
        name: Word or null = one.0.name;
        /// value in the unit of column unit
        /// 换算后的值，单位见unit列
        value: Real or null = one.1.value;
        /// the same as an integer, where it has no factor
        /// 整数值（不带系数时）
        integer: I64 or null = one.1.integer;
        /// value of a string, or what a number means, in English
        /// 字符串的值，或数值的含义（英文）
        text: Utf8 or null = one.1.text;
        unit: Word or null = one.0.unit;
    }
}

/// A value.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::tables) struct Read<'a> {
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

/// The object of a value, and the frame that shows it.
#[derive(Clone, Copy, Debug)]
pub(in crate::tables) struct Of<'a> {
    source: &'static str,
    at: FrameRef,
    bus: BusId,
    node: u8,
    object: Option<Mux>,
    name: Option<&'a str>,
    unit: Option<&'a str>,
}

/// The table, and the signals that are in it.
#[derive(Debug)]
pub(super) struct Objects {
    table: Table<Values>,
    selection: Selection,
    /// Words being put together.
    text: Vec<u8>,
}

impl Objects {
    /// Returns a table without rows.
    pub(super) fn new(selection: Selection) -> Self {
        Self { table: Table::default(), selection, text: Vec::new() }
    }

    /// Appends the signals of a PDO.
    fn process_data(&mut self, done: &mut Vec<Batch>, scene: TableContext<'_>, frame: &Frame, event: &Event) {
        let Self { table, selection, text } = self;
        each(selection, &event.what, |signal| {
            let mapped = signal.mapped;
            let of = Of {
                source: "pdo",
                at: frame.reference(),
                bus: frame.bus,
                node: signal.whose.node,
                object: Some(Mux { index: mapped.index, sub: mapped.sub }),
                name: Some(&signal.chosen.name),
                unit: mapped.unit.as_deref(),
            };
            let octets = || signal.mapping.octets(mapped, frame.payload()).unwrap_or(&[]);
            let Some(raw) = signal.mapping.raw(mapped, frame.payload()) else {
                let read = Read { text: string(mapped.data_type, octets()), ..Read::default() };
                return table.row(done, &scene.cx(), (of, read));
            };
            let words = signal::written(signal.mapping, Lang::En).get(signal.chosen.place).map_or(0, |how| how.words);
            text.clear();
            if words != 0 {
                signal::annotation(text, Lang::En, words, raw);
            }
            let (integer, value) = numbers(mapped, raw);
            let bytes = if value.is_none() { octets() } else { &[] };
            let words = lossy(text);
            let text = if words.is_empty() { string(mapped.data_type, bytes) } else { Some(&*words) };
            table.row(done, &scene.cx(), (of, Read { integer, value, text }));
        });
    }

    /// Appends the values that a change carries: an emergency, or an NMT state.
    fn change(&mut self, done: &mut Vec<Batch>, scene: TableContext<'_>, event: &Event, change: &Change) {
        let of = |source, node, object, name| {
            let (at, bus) = (event.at, event.bus);
            Of { source, at, bus, node, object, name, unit: None }
        };
        if let Change::Error(EmcyChange { node, code, profile, register, .. }) = *change {
            let read = Read::number(code, emcy::code(Lang::En, profile, code));
            self.table.row(done, &scene.cx(), (of("emcy", node, None, Some(EMERGENCY)), read));
            let name = terms::object_name(Lang::En, profile, REGISTER.index, REGISTER.sub);
            let register = Read::number(register, None);
            self.table.row(done, &scene.cx(), (of("emcy", node, Some(REGISTER), name), register));
        } else if let Some((node, state, _)) = states::seen(change) {
            let read = Read::number(state, error_control::state(Lang::En, state));
            self.table.row(done, &scene.cx(), (of("nmt", node, None, Some(STATE)), read));
        }
    }
}

impl Collector for Objects {
    fn frame(&mut self, done: &mut Vec<Batch>, scene: TableContext<'_>, frame: &Frame, events: &[Event]) {
        for event in events {
            match &event.what {
                What::Change(change) => self.change(done, scene, event, change),
                _ => self.process_data(done, scene, frame, event),
            }
        }
    }

    /// Appends the value that a transfer has moved, if all of it is there.
    fn transfer(&mut self, done: &mut Vec<Batch>, scene: TableContext<'_>, transfer: &Transfer) {
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
        if let Some(raw) = raw.filter(|_| mapped.is_drives() && drive::DriveObject::at(mux.index).is_some()) {
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
        self.table.row(done, &scene.cx(), (of, read));
    }

    fn table(&mut self) -> &mut dyn Ends {
        &mut self.table
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

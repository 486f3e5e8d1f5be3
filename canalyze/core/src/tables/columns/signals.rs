//! `signals`: one row a signal of a PDO, as `canalyze signals` lists them.
//!
//! `value` has sign, type and factor applied, `integer` is the same exactly where it is a whole number without factor,
//! `raw` the unsigned number in the payload; `data` are the bytes of what is no number or longer than 64 bits. All of
//! them are null where the payload does not reach. Must not: decide what a mapping is.

use arrow_array::builder::{BinaryBuilder, StringBuilder};
use arrow_array::types::{Float64Type, Int64Type, UInt8Type, UInt64Type};

use super::column::{Batch, Numbers, Table, Words, columns};
use crate::bytes::frame::Frame;
use crate::tables::jsonl::Setting;
use crate::tables::selection::{Chosen, Selection, Whose};
use crate::wire::pdo::mapping::{Mapped, Mapping, Number, number};
use crate::words::Lang;
use crate::words::signal::{self, product};
use crate::world::configuration::Provenance;
use crate::world::event::{Addressed, Event, Signals as Content, What};

columns! {
    /// The columns.
    Signals {
        t_ns: Numbers<Int64Type>, or_null;
        frame: Numbers<UInt64Type>;
        line: Numbers<UInt64Type>, or_null;
        bus: Words, or_null;
        node: Numbers<UInt8Type>;
        pdo: Words;
        signal: Words;
        object: Words;
        value: Numbers<Float64Type>, or_null;
        integer: Numbers<Int64Type>, or_null;
        raw: Numbers<UInt64Type>, or_null;
        data: BinaryBuilder, or_null;
        unit: Words, or_null;
        text: StringBuilder, or_null;
        provenance: Words;
    }
}

/// The table, and which signals are in it.
#[derive(Debug)]
pub(super) struct Listed {
    /// The table.
    pub(super) table: Table<Signals>,
    selection: Selection,
    lang: Lang,
    /// Words being put together.
    text: Vec<u8>,
}

impl Listed {
    /// No row yet.
    pub(super) fn new(table: Table<Signals>, selection: Selection, lang: Lang) -> Self {
        Self { table, selection, lang, text: Vec::new() }
    }

    /// Appends the signals of a frame.
    pub(super) fn event(&mut self, done: &mut Vec<Batch>, setting: Setting<'_>, frame: &Frame, event: &Event) {
        let Self { table, selection, lang, text } = self;
        let mut list = |whose: Whose, mapping: &Mapping, from: Provenance, chosen: &[Chosen]| {
            for one in chosen {
                row(table, done, setting, frame, (whose, mapping, from), one, (*lang, text));
            }
        };
        match &event.what {
            What::Pdo(data) => {
                let (Content::Mapped(mapping, from) | Content::ByConsumer(mapping, from, ..)) = &data.content else {
                    return;
                };
                let whose = Whose { transmit: data.transmit, number: data.number, node: data.node };
                list(whose, mapping, *from, selection.of(whose, mapping));
            }
            What::Mpdo(data) => {
                let Addressed { transmit, number, node, ref mapping, from, .. } = **data;
                let whose = Whose { transmit, number, node };
                list(whose, mapping, from, &selection.choose(whose, mapping));
            }
            _ => {}
        }
    }
}

fn row(
    table: &mut Table<Signals>,
    done: &mut Vec<Batch>,
    setting: Setting<'_>,
    frame: &Frame,
    (whose, mapping, from): (Whose, &Mapping, Provenance),
    chosen: &Chosen,
    (lang, text): (Lang, &mut Vec<u8>),
) {
    let Some(mapped) = mapping.entries.get(chosen.place) else { return };
    let columns = &mut table.columns;
    columns.t_ns.append_option(frame.t_ns);
    columns.frame.append_value(frame.no);
    columns.line.append_option(frame.line);
    columns.bus.name(setting.buses.name(frame.bus));
    columns.node.append_value(whose.node);
    columns.pdo.word(&chosen.pdo);
    columns.signal.word(&chosen.name);
    columns.object.word(&chosen.object);
    let payload = frame.payload();
    let raw = mapping.raw(mapped, payload);
    let (integer, value) = raw.map_or((None, None), |raw| numbers(mapped, raw));
    columns.value.append_option(value);
    columns.integer.append_option(integer);
    columns.raw.append_option(raw);
    let data = if value.is_none() { mapping.octets(mapped, payload) } else { None };
    columns.data.append_option(data);
    columns.unit.maybe(mapped.unit.as_deref());
    text.clear();
    match raw {
        Some(raw) => {
            signal::value_at(text, lang, mapping, chosen.place, raw);
            columns.text.append_value(String::from_utf8_lossy(text));
        }
        None => columns.text.append_null(),
    }
    columns.provenance.word(from.name());
    table.end_row(text.len() + data.map_or(0, <[u8]>::len), done);
}

/// The value exactly, where it is a whole number without factor, and as it is in its unit.
pub(super) fn numbers(mapped: &Mapped, raw: u64) -> (Option<i64>, Option<f64>) {
    let scaled = mapped.factor != 1.0;
    let whole = |exact: Option<i64>, read: f64| {
        if scaled { (None, Some(product(read, mapped.factor))) } else { (exact, Some(read)) }
    };
    match number(mapped.data_type, raw, mapped.bits) {
        // A factor means nothing to it.
        Number::Bool(on) => (Some(i64::from(on)), Some(f64::from(u8::from(on)))),
        Number::Unsigned(read) => whole(i64::try_from(read).ok(), read as f64),
        Number::Signed(read) => whole(Some(read), read as f64),
        Number::Real32(read) => (None, Some(f64::from(read) * mapped.factor)),
        Number::Real64(read) => (None, Some(read * mapped.factor)),
        Number::Bytes => (None, None),
    }
}

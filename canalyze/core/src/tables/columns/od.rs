//! `od`: one row an object of a node that the capture shows, as `canalyze od` lists them.
//!
//! All rows come at the end. `value` has sign, type and factor applied, `integer` is the same exactly where it is a whole
//! number without factor; `text` is the value in words. Must not: decide anything.

use arrow_array::builder::{BinaryBuilder, BooleanBuilder, ListBuilder, StringBuilder};
use arrow_array::types::{Float64Type, Int64Type, UInt8Type, UInt16Type, UInt32Type, UInt64Type};

use super::column::{Batch, Numbers, Table, Words, columns, lossy};
use super::signals::numbers;
use crate::sdo::wire::Mux;
use crate::tables::jsonl::Setting;
use crate::views::inventory::sighting::{Content, Source};
use crate::views::inventory::{HeldValue, InForce, Inventory, ObservedObject};
use crate::wire::pdo::mapping::{Mapped, extract};
use crate::words::{Lang, inventory, value};

columns! {
    /// The columns.
    Rows {
        bus: Words, or_null;
        node: Numbers<UInt8Type>;
        index: Numbers<UInt16Type>;
        sub: Numbers<UInt8Type>;
        name: Words, or_null;
        r#type: Words, or_null;
        type_from: Words, or_null;
        bits: Numbers<UInt64Type>, or_null;
        access: Words, or_null;
        readable: BooleanBuilder, or_null;
        writable: BooleanBuilder, or_null;
        exists: BooleanBuilder, or_null;
        value: Numbers<Float64Type>, or_null;
        integer: Numbers<Int64Type>, or_null;
        text: StringBuilder, or_null;
        data: BinaryBuilder, or_null;
        source: Words, or_null;
        t_ns: Numbers<Int64Type>, or_null;
        frame: Numbers<UInt64Type>, or_null;
        values: Numbers<UInt64Type>;
        read: Numbers<UInt64Type>;
        written: Numbers<UInt64Type>;
        tpdo: Numbers<UInt64Type>;
        rpdo: Numbers<UInt64Type>;
        emcy: Numbers<UInt64Type>;
        refused: Numbers<UInt64Type>;
        unconfirmed: Numbers<UInt64Type>;
        abort_codes: ListBuilder<Numbers<UInt32Type>>;
        in_force: Numbers<UInt64Type>, or_null;
        in_force_from: Words, or_null;
        first_frame: Numbers<UInt64Type>;
        last_frame: Numbers<UInt64Type>;
    }
}

/// The table, and what it is made of.
#[derive(Debug)]
pub(super) struct Od {
    /// The table.
    table: Table<Rows>,
    /// What was seen.
    pub(super) inventory: Inventory,
    lang: Lang,
}

impl Od {
    /// Nothing was seen yet.
    pub(super) fn new(table: Table<Rows>, lang: Lang) -> Self {
        Self { table, inventory: Inventory::default(), lang }
    }

    /// Nothing more comes.
    pub(super) fn finish(&mut self, done: &mut Vec<Batch>, setting: Setting<'_>) {
        let Self { table, inventory, lang } = self;
        for ((bus, id), node) in &inventory.nodes {
            for (mux, object) in &node.objects {
                table.row(done, (setting.buses.name(*bus), *id, *lang), *mux, object);
            }
        }
        table.finish(done);
    }
}

impl Table<Rows> {
    fn row(&mut self, done: &mut Vec<Batch>, (bus, node, lang): (&[u8], u8, Lang), mux: Mux, object: &ObservedObject) {
        let columns = &mut self.columns;
        columns.bus.name(bus);
        columns.node.append_value(node);
        columns.index.append_value(mux.index);
        columns.sub.append_value(mux.sub);
        let mut name = Vec::new();
        value::name(&mut name, lang, mux, &object.described);
        columns.name.name(name.trim_ascii_start());
        let known = object.data_type(mux);
        columns.r#type.maybe(known.map(|known| known.0.name()));
        columns.type_from.maybe(known.map(|known| known.1.name()));
        columns.bits.append_option(object.bits());
        columns.access.maybe(object.access());
        columns.readable.append_option(object.is_readable());
        columns.writable.append_option(object.is_writable());
        columns.exists.append_option(object.exists());
        let bytes = columns.value(lang, mux, object);
        columns.values.append_value(object.values());
        let counts = [
            (&mut columns.read, Source::Read),
            (&mut columns.written, Source::Written),
            (&mut columns.tpdo, Source::Tpdo),
            (&mut columns.rpdo, Source::Rpdo),
            (&mut columns.emcy, Source::Emcy),
            (&mut columns.refused, Source::Refused),
            (&mut columns.unconfirmed, Source::Unconfirmed),
        ];
        for (column, source) in counts {
            column.append_value(object.count(source));
        }
        for one in &object.aborted {
            columns.abort_codes.values().append_value(one.abort.code);
        }
        columns.abort_codes.append(true);
        let (in_force, from) = match object.in_force {
            InForce::Value(known) => (Some(known.value), Some(known.from.name())),
            InForce::Unknown => (None, Some("unknown")),
            InForce::Unfollowed => (None, None),
        };
        columns.in_force.append_option(in_force);
        columns.in_force_from.maybe(from);
        columns.first_frame.append_value(object.first.no);
        columns.last_frame.append_value(object.last.no);
        self.end_row(bytes, done);
    }
}

impl Rows {
    /// Appends the last value, and says how long it is.
    fn value(&mut self, lang: Lang, mux: Mux, object: &ObservedObject) -> usize {
        let held = object.value.as_ref();
        let mut text = Vec::new();
        if let Some(held) = held {
            inventory::held(&mut text, lang, mux, object, &held.value);
        }
        let (raw, bits, data) = match held.map(HeldValue::content) {
            Some(Content::Bits(raw, bits)) => (Some(raw), bits, raw.to_le_bytes().to_vec()),
            Some(Content::Bytes(bytes, size)) => {
                let number = bytes.len() as u64 == size && (1..=8).contains(&bytes.len());
                let raw = if number { extract(bytes, 0, 8 * bytes.len()) } else { None };
                (raw, 8 * bytes.len().min(8) as u8, bytes.to_vec())
            }
            Some(Content::None) | None => (None, 0, Vec::new()),
        };
        let mapped = Mapped { bits, ..inventory::mapped(mux, object) };
        let (integer, value) = raw.map_or((None, None), |raw| numbers(&mapped, raw));
        let data = if matches!(held.map(HeldValue::content), Some(Content::Bits(..))) {
            data.get(..usize::from(bits).div_ceil(8)).unwrap_or(&data)
        } else {
            &data
        };
        self.value.append_option(value);
        self.integer.append_option(integer);
        self.text.append_option(held.map(|_| lossy(&text)));
        self.data.append_option(held.map(|_| data));
        self.source.maybe(held.map(|held| held.source.name()));
        self.t_ns.append_option(held.and_then(|held| held.at.t_ns));
        self.frame.append_option(held.map(|held| held.at.no));
        text.len() + data.len()
    }
}

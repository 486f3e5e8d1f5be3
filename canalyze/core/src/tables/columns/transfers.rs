//! `transfers`: one row an SDO transfer that has ended, in the order in which they end.
//!
//! Of an ok transfer the exact value is the first of `string`, `boolean`, `integer`, `raw` and `value` that is not
//! null; all of them are null where the bytes are no value of a simple type. Must not: judge a transfer.

use arrow_array::builder::{BinaryBuilder, BooleanBuilder, ListBuilder, StringBuilder};
use arrow_array::types::{Float64Type, Int64Type, UInt8Type, UInt16Type, UInt32Type, UInt64Type};

use super::column::{Batch, Numbers, Table, Words, columns};
use crate::sdo::transfer::{Status, Transfer};
use crate::tables::jsonl::Setting;
use crate::tables::jsonl::sdo::side;
use crate::words::{terms, transferred, value};
use crate::world::configuration;
use crate::world::od::{self, DataType, Value};

columns! {
    /// The columns.
    Transfers {
        transfer: Numbers<UInt64Type>;
        bus: Words, or_null;
        node: Numbers<UInt8Type>;
        direction: Words;
        mode: Words;
        index: Numbers<UInt16Type>, or_null;
        sub: Numbers<UInt8Type>, or_null;
        object: Words, or_null;
        name: Words, or_null;
        r#type: Words, or_null;
        size_indicated: Numbers<UInt32Type>, or_null;
        size: Numbers<UInt64Type>;
        data: BinaryBuilder;
        string: StringBuilder, or_null;
        boolean: BooleanBuilder, or_null;
        integer: Numbers<Int64Type>, or_null;
        raw: Numbers<UInt64Type>, or_null;
        value: Numbers<Float64Type>, or_null;
        text: StringBuilder;
        status: Words;
        abort_code: Numbers<UInt32Type>, or_null;
        abort_by: Words, or_null;
        abort_text: Words, or_null;
        first_frame: Numbers<UInt64Type>;
        last_frame: Numbers<UInt64Type>;
        first_line: Numbers<UInt64Type>, or_null;
        last_line: Numbers<UInt64Type>, or_null;
        t_ns: Numbers<Int64Type>, or_null;
        duration_ns: Numbers<Int64Type>, or_null;
        reordered: BooleanBuilder;
        retransmissions: Numbers<UInt32Type>;
        crc_negotiated: BooleanBuilder, or_null;
        findings: ListBuilder<StringBuilder>;
    }
}

impl Table<Transfers> {
    /// Appends a transfer.
    pub(super) fn transfer(&mut self, done: &mut Vec<Batch>, setting: Setting<'_>, transfer: &Transfer) {
        let columns = &mut self.columns;
        columns.transfer.append_value(transfer.id.0);
        columns.bus.name(setting.buses.name(transfer.bus));
        columns.node.append_value(transfer.node);
        columns.direction.word(transfer.direction.name());
        columns.mode.word(transfer.mode.name());
        let data_type = object(columns, setting, transfer);
        columns.r#type.maybe(data_type.map(DataType::name));
        columns.size_indicated.append_option(transfer.data.size_indicated);
        columns.size.append_value(transfer.data.size);
        columns.data.append_value(&transfer.data.kept);
        let ok = transfer.outcome.status == Status::Ok;
        values(
            columns,
            if ok { od::decode(data_type, &transfer.data.kept) } else { Value::Empty },
            &transfer.data.kept,
        );
        let mut text = Vec::new();
        transferred::transferred(&mut text, setting.lang, transfer);
        columns.text.append_value(String::from_utf8_lossy(&text));
        columns.status.word(transfer.outcome.status.name());
        columns.abort_code.append_option(transfer.outcome.abort.map(|abort| abort.code));
        columns.abort_by.maybe(transfer.outcome.abort.map(|abort| side(abort.by)));
        columns.abort_text.maybe(transfer.outcome.abort.and_then(|abort| terms::abort_code(setting.lang, abort.code)));
        columns.first_frame.append_value(transfer.first.no);
        columns.last_frame.append_value(transfer.last.no);
        columns.first_line.append_option(transfer.first.line);
        columns.last_line.append_option(transfer.last.line);
        columns.t_ns.append_option(transfer.first.t_ns);
        columns.duration_ns.append_option(transfer.duration_ns());
        columns.reordered.append_value(transfer.outcome.reordered);
        columns.retransmissions.append_value(transfer.outcome.retransmissions);
        columns.crc_negotiated.append_option(transfer.outcome.crc_negotiated);
        for code in &transfer.outcome.findings {
            columns.findings.values().append_value(code.rule().id);
        }
        columns.findings.append(true);
        self.end_row(transfer.data.kept.len() + text.len(), done);
    }
}

/// Appends the object, and says which type it has.
fn object(columns: &mut Transfers, setting: Setting<'_>, transfer: &Transfer) -> Option<DataType> {
    columns.index.append_option(transfer.mux.map(|mux| mux.index));
    columns.sub.append_option(transfer.mux.map(|mux| mux.sub));
    let Some(mux) = transfer.mux else {
        columns.object.maybe(None);
        columns.name.maybe(None);
        return None;
    };
    columns.object.word(&format!("{:04X}:{:02X}", mux.index, mux.sub));
    let mut known = Vec::new();
    value::name(&mut known, setting.lang, mux, &transfer.described);
    // A blank stands before the name.
    columns.name.name(known.get(1..).unwrap_or(&[]));
    transfer.data_type()
}

/// Appends the value in the columns that can hold it.
fn values(columns: &mut Transfers, value: Value<'_>, bytes: &[u8]) {
    let raw = || configuration::number(bytes);
    let (mut string, mut boolean, mut integer, mut whole, mut real) = (None, None, None, None, None);
    match value {
        Value::Empty | Value::Bytes(_) | Value::Time { .. } | Value::Difference { .. } => {}
        Value::Bool(on) => {
            (boolean, integer, whole, real) = (Some(on), Some(i64::from(on)), raw(), Some(f64::from(u8::from(on))));
        }
        Value::Signed(number) => (integer, whole, real) = (Some(number), raw(), Some(number as f64)),
        Value::Unsigned(number) => {
            (integer, whole, real) = (i64::try_from(number).ok(), Some(number), Some(number as f64));
        }
        Value::Real(number) => real = Some(number),
        Value::Text(text) => string = Some(text),
    }
    columns.string.append_option(string);
    columns.boolean.append_option(boolean);
    columns.integer.append_option(integer);
    columns.raw.append_option(whole);
    columns.value.append_option(real);
}

//! `emcy`: one row an emergency, with the errors of its node after it as far as the capture shows them.
//!
//! Must not: judge.

use arrow_array::builder::{BinaryBuilder, ListBuilder};
use arrow_array::types::{Int64Type, UInt8Type, UInt16Type, UInt64Type};

use super::column::{Batch, Numbers, Table, Words, columns};
use crate::tables::jsonl::Setting;
use crate::wire::emcy;
use crate::wire::message::Message;
use crate::world::event::Event;

columns! {
    /// The columns.
    Emcy {
        t_ns: Numbers<Int64Type>, or_null;
        frame: Numbers<UInt64Type>;
        bus: Words, or_null;
        node: Numbers<UInt8Type>;
        code: Numbers<UInt16Type>;
        name: Words, or_null;
        register: Numbers<UInt8Type>;
        manufacturer: BinaryBuilder;
        active: ListBuilder<Numbers<UInt16Type>>;
        cleared: ListBuilder<Numbers<UInt16Type>>;
    }
}

impl Table<Emcy> {
    /// Appends a message, if it is an emergency.
    pub(super) fn message(&mut self, done: &mut Vec<Batch>, setting: Setting<'_>, event: &Event, message: &Message) {
        let Message::Emcy { node, code, profile, register, manufacturer, active, cleared } = *message else { return };
        let columns = &mut self.columns;
        columns.t_ns.append_option(event.at.t_ns);
        columns.frame.append_value(event.at.no);
        columns.bus.name(setting.buses.name(event.bus));
        columns.node.append_value(node);
        columns.code.append_value(code);
        columns.name.maybe(emcy::code(setting.lang, profile, code));
        columns.register.append_value(register);
        columns.manufacturer.append_value(manufacturer);
        for (column, errors) in [(&mut columns.active, active), (&mut columns.cleared, cleared)] {
            for error in errors.iter() {
                column.values().append_value(error);
            }
            column.append(true);
        }
        self.end_row(manufacturer.len(), done);
    }
}

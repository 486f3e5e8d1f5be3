//! `frames`: one row a frame that the filter lets through, as it stands in the capture.
//!
//! Must not: say what a frame means beyond its service and node.

use arrow_array::builder::{BinaryBuilder, BooleanBuilder};
use arrow_array::types::{Int64Type, UInt8Type, UInt32Type, UInt64Type};

use super::column::{Batch, Numbers, Table, Words, columns};
use crate::bytes::frame::{Direction, Frame, Kind};
use crate::tables::jsonl::Setting;

columns! {
    /// The columns.
    Frames {
        frame: Numbers<UInt64Type>;
        line: Numbers<UInt64Type>, or_null;
        file: Words;
        t_ns: Numbers<Int64Type>, or_null;
        bus: Words, or_null;
        id: Numbers<UInt32Type>;
        extended: BooleanBuilder;
        kind: Words;
        brs: BooleanBuilder, or_null;
        esi: BooleanBuilder, or_null;
        dir: Words, or_null;
        len: Numbers<UInt8Type>;
        data: BinaryBuilder;
        service: Words;
        node: Numbers<UInt8Type>, or_null;
    }
}

impl Table<Frames> {
    /// Appends a frame. `service` and `node` are those by which filters know it.
    pub(super) fn frame(
        &mut self,
        done: &mut Vec<Batch>,
        setting: Setting<'_>,
        frame: &Frame,
        (service, node): (&str, Option<u8>),
    ) {
        let columns = &mut self.columns;
        columns.frame.append_value(frame.no);
        columns.line.append_option(frame.line);
        columns.file.word(&String::from_utf8_lossy(setting.file));
        columns.t_ns.append_option(frame.t_ns);
        columns.bus.name(setting.buses.name(frame.bus));
        columns.id.append_value(frame.id.raw());
        columns.extended.append_value(frame.id.is_extended() && frame.kind != Kind::Error);
        let (kind, flags) = match frame.kind {
            Kind::Data => ("data", None),
            Kind::Remote => ("remote", None),
            Kind::Error => ("error", None),
            Kind::Fd { brs, esi } => ("fd", Some((brs, esi))),
        };
        columns.kind.word(kind);
        columns.brs.append_option(flags.map(|(brs, _)| brs));
        columns.esi.append_option(flags.map(|(_, esi)| esi));
        let direction = frame.dir.map(|direction| match direction {
            Direction::Rx => "rx",
            Direction::Tx => "tx",
        });
        columns.dir.maybe(direction);
        columns.len.append_value(frame.len);
        columns.data.append_value(frame.payload());
        columns.service.word(service);
        columns.node.append_option(node);
        self.end_row(frame.payload().len(), done);
    }
}

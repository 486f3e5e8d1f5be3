//! `listing`: one row a frame that the filter lets through, with its line as people read it.
//!
//! The line is that of `canalyze decode -t n` without bus, without what stands below it there: a list has columns of its
//! own for time and bus, and findings are in `log`. Must not: put words together.

use arrow_array::builder::StringBuilder;
use arrow_array::types::{Int64Type, UInt8Type, UInt64Type};

use super::Seen;
use super::column::{Batch, Numbers, Table, Words, columns, lossy};
use crate::bytes::frame::Frame;
use crate::rules::finding::Severity;
use crate::views::lines::Lines;
use crate::words::{Depth, Lang};
use crate::world::event::Event;

columns! {
    /// The columns.
    Rows {
        frame: Numbers<UInt64Type>;
        t_ns: Numbers<Int64Type>, or_null;
        cycle: Numbers<UInt64Type>;
        bus: Words, or_null;
        node: Numbers<UInt8Type>, or_null;
        service: Words;
        severity: Words, or_null;
        line: StringBuilder;
    }
}

/// The table, and what writes its lines.
#[derive(Debug)]
pub(super) struct Listing {
    /// The table.
    pub(super) table: Table<Rows>,
    lines: Lines,
    /// The line that is being written.
    line: Vec<u8>,
}

impl Listing {
    /// No row yet.
    pub(super) fn new(table: Table<Rows>, lang: Lang) -> Self {
        Self { table, lines: Lines::new(lang, Depth::Default, None), line: Vec::new() }
    }

    /// Appends a frame. `event`: its own one; `severity`: of the worst finding at it.
    pub(super) fn frame(
        &mut self,
        done: &mut Vec<Batch>,
        seen: Seen<'_>,
        frame: &Frame,
        event: Option<&Event>,
        severity: Option<Severity>,
    ) {
        let columns = &mut self.table.columns;
        columns.frame.append_value(frame.no);
        columns.t_ns.append_option(frame.t_ns);
        columns.cycle.append_value(seen.cycle);
        columns.bus.name(seen.setting.buses.name(frame.bus));
        let (service, node) = seen.service;
        columns.node.append_option(node);
        columns.service.word(service);
        columns.severity.maybe(severity.map(Severity::name));
        self.line.clear();
        self.lines.alone(&mut self.line, frame, event);
        columns.line.append_value(lossy(&self.line));
        self.table.end_row(self.line.len(), done);
    }
}

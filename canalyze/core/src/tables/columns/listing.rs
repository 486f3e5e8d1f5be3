//! `listing`: one row per frame that the filter lets through, with its line as people read it.
//!
//! The line is that of `canalyze decode -t n` without bus, and without the lines below it: a list has columns of its
//! own for time and bus, and findings are in `log`. Must not: put words together.

use super::column::{Batch, Table, lossy};
use super::{Collector, Ends, TableContext};
use crate::bytes::frame::Frame;
use crate::rules::finding::Severity;
use crate::tables::table::{Moment, Name, U8, U64, Utf8, Word, table};
use crate::views::lines::Lines;
use crate::words::{Depth, Lang};
use crate::world::event::Event;

/// A frame, its line, and the scene.
pub(in crate::tables) struct Listed<'a> {
    frame: &'a Frame,
    scene: TableContext<'a>,
    line: &'a [u8],
}

table! {
    /// One row per line of the annotated listing.
    /// 一行是注释列表的一行
    Lined arrow "listing", |cx, one: Listed<'_>| {
        frame: U64 = one.frame.no;
        t: Moment or null = one.frame.t_ns;
        cycle: U64 = one.scene.cycle;
        bus: Name or null = cx.setting.bus(one.frame.bus);
        node: U8 or null = one.scene.service.1;
        service: Word = one.scene.service.0;
        severity: Word or null = one.scene.severity.map(Severity::name);
        line: Utf8 = &*lossy(one.line);
    }
}

/// The table, and the renderer of its lines.
#[derive(Debug)]
pub(super) struct Listing {
    table: Table<Lined>,
    lines: Lines,
    line: Vec<u8>,
}

impl Listing {
    /// Returns a listing without rows.
    pub(super) fn new(lang: Lang) -> Self {
        Self { table: Table::default(), lines: Lines::new(lang, Depth::Default, None), line: Vec::new() }
    }
}

impl Collector for Listing {
    fn frame(&mut self, done: &mut Vec<Batch>, scene: TableContext<'_>, frame: &Frame, events: &[Event]) {
        self.line.clear();
        self.lines.alone(&mut self.line, frame, events.first());
        self.table.row(done, &scene.cx(), Listed { frame, scene, line: &self.line });
    }

    fn table(&mut self) -> &mut dyn Ends {
        &mut self.table
    }
}

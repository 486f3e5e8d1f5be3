//! `log`: one row per finding or emergency, as people read it.
//!
//! Findings are those of `findings`, repeats folded alike. One about the capture, which belongs to no frame, is listed
//! at the last frame before it. An emergency is an error; with code 00xxh (error reset or no error) it is information.
//! Must not: judge.

use super::column::{Batch, Table, lossy};
use super::{Collector, Ends, TableContext};
use crate::bytes::frame::{BusId, Frame, FrameRef};
use crate::rules::finding::{Finding, Severity};
use crate::tables::table::{Moment, Name, U8, U64, Utf8, Word, table};
use crate::wire::message::Message;
use crate::words::{Depth, findings, services};
use crate::world::event::{Event, What};

/// A line of the log.
#[derive(Clone, Copy)]
pub(in crate::tables) struct Entry<'a> {
    at: FrameRef,
    cycle: u64,
    bus: BusId,
    node: Option<u8>,
    level: Severity,
    source: &'static str,
    code: &'a str,
    text: &'a [u8],
}

table! {
    /// One row per finding or EMCY, in words.
    /// 一行是一条检查结果或一个紧急报文
    Entries arrow "log", |cx, one: Entry<'_>| {
        t: Moment or null = one.at.t_ns;
        frame: U64 = one.at.no;
        cycle: U64 = one.cycle;
        bus: Name or null = cx.setting.bus(one.bus);
        node: U8 or null = one.node;
        /// severity
        /// 级别
        level: Word = one.level.name();
        source: Word = one.source;
        /// code of the rule, or EMCY error code
        /// 代码：规则代码或EMCY错误码
        code: Word = one.code;
        text: Utf8 = &*lossy(one.text);
    }
}

/// The table, and the text that is being written.
#[derive(Debug, Default)]
pub(super) struct Log {
    table: Table<Entries>,
    text: Vec<u8>,
}

impl Collector for Log {
    fn frame(&mut self, done: &mut Vec<Batch>, scene: TableContext<'_>, frame: &Frame, events: &[Event]) {
        for event in events {
            let What::Message(message) = &event.what else { continue };
            let Message::Emcy { node, code, .. } = *message else { continue };
            self.text.clear();
            services::message(&mut self.text, scene.setting.lang, Depth::Default, message, frame);
            let entry = Entry {
                at: event.at,
                cycle: scene.cycle,
                bus: event.bus,
                node: Some(node),
                level: if code >> 8 == 0 { Severity::Info } else { Severity::Error },
                source: "emcy",
                code: &format!("{code:04X}"),
                text: &self.text,
            };
            self.table.row(done, &scene.cx(), entry);
        }
    }

    fn finding(&mut self, done: &mut Vec<Batch>, scene: TableContext<'_>, finding: &Finding) {
        let at = if finding.at.no > 0 { finding.at } else { scene.last };
        self.text.clear();
        findings::placed(&mut self.text, scene.setting.lang, finding, finding.at.no);
        let entry = Entry {
            at,
            cycle: scene.cycles.at(finding.bus, at.no),
            bus: finding.bus,
            node: finding.node,
            level: finding.severity(),
            source: "finding",
            code: finding.code.rule().id,
            text: &self.text,
        };
        self.table.row(done, &scene.cx(), entry);
    }

    fn table(&mut self) -> &mut dyn Ends {
        &mut self.table
    }
}

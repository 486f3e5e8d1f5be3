//! `log`: one row a finding or an emergency, as people read it.
//!
//! Findings are those of `findings`, repeats folded alike. One about the capture, which belongs to no frame, stands at
//! the last frame before it. An emergency is an error, its code 00xxh (error reset or no error) is information.
//! Must not: judge.

use arrow_array::builder::StringBuilder;
use arrow_array::types::{Int64Type, UInt8Type, UInt64Type};

use super::Seen;
use super::column::{Batch, Numbers, Table, Words, columns};
use super::cycle_numbers::CycleNumbers;
use crate::bytes::frame::{BusId, Frame, FrameRef};
use crate::rules::finding::{Finding, Severity};
use crate::tables::jsonl::Setting;
use crate::wire::message::Message;
use crate::words::digits::{Hex, put};
use crate::words::{Depth, Lang, findings, services};
use crate::world::event::Event;

columns! {
    /// The columns.
    Rows {
        t_ns: Numbers<Int64Type>, or_null;
        frame: Numbers<UInt64Type>;
        cycle: Numbers<UInt64Type>;
        bus: Words, or_null;
        node: Numbers<UInt8Type>, or_null;
        level: Words;
        source: Words;
        code: Words;
        text: StringBuilder;
    }
}

/// The table, and its language.
#[derive(Debug)]
pub(super) struct Log {
    /// The table.
    pub(super) table: Table<Rows>,
    lang: Lang,
    /// The text that is being written.
    text: Vec<u8>,
}

impl Log {
    /// No row yet.
    pub(super) fn new(table: Table<Rows>, lang: Lang) -> Self {
        Self { table, lang, text: Vec::new() }
    }

    /// Appends a message, if it is an emergency.
    pub(super) fn message(
        &mut self,
        done: &mut Vec<Batch>,
        seen: Seen<'_>,
        frame: &Frame,
        event: &Event,
        message: &Message,
    ) {
        let Message::Emcy { node, code, .. } = *message else { return };
        self.text.clear();
        services::message(&mut self.text, self.lang, Depth::Default, message, frame);
        let level = if code >> 8 == 0 { Severity::Info } else { Severity::Error };
        let mut word = Vec::new();
        put!(&mut word; Hex::<4>(u64::from(code)));
        self.row(done, seen.setting, (event.at, seen.cycle, event.bus, Some(node)), (level, "emcy"), &word);
    }

    /// Appends a finding. `last`: the last frame of the capture so far.
    pub(super) fn finding(
        &mut self,
        done: &mut Vec<Batch>,
        setting: Setting<'_>,
        cycles: &CycleNumbers,
        finding: &Finding,
        last: FrameRef,
    ) {
        let rule = finding.code.rule();
        let at = if finding.at.no > 0 { finding.at } else { last };
        self.text.clear();
        findings::placed(&mut self.text, self.lang, finding, finding.at.no);
        let cycle = cycles.at(finding.bus, at.no);
        let place = (at, cycle, finding.bus, finding.node);
        self.row(done, setting, place, (finding.severity(), "finding"), rule.id.as_bytes());
    }

    fn row(
        &mut self,
        done: &mut Vec<Batch>,
        setting: Setting<'_>,
        (at, cycle, bus, node): (FrameRef, u64, BusId, Option<u8>),
        (level, source): (Severity, &str),
        code: &[u8],
    ) {
        let columns = &mut self.table.columns;
        columns.t_ns.append_option(at.t_ns);
        columns.frame.append_value(at.no);
        columns.cycle.append_value(cycle);
        columns.bus.name(setting.buses.name(bus));
        columns.node.append_option(node);
        columns.level.word(level.name());
        columns.source.word(source);
        columns.code.word(&String::from_utf8_lossy(code));
        columns.text.append_value(String::from_utf8_lossy(&self.text));
        self.table.end_row(self.text.len(), done);
    }
}

//! `incidents`: one row an incident, as they stand at the end of the capture, in the order in which a person reads them.
//!
//! A cause stands before what it has caused, which has one more `depth`. Must not: judge.

use arrow_array::builder::StringBuilder;
use arrow_array::types::{Int64Type, UInt8Type, UInt64Type};

use super::column::{Batch, Numbers, Table, Words, columns};
use super::cycle_numbers::CycleNumbers;
use crate::diagnosis::incident::{Incident, members};
use crate::diagnosis::rank::{is_root, stories};
use crate::diagnosis::{Diagnosis, advice};
use crate::render::jsonl::Setting;
use crate::text::digits::put;
use crate::text::incidents as words;

columns! {
    /// The columns.
    Incidents {
        incident: Numbers<UInt64Type>;
        kind: Words;
        status: Words;
        impact: Words;
        depth: Numbers<UInt64Type>;
        bus: Words, or_null;
        node: Numbers<UInt8Type>, or_null;
        subject: Words;
        t_ns: Numbers<Int64Type>, or_null;
        frame: Numbers<UInt64Type>;
        cycle: Numbers<UInt64Type>;
        end_t_ns: Numbers<Int64Type>, or_null;
        end_frame: Numbers<UInt64Type>, or_null;
        end_cycle: Numbers<UInt64Type>, or_null;
        cause: Numbers<UInt64Type>, or_null;
        cause_grade: Words, or_null;
        delay_ns: Numbers<Int64Type>, or_null;
        text: StringBuilder;
        checks: StringBuilder;
    }
}

impl Table<Incidents> {
    /// Appends all of them.
    pub(super) fn diagnosis(
        &mut self,
        done: &mut Vec<Batch>,
        setting: Setting<'_>,
        cycles: &CycleNumbers,
        diagnosis: &Diagnosis,
    ) {
        for (id, depth) in stories(diagnosis.ledger()) {
            if let Some(one) = diagnosis.ledger().by_id(id) {
                self.incident(done, setting, cycles, diagnosis, (one, depth));
            }
        }
    }

    fn incident(
        &mut self,
        done: &mut Vec<Batch>,
        setting: Setting<'_>,
        cycles: &CycleNumbers,
        diagnosis: &Diagnosis,
        (one, depth): (&Incident, u64),
    ) {
        let columns = &mut self.columns;
        let row = one.kind.row();
        columns.incident.append_value(u64::from(one.id.0));
        columns.kind.word(row.name);
        columns.status.word(one.status.name());
        columns.impact.word(one.impact().name());
        columns.depth.append_value(depth);
        columns.bus.name(setting.buses.name(one.bus));
        columns.node.append_option(one.subject.node);
        columns.subject.word(&subject(one));
        columns.t_ns.append_option(one.begin.t_ns);
        columns.frame.append_value(one.begin.no);
        columns.cycle.append_value(cycles.at(one.bus, one.begin.no));
        columns.end_t_ns.append_option(one.end.and_then(|end| end.t_ns));
        columns.end_frame.append_option(one.end.map(|end| end.no));
        columns.end_cycle.append_option(one.end.map(|end| cycles.at(one.bus, end.no)));
        let link = one.cause.filter(|_| !is_root(one));
        columns.cause.append_option(link.map(|link| u64::from(link.cause.0)));
        columns.cause_grade.maybe(link.map(|link| link.grade.name()));
        columns.delay_ns.append_option(link.and_then(|link| link.delay_ns));
        let began_ns = diagnosis.extent().1.and_then(|first| first.t_ns);
        let (mut text, mut checks) = (Vec::new(), Vec::new());
        words::title(&mut text, setting.lang, one, began_ns);
        columns.text.append_value(String::from_utf8_lossy(&text));
        for (place, check) in advice::of(one, diagnosis.shown()).iter().enumerate() {
            put!(&mut checks; if place > 0 { "\n" } else { "" }, setting.lang.of(check.words));
        }
        columns.checks.append_value(String::from_utf8_lossy(&checks));
        self.end_row(text.len() + checks.len(), done);
    }
}

/// To whom it happened, as a part of a path: `node5`, `nodes3-4`, `bus`.
fn subject(one: &Incident) -> String {
    let mut out = Vec::new();
    match one.subject.node {
        Some(node) => put!(&mut out; "node", node),
        None if one.subject.nodes == 0 => put!(&mut out; "bus"),
        None => {
            let word = if one.subject.nodes.count_ones() == 1 { "node" } else { "nodes" };
            for (place, node) in members(one.subject.nodes).enumerate() {
                put!(&mut out; if place > 0 { "-" } else { word }, node);
            }
        }
    }
    String::from_utf8_lossy(&out).into_owned()
}

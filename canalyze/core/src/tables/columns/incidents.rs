//! `incidents`: one row an incident, as they stand at the end of the capture, in the order in which a person reads them.
//!
//! A cause stands before what it has caused, which has one more `depth`. Must not: judge.

use arrow_array::builder::{BooleanBuilder, ListBuilder, StringBuilder};
use arrow_array::types::{Int64Type, UInt8Type, UInt32Type, UInt64Type};

use super::column::{Batch, Numbers, Table, Words, columns};
use super::cycle_numbers::CycleNumbers;
use crate::stories::incident::{Incident, members};
use crate::stories::rank::{is_root, stories};
use crate::stories::{Diagnosis, advice};
use crate::tables::jsonl::{self, Setting};
use crate::words::digits::put;
use crate::words::incidents;

columns! {
    /// The columns.
    Incidents {
        id: Numbers<UInt32Type>;
        incident: Words;
        status: Words;
        impact: Words;
        grade: Words;
        depth: Numbers<UInt64Type>;
        bus: Words, or_null;
        node: Numbers<UInt8Type>, or_null;
        nodes: ListBuilder<Numbers<UInt8Type>>;
        axis: Numbers<UInt8Type>, or_null;
        pdo: Words, or_null;
        subject: Words;
        begin_frame: Numbers<UInt64Type>;
        t_ns: Numbers<Int64Type>, or_null;
        cycle: Numbers<UInt64Type>;
        noticed_frame: Numbers<UInt64Type>;
        noticed_t_ns: Numbers<Int64Type>, or_null;
        end_frame: Numbers<UInt64Type>, or_null;
        end_t_ns: Numbers<Int64Type>, or_null;
        end_cycle: Numbers<UInt64Type>, or_null;
        count: Numbers<UInt64Type>;
        root: BooleanBuilder;
        cause: Numbers<UInt32Type>, or_null;
        cause_link: Words, or_null;
        cause_grade: Words, or_null;
        delay_ns: Numbers<Int64Type>, or_null;
        frames: ListBuilder<Numbers<UInt64Type>>;
        message: StringBuilder;
        checks: StringBuilder;
        facts: StringBuilder;
    }
}

impl Table<Incidents> {
    /// Appends all that went wrong.
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
        columns.id.append_value(one.number);
        columns.incident.word(one.kind.row().name);
        columns.status.word(one.status.name());
        columns.impact.word(one.impact().name());
        columns.grade.word(one.grade.name());
        columns.depth.append_value(depth);
        columns.bus.name(setting.buses.name(one.bus));
        columns.node.append_option(one.subject.node);
        members(one.subject.nodes).for_each(|node| columns.nodes.values().append_value(node));
        columns.nodes.append(true);
        columns.axis.append_option(one.subject.axis);
        let side = |transmit| if transmit { "TPDO" } else { "RPDO" };
        columns.pdo.maybe(one.subject.pdo.map(|(transmit, number)| format!("{}{number}", side(transmit))).as_deref());
        columns.subject.word(&subject(one));
        columns.begin_frame.append_value(one.begin.no);
        columns.t_ns.append_option(one.begin.t_ns);
        columns.cycle.append_value(cycles.at(one.bus, one.begin.no));
        columns.noticed_frame.append_value(one.noticed.no);
        columns.noticed_t_ns.append_option(one.noticed.t_ns);
        columns.end_frame.append_option(one.end.map(|end| end.no));
        columns.end_t_ns.append_option(one.end.and_then(|end| end.t_ns));
        columns.end_cycle.append_option(one.end.map(|end| cycles.at(one.bus, end.no)));
        columns.count.append_value(one.repeats.count);
        columns.root.append_value(is_root(one));
        let cause = one.cause.filter(|_| !is_root(one));
        columns.cause.append_option(cause.map(|link| diagnosis.ledger().number(link.cause)));
        columns.cause_link.maybe(cause.map(|link| format!("L{}", link.rule)).as_deref());
        columns.cause_grade.maybe(cause.map(|link| link.grade.name()));
        columns.delay_ns.append_option(cause.and_then(|link| link.delay_ns));
        frames(one).into_iter().for_each(|frame| columns.frames.values().append_value(frame));
        columns.frames.append(true);
        let began_ns = diagnosis.extent().1.and_then(|first| first.t_ns);
        let (mut message, mut checks) = (Vec::new(), Vec::new());
        incidents::title(&mut message, setting.lang, one, began_ns);
        columns.message.append_value(String::from_utf8_lossy(&message));
        for (place, check) in advice::of(one, diagnosis.shown()).iter().enumerate() {
            put!(&mut checks; if place > 0 { "\n" } else { "" }, setting.lang.of(check.words));
        }
        columns.checks.append_value(String::from_utf8_lossy(&checks));
        let mut facts = Vec::new();
        jsonl::diagnosis::facts_of(&mut facts, one);
        columns.facts.append_value(String::from_utf8_lossy(&facts));
        self.end_row(message.len() + checks.len() + facts.len(), done);
    }
}

/// The frames that are its evidence, ascending.
fn frames(one: &Incident) -> Vec<u64> {
    let steps = one.steps.iter().map(|step| step.at.no);
    let mut frames: Vec<_> =
        [one.begin.no, one.noticed.no].into_iter().chain(one.end.map(|end| end.no)).chain(steps).collect();
    frames.sort_unstable();
    frames.dedup();
    frames
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

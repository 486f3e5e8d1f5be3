//! `incidents`: one row an incident, in the order of their numbers, all at the end of the capture.
//!
//! Must not: judge.

use arrow_array::builder::{BooleanBuilder, ListBuilder, StringBuilder};
use arrow_array::types::{Int64Type, UInt8Type, UInt32Type, UInt64Type};

use super::column::{Batch, Numbers, Table, Words, columns};
use crate::diagnosis::Diagnosis;
use crate::diagnosis::incident::{Incident, members};
use crate::diagnosis::rank::is_root;
use crate::render::jsonl::{self, Setting};
use crate::text::incidents;

columns! {
    /// The columns.
    Incidents {
        id: Numbers<UInt32Type>;
        incident: Words;
        status: Words;
        impact: Words;
        grade: Words;
        bus: Words, or_null;
        node: Numbers<UInt8Type>, or_null;
        nodes: ListBuilder<Numbers<UInt8Type>>;
        axis: Numbers<UInt8Type>, or_null;
        pdo: Words, or_null;
        begin_frame: Numbers<UInt64Type>;
        t_ns: Numbers<Int64Type>, or_null;
        noticed_frame: Numbers<UInt64Type>;
        noticed_t_ns: Numbers<Int64Type>, or_null;
        end_frame: Numbers<UInt64Type>, or_null;
        end_t_ns: Numbers<Int64Type>, or_null;
        count: Numbers<UInt64Type>;
        root: BooleanBuilder;
        cause: Numbers<UInt32Type>, or_null;
        cause_link: Words, or_null;
        cause_grade: Words, or_null;
        frames: ListBuilder<Numbers<UInt64Type>>;
        message: StringBuilder;
        facts: StringBuilder;
    }
}

impl Table<Incidents> {
    /// Appends all that went wrong.
    pub(super) fn diagnosis(&mut self, done: &mut Vec<Batch>, setting: Setting<'_>, diagnosis: &Diagnosis) {
        let began_ns = diagnosis.extent().1.and_then(|first| first.t_ns);
        for one in diagnosis.ledger().told() {
            self.incident(done, setting, one, began_ns);
        }
    }

    fn incident(&mut self, done: &mut Vec<Batch>, setting: Setting<'_>, one: &Incident, began_ns: Option<i64>) {
        let columns = &mut self.columns;
        columns.id.append_value(one.id.0);
        columns.incident.word(one.kind.row().name);
        columns.status.word(one.status.name());
        columns.impact.word(one.impact().name());
        columns.grade.word(one.grade.name());
        columns.bus.name(setting.buses.name(one.bus));
        columns.node.append_option(one.subject.node);
        members(one.subject.nodes).for_each(|node| columns.nodes.values().append_value(node));
        columns.nodes.append(true);
        columns.axis.append_option(one.subject.axis);
        let side = |transmit| if transmit { "TPDO" } else { "RPDO" };
        columns.pdo.maybe(one.subject.pdo.map(|(transmit, number)| format!("{}{number}", side(transmit))).as_deref());
        columns.begin_frame.append_value(one.begin.no);
        columns.t_ns.append_option(one.begin.t_ns);
        columns.noticed_frame.append_value(one.noticed.no);
        columns.noticed_t_ns.append_option(one.noticed.t_ns);
        columns.end_frame.append_option(one.end.map(|end| end.no));
        columns.end_t_ns.append_option(one.end.and_then(|end| end.t_ns));
        columns.count.append_value(one.repeats.count);
        columns.root.append_value(is_root(one));
        let cause = one.cause.filter(|_| !is_root(one));
        columns.cause.append_option(cause.map(|link| link.cause.0));
        columns.cause_link.maybe(cause.map(|link| format!("L{}", link.rule)).as_deref());
        columns.cause_grade.maybe(cause.map(|link| link.grade.name()));
        frames(one).into_iter().for_each(|frame| columns.frames.values().append_value(frame));
        columns.frames.append(true);
        let mut message = Vec::new();
        incidents::title(&mut message, setting.lang, one, began_ns);
        columns.message.append_value(String::from_utf8_lossy(&message));
        let mut facts = Vec::new();
        jsonl::diagnosis::facts_of(&mut facts, one);
        columns.facts.append_value(String::from_utf8_lossy(&facts));
        self.end_row(message.len() + facts.len(), done);
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

//! `findings`: one row a finding, repeats folded as in lines for people.
//!
//! Must not: judge.

use arrow_array::builder::StringBuilder;
use arrow_array::types::{Int64Type, UInt8Type, UInt16Type, UInt64Type};

use super::column::{Batch, Numbers, Table, Words, columns};
use crate::rules::finding::Finding;
use crate::tables::jsonl::{self, Setting};
use crate::words::findings;

columns! {
    /// The columns.
    Findings {
        code: Words;
        name: Words;
        severity: Words;
        file: Words;
        frame: Numbers<UInt64Type>, or_null;
        line: Numbers<UInt64Type>, or_null;
        t_ns: Numbers<Int64Type>, or_null;
        cause_frame: Numbers<UInt64Type>, or_null;
        cause_line: Numbers<UInt64Type>, or_null;
        about_frame: Numbers<UInt64Type>, or_null;
        because_of: Numbers<UInt64Type>, or_null;
        bus: Words, or_null;
        node: Numbers<UInt8Type>, or_null;
        index: Numbers<UInt16Type>, or_null;
        sub: Numbers<UInt8Type>, or_null;
        message: StringBuilder;
        facts: StringBuilder;
    }
}

impl Table<Findings> {
    /// Appends a finding.
    pub(super) fn finding(&mut self, done: &mut Vec<Batch>, setting: Setting<'_>, finding: &Finding) {
        let columns = &mut self.columns;
        let rule = finding.code.rule();
        columns.code.word(rule.id);
        columns.name.word(rule.name);
        columns.severity.word(finding.severity().name());
        columns.file.word(&String::from_utf8_lossy(setting.file));
        columns.frame.append_option((finding.at.no > 0).then_some(finding.at.no));
        columns.line.append_option(finding.at.line);
        columns.t_ns.append_option(finding.at.t_ns);
        columns.cause_frame.append_option(finding.cause.map(|cause| cause.no));
        columns.cause_line.append_option(finding.cause.and_then(|cause| cause.line));
        columns.about_frame.append_option(finding.about().map(|about| about.no));
        columns.because_of.append_option(finding.because_of.map(|cause| cause.no));
        columns.bus.name(setting.buses.name(finding.bus));
        columns.node.append_option(finding.node);
        columns.index.append_option(finding.object.map(|object| object.index));
        columns.sub.append_option(finding.object.map(|object| object.sub));
        let mut message = Vec::new();
        findings::message(&mut message, setting.lang, finding);
        columns.message.append_value(String::from_utf8_lossy(&message));
        let mut facts = Vec::new();
        jsonl::facts::facts(&mut facts, finding);
        columns.facts.append_value(String::from_utf8_lossy(&facts));
        self.end_row(message.len() + facts.len(), done);
    }
}

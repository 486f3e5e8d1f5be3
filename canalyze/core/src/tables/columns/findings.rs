//! `findings`: one row per finding, repeats folded as in lines for people.
//!
//! `message` is about `cause_frame`, where there is one. Must not: judge.

use super::column::{Batch, Table};
use super::{Collector, Ends, TableContext};
use crate::rules::finding::Finding;
use crate::tables::jsonl::facts;
use crate::tables::setting::{Setting, quoted};
use crate::tables::table::{Given, Hex4, Json, List, Moment, Name, Text, U8, U64, Word, list, table};
use crate::views::finding_context::HeldFrame;
use crate::views::lines::Lines;
use crate::words::digits::put;
use crate::words::{Depth, findings};

/// A finding, and the frames of its context where their lines are listed.
#[derive(Clone, Copy)]
pub(in crate::tables) struct FoundFinding<'a> {
    pub(in crate::tables) finding: &'a Finding,
    pub(in crate::tables) context: Option<&'a [&'a HeldFrame]>,
}

table! {
    /// One row per finding.
    /// 一行是一条检查结果
    Findings arrow "findings" json "finding", |cx, one: FoundFinding<'_>| {
        /// code of the rule
        /// 规则代码
        code: Word = one.finding.code.rule().id;
        /// name of the rule
        /// 规则名
        name: Word = one.finding.code.rule().name;
        severity: Word = one.finding.severity().name();
        file: Given = cx.setting.file;
        frame: U64 or null = Some(one.finding.at.no).filter(|no| *no > 0);
        line: U64 or null = one.finding.at.line();
        t: Moment or null = one.finding.at.t_ns;
        /// frame that caused it
        /// 引起它的帧
        cause_frame: U64 or null = one.finding.cause.map(|cause| cause.no);
        /// line of that frame
        /// 引起它的帧的行号
        cause_line: U64 or null = one.finding.cause.and_then(|cause| cause.line());
        /// frame that it is about
        /// 它所说的帧
        about_frame: U64 or null = one.finding.about().map(|about| about.no);
        /// the finding of which it is a consequence
        /// 它是哪一条检查结果的后果
        because_of: U64 or null = one.finding.because_of.map(|cause| cause.no);
        bus: Name or null = cx.setting.bus(one.finding.bus);
        node: U8 or null = one.finding.node;
        index: Hex4 or null = one.finding.object.map(|object| object.index);
        sub: U8 or null = one.finding.object.map(|object| object.sub);
        message: Text = |out: &mut Vec<u8>| findings::message(out, cx.setting.lang, one.finding);
        facts: Json = |out: &mut Vec<u8>| facts::facts(out, one.finding);
        /// the annotated lines of its context, oldest first: the frame and its text
        /// 相关各帧的注释行，由先到后：帧号和文字
        lines: List in optional = one.context.map(|held| |out: &mut Vec<u8>| lines(out, cx.setting, held));
    }
}

impl Collector for Table<Findings> {
    fn finding(&mut self, done: &mut Vec<Batch>, scene: TableContext<'_>, finding: &Finding) {
        self.row(done, &scene.cx(), FoundFinding { finding, context: None });
    }

    fn table(&mut self) -> &mut dyn Ends {
        self
    }
}

fn lines(out: &mut Vec<u8>, setting: Setting<'_>, context: &[&HeldFrame]) {
    let mut lines = Lines::new(setting.lang, Depth::Default, None);
    lines.clock = setting.clock;
    list(out, context, |out, held| {
        put!(out; "{\"frame\":", held.frame.no, ",\"text\":");
        quoted(out, |text| {
            lines.frame(text, &held.frame, held.event.as_slice(), setting.buses);
            text.pop();
        });
        put!(out; "}");
    });
}

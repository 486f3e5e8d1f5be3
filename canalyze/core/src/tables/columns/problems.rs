//! `problems`: one row per problem at the end of the capture, in reading order.
//!
//! A cause is before its consequences, which have one more `depth`. Must not: judge.

use super::column::{Batch, Table};
use super::{Collector, Ends, TableContext};
use crate::problems::problem::{Link, Problem, members};
use crate::problems::rank::{is_root, stories};
use crate::problems::{Diagnosis, advice};
use crate::tables::jsonl;
use crate::tables::setting::Setting;
use crate::tables::table::{Duration, Json, Moment, Name, Text, Truth, U8, U8s, U32, U64, U64s, Word, table};
use crate::words::digits::put;
use crate::words::problems;

/// A problem, and the diagnosis that it is in.
#[derive(Clone, Copy)]
pub(in crate::tables) struct ProblemRow<'a> {
    one: &'a Problem,
    depth: u64,
    scene: TableContext<'a>,
    diagnosis: &'a Diagnosis,
}

impl<'a> ProblemRow<'a> {
    fn cycle(self, frame: u64) -> u64 {
        self.scene.cycles.at(self.one.bus, frame)
    }
}

table! {
    /// One row per problem, known at the end of the capture; a cause comes before its consequences.
    /// 一行是一个问题，读完整个记录后得出；原因排在它引起的问题之前
    Problems arrow "problems", |cx, of: ProblemRow<'_>| {
        /// number of the problem
        /// 问题编号
        id: U32 = of.one.number;
        /// kind, as node-silent
        /// 问题类型，如 node-silent
        problem: Word = of.one.kind.row().name;
        /// open, ended, harmless or unknown
        /// open（仍存在）、ended（已恢复）、harmless（无害）、unknown（未知）
        status: Word = of.one.status.name();
        /// impact, A (worst) and on
        /// 影响等级 A至E
        impact: Word = of.one.impact().name();
        /// how sure it is
        /// 把握程度
        grade: Word = of.one.grade.name();
        /// depth in the tree of causes, 0 is a root
        /// 因果层次，0为根
        depth: U64 = of.depth;
        bus: Name or null = cx.setting.bus(of.one.bus);
        node: U8 or null = of.one.subject.node;
        /// nodes concerned
        /// 涉及的节点
        nodes: U8s = members(of.one.subject.nodes);
        /// axis (CiA 402)
        /// 轴号（CiA 402）
        axis: U8 or null = of.one.subject.axis;
        pdo: Word or null = pdo(of.one).as_deref();
        /// what it is about: a node, a bus, a PDO
        /// 对象：哪个节点、总线或PDO
        subject: Word = &*subject(of.one);
        /// frame of its first sign
        /// 第一个迹象所在的帧
        begin_frame: U64 = of.one.begin.listed().no;
        t: Moment or null = of.one.begin.listed().t_ns;
        cycle: U64 = of.cycle(of.one.begin.listed().no);
        /// frame from which it could be known
        /// 能够判定时的帧
        noticed_frame: U64 = of.one.noticed.listed().no;
        /// time from which it could be known
        /// 能够判定的时刻
        noticed_t: Moment or null = of.one.noticed.listed().t_ns;
        /// frame of its end; empty while it is open
        /// 结束时的帧；仍存在时为空
        end_frame: U64 or null = of.one.end.map(|end| end.listed().no);
        /// time of its end
        /// 结束时刻
        end_t: Moment or null = of.one.end.and_then(|end| end.listed().t_ns);
        /// SYNC cycle of its end
        /// 结束时的同步周期
        end_cycle: U64 or null = of.one.end.map(|end| of.cycle(end.listed().no));
        /// how many times
        /// 次数
        count: U64 = of.one.repeats.count;
        /// no consequence of another problem
        /// 不是其他问题的后果
        root: Truth = is_root(of.one);
        /// the problem that caused it (column id)
        /// 原因的编号（id列）
        cause: U32 or null = cause(of.one).map(|link| of.diagnosis.ledger().number(link.cause));
        /// kind of the causal link
        /// 因果关系的类型
        cause_link: Word or null = cause(of.one).map(|link| format!("L{}", link.rule)).as_deref();
        /// how sure the link is
        /// 因果关系的把握程度
        cause_grade: Word or null = cause(of.one).map(|link| link.grade.name());
        /// since the cause began
        /// 距原因开始
        delay: Duration or null = cause(of.one).and_then(|link| link.delay_ns);
        /// frames that show it
        /// 依据的帧号
        frames: U64s = frames(of.one);
        message: Text = |out: &mut Vec<u8>| {
            let began_ns = of.diagnosis.extent().1.and_then(|first| first.t_ns);
            problems::title(out, cx.setting.lang, of.one, began_ns);
        };
        /// what to check first
        /// 应先检查什么
        checks: Text = |out: &mut Vec<u8>| checks(out, cx.setting, of);
        facts: Json = |out: &mut Vec<u8>| jsonl::diagnosis::facts_of(out, of.one);
    }
}

impl Collector for Table<Problems> {
    fn diagnosis(&mut self, done: &mut Vec<Batch>, scene: TableContext<'_>, diagnosis: &Diagnosis) {
        for (id, depth) in stories(diagnosis.ledger()) {
            if let Some(one) = diagnosis.ledger().by_id(id) {
                self.row(done, &scene.cx(), ProblemRow { one, depth, scene, diagnosis });
            }
        }
    }

    fn table(&mut self) -> &mut dyn Ends {
        self
    }
}

fn cause(one: &Problem) -> Option<Link> {
    one.cause.filter(|_| !is_root(one))
}

fn pdo(one: &Problem) -> Option<String> {
    one.subject.pdo.map(|(transmit, number)| format!("{}{number}", if transmit { "TPDO" } else { "RPDO" }))
}

fn checks(out: &mut Vec<u8>, setting: Setting<'_>, of: ProblemRow<'_>) {
    for (place, check) in advice::of(of.one, of.diagnosis.shown()).iter().enumerate() {
        put!(out; if place > 0 { "\n" } else { "" }, setting.lang.of(check.words));
    }
}

/// The frames that are its evidence, ascending.
fn frames(one: &Problem) -> Vec<u64> {
    let steps = one.steps.iter().map(|step| step.at);
    let mut frames: Vec<_> =
        [one.begin, one.noticed].into_iter().chain(one.end).chain(steps).map(|at| at.listed().no).collect();
    frames.sort_unstable();
    frames.dedup();
    frames
}

/// The subject as a part of a path: `node5`, `nodes3-4`, `bus`.
fn subject(one: &Problem) -> String {
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

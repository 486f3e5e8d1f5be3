//! The problems so far, in reading order.
//!
//! While the capture continues, they are shown as if it had ended now; those that may still change are marked. Problems
//! are not judged here, and nothing is kept between snapshots.

use super::clock::CaptureClock;
use super::{Known, Monitor};
use crate::bytes::frame::BusId;
use crate::problems::problem::{Problem, ProblemId, Status, members};
use crate::problems::rank::{is_root, stories};
use crate::problems::{Diagnosis, advice};
use crate::tables::jsonl::Setting;
use crate::tables::jsonl::obj::{WriteJson, array, obj, text};
use crate::words::{Lang, problems as words};

/// Maximum number of rows.
const ROWS: usize = 256;

/// The present problems.
pub(super) struct Problems<'a> {
    clock: CaptureClock,
    /// The diagnosis while the capture continues; `None` without problems.
    told: Option<&'a Diagnosis>,
    /// The diagnosis as if the capture had ended now.
    now: Option<&'a Diagnosis>,
    /// In reading order, with the number of causes above each.
    order: Vec<(ProblemId, u64)>,
}

impl<'a> Problems<'a> {
    /// Takes the present knowledge.
    pub(super) fn new(monitor: &Monitor, known: Known<'a>) -> Self {
        let told = known.diagnosis.filter(|one| !one.is_empty());
        let now = told.and(known.by_now);
        let order = now.map_or_else(Vec::new, |now| stories(now.ledger()));
        Self { clock: monitor.clock, told, now, order }
    }

    /// The number of those for which there is no room.
    pub(super) fn more(&self) -> u64 {
        let beyond = self.now.map_or(0, |now| now.ledger().beyond());
        beyond + self.order.len().saturating_sub(ROWS) as u64
    }

    /// Returns the rows.
    pub(super) fn list(&self, setting: Setting<'a>) -> impl WriteJson {
        array(self.rows().take(ROWS).map(move |(one, depth)| self.row(setting, one, depth)))
    }

    /// Returns the first problem that concerns a node and is not over.
    pub(super) fn of_node(&self, lang: Lang, bus: BusId, node: u8) -> Option<impl WriteJson> {
        let mine = |one: &&Problem| {
            one.bus == bus && one.subject.concerns(node) && matches!(one.status, Status::Open | Status::Unknown)
        };
        let one = self.rows().map(|(one, _)| one).find(mine)?;
        Some(obj! {
            "id": one.number, "word": lang.of(one.kind.row().words), "provisional": self.is_provisional(one),
        })
    }

    fn rows(&self) -> impl Iterator<Item = (&Problem, u64)> {
        self.order.iter().filter_map(|(id, depth)| Some((self.now?.ledger().by_id(*id)?, *depth)))
    }

    /// Returns true if the rest of the capture may change it.
    fn is_provisional(&self, one: &Problem) -> bool {
        let settled = self.told.is_none_or(|told| told.is_settled(one, self.clock.now_ns));
        self.told.is_some_and(|told| !told.is_over()) && (one.status == Status::Unknown || !settled)
    }

    fn row<'b>(&'b self, setting: Setting<'a>, one: &'b Problem, depth: u64) -> impl WriteJson {
        let row = one.kind.row();
        let link = one.cause.filter(|_| !is_root(one));
        let shown = self.now.map(|now| now.shown()).unwrap_or_default();
        obj! {
            "id": one.number, "kind": row.name,
            "word": setting.lang.of(row.words),
            "status": one.status.name(),
            /// It may still change.
            "provisional": self.is_provisional(one),
            "impact": one.impact().name(),
            "grade": one.grade.name(),
            "bus": setting.buses.name(one.bus),
            "node": one.subject.node,
            "nodes": array(members(one.subject.nodes)),
            "frame": one.begin.no, "t_ns": one.begin.t_ns, "noticed": one.noticed.no,
            "end_frame": one.end.map(|end| end.no),
            "end_ns": one.end.and_then(|end| end.t_ns),
            /// One more than that of its cause.
            "depth": depth,
            "cause": link.and_then(|link| Some(self.now?.ledger().number(link.cause))),
            "cause_grade": link.map(|link| link.grade.name()),
            "delay_ns": link.and_then(|link| link.delay_ns),
            "text": text(move |out| words::title(out, setting.lang, one, self.clock.start_ns)),
            "checks": array(advice::of(one, shown).into_iter().map(move |check| setting.lang.of(check.words))),
            "count": one.repeats.count,
        }
    }
}

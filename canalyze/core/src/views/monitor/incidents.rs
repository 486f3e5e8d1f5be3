//! The problems so far, in reading order.
//!
//! While the capture continues, they are shown as if it had ended now; those that may still change are marked. Problems
//! are not judged here, and nothing is kept between snapshots.

use super::clock::Clock;
use super::{Known, Monitor};
use crate::bytes::frame::BusId;
use crate::stories::incident::{Incident, IncidentId, Status, members};
use crate::stories::rank::{is_root, stories};
use crate::stories::{Diagnosis, advice};
use crate::tables::jsonl::{self, Setting};
use crate::words::digits::put;
use crate::words::{Lang, incidents as words};

/// Maximum number of rows.
const ROWS: usize = 256;

/// The present incidents.
pub(super) struct Incidents<'a> {
    clock: Clock,
    /// The diagnosis while the capture continues; `None` without problems.
    told: Option<&'a Diagnosis>,
    /// The diagnosis as if the capture had ended now.
    now: Option<&'a Diagnosis>,
    /// In reading order, with the number of causes above each.
    order: Vec<(IncidentId, u64)>,
}

impl<'a> Incidents<'a> {
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

    /// Appends the rows as a JSON list.
    pub(super) fn list(&self, out: &mut Vec<u8>, setting: Setting<'_>) {
        put!(out; "[");
        for (place, (one, depth)) in self.rows().take(ROWS).enumerate() {
            put!(out; if place > 0 { "," } else { "" });
            self.row(out, setting, one, depth);
        }
        put!(out; "]");
    }

    /// Appends the first incident of a node that is not over, or null.
    pub(super) fn of_node(&self, out: &mut Vec<u8>, lang: Lang, bus: BusId, node: u8) {
        let mine = |one: &&Incident| {
            one.bus == bus && one.subject.concerns(node) && matches!(one.status, Status::Stands | Status::Unknown)
        };
        let Some(one) = self.rows().map(|(one, _)| one).find(mine) else { return put!(out; "null") };
        put!(out; "{\"id\":", u64::from(one.number), ",\"word\":");
        jsonl::quoted(out, |text| put!(text; lang.of(one.kind.row().words)));
        put!(out; ",\"provisional\":", jsonl::truth(self.is_provisional(one)), "}");
    }

    fn rows(&self) -> impl Iterator<Item = (&Incident, u64)> {
        self.order.iter().filter_map(|(id, depth)| Some((self.now?.ledger().by_id(*id)?, *depth)))
    }

    /// Returns true if the rest of the capture may change it.
    fn is_provisional(&self, one: &Incident) -> bool {
        let settled = self.told.is_none_or(|told| told.is_settled(one, self.clock.now_ns));
        self.told.is_some_and(|told| !told.is_over()) && (one.status == Status::Unknown || !settled)
    }

    fn row(&self, out: &mut Vec<u8>, setting: Setting<'_>, one: &Incident, depth: u64) {
        let row = one.kind.row();
        put!(out; "{\"id\":", u64::from(one.number), ",\"kind\":\"", row.name, "\",\"word\":");
        jsonl::quoted(out, |text| put!(text; setting.lang.of(row.words)));
        put!(out; ",\"status\":\"", one.status.name(), "\",\"provisional\":", jsonl::truth(self.is_provisional(one)));
        put!(out; ",\"impact\":\"", one.impact().name(), "\",\"grade\":\"", one.grade.name(), "\",\"bus\":");
        jsonl::name(out, setting.buses.name(one.bus));
        put!(out; ",\"node\":");
        jsonl::number_or_null(out, one.subject.node.map(u64::from));
        put!(out; ",\"nodes\":[");
        for (place, node) in members(one.subject.nodes).enumerate() {
            put!(out; if place > 0 { "," } else { "" }, node);
        }
        put!(out; "],\"frame\":", one.begin.no, ",\"t_ns\":");
        jsonl::signed_or_null(out, one.begin.t_ns);
        put!(out; ",\"noticed\":", one.noticed.no, ",\"end_frame\":");
        jsonl::number_or_null(out, one.end.map(|end| end.no));
        put!(out; ",\"end_ns\":");
        jsonl::signed_or_null(out, one.end.and_then(|end| end.t_ns));
        let link = one.cause.filter(|_| !is_root(one));
        put!(out; ",\"depth\":", depth, ",\"cause\":");
        let number = |cause| self.now.map(|now| u64::from(now.ledger().number(cause)));
        jsonl::number_or_null(out, link.and_then(|link| number(link.cause)));
        put!(out; ",\"cause_grade\":");
        jsonl::name_or_null(out, link.map_or("", |link| link.grade.name()).as_bytes());
        put!(out; ",\"delay_ns\":");
        jsonl::signed_or_null(out, link.and_then(|link| link.delay_ns));
        put!(out; ",\"text\":");
        jsonl::quoted(out, |text| words::title(text, setting.lang, one, self.clock.start_ns));
        put!(out; ",\"checks\":[");
        let shown = self.now.map(|now| now.shown()).unwrap_or_default();
        for (place, check) in advice::of(one, shown).iter().enumerate() {
            put!(out; if place > 0 { "," } else { "" });
            jsonl::quoted(out, |text| put!(text; setting.lang.of(check.words)));
        }
        put!(out; "],\"count\":", one.repeats.count, "}");
    }
}

//! The last findings.
//!
//! The first few of one kind on one object have rows of their own; the others are counted in the last of these, so that
//! a fault in every cycle does not hide others. Findings are not judged here, and each is counted.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use crate::bytes::frame::BusId;
use crate::rules::finding::{Code, Facts, Finding};
use crate::sdo::wire::Mux;
use crate::tables::jsonl::{self, Setting};
use crate::words::digits::put;
use crate::words::findings;

/// Maximum number of rows.
const ROWS: usize = 500;
/// Number of findings of one kind that have rows of their own.
const SHOWN: u64 = 10;
/// Maximum number of kinds that are counted; findings of further kinds all have rows.
const KINDS: usize = 4096;

type Kind = (Code, BusId, Option<u8>, Option<Mux>, Option<Arc<str>>, bool);

/// A row: the object in JSON without its count.
#[derive(Debug)]
struct Row {
    json: Vec<u8>,
    count: u64,
}

/// The findings of a capture.
#[derive(Debug, Default)]
pub(super) struct Findings {
    /// The number of findings of each kind, and the number of its last row.
    kinds: BTreeMap<Kind, (u64, u64)>,
    rows: VecDeque<Row>,
    /// The number of rows that are no longer kept.
    gone: u64,
}

impl Findings {
    /// Takes a finding. Returns true if it has a row of its own.
    pub(super) fn take(&mut self, setting: Setting<'_>, finding: &Finding) -> bool {
        let expectation = finding.expectation().map(Arc::clone);
        let kind = (finding.code, finding.bus, finding.node, finding.object, expectation, finding.because_of.is_some());
        let row = self.gone + self.rows.len() as u64;
        let known = self.kinds.len();
        let (count, last) = match self.kinds.get_mut(&kind) {
            Some(known) => known,
            None if known < KINDS => self.kinds.entry(kind).or_default(),
            None => &mut (0, 0),
        };
        *count += 1;
        if *count > SHOWN
            && let Some(place) = last.checked_sub(self.gone)
            && let Some(row) = self.rows.get_mut(place as usize)
        {
            row.count += 1;
            return false;
        }
        *last = row;
        if self.rows.len() >= ROWS {
            self.rows.pop_front();
            self.gone += 1;
        }
        let count = if let Facts::Unmet(unmet) = &finding.facts { unmet.repeated.max(1) } else { 1 };
        self.rows.push_back(Row { json: json(setting, finding), count });
        true
    }

    /// Appends the rows, oldest first, as a JSON list.
    pub(super) fn list(&self, out: &mut Vec<u8>) {
        for (place, row) in self.rows.iter().enumerate() {
            put!(out; if place > 0 { "," } else { "[" });
            out.extend_from_slice(&row.json);
            put!(out; row.count, "}");
        }
        put!(out; if self.rows.is_empty() { "[]" } else { "]" });
    }
}

fn json(setting: Setting<'_>, finding: &Finding) -> Vec<u8> {
    let mut out = Vec::with_capacity(256);
    let rule = finding.code.rule();
    put!(&mut out; "{\"code\":\"", rule.id, "\",\"severity\":\"", finding.severity().name(), "\",\"frame\":");
    jsonl::number_or_null(&mut out, (finding.at.no > 0).then_some(finding.at.no));
    put!(&mut out; ",\"t_ns\":");
    jsonl::signed_or_null(&mut out, finding.at.t_ns);
    put!(&mut out; ",\"bus\":");
    jsonl::name(&mut out, setting.buses.name(finding.bus));
    put!(&mut out; ",\"node\":");
    jsonl::number_or_null(&mut out, finding.node.map(u64::from));
    put!(&mut out; ",\"text\":");
    jsonl::quoted(&mut out, |text| findings::placed(text, setting.lang, finding, finding.at.no));
    put!(&mut out; ",\"count\":");
    out
}

//! The last findings.
//!
//! The first few of one kind on one object have rows of their own; the others are counted in the last of these, so that
//! a fault in every cycle does not hide others. Findings are not judged here, and each is counted.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use crate::bytes::frame::BusId;
use crate::rules::finding::{Code, Facts, Finding};
use crate::sdo::wire::Mux;
use crate::tables::jsonl::Setting;
use crate::tables::jsonl::obj::{WriteJson, array, obj, text, written};
use crate::words::findings;

/// Maximum number of rows.
const ROWS: usize = 500;
/// Number of findings of one kind that have rows of their own.
const SHOWN: u64 = 10;
/// Maximum number of kinds that are counted; findings of further kinds all have rows.
const KINDS: usize = 4096;

type FindingKey = (Code, BusId, Option<u8>, Option<Mux>, Option<Arc<str>>, bool);

/// A row: its keys in JSON but for its count.
#[derive(Debug)]
struct FindingRow {
    json: Vec<u8>,
    count: u64,
}

/// The findings of a capture.
#[derive(Debug, Default)]
pub(super) struct Findings {
    /// The number of findings of each kind, and the number of its last row.
    kinds: BTreeMap<FindingKey, (u64, u64)>,
    rows: VecDeque<FindingRow>,
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
        self.rows.push_back(FindingRow { json: json(setting, finding), count });
        true
    }

    /// Returns the rows, oldest first.
    pub(super) fn list(&self) -> impl WriteJson {
        array(self.rows.iter().map(|row| obj! { _: written(&row.json), "count": row.count }))
    }
}

fn json(setting: Setting<'_>, finding: &Finding) -> Vec<u8> {
    let mut out = Vec::with_capacity(256);
    obj! {
        "code": finding.code.rule().id,
        "severity": finding.severity().name(),
        "frame": finding.at.number(), "t_ns": finding.at.t_ns,
        "bus": setting.buses.name(finding.bus),
        "node": finding.node,
        "text": text(|out| findings::placed(out, setting.lang, finding, finding.at.no)),
    }
    .inline()
    .write_json(&mut out);
    out
}

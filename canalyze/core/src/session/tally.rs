//! What a live capture has shown so far, in a few numbers that can be asked for at any time.
//!
//! It counts what it is given, and nothing twice. Must not: judge, or keep a frame.

use crate::bytes::frame::{BusId, Buses, Frame, Kind, MAX_BUSES};
use crate::rules::finding::{Finding, Severity};
use crate::sdo::transfer::Status;
use crate::wire::error_control;
use crate::words::digits::put;
use crate::words::{Lang, escape};
use crate::world::bus::Bus;
use crate::world::event::{Event, What};
use crate::world::node::PerNode;

/// The numbers.
#[derive(Debug, Default)]
pub(super) struct Tally {
    errors: u64,
    warnings: u64,
    infos: u64,
    ok: u64,
    aborted: u64,
    incomplete: u64,
    failed: u64,
    /// Findings of expectations that do not hold.
    missed: u64,
    /// By number of the bus.
    buses: Vec<OnBus>,
}

/// Those of one bus.
#[derive(Debug, Default)]
struct OnBus {
    frames: u64,
    error_frames: u64,
    dropped: u64,
    nodes: PerNode<OnNode>,
}

/// Those of one node.
#[derive(Clone, Copy, Debug, Default)]
struct OnNode {
    frames: u64,
    errors: u64,
    warnings: u64,
}

impl Tally {
    /// Takes a frame and what follows from it.
    #[inline]
    pub(super) fn frame(&mut self, frame: &Frame, events: &[Event]) {
        if let Some(bus) = self.bus(frame.bus) {
            bus.frames += 1;
            bus.error_frames += u64::from(frame.kind == Kind::Error);
            if let Some(node) = events.first().and_then(|event| event.node) {
                bus.nodes.entry(node).frames += 1;
            }
        }
        // Its own event comes first, and is neither.
        self.events(events.get(1..).unwrap_or_default());
    }

    /// Takes what belongs to no frame at hand.
    pub(super) fn events(&mut self, events: &[Event]) {
        for event in events {
            match &event.what {
                What::Finding(finding) => self.finding(finding),
                What::Transfer(transfer) => match transfer.outcome.status {
                    Status::Ok => self.ok += 1,
                    Status::Aborted => self.aborted += 1,
                    Status::Incomplete => self.incomplete += 1,
                    Status::Failed => self.failed += 1,
                    Status::Open => {}
                },
                _ => {}
            }
        }
    }

    /// Takes a finding. One that stands for others that were not reported counts for all of them.
    pub(super) fn finding(&mut self, finding: &Finding) {
        let count = finding.facts.count();
        let severity = finding.severity();
        if finding.expectation().is_some() && severity == Severity::Error {
            self.missed += count;
        }
        *match severity {
            Severity::Error => &mut self.errors,
            Severity::Warning => &mut self.warnings,
            Severity::Info => &mut self.infos,
        } += count;
        if let Some((bus, node)) = self.bus(finding.bus).zip(finding.node) {
            let node = bus.nodes.entry(node);
            match severity {
                Severity::Error => node.errors += count,
                Severity::Warning => node.warnings += count,
                Severity::Info => {}
            }
        }
    }

    /// Frames of a bus are missing.
    pub(super) fn dropped(&mut self, bus: BusId, count: u64) {
        if let Some(bus) = self.bus(bus) {
            bus.dropped = bus.dropped.saturating_add(count);
        }
    }

    fn bus(&mut self, bus: BusId) -> Option<&mut OnBus> {
        let index = usize::from(bus.0).min(MAX_BUSES);
        if self.buses.len() <= index {
            self.buses.resize_with(index + 1, OnBus::default);
        }
        self.buses.get_mut(index)
    }

    /// A JSON object. `shown`: the frames that passed the filters, of `frames` in all. `expects`: expectations are held
    /// against the capture.
    pub(super) fn write(&self, out: &mut Vec<u8>, (frames, shown): (u64, u64), expects: bool, buses: &Buses) {
        put!(out; "{\"frames\":", frames, ",\"shown\":", shown);
        put!(out; ",\"findings\":{\"error\":", self.errors, ",\"warning\":", self.warnings, ",\"info\":", self.infos);
        put!(out; "},\"transfers\":{\"ok\":", self.ok, ",\"aborted\":", self.aborted);
        put!(out; ",\"incomplete\":", self.incomplete, ",\"failed\":", self.failed, "},\"expectations\":");
        if expects {
            put!(out; "{\"missed\":", self.missed, "}");
        } else {
            put!(out; "null");
        }
        put!(out; ",\"buses\":[");
        for (index, name) in buses.names().enumerate() {
            let none = OnBus::default();
            let OnBus { frames, error_frames, dropped, .. } = self.buses.get(index).unwrap_or(&none);
            put!(out; if index > 0 { "," } else { "" }, "{\"name\":");
            escape::json(out, name);
            put!(out; ",\"frames\":", *frames, ",\"error_frames\":", *error_frames, ",\"dropped\":", *dropped, "}");
        }
        put!(out; "]}");
    }

    /// A JSON list of nodes that were heard or of which something was found, each with `bus`, `node`, `state_text` of what
    /// it said last, `silent` as in `monitor/snapshot.rs` at `now_ns`, `frames`, `errors` and `warnings`.
    pub(super) fn nodes(&self, out: &mut Vec<u8>, lang: Lang, known: &[Bus], (buses, now_ns): (&Buses, Option<i64>)) {
        put!(out; "[");
        let mut first = true;
        for ((index, name), counted) in buses.names().enumerate().zip(&self.buses) {
            for (id, node) in counted.nodes.iter() {
                let bus = known.get(index);
                put!(out; if std::mem::take(&mut first) { "{\"bus\":" } else { ",{\"bus\":" });
                escape::json(out, name);
                let state = bus.and_then(|bus| bus.state(id)).and_then(|state| error_control::state(lang, state));
                put!(out; ",\"node\":", id, ",\"state_text\":");
                escape::json(out, state.unwrap_or("").as_bytes());
                let silent = bus.and_then(|bus| bus.silent(id, now_ns)).map_or("", |control| control.name());
                put!(out; ",\"silent\":");
                escape::json(out, silent.as_bytes());
                put!(out; ",\"frames\":", node.frames, ",\"errors\":", node.errors);
                put!(out; ",\"warnings\":", node.warnings, "}");
            }
        }
        put!(out; "]");
    }
}

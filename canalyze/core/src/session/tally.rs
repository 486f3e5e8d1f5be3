//! Counts of a live capture so far, available at any time.
//!
//! It counts what it is given, and nothing twice. Must not: judge, or keep a frame.

use std::iter;

use crate::bytes::frame::{BusId, Buses, Frame, Kind, MAX_BUSES};
use crate::bytes::ns::Ns;
use crate::rules::finding::{Finding, Severity};
use crate::sdo::transfer::Status;
use crate::tables::jsonl::obj::{WriteJson, array, obj};
use crate::wire::error_control;
use crate::words::Lang;
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

    /// Appends a JSON object. `shown`: the frames that passed the filters, of `frames` in all. `expects`: expectations are
    /// held against the capture.
    pub(super) fn write(&self, out: &mut Vec<u8>, (frames, shown): (u64, u64), expects: bool, buses: &Buses) {
        let none = OnBus::default();
        let all = buses.names().zip(self.buses.iter().chain(iter::repeat(&none)));
        obj! {
            "frames": frames, "shown": shown,
            "findings": obj! { "error": self.errors, "warning": self.warnings, "info": self.infos },
            "transfers": obj! {
                "ok": self.ok, "aborted": self.aborted, "incomplete": self.incomplete, "failed": self.failed,
            },
            "expectations": expects.then_some(obj! { "missed": self.missed }),
            "buses": array(all.map(|(name, bus)| obj! {
                "name": name, "frames": bus.frames, "error_frames": bus.error_frames, "dropped": bus.dropped,
            })),
        }
        .write_json(out);
    }

    /// Appends a JSON list of nodes that were heard or that have findings.
    pub(super) fn nodes(&self, out: &mut Vec<u8>, lang: Lang, known: &[Bus], (buses, now_ns): (&Buses, Option<Ns>)) {
        let all = buses.names().enumerate().zip(&self.buses);
        array(all.flat_map(|((index, name), counted)| {
            let bus = known.get(index);
            counted.nodes.iter().map(move |(id, node)| {
                obj! {
                    "bus": name, "node": id,
                    /// The last one that it sent.
                    "state_text": bus.and_then(|bus| error_control::state(lang, bus.state(id)?)).unwrap_or(""),
                    /// As in `views/monitor/snapshot.rs`.
                    "silent": bus.and_then(|bus| bus.silent(id, now_ns)).map_or("", |control| control.name()),
                    "frames": node.frames, "errors": node.errors, "warnings": node.warnings,
                }
            })
        }))
        .write_json(out);
    }
}

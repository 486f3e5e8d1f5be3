//! The content of a view at a moment, without the lines of the trace, as one JSON object.
//!
//! Times are integers of ns, null for never and without timestamps; rates have one decimal. Keys are only ever added,
//! never renamed. Nothing is changed here.

use super::objects::{Label, LineForm, LineKey, ObjectLine};
use super::problems::Problems;
use super::trace::identifier;
use super::transfers;
use super::wire::{ErrorState, LastEmergency, Live, Wire};
use super::{Known, Monitor};
use crate::bytes::frame::{BusId, FrameRef};
use crate::rules::finding::Severity;
use crate::sdo::wire::Side;
use crate::tables::jsonl::Setting;
use crate::tables::jsonl::obj::{WriteJson, array, hex2, hex4, obj, raw, text, written};
use crate::views::summary;
use crate::wire::emcy;
use crate::wire::error_control;
use crate::words::digits::{Joined, put};
use crate::words::{Lang, terms};
use crate::world::bus::Bus;

/// Maximum number of running transfers that are listed.
const RUNNING: usize = 256;

/// Returns the object.
pub(super) fn snapshot(monitor: &Monitor, setting: Setting<'_>, known: Known<'_>) -> Vec<u8> {
    let mut out = Vec::with_capacity(64 << 10);
    let problems = Problems::new(monitor, known);
    let view = View { monitor, setting, known: known.buses, problems: &problems };
    obj! {
        "now_ns": monitor.clock.now_ns, "start_ns": monitor.clock.start_ns,
        /// See `Session::tally`.
        "tally": written(known.tally),
        "buses": array(setting.buses.names().enumerate().map(|(place, name)| view.bus(BusId(place as u8), name))),
        "nodes": view.nodes(),
        "objects": array(monitor.objects.iter().map(|(key, object)| view.object(key, object))),
        "objects_more": monitor.objects.more(),
        "transfers": obj! { "running": view.running(), "done": monitor.transfers.list() },
        "findings": monitor.findings.list(),
        /// In the order of reading, each cause before its effects; while the capture goes on, as if it were over now.
        "problems": problems.list(setting),
        "problems_more": problems.more(),
    }
    .write_json(&mut out);
    out
}

/// The context of all records.
struct View<'a> {
    monitor: &'a Monitor,
    setting: Setting<'a>,
    known: &'a [Bus],
    problems: &'a Problems<'a>,
}

impl<'a> View<'a> {
    fn bus(&self, id: BusId, name: &'a [u8]) -> impl WriteJson + use<'a> {
        let bit_rate = self.monitor.summary.network.bit_rate;
        let counted = self.monitor.summary.buses.get(&id);
        let wire = self.monitor.wires.get(usize::from(id.0));
        let bits = wire.and_then(|wire| self.lately(&wire.load));
        // Tenths of bits a second over bits a second are tenths, too.
        let percent = bits.zip(bit_rate).map(|(bits, rate)| bits.saturating_mul(100) / u64::from(rate.max(1)));
        obj! {
            "name": name,
            "frames": counted.map_or(0, |bus| bus.frames),
            "frames_per_s": wire.and_then(|wire| self.lately(&wire.rate)).map(tenths),
            "bits_per_s": bits.map(|tenths| tenths / 10),
            "bit_rate": bit_rate,
            "load_percent": percent.map(tenths),
            "error_frames": counted.map_or(0, |bus| bus.errors),
            "dropped": counted.map_or(0, |bus| bus.dropped),
            /// `error-warning`, `error-passive` or `bus-off`.
            "state": wire.and_then(|wire| wire.state).map(ErrorState::name),
        }
    }

    fn nodes(&self) -> impl WriteJson {
        array(self.monitor.summary.buses.iter().flat_map(move |(bus, counted)| {
            let wire: Option<&Wire> = self.monitor.wires.get(usize::from(bus.0));
            counted.nodes().map(move |(id, node)| {
                raw(move |out| {
                    let unknown = Live::default();
                    let live = wire.and_then(|wire| wire.nodes.get(id)).unwrap_or(&unknown);
                    self.node((*bus, id), node, live).write_json(out);
                })
            })
        }))
    }

    fn node<'b>(
        &'b self,
        (bus, id): (BusId, u8),
        node: &'b summary::node::NodeSummary,
        live: &'b Live,
    ) -> impl WriteJson {
        let Setting { lang, buses, .. } = self.setting;
        let known = self.known.get(usize::from(bus.0));
        let state = node.states().state;
        let silent = known.and_then(|bus| bus.silent(id, self.monitor.clock.now_ns)).map(|control| control.name());
        let [_, warning, error] = live.findings;
        let name = self.monitor.summary.described(buses.name(bus), id);
        obj! {
            "bus": buses.name(bus),
            "node": id,
            "name": name.or(node.device_name.as_deref()).unwrap_or(""),
            /// The last one that it sent, as in `summary`.
            "state": state.map(hex2),
            "state_text": state.and_then(|state| error_control::state(lang, state)).unwrap_or(""),
            "frames": node.frames, "sent": node.sent,
            "frames_per_s": self.lately(&live.rate).map(tenths),
            /// The bus was away since: the node may be in any state.
            "unknown": live.unknown,
            "heartbeat_age_ns": self.monitor.clock.since(live.beat_ns),
            "heartbeat_period_ns": known.and_then(|bus| bus.heartbeat_period(id)),
            /// `heartbeat` or `guarding` where it should have been heard since and was not.
            "silent": silent,
            "guarded": node.guarded,
            "emcy": live.emergency.map(|one| emergency(lang, one)),
            "boot_ups": node.boot_ups,
            "drive": self.drive(known, id, live, silent.is_some()),
            "findings": obj! { "error": error, "warning": warning },
            /// The first that concerns it and is not over.
            "problem": self.problems.of_node(lang, bus, id),
        }
    }

    /// The state of a drive; of several axes with their numbers. What it reported last holds no more once its node is lost,
    /// unless it was reported when the next heartbeat was overdue already: the node goes on without them.
    fn drive<'b>(&'b self, known: Option<&'b Bus>, node: u8, live: &Live, silent: bool) -> Option<impl WriteJson> {
        let period = known.and_then(|bus| bus.heartbeat_period(node));
        let holds = |at: FrameRef| {
            let since = live.beat_ns.and_then(|beat| Some(at.t_ns? - beat));
            !silent || since.zip(period).is_some_and(|(since, period)| since > period)
        };
        let reports = known.into_iter().flat_map(|bus| bus.drive_reports(node)).filter(|(_, _, at)| holds(*at));
        let states: Vec<_> = reports.map(|(axis, state, _)| (axis, state)).collect();
        let lang = self.setting.lang;
        let several = states.len() > 1;
        let is_there = !states.is_empty();
        let words = move |out: &mut Vec<u8>| {
            for (place, (axis, state)) in states.iter().enumerate() {
                put!(out; if place > 0 { ", " } else { "" });
                if several || *axis > 0 {
                    put!(out; axis + 1, ": ");
                }
                put!(out; terms::drive::state(lang, *state));
            }
        };
        is_there.then(|| text(words))
    }

    fn object<'b>(&'b self, key: &'b LineKey, object: &'b ObjectLine) -> impl WriteJson {
        let Setting { lang, buses, .. } = self.setting;
        let now_ns = self.monitor.clock.now_ns;
        let error = key.form == LineForm::Error;
        let (period, jitter) = object.period().unzip();
        obj! {
            "bus": buses.name(key.bus),
            "id": text(move |out| identifier(out, object.id, error)),
            "ext": object.id.is_extended() && !error,
            "rtr": key.form == LineForm::Remote,
            "service": object.service, "node": object.node,
            "name": text(move |out| label(out, lang, object.label)),
            "count": object.count, "last_ns": object.last.t_ns, "period_ns": period,
            /// The largest difference of one of the last 16 periods from their mean; one period alone has none.
            "jitter_ns": jitter.flatten(),
            "rate": self.lately(&object.rate).map(tenths),
            "len": object.len,
            "data": Joined(object.data()),
            /// FF for a byte that changed in the last second, else 00.
            "changed": text(move |out| {
                object.changed(now_ns).for_each(|changed| put!(out; if changed { "FF" } else { "00" }));
            }),
            "text": &*object.text,
            /// That of the worst finding about frames of the object in the last 10 s.
            "severity": object.severity(now_ns).map(Severity::name),
        }
    }

    fn running(&self) -> impl WriteJson {
        let running = self.known.iter().flat_map(Bus::running).take(RUNNING);
        array(running.map(|(transfer, described)| {
            obj! {
                _: transfers::head(self.setting, transfer, described).inline(),
                "size": transfer.data.size_indicated, "bytes": transfer.data.size, "since_ns": transfer.first.t_ns,
            }
        }))
    }

    /// Returns the recent amount a second in tenths; `None` without timestamps.
    fn lately(&self, recent: &super::recent::Recent) -> Option<u64> {
        let clock = &self.monitor.clock;
        Some(recent.tenths_per_s(clock.now_ns?, clock.start_ns?))
    }
}

fn emergency(lang: Lang, LastEmergency { code, profile, t_ns, active }: LastEmergency) -> impl WriteJson {
    obj! {
        "code": hex4(code),
        "text": emcy::code(lang, profile, code).unwrap_or(""),
        "t_ns": t_ns,
        /// Errors that are present: 0 once all are taken back.
        "active": active,
    }
}

fn label(out: &mut Vec<u8>, lang: Lang, label: Label) {
    match label {
        Label::Pdo(transmit, number) => put!(out; if transmit { "TPDO" } else { "RPDO" }, number),
        Label::Srdo(number, inverted) => {
            put!(out; "SRDO", number);
            if inverted {
                put!(out; " ", terms::service::inverted(lang));
            }
        }
        Label::Sdo(side) => put!(out; terms::service::sdo(lang, side == Side::Server)),
        Label::Service(service) => put!(out; terms::service::name(lang, service).unwrap_or("")),
    }
}

/// Returns a number in tenths with its decimal.
fn tenths(tenths: u64) -> impl WriteJson {
    raw(move |out| put!(out; tenths / 10, ".", tenths % 10))
}

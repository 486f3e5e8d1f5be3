//! The content of a view at a moment, without the lines of the trace, as one JSON object.
//!
//! Times are integers of ns, null for never and without timestamps; rates have one decimal. Keys are only ever added,
//! never renamed. Nothing is changed here.
//!
//! | of | keys |
//! |---|---|
//! | the object | `now_ns start_ns tally buses nodes objects objects_more transfers findings incidents incidents_more` |
//! | `tally` | see `Session::tally` |
//! | `buses` | `name frames frames_per_s bits_per_s bit_rate load_percent error_frames dropped state` |
//! | `nodes` | `bus node name state state_text frames sent frames_per_s unknown heartbeat_age_ns heartbeat_period_ns silent guarded emcy boot_ups drive findings incident` |
//! | `objects` | `bus id ext rtr service node name count last_ns period_ns jitter_ns rate len data changed text severity` |
//! | `transfers` | `running`: `transfer bus node direction mode index sub name size bytes since_ns`; `done`: `transfer bus node direction mode index sub name size value text status abort first_frame last_frame t_ns duration_ns` |
//! | `findings` | `code severity frame t_ns bus node text count` |
//! | `incidents` | `id kind word status provisional impact grade bus node nodes frame t_ns noticed end_frame end_ns depth cause cause_grade delay_ns text checks count` |
//!
//! `state` of a bus is null, `error-warning`, `error-passive` or `bus-off`; of a node as in `summary`, the last one that it
//! reported: `unknown` is true if the bus was away since, so that it may have changed;
//! `silent` is `heartbeat` or `guarding` if the node should have been heard since and was not, else null. `emcy` is null or
//! the last emergency `{"code","text","t_ns","active"}`, where `active` counts the active errors: 0 once all are
//! cleared. `changed` has FF for a byte that changed in the last second, else 00.
//! `jitter_ns` is the greatest deviation of the last 16 intervals from their mean; a single interval has none. `severity`
//! is that of the worst finding about frames of the object in the last 10 s. `count` of a finding is above 1 if it
//! represents more of its kind that have no rows of their own. `incidents` are in reading order, each cause before its
//! consequences, which have one more `depth`; while the capture continues they are as if it had ended now, and those
//! that may still change are `provisional`. `incident` of a node is null or the first one about it that is not over:
//! `{"id","word","provisional"}`, where `word` is its kind.

use super::incidents::Incidents;
use super::objects::{Form, Key, Label, Object};
use super::trace::identifier;
use super::wire::{Emergency, ErrorState, Live, Wire};
use super::{Known, Monitor};
use crate::bytes::frame::{BusId, FrameRef};
use crate::rules::finding::Severity;
use crate::sdo::wire::Side;
use crate::tables::jsonl::{self, Setting};
use crate::views::summary;
use crate::wire::emcy;
use crate::wire::error_control;
use crate::words::digits::{Hex, Joined, put};
use crate::words::{Lang, escape, terms};
use crate::world::bus::Bus;

/// Maximum number of running transfers that are listed.
const RUNNING: usize = 256;

/// Writes the object.
pub(super) fn snapshot(monitor: &Monitor, setting: Setting<'_>, known: Known<'_>) -> Vec<u8> {
    let mut out = Vec::with_capacity(64 << 10);
    put!(&mut out; "{\"now_ns\":");
    jsonl::signed_or_null(&mut out, monitor.clock.now_ns);
    put!(&mut out; ",\"start_ns\":");
    jsonl::signed_or_null(&mut out, monitor.clock.start_ns);
    put!(&mut out; ",\"tally\":");
    out.extend_from_slice(known.tally);
    put!(&mut out; ",\"buses\":[");
    let incidents = Incidents::new(monitor, known);
    let view = View { monitor, setting, known: known.buses, incidents: &incidents };
    view.buses(&mut out);
    put!(&mut out; "],\"nodes\":[");
    view.nodes(&mut out);
    put!(&mut out; "],\"objects\":[");
    for (place, (key, object)) in monitor.objects.iter().enumerate() {
        put!(&mut out; if place > 0 { "," } else { "" });
        view.object(&mut out, key, object);
    }
    put!(&mut out; "],\"objects_more\":", monitor.objects.more(), ",\"transfers\":{\"running\":[");
    view.running(&mut out);
    put!(&mut out; "],\"done\":");
    monitor.transfers.list(&mut out);
    put!(&mut out; "},\"findings\":");
    monitor.findings.list(&mut out);
    put!(&mut out; ",\"incidents\":");
    incidents.list(&mut out, setting);
    put!(&mut out; ",\"incidents_more\":", incidents.more(), "}");
    out
}

/// The sources of a snapshot.
struct View<'a> {
    monitor: &'a Monitor,
    setting: Setting<'a>,
    known: &'a [Bus],
    incidents: &'a Incidents<'a>,
}

impl View<'_> {
    fn buses(&self, out: &mut Vec<u8>) {
        let bit_rate = self.monitor.summary.network.bit_rate;
        for (place, name) in self.setting.buses.names().enumerate() {
            let id = BusId(place as u8);
            let counted = self.monitor.summary.buses.get(&id);
            let wire = self.monitor.wires.get(place);
            put!(out; if place > 0 { "," } else { "" }, "{\"name\":");
            jsonl::name(out, name);
            put!(out; ",\"frames\":", counted.map_or(0, |bus| bus.frames), ",\"frames_per_s\":");
            tenths_or_null(out, wire.and_then(|wire| self.lately(&wire.rate)));
            let bits = wire.and_then(|wire| self.lately(&wire.load));
            put!(out; ",\"bits_per_s\":");
            jsonl::number_or_null(out, bits.map(|tenths| tenths / 10));
            put!(out; ",\"bit_rate\":");
            jsonl::number_or_null(out, bit_rate.map(u64::from));
            put!(out; ",\"load_percent\":");
            // Tenths of bits a second divided by bits a second are tenths, too.
            let percent = bits.zip(bit_rate).map(|(bits, rate)| bits.saturating_mul(100) / u64::from(rate.max(1)));
            tenths_or_null(out, percent);
            put!(out; ",\"error_frames\":", counted.map_or(0, |bus| bus.errors));
            put!(out; ",\"dropped\":", counted.map_or(0, |bus| bus.dropped), ",\"state\":");
            let state = wire.and_then(|wire| wire.state).map_or("", ErrorState::name);
            jsonl::name_or_null(out, state.as_bytes());
            put!(out; "}");
        }
    }

    fn nodes(&self, out: &mut Vec<u8>) {
        let mut first = true;
        let unknown = Live::default();
        for (bus, counted) in &self.monitor.summary.buses {
            let wire: Option<&Wire> = self.monitor.wires.get(usize::from(bus.0));
            for (id, node) in counted.nodes() {
                put!(out; if std::mem::take(&mut first) { "" } else { "," });
                let live = wire.and_then(|wire| wire.nodes.get(id)).unwrap_or(&unknown);
                self.node(out, *bus, id, node, live);
            }
        }
    }

    fn node(&self, out: &mut Vec<u8>, bus: BusId, id: u8, node: &summary::node::Node, live: &Live) {
        let Setting { lang, buses, .. } = self.setting;
        let known = self.known.get(usize::from(bus.0));
        put!(out; "{\"bus\":");
        jsonl::name(out, buses.name(bus));
        let read = node.device_name.as_deref();
        let name = self.monitor.summary.described(buses.name(bus), id).or(read).unwrap_or("");
        put!(out; ",\"node\":", id, ",\"name\":");
        escape::json(out, name.as_bytes());
        put!(out; ",\"state\":");
        let state = node.states().state;
        match state {
            Some(state) => put!(out; "\"", Hex::<2>(u64::from(state)), "\""),
            None => put!(out; "null"),
        }
        let word = state.and_then(|state| error_control::state(lang, state)).unwrap_or("");
        put!(out; ",\"state_text\":\"", word, "\",\"frames\":", node.frames, ",\"sent\":", node.sent);
        put!(out; ",\"frames_per_s\":");
        tenths_or_null(out, self.lately(&live.rate));
        put!(out; ",\"unknown\":", jsonl::truth(live.unknown), ",\"heartbeat_age_ns\":");
        jsonl::signed_or_null(out, self.monitor.clock.since(live.beat_ns));
        put!(out; ",\"heartbeat_period_ns\":");
        jsonl::signed_or_null(out, known.and_then(|bus| bus.heartbeat_period(id)));
        let silent =
            known.and_then(|bus| bus.silent(id, self.monitor.clock.now_ns)).map_or("", |control| control.name());
        put!(out; ",\"silent\":");
        jsonl::name_or_null(out, silent.as_bytes());
        put!(out; ",\"guarded\":", jsonl::truth(node.guarded), ",\"emcy\":");
        emergency(out, lang, live.emergency);
        put!(out; ",\"boot_ups\":", node.boot_ups, ",\"drive\":");
        self.drive(out, known, id, live, !silent.is_empty());
        put!(out; ",\"findings\":");
        let [_, warning, error] = live.findings;
        put!(out; "{\"error\":", error, ",\"warning\":", warning, "},\"incident\":");
        self.incidents.of_node(out, lang, bus, id);
        put!(out; "}");
    }

    /// Writes the state of a drive; of several axes with their numbers. The last reported state is dropped once its
    /// node is lost, unless it was reported when the next heartbeat was already overdue: then the node continues
    /// without heartbeats.
    fn drive(&self, out: &mut Vec<u8>, known: Option<&Bus>, node: u8, live: &Live, silent: bool) {
        let period = known.and_then(|bus| bus.heartbeat_period(node));
        let holds = |at: FrameRef| {
            let since = live.beat_ns.and_then(|beat| Some(at.t_ns?.saturating_sub(beat)));
            !silent || since.zip(period).is_some_and(|(since, period)| since > period)
        };
        let reports = known.into_iter().flat_map(|bus| bus.drive_reports(node)).filter(|(_, _, at)| holds(*at));
        let states: Vec<_> = reports.map(|(axis, state, _)| (axis, state)).collect();
        if states.is_empty() {
            return put!(out; "null");
        }
        put!(out; "\"");
        for (place, (axis, state)) in states.iter().enumerate() {
            put!(out; if place > 0 { ", " } else { "" });
            if states.len() > 1 || *axis > 0 {
                put!(out; axis + 1, ": ");
            }
            put!(out; terms::drive::state(self.setting.lang, *state));
        }
        put!(out; "\"");
    }

    fn object(&self, out: &mut Vec<u8>, key: &Key, object: &Object) {
        let Setting { lang, buses, .. } = self.setting;
        let error = key.form == Form::Error;
        put!(out; "{\"bus\":");
        jsonl::name(out, buses.name(key.bus));
        put!(out; ",\"id\":\"");
        identifier(out, object.id, error);
        put!(out; "\",\"ext\":", jsonl::truth(object.id.is_extended() && !error));
        put!(out; ",\"rtr\":", jsonl::truth(key.form == Form::Remote), ",\"service\":\"", object.service);
        put!(out; "\",\"node\":");
        jsonl::number_or_null(out, object.node.map(u64::from));
        put!(out; ",\"name\":\"");
        label(out, lang, object.label);
        put!(out; "\",\"count\":", object.count, ",\"last_ns\":");
        jsonl::signed_or_null(out, object.last.t_ns);
        let (period, jitter) = object.period().unzip();
        let jitter = jitter.flatten();
        put!(out; ",\"period_ns\":");
        jsonl::signed_or_null(out, period);
        put!(out; ",\"jitter_ns\":");
        jsonl::signed_or_null(out, jitter);
        put!(out; ",\"rate\":");
        tenths_or_null(out, self.lately(&object.rate));
        put!(out; ",\"len\":", object.len, ",\"data\":\"", Joined(object.data()), "\",\"changed\":\"");
        for changed in object.changed(self.monitor.clock.now_ns) {
            put!(out; if changed { "FF" } else { "00" });
        }
        put!(out; "\",\"text\":");
        escape::json(out, &object.text);
        put!(out; ",\"severity\":");
        let severity = object.severity(self.monitor.clock.now_ns).map_or("", Severity::name);
        jsonl::name_or_null(out, severity.as_bytes());
        put!(out; "}");
    }

    fn running(&self, out: &mut Vec<u8>) {
        let running = self.known.iter().flat_map(Bus::running).take(RUNNING);
        for (place, (transfer, described)) in running.enumerate() {
            put!(out; if place > 0 { "," } else { "" }, "{\"transfer\":", transfer.id.0, ",\"bus\":");
            jsonl::name(out, self.setting.buses.name(transfer.bus));
            put!(out; ",\"node\":", transfer.node, ",\"direction\":\"", transfer.direction.name());
            put!(out; "\",\"mode\":\"", transfer.mode.name(), "\"");
            jsonl::sdo::object(out, self.setting.lang, transfer.mux, &described);
            put!(out; ",\"size\":");
            jsonl::number_or_null(out, transfer.data.size_indicated.map(u64::from));
            put!(out; ",\"bytes\":", transfer.data.size, ",\"since_ns\":");
            jsonl::signed_or_null(out, transfer.first.t_ns);
            put!(out; "}");
        }
    }

    /// Returns the recent amount a second in tenths; `None` without timestamps.
    fn lately(&self, recent: &super::recent::Recent) -> Option<u64> {
        let clock = &self.monitor.clock;
        Some(recent.tenths_per_s(clock.now_ns?, clock.start_ns?))
    }
}

fn emergency(out: &mut Vec<u8>, lang: Lang, emergency: Option<Emergency>) {
    let Some(Emergency { code, profile, t_ns, active }) = emergency else { return put!(out; "null") };
    let text = emcy::code(lang, profile, code).unwrap_or("");
    put!(out; "{\"code\":\"", Hex::<4>(u64::from(code)), "\",\"text\":\"", text, "\",\"t_ns\":");
    jsonl::signed_or_null(out, t_ns);
    put!(out; ",\"active\":", active, "}");
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

fn tenths_or_null(out: &mut Vec<u8>, tenths: Option<u64>) {
    match tenths {
        Some(tenths) => put!(out; tenths / 10, ".", tenths % 10),
        None => put!(out; "null"),
    }
}

//! What expectations can be written from, as JSON lines behind those of [`super::summary`].
//!
//! | kind | keys |
//! |---|---|
//! | `observed_signal` | `bus node pdo index sub signal select unit count min max first_frame` |
//! | `observed_pdo` | `bus node pdo count period silence_us` |
//! | `observed_state` | `bus node state count first_frame first_t since_start_ns since_boot_up_ns left` |
//! | `observed_drive` | the same and `axis` |
//! | `observed_emcy` | `bus node code count first_frame` |
//! | `observed_heartbeat` | `bus node count period silence_us` |
//! | `observed_sync` | `bus count period silence_us` |
//!
//! `select` names the signal in every language. `min` and `max` are physical values, null where it is no quantity.
//! `period` is null, or `{"count","min_us","mean_us","max_us"}` of the times that an expectation would judge: `min_us`
//! of those that may be too short (null where there are none), the others of all. `silence_us` is the time from the
//! last frame to the end of the capture, which is judged too; null where something has stopped them. States are named
//! as in expectations.

use super::summary::{us, us_or_null};
use super::{Setting, name_or_null, number_or_null, quoted, seconds, truth};
use crate::expectation::observed::{Kind, Observed, Shown, Train};
use crate::frame::BusId;
use crate::text::digits::{Hex, put};
use crate::text::{escape, signal};

/// Appends all records.
pub fn write(out: &mut Vec<u8>, setting: Setting<'_>, observed: &Observed) {
    for ((bus, pdo, index, sub), one) in &observed.signals {
        let name = if pdo.transmit { "TPDO" } else { "RPDO" };
        begin(out, setting, "signal", *bus, Some(pdo.node));
        put!(out; ",\"pdo\":\"", name, pdo.number);
        put!(out; "\",\"index\":\"", Hex::<4>(u64::from(*index)), "\",\"sub\":", *sub, ",\"signal\":");
        quoted(out, |text| signal::name(text, setting.lang, &one.mapped));
        put!(out; ",\"select\":\"", pdo.node, ".", name, pdo.number, ".");
        put!(out; Hex::<4>(u64::from(*index)), ":", Hex::<2>(u64::from(*sub)), "\",\"unit\":");
        match one.mapped.unit.as_deref() {
            Some(unit) => escape::json(out, unit.as_bytes()),
            None => put!(out; "null"),
        }
        put!(out; ",\"count\":", one.count, ",\"min\":");
        real(out, one.range.map(|(least, _)| least));
        put!(out; ",\"max\":");
        real(out, one.range.map(|(_, greatest)| greatest));
        put!(out; ",\"first_frame\":", one.first.no, "}\n");
    }
    for ((bus, pdo), train) in &observed.pdos {
        begin(out, setting, "pdo", *bus, Some(pdo.node));
        put!(out; ",\"pdo\":\"", if pdo.transmit { "TPDO" } else { "RPDO" }, pdo.number, "\"");
        period(out, train, observed);
    }
    for ((bus, node, kind), shown) in &observed.states {
        state(out, setting, *bus, *node, *kind, shown);
    }
    for ((bus, node, code), reported) in &observed.emergencies {
        begin(out, setting, "emcy", *bus, Some(*node));
        put!(out; ",\"code\":\"", Hex::<4>(u64::from(*code)), "\",\"count\":", reported.count);
        put!(out; ",\"first_frame\":", reported.first.no, "}\n");
    }
    for ((bus, node), train) in &observed.heartbeats {
        begin(out, setting, "heartbeat", *bus, Some(*node));
        period(out, train, observed);
    }
    for (bus, train) in &observed.syncs {
        begin(out, setting, "sync", *bus, None);
        period(out, train, observed);
    }
}

fn begin(out: &mut Vec<u8>, setting: Setting<'_>, kind: &'static str, bus: BusId, node: Option<u8>) {
    put!(out; "{\"kind\":\"observed_", kind, "\",\"bus\":");
    name_or_null(out, setting.buses.name(bus));
    if let Some(node) = node {
        put!(out; ",\"node\":", node);
    }
}

fn state(out: &mut Vec<u8>, setting: Setting<'_>, bus: BusId, node: u8, kind: Kind, shown: &Shown) {
    match kind {
        Kind::Nmt(state) => {
            let Some(name) = crate::expectation::state_name(state) else { return };
            begin(out, setting, "state", bus, Some(node));
            put!(out; ",\"state\":\"", name);
        }
        Kind::Drive(axis, state) => {
            begin(out, setting, "drive", bus, Some(node));
            put!(out; ",\"axis\":", axis, ",\"state\":\"", state.name());
        }
    }
    put!(out; "\",\"count\":", shown.count, ",\"first_frame\":", shown.first.no, ",\"first_t\":");
    seconds(out, shown.first.t_ns, setting.decimals);
    for (key, ns) in [("start", shown.since_start_ns), ("boot_up", shown.since_boot_up_ns)] {
        put!(out; ",\"since_", key, "_ns\":");
        match ns {
            Some(ns) => put!(out; ns),
            None => put!(out; "null"),
        }
    }
    put!(out; ",\"left\":", truth(shown.left), "}\n");
}

fn period(out: &mut Vec<u8>, train: &Train, observed: &Observed) {
    put!(out; ",\"count\":", train.count, ",\"silence_us\":");
    us_or_null(out, train.silence_ns(observed));
    put!(out; ",\"period\":");
    if train.all.count == 0 {
        return put!(out; "null}\n");
    }
    put!(out; "{\"count\":", train.all.count, ",\"min_us\":");
    us_or_null(out, (train.strict.count > 0).then_some(train.strict.min_ns));
    put!(out; ",\"mean_us\":");
    us(out, train.all.mean_ns());
    put!(out; ",\"max_us\":");
    us(out, train.all.max_ns);
    put!(out; "}}\n");
}

fn real(out: &mut Vec<u8>, number: Option<f64>) {
    match number {
        Some(number) => out.extend_from_slice(number.to_string().as_bytes()),
        None => number_or_null(out, None),
    }
}

//! Records from which expectations can be written, as JSON lines behind those of [`super::summary`].
//!
//! States are named as in expectations.

use super::Setting;
use super::obj::{self, Given, Obj, Values, WriteJson, hex2, hex4, named, obj, text, time};
use super::summary::us;
use crate::views::expectation::observed::{Observed, StateKind, Train};
use crate::views::expectation::state_name;
use crate::words::digits::put;
use crate::words::signal;

/// Appends all records.
pub fn write(out: &mut Vec<u8>, setting: Setting<'_>, observed: &Observed) {
    let named = |bus| named(setting.buses.name(bus));
    for ((bus, pdo, index, sub), one) in &observed.signals {
        let name = if pdo.transmit { "TPDO" } else { "RPDO" };
        let (index, sub) = (*index, *sub);
        let mapped = &one.mapped;
        obj! {
            "kind": "observed_signal", "bus": named(*bus), "node": pdo.node,
            "pdo": obj::pdo(pdo.transmit, pdo.number),
            "index": hex4(index), "sub": sub,
            "signal": text(|out| signal::name(out, setting.lang, mapped)),
            /// The name of the signal in every language.
            "select": text(|out| put!(out; pdo.node, ".", name, pdo.number, ".", hex4(index), ":", hex2(sub))),
            "unit": mapped.unit.as_deref(), "count": one.count,
            /// Physical values, null where it is no quantity.
            "min": one.range.map(|(least, _)| least),
            "max": one.range.map(|(_, greatest)| greatest),
            "first_frame": one.first.no,
        }
        .write_line(out);
    }
    for ((bus, pdo), train) in &observed.pdos {
        obj! {
            "kind": "observed_pdo", "bus": named(*bus), "node": pdo.node,
            "pdo": obj::pdo(pdo.transmit, pdo.number),
            _: period(train, observed).inline(),
        }
        .write_line(out);
    }
    for ((bus, node, kind), shown) in &observed.states {
        let (kind, axis, state) = match *kind {
            StateKind::Nmt(state) => ("observed_state", None, state_name(state)),
            StateKind::Drive(axis, state) => ("observed_drive", Some(axis), Some(state.name())),
        };
        let Some(state) = state else { continue };
        obj! {
            "kind": kind, "bus": named(*bus), "node": *node, "axis": Given(axis), "state": state,
            "count": shown.count, "first_frame": shown.first.no, "first_t": time(shown.first.t_ns, setting.decimals),
            "since_start_ns": shown.since_start_ns, "since_boot_up_ns": shown.since_boot_up_ns, "left": shown.left,
        }
        .write_line(out);
    }
    for ((bus, node, code), reported) in &observed.emergencies {
        obj! {
            "kind": "observed_emcy", "bus": named(*bus), "node": *node, "code": hex4(*code), "count": reported.count,
            "first_frame": reported.first.no,
        }
        .write_line(out);
    }
    for ((bus, node), train) in &observed.heartbeats {
        obj! { "kind": "observed_heartbeat", "bus": named(*bus), "node": *node, _: period(train, observed).inline() }
            .write_line(out);
    }
    for (bus, train) in &observed.syncs {
        obj! { "kind": "observed_sync", "bus": named(*bus), _: period(train, observed).inline() }.write_line(out);
    }
}

fn period(train: &Train, observed: &Observed) -> Obj<impl Values> {
    obj! {
        "count": train.count,
        /// The time from the last frame to the end of the capture, which is judged too; null where something has stopped them.
        "silence_us": train.silence_ns(observed).map(us),
        /// The times that an expectation would judge: `min_us` of those that may be too short, the others of all.
        "period": (train.all.count > 0).then(|| obj! {
            "count": train.all.count,
            "min_us": (train.strict.count > 0).then(|| us(train.strict.min_ns)),
            "mean_us": us(train.all.mean_ns()), "max_us": us(train.all.max_ns),
        }),
    }
}

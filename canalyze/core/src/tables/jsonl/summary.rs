//! A capture in figures, as JSON lines: the capture, then each bus followed by its SYNC, its nodes, its PDOs, and those of
//! its identifiers that are not CANopen, then the findings. Where nothing on a bus is CANopen (rule BUS009), it is followed
//! only by its identifiers, and all its frames count as `foreign`.
//!
//! Times that end in `_us` are numbers of microseconds with up to three decimals. Rates are frames a second, loads percent of
//! `bit_rate`; all are null without stamps, loads also without `--bitrate`, and a peak where the capture is shorter than its
//! window. The mean counts what came after the first stamp.

use super::Setting;
use super::info::left_out;
use super::obj::{self, Obj, Values, WriteJson, array, hex2, hex4, map, moment, named, obj, time};
use crate::bytes::frame::CanId;
use crate::bytes::ns::Ns;
use crate::evidence::period::spread::{Ranked, Spread};
use crate::rules::finding::{Code, Severity};
use crate::sdo::wire::Side;
use crate::views::summary::identifiers::Identifier;
use crate::views::summary::load::Peak;
use crate::views::summary::node::{Counted, NodeSummary};
use crate::views::summary::traffic::{PdoTraffic, Sync};
use crate::views::summary::{BusSummary, Capture, Raised, SERVICES, Summary};
use crate::wire::{emcy, error_control};
use crate::words::Lang;
use crate::words::digits::{Padded, put};
use crate::words::terms::abort_code;

const NS: u64 = 1_000_000_000;

/// NMT states (CiA 301 7.2.8.3.2) by the names that programs compare with.
const STATES: [(u8, &str); 4] =
    [(0x00, "boot-up"), (0x04, "stopped"), (0x05, "operational"), (0x7F, "pre-operational")];

/// Appends all records.
pub fn write(out: &mut Vec<u8>, setting: Setting<'_>, summary: &Summary) {
    capture(setting, summary).write_line(out);
    let elapsed_ns = elapsed(&summary.capture);
    for (id, one) in &summary.buses {
        let name = setting.buses.name(*id);
        bus(name, one, elapsed_ns, summary.network.bit_rate).write_line(out);
        if !one.identifiers.are_foreign() {
            if one.sync.frames > 0 {
                sync(name, &one.sync).write_line(out);
            }
            for (id, of_bus) in one.nodes() {
                node(setting, summary, (name, id), of_bus, elapsed_ns).write_line(out);
            }
            for of_bus in one.pdos.iter() {
                pdo(name, of_bus, elapsed_ns).write_line(out);
            }
        }
        for (id, of_bus) in one.identifiers.iter() {
            identifier(name, id, of_bus, elapsed_ns).write_line(out);
        }
    }
    for (of, raised) in &summary.findings {
        finding(setting, *of, raised).write_line(out);
    }
}

/// Time measured in ns, where there is any.
fn elapsed(capture: &Capture) -> Option<u64> {
    capture.span.elapsed_ns.map(|elapsed| elapsed.as_ns().unsigned_abs()).filter(|elapsed| *elapsed > 0)
}

fn capture(setting: Setting<'_>, summary: &Summary) -> impl WriteJson {
    let capture = &summary.capture;
    let span = &capture.span;
    obj! {
        "kind": "summary_capture", "files": capture.files, "frames": capture.frames, "unstamped": capture.unstamped,
        "buses": summary.buses.len(),
        "first_t": moment(setting, capture.first.and_then(|first| first.t_ns)),
        "last_t": moment(setting, capture.last.t_ns),
        /// The time from the first frame to the last one.
        "seconds": time(span.elapsed_ns, setting.decimals),
        "backward": span.backward,
        "backward_most_us": span.elapsed_ns.map(|_| us(span.backward_most_ns)),
        /// The longest time without a frame, and the frame that ended it.
        "pause_us": capture.pause.map(|(ns, _)| us(ns)),
        "pause_frame": capture.pause.map(|(_, frame)| frame.no),
        /// SDO requests captured after their response.
        "reordered": capture.reordered,
        "unreadable": capture.unreadable,
        /// Reports of lost frames by the capturing program, and frames that were lost by them.
        "gaps": summary.buses.values().map(|bus| bus.gaps).sum::<u64>(),
        "dropped": summary.buses.values().map(|bus| bus.dropped).fold(0, u64::saturating_add),
        "left_out": left_out(&capture.left_out),
        "damages": capture.damages, "bit_rate": summary.network.bit_rate,
    }
}

fn bus(name: &[u8], bus: &BusSummary, elapsed_ns: Option<u64>, bit_rate: Option<u32>) -> impl WriteJson {
    let [second, tenth] = bus.load.peaks().map(|(window_ns, bits, frames)| {
        let window_ns = window_ns.as_ns().unsigned_abs();
        (elapsed_ns.filter(|elapsed| *elapsed >= window_ns).map(|_| window_ns), bits, frames)
    });
    let peak_rate = |(window_ns, _, frames): (_, Peak, Peak)| rate(frames.amount, window_ns);
    let peak = |(window_ns, bits, _): (_, Peak, Peak)| percent(bits.amount, window_ns, bit_rate);
    let peak_frame = |(window_ns, bits, _): (Option<u64>, Peak, Peak)| window_ns.and(bit_rate).map(|_| bits.at.no);
    let services = if bus.identifiers.are_foreign() { bus.foreign_only() } else { bus.services };
    obj! {
        "kind": "summary_bus", "bus": named(name), "frames": bus.frames,
        "rate": rate(bus.load.timed_frames, elapsed_ns), "peak_rate_1s": peak_rate(second),
        "peak_rate_100ms": peak_rate(tenth), "sent_by_host": bus.sent_by_host, "remote": bus.remote, "fd": bus.fd,
        "fd_switched": bus.fd_switched, "extended": bus.extended, "errors": bus.errors, "gaps": bus.gaps,
        "dropped": bus.dropped,
        /// A count for each service seen.
        "services": map(SERVICES.iter().copied().zip(services).filter(|(_, count)| *count > 0)),
        /// Bits on the wire with stuff bits (`summary::bits` says which are counted).
        "bits": bus.load.bits,
        "load": percent(bus.load.timed_bits, elapsed_ns, bit_rate), "load_peak_1s": peak(second),
        "load_peak_1s_frame": peak_frame(second), "load_peak_100ms": peak(tenth),
        "load_peak_100ms_frame": peak_frame(tenth),
        "burst": bus.load.longest_burst().map(|burst| obj! {
            "frames": burst.frames, "length_us": us(burst.length_ns), "first_frame": burst.first.no,
        }),
    }
}

fn sync(name: &[u8], sync: &Sync) -> impl WriteJson {
    let counts = (sync.counted > 0).then_some(sync.counters);
    obj! {
        "kind": "summary_sync", "bus": named(name), "frames": sync.frames, "period": ranked(&sync.period),
        "counted": sync.counted,
        "counter_min": counts.map(|(least, _)| least),
        "counter_max": counts.map(|(_, greatest)| greatest),
        "counter_jumps": counts.map(|_| sync.jumps),
    }
}

fn node<'a>(
    setting: Setting<'a>,
    summary: &'a Summary,
    (bus, id): (&'a [u8], u8),
    node: &'a NodeSummary,
    elapsed_ns: Option<u64>,
) -> impl WriteJson {
    let lang = setting.lang;
    let described = summary.described(bus, id);
    let from = described.map(|_| "description").or(node.device_name.as_ref().map(|_| "1008"));
    let states = node.states();
    let (word, name) = state(lang, states.state);
    let [ok, aborted, failed, incomplete] = node.transfers;
    obj! {
        "kind": "summary_node", "bus": named(bus), "node": id,
        "name": described.or(node.device_name.as_deref()),
        "name_from": from, "frames": node.frames, "sent": node.sent, "tpdo": node.tpdos, "rpdo": node.rpdos,
        "tpdo_rate": rate(node.tpdos, elapsed_ns), "rpdo_rate": rate(node.rpdos, elapsed_ns),
        "state": states.state.map(hex2),
        "state_text": word,
        /// Boot-up, stopped, operational or pre-operational in every language.
        "state_name": name,
        "lost": node.lost, "changes": states.changes,
        /// The first 64; `commanded`: a node that sends no state was told to enter it.
        "states": array(states.listed.iter().map(move |change| {
            let (word, name) = state(lang, Some(change.state));
            obj! {
                "state": hex2(change.state), "text": word, "name": name,
                "t": moment(setting, change.at.t_ns), "frame": change.at.no, "commanded": change.commanded,
            }
        })),
        "boot_ups": node.boot_ups,
        "error_control": match (node.guarded, node.heartbeats) {
            (true, _) => Some("guarding"),
            (false, 0) => None,
            (false, _) => Some("heartbeat"),
        },
        "heartbeats": node.heartbeats, "heartbeat": spread(&node.heartbeat),
        "sdo": obj! {
            "transfers": ok + aborted + failed + incomplete, "ok": ok, "aborted": aborted,
            "failed": failed, "incomplete": incomplete,
        },
        "response": ranked(&node.response),
        /// At most 32 different ones, as of `emcy`.
        "aborts": array(node.aborts.iter().map(move |one| {
            let (code, by) = one.code;
            let by = match by {
                Side::Client => "client",
                Side::Server => "server",
            };
            obj! {
                "code": code, "text": abort_code(lang, code), "by": by, _: counted(one).inline(),
            }
        })),
        "emcys": node.emcys,
        "emcy": array(node.emcy_codes.iter().map(move |one| obj! {
            "code": hex4(one.code), "text": emcy::code(lang, node.profile, one.code), _: counted(one).inline(),
        })),
    }
}

fn counted<C>(one: &Counted<C>) -> Obj<impl Values> {
    obj! { "count": one.count, "first_frame": one.first.no, "last_frame": one.last.no }
}

/// Returns the word and the name of a state.
fn state(lang: Lang, state: Option<u8>) -> (Option<&'static str>, Option<&'static str>) {
    let named = STATES.iter().find(|(code, _)| state == Some(*code));
    (state.and_then(|state| error_control::state(lang, state)), named.map(|(_, name)| *name))
}

fn pdo(bus: &[u8], pdo: &PdoTraffic, elapsed_ns: Option<u64>) -> impl WriteJson {
    let (node, transmit, number) = pdo.key;
    obj! {
        "kind": "summary_pdo", "bus": named(bus), "node": node,
        "pdo": obj::pdo(transmit, number),
        "id": pdo.id, "ext": pdo.id.is_extended(), "frames": pdo.frames, "rate": rate(pdo.frames, elapsed_ns),
        "interval": spread(&pdo.interval), "synchronous": pdo.synchronous,
        /// Those captured before their SYNC, which are not in `delay`.
        "before_sync": pdo.before_sync,
        "delay": ranked(&pdo.delay),
    }
}

fn identifier(bus: &[u8], id: CanId, one: &Identifier, elapsed_ns: Option<u64>) -> impl WriteJson {
    let (least, greatest) = one.length;
    obj! {
        "kind": "summary_identifier", "bus": named(bus), "id": id, "ext": id.is_extended(), "frames": one.frames,
        "rate": rate(one.frames, elapsed_ns), "interval": spread(&one.interval), "length_min": least,
        "length_max": greatest,
    }
}

fn finding(setting: Setting<'_>, (code, severity): (Code, Severity), raised: &Raised) -> impl WriteJson {
    let rule = code.rule();
    let names = setting.buses.names().enumerate().filter(|(bus, _)| raised.buses >> bus & 1 == 1);
    obj! {
        "kind": "summary_finding", "code": rule.id, "name": rule.name, "severity": severity.name(),
        "message": setting.lang.of(rule.message),
        "count": raised.count, "first_frame": raised.first.number(), "first_line": raised.first.line(),
        "first_t": moment(setting, raised.first.t_ns), "last_frame": raised.last.number(),
        "last_line": raised.last.line(), "last_t": moment(setting, raised.last.t_ns),
        "buses": array(names.filter_map(|(_, name)| named(name))),
        "nodes": array((0u8..128).filter(|node| raised.nodes >> node & 1 == 1)),
    }
}

/// Returns the figures of times, or `None` where nothing was measured.
fn spread(times: &Spread) -> Option<impl WriteJson> {
    (times.count > 0).then(|| basic(times))
}

/// Returns the same with the 99th percentile, which is never below the true one and at most 3.2 % above it.
fn ranked(times: &Ranked) -> Option<impl WriteJson> {
    let figures = || obj! { _: basic(&times.spread).inline(), "p99_us": us(times.percentile_ns(99)) };
    (times.spread.count > 0).then(figures)
}

fn basic(times: &Spread) -> Obj<impl Values> {
    obj! {
        "count": times.count, "min_us": us(times.min_ns), "mean_us": us(times.mean_ns()), "max_us": us(times.max_ns),
        "sigma_us": us(times.sigma_ns()),
    }
}

/// A decimal number in thousandths, written without zeros at its end.
pub(super) struct Thousandths(i128);

impl WriteJson for Thousandths {
    fn write_json(self, out: &mut Vec<u8>) {
        let number = self.0.unsigned_abs() as u64;
        put!(out; if self.0 < 0 { "-" } else { "" }, number / 1000);
        if !number.is_multiple_of(1000) {
            put!(out; ".", Padded::<3>(number % 1000));
            while out.last() == Some(&b'0') {
                out.pop();
            }
        }
    }
}

/// Returns nanoseconds as microseconds.
pub(super) fn us(ns: Ns) -> Thousandths {
    Thousandths(i128::from(ns.as_ns()))
}

/// Returns frames a second.
fn rate(frames: u64, elapsed_ns: Option<u64>) -> Option<Thousandths> {
    Some(ratio(u128::from(frames) * u128::from(NS), u128::from(elapsed_ns?)))
}

/// Returns bits as percent of those that the bit rate allows.
fn percent(bits: u64, elapsed_ns: Option<u64>, bit_rate: Option<u32>) -> Option<Thousandths> {
    let most = u128::from(elapsed_ns?) * u128::from(bit_rate?);
    Some(ratio(u128::from(bits) * 100 * u128::from(NS), most))
}

fn ratio(of: u128, to: u128) -> Thousandths {
    let to = to.max(1);
    Thousandths(i128::from(u64::try_from((of * 1000 + to / 2) / to).unwrap_or(u64::MAX)))
}

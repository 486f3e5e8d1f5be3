//! A capture in figures, as JSON lines: one object a record, in the order of this table.
//!
//! | kind | keys |
//! |---|---|
//! | `summary_capture` | `files frames unstamped buses first_t last_t seconds backward backward_most_us pause_us pause_frame reordered unreadable gaps dropped left_out damages bit_rate` |
//! | `summary_bus` | `bus frames rate peak_rate_1s peak_rate_100ms sent_by_host remote fd fd_switched extended errors gaps dropped services bits load load_peak_1s load_peak_1s_frame load_peak_100ms load_peak_100ms_frame burst` |
//! | `summary_sync` | `bus frames period counted counter_min counter_max counter_jumps` |
//! | `summary_node` | `bus node name name_from frames sent tpdo rpdo tpdo_rate rpdo_rate state state_text state_name lost changes states boot_ups error_control heartbeats heartbeat sdo response aborts emcys emcy` |
//! | `summary_pdo` | `bus node pdo id ext frames rate interval synchronous before_sync delay` |
//! | `summary_identifier` | `bus id ext frames rate interval length_min length_max` |
//! | `summary_finding` | `code name severity message count first_frame first_line first_t last_frame last_line last_t buses nodes` |
//!
//! Each bus is followed by its SYNC, its nodes, its PDOs, and those of its identifiers that are not CANopen; where nothing on
//! it is (rule BUS009), only by these, and all its frames count as `foreign`. Times that end in `_us` are numbers of microseconds with
//! up to three decimals. A spread (`period`, `heartbeat`, `response`, `interval`, `delay`) is
//! `{"count","min_us","mean_us","max_us","sigma_us"}`, and has `p99_us` too in `period`, `response` and `delay`; it is
//! null where nothing was measured. `p99_us` is never below the true one and at most 3.2 % above it
//! (`summary::spread`). Rates are frames a second, loads percent of `bit_rate`; all are null without stamps, loads also
//! without `--bitrate`, and a peak where the capture is shorter than its window. The mean counts what came after the
//! first stamp. `bits` are bits on the wire with stuff bits (`summary::bits` says which are counted).
//!
//! `seconds` is the time from the first to the last frame, `pause_us` the longest time without a frame; `reordered`
//! are SDO requests captured after their response; `gaps` is how often the capturing program says that it `dropped`
//! frames. `services` has a count for each service seen. `burst` is null or `{"frames","length_us","first_frame"}`.
//! `states` are `{"state","text","name","t","frame","commanded"}`, the first 64; `name` (`state_name` of the node) is
//! boot-up, stopped, operational or pre-operational in every language; `commanded` is true where a node that sends no
//! state was told to enter it. `sdo` is `{"transfers","ok","aborted","failed","incomplete"}`, `aborts` are
//! `{"code","text","by","count","first_frame","last_frame"}`, `emcy` likewise without `by`, at most 32 each. `name_from`
//! is `description` or `1008`; `error_control` is `heartbeat`, `guarding` or null. `before_sync` are PDOs captured before
//! their SYNC: they are not in `delay`.

use super::{Setting, left_out, name_or_null, number_or_null, quoted, seconds, truth};
use crate::finding::{Code, Severity};
use crate::frame::{CanId, FrameRef};
use crate::services::sdo::wire::Side;
use crate::summary::identifiers::Identifier;
use crate::summary::load::Peak;
use crate::summary::node::{Counted, Node};
use crate::summary::spread::{Ranked, Spread};
use crate::summary::traffic::{Pdo, Sync};
use crate::summary::{Bus, Capture, Raised, SERVICES, Summary};
use crate::text::digits::{Hex, Padded, put};
use crate::text::terms::{abort_code, nmt};
use crate::text::{Lang, escape};
use crate::wire::emcy;

const NS: u64 = 1_000_000_000;

/// NMT states (CiA 301 7.2.8.3.2) by the names that programs compare with.
const STATES: [(u8, &str); 4] =
    [(0x00, "boot-up"), (0x04, "stopped"), (0x05, "operational"), (0x7F, "pre-operational")];

/// Appends all records.
pub fn write(out: &mut Vec<u8>, setting: Setting<'_>, summary: &Summary) {
    capture(out, setting, summary);
    let elapsed_ns = elapsed(&summary.capture);
    for (id, one) in &summary.buses {
        let name = setting.buses.name(*id);
        bus(out, name, one, elapsed_ns, summary.network.bit_rate);
        if !one.identifiers.are_foreign() {
            if one.sync.frames > 0 {
                sync(out, name, &one.sync);
            }
            for (id, of_bus) in one.nodes() {
                node(out, setting, summary, name, id, of_bus, elapsed_ns);
            }
            for of_bus in one.pdos.iter() {
                pdo(out, name, of_bus, elapsed_ns);
            }
        }
        for (id, of_bus) in one.identifiers.iter() {
            identifier(out, name, id, of_bus, elapsed_ns);
        }
    }
    for (of, raised) in &summary.findings {
        finding(out, setting, *of, raised);
    }
}

/// Time measured in ns, where there is any.
fn elapsed(capture: &Capture) -> Option<u64> {
    capture.span.elapsed_ns.map(i64::unsigned_abs).filter(|elapsed| *elapsed > 0)
}

fn capture(out: &mut Vec<u8>, setting: Setting<'_>, summary: &Summary) {
    let capture = &summary.capture;
    let stamped = capture.span.elapsed_ns.is_some();
    put!(out; "{\"kind\":\"summary_capture\",\"files\":", capture.files, ",\"frames\":", capture.frames);
    put!(out; ",\"unstamped\":", capture.unstamped, ",\"buses\":", summary.buses.len(), ",\"first_t\":");
    setting.moment(out, capture.first.and_then(|first| first.t_ns));
    put!(out; ",\"last_t\":");
    setting.moment(out, capture.last.t_ns);
    put!(out; ",\"seconds\":");
    seconds(out, capture.span.elapsed_ns, setting.decimals);
    put!(out; ",\"backward\":", capture.span.backward, ",\"backward_most_us\":");
    us_or_null(out, stamped.then_some(capture.span.backward_most_ns));
    put!(out; ",\"pause_us\":");
    us_or_null(out, capture.pause.map(|(ns, _)| ns));
    put!(out; ",\"pause_frame\":");
    number_or_null(out, capture.pause.map(|(_, frame)| frame.no));
    put!(out; ",\"reordered\":", capture.reordered, ",\"unreadable\":", capture.unreadable);
    put!(out; ",\"gaps\":", summary.buses.values().map(|bus| bus.gaps).sum::<u64>());
    put!(out; ",\"dropped\":", summary.buses.values().map(|bus| bus.dropped).fold(0, u64::saturating_add));
    put!(out; ",\"left_out\":");
    left_out(out, &capture.left_out);
    put!(out; ",\"damages\":", capture.damages, ",\"bit_rate\":");
    number_or_null(out, summary.network.bit_rate.map(u64::from));
    put!(out; "}\n");
}

fn bus(out: &mut Vec<u8>, name: &[u8], bus: &Bus, elapsed_ns: Option<u64>, bit_rate: Option<u32>) {
    begin(out, "bus", name);
    put!(out; ",\"frames\":", bus.frames, ",\"rate\":");
    rate(out, bus.load.timed_frames, elapsed_ns);
    let spans = |window_ns: i64| elapsed_ns.filter(|elapsed| *elapsed >= window_ns.unsigned_abs());
    for ((window_ns, _, frames), key) in bus.load.peaks().zip(["1s", "100ms"]) {
        put!(out; ",\"peak_rate_", key, "\":");
        rate(out, frames.amount, spans(window_ns).map(|_| window_ns.unsigned_abs()));
    }
    put!(out; ",\"sent_by_host\":");
    number_or_null(out, bus.sent_by_host);
    put!(out; ",\"remote\":", bus.remote, ",\"fd\":", bus.fd, ",\"fd_switched\":", bus.fd_switched);
    put!(out; ",\"extended\":", bus.extended, ",\"errors\":", bus.errors, ",\"gaps\":", bus.gaps);
    put!(out; ",\"dropped\":", bus.dropped, ",\"services\":{");
    let services = if bus.identifiers.are_foreign() { bus.foreign_only() } else { bus.services };
    let seen = SERVICES.iter().zip(services).filter(|(_, count)| *count > 0);
    for (place, (service, count)) in seen.enumerate() {
        put!(out; if place > 0 { ",\"" } else { "\"" }, *service, "\":", count);
    }
    put!(out; "},\"bits\":", bus.load.bits, ",\"load\":");
    percent(out, bus.load.timed_bits, elapsed_ns, bit_rate);
    for ((window_ns, bits, _), key) in bus.load.peaks().zip(["1s", "100ms"]) {
        let Peak { amount, at } = bits;
        let span_ns = spans(window_ns).map(|_| window_ns.unsigned_abs());
        put!(out; ",\"load_peak_", key, "\":");
        percent(out, amount, span_ns, bit_rate);
        put!(out; ",\"load_peak_", key, "_frame\":");
        number_or_null(out, span_ns.and(bit_rate).map(|_| at.no));
    }
    match bus.load.longest_burst() {
        Some(burst) => {
            put!(out; ",\"burst\":{\"frames\":", burst.frames, ",\"length_us\":");
            us(out, burst.length_ns);
            put!(out; ",\"first_frame\":", burst.first.no, "}}\n");
        }
        None => put!(out; ",\"burst\":null}\n"),
    }
}

fn sync(out: &mut Vec<u8>, name: &[u8], sync: &Sync) {
    begin(out, "sync", name);
    put!(out; ",\"frames\":", sync.frames, ",\"period\":");
    ranked(out, &sync.period);
    let (least, greatest) = sync.counters;
    let counts = (sync.counted > 0).then_some(());
    put!(out; ",\"counted\":", sync.counted, ",\"counter_min\":");
    number_or_null(out, counts.map(|()| u64::from(least)));
    put!(out; ",\"counter_max\":");
    number_or_null(out, counts.map(|()| u64::from(greatest)));
    put!(out; ",\"counter_jumps\":");
    number_or_null(out, counts.map(|()| sync.jumps));
    put!(out; "}\n");
}

fn node(
    out: &mut Vec<u8>,
    setting: Setting<'_>,
    summary: &Summary,
    name: &[u8],
    id: u8,
    node: &Node,
    elapsed_ns: Option<u64>,
) {
    begin(out, "node", name);
    put!(out; ",\"node\":", id, ",\"name\":");
    match (summary.described(name, id), &node.device_name) {
        (Some(product), _) => {
            escape::json(out, product.as_bytes());
            put!(out; ",\"name_from\":\"description\"");
        }
        (None, Some(read)) => {
            escape::json(out, read.as_bytes());
            put!(out; ",\"name_from\":\"1008\"");
        }
        (None, None) => put!(out; "null,\"name_from\":null"),
    }
    put!(out; ",\"frames\":", node.frames, ",\"sent\":", node.sent, ",\"tpdo\":", node.tpdos, ",\"rpdo\":", node.rpdos);
    put!(out; ",\"tpdo_rate\":");
    rate(out, node.tpdos, elapsed_ns);
    put!(out; ",\"rpdo_rate\":");
    rate(out, node.rpdos, elapsed_ns);
    let states = node.states();
    put!(out; ",\"state\":");
    state(out, setting.lang, states.state, ["state_text", "state_name"]);
    put!(out; ",\"lost\":", truth(node.lost), ",\"changes\":", states.changes, ",\"states\":[");
    for (place, change) in states.listed.iter().enumerate() {
        put!(out; if place > 0 { ",{\"state\":" } else { "{\"state\":" });
        state(out, setting.lang, Some(change.state), ["text", "name"]);
        put!(out; ",\"t\":");
        setting.moment(out, change.at.t_ns);
        put!(out; ",\"frame\":", change.at.no, ",\"commanded\":", truth(change.commanded), "}");
    }
    put!(out; "],\"boot_ups\":", node.boot_ups, ",\"error_control\":");
    put!(out; match (node.guarded, node.heartbeats) {
        (true, _) => "\"guarding\"",
        (false, 0) => "null",
        (false, _) => "\"heartbeat\"",
    });
    put!(out; ",\"heartbeats\":", node.heartbeats, ",\"heartbeat\":");
    spread(out, &node.heartbeat);
    let [ok, aborted, failed, incomplete] = node.transfers;
    put!(out; ",\"sdo\":{\"transfers\":", ok + aborted + failed + incomplete, ",\"ok\":", ok, ",\"aborted\":", aborted);
    put!(out; ",\"failed\":", failed, ",\"incomplete\":", incomplete, "},\"response\":");
    ranked(out, &node.response);
    put!(out; ",\"aborts\":[");
    for (place, Counted { code: (code, by), count, first, last }) in node.aborts.iter().enumerate() {
        put!(out; if place > 0 { ",{\"code\":\"" } else { "{\"code\":\"" }, Hex::<8>(u64::from(*code)), "\",\"text\":");
        text_or_null(out, abort_code(setting.lang, *code));
        put!(out; match by {
            Side::Client => ",\"by\":\"client\"",
            Side::Server => ",\"by\":\"server\"",
        });
        counted(out, *count, *first, *last);
    }
    put!(out; "],\"emcys\":", node.emcys, ",\"emcy\":[");
    for (place, Counted { code, count, first, last }) in node.emcy_codes.iter().enumerate() {
        put!(out; if place > 0 { ",{\"code\":\"" } else { "{\"code\":\"" }, Hex::<4>(u64::from(*code)), "\",\"text\":");
        text_or_null(out, emcy::code(setting.lang, node.profile, *code));
        counted(out, *count, *first, *last);
    }
    put!(out; "]}\n");
}

fn counted(out: &mut Vec<u8>, count: u64, first: FrameRef, last: FrameRef) {
    put!(out; ",\"count\":", count, ",\"first_frame\":", first.no, ",\"last_frame\":", last.no, "}");
}

/// A state in hexadecimal, then its word and its name under these keys.
fn state(out: &mut Vec<u8>, lang: Lang, state: Option<u8>, [word, name]: [&'static str; 2]) {
    match state {
        Some(state) => put!(out; "\"", Hex::<2>(u64::from(state)), "\""),
        None => put!(out; "null"),
    }
    put!(out; ",\"", word, "\":");
    text_or_null(out, state.and_then(|state| nmt::state(lang, state)));
    put!(out; ",\"", name, "\":");
    let named = STATES.iter().find(|(code, _)| state == Some(*code));
    text_or_null(out, named.map(|(_, name)| *name));
}

fn pdo(out: &mut Vec<u8>, name: &[u8], pdo: &Pdo, elapsed_ns: Option<u64>) {
    let (node, transmit, number) = pdo.key;
    begin(out, "pdo", name);
    put!(out; ",\"node\":", node, ",\"pdo\":\"", if transmit { "TPDO" } else { "RPDO" }, number, "\"");
    can_id(out, pdo.id);
    put!(out; ",\"frames\":", pdo.frames, ",\"rate\":");
    rate(out, pdo.frames, elapsed_ns);
    put!(out; ",\"interval\":");
    spread(out, &pdo.interval);
    put!(out; ",\"synchronous\":", pdo.synchronous, ",\"before_sync\":", pdo.before_sync, ",\"delay\":");
    ranked(out, &pdo.delay);
    put!(out; "}\n");
}

fn identifier(out: &mut Vec<u8>, name: &[u8], id: CanId, one: &Identifier, elapsed_ns: Option<u64>) {
    begin(out, "identifier", name);
    can_id(out, id);
    put!(out; ",\"frames\":", one.frames, ",\"rate\":");
    rate(out, one.frames, elapsed_ns);
    put!(out; ",\"interval\":");
    spread(out, &one.interval);
    put!(out; ",\"length_min\":", one.length.0, ",\"length_max\":", one.length.1, "}\n");
}

pub(in crate::render) fn can_id(out: &mut Vec<u8>, id: CanId) {
    let raw = u64::from(id.raw());
    put!(out; ",\"id\":\"");
    if id.is_extended() {
        put!(out; Hex::<8>(raw))
    } else {
        put!(out; Hex::<3>(raw))
    }
    put!(out; "\",\"ext\":", truth(id.is_extended()));
}

fn finding(out: &mut Vec<u8>, setting: Setting<'_>, (code, severity): (Code, Severity), raised: &Raised) {
    let rule = code.rule();
    put!(out; "{\"kind\":\"summary_finding\",\"code\":\"", rule.id, "\",\"name\":\"", rule.name);
    put!(out; "\",\"severity\":\"", severity.name(), "\",\"message\":");
    quoted(out, |text| {
        put!(text; setting.lang.of(rule.message));
    });
    put!(out; ",\"count\":", raised.count);
    for (key, at) in [("first", raised.first), ("last", raised.last)] {
        put!(out; ",\"", key, "_frame\":");
        number_or_null(out, (at.no > 0).then_some(at.no));
        put!(out; ",\"", key, "_line\":");
        number_or_null(out, at.line);
        put!(out; ",\"", key, "_t\":");
        setting.moment(out, at.t_ns);
    }
    put!(out; ",\"buses\":[");
    let named =
        setting.buses.names().enumerate().filter(|(bus, name)| raised.buses >> bus & 1 == 1 && !name.is_empty());
    for (place, (_, name)) in named.enumerate() {
        put!(out; if place > 0 { "," } else { "" });
        escape::json(out, name);
    }
    put!(out; "],\"nodes\":[");
    for (place, node) in (0u8..128).filter(|node| raised.nodes >> node & 1 == 1).enumerate() {
        put!(out; if place > 0 { "," } else { "" }, node);
    }
    put!(out; "]}\n");
}

fn begin(out: &mut Vec<u8>, kind: &'static str, bus: &[u8]) {
    put!(out; "{\"kind\":\"summary_", kind, "\",\"bus\":");
    name_or_null(out, bus);
}

fn text_or_null(out: &mut Vec<u8>, text: Option<&str>) {
    match text {
        Some(text) => escape::json(out, text.as_bytes()),
        None => put!(out; "null"),
    }
}

fn spread(out: &mut Vec<u8>, times: &Spread) {
    if times.count == 0 {
        return put!(out; "null");
    }
    basic(out, times);
    put!(out; "}");
}

fn ranked(out: &mut Vec<u8>, times: &Ranked) {
    if times.spread.count == 0 {
        return put!(out; "null");
    }
    basic(out, &times.spread);
    put!(out; ",\"p99_us\":");
    us(out, times.percentile_ns(99));
    put!(out; "}");
}

fn basic(out: &mut Vec<u8>, times: &Spread) {
    put!(out; "{\"count\":", times.count);
    let figures = [
        (",\"min_us\":", times.min_ns),
        (",\"mean_us\":", times.mean_ns()),
        (",\"max_us\":", times.max_ns),
        (",\"sigma_us\":", times.sigma_ns()),
    ];
    for (key, ns) in figures {
        put!(out; key);
        us(out, ns);
    }
}

pub(super) fn us_or_null(out: &mut Vec<u8>, ns: Option<i64>) {
    match ns {
        Some(ns) => us(out, ns),
        None => put!(out; "null"),
    }
}

/// Nanoseconds as microseconds.
pub(super) fn us(out: &mut Vec<u8>, ns: i64) {
    put!(out; if ns < 0 { "-" } else { "" });
    thousandths(out, ns.unsigned_abs());
}

/// A decimal number without zeros at its end, given in thousandths.
fn thousandths(out: &mut Vec<u8>, number: u64) {
    put!(out; number / 1000);
    if !number.is_multiple_of(1000) {
        put!(out; ".", Padded::<3>(number % 1000));
        while out.last() == Some(&b'0') {
            out.pop();
        }
    }
}

/// Frames a second.
fn rate(out: &mut Vec<u8>, frames: u64, elapsed_ns: Option<u64>) {
    match elapsed_ns {
        Some(elapsed_ns) => ratio(out, u128::from(frames) * u128::from(NS), u128::from(elapsed_ns)),
        None => put!(out; "null"),
    }
}

/// Bits as percent of what the bit rate allows.
fn percent(out: &mut Vec<u8>, bits: u64, elapsed_ns: Option<u64>, bit_rate: Option<u32>) {
    match (elapsed_ns, bit_rate) {
        (Some(elapsed_ns), Some(bit_rate)) => {
            let most = u128::from(elapsed_ns) * u128::from(bit_rate);
            ratio(out, u128::from(bits) * 100 * u128::from(NS), most);
        }
        _ => put!(out; "null"),
    }
}

fn ratio(out: &mut Vec<u8>, of: u128, to: u128) {
    let to = to.max(1);
    thousandths(out, u64::try_from((of * 1000 + to / 2) / to).unwrap_or(u64::MAX));
}

//! A diagnosis in words: the verdict, the extent of the capture, what was looked at, the nodes, and what goes with each
//! problem. Terminal, library and page lay them out and add none of their own.

use super::digits::put;
use super::problems::title;
use super::profiles::Profile;
use super::sentence::{fill, print};
use super::terms::Row;
use super::{Lang, escape, terms};
use crate::bytes::frame::Buses;
use crate::bytes::ns::Ns;
use crate::evidence::services::Nature;
use crate::problems::problem::{Problem, Status};
use crate::problems::{Diagnosis, NodeView, advice, apart};
use crate::rules::finding::{Quantity, Said};
use crate::wire::error_control;
use crate::words::digits::Hex;

/// Words of machine output: `status.open`.
pub static WORDS: &[(&str, &str, &str)] = words!("diagnosis");
/// The reasons of the rules of cause, by their numbers.
static CAUSES: &[Row<u8>] = words!("causes");
/// The kinds of devices, by the numbers of their profiles.
static DEVICES: &[Row<u16>] = words!("devices");

/// A capture shorter than this shows no heartbeat that stays away, in ns.
const SHORT_NS: Ns = Ns::from_s(2);
/// Maximum number of rules that are named whose findings belong to no problem.
const LOOSE: usize = 3;
/// From this time on a delay is given in seconds, in ns: with two digits, or with three significant ones.
const SECONDS_NS: u64 = 2_000_000_000;
const SECOND_NS: Ns = Ns::from_s(1);
/// Advice that repeats what tells causes apart.
const APART: [&str; 4] = ["no-sign", "berr-reporting", "cable-only", "wiring"];

/// Numbers of roots: open, of unknown status, ended, harmless.
pub type Counts = [usize; 4];

/// Returns the word for a value of machine output: `of(lang, "status", "open")`; the value itself if there is none.
pub fn of(lang: Lang, what: &str, name: &'static str) -> &'static str {
    let row = WORDS.iter().find(|(key, ..)| key.split_once('.') == Some((what, name)));
    row.map_or(name, |(_, zh, en)| lang.pick(zh, en))
}

/// Returns the state of the worst problem: `ended` also if there is none, `unjudged` if that says nothing.
pub fn worst(nature: Nature, [open, unknown, ..]: Counts) -> &'static str {
    match (open, unknown, nature) {
        (1.., ..) => "open",
        (_, 1.., _) => "unknown",
        (.., Nature::Canopen) => "ended",
        _ => "unjudged",
    }
}

/// Appends the verdict: a mark, and the number of problems by status.
pub fn verdict(out: &mut Vec<u8>, lang: Lang, nature: Nature, counts: Counts) {
    let [open, unknown, ended, harmless] = counts;
    let worst = worst(nature, counts);
    put!(out; match worst {
        "open" => "✖ ",
        "unknown" => "? ",
        "ended" => "✔ ",
        _ => "- ",
    });
    let first = match (worst, open + unknown + ended, open) {
        ("unjudged", ..) => lang.pick("未作判断", "not judged"),
        (_, 0, _) => lang.pick("未发现问题", "no problems found"),
        (.., 0) => lang.pick("没有仍存在的问题", "no open problems"),
        _ => "",
    };
    put!(out; first);
    let mut between = if first.is_empty() { "" } else { ", " };
    for (count, words) in [
        (open, lang.pick("{count}个问题仍存在", "{count|open problem|open problems}")),
        (unknown, lang.pick("{count}个状态不明", "{count} of unknown status")),
        (ended, lang.pick("{count}个已恢复", "{count} ended")),
        (harmless, lang.pick("{count}个无害", "{count} harmless")),
    ] {
        if count > 0 {
            put!(out; between);
            counted(out, lang, words, count as u64);
            between = ", ";
        }
    }
}

/// Appends the extent of a capture: buses, time, frames, nodes.
pub fn extent<'a>(out: &mut Vec<u8>, lang: Lang, buses: impl Iterator<Item = &'a [u8]>, diagnosis: &Diagnosis) {
    let mut between = "";
    for bus in buses.filter(|bus| !bus.is_empty()) {
        put!(out; between);
        escape::terminal(out, bus);
        between = ", ";
    }
    between = if between.is_empty() { "" } else { " · " };
    if let Some(span_ns) = span_ns(diagnosis) {
        put!(out; between);
        tenths(out, span_ns);
        between = " · ";
    }
    put!(out; between);
    counted(out, lang, lang.pick("{count}帧", "{count|frame|frames}"), diagnosis.extent().0);
    put!(out; " · ");
    counted(out, lang, lang.pick("{count}个节点", "{count|node|nodes}"), diagnosis.nodes().len() as u64);
}

/// Returns the time of a capture with usable stamps, in ns.
fn span_ns(diagnosis: &Diagnosis) -> Option<Ns> {
    let (frames, first, last) = diagnosis.extent();
    last.since(first).filter(|_| frames > 0)
}

/// Appends a time in seconds with one digit after the point.
fn tenths(out: &mut Vec<u8>, ns: Ns) {
    put!(out; format!("{:.1} s", ns.as_ns() as f64 / 1e9).as_str());
}

/// Appends what could not be judged, if something could not.
pub fn notice(out: &mut Vec<u8>, lang: Lang, nature: Nature, diagnosis: &Diagnosis) {
    match (nature, span_ns(diagnosis)) {
        (Nature::Foreign, _) => {
            put!(out; lang.pick("不像CANopen的报文: 未作判断", "this does not look like CANopen: nothing was checked"));
        }
        (Nature::Silent, _) if diagnosis.extent().0 > 0 => put!(out; lang.pick(
            "只有远程帧或错误帧: 未作判断",
            "only remote requests or error frames: nothing was checked",
        )),
        (Nature::Silent, _) => put!(out; lang.pick("没有报文: 未作判断", "no traffic: nothing was checked")),
        (Nature::Unproven, _) => {
            put!(out; lang.pick("无法确认是CANopen: 判断有限", "may not be CANopen: little could be checked"));
        }
        (Nature::Canopen, None) => put!(out; lang.pick(
            "没有可用的时间戳: 只检查了顺序和内容, 未检查心跳、周期和超时",
            "no usable timestamps: order and content were checked, heartbeats, periods and timeouts were not",
        )),
        (Nature::Canopen, Some(span_ns)) if span_ns < SHORT_NS => {
            put!(out; lang.pick("报文记录只有", "the capture is only "));
            tenths(out, span_ns);
            put!(out; lang.pick(
                ": 可能看不出心跳丢失和周期问题",
                " long: lost heartbeats and periods may not show",
            ));
        }
        (Nature::Canopen, Some(_)) => {}
    }
}

/// Appends what was checked, in one line.
pub fn looked(out: &mut Vec<u8>, lang: Lang, diagnosis: &Diagnosis) {
    put!(out; if diagnosis.shown().error_frames {
        lang.pick(
            "已检查心跳、启动、EMCY、SDO、PDO、SYNC、驱动器状态和错误帧",
            "checked: heartbeats, boot-ups, EMCY, SDO, PDO, SYNC, drive states, error frames",
        )
    } else {
        lang.pick(
            "已检查心跳、启动、EMCY、SDO、PDO、SYNC和驱动器状态; 记录中没有错误帧",
            "checked: heartbeats, boot-ups, EMCY, SDO, PDO, SYNC, drive states; error frames were not recorded",
        )
    });
    let drives = diagnosis.nodes().iter().filter(|view| view.profile == Profile::DRIVE && view.drives.is_empty());
    let mut between = lang
        .pick("; 未识别到状态字, 未判断驱动器状态: 节点", "; no statusword recognized, drive states not judged: node ");
    for view in drives {
        put!(out; between, view.node);
        between = ", ";
    }
}

/// Appends what shows that the buses are well, in one line.
pub fn well(out: &mut Vec<u8>, lang: Lang, diagnosis: &Diagnosis) {
    let ([beating, guarded], responses, slowest_ns) = diagnosis.well();
    if beating > 0 {
        let words = lang.pick("{count}个节点有心跳", "{count|node|nodes} with heartbeats");
        counted(out, lang, words, beating);
    }
    if guarded > 0 {
        put!(out; if beating > 0 { "; " } else { "" });
        let words = lang.pick("{count}个节点响应节点保护", "{count|node|nodes} with responses to node guarding");
        counted(out, lang, words, guarded);
    }
    if responses > 0 {
        put!(out; if beating + guarded > 0 { "; " } else { "" });
        let words =
            lang.pick("默认SDO上{count}个响应, 最慢", "{count|response|responses} on default SDOs, the slowest after ");
        counted(out, lang, words, responses);
        significant(out, slowest_ns.as_ns() as f64 / 1e6);
        put!(out; " ms");
    }
}

/// Appends a number with three significant digits, without trailing zeros.
fn significant(out: &mut Vec<u8>, number: f64) {
    let digits = match number.abs() {
        100.0.. => 0,
        10.0.. => 1,
        1.0.. => 2,
        0.1.. => 3,
        0.01.. => 4,
        _ => 5,
    };
    let text = format!("{number:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    put!(out; text);
}

/// Appends the rules with findings above info that belong to no problem; a tick is no passed check.
pub fn loose(out: &mut Vec<u8>, lang: Lang, diagnosis: &Diagnosis) {
    let mut found: Vec<_> = diagnosis.ledger().loose().collect();
    found.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    if found.is_empty() {
        return;
    }
    put!(out; lang.pick("另有未计为问题的检查结果, 见 canalyze check: ", "also found, not counted as problems, see canalyze check: "));
    for (place, (code, count)) in found.iter().take(LOOSE).enumerate() {
        put!(out; if place > 0 { "; " } else { "" }, code.rule().id, " ", lang.of(code.rule().message));
        if *count > 1 {
            put!(out; " (", *count, ")");
        }
    }
    put!(out; if found.len() > LOOSE { " …" } else { "" });
}

/// Appends the part of a node's row in a column: 0 its name, 1 its role, 2 its NMT state, 3 the states of its axes, 4 its
/// last error, 5 the problem that it is in. `bus`: the name of its bus if there are several.
pub fn node(
    out: &mut Vec<u8>,
    lang: Lang,
    view: &NodeView,
    (bus, problem): (Option<&[u8]>, Option<u32>),
    column: usize,
) {
    match column {
        0 => {
            if let Some(bus) = bus {
                escape::terminal(out, bus);
                put!(out; ":");
            }
            put!(out; view.node);
        }
        1 => match terms::find(DEVICES, lang, view.profile.number()) {
            Some(device) => put!(out; device),
            None => put!(out; if view.is_beating { lang.pick("只有心跳", "heartbeats only") } else { "" }),
        },
        2 => match view.state.map(|state| (state, error_control::state(lang, state))) {
            Some((_, Some(word))) => put!(out; word),
            Some((state, None)) => put!(out; Hex::<2>(u64::from(state)), "h"),
            None => put!(out; lang.pick("状态不明", "state unknown")),
        },
        3 => {
            for (place, state) in view.drives.iter().enumerate() {
                put!(out; if place > 0 { ", " } else { "" }, terms::drive::state(lang, *state));
            }
        }
        4 => {
            if let Some(code) = view.error {
                put!(out; "EMCY ");
                print(out, lang, Quantity::Emcy(code, view.profile));
            }
        }
        _ => {
            if let Some(problem) = problem {
                put!(out; lang.pick("问题", "problem "), problem);
            }
        }
    }
}

/// Appends the title of a problem behind the name of its bus if there are several.
pub fn placed(out: &mut Vec<u8>, lang: Lang, buses: &Buses, diagnosis: &Diagnosis, one: &Problem) {
    let bus = buses.name(one.bus);
    if buses.count() > 1 && !bus.is_empty() {
        escape::terminal(out, bus);
        put!(out; " ");
    }
    title(out, lang, one, diagnosis.extent().1.and_then(|first| first.t_ns));
}

/// Appends the cause of a problem, with its number, its title and the certainty.
pub fn because(out: &mut Vec<u8>, lang: Lang, buses: &Buses, diagnosis: &Diagnosis, one: &Problem) {
    let Some((link, cause)) = one.cause.and_then(|link| Some((link, diagnosis.ledger().by_id(link.cause)?))) else {
        return;
    };
    put!(out; lang.pick("起因: 问题", "caused by "), cause.number, lang.pick(" ", ", "));
    placed(out, lang, buses, diagnosis, cause);
    put!(out; lang.pick("(", " ("), of(lang, "grade", link.grade.name()), ")");
}

/// Appends the reason by which the cause of a problem was found.
pub fn why(out: &mut Vec<u8>, lang: Lang, one: &Problem) {
    let reason = one.cause.and_then(|link| terms::find(CAUSES, lang, link.rule));
    put!(out; reason.unwrap_or_default());
}

/// Appends the time from the cause of a problem to it, with the limit for that: `+707 ms (1016h 700 ms)`.
pub fn delay(out: &mut Vec<u8>, diagnosis: &Diagnosis, one: &Problem) {
    let Some(cause) = one.cause.and_then(|link| diagnosis.ledger().by_id(link.cause)) else { return };
    let delay_ns = listed_ns(one).zip(listed_ns(cause)).map_or(Ns::ZERO, |(then, began)| then - began);
    if delay_ns != Ns::ZERO {
        put!(out; if delay_ns < Ns::ZERO { "-" } else { "+" });
        read(out, delay_ns.as_ns().unsigned_abs());
        if let Some((object, limit_ns)) = one.limit(cause) {
            put!(out; " (", Hex::<4>(u64::from(object)), "h ");
            read(out, limit_ns.as_ns().unsigned_abs());
            put!(out; ")");
        }
    }
}

/// Returns the stamp of the beginning of a problem.
fn listed_ns(one: &Problem) -> Option<Ns> {
    one.begin.listed().t_ns
}

/// Appends a time in ms, from 2 s on in s, with as many digits as are read.
fn read(out: &mut Vec<u8>, ns: u64) {
    let ms = ns as f64 / 1e6;
    let text = match ns {
        SECONDS_NS.. => format!("{:.2} s", ms / 1e3),
        10_000_000.. => format!("{ms:.0} ms"),
        _ if ns.is_multiple_of(1_000_000) => format!("{ms:.0} ms"),
        _ => format!("{ms:.1} ms"),
    };
    put!(out; text.as_str());
}

/// Appends how long after its cause a problem came.
pub fn after(out: &mut Vec<u8>, lang: Lang, diagnosis: &Diagnosis, one: &Problem) {
    let cause = one.cause.and_then(|link| diagnosis.ledger().by_id(link.cause));
    let Some((then, began)) = listed_ns(one).zip(cause.and_then(listed_ns)).filter(|(then, began)| then >= began)
    else {
        return;
    };
    let delay_ns = then - began;
    put!(out; ", ");
    if delay_ns >= SECOND_NS {
        significant(out, delay_ns.as_ns() as f64 / 1e9);
        put!(out; lang.pick(" s后", " s later"));
    } else {
        put!(out; format!("{:.0}", delay_ns.as_ns() as f64 / 1e6).as_str(), lang.pick(" ms后", " ms later"));
    }
}

/// Appends how often a problem happened, and the longest time, if it did several times.
pub fn repeats(out: &mut Vec<u8>, lang: Lang, one: &Problem) {
    if one.repeats.count < 2 {
        return;
    }
    counted(out, lang, lang.pick("共{count}次", "{count|time|times}"), one.repeats.count);
    if one.repeats.longest_ns > Ns::ZERO {
        put!(out; lang.pick(", 最长", ", at most "));
        read(out, one.repeats.longest_ns.as_ns().unsigned_abs());
    }
}

/// Returns what to check first, without what the lines that tell causes apart say.
pub fn checks<'a>(
    lang: Lang,
    diagnosis: &'a Diagnosis,
    one: &'a Problem,
) -> impl Iterator<Item = &'static str> + use<'a> {
    let told = apart::of(one, diagnosis.ledger(), diagnosis.shown());
    let left = advice::of(one, diagnosis.shown()).into_iter();
    left.filter(move |check| told.is_empty() || !APART.contains(&check.name)).map(move |check| lang.of(check.words))
}

/// Returns the numbers of problems by status.
pub fn counts(all: impl Iterator<Item = Status>) -> Counts {
    all.fold([0; 4], |mut counts, status| {
        if let Some(count) = counts.get_mut(status as usize) {
            *count += 1;
        }
        counts
    })
}

fn counted(out: &mut Vec<u8>, lang: Lang, words: &str, count: u64) {
    fill(out, lang, words, |_| Some(Said::Quantity(Quantity::Count(count))));
}

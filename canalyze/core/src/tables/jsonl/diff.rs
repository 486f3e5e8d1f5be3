//! Differences of two captures, as JSON lines: first the problems that differ, then the differences, then a line that
//! closes them. `a` and `b` are the content of each capture, or null.

use super::obj::{WriteJson, array, hex2, hex4, hex8, named, obj, pdo, raw, text, time};
use crate::bytes::ns::Ns;
use crate::problems::problem::Problem;
use crate::tables::diff::{DiffSetting, extents};
use crate::tables::jsonl::sdo::side as by;
use crate::views::diff::Comparison;
use crate::views::diff::difference::{CaptureSide, Difference, Shows};
use crate::views::diff::digest::{Action, Digest, Service, TransferDigest};
use crate::views::diff::problems::{ProblemDifference, lasted_ns};
use crate::words::diff as words;
use crate::words::digits::{Joined, put};
use crate::words::{findings, problems};

/// Appends all lines. `files`: the names of both.
pub fn write(out: &mut Vec<u8>, setting: DiffSetting<'_>, comparison: &Comparison, files: [&[u8]; 2]) {
    for one in &comparison.stories {
        if let Some(story) = story(setting, one) {
            story.write_line(out);
        }
    }
    for one in &comparison.differences {
        difference(setting, one).write_line(out);
    }
    let ([file_a, file_b], [digest_a, digest_b]) = (files, setting.digests);
    let ([outside_a, outside_b], [extent_a, extent_b]) = (comparison.outside, extents(setting, comparison));
    let side = |file, digest: &Digest, outside, (first, last): (u64, u64)| {
        obj! {
            "file": file, "frames": digest.frames,
            /// The frames between which both captures were compared.
            "first_frame": Some(first).filter(|no| *no > 0),
            "last_frame": Some(last).filter(|no| *no > 0),
            /// Frames outside of that.
            "outside": outside,
            /// The capture was too long.
            "full": digest.full,
        }
    };
    obj! {
        "kind": "diff",
        "same": comparison.count() == 0,
        "problems": comparison.stories.len(),
        /// Deprecated: the former name of `problems`.
        "incidents": comparison.stories.len(),
        "differences": comparison.differences.len() as u64 + comparison.more,
        /// Differences that are not listed.
        "more": comparison.more,
        /// Both captures show one session in time.
        "rigid": comparison.alignment.rigid,
        /// Periods were compared.
        "times": comparison.alignment.by_time,
        /// The place of one capture in the other is known.
        "placed": !comparison.alignment.is_blurred(),
        "a": side(file_a, digest_a, outside_a, extent_a), "b": side(file_b, digest_b, outside_b, extent_b),
    }
    .write_line(out);
}

/// Returns a problem that is in one capture only, or differs in both.
fn story<'a>(setting: DiffSetting<'a>, one: &'a ProblemDifference) -> Option<impl WriteJson> {
    let sides = setting.problems(one);
    let (_, first) = sides.iter().flatten().next()?;
    let [a, b] = sides.map(|side| side.map(|(digest, one)| problem(setting, digest, one)));
    Some(obj! {
        "kind": "problem_difference",
        "problem": first.kind.row().name,
        /// The name in A, or in B where A lacks the bus.
        "bus": named(setting.bus(one.bus)),
        "node": first.subject.node,
        /// `status`, `duration`, `count` and `cause`; empty where one capture has nothing.
        "differs": array(one.differs.iter().map(|differs| differs.name())),
        "a": a, "b": b,
    })
}

fn problem<'a>(setting: DiffSetting<'a>, digest: &'a Digest, one: &'a Problem) -> impl WriteJson {
    obj! {
        "bus": named(digest.buses.name(one.bus)),
        "id": one.number, "frame": one.begin.listed().no, "t": time(one.begin.listed().t_ns, digest.decimals),
        "end_frame": one.end.map(|end| end.listed().no),
        "status": one.status.name(),
        "duration_ns": lasted_ns(one).and_then(|ns| u64::try_from(ns.as_ns()).ok()),
        "count": one.repeats.count,
        /// The kind of the problem that caused it.
        "cause": digest.cause(one).map(|cause| cause.kind.row().name),
        "text": text(move |out| problems::title(out, setting.lang, one, digest.began_ns)),
    }
}

fn difference<'a>(setting: DiffSetting<'a>, one: &'a Difference) -> impl WriteJson {
    let shown = || one.sides.iter().flatten().map(|side| &side.shows);
    let moved = shown().find_map(|shows| match shows {
        Shows::Action(Action::Transfer(moved)) => Some(moved),
        _ => None,
    });
    let raised = shown().find_map(|shows| match shows {
        Shows::Finding(finding) => finding.object,
        _ => None,
    });
    let object = moved.and_then(|moved| moved.mux).or(raised);
    let [near_a, near_b] = one.beside;
    obj! {
        "kind": "difference",
        /// `bus`, `node`, `transfer` (in one capture only), `outcome`, `value` or `mode` (of a transfer), `nmt`, `state`,
        /// `drive_state`, `emcy`, `lss`, `frames`, `period`, `jitter`, `cob_id`, `mapping`, `length`, `poll` or `finding`.
        "what": one.what.name(),
        "bus": named(setting.bus(one.bus)),
        "node": one.node.filter(|node| *node > 0),
        /// `sync`, `time`, `error_control`, `TPDO1`, `RPDO1`, `SRDO1` or null.
        "service": one.what.service().map(service),
        "index": object.map(|mux| hex4(mux.index)),
        "sub": object.map(|mux| mux.sub),
        /// That of a transfer.
        "direction": moved.map(|moved| moved.direction.name()),
        "count": one.count,
        "text": text(move |out| words::subject(out, setting.lang, one)),
        "a": side(setting, one, 0), "b": side(setting, one, 1),
        /// Where a capture has nothing, the nearest frame before that both have.
        "a_near": near_a.map(|at| at.no),
        "b_near": near_b.map(|at| at.no),
    }
}

fn service(service: Service) -> impl WriteJson {
    raw(move |out| match service {
        Service::Sync => "sync".write_json(out),
        Service::Time => "time".write_json(out),
        Service::ErrorControl => "error_control".write_json(out),
        Service::Pdo(transmit, number) => pdo(transmit, number).write_json(out),
        Service::Srdo(number, _) => put!(out; "\"SRDO", number, "\""),
    })
}

fn side<'a>(setting: DiffSetting<'a>, difference: &'a Difference, place: usize) -> Option<impl WriteJson> {
    let side = difference.sides.get(place)?.as_ref()?;
    let digest = setting.digests.get(place);
    let bus = difference.bus.get(place).copied().flatten().zip(digest);
    Some(obj! {
        "bus": bus.and_then(|(bus, digest)| named(digest.buses.name(bus))),
        /// The first frame of it.
        "frame": side.since.number(),
        "line": side.since.line(),
        "t": time(side.since.t_ns, digest.map_or(9, |digest| digest.decimals)),
        "last_frame": side.at.number(),
        "text": text(move |out| words::side(out, setting.lang, difference.what, Some(side))),
        "value": raw(move |out| value(out, setting, side)),
    })
}

/// Appends the value of a side, whose keys depend on its kind.
fn value(out: &mut Vec<u8>, setting: DiffSetting<'_>, side: &CaptureSide) {
    let period = |ns: Ns| obj! { "period_us": ns / 1000 };
    if let Some(ns) = side.pace_ns {
        return period(ns).write_json(out);
    }
    match &side.shows {
        Shows::Action(action) => self::action(out, action),
        Shows::Count(frames) => obj! { "frames": *frames }.write_json(out),
        Shows::Time(ns) => period(*ns).write_json(out),
        Shows::Id(id) => obj! { "id": *id }.write_json(out),
        Shows::Mapping(words) => obj! { "mapping": array(words.iter().map(|word| hex8(*word))) }.write_json(out),
        Shows::Length(bytes) => obj! { "length": *bytes }.write_json(out),
        Shows::Finding(finding) => {
            let message = text(|text| findings::placed(text, setting.lang, finding, finding.at.no));
            obj! { "code": finding.code.rule().id, "message": message }.write_json(out);
        }
    }
}

fn action(out: &mut Vec<u8>, action: &Action) {
    match action {
        Action::Transfer(moved) => transfer(moved).write_json(out),
        Action::Nmt(code) | Action::State(code) => obj! { "code": hex2(*code) }.write_json(out),
        Action::BootUp => obj! { "code": hex2(0) }.write_json(out),
        Action::Drive(state) => obj! { "code": state.map(|state| hex4(state.coding().1)) }.write_json(out),
        Action::Emcy(code, register) => obj! { "code": hex4(*code), "register": hex2(*register) }.write_json(out),
        Action::Lss(bytes) => obj! { "data": Joined(bytes) }.write_json(out),
    }
}

fn transfer(moved: &TransferDigest) -> impl WriteJson {
    obj! {
        "status": moved.status.name(), "mode": moved.mode.name(),
        "abort": moved.abort.map(|abort| obj! { "code": abort.code, "by": by(abort.by) }),
        "size": moved.size,
        /// The first 64 bytes.
        "data": Joined(&moved.kept),
    }
}

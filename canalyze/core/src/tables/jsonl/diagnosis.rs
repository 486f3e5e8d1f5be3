//! Problems, as JSON lines: an object a problem in the order of their numbers, then one for all of it.

use super::obj::{Given, Obj, Values, WriteJson, array, hex2, hex4, map, named, obj, pdo, raw, text, time};
use super::{Setting, facts};
use crate::bytes::frame::FrameRef;
use crate::problems::problem::{Problem, ProblemId, Status, members};
use crate::problems::rank::{is_root, roots};
use crate::problems::{Diagnosis, Phase, advice, apart};
use crate::wire::error_control;
use crate::words::diagnosis as said;
use crate::words::digits::put;
use crate::words::problems as words;
use crate::words::terms::drive;

/// Number of columns of a node's row.
const NODE_COLUMNS: usize = 6;

/// Appends all of it.
pub fn write(out: &mut Vec<u8>, setting: Setting<'_>, diagnosis: &Diagnosis) {
    for one in diagnosis.ledger().numbered() {
        obj! {
            _: problem(setting, diagnosis, one, "final").inline(),
            _: for_people(setting, diagnosis, one).inline(),
        }
        .write_line(out);
    }
    whole(setting, diagnosis).write_line(out);
}

/// Appends the problems alone at their end, without the keys that are for people.
pub fn ends(out: &mut Vec<u8>, setting: Setting<'_>, diagnosis: &Diagnosis) {
    for one in diagnosis.ledger().numbered() {
        problem(setting, diagnosis, one, "final").write_line(out);
    }
}

/// Appends a problem as it is known when it begins to show, when its cause changes, or when it is over. Its status and
/// cause may still change.
pub fn changed(out: &mut Vec<u8>, setting: Setting<'_>, diagnosis: &Diagnosis, (phase, id): (Phase, ProblemId)) {
    let name = match phase {
        Phase::Opened => "opened",
        Phase::Linked => "linked",
        Phase::Ended => "ended",
    };
    if let Some(one) = diagnosis.ledger().by_id(id) {
        problem(setting, diagnosis, one, name).write_line(out);
    }
}

/// Returns the keys that are for people, and for those who put problems in order.
fn for_people<'a>(setting: Setting<'a>, diagnosis: &'a Diagnosis, one: &'a Problem) -> Obj<impl Values> {
    let lang = setting.lang;
    let ledger = diagnosis.ledger();
    let link = one.cause.filter(|_| !is_root(one));
    obj! {
        "texts": obj! {
            "title": text(move |out| said::placed(out, lang, setting.buses, diagnosis, one)),
            "because": text(move |out| if link.is_some() { said::because(out, lang, setting.buses, diagnosis, one) }),
            "why": text(move |out| if link.is_some() { said::why(out, lang, one) }),
            "delay": text(move |out| if link.is_some() { said::delay(out, diagnosis, one) }),
            "after": text(move |out| if link.is_some() { said::after(out, lang, diagnosis, one) }),
            "repeats": text(move |out| said::repeats(out, lang, one)),
        },
        "checks_left": array(said::checks(lang, diagnosis, one)),
        "checks_text": array(advice::of(one, diagnosis.shown()).into_iter().map(move |check| lang.of(check.words))),
        "apart": array(apart::of(one, ledger, diagnosis.shown()).into_iter().map(move |tell| obj! {
            "told": tell.told, "text": lang.of(tell.words),
        })),
        /// The time after which the effect was due, and the object that sets it.
        "limit": link.and_then(|link| one.limit(ledger.by_id(link.cause)?)).map(|(object, limit)| obj! {
            "ns": limit, "object": hex4(object),
        }),
        "root": is_root(one),
    }
}

fn problem<'a>(
    setting: Setting<'a>,
    diagnosis: &'a Diagnosis,
    one: &'a Problem,
    phase: &'static str,
) -> Obj<impl Values> {
    let (_, first, _) = diagnosis.extent();
    let ledger = diagnosis.ledger();
    let place = move |at: FrameRef| {
        let at = at.listed();
        obj! { "frame": at.no, "t": time(at.t_ns, setting.decimals) }
    };
    let subject = &one.subject;
    let several = subject.node.is_none() || subject.nodes.count_ones() > 1;
    let is_effect = |other: &&Problem| !is_root(other) && other.cause.is_some_and(|link| link.cause == one.id);
    let parts = || one.parts.iter().map(|part| ledger.number(*part)).filter(|part| *part > 0);
    let again = one.repeats.count > 1;
    obj! {
        "kind": "problem", "phase": phase, "id": one.number,
        "problem": one.kind.row().name,
        /// Deprecated: the former name of `problem`.
        "incident": one.kind.row().name,
        "subject": obj! {
            "bus": named(setting.buses.name(one.bus)),
            "node": Given(subject.node),
            "nodes": Given(several.then(|| array(members(subject.nodes)))),
            "axis": Given(subject.axis),
            "pdo": Given(subject.pdo.map(|(transmit, number)| pdo(transmit, number))),
        },
        "status": one.status.name(),
        "impact": one.impact().name(),
        "grade": one.grade.name(), "begin": place(one.begin),
        "noticed": obj! { _: place(one.noticed).inline(), "delay": time(one.noticed.since(one.begin), 9) },
        "end": one.end.map(place),
        /// Null where it is only possible: the problem stays a root.
        "cause": one.cause.filter(|_| !is_root(one)).map(|link| obj! {
            "id": ledger.number(link.cause), "link": text(move |out| put!(out; "L", link.rule)), "grade": link.grade.name(),
        }),
        "effects": array(ledger.numbered().into_iter().filter(is_effect).map(|other| other.number)),
        "steps": array(one.steps.iter().map(move |step| obj! {
            _: place(step.at).inline(),
            "role": step.role.name(),
            "text": text(move |out| words::said(out, setting.lang, &step.said)),
            "finding": step.from.map(|code| code.rule().id),
        })),
        "facts": raw(move |out| facts_of(out, one)),
        "checks": array(advice::of(one, diagnosis.shown()).into_iter().map(|check| check.name)),
        "findings": array(one.findings.iter().map(|cited| obj! {
            "code": cited.code.rule().id,
            "frame": cited.frame.listed().number(),
            "about_frame": cited.about.listed().number(),
        })),
        "message": text(move |out| words::title(out, setting.lang, one, first.and_then(|first| first.t_ns))),
        "repeats": obj! {
            "count": one.repeats.count,
            "longest_ns": Given(again.then_some(one.repeats.longest_ns)),
            "total_ns": Given(again.then_some(one.repeats.total_ns)),
        },
        /// Problems that were reported while the capture was read and turned out at its end to be one with this.
        "parts": Given(parts().next().map(|_| array(parts()))),
    }
}

/// Appends the measured facts, as an object.
pub fn facts_of(out: &mut Vec<u8>, one: &Problem) {
    obj! { _: facts::quantities(one.facts.iter().copied()) }.write_json(out);
}

fn whole<'a>(setting: Setting<'a>, diagnosis: &'a Diagnosis) -> impl WriteJson {
    let (frames, first, last) = diagnosis.extent();
    let (ledger, lang) = (diagnosis.ledger(), setting.lang);
    let ([beating, guarded], responses, slowest) = diagnosis.well();
    let order = roots(ledger);
    let nature = diagnosis.nature();
    let roots_by_status = said::counts(order.iter().filter_map(|id| ledger.by_id(*id)).map(|one| one.status));
    let several = setting.buses.count() > 1;
    let counts = [Status::Open, Status::Unknown, Status::Ended, Status::Harmless].map(|status| {
        let all = order.iter().filter_map(|id| ledger.by_id(*id));
        (status.name(), all.filter(|one| one.status == status).count())
    });
    obj! {
        "kind": "diagnosis",
        /// The roots, in the order of reading.
        "order": array(order.into_iter().map(|id| ledger.number(id))),
        /// Roots by status.
        "counts": map(counts),
        "frames": frames,
        "begin": time(first.and_then(|first| first.t_ns), setting.decimals),
        "end": time(last.t_ns.filter(|_| frames > 0), setting.decimals),
        "buses": array(setting.buses.names().map(named)),
        "nodes": array(diagnosis.nodes().iter().map(move |view| obj! {
            "bus": named(setting.buses.name(view.bus)),
            "node": view.node,
            "state": view.state.map(hex2),
            "state_text": view.state.and_then(|state| error_control::state(setting.lang, state)),
            /// The states of its axes, in words.
            "drives": array(view.drives.iter().map(move |state| drive::state(lang, *state))),
            /// The last error code that it has reported and not cleared.
            "error": view.error.map(hex4),
            "problem": view.problem.map(|id| ledger.number(id)),
            /// Its row on the first screen: name, role, NMT state, states of axes, last error, problem.
            "cells": array((0..NODE_COLUMNS).map(move |column| {
                let bus = several.then(|| setting.buses.name(view.bus));
                let problem = view.problem.map(|id| ledger.number(id));
                text(move |out| said::node(out, lang, view, (bus, problem), column))
            })),
        })),
        /// The nature of the buses.
        "nature": nature.name(),
        "verdict": obj! {
            "status": said::worst(nature, roots_by_status),
            "text": text(move |out| said::verdict(out, lang, nature, roots_by_status)),
        },
        "extent": text(move |out| said::extent(out, lang, setting.buses.names(), diagnosis)),
        /// The statement that something was not judged; empty if all was.
        "notice": text(move |out| said::notice(out, lang, nature, diagnosis)),
        "looked": text(move |out| said::looked(out, lang, diagnosis)),
        "well": text(move |out| said::well(out, lang, diagnosis)),
        "loose_text": text(move |out| said::loose(out, lang, diagnosis)),
        /// The number of nodes with heartbeats or responses to guarding.
        "heartbeats": beating + guarded,
        /// The number of responses of default SDOs, and the longest time until one.
        "responses": responses,
        "slowest_ns": slowest,
        /// Rules with findings above info that belong to no problem, with their number.
        "loose": array(ledger.loose().map(|(code, count)| obj! { "code": code.rule().id, "count": count })),
        "beyond": ledger.beyond(),
        "error_frames": diagnosis.shown().error_frames,
    }
}

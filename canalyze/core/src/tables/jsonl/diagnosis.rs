//! What went wrong, as JSON lines: an object an incident in the order of their numbers, then one for all of it. `phase` is
//! `final` then; while a capture is read, incidents that begin to show, whose cause has changed since, and that are over are
//! `opened`, `linked` and `ended`: what those say of status and cause holds by then, and may change.
//!
//! `incident`: `kind phase id incident subject status impact grade begin noticed end cause effects steps facts checks
//! findings message repeats parts`, and for people `checks_text apart limit root`. `parts`, where there are such, are the numbers of those that were told of
//! while the capture was read and turned out at its end to be one with it: they have no line of their own then. `subject`
//! has `bus`, and `node`, `nodes`, `axis`, `pdo` where there are such; `cause` is
//! `{"id","link","grade"}`, `limit` the time `{"ns","object"}` after which the effect was due; `steps` are `{"frame","t","role","text","finding"}`. `diagnosis`:
//! `order` (the roots, as they are read), `counts` of roots by status, `frames begin end buses nodes beyond error_frames`.

use super::{Setting, facts, name_or_null, number_or_null, object::Object, quoted, seconds, truth};
use crate::bytes::frame::FrameRef;
use crate::stories::incident::{Incident, IncidentId, Status, members};
use crate::stories::rank::{is_root, roots};
use crate::stories::{Diagnosis, Phase, advice, apart};
use crate::words::digits::{Hex, put};
use crate::words::incidents as words;

/// Appends all of it.
pub fn write(out: &mut Vec<u8>, setting: Setting<'_>, diagnosis: &Diagnosis) {
    for one in diagnosis.ledger().numbered() {
        incident(out, setting, diagnosis, one, "final");
        for_people(out, setting, diagnosis, one);
    }
    whole(out, setting, diagnosis);
}

/// Appends the incidents alone, without what is for people: how they stand at the end.
pub fn ends(out: &mut Vec<u8>, setting: Setting<'_>, diagnosis: &Diagnosis) {
    for one in diagnosis.ledger().numbered() {
        incident(out, setting, diagnosis, one, "final");
        put!(out; "}\n");
    }
}

fn place(out: &mut Vec<u8>, setting: Setting<'_>, at: FrameRef) {
    put!(out; "{\"frame\":", at.no, ",\"t\":");
    seconds(out, at.t_ns, setting.decimals);
}

/// Appends an incident as it is known when it begins to show, when its cause changes, or when it is over.
pub fn changed(out: &mut Vec<u8>, setting: Setting<'_>, diagnosis: &Diagnosis, (phase, id): (Phase, IncidentId)) {
    let name = match phase {
        Phase::Opened => "opened",
        Phase::Linked => "linked",
        Phase::Ended => "ended",
    };
    if let Some(one) = diagnosis.ledger().by_id(id) {
        incident(out, setting, diagnosis, one, name);
        put!(out; "}\n");
    }
}

/// Closes an incident with what is for people, and for who puts them in order.
fn for_people(out: &mut Vec<u8>, setting: Setting<'_>, diagnosis: &Diagnosis, one: &Incident) {
    put!(out; ",\"checks_text\":[");
    for (number, check) in advice::of(one, diagnosis.shown()).iter().enumerate() {
        put!(out; if number > 0 { "," } else { "" });
        quoted(out, |text| put!(text; setting.lang.of(check.words)));
    }
    put!(out; "],\"apart\":[");
    for (number, tell) in apart::of(one, diagnosis.ledger(), diagnosis.shown()).iter().enumerate() {
        put!(out; if number > 0 { "," } else { "" }, "{\"told\":", truth(tell.told), ",\"text\":");
        quoted(out, |text| put!(text; setting.lang.of(tell.words)));
        put!(out; "}");
    }
    put!(out; "],\"limit\":");
    let link = one.cause.filter(|_| !is_root(one));
    match link.and_then(|link| one.limit(diagnosis.ledger().by_id(link.cause)?)) {
        Some((object, limit)) => {
            put!(out; "{\"ns\":", limit, ",\"object\":\"", Hex::<4>(u64::from(object)), "\"}");
        }
        None => put!(out; "null"),
    }
    put!(out; ",\"root\":", truth(is_root(one)), "}\n");
}

/// Appends an incident, without the brace that closes it.
fn incident(out: &mut Vec<u8>, setting: Setting<'_>, diagnosis: &Diagnosis, one: &Incident, phase: &'static str) {
    let (_, first, _) = diagnosis.extent();
    let row = one.kind.row();
    put!(out; "{\"kind\":\"incident\",\"phase\":\"", phase, "\",\"id\":", u64::from(one.number), ",\"incident\":\"", row.name);
    put!(out; "\",\"subject\":{\"bus\":");
    name_or_null(out, setting.buses.name(one.bus));
    if let Some(node) = one.subject.node {
        put!(out; ",\"node\":", node);
    }
    if one.subject.node.is_none() || one.subject.nodes.count_ones() > 1 {
        put!(out; ",\"nodes\":[");
        for (place, node) in members(one.subject.nodes).enumerate() {
            put!(out; if place > 0 { "," } else { "" }, node);
        }
        put!(out; "]");
    }
    if let Some(axis) = one.subject.axis {
        put!(out; ",\"axis\":", axis);
    }
    if let Some((transmit, number)) = one.subject.pdo {
        put!(out; ",\"pdo\":\"", if transmit { "TPDO" } else { "RPDO" }, number, "\"");
    }
    put!(out; "},\"status\":\"", one.status.name(), "\",\"impact\":\"", one.impact().name());
    put!(out; "\",\"grade\":\"", one.grade.name(), "\",\"begin\":");
    place(out, setting, one.begin);
    put!(out; "},\"noticed\":");
    place(out, setting, one.noticed);
    put!(out; ",\"delay\":");
    seconds(out, one.noticed.since(one.begin), 9);
    put!(out; "},\"end\":");
    match one.end {
        Some(end) => {
            place(out, setting, end);
            put!(out; "}");
        }
        None => put!(out; "null"),
    }
    put!(out; ",\"cause\":");
    // What is only possible is no cause: the incident stays a root.
    match one.cause.filter(|_| !is_root(one)) {
        Some(link) => {
            put!(out; "{\"id\":", u64::from(diagnosis.ledger().number(link.cause)), ",\"link\":\"L", u64::from(link.rule));
            put!(out; "\",\"grade\":\"", link.grade.name(), "\"}");
        }
        None => put!(out; "null"),
    }
    put!(out; ",\"effects\":[");
    let effects = diagnosis.ledger().numbered().into_iter();
    let mine = |other: &&Incident| !is_root(other) && other.cause.is_some_and(|link| link.cause == one.id);
    for (place, other) in effects.filter(mine).enumerate() {
        put!(out; if place > 0 { "," } else { "" }, u64::from(other.number));
    }
    put!(out; "],\"steps\":[");
    for (number, step) in one.steps.iter().enumerate() {
        put!(out; if number > 0 { "," } else { "" });
        place(out, setting, step.at);
        put!(out; ",\"role\":\"", step.role.name(), "\",\"text\":");
        quoted(out, |text| words::said(text, setting.lang, &step.said));
        put!(out; ",\"finding\":");
        match step.from {
            Some(code) => put!(out; "\"", code.rule().id, "\""),
            None => put!(out; "null"),
        }
        put!(out; "}");
    }
    put!(out; "],\"facts\":");
    facts_of(out, one);
    let checks = advice::of(one, diagnosis.shown());
    put!(out; ",\"checks\":[");
    for (number, check) in checks.iter().enumerate() {
        put!(out; if number > 0 { "," } else { "" }, "\"", check.name, "\"");
    }
    put!(out; "],\"findings\":[");
    for (place, cited) in one.findings.iter().enumerate() {
        put!(out; if place > 0 { "," } else { "" }, "{\"code\":\"", cited.code.rule().id, "\",\"frame\":");
        number_or_null(out, (cited.frame > 0).then_some(cited.frame));
        put!(out; ",\"about_frame\":");
        number_or_null(out, (cited.about > 0).then_some(cited.about));
        put!(out; "}");
    }
    put!(out; "],\"message\":");
    quoted(out, |text| words::title(text, setting.lang, one, first.and_then(|first| first.t_ns)));
    put!(out; ",\"repeats\":{\"count\":", one.repeats.count);
    if one.repeats.count > 1 {
        put!(out; ",\"longest_ns\":", one.repeats.longest_ns, ",\"total_ns\":", one.repeats.total_ns);
    }
    put!(out; "}");
    let parts: Vec<_> =
        one.parts.iter().map(|part| diagnosis.ledger().number(*part)).filter(|part| *part > 0).collect();
    if !parts.is_empty() {
        put!(out; ",\"parts\":[");
        for (place, part) in parts.into_iter().enumerate() {
            put!(out; if place > 0 { "," } else { "" }, u64::from(part));
        }
        put!(out; "]");
    }
}

/// Appends what was measured, as an object.
pub fn facts_of(out: &mut Vec<u8>, one: &Incident) {
    put!(out; "{");
    for (number, (name, value)) in one.facts.iter().enumerate() {
        put!(out; if number > 0 { ",\"" } else { "\"" });
        facts::pair(out, name, *value);
    }
    put!(out; "}");
}

fn whole(out: &mut Vec<u8>, setting: Setting<'_>, diagnosis: &Diagnosis) {
    let (frames, first, last) = diagnosis.extent();
    put!(out; "{\"kind\":\"diagnosis\",\"order\":[");
    let order = roots(diagnosis.ledger());
    for (place, id) in order.iter().enumerate() {
        put!(out; if place > 0 { "," } else { "" }, u64::from(diagnosis.ledger().number(*id)));
    }
    put!(out; "],\"counts\":{");
    for (place, status) in [Status::Stands, Status::Unknown, Status::Over, Status::Harmless].iter().enumerate() {
        let all = order.iter().filter_map(|id| diagnosis.ledger().by_id(*id));
        let count = all.filter(|one| one.status == *status).count();
        put!(out; if place > 0 { ",\"" } else { "\"" }, status.name(), "\":", count as u64);
    }
    put!(out; "},\"frames\":", frames, ",\"begin\":");
    seconds(out, first.and_then(|first| first.t_ns), setting.decimals);
    put!(out; ",\"end\":");
    seconds(out, last.t_ns.filter(|_| frames > 0), setting.decimals);
    put!(out; ",\"buses\":[");
    for (place, bus) in setting.buses.names().enumerate() {
        put!(out; if place > 0 { "," } else { "" });
        name_or_null(out, bus);
    }
    put!(out; "],\"nodes\":[");
    for (place, view) in diagnosis.nodes().iter().enumerate() {
        put!(out; if place > 0 { "," } else { "" });
        let mut object = Object::open(out);
        name_or_null(object.key("bus"), setting.buses.name(view.bus));
        object.number("node", view.node);
        let state = object.key("state");
        match view.state {
            Some(state_of) => put!(state; "\"", Hex::<2>(u64::from(state_of)), "\""),
            None => put!(state; "null"),
        }
        number_or_null(object.key("incident"), view.incident.map(|id| u64::from(diagnosis.ledger().number(id))));
        object.close();
    }
    put!(out; "],\"beyond\":", diagnosis.ledger().beyond(), ",\"error_frames\":");
    put!(out; truth(diagnosis.shown().error_frames), "}\n");
}

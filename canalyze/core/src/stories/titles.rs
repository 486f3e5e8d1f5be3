//! The title line of an incident, from its kind and its facts.

use super::incident::{Incident, Role, Status};
use super::kinds::Kind;
use super::sayings::Saying;
use crate::rules::Measured;
use crate::rules::finding::Quantity;

/// Returns the line; `None` if the words of the kind suffice. `began_ns`: the first stamp of the capture.
pub fn of(one: &Incident, began_ns: Option<i64>) -> Option<Measured> {
    let at = one.begin.t_ns.zip(began_ns).map_or(0, |(at, began)| at.saturating_sub(began));
    let get = |name: &str| one.get(name);
    let ns = |name: &str| match get(name) {
        Some(Quantity::Ns(ns)) => Some(ns),
        _ => None,
    };
    let count = one.repeats.count;
    if one.begin.t_ns.is_none() {
        return untimed(one);
    }
    Some(match one.kind {
        Kind::NodeSilent if count > 1 => Saying::SilentOften { at, count }.into(),
        Kind::NodeSilent => match (ns("silence"), get("boot_up"), one.end, ns("period")) {
            (Some(silence), Some(_), ..) => Saying::SilentAndBooted { at, silence }.into(),
            (Some(silence), None, None, _) if one.steps.iter().any(|step| step.role == Role::Recovery) => {
                Saying::SilentAndWaits { at, silence }.into()
            }
            (_, _, Some(end), _) => Saying::SilentAndBack { at, silence: end.since(one.begin).unwrap_or(0) }.into(),
            (.., Some(period)) => Saying::Silent { at, period }.into(),
            _ => Saying::SilentSince { at }.into(),
        },
        Kind::HeartbeatStopped => Saying::HeartbeatStopped { at }.into(),
        Kind::SegmentLost => Saying::Segment { at, count: one.subject.nodes.count_ones().into() }.into(),
        Kind::NodeRestarted if count == 1 => Saying::Restarted { at }.into(),
        Kind::NodeRestarted | Kind::RestartLoop => Saying::RestartedOften { at, count }.into(),
        Kind::NodeAbsent => Saying::Absent { at }.into(),
        Kind::NoBootUp => Saying::NoBootUp { at }.into(),
        Kind::LeftOperational => match get("state") {
            Some(Quantity::State(state)) => Saying::LeftOperational { at, state }.into(),
            _ => return None,
        },
        Kind::StartWithoutEffect | Kind::CommandedReset | Kind::CommandedStop => match (one.kind, get("command")) {
            (Kind::StartWithoutEffect, Some(Quantity::Command(command))) => {
                Saying::WithoutEffect { at, command }.into()
            }
            (Kind::CommandedReset, Some(Quantity::Command(command))) => Saying::ResetByCommand { at, command }.into(),
            (_, Some(Quantity::Command(command))) => Saying::StoppedByCommand { at, command }.into(),
            _ => return None,
        },
        Kind::ConsumerTimeTooShort => match (ns("limit"), get("watched"), ns("period")) {
            (Some(limit), Some(Quantity::Count(watched)), Some(period)) => {
                Saying::TooShort { limit, watched, period }.into()
            }
            _ => return None,
        },
        Kind::AxisFault => match get("code") {
            Some(Quantity::Emcy(code, profile)) => Saying::FaultWith { at, code: (code, profile) }.into(),
            _ if one.has("seen_in_fault") => Saying::FaultSeen { at }.into(),
            _ => Saying::Fault { at }.into(),
        },
        _ if !one.clue.reported.is_empty() => match get("code") {
            Some(Quantity::Emcy(code, profile)) if count > 1 => {
                Saying::ReportedOften { code: (code, profile), at, count }.into()
            }
            Some(Quantity::Emcy(code, profile)) => Saying::Reported { code: (code, profile), at }.into(),
            _ => return None,
        },
        _ if get("refused").is_some() => match (get("refused"), get("object"), get("abort")) {
            (Some(Quantity::Count(count)), Some(Quantity::Object(object)), Some(Quantity::Abort(abort))) => {
                match one.status {
                    Status::Over if one.has("booted") => Saying::Refused { count, object, abort }.into(),
                    Status::Over if one.has("others") => Saying::RefusedOthers { count, object, abort }.into(),
                    Status::Over => Saying::RefusedMadeGood { count, object, abort }.into(),
                    _ => Saying::Refused { count, object, abort }.into(),
                }
            }
            _ => return None,
        },
        Kind::RequestUnanswered if count == 1 => match get("object") {
            Some(Quantity::Object(object)) => Saying::Unanswered { object, at }.into(),
            _ => Saying::UnansweredAt { at }.into(),
        },
        Kind::CaptureGap | Kind::BusSilent => match ns("silence") {
            Some(silence) => Saying::GapOf { at, silence }.into(),
            None => Saying::Gap { at }.into(),
        },
        Kind::SyncStopped => Saying::SyncStopped { at }.into(),
        Kind::PdoMissing | Kind::PdoLength | Kind::PdoNotAllowed => match (one.kind, one.subject.pdo) {
            (Kind::PdoMissing, Some(pdo)) => Saying::PdoMissing { pdo, at }.into(),
            (_, Some(pdo)) => Saying::PdoOf { pdo, at }.into(),
            _ => Saying::Since { at }.into(),
        },
        _ if count > 1 => Saying::Times { at, count }.into(),
        _ => Saying::Since { at }.into(),
    })
}

/// Returns the line in a capture without stamps.
fn untimed(one: &Incident) -> Option<Measured> {
    let get = |name: &str| one.get(name);
    Some(match (one.kind, get("code"), get("object")) {
        (Kind::AxisFault, Some(Quantity::Emcy(code, profile)), _) => Saying::FaultOnce { code: (code, profile) }.into(),
        (_, Some(Quantity::Emcy(code, profile)), _) => Saying::ReportedOnce { code: (code, profile) }.into(),
        (Kind::RequestUnanswered, _, Some(Quantity::Object(object))) => Saying::UnansweredOnce { object }.into(),
        (_, _, Some(Quantity::Object(object))) if get("refused").is_some() => match (get("refused"), get("abort")) {
            (Some(Quantity::Count(count)), Some(Quantity::Abort(abort))) => {
                Saying::Refused { count, object, abort }.into()
            }
            _ => return None,
        },
        (Kind::PdoLength | Kind::PdoNotAllowed, ..) => Saying::OfPdo { pdo: one.subject.pdo? }.into(),
        _ => return None,
    })
}

/// Returns true if the line names the kind by itself; otherwise the words of the kind precede it.
pub fn is_whole(one: &Incident) -> bool {
    if one.begin.t_ns.is_none() {
        return !matches!(one.kind, Kind::PdoLength | Kind::PdoNotAllowed);
    }
    match one.kind {
        Kind::PdoLength | Kind::PdoNotAllowed | Kind::CaptureGap => {
            one.kind == Kind::CaptureGap || !one.clue.reported.is_empty()
        }
        Kind::NodeSilent
        | Kind::HeartbeatStopped
        | Kind::SegmentLost
        | Kind::NodeRestarted
        | Kind::RestartLoop
        | Kind::NodeAbsent
        | Kind::NoBootUp
        | Kind::LeftOperational
        | Kind::StartWithoutEffect
        | Kind::CommandedReset
        | Kind::CommandedStop
        | Kind::ConsumerTimeTooShort
        | Kind::AxisFault
        | Kind::RequestUnanswered
        | Kind::BusSilent
        | Kind::SyncStopped
        | Kind::PdoMissing => one.repeats.count == 1 || one.kind != Kind::RequestUnanswered,
        _ => !one.clue.reported.is_empty() || one.has("refused"),
    }
}

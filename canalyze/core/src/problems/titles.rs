//! The title line of an incident, from its kind and its facts.

use super::incident::{Incident, Status};
use super::kinds::IncidentKind;
use super::sayings::Saying;
use crate::rules::Measured;
use crate::rules::finding::{Code, Quantity};

/// Returns the line; `None` if the words of the kind suffice. `began_ns`: the first stamp of the capture.
pub fn of(one: &Incident, began_ns: Option<i64>) -> Option<Measured> {
    let at = one.begin.listed().t_ns.zip(began_ns).map_or(0, |(at, began)| at.saturating_sub(began));
    let get = |name: &str| one.get(name);
    let ns = |name: &str| match get(name) {
        Some(Quantity::Ns(ns)) => Some(ns),
        _ => None,
    };
    let count = one.repeats.count;
    // A clock that was set back since has no time of the capture's beginning.
    if one.begin.t_ns.is_none() || at < 0 {
        return untimed(one);
    }
    Some(match one.kind {
        IncidentKind::NodeSilent if count > 1 => Saying::SilentOften { at, count }.into(),
        IncidentKind::NodeSilent => match (ns("silence"), get("boot_up"), one.end, ns("period")) {
            (Some(silence), Some(_), ..) => Saying::SilentAndBooted { at, silence }.into(),
            (Some(silence), None, None, _) if one.is_back() => Saying::SilentAndWaits { at, silence }.into(),
            (Some(silence), None, Some(_), _) => Saying::SilentAndBack { at, silence }.into(),
            (_, _, Some(end), _) => Saying::SilentAndBack { at, silence: end.since(one.begin).unwrap_or(0) }.into(),
            (.., Some(period)) => Saying::Silent { at, period }.into(),
            _ => Saying::SilentSince { at }.into(),
        },
        IncidentKind::HeartbeatStopped => Saying::HeartbeatStopped { at }.into(),
        IncidentKind::SegmentLost => {
            let count = one.subject.nodes.count_ones().into();
            match (one.is_back(), one.end) {
                (true, Some(_)) => Saying::SegmentAndBack { at, count }.into(),
                (true, None) => Saying::SegmentAndWaits { at, count }.into(),
                (false, _) => Saying::Segment { at, count }.into(),
            }
        }
        IncidentKind::NodeRestarted if one.subject.nodes.count_ones() > 1 => {
            Saying::RestartedTogether { at, count: one.subject.nodes.count_ones().into() }.into()
        }
        IncidentKind::NodeRestarted if count == 1 => Saying::Restarted { at }.into(),
        IncidentKind::NodeRestarted | IncidentKind::RestartLoop => Saying::RestartedOften { at, count }.into(),
        IncidentKind::NodeAbsent if one.has("commands") => Saying::AbsentCommanded { at }.into(),
        IncidentKind::NodeAbsent => match one.end.and_then(|end| Some(end.t_ns?.saturating_sub(began_ns?))) {
            Some(heard) if one.has("boot_up") => Saying::AbsentThenBooted { at, heard }.into(),
            Some(heard) => Saying::AbsentThenHeard { at, heard }.into(),
            None => Saying::Absent { at }.into(),
        },
        IncidentKind::NotStarted => match get("object") {
            Some(Quantity::Object(object)) if one.subject.nodes.count_ones() < 2 => {
                Saying::NeverStarted { at, object }.into()
            }
            _ => return None,
        },
        IncidentKind::LateAnswer => match (get("object"), ns("delay"), ns("waited")) {
            (Some(Quantity::Object(object)), Some(delay), Some(waited)) => {
                Saying::Late { object, at, delay, waited }.into()
            }
            _ => return None,
        },
        IncidentKind::NoBootUp => Saying::NoBootUp { at }.into(),
        IncidentKind::MuteAfterBoot => match ns("period") {
            Some(period) => Saying::Mute { at, period }.into(),
            None => return None,
        },
        IncidentKind::ResetAgain => Saying::ResetAgain { at, count }.into(),
        IncidentKind::AnotherDevice => match (get("object"), get("was"), get("is")) {
            (Some(Quantity::Object(object)), Some(Quantity::Hex8(was)), Some(Quantity::Hex8(is))) => {
                Saying::Another { object, was, is }.into()
            }
            _ => return None,
        },
        IncidentKind::HeartbeatSwitchedOff => Saying::SwitchedOff { at }.into(),
        IncidentKind::WatchedAbsent => match (get("watched"), ns("limit")) {
            (Some(Quantity::Count(watched)), Some(limit)) => Saying::NeverSeen { watched, limit }.into(),
            _ => return None,
        },
        IncidentKind::AnswerElsewhere => match (get("object"), get("id")) {
            (Some(Quantity::Object(object)), Some(Quantity::Id(id))) => Saying::Elsewhere { object, id, count }.into(),
            _ => return None,
        },
        IncidentKind::ReadInVain => match (get("object"), get("abort")) {
            (Some(Quantity::Object(object)), Some(Quantity::Abort(abort))) => {
                Saying::ReadInVain { object, count, abort }.into()
            }
            _ => return None,
        },
        IncidentKind::RpdoStopped => Saying::RpdoStopped { pdo: one.subject.pdo?, at }.into(),
        IncidentKind::NotTaken => match (get("id"), get("other"), get("frames")) {
            (Some(Quantity::Id(id)), Some(Quantity::Id(other)), Some(Quantity::Count(frames))) => {
                Saying::NotTaken { id, frames, pdo: one.subject.pdo?, other }.into()
            }
            _ => return None,
        },
        IncidentKind::DuplicateNodeId if one.has("answers") => Saying::TwoServers { at }.into(),
        IncidentKind::DuplicateNodeId if one.has("equal_answers") => Saying::TwoResponses { at }.into(),
        IncidentKind::NotEnabled => match get("statusword") {
            Some(Quantity::Statusword(statusword)) => Saying::NotEnabled { at, statusword }.into(),
            _ => Saying::Since { at }.into(),
        },
        IncidentKind::SharedCobId if one.has("alternates") => Saying::TwoSenders { pdo: one.subject.pdo?, at }.into(),
        IncidentKind::LeftOperational => match get("state") {
            Some(Quantity::State(state)) => Saying::LeftOperational { at, state }.into(),
            _ => return None,
        },
        IncidentKind::StartWithoutEffect | IncidentKind::CommandedReset | IncidentKind::CommandedStop => {
            match (one.kind, get("command")) {
                (IncidentKind::StartWithoutEffect, Some(Quantity::Command(command))) => {
                    Saying::WithoutEffect { at, command }.into()
                }
                (IncidentKind::CommandedReset, Some(Quantity::Command(command))) => {
                    Saying::ResetByCommand { at, command }.into()
                }
                (_, Some(Quantity::Command(command))) => Saying::StoppedByCommand { at, command }.into(),
                _ => return None,
            }
        }
        IncidentKind::ConsumerTimeTooShort => match (ns("limit"), get("watched"), ns("period")) {
            (Some(limit), Some(Quantity::Count(watched)), Some(period)) => {
                Saying::TooShort { limit, watched, period }.into()
            }
            _ => return None,
        },
        IncidentKind::AxisFault if one.has("error_code") && !one.has("code") => match get("error_code") {
            Some(Quantity::Emcy(code, profile)) => Saying::FaultRead { at, code: (code, profile) }.into(),
            _ => return None,
        },
        IncidentKind::AxisFault => match get("code") {
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
        _ if one.has("client_aborted") => return client_aborted(one),
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
        IncidentKind::RequestUnanswered if is_to_stopped(one) => Saying::Since { at }.into(),
        IncidentKind::RequestUnanswered if count == 1 => match get("object") {
            Some(Quantity::Object(object)) => Saying::Unanswered { object, at }.into(),
            _ => Saying::UnansweredAt { at }.into(),
        },
        IncidentKind::CaptureGap | IncidentKind::BusSilent => match ns("silence") {
            Some(silence) => Saying::GapOf { at, silence }.into(),
            None => Saying::Gap { at }.into(),
        },
        IncidentKind::BusErrors => Saying::Since { at }.into(),
        IncidentKind::SyncStopped => match once(one) {
            Some(lasts) => Saying::SyncGap { at, lasts }.into(),
            None => Saying::SyncStopped { at }.into(),
        },
        IncidentKind::Flood => match (get("id"), ns("gap"), ns("period")) {
            (Some(Quantity::Id(id)), Some(gap), Some(period)) => Saying::FloodOf { id, gap, period, at }.into(),
            _ => Saying::Since { at }.into(),
        },
        IncidentKind::PdoMissing | IncidentKind::PdoLength => match (one.kind, one.subject.pdo) {
            (IncidentKind::PdoMissing, Some(pdo)) => match once(one) {
                Some(lasts) => Saying::PdoGap { pdo, at, lasts }.into(),
                None => Saying::PdoMissing { pdo, at }.into(),
            },
            (_, Some(pdo)) => Saying::PdoOf { pdo, at }.into(),
            _ => Saying::Since { at }.into(),
        },
        _ if count > 1 => Saying::Times { at, count }.into(),
        _ => Saying::Since { at }.into(),
    })
}

/// Returns the duration of an incident that has ended and came once, in ns.
fn once(one: &Incident) -> Option<i64> {
    one.end.and_then(|end| end.since(one.begin)).filter(|lasts| one.repeats.count == 1 && *lasts > 0)
}

/// Returns the line of a download that its client aborted.
fn client_aborted(one: &Incident) -> Option<Measured> {
    Some(match (one.get("object"), one.get("abort")) {
        (Some(Quantity::Object(object)), Some(Quantity::Abort(abort))) => {
            Saying::ClientAborted { object, abort }.into()
        }
        (None, Some(Quantity::Abort(abort))) => Saying::ClientAbortedUnseen { abort }.into(),
        _ => return None,
    })
}

/// Returns the line in a capture without stamps.
fn untimed(one: &Incident) -> Option<Measured> {
    let get = |name: &str| one.get(name);
    if one.has("client_aborted") {
        return client_aborted(one);
    }
    Some(match (one.kind, get("code"), get("object")) {
        (IncidentKind::ReadInVain, _, Some(Quantity::Object(object))) => match get("abort") {
            Some(Quantity::Abort(abort)) => Saying::ReadInVain { object, count: one.repeats.count, abort }.into(),
            _ => return None,
        },
        (IncidentKind::AnswerElsewhere, _, Some(Quantity::Object(object))) => match get("id") {
            Some(Quantity::Id(id)) => Saying::Elsewhere { object, id, count: one.repeats.count }.into(),
            _ => return None,
        },
        (IncidentKind::NodeAbsent, ..) if one.end.is_some() => Saying::HeardLater.into(),
        (IncidentKind::AxisFault, Some(Quantity::Emcy(code, profile)), _) => {
            Saying::FaultOnce { code: (code, profile) }.into()
        }
        (_, Some(Quantity::Emcy(code, profile)), _) => Saying::ReportedOnce { code: (code, profile) }.into(),
        (IncidentKind::RequestUnanswered, _, Some(Quantity::Object(object))) => {
            Saying::UnansweredOnce { object }.into()
        }
        (_, _, Some(Quantity::Object(object))) if get("refused").is_some() => match (get("refused"), get("abort")) {
            (Some(Quantity::Count(count)), Some(Quantity::Abort(abort))) => {
                Saying::Refused { count, object, abort }.into()
            }
            _ => return None,
        },
        (IncidentKind::PdoLength, ..) => Saying::OfPdo { pdo: one.subject.pdo? }.into(),
        _ => return None,
    })
}

/// Returns true for requests that a Stopped node does not serve.
fn is_to_stopped(one: &Incident) -> bool {
    one.findings.first().is_some_and(|cited| cited.code == Code::Sdo011)
}

/// Returns true if the line names the kind by itself; otherwise the words of the kind precede it.
pub fn is_whole(one: &Incident, began_ns: Option<i64>) -> bool {
    if one.begin.t_ns.is_none() || one.begin.t_ns < began_ns {
        return !matches!(one.kind, IncidentKind::PdoLength | IncidentKind::PdoNotAllowed);
    }
    match one.kind {
        IncidentKind::PdoLength | IncidentKind::PdoNotAllowed | IncidentKind::CaptureGap => {
            one.kind == IncidentKind::CaptureGap || !one.clue.reported.is_empty()
        }
        IncidentKind::RequestUnanswered if is_to_stopped(one) => false,
        IncidentKind::DuplicateNodeId => one.has("answers") || one.has("equal_answers"),
        IncidentKind::NotEnabled => one.has("statusword"),
        IncidentKind::SharedCobId => one.has("alternates"),
        IncidentKind::WatchedAbsent => one.has("limit"),
        IncidentKind::NotStarted | IncidentKind::LateAnswer => of(one, began_ns).is_some(),
        IncidentKind::Flood
        | IncidentKind::MuteAfterBoot
        | IncidentKind::ResetAgain
        | IncidentKind::AnotherDevice
        | IncidentKind::HeartbeatSwitchedOff
        | IncidentKind::AnswerElsewhere
        | IncidentKind::ReadInVain
        | IncidentKind::RpdoStopped
        | IncidentKind::NotTaken => true,
        IncidentKind::NodeSilent
        | IncidentKind::HeartbeatStopped
        | IncidentKind::SegmentLost
        | IncidentKind::NodeRestarted
        | IncidentKind::RestartLoop
        | IncidentKind::NodeAbsent
        | IncidentKind::NoBootUp
        | IncidentKind::LeftOperational
        | IncidentKind::StartWithoutEffect
        | IncidentKind::CommandedReset
        | IncidentKind::CommandedStop
        | IncidentKind::ConsumerTimeTooShort
        | IncidentKind::AxisFault
        | IncidentKind::RequestUnanswered
        | IncidentKind::BusSilent
        | IncidentKind::SyncStopped
        | IncidentKind::PdoMissing => one.repeats.count == 1 || one.kind != IncidentKind::RequestUnanswered,
        _ => !one.clue.reported.is_empty() || one.has("refused") || one.has("client_aborted"),
    }
}

//! The title line of a problem, from its kind and its facts.

use super::kinds::ProblemKind;
use super::problem::{Problem, Status};
use super::sayings::Saying;
use crate::rules::Measured;
use crate::rules::finding::{Code, Quantity};

/// Returns the line; `None` if the words of the kind suffice. `began_ns`: the first stamp of the capture.
pub fn of(one: &Problem, began_ns: Option<i64>) -> Option<Measured> {
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
        ProblemKind::NodeSilent if count > 1 => Saying::SilentOften { at, count }.into(),
        ProblemKind::NodeSilent => match (ns("silence"), get("boot_up"), one.end, ns("period")) {
            (Some(silence), Some(_), ..) => Saying::SilentAndBooted { at, silence }.into(),
            (Some(silence), None, None, _) if one.is_back() => Saying::SilentAndWaits { at, silence }.into(),
            (Some(silence), None, Some(_), _) => Saying::SilentAndBack { at, silence }.into(),
            (_, _, Some(end), _) => Saying::SilentAndBack { at, silence: end.since(one.begin).unwrap_or(0) }.into(),
            (.., Some(period)) => Saying::Silent { at, period }.into(),
            _ => Saying::SilentSince { at }.into(),
        },
        ProblemKind::HeartbeatStopped => Saying::HeartbeatStopped { at }.into(),
        ProblemKind::SegmentLost => {
            let count = one.subject.nodes.count_ones().into();
            match (one.is_back(), one.end) {
                (true, Some(_)) => Saying::SegmentAndBack { at, count }.into(),
                (true, None) => Saying::SegmentAndWaits { at, count }.into(),
                (false, _) => Saying::Segment { at, count }.into(),
            }
        }
        ProblemKind::NodeRestarted if one.subject.nodes.count_ones() > 1 => {
            Saying::RestartedTogether { at, count: one.subject.nodes.count_ones().into() }.into()
        }
        ProblemKind::NodeRestarted if count == 1 => Saying::Restarted { at }.into(),
        ProblemKind::NodeRestarted | ProblemKind::RestartLoop => Saying::RestartedOften { at, count }.into(),
        ProblemKind::NodeAbsent if one.has("commands") => Saying::AbsentCommanded { at }.into(),
        ProblemKind::NodeAbsent => match one.end.and_then(|end| Some(end.t_ns?.saturating_sub(began_ns?))) {
            Some(heard) if one.has("boot_up") => Saying::AbsentThenBooted { at, heard }.into(),
            Some(heard) => Saying::AbsentThenHeard { at, heard }.into(),
            None => Saying::Absent { at }.into(),
        },
        ProblemKind::NotStarted => match get("object") {
            Some(Quantity::Object(object)) if one.subject.nodes.count_ones() < 2 => {
                Saying::NeverStarted { at, object }.into()
            }
            _ => return None,
        },
        ProblemKind::LateAnswer => match (get("object"), ns("delay"), ns("waited")) {
            (Some(Quantity::Object(object)), Some(delay), Some(waited)) => {
                Saying::Late { object, at, delay, waited }.into()
            }
            _ => return None,
        },
        ProblemKind::NoBootUp => Saying::NoBootUp { at }.into(),
        ProblemKind::MuteAfterBoot => match ns("period") {
            Some(period) => Saying::Mute { at, period }.into(),
            None => return None,
        },
        ProblemKind::ResetAgain => Saying::ResetAgain { at, count }.into(),
        ProblemKind::AnotherDevice => match (get("object"), get("was"), get("is")) {
            (Some(Quantity::Object(object)), Some(Quantity::Hex8(was)), Some(Quantity::Hex8(is))) => {
                Saying::Another { object, was, is }.into()
            }
            _ => return None,
        },
        ProblemKind::HeartbeatSwitchedOff => Saying::SwitchedOff { at }.into(),
        ProblemKind::WatchedAbsent => match (get("watched"), ns("limit")) {
            (Some(Quantity::Count(watched)), Some(limit)) => Saying::NeverSeen { watched, limit }.into(),
            _ => return None,
        },
        ProblemKind::AnswerElsewhere => match (get("object"), get("id")) {
            (Some(Quantity::Object(object)), Some(Quantity::Id(id))) => Saying::Elsewhere { object, id, count }.into(),
            _ => return None,
        },
        ProblemKind::ReadInVain => match (get("object"), get("abort")) {
            (Some(Quantity::Object(object)), Some(Quantity::Abort(abort))) => {
                Saying::ReadInVain { object, count, abort }.into()
            }
            _ => return None,
        },
        ProblemKind::RpdoStopped => Saying::RpdoStopped { pdo: one.subject.pdo?, at }.into(),
        ProblemKind::NotTaken => match (get("id"), get("other"), get("frames")) {
            (Some(Quantity::Id(id)), Some(Quantity::Id(other)), Some(Quantity::Count(frames))) => {
                Saying::NotTaken { id, frames, pdo: one.subject.pdo?, other }.into()
            }
            (Some(Quantity::Id(id)), None, Some(Quantity::Count(frames))) => {
                Saying::NotTakenAny { id, frames, pdo: one.subject.pdo? }.into()
            }
            _ => return None,
        },
        ProblemKind::DuplicateNodeId if one.has("answers") => Saying::TwoServers { at }.into(),
        ProblemKind::DuplicateNodeId if one.has("equal_answers") => Saying::TwoResponses { at }.into(),
        ProblemKind::NotEnabled => match get("statusword") {
            Some(Quantity::Statusword(statusword)) => Saying::NotEnabled { at, statusword }.into(),
            _ => Saying::Since { at }.into(),
        },
        ProblemKind::SharedCobId if one.has("alternates") => Saying::TwoSenders { pdo: one.subject.pdo?, at }.into(),
        ProblemKind::LeftOperational => match get("state") {
            Some(Quantity::State(state)) => Saying::LeftOperational { at, state }.into(),
            _ => return None,
        },
        ProblemKind::StartWithoutEffect | ProblemKind::CommandedReset | ProblemKind::CommandedStop => {
            match (one.kind, get("command")) {
                (ProblemKind::StartWithoutEffect, Some(Quantity::Command(command))) => {
                    Saying::WithoutEffect { at, command }.into()
                }
                (ProblemKind::CommandedReset, Some(Quantity::Command(command))) => {
                    Saying::ResetByCommand { at, command }.into()
                }
                (_, Some(Quantity::Command(command))) => Saying::StoppedByCommand { at, command }.into(),
                _ => return None,
            }
        }
        ProblemKind::ConsumerTimeTooShort => match (ns("limit"), get("watched"), ns("period")) {
            (Some(limit), Some(Quantity::Count(watched)), Some(period)) => {
                Saying::TooShort { limit, watched, period }.into()
            }
            _ => return None,
        },
        ProblemKind::AxisFault if one.has("error_code") && !one.has("code") => match get("error_code") {
            Some(Quantity::Emcy(code, profile)) => Saying::FaultRead { at, code: (code, profile) }.into(),
            _ => return None,
        },
        ProblemKind::AxisFault => match get("code") {
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
                    Status::Ended if one.has("booted") => Saying::Refused { count, object, abort }.into(),
                    Status::Ended if one.has("others") => Saying::RefusedOthers { count, object, abort }.into(),
                    Status::Ended => Saying::RefusedMadeGood { count, object, abort }.into(),
                    _ => Saying::Refused { count, object, abort }.into(),
                }
            }
            _ => return None,
        },
        ProblemKind::RequestUnanswered if is_to_stopped(one) => Saying::Since { at }.into(),
        ProblemKind::RequestUnanswered if count == 1 => match get("object") {
            Some(Quantity::Object(object)) => Saying::Unanswered { object, at }.into(),
            _ => Saying::UnansweredAt { at }.into(),
        },
        ProblemKind::CaptureGap | ProblemKind::BusSilent => match ns("silence") {
            Some(silence) => Saying::GapOf { at, silence }.into(),
            None => Saying::Gap { at }.into(),
        },
        ProblemKind::BusErrors => Saying::Since { at }.into(),
        ProblemKind::SyncStopped => match once(one) {
            Some(lasts) => Saying::SyncGap { at, lasts }.into(),
            None => Saying::SyncStopped { at }.into(),
        },
        ProblemKind::Flood => match (get("id"), ns("gap"), ns("period")) {
            (Some(Quantity::Id(id)), Some(gap), Some(period)) => Saying::FloodOf { id, gap, period, at }.into(),
            (Some(Quantity::Id(id)), Some(gap), None) => Saying::FloodNew { id, gap, at }.into(),
            _ => Saying::Since { at }.into(),
        },
        ProblemKind::PdoMissing | ProblemKind::PdoLength => match (one.kind, one.subject.pdo) {
            (ProblemKind::PdoMissing, Some(pdo)) => match once(one) {
                Some(lasts) => Saying::PdoGap { pdo, at, lasts }.into(),
                None => Saying::PdoMissing { pdo, at }.into(),
            },
            (_, Some(pdo)) => Saying::PdoOf { pdo, at }.into(),
            _ => Saying::Since { at }.into(),
        },
        _ if count > 1 => Saying::Times { at, count }.into(),
        // It had ended when it was noticed.
        _ if one.end.is_some_and(|end| end.no <= one.noticed.no) => Saying::At { at }.into(),
        _ => Saying::Since { at }.into(),
    })
}

/// Returns the duration of a problem that has ended and came once, in ns.
fn once(one: &Problem) -> Option<i64> {
    one.end.and_then(|end| end.since(one.begin)).filter(|lasts| one.repeats.count == 1 && *lasts > 0)
}

/// Returns the line of a download that its client aborted.
fn client_aborted(one: &Problem) -> Option<Measured> {
    Some(match (one.get("object"), one.get("abort")) {
        (Some(Quantity::Object(object)), Some(Quantity::Abort(abort))) => {
            Saying::ClientAborted { object, abort }.into()
        }
        (None, Some(Quantity::Abort(abort))) => Saying::ClientAbortedUnseen { abort }.into(),
        _ => return None,
    })
}

/// Returns the line in a capture without stamps.
fn untimed(one: &Problem) -> Option<Measured> {
    let get = |name: &str| one.get(name);
    if one.has("client_aborted") {
        return client_aborted(one);
    }
    Some(match (one.kind, get("code"), get("object")) {
        (ProblemKind::ReadInVain, _, Some(Quantity::Object(object))) => match get("abort") {
            Some(Quantity::Abort(abort)) => Saying::ReadInVain { object, count: one.repeats.count, abort }.into(),
            _ => return None,
        },
        (ProblemKind::AnswerElsewhere, _, Some(Quantity::Object(object))) => match get("id") {
            Some(Quantity::Id(id)) => Saying::Elsewhere { object, id, count: one.repeats.count }.into(),
            _ => return None,
        },
        (ProblemKind::NodeAbsent, ..) if one.end.is_some() => Saying::HeardLater.into(),
        (ProblemKind::AxisFault, Some(Quantity::Emcy(code, profile)), _) => {
            Saying::FaultOnce { code: (code, profile) }.into()
        }
        (_, Some(Quantity::Emcy(code, profile)), _) => Saying::ReportedOnce { code: (code, profile) }.into(),
        (ProblemKind::RequestUnanswered, _, Some(Quantity::Object(object))) => Saying::UnansweredOnce { object }.into(),
        (_, _, Some(Quantity::Object(object))) if get("refused").is_some() => match (get("refused"), get("abort")) {
            (Some(Quantity::Count(count)), Some(Quantity::Abort(abort))) => {
                Saying::Refused { count, object, abort }.into()
            }
            _ => return None,
        },
        (ProblemKind::PdoLength, ..) => Saying::OfPdo { pdo: one.subject.pdo? }.into(),
        _ => return None,
    })
}

/// Returns true for requests that a Stopped node does not serve.
fn is_to_stopped(one: &Problem) -> bool {
    one.findings.first().is_some_and(|cited| cited.code == Code::Sdo011)
}

/// Returns true if the line names the kind by itself; otherwise the words of the kind precede it.
pub fn is_whole(one: &Problem, began_ns: Option<i64>) -> bool {
    if one.begin.t_ns.is_none() || one.begin.t_ns < began_ns {
        return !matches!(one.kind, ProblemKind::PdoLength | ProblemKind::PdoNotAllowed);
    }
    match one.kind {
        ProblemKind::PdoLength | ProblemKind::PdoNotAllowed | ProblemKind::CaptureGap => {
            one.kind == ProblemKind::CaptureGap || !one.clue.reported.is_empty()
        }
        ProblemKind::RequestUnanswered if is_to_stopped(one) => false,
        ProblemKind::DuplicateNodeId => one.has("answers") || one.has("equal_answers"),
        ProblemKind::NotEnabled => one.has("statusword"),
        ProblemKind::SharedCobId => one.has("alternates"),
        ProblemKind::WatchedAbsent => one.has("limit"),
        ProblemKind::NotStarted | ProblemKind::LateAnswer => of(one, began_ns).is_some(),
        ProblemKind::Flood
        | ProblemKind::MuteAfterBoot
        | ProblemKind::ResetAgain
        | ProblemKind::AnotherDevice
        | ProblemKind::HeartbeatSwitchedOff
        | ProblemKind::AnswerElsewhere
        | ProblemKind::ReadInVain
        | ProblemKind::RpdoStopped
        | ProblemKind::NotTaken => true,
        ProblemKind::NodeSilent
        | ProblemKind::HeartbeatStopped
        | ProblemKind::SegmentLost
        | ProblemKind::NodeRestarted
        | ProblemKind::RestartLoop
        | ProblemKind::NodeAbsent
        | ProblemKind::NoBootUp
        | ProblemKind::LeftOperational
        | ProblemKind::StartWithoutEffect
        | ProblemKind::CommandedReset
        | ProblemKind::CommandedStop
        | ProblemKind::ConsumerTimeTooShort
        | ProblemKind::AxisFault
        | ProblemKind::RequestUnanswered
        | ProblemKind::BusSilent
        | ProblemKind::SyncStopped
        | ProblemKind::PdoMissing => one.repeats.count == 1 || one.kind != ProblemKind::RequestUnanswered,
        _ => !one.clue.reported.is_empty() || one.has("refused") || one.has("client_aborted"),
    }
}

//! What caused what: the rules of cause, each with its number in the table of `diagnosis.md`'s order (L1 to L28).
//!
//! A rule looks at two incidents of one bus and what was known at their begin. It must not look at frames, and it never
//! makes a cycle. A consequence has one cause; others are kept as possible.

use super::incident::{Grade, Incident, Link, Status, bit};
use super::kinds::Kind;
use super::ledger::{Ledger, Place};
use super::trackers::emcy::{LIFE_GUARD, RPDO_TIMEOUT};
use crate::finding::Quantity;
use crate::frame::BusId;

/// A cause may be noticed so long after its consequence, in ns; and a consequence come so long after its cause is over.
pub(super) const WINDOW_NS: i64 = 3_000_000_000;
/// A reaction follows within this time, in ns.
const PROMPT_NS: i64 = 500_000_000;
/// How late a consumer may report a loss beyond its time, in ns; and as a part of its time.
const LATE_NS: i64 = 50_000_000;
/// Periods of SYNC within which its consumers report that it is gone.
const SYNCS: i64 = 30;

/// What a rule says: its number, how sure it is, and how far the delay is from the expected one, in ns.
type Found = (u8, Grade, i64);

/// Links an incident that has just begun with those before it, and those of the last seconds with it.
pub(super) fn link(ledger: &mut Ledger, place: Place, bus: BusId) {
    let recent = ledger.recent(bus);
    if let Some(link) = best(ledger, place, &recent) {
        set(ledger, place, link);
    }
    let Some(new) = ledger.get(place).cloned() else { return };
    for other in recent {
        let Some(one) = ledger.get(other) else { continue };
        let late = new.noticed.since(one.noticed).is_none_or(|since| since.abs() <= WINDOW_NS);
        if other == place || !late || one.cause.is_some_and(|link| link.grade == Grade::Certain) {
            continue;
        }
        if let Some(link) = best(ledger, other, &[place]) {
            set(ledger, other, link);
        }
    }
}

fn set(ledger: &mut Ledger, place: Place, link: Link) {
    if let Some(one) = ledger.get_mut(place) {
        one.link(link);
    }
}

/// The best cause of an incident among others.
fn best(ledger: &Ledger, place: Place, others: &[Place]) -> Option<Link> {
    let effect = ledger.get(place)?;
    let mut found: Option<(Found, &Incident)> = None;
    for other in others.iter().filter(|other| **other != place) {
        let Some(cause) = ledger.get(*other) else { continue };
        if !touches(cause, effect) || ledger.comes_from(cause.id, effect.id) {
            continue;
        }
        let Some(one) = relate(cause, effect, ledger) else { continue };
        let better = found.is_none_or(|(before, incident)| {
            (one.1, -one.2, std::cmp::Reverse(cause.begin.no))
                > (before.1, -before.2, std::cmp::Reverse(incident.begin.no))
        });
        if better {
            found = Some((one, cause));
        }
    }
    let ((rule, grade, _), cause) = found?;
    Some(Link { cause: cause.id, rule, grade, delay_ns: effect.begin.since(cause.begin) })
}

/// Whether one was there, or had just been, when the other began.
fn touches(cause: &Incident, effect: &Incident) -> bool {
    if let Some(frame) = effect.clue.because_of
        && cause.holds(frame)
    {
        return true;
    }
    let before = effect.noticed.since(cause.begin).is_none_or(|since| since >= -LATE_NS);
    let after = cause.end.is_none_or(|end| effect.begin.since(end).is_none_or(|since| since <= WINDOW_NS));
    before && after
}

fn is_gone(kind: Kind) -> bool {
    use Kind::{GuardingUnanswered, NoBootUp, NodeAbsent, NodeRestarted, NodeSilent, RestartLoop, SegmentLost};
    matches!(kind, NodeSilent | SegmentLost | NodeRestarted | RestartLoop | NoBootUp | GuardingUnanswered | NodeAbsent)
}

fn is_commanded(kind: Kind) -> bool {
    matches!(kind, Kind::CommandedReset | Kind::CommandedStop)
}

fn is_bus(kind: Kind) -> bool {
    matches!(kind, Kind::BusOff | Kind::ErrorPassive | Kind::BusErrors | Kind::TransceiverFault)
}

/// Errors of communication that a lost SYNC may raise: generic ones, and those of the makers beside.
fn may_be_sync(code: u16) -> bool {
    matches!(code, 0x8100 | 0x8180..=0x81FF | 0x8200 | 0x8700 | 0xFF00..)
}

/// Whether one caused the other.
fn relate(cause: &Incident, effect: &Incident, ledger: &Ledger) -> Option<Found> {
    let delay = effect.begin.since(cause.begin).unwrap_or(0);
    let same_node = effect.subject.node.is_some_and(|node| cause.subject.concerns(node));
    let reported = |code: u16| effect.clue.reported.contains(&code);
    if let Some(frame) = effect.clue.because_of
        && cause.holds(frame)
        && (cause.subject.node != effect.subject.node || cause.kind != effect.kind)
    {
        return Some((0, Grade::Certain, 0));
    }
    if reported(LIFE_GUARD)
        && effect.kind != Kind::ConsumerTimeTooShort
        && let Some(found) = loss(cause, effect, delay)
    {
        return Some(found);
    }
    if reported(RPDO_TIMEOUT) || effect.kind == Kind::RpdoTimeout {
        let stops = is_gone(cause.kind)
            || is_commanded(cause.kind)
            || !cause.clue.reported.is_empty()
            || matches!(
                cause.kind,
                Kind::LeftOperational | Kind::AxisFault | Kind::PdoMissing | Kind::HeartbeatStopped
            );
        let source = cause.subject.nodes & effect.clue.sources != 0;
        if stops && source && cause.subject.node != effect.subject.node {
            return Some((5, Grade::Certain, delay.abs()));
        }
        if stops && effect.clue.sources == 0 && cause.subject.node != effect.subject.node && delay >= 0 {
            return Some((5, Grade::Possible, delay));
        }
    }
    if let Some(found) = sync(cause, effect) {
        return Some(found);
    }
    if same_node && cause.kind == Kind::DuplicateNodeId && delay >= -LATE_NS {
        return Some((20, Grade::Likely, delay));
    }
    // Who could not be heard could not hear, either.
    let of_bus = effect.clue.reported.iter().any(|code| (0x8100..=0x82FF).contains(code));
    if same_node && of_bus && matches!(cause.kind, Kind::NodeSilent | Kind::SegmentLost) && delay >= 0 {
        return Some((7, Grade::Likely, delay));
    }
    let commanded = is_commanded(cause.kind) && delay >= -LATE_NS;
    match effect.kind {
        Kind::RequestUnanswered | Kind::LateAnswer | Kind::DamagedTransfer if same_node => {
            let gone = is_gone(cause.kind) || commanded;
            // Before the node was lost it could have answered.
            gone.then_some((11, Grade::Certain, delay.abs()))
        }
        Kind::NodeSilent if same_node && cause.kind == Kind::RestartLoop => Some((12, Grade::Likely, delay)),
        Kind::NodeAbsent if same_node => is_gone(cause.kind).then_some((11, Grade::Likely, delay.abs())),
        Kind::AxisFault | Kind::QuickStop | Kind::StateLeft if same_node && commanded && delay <= 2 * PROMPT_NS => {
            Some((15, Grade::Certain, delay))
        }
        Kind::AxisFault | Kind::QuickStop => {
            let limit =
                effect.clue.watched.iter().find(|(node, _)| cause.subject.concerns(*node)).map(|(_, limit)| *limit);
            let watched = is_gone(cause.kind)
                && limit.is_some_and(|limit| (limit..=limit + limit / 3 + PROMPT_NS).contains(&delay));
            watched.then_some((7, Grade::Likely, delay))
        }
        Kind::PdoMissing | Kind::SyncStopped | Kind::SyncIrregular if same_node => {
            let gone = is_gone(cause.kind) || cause.kind == Kind::LeftOperational || commanded;
            gone.then_some((if commanded { 15 } else { 5 }, Grade::Certain, delay.abs()))
        }
        Kind::PdoLength | Kind::PdoNotAllowed if same_node && cause.kind.row().name.ends_with("refused") => {
            let same = effect.subject.pdo.is_none() || effect.subject.pdo == cause.subject.pdo;
            same.then_some((13, Grade::Likely, delay))
        }
        Kind::PdoLength | Kind::PdoNotAllowed | Kind::StartWithoutEffect | Kind::DeviceError
            if same_node && matches!(cause.kind, Kind::NodeRestarted | Kind::RestartLoop | Kind::NodeSilent) =>
        {
            Some((12, Grade::Likely, delay))
        }
        Kind::StartWithoutEffect if same_node && !cause.clue.codes.is_empty() => Some((4, Grade::Likely, delay)),
        Kind::LeftOperational if same_node && !cause.clue.reported.is_empty() => Some((4, Grade::Likely, delay)),
        Kind::FaultResetWithoutEffect | Kind::NotEnabled if same_node && !cause.clue.codes.is_empty() => {
            Some((22, Grade::Likely, delay))
        }
        Kind::NotEnabled if same_node && (is_gone(cause.kind) || commanded) => Some((27, Grade::Likely, delay)),
        Kind::NodeSilent | Kind::HeartbeatIrregular | Kind::SyncIrregular | Kind::PdoMissing if is_bus(cause.kind) => {
            let many = cause.kind == Kind::BusOff || cause.repeats.count >= 3;
            Some((10, if many { Grade::Likely } else { Grade::Possible }, delay.abs()))
        }
        Kind::BusTrouble if is_bus(cause.kind) => Some((21, Grade::Likely, delay.abs())),
        _ if cause.kind == Kind::CaptureGap && over(cause, effect) && ledger.by_id(cause.id).is_some() => {
            Some((26, Grade::Certain, delay.abs()))
        }
        _ => None,
    }
}

/// Whether something that rests on times began in a gap of the recording.
fn over(gap: &Incident, effect: &Incident) -> bool {
    let timed = matches!(
        effect.kind,
        Kind::NodeSilent | Kind::HeartbeatIrregular | Kind::SyncIrregular | Kind::SyncStopped | Kind::PdoMissing
    );
    timed && gap.begin.no >= effect.begin.no && gap.begin.no <= effect.noticed.no
}

/// L1, L2, L3: a heartbeat consumer has reported the loss of a node.
fn loss(cause: &Incident, effect: &Incident, delay: i64) -> Option<Found> {
    if cause.subject.node == effect.subject.node && cause.kind != Kind::GuardingStopped {
        return None;
    }
    let rule = match cause.kind {
        kind if is_gone(kind) || kind == Kind::HeartbeatStopped => 1,
        Kind::GuardingStopped => 2,
        kind if is_commanded(kind) => 3,
        _ => return None,
    };
    let watched = effect.clue.watched.iter().find(|(node, _)| cause.subject.concerns(*node));
    match watched {
        Some((_, limit)) => {
            // A silence begins with the last frame, the consumer's time with the last heartbeat before it.
            let least = limit - limit / 3 - LATE_NS;
            let apart = if cause.kind == Kind::SegmentLost { period(cause) } else { 0 };
            let most = limit.saturating_add(LATE_NS.max(limit / 3)).saturating_add(apart);
            let fits = (least.min(0)..=most).contains(&delay) || rule == 3;
            // Some stacks look at their times now and then only.
            let soon = delay > most && delay <= most.saturating_add(limit.saturating_add(PROMPT_NS));
            let grade = if fits {
                Grade::Certain
            } else if soon {
                Grade::Likely
            } else {
                Grade::Possible
            };
            Some((rule, grade, (delay - limit).abs()))
        }
        None if effect.clue.watched.is_empty() && (0..=WINDOW_NS).contains(&delay) => {
            Some((rule, Grade::Likely, delay))
        }
        None => None,
    }
}

/// How often the subject of an incident sent heartbeats, in ns; 0 where that is not known.
fn period(one: &Incident) -> i64 {
    let found = one.facts.iter().find_map(|(name, value)| match value {
        Quantity::Ns(ns) if *name == "period" => Some(*ns),
        _ => None,
    });
    found.unwrap_or(0)
}

/// L6: SYNC is gone with its producer, and its consumers say so.
fn sync(cause: &Incident, effect: &Incident) -> Option<Found> {
    let stopped = cause.clue.sync_producer || cause.kind == Kind::SyncStopped;
    let (last, period) =
        if cause.clue.sync_producer { cause.clue.sync? } else { effect.clue.sync.or(cause.clue.sync)? };
    let since = effect.begin.since(last)?;
    if effect.kind == Kind::SyncStopped && is_gone(cause.kind) {
        let near = effect.begin.since(cause.begin)?.abs() <= period.saturating_mul(2).max(self::period(cause));
        let grade = if cause.clue.sync_producer { Grade::Certain } else { Grade::Likely };
        return near.then_some((6, grade, 0));
    }
    let says = effect.clue.reported.iter().any(|code| may_be_sync(*code));
    let soon = (period / 2..=period.saturating_mul(SYNCS)).contains(&since);
    (stopped && says && soon && cause.subject.node != effect.subject.node).then_some((6, Grade::Likely, since))
}

/// Consequences of one cause that begin within this time of each other, in ns, are one where they are of one kind.
const TOGETHER_NS: i64 = 100_000_000;

/// The capture is over: what happened to several nodes alike, by one cause, is one incident; so is a SYNC that stops with
/// its producer, and the loss of that.
pub(super) fn join(ledger: &mut Ledger) {
    for place in 0..ledger.all.len() {
        let Some(one) = ledger.get(place) else { continue };
        let Some(link) = one.cause.filter(|link| link.grade >= Grade::Likely) else { continue };
        let into = match one.kind {
            Kind::SyncStopped if link.rule == 6 && link.grade == Grade::Certain => Some(place_of(link)),
            _ => (0..place).find(|other| ledger.get(*other).is_some_and(|other| is_alike(other, one, link))),
        };
        if let Some(into) = into {
            ledger.merge(place, into);
        }
    }
}

fn place_of(link: Link) -> Place {
    (link.cause.0 as usize).saturating_sub(1)
}

/// Whether the same happened to another node at the same time, by the same cause.
fn is_alike(other: &Incident, one: &Incident, link: Link) -> bool {
    let near = one.begin.since(other.begin).is_some_and(|since| since.abs() <= TOGETHER_NS);
    let same = other.kind == one.kind && other.bus == one.bus && other.status == one.status && !other.merged;
    let subject = one.subject.node.is_some() && one.subject.pdo.is_none() && one.subject.axis == other.subject.axis;
    same && near
        && subject
        && other.clue.reported == one.clue.reported
        && other.cause.is_some_and(|cause| cause.cause == link.cause)
}

/// The capture is over: what only follows from what is harmless is harmless, too.
pub(super) fn settle(ledger: &mut Ledger) {
    for place in 0..ledger.all.len() {
        let Some(one) = ledger.get(place) else { continue };
        let Some(link) = one.cause.filter(|link| link.grade == Grade::Certain) else { continue };
        let harmless = ledger.by_id(link.cause).is_some_and(|cause| cause.status == Status::Harmless);
        if harmless
            && one.status == Status::Over
            && let Some(one) = ledger.get_mut(place)
        {
            one.status = Status::Harmless;
        }
    }
    // A cause that is not told cannot be named.
    let told: Vec<bool> = ledger.all.iter().map(Incident::counts).collect();
    for one in &mut ledger.all {
        let is_told = |link: &Link| told.get((link.cause.0 as usize).wrapping_sub(1)).copied().unwrap_or(false);
        one.cause = one.cause.filter(is_told);
        one.possible.retain(is_told);
    }
}

/// All nodes of a story: of an incident and of all that follows from it.
pub(super) fn spread(ledger: &Ledger, root: &Incident) -> u32 {
    let parts = ledger.told().filter(|one| ledger.comes_from(one.id, root.id));
    parts.fold(0, |nodes, one| nodes | one.subject.nodes | one.subject.node.map_or(0, bit)).count_ones()
}

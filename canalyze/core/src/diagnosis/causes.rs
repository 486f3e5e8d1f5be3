//! What can have caused what: one rule of cause a row, first match first.
//!
//! A rule looks at two incidents of one bus and at what was known at their begin. Its number is the one that `cause` has in
//! machine output (L1 to L28); L0 is what a finding says of itself. Must not: look at frames, or choose between causes.

use std::ops::RangeInclusive;

use super::incident::{Grade, Incident};
use super::kinds::Kind::{self, *};
use super::trackers::emcy::{LIFE_GUARD, RPDO_TIMEOUT};
use crate::finding::{Code, Quantity};

/// A cause may be noticed so long after its consequence, in ns; and a consequence come so long after its cause is over.
pub(super) const WINDOW_NS: i64 = 3_000_000_000;
/// How late a consumer may report a loss beyond its time, in ns.
pub(super) const LATE_NS: i64 = 50_000_000;
/// A reaction follows within this time, in ns.
const PROMPT_NS: i64 = 500_000_000;
/// A supply that dips takes other nodes with it within this time, in ns.
const SUPPLY_NS: i64 = 200_000_000;
/// Periods of a heartbeat for which a consumer waits at most, where its time is not known.
const PERIODS: i64 = 5;
/// Periods of SYNC within which its consumers report that it is gone.
const SYNCS: i64 = 30;

/// What a rule says: its number, how sure it is, and how far the delay is from the expected one, in ns.
pub(super) type Found = (u8, Grade, i64);

/// Two incidents of one bus.
struct Pair<'a> {
    cause: &'a Incident,
    effect: &'a Incident,
    /// From the begin of one to that of the other, in ns; 0 without stamps.
    delay: i64,
    /// The cause concerns the node to which the effect happened.
    same_node: bool,
}

/// A rule: its number, and how sure it is that one of the pair caused the other, with how far the delay is from the
/// expected one, in ns.
type Rule = (u8, fn(&Pair<'_>) -> Option<(Grade, i64)>);

/// The rules.
const RULES: &[Rule] = &[
    (0, said_by_the_finding),
    (1, loss_reported),
    (2, guarding_stopped),
    (3, commanded_reset_reported),
    (5, rpdo_without_source),
    (6, sync_gone),
    (20, second_node),
    (7, could_hear_nobody),
    (17, busy_storing),
    (16, bus_full),
    (15, contradicted),
    (18, supply_dipped),
    (11, nobody_to_answer),
    (11, transfer_ended),
    (12, configuration_lost),
    (15, commanded),
    (7, communication_lost),
    (5, node_not_operational),
    (13, configured_wrongly),
    (14, boot_cut_short),
    (4, error_before),
    (23, no_edge),
    (8, announced),
    (22, cause_stands),
    (27, not_listening),
    (10, bus_errors),
    (21, bus_errors_reported),
    (26, recording_stood_still),
];

/// Whether one incident caused the other.
pub(super) fn relate(cause: &Incident, effect: &Incident) -> Option<Found> {
    let delay = effect.begin.since(cause.begin).unwrap_or(0);
    let same_node = effect.subject.node.is_some_and(|node| cause.subject.concerns(node));
    // Where stamps do not tell, the order does: what began after its effect was seen has not caused it.
    if delay == 0 && cause.begin.no > effect.noticed.no {
        return None;
    }
    let pair = Pair { cause, effect, delay, same_node };
    RULES.iter().find_map(|(number, rule)| rule(&pair).map(|(grade, far)| (*number, grade, far)))
}

impl Pair<'_> {
    /// The node of the effect has reported this error code in it.
    fn reported(&self, code: u16) -> bool {
        self.effect.clue.reported.contains(&code)
    }

    /// Both happened to one and the same node alone.
    fn alone(&self) -> bool {
        self.cause.subject.node.is_some() && self.cause.subject.node == self.effect.subject.node
    }

    /// The cause was there when what is missing since was there last. What has come again since had another end; but
    /// that it is not steady at once is no other trouble.
    fn lasted(&self) -> bool {
        let unsteady = self.effect.kind == SyncIrregular;
        unsteady || self.cause.end.is_none_or(|end| self.effect.begin.no <= end.no)
    }

    /// The cause is a command, and came first.
    fn commanded(&self) -> bool {
        is_commanded(self.cause.kind) && self.delay >= -LATE_NS
    }

    /// The time that the effect's node waits for the heartbeat of the cause's, in ns.
    fn limit(&self) -> Option<i64> {
        let watched = self.effect.clue.watched.iter().find(|(node, _)| self.cause.subject.concerns(*node));
        watched.map(|(_, limit)| *limit)
    }
}

fn is_gone(kind: Kind) -> bool {
    matches!(kind, NodeSilent | SegmentLost | NodeRestarted | RestartLoop | NoBootUp | GuardingUnanswered | NodeAbsent)
}

fn is_commanded(kind: Kind) -> bool {
    matches!(kind, CommandedReset | CommandedStop)
}

fn is_bus(kind: Kind) -> bool {
    matches!(kind, BusOff | ErrorPassive | BusErrors | TransceiverFault)
}

/// A node that is busy, or a bus that is full, makes this.
fn is_late(kind: Kind) -> bool {
    matches!(
        kind,
        NodeSilent
            | HeartbeatStopped
            | HeartbeatIrregular
            | RequestUnanswered
            | LateAnswer
            | PdoMissing
            | InhibitTime
            | SyncIrregular
            | TargetsLate
            | Overrun
    )
}

/// Errors of communication that a lost SYNC may raise: generic ones, and those of the makers beside.
fn may_be_sync(code: u16) -> bool {
    matches!(code, 0x8100 | 0x8180..=0x81FF | 0x8200 | 0x8700 | 0xFF00..)
}

fn said_by_the_finding(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    let frame = pair.effect.clue.because_of?;
    let other = !pair.alone() || pair.cause.kind != pair.effect.kind;
    (pair.cause.holds(frame) && other).then_some((Grade::Certain, 0))
}

/// L1: a heartbeat consumer has reported the loss of a node.
fn loss_reported(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    let kind = pair.cause.kind;
    (is_gone(kind) || kind == HeartbeatStopped).then(|| loss(pair))?
}

/// L2: the master has stopped guarding.
fn guarding_stopped(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    (pair.cause.kind == GuardingStopped).then(|| loss(pair))?
}

/// L3: the node that is watched was reset by command.
fn commanded_reset_reported(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    is_commanded(pair.cause.kind).then(|| loss(pair))?
}

fn loss(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    let Pair { cause, effect, delay, .. } = *pair;
    let says = pair.reported(LIFE_GUARD);
    if !says && !effect.clue.communication
        || effect.kind == ConsumerTimeTooShort
        || pair.alone() && cause.kind != GuardingStopped
    {
        return None;
    }
    let Some(limit) = pair.limit() else {
        // Who waits for a heartbeat waits for some periods of it.
        let period = cause.ns("period").unwrap_or(0);
        let least = if says { 0 } else { period };
        let most = if says { WINDOW_NS.max(period.saturating_mul(PERIODS)) } else { period.saturating_mul(PERIODS) };
        // Or it was this emergency by which the silence was noticed.
        let shows = says && cause.noticed.no == effect.begin.no;
        let any = effect.clue.watched.is_empty() && (shows || (least..=most).contains(&delay));
        return any.then_some((Grade::Likely, delay.saturating_sub(period.saturating_mul(2)).saturating_abs()));
    };
    let within = within(cause, limit);
    // A boot-up tells the consumer at once.
    let booted = matches!(cause.kind, NodeRestarted | RestartLoop) && effect.begin.no >= cause.noticed.no;
    // Some stacks look at their times now and then only.
    let late = within.end().saturating_add(limit.saturating_add(PROMPT_NS));
    let grade = if within.contains(&delay) || is_commanded(cause.kind) || booted && delay <= *within.end() {
        Grade::Certain
    } else if delay <= late {
        Grade::Likely
    } else {
        Grade::Possible
    };
    Some((grade, delay.saturating_sub(limit).saturating_abs()))
}

/// How long after the begin of an incident a consumer that waits for `limit` ns reports it, in ns. A silence begins with the
/// last frame, the consumer's time with the last heartbeat before it.
pub(super) fn within(cause: &Incident, limit: i64) -> RangeInclusive<i64> {
    let period = cause.ns("period").unwrap_or(limit / 3);
    let apart = if cause.kind == SegmentLost { period } else { 0 };
    limit.saturating_sub(period).saturating_sub(LATE_NS)
        ..=limit.saturating_add(LATE_NS.max(limit / 3)).saturating_add(apart)
}

/// L5: who should send the PDO that is missing does not.
fn rpdo_without_source(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    let Pair { cause, effect, delay, .. } = *pair;
    let waits = pair.reported(RPDO_TIMEOUT) || effect.kind == RpdoTimeout;
    let stops = is_gone(cause.kind)
        || is_commanded(cause.kind)
        || !cause.clue.reported.is_empty()
        || matches!(cause.kind, LeftOperational | AxisFault | PdoMissing | HeartbeatStopped);
    if !waits || !stops || pair.alone() {
        return None;
    }
    let source = cause.subject.nodes & effect.clue.sources != 0;
    if source {
        return Some((Grade::Certain, delay.saturating_abs()));
    }
    // Whose PDOs stopped as long ago as the node waits; and who only controls sends the RPDOs that nobody has as a TPDO.
    let suspect = cause.subject.nodes & effect.clue.suspects != 0 || effect.clue.suspects == 0 && cause.clue.controller;
    let gone = is_gone(cause.kind) || is_commanded(cause.kind) || cause.kind == LeftOperational;
    let soon = (0..=WINDOW_NS).contains(&delay) && effect.clue.suspects == 0 && gone;
    let grade = if suspect || soon { Grade::Likely } else { Grade::Possible };
    (suspect || effect.clue.sources == 0 && delay >= 0).then_some((grade, delay.saturating_abs()))
}

/// L6: SYNC is gone with its producer, and its consumers say so.
fn sync_gone(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    let Pair { cause, effect, .. } = *pair;
    let stopped = cause.clue.sync_producer || cause.kind == SyncStopped;
    let (last, period) =
        if cause.clue.sync_producer { cause.clue.sync? } else { effect.clue.sync.or(cause.clue.sync)? };
    let since = effect.begin.since(last)?;
    if effect.kind == SyncStopped && is_gone(cause.kind) {
        let most = period.saturating_mul(2).max(cause.ns("period").unwrap_or(0));
        let near = effect.begin.since(cause.begin)?.saturating_abs() <= most;
        let grade = if cause.clue.sync_producer { Grade::Certain } else { Grade::Likely };
        return near.then_some((grade, 0));
    }
    let says = effect.clue.reported.iter().any(|code| may_be_sync(*code))
        || effect.clue.reported.is_empty() && matches!(effect.kind, AxisFault | QuickStop | StateLeft);
    let soon = (period / 2..=period.saturating_mul(SYNCS)).contains(&since);
    (stopped && says && soon && cause.subject.node != effect.subject.node).then_some((Grade::Likely, since))
}

/// L20: two nodes have one node-ID.
fn second_node(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    let second = pair.same_node && pair.cause.kind == DuplicateNodeId && pair.delay >= -LATE_NS;
    second.then_some((Grade::Likely, pair.delay))
}

/// L7: who could not be heard could not hear, either.
fn could_hear_nobody(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    let of_bus = pair.effect.clue.reported.iter().any(|code| (0x8100..=0x82FF).contains(code));
    let lost = matches!(pair.cause.kind, NodeSilent | SegmentLost);
    let stops = pair.effect.clue.reported.is_empty() && matches!(pair.effect.kind, AxisFault | QuickStop | StateLeft);
    (pair.same_node && (of_bus || stops) && lost && pair.delay >= 0).then_some((Grade::Likely, pair.delay))
}

/// L17: a node stores parameters or a program, and has no time for anything else.
fn busy_storing(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    let busy = is_late(pair.effect.kind) || pair.effect.kind == NodeRestarted;
    (pair.same_node && pair.cause.kind == Storing && busy).then_some((Grade::Certain, pair.delay))
}

/// L16: more frames than the bus can carry, or one identifier that comes before all others.
fn bus_full(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    match (pair.cause.kind, pair.effect.kind) {
        (Flood, Overload) => Some((Grade::Certain, pair.delay.saturating_abs())),
        // The last sign of who cannot be heard is older than what keeps it from being heard.
        (Flood | Overload, kind) => {
            let began = pair.effect.noticed.since(pair.cause.begin).unwrap_or(0) >= 0;
            let period = pair.effect.ns("period").unwrap_or(0);
            (is_late(kind) && began && pair.delay >= (-period).saturating_sub(LATE_NS))
                .then_some((Grade::Likely, pair.delay.saturating_abs()))
        }
        _ => None,
    }
}

/// L15: two masters contradict each other.
fn contradicted(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    let follows = is_commanded(pair.effect.kind) || is_late(pair.effect.kind) || pair.effect.kind == StartWithoutEffect;
    (pair.cause.kind == TwoMasters && follows).then_some((Grade::Likely, pair.delay.saturating_abs()))
}

/// L18: a supply that dips takes others with it.
fn supply_dipped(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    let falls = matches!(pair.effect.kind, NodeRestarted | NodeSilent) && !pair.same_node;
    let soon = (0..=SUPPLY_NS).contains(&pair.effect.noticed.since(pair.cause.begin).unwrap_or(-1));
    (pair.cause.kind == SupplyVoltage && falls && soon).then_some((Grade::Likely, pair.delay))
}

/// L11: a node that is gone answers nothing.
fn nobody_to_answer(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    let gone = is_gone(pair.cause.kind);
    match pair.effect.kind {
        RequestUnanswered | LateAnswer | DamagedTransfer if pair.same_node => {
            // A node that is Pre-operational answers, one that is Stopped or boots does not.
            let mute = pair.commanded() && pair.cause.get("command") != Some(Quantity::Command(0x80));
            (gone || mute).then_some((Grade::Certain, pair.delay.saturating_abs()))
        }
        NodeAbsent if pair.same_node => gone.then_some((Grade::Likely, pair.delay.saturating_abs())),
        _ => None,
    }
}

/// L11: frames of a transfer that the server has refused were under way.
fn transfer_ended(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    let soon = (0..=PROMPT_NS).contains(&pair.delay) && pair.alone();
    let left_over = pair.effect.findings.iter().all(|cited| cited.code == Code::Sdo007);
    let refused = pair.cause.has("refused") && pair.effect.kind == DamagedTransfer && left_over;
    (soon && refused).then_some((Grade::Likely, pair.delay))
}

/// L12: a node that has booted has lost what it was told before.
fn configuration_lost(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    if !pair.same_node {
        return None;
    }
    match pair.effect.kind {
        NodeSilent => (pair.cause.kind == RestartLoop).then_some((Grade::Likely, pair.delay)),
        PdoLength | PdoNotAllowed | StartWithoutEffect | DeviceError => {
            let booted = matches!(pair.cause.kind, NodeRestarted | RestartLoop | NodeSilent);
            booted.then_some((Grade::Likely, pair.delay))
        }
        _ => None,
    }
}

/// L15: a node was stopped or reset by command.
fn commanded(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    if !pair.same_node || !pair.commanded() {
        return None;
    }
    match pair.effect.kind {
        AxisFault | QuickStop | StateLeft => (pair.delay <= 2 * PROMPT_NS).then_some((Grade::Certain, pair.delay)),
        PdoMissing | SyncStopped | SyncIrregular if pair.lasted() => {
            Some((Grade::Certain, pair.delay.saturating_abs()))
        }
        _ => None,
    }
}

/// L7: a drive stops because it has lost whom it watches, as it says itself, or as the times tell.
fn communication_lost(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    let stops = matches!(pair.effect.kind, AxisFault | QuickStop | StateLeft) && is_gone(pair.cause.kind);
    let says = pair.alone() && pair.cause.clue.reported.iter().any(|code| (0x8100..=0x82FF).contains(code));
    if matches!(pair.effect.kind, QuickStop | StateLeft) && says && (-LATE_NS..=PROMPT_NS).contains(&pair.delay) {
        return Some((Grade::Certain, pair.delay.saturating_abs()));
    }
    let limit = pair.limit().filter(|_| stops)?;
    (limit..=limit + limit / 3 + PROMPT_NS).contains(&pair.delay).then_some((Grade::Likely, pair.delay))
}

/// L5: a node that is gone, or is not Operational, sends no PDO.
fn node_not_operational(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    let missing = matches!(pair.effect.kind, PdoMissing | SyncStopped | SyncIrregular);
    let stops = is_gone(pair.cause.kind) || pair.cause.kind == LeftOperational;
    (pair.same_node && missing && stops && pair.lasted()).then_some((Grade::Certain, pair.delay.saturating_abs()))
}

/// L13: a PDO that could not be configured is another one than was wanted.
fn configured_wrongly(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    let other = matches!(pair.effect.kind, PdoLength | PdoNotAllowed | PdoMissing);
    // A consumer says that a PDO is too long or too short: of those that it takes, one was not configured.
    let taken = pair.effect.kind == PdoLength && pair.effect.clue.sources & pair.cause.subject.nodes != 0;
    // Where it is not known what it takes, it is that of which the mapping was refused.
    let unknown = pair.effect.clue.sources == 0 && pair.cause.subject.pdo.is_some_and(|(transmit, _)| transmit);
    let taken = taken || pair.effect.kind == PdoLength && unknown && !pair.effect.clue.reported.is_empty();
    if taken && (pair.cause.has("refused") || pair.cause.kind == PdoLength) && !pair.alone() && pair.delay >= 0 {
        return Some((Grade::Likely, pair.delay));
    }
    let pdo = pair.effect.subject.pdo;
    let same = pdo.is_none() || pdo == pair.cause.subject.pdo;
    (pair.same_node && other && same && pair.cause.has("refused")).then_some((Grade::Likely, pair.delay))
}

/// L14: a master that got no answer, or a refusal, does not start the node.
fn boot_cut_short(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    let waits = matches!(pair.effect.kind, NotStarted | BootStuck)
        || pair.effect.kind == StartWithoutEffect && pair.cause.kind == ProgramFailed;
    let cut = pair.cause.has("refused") || matches!(pair.cause.kind, RequestUnanswered | IdentityMismatch);
    (pair.same_node && waits && cut).then_some((Grade::Likely, pair.delay.saturating_abs()))
}

/// L4: a node with an error leaves Operational, or does not reach it (1029h).
fn error_before(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    let Pair { cause, effect, delay, .. } = *pair;
    let errs = match effect.kind {
        StartWithoutEffect => !cause.clue.codes.is_empty(),
        LeftOperational => !cause.clue.reported.is_empty(),
        _ => false,
    };
    (pair.same_node && errs).then_some((Grade::Likely, delay))
}

/// L23: a fault reset is an edge.
fn no_edge(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    let held = pair.effect.kind == FaultResetWithoutEdge && pair.cause.kind == AxisFault;
    (pair.same_node && held).then_some((Grade::Certain, pair.delay))
}

/// L8: what a device reports before its axis faults, and what makes an axis lag.
fn announced(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    if !pair.same_node {
        return None;
    }
    match (pair.cause.kind, pair.effect.kind) {
        (FollowingError | Temperature | SupplyVoltage, AxisFault) => Some((Grade::Likely, pair.delay)),
        (SyncIrregular | TargetsLate, FollowingError | InternalLimit) => Some((Grade::Possible, pair.delay)),
        _ => None,
    }
}

/// L22: what caused the fault is still there.
fn cause_stands(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    let stays = matches!(pair.effect.kind, FaultResetWithoutEffect | NotEnabled) && !pair.cause.clue.codes.is_empty();
    (pair.same_node && stays).then_some((Grade::Likely, pair.delay))
}

/// L27: a node that is not Operational takes no RPDO.
fn not_listening(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    let out = is_gone(pair.cause.kind)
        || pair.commanded()
        || matches!(pair.cause.kind, LeftOperational | NotStarted | BootStuck | StartWithoutEffect);
    match pair.effect.kind {
        CommandsNotTaken if pair.same_node => {
            let errs = pair.cause.has("left_operational") || !pair.cause.clue.reported.is_empty();
            let grade = if out { Grade::Certain } else { Grade::Likely };
            (out || errs).then_some((grade, pair.delay.saturating_abs()))
        }
        NotEnabled if pair.same_node && out => Some((Grade::Likely, pair.delay)),
        _ => None,
    }
}

/// L10: errors on the bus around what is lost or late.
fn bus_errors(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    let lost = matches!(pair.effect.kind, NodeSilent | HeartbeatIrregular | SyncIrregular | PdoMissing);
    if !lost || !is_bus(pair.cause.kind) {
        return None;
    }
    let many = pair.cause.kind == BusOff || pair.cause.repeats.count >= 3;
    Some((if many { Grade::Likely } else { Grade::Possible }, pair.delay.saturating_abs()))
}

/// L21: nodes report the errors that are seen on the bus.
fn bus_errors_reported(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    (pair.effect.kind == BusTrouble && is_bus(pair.cause.kind)).then_some((Grade::Likely, pair.delay.saturating_abs()))
}

/// L26: what rests on times and began in a gap of the recording.
fn recording_stood_still(pair: &Pair<'_>) -> Option<(Grade, i64)> {
    let Pair { cause, effect, .. } = *pair;
    let timed = matches!(effect.kind, NodeSilent | HeartbeatIrregular | SyncIrregular | SyncStopped | PdoMissing);
    let inside = cause.begin.no >= effect.begin.no && cause.begin.no <= effect.noticed.no;
    (cause.kind == CaptureGap && timed && inside).then_some((Grade::Certain, pair.delay.saturating_abs()))
}

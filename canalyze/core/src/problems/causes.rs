//! The rules of cause, one in each row; the first match applies.
//!
//! A rule compares two problems of one bus and the facts known at their beginning. Its number appears as `cause` in
//! machine output (L1 to L41); L0 is a cause that a finding names itself.

use std::ops::RangeInclusive;

use super::problem::{Grade, Problem, bit};
use super::roles::KindRole;
use super::trackers::emcy::{LIFE_GUARD, RPDO_TIMEOUT};
use crate::bytes::ns::Ns;
use crate::rules::finding::{Code, Quantity};

/// Maximum time by which a cause may be noticed after its consequence, and a consequence follow the end of its cause,
/// in ns.
pub(super) const WINDOW_NS: Ns = Ns::from_s(3);
/// Maximum delay of a consumer's report beyond its time, in ns.
pub(super) const LATE_NS: Ns = Ns::from_ms(50);
/// Maximum time until a reaction, in ns.
const PROMPT_NS: Ns = Ns::from_ms(500);
/// Maximum time in which a supply that dips takes other nodes with it, in ns.
const SUPPLY_NS: Ns = Ns::from_ms(200);
/// Maximum number of heartbeat periods for which a consumer waits, if its time is not known.
pub(super) const PERIODS: i64 = 5;
/// Producer heartbeat time (CiA 301, 7.5.2.19).
const PRODUCER_TIME: u16 = 0x1017;
/// The emergency of a drive whose control is not in step with SYNC.
const SYNC_CONTROLLER: u16 = 0x8700;
/// Number of SYNC periods within which consumers report its loss.
const SYNCS: i64 = 30;

/// The result of a rule: its number, its certainty, and the deviation of the delay from the expected one, in ns.
pub(super) type Found = (u8, Grade, Ns);

/// Two problems of one bus.
struct Pair<'a> {
    cause: &'a Problem,
    effect: &'a Problem,
    /// Time from the beginning of the cause to that of the effect, in ns; 0 without stamps.
    delay: Ns,
    /// True if the cause concerns the node of the effect.
    same_node: bool,
}

/// A rule: its number, and a function that returns the certainty and the deviation from the expected delay in ns.
type CauseRule = (u8, fn(&Pair<'_>) -> Option<(Grade, Ns)>);

/// The rules.
const RULES: &[CauseRule] = &[
    (0, said_by_the_finding),
    (1, loss_reported),
    (32, no_heartbeats),
    (2, guarding_stopped),
    (3, commanded_reset_reported),
    (40, rpdo_stopped),
    (5, rpdo_without_source),
    (6, sync_gone),
    (20, second_node),
    (7, could_hear_nobody),
    (17, busy_storing),
    (16, bus_full),
    (15, contradicted),
    (18, supply_dipped),
    (11, nobody_to_answer),
    (35, transfer_ended),
    (30, violation_refused),
    (31, length_reported),
    (12, configuration_lost),
    (15, commanded),
    (7, communication_lost),
    (33, node_not_operational),
    (13, configured_wrongly),
    (14, boot_cut_short),
    (34, boot_awaited),
    (4, error_before),
    (36, error_meanwhile),
    (37, sent_nothing),
    (39, restarted_meanwhile),
    (38, targets_with_sync),
    (41, unsteady_sync_reported),
    (23, no_edge),
    (8, announced),
    (22, cause_stands),
    (27, not_listening),
    (10, bus_errors),
    (21, bus_errors_reported),
    (26, recording_stood_still),
    (29, same_outage),
];

/// Applies the rules to a possible cause and its effect.
pub(super) fn relate(cause: &Problem, effect: &Problem) -> Option<Found> {
    // A cause that recurs may have caused it by its last time.
    let since = if cause.repeats.since.no <= effect.begin.no { cause.repeats.since } else { cause.begin };
    let delay = effect.begin.since(since).unwrap_or(Ns::ZERO);
    let same_node = effect.subject.node.is_some_and(|node| cause.subject.concerns(node));
    // Without usable stamps the order decides: a problem that began after the effect was noticed is not its cause.
    if delay == Ns::ZERO && cause.begin.no > effect.noticed.no {
        return None;
    }
    let pair = Pair { cause, effect, delay, same_node };
    RULES.iter().find_map(|(number, rule)| rule(&pair).map(|(grade, far)| (*number, grade, far)))
}

impl Pair<'_> {
    /// Returns true if the node of the effect has reported this error code in it.
    fn reported(&self, code: u16) -> bool {
        self.effect.clue.reported.contains(&code)
    }

    /// Returns true if both concern the same single node.
    fn alone(&self) -> bool {
        self.cause.subject.node.is_some() && self.cause.subject.node == self.effect.subject.node
    }

    /// Returns true if the cause concerns all nodes of the effect.
    fn within(&self) -> bool {
        let nodes = |one: &Problem| one.subject.nodes | one.subject.node.map_or(0, bit);
        nodes(self.effect) != 0 && nodes(self.effect) & !nodes(self.cause) == 0
    }

    /// Returns true if the cause lasted until the last sign before the effect began; an effect that ended in between
    /// had another cause. A SYNC that is still irregular after its return has the same cause.
    fn lasted(&self) -> bool {
        let unsteady = self.effect.kind.is(KindRole::UnsteadySync);
        unsteady || self.cause.end.is_none_or(|end| self.effect.begin.no <= end.no)
    }

    /// Returns true if the cause is a command and came first.
    fn commanded(&self) -> bool {
        self.cause.kind.is(KindRole::Commanded) && self.delay >= -LATE_NS
    }

    /// Returns the time for which the effect's node waits for a heartbeat of the cause's node, in ns.
    fn limit(&self) -> Option<Ns> {
        let watched = self.effect.clue.watched.iter().find(|(node, _)| self.cause.subject.concerns(*node));
        watched.map(|(_, limit)| *limit)
    }
}

/// Returns true for communication errors that a lost SYNC may raise: generic and manufacturer-specific ones.
fn may_be_sync(code: u16) -> bool {
    matches!(code, 0x8100 | 0x8180..=0x81FF | 0x8200 | 0x8700 | 0xFF00..)
}

fn said_by_the_finding(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let frame = pair.effect.clue.because_of?;
    let other = !pair.alone() || pair.cause.kind != pair.effect.kind;
    // A silence of the whole bus is no cause of the boot-ups behind it: nodes without supply are silent.
    let silence = pair.cause.kind.is(KindRole::Explained) && pair.effect.kind.is(KindRole::Restart);
    let several = pair.effect.subject.nodes.count_ones() > 1;
    (pair.cause.holds(frame) && other && !(silence && several)).then_some((Grade::Certain, Ns::ZERO))
}

/// L1: a heartbeat consumer reported the loss of a node.
fn loss_reported(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let kind = pair.cause.kind;
    if kind.is(KindRole::Slower) {
        return slower_reported(pair);
    }
    (kind.is(KindRole::Gone) || kind.is(KindRole::NoHeartbeats)).then(|| loss(pair))?
}

/// L1: heartbeats that come more slowly are missed, too. Their period is known only some periods later.
fn slower_reported(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let Pair { cause, effect, delay, .. } = *pair;
    let period = cause.slow_ns()?;
    let watched = effect.clue.watched.is_empty() || pair.limit().is_some_and(|limit| limit < period + LATE_NS);
    let near = delay >= period * (-PERIODS) && cause.end.is_none_or(|end| effect.begin.no <= end.no);
    (pair.reported(LIFE_GUARD) && !pair.alone() && watched && near).then_some((Grade::Likely, delay.abs()))
}

/// L2: the master stopped guarding.
fn guarding_stopped(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    pair.cause.kind.is(KindRole::NoGuarding).then(|| loss(pair))?
}

/// L3: the monitored node was reset by command.
fn commanded_reset_reported(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    pair.cause.kind.is(KindRole::Commanded).then(|| loss(pair))?
}

fn loss(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let Pair { cause, effect, delay, .. } = *pair;
    let says = pair.reported(LIFE_GUARD);
    if !says && !effect.clue.communication
        || effect.kind.is(KindRole::TimeTooShort)
        || pair.alone() && !cause.kind.is(KindRole::NoGuarding)
    {
        return None;
    }
    let Some(limit) = pair.limit() else {
        // A heartbeat consumer waits for several periods.
        let period = cause.ns("period").unwrap_or(Ns::ZERO);
        let least = if says { Ns::ZERO } else { period };
        let most = if says { WINDOW_NS.max(period * PERIODS) } else { period * PERIODS };
        // Or the silence was noticed by this emergency.
        let shows = says && cause.noticed.no == effect.begin.no;
        let named = effect.clue.named & cause.subject.nodes != 0;
        let any = (effect.clue.watched.is_empty() || named) && (shows || (least..=most).contains(&delay));
        return any.then_some((Grade::Likely, (delay - period * 2).abs()));
    };
    let within = within(cause, limit);
    // A boot-up tells the consumer at once.
    let booted = cause.kind.is(KindRole::Booted) && effect.begin.no >= cause.noticed.no;
    // Some stacks check their times only now and then.
    let late = *within.end() + (limit + PROMPT_NS);
    let grade = if within.contains(&delay) || cause.kind.is(KindRole::Commanded) || booted && delay <= *within.end() {
        Grade::Certain
    } else if delay <= late || pair.same_node {
        // A node that could not be heard itself reports late.
        Grade::Likely
    } else {
        Grade::Possible
    };
    Some((grade, (delay - limit).abs()))
}

/// Returns the range of delays, in ns, after which a consumer that waits for `limit` ns reports a problem. A silence
/// begins with the last frame, but the consumer's time with the last heartbeat before it.
pub(super) fn within(cause: &Problem, limit: Ns) -> RangeInclusive<Ns> {
    let period = cause.ns("period").unwrap_or(limit / 3);
    let apart = if cause.kind.is(KindRole::Segment) { period } else { Ns::ZERO };
    limit - period - LATE_NS..=limit + LATE_NS.max(limit / 3) + apart
}

/// L40: an RPDO of the node that reports its timeout does not come any more.
fn rpdo_stopped(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let Pair { cause, effect, delay, .. } = *pair;
    let waits = pair.reported(RPDO_TIMEOUT) || effect.kind.is(KindRole::AwaitsPdo);
    let stopped = cause.kind.is(KindRole::NoRpdo) && pair.alone() && pair.lasted();
    (waits && stopped && (Ns::ZERO..=WINDOW_NS).contains(&delay)).then_some((Grade::Certain, delay))
}

/// L5: the producer of the missing PDO does not send.
fn rpdo_without_source(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let Pair { cause, effect, delay, .. } = *pair;
    let waits = pair.reported(RPDO_TIMEOUT) || effect.kind.is(KindRole::AwaitsPdo);
    let stops = cause.kind.is(KindRole::Gone)
        || cause.kind.is(KindRole::Commanded)
        || !cause.clue.reported.is_empty()
        || cause.kind.is(KindRole::StopsPdos);
    if !waits || !stops || pair.alone() {
        return None;
    }
    let source = cause.subject.nodes & effect.clue.sources != 0;
    if source {
        return Some((Grade::Certain, delay.abs()));
    }
    // Who waits for an RPDO itself has the same trouble.
    if cause.clue.reported.contains(&RPDO_TIMEOUT) {
        return None;
    }
    // Either its PDOs stopped as long ago as the node waits, or it is a pure controller, which sends the RPDOs that are
    // no node's TPDO.
    let suspect = cause.subject.nodes & effect.clue.suspects != 0 || effect.clue.suspects == 0 && cause.clue.controller;
    let gone =
        cause.kind.is(KindRole::Gone) || cause.kind.is(KindRole::Commanded) || cause.kind.is(KindRole::LeftState);
    let soon = (Ns::ZERO..=WINDOW_NS).contains(&delay) && effect.clue.suspects == 0 && gone;
    let grade = if suspect || soon { Grade::Likely } else { Grade::Possible };
    (suspect || effect.clue.sources == 0 && delay >= Ns::ZERO).then_some((grade, delay.abs()))
}

/// L6: SYNC is gone with its producer, and its consumers report that.
fn sync_gone(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let Pair { cause, effect, .. } = *pair;
    let stopped = cause.clue.sync_producer || cause.kind.is(KindRole::NoSync);
    let (last, period) =
        if cause.clue.sync_producer { cause.clue.sync? } else { effect.clue.sync.or(cause.clue.sync)? };
    let since = effect.begin.since(last)?;
    if effect.kind.is(KindRole::NoSync) && cause.kind.is(KindRole::Gone) {
        let most = (period * 2).max(cause.ns("period").unwrap_or(Ns::ZERO));
        let near = effect.begin.since(cause.begin)?.abs() <= most;
        let grade = if cause.clue.sync_producer { Grade::Certain } else { Grade::Likely };
        return near.then_some((grade, Ns::ZERO));
    }
    let says = effect.clue.reported.iter().any(|code| may_be_sync(*code))
        || effect.clue.reported.is_empty() && effect.kind.is(KindRole::DriveStops);
    let soon = (period / 2..=period * SYNCS).contains(&since);
    (stopped && says && soon && cause.subject.node != effect.subject.node).then_some((Grade::Likely, since))
}

/// L20: two nodes have one node-ID.
fn second_node(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let second = pair.same_node && pair.cause.kind.is(KindRole::SecondDevice) && pair.delay >= -WINDOW_NS;
    second.then_some((Grade::Likely, pair.delay))
}

/// L7: a node that could not be heard could not hear, either.
fn could_hear_nobody(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let of_bus = pair.effect.clue.reported.iter().any(|code| (0x8100..=0x82FF).contains(code));
    let lost = pair.cause.kind.is(KindRole::Silent) || pair.cause.kind.is(KindRole::Guarding);
    let stops = pair.effect.clue.reported.is_empty() && pair.effect.kind.is(KindRole::DriveStops);
    // What it sent last is no consequence.
    let after = pair.effect.begin.no > pair.cause.begin.no && pair.delay >= Ns::ZERO;
    (pair.same_node && (of_bus || stops) && lost && after).then_some((Grade::Likely, pair.delay))
}

/// L17: a node stores parameters or a program and has no time for anything else.
fn busy_storing(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let busy = pair.effect.kind.is(KindRole::Late) || pair.effect.kind.is(KindRole::Restart);
    (pair.same_node && pair.cause.kind.is(KindRole::Storing) && busy).then_some((Grade::Certain, pair.delay))
}

/// L16: more frames than the bus can carry, or one identifier of higher priority than all others.
fn bus_full(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let Pair { cause, effect, delay, .. } = *pair;
    let floods = cause.kind.is(KindRole::Floods);
    if floods && effect.kind.is(KindRole::Overloads) {
        return Some((Grade::Certain, delay.abs()));
    }
    // The last sign of an unheard node is older than the traffic that suppresses it.
    let began = effect.noticed.since(cause.begin).unwrap_or(Ns::ZERO) >= Ns::ZERO;
    let after = delay >= -effect.ns("period").unwrap_or(Ns::ZERO) - LATE_NS;
    let full = floods || cause.kind.is(KindRole::Overloads);
    (full && effect.kind.is(KindRole::Late) && began && after).then_some((Grade::Likely, delay.abs()))
}

/// L15: two masters contradict each other.
fn contradicted(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let follows = pair.effect.kind.is(KindRole::Commanded)
        || pair.effect.kind.is(KindRole::Late)
        || pair.effect.kind.is(KindRole::IgnoresCommand);
    (pair.cause.kind.is(KindRole::Contradicts) && follows).then_some((Grade::Likely, pair.delay.abs()))
}

/// L18: a supply that dips takes other nodes with it.
fn supply_dipped(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let falls = pair.effect.kind.is(KindRole::Falls) || pair.effect.kind.is(KindRole::Supply) && !pair.same_node;
    let soon = |since: Option<Ns>| since.is_some_and(|since| (Ns::ZERO..=SUPPLY_NS).contains(&since));
    let soon = soon(pair.effect.noticed.since(pair.cause.begin)) || soon(pair.effect.begin.since(pair.cause.begin));
    (pair.cause.kind.is(KindRole::Supply) && falls && soon).then_some((Grade::Likely, pair.delay))
}

/// L11: a lost node answers nothing.
fn nobody_to_answer(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let Pair { cause, effect, delay, same_node } = *pair;
    // One that is back answers again.
    let gone = cause.kind.is(KindRole::Gone) && pair.lasted();
    // A Pre-operational node answers; a Stopped or booting one does not.
    let mute = pair.commanded() && cause.get("command") != Some(Quantity::Command(0x80));
    if same_node && effect.kind.is(KindRole::Service) && (gone || mute) {
        return Some((Grade::Certain, delay.abs()));
    }
    (same_node && effect.kind.is(KindRole::NeverHeard) && gone).then_some((Grade::Likely, delay.abs()))
}

/// L35: frames of a transfer that the server refused were still under way.
fn transfer_ended(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let soon = (Ns::ZERO..=PROMPT_NS).contains(&pair.delay) && pair.alone();
    let left_over = pair.effect.findings.iter().all(|cited| cited.code == Code::Sdo007);
    let refused = pair.cause.has("refused") && pair.effect.kind.is(KindRole::Violation) && left_over;
    (soon && refused).then_some((Grade::Likely, pair.delay))
}

/// L30: a server refuses a transfer that violates the protocol.
fn violation_refused(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let Pair { cause, effect, delay, .. } = *pair;
    let code = matches!(effect.get("abort"), Some(Quantity::Abort(code)) if code.is_violation());
    let within = (effect.begin.no..=effect.noticed.no).contains(&cause.begin.no);
    (pair.alone() && cause.kind.is(KindRole::Violation) && code && within).then_some((Grade::Certain, delay.abs()))
}

/// L31: a consumer reports a PDO that does not fit its mapping.
fn length_reported(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let own = pair.cause.kind.is(KindRole::WrongLength) && matches!(pair.cause.subject.pdo, Some((false, _)));
    let says = pair.reported(0x8210) || pair.reported(0x8220);
    (pair.alone() && own && says && pair.delay >= -LATE_NS).then_some((Grade::Certain, pair.delay.abs()))
}

/// L29: a guarded node that did not answer shows at its return that it has restarted.
fn same_outage(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let Pair { cause, effect, .. } = *pair;
    let shows = effect.kind.is(KindRole::ShowsOutage);
    let then = effect.begin.no >= cause.begin.no && cause.end.is_none_or(|end| effect.begin.no <= end.no);
    (pair.within() && cause.kind.is(KindRole::Guarding) && shows && then).then_some((Grade::Certain, Ns::ZERO))
}

/// L12: a booted node has lost its configuration.
fn configuration_lost(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let Pair { cause, effect, delay, same_node } = *pair;
    let silent = effect.kind.is(KindRole::AloneSilent) && cause.kind.is(KindRole::Loop);
    let booted = effect.kind.is(KindRole::OldConfiguration) && cause.kind.is(KindRole::LosesConfiguration);
    // What came before the boot-up may be its cause.
    let booted = booted && delay >= Ns::ZERO;
    (same_node && (silent || booted)).then_some((Grade::Likely, delay))
}

/// L15: a node was stopped or reset by command.
fn commanded(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    if !pair.same_node || !pair.commanded() {
        return None;
    }
    if pair.effect.kind.is(KindRole::DriveStops) {
        return (pair.delay <= 2 * PROMPT_NS).then_some((Grade::Certain, pair.delay));
    }
    let missing = pair.effect.kind.is(KindRole::OwnFramesMissing) && pair.lasted();
    missing.then_some((Grade::Certain, pair.delay.abs()))
}

/// L7: a drive stops because it lost a node that it monitors, by its own report or by the times.
fn communication_lost(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let stops = pair.effect.kind.is(KindRole::DriveStops) && pair.cause.kind.is(KindRole::Gone);
    let says = pair.alone() && pair.cause.clue.reported.iter().any(|code| (0x8100..=0x82FF).contains(code));
    if pair.effect.kind.is(KindRole::Reaction) && says && (-LATE_NS..=PROMPT_NS).contains(&pair.delay) {
        return Some((Grade::Certain, pair.delay.abs()));
    }
    let limit = pair.limit().filter(|_| stops)?;
    (limit..=limit + limit / 3 + PROMPT_NS).contains(&pair.delay).then_some((Grade::Likely, pair.delay))
}

/// L33: a node that is lost or not Operational sends no PDO, and none is sent to it.
fn node_not_operational(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    // A controller stops the RPDOs of a node that it has lost.
    let missing = pair.effect.kind.is(KindRole::FramesMissing);
    let stops = pair.cause.kind.is(KindRole::Gone)
        || pair.cause.kind.is(KindRole::LeftState)
        || pair.cause.has("left_operational");
    (pair.same_node && missing && stops && pair.lasted()).then_some((Grade::Certain, pair.delay.abs()))
}

/// L13: a PDO that could not be configured differs from the intended one.
fn configured_wrongly(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let other = pair.effect.kind.is(KindRole::OtherPdo);
    // A consumer reports a wrong PDO length; one of the PDOs that it receives was not configured.
    let taken = pair.effect.kind.is(KindRole::WrongLength) && pair.effect.clue.sources & pair.cause.subject.nodes != 0;
    // If the PDOs that it receives are not known, it is the one whose mapping was refused.
    let unknown = pair.effect.clue.sources == 0 && pair.cause.subject.pdo.is_some_and(|(transmit, _)| transmit);
    let taken = taken || pair.effect.kind.is(KindRole::WrongLength) && unknown && !pair.effect.clue.reported.is_empty();
    if taken
        && (pair.cause.has("refused") || pair.cause.kind.is(KindRole::WrongLength))
        && !pair.alone()
        && pair.delay >= Ns::ZERO
    {
        return Some((Grade::Likely, pair.delay));
    }
    let pdo = pair.effect.subject.pdo;
    // It has the frames of another service, as its COB-ID was set to that of one.
    if pair.cause.kind.is(KindRole::PdoSetting)
        && pair.alone()
        && pdo.is_some()
        && pdo == pair.cause.subject.pdo
        && other
    {
        return (pair.delay >= Ns::ZERO).then_some((Grade::Certain, pair.delay));
    }
    let same = pdo.is_none() || pdo == pair.cause.subject.pdo;
    (pair.same_node && other && same && pair.cause.has("refused")).then_some((Grade::Likely, pair.delay))
}

/// L32: a producer that refused its heartbeat time sends no heartbeats.
fn no_heartbeats(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let Pair { cause, effect, delay, .. } = *pair;
    let time = matches!(cause.get("object"), Some(Quantity::Object(object)) if object.index == PRODUCER_TIME);
    let watched = effect.clue.watched.is_empty() || pair.limit().is_some();
    let misses = time && cause.has("refused") && pair.reported(LIFE_GUARD) && watched && !pair.alone();
    (misses && delay >= Ns::ZERO).then_some((Grade::Likely, Ns::ZERO))
}

/// L14: a master that got no answer, or a refusal, does not start the node.
fn boot_cut_short(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let waits = pair.effect.kind.is(KindRole::NeverStarted)
        || pair.effect.kind.is(KindRole::IgnoresCommand) && pair.cause.kind.is(KindRole::Program);
    let cut = pair.cause.has("refused") || pair.cause.kind.is(KindRole::CutsBoot);
    (pair.same_node && waits && cut).then_some((Grade::Likely, pair.delay.abs()))
}

/// L34: a master that starts none of its nodes waits for the one whose boot was cut short (CiA 302-2, mandatory slaves).
fn boot_awaited(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let cut = pair.cause.has("refused") || pair.cause.kind.is(KindRole::CutsBoot);
    let waits =
        pair.effect.kind.is(KindRole::AwaitsStart) && pair.effect.has("started_nodes") && pair.cause.end.is_none();
    (waits && cut).then_some((Grade::Likely, pair.delay.abs()))
}

/// L4: a node with an error leaves Operational, or does not reach it (1029h).
fn error_before(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let Pair { cause, effect, delay, .. } = *pair;
    let errs = effect.kind.is(KindRole::IgnoresCommand) && !cause.clue.codes.is_empty()
        || effect.kind.is(KindRole::LeftState) && !cause.clue.reported.is_empty();
    (pair.same_node && errs).then_some((Grade::Likely, delay))
}

/// Returns the gap before a late heartbeat, in ns; heartbeats that come more slowly for good (`reason`) leave none.
fn gap(one: &Problem) -> Option<Ns> {
    let lasts = one.measured().is_some_and(|all| all.variant.constants.iter().any(|(name, _)| *name == "reason"));
    one.ns("found").filter(|_| one.kind.is(KindRole::Slower) && !lasts)
}

/// L36: a node that reports an error is late with its heartbeat.
fn error_meanwhile(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let errs = pair.same_node && !pair.cause.clue.reported.is_empty();
    (errs && (Ns::ZERO..=gap(pair.effect)?).contains(&pair.delay)).then_some((Grade::Likely, pair.delay))
}

/// L39: a node that restarts sends no heartbeat meanwhile.
fn restarted_meanwhile(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let restarts = pair.same_node && (pair.cause.kind.is(KindRole::Restart) || pair.cause.kind.is(KindRole::Loop));
    (restarts && (Ns::ZERO..=gap(pair.effect)?).contains(&pair.delay)).then_some((Grade::Certain, pair.delay))
}

/// L37: a node that sent no heartbeat sent nothing else at that time.
fn sent_nothing(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let missing = [KindRole::MissingPdo, KindRole::Service, KindRole::NoSync].map(|role| pair.effect.kind.is(role));
    let within = (gap(pair.cause)? * (-2)..=Ns::ZERO).contains(&pair.delay);
    (pair.same_node && missing.contains(&true) && within).then_some((Grade::Likely, pair.delay.abs()))
}

/// L38: targets that are sent with SYNC are late with it.
fn targets_with_sync(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let Pair { cause, effect, delay, .. } = *pair;
    let targets = effect.kind.is(KindRole::Jitter) && !effect.kind.is(KindRole::UnsteadySync);
    let follows = targets && (cause.kind.is(KindRole::UnsteadySync) || cause.kind.is(KindRole::NoSync));
    let period = effect.ns("period").unwrap_or(Ns::ZERO);
    (follows && delay >= period * (-PERIODS)).then_some((Grade::Likely, delay.abs()))
}

/// L41: a drive reports that its control does not keep up with an unsteady SYNC (CiA 402, 8700h).
fn unsteady_sync_reported(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let unsteady = pair.cause.kind.is(KindRole::UnsteadySync) && !pair.effect.kind.is(KindRole::UnsteadySync);
    let reported = pair.effect.clue.reported.contains(&SYNC_CONTROLLER);
    (unsteady && reported && pair.delay >= Ns::ZERO).then_some((Grade::Likely, pair.delay))
}

/// L23: a fault reset needs a rising edge.
fn no_edge(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let held = pair.effect.kind.is(KindRole::EdgeMissing) && pair.cause.kind.is(KindRole::Fault);
    (pair.same_node && held).then_some((Grade::Certain, pair.delay))
}

/// L8: errors that a device reports before its axis faults, and causes of a lagging axis.
fn announced(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let Pair { cause, effect, delay, same_node } = *pair;
    if same_node && cause.kind.is(KindRole::AnnouncesFault) && effect.kind.is(KindRole::Fault) {
        return Some((Grade::Likely, delay));
    }
    (same_node && cause.kind.is(KindRole::Jitter) && effect.kind.is(KindRole::Lags)).then_some((Grade::Possible, delay))
}

/// L22: the cause of the fault persists.
fn cause_stands(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let stays = pair.effect.kind.is(KindRole::FaultStays) && !pair.cause.clue.codes.is_empty();
    (pair.same_node && stays).then_some((Grade::Likely, pair.delay))
}

/// L27: a node that is not Operational processes no RPDO.
fn not_listening(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let out = pair.cause.kind.is(KindRole::Gone) || pair.commanded() || pair.cause.kind.is(KindRole::NotOperational);
    let Pair { cause, effect, delay, same_node } = *pair;
    if same_node && effect.kind.is(KindRole::RpdosIgnored) {
        let errs = cause.has("left_operational") || !cause.clue.reported.is_empty();
        let grade = if out { Grade::Certain } else { Grade::Likely };
        return (out || errs).then_some((grade, delay.abs()));
    }
    let unmoved = same_node && effect.kind.is(KindRole::EnableIgnored) && (out || cause.kind.is(KindRole::NoReceiver));
    unmoved.then_some((Grade::Likely, delay))
}

/// L10: bus errors around a loss or delay.
fn bus_errors(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let lost = pair.effect.kind.is(KindRole::Disturbed);
    if !lost || !pair.cause.kind.is(KindRole::BusFault) {
        return None;
    }
    let many = pair.cause.kind.is(KindRole::BusOff) || pair.cause.repeats.count >= 3;
    Some((if many { Grade::Likely } else { Grade::Possible }, pair.delay.abs()))
}

/// L21: nodes report the errors seen on the bus.
fn bus_errors_reported(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    (pair.effect.kind.is(KindRole::ReportsBus) && pair.cause.kind.is(KindRole::BusFault))
        .then_some((Grade::Likely, pair.delay.abs()))
}

/// L26: a problem that rests on times began in a gap of the recording.
fn recording_stood_still(pair: &Pair<'_>) -> Option<(Grade, Ns)> {
    let Pair { cause, effect, .. } = *pair;
    let timed = effect.kind.is(KindRole::Timed);
    let inside = cause.begin.no >= effect.begin.no && cause.begin.no <= effect.noticed.no;
    (cause.kind.is(KindRole::Gap) && timed && inside).then_some((Grade::Certain, pair.delay.abs()))
}

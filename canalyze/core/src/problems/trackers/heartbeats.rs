//! Heartbeats that cannot come any more: switched off by a write, not sent again behind a boot-up, or monitored although
//! the node was never there.
//!
//! Heartbeats that stop while they are owed are findings of the checks.

use std::collections::BTreeMap;

use super::rules::GOES_ON;
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::problems::kinds::ProblemKind;
use crate::problems::ledger::LedgerPlace;
use crate::problems::problem::{Problem, StepRole, Subject};
use crate::problems::roles::KindRole;
use crate::problems::sayings::Saying;
use crate::problems::scene::Scene;
use crate::rules::finding::Quantity;
use crate::sdo::transfer::{Direction, Status, Transfer};

/// Consumer and producer heartbeat time (CiA 301, 7.5.2.18, 7.5.2.19).
const CONSUMER_TIME: u16 = 0x1016;
const PRODUCER_TIME: u16 = 0x1017;
/// Number of periods without a heartbeat of a node behind its boot-up, and minimum time in ns, from which they do not come
/// again.
const MUTE_PERIODS: i64 = 10;
const MUTE_NS: Ns = Ns::from_s(5);
/// A period that differs by less than this part is the same, and number of times in a row that show one.
const SAME: i64 = 8;
const STEADY: u32 = 3;
/// Number of times of a consumer in which a monitored node must be heard.
const CONSUMER_TIMES: i64 = 3;

/// The heartbeats of a bus that were switched off, and the nodes that booted.
#[derive(Clone, Debug, Default)]
pub(in crate::problems) struct MissingHeartbeats {
    off: BTreeMap<u8, LedgerPlace>,
    /// The last transfer of a consumer heartbeat time with each node.
    consumers: BTreeMap<u8, FrameRef>,
    /// The last time between two heartbeats of a node, in ns, and the number of times in a row that it was the same.
    periods: BTreeMap<u8, (Ns, u32)>,
    /// The boot-up of each node that sent heartbeats before it, and their period in ns.
    booted: BTreeMap<u8, (FrameRef, Ns)>,
}

impl MissingHeartbeats {
    /// Processes the end of an SDO transfer.
    pub(in crate::problems) fn transfer(&mut self, transfer: &Transfer, scene: &mut Scene<'_>) {
        let node = transfer.node;
        let index = transfer.mux.map(|mux| mux.index);
        if index == Some(CONSUMER_TIME) && transfer.outcome.status == Status::Ok {
            self.consumers.insert(node, transfer.first);
        }
        let written = transfer.direction == Direction::Download && transfer.outcome.status == Status::Ok;
        if !written || index != Some(PRODUCER_TIME) {
            return;
        }
        if transfer.data.kept.iter().any(|byte| *byte != 0) {
            if let Some(one) = self.off.remove(&node).and_then(|place| scene.ledger.get_mut(place)) {
                one.step(transfer.last, StepRole::Recovery, Saying::WrittenAgain, None);
                one.ends(transfer.last);
            }
        } else if let Some(last) = scene.heard.last_heartbeat(node)
            && !self.off.contains_key(&node)
        {
            let period = scene.bus.heartbeat_period(node);
            let kind = ProblemKind::HeartbeatSwitchedOff;
            let Some(place) = scene.ledger.open(kind, scene.id, Subject::node(node), transfer.first, transfer.last)
            else {
                return;
            };
            self.off.insert(node, place);
            if let Some(one) = scene.ledger.get_mut(place) {
                one.fact("last_heartbeat", Quantity::Count(last.listed().no));
                if let Some(period) = period {
                    one.fact("period", Quantity::Ns(period));
                }
            }
        }
    }

    /// Processes a heartbeat, before it is recorded as the last one.
    pub(in crate::problems) fn beat(&mut self, node: u8, scene: &mut Scene<'_>) {
        if let Some(period) = scene.at.since(scene.heard.last_heartbeat(node)).filter(|period| *period > Ns::ZERO) {
            let (before, run) = self.periods.get(&node).copied().unwrap_or_default();
            let run = if is_same(before, period) { run.saturating_add(1) } else { 0 };
            self.periods.insert(node, (period, run));
        }
    }

    /// Processes a boot-up.
    pub(in crate::problems) fn booted(&mut self, node: u8, scene: &mut Scene<'_>) {
        if let Some(one) = self.off.remove(&node).and_then(|place| scene.ledger.get_mut(place)) {
            one.ends(scene.at);
        }
        if let Some((period, _)) = self.periods.get(&node) {
            let known = scene.bus.heartbeat_period(node).unwrap_or(*period);
            self.booted.insert(node, (scene.at, known));
        }
    }

    /// Concludes at the end of the capture.
    pub(in crate::problems) fn finish(&mut self, scene: &mut Scene<'_>) {
        // Heartbeats that are back at their period are no finding, nor are those after the first late one.
        for (node, (period, run)) in &self.periods {
            let late = |one: &Problem| {
                let counts = one.kind.is(KindRole::Slower) && one.subject.node == Some(*node);
                counts && one.repeats.count < GOES_ON
            };
            let place = scene.ledger.last(scene.id, late);
            if let Some(one) = place.and_then(|place| scene.ledger.get_mut(place))
                && one.ns("expected").is_some_and(|usual| *period > usual + usual / 4 && *run >= STEADY)
            {
                (one.clue.least, one.clue.lasts, one.end) = (1, true, None);
            }
            let changed =
                |one: &Problem| one.kind.is(KindRole::Slower) && one.end.is_none() && one.subject.node == Some(*node);
            let place = scene.ledger.last(scene.id, changed);
            if let Some(one) = place.and_then(|place| scene.ledger.get_mut(place))
                && one.ns("from").is_some_and(|from| is_same(from, *period) && *run >= STEADY)
                && let Some(last) = scene.heard.last_heartbeat(*node)
            {
                one.step(last, StepRole::Recovery, Saying::Recovered, None);
                one.ends(last);
            }
        }
        for (node, (boot_up, period)) in std::mem::take(&mut self.booted) {
            let silent = scene.heard.last_heartbeat(node).is_none_or(|last| last.no <= boot_up.no);
            let long = scene.at.since(boot_up).is_some_and(|since| since >= MUTE_NS.max(period * MUTE_PERIODS));
            let told = scene
                .ledger
                .all
                .iter()
                .any(|one| is_of(one, scene, node) && one.end.is_none() && !one.kind.is_harmless());
            if silent && long && !told {
                let kind = ProblemKind::MuteAfterBoot;
                let place = scene.ledger.open(kind, scene.id, Subject::node(node), boot_up, boot_up);
                if let Some(one) = place.and_then(|place| scene.ledger.get_mut(place)) {
                    one.fact("period", Quantity::Ns(period));
                }
            }
        }
        // A capture of one node alone does not show the others.
        if scene.heard.known.count_ones() < 2 {
            return;
        }
        for (node, first) in std::mem::take(&mut self.consumers) {
            for (watched, limit, _) in scene.watched(node) {
                let absent = scene.heard.last(watched).is_none();
                let long = absent && scene.at.since(first).is_some_and(|since| since > limit * CONSUMER_TIMES);
                let told = scene
                    .ledger
                    .all
                    .iter()
                    .any(|one| is_of(one, scene, node) && one.kind.is(KindRole::ConsumerReports));
                if !long || told {
                    continue;
                }
                let kind = ProblemKind::WatchedAbsent;
                let place = scene.ledger.open(kind, scene.id, Subject::node(node), first, first);
                if let Some(one) = place.and_then(|place| scene.ledger.get_mut(place)) {
                    one.fact("watched", Quantity::Count(watched.into()));
                    one.fact("limit", Quantity::Ns(limit));
                }
            }
        }
    }
}

/// Makes a consumer's report that of a node that was never seen.
pub(in crate::problems) fn never_seen(one: &mut Problem, node: u8) {
    one.kind = ProblemKind::WatchedAbsent;
    one.fact("watched", Quantity::Count(node.into()));
}

/// Returns true if two periods are the same, in ns.
fn is_same(one: Ns, other: Ns) -> bool {
    (one - other).abs() <= one / SAME
}

/// Returns true if a problem concerns a node of the bus.
fn is_of(one: &Problem, scene: &Scene<'_>, node: u8) -> bool {
    one.bus == scene.id && one.subject.concerns(node)
}

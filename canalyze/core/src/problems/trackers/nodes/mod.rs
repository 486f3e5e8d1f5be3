//! Nodes that are lost, restart, leave Operational or receive commands.
//!
//! A silence begins with the last frame of the node, not when it is noticed. It ends when the node is heard again, or,
//! for a node that was Operational and boots, when it is Operational again. This module holds the open problems and
//! ends them; `losses`, `changes` and `commands` open them. `checks/heartbeat` decides if a heartbeat is overdue.

mod changes;
mod commands;
mod losses;

pub(in crate::problems) use self::changes::LOOP;
use std::collections::BTreeMap;

use self::changes::Together;
use super::commanded::Commanded;
use crate::bytes::frame::FrameRef;
use crate::problems::ledger::LedgerPlace;
use crate::problems::problem::{StepRole, bit};
use crate::problems::roles::KindRole;
use crate::problems::sayings::Saying;
use crate::problems::scene::Scene;
use crate::rules::finding::Quantity;
use crate::wire::error_control::OPERATIONAL;
use crate::wire::nmt::START;

/// The open problems of the nodes of a bus.
#[derive(Clone, Debug, Default)]
pub(in crate::problems) struct NodeProblems {
    silent: BTreeMap<u8, LedgerPlace>,
    /// Silent nodes that have sent other frames since, but no heartbeat: the problem and the first such frame.
    mute: BTreeMap<u8, (LedgerPlace, FrameRef)>,
    /// Problems of nodes that are back or left Operational, which end once the node is Operational.
    waiting: BTreeMap<u8, Vec<LedgerPlace>>,
    /// Nodes that have to boot or to reach a state.
    owing: BTreeMap<u8, LedgerPlace>,
    commanded: Option<Commanded>,
    /// Nodes that were Operational before their last boot-up or reset, one bit each.
    was_operational: u128,
    /// The first start command to each node that it has not obeyed yet.
    started: BTreeMap<u8, FrameRef>,
    /// The boot-up of each node that ended its last silence.
    returned: BTreeMap<u8, u64>,
    /// The last frame of each node before its last boot-up.
    before: BTreeMap<u8, FrameRef>,
    /// The last start command to each node, and to all (0).
    ordered: BTreeMap<u8, FrameRef>,
    /// RPDOs to nodes that are not Operational.
    ignored: BTreeMap<u8, IgnoredRpdos>,
    /// The last boot-up of each node.
    booted: BTreeMap<u8, FrameRef>,
    together: Together,
}

/// RPDOs to a node that is not Operational: the first and the last, their number, and the problem.
#[derive(Clone, Copy, Debug)]
struct IgnoredRpdos {
    first: FrameRef,
    last: FrameRef,
    count: u64,
    place: Option<LedgerPlace>,
}

impl NodeProblems {
    /// Records a boot-up of a node.
    pub(in crate::problems) fn booted(&mut self, node: u8, scene: &mut Scene<'_>) {
        let at = scene.at;
        let was = scene.heard.is_operational(node) || self.was_operational & bit(node) != 0;
        self.booted.insert(node, at);
        self.together.booted(node, was && scene.bus.booted_unasked(node), at);
        self.mute.remove(&node);
        if let Some(commanded) = &mut self.commanded {
            commanded.boots(node, scene.ledger);
        }
        match scene.heard.last(node) {
            Some(last) => self.before.insert(node, last),
            None => self.before.remove(&node),
        };
        self.started.remove(&node);
        if let Some(place) = self.owing.remove(&node) {
            self.close(place, at, Saying::Booted, scene);
        }
        let waits = self.waiting.remove(&node).unwrap_or_default();
        for place in &waits {
            if let Some(one) = scene.ledger.get_mut(*place) {
                one.step(at, StepRole::Reaction, Saying::Booted, None);
            }
        }
        if !waits.is_empty() {
            self.waiting.insert(node, waits);
        }
        if let Some(place) = self.silent.remove(&node)
            && let Some(one) = scene.ledger.get_mut(place)
        {
            self.returned.insert(node, at.no);
            one.step(at, StepRole::Recovery, Saying::BootedUnasked, None);
            one.fact("boot_up", Quantity::Count(1));
            one.clue.back |= bit(node);
            if let Some(silence) = at.since(one.repeats.since) {
                one.fact("silence", Quantity::Ns(silence));
            }
            if was {
                self.wait(node, place);
            } else if !self.silent.values().any(|other| *other == place) {
                one.ends(at);
            }
        }
    }

    /// Records that a node has another node-ID: it does not return under this one.
    pub(in crate::problems) fn moved(&mut self, node: u8, scene: &mut Scene<'_>) {
        self.started.remove(&node);
        if self.commanded.as_mut().is_some_and(|commanded| commanded.is_over_without(node, scene)) {
            self.commanded = None;
        }
    }

    /// Processes a state shown by error control; `stays`: it is that of the report before.
    pub(in crate::problems) fn state(&mut self, node: u8, state: u8, stays: bool, scene: &mut Scene<'_>) {
        if state != OPERATIONAL {
            return;
        }
        self.was_operational &= !bit(node);
        self.started.remove(&node);
        self.controlled(node, true, scene);
        self.runs_again(node, scene);
        let at = scene.at;
        for place in self.waiting.remove(&node).unwrap_or_default() {
            let others = self.waiting.values().flatten().any(|other| *other == place)
                || self.silent.values().any(|other| *other == place);
            if let Some(one) = scene.ledger.get_mut(place) {
                one.step(at, StepRole::Recovery, Saying::OperationalAgain, None);
                if !others && one.clue.codes.is_empty() && !one.kind.is(KindRole::Fault) {
                    one.ends(at);
                }
            }
        }
        if let Some(place) = self.owing.get(&node).copied()
            && scene.ledger.get(place).is_some_and(|one| {
                // A node that goes on has not obeyed another command.
                let ignored = one.get("command").is_some_and(|command| command != Quantity::Command(START));
                one.kind.is(KindRole::IgnoresCommand) && !ignored
            })
        {
            self.owing.remove(&node);
            self.close(place, at, Saying::OperationalAgain, scene);
        }
        let booted = self.booted.get(&node).copied();
        if self.commanded.as_mut().is_some_and(|commanded| commanded.is_over_with(node, (booted, stays), scene)) {
            self.commanded = None;
        }
    }

    /// Returns true if a problem ends only once its node is Operational.
    pub(in crate::problems) fn waits(&self, place: LedgerPlace) -> bool {
        self.waiting.values().flatten().any(|other| *other == place)
    }

    /// Returns true if a node is expected to become Operational.
    pub(in crate::problems) fn is_waiting(&self, node: u8) -> bool {
        self.waiting.contains_key(&node)
            || self.owing.contains_key(&node)
            || self.ignored.contains_key(&node)
            || self.commanded.is_some()
            || self.together.waits_for(node)
    }

    /// Returns true if a node is silent.
    pub(in crate::problems) fn is_silent(&self, node: u8) -> bool {
        self.silent.contains_key(&node)
    }

    /// Returns true if a node has booted since a frame.
    pub(in crate::problems) fn booted_since(&self, node: u8, at: FrameRef) -> bool {
        self.booted.get(&node).is_some_and(|booted| booted.no > at.no)
    }

    /// Returns the last boot-up of the nodes of a problem that are back without being Operational.
    pub(in crate::problems) fn back(&self, place: LedgerPlace) -> Option<FrameRef> {
        let waiting = self.waiting.iter().filter(|(_, places)| places.contains(&place));
        waiting.filter_map(|(node, _)| self.booted.get(node).copied()).max_by_key(|at| at.no)
    }

    fn wait(&mut self, node: u8, place: LedgerPlace) {
        let places = self.waiting.entry(node).or_default();
        if !places.contains(&place) {
            places.push(place);
        }
    }

    fn close(&mut self, place: LedgerPlace, at: FrameRef, said: Saying, scene: &mut Scene<'_>) {
        if let Some(one) = scene.ledger.get_mut(place) {
            one.step(at, StepRole::Recovery, said, None);
            one.ends(at);
        }
    }
}

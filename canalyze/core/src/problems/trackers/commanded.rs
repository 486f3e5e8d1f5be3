//! A reset or stop by command, with the nodes concerned until all of them are Operational again.
//!
//! A command to all nodes does not affect the controller that sends it, which continues without a boot-up.

use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::problems::ledger::{Ledger, LedgerPlace};
use crate::problems::problem::{StepRole, bit};
use crate::problems::roles::KindRole;
use crate::problems::sayings::Saying;
use crate::problems::scene::Scene;

/// Time for which a heartbeat may have waited to be sent when a command came, and in which the command is obeyed, in ns.
const ON_ITS_WAY_NS: Ns = Ns::from_ms(50);

/// A command that has not ended.
#[derive(Clone, Copy, Debug)]
pub(super) struct Commanded {
    pub(super) place: LedgerPlace,
    /// Nodes that are not Operational again, one bit each.
    left: u128,
    /// Those of them that continue as if they were not meant.
    goes_on: u128,
}

impl Commanded {
    /// Makes a command to these nodes, one bit each.
    pub(super) fn new(place: LedgerPlace, nodes: u128) -> Self {
        Self { place, left: nodes, goes_on: 0 }
    }

    /// Adds nodes.
    pub(super) fn hits(&mut self, nodes: u128) {
        self.left |= nodes;
    }

    /// Returns true if one of its nodes is not Operational again.
    pub(super) fn waits_for(&self, node: u8) -> bool {
        self.left & bit(node) != 0
    }

    /// Returns true if it waits for none but these nodes.
    pub(super) fn waits_only_for(&self, nodes: u128) -> bool {
        self.left & !self.goes_on & !nodes == 0
    }

    /// Records a boot-up; if the node seemed to continue, that was a frame under way.
    pub(super) fn boots(&mut self, node: u8, ledger: &mut Ledger) {
        if self.goes_on & bit(node) != 0
            && let Some(one) = ledger.get_mut(self.place)
        {
            self.goes_on &= !bit(node);
            one.subject.nodes |= bit(node);
        }
    }

    /// Records that error control shows a node as Operational, after its last boot-up `booted`; `stays`: it has reported no
    /// other state meanwhile. Returns true if the command has ended.
    pub(super) fn is_over_with(
        &mut self,
        node: u8,
        (booted, stays): (Option<FrameRef>, bool),
        scene: &mut Scene<'_>,
    ) -> bool {
        let at = scene.at;
        let Some(one) = scene.ledger.get_mut(self.place) else { return false };
        // A heartbeat so soon behind the command was sent, or waited to be sent, before it.
        if at.since(one.repeats.since).is_some_and(|since| (Ns::ZERO..ON_ITS_WAY_NS).contains(&since)) {
            return false;
        }
        let booted = booted.is_some_and(|boot| boot.no > one.begin.no);
        let others = one.subject.nodes & !bit(node);
        let obeyed = if one.kind.is(KindRole::Reset) { booted } else { !stays };
        if !obeyed && others != 0 && self.waits_for(node) {
            self.goes_on |= self.left & bit(node);
            one.subject.nodes = others;
        } else {
            self.left &= !bit(node);
        }
        let over = self.waits_only_for(0);
        if over {
            one.step(at, StepRole::Recovery, Saying::OperationalAgain, None);
            one.ends(at);
        }
        over
    }

    /// Records that a node has another node-ID; returns true if the command has ended.
    pub(super) fn is_over_without(&mut self, node: u8, scene: &mut Scene<'_>) -> bool {
        self.left &= !bit(node);
        let over = self.waits_only_for(0);
        if let Some(one) = scene.ledger.get_mut(self.place).filter(|_| over) {
            one.ends(scene.at);
        }
        over
    }
}

//! A reset, or a stop, by command: the nodes that it has hit, until all of them are Operational again.
//!
//! A command to all nodes does not hit the controller that sends it: it goes on without a boot-up. Must not: open an
//! incident, or know what else keeps a node from being Operational.

use crate::diagnosis::incident::{Role, bit};
use crate::diagnosis::kinds::Kind;
use crate::diagnosis::ledger::{Ledger, Place};
use crate::diagnosis::sayings::Saying;
use crate::diagnosis::scene::Scene;
use crate::frame::FrameRef;

/// A command that is not over.
#[derive(Clone, Copy, Debug)]
pub(super) struct Commanded {
    pub(super) place: Place,
    /// The nodes that are not Operational again, a bit each.
    left: u128,
    /// Those of them that were to be reset and go on without a boot-up.
    goes_on: u128,
}

impl Commanded {
    /// A command that has hit these nodes, a bit each.
    pub(super) fn new(place: Place, nodes: u128) -> Self {
        Self { place, left: nodes, goes_on: 0 }
    }

    /// It hits these nodes, too.
    pub(super) fn hits(&mut self, nodes: u128) {
        self.left |= nodes;
    }

    /// Whether a node that it has hit is not Operational again.
    pub(super) fn waits_for(&self, node: u8) -> bool {
        self.left & bit(node) != 0
    }

    /// Whether it waits for none but these.
    pub(super) fn waits_only_for(&self, nodes: u128) -> bool {
        self.left & !self.goes_on & !nodes == 0
    }

    /// A node has booted: if it seemed to go on, that was a frame under way.
    pub(super) fn boots(&mut self, node: u8, ledger: &mut Ledger) {
        if self.goes_on & bit(node) != 0
            && let Some(one) = ledger.get_mut(self.place)
        {
            self.goes_on &= !bit(node);
            one.subject.nodes |= bit(node);
        }
    }

    /// Error control shows a node, which has last booted there, as Operational. Tells whether the command is over.
    pub(super) fn is_over_with(&mut self, node: u8, booted: Option<FrameRef>, scene: &mut Scene<'_>) -> bool {
        let at = scene.at;
        let Some(one) = scene.ledger.get_mut(self.place) else { return false };
        let booted = booted.is_some_and(|boot| boot.no > one.begin.no);
        let others = one.subject.nodes & !bit(node);
        if one.kind == Kind::CommandedReset && !booted && others != 0 {
            self.goes_on |= self.left & bit(node);
            one.subject.nodes = others;
        } else {
            self.left &= !bit(node);
        }
        let over = self.waits_only_for(0);
        if over {
            one.step(at, Role::Recovery, Saying::OperationalAgain, None);
            one.ends(at);
        }
        over
    }
}

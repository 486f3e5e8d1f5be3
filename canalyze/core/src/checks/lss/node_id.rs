//! Node-IDs assigned by LSS, from the slave's confirmation to the boot-up with it (CiA 305, CiA 301 7.2.8.2).
//!
//! A slave without node-ID adopts the new one when it returns to the waiting state; one with a node-ID adopts it at the
//! next reset of its communication, or at a restart if it was stored. If nobody asked for the former node-ID, it is that of the
//! only node that was reset since and did not boot; without such a node a new node-ID is simply a new node.

use super::withheld::Withheld;
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::checks::limits::BOOT_NS;
use crate::rules::lss::Lss005;
use crate::wire::nmt::RESET_COMMUNICATION;
use crate::world::context::Context;

/// A slave's previous node-ID.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Before {
    /// Unknown.
    #[default]
    Unknown,
    /// None.
    Unconfigured,
    /// Its node-ID.
    Node(u8),
}

/// A node-ID accepted by a slave.
#[derive(Debug)]
struct NodeIdChange {
    /// The slave's confirmation.
    at: FrameRef,
    /// The selection in which it was assigned; a later one to the same slave replaces it.
    selection: u64,
    before: Before,
    to: u8,
    stored: bool,
    /// It may be in effect because the slave has left the configuration state or nodes were reset.
    active: bool,
    /// The frame from which on a boot-up is expected, and the deadline in ns.
    expected: Option<(FrameRef, Ns)>,
    /// The nodes that were reset one by one since and have not booted, one bit each.
    reset: u128,
}

/// The node-IDs assigned on a bus.
#[derive(Debug, Default)]
pub struct NodeIds {
    /// At most one change per node-ID.
    changes: Vec<NodeIdChange>,
    /// The node-ID last requested by the master.
    requested: Option<u8>,
}

impl NodeIds {
    /// Takes the master's request for a node-ID.
    pub fn request(&mut self, node: u8) {
        self.requested = Some(node);
    }

    /// Takes a slave's acceptance of the node-ID.
    pub fn accept(&mut self, before: Before, selection: u64, at: FrameRef) {
        let Some(to) = self.requested else { return };
        self.changes.retain(|change| change.to != to && change.selection != selection);
        if (1..=127).contains(&to) && before != Before::Node(to) {
            let fresh =
                NodeIdChange { at, selection, before, to, stored: false, active: false, expected: None, reset: 0 };
            self.changes.push(fresh);
        }
    }

    /// Notes that the slave of a selection has stored its configuration.
    pub fn stored(&mut self, selection: u64) {
        for change in self.changes.iter_mut().filter(|change| change.selection == selection) {
            change.stored = true;
        }
    }

    /// Takes the return of all slaves to the waiting state.
    pub fn waiting(&mut self, at: FrameRef) {
        for change in &mut self.changes {
            let new = !std::mem::replace(&mut change.active, true);
            if new && change.before == Before::Unconfigured {
                change.await_boot_up(at);
            }
        }
    }

    /// Takes an NMT reset of a node, or of all (0).
    pub fn reset(&mut self, command: u8, node: u8, at: FrameRef) {
        for change in &mut self.changes {
            let certain = node == 0 || change.before == Before::Node(node);
            if !certain && change.before != Before::Unknown {
                continue;
            }
            change.active = true;
            change.reset |= 1 << (node & 0x7F);
            if !certain {
                continue;
            }
            if command == RESET_COMMUNICATION || change.stored {
                change.await_boot_up(at);
            }
        }
    }

    /// Takes a boot-up; returns the node's previous node-ID if it is certain and the slave has accepted the new one.
    pub fn booted(
        &mut self,
        node: u8,
        at: FrameRef,
        findings: &mut Withheld,
        cx: &mut Context<'_>,
    ) -> Option<(u8, FrameRef)> {
        if let Some(place) = self.changes.iter().position(|change| change.to == node && change.active) {
            let change = self.changes.swap_remove(place);
            return match change.before {
                Before::Node(from) => Some((from, change.at)),
                Before::Unknown if change.reset.count_ones() == 1 && change.reset != 1 => {
                    Some((change.reset.trailing_zeros() as u8, change.at))
                }
                Before::Unknown | Before::Unconfigured => None,
            };
        }
        self.changes.iter_mut().for_each(|change| change.reset &= !(1 << (node & 0x7F)));
        let old = self.changes.iter().position(|change| change.before == Before::Node(node) && change.active)?;
        let change = self.changes.swap_remove(old);
        if let Some((since, until)) = change.expected
            && at.t_ns.is_some_and(|now| now <= until)
        {
            let what = Lss005::OldNodeId { found: node.into(), expected: change.to.into() };
            findings.raise(what, Some(node), Some(since), cx);
        }
        None
    }

    /// Takes a sign of life of a node, which needs no boot-up any more.
    pub fn alive(&mut self, node: u8) {
        for change in self.changes.iter_mut().filter(|change| change.to == node) {
            change.expected = None;
        }
    }

    /// Reports nodes that should have booted by `now_ns`.
    pub fn advance(&mut self, now_ns: Ns, findings: &mut Withheld, cx: &mut Context<'_>) {
        for change in &mut self.changes {
            if let Some((since, until)) = change.expected
                && now_ns > until
            {
                change.expected = None;
                let what = Lss005::NoBootUp { node: change.to.into(), limit: BOOT_NS };
                findings.raise_timed(what, Some(change.to), Some(since), cx);
            }
        }
    }

    /// Returns the time of the next deadline, in ns.
    pub fn due(&self) -> Option<Ns> {
        self.changes.iter().filter_map(|change| Some(change.expected?.1)).min()
    }

    /// Drops expected boot-ups after lost frames.
    pub fn lost(&mut self) {
        for change in &mut self.changes {
            change.active = true;
            change.expected = None;
        }
    }
}

impl NodeIdChange {
    fn await_boot_up(&mut self, at: FrameRef) {
        if let (Some(now), None) = (at.t_ns, self.expected) {
            self.expected = Some((at, now + BOOT_NS));
        }
    }
}

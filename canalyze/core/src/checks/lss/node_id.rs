//! Node-IDs given by LSS, from the slave's confirmation until a node boots up with them (CiA 305, CiA 301 7.2.8.2).
//!
//! A slave without node-ID takes the new one as it returns to the waiting state; one that has a node-ID takes it with
//! the next reset of its communication, or as it restarts if it was stored. It must not guess which node a slave was:
//! where that is not certain a new node-ID is only a new node.

use super::withheld::Withheld;
use crate::context::Context;
use crate::frame::FrameRef;
use crate::rules::lss::Lss005;
use crate::wire::nmt::RESET_COMMUNICATION;

/// How long a node may take to boot up: 3 s. CiA 305 and CiA 301 give no limit; real nodes take well below 2 s.
const BOOT_NS: i64 = 3_000_000_000;

/// What a slave was called before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Before {
    /// Not known.
    #[default]
    Unknown,
    /// It had no node-ID.
    Unconfigured,
    /// Its node-ID.
    Node(u8),
}

/// A node-ID that a slave has accepted.
#[derive(Debug)]
struct Change {
    /// The slave's confirmation.
    at: FrameRef,
    /// The selection during which it was given: a later one to the same slave replaces it.
    selection: u64,
    before: Before,
    to: u8,
    stored: bool,
    /// It may be in effect: the slave has left the configuration state, or nodes were reset.
    active: bool,
    /// The frame from which on a boot-up is expected, and until when.
    expected: Option<(FrameRef, i64)>,
}

/// The node-IDs that were given on a bus.
#[derive(Debug, Default)]
pub struct NodeIds {
    /// At most one for each node-ID.
    changes: Vec<Change>,
    /// The node-ID that the master has requested last.
    requested: Option<u8>,
}

impl NodeIds {
    /// The master asks for a node-ID.
    pub fn request(&mut self, node: u8) {
        self.requested = Some(node);
    }

    /// A slave has accepted the node-ID.
    pub fn accept(&mut self, before: Before, selection: u64, at: FrameRef) {
        let Some(to) = self.requested else { return };
        self.changes.retain(|change| change.to != to && change.selection != selection);
        if (1..=127).contains(&to) && before != Before::Node(to) {
            let fresh = Change { at, selection, before, to, stored: false, active: false, expected: None };
            self.changes.push(fresh);
        }
    }

    /// The slave of a selection has stored its configuration.
    pub fn stored(&mut self, selection: u64) {
        for change in self.changes.iter_mut().filter(|change| change.selection == selection) {
            change.stored = true;
        }
    }

    /// All slaves return to the waiting state.
    pub fn waiting(&mut self, at: FrameRef) {
        for change in &mut self.changes {
            let new = !std::mem::replace(&mut change.active, true);
            if new && change.before == Before::Unconfigured {
                change.await_boot_up(at);
            }
        }
    }

    /// An NMT reset of a node, or of all (0).
    pub fn reset(&mut self, command: u8, node: u8, at: FrameRef) {
        for change in &mut self.changes {
            let certain = node == 0 || change.before == Before::Node(node);
            if !certain && change.before != Before::Unknown {
                continue;
            }
            change.active = true;
            if !certain {
                continue;
            }
            if command == RESET_COMMUNICATION || change.stored {
                change.await_boot_up(at);
            }
        }
    }

    /// A node boots up. Says which node it was before, where that is certain, and where the
    /// slave has accepted its new node-ID.
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
                Before::Unknown | Before::Unconfigured => None,
            };
        }
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

    /// A node shows a sign of life: it needs no boot-up any more.
    pub fn alive(&mut self, node: u8) {
        for change in self.changes.iter_mut().filter(|change| change.to == node) {
            change.expected = None;
        }
    }

    /// It is `now_ns`: who should have booted up by now.
    pub fn advance(&mut self, now_ns: i64, findings: &mut Withheld, cx: &mut Context<'_>) {
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

    /// When something becomes due, in ns.
    pub fn due(&self) -> Option<i64> {
        self.changes.iter().filter_map(|change| Some(change.expected?.1)).min()
    }

    /// Frames were lost: a boot-up may have been among them.
    pub fn lost(&mut self) {
        for change in &mut self.changes {
            change.active = true;
            change.expected = None;
        }
    }
}

impl Change {
    fn await_boot_up(&mut self, at: FrameRef) {
        if let (Some(now), None) = (at.t_ns, self.expected) {
            self.expected = Some((at, now.saturating_add(BOOT_NS)));
        }
    }
}

//! What happened on the bus that excuses others: the only place that does.
//!
//! [`EXCUSES`] is read top down: what happened, whom it concerns, which rules it voids. A breach that is
//! excused is not dropped: it is reported as a consequence, linked to the frame of what happened. It must not look for
//! what happened: whoever sees it notes it.

use std::collections::VecDeque;

use crate::frame::FrameRef;

use super::recording::Recording;
use super::when::When;

/// What happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Frames are missing from the recording, or its clock was set.
    Gap,
    /// The recorder stood still.
    Stall,
    /// The whole bus, or its recorder, paused: frames of this node, or (`None`) of several, had been expected.
    Pause,
    /// A SYNC that was missing or one too many was reported, or that none come any more.
    SyncBroken,
    /// Two SYNC producers were reported. It holds until SYNCs come as of one.
    TwoSyncProducers,
    /// A node was reported lost, or that it has not come back from a reset. It holds until the node is heard.
    NodeLost,
    /// Two nodes with one node-ID were reported.
    SharedId,
}

impl Kind {
    /// Whether it excuses what was owed since, until it is over.
    fn lasts(self) -> bool {
        matches!(self, Self::TwoSyncProducers | Self::NodeLost | Self::SharedId)
    }
}

/// What rules are about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rules {
    /// The period and the counter of SYNC.
    Sync,
    /// Synchronous PDOs in their cycles.
    SynchronousPdo,
    /// Event-driven PDOs: inhibit time, event timer, deadline.
    EventPdo,
    /// Safety-relevant data objects.
    Srdo,
    /// How long SDO answers take.
    SdoTime,
    /// Whether SDO requests are answered.
    SdoAnswer,
    /// NMT states.
    Nmt,
}

/// Whom something that happened concerns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scope {
    /// Everybody on the bus.
    Bus,
    /// Everybody but the node: what was missing of itself does not excuse it.
    Others,
    /// The node that it happened to.
    Node,
}

use Rules::{EventPdo, Nmt, SdoAnswer, SdoTime, Srdo, Sync, SynchronousPdo};

/// What excuses what: what happened, whom it concerns, which rules. A kind or a family stands here once somebody notes
/// or asks for it.
const EXCUSES: &[(Kind, Scope, &[Rules])] = &[
    (Kind::Gap, Scope::Bus, &[SynchronousPdo, EventPdo, Srdo, SdoTime]),
    (Kind::Stall, Scope::Bus, &[SynchronousPdo, EventPdo, Srdo, SdoTime]),
    (Kind::Pause, Scope::Others, &[EventPdo, Srdo, SdoTime]),
    (Kind::SyncBroken, Scope::Bus, &[SynchronousPdo]),
    (Kind::TwoSyncProducers, Scope::Bus, &[Sync, SynchronousPdo]),
    (Kind::NodeLost, Scope::Node, &[SynchronousPdo, EventPdo, Srdo, SdoTime, SdoAnswer]),
    (Kind::SharedId, Scope::Node, &[Nmt]),
];

/// Circumstances remembered.
const KEPT: usize = 64;

/// Something that happened.
#[derive(Clone, Copy, Debug)]
struct Circumstance {
    kind: Kind,
    /// The node; `None`: all.
    node: Option<u8>,
    when: When,
}

/// What happened on a bus lately.
#[derive(Debug, Default)]
pub struct Circumstances {
    past: VecDeque<Circumstance>,
}

impl Circumstances {
    /// Something has happened, to a node or (`None`) to all.
    pub fn note(&mut self, kind: Kind, node: Option<u8>, when: When) {
        if self.past.len() == KEPT {
            self.past.pop_front();
        }
        self.past.push_back(Circumstance { kind, node, when });
    }

    /// It is over: what it would excuse from here on is not excused.
    pub fn over(&mut self, kind: Kind, node: impl Into<Option<u8>>) {
        let node = node.into();
        self.past.retain(|one| one.kind != kind || one.node != node);
    }

    /// Whether it has happened lately, or holds.
    pub fn holds(&self, kind: Kind) -> bool {
        self.past.iter().any(|one| one.kind == kind)
    }

    /// The frame of the latest circumstance that excuses a breach of such rules by a node (`None`: of the bus), by what
    /// was owed since `since`.
    pub fn excuse(&self, rules: Rules, node: Option<u8>, since: When, recording: &Recording) -> Option<FrameRef> {
        let mut past = self.past.iter().rev();
        let found = past.find(|one| {
            let after = one.kind.lasts() || recording.may_precede(since, one.when);
            after && EXCUSES.iter().any(|row| one.fits(row, rules, node))
        });
        found.map(|one| one.when.at)
    }
}

impl Circumstance {
    fn fits(&self, (kind, scope, families): &(Kind, Scope, &[Rules]), rules: Rules, node: Option<u8>) -> bool {
        let concerned = match scope {
            Scope::Bus => true,
            Scope::Node => self.node == node,
            Scope::Others => self.node.is_none() || self.node != node,
        };
        *kind == self.kind && concerned && families.contains(&rules)
    }
}

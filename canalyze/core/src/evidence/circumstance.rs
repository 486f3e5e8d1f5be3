//! What happened on the bus that excuses others: the only place that does.
//!
//! [`EXCUSES`] is read top down: what happened, whom it concerns, which rules it voids, for how long. A breach that is
//! excused is not dropped: it is reported as a consequence, linked to the frame of what happened. It must not look for
//! what happened: whoever sees it notes it.

use std::collections::VecDeque;

use crate::frame::FrameRef;

use super::recording::Recording;
use super::when::When;

/// What happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Frames are missing from the recording.
    Gap,
    /// The recorder stood still.
    Stall,
    /// The whole bus, or its recorder, paused: frames of this node, or (`None`) of several, had been due.
    Pause,
    /// A node, or all, was reset or booted.
    Reset,
    /// A node, or all, was stopped or sent to Pre-operational.
    Stopped,
    /// A frame of NMT, SDO or error control could not be read.
    Unreadable,
    /// The bit timing of the bus was switched (LSS).
    BitTiming,
    /// An object that times or identifiers depend on was written.
    Reconfigured,
    /// The bus was switched on.
    PowerUp,
    /// A node was reported lost, or its node-ID as used twice.
    NodeLost,
    /// Two SYNC producers, or none any more, were reported.
    SyncBroken,
}

/// What rules are about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rules {
    /// Heartbeats and node guarding.
    ErrorControl,
    /// Boot-ups, states, commands.
    Nmt,
    /// SYNC itself.
    Sync,
    /// Synchronous PDOs in their cycles.
    SynchronousPdo,
    /// Event-driven PDOs: inhibit time, event timer, deadline.
    EventPdo,
    /// SDO transfers.
    Sdo,
    /// Safety-relevant data objects.
    Srdo,
    /// Emergencies.
    Emcy,
    /// Layer setting services.
    Lss,
    /// CiA 402 drives.
    Drive,
}

/// Whom something that happened concerns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scope {
    /// Everybody on the bus.
    Bus,
    /// The node that it happened to; all, where it happened to all.
    Node,
    /// Everybody but the node: what was missing of itself excuses it not.
    Others,
}

use Rules::{Drive, Emcy, ErrorControl, EventPdo, Lss, Nmt, Sdo, Srdo, Sync, SynchronousPdo};

/// Every family of rules.
const ALL: &[Rules] = &[ErrorControl, Nmt, Sync, SynchronousPdo, EventPdo, Sdo, Srdo, Emcy, Lss, Drive];

/// What excuses what: what happened, whom it concerns, which rules, and for how long at most in ns.
const EXCUSES: &[(Kind, Scope, &[Rules], i64)] = &[
    (Kind::Gap, Scope::Bus, ALL, 0),
    (Kind::BitTiming, Scope::Bus, ALL, 5_000_000_000),
    (Kind::Stall, Scope::Bus, &[ErrorControl, Sync, SynchronousPdo, EventPdo, Srdo, Drive, Lss], 0),
    (Kind::Pause, Scope::Others, &[EventPdo, Srdo], 0),
    (Kind::PowerUp, Scope::Bus, &[Nmt, ErrorControl], 5_000_000_000),
    (Kind::Reset, Scope::Node, ALL, i64::MAX),
    (Kind::Stopped, Scope::Node, &[SynchronousPdo, EventPdo, Sdo, Srdo, Emcy, Drive], i64::MAX),
    (Kind::Unreadable, Scope::Bus, &[Nmt, ErrorControl, Sync, Sdo, Lss], 1_000_000_000),
    (Kind::Reconfigured, Scope::Node, &[SynchronousPdo, EventPdo, ErrorControl, Sync, Srdo], i64::MAX),
    (Kind::NodeLost, Scope::Node, ALL, i64::MAX),
    (Kind::SyncBroken, Scope::Bus, &[Sync, SynchronousPdo], i64::MAX),
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

    /// The frame of the latest circumstance that excuses a breach of such rules by a node (`None`: of the bus), by what
    /// was owed since `since` and was not there at `now`.
    pub fn excuse(
        &self,
        rules: Rules,
        node: Option<u8>,
        (since, now): (When, When),
        recording: &Recording,
    ) -> Option<FrameRef> {
        let mut past = self.past.iter().rev();
        let found = past.find(|one| {
            let after = recording.may_precede(since, one.when);
            after && EXCUSES.iter().any(|row| one.fits(row, rules, node, now, recording))
        });
        found.map(|one| one.when.at)
    }
}

impl Circumstance {
    fn fits(
        &self,
        (kind, scope, families, for_ns): &(Kind, Scope, &[Rules], i64),
        rules: Rules,
        node: Option<u8>,
        now: When,
        recording: &Recording,
    ) -> bool {
        let concerned = match scope {
            Scope::Bus => true,
            Scope::Node => self.node.is_none() || node.is_none() || self.node == node,
            Scope::Others => self.node.is_none() || self.node != node,
        };
        // 0: whatever was owed across it.
        let lasts = *for_ns == 0 || !recording.certainly_later(now, self.when, *for_ns);
        *kind == self.kind && concerned && families.contains(&rules) && lasts
    }
}

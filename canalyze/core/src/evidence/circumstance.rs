//! Circumstances on the bus that excuse breaches of rules; the only place that excuses any.
//!
//! [`EXCUSES`] has a row for each: the circumstance, its scope, and the rules that it suspends. An excused breach is
//! not dropped: it is reported as a consequence, linked to the frame of the circumstance. Circumstances are noted by
//! the code that detects them.
//!
//! Only a certain breach is excused. Rules without a row need none, since these circumstances leave them no certain
//! breach, and a row could only turn a verdict that holds into a consequence:
//!
//! | rules | behind a hole or in a new recording | in stalls, pauses and steps of the clock |
//! |---|---|---|
//! | HBT, GRD | nothing is owed until the node is heard again | ages are bounds (`Recording::certainly_later`); a deadline that falls into a silence of the whole bus begins again at its end (`Recording::silence`, `was_silent`) |
//! | EMC | active errors remain; no age is known across it | ages are bounds (`Recording::certainly_within`) |
//! | LSS | selections, scans and open requests are unknown | nothing is overdue in a burst of the recorder |
//! | TIM | no age is known across it | ages are bounds; a silence that was not recorded begins anew |
//! | SYN, its period | the next gap is skipped | the phase of later SYNCs decides (`checks::sync::period`) |
//! | SDO, structure | the state of the channel is unknown (`sdo::hypotheses`) | the order alone is judged |
//! | DRV | states and controlwords are unknown | ages are bounds |
//!
//! Two more circumstances link a finding of any rule when it is reported: frames that the recorder lost one by one
//! (`Recording::explain_by_losses`), and a node whose loss is reported while the finding waits (`Pending`).

use std::collections::VecDeque;

use crate::bytes::frame::FrameRef;

use super::recording::Recording;
use super::when::When;

/// The kinds of circumstances.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CircumstanceKind {
    /// Frames are missing from the recording, or its clock was set.
    Gap,
    /// The recorder stalled.
    Stall,
    /// The whole bus, or its recorder, paused while frames of this node, or (`None`) of several, were due.
    Pause,
    /// A missing or surplus SYNC was reported, or no more SYNCs come.
    SyncBroken,
    /// Two SYNC producers were reported. Lasts until the SYNCs are those of one.
    TwoSyncProducers,
    /// A node was reported lost, or not back from a reset. Lasts until a frame of the node.
    NodeLost,
    /// Two nodes with one node-ID were reported.
    SharedId,
    /// Two PDOs of this and another node with one identifier were reported. Lasts until they have two.
    SharedIdentifier,
}

impl CircumstanceKind {
    /// Returns true if it excuses everything due since, until it is over.
    fn lasts(self) -> bool {
        matches!(self, Self::TwoSyncProducers | Self::NodeLost | Self::SharedId | Self::SharedIdentifier)
    }
}

/// Groups of rules.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rules {
    /// The period and the counter of SYNC.
    Sync,
    /// Synchronous PDOs in their cycles.
    SynchronousPdo,
    /// Event-driven PDOs: inhibit time, event timer, deadline.
    EventPdo,
    /// The length of PDOs.
    PdoLength,
    /// Safety-relevant data objects.
    Srdo,
    /// Response times of SDO.
    SdoTime,
    /// Unanswered SDO requests.
    SdoAnswer,
    /// NMT states.
    Nmt,
    /// A gap in which a node was lost that may be the producer of SYNC.
    SyncGap,
}

/// The scope of a circumstance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scope {
    /// Everything on the bus.
    Bus,
    /// Everything except the node, which its own missing frames do not excuse.
    Others,
    /// The affected node.
    Node,
}

use Rules::{EventPdo, Nmt, PdoLength, SdoAnswer, SdoTime, Srdo, Sync, SyncGap, SynchronousPdo};

/// The excuses: circumstance, scope, rules. A kind or group is listed once it is noted or asked for.
const EXCUSES: &[(CircumstanceKind, Scope, &[Rules])] = &[
    (CircumstanceKind::Gap, Scope::Bus, &[SynchronousPdo, EventPdo, Srdo, SdoTime, SdoAnswer, Nmt]),
    (CircumstanceKind::Stall, Scope::Bus, &[SynchronousPdo, EventPdo, Srdo, SdoTime]),
    (CircumstanceKind::Pause, Scope::Others, &[EventPdo, Srdo, SdoTime, Nmt]),
    (CircumstanceKind::SyncBroken, Scope::Bus, &[SynchronousPdo]),
    (CircumstanceKind::TwoSyncProducers, Scope::Bus, &[Sync, SynchronousPdo]),
    (CircumstanceKind::NodeLost, Scope::Node, &[SynchronousPdo, EventPdo, Srdo, SdoTime, SdoAnswer]),
    (CircumstanceKind::NodeLost, Scope::Bus, &[SyncGap]),
    (CircumstanceKind::SharedId, Scope::Node, &[Nmt]),
    (CircumstanceKind::SharedIdentifier, Scope::Node, &[SynchronousPdo, EventPdo, PdoLength]),
];

/// Maximum number of remembered circumstances.
const KEPT: usize = 64;

/// One circumstance.
#[derive(Clone, Copy, Debug)]
struct Circumstance {
    kind: CircumstanceKind,
    /// The node; `None` for all.
    node: Option<u8>,
    when: When,
}

/// The recent circumstances on a bus.
#[derive(Debug, Default)]
pub struct Circumstances {
    past: VecDeque<Circumstance>,
}

impl Circumstances {
    /// Notes a circumstance of a node or (`None`) of all.
    pub fn note(&mut self, kind: CircumstanceKind, node: Option<u8>, when: When) {
        if self.past.len() == KEPT {
            self.past.pop_front();
        }
        self.past.push_back(Circumstance { kind, node, when });
    }

    /// Ends a circumstance; it excuses nothing from here on.
    pub fn over(&mut self, kind: CircumstanceKind, node: impl Into<Option<u8>>) {
        let node = node.into();
        self.past.retain(|one| one.kind != kind || one.node != node);
    }

    /// Returns the frame of the first circumstance that was noted after a frame, is not over, and excuses a breach of such
    /// rules by the bus.
    pub fn first_excuse(&self, rules: Rules, since: FrameRef) -> Option<FrameRef> {
        self.past.iter().find(|one| one.when.at.no > since.no && one.excuses(rules, None)).map(|one| one.when.at)
    }

    /// Returns true if a circumstance is recent or lasts.
    pub fn holds(&self, kind: CircumstanceKind) -> bool {
        self.past.iter().any(|one| one.kind == kind)
    }

    /// Returns the frame of the latest circumstance that excuses a breach of such rules by a node (`None`: by the bus)
    /// of an obligation between two frames. Those that last excuse it whenever they are noted.
    pub fn excuse(
        &self,
        rules: Rules,
        node: Option<u8>,
        (since, until): (When, FrameRef),
        recording: &Recording,
    ) -> Option<FrameRef> {
        let mut past = self.past.iter().rev();
        let found = past.find(|one| {
            let between = recording.may_precede(since, one.when) && one.when.at.no <= until.no;
            let concerns = one.kind.lasts() || between;
            concerns && one.excuses(rules, node)
        });
        found.map(|one| one.when.at)
    }
}

impl Circumstance {
    fn excuses(&self, rules: Rules, node: Option<u8>) -> bool {
        EXCUSES.iter().any(|row| self.fits(row, rules, node))
    }

    fn fits(
        &self,
        (kind, scope, families): &(CircumstanceKind, Scope, &[Rules]),
        rules: Rules,
        node: Option<u8>,
    ) -> bool {
        let concerned = match scope {
            Scope::Bus => true,
            Scope::Node => self.node == node,
            Scope::Others => self.node.is_none() || self.node != node,
        };
        *kind == self.kind && concerned && families.contains(&rules)
    }
}

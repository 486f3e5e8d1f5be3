//! What a node may do in its NMT state (CiA 301, 7.3.2.2): SDO and EMCY not in Stopped, PDOs only in Operational,
//! nothing but the boot-up before the boot-up.
//!
//! Only a state that is known judges (`nmt`), and what was under way when the state changed is no fault. Each fault is
//! reported once as long as the node stays in a state. It must not move states.

use super::{KnownState, Nmt, OBEYED_NS};
use crate::context::Context;
use crate::evidence::duplicates::Sighting;
use crate::finding::{Code, Finding};
use crate::frame::FrameRef;
use crate::node::PerNode;
use crate::rules::emcy::Emc004;
use crate::rules::pdo::{Pdo002, Pdo003};
use crate::rules::sdo::Sdo011;
use crate::services::pdo::communication_parameter;
use crate::services::sdo::wire::{Mux, Side};
use crate::wire::error_control::{OPERATIONAL, STOPPED};

/// What a node had queued when it showed a new state or, of TPDOs, received a command, in ns.
const QUEUED_NS: i64 = 5_000_000;
/// The same where the bus was idle just before: what is queued is sent at once.
const PROCESSED_NS: i64 = 2_000_000;
const IDLE_NS: i64 = 1_500_000;
/// Faults of one node whose state is not certain that are kept at most.
const KEPT: usize = 8;

/// The time that a node spends in a state.
#[derive(Debug, Default)]
struct StatePeriod {
    /// 0: none.
    state: u8,
    /// What was reported. Of several PDOs one is enough: it is the state that is wrong.
    reported: Vec<Code>,
    /// The last SDO request.
    request: Option<FrameRef>,
    /// The same where it is a fault by itself, unless a late command permits it.
    vain: Option<FrameRef>,
    /// What a node has sent whose state is not certain, since it may have started itself or not obeyed a command:
    /// the next state it shows decides.
    undecided: Vec<(u8, Finding)>,
    /// An SDO response or EMCY after a reset: the boot-up decides whether it came before it.
    early: Option<Finding>,
}

/// Verdicts on what nodes send in their states.
#[derive(Debug, Default)]
pub struct NmtPermissions {
    nodes: PerNode<StatePeriod>,
}

impl NmtPermissions {
    /// A PDO of a node.
    #[inline]
    pub fn pdo(&mut self, nmt: &Nmt, transmit: bool, number: u16, node: u8, cx: &mut Context<'_>) {
        if nmt.state(node).is_some_and(|state| state != OPERATIONAL) {
            self.pdo_outside(nmt, transmit, number, node, cx);
        }
    }

    fn pdo_outside(&mut self, nmt: &Nmt, transmit: bool, number: u16, node: u8, cx: &mut Context<'_>) {
        let Some(known) = nmt.known(node) else { return };
        let (pdo, state) = ((transmit, number), known.state);
        let object = Some(Mux { index: communication_parameter(transmit, number), sub: 1 });
        let (queued, finding) = if transmit {
            let finding = cx.verdict(Pdo002::InState { pdo, state }, Some(node), object, None);
            let limit = if cx.when.silent_ns < IDLE_NS { QUEUED_NS } else { PROCESSED_NS };
            (is_within(known, limit, cx), finding)
        } else {
            (is_under_way(known, cx), cx.verdict(Pdo003::InState { pdo, state }, Some(node), object, None))
        };
        if queued || cx.sighting == Sighting::Suspect || !self.period(node, known).is_first(finding.code) {
            return;
        }
        // Without commands a node may have started itself.
        let doubtful = known.doubtful || transmit && (known.may_start_itself || !nmt.commanded());
        self.judge(nmt, KnownState { doubtful, ..known }, finding, cx);
    }

    /// A frame of a node's default SDO channel.
    pub fn sdo(&mut self, nmt: &Nmt, side: Side, node: u8, cx: &mut Context<'_>) {
        let answered = side == Side::Server;
        let known = nmt.known(node).filter(|known| known.state == STOPPED);
        let vain = known.is_some_and(|known| known.shown && !is_under_way(known, cx));
        let request = self.nodes.get(node).and_then(|period| period.request);
        if !answered {
            let period = self.nodes.entry(node);
            (period.request, period.vain) = (Some(cx.at), vain.then_some(cx.at));
        } else if let Some(reset) = nmt.silent_since_reset(node)
            && request.is_some_and(|request| request.no > reset.no)
        {
            // An answer to what was asked after the reset: not one that was under way.
            self.early(reset, cx.verdict(Sdo011::BeforeBootUp, Some(node), None, None), cx);
        }
        let Some(known) = known else { return };
        let asked = !answered || request.is_some_and(|request| request.no > known.at.no);
        if !asked || is_under_way(known, cx) || !(answered || vain) || !self.period(node, known).is_first(Code::Sdo011)
        {
            return;
        }
        let state = known.state;
        let what = if answered { Sdo011::Response { state } } else { Sdo011::Request { state } };
        self.judge(nmt, known, cx.verdict(what, Some(node), None, None), cx);
    }

    /// The last SDO request to a node, where it is a fault by itself: that it is not answered only follows from that.
    pub fn asked_in_vain(&self, node: u8) -> Option<FrameRef> {
        self.nodes.get(node)?.vain
    }

    /// An emergency of a node.
    pub fn emergency(&mut self, nmt: &Nmt, node: u8, cx: &mut Context<'_>) {
        if let Some(reset) = nmt.silent_since_reset(node) {
            self.early(reset, cx.verdict(Emc004::BeforeBootUp, Some(node), None, None), cx);
        }
        let Some(known) = nmt.known(node).filter(|known| known.state == STOPPED) else { return };
        if !is_under_way(known, cx) && self.period(node, known).is_first(Code::Emc004) {
            self.judge(nmt, known, cx.verdict(Emc004::InState { state: known.state }, Some(node), None, None), cx);
        }
    }

    /// Keeps the first finding on what a node has sent after a reset and before its boot-up.
    fn early(&mut self, reset: FrameRef, finding: Finding, cx: &Context<'_>) {
        let age = reset.t_ns.zip(cx.at.t_ns).map(|(reset, now)| now.saturating_sub(reset));
        if let (Some(node), Some(OBEYED_NS..)) = (finding.node, age) {
            self.nodes.entry(node).early.get_or_insert(finding);
        }
    }

    /// A command to go to a state, 0 where it is none: what came just before it may have been permitted by it.
    pub fn command(&mut self, node: u8, state: u8, cx: &mut Context<'_>) {
        for (id, period) in self.nodes.iter_mut().filter(|(id, _)| node == 0 || node == *id) {
            let voided = |finding: &Finding| finding.node == Some(id) && is_permitted(finding.code, state);
            // What is dropped here may come again, and is a fault then.
            period.leave_for(if cx.evidence.pending.withdraw(voided) { 0 } else { state });
            period.vain = period.vain.filter(|request| cx.evidence.recording.is_settled(*request, cx.at));
        }
    }

    /// A boot-up: what came between the reset and it, came too early.
    pub fn boot_up(&mut self, node: u8, cx: &mut Context<'_>) {
        let Some(period) = self.nodes.get_mut(node) else { return };
        period.leave_for(0);
        period.undecided.clear();
        if let Some(early) = period.early.take() {
            cx.report(early);
        }
    }

    /// A node shows its state. `changes`: it does so before its next heartbeat is expected, since it has just gone to that
    /// state; what it sent shortly before, it sent in the state before.
    pub fn shown(&mut self, node: u8, state: u8, changes: bool, cx: &mut Context<'_>) {
        let Some(period) = self.nodes.get_mut(node) else { return };
        period.leave_for(state);
        for (supposed, undecided) in std::mem::take(&mut period.undecided) {
            let before = changes && cx.at.since(undecided.at).is_some_and(|age| age < OBEYED_NS);
            if state == supposed && !before {
                cx.report(undecided);
                continue;
            }
            // What is dropped here may come again, and is a fault then.
            period.state = 0;
            if undecided.code == Code::Sdo011 {
                period.vain = None;
            }
        }
    }

    /// Frames were lost, a command may be among them.
    pub fn forget(&mut self) {
        *self = Self::default();
    }

    fn period(&mut self, node: u8, known: KnownState) -> &mut StatePeriod {
        let period = self.nodes.entry(node);
        if period.state != known.state {
            period.state = known.state;
            period.reported.clear();
        }
        period
    }

    /// A node that was commanded and shows its states may not have obeyed: then it is the command that failed. And
    /// where one heartbeat alone shows a state that was not commanded, it is that heartbeat.
    fn judge(&mut self, nmt: &Nmt, known: KnownState, finding: Finding, cx: &mut Context<'_>) {
        let Some(node) = finding.node else { return };
        if !known.doubtful && (known.shown || !nmt.shows(node)) {
            return cx.report_listed(finding);
        }
        let undecided = &mut self.nodes.entry(node).undecided;
        if undecided.len() < KEPT {
            undecided.push((known.state, finding));
        }
    }
}

impl StatePeriod {
    /// Whether a rule is broken for the first time in the state.
    fn is_first(&mut self, code: Code) -> bool {
        let first = !self.reported.contains(&code);
        if first {
            self.reported.push(code);
        }
        first
    }

    /// The node goes to a state, or is asked to: what it does there is reported again, unless it is in it already.
    fn leave_for(&mut self, state: u8) {
        if self.state != state {
            self.state = 0;
        }
    }
}

/// Whether a command to go to a state, 0 where it is a reset, may permit what would be a fault before it.
fn is_permitted(code: Code, state: u8) -> bool {
    match code {
        Code::Pdo002 | Code::Pdo003 => state == OPERATIONAL,
        Code::Sdo011 | Code::Emc004 => state != STOPPED,
        _ => false,
    }
}

/// Whether a frame may have been under way when the state changed.
fn is_under_way(known: KnownState, cx: &Context<'_>) -> bool {
    is_within(known, if known.shown { QUEUED_NS } else { OBEYED_NS }, cx)
}

/// Whether a frame may have been sent within `limit_ns` of the change of state. Without stamps only what a node has
/// shown counts.
fn is_within(known: KnownState, limit_ns: i64, cx: &Context<'_>) -> bool {
    let (earliest, _) = cx.evidence.recording.interval(cx.when);
    match known.at.t_ns.filter(|_| cx.at.t_ns.is_some()) {
        Some(known_ns) => earliest.saturating_sub(known_ns) < limit_ns,
        None => !known.shown,
    }
}

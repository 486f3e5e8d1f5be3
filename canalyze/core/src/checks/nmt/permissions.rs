//! Services permitted in an NMT state (CiA 301, 7.3.2.2): no SDO and EMCY in Stopped, PDOs only in Operational, nothing
//! before the boot-up.
//!
//! Only known states judge (`nmt`), and frames on their way during a change are no fault. Each fault is reported once
//! per stay in a state.

use super::{KnownState, Nmt, OBEYED_NS};
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::evidence::duplicates::Sighting;
use crate::rules::emcy::Emc004;
use crate::rules::finding::{Code, Finding};
use crate::rules::pdo::{Pdo002, Pdo003};
use crate::rules::sdo::Sdo011;
use crate::sdo::wire::{Mux, Side};
use crate::wire::error_control::{OPERATIONAL, STOPPED};
use crate::wire::pdo::communication_parameter;
use crate::world::context::Context;
use crate::world::node::PerNode;

/// Time in which queued frames follow a reported state or, for TPDOs, a command, in ns.
const QUEUED_NS: Ns = Ns::from_ms(5);
/// The same on an idle bus, where queued frames are sent at once.
const PROCESSED_NS: Ns = Ns::from_ms(2);
const IDLE_NS: Ns = Ns::from_us(1_500);
/// Maximum number of kept faults of a node whose state is uncertain.
const KEPT: usize = 8;
/// Maximum number of TPDOs between a boot-up and the start command of a node that has not started itself: one that has
/// sends more.
const EARLY: u32 = 5;

/// A node's stay in a state.
#[derive(Debug, Default)]
struct StatePeriod {
    /// The state; 0 is none.
    state: u8,
    /// The reported rules; one PDO is enough, because the state is wrong.
    reported: Vec<Code>,
    /// The last SDO request.
    request: Option<FrameRef>,
    /// The last SDO request if it is a fault by itself, unless a late command permits it.
    vain: Option<FrameRef>,
    /// Faults of a node that may have started itself or not obeyed a command; the next reported state decides.
    undecided: Vec<(u8, Finding)>,
    /// Number of TPDOs outside Operational since the boot-up.
    sent: u32,
    /// PDOs outside Operational by the node's last report; the next one decides if a command is missing in the capture.
    waiting: Vec<Finding>,
    /// An SDO response or EMCY after a reset; the boot-up decides if it came before that.
    early: Option<Finding>,
}

/// Verdicts on the frames of nodes in their states.
#[derive(Debug, Default)]
pub struct NmtPermissions {
    nodes: PerNode<StatePeriod>,
}

impl NmtPermissions {
    /// Takes a PDO of a node.
    #[inline]
    pub fn pdo(&mut self, nmt: &Nmt, transmit: bool, number: u16, node: u8, cx: &mut Context<'_>) {
        if nmt.state(node).map_or(transmit, |state| state != OPERATIONAL) {
            self.pdo_outside(nmt, transmit, number, node, cx);
        }
    }

    fn pdo_outside(&mut self, nmt: &Nmt, transmit: bool, number: u16, node: u8, cx: &mut Context<'_>) {
        let Some(known) = nmt.known(node) else { return };
        if transmit {
            let sent = &mut self.nodes.entry(node).sent;
            *sent = sent.saturating_add(1);
        }
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
        // A node that was reported for not having started may have done so since.
        let because_of = known.not_started.filter(|_| transmit);
        self.judge(nmt, KnownState { doubtful, ..known }, Finding { because_of, ..finding }, cx);
    }

    /// Takes a frame of a node's default SDO channel.
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
            // The answer to a request after the reset was not on its way before it.
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

    /// Returns the last SDO request to a node if it is a fault by itself, which explains its missing answer.
    pub fn asked_in_vain(&self, node: u8) -> Option<FrameRef> {
        self.nodes.get(node)?.vain
    }

    /// Takes an emergency of a node.
    pub fn emergency(&mut self, nmt: &Nmt, node: u8, cx: &mut Context<'_>) {
        if let Some(reset) = nmt.silent_since_reset(node) {
            self.early(reset, cx.verdict(Emc004::BeforeBootUp, Some(node), None, None), cx);
        }
        let Some(known) = nmt.known(node).filter(|known| known.state == STOPPED) else { return };
        if !is_under_way(known, cx) && self.period(node, known).is_first(Code::Emc004) {
            self.judge(nmt, known, cx.verdict(Emc004::InState { state: known.state }, Some(node), None, None), cx);
        }
    }

    /// Keeps the first finding on a frame between a reset and the boot-up.
    fn early(&mut self, reset: FrameRef, finding: Finding, cx: &Context<'_>) {
        let age = reset.t_ns.zip(cx.at.t_ns).map(|(reset, now)| now - reset);
        if let Some(node) = finding.node.filter(|_| age.is_some_and(|age| age >= OBEYED_NS)) {
            self.nodes.entry(node).early.get_or_insert(finding);
        }
    }

    /// Takes a command to a state, or 0; it may have permitted the frames just before it.
    pub fn command(&mut self, nmt: &Nmt, node: u8, state: u8, cx: &mut Context<'_>) {
        for (id, period) in self.nodes.iter_mut().filter(|(id, _)| node == 0 || node == *id) {
            for finding in std::mem::take(&mut period.waiting) {
                // A later command is not the one that would have permitted it.
                if cx.evidence.recording.is_settled(finding.at, cx.at) || !is_permitted(finding.code, state) {
                    cx.report(finding);
                } else {
                    period.state = 0;
                }
            }
            let voided = |finding: &Finding| finding.node == Some(id) && is_permitted(finding.code, state);
            // A withdrawn fault may occur again, and is reported then.
            period.leave_for(if cx.evidence.pending.withdraw(voided) { 0 } else { state });
            period.vain = period.vain.filter(|request| cx.evidence.recording.is_settled(*request, cx.at));
            if state == OPERATIONAL && !nmt.shows(id) {
                period.started(cx);
            }
        }
    }

    /// Takes a boot-up: frames between the reset and it came too early.
    pub fn boot_up(&mut self, node: u8, cx: &mut Context<'_>) {
        let Some(period) = self.nodes.get_mut(node) else { return };
        period.waiting.drain(..).for_each(|waiting| cx.report(waiting));
        period.leave_for(0);
        period.undecided.clear();
        period.sent = 0;
        if let Some(early) = period.early.take() {
            cx.report(early);
        }
    }

    /// Takes a reported state. `changes`: the report precedes the next expected heartbeat, so the state has just
    /// changed, and frames shortly before belong to the previous one.
    pub fn shown(&mut self, node: u8, state: u8, changes: bool, cx: &mut Context<'_>) {
        let Some(period) = self.nodes.get_mut(node) else { return };
        period.leave_for(state);
        for waiting in std::mem::take(&mut period.waiting) {
            if is_permitted(waiting.code, state) {
                period.state = 0;
            } else {
                cx.report(waiting);
            }
        }
        for (supposed, undecided) in std::mem::take(&mut period.undecided) {
            let before = changes && cx.at.since(undecided.at).is_some_and(|age| age < OBEYED_NS);
            if state == supposed && !before {
                cx.report(undecided);
                continue;
            }
            // A dropped fault may occur again, and is reported then.
            period.state = 0;
            if undecided.code == Code::Sdo011 {
                period.vain = None;
            }
        }
    }

    /// Reports the PDOs that no report of the node's state has followed, at the end of the capture.
    pub fn finish(&mut self, cx: &mut Context<'_>) {
        for (_, period) in self.nodes.iter_mut() {
            period.waiting.drain(..).for_each(|waiting| cx.report(waiting));
        }
    }

    /// Forgets everything after lost frames, which may include a command.
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

    /// Reports or keeps a finding. A commanded node that reports its states may not have obeyed, so that the command
    /// failed; and a single heartbeat with an uncommanded state may itself be wrong.
    fn judge(&mut self, nmt: &Nmt, known: KnownState, finding: Finding, cx: &mut Context<'_>) {
        let Some(node) = finding.node else { return };
        if !known.doubtful && known.shown && matches!(finding.code, Code::Pdo002 | Code::Pdo003) {
            // A command may be missing in the capture; the node's next report tells.
            return self.nodes.entry(node).waiting.push(finding);
        }
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
    /// Returns true if a rule is broken for the first time in the state.
    fn is_first(&mut self, code: Code) -> bool {
        let first = !self.reported.contains(&code);
        if first {
            self.reported.push(code);
        }
        first
    }

    /// Takes the start command of a node that reports no states: it has not started itself if it sent few TPDOs.
    fn started(&mut self, cx: &mut Context<'_>) {
        let few = self.sent <= EARLY;
        for (_, finding) in std::mem::take(&mut self.undecided) {
            if few && finding.code == Code::Pdo002 && cx.evidence.recording.is_settled(finding.at, cx.at) {
                cx.report_listed(finding);
            }
        }
    }

    /// Takes a change, or command, to a state: faults are reported again unless it is the present state.
    fn leave_for(&mut self, state: u8) {
        if self.state != state {
            self.state = 0;
        }
    }
}

/// Returns true if a command to a state (0 for a reset) may permit the fault before it.
fn is_permitted(code: Code, state: u8) -> bool {
    match code {
        Code::Pdo002 | Code::Pdo003 => state == OPERATIONAL,
        Code::Sdo011 | Code::Emc004 => state != STOPPED,
        _ => false,
    }
}

/// Returns true if a frame may have been on its way when the state changed.
fn is_under_way(known: KnownState, cx: &Context<'_>) -> bool {
    is_within(known, if known.shown { QUEUED_NS } else { OBEYED_NS }, cx)
}

/// Returns true if a frame may have been sent within `limit_ns` of the change of state. Without stamps only reported
/// states count.
fn is_within(known: KnownState, limit_ns: Ns, cx: &Context<'_>) -> bool {
    let (earliest, _) = cx.evidence.recording.interval(cx.when);
    match known.at.t_ns.filter(|_| cx.at.t_ns.is_some()) {
        Some(known_ns) => earliest - known_ns < limit_ns,
        None => !known.shown,
    }
}

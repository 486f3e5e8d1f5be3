//! What a node may do in its NMT state (CiA 301, 7.3.2.2): SDO and EMCY not in Stopped, PDOs only in Operational,
//! nothing but the boot-up before the boot-up.
//!
//! Only a state that is known judges (`nmt`), and what was under way when the state changed is no fault. Each fault is
//! said once as long as the node stays in a state. It must not move states.

use super::nmt::{Known, Nmt, since};
use crate::context::Context;
use crate::evidence::duplicates::Sighting;
use crate::evidence::recording::Verdict;
use crate::finding::{Code, Facts, Quantity};
use crate::frame::FrameRef;
use crate::node::PerNode;
use crate::services::heartbeat::{OPERATIONAL, STOPPED};
use crate::services::pdo::communication_parameter;
use crate::services::sdo::wire::{Mux, Side};

/// What a node had queued when it showed a new state or, of TPDOs, received a command, in ns.
const QUEUED_NS: i64 = 5_000_000;
/// What else a node does before it obeys a command, and what others send it meanwhile, in ns.
const OBEYED_NS: i64 = 50_000_000;
/// How long the command that permits something may be captured after it, in ns.
const SETTLED_NS: i64 = 10_000_000;
/// The same in frames, where there are no stamps.
const LATE: u64 = 2;
/// Faults of one node that wait at a time, at most.
const HELD: usize = 8;

/// A frame that a node should not have sent.
#[derive(Clone, Debug)]
struct Held {
    at: FrameRef,
    code: Code,
    object: Option<Mux>,
    facts: Facts,
    /// The burst that it is in, or 0.
    burst: u32,
}

#[derive(Debug, Default)]
struct Stay {
    /// The state that the rest is about; 0: none.
    state: u8,
    /// What was said. Of several PDOs one tells of all: it is the state that is wrong.
    tpdos: bool,
    rpdos: bool,
    sdo: bool,
    emcy: bool,
    /// The last SDO request.
    request: Option<FrameRef>,
    /// The same where it is a fault by itself, unless a late command permits it.
    vain: Option<FrameRef>,
    /// Faults that a late command may yet permit.
    held: Vec<Held>,
    /// What a node has sent whose state is not certain, since it may have started itself or not obeyed a command:
    /// the next state it shows decides.
    undecided: Vec<(u8, Held)>,
    /// An SDO response or EMCY after a reset: the boot-up decides whether it came before it.
    early: Option<Held>,
}

/// Verdicts on what nodes send in their states.
#[derive(Debug, Default)]
pub struct Permitted {
    nodes: PerNode<Stay>,
    held: usize,
}

impl Permitted {
    /// A PDO of a node.
    #[inline]
    pub fn pdo(&mut self, nmt: &Nmt, transmit: bool, number: u16, node: u8, cx: &Context<'_>) {
        if nmt.state(node).is_some_and(|state| state != OPERATIONAL) {
            self.pdo_outside(nmt, transmit, number, node, cx);
        }
    }

    fn pdo_outside(&mut self, nmt: &Nmt, transmit: bool, number: u16, node: u8, cx: &Context<'_>) {
        let Some(known) = nmt.known(node) else { return };
        let stay = self.stay(node, known);
        let told = if transmit { &mut stay.tpdos } else { &mut stay.rpdos };
        let queued = if transmit { queued(known, cx) } else { under_way(known, cx) };
        if *told || queued || cx.sighting == Sighting::Suspect {
            return;
        }
        *told = true;
        let facts =
            Facts::told(0, &[("pdo", Quantity::Pdo(transmit, number)), ("state", Quantity::State(known.state))]);
        let object = Some(Mux { index: communication_parameter(transmit, number), sub: 1 });
        let code = if transmit { Code::Pdo002 } else { Code::Pdo003 };
        let held = Held { at: cx.at, code, object, facts, burst: cx.when.burst };
        if known.doubtful || transmit && (known.may_start_itself || !nmt.commanded()) {
            stay.decide_later(known.state, held);
        } else {
            self.judge(nmt, node, known, held);
        }
    }

    /// A frame of a node's default SDO channel.
    pub fn sdo(&mut self, nmt: &Nmt, side: Side, node: u8, cx: &Context<'_>) {
        if side == Side::Server
            && let Some(reset) = nmt.silent_since_reset(node)
        {
            // An answer to what was asked after the reset: not one that was under way.
            let stay = self.nodes.entry(node);
            let asked_after = stay.request.is_some_and(|request| request.no > reset.no);
            if asked_after && since(Some(reset), cx.at).is_some_and(|age| age > OBEYED_NS) {
                let facts = Facts::told(2, &[]);
                stay.early = stay.early.take().or(Some(Held {
                    at: cx.at,
                    code: Code::Sdo011,
                    object: None,
                    facts,
                    burst: cx.when.burst,
                }));
            }
        }
        let request = self.nodes.get(node).and_then(|stay| stay.request);
        if side == Side::Client {
            let vain = nmt.known(node).is_some_and(|known| is_asked_in_vain(known, cx));
            let stay = self.nodes.entry(node);
            (stay.request, stay.vain) = (Some(cx.at), vain.then_some(cx.at));
        }
        let Some(known) = nmt.known(node).filter(|known| known.state == STOPPED) else { return };
        let answered = side == Side::Server;
        let asked = !answered || request.is_some_and(|request| request.no > known.at.no);
        let stay = self.stay(node, known);
        if stay.sdo || !asked || under_way(known, cx) || !(answered || is_asked_in_vain(known, cx)) {
            return;
        }
        stay.sdo = true;
        let facts = Facts::told(u8::from(answered), &[("state", Quantity::State(known.state))]);
        self.judge(nmt, node, known, Held { at: cx.at, code: Code::Sdo011, object: None, facts, burst: cx.when.burst });
    }

    /// The last SDO request to a node, where it is a fault by itself: that nobody answers it only follows from that.
    pub fn asked_in_vain(&self, node: u8) -> Option<FrameRef> {
        self.nodes.get(node)?.vain
    }

    /// An emergency of a node.
    pub fn emergency(&mut self, nmt: &Nmt, node: u8, cx: &Context<'_>) {
        if let Some(reset) = nmt.silent_since_reset(node) {
            let stay = self.nodes.entry(node);
            if since(Some(reset), cx.at).is_some_and(|age| age > OBEYED_NS) {
                let facts = Facts::told(1, &[]);
                stay.early = stay.early.take().or(Some(Held {
                    at: cx.at,
                    code: Code::Emc004,
                    object: None,
                    facts,
                    burst: cx.when.burst,
                }));
            }
        }
        let Some(known) = nmt.known(node).filter(|known| known.state == STOPPED) else { return };
        let stay = self.stay(node, known);
        if stay.emcy || under_way(known, cx) {
            return;
        }
        stay.emcy = true;
        let facts = Facts::told(0, &[("state", Quantity::State(known.state))]);
        self.judge(nmt, node, known, Held { at: cx.at, code: Code::Emc004, object: None, facts, burst: cx.when.burst });
    }

    /// A command to go to a state, 0 where it is none: what came just before it may have been permitted by it.
    pub fn command(&mut self, node: u8, state: u8, at: FrameRef) {
        let held = &mut self.held;
        for (id, stay) in self.nodes.iter_mut() {
            if node == 0 || node == id {
                // What is dropped here may come again, and is a fault then.
                stay.leave_for(if stay.held.is_empty() { state } else { 0 });
                stay.vain = stay.vain.filter(|request| is_settled(*request, at));
                *held = held.saturating_sub(stay.held.len());
                stay.held.clear();
            }
        }
    }

    /// A boot-up: what came between the reset and it, came too early.
    pub fn boot_up(&mut self, node: u8, cx: &mut Context<'_>) {
        let Some(stay) = self.nodes.get_mut(node) else { return };
        stay.leave_for(0);
        stay.undecided.clear();
        if let Some(early) = stay.early.take() {
            cx.find_at(early.at, early.code, Some(node), early.object, None, early.facts);
        }
    }

    /// A node shows its state.
    pub fn shown(&mut self, node: u8, state: u8, cx: &mut Context<'_>) {
        let Some(stay) = self.nodes.get_mut(node) else { return };
        stay.leave_for(state);
        for (supposed, undecided) in std::mem::take(&mut stay.undecided) {
            if state == supposed {
                cx.find_at(undecided.at, undecided.code, Some(node), undecided.object, None, undecided.facts);
            } else if undecided.code == Code::Sdo011 {
                stay.vain = None;
            }
        }
    }

    /// Says what no command has permitted. Called with each frame before it is followed.
    #[inline]
    pub fn settle(&mut self, cx: &mut Context<'_>) {
        if self.held > 0 {
            self.resolve(cx);
        }
    }

    fn resolve(&mut self, cx: &mut Context<'_>) {
        for (node, stay) in self.nodes.iter_mut() {
            let at = cx.at;
            while stay.held.first().is_some_and(|held| is_settled(held.at, at) && !is_open(held, cx)) {
                let held = stay.held.remove(0);
                self.held = self.held.saturating_sub(1);
                // A burst has no times of its own.
                if cx.evidence.recording.verdict(held.burst) == Some(Verdict::Confirmed) {
                    (stay.tpdos, stay.rpdos, stay.sdo, stay.emcy) = (false, false, false, false);
                    continue;
                }
                cx.find_at(held.at, held.code, Some(node), held.object, None, held.facts);
            }
        }
    }

    /// Frames were lost, a command may be among them.
    pub fn forget(&mut self) {
        *self = Self::default();
    }

    fn stay(&mut self, node: u8, known: Known) -> &mut Stay {
        let stay = self.nodes.entry(node);
        if stay.state != known.state {
            (stay.state, stay.tpdos, stay.rpdos, stay.sdo, stay.emcy) = (known.state, false, false, false, false);
        }
        stay
    }

    /// A node that was commanded and shows its states may not have obeyed: then it is the command that failed. And where
    /// one heartbeat alone shows a state that nobody has commanded, it is that heartbeat.
    fn judge(&mut self, nmt: &Nmt, node: u8, known: Known, held: Held) {
        if !known.doubtful && (known.shown || !nmt.shows(node)) {
            self.hold(node, held);
        } else {
            self.nodes.entry(node).decide_later(known.state, held);
        }
    }

    fn hold(&mut self, node: u8, held: Held) {
        let stay = self.nodes.entry(node);
        if stay.held.len() < HELD {
            stay.held.push(held);
            self.held += 1;
        }
    }
}

impl Stay {
    /// The node goes to a state, or is asked to: what it does there is told anew, unless it is in it already.
    fn leave_for(&mut self, state: u8) {
        if self.state != state {
            self.state = 0;
        }
    }

    fn decide_later(&mut self, state: u8, held: Held) {
        if self.undecided.len() < HELD {
            self.undecided.push((state, held));
        }
    }
}

/// Whether it is too late for a command that would permit what was sent in a frame.
fn is_settled(from: FrameRef, at: FrameRef) -> bool {
    match since(Some(from), at) {
        Some(age) => !(0..SETTLED_NS).contains(&age) && at.no > from.no,
        None => at.no > from.no + LATE,
    }
}

/// Whether it is not known yet whether a frame's time is its own.
fn is_open(held: &Held, cx: &Context<'_>) -> bool {
    cx.evidence.recording.verdict(held.burst) == Some(Verdict::Open)
}

/// Whether a request alone is a fault: only where the node has shown that it is stopped.
fn is_asked_in_vain(known: Known, cx: &Context<'_>) -> bool {
    known.state == STOPPED && known.shown && !under_way(known, cx)
}

/// Whether a TPDO may have been in the node's queue when the state changed.
fn queued(known: Known, cx: &Context<'_>) -> bool {
    let recording = &cx.evidence.recording;
    match since(Some(known.at), cx.at) {
        Some(age) => age.saturating_sub(recording.grain_ns()) < QUEUED_NS,
        None => !known.shown,
    }
}

/// Whether a frame may have been under way when the state changed. Without stamps only what a node has shown counts.
fn under_way(known: Known, cx: &Context<'_>) -> bool {
    let limit = if known.shown { QUEUED_NS } else { OBEYED_NS };
    let (earliest, _) = cx.evidence.recording.interval(cx.when);
    known.at.t_ns.filter(|_| cx.at.t_ns.is_some()).map_or(!known.shown, |known| earliest.saturating_sub(known) < limit)
}

//! Nodes that the master never starts, and nodes whose boot repeats endlessly (CiA 302-2, boot-up of a slave).
//!
//! A master reads 1000h and the identity of a node that has booted, configures it and starts it. A stop half way, while
//! other nodes run, is not reported on the bus and shows only at the end of the capture. A node that was started once
//! is not judged; refusals are left to `configuration`.

use std::collections::BTreeMap;

use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::problems::kinds::ProblemKind;
use crate::problems::problem::{Grade, Problem, StepRole, Subject, bit};
use crate::problems::roles::KindRole;
use crate::problems::sayings::Saying;
use crate::problems::scene::{Heard, Last, Scene};
use crate::problems::trackers::nodes::LOOP;
use crate::rules::finding::Quantity;
use crate::sdo::transfer::{Direction, Status, Transfer};
use crate::sdo::wire::Mux;

/// Time after which a node that does not run, while others do, is not about to be started, in ns.
pub(super) const WAITING_NS: Ns = Ns::from_s(5);
/// Number of reads of the device type in one boot; more of them, at least this far apart in ns, are repeated boots.
const READS: u64 = 3;
const APART_NS: Ns = Ns::from_ms(500);

/// A node that has not been started yet.
#[derive(Clone, Copy, Debug)]
struct Boot {
    /// Its boot-up, or the first read of its device type.
    begin: FrameRef,
    /// Number of its boot-ups, and the last of them.
    boots: u64,
    booted: FrameRef,
    /// Number of separate reads of 1000h, the first and the last of them.
    reads: u64,
    first: FrameRef,
    last: FrameRef,
    /// True if it has been written to.
    configured: bool,
    /// The object of the last transfer with it.
    step: Option<Mux>,
}

/// The nodes that wait for their start command.
#[derive(Clone, Debug, Default)]
pub(in crate::problems) struct Boots {
    waiting: BTreeMap<u8, Boot>,
    /// True once the NMT master has started a node.
    starts: bool,
}

impl Boots {
    /// Records a boot-up.
    pub(in crate::problems) fn booted(&mut self, node: u8, at: FrameRef) {
        let reads = self.waiting.get(&node).map_or((0, at, at), |boot| (boot.reads, boot.first, boot.last));
        let (reads, first, last) = reads;
        let (begin, boots, before) =
            self.waiting.get(&node).map_or((at, 0, at), |boot| (boot.begin, boot.boots, boot.booted));
        let boots = boots + u64::from(boots == 0 || at.since(before).is_none_or(|since| since >= APART_NS));
        let booted = at;
        let boot = Boot { begin, boots, booted, reads, first, last, configured: false, step: None };
        self.waiting.insert(node, boot);
    }

    /// Removes nodes started by the NMT master, one bit each.
    pub(in crate::problems) fn started(&mut self, nodes: u128) {
        self.starts |= nodes != 0;
        if !self.waiting.is_empty() {
            self.waiting.retain(|node, _| nodes & bit(*node) == 0);
        }
    }

    /// Processes an SDO transfer, which may be a step of a boot.
    pub(in crate::problems) fn transfer(&mut self, transfer: &Transfer, heard: &Heard) {
        let (node, at) = (transfer.node, transfer.first);
        let done = transfer.outcome.status == Status::Ok;
        let Some(mux) = transfer.mux.filter(|_| done && !heard.is_operational(node)) else { return };
        if let Some(boot) = self.waiting.get_mut(&node) {
            boot.step = Some(mux);
        }
        match transfer.direction {
            Direction::Upload if mux.index == 0x1000 => {
                let (boots, booted, reads, configured) = (0, FrameRef::default(), 0, false);
                let fresh = Boot { begin: at, boots, booted, reads, first: at, last: at, configured, step: None };
                let boot = self.waiting.entry(node).or_insert(fresh);
                if boot.reads == 0 {
                    (boot.first, boot.last, boot.reads) = (at, at, 1);
                } else if at.since(boot.last).is_some_and(|since| since >= APART_NS) {
                    (boot.last, boot.reads) = (at, boot.reads + 1);
                }
            }
            Direction::Download => {
                if let Some(boot) = self.waiting.get_mut(&node) {
                    boot.configured = true;
                }
            }
            Direction::Upload => {}
        }
    }

    /// Returns the only node in a capture without any command, if it has booted several times: the number of its boot-ups, and
    /// the first and the last of them.
    pub(in crate::problems) fn alone(&self, heard: &Heard) -> Option<(u8, u64, [FrameRef; 2])> {
        let (node, boot) = self.waiting.first_key_value().filter(|_| heard.control.no == 0)?;
        let loops = boot.boots >= LOOP && heard.known == bit(*node);
        loops.then_some((*node, boot.boots, [boot.begin, boot.booted]))
    }

    /// Reports nodes, at the end of the capture, that are present and were read, but never started while others run.
    pub(in crate::problems) fn finish(&mut self, scene: &mut Scene<'_>) {
        let running = scene.heard.operational & scene.heard.serving;
        for (node, boot) in std::mem::take(&mut self.waiting) {
            let long = scene.at.since(boot.begin).is_some_and(|since| since >= WAITING_NS);
            // A network in which SYNC goes on is meant to run, whatever else is on it.
            let cycles = scene.heard.sync.since(boot.begin).is_some_and(|since| since >= WAITING_NS);
            let of_node = |one: &&Problem| one.bus == scene.id && one.subject.concerns(node) && one.end.is_none();
            let mut open = scene.ledger.all.iter().filter(of_node);
            let commanded = open.clone().any(|one| one.kind.is(KindRole::RpdosIgnored));
            let meant_to_run = running & !bit(node) != 0 || cycles || commanded;
            let rest = scene.heard.last(node).and_then(|last| scene.at.since(last)).unwrap_or(Ns::MAX);
            // Without heartbeats a node that is not started has nothing to send.
            let here = scene
                .bus
                .heartbeat_period(node)
                .map_or(boot.boots > 0, |period| rest <= (period * 2).max(WAITING_NS / 2));
            // It has started itself: only Operational nodes send PDOs, and without heartbeats nothing else shows that.
            let sends = scene.heard.noted(Last::Pdo, node).is_some_and(|pdo| pdo.no > boot.begin.no);
            let runs = sends && scene.bus.heartbeat_period(node).is_none();
            if !long || !here || !meant_to_run || runs || scene.heard.is_operational(node) {
                continue;
            }
            // A problem since then explains why it is not Operational.
            let told = open.any(|one| !one.has("refused") && !one.kind.is(KindRole::Expected));
            // A node that restarts is read again each time.
            let is =
                |role| scene.ledger.last(scene.id, |one| one.subject.concerns(node) && one.kind.is(role)).is_some();
            let (restarted, loops) = (is(KindRole::Restart), is(KindRole::Loop));
            let stuck = boot.reads >= READS && !boot.configured && !restarted;
            if told || loops || !(stuck || boot.boots > 0 && boot.reads > 0) {
                continue;
            }
            let (kind, begin) =
                if stuck { (ProblemKind::BootStuck, boot.first) } else { (ProblemKind::NotStarted, boot.begin) };
            let Some(place) = scene.ledger.open(kind, scene.id, Subject::node(node), begin, boot.last) else { return };
            if let Some(one) = scene.ledger.get_mut(place) {
                one.grade = Grade::Likely;
                one.fact("reads", Quantity::Count(boot.reads));
                if !self.starts {
                    one.fact("started_nodes", Quantity::Count(0));
                }
                if let Some(object) = boot.step {
                    one.fact("object", Quantity::Object(object));
                }
                if boot.boots > 0 {
                    one.step(boot.begin, StepRole::Sign, Saying::Booted, None);
                }
                if boot.reads > 0 {
                    one.step(boot.first, StepRole::Sign, Saying::DeviceTypeRead, None);
                }
                if boot.reads > 1 {
                    one.step(boot.last, StepRole::Sign, Saying::DeviceTypeRead, None);
                }
            }
        }
    }
}

//! Attempts of a controller without success: reads that a node refuses, resets, and commands to a node that
//! is not there.
//!
//! One refusal or one reset is ordinary traffic. The number of times makes it a problem, unless it succeeds at last.

use std::collections::BTreeMap;

use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::problems::kinds::ProblemKind;
use crate::problems::ledger::LedgerPlace;
use crate::problems::problem::{Problem, StepRole, Subject};
use crate::problems::roles::KindRole;
use crate::problems::sayings::Saying;
use crate::problems::scene::Scene;
use crate::rules::finding::Quantity;
use crate::sdo::transfer::{Direction, Status, Transfer};
use crate::sdo::wire::{Mux, Side};

/// Number of refused reads of one object, without one that succeeds, that are a problem.
const READS: u64 = 5;
/// Number of resets with a boot-up behind each, without the state Operational in between and not further apart than
/// `RESETS_NS` in ns, that are a problem.
const RESETS: u64 = 3;
const RESETS_NS: Ns = Ns::from_s(30);
/// Number of commands to a node of its own that was never heard.
const COMMANDS: u64 = 2;
/// Maximum number of objects that are followed.
const KEPT: usize = 256;
/// The history of errors: reading beyond its end is usual.
const ERROR_HISTORY: u16 = 0x1003;
/// The abort codes of a hardware error, and of a resource that is not available.
const HARDWARE: u32 = 0x0606_0000;
const RESOURCE: u32 = 0x060A_0023;
/// The abort code of an object without data at this time.
const NO_DATA: u32 = 0x0800_0024;

/// Something that is tried again and again.
#[derive(Clone, Copy, Debug)]
struct Tries {
    first: FrameRef,
    last: FrameRef,
    count: u64,
    place: Option<LedgerPlace>,
}

impl Tries {
    fn new(at: FrameRef) -> Self {
        Self { first: at, last: at, count: 0, place: None }
    }

    /// Counts a time, and opens or extends the problem from `least` times on.
    fn again(&mut self, at: FrameRef, (kind, node, least): (ProblemKind, u8, u64), scene: &mut Scene<'_>) {
        (self.count, self.last) = (self.count.saturating_add(1), at);
        if self.count >= least && self.place.is_none() {
            self.place = scene.ledger.open(kind, scene.id, Subject::node(node), self.first, at);
        }
        if let Some(one) = self.place.and_then(|place| scene.ledger.get_mut(place)) {
            one.repeats.count = self.count;
            one.repeats.since = at;
        }
    }
}

/// Returns the number of refused reads of an object that are a problem: one of an object that each device has (CiA 301,
/// 7.5.2), and two with an error of the device.
fn least(mux: Mux, abort: u32) -> u64 {
    let mandatory = matches!((mux.index, mux.sub), (0x1000 | 0x1001, 0) | (0x1018, 0..=1));
    match abort {
        0x0602_0000 | 0x0609_0011 if mandatory => 1,
        HARDWARE | RESOURCE => 2,
        _ => READS,
    }
}

/// The vain attempts on a bus.
#[derive(Clone, Debug, Default)]
pub(in crate::problems) struct InVain {
    reads: BTreeMap<(u8, Mux), Tries>,
    /// The last reset of a node by command without a boot-up since, and resets with one.
    reset: BTreeMap<u8, FrameRef>,
    resets: BTreeMap<u8, Tries>,
    commands: BTreeMap<u8, Tries>,
}

impl InVain {
    /// Processes the end of an SDO transfer.
    pub(in crate::problems) fn transfer(&mut self, transfer: &Transfer, scene: &mut Scene<'_>) {
        let (Direction::Upload, Some(mux)) = (transfer.direction, transfer.mux) else { return };
        let key = (transfer.node, mux);
        match (transfer.outcome.status, transfer.outcome.abort) {
            (Status::Ok, _) => {
                let place = self.reads.remove(&key).and_then(|tries| tries.place);
                if let Some(one) = place.and_then(|place| scene.ledger.get_mut(place)) {
                    one.step(transfer.last, StepRole::Recovery, Saying::Transferred, None);
                    one.ends(transfer.last);
                }
            }
            (Status::Aborted, Some(abort)) if abort.by == Side::Server => {
                let usual = mux.index == ERROR_HISTORY || abort.code.meaning() == NO_DATA;
                if usual || self.reads.len() >= KEPT && !self.reads.contains_key(&key) {
                    return;
                }
                let tries = self.reads.entry(key).or_insert(Tries::new(transfer.first));
                let least = least(mux, abort.code.meaning());
                tries.again(transfer.last, (ProblemKind::ReadInVain, transfer.node, least), scene);
                if let Some(one) = tries.place.and_then(|place| scene.ledger.get_mut(place)) {
                    one.fact("object", Quantity::Object(mux));
                    one.fact("abort", Quantity::Abort(abort.code));
                }
            }
            _ => {}
        }
    }

    /// Processes an NMT command to a node of its own; `ran`: the node was Operational.
    pub(in crate::problems) fn commanded(&mut self, command: u8, node: u8, ran: bool, scene: &mut Scene<'_>) {
        if matches!(command, 0x81 | 0x82) {
            // What has been started was not reset in vain before.
            if ran && self.resets.get(&node).is_some_and(|tries| tries.place.is_none()) {
                self.resets.remove(&node);
            }
            self.reset.insert(node, scene.at);
        }
        if scene.heard.last(node).is_none() {
            let tries = self.commands.entry(node).or_insert(Tries::new(scene.at));
            (tries.count, tries.last) = (tries.count.saturating_add(1), scene.at);
        }
    }

    /// Processes a boot-up.
    pub(in crate::problems) fn booted(&mut self, node: u8, scene: &mut Scene<'_>) {
        let Some(reset) = self.reset.remove(&node) else { return };
        let tries = self.resets.entry(node).or_insert(Tries::new(reset));
        if reset.since(tries.last).is_some_and(|since| since > RESETS_NS) && tries.place.is_none() {
            *tries = Tries::new(reset);
        }
        tries.again(reset, (ProblemKind::ResetAgain, node, RESETS), scene);
    }

    /// Concludes at the end of the capture.
    pub(in crate::problems) fn finish(&mut self, scene: &mut Scene<'_>) {
        for (node, tries) in std::mem::take(&mut self.resets) {
            let Some(one) = tries.place.and_then(|place| scene.ledger.get_mut(place)) else { continue };
            // It runs for longer than it did between the resets.
            let mean = tries.last.since(tries.first).map(|all| all / tries.count.saturating_sub(1).max(1) as i64);
            let rest = scene.at.since(tries.last);
            let stays = mean.zip(rest).is_some_and(|(mean, rest)| rest > mean * 2);
            if stays && scene.heard.is_operational(node) {
                one.ends(tries.last);
            }
        }
        // A capture of one node alone does not show the others.
        if scene.heard.known.count_ones() < 2 {
            return;
        }
        for (node, tries) in std::mem::take(&mut self.commands) {
            let absent = |one: &Problem| one.kind.is(KindRole::NeverHeard) && one.subject.node == Some(node);
            if tries.count < COMMANDS
                || scene.heard.last(node).is_some()
                || scene.ledger.last(scene.id, absent).is_some()
            {
                continue;
            }
            let place = scene.ledger.absent(scene.id, node, tries.first, tries.last);
            if let Some(one) = place.and_then(|place| scene.ledger.get_mut(place)) {
                one.fact("commands", Quantity::Count(tries.count));
            }
        }
    }
}

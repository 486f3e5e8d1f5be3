//! Refused writes to a node: from the first refusal to the write that makes up for the last of them.
//!
//! A successful write of the same value makes up for a refused one. Another value for the same object, or for a PDO the
//! write that enables its mapping again, ends it as well: the first value was wrong. Refused reads are ordinary traffic
//! and not considered.

use std::collections::BTreeMap;

use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::checks::pdo::configuration::pdo_parameter;
use crate::problems::kinds::{ProblemKind, signed};
use crate::problems::ledger::LedgerPlace;
use crate::problems::problem::{ProblemId, StepRole, Subject, bit};
use crate::problems::roles::KindRole;
use crate::problems::sayings::Saying;
use crate::problems::scene::Scene;
use crate::rules::finding::{Code, Finding, Quantity};
use crate::sdo::abort_code::AbortCode;
use crate::sdo::transfer::{Abort, Direction, Status, Transfer};
use crate::sdo::wire::{Command, Mux, Side};
use crate::world::event::Step;

/// Minimum pause that ends a run of writes, in ns.
const PAUSE_NS: Ns = Ns::from_s(2);
/// Maximum number of refused objects of a node.
const KEPT: usize = 64;
/// Maximum number of kept bytes of a refused value.
const LONGEST: usize = 8;

/// The open problems of configuration on a bus.
#[derive(Clone, Debug, Default)]
pub(in crate::problems) struct Configurations {
    open: BTreeMap<u8, (LedgerPlace, Vec<Refused>)>,
    /// The last request to each node that has never been heard.
    asked: BTreeMap<u8, FrameRef>,
    /// Nodes requested in vain and never heard.
    missed: Vec<(u8, ProblemId)>,
    /// Nodes with which a transfer begins in the capture, or whose missing beginning is reported, one bit each.
    begun: u128,
}

/// A refused write: object and value; the value is empty if longer than [`LONGEST`] or not known.
type Refused = (Mux, Vec<u8>);

/// Returns the kind of refusal for an abort code and object.
fn kind(code: AbortCode, mux: Mux) -> ProblemKind {
    match mux.index {
        0x1010 | 0x1011 => return ProblemKind::StoreFailed,
        0x1F50 | 0x1F51 => return ProblemKind::ProgramFailed,
        _ => {}
    }
    let of_pdo = pdo_parameter(mux.index).is_some();
    match code.meaning() {
        0x0602_0000 | 0x0609_0011 => ProblemKind::ObjectRefused,
        _ if of_pdo => ProblemKind::MappingRefused,
        0x0604_0041 | 0x0604_0042 => ProblemKind::MappingRefused,
        0x0601_0000..=0x0601_00FF => ProblemKind::AccessRefused,
        0x0607_0000..=0x0607_00FF => ProblemKind::LengthRefused,
        0x0609_0000..=0x0609_00FF => ProblemKind::ValueRefused,
        0x0800_0020..=0x0800_00FF => ProblemKind::StateRefused,
        _ => ProblemKind::WriteRefused,
    }
}

/// Returns the value that stores or restores parameters (CiA 301, 7.5.2.13 and 7.5.2.14).
fn signature(index: u16) -> Option<&'static [u8; 4]> {
    match index {
        0x1010 => Some(b"save"),
        0x1011 => Some(b"load"),
        _ => None,
    }
}

/// Reports a download whose start is not in the capture, if its client aborts it for another reason than a time-out.
fn given_up(transfer: &Transfer, scene: &mut Scene<'_>) {
    let Some(abort) = transfer.outcome.abort.filter(|abort| abort.by == Side::Client && !abort.code.is_timeout())
    else {
        return;
    };
    let (kind, subject) = (ProblemKind::WriteRefused, Subject::node(transfer.node));
    let place = scene.ledger.open(kind, scene.id, subject, transfer.first, transfer.last);
    if let Some(one) = place.and_then(|place| scene.ledger.get_mut(place)) {
        one.fact("abort", Quantity::Abort(abort.code));
        one.fact("client_aborted", Quantity::Count(1));
    }
}

impl Configurations {
    /// Processes the end of an SDO transfer.
    pub(in crate::problems) fn transfer(&mut self, transfer: &Transfer, scene: &mut Scene<'_>) {
        if transfer.direction != Direction::Download {
            return;
        }
        let Some(mux) = transfer.mux else { return given_up(transfer, scene) };
        match (transfer.outcome.status, transfer.outcome.abort) {
            // What its client aborts has not been written, either; a time-out is an unanswered request.
            (Status::Aborted, Some(abort))
                if abort.by == Side::Server || mux.index == 0x1F50 || !abort.code.is_timeout() =>
            {
                self.refused(transfer, mux, abort, scene)
            }
            (Status::Ok, _) if !transfer.outcome.bad => self.taken(transfer, mux, scene),
            _ => {}
        }
    }

    /// Records a request to a node that has never been heard.
    pub(in crate::problems) fn asked(&mut self, node: u8, at: FrameRef) {
        self.asked.insert(node, at);
    }

    /// Records the abort of a client's request to a node that has never been heard.
    pub(in crate::problems) fn given_up(&mut self, node: u8, code: AbortCode, scene: &mut Scene<'_>) {
        let Some(begin) = self.asked.remove(&node).filter(|_| code.is_timeout()) else { return };
        let known =
            scene.ledger.last(scene.id, |one| one.kind.is(KindRole::NeverHeard) && one.subject.node == Some(node));
        let at = scene.at;
        let place = known.or_else(|| scene.ledger.absent(scene.id, node, begin, at));
        let Some(one) = place.and_then(|place| scene.ledger.get_mut(place)) else { return };
        if known.is_some() {
            one.again(begin);
        } else {
            self.missed.push((node, one.id));
        }
        one.step(at, StepRole::Attempt, Saying::ClientGaveUp, None);
    }

    /// Processes an SDO frame that ends no transfer. If it aborts the first transfer with its node, of which the capture has
    /// no beginning, nothing else tells of that: by the client after a time-out, or by the server for a reason that concerns
    /// data. Whether it was tried again is unknown.
    pub(in crate::problems) fn step(&mut self, node: u8, step: &Step, scene: &mut Scene<'_>) {
        let Command::Abort(mux, code) = step.command else {
            self.begun |= if step.command.is_initiate() { bit(node) } else { 0 };
            return;
        };
        let code = AbortCode::Sdo(code);
        let kind = match (step.side, code.meaning()) {
            _ if step.mux.is_some() || self.begun & bit(node) != 0 => None,
            // That of a request without response.
            (Side::Client, _) if code.is_timeout() => signed(Code::Sdo002).map(|(kind, _)| kind),
            (Side::Server, 0x0503_0000..=0x0504_FFFF | 0x0601_0002 | 0x0604_0000..=0x0609_0010) => {
                Some(kind(code, mux))
            }
            (Side::Server, 0x0609_0030..=0x0800_0022) => Some(kind(code, mux)),
            _ => None,
        };
        let Some(kind) = kind else { return };
        self.begun |= bit(node);
        let (subject, at) = (Subject::node(node), scene.at);
        let place = scene.ledger.open(kind, scene.id, subject, at, at);
        if let Some(one) = place.and_then(|place| scene.ledger.get_mut(place)) {
            one.clue.unsettled = true;
            one.fact("object", Quantity::Object(mux));
            one.fact("abort", Quantity::Abort(code));
            one.fact("unseen", Quantity::Count(1));
        }
    }

    /// Ends the problems of a node that was requested in vain and is now heard; `booted`: by its boot-up.
    #[inline]
    pub(in crate::problems) fn heard(&mut self, node: u8, booted: bool, scene: &mut Scene<'_>) {
        if self.missed.is_empty() {
            return;
        }
        let at = scene.at;
        self.missed.retain(|(missed, id)| {
            if *missed == node
                && let Some(one) = scene.ledger.get_mut((id.0 as usize).wrapping_sub(1))
            {
                if booted {
                    one.fact("boot_up", Quantity::Count(1));
                }
                let said = if booted { Saying::Booted } else { Saying::FirstHeard };
                one.step(at, StepRole::Recovery, said, None);
                one.ends(at);
            }
            *missed != node
        });
    }

    fn refused(&mut self, transfer: &Transfer, mux: Mux, abort: Abort, scene: &mut Scene<'_>) {
        let node = transfer.node;
        let open = self.open.get(&node).map(|(place, _)| *place);
        let ended = || {
            scene.ledger.last(scene.id, |one| {
                one.subject.node == Some(node) && one.has("abort") && one.ended_within(transfer.first, PAUSE_NS)
            })
        };
        let place = open.or_else(ended);
        let (by_client, abort) = (abort.by == Side::Client, abort.code);
        let (begin, at) = (transfer.first, transfer.last);
        let place = match place {
            Some(place) => place,
            None => {
                let kind = kind(abort, mux);
                let Some(place) = scene.ledger.open(kind, scene.id, Subject::node(node), begin, at) else { return };
                if let Some(one) = scene.ledger.get_mut(place) {
                    one.subject.pdo = pdo_parameter(mux.index).map(|(_, transmit, number)| (transmit, number));
                    one.fact("object", Quantity::Object(mux));
                    one.fact("abort", Quantity::Abort(abort));
                }
                place
            }
        };
        if let Some(one) = scene.ledger.get_mut(place) {
            one.end = None;
            let object = mux;
            let (said, name) = match by_client {
                true => (Saying::ClientAborted { object, abort }, "client_aborted"),
                false => (Saying::WriteRefused { object, abort }, "refused"),
            };
            one.step(at, StepRole::Sign, said, None);
            one.fact(name, Quantity::Count(one.count(name) + 1));
            if signature(mux.index).is_some_and(|right| !transfer.data.requested.starts_with(right)) {
                one.fact("signature", Quantity::Count(1));
            }
        }
        let (_, objects) = self.open.entry(node).or_insert((place, Vec::new()));
        let asked = Some(&transfer.data.requested).filter(|value| value.len() <= LONGEST).cloned().unwrap_or_default();
        if let Some((_, value)) = objects.iter_mut().find(|(object, _)| *object == mux) {
            *value = asked;
        } else if objects.len() < KEPT {
            objects.push((mux, asked));
        }
    }

    fn taken(&mut self, transfer: &Transfer, mux: Mux, scene: &mut Scene<'_>) {
        let Some((place, objects)) = self.open.get_mut(&transfer.node) else { return };
        let nonzero = transfer.data.kept.iter().any(|byte| *byte != 0);
        let whole = pdo_parameter(mux.index).filter(|(mapping, ..)| *mapping && mux.sub == 0 && nonzero);
        // A write that clears a mapping or disables a PDO prepares the intended value.
        let prepares = pdo_parameter(mux.index).is_some_and(|(mapping, ..)| match mapping {
            true => mux.sub == 0 && !nonzero,
            false => mux.sub == 1 && transfer.data.kept.get(3).is_some_and(|byte| byte & 0x80 != 0),
        });
        let before = objects.len();
        let mut others = 0;
        objects.retain(|(open, value)| {
            let same_pdo = whole.is_some_and(|(_, transmit, number)| {
                // An entry that the new mapping has was not written.
                let unused = open.sub == 0 || transfer.data.kept.first().is_some_and(|count| open.sub > *count);
                pdo_parameter(open.index)
                    .is_some_and(|(mapping, t, n)| mapping && unused && (t, n) == (transmit, number))
            });
            let same = *open == mux && (value.is_empty() || *value == transfer.data.kept);
            let other = !same && (same_pdo || *open == mux && !prepares);
            others += u64::from(other);
            !same && !other
        });
        let (place, done) = (*place, objects.is_empty());
        if before == objects.len() {
            return;
        }
        if done {
            self.open.remove(&transfer.node);
        }
        if let Some(one) = scene.ledger.get_mut(place) {
            one.step(transfer.last, StepRole::Recovery, Saying::WriteTaken { object: mux }, None);
            if others != 0 {
                one.fact("others", Quantity::Count(one.count("others") + others));
            }
            if done {
                one.ends(transfer.last);
            }
        }
    }

    /// Records that the NMT master started nodes, one bit each, without making up for their refused writes.
    pub(in crate::problems) fn started(&mut self, nodes: u128, scene: &mut Scene<'_>) {
        for (node, (place, _)) in &self.open {
            if nodes & bit(*node) != 0
                && let Some(one) = scene.ledger.get_mut(*place)
                && !one.has("started")
            {
                one.fact("started", Quantity::Count(scene.at.listed().no));
                one.step(scene.at, StepRole::Reaction, Saying::StartedAllTheSame, None);
            }
        }
    }

    /// Adds the finding that a refused write was not made up for (SDO018), at the end of the capture.
    pub(in crate::problems) fn stays(&mut self, node: u8, finding: &Finding, scene: &mut Scene<'_>) {
        let open = self.open.get(&node).map(|(place, _)| *place);
        let place = open.or_else(|| scene.ledger.last(scene.id, |one| one.holds(finding.at.no)));
        if let Some(one) = place.and_then(|place| scene.ledger.get_mut(place))
            && finding.because_of.is_none()
        {
            one.found(finding);
        }
    }

    /// Ends the refused writes of a node that booted; a program that it refused it has not.
    pub(in crate::problems) fn booted(&mut self, node: u8, scene: &mut Scene<'_>) {
        let program = |place| scene.ledger.get(place).is_some_and(|one| one.kind.is(KindRole::Program));
        if self.open.get(&node).is_some_and(|(place, _)| program(*place)) {
            return;
        }
        if let Some((place, _)) = self.open.remove(&node)
            && let Some(one) = scene.ledger.get_mut(place)
        {
            one.step(scene.at, StepRole::Recovery, Saying::Booted, None);
            one.fact("booted", Quantity::Count(scene.at.listed().no));
            one.ends(scene.at);
        }
    }
}

//! PDOs that come with SYNC and stop while it goes on, RPDOs that came at even times without SYNC, two senders of one RPDO,
//! and frames that no RPDO takes.
//!
//! Frames at even times are no events. On a bus without SYNC it is unknown whether they should go on.

use std::collections::BTreeMap;

use crate::bytes::frame::{CanId, Frame, FrameRef};
use crate::bytes::ns::Ns;
use crate::checks::pdo::configuration::pdo_parameter;
use crate::problems::kinds::ProblemKind;
use crate::problems::ledger::LedgerPlace;
use crate::problems::problem::{StepRole, Subject};
use crate::problems::sayings::Saying;
use crate::problems::scene::Scene;
use crate::rules::finding::Quantity;
use crate::sdo::transfer::{Direction, Status, Transfer};
use crate::wire::error_control::OPERATIONAL;
use crate::world::event::ProcessData;

/// Number of SYNC cycles in a row with the PDO after which it is expected in each, and without it after which it has
/// stopped.
const CYCLES: u32 = 20;
/// Number of cycles with the data of the one before, or of cycles in all, after which it is not sent by changes.
const UNCHANGED: u32 = 10;
const MANY: u32 = 5 * CYCLES;
/// Number of even gaps in a row that a sender by time makes, the part of a gap by which even ones differ at most, and the
/// number of heartbeats of the node, each so many gaps later, without the RPDO.
const EVEN: u32 = 50;
const EVEN_PART: i64 = 4;
const LATE: u32 = 3;
/// Number of cycles in which a node that was away may send its PDO again after its first frame.
const BACK: u32 = 5;
/// Number of SYNC cycles in a row with two different frames, each as in the cycle before, that two senders make.
const TWICE: u32 = 10;
/// Maximum number of PDOs that are followed.
const KEPT: usize = 512;
/// Number of frames that no RPDO takes beyond the change of a COB-ID.
const FRAMES: u64 = 10;

/// A PDO in order of node, RPDOs before TPDOs, and number: one comparison.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct CyclicName(u32);

impl CyclicName {
    fn new(node: u8, transmit: bool, number: u16) -> Self {
        Self(u32::from(node) << 17 | u32::from(transmit) << 16 | u32::from(number))
    }

    fn node(self) -> u8 {
        (self.0 >> 17) as u8
    }

    /// Returns true for a TPDO, and its number.
    fn pdo(self) -> (bool, u16) {
        (self.0 >> 16 & 1 != 0, self.0 as u16)
    }
}

/// A PDO that comes with SYNC.
#[derive(Clone, Debug, Default)]
struct Cyclic {
    name: CyclicName,
    last: FrameRef,
    /// Frames of this cycle, the first two of them, and those of the cycle before.
    frames: u32,
    now: [[u8; 8]; 2],
    before: [[u8; 8]; 2],
    /// Number of cycles in a row with it, with the same data, without it, and with two different ones.
    with: u32,
    same: u32,
    without: u32,
    twice: u32,
    /// Number of cycles since the node was heard without it.
    alone: u32,
    /// Mean time between the last frames, in ns, the number of gaps in a row like it, and the number of heartbeats of the node
    /// since they have stopped.
    gap_ns: Ns,
    even: u32,
    late: u32,
    /// True once it has come in [`CYCLES`] cycles in a row, once in each.
    expected: bool,
    stopped: Option<LedgerPlace>,
    shared: Option<LedgerPlace>,
}

/// A CAN-ID of the pre-defined connection set whose RPDO has another one.
#[derive(Clone, Copy, Debug)]
struct Untaken {
    first: FrameRef,
    count: u64,
    place: Option<LedgerPlace>,
}

/// The PDOs of a bus.
#[derive(Clone, Debug, Default)]
pub(in crate::problems) struct Pdos {
    /// In order of their names: a search in a row is quicker than one in a tree, and each SYNC passes all.
    cyclic: Vec<Cyclic>,
    untaken: BTreeMap<u32, Untaken>,
}

impl Pdos {
    /// Processes a PDO.
    pub(in crate::problems) fn pdo(&mut self, data: &ProcessData, frame: &Frame, scene: &mut Scene<'_>) {
        let at = frame.reference();
        if !data.transmit {
            self.disabled(data, frame, scene);
        }
        if scene.heard.sync_period_ns.is_none() && data.transmit {
            return;
        }
        let name = CyclicName::new(data.node, data.transmit, data.number);
        let place = self.cyclic.binary_search_by_key(&name, |one| one.name).unwrap_or_else(|place| {
            if self.cyclic.len() < KEPT {
                self.cyclic.insert(place, Cyclic { name, ..Cyclic::default() });
            }
            place
        });
        let Some(one) = self.cyclic.get_mut(place).filter(|one| one.name == name) else { return };
        if let Some(slot) = one.now.get_mut(one.frames as usize) {
            *slot = frame.head();
        }
        let gap_ns = at.since(one.last).unwrap_or(Ns::ZERO);
        let even = gap_ns > Ns::ZERO && (gap_ns - one.gap_ns).abs() <= one.gap_ns / EVEN_PART;
        (one.gap_ns, one.even, one.late) = match even {
            true => (one.gap_ns + (gap_ns - one.gap_ns) / 16, one.even.saturating_add(1), 0),
            false => (gap_ns, 0, 0),
        };
        (one.frames, one.last) = (one.frames.saturating_add(1), at);
        if let Some(problem) = one.stopped.take().and_then(|place| scene.ledger.get_mut(place)) {
            problem.step(at, StepRole::Recovery, Saying::PdoAgain, None);
            problem.ends(at);
        }
    }

    /// Processes a frame to an RPDO, which may be disabled while its node is Operational.
    fn disabled(&mut self, data: &ProcessData, frame: &Frame, scene: &mut Scene<'_>) {
        let (id, at) = (frame.id.raw(), frame.reference());
        if !data.is_off || data.state != Some(OPERATIONAL) {
            return self.taken(frame.id, at, scene);
        }
        self.count(id, (data.node, data.number), None, frame, scene);
    }

    /// Counts a frame that no RPDO takes. `other`: the CAN-ID of the RPDO for which it may be; `None` if that is disabled.
    fn count(
        &mut self,
        id: u32,
        (node, number): (u8, u16),
        other: Option<CanId>,
        frame: &Frame,
        scene: &mut Scene<'_>,
    ) {
        let at = frame.reference();
        let one = self.untaken.entry(id).or_insert(Untaken { first: at, count: 0, place: None });
        one.count = one.count.saturating_add(1);
        if one.count < FRAMES {
            return;
        }
        if one.place.is_none() {
            let subject = Subject { pdo: Some((false, number)), ..Subject::node(node) };
            one.place = scene.ledger.open(ProblemKind::NotTaken, scene.id, subject, one.first, at);
            if let Some(problem) = one.place.and_then(|place| scene.ledger.get_mut(place)) {
                problem.fact("id", Quantity::Id(frame.id));
                if let Some(other) = other {
                    problem.fact("other", Quantity::Id(other));
                }
            }
        }
        if let Some(problem) = one.place.and_then(|place| scene.ledger.get_mut(place)) {
            problem.fact("frames", Quantity::Count(one.count));
        }
    }

    /// Processes a SYNC, with which a cycle ends.
    pub(in crate::problems) fn sync(&mut self, scene: &mut Scene<'_>) {
        for one in &mut self.cyclic {
            let (node, (transmit, number)) = (one.name.node(), one.name.pdo());
            let subject = Subject { pdo: Some((transmit, number)), ..Subject::node(node) };
            let [first, second] = one.now;
            let two = one.frames == 2 && first != second;
            one.twice = if two && one.now == one.before { one.twice.saturating_add(1) } else { 0 };
            if one.frames > 0 {
                one.same = one.same.saturating_add(u32::from(one.now == one.before));
                (one.with, one.without, one.before) = (one.with.saturating_add(1), 0, one.now);
                let cyclic = one.same >= UNCHANGED || one.with >= MANY;
                one.expected |= one.with >= CYCLES && one.frames == 1 && cyclic;
            } else {
                (one.with, one.same, one.without) = (0, 0, one.without.saturating_add(1));
            }
            let here = scene.heard.last(node).is_some_and(|last| last.no > one.last.no);
            one.alone = if here { one.alone.saturating_add(1) } else { 0 };
            one.frames = 0;
            if one.expected && one.twice >= TWICE && one.shared.is_none() && !transmit {
                one.shared = scene.ledger.open(ProblemKind::SharedCobId, scene.id, subject, one.last, one.last);
                if let Some(problem) = one.shared.and_then(|place| scene.ledger.get_mut(place)) {
                    problem.fact("alternates", Quantity::Count(2));
                }
            }
            let stops = match transmit {
                true => one.without >= CYCLES && one.alone >= BACK,
                false => one.without == CYCLES,
            };
            if one.expected
                && stops
                && one.stopped.is_none()
                && scene.bus.state(node) == Some(OPERATIONAL)
                && (!transmit || is_unknown(node, number, scene))
            {
                let kind = if transmit { ProblemKind::PdoMissing } else { ProblemKind::RpdoStopped };
                one.stopped = scene.ledger.open(kind, scene.id, subject, one.last, scene.at);
            }
        }
    }

    /// Processes a heartbeat of an Operational node: on a bus without SYNC, RPDOs to it that came evenly are due.
    pub(in crate::problems) fn beat(&mut self, node: u8, scene: &mut Scene<'_>) {
        if scene.heard.sync_period_ns.is_some() {
            return;
        }
        let from = self.cyclic.partition_point(|one| one.name < CyclicName::new(node, false, 0));
        let of_node = self.cyclic.iter_mut().skip(from).take_while(|one| one.name.node() == node && !one.name.pdo().0);
        for one in of_node.filter(|one| one.even >= EVEN && one.stopped.is_none()) {
            let limit_ns = one.gap_ns * i64::from(CYCLES);
            one.late += u32::from(scene.at.since(one.last).is_some_and(|since| since > limit_ns));
            if one.late < LATE {
                continue;
            }
            let subject = Subject { pdo: Some(one.name.pdo()), ..Subject::node(node) };
            one.stopped = scene.ledger.open(ProblemKind::RpdoStopped, scene.id, subject, one.last, scene.at);
            if let Some(problem) = one.stopped.and_then(|place| scene.ledger.get_mut(place)) {
                problem.clue.unsettled = true;
                problem.fact("period", Quantity::Ns(one.gap_ns));
            }
        }
    }

    /// Processes the end of an SDO transfer: a PDO whose configuration changed may be sent otherwise.
    pub(in crate::problems) fn transfer(&mut self, transfer: &Transfer) {
        let written = transfer.direction == Direction::Download && transfer.outcome.status == Status::Ok;
        let pdo = transfer.mux.filter(|_| written).and_then(|mux| pdo_parameter(mux.index));
        if let Some((_, true, number)) = pdo {
            self.cyclic.retain(|one| one.name != CyclicName::new(transfer.node, true, number) || one.stopped.is_some());
        }
    }

    /// Processes the boot-up of a node, or a command that stops it: no RPDO is expected.
    pub(in crate::problems) fn stopped(&mut self, node: u8) {
        self.cyclic.retain(|one| (node != 0 && one.name.node() != node) || one.stopped.is_some());
    }

    /// Processes a frame that an RPDO takes again.
    fn taken(&mut self, id: CanId, at: FrameRef, scene: &mut Scene<'_>) {
        let place = self.untaken.remove(&id.raw()).and_then(|one| one.place);
        if let Some(problem) = place.and_then(|place| scene.ledger.get_mut(place)) {
            problem.step(at, StepRole::Recovery, Saying::PdoAgain, None);
            problem.ends(at);
        }
    }

    /// Processes a data frame that is no known PDO.
    #[inline]
    pub(in crate::problems) fn unknown(&mut self, frame: &Frame, scene: &mut Scene<'_>) {
        let id = frame.id.raw();
        let number = match id >> 8 {
            group @ 2..=5 if id & 0x80 == 0 && id & 0x7F != 0 && !frame.id.is_extended() => group as u16 - 1,
            _ => return,
        };
        let node = id as u8 & 0x7F;
        let told = self.untaken.get(&id).is_some_and(|one| one.place.is_some());
        let other = rpdo_of(node, number, frame.id, scene);
        if !told && other.is_none() {
            self.untaken.remove(&id);
            return;
        }
        self.count(id, (node, number), other, frame, scene);
    }
}

/// Returns true if the transmission type of a TPDO is not known; otherwise the checks judge its cycles.
fn is_unknown(node: u8, number: u16, scene: &Scene<'_>) -> bool {
    let pdos = scene.bus.node(node).map(|known| known.pdos()).unwrap_or_default();
    let one = pdos.iter().find(|pdo| pdo.transmit && pdo.number == number);
    one.is_none_or(|pdo| pdo.transmission.is_none())
}

/// Returns the CAN-ID that an RPDO has, as the capture shows, if it is not this one and no known RPDO has this one.
fn rpdo_of(node: u8, number: u16, id: CanId, scene: &Scene<'_>) -> Option<CanId> {
    let pdos = scene.bus.node(node)?.pdos();
    let one = pdos.iter().find(|pdo| !pdo.transmit && pdo.number == number)?;
    let (cob, from) = one.cob;
    let elsewhere = from.is_told() && !from.is_doubted() && cob.valid && cob.id != id;
    let taken = |other: u8| {
        let pdos = scene.bus.node(other).map(|known| known.pdos()).unwrap_or_default();
        pdos.iter().any(|pdo| pdo.cob.0.valid && pdo.cob.0.id == id)
    };
    (elsewhere && !(1..=127).any(taken)).then_some(cob.id)
}

//! The diagnosis of a bus: problems, their status and their causes; the level above findings.
//!
//! Events go to trackers, which open, extend and end problems in the ledger; rules of cause link these; the rank gives the
//! reading order. A kind is a row of `words/problems.tsv`, with the findings that are such a problem by themselves; only
//! the tracker that opens it names it beside that, all others ask for its roles. Sentences are declared in `sayings` and
//! filled in by `titles`.
//!
//! Some known problems have no kind of their own. A flapping node is a silent node with repeats; one forgotten after a
//! restart is a restart that is still open; a fault by lost communication is an axis in fault with that cause. Others
//! are not visible on the wire: an RPDO that is not sent or not received (it may be event-driven, and receivers are not
//! seen), a target not reached in time (the limit is not on the bus), and parameters lost in a power cycle unless they
//! are read before and after.

pub mod advice;
pub mod apart;
mod causes;
pub mod kinds;
mod ledger;
mod links;
mod live;
mod on_bus;
pub mod problem;
pub mod rank;
pub mod roles;
pub mod sayings;
mod scene;
mod signs;
mod status;
pub mod titles;
mod trackers;

pub use ledger::Ledger;

use std::collections::{BTreeMap, VecDeque};

use self::ledger::LedgerPlace;
use self::on_bus::OfBus;
use self::problem::{Problem, ProblemId, Status};
use self::scene::Last;
use self::status::is_over;
use crate::bytes::frame::{BusId, Frame, FrameRef};
use crate::bytes::ns::Ns;
use crate::evidence::services::Nature;
use crate::rules::finding::Finding;
use crate::words::profiles::Profile;
use crate::world::bus::Bus;
use crate::world::drive::DriveState;
use crate::world::event::{Event, What};

/// Maximum number of ended problems that may begin again.
const CLOSED: usize = 64;

/// The diagnosis of a capture.
#[derive(Clone, Debug, Default)]
pub struct Diagnosis {
    ledger: Ledger,
    buses: Vec<OfBus>,
    /// The bit rate of all buses, in bit/s.
    bit_rate: Option<u32>,
    /// The first and the last frame, and the number of frames.
    first: Option<FrameRef>,
    last: FrameRef,
    frames: u64,
    /// The earliest first stamp of a bus, and the latest stamp, in ns: buses may have clocks of their own.
    began_ns: Option<Ns>,
    latest_ns: Option<Ns>,
    /// Reported problems that have not ended.
    open: Vec<LedgerPlace>,
    /// Recently ended problems; if one recurs, it is reported again.
    closed: VecDeque<LedgerPlace>,
    /// Problems before this place have been examined; those that did not count yet are examined again.
    looked: LedgerPlace,
    unripe: Vec<LedgerPlace>,
    /// Reported problems whose cause may still be found, with the reported cause, and true if that is final.
    linking: VecDeque<(LedgerPlace, Option<(ProblemId, bool)>)>,
    /// True after the end of the capture, when everything is final.
    over: bool,
    /// The nature of the buses, at the end of the capture.
    nature: Option<Nature>,
    nodes: Vec<NodeView>,
}

/// A change of a problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// It has appeared.
    Opened,
    /// Its cause has changed or has become certain.
    Linked,
    /// It has ended.
    Ended,
}

/// The state of a node at the end of the capture.
#[derive(Clone, Debug)]
pub struct NodeView {
    /// The bus.
    pub bus: BusId,
    /// Its node-ID.
    pub node: u8,
    /// Its last known NMT state.
    pub state: Option<u8>,
    /// Its profile.
    pub profile: Profile,
    /// True if it sends heartbeats alone.
    pub is_beating: bool,
    /// The last states of its axes.
    pub drives: Vec<DriveState>,
    /// The last error code that it has reported and not cleared.
    pub error: Option<u16>,
    /// The first problem in reading order that concerns it and has not ended.
    pub problem: Option<ProblemId>,
}

impl Diagnosis {
    /// Processes a frame with its events.
    pub fn frame(&mut self, frame: &Frame, events: &[Event], bus: &Bus) {
        self.frames += 1;
        self.first.get_or_insert(frame.reference().listed());
        self.last = frame.reference();
        let listed_ns = self.last.listed().t_ns;
        let index = usize::from(frame.bus.0);
        if self.buses.len() <= index {
            self.buses.resize_with(index + 1, || OfBus::new(self.bit_rate));
            self.began_ns = [self.began_ns, listed_ns].into_iter().flatten().min();
        }
        self.latest_ns = self.latest_ns.max(listed_ns);
        let Self { ledger, buses, .. } = self;
        if let Some(of_bus) = buses.get_mut(index) {
            of_bus.frame(frame, events, bus, ledger);
        }
    }

    /// Returns the changes of problems since the last call, in order. Kinds that are harmless are left out.
    pub fn changes(&mut self) -> Vec<(Phase, ProblemId)> {
        let (fresh, ledger) = (self.looked..self.ledger.all.len(), &self.ledger);
        let idle = self.open.is_empty() && self.unripe.is_empty() && self.closed.is_empty() && self.linking.is_empty();
        if fresh.is_empty() && idle {
            return Vec::new();
        }
        let last = self.last;
        self.looked = fresh.end;
        let mut changes = Vec::new();
        let (open, closed) = (&mut self.open, &mut self.closed);
        closed.retain(|place| {
            let Some(one) = ledger.get(*place).filter(|one| one.end.is_none()) else { return true };
            changes.push((Phase::Opened, one.id));
            open.push(*place);
            false
        });
        open.retain(|place| {
            let Some(one) = ledger.get(*place) else { return false };
            let over = is_over(one, last);
            if over {
                changes.push((Phase::Ended, one.id));
                closed.push_back(*place);
            }
            !over
        });
        self.unripe.extend(fresh);
        self.unripe.retain(|place| {
            let Some(one) = ledger.get(*place) else { return false };
            if one.kind.is_harmless() {
                return false;
            }
            if one.counts() {
                changes.push((Phase::Opened, one.id));
                if is_over(one, last) {
                    changes.push((Phase::Ended, one.id));
                    closed.push_back(*place);
                } else {
                    open.push(*place);
                }
            }
            !one.counts()
        });
        while closed.len() > CLOSED {
            closed.pop_front();
        }
        self.linked(&mut changes);
        self.number(&changes);
        changes
    }

    /// Assigns numbers to the reported problems, and to their causes if named with them.
    fn number(&mut self, changes: &[(Phase, ProblemId)]) {
        for (phase, id) in changes {
            let cause = self.ledger.by_id(*id).filter(|one| *phase != Phase::Ended && !rank::is_root(one));
            let cause = cause.and_then(|one| one.cause).map(|link| link.cause);
            self.ledger.give_numbers([*id].into_iter().chain(cause));
        }
    }

    /// Processes events without a frame at hand.
    pub fn asides(&mut self, events: &[Event], state: &[Bus]) {
        for event in events {
            let index = usize::from(event.bus.0);
            let (Some(of_bus), Some(bus)) = (self.buses.get_mut(index), state.get(index)) else { continue };
            match &event.what {
                What::Finding(finding) => of_bus.aside(finding, self.last, bus, &mut self.ledger),
                What::Transfer(transfer) => of_bus.transferred(transfer, self.last, bus, &mut self.ledger),
                What::Change(change) => _ = of_bus.drive(change, event.bus, self.last, bus, &mut self.ledger),
                _ => {}
            }
        }
    }

    /// Processes a finding about the capture, which has no frame.
    pub fn finding(&mut self, finding: &Finding, state: &[Bus]) {
        let index = if finding.bus == BusId::NONE { 0 } else { usize::from(finding.bus.0) };
        if let (Some(of_bus), Some(bus)) = (self.buses.get_mut(index), state.get(index)) {
            of_bus.aside(finding, self.last, bus, &mut self.ledger);
        }
    }

    /// Concludes at the end of the capture. `nature`: what it has shown of its buses.
    pub fn finish(&mut self, state: &[Bus], nature: Nature) {
        (self.over, self.nature) = (true, Some(nature));
        for (index, (of_bus, bus)) in self.buses.iter_mut().zip(state).enumerate() {
            of_bus.finish(BusId(index as u8), self.last, bus, &mut self.ledger);
        }
        links::settle(&mut self.ledger);
        links::join(&mut self.ledger);
        status::of_lost_frames(&mut self.ledger);
        status::of_chains(&mut self.ledger);
        let order = rank::stories(&self.ledger);
        self.ledger.give_numbers(order.into_iter().map(|(id, _)| id));
        self.nodes = self.views(state);
    }

    /// Returns what the capture has shown of its buses, at its end.
    pub fn nature(&self) -> Nature {
        self.nature.unwrap_or(Nature::Silent)
    }

    /// Returns all problems.
    pub fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    /// Returns the number of frames so far, and the first and the last of them.
    pub fn extent(&self) -> (u64, Option<FrameRef>, FrameRef) {
        // Stamps that become useless later have no usable beginning.
        let usable = self.last.t_ns.is_some();
        let timed = |first: FrameRef| FrameRef { t_ns: self.began_ns.or(first.t_ns).filter(|_| usable), ..first };
        let last = FrameRef { t_ns: self.latest_ns.filter(|_| usable), ..self.last };
        (self.frames, self.first.map(timed), last)
    }

    /// Creates a diagnosis of buses with this bit rate in bit/s, if known.
    pub fn new(bit_rate: Option<u32>) -> Self {
        Self { bit_rate, ..Self::default() }
    }

    /// Returns what shows that the bus is well: the number of nodes with heartbeats and of guarded ones, the number of responses
    /// of default SDOs and the longest time until one, in ns.
    pub fn well(&self) -> ([u64; 2], u64, Ns) {
        self.buses.iter().fold(([0; 2], 0, Ns::ZERO), |([beating, guarded], responses, slowest), one| {
            let ((beats, answers), (count, longest_ns)) = (one.heard.beating(), one.heard.responses);
            ([beating + beats, guarded + answers], responses + count, longest_ns.max(slowest))
        })
    }

    /// Returns the facts of the whole capture that advice depends on.
    pub fn shown(&self) -> advice::AdviceFacts {
        advice::AdviceFacts {
            error_frames: self.buses.iter().any(|one| one.heard.errors.0 > 0),
            nodes: self.buses.iter().map(|one| one.heard.known.count_ones()).max().unwrap_or(0),
        }
    }

    /// Returns the nodes seen, and those that problems concern, at the end of the capture.
    pub fn nodes(&self) -> &[NodeView] {
        &self.nodes
    }

    /// Returns the nodes with their states, and the first open problem in reading order that concerns each.
    fn views(&self, state: &[Bus]) -> Vec<NodeView> {
        let order = rank::roots(&self.ledger);
        let ranks: BTreeMap<ProblemId, usize> = order.iter().enumerate().map(|(rank, root)| (*root, rank)).collect();
        let is_open = |one: &&Problem| matches!(one.alone, Status::Open | Status::Unknown);
        let mut open: BTreeMap<u8, Vec<(usize, &Problem)>> = BTreeMap::new();
        for one in self.ledger.told().filter(is_open) {
            let rank = self.ledger.causes(one.id).filter_map(|id| ranks.get(&id)).min();
            rank.into_iter().for_each(|rank| open.entry(one.bus.0).or_default().push((*rank, one)));
        }
        let mut views = Vec::new();
        for (index, (of_bus, known)) in self.buses.iter().zip(state).enumerate() {
            let (bus, heard) = (BusId(index as u8), &of_bus.heard);
            let open = open.get(&bus.0).map_or(&[][..], Vec::as_slice);
            for node in problem::members(heard.known) {
                let concerning = open.iter().filter(|(_, one)| one.subject.concerns(node));
                let problem = concerning.map(|(rank, _)| *rank).min().and_then(|rank| order.get(rank).copied());
                // An axis has left the fault once no error is left, unless a problem says that it has not; it has shown no
                // other state yet.
                let cleared = heard.noted(Last::NoError, node).filter(|_| problem.is_none());
                let is_current = |(_, state, at): &(usize, DriveState, FrameRef)| {
                    *state != DriveState::Fault || cleared.is_none_or(|cleared| cleared.no < at.no)
                };
                views.push(NodeView {
                    bus,
                    node,
                    state: heard.states.get(usize::from(node)).copied().flatten(),
                    profile: known.node(node).map_or(Profile::UNKNOWN, |one| one.profile()),
                    is_beating: heard.is_beating(node),
                    drives: known.drive_reports(node).filter(is_current).map(|(_, state, _)| state).collect(),
                    error: heard.errors_of.get(usize::from(node)).copied().flatten(),
                    problem,
                });
            }
        }
        views
    }
}

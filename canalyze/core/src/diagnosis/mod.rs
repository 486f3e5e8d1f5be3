//! What went wrong on a bus, whether it still is, and why: the level above findings.
//!
//! Events go to trackers, which open, extend and end incidents in the ledger; rules of cause link those to stories; the
//! rank says in which order a person reads them. `signs` says which findings are incidents by themselves. A kind is added
//! in `kinds`, with a row in `signs` or a tracker that opens it. It must not change a configuration, raise a finding or
//! put words together: sentences are declared in `sayings` and filled by `text`.
//!
//! Of what is known to go wrong on such a bus these have no kind of their own. A node that flaps is a node that is silent,
//! with its repeats; one that is forgotten after a restart, a restart that stands; a fault by lost communication, an axis
//! in fault with that cause. Nobody can tell from the wire: an RPDO that nobody sends or takes (it may be event-driven,
//! and who receives is not seen), a target that is not reached in time (nothing on the bus says what is in time), and
//! parameters that are lost by a power cycle unless they are read before and after.

pub mod advice;
pub mod apart;
mod causes;
pub mod incident;
pub mod kinds;
mod ledger;
mod links;
mod live;
mod on_bus;
pub mod rank;
pub mod sayings;
mod scene;
mod signs;
mod status;
pub mod titles;
mod trackers;

pub use ledger::Ledger;

use std::collections::VecDeque;

use self::incident::{IncidentId, Status};
use self::kinds::Kind;
use self::ledger::Place;
use self::on_bus::OfBus;
use self::status::{is_harmless, is_over};
use crate::bus::Bus;
use crate::event::{Event, What};
use crate::finding::{Code, Finding};
use crate::frame::{BusId, Frame, FrameRef};
use crate::wire::error_control::OPERATIONAL;

/// Incidents that are over and may begin again.
const CLOSED: usize = 64;

/// What went wrong in a capture.
#[derive(Clone, Debug, Default)]
pub struct Diagnosis {
    ledger: Ledger,
    buses: Vec<OfBus>,
    /// Of all buses, in bit/s.
    bit_rate: Option<u32>,
    /// First and last frame, and how many there were.
    first: Option<FrameRef>,
    last: FrameRef,
    frames: u64,
    /// Incidents that were told of and are not over.
    open: Vec<Place>,
    /// Those that were over lately: what happens again is told again.
    closed: VecDeque<Place>,
    /// Incidents before this place were looked at; those that did not count yet are looked at again.
    looked: Place,
    unripe: Vec<Place>,
    /// Those that were told of and whose cause may still be found, with the cause that was told, and whether it was told
    /// for good.
    linking: VecDeque<(Place, Option<(IncidentId, bool)>)>,
    /// The capture is over, and all of it stands as it will.
    over: bool,
}

/// What has become of an incident.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// It has begun to show.
    Opened,
    /// Its cause is another one than was told, or is certain by now.
    Linked,
    /// It is over.
    Ended,
}

/// The rules whose findings are incidents of a kind by themselves.
pub fn shown_by(kind: Kind) -> impl Iterator<Item = Code> {
    signs::SIGNS.iter().filter(move |row| row.1 == kind).map(|row| row.0)
}

/// What is known of a node at the end of the capture.
#[derive(Clone, Copy, Debug)]
pub struct NodeView {
    /// The bus.
    pub bus: BusId,
    /// Its node-ID.
    pub node: u8,
    /// Its NMT state, as it was shown last.
    pub state: Option<u8>,
    /// The first incident, in the order of reading, that concerns it and is not over.
    pub incident: Option<IncidentId>,
}

impl Diagnosis {
    /// Takes a frame with what follows from it.
    pub fn frame(&mut self, frame: &Frame, events: &[Event], bus: &Bus) {
        self.frames += 1;
        self.first.get_or_insert(frame.reference());
        self.last = frame.reference();
        let index = usize::from(frame.bus.0);
        if self.buses.len() <= index {
            self.buses.resize_with(index + 1, || OfBus::new(self.bit_rate));
        }
        let Self { ledger, buses, .. } = self;
        if let Some(of_bus) = buses.get_mut(index) {
            of_bus.frame(frame, events, bus, ledger);
        }
    }

    /// What has become of incidents since this was last asked, the first first. What is harmless by its kind is left out.
    pub fn changes(&mut self) -> Vec<(Phase, IncidentId)> {
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
            if is_harmless(one.kind) {
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

    /// What is reported has a number from then on, and so has its cause, where that is named with it.
    fn number(&mut self, changes: &[(Phase, IncidentId)]) {
        for (phase, id) in changes {
            let cause = self.ledger.by_id(*id).filter(|one| *phase != Phase::Ended && !rank::is_root(one));
            let cause = cause.and_then(|one| one.cause).map(|link| link.cause);
            self.ledger.give_numbers([*id].into_iter().chain(cause));
        }
    }

    /// Takes what belongs to no frame at hand.
    pub fn asides(&mut self, events: &[Event], state: &[Bus]) {
        for event in events {
            let What::Finding(finding) = &event.what else { continue };
            let index = usize::from(event.bus.0);
            if let (Some(of_bus), Some(bus)) = (self.buses.get_mut(index), state.get(index)) {
                of_bus.aside(finding, self.last, bus, &mut self.ledger);
            }
        }
    }

    /// Takes a finding about the capture, which belongs to no frame.
    pub fn finding(&mut self, finding: &Finding, state: &[Bus]) {
        let index = if finding.bus == BusId::NONE { 0 } else { usize::from(finding.bus.0) };
        if let (Some(of_bus), Some(bus)) = (self.buses.get_mut(index), state.get(index)) {
            of_bus.aside(finding, self.last, bus, &mut self.ledger);
        }
    }

    /// The capture is over: how all of it stands.
    pub fn finish(&mut self, state: &[Bus]) {
        self.over = true;
        for (index, (of_bus, bus)) in self.buses.iter_mut().zip(state).enumerate() {
            of_bus.finish(BusId(index as u8), self.last, bus, &mut self.ledger);
        }
        links::settle(&mut self.ledger);
        links::join(&mut self.ledger);
        let order = rank::stories(&self.ledger);
        self.ledger.give_numbers(order.into_iter().map(|(id, _)| id));
    }

    /// All incidents.
    pub fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    /// Frames so far, and the first and the last of them.
    pub fn extent(&self) -> (u64, Option<FrameRef>, FrameRef) {
        // Stamps of no use from somewhere on give no time to count from.
        let timed = |first: FrameRef| FrameRef { t_ns: first.t_ns.filter(|_| self.last.t_ns.is_some()), ..first };
        (self.frames, self.first.map(timed), self.last)
    }

    /// A diagnosis of buses with this bit rate in bit/s, where it is known.
    pub fn new(bit_rate: Option<u32>) -> Self {
        Self { bit_rate, ..Self::default() }
    }

    /// What the whole capture shows that matters to advice.
    pub fn shown(&self) -> advice::Shown {
        advice::Shown { error_frames: self.buses.iter().any(|one| one.heard.errors.0 > 0) }
    }

    /// The nodes that were heard, and those that incidents are about.
    pub fn nodes(&self) -> Vec<NodeView> {
        let order = rank::roots(&self.ledger);
        let mut views = Vec::new();
        for (index, of_bus) in self.buses.iter().enumerate() {
            let bus = BusId(index as u8);
            for node in incident::members(of_bus.heard.known) {
                let about = |id: &&IncidentId| {
                    self.ledger.told().any(|one| {
                        one.bus == bus
                            && one.subject.concerns(node)
                            && matches!(one.status, Status::Stands | Status::Unknown)
                            && self.ledger.comes_from(one.id, **id)
                    })
                };
                let incident = order.iter().find(about).copied();
                let state = of_bus.heard.is_operational(node).then_some(OPERATIONAL);
                views.push(NodeView { bus, node, state, incident });
            }
        }
        views
    }
}

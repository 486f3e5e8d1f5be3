//! What went wrong on a bus, whether it still is, and why: the level above findings.
//!
//! Events go to trackers, which open, extend and end incidents in the ledger; rules of cause link those to stories; the
//! rank says in which order a person reads them. `signs` says which findings are incidents by themselves. A kind is added
//! in `kinds`, with a row in `signs` or a tracker that opens it. It must not change a configuration, raise a finding or
//! put words together: sentences are declared in `sayings` and filled by `text`.
//!
//! Not told are: overload and flooding (no figure of a bus is kept here), two masters, a boot that is stuck, IP and CSP
//! targets that come late, thermal courses, modules of couplers, programs that are downloaded.

pub mod advice;
pub mod incident;
pub mod kinds;
mod ledger;
mod links;
mod live;
pub mod rank;
pub mod sayings;
mod scene;
mod signs;
pub mod titles;
mod trackers;

pub use ledger::Ledger;

use std::collections::VecDeque;

use self::incident::{IncidentId, Status, bit};
use self::kinds::Kind;
use self::ledger::Place;
use self::scene::{Heard, Scene};
use self::signs::Ends;
use self::trackers::configuration::Configurations;
use self::trackers::drive::Drives;
use self::trackers::emcy::{Emergencies, Emergency};
use self::trackers::nodes::Nodes;
use self::trackers::rules::{Found, GOES_ON, Sign};
use crate::bus::Bus;
use crate::checks::pdo::length::misfit;
use crate::drive::State;
use crate::event::{Event, ProcessData, Step, What};
use crate::finding::{Code, Finding};
use crate::frame::{self, BusId, Frame, FrameRef};
use crate::message::Message;
use crate::services::heartbeat::OPERATIONAL;
use crate::services::sdo::transfer::Status as Transferred;
use crate::services::sdo::wire::Side;

/// A node that is back has this time to be started again, in ns.
const START_NS: i64 = 5_000_000_000;
/// An error stands once it was not taken back for so long, in ns.
const SETTLED_NS: i64 = 500_000_000;
/// A node that was stopped by command for so long while others run is left alone, in ns.
const ALONE_NS: i64 = 2_000_000_000;
/// Incidents that are over and may begin again.
const CLOSED: usize = 64;
/// Error frames, and nothing else, that show a wrong bit rate.
const ERRORS_ONLY: u64 = 10;
/// SYNCs further apart than this show no period, in ns.
const LONGEST_SYNC_NS: i64 = 2_000_000_000;

/// What went wrong in a capture.
#[derive(Clone, Debug, Default)]
pub struct Diagnosis {
    ledger: Ledger,
    buses: Vec<OfBus>,
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

/// What is open on one bus.
#[derive(Clone, Debug, Default)]
struct OfBus {
    heard: Heard,
    nodes: Nodes,
    emergencies: Emergencies,
    drives: Drives,
    configurations: Configurations,
    found: Found,
    /// Frames of the bus.
    frames: u64,
    /// Whether the node that has booted last was Operational before.
    was: bool,
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
            self.buses.resize_with(index + 1, OfBus::default);
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
        changes
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
    }

    /// All incidents.
    pub fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    /// Frames so far, and the first and the last of them.
    pub fn extent(&self) -> (u64, Option<FrameRef>, FrameRef) {
        (self.frames, self.first, self.last)
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

/// What a tracker is handed, from the fields that it does not own.
macro_rules! scene {
    ($self:ident, $ledger:ident, $bus:ident, $id:expr, $at:expr) => {
        &mut Scene { ledger: $ledger, bus: $bus, id: $id, heard: &$self.heard, at: $at }
    };
}

impl OfBus {
    fn frame(&mut self, frame: &Frame, events: &[Event], bus: &Bus, ledger: &mut Ledger) {
        let (at, id, before) = (frame.reference(), frame.bus, ledger.all.len());
        self.frames += 1;
        let mut dirty = false;
        // A node that is heard too late was silent until then.
        for event in events {
            if let What::Finding(finding) = &event.what
                && let (Code::Hbt002, Some(node)) = (finding.code, finding.node)
            {
                self.nodes.lost(node, finding, scene!(self, ledger, bus, id, at));
            }
        }
        for event in events {
            dirty |= match &event.what {
                What::Message(message) => self.message(message, frame, bus, ledger),
                What::Pdo(data) => self.pdo(data, frame, bus, ledger),
                What::Mpdo(data) if data.transmit => self.alive(data.node, frame, bus, ledger),
                What::Sdo(step) => self.sdo(step, event.node, frame, bus, ledger),
                What::Transfer(transfer) => {
                    self.drives.transfer(transfer);
                    self.configurations.transfer(transfer, scene!(self, ledger, bus, id, at));
                    if transfer.outcome.status == Transferred::Ok && !transfer.outcome.bad {
                        let sign = Sign { ends: Ends::Transferred, node: Some(transfer.node), pdo: None };
                        self.found.sign(sign, scene!(self, ledger, bus, id, at));
                    }
                    false
                }
                What::Finding(finding) => self.finding(finding, id, at, bus, ledger),
                What::Mpdo(_) | What::Note(_) => false,
            };
        }
        if !self.found.is_empty() && frame.kind != frame::Kind::Error {
            self.found.sign(Sign { ends: Ends::Traffic, node: None, pdo: None }, scene!(self, ledger, bus, id, at));
        }
        self.conclude(before, dirty, id, at, bus, ledger);
    }

    /// A finding that belongs to no frame at hand.
    fn aside(&mut self, finding: &Finding, at: FrameRef, bus: &Bus, ledger: &mut Ledger) {
        let (id, before) = (finding.bus, ledger.all.len());
        if let (Code::Hbt002, Some(node)) = (finding.code, finding.node) {
            self.nodes.lost(node, finding, scene!(self, ledger, bus, id, at));
        }
        let dirty = self.finding(finding, id, at, bus, ledger);
        self.conclude(before, dirty, id, at, bus, ledger);
    }

    /// What has ended by what the frame has shown, and from where the new incidents come.
    #[inline]
    fn conclude(&mut self, before: usize, dirty: bool, id: BusId, at: FrameRef, bus: &Bus, ledger: &mut Ledger) {
        if dirty {
            self.end(id, at, bus, ledger);
        }
        for place in before..ledger.all.len() {
            links::link(ledger, place, id);
        }
    }

    /// Troubles of which nothing is left are over.
    fn end(&mut self, id: BusId, at: FrameRef, bus: &Bus, ledger: &mut Ledger) {
        for place in ledger.recent(id) {
            let (waits, in_fault) = (self.nodes.waits(place), self.drives.holds(place));
            let Some(one) = ledger.get_mut(place) else { continue };
            let enabled = || {
                let mut states = one.subject.node.into_iter().flat_map(|node| bus.drive_states(node));
                states.any(|(_, state)| state == State::OperationEnabled)
            };
            let fault = one.kind == Kind::AxisFault;
            let of_errors = !one.clue.reported.is_empty() || fault;
            let gone = one.clue.codes.is_empty() || fault && enabled();
            if one.end.is_none() && of_errors && !waits && !in_fault && gone {
                one.ends(at);
            }
        }
    }

    /// A node has sent a frame that is no boot-up.
    #[inline]
    fn alive(&mut self, node: u8, frame: &Frame, bus: &Bus, ledger: &mut Ledger) -> bool {
        let (at, id) = (frame.reference(), frame.bus);
        self.nodes.heard(node, false, scene!(self, ledger, bus, id, at));
        self.heard.frame(node, at);
        if !self.found.is_empty() {
            let sign = Sign { ends: Ends::Heard, node: Some(node), pdo: None };
            self.found.sign(sign, scene!(self, ledger, bus, id, at));
        }
        if self.drives.is_empty() {
            return false;
        }
        self.drives.heard(node, at, scene!(self, ledger, bus, id, at))
    }

    fn pdo(&mut self, data: &ProcessData, frame: &Frame, bus: &Bus, ledger: &mut Ledger) -> bool {
        let (at, id) = (frame.reference(), frame.bus);
        if !self.found.is_empty() {
            let pdo = Some((data.transmit, data.number));
            let mut ends = vec![Ends::Pdo];
            if self.found.measures() && misfit(&data.content, frame).is_none() {
                ends.push(Ends::Length);
            }
            for ends in ends {
                self.found.sign(Sign { ends, node: Some(data.node), pdo }, scene!(self, ledger, bus, id, at));
            }
        }
        self.drives.pdo(data, frame, scene!(self, ledger, bus, id, at));
        if !data.transmit {
            self.heard.control = at;
            return false;
        }
        self.heard.serves(data.node);
        let dirty = self.alive(data.node, frame, bus, ledger);
        // A node without heartbeats shows by its PDOs that it is started.
        if data.state == Some(OPERATIONAL) && self.nodes.is_waiting(data.node) {
            self.heard.operational |= bit(data.node);
            self.nodes.state(data.node, OPERATIONAL, scene!(self, ledger, bus, id, at));
            return true;
        }
        dirty
    }

    fn sdo(&mut self, step: &Step, node: Option<u8>, frame: &Frame, bus: &Bus, ledger: &mut Ledger) -> bool {
        let (at, id) = (frame.reference(), frame.bus);
        let (Side::Server, Some(node)) = (step.side, node) else {
            self.heard.control = at;
            return false;
        };
        self.heard.serves(node);
        if !self.found.is_empty() {
            let sign = Sign { ends: Ends::Answered, node: Some(node), pdo: None };
            self.found.sign(sign, scene!(self, ledger, bus, id, at));
        }
        self.alive(node, frame, bus, ledger)
    }

    fn message(&mut self, message: &Message, frame: &Frame, bus: &Bus, ledger: &mut Ledger) -> bool {
        let (at, id) = (frame.reference(), frame.bus);
        match *message {
            Message::BootUp { node } => {
                self.was = self.heard.is_operational(node);
                self.nodes.booted(node, scene!(self, ledger, bus, id, at));
                self.emergencies.booted(node, scene!(self, ledger, bus, id, at));
                self.drives.booted(node, scene!(self, ledger, bus, id, at));
                self.configurations.booted(node, scene!(self, ledger, bus, id, at));
                self.heard.frame(node, at);
                self.heard.operational &= !bit(node);
                for ends in [Ends::Heard, Ends::Guarded] {
                    let sign = Sign { ends, node: Some(node), pdo: None };
                    self.found.sign(sign, scene!(self, ledger, bus, id, at));
                }
                true
            }
            Message::Heartbeat { node, state, .. } => {
                self.nodes.heard(node, true, scene!(self, ledger, bus, id, at));
                self.heard.heartbeat(node, at);
                let before = self.heard.is_operational(node);
                match state {
                    OPERATIONAL => self.heard.operational |= bit(node),
                    _ => self.heard.operational &= !bit(node),
                }
                let changed = state == OPERATIONAL && (!before || self.nodes.is_waiting(node));
                if changed {
                    self.nodes.state(node, state, scene!(self, ledger, bus, id, at));
                    let sign = Sign { ends: Ends::Guarded, node: Some(node), pdo: None };
                    self.found.sign(sign, scene!(self, ledger, bus, id, at));
                }
                self.alive(node, frame, bus, ledger) || changed
            }
            Message::Emcy { node, code, register, manufacturer, active, .. } => {
                self.heard.serves(node);
                let emergency = Emergency { node, code, register, manufacturer, active };
                let dirty = self.alive(node, frame, bus, ledger);
                self.emergencies.emergency(emergency, scene!(self, ledger, bus, id, at));
                dirty || code <= 0xFF
            }
            Message::Nmt { command, node } if node <= 127 => {
                self.heard.control = at;
                let before = self.heard.operational;
                let meant = self.heard.known & if node == 0 { u128::MAX } else { bit(node) };
                if command == 0x01 {
                    self.heard.operational |= meant;
                } else if matches!(command, 0x02 | 0x80..=0x82) {
                    self.heard.operational &= !meant;
                }
                self.nodes.commanded(command, node, before, scene!(self, ledger, bus, id, at));
                false
            }
            Message::Sync { .. } => {
                let gap = at.since(Some(self.heard.sync).filter(|last| last.no > 0));
                self.heard.sync_period_ns =
                    gap.filter(|gap| (1..LONGEST_SYNC_NS).contains(gap)).or(self.heard.sync_period_ns);
                (self.heard.sync, self.heard.control) = (at, at);
                if !self.found.is_empty() {
                    let sign = Sign { ends: Ends::Sync, node: None, pdo: None };
                    self.found.sign(sign, scene!(self, ledger, bus, id, at));
                }
                false
            }
            Message::ErrorFrame => {
                self.heard.errors = (self.heard.errors.0 + 1, at);
                false
            }
            _ => false,
        }
    }

    /// What a rule has found goes to whoever follows it.
    fn finding(&mut self, finding: &Finding, id: BusId, at: FrameRef, bus: &Bus, ledger: &mut Ledger) -> bool {
        let scene = scene!(self, ledger, bus, id, at);
        match (finding.code, finding.node) {
            (Code::Hbt002, _) => {}
            (Code::Nmt003, Some(node)) => self.nodes.restarted(node, finding, self.was, scene),
            (Code::Nmt004 | Code::Nmt005, Some(node)) => self.nodes.changed(node, finding, scene),
            (Code::Nmt002 | Code::Nmt006, Some(node)) => self.nodes.owes(node, finding, scene),
            (code, Some(node)) if code.rule().id.starts_with("EMC") => {
                if !self.emergencies.found(node, finding, scene) {
                    self.found.found(finding, scene!(self, ledger, bus, id, at));
                }
            }
            (Code::Sdo018, Some(node)) => self.configurations.stays(node, finding, scene),
            (Code::Drv005, Some(node)) => self.drives.fault(node, finding, scene),
            (Code::Drv002, Some(node)) => self.drives.stuck(node, finding, scene),
            (Code::Bus006, _) => {
                for ends in [Ends::Controller, Ends::Traffic] {
                    let sign = Sign { ends, node: None, pdo: None };
                    self.found.sign(sign, scene!(self, ledger, bus, id, at));
                }
            }
            _ => {
                self.found.found(finding, scene);
            }
        }
        false
    }

    /// The capture is over.
    fn finish(&mut self, id: BusId, end: FrameRef, bus: &Bus, ledger: &mut Ledger) {
        let mine = ledger.all.iter().any(|one| one.bus == id);
        if self.heard.errors.0 >= ERRORS_ONLY && self.heard.errors.0 == self.frames {
            ledger.open(Kind::WrongBitRate, id, incident::Subject::default(), self.heard.errors.1, self.heard.errors.1);
        } else if !mine {
            return;
        }
        self.nodes.finish(scene!(self, ledger, bus, id, end));
        self.found.finish(end, scene!(self, ledger, bus, id, end));
        for place in 0..ledger.all.len() {
            let back = self.nodes.back(place);
            let Some(one) = ledger.get_mut(place).filter(|one| one.bus == id) else { continue };
            let gone = one.subject.node.is_some_and(|node| self.nodes.is_silent(node));
            let others = self.heard.operational & !one.subject.nodes & self.heard.serving != 0;
            let long = end.since(one.begin).is_some_and(|since| since >= ALONE_NS);
            one.status = status(one, end, (back, gone, others && long));
            if one.status == Status::Stands {
                one.end = None;
            }
        }
    }
}

/// Whether a kind is explained by a command or by the recording.
fn is_harmless(kind: Kind) -> bool {
    use Kind::{BusSilent, CaptureGap, CommandedReset, CommandedStop, NotCanopen};
    matches!(kind, BusSilent | CaptureGap | CommandedReset | CommandedStop | NotCanopen)
}

/// Whether an incident is over by now, and will not have to be told again at once.
fn is_over(one: &incident::Incident, last: FrameRef) -> bool {
    one.end.is_some() && one.kind != Kind::ConsumerTimeTooShort && !goes_on(one, last)
}

/// Whether what has come again and again, and whose next time is not due yet, goes on.
fn goes_on(one: &incident::Incident, end: FrameRef) -> bool {
    use Kind::{NodeRestarted, NodeSilent, RequestUnanswered, RestartLoop, SegmentLost};
    let mean = one.repeats.since.since(one.begin).map(|all| all / one.repeats.count.saturating_sub(1).max(1) as i64);
    let comes_again = !one.clue.reported.is_empty()
        || matches!(one.kind, NodeRestarted | RestartLoop | NodeSilent | SegmentLost | RequestUnanswered);
    let rest = end.since(one.end.unwrap_or(one.repeats.since));
    let soon = mean.zip(rest).is_some_and(|(mean, rest)| rest < mean.saturating_mul(2));
    one.repeats.count >= GOES_ON && comes_again && soon
}

/// How an incident stands at the end. `back`: since when its node has been back without being started; `gone`: its node
/// cannot be heard any more; `left_alone`: others have been Operational for long while it is not.
fn status(one: &incident::Incident, end: FrameRef, (back, gone, left_alone): (Option<FrameRef>, bool, bool)) -> Status {
    use Kind::{
        CommandedStop, ConsumerTimeTooShort, HeartbeatStopped, NodeAbsent, NodeSilent, RequestUnanswered, SegmentLost,
    };
    match one.kind {
        // One node that stays stopped while others run is not what anybody wants.
        CommandedStop if one.end.is_none() && left_alone => return Status::Stands,
        kind if is_harmless(kind) => return Status::Harmless,
        ConsumerTimeTooShort => return Status::Stands,
        _ => {}
    }
    if goes_on(one, end) {
        return Status::Stands;
    }
    if one.end.is_some() {
        return Status::Over;
    }
    if let Some(back) = back {
        return if end.since(back).is_some_and(|since| since < START_NS) { Status::Unknown } else { Status::Stands };
    }
    // An error that was reported at the very end may be taken back at once.
    if !one.clue.reported.is_empty() && end.since(one.repeats.since).is_none_or(|since| since < SETTLED_NS) {
        return Status::Unknown;
    }
    // Not every controller says that it is active again.
    if one.kind == Kind::ErrorPassive {
        return Status::Unknown;
    }
    // A refused write may still be made good where the capture ends too soon for the rule to say.
    if one.facts.iter().any(|(name, _)| *name == "refused") {
        let stays = one.findings.iter().any(|(code, _)| *code == Code::Sdo018);
        return if stays { Status::Stands } else { Status::Unknown };
    }
    let silent = matches!(one.kind, NodeSilent | HeartbeatStopped | SegmentLost | RequestUnanswered | NodeAbsent);
    if gone && !silent { Status::Unknown } else { Status::Stands }
}

//! The diagnosis of one bus: passes each frame and its events to the trackers concerned.
//!
//! The order matters: nodes that are heard again are recorded before the problems that this ends. Only trackers open
//! problems.

use super::kinds::ProblemKind;
use super::ledger::Ledger;
use super::links;
use super::problem::{self, Problem, Status, StepRole, bit};
use super::roles::KindRole;
use super::sayings::Saying;
use super::scene::{Heard, Last, Scene};
use super::signs::Ends;
use super::status::status;
use super::trackers::boots::Boots;
use super::trackers::configuration::Configurations;
use super::trackers::drive::Drives;
use super::trackers::emcy::{Emergencies, LIFE_GUARD};
use super::trackers::heartbeats;
use super::trackers::heartbeats::MissingHeartbeats;
use super::trackers::identity::Identities;
use super::trackers::idle::IdleNodes;
use super::trackers::in_vain::InVain;
use super::trackers::load::LoadProblem;
use super::trackers::masters::Masters;
use super::trackers::motion::Motions;
use super::trackers::nodes::NodeProblems;
use super::trackers::pdos::Pdos;
use super::trackers::rules::{RuleProblems, Sign};
use crate::bytes::frame::{self, BusId, Frame, FrameRef};
use crate::bytes::ns::Ns;
use crate::checks::pdo::length::fits;
use crate::rules::finding::{Code, Finding, Quantity};
use crate::sdo::abort_code::AbortCode;
use crate::sdo::transfer::{Direction, Status as Transferred, Transfer};
use crate::sdo::wire::{Command, Side};
use crate::wire::error_control::{BOOT_UP, OPERATIONAL, PRE_OPERATIONAL, STOPPED};
use crate::wire::lss::command as lss;
use crate::wire::message::Message;
use crate::world::bus::Bus;
use crate::world::change::{Change, EmcyChange};
use crate::world::drive::DriveState;
use crate::world::event::{Event, Note, ProcessData, Step, What};

/// Minimum time for which a node stopped by command is left alone while others run, in ns.
const ALONE_NS: Ns = Ns::from_s(2);
/// Minimum number of error frames that show a wrong bit rate if there are no other frames.
const ERRORS_ONLY: u64 = 10;
/// Maximum time for which storing parameters or a program keeps a node busy, in ns.
const STORING_NS: Ns = Ns::from_s(10);
/// The error register (CiA 301, 7.5.2.2).
const ERROR_REGISTER: u16 = 0x1001;
/// Objects by which parameters are stored and restored, and programs written and started (CiA 301, CiA 302-3).
const STORES: [u16; 4] = [0x1010, 0x1011, 0x1F50, 0x1F51];
/// Maximum gap between SYNCs from which a period is taken, in ns.
const LONGEST_SYNC_NS: Ns = Ns::from_s(2);

/// Maximum difference of the gaps between the heartbeats of one node, in ns: that of a slow task.
const UNEVEN_NS: Ns = Ns::from_ms(50);

/// Returns true if the gaps of heartbeats alternate (HBT004) by no more than a slow task explains.
fn is_uneven(finding: &Finding) -> bool {
    let gap = |name: &str| match finding.measured().and_then(|all| all.get(name)) {
        Some(Quantity::Ns(ns)) => Some(ns),
        _ => None,
    };
    let Some((one, other)) = gap("one").zip(gap("other")) else { return false };
    let apart = (one - other).abs();
    // Of a series beside another both are nearly the same; twice as many without one are of a shorter period.
    let series = apart * 4 < one + other;
    if series { apart == Ns::ZERO } else { apart < UNEVEN_NS }
}

/// The open problems of one bus.
#[derive(Clone, Debug, Default)]
pub(super) struct OfBus {
    pub(super) heard: Heard,
    nodes: NodeProblems,
    emergencies: Emergencies,
    drives: Drives,
    configurations: Configurations,
    boots: Boots,
    idle: IdleNodes,
    masters: Masters,
    load: LoadProblem,
    motions: Motions,
    heartbeats: MissingHeartbeats,
    identities: Identities,
    in_vain: InVain,
    pdos: Pdos,
    found: RuleProblems,
    /// Number of frames of the bus.
    frames: u64,
    /// True if the last node that booted was Operational before.
    was: bool,
}

/// Makes the scene for a tracker from the fields that it does not own.
macro_rules! scene {
    ($self:ident, $ledger:ident, $bus:ident, $id:expr, $at:expr) => {
        &mut Scene { ledger: $ledger, bus: $bus, id: $id, heard: &$self.heard, at: $at }
    };
}

impl OfBus {
    /// Creates the state of a bus without frames; its bit rate in bit/s, if known.
    pub(super) fn new(bit_rate: Option<u32>) -> Self {
        let mut bus = Self::default();
        bus.heard.bit_rate = bit_rate;
        bus
    }

    /// Completes a problem that is open at the end; its kind may be plainer than at first.
    fn stands(&self, place: usize, back: Option<FrameRef>, end: FrameRef, ledger: &mut Ledger) {
        let Some(one) = ledger.get_mut(place) else { return };
        let unheard = one.clue.watched.iter().find(|(node, _)| self.heard.known & bit(*node) == 0);
        match (one.kind, unheard) {
            (kind, Some((node, _))) if kind.is(KindRole::Reported) => {
                let node = *node;
                heartbeats::never_seen(one, node);
            }
            (kind, _) if one.has("started") && !kind.is(KindRole::Program) => one.kind = ProblemKind::HalfConfigured,
            _ => {}
        }
        // The node is back and was not started again.
        if let Some(since) = back.and_then(|back| end.since(back)) {
            one.fact("waits_to_be_started", Quantity::Ns(since));
            one.step(end, StepRole::Reaction, Saying::NotStartedSince { since }, None);
        }
    }

    /// Passes on a frame with its events.
    pub(super) fn frame(&mut self, frame: &Frame, events: &[Event], bus: &Bus, ledger: &mut Ledger) {
        let (at, id, before) = (frame.reference(), frame.bus, ledger.all.len());
        self.frames += 1;
        let mut dirty = false;
        // A second sighting was on the bus once.
        let again = bus.shows_again();
        let (mut is_pdo, mut is_lost) = (false, false);
        for event in events {
            is_pdo |= matches!(event.what, What::Pdo(_));
            is_lost |= matches!(&event.what, What::Finding(finding) if finding.code == Code::Hbt002);
        }
        if frame.kind == frame::Kind::Data && !again {
            let node = events.first().and_then(|event| event.node);
            self.load.frame(frame, node, scene!(self, ledger, bus, id, at));
            self.identities.frame(frame);
            if !is_pdo {
                self.pdos.unknown(frame, scene!(self, ledger, bus, id, at));
            }
        }
        // A node whose frame is overdue was silent until then.
        for event in events.iter().filter(|_| is_lost) {
            if let What::Finding(finding) = &event.what
                && let (Code::Hbt002, Some(node)) = (finding.code, finding.node)
            {
                self.nodes.lost(node, finding, scene!(self, ledger, bus, id, at));
            }
        }
        for event in events {
            dirty |= match &event.what {
                What::Message(_) | What::Pdo(_) | What::Mpdo(_) | What::Sdo(_) if again => false,
                What::Message(Message::Usdo { request, source, .. }) => {
                    self.usdo((*request, *source, event.node), frame, bus, ledger)
                }
                What::Message(message) => self.message(message, at, id, bus, ledger),
                What::Change(change @ Change::Drive { .. }) => self.drive(change, id, at, bus, ledger),
                What::Change(change) => self.change(change, frame, bus, ledger),
                What::Pdo(data) => self.pdo(data, frame, bus, ledger),
                What::Mpdo(data) if data.transmit => self.alive(data.node, frame, bus, ledger),
                What::Sdo(step) => {
                    let told = events.iter().any(|event| matches!(event.what, What::Transfer(_) | What::Finding(_)));
                    if let Some(node) = event.node.filter(|_| !told) {
                        self.configurations.step(node, step, scene!(self, ledger, bus, id, at));
                    }
                    self.sdo(step, event.node, frame, bus, ledger)
                }
                What::Transfer(transfer) => {
                    self.transfer(transfer, id, at, bus, ledger);
                    transfer.mux.is_some_and(|mux| mux.index == ERROR_REGISTER)
                }
                What::Finding(finding) => self.finding(finding, id, at, bus, ledger),
                What::Note(Note::BitTimingActivated { .. }) => {
                    ledger.open(ProblemKind::BitTiming, id, problem::Subject::default(), event.at, at);
                    false
                }
                What::Note(Note::NodeIdChanged { from, .. }) => {
                    self.nodes.moved(*from, scene!(self, ledger, bus, id, at));
                    true
                }
                What::Mpdo(_) | What::Note(_) => false,
            };
        }
        if !self.found.is_empty() && frame.kind != frame::Kind::Error {
            self.found.sign(Sign::of(Ends::Traffic, None), scene!(self, ledger, bus, id, at));
        }
        self.conclude(before, dirty, id, at, bus, ledger);
    }

    fn transfer(&mut self, transfer: &Transfer, id: BusId, at: FrameRef, bus: &Bus, ledger: &mut Ledger) {
        self.drives.transfer(transfer);
        self.pdos.transfer(transfer);
        self.motions.transfer(transfer, scene!(self, ledger, bus, id, at));
        self.emergencies.transfer(transfer, scene!(self, ledger, bus, id, at));
        if transfer.shows_no_error() {
            self.heard.reports(transfer.node, None, at);
        }
        self.boots.transfer(transfer, &self.heard);
        self.heartbeats.transfer(transfer, scene!(self, ledger, bus, id, at));
        self.identities.transfer(transfer, scene!(self, ledger, bus, id, at));
        self.in_vain.transfer(transfer, scene!(self, ledger, bus, id, at));
        self.configurations.transfer(transfer, scene!(self, ledger, bus, id, at));
        let failed = transfer.outcome.status != Transferred::Ok || transfer.outcome.bad;
        if failed && transfer.direction == Direction::Download && !self.found.is_empty() {
            self.found.not_written(transfer, scene!(self, ledger, bus, id, at));
        }
        if !failed {
            self.found.served(transfer);
            let sign = Sign::of(Ends::Transferred, Some(transfer.node));
            self.found.sign(sign, scene!(self, ledger, bus, id, at));
            if transfer.direction == Direction::Download {
                let sign = Sign { ends: Ends::Written, object: transfer.mux, ..sign };
                self.found.sign(sign, scene!(self, ledger, bus, id, at));
            }
        }
    }

    /// Passes on the end of a transfer without a frame at hand.
    pub(super) fn transferred(&mut self, transfer: &Transfer, at: FrameRef, bus: &Bus, ledger: &mut Ledger) {
        let (id, before) = (transfer.bus, ledger.all.len());
        self.transfer(transfer, id, at, bus, ledger);
        self.conclude(before, false, id, at, bus, ledger);
    }

    /// Passes on a finding without a frame at hand.
    pub(super) fn aside(&mut self, finding: &Finding, at: FrameRef, bus: &Bus, ledger: &mut Ledger) {
        let (id, before) = (finding.bus, ledger.all.len());
        if let (Code::Hbt002, Some(node)) = (finding.code, finding.node) {
            self.nodes.lost(node, finding, scene!(self, ledger, bus, id, at));
        }
        let dirty = self.finding(finding, id, at, bus, ledger);
        self.conclude(before, dirty, id, at, bus, ledger);
    }

    /// Ends problems after a frame and links the new ones to their causes.
    #[inline]
    fn conclude(&mut self, before: usize, dirty: bool, id: BusId, at: FrameRef, bus: &Bus, ledger: &mut Ledger) {
        if dirty {
            self.end(id, at, bus, ledger);
        }
        for place in before..ledger.all.len() {
            self.stored(place, id, ledger);
        }
        for place in before..ledger.all.len() {
            links::link(ledger, place, id);
        }
        for place in std::mem::take(&mut ledger.grown) {
            links::link(ledger, place, id);
        }
    }

    /// Adds an order to store something, or to change the program, as the explanation if a node then is silent, late or
    /// boots: it may be busy for a while.
    fn stored(&self, place: usize, id: BusId, ledger: &mut Ledger) {
        let Some(one) = ledger.get(place) else { return };
        let busy = one.kind.is(KindRole::Busy);
        let Some((node, begin)) = one.subject.node.filter(|_| busy).map(|node| (node, one.noticed)) else { return };
        let Some(stored) = self.heard.noted(Last::Stored, node) else { return };
        let near = begin.since(stored).is_some_and(|since| (Ns::ZERO..=STORING_NS).contains(&since));
        let known = ledger.last(id, |one| one.kind.is(KindRole::Storing) && one.begin.no == stored.no).is_some();
        if near && !known {
            ledger.open(ProblemKind::Storing, id, problem::Subject::node(node), stored, stored);
        }
    }

    /// Ends problems with nothing left open.
    fn end(&mut self, id: BusId, at: FrameRef, bus: &Bus, ledger: &mut Ledger) {
        for place in ledger.recent(id) {
            let (waits, in_fault) = (self.nodes.waits(place), self.drives.holds(place));
            let Some(one) = ledger.get_mut(place) else { continue };
            let enabled = || {
                let mut states = one.subject.node.into_iter().flat_map(|node| bus.drive_states(node));
                states.any(|(_, state)| state == DriveState::OperationEnabled)
            };
            let fault = one.kind.is(KindRole::Fault);
            let of_errors = !one.clue.reported.is_empty() || fault;
            let gone = one.clue.codes.is_empty() || fault && enabled();
            if one.end.is_none() && of_errors && !waits && !in_fault && gone {
                one.ends(at);
            }
        }
    }

    /// Records a frame of a node that is not a boot-up.
    #[inline]
    fn alive(&mut self, node: u8, frame: &Frame, bus: &Bus, ledger: &mut Ledger) -> bool {
        let (at, id) = (frame.reference(), frame.bus);
        self.nodes.heard(node, false, scene!(self, ledger, bus, id, at));
        self.heard.frame(node, at);
        self.configurations.heard(node, false, scene!(self, ledger, bus, id, at));
        if !self.found.is_empty() {
            let sign = Sign::of(Ends::Heard, Some(node));
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
            let mut ends = vec![Ends::Pdo, Ends::Former];
            if self.found.measures() && fits(&data.content, frame) {
                ends.push(Ends::Length);
            }
            for ends in ends {
                self.found.sign(
                    Sign { pdo, length: frame.len.into(), ..Sign::of(ends, Some(data.node)) },
                    scene!(self, ledger, bus, id, at),
                );
            }
        }
        self.drives.pdo(data, frame, scene!(self, ledger, bus, id, at));
        if self.drives.is_drive(data.node) || bus.drive_states(data.node).next().is_some() {
            self.motions.pdo(data, frame, scene!(self, ledger, bus, id, at));
            if data.transmit {
                self.drives.stays(data.node, scene!(self, ledger, bus, id, at));
            }
        }
        self.pdos.pdo(data, frame, scene!(self, ledger, bus, id, at));
        if !data.transmit {
            self.heard.control = at;
            let taken = data.state.is_none_or(|state| state == OPERATIONAL);
            self.nodes.controlled(data.node, taken, scene!(self, ledger, bus, id, at));
            return false;
        }
        self.heard.serves(data.node);
        self.heard.note(Last::Pdo, data.node, at);
        let dirty = self.alive(data.node, frame, bus, ledger);
        // A node without heartbeats shows by its PDOs that it is started.
        let booted = self.heard.states.get(usize::from(data.node)) == Some(&Some(BOOT_UP));
        if booted && data.state == Some(OPERATIONAL) {
            self.heard.state(data.node, Some(OPERATIONAL));
        }
        if data.state == Some(OPERATIONAL) && self.nodes.is_waiting(data.node) {
            self.heard.operational |= bit(data.node);
            self.nodes.state(data.node, OPERATIONAL, false, scene!(self, ledger, bus, id, at));
            return true;
        }
        dirty
    }

    /// Passes on a statusword of an axis.
    pub(super) fn drive(&mut self, change: &Change, id: BusId, at: FrameRef, bus: &Bus, ledger: &mut Ledger) -> bool {
        if let Change::Drive { node, state: Some(state), .. } = change {
            self.drives.reports(*node, *state);
        }
        self.motions.reported(change, scene!(self, ledger, bus, id, at));
        false
    }

    fn sdo(&mut self, step: &Step, node: Option<u8>, frame: &Frame, bus: &Bus, ledger: &mut Ledger) -> bool {
        let (at, id) = (frame.reference(), frame.bus);
        if let Some(node) = node.filter(|_| (0x580..0x680).contains(&frame.id.raw())) {
            self.heard.exchanged(node, step.side == Side::Client, at);
        }
        let (Side::Server, Some(node)) = (step.side, node) else {
            self.heard.control = at;
            if let (Some(node), Some(mux)) = (node, step.command.mux()) {
                self.masters.asked(node, mux, at);
                self.identities.asked(node, mux, frame, scene!(self, ledger, bus, id, at));
                if self.heard.last(node).is_none() {
                    self.configurations.asked(node, at);
                }
            }
            if let (Some(node), Command::Abort(_, code)) = (node, step.command)
                && self.heard.last(node).is_none()
            {
                self.configurations.given_up(node, AbortCode::Sdo(code), scene!(self, ledger, bus, id, at));
            }
            let (Command::InitiateDownload(mux, _) | Command::InitiateBlockDownload { mux, .. }) = step.command else {
                return false;
            };
            if let Some(node) = node {
                self.heard.writes(node, at);
                self.motions.asked(node, mux.index);
                if STORES.contains(&mux.index) {
                    self.heard.note(Last::Stored, node, at);
                }
            }
            return false;
        };
        self.heard.answers(node, at);
        self.identities.answered(node, step.command.mux(), frame);
        if let Some(mux) = step.command.mux() {
            self.masters.answered(node, mux, scene!(self, ledger, bus, id, at));
        }
        if !self.found.is_empty() {
            let sign = Sign::of(Ends::Answered, Some(node));
            self.found.sign(sign, scene!(self, ledger, bus, id, at));
        }
        self.alive(node, frame, bus, ledger)
    }

    /// Processes a frame of USDO: its sender, and the server of its transfer unless it is to all.
    fn usdo(
        &mut self,
        (request, source, server): (bool, u8, Option<u8>),
        frame: &Frame,
        bus: &Bus,
        ledger: &mut Ledger,
    ) -> bool {
        let (at, id) = (frame.reference(), frame.bus);
        if let Some(server) = server {
            self.heard.exchanged(server, request, at);
        }
        if request {
            self.heard.control = at;
            let writes = matches!(frame.payload().get(1), Some(0x01 | 0x02));
            if let Some(server) = server.filter(|_| writes) {
                self.heard.writes(server, at);
            }
        } else {
            self.heard.answers(source, at);
            let sign = Sign::of(Ends::Answered, Some(source));
            self.found.sign(sign, scene!(self, ledger, bus, id, at));
        }
        (1..=127).contains(&source) && self.alive(source, frame, bus, ledger)
    }

    fn message(&mut self, message: &Message, at: FrameRef, id: BusId, bus: &Bus, ledger: &mut Ledger) -> bool {
        match *message {
            Message::Lss { from_master: false, command: lss::Command::Confirmation { error: 0, .. } }
                if !self.found.is_empty() =>
            {
                self.found.sign(Sign::of(Ends::Lss, None), scene!(self, ledger, bus, id, at));
            }
            Message::Srdo { number, valid: Some(true), .. } if !self.found.is_empty() => {
                let sign = Sign { srdo: number, ..Sign::of(Ends::Srdo, None) };
                self.found.sign(sign, scene!(self, ledger, bus, id, at));
            }
            Message::GuardingRequest { node } if !self.found.is_empty() => {
                self.found.sign(Sign::of(Ends::Guarded, Some(node)), scene!(self, ledger, bus, id, at));
            }
            Message::ErrorFrame => {
                let first = if self.heard.errors.0 == 0 { at } else { self.heard.errors.1 };
                self.heard.errors = (self.heard.errors.0 + 1, first);
                self.heard.last_error = at;
            }
            _ => {}
        }
        false
    }

    fn change(&mut self, change: &Change, frame: &Frame, bus: &Bus, ledger: &mut Ledger) -> bool {
        let (at, id) = (frame.reference(), frame.bus);
        match *change {
            Change::BootUp { node } => {
                self.heard.state(node, Some(BOOT_UP));
                self.heard.reports(node, None, at);
                self.was = self.heard.is_operational(node);
                self.nodes.booted(node, scene!(self, ledger, bus, id, at));
                self.emergencies.booted(node, scene!(self, ledger, bus, id, at));
                self.drives.booted(node, scene!(self, ledger, bus, id, at));
                self.motions.booted(node, scene!(self, ledger, bus, id, at));
                self.boots.booted(node, at);
                self.idle.booted(node, self.was, at);
                self.heartbeats.booted(node, scene!(self, ledger, bus, id, at));
                self.identities.booted(node);
                self.in_vain.booted(node, scene!(self, ledger, bus, id, at));
                self.found.booted(node, at);
                self.pdos.stopped(node);
                self.load.booted(node, scene!(self, ledger, bus, id, at));
                self.configurations.heard(node, true, scene!(self, ledger, bus, id, at));
                self.configurations.booted(node, scene!(self, ledger, bus, id, at));
                self.heard.frame(node, at);
                self.heard.operational &= !bit(node);
                for ends in [Ends::Heard, Ends::Guarded, Ends::Controlled, Ends::State] {
                    let sign = Sign { boot_up: true, ..Sign::of(ends, Some(node)) };
                    self.found.sign(sign, scene!(self, ledger, bus, id, at));
                }
                true
            }
            Change::Lost { node, .. } => {
                let all = if node.is_none() { 1..=127 } else { 0..=0 };
                for node in node.into_iter().chain(all) {
                    self.heard.state(node, None);
                    self.idle.lost(node);
                }
                false
            }
            Change::State { node, state, previous, guarding, .. } => {
                self.heard.state(node, Some(state));
                self.heard.guarded |= if guarding { bit(node) } else { 0 };
                self.nodes.heard(node, true, scene!(self, ledger, bus, id, at));
                self.heartbeats.beat(node, scene!(self, ledger, bus, id, at));
                if !self.found.is_empty() {
                    self.found.sign(Sign::of(Ends::Controlled, Some(node)), scene!(self, ledger, bus, id, at));
                    if matches!(state, BOOT_UP | STOPPED | OPERATIONAL | PRE_OPERATIONAL) {
                        self.found.sign(Sign::of(Ends::State, Some(node)), scene!(self, ledger, bus, id, at));
                    }
                }
                self.heard.note(Last::Heartbeat, node, at);
                self.idle.reports(node, state, at);
                let before = self.heard.is_operational(node);
                match state {
                    OPERATIONAL => self.heard.operational |= bit(node),
                    _ => self.heard.operational &= !bit(node),
                }
                if state == OPERATIONAL {
                    self.pdos.beat(node, scene!(self, ledger, bus, id, at));
                }
                let changed = state == OPERATIONAL && (!before || self.nodes.is_waiting(node));
                if changed {
                    self.nodes.state(node, state, previous == Some(state), scene!(self, ledger, bus, id, at));
                    for ends in [Ends::Guarded, Ends::Operational] {
                        self.found.sign(Sign::of(ends, Some(node)), scene!(self, ledger, bus, id, at));
                    }
                }
                self.alive(node, frame, bus, ledger) || changed
            }
            Change::Error(emergency @ EmcyChange { node, code, manufacturer, .. }) => {
                self.heard.serves(node);
                self.heard.reports(node, emergency.active.iter().last(), at);
                let dirty = self.alive(node, frame, bus, ledger);
                if code == LIFE_GUARD {
                    let scene = scene!(self, ledger, bus, id, at);
                    let watched: Vec<_> = scene.watched(node).iter().map(|(node, time, _)| (*node, *time)).collect();
                    self.nodes.missed(node, &watched, manufacturer, scene);
                }
                self.emergencies.emergency(emergency, scene!(self, ledger, bus, id, at));
                dirty || code <= 0xFF
            }
            Change::Command { command, node } if node <= 127 => {
                self.heard.control = at;
                let before = self.heard.operational;
                let meant = self.heard.known & if node == 0 { u128::MAX } else { bit(node) };
                if command == 0x01 {
                    self.heard.operational |= meant;
                } else if matches!(command, 0x02 | 0x80..=0x82) {
                    self.heard.operational &= !meant;
                }
                self.heard.note(Last::Asked, node, at);
                self.idle.commanded(command, meant, at);
                self.masters.commanded(command, node, scene!(self, ledger, bus, id, at));
                self.nodes.commanded(command, node, before, scene!(self, ledger, bus, id, at));
                if node > 0 {
                    self.in_vain.commanded(command, node, before & bit(node) != 0, scene!(self, ledger, bus, id, at));
                }
                if command != 0x01 {
                    self.pdos.stopped(node);
                }
                if command == 0x01 {
                    self.boots.started(meant);
                    self.configurations.started(meant, scene!(self, ledger, bus, id, at));
                    for node in problem::members(meant & before) {
                        self.load.started_again(node, bus);
                    }
                }
                false
            }
            Change::SyncCycle { .. } => {
                let gap = at.since(Some(self.heard.sync).filter(|last| last.no > 0));
                self.heard.sync_period_ns =
                    gap.filter(|gap| (Ns(1)..LONGEST_SYNC_NS).contains(gap)).or(self.heard.sync_period_ns);
                (self.heard.sync, self.heard.control) = (at, at);
                self.pdos.sync(scene!(self, ledger, bus, id, at));
                if !self.found.is_empty() {
                    self.found.sign(Sign::of(Ends::Sync, None), scene!(self, ledger, bus, id, at));
                    let sign = Sign { length: frame.len.into(), ..Sign::of(Ends::SyncLength, None) };
                    self.found.sign(sign, scene!(self, ledger, bus, id, at));
                }
                false
            }
            _ => false,
        }
    }

    /// Passes a finding to the tracker of its rule.
    fn finding(&mut self, finding: &Finding, id: BusId, at: FrameRef, bus: &Bus, ledger: &mut Ledger) -> bool {
        ledger.count(finding);
        let scene = scene!(self, ledger, bus, id, at);
        match (finding.code, finding.node) {
            (Code::Hbt002, _) => {}
            (Code::Hbt001, Some(node)) if self.nodes.was_silent(node, finding, scene) => {}
            (Code::Nmt003, Some(node)) => self.nodes.restarted(node, finding, self.was, scene),
            (Code::Nmt004 | Code::Nmt005, Some(node)) => self.nodes.changed(node, finding, scene),
            (Code::Nmt002, Some(node)) => self.nodes.owes(node, finding, scene),
            (Code::Nmt006, Some(node)) => {
                self.nodes.owes(node, finding, scene);
                // Its state is older than the reset.
                self.heard.state(node, None);
            }
            (code, Some(node)) if code.rule().id.starts_with("EMC") => {
                if !self.emergencies.found(node, finding, scene) {
                    self.found.found(finding, scene!(self, ledger, bus, id, at));
                }
            }
            // A single node with an uneven task has alternating gaps, too, which is no second node without another
            // sign.
            (Code::Hbt004, Some(_)) if is_uneven(finding) => {}
            (Code::Sdo018, Some(node)) => self.configurations.stays(node, finding, scene),
            (Code::Drv005, Some(node)) => self.drives.fault(node, finding, scene),
            (Code::Drv002, Some(node)) => self.drives.stuck(node, finding, scene),
            (Code::Bus006, _) => {
                for ends in [Ends::Controller, Ends::Traffic] {
                    let sign = Sign::of(ends, None);
                    self.found.sign(sign, scene!(self, ledger, bus, id, at));
                }
            }
            (code, node) => {
                self.found.found(finding, scene);
                if code == Code::Cap006 {
                    self.masters.part();
                }
                if let (Code::Sdo002, Some(node)) = (code, node) {
                    self.identities.unasked(node, finding, scene!(self, ledger, bus, id, at));
                    // Where requests run at once, the server may have answered others since.
                    let since = |answer: &FrameRef| finding.cause.is_some_and(|cause| answer.no > cause.no);
                    if let Some(answer) = self.heard.noted(Last::Answer, node).filter(since) {
                        let sign = Sign::of(Ends::Answered, Some(node));
                        self.found.sign(sign, scene!(self, ledger, bus, id, answer));
                    }
                }
            }
        }
        false
    }

    /// Concludes at the end of the capture.
    pub(super) fn finish(&mut self, id: BusId, end: FrameRef, bus: &Bus, ledger: &mut Ledger) {
        let before = ledger.all.len();
        if let Some(alone) = self.boots.alone(&self.heard) {
            self.nodes.boots_alone(alone, scene!(self, ledger, bus, id, end));
        }
        self.boots.finish(scene!(self, ledger, bus, id, end));
        self.heartbeats.finish(scene!(self, ledger, bus, id, end));
        self.identities.finish(scene!(self, ledger, bus, id, end));
        self.in_vain.finish(scene!(self, ledger, bus, id, end));
        self.motions.finish(scene!(self, ledger, bus, id, end));
        self.nodes.never_started(scene!(self, ledger, bus, id, end));
        self.drives.finish(scene!(self, ledger, bus, id, end));
        self.load.finish(scene!(self, ledger, bus, id, end));
        self.idle.finish(scene!(self, ledger, bus, id, end));
        self.nodes.restarted_last(scene!(self, ledger, bus, id, end));
        let mine = ledger.all.iter().any(|one| one.bus == id);
        if self.heard.errors.0 >= ERRORS_ONLY && self.heard.errors.0 == self.frames {
            let first = self.heard.errors.1;
            let wrong = ledger.open(ProblemKind::WrongBitRate, id, problem::Subject::default(), first, first);
            let errors = ledger.last(id, |one| one.kind.is(KindRole::ErrorFrames));
            if let (Some(wrong), Some(errors)) = (wrong, errors) {
                ledger.merge(errors, wrong);
            }
        } else if !mine {
            return;
        }
        self.nodes.finish(scene!(self, ledger, bus, id, end));
        self.masters.finish(scene!(self, ledger, bus, id, end));
        self.found.finish(end, scene!(self, ledger, bus, id, end));
        // A finding that counts error frames refers to the first of them.
        let errors = ledger.last(id, |one| one.kind.is(KindRole::ErrorFrames) && one.end.is_some());
        if let Some(one) = errors.and_then(|place| ledger.get_mut(place)) {
            one.end = one.end.map(|end| if end.no < self.heard.last_error.no { self.heard.last_error } else { end });
        }
        for place in 0..ledger.all.len() {
            // A node may have been found lost after a request to it, and nodes that were lost together restart so.
            let asked = |one: &&problem::Problem| {
                (one.kind.is(KindRole::Unanswered) || one.kind.is(KindRole::Restart)) && one.cause.is_none()
            };
            let late = ledger.get(place).filter(asked).is_some_and(|one| one.bus == id && !one.merged);
            if place >= before || late {
                links::link(ledger, place, id);
            }
        }
        links::scanned(ledger, id);
        self.emergencies.finish(scene!(self, ledger, bus, id, end));
        for place in 0..ledger.all.len() {
            let back = self.nodes.back(place);
            let unstarted = ledger.get(place).is_some_and(|one| self.is_unstarted(one, ledger));
            let Some(one) = ledger.get_mut(place).filter(|one| one.bus == id) else { continue };
            let gone = one.subject.node.is_some_and(|node| self.nodes.is_silent(node));
            let others = self.heard.operational & !one.subject.nodes & self.heard.serving != 0;
            let long = end.since(one.begin).is_some_and(|since| since >= ALONE_NS);
            let idle = others && one.subject.node.is_some_and(|node| !self.heard.is_operational(node));
            let left_alone = others && long && (unstarted || !one.kind.is(KindRole::Reset));
            one.status = status(one, end, (back, gone, left_alone, idle));
            // The node was stopped in order to be written to.
            let written =
                |node: u8| self.heard.noted(Last::Written, node).is_some_and(|written| written.no > one.begin.no);
            let on_purpose = one.kind.is(KindRole::Stop) && problem::members(one.subject.nodes).all(written);
            if on_purpose && one.status == Status::Harmless {
                one.clue.least = u64::MAX;
            }
            if one.status == Status::Open {
                one.end = None;
                // It may have left Operational long after its boot-up.
                let since = back.map(|back| if one.begin.no > back.no { one.begin } else { back });
                self.stands(place, since, end, ledger);
            }
        }
    }
    /// Returns true if the nodes of a reset by command have booted and send heartbeats, but were not started again, and no
    /// other problem says more of them.
    fn is_unstarted(&self, one: &Problem, ledger: &Ledger) -> bool {
        let waits = |node: u8| {
            self.nodes.booted_since(node, one.begin) && !self.nodes.is_silent(node) && !self.heard.is_operational(node)
        };
        let told =
            |other: &Problem| other.id != one.id && other.subject.node.is_some_and(|node| one.subject.concerns(node));
        one.kind.is(KindRole::Reset)
            && problem::members(one.subject.nodes).all(waits)
            && !ledger.told().any(|other| told(other) && !other.kind.is_harmless() && other.end.is_none())
    }
}

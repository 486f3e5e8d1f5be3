//! A capture in figures: each bus, node, PDO, SYNC and rule, and the quality of the capture itself.
//!
//! It takes every frame with its events, markers and unreadable lines, and keeps figures only: memory does not grow
//! with the length of the capture. It does not judge, and uses only the findings of the checks.

pub mod bits;
pub mod identifiers;
pub mod load;
pub mod node;
pub mod traffic;

use std::collections::BTreeMap;
use std::sync::Arc;

use identifiers::Identifiers;
use load::{BitTime, Load};
use node::NodeSummary;
use traffic::{BusPdos, Sync};

use crate::bytes::frame::{BusId, Direction, Frame, FrameRef, Kind};
use crate::bytes::ns::Ns;
use crate::bytes::readers::Marker;
use crate::bytes::readers::listing::LeftOut;
use crate::bytes::span::Span;
use crate::rules::finding::{Code, Facts, Finding, Quantity, Severity};
use crate::sdo::wire::Side;
use crate::wire::cob_id::Role;
use crate::wire::message::Message;
use crate::world::change::Change;
use crate::world::event::{Event, What};
use crate::world::network::Network;

/// Services in the order of their identifiers, by the names of filters and JSON.
pub const SERVICES: [&str; 15] = [
    "nmt",
    "gfc",
    "flying_master",
    "sync",
    "time",
    "emcy",
    "srdo",
    "pdo",
    "sdo",
    "heartbeat",
    "guarding",
    "lss",
    "usdo",
    FOREIGN,
    "error",
];
/// The service of frames that are not CANopen.
const FOREIGN: &str = "foreign";
const PDO: usize = 7;
const SDO: usize = 8;

/// The capture as a whole.
#[derive(Clone, Debug, Default)]
pub struct Capture {
    /// Files.
    pub files: u64,
    /// Frames.
    pub frames: u64,
    /// Frames without a timestamp.
    pub unstamped: u64,
    /// The first frame.
    pub first: Option<FrameRef>,
    /// The last frame.
    pub last: FrameRef,
    /// The timestamps.
    pub span: Span,
    /// The longest time in ns without a frame, and the frame that ended it.
    pub pause: Option<(Ns, FrameRef)>,
    /// SDO requests captured after their response.
    pub reordered: u64,
    /// Lines that could not be read.
    pub unreadable: u64,
    /// Rows that a file itself shows to be left out.
    pub left_out: LeftOut,
    /// Damaged places of files, and ends in the middle of a record.
    pub damages: u64,
}

impl Capture {
    fn take(&mut self, frame: &Frame) {
        self.frames += 1;
        self.last = frame.reference();
        self.first.get_or_insert(self.last);
        let Some(now_ns) = frame.t_ns else {
            self.unstamped += 1;
            return;
        };
        let step_ns = self.span.take(now_ns).filter(|step_ns| *step_ns >= Ns::ZERO);
        if let Some(step_ns) = step_ns
            && self.pause.is_none_or(|(longest, _)| step_ns > longest)
        {
            self.pause = Some((step_ns, self.last));
        }
    }
}

/// One bus.
#[derive(Debug)]
pub struct BusSummary {
    /// Frames.
    pub frames: u64,
    /// Frames sent by the capturing host, if the capture has directions.
    pub sent_by_host: Option<u64>,
    /// Remote frames.
    pub remote: u64,
    /// CAN FD frames.
    pub fd: u64,
    /// CAN FD frames with bit rate switch, which are only partly counted in the load.
    pub fd_switched: u64,
    /// Frames with 29-bit identifiers.
    pub extended: u64,
    /// Error frames, and error markers without content.
    pub errors: u64,
    /// The number of reports of the capturing program that frames were lost.
    pub gaps: u64,
    /// The number of lost frames that it reports.
    pub dropped: u64,
    /// By [`SERVICES`].
    pub services: [u64; SERVICES.len()],
    /// Its load.
    pub load: Load,
    /// SYNC.
    pub sync: Sync,
    /// PDOs.
    pub pdos: BusPdos,
    /// CAN-IDs.
    pub identifiers: Identifiers,
    nodes: Vec<Option<Box<NodeSummary>>>,
    /// The last NMT command to all nodes, which also applies to nodes that are seen later.
    to_all: Option<(u8, FrameRef)>,
}

impl Default for BusSummary {
    fn default() -> Self {
        Self {
            frames: 0,
            sent_by_host: None,
            remote: 0,
            fd: 0,
            fd_switched: 0,
            extended: 0,
            errors: 0,
            gaps: 0,
            dropped: 0,
            services: [0; SERVICES.len()],
            load: Load::default(),
            sync: Sync::default(),
            pdos: BusPdos::default(),
            identifiers: Identifiers::default(),
            nodes: (0..128).map(|_| None).collect(),
            to_all: None,
        }
    }
}

impl BusSummary {
    /// Nodes that were seen, or only addressed, by node-ID.
    pub fn nodes(&self) -> impl Iterator<Item = (u8, &NodeSummary)> {
        self.nodes.iter().enumerate().filter_map(|(id, node)| Some((id as u8, node.as_deref()?)))
    }

    /// Returns its services, if all frames except error frames are not CANopen.
    pub fn foreign_only(&self) -> [u64; SERVICES.len()] {
        let mut services = [0; SERVICES.len()];
        for ((name, count), slot) in SERVICES.iter().zip(self.services).zip(&mut services) {
            *slot = if *name == "error" { count } else { 0 };
        }
        let errors: u64 = services.iter().sum();
        if let Some(slot) = SERVICES.iter().position(|name| *name == FOREIGN).and_then(|place| services.get_mut(place))
        {
            *slot = self.services.iter().sum::<u64>().saturating_sub(errors);
        }
        services
    }

    fn node(&mut self, id: u8) -> Option<&mut NodeSummary> {
        let to_all = self.to_all;
        let slot = self.nodes.get_mut(usize::from(id))?;
        Some(slot.get_or_insert_with(|| {
            let mut node = Box::<NodeSummary>::default();
            if let Some((command, at)) = to_all {
                node.command(command, at);
            }
            node
        }))
    }

    fn take(&mut self, frame: &Frame, at_ns: Option<Ns>, bit_time: Option<BitTime>) {
        self.frames += 1;
        match frame.kind {
            Kind::Data => {}
            Kind::Remote => self.remote += 1,
            Kind::Error => self.errors += 1,
            Kind::Fd { brs, .. } => {
                self.fd += 1;
                self.fd_switched += u64::from(brs);
            }
        }
        self.extended += u64::from(frame.id.is_extended() && frame.kind != Kind::Error);
        if let Some(direction) = frame.dir {
            *self.sent_by_host.get_or_insert(0) += u64::from(direction == Direction::Tx);
        }
        if !matches!(frame.kind, Kind::Error | Kind::Remote) {
            self.identifiers.take(frame);
        }
        self.load.add(bits::on_the_wire(frame), at_ns, bit_time, frame.reference());
    }

    /// Counts lost frames, and stops the measurement of times at the gap.
    fn lost(&mut self, count: u64) {
        self.gaps += 1;
        self.dropped = self.dropped.saturating_add(count);
        self.interrupted();
    }

    /// Stops the measurement of times, since frames are missing here.
    fn interrupted(&mut self) {
        self.sync.lost();
        self.pdos.lost();
        self.identifiers.lost();
        for node in self.nodes.iter_mut().flatten() {
            node.lost();
        }
    }

    fn serves(&mut self, service: usize) {
        if let Some(count) = self.services.get_mut(service) {
            *count += 1;
        }
    }

    fn message(&mut self, message: &Message, frame: &Frame) {
        let service = message.service();
        if let Some(place) = SERVICES.iter().position(|name| *name == service) {
            self.serves(place);
        }
        if service == FOREIGN && frame.kind != Kind::Remote {
            self.identifiers.foreign(Some(frame.id));
        }
        if let Message::Pdo { transmit, number, node } | Message::Mpdo { transmit, number, node, .. } = *message {
            self.pdos.take((node, transmit, number), None, frame);
        }
        let Some(node) = message.node().and_then(|id| self.node(id)) else { return };
        node.frames += 1;
        node.sent += u64::from(is_from_node(message));
        match *message {
            Message::Pdo { transmit, .. } | Message::Mpdo { transmit, .. } => {
                node.tpdos += u64::from(transmit);
                node.rpdos += u64::from(!transmit);
            }
            Message::GuardingRequest { .. } => node.guarded = true,
            _ => {}
        }
    }

    fn change(&mut self, change: &Change, at: FrameRef) {
        match *change {
            Change::SyncCycle { counter, .. } => self.sync.take(counter, at.t_ns),
            Change::Command { command, node: 0 } => {
                self.to_all = Some((command, at));
                self.nodes.iter_mut().flatten().for_each(|node| node.command(command, at));
            }
            Change::Lost { node: None, .. } => {
                self.nodes.iter_mut().flatten().for_each(|node| node.lost |= node.heartbeats > 0);
            }
            _ => {
                if let Some(node) = change.node().and_then(|id| self.node(id)) {
                    node.change(change, at);
                }
            }
        }
    }

    fn event(&mut self, event: &Event, frame: Option<&Frame>) {
        match (&event.what, frame) {
            (What::Message(message), Some(frame)) => {
                self.message(message, frame);
                if let Message::Usdo { request, .. } = *message
                    && let Some(node) = event.node.and_then(|id| self.node(id))
                {
                    node.exchange(event.transfer, (request, !request), frame.reference());
                }
            }
            (What::Mpdo(data), Some(frame)) => self.message(&data.message(), frame),
            (What::Pdo(data), Some(frame)) => {
                self.serves(PDO);
                self.pdos.take((data.node, data.transmit, data.number), data.sync, frame);
                if let Some(node) = self.node(data.node) {
                    node.frames += 1;
                    node.sent += u64::from(data.transmit);
                    node.tpdos += u64::from(data.transmit);
                    node.rpdos += u64::from(!data.transmit);
                }
            }
            (What::Sdo(step), Some(frame)) => {
                self.serves(SDO);
                if let Some(node) = event.node.and_then(|id| self.node(id)) {
                    node.frames += 1;
                    node.sent += u64::from(step.side == Side::Server);
                    node.sdo(step, event.transfer, frame.reference());
                }
            }
            (What::Transfer(transfer), _) => {
                if let Some(node) = self.node(transfer.node) {
                    node.transfer(transfer, event.at);
                }
            }
            (What::Change(change), _) => self.change(change, event.at),
            _ => {}
        }
    }
}

/// Returns true if the node that a message is about has sent it.
fn is_from_node(message: &Message) -> bool {
    match *message {
        Message::Srdo { .. } | Message::Usdo { .. } => true,
        Message::GuardingRequest { .. } | Message::PdoRequest { .. } => false,
        Message::Pdo { transmit, .. } | Message::Mpdo { transmit, .. } => transmit,
        Message::Malformed { role, flaw } => {
            flaw != crate::wire::message::Flaw::Remote
                && matches!(role, Role::Tpdo { .. } | Role::SdoResponse(_) | Role::Emcy(_) | Role::ErrorControl(_))
        }
        _ => matches!(message.role(), Role::Emcy(_) | Role::ErrorControl(_)),
    }
}

/// The findings of a rule.
#[derive(Clone, Copy, Debug)]
pub struct Raised {
    /// The number of findings.
    pub count: u64,
    /// The first one.
    pub first: FrameRef,
    /// The last one.
    pub last: FrameRef,
    /// Node-IDs concerned, as bits.
    pub nodes: u128,
    /// Buses concerned, as bits.
    pub buses: u64,
}

fn raise(findings: &mut BTreeMap<(Code, Severity), Raised>, finding: &Finding) {
    let more = if let Facts::Repeated { count } = finding.facts { count } else { 1 };
    let nothing = Raised { count: 0, first: finding.at, last: finding.at, nodes: 0, buses: 0 };
    let raised = findings.entry((finding.code, finding.severity())).or_insert(nothing);
    raised.count += more;
    raised.last = finding.at;
    raised.nodes |= finding.node.map_or(0, |node| 1 << (node & 0x7F));
    if finding.at.no > 0 || finding.code == Code::Cap002 {
        raised.buses |= 1 << (finding.bus.0 & 0x3F);
    }
}

/// The figures of a capture.
#[derive(Debug)]
pub struct Summary {
    /// Data that were known beforehand: names, bit rate.
    pub network: Arc<Network>,
    /// The capture as a whole.
    pub capture: Capture,
    /// Buses with anything to count.
    pub buses: BTreeMap<BusId, Box<BusSummary>>,
    /// Findings by rule; those that are only consequences have severity info and are counted apart.
    pub findings: BTreeMap<(Code, Severity), Raised>,
    bit_time: Option<BitTime>,
}

impl Summary {
    /// Creates an empty summary.
    pub fn new(network: Arc<Network>) -> Self {
        let bit_time = network.bit_rate.map(BitTime::at);
        Self { network, capture: Capture::default(), buses: BTreeMap::new(), findings: BTreeMap::new(), bit_time }
    }

    /// Takes the end of a file with frames, and the number of its unreadable lines.
    pub fn file(&mut self, unreadable: u64) {
        self.capture.files += 1;
        self.capture.unreadable += unreadable;
    }

    /// Takes a frame and its events.
    pub fn frame(&mut self, frame: &Frame, events: &[Event]) {
        self.capture.take(frame);
        let at_ns = frame.t_ns.and(self.capture.span.elapsed_ns);
        let bus = self.buses.entry(frame.bus).or_default();
        bus.take(frame, at_ns, self.bit_time);
        for event in events {
            match &event.what {
                What::Finding(finding) => raise(&mut self.findings, finding),
                _ => bus.event(event, Some(frame)),
            }
            if let What::Sdo(step) = &event.what {
                self.capture.reordered += u64::from(step.answered_by.is_some());
            }
        }
    }

    /// Takes events without a current frame: transfers cut by the end of the capture, findings.
    pub fn asides(&mut self, events: &[Event]) {
        for event in events {
            match &event.what {
                What::Finding(finding) => self.finding(finding),
                _ => self.bus(event.bus).event(event, None),
            }
        }
    }

    /// Takes a line about the capture itself.
    pub fn marker(&mut self, marker: &Marker) {
        match *marker {
            Marker::Dropped { bus, count, .. } => self.bus(bus).lost(count),
            Marker::LeftOut { count, .. } => {
                self.capture.left_out.add(count);
                self.buses.values_mut().for_each(|bus| bus.interrupted());
            }
            Marker::Error { bus, .. } => self.bus(bus).errors += 1,
            Marker::Backward { .. } | Marker::Start { .. } | Marker::Swapped => {}
        }
    }

    /// Stops the measurement of times, since a bus was away.
    pub fn gap(&mut self, bus: BusId) {
        self.bus(bus).lost(0);
    }

    /// Counts a finding.
    pub fn finding(&mut self, finding: &Finding) {
        if finding.code == Code::Bus009 {
            let id = finding.measured().and_then(|measured| measured.get("id"));
            let id = if let Some(Quantity::Id(id)) = id { Some(id) } else { None };
            self.bus(finding.bus).identifiers.foreign(id);
        }
        self.capture.damages += u64::from(matches!(finding.code, Code::Cap004 | Code::Cap005));
        raise(&mut self.findings, finding);
    }

    /// Returns the product's name in the description of a node; a description for this bus takes precedence.
    pub fn described(&self, bus: &[u8], node: u8) -> Option<&str> {
        let of_node = self.network.descriptions.iter().filter(|one| one.node == node);
        let holding = of_node.filter(|one| Network::holds(one.bus.as_ref(), bus) && !one.dictionary.device.is_empty());
        holding.max_by_key(|one| one.bus.is_some()).map(|one| one.dictionary.device.as_str())
    }

    fn bus(&mut self, id: BusId) -> &mut BusSummary {
        self.buses.entry(id).or_default()
    }
}

#[cfg(test)]
mod tests;

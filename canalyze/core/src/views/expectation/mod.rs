//! The comparison of a capture with what is expected of it.
//!
//! An expectation is a line of a file that people write (`canalyze check --expect`); [`Expectations`] is the file as
//! `settings` has read and normalized it, [`Verification`] applies it to one capture. Each kind of expectation has a
//! file here and owns its state. A deviation is a finding at the frame at which it occurred, or at the last frame if
//! something is missing; an expectation that the capture cannot decide is reported as info.
//!
//! It sees frames and their events, as any other consumer of events. It does not change events, and does not depend on
//! the syntax of the file.

use crate::bytes::ns::Ns;

mod emcy;
mod heartbeat;
mod latency;
mod load;
pub mod observed;
mod problem;
mod sdo;
mod shown;
mod signal;
mod state;
mod sync;
mod value;

#[cfg(test)]
mod tests;

use std::sync::Arc;

use serde::Deserialize;

use crate::bytes::frame::{BusId, Buses, Frame, FrameRef, MAX_BUSES};
use crate::problems::Diagnosis;
use crate::rules::expectation::Exp015;
use crate::rules::finding::{Deviation, Facts, Finding, Unmet};
use crate::sdo::transfer::{Direction, Status, Transfer};
use crate::sdo::wire::Mux;
use crate::wire::message::Message;
use crate::wire::usdo::Pdu;
use crate::world::change::{Change, EmcyChange};
use crate::world::event::{Event, What};

/// The expectations of a capture.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Expectations {
    file: String,
    sdo: Vec<sdo::SdoEntry>,
    state: Vec<state::StateEntry>,
    signal: Vec<signal::SignalEntry>,
    heartbeat: Vec<heartbeat::HeartbeatEntry>,
    sync: Vec<sync::SyncEntry>,
    emcy: Vec<emcy::EmcyEntry>,
    problem: Vec<problem::ProblemEntry>,
    latency: Vec<latency::LatencyEntry>,
    load: Vec<load::LoadEntry>,
}

impl Expectations {
    /// Reads the normalized form, a JSON object: `file` and a list for each kind. Errors are in terms of the JSON,
    /// since users do not write it.
    pub fn read(json: &str) -> Result<Self, String> {
        serde_json::from_str(json).map_err(|mistake| mistake.to_string()).and_then(Self::normalized)
    }

    /// Converts the normalized form.
    pub fn normalized(form: serde_json::Value) -> Result<Self, String> {
        let read = Self::deserialize(form).map_err(|mistake| mistake.to_string())?;
        read.sdo.iter().try_for_each(sdo::SdoEntry::check)?;
        read.state.iter().try_for_each(state::StateEntry::check)?;
        read.signal.iter().try_for_each(signal::SignalEntry::check)?;
        read.heartbeat.iter().try_for_each(heartbeat::HeartbeatEntry::check)?;
        read.sync.iter().try_for_each(sync::SyncEntry::check)?;
        read.emcy.iter().try_for_each(emcy::EmcyEntry::check)?;
        read.problem.iter().try_for_each(problem::ProblemEntry::check)?;
        read.latency.iter().try_for_each(latency::LatencyEntry::check)?;
        read.load.iter().try_for_each(load::LoadEntry::check)?;
        Ok(read)
    }

    /// Returns true if an expectation needs the diagnosis.
    pub fn diagnoses(&self) -> bool {
        !self.problem.is_empty()
    }
}

/// The subject of an expectation, and its line in the file.
#[derive(Clone, Debug)]
struct EntryPlace {
    /// `boot.expect.toml:12`.
    label: Arc<str>,
    /// The bus's name; `None`: every bus.
    bus: Option<String>,
    /// The node, if it is about one.
    node: Option<u8>,
    /// The object, if it is about one.
    object: Option<Mux>,
}

impl EntryPlace {
    fn new(file: &str, line: u32, bus: Option<&String>, node: Option<u8>) -> Self {
        Self { label: format!("{file}:{line}").into(), bus: bus.cloned(), node, object: None }
    }

    /// Returns true if it is about a node of a bus.
    fn holds(&self, name: &[u8], node: Option<u8>) -> bool {
        self.is_on(name) && (self.node.is_none() || self.node == node)
    }

    /// Returns true if it is about a bus.
    fn is_on(&self, name: &[u8]) -> bool {
        self.bus.as_ref().is_none_or(|bus| bus.as_bytes() == name)
    }
}

/// A finding about an expectation.
#[derive(Clone, Debug)]
struct Breach {
    what: Deviation,
    at: FrameRef,
    cause: Option<FrameRef>,
    bus: BusId,
    /// The node found, if the expectation names none.
    node: Option<u8>,
    /// The object found, if the expectation names none.
    object: Option<Mux>,
}

impl Breach {
    fn new(what: impl Into<Deviation>, at: FrameRef, bus: BusId) -> Self {
        Self { what: what.into(), at, cause: None, bus, node: None, object: None }
    }

    fn about(self, cause: FrameRef) -> Self {
        let cause = (cause.no != self.at.no).then_some(cause);
        Self { cause, ..self }
    }

    fn of(self, node: u8) -> Self {
        Self { node: Some(node), ..self }
    }

    fn object(self, object: Mux) -> Self {
        Self { object: Some(object), ..self }
    }
}

/// The current frame, and the list of findings.
#[derive(Debug)]
struct Scene<'a> {
    at: FrameRef,
    bus: BusId,
    /// Its name.
    name: &'a [u8],
    /// The first timestamp of the capture.
    start_ns: Option<Ns>,
    found: &'a mut Vec<Event>,
}

impl Scene<'_> {
    /// Returns a finding at the current frame.
    fn breach(&self, what: impl Into<Deviation>) -> Breach {
        Breach::new(what, self.at, self.bus)
    }

    /// Returns the time since the beginning of the capture.
    fn elapsed_ns(&self) -> Option<Ns> {
        Some(self.at.t_ns? - self.start_ns?)
    }

    fn raise(&mut self, place: &EntryPlace, breach: Breach) {
        raise(self.found, place, breach);
    }
}

fn raise(found: &mut Vec<Event>, place: &EntryPlace, breach: Breach) {
    let Breach { what: Deviation { code, variant, said }, at, cause, bus, node, object } = breach;
    let (node, object) = (node.or(place.node), object.or(place.object));
    let unmet = Unmet { expectation: Arc::clone(&place.label), variant, said, repeated: 0 };
    let facts = Facts::Unmet(Arc::new(unmet));
    let finding = Finding { code, at, cause, bus, node, object, facts, because_of: None };
    found.push(Event {
        at,
        about: cause.map(Box::new),
        bus,
        node,
        transfer: None,
        what: What::Finding(Box::new(finding)),
    });
}

/// The end of the capture.
#[derive(Debug)]
struct Closing<'a> {
    last: FrameRef,
    /// The last timestamp of the capture.
    end_ns: Option<Ns>,
    buses: &'a Buses,
    /// Nodes that were seen, as bits, by bus.
    heard: &'a [u128],
    found: &'a mut Vec<Event>,
}

impl Closing<'_> {
    /// Returns a finding at the last frame, on the bus of an expectation if it names exactly one.
    fn breach(&self, place: &EntryPlace, what: impl Into<Deviation>) -> Breach {
        Breach::new(what, self.last, self.bus(place))
    }

    fn bus(&self, place: &EntryPlace) -> BusId {
        let id = |index: usize| BusId(index as u8);
        if let Some(name) = &place.bus {
            return self.buses.names().position(|known| known == name.as_bytes()).map_or(BusId::NONE, id);
        }
        if self.buses.names().count() <= 1 {
            return BusId(0);
        }
        let bit = 1 << (place.node.unwrap_or(0) & 0x7F);
        let mut hearing = self.heard.iter().enumerate().filter(|(_, nodes)| *nodes & bit != 0);
        match (hearing.next(), hearing.next()) {
            (Some((index, _)), None) => id(index),
            _ => BusId::NONE,
        }
    }

    /// Reports an expectation that cannot be checked.
    fn unchecked(&mut self, place: &EntryPlace, why: Exp015) {
        let breach = self.breach(place, why);
        self.raise(place, breach);
    }

    fn raise(&mut self, place: &EntryPlace, breach: Breach) {
        raise(self.found, place, breach);
    }
}

/// A capture and its expectations.
#[derive(Debug)]
pub struct Verification {
    transfers: sdo::Transfers,
    states: state::States,
    signals: signal::SignalExpectations,
    heartbeats: heartbeat::Heartbeats,
    syncs: sync::Syncs,
    emergencies: emcy::EmcyExpectations,
    problems: problem::ProblemExpectations,
    latencies: latency::Latencies,
    loads: load::Loads,
    shown: shown::ShownTransfers,
    /// The first and the last timestamp of the capture.
    start_ns: Option<Ns>,
    end_ns: Option<Ns>,
    /// Nodes that were seen, as bits, by bus.
    heard: Vec<u128>,
    /// Findings of the current events.
    found: Vec<Event>,
}

impl Verification {
    /// Creates the verification of a capture at its beginning. `bit_rate` is in bit/s, if it is known.
    pub fn new(expected: &Expectations, bit_rate: Option<u32>) -> Self {
        let file = &expected.file;
        Self {
            transfers: sdo::Transfers::new(file, &expected.sdo),
            states: state::States::new(file, &expected.state),
            signals: signal::SignalExpectations::new(file, &expected.signal),
            heartbeats: heartbeat::Heartbeats::new(file, &expected.heartbeat),
            syncs: sync::Syncs::new(file, &expected.sync),
            emergencies: emcy::EmcyExpectations::new(file, &expected.emcy),
            problems: problem::ProblemExpectations::new(file, &expected.problem),
            latencies: latency::Latencies::new(file, &expected.latency),
            loads: load::Loads::new(file, &expected.load, bit_rate),
            shown: shown::ShownTransfers::default(),
            start_ns: None,
            end_ns: None,
            heard: Vec::new(),
            found: Vec::new(),
        }
    }

    /// Takes a frame with its events, and appends findings.
    pub fn frame(&mut self, frame: &Frame, events: &mut Vec<Event>, buses: &Buses) {
        if let Some(now_ns) = frame.t_ns {
            self.start_ns.get_or_insert(now_ns);
            self.end_ns = Some(now_ns);
        }
        let mut found = std::mem::take(&mut self.found);
        let name = buses.name(frame.bus);
        let scene = Scene { at: frame.reference(), bus: frame.bus, name, start_ns: self.start_ns, found: &mut found };
        self.loads.frame(frame, scene);
        self.take(Some(frame), events, buses, &mut found);
        events.append(&mut found);
        self.found = found;
    }

    /// Takes events without a current frame, and appends findings.
    pub fn asides(&mut self, events: &mut Vec<Event>, from: usize, buses: &Buses) {
        let mut found = std::mem::take(&mut self.found);
        self.take(None, events.get(from..).unwrap_or(&[]), buses, &mut found);
        events.append(&mut found);
        self.found = found;
    }

    fn take(&mut self, frame: Option<&Frame>, events: &[Event], buses: &Buses, found: &mut Vec<Event>) {
        for event in events {
            let name = buses.name(event.bus);
            let mut scene = Scene { at: event.at, bus: event.bus, name, start_ns: self.start_ns, found };
            self.event(event, frame, &mut scene);
        }
    }

    fn event(&mut self, event: &Event, frame: Option<&Frame>, scene: &mut Scene<'_>) {
        if let Some(node) = event.node {
            self.hear(event.bus, node);
        }
        if let Some(transfer) = self.shown.next(&event.what) {
            self.transfers.ended(&transfer, scene);
            self.reconfigured(&transfer);
        }
        match (&event.what, frame) {
            (What::Transfer(transfer), _) => self.latencies.ended(transfer, scene),
            (What::Sdo(step), Some(_)) => self.latencies.step(step, event, scene),
            (What::Message(Message::Usdo { request, .. }), Some(frame)) => {
                let mux = Pdu::read(frame.payload()).and_then(|pdu| pdu.mux());
                self.latencies.exchange((*request, !request), mux, event, scene);
            }
            (What::Pdo(data), Some(frame)) => {
                self.signals.process_data(data, frame, scene);
                self.latencies.process_data(data, scene);
            }
            (What::Mpdo(data), Some(frame)) => self.signals.multiplexed(data, frame, scene),
            (What::Change(change @ Change::Drive { .. }), _) => self.states.change(change, scene),
            (What::Change(change), Some(_)) => self.change(change, scene),
            _ => {}
        }
    }

    fn change(&mut self, change: &Change, scene: &mut Scene<'_>) {
        match *change {
            Change::SyncCycle { .. } => self.syncs.sync(scene),
            Change::Error(EmcyChange { node, code, profile, .. }) => {
                self.emergencies.emcy(node, (code, profile), scene);
            }
            _ => {
                self.heartbeats.change(change, scene);
                self.signals.change(change, scene);
                self.states.change(change, scene);
                self.latencies.change(change, scene);
            }
        }
    }

    /// Applies a written value that changes a period at once.
    fn reconfigured(&mut self, transfer: &Transfer) {
        let Some(written) = written(transfer) else { return };
        match written {
            WrittenPeriod::Heartbeat => self.heartbeats.reconfigured(transfer.bus, transfer.node),
            WrittenPeriod::Pdo => self.signals.reconfigured(transfer.bus, transfer.node),
            WrittenPeriod::Sync => self.syncs.lost(transfer.bus),
        }
    }

    fn hear(&mut self, bus: BusId, node: u8) {
        let index = usize::from(bus.0).min(MAX_BUSES);
        if self.heard.len() <= index {
            self.heard.resize(index + 1, 0);
        }
        if let Some(nodes) = self.heard.get_mut(index) {
            *nodes |= 1 << (node & 0x7F);
        }
    }

    /// Restarts all measurements of a bus, since its frames are missing here.
    pub fn lost(&mut self, bus: BusId, buses: &Buses) {
        self.transfers.lost(buses.name(bus));
        self.states.lost(bus, buses.name(bus));
        self.heartbeats.lost(bus);
        self.signals.lost(bus);
        self.syncs.lost(bus);
        self.latencies.lost(bus);
    }

    /// Reports what is overdue at `now_ns` on the clock of the frames; `last` is the last frame.
    pub fn advance(&mut self, now_ns: Ns, last: FrameRef, events: &mut Vec<Event>, buses: &Buses) {
        if last.no > 0 {
            let mut closing = Closing { last, end_ns: Some(now_ns), buses, heard: &self.heard, found: events };
            self.transfers.overdue(self.start_ns, &mut closing);
            self.states.overdue(self.start_ns, &mut closing);
        }
        self.heartbeats.overdue(now_ns, last, events);
        self.signals.overdue(now_ns, last, events);
        self.syncs.overdue(now_ns, last, events);
    }

    /// Reports at the end of the capture, after its own events; `last` is its last frame.
    pub fn finish(&mut self, last: FrameRef, events: &mut Vec<Event>, buses: &Buses) {
        let Self { heard, end_ns, .. } = self;
        let mut closing = Closing { last, end_ns: *end_ns, buses, heard, found: events };
        self.transfers.finish(&mut closing);
        self.states.finish(&mut closing);
        self.signals.finish(&mut closing);
        self.heartbeats.finish(&mut closing);
        self.syncs.finish(&mut closing);
        self.emergencies.finish(&mut closing);
        self.latencies.finish(&mut closing);
        self.loads.finish(&mut closing);
    }

    /// Reports on problems at the end of the capture; `last` is its last frame.
    pub fn diagnosed(&self, diagnosis: &Diagnosis, last: FrameRef, events: &mut Vec<Event>, buses: &Buses) {
        let mut closing = Closing { last, end_ns: self.end_ns, buses, heard: &self.heard, found: events };
        self.problems.finish(diagnosis, &mut closing);
    }
}

/// The period that an acknowledged write has changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum WrittenPeriod {
    Heartbeat,
    Pdo,
    Sync,
}

fn written(transfer: &Transfer) -> Option<WrittenPeriod> {
    let index = transfer.mux?.index;
    let done = transfer.direction == Direction::Download && transfer.outcome.status == Status::Ok;
    match index {
        0x1017 if done => Some(WrittenPeriod::Heartbeat),
        0x1005 | 0x1006 if done => Some(WrittenPeriod::Sync),
        0x1400..=0x1BFF if done => Some(WrittenPeriod::Pdo),
        _ => None,
    }
}

/// The name of an NMT state in expectations.
pub fn state_name(state: u8) -> Option<&'static str> {
    state::NMT.iter().find(|row| row.1 == state).map(|row| row.0)
}

/// The names of all NMT states in expectations.
pub fn state_names() -> impl Iterator<Item = &'static str> {
    state::NMT.iter().map(|row| row.0)
}

/// Returns an error in the normalized form, with the line of the file.
fn mistake(line: u32, what: &str) -> Result<(), String> {
    Err(format!("line {line}: {what}"))
}

/// Checks a node-ID.
fn check_node(line: u32, node: Option<u8>) -> Result<(), String> {
    if node.is_none_or(|node| (1..=127).contains(&node)) { Ok(()) } else { mistake(line, "node") }
}

/// Checks that no time is negative, and that the times `positive` are above 0.
fn check_times(line: u32, positive: &[Option<Ns>], others: &[Option<Ns>]) -> Result<(), String> {
    let below = |limit: Ns| move |ns: &Option<Ns>| ns.is_some_and(|ns| ns < limit);
    if positive.iter().any(below(Ns(1))) || others.iter().any(below(Ns::ZERO)) { mistake(line, "time") } else { Ok(()) }
}

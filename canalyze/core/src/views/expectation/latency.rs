//! Latencies: of an SDO response after its request, a synchronous TPDO after its SYNC, a node after an NMT command.
//!
//! Only pairs that were captured in their order are measured. The reason of a delay does not matter here.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::{Breach, Closing, EntryPlace, Scene, check_node, check_times, mistake};
use crate::bytes::frame::{BusId, FrameRef};
use crate::bytes::ns::Ns;
use crate::rules::expectation::{Exp013, Exp015};
use crate::sdo::transfer::{Transfer, TransferId};
use crate::sdo::wire::{Command, Mux, Side};
use crate::wire::error_control::BOOT_UP;
use crate::wire::nmt::commanded_state;
use crate::world::change::Change;
use crate::world::event::{Event, Place as Stands, ProcessData, Step};

/// Maximum number of SDO requests that wait for their response at a time.
const PENDING: usize = 1024;

/// A measured latency.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Measure {
    Sdo,
    Sync,
    Nmt,
}

/// An expectation in the form of the file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LatencyEntry {
    line: u32,
    bus: Option<String>,
    node: Option<u8>,
    of: Measure,
    index: Option<u16>,
    sub: Option<u8>,
    pdo: Option<u16>,
    max_ns: Ns,
}

impl LatencyEntry {
    pub(super) fn check(&self) -> Result<(), String> {
        check_node(self.line, self.node)?;
        check_times(self.line, &[], &[Some(self.max_ns)])?;
        if self.sub.is_some() && self.index.is_none() {
            return mistake(self.line, "sub without index");
        }
        if self.index.is_some() && self.of != Measure::Sdo || self.pdo.is_some() && self.of != Measure::Sync {
            return mistake(self.line, "index or pdo");
        }
        Ok(())
    }

    fn is_about(&self, mux: Option<Mux>) -> bool {
        let index = self.index.is_none_or(|index| mux.is_some_and(|mux| mux.index == index));
        index && self.sub.is_none_or(|sub| mux.is_some_and(|mux| mux.sub == sub))
    }
}

/// An expectation and whether there was anything to measure.
#[derive(Debug)]
struct WatchedLatency {
    entry: LatencyEntry,
    place: EntryPlace,
    measured: bool,
}

/// A command that a node has not followed yet.
#[derive(Clone, Copy, Debug)]
struct Ordered {
    command: u8,
    state: u8,
    at: FrameRef,
    /// It was reported as late.
    told: bool,
}

/// A node of one bus.
#[derive(Clone, Copy, Debug, Default)]
struct KnownNode {
    shown: Option<u8>,
    ordered: Option<Ordered>,
}

/// All expectations of latencies.
#[derive(Debug)]
pub(super) struct Latencies {
    all: Vec<WatchedLatency>,
    sdo: bool,
    nmt: bool,
    /// Requests without a response so far.
    pending: Vec<(TransferId, BusId, FrameRef)>,
    /// Nodes that were seen, by bus and node-ID.
    nodes: BTreeMap<(BusId, u8), KnownNode>,
}

impl Latencies {
    pub(super) fn new(file: &str, entries: &[LatencyEntry]) -> Self {
        let all = entries.iter().map(|entry| WatchedLatency {
            place: EntryPlace::new(file, entry.line, entry.bus.as_ref(), entry.node),
            entry: entry.clone(),
            measured: false,
        });
        let has = |of| entries.iter().any(|entry| entry.of == of);
        Self {
            all: all.collect(),
            sdo: has(Measure::Sdo),
            nmt: has(Measure::Nmt),
            pending: Vec::new(),
            nodes: BTreeMap::new(),
        }
    }

    /// Takes a frame of an SDO channel.
    pub(super) fn step(&mut self, step: &Step, event: &Event, scene: &mut Scene<'_>) {
        let (client, due) = (step.side == Side::Client, step.place == Stands::Due);
        let ends = matches!(step.command, Command::Abort(..) | Command::BlockEnded);
        let asks = client && step.answered_by.is_none() && due && !ends;
        self.exchange((asks, !client && due), step.mux.or(step.command.mux()), event, scene);
    }

    /// Takes a frame of a transfer that asks for a response or is one.
    pub(super) fn exchange(
        &mut self,
        (asks, responds): (bool, bool),
        mux: Option<Mux>,
        event: &Event,
        scene: &mut Scene<'_>,
    ) {
        let (Some(id), Some(node), true) = (event.transfer, event.node, self.sdo) else { return };
        let place = self.pending.iter().position(|(pending, ..)| *pending == id);
        let requested = place.map(|place| self.pending.swap_remove(place).2);
        if asks && self.pending.len() < PENDING {
            self.pending.push((id, scene.bus, scene.at));
        }
        let Some(requested) = requested.filter(|_| responds) else { return };
        let Some((now, then)) = scene.at.t_ns.zip(requested.t_ns) else { return };
        let about = |entry: &LatencyEntry| entry.of == Measure::Sdo && entry.is_about(mux);
        let found = now - then;
        self.measure(about, Some(node), found, scene, |expected, scene| {
            let breach = scene.breach(Exp013::Response { expected, found }).about(requested);
            if let Some(mux) = mux { breach.object(mux) } else { breach }
        });
    }

    /// Forgets a transfer that has ended.
    pub(super) fn ended(&mut self, transfer: &Transfer, _: &Scene<'_>) {
        self.pending.retain(|(id, ..)| *id != transfer.id);
    }

    /// Takes a PDO.
    pub(super) fn process_data(&mut self, data: &ProcessData, scene: &mut Scene<'_>) {
        let Some(delay) = data.sync.and_then(|placed| placed.delay_ns).filter(|_| data.transmit) else { return };
        let number = data.number;
        let about = |entry: &LatencyEntry| entry.of == Measure::Sync && entry.pdo.is_none_or(|wanted| wanted == number);
        self.measure(about, Some(data.node), delay, scene, |expected, scene| {
            scene.breach(Exp013::Sync { expected, found: delay, pdo: (true, number) })
        });
    }

    /// Takes a boot-up, a report of a state or an NMT command.
    pub(super) fn change(&mut self, change: &Change, scene: &mut Scene<'_>) {
        if !self.nmt {
            return;
        }
        match *change {
            Change::Command { command, node } => self.command(command, node, scene),
            Change::BootUp { node } => self.shows(node, BOOT_UP, scene),
            Change::State { node, state, .. } => self.shows(node, state, scene),
            _ => {}
        }
    }

    fn command(&mut self, command: u8, node: u8, scene: &Scene<'_>) {
        let Some(state) = commanded_state(command) else { return };
        let ordered = Ordered { command, state, at: scene.at, told: false };
        for ((bus, id), known) in &mut self.nodes {
            if *bus != scene.bus || node != 0 && node != *id {
                continue;
            }
            let again = known.ordered.is_some_and(|before| before.state == state);
            if state != BOOT_UP && known.shown == Some(state) {
                known.ordered = None;
            } else if !again {
                known.ordered = Some(ordered);
            }
        }
        if node != 0 && !self.nodes.contains_key(&(scene.bus, node)) {
            self.known(scene.bus, node).ordered = Some(ordered);
        }
    }

    fn shows(&mut self, node: u8, state: u8, scene: &mut Scene<'_>) {
        let known = self.known(scene.bus, node);
        known.shown = Some(state);
        let Some(ordered) = known.ordered else { return };
        let Some(waited) = scene.at.t_ns.zip(ordered.at.t_ns).map(|(now, then)| now - then) else {
            return;
        };
        let shown = state == ordered.state;
        if shown || state == BOOT_UP {
            known.ordered = None;
        }
        if ordered.told || !shown && state == BOOT_UP {
            return;
        }
        let about = |entry: &LatencyEntry| entry.of == Measure::Nmt && (shown || waited > entry.max_ns);
        let raised = self.measure(about, Some(node), waited, scene, |expected, scene| {
            let (found, command) = (waited, ordered.command);
            let breach = if shown {
                scene.breach(Exp013::Command { expected, found, command })
            } else {
                scene.breach(Exp013::CommandPending { expected, found, command, state })
            };
            breach.about(ordered.at)
        });
        if raised && let Some(ordered) = &mut self.known(scene.bus, node).ordered {
            ordered.told = true;
        }
    }

    fn known(&mut self, bus: BusId, node: u8) -> &mut KnownNode {
        self.nodes.entry((bus, node)).or_default()
    }

    /// Compares a time with the expectations. Returns true if it is too long for any of them.
    fn measure(
        &mut self,
        about: impl Fn(&LatencyEntry) -> bool,
        node: Option<u8>,
        found: Ns,
        scene: &mut Scene<'_>,
        breach: impl Fn(Ns, &Scene<'_>) -> Breach,
    ) -> bool {
        let mut raised = false;
        if found < Ns::ZERO {
            return raised;
        }
        for one in self.all.iter_mut().filter(|one| one.place.holds(scene.name, node) && about(&one.entry)) {
            one.measured = true;
            if found <= one.entry.max_ns {
                continue;
            }
            raised = true;
            scene.raise(&one.place, Breach { node, ..breach(one.entry.max_ns, scene) });
        }
        raised
    }

    /// Forgets pending requests, since frames of a bus are missing.
    pub(super) fn lost(&mut self, of: BusId) {
        self.pending.retain(|(_, bus, _)| *bus != of);
        self.nodes.retain(|(bus, _), _| *bus != of);
    }

    /// Reports at the end of the capture.
    pub(super) fn finish(&self, closing: &mut Closing<'_>) {
        let why = if closing.end_ns.is_none() { Exp015::NoStamps } else { Exp015::NothingMeasured };
        for one in self.all.iter().filter(|one| !one.measured) {
            closing.unchecked(&one.place, why.clone());
        }
    }
}

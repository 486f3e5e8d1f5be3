//! The data for a draft of expectations of a capture: ranges of signals, periods, states and the times at which they
//! were shown.
//!
//! It measures as the kinds of expectations do, without judging. It keeps figures only, and at most [`KEPT`] of each
//! kind.

use std::collections::BTreeMap;

use super::signal::{PdoChoice, stopped, value};
use super::{WrittenPeriod, written};
use crate::bytes::frame::{BusId, Frame, FrameRef};
use crate::bytes::ns::Ns;
use crate::evidence::period::expected::Rhythm;
use crate::evidence::period::spread::Spread;
use crate::sdo::transfer::Transfer;
use crate::wire::error_control::BOOT_UP;
use crate::wire::nmt::{RESET_COMMUNICATION, RESET_NODE};
use crate::wire::pdo::mapping::{Mapped, Mapping};
use crate::words::signal;
use crate::world::change::{Change, EmcyChange};
use crate::world::drive::DriveState;
use crate::world::event::{Event, Signals as Content, What};

/// Maximum number of signals, PDOs, states and so on that are kept apart.
pub const KEPT: usize = 4096;

/// A signal that was seen.
#[derive(Clone, Debug)]
pub struct Signal {
    /// The entry of its last mapping: its name and unit.
    pub mapped: Mapped,
    /// PDOs that carried it.
    pub count: u64,
    /// The first one.
    pub first: FrameRef,
    /// Least and greatest physical value; `None` if it is not a quantity or has no value.
    pub range: Option<(f64, f64)>,
}

/// Frames that repeat.
#[derive(Clone, Debug, Default)]
pub struct Train {
    /// The number of frames.
    pub count: u64,
    /// All times between them that are judged, in ns.
    pub all: Spread,
    /// Those of them that may be too short.
    pub strict: Spread,
    rhythm: Rhythm,
}

impl Train {
    /// Time in ns from the last frame to the end of the capture, which is judged like a time between two frames. `None`
    /// if something has stopped them, or without timestamps.
    pub fn silence_ns(&self, observed: &Observed) -> Option<Ns> {
        let last_ns = self.rhythm.last?.t_ns?;
        Some((observed.end_ns? - last_ns).max(Ns::ZERO))
    }

    fn beat(&mut self, at: FrameRef, extra: bool) {
        self.count += 1;
        if let Some(interval) = self.rhythm.next(at, extra) {
            self.all.add(interval.ns);
            if !interval.loose {
                self.strict.add(interval.ns);
            }
        }
    }
}

/// A state that was shown.
#[derive(Clone, Copy, Debug)]
pub struct ShownState {
    /// The number of times.
    pub count: u64,
    /// The first time.
    pub first: FrameRef,
    /// Time from the capture's first timestamp to it, in ns.
    pub since_start_ns: Option<Ns>,
    /// Time from the node's first boot-up to the first time after it, in ns.
    pub since_boot_up_ns: Option<Ns>,
    /// Another state was shown later.
    pub left: bool,
}

/// A state of a node, or of an axis of its drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum StateKind {
    /// In the encoding of error control.
    Nmt(u8),
    /// The axis, from 1, and its state.
    Drive(u8, DriveState),
}

/// An emergency error code that was reported.
#[derive(Clone, Copy, Debug)]
pub struct Reported {
    /// The number of times.
    pub count: u64,
    /// The first time.
    pub first: FrameRef,
}

/// The observed figures.
#[derive(Debug, Default)]
pub struct Observed {
    /// Signals by bus, PDO, index and sub-index.
    pub signals: BTreeMap<(BusId, PdoChoice, u16, u8), Signal>,
    /// PDOs.
    pub pdos: BTreeMap<(BusId, PdoChoice), Train>,
    /// States by bus and node-ID.
    pub states: BTreeMap<(BusId, u8, StateKind), ShownState>,
    /// EMCYs by bus, node-ID and error code.
    pub emergencies: BTreeMap<(BusId, u8, u16), Reported>,
    /// Heartbeats by bus and node-ID.
    pub heartbeats: BTreeMap<(BusId, u8), Train>,
    /// SYNCs by bus.
    pub syncs: BTreeMap<BusId, Train>,
    transfers: super::shown::ShownTransfers,
    /// First boot-ups.
    booted: BTreeMap<(BusId, u8), FrameRef>,
    start_ns: Option<Ns>,
    end_ns: Option<Ns>,
}

/// Returns the value of a key, which is created if there is room.
fn kept<K: Ord, V>(map: &mut BTreeMap<K, V>, key: K, make: impl FnOnce() -> V) -> Option<&mut V> {
    (map.len() < KEPT || map.contains_key(&key)).then(|| map.entry(key).or_insert_with(make))
}

impl Observed {
    /// Takes a frame and its events.
    pub fn frame(&mut self, frame: &Frame, events: &[Event]) {
        if let Some(now_ns) = frame.t_ns {
            self.start_ns.get_or_insert(now_ns);
            self.end_ns = Some(now_ns);
        }
        for event in events {
            let (bus, at) = (event.bus, event.at);
            if let Some(transfer) = self.transfers.next(&event.what) {
                self.transfer(&transfer);
            }
            match &event.what {
                What::Pdo(data) => {
                    let pdo = PdoChoice { node: data.node, transmit: data.transmit, number: data.number };
                    if let Content::Mapped(mapping, _) | Content::ByConsumer(mapping, ..) = &data.content {
                        self.signals(bus, pdo, mapping, frame);
                    }
                    if let Some(train) = kept(&mut self.pdos, (bus, pdo), Train::default) {
                        train.beat(at, false);
                    }
                }
                What::Mpdo(data) => {
                    let pdo = PdoChoice { node: data.node, transmit: data.transmit, number: data.number };
                    self.signals(bus, pdo, &data.mapping, frame);
                }
                What::Change(change) => self.change(change, bus, at),
                _ => {}
            }
        }
    }

    fn signals(&mut self, bus: BusId, pdo: PdoChoice, mapping: &Mapping, frame: &Frame) {
        for mapped in mapping.entries.iter().filter(|mapped| !mapped.dummy) {
            let first = frame.reference();
            let made = || Signal { mapped: mapped.clone(), count: 0, first, range: None };
            let Some(one) = kept(&mut self.signals, (bus, pdo, mapped.index, mapped.sub), made) else { continue };
            one.count += 1;
            let read = value(mapping, mapped, frame).filter(|_| signal::is_quantity(mapped));
            if let Some(read) = read {
                let (least, greatest) = one.range.unwrap_or((read, read));
                one.range = Some((least.min(read), greatest.max(read)));
            }
        }
    }

    fn transfer(&mut self, transfer: &Transfer) {
        let (bus, node) = (transfer.bus, transfer.node);
        match written(transfer) {
            Some(WrittenPeriod::Heartbeat) => self.interrupt_heartbeats(bus, node),
            Some(WrittenPeriod::Pdo) => self.interrupt_pdos(bus, node),
            Some(WrittenPeriod::Sync) => {
                if let Some(train) = self.syncs.get_mut(&bus) {
                    train.rhythm.interrupt();
                }
            }
            None => {}
        }
    }

    fn change(&mut self, change: &Change, bus: BusId, at: FrameRef) {
        if let Some(node) = stopped(change) {
            self.interrupt_pdos(bus, node);
        }
        match *change {
            Change::SyncCycle { .. } => {
                if let Some(train) = kept(&mut self.syncs, bus, Train::default) {
                    train.beat(at, false);
                }
            }
            Change::Error(EmcyChange { node, code, .. }) => {
                let made = || Reported { count: 0, first: at };
                if let Some(reported) = kept(&mut self.emergencies, (bus, node, code), made) {
                    reported.count += 1;
                }
            }
            Change::BootUp { node } => {
                self.booted.entry((bus, node)).or_insert(at);
                self.interrupt_heartbeats(bus, node);
                self.show(bus, node, StateKind::Nmt(BOOT_UP), at);
                // The node's drive starts anew.
                for ((of, id, kind), shown) in &mut self.states {
                    shown.left |= *of == bus && *id == node && matches!(kind, StateKind::Drive(..));
                }
            }
            Change::Drive { node, axis, state: Some(state), .. } => {
                self.show(bus, node, StateKind::Drive(axis + 1, state), at);
            }
            Change::State { node, state, guarding, .. } => {
                self.show(bus, node, StateKind::Nmt(state), at);
                if !guarding && let Some(train) = kept(&mut self.heartbeats, (bus, node), Train::default) {
                    train.beat(at, change.is_another_state());
                }
            }
            Change::Command { command: RESET_NODE | RESET_COMMUNICATION, node } => self.interrupt_heartbeats(bus, node),
            _ => {}
        }
    }

    /// Records a shown state; others of the same kind are left.
    fn show(&mut self, bus: BusId, node: u8, kind: StateKind, at: FrameRef) {
        let since = |then: Option<Ns>| Some(at.t_ns? - then?);
        let since_start_ns = since(self.start_ns);
        let since_boot_up_ns = since(self.booted.get(&(bus, node)).and_then(|booted| booted.t_ns));
        for ((of, id, other), shown) in &mut self.states {
            shown.left |= *of == bus && *id == node && *other != kind && alike(*other, kind);
        }
        let made = || ShownState { count: 0, first: at, since_start_ns, since_boot_up_ns: None, left: false };
        if let Some(shown) = kept(&mut self.states, (bus, node, kind), made) {
            shown.count += 1;
            shown.since_boot_up_ns = shown.since_boot_up_ns.or(since_boot_up_ns);
        }
    }

    fn interrupt_heartbeats(&mut self, bus: BusId, node: u8) {
        for ((of, id), train) in &mut self.heartbeats {
            if *of == bus && (node == 0 || *id == node) {
                train.rhythm.interrupt();
            }
        }
    }

    fn interrupt_pdos(&mut self, bus: BusId, node: u8) {
        for ((of, pdo), train) in &mut self.pdos {
            if *of == bus && (node == 0 || pdo.node == node) {
                train.rhythm.interrupt();
            }
        }
    }

    /// Restarts the measurement of times, since frames of a bus, or of all, are missing.
    pub fn lost(&mut self, bus: Option<BusId>) {
        let all = |of: &BusId| bus.is_none_or(|bus| bus == *of);
        let heartbeats = self.heartbeats.iter_mut().filter(|((of, _), _)| all(of)).map(|(_, train)| train);
        let pdos = self.pdos.iter_mut().filter(|((of, _), _)| all(of)).map(|(_, train)| train);
        let syncs = self.syncs.iter_mut().filter(|(of, _)| all(of)).map(|(_, train)| train);
        for train in heartbeats.chain(pdos).chain(syncs) {
            train.rhythm.interrupt();
        }
    }
}

/// Returns true if two states exclude each other.
fn alike(one: StateKind, other: StateKind) -> bool {
    match (one, other) {
        (StateKind::Nmt(_), StateKind::Nmt(_)) => true,
        (StateKind::Drive(one, _), StateKind::Drive(other, _)) => one == other,
        _ => false,
    }
}

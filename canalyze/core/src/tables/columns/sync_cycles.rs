//! `sync_cycles`: one row a SYNC cycle, when the next one begins or the capture ends.
//!
//! Its number is that of `pdo.sync.cycle` in JSON lines: a SYNC that was captured twice, or one of another identifier,
//! begins none. `pdos` counts all synchronous PDOs of the cycle; the filter decides whether its SYNC is shown.
//! `period_ns` is the time since the SYNC before, null after a gap in the capture; `window_ns` the least synchronous
//! window in force when the cycle began (1007h, option or EDS). Must not: judge.

use std::collections::BTreeMap;

use arrow_array::types::{Int64Type, UInt8Type, UInt32Type, UInt64Type};

use super::Seen;
use super::column::{Batch, Numbers, Table, Words, columns};
use crate::bytes::frame::{BusId, Buses, Frame, FrameRef};
use crate::wire::message::Message;
use crate::world::event::{Event, What};

columns! {
    /// The columns.
    SyncCycles {
        cycle: Numbers<UInt64Type>;
        frame: Numbers<UInt64Type>;
        t_ns: Numbers<Int64Type>, or_null;
        bus: Words, or_null;
        period_ns: Numbers<Int64Type>, or_null;
        counter: Numbers<UInt8Type>, or_null;
        pdos: Numbers<UInt32Type>;
        delay_min_ns: Numbers<Int64Type>, or_null;
        delay_max_ns: Numbers<Int64Type>, or_null;
        window_ns: Numbers<Int64Type>, or_null;
    }
}

/// The PDOs of a cycle.
#[derive(Clone, Copy, Debug, Default)]
struct CyclePdos {
    pdos: u32,
    /// Least and greatest delay in ns.
    delays: Option<(i64, i64)>,
}

/// The cycle that runs on a bus.
#[derive(Clone, Copy, Debug, Default)]
struct Running {
    /// Its number; 0 before the first SYNC.
    cycle: u64,
    at: FrameRef,
    shown: bool,
    period_ns: Option<i64>,
    counter: Option<u8>,
    window_ns: Option<i64>,
    seen: CyclePdos,
    /// What came before the SYNC that it belongs to.
    early: CyclePdos,
    /// Frames were lost since.
    broken: bool,
}

/// The cycles that run, by bus, and the table of those that are over.
#[derive(Debug)]
pub(super) struct Cycles {
    /// The table.
    pub(super) table: Table<SyncCycles>,
    running: BTreeMap<BusId, Running>,
}

impl Cycles {
    /// No cycle yet.
    pub(super) fn new(table: Table<SyncCycles>) -> Self {
        Self { table, running: BTreeMap::new() }
    }

    /// Takes a frame of a bus on which the cycle of this number runs now; `shown`: the filter lets it through.
    pub(super) fn frame(&mut self, done: &mut Vec<Batch>, at_hand: Seen<'_>, frame: &Frame, events: &[Event]) {
        let Seen { cycle, window_ns, shown, setting, .. } = at_hand;
        match events.first().map(|event| &event.what) {
            Some(What::Pdo(data)) => {
                let Some(placement) = data.sync else { return };
                let running = self.running.entry(frame.bus).or_default();
                let seen = if placement.cycle > running.cycle { &mut running.early } else { &mut running.seen };
                seen.pdos = seen.pdos.saturating_add(1);
                if let Some(delay) = placement.delay_ns {
                    let (least, most) = seen.delays.unwrap_or((delay, delay));
                    seen.delays = Some((least.min(delay), most.max(delay)));
                }
            }
            Some(What::Message(message)) => {
                let running = self.running.entry(frame.bus).or_default();
                if cycle <= running.cycle {
                    return;
                }
                let counter = if let Message::Sync { counter } = message { *counter } else { None };
                let at = frame.reference();
                let before = *running;
                let known = before.cycle > 0 && !before.broken;
                let times = at.t_ns.zip(before.at.t_ns).filter(|(now, then)| known && now >= then);
                let period_ns = times.map(|(now, then)| now.saturating_sub(then));
                let seen = before.early;
                *running = Running { cycle, at, shown, period_ns, counter, window_ns, seen, ..Running::default() };
                row(&mut self.table, done, setting.buses.name(frame.bus), &before);
            }
            _ => {}
        }
    }

    /// Frames of a bus, or of all, were lost: no time is measured across the gap.
    pub(super) fn lost(&mut self, bus: Option<BusId>) {
        for (_, running) in self.running.iter_mut().filter(|(id, _)| bus.is_none_or(|bus| bus == **id)) {
            running.broken = true;
        }
    }

    /// The capture is over: so are the cycles.
    pub(super) fn finish(&mut self, done: &mut Vec<Batch>, buses: &Buses) {
        for (bus, running) in std::mem::take(&mut self.running) {
            row(&mut self.table, done, buses.name(bus), &running);
        }
        self.table.finish(done);
    }
}

fn row(table: &mut Table<SyncCycles>, done: &mut Vec<Batch>, bus: &[u8], over: &Running) {
    if over.cycle == 0 || !over.shown {
        return;
    }
    let columns = &mut table.columns;
    columns.cycle.append_value(over.cycle);
    columns.frame.append_value(over.at.no);
    columns.t_ns.append_option(over.at.t_ns);
    columns.bus.name(bus);
    columns.period_ns.append_option(over.period_ns);
    columns.counter.append_option(over.counter);
    columns.pdos.append_value(over.seen.pdos);
    columns.delay_min_ns.append_option(over.seen.delays.map(|(least, _)| least));
    columns.delay_max_ns.append_option(over.seen.delays.map(|(_, most)| most));
    columns.window_ns.append_option(over.window_ns);
    table.end_row(0, done);
}

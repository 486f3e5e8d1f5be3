//! `sync_cycles`: one row per SYNC cycle, when the next one begins or the capture ends.
//!
//! Its number is that of `pdo.sync.cycle` in JSON lines: a SYNC that was captured twice, or one of another identifier,
//! begins none. `pdos` counts all synchronous PDOs of the cycle; the filter decides whether its SYNC is shown.
//! `period_ns` is the time since the SYNC before, null after a gap in the capture; `window_ns` the least synchronous
//! window in force when the cycle began (1007h, option or EDS). Must not: judge.

use std::collections::BTreeMap;

use super::column::{Batch, Table};
use super::{Collector, Ends, TableContext};
use crate::bytes::frame::{BusId, Frame, FrameRef};
use crate::bytes::ns::Ns;
use crate::rules::finding::{Code, Finding};
use crate::tables::setting::Setting;
use crate::tables::table::{Cx, Duration, Moment, Name, U8, U32, U64, table};
use crate::world::change::Change;
use crate::world::event::{Event, What};

table! {
    /// One row per SYNC cycle.
    /// 一行是一个同步周期
    SyncCycles arrow "sync_cycles", |cx, one: (BusId, &Running)| {
        cycle: U64 = one.1.cycle;
        frame: U64 = one.1.at.no;
        t: Moment or null = one.1.at.t_ns;
        bus: Name or null = cx.setting.bus(one.0);
        /// since the previous SYNC
        /// 距上一个SYNC
        period: Duration or null = one.1.period_ns;
        /// SYNC counter
        /// SYNC计数器
        counter: U8 or null = one.1.counter;
        /// synchronous PDOs in this cycle
        /// 该周期内同步PDO的个数
        pdos: U32 = one.1.seen.pdos;
        /// shortest delay of a synchronous PDO after SYNC
        /// 同步PDO距SYNC的最短延迟
        delay_min: Duration or null = one.1.seen.delays.map(|(least, _)| least);
        /// longest delay of a synchronous PDO after SYNC
        /// 同步PDO距SYNC的最长延迟
        delay_max: Duration or null = one.1.seen.delays.map(|(_, most)| most);
        /// synchronous window (1007h)
        /// 同步窗口（1007h）
        window: Duration or null = one.1.window_ns;
    }
}

/// The PDOs of a cycle.
#[derive(Clone, Copy, Debug, Default)]
struct CyclePdos {
    pdos: u32,
    /// Least and greatest delay in ns.
    delays: Option<(Ns, Ns)>,
}

/// The cycle that runs on a bus.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::tables) struct Running {
    /// Its number; 0 before the first SYNC.
    cycle: u64,
    at: FrameRef,
    shown: bool,
    period_ns: Option<Ns>,
    counter: Option<u8>,
    window_ns: Option<Ns>,
    seen: CyclePdos,
    /// PDOs before the SYNC that they belong to.
    early: CyclePdos,
    /// Frames were lost since.
    broken: bool,
}

/// The cycles that run, by bus, and the table of those that are over.
#[derive(Debug, Default)]
pub(super) struct Cycles {
    table: Table<SyncCycles>,
    running: BTreeMap<BusId, Running>,
}

impl Cycles {
    fn row(&mut self, done: &mut Vec<Batch>, setting: Setting<'_>, bus: BusId, over: &Running) {
        if over.cycle > 0 && over.shown {
            self.table.row(done, &Cx::of(setting), (bus, over));
        }
    }
}

impl Collector for Cycles {
    fn passing(&mut self, done: &mut Vec<Batch>, scene: TableContext<'_>, frame: &Frame, events: &[Event]) {
        let TableContext { window_ns, shown, setting, .. } = scene;
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
            Some(What::Message(_)) => {
                let cycle = events.iter().find_map(|event| match event.what {
                    What::Change(Change::SyncCycle { cycle, counter }) => Some((cycle, counter)),
                    _ => None,
                });
                let Some((cycle, counter)) = cycle else { return };
                let running = self.running.entry(frame.bus).or_default();
                let at = frame.reference();
                let before = *running;
                let known = before.cycle > 0 && !before.broken;
                let times = at.t_ns.zip(before.at.t_ns).filter(|(now, then)| known && now >= then);
                let period_ns = times.map(|(now, then)| now - then);
                let seen = before.early;
                *running = Running { cycle, at, shown, period_ns, counter, window_ns, seen, ..Running::default() };
                self.row(done, setting, frame.bus, &before);
            }
            _ => {}
        }
    }

    /// Frames of a bus, or of all, were lost: no time is measured across the gap.
    fn finding(&mut self, _: &mut Vec<Batch>, _: TableContext<'_>, finding: &Finding) {
        let is_lost = |bus: BusId| match finding.code {
            Code::Cap002 => bus == finding.bus,
            code => matches!(code, Code::Cap004 | Code::Cap008),
        };
        for (_, running) in self.running.iter_mut().filter(|(bus, _)| is_lost(**bus)) {
            running.broken = true;
        }
    }

    fn finish(&mut self, done: &mut Vec<Batch>, scene: TableContext<'_>) {
        for (bus, running) in std::mem::take(&mut self.running) {
            self.row(done, scene.setting, bus, &running);
        }
        self.table.finish(done);
    }

    fn table(&mut self) -> &mut dyn Ends {
        &mut self.table
    }
}

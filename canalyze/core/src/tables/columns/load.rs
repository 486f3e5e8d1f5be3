//! `load`: one row each 100 ms of a bus: how busy it was.
//!
//! Windows follow one another from the bus's first stamp on; `t_ns` is the end of one, `frame` and `cycle` are those of
//! the last frame before it. However long a bus is silent, that is two rows of 0: the first window without a frame and
//! the last one. The window that the end of the capture cuts is left out, unless it is the bus's only one. What the
//! filter lets through counts, with the bits of the summary; frames without a stamp do not. Must not: judge.

use std::collections::BTreeMap;

use arrow_array::types::{Float64Type, Int64Type, UInt32Type, UInt64Type};

use super::Seen;
use super::column::{Batch, Numbers, Table, Words, columns};
use crate::bytes::frame::{BusId, Buses, Frame, FrameRef};
use crate::views::summary::bits;

/// Length of a window in ns.
const WINDOW: i64 = 100_000_000;
/// Windows a second.
const PER_SECOND: f64 = 10.0;

columns! {
    /// The columns.
    Rows {
        t_ns: Numbers<Int64Type>;
        frame: Numbers<UInt64Type>;
        cycle: Numbers<UInt64Type>;
        bus: Words, or_null;
        frames: Numbers<UInt32Type>;
        bits: Numbers<UInt64Type>;
        frames_per_s: Numbers<Float64Type>;
        load_percent: Numbers<Float64Type>, or_null;
    }
}

/// The window that runs on a bus.
#[derive(Debug, Default)]
struct Running {
    /// When it began, in ns.
    begin_ns: i64,
    frames: u32,
    bits: u64,
    /// The last frame, and the SYNC cycle at it.
    last: (u64, u64),
    /// The end of the first window of a silence that lasts.
    silent_ns: Option<i64>,
    /// Some window of the bus is over.
    told: bool,
}

/// The table, and the windows that run.
#[derive(Debug)]
pub(super) struct Load {
    /// The table.
    pub(super) table: Table<Rows>,
    /// Bits that fit into a window, where the bit rate is known.
    room: Option<f64>,
    running: BTreeMap<BusId, Running>,
}

impl Load {
    /// No row yet. `bit_rate`: of all buses, in bit/s.
    pub(super) fn new(table: Table<Rows>, bit_rate: Option<u32>) -> Self {
        let room = bit_rate.filter(|rate| *rate > 0).map(|rate| f64::from(rate) / PER_SECOND);
        Self { table, room, running: BTreeMap::new() }
    }

    /// Takes a frame.
    pub(super) fn frame(&mut self, done: &mut Vec<Batch>, seen: Seen<'_>, frame: &Frame) {
        let Some(t_ns) = frame.t_ns else { return };
        let Self { table, room, running } = self;
        let running = running.entry(frame.bus).or_insert_with(|| Running { begin_ns: t_ns, ..Running::default() });
        let mut say =
            |running: &Running, end_ns| row(table, done, *room, seen.setting.buses.name(frame.bus), running, end_ns);
        if t_ns < running.begin_ns.saturating_sub(WINDOW) {
            // The clock was set back: what was counted is all that there is of the window.
            if running.frames > 0 {
                say(running, running.begin_ns.saturating_add(WINDOW));
            }
            running.silence_ends(&mut say);
            *running = Running { begin_ns: t_ns, told: true, ..Running::default() };
        }
        running.advance(t_ns, &mut say);
        running.silence_ends(&mut say);
        running.frames = running.frames.saturating_add(1);
        running.bits = running.bits.saturating_add(u64::from(bits::on_the_wire(frame)));
        running.last = (frame.no, seen.cycle);
    }

    /// It is `now_ns` on the clock of the frames.
    pub(super) fn advance(&mut self, done: &mut Vec<Batch>, buses: &Buses, now_ns: i64) {
        let Self { table, room, running } = self;
        for (bus, running) in running {
            running.advance(now_ns, &mut |running, end_ns| row(table, done, *room, buses.name(*bus), running, end_ns));
        }
    }

    /// The capture, whose last frame this was, is over.
    pub(super) fn finish(&mut self, done: &mut Vec<Batch>, buses: &Buses, last: FrameRef) {
        if let Some(end_ns) = last.t_ns {
            self.advance(done, buses, end_ns);
        }
        let Self { table, room, running } = self;
        for (bus, running) in running {
            let mut say = |running: &Running, end_ns| row(table, done, *room, buses.name(*bus), running, end_ns);
            running.silence_ends(&mut say);
            if !running.told && running.frames > 0 {
                say(running, running.begin_ns.saturating_add(WINDOW));
            }
        }
        self.table.finish(done);
    }
}

impl Running {
    /// It is `now_ns`: says what is over by then.
    #[inline]
    fn advance(&mut self, now_ns: i64, say: &mut dyn FnMut(&Self, i64)) {
        if now_ns >= self.begin_ns.saturating_add(WINDOW) {
            self.pass(now_ns, say);
        }
    }

    fn pass(&mut self, now_ns: i64, say: &mut dyn FnMut(&Self, i64)) {
        let end_ns = self.begin_ns.saturating_add(WINDOW);
        let passed = now_ns.saturating_sub(self.begin_ns) / WINDOW;
        self.begin_ns = self.begin_ns.saturating_add(passed.saturating_mul(WINDOW));
        if self.silent_ns.is_some() {
            return;
        }
        self.told = true;
        let mut first_ns = end_ns;
        if self.frames > 0 {
            say(self, end_ns);
            (self.frames, self.bits) = (0, 0);
            first_ns = end_ns.saturating_add(WINDOW);
        }
        if self.begin_ns >= first_ns {
            say(self, first_ns);
            self.silent_ns = Some(first_ns);
        }
    }

    /// Says the last window of a silence.
    #[inline]
    fn silence_ends(&mut self, say: &mut dyn FnMut(&Self, i64)) {
        if let Some(first_ns) = self.silent_ns.take()
            && self.begin_ns > first_ns
        {
            say(self, self.begin_ns);
        }
    }
}

fn row(table: &mut Table<Rows>, done: &mut Vec<Batch>, room: Option<f64>, bus: &[u8], over: &Running, end_ns: i64) {
    let columns = &mut table.columns;
    columns.t_ns.append_value(end_ns);
    let (frame, cycle) = over.last;
    columns.frame.append_value(frame);
    columns.cycle.append_value(cycle);
    columns.bus.name(bus);
    columns.frames.append_value(over.frames);
    columns.bits.append_value(over.bits);
    columns.frames_per_s.append_value(f64::from(over.frames) * PER_SECOND);
    columns.load_percent.append_option(room.map(|room| 100.0 * over.bits as f64 / room));
    table.end_row(0, done);
}

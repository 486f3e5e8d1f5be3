//! `load`: one row per 100 ms of a bus, with its load.
//!
//! Windows follow one another from the bus's first stamp on; `t_ns` is the end of one, `frame` and `cycle` are those of
//! the last frame before it. However long a bus is silent, that is two rows of 0: the first window without a frame and
//! the last one. The window that the end of the capture cuts is left out, unless it is the bus's only one. What the
//! filter lets through counts, with the bits of the summary; frames without a stamp do not. Must not: judge.

use std::collections::BTreeMap;

use super::column::{Batch, Table};
use super::{Collector, Ends, TableContext};
use crate::bytes::frame::{BusId, Frame};
use crate::bytes::ns::Ns;
use crate::tables::setting::Setting;
use crate::tables::table::{Cx, Moment, Name, Real, U32, U64, table};
use crate::views::summary::bits;
use crate::world::event::Event;

/// Length of a window in ns.
const WINDOW: Ns = Ns::from_ms(100);
/// Windows a second.
const PER_SECOND: f64 = 10.0;

/// A window that is over.
#[derive(Clone, Copy)]
pub(in crate::tables) struct LoadWindow<'a> {
    bus: BusId,
    running: &'a Running,
    end_ns: Ns,
    /// Bits that fit into a window, where the bit rate is known.
    room: Option<f64>,
}

table! {
    /// One row per bus and 100 ms.
    /// 一行是一条总线的100 ms
    Windows arrow "load", |cx, one: LoadWindow<'_>| {
        t: Moment = one.end_ns;
        frame: U64 = one.running.last.0;
        cycle: U64 = one.running.last.1;
        bus: Name or null = cx.setting.bus(one.bus);
        /// number of frames
        /// 帧数
        frames: U32 = one.running.frames;
        /// bits on the wire
        /// 总线上的位数
        bits: U64 = one.running.bits;
        /// frame rate
        /// 帧率
        frames_per_s: Real = f64::from(one.running.frames) * PER_SECOND;
        /// bus load; needs a bit rate
        /// 总线负载；需要波特率
        load_percent: Real or null = one.room.map(|room| 100.0 * one.running.bits as f64 / room);
    }
}

/// The window that runs on a bus.
#[derive(Debug, Default)]
pub(in crate::tables) struct Running {
    /// When it began, in ns.
    begin_ns: Ns,
    frames: u32,
    bits: u64,
    /// The last frame, and the SYNC cycle at it.
    last: (u64, u64),
    /// The end of the first window of a silence that lasts.
    silent_ns: Option<Ns>,
    /// Some window of the bus is over.
    told: bool,
}

/// The table, and the windows that run.
#[derive(Debug)]
pub(super) struct Load {
    table: Table<Windows>,
    /// Bits that fit into a window, where the bit rate is known.
    room: Option<f64>,
    running: BTreeMap<BusId, Running>,
}

impl Load {
    /// Returns a table without rows. `bit_rate`: of all buses, in bit/s.
    pub(super) fn new(bit_rate: Option<u32>) -> Self {
        let room = bit_rate.filter(|rate| *rate > 0).map(|rate| f64::from(rate) / PER_SECOND);
        Self { table: Table::default(), room, running: BTreeMap::new() }
    }
}

impl Collector for Load {
    fn frame(&mut self, done: &mut Vec<Batch>, scene: TableContext<'_>, frame: &Frame, _: &[Event]) {
        let Some(t_ns) = frame.t_ns else { return };
        let Self { table, room, running } = self;
        let running = running.entry(frame.bus).or_insert_with(|| Running { begin_ns: t_ns, ..Running::default() });
        let mut say = says(table, done, *room, scene.setting, frame.bus);
        if t_ns < running.begin_ns - WINDOW {
            // The clock was set back: nothing more of the window comes.
            if running.frames > 0 {
                say(running, running.begin_ns + WINDOW);
            }
            running.silence_ends(&mut say);
            *running = Running { begin_ns: t_ns, told: true, ..Running::default() };
        }
        running.advance(t_ns, &mut say);
        running.silence_ends(&mut say);
        running.frames = running.frames.saturating_add(1);
        running.bits = running.bits.saturating_add(u64::from(bits::on_the_wire(frame)));
        running.last = (frame.no, scene.cycle);
    }

    fn advance(&mut self, done: &mut Vec<Batch>, setting: Setting<'_>, now_ns: Ns) {
        let Self { table, room, running } = self;
        for (bus, running) in running {
            running.advance(now_ns, &mut says(table, done, *room, setting, *bus));
        }
    }

    fn finish(&mut self, done: &mut Vec<Batch>, scene: TableContext<'_>) {
        if let Some(end_ns) = scene.last.t_ns {
            self.advance(done, scene.setting, end_ns);
        }
        let Self { table, room, running } = self;
        for (bus, running) in running {
            let mut say = says(table, done, *room, scene.setting, *bus);
            running.silence_ends(&mut say);
            if !running.told && running.frames > 0 {
                say(running, running.begin_ns + WINDOW);
            }
        }
        self.table.finish(done);
    }

    fn table(&mut self) -> &mut dyn Ends {
        &mut self.table
    }
}

/// Returns a function that appends a window that is over, and ends at a time.
fn says<'a>(
    table: &'a mut Table<Windows>,
    done: &'a mut Vec<Batch>,
    room: Option<f64>,
    setting: Setting<'a>,
    bus: BusId,
) -> impl FnMut(&Running, Ns) + 'a {
    move |running, end_ns| table.row(done, &Cx::of(setting), LoadWindow { bus, running, end_ns, room })
}

impl Running {
    /// It is `now_ns`: says what is over by then.
    #[inline]
    fn advance(&mut self, now_ns: Ns, say: &mut dyn FnMut(&Self, Ns)) {
        if now_ns >= self.begin_ns + WINDOW {
            self.pass(now_ns, say);
        }
    }

    fn pass(&mut self, now_ns: Ns, say: &mut dyn FnMut(&Self, Ns)) {
        let end_ns = self.begin_ns + WINDOW;
        let passed = (now_ns - self.begin_ns) / WINDOW;
        self.begin_ns += passed * WINDOW;
        if self.silent_ns.is_some() {
            return;
        }
        self.told = true;
        let mut first_ns = end_ns;
        if self.frames > 0 {
            say(self, end_ns);
            (self.frames, self.bits) = (0, 0);
            first_ns = end_ns + WINDOW;
        }
        if self.begin_ns >= first_ns {
            say(self, first_ns);
            self.silent_ns = Some(first_ns);
        }
    }

    /// Says the last window of a silence.
    #[inline]
    fn silence_ends(&mut self, say: &mut dyn FnMut(&Self, Ns)) {
        if let Some(first_ns) = self.silent_ns.take()
            && self.begin_ns > first_ns
        {
            say(self, self.begin_ns);
        }
    }
}

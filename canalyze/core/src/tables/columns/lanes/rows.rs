//! Rows of `lanes`: their writer, their places, and the names of lanes.
//!
//! Must not: know what a lane is about.

use std::fmt::Write;

use super::{Changes, LaneChange};
use crate::bytes::frame::{BusId, Frame, FrameRef};
use crate::bytes::ns::Ns;
use crate::tables::columns::column::{Append, Batch, Table};
use crate::tables::columns::cycle_numbers::CycleNumbers;
use crate::words::Lang;
use crate::words::escape::unsafe_on_a_terminal;

/// Distinct states that a lane shows before it shows [`MANY`].
pub(super) const DISTINCT: usize = 512;
/// The text for further states.
pub(super) const MANY: &str = "…";

/// The place of a row: time stamp in ns, frame, SYNC cycle of its bus.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct At {
    pub(super) t_ns: Option<Ns>,
    pub(super) frame: u64,
    pub(super) cycle: u64,
}

impl At {
    /// A frame in this cycle.
    pub(super) fn frame(frame: &Frame, cycle: u64) -> Self {
        Self { t_ns: frame.t_ns, frame: frame.no, cycle }
    }

    /// An earlier frame of a bus.
    pub(super) fn of(at: FrameRef, bus: BusId, cycles: &CycleNumbers) -> Self {
        Self { t_ns: at.t_ns, frame: at.no, cycle: cycles.at(bus, at.no) }
    }

    /// The same at another time. One before `least` is that of a clock that was set meanwhile: then nothing changes.
    pub(super) fn at_time(self, t_ns: Option<Ns>, least: Self) -> Self {
        let t_ns = t_ns.filter(|t_ns| least.t_ns.is_none_or(|least| *t_ns >= least)).or(self.t_ns);
        Self { t_ns, ..self }
    }
}

/// The writer of rows.
#[derive(Debug)]
pub(super) struct Pen<'a> {
    pub(super) table: &'a mut Table<Changes>,
    pub(super) done: &'a mut Vec<Batch>,
    pub(super) lang: Lang,
    /// Words being put together; empty between two rows.
    pub(super) text: &'a mut Vec<u8>,
}

impl Pen<'_> {
    /// Writes a row with the words that `say` appends.
    pub(super) fn says(
        &mut self,
        lane: &str,
        at: At,
        class: Option<&'static str>,
        say: impl FnOnce(&mut Vec<u8>, Lang),
    ) {
        let mut text = std::mem::take(self.text);
        say(&mut text, self.lang);
        self.row(lane, at, Some(&String::from_utf8_lossy(&text)), class);
        text.clear();
        *self.text = text;
    }

    /// Writes a row.
    pub(super) fn row(&mut self, lane: &str, at: At, state: Option<&str>, class: Option<&'static str>) {
        self.table.columns.append((), LaneChange { lane, at, state, class });
        self.table.end_row(lane.len() + state.map_or(0, str::len), self.done);
    }

    /// The lane ends, or is idle.
    pub(super) fn end(&mut self, lane: &str, at: At) {
        self.row(lane, at, None, None);
    }
}

/// Returns the prefix of a lane's name for a bus, `can0/`; empty if the capture names none.
pub(super) fn prefix(bus: &[u8]) -> String {
    let mut name = String::new();
    if !bus.is_empty() {
        part(&mut name, bus);
        name.push('/');
    }
    name
}

/// Appends text as a part of a lane's name: a blank is `_`, what would end the part or is not a plain character `%2F`.
pub(super) fn part(name: &mut String, text: &[u8]) {
    for chunk in text.utf8_chunks() {
        for c in chunk.valid().chars() {
            match c {
                ' ' => name.push('_'),
                '/' | '%' => percent(name, c.encode_utf8(&mut [0; 4]).as_bytes()),
                _ if c.is_whitespace() || unsafe_on_a_terminal(c) => {
                    percent(name, c.encode_utf8(&mut [0; 4]).as_bytes());
                }
                _ => name.push(c),
            }
        }
        percent(name, chunk.invalid());
    }
}

fn percent(name: &mut String, bytes: &[u8]) {
    for byte in bytes {
        // Writing to a string cannot fail.
        let _ = write!(name, "%{byte:02X}");
    }
}

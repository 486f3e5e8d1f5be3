//! `load`: one row each 100 ms of a bus: how busy it was.
//!
//! What the filter lets through counts, as in the summary. Must not: judge.

use arrow_array::types::{Float64Type, Int64Type, UInt32Type, UInt64Type};

use super::Seen;
use super::column::{Batch, Numbers, Table, Words, columns};
use crate::frame::{Frame, FrameRef};

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

/// The table, and the windows that run.
#[derive(Debug)]
pub(super) struct Load {
    /// The table.
    pub(super) table: Table<Rows>,
}

impl Load {
    /// No row yet. `bit_rate`: of all buses, in bit/s.
    pub(super) fn new(table: Table<Rows>, _bit_rate: Option<u32>) -> Self {
        Self { table }
    }

    /// Takes a frame.
    pub(super) fn frame(&mut self, _done: &mut Vec<Batch>, _seen: Seen<'_>, _frame: &Frame) {}

    /// It is `now_ns` on the clock of the frames.
    pub(super) fn advance(&mut self, _done: &mut Vec<Batch>, _now_ns: i64) {}

    /// The capture, whose last frame this was, is over.
    pub(super) fn finish(&mut self, done: &mut Vec<Batch>, _last: FrameRef) {
        self.table.finish(done);
    }
}

//! `lanes`: one row a change of what a lane of a timeline shows.
//!
//! Must not: judge.

use arrow_array::types::{Int64Type, UInt64Type};

use super::Seen;
use super::column::{Batch, Numbers, Table, Words, columns};
use super::cycle_numbers::CycleNumbers;
use crate::event::Event;
use crate::finding::Finding;
use crate::frame::Frame;
use crate::render::jsonl::Setting;
use crate::render::selection::Selection;
use crate::services::sdo::transfer::Transfer;
use crate::text::Lang;

columns! {
    /// The columns.
    Rows {
        lane: Words;
        t_ns: Numbers<Int64Type>, or_null;
        frame: Numbers<UInt64Type>;
        cycle: Numbers<UInt64Type>;
        state: Words, or_null;
        class: Words, or_null;
    }
}

/// The table, and what its lanes show.
#[derive(Debug)]
pub(super) struct Lanes {
    /// The table.
    pub(super) table: Table<Rows>,
}

impl Lanes {
    /// No lane yet. `selection`: which signals have one.
    pub(super) fn new(table: Table<Rows>, _lang: Lang, _selection: Selection) -> Self {
        Self { table }
    }

    /// Takes a frame and what follows from it, whether it is shown or not, before [`Self::finding`] takes its findings
    /// and [`Self::transfer`] the transfers that end with it.
    pub(super) fn frame(&mut self, _done: &mut Vec<Batch>, _seen: Seen<'_>, _frame: &Frame, _events: &[Event]) {}

    /// Takes a transfer that has ended.
    pub(super) fn transfer(
        &mut self,
        _done: &mut Vec<Batch>,
        _setting: Setting<'_>,
        _cycles: &CycleNumbers,
        _transfer: &Transfer,
    ) {
    }

    /// Takes a finding that is shown, also one that repeats others; those about the capture among them.
    pub(super) fn finding(
        &mut self,
        _done: &mut Vec<Batch>,
        _setting: Setting<'_>,
        _cycles: &CycleNumbers,
        _finding: &Finding,
    ) {
    }

    /// The capture is over.
    pub(super) fn finish(&mut self, done: &mut Vec<Batch>) {
        self.table.finish(done);
    }
}

//! The contents of a capture as tables in Arrow's memory layout, for libraries, files of columns and timelines.
//!
//! Only tables that are asked for are built. A batch of one ends after 65,536 rows or 16 MiB of text and data, or when
//! it is asked for. Names and types of tables and columns are frozen by `tests.rs`: they are only ever added. Each file
//! declares its table, see [`super::table`].
//!
//! Times (`..._ns`) are int64 in ns, `t_ns` is JSON's `t`. Identifiers, indices and
//! codes are numbers; `object` is `1008:00`; `id` is that of an error frame its class. Words of few different values are
//! dictionary-encoded; those for people (`name`, `signal`, `text`, `message`, `abort_text`, `line`, `state` of a lane and
//! the signal in its name) are in the session's language; those of `wide` and `objects`, which queries compare, are
//! English. Strings from a capture or a description are as they are
//! there, what is not UTF-8 as U+FFFD: whoever prints them escapes them. Metadata of a schema: `table`, its name; of
//! those of PDOs also `bus node pdo version lang`.
//!
//! Must not: judge, or leave Rust: how columns are handed over is the binding's matter.

pub(in crate::tables) mod column;
mod cycle_numbers;
mod emcy;
pub(in crate::tables) mod findings;
pub(in crate::tables) mod frames;
mod lanes;
mod listing;
mod load;
mod log;
mod objects;
pub mod od;
pub mod od_nodes;
pub mod od_values;
mod pdo;
mod problems;
pub mod signals;
mod states;
mod sync_cycles;
pub mod transfers;

use std::fmt::Debug;

use self::column::{Ends, Table};
use self::cycle_numbers::CycleNumbers;
use self::lanes::Lanes;
use self::listing::Listing;
use self::load::Load;
use self::log::Log;
use self::objects::Objects;
use self::od::Od;
use self::pdo::{Of, Pdos};
use self::signals::Listed;
use self::sync_cycles::Cycles;
use super::jsonl::{note, pdo as pdo_object, pdos};
use super::selection::Selection;
use super::setting::Setting;
use super::table::{Cx, list};
use crate::bytes::frame::{BusId, Frame, FrameRef};
use crate::bytes::ns::Ns;
use crate::bytes::select::Select;
use crate::problems::Diagnosis;
use crate::rules::finding::{Finding, Severity};
use crate::sdo::transfer::Transfer;
use crate::views::inventory::Inventory;
use crate::words::Lang;
use crate::world::bus::Bus;
use crate::world::event::{Event, What};
use crate::world::repeats::Repeats;

pub use self::column::Batch;

/// The tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Name {
    /// Frames.
    Frames,
    /// SDO transfers.
    Transfers,
    /// NMT states.
    States,
    /// Emergencies.
    Emcy,
    /// Findings.
    Findings,
    /// SYNC cycles.
    SyncCycles,
    /// Signals, one a row.
    Signals,
    /// A table for each PDO and mapping.
    Pdo,
    /// The same in units and words.
    Wide,
    /// Values of objects, one a row.
    Objects,
    /// Objects of nodes, one a row.
    Od,
    /// Frames with what they mean, for people.
    Listing,
    /// Lanes of a timeline.
    Lanes,
    /// Findings and emergencies, for people.
    Log,
    /// Load of buses.
    Load,
    /// Problems.
    Problems,
}

impl Name {
    /// All of them, with the names by which they are asked for.
    pub const NAMES: &[(&str, Name)] = &[
        ("frames", Name::Frames),
        ("transfers", Name::Transfers),
        ("states", Name::States),
        ("emcy", Name::Emcy),
        ("findings", Name::Findings),
        ("sync_cycles", Name::SyncCycles),
        ("signals", Name::Signals),
        ("pdo", Name::Pdo),
        ("wide", Name::Wide),
        ("objects", Name::Objects),
        ("od", Name::Od),
        ("listing", Name::Listing),
        ("lanes", Name::Lanes),
        ("log", Name::Log),
        ("load", Name::Load),
        ("problems", Name::Problems),
    ];
}

/// A frame as the session sees it, beside what it means.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    /// Its service and the node that it is about, as filters know them.
    pub service: (&'static str, Option<u8>),
    /// The SYNC cycle that runs on its bus now; 0 before the first.
    pub cycle: u64,
    /// The least synchronous window in force on its bus, in ns, where one is known.
    pub window_ns: Option<Ns>,
    /// The filter lets it through.
    pub shown: bool,
    /// The context of output.
    pub setting: Setting<'a>,
}

/// The context of a record that a table takes.
#[derive(Clone, Copy)]
struct TableContext<'a> {
    setting: Setting<'a>,
    service: (&'static str, Option<u8>),
    cycle: u64,
    window_ns: Option<Ns>,
    shown: bool,
    /// The severity of the worst finding at the frame.
    severity: Option<Severity>,
    cycles: &'a CycleNumbers,
    /// The last frame.
    last: FrameRef,
}

impl<'a> TableContext<'a> {
    fn cx(&self) -> Cx<'a> {
        Cx::of(self.setting)
    }
}

/// A table with what it follows. Each takes what concerns it.
trait Collector: Debug + Send + Sync {
    /// Returns the table itself.
    fn table(&mut self) -> &mut dyn Ends;
    /// Takes the objects of nodes as they are to be collected.
    fn taking(&mut self, _inventory: &mut Inventory) {}
    /// Takes a frame and its events but for transfers, whether the filter lets it through or not.
    fn passing(&mut self, _done: &mut Vec<Batch>, _scene: TableContext<'_>, _frame: &Frame, _events: &[Event]) {}
    /// Takes a frame and its events but for transfers.
    fn frame(&mut self, _done: &mut Vec<Batch>, _scene: TableContext<'_>, _frame: &Frame, _events: &[Event]) {}
    /// Takes events that belong to no frame at hand.
    fn asides(&mut self, _done: &mut Vec<Batch>, _scene: TableContext<'_>, _events: &[Event]) {}
    /// Takes a finding that is shown.
    fn finding(&mut self, _done: &mut Vec<Batch>, _scene: TableContext<'_>, _finding: &Finding) {}
    /// Takes a finding about the capture, before [`Self::finding`].
    fn about_capture(&mut self, _done: &mut Vec<Batch>, _finding: &Finding) {}
    /// Takes a transfer that has ended.
    fn transfer(&mut self, _done: &mut Vec<Batch>, _scene: TableContext<'_>, _transfer: &Transfer) {}
    /// Frames of a bus may be missing.
    fn gap(&mut self, _done: &mut Vec<Batch>, _bus: BusId) {}
    /// It is `now_ns` on the clock of the frames.
    fn advance(&mut self, _done: &mut Vec<Batch>, _setting: Setting<'_>, _now_ns: Ns) {}
    /// Takes the state of the nodes at the end of the capture.
    fn settle(&mut self, _state: &[Bus]) {}
    /// Takes the problems of the capture, which is over.
    fn diagnosis(&mut self, _done: &mut Vec<Batch>, _scene: TableContext<'_>, _diagnosis: &Diagnosis) {}
    /// Ends the batch that runs.
    fn flush(&mut self, done: &mut Vec<Batch>) {
        self.table().flush(done);
    }
    /// Ends the last batch; the capture is over.
    fn finish(&mut self, done: &mut Vec<Batch>, _scene: TableContext<'_>) {
        self.table().finish(done);
    }
}

/// The tables that are asked for.
#[derive(Debug)]
pub struct Columns {
    /// Batches that are complete.
    done: Vec<Batch>,
    /// In the order of [`Name::NAMES`].
    tables: Vec<Box<dyn Collector>>,
    diagnoses: bool,
    cycle_numbers: CycleNumbers,
    repeats: Repeats,
    /// The last frame.
    last: FrameRef,
}

impl Columns {
    /// Returns these tables, without a row. `select`: the signals that are in them; `bit_rate`: of all buses, in bit/s.
    pub fn new(lang: Lang, select: &Select, tables: &[Name], bit_rate: Option<u32>) -> Self {
        let selection = |lang| Selection::new(lang, select.clone());
        let table = |name: &Name| -> Box<dyn Collector> {
            match name {
                Name::Frames => Box::<Table<frames::Frames>>::default(),
                Name::Transfers => Box::<Table<transfers::Transfers>>::default(),
                Name::States => Box::<Table<states::States>>::default(),
                Name::Emcy => Box::<Table<emcy::Emcy>>::default(),
                Name::Findings => Box::<Table<findings::Findings>>::default(),
                Name::SyncCycles => Box::<Cycles>::default(),
                Name::Signals => Box::new(Listed::new(selection(lang))),
                Name::Pdo => Box::new(Pdos::new(lang, selection(lang), Of::Bus)),
                Name::Wide => Box::new(Pdos::new(Lang::En, selection(Lang::En), Of::Values)),
                Name::Objects => Box::new(Objects::new(selection(Lang::En))),
                Name::Od => Box::<Od>::default(),
                Name::Listing => Box::new(Listing::new(lang)),
                Name::Lanes => Box::new(Lanes::new(lang, selection(lang))),
                Name::Log => Box::<Log>::default(),
                Name::Load => Box::new(Load::new(bit_rate)),
                Name::Problems => Box::<Table<problems::Problems>>::default(),
            }
        };
        let wanted = Name::NAMES.iter().map(|(_, name)| name).filter(|name| tables.contains(name));
        Self {
            done: Vec::new(),
            tables: wanted.map(table).collect(),
            diagnoses: tables.contains(&Name::Problems),
            cycle_numbers: CycleNumbers::default(),
            repeats: Repeats::default(),
            last: FrameRef::default(),
        }
    }

    /// Returns the same, with objects of nodes as this takes them.
    pub fn taking(mut self, mut inventory: Inventory) -> Self {
        self.tables.iter_mut().for_each(|table| table.taking(&mut inventory));
        self
    }

    /// Calls `take` with each table, in the context of no frame.
    fn each(
        &mut self,
        setting: Setting<'_>,
        mut take: impl FnMut(&mut dyn Collector, &mut Vec<Batch>, TableContext<'_>),
    ) {
        let Self { done, tables, cycle_numbers: cycles, last, .. } = self;
        let scene = TableContext {
            setting,
            service: ("foreign", None),
            cycle: 0,
            window_ns: None,
            shown: true,
            severity: None,
            cycles,
            last: *last,
        };
        tables.iter_mut().for_each(|table| take(&mut **table, done, scene));
    }

    /// Takes a frame and its events but for transfers. Repeats of findings are among them: they are folded here.
    pub fn frame(&mut self, seen: Seen<'_>, frame: &Frame, events: &[Event]) {
        let Seen { service, cycle, window_ns, shown, setting } = seen;
        self.last = frame.reference();
        self.cycle_numbers.frame(frame, cycle);
        self.each(setting, |table, done, scene| {
            table.passing(done, TableContext { service, cycle, window_ns, shown, ..scene }, frame, events);
        });
        // Repeats are counted whether they are shown or not.
        let severity = self.findings(setting, events, shown);
        if shown {
            self.each(setting, |table, done, scene| {
                table.frame(done, TableContext { service, cycle, window_ns, severity, ..scene }, frame, events);
            });
        }
    }

    /// Takes findings that belong to no frame at hand.
    pub fn asides(&mut self, setting: Setting<'_>, events: &[Event]) {
        self.each(setting, |table, done, scene| table.asides(done, scene, events));
        self.findings(setting, events, true);
    }

    /// A bus is away for a while, and may have had frames meanwhile.
    pub fn gap(&mut self, bus: BusId) {
        self.tables.iter_mut().for_each(|table| table.gap(&mut self.done, bus));
    }

    /// It is `now_ns` on the clock of the frames.
    pub fn advance(&mut self, setting: Setting<'_>, now_ns: Ns) {
        // The greatest time means that all frames have come, and is no time.
        if now_ns < Ns::MAX {
            self.tables.iter_mut().for_each(|table| table.advance(&mut self.done, setting, now_ns));
        }
    }

    /// Takes the findings among events that are shown, and returns the severity of the worst at the last frame.
    fn findings(&mut self, setting: Setting<'_>, events: &[Event], shown: bool) -> Option<Severity> {
        let mut worst = None;
        for event in events {
            let What::Finding(one) = &event.what else { continue };
            if self.repeats.shows(one) && shown {
                self.tell(setting, one);
                worst = worst.max((one.at == self.last).then_some(one.severity()));
            }
        }
        worst
    }

    fn tell(&mut self, setting: Setting<'_>, finding: &Finding) {
        self.each(setting, |table, done, scene| table.finding(done, scene, finding));
    }

    /// Returns true if problems are asked for.
    pub fn diagnoses(&self) -> bool {
        self.diagnoses
    }

    /// Takes the problems of the capture, which is over.
    pub fn diagnosis(&mut self, setting: Setting<'_>, diagnosis: &Diagnosis) {
        self.each(setting, |table, done, scene| table.diagnosis(done, scene, diagnosis));
    }

    /// Takes a transfer that has ended.
    pub fn transfer(&mut self, setting: Setting<'_>, transfer: &Transfer) {
        self.each(setting, |table, done, scene| table.transfer(done, scene, transfer));
    }

    /// Takes a finding about the capture.
    pub fn finding(&mut self, setting: Setting<'_>, finding: &Finding) {
        self.tables.iter_mut().for_each(|table| table.about_capture(&mut self.done, finding));
        self.tell(setting, finding);
    }

    /// Takes the state of the nodes at the end of the capture.
    pub fn settle(&mut self, state: &[Bus]) {
        self.tables.iter_mut().for_each(|table| table.settle(state));
    }

    /// The capture is over: the last batches, and one without rows of each table that has had none, for its schema.
    pub fn finish(&mut self, setting: Setting<'_>) {
        let mut counted = Vec::new();
        self.repeats.finish(self.last, &mut counted);
        for event in &counted {
            if let What::Finding(one) = &event.what {
                self.tell(setting, one);
            }
        }
        self.each(setting, |table, done, scene| table.finish(done, scene));
    }

    /// Takes the batches that are complete. `flush`: those that run end now.
    pub fn take(&mut self, flush: bool) -> Vec<Batch> {
        if flush {
            self.tables.iter_mut().for_each(|table| table.flush(&mut self.done));
        }
        std::mem::take(&mut self.done)
    }
}

/// Returns the schema of all records as a JSON list; see [`super::table`].
pub fn schema() -> Vec<u8> {
    const RECORDS: &[fn(&mut Vec<u8>)] = &[
        frames::Frames::schema,
        transfers::Transfers::schema,
        states::States::schema,
        emcy::Emcy::schema,
        findings::Findings::schema,
        problems::Problems::schema,
        sync_cycles::SyncCycles::schema,
        signals::Signals::schema,
        objects::Values::schema,
        od::Objects::schema,
        listing::Lined::schema,
        lanes::Changes::schema,
        log::Entries::schema,
        load::Windows::schema,
        pdo::Places::schema,
        note::Notes::schema,
        od_nodes::Nodes::schema,
        od_nodes::Pdos::schema,
        od_values::Values::schema,
        pdos::Lines::schema,
        pdos::Signals::schema,
        pdo_object::Pdos::schema,
        pdo_object::Signals::schema,
    ];
    let mut out = Vec::new();
    list(&mut out, RECORDS, |out, schema| schema(out));
    out
}

#[cfg(test)]
mod tests;

//! What a capture holds as tables of columns, in Arrow's memory layout: for libraries, files of columns and timelines.
//!
//! Only tables that are asked for are built. A batch of one ends after 65,536 rows or 16 MiB of text and data, or when
//! it is asked for. Names and types of tables and columns are frozen by `tests.rs`: they are only ever added.
//!
//! | table | a row is | columns |
//! |---|---|---|
//! | `frames` | a frame | `frame line? file t_ns? bus? id extended kind brs? esi? dir? len data service node?` |
//! | `transfers` | an SDO transfer | `transfer bus? node direction mode index? sub? object? name? type? size_indicated? size data string? boolean? integer? raw? value? text status abort_code? abort_by? abort_text? first_frame last_frame first_line? last_line? t_ns? duration_ns? reordered retransmissions crc_negotiated? findings` |
//! | `states` | a change of an NMT state, or an NMT command | `t_ns? frame bus? node? state? name? source command?` |
//! | `emcy` | an emergency | `t_ns? frame bus? node code name? register manufacturer active cleared` |
//! | `findings` | a finding | `code name severity file frame? line? t_ns? cause_frame? cause_line? about_frame? because_of? bus? node? index? sub? message facts` |
//! | `sync_cycles` | a SYNC cycle | `cycle frame t_ns? bus? period_ns? counter? pdos delay_min_ns? delay_max_ns? window_ns?` |
//! | `signals` | a signal of a PDO | `t_ns? frame line? bus? node pdo signal object value? integer? raw? data? unit? text? provenance` |
//! | `pdo` | a PDO; `pdo/can1/5.TPDO1/1` is a table for itself, see `pdo` | `t_ns? frame provenance cycle? delay_ns? running_cycle`, then its signals |
//! | `wide` | the same in units and words, see `pdo` | the same |
//! | `objects` | a value of an object that the capture shows | `t_ns? frame bus? node index? sub? source name? value? integer? text? unit?` |
//! | `od` | an object of a node, at the end of the capture | `bus? node index sub name? type? type_from? bits? access? readable? writable? exists? value? integer? text? data? source? t_ns? frame? values read written tpdo rpdo emcy refused unconfirmed abort_codes in_force? in_force_from? first_frame last_frame` |
//! | `listing` | a frame, for people | `frame t_ns? cycle bus? node? service severity? line` |
//! | `lanes` | a change of what a lane of a timeline shows | `lane t_ns? frame cycle state? class?` |
//! | `log` | a finding or an emergency, for people | `t_ns? frame cycle bus? node? level source code text` |
//! | `incidents` | what went wrong, at the end of the capture, a cause before what it caused | `id incident status impact grade depth bus? node? nodes axis? pdo? subject begin_frame t_ns? cycle noticed_frame noticed_t_ns? end_frame? end_t_ns? end_cycle? count root cause? cause_link? cause_grade? delay_ns? frames message checks facts` |
//! | `load` | 100 ms of a bus | `t_ns frame cycle bus? frames bits frames_per_s load_percent?` |
//!
//! `?`: null where there is none. Times (`..._ns`) are int64 in ns, `t_ns` is JSON's `t`. Identifiers, indices and
//! codes are numbers; `object` is `1008:00`; `id` is that of an error frame its class. Words of which there are few are
//! dictionary-encoded; those for people (`name`, `signal`, `text`, `message`, `abort_text`, `line`, `state` of a lane and
//! the signal in its name) are in the session's language; those of `wide` and `objects`, which queries compare, are
//! English. Strings from a capture or a description are as they are
//! there, what is not UTF-8 as U+FFFD: whoever prints them escapes them. Metadata of a schema: `table`, its name; of
//! those of PDOs also `bus node pdo version lang`.
//!
//! Must not: judge, or leave Rust: how columns are handed over is the binding's matter.

mod column;
mod cycle_numbers;
mod emcy;
mod findings;
mod frames;
mod incidents;
mod lanes;
mod listing;
mod load;
mod log;
mod objects;
mod od;
mod pdo;
mod signals;
mod states;
mod sync_cycles;
mod transfers;

use self::column::Table;
use self::cycle_numbers::CycleNumbers;
use self::emcy::Emcy;
use self::findings::Findings;
use self::frames::Frames;
use self::incidents::Incidents;
use self::lanes::Lanes;
use self::listing::Listing;
use self::load::Load;
use self::log::Log;
use self::objects::Objects;
use self::od::Od;
use self::pdo::{Of, Pdos};
use self::signals::Listed;
use self::states::States;
use self::sync_cycles::Cycles;
use self::transfers::Transfers;
use super::jsonl::Setting;
use super::selection::Selection;
use crate::bytes::frame::{BusId, Frame, FrameRef};
use crate::bytes::select::Select;
use crate::rules::finding::{Code, Finding, Severity};
use crate::sdo::transfer::Transfer;
use crate::stories::Diagnosis;
use crate::views::inventory::Inventory;
use crate::views::repeats::Repeats;
use crate::words::Lang;
use crate::world::bus::Bus;
use crate::world::event::{Event, What};

pub use self::column::Batch;
pub use self::lanes::class_of;

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
    /// How busy buses are.
    Load,
    /// What went wrong.
    Incidents,
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
        ("incidents", Name::Incidents),
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
    pub window_ns: Option<i64>,
    /// The filter lets it through.
    pub shown: bool,
    /// What is known of the capture.
    pub setting: Setting<'a>,
}

/// The tables that are asked for.
#[derive(Debug)]
pub struct Columns {
    /// Batches that are complete.
    done: Vec<Batch>,
    frames: Option<Table<Frames>>,
    transfers: Option<Table<Transfers>>,
    states: Option<Table<States>>,
    emcy: Option<Table<Emcy>>,
    findings: Option<Table<Findings>>,
    cycles: Option<Cycles>,
    signals: Option<Listed>,
    pdos: Option<Pdos>,
    wide: Option<Pdos>,
    objects: Option<Objects>,
    od: Option<Od>,
    listing: Option<Listing>,
    lanes: Option<Lanes>,
    log: Option<Log>,
    load: Option<Load>,
    incidents: Option<Table<Incidents>>,
    cycle_numbers: CycleNumbers,
    repeats: Repeats,
    /// The last frame.
    last: FrameRef,
}

impl Columns {
    /// These tables, without a row. `select`: which signals are in them; `bit_rate`: of all buses, in bit/s.
    pub fn new(lang: Lang, select: &Select, tables: &[Name], bit_rate: Option<u32>) -> Self {
        fn table<C: column::Columns + Default>(tables: &[Name], name: Name) -> Option<Table<C>> {
            let (word, _) = Name::NAMES.iter().find(|row| row.1 == name && tables.contains(&name))?;
            Some(Table::new(word, C::default(), &[]))
        }
        let selection = || Selection::new(lang, select.clone());
        let english = || Selection::new(Lang::En, select.clone());
        Self {
            done: Vec::new(),
            frames: table(tables, Name::Frames),
            transfers: table(tables, Name::Transfers),
            states: table(tables, Name::States),
            emcy: table(tables, Name::Emcy),
            findings: table(tables, Name::Findings),
            cycles: table(tables, Name::SyncCycles).map(Cycles::new),
            signals: table(tables, Name::Signals).map(|table| Listed::new(table, selection(), lang)),
            pdos: tables.contains(&Name::Pdo).then(|| Pdos::new(lang, selection(), Of::Bus)),
            wide: tables.contains(&Name::Wide).then(|| Pdos::new(Lang::En, english(), Of::Values)),
            objects: table(tables, Name::Objects).map(|table| Objects::new(table, english())),
            od: table(tables, Name::Od).map(|table| Od::new(table, lang)),
            listing: table(tables, Name::Listing).map(|table| Listing::new(table, lang)),
            lanes: table(tables, Name::Lanes).map(|table| Lanes::new(table, lang, selection())),
            log: table(tables, Name::Log).map(|table| Log::new(table, lang)),
            load: table(tables, Name::Load).map(|table| Load::new(table, bit_rate)),
            incidents: table(tables, Name::Incidents),
            cycle_numbers: CycleNumbers::default(),
            repeats: Repeats::default(),
            last: FrameRef::default(),
        }
    }

    /// The same, with objects of nodes as this takes them.
    pub fn taking(mut self, inventory: Inventory) -> Self {
        if let Some(od) = &mut self.od {
            od.inventory = inventory;
        }
        self
    }

    /// Takes a frame and what follows from it, but for transfers. Repeats of findings are among it: they are folded
    /// here.
    pub fn frame(&mut self, seen: Seen<'_>, frame: &Frame, events: &[Event]) {
        let Seen { service, cycle, shown, setting, .. } = seen;
        self.last = frame.reference();
        self.cycle_numbers.frame(frame, cycle);
        if let Some(cycles) = &mut self.cycles {
            cycles.frame(&mut self.done, seen, frame, events);
        }
        if let Some(lanes) = &mut self.lanes {
            lanes.frame(&mut self.done, seen, frame, events);
        }
        // Repeats are counted whether they are shown or not.
        let severity = self.findings(setting, events, shown);
        if !shown {
            return;
        }
        if let Some(listing) = &mut self.listing {
            listing.frame(&mut self.done, seen, frame, events.first(), severity);
        }
        if let Some(load) = &mut self.load {
            load.frame(&mut self.done, seen, frame);
        }
        if let Some(od) = &mut self.od {
            od.inventory.frame(frame, events);
        }
        if let Some(frames) = &mut self.frames {
            frames.frame(&mut self.done, setting, frame, service);
        }
        for event in events {
            match &event.what {
                What::Message(message) => {
                    if let Some(states) = &mut self.states {
                        states.message(&mut self.done, setting, event, message);
                    }
                    if let Some(emcy) = &mut self.emcy {
                        emcy.message(&mut self.done, setting, event, message);
                    }
                    if let Some(objects) = &mut self.objects {
                        objects.message(&mut self.done, setting, event, message);
                    }
                    if let Some(log) = &mut self.log {
                        log.message(&mut self.done, seen, frame, event, message);
                    }
                }
                What::Pdo(_) | What::Mpdo(_) => {
                    if let Some(signals) = &mut self.signals {
                        signals.event(&mut self.done, setting, frame, event);
                    }
                    if let Some(objects) = &mut self.objects {
                        objects.process_data(&mut self.done, setting, frame, event);
                    }
                    if let What::Pdo(data) = &event.what {
                        for pdos in [&mut self.pdos, &mut self.wide].into_iter().flatten() {
                            pdos.process_data(&mut self.done, seen, frame, data);
                        }
                    }
                }
                What::Finding(_) | What::Sdo(_) | What::Transfer(_) | What::Note(_) => {}
            }
        }
    }

    /// Takes findings that belong to no frame at hand.
    pub fn asides(&mut self, setting: Setting<'_>, events: &[Event]) {
        if let Some(lanes) = &mut self.lanes {
            lanes.asides(&mut self.done, &self.cycle_numbers, events);
        }
        self.findings(setting, events, true);
    }

    /// A bus is away for a while, and may have had frames meanwhile.
    pub fn gap(&mut self, bus: BusId) {
        if let Some(lanes) = &mut self.lanes {
            lanes.lost(&mut self.done, bus);
        }
    }

    /// It is `now_ns` on the clock of the frames.
    pub fn advance(&mut self, setting: Setting<'_>, now_ns: i64) {
        // The greatest time says that all frames have come, not what time it is.
        if let Some(load) = self.load.as_mut().filter(|_| now_ns < i64::MAX) {
            load.advance(&mut self.done, setting.buses, now_ns);
        }
    }

    /// Takes the findings among events, where they are shown, and gives the severity of the worst at the last frame.
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

    /// Whether what goes wrong is asked for.
    pub fn diagnoses(&self) -> bool {
        self.incidents.is_some()
    }

    /// Takes what went wrong in the capture, which is over.
    pub fn diagnosis(&mut self, setting: Setting<'_>, diagnosis: &Diagnosis) {
        if let Some(incidents) = &mut self.incidents {
            incidents.diagnosis(&mut self.done, setting, &self.cycle_numbers, diagnosis);
        }
    }

    /// Takes a transfer that has ended.
    pub fn transfer(&mut self, setting: Setting<'_>, transfer: &Transfer) {
        if let Some(transfers) = &mut self.transfers {
            transfers.transfer(&mut self.done, setting, transfer);
        }
        if let Some(objects) = &mut self.objects {
            objects.transfer(&mut self.done, setting, transfer);
        }
        if let Some(od) = &mut self.od {
            od.inventory.transfer(transfer);
        }
        if let Some(lanes) = &mut self.lanes {
            lanes.transfer(&mut self.done, setting, &self.cycle_numbers, transfer);
        }
    }

    /// Takes a finding about the capture.
    pub fn finding(&mut self, setting: Setting<'_>, finding: &Finding) {
        if let Some(lanes) = &mut self.lanes {
            lanes.finding(&mut self.done, finding);
        }
        self.tell(setting, finding);
    }

    fn tell(&mut self, setting: Setting<'_>, finding: &Finding) {
        if let Some(cycles) = &mut self.cycles {
            match finding.code {
                Code::Cap002 => cycles.lost(Some(finding.bus)),
                Code::Cap004 | Code::Cap008 => cycles.lost(None),
                _ => {}
            }
        }
        if let Some(findings) = &mut self.findings {
            findings.finding(&mut self.done, setting, finding);
        }
        if let Some(log) = &mut self.log {
            log.finding(&mut self.done, setting, &self.cycle_numbers, finding, self.last);
        }
    }

    /// Takes what is known of the nodes when the capture is over.
    pub fn settle(&mut self, state: &[Bus]) {
        if let Some(od) = &mut self.od {
            od.inventory.settle(state);
        }
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
        let Self { done, frames, transfers, states, emcy, findings, cycles, signals, pdos, .. } = self;
        // One row a table; each has columns of its own type.
        frames.iter_mut().for_each(|table| table.finish(done));
        transfers.iter_mut().for_each(|table| table.finish(done));
        states.iter_mut().for_each(|table| table.finish(done));
        emcy.iter_mut().for_each(|table| table.finish(done));
        findings.iter_mut().for_each(|table| table.finish(done));
        cycles.iter_mut().for_each(|cycles| cycles.finish(done, setting.buses));
        signals.iter_mut().for_each(|signals| signals.table.finish(done));
        pdos.iter_mut().for_each(|pdos| pdos.flush(done));
        let Self { done, wide, objects, od, listing, lanes, log, load, incidents, .. } = self;
        wide.iter_mut().for_each(|pdos| pdos.flush(done));
        objects.iter_mut().for_each(|objects| objects.table.finish(done));
        od.iter_mut().for_each(|od| od.finish(done, setting));
        listing.iter_mut().for_each(|listing| listing.table.finish(done));
        lanes.iter_mut().for_each(|lanes| lanes.finish(done));
        log.iter_mut().for_each(|log| log.table.finish(done));
        load.iter_mut().for_each(|load| load.finish(done, setting.buses, self.last));
        incidents.iter_mut().for_each(|table| table.finish(done));
    }

    /// Takes the batches that are complete. `flush`: those that run end now.
    pub fn take(&mut self, flush: bool) -> Vec<Batch> {
        if flush {
            let Self { done, frames, transfers, states, emcy, findings, cycles, signals, pdos, .. } = self;
            frames.iter_mut().for_each(|table| table.flush(done));
            transfers.iter_mut().for_each(|table| table.flush(done));
            states.iter_mut().for_each(|table| table.flush(done));
            emcy.iter_mut().for_each(|table| table.flush(done));
            findings.iter_mut().for_each(|table| table.flush(done));
            cycles.iter_mut().for_each(|cycles| cycles.table.flush(done));
            signals.iter_mut().for_each(|signals| signals.table.flush(done));
            pdos.iter_mut().for_each(|pdos| pdos.flush(done));
            // Those of objects of nodes come at the end.
            let Self { done, wide, objects, listing, lanes, log, load, incidents, .. } = self;
            wide.iter_mut().for_each(|pdos| pdos.flush(done));
            objects.iter_mut().for_each(|objects| objects.table.flush(done));
            listing.iter_mut().for_each(|listing| listing.table.flush(done));
            lanes.iter_mut().for_each(|lanes| lanes.flush(done));
            log.iter_mut().for_each(|log| log.table.flush(done));
            load.iter_mut().for_each(|load| load.table.flush(done));
            incidents.iter_mut().for_each(|table| table.flush(done));
        }
        std::mem::take(&mut self.done)
    }
}

#[cfg(test)]
mod tests;

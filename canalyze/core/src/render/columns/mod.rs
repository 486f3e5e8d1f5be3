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
//! | `findings` | a finding | `code name severity file frame? line? t_ns? cause_frame? cause_line? bus? node? index? sub? message facts` |
//! | `sync_cycles` | a SYNC cycle | `cycle frame t_ns? bus? period_ns? counter? pdos delay_min_ns? delay_max_ns?` |
//! | `signals` | a signal of a PDO | `t_ns? frame line? bus? node pdo signal object value? integer? raw? data? unit? text? provenance` |
//! | `pdo` | a PDO; `pdo/can1/5.TPDO1/1` is a table for itself, see `pdo` | `t_ns? frame provenance cycle? delay_ns?`, then its signals |
//!
//! `?`: null where there is none. Times (`..._ns`) are int64 in ns, `t_ns` is JSON's `t`. Identifiers, indices and
//! codes are numbers; `object` is `1008:00`; `id` is that of an error frame its class. Words of which there are few are
//! dictionary-encoded; those for people (`name`, `signal`, `text`, `message`, `abort_text`) are in the session's
//! language. Strings from a capture or a description are as they are there, what is not UTF-8 as U+FFFD: whoever
//! prints them escapes them. Metadata of a schema: `table`, its name; of those of PDOs also `bus node pdo version
//! lang`.
//!
//! Must not: judge, or leave Rust: how columns are handed over is the binding's matter.

mod column;
mod emcy;
mod findings;
mod frames;
mod pdo;
mod signals;
mod states;
mod sync_cycles;
mod transfers;

use self::column::Table;
use self::emcy::Emcy;
use self::findings::Findings;
use self::frames::Frames;
use self::pdo::Pdos;
use self::signals::Listed;
use self::states::States;
use self::sync_cycles::Cycles;
use self::transfers::Transfers;
use super::jsonl::Setting;
use super::selection::Selection;
use crate::event::{Event, What};
use crate::finding::{Code, Finding};
use crate::frame::{Buses, Frame};
use crate::select::Select;
use crate::services::sdo::transfer::Transfer;
use crate::text::Lang;

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
    ];
}

/// A frame as the session sees it, beside what it means.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    /// Its service and the node that it is about, as filters know them.
    pub service: (&'static str, Option<u8>),
    /// The SYNC cycle that runs on its bus now; 0 before the first.
    pub cycle: u64,
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
}

impl Columns {
    /// These tables, without a row. `select`: which signals are in them.
    pub fn new(lang: Lang, select: &Select, tables: &[Name]) -> Self {
        fn table<C: column::Columns + Default>(tables: &[Name], name: Name) -> Option<Table<C>> {
            let (word, _) = Name::NAMES.iter().find(|row| row.1 == name && tables.contains(&name))?;
            Some(Table::new(word, C::default(), &[]))
        }
        let selection = || Selection::new(lang, select.clone());
        Self {
            done: Vec::new(),
            frames: table(tables, Name::Frames),
            transfers: table(tables, Name::Transfers),
            states: table(tables, Name::States),
            emcy: table(tables, Name::Emcy),
            findings: table(tables, Name::Findings),
            cycles: table(tables, Name::SyncCycles).map(Cycles::new),
            signals: table(tables, Name::Signals).map(|table| Listed::new(table, selection(), lang)),
            pdos: tables.contains(&Name::Pdo).then(|| Pdos::new(lang, selection())),
        }
    }

    /// Takes a frame and what follows from it, but for transfers.
    pub fn frame(&mut self, seen: Seen<'_>, frame: &Frame, events: &[Event]) {
        let Seen { service, cycle, shown, setting } = seen;
        if let Some(cycles) = &mut self.cycles {
            cycles.frame(&mut self.done, setting.buses, frame, events, (cycle, shown));
        }
        if !shown {
            return;
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
                }
                What::Pdo(_) | What::Mpdo(_) => {
                    if let Some(signals) = &mut self.signals {
                        signals.event(&mut self.done, setting, frame, event);
                    }
                    if let (Some(pdos), What::Pdo(data)) = (&mut self.pdos, &event.what) {
                        pdos.process_data(&mut self.done, setting, frame, data);
                    }
                }
                What::Finding(one) => self.finding(setting, one),
                What::Sdo(_) | What::Transfer(_) | What::Note(_) => {}
            }
        }
    }

    /// Takes findings that belong to no frame at hand.
    pub fn asides(&mut self, setting: Setting<'_>, events: &[Event]) {
        for event in events {
            if let What::Finding(one) = &event.what {
                self.finding(setting, one);
            }
        }
    }

    /// Takes a transfer that has ended.
    pub fn transfer(&mut self, setting: Setting<'_>, transfer: &Transfer) {
        if let Some(transfers) = &mut self.transfers {
            transfers.transfer(&mut self.done, setting, transfer);
        }
    }

    /// Takes a finding.
    pub fn finding(&mut self, setting: Setting<'_>, finding: &Finding) {
        if let Some(cycles) = &mut self.cycles {
            match finding.code {
                Code::Cap002 => cycles.lost(Some(finding.bus)),
                Code::Cap004 => cycles.lost(None),
                _ => {}
            }
        }
        if let Some(findings) = &mut self.findings {
            findings.finding(&mut self.done, setting, finding);
        }
    }

    /// The capture is over: the last batches, and one without rows of each table that has had none, for its schema.
    pub fn finish(&mut self, buses: &Buses) {
        let Self { done, frames, transfers, states, emcy, findings, cycles, signals, pdos } = self;
        // One row a table; each has columns of its own type.
        frames.iter_mut().for_each(|table| table.finish(done));
        transfers.iter_mut().for_each(|table| table.finish(done));
        states.iter_mut().for_each(|table| table.finish(done));
        emcy.iter_mut().for_each(|table| table.finish(done));
        findings.iter_mut().for_each(|table| table.finish(done));
        cycles.iter_mut().for_each(|cycles| cycles.finish(done, buses));
        signals.iter_mut().for_each(|signals| signals.table.finish(done));
        pdos.iter_mut().for_each(|pdos| pdos.flush(done));
    }

    /// Takes the batches that are complete. `flush`: those that run end now.
    pub fn take(&mut self, flush: bool) -> Vec<Batch> {
        if flush {
            let Self { done, frames, transfers, states, emcy, findings, cycles, signals, pdos } = self;
            frames.iter_mut().for_each(|table| table.flush(done));
            transfers.iter_mut().for_each(|table| table.flush(done));
            states.iter_mut().for_each(|table| table.flush(done));
            emcy.iter_mut().for_each(|table| table.flush(done));
            findings.iter_mut().for_each(|table| table.flush(done));
            cycles.iter_mut().for_each(|cycles| cycles.table.flush(done));
            signals.iter_mut().for_each(|signals| signals.table.flush(done));
            pdos.iter_mut().for_each(|pdos| pdos.flush(done));
        }
        std::mem::take(&mut self.done)
    }
}

#[cfg(test)]
mod tests;

//! What comes out of a session: the format that is chosen, and what of the frames passes the filter to it.
//!
//! The only place that chooses: a new format is a [`Sink`] and an arm here. Must not: keep state of a bus, or put words
//! together.

use super::capture::View;
use super::inventory::{History, Objects, Pdos};
use super::options::{Format, Options};
use super::records::Records;
use super::sink::{Incidents, JsonLines, Nothing, NumberedLines, Passing, Sink, Text};
use super::subject::{self, Seen, said_of, service};
use crate::bytes::frame::{BusId, Frame};
use crate::bytes::info::Info;
use crate::bytes::masks::Masks;
use crate::bytes::readers::Marker;
use crate::bytes::writers::{Losses, Writer};
use crate::rules::finding::Finding;
use crate::stories::incident::IncidentId;
use crate::stories::{Diagnosis, Phase};
use crate::tables::columns::signals::SignalLines as Signals;
use crate::tables::columns::{Batch, Columns};
use crate::views::diff::digest::Digest;
use crate::views::filter::Filter;
use crate::views::inventory::Inventory;
use crate::views::lines::Lines;
use crate::views::monitor::Monitor;
use crate::world::bus::Bus;
use crate::world::event::{Event, What};

/// What of the frames passes the filter, in one format.
#[derive(Debug)]
pub(super) struct Output {
    pub(super) sink: Box<dyn Sink>,
    pub(super) filter: Filter,
    masks: Masks,
    /// Frames or transfers that passed them.
    pub(super) shown: u64,
    /// So many are shown at most.
    count: Option<u64>,
    /// The capture ends with this time in ns, counted from its first frame; and it has ended so.
    until_ns: Option<i64>,
    over: bool,
    /// No frame by now had a stamp that it could have ended by.
    timeless: bool,
    /// Incidents are written, too.
    incidents: bool,
    /// Tables that are built beside.
    tables: Option<Box<Columns>>,
}

impl Output {
    pub(super) fn new(options: &Options) -> Self {
        let (lang, depth, time) = (options.lang, options.depth, options.time);
        let inventory = || Inventory::new(options.filter.clone());
        let signals = |csv| Box::new(Signals::new(lang, csv, options.select.clone()));
        let sink: Box<dyn Sink> = match options.format {
            Format::Text => Box::new(Text(Lines::folding(lang, depth, time).looking(options.look))),
            Format::Lines => Box::new(NumberedLines(Lines::new(lang, depth, time))),
            Format::Jsonl => Box::new(JsonLines { diagnosis: false }),
            Format::Events => Box::new(JsonLines { diagnosis: true }),
            Format::Signals => signals(false),
            Format::SignalsCsv => signals(true),
            Format::Transfers
            | Format::TransfersText
            | Format::TransfersCsv
            | Format::Check
            | Format::Summary
            | Format::Records
            | Format::Observed => Box::new(Records::new(options.format, &options.network)),
            Format::Objects | Format::ObjectsText | Format::ObjectsCsv => {
                Box::new(Objects::new(options.format, lang, inventory()))
            }
            Format::History | Format::HistoryText | Format::HistoryCsv => {
                Box::new(History::new(options.format, lang, options.filter.clone()))
            }
            Format::Pdos => Box::new(Pdos::new(options.filter.clone())),
            Format::Diagnosis => Box::new(Incidents),
            Format::Info => Box::new(Info::default()),
            // What goes wrong is no matter of single frames: behind a filter it is not compared.
            Format::Digest => Box::new(Digest::new(options.filter.is_empty() && options.masks.is_empty())),
            Format::Convert(format) => Box::new(Writer::new(format, &options.writing)),
            Format::Monitor => Box::new(Monitor::new(lang, &options.network)),
            Format::Columns => Box::new(Nothing),
        };
        let (filter, masks) = (options.filter.clone(), options.masks.clone());
        let has_tables = !options.tables.is_empty() && options.format != Format::Info;
        let columns =
            || Columns::new(lang, &options.select, &options.tables, options.network.bit_rate).taking(inventory());
        let tables = has_tables.then(|| Box::new(columns()));
        let Options { count, until_ns, incidents, .. } = *options;
        Self { sink, filter, masks, shown: 0, count, until_ns, over: false, timeless: true, incidents, tables }
    }

    /// As many were shown as are to be, or the time has come with which the capture ends.
    pub(super) fn is_done(&self) -> bool {
        self.over || self.count.is_some_and(|count| self.shown >= count)
    }

    /// Whether the capture ends before a frame of this time; the first one had that.
    pub(super) fn ends_before(&mut self, t_ns: Option<i64>, start_ns: Option<i64>) -> bool {
        self.timeless &= t_ns.is_none();
        let since = || Some(t_ns?.saturating_sub(start_ns?));
        self.over |= self.until_ns.is_some_and(|until_ns| since().is_some_and(|since| since > until_ns));
        self.over
    }

    /// The capture should have ended with a time, and no frame has one.
    pub(super) fn is_timeless(&self) -> bool {
        self.until_ns.is_some() && self.timeless
    }

    /// The capture is over: what is known of the nodes now.
    pub(super) fn settle(&mut self, state: &[Bus]) {
        self.each(|sink| sink.settle(state));
    }

    /// Whether what goes wrong is asked for.
    pub(super) fn diagnoses(&self) -> bool {
        self.writes_incidents() || self.tables.as_ref().is_some_and(|tables| tables.diagnoses())
    }

    fn writes_incidents(&self) -> bool {
        self.incidents || self.sink.diagnoses()
    }

    /// Whether incidents are told of as they begin and end.
    pub(super) fn tells(&self) -> bool {
        self.incidents
    }

    /// What has become of an incident.
    pub(super) fn incident(
        &mut self,
        out: &mut Vec<u8>,
        view: View<'_>,
        diagnosis: &Diagnosis,
        change: (Phase, IncidentId),
    ) {
        self.sink.incident(out, view, diagnosis, change);
    }

    /// What went wrong in the capture, which is over.
    pub(super) fn diagnosis(&mut self, out: &mut Vec<u8>, view: View<'_>, diagnosis: &Diagnosis) {
        if self.writes_incidents() {
            self.sink.diagnosis(out, view, diagnosis);
        }
        if let Some(tables) = &mut self.tables {
            tables.diagnosis(view.jsonl, diagnosis);
        }
    }

    /// Nobody asks what frames mean.
    pub(super) fn is_blind(&self) -> bool {
        self.sink.is_blind() && self.filter.is_plain() && self.tables.is_none()
    }

    /// Whether tables are built.
    pub(super) fn has_tables(&self) -> bool {
        self.tables.is_some()
    }

    /// The batches that are complete; `flush`: those that run end now.
    pub(super) fn take_batches(&mut self, flush: bool) -> Vec<Batch> {
        self.tables.as_mut().map_or_else(Vec::new, |tables| tables.take(flush))
    }

    /// A filter has let nothing through.
    pub(super) fn is_idle(&self) -> bool {
        self.shown == 0 && !(self.filter.is_empty() && self.masks.is_empty())
    }

    /// Frames that the filter asks for and that there are not in a capture of so many, and whether it asks for no others.
    /// Nothing is known of that where reading has ended before the capture.
    pub(super) fn beyond(&self, frames: u64) -> (Vec<(u32, u32)>, bool) {
        if self.is_done() { (Vec::new(), false) } else { self.filter.beyond(frames) }
    }

    /// What the format that is written cannot hold.
    pub(super) fn losses(&self) -> Option<&Losses> {
        self.sink.losses()
    }

    /// What is kept to be compared.
    pub(super) fn take_digest(&mut self) -> Option<Digest> {
        self.sink.take_digest()
    }

    /// Repeats of one finding on one object are counted instead of shown; figures count by themselves.
    pub(super) fn folds(&self) -> bool {
        self.sink.folds()
    }

    /// What is watched.
    pub(super) fn monitor(&self) -> Option<&Monitor> {
        self.sink.monitor()
    }

    /// What describes the file itself takes an item before it is looked at any further.
    pub(super) fn info(&mut self) -> Option<&mut Info> {
        self.sink.info()
    }

    /// It is `now_ns` on the clock of the frames.
    pub(super) fn advance(&mut self, view: View<'_>, now_ns: i64) {
        self.each(|sink| sink.advance(view, now_ns));
    }

    /// A bus is away for a while.
    pub(super) fn gap(&mut self, bus: BusId, away: bool) {
        self.each(|sink| sink.gap(bus, away));
    }

    /// The next file begins, in a format of this name. `first`: of those that are open together.
    pub(super) fn begin(&mut self, file: &[u8], format: &str, first: bool) {
        self.sink.begin(file, format, first);
    }

    /// A frame with what follows from it. What keeps a frame's own event takes it.
    pub(super) fn frame(&mut self, out: &mut Vec<u8>, view: View<'_>, frame: &Frame, events: &mut Vec<Event>) {
        self.transfers(out, view, events);
        if self.sink.takes_frames() {
            let passing = passing((&self.filter, &self.masks), view, frame, events, (0, None));
            self.shown += u64::from(passing.shown);
            self.sink.frame(out, view, passing, events);
        }
    }

    /// The rows of a frame with all that follows from it. `sync`: the SYNC cycle that runs on its bus, and the least
    /// synchronous window there, in ns.
    pub(super) fn rows(&mut self, view: View<'_>, frame: &Frame, events: &mut Vec<Event>, sync: (u64, Option<i64>)) {
        let passing = passing((&self.filter, &self.masks), view, frame, events, sync);
        if let Some(tables) = &mut self.tables {
            Sink::frame(&mut **tables, &mut Vec::new(), view, passing, events);
        }
        self.transfer_rows(view, events);
    }

    /// The rows of what belongs to no frame at hand.
    pub(super) fn aside_rows(&mut self, view: View<'_>, events: &[Event]) {
        if let Some(tables) = &mut self.tables {
            tables.asides(view.jsonl, events);
        }
        self.transfer_rows(view, events);
    }

    /// What belongs to no frame at hand.
    pub(super) fn aside(&mut self, out: &mut Vec<u8>, view: View<'_>, events: &[Event]) {
        self.transfers(out, view, events);
        if self.filter.is_empty() || self.sink.filters_asides() {
            return self.sink.asides(out, view, events, &self.filter);
        }
        let shown = |event: &&Event| {
            self.filter.shows_aside(event, &subject::aside(view.jsonl.lang, event), view.buses, view.clock)
        };
        let events: Vec<Event> = events.iter().filter(shown).cloned().collect();
        self.sink.asides(out, view, &events, &self.filter);
    }

    /// What the capturing program reports of itself.
    pub(super) fn marker(&mut self, out: &mut Vec<u8>, view: View<'_>, marker: &Marker) {
        self.sink.marker(out, view, marker);
    }

    /// A finding about the capture, which belongs to no frame; lines for people have it on standard error only.
    pub(super) fn finding(&mut self, out: &mut Vec<u8>, view: View<'_>, finding: &Finding) {
        if self.filter.takes_finding(finding) {
            self.each(|sink| sink.finding(out, view, finding));
        }
    }

    /// The end of a file that had frames; `unreadable`: its lines or records that cannot be read.
    pub(super) fn end_of_file(&mut self, unreadable: u64) {
        self.sink.end_of_file(unreadable);
    }

    /// Live buses have given all until `now_ns`: what is held back too long is given.
    pub(super) fn until(&mut self, out: &mut Vec<u8>, now_ns: i64) {
        self.sink.until(out, now_ns);
    }

    /// The capture, which has frames, is over.
    pub(super) fn finish(&mut self, out: &mut Vec<u8>, view: View<'_>) {
        self.sink.finish(out, view, self.shown);
    }

    /// The capture, which may have no frame, is over.
    pub(super) fn close(&mut self, view: View<'_>) {
        if let Some(tables) = &mut self.tables {
            tables.finish(view.jsonl);
        }
    }

    /// The format, and the tables beside it.
    fn each(&mut self, mut act: impl FnMut(&mut dyn Sink)) {
        act(&mut *self.sink);
        if let Some(tables) = &mut self.tables {
            act(&mut **tables);
        }
    }

    /// The transfers that end here and pass the filter.
    fn transfers(&mut self, out: &mut Vec<u8>, view: View<'_>, events: &[Event]) {
        for event in events {
            if let What::Transfer(transfer) = &event.what
                && self.filter.shows_transfer(transfer, &said_of(view, transfer), view.buses, view.clock)
            {
                self.shown += u64::from(self.sink.transfer(out, view, transfer));
            }
        }
    }

    /// The rows of the same.
    fn transfer_rows(&mut self, view: View<'_>, events: &[Event]) {
        let Some(tables) = &mut self.tables else { return };
        for event in events {
            if let What::Transfer(transfer) = &event.what
                && self.filter.shows_transfer(transfer, &said_of(view, transfer), view.buses, view.clock)
            {
                tables.transfer(view.jsonl, transfer);
            }
        }
    }
}

/// What is known of a frame, and whether filters let it through. `sync`: see [`Passing`].
fn passing<'a>(
    (filter, masks): (&'a Filter, &Masks),
    view: View<'_>,
    frame: &'a Frame,
    events: &[Event],
    sync: (u64, Option<i64>),
) -> Passing<'a> {
    let seen = Seen { lang: view.jsonl.lang, frame, events, further: None };
    let shown = filter.shows(frame, &seen, view.buses, view.clock) && masks.shows(frame, view.buses);
    Passing { frame, service: service(events), filter, shown, sync }
}

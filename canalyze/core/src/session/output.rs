//! What comes out of a session, in each of its formats: what a frame, an event, a finding is there.
//!
//! The only place that knows one format from another: a new one is a variant here. Must not: keep state of a bus, or
//! put words together.

use super::capture::View;
use super::records::Records;
use super::{Format, Options};
use crate::diff::digest::Digest;
use crate::event::{Event, What};
use crate::filter::Filter;
use crate::finding::Finding;
use crate::finding_context::Held;
use crate::frame::{BusId, Frame};
use crate::info::Info;
use crate::masks::Masks;
use crate::monitor::Monitor;
use crate::readers::Marker;
use crate::render::columns::{Batch, Columns, Seen};
use crate::render::jsonl;
use crate::render::signals::Signals;
use crate::render::text::Lines;
use crate::writers::{Losses, Writer};

/// What of the frames passes the filter, in one format.
#[derive(Debug)]
pub(super) struct Output {
    pub(super) form: Form,
    filter: Filter,
    masks: Masks,
    /// Frames or transfers that passed them.
    pub(super) shown: u64,
    /// So many are shown at most.
    count: Option<u64>,
    /// Tables that are built beside.
    tables: Option<Box<Columns>>,
}

/// The formats, each with what it keeps from line to line.
#[derive(Debug)]
pub(super) enum Form {
    Text(Lines),
    Lines(Lines),
    Jsonl,
    Signals(Signals),
    /// Transfers, findings, figures, or several of them.
    Records(Records),
    Info(Box<Info>),
    Digest(Box<Digest>),
    Convert(Box<Writer>),
    /// Nothing.
    Columns,
    Monitor(Box<Monitor>),
}

impl Output {
    pub(super) fn new(options: &Options) -> Self {
        let signals = |csv| Form::Signals(Signals::new(options.lang, csv, options.select.clone()));
        let lines = || Lines::new(options.lang, options.depth, options.time);
        let form = match options.format {
            Format::Text => Form::Text(Lines::folding(options.lang, options.depth, options.time)),
            Format::Lines => Form::Lines(lines()),
            Format::Jsonl => Form::Jsonl,
            Format::Signals => signals(false),
            Format::SignalsCsv => signals(true),
            Format::Transfers | Format::Check | Format::Summary | Format::Records | Format::Observed => {
                Form::Records(Records::new(options.format, &options.network))
            }
            Format::Info => Form::Info(Box::default()),
            Format::Digest => Form::Digest(Box::default()),
            Format::Convert(format) => Form::Convert(Box::new(Writer::new(format, &options.writing))),
            Format::Monitor => Form::Monitor(Box::new(Monitor::new(options.lang, &options.network))),
            Format::Columns => Form::Columns,
        };
        let (filter, masks) = (options.filter.clone(), options.masks.clone());
        let has_tables = !options.tables.is_empty() && options.format != Format::Info;
        let columns = || Columns::new(options.lang, &options.select, &options.tables, options.network.bit_rate);
        let tables = has_tables.then(|| Box::new(columns()));
        Self { form, filter, masks, shown: 0, count: options.count, tables }
    }

    /// As many were shown as are to be.
    pub(super) fn is_done(&self) -> bool {
        self.count.is_some_and(|count| self.shown >= count)
    }

    /// Nobody asks what frames mean.
    pub(super) fn is_blind(&self) -> bool {
        let plain = self.filter.is_plain() && self.tables.is_none();
        matches!(&self.form, Form::Convert(writer) if plain && !writer.wants_events())
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

    /// What the format that is written cannot hold.
    pub(super) fn losses(&self) -> Option<&Losses> {
        if let Form::Convert(writer) = &self.form { Some(writer.losses()) } else { None }
    }

    /// What is kept to be compared.
    pub(super) fn take_digest(&mut self) -> Option<Digest> {
        if let Form::Digest(digest) = &mut self.form { Some(std::mem::take(digest)) } else { None }
    }

    /// Repeats of one finding on one object are counted instead of shown; figures count by themselves.
    pub(super) fn folds(&self) -> bool {
        match &self.form {
            Form::Records(records) => !records.only_counts(),
            Form::Digest(_) | Form::Monitor(_) => false,
            _ => true,
        }
    }

    /// What is watched.
    pub(super) fn monitor(&self) -> Option<&Monitor> {
        if let Form::Monitor(monitor) = &self.form { Some(monitor) } else { None }
    }

    /// It is `now_ns` on the clock of the frames.
    pub(super) fn advance(&mut self, view: View<'_>, now_ns: i64) {
        if let Form::Monitor(monitor) = &mut self.form {
            monitor.advance(now_ns);
        }
        if let Some(tables) = &mut self.tables {
            tables.advance(view.jsonl, now_ns);
        }
    }

    /// A bus is away for a while.
    pub(super) fn gap(&mut self, bus: BusId) {
        if let Form::Monitor(monitor) = &mut self.form {
            monitor.gap(bus);
        }
        if let Some(tables) = &mut self.tables {
            tables.gap(bus);
        }
    }

    /// What tells of the file itself takes an item before it is looked at any further.
    pub(super) fn info(&mut self) -> Option<&mut Info> {
        if let Form::Info(info) = &mut self.form { Some(info) } else { None }
    }

    /// The next file begins, in a format of this name. `first`: of those that are open together.
    pub(super) fn begin(&mut self, file: &[u8], format: &str, first: bool) {
        match &mut self.form {
            Form::Convert(writer) => writer.source(file, format),
            Form::Info(info) if first => **info = Info::default(),
            _ => {}
        }
    }

    /// A frame with what follows from it, if the filter lets it through. What keeps a frame's own event takes it.
    pub(super) fn frame(&mut self, out: &mut Vec<u8>, view: View<'_>, frame: &Frame, events: &mut Vec<Event>) {
        self.transfers(out, view, events);
        if self.is_transfers_only() {
            return;
        }
        if let Form::Digest(digest) = &mut self.form {
            digest.extend(frame);
        }
        let (service, node) = service(events);
        let shown =
            self.filter.shows(frame, service, node, view.buses, view.clock) && self.masks.shows(frame, view.buses);
        self.shown += u64::from(shown);
        // These look at the others too.
        match &mut self.form {
            Form::Records(records) => return records.frame(out, view, frame, events, shown),
            Form::Monitor(monitor) => return monitor.frame(view.jsonl, service, frame, events, shown),
            _ => {}
        }
        if !shown {
            return;
        }
        match &mut self.form {
            Form::Text(lines) => {
                lines.date_ns = view.writing.date_ns;
                lines.frame(out, frame, events, view.buses);
            }
            Form::Lines(lines) => {
                lines.date_ns = view.writing.date_ns;
                jsonl::line(out, frame.no, |text| lines.frame(text, frame, events, view.buses));
            }
            Form::Jsonl => jsonl::frame(out, view.jsonl, frame, events),
            Form::Signals(signals) => signals.frame(out, view.jsonl, frame, events),
            Form::Digest(digest) => digest.frame(frame, events),
            Form::Convert(writer) => {
                writer.frame(out, view.writing, frame);
                writer.events(out, view.writing, Some(frame), events);
            }
            Form::Records(_) | Form::Info(_) | Form::Columns | Form::Monitor(_) => {}
        }
    }

    /// The rows of a frame with all that follows from it. `sync`: the SYNC cycle that runs on its bus, and the least
    /// synchronous window there, in ns.
    pub(super) fn rows(&mut self, view: View<'_>, frame: &Frame, events: &[Event], sync: (u64, Option<i64>)) {
        let Some(tables) = &mut self.tables else { return };
        let (service, node) = service(events);
        let shown =
            self.filter.shows(frame, service, node, view.buses, view.clock) && self.masks.shows(frame, view.buses);
        let (cycle, window_ns) = sync;
        let seen = Seen { service: (service, node), cycle, window_ns, shown, setting: view.jsonl };
        tables.frame(seen, frame, events);
        self.transfer_rows(view, events);
    }

    /// The rows of what belongs to no frame at hand.
    pub(super) fn aside_rows(&mut self, view: View<'_>, events: &[Event]) {
        let Some(tables) = &mut self.tables else { return };
        tables.asides(view.jsonl, events);
        self.transfer_rows(view, events);
    }

    /// The rows of transfers that end here and pass the filter.
    fn transfer_rows(&mut self, view: View<'_>, events: &[Event]) {
        let Some(tables) = &mut self.tables else { return };
        for event in events {
            if let What::Transfer(transfer) = &event.what
                && self.filter.shows_transfer(transfer, view.buses, view.clock)
            {
                tables.transfer(view.jsonl, transfer);
            }
        }
    }

    /// The rows of a finding about the capture.
    pub(super) fn row(&mut self, view: View<'_>, finding: &Finding) {
        if let Some(tables) = &mut self.tables {
            tables.finding(view.jsonl, finding);
        }
    }

    /// What belongs to no frame at hand.
    pub(super) fn aside(&mut self, out: &mut Vec<u8>, view: View<'_>, events: &[Event]) {
        self.transfers(out, view, events);
        match &mut self.form {
            Form::Text(lines) => lines.end(out, events),
            Form::Jsonl => jsonl::asides(out, view.jsonl, events),
            Form::Digest(digest) => {
                let shown = |event: &&Event| match &event.what {
                    What::Transfer(transfer) => self.filter.shows_transfer(transfer, view.buses, view.clock),
                    _ => self.filter.is_empty(),
                };
                digest.asides(events.iter().filter(shown));
            }
            Form::Convert(writer) => writer.events(out, view.writing, None, events),
            Form::Records(records) => {
                let passes = |held: &Held| {
                    let (service, node) = service(held.event.as_slice());
                    self.filter.shows(&held.frame, service, node, view.buses, view.clock)
                };
                let passes: Option<&dyn Fn(&Held) -> bool> = if self.filter.is_empty() { None } else { Some(&passes) };
                records.asides(out, view, events, passes);
            }
            Form::Monitor(monitor) => monitor.asides(view.jsonl, events),
            Form::Lines(_) | Form::Signals(_) | Form::Info(_) | Form::Columns => {}
        }
    }

    /// What the capturing program says of itself.
    pub(super) fn marker(&mut self, out: &mut Vec<u8>, view: View<'_>, marker: &Marker) {
        match &mut self.form {
            Form::Text(lines) => lines.marker(out, marker, view.buses),
            Form::Records(records) => records.marker(marker),
            Form::Convert(writer) => writer.marker(out, view.writing, marker),
            Form::Monitor(monitor) => monitor.marker(marker),
            Form::Lines(_) | Form::Jsonl | Form::Signals(_) | Form::Info(_) | Form::Columns | Form::Digest(_) => {}
        }
    }

    /// A finding about the capture, which belongs to no frame; lines for people have it on standard error only.
    pub(super) fn finding(&mut self, out: &mut Vec<u8>, view: View<'_>, finding: &Finding) {
        match &mut self.form {
            Form::Jsonl => jsonl::finding(out, view.jsonl, finding),
            Form::Records(records) => records.finding(out, view, finding),
            Form::Convert(writer) => writer.finding(out, view.writing, finding),
            Form::Monitor(monitor) => monitor.finding(view.jsonl, finding),
            Form::Text(_) | Form::Lines(_) | Form::Signals(_) | Form::Info(_) | Form::Digest(_) | Form::Columns => {}
        }
    }

    /// A file is over that had frames, and so many lines or records that cannot be read.
    pub(super) fn end_of_file(&mut self, unreadable: u64) {
        match &mut self.form {
            Form::Records(records) => records.end_of_file(unreadable),
            Form::Monitor(monitor) => monitor.end_of_file(unreadable),
            _ => {}
        }
    }

    /// Live buses have given all until `now_ns`: what is held back too long is given.
    pub(super) fn until(&mut self, out: &mut Vec<u8>, now_ns: i64) {
        if let Form::Convert(writer) = &mut self.form {
            writer.until(out, now_ns);
        }
    }

    /// The capture, which has frames, is over.
    pub(super) fn finish(&mut self, out: &mut Vec<u8>, view: View<'_>) {
        match &mut self.form {
            Form::Records(records) if self.shown > 0 => records.finish(out, view),
            Form::Convert(writer) => writer.finish(out, view.writing),
            Form::Digest(digest) => digest.finish(view.buses),
            Form::Text(lines) => lines.finish(out),
            _ => {}
        }
    }

    /// The capture, which may have no frame, is over.
    pub(super) fn close(&mut self, view: View<'_>) {
        if let Some(tables) = &mut self.tables {
            tables.finish(view.jsonl);
        }
    }

    fn is_transfers_only(&self) -> bool {
        matches!(&self.form, Form::Records(records) if records.is_transfers_only())
    }

    /// The transfers that end here, where they are told by themselves and pass the filter.
    fn transfers(&mut self, out: &mut Vec<u8>, view: View<'_>, events: &[Event]) {
        if !matches!(&self.form, Form::Records(records) if records.transfers) {
            return;
        }
        for event in events {
            if let What::Transfer(transfer) = &event.what
                && self.filter.shows_transfer(transfer, view.buses, view.clock)
            {
                self.shown += 1;
                jsonl::transfer(out, view.jsonl, transfer);
            }
        }
    }
}

/// The service that a frame belongs to and the node that it is about, by the first of its events.
fn service(events: &[Event]) -> (&'static str, Option<u8>) {
    events.first().map_or(("foreign", None), |event| match &event.what {
        What::Message(message) => (message.service(), event.node),
        What::Pdo(_) | What::Mpdo(_) => ("pdo", event.node),
        _ => ("sdo", event.node),
    })
}

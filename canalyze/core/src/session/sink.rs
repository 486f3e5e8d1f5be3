//! Where a session writes: the interface of every format, and of the tables beside them.
//!
//! A format implements what concerns it; the other methods do nothing. It must not filter frames: which are shown is
//! given.

use std::fmt::Debug;

use super::capture::View;
use super::subject::said_of;
use crate::bytes::frame::{BusId, Frame};
use crate::bytes::info::Info;
use crate::bytes::readers::{Item, Marker};
use crate::bytes::writers::{Losses, Writer};
use crate::rules::finding::Finding;
use crate::sdo::transfer::Transfer;
use crate::stories::incident::IncidentId;
use crate::stories::{Diagnosis, Phase};
use crate::tables::columns::signals::SignalLines as Signals;
use crate::tables::columns::{Columns, Seen};
use crate::tables::jsonl;
use crate::views::diff::digest::Digest;
use crate::views::filter::Filter;
use crate::views::lines::Lines;
use crate::views::monitor::Monitor;
use crate::words::incidents;
use crate::world::bus::Bus;
use crate::world::event::{Event, What};

/// A frame, and what is known of it beside what it means.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passing<'a> {
    pub(super) frame: &'a Frame,
    /// Its service and the node that it is about, as filters know them.
    pub(super) service: (&'static str, Option<u8>),
    /// The filter, and whether it lets the frame through.
    pub(super) filter: &'a Filter,
    pub(super) shown: bool,
    /// The SYNC cycle that runs on its bus, 0 before the first, and the least synchronous window there, in ns.
    pub(super) sync: (u64, Option<i64>),
}

/// A format, with what it keeps from frame to frame.
pub(super) trait Sink: Debug + Send + Sync {
    /// The next file begins, in a format of this name. `first`: of those that are open together.
    fn begin(&mut self, _file: &[u8], _format: &str, _first: bool) {}

    /// A frame with what follows from it. What keeps a frame's own event takes it out.
    fn frame(&mut self, _out: &mut Vec<u8>, _view: View<'_>, _passing: Passing<'_>, _events: &mut Vec<Event>) {}

    /// An SDO transfer that has ended and passes the filter, before the frame that ended it. Whether it is shown by
    /// itself.
    fn transfer(&mut self, _out: &mut Vec<u8>, _view: View<'_>, _transfer: &Transfer) -> bool {
        false
    }

    /// What belongs to no frame at hand.
    fn asides(&mut self, _out: &mut Vec<u8>, _view: View<'_>, _events: &[Event], _filter: &Filter) {}

    /// Whether it chooses by the filter what it takes of [`Self::asides`].
    fn filters_asides(&self) -> bool {
        false
    }

    /// A finding about the capture, which belongs to no frame.
    fn finding(&mut self, _out: &mut Vec<u8>, _view: View<'_>, _finding: &Finding) {}

    /// What the capturing program reports of itself.
    fn marker(&mut self, _out: &mut Vec<u8>, _view: View<'_>, _marker: &Marker) {}

    /// A bus is away for a while.
    fn gap(&mut self, _bus: BusId, _away: bool) {}

    /// It is `now_ns` on the clock of the frames.
    fn advance(&mut self, _view: View<'_>, _now_ns: i64) {}

    /// Live buses have given all until `now_ns`.
    fn until(&mut self, _out: &mut Vec<u8>, _now_ns: i64) {}

    /// The end of a file that had frames; `unreadable`: its lines or records that cannot be read.
    fn end_of_file(&mut self, _unreadable: u64) {}

    /// What is known of the nodes when the capture is over, before [`Self::finish`].
    fn settle(&mut self, _state: &[Bus]) {}

    /// The end of the capture; `shown`: the frames or transfers of it that were shown.
    fn finish(&mut self, _out: &mut Vec<u8>, _view: View<'_>, _shown: u64) {}

    /// Whether it wants to know what went wrong.
    fn diagnoses(&self) -> bool {
        false
    }

    /// What has become of an incident.
    fn incident(&mut self, _out: &mut Vec<u8>, _view: View<'_>, _diagnosis: &Diagnosis, _change: (Phase, IncidentId)) {}

    /// What went wrong in the capture, which is over.
    fn diagnosis(&mut self, _out: &mut Vec<u8>, _view: View<'_>, _diagnosis: &Diagnosis) {}

    /// Whether it takes frames, and not only what ends with them.
    fn takes_frames(&self) -> bool {
        true
    }

    /// Whether it may be called later, by another thread: of frames, of what belongs to none, of findings about the
    /// capture and of markers it needs no more than it is given, but for SYNC cycles, and frames that are not shown do
    /// not concern it.
    fn defers(&self) -> bool {
        false
    }

    /// The items that were read together, in which frames are that it was called with, have been understood: it may
    /// take them.
    fn understood(&mut self, _items: &mut Vec<Item>) {}

    /// Another one that writes the same as it does, where nothing depends on what was written before.
    fn another(&self) -> Option<Box<dyn Sink>> {
        None
    }

    /// Whether nobody asks what frames mean.
    fn is_blind(&self) -> bool {
        false
    }

    /// Whether repeats of one finding on one object are counted instead of shown.
    fn folds(&self) -> bool {
        true
    }

    /// What the format that is written cannot hold.
    fn losses(&self) -> Option<&Losses> {
        None
    }

    /// What is kept to be compared.
    fn take_digest(&mut self) -> Option<Digest> {
        None
    }

    /// What is watched.
    fn monitor(&self) -> Option<&Monitor> {
        None
    }

    /// What describes the file itself takes its items before they are looked at any further.
    fn info(&mut self) -> Option<&mut Info> {
        None
    }
}

/// Nothing but the tables beside it is written.
#[derive(Debug)]
pub(super) struct Nothing;

impl Sink for Nothing {}

/// What went wrong.
#[derive(Debug)]
pub(super) struct Incidents;

impl Sink for Incidents {
    fn takes_frames(&self) -> bool {
        false
    }

    fn diagnoses(&self) -> bool {
        true
    }

    fn diagnosis(&mut self, out: &mut Vec<u8>, view: View<'_>, diagnosis: &Diagnosis) {
        jsonl::diagnosis::write(out, view.jsonl, diagnosis);
    }
}

/// Annotated lines.
#[derive(Debug)]
pub(super) struct Text(pub(super) Lines);

impl Sink for Text {
    fn frame(&mut self, out: &mut Vec<u8>, view: View<'_>, passing: Passing<'_>, events: &mut Vec<Event>) {
        if passing.shown {
            self.0.clock = view.jsonl.clock;
            self.0.frame(out, passing.frame, events, view.buses);
        }
    }

    fn asides(&mut self, out: &mut Vec<u8>, _view: View<'_>, events: &[Event], _filter: &Filter) {
        self.0.end(out, events);
    }

    fn marker(&mut self, out: &mut Vec<u8>, view: View<'_>, marker: &Marker) {
        self.0.marker(out, marker, view.buses);
    }

    fn defers(&self) -> bool {
        true
    }

    fn incident(&mut self, out: &mut Vec<u8>, view: View<'_>, diagnosis: &Diagnosis, change: (Phase, IncidentId)) {
        self.0.emphasized(out, |out| incidents::changed(out, view.jsonl.lang, diagnosis, change));
    }

    fn finish(&mut self, out: &mut Vec<u8>, _view: View<'_>, _shown: u64) {
        self.0.finish(out);
    }
}

/// The annotated lines of frames as JSON lines, each with the number of its frame.
#[derive(Debug)]
pub(super) struct NumberedLines(pub(super) Lines);

impl Sink for NumberedLines {
    fn frame(&mut self, out: &mut Vec<u8>, view: View<'_>, passing: Passing<'_>, events: &mut Vec<Event>) {
        if passing.shown {
            self.0.clock = view.jsonl.clock;
            jsonl::line(out, passing.frame.no, |text| self.0.frame(text, passing.frame, events, view.buses));
        }
    }

    fn defers(&self) -> bool {
        true
    }
}

/// A JSON line for each frame.
#[derive(Debug)]
pub(super) struct JsonLines {
    /// What is known at the end is written with what is for people.
    pub(super) diagnosis: bool,
}

impl Sink for JsonLines {
    fn frame(&mut self, out: &mut Vec<u8>, view: View<'_>, passing: Passing<'_>, events: &mut Vec<Event>) {
        if passing.shown {
            jsonl::frame(out, view.jsonl, passing.frame, events);
        }
    }

    fn defers(&self) -> bool {
        true
    }

    fn another(&self) -> Option<Box<dyn Sink>> {
        Some(Box::new(Self { diagnosis: self.diagnosis }))
    }

    fn asides(&mut self, out: &mut Vec<u8>, view: View<'_>, events: &[Event], _filter: &Filter) {
        jsonl::asides(out, view.jsonl, events);
    }

    fn finding(&mut self, out: &mut Vec<u8>, view: View<'_>, finding: &Finding) {
        jsonl::finding(out, view.jsonl, finding);
    }

    fn incident(&mut self, out: &mut Vec<u8>, view: View<'_>, diagnosis: &Diagnosis, change: (Phase, IncidentId)) {
        jsonl::diagnosis::changed(out, view.jsonl, diagnosis, change);
    }

    fn diagnosis(&mut self, out: &mut Vec<u8>, view: View<'_>, diagnosis: &Diagnosis) {
        let write = if self.diagnosis { jsonl::diagnosis::write } else { jsonl::diagnosis::ends };
        write(out, view.jsonl, diagnosis);
    }
}

impl Sink for Signals {
    fn frame(&mut self, out: &mut Vec<u8>, view: View<'_>, passing: Passing<'_>, events: &mut Vec<Event>) {
        if passing.shown {
            Signals::frame(self, out, view.jsonl, passing.frame, events);
        }
    }

    fn defers(&self) -> bool {
        true
    }
}

impl Sink for Info {
    fn begin(&mut self, _file: &[u8], _format: &str, first: bool) {
        if first {
            *self = Self::default();
        }
    }

    fn info(&mut self) -> Option<&mut Info> {
        Some(self)
    }
}

impl Sink for Digest {
    fn frame(&mut self, _out: &mut Vec<u8>, _view: View<'_>, passing: Passing<'_>, events: &mut Vec<Event>) {
        self.extend(passing.frame);
        if passing.shown {
            Digest::frame(self, passing.frame, events);
        }
    }

    fn asides(&mut self, _out: &mut Vec<u8>, view: View<'_>, events: &[Event], filter: &Filter) {
        let shown = |event: &&Event| match &event.what {
            What::Transfer(transfer) => {
                filter.shows_transfer(transfer, &said_of(view, transfer), view.buses, view.clock)
            }
            _ => filter.is_empty(),
        };
        Digest::asides(self, events.iter().filter(shown));
    }

    fn filters_asides(&self) -> bool {
        true
    }

    fn finish(&mut self, _out: &mut Vec<u8>, view: View<'_>, _shown: u64) {
        Digest::finish(self, view.buses);
    }

    fn diagnoses(&self) -> bool {
        Digest::diagnoses(self)
    }

    fn diagnosis(&mut self, _out: &mut Vec<u8>, _view: View<'_>, diagnosis: &Diagnosis) {
        Digest::diagnosis(self, diagnosis);
    }

    fn folds(&self) -> bool {
        false
    }

    fn take_digest(&mut self) -> Option<Digest> {
        Some(std::mem::take(self))
    }
}

impl Sink for Writer {
    fn begin(&mut self, file: &[u8], format: &str, _first: bool) {
        self.source(file, format);
    }

    fn frame(&mut self, out: &mut Vec<u8>, view: View<'_>, passing: Passing<'_>, events: &mut Vec<Event>) {
        if passing.shown {
            Writer::frame(self, out, view.writing, passing.frame);
            self.events(out, view.writing, Some(passing.frame), events);
        }
    }

    fn asides(&mut self, out: &mut Vec<u8>, view: View<'_>, events: &[Event], _filter: &Filter) {
        self.events(out, view.writing, None, events);
    }

    fn finding(&mut self, out: &mut Vec<u8>, view: View<'_>, finding: &Finding) {
        Writer::finding(self, out, view.writing, finding);
    }

    fn marker(&mut self, out: &mut Vec<u8>, view: View<'_>, marker: &Marker) {
        Writer::marker(self, out, view.writing, marker);
    }

    fn until(&mut self, out: &mut Vec<u8>, now_ns: i64) {
        Writer::until(self, out, now_ns);
    }

    fn finish(&mut self, out: &mut Vec<u8>, view: View<'_>, _shown: u64) {
        Writer::finish(self, out, view.writing);
    }

    fn defers(&self) -> bool {
        true
    }

    fn is_blind(&self) -> bool {
        !self.wants_events()
    }

    fn losses(&self) -> Option<&Losses> {
        Some(Writer::losses(self))
    }
}

impl Sink for Monitor {
    fn frame(&mut self, _out: &mut Vec<u8>, view: View<'_>, passing: Passing<'_>, events: &mut Vec<Event>) {
        Monitor::frame(self, view.jsonl, passing.service.0, passing.frame, events, passing.shown);
    }

    fn asides(&mut self, _out: &mut Vec<u8>, view: View<'_>, events: &[Event], _filter: &Filter) {
        Monitor::asides(self, view.jsonl, events);
    }

    fn finding(&mut self, _out: &mut Vec<u8>, view: View<'_>, finding: &Finding) {
        Monitor::finding(self, view.jsonl, finding);
    }

    fn marker(&mut self, _out: &mut Vec<u8>, _view: View<'_>, marker: &Marker) {
        Monitor::marker(self, marker);
    }

    fn gap(&mut self, bus: BusId, away: bool) {
        Monitor::gap(self, bus, away);
    }

    fn advance(&mut self, _view: View<'_>, now_ns: i64) {
        Monitor::advance(self, now_ns);
    }

    fn end_of_file(&mut self, unreadable: u64) {
        Monitor::end_of_file(self, unreadable);
    }

    fn diagnoses(&self) -> bool {
        true
    }

    fn folds(&self) -> bool {
        false
    }

    fn monitor(&self) -> Option<&Monitor> {
        Some(self)
    }
}

impl Sink for Columns {
    fn frame(&mut self, _out: &mut Vec<u8>, view: View<'_>, passing: Passing<'_>, events: &mut Vec<Event>) {
        let Passing { frame, service, shown, sync: (cycle, window_ns), .. } = passing;
        Columns::frame(self, Seen { service, cycle, window_ns, shown, setting: view.jsonl }, frame, events);
    }

    fn transfer(&mut self, _out: &mut Vec<u8>, view: View<'_>, transfer: &Transfer) -> bool {
        Columns::transfer(self, view.jsonl, transfer);
        true
    }

    fn asides(&mut self, _out: &mut Vec<u8>, view: View<'_>, events: &[Event], _filter: &Filter) {
        Columns::asides(self, view.jsonl, events);
    }

    fn finding(&mut self, _out: &mut Vec<u8>, view: View<'_>, finding: &Finding) {
        Columns::finding(self, view.jsonl, finding);
    }

    fn gap(&mut self, bus: BusId, _away: bool) {
        Columns::gap(self, bus);
    }

    fn advance(&mut self, view: View<'_>, now_ns: i64) {
        Columns::advance(self, view.jsonl, now_ns);
    }

    fn settle(&mut self, state: &[Bus]) {
        Columns::settle(self, state);
    }

    fn finish(&mut self, _out: &mut Vec<u8>, view: View<'_>, _shown: u64) {
        Columns::finish(self, view.jsonl);
    }
}

//! The outputs of a session, and the part of the capture that passes the filters to them.
//!
//! [`sink`] is the table of all outputs: the needs of each, and its construction.

use std::any::Any;
use std::sync::Arc;

use super::capture::View;
use super::inventory::{HistoryRows, ObjectRows, PdoRows};
use super::options::{Encoding, Options, Output, Rows, Scope};
use super::rows::{
    Changes, Endings, FindingRows, FrameRows, LineRows, ObservedRows, Problems, SummaryRows, Text, TransferRows,
};
use super::sink::{
    BESIDE, BLIND, CHANGES, DIAGNOSIS, Digested, FOLDED, FRAMES, ITEMS, LATER, Notice, Passing, REPEATS, Sink,
    TRANSFERS, UNFILTERED, Wants,
};
use super::subject::{self, Seen, said_of, service};
use crate::bytes::frame::Frame;
use crate::bytes::info::Info;
use crate::bytes::ns::Ns;
use crate::bytes::writers::Writer;
use crate::rules::finding::Finding;
use crate::tables::columns::Columns;
use crate::tables::columns::signals::SignalLines as Signals;
use crate::views::diff::digest::Digest;
use crate::views::inventory::Inventory;
use crate::views::lines::Lines;
use crate::views::monitor::Monitor;
use crate::world::event::{Event, What};

/// The outputs, and the part of the capture that passes to them.
#[derive(Debug)]
pub(super) struct Sinks {
    /// Those beside the others come first.
    list: Vec<(Wants, Box<dyn Sink>)>,
    /// The needs of all but those beside, and of all.
    wants: Wants,
    all: Wants,
    scope: Scope,
    /// Frames or transfers that have passed the filters.
    pub(super) shown: u64,
    /// True once a frame is later than [`Scope::until_ns`].
    over: bool,
    /// True until a frame has a time.
    timeless: bool,
}

/// Returns an output and its needs; `None` for a table of columns, since all of them are one sink.
fn sink(output: Output, options: &Options) -> Option<(Wants, Box<dyn Sink>)> {
    let Options { lang, ref known, shown: Scope { ref filter, ref masks, ref select, .. }, ref writing, .. } = *options;
    let lines = || Lines::new(lang, writing.depth, writing.time);
    let inventory = || Inventory::new(filter.clone());
    let Output::Rows(rows, encoding) = output else {
        return Some(match output {
            Output::Lines => {
                let lines = Lines::folding(lang, writing.depth, writing.time).looking(writing.look);
                (FRAMES | LATER, Box::new(Text(lines)))
            }
            Output::LinesOfChanges => (CHANGES, Box::new(Changes { lines: Some(lines().looking(writing.look)) })),
            Output::Convert => {
                let writer = Writer::new(writing.to, &writing.settings);
                (FRAMES | LATER | if writer.wants_events() { 0 } else { BLIND }, Box::new(writer))
            }
            Output::Digest => {
                // Problems are no matter of single frames, so they are not compared behind a filter.
                let diagnosis = if filter.is_empty() && masks.is_empty() { DIAGNOSIS } else { 0 };
                let digested = Digested { digest: Digest::new(diagnosis != 0), filter: filter.clone() };
                (FRAMES | UNFILTERED | REPEATS | diagnosis, Box::new(digested))
            }
            Output::Monitor => (FRAMES | REPEATS | DIAGNOSIS, Box::new(Monitor::new(lang, &known.network))),
            Output::Columns(_) | Output::Rows(..) => return None,
        });
    };
    let csv = encoding == Encoding::Csv;
    Some(match rows {
        Rows::Frames => (FRAMES | LATER, Box::<FrameRows>::default()),
        Rows::Lines => (FRAMES | LATER, Box::new(LineRows(lines()))),
        Rows::Transfers => (TRANSFERS, Box::new(TransferRows::new(encoding, lang))),
        Rows::Findings => (FRAMES | UNFILTERED | FOLDED, Box::new(FindingRows::new(filter.clone()))),
        Rows::Signals => (FRAMES | LATER, Box::new(Signals::new(lang, csv, select.clone()))),
        Rows::Objects => (FRAMES | TRANSFERS, Box::new(ObjectRows::new(encoding, lang, inventory()))),
        Rows::History => (FRAMES | TRANSFERS, Box::new(HistoryRows::new(encoding, lang, filter.clone()))),
        Rows::Pdos => (FRAMES, Box::new(PdoRows::new(filter.clone()))),
        Rows::Summary => (FRAMES | UNFILTERED | REPEATS, Box::new(SummaryRows::new(Arc::clone(&known.network)))),
        Rows::Observed => (FRAMES, Box::new(ObservedRows::default())),
        Rows::Problems => (DIAGNOSIS, Box::new(Problems)),
        Rows::NumberedProblems => (DIAGNOSIS | CHANGES, Box::new(Problems)),
        Rows::Changes => (CHANGES, Box::new(Changes { lines: None })),
        Rows::Endings => (DIAGNOSIS, Box::new(Endings)),
        Rows::Files => (ITEMS, Box::new(Info::default())),
    })
}

impl Sinks {
    pub(super) fn new(options: &Options) -> Self {
        let Options { lang, known, shown: scope, writing: super::Writing { outputs, .. }, .. } = options;
        let mut list: Vec<_> = outputs.iter().filter_map(|output| sink(*output, options)).collect();
        let of = |list: &[(Wants, _)]| list.iter().fold(0, |all, (wants, _)| all | wants);
        // Without a sink frames count all the same.
        let wants = if list.is_empty() { FRAMES } else { of(&list) };
        let name = |output: &Output| if let Output::Columns(name) = output { Some(*name) } else { None };
        let names: Vec<_> = outputs.iter().filter_map(name).collect();
        if !names.is_empty() {
            let columns = Columns::new(*lang, &scope.select, &names, known.network.bit_rate)
                .taking(Inventory::new(scope.filter.clone()));
            let diagnosis = if columns.diagnoses() { DIAGNOSIS } else { 0 };
            list.insert(0, (BESIDE | diagnosis, Box::new(columns)));
        }
        let all = of(&list);
        Self { list, wants, all, scope: scope.clone(), shown: 0, over: false, timeless: true }
    }

    /// Returns true if any sink wants this.
    pub(super) fn want(&self, wants: Wants) -> bool {
        self.all & wants != 0
    }

    /// Returns true if a sink takes events before repeats are folded.
    pub(super) fn has_beside(&self) -> bool {
        self.all & BESIDE != 0
    }

    /// Returns true if nobody asks for the meaning of frames.
    pub(super) fn is_blind(&self) -> bool {
        !self.list.is_empty() && self.list.iter().all(|(wants, _)| wants & BLIND != 0) && self.scope.filter.is_plain()
    }

    /// Returns true if repeats of one finding on one object are counted instead of shown.
    pub(super) fn folds(&self) -> bool {
        self.wants & FOLDED != 0 || self.wants & REPEATS == 0
    }

    /// Returns true if the only sink that is not beside the others may be called later, by another thread.
    pub(super) fn defers(&self) -> bool {
        let mut sinks = self.list.iter().filter(|(wants, _)| wants & BESIDE == 0);
        sinks.next().is_some_and(|(wants, _)| wants & LATER != 0) && sinks.next().is_none()
    }

    /// Takes the last sink out, and puts another in its place.
    pub(super) fn replace(&mut self, by: Box<dyn Sink>) -> Option<Box<dyn Sink>> {
        self.list.last_mut().map(|last| std::mem::replace(&mut last.1, by))
    }

    /// Returns the sink of this type.
    pub(super) fn find<T: Sink>(&self) -> Option<&T> {
        self.list.iter().find_map(|(_, sink)| (&**sink as &dyn Any).downcast_ref())
    }

    /// Returns the sink of this type.
    pub(super) fn find_mut<T: Sink>(&mut self) -> Option<&mut T> {
        self.list.iter_mut().find_map(|(_, sink)| (&mut **sink as &mut dyn Any).downcast_mut())
    }

    /// Returns true if the limit is reached or the capture has ended by its time.
    pub(super) fn is_done(&self) -> bool {
        self.over || self.has_enough()
    }

    /// Returns true if the limit is reached.
    pub(super) fn has_enough(&self) -> bool {
        self.scope.limit.is_some_and(|limit| self.shown >= limit)
    }

    /// Returns true if the capture, which began at `start_ns`, ends before a frame of this time.
    pub(super) fn ends_before(&mut self, t_ns: Option<Ns>, start_ns: Option<Ns>) -> bool {
        self.timeless &= t_ns.is_none();
        let since = || Some(t_ns? - start_ns?);
        self.over |= self.scope.until_ns.is_some_and(|until_ns| since().is_some_and(|since| since > until_ns));
        self.over
    }

    /// Returns true if the capture should have ended by its time, and no frame has one.
    pub(super) fn is_timeless(&self) -> bool {
        self.scope.until_ns.is_some() && self.timeless
    }

    /// Returns true if a filter has let nothing pass.
    pub(super) fn is_idle(&self) -> bool {
        self.shown == 0 && !(self.scope.filter.is_empty() && self.scope.masks.is_empty())
    }

    /// Returns the frames that the filter asks for beyond this number of frames, and true if it asks for no others.
    /// Empty if reading has ended before the capture.
    pub(super) fn beyond(&self, frames: u64) -> (Vec<(u32, u32)>, bool) {
        if self.is_done() { (Vec::new(), false) } else { self.scope.filter.beyond(frames) }
    }

    /// Gives a frame with its events to the sinks that are not beside the others.
    pub(super) fn frame(&mut self, out: &mut Vec<u8>, view: &View<'_>, frame: &Frame, events: &mut Vec<Event>) {
        self.transfers(out, view, events, 0);
        if self.wants & FRAMES != 0 {
            let passing = self.passing(view, frame, events, (0, None));
            self.shown += u64::from(passing.shown);
            self.group(0).for_each(|sink| sink.frame(out, view, &passing, events));
        }
    }

    /// Gives events that belong to no frame at hand to the sinks that are not beside the others.
    pub(super) fn asides(&mut self, out: &mut Vec<u8>, view: &View<'_>, events: &[Event]) {
        self.transfers(out, view, events, 0);
        let filter = &self.scope.filter;
        let shown =
            |event: &&Event| filter.shows_aside(event, &subject::aside(view.jsonl.lang, event), view.buses, view.clock);
        let filtered: Option<Vec<Event>> = (!filter.is_empty()
            && self.list.iter().any(|(wants, _)| wants & UNFILTERED == 0))
        .then(|| events.iter().filter(shown).cloned().collect());
        for (wants, sink) in self.list.iter_mut().filter(|(wants, _)| wants & BESIDE == 0) {
            let events = filtered.as_deref().filter(|_| *wants & UNFILTERED == 0).unwrap_or(events);
            sink.take(out, view, Notice::Asides(events));
        }
    }

    /// Gives a frame with all its events to the sinks beside the others. `sync`: see [`Passing`].
    pub(super) fn frame_beside(
        &mut self,
        view: &View<'_>,
        frame: &Frame,
        events: &mut Vec<Event>,
        sync: (u64, Option<Ns>),
    ) {
        let (passing, mut out) = (self.passing(view, frame, events, sync), Vec::new());
        self.group(BESIDE).for_each(|sink| sink.frame(&mut out, view, &passing, events));
        self.transfers(&mut out, view, events, BESIDE);
    }

    /// Gives events that belong to no frame at hand to the sinks beside the others.
    pub(super) fn asides_beside(&mut self, view: &View<'_>, events: &[Event]) {
        let mut out = Vec::new();
        self.group(BESIDE).for_each(|sink| sink.take(&mut out, view, Notice::Asides(events)));
        self.transfers(&mut out, view, events, BESIDE);
    }

    /// Gives a notice to all sinks.
    pub(super) fn take(&mut self, out: &mut Vec<u8>, view: &View<'_>, notice: Notice<'_>) {
        self.list.iter_mut().for_each(|(_, sink)| sink.take(out, view, notice));
    }

    /// Gives a finding about the capture to all sinks, if it passes the filter.
    pub(super) fn finding(&mut self, out: &mut Vec<u8>, view: &View<'_>, finding: &Finding) {
        if self.scope.filter.takes_finding(finding) {
            self.take(out, view, Notice::Finding(finding));
        }
    }

    /// Returns the sinks beside the others ([`BESIDE`]), or the others (0).
    fn group(&mut self, beside: Wants) -> impl Iterator<Item = &mut dyn Sink> {
        self.list.iter_mut().filter(move |(wants, _)| wants & BESIDE == beside).map(|(_, sink)| &mut **sink)
    }

    /// Gives the transfers that end here and pass the filter to the sinks of a group that want them.
    #[inline]
    fn transfers(&mut self, out: &mut Vec<u8>, view: &View<'_>, events: &[Event], beside: Wants) {
        if beside != 0 || self.wants & TRANSFERS != 0 {
            self.wanted_transfers(out, view, events, beside);
        }
    }

    fn wanted_transfers(&mut self, out: &mut Vec<u8>, view: &View<'_>, events: &[Event], beside: Wants) {
        for event in events {
            if let What::Transfer(transfer) = &event.what
                && self.scope.filter.shows_transfer(transfer, &said_of(view, transfer), view.buses, view.clock)
            {
                self.shown += u64::from(beside == 0);
                self.group(beside).for_each(|sink| sink.take(out, view, Notice::Transfer(transfer)));
            }
        }
    }

    /// Returns a frame with the result of the filters.
    #[inline]
    fn passing<'a>(&self, view: &View<'_>, frame: &'a Frame, events: &[Event], sync: (u64, Option<Ns>)) -> Passing<'a> {
        let Scope { filter, masks, .. } = &self.scope;
        let seen = || Seen { lang: view.jsonl.lang, frame, events, further: None };
        let shown = (filter.is_empty() || filter.shows(frame, &seen(), view.buses, view.clock))
            && masks.shows(frame, view.buses);
        Passing { frame, service: service(events), shown, sync }
    }
}

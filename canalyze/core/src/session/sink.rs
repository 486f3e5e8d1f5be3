//! The interface of all outputs, and its implementation for those that live elsewhere.
//!
//! A sink is given frames and notices. Filters were applied before; [`Passing::shown`] has the result.

use std::any::Any;
use std::fmt::Debug;

use super::capture::View;
use super::subject::said_of;
use crate::bytes::frame::{BusId, Frame};
use crate::bytes::info::Info;
use crate::bytes::ns::Ns;
use crate::bytes::readers::Marker;
use crate::bytes::writers::Writer;
use crate::problems::problem::ProblemId;
use crate::problems::{Diagnosis, Phase};
use crate::rules::finding::Finding;
use crate::sdo::transfer::Transfer;
use crate::tables::columns::signals::SignalLines as Signals;
use crate::tables::columns::{Columns, Seen};
use crate::views::diff::digest::Digest;
use crate::views::filter::Filter;
use crate::views::monitor::Monitor;
use crate::world::bus::Bus;
use crate::world::event::{Event, What};

/// A set of the constants below: the needs of a sink, declared once beside its construction.
pub(super) type Wants = u16;

/// Frames, which count as shown.
pub(super) const FRAMES: Wants = 1;
/// SDO transfers that pass the filter, which count as shown.
pub(super) const TRANSFERS: Wants = 1 << 1;
/// Events without a frame before the filter is applied.
pub(super) const UNFILTERED: Wants = 1 << 2;
/// Each repeat of a finding.
pub(super) const REPEATS: Wants = 1 << 3;
/// Repeats of a finding counted, whatever other sinks want.
pub(super) const FOLDED: Wants = 1 << 4;
/// The diagnosis at the end.
pub(super) const DIAGNOSIS: Wants = 1 << 5;
/// Problems as they change.
pub(super) const CHANGES: Wants = 1 << 6;
/// Frames only, without their meaning.
pub(super) const BLIND: Wants = 1 << 7;
/// Items of the file before they are numbered or decoded.
pub(super) const ITEMS: Wants = 1 << 8;
/// Calls by another thread, later: only shown frames, asides, findings and markers matter, no SYNC cycles, and no statusword
/// that shows the state already known.
pub(super) const LATER: Wants = 1 << 9;
/// Everything before repeats are folded, and nothing that it takes counts as shown.
pub(super) const BESIDE: Wants = 1 << 10;

/// A frame, and what is known of it beside its events.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passing<'a> {
    pub(super) frame: &'a Frame,
    /// Its service and its node, as filters know them.
    pub(super) service: (&'static str, Option<u8>),
    /// True if it passes the filters.
    pub(super) shown: bool,
    /// The current SYNC cycle of its bus, 0 before the first, and the shortest synchronous window there, in ns.
    pub(super) sync: (u64, Option<Ns>),
}

/// Everything that happens beside frames.
#[derive(Clone, Copy, Debug)]
pub(super) enum Notice<'a> {
    /// The next file begins.
    Begin {
        file: &'a [u8],
        /// The name of its format.
        format: &'a str,
        /// True for the first of the files that are open together.
        first: bool,
    },
    /// An SDO transfer has ended; the frame that ended it follows.
    Transfer(&'a Transfer),
    /// Events that belong to no frame at hand.
    Asides(&'a [Event]),
    /// A finding about the capture.
    Finding(&'a Finding),
    /// A message of the capturing program about itself.
    Marker(&'a Marker),
    /// A bus is away for a while.
    Gap(BusId, bool),
    /// The clock of the frames shows this time, in ns.
    Advance(Ns),
    /// Live buses have delivered everything until this time, in ns.
    Until(Ns),
    /// The end of a file that had frames, with the number of its unreadable lines or records.
    EndOfFile(u64),
    /// A problem has changed.
    Changed(&'a Diagnosis, (Phase, ProblemId)),
    /// The diagnosis at the end of the capture.
    Diagnosis(&'a Diagnosis),
    /// The nodes at the end of a capture that had frames, before [`Self::Finish`].
    Settle(&'a [Bus]),
    /// The end of a capture that had frames, with the number of frames or transfers shown.
    Finish(u64),
    /// The end of any capture.
    Close,
}

/// An output, with its state from frame to frame.
pub(super) trait Sink: Any + Debug + Send + Sync {
    /// Takes a frame with its events. A sink that keeps the frame's own event removes it, and is the last one.
    fn frame(&mut self, _out: &mut Vec<u8>, _view: &View<'_>, _passing: &Passing<'_>, _events: &mut Vec<Event>) {}

    /// Takes a notice.
    fn take(&mut self, _out: &mut Vec<u8>, _view: &View<'_>, _notice: Notice<'_>) {}

    /// Returns another sink that writes the same, if nothing depends on what was written before.
    fn another(&self) -> Option<Box<dyn Sink>> {
        None
    }
}

impl Sink for Signals {
    fn frame(&mut self, out: &mut Vec<u8>, view: &View<'_>, passing: &Passing<'_>, events: &mut Vec<Event>) {
        if passing.shown {
            Signals::frame(self, out, view.jsonl, passing.frame, events);
        }
    }
}

impl Sink for Info {
    fn take(&mut self, _out: &mut Vec<u8>, _view: &View<'_>, notice: Notice<'_>) {
        if let Notice::Begin { first: true, .. } = notice {
            *self = Self::default();
        }
    }
}

/// The digest of a capture for a comparison.
#[derive(Debug)]
pub(super) struct Digested {
    pub(super) digest: Digest,
    pub(super) filter: Filter,
}

impl Sink for Digested {
    fn frame(&mut self, _out: &mut Vec<u8>, _view: &View<'_>, passing: &Passing<'_>, events: &mut Vec<Event>) {
        self.digest.extend(passing.frame);
        if passing.shown {
            self.digest.frame(passing.frame, events);
        }
    }

    fn take(&mut self, _out: &mut Vec<u8>, view: &View<'_>, notice: Notice<'_>) {
        let Self { digest, filter } = self;
        let shown = |event: &&Event| match &event.what {
            What::Transfer(transfer) => {
                filter.shows_transfer(transfer, &said_of(view, transfer), view.buses, view.clock)
            }
            _ => filter.is_empty(),
        };
        match notice {
            Notice::Asides(events) => digest.asides(events.iter().filter(shown)),
            Notice::Diagnosis(diagnosis) if digest.diagnoses() => digest.diagnosis(diagnosis),
            Notice::Finish(_) => digest.finish(view.buses),
            _ => {}
        }
    }
}

impl Sink for Writer {
    fn frame(&mut self, out: &mut Vec<u8>, view: &View<'_>, passing: &Passing<'_>, events: &mut Vec<Event>) {
        if passing.shown {
            Writer::frame(self, out, view.writing, passing.frame);
            self.events(out, view.writing, Some(passing.frame), events);
        }
    }

    fn take(&mut self, out: &mut Vec<u8>, view: &View<'_>, notice: Notice<'_>) {
        match notice {
            Notice::Begin { file, format, .. } => self.source(file, format),
            Notice::Asides(events) => self.events(out, view.writing, None, events),
            Notice::Finding(finding) => self.finding(out, view.writing, finding),
            Notice::Marker(marker) => self.marker(out, view.writing, marker),
            Notice::Until(now_ns) => self.until(out, now_ns),
            Notice::Finish(_) => self.finish(out, view.writing),
            _ => {}
        }
    }
}

impl Sink for Monitor {
    fn frame(&mut self, _out: &mut Vec<u8>, view: &View<'_>, passing: &Passing<'_>, events: &mut Vec<Event>) {
        Monitor::frame(self, view.jsonl, passing.service.0, passing.frame, events, passing.shown);
    }

    fn take(&mut self, _out: &mut Vec<u8>, view: &View<'_>, notice: Notice<'_>) {
        match notice {
            Notice::Asides(events) => self.asides(view.jsonl, events),
            Notice::Finding(finding) => self.finding(view.jsonl, finding),
            Notice::Marker(marker) => self.marker(marker),
            Notice::Gap(bus, away) => self.gap(bus, away),
            Notice::Advance(now_ns) => self.advance(now_ns),
            Notice::EndOfFile(unreadable) => self.end_of_file(unreadable),
            _ => {}
        }
    }
}

impl Sink for Columns {
    fn frame(&mut self, _out: &mut Vec<u8>, view: &View<'_>, passing: &Passing<'_>, events: &mut Vec<Event>) {
        let Passing { frame, service, shown, sync: (cycle, window_ns) } = *passing;
        Columns::frame(self, Seen { service, cycle, window_ns, shown, setting: view.jsonl }, frame, events);
    }

    fn take(&mut self, _out: &mut Vec<u8>, view: &View<'_>, notice: Notice<'_>) {
        match notice {
            Notice::Transfer(transfer) => self.transfer(view.jsonl, transfer),
            Notice::Asides(events) => self.asides(view.jsonl, events),
            Notice::Finding(finding) => self.finding(view.jsonl, finding),
            Notice::Gap(bus, _) => self.gap(bus),
            Notice::Advance(now_ns) => self.advance(view.jsonl, now_ns),
            Notice::Diagnosis(diagnosis) => self.diagnosis(view.jsonl, diagnosis),
            Notice::Settle(state) => self.settle(state),
            Notice::Close => self.finish(view.jsonl),
            _ => {}
        }
    }
}

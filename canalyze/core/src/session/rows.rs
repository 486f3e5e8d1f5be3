//! Outputs that write what they are given: lines for people, and records one by one.

use std::sync::Arc;

use super::capture::View;
use super::options::Encoding;
use super::sink::{Notice, Passing, Sink};
use super::subject::Seen;
use crate::bytes::readers::Marker;
use crate::rules::finding::{Code, Finding};
use crate::tables::columns::transfers;
use crate::tables::jsonl;
use crate::views::expectation::observed::Observed;
use crate::views::filter::Filter;
use crate::views::finding_context::{FindingContext, HeldFrame};
use crate::views::lines::Lines;
use crate::views::summary::Summary;
use crate::words::{Lang, problems};
use crate::world::event::{Event, What};
use crate::world::network::Network;

/// Annotated lines.
#[derive(Debug)]
pub(super) struct Text(pub(super) Lines);

impl Sink for Text {
    fn frame(&mut self, out: &mut Vec<u8>, view: &View<'_>, passing: &Passing<'_>, events: &mut Vec<Event>) {
        if passing.shown {
            self.0.clock = view.jsonl.clock;
            self.0.frame(out, passing.frame, events, view.buses);
        }
    }

    fn take(&mut self, out: &mut Vec<u8>, view: &View<'_>, notice: Notice<'_>) {
        match notice {
            Notice::Asides(events) => self.0.end(out, events),
            Notice::Marker(marker) => self.0.marker(out, marker, view.buses),
            Notice::Finish(_) => self.0.finish(out),
            // Findings about the capture are on standard error.
            _ => {}
        }
    }
}

/// The annotated lines of frames as JSON lines, each with the number of its frame.
#[derive(Debug)]
pub(super) struct LineRows(pub(super) Lines);

impl Sink for LineRows {
    fn frame(&mut self, out: &mut Vec<u8>, view: &View<'_>, passing: &Passing<'_>, events: &mut Vec<Event>) {
        if passing.shown {
            self.0.clock = view.jsonl.clock;
            jsonl::line(out, passing.frame.no, |text| self.0.frame(text, passing.frame, events, view.buses));
        }
    }
}

/// A JSON line for each frame, followed by those of its notes, findings and transfers.
#[derive(Debug, Default)]
pub(super) struct FrameRows(jsonl::FrameObjects);

impl Sink for FrameRows {
    fn frame(&mut self, out: &mut Vec<u8>, view: &View<'_>, passing: &Passing<'_>, events: &mut Vec<Event>) {
        if passing.shown {
            self.0.frame(out, view.jsonl, passing.frame, events);
        }
    }

    fn take(&mut self, out: &mut Vec<u8>, view: &View<'_>, notice: Notice<'_>) {
        match notice {
            Notice::Asides(events) => jsonl::asides(out, view.jsonl, events),
            Notice::Finding(finding) => jsonl::finding(out, view.jsonl, finding),
            _ => {}
        }
    }

    fn another(&self) -> Option<Box<dyn Sink>> {
        Some(Box::new(Self::default()))
    }
}

/// SDO transfers as they end.
#[derive(Debug)]
pub(super) struct TransferRows {
    /// The language of names; `None`: CSV.
    names: Option<Lang>,
    /// True once the headings of CSV are written.
    headed: bool,
}

impl TransferRows {
    pub(super) fn new(encoding: Encoding, lang: Lang) -> Self {
        Self { names: encoding.names(lang), headed: false }
    }
}

impl Sink for TransferRows {
    fn take(&mut self, out: &mut Vec<u8>, view: &View<'_>, notice: Notice<'_>) {
        let Notice::Transfer(transfer) = notice else { return };
        if let Some(names) = self.names {
            return jsonl::transfer(out, view.jsonl, transfer, names);
        }
        if !std::mem::replace(&mut self.headed, true) {
            transfers::head(out);
        }
        transfers::row(out, view.jsonl, transfer);
    }
}

/// Findings as they come, each with the annotated lines of its context.
#[derive(Debug)]
pub(super) struct FindingRows {
    filter: Filter,
    context: FindingContext,
}

impl FindingRows {
    pub(super) fn new(filter: Filter) -> Self {
        Self { filter, context: FindingContext::default() }
    }

    /// Writes the findings among events that pass.
    fn write(
        &self,
        out: &mut Vec<u8>,
        view: &View<'_>,
        events: &[Event],
        passes: impl Fn(&Event, &Finding, &[&HeldFrame]) -> bool,
    ) {
        for event in events {
            let What::Finding(finding) = &event.what else { continue };
            let lines = self.context.frames(finding);
            if passes(event, finding, &lines) {
                jsonl::finding_with_lines(out, view.jsonl, finding, &lines);
            }
        }
    }

    /// Writes the findings among events that belong to no frame at hand.
    fn asides(&self, out: &mut Vec<u8>, view: &View<'_>, events: &[Event]) {
        let filter = &self.filter;
        let passes = |held: &HeldFrame, event: &Event| {
            let events = held.event.as_slice();
            let seen = Seen { lang: view.jsonl.lang, frame: &held.frame, events, further: Some(event) };
            filter.shows(&held.frame, &seen, view.buses, view.clock)
        };
        self.write(out, view, events, |event, finding, lines| {
            // The frame at hand only proves the finding, which is about the others if there are any.
            let mut about = lines.iter().filter(|held| lines.len() == 1 || held.frame.no != finding.at.no);
            let named = filter.is_empty() || lines.is_empty() || about.any(|held| passes(held, event));
            named && filter.takes_finding(finding)
        });
    }
}

impl Sink for FindingRows {
    fn frame(&mut self, out: &mut Vec<u8>, view: &View<'_>, passing: &Passing<'_>, events: &mut Vec<Event>) {
        self.context.push(passing.frame, events);
        if passing.shown {
            self.write(out, view, events, |_, finding, _| self.filter.takes_finding(finding));
        }
    }

    fn take(&mut self, out: &mut Vec<u8>, view: &View<'_>, notice: Notice<'_>) {
        match notice {
            Notice::Asides(events) => self.asides(out, view, events),
            Notice::Finding(finding) => {
                jsonl::finding_with_lines(out, view.jsonl, finding, &self.context.frames(finding));
            }
            _ => {}
        }
    }
}

/// Figures of the capture, at the end.
#[derive(Debug)]
pub(super) struct SummaryRows(Summary);

impl SummaryRows {
    pub(super) fn new(network: Arc<Network>) -> Self {
        Self(Summary::new(network))
    }
}

impl Sink for SummaryRows {
    fn frame(&mut self, _out: &mut Vec<u8>, _view: &View<'_>, passing: &Passing<'_>, events: &mut Vec<Event>) {
        if passing.shown {
            self.0.frame(passing.frame, events);
        }
    }

    fn take(&mut self, out: &mut Vec<u8>, view: &View<'_>, notice: Notice<'_>) {
        match notice {
            Notice::Asides(events) => self.0.asides(events),
            Notice::Finding(finding) => self.0.finding(finding),
            Notice::Marker(marker) => self.0.marker(marker),
            Notice::EndOfFile(unreadable) => self.0.file(unreadable),
            Notice::Finish(shown) if shown > 0 => jsonl::summary::write(out, view.jsonl, &self.0),
            _ => {}
        }
    }
}

/// Observations from which expectations can be written, at the end.
#[derive(Debug, Default)]
pub(super) struct ObservedRows(Observed);

impl Sink for ObservedRows {
    fn frame(&mut self, _out: &mut Vec<u8>, _view: &View<'_>, passing: &Passing<'_>, events: &mut Vec<Event>) {
        if passing.shown {
            self.0.frame(passing.frame, events);
        }
    }

    fn take(&mut self, out: &mut Vec<u8>, view: &View<'_>, notice: Notice<'_>) {
        match notice {
            Notice::Marker(Marker::Dropped { bus, .. }) => self.0.lost(Some(*bus)),
            Notice::Marker(Marker::LeftOut { .. }) => self.0.lost(None),
            Notice::Finding(finding) if finding.code == Code::Cap004 => self.0.lost(None),
            Notice::Finish(shown) if shown > 0 => jsonl::observed::write(out, view.jsonl, &self.0),
            _ => {}
        }
    }
}

/// Problems and the verdict, at the end.
#[derive(Debug)]
pub(super) struct Problems;

impl Sink for Problems {
    fn take(&mut self, out: &mut Vec<u8>, view: &View<'_>, notice: Notice<'_>) {
        if let Notice::Diagnosis(diagnosis) = notice {
            jsonl::diagnosis::write(out, view.jsonl, diagnosis);
        }
    }
}

/// Problems that end with the capture.
#[derive(Debug)]
pub(super) struct Endings;

impl Sink for Endings {
    fn take(&mut self, out: &mut Vec<u8>, view: &View<'_>, notice: Notice<'_>) {
        if let Notice::Diagnosis(diagnosis) = notice {
            jsonl::diagnosis::ends(out, view.jsonl, diagnosis);
        }
    }
}

/// Problems as they begin, are linked to a cause and end.
#[derive(Debug)]
pub(super) struct Changes {
    /// The look of lines for people; `None`: JSON lines.
    pub(super) lines: Option<Lines>,
}

impl Sink for Changes {
    fn take(&mut self, out: &mut Vec<u8>, view: &View<'_>, notice: Notice<'_>) {
        let Notice::Changed(diagnosis, change) = notice else { return };
        match &self.lines {
            Some(lines) => lines.emphasized(out, |out| problems::changed(out, view.jsonl.lang, diagnosis, change)),
            None => jsonl::diagnosis::changed(out, view.jsonl, diagnosis, change),
        }
    }
}

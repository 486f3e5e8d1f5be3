//! Forms that are made of whole records, JSON lines all of them: SDO transfers and findings as they come, figures at
//! the end.
//!
//! A form is a choice of parts: one more is a row in [`Records::new`]. Must not: judge.

use std::sync::Arc;

use super::capture::View;
use super::options::Format;
use super::sink::{Passing, Sink};
use super::subject::Seen;
use crate::bytes::readers::Marker;
use crate::rules::finding::{Code, Finding};
use crate::sdo::transfer::Transfer;
use crate::stories::Diagnosis;
use crate::tables::columns::transfers;
use crate::tables::jsonl;
use crate::views::expectation::observed::Observed;
use crate::views::filter::Filter;
use crate::views::finding_context::{FindingContext, HeldFrame};
use crate::views::summary::Summary;
use crate::words::Lang;
use crate::world::event::{Event, What};
use crate::world::network::Network;

/// What of a capture is written; of each part what it keeps.
#[derive(Debug)]
pub(super) struct Records {
    /// SDO transfers as they end.
    transfers: bool,
    /// The language of their objects' names: one, or that of the texts, for what is laid out for people.
    names: Option<Lang>,
    /// The same as CSV, and whether its headings are written.
    table: Option<bool>,
    /// Findings as they come, each with the lines of its context.
    context: Option<Box<FindingContext>>,
    /// Figures at the end.
    summary: Option<Box<Summary>>,
    /// What expectations can be written from, at the end.
    observed: Option<Box<Observed>>,
}

impl Records {
    /// The parts of a format; none of them for one that is made otherwise.
    pub(super) fn new(format: Format, network: &Arc<Network>) -> Self {
        let (transfers, findings, figures, observed) = match format {
            Format::Transfers | Format::TransfersText | Format::TransfersCsv => (true, false, false, false),
            Format::Check => (false, true, false, false),
            Format::Summary => (false, false, true, false),
            Format::Records => (true, true, true, false),
            Format::Observed => (true, false, true, true),
            _ => (false, false, false, false),
        };
        Self {
            transfers,
            names: (!matches!(format, Format::TransfersText | Format::Observed)).then_some(jsonl::NAMES),
            table: (format == Format::TransfersCsv).then_some(false),
            context: findings.then(Box::default),
            summary: figures.then(|| Box::new(Summary::new(Arc::clone(network)))),
            observed: observed.then(Box::default),
        }
    }

    /// The findings among the events that pass, each with the lines of its context.
    fn findings(
        &self,
        out: &mut Vec<u8>,
        view: View<'_>,
        events: &[Event],
        passes: impl Fn(&Event, &Finding, &[&HeldFrame]) -> bool,
    ) {
        let Some(context) = &self.context else { return };
        for event in events {
            let What::Finding(finding) = &event.what else { continue };
            let lines = context.frames(finding);
            if passes(event, finding, &lines) {
                jsonl::finding_with_lines(out, view.jsonl, finding, &lines);
            }
        }
    }
}

impl Sink for Records {
    fn transfer(&mut self, out: &mut Vec<u8>, view: View<'_>, transfer: &Transfer) -> bool {
        match &mut self.table {
            Some(headed) => {
                if !std::mem::replace(headed, true) {
                    transfers::head(out);
                }
                transfers::row(out, view.jsonl, transfer);
            }
            None if self.transfers => jsonl::transfer(out, view.jsonl, transfer, self.names.unwrap_or(view.jsonl.lang)),
            None => {}
        }
        self.transfers
    }

    /// Of its events the frame's own one is taken out where findings are written.
    fn frame(&mut self, out: &mut Vec<u8>, view: View<'_>, passing: Passing<'_>, events: &mut Vec<Event>) {
        let Passing { frame, filter, shown, .. } = passing;
        if shown {
            if let Some(summary) = &mut self.summary {
                summary.frame(frame, events);
            }
            if let Some(observed) = &mut self.observed {
                observed.frame(frame, events);
            }
        }
        if let Some(context) = &mut self.context {
            context.push(frame, (!events.is_empty()).then(|| events.remove(0)));
        }
        if shown {
            self.findings(out, view, events, |_, finding, _| filter.takes_finding(finding));
        }
    }

    fn filters_asides(&self) -> bool {
        self.context.is_some() || self.summary.is_some() || self.observed.is_some()
    }

    fn asides(&mut self, out: &mut Vec<u8>, view: View<'_>, events: &[Event], filter: &Filter) {
        if let Some(summary) = &mut self.summary {
            summary.asides(events);
        }
        let passes = |held: &HeldFrame, event: &Event| {
            let events = held.event.as_slice();
            let seen = Seen { lang: view.jsonl.lang, frame: &held.frame, events, further: Some(event) };
            filter.shows(&held.frame, &seen, view.buses, view.clock)
        };
        self.findings(out, view, events, |event, finding, lines| {
            // The frame at hand only proves it: what it is about are the others, where there are any.
            let mut about = lines.iter().filter(|held| lines.len() == 1 || held.frame.no != finding.at.no);
            let named = filter.is_empty() || lines.is_empty() || about.any(|held| passes(held, event));
            named && filter.takes_finding(finding)
        });
    }

    fn marker(&mut self, _out: &mut Vec<u8>, _view: View<'_>, marker: &Marker) {
        if let Some(summary) = &mut self.summary {
            summary.marker(marker);
        }
        match (&mut self.observed, marker) {
            (Some(observed), Marker::Dropped { bus, .. }) => observed.lost(Some(*bus)),
            (Some(observed), Marker::LeftOut { .. }) => observed.lost(None),
            _ => {}
        }
    }

    fn finding(&mut self, out: &mut Vec<u8>, view: View<'_>, finding: &Finding) {
        if let Some(summary) = &mut self.summary {
            summary.finding(finding);
        }
        if let (Some(observed), Code::Cap004) = (&mut self.observed, finding.code) {
            observed.lost(None);
        }
        if let Some(context) = &self.context {
            jsonl::finding_with_lines(out, view.jsonl, finding, &context.frames(finding));
        }
    }

    fn diagnosis(&mut self, out: &mut Vec<u8>, view: View<'_>, diagnosis: &Diagnosis) {
        jsonl::diagnosis::write(out, view.jsonl, diagnosis);
    }

    fn end_of_file(&mut self, unreadable: u64) {
        if let Some(summary) = &mut self.summary {
            summary.file(unreadable);
        }
    }

    fn finish(&mut self, out: &mut Vec<u8>, view: View<'_>, shown: u64) {
        if let Some(summary) = self.summary.as_ref().filter(|_| shown > 0) {
            jsonl::summary::write(out, view.jsonl, summary);
        }
        if let Some(observed) = self.observed.as_ref().filter(|_| shown > 0) {
            jsonl::observed::write(out, view.jsonl, observed);
        }
    }

    fn takes_frames(&self) -> bool {
        self.context.is_some() || self.summary.is_some()
    }

    /// Figures count every finding by themselves.
    fn folds(&self) -> bool {
        self.context.is_some() || self.summary.is_none()
    }
}

//! Forms that are made of whole records, JSON lines all of them: SDO transfers and findings as they come, figures at
//! the end.
//!
//! A form is a choice of parts: one more is a row in [`Records::new`]. Must not: filter, or judge.

use std::sync::Arc;

use super::Format;
use super::capture::View;
use crate::event::{Event, What};
use crate::expectation::observed::Observed;
use crate::finding::{Code, Finding};
use crate::finding_context::{FindingContext, Held};
use crate::frame::Frame;
use crate::network::Network;
use crate::readers::Marker;
use crate::render::jsonl;
use crate::summary::Summary;

/// What of a capture is told; of each part what it keeps.
#[derive(Debug)]
pub(super) struct Records {
    /// SDO transfers as they end.
    pub(super) transfers: bool,
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
            Format::Transfers => (true, false, false, false),
            Format::Check => (false, true, false, false),
            Format::Summary => (false, false, true, false),
            Format::Records => (true, true, true, false),
            Format::Observed => (true, false, true, true),
            _ => (false, false, false, false),
        };
        Self {
            transfers,
            context: findings.then(Box::default),
            summary: figures.then(|| Box::new(Summary::new(Arc::clone(network)))),
            observed: observed.then(Box::default),
        }
    }

    /// Frames are of no interest by themselves.
    pub(super) fn is_transfers_only(&self) -> bool {
        self.context.is_none() && self.summary.is_none()
    }

    /// Every finding is counted among the figures, and none is told.
    pub(super) fn only_counts(&self) -> bool {
        self.context.is_none() && self.summary.is_some()
    }

    /// A frame with what follows from it. `shown`: it passes the filter. Of its events its own is taken where findings
    /// are told.
    pub(super) fn frame(
        &mut self,
        out: &mut Vec<u8>,
        view: View<'_>,
        frame: &Frame,
        events: &mut Vec<Event>,
        shown: bool,
    ) {
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
            self.findings(out, view, events, |_, _| true);
        }
    }

    /// What belongs to no frame at hand. `passes`: whether a frame that is held passes the filter, `None` where there is
    /// no filter.
    pub(super) fn asides(
        &mut self,
        out: &mut Vec<u8>,
        view: View<'_>,
        events: &[Event],
        passes: Option<&dyn Fn(&Held) -> bool>,
    ) {
        if let Some(summary) = &mut self.summary {
            summary.asides(events);
        }
        self.findings(out, view, events, |finding, lines| {
            let Some(passes) = passes else { return true };
            // The frame at hand only proves it: what it is about are the others, where there are any.
            let mut about = lines.iter().filter(|held| lines.len() == 1 || held.frame.no != finding.at.no);
            lines.is_empty() || about.any(|held| passes(held))
        });
    }

    /// What the capturing program says of itself.
    pub(super) fn marker(&mut self, marker: &Marker) {
        if let Some(summary) = &mut self.summary {
            summary.marker(marker);
        }
        if let (Some(observed), Marker::Dropped { bus, .. }) = (&mut self.observed, marker) {
            observed.lost(Some(*bus));
        }
    }

    /// A finding about the capture, which belongs to no frame.
    pub(super) fn finding(&mut self, out: &mut Vec<u8>, view: View<'_>, finding: &Finding) {
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

    /// A file is over that had frames, and so many lines or records that cannot be read.
    pub(super) fn end_of_file(&mut self, unreadable: u64) {
        if let Some(summary) = &mut self.summary {
            summary.file(unreadable);
        }
    }

    /// The capture is over, of which something was shown.
    pub(super) fn finish(&self, out: &mut Vec<u8>, view: View<'_>) {
        if let Some(summary) = &self.summary {
            jsonl::summary::write(out, view.jsonl, summary);
        }
        if let Some(observed) = &self.observed {
            jsonl::observed::write(out, view.jsonl, observed);
        }
    }

    /// The findings among the events that pass, each with the lines of its context.
    fn findings(
        &self,
        out: &mut Vec<u8>,
        view: View<'_>,
        events: &[Event],
        passes: impl Fn(&Finding, &[&Held]) -> bool,
    ) {
        let Some(context) = &self.context else { return };
        for event in events {
            let What::Finding(finding) = &event.what else { continue };
            let lines = context.frames(finding);
            if passes(finding, &lines) {
                jsonl::finding_with_lines(out, view.jsonl, finding, &lines);
            }
        }
    }
}

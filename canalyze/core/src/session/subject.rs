//! The properties of a frame that filters take from its events.
//!
//! Words are put together only if a filter asks for them. The comparison is the filter's.

use super::capture::View;
use crate::bytes::frame::Frame;
use crate::rules::finding::{Finding, Severity};
use crate::sdo::transfer::Transfer;
use crate::sdo::wire::Mux;
use crate::views::filter::Subject;
use crate::views::lines::Lines;
use crate::words::{Depth, Lang, lane};
pub(super) use crate::world::event::service;
use crate::world::event::{Event, Signals, What};

/// A frame with its events.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen<'a> {
    pub(super) lang: Lang,
    pub(super) frame: &'a Frame,
    pub(super) events: &'a [Event],
    /// A further event, which stands elsewhere but is about it.
    pub(super) further: Option<&'a Event>,
}

impl<'a> Seen<'a> {
    fn all(&self) -> impl Iterator<Item = &'a Event> {
        self.events.iter().chain(self.further)
    }

    fn findings(&self) -> impl Iterator<Item = &'a Finding> {
        self.all().filter_map(|event| if let What::Finding(finding) = &event.what { Some(&**finding) } else { None })
    }
}

impl Subject for Seen<'_> {
    fn service(&self) -> (&str, Option<u8>) {
        service(self.events)
    }

    fn has_object(&self, wanted: &dyn Fn(Mux) -> bool) -> bool {
        self.all().any(|event| objects(&event.what, wanted))
    }

    fn has_finding(&self, wanted: &dyn Fn(&str, Severity) -> bool) -> bool {
        self.findings().any(|finding| wanted(finding.code.rule().id, finding.severity()))
    }

    fn annotation(&self, out: &mut Vec<u8>) {
        let lines = Lines::new(self.lang, Depth::Default, None);
        for event in self.all() {
            lines.said(out, event, self.frame);
        }
    }
}

/// Returns true if an event is about an object that is wanted.
fn objects(what: &What, wanted: &dyn Fn(Mux) -> bool) -> bool {
    let mapped = |one: &crate::wire::pdo::mapping::Mapped| !one.dummy && wanted(Mux { index: one.index, sub: one.sub });
    match what {
        What::Sdo(step) => step.mux.or(step.command.mux()).is_some_and(wanted),
        What::Pdo(data) => match &data.content {
            Signals::Mapped(mapping, _) | Signals::ByConsumer(mapping, ..) => mapping.entries.iter().any(mapped),
            Signals::None(_) => false,
        },
        What::Mpdo(data) => data.mapping.entries.iter().any(mapped),
        What::Transfer(transfer) => transfer.mux.is_some_and(wanted),
        What::Finding(finding) => finding.object.is_some_and(wanted),
        What::Message(_) | What::Note(_) | What::Change(_) => false,
    }
}

/// Returns the words about an event that belongs to no frame at hand.
pub(super) fn aside(lang: Lang, event: &Event) -> impl Fn(&mut Vec<u8>) {
    move |out| Lines::new(lang, Depth::Default, None).aside(out, event, 0)
}

/// Returns the words about a transfer.
pub(super) fn said_of<'a>(view: &'a View<'a>, transfer: &'a Transfer) -> impl Fn(&mut Vec<u8>) + 'a {
    move |out| lane::transfer(out, view.jsonl.lang, transfer, true)
}

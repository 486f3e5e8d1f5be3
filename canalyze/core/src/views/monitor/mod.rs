//! The view of a growing capture: buses, nodes, communication objects, SDO transfers, findings, and the last lines.
//!
//! It takes every frame with its events and keeps the present state beside the figures of `summary`. Time is that of
//! the frames, and memory is bounded. Nothing is decoded or judged here, and no clock is read.

use crate::bytes::ns::Ns;

mod clock;
mod findings;
mod objects;
mod page;
mod problems;
mod recent;
mod snapshot;
#[cfg(test)]
mod tests;
mod trace;
mod transfers;
mod wire;

use std::sync::Arc;

use self::clock::CaptureClock;
use self::findings::Findings;
use self::objects::ObjectLines;
use self::page::Identity;
use self::trace::{FramePlace, Trace};
use self::transfers::Transfers;
use self::wire::Wire;
use crate::bytes::frame::{BusId, Buses, CanId, Frame, FrameRef, Kind};
use crate::bytes::readers::Marker;
use crate::problems::Diagnosis;
use crate::rules::finding::{Finding, Severity};
use crate::sdo::wire::Mux;
use crate::tables::jsonl::Setting;
use crate::views::filter;
use crate::views::finding_context;
use crate::views::lines::Lines;
use crate::views::summary::Summary;
use crate::wire::pdo::mapping::Mapping;
use crate::words::digits::{Spaced, put};
use crate::words::{Depth, Lang};
use crate::world::bus::Bus;
use crate::world::event::{Event, ProcessData, Signals, What};
use crate::world::network::Network;

pub use self::trace::{Line, Wanted};

/// Knowledge of others that a snapshot shows.
#[derive(Clone, Copy, Debug)]
pub struct Known<'a> {
    /// The session's tally, as JSON.
    pub tally: &'a [u8],
    /// The state of decoding, by bus.
    pub buses: &'a [Bus],
    /// The diagnosis while the capture continues.
    pub diagnosis: Option<&'a Diagnosis>,
    /// The diagnosis as if the capture had ended now.
    pub by_now: Option<&'a Diagnosis>,
}

/// The state of a capture that is shown.
#[derive(Debug)]
pub struct Monitor {
    clock: CaptureClock,
    summary: Summary,
    /// By bus.
    wires: Vec<Wire>,
    objects: ObjectLines,
    transfers: Transfers,
    findings: Findings,
    identity: Identity,
    trace: Trace,
    lines: Lines,
    last: FrameRef,
    /// The text of the current line, and its data.
    said: Vec<u8>,
    data: Vec<u8>,
}

impl Monitor {
    /// Creates an empty view.
    pub fn new(lang: Lang, network: &Arc<Network>) -> Self {
        Self {
            clock: CaptureClock::default(),
            summary: Summary::new(Arc::clone(network)),
            wires: Vec::new(),
            objects: ObjectLines::default(),
            transfers: Transfers::default(),
            findings: Findings::default(),
            identity: Identity::default(),
            trace: Trace::default(),
            lines: Lines::new(lang, Depth::Default, None),
            last: FrameRef::default(),
            said: Vec::new(),
            data: Vec::new(),
        }
    }

    /// Takes a frame of a service with its events, and removes the frame's own event from them. `shown`: the frame
    /// passes the filter; only then it is traced.
    pub fn frame(
        &mut self,
        setting: Setting<'_>,
        service: &'static str,
        frame: &Frame,
        events: &mut Vec<Event>,
        shown: bool,
    ) {
        if let Some(now_ns) = frame.t_ns {
            self.clock.frame(now_ns);
        }
        self.last = frame.reference();
        self.summary.frame(frame, events);
        let bits = self.summary.buses.get(&frame.bus).map_or(0, |bus| bus.load.bits);
        let own = events.first().is_some_and(|event| is_own(&event.what)).then(|| events.remove(0));
        self.wire(frame.bus, |wire| wire.take(frame, own.as_ref(), events, bits));
        let worst = self.follow(setting, events, Some((frame, own.as_ref())));
        self.said.clear();
        if let Some(own) = &own {
            self.lines.said(&mut self.said, own, frame);
        }
        let words = self.said.trim_ascii_end();
        if let Some(object) = self.objects.take(frame, own.as_ref(), service) {
            object.text.clear();
            object.text.extend_from_slice(words);
            for (severity, _) in worst.iter().filter(|(_, about)| *about) {
                object.mark(*severity, frame.reference());
            }
        }
        if !shown {
            return;
        }
        let (no, t_ns, bus, id, kind) = (frame.no, frame.t_ns, frame.bus, frame.id, frame.kind);
        let node = own.as_ref().and_then(|own| own.node);
        let (object, mapping) = own.as_ref().map_or((None, None), objects);
        let place = FramePlace { frame: no, t_ns, bus, id, kind, service, node, object, mapping, code: None };
        self.data.clear();
        if kind == Kind::Remote {
            put!(&mut self.data; "remote request");
        } else {
            put!(&mut self.data; Spaced(frame.payload()));
        }
        // A finding that is not about this frame has a line of its own.
        let severity = worst.iter().filter(|(_, about)| *about).map(|(severity, _)| *severity).max();
        self.trace.push(place.clone(), severity, true, &self.data, words);
        self.below(events, &place);
    }

    /// Takes events without a current frame.
    pub fn asides(&mut self, setting: Setting<'_>, events: &[Event]) {
        self.summary.asides(events);
        let mut events = events.to_vec();
        self.follow(setting, &mut events, None);
        for event in &events {
            let place = self.nowhere(event.bus, event.node);
            self.below(std::slice::from_ref(event), &place);
        }
    }

    /// Takes a finding about the capture, which belongs to no frame.
    pub fn finding(&mut self, setting: Setting<'_>, finding: &Finding) {
        self.summary.finding(finding);
        let Finding { at, bus, node, .. } = *finding;
        let what = What::Finding(Box::new(finding.clone()));
        let mut events = vec![Event { at, about: None, bus, node, transfer: None, what }];
        self.follow(setting, &mut events, None);
        let place = self.nowhere(bus, node);
        self.below(&events, &place);
    }

    /// Takes a report of the capturing program.
    pub fn marker(&mut self, marker: &Marker) {
        self.summary.marker(marker);
        match marker {
            Marker::Dropped { bus, .. } => self.objects.lost(*bus),
            Marker::LeftOut { .. } => self.summary.buses.keys().for_each(|bus| self.objects.lost(*bus)),
            _ => {}
        }
    }

    /// Notes that a bus is away for a while and may have frames meanwhile.
    pub fn gap(&mut self, bus: BusId, away: bool) {
        self.summary.gap(bus);
        self.objects.lost(bus);
        if away {
            self.wire(bus, Wire::leave);
        }
    }

    /// Takes the end of a file with frames, and the number of its unreadable lines or records.
    pub fn end_of_file(&mut self, unreadable: u64) {
        self.summary.file(unreadable);
    }

    /// Advances the time to `now_ns` on the clock of the frames.
    pub fn advance(&mut self, now_ns: Ns) {
        self.clock.advance(now_ns);
    }

    /// Returns the view without the trace as one JSON object; declared in `snapshot.rs`.
    pub fn snapshot(&self, setting: Setting<'_>, known: Known<'_>) -> Vec<u8> {
        snapshot::snapshot(self, setting, known)
    }

    /// Returns the page of one node as one JSON object; declared in `page.rs`.
    pub fn page(&self, setting: Setting<'_>, known: &[Bus], (bus, node): (BusId, u8)) -> Vec<u8> {
        self.identity.page(setting, known.get(usize::from(bus.0)), (bus, node))
    }

    /// Returns lines of the trace, oldest first.
    pub fn trace(&self, wanted: Wanted<'_>, buses: &Buses, clock: filter::FilterClock) -> Vec<Line> {
        self.trace.lines(wanted, buses, clock)
    }

    /// Takes transfers and findings, and removes findings that are only counted. Returns the severities of all findings
    /// at the current frame, each with true if it is about that frame.
    fn follow(
        &mut self,
        setting: Setting<'_>,
        events: &mut Vec<Event>,
        at: Option<(&Frame, Option<&Event>)>,
    ) -> Vec<(Severity, bool)> {
        let mut found = Vec::new();
        events.retain(|event| match &event.what {
            What::Transfer(transfer) => {
                self.transfers.take(setting, transfer);
                self.identity.take(setting, transfer);
                true
            }
            What::Finding(finding) => {
                let severity = finding.severity();
                if let Some(node) = finding.node {
                    wire(&mut self.wires, finding.bus, |wire| wire.find(node, severity));
                }
                if let Some((frame, own)) = at.filter(|(frame, _)| frame.no == finding.at.no) {
                    let about =
                        |own: &Event| own.node == finding.node && finding_context::concerns(finding.code, &own.what);
                    found.push((severity, finding.bus == frame.bus && own.is_some_and(about)));
                }
                self.findings.take(setting, finding)
            }
            _ => true,
        });
        found
    }

    /// Traces the lines below a frame's own one, or without a frame.
    fn below(&mut self, events: &[Event], place: &FramePlace) {
        for event in events.iter().filter(|event| !is_own(&event.what)) {
            self.said.clear();
            self.lines.aside(&mut self.said, event, place.frame);
            let words = self.said.trim_ascii_end();
            let words = words.strip_prefix(b"#").unwrap_or(words).trim_ascii_start();
            if !words.is_empty() {
                let finding = if let What::Finding(finding) = &event.what { Some(finding) } else { None };
                let code = finding.map(|finding| finding.code);
                let object = finding.and_then(|finding| finding.object).or(place.object);
                let severity = finding.map(|finding| finding.severity());
                self.trace.push(FramePlace { code, object, ..place.clone() }, severity, false, &[], words);
            }
        }
    }

    /// Returns the place of a line without a frame.
    fn nowhere(&self, bus: BusId, node: Option<u8>) -> FramePlace {
        let FrameRef { no, .. } = self.last;
        FramePlace {
            frame: no,
            t_ns: self.clock.now_ns,
            bus,
            id: CanId::standard(0),
            kind: Kind::Error,
            service: "",
            node,
            object: None,
            mapping: None,
            code: None,
        }
    }

    fn wire(&mut self, bus: BusId, act: impl FnOnce(&mut Wire)) {
        wire(&mut self.wires, bus, act);
    }
}

/// Returns the object that a frame's own event is about, and its mapped objects.
fn objects(own: &Event) -> (Option<Mux>, Option<Arc<Mapping>>) {
    match &own.what {
        What::Sdo(step) => (step.mux.or(step.command.mux()), None),
        What::Pdo(ProcessData { content: Signals::Mapped(mapping, _) | Signals::ByConsumer(mapping, ..), .. }) => {
            (None, Some(Arc::clone(mapping)))
        }
        What::Mpdo(data) => (data.mapping.entries.first().map(|one| Mux { index: one.index, sub: one.sub }), None),
        _ => (None, None),
    }
}

fn wire(wires: &mut Vec<Wire>, bus: BusId, act: impl FnOnce(&mut Wire)) {
    let index = usize::from(bus.0);
    if bus == BusId::NONE {
        return;
    }
    if wires.len() <= index {
        wires.resize_with(index + 1, Wire::default);
    }
    if let Some(wire) = wires.get_mut(index) {
        act(wire);
    }
}

/// Returns true if an event is the frame's own.
fn is_own(what: &What) -> bool {
    matches!(what, What::Message(_) | What::Pdo(_) | What::Mpdo(_) | What::Sdo(_))
}

//! Lines for people, in candump's console form, so that the output is input again.
//!
//! `can1  60A   [8]  40 08 10 00 00 00 00 00  # ...`: stamp, direction and length as they came; everything else
//! is a comment. Notes and findings stand on lines of their own that begin with `#`. The columns before the data are
//! those of `writers::console`.

mod known;

use std::collections::BTreeMap;

use self::known::{KnownLines, PdoForm};
use super::colour;
use crate::bytes::frame::{Buses, Frame, Kind, Stamp, StampForm};
use crate::bytes::ns::Ns;
use crate::bytes::readers::Marker;
use crate::bytes::writers::console::{ConsoleColumns, dropped, left_out, length};
use crate::rules::finding::{Code, Severity};
use crate::sdo::wire::Side;
use crate::wire;
use crate::wire::cob_id::{Role, predefined};
use crate::words::digits::{filled, hex_digits, put};
use crate::words::{Depth, Lang, explain, findings, notes, services as words};
use crate::world::event::{Event, ProcessData, Step, What};

/// The form of times (option `-t`, as in candump).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Time {
    /// a: seconds.
    Absolute,
    /// d: seconds since the frame before.
    Delta,
    /// z: seconds since the first frame.
    Zero,
    /// A: date and time of day, UTC.
    Date,
    /// n: none.
    None,
}

impl Time {
    /// All forms, with their names.
    pub const NAMES: &[(&str, Self)] =
        &[("a", Self::Absolute), ("d", Self::Delta), ("z", Self::Zero), ("A", Self::Date), ("n", Self::None)];
}

/// The form of times and their origin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Clocked {
    /// The form; unchanged by default.
    pub time: Option<Time>,
    /// The stamp of the capture's first frame.
    pub start_ns: Option<Ns>,
    /// The date that stamps count from, where one is known.
    pub date_ns: Option<Ns>,
}

impl Clocked {
    /// A moment in this form, and whether it is a date; `None` where none is shown. Differences are not known here.
    pub fn moment(self, t_ns: Ns) -> Option<(Ns, StampForm)> {
        match self.time {
            Some(Time::None) => None,
            Some(Time::Zero) => Some((t_ns - self.start_ns.unwrap_or(t_ns), StampForm::Seconds)),
            Some(Time::Absolute) => Some((t_ns + self.date_ns.unwrap_or(Ns::ZERO), StampForm::Seconds)),
            Some(Time::Date) => Some((t_ns + self.date_ns.unwrap_or(Ns::ZERO), StampForm::Calendar)),
            Some(Time::Delta) | None => Some((t_ns, StampForm::Seconds)),
        }
    }
}

/// The marks of lines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Look {
    /// In colours, for a terminal.
    pub coloured: bool,
    /// The number of each frame is before its line.
    pub numbered: bool,
}

/// The text renderer: what the lines so far decide of the next ones.
#[derive(Debug)]
pub struct Lines {
    lang: Lang,
    depth: Depth,
    look: Look,
    columns: ConsoleColumns,
    known: KnownLines,
    /// The form of the next frames' stamps.
    pub clock: Clocked,
    last_ns: Option<Ns>,
    /// Consequences are told at the end, by their causes; `None`: each has a line of its own.
    folded: Option<Consequences>,
}

/// Consequences, by the frame that explains them: how many of which rule.
type Consequences = BTreeMap<u64, BTreeMap<Code, u64>>;

/// Digits for which numbers of frames are aligned.
const NUMBER: usize = 6;
/// Causes of which the consequences are counted; those of further ones have lines of their own.
const CAUSES: usize = 4096;

impl Lines {
    /// A renderer at the beginning of a capture.
    pub fn new(lang: Lang, depth: Depth, time: Option<Time>) -> Self {
        Self {
            lang,
            depth,
            look: Look::default(),
            columns: ConsoleColumns::default(),
            known: KnownLines::default(),
            clock: Clocked { time, ..Clocked::default() },
            last_ns: None,
            folded: None,
        }
    }

    /// The same, but consequences are told at the end, in a line for each cause.
    pub fn folding(lang: Lang, depth: Depth, time: Option<Time>) -> Self {
        let folded = (depth != Depth::Explain).then(BTreeMap::new);
        Self { folded, ..Self::new(lang, depth, time) }
    }

    /// The same, marked like this.
    pub fn looking(self, look: Look) -> Self {
        Self { look, ..self }
    }

    /// One frame's line, and below it what else it shows.
    pub fn frame(&mut self, out: &mut Vec<u8>, frame: &Frame, events: &[Event], buses: &Buses) {
        let stamp = self.stamp(frame);
        if self.look.numbered {
            // With a colon readers take it for the number of the row, whatever follows.
            self.dyed(
                out,
                || colour::named("quiet"),
                |out| {
                    filled(out, frame.no, NUMBER, b' ');
                    out.push(b':');
                },
            );
            put!(out; "  ");
        }
        if self.look.coloured {
            let (columns, name) = (&mut self.columns, buses.name(frame.bus));
            put!(out; colour::named("quiet"));
            columns.source(out, stamp.as_ref(), name, frame);
            put!(out; colour::PLAIN, colour::node(events.first().and_then(|event| event.node)));
            columns.identifier(out, frame);
            put!(out; colour::PLAIN);
            length(out, frame);
            data(out, frame);
            return self.comment(out, frame, events);
        }
        if let Some(stamp) = &stamp {
            self.columns.stamp(out, stamp);
        }
        let name = buses.name(frame.bus);
        match PdoForm::of(frame, events).filter(|_| self.depth == Depth::Default) {
            Some((form, pdo)) => {
                if !self.known.put(out, &form, frame, self.columns.layout()) {
                    self.process_data(out, (&form, pdo), frame, name);
                }
                if !form.ends(pdo) {
                    words::pdo::signals(out, self.lang, pdo, frame);
                }
                out.push(b'\n');
            }
            None => {
                self.columns.known_columns(out, name, frame);
                data(out, frame);
                self.comment(out, frame, events);
            }
        }
    }

    /// Appends the line of a PDO from the bus to its signals, and keeps it.
    fn process_data(&mut self, out: &mut Vec<u8>, (form, pdo): (&PdoForm, &ProcessData), frame: &Frame, name: &[u8]) {
        let start = out.len();
        self.columns.known_columns(out, name, frame);
        let place = out.len() - start;
        data(out, frame);
        put!(out; "  # ");
        words::pdo::beginning(out, self.lang, self.depth, pdo, frame.len);
        self.known.keep(form, out.get(start..).unwrap_or_default(), place, self.columns.layout());
    }

    /// Appends what a frame's events say, behind its columns and below them.
    fn comment(&mut self, out: &mut Vec<u8>, frame: &Frame, events: &[Event]) {
        put!(out; "  # ");
        let mut said = false;
        for event in events {
            said |= !self.fold(event) && self.said(out, event, frame);
        }
        if !said {
            out.push(b'\n');
        }
    }

    /// Appends the output of `write`, in a colour if colours are used.
    fn dyed(&self, out: &mut Vec<u8>, colour: impl FnOnce() -> &'static str, write: impl FnOnce(&mut Vec<u8>)) {
        if !self.look.coloured {
            return write(out);
        }
        let colour = colour();
        let start = out.len() + colour.len();
        put!(out; colour);
        write(out);
        // A colour ends with the first line: below it is what explains it.
        let end = out.get(start..).and_then(|said| said.iter().position(|byte| *byte == b'\n'));
        let end = end.map_or(out.len(), |end| start + end);
        out.splice(end..end, colour::PLAIN.bytes());
    }

    /// A line that stands out by itself.
    pub fn emphasized(&self, out: &mut Vec<u8>, write: impl FnOnce(&mut Vec<u8>)) {
        self.dyed(out, || colour::named("own"), write);
    }

    /// One frame's line by itself: neither stamp nor bus, and nothing below it; no line end. `event`: its own one.
    pub fn alone(&mut self, out: &mut Vec<u8>, frame: &Frame, event: Option<&Event>) {
        self.columns.head(out, None, &[], frame);
        data(out, frame);
        if let Some(event) = event {
            put!(out; "  # ");
            let from = out.len();
            self.said(out, event, frame);
            let line = out.get(from..).and_then(|said| said.iter().position(|byte| *byte == b'\n'));
            out.truncate(line.map_or(out.len(), |line| from + line));
        }
    }

    /// Appends an event's text in whole lines: a frame's own event after its data, others below it. Returns true for
    /// the frame's own.
    pub fn said(&self, out: &mut Vec<u8>, event: &Event, frame: &Frame) -> bool {
        let service = match &event.what {
            What::Message(message) => message.service(),
            What::Pdo(_) | What::Mpdo(_) => "pdo",
            What::Sdo(_) => "sdo",
            _ => {
                self.aside(out, event, frame.no);
                return false;
            }
        };
        self.dyed(out, || colour::named(service), |out| self.own(out, event, frame));
        true
    }

    /// Appends the text of a frame's own event.
    fn own(&self, out: &mut Vec<u8>, event: &Event, frame: &Frame) {
        match &event.what {
            What::Message(message) => {
                words::message(out, self.lang, self.depth, message, frame);
                out.push(b'\n');
                if self.depth == Depth::Explain {
                    explain::services::message(out, self.lang, message, frame);
                }
            }
            What::Pdo(data) => {
                words::pdo::process_data(out, self.lang, self.depth, data, frame);
                out.push(b'\n');
                if self.depth == Depth::Explain {
                    explain::pdo::process_data(out, self.lang, data, frame);
                }
            }
            What::Mpdo(data) => {
                words::pdo::multiplex(out, self.lang, self.depth, data);
                out.push(b'\n');
                if self.depth == Depth::Explain {
                    explain::services::message(out, self.lang, &data.message(), frame);
                }
            }
            What::Sdo(step) => {
                words::sdo::step(out, self.lang, self.depth, step, frame.len);
                out.push(b'\n');
                if self.depth == Depth::Explain {
                    explain::sdo::step(out, self.lang, step, event.node.unwrap_or(0), frame);
                }
            }
            What::Transfer(_) | What::Note(_) | What::Change(_) | What::Finding(_) => {}
        }
    }

    /// Appends the events known only at the end of the capture.
    pub fn end(&mut self, out: &mut Vec<u8>, events: &[Event]) {
        for event in events {
            if !self.fold(event) {
                self.aside(out, event, 0);
            }
        }
    }

    /// Counts a consequence that has no line of its own; gives whether it did.
    fn fold(&mut self, event: &Event) -> bool {
        let (Some(folded), What::Finding(finding)) = (&mut self.folded, &event.what) else { return false };
        let Some(cause) = finding.because_of else { return false };
        if folded.len() >= CAUSES && !folded.contains_key(&cause.no) {
            return false;
        }
        *folded.entry(cause.no).or_default().entry(finding.code).or_default() += finding.facts.count();
        true
    }

    /// The consequences that have no lines of their own: a line for each cause.
    pub fn finish(&mut self, out: &mut Vec<u8>) {
        let Some(folded) = self.folded.as_mut().filter(|_| self.depth != Depth::Brief) else { return };
        for (cause, rules) in std::mem::take(folded) {
            self.dyed(
                out,
                || colour::severity(Severity::Info),
                |out| {
                    put!(out; "#   ");
                    findings::consequences(out, self.lang, cause, &rules);
                    out.push(b'\n');
                },
            );
        }
    }

    /// A note, a finding, or a transfer whose result belongs to an earlier frame, on a line of its own.
    ///
    /// `under`: the frame below whose line it stands; 0 for none.
    pub fn aside(&self, out: &mut Vec<u8>, event: &Event, under: u64) {
        if self.depth == Depth::Brief {
            return;
        }
        let colour = || match &event.what {
            What::Finding(finding) => colour::severity(finding.severity()),
            _ => colour::named("quiet"),
        };
        match &event.what {
            What::Finding(finding) => self.dyed(out, colour, |out| {
                let rule = finding.code.rule();
                put!(out; "#   ", rule.id, " ");
                put!(out; findings::severity(self.lang, finding.severity()), ": ");
                findings::placed(out, self.lang, finding, under);
                out.push(b'\n');
            }),
            What::Note(note) => self.dyed(out, colour, |out| {
                let about = event.about.as_ref().map_or(event.at.no, |about| about.no);
                put!(out; "#   ");
                notes::note(out, self.lang, *note, about);
                out.push(b'\n');
            }),
            What::Transfer(transfer) if event.about.is_some() => self.dyed(out, colour, |out| {
                put!(out; "#   ");
                words::sdo::later_result(out, self.lang, transfer);
                out.push(b'\n');
            }),
            // A frame of USDO has no word of its transfer itself.
            What::Transfer(transfer) if transfer.session.is_some() => self.dyed(out, colour, |out| {
                put!(out; "#   ");
                words::sdo::result(out, self.lang, transfer);
                out.push(b'\n');
            }),
            What::Transfer(_) | What::Change(_) | What::Message(_) | What::Pdo(_) | What::Mpdo(_) | What::Sdo(_) => {}
        }
    }

    /// A line of the capture that is no frame, in the form in which readers take it.
    pub fn marker(&mut self, out: &mut Vec<u8>, marker: &Marker, buses: &Buses) {
        match *marker {
            Marker::Dropped { bus, count, total, .. } => dropped(out, buses.name(bus), count, total),
            Marker::LeftOut { count, .. } => left_out(out, count),
            Marker::Error { bus, stamp, .. } => self.columns.error(out, stamp.as_ref(), buses.name(bus)),
            Marker::Backward { .. } | Marker::Start { .. } | Marker::Swapped => {}
        }
    }

    /// The stamp that is shown.
    fn stamp(&mut self, frame: &Frame) -> Option<Stamp> {
        let stamp = frame.stamp?;
        let Some(time) = self.clock.time else { return Some(stamp) };
        let now = frame.t_ns.unwrap_or(stamp.ns);
        let last = self.last_ns.replace(now).unwrap_or(now);
        let (ns, form) = match time {
            Time::Delta => (now - last, StampForm::Seconds),
            _ => self.clock.moment(now)?,
        };
        Some(Stamp { form, ns, width: 3, decimals: stamp.decimals })
    }
}

/// One frame by itself, with its breakdown: no history, so nothing is said of its place.
pub fn explain(out: &mut Vec<u8>, lang: Lang, frame: &Frame, buses: &Buses) {
    let what = match predefined(frame.id) {
        Role::SdoRequest(node) if frame.kind == Kind::Data => (Some(node), What::Sdo(Step::alone(Side::Client, frame))),
        Role::SdoResponse(node) if frame.kind == Kind::Data => {
            (Some(node), What::Sdo(Step::alone(Side::Server, frame)))
        }
        role => (None, What::Message(wire::decode(role, frame))),
    };
    let (node, what) = what;
    let event = Event { at: frame.reference(), about: None, bus: frame.bus, node, transfer: None, what };
    Lines::new(lang, Depth::Explain, None).frame(out, frame, &[event], buses);
}

/// The data, filled up to the column of the comments.
fn data(out: &mut Vec<u8>, frame: &Frame) {
    // Eight bytes in one piece: what nearly every frame needs.
    let payload = frame.payload();
    let mut field = [0; known::DATA];
    known::put_data(&mut field, frame.head(), payload.len().min(8) as u8);
    if frame.kind == Kind::Remote {
        for (slot, byte) in field.iter_mut().zip(b" remote request") {
            *slot = *byte;
        }
    }
    out.extend_from_slice(&field);
    for byte in payload.iter().skip(8) {
        out.push(b' ');
        out.extend_from_slice(&hex_digits(*byte));
    }
    if frame.kind == Kind::Error {
        put!(out; "   ERRORFRAME");
    }
}

#[cfg(test)]
mod tests;

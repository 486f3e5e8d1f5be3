//! Lines for people, in candump's console form, so that the output is input again.
//!
//! `can1  60A   [8]  40 08 10 00 00 00 00 00  # ...`: stamp, direction and length as they came; everything else
//! is a comment. Notes and findings stand on lines of their own that begin with `#`. The columns before the data are
//! those of `writers::console`.

use crate::cob_id::{Role, predefined};
use crate::event::{Event, Step, What};
use crate::frame::{Buses, Frame, Kind, Stamp, StampForm};
use crate::readers::Marker;
use crate::services;
use crate::services::sdo::wire::Side;
use crate::text::digits::{hex_digits, put};
use crate::text::{Depth, Lang, en, explain, zh};
use crate::writers::console::{Columns, dropped};

/// How time is shown (option `-t`, as candump's).
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

/// The column in which comments begin, counted from the first data byte: eight bytes and their blanks.
const DATA_WIDTH: usize = 23;

/// The text renderer: what the lines so far decide of the next ones.
#[derive(Debug)]
pub struct Lines {
    lang: Lang,
    depth: Depth,
    time: Option<Time>,
    columns: Columns,
    /// The date that the stamps of the next frames count from, where one is known.
    pub date_ns: Option<i64>,
    first_ns: Option<i64>,
    last_ns: Option<i64>,
}

impl Lines {
    /// A renderer at the beginning of a capture.
    pub fn new(lang: Lang, depth: Depth, time: Option<Time>) -> Self {
        Self { lang, depth, time, columns: Columns::default(), date_ns: None, first_ns: None, last_ns: None }
    }

    /// One frame's line, and below it what else it shows.
    pub fn frame(&mut self, out: &mut Vec<u8>, frame: &Frame, events: &[Event], buses: &Buses) {
        let stamp = self.stamp(frame);
        self.columns.head(out, stamp.as_ref(), buses.name(frame.bus), frame);
        data(out, frame);
        put!(out; "  # ");
        let mut said = false;
        for event in events {
            said |= self.said(out, event, frame);
        }
        if !said {
            out.push(b'\n');
        }
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

    /// What one of a frame's events says, in whole lines. Its own one stands behind the frame's data, others below it.
    /// Gives whether it is its own.
    pub fn said(&self, out: &mut Vec<u8>, event: &Event, frame: &Frame) -> bool {
        match &event.what {
            What::Message(message) => {
                match self.lang {
                    Lang::Zh => zh::services::message(out, self.depth, message, frame),
                    Lang::En => en::services::message(out, self.depth, message, frame),
                }
                out.push(b'\n');
                if self.depth == Depth::Explain {
                    explain::services::message(out, self.lang, message, frame);
                }
            }
            What::Pdo(data) => {
                match self.lang {
                    Lang::Zh => zh::pdo::process_data(out, self.depth, data, frame),
                    Lang::En => en::pdo::process_data(out, self.depth, data, frame),
                }
                out.push(b'\n');
                if self.depth == Depth::Explain {
                    explain::pdo::process_data(out, self.lang, data, frame);
                }
            }
            What::Mpdo(data) => {
                match self.lang {
                    Lang::Zh => zh::pdo::multiplexed(out, self.depth, data),
                    Lang::En => en::pdo::multiplexed(out, self.depth, data),
                }
                out.push(b'\n');
                if self.depth == Depth::Explain {
                    explain::services::message(out, self.lang, &data.message(), frame);
                }
            }
            What::Sdo(step) => {
                match self.lang {
                    Lang::Zh => zh::sdo::step(out, self.depth, step, frame.len),
                    Lang::En => en::sdo::step(out, self.depth, step, frame.len),
                }
                out.push(b'\n');
                if self.depth == Depth::Explain {
                    explain::sdo::step(out, self.lang, step, event.node.unwrap_or(0), frame);
                }
            }
            _ => {
                self.aside(out, event, frame.no);
                return false;
            }
        }
        true
    }

    /// What is known only at the end of the capture.
    pub fn end(&self, out: &mut Vec<u8>, events: &[Event]) {
        for event in events {
            self.aside(out, event, 0);
        }
    }

    /// A note, a finding, or a transfer whose result belongs to an earlier frame, on a line of its own.
    ///
    /// `under`: the frame below whose line it stands; 0 for none.
    pub fn aside(&self, out: &mut Vec<u8>, event: &Event, under: u64) {
        if self.depth == Depth::Brief {
            return;
        }
        match &event.what {
            What::Finding(finding) => {
                let rule = finding.code.rule();
                put!(out; "#   ", rule.id, " ");
                // Under its own frame's line the frame needs no name, nor where the sentence names it.
                let named = finding.cause.is_some_and(|cause| cause.no == finding.at.no);
                let elsewhere = (finding.at.no != under && !named).then_some(finding.at.no);
                match self.lang {
                    Lang::Zh => {
                        put!(out; zh::findings::severity(finding.severity()), ": ");
                        zh::findings::place(out, elsewhere, finding.node);
                        zh::findings::message(out, finding);
                    }
                    Lang::En => {
                        put!(out; en::findings::severity(finding.severity()), ": ");
                        en::findings::place(out, elsewhere, finding.node);
                        en::findings::message(out, finding);
                    }
                }
                out.push(b'\n');
            }
            What::Note(note) => {
                let about = event.about.map_or(event.at.no, |about| about.no);
                put!(out; "#   ");
                match self.lang {
                    Lang::Zh => zh::findings::note(out, *note, about),
                    Lang::En => en::findings::note(out, *note, about),
                }
                out.push(b'\n');
            }
            What::Transfer(transfer) if event.about.is_some() => {
                put!(out; "#   ");
                match self.lang {
                    Lang::Zh => zh::sdo::later_result(out, transfer),
                    Lang::En => en::sdo::later_result(out, transfer),
                }
                out.push(b'\n');
            }
            What::Transfer(_) | What::Message(_) | What::Pdo(_) | What::Mpdo(_) | What::Sdo(_) => {}
        }
    }

    /// A line of the capture that is no frame, in the form in which readers take it.
    pub fn marker(&mut self, out: &mut Vec<u8>, marker: &Marker, buses: &Buses) {
        match *marker {
            Marker::Dropped { bus, count, total, .. } => dropped(out, buses.name(bus), count, total),
            Marker::Error { bus, stamp, .. } => self.columns.error(out, stamp.as_ref(), buses.name(bus)),
            Marker::Backward { .. } | Marker::Start { .. } => {}
        }
    }

    /// The stamp that is shown.
    fn stamp(&mut self, frame: &Frame) -> Option<Stamp> {
        let stamp = frame.stamp?;
        let Some(time) = self.time else { return Some(stamp) };
        let now = frame.t_ns.unwrap_or(stamp.ns);
        let first = *self.first_ns.get_or_insert(now);
        let last = self.last_ns.replace(now).unwrap_or(now);
        let seconds = |ns| Stamp { form: StampForm::Seconds, ns, width: 3, decimals: stamp.decimals };
        let moment = now.saturating_add(self.date_ns.unwrap_or(0));
        match time {
            Time::None => None,
            Time::Absolute => Some(seconds(moment)),
            Time::Delta => Some(seconds(now.saturating_sub(last))),
            Time::Zero => Some(seconds(now.saturating_sub(first))),
            Time::Date => Some(Stamp { form: StampForm::Calendar, ..seconds(moment) }),
        }
    }
}

/// One frame by itself, with its breakdown: no history, so nothing is said of its place.
pub fn explain(out: &mut Vec<u8>, lang: Lang, frame: &Frame, buses: &Buses) {
    let what = match predefined(frame.id) {
        Role::SdoRequest(node) if frame.kind == Kind::Data => (Some(node), What::Sdo(Step::alone(Side::Client, frame))),
        Role::SdoResponse(node) if frame.kind == Kind::Data => {
            (Some(node), What::Sdo(Step::alone(Side::Server, frame)))
        }
        role => (None, What::Message(services::decode(role, frame))),
    };
    let (node, what) = what;
    let event = Event { at: frame.reference(), about: None, bus: frame.bus, node, transfer: None, what };
    Lines::new(lang, Depth::Explain, None).frame(out, frame, &[event], buses);
}

/// The data, filled up to the column of the comments.
fn data(out: &mut Vec<u8>, frame: &Frame) {
    out.push(b' ');
    // Eight bytes in one piece: what nearly every frame needs.
    let mut field = [b' '; DATA_WIDTH];
    let payload = frame.payload();
    if frame.kind == Kind::Remote {
        for (slot, byte) in field.iter_mut().zip(b"remote request") {
            *slot = *byte;
        }
    }
    for (slots, byte) in field.chunks_mut(3).zip(payload) {
        if let [high, low, ..] = slots {
            [*high, *low] = hex_digits(*byte);
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

//! Lines for people, in candump's console form, so that the output is input again.
//!
//! `can1  60A   [8]  40 08 10 00 00 00 00 00  # ...`: stamp, direction and length as they came; everything else
//! is a comment. Notes and findings stand on lines of their own that begin with `#`. Formatting is by hand: it
//! costs more than decoding.

use crate::cob_id::{Role, predefined};
use crate::event::{Event, Step, What};
use crate::frame::{Buses, Direction, Frame, Kind, Stamp, StampForm};
use crate::readers::Marker;
use crate::services;
use crate::services::sdo::wire::Side;
use crate::text::digits::{Hex, Padded, hex_digits, put};
use crate::text::{Depth, Lang, en, escape, explain, zh};

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
/// Longest bus name for which columns are aligned.
const NAME_WIDTH: usize = 16;

/// The text renderer: what the lines so far decide of the next ones.
#[derive(Debug)]
pub struct Lines {
    lang: Lang,
    depth: Depth,
    time: Option<Time>,
    /// Widest bus name so far; candump aligns them to the right.
    width: usize,
    /// A 29-bit identifier was seen: 11-bit ones are indented from then on, as candump does.
    indent: bool,
    first_ns: Option<i64>,
    last_ns: Option<i64>,
}

impl Lines {
    /// A renderer at the beginning of a capture.
    pub fn new(lang: Lang, depth: Depth, time: Option<Time>) -> Self {
        Self { lang, depth, time, width: 0, indent: false, first_ns: None, last_ns: None }
    }

    /// One frame's line, and below it what else it shows.
    pub fn frame(&mut self, out: &mut Vec<u8>, frame: &Frame, events: &[Event], buses: &Buses) {
        self.stamp(out, frame);
        self.bus(out, buses.name(frame.bus));
        direction(out, frame);
        self.identifier(out, frame);
        length(out, frame);
        data(out, frame);
        put!(out; "  # ");
        let mut said = false;
        for event in events {
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
                    said = true;
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
                    said = true;
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
                    said = true;
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
                    said = true;
                }
                _ => self.aside(out, event, frame.no),
            }
        }
        if !said {
            out.push(b'\n');
        }
    }

    /// What is known only at the end of the capture.
    pub fn end(&self, out: &mut Vec<u8>, events: &[Event]) {
        for event in events {
            self.aside(out, event, 0);
        }
    }

    /// A note, a finding, or a transfer whose result belongs to an earlier frame, on a line of its own.
    fn aside(&self, out: &mut Vec<u8>, event: &Event, under: u64) {
        if self.depth == Depth::Brief {
            return;
        }
        match &event.what {
            What::Finding(finding) => {
                let rule = finding.code.rule();
                put!(out; "#   ", rule.id, " ");
                // Under its own frame's line the frame needs no name.
                let elsewhere = (finding.at.no != under).then_some(finding.at.no);
                match self.lang {
                    Lang::Zh => {
                        put!(out; zh::findings::severity(rule.severity), ": ");
                        zh::findings::place(out, elsewhere);
                        zh::findings::message(out, finding);
                    }
                    Lang::En => {
                        put!(out; en::findings::severity(rule.severity), ": ");
                        en::findings::place(out, elsewhere);
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
            Marker::Dropped { bus, count, total, .. } => {
                put!(out; "DROPCOUNT: dropped ", count, if count == 1 { " CAN frame on '" } else { " CAN frames on '" });
                escape::terminal(out, buses.name(bus));
                put!(out; "' socket (total drops ", total, ")\n");
            }
            Marker::Error { bus, stamp, .. } => {
                if let Some(stamp) = stamp {
                    written(out, &stamp);
                }
                self.bus(out, buses.name(bus));
                put!(out; "ERROR\n");
            }
            Marker::Backward { .. } | Marker::Start { .. } => {}
        }
    }

    fn stamp(&mut self, out: &mut Vec<u8>, frame: &Frame) {
        let Some(stamp) = &frame.stamp else { return };
        let Some(time) = self.time else { return written(out, stamp) };
        let now = frame.t_ns.unwrap_or(stamp.ns);
        let first = *self.first_ns.get_or_insert(now);
        let last = self.last_ns.replace(now).unwrap_or(now);
        let seconds = |ns| Stamp { form: StampForm::Seconds, ns, width: 3, decimals: stamp.decimals };
        match time {
            Time::None => {}
            Time::Absolute => written(out, &seconds(now)),
            Time::Delta => written(out, &seconds(now.saturating_sub(last))),
            Time::Zero => written(out, &seconds(now.saturating_sub(first))),
            Time::Date => written(out, &Stamp { form: StampForm::Calendar, ..seconds(now) }),
        }
    }

    fn bus(&mut self, out: &mut Vec<u8>, name: &[u8]) {
        if name.is_empty() {
            return;
        }
        self.width = self.width.max(name.len().min(NAME_WIDTH));
        for _ in name.len()..self.width {
            out.push(b' ');
        }
        if name.iter().all(u8::is_ascii_graphic) {
            out.extend_from_slice(name);
        } else {
            escape::terminal(out, name);
        }
        put!(out; "  ");
    }

    fn identifier(&mut self, out: &mut Vec<u8>, frame: &Frame) {
        let raw = u64::from(frame.id.raw());
        if frame.kind == Kind::Error {
            put!(out; Hex::<8>(raw | 0x2000_0000));
        } else if frame.id.is_extended() {
            self.indent = true;
            put!(out; Hex::<8>(raw));
        } else {
            if self.indent {
                put!(out; "     ");
            }
            put!(out; Hex::<3>(raw));
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

/// A stamp with its digits as they were written.
fn written(out: &mut Vec<u8>, stamp: &Stamp) {
    let (seconds, fraction) = (stamp.ns.div_euclid(1_000_000_000), stamp.ns.rem_euclid(1_000_000_000) as u32);
    put!(out; "(");
    match stamp.form {
        StampForm::Seconds => {
            // Right to left into a buffer: `{:0width$}` of the formatting machinery costs five times as much.
            let mut digits = [b'0'; 20];
            let mut rest = seconds.unsigned_abs();
            let mut count = 0;
            for slot in digits.iter_mut().rev() {
                *slot = b'0' + (rest % 10) as u8;
                rest /= 10;
                count += 1;
                if rest == 0 {
                    break;
                }
            }
            let shown = usize::from(stamp.width).clamp(count, digits.len());
            out.extend_from_slice(digits.get(digits.len() - shown..).unwrap_or(&digits));
        }
        StampForm::Calendar => calendar(out, seconds),
    }
    decimals(out, fraction, stamp.decimals);
    put!(out; ")  ");
}

/// `2026-09-15 18:44:56.479963`, of ns since 1970-01-01.
pub(in crate::render) fn date(out: &mut Vec<u8>, ns: i64, digits: u8) {
    calendar(out, ns.div_euclid(1_000_000_000));
    decimals(out, ns.rem_euclid(1_000_000_000) as u32, digits);
}

/// A fraction of a second after its point, to so many digits.
fn decimals(out: &mut Vec<u8>, fraction: u32, count: u8) {
    if count == 0 {
        return;
    }
    let mut digits = *b".000000000";
    let mut rest = fraction;
    for slot in digits.iter_mut().skip(1).rev() {
        *slot = b'0' + (rest % 10) as u8;
        rest /= 10;
    }
    out.extend_from_slice(digits.get(..=usize::from(count.min(9))).unwrap_or(&digits));
}

/// `2026-09-15 18:44:56` of seconds since 1970-01-01, by the proleptic Gregorian calendar.
fn calendar(out: &mut Vec<u8>, seconds: i64) {
    let (days, second) = (seconds.div_euclid(86_400), seconds.rem_euclid(86_400) as u64);
    // Years begin in March, so that the leap day is a year's last; 719 468 days lie between 0000-03-01 and 1970-01-01.
    let shifted = days.saturating_add(719_468);
    let (era, day) = (shifted.div_euclid(146_097), shifted.rem_euclid(146_097));
    let year_of_era = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day_of_year = day - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day_of_month = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = year_of_era.saturating_add(era.saturating_mul(400)) + i64::from(month <= 2);
    put!(out; Padded::<4>(year.unsigned_abs()), "-", Padded::<2>(month.unsigned_abs()), "-");
    put!(out; Padded::<2>(day_of_month.unsigned_abs()), " ", Padded::<2>(second / 3600), ":");
    put!(out; Padded::<2>(second / 60 % 60), ":", Padded::<2>(second % 60));
}

/// `TX - -  `, where the capture tells; B and E are the flags of an FD frame.
fn direction(out: &mut Vec<u8>, frame: &Frame) {
    let Some(dir) = frame.dir else { return };
    let (brs, esi) = match frame.kind {
        Kind::Fd { brs, esi } => (brs, esi),
        _ => (false, false),
    };
    put!(out; match dir {
        Direction::Rx => "RX ",
        Direction::Tx => "TX ",
    });
    put!(out; if brs { "B " } else { "- " }, if esi { "E  " } else { "-  " });
}

fn length(out: &mut Vec<u8>, frame: &Frame) {
    let form = frame.length_form;
    if matches!(frame.kind, Kind::Fd { .. }) || form.two_digits {
        put!(out; "  [", Padded::<2>(u64::from(frame.len)), "]  ");
    } else if form.braces || form.raw_dlc > 8 {
        put!(out; "   {", Hex::<1>(u64::from(form.raw_dlc.max(frame.len))), "}  ");
    } else {
        put!(out; "   [", frame.len, "]  ");
    }
}

fn data(out: &mut Vec<u8>, frame: &Frame) {
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

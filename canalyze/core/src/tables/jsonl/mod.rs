//! JSON lines: one object a line. Keys are only ever added, never renamed.
//!
//! Hexadecimal numbers are upper-case strings without prefix, bytes are hex strings, `t` is a decimal string of
//! seconds with all its digits or null, integers beyond 2^53 are decimal strings, `line` is null for binary formats.
//!
//! | kind | keys |
//! |---|---|
//! | `frame` | `frame line file t bus dir id ext rtr fd err len data service node text findings`, then an object named after the service with its fields |
//! | `note` | `note frame line about_frame about_line bus node transfer text facts` |
//! | `finding` | `code name severity file frame line t cause_frame cause_line about_frame because_of bus node index sub message facts`, in `check` also `lines` |
//! | `transfer` | see [`transfer`] |
//! | `line` | `frame text`: what [`super::text`] writes of a frame, without the last line end |
//! | `summary_...` | see [`summary`] |
//! | `observed_...` | see [`observed`] |
//! | `difference`, `diff` | see [`diff`] |
//! | `incident`, `diagnosis` | see [`diagnosis`] |
//! | `od_node`, `od_object`, `od_value` | see [`inventory`] |
//!
//! `name` of a code, a state or an object is the description's or that of the standard in English, whatever the language;
//! `text`, `message`, and what ends in `_text` are for people, in theirs.
//!
//! `fd` is `{"brs","esi"}` for an FD frame, else false. `text` is the default line's words. `findings` are the codes
//! raised at the frame, each of which has its own `finding` line after it. Its `message` is about `cause_frame`, where
//! there is one. `lines` are the annotated lines of its context, `{"frame","text"}` each, oldest first.

mod contents;
pub mod diagnosis;
pub mod diff;
pub mod facts;
mod info;
pub mod inventory;
pub(crate) mod obj;
pub(crate) mod object;
pub mod observed;
mod pdo;
pub mod pdos;
pub mod sdo;
pub mod services;
pub mod summary;

use crate::bytes::frame::{Buses, Direction, Frame, Kind, Stamp, StampForm};
use crate::bytes::writers::console;
use crate::rules::finding::Finding;
use crate::views::finding_context::HeldFrame;
use crate::views::lines::{Clocked, Lines};
use crate::words::digits::{Hex, Joined, fraction, put};
use crate::words::{Depth, Lang, escape, findings, notes, services as words};
use crate::world::event::{Event, Note, Scanned, What};

pub use contents::contents;
pub use info::{DAMAGES, info};
pub(super) use pdo::marked;
pub use sdo::transfer;

/// The language of names in machine output: one, whatever that of the texts is.
pub const NAMES: Lang = Lang::En;

/// What JSON lines need to know beside the events.
#[derive(Clone, Copy, Debug)]
pub struct Setting<'a> {
    /// The language of `text` and `message`; names are the same in every language.
    pub lang: Lang,
    /// The name of the file.
    pub file: &'a [u8],
    /// The names of the buses.
    pub buses: &'a Buses,
    /// Digits after the point of the capture's stamps.
    pub decimals: u8,
    /// How moments are written, and in lines the time.
    pub clock: Clocked,
}

impl Setting<'_> {
    /// A moment in the form that is asked for, or null.
    pub(in crate::tables) fn moment(&self, out: &mut Vec<u8>, t_ns: Option<i64>) {
        match t_ns.and_then(|t_ns| self.clock.moment(t_ns)) {
            Some((ns, StampForm::Calendar)) => {
                put!(out; "\"");
                console::digits(out, &Stamp { form: StampForm::Calendar, ns, width: 0, decimals: self.decimals });
                put!(out; "\"");
            }
            moment => seconds(out, moment.map(|(ns, _)| ns), self.decimals),
        }
    }
}

/// One frame's object, and what follows from it.
pub fn frame(out: &mut Vec<u8>, setting: Setting<'_>, frame: &Frame, events: &[Event]) {
    put!(out; "{\"kind\":\"frame\",\"frame\":", frame.no, ",\"line\":");
    number_or_null(out, frame.line);
    put!(out; ",\"file\":");
    escape::json(out, setting.file);
    put!(out; ",\"t\":");
    seconds(out, frame.t_ns, frame.stamp.map_or(9, |stamp| stamp.decimals));
    put!(out; ",\"bus\":");
    bus_name(out, setting, frame);
    put!(out; match frame.dir {
        None => ",\"dir\":null",
        Some(Direction::Rx) => ",\"dir\":\"rx\"",
        Some(Direction::Tx) => ",\"dir\":\"tx\"",
    });
    let raw = u64::from(frame.id.raw());
    put!(out; ",\"id\":\"");
    if frame.id.is_extended() {
        put!(out; Hex::<8>(raw))
    } else {
        put!(out; Hex::<3>(raw))
    }
    let error = frame.kind == Kind::Error;
    put!(out; "\",\"ext\":", truth(frame.id.is_extended() && !error), ",\"rtr\":", truth(frame.kind == Kind::Remote));
    match frame.kind {
        Kind::Fd { brs, esi } => put!(out; ",\"fd\":{\"brs\":", truth(brs), ",\"esi\":", truth(esi), "}"),
        _ => put!(out; ",\"fd\":false"),
    }
    put!(out; ",\"err\":", truth(error), ",\"len\":", frame.len);
    put!(out; ",\"data\":\"", Joined(frame.payload()), "\"");
    for event in events {
        match &event.what {
            What::Message(message) => {
                let service = message.service();
                put!(out; ",\"service\":\"", service, "\",\"node\":");
                number_or_null(out, event.node.map(u64::from));
                put!(out; ",\"text\":");
                quoted(out, |text| words::message(text, setting.lang, Depth::Default, message, frame));
                codes(out, events);
                put!(out; ",\"", service, "\":");
                services::fields(out, message, frame);
            }
            What::Pdo(data) => {
                put!(out; ",\"service\":\"pdo\",\"node\":");
                number_or_null(out, event.node.map(u64::from));
                put!(out; ",\"text\":");
                quoted(out, |text| words::pdo::process_data(text, setting.lang, Depth::Default, data, frame));
                codes(out, events);
                put!(out; ",\"pdo\":");
                pdo::fields(out, setting.lang, data, frame);
            }
            What::Mpdo(data) => {
                put!(out; ",\"service\":\"pdo\",\"node\":");
                number_or_null(out, event.node.map(u64::from));
                put!(out; ",\"text\":");
                quoted(out, |text| words::pdo::multiplex(text, setting.lang, Depth::Default, data));
                codes(out, events);
                put!(out; ",\"pdo\":");
                services::multiplexed(out, setting.lang, data, frame);
            }
            What::Sdo(step) => {
                put!(out; ",\"service\":\"sdo\",\"node\":");
                number_or_null(out, event.node.map(u64::from));
                put!(out; ",\"text\":");
                quoted(out, |text| words::sdo::step(text, setting.lang, Depth::Default, step, frame.len));
                codes(out, events);
                put!(out; ",\"sdo\":");
                sdo::fields(out, step, event.transfer, frame);
            }
            _ => {}
        }
    }
    put!(out; "}\n");
    asides(out, setting, events);
}

/// Notes, findings and ended transfers, an object each.
pub fn asides(out: &mut Vec<u8>, setting: Setting<'_>, events: &[Event]) {
    for event in events {
        match &event.what {
            What::Note(what) => note(out, setting, event, *what),
            What::Finding(what) => finding(out, setting, what),
            What::Transfer(what) => transfer(out, setting, what, NAMES),
            What::Message(_) | What::Pdo(_) | What::Mpdo(_) | What::Sdo(_) => {}
        }
    }
}

/// A finding's object.
pub fn finding(out: &mut Vec<u8>, setting: Setting<'_>, finding: &Finding) {
    found(out, setting, finding);
    put!(out; "}\n");
}

/// A finding's object with the lines of its context.
pub fn finding_with_lines(out: &mut Vec<u8>, setting: Setting<'_>, finding: &Finding, context: &[&HeldFrame]) {
    found(out, setting, finding);
    put!(out; ",\"lines\":[");
    let mut lines = Lines::new(setting.lang, Depth::Default, None);
    lines.clock = setting.clock;
    for (place, held) in context.iter().enumerate() {
        put!(out; if place == 0 { "" } else { "," }, "{\"frame\":", held.frame.no, ",\"text\":");
        quoted(out, |text| {
            lines.frame(text, &held.frame, held.event.as_slice(), setting.buses);
            text.pop();
        });
        put!(out; "}");
    }
    put!(out; "]}\n");
}

fn found(out: &mut Vec<u8>, setting: Setting<'_>, finding: &Finding) {
    let rule = finding.code.rule();
    put!(out; "{\"kind\":\"finding\",\"code\":\"", rule.id, "\",\"name\":\"", rule.name);
    put!(out; "\",\"severity\":\"", finding.severity().name(), "\",\"file\":");
    escape::json(out, setting.file);
    put!(out; ",\"frame\":");
    number_or_null(out, (finding.at.no > 0).then_some(finding.at.no));
    put!(out; ",\"line\":");
    number_or_null(out, finding.at.line);
    put!(out; ",\"t\":");
    setting.moment(out, finding.at.t_ns);
    put!(out; ",\"cause_frame\":");
    number_or_null(out, finding.cause.map(|cause| cause.no));
    put!(out; ",\"cause_line\":");
    number_or_null(out, finding.cause.and_then(|cause| cause.line));
    put!(out; ",\"about_frame\":");
    number_or_null(out, finding.about().map(|about| about.no));
    put!(out; ",\"because_of\":");
    number_or_null(out, finding.because_of.map(|cause| cause.no));
    put!(out; ",\"bus\":");
    name_or_null(out, setting.buses.name(finding.bus));
    put!(out; ",\"node\":");
    number_or_null(out, finding.node.map(u64::from));
    match finding.object {
        Some(mux) => put!(out; ",\"index\":\"", Hex::<4>(u64::from(mux.index)), "\",\"sub\":", mux.sub),
        None => put!(out; ",\"index\":null,\"sub\":null"),
    }
    put!(out; ",\"message\":");
    quoted(out, |text| findings::message(text, setting.lang, finding));
    put!(out; ",\"facts\":");
    facts::facts(out, finding);
}

/// What `write` says of the frame of this number, for people.
pub fn line(out: &mut Vec<u8>, frame: u64, write: impl FnOnce(&mut Vec<u8>)) {
    put!(out; "{\"kind\":\"line\",\"frame\":", frame, ",\"text\":");
    quoted(out, |text| {
        write(text);
        text.pop();
    });
    put!(out; "}\n");
}

fn note(out: &mut Vec<u8>, setting: Setting<'_>, event: &Event, note: Note) {
    let about = event.about.as_deref().copied().unwrap_or(event.at);
    put!(out; "{\"kind\":\"note\",\"note\":\"", match note {
        Note::RequestNotCaptured => "request_not_captured",
        Note::LostByReset => "lost_by_reset",
        Note::LssSelected { .. } => "lss_selected",
        Note::Fastscan(Scanned { found: true, .. }) => "fastscan_found",
        Note::Fastscan(_) => "fastscan_incomplete",
        Note::BitTimingActivated { .. } => "bit_timing_activated",
        Note::NodeIdChanged { .. } => "node_id_changed",
    });
    put!(out; "\",\"frame\":", event.at.no, ",\"line\":");
    number_or_null(out, event.at.line);
    put!(out; ",\"about_frame\":", about.no, ",\"about_line\":");
    number_or_null(out, about.line);
    put!(out; ",\"bus\":");
    name_or_null(out, setting.buses.name(event.bus));
    put!(out; ",\"node\":");
    number_or_null(out, event.node.map(u64::from));
    put!(out; ",\"transfer\":");
    number_or_null(out, event.transfer.map(|id| id.0));
    put!(out; ",\"text\":");
    quoted(out, |text| notes::note(text, setting.lang, note, about.no));
    facts::note(out, note);
    put!(out; "}\n");
}

fn codes(out: &mut Vec<u8>, events: &[Event]) {
    put!(out; ",\"findings\":[");
    let mut first = true;
    for event in events {
        if let What::Finding(finding) = &event.what {
            put!(out; if first { "\"" } else { ",\"" }, finding.code.rule().id, "\"");
            first = false;
        }
    }
    put!(out; "]");
}

fn bus_name(out: &mut Vec<u8>, setting: Setting<'_>, frame: &Frame) {
    name_or_null(out, setting.buses.name(frame.bus));
}

/// A bus name, or null where the capture names none.
pub(crate) fn name_or_null(out: &mut Vec<u8>, name: &[u8]) {
    if name.is_empty() { put!(out; "null") } else { escape::json(out, name) }
}

/// A number, or null.
pub(crate) fn number_or_null(out: &mut Vec<u8>, number: Option<u64>) {
    match number {
        Some(number) => put!(out; number),
        None => put!(out; "null"),
    }
}

/// Seconds as a decimal string, or null.
pub(in crate::tables) fn seconds(out: &mut Vec<u8>, ns: Option<i64>, decimals: u8) {
    let Some(ns) = ns else { return put!(out; "null") };
    put!(out; if ns < 0 { "\"-" } else { "\"" });
    let ns = ns.unsigned_abs();
    put!(out; ns / 1_000_000_000);
    fraction(out, (ns % 1_000_000_000) as u32, decimals);
    put!(out; "\"");
}

/// `true` or `false`.
pub(crate) fn truth(yes: bool) -> &'static str {
    if yes { "true" } else { "false" }
}

/// Text as a JSON string.
pub(crate) fn quoted(out: &mut Vec<u8>, write: impl FnOnce(&mut Vec<u8>)) {
    let start = out.len();
    write(out);
    let text = out.split_off(start);
    escape::json(out, &text);
}

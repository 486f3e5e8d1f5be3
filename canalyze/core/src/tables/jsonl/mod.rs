//! JSON lines: one object a line. Keys are only ever added, never renamed.
//!
//! Hexadecimal numbers are upper-case strings without prefix, bytes are hex strings, `t` is a decimal string of
//! seconds with all its digits or null, integers beyond 2^53 are decimal strings, `line` is null for binary formats.
//!
//! Each record is declared with its keys in a file of its own: those that are tables, too, in [`super::columns`], the
//! rest here.
//!
//! `name` of a code, a state or an object is the description's or that of the standard in English, whatever the language;
//! `text`, `message`, and what ends in `_text` are for people, in theirs.

mod contents;
pub mod diagnosis;
pub mod diff;
pub mod facts;
mod info;
pub(super) mod note;
pub(crate) mod obj;
pub(crate) mod object;
pub mod observed;
pub(super) mod pdo;
pub mod pdos;
pub mod sdo;
pub mod services;
pub mod summary;

use super::columns::findings::{Findings, FoundFinding};
use super::columns::frames::{Framed, Frames};
use super::setting::seconds;
use super::table::Cx;
use crate::bytes::frame::Frame;
use crate::rules::finding::Finding;
use crate::views::finding_context::HeldFrame;
use crate::words::digits::put;
use crate::words::escape;
use crate::world::event::{Event, What, service};

pub use super::columns::transfers::line as transfer;
pub(super) use super::number::marked;
pub(crate) use super::setting::quoted;
pub use super::setting::{NAMES, Setting};
pub use contents::contents;
pub use info::{DAMAGES, info};

/// Appends a frame's object, and those of what follows from it.
pub fn frame(out: &mut Vec<u8>, setting: Setting<'_>, frame: &Frame, events: &[Event]) {
    Frames::json(out, &Cx { setting, names: NAMES }, Framed { frame, service: service(events), events });
    out.push(b'\n');
    asides(out, setting, events);
}

/// Appends notes, findings and ended transfers, an object each.
pub fn asides(out: &mut Vec<u8>, setting: Setting<'_>, events: &[Event]) {
    for event in events {
        match &event.what {
            What::Note(what) => note::line(out, setting, event, *what),
            What::Finding(what) => finding(out, setting, what),
            What::Transfer(what) => transfer(out, setting, what, NAMES),
            What::Message(_) | What::Pdo(_) | What::Mpdo(_) | What::Sdo(_) | What::Change(_) => {}
        }
    }
}

/// Appends a finding's object.
pub fn finding(out: &mut Vec<u8>, setting: Setting<'_>, finding: &Finding) {
    found(out, setting, FoundFinding { finding, context: None });
}

/// Appends a finding's object with the lines of its context.
pub fn finding_with_lines(out: &mut Vec<u8>, setting: Setting<'_>, finding: &Finding, context: &[&HeldFrame]) {
    found(out, setting, FoundFinding { finding, context: Some(context) });
}

fn found(out: &mut Vec<u8>, setting: Setting<'_>, found: FoundFinding<'_>) {
    Findings::json(out, &Cx { setting, names: NAMES }, found);
    out.push(b'\n');
}

/// Appends the lines that `write` appends of the frame of this number, for people.
pub fn line(out: &mut Vec<u8>, frame: u64, write: impl FnOnce(&mut Vec<u8>)) {
    put!(out; "{\"kind\":\"line\",\"frame\":", frame, ",\"text\":");
    quoted(out, |text| {
        write(text);
        text.pop();
    });
    put!(out; "}\n");
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

/// `true` or `false`.
pub(crate) fn truth(yes: bool) -> &'static str {
    if yes { "true" } else { "false" }
}

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
use crate::bytes::writers::console;
use crate::rules::finding::Finding;
use crate::views::finding_context::HeldFrame;
use crate::words::digits::{KnownTexts, put};
use crate::words::escape;
use crate::world::event::{Event, What, service};

pub use super::columns::transfers::line as transfer;
pub(super) use super::number::marked;
pub(crate) use super::setting::quoted;
pub use super::setting::{NAMES, Setting};
pub use contents::contents;
pub use info::{DAMAGES, info};

/// The writer of frames' objects.
#[derive(Debug, Default)]
pub struct FrameObjects {
    /// A file, and its name as it is written.
    source: (Vec<u8>, Vec<u8>),
    /// Bus, identifier, kind and length, by what decides them.
    forms: KnownTexts<118>,
    /// Service, node, text and fields, where the bytes of a frame do not decide them.
    meanings: KnownTexts<502>,
}

impl FrameObjects {
    /// Appends a frame's object, and those of what follows from it.
    pub fn frame(&mut self, out: &mut Vec<u8>, setting: Setting<'_>, frame: &Frame, events: &[Event]) {
        let (cx, one) = (&Cx { setting, names: NAMES }, Framed { frame, service: service(events), events });
        if self.source.0 != setting.file || self.source.1.is_empty() {
            self.source = (setting.file.to_vec(), Vec::new());
            Frames::source(&mut self.source.1, cx, one);
        }
        put!(out; Frames::HEAD);
        Frames::number(out, cx, one);
        out.extend_from_slice(&self.source.1);
        Frames::moment(out, cx, one);
        let form = console::key(setting.bus(frame.bus), frame);
        self.forms.put_or(out, form, |out| Frames::form(out, cx, one));
        Frames::content(out, cx, one);
        match one.meaning_key(setting.lang) {
            Some(meaning) => self.meanings.put_or(out, meaning, |out| Frames::meaning(out, cx, one)),
            None => Frames::meaning(out, cx, one),
        }
        put!(out; "}\n");
        asides(out, setting, events);
    }
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

#[cfg(test)]
mod tests {
    #![allow(clippy::indexing_slicing)]
    use super::*;
    use crate::bytes::frame::{BusId, Buses, CanId, Direction, Kind};
    use crate::bytes::ns::Ns;
    use crate::rules::finding::{Code, Facts};
    use crate::views::lines::Clocked;
    use crate::wire::pdo::mapping::Mapping;
    use crate::words::Lang;
    use crate::world::configuration::Provenance;
    use crate::world::event::{Placement, ProcessData, Signals, Unmapped};
    use std::sync::Arc;

    /// Frames that differ in one column each, and a frame of another bus.
    fn frames() -> Vec<Frame> {
        let frame = Frame::classic(CanId::standard(0x181), &[1, 2, 3]);
        vec![
            frame,
            Frame { no: 7, line: Some(9), ..frame },
            Frame { bus: BusId(1), ..frame },
            Frame { bus: BusId::BEYOND, ..frame },
            Frame { dir: Some(Direction::Rx), ..frame },
            Frame { dir: Some(Direction::Tx), ..frame },
            Frame { id: CanId::standard(0x182), ..frame },
            Frame { id: CanId::extended(0x181), ..frame },
            Frame { kind: Kind::Remote, ..frame },
            Frame { kind: Kind::Error, ..frame },
            Frame { kind: Kind::Fd { brs: false, esi: false }, ..frame },
            Frame { kind: Kind::Fd { brs: true, esi: false }, ..frame },
            Frame { kind: Kind::Fd { brs: false, esi: true }, ..frame },
            Frame::classic(CanId::standard(0x181), &[1, 2, 4]),
            Frame::classic(CanId::standard(0x181), &[1, 2]),
        ]
    }

    /// PDOs that differ in one field each.
    fn pdos() -> Vec<(Option<u8>, ProcessData)> {
        let pdo = |transmit, number, node| {
            let content = Signals::None(Unmapped::Unknown);
            ProcessData { transmit, number, node, content, state: None, sync: None, is_off: false }
        };
        let state = |state| (Some(1), ProcessData { state, ..pdo(true, 1, 1) });
        let sync = |delay_ns| Some(Placement { cycle: 3, delay_ns });
        let why = [Unmapped::Unconfirmed, Unmapped::Contradicted, Unmapped::Disabled, Unmapped::Multiplex];
        let why = why.map(|why| (Some(1), ProcessData { content: Signals::None(why), ..pdo(true, 1, 1) }));
        let mapping = Arc::new(Mapping::from_words(&[0x6041_0010, 0x2000_0108]));
        let further = [
            (Some(1), pdo(true, 1, 1)),
            (Some(1), pdo(false, 1, 1)),
            (Some(1), pdo(true, 257, 1)),
            (Some(2), pdo(true, 1, 2)),
            (None, pdo(true, 1, 1)),
            (Some(1), ProcessData { sync: sync(None), ..pdo(true, 1, 1) }),
            (Some(1), ProcessData { sync: sync(Some(Ns(5))), ..pdo(true, 1, 1) }),
            state(Some(0)),
            state(Some(4)),
            state(Some(5)),
            (Some(1), ProcessData { content: Signals::Mapped(mapping, Provenance::Eds), ..pdo(true, 1, 1) }),
        ];
        further.into_iter().chain(why).collect()
    }

    #[test]
    fn an_object_does_not_depend_on_those_before() {
        let mut buses = Buses::default();
        let _ = ["can0", "can1"].map(|name| buses.intern(name.as_bytes()));
        let mut known = FrameObjects::default();
        let (frames, pdos) = (frames(), pdos());
        for lang in [Lang::Zh, Lang::En, Lang::Zh, Lang::En] {
            for (frame, (node, pdo)) in frames.iter().flat_map(|frame| pdos.iter().map(move |pdo| (frame, pdo))) {
                let file = if lang == Lang::Zh { &b""[..] } else { b"a.log" };
                let setting = Setting { lang, file, buses: &buses, decimals: 6, clock: Clocked::default() };
                let event = |what| Event {
                    at: frame.reference(),
                    about: None,
                    bus: frame.bus,
                    node: *node,
                    transfer: None,
                    what,
                };
                let finding = Finding {
                    code: Code::Pdo001,
                    at: frame.reference(),
                    cause: None,
                    bus: frame.bus,
                    node: *node,
                    object: None,
                    facts: Facts::None,
                    because_of: None,
                };
                let events = [event(What::Pdo(pdo.clone())), event(What::Finding(Box::new(finding)))];
                for events in [&events[..1], &events] {
                    let (mut one, mut other) = (Vec::new(), Vec::new());
                    known.frame(&mut one, setting, frame, events);
                    // Nothing is kept of the first ones.
                    FrameObjects::default().frame(&mut other, setting, frame, events);
                    assert_eq!(String::from_utf8_lossy(&one), String::from_utf8_lossy(&other), "{frame:?} {pdo:?}");
                }
            }
        }
    }
}

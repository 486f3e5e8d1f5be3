//! Decoded signals in long form: one row a signal of a PDO, as CSV or JSON lines.
//!
//! | column | |
//! |---|---|
//! | `t` | seconds, all digits of the stamp, or as the time is asked for; empty or null without stamps |
//! | `frame` | number in the capture, from 1 |
//! | `bus` | name; empty or null where the capture has none |
//! | `node` | node-ID |
//! | `pdo` | `TPDO1` |
//! | `signal` | name: the description's, else that of the standard in English; `6041h:00` where there is none |
//! | `value` | with sign, type and factor applied; bytes in hexadecimal |
//! | `raw` | the unsigned number in the payload |
//! | `unit` | empty or null where the description has none |
//! | `provenance` | of the mapping (of a multiplex PDO: its sub-index 0, which makes it one): `observed`, `option`, `dcf`, `eds`, `unconfirmed` |
//! | `object` | `6041:00` |
//!
//! A multiplex PDO has one row, `node` and `pdo` are those of the PDO: the object that it addresses, of the node that
//! its first byte names. Without a type `value` and `raw` are all four bytes.
//!
//! JSON lines have `kind` = `signal` and further `file`, `line`, `index`, `sub` and `text` (the value in words).

use std::sync::Arc;

use super::csv;
use super::jsonl::{self, NAMES, Setting};
use super::number;
use super::selection::{Chosen, Selection, Whose};
use crate::bytes::frame::Frame;
use crate::bytes::select::Select;
use crate::wire::pdo::mapping::{Mapped, Mapping};
use crate::words::digits::{Hex, put};
use crate::words::{Lang, escape, signal};
use crate::world::configuration::Provenance;
use crate::world::event::{Addressed, Event, Signals as Content, What};

/// The columns of CSV.
const HEAD: &str = "t,frame,bus,node,pdo,signal,value,raw,unit,provenance,object\n";

/// The renderer.
#[derive(Debug)]
pub struct Signals {
    lang: Lang,
    csv: bool,
    headed: bool,
    selection: Selection,
}

impl Signals {
    /// A renderer at the beginning of a capture.
    pub fn new(lang: Lang, csv: bool, select: Select) -> Self {
        Self { lang, csv, headed: false, selection: Selection::new(NAMES, select) }
    }

    /// Appends the rows of a frame.
    pub fn frame(&mut self, out: &mut Vec<u8>, setting: Setting<'_>, frame: &Frame, events: &[Event]) {
        if self.csv && !std::mem::replace(&mut self.headed, true) {
            put!(out; HEAD);
        }
        for event in events {
            match &event.what {
                What::Pdo(data) => {
                    if let Content::Mapped(mapping, from) | Content::ByConsumer(mapping, from, ..) = &data.content {
                        let whose = Whose { transmit: data.transmit, number: data.number, node: data.node };
                        self.rows(out, setting, frame, whose, mapping, *from);
                    }
                }
                What::Mpdo(data) => self.multiplexed(out, setting, frame, data),
                _ => {}
            }
        }
    }

    fn rows(
        &mut self,
        out: &mut Vec<u8>,
        setting: Setting<'_>,
        frame: &Frame,
        whose: Whose,
        mapping: &Arc<Mapping>,
        from: Provenance,
    ) {
        let Self { lang, csv, .. } = *self;
        let chosen = self.selection.of(whose, mapping);
        write(out, lang, csv, setting, frame, whose, mapping, chosen, from);
    }

    /// The object in a multiplex PDO: another one in every frame, so that nothing of it is remembered.
    fn multiplexed(&self, out: &mut Vec<u8>, setting: Setting<'_>, frame: &Frame, data: &Addressed) {
        let whose = Whose { transmit: data.transmit, number: data.number, node: data.node };
        let chosen = self.selection.choose(whose, &data.mapping);
        write(out, self.lang, self.csv, setting, frame, whose, &data.mapping, &chosen, data.from);
    }
}

#[allow(clippy::too_many_arguments, reason = "what a row is made of")]
fn write(
    out: &mut Vec<u8>,
    lang: Lang,
    csv: bool,
    setting: Setting<'_>,
    frame: &Frame,
    whose: Whose,
    mapping: &Mapping,
    chosen: &[Chosen],
    from: Provenance,
) {
    let start = out.len();
    // The columns of the frame, which are those of each of its rows.
    let mut head = 0..0;
    for one in chosen {
        let Some(mapped) = mapping.entries.get(one.place) else { continue };
        if !csv {
            line(out, lang, setting, frame, whose, mapping, mapped, &one.name, from);
            continue;
        }
        if head.is_empty() {
            csv::bare(out, |out| setting.moment(out, frame.t_ns));
            put!(out; ",", frame.no, ",");
            csv::cell(out, setting.buses.name(frame.bus));
            put!(out; ",", whose.node, if whose.transmit { ",TPDO" } else { ",RPDO" }, whose.number, ",");
            head = start..out.len();
        } else {
            out.extend_from_within(head.clone());
        }
        out.extend_from_slice(&one.cell);
        put!(out; ",");
        number::value(out, mapping, mapped, frame.payload());
        put!(out; ",");
        number::raw(out, mapping, mapped, frame.payload());
        put!(out; ",");
        out.extend_from_slice(&one.unit_cell);
        put!(out; ",", from.name(), ",", one.object.as_str(), "\n");
    }
}

#[allow(clippy::too_many_arguments, reason = "the keys of an object")]
fn line(
    out: &mut Vec<u8>,
    lang: Lang,
    setting: Setting<'_>,
    frame: &Frame,
    whose: Whose,
    mapping: &Mapping,
    mapped: &Mapped,
    name: &str,
    from: Provenance,
) {
    put!(out; "{\"kind\":\"signal\",\"t\":");
    setting.moment(out, frame.t_ns);
    put!(out; ",\"frame\":", frame.no, ",\"line\":");
    jsonl::number_or_null(out, frame.line);
    put!(out; ",\"file\":");
    escape::json(out, setting.file);
    put!(out; ",\"bus\":");
    jsonl::name_or_null(out, setting.buses.name(frame.bus));
    put!(out; ",\"node\":", whose.node, if whose.transmit { ",\"pdo\":\"TPDO" } else { ",\"pdo\":\"RPDO" }, whose.number);
    put!(out; "\",\"index\":\"", Hex::<4>(u64::from(mapped.index)), "\",\"sub\":", mapped.sub, ",\"signal\":");
    escape::json(out, name.as_bytes());
    put!(out; ",\"value\":");
    jsonl::marked(out, |out| number::value(out, mapping, mapped, frame.payload()));
    put!(out; ",\"raw\":");
    jsonl::marked(out, |out| number::raw(out, mapping, mapped, frame.payload()));
    put!(out; ",\"unit\":");
    match mapped.unit.as_deref() {
        Some(unit) => escape::json(out, unit.as_bytes()),
        None => put!(out; "null"),
    }
    put!(out; ",\"text\":");
    match mapping.raw(mapped, frame.payload()) {
        Some(raw) => jsonl::quoted(out, |text| signal::value(text, lang, mapped, raw)),
        None => put!(out; "null"),
    }
    put!(out; ",\"provenance\":\"", from.name(), "\"}\n");
}

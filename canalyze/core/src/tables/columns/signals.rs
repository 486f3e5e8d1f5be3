//! `signals`: one row per signal of a PDO, in Arrow, as CSV and as JSON lines.
//!
//! `value` has sign, type and factor applied, `integer` is the same exactly where it is a whole number without factor,
//! `raw` the unsigned number in the payload; `data` are the bytes of an entry that is no number or longer than 64 bits.
//! All of them are null where the payload does not reach; in JSON and CSV bytes are the value, in hexadecimal. A
//! multiplex PDO has one row: the object that it addresses, of the node that its first byte names. Without a type
//! `value` and `raw` are all four bytes. Must not: decide which mapping holds.

use super::column::{Batch, Table};
use super::{Collector, Ends, TableContext};
use crate::bytes::frame::Frame;
use crate::bytes::select::Select;
use crate::tables::csv;
use crate::tables::number::{self, marked};
use crate::tables::selection::{Chosen, Selection, Whose};
use crate::tables::setting::{NAMES, Setting};
use crate::tables::table::{
    Any, Bytes, Cx, Given, Hex4, I64, Label, MaybeText, Moment, Name, Piece, Real, U8, U64, Word, table,
};
use crate::wire::pdo::mapping::{Mapped, Mapping, Number, number as read};
use crate::words::Lang;
use crate::words::digits::KnownTexts;
use crate::words::signal::{self, product};
use crate::world::configuration::Provenance;
use crate::world::event::{Addressed, Event, Signals as Content, What};

/// A signal of a PDO.
#[derive(Clone, Copy)]
pub(super) struct ListedSignal<'a> {
    pub(super) whose: Whose,
    pub(super) mapping: &'a Mapping,
    pub(super) mapped: &'a Mapped,
    pub(super) from: Provenance,
    pub(super) chosen: &'a Chosen,
}

/// A signal in a frame, and the numbers that are read of it.
#[derive(Clone, Copy)]
pub(in crate::tables) struct Sample<'a> {
    frame: &'a Frame,
    signal: ListedSignal<'a>,
    raw: Option<u64>,
    integer: Option<i64>,
    value: Option<f64>,
}

impl<'a> Sample<'a> {
    /// Returns a signal with the number in the payload.
    fn new(frame: &'a Frame, signal: ListedSignal<'a>) -> Self {
        let raw = signal.mapping.raw(signal.mapped, frame.payload());
        Self { frame, signal, raw, integer: None, value: None }
    }

    /// The bytes, where it has no value.
    fn octets(&self) -> Option<&'a [u8]> {
        let ListedSignal { mapping, mapped, .. } = self.signal;
        if self.value.is_none() { mapping.octets(mapped, self.frame.payload()) } else { None }
    }

    fn text(&self, out: &mut Vec<u8>, lang: Lang) -> bool {
        let Some(raw) = self.raw else { return false };
        signal::value_at(out, lang, self.signal.mapping, self.signal.chosen.place, raw);
        true
    }

    fn entry(&self) -> number::EntryBits<'a> {
        let ListedSignal { mapping, mapped, .. } = self.signal;
        number::EntryBits { mapping, mapped, payload: self.frame.payload(), raw: self.raw }
    }
}

table! {
    /// One row per value of a signal in a PDO.
    /// 一行是PDO里的一个信号值
    Signals arrow "signals" json "signal", |cx, one: Sample<'_>| {
        t: Moment or null = one.frame.t_ns;
        frame: U64 = one.frame.no;
        line: U64 or null = one.frame.line;
        file: Given in json = cx.setting.file;
        bus: Name or null = cx.setting.bus(one.frame.bus);
        node: U8 = one.signal.whose.node;
        pdo: Word = &*one.signal.chosen.pdo;
        index: Hex4 in json = one.signal.mapped.index;
        sub: U8 in json = one.signal.mapped.sub;
        /// name of the signal
        /// 信号名
        signal: Label = &*one.signal.chosen.name;
        object: Word in arrow = &*one.signal.chosen.object;
        value: Real or null in arrow = one.value;
        integer: I64 or null in arrow = one.integer;
        raw: U64 or null in arrow = one.raw;
        data: Bytes or null in arrow = one.octets();
        value_shown as "value": Any or null in json = |out: &mut Vec<u8>| marked(out, |out| number::value(out, one.entry()));
        raw_shown as "raw": Any or null in json = |out: &mut Vec<u8>| marked(out, |out| number::raw(out, one.entry()));
        unit: Label or null = one.signal.mapped.unit.as_deref();
        text: MaybeText or null = |out: &mut Vec<u8>| one.text(out, cx.setting.lang);
        provenance: Word = one.signal.from.name();
        signal_cell as "signal": Piece in csv = |out: &mut Vec<u8>| out.extend_from_slice(&one.signal.chosen.cell);
        value_cell as "value": Piece in csv = |out: &mut Vec<u8>| _ = number::value(out, one.entry());
        raw_cell as "raw": Piece in csv = |out: &mut Vec<u8>| _ = number::raw(out, one.entry());
        unit_cell as "unit": Piece in csv = |out: &mut Vec<u8>| out.extend_from_slice(&one.signal.chosen.unit_cell);
    }
    csv [{csv_place: t, frame} {csv_source: bus, node, pdo} {csv_value: signal_cell, value_cell, raw_cell}
        [unit_cell, provenance, object]]
}

/// Calls `take` with each signal of a PDO that is listed.
pub(super) fn each(selection: &mut Selection, what: &What, mut take: impl FnMut(ListedSignal<'_>)) {
    let mut all = |whose, mapping: &Mapping, from, chosen: &[Chosen]| {
        for chosen in chosen {
            if let Some(mapped) = mapping.entries.get(chosen.place) {
                take(ListedSignal { whose, mapping, mapped, from, chosen });
            }
        }
    };
    match what {
        What::Pdo(data) => {
            let (Content::Mapped(mapping, from) | Content::ByConsumer(mapping, from, ..)) = &data.content else {
                return;
            };
            let whose = Whose { transmit: data.transmit, number: data.number, node: data.node };
            all(whose, mapping, *from, selection.of(whose, mapping, *from));
        }
        // Its object is another one in every frame, so nothing of it is remembered.
        What::Mpdo(data) => {
            let Addressed { transmit, number, node, ref mapping, from, .. } = **data;
            let whose = Whose { transmit, number, node };
            all(whose, mapping, from, &selection.choose(whose, mapping));
        }
        _ => {}
    }
}

/// The table, and the signals that are in it.
#[derive(Debug)]
pub(super) struct Listed {
    table: Table<Signals>,
    selection: Selection,
}

impl Listed {
    /// Returns a table without rows.
    pub(super) fn new(selection: Selection) -> Self {
        Self { table: Table::default(), selection }
    }
}

impl Collector for Listed {
    fn frame(&mut self, done: &mut Vec<Batch>, scene: TableContext<'_>, frame: &Frame, events: &[Event]) {
        let Self { table, selection } = self;
        for event in events {
            each(selection, &event.what, |signal| {
                let sample = Sample::new(frame, signal);
                let (integer, value) = sample.raw.map_or((None, None), |raw| numbers(signal.mapped, raw));
                table.row(done, &scene.cx(), Sample { integer, value, ..sample });
            });
        }
    }

    fn table(&mut self) -> &mut dyn Ends {
        &mut self.table
    }
}

/// The renderer of CSV and JSON lines.
#[derive(Debug)]
pub struct SignalLines {
    lang: Lang,
    csv: bool,
    headed: bool,
    selection: Selection,
    /// Cells of buses and PDOs.
    sources: KnownTexts,
}

impl SignalLines {
    /// Returns a renderer at the beginning of a capture.
    pub fn new(lang: Lang, csv: bool, select: Select) -> Self {
        Self { lang, csv, headed: false, selection: Selection::new(NAMES, select), sources: KnownTexts::default() }
    }

    /// Appends the rows of a frame.
    pub fn frame(&mut self, out: &mut Vec<u8>, setting: Setting<'_>, frame: &Frame, events: &[Event]) {
        let Self { lang, csv, headed, selection, sources } = self;
        let cx = Cx { setting: Setting { lang: *lang, ..setting }, names: NAMES };
        if *csv && !std::mem::replace(headed, true) {
            csv::headings(out, Signals::HEADINGS);
        }
        for event in events {
            // The cells of the frame, which all its rows begin with.
            let mut head = 0..0;
            each(selection, &event.what, |signal| {
                let sample = Sample::new(frame, signal);
                if !*csv {
                    Signals::json(out, &cx, sample);
                    return out.push(b'\n');
                }
                if head.is_empty() {
                    let start = out.len();
                    Signals::csv_place(out, &cx, sample);
                    let source = signal.whose.key() | u64::from(frame.bus.0) << 32;
                    sources.put_or(out, source, |out| Signals::csv_source(out, &cx, sample));
                    head = start..out.len();
                } else {
                    out.extend_from_within(head.clone());
                }
                Signals::csv_value(out, &cx, sample);
                out.extend_from_slice(signal.chosen.rest.get_or_init(|| {
                    let mut rest = Vec::new();
                    Signals::csv(&mut rest, &cx, sample);
                    rest
                }));
            });
        }
    }
}

/// Returns the value exactly, where it is a whole number without factor, and as it is in its unit.
pub(super) fn numbers(mapped: &Mapped, raw: u64) -> (Option<i64>, Option<f64>) {
    let scaled = mapped.factor != 1.0;
    let whole = |exact: Option<i64>, read: f64| {
        if scaled { (None, Some(product(read, mapped.factor))) } else { (exact, Some(read)) }
    };
    match read(mapped.data_type, raw, mapped.bits) {
        // A factor means nothing to it.
        Number::Bool(on) => (Some(i64::from(on)), Some(f64::from(u8::from(on)))),
        Number::Unsigned(read) => whole(i64::try_from(read).ok(), read as f64),
        Number::Signed(read) => whole(Some(read), read as f64),
        Number::Real32(read) => (None, Some(f64::from(read) * mapped.factor)),
        Number::Real64(read) => (None, Some(read * mapped.factor)),
        Number::Bytes => (None, None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bytes::frame::{BusId, Buses, CanId};
    use crate::views::lines::Clocked;
    use crate::world::event::ProcessData;
    use std::sync::Arc;

    /// A PDO for each of what decides the cells of its rows.
    fn pdos() -> Vec<ProcessData> {
        let mapping = |words: &[u32]| {
            let mut mapping = Mapping::from_words(words);
            mapping.entries.iter_mut().for_each(|mapped| mapped.unit = Some("rpm".into()));
            Arc::new(mapping)
        };
        let (one, other) = (mapping(&[0x6041_0010, 0x606C_0020]), mapping(&[0x6041_0010, 0x6064_0020]));
        let pdo = |mapping: &Arc<Mapping>, from, transmit, number, node| {
            let content = Content::Mapped(Arc::clone(mapping), from);
            ProcessData { transmit, number, node, content, state: None, sync: None, is_off: false }
        };
        vec![
            pdo(&one, Provenance::Eds, true, 1, 1),
            pdo(&one, Provenance::Dcf, true, 1, 1),
            pdo(&one, Provenance::Observed(3), true, 1, 1),
            pdo(&one, Provenance::Unconfirmed(3), true, 1, 1),
            pdo(&other, Provenance::Eds, true, 1, 1),
            pdo(&one, Provenance::Eds, false, 1, 1),
            pdo(&one, Provenance::Eds, true, 257, 1),
            pdo(&one, Provenance::Eds, true, 1, 2),
        ]
    }

    #[test]
    fn rows_do_not_depend_on_those_before() {
        let mut buses = Buses::default();
        let _ = ["can0", "can1"].map(|name| buses.intern(name.as_bytes()));
        let setting = Setting { lang: Lang::En, file: b"", buses: &buses, decimals: 6, clock: Clocked::default() };
        let lines = || SignalLines { headed: true, ..SignalLines::new(Lang::En, true, Select::default()) };
        let (mut known, pdos) = (lines(), pdos());
        for _ in 0..10 {
            for (bus, pdo) in (0..3).flat_map(|bus| pdos.iter().map(move |pdo| (BusId(bus), pdo))) {
                let frame = Frame { bus, ..Frame::classic(CanId::standard(0x181), &[1, 2, 3, 4, 5, 6]) };
                let node = Some(pdo.node);
                let what = What::Pdo(pdo.clone());
                let events = [Event { at: frame.reference(), about: None, bus, node, transfer: None, what }];
                let (mut one, mut other) = (Vec::new(), Vec::new());
                known.frame(&mut one, setting, &frame, &events);
                lines().frame(&mut other, setting, &frame, &events);
                assert!(other.iter().filter(|byte| **byte == b'\n').count() == 2);
                assert_eq!(String::from_utf8_lossy(&one), String::from_utf8_lossy(&other), "{events:?}");
            }
        }
    }
}

//! `pdo/BUS/NODE.PDO/VERSION`: one wide table a PDO and mapping, a row a frame, a column a signal.
//!
//! The mapping seen first is version 1, the next other one 2; one that comes again has its own number again. Signals
//! have the type that they have on the bus, without factor: what a column is, its metadata say (`object`, `index`,
//! `sub`, `unit`, `kind`, `factor`, `type`, `bits`, `offset`, and `quantity`: "true", or "false" for truth values, choices, bits
//! and text). A cell is null where the payload does not reach. Columns are named as the signals are; of several with one
//! name the later ones have their object behind it. Multiplex PDOs have no such table: their object is another one in
//! every frame. `cycle` is the SYNC cycle to which a synchronous PDO belongs, `running_cycle` the one that runs on the
//! bus at any PDO. Version 0 is a synchronous PDO without a known mapping: it has no signals, and is there if all signals
//! are selected. Must not: decide what a mapping is.
//!
//! `wide/BUS/NODE.PDO/VERSION` is the same for whoever asks for values rather than for what is on the bus: a number with
//! a factor is in its unit, what has words (a drive's states, commands and modes) is these words, and
//! `NAME__raw` behind it the number. Names and words are English whatever the language is, since queries compare them;
//! there is no version 0.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use arrow_array::ArrayRef;
use arrow_array::builder::{BinaryBuilder, BooleanBuilder};
use arrow_array::types::{
    Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type, UInt8Type, UInt16Type, UInt32Type, UInt64Type,
};
use arrow_schema::Field;

use super::column::{Append, Batch, Column, Columns, Numbers, Table, Words};
use super::signals::numbers;
use super::{Collector, Ends, TableContext};
use crate::bytes::frame::{BusId, Frame};
use crate::tables::selection::{Chosen, Selection, Whose};
use crate::tables::table::{Cx, Duration, Moment, U64, Word, table};
use crate::wire::pdo::mapping::{Mapped, Mapping, Number, number};
use crate::words::{Lang, signal};
use crate::world::event::{Event, Placement, ProcessData, Signals, What};
use crate::world::od::DataType;

/// Columns that every such table has before those of its signals.
const FIXED: usize = 6;
/// Most columns that rows are kept for, those of 4096 PDOs with a signal a byte; with more all tables end their batches and
/// are forgotten.
const MOST: usize = 4096 * (FIXED + 8);
/// Bytes that the rows of all tables may take before all of them end their batches.
const BYTES: usize = 64 << 20;

/// One of the types that a signal may have.
#[derive(Debug)]
enum Cells {
    Bool(BooleanBuilder),
    U8(Numbers<UInt8Type>),
    U16(Numbers<UInt16Type>),
    U32(Numbers<UInt32Type>),
    U64(Numbers<UInt64Type>),
    I8(Numbers<Int8Type>),
    I16(Numbers<Int16Type>),
    I32(Numbers<Int32Type>),
    I64(Numbers<Int64Type>),
    Real32(Numbers<Float32Type>),
    Real64(Numbers<Float64Type>),
    Bytes(BinaryBuilder),
    /// A number in its unit.
    Scaled(Numbers<Float64Type>),
    /// The meaning of a number.
    Worded(Worded),
}

/// A column of what the numbers of an object of CiA 402 mean.
#[derive(Debug, Default)]
struct Worded {
    words: Words,
    /// Its index on the first axis.
    index: u16,
    /// The number that came last, and its words: mostly it comes again.
    last: Option<u64>,
    text: Vec<u8>,
}

impl Worded {
    fn append(&mut self, raw: Option<u64>) {
        let Some(value) = raw else { return self.words.maybe(None) };
        if self.last.replace(value) != raw {
            self.text.clear();
            signal::annotation(&mut self.text, Lang::En, self.index, value);
        }
        self.words.name(&self.text);
    }
}

impl Column for Worded {
    fn empty() -> Self {
        Self::default()
    }

    fn data_type() -> arrow_schema::DataType {
        Words::data_type()
    }

    fn take(&mut self) -> ArrayRef {
        self.words.take()
    }
}

/// Does the same with a builder of any type.
macro_rules! each {
    ($cells:expr, $builder:ident => $do:expr) => {
        match $cells {
            Cells::Bool($builder) => $do,
            Cells::U8($builder) => $do,
            Cells::U16($builder) => $do,
            Cells::U32($builder) => $do,
            Cells::U64($builder) => $do,
            Cells::I8($builder) => $do,
            Cells::I16($builder) => $do,
            Cells::I32($builder) => $do,
            Cells::I64($builder) => $do,
            Cells::Real32($builder) => $do,
            Cells::Real64($builder) => $do,
            Cells::Bytes($builder) => $do,
            Cells::Scaled($builder) => $do,
            Cells::Worded($builder) => $do,
        }
    };
}

impl Cells {
    /// Those of an entry; `None` where it has no bits. There are many tables: nothing is reserved.
    fn of(mapped: &Mapped) -> Option<Self> {
        let bits = mapped.bits;
        if bits == 0 {
            return None;
        }
        let whole = bits.is_multiple_of(8) && mapped.offset.is_multiple_of(8);
        Some(match number(mapped.data_type, 0, bits) {
            _ if bits > 64 => Self::Bytes(BinaryBuilder::with_capacity(0, 0)),
            Number::Bytes if whole => Self::Bytes(BinaryBuilder::with_capacity(0, 0)),
            Number::Bool(_) if bits == 1 => Self::Bool(BooleanBuilder::with_capacity(0)),
            Number::Real32(_) => Self::Real32(Numbers::with_capacity(0)),
            Number::Real64(_) => Self::Real64(Numbers::with_capacity(0)),
            Number::Signed(_) => match bits {
                0..=8 => Self::I8(Numbers::with_capacity(0)),
                9..=16 => Self::I16(Numbers::with_capacity(0)),
                17..=32 => Self::I32(Numbers::with_capacity(0)),
                _ => Self::I64(Numbers::with_capacity(0)),
            },
            Number::Bool(_) | Number::Unsigned(_) | Number::Bytes => match bits {
                0..=8 => Self::U8(Numbers::with_capacity(0)),
                9..=16 => Self::U16(Numbers::with_capacity(0)),
                17..=32 => Self::U32(Numbers::with_capacity(0)),
                _ => Self::U64(Numbers::with_capacity(0)),
            },
        })
    }

    /// Those of an entry in a table of values: what it means, where that has words, and its number.
    fn of_value(mapping: &Mapping, place: usize, mapped: &Mapped) -> (Option<Self>, Option<Self>) {
        let index = signal::written(mapping, Lang::En).get(place).map_or(0, |how| how.words);
        let words = (index != 0).then(|| Self::Worded(Worded { index, ..Worded::default() }));
        let number = match (mapped.factor != 1.0, number(mapped.data_type, 0, mapped.bits)) {
            (true, Number::Unsigned(_) | Number::Signed(_) | Number::Real32(_) | Number::Real64(_))
                if (1..=64).contains(&mapped.bits) =>
            {
                Some(Self::Scaled(Numbers::with_capacity(0)))
            }
            _ => Self::of(mapped),
        };
        (words, number)
    }

    /// Appends what the payload holds of the entry.
    fn append(&mut self, mapping: &Mapping, mapped: &Mapped, payload: &[u8]) {
        let raw = mapping.raw(mapped, payload);
        let signed = |raw| match number(mapped.data_type, raw, mapped.bits) {
            Number::Signed(read) => read,
            _ => 0,
        };
        match self {
            Self::Bool(column) => column.append_option(raw.map(|raw| raw != 0)),
            Self::U8(column) => column.append_option(raw.map(|raw| raw as u8)),
            Self::U16(column) => column.append_option(raw.map(|raw| raw as u16)),
            Self::U32(column) => column.append_option(raw.map(|raw| raw as u32)),
            Self::U64(column) => column.append_option(raw),
            Self::I8(column) => column.append_option(raw.map(|raw| signed(raw) as i8)),
            Self::I16(column) => column.append_option(raw.map(|raw| signed(raw) as i16)),
            Self::I32(column) => column.append_option(raw.map(|raw| signed(raw) as i32)),
            Self::I64(column) => column.append_option(raw.map(signed)),
            Self::Real32(column) => column.append_option(raw.map(|raw| f32::from_bits(raw as u32))),
            Self::Real64(column) => column.append_option(raw.map(f64::from_bits)),
            Self::Bytes(column) => column.append_option(mapping.octets(mapped, payload)),
            Self::Scaled(column) => column.append_option(raw.and_then(|raw| numbers(mapped, raw).1)),
            Self::Worded(column) => column.append(raw),
        }
    }
}

/// The type of the column behind a builder.
fn type_of<C: Column>(_: &C) -> arrow_schema::DataType {
    C::data_type()
}

/// The place of a PDO in the capture.
#[derive(Clone, Copy)]
pub(in crate::tables) struct PdoPlace<'a> {
    frame: &'a Frame,
    running: u64,
    from: &'static str,
    sync: Option<Placement>,
}

table! {
    /// One row per PDO; its signals are further columns.
    /// 一行是一个PDO，其后每个信号一列
    Places arrow "pdo", |cx, one: PdoPlace<'_>| {
        t: Moment or null = one.frame.t_ns;
        frame: U64 = one.frame.no;
        provenance: Word = one.from;
        cycle: U64 or null = one.sync.map(|sync| sync.cycle);
        /// since SYNC
        /// 距SYNC
        delay: Duration or null = one.sync.and_then(|sync| sync.delay_ns);
        /// number of the cycle, counted through the whole capture
        /// 全记录连续的周期编号
        running_cycle: U64 = one.running;
    }
}

/// The columns of a PDO by one mapping.
#[derive(Debug, Default)]
struct Wide {
    places: Places,
    /// PdoPlace in the mapping, the column as the schema has it, its values.
    signals: Vec<(usize, Field, Cells)>,
}

impl Wide {
    fn new(mapping: &Mapping, chosen: &[Chosen], of: Of) -> Self {
        let places = Places::default();
        let mut taken: Vec<String> = places.fields().iter().map(|field| field.name().clone()).collect();
        let mut signals = Vec::new();
        for one in chosen {
            let Some(mapped) = mapping.entries.get(one.place) else { continue };
            let (words, number) = match of {
                Of::Bus => (None, Cells::of(mapped)),
                Of::Values => Cells::of_value(mapping, one.place, mapped),
            };
            let Some(number) = number else { continue };
            let name = unique(one, &mut taken);
            let mut push = |name: String, cells: Cells| {
                let data_type = each!(&cells, builder => type_of(builder));
                let field = Field::new(name, data_type, true).with_metadata(metadata(mapped, &one.object));
                signals.push((one.place, field, cells));
            };
            let raw = words.map(|words| {
                push(name.clone(), words);
                format!("{name}__raw")
            });
            push(raw.unwrap_or(name), number);
        }
        Self { places, signals }
    }

    fn append(&mut self, cx: &Cx<'_>, mapping: &Mapping, place: PdoPlace<'_>) {
        self.places.append(cx, place);
        for (at, _, cells) in &mut self.signals {
            if let Some(mapped) = mapping.entries.get(*at) {
                cells.append(mapping, mapped, place.frame.payload());
            }
        }
    }
}

impl Columns for Wide {
    fn fields(&self) -> Vec<Field> {
        let signals = self.signals.iter().map(|(_, field, _)| field.clone());
        self.places.fields().into_iter().chain(signals).collect()
    }

    fn arrays(&mut self) -> Vec<ArrayRef> {
        let signals = self.signals.iter_mut().map(|(_, _, cells)| each!(cells, builder => Column::take(builder)));
        self.places.arrays().into_iter().chain(signals).collect()
    }
}

/// The name of a signal, or one made of it that no other column has.
fn unique(one: &Chosen, taken: &mut Vec<String>) -> String {
    let mut name = one.name.clone();
    let mut number = 1;
    while taken.contains(&name) {
        name = format!("{} ({})", one.name, one.object);
        if number > 1 {
            name.push_str(&format!(" {number}"));
        }
        number += 1;
    }
    taken.push(name.clone());
    name
}

fn metadata(mapped: &Mapped, object: &str) -> HashMap<String, String> {
    let mut all = vec![
        ("object", object.to_owned()),
        ("index", mapped.index.to_string()),
        ("sub", mapped.sub.to_string()),
        ("factor", mapped.factor.to_string()),
        ("bits", mapped.bits.to_string()),
        ("offset", mapped.offset.to_string()),
        ("quantity", signal::is_quantity(mapped).to_string()),
    ];
    let kind = mapped.profile.kind(mapped.index).filter(|_| mapped.is_of_profile());
    all.extend(kind.map(|kind| ("kind", kind.to_owned())));
    all.extend(mapped.unit.as_deref().map(|unit| ("unit", unit.to_owned())));
    all.extend(mapped.data_type.map(|one| ("type", DataType::name(one).to_owned())));
    all.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
}

/// One mapping of a PDO, and its table.
#[derive(Debug)]
struct Version {
    /// The mapping by which it was made; others with the same entries are the same.
    mapping: Arc<Mapping>,
    /// Its number, from 1.
    number: usize,
    table: Table<Wide>,
    /// About what a row takes.
    width: usize,
}

/// The mappings of one PDO, the one used last first.
#[derive(Debug, Default)]
struct Versions {
    /// The number of mappings, including forgotten ones.
    count: usize,
    known: Vec<Version>,
}

/// The content of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Of {
    /// The number on the bus.
    Bus,
    /// Its value.
    Values,
}

/// The tables of all PDOs.
#[derive(Debug)]
pub(super) struct Pdos {
    lang: Lang,
    of: Of,
    selection: Selection,
    tables: BTreeMap<(BusId, Whose), Versions>,
    /// Those of synchronous PDOs without a mapping.
    unmapped: BTreeMap<(BusId, Whose), Table<Wide>>,
    /// Columns of the tables that are known.
    columns: usize,
    /// About what the rows of all of them take.
    bytes: usize,
}

impl Pdos {
    /// Returns no tables.
    pub(super) fn new(lang: Lang, selection: Selection, of: Of) -> Self {
        Self { lang, of, selection, tables: BTreeMap::new(), unmapped: BTreeMap::new(), columns: 0, bytes: 0 }
    }

    /// Appends the signals of a PDO.
    fn process_data(&mut self, done: &mut Vec<Batch>, scene: TableContext<'_>, frame: &Frame, data: &ProcessData) {
        let (Signals::Mapped(mapping, from) | Signals::ByConsumer(mapping, from, ..)) = &data.content else {
            if self.of == Of::Bus && data.sync.is_some() && self.selection.is_everything() {
                self.unmapped(done, scene, frame, data);
            }
            return;
        };
        let whose = Whose { transmit: data.transmit, number: data.number, node: data.node };
        self.make_room(done);
        let versions = self.tables.entry((frame.bus, whose)).or_default();
        let same = |one: &Version| {
            Arc::ptr_eq(&one.mapping, mapping)
                || (one.mapping.bits == mapping.bits && one.mapping.entries == mapping.entries)
        };
        let place = match versions.known.iter().position(same) {
            Some(place) => place,
            None => {
                versions.count += 1;
                let bus = scene.setting.bus(frame.bus);
                let chosen = self.selection.choose(whose, mapping);
                let columns = Wide::new(mapping, &chosen, self.of);
                self.columns += FIXED + columns.signals.len();
                let width = 8 * (FIXED + columns.signals.len()) + mapping.bytes();
                let table = named((self.of, self.lang), bus, whose, versions.count, columns);
                versions.known.push(Version { mapping: Arc::clone(mapping), number: versions.count, table, width });
                versions.known.len() - 1
            }
        };
        versions.known.swap(0, place);
        let Some(version) = versions.known.first_mut().filter(|one| !one.table.columns.signals.is_empty()) else {
            return;
        };
        if !Arc::ptr_eq(&version.mapping, mapping) {
            // The newer of two that are the same is the one that comes again.
            version.mapping = Arc::clone(mapping);
        }
        let place = PdoPlace { frame, running: scene.cycle, from: from.name(), sync: data.sync };
        version.table.columns.append(&scene.cx(), mapping, place);
        version.table.end_row(0, done);
        self.bytes += version.width;
    }

    /// Appends the place of a synchronous PDO in its cycle; nothing else is known of it.
    fn unmapped(&mut self, done: &mut Vec<Batch>, scene: TableContext<'_>, frame: &Frame, data: &ProcessData) {
        self.make_room(done);
        let Self { lang, unmapped, columns, .. } = self;
        let whose = Whose { transmit: data.transmit, number: data.number, node: data.node };
        let table = unmapped.entry((frame.bus, whose)).or_insert_with(|| {
            *columns += FIXED;
            named((Of::Bus, *lang), scene.setting.bus(frame.bus), whose, 0, Wide::default())
        });
        let place = PdoPlace { frame, running: scene.cycle, from: "unknown", sync: data.sync };
        table.columns.places.append(&scene.cx(), place);
        table.end_row(0, done);
        self.bytes += 8 * FIXED;
    }

    fn make_room(&mut self, done: &mut Vec<Batch>) {
        if self.columns >= MOST || self.bytes >= BYTES {
            Ends::flush(self, done);
        }
        if self.columns >= MOST {
            self.forget();
        }
    }

    /// Forgets all mappings, but not which numbers are taken.
    fn forget(&mut self) {
        for versions in self.tables.values_mut() {
            versions.known = Vec::new();
        }
        self.unmapped.clear();
        self.columns = 0;
    }
}

impl Ends for Pdos {
    /// Ends all batches, of a PDO those of its first mapping first.
    fn flush(&mut self, done: &mut Vec<Batch>) {
        self.tables.values_mut().for_each(|versions| versions.known.sort_by_key(|one| one.number));
        for version in self.tables.values_mut().flat_map(|versions| &mut versions.known) {
            version.table.flush(done);
        }
        self.unmapped.values_mut().for_each(|table| table.flush(done));
        self.bytes = 0;
    }

    fn finish(&mut self, done: &mut Vec<Batch>) {
        Ends::flush(self, done);
    }
}

impl Collector for Pdos {
    fn frame(&mut self, done: &mut Vec<Batch>, scene: TableContext<'_>, frame: &Frame, events: &[Event]) {
        for event in events {
            if let What::Pdo(data) = &event.what {
                self.process_data(done, scene, frame, data);
            }
        }
    }

    fn table(&mut self) -> &mut dyn Ends {
        self
    }
}

/// A table by the name of its PDO.
fn named((of, lang): (Of, Lang), bus: &[u8], whose: Whose, number: usize, columns: Wide) -> Table<Wide> {
    let mut table = if of == Of::Bus { "pdo/" } else { "wide/" }.to_owned();
    if !bus.is_empty() {
        part(&mut table, bus);
        table.push('/');
    }
    table.push_str(&format!("{}.{}/{number}", whose.node, whose.pdo()));
    let metadata = [
        ("bus", String::from_utf8_lossy(bus).into_owned()),
        ("node", whose.node.to_string()),
        ("pdo", whose.pdo()),
        ("version", number.to_string()),
        ("lang", if lang == Lang::Zh { "zh" } else { "en" }.to_owned()),
    ];
    Table::new(&table, columns, &metadata)
}

/// Appends a name, of a bus for one, as a part of a table's or a lane's name: what would end the part, or is not a plain character, is `%2F`.
pub(super) fn part(table: &mut String, name: &[u8]) {
    for chunk in name.utf8_chunks() {
        for c in chunk.valid().chars() {
            if matches!(c, '/' | '%') || c.is_whitespace() || crate::words::escape::unsafe_on_a_terminal(c) {
                let mut bytes = [0; 4];
                for byte in c.encode_utf8(&mut bytes).bytes() {
                    table.push_str(&format!("%{byte:02X}"));
                }
            } else {
                table.push(c);
            }
        }
        for byte in chunk.invalid() {
            table.push_str(&format!("%{byte:02X}"));
        }
    }
}

//! The tables against what is fed: names and types frozen, the ends of batches, what is forgotten.
//!
//! That rows say the same as JSON lines is seen in Python, over all samples (`tests/test_columns.py`).
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]

use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int64Type, UInt32Type, UInt64Type};
use arrow_schema::{DataType, Schema};

use super::column::ROWS;
use super::cycle_numbers::CycleNumbers;
use super::{Batch, Columns, Name, Seen};
use crate::bytes::frame::{BusId, Buses, CanId, Frame, FrameRef};
use crate::bytes::ns::Ns;
use crate::bytes::select::Select;
use crate::rules::capture::Cap002;
use crate::rules::finding::{Code, Finding, Verdict};
use crate::sdo::transfer::{Beginning, Direction, Mode, Transfer, TransferId};
use crate::sdo::wire::Mux;
use crate::tables::jsonl::Setting;
use crate::views::lines::Clocked;
use crate::wire::message::Message;
use crate::wire::pdo::mapping::Mapping;
use crate::words::Lang;
use crate::world::change::Change;
use crate::world::configuration::Provenance;
use crate::world::event::{Event, Placement, ProcessData, Signals, What};

/// Names and types of all columns, as libraries know them: lines are only ever added.
const FROZEN: &str = "\
frames: frame u64, line u64?, file word, t_ns i64?, bus word?, id u32, extended bool, kind word, brs bool?, esi bool?, \
dir word?, len u8, data binary, service word, node u8?
transfers: transfer u64, bus word?, node u8, client u8?, session u8?, direction word, mode word, index u16?, sub u8?, object word?, name word?, \
type word?, size_indicated u32?, size u64, data binary, string utf8?, boolean bool?, integer i64?, raw u64?, value f64?, \
text utf8, status word, abort_code u32?, abort_by word?, abort_text word?, first_frame u64, last_frame u64, \
first_line u64?, last_line u64?, t_ns i64?, duration_ns i64?, reordered bool, retransmissions u32, crc_negotiated bool?, \
findings [utf8?]
states: t_ns i64?, frame u64, bus word?, node u8?, state u8?, name word?, source word, command u8?
emcy: t_ns i64?, frame u64, bus word?, node u8, code u16, name word?, register u8, manufacturer binary, active [u16?], \
cleared [u16?]
findings: code word, name word, severity word, file word, frame u64?, line u64?, t_ns i64?, cause_frame u64?, \
cause_line u64?, about_frame u64?, because_of u64?, bus word?, node u8?, index u16?, sub u8?, message utf8, facts utf8
sync_cycles: cycle u64, frame u64, t_ns i64?, bus word?, period_ns i64?, counter u8?, pdos u32, delay_min_ns i64?, \
delay_max_ns i64?, window_ns i64?
signals: t_ns i64?, frame u64, line u64?, bus word?, node u8, pdo word, signal word, object word, value f64?, \
integer i64?, raw u64?, data binary?, unit word?, text utf8?, provenance word
pdo/can0/5.TPDO1/1: t_ns i64?, frame u64, provenance word, cycle u64?, delay_ns i64?, running_cycle u64, statusword u16?, \
position actual value i32?, 2000h:00 bool?, 2001h:00 u64?, 2002h:00 u8?
wide/can0/5.TPDO1/1: t_ns i64?, frame u64, provenance word, cycle u64?, delay_ns i64?, running_cycle u64, \
statusword word?, statusword__raw u16?, position actual value i32?, 2000h:00 bool?, 2001h:00 u64?, 2002h:00 u8?
objects: t_ns i64?, frame u64, bus word?, node u8, index u16?, sub u8?, source word, name word?, value f64?, \
integer i64?, text utf8?, unit word?
od: bus word?, node u8, index u16, sub u8, name word?, type word?, type_from word?, bits u64?, access word?, \
readable bool?, writable bool?, exists bool?, value f64?, integer i64?, text utf8?, data binary?, source word?, \
t_ns i64?, frame u64?, values u64, read u64, written u64, tpdo u64, rpdo u64, emcy u64, refused u64, unconfirmed u64, \
abort_codes [u32?], in_force u64?, in_force_from word?, first_frame u64, last_frame u64
listing: frame u64, t_ns i64?, cycle u64, bus word?, node u8?, service word, severity word?, line utf8
lanes: lane word, t_ns i64?, frame u64, cycle u64, state word?, class word?
log: t_ns i64?, frame u64, cycle u64, bus word?, node u8?, level word, source word, code word, text utf8
load: t_ns i64, frame u64, cycle u64, bus word?, frames u32, bits u64, frames_per_s f64, load_percent f64?
problems: id u32, problem word, status word, impact word, grade word, depth u64, bus word?, node u8?, nodes [u8?], \
axis u8?, pdo word?, subject word, begin_frame u64, t_ns i64?, cycle u64, noticed_frame u64, noticed_t_ns i64?, \
end_frame u64?, end_t_ns i64?, end_cycle u64?, count u64, root bool, cause u32?, cause_link word?, cause_grade word?, \
delay_ns i64?, frames [u64?], message utf8, checks utf8, facts utf8
";

fn type_name(data_type: &DataType) -> String {
    match data_type {
        DataType::Boolean => "bool".to_owned(),
        DataType::Dictionary(key, value) if **key == DataType::Int32 && **value == DataType::Utf8 => "word".to_owned(),
        DataType::List(field) => format!("[{}{}]", type_name(field.data_type()), null(field.is_nullable())),
        other => format!("{other:?}").to_lowercase().replace("uint", "u").replace("int", "i").replace("float", "f"),
    }
}

fn null(nullable: bool) -> &'static str {
    if nullable { "?" } else { "" }
}

fn columns_of(schema: &Schema) -> String {
    let fields = schema.fields().iter();
    let fields: Vec<String> = fields
        .map(|field| format!("{} {}{}", field.name(), type_name(field.data_type()), null(field.is_nullable())))
        .collect();
    fields.join(", ")
}

/// A capture on one bus, `can0`, without the session: events are made by hand.
struct Capture {
    columns: Columns,
    buses: Buses,
    no: u64,
    cycle: u64,
    /// The last cycle that has begun.
    begun: u64,
}

impl Capture {
    fn new(tables: &[Name]) -> Self {
        let mut buses = Buses::default();
        buses.intern(b"can0");
        Self {
            columns: Columns::new(Lang::En, &Select::default(), tables, Some(500_000)),
            buses,
            no: 0,
            cycle: 0,
            begun: 0,
        }
    }

    fn frame(&mut self, payload: &[u8], what: What) {
        self.no += 1;
        let id = CanId::standard(0x185);
        let frame = Frame { no: self.no, t_ns: Some(Ns(1000 * self.no as i64)), ..Frame::classic(id, payload) };
        let begins = match what {
            What::Message(Message::Sync { counter }) if self.cycle > self.begun => {
                self.begun = self.cycle;
                Some(What::Change(Change::SyncCycle { cycle: self.cycle, counter }))
            }
            _ => None,
        };
        let at = frame.reference();
        let event = |what| Event { at, about: None, bus: BusId(0), node: Some(5), transfer: None, what };
        let events: Vec<Event> = [Some(what), begins].into_iter().flatten().map(event).collect();
        let setting =
            Setting { lang: Lang::En, file: b"a.log", buses: &self.buses, decimals: 6, clock: Clocked::default() };
        let seen =
            Seen { service: ("pdo", Some(5)), cycle: self.cycle, window_ns: Some(Ns(5_000)), shown: true, setting };
        self.columns.frame(seen, &frame, &events);
    }

    fn frame_at(&mut self, t_ns: Option<Ns>) {
        self.no += 1;
        let frame = Frame { no: self.no, t_ns, ..Frame::classic(CanId::standard(0x705), &[5]) };
        let setting =
            Setting { lang: Lang::En, file: b"a.log", buses: &self.buses, decimals: 6, clock: Clocked::default() };
        let seen = Seen { service: ("heartbeat", Some(5)), cycle: self.cycle, window_ns: None, shown: true, setting };
        self.columns.frame(seen, &frame, &[]);
    }

    fn pdo(&mut self, number: u16, mapping: &Arc<Mapping>, sync: Option<Placement>) {
        let content = Signals::Mapped(Arc::clone(mapping), Provenance::Eds);
        let data = ProcessData { transmit: true, number, node: 5, content, state: None, sync, is_off: false };
        self.frame(&[1, 2, 3, 4, 5, 6, 7, 8], What::Pdo(data));
    }

    fn sync(&mut self, counter: u8) {
        self.cycle += 1;
        self.frame(&[counter], What::Message(Message::Sync { counter: Some(counter) }));
    }

    fn lost(&mut self, code: Code) {
        let setting =
            Setting { lang: Lang::En, file: b"a.log", buses: &self.buses, decimals: 6, clock: Clocked::default() };
        let at = Frame::classic(CanId::standard(0), &[]).reference();
        let Verdict { facts, .. } = Cap002::Dropped { frames: 1, total: 1 }.into();
        let finding =
            Finding { code, at, cause: None, bus: BusId(0), node: None, object: None, facts, because_of: None };
        self.columns.finding(setting, &finding);
    }

    fn end(mut self) -> Vec<Batch> {
        let setting =
            Setting { lang: Lang::En, file: b"a.log", buses: &self.buses, decimals: 6, clock: Clocked::default() };
        self.columns.finish(setting);
        self.columns.take(false)
    }
}

fn shapes(batches: &[Batch]) -> Vec<(&str, usize)> {
    batches.iter().map(|batch| (&*batch.name, batch.rows.num_rows())).collect()
}

#[test]
fn names_and_types_are_frozen() {
    let all: Vec<Name> = Name::NAMES.iter().map(|(_, name)| *name).collect();
    let mut capture = Capture::new(&all);
    let words = [0x6041_0010, 0x6064_0020, 0x0005_0001, 0x2000_0001, 0x2001_0021, 0x2002_0005];
    let mut mapping = Mapping::from_words(&words);
    mapping.entries[3].data_type = Some(crate::world::od::DataType::Boolean);
    capture.pdo(1, &Arc::new(mapping), None);
    let said: String = capture
        .end()
        .iter()
        .map(|batch| format!("{}: {}\n", batch.name, columns_of(batch.rows.schema_ref())))
        .collect();
    assert_eq!(said, FROZEN);
}

#[test]
fn batches_end_by_rows_and_by_bytes() {
    let mapping = Arc::new(Mapping::from_words(&[0x6041_0010]));
    let mut capture = Capture::new(&[Name::Frames, Name::Signals, Name::Pdo]);
    for _ in 0..=ROWS {
        capture.pdo(1, &mapping, None);
    }
    let done = capture.columns.take(false);
    assert_eq!(shapes(&done), [("frames", ROWS), ("signals", ROWS), ("pdo/can0/5.TPDO1/1", ROWS)]);
    assert!(capture.columns.take(false).is_empty());
    assert_eq!(shapes(&capture.columns.take(true)), [("frames", 1), ("signals", 1), ("pdo/can0/5.TPDO1/1", 1)]);
    assert!(capture.end().is_empty());
}

#[test]
fn batches_of_much_data_end_early() {
    let mut capture = Capture::new(&[Name::Transfers]);
    let at = FrameRef { no: 1, ..FrameRef::default() };
    let beginning = Beginning { id: TransferId(1), bus: BusId(0), node: 5, channel: None, extract: false, at };
    let mut transfer = Transfer::new(beginning, Direction::Upload, Mode::Block, Some(Mux { index: 0x2000, sub: 0 }));
    transfer.append(&[0xAA; 100_000]);
    let setting =
        Setting { lang: Lang::En, file: b"a.log", buses: &capture.buses, decimals: 6, clock: Clocked::default() };
    for _ in 0..300 {
        capture.columns.transfer(setting, &transfer);
    }
    let rows: Vec<_> = capture.columns.take(false).iter().map(|batch| batch.rows.num_rows()).collect();
    assert_eq!(rows, [256], "65,536 bytes are kept of each");
    assert_eq!(shapes(&capture.end()), [("transfers", 44)]);
}

#[test]
fn many_mappings_are_forgotten_but_not_their_numbers() {
    let mut capture = Capture::new(&[Name::Pdo]);
    let mappings: Vec<_> =
        (0..9000).map(|number| Arc::new(Mapping::from_words(&[(0x2000 + number) << 16 | 0x10]))).collect();
    for mapping in &mappings {
        capture.pdo(1, mapping, None);
    }
    capture.pdo(1, &mappings[8999], None);
    capture.pdo(1, &mappings[0], None);
    let batches = capture.end();
    let mut names: Vec<_> = batches.iter().map(|batch| Arc::clone(&batch.name)).collect();
    assert_eq!(batches.iter().map(|batch| batch.rows.num_rows()).sum::<usize>(), 9002);
    names.sort();
    names.dedup();
    assert_eq!(names.len(), 9001, "the first came again after all were forgotten: another table");
    assert!(names.contains(&Arc::from("pdo/can0/5.TPDO1/9001")));
}

#[test]
fn equal_mappings_share_a_table() {
    let mut capture = Capture::new(&[Name::Pdo]);
    for _ in 0..10 {
        capture.pdo(2, &Arc::new(Mapping::from_words(&[0x6041_0010])), None);
        capture.pdo(2, &Arc::new(Mapping::from_words(&[0x6064_0020])), None);
    }
    let mut batches = capture.end();
    batches.sort_by(|one, other| one.name.cmp(&other.name));
    assert_eq!(shapes(&batches), [("pdo/can0/5.TPDO2/1", 10), ("pdo/can0/5.TPDO2/2", 10)]);
}

#[test]
fn cycles_end_with_the_next() {
    let mapping = Arc::new(Mapping::from_words(&[0x6041_0010]));
    let placed = |cycle, delay| Some(Placement { cycle, delay_ns: Some(delay) });
    let mut capture = Capture::new(&[Name::SyncCycles]);
    capture.pdo(1, &mapping, None);
    capture.sync(1);
    capture.pdo(1, &mapping, placed(1, Ns(30)));
    capture.pdo(2, &mapping, placed(1, Ns(10)));
    // Its SYNC comes late.
    capture.pdo(3, &mapping, placed(2, Ns(-5)));
    capture.sync(2);
    // A copy of it begins no cycle.
    capture.cycle -= 1;
    capture.sync(2);
    capture.lost(Code::Cap002);
    capture.sync(3);
    capture.lost(Code::Cap003);
    capture.sync(4);
    let batches = capture.end();
    assert_eq!(shapes(&batches), [("sync_cycles", 4)]);
    let rows = &batches[0].rows;
    let numbers = |name| rows.column_by_name(name).unwrap().as_primitive::<Int64Type>().iter().collect::<Vec<_>>();
    let cycles = rows.column_by_name("cycle").unwrap().as_primitive::<UInt64Type>();
    assert_eq!(cycles.values(), &[1, 2, 3, 4]);
    assert_eq!(rows.column_by_name("pdos").unwrap().as_primitive::<UInt32Type>().values(), &[2, 1, 0, 0]);
    assert_eq!(numbers("delay_min_ns"), [Some(10), Some(-5), None, None]);
    assert_eq!(numbers("delay_max_ns"), [Some(30), Some(-5), None, None]);
    assert_eq!(numbers("period_ns"), [None, Some(4000), None, Some(1000)]);
}

#[test]
fn nothing_asked_for_is_nothing() {
    assert!(Capture::new(&[]).end().is_empty());
    let all: Vec<Name> = Name::NAMES.iter().map(|(_, name)| *name).collect();
    let names: Vec<_> = Capture::new(&all).end().iter().map(|batch| (batch.name.to_string(), 0)).collect();
    let expected = Name::NAMES
        .iter()
        .filter(|row| !matches!(row.1, Name::Pdo | Name::Wide))
        .map(|(name, _)| ((*name).to_owned(), 0));
    assert_eq!(names, expected.collect::<Vec<_>>());
}

#[test]
fn the_cycle_of_an_earlier_frame_is_known() {
    let mut numbers = CycleNumbers::default();
    let frame = |no| Frame { no, ..Frame::classic(CanId::standard(0x80), &[]) };
    assert_eq!(numbers.at(BusId(0), 1), 0);
    // A SYNC every tenth frame, from the fifth on.
    for no in 1..=100_000u64 {
        numbers.frame(&frame(no), (no + 5) / 10);
    }
    for no in [100_000, 99_995, 99_994, 60_000] {
        assert_eq!(numbers.at(BusId(0), no), (no + 5) / 10);
    }
    assert_eq!(numbers.at(BusId(0), 1), 10_000 - 4096, "the oldest that is known");
    assert_eq!(numbers.at(BusId(1), 1), 0);
}

/// Ends in ms and frames of the load of one bus whose frames come at these times, in ms.
fn load(times: &[i64]) -> Vec<(i64, u32)> {
    let mut capture = Capture::new(&[Name::Load]);
    for time in times {
        capture.frame_at(Some(Ns(time * 1_000_000)));
    }
    let batches = capture.end();
    let ends = batches[0].rows.column_by_name("t_ns").unwrap().as_primitive::<Int64Type>().clone();
    let frames = batches[0].rows.column_by_name("frames").unwrap().as_primitive::<UInt32Type>().clone();
    ends.values().iter().map(|ns| ns / 1_000_000).zip(frames.values().iter().copied()).collect()
}

#[test]
fn a_window_ends_with_the_first_frame_behind_it() {
    assert_eq!(load(&[]), []);
    assert_eq!(load(&[0]), [(100, 1)], "the only one, though the capture cuts it");
    assert_eq!(load(&[0, 99]), [(100, 2)]);
    assert_eq!(load(&[0, 99, 100]), [(100, 2)]);
    assert_eq!(load(&[7, 106, 107, 206, 210]), [(107, 2), (207, 2)]);
    assert_eq!(load(&[0, 250]), [(100, 1), (200, 0)]);
    assert_eq!(load(&[0, 350]), [(100, 1), (200, 0), (300, 0)]);
    assert_eq!(load(&[0, 3_600_050]), [(100, 1), (200, 0), (3_600_000, 0)]);
    assert_eq!(load(&[0, 90, 80, 110, 95, 205]), [(100, 3), (200, 2)], "late stamps count where they come");
}

#[test]
fn load_goes_on_when_the_clock_is_set() {
    assert_eq!(load(&[5_000, 5_010, 20, 30, 120]), [(5_100, 2), (120, 2)]);
    assert_eq!(load(&[5_000, 5_990, 20, 130]), [(5_100, 1), (5_200, 0), (5_900, 0), (6_000, 1), (120, 1)]);
    let mut capture = Capture::new(&[Name::Load]);
    for t_ns in [i64::MIN, 0, i64::MAX, i64::MAX, i64::MIN, i64::MAX - 1, -1] {
        capture.frame_at(Some(Ns(t_ns)));
    }
    capture.frame_at(None);
    assert!(capture.end()[0].rows.num_rows() < 30);
}

#[test]
fn load_is_of_the_bit_rate() {
    let mut capture = Capture::new(&[Name::Load]);
    for time in 0..1001 {
        capture.frame_at(Some(Ns::from_ms(time)));
    }
    let batches = capture.end();
    let rows = &batches[0].rows;
    assert_eq!(rows.num_rows(), 10);
    let real = |name| rows.column_by_name(name).unwrap().as_primitive::<Float64Type>().value(3);
    let bits = rows.column_by_name("bits").unwrap().as_primitive::<UInt64Type>().value(3);
    assert_eq!((real("frames_per_s"), real("load_percent")), (1000.0, bits as f64 / 500.0));
}

//! Lanes against captures: every row as it stands, in both languages, and what must not be shown.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]

use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::types::{Int32Type, Int64Type, UInt64Type};
use arrow_array::{Array, DictionaryArray, StringArray};

use crate::bytes::readers::InputFormat as Input;
use crate::session::{Options, Output, Session};
use crate::tables::columns::{Batch, Name};
use crate::views::filter::Filter;
use crate::words::Lang;
use crate::world::dictionary::{Access, Dictionary, Form, Object, Preset};
use crate::world::network::{Description, Network};

fn options(lang: Lang) -> Options {
    Options::of(lang, &[Output::Columns(Name::Lanes)])
}

/// `FRAME LANE CLASS STATE`, `-` for null.
fn rows(capture: &[u8], options: Options) -> Vec<String> {
    rows_in(capture, options, capture.len().max(1))
}

fn rows_in(capture: &[u8], options: Options, chunk: usize) -> Vec<String> {
    let mut session = Session::new(options);
    let mut out = Vec::new();
    session.begin(b"x.log", Input::Candump, true);
    let mut batches = Vec::new();
    for piece in capture.chunks(chunk) {
        session.feed(piece, &mut out);
        batches.extend(session.take_batches(false));
    }
    session.finish(&mut out);
    batches.extend(session.take_batches(false));
    batches.iter().flat_map(listed).collect()
}

fn word(array: &dyn Array, row: usize) -> Option<String> {
    let words: &DictionaryArray<Int32Type> = array.as_dictionary();
    let values: &StringArray = words.values().as_string();
    words.is_valid(row).then(|| values.value(words.keys().value(row) as usize).to_owned())
}

fn listed(batch: &Batch) -> Vec<String> {
    let rows = &batch.rows;
    let column = |name: &str| Arc::clone(rows.column_by_name(name).unwrap());
    let (lane, state, class) = (column("lane"), column("state"), column("class"));
    let (frame, _t) = (column("frame"), column("t_ns"));
    let frame = frame.as_primitive::<UInt64Type>().clone();
    let mut all = Vec::new();
    for row in 0..rows.num_rows() {
        let dash = |text: Option<String>| text.unwrap_or_else(|| "-".to_owned());
        let (lane, class, state) = (word(&lane, row).unwrap(), word(&class, row), word(&state, row));
        all.push(format!("{} {lane} {} {}", frame.value(row), dash(class), dash(state)));
    }
    all
}

fn sample(name: &str) -> Vec<u8> {
    std::fs::read(format!("{}/../../samples/{name}.log", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

fn text(rows: &[String], lanes: &[&str]) -> String {
    let of = |row: &&String| lanes.iter().any(|lane| row.split(' ').nth(1).unwrap().starts_with(lane));
    rows.iter().filter(of).map(|row| format!("{row}\n")).collect()
}

/// Frames of can0, 10 ms apart, or at the time before an `@`: `0.5@705#05`.
fn capture(frames: &[&str]) -> Vec<u8> {
    let line = |(place, frame): (usize, &&str)| match frame.split_once('@') {
        Some((time, frame)) => format!("({time}) can0 {frame}\n"),
        None if frame.starts_with("DROP") => format!("{frame}\n"),
        None => format!("({}.{:03}000) can0 {frame}\n", place / 100, place % 100 * 10),
    };
    frames.iter().enumerate().map(line).collect::<String>().into_bytes()
}

fn object(index: u16, sub: u8, data_type: u16, name: &str, value: Option<u64>) -> Object {
    let preset = value.map(|value| Preset { value, relative: false, configured: false });
    let (access, unit) = (Access::Rw, None);
    Object { index, sub, name: name.into(), data_type, access, preset, mappable: true, unit, factor: 1.0 }
}

/// Node 5: TPDO1 statusword, TPDO2 statusword and mode display, TPDO3 two truth values, a name twice, digital inputs;
/// TPDO4 the statusword of axis 2; RPDO1 controlword.
fn described(lang: Lang) -> Options {
    described_as(lang, "Door open/closed")
}

/// The same with another name for the two.
fn described_as(lang: Lang, name: &str) -> Options {
    let mut objects = vec![
        object(0x6040, 0, 6, "Controlword", None),
        object(0x6041, 0, 6, "Statusword", None),
        object(0x6841, 0, 6, "Statusword", None),
        object(0x6061, 0, 2, "Modes of operation display", None),
        object(0x60FD, 0, 7, "Digital inputs", None),
        object(0x2000, 1, 1, name, None),
        object(0x2000, 2, 1, name, None),
        object(0x2000, 3, 6, "Speed", None),
    ];
    for (parameter, words) in [
        (0x1600, &[0x6040_0010][..]),
        (0x1A00, &[0x6041_0010]),
        (0x1A01, &[0x6041_0010, 0x6061_0008]),
        (0x1A02, &[0x2000_0101, 0x2000_0201, 0x0005_0006, 0x60FD_0020, 0x2000_0310]),
        (0x1A03, &[0x6841_0010]),
    ] {
        objects.push(object(parameter, 0, 5, "mapping", Some(words.len() as u64)));
        for (sub, word) in (1..).zip(words) {
            objects.push(object(parameter, sub, 7, "mapping", Some(*word)));
        }
    }
    objects.sort_by_key(|object| (object.index, object.sub));
    let dictionary = Arc::new(Dictionary::new("x.eds".into(), Form::Eds, String::new(), objects));
    let descriptions = vec![Description { bus: None, node: 5, dictionary }];
    let mut options = options(lang);
    options.known.network = Arc::new(Network { descriptions, ..Network::default() });
    options
}

#[test]
fn chunks_make_no_difference() {
    for name in ["services", "network/drive-states", "network/remapping"] {
        let bytes = sample(name);
        let whole = rows(&bytes, described(Lang::Zh));
        assert!(whole.len() > 8);
        assert_eq!(rows_in(&bytes, described(Lang::Zh), 7), whole, "{name}");
    }
}

#[test]
fn languages_have_the_same_rows() {
    for name in ["services", "network/drive-states", "network/guarding", "network/remapping", "rules/HBT002"] {
        let bytes = sample(name);
        let [zh, en] = [Lang::Zh, Lang::En].map(|lang| rows(&bytes, described(lang)));
        let known = |rows: &[String]| -> Vec<String> {
            let words = rows.iter().map(|row| row.split(' ').take(3).collect::<Vec<_>>());
            // Names of signals differ.
            words.map(|words| format!("{} {} {}", words[0], words[1].rsplit_once('/').unwrap().0, words[2])).collect()
        };
        assert_eq!(known(&zh), known(&en), "{name}");
        assert!(en.iter().all(|row| row.is_ascii()), "{name}");
        assert!(zh.iter().all(|row| row.ends_with('-') || !row.is_ascii() || !row.contains(" nmt/")), "{name}");
    }
}

#[test]
fn without_time_stamps() {
    let capture = b"can0  705   [1]  7F\ncan0  000   [2]  01 05\ncan0  705   [1]  7F\ncan0  705   [1]  05\n";
    // What the node sent before it could obey changes nothing.
    let expected = "1 nmt/can0/node5 pre-operational Pre-operational\n2 nmt/can0/node5 operational Operational (commanded)\n\
                    4 nmt/can0/node5 operational Operational\n";
    assert_eq!(text(&rows(capture, options(Lang::En)), &["nmt/"]), expected);
}

#[test]
fn no_more_than_so_many_texts() {
    let mut frames = Vec::new();
    for number in 0..600_u32 {
        frames.push(format!("385#40{:02X}{:02X}00000000", number & 0xFF, number >> 8));
    }
    frames.push("705#00".to_owned());
    frames.push("385#40000000000000".to_owned());
    let frames: Vec<&str> = frames.iter().map(String::as_str).collect();
    let rows = rows(&capture(&frames), described(Lang::En));
    let lane = "value/can0/node5/TPDO3/digital_inputs ";
    let of: Vec<&String> = rows.iter().filter(|row| row.contains(lane)).collect();
    assert_eq!(of.len(), 512 + 1 + 1 + 1);
    assert!(of[511].ends_with(" - 000001FFh") && of[512].ends_with(" - …") && of[513].ends_with(" - -"));
    assert_eq!(of[514], "602 value/can0/node5/TPDO3/digital_inputs - …");
}

#[test]
fn a_filter_ends_lanes_instead_of_letting_them_lie() {
    let frames = ["705#05", "185#3702", "705#04", "185#3102", "705#04", "705#05", "185#3102"];
    let filter = Filter::parse("frame=1-2,5-7").unwrap();
    let mut options = described(Lang::En);
    options.shown.filter = filter;
    let rows = rows(&capture(&frames), options);
    let expected = "\
1 nmt/can0/node5 operational Operational
2 drive/can0/node5 operation-enabled operation enabled
3 nmt/can0/node5 - -
3 drive/can0/node5 - -
5 nmt/can0/node5 stopped Stopped
6 nmt/can0/node5 operational Operational
7 drive/can0/node5 ready-to-switch-on ready to switch on
";
    assert_eq!(text(&rows, &["nmt/", "drive/"]), expected);
}

#[test]
fn states_and_errors_of_nodes() {
    let rows = rows(&sample("network/boot-and-states"), options(Lang::En));
    let expected = "\
1 nmt/vcan0/node5 pre-operational Pre-operational (boot-up)
2 nmt/vcan0/node6 pre-operational Pre-operational (boot-up)
3 nmt/vcan0/node7 pre-operational Pre-operational (boot-up)
15 nmt/vcan0/node5 pre-operational Pre-operational
16 nmt/vcan0/node6 pre-operational Pre-operational
17 nmt/vcan0/node7 pre-operational Pre-operational
21 nmt/vcan0/node5 operational Operational (commanded)
21 nmt/vcan0/node6 operational Operational (commanded)
21 nmt/vcan0/node7 operational Operational (commanded)
22 nmt/vcan0/node7 operational Operational
24 nmt/vcan0/node6 operational Operational
27 nmt/vcan0/node5 operational Operational
42 emcy/vcan0/node5 active 3210h voltage inside the device
47 emcy/vcan0/node5 active 3210h voltage inside the device + 4210h device temperature
54 emcy/vcan0/node5 - -
55 nmt/vcan0/node6 stopped Stopped (commanded)
56 nmt/vcan0/node6 stopped Stopped
65 nmt/vcan0/node6 operational Operational (commanded)
66 nmt/vcan0/node6 operational Operational
76 nmt/vcan0/node7 pre-operational Pre-operational (commanded)
77 nmt/vcan0/node7 pre-operational Pre-operational
88 nmt/vcan0/node6 initialising Initialisation (commanded)
90 nmt/vcan0/node6 pre-operational Pre-operational (boot-up)
94 emcy/vcan0/node7 active 8110h CAN overrun (objects lost)
96 emcy/vcan0/node7 - -
97 nmt/vcan0/node7 initialising Initialisation (commanded)
98 nmt/vcan0/node7 pre-operational Pre-operational (boot-up)
99 nmt/vcan0/node6 pre-operational Pre-operational
106 nmt/vcan0/node7 pre-operational Pre-operational
110 nmt/vcan0/node6 operational Operational (commanded)
110 nmt/vcan0/node7 operational Operational (commanded)
111 nmt/vcan0/node7 operational Operational
113 nmt/vcan0/node6 operational Operational
";
    assert_eq!(text(&rows, &["nmt/", "emcy/", "drive/"]), expected);
}

#[test]
fn who_is_not_heard_is_lost() {
    for (name, expected) in [
        ("rules/HBT002", "3 nmt/can0/node5 pre-operational Pre-operational\n8 nmt/can0/node5 lost heartbeat lost\n"),
        (
            "rules/GRD002",
            "4 nmt/can0/node5 pre-operational Pre-operational\n8 nmt/can0/node5 lost guarding unanswered\n\
             10 nmt/can0/node5 pre-operational Pre-operational\n",
        ),
        (
            "rules/HBT005",
            "3 nmt/can0/node5 pre-operational Pre-operational\n4 nmt/can0/node6 operational Operational\n\
             11 nmt/can0/node5 unknown unknown (silent bus)\n11 nmt/can0/node6 unknown unknown (silent bus)\n\
             13 nmt/can0/node5 pre-operational Pre-operational\n14 nmt/can0/node6 operational Operational\n",
        ),
        // Bit 7 in a heartbeat is no toggle bit: the state counts for nothing.
        ("rules/HBT003-bit-7", "3 nmt/can0/node5 pre-operational Pre-operational\n"),
        // The node goes on as it was.
        (
            "rules/NMT002",
            "3 nmt/can0/node5 pre-operational Pre-operational\n8 nmt/can0/node5 operational Operational (commanded)\n\
             9 nmt/can0/node5 pre-operational Pre-operational\n",
        ),
    ] {
        assert_eq!(text(&rows(&sample(name), options(Lang::En)), &["nmt/"]), expected, "{name}");
    }
}

#[test]
fn a_clock_that_is_wrong_for_a_moment() {
    // The silence that it seems to end does not reach back to where the state began.
    let mut frames: Vec<String> = (0..20).map(|at| format!("{}.{}@705#05", 1_700_000_000 + at / 10, at % 10)).collect();
    frames.extend(["5.0@705#05", "1700000002.1@705#05", "1700000002.2@705#05"].map(str::to_owned));
    let frames: Vec<&str> = frames.iter().map(String::as_str).collect();
    let mut session = Session::new(options(Lang::En));
    session.begin(b"x.log", Input::Candump, true);
    session.feed(&capture(&frames), &mut Vec::new());
    session.finish(&mut Vec::new());
    let batches = session.take_batches(false);
    let stamps = batches[0].rows.column_by_name("t_ns").unwrap().as_primitive::<Int64Type>().values().to_vec();
    assert_eq!(listed(&batches[0])[1], "22 nmt/can0/node5 unknown unknown (silent bus)");
    assert_eq!(stamps[1], 1_700_000_002_100_000_000);
}

#[test]
fn a_guarded_node() {
    let rows = rows(&sample("network/guarding"), options(Lang::Zh));
    let expected = "\
1 nmt/vcan0/node4 pre-operational 启动(Boot-up)
17 nmt/vcan0/node4 pre-operational 预操作状态
24 nmt/vcan0/node4 operational 操作状态 (已命令)
26 nmt/vcan0/node4 operational 操作状态
49 nmt/vcan0/node4 stopped 停止状态 (已命令)
51 nmt/vcan0/node4 stopped 停止状态
56 nmt/vcan0/node4 pre-operational 预操作状态 (已命令)
58 nmt/vcan0/node4 pre-operational 预操作状态
63 nmt/vcan0/node4 initialising 初始化 (已命令)
64 nmt/vcan0/node4 pre-operational 启动(Boot-up)
67 nmt/vcan0/node4 pre-operational 预操作状态
";
    assert_eq!(text(&rows, &["nmt/"]), expected);
}

#[test]
fn behind_a_gap_nothing_holds() {
    let dropped = "DROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 3)";
    let frames = [
        "705#05",
        "185#3702",
        "385#41050000000800",
        "085#3081010000000000",
        "605#4041600000000000",
        "585#4B41600037020000",
        dropped,
        "385#41050000000800",
        "705#05",
        "085#1032010000000000",
    ];
    let rows = rows(&capture(&frames), described(Lang::En));
    let expected = "\
1 nmt/can0/node5 operational Operational
2 value/can0/node5/TPDO1/statusword operation-enabled 0237h operation enabled
2 drive/can0/node5 operation-enabled operation enabled
3 value/can0/node5/TPDO3/Door_open%2Fclosed 1 1
3 value/can0/node5/TPDO3/Door_open%2Fclosed(2000:02) 0 0
3 value/can0/node5/TPDO3/digital_inputs - 00000005h
4 emcy/can0/node5 active 8130h life guard error or heartbeat error
5 sdo/can0/node5 ok 6041h:00 read 0237h operation enabled
6 nmt/can0/node5 unknown unknown (gap in the capture)
6 drive/can0/node5 - -
6 emcy/can0/node5 - -
6 value/can0/node5/TPDO1/statusword - -
6 pdo/can0/node5/TPDO3 - -
6 value/can0/node5/TPDO3/Door_open%2Fclosed - -
6 value/can0/node5/TPDO3/Door_open%2Fclosed(2000:02) - -
6 value/can0/node5/TPDO3/digital_inputs - -
7 value/can0/node5/TPDO3/Door_open%2Fclosed 1 1
7 value/can0/node5/TPDO3/Door_open%2Fclosed(2000:02) 0 0
7 value/can0/node5/TPDO3/digital_inputs - 00000005h
8 nmt/can0/node5 operational Operational
9 emcy/can0/node5 active 3210h DC link over-voltage
6 sdo/can0/node5 - -
";
    assert_eq!(text(&rows, &[""]), expected);
}

#[test]
fn echoes_that_come_late() {
    // The boot-up before the reset that caused it, the state before its command, a PDO that was under way.
    let frames = [
        "0.000000@605#4000100000000000",
        "0.001000@585#4300100092010000",
        "0.100000@705#05",
        "0.200000@705#00",
        "0.200100@000#8105",
        "0.300000@705#05",
        "0.301000@000#0105",
        "0.400000@185#3702",
        "0.500000@000#8005",
        "0.500400@185#3702",
        "0.500500@705#05",
        "0.600000@705#7F",
    ];
    let rows = rows(&capture(&frames), described(Lang::En));
    let expected = "\
3 nmt/can0/node5 operational Operational
4 nmt/can0/node5 pre-operational Pre-operational (boot-up)
6 nmt/can0/node5 operational Operational
8 drive/can0/node5 operation-enabled operation enabled
9 nmt/can0/node5 pre-operational Pre-operational (commanded)
9 drive/can0/node5 - -
12 nmt/can0/node5 pre-operational Pre-operational
";
    assert_eq!(text(&rows, &["nmt/", "drive/"]), expected);
}

#[test]
fn bits_have_lanes_once_they_change() {
    let frames = [
        "385#00000000000000",
        "385#00040000000000",
        "385#00050000000000",
        "000#0205",
        "705#05",
        "385#00090000000000",
        "385#41",
    ];
    let rows = rows(&capture(&frames), described(Lang::Zh));
    let expected = "\
1 value/can0/node5/TPDO3/数字输入 - 00000000h
2 value/can0/node5/TPDO3/数字输入 - 00000004h
1 value/can0/node5/TPDO3/数字输入.2 0 0
2 value/can0/node5/TPDO3/数字输入.2 1 1
3 value/can0/node5/TPDO3/数字输入 - 00000005h
1 value/can0/node5/TPDO3/数字输入.0 0 0
3 value/can0/node5/TPDO3/数字输入.0 1 1
4 value/can0/node5/TPDO3/数字输入 - -
4 value/can0/node5/TPDO3/数字输入.0 - -
4 value/can0/node5/TPDO3/数字输入.2 - -
6 value/can0/node5/TPDO3/数字输入 - 00000009h
6 value/can0/node5/TPDO3/数字输入.0 1 1
6 value/can0/node5/TPDO3/数字输入.2 0 0
7 value/can0/node5/TPDO3/数字输入 - -
7 value/can0/node5/TPDO3/数字输入.0 - -
7 value/can0/node5/TPDO3/数字输入.2 - -
";
    assert_eq!(text(&rows, &["value/can0/node5/TPDO3/数"]), expected);
}

#[test]
fn a_long_name_is_cut() {
    // Titles of lanes are read; two that are cut alike are still two.
    let long = "n".repeat(200);
    let rows = rows(&capture(&["385#0100000000000000"]), described_as(Lang::En, &long));
    let cut = format!("1 value/can0/node5/TPDO3/{}…", "n".repeat(64));
    assert_eq!(text(&rows, &["value/can0/node5/TPDO3/n"]), format!("{cut} 1 1\n{cut}(2000:02) 0 0\n"));
}

#[test]
fn drives_of_two_axes() {
    let frames = ["485#3102", "185#3102", "485#3302", "485#2200", "705#00", "485#3102", "000#0205"];
    let rows = rows(&capture(&frames), described(Lang::Zh));
    let expected = "\
1 drive/can0/node5/axis2 ready-to-switch-on 准备接通
2 drive/can0/node5 ready-to-switch-on 准备接通
3 drive/can0/node5/axis2 switched-on 已接通
4 drive/can0/node5/axis2 - -
5 drive/can0/node5 - -
6 drive/can0/node5/axis2 ready-to-switch-on 准备接通
7 drive/can0/node5/axis2 - -
";
    assert_eq!(text(&rows, &["drive/"]), expected);
}

#[test]
fn statuswords_of_what_is_no_drive() {
    // An encoder says so; then 6041h is no statusword. Nor is it where nobody knows the mapping.
    let read = ["605#4041600000000000", "585#4B41600037020000"];
    let encoder = ["605#4000100000000000", "585#4300100096010000"];
    let frames = [encoder, read].concat();
    assert_eq!(text(&rows(&capture(&frames), options(Lang::En)), &["drive/"]), "");
    assert_eq!(text(&rows(&capture(&["185#3702"]), options(Lang::En)), &["drive/", "value/"]), "");
    let expected = "2 drive/can0/node5 operation-enabled operation enabled\n";
    assert_eq!(text(&rows(&capture(&read), options(Lang::En)), &["drive/"]), expected);
}

#[test]
fn transfers() {
    let frames = |name: &str| text(&rows(&sample(name), options(Lang::En)), &["sdo/"]);
    let expected = "\
1 sdo/can0/node10 ok 2002h:00 read 90 (5Ah)
2 sdo/can0/node10 - -
3 sdo/can0/node10 incomplete 1008h:00 read: incomplete
4 sdo/can0/node10 - -
5 sdo/can0/node10 ok 2002h:00 read 90 (5Ah)
6 sdo/can0/node10 - -
";
    assert_eq!(frames("rules/SDO008"), expected);
    let zh = text(&rows(&sample("sdo-abort"), options(Lang::Zh)), &["sdo/"]);
    assert!(zh.contains(": 中止 "), "{zh}");
}

#[test]
fn a_transfer_of_one_frame_has_a_length() {
    // A request that nobody answers, up to the end of the capture.
    let unanswered = capture(&["60A#4000100000000000", "70A#05"]);
    let open = "1 sdo/can0/node10 incomplete 1000h:00 read: incomplete\n";
    assert_eq!(text(&rows(&unanswered, options(Lang::En)), &["sdo/"]), open);
    // One that a restart leaves open, whichever frame tells of it.
    let restarted =
        capture(&["60A#4000100000000000", "70A#00", "70A#7F", "60A#4000100000000000", "58A#4300100092010000"]);
    let found = text(&rows(&restarted, options(Lang::En)), &["sdo/"]);
    let (first, others) = found.split_at(open.len());
    assert_eq!(first, open);
    let others: Vec<&str> = others.lines().collect();
    assert!(["2 sdo/can0/node10 - -", "3 sdo/can0/node10 - -"].contains(&others[0]), "{found}");
    assert_eq!(
        others[1..],
        ["4 sdo/can0/node10 ok 1000h:00 read 00000192h (device profile 402)", "5 sdo/can0/node10 - -"]
    );
}

#[test]
fn samples_of_a_plot_do_not_hold_on() {
    let pdo = "385#0000000000002A00";
    // Stopped, and a PDO that was on its way; started, restarted.
    let frames = [
        "705#05",
        pdo,
        "0.02@000#0205",
        "0.0205@385#0000000000002B00",
        "0.03@705#04",
        "0.04@000#0105",
        "0.05@705#05",
        "0.06@385#0000000000002C00",
        "0.07@705#00",
        "0.08@705#00",
    ];
    let found = rows(&capture(&frames), described(Lang::En));
    let lane = "pdo/can0/node5/TPDO3 - -\n";
    assert_eq!(text(&found, &["pdo/"]), format!("3 {lane}4 {lane}9 {lane}"));
    // PDOs without quantities are not plotted.
    let frames = ["705#05", "185#3702", "705#00"];
    assert_eq!(text(&rows(&capture(&frames), described(Lang::En)), &["pdo/"]), "");
}

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]

use std::fmt::Write;

use proptest::prelude::*;

use super::super::Contents;
use super::Asc;
use crate::bytes::frame::{Buses, Direction, Frame, Kind};
use crate::bytes::readers::lines::MAX_LINE;
use crate::bytes::readers::{Item, Marker};

/// Returns all items, one on each line, with the text cut repeatedly at the given places.
fn items(text: &[u8], cuts: &[usize]) -> (String, Contents) {
    let mut reader = Asc::default();
    let mut buses = Buses::default();
    let mut out = String::new();
    let mut sink = |item: Item, buses: &Buses| match item {
        Item::Frame(frame) => writeln!(out, "{}: {}", frame.line.unwrap(), shown(&frame, buses)).unwrap(),
        Item::Marker(Marker::Start { date_ns }) => writeln!(out, "start {}", date_ns.as_ns()).unwrap(),
        Item::Marker(Marker::Dropped { bus, count, total, .. }) => {
            writeln!(out, "dropped {count} {total} {}", String::from_utf8_lossy(buses.name(bus))).unwrap();
        }
        Item::Marker(Marker::LeftOut { count, place, .. }) => {
            let count = count.map_or("?".to_owned(), |count| count.to_string());
            writeln!(out, "Left out {count} at {}", place.line().unwrap()).unwrap();
        }
        Item::Unreadable { place, reason } => writeln!(out, "{}! {reason:?}", place.line().unwrap()).unwrap(),
        other => writeln!(out, "{other:?}").unwrap(),
    };
    let mut rest = text;
    for cut in cuts {
        let (piece, after) = rest.split_at(*cut.min(&rest.len()));
        reader.feed(piece, &mut buses, &mut sink);
        rest = after;
    }
    reader.feed(rest, &mut buses, &mut sink);
    reader.finish(&mut buses, &mut sink);
    writeln!(out, "{} lines", reader.lines()).unwrap();
    (out, reader.contents())
}

fn shown(frame: &Frame, buses: &Buses) -> String {
    let mut out = String::new();
    if let Some(t_ns) = frame.t_ns {
        write!(out, "{} ", t_ns.as_ns()).unwrap();
    }
    out.push_str(&String::from_utf8_lossy(buses.name(frame.bus)));
    out.push_str(match frame.dir {
        Some(Direction::Rx) => " rx",
        Some(Direction::Tx) => " tx",
        None => "",
    });
    write!(out, " {:?}", frame.id).unwrap();
    match frame.kind {
        Kind::Data => {}
        Kind::Remote => out.push_str(" rtr"),
        Kind::Fd { brs, esi } => {
            write!(out, " fd{}{}", if brs { "B" } else { "" }, if esi { "E" } else { "" }).unwrap();
        }
        Kind::Error => out.push_str(" error"),
    }
    write!(out, " {} ", frame.len).unwrap();
    for byte in frame.payload() {
        write!(out, "{byte:02X}").unwrap();
    }
    if frame.length_form.raw_dlc != 0 {
        write!(out, " dlc{:X}", frame.length_form.raw_dlc).unwrap();
    }
    assert!(frame.data[if frame.kind == Kind::Remote { 0 } else { usize::from(frame.len) }..].iter().all(|&b| b == 0));
    out.trim_end().to_owned()
}

fn read(text: &str) -> String {
    items(text.as_bytes(), &[]).0
}

/// Returns the items of one line with its newline, without line numbers, and the kinds passed over.
fn one(header: &str, line: &str) -> String {
    let (text, contents) = items(format!("{header}{line}\n").as_bytes(), &[]);
    let mut out: Vec<String> = text.lines().map(str::to_owned).collect();
    out.pop();
    let lines = header.lines().count() + 1;
    let mut out: Vec<String> =
        out.iter().map(|item| item.replace(&format!("{lines}: "), "").replace(&format!("{lines}! "), "! ")).collect();
    for (kind, count) in contents.passed_over {
        assert_eq!(count, 1);
        out.push(format!("({})", String::from_utf8_lossy(&kind)));
    }
    out.join(" ")
}

#[test]
fn classic_lines() {
    for (line, expected) in [
        ("   0.000000 1  601             Rx   d 8 40 08 10 00 00 00 00 00", "0 can0 rx 601 8 4008100000000000"),
        (" 1.5 2 6f9 Tx d 1 fE", "1500000000 can1 tx 6F9 1 FE"),
        ("2.5010 2   C8             Tx   d 8 09 08 07 06 05 04 03 02\r", "2501000000 can1 tx 0C8 8 0908070605040302"),
        ("\u{FEFF}1.123456789 12 18EBFF00x\tRx\td 0", "1123456789 can11 rx 18EBFF00 0"),
        (
            "1.5 1 123x Rx d 2 11 22  Length = 273910 BitCount = 141 ID = 418119424x",
            "1500000000 can0 rx 00000123 2 1122",
        ),
        ("1.5 1 601 EngineData Rx d 1 40", "1500000000 can0 rx 601 1 40"),
        ("1.5 1 601 d 1 40", "1500000000 can0 601 1 40"),
        ("1.5 1 Motor_1 Rx d 1 40  Length = 0 BitCount = 9 ID = 1537", "1500000000 can0 rx 601 1 40"),
        ("1.5 1 ABBA Rx d 1 40  Length = 0 BitCount = 9 ID = 418119424x", "1500000000 can0 rx 18EBFF00 1 40"),
        ("1.5 1 3FF Tx d D 55 AA 01 02 03 04 05 06", "1500000000 can0 tx 3FF 8 55AA010203040506 dlcD"),
        ("1.5 1 3FF Tx d 8 55 AA 01 02 03 04 05 06 TE", "1500000000 can0 tx 3FF 8 55AA010203040506"),
        (
            "1.5 1 123x Rx d 9 00 01 02 03 04 05 06 07 08 09 0A 0B",
            "1500000000 can0 rx 00000123 fd 12 000102030405060708090A0B",
        ),
        (
            "1.5 1 123 Rx d 10 00 01 02 03 04 05 06 07 08 09 0A 0B 0C 0D 0E 0F",
            "1500000000 can0 rx 123 fd 16 000102030405060708090A0B0C0D0E0F",
        ),
        ("1.5 1 123 Rx r", "1500000000 can0 rx 123 rtr 0"),
        ("1.5 3 123 Tx r Length = 1704000 BitCount = 145 ID = 88888888x", "1500000000 can2 tx 123 rtr 0"),
        ("1.5 4 123 Tx r 8 Length = 1704000 BitCount = 145 ID = 88888888x", "1500000000 can3 tx 123 rtr 8"),
        ("1.5 4 123x Tx r C", "1500000000 can3 tx 00000123 rtr 8  dlcC"),
        ("1.5 1 ErrorFrame", "1500000000 can0 00000000 error 0"),
        ("1.5 1  ErrorFrame\tECC: 10100010", "1500000000 can0 00000000 error 0"),
        (
            "1.5 2 ErrorFrame Flags = 0xe CodeExt = 0x20a2 Code = 0x82 ID = 0 DLC = 0 Position = 5 Length = 11300",
            "1500000000 can1 00000000 error 0",
        ),
        ("1.5 0 601 Rx d 1 40", "1500000000 canX rx 601 1 40"),
        ("-0.5 1 601 Rx d 1 40", "-500000000 can0 rx 601 1 40"),
        ("594680.67 1 601 Rx d 1 40", "594680670000000 can0 rx 601 1 40"),
        ("1.5 1 601 TxRq d 1 40", "(TxRq)"),
        ("1.5 1 601 Rx d 1", "! Data"),
        ("1.5 1 601 Rx d 2 40", "! Data"),
        ("1.5 1 601 Rx d 2 40 4", "! Data"),
        ("1.5 1 601 Rx d 2 40 4G", "! Data"),
        ("1.5 1 601 Rx d 1 40 41", "! Length"),
        ("1.5 1 601 Rx d 11 40", "! Length"),
        ("1.5 1 601 Rx d", "! Length"),
        ("1.5 1 601 Rx d x 40", "! Length"),
        ("1.5 1 601 Rx r 8 40", "! Length"),
        ("1.5 1 801 Rx d 1 40", "! Identifier"),
        ("1.5 1 20000000x Rx d 1 40", "! Identifier"),
        ("1.5 1 6Z1 Rx d 1 40", "! Identifier"),
        ("1.5 1 601 Rz d 1 40", "! NoFrame"),
        ("1.5 1 601 Rx e 1 40", "! NoFrame"),
        ("1.5 1 601", "! NoFrame"),
        ("1.5 99999 601 Rx d 1 40", "! NoFrame"),
        ("1.5 CAN1 601 Rx d 1 40", "! NoFrame"),
        ("1.5", "! NoFrame"),
        ("1,5 1 601 Rx d 1 40", "! NoFrame"),
        ("1.5x 1 601 Rx d 1 40", "! NoFrame"),
        ("hello world", "! NoFrame"),
        ("  can0  601   [1]  40", "! NoFrame"),
        ("Timestamp: 1.5 ID: 0601 S Rx DL: 1 40", "! NoFrame"),
    ] {
        assert_eq!(one("", line), expected, "{line}");
        assert_eq!(one("base hex  timestamps absolute\n", line), expected, "{line}");
    }
}

#[test]
fn lines_of_base_10() {
    for (line, expected) in [
        ("1.5 1 291 Rx d 2 1 255", "1500000000 can0 rx 123 2 01FF"),
        ("1.5 1 291 Rx d 2 10 25  Length = 1", "1500000000 can0 rx 123 2 0A19"),
        ("1.5 1 218038280x Rx d 1 0", "1500000000 can0 rx 0CFF0008 1 00"),
        ("1.5 1 291 Rx d D 0 1 2 3 4 5 6 7", "1500000000 can0 rx 123 8 0001020304050607 dlcD"),
        ("1.5 1 291 Rx d 13 0 1 2 3 4 5 6 7", "1500000000 can0 rx 123 8 0001020304050607 dlcD"),
        ("1.5 1 291 Tx r 8", "1500000000 can0 tx 123 rtr 8"),
        ("1.5 1 291 Rx d 1 256", "! Data"),
        ("1.5 1 291 Rx d 1 1 2", "! Length"),
        ("1.5 1 12A Rx d 1 1", "! Identifier"),
        ("1.5 1 2048 Rx d 1 1", "! Identifier"),
        ("1.5 CANFD 1 Rx 123 1 0 2 2 05 FF", "1500000000 can0 rx 123 fdB 2 05FF"),
        ("1.5 CANFD 1 Rx 291 1 0 2 2 5 255", "1500000000 can0 rx 123 fdB 2 05FF"),
    ] {
        assert_eq!(one("base dec  timestamps absolute\n", line), expected, "{line}");
        assert_eq!(one("base dez\n", line), expected, "{line}");
    }
}

#[test]
fn lines_of_fd_and_xl() {
    let tail = "102203  133   303000 e0006659 46500250 4b140250 20011736 2001040d";
    for (line, expected) in [
        (
            format!("1.5 CANFD   2 Rx        300  Generic_Name_12                  1 0 8  8 01 02 03 04 05 06 07 08   {tail}"),
            "1500000000 can1 rx 300 fdB 8 0102030405060708",
        ),
        (format!("1.5 CANFD 2 Tx 1C4D80A7x  0 1 9 12 12 c2 03 04 05 06 07 08 09 0A 0b 0C {tail}"), "1500000000 can1 tx 1C4D80A7 fdE 12 12C2030405060708090A0B0C"),
        ("1.5 CANFD 1 Rx 168 1 0 2 02 08 09".into(), "1500000000 can0 rx 168 fdB 2 0809"),
        ("1.5 CANFD 1 Rx 750 0 0 2 2 01 02 244000 126 200000 7e04 51200550 4b140250".into(), "1500000000 can0 rx 750 2 0102"),
        ("1.5 CANFD 3 Tx 50005x 0 0 5 0 140000 73 200050 7a60 46500250 460a0250".into(), "1500000000 can2 tx 00050005 rtr 5"),
        ("1.5 CANFD 1 Rx 123 0 0 D 8 11 22 33 44 55 66 77 88 130000 130 0 0".into(), "1500000000 can0 rx 123 8 1122334455667788 dlcD"),
        ("1.5 CANFD 1 Rx 123 0 0 9 12 11 22 33 44 55 66 77 88 99 00 AA BB 130000 130 0 0".into(), "1500000000 can0 rx 123 fd 12 112233445566778899" ),
        ("1.5 CANFD 1 123 Tx 1 0 d 8 8 11 22 33 44 55 66 77 88".into(), "1500000000 can0 tx 123 fdB 8 1122334455667788"),
        ("1.5 CANFD 1 123x Tx 1 0 r 8".into(), "1500000000 can0 tx 00000123 rtr 8"),
        ("1.5 CANFD 1 Rx 123 0 0 8 0".into(), "1500000000 can0 rx 123 rtr 8"),
        ("1.5 CANFD 1 Rx 123 0 0 0 0".into(), "1500000000 can0 rx 123 fd 0"),
        ("1.5 CANFD 1 Rx 123 0 0 10 16 00 01 02 03 04 05 06 07 08 09 0A 0B 0C 0D 0E 0F".into(), "1500000000 can0 rx 123 fd 16 000102030405060708090A0B0C0D0E0F"),
        ("1.5 CANFD   5 Tx ErrorFrame Not Acknowledge error, dominant error flag fffe c7 31ca Arb. 556 44 0 0 f 64 00 00".into(), "1500000000 can4 tx 00000000 error 0"),
        ("1.5 CANFD 1 TxRq 123 0 0 0 0".into(), "(TxRq)"),
        ("1.5 CANXL   2 Rx   XLFF   984438   4656      432  msgCanXlTest1 e0 0  1fe  511 1 1f96 00 00000000 e1 89".into(), "! CanXl"),
        ("1.5 CANXL   2 Rx   CBFF   243215   176      432  msgCanCCTest1 f 8 e1 89 e8 c2 b9 6d 5a f1 174 00000000 00000000".into(), "1500000000 can1 rx 432 8 E189E8C2B96D5AF1 dlcF"),
        ("1.5 CANXL   2 Rx   CEFF   243215   176      432x 5 0 174 00000010 00000000".into(), "1500000000 can1 rx 00000432 rtr 5"),
        ("1.5 CANXL 2 Rx FBFF 243215 176 432 name 9 12 e1 89 e8 c2 b9 6d 5a f1 11 22 33 44 a 12345 00003040 0".into(), "1500000000 can1 rx 432 fdB 12 E189E8C2B96D5AF111223344"),
        ("1.5 CANFD 1 Rx 123 0 0 9 11 11".into(), "! Data"),
        ("1.5 CANFD 1 Rx 123 0 0 8 65 11".into(), "! Length"),
        ("1.5 CANFD 1 Rx 123 0 0 8 2 11 22".into(), "! Length"),
        ("1.5 CANFD 1 Rx 923 0 0 1 1 11".into(), "! Identifier"),
        ("1.5 CANFD 1 Rx name 0 0 1 1 11".into(), "! Identifier"),
        ("1.5 CANFD 1 Rx 123 0 2 1 1 11".into(), "! NoFrame"),
        ("1.5 CANFD 1 Rx 123".into(), "! NoFrame"),
        ("1.5 CANFD 1".into(), "! NoFrame"),
        ("1.5 CANFD x Rx 123 0 0 1 1 11".into(), "! NoFrame"),
    ] {
        let expected = if expected.ends_with("112233445566778899") { format!("{expected}00AABB") } else { expected.into() };
        assert_eq!(one("", &line), expected, "{line}");
    }
}

#[test]
fn what_is_no_frame_is_counted_by_kind() {
    for (line, kind) in [
        ("0.000000 Start of measurement", "Start of measurement"),
        ("0.000000 Start der Messung", "Start of measurement"),
        ("0.015991 CAN 1 Status:chip status error passive - TxErr: 132 RxErr: 0", "CAN Status"),
        ("1.015991 1  Statistic: D 0 R 0 XD 0 XR 0 E 0 O 0 B 0.00%", "Statistic"),
        ("3.297743 1  J1939TP FEE3p        6    0  0   -   Rx   d 23 A0 0F A6 60", "J1939TP"),
        ("1.0 1 OverloadFrame", "OverloadFrame"),
        ("1.0 SV: 1 0 1 ::Motor::Speed = 5", "SV"),
        ("1.0 Comment: 0 frames as of old: Rx and Tx", "Comment"),
        ("1.0 GMR_Group: Group 1", "GMR_Group"),
        ("1.0 log trigger event", "log"),
        ("1.0 log direct start (0ms)", "log"),
        ("1.0 TFS: [3,1] Test case 1 passed", "TFS"),
        ("1.0 L1 3c Rx 8 01 02", "L1"),
        ("1.0 End of measurement", "End"),
        ("1.0 Lamp := 1", "environment variable"),
        ("1.0 Li 1 3c Rx 8 01 02", "Li"),
    ] {
        assert_eq!(one("", line), format!("({kind})"), "{line}");
    }
    for line in [
        "",
        "   ",
        "\r",
        "// version 9.0.0",
        "//0.000000 previous log file: a.asc",
        "# remark",
        "date Sam Sep 30 15:06:13.191 2017",
        "date of nothing",
        "base hex  no internal events logged",
        "internal events logged",
        "no internal events logged",
        "Begin Triggerblock",
        "begin TriggerBlock Sam Sep 30 15:06:13.191 2017",
        "End TriggerBlock",
    ] {
        assert_eq!(one("", line), "", "{line}");
    }
    for line in [
        "1.0 Something of its own",
        "1.0 1 Something of its own",
        "1.0 Warning: buffer overrun",
        "1.0 CAN 1  601  CAN Frame  Rx  8  40 18 10 01 00 00 00 00",
        "1.0 can0 601 [8] 40 18 10 01 00 00 00 00",
        "1.0 Comment Rx d 1 40",
        "1.0 601 8 40 18 10 01 00 00 00 00",
    ] {
        assert_eq!(one("", line), "! NoFrame", "{line}");
    }
    let many: String = (0..100).map(|kind| format!("1.0 GM{kind} x\n1.0 GM{kind} x\n")).collect();
    let kinds = items(many.as_bytes(), &[]).1.passed_over;
    assert_eq!((kinds.len(), &kinds[63], &kinds[0]), (64, &(b"...".to_vec(), 74), &(b"GM0".to_vec(), 2)));
}

#[test]
fn what_a_file_says_of_itself() {
    let text = "date Sam Sep 30 15:06:13.191 2017\nbase dec  timestamps relative\nno internal events logged\n// version 9.0.0\n//0.000000 previous log file: a b.asc\n0.0 x y\n// version 10\n";
    let contents = items(text.as_bytes(), &[]).1;
    let dialect: Vec<_> =
        contents.dialect.iter().map(|(name, value)| (*name, std::str::from_utf8(value).unwrap())).collect();
    assert_eq!(
        dialect,
        [
            ("date", "Sam Sep 30 15:06:13.191 2017"),
            ("base", "dec"),
            ("timestamps", "relative"),
            ("version", "9.0.0"),
            ("previous log file", "a b.asc"),
        ]
    );
}

#[test]
fn channels_are_told_with_their_buses() {
    let frame = "601 Rx d 1 40";
    let text = format!("// canalyze: channel 3 is vcan0\n0.0 2 {frame}\n0.1 3 {frame}\n0.2 2 {frame}\n0.3 1 {frame}\n");
    let dialect = items(text.as_bytes(), &[]).1.dialect;
    assert_eq!(dialect, [("channels", b"3 = vcan0, 2 = can1, 1 = can0".to_vec())]);
}

#[test]
fn dates_and_blocks() {
    const DATE: i64 = 1_506_783_973_191_000_000;
    let head = "date Sam Sep 30 15:06:13.191 2017\nbase hex  timestamps absolute\n";
    let frame = "1 601 Rx d 1 40";
    assert_eq!(
        read(&format!(
            "{head}Begin Triggerblock Sat Sep 30 03:06:13.191 PM 2017\n0.0 {frame}\n1.0 {frame}\nEnd TriggerBlock\n"
        )),
        format!("start {DATE}\n4: 0 can0 rx 601 1 40\n5: 1000000000 can0 rx 601 1 40\n6 lines\n")
    );
    // A new block, and differences, which count from the previous event, readable or not.
    assert_eq!(
        read(&format!(
            "date Sam Sep 30 15:06:13.191 2017\nbase hex  timestamps relative\n0.5 Start of measurement\n0.5 {frame}\n0.5 1 801 Rx d 0\n0.5 {frame}\nBegin Triggerblock Sam Sep 30 15:07:13.191 2017\n0.5 {frame}\n"
        )),
        format!(
            "start {DATE}\n4: 1000000000 can0 rx 601 1 40\n5! Identifier\n6: 2000000000 can0 rx 601 1 40\nstart {}\n8: 500000000 can0 rx 601 1 40\n8 lines\n",
            DATE + 60_000_000_000
        )
    );
    assert_eq!(read(&format!("Begin TriggerBlock\n1.0 {frame}\n")), "2: 1000000000 can0 rx 601 1 40\n2 lines\n");
}

#[test]
fn what_the_own_writer_leaves() {
    let text = "// canalyze: no date\n// canalyze: channel 1 is vcan0\n// canalyze: directions unknown\n0.5 1 601 Rx d 0\n0.5 2 601 Rx d 0\n// canalyze: directions known\n// canalyze: stamps unknown\n0.5 1 601 Rx d 0\n// canalyze: error 00000088 00 01\n0.6 1 ErrorFrame\n0.6 1 ErrorFrame\n// canalyze: dropped 3 on channel 1, 5 in total\n";
    assert_eq!(
        read(text),
        "4: 500000000 vcan0 601 0\n5: 500000000 can1 601 0\n8: vcan0 rx 601 0\n10: vcan0 00000088 error 2 0001\n11: vcan0 00000000 error 0\ndropped 3 5 vcan0\n12 lines\n"
    );
}

#[test]
fn a_file_that_is_cut() {
    let line = "  13.258199 1  18EBFF00x       Tx   d 8 6A 00 00 00 00 00 00 F0";
    for end in 1..line.len() {
        let got = read(&line[..end]);
        let cut = "1! Cut\n1 lines\n";
        let expected = if line[..end].trim().is_empty() { "1 lines\n" } else { cut };
        assert_eq!(got, expected, "{:?}", &line[..end]);
    }
    assert_eq!(read(line), "1: 13258199000 can0 tx 18EBFF00 8 6A000000000000F0\n1 lines\n");
    for text in [
        "1.0 CANFD 1 Rx 123 0 0 1 1 11 244000 126 20",
        "1.0 CANFD 1 Rx 123 0 0 1 1 1",
        "End Trigg",
        "date",
        "ba",
        "1.0 Start",
        "1.0 1 Stat",
        "1.0 1 name Rx d 1 40 ID = 15",
        "1.0 1 701 Rx r",
        "1.0 CANFD 1 Rx 701 0 0 1 1 05",
        "1.0 CANFD 1 Rx 701 0 0 1 1 05  ",
    ] {
        assert_eq!(read(text), "1! Cut\n1 lines\n", "{text}");
    }
    // Digits of the last byte may be missing, unless it would become too large.
    for (bytes, whole) in
        [("0 1", false), ("0 10", false), ("0 25", false), ("0 30", true), ("1 0", true), ("0 255", true)]
    {
        for line in [format!("1.0 1 1793 Rx d 2 {bytes}"), format!("1.0 CANFD 1 Rx 1793 1 0 2 2 {bytes}")] {
            let got = read(&format!("base dec  timestamps absolute\n{line}"));
            assert_eq!(got.contains("can0 rx 701"), whole, "{line}: {got}");
            assert_eq!(got.contains("! Cut"), !whole, "{line}: {got}");
        }
    }
    assert_eq!(read("1.0 CANFD 1 Rx 701 1 0 1 1 05"), "1: 1000000000 can0 rx 701 fdB 1 05\n1 lines\n");
    let mut reader = Asc::default();
    let mut buses = Buses::default();
    reader.feed(b"1.0 1 601 R", &mut buses, &mut |_, _| panic!());
    reader.interrupt(&mut buses, &mut |_, _| panic!());
    reader.finish(&mut buses, &mut |_, _| panic!());
}

#[test]
fn damage_is_no_comment_and_no_event() {
    let frame = "  1.5 1  601             Rx   d 2 40 08";
    let whole = "1: 1500000000 can0 rx 601 2 4008\n";
    for line in [
        "// remark\0",
        "\0\0\0",
        "no internal events logged\0\0",
        "date Tue Nov 14 \0\0",
        "  1.6 1  601     \0\0",
        "  1.6 1  601             Rx   d 2 40 08\0",
        "  1.6 Start of measurement\0",
        "no internal events loggedX  1.6 1  601             Rx   d 2 40 08",
        "  1.6 1  Statistic: D 1 R 0X 1.6 1  601             Rx   d 2 40 08",
    ] {
        let got = read(&format!("{frame}\n{line}\n"));
        assert!(got.starts_with(whole) && got.ends_with("2! NoFrame\n2 lines\n"), "{line:?}: {got}");
    }
    for columns in ["", "  Length = 244016 BitCount = 125 ID = 1537"] {
        for tail in [" \0", "  1.6 1  602             Rx   d 1 40", "\u{1} 1.6 1  602 Rx d 1 40"] {
            assert_eq!(read(&format!("{frame}{columns}{tail}\n")), format!("{whole}1! NoFrame\n1 lines\n"), "{tail:?}");
        }
        for tail in ["", "\r", "\t// 1.5 is the stamp", " 0 1"] {
            let got = read(&format!("{frame}{columns}{tail}\n"));
            assert_eq!(got, format!("{whole}1 lines\n"), "{tail:?}");
        }
    }
    // Digits of a decimal byte may be damaged.
    assert_eq!(read("base dec\n1.0 1 1793 Rx d 1 2\0"), "2! Data\n2 lines\n");
}

#[test]
fn a_line_without_end() {
    let mut text = vec![b'7'; 3 * MAX_LINE];
    text.extend_from_slice(b"\n1.5 1 601 Rx d 1 40\n");
    for cuts in [&[][..], &[1, 1, 70_000, 1, 120_000], &[3 * MAX_LINE], &[3 * MAX_LINE + 1]] {
        assert_eq!(items(&text, cuts).0, "1! NoFrame\n2: 1500000000 can0 rx 601 1 40\n2 lines\n");
    }
    let mut reader = Asc::default();
    let mut buses = Buses::default();
    for _ in 0..100 {
        reader.feed(&[0; 100_000], &mut buses, &mut |_, _| {});
        assert!(reader.begun.capacity() <= 4 * MAX_LINE);
    }
}

#[test]
fn numbers_without_end() {
    let digits = "9".repeat(300);
    for line in [
        format!("{digits}.{digits} 1 601 Rx d 1 40"),
        format!("1.5 {digits} 601 Rx d 1 40"),
        format!("1.5 1 {digits} Rx d 1 40"),
        format!("1.5 1 601 Rx d {digits} 40"),
        format!("1.5 1 601 Rx r {digits}"),
        format!("1.5 1 name Rx d 1 40 ID = {digits}"),
        format!("1.5 CANFD 1 Rx 601 0 0 {digits} 1 40"),
        format!("1.5 CANFD 1 Rx 601 0 0 1 {digits} 40"),
        format!("date Sat Jan 1 {digits}:00:00 {digits}"),
        "date Sat Jan 1 01:00:00.000 0001\n9223372036.9 1 601 Rx d 0\n-9223372036.9 1 601 Rx d 0\nBegin Triggerblock Sat Jan 1 01:00:00 9999\n9223372036.9 1 601 Rx d 0".to_owned(),
        "base hex timestamps relative\n9223372036.9 1 601 Rx d 0\n9223372036.9 1 601 Rx d 0".to_owned(),
    ] {
        let _ = read(&format!("{line}\n"));
    }
}

fn regex(pattern: &str) -> impl Strategy<Value = String> + use<> {
    proptest::string::string_regex(pattern).unwrap()
}

/// Generates text similar to logs, whole and in pieces.
fn logs() -> impl Strategy<Value = Vec<u8>> {
    let classic = regex(
        "[ ]{0,3}[0-9]{1,2}\\.[0-9]{3,9} [0-2] {1,2}[0-7][0-9A-Fa-f]{2}([0-9a-f]{5}x)?( Name_1)? {1,8}(Rx|Tx|TxRq)? {1,3}([dr] [0-9]( [0-9A-F]{2}){0,9}|d 40( [0-9]{2}){64})(  Length = 1 ID = 5x?)?\r?",
    );
    let fd = regex(
        "1\\.[0-9]{1,9} CANFD +[1-3] [RT]x +[0-7][0-9A-F]{2}x?( +Name)? [01] [01] [0-9a-f] {1,2}([0-8]|12|64)( [0-9a-f]{2}){0,12}( 1 2 [0-7]000)?",
    );
    let other = prop_oneof![
        Just("date Sam Sep 30 15:06:13.191 2017"),
        Just("base dec  timestamps relative"),
        Just("base hex  timestamps absolute"),
        Just("Begin Triggerblock Sat Sep 30 10:06:13.191 PM 2017"),
        Just("End TriggerBlock"),
        Just("   0.000000 Start of measurement"),
        Just("   1.015991 CAN 2 Status:chip status error active"),
        Just("   1.015991 2  Statistic: D 0 R 0 XD 0 XR 0 E 0 O 0 B 0.00%"),
        Just("2.501010 1 ErrorFrame\tECC: 10100010"),
        Just("// canalyze: channel 1 is vcan0"),
        Just("// canalyze: directions unknown"),
        Just("// canalyze: error 00000088 00 01"),
        Just("// canalyze: no date"),
        Just(""),
    ];
    let bytes = prop_oneof![
        4 => classic.prop_map(String::into_bytes),
        2 => fd.prop_map(String::into_bytes),
        3 => other.prop_map(|line| line.as_bytes().to_vec()),
        1 => prop::collection::vec(any::<u8>(), 0..30),
    ];
    let damaged = (bytes, prop::option::weighted(0.2, any::<prop::sample::Index>())).prop_map(|(mut line, cut)| {
        if let Some(cut) = cut {
            line.truncate(cut.index(line.len() + 1));
        }
        line
    });
    (prop::collection::vec(damaged, 0..20), any::<bool>()).prop_map(|(lines, newline)| {
        let mut text = lines.join(&b'\n');
        if newline {
            text.push(b'\n');
        }
        text
    })
}

proptest! {
    #[test]
    fn chunking_does_not_matter(text in logs(), cuts in prop::collection::vec(0usize..50, 0..30)) {
        let whole = items(&text, &[]);
        prop_assert_eq!(&whole, &items(&text, &cuts));
        prop_assert_eq!(&whole, &items(&text, &vec![1; text.len()]));
    }

    #[test]
    fn any_bytes_are_survived(text in prop::collection::vec(any::<u8>(), 0..2000), cuts in prop::collection::vec(0usize..500, 0..10)) {
        prop_assert_eq!(items(&text, &[]), items(&text, &cuts));
        let _ = super::line(&text, &mut Buses::default());
    }

    // Each line gives a frame, is unreadable, or is counted.
    #[test]
    fn a_damaged_frame_is_never_silent(frame in "[0-9]\\.[0-9]{6} 1  [0-7][0-9A-F]{2}  [RT]x   d 8( [0-9A-F]{2}){8}", at in any::<prop::sample::Index>(), new in "[!-~]") {
        let mut text = frame.clone();
        let at = at.index(text.len());
        text.replace_range(at..=at, &new);
        prop_assume!(at != 0);
        let (shown, contents) = items(format!("{text}\n").as_bytes(), &[]);
        let counted: u64 = contents.passed_over.iter().map(|(_, count)| count).sum();
        prop_assert_eq!(shown.lines().count() as u64 + counted, 2, "{}", shown);
    }
}

#[test]
fn what_is_pasted_from_a_forum() {
    let frame = "1 601 Rx d 1 40";
    assert_eq!(
        read(&format!("```\n> 1.0 {frame}\n...\n> 1.5 {frame}\n[5 lines omitted]\n```\n")),
        "2: 1000000000 can0 rx 601 1 40\nLeft out ? at 3\n4: 1500000000 can0 rx 601 1 40\nLeft out 5 at 5\n6 lines\n"
    );
    assert_eq!(
        read(&format!("1.0 {frame}\n// canalyze: 6 rows left out\n1.5 {frame}\n")),
        "1: 1000000000 can0 rx 601 1 40\nLeft out 6 at 2\n3: 1500000000 can0 rx 601 1 40\n3 lines\n"
    );
}

#[test]
fn a_piece_without_a_header_tells_its_base() {
    let frames = |text: &str| items(text.as_bytes(), &[1; 40]).0;
    let decimal = "0.0 1 385 Rx d 2 55 12\n0.1 1 385 Rx d 2 55 146\n0.2 1 1409 Rx d 1 5\n";
    let said = frames(decimal);
    assert_eq!((said.matches(" 181 2 ").count(), said.matches(" 581 1 05").count()), (2, 1), "{said}");
    let hexadecimal = "0.0 1 385 Rx d 2 55 12\n0.1 1 385 Rx d 2 55 4\n0.2 1 385 Rx d 1 0A\n0.3 1 385 Rx d 1 5\n";
    let said = frames(hexadecimal);
    assert_eq!((said.matches(" 385 ").count(), said.matches("! Data").count()), (2, 2), "{said}");
    let told = format!("base hex  timestamps absolute\n{decimal}");
    assert_eq!(frames(&told).matches("! ").count(), 2, "what the header says holds");
}

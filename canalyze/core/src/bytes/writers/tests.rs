//! Tests of candump's two forms, for complete frames and for captures without some columns.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]

use super::*;
use crate::bytes::frame::{CanId, Direction, Kind, LengthForm, Stamp, StampForm};
use crate::bytes::ns::Ns;
use crate::bytes::readers::FilePlace;

fn stamped(ns: i64, decimals: u8) -> Frame {
    let stamp = Stamp { form: StampForm::Seconds, ns: Ns(ns), width: 1, decimals };
    Frame { t_ns: Some(Ns(ns)), stamp: Some(stamp), ..Frame::classic(CanId::standard(0x123), &[0x11]) }
}

fn written(format: Format, name: &[u8], date_ns: Option<i64>, frames: &[Frame]) -> (String, Vec<(Loss, u64)>) {
    let mut buses = Buses::default();
    buses.intern(name);
    let mut writer = Writer::new(format, &WriterSettings::default());
    let mut out = Vec::new();
    let setting = CaptureFacts { buses: &buses, date_ns: date_ns.map(Ns) };
    for frame in frames {
        writer.frame(&mut out, setting, frame);
    }
    writer.finish(&mut out, setting);
    (String::from_utf8(out).unwrap(), writer.losses().iter().collect())
}

#[test]
fn candump_log_lines() {
    let full = [0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88];
    let raw_dlc = LengthForm { raw_dlc: 12, ..LengthForm::default() };
    let at = |kind, id, payload: &[u8], dir| Frame {
        kind,
        dir,
        stamp: stamped(0, 9).stamp,
        t_ns: Some(Ns(1_700_000_000_123_456_789)),
        ..Frame::classic(id, payload)
    };
    let standard = CanId::standard(0x7F);
    let remote = Frame { len: 8, length_form: raw_dlc, ..at(Kind::Remote, standard, &[], None) };
    let rows = [
        (at(Kind::Data, standard, &[], None), "07F#"),
        (Frame { length_form: raw_dlc, ..at(Kind::Data, standard, &full, None) }, "07F#1122334455667788_C"),
        (at(Kind::Data, CanId::extended(0x7F), &[1], Some(Direction::Rx)), "0000007F#01 R"),
        (at(Kind::Remote, standard, &[], Some(Direction::Tx)), "07F#R T"),
        (remote, "07F#R8_C"),
        (at(Kind::Fd { brs: true, esi: false }, standard, &[1, 2], None), "07F##10102"),
        (at(Kind::Fd { brs: false, esi: true }, standard, &[], None), "07F##2"),
        (at(Kind::Error, CanId::standard(4), &full, None), "20000004#1122334455667788"),
    ];
    for (frame, line) in rows {
        let (text, losses) = written(Format::Log, b"can1", None, &[frame]);
        assert_eq!(text, format!("(1700000000.123456789) can1 {line}\n"));
        assert_eq!(losses, []);
    }
}

#[test]
fn stamps_that_are_missing_go_on_from_the_last() {
    let bare = Frame::classic(CanId::standard(0x123), &[]);
    let before = Frame { t_ns: Some(Ns(-1)), ..stamped(-1, 9) };
    let (text, losses) = written(Format::Log, b"", None, &[bare, bare, stamped(5_000_000_000, 3), bare, before]);
    let stamps: Vec<&str> = text.lines().map(|line| line.split(' ').next().unwrap()).collect();
    let due = ["0000000000.000000", "0000000000.001000", "0000000005.000000", "0000000005.001000"];
    assert_eq!(stamps[..4], due.map(|stamp| format!("({stamp})")));
    assert_eq!(losses, [(Loss::NoStamp, 4)]);
    assert!(text.lines().all(|line| line.contains(" can0 ")));
    let (text, losses) = written(Format::Console, b"", None, &[bare]);
    assert_eq!((text.as_str(), losses.as_slice()), ("  123   [0] \n", &[][..]));
}

#[test]
fn stamps_count_from_the_date() {
    let date = 1_700_000_000_000_000_000;
    let (text, _) = written(Format::Log, b"can0", Some(date), &[stamped(1_500_000_000, 3)]);
    assert_eq!(text, "(1700000001.500000) can0 123#11\n");
    let (text, _) = written(Format::Console, b"can0", Some(date), &[stamped(1_500_000_000, 3)]);
    assert_eq!(text, " (1700000001.500)  can0  123   [1]  11\n");
    // A difference is written as an absolute time.
    let (text, _) =
        written(Format::Console, b"can0", None, &[Frame { t_ns: Some(Ns(7_000_000)), ..stamped(2_000_000, 3) }]);
    assert_eq!(text, " (0.007)  can0  123   [1]  11\n");
}

#[test]
fn names_that_text_cannot_hold() {
    let rows: &[(&[u8], &str, u64)] = &[
        (b"can0", "can0", 0),
        (b"vcan-0.1", "vcan-0.1", 0),
        (b"/can/front left", "can/front_left", 1),
        (b"a#b\x1B", "a_b_", 1),
        (b"\xE6\x80\xBB", "bus0", 1),
        (b"  ", "bus0", 1),
    ];
    for (name, kept, losses) in rows {
        for format in [Format::Log, Format::Console] {
            let (text, lost) = written(format, name, None, &[stamped(0, 6)]);
            assert_eq!(text.split_ascii_whitespace().nth(1), Some(*kept), "{text:?}");
            assert_eq!(lost.iter().map(|(_, count)| count).sum::<u64>(), *losses, "{name:?}");
        }
    }
}

#[test]
fn flags_without_a_direction_have_no_column() {
    let frame = Frame { kind: Kind::Fd { brs: true, esi: false }, ..stamped(0, 6) };
    assert_eq!(written(Format::Console, b"can0", None, &[frame]).1, [(Loss::FdFlags, 1)]);
    let frame = Frame { dir: Some(Direction::Rx), ..frame };
    let (text, losses) = written(Format::Console, b"can0", None, &[frame]);
    assert_eq!((text.as_str(), losses.as_slice()), (" (0.000000)  can0  RX B -  123  [01]  11\n", &[][..]));
}

#[test]
fn markers() {
    let mut buses = Buses::default();
    let bus = buses.intern(b"can0");
    let setting = CaptureFacts { buses: &buses, date_ns: None };
    let place = FilePlace::Line(1);
    let gap = Marker::Dropped { bus, count: 1, total: 2, place };
    let error = Marker::Error { bus, stamp: None, place };
    let counted = Marker::LeftOut { count: Some(5), rows: Some((14, 20)), place };
    let uncounted = Marker::LeftOut { count: None, rows: None, place };
    for (format, lines, losses) in [
        (
            Format::Log,
            "DROPCOUNT: dropped 1 CAN frame on 'can0' socket (total drops 2)\n... 5 rows left out ...\n...\n",
            1,
        ),
        (
            Format::Console,
            "DROPCOUNT: dropped 1 CAN frame on 'can0' socket (total drops 2)\n  can0  ERROR\n... 5 rows left out ...\n...\n",
            0,
        ),
    ] {
        let mut writer = Writer::new(format, &WriterSettings::default());
        let mut out = Vec::new();
        for marker in [gap, error, counted, uncounted, Marker::Start { date_ns: Ns(5) }, Marker::Backward { place }] {
            writer.marker(&mut out, setting, &marker);
        }
        assert_eq!(String::from_utf8(out).unwrap(), lines);
        assert_eq!(writer.losses().iter().count(), losses);
    }
}

#[test]
fn every_loss_has_a_name() {
    let losses: std::collections::BTreeSet<Loss> = Loss::NAMES.iter().map(|(_, loss)| *loss).collect();
    assert_eq!(losses.len(), Loss::NAMES.len());
    assert!(losses.contains(&Loss::Direction) && losses.contains(&Loss::Gap));
}

//! What other programs read in the pcapng files that we write: tshark frame by frame, capinfos, editcap.
//!
//! Without these programs there is nothing to compare with, and the tests pass.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::path::{Path, PathBuf};
use std::process::Command;

use canalyze_core::bytes::frame::{Buses, CanId, Direction, Frame, Kind};
use canalyze_core::bytes::ns::Ns;
use canalyze_core::bytes::readers::{FilePlace, InputFormat, Item, Marker, Reader, Settings};
use canalyze_core::bytes::writers::pcapng::Pcapng;
use canalyze_core::bytes::writers::{CaptureFacts, Loss};

/// One of every kind, on two buses.
fn frames(buses: &mut Buses) -> Vec<Frame> {
    let (first, second) = (buses.intern(b"can0"), buses.intern(b"vcan one"));
    let of = |id, bytes: &[u8]| Frame { bus: first, ..Frame::classic(id, bytes) };
    let standard = of(CanId::standard(0x601), &[0x40, 0x08, 0x10, 0, 0, 0, 0, 0]);
    let mut raw_dlc = standard;
    raw_dlc.length_form.raw_dlc = 13;
    let fd = |brs, esi| Frame { kind: Kind::Fd { brs, esi }, ..of(CanId::standard(0x123), &[1, 2, 3]) };
    let mut long = Frame { len: 64, bus: second, ..fd(true, false) };
    long.data = std::array::from_fn(|at| at as u8);
    let mut all = vec![
        standard,
        Frame { dir: Some(Direction::Rx), ..of(CanId::extended(0x1FFF_FFFF), &[1]) },
        Frame { dir: Some(Direction::Tx), bus: second, ..of(CanId::extended(0x123), &[]) },
        Frame { kind: Kind::Remote, len: 4, ..of(CanId::standard(0x70A), &[]) },
        Frame { kind: Kind::Error, ..of(CanId::extended(0x88), &[0, 0, 0, 8, 0, 0, 0, 0]) },
        raw_dlc,
        fd(false, false),
        fd(true, true),
        Frame { id: CanId::extended(0x1234_5678), ..fd(false, true) },
        long,
    ];
    for (no, frame) in (0..).zip(&mut all) {
        frame.t_ns = Some(Ns(1_700_000_000_123_456_789 + no * 1_000_001));
    }
    all
}

fn written(name: &str) -> (PathBuf, Buses, Vec<Frame>) {
    let mut buses = Buses::default();
    let frames = frames(&mut buses);
    let (mut writer, mut out) = (Pcapng::default(), Vec::new());
    let setting = CaptureFacts { buses: &buses, date_ns: None };
    for frame in &frames {
        writer.frame(&mut out, setting, frame);
    }
    let lost = Marker::Dropped { bus: buses_first(), count: 3, total: 3, place: FilePlace::Byte(0) };
    writer.marker(&mut out, setting, &lost);
    writer.finish(&mut out);
    assert_eq!(writer.losses.iter().collect::<Vec<(Loss, u64)>>(), []);
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, &out).unwrap();
    (path, buses, frames)
}

fn buses_first() -> canalyze_core::bytes::frame::BusId {
    canalyze_core::bytes::frame::BusId(0)
}

/// What the program says; `None` where there is none.
fn said(program: &str, args: &[&str]) -> Option<String> {
    let done = Command::new(program).args(args).output().ok()?;
    assert!(done.status.success(), "{program}: {}", String::from_utf8_lossy(&done.stderr));
    Some(String::from_utf8(done.stdout).unwrap())
}

#[test]
fn tshark_reads_the_frames() {
    let (path, buses, frames) = written("tshark.pcapng");
    const FIELDS: &[&str] = &[
        "frame.time_epoch",
        "frame.interface_name",
        "frame.protocols",
        "can.id",
        "can.flags.xtd",
        "can.flags.rtr",
        "can.flags.err",
        "can.len",
        "canfd.flags.brs",
        "canfd.flags.esi",
        "frame.packet_flags_direction",
        "data.data",
    ];
    let path = path.to_str().unwrap();
    let mut args = vec!["-r", path, "-T", "fields", "-E", "separator=,"];
    args.extend(FIELDS.iter().flat_map(|field| ["-e", field]));
    let Some(text) = said("tshark", &args) else { return };
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), frames.len());
    for (line, frame) in lines.iter().zip(&frames) {
        let mut fields = line.split(',');
        let mut next = || fields.next().unwrap();
        let t_ns = frame.t_ns.unwrap();
        assert_eq!(next(), format!("{}.{:09}", t_ns.as_ns() / 1_000_000_000, t_ns.as_ns() % 1_000_000_000));
        assert_eq!(next(), String::from_utf8_lossy(buses.name(frame.bus)));
        let fd = matches!(frame.kind, Kind::Fd { .. });
        let protocol = next();
        // tshark calls an FD frame canfd where the link type does not tell, and can in a tree of its own otherwise.
        assert!(protocol.starts_with("can"), "{line}");
        let id = next();
        if frame.kind != Kind::Error {
            assert_eq!(id.parse::<u32>().unwrap(), frame.id.raw(), "{line}");
        }
        let (extended, remote, error) = (next(), next(), next());
        let flags = [extended, remote, error].map(|flag| flag == "1" || flag == "True");
        let expected = [frame.id.is_extended(), frame.kind == Kind::Remote, frame.kind == Kind::Error];
        // In an error frame only its own flag is shown.
        assert_eq!(flags.get(1..), expected.get(1..), "{line}");
        if frame.kind != Kind::Error {
            assert_eq!(flags, expected, "{line}");
        }
        assert_eq!(next(), frame.len.to_string());
        let (brs, esi) = (next(), next());
        match frame.kind {
            Kind::Fd { brs: b, esi: e } => {
                assert_eq!((brs, esi), (if b { "1" } else { "0" }, if e { "1" } else { "0" }), "{line}");
            }
            _ => assert_eq!((brs, esi, fd), ("", "", false), "{line}"),
        }
        let direction = match frame.dir {
            Some(Direction::Rx) => "1",
            Some(Direction::Tx) => "2",
            None => "",
        };
        assert_eq!(next().trim_start_matches("0x").trim_start_matches('0'), direction, "{line}");
        let data: String = frame.payload().iter().map(|byte| format!("{byte:02x}")).collect();
        if frame.kind == Kind::Data || fd {
            assert_eq!(next(), data, "{line}");
        }
    }
}

#[test]
fn capinfos_counts_and_editcap_copies_them() {
    let (path, _, frames) = written("capinfos.pcapng");
    let path = path.to_str().unwrap();
    let Some(text) = said("capinfos", &["-c", "-I", path]) else { return };
    assert!(text.contains(&format!("Number of packets:   {}", frames.len())), "{text}");
    assert!(text.contains("Number of interfaces in file: 2"), "{text}");
    let ours = items(&std::fs::read(path).unwrap());
    let copy = format!("{path}.copy");
    said("editcap", &[path, &copy]).unwrap();
    let theirs = items(&std::fs::read(&copy).unwrap());
    // editcap leaves out what is said of lost packets at the end.
    assert_eq!((ours.len(), theirs.len()), (frames.len() + 1, frames.len()));
    assert!(ours.iter().zip(&theirs).all(|(ours, theirs)| ours == theirs), "{theirs:?}");
}

fn items(bytes: &[u8]) -> Vec<String> {
    let mut reader = Reader::new(InputFormat::Pcap, &Settings::default());
    let (mut buses, mut items) = (Buses::default(), Vec::new());
    let mut sink = |item: &mut Item, _: &Buses| {
        let text = format!("{item:?}");
        // Another writer has its blocks elsewhere.
        items.push(text.split(", place:").next().unwrap_or_default().to_owned());
    };
    reader.feed(bytes, &mut buses, &mut sink);
    reader.finish(&mut buses, &mut sink);
    items
}

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
use std::collections::BTreeMap;

use super::*;
use crate::bytes::frame::Buses;
use crate::bytes::frame::LengthForm;
use crate::bytes::ns::Ns;

/// Returns the records of some bytes: opcode and content.
fn records(mut bytes: &[u8]) -> Vec<(u8, &[u8])> {
    let mut found = Vec::new();
    while let [opcode, rest @ ..] = bytes {
        let length = u64::from_le_bytes(rest[..8].try_into().unwrap()) as usize;
        found.push((*opcode, &rest[8..8 + length]));
        bytes = &rest[8 + length..];
    }
    found
}

/// Returns the records of a file without the magic, with chunks opened.
fn open(file: &[u8]) -> Vec<(u8, Vec<u8>)> {
    let inner = &file[8..file.len() - 8];
    assert_eq!((&file[..8], &file[file.len() - 8..]), (&b"\x89MCAP0\r\n"[..], &b"\x89MCAP0\r\n"[..]));
    let mut all = Vec::new();
    for (opcode, content) in records(inner) {
        if opcode != 6 {
            all.push((opcode, content.to_vec()));
            continue;
        }
        let (size, crc) = (&content[16..24], &content[24..28]);
        assert_eq!(&content[28..36], b"\x04\0\0\0zstd");
        let size = u64::from_le_bytes(size.try_into().unwrap()) as usize;
        let chunk = zstd::bulk::decompress(&content[44..], size).unwrap();
        assert_eq!(chunk.len(), size);
        assert_eq!(crc, crc32fast::hash(&chunk).to_le_bytes());
        all.extend(records(&chunk).into_iter().map(|(opcode, content)| (opcode, content.to_vec())));
    }
    all
}

/// Returns the messages of a file: topic, sequence, log time, data.
pub(super) fn messages(file: &[u8]) -> Vec<(String, u32, u64, Vec<u8>)> {
    let mut topics = BTreeMap::new();
    let mut found = Vec::new();
    for (opcode, content) in open(file) {
        let id = u16::from_le_bytes([content[0], content[1]]);
        match opcode {
            4 => {
                let length = u32::from_le_bytes(content[4..8].try_into().unwrap()) as usize;
                topics.insert(id, String::from_utf8(content[8..8 + length].to_vec()).unwrap());
            }
            5 => {
                let sequence = u32::from_le_bytes(content[2..6].try_into().unwrap());
                let time = u64::from_le_bytes(content[6..14].try_into().unwrap());
                assert_eq!(content[6..14], content[14..22]);
                found.push((topics[&id].clone(), sequence, time, content[22..].to_vec()));
            }
            _ => {}
        }
    }
    found
}

/// Returns the names and texts of the schemas of a file.
pub(super) fn texts(file: &[u8]) -> Vec<(String, String)> {
    let schemas = open(file).into_iter().filter(|(opcode, _)| *opcode == 3);
    let read = |(_, content): (u8, Vec<u8>)| {
        let mut rest = &content[2..];
        let mut parts = [(); 3].map(|()| {
            let length = u32::from_le_bytes(rest[..4].try_into().unwrap()) as usize;
            let part = String::from_utf8(rest[4..4 + length].to_vec()).unwrap();
            rest = &rest[4 + length..];
            part
        });
        (std::mem::take(&mut parts[0]), std::mem::take(&mut parts[2]))
    };
    schemas.map(read).collect()
}

fn write(settings: McapSettings, frames: &[Frame]) -> (Vec<u8>, Vec<(Loss, u64)>) {
    let mut buses = Buses::default();
    buses.intern(b"can1");
    buses.intern(b"a b/c");
    let setting = CaptureFacts { buses: &buses, date_ns: None };
    let mut writer = Mcap::new(settings);
    let mut out = Vec::new();
    for frame in frames {
        writer.frame(&mut out, setting, frame);
    }
    writer.finish(&mut out, setting);
    (out, writer.losses.iter().collect())
}

fn plain(frame: Frame) -> Frame {
    Frame { t_ns: Some(Ns(1_549_455_524_265_601_001)), dir: Some(Direction::Rx), ..frame }
}

const STAMP: [u8; 8] = [0xA4, 0xD0, 0x5A, 0x5C, 0xE9, 0xBF, 0xD4, 0x0F];

/// Returns the encapsulation and header of a message on `can1`, up to the first field.
fn head() -> Vec<u8> {
    let mut bytes = vec![0, 1, 0, 0];
    bytes.extend(STAMP);
    bytes.extend(b"\x05\0\0\0can1\0\0\0\0");
    bytes
}

#[test]
fn a_classic_frame() {
    let frame = plain(Frame::classic(CanId::standard(0x60A), &[0x40, 8, 0x10]));
    let (file, losses) = write(McapSettings::default(), &[frame]);
    let mut data = head();
    data.extend([0x0A, 6, 0, 0, 0, 0, 0, 3, 0x40, 8, 0x10, 0, 0, 0, 0, 0]);
    assert_eq!(data.len(), 40);
    assert_eq!(messages(&file), [("/can1/from_can_bus".to_owned(), 1, 1_549_455_524_265_601_001, data)]);
    assert_eq!(losses, []);
}

#[test]
fn kinds_of_frames() {
    let data = Frame::classic(CanId::extended(0x1ABC_DEF0), &[1]);
    let mut fd = Frame { kind: Kind::Fd { brs: true, esi: false }, len: 12, ..data };
    fd.data[11] = 9;
    let frames = [
        Frame { kind: Kind::Remote, len: 4, data: [0; 64], dir: Some(Direction::Tx), ..plain(data) },
        plain(Frame { kind: Kind::Error, len: 8, ..Frame::classic(CanId::standard(0x88), &[0, 4]) }),
        plain(fd),
        Frame { dir: Some(Direction::Tx), ..plain(fd) },
    ];
    let tails = |file: &[u8]| -> Vec<(String, Vec<u8>)> {
        messages(file).into_iter().map(|(topic, _, _, data)| (topic, data[head().len()..].to_vec())).collect()
    };
    let (file, losses) = write(McapSettings::default(), &frames);
    let bytes = [1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 9];
    let long = |head: &[u8]| [head, &bytes].concat();
    let row = |topic: &str, data: Vec<u8>| (topic.to_owned(), data);
    let expected = [
        row("/can1/to_can_bus", vec![0xF0, 0xDE, 0xBC, 0x1A, 1, 1, 0, 4, 0, 0, 0, 0, 0, 0, 0, 0]),
        row("/can1/from_can_bus", vec![0x88, 0, 0, 0, 0, 0, 1, 8, 0, 4, 0, 0, 0, 0, 0, 0]),
        row("/can1/from_can_bus_fd", long(&[0xF0, 0xDE, 0xBC, 0x1A, 1, 0, 12, 0, 12, 0, 0, 0])),
        row("/can1/to_can_bus_fd", long(&[0xF0, 0xDE, 0xBC, 0x1A, 1, 0, 12, 0, 12, 0, 0, 0])),
    ];
    assert_eq!(tails(&file), expected);
    assert_eq!(losses, [(Loss::FdFlags, 2)]);
    let (file, losses) =
        write(McapSettings { fd_schema: FdSchema::Dataspeed, ..McapSettings::default() }, &frames[2..3]);
    let data = long(&[0xF0, 0xDE, 0xBC, 0x1A, 1, 1, 1, 0, 0, 0, 0, 0, 12, 0, 0, 0]);
    assert_eq!(tails(&file), [row("/can1/from_can_bus_fd", data)]);
    assert_eq!(losses, []);
}

#[test]
fn what_the_format_cannot_hold() {
    let bare = Frame::classic(CanId::standard(1), &[]);
    let (file, losses) = write(McapSettings::default(), &[bare, bare]);
    let times: Vec<_> = messages(&file).into_iter().map(|(_, _, time, _)| time).collect();
    assert_eq!(times, [0, STEP]);
    assert_eq!(losses, [(Loss::UnknownDirection, 2), (Loss::NoStamp, 2)]);
    let odd = Frame {
        t_ns: Some(Ns(-5)),
        bus: BusId(1),
        len: 8,
        length_form: LengthForm { raw_dlc: 15, ..LengthForm::default() },
        ..plain(bare)
    };
    let (file, losses) =
        write(McapSettings::default(), &[Frame { bus: BusId(1), ..plain(bare) }, Frame { t_ns: Some(Ns(-5)), ..odd }]);
    assert_eq!(messages(&file)[1].0, "/a_b_c/from_can_bus");
    assert_eq!(messages(&file)[1].2, 0);
    assert_eq!(losses, [(Loss::BusName, 2), (Loss::NoStamp, 1), (Loss::RawDlc, 1)]);
    // After 2038 the stamp is 0 for unknown; the log time is still right.
    let (file, losses) = write(McapSettings::default(), &[Frame { t_ns: Some(Ns::MAX), ..plain(bare) }]);
    let (_, _, time, data) = messages(&file).remove(0);
    assert_eq!((time, &data[4..12]), (i64::MAX as u64, &[0; 8][..]));
    assert_eq!(losses, []);
}

#[test]
fn buses_in_topics() {
    assert_eq!(topic_name(b"", &[]), "can0");
    assert_eq!(topic_name(b"", &["can0"]), "can0_2");
    assert_eq!(topic_name(b"can0", &["can0", "can0_2"]), "can0_3");
    assert_eq!(topic_name("总线".as_bytes(), &[]), "总线");
    assert_eq!(topic_name(b"a/\x01\xFF b", &[]), "a____b");
}

#[test]
fn summary_and_indexes() {
    let frames: Vec<Frame> = (0..60_000)
        .map(|no| {
            let id = CanId::standard(0x180 + no % 7);
            Frame { t_ns: Some(Ns(i64::from(no) * 1000)), ..plain(Frame::classic(id, &no.to_le_bytes())) }
        })
        .collect();
    let (file, _) = write(McapSettings::default(), &frames);
    let kinds = |file: &[u8]| {
        let mut counts = BTreeMap::new();
        for (opcode, _) in records(&file[8..file.len() - 8]) {
            *counts.entry(opcode).or_insert(0) += 1;
        }
        counts
    };
    // With 75 bytes a message, 4.5 MB are five chunks. The summary has a schema, a channel, five chunks and a metadata
    // record.
    let expected =
        [(1, 1), (2, 1), (3, 1), (4, 1), (6, 5), (7, 5), (8, 5), (0xB, 1), (0xC, 1), (0xD, 1), (0xE, 5), (0xF, 1)];
    assert_eq!(kinds(&file), BTreeMap::from(expected));
    assert_eq!(messages(&file).len(), frames.len());

    // Each indexed offset points to the described record.
    let at = |offset: u64| -> (u8, &[u8]) {
        let rest = &file[offset as usize..];
        let length = u64::from_le_bytes(rest[1..9].try_into().unwrap()) as usize;
        (rest[0], &rest[9..9 + length])
    };
    let number = |bytes: &[u8]| u64::from_le_bytes(bytes[..8].try_into().unwrap());
    let mut indexed = 0;
    for (opcode, content) in open(&file) {
        match opcode {
            8 => {
                assert_eq!(at(number(&content[16..])).0, 6);
                let places = u32::from_le_bytes(content[32..36].try_into().unwrap()) as usize;
                for place in content[36..36 + places].chunks(10) {
                    let (opcode, index) = at(number(&place[2..]));
                    assert_eq!((opcode, &index[..2]), (7, &place[..2]));
                    indexed += (index.len() - 6) / 16;
                }
            }
            0xD => assert_eq!(at(number(&content)).0, 0xC),
            0xE => assert_eq!(at(number(&content[1..])).0, content[0]),
            2 => {
                assert_eq!(at(number(&content)).0, 3);
                assert_eq!(at(number(&content[8..])).0, 0xE);
                let summary = &file[number(&content) as usize..file.len() - 12];
                assert_eq!(content[16..], crc32fast::hash(summary).to_le_bytes());
            }
            0xB => {
                assert_eq!(number(&content), 60_000);
                assert_eq!((number(&content[26..]), number(&content[34..])), (0, 59_999_000));
            }
            _ => {}
        }
    }
    assert_eq!(indexed, frames.len());

    let (archive, _) = write(McapSettings { archive: true, ..McapSettings::default() }, &frames);
    assert!(!kinds(&archive).contains_key(&7) && archive.len() < file.len());
    assert_eq!(messages(&archive), messages(&file));
}

#[test]
fn every_chunk_is_readable_by_itself() {
    let frame = plain(Frame::classic(CanId::standard(1), &[1; 8]));
    let (file, _) = write(McapSettings::default(), &vec![frame; 30_000]);
    let opened = open(&file);
    let data: Vec<u8> = opened.iter().map(|(opcode, _)| *opcode).take_while(|opcode| *opcode != 0xF).collect();
    assert_eq!(data.iter().filter(|opcode| **opcode == 3).count(), 3);
    assert_eq!(data.iter().filter(|opcode| **opcode == 4).count(), 3);
}

#[test]
fn an_empty_capture_is_a_whole_file() {
    let (file, losses) = write(McapSettings::default(), &[]);
    assert_eq!(losses, []);
    let kinds: Vec<u8> = open(&file).iter().map(|(opcode, _)| *opcode).collect();
    assert_eq!(kinds, [1, 0xC, 0xF, 0xB, 0xD, 0xE, 0xE, 2]);
}

#[test]
fn where_it_comes_from() {
    let mut buses = Buses::default();
    buses.intern(b"can1");
    let setting = CaptureFacts { buses: &buses, date_ns: None };
    let (mut writer, mut file) = (Mcap::default(), Vec::new());
    writer.source(b"folder/x.log", "candump");
    writer.frame(&mut file, setting, &plain(Frame::classic(CanId::standard(1), &[])));
    writer.finish(&mut file, setting);
    let (_, metadata) = open(&file).into_iter().find(|(opcode, _)| *opcode == 0xC).unwrap();
    let text = String::from_utf8_lossy(&metadata).into_owned();
    for part in ["canalyze.source", "buses\u{4}\0\0\0can1", "file\u{5}\0\0\0x.log", "format\u{7}\0\0\0candump"] {
        assert!(text.contains(part), "{part}");
    }
}

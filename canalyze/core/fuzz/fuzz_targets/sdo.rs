//! Arbitrary SDO traffic, pushed frame by frame: no panic, and every frame has its line in every kind of output.
//!
//! The first byte sets the options. Each frame is then a control byte and its data: side, node, bus, the time since
//! the frame before, and what kind of frame it is, so that the fuzzer finds sessions and not only single frames.
#![no_main]

use std::collections::BTreeMap;

use canalyze_core::bytes::frame::{BusId, CanId, Frame, Kind, Stamp, StampForm};
use canalyze_core::bytes::ns::Ns;
use canalyze_core::sdo::transfer::{Hole, KEPT, Status};
use canalyze_core::session::{Options, Output, Rows, Session};
use canalyze_core::words::{Depth, Lang};
use libfuzzer_sys::fuzz_target;
use serde_json::Value;

const NODES: [u16; 4] = [1, 2, 10, 127];
/// Within a response time, within the hold of a response, beyond it, beyond a client's patience.
const GAPS_NS: [i64; 4] = [400_000, 4_900_000, 5_100_000, 1_500_000_000];

/// Frames of up to 8 bytes, from a control byte each: `sbnnggkk`.
fn frames(mut input: &[u8], stamped: bool) -> Vec<Frame> {
    let mut frames = Vec::new();
    let mut now = 1_000_000_000_i64;
    while let Some((&control, rest)) = input.split_first() {
        input = rest;
        let node = NODES[usize::from(control >> 4 & 3)];
        let mut id = CanId::standard(if control & 0x80 == 0 { 0x600 } else { 0x580 } + node);
        now += GAPS_NS[usize::from(control >> 2 & 3)];
        let mut len = 8;
        let mut kind = Kind::Data;
        match control & 3 {
            0 | 1 => {}
            // A short frame: its length stands before its data.
            2 => {
                let Some((&byte, rest)) = input.split_first() else { break };
                input = rest;
                len = usize::from(byte % 9);
            }
            // What ends transfers, what is no SDO though it has its identifier, and a step back in time.
            _ => {
                let Some((&what, rest)) = input.split_first() else { break };
                input = rest;
                match what % 6 {
                    0 => (id, len) = (CanId::standard(0), 2),
                    1 => (id, len) = (CanId::standard(0x700 + node), 1),
                    2 => kind = Kind::Remote,
                    3 => kind = Kind::Fd { brs: what & 0x40 != 0, esi: what & 0x80 != 0 },
                    4 => id = CanId::extended(u32::from(what)),
                    _ => now -= 10_000_000,
                }
            }
        }
        let (data, rest) = input.split_at(len.min(input.len()));
        input = rest;
        let mut frame = Frame::classic(id, data);
        frame.kind = kind;
        frame.bus = BusId(control >> 6 & 1);
        frame.line = Some(frames.len() as u64 + 1);
        if stamped {
            frame.t_ns = Some(Ns(now));
            frame.stamp = Some(Stamp { form: StampForm::Seconds, ns: Ns(now), width: 3, decimals: 6 });
        }
        frames.push(frame);
    }
    frames
}

/// The bytes of a transfer that are handed out, how it ended, and its holes.
type File = (Vec<u8>, Option<Status>, Vec<Hole>);

/// What a session says of the frames, and the bytes of each transfer that it hands out.
fn run(frames: &[Frame], options: Options) -> (String, BTreeMap<String, File>) {
    let mut session = Session::new(options);
    let mut out = Vec::new();
    let mut files: BTreeMap<String, File> = BTreeMap::new();
    for frame in frames {
        session.push(*frame, &mut out);
    }
    session.finish(&mut out);
    for piece in session.take_extracted() {
        let (bytes, status, holes) = files.entry(piece.name).or_default();
        assert_eq!(*status, None, "bytes of a transfer that has ended");
        bytes.extend_from_slice(&piece.bytes);
        (*status, *holes) = (piece.status, piece.holes);
    }
    assert_eq!(session.frames().0, frames.len() as u64);
    assert!(session.take_complaints().is_empty());
    (String::from_utf8(out).expect("output is UTF-8"), files)
}

fn rows(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}"))).collect()
}

fn of_kind<'a>(rows: &'a [Value], kind: &str) -> Vec<&'a Value> {
    rows.iter().filter(|row| row["kind"] == kind).collect()
}

fn check_transfer(transfer: &Value) {
    let size = transfer["size"].as_u64().expect("a size");
    let kept = transfer["data"].as_str().expect("data").len() as u64 / 2;
    assert!(kept <= size && kept <= KEPT as u64, "{transfer}");
    assert!(transfer["first_frame"].as_u64() <= transfer["last_frame"].as_u64(), "{transfer}");
    assert_ne!(transfer["status"], "open", "{transfer}");
}

fn check_text(frames: &[Frame], lang: Lang, depth: Depth) {
    let mut options = Options::of(lang, &[Output::Lines]);
    options.writing.depth = depth;
    let (text, _) = run(frames, options);
    assert_eq!(text.lines().filter(|line| !line.starts_with('#')).count(), frames.len(), "a line a frame");
    assert!(!text.chars().any(|c| c.is_control() && c != '\n'), "nothing that controls a terminal");
}

fn check_json(frames: &[Frame], lang: Lang) {
    let (lines, _) = run(frames, Options::of(lang, &[Output::json(Rows::Frames)]));
    let all = rows(&lines);
    let numbers: Vec<u64> = of_kind(&all, "frame").iter().filter_map(|row| row["frame"].as_u64()).collect();
    assert_eq!(numbers, (1..=frames.len() as u64).collect::<Vec<_>>(), "a line a frame, in order");
    let said = of_kind(&all, "transfer");
    said.iter().for_each(|transfer| check_transfer(transfer));

    let mut options = Options::of(lang, &[Output::json(Rows::Transfers)]);
    options.writing.extract = true;
    let (lines, files) = run(frames, options);
    let transfers = rows(&lines);
    assert_eq!(said, transfers.iter().collect::<Vec<_>>(), "the same transfers");
    for transfer in &transfers {
        let number = format!("{:05}_", transfer["transfer"].as_u64().expect("a number"));
        let mut files = files.iter().filter(|(name, _)| name.starts_with(&number));
        let (_, (bytes, status, holes)) = files.next().expect("a file a transfer");
        assert!(files.next().is_none(), "one file a transfer: {transfer}");
        let size = transfer["size"].as_u64().expect("a size");
        let filled: u64 = holes.iter().filter(|hole| hole.offset < size).filter_map(|hole| hole.length).sum();
        // Of a write that was not confirmed, what was requested is handed out.
        let requested = size == 0 && !transfer["text"].as_str().unwrap_or("").is_empty();
        assert!(requested || bytes.len() as u64 + filled == size, "{transfer}");
        assert_eq!(status.map(Status::name), transfer["status"].as_str());
    }
}

fuzz_target!(|input: &[u8]| {
    let Some((options, traffic)) = input.split_first() else { return };
    let lang = if options & 1 == 0 { Lang::Zh } else { Lang::En };
    let frames = frames(traffic, options & 2 == 0);
    // One kind of output at a time: two would halve what can be tried.
    match options >> 2 & 3 {
        0 | 1 => check_json(&frames, lang),
        2 => check_text(&frames, lang, Depth::Default),
        _ => check_text(&frames, lang, Depth::Explain),
    }
});

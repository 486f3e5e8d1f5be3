//! Live buses through a whole session: the same results as for a capture of the same frames, and live-only behaviour.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::*;
use crate::bytes::frame::{BusId, Buses, CanId};
use crate::bytes::masks::Masks;
use crate::bytes::ns::Ns;
use crate::bytes::readers::{InputFormat as Input, Item, Reader, Settings};
use crate::bytes::writers;
use crate::session::{Knowledge, Options, Output, Rows, Session};
use crate::words::Lang;

const START: i64 = 1_700_000_000_000_000_000;
const MS: i64 = 1_000_000;

fn english(output: Output) -> Options {
    Options::of(Lang::En, &[output])
}

fn run_as(input: Input, options: Options, chunks: &[&[u8]]) -> Vec<u8> {
    let (mut session, mut out) = (Session::new(options), Vec::new());
    session.begin(b"can0", input, false);
    for chunk in chunks {
        session.feed(chunk, &mut out);
    }
    session.finish(&mut out);
    out
}

fn run(options: Options, stream: &[u8]) -> String {
    String::from_utf8(run_as(Input::Live, options, &[stream])).unwrap()
}

fn logs() -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            match path.extension().and_then(|extension| extension.to_str()) {
                Some("log") => found.push(path),
                None if path.is_dir() => folders.push(path),
                _ => {}
            }
        }
    }
    found.sort();
    assert!(found.len() > 10, "{found:?}");
    found
}

/// Returns the frames of a log if its stamps have the form of a kernel's.
fn frames_of(path: &Path) -> Option<(Vec<Frame>, Buses)> {
    let mut reader = Reader::new(Input::Candump, &Settings { regular: true, ..Settings::default() });
    let (mut buses, mut frames, mut fit) = (Buses::default(), Vec::new(), true);
    let mut sink = |item: &mut Item, _: &Buses| match *item {
        Item::Frame(frame) => {
            fit &= frame.stamp.is_some_and(|stamp| stamp.decimals == 6 && stamp.width == 10) && frame.line.is_some();
            frames.push(Frame { line: None, ..frame });
        }
        _ => fit = false,
    };
    reader.feed(&fs::read(path).unwrap(), &mut buses, &mut sink);
    reader.finish(&mut buses, &mut sink);
    (fit && !frames.is_empty() && buses.names().all(|name| !name.is_empty())).then_some((frames, buses))
}

fn names(buses: &Buses) -> Vec<u8> {
    let named = buses.names().enumerate().map(|(index, name)| named(index as u8, &String::from_utf8_lossy(name)));
    named.flatten().collect()
}

/// Returns the blocks of a receiver for these frames: pieces of them bus by bus, each followed by a tick.
fn live(frames: &[Frame], buses: &Buses, piece: usize) -> Vec<u8> {
    let mut out = names(buses);
    for frames in frames.chunks(piece) {
        for bus in 0..buses.names().count() as u8 {
            let sent: Vec<Sent> = frames.iter().filter(|frame| frame.bus == BusId(bus)).map(Sent::new).collect();
            out.extend(received(bus, 0, &sent));
        }
        out.extend(until(frames.last().unwrap().t_ns.unwrap()));
    }
    out
}

/// Returns JSON lines without the fields that only a file has.
fn without_lines(jsonl: &[u8]) -> Vec<Value> {
    fn strip(value: &mut Value) {
        match value {
            Value::Object(object) => {
                object.retain(|key, _| !key.ends_with("line"));
                object.values_mut().for_each(strip);
            }
            Value::Array(values) => values.iter_mut().for_each(strip),
            _ => {}
        }
    }
    let lines = std::str::from_utf8(jsonl).unwrap().lines();
    lines
        .map(|line| serde_json::from_str(line).unwrap())
        .inspect(|_| ())
        .map(|mut value| {
            strip(&mut value);
            value
        })
        .collect()
}

#[test]
fn live_frames_read_as_their_log_does() {
    let mut compared = 0;
    for path in logs() {
        let Some((frames, buses)) = frames_of(&path) else { continue };
        compared += 1;
        let stream = live(&frames, &buses, 7);
        let log = run(english(Output::Convert), &stream);
        for format in [Output::Lines, Output::json(Rows::Frames)] {
            let of_log = run_as(Input::Candump, english(format), &[log.as_bytes()]);
            let whole = run_as(Input::Live, english(format), &[&stream]);
            // The cuts within a block depend on no frame: a short log has them all.
            let sizes: &[usize] = if frames.len() <= 200 { &[1, 3, 4096] } else { &[4096] };
            for &size in sizes {
                let chunks: Vec<&[u8]> = stream.chunks(size).collect();
                assert_eq!(run_as(Input::Live, english(format), &chunks), whole, "{path:?} in {size}");
            }
            if format == Output::Lines {
                let texts = [&whole, &of_log].map(|out| String::from_utf8_lossy(out).into_owned());
                assert!(texts[0] == texts[1], "{path:?}");
                // The original log has no directions.
                let bare = texts[0].replace("RX - -  ", "").replace("RX B -  ", "").replace("RX - E  ", "");
                let given = run_as(Input::Candump, english(format), &[&fs::read(&path).unwrap()]);
                // A SYNC marked as received has an exact stamp; an unmarked one may be the host's own. A limit exceeded
                // by less than the possible delay of an own frame is certain some frames later.
                let exact = ["SYN011.log", "SYN011.clean.log"].iter().any(|name| path.ends_with(name))
                    || path.components().any(|part| part.as_os_str() == "stories");
                if !exact && frames.iter().all(|frame| frame.dir.is_none()) && buses.names().count() == 1 {
                    assert!(bare.as_bytes() == given, "{path:?}");
                }
            } else {
                assert!(without_lines(&whole) == without_lines(&of_log), "{path:?}");
            }
        }
    }
    assert!(compared > 5, "{compared}");
}

/// Returns the codes of findings with their nodes and objects, sorted.
fn findings(jsonl: &str) -> Vec<(String, String)> {
    let lines = jsonl.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    let text = |line: &Value, key: &str| line[key].as_str().unwrap_or_default().to_owned();
    let mut found: Vec<_> = lines
        .filter(|line| line["kind"] == "finding")
        .map(|line| (text(&line, "code"), format!("{} {}", line["node"], text(&line, "object"))))
        .collect();
    found.sort();
    found
}

#[test]
fn ticks_that_lag_find_nothing_further() {
    // A tick shows that the bus was silent, so that nothing is missing from the recording.
    let holed = ["CAP007.log", "t20-recorder-stall.log"];
    for path in logs().into_iter().filter(|path| !holed.iter().any(|name| path.ends_with(name))) {
        let Some((frames, buses)) = frames_of(&path) else { continue };
        let plain = findings(&run(english(Output::json(Rows::Frames)), &live(&frames, &buses, 1 << 20)));
        let (mut ticked, mut twice) = (names(&buses), names(&buses));
        let mut now = frames[0].t_ns.unwrap();
        for frame in &frames {
            let block = received(frame.bus.0, 0, &[Sent::new(frame)]);
            while now + Ns(20 * MS) < frame.t_ns.unwrap() {
                now += 5 * Ns(MS).max((frame.t_ns.unwrap() - now) / 50);
                let tick = until(now - Ns(20 * MS));
                ticked.extend_from_slice(&tick);
                twice.extend([tick.clone(), tick].concat());
            }
            ticked.extend_from_slice(&block);
            twice.extend(block);
        }
        let found = run(english(Output::json(Rows::Frames)), &ticked);
        assert_eq!(findings(&found), plain, "{path:?}");
        assert_eq!(run(english(Output::json(Rows::Frames)), &twice), found, "{path:?}");
    }
}

#[test]
fn nothing_is_found_across_a_gap() {
    for path in logs() {
        let Some((frames, buses)) = frames_of(&path) else { continue };
        for cut in [frames.len() / 3, frames.len() / 2, frames.len()] {
            for kind in [kind::GAP, kind::DROPPED] {
                let before = live(&frames[..cut], &buses, 5);
                let mut session = Session::new(english(Output::json(Rows::Frames)));
                let mut out = Vec::new();
                session.begin(b"can0", Input::Live, false);
                session.feed(&before, &mut out);
                out.clear();
                for bus in 0..buses.names().count() as u8 {
                    session.feed(&block(kind, bus, 0, 0, b""), &mut out);
                }
                let end = frames.iter().filter_map(|frame| frame.t_ns).max().unwrap();
                for tick in [MS, 100 * MS, 1_000 * MS, 10_000 * MS, 3_600_000 * MS] {
                    session.feed(&until(end + Ns(tick)), &mut out);
                }
                // A bus that is back shows no more about the silence of others than one that is away.
                let back = Frame {
                    t_ns: Some(end + Ns(3_600_001 * MS)),
                    bus: BusId(0),
                    ..Frame::classic(CanId::standard(0x7FF), &[])
                };
                session.feed(&received(0, 0, &[Sent::new(&back)]), &mut out);
                session.feed(&until(end + Ns(3_700_000 * MS)), &mut out);
                // Waiting findings are released at the gap, with their own frames.
                let told = String::from_utf8(out).unwrap();
                let later = |line: &&str| {
                    let row = serde_json::from_str::<Value>(line).unwrap();
                    row["because_of"].is_null() && row["frame"].as_u64().is_none_or(|no| no > cut as u64)
                };
                let found = findings(&told.lines().filter(later).collect::<Vec<_>>().join("\n"));
                let found: Vec<_> = found.iter().filter(|(code, _)| code != "CAP002").collect();
                assert!(found.is_empty(), "{path:?} {cut} {kind}: {found:?}");
            }
        }
    }
}

fn heartbeat(node: u8, ms: i64) -> Vec<u8> {
    let frame = Frame::classic(CanId::standard(0x700 + u16::from(node)), &[5]);
    received(0, 0, &[Sent::new(&Frame { t_ns: Some(Ns(START + ms * MS)), ..frame })])
}

/// Makes twenty heartbeats every 100 ms, the last one at 1900 ms.
fn heartbeats(node: u8) -> Vec<u8> {
    [named(0, "can0"), (0..20).flat_map(|no| heartbeat(node, no * 100)).collect()].concat()
}

/// Makes ticks every 20 ms, delayed by 20 ms.
fn ticks(from_ms: i64, to_ms: i64) -> Vec<u8> {
    (from_ms / 20..to_ms / 20).flat_map(|no| until(Ns(START + (no * 20 - 20) * MS))).collect()
}

#[test]
fn a_heartbeat_that_stops_on_a_silent_bus_is_told_by_time_alone() {
    let mut session = Session::new(english(Output::Lines));
    let mut out = Vec::new();
    session.begin(b"can0", Input::Live, false);
    session.feed(&heartbeats(5), &mut out);
    session.feed(&ticks(1_900, 2_200), &mut out);
    assert!(!String::from_utf8_lossy(&out).contains("HBT"));
    out.clear();
    session.feed(&ticks(2_200, 60_000), &mut out);
    let text = String::from_utf8(out).unwrap();
    assert_eq!(
        text,
        "#   HBT002 error: frame 20 node 5: no heartbeat for 360 ms since then (limit 330 ms: 3 periods plus tolerance)\n"
    );
}

#[test]
fn a_cable_that_is_pulled_is_told_once_and_then_who_is_lost() {
    let mut stream = named(0, "can0");
    for no in 0..20 {
        stream.extend(heartbeat(5, no * 100));
        stream.extend(heartbeat(6, no * 100 + 20));
    }
    stream.extend(ticks(1_940, 60_000));
    let told = |stream: &[u8]| findings(&run(english(Output::json(Rows::Frames)), stream));
    assert_eq!(told(&stream), [("HBT005".to_owned(), "null ".to_owned())]);
    for no in 0..20 {
        stream.extend(heartbeat(6, 60_000 + no * 100));
    }
    let lost = told(&stream);
    assert_eq!(
        lost.iter().map(|(code, about)| format!("{code} {about}")).collect::<Vec<_>>(),
        ["HBT002 5 ", "HBT005 null "]
    );
}

#[test]
fn a_node_that_stops_among_others_is_told_as_in_a_file() {
    let mut live = named(0, "can0");
    for no in 0..40 {
        if no < 20 {
            live.extend(heartbeat(5, no * 100));
        }
        live.extend(heartbeat(6, no * 100 + 50));
    }
    let text = run(english(Output::Lines), &live);
    assert!(text.contains("HBT002"), "{text}");
}

#[test]
fn a_gap_is_no_silence() {
    let gap = block(kind::GAP, 0, 0, 0, b"");
    let stream = [heartbeats(5), gap, ticks(1_900, 30_000), heartbeat(6, 30_000), ticks(30_020, 60_000)].concat();
    let text = run(english(Output::Lines), &stream);
    assert!(!text.contains('!') && !text.contains("HBT"), "{text}");
    // A return and another loss: one finding.
    let again = (0..5).flat_map(|no| heartbeat(5, 61_000 + no * 100)).collect();
    let stream = [stream, again, ticks(61_420, 70_000)].concat();
    assert_eq!(run(english(Output::Lines), &stream).matches("HBT").count(), 1);
}

#[test]
fn a_clock_that_is_set_back_at_a_gap() {
    let gap = block(kind::GAP, 0, 0, 0, b"");
    let hour = 3_600_000;
    let before: Vec<u8> = (0..20).flat_map(|no| heartbeat(5, hour + no * 100)).collect();
    let after: Vec<u8> = (0..20).flat_map(|no| heartbeat(5, no * 100)).collect();
    let stream =
        [named(0, "can0"), before, ticks(hour + 1_900, hour + 2_000), gap, after, ticks(1_900, 2_000)].concat();
    assert_eq!(findings(&run(english(Output::json(Rows::Frames)), &stream)), []);
}

/// Returns findings above info except CAP002.
fn verdicts(jsonl: &str) -> Vec<String> {
    let lines = jsonl.lines().filter(|line| line.starts_with("{\"kind\":\"finding\""));
    let verdict = |line: &&str| !line.contains("\"severity\":\"info\"") && !line.contains("CAP002");
    lines.filter(verdict).map(str::to_owned).collect()
}

#[test]
fn what_follows_a_gap_is_not_judged_by_what_was_before() {
    let (mut clean, mut wrong) = (0, Vec::new());
    // Stories contain faults on purpose.
    for path in logs().into_iter().filter(|path| path.components().all(|part| part.as_os_str() != "stories")) {
        let Some((frames, buses)) = frames_of(&path) else { continue };
        let whole = run(english(Output::json(Rows::Frames)), &live(&frames, &buses, 50));
        if buses.names().count() != 1 || frames.len() > 1_000 || !verdicts(&whole).is_empty() {
            continue;
        }
        clean += 1;
        let step = (frames.len() / 40).max(1);
        for cut in (1..frames.len()).step_by(step) {
            // A long capture has one of them at each cut, in turn.
            let ways = [(kind::GAP, 0), (kind::GAP, 7), (kind::DROPPED, 2)];
            let ways = if frames.len() > 200 { &ways[cut / step % 3..][..1] } else { &ways[..] };
            for &(kind, missed) in ways {
                let after = &frames[(cut + missed).min(frames.len() - 1)..];
                let stream =
                    [live(&frames[..cut], &buses, 50), block(kind, 0, 0, 0, b""), live(after, &buses, 50)].concat();
                for one in verdicts(&run(english(Output::json(Rows::Frames)), &stream)) {
                    wrong.push(format!("{path:?} {cut} {kind} {missed}: {one}"));
                }
            }
        }
    }
    assert!(clean > 20, "{clean}");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn who_is_back_with_the_bus_is_not_lost() {
    let mut stream = named(0, "can0");
    let pair = |from: i64| (0..20).flat_map(move |no| [(5, from + no * 100), (6, from + no * 100 + 70)]);
    stream.extend(pair(0).flat_map(|(node, ms)| heartbeat(node, ms)));
    // The silence is reported repeatedly, at any phase of the nodes' deadlines.
    for silent in (3_000..4_000).step_by(37) {
        let mut stream = [stream.clone(), ticks(1_980, silent)].concat();
        stream.extend(pair(silent).flat_map(|(node, ms)| [heartbeat(node, ms), until(Ns(START + ms * MS))].concat()));
        assert_eq!(verdicts(&run(english(Output::json(Rows::Frames)), &stream)), [""; 0], "{silent}");
    }
}

#[test]
fn a_time_limit_is_over_when_it_is_over() {
    let expected = |json: &str| {
        let expectations = crate::views::expectation::Expectations::read(json).unwrap();
        Options {
            known: Knowledge { expectations: Some(std::sync::Arc::new(expectations)), ..Knowledge::default() },
            ..english(Output::json(Rows::Frames))
        }
    };
    let state = r#"{"file":"x","state":[{"line":1,"node":5,"state":"stopped","by_ns":2500000000}]}"#;
    let sdo = r#"{"file":"x","sdo":[{"line":1,"node":5,"index":4096,"sub":0,"within_ns":2500000000}]}"#;
    for (json, code) in [(state, "EXP005"), (sdo, "EXP001")] {
        let count = |out: &[u8], code: &str| String::from_utf8_lossy(out).matches(code).count();
        for gap in [false, true] {
            let (mut session, mut out) = (Session::new(expected(json)), Vec::new());
            session.begin(b"can0", Input::Live, false);
            session.feed(&heartbeats(5), &mut out);
            if gap {
                session.feed(&block(kind::GAP, 0, 0, 0, b""), &mut out);
            }
            session.feed(&ticks(1_900, 2_500), &mut out);
            assert_eq!(count(&out, "EXP0"), 0);
            session.feed(&ticks(2_500, 9_000), &mut out);
            session.finish(&mut out);
            // Missing frames may have fulfilled it.
            let told = if gap { "\"EXP015\"" } else { &format!("\"{code}\"") };
            assert_eq!((count(&out, "\"code\":\"EXP"), count(&out, told)), (1, 1), "{code} {gap}");
        }
    }
}

#[test]
fn dropped_frames_are_told_and_counted() {
    let mut session = Session::new(english(Output::Lines));
    let mut out = Vec::new();
    session.begin(b"can0,can1", Input::Live, false);
    let stream =
        [named(0, "can0"), named(1, "can1"), block(kind::DROPPED, 1, 0, 3, b""), block(kind::DROPPED, 1, 1, 4, b"")];
    session.feed(&stream.concat(), &mut out);
    session.feed(&until(Ns(START)), &mut out);
    let text = String::from_utf8(out).unwrap();
    assert!(text.contains("DROPCOUNT: dropped 4 CAN frames on 'can1' socket (total drops 7)"), "{text}");
    assert_eq!(
        session.take_complaints(),
        ["can1: CAP002 3 frames lost (total 3)", "can1: CAP002 4 frames lost (total 7)"]
    );
    let tally: Value = serde_json::from_slice(&session.tally()).unwrap();
    assert_eq!(tally["buses"][1]["dropped"], 7);
    assert_eq!((&tally["findings"]["warning"], &tally["expectations"]), (&Value::from(2), &Value::Null));
}

#[test]
fn so_many_frames_and_no_more_are_shown() {
    let path = logs().into_iter().find(|path| path.ends_with("services.log")).unwrap();
    let (frames, buses) = frames_of(&path).unwrap();
    let stream = live(&frames, &buses, 3);
    let masks = Masks::parse(&["any,700:780".to_owned()]).unwrap();
    let shown =
        |options: Options| run(options, &stream).lines().filter(|line| line.starts_with("{\"kind\":\"frame\"")).count();
    let mut masked = english(Output::json(Rows::Frames));
    masked.shown.masks = masks.clone();
    let all = shown(masked.clone());
    let expected = frames.iter().filter(|frame| frame.kind != Kind::Error && frame.id.raw() & 0x780 == 0x700).count();
    assert!(all == expected && all > 3, "{all} {expected}");
    for count in [0, 1, 3, all, all + 1] {
        let mut options = masked.clone();
        options.shown.limit = Some(count as u64);
        assert_eq!(shown(options.clone()), count.min(all));
        for size in [1, 100] {
            let mut session = Session::new(options.clone());
            let (mut out, mut done) = (Vec::new(), session.is_done());
            session.begin(b"x", Input::Live, false);
            for chunk in stream.chunks(size) {
                session.feed(chunk, &mut out);
                done |= session.is_done();
            }
            session.finish(&mut out);
            // The last frame may have waited for the next one.
            done |= session.is_done();
            assert_eq!(
                String::from_utf8(out).unwrap().replace("\"file\":\"x\"", "\"file\":\"can0\""),
                run(options.clone(), &stream)
            );
            assert_eq!(done, count <= all);
            let tally: Value = serde_json::from_slice(&session.tally()).unwrap();
            assert_eq!(tally["shown"], count.min(all));
        }
    }
}

#[test]
fn a_tally_agrees_with_what_is_told() {
    for path in logs() {
        let Some((frames, buses)) = frames_of(&path) else { continue };
        let mut session = Session::new(english(Output::json(Rows::Frames)));
        let mut out = Vec::new();
        session.begin(b"can0", Input::Live, false);
        session.feed(&live(&frames, &buses, 9), &mut out);
        session.finish(&mut out);
        let tally: Value = serde_json::from_slice(&session.tally()).unwrap();
        let lines: Vec<Value> =
            std::str::from_utf8(&out).unwrap().lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        let count = |wanted: &dyn Fn(&Value) -> bool| lines.iter().filter(|line| wanted(line)).count();
        assert_eq!((&tally["frames"], &tally["shown"]), (&frames.len().into(), &frames.len().into()));
        for (key, status) in [("ok", "ok"), ("aborted", "aborted"), ("incomplete", "incomplete"), ("failed", "failed")]
        {
            let ended = count(&|line| line["kind"] == "transfer" && line["status"] == status);
            assert_eq!(tally["transfers"][key], ended, "{path:?} {key}");
        }
        for severity in ["error", "warning", "info"] {
            let told = lines.iter().filter(|line| line["kind"] == "finding" && line["severity"] == severity);
            let told: u64 = told.map(|line| line["facts"]["repeated"].as_u64().unwrap_or(1)).sum();
            assert_eq!(tally["findings"][severity], told, "{path:?} {severity}");
        }
        let of_buses: u64 = tally["buses"].as_array().unwrap().iter().map(|bus| bus["frames"].as_u64().unwrap()).sum();
        assert_eq!(of_buses, frames.len() as u64);
    }
}

#[test]
fn a_recording_is_readable_while_it_grows() {
    let mut mcap = english(Output::Convert);
    mcap.writing.to = writers::Format::Mcap;
    let mut session = Session::new(mcap);
    let (mut out, mut read) = (Vec::new(), Vec::new());
    session.begin(b"can0", Input::Live, false);
    session.feed(&named(0, "can0"), &mut out);
    for no in 0..50 {
        session.feed(&heartbeat(5, no * 100), &mut out);
        session.feed(&until(Ns(START + no * 100 * MS)), &mut out);
        // The content on a disk at this time.
        let mut reader = Session::new(english(Output::json(Rows::Frames)));
        let mut text = Vec::new();
        reader.begin(b"x.mcap", Input::Mcap, false);
        reader.feed(&out, &mut text);
        reader.end(true, &mut text);
        read.push(reader.frames().0);
    }
    assert!(read.iter().zip(1..).all(|(read, seen)| read + 11 >= seen), "{read:?}");
    assert!(*read.last().unwrap() >= 40 && read[5] == 0, "{read:?}");
    // Without ticks it would be a single chunk.
    session.finish(&mut out);
    let mut reader = Session::new(english(Output::json(Rows::Summary)));
    let mut text = Vec::new();
    reader.begin(b"x.mcap", Input::Mcap, true);
    reader.feed(&out, &mut text);
    reader.finish(&mut text);
    assert_eq!(reader.frames().0, 50);
}

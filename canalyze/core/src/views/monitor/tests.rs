//! The view of small captures, through a whole session.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]

use std::sync::Arc;

use proptest::prelude::*;
use serde_json::{Value, json};

use super::{Line, Wanted};
use crate::bytes::ns::Ns;
use crate::bytes::readers::InputFormat as Input;
use crate::session::{Options, Output, Session};
use crate::views::filter::Filter;
use crate::words::Lang;
use crate::world::network::Network;

fn session(bit_rate: Option<u32>) -> Session {
    let network = Arc::new(Network { bit_rate, ..Network::default() });
    let mut options = Options::of(Lang::En, &[Output::Monitor]);
    options.known.network = network;
    let mut session = Session::new(options);
    session.begin(b"capture.log", Input::Candump, true);
    session
}

fn feed(session: &mut Session, text: &str) {
    let mut out = Vec::new();
    session.feed(text.as_bytes(), &mut out);
    assert!(out.is_empty());
}

/// Ends the input: pending lines and frames are processed.
fn end(session: &mut Session) {
    session.end(false, &mut Vec::new());
    session.rest(&mut Vec::new());
}

fn shot(session: &mut Session) -> Value {
    serde_json::from_slice(&session.snapshot()).unwrap()
}

/// Formats frames with their time in ms, as `ID#DATA`.
fn log(frames: &[(u64, &str)]) -> String {
    frames.iter().map(|(ms, frame)| format!("({}.{:06}) can0 {frame}\n", 100 + ms / 1000, ms % 1000 * 1000)).collect()
}

/// Returns the snapshot after these frames.
fn seen(frames: &[(u64, &str)]) -> Value {
    let mut session = session(Some(500_000));
    feed(&mut session, &log(frames));
    end(&mut session);
    shot(&mut session)
}

fn object<'a>(shot: &'a Value, id: &str) -> &'a Value {
    shot["objects"].as_array().unwrap().iter().find(|object| object["id"] == id).unwrap()
}

fn lines(session: &Session, filter: &str, search: &str, frame: Option<u64>, rows: usize, back: bool) -> Vec<Line> {
    session.trace(Wanted { filter: &Filter::parse(filter).unwrap(), search, frame, rows, back })
}

fn numbers(lines: &[Line]) -> Vec<u64> {
    lines.iter().map(|line| line.frame).collect()
}

#[test]
fn an_object_shows_its_last_frame_and_its_rhythm() {
    let frames: Vec<_> = (0..300u64).map(|no| (no * 10, format!("185#{:02X}00000000000000", no / 100))).collect();
    let frames: Vec<_> = frames.iter().map(|(ms, frame)| (*ms, frame.as_str())).collect();
    let shot = seen(&frames);
    let pdo = object(&shot, "185");
    let of = |key: &str| pdo[key].clone();
    assert_eq!((of("name"), of("node"), of("service")), (json!("TPDO1"), json!(5), json!("pdo")));
    assert_eq!((of("count"), of("len"), of("data")), (json!(300), json!(8), json!("0200000000000000")));
    assert_eq!((of("period_ns"), of("jitter_ns")), (json!(10_000_000), json!(0)));
    // The first byte has changed 0.99 s ago.
    assert_eq!(of("changed"), "FF00000000000000");
    assert!((of("rate").as_f64().unwrap() - 100.0).abs() < 1.0, "{pdo}");
    assert_eq!(of("text"), "TPDO1 of node 5: 8 bytes, mapping unknown");
    assert_eq!((of("last_ns"), &shot["now_ns"]), (json!(102_990_000_000u64), &json!(102_990_000_000u64)));
    assert_eq!(shot["start_ns"], json!(100_000_000_000u64));
    let bus = &shot["buses"][0];
    // 111 bits and some stuff bits a frame, 100 frames a second, 500 kbit/s.
    let load = bus["load_percent"].as_f64().unwrap();
    assert!((2.1..2.8).contains(&load), "{bus}");
    assert_eq!((&bus["bit_rate"], &bus["state"]), (&json!(500_000), &Value::Null));
    assert_eq!(shot["tally"]["frames"], 300);
}

#[test]
fn time_goes_on_without_frames() {
    let mut session = session(Some(500_000));
    let beats: Vec<_> = (0..8).map(|no| (no * 100, "705#05")).collect();
    feed(&mut session, &log(&beats));
    end(&mut session);
    let before = shot(&mut session);
    assert_eq!(before["nodes"][0]["heartbeat_age_ns"], 0);
    assert_eq!(before["nodes"][0]["heartbeat_period_ns"], 100_000_000);
    session.advance(Ns(105_000_000_000), &mut Vec::new());
    let after = shot(&mut session);
    assert_eq!(after["nodes"][0]["heartbeat_age_ns"], 4_300_000_000u64);
    assert_eq!((&after["nodes"][0]["frames_per_s"], &after["buses"][0]["load_percent"]), (&json!(0.0), &json!(0.0)));
    assert_eq!(object(&after, "705")["rate"], json!(0.0));
    // The heartbeat was missed, but no frame has shown that: nothing is marked.
    assert_eq!((&after["findings"][0]["code"], &after["nodes"][0]["findings"]["error"]), (&json!("HBT005"), &json!(0)));
    assert_eq!(object(&after, "705")["severity"], Value::Null);
    session.advance(Ns(1), &mut Vec::new());
    assert_eq!(shot(&mut session)["now_ns"], 105_000_000_000u64);
}

#[test]
fn a_node_that_is_no_longer_heard_is_silent() {
    let silent = |frames: &[(u64, &str)]| seen(frames)["nodes"][0]["silent"].clone();
    let beats: Vec<_> = (0..8).map(|no| (no * 100, "705#05")).collect();
    let then = |more: &[(u64, &'static str)]| silent(&[&beats[..], more].concat());
    // 700 ms + three periods and the tolerance of timestamps.
    assert_eq!(then(&[(1_000, "185#00")]), Value::Null);
    assert_eq!(then(&[(800, "185#00"), (900, "185#00"), (1_000, "185#00"), (1_100, "185#00")]), json!("heartbeat"));
    assert_eq!(then(&[(1_100, "185#00"), (1_110, "705#05")]), Value::Null);
    // It was commanded to reset: no heartbeat is due.
    assert_eq!(then(&[(750, "000#8105"), (1_200, "185#00")]), Value::Null);
    // The period is unknown after one heartbeat.
    assert_eq!(silent(&[(0, "705#05"), (5_000, "185#00")]), Value::Null);

    // The whole bus is silent: there is no verdict, but the node is still silent.
    let mut session = session(None);
    feed(&mut session, &log(&beats));
    end(&mut session);
    session.advance(Ns(105_000_000_000), &mut Vec::new());
    assert_eq!(shot(&mut session)["nodes"][0]["silent"], "heartbeat");

    let asked: Vec<_> = (0..8).map(|no| (no * 100, if no % 2 == 0 { "705#85" } else { "705#05" })).collect();
    let asked: Vec<_> = asked.into_iter().flat_map(|(ms, answer)| [(ms, "705#R"), (ms + 1, answer)]).collect();
    assert_eq!(silent(&asked), Value::Null);
    let unanswered: Vec<_> = (8..30).map(|no| (no * 100, "705#R")).collect();
    assert_eq!(silent(&[asked, unanswered].concat()), json!("guarding"));
}

#[test]
fn one_time_from_frame_to_frame_has_no_jitter() {
    let shot = seen(&[(0, "185#00"), (700, "185#00")]);
    assert_eq!(
        (&object(&shot, "185")["period_ns"], &object(&shot, "185")["jitter_ns"]),
        (&json!(700_000_000), &Value::Null)
    );
}

#[test]
fn without_stamps_there_are_no_times() {
    let mut session = session(Some(500_000));
    feed(&mut session, "  can0  705   [1]  05\n  can0  185   [2]  01 02\n  can0  185   [2]  01 03\n");
    session.advance(Ns(5), &mut Vec::new());
    end(&mut session);
    let shot = shot(&mut session);
    assert_eq!((&shot["now_ns"], &shot["start_ns"]), (&Value::Null, &Value::Null));
    let pdo = object(&shot, "185");
    for key in ["last_ns", "period_ns", "jitter_ns", "rate"] {
        assert_eq!(pdo[key], Value::Null, "{key}");
    }
    assert_eq!((&pdo["count"], &pdo["changed"]), (&json!(2), &json!("00FF")));
    for key in ["frames_per_s", "bits_per_s", "load_percent"] {
        assert_eq!(shot["buses"][0][key], Value::Null, "{key}");
    }
    for key in ["heartbeat_age_ns", "heartbeat_period_ns", "frames_per_s"] {
        assert_eq!(shot["nodes"][0][key], Value::Null, "{key}");
    }
    assert_eq!(lines(&session, "", "", None, 9, true)[0].t_ns, None);
}

#[test]
fn a_running_transfer_shows_how_far_it_is() {
    let mut session = session(None);
    feed(
        &mut session,
        &log(&[
            (0, "60A#4008100000000000"),
            (1, "58A#4108100017000000"),
            (2, "60A#6000000000000000"),
            (3, "58A#005A657068797220"),
            (4, "60A#7000000000000000"),
            (5, "58A#1052544F532F4341"),
            (6, "60B#4018100100000000"),
            (7, "58B#4318100101000000"),
            (8, "60C#4000200000000000"),
            (9, "58C#8000200000000206"),
            (10, "705#05"),
        ]),
    );
    end(&mut session);
    let shot = shot(&mut session);
    let running = shot["transfers"]["running"].as_array().unwrap();
    assert_eq!(running.len(), 1, "{running:?}");
    assert_eq!(
        (&running[0]["node"], &running[0]["index"], &running[0]["mode"]),
        (&json!(10), &json!("1008"), &json!("segmented"))
    );
    assert_eq!((&running[0]["size"], &running[0]["bytes"]), (&json!(23), &json!(14)));
    assert_eq!(running[0]["since_ns"], 100_000_000_000u64);
    let done = shot["transfers"]["done"].as_array().unwrap();
    assert_eq!(
        (&done[0]["node"], &done[0]["value"], &done[0]["duration_ns"]),
        (&json!(11), &json!(1), &json!(1_000_000))
    );
    assert_eq!((&done[1]["status"], &done[1]["abort"]["code"]), (&json!("aborted"), &json!("06020000")));
    assert_eq!(shot["tally"]["transfers"], json!({"ok": 1, "aborted": 1, "incomplete": 0, "failed": 0}));
    assert_eq!(object(&shot, "58A")["text"], "segment 2 of data from the server: \"RTOS/CA\"");
}

#[test]
fn emergencies_stand_until_they_are_taken_back() {
    let first = (0, "085#2081110000000000");
    let second = (5, "085#1052010000000000");
    let emcy = |frames: &[(u64, &str)]| seen(frames)["nodes"][0]["emcy"].clone();
    let stands = emcy(&[first]);
    assert_eq!(
        (&stands["code"], &stands["active"], &stands["t_ns"]),
        (&json!("8120"), &json!(1), &json!(100_000_000_000u64))
    );
    assert_eq!(stands["text"], "CAN in error passive mode");
    let both = emcy(&[first, second, (9, "085#0000010000000000")]);
    assert_eq!(
        (&both["code"], &both["active"], &both["t_ns"]),
        (&json!("5210"), &json!(2), &json!(100_005_000_000u64))
    );
    for taken_back in ["085#0000000000000000", "705#00"] {
        let was = emcy(&[first, (9, taken_back)]);
        assert_eq!((&was["code"], &was["active"], &was["t_ns"]), (&json!("8120"), &json!(0), &stands["t_ns"]));
    }
    assert_eq!(emcy(&[(9, "085#0000000000000000")]), Value::Null);
}

#[test]
fn the_controller_stands_as_it_said_last() {
    let state = |frames: &[(u64, &str)]| seen(frames)["buses"][0]["state"].clone();
    let passive = (0, "20000004#0020000000000000");
    assert_eq!(state(&[(0, "20000004#0008000000000000")]), "error-warning");
    assert_eq!(state(&[passive]), "error-passive");
    assert_eq!(state(&[passive, (1, "20000002#0500000000000000")]), "error-passive");
    assert_eq!(state(&[passive, (1, "20000004#0040000000000000")]), Value::Null);
    assert_eq!(state(&[passive, (1, "20000200#0000000000007F00")]), "error-warning");
    assert_eq!(state(&[(0, "20000040#0000000000000000")]), "bus-off");
    assert_eq!(state(&[(0, "20000040#0000000000000000"), (1, "080#")]), Value::Null);
    let shot = seen(&[passive, (1, "20000002#0500000000000000"), (2, "1FFFFFFF#")]);
    assert_eq!(shot["buses"][0]["error_frames"], 2);
    let objects = shot["objects"].as_array().unwrap();
    assert_eq!(objects.len(), 2);
    assert_eq!(
        (&objects[1]["id"], &objects[1]["service"], &objects[1]["count"]),
        (&json!("20000002"), &json!("error"), &json!(2))
    );
}

#[test]
fn many_identifiers_take_no_more_room() {
    let mut session = session(None);
    let mut text = String::new();
    for no in 0..3_000u32 {
        text.push_str(&format!("(1.{no:06}) can0 {:08X}#00\n", no * 7919 % 0x1FFF_FFFF));
    }
    text.push_str("(2.000000) can0 705#05\n(2.000001) can0 705#R\n");
    feed(&mut session, &text);
    end(&mut session);
    let shot = shot(&mut session);
    let objects = shot["objects"].as_array().unwrap();
    assert_eq!((objects.len(), &shot["objects_more"]), (1_026, &json!(1_976)));
    assert_eq!(
        (&objects[0]["id"], &objects[0]["rtr"], &objects[1]["rtr"]),
        (&json!("705"), &json!(false), &json!(true))
    );
    assert_eq!(shot["tally"]["frames"], 3_002);
}

#[test]
fn repeats_are_counted_in_the_last_row_of_their_kind() {
    let mut frames: Vec<(u64, String)> = (0..30).map(|no| (no * 100, "185#01".to_owned())).collect();
    frames.insert(0, (0, "705#00".to_owned()));
    let all: Vec<_> = frames.iter().map(|(ms, frame)| (*ms, frame.as_str())).collect();
    let mut session = session(None);
    feed(&mut session, &log(&all));
    end(&mut session);
    let shot = shot(&mut session);
    let rows = shot["findings"].as_array().unwrap();
    let of_kind: Vec<_> = rows.iter().filter(|row| row["code"] == rows[0]["code"]).collect();
    let all: u64 = rows.iter().map(|row| row["count"].as_u64().unwrap()).sum();
    let tally = &shot["tally"]["findings"];
    let told: u64 = ["error", "warning", "info"].iter().map(|key| tally[key].as_u64().unwrap()).sum();
    assert_eq!(all, told);
    assert!(of_kind.len() <= 10, "{rows:?}");
    // A line of the trace for each row, below the frame's own line.
    let told = lines(&session, "", "", None, 200, true);
    assert_eq!(told.iter().filter(|line| line.id.is_empty()).count(), rows.len());
    assert!(told.iter().filter(|line| line.id.is_empty()).all(|line| !line.severity.is_empty()));
}

#[test]
fn the_trace_is_read_in_both_directions() {
    let mut session = session(None);
    let frames: Vec<_> =
        (0..100u64).map(|no| (no, format!("{}#{no:02X}", if no % 2 == 0 { "185" } else { "705" }))).collect();
    let frames: Vec<_> = frames.iter().map(|(ms, frame)| (*ms, frame.as_str())).collect();
    feed(&mut session, &log(&frames));
    end(&mut session);
    let plain = "service=pdo";
    assert_eq!(numbers(&lines(&session, plain, "", None, 3, true)), [95, 97, 99]);
    assert_eq!(numbers(&lines(&session, plain, "", Some(50), 3, true)), [45, 47, 49]);
    assert_eq!(numbers(&lines(&session, plain, "", Some(50), 3, false)), [51, 53, 55]);
    assert_eq!(numbers(&lines(&session, plain, "", None, 2, false)), [1, 3]);
    assert_eq!(numbers(&lines(&session, "frame=7", "", None, 1, true)), [7]);
    assert_eq!(numbers(&lines(&session, plain, "185 0A", None, 9, true)), [11]);
    assert_eq!(numbers(&lines(&session, plain, "tpdo1 OF node 5", None, 2, true)), [97, 99]);
    assert!(lines(&session, "", "nowhere", None, 9, true).is_empty());
    assert!(lines(&session, "", "", None, 0, true).is_empty());
    let one = &lines(&session, plain, "", Some(1), 1, true)[0];
    let said = "TPDO1 of node 5: 1 byte, mapping unknown";
    assert_eq!((one.bus.as_str(), one.id.as_str(), one.data.as_str(), one.text.as_str()), ("can0", "185", "00", said));
}

#[test]
fn the_trace_is_bounded() {
    let mut session = session(None);
    let mut text = String::new();
    for no in 0..60_000u32 {
        text.push_str(&format!("({}.{:06}) can0 080#\n", 100 + no / 1000, no % 1000 * 1000));
    }
    feed(&mut session, &text);
    end(&mut session);
    let kept = lines(&session, "", "", None, usize::MAX, true);
    assert!((50_000..51_100).contains(&kept.len()), "{}", kept.len());
    assert_eq!(kept.last().unwrap().frame, 60_000);
    assert_eq!(lines(&session, "", "", Some(1), 2, false)[0].frame, kept[0].frame);
}

#[test]
fn no_time_is_measured_across_lost_frames() {
    let mut session = session(None);
    feed(&mut session, &log(&[(0, "705#05"), (100, "705#05")]));
    feed(&mut session, "DROPCOUNT: dropped 5 CAN frames on 'can0' socket (total drops 5)\n");
    feed(&mut session, &log(&[(9_000, "705#05"), (9_100, "705#05")]));
    end(&mut session);
    let shot = shot(&mut session);
    let beat = object(&shot, "705");
    assert_eq!((&beat["count"], &beat["period_ns"]), (&json!(4), &json!(100_000_000)));
    assert_eq!(shot["buses"][0]["dropped"], 5);
    let told = lines(&session, "", "CAP002", None, 9, true);
    assert_eq!((told.len(), told[0].severity, told[0].frame), (1, "warning", 2));
}

#[test]
fn a_filter_leaves_the_state_alone() {
    let filter = Filter::parse("service=emcy").unwrap();
    let mut options = Options::of(Lang::Zh, &[Output::Monitor]);
    options.shown.filter = filter;
    let mut session = Session::new(options);
    session.begin(b"capture.log", Input::Candump, true);
    feed(&mut session, &log(&[(0, "705#05"), (1, "085#2081110000000000"), (2, "185#00")]));
    end(&mut session);
    let shot = shot(&mut session);
    assert_eq!((&shot["tally"]["frames"], &shot["tally"]["shown"]), (&json!(3), &json!(1)));
    assert_eq!(shot["objects"].as_array().unwrap().len(), 3);
    assert!(numbers(&lines(&session, "", "", None, 9, true)).iter().all(|no| *no == 2));
}

/// Lines of a capture, most of them valid, so that state builds up.
fn line() -> impl Strategy<Value = String> {
    let ids = prop_oneof![
        Just("000".to_owned()),
        Just("080".to_owned()),
        Just("100".to_owned()),
        Just("085".to_owned()),
        Just("105".to_owned()),
        Just("106".to_owned()),
        Just("185".to_owned()),
        Just("585".to_owned()),
        Just("605".to_owned()),
        Just("705".to_owned()),
        Just("7E5".to_owned()),
        Just("20000004".to_owned()),
        (0u32..0x2000_0000).prop_map(|id| format!("{id:08X}")),
    ];
    let data = prop_oneof![prop::collection::vec(any::<u8>(), 0..9), Just(vec![0x40, 0x08, 0x10, 0, 0, 0, 0, 0])];
    let stamp = prop_oneof![4 => 0i64..5_000_000, 1 => any::<i64>().prop_map(|us| us.saturating_abs() / 1000)];
    (stamp, 0u8..3, ids, data, any::<bool>()).prop_map(|(us, bus, id, data, remote)| {
        let data: String = data.iter().map(|byte| format!("{byte:02X}")).collect();
        let data = if remote && us % 7 == 0 { "R".to_owned() } else { data };
        format!("({}.{:06}) can{bus} {id}#{data}\n", us / 1_000_000, us % 1_000_000)
    })
}

fn all(bytes: &[u8], piece: usize) -> (Vec<u8>, Vec<Line>) {
    let mut session = session(Some(125_000));
    let mut out = Vec::new();
    for chunk in bytes.chunks(piece.max(1)) {
        session.feed(chunk, &mut out);
    }
    session.end(false, &mut out);
    session.finish(&mut out);
    (session.snapshot(), lines(&session, "", "", None, usize::MAX, true))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn any_bytes_show_something_and_the_same_in_any_pieces(bytes in prop::collection::vec(any::<u8>(), 0..600), piece in 1usize..80) {
        let whole = all(&bytes, bytes.len());
        prop_assert!(serde_json::from_slice::<Value>(&whole.0).is_ok());
        prop_assert_eq!(whole, all(&bytes, piece));
    }

    #[test]
    fn any_frames_show_something_and_the_same_in_any_pieces(text in prop::collection::vec(line(), 0..120), piece in 1usize..200) {
        let text = text.concat();
        let whole = all(text.as_bytes(), text.len());
        let shot = serde_json::from_slice::<Value>(&whole.0).unwrap();
        let counted: u64 = shot["objects"].as_array().unwrap().iter().map(|object| object["count"].as_u64().unwrap()).sum();
        prop_assert_eq!(counted, shot["tally"]["frames"].as_u64().unwrap());
        prop_assert_eq!(whole, all(text.as_bytes(), piece));
    }
}

/// Node 5 is silent after 2 s, and node 6 continues until 3 s; the capture ends at `until_ms` without a frame.
fn lost(until_ms: Option<i64>) -> Value {
    let beats = (0..30u64).flat_map(|beat| {
        let five = (beat < 20).then_some((beat * 100, "705#05"));
        five.into_iter().chain([(beat * 100 + 1, "706#05")])
    });
    let beats: Vec<_> = beats.collect();
    let mut session = session(None);
    feed(&mut session, &log(&beats));
    end(&mut session);
    if let Some(until_ms) = until_ms {
        session.advance(Ns(until_ms * 1_000_000), &mut Vec::new());
    }
    shot(&mut session)
}

#[test]
fn what_goes_wrong_is_shown_while_it_goes_on_and_may_change_until_its_cause_is_known() {
    let shot = lost(None);
    let first = &shot["problems"][0];
    let of = |key: &str| first[key].clone();
    assert_eq!((of("kind"), of("status"), of("node")), (json!("node-silent"), json!("open"), json!(5)));
    assert_eq!((of("frame"), of("end_frame"), of("provisional")), (json!(39), json!(null), json!(true)));
    assert_eq!(shot["nodes"][0]["problem"]["word"], "node silent");
    assert_eq!((&shot["nodes"][1]["problem"], &shot["problems_more"]), (&json!(null), &json!(0)));
    // No further frame comes, and the other node is late by now, too.
    let later = lost(Some(103_200));
    assert_eq!(later["problems"].as_array().unwrap().len(), 1);
    let silent = lost(Some(110_000));
    let provisional: Vec<_> = silent["problems"].as_array().unwrap().iter().map(|one| &one["provisional"]).collect();
    assert_eq!(provisional.first(), Some(&&json!(false)), "{}", silent["problems"]);
}

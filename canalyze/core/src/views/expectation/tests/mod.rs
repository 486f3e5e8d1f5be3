//! Expectations of every kind, applied to small captures: the findings and their frames.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]

mod any;
mod measured;
mod problems;
mod states;
mod transfers;

use std::sync::Arc;

use serde_json::Value;

use super::Expectations;
use crate::bytes::readers::InputFormat as Input;
use crate::bytes::readers::candump::Stamps;
use crate::session::{Knowledge, Options, Output, Rows, Session};
use crate::words::Lang;
use crate::world::dictionary::{Access, Dictionary, Form, Object, Preset};
use crate::world::network::{Description, Network};

/// A finding about an expectation: its code, the frame, the earlier frame it is about (0: none), the line of the
/// expectation.
type Raised = (String, u64, u64, u64);

/// Returns a capture in short form: `0.1 705#05` or `0.1 705#05 can1`, frames separated by `;` or line ends. Without
/// timestamps the first word is `-`.
fn capture(short: &str) -> String {
    let mut log = String::new();
    for frame in short.split([';', '\n']).map(str::trim).filter(|frame| !frame.is_empty()) {
        let words: Vec<_> = frame.split_whitespace().collect();
        let bus = words.get(2).unwrap_or(&"can0");
        if words[0] == "-" {
            let (id, data) = words[1].split_once('#').unwrap();
            let bytes: Vec<_> = data.as_bytes().chunks(2).map(|pair| std::str::from_utf8(pair).unwrap()).collect();
            log.push_str(&format!("  {bus}  {id}   [{}]  {}\n", bytes.len(), bytes.join(" ")));
        } else {
            let seconds: f64 = words[0].parse().unwrap();
            log.push_str(&format!("({seconds:.6}) {bus} {}\n", words[1]));
        }
    }
    log
}

/// A drive on node 5: TPDO 1 is statusword, velocity (0.1 rpm) and a bit, TPDO 2 the velocity with every SYNC.
fn network() -> Network {
    let object = |index, sub, data_type, value, name: &str| Object {
        index,
        sub,
        name: name.into(),
        data_type,
        access: Access::Rw,
        preset: Some(Preset { value, relative: sub == 1 && index & 0xFF00 == 0x1800, configured: false }),
        mappable: true,
        unit: None,
        factor: if index == 0x606C { 0.1 } else { 1.0 },
    };
    let objects = vec![
        object(0x1000, 0, 7, 0x0002_0192, "Device type"),
        object(0x1800, 1, 7, 0x4000_0180, "COB-ID"),
        object(0x1800, 2, 5, 255, "Transmission type"),
        object(0x1A00, 0, 5, 3, "Entries"),
        object(0x1A00, 1, 7, 0x6041_0010, "Entry"),
        object(0x1A00, 2, 7, 0x606C_0020, "Entry"),
        object(0x1A00, 3, 7, 0x2000_0001, "Entry"),
        object(0x1801, 1, 7, 0x4000_0280, "COB-ID"),
        object(0x1801, 2, 5, 1, "Transmission type"),
        object(0x1A01, 0, 5, 1, "Entries"),
        object(0x1A01, 1, 7, 0x606C_0020, "Entry"),
        object(0x2000, 0, 1, 0, "Door"),
        object(0x6041, 0, 6, 0, "Statusword"),
        object(0x606C, 0, 4, 0, "Velocity actual value"),
    ];
    let dictionary = Arc::new(Dictionary::new("drive.eds".into(), Form::Eds, "drive".into(), objects));
    Network { descriptions: vec![Description { bus: None, node: 5, dictionary }], ..Network::default() }
}

/// Returns all findings of a capture about expectations, as JSON.
fn findings(expected: &str, log: &str, lang: Lang, chunk: usize) -> Vec<Value> {
    let expectations = Some(Arc::new(Expectations::read(expected).unwrap()));
    let mut options = Options::of(lang, &[Output::json(Rows::Frames)]);
    options.known = Knowledge { network: Arc::new(network()), expectations };
    options.reading.stamps = Stamps::Zero;
    let mut session = Session::new(options);
    let mut out = Vec::new();
    session.begin(b"x.log", Input::Candump, true);
    for bytes in log.as_bytes().chunks(chunk) {
        session.feed(bytes, &mut out);
    }
    session.end(false, &mut out);
    session.finish(&mut out);
    let lines = out.split(|byte| *byte == b'\n').filter(|line| !line.is_empty());
    let rows = lines.map(|line| serde_json::from_slice::<Value>(line).unwrap());
    rows.filter(|row| row["kind"] == "finding" && row["code"].as_str().unwrap().starts_with("EXP")).collect()
}

fn raised(rows: &[Value]) -> Vec<Raised> {
    let line = |row: &Value| row["facts"]["expectation"].as_str().unwrap().rsplit_once(':').unwrap().1.parse().unwrap();
    let one = |row: &Value| {
        let cause = row["cause_frame"].as_u64().unwrap_or(0);
        (row["code"].as_str().unwrap().to_owned(), row["frame"].as_u64().unwrap(), cause, line(row))
    };
    rows.iter().map(one).collect()
}

/// Applies expectations to captures. `kind`: their list; their lines are numbered from 1.
fn check(kind: &str, entries: &[&str], short: &str, expected: &[(&str, u64, u64, u64)]) {
    let numbered = entries.iter().zip(1..).map(|(entry, line)| format!("{{\"line\":{line},{entry}}}"));
    let json = format!("{{\"file\":\"x.toml\",\"{kind}\":[{}]}}", numbered.collect::<Vec<_>>().join(","));
    let log = capture(short);
    let rows = findings(&json, &log, Lang::En, usize::MAX);
    let wanted: Vec<Raised> = expected.iter().map(|row| (row.0.to_owned(), row.1, row.2, row.3)).collect();
    let messages: Vec<_> = rows.iter().map(|row| row["message"].as_str().unwrap()).collect();
    assert_eq!(raised(&rows), wanted, "{entries:?}\n{short}\n{messages:#?}");
    assert_eq!(findings(&json, &log, Lang::En, 7), rows, "the same whatever the chunking");
    let chinese = findings(&json, &log, Lang::Zh, usize::MAX);
    for (one, other) in rows.iter().zip(&chinese) {
        assert_eq!(one["facts"], other["facts"]);
        let words = |row: &Value| row["message"].as_str().unwrap().to_owned();
        assert!(words(one).is_ascii() && !words(other).is_ascii(), "{one} {other}");
        assert!(!words(one).contains(['{', '}']) && !words(other).contains(['{', '}']), "{one}");
    }
}

#[test]
fn mistakes_of_the_normalized_form() {
    for json in [
        "",
        r#"{"other":1}"#,
        r#"{"sdo":[{"line":1,"node":5,"index":1,"sub":0,"more":1}]}"#,
        r#"{"sdo":[{"line":1,"node":0,"index":1,"sub":0}]}"#,
        r#"{"sdo":[{"line":1,"node":5,"index":65536,"sub":0}]}"#,
        r#"{"sdo":[{"line":1,"node":5,"index":1,"sub":0,"outcome":"aborted","value":{"number":1}}]}"#,
        r#"{"sdo":[{"line":1,"node":5,"index":1,"sub":0,"abort":1}]}"#,
        r#"{"sdo":[{"line":1,"node":5,"index":1,"sub":0,"count":0,"sequence":"x"}]}"#,
        r#"{"state":[{"line":1,"node":5}]}"#,
        r#"{"state":[{"line":1,"node":5,"state":"operational","drive":"fault"}]}"#,
        r#"{"state":[{"line":1,"node":5,"state":"Operational"}]}"#,
        r#"{"state":[{"line":1,"node":5,"drive":"fault","axis":9}]}"#,
        r#"{"state":[{"line":1,"node":5,"state":"boot-up","stays":true}]}"#,
        r#"{"state":[{"line":1,"node":5,"state":"stopped","by_ns":-1}]}"#,
        r#"{"signal":[{"line":1,"select":" ,"}]}"#,
        r#"{"signal":[{"line":1,"select":"*","min":2,"max":1}]}"#,
        r#"{"signal":[{"line":1,"select":"*","period_ns":5}]}"#,
        r#"{"heartbeat":[{"line":1,"node":5,"period_ns":0,"tolerance_ns":0}]}"#,
        r#"{"sync":[{"line":1,"period_ns":1}]}"#,
        r#"{"emcy":[{"line":1,"occurs":"often"}]}"#,
        r#"{"problem":[{"line":1}]}"#,
        r#"{"problem":[{"line":1,"occurs":[2,1]}]}"#,
        r#"{"problem":[{"line":1,"ends_within_ns":0}]}"#,
        r#"{"problem":[{"line":1,"occurs":[0,0],"node":128}]}"#,
        r#"{"latency":[{"line":1,"of":"sync","index":1,"max_ns":1}]}"#,
        r#"{"latency":[{"line":1,"of":"sdo","sub":1,"max_ns":1}]}"#,
        r#"{"load":[{"line":1,"max_percent":101}]}"#,
        r#"{"load":[{"line":1,"max_percent":10,"window_ns":0}]}"#,
    ] {
        assert!(Expectations::read(json).is_err(), "{json}");
    }
    assert!(Expectations::read("{}").is_ok());
    let nulls = r#"{"file":"x","sdo":[{"line":1,"bus":null,"node":5,"index":1,"sub":0,"direction":null,"value":null,
        "outcome":null,"abort":null,"sequence":null,"count":null,"within_ns":null}],"state":[{"line":2,"bus":null,"node":5,
        "state":"stopped","drive":null,"axis":null,"by_ns":null,"since":null,"stays":null}],"signal":[{"line":3,"bus":null,
        "select":"*","min":null,"max":null,"period_ns":null,"tolerance_ns":null}],"emcy":[{"line":4,"bus":null,"node":null,
        "code":null,"occurs":"may"}],"latency":[{"line":5,"bus":null,"node":null,"of":"sdo","index":null,"sub":null,
        "pdo":null,"max_ns":1}],"problem":[{"line":7,"bus":null,"node":null,"kind":null,"occurs":[1,null],"ends_within_ns":null,"cause":null}],
        "load":[{"line":6,"bus":null,"max_percent":50,"bit_rate":null,"window_ns":null}]}"#;
    assert!(Expectations::read(nulls).is_ok(), "{:?}", Expectations::read(nulls));
}

#[test]
fn a_capture_without_frames_says_nothing() {
    let json = r#"{"file":"x","heartbeat":[{"line":1,"node":5,"period_ns":1,"tolerance_ns":0}]}"#;
    assert!(findings(json, "# nothing\n", Lang::En, 5).is_empty());
}

#[test]
fn a_bus_that_is_named() {
    let entry = r#""node":5,"bus":"can1","period_ns":1000000000,"tolerance_ns":0"#;
    check("heartbeat", &[entry], "0 705#05;1 705#05;2 705#05", &[("EXP009", 3, 0, 1)]);
    check("heartbeat", &[entry], "0 705#05 can1;0.5 705#05;1 705#05 can1", &[]);
    let json = format!("{{\"file\":\"x\",\"heartbeat\":[{{\"line\":1,{entry}}}]}}");
    assert_eq!(findings(&json, &capture("0 705#05"), Lang::En, 5)[0]["bus"], Value::Null);
}

#[test]
fn repeats_are_folded_by_expectation() {
    let entries = [r#""select":"5.606C","max":1"#, r#""select":"5.606C","max":2"#];
    let frames: Vec<_> = (0..20).map(|no| format!("{no} 185#00006400000000")).collect();
    let numbered = entries.iter().zip(1..).map(|(entry, line)| format!("{{\"line\":{line},{entry}}}"));
    let json = format!("{{\"file\":\"x.toml\",\"signal\":[{}]}}", numbered.collect::<Vec<_>>().join(","));
    let rows = findings(&json, &capture(&frames.join(";")), Lang::En, 100);
    assert_eq!(rows.len(), 22);
    let last = &rows[21];
    assert_eq!(last["facts"], serde_json::json!({"expectation": "x.toml:2", "repeated": 10}));
    assert_eq!(last["message"], "node 5 606Ch:00: 10 more of the same (expected by x.toml:2)");
}

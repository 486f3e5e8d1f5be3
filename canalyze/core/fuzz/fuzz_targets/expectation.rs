//! Arbitrary expectations of arbitrary traffic: no panic, and every finding names a frame and the line it is about.
//!
//! The first byte sets the options. Up to the first zero byte stands the JSON of expectations, or what they are drawn
//! from; the rest are frames as `traffic` reads them.
#![no_main]

mod traffic;

use std::sync::Arc;

use canalyze_core::bytes::frame::Frame;
use canalyze_core::bytes::ns::Ns;
use canalyze_core::session::{Knowledge, Options, Output, Rows, Session};
use canalyze_core::views::expectation::Expectations;
use canalyze_core::words::Lang;
use libfuzzer_sys::fuzz_target;
use serde_json::{Map, Value, json};

/// Takes choices from bytes; at their end the first choice.
struct Draw<'a>(&'a [u8]);

impl Draw<'_> {
    fn byte(&mut self) -> u8 {
        let [first, rest @ ..] = self.0 else { return 0 };
        self.0 = rest;
        *first
    }

    fn of(&mut self, choices: &Value) -> Value {
        let choices = choices.as_array().expect("choices");
        choices[usize::from(self.byte()) % choices.len()].clone()
    }
}

/// Keys of every kind of entry and what may stand there; null is left out.
fn tables() -> Value {
    let ns = json!([null, 0, 1, 200_000, 10_000_000, 600_000_000, i64::MAX]);
    let period = json!([1, 200_000, 10_000_000, 600_000_000, i64::MAX]);
    let tolerance = json!([0, 1, 1_000_000, i64::MAX]);
    let bus = json!([null, null, "can0", ""]);
    let node = json!([5, 6, 1, 127]);
    json!({
        "sdo": {"bus": bus, "node": node, "index": [0x1000, 0x1017, 0x1A00, 0x2000, 0x6041, 0xFFFF], "sub": [0, 1, 255],
            "direction": [null, "upload", "download"], "outcome": [null, "ok", "aborted", "any"],
            "value": [null, {"number": 0}, {"number": -1}, {"number": 1.5}, {"number": u64::MAX}, {"text": ""},
                {"text": "a"}, {"bool": true}, {"data": ""}, {"data": "E803"}],
            "abort": [null, null, 0x0602_0000_u32, 0], "sequence": [null, "a", "b"], "count": [null, 1, 0, 2, u64::MAX],
            "within_ns": ns},
        "state": {"bus": bus, "node": node, "state": [null, "boot-up", "stopped", "operational", "pre-operational"],
            "drive": [null, "fault", "operation-enabled", "switched-on", "not-ready-to-switch-on"],
            "axis": [null, 1, 2, 8], "by_ns": ns, "since": [null, "start", "boot-up"], "stays": [null, true, false]},
        "signal": {"bus": bus, "select": ["5.*", "*", "6041", "5.TPDO1.606C:00", "?", "5.RPDO1.*,object"],
            "min": [null, -1, 0, 1e300], "max": [null, 0, 1.5, -1e300], "period_ns": [null, 1, 10_000_000, i64::MAX],
            "tolerance_ns": [null, 0, 1_000_000, i64::MAX]},
        "heartbeat": {"bus": bus, "node": node, "period_ns": period, "tolerance_ns": tolerance},
        "sync": {"bus": bus, "period_ns": period, "tolerance_ns": tolerance},
        "emcy": {"bus": bus, "node": [null, 5, 127], "code": [null, [0, 0], [0x8130, 0xFFFF], [0x8100, 0xFF00]],
            "occurs": ["never", "must", "may"]},
        "latency": {"bus": bus, "node": [null, 5], "of": ["sdo", "sync", "nmt"], "index": [null, null, 0x1017],
            "sub": [null, null, 0], "pdo": [null, null, 1, 512], "max_ns": [0, 1, 1_000_000, i64::MAX]},
        "load": {"bus": bus, "max_percent": [0, 1, 60.5, 100], "bit_rate": [null, 1, 125_000, u32::MAX],
            "window_ns": [null, 1, 10_000_000, i64::MAX]},
    })
}

fn drawn(bytes: &[u8]) -> String {
    let tables = tables();
    let kinds: Vec<(&String, &Value)> = tables.as_object().expect("tables").iter().collect();
    let mut whole = Map::from_iter([("file".to_owned(), json!("x.toml"))]);
    let mut draw = Draw(bytes);
    let mut line = 0;
    while !draw.0.is_empty() {
        line += 1;
        let (name, keys) = kinds[usize::from(draw.byte()) % kinds.len()];
        let mut entry = Map::from_iter([("line".to_owned(), json!(line))]);
        for (key, choices) in keys.as_object().expect("keys") {
            let value = draw.of(choices);
            if !value.is_null() {
                entry.insert(key.clone(), value);
            }
        }
        // An entry that cannot be would spoil all of them.
        if Expectations::read(&json!({name: [entry]}).to_string()).is_ok() {
            let list = whole.entry(name.clone()).or_insert_with(|| json!([]));
            list.as_array_mut().expect("list").push(Value::Object(entry));
        }
    }
    Value::Object(whole).to_string()
}

fn run(frames: &[Frame], options: Options) -> String {
    let mut session = Session::new(options);
    let mut out = Vec::new();
    for frame in frames {
        session.push(*frame, &mut out);
    }
    session.advance(Ns::MAX, &mut out);
    session.finish(&mut out);
    String::from_utf8(out).expect("output is UTF-8")
}

fuzz_target!(|input: &[u8]| {
    let [choice, rest @ ..] = input else { return };
    let end = rest.iter().position(|byte| *byte == 0).unwrap_or(rest.len());
    let (said, frames) = rest.split_at(end);
    let json = if choice & 4 == 0 { drawn(said) } else { String::from_utf8_lossy(said).into_owned() };
    let Ok(expectations) = Expectations::read(&json) else { return };
    let expectations = Some(Arc::new(expectations));
    let frames = traffic::frames(frames.get(1..).unwrap_or_default(), choice & 1 == 0);
    let network = Arc::new(if choice & 8 == 0 { traffic::network() } else { Default::default() });
    let options = |output| Options {
        threads: Some(1),
        known: Knowledge { network: Arc::clone(&network), expectations: expectations.clone() },
        ..Options::of(if choice & 2 == 0 { Lang::Zh } else { Lang::En }, &[output])
    };
    for line in run(&frames, options(Output::json(Rows::Findings))).lines() {
        let row: Value = serde_json::from_str(line).expect("every line is an object");
        let at = row["frame"].as_u64().expect("a finding names a frame");
        assert!(at >= 1 && at <= frames.len() as u64, "it is one of the capture");
        if row["code"].as_str().is_some_and(|code| code.starts_with("EXP")) {
            assert!(row["facts"]["expectation"].is_string(), "it names the expectation");
        }
    }
    run(&frames, options(Output::Lines));
});

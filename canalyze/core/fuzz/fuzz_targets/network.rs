//! Arbitrary traffic of a whole network, pushed frame by frame: no panic, and every frame has its line.
//!
//! The first byte sets the options, the rest are frames as `traffic` reads them. Node 5 carries a description, so that
//! its PDOs are signals. What `check` finds, and what is in tables, is what is in JSON lines.
#![no_main]

mod traffic;

use std::collections::BTreeMap;
use std::sync::{Arc, LazyLock};

use canalyze_core::bytes::frame::Frame;
use canalyze_core::bytes::ns::Ns;
use canalyze_core::session::{Format, Knowledge, Options, Output, Session};
use canalyze_core::tables::columns::Name;
use canalyze_core::views::expectation::Expectations;
use canalyze_core::views::finding_context::MOST;
use canalyze_core::words::{Depth, Lang};
use canalyze_core::world::network::Network;
use libfuzzer_sys::fuzz_target;
use serde_json::Value;

/// Expectations of every kind.
const EXPECTED: &str = r#"{"file":"x.toml",
"sdo":[{"line":1,"node":5,"index":4119,"sub":0,"value":{"number":1000},"sequence":"a"},
 {"line":2,"node":5,"index":4104,"sub":0,"value":{"text":"x"},"sequence":"a","within_ns":1000000},
 {"line":3,"node":6,"index":4096,"sub":0,"count":0,"outcome":"any"}],
"state":[{"line":4,"node":5,"state":"operational","by_ns":5000000,"since":"boot-up","stays":true},
 {"line":5,"node":5,"drive":"operation-enabled","stays":true}],
"signal":[{"line":6,"select":"5.*","min":-1,"max":1.5,"period_ns":10000000,"tolerance_ns":1000000}],
"heartbeat":[{"line":7,"node":5,"period_ns":100000000,"tolerance_ns":0}],
"sync":[{"line":8,"period_ns":10000000,"tolerance_ns":0}],
"emcy":[{"line":9,"occurs":"never"},{"line":10,"node":5,"code":[33024,65280],"occurs":"must"}],
"latency":[{"line":11,"of":"sdo","max_ns":0},{"line":12,"of":"sync","max_ns":0},{"line":13,"of":"nmt","max_ns":0}],
"load":[{"line":14,"max_percent":1,"bit_rate":125000,"window_ns":10000000}]}"#;

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

/// Rows of every table.
fn rows(frames: &[Frame], options: Options) -> BTreeMap<String, u64> {
    let mut options = options;
    options.writing.outputs = Name::NAMES.iter().map(|(_, name)| Output::Columns(*name)).collect();
    let mut session = Session::new(options);
    let mut rows = BTreeMap::new();
    let mut out = Vec::new();
    for (place, frame) in frames.iter().enumerate() {
        session.push(*frame, &mut out);
        if place % 16 == 15 {
            count(&mut rows, &mut session);
        }
    }
    session.advance(Ns::MAX, &mut out);
    session.finish(&mut out);
    count(&mut rows, &mut session);
    assert!(out.is_empty(), "columns are no bytes");
    rows
}

fn count(rows: &mut BTreeMap<String, u64>, session: &mut Session) {
    for batch in session.take_batches(false) {
        *rows.entry(batch.name.to_string()).or_default() += batch.rows.num_rows() as u64;
    }
}

static NETWORK: LazyLock<Arc<Network>> = LazyLock::new(|| Arc::new(traffic::network()));
static EXPECTATIONS: LazyLock<Arc<Expectations>> =
    LazyLock::new(|| Arc::new(Expectations::read(EXPECTED).expect("they are well-formed")));

/// Findings in order, without the lines of their context.
fn findings(lines: &str) -> Vec<Value> {
    let rows = lines.lines().map(|line| serde_json::from_str::<Value>(line).expect("every line is an object"));
    let found = rows.filter(|row| row["kind"] == "finding").map(|mut row| {
        assert!(row["frame"].is_u64(), "every finding names a frame");
        if let Some(lines) = row.as_object_mut().and_then(|row| row.remove("lines")) {
            let numbers: Vec<u64> =
                lines.as_array().expect("lines").iter().map(|line| line["frame"].as_u64().expect("frame")).collect();
            assert!(numbers.len() <= MOST && numbers.is_sorted(), "a few, oldest first");
        }
        row
    });
    found.collect()
}

// A session costs more than its frames, so an execution tries one law with one session, or with two that it compares.
fuzz_target!(|input: &[u8]| {
    let [choice, rest @ ..] = input else { return };
    let frames = traffic::frames(rest, choice & 1 == 0);
    let options = |name| {
        let (_, format) = Format::NAMES.iter().find(|row| row.0 == name).expect("it is a format");
        let mut options = Options::of(if choice & 2 == 0 { Lang::Zh } else { Lang::En }, format.outputs);
        let expectations = (choice & 8 != 0).then(|| Arc::clone(&EXPECTATIONS));
        // Frames are pushed on one thread; without the number each session asks the system how many it has.
        options.threads = Some(1);
        options.known = Knowledge { network: Arc::clone(&NETWORK), expectations };
        options.writing.depth = if choice & 4 == 0 { Depth::Default } else { Depth::Explain };
        options
    };
    let of_kind = |lines: &str, kind: &str| {
        lines.lines().filter(|line| line.starts_with(&format!(r#"{{"kind":"{kind}""#))).count()
    };
    match choice >> 4 {
        0 | 1 => {
            let text = run(&frames, options("text"));
            assert_eq!(text.lines().filter(|line| !line.starts_with('#')).count(), frames.len(), "a line a frame");
        }
        2 => {
            run(&frames, options("signals-csv"));
        }
        law @ 3..=5 => {
            let name = ["summary", "observed", "records"][usize::from(law - 3)];
            for line in run(&frames, options(name)).lines() {
                serde_json::from_str::<Value>(line).expect("every line is an object");
            }
        }
        6 | 7 => {
            let json = run(&frames, options("jsonl"));
            assert_eq!(of_kind(&json, "frame"), frames.len(), "an object a frame");
            assert_eq!(findings(&run(&frames, options("check"))), findings(&json), "the same findings");
        }
        8..=10 => told(&run(&frames, options("diagnosis"))),
        11 => {
            let mut problems = options("text");
            problems.writing.outputs.push(Output::LinesOfChanges);
            run(&frames, problems);
        }
        12 => {
            let rows = rows(&frames, options("columns"));
            assert_eq!(rows.get("frames").copied().unwrap_or(0), frames.len() as u64, "a row a frame");
        }
        _ => {
            let rows = rows(&frames, options("columns"));
            let json = run(&frames, options("jsonl"));
            let of = |name: &str| rows.get(name).copied().unwrap_or(0) as usize;
            assert_eq!(of("transfers"), of_kind(&json, "transfer"), "a row a transfer");
            assert_eq!(of("findings"), of_kind(&json, "finding"), "a row a finding");
        }
    }
});

/// Problems are numbered in order, causes are told and lead to a root, and what is over has an end.
fn told(output: &str) {
    let rows: Vec<serde_json::Value> =
        output.lines().map(|line| serde_json::from_str(line).expect("a problem is JSON")).collect();
    let problems: Vec<_> = rows.iter().filter(|row| row["kind"] == "problem").collect();
    let cause = |id: u64| {
        let one = problems.iter().find(|one| one["id"] == id).expect("a cause is told");
        one["cause"]["id"].as_u64()
    };
    for one in &problems {
        let mut at = one["cause"]["id"].as_u64();
        for _ in 0..=problems.len() {
            at = at.and_then(cause);
        }
        assert_eq!(at, None, "causes go in circles");
        assert!(one["steps"].as_array().is_some_and(|steps| steps.len() <= 16));
        assert!(one["begin"]["frame"].as_u64() >= Some(1));
        assert!(one["status"] != "ended" || !one["end"].is_null(), "ended without an end: {one}");
    }
    assert!(problems.windows(2).all(|two| two[0]["id"].as_u64() < two[1]["id"].as_u64()));
}

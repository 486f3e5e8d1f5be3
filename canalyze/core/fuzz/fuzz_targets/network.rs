//! Arbitrary traffic of a whole network, pushed frame by frame: no panic, and every frame has its line.
//!
//! The first byte sets the options. Each frame is two bytes of identifier and kind, one byte of time since the frame
//! before, one byte of length, and its data. Node 5 carries a description, so that its PDOs are signals.
#![no_main]

use std::sync::Arc;

use canalyze_core::dictionary::{Access, Dictionary, Form, Object, Preset};
use canalyze_core::expectation::Expectations;
use canalyze_core::frame::{BusId, CanId, Frame, Kind, Stamp, StampForm};
use canalyze_core::network::{Description, Network};
use canalyze_core::session::{Format, Options, Session};
use canalyze_core::text::{Depth, Lang};
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

/// Time since the frame before, in ns, by the byte's lowest three bits; bit 3 makes it a step back.
const GAPS_NS: [i64; 8] = [0, 200_000, 1_000_000, 4_900_000, 10_000_000, 50_000_000, 600_000_000, i64::MAX / 4];

fn object(index: u16, sub: u8, data_type: u16, value: u64) -> Object {
    Object {
        index,
        sub,
        name: format!("object {index:04X}").into(),
        data_type,
        access: if index == 0x6041 { Access::Ro } else { Access::Rw },
        preset: Some(Preset { value, relative: sub == 1 && index & 0xFF00 == 0x1800, configured: false }),
        mappable: true,
        unit: (index == 0x606C).then(|| "rpm".into()),
        factor: if index == 0x6077 { 0.1 } else { 1.0 },
    }
}

/// A drive: TPDO 1 event-driven with timers, TPDO 2 with every SYNC, SYNC times, a heartbeat.
fn network() -> Network {
    let objects = vec![
        object(0x1000, 0, 7, 0x0002_0192),
        object(0x1006, 0, 7, 10_000),
        object(0x1007, 0, 7, 2_000),
        object(0x1017, 0, 6, 100),
        object(0x1800, 1, 7, 0x4000_0180),
        object(0x1800, 2, 5, 255),
        object(0x1800, 3, 6, 100),
        object(0x1800, 5, 6, 50),
        object(0x1A00, 0, 5, 3),
        object(0x1A00, 1, 7, 0x6041_0010),
        object(0x1A00, 2, 7, 0x606C_0020),
        object(0x1A00, 3, 7, 0x6077_0010),
        object(0x1801, 1, 7, 0x4000_0280),
        object(0x1801, 2, 5, 1),
        object(0x1A01, 0, 5, 1),
        object(0x1A01, 1, 7, 0x2000_010D),
        object(0x6041, 0, 6, 0),
        object(0x606C, 0, 4, 0),
        object(0x6077, 0, 3, 0),
    ];
    let dictionary = Arc::new(Dictionary::new("drive.eds".into(), Form::Eds, "drive".into(), objects));
    Network { descriptions: vec![Description { bus: None, node: 5, dictionary }], ..Network::default() }
}

fn frames(mut input: &[u8], stamped: bool) -> Vec<Frame> {
    let mut frames = Vec::new();
    let mut now = 1_000_000_000_i64;
    while let [high, low, time, length, rest @ ..] = input {
        let len = usize::from(length % 9).min(rest.len());
        let (data, after) = rest.split_at(len);
        input = after;
        let gap = GAPS_NS[usize::from(time & 7)];
        now = now.saturating_add(if time & 8 == 0 { gap } else { -gap });
        let word = u16::from_be_bytes([*high, *low]);
        let id = if high & 0x40 == 0 { CanId::standard(word & 0x7FF) } else { CanId::extended(u32::from(word)) };
        let mut frame = Frame::classic(id, data);
        frame.bus = BusId(time >> 7);
        frame.kind = match high >> 4 & 3 {
            1 => Kind::Remote,
            2 => Kind::Error,
            3 => Kind::Fd { brs: false, esi: false },
            _ => Kind::Data,
        };
        if stamped {
            frame.t_ns = Some(now);
            frame.stamp = Some(Stamp { form: StampForm::Seconds, ns: now, width: 1, decimals: 6 });
        }
        frames.push(frame);
    }
    frames
}

fn run(frames: &[Frame], options: Options) -> String {
    let mut session = Session::new(options);
    let mut out = Vec::new();
    for frame in frames {
        session.push(*frame, &mut out);
    }
    session.advance(i64::MAX, &mut out);
    session.finish(&mut out);
    String::from_utf8(out).expect("output is UTF-8")
}

fuzz_target!(|input: &[u8]| {
    let [choice, rest @ ..] = input else { return };
    let frames = frames(rest, choice & 1 == 0);
    let network = Arc::new(network());
    let expectations = (choice & 8 != 0).then(|| Arc::new(Expectations::read(EXPECTED).expect("they are well-formed")));
    let options = |format| Options {
        lang: if choice & 2 == 0 { Lang::Zh } else { Lang::En },
        depth: if choice & 4 == 0 { Depth::Default } else { Depth::Explain },
        format,
        network: Arc::clone(&network),
        expectations: expectations.clone(),
        ..Options::default()
    };
    let text = run(&frames, options(Format::Text));
    assert_eq!(text.lines().filter(|line| !line.starts_with('#')).count(), frames.len(), "a line for every frame");
    let mut counted = 0;
    for line in run(&frames, options(Format::Jsonl)).lines() {
        let row: Value = serde_json::from_str(line).expect("every line is an object");
        if row["kind"] == "frame" {
            counted += 1;
        }
        if row["kind"] == "finding" {
            assert!(row["frame"].is_u64(), "every finding names a frame");
        }
    }
    assert_eq!(counted, frames.len(), "an object for every frame");
    run(&frames, options(Format::SignalsCsv));
    for format in [Format::Summary, Format::Observed, Format::Check] {
        for line in run(&frames, options(format)).lines() {
            serde_json::from_str::<Value>(line).expect("every line is an object");
        }
    }
});

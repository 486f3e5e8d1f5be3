//! Any expectations with any frames: no input panics, every finding names a frame, and chunks make no difference.

use std::sync::Arc;

use proptest::prelude::*;

use super::{Expectations, findings};
use crate::bytes::frame::{CanId, Frame};
use crate::bytes::ns::Ns;
use crate::session::{Format, Knowledge, Options, Session};
use crate::words::Lang;

fn maybe(name: &'static str, value: impl Strategy<Value = String> + 'static) -> BoxedStrategy<String> {
    prop_oneof![Just(String::new()), value.prop_map(move |value| format!(",\"{name}\":{value}"))].boxed()
}

fn time() -> BoxedStrategy<String> {
    prop_oneof![Just(0_i64), Just(1), Just(10_000_000), Just(i64::MAX), 0..2_000_000_000_i64]
        .prop_map(|ns| ns.to_string())
        .boxed()
}

fn joined(parts: Vec<BoxedStrategy<String>>) -> BoxedStrategy<String> {
    parts.prop_map(|parts| parts.concat()).boxed()
}

fn word(words: &'static [&'static str]) -> BoxedStrategy<String> {
    proptest::sample::select(words).prop_map(|word| format!("\"{word}\"")).boxed()
}

fn json(words: &'static [&'static str]) -> BoxedStrategy<String> {
    proptest::sample::select(words).prop_map(str::to_owned).boxed()
}

const VALUES: &[&str] =
    &[r#"{"number":1000}"#, r#"{"number":0.5}"#, r#"{"text":"abc"}"#, r#"{"bool":true}"#, r#"{"data":"E803"}"#];
const DRIVES: &[&str] = &["fault", "operation-enabled", "switch-on-disabled"];

fn entry() -> BoxedStrategy<(&'static str, String)> {
    let bus = || maybe("bus", word(&["can0", "can1"]));
    let node = || json(&["5", "6", "127"]);
    let fixed = |text: &'static str| Just(text.to_owned()).boxed();
    let named = |name: &'static str, value: BoxedStrategy<String>| {
        value.prop_map(move |value| format!(",\"{name}\":{value}")).boxed()
    };
    let whole = || (1..2_000_000_000_i64).prop_map(|ns| ns.to_string()).boxed();
    prop_oneof![
        joined(vec![
            named("node", node()),
            bus(),
            named("index", json(&["4119", "4104", "24641"])),
            fixed(",\"sub\":0"),
            maybe("direction", word(&["upload", "download"])),
            maybe("value", json(VALUES)),
            maybe("outcome", word(&["ok", "aborted", "any"])),
            maybe("sequence", word(&["a", "b"])),
            maybe("count", json(&["0", "1", "3"])),
            maybe("within_ns", time()),
        ])
        .prop_map(|entry| ("sdo", entry)),
        joined(vec![
            named("node", node()),
            bus(),
            prop_oneof![named("state", word(&["boot-up", "operational", "stopped"])), named("drive", word(DRIVES)),]
                .boxed(),
            maybe("by_ns", time()),
            maybe("since", word(&["start", "boot-up"])),
            maybe("stays", json(&["true", "false"])),
        ])
        .prop_map(|entry| ("state", entry)),
        joined(vec![
            named("select", word(&["*", "5.*", "door", "6.TPDO1.x"])),
            bus(),
            maybe("min", json(&["-1.5", "-1e308"])),
            maybe("max", json(&["0", "3.25"])),
            prop_oneof![
                Just(String::new()),
                whole().prop_map(|ns| format!(",\"period_ns\":{ns},\"tolerance_ns\":{ns}"))
            ]
            .boxed(),
        ])
        .prop_map(|entry| ("signal", entry)),
        joined(vec![named("node", node()), bus(), named("period_ns", whole()), named("tolerance_ns", time())])
            .prop_map(|entry| ("heartbeat", entry)),
        joined(vec![bus(), named("period_ns", whole()), named("tolerance_ns", time())])
            .prop_map(|entry| ("sync", entry)),
        joined(vec![
            named("occurs", word(&["must", "may", "never"])),
            maybe("node", node()),
            maybe("code", json(&["[33024,65280]", "[0,65535]"])),
        ])
        .prop_map(|entry| ("emcy", entry)),
        joined(vec![named("of", word(&["sdo", "sync", "nmt"])), maybe("node", node()), named("max_ns", time())])
            .prop_map(|entry| ("latency", entry)),
        joined(vec![
            named("max_percent", json(&["0", "0.5", "60"])),
            maybe("bit_rate", json(&["10000", "1000000"])),
            maybe("window_ns", json(&["1000", "100000000", "9223372036854775807"])),
        ])
        .prop_map(|entry| ("load", entry)),
    ]
    .boxed()
}

const FRAMES: &[&str] = &[
    "605#2B171000E8030000",
    "585#6017100000000000",
    "605#4008100000000000",
    "585#4108100009000000",
    "605#6000000000000000",
    "585#0041424344454647",
    "605#7000000000000000",
    "585#1B48490000000000",
    "585#8017100002000106",
    "605#4041600000000000",
    "585#4B41600037020000",
    "705#00",
    "705#05",
    "705#7F",
    "705#R1",
    "705#85",
    "706#05",
    "000#0100",
    "000#8105",
    "000#8000",
    "080#",
    "185#37020300000001",
    "185#4002",
    "285#0A000000",
    "186#0102",
    "085#3081110000000000",
    "085#0000000000000000",
    "7E5#00",
    "123#R",
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, ..ProptestConfig::default() })]

    #[test]
    fn nothing_panics(
        entries in proptest::collection::vec(entry(), 1..8),
        frames in proptest::collection::vec(
            (proptest::sample::select(FRAMES), prop_oneof![Just(0_i64), 1..2000_i64, Just(-500), Just(9_000_000_000)], 0..3_u8),
            0..60,
        ),
        chunk in 1..200_usize,
    ) {
        let mut lists: std::collections::BTreeMap<&str, Vec<String>> = std::collections::BTreeMap::new();
        for ((kind, entry), line) in entries.iter().zip(1..) {
            lists.entry(kind).or_default().push(format!("{{\"line\":{line}{entry}}}"));
        }
        let lists: Vec<_> = lists.iter().map(|(kind, rows)| format!("\"{kind}\":[{}]", rows.join(","))).collect();
        let json = format!("{{\"file\":\"x.toml\",{}}}", lists.join(","));
        // Some of them contradict themselves.
        prop_assume!(Expectations::read(&json).is_ok());
        let (mut now, mut log) = (0_i64, String::new());
        for (frame, gap, bus) in &frames {
            now = now.saturating_add(*gap).max(0);
            let bus = if *bus == 0 { "can1" } else { "can0" };
            log.push_str(&format!("({}.{:03}000) {bus} {frame}\n", now / 1000, now % 1000));
        }
        log.push_str("(9999999999.000000) can0 DROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 3)\n");
        let whole = findings(&json, &log, Lang::Zh, usize::MAX);
        prop_assert_eq!(&findings(&json, &log, Lang::Zh, chunk), &whole);
        for row in &whole {
            prop_assert!(row["frame"].as_u64().is_some_and(|no| no >= 1 && no <= frames.len() as u64), "{}", row);
            prop_assert!(row["cause_frame"].as_u64().is_none_or(|no| no >= 1), "{}", row);
        }
    }
}

/// Expectations of every kind.
const EVERY: &str = r#"{"file":"x.toml",
    "sdo":[{"line":1,"node":5,"index":4119,"sub":0,"sequence":"a","within_ns":9223372036854775807}],
    "state":[{"line":4,"node":5,"state":"operational","by_ns":0,"since":"boot-up","stays":true}],
    "signal":[{"line":6,"select":"5.*","min":0,"period_ns":9223372036854775807,"tolerance_ns":9223372036854775807}],
    "heartbeat":[{"line":7,"node":5,"period_ns":1,"tolerance_ns":9223372036854775807}],
    "sync":[{"line":8,"period_ns":9223372036854775807,"tolerance_ns":0}],
    "latency":[{"line":11,"of":"sdo","max_ns":0},{"line":12,"of":"sync","max_ns":0},{"line":13,"of":"nmt","max_ns":0}],
    "load":[{"line":14,"max_percent":0,"bit_rate":1,"window_ns":1},{"line":15,"max_percent":0,"bit_rate":4294967295}]}"#;

proptest! {
    #[test]
    fn no_stamp_is_too_large(
        frames in proptest::collection::vec(
            (proptest::sample::select(FRAMES), prop_oneof![Just(i64::MIN), Just(i64::MAX), Just(0), any::<i64>()]),
            0..30,
        ),
    ) {
        for (_, format) in Format::NAMES.iter().filter(|(name, _)| ["jsonl", "observed"].contains(name)) {
            let known = Knowledge {
                network: Arc::new(super::network()),
                expectations: Some(Arc::new(Expectations::read(EVERY).unwrap())),
            };
            let mut session = Session::new(Options { known, ..Options::of(Lang::Zh, format.outputs) });
            let mut out = Vec::new();
            for (frame, now) in &frames {
                let (id, data) = frame.split_once('#').unwrap();
                let digits = data.as_bytes().chunks(2).filter_map(|pair| std::str::from_utf8(pair).ok());
                let bytes: Vec<u8> = digits.filter_map(|pair| u8::from_str_radix(pair, 16).ok()).collect();
                let mut frame = Frame::classic(CanId::standard(u16::from_str_radix(id, 16).unwrap()), &bytes);
                frame.t_ns = Some(Ns(*now));
                session.push(frame, &mut out);
            }
            session.advance(Ns::MAX, &mut out);
            session.finish(&mut out);
            for line in out.split(|byte| *byte == b'\n').filter(|line| !line.is_empty()) {
                prop_assert!(serde_json::from_slice::<serde_json::Value>(line).is_ok());
            }
        }
    }
}

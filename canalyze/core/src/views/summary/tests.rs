//! Figures of small captures, through a whole session.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]

use std::sync::Arc;

use serde_json::Value;

use crate::session::{Options, Output, Rows, Session};
use crate::words::Lang;
use crate::world::network::Network;

/// Returns the records of a capture in `candump -l` form.
fn records(text: &str, bit_rate: Option<u32>) -> Vec<Value> {
    let network = Arc::new(Network { bit_rate, ..Network::default() });
    let mut options = Options::of(Lang::En, &[Output::json(Rows::Summary)]);
    options.known.network = network;
    let mut session = Session::new(options);
    let mut out = Vec::new();
    session.begin(b"capture.log", crate::bytes::readers::InputFormat::Candump, true);
    session.feed(text.as_bytes(), &mut out);
    session.finish(&mut out);
    String::from_utf8(out).unwrap().lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

fn of<'a>(records: &'a [Value], kind: &str) -> Vec<&'a Value> {
    records.iter().filter(|record| record["kind"] == kind).collect()
}

/// Formats frames with their time in ms, as `ID#DATA`.
fn log(frames: &[(u64, &str)]) -> String {
    frames.iter().map(|(ms, frame)| format!("({}.{:06}) can0 {frame}\n", 100 + ms / 1000, ms % 1000 * 1000)).collect()
}

#[test]
fn states_come_from_error_control_and_else_from_commands() {
    let found = records(
        &log(&[
            (0, "705#00"),
            (1, "000#0105"),
            (2, "705#7F"),
            (3, "705#05"),
            (100, "000#0100"),
            (101, "186#00"),
            (102, "000#8006"),
        ]),
        None,
    );
    let nodes = of(&found, "summary_node");
    let states = |node: &Value| -> Vec<(String, u64, bool)> {
        let change = |state: &Value| {
            let commanded = state["commanded"].as_bool().unwrap();
            (state["state"].as_str().unwrap().to_owned(), state["frame"].as_u64().unwrap(), commanded)
        };
        node["states"].as_array().unwrap().iter().map(change).collect()
    };
    let state = |state: &str, frame, commanded| (state.to_owned(), frame, commanded);
    assert_eq!(states(nodes[0]), [state("00", 1, false), state("7F", 3, false), state("05", 4, false)]);
    assert_eq!(states(nodes[1]), [state("05", 5, true), state("7F", 7, true)]);
    assert_eq!(
        (&nodes[0]["boot_ups"], &nodes[0]["heartbeats"], &nodes[0]["heartbeat"]["count"]),
        (&1.into(), &2.into(), &1.into())
    );
    assert_eq!(nodes[1]["error_control"], Value::Null);
    assert_eq!(nodes[0]["error_control"], "heartbeat");
}

#[test]
fn responses_are_timed_where_they_can_be() {
    let read = [(0, "605#4000200000000000"), (3, "585#4F00200001000000")];
    // The second request's echo comes after its response.
    let late = [(10, "585#4F00200101000000"), (11, "605#4000200100000000")];
    // Refused by the server after 8 ms; then the client gives up a request of its own.
    let aborts = [(20, "605#4000200200000000"), (28, "585#8000200200000206"), (40, "605#4000200300000000")];
    let given_up = [(60, "605#8000200300000405")];
    let frames: Vec<_> = [&read[..], &late, &aborts, &given_up].concat();
    let found = records(&log(&frames), None);
    let node = of(&found, "summary_node")[0];
    let response = &node["response"];
    assert_eq!(response["count"], 2, "{node}");
    assert_eq!(
        (&response["min_us"], &response["max_us"], &response["p99_us"]),
        (&3000.into(), &8000.into(), &8000.into())
    );
    assert_eq!(node["sdo"], serde_json::json!({"transfers": 4, "ok": 2, "aborted": 2, "failed": 0, "incomplete": 0}));
    let by: Vec<_> = node["aborts"].as_array().unwrap().iter().map(|abort| abort["by"].as_str().unwrap()).collect();
    assert_eq!(by, ["server", "client"]);
    assert_eq!(of(&found, "summary_capture")[0]["reordered"], 1);
}

#[test]
fn sync_and_pdos_without_what_was_lost() {
    let found = records(
        "(1.000) can0 080#01\n(1.010) can0 080#02\n(1.015) can0 185#00\n(1.020) can0 080#03\n\
         can0  2 frames dropped\n(1.090) can0 080#0A\n(1.100) can0 080#01\n(1.110) can0 080#05\n(1.200) can0 185#00\n",
        None,
    );
    let sync = of(&found, "summary_sync")[0];
    assert_eq!(sync["frames"], 6);
    let period = &sync["period"];
    assert_eq!(sync["counter_max"], 10);
    assert!(period["count"].as_u64().unwrap() >= 4);
    let pdo = of(&found, "summary_pdo")[0];
    assert_eq!((&pdo["pdo"], &pdo["id"], &pdo["frames"]), (&"TPDO1".into(), &"185".into(), &2.into()));
}

#[test]
fn no_stamps_no_times() {
    let found = records("can0 080#\ncan0 705#05\ncan0 185#0011\ncan0 705#05\ncan0 185#0011\n", Some(500_000));
    let (capture, bus) = (of(&found, "summary_capture")[0], of(&found, "summary_bus")[0]);
    assert_eq!((&capture["frames"], &capture["unstamped"], &capture["seconds"]), (&5.into(), &5.into(), &Value::Null));
    for key in ["rate", "peak_rate_1s", "peak_rate_100ms", "load", "load_peak_1s", "load_peak_100ms", "burst"] {
        assert_eq!(bus[key], Value::Null, "{key}");
    }
    assert!(bus["bits"].as_u64().unwrap() > 250);
    assert_eq!(of(&found, "summary_node")[0]["heartbeats"], 2);
    assert_eq!(of(&found, "summary_node")[0]["heartbeat"], Value::Null);
    assert_eq!(of(&found, "summary_pdo")[0]["frames"], 2);
}

#[test]
fn load_of_a_steady_bus() {
    // 1001 SYNCs, one a millisecond: 47 bits and its stuff bits each.
    let frames: Vec<_> = (0..=1000).map(|ms| (ms, "080#")).collect();
    let found = records(&log(&frames), Some(125_000));
    let bus = of(&found, "summary_bus")[0];
    let bits = crate::views::summary::bits::on_the_wire(&crate::bytes::frame::Frame::classic(
        crate::bytes::frame::CanId::standard(0x80),
        &[],
    ));
    assert_eq!(bus["bits"], u64::from(bits) * 1001);
    assert_eq!(bus["rate"], 1000);
    let load = f64::from(bits) * 1000.0 / 125_000.0 * 100.0;
    assert!((bus["load"].as_f64().unwrap() - load).abs() < 0.001);
    assert!((bus["load_peak_1s"].as_f64().unwrap() - load).abs() < 0.001);
    assert_eq!(of(&found, "summary_sync")[0]["period"]["sigma_us"], 0);
}

#[test]
fn stamps_that_step_back() {
    let found =
        records("(10.0) can0 080#\n(10.5) can0 080#\n(10.4) can0 080#\n(3.0) can0 080#\n(4.0) can0 080#\n", None);
    let capture = of(&found, "summary_capture")[0];
    assert_eq!((&capture["backward"], &capture["backward_most_us"]), (&2.into(), &7_400_000.into()));
    assert_eq!(capture["seconds"], "1.5");
    assert_eq!((&capture["pause_us"], &capture["pause_frame"]), (&1_000_000.into(), &5.into()));
}

#[test]
fn every_rule_is_counted_whole() {
    let one = [(0, "605#4000200000000000"), (1, "585#4F00200001000000")];
    let mut frames = one.to_vec();
    frames.extend((1..=30).flat_map(|no| [(no * 10, "605#4000200000000000"), (no * 10 + 1, "585#8000200000000206")]));
    let found = records(&log(&frames), None);
    let aborted = of(&found, "summary_finding").into_iter().find(|one| one["code"] == "SDO017").unwrap();
    assert_eq!(
        (&aborted["count"], &aborted["first_frame"], &aborted["last_frame"]),
        (&30.into(), &4.into(), &62.into())
    );
    assert_eq!((&aborted["nodes"], &aborted["buses"]), (&serde_json::json!([5]), &serde_json::json!(["can0"])));
}

//! Problems that are expected, and those that are not.

use super::{capture, check, findings};
use crate::words::Lang;

/// Heartbeats of node 5 every 100 ms except for a silence, and of node 6 all the time.
fn silent(from: u64, until: u64) -> String {
    let beats = (0..60).flat_map(|beat| {
        let five = (!(from..until).contains(&beat)).then(|| format!("{}.{}01 705#05", beat / 10, beat % 10));
        five.into_iter().chain([format!("{}.{}02 706#05", beat / 10, beat % 10)])
    });
    beats.collect::<Vec<_>>().join(";")
}

#[test]
fn what_must_and_must_not_occur() {
    let (lost, back, well) = (silent(20, 60), silent(20, 30), silent(60, 60));
    let must = r#""kind":"node-silent","node":5,"occurs":[1,1]"#;
    check("problem", &[must], &lost, &[]);
    check("problem", &[must], &well, &[("EXP017", 120, 0, 1)]);
    check("problem", &[r#""kind":"node-silent","occurs":[2,null]"#], &back, &[("EXP017", 110, 0, 1)]);
    check("problem", &[r#""kind":"node-*","occurs":[0,0]"#], &back, &[("EXP018", 110, 39, 1)]);
    check("problem", &[r#""kind":"node-silent","occurs":[0,0],"node":6"#], &lost, &[]);
    check("problem", &[r#""kind":"bus-*","occurs":[0,0]"#], &lost, &[]);
}

#[test]
fn what_is_listed_may_occur_and_nothing_else() {
    let may = r#""kind":"node-silent","node":5,"occurs":[0,null]"#;
    let none = r#""occurs":[0,0]"#;
    check("problem", &[none], &silent(20, 60), &[("EXP018", 80, 39, 1)]);
    check("problem", &[may, none], &silent(20, 60), &[]);
    check("problem", &[r#""kind":"node-silent","ends_within_ns":2000000000"#, none], &silent(20, 30), &[]);
    let strict = r#""kind":"node-silent","node":5,"bus":"can0","occurs":[0,0]"#;
    check("problem", &[may, strict], &silent(20, 60), &[("EXP018", 80, 39, 2)]);
}

#[test]
fn each_is_over_in_time() {
    let within = |ns: i64| format!(r#""kind":"node-silent","ends_within_ns":{ns}"#);
    check("problem", &[&within(1_200_000_000)], &silent(20, 30), &[]);
    check("problem", &[&within(1_000_000_000)], &silent(20, 30), &[("EXP019", 110, 39, 1)]);
    check("problem", &[&within(1_000_000_000)], &silent(20, 60), &[("EXP019", 80, 39, 1)]);
    check("problem", &[&within(60_000_000_000)], &silent(20, 60), &[("EXP015", 80, 39, 1)]);
}

#[test]
fn what_was_found_instead_is_said() {
    let json = r#"{"file":"x.toml","problem":[{"line":1,"kind":"node-restarted","node":6,"occurs":[1,1]}]}"#;
    let rows = findings(json, &capture(&silent(20, 60)), Lang::En, 100);
    let message = "node 6: no \"node-restarted\"; found instead: node 5 node-silent (frame 39) (expected by x.toml:1)";
    assert_eq!(rows[0]["message"], message);
    let found = serde_json::json!([{"problem": "node-silent", "node": 5, "frame": 39}]);
    assert_eq!(rows[0]["facts"]["found"], found);
    let rows = findings(json, &capture(&silent(20, 60)), Lang::Zh, 100);
    let message =
        "节点6: 没有出现\"node-restarted\"; 实际出现: 节点5 node-silent 节点失去联系 (第39帧) (期望: x.toml:1)";
    assert_eq!(rows[0]["message"], message);
}

#[test]
fn where_it_comes_from() {
    // Node 6 watches node 5 (1016h) and reports its loss.
    let configured = "0 606#2316100196000500;0.001 586#6016100100000000";
    let capture = format!("{configured};{};2.2 086#3081110000000000;2.25 706#05", silent(20, 20));
    let before: Vec<_> = capture.split(';').filter(|frame| !frame.contains("705#05") || !late(frame)).collect();
    let capture = sorted(before);
    let from = |cause: &str| format!(r#""kind":"heartbeat-consumer-error","cause":"{cause}""#);
    check("problem", &[&from("node-silent")], &capture, &[]);
    let at = capture.split(';').position(|frame| frame.contains("086#")).unwrap() as u64 + 1;
    let last = capture.split(';').count() as u64;
    check("problem", &[&from("bus-off")], &capture, &[("EXP020", last, at, 1)]);
}

/// Returns true if a frame comes later than 2 s.
fn late(frame: &str) -> bool {
    frame.split(' ').next().and_then(|seconds| seconds.parse::<f64>().ok()).is_some_and(|seconds| seconds > 2.05)
}

fn sorted(mut frames: Vec<&str>) -> String {
    let seconds = |frame: &&str| frame.split(' ').next().and_then(|word| word.parse::<f64>().ok()).unwrap_or_default();
    frames.sort_by(|one, other| seconds(one).total_cmp(&seconds(other)));
    frames.join(";")
}

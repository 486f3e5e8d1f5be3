//! Error frames: one finding per disturbance, at the first frame of its worst condition, with linked consequences.

use super::{lines, log, raised, without_stamps};
use crate::world::network::Network;

/// Code, frame, severity, explaining frame, and number of counted error frames.
type Row = (String, u64, String, Option<u64>, Option<u64>);

fn findings(text: &str) -> Vec<Row> {
    let lines = lines(text, Network::default());
    let found = lines.iter().filter(|line| line["kind"] == "finding");
    found
        .map(|line| {
            let text = |key: &str| line[key].as_str().unwrap().to_owned();
            (
                text("code"),
                line["frame"].as_u64().unwrap_or(0),
                text("severity"),
                line["because_of"].as_u64(),
                line["facts"]["count"].as_u64(),
            )
        })
        .collect()
}

fn short(text: &str) -> Vec<(String, u64, Option<u64>)> {
    findings(text).into_iter().map(|(code, frame, _, because, _)| (code, frame, because)).collect()
}

fn one(code: &str, frame: u64, because: Option<u64>) -> (String, u64, Option<u64>) {
    (code.into(), frame, because)
}

const NO_ACK: &str = "20000020#0000000000000000";
const WARNING: &str = "20000004#0008000000000000";
const PASSIVE: &str = "20000004#0020000000000000";
const ACTIVE: &str = "20000004#0040000000000000";
const BUS_OFF: &str = "20000040#0000000000000000";
const RESTARTED: &str = "20000100#0000000000000000";
const BUS_ERROR: &str = "20000088#0000040A00000000";
const ARBITRATION: &str = "20000002#0C00000000000000";
const OVERFLOW: &str = "20000004#0001000000000000";

/// Heartbeats every 100 ms beside these frames, `ms FRAME`.
fn amid(frames: &[(f64, &str)], until_ms: u32) -> String {
    let beats = (0..until_ms / 100).map(|no| (f64::from(no) * 100.0, "705#05"));
    let mut all: Vec<(f64, &str)> = beats.chain(frames.iter().copied()).collect();
    all.sort_by(|left, right| left.0.total_cmp(&right.0));
    log(&all.iter().map(|(ms, frame)| format!("{ms} {frame}\n")).collect::<String>())
}

#[test]
fn each_kind_by_itself() {
    for (frame, code, severity) in [
        (BUS_OFF, "BUS001", "error"),
        (PASSIVE, "BUS002", "warning"),
        // At least 12 transmissions, or 96 frames, were faulty by then: as many bus errors, where those are not
        // recorded.
        (WARNING, "BUS003", "warning"),
        (NO_ACK, "BUS004", "warning"),
        (OVERFLOW, "BUS005", "warning"),
        (ACTIVE, "BUS006", "info"),
        // It had been off the bus.
        (RESTARTED, "BUS001", "error"),
        (BUS_ERROR, "BUS007", "warning"),
        ("20000000#", "BUS007", "warning"),
        ("20000010#0000000004000000", "BUS008", "warning"),
    ] {
        // At the beginning, in the middle, and as the last frame.
        for (ms, at) in [(1.0, 2), (1005.0, 12), (2995.0, 31)] {
            let found = findings(&amid(&[(ms, frame)], 3000));
            let found: Vec<_> = found.iter().map(|one| (one.0.as_str(), one.1, one.2.as_str(), one.3)).collect();
            assert_eq!(found, [(code, at, severity, None)], "{frame} at {ms}");
        }
    }
    assert_eq!(findings(&amid(&[(1005.0, ARBITRATION)], 3000)), []);
}

#[test]
fn a_disturbance_is_one_finding_at_its_worst() {
    let mut frames: Vec<(f64, &str)> = (0..16).map(|no| (1001.0 + f64::from(no), NO_ACK)).collect();
    frames.extend([(1018.0, WARNING), (1019.0, PASSIVE), (1030.0, BUS_OFF)]);
    let text = amid(&frames, 5000);
    let found = short(&text);
    let root = 30;
    let expected = [
        one("BUS001", root, None),
        one("BUS003", 28, Some(root)),
        one("BUS004", 12, Some(root)),
        one("BUS002", 29, Some(root)),
    ];
    assert_eq!(found, expected);
    assert_eq!(findings(&text)[0].4, Some(19));
    assert_eq!(raised(&text).len(), 1);
    // The same without stamps.
    assert_eq!(short(&without_stamps(&text)), expected);
}

#[test]
fn a_burst_is_counted_and_two_bursts_are_two() {
    for count in [1_u32, 2, 10, 500] {
        let burst = |from: f64| (0..count).map(move |no| (from + f64::from(no) * 0.5, BUS_ERROR));
        let frames: Vec<(f64, &str)> = burst(1000.1).chain(burst(3000.1)).collect();
        let found = findings(&amid(&frames, 6000));
        assert_eq!(found.len(), 2, "{count}: {found:?}");
        assert!(found.iter().all(|one| one.4 == Some(count.into())), "{found:?}");
    }
}

#[test]
fn one_that_goes_on_is_told_and_its_count_when_it_is_over() {
    let frames: Vec<(f64, &str)> = (0..50).map(|no| (1001.0 + 100.0 * f64::from(no), NO_ACK)).collect();
    let found = findings(&amid(&frames, 9000));
    let codes: Vec<_> = found.iter().map(|one| (one.0.as_str(), one.2.as_str(), one.3)).collect();
    assert_eq!(codes, [("BUS004", "warning", None), ("BUS004", "info", Some(12))]);
    assert_eq!((found[0].4, found[1].4), (Some(10), Some(50)));
    // A worse condition is found: bus-off by itself, error passive as a part of it.
    let worse = |frame: &'static str| {
        let mut frames = frames.clone();
        frames.push((5955.0, frame));
        findings(&amid(&frames, 9000)).into_iter().filter(|one| one.2 != "info").map(|one| one.0).collect::<Vec<_>>()
    };
    assert_eq!(worse(BUS_OFF), ["BUS004", "BUS001"]);
    assert_eq!(worse(PASSIVE), ["BUS004"]);
}

#[test]
fn a_state_is_entered_once_until_it_is_left() {
    let text = amid(&[(1001.0, PASSIVE), (4001.0, PASSIVE), (7001.0, ACTIVE), (10_001.0, PASSIVE)], 13_000);
    let expected =
        [one("BUS002", 12, None), one("BUS002", 43, Some(12)), one("BUS006", 74, Some(12)), one("BUS002", 105, None)];
    assert_eq!(short(&text), expected);
    // Bus-off cannot be entered twice without being left.
    let text = amid(&[(1001.0, BUS_OFF), (4001.0, BUS_OFF)], 7000);
    assert_eq!(raised(&text).len(), 2);
    let text = amid(&[(1001.0, BUS_OFF), (1101.0, RESTARTED), (1201.0, BUS_OFF), (1301.0, RESTARTED)], 4000);
    assert_eq!(short(&text), [one("BUS001", 12, None), one("BUS006", 18, Some(12))]);
}

#[test]
fn a_deaf_controller_accuses_nobody() {
    // No heartbeat for a second while it is off the bus, or while its buffer overflows.
    for frame in [BUS_OFF, OVERFLOW] {
        let text = amid(&[(1950.0, frame)], 2000);
        let after: String = (0..20).map(|no| format!("{} 705#05\n", 3000 + 100 * no)).collect();
        let found = raised(&(text + &log(&after)));
        assert_eq!(found.len(), 1, "{found:?}");
    }
}

#[test]
fn a_switch_of_the_bit_rate_explains_them() {
    let frames = [(1001.0, "7E5#15E8030000000000"), (1500.0, BUS_ERROR), (1600.0, BUS_ERROR)];
    let found = short(&amid(&frames, 1000));
    assert!(found.contains(&one("BUS007", 12, Some(11))), "{found:?}");
}

#[test]
fn a_marker_without_content_counts_too() {
    for count in [1, 3] {
        let text = format!("  can0  705   [1]  05\n{}  can0  705   [1]  05\n", "  can0  ERROR\n".repeat(count));
        let found = findings(&text);
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!((found[0].0.as_str(), found[0].4), ("BUS007", Some(count as u64)));
    }
}

#[test]
fn a_marker_stands_behind_a_frame_of_its_own_bus() {
    let text = "  can0  705   [1]  05\n  can1  706   [1]  05\n  can0  ERROR\n  can0  705   [1]  05\n";
    assert_eq!(short(text), [one("BUS007", 1, None)]);
    let text = "  can1  706   [1]  05\n  can0  ERROR\n  can0  705   [1]  05\n";
    assert_eq!(short(text), [one("BUS007", 0, None)], "no frame of its bus is known by then");
    let text = "  can1  706   [1]  05\n  can0  705   [1]  05\n  can0  ERROR\n";
    assert_eq!(short(text), [one("BUS007", 2, None)]);
}

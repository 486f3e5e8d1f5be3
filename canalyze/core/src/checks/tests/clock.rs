//! Stamps that go back: one finding per step of more than 10 ms, at the frame after it, for each bus. Stamps that jump
//! forward, or missing frames: one finding if several senders show it.

use super::{Raised, log, raised};

fn beats(from_ms: f64, count: u32) -> String {
    (0..count).map(|no| format!("{} 705#05\n", from_ms + 100.0 * f64::from(no))).collect()
}

#[test]
fn each_step_back_is_found_once() {
    for back_ms in [10.001, 30.0, 5_000.0, 3_600_000.0] {
        for before in [1, 10, 29] {
            let last = 4_000_000.0 + 100.0 * f64::from(before - 1);
            let text = log(&(beats(4_000_000.0, before) + &beats(last - back_ms, 30 - before)));
            let steps: Vec<Raised> = raised(&text).into_iter().filter(|one| one.0 == "CAP006").collect();
            let at = u64::from(before);
            assert_eq!(steps, [("CAP006".into(), at + 1, Some(at))], "{back_ms} after {before}");
        }
    }
    let none = |text: &str| assert!(raised(text).iter().all(|one| one.0 != "CAP006"), "{text}");
    for back_ms in [0.001, 3.0, 9.999, 10.0] {
        none(&log(&format!("{}{}", beats(1000.0, 10), beats(1900.0 - back_ms, 10))));
    }
    // A forward step looks like a pause.
    none(&log(&format!("{}{}", beats(1000.0, 10), beats(1_000_000.0, 10))));
    // Two buses, each on its own.
    let other = log(&beats(500.0, 10)).replace("can0", "can1");
    none(&(log(&beats(1000.0, 10)) + &other));
}

/// Heartbeats of two nodes every 100 ms for `ms`; those within a range are left out, those after it are late.
fn two(ms: u32, without: std::ops::Range<u32>, by: u32) -> String {
    let at = (0..ms / 50).map(|no| (no * 50, 5 + no % 2)).filter(|(at, _)| !without.contains(at));
    at.map(|(at, node)| format!("{}.137 70{node}#05\n", at + if at < without.end { 0 } else { by })).collect()
}

#[test]
fn a_hole_is_found_once_and_nothing_beside_it() {
    for (without, by) in
        [(1000..1300, 0), (1000..5000, 0), (1000..1000, 30), (1000..1000, 7_777), (1000..1000, 3_600_000)]
    {
        let found = raised(&log(&two(without.end + 1_000, without.clone(), by)));
        assert_eq!(found, [("CAP007".into(), 21, Some(20))], "{without:?} {by}");
    }
    assert_eq!(raised(&log(&two(3_000, 0..0, 0))), []);
}

#[test]
fn all_senders_late_together_once_are_no_hole() {
    // One host sends for all nodes and paused: after that each is on time again.
    for apart_us in [200, 1_500, 3_000, 10_000] {
        for late_us in [500, 2_000, 5_000, 20_000] {
            let at = |no: u32, node: u32| {
                no * 250_000 + node * apart_us + if no % 20 == 19 && no < 100 { late_us } else { 0 }
            };
            let beats = (0..120_u32).flat_map(|no| (0..4).map(move |node| (at(no, node), 5 + node)));
            let text: String = beats.map(|(at, node)| format!("{} 70{node}#05\n", f64::from(at) / 1000.0)).collect();
            assert_eq!(raised(&log(&text)), [], "{late_us} of nodes {apart_us} apart");
        }
    }
}

#[test]
fn a_node_that_stops_is_found_beside_others_in_step_with_it() {
    // On a virtual bus, and from adapters that deliver several frames at once, frames are closer than on a wire.
    for apart_us in [1, 5, 10, 20, 40, 52, 60, 100, 500, 1_400, 1_600, 5_000] {
        for (nodes, before) in [(2, 8), (2, 20), (3, 12), (8, 30)] {
            let goes_on = |no: u32, node: u32| node > 0 || no < before;
            let beats = (0..before + 12).flat_map(|no| (0..nodes).map(move |node| (no, node)));
            let beats = beats.filter(|(no, node)| goes_on(*no, *node));
            let line = |(no, node): (u32, u32)| {
                format!("{} 70{}#05\n", f64::from(no * 250_000 + node * apart_us + 137) / 1000.0, 1 + node)
            };
            let text: String = beats.map(line).collect();
            let found: Vec<String> = raised(&log(&text)).into_iter().map(|one| one.0).collect();
            assert_eq!(found, ["HBT002"], "{nodes} nodes, {apart_us} µs apart, {before} before");
        }
    }
}

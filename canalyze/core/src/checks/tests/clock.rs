//! Stamps that go back: one finding for each step of 10 ms or more, at the frame after it, on each bus by itself. Stamps
//! that go forth, or frames of some time that are not there: one finding, where several senders show it.

use super::{Raised, log, raised};

fn beats(from_ms: f64, count: u32) -> String {
    (0..count).map(|no| format!("{} 705#05\n", from_ms + 100.0 * f64::from(no))).collect()
}

#[test]
fn each_step_back_is_found_once() {
    for back_ms in [10.0, 30.0, 5_000.0, 3_600_000.0] {
        for before in [1, 10, 29] {
            let last = 4_000_000.0 + 100.0 * f64::from(before - 1);
            let text = log(&(beats(4_000_000.0, before) + &beats(last - back_ms, 30 - before)));
            let steps: Vec<Raised> = raised(&text).into_iter().filter(|one| one.0 == "CAP006").collect();
            let at = u64::from(before);
            assert_eq!(steps, [("CAP006".into(), at + 1, Some(at))], "{back_ms} after {before}");
        }
    }
    let none = |text: &str| assert!(raised(text).iter().all(|one| one.0 != "CAP006"), "{text}");
    for back_ms in [0.001, 3.0, 9.999] {
        none(&log(&format!("{}{}", beats(1000.0, 10), beats(1900.0 - back_ms, 10))));
    }
    // Forward, it cannot be told from a pause.
    none(&log(&format!("{}{}", beats(1000.0, 10), beats(1_000_000.0, 10))));
    // Two buses, each on its own.
    let other = log(&beats(500.0, 10)).replace("can0", "can1");
    none(&(log(&beats(1000.0, 10)) + &other));
}

/// Heartbeats of two nodes every 100 ms, for some time in ms; those within a range are left out, those behind it are late.
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

//! SRDO: findings that no capture of correct pairs may raise, and the limits of those that must be raised.

use proptest::prelude::*;

use super::{lines, log, raised, without_stamps};
use crate::world::network::Network;

/// Node 5 sends SRDO5: 20 ms, validated within 5 ms.
const KNOWN: &str = "
    0 605#2F01130101000000\n0.2 585#6001130100000000
    1 605#2B01130214000000\n1.2 585#6001130200000000
    2 605#2F01130305000000\n2.2 585#6001130300000000
";

fn normal(ms: f64, value: u8) -> String {
    format!("{ms} 109#{value:02X}55\n")
}

fn inverted(ms: f64, value: u8) -> String {
    format!("{ms} 10A#{:02X}AA\n", !value)
}

/// Pairs every 20 ms whose data change with every `constant`th one.
fn pairs(from_ms: f64, count: u8, constant: u8) -> String {
    let pair = |no: u8| {
        let ms = from_ms + 20.0 * f64::from(no);
        normal(ms, no / constant) + &inverted(ms + 1.0, no / constant)
    };
    (0..count).map(pair).collect()
}

fn codes(log: &str) -> Vec<String> {
    raised(log).into_iter().map(|(code, _, _)| code).collect()
}

#[test]
fn identifiers_that_carry_something_else() {
    let other: String =
        (0..50).map(|no| format!("{} 109#{no:02X}\n{} 10A#{no:02X}77\n", no * 10, no * 10 + 3)).collect();
    assert_eq!(raised(&log(&other)), []);
    let said = lines(&log(&other), Network::default());
    assert!(said.iter().filter(|line| line["service"] == "srdo").all(|line| line["srdo"]["valid"].is_null()));
    // One byte that happens to be the inverse once.
    assert_eq!(raised(&log("0 109#FF\n1 10A#00\n2 109#FF\n3 10A#01\n")), []);
    // Two right pairs prove it, and so does the record.
    assert_eq!(codes(&log("0 109#01\n1 10A#FE\n2 109#02\n3 10A#FD\n4 109#03\n5 10A#FD\n")), ["SRD001"]);
    assert_eq!(codes(&log(&(KNOWN.to_owned() + "4 109#03\n5 10A#FC\n6 109#03\n7 10A#FD\n"))), ["SRD001"]);
    // Never right at all: the first wrong one may have been cut by the capture's edge.
    let wrong = "4 109#03\n5 10A#FD\n6 109#04\n7 10A#04\n8 109#04\n9 10A#04\n";
    assert_eq!(codes(&log(&(KNOWN.to_owned() + wrong))), ["SRD001", "SRD001"]);
    // Unless it was started after that.
    assert_eq!(codes(&log(&(KNOWN.to_owned() + "3 000#0105\n" + wrong))), ["SRD001", "SRD001", "SRD001"]);
    // The inverted frame first: once may be an echo, but not if it is much earlier.
    let early = |by: f64| {
        let sound = KNOWN.to_owned() + &pairs(10.0, 4, 1) + &pairs(110.0, 3, 1);
        log(&(sound + &inverted(91.0 - by, 9) + &normal(90.0, 9)))
    };
    let sorted = |text: String| {
        let mut lines: Vec<&str> = text.lines().collect();
        lines.sort_unstable();
        lines.join("\n") + "\n"
    };
    assert_eq!(raised(&sorted(early(2.0))), []);
    assert_eq!(raised(&sorted(early(15.0))).iter().map(|one| one.0.as_str()).collect::<Vec<_>>(), ["SRD004"]);
}

#[test]
fn gaps_that_are_none_of_the_producers() {
    let after = pairs(1000.0, 5, 1);
    let with = |between: &str| KNOWN.to_owned() + &pairs(10.0, 5, 1) + between + &after;
    assert_eq!(codes(&log(&with(""))), ["SRD003"]);
    for between in ["500 000#0205\n990 000#0105\n", "500 705#00\n", "500 000#8200\n"] {
        let written = with(between);
        assert!(!codes(&log(&written)).contains(&"SRD003".to_owned()), "{between}");
    }
    let text = log(&with(""));
    let bare = without_stamps(&text);
    assert_eq!(codes(&bare), Vec::<String>::new());
    // Without configuration no time is judged.
    assert_eq!(codes(&log(&(pairs(10.0, 5, 1) + &after))), Vec::<String>::new());
    // Jitter.
    let jitter: String = (0..40_u8)
        .map(|no| {
            let ms = 10.0 + 20.0 * f64::from(no) + f64::from(no % 3) * 0.9;
            normal(ms, no) + &inverted(ms + 5.9, no)
        })
        .collect();
    assert_eq!(codes(&log(&(KNOWN.to_owned() + &jitter))), Vec::<String>::new());
}

#[test]
fn a_receivers_limits_count_before_the_producers() {
    // Node 6 receives the pair 109h/10Ah and waits 50 ms.
    let receiver = "
        3 606#2F01130102000000\n3.2 586#6001130100000000
        4 606#2B01130232000000\n4.2 586#6001130200000000
        5 606#2301130509010000\n5.2 586#6001130500000000
        6 606#230113060A010000\n6.2 586#6001130600000000
    ";
    let slow = KNOWN.to_owned() + receiver + &pairs(10.0, 3, 1) + &pairs(90.0, 3, 1);
    assert_eq!(codes(&log(&slow)), Vec::<String>::new());
    assert_eq!(codes(&log(&(slow + &pairs(250.0, 3, 1)))), ["SRD003"]);
}

#[test]
fn a_producer_that_starts_by_itself() {
    let started = KNOWN.to_owned() + "5 705#7F\n" + &pairs(10.0, 20, 1) + "500 705#05\n" + &pairs(520.0, 3, 1);
    assert!(!codes(&log(&started)).contains(&"SRD005".to_owned()));
    let stopped = KNOWN.to_owned() + "5 705#7F\n" + &pairs(10.0, 3, 1) + "69 705#7F\n" + &pairs(70.0, 3, 1);
    assert_eq!(codes(&log(&stopped)), ["SRD005", "SRD005", "SRD005"]);
}

#[test]
fn pairs_on_other_identifiers() {
    // 111h with 120h, halves of two pairs.
    let configured = "
        0 605#2F01130101000000\n0.2 585#6001130100000000
        1 605#2301130511010000\n1.2 585#6001130500000000
        2 605#2301130620010000\n2.2 585#6001130600000000
    ";
    let said =
        lines(&log(&(configured.to_owned() + "10 111#01\n11 120#FE\n30 111#02\n31 120#FF\n")), Network::default());
    let valid: Vec<_> =
        said.iter().filter(|line| line["service"] == "srdo").map(|line| &line["srdo"]["valid"]).collect();
    assert_eq!(valid, [&serde_json::Value::Null, &true.into(), &serde_json::Value::Null, &false.into()]);
}

#[test]
fn two_buses_are_two_networks() {
    let text = log(&(KNOWN.to_owned() + &pairs(10.0, 3, 1)));
    let other = log(&pairs(10.5, 3, 1).replace("109#", "109#01")).replace("can0", "can1");
    let mut lines: Vec<&str> = text.lines().chain(other.lines()).collect();
    lines.sort_unstable();
    assert_eq!(codes(&(lines.join("\n") + "\n")), Vec::<String>::new());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, ..ProptestConfig::default() })]
    /// Correct pairs, cut anywhere, one frame in eight late by one.
    #[test]
    fn never_wrong_on_what_a_capture_does(
        (start, end, constant) in (0..40_usize, 0..40_usize, 1..5_u8),
        late in 0..80_usize,
        known: bool,
    ) {
        let sound = pairs(10.0, 40, constant);
        let mut lines: Vec<&str> = sound.lines().collect();
        lines.swap(late.min(78), late.min(78) + 1);
        let cut = lines[start..lines.len() - end].join("\n");
        let known = if known { KNOWN } else { "" };
        let text = log(&(known.to_owned() + "\n" + &cut));
        // The stamps of swapped frames belong to their places.
        let said: Vec<_> = codes(&text).into_iter().filter(|code| code.starts_with("SRD") && code != "SRD003" && code != "SRD002").collect();
        prop_assert_eq!(said, Vec::<String>::new());
    }
}

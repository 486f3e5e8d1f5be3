//! Emergencies: each error is found once, counted while active, and removed by the reset that names it.

use super::{lines, log, raised};
use crate::world::network::Network;

/// Returns code, frame, explaining frame, and measured values.
fn found(text: &str) -> Vec<(String, u64, Option<u64>, serde_json::Value)> {
    let lines = lines(text, Network::default());
    let rows = lines.iter().filter(|line| line["kind"] == "finding");
    rows.map(|row| {
        let code = row["code"].as_str().unwrap().to_owned();
        (code, row["frame"].as_u64().unwrap(), row["because_of"].as_u64(), row["facts"].clone())
    })
    .collect()
}

fn short(text: &str) -> Vec<(String, u64, Option<u64>)> {
    found(text).into_iter().map(|(code, frame, because, _)| (code, frame, because)).collect()
}

fn one(code: &str, frame: u64, because: Option<u64>) -> (String, u64, Option<u64>) {
    (code.into(), frame, because)
}

/// Returns the log of a present node and these emergencies: `ms DATA`.
fn emergencies(of: &[(f64, &str)]) -> String {
    let sent: String = of.iter().map(|(ms, data)| format!("{ms} 085#{data}\n")).collect();
    log(&format!("0 705#05\n1 705#05\n{sent}"))
}

#[test]
fn each_class_has_its_severity() {
    for (code, rule) in [
        ("0010", "EMC008"),
        ("1023", "EMC007"),
        ("2031", "EMC007"),
        ("1042", "EMC007"),
        ("0050", "EMC007"),
        ("0061", "EMC007"),
        ("0070", "EMC007"),
        ("1081", "EMC008"),
        ("3081", "EMC008"),
        ("1082", "EMC008"),
        ("1186", "EMC007"),
        ("0090", "EMC007"),
        ("00F0", "EMC008"),
        ("00FF", "EMC008"),
    ] {
        let text = emergencies(&[(10.0, &format!("{code}010000000000")), (200.0, "0000000000000000")]);
        assert_eq!(short(&text), [one(rule, 3, None)], "{code}");
    }
    assert_eq!(short(&emergencies(&[(10.0, "0000000000000000")])), []);
}

#[test]
fn an_error_is_found_once_while_it_stands() {
    let again: Vec<(f64, &str)> = (0..5).map(|no| (10.0 + 1000.0 * f64::from(no), "1032050000000000")).collect();
    let text = emergencies(&again);
    assert_eq!(short(&text), [one("EMC007", 3, None), one("EMC009", 7, Some(3))]);
    assert_eq!(found(&text)[1].3["count"], 5);
    let mut taken_back = again.clone();
    taken_back.push((6000.0, "0000000000000000"));
    let text = emergencies(&taken_back);
    assert_eq!(short(&text), [one("EMC007", 3, None), one("EMC009", 8, Some(3))]);
    // A boot-up ends it, and it is new after that.
    let text = log("0 705#05\n10 085#1032050000000000\n20 705#00\n30 085#1032050000000000\n40 085#0000000000000000");
    assert_eq!(short(&text).iter().filter(|one| one.0 == "EMC007").count(), 2);
}

#[test]
fn an_error_that_comes_and_goes_is_one_trouble() {
    let text = |gap_ms: f64| {
        let step = |no: u32| {
            [
                (f64::from(no) * (gap_ms + 300.0) + 10.0, "3081101B00000000"),
                (f64::from(no) * (gap_ms + 300.0) + 310.0, "0000001B00000000"),
            ]
        };
        emergencies(&(0..4).flat_map(step).collect::<Vec<_>>())
    };
    for gap_ms in [1.0, 700.0, 9900.0] {
        let text = text(gap_ms);
        assert_eq!(raised(&text).len(), 1, "{gap_ms}");
        assert_eq!(short(&text).iter().filter(|one| one.2 == Some(3)).count(), 3, "{gap_ms}");
    }
    assert_eq!(raised(&text(10_100.0)).len(), 4);
}

#[test]
fn a_partial_reset_names_what_is_left() {
    let two = [(10.0, "3081111B00000000"), (500.0, "1032151400000000")];
    let with = |reset: &str| {
        let text = emergencies(&[two[0], two[1], (1000.0, reset)]);
        let row = found(&text).into_iter().find(|one| one.0 == "EMC002").unwrap();
        row.3
    };
    let facts = with("0000051B00000000");
    assert_eq!((&facts["cleared"], &facts["left"]), (&"8130".into(), &"3210".into()));
    // Another byte or none: the error is unknown.
    for reset in ["0000050700000000", "0000050000000000"] {
        assert_eq!(with(reset)["count"], 2);
    }
    // Both have the same byte.
    let same = emergencies(&[(10.0, "3081110100000000"), (500.0, "1032150100000000"), (1000.0, "0000050100000000")]);
    let row = found(&same).into_iter().find(|one| one.0 == "EMC002").unwrap();
    assert_eq!(row.3["count"], 2);
    // Only one is known: it is gone, and the remaining one was not seen.
    let text = emergencies(&[two[0], (1000.0, "0000051B00000000")]);
    let row = found(&text).into_iter().find(|one| one.0 == "EMC002").unwrap();
    assert_eq!((row.3["cleared"].as_str(), row.3["left"].as_str()), (Some("8130"), None));
}

#[test]
fn a_flood_is_one_finding_with_its_count() {
    // The same error repeatedly, and one that comes and goes.
    let held = |count: u32, step_ms: f64| {
        let sent: Vec<_> = (0..count).map(|no| (10.0 + step_ms * f64::from(no), "1032050000000000")).collect();
        emergencies(&sent)
    };
    for (count, step_ms, flood) in [(9, 10.0, false), (10, 10.0, true), (300, 1.0, true), (40, 120.0, false)] {
        let text = held(count, step_ms);
        assert_eq!(raised(&text).len(), 1, "{count} every {step_ms} ms");
        let floods: Vec<_> = found(&text).into_iter().filter(|one| one.0 == "EMC010").collect();
        assert_eq!(!floods.is_empty(), flood, "{count} every {step_ms} ms");
        assert!(!flood || floods.last().unwrap().3["count"] == count, "{floods:?}");
    }
    let flaps: Vec<_> = (0..100)
        .map(|no| (10.0 + 5.0 * f64::from(no), if no % 2 == 0 { "1032050000000000" } else { "0000000000000000" }))
        .collect();
    assert_eq!(raised(&emergencies(&flaps)).len(), 1);
    // For an error active before, the flood is the finding.
    let mut late = vec![(10.0, "1032050000000000")];
    late.extend((0..20).map(|no| (60_000.0 + 10.0 * f64::from(no), "1032050000000000")));
    let codes: Vec<_> = raised(&emergencies(&late)).into_iter().map(|one| one.0).collect();
    assert_eq!(codes, ["EMC007", "EMC010"]);
}

#[test]
fn an_error_with_another_number_of_the_stack_is_another_error() {
    // CANopenNode repeats its error bit (first manufacturer byte) in the reset: 1Bh is gone, and 1Ch is not it.
    let text = |again: &str, reset: &str| {
        log(&format!(
            "100 704#05\n200 084#3081101B01000000\n300 084#000000{reset}00000000\n400 084#308110{again}01000000\n"
        ))
    };
    let raised_by = |again: &str, reset: &str| {
        let found = raised(&text(again, reset)).into_iter().filter(|one| one.0 == "EMC008");
        found.map(|one| one.1).collect::<Vec<u64>>()
    };
    assert_eq!(raised_by("1C", "1B"), [2, 4]);
    assert_eq!(raised_by("1B", "1B"), [2]);
    // A byte that the reset does not repeat may have any meaning.
    assert_eq!(raised_by("1C", "00"), [2]);
}

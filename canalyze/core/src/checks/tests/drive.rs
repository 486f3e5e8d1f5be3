//! Drives: findings that no capture of a correct session may raise, and the limits of those that must be raised.

use proptest::prelude::*;

use super::{lines, log, raised, raised_with, without_stamps};
use crate::world::network::Network;

/// Node 5 is a drive; RPDO1 holds the controlword and the mode, TPDO1 the statusword and the mode's display.
const KNOWN: &str = "
    0 605#4000100000000000\n0.2 585#4300100092010200
    1 605#4000160000000000\n1.2 585#4F00160002000000
    2 605#4000160100000000\n2.2 585#4300160110004060
    3 605#4000160200000000\n3.2 585#4300160208006060
    4 605#40001A0000000000\n4.2 585#4F001A0002000000
    5 605#40001A0100000000\n5.2 585#43001A0110004160
    6 605#40001A0200000000\n6.2 585#43001A0208006160
";

/// The same without the device type.
fn unknown() -> String {
    KNOWN.lines().filter(|line| !line.contains("00100")).collect::<Vec<_>>().join("\n") + "\n"
}

/// Controlword, statusword, and number of repetitions.
type Step = (u16, u16, usize);

fn command(ms: f64, word: u16, mode: i8) -> String {
    let [low, high] = word.to_le_bytes();
    format!("{ms} 205#{low:02X}{high:02X}{mode:02X}\n")
}

fn status(ms: f64, word: u16, mode: i8) -> String {
    let [low, high] = word.to_le_bytes();
    format!("{ms} 185#{low:02X}{high:02X}{mode:02X}\n")
}

/// A controlword and then a statusword every 10 ms, each pair repeated.
fn cycles(from_ms: f64, steps: &[Step]) -> String {
    let mut ms = from_ms;
    let mut out = String::new();
    for (controlword, statusword, times) in steps {
        for _ in 0..*times {
            out += &command(ms, *controlword, 8);
            out += &status(ms + 1.0, *statusword, 8);
            ms += 10.0;
        }
    }
    out
}

fn codes(raised: &[super::Raised]) -> Vec<&str> {
    raised.iter().map(|(code, _, _)| code.as_str()).collect()
}

/// Up, a fault that is announced, reset, up again, quick stop, down.
const SESSION: &[Step] = &[
    (0x0000, 0x0250, 120),
    (0x0006, 0x0250, 2),
    (0x0006, 0x0231, 10),
    (0x0007, 0x0231, 1),
    (0x0007, 0x0233, 10),
    (0x000F, 0x0233, 3),
    (0x000F, 0x0237, 150),
    (0x000F, 0x021F, 1),
    (0x000F, 0x0218, 120),
    (0x0080, 0x0218, 2),
    (0x0080, 0x0250, 5),
    (0x0006, 0x0250, 1),
    (0x0006, 0x0231, 5),
    (0x000F, 0x0231, 1),
    (0x000F, 0x0237, 120),
    (0x0002, 0x0217, 30),
    (0x0002, 0x0250, 120),
    (0x0000, 0x0250, 20),
];

#[test]
fn a_sound_session_raises_nothing_but_its_fault() {
    assert_eq!(codes(&raised(&log(&(KNOWN.to_owned() + &cycles(10.0, SESSION))))), ["DRV005"]);
    assert_eq!(codes(&raised(&log(&(unknown() + &cycles(10.0, SESSION))))), ["DRV005"]);
    // No stamps.
    let log = log(&(KNOWN.to_owned() + &cycles(10.0, SESSION)));
    let bare = without_stamps(&log);
    assert_eq!(codes(&raised(&bare)), ["DRV005"]);
}

#[test]
fn a_jump_is_raised_when_what_may_be_late_has_come() {
    let jump = cycles(10.0, &[(0x0006, 0x0231, 150), (0x0006, 0x0237, 30)]);
    let known = raised(&log(&(KNOWN.to_owned() + &jump)));
    assert_eq!(codes(&known), ["DRV001"]);
    // Not yet at the end of the capture.
    let early = cycles(10.0, &[(0x0006, 0x0231, 150), (0x0006, 0x0237, 1)]);
    assert_eq!(raised(&log(&(KNOWN.to_owned() + &early))), []);
    // The controlword comes after it.
    let late = cycles(10.0, &[(0x0006, 0x0231, 150), (0x0006, 0x0237, 1), (0x000F, 0x0237, 30)]);
    assert_eq!(raised(&log(&(KNOWN.to_owned() + &late))), []);
    // A node of unknown type that has shown nothing yet, and one that has climbed.
    assert_eq!(raised(&log(&(unknown() + &jump))), []);
    let climbed =
        cycles(10.0, &[(0x0000, 0x0250, 150), (0x0006, 0x0231, 5), (0x0007, 0x0233, 150), (0x0007, 0x0237, 30)]);
    assert_eq!(codes(&raised(&log(&(unknown() + &climbed)))), ["DRV001"]);
    // Another coding; another device.
    let later = cycles(9000.0, &[(0x0006, 0x0231, 150), (0x0006, 0x0237, 30)]);
    let strange = cycles(10.0, &[(0x0000, 0x0250, 2), (0x0000, 0x0249, 1)]) + &cycles(50.0, SESSION) + &later;
    assert_eq!(raised(&log(&(unknown() + &strange))), []);
    let encoder = KNOWN.replace("4300100092010200", "4300100096010200");
    assert_eq!(raised(&log(&(encoder + &jump))), []);
}

#[test]
fn what_excuses_a_jump() {
    let with = |between: &str, after: &str| {
        let before = cycles(10.0, &[(0x0006, 0x0231, 150)]);
        KNOWN.to_owned() + &before + between + &cycles(1600.0, &[(0x0006, 0x0237, 30)]) + after
    };
    let cases = [
        ("a restart of the node", with("1590 705#00\n", "")),
        ("a reset", with("1590 000#8105\n", "")),
        ("a write by SDO, not answered yet", with("1590 605#2B4060000F000000\n", "1900 585#6040600000000000\n")),
        ("an RPDO nobody can read", with("1590 305#0F000000\n", "")),
        ("local operation", with("", "").replace("3702", "3700")),
        ("the node is another device", with("", "").replace("0192", "0196").replace("92010200", "96010200")),
    ];
    for (what, lines) in &cases {
        assert_eq!(raised(&log(lines)), [], "{what}");
    }
    assert_eq!(codes(&raised(&log(&with("", "")))), ["DRV001"]);
    // Frames were lost.
    let text = log(&with("", ""));
    let (before, after) = text.split_at(text.find("185#3702").map(|at| text[..at].rfind('\n').unwrap() + 1).unwrap());
    let lost = format!("{before}DROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 3)\n{after}");
    assert_eq!(codes(&raised(&lost)), ["CAP002"]);
}

#[test]
fn a_jump_without_stamps_and_on_the_second_axis() {
    let jump = KNOWN.to_owned() + &cycles(10.0, &[(0x0006, 0x0231, 300), (0x0006, 0x0237, 80)]);
    let text = log(&jump);
    let bare = without_stamps(&text);
    assert_eq!(codes(&raised(&bare)), ["DRV001"]);
    let second = jump.replace("10004060", "10004068").replace("10004160", "10004168");
    let lines = lines(&log(&second), Network::default());
    let finding = lines.iter().find(|line| line["code"] == "DRV001").unwrap();
    assert_eq!(finding["index"], "6841");
}

#[test]
fn commands_that_may_have_no_effect() {
    let cases: &[(&str, &[Step])] = &[
        ("no supply", &[(0x0000, 0x0240, 10), (0x0006, 0x0240, 900)]),
        ("no command of this state", &[(0x0000, 0x0250, 10), (0x000F, 0x0250, 900)]),
        ("braking", &[(0x000F, 0x0237, 10), (0x0006, 0x0237, 480), (0x0006, 0x0231, 100)]),
        ("enabled out of quick stop", &[(0x0002, 0x0217, 10), (0x000F, 0x0217, 900)]),
        ("slow to switch on", &[(0x0006, 0x0231, 10), (0x0007, 0x0231, 140), (0x0007, 0x0233, 450)]),
        ("local operation", &[(0x0000, 0x0050, 10), (0x0006, 0x0050, 900)]),
        ("in force since before the capture", &[(0x0006, 0x0250, 900)]),
    ];
    for (what, steps) in cases {
        assert_eq!(raised(&log(&(KNOWN.to_owned() + &cycles(10.0, steps)))), [], "{what}");
    }
    let held = cycles(10.0, &[(0x000F, 0x0237, 10), (0x0000, 0x0237, 150)]);
    assert_eq!(codes(&raised(&log(&(KNOWN.to_owned() + &held)))), ["DRV002"]);
    let braking = cycles(10.0, &[(0x000F, 0x0237, 10), (0x0006, 0x0237, 600)]);
    assert_eq!(codes(&raised(&log(&(KNOWN.to_owned() + &braking)))), ["DRV002"]);
    // PDOs are not received outside Operational.
    let stopped = KNOWN.to_owned() + "8 705#7F\n" + &held;
    assert!(!codes(&raised(&log(&stopped))).contains(&"DRV002"));
    // Nothing more is reported.
    let silent = KNOWN.to_owned() + &cycles(10.0, &[(0x000F, 0x0237, 10)]) + &command(200.0, 0, 8);
    assert_eq!(raised(&log(&(silent + "5000 080#\n"))), []);
}

/// Returns the findings on drives and the emergencies: code, frame, and explaining frame.
fn faults(lines: &str) -> Vec<(String, u64, Option<u64>)> {
    let lines = super::lines(&log(lines), Network::default());
    let found = lines.iter().filter(|line| line["kind"] == "finding");
    let found = found.map(|line| {
        (line["code"].as_str().unwrap().to_owned(), line["frame"].as_u64().unwrap(), line["because_of"].as_u64())
    });
    found.filter(|(code, ..)| code != "EMC009").collect()
}

fn one(code: &str, frame: u64, because_of: Option<u64>) -> (String, u64, Option<u64>) {
    (code.to_owned(), frame, because_of)
}

#[test]
fn a_fault_is_one_finding() {
    let fault = |emcy: &str, known: &str| {
        let (up, down) = ([(0x000F, 0x0237, 20)], [(0x000F, 0x0218, 100)]);
        known.to_owned() + &cycles(10.0, &up) + emcy + &cycles(300.0, &down)
    };
    // 14 frames of configuration, 40 of the cycles: the fault is frame 56.
    let alone = faults(&fault("", KNOWN));
    assert_eq!(alone[0], one("DRV005", 56, None));
    assert_eq!((alone[1].0.as_str(), alone[1].2, alone.len()), ("DRV003", Some(56), 2));
    assert_eq!(raised(&log(&fault("", KNOWN))).len(), 1);
    // An EMCY before or after it is the explanation.
    let before = "250 085#1032020000000000\n";
    assert_eq!(faults(&fault(before, KNOWN)), [one("EMC007", 55, None), one("DRV005", 57, Some(55))]);
    for ms in [301.5, 450.5, 790.5] {
        let next = format!(
            "\n{} ",
            if ms > 700.0 {
                800
            } else if ms > 400.0 {
                460
            } else {
                310
            }
        );
        let later = fault("", KNOWN).replacen(&next, &format!("\n{ms} 085#1032020000000000{next}"), 1);
        let found = faults(&later);
        let emcy = found[0].1;
        assert_eq!(found, [one("EMC007", emcy, None), one("DRV005", 56, Some(emcy))], "{ms}");
    }
    // Stopped: no EMCY is sent. At the end of the capture; before a reset.
    let stopped = faults(&fault("250 000#0205\n", KNOWN));
    assert!(stopped.contains(&one("DRV005", 57, None)) && stopped.iter().all(|one| one.0 != "DRV003"), "{stopped:?}");
    let end = KNOWN.to_owned() + &cycles(10.0, &[(0x000F, 0x0237, 20), (0x000F, 0x0218, 1)]);
    assert_eq!(faults(&end), [one("DRV005", 56, None)]);
    assert_eq!(faults(&(end + "420 000#8105\n")), [one("DRV005", 56, None)]);
    // Already there when the capture begins.
    assert_eq!(faults(&(KNOWN.to_owned() + &cycles(10.0, &[(0, 0x0218, 100)]))), []);
}

#[test]
fn a_device_type_of_0_hides_no_drive() {
    let of = |device: &str| KNOWN.replace("4300100092010200", device);
    let steps = [(0, 0x0250, 120), (6, 0x0231, 5), (7, 0x0233, 5), (15, 0x0237, 5), (15, 0x0218, 90)];
    let session = cycles(10.0, &steps);
    for device in ["4300100000000000", "43001000FFFF0000", "4300100092010200"] {
        assert_eq!(codes(&raised(&log(&(of(device) + &session)))), ["DRV005"], "{device}");
    }
    assert_eq!(raised(&log(&(of("4300100096010200") + &session))), []);
}

#[test]
fn a_fault_reset_without_effect() {
    let session = |steps: &[Step]| KNOWN.to_owned() + &cycles(10.0, steps);
    // The fault existed before the capture and is unexplained.
    let held = session(&[(0x0000, 0x0218, 10), (0x0080, 0x0218, 120)]);
    assert_eq!(faults(&held).iter().map(|one| (one.0.as_str(), one.2)).collect::<Vec<_>>(), [("DRV002", None)]);
    // Repeated, each time briefly.
    let pulse: Vec<Step> = std::iter::once((0x0000, 0x0218, 10))
        .chain((0..20).flat_map(|_| [(0x0080, 0x0218, 5), (0x0000, 0x0218, 5)]))
        .collect();
    assert!(!codes(&raised(&log(&session(&pulse)))).is_empty());
    // Also of a fault in the capture; a repetition follows from the first, and one with effect is no finding.
    let after = |reset: &[Step]| {
        let mut steps = vec![(0x000F, 0x0237, 20), (0x000F, 0x0218, 80)];
        steps.extend(reset);
        session(&steps)
    };
    let found = faults(&after(&[(0x0080, 0x0218, 150)]));
    assert!(found.contains(&one("DRV005", 56, None)), "{found:?}");
    assert!(found.iter().any(|one| one.0 == "DRV002" && one.2.is_none()), "{found:?}");
    let found = faults(&after(&[(0x0080, 0x0218, 150), (0x0000, 0x0218, 10), (0x0080, 0x0218, 150)]));
    let because: Vec<_> = found.iter().filter(|one| one.0 == "DRV002").map(|one| one.2.is_some()).collect();
    assert_eq!(because, [false, true], "{found:?}");
    for late in [1, 50, 90] {
        let found = faults(&after(&[(0x0080, 0x0218, late), (0x0080, 0x0250, 150)]));
        assert!(found.iter().all(|one| one.0 != "DRV002"), "{late}: {found:?}");
    }
}

#[test]
fn modes_that_are_not_taken() {
    let infos = |lines: &str| {
        let infos = raised_with(&log(lines), Network::default(), &["info"]);
        infos.iter().map(|(code, _, _)| code.clone()).filter(|code| code.starts_with("DRV")).collect::<Vec<_>>()
    };
    let mode = |asked: i8, shown: i8| {
        let one = |at: i32| command(f64::from(at), 6, asked) + &status(f64::from(at) + 1.0, 0x0231, shown);
        KNOWN.to_owned() + &(0..150).map(|no| one(10 + 10 * no)).collect::<String>()
    };
    assert_eq!(infos(&mode(8, 1)), ["DRV004"]);
    for (asked, shown) in [(8, 8), (0, 3)] {
        assert_eq!(infos(&mode(asked, shown)), Vec::<String>::new());
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]
    /// A correct session, cut anywhere, with some controlwords late by one frame.
    #[test]
    fn never_wrong_on_what_a_capture_does(
        (start, end) in (0..1800_usize, 0..1800_usize),
        late in 2..9_usize,
        own_type: bool,
    ) {
        let known = if own_type { KNOWN.to_owned() } else { unknown() };
        let session = cycles(10.0, SESSION);
        let mut lines: Vec<&str> = session.lines().collect();
        let mut at = 0;
        while at + 1 < lines.len() {
            if at % late < 2 && lines[at].contains("205#") {
                lines.swap(at, at + 1);
                at += 1;
            }
            at += 1;
        }
        let end = lines.len().saturating_sub(end).max(start.min(lines.len()));
        let cut = lines[start.min(lines.len())..end].join("\n");
        let found = raised(&log(&(known + &cut)));
        prop_assert!(found.len() <= 1 && found.iter().all(|(code, ..)| code == "DRV005"), "{found:?}");
    }
}

//! PDOs against their configuration: findings, and correct traffic.

use super::*;
use crate::tables::columns::Name;
use crate::world::dictionary::{Access, Dictionary, Form, Object, Preset};
use crate::world::network::Description;

const ABOVE: &[&str] = &["warning", "error"];
const ALL: &[&str] = &["info", "warning", "error"];

/// SDO writes to node 5, acknowledged, from 0 ms on in steps of 1 ms: `1800:01 u32 80000185`.
pub(super) fn writes(from_ms: f64, rows: &str) -> String {
    exchange(from_ms, rows, |index, size, value| {
        let command = ["", "2F", "2B", "27", "23"][size];
        (format!("{command}{index}{value}"), format!("60{index}00000000"))
    })
}

/// SDO reads from node 5.
pub(super) fn reads(from_ms: f64, rows: &str) -> String {
    exchange(from_ms, rows, |index, size, value| {
        let command = ["", "4F", "4B", "47", "43"][size];
        (format!("40{index}00000000"), format!("{command}{index}{value}"))
    })
}

fn exchange(from_ms: f64, rows: &str, frames: impl Fn(&str, usize, &str) -> (String, String)) -> String {
    let mut out = String::new();
    let mut ms = from_ms;
    for row in rows.lines().map(str::trim).filter(|row| !row.is_empty()) {
        let mut words = row.split_whitespace();
        let (index, sub) = words.next().unwrap().split_once(':').unwrap();
        let size = words.next().unwrap()[1..].parse::<usize>().unwrap() / 8;
        let value = u32::from_str_radix(words.next().unwrap(), 16).unwrap();
        let index = u16::from_str_radix(index, 16).unwrap().to_le_bytes();
        let value: String = value.to_le_bytes().iter().map(|byte| format!("{byte:02X}")).collect();
        let (request, response) = frames(&format!("{:02X}{:02X}{sub}", index[0], index[1]), size, &value);
        out += &format!("{ms} 605#{request}\n{} 585#{response}\n", ms + 0.3);
        ms += 1.0;
    }
    out
}

/// The procedure of CiA 301, 7.5.2.38: TPDO1 of node 5 with four bytes, event-driven.
const REMAP: &str = "1800:01 u32 C0000185
    1A00:00 u8 0
    1A00:01 u32 20000120
    1A00:00 u8 1
    1800:02 u8 FE
    1800:01 u32 40000185";

fn codes(text: &str) -> Vec<String> {
    codes_with(text, Network::default(), ABOVE)
}

/// Returns all findings except those on heartbeats, which are mere other traffic here.
fn codes_with(text: &str, network: Network, severities: &[&str]) -> Vec<String> {
    let found = raised_with(&log(text), network, severities).into_iter();
    found.filter(|(code, ..)| !code.starts_with("HBT")).map(|(code, frame, _)| format!("{code} {frame}")).collect()
}

fn object(index: u16, sub: u8, data_type: u16, access: Access, preset: Option<u64>) -> Object {
    let preset = preset.map(|value| Preset { value, relative: false, configured: false });
    let (name, unit) = ("x".into(), None);
    Object { index, sub, name, data_type, access, preset, mappable: true, unit, factor: 1.0 }
}

/// Node 5 with a description of that form.
fn described(form: Form, objects: Vec<Object>) -> Network {
    let dictionary = Arc::new(Dictionary::new("x.eds".into(), form, String::new(), objects));
    Network { descriptions: vec![Description { bus: None, node: 5, dictionary }], ..Network::default() }
}

fn mapping(form: Form) -> Network {
    described(
        form,
        vec![
            object(0x1800, 1, 7, Access::Rw, Some(0x185)),
            object(0x1A00, 0, 5, Access::Rw, Some(1)),
            object(0x1A00, 1, 7, Access::Rw, Some(0x2000_0120)),
        ],
    )
}

#[test]
fn lengths() {
    let remapped = writes(0.0, REMAP);
    assert_eq!(
        codes(&format!("{remapped} 20 185#01020304\n 30 185#010203\n 40 185#0102030405")),
        ["PDO001 14", "PDO006 15"]
    );
    // Written values are gone after a reset.
    assert_eq!(codes(&format!("{remapped} 20 000#8105\n 30 705#00\n 40 185#0102")), [""; 0]);
    assert_eq!(
        codes(&format!("{} 20 705#05\n 21 185#010203", reads(0.0, "1A00:00 u8 1\n 1A00:01 u32 20000120"))),
        ["PDO001 6"]
    );
    // An aborted write changes nothing.
    let refused = "20 605#2F001A0000000000\n 20.3 585#80001A0000000106\n 30 185#01020304\n 40 185#01";
    assert_eq!(codes(&format!("{remapped} {refused}")), ["PDO001 16"]);
    for (text, form, expected) in [
        ("0 185#010203", Form::Dcf, "PDO001 1"),
        ("0 185#01020304", Form::Dcf, ""),
        // Against an EDS: only after it was correct once; before, the device may have stored another mapping.
        ("0 185#010203", Form::Eds, "EDS001 1"),
        ("0 185#01020304\n 1 185#010203", Form::Eds, "PDO012 2"),
        ("0 705#00\n 1 185#010203", Form::Eds, "EDS001 2"),
        ("0 185#01020304\n 1 185#01020304", Form::Eds, ""),
    ] {
        assert_eq!(codes_with(text, mapping(form), ALL).concat(), expected, "{text}");
    }
    // Read, then reset: it may have been written before the capture.
    let read = reads(0.0, "1A00:00 u8 1\n 1A00:01 u32 20000120");
    assert_eq!(codes(&format!("{read} 20 000#8105\n 21 705#00\n 30 185#0102")), [""; 0]);
}

#[test]
fn consequences_are_counted_the_same_if_tables_take_them_first() {
    let frames: String = (0..30).map(|no| format!("{no} 185#010203\n")).collect();
    let text = |outputs: &[Output]| written(&log(&frames), mapping(Form::Eds), outputs);
    let alone = text(&[Output::Lines]);
    assert!(alone.contains("29条后果: EDS001"), "{alone}");
    assert_eq!(text(&[Output::Lines, Output::Columns(Name::Findings)]), alone);
}

#[test]
fn lengths_of_a_receiver() {
    // Node 6 receives node 5's TPDO1 with its RPDO1.
    let linked = "0 606#2F00160001000000\n 0.3 586#6000160000000000
        1 606#2300160110000020\n 1.3 586#6000160100000000
        2 606#2300140185010000\n 2.3 586#6000140100000000";
    assert_eq!(codes(&format!("{linked}\n 10 185#0102\n 20 185#01")), ["PDO001 8"]);
}

#[test]
fn a_conformant_remap() {
    let sent = "-5 185#0102030405060708\n";
    let after = "40 185#01020304\n 41 185#01020304";
    assert_eq!(codes_with(&format!("{sent}{}{after}", writes(0.0, REMAP)), Network::default(), ALL), [""; 0]);
    // Cut anywhere, and twice.
    let twice = format!("{sent}{}{}{after}", writes(0.0, REMAP), writes(30.0, REMAP));
    let lines: Vec<&str> = twice.lines().collect();
    for from in 0..lines.len() {
        for to in from + 1..=lines.len() {
            assert_eq!(codes(&lines[from..to].join("\n")), [""; 0], "{from}..{to}");
        }
    }
}

#[test]
fn mapping_of_a_valid_pdo() {
    let valid = reads(-10.0, "1800:01 u32 40000185");
    let live = |rows: &str| codes(&format!("{valid}{}", writes(0.0, rows)));
    assert_eq!(live("1A00:00 u8 0\n 1A00:01 u32 20000120\n 1A00:02 u32 20010120\n 1A00:00 u8 2"), ["PDO009 6"]);
    assert_eq!(live("1A00:01 u32 20000120"), ["PDO009 4"]);
    assert_eq!(live("1A00:00 u8 0"), [""; 0]);
    // A node that is not Operational sends nothing meanwhile; many masters then write only sub-index 0.
    let after_boot_up =
        format!("-20 705#00\n{valid}{}", writes(0.0, "1A00:00 u8 0\n 1A00:01 u32 20000120\n 1A00:00 u8 1"));
    assert_eq!(codes(&after_boot_up), [""; 0]);
    assert_eq!(codes(&after_boot_up.replace("-20 705#00", "-20 705#00\n-19 000#0105\n-18 705#05")), ["PDO009 9"]);
    assert_eq!(
        codes(&writes(0.0, "1A00:00 u8 0\n 1A00:01 u32 20000120\n 1A00:00 u8 1")),
        [""; 0],
        "validity is not known"
    );
    // A TPDO that is sent is valid.
    assert_eq!(codes(&format!("-5 185#01\n {}", writes(0.0, "1A00:01 u32 20000120"))), ["PDO009 3"]);
    // The same value again changes nothing.
    let same = reads(-20.0, "1A00:00 u8 1\n 1A00:01 u32 20000120");
    assert_eq!(codes(&format!("{same}{valid}{}", writes(0.0, "1A00:01 u32 20000120\n 1A00:00 u8 1"))), [""; 0]);
}

#[test]
fn cob_ids() {
    let valid = reads(-10.0, "1800:01 u32 40000185");
    assert_eq!(codes(&format!("{valid}{}", writes(0.0, "1800:01 u32 400001A5"))), ["PDO010 4"]);
    assert_eq!(codes(&format!("{valid}{}", writes(0.0, "1800:01 u32 C0000185\n 1800:01 u32 400001A5"))), [""; 0]);
    assert_eq!(codes(&format!("-5 185#01\n {}", writes(0.0, "1800:01 u32 400001A5"))), ["PDO010 3"]);
    assert_eq!(codes(&writes(0.0, "1800:01 u32 400001A5")), [""; 0]);
    for (write, restricted) in [
        ("1800:01 u32 40000601", true),
        ("1400:01 u32 0000007F", true),
        ("1800:01 u32 80000000", false),
        ("1800:01 u32 60000601", false),
        ("1005:00 u32 00000701", true),
        ("1005:00 u32 40000080", false),
        ("1014:00 u32 00000180", true),
        ("1012:00 u32 80000100", false),
        ("1201:01 u32 00000640", true),
        ("1280:01 u32 00000640", false),
        ("1280:01 u32 00000080", false),
    ] {
        assert_eq!(codes(&writes(0.0, write)).len(), usize::from(restricted), "{write}");
    }
}

#[test]
fn transmission_types() {
    for (write, reserved) in [
        ("1800:02 u8 F5", true),
        ("1800:02 u8 F0", false),
        ("1800:02 u8 FC", false),
        ("1400:02 u8 FC", true),
        ("1400:02 u8 FE", false),
        ("1A00:00 u8 F5", false),
    ] {
        let expected: &[&str] = if reserved { &["PDO008 2"] } else { &[] };
        assert_eq!(codes(&writes(0.0, write)), expected, "{write}");
    }
    assert_eq!(codes("0 605#2F001802F5000000\n 0.3 585#8000180230000906"), [""; 0]);
}

#[test]
fn remote_frames_and_disabled_pdos() {
    let no_rtr = reads(0.0, "1800:01 u32 40000185");
    assert_eq!(codes(&format!("{no_rtr} 10 185#R4")), ["PDO011 3"]);
    assert_eq!(codes(&format!("{} 10 185#R4", reads(0.0, "1800:01 u32 00000185"))), [""; 0]);
    assert_eq!(codes("10 185#R4"), [""; 0]);
    let off = writes(0.0, "1800:01 u32 C0000185");
    assert_eq!(codes(&format!("{off} 2 185#01\n 3 185#01\n 4 185#01")), ["PDO018 5"], "two may have been under way");
    let late = "2 585#6000180100000000\n 3 185#01\n 4 185#01\n 15 185#01\n 16 605#2300180185010040\n 17 185#01";
    assert!(!codes(&format!("{off} {late}")).iter().any(|code| code.starts_with("PDO")), "enabled, the request late");
    let moved = writes(0.0, "1800:01 u32 800001B0");
    assert_eq!(codes(&format!("{moved} 5 705#05\n 6 705#05\n 10 185#01")), [""; 0], "anyone's");
    let rpdo = writes(0.0, "1400:01 u32 80000205");
    let seen = format!("{rpdo} 5 205#01\n 6 205#01");
    assert_eq!(codes_with(&seen, Network::default(), ALL), ["PDO019 3"]);
}

#[test]
fn long_and_empty_mappings() {
    let long = "1A00:00 u8 0\n 1A00:01 u32 20000140\n 1A00:02 u32 20010008\n 1A00:00 u8 2";
    assert_eq!(codes(&writes(0.0, long)), ["PDO016 8"]);
    let empty = writes(0.0, "1800:01 u32 40000185\n 1A00:00 u8 0");
    assert_eq!(codes_with(&format!("{empty} 5 185#01\n 6 185#02"), Network::default(), ALL), ["PDO015 5"]);
}

/// TPDO1 of node 5: event-driven, inhibit time 10 ms, event timer 100 ms.
fn timed() -> String {
    writes(0.0, "1800:01 u32 C0000185\n 1800:02 u8 FF\n 1800:03 u16 64\n 1800:05 u16 64\n 1800:01 u32 40000185")
}

#[test]
fn inhibit_time() {
    let after = |times: &[f64]| {
        let frames: String = times.iter().map(|ms| format!("{ms} 185#01\n")).collect();
        codes(&format!("{}{frames}", timed()))
    };
    assert_eq!(after(&[100.0, 110.0, 120.0, 130.0]), [""; 0]);
    assert_eq!(after(&[100.0, 103.0, 120.0]), ["PDO004 12"]);
    assert_eq!(after(&[100.0, 107.0, 114.0, 121.0]), ["PDO004 13"], "and what follows is its consequence");
    // One frame was stamped late, by less than half of the time.
    assert_eq!(after(&[100.0, 110.0, 124.0, 130.0, 140.0, 150.0]), [""; 0]);
    assert_eq!(after(&[100.0, 111.5, 120.0, 130.0, 140.9, 149.5, 160.0]), [""; 0]);
    // Stamps that step back, and a reset in between.
    assert_eq!(after(&[100.0, 89.0, 78.0]), ["CAP006 12", "CAP006 13"]);
    assert_eq!(codes(&format!("{} 100 185#01\n 101 000#8105\n 102 705#00\n 103 185#01", timed())), [""; 0]);
    // An answer to a remote frame.
    let allowed = timed().replace("85010040", "85010000");
    assert_eq!(codes(&format!("{allowed} 100 185#01\n 101 185#R1\n 102 185#01\n 103 185#01")), ["PDO004 14"]);
    // A synchronous PDO has none.
    let synchronous = timed().replace("00001802FF", "0000180201").replace("180002FF", "18000201");
    let synchronous = synchronous.replace("2F001802FF000000", "2F00180201000000");
    assert_eq!(codes(&format!("{synchronous} 100 185#01\n 101 185#01")), [""; 0]);
}

#[test]
fn event_timer() {
    let with = |rest: &str| codes(&format!("{}{rest}", timed()));
    let heartbeats = |from: u32, to: u32| -> String { (from..to).map(|n| format!("{} 706#05\n", n * 20)).collect() };
    assert_eq!(with(&format!("100 185#01\n{}", heartbeats(6, 30))), ["PDO005 19"], "at 260 ms, and once");
    assert_eq!(with(&format!("100 185#01\n{} 245 185#01\n", heartbeats(6, 12))), [""; 0]);
    // Stopped, pre-operational by itself, or never there.
    assert_eq!(with(&format!("100 185#01\n 101 000#0205\n 101.1 185#01\n{}", heartbeats(6, 30))), [""; 0]);
    assert_eq!(with(&format!("100 185#01\n 101 705#7F\n{}", heartbeats(6, 30))), [""; 0]);
    assert_eq!(with(&heartbeats(6, 30)), [""; 0]);
    // The whole bus was silent.
    assert_eq!(with(&format!("{} 195 185#01\n 600 706#05\n 601 185#01\n", heartbeats(5, 10))), [""; 0]);
    // If nothing else is ever sent, silence is the PDO's own.
    assert_eq!(with("100 185#01\n 200 185#01\n 300 185#01\n 500 185#01\n 600 185#01"), ["PDO005 14"]);
    assert_eq!(with("100 185#01\n 200 185#01\n 300 185#01\n 480 185#01\n 500 185#01"), [""; 0]);
    // A silence of many periods may be the recorder's if hardly anything else is sent, but not two of them.
    let alone: String = (1..20).map(|n| format!("{} 185#01\n", n * 100)).collect();
    assert_eq!(with(&format!("{alone} 4000 706#05\n 4010 185#01\n")), [""; 0]);
    assert_eq!(with(&format!("{alone} 4000 706#05\n 6000 706#05\n 8000 706#05\n")), ["PDO005 31"]);
    // The end of the capture proves nothing.
    assert_eq!(with("100 185#01"), [""; 0]);
}

#[test]
fn deadline_of_an_rpdo() {
    let deadline = writes(0.0, "1400:02 u8 FF\n 1400:05 u16 32");
    let text = format!("{deadline} 20 205#01\n 71 706#05\n 90 706#05\n 100 706#05");
    assert_eq!(codes_with(&text, Network::default(), ALL), ["PDO013 7"]);
}

/// Object 2000h is requested, and the device does not have it.
const NO_OBJECT: &str = "0 605#4000200000000000\n 1 585#8000200000000206\n";

#[test]
fn descriptions_and_transfers() {
    let network = || {
        described(
            Form::Eds,
            vec![
                object(0x1000, 0, 7, Access::Ro, Some(0x0002_0192)),
                object(0x1018, 1, 7, Access::Ro, Some(0x77)),
                object(0x1018, 2, 7, Access::Ro, Some(0)),
                object(0x1800, 1, 7, Access::Rw, Some(0x4000_0185)),
                object(0x1800, 2, 5, Access::Rw, Some(254)),
                object(0x2000, 0, 6, Access::Rw, None),
                object(0x2001, 0, 6, Access::Const, None),
                object(0x2002, 0, 1, Access::Wo, None),
                object(0x2003, 0, 9, Access::Rw, None),
            ],
        )
    };
    for (text, expected) in [
        (reads(0.0, "2000:00 u16 1"), vec![]),
        (reads(0.0, "2000:00 u32 1"), vec!["SDO013 2"]),
        (writes(0.0, "2000:00 u8 1"), vec!["SDO013 2"]),
        // Size not indicated; aborted; strings.
        ("0 605#4000200000000000\n 1 585#4200200001000000".into(), vec![]),
        ("0 605#2F00200001000000\n 1 585#8000200010000706".into(), vec!["SDO017 2"]),
        // It has no such object: reported once, also for objects that the description lacks.
        (NO_OBJECT.repeat(2), vec!["SDO017 2", "EDS005 2", "SDO017 4"]),
        (NO_OBJECT.replace("00000206", "11000906"), vec!["SDO017 2", "EDS005 2"]),
        (NO_OBJECT.replace("0020", "0420"), vec!["SDO017 2"]),
        (writes(0.0, "2003:00 u8 1"), vec![]),
        (writes(0.0, "2001:00 u16 1"), vec!["SDO014 2"]),
        (reads(0.0, "2001:00 u16 1"), vec![]),
        (reads(0.0, "2002:00 u8 1"), vec!["SDO014 2"]),
        (writes(0.0, "2002:00 u8 1"), vec![]),
        (reads(0.0, "2004:00 u8 1\n 2004:00 u8 1"), vec!["EDS003 2"]),
        (reads(0.0, "1000:00 u32 191"), vec!["EDS004 2"]),
        (reads(0.0, "1000:00 u32 20192\n 1018:01 u32 77\n 1018:02 u32 9"), vec![]),
        (reads(0.0, "1018:01 u32 78"), vec!["EDS004 2"]),
        (reads(0.0, "1800:02 u8 1\n 1800:02 u8 1"), vec!["EDS001 2"]),
        (reads(0.0, "1800:01 u32 40000185"), vec![]),
        (format!("{}{}", writes(0.0, "1800:02 u8 1"), reads(5.0, "1800:02 u8 1")), vec![]),
    ] {
        assert_eq!(codes_with(&text, network(), ALL), expected, "{text}");
    }
    let mut dcf = network();
    let mut dictionary = (*dcf.descriptions[0].dictionary).clone();
    dictionary.form = Form::Dcf;
    dcf.descriptions[0].dictionary = Arc::new(dictionary);
    assert_eq!(codes_with(&reads(0.0, "1800:02 u8 1"), dcf, ALL), ["EDS002 2"]);
}

#[test]
fn lost_frames_and_two_buses() {
    let other_bus = log(&writes(0.0, REMAP)) + &log("20 185#01").replace("can0", "can1");
    assert_eq!(raised(&other_bus), []);
    let lost = log(&writes(0.0, REMAP)) + "DROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 3)\n";
    let text = lost + &log("20 185#01");
    let found: Vec<_> = lines(&text, Network::default()).into_iter().filter(|line| line["kind"] == "finding").collect();
    assert_eq!(found.len(), 1);
    assert_eq!(found[0]["code"], "CAP002");
}

#[test]
fn a_bunch_after_an_unusual_silence_was_held_up() {
    let inhibited = writes(0.0, "1800:03 u16 C8\n 1800:02 u8 FF");
    let sent = |from: u32, to: u32| -> String { (from..to).map(|no| format!("{} 185#01\n", 100 + 25 * no)).collect() };
    let steady = sent(0, 20);
    // Five frames of 25 ms each, after 150 ms in which the bus showed nothing.
    let bunch = "745 185#01\n 745.2 185#01\n 745.4 185#01\n 745.6 185#01\n 745.8 185#01\n 770 185#01";
    assert_eq!(codes(&format!("{inhibited}{steady}{bunch}")), [""; 0]);
    // The same distance after the usual silence is the node's own.
    let close = "600 185#01\n 600.2 185#01\n 625 185#01";
    assert_eq!(codes(&format!("{inhibited}{steady}{close}")), ["PDO004 26"]);
}

#[test]
fn a_type_that_only_an_eds_presets_and_a_timer_as_long_as_the_period() {
    // Acyclic by 1 % of the period: once it comes twice in a cycle.
    let cycles: String = (1..=150_u32)
        .map(|no| {
            let sync = f64::from(no) * 10.0;
            format!("{sync} 080#\n{:.2} 185#01\n", sync + 9.95 - 0.1 * f64::from(no))
        })
        .collect();
    let mut lines: Vec<(f64, &str)> =
        cycles.lines().map(|line| (line.split(' ').next().unwrap().parse().unwrap(), line)).collect();
    lines.sort_by(|one, other| one.0.total_cmp(&other.0));
    let text: String = lines.iter().map(|(_, line)| format!("{line}\n")).collect();
    let network = described(Form::Eds, vec![object(0x1800, 2, 5, Access::Rw, Some(1))]);
    assert_eq!(codes_with(&text, network, ABOVE), [""; 0]);
}

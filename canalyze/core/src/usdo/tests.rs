//! Transfers frame by frame: what each becomes, and what is reported. The frames are those of a real stack where they
//! name SOFA's node 7Eh, else by the layouts.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]

use serde_json::Value;

use crate::checks::tests::{lines, log};
use crate::world::network::Network;

/// The first exchange, by which the server is known.
const KNOWN: &str = "0 67E##1051101011810\n0.2 585##17E31010118100F04000002F1\n";

/// Returns the JSON lines of frames after the first exchange. `then`: `ms ID##FDATA` lines.
fn read(then: &str) -> Vec<Value> {
    lines(&log(&format!("{KNOWN}{then}")), Network::default())
}

fn transfers(lines: &[Value]) -> Vec<&Value> {
    lines.iter().filter(|line| line["kind"] == "transfer").collect()
}

/// Returns code and frame of each finding.
fn codes(lines: &[Value]) -> Vec<(&str, u64)> {
    let findings = lines.iter().filter(|line| line["kind"] == "finding");
    findings.map(|line| (line["code"].as_str().unwrap(), line["frame"].as_u64().unwrap())).collect()
}

/// Returns 60 bytes in hexadecimal digits.
fn full(byte: &str) -> String {
    byte.repeat(60)
}

#[test]
fn expedited() {
    let lines = read("10 67E##105014B01022F070478563412\n10.2 585##17E214B01022F\n");
    let all = transfers(&lines);
    assert_eq!(
        (all[0]["client"].as_u64(), all[0]["node"].as_u64(), all[0]["session"].as_u64()),
        (Some(126), Some(5), Some(1))
    );
    assert_eq!((&all[0]["data"], &all[0]["status"]), (&"000002F1".into(), &"ok".into()));
    assert_eq!((&all[1]["data"], &all[1]["direction"]), (&"78563412".into(), &"download".into()));
    assert_eq!((&all[1]["index"], &all[1]["sub"]), (&"2F02".into(), &1.into()));
    assert!(codes(&lines).is_empty());
}

#[test]
fn segmented_both_ways() {
    let upload = format!(
        "10 67E##10511130D002E\n10.1 585##17E32130D002E0F003D000000\n10.2 67E##105131300\n10.3 585##17E331300{}\n\
         10.4 67E##105131301\n10.5 585##17E34130180\n",
        full("CC")
    );
    let download = format!(
        "20 67E##1050227012F000F0040000000\n20.1 585##17E2227012F00\n20.2 67E##105032700{}\n20.3 585##17E232700\n\
         20.4 67E##105042704FCFDFEFF\n20.5 585##17E2427\n",
        full("C0")
    );
    let lines = read(&(upload + &download));
    let all = transfers(&lines);
    assert_eq!((&all[1]["size"], &all[1]["mode"], &all[1]["status"]), (&61.into(), &"segmented".into(), &"ok".into()));
    assert_eq!((&all[2]["size"], &all[2]["size_indicated"], &all[2]["status"]), (&64.into(), &64.into(), &"ok".into()));
    assert!(codes(&lines).is_empty());
}

#[test]
fn sessions_at_once() {
    // Two clients with one session number at one server, whose answers come the other way round.
    let lines = read(
        "10 601##1051107011810\n10.1 602##1051107021810\n10.3 585##1023107021810070402000000\n10.4 585##1013107011810070401000000\n",
    );
    let all = transfers(&lines);
    assert_eq!((&all[1]["client"], &all[1]["sub"], &all[1]["status"]), (&2.into(), &2.into(), &"ok".into()));
    assert_eq!((&all[2]["client"], &all[2]["data"]), (&1.into(), &"01000000".into()));
    assert!(codes(&lines).is_empty());
}

#[test]
fn aborts() {
    // The server refuses, and refuses the client's abort, too.
    let lines = read(
        "10 67E##1051109000030\n10.2 585##17E7F0900003033\n20 67E##105020B01002F0F00C8000000\n20.1 585##17E220B01002F\n21 67E##1057F0B01002F11\n21.2 585##17E7F0B01002F13\n",
    );
    let all = transfers(&lines);
    assert_eq!(all[1]["abort"]["code"], "33");
    assert_eq!(all[1]["abort"]["text"], "对象字典中不存在该对象");
    assert_eq!((&all[2]["abort"]["by"], &all[2]["abort"]["code"]), (&"client".into(), &"11".into()));
    assert_eq!(codes(&lines), [("SDO017", 4), ("SDO017", 7)]);
}

#[test]
fn unanswered_and_late() {
    let lines = read("10 67E##105110C011810\n3000 705##105\n");
    assert_eq!(codes(&lines), [("SDO002", 4)]);
    assert_eq!(transfers(&lines)[1]["status"], "incomplete");
    let late = read(
        "10 67E##105110C011810\n300 705##105\n600 705##105\n900 705##105\n1200 705##105\n1500 585##17E310C0118100F04000002F1\n",
    );
    assert_eq!(codes(&late), [("SDO020", 8)]);
    assert_eq!(transfers(&late)[1]["status"], "ok");
    // Before clients give up nothing is missing.
    assert!(codes(&read("10 67E##105110C011810\n500 705##105\n")).is_empty());
}

#[test]
fn counters() {
    let begin = "10 67E##105020902002F0F0078000000\n10.1 585##17E220902002F\n10.2 67E##105030900";
    // The server refuses a segment that skips one: the client is wrong.
    let refused = read(&format!(
        "{begin}{}\n10.3 585##17E230900\n10.4 67E##105030902{}\n10.5 585##17E7F0902002F14\n",
        full("AA"),
        full("BB")
    ));
    assert_eq!(codes(&refused), [("SDO001", 7), ("SDO017", 8)]);
    assert_eq!(transfers(&refused)[1]["size"], 120);
    // It takes the segment: the one before is missing in the capture.
    let lost = read(&format!(
        "{begin}{}\n10.3 585##17E230900\n10.4 67E##105030902{}\n10.5 585##17E230902\n",
        full("AA"),
        full("BB")
    ));
    assert_eq!(codes(&lost), [("SDO024", 8)]);
    assert_eq!(transfers(&lost)[1]["size"], 180);
}

#[test]
fn sizes() {
    let begin = "10 67E##105020901002F0F0005000000\n10.1 585##17E220901002F\n10.2 67E##105040903010203\n";
    assert_eq!(codes(&read(&format!("{begin}10.3 585##17E2409\n"))), [("SDO006", 6)]);
    assert_eq!(codes(&read(&format!("{begin}10.3 585##17E7F0901002F15\n"))), [("SDO006", 5), ("SDO017", 6)]);
}

#[test]
fn unknown_session() {
    let lines = read(&format!("10 67E##105030D00{}\n10.2 585##17E7F0D00001021\n", full("00")));
    assert_eq!(codes(&lines), [("SDO007", 3)]);
}

#[test]
fn to_all_nodes() {
    let lines = lines(
        &log(
            "0 601##10001020017100602E8030000\n0.3 585##1012102001710\n0.6 586##1012102001710\n0.9 587##1017F0200171070\n",
        ),
        Network::default(),
    );
    let all = transfers(&lines);
    let shown: Vec<_> =
        all.iter().map(|one| (one["node"].as_u64().unwrap(), one["status"].as_str().unwrap())).collect();
    assert_eq!(shown, [(5, "ok"), (6, "ok"), (7, "aborted")]);
}

#[test]
fn bytes_of_sdo_in_fd_frames() {
    let lines = lines(&log("0 605##14018100100000000\n1 585##14318100144332211\n"), Network::default());
    assert!(transfers(&lines).is_empty());
    let malformed = lines.iter().filter(|line| line["sdo"]["malformed"] == "fd").count();
    assert_eq!(malformed, 2, "{lines:?}");
}

#[test]
fn any_bytes() {
    // Every command with every length, between exchanges: no panic, and nothing but USDO is decoded.
    let mut text = String::new();
    for command in 0..=255_u8 {
        for (place, len) in [0_usize, 1, 2, 3, 4, 6, 7, 8, 12, 64].into_iter().enumerate() {
            let id = if place % 2 == 0 { "67E" } else { "585" };
            let payload: String =
                (0..len).map(|at| if at == 1 { format!("{command:02X}") } else { "05".into() }).collect();
            text += &format!("{} {id}##1{payload}\n", 10 + u64::from(command) * 10 + place as u64);
        }
    }
    let lines = read(&text);
    assert!(lines.iter().filter(|line| line["kind"] == "frame").count() > 2000);
}

#[test]
fn what_a_lost_frame_leaves() {
    let begin = "10 67E##105020902002F0F0046000000\n10.1 585##17E220902002F\n10.2 67E##105030900";
    // The last segment is missing in the capture.
    let lines = read(&format!("{begin}{}\n10.3 585##17E230900\n10.5 585##17E2409\n", full("AA")));
    let all = transfers(&lines);
    assert_eq!((&all[1]["status"], &all[1]["size"]), (&"incomplete".into(), &60.into()));
    assert_eq!(codes(&lines), [("SDO024", 7)]);
    // A response without its request at the beginning is no fault.
    assert!(codes(&lines_of("0 585##1023107021810070402000000\n")).is_empty());
}

fn lines_of(frames: &str) -> Vec<Value> {
    lines(&log(frames), Network::default())
}

#[test]
fn what_is_no_fault_of_a_server() {
    // Pipelined reads of one object, a response command on a request's identifier, and a group of nodes.
    assert!(codes(&read("10 67E##1051109011810\n11 67E##105110A011810\n11.5 585##17E31090118100F04000002F1\n12 585##17E310A0118100F04000002F1\n")).is_empty());
    assert!(
        codes(&read("10 67E##1051109011810\n11 67E##1052109011810\n11.5 585##17E31090118100F04000002F1\n")).is_empty()
    );
    assert!(codes(&read("10 67E##1C81109011810\n2500 705##105\n5000 705##105\n")).is_empty());
    // A refusal for another reason than the size says nothing of segments that were not captured.
    let lost = format!(
        "10 67E##1050209010021 0F00B4000000\n10.1 585##17E2209010021\n10.2 67E##105030900{}\n10.3 585##17E230900\n10.6 67E##10504093C{}\n10.7 585##17E7F0901002160\n",
        full("AA"),
        full("AA")
    );
    assert_eq!(codes(&read(&lost.replace(" 0F00B4", "0F00B4"))), [("SDO017", 8)]);
}

#[test]
fn the_type_of_the_frame_is_the_type_of_an_unknown_object() {
    let lines = read(
        "10 67E##105014B01022F0401FF\n10.2 585##17E214B01022F\n20 67E##105014C01022F0201FF\n20.2 585##17E214C01022F\n",
    );
    let types: Vec<_> = transfers(&lines).iter().map(|one| one["type"].clone()).collect();
    assert_eq!(types[1..], [Value::from("INTEGER32"), Value::from("INTEGER8")]);
}

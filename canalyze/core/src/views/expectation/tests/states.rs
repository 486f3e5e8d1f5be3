//! States of nodes and drives, heartbeats, SYNC, emergencies.

use std::sync::Arc;

use super::{check, findings};
use crate::bytes::frame::{CanId, Frame};
use crate::bytes::ns::Ns;
use crate::session::{Encoding, Options, Output, Rows, Session};
use crate::views::expectation::Expectations;
use crate::words::Lang;

fn state(more: &str, frames: &str, expected: &[(&str, u64, u64, u64)]) {
    check("state", &[&format!(r#""node":5,{more}"#)], frames, expected);
}

const OPERATIONAL: &str = r#""state":"operational""#;

#[test]
fn states_that_must_be_reached() {
    state(OPERATIONAL, "0 705#7F;1 705#05", &[]);
    state(OPERATIONAL, "- 705#7F;- 705#05", &[]);
    state(OPERATIONAL, "0 705#7F;1 705#7F", &[("EXP005", 2, 0, 1)]);
    state(OPERATIONAL, "0 706#05;1 706#05", &[("EXP005", 2, 0, 1)]);
    // Guarding responses show it too.
    state(OPERATIONAL, "0 705#R1;0.1 705#85", &[]);
    state(r#""state":"boot-up""#, "0 705#00", &[]);
    state(r#""state":"boot-up""#, "0 705#7F", &[("EXP005", 1, 0, 1)]);
    // A command is not enough, unless the node shows no state at all.
    state(OPERATIONAL, "0 705#7F;1 000#0105;2 705#7F", &[("EXP005", 3, 0, 1)]);
    state(OPERATIONAL, "0 705#00;1 000#0100;2 185#00", &[("EXP015", 3, 0, 1)]);
    state(r#""state":"pre-operational""#, "0 705#00;2 185#00", &[("EXP015", 2, 0, 1)]);
}

#[test]
fn in_time() {
    let by = r#""state":"operational","by_ns":2500000000"#;
    state(by, "0 705#7F;2.5 705#05;3 705#05", &[]);
    state(by, "0 705#7F;2.6 705#05;3 705#05", &[("EXP005", 2, 0, 1)]);
    state(by, "0 705#7F;3 705#7F", &[("EXP005", 2, 0, 1)]);
    // First seen after the limit: the time of the state is unknown.
    state(by, "0 706#05;3 705#05", &[("EXP015", 2, 0, 1)]);
    state(by, "- 705#7F;- 705#05", &[("EXP015", 2, 0, 1)]);
    state(r#""state":"boot-up","by_ns":1000000000"#, "0 706#05;3 705#00", &[("EXP005", 2, 0, 1)]);
    let since = r#""state":"operational","by_ns":2500000000,"since":"boot-up""#;
    state(since, "0 706#05;9 705#00;11 705#05", &[]);
    state(since, "0 706#05;9 705#00;12 705#05;13 705#05", &[("EXP005", 3, 2, 1)]);
    state(since, "0 705#05;1 705#05", &[("EXP015", 2, 0, 1)]);
    // A second boot-up begins anew; the last one counts.
    state(since, "0 705#00;4 705#00;5 705#05", &[]);
    state(since, "0 705#00;1 705#05;4 705#00;9 705#7F", &[("EXP005", 4, 3, 1)]);
    state(since, "0 705#00;1 705#05;4 705#00;5 705#7F", &[]);
}

#[test]
fn states_that_stay() {
    let stays = r#""state":"operational","stays":true"#;
    state(stays, "0 705#7F;1 705#05;2 705#05", &[]);
    state(stays, "0 705#05;1 705#7F;2 705#7F;3 705#05;4 705#04", &[("EXP006", 2, 0, 1), ("EXP006", 5, 0, 1)]);
    state(stays, "0 705#05;1 705#00;2 705#05", &[("EXP006", 2, 0, 1)]);
    // On each bus by itself.
    state(stays, "0 705#05;1 705#7F can1;2 705#05", &[]);
}

#[test]
fn drives() {
    let enabled = r#""drive":"operation-enabled""#;
    state(enabled, "0 185#40020000000000;1 185#37020000000000", &[]);
    state(enabled, "0 185#40020000000000;1 185#40020000000000", &[("EXP005", 2, 0, 1)]);
    state(enabled, "0 605#4041600000000000;0.1 585#4B41600037020000", &[]);
    // A value written to another object, or read from another node, is not a statusword.
    state(enabled, "0 606#4041600000000000;0.1 586#4B41600037020000", &[("EXP005", 2, 0, 1)]);
    let stays = r#""drive":"operation-enabled","stays":true,"by_ns":1000000000"#;
    state(stays, "0 185#40020000000000;1 185#37020000000000;2 185#18020000000000", &[("EXP006", 3, 0, 1)]);
    state(stays, "0 185#37020000000000;1 705#00;2 185#50020000000000", &[("EXP006", 2, 0, 1)]);
    state(stays, "0 185#40020000000000;2 185#37020000000000", &[("EXP005", 2, 0, 1)]);
    state(r#""drive":"fault","axis":2"#, "0 605#4041680000000000;0.1 585#4B41680008000000", &[]);
}

fn heartbeat(frames: &str, expected: &[(&str, u64, u64, u64)]) {
    check("heartbeat", &[r#""node":5,"period_ns":1000000000,"tolerance_ns":100000000"#], frames, expected);
}

#[test]
fn heartbeats() {
    heartbeat("0 705#05;1 705#05;2.1 705#05;3 705#05", &[]);
    heartbeat("0 705#05;1.2 705#05;2.2 705#05", &[("EXP009", 2, 1, 1)]);
    heartbeat("0 705#05;0.8 705#05;1.8 705#05", &[("EXP009", 2, 1, 1)]);
    // Another node in between; none; without timestamps.
    heartbeat("0 705#05;0.5 706#05;1 705#05;1.2 706#05", &[]);
    heartbeat("0 706#05;5 706#05", &[("EXP009", 2, 0, 1)]);
    heartbeat("- 705#05;- 705#05", &[("EXP015", 2, 0, 1)]);
    // A change of state may come between.
    heartbeat("0 705#7F;0.3 705#05;1 705#05;2 705#05", &[]);
    heartbeat("0 705#7F;0.3 705#05;1.3 705#05", &[]);
    heartbeat("0 705#7F;1.3 705#05", &[("EXP009", 2, 1, 1)]);
    // A boot-up begins anew, and so does a reset.
    heartbeat("0 705#05;5 705#00;5.1 705#7F;6.1 705#7F", &[]);
    heartbeat("0 705#05;0.5 000#8105;9 706#05", &[]);
    heartbeat("0 705#05;0.5 000#8106;9 706#05", &[("EXP009", 3, 1, 1)]);
    // Silence to the end counts, once; the end of an earlier capture does not.
    heartbeat("0 705#05;1 705#05;2.1 706#05", &[]);
    heartbeat("0 705#05;1 705#05;2.2 706#05;9 706#05", &[("EXP009", 4, 2, 1)]);
    // Each bus by itself.
    heartbeat("0 705#05;0.5 705#05 can1;1 705#05;1.5 705#05 can1;2 705#05", &[]);
    heartbeat("0 705#05;0.5 705#05 can1;1 705#05;2 705#05;2.5 705#05 can1", &[("EXP009", 5, 2, 1)]);
    // Guarding responses are not heartbeats.
    heartbeat("0 705#R1;0.1 705#85;2 705#R1;2.1 705#05", &[("EXP009", 4, 0, 1)]);
}

#[test]
fn gaps_and_live_silence() {
    let json = r#"{"file":"x","heartbeat":[{"line":1,"node":5,"period_ns":1000000000,"tolerance_ns":0}],
        "sync":[{"line":2,"period_ns":1000000000,"tolerance_ns":0}]}"#;
    let log = "(0.000000) can0 705#05\n(0.000000) can0 080#\n\
        DROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 3)\n\
        (5.000000) can0 705#05\n(5.000000) can0 080#\n";
    assert!(findings(json, log, Lang::En, 9).is_empty());
    let mut options = Options::of(Lang::Zh, &[Output::Rows(Rows::Frames, Encoding::Json)]);
    options.known.expectations = Some(Arc::new(Expectations::read(json).unwrap()));
    let mut session = Session::new(options);
    let mut out = Vec::new();
    let push = |session: &mut Session, id, now: Ns, bytes: &[u8], out: &mut Vec<u8>| {
        let mut frame = Frame::classic(CanId::standard(id), bytes);
        frame.t_ns = Some(now);
        session.push(frame, out);
    };
    push(&mut session, 0x705, Ns::ZERO, &[5], &mut out);
    push(&mut session, 0x080, Ns(200_000), &[], &mut out);
    session.advance(Ns(900_000_000), &mut out);
    session.advance(Ns(1_100_000_000), &mut out);
    session.advance(Ns(1_200_000_000), &mut out);
    push(&mut session, 0x705, Ns(1_300_000_000), &[5], &mut out);
    push(&mut session, 0x080, Ns(1_300_000_000), &[], &mut out);
    session.finish(&mut out);
    let text = String::from_utf8(out).unwrap();
    assert_eq!(text.matches("\"code\":\"EXP009\"").count(), 1, "{text}");
    assert_eq!(text.matches("\"code\":\"EXP010\"").count(), 1, "{text}");
}

#[test]
fn syncs() {
    let sync = |frames: &str, expected: &[(&str, u64, u64, u64)]| {
        check("sync", &[r#""period_ns":10000000,"tolerance_ns":1000000"#], frames, expected);
    };
    sync("0 080#;0.010 080#;0.0209 080#", &[]);
    sync("0 080#;0.010 080#;0.022 080#;0.032 080#", &[("EXP010", 3, 2, 1)]);
    sync("0 080#;0.005 080#;0.015 080#", &[("EXP010", 2, 1, 1)]);
    sync("0 705#05;1 705#05", &[("EXP010", 2, 0, 1)]);
    sync("0 080#;0.010 080#;1 705#05", &[("EXP010", 3, 2, 1)]);
    sync("- 080#;- 080#", &[("EXP015", 2, 0, 1)]);
    sync("0 080#;0.001 080# can1;0.010 080#;0.011 080# can1", &[]);
}

#[test]
fn emergencies() {
    let held = |entries: &[&str], frames: &str, expected: &[(&str, u64, u64, u64)]| {
        check("emcy", entries, frames, expected);
    };
    let (lost, reset, current) = ("1 085#3081110000000000", "2 085#0000000000000000", "3 085#1023020000000000");
    let never = r#""occurs":"never""#;
    held(&[never], &[lost, reset].join(";"), &[("EXP012", 1, 0, 1)]);
    held(&[r#""node":6,"occurs":"never""#], lost, &[]);
    // None but these.
    let may = r#""occurs":"may","code":[33024,65280]"#;
    held(&[never, may], &[lost, reset, current].join(";"), &[("EXP012", 3, 0, 1)]);
    // The more specific one counts.
    let never_exact = r#""occurs":"never","code":[33072,65535]"#;
    held(&[never_exact, may], lost, &[("EXP012", 1, 0, 1)]);
    held(&[r#""occurs":"never","code":[33024,65280]"#, r#""occurs":"may","code":[33072,65535]"#], lost, &[]);
    held(&[r#""occurs":"never","code":[0,65280]"#], &[lost, reset].join(";"), &[("EXP012", 2, 0, 1)]);
    let must = r#""occurs":"must","code":[33072,65535],"node":5"#;
    held(&[must, never], &[lost, reset].join(";"), &[]);
    held(&[must, never], current, &[("EXP012", 1, 0, 2), ("EXP011", 1, 0, 1)]);
    held(&[r#""occurs":"must""#], "1 705#05", &[("EXP011", 1, 0, 1)]);
    held(&[r#""occurs":"must","code":[33024,65280]"#], "- 705#05", &[("EXP011", 1, 0, 1)]);
}

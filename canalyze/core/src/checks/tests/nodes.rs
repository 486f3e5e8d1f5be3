//! What nodes may do without any finding, and where faults of theirs are named.

use super::{Raised, lines, log, raised, raised_with};
use crate::network::Network;

/// Heartbeats of a node every 100 ms, from and to in ms.
fn beats(id: &str, from: u32, to: u32, state: &str) -> String {
    (from..=to).step_by(100).map(|ms| format!("{ms} {id}#{state}\n")).collect()
}

/// Lines in the order of their times.
fn sorted(parts: &[&str]) -> String {
    let text = parts.concat();
    let mut rows: Vec<(f64, &str)> = text
        .lines()
        .map(str::trim)
        .filter(|line| !line.is_empty())
        .map(|line| (line.split_once(' ').unwrap().0.parse().unwrap(), line))
        .collect();
    rows.sort_by(|left, right| left.0.total_cmp(&right.0));
    let joined: Vec<&str> = rows.iter().map(|(_, line)| *line).collect();
    log(&joined.join("\n"))
}

fn codes(raised: &[Raised]) -> Vec<&str> {
    raised.iter().map(|(code, ..)| code.as_str()).collect()
}

/// The same without stamps.
fn plain(log: &str) -> String {
    log.lines().map(|line| format!("{}\n", line.split_once(") ").unwrap().1)).map(console).collect()
}

fn console(line: String) -> String {
    let (bus, frame) = line.trim().split_once(' ').unwrap();
    let (id, data) = frame.split_once('#').unwrap();
    let bytes: Vec<&str> = (0..data.len() / 2).map(|at| &data[2 * at..2 * at + 2]).collect();
    match data {
        "R" => format!("  {bus}  {id}   [0]  remote request\n"),
        _ => format!("  {bus}  {id}   [{}]  {}\n", bytes.len(), bytes.join(" ")),
    }
}

/// A managed node: its server has been asked.
const ASKED: &str = "0 605#4000100000000000\n0.4 585#4300100092010000\n";

#[test]
fn what_clean_networks_do() {
    let five = beats("705", 100, 900, "7F");
    let operational = beats("705", 1000, 1800, "05");
    for (what, parts) in [
        ("a slave that starts itself", vec![ASKED, "5 705#00\n", "105 705#05\n205 705#05\n305 705#05\n"]),
        (
            "a slave that shows Pre-operational once",
            vec![ASKED, "5 705#00\n105 705#7F\n205 705#05\n305 705#05\n405 705#05\n"],
        ),
        ("a master that starts itself in time", vec![&five, &operational, "950 185#01\n"]),
        ("a command", vec![ASKED, &five, "950 000#0105\n", &operational, "960 185#01\n"]),
        (
            "its late echo",
            vec![ASKED, &five, "950 705#05\n950.2 185#01\n953 000#0105\n", &beats("705", 1050, 1850, "05")],
        ),
        (
            "a late echo, and the reset's",
            vec![ASKED, "5 705#00\n", &five, "950 705#00\n952 000#8105\n", &beats("705", 1050, 1450, "7F")],
        ),
        ("two resets, two boot-ups", vec![ASKED, "5 705#00\n", "50 000#8100\n51 000#8200\n80 705#00\n120 705#00\n"]),
        ("extra heartbeats", vec![ASKED, &five, "930 000#0105\n931 705#05\n", &operational]),
        (
            "a stop with frames in flight",
            vec![
                ASKED,
                &beats("705", 100, 900, "05"),
                "950 000#0205\n951 185#01\n952 085#1081110000000000\n953 585#4300100092010000\n",
                &beats("705", 1000, 1400, "04"),
            ],
        ),
        (
            "a reset without a boot-up yet",
            vec![ASKED, &five, "950 000#8205\n5000 605#4000100000000000\n5000.4 585#4300100092010000\n"],
        ),
        (
            "1017h = 0",
            vec![
                ASKED,
                &five,
                "910 605#2B17100000000000\n910.5 585#6017100000000000\n9000 605#4000100000000000\n9000.4 585#4300100092010000\n",
            ],
        ),
        (
            "a longer period",
            vec![
                &five,
                "910 605#2B171000F4010000\n910.5 585#6017100000000000\n1400 705#7F\n1900 705#7F\n2400 705#7F\n2900 705#7F\n",
            ],
        ),
        (
            "a node-ID by LSS",
            vec![
                ASKED,
                "5 705#00\n50 7E5#1106000000000000\n51 7E4#1100000000000000\n60 000#8205\n90 706#00\n\
             100 7E5#1105000000000000\n101 7E4#1100000000000000\n110 000#8206\n140 705#00\n\
             150 7E5#1106000000000000\n151 7E4#1100000000000000\n160 000#8205\n190 706#00\n",
            ],
        ),
        ("guarding", vec![ASKED, "100 705#R\n101 705#7F\n200 705#R\n201 705#FF\n300 705#R\n301 705#7F\n"]),
        (
            "guarding whose requests are not captured",
            vec![ASKED, "101 705#7F\n201 705#FF\n301 705#7F\n401 705#FF\n501 705#7F\n"],
        ),
        (
            "guarding whose requests are captured late",
            vec![
                ASKED,
                "101 705#7F\n102 705#R\n201 705#FF\n202 705#R\n301 705#7F\n302 705#R\n401 705#FF\n402 705#R\n501 705#7F\n502 705#R\n3000 080#\n",
            ],
        ),
        ("an unknown node that is guarded", vec![ASKED, "100 709#R\n200 709#R\n1300 709#R\n2500 080#\n"]),
        ("sleep and standby", vec![ASKED, "100 000#5005\n200 000#6000\n"]),
        ("midnight", vec!["10 100#FF5B26059E39\n1010 100#E70300009F39\n"]),
    ] {
        let capture = sorted(&parts);
        assert_eq!(raised(&capture), [], "{what}");
        let nothing = plain(&capture);
        assert_eq!(raised(&nothing), [], "{what}, without stamps");
        let count = capture.lines().count();
        for start in 0..count {
            let rest: String = capture.lines().skip(start).map(|line| format!("{line}\n")).collect();
            // A capture that begins just after a request misses its half; that is not what is asked here.
            let said: Vec<_> = raised(&rest).into_iter().filter(|(code, ..)| !code.starts_with("SDO00")).collect();
            assert_eq!(said, [], "{what}, from line {start}");
        }
    }
}

#[test]
fn a_silent_bus_is_not_many_lost_nodes() {
    let both = |from, to| [beats("705", from, to, "05"), beats("706", from + 10, to + 10, "05")].concat();
    assert_eq!(raised(&sorted(&[&both(100, 900), &both(5000, 5500)])), []);
    // Who does not come back is lost all the same.
    let one = sorted(&[&both(100, 900), &beats("705", 5000, 6000, "05")]);
    let said = raised(&one);
    assert_eq!(codes(&said), ["HBT002"]);
    assert_eq!(raised_with(&one, Network::default(), &["info"]).len(), 1);
}

#[test]
fn a_bus_that_was_switched_off_boots_again() {
    let (before, after) = (beats("705", 100, 900, "7F"), beats("705", 60100, 60500, "7F"));
    assert_eq!(raised(&sorted(&[ASKED, "5 705#00\n", &before, "60000 705#00\n", &after])), []);
}

#[test]
fn a_lost_node_is_said_once_and_may_come_back() {
    let log = sorted(&[&beats("705", 100, 900, "05"), &beats("706", 120, 4000, "05"), &beats("705", 3000, 4000, "05")]);
    let said = raised(&log);
    assert_eq!(codes(&said), ["HBT002"]);
    // At the first frame after three periods and the tolerance, about the last heartbeat.
    assert_eq!(said, [("HBT002".into(), 22, Some(17))]);
}

#[test]
fn lost_frames_make_no_faults() {
    let before = sorted(&[ASKED, "5 705#00\n", &beats("705", 100, 900, "05")]);
    let after = sorted(&[&beats("705", 1000, 1400, "7F"), "1450 705#00\n1500 185#01\n"]);
    let gap = "DROPCOUNT: dropped 5 CAN frames on 'can0' socket (total drops 5)\n";
    let all = lines(&[before.as_str(), gap, after.as_str()].concat(), Network::default());
    let said: Vec<_> = all.iter().filter(|line| line["kind"] == "finding" && line["severity"] != "info").collect();
    assert!(said.iter().all(|line| line["code"] == "CAP002" || line["code"] == "NMT003"), "{said:?}");
}

#[test]
fn stamps_that_step_back_are_no_fault() {
    let log = sorted(&[ASKED, &beats("705", 1000, 1900, "05")]);
    let again = sorted(&[&beats("705", 100, 900, "05")]);
    assert_eq!(raised(&[log, again].concat()), []);
}

#[test]
fn two_buses_have_nodes_of_their_own() {
    let one = sorted(&[ASKED, "5 705#00\n", &beats("705", 100, 900, "05")]);
    let other = sorted(&[&beats("705", 120, 920, "7F"), "300 705#00\n"]).replace("can0", "can1");
    let mut rows: Vec<&str> = one.lines().chain(other.lines()).collect();
    rows.sort_unstable();
    let said = raised(&rows.join("\n"));
    assert!(said.iter().all(|(code, ..)| code == "NMT003" || code == "HBT001"), "{said:?}");
}

#[test]
fn pdos_outside_operational() {
    let beats = beats("705", 100, 900, "7F");
    let said = raised(&sorted(&[ASKED, &beats, "450 185#01\n"]));
    assert_eq!(said, [("PDO002".into(), 8, Some(7))]);
    // A node that nobody commands or configures may have started itself: its next heartbeat decides.
    let said = raised(&sorted(&[&beats, "450 185#01\n"]));
    assert_eq!(said, [("PDO002".into(), 6, Some(5))]);
    let said = raised(&sorted(&[ASKED, "5 705#00\n10 000#8005\n200 185#01\n300 080#\n"]));
    assert_eq!(codes(&said), ["PDO002"], "commanded, and known to be there");
    assert_eq!(raised(&sorted(&["10 000#8005\n200 185#01\n300 080#\n"])), [], "never seen");
}

#[test]
fn states_of_pdos_and_heartbeats() {
    let log = sorted(&[ASKED, "5 705#00\n", "100 705#7F\n", "150 000#0105\n", "160 185#01\n", "200 705#05\n"]);
    let lines = lines(&log, Network::default());
    let frame = |no: u64| lines.iter().find(|line| line["kind"] == "frame" && line["frame"] == no).unwrap();
    assert_eq!(frame(6)["pdo"]["state"], "05");
    assert_eq!(frame(4)["heartbeat"]["previous"], serde_json::Value::Null);
    assert_eq!(frame(7)["heartbeat"]["previous"], "7F");
    assert_eq!(frame(7)["heartbeat"]["changed"], true);
}

#[test]
fn errors_that_are_active() {
    let emergencies =
        "10 085#1081110000000000\n20 085#1032150000000000\n30 085#0000110000000000\n40 085#0000000000000000\n";
    let lines = lines(&sorted(&[emergencies]), Network::default());
    let emcy = |no: u64| &lines.iter().find(|line| line["kind"] == "frame" && line["frame"] == no).unwrap()["emcy"];
    assert_eq!(emcy(2)["active"], serde_json::json!(["8110", "3210"]));
    assert_eq!(emcy(3)["active"], serde_json::json!(["8110", "3210"]), "which one went, nothing tells");
    assert_eq!(emcy(4)["active"], serde_json::json!([]));
    assert_eq!(emcy(4)["cleared"], serde_json::json!(["8110", "3210"]));
}

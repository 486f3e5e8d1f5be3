//! Correct behaviour of nodes, and the frames at which faults are reported.

use super::{Raised, lines, log, raised, raised_with};
use crate::world::network::Network;

/// Returns heartbeats of a node every 100 ms, from and to in ms.
fn beats(id: &str, from: u32, to: u32, state: &str) -> String {
    (from..=to).step_by(100).map(|ms| format!("{ms} {id}#{state}\n")).collect()
}

/// Sorts lines by time.
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
                "949 605#4000100000000000\n950 000#0205\n951 185#01\n952 085#0000000000000000\n953 585#4300100092010000\n",
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
            // A capture that begins just after a request lacks its half, which is not tested here.
            let said: Vec<_> = raised(&rest).into_iter().filter(|(code, ..)| !code.starts_with("SDO00")).collect();
            assert_eq!(said, [], "{what}, from line {start}");
        }
    }
}

#[test]
fn a_silent_bus_is_not_many_lost_nodes() {
    let both = |from, to| [beats("705", from, to, "05"), beats("706", from + 10, to + 10, "05")].concat();
    assert_eq!(raised(&sorted(&[&both(100, 900), &both(5000, 5500)])), []);
    // A node that does not return is still lost.
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
fn stamps_that_step_back_are_no_fault_of_a_node() {
    let log = sorted(&[ASKED, &beats("705", 1000, 1900, "05")]);
    let again = sorted(&[&beats("705", 100, 900, "05")]);
    // The step itself is the capture's.
    assert_eq!(codes(&raised(&[log, again].concat())), ["CAP006"]);
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
    assert_eq!(said, [("PDO002".into(), 7, None)]);
    // A node without commands and configuration may have started itself: its next heartbeat decides.
    let said = raised(&sorted(&[&beats, "450 185#01\n"]));
    assert_eq!(said, [("PDO002".into(), 5, None)]);
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

/// Frames every `step` ms from `from` to `to` in a recording that pauses during `stall` and lists the frames of that time
/// at its end, at once.
fn kept_back(id: &str, times: (u32, u32, u32), data: &str, stall: (u32, u32)) -> String {
    let (from, to, step) = times;
    let late =
        |ms: u32| if (stall.0..stall.1).contains(&ms) { f64::from(stall.1) + f64::from(ms) / 1e4 } else { ms.into() };
    (from..=to).step_by(step as usize).map(|ms| format!("{} {id}#{data}\n", late(ms))).collect()
}

#[test]
fn a_recording_that_stood_still_is_no_late_node() {
    for stall in [(1203, 1373), (1203, 1611), (1299, 1790)] {
        let nodes: String = ["705", "706", "707"]
            .iter()
            .zip([0, 31, 57])
            .map(|(id, phase)| kept_back(id, (100 + phase, 3000, 100), "05", stall))
            .collect();
        let fast = kept_back("708", (50, 3000, 10), "05", stall);
        let sync = kept_back("080", (95, 3000, 10), "", stall);
        for parts in [vec![nodes.as_str()], vec![&nodes, &sync], vec![&nodes, &fast, &sync], vec![&fast, &sync]] {
            let said = raised(&sorted(&parts));
            let said: Vec<_> = said.iter().filter(|(code, ..)| !code.starts_with("SYN")).collect();
            assert!(said.is_empty(), "{stall:?} {said:?}");
        }
    }
    // One late or absent node of several is still named.
    let others = [beats("706", 131, 3031, "05"), beats("707", 157, 3057, "05")].concat();
    let late = [&beats("705", 100, 1200, "05"), "1365 705#05\n", &beats("705", 1400, 3000, "05"), &others];
    assert_eq!(codes(&raised(&sorted(&late))), ["HBT001"]);
    assert_eq!(codes(&raised(&sorted(&[&beats("705", 100, 1200, "05"), &others]))), ["HBT002"]);
}

#[test]
fn stamps_of_a_loaded_host() {
    // Every fifth heartbeat of 50 ms is stamped 18 ms late.
    let shaken = |ms: u32| if ms.is_multiple_of(250) { ms + 18 } else { ms };
    let beats: String = (100..=4000).step_by(50).map(|ms| format!("{} 705#05\n", shaken(ms))).collect();
    assert_eq!(raised(&sorted(&[&beats])), []);
    // Every other heartbeat of 10 ms is stamped 5 ms late: one series.
    let beats: String = (10..=400).map(|one| format!("{} 705#05\n", one * 10 + one % 2 * 5)).collect();
    assert_eq!(raised(&sorted(&[&beats])), []);
}

#[test]
fn frames_captured_twice() {
    let guarded =
        "1600 705#R\n1601 705#7F\n1800 705#R\n1801 705#FF\n2000 705#R\n2001 705#7F\n2200 705#R\n2201 705#FF\n";
    let heard = beats("706", 100, 3000, "7F");
    let parts = ["5 705#00\n6 706#00\n", ASKED, guarded, &heard, "1500 000#8107\n1550 707#00\n"];
    let twice = |log: String| -> String {
        log.lines().map(|line| format!("{line}\n{}\n", line.replacen("000) ", "011) ", 1))).collect()
    };
    assert_eq!(raised(&twice(sorted(&parts))), []);
    let restarted = [&parts[..], &["1620 706#00\n"]].concat();
    assert_eq!(codes(&raised(&twice(sorted(&restarted)))), ["NMT003"]);
    // Two nodes: nothing else is there twice.
    let pair = [&parts[..], &["1552 707#00\n"]].concat();
    assert_eq!(codes(&raised(&sorted(&pair))), ["HBT004"]);
}

#[test]
fn a_command_that_failed_is_one_fault() {
    // The node goes on as before: its frames are correct, the command failed.
    let parts = [
        ASKED,
        &beats("705", 100, 1900, "05"),
        "930 000#0205\n985 185#01\n990 605#4000100000000000\n991 585#4300100092010000\n",
    ];
    assert_eq!(codes(&raised(&sorted(&parts))), ["NMT002"]);
    // It obeys, and sends nevertheless.
    let parts = [ASKED, &beats("705", 100, 900, "05"), "930 000#0205\n985 185#01\n", &beats("705", 1000, 1900, "04")];
    assert_eq!(raised(&sorted(&parts)), [("PDO002".into(), 13, None)]);
}

#[test]
fn boot_ups_and_resets_that_cross() {
    // The node was booting when the reset came, and boots again.
    let parts =
        ["10 706#00\n", ASKED, "100 000#8200\n100.2 705#00\n156 705#00\n160 706#00\n", &beats("705", 200, 900, "7F")];
    assert_eq!(raised(&sorted(&parts)), []);
    // A reset, captured late, to a node that was still resetting.
    let parts = [ASKED, "50 705#00\n", "100 000#8105\n200 705#00\n200.2 000#8205\n", &beats("705", 300, 1900, "7F")];
    assert_eq!(raised(&sorted(&parts)), []);
    // Without stamps an answer after the reset may have been sent before it was obeyed.
    let parts =
        [ASKED, "50 705#00\n", "100 000#8105\n100.2 605#4000100000000000\n100.6 585#4300100092010000\n900 705#00\n"];
    assert_eq!(raised(&plain(&sorted(&parts))), []);
}

#[test]
fn a_network_that_is_switched_on_takes_its_time() {
    let before = [beats("705", 100, 2000, "05"), beats("706", 130, 2030, "05"), beats("707", 160, 2060, "05")].concat();
    let boots = "5 705#00\n6 706#00\n7 707#00\n";
    let after = [
        "5000 705#00\n",
        &beats("705", 5100, 9000, "7F"),
        "5300 706#00\n6400 707#00\n",
        &beats("706", 5400, 9000, "7F"),
        &beats("707", 6500, 9000, "7F"),
    ]
    .concat();
    assert_eq!(raised(&sorted(&[boots, &before, &after])), []);
    // One that does not return is lost.
    let after =
        ["5000 705#00\n", &beats("705", 5100, 15000, "7F"), "5300 706#00\n", &beats("706", 5400, 15000, "7F")].concat();
    assert_eq!(codes(&raised(&sorted(&[boots, &before, &after]))), ["HBT002"]);
}

#[test]
fn guarding_without_stamps_and_with_late_echoes() {
    let parts = [
        ASKED,
        "5 705#00\n600 705#R\n",
        "800 705#7F\n801 705#R\n1000 705#FF\n1001 705#R\n1200 705#R\n1201 705#7F\n1400 705#FF\n1401 705#R\n",
    ];
    assert_eq!(raised(&plain(&sorted(&parts))), []);
    // After heartbeats that have ended; the request whose answer confirms 1017h = 0 is unknown.
    let parts = [
        "5 705#00\n6 585#6017100000000000\n7 605#2B17100064000000\n",
        &beats("705", 100, 500, "7F"),
        "600 585#6017100000000000\n601 605#2B17100000000000\n602 585#600C100000000000\n603 605#2B0C100064000000\n",
        "700 705#7F\n701 705#R\n800 705#FF\n801 705#R\n900 705#7F\n901 705#R\n1000 705#FF\n1001 705#R\n",
        "1100 705#7F\n1101 705#R\n1200 705#FF\n1201 705#R\n1300 705#7F\n1301 705#R\n",
    ];
    assert_eq!(raised(&plain(&sorted(&parts))), []);
}

#[test]
fn heartbeats_centuries_apart() {
    let beats: String =
        (0..12).map(|n| format!("({}.000000) can0 705#05\n", if n % 2 == 0 { 1 } else { 9_200_000_000_u64 })).collect();
    raised(&beats);
    let mut forth = String::new();
    for n in 0..4_u64 {
        forth += &format!("({}.000000) can0 705#05\n", n * 3_000_000_000);
    }
    raised(&forth);
}

#[test]
fn a_pdo_before_the_node_shows_that_it_has_just_changed_its_state() {
    let before = beats("705", 100, 900, "05");
    for ms in [6, 10, 20, 45] {
        let pdo = format!("910 000#8005\n{} 185#01\n", 910 + ms);
        let at_once = 911 + ms;
        let prompt = beats("705", at_once, at_once + 400, "7F");
        assert_eq!(raised(&sorted(&[ASKED, &before, &pdo, &prompt])), [], "{ms} ms");
        // It is a fault after that heartbeat, and if the node shows its state only in turn.
        let after = format!("{}.5 185#01\n", at_once + 5);
        assert_eq!(codes(&raised(&sorted(&[ASKED, &before, &pdo, &prompt, &after]))), ["PDO002"], "{ms} ms");
        let in_turn = beats("705", 1000, 1400, "7F");
        assert_eq!(codes(&raised(&sorted(&[ASKED, &before, &pdo, &in_turn]))), ["PDO002"], "{ms} ms");
    }
}

#[test]
fn a_reset_without_boot_up() {
    let others = beats("706", 50, 5050, "7F");
    let before = beats("705", 100, 900, "7F");
    for (command, started_after) in [("81", 100), ("82", 300), ("81", 800)] {
        let start = 950 + started_after;
        let commands = format!("950 000#{command}05\n{start} 000#0105\n");
        let pre_operational = beats("705", 1000, start, "7F");
        let operational = beats("705", (start / 100 + 1) * 100, 5000, "05");
        let text = sorted(&[ASKED, &others, &before, &commands, &pre_operational, &operational]);
        assert_eq!(codes(&raised(&text)), ["NMT006"], "started after {started_after} ms");
    }
    // A device may boot for two seconds, and send a frame while obeying.
    for boots_after in [20, 200, 1_000, 2_000] {
        let boot_up = 950 + boots_after;
        let parts = format!("950 000#8105\n951 705#7F\n{boot_up} 705#00\n");
        let after = beats("705", boot_up + 100, 5000, "7F");
        assert_eq!(raised(&sorted(&[ASKED, &others, &before, &parts, &after])), [], "boot-up after {boots_after} ms");
    }
}

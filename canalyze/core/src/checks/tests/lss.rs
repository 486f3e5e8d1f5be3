//! Findings on LSS: captures that are cut, late, lossy or without stamps raise nothing that they do not show.

use super::{lines, log, raised, raised_with};
use crate::world::network::Network;

const SDO: &str = "0 60A#4002200000000000\n0.4 58A#4F0220005A000000\n";

/// Both slaves' numbers of python-canopen's recorded scan.
const FASTSCAN: &str = include_str!("../../../../../samples/lss-fastscan.log");
const STACK: &str = include_str!("../../../../../samples/stacks/d2-lss-selective.log");

/// A commissioning of one slave, as masters do it.
const SESSION: &str = "
    1 7E5#0400000000000000
    2 7E5#4078563412000000
    2.5 7E5#41DDCCBBAA000000
    3 7E5#4202000100000000
    3.5 7E5#4399000000000000
    4 7E4#4400000000000000
    20 7E5#5E00000000000000
    20.5 7E4#5E07000000000000
    30 7E5#5D00000000000000
    30.5 7E4#5D99000000000000
    40 7E5#1119000000000000
    40.5 7E4#1100000000000000
    50 7E5#1700000000000000
    50.5 7E4#1700000000000000
    60 7E5#0400000000000000
    70 000#8207
    71 719#00
    80 7E5#0401000000000000
    81 7E5#1300020000000000
    81.5 7E4#1300000000000000
    81.6 7E4#1300000000000000
    90 7E5#1564000000000000
    ";

fn session() -> String {
    log(SESSION)
}

/// Returns the codes of all findings of any severity.
fn all(log: &str) -> Vec<String> {
    let found = raised_with(log, Network::default(), &["info", "warning", "error"]);
    found.into_iter().map(|(code, _, _)| code).collect()
}

fn notes(log: &str) -> Vec<(String, u64, serde_json::Value)> {
    let lines = lines(log, Network::default());
    let notes = lines.iter().filter(|line| line["kind"] == "note");
    notes
        .map(|line| (line["note"].as_str().unwrap().into(), line["frame"].as_u64().unwrap(), line["facts"].clone()))
        .collect()
}

fn without_stamps(log: &str) -> String {
    log.lines().filter_map(|line| line.split_once(") can0 ")).map(|(_, frame)| format!("can0 {frame}\n")).collect()
}

/// Delays the master's frames by one, as in captures on its own host.
fn late(log: &str, every: usize) -> String {
    let mut frames: Vec<&str> = log.lines().filter(|line| !line.starts_with('#')).collect();
    let mut place = 0;
    let mut count = 0;
    while place + 1 < frames.len() {
        let time = |line: &str| line[1..18].parse::<f64>().unwrap();
        let near = time(frames[place + 1]) - time(frames[place]) < 0.004;
        if frames[place].contains(" 7E5#") && !frames[place + 1].contains(" 7E5#") && near {
            count += 1;
            if count % every == 0 {
                frames.swap(place, place + 1);
                place += 1;
            }
        }
        place += 1;
    }
    // The stamp belongs to the place in the capture, not to the frame.
    let mut stamps: Vec<&str> = frames.iter().map(|line| line.split_once(' ').unwrap().0).collect();
    stamps.sort_unstable();
    let rest = frames.iter().map(|line| line.split_once(' ').unwrap().1);
    stamps.iter().zip(rest).map(|(stamp, frame)| format!("{stamp} {frame}\n")).collect()
}

#[test]
fn cut_anywhere() {
    for whole in [session(), FASTSCAN.into(), STACK.into()] {
        let frames: Vec<&str> = whole.lines().filter(|line| !line.starts_with('#')).collect();
        let steps = 1 + frames.len() / 60;
        for cut in (0..frames.len()).step_by(steps) {
            for part in [&frames[cut..], &frames[..cut]] {
                let part: String = part.iter().map(|line| format!("{line}\n")).collect();
                assert_eq!(raised(&part), [], "{cut}: {part}");
                assert_eq!(raised(&without_stamps(&part)), [], "{cut}: {part}");
            }
        }
    }
}

#[test]
fn late_frames_of_the_master() {
    for whole in [session(), FASTSCAN.into(), STACK.into()] {
        for every in 1..5 {
            let late = late(&whole, every);
            assert_ne!(late, whole);
            assert_eq!(raised(&late), [], "{every}: {late}");
            assert_eq!(raised(&without_stamps(&late)), [], "{every}: {late}");
            let names = |log: &str| notes(log).into_iter().map(|(name, _, facts)| (name, facts["serial"].clone()));
            let found = |log: &str| names(log).filter(|(name, _)| name == "fastscan_found").collect::<Vec<_>>();
            assert_eq!(found(&late), found(&whole), "{every}: {late}");
        }
    }
}

#[test]
fn lost_frames() {
    for whole in [session(), STACK.replace("vcan0", "can0")] {
        let drop = "DROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 3)\n";
        let frames: Vec<&str> = whole.lines().collect();
        for from in 0..frames.len() {
            for to in from..frames.len().min(from + 6) {
                let head = frames[..from].iter().map(|line| format!("{line}\n"));
                let rest = frames[to..].iter().map(|line| format!("{line}\n"));
                let log: String = head.chain([drop.to_owned()]).chain(rest).collect();
                let lines = lines(&log, Network::default());
                let judged = |line: &&serde_json::Value| line["severity"] == "warning" && line["code"] != "CAP002";
                assert_eq!(lines.iter().find(judged), None, "{from}..{to}: {log}");
            }
        }
    }
}

#[test]
fn a_scan_is_one_action() {
    let notes = notes(FASTSCAN);
    let found: Vec<_> = notes.iter().filter(|(name, _, _)| name == "fastscan_found").collect();
    assert_eq!(found.len(), 2);
    for ((_, _, facts), serial) in found.iter().zip(["00000003", "00000077"]) {
        assert_eq!(facts["vendor"], "00000001");
        assert_eq!(facts["product"], "00000002");
        assert_eq!(facts["revision"], "80000000");
        assert_eq!(facts["serial"], serial);
        assert_eq!(facts["requests"], 133);
    }
    assert_eq!(notes.len(), 2, "that nobody is left is said by the frame itself: {notes:?}");
    assert_eq!(all(FASTSCAN), Vec::<String>::new());
}

#[test]
fn a_scan_that_breaks_off_is_incomplete() {
    let frames: Vec<&str> = FASTSCAN.lines().filter(|line| line.contains(" 7E")).take(120).collect();
    let part: String = frames.iter().map(|line| format!("{line}\n")).collect();
    let notes = notes(&part);
    assert_eq!(notes.len(), 1);
    assert_eq!(notes[0].0, "fastscan_incomplete");
    assert_eq!((&notes[0].2["vendor"], &notes[0].2["serial"]), (&"00000001".into(), &serde_json::Value::Null));
}

#[test]
fn a_node_with_another_node_id() {
    let notes = notes(STACK);
    let names: Vec<_> = notes.iter().map(|(name, frame, _)| (name.as_str(), *frame)).collect();
    assert_eq!(names, [("lss_selected", 10), ("node_id_changed", 21), ("lss_selected", 34)]);
    assert_eq!(notes[1].2, serde_json::json!({"from": 7, "to": 25}));
    assert_eq!(all(STACK), ["LSS012"]);
}

/// The configuration moves with the node: its mapping by $NODEID, not the COB-ID it was seen with.
#[test]
fn the_configuration_follows_the_node() {
    let before = "
        1 607#4000180100000000
        1.4 587#4300180187010000
        2 607#40001A0000000000
        2.4 587#4F001A0001000000
        3 607#40001A0100000000
        3.4 587#43001A0110004160
        4 187#3702
        ";
    let log = log(&format!("{before}{}\n100 199#3702", SESSION.lines().take(18).collect::<Vec<_>>().join("\n")));
    let lines = lines(&log, Network::default());
    let pdos: Vec<_> = lines.iter().filter(|line| line["service"] == "pdo").collect();
    assert_eq!(pdos.len(), 2);
    for (pdo, node) in pdos.iter().zip([7, 25]) {
        assert_eq!(pdo["node"], node);
        assert_eq!(pdo["pdo"]["signals"][0]["index"], "6041", "{pdo}");
    }
}

#[test]
fn identity_names_the_old_node() {
    let read = "
        0.1 607#4018100100000000
        0.2 587#4318100178563412
        0.3 607#4018100200000000
        0.4 587#43181002DDCCBBAA
        0.5 607#4018100300000000
        0.6 587#4318100302000100
        0.7 607#4018100400000000
        0.8 587#4318100499000000
        ";
    let asked = SESSION.lines().take(18).filter(|line| !line.contains("#5E")).collect::<Vec<_>>().join("\n");
    let names = |log: &str| notes(log).into_iter().map(|(name, _, _)| name).collect::<Vec<_>>();
    assert_eq!(names(&log(&format!("{read}{asked}"))), ["lss_selected", "node_id_changed"]);
    // It is that of the only node that was reset since and did not boot; a reset of all shows nothing.
    assert_eq!(names(&log(&asked)), ["lss_selected", "node_id_changed"]);
    assert_eq!(names(&log(&asked.replace("000#8207", "000#8200"))), ["lss_selected"], "which node it was is unknown");
    assert_eq!(names(&log(&asked.replace("71 719#00", "70.5 707#00\n71 719#00"))), ["lss_selected"]);
}

#[test]
fn several_may_answer() {
    // All slaves accept a bit timing that is given to all of them, and every slave without node-ID says so.
    let log = log(&format!(
        "{SDO}
        1 7E5#0401000000000000
        2 7E5#5E00000000000000
        2.4 7E4#5E07000000000000
        10 7E5#1300020000000000
        10.4 7E4#1300000000000000
        10.8 7E4#1300000000000000
        20 7E5#1700000000000000
        20.4 7E4#1700000000000000
        20.8 7E4#1700000000000000
        30 7E5#4C00000000000000
        30.4 7E4#5000000000000000
        30.8 7E4#5000000000000000
        40 7E5#0400000000000000
        "
    ));
    assert_eq!(all(&log), Vec::<String>::new());
}

#[test]
fn a_reset_slave_owes_nothing() {
    let answered = "1 7E5#0401000000000000\n2 7E5#5E00000000000000\n2.4 7E4#5E07000000000000\n";
    let waiting = "3 7E5#0400000000000000\n";
    let selected = "4 7E5#4078563412000000\n5 7E5#41DDCCBBAA000000\n6 7E5#4202000100000000\n7 7E5#4399000000000000\n8 7E4#4400000000000000\n";
    let asked = "20 7E5#5A00000000000000\n";
    let later = "3000 60A#4002200000000000\n3000.4 58A#4F0220005A000000\n";
    let whole = |between: &str| log(&format!("{answered}{waiting}{selected}{between}{asked}{later}"));
    assert_eq!(raised(&whole("")), [("LSS009".to_owned(), 11, Some(10))]);
    assert_eq!(raised(&whole("10 70A#00\n")), []);
    assert_eq!(raised(&whole("10 000#8200\n")), []);
}

#[test]
fn what_is_no_lss_is_not_judged() {
    let counter: String = (0..200).map(|n| format!("{n} 7E{}#{n:02X}55{n:02X}AA00000000\n", 4 + n % 2)).collect();
    assert_eq!(raised(&log(&counter)), []);
    assert_eq!(all(&log(&counter)), ["BUS009"]);
    let beside = format!("{}300 605#4000100000000000\n301 585#4300100092010000\n", counter);
    assert_eq!(all(&log(&beside)), ["LSS030"], "CANopen is on the bus");
    let requests = SESSION.lines().filter(|line| line.contains("7E5") && !line.contains("#15"));
    let requests: String = requests.map(|line| format!("{line}\n")).collect();
    assert_eq!(raised(&log(&requests)), [], "only the master's frames were captured");
}

#[test]
fn error_frames_do_not_break_the_silence() {
    let log = format!("{}(1700000000.190000) can0 20000004#0008000000006000\n", session());
    assert_eq!(raised(&log), []);
    let log = format!("{log}(1700000000.200000) can0 185#0102\n");
    let frame = log.lines().count() as u64;
    assert_eq!(raised(&log), [("LSS008".to_owned(), frame, Some(frame - 2))]);
}

#[test]
fn stamps_that_step_back() {
    let frames = session();
    let mut reversed: Vec<&str> = frames.lines().collect();
    reversed.reverse();
    let log: String = reversed.iter().map(|line| format!("{line}\n")).collect();
    let _ = raised(&log);
}

#[test]
fn an_address_captured_twice() {
    let twice: String =
        session().lines().map(|line| format!("{line}\n{}\n", line.replacen("00) can0", "11) can0", 1))).collect();
    let said = raised(&twice);
    assert!(said.iter().all(|(code, ..)| code != "LSS011"), "{said:?}");
}

#[test]
fn an_answer_captured_twice_is_not_the_next_ones() {
    let head = "1 7E5#0401000000000000\n10 7E5#5E00000000000000\n10.4 7E4#5E28000000000000\n";
    let given = "12 7E5#1129000000000000\n12.4 7E4#1100000000000000\n";
    let double = "12.46 7E4#1100000000000000\n";
    let refused = "14 7E5#11C8000000000000\n14.4 7E4#1101000000000000\n";
    let tail = "16 7E5#1700000000000000\n16.4 7E4#1700000000000000\n18 7E5#0400000000000000\n";
    let refusal = |frame| ("LSS004".to_owned(), frame, Some(frame - 1));
    assert_eq!(raised(&log(&format!("{head}{given}{refused}{tail}"))), [refusal(7)]);
    let said = raised(&log(&format!("{head}{given}{double}{refused}{tail}")));
    assert_eq!(said, [("LSS007".to_owned(), 8, Some(6)), refusal(8)]);
    // Captured on the master's host, the second request is listed after its answer.
    let late = "14 7E5#1129000000000000\n";
    assert_eq!(raised(&log(&format!("{head}{given}{double}{late}{tail}"))), []);
    let late_refusal = format!("{head}{given}{double}{late}").replace("#1100", "#1101");
    let said = raised(&log(&format!("{late_refusal}{tail}")));
    assert_eq!(said, [refusal(5), ("LSS004".to_owned(), 8, Some(7))]);
}

#[test]
fn a_switch_that_cannot_be_read_may_have_selected() {
    for switch in ["7E5#0C01000000000000", "7E5#0401000000", "7E5#0401000000000000"] {
        let said = raised(&log(&format!(
            "1 7E5#0400000000000000\n5 {switch}\n10 7E5#5E00000000000000\n10.4 7E4#5E28000000000000\n20 7E5#0400000000000000\n"
        )));
        assert!(said.iter().all(|(code, frame, _)| code == "LSS001" && *frame == 2), "{switch}: {said:?}");
    }
}

#[test]
fn a_frame_of_the_other_side_is_one_finding() {
    let lines: Vec<&str> = STACK.lines().collect();
    for (number, line) in lines.iter().enumerate().filter(|(_, line)| line.contains(" 7E")) {
        let other = if line.contains("7E5#") { line.replace("7E5#", "7E4#") } else { line.replace("7E4#", "7E5#") };
        let changed: Vec<&str> = (0..lines.len()).map(|at| if at == number { &other } else { lines[at] }).collect();
        let said = raised(&(changed.join("\n") + "\n"));
        assert!(said.len() <= 1, "frame {}: {said:?}", number + 1);
    }
}

#[test]
fn parts_of_an_address_out_of_turn_are_one_finding() {
    let part = |ms: u32, part: &str| format!("{ms} 7E5#{part}00000000\n");
    let parts = ["40785634", "41DDCCBB", "42020001", "43990000"];
    for order in [[1, 0, 2, 3], [0, 2, 1, 3], [0, 1, 1, 3], [0, 0, 2, 3]] {
        let address: String = (0..).zip(order).map(|(at, number)| part(200 + 20 * at, parts[number])).collect();
        let said = raised(&log(&(SESSION.to_owned() + &address + "300 7E5#0400000000000000\n")));
        assert_eq!(said.iter().filter(|(code, ..)| code == "LSS011").count(), 1, "{order:?}: {said:?}");
    }
}

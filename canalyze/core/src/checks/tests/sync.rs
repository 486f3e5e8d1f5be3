//! SYNC and synchronous PDOs: captures of correct networks raise nothing, and single faults are found at their frame.

use super::{Raised, lines, log, raised, raised_with};
use crate::bytes::ns::Ns;
use crate::world::network::Network;

/// TPDO1 of node 5 has type 1, TPDO2 type 2, TPDO1 of node 6 type 3; then all nodes are started.
const CONFIGURED: &str = "
    0.4 605#2F00180201000000
    0.8 585#6000180200000000
    1.2 605#2F01180202000000
    1.6 585#6001180200000000
    2.0 606#2F00180203000000
    2.4 586#6000180200000000
    2.8 000#0100
";
/// Frames of [`CONFIGURED`].
const BEFORE: u64 = 7;

/// Returns the frames of the `cycle`-th SYNC at `ms`: the SYNC, then the PDOs due.
fn cycle(cycle: u64, ms: f64) -> String {
    let mut out = format!("{ms} 080#\n{} 185#01\n", ms + 0.3);
    if cycle.is_multiple_of(2) {
        out += &format!("{} 285#02\n", ms + 0.4);
    }
    if cycle.is_multiple_of(3) {
        out += &format!("{} 186#03\n", ms + 0.5);
    }
    out
}

/// Deterministic noise within 0..1.
fn noise(seed: u64) -> f64 {
    let mut x = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15);
    x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    ((x ^ (x >> 27)) % 1000) as f64 / 1000.0
}

/// A capture of `count` cycles of 10 ms; `at` moves SYNCs with all that follows.
fn capture(count: u64, at: impl Fn(u64) -> f64) -> String {
    let cycles: String = (1..=count).map(|number| cycle(number, 10.0 * number as f64 + at(number))).collect();
    log(&format!("{CONFIGURED}{cycles}"))
}

fn sorted(log: &str) -> String {
    let mut lines: Vec<&str> = log.lines().collect();
    lines.sort_by_key(|line| line.split(')').next().unwrap());
    lines.into_iter().map(|line| format!("{line}\n")).collect()
}

/// The same without stamps.
fn console(log: &str) -> String {
    let line = |line: &str| {
        let (id, data) = line.rsplit(' ').next().unwrap().split_once('#').unwrap();
        let bytes: Vec<String> = data.as_bytes().chunks(2).map(|two| String::from_utf8_lossy(two).into()).collect();
        format!("  can0  {id}   [{}]  {}\n", bytes.len(), bytes.join(" "))
    };
    log.lines().map(line).collect()
}

fn nothing() -> Vec<Raised> {
    Vec::new()
}

fn codes(raised: &[Raised]) -> Vec<&str> {
    raised.iter().map(|(code, ..)| code.as_str()).collect()
}

#[test]
fn syncs_out_of_a_buffer_are_no_period() {
    for apart_us in [50, 100, 190] {
        let buffered: String =
            (0..40).map(|number| format!("{} 080#\n", f64::from(number * apart_us) / 1000.0)).collect();
        let regular: String = (1..60).map(|cycle| format!("{} 080#\n", 10 * cycle)).collect();
        assert_eq!(raised(&log(&(buffered + &regular))), nothing(), "{apart_us} us");
    }
}

#[test]
fn sound_captures_cut_anywhere() {
    let whole = capture(24, |_| 0.0);
    let lines: Vec<&str> = whole.lines().collect();
    for cut in 0..lines.len() {
        for part in [&lines[cut..], &lines[..cut]] {
            let part: String = part.iter().map(|line| format!("{line}\n")).collect();
            assert_eq!(raised(&part), nothing(), "{part}");
            assert_eq!(raised(&console(&part)), nothing(), "{part}");
        }
    }
}

#[test]
fn jitter_of_a_loaded_host() {
    for seed in 0..20 {
        let text = capture(200, |number| 2.0 * noise(seed * 1000 + number));
        assert_eq!(raised(&text), nothing(), "seed {seed}");
        assert_eq!(raised(&console(&text)), nothing(), "seed {seed}");
    }
}

#[test]
fn the_echo_of_the_own_sync_comes_late() {
    for seed in 0..20 {
        let mut text = String::from(CONFIGURED);
        for number in 1..60 {
            let late = if noise(seed * 100 + number) < 0.4 { 0.45 } else { 0.0 };
            let frames = cycle(number, 10.0 * number as f64);
            let (_, rest) = frames.split_once('\n').unwrap();
            text += &format!("{} 080#\n{rest}", 10.0 * number as f64 + late);
        }
        assert_eq!(raised(&sorted(&log(&text))), nothing(), "seed {seed}");
    }
}

#[test]
fn placement() {
    let all = lines(&capture(6, |_| 0.0), Network::default());
    let placed: Vec<_> = all
        .iter()
        .filter(|line| line["pdo"]["number"] == 2)
        .map(|line| (line["pdo"]["sync"]["cycle"].as_u64().unwrap(), line["pdo"]["sync"]["delay_us"].as_f64().unwrap()))
        .collect();
    assert_eq!(placed, [(2, 400.0), (4, 400.0), (6, 400.0)]);
}

#[test]
fn stalls_of_the_machine_are_no_fault() {
    // The machine pauses for 25 ms: three SYNCs come together, the nodes answer the last one.
    let mut text = String::from(CONFIGURED);
    for number in 1..40 {
        match number {
            20 | 21 => text += &format!("{} 080#\n", 225.0 + number as f64 / 100.0),
            22 => text += &cycle(number, 225.3),
            _ => text += &cycle(number, 10.0 * number as f64),
        }
    }
    assert_eq!(raised(&sorted(&log(&text))), nothing());
    assert_eq!(raised(&console(&sorted(&log(&text)))), nothing());
}

#[test]
fn long_stalls_late_syncs_and_copies() {
    for period in [1.0, 4.0, 10.0, 50.0] {
        let at = |number: u64| period * number as f64;
        let train = |late: &dyn Fn(u64) -> f64| -> String {
            (1..400).map(|number| format!("{:.3} 080#\n", late(number))).collect()
        };
        // 300 ms without frames, then all due ones within some 10 us.
        let (from, to) = (at(60), at(60) + 300.0);
        let stalled = |number: u64| {
            let stall = (from..to).contains(&at(number));
            if stall { to + 0.01 * (number - 60) as f64 / period.max(4.0) } else { at(number) }
        };
        assert_eq!(raised(&sorted(&log(&train(&stalled)))), nothing(), "{period}");
        // One is late, later ones are not.
        let late = |number: u64| at(number) + if number == 50 { 0.59 * period } else { 0.0 };
        assert_eq!(raised(&log(&train(&late))), nothing(), "{period}");
        // All are listed twice.
        let twice = train(&at) + &train(&|number| at(number) + 0.12);
        let said = lines(&sorted(&log(&twice)), Network::default());
        assert!(said.iter().all(|line| line["kind"] != "finding" || line["severity"] == "info"), "{period}");
        // One is listed twice, and one is missing after a stall.
        let once = train(&at) + &format!("{:.3} 080#\n", at(50) + 0.12);
        assert_eq!(raised(&sorted(&log(&once))), [("SYN003".to_owned(), 51, Some(50))], "{period}");
    }
}

#[test]
fn lost_frames_are_no_fault() {
    let text = capture(40, |_| 0.0);
    let kept: Vec<&str> = text.lines().collect();
    let marker = "DROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 3)";
    for gap in 1..8 {
        let parts = [&kept[..40], &[marker][..], &kept[40 + gap..]].concat();
        let said = lines(&(parts.join("\n") + "\n"), Network::default());
        let codes: Vec<_> = said.iter().filter(|line| line["kind"] == "finding").map(|line| &line["code"]).collect();
        assert_eq!(codes, ["CAP002"], "{gap}");
    }
}

#[test]
fn what_ends_for_a_reason_is_not_missing() {
    for (why, silent) in [
        ("000#8005", true),
        ("000#0200", true),
        ("000#8105", true),
        ("705#7F", true),
        ("705#00", true),
        ("605#23001801850100C0\n109.6 585#6000180100000000", true),
        // The node is off, or its last frame was the end.
        ("", true),
        ("", false),
    ] {
        let mut text = String::from(CONFIGURED);
        for number in 1..=30 {
            let frames = cycle(number, 10.0 * number as f64);
            match number {
                ..=10 => text += &frames,
                _ if silent => text += frames.lines().next().unwrap(),
                _ => {}
            }
            text += "\n";
            if number == 10 && !why.is_empty() {
                text += &format!("109 {why}\n");
            }
        }
        // Node 6 goes on in none of them; a heartbeat of another node does not keep either alive.
        text += "400 707#05\n";
        assert_eq!(raised(&log(&text)), nothing(), "{why}");
    }
}

#[test]
fn pauses_and_restarts() {
    let counted = |from: u64, to: u64, ms: f64| -> String {
        (from..=to).map(|counter| format!("{} 080#{counter:02X}\n", ms + 10.0 * counter as f64)).collect()
    };
    for between in ["", "100 000#8100\n", "105 705#00\n", "100 605#2306100000000000\n100.4 585#6006100000000000\n"] {
        let text = counted(1, 9, 0.0) + between + &counted(1, 9, 500.0) + &counted(10, 12, 500.0);
        assert_eq!(raised(&log(&text)), nothing(), "{between}");
    }
    let reset = counted(1, 9, 0.0) + "95 000#8100\n" + &counted(1, 9, 100.0);
    assert_eq!(raised(&log(&reset)), nothing());
    // The producer goes on at another period.
    let slower: String = (0..20).map(|number| format!("{} 080#\n", 500.0 + 25.0 * f64::from(number))).collect();
    let faster: String = (0..20).map(|number| format!("{} 080#\n", 10.0 * f64::from(number))).collect();
    assert_eq!(raised(&log(&(faster + &slower))), nothing());
}

#[test]
fn a_sync_without_period() {
    let mut ms = 0.0;
    let mut text = String::from(CONFIGURED);
    for number in 1..60 {
        ms += 3.0 + 40.0 * noise(number);
        text += &cycle(number, ms);
    }
    assert_eq!(raised(&log(&text)), nothing());
}

#[test]
fn two_buses_do_not_mix() {
    let one = capture(20, |_| 0.0);
    let other = capture(20, |_| 4.0).replace("can0", "can1");
    assert_eq!(raised(&sorted(&(one + &other))), nothing());
}

#[test]
fn remote_frames_and_preset_types() {
    // An answer to a remote frame is not one too many; nor is a type that only an option would have to know.
    let mut text = String::from(CONFIGURED);
    for number in 1..=10 {
        text += &cycle(number, 10.0 * number as f64);
        if number == 6 {
            text += "62 185#R\n62.3 185#01\n";
        }
    }
    assert_eq!(raised(&log(&text)), nothing());
    let unknown: String = (1..10).map(|number| format!("{0}0 080#\n{0}1 185#01\n{0}2 185#01\n", number)).collect();
    assert_eq!(raised(&log(&unknown)), nothing());
}

/// Single faults: the change to line `n` of the capture, and the code with its frame.
#[test]
fn single_faults() {
    let whole = capture(30, |_| 0.0);
    let lines: Vec<String> = whole.lines().map(str::to_owned).collect();
    for (number, line) in lines.iter().enumerate().take(75).skip(45) {
        let frame = number as u64 + 1;
        let sync = line.contains("080#");
        let mut without = lines.clone();
        without.remove(number);
        let said = raised(&(without.join("\n") + "\n"));
        if sync {
            assert_eq!(codes(&said), ["SYN003"], "{line}");
        } else {
            assert_eq!(codes(&said), ["SYN008"], "{line}");
            let before = (0..number).rev().find(|before| lines[*before].contains("080#")).unwrap();
            assert_eq!(said[0].2, Some(before as u64 + 1), "{line}");
            let mut twice = lines.clone();
            twice.insert(number + 1, line.clone());
            let said = raised(&(twice.join("\n") + "\n"));
            assert_eq!(said, [("SYN009".to_owned(), frame + 1, Some(frame))], "{line}");
        }
    }
    assert!(lines.len() as u64 > BEFORE + 60);
}

#[test]
fn windows() {
    let network = |window_ns, jitter_ns: Option<i64>| Network {
        sync_window_ns: Some(Ns(window_ns)),
        jitter_ns: jitter_ns.map(Ns),
        ..Network::default()
    };
    let severities = ["info", "warning", "error"];
    let text = capture(20, |_| 0.0);
    let late = text.replace(".100300", ".103300").replace(".100400", ".103400");
    for (text, window_ns, jitter_ns, want) in [
        (&text, 2_000_000, None, vec![]),
        (&late, 2_000_000, None, vec!["SYN004", "SYN004"]),
        (&late, 4_000_000, None, vec![]),
        (&late, 2_000_000, Some(1_500_000), vec![]),
        (&late, 2_000_000, Some(3_000_000), vec!["SYN011"]),
        (&console(&late), 2_000_000, None, vec!["SYN011"]),
        (&late, 0, None, vec![]),
    ] {
        let said = raised_with(text, network(window_ns, jitter_ns), &severities);
        assert_eq!(codes(&said), want, "{window_ns} {jitter_ns:?}");
    }
}

#[test]
fn a_short_period_before_it_is_known() {
    // 250 us after its SYNC, 750 us before the next one: the first cycles must not assign it to that one.
    let only = "0.4 605#2F01180201000000\n0.8 585#6001180200000000\n1.2 000#0100\n";
    for late in 1..8_u32 {
        let cycles: String = (1..=20_u32)
            .map(|no| {
                let sync = f64::from(no) + 10.0;
                let delay = if no == late { 0.35 } else { 0.25 };
                format!("{sync} 080#\n{:.3} 285#01\n", sync + delay)
            })
            .collect();
        assert_eq!(raised(&log(&format!("{only}{cycles}"))), nothing(), "late in cycle {late}");
    }
}

#[test]
fn a_gap_of_centuries() {
    let configured = "0 605#2F00180201000000\n 0.4 585#6000180200000000\n 10 080#\n 11 185#01\n 20 080#\n 21 185#01\n";
    let later = "(9100000000.000000) can0 185#01\n(9100000000.000100) can0 080#\n(9100000000.000200) can0 185#01\n";
    let back = "(1.000000) can0 080#\n(1.000100) can0 185#01\n";
    assert!(raised(&(log(configured) + later + back)).len() < 10, "no overflow, no flood");
}

/// `count` SYNCs alone, every 20 ms or a little more, from `ms` on.
fn train(ms: f64, count: u64) -> String {
    (0..count).map(|number| format!("{:.3} 080#\n", ms + 20.1 * number as f64 + 0.2 * noise(number))).collect()
}

#[test]
fn a_missing_sync_beside_a_command() {
    let whole = train(0.0, 44);
    let without: String =
        whole.lines().filter(|line| !line.starts_with("502.")).map(|line| format!("{line}\n")).collect();
    for command in ["0205", "8105", "8205", "0105", "0200", "8200"] {
        for at in [440, 462, 490, 515, 545, 565, 585, 605] {
            let beside = |train: &str| raised(&sorted(&log(&format!("{train}{at} 000#{command}\n"))));
            assert_eq!(beside(&whole), nothing(), "{command} at {at}");
            // Where the master speaks to all in the gap, it may have held SYNC up.
            let excused = command.ends_with("00") && (483..523).contains(&at);
            let want: &[&str] = if excused { &[] } else { &["SYN003"] };
            assert_eq!(codes(&beside(&without)), want, "{command} at {at}");
        }
    }
    // The last but one before a pause that has its reason.
    let paused = without.lines().take(26).map(|line| format!("{line}\n")).collect::<String>();
    let said = raised(&log(&format!("{paused}560 000#8205\n{}", train(900.0, 20))));
    assert_eq!(said, [("SYN003".to_owned(), 26, Some(25))]);
}

#[test]
fn a_pause_by_command_before_the_period_is_known() {
    for before in 1..6 {
        for command in ["0205", "8205", "8100", "8000"] {
            let text = format!("{}150 000#{command}\n{}", train(0.0, before), train(217.0, 30));
            assert_eq!(raised(&log(&text)), nothing(), "{before} SYNCs, then {command}");
        }
    }
    let faster: String = (0..20).map(|number| format!("{} 080#\n", 50.0 * f64::from(number))).collect();
    for missing in 4..12 {
        let lines: Vec<String> = train(2000.0, 40).lines().map(str::to_owned).collect();
        let lost = lines.iter().enumerate().filter(|(number, _)| *number != missing);
        let lost: String = lost.map(|(_, line)| format!("{line}\n")).collect();
        let said = raised(&log(&format!("{faster}1000 000#8200\n{lost}")));
        assert_eq!(codes(&said), ["SYN003"], "the {missing}th of another period");
    }
}

#[test]
fn a_pause_by_a_broken_command() {
    let (before, after) = (train(0.0, 12), train(600.0, 20));
    for (command, want) in
        [("8205", None), ("82", Some("NMT001")), ("820500", Some("NMT001")), ("8305", Some("NMT001"))]
    {
        let said = raised(&log(&format!("{before}250 000#{command}\n{after}")));
        assert_eq!(codes(&said), want.as_slice(), "{command}");
    }
    assert_eq!(codes(&raised(&log(&format!("{before}{}", train(363.0, 20))))), ["SYN003"]);
}

/// Apparent faults of PDOs if a SYNC is missing before the period is known.
#[test]
fn a_sync_missing_early_is_one_finding() {
    let whole = capture(12, |_| 0.0);
    let lines: Vec<&str> = whole.lines().collect();
    let syncs: Vec<usize> = (0..lines.len()).filter(|number| lines[*number].contains("080#")).collect();
    for missing in syncs.iter().skip(1).take(6) {
        let text: String = lines
            .iter()
            .enumerate()
            .filter(|(number, _)| number != missing)
            .map(|(_, line)| format!("{line}\n"))
            .collect();
        assert_eq!(codes(&raised(&text)), ["SYN003"], "without frame {}", missing + 1);
    }
    // One too many is also reported if nothing is missing.
    for (number, line) in lines.iter().enumerate().filter(|(number, line)| *number > 14 && line.contains("185#")) {
        let mut twice = lines.clone();
        twice.insert(number + 1, line);
        let text: String = twice.iter().map(|line| format!("{line}\n")).collect();
        let (said, double) = (raised(&text), number as u64 + 2);
        assert_eq!(codes(&said), ["SYN009"], "{line}");
        assert!(said[0].1 == double || said[0].2 == Some(double), "{line}: {said:?}");
    }
}

//! Damaged text captures: lines cut by the end of the file, and remains of lines. Comments and remarks of people are
//! not damage.

use super::*;

#[test]
fn the_last_line() {
    for (line, reason) in [
        ("(1.5) can0 601#40081", "Cut"),
        ("(1.5) can0 601##", "Cut"),
        ("(1.5) can0 6", "Cut"),
        ("(1.5) can0", "Cut"),
        ("(1.5) ", "Cut"),
        ("(1.5)", "Cut"),
        ("(1.", "Cut"),
        ("(15", "Cut"),
        ("(2026-11-21 00:", "Cut"),
        ("  can0  601   [8]  40 08", "Cut"),
        ("  can0  601   [8]  40 0", "Cut"),
        ("  can0  601   [8]", "Cut"),
        ("  can0  601   [8", "Cut"),
        ("  can0  601   [", "Cut"),
        ("  can0  601 ", "Cut"),
        ("  can0  60", "Cut"),
        ("  can0  TX", "Cut"),
        ("  can0  TX - ", "Cut"),
        ("  can0  TX - -", "Cut"),
        ("  can0  601   [0]  remote re", "Cut"),
        ("  can0  601   [2]  01010101`0101", "Cut"),
        ("  can", "Cut"),
        ("  can0  601   [8]  40 0G", "Data"),
        ("(1.5) can0 601#40G", "Data"),
        ("(1.5) can0 FFF#40", "Identifier"),
        ("the end", "NoFrame"),
        ("end", "NoFrame"),
    ] {
        let text = format!("(1.5) can0 601#40\n{line}");
        assert_eq!(read(&text).lines().nth(1), Some(&*format!("2! {reason}")), "{line:?}");
        let text = format!("{text}\n");
        assert_ne!(read(&text).lines().nth(1), Some("2! Cut"), "{line:?}");
    }
    assert_eq!(read(""), "0 lines\n");
}

#[test]
fn a_last_line_that_may_go_on() {
    // The beginning of a longer frame is reported and not read.
    for (before, line) in [
        ("(1.5) can0 601#4008100000000000", "(2.5) can0 601#4008"),
        ("(1.5) can0 601#40", "(2.5) can0 602#41"),
        ("(1.5) can0 601#40", "(2.5) can0 601#"),
        ("(1.5) can0 601#40", "(2.5) can0 00000601#40"),
        ("(1.5) can0 601#40 R", "(2.5) can0 601#40"),
        ("(1.5) can0 601#40 R", "(2.5) can0 601#40 "),
        ("(1.5) can0 601#4008100000000000 T", "(2.5) can0 601#4008100000000000"),
        ("(1.5) can0 601##14008", "(2.5) can0 601##140"),
        ("(1.5) can0 601#R4", "(2.5) can0 602#R"),
        ("(1.5) can0 601#40:08:10:00:00:00:00:00", "(2.5) can0 601#40:08"),
        ("(1.5) can0 601#40 08 10 00 00 00 00 00", "(2.5) can0 601#40 08"),
        ("601#4008", "601#40"),
        ("  can0  601   [1]  40", "  can0  602   [0]"),
        ("  can0  601   [1]  40", "  can0  602   [0] "),
    ] {
        for regular in [true, false] {
            let got = items(format!("{before}\n{line}").as_bytes(), Stamps::Auto, regular, &[]);
            assert_eq!(got.lines().nth(1), Some("2! Cut"), "{line:?}");
        }
        let got = read(&format!("{before}\n{line}\n"));
        assert!(got.lines().nth(1).unwrap().starts_with("2: "), "{line:?}: {got}");
    }
    // Complete lines without a newline are read.
    for (before, line) in [
        ("(1.5) can0 601#40", "(2.5) can0 601#41"),
        ("(1.5) can0 602#4008100000000000", "(2.5) can0 601#4008100000000000"),
        ("(1.5) can0 602#40 R", "(2.5) can0 601#40 R"),
        ("(1.5) can0 602#40 R\n(1.5) can0 602#40", "(2.5) can0 601#4008100000000000"),
        ("(1.5) can0 601#40:08:10", "(2.5) can0 601#40:08:10"),
        ("(1.5) can0 601#40 08 10", "(2.5) can0 601#40 08 10"),
        ("(1.5) can0 080#", "(2.5) can0 080#"),
        ("(1.5) can0 601#40", "(2.5) can0 602#41\r"),
        ("(1.5) can0 601#40", "(2.5) can0 602#41 # remark"),
        ("(1.5) can0 601##14008", "(2.5) can0 601##14008"),
        ("  can0  601   [8]  40 08 10 00 00 00 00 00", "  can0  602   [1]  41"),
        ("  can0  080   [0]", "  can0  080   [0] "),
        ("  can0  080   [0]", "  can0  601   [0]  remote request"),
    ] {
        let got = read(&format!("{before}\n{line}"));
        assert!(!got.contains('!'), "{line:?}: {got}");
    }
}

#[test]
fn damage_is_no_comment() {
    let frame = "(1.5) can0 601#40";
    for line in [
        "# remark\0",
        "\0\0\0\0",
        "(1700\0\0\0\0",
        "(17000000\u{1}0.002000) can0 185#0000000000000002",
        ";1700000000.002000) can0 185#0000000000000002",
        "#2026-09-15 18:44:56.479963)  can0  185   [1]  00",
        "#an0  185   [1]  00",
        "  #an0 185#00",
        "*** \x7F",
        "\tremark\0",
        "...\0...",
    ] {
        assert_eq!(read(&format!("{frame}\n{line}\n")).lines().nth(1), Some("2! NoFrame"), "{line:?}");
    }
    assert_eq!(items(b"(17\xE30\n", Stamps::Auto, true, &[]), "1! NoFrame\n1 lines\n");
    for line in [
        "# (1700000000.002000) can0 185#0000000000000002",
        "#(1700000000.002000) can0 185#0000000000000002",
        "# can0 185#00",
        "#can0  185   [1]  00",
        "(254) in decimal",
        "(COB-ID 018A)",
        "; 1.5) is the answer",
        "--- 1.5) ---",
        "\u{2190} \u{4E3B}\u{7AD9}",
        "#\tremark\r",
        "\x1b[1m# remark\x1b[0m",
    ] {
        assert_eq!(read(&format!("{frame}\n{line}\n")), format!("{}2 lines\n", first(frame)), "{line:?}");
    }
}

/// Returns the items of a single line, without the number of lines.
fn first(line: &str) -> String {
    read(&format!("{line}\n")).trim_end_matches("1 lines\n").to_owned()
}

#[test]
fn damage_behind_a_frame_is_no_remark() {
    for frame in ["(1.5) can0 601#40 R", "  can0  601   [1]  40", "(1.5)  can0  601   [1]  40"] {
        for tail in [
            " \0\0\0",
            " remark\u{7}",
            "^(1.6) can0 581#4008100000000000",
            "; (1.6) can0 581#4008100000000000 T",
            "\u{e9} (1.6)  can0  581   [1]  40",
            "  (1.6) can0 581#4",
        ] {
            let got = read(&format!("{frame}{tail}\n"));
            let (whole, rest) = got.split_once('\n').unwrap();
            assert!(whole.ends_with("601 1 40"), "{got}");
            assert_eq!(rest, "1! NoFrame\n1 lines\n", "{frame}{tail}");
        }
        for tail in [
            " # remark",
            " ; (1.6) can0 581#40",
            " (1.6) s later",
            " '@.......'",
            "  <- 581#40",
            " \u{2190} \u{4E3B}",
            "\t(2) can0",
        ] {
            let got = read(&format!("{frame}{tail}\n"));
            assert_eq!(got.lines().count(), 2, "{frame}{tail}: {got}");
        }
    }
    let unstamped = "  can0  601   [1]  40";
    assert_eq!(read(&format!("{unstamped}^{unstamped}\n")), "1: can0 601 1 40\n1! NoFrame\n1 lines\n");
    assert_eq!(items(b"(1.5) can0 601#40 R\xE9(1.6) can0 581#40\n", Stamps::Auto, true, &[]).lines().count(), 3);
}

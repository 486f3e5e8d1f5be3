//! A line for each dialect, and the laws that hold for any input.
//!
//! The lines are written for these tests, in the forms of can-utils' sources and of captures from the field.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]

mod damage;

use std::fmt::Write;

use proptest::prelude::*;

use super::*;
use crate::bytes::frame::Direction;
use crate::bytes::readers::lines::MAX_LINE;

/// Returns all items of a capture, one on each line, in a short notation.
fn items(text: &[u8], stamps: Stamps, regular: bool, cuts: &[usize]) -> String {
    let mut reader = Candump::new(stamps, regular);
    let mut buses = Buses::default();
    let mut out = String::new();
    let mut sink = |item: Item, buses: &Buses| match item {
        Item::Frame(frame) => writeln!(out, "{}", shown(&frame, buses)).unwrap(),
        Item::Marker(marker) => writeln!(out, "{marker:?}").unwrap(),
        Item::Unreadable { place, reason } => writeln!(out, "{}! {reason:?}", place.line().unwrap()).unwrap(),
        Item::Damaged(damage) => writeln!(out, "{damage:?}").unwrap(),
        Item::Gap { .. } | Item::Until { .. } => panic!("{item:?}"),
    };
    let mut rest = text;
    for cut in cuts {
        let (piece, after) = rest.split_at(*cut.min(&rest.len()));
        reader.feed(piece, &mut buses, &mut sink);
        rest = after;
    }
    reader.feed(rest, &mut buses, &mut sink);
    reader.finish(&mut buses, &mut sink);
    reader.finish(&mut buses, &mut sink);
    writeln!(out, "{} lines", reader.lines()).unwrap();
    out
}

fn read(text: &str) -> String {
    items(text.as_bytes(), Stamps::Auto, true, &[])
}

/// Returns `line time bus direction id kind length bytes form` without empty parts.
fn shown(frame: &Frame, buses: &Buses) -> String {
    let mut out = frame.line.map(|line| format!("{line}: ")).unwrap_or_default();
    if let Some(t) = frame.t_ns {
        write!(out, "{} ", t.as_ns()).unwrap();
    }
    if !buses.name(frame.bus).is_empty() {
        write!(out, "{} ", buses.name(frame.bus).escape_ascii()).unwrap();
    }
    match frame.dir {
        Some(Direction::Rx) => out.push_str("rx "),
        Some(Direction::Tx) => out.push_str("tx "),
        None => {}
    }
    write!(out, "{:?} ", frame.id).unwrap();
    match frame.kind {
        Kind::Data => {}
        Kind::Remote => out.push_str("rtr "),
        Kind::Fd { brs, esi } => {
            write!(out, "fd{}{} ", if brs { "B" } else { "" }, if esi { "E" } else { "" }).unwrap();
        }
        Kind::Error => out.push_str("error "),
    }
    write!(out, "{}", frame.len).unwrap();
    if !frame.payload().is_empty() {
        out.push(' ');
    }
    for byte in frame.payload() {
        write!(out, "{byte:02X}").unwrap();
    }
    let form = frame.length_form;
    if form.braces {
        out.push_str(" braces");
    }
    if form.raw_dlc != 0 {
        write!(out, " dlc{:X}", form.raw_dlc).unwrap();
    }
    assert_eq!(form.two_digits, form.two_digits && matches!(frame.kind, Kind::Fd { .. }));
    assert!(frame.data[if frame.kind == Kind::Remote { 0 } else { usize::from(frame.len) }..].iter().all(|&b| b == 0));
    out
}

#[test]
fn compact_lines() {
    for (line, expected) in [
        ("(1579857014.345944) can2 486#82967A6B006B07F8", "1579857014345944000 can2 486 8 82967A6B006B07F8"),
        ("(1579857014.345944) vcan-0 080#", "1579857014345944000 vcan-0 080 0"),
        ("(0.000000) vcan.0 123#00\r", "0 vcan.0 123 1 00"),
        ("(1.1)  slcan0\t1F334455#dead", "1100000000 slcan0 1F334455 2 DEAD"),
        ("\u{FEFF}(1.123456789) vecan0 00000123#Ab", "1123456789 vecan0 00000123 1 AB"),
        ("(1.5) canable0 185#5002E902000008   ← 节点第一帧，模式 8 ✓", "1500000000 canable0 185 7 5002E902000008"),
        ("(1.5) can0 185#50 # remark", "1500000000 can0 185 1 50"),
        ("(1.5) can0 185#50 T", "1500000000 can0 tx 185 1 50"),
        ("(1.5) can0 185#50 R", "1500000000 can0 rx 185 1 50"),
        ("(1.5) can0 185#50 Transmitted", "1500000000 can0 185 1 50"),
        ("\x1b[1m\x1b[34m(1.5) can0 185#50 T\x1b[0m", "1500000000 can0 tx 185 1 50"),
        ("(1.5) can0 123#R", "1500000000 can0 123 rtr 0"),
        ("(1.5) can0 123#R4 R", "1500000000 can0 rx 123 rtr 4"),
        ("(1.5) can0 123#R8_C", "1500000000 can0 123 rtr 8 dlcC"),
        ("(1.5) can0 123#1122334455667788_E", "1500000000 can0 123 8 1122334455667788 dlcE"),
        ("(1.5) can0 123#1122334455667788_9 T", "1500000000 can0 tx 123 8 1122334455667788 dlc9"),
        ("(1.5) can0 123##0", "1500000000 can0 123 fd 0"),
        ("(1.5) can0 123##5A1B2C3", "1500000000 can0 123 fdB 3 A1B2C3"),
        ("(1.5) can0 12345678##311223344556677889900AABB", "1500000000 can0 12345678 fdBE 12 11223344556677889900AABB"),
        ("(1.5) can0 20000088#0000000800000000", "1500000000 can0 00000088 error 8 0000000800000000"),
        ("(2026-09-15 18:44:56.479963) can0 080#", "1789497896479963000 can0 080 0"),
        ("can0 601#40.41.60", "can0 601 3 404160"),
        ("can0 601##1.40.41", "can0 601 fdB 2 4041"),
        ("601#4008100000000000", "601 8 4008100000000000"),
        ("  601#r2", "601 rtr 2"),
        ("(1.5) can0 601#4", "! Data"),
        ("(1.5) can0 601#4G", "! Data"),
        ("(1.5) can0 60A#40:17:10", "1500000000 can0 60A 3 401710"),
        ("60A#40:17:10:00:00:00:00:00 R", "rx 60A 8 4017100000000000"),
        ("0000060A#81:00 # remark", "0000060A 2 8100"),
        ("(1.5) can0 60A#40:17:10:00:00:00:00:00:00", "! Length"),
        ("(1.5) can0 60A#40:17:1", "! Data"),
        ("(1.5) can0 60A#40:17:", "! Data"),
        ("(1.5) can0 60A#40:1710", "! Data"),
        ("(1.5) can0 60A#40:17.10", "! Data"),
        ("(1.5) can0 60A#4017:10", "! Data"),
        ("(1.5) can0 60A#:40:17", "! Data"),
        ("(1.5) can0 60A##1.40:17", "! Data"),
        ("(1.5) can0 601#40 41 42", "1500000000 can0 601 3 404142"),
        ("(1.5) can0 601#40 ad 00 de T", "1500000000 can0 tx 601 4 40AD00DE"),
        ("601#40 41 42 00 00 00 00 00 ; remark", "601 8 4041420000000000"),
        ("(1.5) can0 601#40 be", "1500000000 can0 601 1 40"),
        ("(1.5) can0 601#40 41 42 00 00 00 00 00 00", "! Length"),
        ("(1.5) can0 601#40 41 ms", "! Data"),
        ("(1.5) can0 601#40 41 4", "! Data"),
        ("(1.5) can0 601#40 4", "! Data"),
        ("(1.5) can0 601#4041 42", "! Data"),
        ("(1.5) can0 601##140 41", "! Data"),
        ("(1.5) can0 601#40..41", "! Data"),
        ("(1.5) can0 601#112233445566778899", "! Length"),
        ("(1.5) can0 601#11223344556677_9", "! Length"),
        ("(1.5) can0 601#1122334455667788_8", "! Length"),
        ("(1.5) can0 601#R9", "! Length"),
        ("(1.5) can0 601##", "! Data"),
        ("(1.5) can0 601##Z00", "! Data"),
        ("(1.5) can0 801#00", "! Identifier"),
        ("(1.5) can0 60A1#00", "! Identifier"),
        ("(1.5) can0 40000001#00", "! Identifier"),
        ("(1.5) can0 80000001#00", "! Identifier"),
        ("(1.5) can0 20000001#R", "! Identifier"),
        ("(1.5) can0 45123#81:00:12345678#1122", "! CanXl"),
        ("(1.5) can0 45123#81:00:12", "! CanXl"),
        ("(1.5) can0 123#A0:05:00000000#", "! CanXl"),
        ("(1.5) can0 123#A0:05:00000000", "! Data"),
        ("(1.5) can0 123#A0:05:00000000#ABAB", "! CanXl"),
    ] {
        check(line, expected);
    }
}

#[test]
fn console_lines() {
    let fd = "11 22 33 44 55 66 77 88 99 AA BB CC";
    for (line, expected) in [
        ("  vcan0  601   [8]  40 08 10 00 00 00 00 00", "vcan0 601 8 4008100000000000"),
        ("\t\tvcan0  601   [2]  40 08", "vcan0 601 2 4008"),
        ("            can0       70A   [1]  05", "can0 70A 1 05"),
        ("vcan0  123   [0] ", "vcan0 123 0"),
        ("vcan0  123   [0]", "vcan0 123 0"),
        ("  can0  12345678   [2]  de ad", "can0 12345678 2 DEAD"),
        ("  can0       70A   [0]  remote request", "can0 70A rtr 0"),
        ("  can0  00000123   [4]  remote request  # asks", "can0 00000123 rtr 4"),
        ("  can0  20000088   [8]  00 00 00 08 00 00 00 00   ERRORFRAME", "can0 00000088 error 8 0000000800000000"),
        // -t
        (" (1795221516.618476)  vcan0  601   [1]  40", "1795221516618476000 vcan0 601 1 40"),
        (" (76720.535362)  vcan0  601   [1]  40", "76720535362000 vcan0 601 1 40"),
        (" (2026-11-21 00:38:39.324905)  vcan0  601   [1]  40", "1795221519324905000 vcan0 601 1 40"),
        (" (2026-11-21 00:38:39.324905001)  vcan0  601   [1]  40", "1795221519324905001 vcan0 601 1 40"),
        (" (000.000000001)  vcan0  601   [1]  40", "1 vcan0 601 1 40"),
        // -x
        ("  can0  TX - -  601   [1]  40", "can0 tx 601 1 40"),
        ("  can0  RX - -       601   [1]  40", "can0 rx 601 1 40"),
        ("  can0  TX B E       213  [04]  11 22 33 44", "can0 tx 213 fdBE 4 11223344"),
        ("  can0  RX - E  00000213  [00] ", "can0 rx 00000213 fdE 0"),
        // cut off by hand: the interface, the flags, both
        ("(1.5) TX - -  601 [1] 40", "1500000000 tx 601 1 40"),
        ("(1.5) RX 601 [1] 40", "1500000000 rx 601 1 40"),
        ("601   [1]  40", "601 1 40"),
        ("12345678 [1] 40", "12345678 1 40"),
        // FD
        (&format!("  can0  213  [12]  {fd}"), "can0 213 fd 12 112233445566778899AABBCC"),
        ("  can0  213  [08]  11 22 33 44 55 66 77 88", "can0 213 fd 8 1122334455667788"),
        ("  can1  065   [10]  F0 01 FE FD FC FB FA F9 F8 F7", "can1 065 fd 10 F001FEFDFCFBFAF9F8F7"),
        // -8
        ("  can0  123   {8}  11 22 33 44 55 66 77 88", "can0 123 8 1122334455667788 braces"),
        ("  can0  123   {C}  11 22 33 44 55 66 77 88", "can0 123 8 1122334455667788 braces dlcC"),
        ("  can0  123   {2}  11 22", "can0 123 2 1122 braces"),
        ("  can0  123   {F}  remote request", "can0 123 rtr 8 braces dlcF"),
        // -a
        ("  can0  601   [8]  70 32 2E 27 23 3C 62 27   'p2.'#<b''", "can0 601 8 70322E27233C6227"),
        ("  can0  123   [0]                            ''", "can0 123 0"),
        ("  can0  181   [3]  01 02 03                  '...'", "can0 181 3 010203"),
        ("  can0  181   [2]  41 42                     '11 22'", "can0 181 2 4142"),
        // -S, with -a, with -x
        ("  can0  601   [8]  00`00`00`00`00`10`08`40", "can0 601 8 4008100000000000"),
        ("  can0  TX - -  601   [3]  03`02`01   `...`", "can0 tx 601 3 010203"),
        ("  can0  601   [1]  40                        `@`", "can0 601 1 40"),
        ("  can0  601   [0]                            ``", "can0 601 0"),
        // -i, with -S
        ("  can0  181   [3]  00000001 00000010 10000011", "can0 181 3 010283"),
        ("  can0  181   [3]  10000011`00000010`00000001   `...`", "can0 181 3 010283"),
        ("  can0  181   [1]  00000001", "can0 181 1 01"),
        // -c, -c -c
        ("  \x1b[1m\x1b[34mvcan0\x1b[0m  601   [1]  40", "vcan0 601 1 40"),
        ("  \x1b[1m\x1b[34mvcan0  TX - -  123   [0] \x1b[0m", "vcan0 tx 123 0"),
        ("  \x1b[1m\x1b[34mvcan0  70A   [2]  remote request\x1b[0m", "vcan0 70A rtr 2"),
        // comments
        ("can0  701   [1]  00                       # Boot-up 71 72", "can0 701 1 00"),
        ("can0  701   [1]  00 // boot-up", "can0 701 1 00"),
        ("can0  701   [1]  00#boot-up", "can0 701 1 00"),
        ("can0  701   [2]  00 01 <---- be it 3 bytes", "can0 701 2 0001"),
        ("can0  701   [2]  00 01 -> 부팅", "can0 701 2 0001"),
        ("can0  701   [1]  00 de facto", "can0 701 1 00"),
        ("can0  701   [1]  FE (254)", "can0 701 1 FE"),
        ("can0  701   [0] (COB-ID 701)", "can0 701 0"),
        // damage
        ("  can0  601   [8]  40 08 10 00 00 00 00", "! Data"),
        ("  can0  601   [3]  40 08 1", "! Data"),
        ("  can0  601   [3]  40 08 G0", "! Data"),
        ("  can0  601   [3]  40 08 100", "! Data"),
        ("  can0  601   [3]  40`08 10", "! Data"),
        ("  can0  601   [3]  40 08`10", "! Data"),
        ("  can0  601   [2]  00000001 0000001", "! Data"),
        ("  can0  601   [2]  00000001 00000012", "! Data"),
        ("  can0  601   [2]  40", "! Data"),
        ("  can0  601   [2]", "! Data"),
        ("  can0  601   [2]  40 08 10", "! Length"),
        ("  can0  601   [9]  40 08 10 00 00 00 00 00 00", "! Length"),
        ("  can0  601   [65]  40", "! Length"),
        ("  can0  601   [8  40", "! Length"),
        ("  can0  601   {08}  40", "! Length"),
        ("  can0  601   [1]40", "! Length"),
        ("  can0  FEE   [1]  40", "! Identifier"),
        ("  can0  1234   [1]  40", "! Identifier"),
        ("  can0  40000123   [1]  40", "! Identifier"),
        ("  can0  20000004   [8]  remote request", "! Data"),
        ("  can0  601   [00]  remote request", "! Data"),
        ("  can0  45123   [0064]  (45|81:00:12345678) 11 22", "! CanXl"),
        ("  can0    1   [2048]  (001|81:00:12345678) 11 22", "! CanXl"),
        (" (1.5)  can0", "! NoFrame"),
        (" (1.5)  can0  ", "! NoFrame"),
        (" (1.5", "! NoFrame"),
        (" (1.5)", "! NoFrame"),
        (" (1549455524.2655601  can0  601   [1]  40", "! NoFrame"),
    ] {
        check(line, expected);
    }
}

/// Checks one line, between two others that must not matter, with every kind of line end.
fn check(line: &str, expected: &str) {
    let expected = if expected.starts_with('!') { format!("2{expected}") } else { format!("2: {expected}") };
    for end in ["\n", "\r\n"] {
        assert_eq!(read(&format!("#{end}{line}{end}#{end}")), format!("{expected}\n3 lines\n"), "{line:?}");
    }
    let mut buses = Buses::default();
    let alone = super::line(line.as_bytes(), &mut buses).ok().map(|frame| format!("2: {}", shown(&frame, &buses)));
    assert_eq!(alone, (!expected.starts_with("2!")).then_some(expected), "{line:?}");
}

#[test]
fn a_request_and_its_response_with_an_arrow_between_them() {
    let both = "1: can0 601 8 4018100100000000\n1: can0 581 8 431810019A000000\n1 lines\n";
    let (asked, answered) = ("can0 601 [8] 40 18 10 01 00 00 00 00", "can0 581 [8] 43 18 10 01 9A 00 00 00");
    for arrow in [" -> ", " => ", " \u{2192} "] {
        assert_eq!(read(&format!("{asked}{arrow}{answered}\n")), both, "{arrow}");
    }
    assert_eq!(read(&format!("{asked} -> 581 [8] 43 18 10 01 9A 00 00 00\n")), both);
    // Words behind an arrow are a remark.
    for remark in [" -> the node answers", " -> no answer", "  # -> 581 [1] 40"] {
        assert_eq!(read(&format!("{asked}{remark}\n")).lines().count(), 2, "{remark}");
    }
    let compact = "1: 601 8 4018100100000000\n1: 581 8 431810019A000000\n1 lines\n";
    assert_eq!(read("601#4018100100000000 -> 581#431810019A000000\n"), compact);
}

#[test]
fn what_is_no_frame_and_says_nothing() {
    for line in [
        "",
        " ",
        "\t",
        "\r",
        "#",
        "# text",
        "# can0  601   [1]  40",
        "//",
        "// (1.5) can0 601#40",
        "<---- 601 [1] 40",
        "-> 601#40",
        "← 主站发送",
        "^^^^ Object 1018",
        "(254)",
        "(254) of 601",
        "(COB-ID 018A)",
        "（254）",
        "```",
        "```sh",
        "candump can0",
        "$ candump -ta can0",
        "# candump can0",
        "user@host:~$ candump can0",
        "root@bbb:~# candump -x any",
        "pi@pi:~ $ candump can0",
        "[me@host ~]$ candump can0",
        "me$ candump can0",
        "cansend can0 601#40",
        "$ cansend can0 601#40",
        "--",
        "* 601",
        "|---|",
        "\u{FEFF}# text",
        "\x1b[1m# text\x1b[0m",
    ] {
        assert_eq!(read(&format!("{line}\n")), "1 lines\n", "{line:?}");
    }
}

#[test]
fn a_frame_behind_other_words_is_not_passed_over() {
    for line in
        ["| 0 | can0  601   [1]  40 |", "> he wrote: can0 601#40", "[12] -> 601   [1]  40", "(254) can0 601 [1] 4"]
    {
        assert_eq!(
            read(line),
            "1! NoFrame\n1 lines\n".replace("NoFrame", if line.ends_with('4') { "Cut" } else { "NoFrame" }),
            "{line:?}"
        );
    }
    for line in ["$ sudo cansend can0 601#40", "[me@host ~]$ cansend can0 601#40", "> so it is 601"] {
        assert_eq!(read(line), "1 lines\n", "{line:?}");
    }
}

#[test]
fn mark_up_and_blanks_of_pages() {
    for line in [
        "`can0 601 [1] 40`",
        "* `can0 601 [1] 40`",
        "can0 601 [1] 40<br>",
        "<p>can0 601 [1] 40</p>",
        "<pre><code>can0 601 [1] 40",
        "> `can0 601 [1] 40`",
        "can0\u{A0}601\u{A0} [1]\u{2002}40",
        "\u{200B}can0 601 [1] 40",
    ] {
        assert_eq!(read(line), "1: can0 601 1 40\n1 lines\n", "{line:?}");
    }
    assert_eq!(read("can0 701 [0]<br>"), "1: can0 701 0\n1 lines\n");
    assert_eq!(read("`can0 601 [2] 40`"), "1! Cut\n1 lines\n");
    assert_eq!(read("can0 601 [2] 40<br>\n"), "1! Data\n1 lines\n");
    assert_eq!(read("<p>can0 is broken</p>\n"), "1 lines\n");
}

#[test]
fn decimal_bytes_are_not_read_as_hexadecimal_ones() {
    let decimal = "can0 385 [2] 55 12\ncan0 385 [2] 55 146\ncan0 701 [1] 5\n";
    assert_eq!(read(decimal), "1! Data\n2! Data\n3! Data\n3 lines\n");
    let damaged = "can0 385 [2] 55 12\ncan0 385 [2] 55 1\ncan0 701 [1] 05\n";
    assert_eq!(read(damaged), "1: can0 385 2 5512\n2! Data\n3: can0 701 1 05\n3 lines\n");
}

#[test]
fn carriage_returns_end_lines() {
    let text = "can0 601 [1] 40\rcan0 581 [1] 60\rand so on\rcan0 701 [1] 05";
    let expected = "1: can0 601 1 40\n2: can0 581 1 60\n3! NoFrame\n4: can0 701 1 05\n4 lines\n";
    for end in ["", "\r", "\n", "\r\n"] {
        assert_eq!(read(&format!("{text}{end}")), expected, "{end:?}");
    }
}

#[test]
fn rows_that_are_left_out() {
    let frame = "can0  601   [1]  40";
    let left_out = |count: Option<u64>, rows: Option<(u64, u64)>, line| {
        format!("{:?}\n", Marker::LeftOut { count, rows, place: FilePlace::Line(line) })
    };
    let one = |line: u64| format!("{line}: can0 601 1 40\n");
    let marked = |mark: &str| read(&format!("{frame}\n{mark}\n{frame}\n"));
    assert_eq!(marked("..."), one(1) + &left_out(None, None, 2) + &one(3) + "3 lines\n");
    assert_eq!(marked("(12 frames dropped)"), one(1) + &left_out(Some(12), None, 2) + &one(3) + "3 lines\n");
    assert_eq!(marked(".\n.\n."), one(1) + &left_out(None, None, 2) + &one(5) + "5 lines\n");
    assert_eq!(marked("...\n省略25帧\n..."), one(1) + &left_out(Some(25), None, 2) + &one(5) + "5 lines\n");
    assert_eq!(read(&format!("...\n{frame}")), left_out(None, None, 1) + &one(2) + "2 lines\n");
    assert_eq!(read(&format!("{frame}\n...")), one(1) + &left_out(None, None, 2) + "2 lines\n");
    assert_eq!(marked("... and then nothing"), one(1) + &one(3) + "3 lines\n");
}

#[test]
fn numbers_of_rows() {
    let numbered =
        |rows: &[&str]| read(&rows.iter().map(|row| format!("{row} can0  601   [1]  40\n")).collect::<String>());
    let all = |lines: u64| (1..=lines).map(|line| format!("{line}: can0 601 1 40\n")).collect::<String>();
    let with = |at: u64, lines: u64, count, rows| {
        let marker = Marker::LeftOut { count: Some(count), rows: Some(rows), place: FilePlace::Line(at) };
        let next = format!("{at}: ");
        (all(lines) + &format!("{lines} lines\n")).replace(&next, &format!("{marker:?}\n{next}"))
    };
    for whole in [["1)", "2)", "3)", "4)"], ["1", "2", "3", "4"], ["14.", "15.", "1.", "2."], ["7:", "7:", "6:", "5:"]]
    {
        assert_eq!(numbered(&whole), all(4) + "4 lines\n", "{whole:?}");
    }
    assert_eq!(numbered(&["13)", "14)", "20)", "21)"]), with(3, 4, 5, (14, 20)));
    assert_eq!(numbered(&["[1]", "> [3]"]), with(2, 2, 1, (1, 3)));
    // The mark is where the numbers show the gap, and an unreadable row is a row.
    let marked = read("1) can0 601 [1] 40\n...\n9) can0 601 [1] 40\n10) can0 601 [1] 4\n11) can0 601 [1] 40\n");
    let marker = Marker::LeftOut { count: Some(7), rows: Some((1, 9)), place: FilePlace::Line(3) };
    assert_eq!(marked, format!("1: can0 601 1 40\n{marker:?}\n3: can0 601 1 40\n4! Data\n5: can0 601 1 40\n5 lines\n"));
}

#[test]
fn what_people_write_before_a_frame() {
    for (line, frame) in [
        ("- can0 601 [1] 40", "can0 601 1 40"),
        ("* 601 [1] 40", "601 1 40"),
        ("Rx 601 [1] 40", "rx 601 1 40"),
        ("TX: 601 [1] 40", "tx 601 1 40"),
        ("Rx 601#40", "rx 601 1 40"),
        ("TX: 601#40", "tx 601 1 40"),
        ("can0 Tx 601 [1] 40", "can0 tx 601 1 40"),
        ("ID: 601 [1] 40", "601 1 40"),
        ("COB-ID 601 [1] 40", "601 1 40"),
        ("can0: 601 [1] 40", "can0 601 1 40"),
        ("can0:: 601 [1] 40", "can0 601 1 40"),
        ("can0: 601#40", "can0 601 1 40"),
        ("(1.5) can0: 601#40", "1500000000 can0 601 1 40"),
    ] {
        assert_eq!(read(&format!("{line}\n")), format!("1: {frame}\n1 lines\n"), "{line}");
    }
    for line in ["[12:34:56.789] can0 601 [1] 40", "[0.5] can0 601 [1] 40", "[2024-01-01 12:00:00] 601#40", "ID: reset"]
    {
        assert_eq!(read(&format!("{line}\n")), "1! NoFrame\n1 lines\n", "{line}");
    }
    for line in ["- remark", "* 601", "[1] a footnote", "- see 601 again"] {
        assert_eq!(read(&format!("{line}\n")), "1 lines\n", "{line}");
    }
}

#[test]
fn a_number_is_a_row_or_a_bus() {
    // Three increasing ones are row numbers; otherwise they name the interface.
    assert_eq!(read("1 601 [1] 40\n2 601 [1] 41\n3 601 [1] 42\n"), "1: 601 1 40\n2: 601 1 41\n3: 601 1 42\n3 lines\n");
    assert_eq!(
        read("1 601 [1] 40\n2 601 [1] 41\n1 601 [1] 42\n"),
        "1: 1 601 1 40\n2: 2 601 1 41\n3: 1 601 1 42\n3 lines\n"
    );
    assert_eq!(read("1) 601 [1] 40\n"), "1: 601 1 40\n1 lines\n");
    assert_eq!(read("1) (1.5) can0 601#40\n"), "1: 1500000000 can0 601 1 40\n1 lines\n");
    assert_eq!(read("> can0 601 [1] 40\n"), "1: can0 601 1 40\n1 lines\n");
    assert_eq!(read("> remark\n1) remark\n1. see 601 [1]\n"), "2! NoFrame\n3! Data\n3 lines\n");
}

#[test]
fn what_is_no_frame_and_is_said() {
    for line in [
        "The session starts here",
        "see 123 for more",
        "in 601 [1] we trust",
        "node 5 said [8] bytes",
        "PR #123",
        "fixes C#4",
        "add",
        "Boot FATAL ERROR",
        "ERROR",
        "节点启动",
        "DROPCOUNT: dropped many CAN frames",
        "can0",
        "can0  601",
        "601",
        "\u{1}\u{2}",
        "\0",
    ] {
        let text = read(&format!("{line}\n"));
        assert!(text.starts_with("1! ") && text.lines().count() == 2, "{line:?} {text}");
    }
}

#[test]
fn markers() {
    assert_eq!(
        read("(1.5) can0 601#40\nDROPCOUNT: dropped 3 CAN frames on 'can1' socket (total drops 5)\n"),
        "1: 1500000000 can0 601 1 40\nDropped { bus: BusId(1), count: 3, total: 5, place: Line(2) }\n2 lines\n"
    );
    assert_eq!(
        read("DROPCOUNT: dropped 1 CAN frame on 'can0,0:0,#FFFFFFFF' socket (total drops 1)\n  can0  601   [0] \n"),
        "Dropped { bus: BusId(0), count: 1, total: 1, place: Line(1) }\n2: can0 601 0\n2 lines\n"
    );
    assert_eq!(read("  vcan0  ERROR\n"), "Error { bus: BusId(0), stamp: None, place: Line(1) }\n1 lines\n");
    assert_eq!(read("vcan0: ERROR\n"), read("vcan0 ERROR\n"));
    assert!(read(" (1.5)  can  ERROR\n").starts_with("Error { bus: BusId(0), stamp: Some("));
}

#[test]
fn explained_error_frames_are_one_record() {
    let error = "  can0  20000088   [8]  00 00 00 08 00 00 00 00   ERRORFRAME\n";
    let text = format!("{error}\tprotocol-violation{{{{}}{{crc-sequence}}}}\n\tbus-error\n  can0  701   [1]  05\n");
    assert_eq!(read(&text), "1: can0 00000088 error 8 0000000800000000\n4: can0 701 1 05\n4 lines\n");
    // the same frame once more, without its interface: candump's own fault
    let text = format!("{error}\t20000088   [8]  00 00 00 08 00 00 00 00   ERRORFRAME\n{error}");
    assert_eq!(read(&text).lines().filter(|line| line.contains("error")).count(), 2);
    // another frame behind a TAB is a frame
    assert_eq!(read(&format!("{error}\t701   [1]  05\n")).lines().nth(1), Some("2: 701 1 05"));
    // nor does a TAB excuse what follows no error frame
    assert_eq!(read("  can0  701   [1]  05\n\tbus-error\n").lines().nth(1), Some("2! NoFrame"));
}

/// Returns the times of the frames in ms, and the line of a `Backward` marker.
fn times(text: &str, stamps: Stamps, regular: bool) -> String {
    let items = items(text.as_bytes(), stamps, regular, &[]);
    let times = items.lines().filter_map(|line| match line.strip_prefix("Backward { place: Line(") {
        Some(line) => Some(format!("back@{}", line.trim_end_matches(") }"))),
        None => line.split(' ').nth(1)?.parse::<i64>().ok().map(|ns| (ns / 1_000_000).to_string()),
    });
    times.collect::<Vec<_>>().join(" ")
}

#[test]
fn small_stamps() {
    use Stamps::{Absolute, Auto, Delta, Zero};
    let console = |stamps: &[&str]| -> String {
        stamps.iter().map(|stamp| format!(" ({stamp})  can0  701   [1]  05\n")).collect()
    };
    let deltas = console(&["000.000000", "000.500000", "000.250000", "001.000000", "000.100000"]);
    assert_eq!(times(&deltas, Auto, true), "0 500 750 1750 1850");
    assert_eq!(times(&deltas, Auto, false), "0 500 back@3 250 1000 100");
    assert_eq!(times(&deltas, Delta, false), "0 500 750 1750 1850");
    assert_eq!(times(&deltas, Zero, true), "0 500 250 1000 100");
    assert_eq!(times(&deltas, Absolute, false), "0 500 250 1000 100");

    let zero = console(&["000.000000", "000.500000", "000.500000", "001.000000"]);
    for regular in [true, false] {
        assert_eq!(times(&zero, Auto, regular), "0 500 500 1000");
    }
    // an epoch is never a difference, nor is a line of the other family
    let absolute = console(&["1549455524.5", "1549455524.25", "1549455525.0"]);
    assert_eq!(times(&absolute, Auto, true), "1549455524500 1549455524250 1549455525000");
    assert_eq!(times(&absolute, Delta, true), "1549455524500 1549455524250 1549455525000");
    let log = "(0.5) can0 701#05\n(0.2) can0 701#05\n(0.4) can0 701#05\n";
    for stamps in [Auto, Delta] {
        assert_eq!(times(log, stamps, true), "500 200 400");
    }
    // a difference counts from the line before, whether or not that could be read
    let broken = format!("{deltas} (000.500000)  can0  701   [2]  05\n (000.500000)  can0  ERROR\n{deltas}");
    assert_eq!(times(&broken, Auto, true), "0 500 750 1750 1850 2850 3350 3600 4600 4700");
    // no end of the number line
    let huge = console(&["000.5", "000.4", "99999999.9"]);
    assert_eq!(times(&huge, Auto, true), "500 900 100000000800");
}

#[test]
fn what_stamps_mean_is_decided_on_the_beginning_only() {
    let rising: String = (0..3000).map(|ms| format!(" ({}.{:03})  can0  080   [0] \n", ms / 1000, ms % 1000)).collect();
    assert!(rising.len() > HEAD);
    let late = format!("{rising} (000.001)  can0  080   [0] \n");
    assert!(times(&late, Stamps::Auto, true).ends_with("2998 2999 1"));
    assert!(times(&late, Stamps::Auto, false).ends_with("2998 2999 back@3001 1"));
    // a file whose beginning has no stamps is as uncertain as a pipe
    let notes = format!("{}\n", "# notes\n".repeat(HEAD / 8));
    assert!(times(&format!("{notes}{late}"), Stamps::Auto, true).contains("back@"));
}

#[test]
fn a_line_without_end() {
    for regular in [true, false] {
        let mut text = vec![b'7'; 3 * MAX_LINE];
        text.extend_from_slice(b"\n(1.5) can0 601#40\n");
        for cuts in [&[][..], &[1, 1, 70_000, 1, 120_000], &[3 * MAX_LINE], &[3 * MAX_LINE + 1]] {
            assert_eq!(items(&text, Stamps::Auto, regular, cuts), "1! NoFrame\n2: 1500000000 can0 601 1 40\n2 lines\n");
        }
        // the longest line that is one, and the first that is not, though it looks like a frame to its end
        for more in [0, 1] {
            let zeros = "0".repeat(MAX_LINE - 16 + more);
            let text = format!("(0.{zeros}) can0 601#40\n");
            assert_eq!(text.len(), MAX_LINE + more + 1);
            let whole = items(text.as_bytes(), Stamps::Auto, regular, &[]);
            assert_eq!(whole, items(text.as_bytes(), Stamps::Auto, regular, &[10, 20]));
            assert!(whole.starts_with(if more == 0 { "1: 0 can0 601 1 40" } else { "1! NoFrame" }), "{whole}");
        }
    }
}

#[test]
fn memory_stays_bounded() {
    let mut reader = Candump::new(Stamps::Auto, true);
    let mut buses = Buses::default();
    for _ in 0..100 {
        reader.feed(&[0; 100_000], &mut buses, &mut |_, _| {});
        assert!(reader.begun.capacity() <= 4 * MAX_LINE);
    }
    assert_eq!(reader.lines(), 1);
}

fn regex(pattern: &str) -> impl Strategy<Value = String> + use<> {
    proptest::string::string_regex(pattern).unwrap()
}

/// Generates text similar to captures, whole and in pieces.
fn captures() -> impl Strategy<Value = Vec<u8>> {
    let stamp =
        "(\\((0{1,3}|1549455524|7)\\.[0-9]{1,10}\\) {1,2}|\\(2026-11-2[0-9] 00:38:39\\.[0-9]{6}\\) |\\([0-9]\\) )?";
    let compact = format!(
        "{stamp}(can[01] )?[0-7][0-9A-F]{{2}}([0-9]{{5}})?#(R[0-9]?|#?([0-9a-fA-F]{{2}}){{0,9}})(_[9A-F])?( [TR])?"
    );
    let console = format!(
        "[ \t]{{0,2}}{stamp}(can[01]  )?([TR]X [-B] [-E]  )?([0-7][0-9A-F]{{2}}|[0-3]0000[0-9]{{3}})   (\\[[0-8]\\]|\\[[01][0-9]\\]|\\{{[0-9A-F]\\}})  ([0-9A-F]{{2}}[ `]){{0,9}}(remote request)?"
    );
    let tail = "(\r|   ERRORFRAME|  '..'|\x1b\\[0m| # [a-z节点]{0,5}|)";
    let other = prop_oneof![
        Just("DROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 5)"),
        Just("  can0  20000004   [8]  00 04 00 00 00 00 00 00   ERRORFRAME"),
        Just("\t20000004   [8]  00 04 00 00 00 00 00 00   ERRORFRAME"),
        Just("\tcontroller-problem"),
        Just("  can0  ERROR"),
        Just("$ candump can0"),
        Just(""),
    ];
    let bytes = prop_oneof![
        4 => (regex(&compact), tail).prop_map(|(line, tail)| format!("{line}{tail}").into_bytes()),
        4 => (regex(&console), tail).prop_map(|(line, tail)| format!("{line}{tail}").into_bytes()),
        2 => other.prop_map(|line| line.as_bytes().to_vec()),
        1 => prop::collection::vec(any::<u8>(), 0..30),
    ];
    let damaged = (bytes, prop::option::weighted(0.2, any::<prop::sample::Index>())).prop_map(|(mut line, cut)| {
        if let Some(cut) = cut {
            line.truncate(cut.index(line.len() + 1));
        }
        line
    });
    (prop::collection::vec(damaged, 0..20), any::<bool>()).prop_map(|(lines, newline)| {
        let mut text = lines.join(&b'\n');
        if newline {
            text.push(b'\n');
        }
        text
    })
}

proptest! {
    #[test]
    fn chunking_does_not_matter(
        text in captures(),
        cuts in prop::collection::vec(0usize..50, 0..30),
        regular in any::<bool>(),
        stamps in prop::sample::select(&[Stamps::Auto, Stamps::Delta, Stamps::Zero][..]),
    ) {
        let whole = items(&text, stamps, regular, &[]);
        prop_assert_eq!(&whole, &items(&text, stamps, regular, &cuts));
        prop_assert_eq!(&whole, &items(&text, stamps, regular, &vec![1; text.len()]));
    }

    #[test]
    fn any_bytes_are_survived(text in prop::collection::vec(any::<u8>(), 0..2000), cuts in prop::collection::vec(0usize..500, 0..10)) {
        prop_assert_eq!(items(&text, Stamps::Auto, true, &[]), items(&text, Stamps::Auto, true, &cuts));
        let _ = super::line(&text, &mut Buses::default());
    }

    // Each line gives a frame, a marker, an unreadable one, or may be ignored.
    #[test]
    fn a_damaged_frame_is_never_silent(frame in "can0  601   \\[8\\]  ([0-9A-F]{2} ){7}[0-9A-F]{2}", at in any::<prop::sample::Index>(), new in "[!-~]") {
        let mut text = frame.clone();
        let at = at.index(text.len());
        text.replace_range(at..=at, &new);
        prop_assume!(at != 0);
        let text = read(&format!("{text}\n"));
        prop_assert_eq!(text.lines().count(), 2, "{}", text);
    }
}

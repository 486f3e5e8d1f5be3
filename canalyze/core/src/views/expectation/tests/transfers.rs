//! SDO transfers: missing, other, forbidden, out of order.

use super::check;

const NODE: &str = r#""node":5,"index":4119,"sub":0"#;

/// A write of a 16-bit value to 1017h of node 5, and its confirmation.
fn write(time: f64, value: u16) -> String {
    let [low, high] = value.to_le_bytes();
    format!("{time} 605#2B171000{low:02X}{high:02X}0000;{} 585#6017100000000000;", time + 0.001)
}

/// A read of it.
fn read(time: f64, value: u16) -> String {
    let [low, high] = value.to_le_bytes();
    format!("{time} 605#4017100000000000;{} 585#4B171000{low:02X}{high:02X}0000;", time + 0.001)
}

/// A write that the server aborts.
fn refused(time: f64, code: u32) -> String {
    let [a, b, c, d] = code.to_le_bytes();
    let abort = format!("{a:02X}{b:02X}{c:02X}{d:02X}");
    format!("{time} 605#2B171000E8030000;{} 585#80171000{abort};", time + 0.001)
}

fn entry(more: &str) -> String {
    format!("{NODE}{more}")
}

fn held(more: &[&str], frames: &str, expected: &[(&str, u64, u64, u64)]) {
    let entries: Vec<_> = more.iter().map(|more| entry(more)).collect();
    check("sdo", &entries.iter().map(String::as_str).collect::<Vec<_>>(), frames, expected);
}

const THOUSAND: &str = r#","direction":"download","value":{"number":1000}"#;

#[test]
fn transfers_that_must_occur() {
    held(&[THOUSAND], &write(1.0, 1000), &[]);
    held(&[THOUSAND], "1 705#05", &[("EXP001", 1, 0, 1)]);
    // A read is not a write.
    held(&[THOUSAND], &read(1.0, 1000), &[("EXP001", 2, 0, 1)]);
    held(&[r#","direction":"upload""#], &read(1.0, 1000), &[]);
    held(&[""], &write(1.0, 7), &[]);
    // Another value: the last one, and only if the expected one never comes.
    held(&[THOUSAND], &(write(1.0, 7) + &write(2.0, 8) + "3 705#05"), &[("EXP003", 4, 0, 1)]);
    held(&[THOUSAND], &(write(1.0, 7) + &write(2.0, 1000)), &[]);
    held(&[THOUSAND], &(write(1.0, 1000) + &write(2.0, 7)), &[]);
    // A transfer that another expectation requires is not reported as the one that came instead.
    let zero = r#","direction":"download","value":{"number":0}"#;
    held(&[THOUSAND, zero], &(write(1.0, 0) + "3 705#05"), &[("EXP001", 3, 0, 1)]);
    // Without timestamps.
    held(&[THOUSAND], "- 605#2B171000E8030000;- 585#6017100000000000", &[]);
    // Another node, another bus.
    let other = write(1.0, 1000).replace("605#", "606#").replace("585#", "586#");
    held(&[THOUSAND], &other, &[("EXP001", 2, 0, 1)]);
}

#[test]
fn counts() {
    let twice = r#","count":2"#;
    held(&[twice], &(write(1.0, 1) + &read(2.0, 1)), &[]);
    held(&[twice], &write(1.0, 1), &[("EXP001", 2, 0, 1)]);
    let never = r#","count":0"#;
    held(&[never], &(read(1.0, 1) + &read(2.0, 2)), &[("EXP004", 2, 0, 1), ("EXP004", 4, 0, 1)]);
    held(&[never], &refused(1.0, 0x0601_0002), &[]);
    let any = r#","count":0,"outcome":"any","direction":"download""#;
    held(&[any], &refused(1.0, 0x0601_0002), &[("EXP004", 2, 0, 1)]);
    held(&[any], "1 605#2B171000E8030000;2 705#05", &[("EXP004", 2, 0, 1)]);
    held(&[r#","count":0,"value":{"number":3}"#], &(read(1.0, 1) + &read(2.0, 3)), &[("EXP004", 4, 0, 1)]);
}

#[test]
fn outcomes() {
    let aborted = r#","outcome":"aborted","abort":100728834"#;
    held(&[aborted], &refused(1.0, 0x0601_0002), &[]);
    held(&[aborted], &refused(1.0, 0x0602_0000), &[("EXP003", 2, 0, 1)]);
    held(&[aborted], &write(1.0, 1000), &[("EXP003", 2, 0, 1)]);
    held(&[aborted], "1 705#05", &[("EXP001", 1, 0, 1)]);
    held(&[r#","outcome":"aborted""#], &refused(1.0, 0x0602_0000), &[]);
    held(&[r#","outcome":"aborted""#], &write(1.0, 1000), &[("EXP003", 2, 0, 1)]);
    held(&[THOUSAND], &refused(1.0, 0x0601_0002), &[("EXP003", 2, 0, 1)]);
    // Cut by the end of the capture: it has not occurred.
    held(&[THOUSAND], "1 605#2B171000E8030000;2 705#05", &[("EXP001", 2, 1, 1)]);
}

#[test]
fn time_limits() {
    let within = r#","within_ns":2500000000"#;
    held(&[within], &(write(1.0, 1) + &write(3.4, 1)), &[]);
    held(&[within], &("1 705#05;".to_owned() + &write(3.6, 1) + &write(4.0, 1)), &[("EXP001", 3, 0, 1)]);
    held(&[within], "- 605#2B171000E8030000;- 585#6017100000000000", &[("EXP015", 2, 0, 1)]);
}

fn step(direction: &str, value: u16) -> String {
    format!(r#","sequence":"s","direction":"{direction}","value":{{"number":{value}}}"#)
}

#[test]
fn sequences() {
    let (one, two, three) = (step("download", 1), step("download", 2), step("download", 3));
    let all = [one.as_str(), two.as_str(), three.as_str()];
    let run =
        |values: &[u16]| values.iter().zip(1..).map(|(value, at)| write(f64::from(at), *value)).collect::<String>();
    held(&all, &run(&[1, 2, 3]), &[]);
    held(&all, &run(&[9, 1, 1, 8, 2, 7, 2, 3, 1]), &[]);
    // A scan before it is harmless.
    held(&all, &run(&[3, 2, 1, 1, 2, 3]), &[]);
    // Out of order, and named once.
    held(&all, &run(&[1, 3, 2]), &[("EXP002", 4, 0, 3)]);
    held(&all, &run(&[2, 1, 3]), &[("EXP002", 2, 0, 2)]);
    // One late step is one fault, however many were to follow it.
    held(&all, &run(&[2, 3, 1]), &[("EXP002", 2, 0, 2)]);
    // Two faults.
    let (four, five) = (step("download", 4), step("download", 5));
    let longer = [one.as_str(), &two, &three, &four, &five];
    held(&longer, &run(&[2, 3, 4, 5, 1]), &[("EXP002", 2, 0, 2)]);
    held(&longer, &run(&[2, 1, 3, 5, 4]), &[("EXP002", 2, 0, 2), ("EXP002", 8, 0, 5)]);
    // Missing: later steps are not affected.
    held(&all, &run(&[1, 3]), &[("EXP001", 4, 0, 2)]);
    held(&all, &run(&[2, 3]), &[("EXP001", 4, 0, 1)]);
    held(&all, &run(&[]), &[]);
    held(&all, "1 705#05", &[("EXP001", 1, 0, 1), ("EXP001", 1, 0, 2), ("EXP001", 1, 0, 3)]);
    held(&all, &run(&[1, 2, 4]), &[("EXP003", 6, 0, 3)]);
    // The same step twice takes two transfers.
    let again = [one.as_str(), two.as_str(), one.as_str()];
    held(&again, &run(&[1, 2, 1]), &[]);
    held(&again, &run(&[1, 2]), &[("EXP001", 4, 0, 3)]);
    held(&again, &run(&[2, 1]), &[("EXP002", 2, 0, 2), ("EXP001", 4, 0, 3)]);
    // Sequences of other names are independent.
    let other = r#","sequence":"t","direction":"upload""#;
    held(&[&one, other, &two], &(write(1.0, 1) + &write(2.0, 2) + &read(3.0, 5)), &[]);
    held(&[&one, other, &two], &(read(1.0, 5) + &write(2.0, 1) + &write(3.0, 2)), &[]);
}

#[test]
fn late_echoes_and_buses() {
    // The client's frames are one late, as on its own host.
    held(&[THOUSAND], "1 585#6017100000000000;1.0001 605#2B171000E8030000;2 705#05", &[]);
    let on_one = format!(r#"{THOUSAND},"bus":"can1""#);
    held(&[&on_one], "1 605#2B171000E8030000;1.1 585#6017100000000000;2 705#05 can1", &[("EXP001", 3, 0, 1)]);
    held(&[&on_one], "0 705#05;1 605#2B171000E8030000 can1;1.1 585#6017100000000000 can1", &[]);
    // Interleaved with another node's.
    let mixed = "1 605#2B171000E8030000;1.1 606#2B17100007000000;1.2 586#6017100000000000;1.3 585#6017100000000000";
    held(&[THOUSAND], mixed, &[]);
}

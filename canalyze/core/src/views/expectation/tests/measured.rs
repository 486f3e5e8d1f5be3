//! Signals, latencies and the load.

use super::check;

fn signal(more: &str, frames: &str, expected: &[(&str, u64, u64, u64)]) {
    check("signal", &[more], frames, expected);
}

/// TPDO 1 of node 5 with this velocity in 0.1 rpm.
fn pdo(time: f64, velocity: i32) -> String {
    let [a, b, c, d] = velocity.to_le_bytes();
    format!("{time} 185#3702{a:02X}{b:02X}{c:02X}{d:02X}01;")
}

#[test]
fn ranges() {
    let velocity = r#""select":"5.TPDO1.velocity*","min":-1.0,"max":0.3"#;
    signal(velocity, &(pdo(0.0, 3) + &pdo(1.0, -10)), &[]);
    signal(velocity, &(pdo(0.0, 4) + &pdo(1.0, -11)), &[("EXP007", 1, 0, 1), ("EXP007", 2, 0, 1)]);
    signal(r#""select":"5.606C:00","max":0"#, &pdo(0.0, 1), &[("EXP007", 1, 0, 1)]);
    signal(r#""select":"door","min":1"#, &pdo(0.0, 1), &[]);
    signal(r#""select":"door","max":0"#, &pdo(0.0, 1), &[("EXP007", 1, 0, 1)]);
    // A PDO that is shorter than the default mapping has another one.
    signal(velocity, "0 185#3702FF", &[("EXP015", 1, 0, 1)]);
}

#[test]
fn signals_that_do_not_come() {
    signal(r#""select":"6.*""#, &pdo(0.0, 1), &[("EXP016", 1, 0, 1)]);
    signal(r#""select":"5.TPDO2.*""#, &pdo(0.0, 1), &[("EXP016", 1, 0, 1)]);
    signal(r#""select":"5.TPDO1.*""#, &pdo(0.0, 1), &[]);
    // A PDO without mapping may be the one.
    signal(r#""select":"6.TPDO1.speed""#, "0 186#0102", &[("EXP015", 1, 0, 1)]);
    signal(r#""select":"speed""#, "0 186#0102", &[("EXP015", 1, 0, 1)]);
    signal(r#""select":"6.TPDO2.speed""#, "0 186#0102", &[("EXP016", 1, 0, 1)]);
    signal(r#""select":"7.speed""#, "0 186#0102", &[("EXP016", 1, 0, 1)]);
}

#[test]
fn rates() {
    let rate = r#""select":"5.*","period_ns":100000000,"tolerance_ns":10000000"#;
    signal(rate, &(pdo(0.0, 1) + &pdo(0.1, 1) + &pdo(0.21, 1)), &[]);
    signal(rate, &(pdo(0.0, 1) + &pdo(0.12, 1) + &pdo(0.22, 1)), &[("EXP008", 2, 1, 1)]);
    signal(rate, &(pdo(0.0, 1) + &pdo(0.05, 1)), &[("EXP008", 2, 1, 1)]);
    signal(rate, &(pdo(0.0, 1) + "5 706#05"), &[("EXP008", 2, 1, 1)]);
    // Stopped by a command, or in another state.
    signal(rate, &(pdo(0.0, 1) + "0.01 000#8005;5 000#0105;" + &pdo(5.01, 1)), &[]);
    signal(rate, &(pdo(0.0, 1) + "0.01 705#7F;5 706#05"), &[]);
    signal(rate, "- 185#37020000000000;- 185#37020000000000", &[("EXP015", 2, 0, 1)]);
    // Each PDO has its own.
    signal(rate, &(pdo(0.0, 1) + "0.05 285#00000000;" + &pdo(0.1, 1) + "0.15 285#00000000"), &[]);
}

fn latency(more: &str, frames: &str, expected: &[(&str, u64, u64, u64)]) {
    check("latency", &[more], frames, expected);
}

#[test]
fn of_sdo() {
    let sdo = r#""of":"sdo","node":5,"max_ns":20000000"#;
    latency(sdo, "0 605#4017100000000000;0.02 585#4B17100001000000", &[]);
    latency(sdo, "0 605#4017100000000000;0.03 585#4B17100001000000", &[("EXP013", 2, 1, 1)]);
    // Each exchange of a segmented transfer counts.
    let segmented = "0 605#4008100000000000;0.01 585#4108100009000000;0.02 605#6000000000000000;\
        0.05 585#0041424344454647;0.06 605#7000000000000000;0.07 585#1B48490000000000";
    latency(sdo, segmented, &[("EXP013", 4, 3, 1)]);
    // A request captured late is not measured.
    latency(sdo, "0 585#4B17100001000000;0.001 605#4017100000000000;1 705#05", &[("EXP015", 3, 0, 1)]);
    let object = r#""of":"sdo","index":4119,"sub":0,"max_ns":20000000"#;
    latency(object, "0 605#4008100000000000;0.05 585#4308100041424300", &[("EXP015", 2, 0, 1)]);
    latency(object, "0 605#4017100000000000;0.05 585#4B17100001000000", &[("EXP013", 2, 1, 1)]);
    latency(sdo, "- 605#4017100000000000;- 585#4B17100001000000", &[("EXP015", 2, 0, 1)]);
}

#[test]
fn of_sync() {
    let sync = r#""of":"sync","node":5,"pdo":2,"max_ns":1000000"#;
    latency(sync, "0 080#;0.0005 285#00000000;0.01 080#;0.0105 285#00000000", &[]);
    latency(sync, "0 080#;0.0005 285#00000000;0.01 080#;0.012 285#00000000", &[("EXP013", 4, 0, 1)]);
    latency(sync, "0 080#;0.0005 185#00000000000000", &[("EXP015", 2, 0, 1)]);
}

#[test]
fn of_nmt() {
    let nmt = r#""of":"nmt","max_ns":500000000"#;
    latency(nmt, "0 705#7F;0.1 000#0100;0.5 705#05", &[]);
    latency(nmt, "0 705#7F;0.1 000#0105;0.7 705#05", &[("EXP013", 3, 2, 1)]);
    latency(nmt, "0 705#7F;0.1 000#0105;0.3 705#7F;0.9 705#7F;1 705#05", &[("EXP013", 4, 2, 1)]);
    // It was in the state already; it resets instead; a reset takes its time.
    latency(nmt, "0 705#05;0.1 000#0105;0.9 705#05", &[("EXP015", 3, 0, 1)]);
    latency(nmt, "0 705#05;0.1 000#8105;0.9 705#00", &[("EXP013", 3, 2, 1)]);
    latency(nmt, "0 705#7F;0.1 000#0105;0.9 705#00", &[("EXP015", 3, 0, 1)]);
}

#[test]
fn of_the_bus() {
    let frames =
        |gap: f64| (0..400).map(|no| format!("{} 185#3702000000000001;", f64::from(no) * gap)).collect::<String>();
    let load = |more: &str, frames: &str, expected: &[(&str, u64, u64, u64)]| check("load", &[more], frames, expected);
    let tenth = r#""max_percent":50,"bit_rate":125000,"window_ns":100000000"#;
    // A frame of 8 bytes takes about 1 ms at 125 kbit/s.
    load(tenth, &frames(0.004), &[]);
    load(tenth, &frames(0.0015), &[("EXP014", 52, 0, 1)]);
    // Half a second of a full bus, with the default window; a tenth of a window does not count.
    let full = |count: u32| {
        (0..count).map(|no| format!("{} 185#3702000000000001;", f64::from(no) * 0.000_97)).collect::<String>()
    };
    let ninety = r#""max_percent":90,"bit_rate":125000"#;
    load(ninety, &full(515), &[("EXP014", 93, 0, 1)]);
    load(ninety, &full(10), &[]);
    load(r#""max_percent":50"#, &frames(0.0015), &[("EXP015", 400, 0, 1)]);
    load(tenth, "- 705#05", &[("EXP015", 1, 0, 1)]);
    load(r#""max_percent":50,"bit_rate":125000,"bus":"can1""#, &frames(0.0015), &[("EXP015", 400, 0, 1)]);
}

//! The object in a multiplex PDO, and the frame from which on a write holds.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
use super::*;
use crate::session::{Knowledge, Options, Output, Rows, Session};
use crate::words::Lang;
use crate::world::dictionary::{Access, Dictionary, Form, Object, Preset};
use crate::world::network::Description;

fn object(index: u16, name: &str, data_type: u16, value: Option<u64>) -> Object {
    let preset = value.map(|value| Preset { value, relative: false, configured: false });
    let (name, unit) = (name.into(), (name == "Temperature").then(|| "degC".into()));
    let factor = if unit.is_some() { 0.1 } else { 1.0 };
    Object { index, sub: 0, name, data_type, access: Access::Rw, preset, mappable: true, unit, factor }
}

fn description(node: u8, objects: Vec<Object>) -> Description {
    let dictionary = Arc::new(Dictionary::new("x.eds".into(), Form::Eds, String::new(), objects));
    Description { bus: None, node, dictionary }
}

/// Returns the decoded object of a multiplex PDO of node 4.
fn known(frame: &str) -> String {
    let descriptions = vec![
        description(4, vec![object(0x1A00, "x", 5, Some(255)), object(0x2000, "Own", 5, None)]),
        description(
            5,
            vec![
                object(0x2000, "Temperature", 3, None),
                object(0x2001, "Counter", 0x1B, None),
                object(0x2002, "Level", 6, None),
                object(0x2003, "Five's", 6, None),
                object(0x607A, "Target position", 4, None),
                object(0x6040, "Acceleration", 6, None),
            ],
        ),
        description(6, vec![object(0x2002, "Level", 6, None), object(0x2003, "Six's", 6, None)]),
    ];
    let network = Arc::new(Network { descriptions, ..Network::default() });
    let known = Knowledge { network, ..Knowledge::default() };
    let mut session = Session::new(Options { known, ..Options::of(Lang::En, &[Output::json(Rows::Frames)]) });
    let mut out = Vec::new();
    session.begin(b"x.log", crate::bytes::readers::InputFormat::Candump, true);
    session.feed(format!("(1.000000) can0 184#{frame}\n").as_bytes(), &mut out);
    session.finish(&mut out);
    let line = out.split(|byte| *byte == b'\n').next().unwrap();
    let mpdo = &serde_json::from_slice::<serde_json::Value>(line).unwrap()["pdo"]["mpdo"];
    ["name", "type", "value", "unit", "text"].map(|key| mpdo[key].to_string().replace('"', "")).join("|")
}

#[test]
fn the_object_in_a_multiplex_pdo() {
    for (frame, expected) in [
        // The consumer's object, by its own length; bytes after it do not count.
        ("850020002AFFEEEE", "Temperature|INTEGER16|-21.4|degC|-21.4 degC"),
        ("857A6000FEFFFFFF", "target position|INTEGER32|-2|null|-2"),
        ("854060000F000000", "Acceleration|UNSIGNED16|15|null|15"),
        // A type longer than four bytes.
        ("850120002A000000", "Counter|null|null|null|null"),
        // The producer's object in source address mode.
        ("040020002A000000", "Own|UNSIGNED8|42|null|42"),
        ("050020002A000000", "Temperature|INTEGER16|4.2|degC|4.2 degC"),
        // To all nodes: described, but not by the producer; if two consumers differ, neither.
        ("800020002A000000", "Temperature|INTEGER16|4.2|degC|4.2 degC"),
        ("800220002A000000", "Level|UNSIGNED16|42|null|42"),
        ("800320002A000000", "null|null|null|null|null"),
        // Not described: only the standard's objects.
        ("8917100064000000", "producer heartbeat time|UNSIGNED16|100|null|100"),
        ("890020002A000000", "null|null|null|null|null"),
        ("800500002A000000", "null|null|null|null|null"),
        ("000020002A000000", "null|null|null|null|null"),
    ] {
        assert_eq!(known(frame), expected, "{frame}");
    }
}

/// Returns the node and number of the PDO in each frame of 281h in a capture.
fn producers(capture: &str) -> Vec<String> {
    let mut session = Session::new(Options::of(Lang::En, &[Output::json(Rows::Frames)]));
    let mut out = Vec::new();
    session.begin(b"x.log", crate::bytes::readers::InputFormat::Candump, true);
    session.feed(capture.as_bytes(), &mut out);
    session.finish(&mut out);
    let rows = out.split(|byte| *byte == b'\n').filter(|line| !line.is_empty());
    let rows = rows.map(|line| serde_json::from_slice::<serde_json::Value>(line).unwrap());
    let pdos = rows.filter(|row| row["id"] == "281" && row["service"] == "pdo");
    pdos.map(|row| format!("{}.{}", row["node"], row["pdo"]["number"])).collect()
}

#[test]
fn a_write_holds_from_the_later_frame_of_its_pair() {
    // TPDO1 of node 5 moves to 281h, which is TPDO2 of node 1 in the pre-defined connection set. Either frame of the
    // exchange may come first; the channel does not go on after it.
    let request = "can0 605#2300180181020040";
    let response = "can0 585#6000180100000000";
    let (pdo, other) = ("can0 281#01", "can0 605#4000100000000000");
    for (before, first, second) in [
        ("can0 705#00", request, response),
        ("can0 705#00", response, request),
        ("can0 605#4018100100000000\ncan0 585#4F18100105000000", request, response),
        ("can0 605#4018100100000000\ncan0 585#4F18100105000000", response, request),
    ] {
        let lines = [before, pdo, first, pdo, second, pdo, other, pdo, "can0 705#00", pdo];
        let lines = lines.iter().flat_map(|lines| lines.lines()).enumerate();
        let capture: String = lines.map(|(at, line)| format!("(1.{at:03}000) {line}\n")).collect();
        // After the reset it is gone.
        assert_eq!(producers(&capture), ["1.2", "1.2", "5.1", "5.1", "1.2"], "{first}, {second}");
    }
}

//! The configuration of a network and its effect on frames: the PDO and node of an identifier, its mapping, and its
//! source, as a table over everything that moves an identifier.

use super::pdo::{reads, writes};
use super::*;
use crate::bytes::frame::CanId;
use crate::world::dictionary::{Access, Dictionary, Form, Object, Preset};
use crate::world::network::{Cob, Description, Sdo};

/// Returns one line per frame with service, node, PDO, source, and values: `pdo 5 TPDO1 observed 1,2`.
fn said(text: &str, network: Network) -> Vec<String> {
    let frames = lines(&log(text), network).into_iter().filter(|line| line["kind"] == "frame");
    frames
        .map(|line| {
            let mut out = format!("{} {}", line["service"].as_str().unwrap(), line["node"]);
            let pdo = &line["pdo"];
            if let Some(name) = pdo["pdo"].as_str() {
                out += &format!(" {name}");
            }
            if let Some(from) = pdo["provenance"].as_str() {
                let values = pdo["signals"].as_array().unwrap().iter().map(|signal| signal["value"].to_string());
                out += &format!(" {from} {}", values.collect::<Vec<_>>().join(","));
            }
            if let Some(number) = pdo["consumer"]["number"].as_u64() {
                out += &format!(" by {} RPDO{number}", pdo["consumer"]["node"]);
            }
            out
        })
        .collect()
}

/// Returns that line for the last frame.
fn last(text: &str) -> String {
    last_with(text, Network::default())
}

fn last_with(text: &str, network: Network) -> String {
    said(text, network).pop().unwrap()
}

fn preset(index: u16, sub: u8, value: u64, relative: bool) -> Object {
    let preset = Some(Preset { value, relative, configured: false });
    let (name, unit, access) = ("x".into(), None, Access::Rw);
    Object { index, sub, name, data_type: 7, access, preset, mappable: true, unit, factor: 1.0 }
}

fn described(nodes: &[u8], form: Form, objects: Vec<Object>) -> Network {
    let dictionary = Arc::new(Dictionary::new("x.eds".into(), form, String::new(), objects));
    let of = |node: &u8| Description { bus: None, node: *node, dictionary: Arc::clone(&dictionary) };
    Network { descriptions: nodes.iter().map(of).collect(), ..Network::default() }
}

const MAPPED: &str = "1A00:00 u8 0\n 1A00:01 u32 20000110\n 1A00:02 u32 20010010\n 1A00:00 u8 2\n";

#[test]
fn pdos_by_sdo() {
    let mapped = writes(0.0, MAPPED);
    for (text, expected) in [
        (format!("{mapped} 50 185#01000200"), "pdo 5 TPDO1 observed 1,2"),
        (format!("{} 50 185#01000200", reads(0.0, MAPPED)), "pdo 5 TPDO1 observed 1,2"),
        // Incomplete, and refused.
        (format!("{} 50 185#01000200", reads(0.0, "1A00:00 u8 2\n 1A00:01 u32 20000110")), "pdo 5 TPDO1"),
        (
            format!("{mapped} 20 605#2F001A0000000000\n 21 585#80001A0000000106\n 50 185#01000200"),
            "pdo 5 TPDO1 observed 1,2",
        ),
        (format!("{mapped} {} 50 185#01000200", writes(20.0, "1A00:00 u8 1")), "pdo 5 TPDO1 observed 1"),
        (format!("{mapped} {} 50 185#01000200", writes(20.0, "1A00:00 u8 0")), "pdo 5 TPDO1"),
        // Gaps, dummies, bits.
        (
            format!(
                "{} 50 185#01FF0200",
                writes(
                    0.0,
                    "1A00:00 u8 0\n 1A00:01 u32 20000108\n 1A00:02 u32 00050008\n 1A00:03 u32 00000000\n 1A00:04 u32 20010010\n 1A00:00 u8 4"
                )
            ),
            "pdo 5 TPDO1 observed 1,2",
        ),
        // PDO5, by SDO, of 11 and of 29 bits.
        (
            format!(
                "{} 50 6A5#0700",
                writes(0.0, "1804:01 u32 800006A5\n 1A04:00 u8 1\n 1A04:01 u32 20000110\n 1804:01 u32 400006A5")
            ),
            "pdo 5 TPDO5 observed 7",
        ),
        (
            format!("{} 50 00012345#0700", writes(0.0, "1A04:00 u8 1\n 1A04:01 u32 20000110\n 1804:01 u32 20012345")),
            "pdo 5 TPDO5 observed 7",
        ),
        (format!("{} 50 00012345#0700", writes(0.0, "1804:01 u32 A0012345\n 1804:01 u32 80000000")), "foreign null"),
        (format!("{} 50 1A5#07", writes(0.0, "1400:01 u32 000001A5")), "pdo 37 TPDO1"),
        // A PDO that has left its identifier.
        (format!("{} 50 185#07", writes(0.0, "1800:01 u32 400001B0")), "foreign null"),
        (format!("{} 50 1B0#07", writes(0.0, "1800:01 u32 400001B0")), "pdo 5 TPDO1"),
    ] {
        assert_eq!(last(&text), expected, "{text}");
    }
}

#[test]
fn mappings_in_time() {
    let text = format!(
        "{}20 185#01000200\n{}50 185#01000200\n",
        writes(0.0, MAPPED),
        writes(30.0, "1A00:00 u8 0\n 1A00:01 u32 20000120\n 1A00:00 u8 1")
    );
    let all = said(&text, Network::default());
    assert_eq!(all[8], "pdo 5 TPDO1 observed 1,2");
    assert_eq!(all.last().unwrap(), "pdo 5 TPDO1 observed 131073");
}

#[test]
fn resets_and_stores() {
    let eds = || described(&[5], Form::Eds, vec![preset(0x1A00, 0, 1, false), preset(0x1A00, 1, 0x2000_0120, false)]);
    let reset = "20 000#8105\n 21 705#00\n";
    let mapped = writes(0.0, MAPPED);
    let save = writes(10.0, "1010:01 u32 65766173");
    assert_eq!(last_with(&format!("{mapped} {reset} 50 185#01000200"), eds()), "pdo 5 TPDO1 eds 131073");
    assert_eq!(last_with(&format!("{mapped} {save} {reset} 50 185#01000200"), eds()), "pdo 5 TPDO1 observed 1,2");
    let load = writes(15.0, "1011:01 u32 64616F6C");
    assert_eq!(last_with(&format!("{mapped} {save} {load} {reset} 50 185#01000200"), eds()), "pdo 5 TPDO1 eds 131073");
    // A power-on is a reset without command; another node's is not.
    assert_eq!(last(&format!("{mapped} 20 705#00\n 50 185#01000200")), "pdo 5 TPDO1");
    assert_eq!(last(&format!("{mapped} 20 000#8106\n 21 706#00\n 50 185#01000200")), "pdo 5 TPDO1 observed 1,2");
    let moved = writes(0.0, "1800:01 u32 400001B0");
    assert_eq!(last(&format!("{moved} {reset} 50 185#07")), "pdo 5 TPDO1");
}

#[test]
fn linked_pdos() {
    // Node 6 receives node 5's TPDO1, in any order of configuration.
    let link = "0 606#2F00160000000000\n 0.3 586#6000160000000000
        1 606#2300160110000020\n 1.3 586#6000160100000000
        2 606#2F00160001000000\n 2.3 586#6000160000000000
        3 606#2300140185010000\n 3.3 586#6000140100000000\n";
    assert_eq!(last(&format!("{link} 50 185#0700")), "pdo 5 TPDO1 observed 7 by 6 RPDO1");
    assert_eq!(
        last(&format!("{link} {} 50 185#0700", writes(10.0, "1800:01 u32 40000185"))),
        "pdo 5 TPDO1 observed 7 by 6 RPDO1"
    );
    // A TPDO sent to another node's RPDO, on that identifier.
    let receiver = "0 606#2300160110000020\n 0.3 586#6000160100000000
        1 606#2F00160001000000\n 1.3 586#6000160000000000\n";
    assert_eq!(last(&format!("{receiver} 50 206#0700")), "pdo 6 RPDO1 observed 7");
    assert_eq!(
        last(&format!("{receiver} {} 50 206#0700", writes(10.0, "1800:01 u32 40000206"))),
        "pdo 5 TPDO1 observed 7 by 6 RPDO1"
    );
}

#[test]
fn options() {
    let cob = |id, transmit, number| Network {
        cobs: vec![Cob { bus: None, id, node: 5, transmit, number }],
        ..Network::default()
    };
    assert_eq!(last_with("0 6A5#07", cob(CanId::standard(0x6A5), true, 7)), "pdo 5 TPDO7");
    assert_eq!(last_with("0 00012345#07", cob(CanId::extended(0x12345), false, 1)), "pdo 5 RPDO1");
    let other = Network {
        cobs: vec![Cob { bus: Some("can9".into()), ..cob(CanId::standard(0x6A5), true, 7).cobs[0].clone() }],
        ..Network::default()
    };
    assert_eq!(last_with("0 6A5#07", other), "foreign null");
    let channel =
        |client, server| Network { sdos: vec![Sdo { bus: None, client, server, node: 9 }], ..Network::default() };
    let request = |network| said("0 640#4000200000000000\n 1 5C0#4B00200001000000", network);
    assert_eq!(request(channel(CanId::standard(0x640), CanId::standard(0x5C0))), ["sdo 9", "sdo 9"]);
    let extended = channel(CanId::extended(0x640), CanId::extended(0x5C0));
    assert_eq!(said("0 00000640#4000200000000000\n 1 000005C0#4B00200001000000", extended), ["sdo 9", "sdo 9"]);
}

#[test]
fn further_sdo_channels() {
    let asked = "50 6C1#4000200000000000\n 51 6C2#4B00200001000000\n";
    let server = writes(0.0, "1201:01 u32 000006C1\n 1201:02 u32 000006C2");
    assert_eq!(said(&format!("{server} {asked}"), Network::default())[4..], ["sdo 5", "sdo 5"]);
    let off = writes(0.0, "1201:01 u32 000006C1\n 1201:02 u32 800006C2");
    assert_eq!(said(&format!("{off} {asked}"), Network::default())[4..], ["foreign null", "foreign null"]);
    // A client's knowledge of a server: node 7.
    let client = writes(0.0, "1280:01 u32 000006C1\n 1280:02 u32 000006C2\n 1280:03 u8 7");
    assert_eq!(said(&format!("{client} {asked}"), Network::default())[6..], ["sdo 7", "sdo 7"]);
    let extended = writes(0.0, "1201:01 u32 200106C1\n 1201:02 u32 200106C2");
    let asked = "50 000106C1#4000200000000000\n 51 000106C2#4B00200001000000\n";
    assert_eq!(said(&format!("{extended} {asked}"), Network::default())[4..], ["sdo 5", "sdo 5"]);
}

#[test]
fn services_that_moved() {
    for (write, frame, expected) in [
        ("1005:00 u32 40000090", "90#", "sync null"),
        ("1005:00 u32 60012345", "00012345#", "sync null"),
        ("1012:00 u32 40000680", "680#0000000000C0", "time null"),
        ("1014:00 u32 000000B0", "0B0#1081010000000000", "emcy 5"),
        ("1014:00 u32 800000B0", "0B0#1081010000000000", "emcy 48"),
        ("1014:00 u32 20012345", "00012345#1081010000000000", "emcy 5"),
    ] {
        let frame = if frame.len() == 3 { format!("0{frame}") } else { frame.into() };
        assert_eq!(last(&format!("{} 50 {frame}", writes(0.0, write))), expected, "{write}");
    }
    // An EDS without $NODEID, of two nodes.
    let eds = || described(&[5, 6], Form::Eds, vec![preset(0x1014, 0, 0x80, false), preset(0x1005, 0, 0x80, false)]);
    assert_eq!(last_with("0 080#", eds()), "sync null");
    assert_eq!(last_with("0 086#1081010000000000", eds()), "emcy 6");
}

#[test]
fn one_description_of_two_nodes() {
    let fixed = |relative: bool, base| {
        let objects =
            vec![preset(0x1800, 1, base, relative), preset(0x1A00, 0, 1, false), preset(0x1A00, 1, 0x2000_0110, false)];
        described(&[5, 6], Form::Eds, objects)
    };
    for network in [fixed(true, 0x180), fixed(false, 0x181), fixed(false, 0x186)] {
        let all = said("0 185#0700\n 1 186#0700\n 2 181#0700", network);
        assert_eq!(all, ["pdo 5 TPDO1 eds 7", "pdo 6 TPDO1 eds 7", "pdo 1 TPDO1"]);
    }
}

#[test]
fn a_concise_dcf() {
    // 1F22h:05 of the manager, node 1: one entry, 1A00h:01, and its count; in segments.
    let entries = "02000000001A010400000010000020001A000100000001";
    let bytes: Vec<&str> = (0..entries.len()).step_by(2).map(|at| &entries[at..at + 2]).collect();
    let mut text = format!("0 601#21221F05{:02X}000000\n 0.5 581#60221F0500000000\n", bytes.len());
    for (number, chunk) in bytes.chunks(7).enumerate() {
        let (toggle, last) = (number % 2 * 0x10, (number + 1) * 7 >= bytes.len());
        let command = toggle + (7 - chunk.len()) * 2 + usize::from(last);
        let data = format!("{}{}", chunk.concat(), "00".repeat(7 - chunk.len()));
        text += &format!(
            "{} 601#{command:02X}{data}\n {} 581#{:02X}00000000000000\n",
            number + 1,
            number + 1,
            0x20 + toggle
        );
    }
    assert_eq!(last(&format!("{text} 50 185#0700")), "pdo 5 TPDO1 dcf 7");
}

#[test]
fn multiplex_pdos() {
    let text = |frame: &str| format!("{} 50 185#{frame}", writes(0.0, "1A00:00 u8 FE"));
    let mpdo = |frame: &str| {
        let line = lines(&log(&text(frame)), Network::default()).into_iter().rfind(|line| line["kind"] == "frame");
        let found = line.unwrap()["pdo"]["mpdo"].clone();
        (
            found["mode"].as_str().unwrap().to_owned(),
            found["node"].as_u64().unwrap(),
            found["index"].as_str().unwrap().to_owned(),
        )
    };
    assert_eq!(mpdo("050020012A000000"), ("sam".into(), 5, "2000".into()));
    assert_eq!(mpdo("890020012A000000"), ("dam".into(), 9, "2000".into()));
}

#[test]
fn provenance() {
    let objects = || vec![preset(0x1A00, 0, 1, false), preset(0x1A00, 1, 0x2000_0110, false)];
    assert_eq!(last_with("0 185#0700", described(&[5], Form::Eds, objects())), "pdo 5 TPDO1 eds 7");
    assert_eq!(last_with("0 185#0700", described(&[5], Form::Dcf, objects())), "pdo 5 TPDO1 dcf 7");
    // The least trusted part counts: the entry is known from the EDS only.
    let half = format!("{} 50 185#0700", reads(0.0, "1A00:00 u8 1"));
    assert_eq!(last_with(&half, described(&[5], Form::Eds, objects())), "pdo 5 TPDO1 eds 7");
}

//! Files of random bytes and of parts of valid files: no input panics, and every mistake has its line.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic)]

use proptest::prelude::*;

use super::{Mistake, expectations, schemas, settings};
use crate::bytes::ns::Ns;
use crate::views::expectation::Expectations;

/// Parts of files, valid or not.
const PARTS: &[&str] = &[
    "[[sdo]]",
    "[[eds]]",
    "[[cob]]",
    "[[signal]]",
    "[[problem]]",
    "[[latency]]",
    "[[load]]",
    "[check]",
    "[sync]",
    "[[check.override]]",
    "[a.b]",
    "[[a.b]]",
    "[",
    "]",
    "{",
    "}",
    "[[",
    "\n",
    "\n",
    "\n",
    " = ",
    " = ",
    ".",
    ",",
    "#",
    "\r\n",
    "\"",
    "'",
    "\"\"\"",
    "'''",
    "\\",
    "node",
    "object",
    "value",
    "select",
    "file",
    "id",
    "pdo",
    "codes",
    "kind",
    "occurs",
    "period_ms",
    "tolerance_percent",
    "max_us",
    "bitrate",
    "lang",
    "window_us",
    "5",
    "0x80",
    "1e300",
    "-1",
    "nan",
    "inf",
    "1_0",
    "99999999999999999999999999999999999999999",
    "0xfffffffffffffffffffffffffffffffffff",
    "1.5",
    "true",
    "false",
    "1979-05-27",
    "07:32:00",
    "\"1017:00\"",
    "\"5-7\"",
    "\"81xx\"",
    "\"TPDO1\"",
    "\"125k\"",
    "\"1-3\"",
    "\"E8 03\"",
    "\"node-*\"",
    "\"SDO\"",
    "é",
    "\u{feff}",
    "\u{0}",
    "[5, '7-9']",
    "{ file = 'a', node = 5 }",
    "[[1]]",
];

/// A mistake is one line about this file.
fn told(mistake: &Mistake) {
    let fact = |name| mistake.facts.iter().find(|fact| fact.0 == name).map(|fact| fact.1.as_str());
    let file = fact("file").unwrap();
    let line = fact("line").or_else(|| file.strip_prefix("f:")).unwrap_or_else(|| panic!("{mistake:?}"));
    assert!(line.parse::<usize>().unwrap() >= 1, "{mistake:?}");
}

fn read(content: &[u8]) {
    if let Err(mistake) = settings(content, "f") {
        told(&mistake);
    }
    match expectations(content, "f") {
        Ok(form) => _ = Expectations::normalized(form).unwrap(),
        Err(mistake) => told(&mistake),
    }
}

proptest! {
    #[test]
    fn any_bytes(content in prop::collection::vec(any::<u8>(), 0..200)) {
        read(&content);
    }

    #[test]
    fn any_parts(parts in prop::collection::vec(prop::sample::select(PARTS), 0..40)) {
        read(parts.concat().as_bytes());
    }

    #[test]
    fn any_values(
        place in any::<prop::sample::Index>(),
        values in prop::collection::vec(prop::sample::select(PARTS), 16),
        kept in any::<u32>(),
    ) {
        for (kind, schema) in schemas() {
            let (table, keys) = place.get(&schema);
            let heading = match *table {
                "" => String::new(),
                "sync" | "check" if kind == "config" => format!("[{table}]\n"),
                _ => format!("[[{table}]]\n"),
            };
            let lines = keys.iter().zip(&values).enumerate().filter(|(bit, _)| kept >> bit & 1 == 1);
            let lines: String = lines.map(|(_, ((key, ..), value))| format!("{key} = {value}\n")).collect();
            read((heading + &lines).as_bytes());
        }
    }
}

#[test]
fn every_table_is_read() {
    let expected = concat!(
        "[[sdo]]\nnode = 5\nobject = '1017:00'\n[[state]]\nnode = 5\nstate = 'boot-up'\n[[signal]]\nselect = 'a'\n",
        "[[heartbeat]]\nnode = 5\nperiod_ms = 1\n[[sync]]\nperiod_us = 1\n[[emcy]]\noccurs = 'may'\ncode = '0xxx'\n",
        "[[problem]]\noccurs = '1-'\n[[latency]]\nof = 'nmt'\nmax_ms = 1\n[[load]]\nmax_percent = 1\n"
    );
    let read = Expectations::normalized(expectations(expected.as_bytes(), "f").unwrap()).unwrap();
    assert!(read.diagnoses());
    let configured = concat!(
        "lang = 'zh'\nbitrate = 125000\n[sync]\nperiod_us = 0.5\n[[eds]]\nfile = 'a'\nnode = '1-3,2'\n[[cob]]\nid = '1A5'\n",
        "node = 5\npdo = 'rpdo2'\n[[sdo]]\nclient = '640'\nserver = '000005C0'\nnode = 5\n[check]\nselect = 'sdo,hbt'\n",
        "[[check.override]]\ncodes = ['SDO001']\nseverity = 'ignore'\nreason = 'x'\nnodes = [5, '7-8', 5]\n"
    );
    let read = settings(configured.as_bytes(), "f").unwrap();
    let check = read.check.unwrap();
    assert_eq!((read.sync_period_ns, read.bit_rate, read.lang.as_deref()), (Some(Ns(500)), Some(125_000), Some("zh")));
    assert_eq!((&read.descriptions[0].nodes[..], read.cobs[0].pdo), (&[1, 2, 3][..], (false, 2)));
    assert_eq!((read.sdos[0].client, read.sdos[0].server), ((0x640, false), (0x5C0, true)));
    assert_eq!((check.select, check.at), (vec!["SDO".into(), "HBT".into()], ("f:17".into(), "f:16".into())));
    assert_eq!((&check.overrides[0].nodes[..], check.overrides[0].at.as_str()), (&[5, 7, 8][..], "f:19"));
}

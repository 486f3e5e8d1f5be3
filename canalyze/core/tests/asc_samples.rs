//! The samples in Vector's form are what the writer makes of those in candump's, and hold the same frames.
//!
//! `CANALYZE_WRITE_SAMPLES=1 cargo test --test asc_samples` writes them anew.

#![allow(clippy::expect_used, clippy::panic)]

use std::fs;
use std::path::Path;

use canalyze_core::frame::{Buses, Frame};
use canalyze_core::readers::{Format as Input, Item, Marker, Reader, Settings};
use canalyze_core::writers::{Format, Setting, Writer};

const NAMES: [&str; 4] = ["zephyr-sdo", "services", "sdo-block", "two-nodes-interleaved"];

/// The frames and gaps of a capture, in order, with the date that their stamps count from.
fn read(text: &[u8], format: Input) -> (Vec<Item>, Buses, Option<i64>) {
    let mut reader = Reader::new(format, &Settings { regular: true, ..Settings::default() });
    let (mut items, mut buses, mut date) = (Vec::new(), Buses::default(), None);
    let mut sink = |item, _: &Buses| match item {
        Item::Marker(Marker::Start { date_ns }) => date = Some(date_ns),
        Item::Frame(_) | Item::Marker(_) => items.push(item),
        Item::Unreadable { .. } | Item::Damaged(_) => panic!("{item:?}"),
    };
    reader.feed(text, &mut buses, &mut sink);
    reader.finish(&mut buses, &mut sink);
    (items, buses, date)
}

fn written(items: &[Item], buses: &Buses) -> Vec<u8> {
    let setting = Setting { buses, date_ns: None };
    let mut writer = Writer::new(Format::Asc, &Default::default());
    let mut out = Vec::new();
    for item in items {
        match item {
            Item::Frame(frame) => writer.frame(&mut out, setting, frame),
            Item::Marker(marker) => writer.marker(&mut out, setting, marker),
            Item::Unreadable { .. } | Item::Damaged(_) => {}
        }
    }
    writer.finish(&mut out, setting);
    out
}

fn essence(frame: &Frame, buses: &Buses, date_ns: Option<i64>) -> String {
    let moment = Setting { buses, date_ns }.moment(frame);
    let raw = frame.length_form.raw_dlc;
    format!(
        "{moment:?} {:?} {:?} {:?} {:?} {raw} {:?}",
        buses.name(frame.bus),
        frame.id,
        frame.kind,
        frame.dir,
        frame.payload()
    )
}

#[test]
fn the_samples_are_what_the_writer_makes() {
    let samples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples");
    for name in NAMES {
        let log = fs::read(samples.join(format!("{name}.log"))).expect("the sample");
        let (items, buses, _) = read(&log, Input::Candump);
        let text = written(&items, &buses);
        let path = samples.join(format!("{name}.asc"));
        if std::env::var_os("CANALYZE_WRITE_SAMPLES").is_some() {
            fs::write(&path, &text).expect("a place to write to");
        }
        let kept = fs::read(&path).expect("the sample in Vector's form");
        assert!(kept == text, "{name}.asc is not what the writer makes");
        let (back, other, date) = read(&kept, Input::Asc);
        assert_eq!(back.len(), items.len());
        for (item, back) in items.iter().zip(&back) {
            match (item, back) {
                (Item::Frame(frame), Item::Frame(back)) => {
                    assert_eq!(essence(frame, &buses, None), essence(back, &other, date), "{name}");
                }
                (Item::Marker(_), Item::Marker(_)) => {}
                _ => panic!("{name}: {item:?} {back:?}"),
            }
        }
    }
}

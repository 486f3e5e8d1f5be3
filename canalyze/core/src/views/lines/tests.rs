//! Consequences in lines for people.

#![allow(clippy::unwrap_used, clippy::panic)]
use super::*;
use crate::bytes::frame::{BusId, CanId, Direction, FrameRef, LengthForm};
use crate::bytes::ns::Ns;
use crate::rules::finding::{Facts, Finding};
use crate::wire::pdo::mapping::Mapping;
use crate::world::configuration::Provenance;
use crate::world::event::{Placement, Signals, Unmapped};
use std::sync::Arc;

/// A finding at frame 9, because of frame 4 or of nothing.
fn raised(code: Code, because_of: Option<u64>) -> Event {
    let reference = |no| FrameRef { no, ..FrameRef::default() };
    let (at, bus, node) = (reference(9), BusId(0), Some(5));
    let because_of = because_of.map(reference);
    let finding = Finding { code, at, cause: None, bus, node, object: None, facts: Facts::None, because_of };
    Event { at, about: None, bus, node, transfer: None, what: What::Finding(Box::new(finding)) }
}

fn told(lang: Lang, depth: Depth) -> String {
    let mut lines = Lines::folding(lang, depth, None);
    let mut out = Vec::new();
    let events = [(Code::Syn008, Some(4)), (Code::Pdo004, Some(4)), (Code::Syn008, Some(4)), (Code::Hbt003, None)];
    lines.end(&mut out, &events.map(|(code, because_of)| raised(code, because_of)));
    lines.finish(&mut out);
    String::from_utf8(out).unwrap()
}

#[test]
fn consequences_are_one_line_a_cause() {
    let english = told(Lang::En, Depth::Default);
    let last = english.lines().last();
    let said = "PDO004 sent again within the inhibit time; SYN008 synchronous PDO missing in its cycle (2)";
    assert_eq!((english.lines().count(), last), (2, Some(&*format!("#   frame 4: 3 consequences: {said}"))));
    let chinese = told(Lang::Zh, Depth::Default);
    assert_eq!(
        chinese.lines().last(),
        Some("#   第4帧: 3条后果: PDO004 抑制时间内再次发送; SYN008 周期内缺少同步PDO (2)")
    );
}

#[test]
fn explained_lines_have_each_consequence() {
    assert_eq!(told(Lang::En, Depth::Explain).matches("#   SYN008 info: ").count(), 2);
}

/// A heartbeat of a node at a time, and what it says.
fn heartbeat(no: u64, node: u8, t_ns: Ns) -> (Frame, Event) {
    let stamp = Some(Stamp { form: StampForm::Seconds, ns: t_ns, width: 3, decimals: 1 });
    let id = crate::bytes::frame::CanId::standard(0x700 + u16::from(node));
    let frame = Frame { no, t_ns: Some(t_ns), stamp, ..Frame::classic(id, &[5]) };
    let what = What::Message(wire::decode(predefined(frame.id), &frame));
    (frame, Event { at: frame.reference(), about: None, bus: BusId(0), node: Some(node), transfer: None, what })
}

fn listed(look: Look, clock: Clocked) -> String {
    let mut lines = Lines::new(Lang::En, Depth::Default, None).looking(look);
    lines.clock = clock;
    let mut out = Vec::new();
    for (no, node, t_ns) in [(9, 4, 1_500_000_000), (1_234_567, 5, 2_500_000_000)] {
        let (frame, event) = heartbeat(no, node, Ns(t_ns));
        let found = raised(if node == 4 { Code::Hbt002 } else { Code::Hbt001 }, None);
        lines.frame(&mut out, &frame, &[event, found], &Buses::default());
    }
    String::from_utf8(out).unwrap()
}

/// The same without what colours it.
fn plain(text: &str) -> String {
    let mut parts = text.split('\x1b');
    let first = parts.next().unwrap_or("").to_owned();
    parts.fold(first, |all, part| all + part.split_once('m').map_or("", |(_, rest)| rest))
}

#[test]
fn numbers_stand_before_lines() {
    let text = listed(Look { numbered: true, ..Look::default() }, Clocked::default());
    let begins: Vec<_> = text.lines().map(|line| line.split_once("  ").map_or("", |two| two.0)).collect();
    assert!(text.starts_with("     9:  (001.5)  704 "), "{text}");
    assert!(begins.contains(&"1234567:"), "{text}");
}

#[test]
fn colours_change_no_character() {
    let (coloured, look) = (Look { coloured: true, numbered: true }, Look { numbered: true, ..Look::default() });
    let (with, without) = (listed(coloured, Clocked::default()), listed(look, Clocked::default()));
    assert_eq!(plain(&with), without);
    assert!(!without.contains('\x1b'));
    for line in with.lines() {
        let begun = line.matches('\x1b').count() - line.matches(colour::PLAIN).count();
        assert_eq!(begun, line.matches(colour::PLAIN).count(), "a colour ends with its line: {line:?}");
    }
    let [own, error, other, warning] = with.lines().collect::<Vec<_>>()[..] else { panic!("{with}") };
    assert!(own.contains(&format!("{}704", colour::node(Some(4)))), "{own}");
    assert!(own.contains(&format!("{}heartbeat", colour::named("heartbeat"))), "{own}");
    assert!(other.contains(&format!("{}705", colour::node(Some(5)))), "{other}");
    assert!(error.starts_with(colour::severity(Severity::Error)));
    assert!(warning.starts_with(colour::severity(Severity::Warning)));
}

#[test]
fn explanations_have_no_colour() {
    let mut lines = Lines::new(Lang::En, Depth::Explain, None).looking(Look { coloured: true, ..Look::default() });
    let (frame, event) = heartbeat(1, 4, Ns::ZERO);
    let mut out = Vec::new();
    lines.frame(&mut out, &frame, &[event], &Buses::default());
    let text = String::from_utf8(out).unwrap();
    let mut rows = text.lines();
    assert!(rows.next().is_some_and(|own| own.ends_with(colour::PLAIN)));
    assert!(rows.clone().count() > 1 && rows.all(|row| row.starts_with("#   ") && !row.contains('\x1b')), "{text}");
}

#[test]
fn zero_is_the_first_frame_of_the_capture() {
    let clock = Clocked { time: Some(Time::Zero), start_ns: Some(Ns(1_000_000_000)), date_ns: None };
    let text = listed(Look::default(), clock);
    assert!(text.starts_with("(000.5)") && text.contains("\n(001.5)"), "{text}");
    let clock = Clocked { time: Some(Time::Date), start_ns: None, date_ns: Some(Ns(86_400_000_000_000)) };
    assert!(listed(Look::default(), clock).starts_with("(1970-01-02 00:00:01.5)"));
}

/// Frames of PDOs that differ in one thing each, and their events; the last ones change the layout of the columns.
fn process_data() -> Vec<(Frame, Vec<Event>)> {
    let frame = Frame::classic(CanId::standard(0x181), &[0x37, 6, 0x10, 0x27, 0, 0, 0xFF, 0xFF]);
    let data = ProcessData {
        transmit: true,
        number: 1,
        node: 1,
        content: Signals::None(Unmapped::Unknown),
        state: None,
        sync: None,
        is_off: false,
    };
    let none = |why| Signals::None(why);
    let placed = Some(Placement { cycle: 4, delay_ns: Some(Ns(200_000)) });
    let mapping = Arc::new(Mapping::from_words(&[0x6041_0010, 0x6064_0020]));
    let mapped = |from| Signals::Mapped(Arc::clone(&mapping), from);
    let consumed = Signals::ByConsumer(Arc::clone(&mapping), Provenance::Eds, 9, 1);
    let form = LengthForm { braces: true, ..LengthForm::default() };
    let rows = [
        (frame, data.clone()),
        (Frame { data: [9; 64], ..frame }, data.clone()),
        (Frame { len: 7, ..frame }, data.clone()),
        (Frame { len: 0, ..frame }, data.clone()),
        (Frame { id: CanId::standard(0x281), ..frame }, ProcessData { number: 2, ..data.clone() }),
        (Frame { dir: Some(Direction::Rx), ..frame }, data.clone()),
        (Frame { dir: Some(Direction::Tx), ..frame }, data.clone()),
        (Frame { length_form: form, ..frame }, data.clone()),
        (Frame { kind: Kind::Fd { brs: true, esi: false }, ..frame }, data.clone()),
        (Frame { kind: Kind::Fd { brs: false, esi: false }, len: 12, ..frame }, data.clone()),
        (frame, ProcessData { transmit: false, ..data.clone() }),
        (frame, ProcessData { node: 2, ..data.clone() }),
        (frame, ProcessData { number: 3, ..data.clone() }),
        (frame, ProcessData { content: none(Unmapped::Disabled), ..data.clone() }),
        (frame, ProcessData { content: none(Unmapped::Contradicted), ..data.clone() }),
        (frame, ProcessData { sync: placed, ..data.clone() }),
        (frame, ProcessData { content: mapped(Provenance::Eds), ..data.clone() }),
        (frame, ProcessData { content: mapped(Provenance::Profile), sync: placed, ..data.clone() }),
        (Frame { data: [9; 64], ..frame }, ProcessData { content: mapped(Provenance::Eds), ..data.clone() }),
        (frame, ProcessData { content: consumed, ..data.clone() }),
        (Frame { bus: BusId(1), ..frame }, data.clone()),
        (Frame { bus: BusId(2), ..frame }, data.clone()),
        (Frame { id: CanId::extended(0x181), ..frame }, data.clone()),
    ];
    let event = |frame: &Frame, what| {
        let (at, bus) = (frame.reference(), frame.bus);
        Event { at, about: None, bus, node: Some(1), transfer: None, what }
    };
    let mut all: Vec<_> = rows.into_iter().map(|(frame, data)| (frame, vec![event(&frame, What::Pdo(data))])).collect();
    all.insert(1, (frame, vec![event(&frame, What::Pdo(data)), raised(Code::Pdo002, None)]));
    all
}

#[test]
fn a_line_that_is_known_is_that_which_would_be_written() {
    let mut buses = Buses::default();
    for name in [&b"can0"[..], b"can1", b"vcan12"] {
        buses.intern(name);
    }
    let all = process_data();
    for (lang, depth) in [(Lang::Zh, Depth::Default), (Lang::En, Depth::Default), (Lang::En, Depth::Brief)] {
        let (mut known, mut written) = (Lines::new(lang, depth, None), Lines::new(lang, depth, None));
        // Each form is added when those before it are known, so that a change of the layout reaches them.
        for count in 1..=all.len() {
            for (frame, events) in all.iter().take(count).cycle().take(8 * count + 40) {
                let (mut one, mut other) = (Vec::new(), Vec::new());
                known.frame(&mut one, frame, events, &buses);
                written.columns.head(&mut other, None, buses.name(frame.bus), frame);
                data(&mut other, frame);
                written.comment(&mut other, frame, events);
                assert_eq!(String::from_utf8_lossy(&one), String::from_utf8_lossy(&other), "{frame:?}");
            }
        }
    }
}

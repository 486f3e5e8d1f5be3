//! Consequences in lines for people.

#![allow(clippy::unwrap_used, clippy::panic)]
use super::*;
use crate::bytes::frame::{BusId, FrameRef};
use crate::bytes::ns::Ns;
use crate::rules::finding::{Facts, Finding};

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

//! Consequences in lines for people.

#![allow(clippy::unwrap_used)]
use super::*;
use crate::finding::{Facts, Finding};
use crate::frame::{BusId, FrameRef};

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
    assert_eq!((english.lines().count(), last), (2, Some("#   frame 4: 3 consequences: PDO004, SYN008 (2)")));
    let chinese = told(Lang::Zh, Depth::Default);
    assert_eq!(chinese.lines().last(), Some("#   第4帧: 3条后果: PDO004、SYN008 (2)"));
}

#[test]
fn explained_lines_have_each_consequence() {
    assert_eq!(told(Lang::En, Depth::Explain).matches("#   SYN008 info: ").count(), 2);
}

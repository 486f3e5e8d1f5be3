//! The report of a comparison for people: the first difference, then all of them by node, then what was compared.
//!
//! It must not decide what is a difference.

use crate::bytes::frame::{BusId, FrameRef};
use crate::problems::problem::Problem;
use crate::views::diff::Comparison;
use crate::views::diff::difference::Difference;
use crate::views::diff::digest::Digest;
use crate::views::diff::problems::ProblemDifference;
use crate::words::diff::{self as words, Phrase, phrase};
use crate::words::digits::put;
use crate::words::{Lang, problems};

/// The context of a report.
#[derive(Clone, Copy, Debug)]
pub struct DiffSetting<'a> {
    /// The language.
    pub lang: Lang,
    /// Both captures, A and B.
    pub digests: [&'a Digest; 2],
}

impl<'a> DiffSetting<'a> {
    /// The problems of a difference, each with the capture that it is of.
    pub fn problems(self, one: &ProblemDifference) -> [Option<(&'a Digest, &'a Problem)>; 2] {
        let [a, b] = self.digests;
        let [in_a, in_b] = one.sides;
        let of = |digest: &'a Digest, place: Option<usize>| Some((digest, digest.problems.get(place?)?));
        [of(a, in_a), of(b, in_b)]
    }

    /// The name of a bus: that in A, or in B where A has none.
    pub fn bus(self, bus: [Option<BusId>; 2]) -> &'a [u8] {
        let [a, b] = self.digests;
        match bus {
            [Some(bus), _] => a.buses.name(bus),
            [None, Some(bus)] => b.buses.name(bus),
            [None, None] => b"",
        }
    }
}

/// Names of both sides.
const SIDES: [&str; 2] = ["A", "B"];

/// Appends the text above the lines of the first difference.
pub fn head(out: &mut Vec<u8>, setting: DiffSetting<'_>, comparison: &Comparison) {
    let lang = setting.lang;
    problems(out, setting, comparison);
    let Some(first) = comparison.differences.first() else {
        phrase(out, lang, if comparison.stories.is_empty() { Phrase::Same } else { Phrase::NothingElse }, &[]);
        return put!(out; "\n");
    };
    phrase(out, lang, Phrase::First, &[]);
    for (side, name) in SIDES.iter().enumerate() {
        put!(out; if side > 0 { ", " } else { "" }, *name, " ");
        place(out, lang, first, side);
    }
    put!(out; "\n  ");
    home(out, setting, first);
    put!(out; ", ");
    content(out, lang, first);
    put!(out; "\n");
}

/// Appends the problems of one capture only, and those that differ.
fn problems(out: &mut Vec<u8>, setting: DiffSetting<'_>, comparison: &Comparison) {
    if comparison.stories.is_empty() {
        return;
    }
    let lang = setting.lang;
    phrase(out, lang, Phrase::Problems, &[&|out| put!(out; comparison.stories.len() as u64)]);
    put!(out; "\n");
    let mut heading = None;
    for one in &comparison.stories {
        let shown = one.sides.map(|side| side.is_some());
        if heading != Some(shown) {
            heading = Some(shown);
            put!(out; "  ");
            match shown {
                [true, true] => phrase(out, lang, Phrase::Both, &[]),
                [in_a, _] => phrase(out, lang, Phrase::Only, &[&|out| put!(out; if in_a { "A" } else { "B" })]),
            }
            put!(out; "\n");
        }
        put!(out; "    ");
        problem(out, setting, one);
        put!(out; "\n");
    }
    put!(out; "\n");
}

fn problem(out: &mut Vec<u8>, setting: DiffSetting<'_>, one: &ProblemDifference) {
    let lang = setting.lang;
    if setting.digests.iter().any(|digest| digest.lines.len() > 1) {
        words::bus(out, lang, setting.bus(one.bus));
        put!(out; ", ");
    }
    let sides = setting.problems(one);
    if let Some((digest, first)) = sides.iter().flatten().next() {
        problems::title(out, lang, first, digest.began_ns);
    }
    for differs in &one.differs {
        put!(out; "; ");
        words::respect(out, lang, *differs);
        for (place, (name, side)) in SIDES.iter().zip(sides).enumerate() {
            let Some((digest, one)) = side else { continue };
            put!(out; if place > 0 { ", " } else { " " }, *name, " ");
            words::problem(out, lang, *differs, one, digest.cause(one));
        }
    }
    put!(out; "  [");
    let shown = SIDES.iter().zip(sides).filter_map(|(name, side)| Some((name, side?.1)));
    for (place, (name, one)) in shown.enumerate() {
        put!(out; if place > 0 { ", " } else { "" }, *name, " ");
        words::frame(out, lang, one.begin);
    }
    put!(out; "]");
}

/// Appends the text below the lines of the first difference.
pub fn body(out: &mut Vec<u8>, setting: DiffSetting<'_>, comparison: &Comparison) {
    let lang = setting.lang;
    if !comparison.differences.is_empty() {
        put!(out; "\n");
        phrase(out, lang, Phrase::All, &[]);
        put!(out; "\n");
    }
    let mut all: Vec<&Difference> = comparison.differences.iter().collect();
    // By bus and node; within one they keep their order.
    all.sort_by_key(|one| (one.bus, one.node));
    let mut last = None;
    for one in all {
        if last != Some((one.bus, one.node)) {
            last = Some((one.bus, one.node));
            put!(out; "  ");
            home(out, setting, one);
            put!(out; "\n");
        }
        put!(out; "    ");
        content(out, lang, one);
        put!(out; "  [");
        for (side, name) in SIDES.iter().enumerate() {
            put!(out; if side > 0 { ", " } else { "" }, *name, " ");
            place(out, lang, one, side);
        }
        put!(out; "]\n");
    }
    closing(out, setting, comparison);
}

fn closing(out: &mut Vec<u8>, setting: DiffSetting<'_>, comparison: &Comparison) {
    let lang = setting.lang;
    let count = comparison.differences.len() as u64 + comparison.more;
    if count > 0 {
        put!(out; "\n");
        phrase(out, lang, Phrase::Count, &[&|out| put!(out; count)]);
        if comparison.more > 0 {
            put!(out; ", ");
            phrase(out, lang, Phrase::More, &[&|out| put!(out; comparison.more)]);
        }
        put!(out; "\n");
    }
    phrase(out, lang, Phrase::Compared, &[]);
    for (side, (name, extent)) in SIDES.iter().zip(extents(setting, comparison)).enumerate() {
        put!(out; if side > 0 { ", " } else { "" }, *name, " ");
        let (first, last) = extent;
        phrase(out, lang, Phrase::Frame, &[&|out| put!(out; first, "-", last)]);
    }
    put!(out; "\n");
    let [of_a, of_b] = comparison.outside;
    if of_a + of_b > 0 {
        phrase(out, lang, Phrase::Outside, &[&|out| put!(out; of_a), &|out| put!(out; of_b)]);
        put!(out; "\n");
    }
    if !comparison.alignment.by_time {
        phrase(out, lang, Phrase::NoTimes, &[]);
        put!(out; "\n");
    }
    if comparison.alignment.is_blurred() {
        phrase(out, lang, Phrase::Unplaced, &[]);
        put!(out; "\n");
    }
    for (digest, name) in setting.digests.iter().zip(SIDES) {
        if digest.full {
            phrase(out, lang, Phrase::Full, &[&|out| put!(out; name)]);
            put!(out; "\n");
        }
    }
}

/// First and last frame of each capture of what was compared, as near as is known.
pub fn extents(setting: DiffSetting<'_>, comparison: &Comparison) -> [(u64, u64); 2] {
    let mut found = [(0, 0); 2];
    for (side, (slot, digest)) in found.iter_mut().zip(setting.digests).enumerate() {
        let by_time = comparison.alignment.by_time;
        let Some((from, to)) = comparison.alignment.covered.get(side).copied() else { continue };
        let (first, last) = (digest.first, digest.last);
        let known = digest.places().filter(|place| (from..=to).contains(&place.on(by_time)));
        let numbers = known.map(|place| place.frame().no);
        let (least, most) = numbers.fold((u64::MAX, 0), |(least, most), no| (least.min(no), most.max(no)));
        let inside = |place: crate::views::diff::digest::CapturePlace| (from..=to).contains(&place.on(by_time));
        let least = if inside(first) { first.frame().no } else { least };
        let most = if inside(last) { last.frame().no } else { most };
        *slot = if least <= most { (least, most) } else { (0, 0) };
    }
    found
}

/// Whose a difference is: `can0, node 5`.
fn home(out: &mut Vec<u8>, setting: DiffSetting<'_>, difference: &Difference) {
    let name = setting.bus(difference.bus);
    words::bus(out, setting.lang, name);
    if let Some(node) = difference.node.filter(|node| *node > 0) {
        put!(out; ", ");
        words::node(out, setting.lang, node);
    }
}

fn content(out: &mut Vec<u8>, lang: Lang, difference: &Difference) {
    words::subject(out, lang, difference);
    put!(out; ": ");
    for (place, (name, side)) in SIDES.iter().zip(&difference.sides).enumerate() {
        put!(out; if place > 0 { "; " } else { "" }, *name, " ");
        words::side(out, lang, difference.what, side.as_ref());
    }
    if difference.count > 1 {
        words::times(out, lang, difference.count);
    }
}

fn place(out: &mut Vec<u8>, lang: Lang, difference: &Difference, side: usize) {
    let frame = |out: &mut Vec<u8>, at: FrameRef| words::frame(out, lang, at);
    match (difference.sides.get(side).and_then(Option::as_ref), difference.beside.get(side).copied().flatten()) {
        (Some(one), _) => frame(out, one.since),
        (None, Some(near)) => phrase(out, lang, Phrase::Near, &[&|out| frame(out, near)]),
        (None, None) => put!(out; "-"),
    }
}

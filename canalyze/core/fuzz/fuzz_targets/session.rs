//! Arbitrary bytes as a file: the same output whatever the chunking, and text output is input again.
//!
//! The first two bytes are the sizes of the pieces, the third sets the options of the runs that are compared.
#![no_main]

use canalyze_core::bytes::readers::InputFormat as Input;
use canalyze_core::bytes::readers::candump::Stamps;
use canalyze_core::session::{Options, Output, Rows, Session};
use canalyze_core::tables::columns::Name;
use canalyze_core::views::filter::Filter;
use canalyze_core::views::monitor::{Line, Wanted};
use canalyze_core::words::{Depth, Lang};
use libfuzzer_sys::fuzz_target;
use std::collections::BTreeMap;

/// Standard output and standard error.
fn run(text: &[u8], options: Options, regular: bool, size: usize) -> (String, Vec<String>) {
    let mut session = Session::new(options);
    let mut out = Vec::new();
    session.begin(b"capture.log", Input::Candump, regular);
    for piece in text.chunks(size) {
        session.feed(piece, &mut out);
    }
    session.end(false, &mut out);
    session.finish(&mut out);
    (String::from_utf8(out).expect("output is UTF-8"), session.take_complaints())
}

/// Rows of every table, and frames.
fn rows(text: &[u8], options: Options, regular: bool, size: usize) -> (BTreeMap<String, usize>, u64) {
    let mut options = options;
    options.writing.outputs = Name::NAMES.iter().map(|(_, name)| Output::Columns(*name)).collect();
    let mut session = Session::new(options);
    let mut rows = BTreeMap::new();
    let mut take = |session: &mut Session| {
        for batch in session.take_batches(false) {
            *rows.entry(batch.name.to_string()).or_default() += batch.rows.num_rows();
        }
    };
    let mut out = Vec::new();
    session.begin(b"capture.log", Input::Candump, regular);
    for piece in text.chunks(size) {
        session.feed(piece, &mut out);
        take(&mut session);
    }
    session.end(false, &mut out);
    session.finish(&mut out);
    take(&mut session);
    assert!(out.is_empty(), "columns are no bytes");
    (rows, session.frames().0)
}

/// Output of a format with all tables beside it.
fn beside(text: &[u8], options: Options, regular: bool, size: usize) -> Vec<u8> {
    let mut options = options;
    options.writing.outputs.extend(Name::NAMES.iter().map(|(_, name)| Output::Columns(*name)));
    let mut session = Session::new(options);
    let mut out = Vec::new();
    session.begin(b"capture.log", Input::Candump, regular);
    for piece in text.chunks(size) {
        session.feed(piece, &mut out);
        session.take_batches(true);
    }
    session.end(false, &mut out);
    session.finish(&mut out);
    session.take_batches(false);
    out
}

/// What a view shows of it.
fn watched(text: &[u8], options: Options, regular: bool, size: usize) -> (Vec<u8>, Vec<Line>) {
    let mut options = options;
    options.writing.outputs = vec![Output::Monitor];
    let mut session = Session::new(options);
    let mut out = Vec::new();
    session.begin(b"capture.log", Input::Candump, regular);
    for piece in text.chunks(size) {
        session.feed(piece, &mut out);
    }
    session.end(false, &mut out);
    session.finish(&mut out);
    assert!(out.is_empty(), "what is watched is no bytes");
    let filter = Filter::default();
    let wanted = Wanted { filter: &filter, search: "", frame: None, rows: usize::MAX, back: true };
    (session.snapshot(), session.trace(wanted))
}

/// Whether no stamp that may be a difference is smaller than the one before it.
///
/// Where one is, the output can mean other times than the input: lines that cannot be read are not in it, and its
/// lines are all of the one family of which small stamps may be differences.
fn in_order(text: &str) -> bool {
    let seconds = |line: &str| line.strip_prefix('(')?.split_once(')')?.0.parse::<f64>().ok();
    text.lines().filter_map(seconds).filter(|seconds| *seconds < 1e8).is_sorted()
}

fuzz_target!(|input: &[u8]| {
    let [small, large, choice, text @ ..] = input else { return };
    let options = |output| {
        let mut options = Options::of(if choice & 1 == 0 { Lang::Zh } else { Lang::En }, &[output]);
        options.writing.depth = if choice & 4 == 0 { Depth::Default } else { Depth::Explain };
        options.reading.stamps = if choice & 8 == 0 { Stamps::Auto } else { Stamps::Delta };
        options
    };
    let output = if choice & 2 == 0 { Output::Lines } else { Output::json(Rows::Frames) };
    let regular = choice & 16 == 0;
    let sizes = [1 + usize::from(*small), 1 + 32 * usize::from(*large)];
    let [first, second] = sizes.map(|size| run(text, options(output), regular, size));
    assert_eq!(first, second, "the same output whatever the chunking");

    let [(first, frames), second] = sizes.map(|size| rows(text, options(output), regular, size));
    assert_eq!((&first, frames), (&second.0, second.1), "the same rows whatever the chunking");
    for table in ["frames", "listing"] {
        assert_eq!(first.get(table).copied().unwrap_or(0) as u64, frames, "every frame is a row");
    }
    let figures = || options(Output::json(Rows::Summary));
    let [alone, with_tables] =
        [run(text, figures(), regular, sizes[0]).0.into_bytes(), beside(text, figures(), regular, sizes[1])];
    assert_eq!(alone, with_tables, "tables change nothing of what comes out");

    let [first, second] = sizes.map(|size| watched(text, options(output), regular, size));
    assert_eq!(first, second, "the same view whatever the chunking");
    assert!(std::str::from_utf8(&first.0).is_ok(), "a snapshot is UTF-8");
    assert!(first.1.len() as u64 >= frames.min(50_000), "every frame has a line");

    let decode = |text: &[u8], stamps| {
        let mut options = Options::of(Lang::Zh, &[Output::Lines]);
        options.reading.stamps = stamps;
        run(text, options, true, usize::MAX).0
    };
    let once = decode(text, Stamps::Absolute);
    assert_eq!(once, decode(once.as_bytes(), Stamps::Absolute), "decoding what was decoded changes nothing");
    if once == decode(text, Stamps::Auto) && in_order(&once) {
        assert_eq!(once, decode(once.as_bytes(), Stamps::Auto), "decoding what was decoded changes nothing");
    }
});

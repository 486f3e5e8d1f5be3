//! Arbitrary bytes as what comes from live buses, through a whole session: no panic, the same lines whatever the
//! chunking, and a number of frames asked for is never exceeded.
//!
//! The first byte sets the size of the pieces, the second the number of frames (0: all).
#![no_main]

use canalyze_core::bytes::masks::Masks;
use canalyze_core::bytes::readers::InputFormat as Input;
use canalyze_core::session::{Options, Output, Rows, Session};
use canalyze_core::words::Lang;
use libfuzzer_sys::fuzz_target;

fn told(bytes: &[u8], size: usize, count: Option<u64>) -> (Vec<u8>, Vec<u8>, Vec<String>) {
    let masks = Masks::parse(&["can1,100~700,#1F".to_owned()]).unwrap_or_default();
    let mut options = Options::of(Lang::Zh, &[Output::json(Rows::Frames)]);
    (options.shown.masks, options.shown.limit) = (masks, count);
    let mut session = Session::new(options);
    let mut out = Vec::new();
    session.begin(b"live", Input::Live, false);
    for piece in bytes.chunks(size) {
        session.feed(piece, &mut out);
    }
    session.finish(&mut out);
    (out, session.tally(), session.take_complaints())
}

fuzz_target!(|input: &[u8]| {
    let [size, count, bytes @ ..] = input else { return };
    let count = (*count > 0).then_some(u64::from(*count));
    let whole = told(bytes, usize::MAX, count);
    assert_eq!(whole, told(bytes, 1 + usize::from(*size), count));
    let shown = whole.0.split(|byte| *byte == b'\n').filter(|line| line.starts_with(b"{\"kind\":\"frame\"")).count();
    assert!(count.is_none_or(|count| shown as u64 <= count), "{shown}");
});

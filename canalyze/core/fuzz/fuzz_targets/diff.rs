//! Two captures held against each other from either side: no panic, and a capture is the same as itself.
//!
//! The first byte sets the options, the next two say where the first capture ends; both are frames as `traffic` reads
//! them. Where options ask for it the second capture is the first one with the rest of the input in its middle.
#![no_main]

mod traffic;

use std::sync::Arc;

use canalyze_core::bytes::frame::Frame;
use canalyze_core::session::{Options, Output, Session};
use canalyze_core::tables::diff::{DiffSetting, body, head};
use canalyze_core::tables::jsonl;
use canalyze_core::views::diff::digest::Digest;
use canalyze_core::views::diff::{Comparison, DiffSettings, compare};
use canalyze_core::words::Lang;
use canalyze_core::world::network::Network;
use libfuzzer_sys::fuzz_target;
use serde_json::Value;

fn digest(frames: &[Frame], network: &Arc<Network>) -> Digest {
    let mut options = Options::of(Lang::Zh, &[Output::Digest]);
    options.threads = Some(1);
    options.known.network = Arc::clone(network);
    let mut session = Session::new(options);
    let mut out = Vec::new();
    for frame in frames {
        session.push(*frame, &mut out);
    }
    session.finish(&mut out);
    assert!(out.is_empty(), "a digest is no bytes");
    session.take_digest().expect("it is the format that keeps one")
}

fn written(lang: Lang, digests: [&Digest; 2], compared: &Comparison) {
    let setting = || DiffSetting { lang, digests };
    let mut out = Vec::new();
    head(&mut out, setting(), compared);
    body(&mut out, setting(), compared);
    String::from_utf8(out).expect("output is UTF-8");
    let mut out = Vec::new();
    jsonl::diff::write(&mut out, setting(), compared, [b"a", b"b"]);
    for line in String::from_utf8(out).expect("output is UTF-8").lines() {
        serde_json::from_str::<Value>(line).expect("every line is an object");
    }
}

fuzz_target!(|input: &[u8]| {
    let [choice, high, low, rest @ ..] = input else { return };
    let lang = if choice & 2 == 0 { Lang::Zh } else { Lang::En };
    let network = Arc::new(if choice & 4 == 0 { Network::default() } else { traffic::network() });
    let cut = usize::from(u16::from_be_bytes([*high, *low])).min(rest.len());
    let (one, other) = rest.split_at(cut);
    let one = traffic::frames(one, choice & 1 == 0);
    let other = if choice & 8 == 0 {
        traffic::frames(other, choice & 16 == 0)
    } else {
        let middle = rest.get(..cut / 2).unwrap_or_default();
        traffic::frames(&[middle, other, rest.get(cut / 2..cut).unwrap_or_default()].concat(), choice & 1 == 0)
    };
    let settings = || DiffSettings { tolerance: f64::from(choice >> 5) / 4.0, buses: Vec::new() };
    let (a, b) = (digest(&one, &network), digest(&other, &network));
    for one in [&a, &b] {
        let compared = compare(one, one, &settings());
        assert!(compared.differences.is_empty(), "a capture is the same as itself: {:?}", compared.differences);
        written(lang, [one, one], &compared);
    }
    let (there, back) = (compare(&a, &b, &settings()), compare(&b, &a, &settings()));
    written(lang, [&a, &b], &there);
    written(lang, [&b, &a], &back);
});

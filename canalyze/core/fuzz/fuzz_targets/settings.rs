//! Arbitrary bytes as the files that users write: no panic, and every mistake is about a line of the file.
//!
//! The whole input is the file, once as `canalyze.toml` and once as expectations. It must not judge what is read.
#![no_main]

use canalyze_core::settings::{Mistake, expectations, settings};
use canalyze_core::views::expectation::Expectations;
use libfuzzer_sys::fuzz_target;

const FILE: &str = "f";

fn told(mistake: &Mistake) {
    let fact = |name| mistake.facts.iter().find(|fact| fact.0 == name).map(|fact| fact.1.as_str());
    let place = fact("file").expect("a mistake names the file");
    let line = fact("line").or_else(|| place.strip_prefix("f:")).expect("and the line");
    assert!(line.parse::<usize>().is_ok_and(|line| line >= 1), "{mistake:?}");
}

fuzz_target!(|input: &[u8]| {
    if let Err(mistake) = settings(input, FILE) {
        told(&mistake);
    }
    match expectations(input, FILE) {
        Ok(form) => _ = Expectations::normalized(form).expect("what was read is what can be judged"),
        Err(mistake) => told(&mistake),
    }
});

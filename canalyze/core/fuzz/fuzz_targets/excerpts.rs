//! Nothing false about a part of a capture: SDO transfers of known truth, cut as people paste them.
//!
//! The first byte sets the language and whether a second cut is made, 24 bytes say where the cuts are, and the others
//! what is transferred.
#![no_main]

mod conversation;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|input: &[u8]| {
    let case = conversation::law::judge(input);
    // Where nothing announces a hole, what is read across it is another question.
    let asked = !case.excerpt.unannounced && !case.falsehoods.is_empty();
    assert!(!asked, "{}\n{:?}\n{}", case.falsehoods.join("\n"), case.excerpt.cuts, case.text);
});

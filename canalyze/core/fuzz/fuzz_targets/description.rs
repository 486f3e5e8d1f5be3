//! Arbitrary bytes as a device description: no panic, objects in order, and a DCF made of it is read again.
//!
//! The whole input is the file.
#![no_main]

use std::collections::BTreeMap;

use canalyze_core::description::{configured, read};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|input: &[u8]| {
    let Ok(found) = read(input, String::new()) else { return };
    assert!(!found.objects.is_empty() && found.objects.is_sorted_by(|one, next| one.index < next.index));
    for object in &found.objects {
        assert!(object.entries.is_sorted_by(|one, next| one.sub < next.sub));
    }
    assert!(found.defects.is_sorted_by_key(|defect| defect.line));
    let entries = found.objects.iter().flat_map(|object| &object.entries).take(20);
    let values: BTreeMap<_, _> = entries.map(|entry| ((entry.index, entry.sub), vec![1, 0, 0, 0])).collect();
    let made = configured(input, &values, 5, &[]).expect("it is a description");
    if made.left_out.len() < values.len() && found.form.name() != "xdd" {
        _ = read(made.text.as_bytes(), String::new()).expect("a DCF is a description");
    }
});

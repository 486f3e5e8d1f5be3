//! Arbitrary bytes as a log of Vector's: no panic, and the same items whatever the chunking.
//!
//! The first byte sets the size of the pieces.
#![no_main]

use canalyze_core::bytes::frame::Buses;
use canalyze_core::bytes::readers::asc::{Asc, line};
use libfuzzer_sys::fuzz_target;

fn items(text: &[u8], size: usize) -> Vec<String> {
    let mut reader = Asc::default();
    let mut buses = Buses::default();
    let mut items = Vec::new();
    let mut sink = |item, _: &Buses| items.push(format!("{item:?}"));
    for piece in text.chunks(size) {
        reader.feed(piece, &mut buses, &mut sink);
    }
    reader.finish(&mut buses, &mut sink);
    items.push(format!("{} {:?} {:?}", reader.lines(), reader.contents(), buses.names().collect::<Vec<_>>()));
    items
}

fuzz_target!(|input: &[u8]| {
    let Some((size, text)) = input.split_first() else { return };
    assert_eq!(items(text, usize::MAX), items(text, 1 + usize::from(*size)));
    for text in text.split(|&byte| byte == b'\n') {
        let _ = line(text, &mut Buses::default());
    }
});

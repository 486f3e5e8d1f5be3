//! Arbitrary bytes as a candump capture: no panic, and the same items whatever the chunking.
//!
//! The first byte sets the options and the size of the pieces, so that the fuzzer can find both.
#![no_main]

use canalyze_core::bytes::frame::Buses;
use canalyze_core::bytes::readers::candump::{Candump, Stamps, line};
use libfuzzer_sys::fuzz_target;

fn items(text: &[u8], stamps: Stamps, regular: bool, size: usize) -> Vec<String> {
    let mut reader = Candump::new(stamps, regular);
    let mut buses = Buses::default();
    let mut items = Vec::new();
    let mut sink = |item, _: &Buses| items.push(format!("{item:?}"));
    for piece in text.chunks(size) {
        reader.feed(piece, &mut buses, &mut sink);
    }
    reader.finish(&mut buses, &mut sink);
    items.push(format!("{} {:?}", reader.lines(), buses.names().collect::<Vec<_>>()));
    items
}

fuzz_target!(|input: &[u8]| {
    let Some((options, text)) = input.split_first() else { return };
    let stamps = if options & 2 == 0 { Stamps::Auto } else { Stamps::Delta };
    let regular = options & 1 == 0;
    let size = 1 + usize::from(options >> 2);
    assert_eq!(items(text, stamps, regular, usize::MAX), items(text, stamps, regular, size));
    for text in text.split(|&byte| byte == b'\n') {
        let _ = line(text, &mut Buses::default());
    }
});

//! Arbitrary bytes as a Vector BLF file: no panic, and the same items whatever the chunking.
//!
//! The first byte sets the size of the pieces, so that the fuzzer can find it too.
#![no_main]

use canalyze_core::bytes::frame::Buses;
use canalyze_core::bytes::readers::blf::Blf;
use libfuzzer_sys::fuzz_target;

fn items(bytes: &[u8], size: usize) -> Vec<String> {
    let mut reader = Blf::default();
    let mut buses = Buses::default();
    let mut items = Vec::new();
    let mut sink = |item, _: &Buses| items.push(format!("{item:?}"));
    for piece in bytes.chunks(size) {
        reader.feed(piece, &mut buses, &mut sink);
    }
    reader.finish(&mut buses, &mut sink);
    items.push(format!("{:?} {:?}", reader.contents(), buses.names().collect::<Vec<_>>()));
    items
}

fuzz_target!(|input: &[u8]| {
    let Some((size, bytes)) = input.split_first() else { return };
    assert_eq!(items(bytes, usize::MAX), items(bytes, 1 + usize::from(*size)));
});

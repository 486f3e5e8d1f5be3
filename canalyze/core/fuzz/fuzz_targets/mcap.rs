//! Arbitrary bytes as an MCAP file, and as the records of a chunk whose check sum is right: no panic, and the same
//! items whatever the chunking.
//!
//! The first byte sets the options, the second the size of the pieces.
#![no_main]

use canalyze_core::bytes::frame::Buses;
use canalyze_core::bytes::readers::mcap::{Choice, Mcap};
use libfuzzer_sys::fuzz_target;

fn items(data: &[u8], size: usize) -> Vec<String> {
    let mut reader = Mcap::new(Choice::default());
    let mut buses = Buses::default();
    let mut items = Vec::new();
    let mut sink = |item, _: &Buses| items.push(format!("{item:?}"));
    for piece in data.chunks(size) {
        reader.feed(piece, &mut buses, &mut sink);
    }
    reader.finish(&mut buses, &mut sink);
    items.push(format!("{:?} {:?}", reader.contents(), buses.names().collect::<Vec<_>>()));
    items
}

/// A file of one chunk, not packed, without check sum; `true`: with another behind it.
fn wrapped(records: &[u8], twice: bool) -> Vec<u8> {
    let mut file = b"\x89MCAP0\r\n".to_vec();
    let parts = if twice { records.split_at(records.len() / 2) } else { (records, &[][..]) };
    for part in [parts.0, parts.1] {
        let len = part.len() as u64;
        file.push(6);
        file.extend((40 + len).to_le_bytes());
        file.extend([0; 8]);
        file.extend(u64::MAX.to_le_bytes());
        file.extend(len.to_le_bytes());
        file.extend([0; 8]);
        file.extend(len.to_le_bytes());
        file.extend(part);
    }
    file
}

fuzz_target!(|input: &[u8]| {
    let [options, size, data @ ..] = input else { return };
    let made;
    let data = if options & 1 == 0 {
        data
    } else {
        made = wrapped(data, options & 2 != 0);
        &made
    };
    assert_eq!(items(data, usize::MAX), items(data, 1 + usize::from(*size)));
});

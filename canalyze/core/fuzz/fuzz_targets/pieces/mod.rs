//! A reader that is fed the same bytes at once and in pieces.

/// Makes a fuzz target of a reader: no panic, and the same items whatever the chunking. The first byte of the input sets
/// the size of the pieces, so that the fuzzer can find it too.
macro_rules! any_pieces {
    ($reader:ty) => {
        use canalyze_core::bytes::frame::Buses;

        fn items(bytes: &[u8], size: usize) -> Vec<String> {
            let mut reader = <$reader>::default();
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

        libfuzzer_sys::fuzz_target!(|input: &[u8]| {
            let Some((size, bytes)) = input.split_first() else { return };
            assert_eq!(items(bytes, usize::MAX), items(bytes, 1 + usize::from(*size)));
        });
    };
}

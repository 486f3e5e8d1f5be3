//! Rows of each version as literal text. Files of other programs are read in the Python tests.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]

use proptest::prelude::*;

use super::Trc;
use crate::bytes::frame::{Buses, Frame, Kind};
use crate::bytes::ns::Ns;
use crate::bytes::readers::{FilePlace, Item, Marker, Unreadable};

fn read(text: &str, step: usize) -> Vec<Item> {
    let (mut reader, mut buses, mut items) = (Trc::default(), Buses::default(), Vec::new());
    for piece in text.as_bytes().chunks(step.max(1)) {
        reader.feed(piece, &mut buses, &mut |item, _| items.push(item));
    }
    reader.finish(&mut buses, &mut |item, _| items.push(item));
    items
}

fn frames(items: &[Item]) -> Vec<Frame> {
    items.iter().filter_map(|item| if let Item::Frame(frame) = item { Some(*frame) } else { None }).collect()
}

fn bad(items: &[Item]) -> Vec<(u64, Unreadable)> {
    let each = |item: &Item| match item {
        Item::Unreadable { place: FilePlace::Line(line), reason } => Some((*line, *reason)),
        _ => None,
    };
    items.iter().filter_map(each).collect()
}

const ROWS: [(&str, &str); 6] = [
    ("", "1) 12.5 060A 8 40 08 10 00 00 00 00 00\n"),
    (";$FILEVERSION=1.1\n;$STARTTIME=45000.5\n", "1) 12.5 Rx 060A 8 40 08 10 00 00 00 00 00\n"),
    (";$FILEVERSION=1.2\n", "1) 12.5 1 Tx 060A 8 40 08 10 00 00 00 00 00\n"),
    (";$FILEVERSION=1.3\n", "1) 12.5 1 Rx 060A - 8 40 08 10 00 00 00 00 00\n"),
    (";$FILEVERSION=2.0\n;$COLUMNS=N,O,T,I,d,l,D\n", "1 12.5 DT 060A Rx 8 40 08 10 00 00 00 00 00\n"),
    (";$FILEVERSION=2.1\n;$COLUMNS=N,O,T,B,I,d,R,L,D\n", "1 12.5 DT 1 060A Rx - 8 40 08 10 00 00 00 00 00\n"),
];

#[test]
fn a_row_of_each_version() {
    for (head, row) in ROWS {
        // With its header, and as an excerpt without.
        for text in [format!("{head}{row}"), row.to_owned()] {
            let all = frames(&read(&text, 7));
            assert_eq!(all.len(), 1, "{text}");
            assert_eq!(
                (all[0].id.raw(), all[0].t_ns, all[0].payload()),
                (0x60A, Some(Ns(12_500_000)), &[0x40, 8, 0x10, 0, 0, 0, 0, 0][..])
            );
        }
    }
}

#[test]
fn the_date_is_in_days() {
    let date = |items: &[Item]| {
        items
            .iter()
            .find_map(|item| if let Item::Marker(Marker::Start { date_ns }) = item { Some(*date_ns) } else { None })
    };
    assert_eq!(
        date(&read(";$FILEVERSION=1.1\n;$STARTTIME=25569.5\n1) 1.0 Rx 060A 0\n", 9)),
        Some(Ns(43_200_000_000_000))
    );
    assert_eq!(date(&read(";$FILEVERSION=1.1\n;$STARTTIME=25569\n1) 1.0 Rx 060A 0\n", 9)), None);
}

#[test]
fn rows_of_other_kinds() {
    let items = read(
        ";$FILEVERSION=2.1\n;$COLUMNS=N,O,T,B,I,d,R,L,D\n\
         1 1.5 FB 1 0123 Tx - 9 01 02 03 04 05 06 07 08 09 0A 0B 0C\n2 2.5 RR 1 00000701 Rx - 1\n3 3.5 ST 1 - Rx - 4 00\n\
         4 4.5 ER 2 - Rx - 5 04\n5 5.5 FD 1 0123 Rx - 9 01\n6 zz\n",
        11,
    );
    let all = frames(&items);
    assert_eq!((all[0].kind, all[0].len), (Kind::Fd { brs: true, esi: false }, 12));
    assert_eq!((all[1].kind, all[1].id.is_extended(), all[1].len), (Kind::Remote, true, 1));
    assert_eq!(all[2].kind, Kind::Error);
    assert_eq!(bad(&items), [(7, Unreadable::Data), (8, Unreadable::NoFrame)]);
}

#[test]
fn missing_rows_and_a_cut_line() {
    let items = read("1) 1.0 060A 1 40\n5) 5.0 060A 1 40\n6) 6.0 060A 2 40 0", 5);
    assert!(items.iter().any(|item| matches!(item, Item::Marker(Marker::LeftOut { count: Some(3), .. }))));
    assert_eq!((frames(&items).len(), bad(&items)), (2, vec![(3, Unreadable::Cut)]));
}

proptest! {
    #[test]
    fn any_bytes_in_any_pieces(text in "[ -~\n]{0,200}", version in 0_usize..6, step in 1_usize..40) {
        let (head, row) = ROWS[version];
        let whole = format!("{head}{row}{text}\n{row}");
        prop_assert_eq!(format!("{:?}", read(&whole, step)), format!("{:?}", read(&whole, whole.len())));
    }
}

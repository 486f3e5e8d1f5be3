//! Objects as literal bytes, and laws of damage. Files of other programs are read in the Python tests.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]

use proptest::prelude::*;

use super::Blf;
use crate::bytes::frame::{Buses, Frame, Kind};
use crate::bytes::ns::Ns;
use crate::bytes::readers::{DamageKind, Item};

/// Returns an object with a header of version 1.
fn object(kind: u32, stamp: u64, body: &[u8]) -> Vec<u8> {
    let size = 32 + body.len() as u32;
    let head = [b"LOBJ".as_slice(), &32_u16.to_le_bytes(), &1_u16.to_le_bytes(), &size.to_le_bytes()].concat();
    [head, kind.to_le_bytes().to_vec(), 1_u32.to_le_bytes().to_vec(), vec![0; 4], stamp.to_le_bytes().to_vec()]
        .concat()
        .into_iter()
        .chain(body.iter().copied())
        .collect()
}

/// Returns a CAN message on channel 1.
fn message(stamp: u64, id: u32, data: [u8; 8]) -> Vec<u8> {
    object(1, stamp, &[&[1, 0, 0, 8], id.to_le_bytes().as_slice(), &data].concat())
}

/// Returns a file with one container that is not packed; `count`: its number of objects.
fn file(count: u32, inner: &[u8]) -> Vec<u8> {
    let mut header = vec![0; 144];
    header[..8].copy_from_slice(&[b'L', b'O', b'G', b'G', 144, 0, 0, 0]);
    header[8] = 5;
    header[32..36].copy_from_slice(&count.to_le_bytes());
    let date: [u16; 8] = [2024, 2, 4, 29, 12, 0, 0, 500];
    for (place, part) in date.iter().enumerate() {
        header[40 + 2 * place..42 + 2 * place].copy_from_slice(&part.to_le_bytes());
    }
    let size = 32 + inner.len() as u32;
    let head = [b"LOBJ".as_slice(), &16_u16.to_le_bytes(), &1_u16.to_le_bytes(), &size.to_le_bytes()].concat();
    let container =
        [head, 10_u32.to_le_bytes().to_vec(), vec![0; 8], (inner.len() as u32).to_le_bytes().to_vec(), vec![0; 4]];
    [header, container.concat(), inner.to_vec()].concat()
}

fn read(data: &[u8], step: usize) -> Vec<Item> {
    let (mut reader, mut buses, mut items) = (Blf::default(), Buses::default(), Vec::new());
    for piece in data.chunks(step.max(1)) {
        reader.feed(piece, &mut buses, &mut |item, _| items.push(item));
    }
    reader.finish(&mut buses, &mut |item, _| items.push(item));
    items
}

fn frames(items: &[Item]) -> Vec<Frame> {
    items.iter().filter_map(|item| if let Item::Frame(frame) = item { Some(*frame) } else { None }).collect()
}

fn damages(items: &[Item]) -> Vec<(DamageKind, Option<u64>)> {
    let each =
        |item: &Item| if let Item::Damaged(one) = item { Some((one.kind, one.bytes.or(one.frames))) } else { None };
    items.iter().filter_map(each).collect()
}

#[test]
fn messages_and_their_start() {
    let inner =
        [message(100_003, 0x60A, [0x40, 0x08, 0x10, 0, 0, 0, 0, 0]), message(100_004, 0x8001_2345, [1; 8])].concat();
    let items = read(&file(2, &inner), 1 << 20);
    assert!(matches!(
        items[0],
        Item::Marker(crate::bytes::readers::Marker::Start { date_ns: Ns(1_709_208_000_500_000_000) })
    ));
    let frames = frames(&items);
    assert_eq!((frames[0].id.raw(), frames[0].t_ns, frames[0].payload()[0]), (0x60A, Some(Ns(1_000_030_000)), 0x40));
    assert!(frames[1].id.is_extended());
    assert!(damages(&items).is_empty());
}

#[test]
fn fd_messages() {
    let mut body = vec![2, 0, 1, 13];
    body.extend(0x123_u32.to_le_bytes());
    body.extend([0, 0, 0, 0, 0, 0b111, 32, 0, 0, 0, 0, 0]);
    body.extend([7; 64]);
    let frames = frames(&read(&file(1, &object(100, 1, &body)), 7));
    assert_eq!((frames[0].kind, frames[0].len), (Kind::Fd { brs: true, esi: true }, 32));
}

#[test]
fn the_count_of_objects() {
    let inner = [message(1, 1, [0; 8]), message(2, 2, [0; 8])].concat();
    assert_eq!(damages(&read(&file(3, &inner), 100)), [(DamageKind::Missing, Some(1))]);
    assert_eq!(damages(&read(&file(1, &inner), 100)), [(DamageKind::Excess, Some(1))]);
    // A file that was not closed has no count.
    assert!(damages(&read(&file(0, &inner), 100)).is_empty());
}

#[test]
fn a_frame_under_another_type_is_lost() {
    let mut inner = [message(1, 1, [0; 8]), message(2, 2, [0; 8]), message(3, 3, [0; 8])].concat();
    inner[48 + 12] = 5;
    let items = read(&file(3, &inner), 100);
    assert_eq!((frames(&items).len(), damages(&items)), (2, vec![(DamageKind::Structure, Some(48))]));
}

proptest! {
    #[test]
    fn any_chunking_reads_the_same(step in 1_usize..400, count in 1_usize..40) {
        let inner: Vec<u8> = (0..count).flat_map(|no| message(no as u64, no as u32, [no as u8; 8])).collect();
        let data = file(count as u32, &inner);
        prop_assert_eq!(format!("{:?}", read(&data, step)), format!("{:?}", read(&data, data.len())));
        prop_assert_eq!(frames(&read(&data, step)).len(), count);
    }

    #[test]
    fn no_bytes_panic(noise in prop::collection::vec(any::<u8>(), 0..400), at in 0_usize..600, step in 1_usize..300) {
        let inner: Vec<u8> = (0..9).flat_map(|no| message(no, no as u32, [no as u8; 8])).collect();
        let mut data = file(9, &inner);
        for (slot, byte) in data.iter_mut().skip(at).zip(&noise) {
            *slot = *byte;
        }
        prop_assert!(frames(&read(&data, step)).len() <= 9 + noise.len() / 48);
    }
}

//! Laws that hold for any input; files of other programs' writers are tested in `tests/test_mcap.py`.
//!
//! The files here are made by hand, with the record layout of the specification.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]

use proptest::prelude::*;

use super::*;

fn counted(text: &[u8]) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes(), text].concat()
}

fn record(op: u8, body: &[u8]) -> Vec<u8> {
    [&[op], (body.len() as u64).to_le_bytes().as_slice(), body].concat()
}

fn message(number: u32) -> Vec<u8> {
    let ns = u64::from(number) * 1000 + 1_700_000_000_000_000_000;
    let mut body = 1u16.to_le_bytes().to_vec();
    body.extend(number.to_le_bytes());
    body.extend(ns.to_le_bytes());
    body.extend(ns.to_le_bytes());
    body.extend([0, 1, 0, 0]);
    body.extend(((ns / 1_000_000_000) as u32).to_le_bytes());
    body.extend(((ns % 1_000_000_000) as u32).to_le_bytes());
    body.extend(counted(b"can\0"));
    body.extend(0x181u32.to_le_bytes());
    body.extend([0, 0, 0, 8]);
    body.extend(u64::from(number).to_le_bytes());
    record(op::MESSAGE, &body)
}

fn definitions() -> Vec<u8> {
    let schema = [&[1, 0], counted(b"can_msgs/msg/Frame").as_slice(), &counted(b"ros2msg"), &counted(b"")].concat();
    let channel = [&[1, 0, 1, 0], counted(b"/can0/from_can_bus").as_slice(), &counted(b"cdr"), &counted(b"")].concat();
    [record(op::SCHEMA, &schema), record(op::CHANNEL, &channel)].concat()
}

/// Makes a chunk of these records. Packing: 0 none, 1 zstd, 2 lz4.
fn chunk(records: &[u8], packing: u8) -> Vec<u8> {
    let (name, packed): (&[u8], _) = match packing {
        0 => (b"", records.to_vec()),
        1 => (b"zstd", zstd::bulk::compress(records, 1).unwrap()),
        _ => {
            let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
            std::io::Write::write_all(&mut encoder, records).unwrap();
            (b"lz4", encoder.finish().unwrap())
        }
    };
    let mut body = 0u64.to_le_bytes().to_vec();
    body.extend(u64::MAX.to_le_bytes());
    body.extend((records.len() as u64).to_le_bytes());
    body.extend(crc32fast::hash(records).to_le_bytes());
    body.extend(counted(name));
    body.extend((packed.len() as u64).to_le_bytes());
    body.extend(packed);
    record(op::CHUNK, &body)
}

/// Makes a file of chunks with this number of messages each; the first one holds the definitions.
fn file(chunks: u32, messages: u32, packing: u8) -> Vec<u8> {
    let mut file = walk::MAGIC.to_vec();
    file.extend(record(op::HEADER, &[counted(b"ros2"), counted(b"test")].concat()));
    for number in 0..chunks {
        let mut records = if number == 0 { definitions() } else { Vec::new() };
        (0..messages).for_each(|at| records.extend(message(number * messages + at)));
        file.extend(chunk(&records, packing));
    }
    file.extend(record(op::DATA_END, &[0; 4]));
    file.extend(record(op::FOOTER, &[0; 20]));
    file.extend(walk::MAGIC);
    file
}

fn items(data: &[u8], size: usize) -> Vec<String> {
    let mut reader = Mcap::new(Choice::default());
    let mut buses = Buses::default();
    let mut items = Vec::new();
    let mut sink = |item: Item, _: &Buses| items.push(format!("{item:?}"));
    for piece in data.chunks(size) {
        reader.feed(piece, &mut buses, &mut sink);
    }
    reader.finish(&mut buses, &mut sink);
    reader.finish(&mut buses, &mut sink);
    items.push(format!("{:?} {:?}", reader.contents(), buses.names().collect::<Vec<_>>()));
    items
}

fn frames(items: &[String]) -> usize {
    items.iter().filter(|item| item.starts_with("Frame")).count()
}

#[test]
fn a_whole_file() {
    for packing in 0..3 {
        let items = items(&file(4, 10, packing), usize::MAX);
        assert_eq!((items.len(), frames(&items)), (41, 40));
        assert!(items.iter().all(|item| !item.contains("Damaged")));
    }
}

#[test]
fn every_cut_and_what_is_left_of_it() {
    let file = file(3, 5, 0);
    for end in 1..file.len() {
        let items = items(&file[..end], 64);
        let cut = items.iter().any(|item| item.contains("kind: Cut"));
        assert!(cut || end < walk::MAGIC.len(), "{end}");
        assert!(frames(&items) <= 15);
    }
    assert_eq!(items(&[], 1).len(), 1);
}

#[test]
fn lengths_that_claim_everything() {
    for op in 0..=255 {
        for len in [u64::MAX, 1 << 50, (256 << 20) - 1, 0] {
            let mut data = walk::MAGIC.to_vec();
            data.extend([&[op], len.to_le_bytes().as_slice(), &[7; 40]].concat());
            items(&data, 3);
        }
    }
}

proptest! {
    #[test]
    fn pieces_do_not_matter(
        packing in 0..3u8,
        chunks in 1..5u32,
        flips in prop::collection::vec((any::<prop::sample::Index>(), 0..8u8), 0..4),
        cut in any::<prop::sample::Index>(),
        whole in any::<bool>(),
        zeros in 0..40usize,
        size in 1..200usize,
    ) {
        let mut data = file(chunks, 7, packing);
        for (at, bit) in flips {
            let at = at.index(data.len());
            data[at] ^= 1 << bit;
        }
        if !whole {
            data.truncate(cut.index(data.len()));
        }
        data.extend(vec![0; zeros]);
        prop_assert_eq!(items(&data, usize::MAX), items(&data, size));
    }

    #[test]
    fn any_records_in_a_chunk(body in prop::collection::vec(any::<u8>(), 0..300), op in 0..20u8, packing in 0..3u8) {
        let mut data = walk::MAGIC.to_vec();
        let records = [definitions(), record(op, &body), message(1), body].concat();
        data.extend(chunk(&records, packing));
        prop_assert_eq!(items(&data, usize::MAX), items(&data, 11));
    }

    #[test]
    fn any_definition(text in "((std_msgs/Header header|uint32 id|bool fdf|uint8\\[\\] data|string s|X x|=====\nMSG: a/X|[a-z]{1,3}\\[<=[0-9]{1,12}\\] y)\n){0,12}", message in prop::collection::vec(any::<u8>(), 0..80)) {
        for wire in [Wire::Cdr, Wire::Ros1] {
            if let Some(plan) = Plan::new("a/B", Some(&text), wire, &[(Role::Id, "id"), (Role::Data, "data")]) {
                let _ = plan.read(&message).map(|fields| fields.frame());
            }
        }
    }

    #[test]
    fn reading_by_hand_is_reading_by_steps(name in 0..9u8, rest in prop::collection::vec(any::<u8>(), 0..60), len in 0..70u8) {
        let head: &[u8] = &[0, 1, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, name, 0, 0, 0];
        let at = usize::from(name.next_multiple_of(4)) + 8;
        let mut message = [head, &rest].concat();
        // Offset of the data length in an FD frame.
        if let Some(slot) = message.get_mut(head.len() + at..head.len() + at + 4) {
            slot.copy_from_slice(&u32::from(len).to_le_bytes());
        }
        for (name, text) in [("can_msgs/Frame", layout::CAN_FRAME), ("ros2_socketcan_msgs/FdFrame", layout::FD_FRAME)] {
            for wire in [Wire::Cdr, Wire::Ros1] {
                let plan = Plan::new(name, Some(text), wire, &[]).unwrap();
                prop_assert!(plan.is_by_hand());
                let fields = |read: Option<fields::Fields<'_>>| format!("{read:?}");
                prop_assert_eq!(fields(plan.read(&message)), fields(plan.by_steps(&message)));
            }
        }
    }

    // If the path of nearly every frame differed from the general one, frames would be wrong.
    #[test]
    fn a_plain_message_is_no_other_frame(
        name in 0..9u8,
        id in prop_oneof![0..0x900u32, any::<u32>()],
        flags in prop::array::uniform3(0..3u8),
        len in 0..10u8,
        data in prop::collection::vec(any::<u8>(), 0..12),
    ) {
        let head: &[u8] = &[0, 1, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, name, 0, 0, 0];
        let padding = vec![0; usize::from(name.next_multiple_of(4))];
        let message = [head, &padding, &id.to_le_bytes(), &flags, &[len], &data].concat();
        let plan = Plan::new("can_msgs/Frame", Some(layout::CAN_FRAME), Wire::Cdr, &[]).unwrap();
        prop_assert!(plan.is_plain());
        if let Some((stamp_ns, id, len, data)) = layout::plain(&message) {
            let fields = plan.by_steps(&message).unwrap();
            prop_assert_eq!(fields.stamp_ns, Some(stamp_ns));
            let known = Held::classic(stamp_ns, id, BusId(0), None, len, data);
            prop_assert_eq!(Held::new(stamp_ns, &fields.frame().unwrap()), known);
        } else {
            prop_assert!(id > 0x7FF || flags != [0; 3] || len > 8 || data.len() < 8);
        }
    }
}

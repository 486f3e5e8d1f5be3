#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
use proptest::prelude::*;

use super::*;
use crate::sdo::abort_code::AbortCode;
use crate::sdo::transfer::{Beginning, Mode, Status, TransferId};
use crate::sdo::wire::Side;
use crate::world::od::DataType as T;

const OBJECT: Mux = Mux { index: 0x2000, sub: 1 };

fn at(no: u64) -> FrameRef {
    FrameRef { no, ..FrameRef::default() }
}

/// A transfer of node 5.
fn transfer(direction: Direction, bytes: &[u8], status: Status, abort: Option<(u32, Side)>) -> Transfer {
    let beginning = Beginning { id: TransferId(1), bus: BusId(0), node: 5, channel: None, extract: false, at: at(1) };
    let mut transfer = Transfer::new(beginning, direction, Mode::Expedited, Some(OBJECT));
    transfer.outcome.status = status;
    transfer.outcome.abort = abort.map(|(code, by)| Abort { code: AbortCode::Sdo(code), by });
    transfer.data.size_indicated = Some(bytes.len() as u32);
    if status == Status::Ok {
        transfer.append(bytes);
    } else {
        transfer.data.requested = bytes.to_vec();
    }
    transfer
}

fn seen(transfers: &[Transfer]) -> ObservedObject {
    let mut inventory = Inventory::default();
    transfers.iter().for_each(|one| inventory.transfer(one));
    inventory.nodes[&(BusId(0), 5)].objects[&OBJECT].clone()
}

fn read(bytes: &[u8]) -> Transfer {
    transfer(Direction::Upload, bytes, Status::Ok, None)
}

fn written(bytes: &[u8]) -> Transfer {
    transfer(Direction::Download, bytes, Status::Ok, None)
}

fn refused(direction: Direction, code: u32) -> Transfer {
    transfer(direction, &[], Status::Aborted, Some((code, Side::Server)))
}

fn type_of(values: &[&[u8]]) -> Option<T> {
    let all: Vec<_> = values.iter().map(|bytes| read(bytes)).collect();
    seen(&all).data_type(OBJECT).map(|(data_type, from)| {
        assert_eq!(from, TypeFrom::Inferred);
        data_type
    })
}

#[test]
fn access_as_shown() {
    let (up, down) = (Direction::Upload, Direction::Download);
    let access = |all: &[Transfer]| seen(all).access();
    assert_eq!(access(&[read(&[1])]), Some("r"));
    assert_eq!(access(&[written(&[1])]), Some("w"));
    assert_eq!(access(&[written(&[1]), read(&[1])]), Some("rw"));
    assert_eq!(access(&[read(&[1]), refused(down, READ_ONLY)]), Some("ro"));
    assert_eq!(access(&[written(&[1]), refused(up, WRITE_ONLY)]), Some("wo"));
    // A refusal by the state of the device, or at present, does not describe the access.
    assert_eq!(access(&[read(&[1]), refused(down, 0x0800_0022)]), Some("r"));
    assert_eq!(access(&[read(&[1]), refused(down, 0x0601_0000)]), Some("r"));
    // A successful access is permitted.
    assert_eq!(access(&[refused(down, READ_ONLY), written(&[1])]), Some("w"));
    assert_eq!(access(&[refused(down, READ_ONLY)]), None);
    // The client's abort is not a refusal.
    let given_up = transfer(down, &[1], Status::Aborted, Some((READ_ONLY, Side::Client)));
    let given_up = seen(&[given_up]);
    assert_eq!((given_up.count(Source::Unconfirmed), given_up.count(Source::Refused)), (1, 0));
}

#[test]
fn what_there_is() {
    let up = Direction::Upload;
    assert_eq!(seen(&[read(&[1])]).exists(), Some(true));
    assert_eq!(seen(&[refused(up, 0x0602_0000)]).exists(), Some(false));
    assert_eq!(seen(&[refused(up, 0x0609_0011)]).exists(), Some(false));
    assert_eq!(seen(&[refused(up, WRITE_ONLY)]).exists(), Some(true));
    assert_eq!(seen(&[refused(up, 0x0800_0000)]).exists(), None);
    // A device that had the object before, or has it later, has it.
    assert_eq!(seen(&[refused(up, 0x0602_0000), read(&[1])]).exists(), Some(true));
}

#[test]
fn an_unconfirmed_write_is_no_value() {
    let asked = transfer(Direction::Download, &[7, 0], Status::Incomplete, None);
    let object = seen(&[read(&[5, 0]), asked.clone()]);
    assert!(matches!(&object.value, Some(HeldValue { value: SeenValue::Bytes(bytes, 2), .. }) if bytes == &[5, 0]));
    assert!(matches!(&object.requested, Some(HeldValue { value: SeenValue::Bytes(bytes, 2), .. }) if bytes == &[7, 0]));
    assert_eq!((object.values(), object.count(Source::Unconfirmed)), (1, 1));
    assert!(seen(&[asked, written(&[7, 0])]).requested.is_none());
    // Both sides completed it, but the data are invalid.
    let mut bad = read(&[9, 9]);
    bad.outcome.bad = true;
    let bad = seen(&[bad]);
    assert_eq!((bad.values(), bad.value.is_none()), (0, true));
    // An incomplete value does not count, although it was read.
    let mut holed = read(&[9, 9]);
    holed.data.hole = true;
    let holed = seen(&[holed]);
    assert_eq!((holed.count(Source::Read), holed.value.is_none(), holed.bits()), (1, true, None));
}

#[test]
fn what_is_written_and_accepted_is_configured() {
    let configured = |all: &[Transfer], mux| {
        let held = seen(all).configured(mux)?.value.clone();
        if let SeenValue::Bytes(bytes, _) = held { Some(bytes) } else { None }
    };
    assert_eq!(configured(&[written(&[1]), written(&[2]), read(&[3])], OBJECT), Some(vec![2]));
    assert_eq!(configured(&[read(&[3])], OBJECT), None);
    let unanswered = transfer(Direction::Download, &[7], Status::Incomplete, None);
    assert_eq!(configured(&[written(&[1]), unanswered], OBJECT), Some(vec![1]));
    for (index, sub) in [(0x1003, 0), (0x1010, 1), (0x1011, 4), (0x1F51, 1), (0x6040, 0), (0x6840, 0)] {
        assert_eq!(configured(&[written(&[1])], Mux { index, sub }), None, "{index:04X}");
    }
    for (index, sub) in [(0x1003, 1), (0x1017, 0), (0x6060, 0)] {
        assert_eq!(configured(&[written(&[1])], Mux { index, sub }), Some(vec![1]), "{index:04X}");
    }
}

#[test]
fn a_value_varies_where_nobody_has_written_it() {
    let varies = |all: &[Transfer]| seen(all).varies;
    assert!(varies(&[read(&[1]), read(&[2])]));
    assert!(varies(&[read(&[1; 9]), read(&[1; 10])]));
    assert!(varies(&[read(&[1]), read(&[2]), read(&[2])]));
    assert!(!varies(&[read(&[1]), read(&[1])]));
    assert!(!varies(&[read(&[1]), written(&[2]), read(&[2])]));
    assert!(!varies(&[written(&[1]), written(&[2]), read(&[3])]));
    assert!(!varies(&[read(&[7; 8000]), read(&[7; 8000])]));
}

#[test]
fn what_was_read_before_any_write() {
    let first = |all: &[Transfer]| {
        let held = seen(all).measured.first?;
        if let SeenValue::Bytes(bytes, _) = held.value { Some(bytes) } else { None }
    };
    assert_eq!(first(&[read(&[1]), read(&[2]), written(&[3])]), Some(vec![1]));
    assert_eq!(first(&[written(&[3]), read(&[3])]), None);
    let unanswered = transfer(Direction::Download, &[7], Status::Incomplete, None);
    assert_eq!(first(&[unanswered, read(&[1]), read(&[1])]), None, "it may have been taken");
    assert_eq!(first(&[refused(Direction::Download, READ_ONLY), read(&[1])]), Some(vec![1]));
    assert_eq!(first(&[refused(Direction::Upload, WRITE_ONLY), read(&[1])]), Some(vec![1]));
}

#[test]
fn sizes_and_extremes() {
    let extremes = |values: &[&[u8]]| {
        let all: Vec<_> = values.iter().map(|bytes| read(bytes)).collect();
        seen(&all).measured.extremes().unwrap_or_default().0
    };
    assert_eq!(extremes(&[&[5], &[7], &[6]]), [5, 7]);
    // Without a sign 1 is the least and FFh the greatest, with one 80h and 7Fh.
    assert_eq!(extremes(&[&[1], &[0x7F], &[0x80], &[0xFF], &[0x30]]), [1, 0x7F, 0x80, 0xFF]);
    // As reals -2.5 is the least, which is between the others in either other interpretation.
    let real = |number: f32| u64::from(number.to_bits());
    let values = [-2.5_f32, -0.5, 3.0, f32::NAN].map(f32::to_le_bytes);
    let found = extremes(&[&values[0], &values[1], &values[2], &values[3]]);
    assert!(found.contains(&real(-2.5)) && found.contains(&real(3.0)), "{found:X?}");
    assert_eq!(extremes(&[&[5], &[1, 2], &[3, 0]]), [3, 0x201], "of the width last seen");
    assert!(extremes(&[&[0; 9]]).is_empty());

    let mut unsized_read = read(&[1, 0, 0, 0]);
    unsized_read.data.size_indicated = None;
    let object = seen(&[unsized_read, read(&[1]), written(&[1, 0])]);
    assert_eq!(object.measured.sizes(Direction::Upload), Some((1, 1)), "what tells no size has none");
    assert_eq!(object.measured.sizes(Direction::Download), Some((2, 2)));
}

#[test]
fn types_by_looks() {
    assert_eq!(type_of(&[&[1]]), Some(T::Unsigned8));
    assert_eq!(type_of(&[&[1, 2, 3]]), Some(T::Unsigned24));
    assert_eq!(type_of(&[&[0xFE, 0xFF], &[3, 0]]), Some(T::Integer16));
    // All bits may be a mask, one value alone proves nothing, and distant values are not closer with a sign.
    assert_eq!(type_of(&[&[0xFF, 0xFF], &[0, 0]]), Some(T::Unsigned16));
    assert_eq!(type_of(&[&[0xFE, 0xFF]]), Some(T::Unsigned16));
    assert_eq!(type_of(&[&[0x00, 0x80], &[0xFF, 0x7F]]), Some(T::Unsigned16));
    assert_eq!(type_of(&[b"device"]), Some(T::VisibleString));
    assert_eq!(type_of(&[b"device", b"longer name"]), Some(T::VisibleString));
    assert_eq!(type_of(&[b"device", &[1, 2, 3, 4, 5, 6]]), Some(T::Unsigned48));
    assert_eq!(type_of(&[&[1; 9], &[2; 9]]), Some(T::OctetString));
    assert_eq!(type_of(&[&[1; 9], &[2; 12]]), Some(T::Domain));
    assert_eq!(type_of(&[&[]]), None);
    let mut bits = Looks::default();
    bits.take(Content::Bits(1, 1));
    assert_eq!(bits.inferred(), Some(T::Boolean));
    let mut nibble = Looks::default();
    nibble.take(Content::Bits(1, 4));
    assert_eq!((nibble.inferred(), nibble.bits()), (None, Some(4)));
}

#[test]
fn memory_is_bounded() {
    let mut inventory = Inventory::default();
    let mut one = read(&[7; 8000]);
    for index in 0..300_u32 {
        for sub in 0..500_u32 {
            one.mux = Some(Mux { index: 0x2000 + index as u16, sub: (sub % 250) as u8 });
            one.node = 1 + (sub / 250) as u8;
            inventory.transfer(&refused_at(&one));
        }
    }
    let kept: usize = inventory.nodes.values().map(|node| node.objects.len()).sum();
    let further: u64 = inventory.nodes.values().map(|node| node.further).sum();
    assert_eq!((kept, further), (MOST, 300 * 500 - MOST as u64));
    let Some(HeldValue { value: SeenValue::Bytes(bytes, 8000), .. }) = seen(&[read(&[7; 8000])]).value else {
        panic!()
    };
    assert_eq!(bytes.len(), KEPT);
}

fn refused_at(transfer: &Transfer) -> Transfer {
    let mut refused = refused(Direction::Upload, 0x0602_0000);
    (refused.mux, refused.node) = (transfer.mux, transfer.node);
    refused
}

#[test]
fn the_filter_takes_objects_too() {
    let mut inventory = Inventory::new(Filter::parse("node=5 object=2000:02").unwrap());
    inventory.transfer(&read(&[1]));
    assert!(inventory.nodes.is_empty());
    let mut inventory = Inventory::new(Filter::parse("node=5 object=2000").unwrap());
    inventory.transfer(&read(&[1]));
    assert_eq!(inventory.nodes.len(), 1);
    let mut inventory = Inventory::new(Filter::parse("node=6").unwrap());
    inventory.transfer(&read(&[1]));
    assert!(inventory.nodes.is_empty());
}

proptest! {
    /// Every value is of the type that was inferred for it.
    #[test]
    fn inferred_types_fit(values in proptest::collection::vec(proptest::collection::vec(any::<u8>(), 0..12), 1..6)) {
        let all: Vec<_> = values.iter().map(|bytes| read(bytes)).collect();
        let object = seen(&all);
        prop_assert_eq!(object.values(), values.len() as u64);
        if let Some(size) = object.data_type(OBJECT).and_then(|(data_type, _)| data_type.size()) {
            prop_assert!(values.iter().all(|bytes| bytes.len() == size));
        }
    }
}

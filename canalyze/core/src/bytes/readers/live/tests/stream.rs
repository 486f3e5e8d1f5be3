//! The reader by itself: every kind of block, every chunking, several buses, and invalid blocks.

use proptest::prelude::*;

use super::*;
use crate::bytes::frame::{BusId, Buses, CanId, Direction, Stamp, StampForm};
use crate::bytes::ns::Ns;
use crate::bytes::readers::live::messages::Layout;
use crate::bytes::readers::live::{HEAD, Live, held};
use crate::bytes::readers::{Damage, FilePlace, Item, Marker, Unreadable};

const DAY: i64 = 1_700_000_000_000_000_000;

fn read(chunks: &[&[u8]]) -> (Vec<Item>, Buses) {
    let (mut reader, mut buses, mut items) = (Live::default(), Buses::default(), Vec::new());
    for chunk in chunks {
        reader.feed(chunk, &mut buses, &mut |item, _| items.push(item));
    }
    reader.finish(&mut buses, &mut |item, _| items.push(item));
    (items, buses)
}

fn frames(items: &[Item]) -> Vec<Frame> {
    items.iter().filter_map(|item| if let Item::Frame(frame) = item { Some(*frame) } else { None }).collect()
}

/// Returns bus and time of frames, and short forms of other items.
fn told(items: &[Item]) -> Vec<String> {
    let one = |item: &Item| match item {
        Item::Frame(frame) => format!("{}:{}", frame.bus.0, frame.t_ns.map_or(-1, Ns::as_ns)),
        Item::Until { now_ns } => format!("until {}", now_ns.as_ns()),
        Item::Gap { bus, .. } => format!("gap {}", bus.0),
        Item::Marker(Marker::Dropped { bus, count, total, place: FilePlace::Live }) => {
            format!("dropped {} {count} {total}", bus.0)
        }
        Item::Damaged(Damage { kind, .. }) => format!("{kind:?}"),
        other => format!("{other:?}"),
    };
    items.iter().map(one).collect()
}

fn at(t_ns: i64) -> Frame {
    Frame { t_ns: Some(Ns(t_ns)), ..Frame::classic(CanId::standard(0x181), &[1, 2, 3]) }
}

fn one(bus: u8, t_ns: i64) -> Vec<u8> {
    received(bus, 0, &[Sent::new(&at(t_ns))])
}

fn every_kind() -> Vec<Frame> {
    let of = |id, bytes: &[u8]| Frame::classic(id, bytes);
    let mut raw_dlc = of(CanId::standard(0x601), &[1, 2, 3, 4, 5, 6, 7, 8]);
    raw_dlc.length_form.raw_dlc = 13;
    let mut long = Frame { kind: Kind::Fd { brs: true, esi: true }, len: 64, ..of(CanId::extended(0x1FFF_FFFF), &[]) };
    long.data = std::array::from_fn(|at| at as u8);
    vec![
        of(CanId::standard(0x7FF), &[9; 8]),
        of(CanId::standard(0), &[]),
        of(CanId::extended(0x123), &[1]),
        Frame { kind: Kind::Remote, len: 4, ..of(CanId::standard(0x70A), &[]) },
        Frame { kind: Kind::Error, ..of(CanId::extended(0x88), &[0, 0, 0, 8, 0, 0, 0, 0]) },
        raw_dlc,
        Frame { kind: Kind::Fd { brs: false, esi: false }, ..of(CanId::standard(0x123), &[1, 2, 3]) },
        long,
    ]
}

#[test]
fn messages_of_both_widths() {
    for (word, layout) in [(8, Layout::WIDE), (4, Layout::NARROW)] {
        let mut sent: Vec<Sent> = every_kind().iter().map(Sent::new).collect();
        for (no, sent) in (0..).zip(&mut sent) {
            (sent.kernel, sent.flags) = (Some(1_700_000_000_123_456_789 + no), if no % 2 == 0 { 4 } else { 0 });
            sent.hardware = (no == 3 || no == 4).then_some(5_000_000_007);
            sent.overflow = Some(no as u32);
        }
        let body = messages(&sent, word);
        assert_eq!(layout.bytes(sent.len() as i64), Some(body.len() as u64));
        let found: Vec<_> = layout.messages(&body).collect();
        assert_eq!(found.len(), sent.len());
        let mut ahead = None;
        for (no, (found, expected)) in found.iter().zip(every_kind()).enumerate() {
            let stamped = |ns, decimals| {
                let stamp = Some(Stamp { form: StampForm::Seconds, ns, width: 10, decimals });
                let dir = Some(if no % 2 == 0 { Direction::Tx } else { Direction::Rx });
                format!("{:?}", Frame { t_ns: Some(ns), stamp, dir, ..expected })
            };
            assert_eq!(found.overflow, Some(no as u32));
            assert_eq!(format!("{:?}", found.frame().unwrap()), stamped(Ns(1_700_000_000_123_456_000), 6));
            // An item without an adapter stamp follows one with a stamp at the distance of their kernel stamps.
            let (ns, decimals) = match no {
                3 | 4 => (5_000_000_007, 9),
                5.. => (5_000_000_007 + no as i64 - 4, 9),
                _ => (1_700_000_000_123_456_000, 6),
            };
            assert_eq!(format!("{:?}", found.frame_by_hardware(&mut ahead).unwrap()), stamped(Ns(ns), decimals));
        }
    }
}

#[test]
fn every_kind_of_block() {
    let frame = Frame { stamp: Some(Stamp { form: StampForm::Seconds, ns: Ns(7), width: 1, decimals: 9 }), ..at(7) };
    let mut names = Buses::default();
    names.intern(b"elsewhere");
    let stream = [
        named(3, "can1"),
        one(3, DAY + 1_999),
        records(3, &[frame, Frame { t_ns: None, stamp: None, ..frame }], CaptureFacts { buses: &names, date_ns: None }),
        named(3, "can1"),
        block(kind::DROPPED, 3, 0, 5, b""),
        block(kind::DROPPED, 3, 1, 2, b""),
        block(kind::GAP, 3, 0, 0, b""),
        until(Ns(DAY + 5)),
        until(Ns::MAX),
    ];
    let (items, buses) = read(&[&stream.concat()]);
    let expected = [
        &format!("0:{}", DAY + 1_000),
        "0:7",
        "0:-1",
        "dropped 0 5 5",
        "dropped 0 2 7",
        "gap 0",
        &format!("until {}", DAY + 5),
    ];
    assert_eq!(told(&items), expected);
    assert_eq!(buses.names().collect::<Vec<_>>(), [b"can1"]);
}

#[test]
fn frames_that_cannot_be_are_unreadable() {
    let mut sent: Vec<Sent> = (0..5).map(|no| Sent::new(&at(DAY + no * 1_000))).collect();
    sent[0].flags = 0x20;
    sent[1].frame.truncate(8);
    sent[2].frame[4] = 9;
    sent[3].kernel = None;
    let (items, _) = read(&[&named(0, "can0"), &received(0, 0, &sent)]);
    let reasons: Vec<_> = items
        .iter()
        .filter_map(|item| if let Item::Unreadable { reason, place } = item { Some((*reason, *place)) } else { None })
        .collect();
    assert_eq!(
        reasons,
        [Unreadable::Data, Unreadable::Data, Unreadable::Length].map(|reason| (reason, FilePlace::Live))
    );
    let stamps: Vec<_> = frames(&items).iter().map(|frame| frame.t_ns).collect();
    assert_eq!(stamps, [None, Some(Ns(DAY + 4_000))]);
}

#[test]
fn a_socket_counts_what_it_has_lost() {
    let with = |totals: &[Option<u32>]| {
        let sent: Vec<Sent> = totals.iter().map(|total| Sent { overflow: *total, ..Sent::new(&at(1_000)) }).collect();
        received(0, 0, &sent)
    };
    let told_of = |blocks: &[Vec<u8>]| told(&read(&[&named(0, "can0"), &blocks.concat()]).0);
    let all = with(&[None, Some(3), Some(3), None, Some(10)]);
    assert_eq!(told_of(&[all]), ["0:1000", "dropped 0 3 3", "0:1000", "0:1000", "0:1000", "dropped 0 7 10", "0:1000"]);
    // A socket continues counting after a gap; opened anew it is named again, or its count is lower; 32 bits overflow.
    let gap = block(kind::GAP, 0, 0, 0, b"");
    let twice = [with(&[Some(5)]), gap, with(&[Some(6)]), with(&[Some(2)]), named(0, "can0"), with(&[Some(2)])];
    assert_eq!(
        told_of(&twice),
        [
            "dropped 0 5 5",
            "0:1000",
            "gap 0",
            "dropped 0 1 6",
            "0:1000",
            "dropped 0 2 8",
            "0:1000",
            "dropped 0 2 10",
            "0:1000"
        ]
    );
    let over = [with(&[Some(u32::MAX - 1)]), with(&[Some(1)])];
    let first = u64::from(u32::MAX - 1);
    assert_eq!(told_of(&over)[2], format!("dropped 0 3 {}", first + 3));
}

#[test]
fn several_buses_are_joined_by_time() {
    let stream = [
        named(0, "can0"),
        named(1, "can1"),
        received(0, 0, &[at(1_000), at(5_000), at(4_000)].map(|frame| Sent::new(&frame))),
        one(1, 2_000),
        block(kind::DROPPED, 1, 0, 1, b""),
        one(1, 6_000),
        until(Ns(3_000)),
        one(1, 5_000),
        until(Ns(5_500)),
        until(Ns(9_000)),
    ];
    // 4 came after 5 on its bus, and 5 after 6: they keep that order. Items without a stamp stay with the one before.
    let expected = [
        "0:1000",
        "1:2000",
        "dropped 1 1 1",
        "until 3000",
        "0:5000",
        "0:4000",
        "until 5500",
        "1:6000",
        "1:5000",
        "until 9000",
    ];
    assert_eq!(told(&read(&[&stream.concat()]).0), expected);
    // Without a final tick the end releases the rest; a stopped time releases all, without a tick.
    let cut = stream[..7].concat();
    assert_eq!(told(&read(&[&cut]).0)[4..], ["0:5000", "0:4000", "1:6000"]);
    let all = [cut, until(Ns::MAX)].concat();
    assert_eq!(told(&read(&[&all]).0).len(), 7);
}

#[test]
fn a_clock_that_is_set_back_holds_nothing_up() {
    let stream =
        [named(0, "can0"), named(1, "can1"), until(Ns(DAY)), one(0, DAY + 1_000_000), one(1, DAY + 500_000)].concat();
    let back = [stream, until(Ns(DAY - 3_600_000_000_000)), one(0, 7_000), one(1, 6_000), until(Ns(8_000))].concat();
    let mut expected =
        [DAY + 500_000, DAY + 1_000_000].iter().zip([1, 0]).map(|(ns, bus)| format!("{bus}:{ns}")).collect::<Vec<_>>();
    expected.insert(0, format!("until {DAY}"));
    expected.push(format!("until {}", DAY - 3_600_000_000_000));
    // At the second step back no later item is held.
    expected.extend(["1:6000", "0:7000", "until 8000"].map(str::to_owned));
    assert_eq!(told(&read(&[&back]).0), expected);
}

#[test]
fn no_more_is_held_than_there_is_room_for() {
    let (mut reader, mut buses) = (Live::default(), Buses::default());
    reader.feed(&[named(0, "a"), named(1, "b")].concat(), &mut buses, &mut |_, _| {});
    let sent = vec![Sent::new(&at(1_000)); 1024];
    let (piece, mut given) = (received(0, 0, &sent), 0);
    for _ in 0..held::MOST / 1024 + 1 {
        reader.feed(&piece, &mut buses, &mut |_, _| given += 1);
    }
    assert_eq!(given, held::MOST);
}

#[test]
fn what_is_no_block_ends_the_stream_once() {
    let frame = CaptureFacts { buses: &Buses::default(), date_ns: None };
    let good = [named(0, "can0"), one(0, 1_000)].concat();
    let mut short = received(0, 0, &[Sent::new(&at(1))]);
    short[8] = 2;
    let mut further = until(Ns(1));
    further[3] = 1;
    let cut = records(0, &[at(1)], frame);
    for bad in [
        block(9, 0, 0, 0, b""),
        block(kind::MESSAGES, 0, 2, 0, b""),
        block(kind::MESSAGES, 0, 0, -1, b""),
        block(kind::MESSAGES, 7, 0, 0, b""),
        block(kind::DROPPED, 0, 0, -1, b""),
        block(kind::UNTIL, 0, 0, 0, b"x"),
        block(kind::RECORDS, 0, 0, 0, &cut[HEAD..HEAD + 20]),
        block(kind::RECORDS, 0, 0, 0, &[200; 24]),
        [&[kind::BUS, 0, 0, 0][..], &u32::MAX.to_le_bytes(), &[0; 8]].concat(),
        short,
        further,
    ] {
        let stream = [good.clone(), bad, one(0, 2_000)].concat();
        let (items, _) = read(&[&stream]);
        assert_eq!(told(&items), ["0:1000", "Rest"]);
        let Item::Damaged(damage) = items[1] else { panic!("{items:?}") };
        assert_eq!(damage.place, FilePlace::Byte(good.len() as u64));
    }
    assert_eq!(told(&read(&[&good[..good.len() - 1]]).0), ["Cut"]);
    let (mut reader, mut buses, mut items) = (Live::default(), Buses::default(), Vec::new());
    reader.feed(&good[..good.len() - 1], &mut buses, &mut |item, _| items.push(item));
    reader.interrupt(&mut buses, &mut |item, _| items.push(item));
    assert_eq!(items.len(), 0);
}

fn blocks() -> impl Strategy<Value = Vec<u8>> {
    let some = (0..3_u8, 0..20_i64, 0..4_usize).prop_map(|(bus, us, kind)| {
        let mut sent = Sent::new(&every_kind()[kind * 2 + usize::from(bus > 1)]);
        sent.kernel = (us != 0).then_some(us * 1_000);
        sent.overflow = (us == 3).then_some(kind as u32);
        received(bus, 0, &[sent.clone(), sent])
    });
    let rest = prop_oneof![
        (0..30_i64).prop_map(|us| until(Ns(us * 1_000))),
        Just(until(Ns::MAX)),
        (0..3_u8).prop_map(|bus| block(kind::GAP, bus, 0, 0, b"")),
        (0..3_u8, 0..5_i64).prop_map(|(bus, count)| block(kind::DROPPED, bus, 0, count, b"")),
    ];
    prop::collection::vec(prop_oneof![4 => some, 1 => rest], 0..40).prop_map(|blocks| {
        let names = [named(0, "can0"), named(1, "can1"), named(2, "can2")];
        [names.concat(), blocks.concat()].concat()
    })
}

proptest! {
    #[test]
    fn any_chunking_gives_the_same(stream in blocks(), cut in 1..700_usize) {
        let whole = read(&[&stream]).0;
        let chunks: Vec<&[u8]> = stream.chunks(cut).collect();
        prop_assert_eq!(format!("{:?}", read(&chunks).0), format!("{whole:?}"));
        let bytes: Vec<&[u8]> = stream.chunks(1).collect();
        prop_assert_eq!(format!("{:?}", read(&bytes).0), format!("{whole:?}"));
    }

    /// Joined or alone, the items of one bus keep their order, and none is lost.
    #[test]
    fn the_order_within_a_bus_is_kept(stream in blocks(), bus in 0..3_u8) {
        let of = |items: &[Item]| {
            let mine = |item: &&Item| match item {
                Item::Frame(frame) => frame.bus == BusId(bus),
                Item::Gap { bus: of, .. } | Item::Marker(Marker::Dropped { bus: of, .. }) => *of == BusId(bus),
                _ => false,
            };
            let mine: Vec<Item> = items.iter().filter(mine).copied().collect();
            let unnumbered = told(&mine);
            unnumbered.iter().map(|text| text.replacen(&bus.to_string(), "", 1)).collect::<Vec<_>>()
        };
        // The same bus alone, without the blocks of others.
        let (mut alone, mut rest) = (named(bus, "x"), stream.as_slice());
        while rest.len() >= HEAD {
            let length = u32::from_le_bytes(rest[4..8].try_into().unwrap()) as usize;
            let (block, behind) = rest.split_at(HEAD + length);
            if block[1] == bus && block[0] != kind::BUS && block[0] != kind::UNTIL {
                alone.extend_from_slice(block);
            }
            rest = behind;
        }
        let alone: Vec<String> = told(&read(&[&alone]).0).iter().map(|text| text.replacen('0', "", 1)).collect();
        prop_assert_eq!(of(&read(&[&stream]).0), alone);
    }

    #[test]
    fn anything_is_read_without_panic(bytes in prop::collection::vec(0..9_u8, 0..600), cut in 1..40_usize) {
        let chunks: Vec<&[u8]> = bytes.chunks(cut).collect();
        prop_assert_eq!(format!("{:?}", read(&chunks).0), format!("{:?}", read(&[&bytes]).0));
    }

    /// Headers and slots with any content.
    #[test]
    fn messages_of_anything(bytes in prop::collection::vec(any::<u8>(), 528..=528), word in any::<bool>()) {
        let layout = if word { Layout::WIDE } else { Layout::NARROW };
        for message in layout.messages(&bytes) {
            _ = (message.frame().is_ok(), message.frame_by_hardware(&mut None).is_ok());
        }
    }
}

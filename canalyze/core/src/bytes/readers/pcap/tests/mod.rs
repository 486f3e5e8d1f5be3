//! Files packed by hand, byte by byte, and the laws that hold for any input.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]

use std::fmt::Write;

use proptest::prelude::*;

use super::*;
use crate::bytes::frame::{CanId, Direction, Frame, Kind};
use crate::bytes::ns::Ns;
use crate::bytes::readers::Marker;
use crate::bytes::writers::pcapng::Pcapng;
use crate::bytes::writers::{CaptureFacts, Loss};

mod damage;
mod made;

use made::{Made, classic, epb, fd, four, idb, legacy, option, record, shb, sll, sll2};

/// Returns all items of a file, one on each line, in a short notation.
fn items(bytes: &[u8], cuts: &[usize]) -> String {
    let mut reader = Pcap::default();
    let mut buses = Buses::default();
    let mut out = String::new();
    let mut sink = |item: Item, buses: &Buses| match item {
        Item::Frame(frame) => writeln!(out, "{}", shown(&frame, buses)).unwrap(),
        Item::Marker(marker) => writeln!(out, "{marker:?}").unwrap(),
        Item::Unreadable { place, reason } => writeln!(out, "{place:?} {reason:?}").unwrap(),
        Item::Damaged(Damage { place, kind, bytes, frames: None }) => {
            writeln!(out, "{place:?} {kind:?} {}", bytes.unwrap()).unwrap();
        }
        other => panic!("{other:?}"),
    };
    let mut rest = bytes;
    for cut in cuts {
        let (piece, after) = rest.split_at(*cut.min(&rest.len()));
        reader.feed(piece, &mut buses, &mut sink);
        rest = after;
    }
    reader.feed(rest, &mut buses, &mut sink);
    reader.finish(&mut buses, &mut sink);
    reader.finish(&mut buses, &mut sink);
    let Contents { dialect, passed_over, .. } = reader.contents();
    for (name, value) in dialect {
        writeln!(out, "{name}: {}", value.escape_ascii()).unwrap();
    }
    for (name, count) in passed_over {
        writeln!(out, "{count} x {}", name.escape_ascii()).unwrap();
    }
    out
}

/// Returns frames and other items, without the properties of the file.
fn read(bytes: &[u8]) -> String {
    let text = items(bytes, &[]);
    assert_eq!(text, items(bytes, &vec![1; bytes.len()]), "one byte at a time");
    let lines = text.lines().filter(|line| {
        let (word, _) = line.split_once(": ").unwrap_or(("", ""));
        !["version", "byte order", "interface", "application", "hardware", "operating system"].contains(&word)
    });
    lines.map(|line| format!("{line}\n")).collect()
}

/// Returns `time bus direction id kind length bytes` without empty parts.
fn shown(frame: &Frame, buses: &Buses) -> String {
    let mut out = String::new();
    assert_eq!((frame.line, frame.no, frame.t_ns), (None, 0, frame.stamp.map(|stamp| stamp.ns)));
    match frame.stamp {
        Some(stamp) => write!(out, "{}/{} ", stamp.ns.as_ns(), stamp.decimals).unwrap(),
        None => out.push_str("- "),
    }
    write!(out, "{} ", buses.name(frame.bus).escape_ascii()).unwrap();
    match frame.dir {
        Some(Direction::Rx) => out.push_str("rx "),
        Some(Direction::Tx) => out.push_str("tx "),
        None => {}
    }
    write!(out, "{:?} ", frame.id).unwrap();
    match frame.kind {
        Kind::Data => {}
        Kind::Remote => out.push_str("rtr "),
        Kind::Fd { brs, esi } => {
            write!(out, "fd{}{} ", if brs { "B" } else { "" }, if esi { "E" } else { "" }).unwrap();
        }
        Kind::Error => out.push_str("error "),
    }
    write!(out, "{}", frame.len).unwrap();
    if !frame.payload().is_empty() {
        out.push(' ');
    }
    for byte in frame.payload() {
        write!(out, "{byte:02X}").unwrap();
    }
    if frame.length_form.raw_dlc != 0 {
        write!(out, " dlc{:X}", frame.length_form.raw_dlc).unwrap();
    }
    assert!(frame.data[if frame.kind == Kind::Remote { 0 } else { usize::from(frame.len) }..].iter().all(|&b| b == 0));
    out
}

const ORDERS: [ByteOrder; 2] = [ByteOrder::Little, ByteOrder::Big];

#[test]
fn pcap_in_both_orders_and_resolutions() {
    for order in ORDERS {
        for (nano, stamp) in [(false, "1.000005/6"), (true, "1.000000005/9")] {
            let file = [legacy(order, nano, 227), record(order, 1, 5, &classic(0x601, &[0x40, 8]))].concat();
            let stamp = stamp.replace("1.", "1").replace("000005/6", "000005000/6");
            assert_eq!(read(&file), format!("{stamp} can0 601 2 4008\n"));
        }
    }
    let file = [legacy(ByteOrder::Big, false, 227), record(ByteOrder::Big, 1, 5, &[0; 5])].concat();
    assert_eq!(
        items(&file, &[]),
        "Byte(24) Data\nversion: 2.4\nbyte order: big-endian\ninterface: can0: CAN_SOCKETCAN (227), 1e-6 s, snaplen 65535\n"
    );
}

#[test]
fn socketcan_headers() {
    let long: Vec<u8> = (0..64).collect();
    let digits: String = long.iter().map(|byte| format!("{byte:02X}")).collect();
    let mut short_fd = classic(0x123, &[1, 2, 3]);
    short_fd[5] = 5;
    let mut junk = classic(0x123, &[1]);
    junk[5..8].copy_from_slice(&[0xF4, 0xA, 0xB]);
    let mut dirty = fd(0x123, 0xF7, &[1]);
    dirty[6] = 9;
    let mut raw_dlc = classic(0x123, &[7; 8]);
    raw_dlc[7] = 0xE;
    let mut not_raw = classic(0x123, &[7; 7]);
    not_raw[7] = 0xE;
    let mut remote_dlc = classic(0x4000_0123, &[0; 8]);
    remote_dlc[7] = 9;
    let mut unpadded = fd(0x123, 4, &[5; 12]);
    unpadded.truncate(20);
    let mut unflagged = unpadded.clone();
    unflagged[5] = 0;
    let mut cut = classic(0x123, &[1, 2, 3]);
    cut.truncate(10);
    let mut nine = classic(0x123, &[0; 8]);
    nine[4] = 9;
    let mut long_fd = fd(0x123, 4, &long);
    long_fd[4] = 65;
    let xl = [&[0, 0, 1, 0x23, 0x81, 0, 2, 0, 0, 0, 0, 0][..], &[0; 2]].concat();
    for (packet, expected) in [
        (classic(0x123, &[]), "123 0"),
        (classic(0x7FF, &[1, 2, 3, 4, 5, 6, 7, 8]), "7FF 8 0102030405060708"),
        (classic(0x8000_0123, &[1]), "00000123 1 01"),
        (classic(0x9FFF_FFFF, &[1]), "1FFFFFFF 1 01"),
        (classic(0x4000_0123, &[0; 4]), "123 rtr 4"),
        (classic(0xD234_5678, &[]), "12345678 rtr 0"),
        (classic(0x2000_0088, &[0, 0, 0, 8, 0, 0, 0, 0]), "00000088 error 8 0000000800000000"),
        (raw_dlc, "123 8 0707070707070707 dlcE"),
        (not_raw, "123 7 07070707070707"),
        (remote_dlc, "123 rtr 8 dlc9"),
        (fd(0x123, 4, &[]), "123 fd 0"),
        (fd(0x123, 7, &[0xAA, 0xBB]), "123 fdBE 2 AABB"),
        (fd(0x8000_0123, 5, &[0xAA]), "00000123 fdB 1 AA"),
        (fd(0x123, 4, &long), &format!("123 fd 64 {digits}")),
        // libpcap 1.10 clears the flags; the size shows it
        (fd(0x123, 0, &[1]), "123 fd 1 01"),
        (fd(0x123, 2, &[1]), "123 fdE 1 01"),
        (dirty, "123 fd 1 01"),
        (short_fd, "123 fdB 3 010203"),
        (junk, "123 1 01"),
        (unpadded, "123 fd 12 050505050505050505050505"),
        (unflagged, "123 fd 12 050505050505050505050505"),
        (cut, "! Data"),
        (nine, "! Length"),
        (long_fd, "! Length"),
        (classic(0x800, &[]), "! Identifier"),
        (classic(0x6000_0001, &[]), "! Identifier"),
        (fd(0x4000_0001, 4, &[]), "! Identifier"),
        (fd(0x2000_0001, 4, &[]), "! Identifier"),
        (xl, "! CanXl"),
        (vec![0; 7], "! Data"),
        (vec![], "! Data"),
    ] {
        let expected = match expected.strip_prefix("! ") {
            Some(reason) => format!("Byte(24) {reason}\n"),
            None => format!("1000000000/6 can0 {expected}\n"),
        };
        let file = [legacy(ByteOrder::Little, false, 227), record(ByteOrder::Little, 1, 0, &packet)].concat();
        assert_eq!(read(&file), expected, "{packet:02X?}");
    }
}

#[test]
fn cooked_packets() {
    for order in ORDERS {
        // After a cooked header the identifier is in the order of the file.
        let own = |packet: Vec<u8>| match order {
            ByteOrder::Big => packet,
            ByteOrder::Little => [packet[..4].iter().rev().copied().collect(), packet[4..].to_vec()].concat(),
        };
        let can = own(classic(0x8000_0123, &[1, 2]));
        let long = own(fd(0x123, 7, &[1]));
        for (protocol, packet, expected) in [
            (0x0C, &can, "00000123 2 0102"),
            (0x0D, &long, "123 fdBE 1 01"),
            (0x0D, &own(fd(0x123, 0, &[1])), "123 fd 1 01"),
            (0x0C, &own(fd(0x123, 0, &[1])), "123 fd 1 01"),
            (0x0E, &can, "! CanXl"),
            (0x0800, &can, "1 x LINUX_SLL protocol 0x0800"),
        ] {
            for (kind, word) in [(0, "rx "), (1, ""), (2, "rx "), (3, "rx "), (4, "tx "), (5, "")] {
                let at = "1000000000/6";
                let said = |bus| match expected.strip_prefix("! ") {
                    Some(reason) => format!("Byte(24) {reason}\n"),
                    None if expected.starts_with("1 x") => format!("{expected}\n"),
                    None => format!("{at} {bus} {word}{expected}\n"),
                };
                let file = [legacy(order, false, 113), record(order, 1, 0, &sll(kind, protocol, packet))].concat();
                assert_eq!(read(&file), said("can0"));
                let file = [legacy(order, false, 276), record(order, 1, 0, &sll2(kind, protocol, 3, packet))].concat();
                assert_eq!(read(&file), said("if3"));
            }
        }
        for (link_type, head) in [(113, 16), (276, 20)] {
            for len in 0..head + 10 {
                let whole = if head == 16 { sll(4, 0x0C, &can) } else { sll2(4, 0x0C, 9, &can) };
                let file = [legacy(order, false, link_type), record(order, 1, 0, &whole[..len])].concat();
                let expected = if len < head + 10 { "Byte(24) Data\n" } else { "" };
                assert_eq!(read(&file), expected);
            }
        }
    }
    let order = ByteOrder::Little;
    let file: Vec<u8> = [5, 6, 5].map(|n| record(order, 1, 0, &sll2(1, 0x0D, n, &fd(0, 4, &[])))).concat();
    let file = [legacy(order, true, 276), file].concat();
    assert_eq!(read(&file), "1000000000/9 if5 000 fd 0\n1000000000/9 if6 000 fd 0\n1000000000/9 if5 000 fd 0\n");
}

#[test]
fn what_wireshark_makes_of_logs() {
    let order = ByteOrder::Big;
    let tagged = |name: &[u8], packet: &[u8]| {
        let other = [&[0, 33, 0, 4][..], &[9; 4]].concat();
        [&other, &[0, 12, 0, 16][..], name, &vec![0; 16 - name.len()], &[0; 4], packet].concat()
    };
    for (packet, expected) in [
        (tagged(b"can-hostendian", &classic(0x8000_0123, &[1])), "1000000000/6 can0 00000123 1 01\n"),
        (tagged(b"canfd", &fd(0x123, 1, &[1])), "1000000000/6 can0 123 fdB 1 01\n"),
        (tagged(b"canfd", &fd(0x123, 1, &[1])[..20]), "1000000000/6 can0 123 fdB 1 01\n"),
        (tagged(b"can-hostendian", &[0; 7]), "Byte(24) Data\n"),
        (tagged(b"http", &classic(1, &[])), "1 x WIRESHARK_UPPER_PDU (252)\n"),
        (vec![0, 12, 0, 5, 1], "1 x WIRESHARK_UPPER_PDU (252)\n"),
        (vec![], "1 x WIRESHARK_UPPER_PDU (252)\n"),
    ] {
        let file = [legacy(order, false, 252), record(order, 1, 0, &packet)].concat();
        assert_eq!(read(&file), expected);
    }
}

#[test]
fn stamps_of_every_resolution() {
    let second: u64 = 1_000_000_000;
    for order in ORDERS {
        for (resolution, units, offset, expected) in [
            (None, 1_000_005, 0, "1000005000/6"),
            (Some(0), 7, 0, "7000000000/0"),
            (Some(3), 1005, 0, "1005000000/3"),
            (Some(6), 1_000_005, 100, "101000005000/6"),
            (Some(9), second + 5, -1, "5/9"),
            (Some(9), 5, -1, "-999999995/9"),
            (Some(12), 1_000_000_000_999, 0, "1000000000/9"),
            (Some(28), u64::MAX, 0, "1/9"),
            (Some(29), u64::MAX, 0, "0/9"),
            (Some(127), u64::MAX, 0, "0/9"),
            (Some(0x80), 7, 0, "7000000000/0"),
            (Some(0x80 | 10), 1536, 0, "1500000000/9"),
            (Some(0x80 | 4), 24, 0, "1500000000/4"),
            (Some(0x80 | 32), 3 << 31, 0, "1500000000/9"),
            (Some(0xFF), u64::MAX, 0, "0/9"),
            (Some(9), u64::MAX, 0, "9223372036854775807/9"),
            (Some(0), u64::MAX, 0, "9223372036854775807/0"),
            (Some(9), 5, i64::MAX, "9223372036854775807/9"),
        ] {
            let mut options = Vec::new();
            if let Some(resolution) = resolution {
                options.extend(option(order, 9, &[resolution]));
            }
            options.extend(option(order, 14, &made::eight(order, offset as u64)));
            let file = [
                shb(order),
                idb(order, 227, 0, &[option(order, 2, b"can7"), options].concat()),
                epb(order, 0, units, &classic(0x80, &[]), &[]),
            ];
            assert_eq!(read(&file.concat()), format!("{expected} can7 080 0\n"), "{resolution:?} {units} {offset}");
        }
    }
}

#[test]
fn interfaces_and_sections() {
    let mut file = Made::default();
    for order in ORDERS {
        file.add(shb(order));
        file.add(idb(order, 227, 0, &option(order, 2, b"vcan0")));
        file.add(idb(order, 1, 0, &option(order, 2, b"eth0")));
        file.add(idb(order, 227, 64, &option(order, 1, b"comment")));
        file.add(idb(order, 227, 0, &option(order, 2, b" my can\0")));
        file.add(epb(order, 0, 1, &classic(1, &[]), &option(order, 1, b"a comment")));
        file.add(epb(order, 1, 2, &[0; 60], &[]));
        file.add(epb(order, 2, 3, &classic(2, &[]), &[]));
        file.add(epb(order, 3, 4, &classic(3, &[]), &[]));
        file.add(epb(order, 4, 4, &classic(3, &[]), &[]));
        file.add(made::block(order, 4, &[0; 8]));
        file.add(made::block(order, 0x8000_0001, &[0; 8]));
        file.add(made::block(order, 3, &[&made::four(order, 16)[..], &classic(4, &[])].concat()));
    }
    let text = items(&file.bytes, &[]);
    let at: Vec<usize> = [9, 22].map(|no: usize| file.starts[no]).to_vec();
    let frames = "1000/6 vcan0 001 0\n3000/6 can2 002 0\n4000/6 my_can\\x00 003 0\n";
    assert_eq!(
        text,
        format!(
            "{frames}Byte({}) NoFrame\n- vcan0 004 0\n{frames}Byte({}) NoFrame\n- vcan0 004 0\n\
             version: 1.0\nbyte order: little-endian\napplication: made by hand\n\
             interface: vcan0: CAN_SOCKETCAN (227), 1e-6 s\ninterface: eth0: ETHERNET (1), 1e-6 s\n\
             interface: can2: CAN_SOCKETCAN (227), 1e-6 s, snaplen 64\n\
             interface: my_can\\x00: CAN_SOCKETCAN (227), 1e-6 s\nbyte order: big-endian\n\
             2 x ETHERNET (1)\n2 x Name Resolution Block\n2 x block 0x80000001\n",
            at[0], at[1]
        )
    );
}

#[test]
fn direction_and_losses() {
    for order in ORDERS {
        let flags = |value| option(order, 2, &made::four(order, value));
        let drops = |value| option(order, 4, &made::eight(order, value));
        let statistics = |interface, codes: &[(u16, u64)]| {
            let mut body = [made::four(order, interface), [0; 4], [0; 4]].concat();
            for (code, value) in codes {
                body.extend(option(order, *code, &made::eight(order, *value)));
            }
            made::block(order, 5, &body)
        };
        let packet = classic(1, &[]);
        let old = |interface: u16, lost: u16, options: &[u8]| {
            let (a, b) = (made::two(order, interface), made::two(order, lost));
            let head = [a, b].concat();
            let rest = [0, 7, 16, 16].map(|word| made::four(order, word)).concat();
            made::block(order, 2, &[head, rest, classic(2, &[]), options.to_vec()].concat())
        };
        let mut file = Made::default();
        file.add(shb(order));
        file.add(idb(order, 227, 0, &[]));
        file.add(idb(order, 227, 0, &[]));
        file.add(idb(order, 1, 0, &[]));
        file.add(epb(order, 0, 1, &packet, &flags(0)));
        file.add(epb(order, 0, 1, &packet, &flags(1)));
        file.add(epb(order, 1, 1, &packet, &flags(0x1FE)));
        file.add(epb(order, 0, 1, &packet, &[drops(0), flags(3)].concat()));
        file.add(epb(order, 0, 1, &packet, &[drops(3), flags(2)].concat()));
        file.add(old(0, 4, &flags(1)));
        file.add(old(1, 0xFFFF, &[]));
        file.add(statistics(0, &[(4, 99), (5, 7)]));
        file.add(statistics(0, &[(5, 7), (7, 2)]));
        file.add(statistics(0, &[(5, 1)]));
        file.add(statistics(2, &[(5, 5)]));
        file.add(statistics(9, &[(5, 5)]));
        let at = |no: usize| file.starts[no];
        let dropped = |count, total, at| {
            format!("Dropped {{ bus: BusId(0), count: {count}, total: {total}, place: Byte({at}) }}\n")
        };
        assert_eq!(
            read(&file.bytes),
            format!(
                "1000/6 can0 001 0\n1000/6 can0 rx 001 0\n1000/6 can1 tx 001 0\n1000/6 can0 001 0\n\
                 {}1000/6 can0 tx 001 0\n{}7000/6 can0 rx 002 0\n7000/6 can1 002 0\n{}",
                dropped(3, 3, at(8)),
                dropped(4, 7, at(9)),
                dropped(2, 9, at(12)),
            )
        );
    }
}

#[test]
fn identifiers_in_the_wrong_byte_order() {
    let ids = [0x601, 0x581, 0x000, 0x181, 0x8181_0203, 0x4000_0701, 0x2000_0004, 0x601, 0x602];
    for order in [ByteOrder::Little, ByteOrder::Big] {
        for blocks in [false, true] {
            let file = |swapped: bool| {
                let head = [shb(order), made::idb(order, 227, 0, &[])].concat();
                let mut file = if blocks { head } else { legacy(order, false, 227) };
                for id in ids {
                    let packet = classic(if swapped { u32::swap_bytes(id) } else { id }, &[1, 2]);
                    file.extend(if blocks { epb(order, 0, 5, &packet, &[]) } else { record(order, 0, 5, &packet) });
                }
                file
            };
            let (right, wrong) = (read(&file(false)), read(&file(true)));
            assert_eq!(wrong, format!("Swapped\n{right}identifiers: little-endian\n"));
            assert!(right.contains("can0 601 2 0102\n") && right.contains("can0 01810203 2 0102\n"), "{right}");
            assert!(right.contains("can0 701 rtr 2\n") && right.contains("can0 00000004 error 2"), "{right}");
        }
    }
}

#[test]
fn records_of_another_order_among_those_of_one() {
    let file = |ids: &[u32]| {
        let records: Vec<Vec<u8>> = ids.iter().map(|id| record(ByteOrder::Little, 1, 0, &classic(*id, &[5]))).collect();
        [legacy(ByteOrder::Little, false, 227), records.concat()].concat()
    };
    let swapped = |id: u32| id.swap_bytes();
    for (ids, unreadable) in [
        // Several 29-bit identifiers that are 11-bit ones in the other order are invalid, and so is a single one if a
        // record is certainly of that order.
        (&[0x701, swapped(0x181), 0x702, swapped(0x281), swapped(0x181), swapped(0x080)][..], 3),
        (&[0x701, swapped(0x601), swapped(0x181), swapped(0x181)], 3),
        (&[0x701, 0x98FE_F103, swapped(0x601), swapped(0x181)], 2),
        // A single odd identifier is the only sign of another order.
        (&[0x701, 0x98FE_F103, 0x8C00_0000], 0),
        (&[0x8C00_0000, 0x98FE_F103, 0x701], 0),
        (&[0x701, 0x8000_0000, 0x98FE_F103, 0x8C00_0000], 0),
        (&[0x8C00_0000, 0x8C00_0000], 0),
    ] {
        let said = read(&file(ids));
        assert_eq!(said.matches("Identifier").count(), unreadable, "{said}");
        assert_eq!(said.lines().count(), ids.len(), "{said}");
    }
    let cooked = |id: u32| record(ByteOrder::Little, 1, 0, &sll(1, 12, &classic(id, &[5])));
    let said = read(&[legacy(ByteOrder::Little, false, 113), [0x701, 0x181, 0x601].map(cooked).concat()].concat());
    assert_eq!(said.matches("Identifier").count(), 3, "{said}");
}

#[test]
fn packets_that_hold_no_identifiers() {
    let file: Vec<u8> =
        (0..100u32).flat_map(|no| record(ByteOrder::Little, 0, no, &classic(0x1234_5678 + no, &[1]))).collect();
    let head = legacy(ByteOrder::Little, false, 227);
    assert_eq!(read(&[head, file].concat()), "identifiers: implausible\n100 x CAN_SOCKETCAN (227)\n");
}

#[test]
fn memory_stays_bounded() {
    let held = |reader: &Pcap| {
        let trial = reader.trial.as_ref().map_or(0, |trial| trial.head.capacity() + trial.records.held.capacity());
        reader.records.held.capacity() + trial
    };
    let order = ByteOrder::Little;
    // A claimed length with nothing but zeros after it.
    let claims = |kind: u32, len: u32| [shb(order), four(order, kind).to_vec(), four(order, len).to_vec()].concat();
    for (file, most) in [
        (claims(6, 15 << 20), 40 << 20),
        (claims(6, 5), 300_000),
        ([legacy(order, false, 1), four(order, 0).repeat(2), four(order, 262_144).repeat(2)].concat(), 600_000),
    ] {
        let mut reader = Pcap::default();
        let mut buses = Buses::default();
        reader.feed(&file, &mut buses, &mut |_, _| {});
        assert!(held(&reader) < 1024);
        for _ in 0..most / 200_000 {
            reader.feed(&[0; 100_000], &mut buses, &mut |_, _| {});
            assert!(held(&reader) <= 2 * most);
        }
    }
    let mut reader = Pcap::default();
    let many: Vec<u8> = (0..70u32).flat_map(|kind| made::block(ByteOrder::Little, 0x100 + kind, &[])).collect();
    reader.feed(&[shb(ByteOrder::Little), many].concat(), &mut Buses::default(), &mut |_, _| {});
    let passed = reader.contents().passed_over;
    assert_eq!((passed.len(), passed.last().unwrap()), (64, &(b"...".to_vec(), 7)));
}

#[test]
fn what_is_broken_off_is_no_fault() {
    let file = made::sample(ByteOrder::Little);
    for cut in 0..file.bytes.len() {
        let mut reader = Pcap::default();
        let mut count = 0;
        let mut sink = |item: Item, _: &Buses| count += usize::from(matches!(item, Item::Damaged(_)));
        let mut buses = Buses::default();
        reader.feed(&file.bytes[..cut], &mut buses, &mut sink);
        reader.interrupt(&mut buses, &mut sink);
        reader.finish(&mut buses, &mut sink);
        assert_eq!(count, 0, "{cut}");
    }
}

fn frames() -> impl Strategy<Value = (Frame, usize, Option<u64>)> {
    let id = prop_oneof![(0u16..0x800).prop_map(CanId::standard), (0u32..0x2000_0000).prop_map(CanId::extended)];
    let kind = prop_oneof![
        Just(Kind::Data),
        Just(Kind::Remote),
        Just(Kind::Error),
        any::<(bool, bool)>().prop_map(|(brs, esi)| Kind::Fd { brs, esi }),
    ];
    let dir = prop::sample::select(&[None, Some(Direction::Rx), Some(Direction::Tx)][..]);
    let data = prop::collection::vec(any::<u8>(), 64);
    let raw_dlc = prop_oneof![Just(0u8), 9u8..16];
    (id, kind, dir, 0usize..65, data, (raw_dlc, 0..i64::MAX, 0usize..3, prop::option::weighted(0.2, 1u64..99)))
        .prop_map(|(id, kind, dir, len, bytes, (raw_dlc, t_ns, bus, lost))| {
            let most = if matches!(kind, Kind::Fd { .. }) { 64 } else { 8 };
            let len = len.min(most);
            let id = if kind == Kind::Error { CanId::extended(id.raw()) } else { id };
            let mut frame = Frame { kind, dir, t_ns: Some(Ns(t_ns)), len: len as u8, ..Frame::classic(id, &[]) };
            if kind != Kind::Remote {
                frame.data[..len].copy_from_slice(&bytes[..len]);
            }
            if len == 8 && matches!(kind, Kind::Data | Kind::Remote) {
                frame.length_form.raw_dlc = raw_dlc;
            }
            (frame, bus, lost)
        })
}

proptest! {
    #[test]
    fn what_is_written_is_read_again(frames in prop::collection::vec(frames(), 0..20), cuts in prop::collection::vec(1usize..90, 0..20)) {
        let names = [&b"can0"[..], b"vcan7", b"a-rather-long-name-of-a-bus"];
        let (mut buses, mut writer, mut out, mut expected) = (Buses::default(), Pcapng::default(), Vec::new(), String::new());
        let mut totals = [0; 3];
        for (frame, bus, lost) in frames {
            let mut frame = Frame { bus: buses.intern(names[bus]), ..frame };
            if let Some(count) = lost {
                totals[bus] += count;
                let marker = Marker::Dropped { bus: frame.bus, count, total: totals[bus], place: FilePlace::Byte(0) };
                writer.marker(&mut out, CaptureFacts { buses: &buses, date_ns: None }, &marker);
                writeln!(expected, "lost {count} {} {:?}", totals[bus], frame.bus).unwrap();
            }
            writer.frame(&mut out, CaptureFacts { buses: &buses, date_ns: None }, &frame);
            frame.stamp = frame.t_ns.map(|ns| crate::bytes::frame::Stamp { form: crate::bytes::frame::StampForm::Seconds, ns, width: 1, decimals: 9 });
            writeln!(expected, "{}", shown(&frame, &buses)).unwrap();
        }
        writer.finish(&mut out);
        prop_assert_eq!(writer.losses.iter().count(), 0);
        let mut got = String::new();
        let (mut reader, mut again) = (Pcap::default(), Buses::default());
        let mut sink = |item: Item, buses: &Buses| match item {
            Item::Frame(frame) => writeln!(got, "{}", shown(&frame, buses)).unwrap(),
            Item::Marker(Marker::Dropped { bus, count, total, .. }) => writeln!(got, "lost {count} {total} {bus:?}").unwrap(),
            other => panic!("{other:?}"),
        };
        reader.feed(&out, &mut again, &mut sink);
        reader.finish(&mut again, &mut sink);
        prop_assert_eq!(got, expected);
        prop_assert_eq!(items(&out, &[]), items(&out, &cuts));
    }

    #[test]
    fn any_bytes_are_survived(
        bytes in prop::collection::vec(any::<u8>(), 0..400),
        head in 0usize..7,
        cuts in prop::collection::vec(0usize..50, 0..20),
    ) {
        let head = match head {
            0 => shb(ByteOrder::Little),
            1 => shb(ByteOrder::Big),
            2 => legacy(ByteOrder::Little, true, 227),
            3 => legacy(ByteOrder::Big, false, 276),
            4 => made::sample(ByteOrder::Big).bytes,
            5 => made::sample(ByteOrder::Little).bytes,
            _ => Vec::new(),
        };
        let bytes = [head, bytes].concat();
        let whole = items(&bytes, &[]);
        prop_assert_eq!(&whole, &items(&bytes, &cuts));
        prop_assert_eq!(&whole, &items(&bytes, &vec![1; bytes.len()]));
    }

    // The library reads the same packets from valid files.
    #[test]
    fn packets_are_those_of_the_library(count in 1usize..20, big in any::<bool>(), sizes in prop::collection::vec(0usize..90, 20)) {
        let order = ORDERS[usize::from(big)];
        let mut file = [shb(order), idb(order, 9999, 0, &[])].concat();
        for size in &sizes[..count] {
            file.extend(epb(order, 0, 5, &vec![7; *size], &option(order, 1, &vec![b'x'; *size])));
        }
        let mut rest = &file[..];
        let mut packets = 0;
        while !rest.is_empty() {
            let parsed = if big { pcap_parser::parse_block_be(rest) } else { pcap_parser::parse_block_le(rest) };
            let (after, block) = parsed.unwrap();
            packets += u64::from(block.is_data_block());
            rest = after;
        }
        let text = read(&file);
        prop_assert_eq!(text, format!("{packets} x LINKTYPE (9999)\n"));
    }
}

#[test]
fn what_pcapng_cannot_hold() {
    let mut writer = Pcapng::default();
    let mut buses = Buses::default();
    let bus = buses.intern(b"");
    let mut out = Vec::new();
    let setting = CaptureFacts { buses: &buses, date_ns: None };
    let frame = Frame { bus, ..Frame::classic(CanId::standard(1), &[]) };
    writer.frame(&mut out, setting, &frame);
    writer.frame(&mut out, setting, &frame);
    writer.frame(&mut out, setting, &Frame { t_ns: Some(Ns(-1)), ..frame });
    writer.frame(
        &mut out,
        CaptureFacts { date_ns: Some(Ns(1_000_000_000)), ..setting },
        &Frame { t_ns: Some(Ns(1)), ..frame },
    );
    writer.marker(&mut out, setting, &Marker::Error { bus, stamp: None, place: FilePlace::Line(1) });
    writer.marker(&mut out, setting, &Marker::Start { date_ns: Ns(5) });
    writer.marker(&mut out, setting, &Marker::Dropped { bus, count: 4, total: 9, place: FilePlace::Line(1) });
    writer.finish(&mut out);
    let losses: Vec<_> = writer.losses.iter().collect();
    assert_eq!(losses, [(Loss::StampDigits, 1), (Loss::NoStamp, 2), (Loss::ErrorFrame, 1)]);
    let text = read(&out);
    let (frames, marker) = text.split_at(text.find("Dropped").unwrap());
    assert_eq!(frames, "0/9 can0 001 0\n1000000/9 can0 001 0\n0/9 can0 001 0\n1000000001/9 can0 001 0\n");
    assert!(marker.starts_with("Dropped { bus: BusId(0), count: 4, total: 4,"), "{marker}");
    let mut empty = Vec::new();
    Pcapng::default().finish(&mut empty);
    assert_eq!(read(&empty), "");
    assert_eq!(crate::bytes::readers::sniff::sniff(&empty, true), Some("pcapng"));
}

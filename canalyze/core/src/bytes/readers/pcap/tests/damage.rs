//! Damaged files: complete parts are read, and each damage is reported once.

use super::made::{block, classic, four, legacy, record, sample};
use super::{ByteOrder, ORDERS, items, read};

/// Returns the number of frames, and the lines about damage.
fn counted(text: &str) -> (usize, Vec<&str>) {
    let damage = |line: &&str| line.starts_with("Byte(");
    (
        text.lines().filter(|line| line.contains(" can")).filter(|line| line.contains("/6 ")).count(),
        text.lines().filter(damage).collect(),
    )
}

#[test]
fn cut_at_every_byte() {
    for order in ORDERS {
        let file = sample(order);
        for cut in 0..file.bytes.len() {
            let text = read(&file.bytes[..cut]);
            let begun = file.starts.iter().take_while(|start| **start < cut).count();
            let whole = if file.starts.contains(&cut) { begun } else { begun.saturating_sub(1) };
            let expected = match file.starts.contains(&cut) {
                true => vec![],
                false => {
                    let start = file.starts[begun - 1];
                    vec![format!("Byte({start}) Cut {}", cut - start)]
                }
            };
            let (frames, damage) = counted(&text);
            assert_eq!(
                (frames, damage),
                (whole.saturating_sub(3), expected.iter().map(|line| &**line).collect()),
                "{cut}"
            );
        }
    }
}

#[test]
fn pcap_cut_at_every_byte() {
    for order in ORDERS {
        let file =
            [legacy(order, false, 227), record(order, 1, 2, &classic(1, &[])), record(order, 1, 2, &classic(2, &[]))]
                .concat();
        for cut in 0..file.len() {
            let (start, frames) = match cut {
                0..24 => (0, 0),
                24..56 => (24, 0),
                _ => (56, 1),
            };
            let damage = if cut == start { vec![] } else { vec![format!("Byte({start}) Cut {}", cut - start)] };
            let text = read(&file[..cut]);
            assert_eq!(counted(&text), (frames, damage.iter().map(|line| &**line).collect()), "{cut}");
        }
    }
}

#[test]
fn a_bad_length_costs_its_block() {
    for order in ORDERS {
        let file = sample(order);
        // The block of a frame, at either end; the description of an interface.
        for (no, gone) in [(3, 1), (5, 1), (8, 1), (1, 3), (2, 3)] {
            let start = file.starts[no];
            let end = file.starts.get(no + 1).copied().unwrap_or(file.bytes.len());
            for place in [start + 4, end - 4] {
                for length in [0, 4, 11, 13, 28, 60, 96, 4096, 1 << 24, 1 << 30, u32::MAX] {
                    let mut bytes = file.bytes.clone();
                    bytes[place..place + 4].copy_from_slice(&four(order, length));
                    if bytes == file.bytes {
                        continue;
                    }
                    let text = read(&bytes);
                    let lost = if no == 8 {
                        if place == start + 4 && (length as usize) > end - start && length <= 1 << 24 {
                            "Cut"
                        } else {
                            "Rest"
                        }
                    } else {
                        "Structure"
                    };
                    let told = format!("Byte({start}) {lost} {}", end - start);
                    let (frames, damage) = counted(&text);
                    if no < 3 {
                        // Its frames now have no interface.
                        assert_eq!((frames, damage[0]), (6 - gone, &*told), "{no} {length} {text}");
                    } else {
                        assert_eq!((frames, damage), (6 - gone, vec![&*told]), "{no} {length} {text}");
                    }
                }
            }
        }
    }
}

#[test]
fn every_flipped_bit_is_survived() {
    for order in ORDERS {
        let file = sample(order);
        let whole = read(&file.bytes);
        for bit in 0..file.bytes.len() * 8 {
            let mut bytes = file.bytes.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            let text = items(&bytes, &[]);
            assert_eq!(text, items(&bytes, &[bit / 8]));
            let no = file.starts.iter().filter(|start| **start * 8 <= bit).count() - 1;
            if no >= 3 {
                // The frames of all other blocks are unchanged.
                let missing = whole.lines().filter(|line| !text.contains(*line)).count();
                assert!(missing <= 1, "{bit} {text}");
                assert!(counted(&text).1.len() <= 1, "{bit} {text}");
            }
        }
    }
}

#[test]
fn what_follows_lost_bytes_is_found() {
    for order in ORDERS {
        let file = sample(order);
        for lost in [1, 3, 4, 40, 70] {
            let mut bytes = file.bytes.clone();
            bytes.drain(file.starts[4] + 8..file.starts[4] + 8 + lost);
            let text = read(&bytes);
            let (frames, damage) = counted(&text);
            assert_eq!((frames, damage.len()), (if lost <= 40 { 5 } else { 4 }, 1), "{lost}");
        }
        // Zeros at the end, as left by a file system.
        let bytes = [&file.bytes[..], &[0; 100]].concat();
        assert_eq!(counted(&read(&bytes)), (6, vec![&*format!("Byte({}) Rest 100", file.bytes.len())]));
        // A packet longer than its block.
        let head = [0, 0, 9, 17, 17].map(|word| four(order, word)).concat();
        let bad = block(order, 6, &[head, classic(1, &[])].concat());
        let bytes = [&file.bytes[..], &bad, &sample(order).bytes].concat();
        assert_eq!(counted(&read(&bytes)), (12, vec![&*format!("Byte({}) Structure 48", file.bytes.len())]));
    }
}

#[test]
fn a_pcap_file_ends_where_a_length_cannot_be() {
    for order in ORDERS {
        let packet = record(order, 1, 2, &classic(1, &[]));
        for (place, length) in [(8, 17), (8, 0x4000_0000), (12, 15)] {
            let mut bad = packet.clone();
            bad[place..place + 4].copy_from_slice(&four(order, length));
            let file = [legacy(order, false, 227), packet.clone(), bad, packet.clone()].concat();
            assert_eq!(counted(&read(&file)), (1, vec!["Byte(56) Rest 64"]));
        }
    }
}

#[test]
fn what_is_no_capture() {
    assert_eq!(read(b""), "");
    assert_eq!(read(b"\n\r"), "Byte(0) Cut 2\n");
    assert_eq!(read(b"\n\r\r\n(1.5) can0 601#40\n"), "Byte(0) Rest 22\n");
    assert_eq!(read(b"(1.5) can0 601#40 can0 601#40\n"), "Byte(0) Rest 30\n");
    assert_eq!(read(&[b"\n\r\r\n............", &sample(ByteOrder::Big).bytes[..]].concat()).lines().count(), 7);
}

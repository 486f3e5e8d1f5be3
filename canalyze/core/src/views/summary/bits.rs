//! The number of bits of a frame on the wire.
//!
//! It is exact for a classic frame: SOF to CRC with the stuff bits of its identifier, length, data and CRC-15 (computed
//! here), then delimiters, acknowledgement, EOF and the three bits between frames (ISO 11898-1, 10.4 and 10.5).
//! Reserved bits count as 0. A CAN FD frame without bit rate switch is counted likewise, with the fixed stuff bits of
//! its CRC; of one with bit rate switch only the part at the nominal rate is counted, since the capture does not
//! contain the other rate. The bits of an error frame are unknown and not counted.

use crate::bytes::frame::{Frame, Kind};

/// Generator polynomial of the CRC-15 of classic frames, without its highest term.
const POLYNOMIAL: u16 = 0x4599;
/// Number of bytes that are processed at once.
const BYTES: usize = 4;
/// Contribution of a byte to the CRC, by the number of bytes behind it. The CRC is the sum of the contributions of its
/// bytes, so bytes that are processed at once do not wait for one another.
static CRC15: [[u16; 256]; BYTES] = crc15();

#[allow(clippy::indexing_slicing, reason = "evaluated by the compiler, which refuses what is out of bounds")]
const fn crc15() -> [[u16; 256]; BYTES] {
    let mut table = [[0; 256]; BYTES];
    let mut byte = 0;
    while byte < 256 {
        let (mut crc, mut behind) = ((byte as u16) << 7, 0);
        while behind < BYTES {
            let mut bit = 0;
            while bit < 8 {
                crc = if crc & 0x4000 == 0 { crc << 1 } else { crc << 1 ^ POLYNOMIAL };
                bit += 1;
            }
            crc &= 0x7FFF;
            table[behind][byte] = crc;
            behind += 1;
        }
        byte += 1;
    }
    table
}

/// Returns the CRC of a row of bits that ends with the lowest one. Leading zeros do not change it, since it begins with
/// 0.
fn crc(row: u128) -> u16 {
    let bytes = row.to_be_bytes();
    let (words, _) = bytes.as_chunks::<BYTES>();
    words.iter().fold(0, |crc, word| {
        let word = u32::from_be_bytes(*word) ^ u32::from(crc) << 17;
        let adds = CRC15.iter().zip(word.to_le_bytes());
        adds.fold(0, |crc, (table, byte)| crc ^ table.get(usize::from(byte)).copied().unwrap_or(0))
    })
}

/// CRC delimiter, acknowledgement slot and delimiter, end of frame (7), intermission (3).
const TAIL: u32 = 1 + 2 + 7 + 3;

/// States of the stuffing: none, then runs of 1..=4 zeros, then runs of 1..=4 ones. A fifth bit is followed by its
/// complement, which begins a run of its own.
const STATES: usize = 9;
/// The state (high byte) and the stuff bits inserted (low byte) after a state and eight more bits; the index is both in
/// a row. The table has more entries than states, so that no index has to be checked.
static STEPS: [u16; 0x1000] = steps();

#[allow(clippy::indexing_slicing, reason = "evaluated by the compiler, which refuses what is out of bounds")]
const fn steps() -> [u16; 0x1000] {
    let mut table = [0; 0x1000];
    let mut place = 0;
    while place < STATES << 8 {
        let (mut now, mut stuffed, mut bit) = ((place >> 8) as u8, 0, 8);
        while bit > 0 {
            bit -= 1;
            let one = place >> bit & 1 == 1;
            (now, stuffed) = match next(now, one) {
                0 => (if one { 1 } else { 5 }, stuffed + 1),
                state => (state, stuffed),
            };
        }
        table[place] = (now as u16) << 8 | stuffed;
        place += 1;
    }
    table
}

/// Returns the state after one more bit; 0 if it is the fifth of its kind.
const fn next(state: u8, one: bool) -> u8 {
    match (state, one) {
        (1..=3, false) | (5..=7, true) => state + 1,
        (4, false) | (8, true) => 0,
        (_, false) => 1,
        (_, true) => 5,
    }
}

/// Alternating bits. They need no stuff bit and do not change those of a row that begins with SOF behind them, so they
/// fill its first byte.
const FILL: u128 = u128::MAX / 3;

/// Counts the stuff bits of a row of `bits` bits, which ends with the lowest one, and of whole bytes behind it.
fn stuff_bits(row: u128, bits: u32, behind: &[u8]) -> u32 {
    let filled = (FILL << bits | row).to_be_bytes();
    let row = filled.get(16 - bits.div_ceil(8) as usize..).unwrap_or(&filled);
    let follow = |(step, stuffed): (u16, u32), byte: &u8| {
        let step = STEPS.get(usize::from(step & 0xF00 | u16::from(*byte))).copied().unwrap_or(0);
        (step, stuffed + u32::from(step as u8))
    };
    behind.iter().fold(row.iter().fold((0, 0), follow), follow).1
}

/// Returns the number of bits of a frame on the wire, at the nominal rate, with the intermission after it.
pub fn on_the_wire(frame: &Frame) -> u32 {
    match frame.kind {
        Kind::Error => 0,
        Kind::Data | Kind::Remote => classic(frame),
        Kind::Fd { brs, esi } => fd(frame, brs, esi),
    }
}

/// Returns SOF, identifier and the bits up to IDE or, in an extended frame, up to RTR: their value and their number.
fn arbitration(frame: &Frame, remote: bool) -> (u64, u32) {
    let raw = u64::from(frame.id.raw());
    if frame.id.is_extended() {
        // SOF, 11 bits, SRR = 1, IDE = 1, 18 bits, RTR.
        ((raw >> 18 << 2 | 3) << 19 | (raw & 0x3_FFFF) << 1 | u64::from(remote), 33)
    } else {
        // SOF, 11 bits, RTR, IDE = 0.
        (raw << 2 | u64::from(remote) << 1, 14)
    }
}

fn classic(frame: &Frame) -> u32 {
    let remote = frame.kind == Kind::Remote;
    let raw_dlc = frame.length_form.raw_dlc;
    let dlc = u64::from(if raw_dlc > 8 { raw_dlc.min(15) } else { frame.len.min(8) });
    let (value, count) = arbitration(frame, remote);
    // r0, or r1 and r0, then the DLC.
    let reserved = if frame.id.is_extended() { 2 } else { 1 };
    let (header, count) = (value << (reserved + 4) | dlc, count + reserved + 4);
    let data_bits = if remote { 0 } else { 8 * u32::from(frame.len.min(8)) };
    let data = u64::from_be_bytes(frame.head());
    let row = (u128::from(header) << 64 | u128::from(data)) >> (64 - data_bits);
    let (row, bits) = (row << 15 | u128::from(crc(row)), count + data_bits + 15);
    bits + stuff_bits(row, bits, &[]) + TAIL
}

fn fd(frame: &Frame, brs: bool, esi: bool) -> u32 {
    let (value, count) = arbitration(frame, false);
    // FDF = 1, res = 0, BRS.
    let (header, count) = (u128::from(value << 3 | 0b100 | u64::from(brs)), count + 3);
    if brs {
        return count + stuff_bits(header, count, &[]) + TAIL;
    }
    let (header, count) = (header << 5 | u128::from(u64::from(esi) << 4 | fd_dlc(frame.len)), count + 5);
    let data = frame.payload();
    let stuffed = stuff_bits(header, count, data);
    // Stuff count and parity (4), CRC-17 or CRC-21, and a fixed stuff bit before them and after every four bits.
    let check = if frame.len <= 16 { 4 + 17 } else { 4 + 21 };
    count + 8 * data.len() as u32 + stuffed + check + 1 + check / 4 + TAIL
}

/// Returns the DLC of a number of bytes.
fn fd_dlc(len: u8) -> u64 {
    match len {
        0..=8 => u64::from(len),
        9..=12 => 9,
        13..=16 => 10,
        17..=20 => 11,
        21..=24 => 12,
        25..=32 => 13,
        33..=48 => 14,
        _ => 15,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;
    use crate::bytes::frame::CanId;

    /// Computes it bit by bit, as in the standard.
    fn slowly(frame: &Frame) -> u32 {
        let raw = frame.id.raw();
        let mut bits: Vec<bool> = vec![false];
        let mut put = |value: u32, count: u32| (0..count).rev().for_each(|bit| bits.push(value >> bit & 1 == 1));
        let remote = u32::from(frame.kind == Kind::Remote);
        if frame.id.is_extended() {
            put(raw >> 18, 11);
            put(3, 2);
            put(raw & 0x3_FFFF, 18);
            put(remote, 1);
            put(0, 2);
        } else {
            put(raw, 11);
            put(remote, 1);
            put(0, 2);
        }
        put(u32::from(frame.len), 4);
        for byte in frame.payload() {
            put(u32::from(*byte), 8);
        }
        let mut crc = 0u32;
        for bit in &bits {
            let invert = *bit != (crc >> 14 & 1 == 1);
            crc = crc << 1 & 0x7FFF;
            if invert {
                crc ^= 0x4599;
            }
        }
        (0..15).rev().for_each(|bit| bits.push(crc >> bit & 1 == 1));
        let (mut run, mut last, mut total) = (0, None, 0);
        for bit in bits {
            run = if last == Some(bit) { run + 1 } else { 1 };
            (last, total) = (Some(bit), total + 1);
            if run == 5 {
                (run, last, total) = (1, Some(!bit), total + 1);
            }
        }
        total + TAIL
    }

    #[test]
    fn as_the_standard_counts() {
        let mut seed = 301u64;
        let mut random = move || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            seed >> 33
        };
        let mut stuffed = 0;
        for turn in 0..20_000 {
            let len = random() as usize % 9;
            // Few different bytes, so that runs are frequent.
            let payload: Vec<u8> =
                (0..len).map(|_| [0, 0xFF, 0x0F, 0xE0, random() as u8][random() as usize % 5]).collect();
            let id = if turn % 2 == 0 { CanId::standard(random() as u16) } else { CanId::extended(random() as u32) };
            let mut frame = Frame::classic(id, &payload);
            if turn % 7 == 0 {
                frame.kind = Kind::Remote;
            }
            assert_eq!(on_the_wire(&frame), slowly(&frame), "{frame:?}");
            stuffed += on_the_wire(&frame);
        }
        assert!(stuffed > 0);
    }

    #[test]
    fn lengths_that_are_known() {
        // No data: 34 bits stuffed, 13 more.
        let least = on_the_wire(&Frame::classic(CanId::standard(0x555), &[]));
        assert!((47..=52).contains(&least), "{least}");
        // Consecutive zeros; the bound is 98 + 24 + 13.
        let most = on_the_wire(&Frame::classic(CanId::standard(0), &[0; 8]));
        assert!((120..=135).contains(&most), "{most}");
        let mut fd = Frame::classic(CanId::standard(0x555), &[0x55; 8]);
        fd.kind = Kind::Fd { brs: false, esi: false };
        // 17 + 5 + 64 with hardly a stuff bit, 21 + 6 of the CRC, 13.
        assert!((126..=130).contains(&on_the_wire(&fd)), "{}", on_the_wire(&fd));
        fd.kind = Kind::Fd { brs: true, esi: false };
        assert!((30..=34).contains(&on_the_wire(&fd)), "{}", on_the_wire(&fd));
        fd.kind = Kind::Error;
        assert_eq!(on_the_wire(&fd), 0);
    }
}

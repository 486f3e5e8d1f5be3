//! How many bits a frame takes on the wire.
//!
//! Of a classic frame exactly: SOF to CRC with the stuff bits that its identifier, length, data and CRC-15 (computed
//! here) call for, then delimiters, acknowledgement, EOF and the three bits between frames (ISO 11898-1, 10.4 and
//! 10.5). Reserved bits are taken as 0. Of a CAN FD frame without bit rate switch likewise, with the fixed stuff bits
//! of its CRC; with bit rate switch only the part at the nominal rate is counted, since the capture does not tell the
//! other rate. An error frame in a capture stands for an unknown number of bits: none are counted.

use crate::frame::{Frame, Kind};

/// Generator polynomial of the CRC-15 of classic frames, without its highest term.
const POLYNOMIAL: u16 = 0x4599;
/// What eight bits do to the CRC; here and not by a library's digest, so that a byte goes through CRC and stuffing in
/// one turn.
static CRC15: [u16; 256] = crc15();

#[allow(clippy::indexing_slicing, reason = "evaluated by the compiler, which refuses what is out of bounds")]
const fn crc15() -> [u16; 256] {
    let mut table = [0; 256];
    let mut byte = 0;
    while byte < 256 {
        let (mut crc, mut bit) = ((byte as u16) << 7, 0);
        while bit < 8 {
            crc = if crc & 0x4000 == 0 { crc << 1 } else { crc << 1 ^ POLYNOMIAL };
            bit += 1;
        }
        table[byte] = crc & 0x7FFF;
        byte += 1;
    }
    table
}

fn crc_step(crc: u16, byte: u8) -> u16 {
    let place = usize::from((crc >> 7) as u8 ^ byte);
    (crc << 8 ^ CRC15.get(place).copied().unwrap_or(0)) & 0x7FFF
}

/// CRC delimiter, acknowledgement slot and delimiter, end of frame (7), intermission (3).
const TAIL: u32 = 1 + 2 + 7 + 3;

/// States of the stuffing: none, then runs of 1..=4 zeros, then runs of 1..=4 ones. A fifth bit is followed by its
/// complement, which begins a run of its own.
const STATES: usize = 9;
/// Their rows in the table, with some to spare: each value of the low nibble has one.
const ROWS: usize = 16;

/// After a state and eight more bits: the stuff bits inserted (high nibble) and the state (low nibble).
static STEPS: [[u8; 256]; ROWS] = steps();

#[allow(clippy::indexing_slicing, reason = "evaluated by the compiler, which refuses what is out of bounds")]
const fn steps() -> [[u8; 256]; ROWS] {
    let mut table = [[0; 256]; ROWS];
    let mut state = 0;
    while state < STATES {
        let mut byte = 0;
        while byte < 256 {
            let (mut now, mut stuffed, mut bit) = (state as u8, 0u8, 8);
            while bit > 0 {
                bit -= 1;
                let one = byte >> bit & 1 == 1;
                (now, stuffed) = match next(now, one) {
                    0 => (if one { 1 } else { 5 }, stuffed + 1),
                    state => (state, stuffed),
                };
            }
            table[state][byte] = stuffed << 4 | now;
            byte += 1;
        }
        state += 1;
    }
    table
}

/// The state after one more bit; 0 where it is the fifth of its kind.
const fn next(state: u8, one: bool) -> u8 {
    match (state, one) {
        (1..=3, false) | (5..=7, true) => state + 1,
        (4, false) | (8, true) => 0,
        (_, false) => 1,
        (_, true) => 5,
    }
}

/// A row of bits, counted with their stuff bits.
#[derive(Default)]
struct Stuffed {
    bits: u32,
    state: u8,
    /// Bits that do not fill a byte yet.
    rest: u64,
    waiting: u32,
    last: u64,
}

impl Stuffed {
    /// The lowest `count` bits of a value, at most 40, highest first.
    fn push(&mut self, value: u64, count: u32) {
        self.rest = self.rest << count | value;
        self.waiting += count;
        self.bits += count;
        self.last = value & 1;
        while self.waiting >= 8 {
            self.waiting -= 8;
            self.byte((self.rest >> self.waiting) as u8);
        }
        self.rest &= 0xFF;
    }

    /// Eight bits: the row stays as far from the end of a byte as it is.
    fn octet(&mut self, byte: u8) {
        self.rest = self.rest << 8 | u64::from(byte);
        self.bits += 8;
        self.last = u64::from(byte & 1);
        self.byte((self.rest >> self.waiting) as u8);
        self.rest &= 0xFF;
    }

    fn byte(&mut self, byte: u8) {
        let row = STEPS.get(usize::from(self.state & 0xF));
        let step = row.and_then(|row| row.get(usize::from(byte))).copied().unwrap_or(0);
        self.bits += u32::from(step >> 4);
        self.state = step & 0xF;
    }

    /// All bits; the last byte is filled with changing bits, which call for no stuff bit.
    fn total(mut self) -> u32 {
        if self.waiting > 0 {
            let open = 8 - self.waiting;
            // The first of them is unlike the last bit of the row.
            let changing = (if self.last == 0 { 0xAA } else { 0x55 }) >> self.waiting;
            self.byte((self.rest << open | changing) as u8);
        }
        self.bits
    }
}

/// Bits of a frame on the wire, at the nominal rate, with the intermission after it.
pub fn on_the_wire(frame: &Frame) -> u32 {
    match frame.kind {
        Kind::Error => 0,
        Kind::Data | Kind::Remote => classic(frame),
        Kind::Fd { brs, esi } => fd(frame, brs, esi),
    }
}

/// SOF, identifier and the bits up to IDE or, in an extended frame, up to RTR: their value and their number.
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
    let data = frame.payload().get(..usize::from(frame.len.min(8))).unwrap_or(&[]);
    // Leading zeros change nothing in a CRC that begins with 0.
    let [_, _, _, a, b, c, d, e] = header.to_be_bytes();
    let mut crc = [a, b, c, d, e].into_iter().fold(0, crc_step);
    let mut row = Stuffed::default();
    row.push(header, count);
    for byte in data {
        crc = crc_step(crc, *byte);
        row.octet(*byte);
    }
    row.push(u64::from(crc), 15);
    row.total() + TAIL
}

fn fd(frame: &Frame, brs: bool, esi: bool) -> u32 {
    let (value, count) = arbitration(frame, false);
    let mut row = Stuffed::default();
    // FDF = 1, res = 0, BRS.
    row.push(value << 3 | 0b100 | u64::from(brs), count + 3);
    if brs {
        return row.total() + TAIL;
    }
    row.push(u64::from(esi) << 4 | fd_dlc(frame.len), 5);
    for byte in frame.payload() {
        row.octet(*byte);
    }
    // Stuff count and parity (4), CRC-17 or CRC-21, and a fixed stuff bit before them and after every four bits.
    let check = if frame.len <= 16 { 4 + 17 } else { 4 + 21 };
    row.total() + check + 1 + check / 4 + TAIL
}

/// The DLC of so many bytes.
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
    use crate::frame::CanId;

    /// Bit by bit, as the standard says it.
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
            // Bytes of few kinds, so that runs are frequent.
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
        // Zeros after each other; the bound is 98 + 24 + 13.
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

//! Values in the wire format of ROS 2: CDR (XCDR1), little-endian. A value is aligned to its own size, counted from the
//! end of the four-byte encapsulation.
//!
//! The caller writes the fields of a message in the order of its definition.

use std::ops::Range;

/// The encapsulation header: plain CDR, little-endian, no options.
const HEAD: [u8; 4] = [0, 1, 0, 0];

/// One message.
#[derive(Debug, Default)]
pub(super) struct Cdr {
    bytes: Vec<u8>,
}

impl Cdr {
    /// Begins a message, dropping the previous one.
    pub(super) fn begin(&mut self) -> &mut Self {
        self.bytes.clear();
        self.bytes.extend_from_slice(&HEAD);
        self
    }

    /// Returns the message.
    pub(super) fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    fn align(&mut self, to: usize) {
        while !(self.bytes.len() - HEAD.len().min(self.bytes.len())).is_multiple_of(to) {
            self.bytes.push(0);
        }
    }

    /// Appends the low 1, 2, 4 or 8 bytes of `number`.
    pub(super) fn number(&mut self, number: u64, size: usize) -> &mut Self {
        self.align(size);
        let bytes = number.to_le_bytes();
        self.bytes.extend_from_slice(bytes.get(..size).unwrap_or(&bytes));
        self
    }

    /// Appends a `bool`.
    pub(super) fn bool(&mut self, yes: bool) -> &mut Self {
        self.u8(u8::from(yes))
    }

    /// Appends a `uint8`.
    pub(super) fn u8(&mut self, number: u8) -> &mut Self {
        self.bytes.push(number);
        self
    }

    /// Appends a `uint16`.
    pub(super) fn u16(&mut self, number: u16) -> &mut Self {
        self.number(u64::from(number), 2)
    }

    /// Appends a `uint32`.
    pub(super) fn u32(&mut self, number: u32) -> &mut Self {
        self.number(u64::from(number), 4)
    }

    /// Appends a `uint64`.
    pub(super) fn u64(&mut self, number: u64) -> &mut Self {
        self.number(number, 8)
    }

    /// Appends a `float64`.
    pub(super) fn f64(&mut self, number: f64) -> &mut Self {
        self.number(number.to_bits(), 8)
    }

    /// Appends a `string`: its length including the final NUL, its bytes, NUL. Invalid UTF-8 becomes U+FFFD.
    pub(super) fn string(&mut self, text: &[u8]) -> &mut Self {
        let count = self.open();
        for chunk in text.utf8_chunks() {
            self.bytes.extend_from_slice(chunk.valid().as_bytes());
            if !chunk.invalid().is_empty() {
                self.bytes.extend_from_slice("\u{FFFD}".as_bytes());
            }
        }
        self.bytes.push(0);
        self.close(count);
        self
    }

    /// Appends a `uint8[]`: its length, its bytes.
    pub(super) fn sequence(&mut self, bytes: &[u8]) -> &mut Self {
        self.u32(bytes.len() as u32);
        self.array(bytes)
    }

    /// Appends a `uint8[N]`.
    pub(super) fn array(&mut self, bytes: &[u8]) -> &mut Self {
        self.bytes.extend_from_slice(bytes);
        self
    }

    /// Appends a `builtin_interfaces/Time` for a time in ns; see [`stamp`].
    pub(super) fn time(&mut self, time: u64) -> &mut Self {
        let (seconds, nanoseconds) = stamp(time);
        self.u32(seconds).u32(nanoseconds)
    }

    /// Appends a `std_msgs/Header`.
    pub(super) fn header(&mut self, time: u64, frame_id: &[u8]) -> &mut Self {
        self.time(time).string(frame_id)
    }

    /// Appends a placeholder for a length.
    fn open(&mut self) -> Range<usize> {
        self.u32(0);
        self.bytes.len() - 4..self.bytes.len()
    }

    fn close(&mut self, count: Range<usize>) {
        let length = (self.bytes.len() - count.end) as u32;
        if let Some(slot) = self.bytes.get_mut(count) {
            slot.copy_from_slice(&length.to_le_bytes());
        }
    }
}

/// Returns seconds and nanoseconds of a time. `int32` seconds end in 2038: later times become 0 for unknown; the log
/// time of the message still has them.
fn stamp(time: u64) -> (u32, u32) {
    match i32::try_from(time / 1_000_000_000) {
        Ok(seconds) => (seconds.unsigned_abs(), (time % 1_000_000_000) as u32),
        Err(_) => (0, 0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_at_a_multiple_of_its_size() {
        let mut cdr = Cdr::default();
        cdr.begin().u8(1).u16(0x0203).bool(true).u32(0x0405_0607).u8(8).u64(9).string(b"ab").f64(1.0);
        #[rustfmt::skip]
        let expected = [
            0, 1, 0, 0,
            1, 0, 3, 2, 1, 0, 0, 0, 7, 6, 5, 4, 8, 0, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0,
            3, 0, 0, 0, b'a', b'b', 0, 0, 0, 0, 0, 0, 0, 0, 0xF0, 0x3F,
        ];
        assert_eq!(cdr.bytes(), expected);
    }

    #[test]
    fn strings_and_sequences() {
        let mut cdr = Cdr::default();
        assert_eq!(cdr.begin().string(b"").bytes(), [0, 1, 0, 0, 1, 0, 0, 0, 0]);
        assert_eq!(cdr.begin().sequence(&[7, 8]).bytes(), [0, 1, 0, 0, 2, 0, 0, 0, 7, 8]);
        assert_eq!(cdr.begin().array(&[7, 8]).bytes(), [0, 1, 0, 0, 7, 8]);
        assert_eq!(cdr.begin().string(b"a\xFF").bytes(), [0, 1, 0, 0, 5, 0, 0, 0, b'a', 0xEF, 0xBF, 0xBD, 0]);
    }

    #[test]
    fn stamps() {
        assert_eq!(stamp(1_549_455_524_265_601_001), (1_549_455_524, 265_601_001));
        assert_eq!(stamp(2_147_483_647_999_999_999), (2_147_483_647, 999_999_999));
        assert_eq!(stamp(2_147_483_648_000_000_000), (0, 0));
        assert_eq!(stamp(u64::MAX), (0, 0));
    }
}

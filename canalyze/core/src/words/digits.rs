//! Numbers and words appended to a byte buffer without `format!`.
//!
//! PDO lines are nine tenths of a capture, and the formatting machinery costs more than their decoding. Only ASCII
//! digits and the program's own words are appended here; strings from a capture go through `escape`.

const DIGITS: &[u8; 16] = b"0123456789ABCDEF";
/// The least number of nine decimal digits.
const EIGHT: u64 = 100_000_000;

/// Something that can be appended to an output line.
pub trait Put {
    /// Appends itself.
    fn put(&self, out: &mut Vec<u8>);
}

impl Put for &str {
    fn put(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(self.as_bytes());
    }
}

impl Put for u8 {
    fn put(&self, out: &mut Vec<u8>) {
        decimal(out, u64::from(*self));
    }
}

impl Put for u16 {
    fn put(&self, out: &mut Vec<u8>) {
        decimal(out, u64::from(*self));
    }
}

impl Put for u32 {
    fn put(&self, out: &mut Vec<u8>) {
        decimal(out, u64::from(*self));
    }
}

impl Put for u64 {
    fn put(&self, out: &mut Vec<u8>) {
        decimal(out, *self);
    }
}

impl Put for usize {
    fn put(&self, out: &mut Vec<u8>) {
        decimal(out, *self as u64);
    }
}

impl Put for i64 {
    fn put(&self, out: &mut Vec<u8>) {
        signed(out, *self);
    }
}

/// A part that a function appends.
impl<F: Fn(&mut Vec<u8>)> Put for F {
    fn put(&self, out: &mut Vec<u8>) {
        self(out);
    }
}

/// A number in upper-case hexadecimal with a fixed count of digits; higher digits are cut off.
#[derive(Clone, Copy, Debug)]
pub struct Hex<const DIGITS: usize>(pub u64);

impl<const N: usize> Put for Hex<N> {
    fn put(&self, out: &mut Vec<u8>) {
        if N > 16 {
            return hex(out, self.0, N);
        }
        // In one piece, since nearly every line has some.
        let mut digits = [b'0'; N];
        for (position, slot) in digits.iter_mut().rev().enumerate() {
            *slot = digit((self.0 >> (4 * position)) as u8);
        }
        out.extend_from_slice(&digits);
    }
}

/// A number in binary with a fixed count of digits; higher digits are cut off.
#[derive(Clone, Copy, Debug)]
pub struct Bin<const DIGITS: usize>(pub u64);

impl<const N: usize> Put for Bin<N> {
    fn put(&self, out: &mut Vec<u8>) {
        binary(out, self.0, N);
    }
}

/// A byte in binary as the notes write it: two groups of four, `0001 1011b`.
#[derive(Clone, Copy, Debug)]
pub struct Nibbles(pub u8);

impl Put for Nibbles {
    fn put(&self, out: &mut Vec<u8>) {
        binary(out, u64::from(self.0 >> 4), 4);
        out.push(b' ');
        binary(out, u64::from(self.0), 4);
        out.push(b'b');
    }
}

/// A decimal number with leading zeros: `DIGITS` digits, or more when the number needs them.
#[derive(Clone, Copy, Debug)]
pub struct Padded<const DIGITS: usize>(pub u64);

impl<const N: usize> Put for Padded<N> {
    fn put(&self, out: &mut Vec<u8>) {
        filled(out, self.0, N, b'0');
    }
}

/// Bytes in hexadecimal, separated by blanks as in candump: `05 00 00`.
#[derive(Clone, Copy, Debug)]
pub struct Spaced<'a>(pub &'a [u8]);

impl Put for Spaced<'_> {
    fn put(&self, out: &mut Vec<u8>) {
        for (i, byte) in self.0.iter().enumerate() {
            if i > 0 {
                out.push(b' ');
            }
            hex_byte(out, *byte);
        }
    }
}

/// Bytes in hexadecimal without separators: `050000`.
#[derive(Clone, Copy, Debug)]
pub struct Joined<'a>(pub &'a [u8]);

impl Put for Joined<'_> {
    fn put(&self, out: &mut Vec<u8>) {
        for eight in self.0.chunks(8) {
            let mut digits = [0; 16];
            for (pair, byte) in digits.as_chunks_mut::<2>().0.iter_mut().zip(eight) {
                *pair = hex_digits(*byte);
            }
            put_beginning(out, &digits, 2 * eight.len());
        }
    }
}

/// Appends the first `len` bytes. A copy of constant length costs less than one of the right length.
#[inline]
pub fn put_beginning<const N: usize>(out: &mut Vec<u8>, bytes: &[u8; N], len: usize) {
    let end = out.len() + len;
    out.extend_from_slice(bytes);
    out.truncate(end);
}

/// Appends its arguments one after the other: `put!(out; "node ", node, ": ", Hex::<2>(state), "h")`.
macro_rules! put {
    ($out:expr; $($part:expr),+ $(,)?) => {{
        let out: &mut Vec<u8> = $out;
        $( $crate::words::digits::Put::put(&$part, out); )+
    }};
}
pub(crate) use put;

/// Texts that were appended before, each found by a number that decides it. The last one of each place is kept.
#[derive(Debug, Default)]
pub struct KnownTexts<const MOST: usize = 54> {
    texts: Vec<KnownText<MOST>>,
    /// Texts that were not kept, since memory for a few of them is not worth it.
    few: usize,
}

/// A text of up to `MOST` bytes; none has a length of 0. Aligned, so that it begins a line of the processor's cache.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct KnownText<const MOST: usize> {
    key: u64,
    bytes: [u8; MOST],
    len: u16,
}

impl<const MOST: usize> KnownTexts<MOST> {
    /// Number of places: most captures have fewer CAN-IDs.
    const PLACES: usize = 256;
    /// Number of texts from which on they are kept.
    const FEW: usize = 32;

    fn place(key: u64) -> usize {
        // Multiplied by 2^64 by the golden ratio, numbers that are close to each other have places of their own.
        (key.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32) as usize % Self::PLACES
    }

    /// Appends the text of a number if it is known; returns true if it is.
    #[inline]
    pub fn put(&self, out: &mut Vec<u8>, key: u64) -> bool {
        let known = self.texts.get(Self::place(key)).filter(|known| known.key == key && known.len > 0);
        let Some(KnownText { bytes, len, .. }) = known else { return false };
        put_beginning(out, bytes, usize::from(*len));
        true
    }

    /// Appends the text of a number, which `write` appends where it is not known.
    #[inline]
    pub fn put_or(&mut self, out: &mut Vec<u8>, key: u64, write: impl FnOnce(&mut Vec<u8>)) {
        if !self.put(out, key) {
            let start = out.len();
            write(out);
            self.keep(key, out.get(start..).unwrap_or_default());
        }
    }

    /// Forgets all texts.
    pub fn clear(&mut self) {
        self.texts.clear();
    }

    /// Returns true if this is the text of a number.
    #[inline]
    pub fn holds(&self, key: u64, text: &[u8]) -> bool {
        let known = self.texts.get(Self::place(key)).filter(|known| known.key == key);
        known.is_some_and(|known| known.bytes.get(..usize::from(known.len)) == Some(text))
    }

    /// Keeps the text of a number, unless it is too long.
    pub fn keep(&mut self, key: u64, text: &[u8]) {
        if self.few < Self::FEW {
            self.few += 1;
            return;
        }
        if self.texts.is_empty() {
            self.texts.resize(Self::PLACES, KnownText { key: 0, bytes: [0; MOST], len: 0 });
        }
        if let Some(known) = self.texts.get_mut(Self::place(key))
            && let Some(bytes) = known.bytes.get_mut(..text.len())
        {
            bytes.copy_from_slice(text);
            (known.key, known.len) = (key, text.len() as u16);
        }
    }
}

/// Two upper-case hexadecimal digits of each byte.
static PAIRS: [[u8; 2]; 256] = pairs();

#[allow(clippy::indexing_slicing, reason = "evaluated by the compiler, which refuses what is out of bounds")]
const fn pairs() -> [[u8; 2]; 256] {
    let (mut table, mut byte) = ([[0; 2]; 256], 0);
    while byte < 256 {
        table[byte] = [DIGITS[byte >> 4], DIGITS[byte & 0xF]];
        byte += 1;
    }
    table
}

/// Returns two upper-case hexadecimal digits.
#[inline]
pub fn hex_digits(byte: u8) -> [u8; 2] {
    PAIRS.get(usize::from(byte)).copied().unwrap_or_default()
}

/// Appends two upper-case hexadecimal digits.
pub fn hex_byte(out: &mut Vec<u8>, byte: u8) {
    out.extend_from_slice(&hex_digits(byte));
}

/// Appends `digits` upper-case hexadecimal digits (at most 16); higher ones are cut off.
pub fn hex(out: &mut Vec<u8>, value: u64, digits: usize) {
    for position in (0..digits.min(16)).rev() {
        out.push(digit((value >> (4 * position)) as u8));
    }
}

/// Appends `digits` binary digits (at most 64); higher ones are cut off.
pub fn binary(out: &mut Vec<u8>, value: u64, digits: usize) {
    for position in (0..digits.min(64)).rev() {
        out.push(b'0' + (value >> position & 1) as u8);
    }
}

/// Appends a decimal number. Eight digits are computed at once: dividing by a power found at run time costs several
/// times as much, and numbers are half of the output.
pub fn decimal(out: &mut Vec<u8>, value: u64) {
    if value < 10 {
        return out.push(b'0' + value as u8);
    }
    if value >= EIGHT {
        return long(out, value);
    }
    let digits = u64::from_le_bytes(eight_digits(value as u32));
    // The first digit is lowest, and digits are apart from zeros by their lower four bits.
    let zeros = ((digits & 0x0F0F_0F0F_0F0F_0F0F).trailing_zeros() / 8).min(7);
    put_beginning(out, &(digits >> (8 * zeros)).to_le_bytes(), 8 - zeros as usize);
}

/// The same of more than eight digits. Apart, since a function that calls itself saves registers at each call.
#[inline(never)]
fn long(out: &mut Vec<u8>, value: u64) {
    decimal(out, value / EIGHT);
    out.extend_from_slice(&eight_digits((value % EIGHT) as u32));
}

/// Appends a decimal number that is filled to a width of at most 20.
pub fn filled(out: &mut Vec<u8>, value: u64, width: usize, fill: u8) {
    let digits = 1 + value.checked_ilog10().unwrap_or(0) as usize;
    for _ in digits..width.min(20) {
        out.push(fill);
    }
    decimal(out, value);
}

/// Appends a fraction of a second, given in ns, with its point and `count` digits (at most 9); nothing if that is 0.
pub fn fraction(out: &mut Vec<u8>, ns: u32, count: u8) {
    if count == 0 {
        return;
    }
    let [a, b, c, d, e, f, g, h] = eight_digits(ns / 10);
    let digits = [b'.', a, b, c, d, e, f, g, h, b'0' + (ns % 10) as u8];
    put_beginning(out, &digits, 1 + usize::from(count.min(9)));
}

/// Returns exactly eight decimal digits; higher ones are cut off. All are computed at once within one number, without a
/// division for each: every line has nine of them for a timestamp in ns.
pub fn eight_digits(value: u32) -> [u8; 8] {
    let value = u64::from(value % 100_000_000);
    // Two numbers of four digits, then four of two, then eight of one: each in a part of its own, the first one lowest.
    let fours = (value / 10_000) | ((value % 10_000) << 32);
    let hundreds = ((fours * 10_486) >> 20) & 0x0000_007F_0000_007F;
    let twos = hundreds | ((fours - 100 * hundreds) << 16);
    let tens = ((twos * 103) >> 10) & 0x000F_000F_000F_000F;
    let ones = tens | ((twos - 10 * tens) << 8);
    (ones | 0x3030_3030_3030_3030).to_le_bytes()
}

/// Appends a decimal number with its sign.
pub fn signed(out: &mut Vec<u8>, value: i64) {
    if value < 0 {
        out.push(b'-');
    }
    decimal(out, value.unsigned_abs());
}

fn digit(nibble: u8) -> u8 {
    DIGITS.get(usize::from(nibble & 0xF)).copied().unwrap_or(b'0')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(part: impl Put) -> String {
        let mut out = Vec::new();
        part.put(&mut out);
        String::from_utf8_lossy(&out).into_owned()
    }

    #[test]
    fn numbers() {
        assert_eq!(written(0u8), "0");
        assert_eq!(written(10u8), "10");
        assert_eq!(written(99u16), "99");
        assert_eq!(written(100_000u32), "100000");
        assert_eq!(written(u64::MAX), u64::MAX.to_string());
        assert_eq!(written(i64::MIN), i64::MIN.to_string());
        assert_eq!(written(-1i64), "-1");
    }

    #[test]
    fn eight_digits_at_once() {
        for value in (0..100_000_000).step_by(1237).chain(0..10_000).chain(99_990_000..100_000_000) {
            let digits = eight_digits(value);
            let read = digits.iter().fold(0, |sum, digit| sum * 10 + u32::from(digit - b'0'));
            assert_eq!(read, value);
        }
    }

    #[test]
    fn digits_of_fixed_count() {
        assert_eq!(written(Hex::<4>(0x1008)), "1008");
        assert_eq!(written(Hex::<2>(0x1AB)), "AB");
        assert_eq!(written(Hex::<20>(1)), "0000000000000001");
        assert_eq!(written(Bin::<3>(0b101)), "101");
        assert_eq!(written(Nibbles(0x1B)), "0001 1011b");
        assert_eq!(written(Padded::<2>(5)), "05");
        assert_eq!(written(Padded::<2>(345)), "345");
        let mut out = Vec::new();
        filled(&mut out, 7, 3, b' ');
        filled(&mut out, 1234, 3, b' ');
        fraction(&mut out, 120_000_009, 3);
        fraction(&mut out, 9, 20);
        fraction(&mut out, 9, 0);
        assert_eq!(out, b"  71234.120.000000009");
        assert_eq!(written(Spaced(&[5, 0, 0xFF])), "05 00 FF");
        assert_eq!(written(Joined(&[5, 0xFF])), "05FF");
    }
}

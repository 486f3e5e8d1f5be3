//! TIME (CiA 301, 7.2.6): the time stamp object, a TIME_OF_DAY.
//!
//! | bytes | field |
//! |---|---|
//! | 0-3 | bits 27..0: milliseconds since midnight; bits 31..28: reserved, 0 |
//! | 4-5 | days since 1984-01-01 |
//!
//! The wire names no time zone, and none is assumed here.

use super::length;
use crate::bytes::calendar::{date_of, days_to};
use crate::wire::cob_id::Role;
use crate::wire::message::Message;

/// Milliseconds of a day; a time of day has fewer.
pub const DAY_MS: u32 = 86_400_000;

/// Decodes a frame on the TIME identifier.
pub fn decode(role: Role, payload: &[u8]) -> Message {
    let [a, b, c, d, e, f] = *payload else {
        return length(role, 6, 6);
    };
    let word = u32::from_le_bytes([a, b, c, d]);
    Message::Time { ms: word & 0x0FFF_FFFF, days: u16::from_le_bytes([e, f]), reserved: (word >> 28) as u8 }
}

/// The calendar date (year, month 1..=12, day 1..=31) of a number of days since 1984-01-01.
///
/// 16 bits reach to 2163-06-06, over one year divisible by 4 that is no leap year: 2100.
pub fn date(days: u16) -> (u16, u8, u8) {
    let (year, month, day) = date_of(days_to(1984, 1, 1) + i64::from(days));
    (year as u16, month as u8, day as u8)
}

/// Hours, minutes, seconds and milliseconds of a time of day; hours exceed 23 where `ms` exceeds a day.
pub fn clock(ms: u32) -> (u32, u32, u32, u32) {
    (ms / 3_600_000, ms / 60_000 % 60, ms / 1000 % 60, ms % 1000)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_of_2024() {
        let message = decode(Role::Time, &[0x95, 0x2C, 0xB3, 0x02, 0x9E, 0x39]);
        assert_eq!(message, Message::Time { ms: 45_296_789, days: 14_750, reserved: 0 });
        assert_eq!(date(14_750), (2024, 5, 20));
        assert_eq!(clock(45_296_789), (12, 34, 56, 789));
    }

    #[test]
    fn reserved_bits_are_no_time() {
        let message = decode(Role::Time, &[0x95, 0x2C, 0xB3, 0xA2, 0, 0]);
        assert_eq!(message, Message::Time { ms: 45_296_789, days: 0, reserved: 0xA });
        assert_eq!(decode(Role::Time, &[0; 8]), length(Role::Time, 6, 6));
    }

    #[test]
    fn dates() {
        assert_eq!(date(0), (1984, 1, 1));
        assert_eq!(date(59), (1984, 2, 29));
        assert_eq!(date(365), (1984, 12, 31));
        assert_eq!(date(366), (1985, 1, 1));
        assert_eq!(date(5844), (2000, 1, 1));
        assert_eq!(date(42_428), (2100, 3, 1));
        assert_eq!(date(u16::MAX), (2163, 6, 6));
    }
}

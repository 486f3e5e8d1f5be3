//! TIME (CiA 301, 7.2.6): the time stamp object, a TIME_OF_DAY.
//!
//! The frame names no time zone, and none is assumed here.

use super::prelude::*;
use crate::bytes::calendar::{date_of, days_to};

/// Milliseconds since midnight in bits 27..0, then days since 1984-01-01. Bits 31..28 are reserved, 0.
static FIELDS: &[FieldRow] = &[field(0, 4, ("", ""), Only(milliseconds), &[]), field(4, 2, ("", ""), Only(days), &[])];

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
fn date(days: u16) -> (u16, u8, u8) {
    let (year, month, day) = date_of(days_to(1984, 1, 1) + i64::from(days));
    (year as u16, month as u8, day as u8)
}

/// Hours, minutes, seconds and milliseconds of a time of day; hours exceed 23 where `ms` exceeds a day.
fn clock(ms: u32) -> (u32, u32, u32, u32) {
    (ms / 3_600_000, ms / 60_000 % 60, ms / 1000 % 60, ms % 1000)
}

/// A time of day: `12:34:56.789`; hours exceed 23 beyond a day.
#[derive(Clone, Copy, Debug)]
pub struct Clock(pub u32);

impl Put for Clock {
    fn put(&self, out: &mut Vec<u8>) {
        let (hour, minute, second, ms) = clock(self.0);
        put!(out; Padded::<2>(u64::from(hour)), ":", Padded::<2>(u64::from(minute)), ":");
        put!(out; Padded::<2>(u64::from(second)), ".", Padded::<3>(u64::from(ms)));
    }
}

/// The date of a number of days since 1984-01-01: `2024-05-20`.
struct Date(u16);

impl Put for Date {
    fn put(&self, out: &mut Vec<u8>) {
        let (year, month, day) = date(self.0);
        put!(out; year, "-", Padded::<2>(u64::from(month)), "-", Padded::<2>(u64::from(day)));
    }
}

/// The forms of TIME.
pub(super) struct TimeService;

impl WireService for TimeService {
    /// `时间报文(TIME): 2024-05-20 12:34:56.789 (45296789 ms, 第14750天)`.
    fn line(&self, out: &mut Vec<u8>, lang: Lang, full: bool, message: &Message, _: &Frame) {
        let Message::Time { ms, days, reserved } = *message else { return };
        put!(out; Named(lang, Role::Time));
        if !full {
            return;
        }
        put!(out; ": ", Date(days), " ", Clock(ms));
        say!(out, lang; zh: " (", ms, " ms, 第", days, "天)"; en: " (", ms, " ms, day ", days, ")");
        if ms >= DAY_MS {
            put!(out; lang.pick(", 超出一天", ", beyond a day"));
        }
        if reserved != 0 {
            let bits = Hex::<1>(u64::from(reserved));
            put!(out; lang.pick(", 保留位不为0 (", ", reserved bits are not 0 ("), bits, "h)");
        }
    }

    fn fields(&self) -> &'static [FieldRow] {
        FIELDS
    }

    fn json(&self, object: &mut Object<'_>, message: &Message, _: &Frame) {
        let Message::Time { ms, days, reserved } = *message else { return };
        object.number("ms", ms);
        object.number("days", days);
        object.hex::<1>("reserved", u64::from(reserved));
        put!(object.key("date"); "\"", Date(days), "\"");
        match ms {
            DAY_MS.. => put!(object.key("time_of_day"); "null"),
            _ => put!(object.key("time_of_day"); "\"", Clock(ms), "\""),
        }
    }
}

fn milliseconds(out: &mut Vec<u8>, lang: Lang, read: &FieldValue<'_>) {
    let (ms, reserved) = (read.value & 0x0FFF_FFFF, u64::from(read.value >> 28));
    put!(out; " = ", Hex::<8>(u64::from(read.value)), lang.pick("h (小端格式)  位31-28: ", "h (little-endian)  bits 31-28: "));
    put!(out; Bin::<4>(reserved), lang.pick("b 保留 | 位27-0: 午夜起", "b reserved | bits 27-0: since midnight "));
    put!(out; ms, " ms = ", Clock(ms));
}

fn days(out: &mut Vec<u8>, lang: Lang, read: &FieldValue<'_>) {
    let date = Date(read.value as u16);
    put!(out; " = ", Hex::<4>(u64::from(read.value)));
    say!(out, lang;
        zh: "h (小端格式)  1984-01-01起", read.value, "天 = ", date;
        en: "h (little-endian)  since 1984-01-01: ", read.value, " days = ", date);
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

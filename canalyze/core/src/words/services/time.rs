//! TIME in words (CiA 301, 7.2.6): the date and the time of day that it sets.

use crate::wire::cob_id::Role;
use crate::wire::role::Named;
use crate::wire::time;
use crate::words::digits::{Hex, Padded, Put, put};
use crate::words::{Lang, say};

/// A time of day: `12:34:56.789`; hours exceed 23 where it is beyond a day.
#[derive(Clone, Copy, Debug)]
pub struct Clock(pub u32);

impl Put for Clock {
    fn put(&self, out: &mut Vec<u8>) {
        let (hour, minute, second, ms) = time::clock(self.0);
        put!(out; Padded::<2>(u64::from(hour)), ":", Padded::<2>(u64::from(minute)), ":");
        put!(out; Padded::<2>(u64::from(second)), ".", Padded::<3>(u64::from(ms)));
    }
}

/// The date of a number of days since 1984-01-01: `2024-05-20`.
#[derive(Clone, Copy, Debug)]
pub struct Date(pub u16);

impl Put for Date {
    fn put(&self, out: &mut Vec<u8>) {
        let (year, month, day) = time::date(self.0);
        put!(out; year, "-", Padded::<2>(u64::from(month)), "-", Padded::<2>(u64::from(day)));
    }
}

/// TIME and what it carries: `时间报文(TIME): 2024-05-20 12:34:56.789 (45296789 ms, 第14750天)`.
pub fn time_of_day(out: &mut Vec<u8>, lang: Lang, full: bool, ms: u32, days: u16, reserved: u8) {
    put!(out; Named(lang, Role::Time));
    if !full {
        return;
    }
    put!(out; ": ", Date(days), " ", Clock(ms));
    say!(out, lang; zh: " (", ms, " ms, 第", days, "天)"; en: " (", ms, " ms, day ", days, ")");
    if ms >= time::DAY_MS {
        say!(out, lang; zh: ", 超出一天"; en: ", beyond a day");
    }
    if reserved != 0 {
        let bits = Hex::<1>(u64::from(reserved));
        say!(out, lang; zh: ", 保留位不为0 (", bits, "h)"; en: ", reserved bits are not 0 (", bits, "h)");
    }
}

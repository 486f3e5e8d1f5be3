//! The context of machine output, and the forms that moments and text have in it.
//!
//! Must not: know a record.

use std::cell::RefCell;

use crate::bytes::frame::{BusId, Buses, Stamp, StampForm};
use crate::bytes::ns::Ns;
use crate::bytes::writers::console;
use crate::views::lines::Clocked;
use crate::words::digits::{KnownTexts, fraction, put};
use crate::words::{Lang, escape};

thread_local! {
    /// Whole seconds, since most moments have that of the one before.
    static WHOLE: RefCell<KnownTexts> = RefCell::default();
}

/// The language of names in machine output: one, whatever that of the texts is.
pub const NAMES: Lang = Lang::En;

/// The context of machine output beside the records.
#[derive(Clone, Copy, Debug)]
pub struct Setting<'a> {
    /// The language of `text` and `message`; names are the same in every language.
    pub lang: Lang,
    /// The name of the file.
    pub file: &'a [u8],
    /// The names of the buses.
    pub buses: &'a Buses,
    /// Digits after the point of the capture's stamps.
    pub decimals: u8,
    /// The form of moments, and of the time in lines.
    pub clock: Clocked,
}

impl<'a> Setting<'a> {
    /// Appends a moment in the form that is asked for, or null.
    pub(in crate::tables) fn moment(&self, out: &mut Vec<u8>, t_ns: Option<Ns>) {
        match t_ns.and_then(|t_ns| self.clock.moment(t_ns)) {
            Some((ns, StampForm::Calendar)) => {
                put!(out; "\"");
                console::digits(out, &Stamp { form: StampForm::Calendar, ns, width: 0, decimals: self.decimals });
                put!(out; "\"");
            }
            moment => seconds(out, moment.map(|(ns, _)| ns), self.decimals),
        }
    }

    /// The name of a bus; empty where the capture names none.
    pub(in crate::tables) fn bus(&self, id: BusId) -> &'a [u8] {
        self.buses.name(id)
    }
}

/// Appends seconds as a decimal string, or null.
pub(in crate::tables) fn seconds(out: &mut Vec<u8>, ns: Option<Ns>, decimals: u8) {
    let Some(ns) = ns else { return put!(out; "null") };
    put!(out; if ns < Ns::ZERO { "\"-" } else { "\"" });
    let ns = ns.as_ns().unsigned_abs();
    let whole = ns / 1_000_000_000;
    WHOLE.with_borrow_mut(|known| known.put_or(out, whole, |out| put!(out; whole)));
    fraction(out, (ns % 1_000_000_000) as u32, decimals);
    put!(out; "\"");
}

/// Appends the text that `write` appends as a JSON string.
pub(crate) fn quoted(out: &mut Vec<u8>, write: impl FnOnce(&mut Vec<u8>)) {
    out.push(b'"');
    let start = out.len();
    write(out);
    escape::close(out, start);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_have_their_digits_whatever_came_before() {
        for _ in 0..20 {
            for (ns, text) in [
                (0, "\"0.000000\""),
                (999_999_999, "\"0.999999\""),
                (-1_000_000_000, "\"-1.000000\""),
                (1_000_001_000, "\"1.000001\""),
                (1_700_000_000_108_612_000, "\"1700000000.108612\""),
                (1_700_000_000_999_999_000, "\"1700000000.999999\""),
                (1_700_000_001_000_000_000, "\"1700000001.000000\""),
                (i64::MIN, "\"-9223372036.854775\""),
            ] {
                let mut out = Vec::new();
                seconds(&mut out, Some(Ns(ns)), 6);
                assert_eq!(String::from_utf8_lossy(&out), text);
            }
        }
    }
}

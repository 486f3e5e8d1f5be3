//! JSON objects: `obj! { "frames": frames, "rate": rate }` is a value that writes itself; each key stands in one place.
//!
//! The values of an object are evaluated where it is declared and written when it is; nothing is put on the heap. A value
//! that is expensive, or of varying form, is a closure: [`text`], [`raw`]. It must not know what the keys mean.

use super::Setting;
use crate::bytes::frame::CanId;
use crate::bytes::ns::Ns;
use crate::sdo::abort_code::AbortCode;
use crate::words::digits::{Hex, Joined, Put, put};
use crate::words::escape;

/// Declares an object: `obj! { "key": value, ... }`, with doc comments before keys. The values are what [`WriteJson`] can
/// write, the key of an [`Obj::inline`] or of [`members`] is `_`.
macro_rules! obj {
    ($($(#[$doc:meta])* $($key:literal)? $(_)?: $value:expr),* $(,)?) => {
        $crate::tables::jsonl::obj::Obj {
            keys: const { &[$($crate::tables::jsonl::obj::obj!(@key $($key)?)),*] },
            values: $crate::tables::jsonl::obj::obj!(@values $($value,)*),
        }
    };
    (@key) => { "" };
    (@key $key:literal) => { concat!(",\"", $key, "\":") };
    (@values) => { () };
    (@values $value:expr, $($rest:expr,)*) => { ($value, $crate::tables::jsonl::obj::obj!(@values $($rest,)*)) };
}
pub(crate) use obj;

/// A value that can be written as JSON.
pub(crate) trait WriteJson: Sized {
    /// Appends itself.
    fn write_json(self, out: &mut Vec<u8>);

    /// Returns true if an object has no key for it.
    fn is_absent(&self) -> bool {
        false
    }

    /// Appends itself as a line.
    fn write_line(self, out: &mut Vec<u8>) {
        self.write_json(out);
        out.push(b'\n');
    }
}

macro_rules! numbers {
    ($($number:ty)*) => {$(
        impl WriteJson for $number {
            fn write_json(self, out: &mut Vec<u8>) {
                self.put(out);
            }
        }
    )*};
}
numbers! { u8 u16 u32 u64 usize i64 }

impl WriteJson for Ns {
    fn write_json(self, out: &mut Vec<u8>) {
        self.as_ns().put(out);
    }
}

impl WriteJson for bool {
    fn write_json(self, out: &mut Vec<u8>) {
        put!(out; if self { "true" } else { "false" });
    }
}

/// A number that is not finite is null.
impl WriteJson for f64 {
    fn write_json(self, out: &mut Vec<u8>) {
        if self.is_finite() { put!(out; self.to_string().as_str()) } else { put!(out; "null") }
    }
}

impl WriteJson for &str {
    fn write_json(self, out: &mut Vec<u8>) {
        escape::json(out, self.as_bytes());
    }
}

/// Text from a capture: bytes that are not UTF-8 become U+FFFD.
impl WriteJson for &[u8] {
    fn write_json(self, out: &mut Vec<u8>) {
        escape::json(out, self);
    }
}

impl WriteJson for AbortCode {
    fn write_json(self, out: &mut Vec<u8>) {
        put!(out; "\"", self, "\"");
    }
}

impl<const DIGITS: usize> WriteJson for Hex<DIGITS> {
    fn write_json(self, out: &mut Vec<u8>) {
        put!(out; "\"", self, "\"");
    }
}

impl WriteJson for Joined<'_> {
    fn write_json(self, out: &mut Vec<u8>) {
        put!(out; "\"", self, "\"");
    }
}

impl WriteJson for CanId {
    fn write_json(self, out: &mut Vec<u8>) {
        let raw = u64::from(self.raw());
        if self.is_extended() { Hex::<8>(raw).write_json(out) } else { Hex::<3>(raw).write_json(out) }
    }
}

/// Nothing is null.
impl<V: WriteJson> WriteJson for Option<V> {
    fn write_json(self, out: &mut Vec<u8>) {
        match self {
            Some(value) => value.write_json(out),
            None => put!(out; "null"),
        }
    }
}

/// A value whose key is absent without it.
pub(crate) struct Given<V>(pub(crate) Option<V>);

impl<V: WriteJson> WriteJson for Given<V> {
    fn write_json(self, out: &mut Vec<u8>) {
        self.0.write_json(out);
    }

    fn is_absent(&self) -> bool {
        self.0.is_none()
    }
}

/// A value that a closure writes.
pub(crate) struct Raw<F>(F);

/// Returns a value of varying form, which `write` appends as JSON.
pub(crate) fn raw<F: FnOnce(&mut Vec<u8>)>(write: F) -> Raw<F> {
    Raw(write)
}

impl<F: FnOnce(&mut Vec<u8>)> WriteJson for Raw<F> {
    fn write_json(self, out: &mut Vec<u8>) {
        (self.0)(out);
    }
}

/// Returns a moment in the form that is asked for, or null.
pub(crate) fn moment(setting: Setting<'_>, t_ns: Option<Ns>) -> impl WriteJson {
    raw(move |out| setting.moment(out, t_ns))
}

/// Returns seconds as a decimal string, or null.
pub(crate) fn time(ns: Option<Ns>, decimals: u8) -> impl WriteJson {
    raw(move |out| super::seconds(out, ns, decimals))
}

/// Returns the name of a PDO.
pub(crate) fn pdo(transmit: bool, number: u16) -> impl WriteJson {
    raw(move |out| put!(out; if transmit { "\"TPDO" } else { "\"RPDO" }, number, "\""))
}

/// Returns two hexadecimal digits.
pub(crate) fn hex2(number: u8) -> Hex<2> {
    Hex(u64::from(number))
}

/// Returns four hexadecimal digits.
pub(crate) fn hex4(number: u16) -> Hex<4> {
    Hex(u64::from(number))
}

/// Returns eight hexadecimal digits.
pub(crate) fn hex8(number: u32) -> Hex<8> {
    Hex(u64::from(number))
}

/// Returns JSON that has been written before.
pub(crate) fn written(json: &[u8]) -> impl WriteJson {
    raw(move |out| out.extend_from_slice(json))
}

/// A string that a closure writes.
pub(crate) struct Text<F>(F);

/// Returns a string; `write` appends its content, which is escaped afterwards.
pub(crate) fn text<F: FnOnce(&mut Vec<u8>)>(write: F) -> Text<F> {
    Text(write)
}

impl<F: FnOnce(&mut Vec<u8>)> WriteJson for Text<F> {
    fn write_json(self, out: &mut Vec<u8>) {
        super::quoted(out, self.0);
    }
}

/// A JSON array.
pub(crate) struct Array<I>(I);

/// Returns an array of these values.
pub(crate) fn array<I: IntoIterator<Item: WriteJson>>(items: I) -> Array<I> {
    Array(items)
}

impl<I: IntoIterator<Item: WriteJson>> WriteJson for Array<I> {
    fn write_json(self, out: &mut Vec<u8>) {
        put!(out; "[");
        for (place, item) in self.0.into_iter().enumerate() {
            put!(out; if place > 0 { "," } else { "" });
            item.write_json(out);
        }
        put!(out; "]");
    }
}

/// Returns a value for the key `_`: these keys, which need no escaping, with their values.
pub(crate) fn members<K: Put, V: WriteJson>(items: impl IntoIterator<Item = (K, V)>) -> impl WriteJson {
    raw(move |out| {
        for (key, value) in items {
            put!(out; ",\"", key, "\":");
            value.write_json(out);
        }
    })
}

/// Returns an object of these keys, which need no escaping, with their values.
pub(crate) fn map<K: Put, V: WriteJson>(items: impl IntoIterator<Item = (K, V)>) -> impl WriteJson {
    obj! { _: members(items) }
}

/// Returns a name from a capture, or `None` where it has none.
pub(crate) fn named(name: &[u8]) -> Option<&[u8]> {
    Some(name).filter(|name| !name.is_empty())
}

/// The values of an object, a pair of the first one and the rest.
pub(crate) trait Values {
    /// Appends them behind their keys, each of which is `,"key":`.
    fn write(self, keys: &'static [&'static str], out: &mut Vec<u8>);
}

impl Values for () {
    fn write(self, _: &'static [&'static str], _: &mut Vec<u8>) {}
}

impl<V: WriteJson, R: Values> Values for (V, R) {
    #[inline]
    fn write(self, keys: &'static [&'static str], out: &mut Vec<u8>) {
        let (value, rest) = self;
        let [key, keys @ ..] = keys else { return };
        if !value.is_absent() {
            put!(out; *key);
            value.write_json(out);
        }
        rest.write(keys, out);
    }
}

/// An object; see [`obj`].
pub(crate) struct Obj<V> {
    /// Each as `,"key":`.
    pub(crate) keys: &'static [&'static str],
    /// Their values.
    pub(crate) values: V,
}

impl<V: Values> Obj<V> {
    /// Returns a value for the key `_`, with which all keys of this object become those of the outer one.
    pub(crate) fn inline(self) -> impl WriteJson {
        raw(move |out| self.values.write(self.keys, out))
    }
}

impl<V: Values> WriteJson for Obj<V> {
    fn write_json(self, out: &mut Vec<u8>) {
        let start = out.len();
        self.values.write(self.keys, out);
        // The comma before the first key.
        match out.get_mut(start) {
            Some(comma) => *comma = b'{',
            None => out.push(b'{'),
        }
        out.push(b'}');
    }
}

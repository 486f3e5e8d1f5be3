//! The values of columns: how each kind is written in JSON and CSV, and appended to its Arrow column.
//!
//! Apart from [`super`], because a declaration needs the names of kinds and not this: it is for adding a kind, or for
//! changing how one is written. Must not: know a record.

use std::cell::Cell;

use arrow_array::ArrowPrimitiveType;

use super::*;
use crate::bytes::frame::CanId;
use crate::bytes::ns::Ns;
use crate::rules::finding::Code;
use crate::sdo::abort_code::AbortCode;
use crate::tables::columns::column::lossy;
use crate::tables::jsonl::sdo::json_value;
use crate::tables::setting::{quoted, seconds};
use crate::words::digits::{Hex, Joined, put};
use crate::words::escape;
use crate::world::od;

/// Implements kinds of optional values: the type of a value, its JSON, and how its column holds it.
macro_rules! optional {
    ($($kind:ident $value:ty, |$out:ident, $cx:ident, $one:ident| $json:expr $(, |$column:ident, $held:ident| $append:expr)?;)*) => {$(
        impl<'v, V: Into<Option<$value>>> ColumnKind<V> for $kind {
            #[inline]
            fn json($out: &mut Vec<u8>, $cx: &Cx<'_>, value: V) {
                match value.into() {
                    Some($one) => $json,
                    None => put!($out; "null"),
                }
            }

            fn csv(out: &mut Vec<u8>, cx: &Cx<'_>, value: V) {
                if let Some(value) = value.into() {
                    csv::bare(out, |out| <Self as ColumnKind<$value>>::json(out, cx, value));
                }
            }
        }

        $(impl<'v, V: Into<Option<$value>>> Stored<V> for $kind {
            #[inline]
            fn append($column: &mut Self::Builder, value: V) -> usize {
                let $held = value.into();
                $append
            }
        })?
    )*};
}

/// Appends a number, or null.
fn number<T: ArrowPrimitiveType>(column: &mut Numbers<T>, value: Option<T::Native>) -> usize {
    column.append_option(value);
    0
}

optional! {
    U8 u8, |out, _cx, one| put!(out; one), |column, value| number(column, value);
    U16 u16, |out, _cx, one| put!(out; one), |column, value| number(column, value);
    U32 u32, |out, _cx, one| put!(out; one), |column, value| number(column, value);
    U64 u64, |out, _cx, one| put!(out; one), |column, value| number(column, value);
    I64 i64, |out, _cx, one| put!(out; one), |column, value| number(column, value);
    Real f64, |out, _cx, one| out.extend_from_slice(one.to_string().as_bytes()), |column, value| number(column, value);
    Hex4 u16, |out, _cx, one| put!(out; "\"", Hex::<4>(u64::from(one)), "\""), |column, value| number(column, value);
    Hex8 u32, |out, _cx, one| put!(out; "\"", Hex::<8>(u64::from(one)), "\""), |column, value| number(column, value);
    AbortDigits AbortCode, |out, _cx, one| put!(out; "\"", one, "\""), |column, value| number(column, value.map(AbortCode::number));
    Moment Ns, |out, cx, one| cx.setting.moment(out, Some(one)), |column, value| number(column, value.map(Ns::as_ns));
    Duration Ns, |out, cx, one| seconds(out, Some(one), cx.setting.decimals), |column, value| number(column, value.map(Ns::as_ns));
    Truth bool, |out, _cx, one| put!(out; if one { "true" } else { "false" }), |column, value| {
        column.append_option(value);
        0
    };
    Label &'v str, |out, _cx, one| escape::json(out, one.as_bytes()), |column, value| {
        column.maybe(value);
        0
    };
    Utf8 &'v str, |out, _cx, one| escape::json(out, one.as_bytes()), |column, value| {
        column.append_option(value);
        value.map_or(0, str::len)
    };
    Bytes &'v [u8], |out, _cx, one| put!(out; "\"", Joined(one), "\""), |column, value| {
        column.append_option(value);
        value.map_or(0, <[u8]>::len)
    };
}

impl<'v, V: Into<Option<&'v str>>> ColumnKind<V> for Word {
    #[inline]
    fn json(out: &mut Vec<u8>, _: &Cx<'_>, word: V) {
        match word.into() {
            Some(word) => put!(out; "\"", word, "\""),
            None => put!(out; "null"),
        }
    }

    #[inline]
    fn csv(out: &mut Vec<u8>, _: &Cx<'_>, word: V) {
        put!(out; word.into().unwrap_or(""));
    }
}

impl<'v, V: Into<Option<&'v str>>> Stored<V> for Word {
    #[inline]
    fn append(column: &mut Words, word: V) -> usize {
        column.maybe(word.into());
        0
    }
}

/// The stamp in ns, and its digits behind the point.
impl ColumnKind<(Option<Ns>, u8)> for Stamped {
    fn json(out: &mut Vec<u8>, _: &Cx<'_>, (t_ns, decimals): (Option<Ns>, u8)) {
        seconds(out, t_ns, decimals);
    }
}

impl Stored<(Option<Ns>, u8)> for Stamped {
    fn append(column: &mut Self::Builder, (t_ns, _): (Option<Ns>, u8)) -> usize {
        number(column, t_ns.map(Ns::as_ns))
    }
}

impl ColumnKind<CanId> for Identifier {
    fn json(out: &mut Vec<u8>, _: &Cx<'_>, id: CanId) {
        let raw = u64::from(id.raw());
        match id.is_extended() {
            true => put!(out; "\"", Hex::<8>(raw), "\""),
            false => put!(out; "\"", Hex::<3>(raw), "\""),
        }
    }
}

impl Stored<CanId> for Identifier {
    fn append(column: &mut Self::Builder, id: CanId) -> usize {
        number(column, Some(id.raw()))
    }
}

impl<N: AsRef<[u8]>> ColumnKind<N> for Name {
    fn json(out: &mut Vec<u8>, _: &Cx<'_>, name: N) {
        match name.as_ref() {
            [] => put!(out; "null"),
            name => escape::json(out, name),
        }
    }

    fn csv(out: &mut Vec<u8>, _: &Cx<'_>, name: N) {
        csv::cell(out, name.as_ref());
    }
}

impl<N: AsRef<[u8]>> Stored<N> for Name {
    fn append(column: &mut Words, name: N) -> usize {
        column.name(name.as_ref());
        0
    }
}

impl<N: AsRef<[u8]>> ColumnKind<N> for Given {
    fn json(out: &mut Vec<u8>, _: &Cx<'_>, name: N) {
        escape::json(out, name.as_ref());
    }

    fn csv(out: &mut Vec<u8>, _: &Cx<'_>, name: N) {
        csv::cell(out, name.as_ref());
    }
}

impl<N: AsRef<[u8]>> Stored<N> for Given {
    fn append(column: &mut Words, name: N) -> usize {
        column.word(&lossy(name.as_ref()));
        0
    }
}

thread_local! {
    /// The memory of texts on their way to a column.
    static TEXT: Cell<Vec<u8>> = const { Cell::new(Vec::new()) };
}

/// Appends text that a function appends to a column, or null where it returns false.
fn text(column: &mut StringBuilder, write: impl FnOnce(&mut Vec<u8>) -> bool) -> usize {
    let mut text = TEXT.take();
    let is_some = write(&mut text);
    column.append_option(is_some.then(|| lossy(&text)));
    let bytes = text.len();
    text.clear();
    TEXT.set(text);
    bytes
}

impl<F: FnOnce(&mut Vec<u8>)> ColumnKind<F> for Text {
    fn json(out: &mut Vec<u8>, _: &Cx<'_>, write: F) {
        quoted(out, write);
    }
}

impl<F: FnOnce(&mut Vec<u8>)> Stored<F> for Text {
    fn append(column: &mut StringBuilder, write: F) -> usize {
        text(column, |text| {
            write(text);
            true
        })
    }
}

impl<F: FnOnce(&mut Vec<u8>) -> bool> ColumnKind<F> for MaybeText {
    fn json(out: &mut Vec<u8>, _: &Cx<'_>, write: F) {
        let (start, mut is_some) = (out.len(), false);
        quoted(out, |out| is_some = write(out));
        if !is_some {
            out.truncate(start);
            put!(out; "null");
        }
    }
}

impl<F: FnOnce(&mut Vec<u8>) -> bool> Stored<F> for MaybeText {
    fn append(column: &mut StringBuilder, write: F) -> usize {
        text(column, write)
    }
}

macro_rules! written {
    ($($kind:ident)*) => {$(
        impl<F: FnOnce(&mut Vec<u8>)> ColumnKind<F> for $kind {
            fn json(out: &mut Vec<u8>, _: &Cx<'_>, write: F) {
                write(out);
            }

            fn csv(out: &mut Vec<u8>, _: &Cx<'_>, write: F) {
                csv::bare(out, write);
            }
        }
    )*};
}
written! { Json Any List Members }

impl<F: FnOnce(&mut Vec<u8>)> Stored<F> for Json {
    fn append(column: &mut StringBuilder, write: F) -> usize {
        Text::append(column, write)
    }
}

impl<F: FnOnce(&mut Vec<u8>)> ColumnKind<F> for Piece {
    fn json(out: &mut Vec<u8>, _: &Cx<'_>, write: F) {
        write(out);
    }

    fn csv(out: &mut Vec<u8>, _: &Cx<'_>, write: F) {
        write(out);
    }
}

impl ColumnKind<(Option<od::DataType>, &[u8])> for Typed {
    fn json(out: &mut Vec<u8>, _: &Cx<'_>, (data_type, bytes): (Option<od::DataType>, &[u8])) {
        json_value(out, data_type, bytes);
    }

    fn csv(out: &mut Vec<u8>, cx: &Cx<'_>, (data_type, bytes): (Option<od::DataType>, &[u8])) {
        match od::decode(data_type, bytes) {
            od::Value::Text(text) => csv::cell(out, text.as_bytes()),
            _ => csv::bare(out, |out| Self::json(out, cx, (data_type, bytes))),
        }
    }
}

impl ColumnKind<&[Code]> for Codes {
    fn json(out: &mut Vec<u8>, cx: &Cx<'_>, codes: &[Code]) {
        List::json(out, cx, |out: &mut Vec<u8>| list(out, codes, |out, code| put!(out; "\"", code.rule().id, "\"")));
    }

    fn csv(out: &mut Vec<u8>, _: &Cx<'_>, codes: &[Code]) {
        for (place, code) in codes.iter().enumerate() {
            put!(out; if place > 0 { " " } else { "" }, code.rule().id);
        }
    }
}

impl Stored<&[Code]> for Codes {
    fn append(column: &mut Self::Builder, codes: &[Code]) -> usize {
        codes.iter().for_each(|code| column.values().append_value(code.rule().id));
        column.append(true);
        0
    }
}

macro_rules! lists {
    ($($kind:ident $number:ty;)*) => {$(
        impl<I: IntoIterator<Item = $number>> Stored<I> for $kind {
            fn append(column: &mut Self::Builder, numbers: I) -> usize {
                numbers.into_iter().for_each(|one| column.values().append_value(one));
                column.append(true);
                0
            }
        }
    )*};
}
lists! { U8s u8; U16s u16; U32s u32; U64s u64; }

//! Tables: the columns of a record, declared once; JSON lines, Arrow, CSV, the documentation and the schema follow.
//!
//! A row of [`table!`] is a column: its documentation, its name, its kind, and the expression that reads it off the
//! record. The kind knows how a value is written in JSON and CSV, and which Arrow column holds it. Must not: know a
//! record.

use std::borrow::Cow;
use std::cell::Cell;

use arrow_array::ArrowPrimitiveType;
use arrow_array::builder::{BinaryBuilder, BooleanBuilder, ListBuilder, StringBuilder};
use arrow_array::types::{Float64Type, Int64Type, UInt8Type, UInt16Type, UInt32Type, UInt64Type};
use arrow_schema::{DataType, Field};

use super::columns::column::{Column, Numbers, Words, lossy};
use super::csv;
use super::jsonl::sdo::json_value;
use super::setting::{Setting, quoted, seconds};
use crate::bytes::frame::CanId;
use crate::rules::finding::Code;
use crate::sdo::abort_code::AbortCode;
use crate::sdo::wire::Mux;
use crate::words::digits::{Hex, Joined, put};
use crate::words::{Lang, escape, value};
use crate::world::dictionary::Described;
use crate::world::od;

/// The context of a record: the setting, and the language of names.
#[derive(Clone, Copy)]
pub(super) struct Cx<'a> {
    pub(super) setting: Setting<'a>,
    pub(super) names: Lang,
}

impl<'a> Cx<'a> {
    /// Returns the context of tables, where names are in the language of texts.
    pub(super) fn of(setting: Setting<'a>) -> Self {
        Self { setting, names: setting.lang }
    }

    /// Returns the name of an object; empty where it has none.
    pub(super) fn object(&self, mux: Option<Mux>, described: &Described) -> Cow<'a, [u8]> {
        let mut name = Vec::new();
        if let Some(mux) = mux {
            value::name(&mut name, self.names, mux, described);
        }
        // A blank is before the name.
        name.drain(..name.len().min(1));
        name.into()
    }
}

/// A kind of column.
pub(super) trait ColumnKind<V> {
    /// Appends a value as JSON.
    fn json(out: &mut Vec<u8>, cx: &Cx<'_>, value: V);
    /// Appends a value as a cell of CSV.
    fn csv(out: &mut Vec<u8>, cx: &Cx<'_>, value: V) {
        csv::bare(out, |out| Self::json(out, cx, value));
    }
}

/// The type that a kind has in JSON.
pub(super) trait InJson {
    /// Its name: `integer`, `number`, `string`, `boolean`, `array`, `object` or `any`.
    const JSON: &'static str;
}

/// The Arrow column of a kind.
pub(super) trait InArrow {
    /// The builder.
    type Builder: Column;
    /// The end of the column's name, behind that of the row.
    const SUFFIX: &'static str = "";
}

/// A kind whose values Arrow columns hold.
pub(super) trait Stored<V>: InArrow {
    /// Appends a value, and returns the bytes of its text and data.
    fn append(column: &mut Self::Builder, value: V) -> usize;
}

/// Declares kinds: what each is, its type in JSON, its Arrow builder and the suffix of its column.
macro_rules! kinds {
    ($($(#[$doc:meta])* $kind:ident $json:literal $($builder:ty $(, $suffix:literal)?)?;)*) => {$(
        $(#[$doc])*
        pub(super) enum $kind {}
        impl InJson for $kind {
            const JSON: &'static str = $json;
        }
        $(impl InArrow for $kind {
            type Builder = $builder;
            $(const SUFFIX: &'static str = $suffix;)?
        })?
    )*};
}

kinds! {
    /// A number.
    U8 "integer" Numbers<UInt8Type>;
    /// A number.
    U16 "integer" Numbers<UInt16Type>;
    /// A number.
    U32 "integer" Numbers<UInt32Type>;
    /// A number.
    U64 "integer" Numbers<UInt64Type>;
    /// A number with a sign.
    I64 "integer" Numbers<Int64Type>;
    /// A real.
    Real "number" Numbers<Float64Type>;
    /// Four hexadecimal digits.
    Hex4 "string" Numbers<UInt16Type>;
    /// Eight hexadecimal digits.
    Hex8 "string" Numbers<UInt32Type>;
    /// The code of an abort: eight hexadecimal digits, of USDO two.
    AbortDigits "string" Numbers<UInt32Type>;
    /// A moment of the capture, in ns.
    Moment "string" Numbers<Int64Type>, "_ns";
    /// The stamp of a frame, in ns, with its own count of digits.
    Stamped "string" Numbers<Int64Type>, "_ns";
    /// A time from one frame to another, in ns.
    Duration "string" Numbers<Int64Type>, "_ns";
    /// An identifier.
    Identifier "string" Numbers<UInt32Type>;
    /// A truth value.
    Truth "boolean" BooleanBuilder;
    /// A word of the program.
    Word "string" Words;
    /// A name from a capture or a description; null where it is empty.
    Name "string" Words;
    /// A name that may be empty.
    Given "string" Words;
    /// Text that a function appends.
    Text "string" StringBuilder;
    /// Text that a function appends; null where it returns false.
    MaybeText "string" StringBuilder;
    /// JSON of its own shape that a function appends; Arrow holds its text.
    Json "object" StringBuilder;
    /// JSON of any type that a function appends.
    Any "any" StringBuilder;
    /// A list that a function appends.
    List "array";
    /// Members of the object with their keys, that a function appends.
    Members "object";
    /// Text from a capture or a description.
    Utf8 "string" StringBuilder;
    /// The same where there are few different ones.
    Label "string" Words;
    /// Bytes.
    Bytes "string" BinaryBuilder;
    /// A value by its type: a number, a truth value, a text, or null.
    Typed "any";
    /// A cell of CSV that a function appends.
    Piece "string";
    /// Codes of rules.
    Codes "array" ListBuilder<StringBuilder>;
    /// Numbers.
    U8s "array" ListBuilder<Numbers<UInt8Type>>;
    /// Numbers.
    U16s "array" ListBuilder<Numbers<UInt16Type>>;
    /// Numbers.
    U32s "array" ListBuilder<Numbers<UInt32Type>>;
    /// Numbers.
    U64s "array" ListBuilder<Numbers<UInt64Type>>;
}

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
    Moment i64, |out, cx, one| cx.setting.moment(out, Some(one)), |column, value| number(column, value);
    Duration i64, |out, cx, one| seconds(out, Some(one), cx.setting.decimals), |column, value| number(column, value);
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
impl ColumnKind<(Option<i64>, u8)> for Stamped {
    fn json(out: &mut Vec<u8>, _: &Cx<'_>, (t_ns, decimals): (Option<i64>, u8)) {
        seconds(out, t_ns, decimals);
    }
}

impl Stored<(Option<i64>, u8)> for Stamped {
    fn append(column: &mut Self::Builder, (t_ns, _): (Option<i64>, u8)) -> usize {
        number(column, t_ns)
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

/// Appends a list in JSON, each item with `write`.
pub(super) fn list<T>(out: &mut Vec<u8>, items: impl IntoIterator<Item = T>, mut write: impl FnMut(&mut Vec<u8>, T)) {
    out.push(b'[');
    for (place, item) in items.into_iter().enumerate() {
        if place > 0 {
            out.push(b',');
        }
        write(out, item);
    }
    out.push(b']');
}

/// Declares a record and its columns.
///
/// ```text
/// /// One row per pulse.                              in English, then in Chinese
/// Pulses arrow "pulses" json "pulse", |cx, one: &Pulse| {
///     /// number of the pulse, from 1                 the same; without it that of `MEANINGS` is meant
///     pulse: U64 = one.number;
///     node: U8 or null = one.node;                    may be null
///     width as "width_us": U32 = one.width;           the key in JSON is another one
///     raw: U64 in arrow = one.raw;                    `in json`, `in csv`: only there
///     holes: List in optional = one.holes();          in JSON, where there is some value
///     rest: Members in members = |out| ..;            members of the JSON object with their keys
/// } csv [pulse, node]                                 in the order of CSV; of `[[..] [..]]` `csv_head` writes the first
/// ```
///
/// `|cx (()), ..|`: the columns need no [`Cx`]. Without `arrow` there is no table; with `object` in place of `json` the JSON object has no `kind`.
macro_rules! table {
    (
        #[doc = $en:literal] #[doc = $zh:literal]
        $table:ident $(arrow $arrow:literal)? $(json $json:literal)? $(object $object:literal)?,
        |$cx:ident $(($context:ty))?, $one:ident: $record:ty| $rows:tt $(csv $cells:tt)?
    ) => {
        $crate::tables::table::table! { @type ($($arrow)?) ($($context)?) $table $cx $one $record; $rows }
        $crate::tables::table::table! { @json ($($json)?) ($($object)?) $table $cx $one $record; $rows }
        $($crate::tables::table::table! { @csv $table $cx $one $record; $cells $rows })?
        $crate::tables::table::table! {
            @schema $table ($($arrow)?) [concat!($($arrow)?), concat!($($json)? $($object)?), $en, $zh] ($($cells)?) $rows
        }
    };
    (@type () () $table:ident $($rest:tt)*) => {
        /// The record.
        pub(in crate::tables) enum $table {}
    };
    (@context) => { &$crate::tables::table::Cx<'_> };
    (@context $context:ty) => { $context };
    (@type ($name:literal) ($($context:ty)?) $table:ident $cx:ident $one:ident $record:ty; {$(
        $(#[doc = $doc:literal])* $column:ident $(as $key:literal)?: $kind:ident $(or $null:ident)? $(in $sink:ident)?
            = $value:expr;
    )*}) => {
        /// The columns.
        #[derive(Debug)]
        pub(in crate::tables) struct $table {
            $($column: $crate::tables::table::table!(@builder ($($sink)?) $kind),)*
        }

        impl Default for $table {
            fn default() -> Self {
                Self { $($column: $crate::tables::table::table!(@arrow ($($sink)?) {
                    $crate::tables::columns::column::Column::empty()
                } else {}),)* }
            }
        }

        impl $crate::tables::columns::column::Columns for $table {
            fn fields(&self) -> Vec<arrow_schema::Field> {
                let mut all = Vec::new();
                $($crate::tables::table::table!(@arrow ($($sink)?) {
                    let name = $crate::tables::table::table!(@name $column ($($sink)?) $($key)?);
                    all.push($crate::tables::table::field::<$kind>(name, !stringify!($($null)?).is_empty()));
                } else {});)*
                all
            }

            fn arrays(&mut self) -> Vec<arrow_array::ArrayRef> {
                let mut all = Vec::new();
                $($crate::tables::table::table!(@arrow ($($sink)?) {
                    all.push($crate::tables::columns::column::Column::take(&mut self.$column));
                } else {
                    let () = self.$column;
                });)*
                all
            }
        }

        impl $crate::tables::columns::column::Append<$crate::tables::table::table!(@context $($context)?), $record>
            for $table
        {
            fn append(
                &mut self,
                $cx: $crate::tables::table::table!(@context $($context)?),
                $one: $record,
            ) -> usize {
                let _ = $cx;
                let mut bytes = 0;
                $($crate::tables::table::table!(@arrow ($($sink)?) {
                    bytes += <$kind as $crate::tables::table::Stored<_>>::append(&mut self.$column, $value);
                } else {});)*
                bytes
            }
        }

        impl $crate::tables::columns::column::Named for $table {
            const NAME: &'static str = $name;
        }
    };
    (@builder (json) $kind:ident) => { () };
    (@builder (optional) $kind:ident) => { () };
    (@builder (members) $kind:ident) => { () };
    (@builder (csv) $kind:ident) => { () };
    (@builder ($($sink:ident)?) $kind:ident) => { <$kind as $crate::tables::table::InArrow>::Builder };
    (@arrow (json) $then:tt else $otherwise:tt) => { $otherwise };
    (@arrow (optional) $then:tt else $otherwise:tt) => { $otherwise };
    (@arrow (members) $then:tt else $otherwise:tt) => { $otherwise };
    (@arrow (csv) $then:tt else $otherwise:tt) => { $otherwise };
    (@arrow ($($sink:ident)?) $then:tt else $otherwise:tt) => { $then };
    (@name $column:ident (arrow) $key:literal) => { $key };
    (@name $column:ident ($($sink:ident)?) $($key:literal)?) => { stringify!($column) };
    (@json () () $($rest:tt)*) => {};
    (@json ($kind:literal) () $($rest:tt)*) => {
        $crate::tables::table::table! { @json concat!("{\"kind\":\"", $kind, "\""), $($rest)* }
    };
    (@json () ($object:literal) $($rest:tt)*) => { $crate::tables::table::table! { @json "", $($rest)* } };
    (@json $head:expr, $table:ident $cx:ident $one:ident $record:ty; {$(
        $(#[doc = $doc:literal])* $column:ident $(as $key:literal)?: $kind:ident $(or $null:ident)? $(in $sink:ident)?
            = $value:expr;
    )*}) => {
        impl $table {
            /// Appends the record as a JSON object.
            pub(in crate::tables) fn json(
                out: &mut Vec<u8>,
                $cx: &$crate::tables::table::Cx<'_>,
                $one: $record,
            ) {
                let start = out.len();
                out.extend_from_slice($head.as_bytes());
                $($crate::tables::table::table!(@member out $cx ($($sink)?) $kind
                    ($crate::tables::table::table!(@key $column $($key)?)) $value);)*
                // Without a kind a comma is before the first key.
                if let Some(first) = out.get_mut(start) {
                    *first = b'{';
                }
                out.push(b'}');
            }
        }
    };
    (@key $column:ident) => { concat!(",\"", stringify!($column), "\":") };
    (@key $column:ident $key:literal) => { concat!(",\"", $key, "\":") };
    (@member $out:ident $cx:ident (arrow) $($rest:tt)*) => {};
    (@member $out:ident $cx:ident (csv) $($rest:tt)*) => {};
    (@member $out:ident $cx:ident (members) $kind:ident ($key:expr) $value:expr) => {
        <$kind as $crate::tables::table::ColumnKind<_>>::json($out, $cx, $value)
    };
    (@member $out:ident $cx:ident (optional) $kind:ident ($key:expr) $value:expr) => {
        if let Some(value) = $value {
            $out.extend_from_slice($key.as_bytes());
            <$kind as $crate::tables::table::ColumnKind<_>>::json($out, $cx, value);
        }
    };
    (@member $out:ident $cx:ident ($($json:ident)?) $kind:ident ($key:expr) $value:expr) => {{
        $out.extend_from_slice($key.as_bytes());
        <$kind as $crate::tables::table::ColumnKind<_>>::json($out, $cx, $value);
    }};
    (@csv $table:ident $cx:ident $one:ident $record:ty; [$($cell:ident),* $(,)?] $rows:tt) => {
        $crate::tables::table::table! { @cells HEADINGS $table [$($cell),*] $rows }
        $crate::tables::table::table! { @cells csv $table $cx $one $record; [$($cell),*] b'\n'; $rows }
    };
    (@csv $table:ident $cx:ident $one:ident $record:ty; [[$($head:ident),*] [$($cell:ident),*]] $rows:tt) => {
        $crate::tables::table::table! { @cells HEADINGS $table [$($head,)* $($cell),*] $rows }
        $crate::tables::table::table! { @cells csv_head $table $cx $one $record; [$($head),*] b','; $rows }
        $crate::tables::table::table! { @cells csv $table $cx $one $record; [$($cell),*] b'\n'; $rows }
    };
    (@cells HEADINGS $table:ident [$($cell:ident),*] {$(
        $(#[doc = $doc:literal])* $column:ident $(as $key:literal)?: $kind:ident $(or $null:ident)? $(in $sink:ident)?
            = $value:expr;
    )*}) => {
        impl $table {
            /// The headings of its CSV.
            pub(in crate::tables) const HEADINGS: &[&str] = {
                macro_rules! heading {
                    $(($column) => { $crate::tables::table::table!(@heading $column $($key)?) };)*
                }
                &[$(heading!($cell)),*]
            };
        }
    };
    (@cells $name:ident $table:ident $cx:ident $one:ident $record:ty; [$($cell:ident),*] $end:literal; {$(
        $(#[doc = $doc:literal])* $column:ident $(as $key:literal)?: $kind:ident $(or $null:ident)? $(in $sink:ident)?
            = $value:expr;
    )*}) => {
        impl $table {
            /// Appends cells of a row of CSV.
            pub(in crate::tables) fn $name(
                out: &mut Vec<u8>,
                $cx: &$crate::tables::table::Cx<'_>,
                $one: $record,
            ) {
                macro_rules! cell {
                    $(($column) => { <$kind as $crate::tables::table::ColumnKind<_>>::csv(out, $cx, $value) };)*
                }
                $(cell!($cell); out.push(b',');)*
                out.pop();
                out.push($end);
            }
        }
    };
    (@heading $column:ident) => { stringify!($column) };
    (@heading $column:ident $key:literal) => { $key };
    (@schema $table:ident $arrow:tt $head:tt ($($cells:tt)?) {$(
        $(#[doc = $doc:literal])* $column:ident $(as $key:literal)?: $kind:ident $(or $null:ident)? $(in $sink:ident)?
            = $value:expr;
    )*}) => {
        impl $table {
            /// Appends its part of the schema.
            pub(in crate::tables) fn schema(out: &mut Vec<u8>) {
                let rows = [$($crate::tables::table::Row {
                    name: stringify!($column),
                    key: concat!($($key)?),
                    sink: stringify!($($sink)?),
                    is_null: !stringify!($($null)?).is_empty(),
                    json: <$kind as $crate::tables::table::InJson>::JSON,
                    arrow: $crate::tables::table::table!(@stored $arrow ($($sink)?) {
                        Some($crate::tables::table::field::<$kind>(stringify!($column), false))
                    }),
                    documentation: &[$($doc),*],
                }),*];
                let headings = $crate::tables::table::table!(@headings $($cells)?);
                $crate::tables::table::schema(out, $head, headings, &rows);
            }
        }
    };
    (@stored () $sink:tt $then:tt) => { None };
    (@stored $arrow:tt $sink:tt $then:tt) => {
        $crate::tables::table::table!(@arrow $sink $then else { None })
    };
    (@headings) => { &[] };
    (@headings $cells:tt) => { Self::HEADINGS };
}
pub(super) use table;

/// Returns the Arrow field of a column.
pub(super) fn field<K: InArrow>(name: &str, is_null: bool) -> Field {
    let name = [name.trim_start_matches("r#"), K::SUFFIX].concat();
    Field::new(name, K::Builder::data_type(), is_null)
}

/// A column in the schema.
pub(super) struct Row<'a> {
    pub(super) name: &'a str,
    /// The key in JSON, or the name of the Arrow column where that is all; empty where `name` is it.
    pub(super) key: &'a str,
    pub(super) sink: &'a str,
    pub(super) is_null: bool,
    pub(super) json: &'a str,
    pub(super) arrow: Option<Field>,
    /// In English, then in Chinese; nothing where it is one of [`MEANINGS`].
    pub(super) documentation: &'a [&'a str],
}

/// Appends the schema of a record: `table` and `kind` are null where there is none; a column has a `column` and an
/// `arrow` type where it is in the table, a `key` and a `json` type where it is in the object.
pub(super) fn schema(out: &mut Vec<u8>, [table, kind, en, zh]: [&str; 4], csv: &[&str], rows: &[Row<'_>]) {
    let text = |out: &mut Vec<u8>, key: &str, text: &str| {
        put!(out; key);
        match text {
            "" => put!(out; "null"),
            text => escape::json(out, text.trim().as_bytes()),
        }
    };
    text(out, "{\"table\":", table);
    text(out, ",\"kind\":", kind);
    text(out, ",\"en\":", en);
    text(out, ",\"zh\":", zh);
    put!(out; ",\"csv\":");
    list(out, csv, |out, heading| text(out, "", heading));
    put!(out; ",\"columns\":");
    list(out, rows.iter().filter(|row| row.sink != "csv"), |out, row| {
        let name = row.name.trim_start_matches("r#");
        let named = if row.key.is_empty() { name } else { row.key };
        let common =
            MEANINGS.iter().find(|meaning| meaning.0 == named).map_or(["", ""], |meaning| [meaning.1, meaning.2]);
        let meaning = |place: usize| {
            let own = row.documentation.get(place).copied();
            own.or(common.get(place).copied()).unwrap_or_default()
        };
        let arrow = row.arrow.as_ref();
        let column = arrow.map_or("", |field| if row.sink == "arrow" { named } else { field.name() });
        text(out, "{\"column\":", column);
        text(out, ",\"arrow\":", &arrow.map_or(String::new(), |field| type_name(field.data_type())));
        text(
            out,
            ",\"key\":",
            if row.sink == "arrow" || row.sink == "members" && row.key.is_empty() { "" } else { named },
        );
        text(out, ",\"json\":", if row.sink == "arrow" { "" } else { row.json });
        let truth = |yes: bool| if yes { "true" } else { "false" };
        put!(out; ",\"nullable\":", truth(row.is_null), ",\"optional\":", truth(row.sink == "optional"));
        text(out, ",\"en\":", meaning(0));
        text(out, ",\"zh\":", meaning(1));
        put!(out; "}");
    });
    put!(out; "}");
}

fn type_name(data_type: &DataType) -> String {
    match data_type {
        DataType::Dictionary(..) | DataType::Utf8 => "string".to_owned(),
        DataType::Boolean => "bool".to_owned(),
        DataType::List(field) => format!("list of {}", type_name(field.data_type())),
        other => format!("{other:?}").to_lowercase(),
    }
}

/// The documentation of columns that many records have.
const MEANINGS: &[(&str, &str, &str)] = &[
    ("frame", "number of the frame, from 1", "帧号，从1起"),
    ("line", "line of the file; empty in binary formats", "文件的行号；二进制格式为空"),
    ("file", "name of the file", "文件名"),
    ("t", "timestamp", "时间戳"),
    ("bus", "bus; empty where the capture names none", "总线名；记录中没有时为空"),
    ("node", "node-ID; empty where it is about no node", "节点ID；与节点无关时为空"),
    ("cycle", "number of the SYNC cycle, from 1", "同步周期的编号，从1起"),
    ("index", "index of the object", "对象索引"),
    ("sub", "sub-index", "子索引"),
    ("object", "object, as 1008:00", "对象，如 1008:00"),
    ("name", "name", "名称"),
    ("type", "data type", "数据类型"),
    ("data", "data bytes", "数据字节"),
    ("value", "value, scaled", "换算后的值"),
    ("integer", "value as a signed integer", "值：有符号整数"),
    ("raw", "value as an unsigned number, not scaled", "未换算的无符号值"),
    ("unit", "unit", "单位"),
    ("text", "in words", "文字说明"),
    ("message", "in words", "文字说明"),
    ("facts", "its figures, as JSON", "数值，JSON"),
    ("pdo", "PDO, as TPDO1", "PDO，如 TPDO1"),
    ("service", "service: nmt, sync, pdo, sdo, ...", "服务：nmt、sync、pdo、sdo等"),
    ("severity", "error, warning or info", "error、warning、info"),
    ("source", "the kind of message it comes from", "状态由什么报文得出；log里为来源"),
    ("transfer", "number of the transfer, from 1", "传输编号，从1起"),
    ("findings", "codes of its findings", "相关规则的代码"),
    (
        "provenance",
        "where the mapping comes from: observed (written by SDO), else a description or an option",
        "映射的来源：observed 由SDO写入得出，其余来自设备描述或选项",
    ),
];

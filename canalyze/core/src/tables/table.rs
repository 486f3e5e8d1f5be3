//! Tables: the columns of a record, declared once; JSON lines, Arrow, CSV, the documentation and the schema follow.
//!
//! A row of [`table!`] is a column: its documentation, its name, its kind, and the expression that reads it off the
//! record. The kind knows how a value is written in JSON and CSV, and which Arrow column holds it.
//!
//! Everything that a declaration names is here. [`values`] is how each kind is written, [`schema`] the documentation
//! that follows. Must not: know a record.

use std::borrow::Cow;

use arrow_array::builder::{BinaryBuilder, BooleanBuilder, ListBuilder, StringBuilder};
use arrow_array::types::{Float64Type, Int64Type, UInt8Type, UInt16Type, UInt32Type, UInt64Type};

use super::columns::column::{Column, Numbers, Words};
use super::csv;
use super::setting::Setting;
use crate::sdo::wire::Mux;
use crate::words::{Lang, value};
use crate::world::dictionary::Described;

pub(super) mod schema;
mod values;

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
/// } csv [pulse, node]                                 in the order of CSV; of `[{first: ..} [..]]` `first` writes some
///   parts { head [pulse, node] tail [width] }         a function for each part of the JSON object, in place of one for all
/// ```
///
/// `|cx (()), ..|`: the columns need no [`Cx`]. Without `arrow` there is no table; with `object` in place of `json` the JSON object has no `kind`.
macro_rules! table {
    (
        #[doc = $en:literal] #[doc = $zh:literal]
        $table:ident $(arrow $arrow:literal)? $(json $json:literal)? $(object $object:literal)?,
        |$cx:ident $(($context:ty))?, $one:ident: $record:ty| $rows:tt $(csv $cells:tt)? $(parts $parts:tt)?
    ) => {
        $crate::tables::table::table! { @type ($($arrow)?) ($($context)?) $table $cx $one $record; $rows }
        $crate::tables::table::table! { @json ($($json)?) ($($object)?) ($($parts)?) $table $cx $one $record; $rows }
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
                    all.push($crate::tables::table::schema::field::<$kind>(name, !stringify!($($null)?).is_empty()));
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
    (@json () () () $($rest:tt)*) => {};
    (@json ($kind:literal) () ({$($part:ident $members:tt)*}) $table:ident $cx:ident $one:ident $record:ty; $rows:tt) => {
        impl $table {
            /// The beginning of its JSON object.
            pub(in crate::tables) const HEAD: &str = concat!("{\"kind\":\"", $kind, "\"");
        }
        $($crate::tables::table::table! { @part $part $members $table $cx $one $record; $rows })*
    };
    (@part $part:ident [$($member:ident),*] $table:ident $cx:ident $one:ident $record:ty; {$(
        $(#[doc = $doc:literal])* $column:ident $(as $key:literal)?: $kind:ident $(or $null:ident)? $(in $sink:ident)?
            = $value:expr;
    )*}) => {
        impl $table {
            /// Appends a part of the record to its JSON object.
            pub(in crate::tables) fn $part(
                out: &mut Vec<u8>,
                $cx: &$crate::tables::table::Cx<'_>,
                $one: $record,
            ) {
                let _ = &$one;
                macro_rules! member {
                    $(($column) => { $crate::tables::table::table!(@member out $cx ($($sink)?) $kind
                        ($crate::tables::table::table!(@key $column $($key)?)) $value) };)*
                }
                $(member!($member);)*
            }
        }
    };
    (@json ($kind:literal) () () $($rest:tt)*) => {
        $crate::tables::table::table! { @json concat!("{\"kind\":\"", $kind, "\""), $($rest)* }
    };
    (@json () ($object:literal) () $($rest:tt)*) => { $crate::tables::table::table! { @json "", $($rest)* } };
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
    (@csv $table:ident $cx:ident $one:ident $record:ty; [$({$part:ident: $($head:ident),*})* [$($cell:ident),*]] $rows:tt) => {
        $crate::tables::table::table! { @cells HEADINGS $table [$($($head,)*)* $($cell),*] $rows }
        $($crate::tables::table::table! { @cells $part $table $cx $one $record; [$($head),*] b','; $rows })*
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
                let rows = [$($crate::tables::table::schema::Row {
                    name: stringify!($column),
                    key: concat!($($key)?),
                    sink: stringify!($($sink)?),
                    is_null: !stringify!($($null)?).is_empty(),
                    json: <$kind as $crate::tables::table::InJson>::JSON,
                    arrow: $crate::tables::table::table!(@stored $arrow ($($sink)?) {
                        Some($crate::tables::table::schema::field::<$kind>(stringify!($column), false))
                    }),
                    documentation: &[$($doc),*],
                }),*];
                let headings = $crate::tables::table::table!(@headings $($cells)?);
                $crate::tables::table::schema::schema(out, $head, headings, &rows);
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

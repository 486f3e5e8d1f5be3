//! What a finding may have measured, and the kinds by which a variant's facts are declared.
//!
//! A kind says which Rust type a check hands over, and which quantity that is; the quantity says how it is printed and
//! what it is in JSON.

use std::sync::Arc;

use super::Words;
use crate::bytes::frame::CanId;
use crate::sdo::wire::{self, Mux};
use crate::words::profiles::Profile;

/// Something measured or expected. Its kind says how it is printed and what it is in JSON.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Quantity {
    /// Unused.
    Nothing,
    /// A number.
    Count(u64),
    /// A number with sign.
    Signed(i64),
    /// A time or a difference of times in ns; words choose a unit, JSON has ns.
    Ns(i64),
    /// Two hexadecimal digits.
    Hex2(u8),
    /// Four hexadecimal digits.
    Hex4(u16),
    /// Eight hexadecimal digits.
    Hex8(u32),
    /// An object: `1800h:01`.
    Object(Mux),
    /// A CAN identifier.
    Id(CanId),
    /// An NMT state as error control carries it: 00, 04, 05, 7F.
    State(u8),
    /// An NMT command specifier: 01, 02, 80, 81, 82.
    Command(u8),
    /// A PDO: whether it is a TPDO, and its number.
    Pdo(bool, u16),
    /// A CiA 402 statusword: words name its state.
    Statusword(u16),
    /// A CiA 402 controlword: words name its command.
    Controlword(u16),
    /// A CiA 402 mode of operation.
    Mode(i8),
    /// An LSS command specifier: words name it.
    Lss(u8),
    /// An error code of an LSS slave, with the command specifier that it answers: words name it.
    LssError(u8, u8),
    /// An emergency error code.
    Emcy(u16, Profile),
    /// A data type code (CiA 301, 7.4.7).
    Type(u16),
    /// A state of CiA 402's power drive system, as a statusword that says it: words name it.
    Drive(u16),
    /// An SDO abort code: words name it.
    Abort(u32),
    /// A side of an SDO channel.
    Side(wire::Side),
    /// A number of bytes; words have the unit.
    Size(u64),
    /// What a wrong CRC would be right for; a clause of the sentence, or nothing.
    Crc(CrcMatch),
}

/// What a wrong CRC would be right for: it tells an engineer where the fault is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CrcMatch {
    /// Nothing known.
    Nothing,
    /// The data with the padding of the last segment.
    WithPadding,
    /// The right polynomial with initial value FFFFh (CCITT-FALSE).
    InitialFfff,
    /// The reflected variant (KERMIT).
    Reflected,
}

/// What went wrong, in short.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Problem {
    /// Its kind, as machine output has it.
    pub name: &'static str,
    /// What it is, in words.
    pub words: Words,
    /// The node, where it is about one that is not named before.
    pub node: Option<u8>,
    /// The frame at which it begins.
    pub frame: u64,
}

/// Something expected or found.
#[derive(Clone, Debug, PartialEq)]
pub enum Said {
    /// As other rules measure it.
    Quantity(Quantity),
    /// A number with a fraction.
    Real(f64),
    /// A truth value.
    Bool(bool),
    /// Text of the capture or of an expectation; to be escaped.
    Text(Arc<str>),
    /// Bytes.
    Bytes(Arc<[u8]>),
    /// A word of the rule's sentence, the same in JSON: it is not shown to people.
    Word(&'static str),
    /// What went wrong, and how many more there are that are not named.
    Problems(Arc<[Problem]>, u64),
}

impl From<Quantity> for Said {
    fn from(quantity: Quantity) -> Self {
        Self::Quantity(quantity)
    }
}

/// A kind of fact.
pub trait Kind {
    /// What a check hands over.
    type Value;
    /// What the finding holds: a [`Quantity`], or [`Said`] where only expectations have it.
    type Held;
    /// It stands in the sentence, not only in JSON.
    const SPOKEN: bool = true;

    /// What the finding holds of a value.
    fn of(value: Self::Value) -> Self::Held;
}

/// Kinds that are called as the quantity or text that they become.
macro_rules! kinds {
    ($held:ident: $($kind:ident($($value:ty),+))*) => {$(
        #[doc = concat!("As [`", stringify!($held), "::", stringify!($kind), "`].")]
        #[derive(Debug)]
        pub enum $kind {}

        impl Kind for $kind {
            type Value = kinds!(@value $($value),+);
            type Held = $held;

            fn of(value: Self::Value) -> Self::Held {
                kinds!(@held $held::$kind, value, $($value),+)
            }
        }
    )*};
    (@value $one:ty) => { $one };
    (@value $one:ty, $two:ty) => { ($one, $two) };
    (@held $made:path, $from:ident, $one:ty) => { $made($from) };
    (@held $made:path, $from:ident, $one:ty, $two:ty) => { $made($from.0, $from.1) };
}

kinds! {
    Quantity: Count(u64) Ns(i64) Hex2(u8) Hex4(u16) Hex8(u32) Object(Mux) Id(CanId) State(u8) Command(u8) Pdo(bool, u16)
    Statusword(u16) Controlword(u16) Mode(i8) Lss(u8) LssError(u8, u8) Emcy(u16, Profile) Type(u16) Abort(u32) Side(wire::Side)
    Size(u64) Crc(CrcMatch)
}

kinds! {
    Said: Real(f64) Text(Arc<str>) Word(&'static str) Problems(Arc<[Problem]>, u64)
}

/// A bit, as the number 0 or 1.
#[derive(Debug)]
pub enum Bit {}

impl Kind for Bit {
    type Value = bool;
    type Held = Quantity;

    fn of(value: bool) -> Quantity {
        Quantity::Count(value.into())
    }
}

/// Of a kind that only the check knows.
impl Kind for Quantity {
    type Value = Self;
    type Held = Self;

    fn of(value: Self) -> Self {
        value
    }
}

/// Of a kind that only the expectation knows.
impl Kind for Said {
    type Value = Self;
    type Held = Self;

    fn of(value: Self) -> Self {
        value
    }
}

/// It may not be known.
impl<K: Kind<Held = Quantity>> Kind for Option<K> {
    type Value = Option<K::Value>;
    type Held = Quantity;
    const SPOKEN: bool = K::SPOKEN;

    fn of(value: Self::Value) -> Quantity {
        value.map_or(Quantity::Nothing, K::of)
    }
}

/// For JSON only: no sentence says it.
#[derive(Debug)]
pub struct JsonOnly<K>(std::marker::PhantomData<K>);

impl<K: Kind> Kind for JsonOnly<K> {
    type Value = K::Value;
    type Held = K::Held;
    const SPOKEN: bool = false;

    fn of(value: Self::Value) -> Self::Held {
        K::of(value)
    }
}

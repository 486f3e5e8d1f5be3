//! The quantities that a finding may measure, and the kinds by which a variant's facts are declared.
//!
//! A kind defines the Rust type that a check hands over and the quantity that it becomes. The quantity defines how it
//! is printed and its form in JSON.

use std::sync::Arc;

use super::Words;
use crate::bytes::frame::CanId;
use crate::bytes::ns::Ns;
use crate::sdo::abort_code::AbortCode;
use crate::sdo::wire::{self, Mux};
use crate::words::profiles::Profile;

/// A measured or expected quantity. Its kind defines how it is printed and its form in JSON.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Quantity {
    /// Unused.
    Nothing,
    /// A number.
    Count(u64),
    /// A signed number.
    Signed(i64),
    /// A time or a difference of times in ns. Sentences choose a unit, JSON has ns.
    Ns(Ns),
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
    /// An NMT state in the encoding of error control: 00, 04, 05, 7F.
    State(u8),
    /// An NMT command specifier: 01, 02, 80, 81, 82.
    Command(u8),
    /// A PDO: true for a TPDO, and its number.
    Pdo(bool, u16),
    /// A CiA 402 statusword, printed with its state.
    Statusword(u16),
    /// A CiA 402 controlword, printed with its command.
    Controlword(u16),
    /// A CiA 402 mode of operation.
    Mode(i8),
    /// An LSS command specifier, printed with its name.
    Lss(u8),
    /// An error code of an LSS slave with the command specifier that it answers, printed with its name.
    LssError(u8, u8),
    /// An emergency error code.
    Emcy(u16, Profile),
    /// A data type code (CiA 301, 7.4.7).
    Type(u16),
    /// A state of CiA 402's power drive system in the form of a statusword, printed with its name.
    Drive(u16),
    /// An SDO abort code, printed with its name.
    Abort(AbortCode),
    /// A side of an SDO channel.
    Side(wire::Side),
    /// A number of bytes, printed with the unit.
    Size(u64),
    /// The data that a wrong CRC would match; a clause of the sentence, or nothing.
    Crc(CrcMatch),
}

/// The data or variant of the algorithm that a wrong CRC would match, as a hint to the location of the fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CrcMatch {
    /// None known.
    Nothing,
    /// The data with the padding of the last segment.
    WithPadding,
    /// The right polynomial with initial value FFFFh (CCITT-FALSE).
    InitialFfff,
    /// The reflected variant (KERMIT).
    Reflected,
}

/// A problem in short.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NamedProblem {
    /// Its kind in machine output.
    pub name: &'static str,
    /// Its kind in words.
    pub words: Words,
    /// The node, if it is about one that has not been named.
    pub node: Option<u8>,
    /// The frame at which it begins.
    pub frame: u64,
}

/// An expected or found value.
#[derive(Clone, Debug, PartialEq)]
pub enum Said {
    /// A quantity as in other rules.
    Quantity(Quantity),
    /// A number with a fraction.
    Real(f64),
    /// A truth value.
    Bool(bool),
    /// Text of the capture or of an expectation; to be escaped.
    Text(Arc<str>),
    /// Bytes.
    Bytes(Arc<[u8]>),
    /// A word of the rule's sentence, the same in JSON; not shown to people.
    Word(&'static str),
    /// Problems, and the number of further ones that are not named.
    Problems(Arc<[NamedProblem]>, u64),
}

impl From<Quantity> for Said {
    fn from(quantity: Quantity) -> Self {
        Self::Quantity(quantity)
    }
}

/// A kind of fact.
pub trait FactKind {
    /// The type that a check hands over.
    type Value;
    /// The type that the finding holds: a [`Quantity`], or [`Said`] for facts of expectations only.
    type Held;
    /// It is part of the sentence, not only of JSON.
    const SPOKEN: bool = true;

    /// Returns the form of a value that the finding holds.
    fn of(value: Self::Value) -> Self::Held;
}

/// Declares kinds that have the name of the quantity or text that they become.
macro_rules! kinds {
    ($held:ident: $($kind:ident($($value:ty),+))*) => {$(
        #[doc = concat!("As [`", stringify!($held), "::", stringify!($kind), "`].")]
        #[derive(Debug)]
        pub enum $kind {}

        impl FactKind for $kind {
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
    Quantity: Count(u64) Hex2(u8) Hex4(u16) Hex8(u32) Object(Mux) Id(CanId) State(u8) Command(u8) Pdo(bool, u16)
    Statusword(u16) Controlword(u16) Mode(i8) Lss(u8) LssError(u8, u8) Emcy(u16, Profile) Type(u16) Abort(AbortCode) Side(wire::Side)
    Size(u64) Crc(CrcMatch)
}

kinds! {
    Said: Real(f64) Text(Arc<str>) Word(&'static str) Problems(Arc<[NamedProblem]>, u64)
}

impl FactKind for Ns {
    type Value = Self;
    type Held = Quantity;

    fn of(value: Self) -> Quantity {
        Quantity::Ns(value)
    }
}

/// A bit: the number 0 or 1.
#[derive(Debug)]
pub enum Bit {}

impl FactKind for Bit {
    type Value = bool;
    type Held = Quantity;

    fn of(value: bool) -> Quantity {
        Quantity::Count(value.into())
    }
}

/// A quantity whose kind is known only to the check.
impl FactKind for Quantity {
    type Value = Self;
    type Held = Self;

    fn of(value: Self) -> Self {
        value
    }
}

/// A value whose kind is known only to the expectation.
impl FactKind for Said {
    type Value = Self;
    type Held = Self;

    fn of(value: Self) -> Self {
        value
    }
}

/// A fact that may be unknown.
impl<K: FactKind<Held = Quantity>> FactKind for Option<K> {
    type Value = Option<K::Value>;
    type Held = Quantity;
    const SPOKEN: bool = K::SPOKEN;

    fn of(value: Self::Value) -> Quantity {
        value.map_or(Quantity::Nothing, K::of)
    }
}

/// A fact for JSON only, not part of a sentence.
#[derive(Debug)]
pub struct JsonOnly<K>(std::marker::PhantomData<K>);

impl<K: FactKind> FactKind for JsonOnly<K> {
    type Value = K::Value;
    type Held = K::Held;
    const SPOKEN: bool = false;

    fn of(value: Self::Value) -> Self::Held {
        K::of(value)
    }
}

//! The sentences of problems and their steps, and the first things to check, in both languages.
//!
//! A sentence is declared with its facts like those of rules; an unknown name in braces does not compile. Times called
//! `at` count from the first frame of the capture.

use crate::bytes::ns::Ns;
use crate::rules::quantity::{Abort, Command, Count, Emcy, Hex2, Hex8, Id, Object, Pdo, State, Statusword};
use crate::rules::rules;
use crate::rules::{Measured, Variant, Words};

macro_rules! sayings {
    ($($saying:ident $({ $($fact:ident: $kind:ty),+ })? $zh:literal $en:literal;)*) => {
        /// A sentence with its facts.
        #[derive(Clone, Debug, PartialEq)]
        pub enum Saying {
            $(
                #[doc = $en]
                $saying $({ $(#[doc = stringify!($kind)] $fact: <$kind as crate::rules::FactKind>::Value),+ })?,
            )*
        }

        $(const _: () = rules!(@variant $zh, $en, [], [$($($fact: $kind),+)?]).check();)*

        impl From<Saying> for Measured {
            fn from(what: Saying) -> Self {
                match what {$(
                    Saying::$saying $({ $($fact),+ })? => {
                        const VARIANT: &crate::rules::Variant = &rules!(@variant $zh, $en, [], [$($($fact: $kind),+)?]);
                        Self::new(VARIANT, [$($(<$kind as crate::rules::FactKind>::of($fact)),+)?])
                    }
                )*}
            }
        }
    };
}

include!(concat!(env!("OUT_DIR"), "/sayings.rs"));

macro_rules! titles {
    ($($title:ident $({ $($fact:ident: $kind:ty),+ })? $zh:literal $en:literal;)*) => {$(
        #[doc = $en]
        pub(in crate::problems) static $title: Variant = rules!(@variant $zh, $en, [], [$($($fact: $kind),+)?]);
        const _: () = rules!(@variant $zh, $en, [], [$($($fact: $kind),+)?]).check();
    )*};
}

/// The titles by the names that the table of kinds has for them.
#[allow(non_upper_case_globals)]
pub(super) mod title {
    use super::*;

    include!(concat!(env!("OUT_DIR"), "/titles.rs"));
}

/// One of the first things to check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Check {
    /// The word in machine output.
    pub name: &'static str,
    /// The text for people.
    pub words: Words,
}

macro_rules! checks {
    ($($(#[$doc:meta])* $check:ident $name:literal $zh:literal $en:literal;)*) => {
        $(#[doc = $en] pub const $check: Check = Check { name: $name, words: Words { zh: $zh, en: $en } };)*
    };
}

include!(concat!(env!("OUT_DIR"), "/checks.rs"));

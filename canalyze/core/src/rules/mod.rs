//! The rules, one file a family. Everything about a rule is declared in one place.
//!
//! A rule has a code, a name, a default severity, the clause that it rests on, the frames that give its findings their
//! context, an explanation in Chinese and English, and variants: the facts that a finding measures and the sentence
//! that states them. A rule is added in its family's file and in the list below, with a sample that raises it. Rules
//! are not judged here, and sentences are not filled or printed here.
//!
//! Severities are on one scale. An error is a frame that its receiver cannot have understood, or a loss. A warning is
//! against the standard or the configuration. An info is worth knowing.

mod facts;
pub mod finding;
pub(crate) mod quantity;

pub mod bus;
pub mod capture;
pub mod description;
pub mod drive;
pub mod emcy;
pub mod expectation;
pub mod guarding;
pub mod heartbeat;
pub mod lss;
pub mod nmt;
pub mod pdo;
pub mod sdo;
pub mod srdo;
pub mod sync;
pub mod time;

pub use facts::{Deviation, Fact, Facts, Measured, Unmet, Variant, Verdict, Words};
pub use quantity::{CrcMatch, FactKind, JsonOnly, NamedProblem, Quantity, Said};

pub(crate) use facts::plain;

/// The severity of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Worth knowing; normal traffic may show it.
    Info,
    /// Suspicious: an engineer should look.
    Warning,
    /// The standard is violated.
    Error,
}

/// Every severity, from the least to the greatest.
pub const SEVERITIES: &[Severity] = &[Severity::Info, Severity::Warning, Severity::Error];

impl Severity {
    /// The word in machine output.
    pub fn name(self) -> &'static str {
        match self {
            Self::Info => "info",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

/// Families of frames that are kept together to show the context of a finding. Families up to `Srdo` are kept by node,
/// the others by bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// SDO.
    Sdo,
    /// PDO.
    Pdo,
    /// Boot-up, heartbeat, guarding.
    ErrorControl,
    /// EMCY.
    Emcy,
    /// SRDO.
    Srdo,
    /// Commands and elections: node control, fail-safe, flying master.
    Nmt,
    /// SYNC.
    Sync,
    /// TIME.
    Time,
    /// LSS.
    Lss,
    /// Error frames.
    Error,
    /// Anything else.
    Other,
}

/// A rule without its measured facts.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// The rule.
    pub code: Code,
    /// Its code as printed.
    pub id: &'static str,
    /// Its name in kebab-case.
    pub name: &'static str,
    /// Default severity.
    pub severity: Severity,
    /// The clause of the standard, or another basis.
    pub clause: &'static str,
    /// The frames that its findings are about. Empty for a rule about a file.
    pub context: &'static [Family],
    /// It is about one PDO: that of the finding's frame or of its cause.
    pub one_pdo: bool,
    /// Its findings are about their own frame, not about an earlier one that they name.
    pub about_here: bool,
    /// The statement in one line.
    pub message: Words,
    /// The meaning.
    pub meaning: Words,
    /// The usual cause.
    pub cause: Words,
    /// The sentences that findings may have instead of the message.
    pub variants: &'static [Variant],
}

/// Declares the rules of a family. Each becomes a type named by its code, with a variant for each of its sentences,
/// that converts to a verdict (or, for expectations, a deviation). A name in braces that is not a fact of the variant
/// does not compile, nor does a fact without a sentence, nor a missing language. Before its context a rule may be
/// marked `one` (see [`Rule::one_pdo`]) and `here` (see [`Rule::about_here`]). Its doc comment is its documentation, also
/// for users: the meaning in Chinese and in English, an empty line, the usual cause in Chinese and in English.
macro_rules! rules {
    ($target:ident: $(
        #[doc = $meaning_zh:literal]
        #[doc = $meaning_en:literal]
        #[doc = $between:literal]
        #[doc = $cause_zh:literal]
        #[doc = $cause_en:literal]
        $code:ident $id:literal $name:literal $severity:ident $clause:literal $($mark:ident)* [$($family:ident),*] {
            message $message_zh:literal $message_en:literal;
            $(
                $variant:ident $([$($word:ident = $constant:literal),+])? $({ $($fact:ident: $kind:ty),+ })?
                    $zh:literal $en:literal;
            )*
        }
    )*) => {$(
        #[doc = $meaning_en]
        #[doc = ""]
        #[doc = $cause_en]
        #[derive(Clone, Debug, PartialEq)]
        pub enum $code {
            $(
                #[doc = $en]
                $variant $({ $(#[doc = stringify!($kind)] $fact: <$kind as $crate::rules::FactKind>::Value),+ })?,
            )*
        }

        impl $code {
            pub(super) const RULE: &'static $crate::rules::Rule = &$crate::rules::Rule {
                code: $crate::rules::Code::$code,
                id: $id,
                name: $name,
                severity: $crate::rules::Severity::$severity,
                clause: $clause,
                context: &[$($crate::rules::Family::$family),*],
                one_pdo: $crate::rules::rules!(@one $($mark)*),
                about_here: $crate::rules::rules!(@here $($mark)*),
                message: $crate::rules::Words { zh: $message_zh, en: $message_en },
                meaning: $crate::rules::documented($meaning_zh, $meaning_en),
                cause: $crate::rules::documented($cause_zh, $cause_en),
                variants: &[$($crate::rules::rules!(
                    @variant $zh, $en, [$($($word = $constant),+)?], [$($($fact: $kind),+)?]
                )),*],
            };
        }

        $(const _: () = $crate::rules::rules!(
            @variant $zh, $en, [$($($word = $constant),+)?], [$($($fact: $kind),+)?]
        ).check();)*

        impl From<$code> for $target {
            fn from(what: $code) -> Self {
                match what {$(
                    $code::$variant $({ $($fact),+ })? => {
                        const VARIANT: &$crate::rules::Variant = &$crate::rules::rules!(
                            @variant $zh, $en, [$($($word = $constant),+)?], [$($($fact: $kind),+)?]
                        );
                        let facts = [$($(<$kind as $crate::rules::FactKind>::of($fact).into()),+)?];
                        Self::of($crate::rules::Code::$code, VARIANT, facts)
                    }
                )*}
            }
        }
    )*};
    (@one one) => { true };
    (@one one here) => { true };
    (@one $($here:ident)?) => { false };
    (@here here) => { true };
    (@here one here) => { true };
    (@here $($one:ident)?) => { false };
    (@variant $zh:literal, $en:literal, [$($word:ident = $constant:literal),*], [$($fact:ident: $kind:ty),*]) => {
        $crate::rules::Variant {
            constants: &[$((stringify!($word), stringify!($constant))),*],
            facts: &[$($crate::rules::Fact {
                name: $crate::rules::plain(stringify!($fact)),
                spoken: <$kind as $crate::rules::FactKind>::SPOKEN,
            }),*],
            words: $crate::rules::Words { zh: $zh, en: $en },
        }
    };
}
pub(crate) use rules;

/// Returns two lines of a doc comment without the blank that each begins with.
pub(crate) const fn documented(zh: &'static str, en: &'static str) -> Words {
    Words { zh: zh.trim_ascii_start(), en: en.trim_ascii_start() }
}

/// Declares the codes, from the files that hold their rules.
macro_rules! codes {
    ($($file:ident: $($code:ident)*;)*) => {
        /// The rules, by their code.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Code {
            $($(
                #[doc = concat!("See [`", stringify!($file), "::", stringify!($code), "`].")]
                $code,
            )*)*
        }

        /// All rules, in order of the code.
        pub static RULES: &[&Rule] = &[$($($file::$code::RULE,)*)*];

        impl Code {
            /// The rule.
            pub fn rule(self) -> &'static Rule {
                match self {
                    $($(Self::$code => $file::$code::RULE,)*)*
                }
            }
        }
    };
}

codes! {
    bus: Bus001 Bus002 Bus003 Bus004 Bus005 Bus006 Bus007 Bus008 Bus009;
    capture: Cap001 Cap002 Cap003 Cap004 Cap005 Cap006 Cap007 Cap008 Cap009;
    drive: Drv001 Drv002 Drv003 Drv004 Drv005;
    description: Eds001 Eds002 Eds003 Eds004 Eds005;
    emcy: Emc001 Emc002 Emc003 Emc004 Emc005 Emc006 Emc007 Emc008 Emc009 Emc010 Emc011;
    expectation: Exp001 Exp002 Exp003 Exp004 Exp005 Exp006 Exp007 Exp008 Exp009 Exp010 Exp011 Exp012 Exp013 Exp014
        Exp015 Exp016 Exp017 Exp018 Exp019 Exp020;
    guarding: Grd001 Grd002 Grd003 Grd004 Grd005;
    heartbeat: Hbt001 Hbt002 Hbt003 Hbt004 Hbt005 Hbt006 Hbt007;
    lss: Lss001 Lss002 Lss003 Lss004 Lss005 Lss006 Lss007 Lss008 Lss009 Lss010 Lss011 Lss012 Lss030;
    pdo: Mpd001;
    nmt: Nmt001 Nmt002 Nmt003 Nmt004 Nmt005 Nmt006;
    pdo: Pdo001 Pdo002 Pdo003 Pdo004 Pdo005 Pdo006 Pdo008 Pdo009 Pdo010 Pdo011 Pdo012 Pdo013 Pdo014 Pdo015 Pdo016
        Pdo018 Pdo019 Pdo020 Pdo021 Pdo022 Pdo023;
    sdo: Sdo001 Sdo002 Sdo003 Sdo004 Sdo005 Sdo006 Sdo007 Sdo008 Sdo009 Sdo010 Sdo011 Sdo012 Sdo013 Sdo014 Sdo015
        Sdo016 Sdo017 Sdo018 Sdo019 Sdo020 Sdo021 Sdo022 Sdo023 Sdo024 Sdo025 Sdo026 Sdo030 Sdo031 Sdo032;
    srdo: Srd001 Srd002 Srd003 Srd004 Srd005;
    sync: Syn001 Syn002 Syn003 Syn004 Syn005 Syn006 Syn007 Syn008 Syn009 Syn010 Syn011 Syn012 Syn013 Syn014;
    time: Tim001 Tim002;
}

impl Code {
    /// Returns the rule with this printed code, in any case.
    pub fn parse(id: &str) -> Option<Self> {
        RULES.iter().find(|rule| rule.id.eq_ignore_ascii_case(id)).map(|rule| rule.code)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_in_order_and_each_is_its_own() {
        assert!(RULES.windows(2).all(|two| matches!(two, [one, next] if one.id < next.id && one.code < next.code)));
        for rule in RULES {
            assert_eq!(format!("{:?}", rule.code).to_uppercase(), rule.id);
            let of_file =
                rule.id.starts_with("CAP") && !matches!(rule.code, Code::Cap006 | Code::Cap007 | Code::Cap009);
            assert_eq!(rule.context.is_empty(), of_file, "{}", rule.id);
        }
    }

    #[test]
    fn a_name_in_braces_is_a_fact_and_a_fact_is_named() {
        const SPOKEN: Fact = Fact { name: "gap", spoken: true };
        const UNSPOKEN: Fact = Fact { name: "gap", spoken: false };
        let names = |facts, zh, en| Variant { constants: &[], facts, words: Words { zh, en } }.is_sound();
        assert!(names(&[SPOKEN], "{gap}", "after {gap}.") && names(&[SPOKEN], "{gap}", "{gap|frame|frames}"));
        assert!(names(&[UNSPOKEN], "", "") && names(&[], "", ""));
        assert!(!names(&[SPOKEN], "{gap}", "after {gaps}") && !names(&[SPOKEN], "{gap} {period}", "{gap}"));
        assert!(!names(&[SPOKEN], "{gap}", "after gap") && !names(&[SPOKEN], "", "{gap}"));
        assert!(!names(&[UNSPOKEN], "{gap}", "{gap}") && !names(&[SPOKEN], "{ga}{gap}", "{gap"));
    }
}

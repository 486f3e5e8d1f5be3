//! The kinds of problems: a row of `words/problems.tsv` holds everything about its kind.
//!
//! Nothing else names a kind but the tracker that opens it, if its findings alone do not. The rules of cause, the status
//! and the comparison ask for roles. Sentences with figures are in `sayings`.

use super::roles::{Apart, KindRole};
use super::sayings::{self as say, Check, title};
use super::signs::{Ends, Sign, Titles, When};
use crate::rules::{Code, Words};

/// The effect of a problem on the machine, the worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Impact {
    /// Something stopped.
    A,
    /// Something does not start.
    B,
    /// Something works worse than it should.
    C,
    /// Something is wrong on the wire without a visible effect.
    D,
    /// Worth knowing.
    E,
}

impl Impact {
    /// Returns the letter used in machine output.
    pub fn name(self) -> &'static str {
        match self {
            Self::A => "A",
            Self::B => "B",
            Self::C => "C",
            Self::D => "D",
            Self::E => "E",
        }
    }
}

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub struct KindRow {
    /// The kind.
    pub kind: ProblemKind,
    /// The name in machine output, in kebab-case.
    pub name: &'static str,
    /// The effect on the machine.
    pub impact: Impact,
    /// The description, without figures.
    pub words: Words,
    /// Its roles for the rules of cause, the status and the comparison.
    roles: &'static [KindRole],
    /// The facts that tell its causes apart.
    pub(super) apart: Apart,
    /// The rules whose findings are such problems by themselves.
    pub(super) signs: &'static [Sign],
    /// The titles with figures, each with its conditions.
    pub(super) titles: Titles,
    /// The emergency error codes that report it, from and to.
    emcy: &'static [(u16, u16)],
    /// The lists of the things to check first, each with its condition.
    pub(super) checks: &'static [(&'static [When], &'static [Check])],
    /// The clause or practice on which it rests, or `-`.
    pub clause: &'static str,
    /// Rules that show it beside its signs.
    codes: &'static [Code],
    /// The usual cause.
    pub cause: Words,
    /// The signs that end it, in words.
    pub end: Words,
}

impl KindRow {
    /// Iterates over the things to check first where no fact says more, without those about the capture at hand.
    pub fn checked_first(&self) -> impl Iterator<Item = Words> {
        let always = self.checks.iter().find(|(when, _)| when.is_empty());
        let checks = always.into_iter().flat_map(|(_, checks)| checks.iter());
        checks.filter(|check| ![say::NO_SIGN, say::ERROR_FRAMES_OFF].contains(check)).map(|check| check.words)
    }

    /// Iterates over the rules that show it.
    pub fn shown_by(&self) -> impl Iterator<Item = Code> {
        self.signs.iter().map(|sign| sign.code).chain(self.codes.iter().copied())
    }
}

macro_rules! problems {
    ($($kind:ident $name:literal $impact:ident $zh:literal $en:literal $apart:ident $roles:tt $signs:tt $emcy:tt $titles:tt $checks:tt $clause:literal $codes:tt
        $cause_zh:literal $cause_en:literal $end_zh:literal $end_en:literal;)*) => {
        /// The kind of a problem.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub enum ProblemKind {
            $(#[doc = $en] $kind,)*
        }

        #[allow(non_upper_case_globals)]
        mod rows {
            use super::*;
            $(pub(super) static $kind: KindRow = KindRow {
                kind: ProblemKind::$kind,
                name: $name,
                impact: Impact::$impact,
                words: Words { zh: $zh, en: $en },
                roles: &$roles,
                apart: Apart::$apart,
                signs: &$signs,
                titles: &$titles,
                emcy: &$emcy,
                checks: &$checks,
                clause: $clause,
                codes: &$codes,
                cause: Words { zh: $cause_zh, en: $cause_en },
                end: Words { zh: $end_zh, en: $end_en },
            };)*
        }

        /// All kinds.
        pub static KINDS: &[&KindRow] = &[$(&rows::$kind),*];

        impl ProblemKind {
            /// Returns the row of the kind.
            pub fn row(self) -> &'static KindRow {
                match self {
                    $(Self::$kind => &rows::$kind,)*
                }
            }
        }
    };
}

include!(concat!(env!("OUT_DIR"), "/problems.rs"));

/// Returns the sign of a rule with its kind.
pub(super) fn signed(code: Code) -> Option<(ProblemKind, Sign)> {
    let sign = |row: &KindRow| row.signs.iter().find(|sign| sign.code == code).map(|sign| (row.kind, *sign));
    KINDS.iter().find_map(|row| sign(row))
}

/// Returns the kind that an emergency error code reports: the one with the fewest codes.
pub(super) fn reported(code: u16) -> Option<ProblemKind> {
    let fits = |row: &KindRow| {
        row.emcy.iter().filter(|(from, to)| (*from..=*to).contains(&code)).map(|(from, to)| to - from).min()
    };
    KINDS.iter().filter_map(|row| Some((fits(row)?, row.kind))).min().map(|(_, kind)| kind)
}

impl ProblemKind {
    /// Returns true if it has a role.
    pub fn is(self, role: KindRole) -> bool {
        self.row().roles.contains(&role)
    }

    /// Returns true for kinds that a command or the recording explains.
    pub fn is_harmless(self) -> bool {
        self.row().impact == Impact::E || self.is(KindRole::Explained)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_has_a_name_of_its_own() {
        for (place, row) in KINDS.iter().enumerate() {
            assert_eq!(row.kind.row().name, row.name);
            assert!(KINDS.iter().skip(place + 1).all(|other| other.name != row.name), "{}", row.name);
            assert!(row.name.bytes().all(|byte| byte.is_ascii_lowercase() || byte == b'-'), "{}", row.name);
        }
    }

    #[test]
    fn a_rule_is_a_sign_of_one_kind() {
        let signs: Vec<_> = KINDS.iter().flat_map(|row| row.signs).map(|sign| sign.code).collect();
        assert!(signs.len() > 80);
        for (place, code) in signs.iter().enumerate() {
            assert!(!signs.iter().skip(place + 1).any(|other| other == code), "{code:?}");
        }
    }
}

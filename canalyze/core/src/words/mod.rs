//! The core's words, in Chinese and English. Other words are only in `rules` and in the tables of
//! `words/` (invariant 3).
//!
//! - The lines of services: `services`, a file for each service; their breakdown bit by bit: `explain`.
//! - Names of states, error codes and objects: the rows of `terms`.
//! - Values and signals: `value`, `signal`, `parameter`; findings and notes: `sentence`, `findings`, `notes`.
//!
//! The languages of a phrase are side by side: in a row of a table, in [`Lang::pick`] if the rest of the line is the
//! same, and in `say!` if each has its own order of words. A further language is one more variant of [`Lang`] and one
//! more column or label at each of these places; the compiler names the missing ones.
//!
//! The permitted terms are a table, `tests/terms.toml`; `tests/test_terms.py` compares every sentence with it.
//!
//! Nothing is decided here: the words render the content of `message`, `event` and `finding`.

pub mod complaints;
pub mod diagnosis;
pub mod diff;
pub mod digits;
pub mod escape;
pub mod explain;
pub mod findings;
pub mod inventory;
pub mod lane;
pub mod lang;
pub mod losses;
pub mod notes;
pub mod object;
pub mod parameter;
pub mod problems;
pub mod profiles;
pub mod sentence;
pub mod services;
pub mod signal;
pub mod terms;
pub mod transferred;
pub mod value;

use crate::rules::Words;

pub use lang::Lang;
pub(crate) use lang::say;

impl Lang {
    /// All languages, with their names.
    pub const NAMES: &[(&str, Self)] = &[("zh", Self::Zh), ("en", Self::En)];

    /// Returns the words in this language.
    pub fn of(self, words: Words) -> &'static str {
        self.pick(words.zh, words.en)
    }
}

/// The level of detail of a line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Depth {
    /// The phrase of the notes, nothing else.
    Brief,
    /// The phrase, then the content.
    #[default]
    Default,
    /// The same, followed by a breakdown bit by bit.
    Explain,
}

impl Depth {
    /// All depths, with their names.
    pub const NAMES: &[(&str, Self)] =
        &[("brief", Self::Brief), ("default", Self::Default), ("explain", Self::Explain)];
}

#[cfg(test)]
mod tests;

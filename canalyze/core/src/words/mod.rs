//! The core's words, in Chinese and English, and only here and in `rules` (invariant 3).
//!
//! Where words stand:
//!
//! - what a frame of a service says: `services`, a file for each service; its breakdown bit by bit: `explain`;
//! - what has a name (states, error codes, objects): the rows of `terms`;
//! - values and signals: `value`, `signal`, `parameter`; what a finding or a note says: `sentence`, `findings`, `notes`.
//!
//! The languages of a phrase stand beside each other: in a row of a table, in [`Lang::pick`] where the rest of the line
//! is the same, and in `say!` where each has its own order of words. A further language is one more variant of [`Lang`]
//! and one more column or label at each of these places; the compiler names those that lack it.
//!
//! Which word is used for what is a table, `canalyze/words/terms.toml`; `tests/test_terms.py` walks every sentence by it.
//!
//! Must not decide anything: it puts into words what `message`, `event` and `finding` carry.

pub mod complaints;
pub mod diff;
pub mod digits;
pub mod escape;
pub mod explain;
pub mod findings;
pub mod incidents;
pub mod inventory;
pub mod lane;
pub mod lang;
pub mod losses;
pub mod notes;
pub mod object;
pub mod parameter;
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
    /// Returns the words in this language.
    pub fn of(self, words: Words) -> &'static str {
        self.pick(words.zh, words.en)
    }
}

/// How detailed a line is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Depth {
    /// The phrase of the notes, nothing else.
    Brief,
    /// The phrase, then the content.
    #[default]
    Default,
    /// The same, and under each line its breakdown bit by bit.
    Explain,
}

#[cfg(test)]
mod tests;

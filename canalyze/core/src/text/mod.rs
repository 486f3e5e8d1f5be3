//! The core's words, in Chinese and English, and only here and in `rules` (invariant 3).
//!
//! `terms` holds rows (code, zh, en); `zh` and `en` say each message and event in a sentence; `findings` and `notes` have
//! their phrases in pairs; `explain` breaks a frame down bit by bit. It must not decide anything: it puts into words what `message`,
//! `event` and `finding` carry.

pub mod complaints;
pub mod diff;
pub mod digits;
pub mod en;
pub mod escape;
pub mod explain;
pub mod findings;
pub mod lane;
pub mod notes;
pub mod object;
pub mod parameter;
pub mod sentence;
pub mod signal;
pub mod terms;
pub mod value;
pub mod zh;

use crate::rules::Words;

/// The language of the text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lang {
    /// Chinese, in the vocabulary of the notes.
    #[default]
    Zh,
    /// English, in CiA 301's terms.
    En,
}

impl Lang {
    /// Words that stand in pairs.
    pub fn of(self, words: Words) -> &'static str {
        self.pick(words.zh, words.en)
    }

    /// The one of two that is in this language.
    pub(crate) fn pick(self, zh: &'static str, en: &'static str) -> &'static str {
        match self {
            Self::Zh => zh,
            Self::En => en,
        }
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

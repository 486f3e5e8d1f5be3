//! The core's words, in Chinese and English, and only here (invariant 3).
//!
//! `terms` holds rows (code, zh, en); `zh` and `en` say each message, event and finding in a sentence;
//! `explain` breaks a frame down bit by bit. It must not decide anything: it puts into words what `message`,
//! `event` and `finding` carry.

pub mod complaints;
pub mod diff;
pub mod digits;
pub mod en;
pub mod escape;
pub mod explain;
pub mod lane;
pub mod parameter;
pub mod signal;
pub mod terms;
pub mod told;
pub mod value;
pub mod zh;

/// The language of the text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lang {
    /// Chinese, in the vocabulary of the notes.
    #[default]
    Zh,
    /// English, in CiA 301's terms.
    En,
}

/// How much a line says.
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

/// The words of a rule.
#[derive(Clone, Copy, Debug)]
pub struct RuleText {
    /// In one line.
    pub message: &'static str,
    /// What it means.
    pub meaning: &'static str,
    /// What usually causes it.
    pub cause: &'static str,
    /// Its sentences with what was measured, as `{name}`: one for each face of the rule.
    pub faces: &'static [&'static str],
}

#[cfg(test)]
mod tests;

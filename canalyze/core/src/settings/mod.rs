//! What users write for the program: `canalyze.toml` and files of expectations, each checked key by key.
//!
//! The one place that knows which tables and keys there are, and how each value is spelled. A mistake is reported with its
//! line and with what is allowed, as the key of a sentence and what fills it: the sentences stand in `canalyze/words`.
//! Must not: open a file, judge a capture, or panic on any bytes.

mod config;
mod expected;
mod near;
mod schema;
mod spelled;
mod toml;
mod value;

#[cfg(test)]
mod tests;

pub use config::{Channel, Check, Cob, Description, Override, Settings, settings};
pub use expected::expectations;
pub use schema::Schema;
pub use spelled::{address, bit_rate, can_id, codes, node, nodes, pdo, tolerance};

/// Which tables and keys there are, of `canalyze.toml` and of expectations.
pub fn schemas() -> [(&'static str, Schema); 2] {
    [("config", config::schema()), ("expect", expected::schema())]
}

/// What is wrong with a file, for who has the words: one sentence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mistake {
    /// The key of the sentence, such as `config.unknown`.
    pub key: String,
    /// What fills it: names and texts.
    pub facts: Vec<(&'static str, String)>,
}

impl Mistake {
    fn new<const N: usize>(key: impl Into<String>, facts: [(&'static str, String); N]) -> Self {
        Self { key: key.into(), facts: facts.into() }
    }
}

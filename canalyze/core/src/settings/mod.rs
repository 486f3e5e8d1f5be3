//! The files that users write for the program: `canalyze.toml` and files of expectations, each checked key by key.
//!
//! This is the only place that defines the tables and keys and the syntax of each value. A mistake is reported with its
//! line and with the permitted values, as the key of a sentence and its facts; the sentences are in `canalyze/words`.
//! No file is opened and no capture is judged here, and no input panics.

mod config;
mod expected;
mod near;
mod schema;
mod spelled;
mod toml;
mod value;

#[cfg(test)]
mod tests;

pub use config::{CheckSettings, CobSetting, Config, Description, Override, SdoIds, settings};
pub use expected::expectations;
pub use schema::Schema;
pub use spelled::{PdoMapping, address, bit_rate, can_id, codes, node, nodes, pdo, pdo_mapping, profile, tolerance};

/// The tables and keys of `canalyze.toml` and of expectations.
pub fn schemas() -> [(&'static str, Schema); 2] {
    [("config", config::schema()), ("expect", expected::schema())]
}

/// A mistake in a file, to be put into one sentence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mistake {
    /// The key of the sentence, such as `config.unknown`.
    pub key: String,
    /// Its facts: names and texts.
    pub facts: Vec<(&'static str, String)>,
}

impl Mistake {
    fn new<const N: usize>(key: impl Into<String>, facts: [(&'static str, String); N]) -> Self {
        Self { key: key.into(), facts: facts.into() }
    }
}

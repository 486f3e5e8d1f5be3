//! What a finding says: a variant of its rule, and what was measured for it.

use std::sync::Arc;

use super::{Code, Quantity, Said};

/// The same in both languages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Words {
    /// Chinese.
    pub zh: &'static str,
    /// English.
    pub en: &'static str,
}

/// The name of something measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fact {
    /// As it stands in the sentence and in JSON.
    pub name: &'static str,
    /// It stands in the sentence, not only in JSON.
    pub spoken: bool,
}

/// One of the sentences of a rule. A name in braces stands for a fact; `{frames|frame|frames}` for a number and its noun.
#[derive(Debug, PartialEq, Eq)]
pub struct Variant {
    /// What JSON says of this variant beside its facts: names and JSON values.
    pub constants: &'static [(&'static str, &'static str)],
    /// What is measured, in the order of JSON.
    pub facts: &'static [Fact],
    /// The sentence.
    pub words: Words,
}

impl Variant {
    /// Does not compile where a sentence and the facts do not fit.
    pub(crate) const fn check(&self) {
        assert!(self.is_sound(), "a name in braces is no fact of the variant, or a fact is in no sentence");
    }

    /// Whether each name in braces is a fact, and each fact that is spoken stands in both sentences.
    pub(super) const fn is_sound(&self) -> bool {
        self.covers(self.words.zh) && self.covers(self.words.en)
    }

    const fn covers(&self, sentence: &str) -> bool {
        let mut facts = self.facts;
        while let [fact, others @ ..] = facts {
            if fact.spoken && !names(sentence.as_bytes(), fact.name.as_bytes()) {
                return false;
            }
            facts = others;
        }
        let mut rest = sentence.as_bytes();
        while let [byte, after @ ..] = rest {
            if *byte == b'{' && !self.has(after) {
                return false;
            }
            rest = after;
        }
        true
    }

    /// Whether the name of a fact that is spoken begins here.
    const fn has(&self, text: &[u8]) -> bool {
        let mut facts = self.facts;
        while let [fact, others @ ..] = facts {
            if fact.spoken && begins(text, fact.name.as_bytes()) {
                return true;
            }
            facts = others;
        }
        false
    }
}

/// Whether a name stands in braces in a sentence.
const fn names(mut sentence: &[u8], name: &[u8]) -> bool {
    while let [byte, after @ ..] = sentence {
        if *byte == b'{' && begins(after, name) {
            return true;
        }
        sentence = after;
    }
    false
}

/// Whether a text begins with a name that ends there.
const fn begins(mut text: &[u8], mut name: &[u8]) -> bool {
    while let [wanted, others @ ..] = name {
        match text {
            [found, after @ ..] if *found == *wanted => text = after,
            _ => return false,
        }
        name = others;
    }
    matches!(text, [b'}' | b'|', ..])
}

/// A name without the mark by which Rust tells it from a keyword.
pub(crate) const fn plain(name: &'static str) -> &'static str {
    match name.as_bytes() {
        [b'r', b'#', rest @ ..] => match std::str::from_utf8(rest) {
            Ok(name) => name,
            Err(_) => name,
        },
        _ => name,
    }
}

/// Most facts of one variant, but for expectations.
const MEASURED: usize = 4;

/// A variant with what was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// The variant.
    pub variant: &'static Variant,
    /// In the order of the variant's facts.
    values: [Quantity; MEASURED],
}

impl Measured {
    pub(crate) fn new<const N: usize>(variant: &'static Variant, facts: [Quantity; N]) -> Self {
        const { assert!(N <= MEASURED, "a variant with more facts than a finding holds") };
        let mut values = [Quantity::Nothing; MEASURED];
        for (slot, fact) in values.iter_mut().zip(facts) {
            *slot = fact;
        }
        Self { variant, values }
    }

    /// What was measured, by name.
    pub fn facts(&self) -> impl Iterator<Item = (&'static str, Quantity)> {
        self.variant.facts.iter().map(|fact| fact.name).zip(self.values)
    }

    /// What was measured by this name.
    pub fn get(&self, name: &str) -> Option<Quantity> {
        self.facts().find(|(known, _)| *known == name).map(|(_, quantity)| quantity)
    }
}

/// What a rule says of something: without facts its message, else one of its variants.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The rule.
    pub code: Code,
    /// What was measured.
    pub facts: Facts,
}

impl Verdict {
    pub(super) fn of<const N: usize>(code: Code, variant: &'static Variant, facts: [Quantity; N]) -> Self {
        Self { code, facts: Facts::Measured(Measured::new(variant, facts)) }
    }
}

impl From<Code> for Verdict {
    fn from(code: Code) -> Self {
        Self { code, facts: Facts::None }
    }
}

/// How a capture deviates from what is expected of it, or why that cannot be checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Deviation {
    /// The rule.
    pub code: Code,
    /// One of its variants.
    pub variant: &'static Variant,
    /// What was expected and found, in the order of the variant's facts.
    pub said: Vec<Said>,
}

impl Deviation {
    pub(super) fn of<const N: usize>(code: Code, variant: &'static Variant, facts: [Said; N]) -> Self {
        Self { code, variant, said: facts.into() }
    }
}

/// A deviation from an expectation that stands in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Unmet {
    /// The expectation's file and line, `boot.expect.toml:12`; to be escaped.
    pub expectation: Arc<str>,
    /// The variant of the rule.
    pub variant: &'static Variant,
    /// What was expected and found, in the order of the variant's facts.
    pub said: Vec<Said>,
    /// The finding stands for this many more of its kind; 0: for itself.
    pub repeated: u64,
}

impl Unmet {
    /// What was expected and found, by name.
    pub fn facts(&self) -> impl Iterator<Item = (&'static str, &Said)> {
        self.variant.facts.iter().map(|fact| fact.name).zip(&self.said)
    }
}

/// What a finding measured.
#[derive(Clone, Debug, PartialEq)]
pub enum Facts {
    /// Nothing beyond the code.
    None,
    /// A variant of the rule with what was measured.
    Measured(Measured),
    /// An expectation does not hold, or cannot be checked. Rare, and large: apart, so that findings stay small.
    Unmet(Arc<Unmet>),
    /// The finding stands for this many more of its kind on the same object.
    Repeated {
        /// How many were not shown.
        count: u64,
    },
}

impl Facts {
    /// For how many findings it stands: for itself, or for so many that were only counted.
    pub fn count(&self) -> u64 {
        match self {
            Self::Repeated { count } => *count,
            Self::Unmet(unmet) => unmet.repeated.max(1),
            _ => 1,
        }
    }

    /// What a finding says that stands for so many more like this one.
    pub fn repeated(&self, count: u64) -> Self {
        match self {
            Self::Unmet(unmet) => {
                Self::Unmet(Arc::new(Unmet { said: Vec::new(), repeated: count, ..Unmet::clone(unmet) }))
            }
            _ => Self::Repeated { count },
        }
    }
}

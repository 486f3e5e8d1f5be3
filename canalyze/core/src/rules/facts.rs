//! The statement of a finding: a variant of its rule and the measured facts.

use std::sync::Arc;

use super::{Code, Quantity, Said};

/// A text in both languages.
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
    /// Its name in the sentence and in JSON.
    pub name: &'static str,
    /// It is part of the sentence, not only of JSON.
    pub spoken: bool,
}

/// One of the sentences of a rule. A name in braces is replaced by its fact, `{frames|frame|frames}` by a number and
/// its noun.
#[derive(Debug, PartialEq, Eq)]
pub struct Variant {
    /// Further members in JSON: names and JSON values.
    pub constants: &'static [(&'static str, &'static str)],
    /// The measured facts, in the order of JSON.
    pub facts: &'static [Fact],
    /// The sentence.
    pub words: Words,
}

impl Variant {
    /// Fails to compile if a sentence and the facts do not match.
    pub(crate) const fn check(&self) {
        assert!(self.is_sound(), "a name in braces is no fact of the variant, or a fact is in no sentence");
    }

    /// Returns true if each name in braces is a fact, and each spoken fact is in both sentences.
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

    /// Returns true if the name of a spoken fact begins here.
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

/// Returns true if a sentence has a name in braces.
const fn names(mut sentence: &[u8], name: &[u8]) -> bool {
    while let [byte, after @ ..] = sentence {
        if *byte == b'{' && begins(after, name) {
            return true;
        }
        sentence = after;
    }
    false
}

/// Returns true if a text begins with a name that ends there.
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

/// Returns a name without the prefix by which Rust distinguishes it from a keyword.
pub(crate) const fn plain(name: &'static str) -> &'static str {
    match name.as_bytes() {
        [b'r', b'#', rest @ ..] => match std::str::from_utf8(rest) {
            Ok(name) => name,
            Err(_) => name,
        },
        _ => name,
    }
}

/// Maximum number of facts of one variant, except for expectations.
const MEASURED: usize = 4;

/// A variant with its measured facts.
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

    /// Returns a sentence with its facts by their names; `None` if one of them is not known.
    pub(crate) fn filled(variant: &'static Variant, fact: impl Fn(&str) -> Option<Quantity>) -> Option<Self> {
        let mut values = [Quantity::Nothing; MEASURED];
        for (slot, known) in values.iter_mut().zip(variant.facts) {
            *slot = fact(known.name)?;
        }
        Some(Self { variant, values })
    }

    /// The measured facts by name.
    pub fn facts(&self) -> impl Iterator<Item = (&'static str, Quantity)> {
        self.variant.facts.iter().map(|fact| fact.name).zip(self.values)
    }

    /// Returns the fact of this name.
    pub fn get(&self, name: &str) -> Option<Quantity> {
        self.facts().find(|(known, _)| *known == name).map(|(_, quantity)| quantity)
    }

    /// Returns the number or the time in ns of this name, if the sentence has it.
    pub fn spoken(&self, name: &str) -> Option<i64> {
        self.variant.facts.iter().find(|fact| fact.spoken && fact.name == name)?;
        match self.get(name)? {
            Quantity::Count(count) => i64::try_from(count).ok(),
            Quantity::Ns(ns) => Some(ns.as_ns()),
            _ => None,
        }
    }
}

/// The statement of a rule about something: its message if there are no facts, else one of its variants.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The rule.
    pub code: Code,
    /// The measured facts.
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

/// A deviation of a capture from what is expected of it, or the reason why that cannot be checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Deviation {
    /// The rule.
    pub code: Code,
    /// One of its variants.
    pub variant: &'static Variant,
    /// Expected and found values, in the order of the variant's facts.
    pub said: Vec<Said>,
}

impl Deviation {
    pub(super) fn of<const N: usize>(code: Code, variant: &'static Variant, facts: [Said; N]) -> Self {
        Self { code, variant, said: facts.into() }
    }
}

/// A deviation from an expectation in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Unmet {
    /// The expectation's file and line, `boot.expect.toml:12`; to be escaped.
    pub expectation: Arc<str>,
    /// The variant of the rule.
    pub variant: &'static Variant,
    /// Expected and found values, in the order of the variant's facts.
    pub said: Vec<Said>,
    /// The number of further findings that this one represents; 0: it is a finding of its own.
    pub repeated: u64,
}

impl Unmet {
    /// Expected and found values by name.
    pub fn facts(&self) -> impl Iterator<Item = (&'static str, &Said)> {
        self.variant.facts.iter().map(|fact| fact.name).zip(&self.said)
    }
}

/// The facts of a finding.
#[derive(Clone, Debug, PartialEq)]
pub enum Facts {
    /// Nothing beyond the code.
    None,
    /// A variant of the rule with what was measured.
    Measured(Measured),
    /// An expectation does not hold, or cannot be checked. Rare and large, so it is boxed to keep findings small.
    Unmet(Arc<Unmet>),
    /// The finding represents this many more of its kind on the same object.
    Repeated {
        /// The number of findings that were not shown.
        count: u64,
    },
}

impl Facts {
    /// Returns the number of findings that it represents: itself, or those that were only counted.
    pub fn count(&self) -> u64 {
        match self {
            Self::Repeated { count } => *count,
            Self::Unmet(unmet) => unmet.repeated.max(1),
            _ => 1,
        }
    }

    /// Returns the facts of a finding that represents `count` more like this one.
    pub fn repeated(&self, count: u64) -> Self {
        match self {
            Self::Unmet(unmet) => {
                Self::Unmet(Arc::new(Unmet { said: Vec::new(), repeated: count, ..Unmet::clone(unmet) }))
            }
            _ => Self::Repeated { count },
        }
    }
}

//! The languages of the text, and terms: words that have one name in each.

use super::digits::{Put, decimal, put};

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
    /// Returns the one of two words that is in this language.
    pub(crate) const fn pick(self, zh: &'static str, en: &'static str) -> &'static str {
        match self {
            Self::Zh => zh,
            Self::En => en,
        }
    }

    /// Returns the word of a pair that is in this language.
    pub(crate) const fn word(self, pair: Bilingual) -> &'static str {
        self.pick(pair.0, pair.1)
    }
}

/// Words in Chinese and in English.
pub(crate) type Bilingual = (&'static str, &'static str);

/// Appends a phrase in the chosen language, each with its parts in its own order of words:
/// `say!(out, lang; zh: "节点", node, "的心跳"; en: "heartbeat of node ", node)`.
macro_rules! say {
    ($out:expr, $lang:expr; zh: $($zh:expr),+; en: $($en:expr),+) => {
        match $lang {
            $crate::words::lang::Lang::Zh => $crate::words::digits::put!($out; $($zh),+),
            $crate::words::lang::Lang::En => $crate::words::digits::put!($out; $($en),+),
        }
    };
}
pub(crate) use say;

/// A term: its code, its Chinese word, its English word.
pub type Term<K> = (K, &'static str, &'static str);

/// Returns the word for `code` in rows sorted by code.
pub fn find<K: Ord + Copy>(rows: &'static [Term<K>], lang: Lang, code: K) -> Option<&'static str> {
    let at = rows.binary_search_by_key(&code, |row| row.0).ok()?;
    rows.get(at).map(|row| lang.pick(row.1, row.2))
}

/// A number of bytes: `23字节`, `23 bytes`.
#[derive(Clone, Copy, Debug)]
pub struct Size(pub Lang, pub u64);

impl Put for Size {
    fn put(&self, out: &mut Vec<u8>) {
        decimal(out, self.1);
        put!(out; self.0.pick("字节", if self.1 == 1 { " byte" } else { " bytes" }));
    }
}

#[cfg(test)]
pub(crate) mod tests {
    #![allow(clippy::indexing_slicing)]
    use super::*;

    /// Rows are strictly ascending, and each has both words, the English one in ASCII.
    pub(crate) fn sound<K: Ord + Copy + std::fmt::Debug>(rows: &[Term<K>]) {
        for pair in rows.windows(2) {
            assert!(pair[0].0 < pair[1].0, "{:?} before {:?}", pair[0].0, pair[1].0);
        }
        for (code, zh, en) in rows {
            assert!(!zh.is_empty() && !en.is_empty(), "{code:?}");
            assert!(en.is_ascii(), "{code:?}: {en}");
            assert!(zh.chars().all(|c| !c.is_control()), "{code:?}");
            // Terms stand within sentences that use half-width punctuation, as the notes do.
            assert!(!zh.contains(['，', '（', '）', '：', '；']), "{code:?}: {zh}");
        }
    }
}

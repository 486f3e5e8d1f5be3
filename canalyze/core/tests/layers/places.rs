//! What few places may hold: words for people, the binding to Python, and the following of states.
//!
//! The order of modules does not show these: a Chinese word or a match of a message can stand in any file. Each test
//! here searches the text for one of them.

use crate::sources::{belongs, is_test, sources};

#[test]
fn words_for_people_stand_in_words_and_rules() {
    for (module, source) in sources() {
        let chinese = source.chars().any(|c| ('\u{4E00}'..='\u{9FFF}').contains(&c));
        // Listings are read in any language.
        let read = module == "bytes::readers::listing" || belongs(&module, "bytes::readers::rows");
        // A kind of problem is declared with its words, and a record with the documentation of its columns, like a rule.
        let records =
            ["tables::table", "tables::columns", "tables::jsonl::note", "tables::jsonl::pdo", "tables::jsonl::pdos"];
        let declared = ["rules", "problems::kinds", "problems::sayings", "problems::apart"]
            .iter()
            .chain(&records)
            .any(|room| belongs(&module, room));
        let words = belongs(&module, "words") || belongs(&module, "wire") || declared || is_test(&module) || read;
        assert!(!chinese || words, "{module} holds Chinese words");
    }
}

#[test]
fn only_the_binding_knows_python() {
    for (module, source) in sources() {
        assert!(belongs(&module, "python") || !source.contains("pyo3"), "{module} names pyo3");
    }
}

#[test]
fn times_have_their_own_type() {
    for (module, source) in sources() {
        // Readers, schemas and the binding have numbers before these are times.
        let numbers = ["bytes::readers", "settings::schema", "python"].iter().any(|room| belongs(&module, room));
        let code = source.split("#[cfg(test)]").next().unwrap_or(&source);
        let bare = ["_ns: i64", "_ns: Option<i64>", "_NS: i64"].into_iter().find(|bare| code.contains(bare));
        assert!(bare.is_none() || numbers || is_test(&module), "{module} has a time that is a bare integer: {bare:?}");
    }
}

/// Messages whose states the world publishes as changes, and the most files that may match one.
const FOLLOWED: [&str; 5] = ["Heartbeat", "BootUp", "Emcy", "Nmt", "Sync"];
const FOLLOWERS: usize = 8;

#[test]
fn states_are_followed_in_few_files() {
    let sources = sources();
    let product: Vec<_> = sources.iter().filter(|(module, _)| !is_test(module)).collect();
    for message in FOLLOWED {
        let name = format!("Message::{message}");
        let matches = |source: &str| {
            let code = source.split("#[cfg(test)]").next().unwrap_or(source);
            code.split(&name).skip(1).any(|rest| !rest.starts_with(|next: char| next.is_alphanumeric()))
        };
        let found: Vec<_> = product.iter().filter(|(_, source)| matches(source)).map(|(module, _)| module).collect();
        assert!((1..=FOLLOWERS).contains(&found.len()), "{message} is matched in {found:?}");
        let views = found.iter().filter(|module| ["views", "problems"].iter().any(|room| belongs(module, room)));
        assert_eq!(views.count(), 0, "a view follows {message} instead of changes: {found:?}");
    }
}

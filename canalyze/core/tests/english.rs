//! Plain English, kept: the openers of doc comments, and one meaning per type name.
#![allow(clippy::expect_used)]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// First words of doc comments that do not say what an item is or does.
const OPENERS: [&str; 5] = ["What", "Whether", "How", "Where", "Which"];

/// Maximum number of doc comments that begin so; it only falls.
const BEGUN_SO: usize = 21;

/// Maximum number of types of one name outside tests.
const MEANINGS: usize = 2;

/// Names that may have more types, with the reason.
const EXCEPTIONS: &[(&str, &str)] = &[];

/// Returns the path and the text of every source file.
fn sources() -> Vec<(String, String)> {
    let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("src")];
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("the source is readable") {
            let path = entry.expect("the source is readable").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let text = fs::read_to_string(&path).expect("the source is UTF-8");
                found.push((path.display().to_string().replace('\\', "/"), text));
            }
        }
    }
    found
}

/// Returns the text of a line of a doc comment.
fn doc(line: &str) -> Option<&str> {
    let line = line.trim_start();
    line.strip_prefix("///").or_else(|| line.strip_prefix("//!"))
}

/// Returns the name of the type that a line defines; associated types are none.
fn defined(line: &str) -> Option<&str> {
    let item = line.trim_start();
    let item = match item.strip_prefix("pub(") {
        Some(restricted) => restricted.split_once(") ")?.1,
        None => item.strip_prefix("pub ").unwrap_or(item),
    };
    let (keyword, rest) = item.split_once(' ')?;
    let of_its_own = match keyword {
        "struct" | "enum" | "trait" => true,
        "type" => !line.starts_with(' '),
        _ => false,
    };
    let name = rest.split(|letter: char| !letter.is_alphanumeric()).next()?;
    Some(name).filter(|name| of_its_own && name.starts_with(|letter: char| letter.is_uppercase()))
}

#[test]
fn doc_comments_begin_with_what_an_item_is_or_does() {
    let mut begun = Vec::new();
    for (path, text) in sources() {
        let mut before = None;
        for (number, line) in (1..).zip(text.lines()) {
            let comment = doc(line);
            let word = comment.and_then(|text| text.split_whitespace().next()).unwrap_or_default();
            if before.is_none() && OPENERS.contains(&word) {
                begun.push(format!("{path}:{number}"));
            }
            before = comment;
        }
    }
    let places = begun.join("\n");
    assert!(begun.len() <= BEGUN_SO, "{} of {BEGUN_SO} begin with one of {OPENERS:?}:\n{places}", begun.len());
}

#[test]
fn a_type_name_has_one_meaning() {
    let mut names = BTreeMap::<String, Vec<String>>::new();
    for (path, text) in sources() {
        if path.contains("/tests/") || path.ends_with("/tests.rs") {
            continue;
        }
        let product = text.split("\nmod tests {").next().unwrap_or(&text);
        for name in product.lines().filter_map(defined) {
            names.entry(name.to_owned()).or_default().push(path.clone());
        }
    }
    let excepted = |name: &str| EXCEPTIONS.iter().any(|(one, _)| *one == name);
    names.retain(|name, paths| paths.len() > MEANINGS && !excepted(name));
    assert!(names.is_empty(), "defined more than {MEANINGS} times: {names:#?}");
}

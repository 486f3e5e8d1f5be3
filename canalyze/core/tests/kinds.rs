//! A kind of problem is a row of the table of kinds, and at most one file of the source names it: the tracker that opens it.
#![allow(clippy::expect_used, clippy::panic)]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Kinds that more files name, with the reason.
const EXCEPTIONS: &[(&str, &str)] = &[];

/// Returns the path and the product code of every source file, without comments.
fn sources() -> Vec<(String, String)> {
    let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("src")];
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("the source is readable") {
            let path = entry.expect("the source is readable").path();
            let name = path.file_stem().expect("an entry has a name").to_string_lossy().into_owned();
            if name == "tests" {
                continue;
            }
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let text = fs::read_to_string(&path).expect("the source is UTF-8");
                let code = text.lines().take_while(|line| !line.contains("#[cfg(test)]"));
                let code = code.filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n");
                found.push((path.display().to_string(), code));
            }
        }
    }
    found
}

/// Returns the names behind `Type::` in a text.
fn behind<'a>(text: &'a str, of: &str) -> Vec<&'a str> {
    let rest = text.split(of).skip(1);
    rest.map(|rest| rest.split(|letter: char| !letter.is_alphanumeric()).next().unwrap_or_default()).collect()
}

/// Returns the lines of the rows of the table of kinds.
fn rows() -> Vec<Vec<String>> {
    let table = Path::new(env!("CARGO_MANIFEST_DIR")).join("words/problems.tsv");
    let table = fs::read_to_string(table).expect("the table is readable");
    let rows = table.split("\n\n").filter(|row| row.starts_with(|letter: char| letter.is_ascii_uppercase()));
    rows.map(|row| row.lines().map(|line| line.trim_start_matches('\t').to_owned()).collect()).collect()
}

#[test]
fn a_kind_is_named_by_its_row_and_one_file() {
    let rows = rows();
    let kinds: Vec<_> = rows.iter().filter_map(|row| row.first()?.split('\t').next()).collect();
    assert!(kinds.len() > 90, "the table is where this test looks");
    let mut named: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    let sources = sources();
    for (path, code) in &sources {
        let mut names = behind(code, "ProblemKind::");
        let imports = ["ProblemKind::{", "ProblemKind::*"].iter().any(|import| code.contains(import));
        assert!(!imports, "{path} imports the names of kinds");
        names.sort_unstable();
        names.dedup();
        for name in names.into_iter().filter(|name| kinds.contains(name)) {
            named.entry(name).or_default().push(path.clone());
        }
    }
    assert!(named.len() > 30, "kinds are named as this test looks for them");
    named.retain(|kind, files| files.len() > 1 && !EXCEPTIONS.iter().any(|(name, _)| name == kind));
    assert!(named.is_empty(), "named by several files: ask for a role of the table instead: {named:#?}");
}

#[test]
fn a_role_has_kinds_and_is_asked_for() {
    let sources = sources();
    let roles = sources.iter().find(|(path, _)| path.ends_with("roles.rs")).map(|(_, code)| code).expect("it is there");
    let roles =
        roles.split_once("pub enum KindRole {").and_then(|(_, rest)| rest.split_once('}')).expect("it is there").0;
    let rows = rows();
    let lists: Vec<Vec<&str>> = rows.iter().filter_map(|row| Some(row.get(1)?.split(", ").collect())).collect();
    let asked: Vec<_> = sources.iter().flat_map(|(_, code)| behind(code, "KindRole::")).collect();
    for role in roles.split([',', '\n']).map(str::trim).filter(|role| !role.is_empty()) {
        assert!(lists.iter().any(|list| list.contains(&role)), "no kind has the role {role}");
        assert!(asked.contains(&role), "nothing asks for the role {role}");
    }
}

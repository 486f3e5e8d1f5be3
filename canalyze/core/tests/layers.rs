//! The house order of `src/lib.rs`, kept: which module may use which, and where words for people may stand.

#![allow(clippy::expect_used, clippy::panic)]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// A module (the longest prefix counts) and the modules that it may use. Its own files always may.
const MAY_USE: &[(&str, &[&str])] = &[
    ("frame", &[]),
    ("od", &[]),
    ("dictionary", &["od"]),
    ("drive", &["od"]),
    ("cob_id", &["frame"]),
    ("network", &["frame", "dictionary"]),
    ("services::sdo::wire", &[]),
    ("finding", &["frame", "services::sdo::wire"]),
    ("services::sdo::transfer", &["frame", "dictionary", "finding", "services::sdo::wire"]),
    ("configuration", &["dictionary", "services::sdo::wire", "services::sdo::transfer"]),
    ("message", &["frame", "cob_id", "services::lss", "services::pdo"]),
    (
        "event",
        &[
            "frame",
            "message",
            "finding",
            "dictionary",
            "configuration",
            "services::pdo",
            "services::sdo::wire",
            "services::sdo::transfer",
        ],
    ),
    ("context", &["frame", "finding", "event", "services::sdo::wire", "services::sdo::transfer"]),
    ("services", &["frame", "dictionary", "od", "cob_id", "message", "finding", "event", "context"]),
    ("node", &["frame", "od", "drive", "configuration", "services::pdo"]),
    ("roles", &["frame", "cob_id", "configuration", "network", "node"]),
    (
        "checks",
        &[
            "frame",
            "od",
            "cob_id",
            "message",
            "finding",
            "event",
            "context",
            "dictionary",
            "drive",
            "configuration",
            "network",
            "node",
            "services",
        ],
    ),
    (
        "bus",
        &[
            "frame",
            "dictionary",
            "cob_id",
            "message",
            "finding",
            "event",
            "context",
            "configuration",
            "network",
            "node",
            "roles",
            "checks",
            "services",
        ],
    ),
    ("readers", &["frame", "select"]),
    ("writers", &["frame", "readers", "event", "finding", "text::digits", "text::escape"]),
    ("writers::mcap", &["frame", "readers", "event", "finding", "text"]),
    ("writers::mcap::decoded", &["frame", "od", "drive", "message", "event", "finding", "services", "text", "writers"]),
    ("inputs", &["frame", "readers"]),
    ("info", &["frame", "readers"]),
    ("select", &[]),
    (
        "summary",
        &[
            "frame",
            "cob_id",
            "message",
            "finding",
            "event",
            "network",
            "readers",
            "services::sdo::wire",
            "services::sdo::transfer",
        ],
    ),
    ("filter", &["frame", "services::sdo::transfer"]),
    (
        "text",
        &[
            "drive",
            "frame",
            "cob_id",
            "od",
            "message",
            "dictionary",
            "finding",
            "event",
            "configuration",
            "services",
            "readers",
            "writers",
            "filter",
        ],
    ),
    (
        "render",
        &[
            "drive",
            "select",
            "summary",
            "info",
            "frame",
            "cob_id",
            "od",
            "message",
            "finding",
            "event",
            "configuration",
            "services",
            "readers",
            "writers",
            "text",
        ],
    ),
    ("repeats", &["frame", "finding", "event", "services::sdo::wire"]),
    (
        "session",
        &[
            "frame", "finding", "event", "context", "network", "services", "bus", "readers", "writers", "filter",
            "select", "summary", "info", "inputs", "text", "render", "repeats",
        ],
    ),
    (
        "python",
        &[
            "frame",
            "finding",
            "dictionary",
            "network",
            "services",
            "readers",
            "writers",
            "filter",
            "select",
            "text",
            "render",
            "inputs",
            "session",
        ],
    ),
];

fn sources() -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut folders = vec![root.clone()];
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("the source is readable") {
            let path = entry.expect("the source is readable").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                found.push((module(&root, &path), fs::read_to_string(&path).expect("the source is UTF-8")));
            }
        }
    }
    assert!(found.len() > 30, "the source is where this test looks");
    found
}

fn module(root: &Path, path: &Path) -> String {
    let inner: PathBuf = path.strip_prefix(root).expect("below the root").with_extension("");
    let names: Vec<String> = inner.iter().map(|name| name.to_string_lossy().into_owned()).collect();
    names.join("::").trim_end_matches("::mod").to_owned()
}

fn is_test(module: &str) -> bool {
    module.split("::").any(|name| name == "tests")
}

fn belongs(module: &str, to: &str) -> bool {
    module == to || module.strip_prefix(to).is_some_and(|rest| rest.starts_with("::"))
}

/// Every `crate::a::b` in code that is not a test, as paths.
fn used(source: &str) -> BTreeSet<String> {
    let code = source.split("#[cfg(test)]").next().unwrap_or(source);
    let mut paths = BTreeSet::new();
    for line in code.lines().filter(|line| !line.trim_start().starts_with("//")) {
        for rest in line.split("crate::").skip(1) {
            let path: String = rest.chars().take_while(|c| c.is_alphanumeric() || matches!(c, '_' | ':')).collect();
            match rest.split_once("::{") {
                // `crate::services::{nmt, pdo::x}`: one path a name.
                Some((head, names)) if head.chars().all(|c| c.is_alphanumeric() || matches!(c, '_' | ':')) => {
                    for name in names.split([',', '}']).map(str::trim).filter(|name| !name.is_empty()) {
                        paths.insert(format!("{head}::{name}"));
                    }
                }
                _ => {
                    paths.insert(path.trim_end_matches(':').to_owned());
                }
            }
        }
    }
    paths
}

#[test]
fn dependency_runs_one_way() {
    let mut checked = 0;
    for (module, source) in sources() {
        if module == "lib" || is_test(&module) {
            continue;
        }
        let row = MAY_USE.iter().filter(|(name, _)| belongs(&module, name)).max_by_key(|(name, _)| name.len());
        let (home, allowed) = row.unwrap_or_else(|| panic!("{module} has no row in this table"));
        for path in used(&source) {
            let fine = belongs(&path, home) || allowed.iter().any(|name| belongs(&path, name));
            assert!(fine, "{module} uses crate::{path}");
            checked += 1;
        }
    }
    assert!(checked > 100, "only {checked} uses were found");
}

#[test]
fn words_for_people_stand_in_text() {
    for (module, source) in sources() {
        let chinese = source.chars().any(|c| ('\u{4E00}'..='\u{9FFF}').contains(&c));
        let words = belongs(&module, "text") || is_test(&module);
        assert!(!chinese || words, "{module} holds Chinese words");
    }
}

#[test]
fn only_the_binding_knows_python() {
    for (module, source) in sources() {
        assert!(module == "python" || !source.contains("pyo3"), "{module} names pyo3");
    }
}

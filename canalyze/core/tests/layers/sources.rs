//! The files of `src` as modules, and the paths that they use.
//!
//! Every test of the structure reads the source as text, so that no feature or platform hides a use from it.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

pub(crate) fn sources() -> Vec<(String, String)> {
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

pub(crate) fn is_test(module: &str) -> bool {
    module.split("::").any(|name| name == "tests")
}

pub(crate) fn belongs(module: &str, to: &str) -> bool {
    module == to || module.strip_prefix(to).is_some_and(|rest| rest.starts_with("::"))
}

/// Returns every `crate::a::b` in product code as a path.
pub(crate) fn used(source: &str) -> BTreeSet<String> {
    let code = source.split("#[cfg(test)]\nmod tests {").next().unwrap_or(source);
    let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
    let code = lines.collect::<Vec<_>>().join(" ");
    let mut paths = BTreeSet::new();
    for rest in code.split("crate::").skip(1) {
        let path: String = rest.chars().take_while(|c| c.is_alphanumeric() || matches!(c, '_' | ':')).collect();
        let head = path.trim_end_matches(':');
        match rest.strip_prefix(&path).and_then(|rest| rest.strip_prefix('{')?.split_once('}')) {
            // `crate::{wire::nmt, wire::pdo::x}` is one path per name.
            Some((names, _)) => {
                let names = names.split(',').map(str::trim).filter(|name| !name.is_empty());
                paths.extend(names.map(|name| format!("{head}::{name}")));
            }
            None => _ = paths.insert(head.to_owned()),
        }
    }
    paths
}

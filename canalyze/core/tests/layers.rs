//! The modules of `src/lib.rs` in their order: the modules that each may use, and the places of text for people.

#![allow(clippy::expect_used, clippy::panic)]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// A module and the modules that it may use.
type Row = (&'static str, &'static [&'static str]);

/// A module (the longest prefix counts) and the modules that it may use; its own files are always allowed.
const MAY_USE: &[Row] = &[
    ("frame", &[]),
    ("calendar", &[]),
    ("select", &[]),
    ("span", &[]),
    ("od", &[]),
    ("profiles", &["od"]),
    ("dictionary", &["od", "profiles"]),
    ("drive", &["od"]),
    ("cob_id", &["frame"]),
    ("network", &["frame", "dictionary"]),
    ("services::sdo::wire", &[]),
    ("rules", &["frame", "profiles", "services::sdo::wire"]),
    ("finding", &["frame", "services::sdo::wire", "rules"]),
    ("services::sdo::transfer", &["frame", "od", "dictionary", "finding"]),
    ("configuration", &["dictionary", "services::sdo::wire", "services::sdo::transfer"]),
    ("wire::lss::command", &[]),
    ("message", &["cob_id", "profiles", "wire::lss::command", "services::pdo"]),
    ("wire", &["frame", "calendar", "cob_id", "profiles", "message"]),
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
    ("evidence", &["frame", "cob_id", "finding", "rules"]),
    ("context", &["evidence", "frame", "finding", "event", "services::sdo::wire", "services::sdo::transfer"]),
    (
        "services",
        &[
            "profiles",
            "frame",
            "dictionary",
            "od",
            "cob_id",
            "message",
            "finding",
            "rules",
            "event",
            "evidence",
            "context",
        ],
    ),
    ("node", &["frame", "od", "profiles", "configuration", "services::pdo"]),
    ("preset", &["dictionary", "configuration", "node", "od", "services::pdo"]),
    ("roles", &["frame", "cob_id", "configuration", "network", "node", "services::pdo"]),
    (
        "checks",
        &[
            "profiles",
            "frame",
            "od",
            "cob_id",
            "message",
            "finding",
            "rules",
            "event",
            "evidence",
            "context",
            "dictionary",
            "drive",
            "configuration",
            "network",
            "node",
            "services",
            "wire",
        ],
    ),
    (
        "bus",
        &[
            "profiles",
            "frame",
            "dictionary",
            "drive",
            "cob_id",
            "message",
            "event",
            "evidence",
            "context",
            "configuration",
            "network",
            "node",
            "roles",
            "checks",
            "services",
            "wire",
        ],
    ),
    (
        "diagnosis",
        &[
            "profiles",
            "frame",
            "od",
            "cob_id",
            "drive",
            "configuration",
            "message",
            "finding",
            "rules",
            "event",
            "wire::error_control",
            "wire::lss",
            "services::pdo",
            "services::sdo::wire",
            "services::sdo::transfer",
            "checks::pdo",
            "bus",
        ],
    ),
    ("readers", &["frame", "calendar", "select"]),
    ("inputs", &["frame", "readers"]),
    ("info", &["frame", "span", "readers"]),
    ("text::digits", &[]),
    ("text::escape", &[]),
    ("writers::loss", &[]),
    ("writers", &["frame", "calendar", "readers", "event", "finding", "text::digits", "text::escape"]),
    ("writers::mcap", &["frame", "readers", "event", "finding", "text"]),
    ("writers::mcap::decoded", &["frame", "od", "drive", "message", "event", "finding", "services", "text"]),
    (
        "summary",
        &[
            "profiles",
            "frame",
            "span",
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
    (
        "diff",
        &[
            "diagnosis",
            "frame",
            "cob_id",
            "dictionary",
            "drive",
            "message",
            "finding",
            "event",
            "services::pdo",
            "services::sdo::wire",
            "services::sdo::transfer",
        ],
    ),
    ("filter", &["frame", "rules", "finding", "event", "services::sdo::wire", "services::sdo::transfer"]),
    ("masks", &["frame"]),
    (
        "inventory",
        &[
            "profiles",
            "frame",
            "od",
            "dictionary",
            "drive",
            "configuration",
            "message",
            "event",
            "node",
            "services::pdo",
            "services::sdo::wire",
            "services::sdo::transfer",
            "bus",
            "filter",
        ],
    ),
    (
        "text",
        &[
            "profiles",
            "drive",
            "diagnosis",
            "frame",
            "rules",
            "cob_id",
            "od",
            "message",
            "dictionary",
            "network",
            "finding",
            "event",
            "configuration",
            "services",
            "readers",
            "writers::loss",
            "filter",
            "masks",
            "diff",
            "inventory",
            "wire",
        ],
    ),
    ("repeats", &["frame", "finding", "event", "services::sdo::wire"]),
    (
        "render",
        &[
            "profiles",
            "select",
            "drive",
            "expectation",
            "summary",
            "diff",
            "bus",
            "node",
            "inventory",
            "dictionary",
            "info",
            "diagnosis",
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
            "finding_context",
            "repeats",
            "wire",
        ],
    ),
    ("finding_context", &["frame", "cob_id", "message", "finding", "rules", "event", "services::sdo::wire"]),
    (
        "expectation",
        &[
            "profiles",
            "frame",
            "od",
            "drive",
            "select",
            "message",
            "finding",
            "rules",
            "event",
            "services",
            "summary",
            "diagnosis",
            "text::signal",
            "wire",
        ],
    ),
    ("settings", &["diagnosis", "drive", "expectation", "rules", "select"]),
    (
        "monitor",
        &[
            "profiles",
            "frame",
            "dictionary",
            "message",
            "finding",
            "event",
            "network",
            "node",
            "services",
            "bus",
            "diagnosis",
            "readers",
            "filter",
            "summary",
            "text",
            "render",
            "finding_context",
            "wire",
        ],
    ),
    (
        "session",
        &[
            "diagnosis",
            "frame",
            "rules",
            "finding",
            "event",
            "evidence",
            "context",
            "expectation",
            "network",
            "services",
            "bus",
            "node",
            "monitor",
            "readers",
            "writers",
            "filter",
            "masks",
            "select",
            "summary",
            "diff",
            "info",
            "inventory",
            "inputs",
            "text",
            "render",
            "repeats",
            "finding_context",
        ],
    ),
    (
        "python",
        &[
            "diagnosis",
            "frame",
            "rules",
            "dictionary",
            "network",
            "node",
            "od",
            "preset",
            "profiles",
            "services",
            "readers",
            "writers",
            "expectation",
            "filter",
            "masks",
            "select",
            "diff",
            "text",
            "render",
            "inputs",
            "monitor",
            "session",
            "settings",
        ],
    ),
];

/// Rows that use each other: a service's file creates its messages and events, which contain the service's values.
const KNIT: &[&str] = &["message", "event", "context", "services"];

/// Folders whose files still use each other in circles; none may be added, and a row without a circle is removed.
const CIRCLES: &[&str] = &["services::sdo"];

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

/// Returns every `crate::a::b` in product code as a path.
fn used(source: &str) -> BTreeSet<String> {
    let code = source.split("#[cfg(test)]\nmod tests {").next().unwrap_or(source);
    let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
    let code = lines.collect::<Vec<_>>().join(" ");
    let mut paths = BTreeSet::new();
    for rest in code.split("crate::").skip(1) {
        let path: String = rest.chars().take_while(|c| c.is_alphanumeric() || matches!(c, '_' | ':')).collect();
        let head = path.trim_end_matches(':');
        match rest.strip_prefix(&path).and_then(|rest| rest.strip_prefix('{')?.split_once('}')) {
            // `crate::services::{nmt, pdo::x}` is one path per name.
            Some((names, _)) => {
                let names = names.split(',').map(str::trim).filter(|name| !name.is_empty());
                paths.extend(names.map(|name| format!("{head}::{name}")));
            }
            None => _ = paths.insert(head.to_owned()),
        }
    }
    paths
}

/// Returns the row of a module.
fn row(module: &str) -> Option<Row> {
    MAY_USE.iter().filter(|(name, _)| belongs(module, name)).max_by_key(|(name, _)| name.len()).copied()
}

/// Returns every use of another module: user, path, and the user's row.
fn uses() -> Vec<(String, String, Row)> {
    let mut found = Vec::new();
    for (module, source) in sources().iter().filter(|(module, _)| module != "lib" && !is_test(module)) {
        let row = row(module).unwrap_or_else(|| panic!("{module} has no row in this table"));
        let others = used(source).into_iter().filter(|path| !belongs(path, row.0));
        found.extend(others.map(|path| (module.clone(), path, row)));
    }
    assert!(found.len() > 100, "only {} uses were found", found.len());
    found
}

#[test]
fn dependency_runs_one_way() {
    let against: BTreeSet<String> = uses()
        .into_iter()
        .filter(|(_, path, (_, allowed))| !allowed.iter().any(|name| belongs(path, name)))
        .map(|(module, path, _)| format!("{module} uses crate::{path}"))
        .collect();
    assert!(against.is_empty(), "{against:#?}");
}

#[test]
fn nothing_is_allowed_that_nobody_does() {
    let uses = uses();
    for (home, allowed) in MAY_USE {
        for name in *allowed {
            let done = uses.iter().any(|(_, path, row)| row.0 == *home && belongs(path, name));
            assert!(done, "nothing of {home} uses {name}");
        }
    }
}

#[test]
fn no_row_leads_back_to_itself() {
    let room = |name: &'static str| if KNIT.contains(&name) { "services" } else { name };
    let mut leads: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for (_, path, (home, _)) in uses() {
        let to = row(&path).map(|(name, _)| room(name)).filter(|to| *to != room(home));
        leads.entry(room(home)).or_default().extend(to);
    }
    // Dead ends are removed until nothing remains but circles.
    while let Some(end) =
        leads.iter().find(|(_, to)| to.iter().all(|to| !leads.contains_key(to))).map(|(name, _)| *name)
    {
        leads.remove(end);
    }
    assert!(leads.is_empty(), "in circles, or before one: {:?}", leads.keys());
}

/// Returns every path in product code from the root of the crate, by `crate::`, `self::` and `super::` alike.
fn reached(module: &str, source: &str) -> BTreeSet<String> {
    let inner: Vec<&str> = module.split("::").collect();
    let rooted = |levels: usize| {
        let above = inner.get(..inner.len().saturating_sub(levels)).unwrap_or_default();
        std::iter::once("crate").chain(above.iter().copied()).fold(String::new(), |path, name| path + name + "::")
    };
    let rooted_source = source.replace("super::super::", &rooted(2)).replace("super::", &rooted(1));
    used(&rooted_source.replace("self::", &rooted(0)))
}

#[test]
fn files_do_not_use_each_other_in_circles() {
    let sources: BTreeMap<String, String> = sources().into_iter().filter(|(module, _)| !is_test(module)).collect();
    let file = |path: &str| {
        let fits = |name: &&String| belongs(path, name);
        sources.keys().filter(fits).max_by_key(|name| name.len()).cloned()
    };
    let mut leads: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (module, source) in sources.iter().filter(|(module, _)| *module != "lib") {
        // Items declared in a folder's own file are available to its files.
        let others = reached(module, source).iter().filter_map(|path| file(path)).collect::<BTreeSet<_>>();
        leads.insert(module.clone(), others.into_iter().filter(|other| !belongs(module, other)).collect());
    }
    let reach = |from: &str| {
        let (mut seen, mut next) = (BTreeSet::new(), vec![from.to_owned()]);
        while let Some(one) = next.pop() {
            let further = leads.get(&one).into_iter().flatten().filter(|to| seen.insert((*to).clone()));
            next.extend(further.cloned().collect::<Vec<_>>());
        }
        seen
    };
    let circular: BTreeSet<&String> = leads.keys().filter(|module| reach(module).contains(*module)).collect();
    let known = |module: &&&String| CIRCLES.iter().any(|folder| belongs(module, folder));
    let new: Vec<_> = circular.iter().filter(|module| !known(module)).collect();
    assert!(new.is_empty(), "use each other in circles: {new:?}");
    for folder in CIRCLES {
        assert!(circular.iter().any(|module| belongs(module, folder)), "no circle is left in {folder}");
    }
    assert!(leads.values().map(BTreeSet::len).sum::<usize>() > 300, "uses are found");
}

#[test]
fn words_for_people_stand_in_text_and_rules() {
    for (module, source) in sources() {
        let chinese = source.chars().any(|c| ('\u{4E00}'..='\u{9FFF}').contains(&c));
        // Listings are read in any language.
        let read = module == "readers::listing";
        // A kind of incident is declared with its words, and a record with the documentation of its columns, like a rule.
        let records =
            ["render::table", "render::columns", "render::jsonl::note", "render::jsonl::pdo", "render::jsonl::pdos"];
        let declared = ["rules", "diagnosis::kinds", "diagnosis::sayings", "diagnosis::apart"]
            .iter()
            .chain(&records)
            .any(|room| belongs(&module, room));
        let words = belongs(&module, "text") || belongs(&module, "wire") || declared || is_test(&module) || read;
        assert!(!chinese || words, "{module} holds Chinese words");
    }
}

#[test]
fn only_the_binding_knows_python() {
    for (module, source) in sources() {
        assert!(belongs(&module, "python") || !source.contains("pyo3"), "{module} names pyo3");
    }
}

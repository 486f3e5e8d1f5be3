//! The modules of `src/lib.rs` in their order: the modules that each may use, and the places of text for people.

#![allow(clippy::expect_used, clippy::panic)]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// A module and the modules that it may use.
type Row = (&'static str, &'static [&'static str]);

/// A module (the longest prefix counts) and the modules that it may use; its own files are always allowed.
const MAY_USE: &[Row] = &[
    ("bytes::calendar", &[]),
    ("bytes::frame", &[]),
    ("bytes::select", &[]),
    ("bytes::readers", &["bytes::calendar", "bytes::frame", "bytes::select"]),
    ("bytes::span", &[]),
    ("bytes::info", &["bytes::frame", "bytes::readers", "bytes::span"]),
    ("bytes::inputs", &["bytes::frame", "bytes::readers"]),
    ("bytes::masks", &["bytes::frame"]),
    ("words::digits", &[]),
    ("words::escape", &[]),
    ("sdo::abort_code", &["words::digits"]),
    ("sdo::wire", &[]),
    ("world::od", &[]),
    ("words::profiles", &["world::od"]),
    ("rules", &["bytes::frame", "sdo::abort_code", "sdo::wire", "words::profiles"]),
    ("rules::finding", &["bytes::frame", "sdo::wire", "rules"]),
    ("world::dictionary", &["world::od", "words::profiles"]),
    ("sdo::transfer", &["bytes::frame", "world::od", "rules::finding", "world::dictionary"]),
    ("world::configuration", &["sdo::wire", "world::dictionary", "sdo::transfer"]),
    ("world::drive", &["world::od"]),
    ("wire::cob_id", &["bytes::frame"]),
    ("wire::lss::command", &[]),
    ("wire::message", &["words::profiles", "wire::cob_id", "wire::lss::command", "wire::pdo"]),
    ("wire::pdo", &["bytes::frame", "world::od", "words::profiles", "wire::cob_id", "wire::message"]),
    ("words::lang", &["words::digits"]),
    ("tables::jsonl::object", &["words::digits", "words::escape"]),
    (
        "wire",
        &[
            "bytes::calendar",
            "bytes::frame",
            "words::digits",
            "sdo::wire",
            "world::od",
            "words::profiles",
            "words::lang",
            "tables::jsonl::object",
        ],
    ),
    ("world::node", &["bytes::frame", "world::od", "words::profiles", "world::configuration", "wire::pdo"]),
    (
        "world::change",
        &[
            "bytes::frame",
            "words::profiles",
            "rules::finding",
            "world::drive",
            "wire::cob_id",
            "wire::message",
            "wire",
            "world::node",
        ],
    ),
    (
        "world::event",
        &[
            "bytes::frame",
            "sdo::wire",
            "rules::finding",
            "world::dictionary",
            "sdo::transfer",
            "world::configuration",
            "wire::message",
            "wire::pdo",
            "world::change",
        ],
    ),
    (
        "bytes::writers",
        &[
            "bytes::calendar",
            "bytes::frame",
            "bytes::readers",
            "words::digits",
            "words::escape",
            "rules::finding",
            "world::event",
        ],
    ),
    ("bytes::writers::loss", &[]),
    ("evidence::period", &["bytes::frame"]),
    ("evidence", &["bytes::frame", "rules", "rules::finding", "wire::cob_id"]),
    (
        "world::context",
        &["bytes::frame", "sdo::wire", "rules::finding", "sdo::transfer", "world::change", "world::event", "evidence"],
    ),
    (
        "sdo",
        &[
            "bytes::frame",
            "world::od",
            "words::profiles",
            "rules",
            "rules::finding",
            "world::dictionary",
            "world::event",
            "evidence",
            "world::context",
        ],
    ),
    (
        "usdo",
        &[
            "bytes::frame",
            "world::od",
            "words::profiles",
            "rules",
            "rules::finding",
            "world::dictionary",
            "sdo::abort_code",
            "sdo::transfer",
            "sdo::wire",
            "wire::message",
            "wire",
            "world::node",
            "world::event",
            "evidence",
            "world::context",
            "sdo",
        ],
    ),
    ("world::network", &["bytes::frame", "world::dictionary"]),
    ("world::profile_defaults", &["wire::pdo"]),
    (
        "world::roles",
        &["bytes::frame", "world::configuration", "wire::cob_id", "wire::pdo", "world::node", "world::network"],
    ),
    (
        "checks",
        &[
            "bytes::frame",
            "sdo::wire",
            "world::od",
            "words::profiles",
            "rules",
            "rules::finding",
            "world::dictionary",
            "sdo::transfer",
            "world::configuration",
            "world::drive",
            "wire::cob_id",
            "wire::message",
            "wire::pdo",
            "wire",
            "world::node",
            "world::change",
            "world::event",
            "evidence",
            "world::context",
            "sdo",
            "world::network",
        ],
    ),
    (
        "world::bus",
        &[
            "bytes::frame",
            "sdo::wire",
            "words::profiles",
            "world::dictionary",
            "sdo::transfer",
            "world::configuration",
            "world::drive",
            "wire::cob_id",
            "wire::message",
            "wire::pdo",
            "wire",
            "world::node",
            "world::change",
            "world::event",
            "evidence",
            "world::context",
            "sdo",
            "world::network",
            "world::roles",
            "world::profile_defaults",
            "usdo",
            "checks",
        ],
    ),
    ("views::filter", &["bytes::frame", "sdo::wire", "rules", "rules::finding", "sdo::transfer", "world::event"]),
    (
        "views::inventory",
        &[
            "bytes::frame",
            "sdo::wire",
            "world::od",
            "words::profiles",
            "world::dictionary",
            "sdo::transfer",
            "world::configuration",
            "world::drive",
            "wire::pdo",
            "world::node",
            "world::change",
            "world::event",
            "world::bus",
            "views::filter",
        ],
    ),
    (
        "stories",
        &[
            "sdo::abort_code",
            "bytes::frame",
            "sdo::wire",
            "world::od",
            "rules",
            "rules::finding",
            "sdo::transfer",
            "world::configuration",
            "world::drive",
            "wire::cob_id",
            "wire::lss::command",
            "wire::message",
            "wire::pdo",
            "wire",
            "world::change",
            "world::event",
            "checks",
            "evidence::period",
            "world::bus",
        ],
    ),
    (
        "views::diff",
        &[
            "bytes::frame",
            "sdo::wire",
            "rules::finding",
            "world::dictionary",
            "sdo::transfer",
            "world::drive",
            "wire::cob_id",
            "wire::message",
            "wire::pdo",
            "world::change",
            "world::event",
            "evidence::period",
            "stories",
        ],
    ),
    (
        "words",
        &[
            "bytes::frame",
            "bytes::readers",
            "bytes::masks",
            "sdo::wire",
            "world::od",
            "rules",
            "rules::finding",
            "world::dictionary",
            "sdo::transfer",
            "world::configuration",
            "world::drive",
            "wire::cob_id",
            "wire::message",
            "wire::pdo",
            "wire",
            "world::event",
            "bytes::writers::loss",
            "sdo",
            "world::network",
            "views::filter",
            "views::inventory",
            "stories",
            "views::diff",
        ],
    ),
    ("bytes::writers::mcap", &["bytes::frame", "bytes::readers", "rules::finding", "world::event", "words"]),
    (
        "words::signal",
        &[
            "words::digits",
            "words::escape",
            "sdo::wire",
            "world::od",
            "words::profiles",
            "world::drive",
            "wire::pdo",
            "words",
        ],
    ),
    (
        "bytes::writers::mcap::decoded",
        &[
            "sdo::abort_code",
            "bytes::frame",
            "words::digits",
            "world::od",
            "rules::finding",
            "sdo::transfer",
            "world::drive",
            "wire::message",
            "wire::pdo",
            "wire",
            "world::change",
            "world::event",
            "words",
            "words::signal",
        ],
    ),
    (
        "views::lines",
        &[
            "bytes::frame",
            "bytes::readers",
            "words::digits",
            "sdo::wire",
            "rules::finding",
            "wire::cob_id",
            "wire",
            "world::event",
            "bytes::writers",
            "words",
        ],
    ),
    (
        "views::summary",
        &[
            "sdo::abort_code",
            "bytes::frame",
            "bytes::readers",
            "bytes::span",
            "sdo::wire",
            "words::profiles",
            "rules::finding",
            "sdo::transfer",
            "wire::cob_id",
            "wire::message",
            "wire",
            "world::change",
            "world::event",
            "evidence::period",
            "world::network",
        ],
    ),
    (
        "views::expectation",
        &[
            "sdo::abort_code",
            "bytes::frame",
            "bytes::select",
            "sdo::wire",
            "world::od",
            "words::profiles",
            "rules",
            "rules::finding",
            "sdo::transfer",
            "world::drive",
            "wire::pdo",
            "wire",
            "world::change",
            "world::event",
            "evidence::period",
            "stories",
            "words::signal",
            "views::summary",
        ],
    ),
    (
        "views::finding_context",
        &["bytes::frame", "sdo::wire", "rules", "rules::finding", "wire::cob_id", "wire::message", "world::event"],
    ),
    ("views::repeats", &["bytes::frame", "sdo::wire", "rules::finding", "world::event"]),
    (
        "tables",
        &[
            "sdo::abort_code",
            "bytes::frame",
            "bytes::select",
            "bytes::readers",
            "bytes::info",
            "words::digits",
            "words::escape",
            "sdo::wire",
            "world::od",
            "words::profiles",
            "rules::finding",
            "world::dictionary",
            "sdo::transfer",
            "world::configuration",
            "world::drive",
            "wire::message",
            "wire::pdo",
            "wire",
            "world::node",
            "world::change",
            "world::event",
            "evidence::period",
            "bytes::writers",
            "world::bus",
            "views::inventory",
            "stories",
            "views::diff",
            "words",
            "words::signal",
            "views::lines",
            "views::summary",
            "views::expectation",
            "views::finding_context",
            "views::repeats",
        ],
    ),
    (
        "views::monitor",
        &[
            "bytes::frame",
            "bytes::readers",
            "words::digits",
            "sdo::wire",
            "words::profiles",
            "rules::finding",
            "world::dictionary",
            "sdo::transfer",
            "wire::message",
            "wire::pdo",
            "wire",
            "world::node",
            "world::change",
            "world::event",
            "evidence::period",
            "world::network",
            "world::bus",
            "views::filter",
            "stories",
            "words",
            "views::lines",
            "views::summary",
            "views::finding_context",
            "tables",
        ],
    ),
    (
        "session",
        &[
            "bytes::frame",
            "bytes::select",
            "bytes::readers",
            "bytes::info",
            "bytes::inputs",
            "bytes::masks",
            "sdo::wire",
            "rules",
            "rules::finding",
            "sdo::transfer",
            "wire::pdo",
            "wire",
            "world::node",
            "world::event",
            "bytes::writers",
            "evidence",
            "world::context",
            "world::network",
            "world::bus",
            "views::filter",
            "views::inventory",
            "stories",
            "views::diff",
            "words",
            "views::lines",
            "views::summary",
            "views::expectation",
            "views::finding_context",
            "views::repeats",
            "tables",
            "views::monitor",
        ],
    ),
    ("world::preset", &["world::od", "world::dictionary", "world::configuration", "wire::pdo", "world::node"]),
    ("views::colour", &["rules::finding"]),
    (
        "settings",
        &[
            "bytes::frame",
            "bytes::select",
            "rules",
            "world::drive",
            "wire::cob_id",
            "wire::pdo",
            "world::profile_defaults",
            "stories",
            "views::expectation",
        ],
    ),
    (
        "python",
        &[
            "bytes::frame",
            "bytes::select",
            "bytes::readers",
            "bytes::inputs",
            "bytes::masks",
            "sdo::wire",
            "world::od",
            "words::profiles",
            "rules",
            "world::dictionary",
            "sdo::transfer",
            "wire::pdo",
            "world::node",
            "bytes::writers",
            "world::network",
            "views::filter",
            "stories",
            "views::diff",
            "words",
            "bytes::writers::mcap",
            "views::lines",
            "views::expectation",
            "tables",
            "views::monitor",
            "session",
            "world::preset",
            "views::colour",
            "settings",
        ],
    ),
];

/// Rows that use each other: a service's file creates its messages and events, which contain the service's values.
const KNIT: &[&str] = &["wire::message", "wire::pdo"];

/// Folders whose own file only lists what is in them.
const ROOMS: &[&str] = &["lib", "bytes", "world", "views"];

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

/// Returns the row of a module.
fn row(module: &str) -> Option<Row> {
    MAY_USE.iter().filter(|(name, _)| belongs(module, name)).max_by_key(|(name, _)| name.len()).copied()
}

/// Returns every use of another module: user, path, and the user's row.
fn uses() -> Vec<(String, String, Row)> {
    let mut found = Vec::new();
    for (module, source) in sources().iter().filter(|(module, _)| !ROOMS.contains(&module.as_str()) && !is_test(module))
    {
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
    let room = |name: &'static str| if KNIT.contains(&name) { "wire::message" } else { name };
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
    assert!(circular.is_empty(), "use each other in circles: {circular:?}");
    assert!(leads.values().map(BTreeSet::len).sum::<usize>() > 300, "uses are found");
}

#[test]
fn words_for_people_stand_in_text_and_rules() {
    for (module, source) in sources() {
        let chinese = source.chars().any(|c| ('\u{4E00}'..='\u{9FFF}').contains(&c));
        // Listings are read in any language.
        let read = module == "bytes::readers::listing" || belongs(&module, "bytes::readers::rows");
        // A kind of incident is declared with its words, and a record with the documentation of its columns, like a rule.
        let records =
            ["tables::table", "tables::columns", "tables::jsonl::note", "tables::jsonl::pdo", "tables::jsonl::pdos"];
        let declared = ["rules", "stories::kinds", "stories::sayings", "stories::apart"]
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
        let views = found.iter().filter(|module| ["views", "stories"].iter().any(|room| belongs(module, room)));
        assert_eq!(views.count(), 0, "a view follows {message} instead of changes: {found:?}");
    }
}

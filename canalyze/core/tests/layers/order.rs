//! Modules use only what their row of [`MAY_USE`] names, the table names nothing else, and its rows make no circle.
//!
//! With an order, a module can be read and changed with nothing in mind but the modules before it.

use std::collections::{BTreeMap, BTreeSet};

use crate::may_use::{KNIT, MAY_USE, Row};
use crate::sources::{belongs, is_test, sources, used};

/// Folders whose own file only lists what is in them.
const ROOMS: &[&str] = &["lib", "bytes", "world", "views"];

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

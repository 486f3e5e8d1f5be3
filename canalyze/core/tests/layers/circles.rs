//! Files do not use each other in circles, inside a room either.
//!
//! The order of modules has no row for each file; two files that need each other are one file, or a third is missing.

use std::collections::{BTreeMap, BTreeSet};

use crate::sources::{belongs, is_test, sources, used};

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

//! The colours of lines for people: the one table of them, also for what Python lays out.
//!
//! All of them can be read on a dark and on a light background: none is lighter or darker than a middle grey by much.
//! Numbers are those of the 256 colours of ECMA-48 terminals. Must not: know how a line is made.

use crate::rules::finding::Severity;

/// The end of every colour.
pub const PLAIN: &str = "\x1b[0m";

/// Colours by what they stand for: severities, services by their names in filters, and what a report marks.
pub static COLOURS: &[(&str, &str)] = &[
    ("error", "\x1b[1;38;5;160m"),
    ("warning", "\x1b[38;5;166m"),
    ("info", "\x1b[38;5;30m"),
    ("clean", "\x1b[38;5;28m"),
    ("own", "\x1b[1m"),
    ("quiet", "\x1b[38;5;244m"),
    ("nmt", "\x1b[38;5;133m"),
    ("gfc", "\x1b[38;5;166m"),
    ("flying_master", "\x1b[38;5;133m"),
    ("emcy", "\x1b[38;5;160m"),
    ("pdo", "\x1b[38;5;28m"),
    ("srdo", "\x1b[38;5;28m"),
    ("sdo", "\x1b[38;5;33m"),
    ("heartbeat", "\x1b[38;5;30m"),
    ("guarding", "\x1b[38;5;30m"),
    ("lss", "\x1b[38;5;98m"),
    ("usdo", "\x1b[38;5;33m"),
];

/// Colours of nodes, in turn: neighbours differ.
static NODES: [&str; 7] = [
    "\x1b[38;5;33m",
    "\x1b[38;5;166m",
    "\x1b[38;5;28m",
    "\x1b[38;5;133m",
    "\x1b[38;5;30m",
    "\x1b[38;5;130m",
    "\x1b[38;5;98m",
];

/// The colour of what has this name; that of what is of less interest where it has none.
pub fn named(name: &str) -> &'static str {
    let find = |name: &str| COLOURS.iter().find(|(known, _)| *known == name).map(|(_, colour)| *colour);
    find(name).or_else(|| find("quiet")).unwrap_or(PLAIN)
}

/// The colour of a severity.
pub fn severity(severity: Severity) -> &'static str {
    named(severity.name())
}

/// The colour of a node.
pub fn node(node: Option<u8>) -> &'static str {
    node.and_then(|node| NODES.get(usize::from(node) % NODES.len())).copied().unwrap_or_else(|| named("quiet"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::views::filter::SERVICES;

    #[test]
    fn each_service_and_severity_has_a_colour_of_its_table() {
        for service in SERVICES.iter().filter(|service| !matches!(**service, "sync" | "time" | "error" | "foreign")) {
            assert!(COLOURS.iter().any(|(name, _)| name == service), "{service}");
        }
        assert_eq!(named("sync"), named("quiet"));
        let all: Vec<_> = crate::rules::SEVERITIES.iter().map(|one| severity(*one)).collect();
        assert!(all.windows(2).all(|two| matches!(two, [one, next] if one != next)), "{all:?}");
    }

    #[test]
    fn neighbours_differ() {
        assert!((1..127).all(|one| node(Some(one)) != node(Some(one + 1))));
        assert_eq!(node(None), named("quiet"));
    }
}

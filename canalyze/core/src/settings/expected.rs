//! Files of expectations: their tables and keys, and the permitted combinations of keys.
//!
//! The result is the normalized form that [`crate::views::expectation`] takes: hexadecimal values as numbers, times in ns.
//! Captures are not judged here, and the meaning of an expectation beyond its own table is not known.

use std::iter;

use serde_json::{Map, Value as Json, json};

use super::Mistake;
use super::near::near;
use super::schema::{FoundKeys, Schema, SchemaKey, ValueForm, at, key, needed, row, tables, unknown};
use super::toml::parse;
use super::value::{TomlTable, Value};
use crate::bytes::select::Select;
use crate::problems::kinds::KINDS;
use crate::views::expectation::state_names;
use crate::world::drive::DriveState;

const NS: i64 = 1_000_000_000;
const MS: i64 = 1_000_000;
const US: i64 = 1_000;
const SECONDS: ValueForm = ValueForm::AboveZero(1_000_000_000, NS);
/// The default tolerance of a period.
const TOLERANCE_PERCENT: f64 = 10.0;
/// The default window of the load in ms.
const WINDOW_MS: i64 = 100;

/// The last key of every table.
const BUS: SchemaKey = key("bus", ValueForm::Text);
/// Keys of tables with a period.
const PERIOD: &[SchemaKey] = &[
    key("period_ms", ValueForm::AboveZero(4_000_000, MS)),
    key("period_us", ValueForm::AboveZero(4_000_000_000, US)),
    key("tolerance_ms", ValueForm::FromZero(4_000_000, MS)),
    key("tolerance_us", ValueForm::FromZero(4_000_000_000, US)),
    key("tolerance_percent", ValueForm::Percent(1_000, false)),
];

/// A table of the file, which may occur several times.
struct TableKind {
    name: &'static str,
    own: &'static [SchemaKey],
    /// Keys that other tables share.
    shared: &'static [SchemaKey],
    /// Makes the form for the core.
    normal: fn(&FoundKeys<'_>) -> Result<Json, Mistake>,
}

impl TableKind {
    fn keys(&self) -> Vec<SchemaKey> {
        [self.own, self.shared, &[BUS]].concat()
    }
}

const KINDS_OF: [TableKind; 9] = [
    TableKind {
        name: "sdo",
        own: &[
            needed("node", ValueForm::Node),
            needed("object", ValueForm::Object),
            key("direction", ValueForm::Choice(|| vec!["upload", "download"], "choice")),
            key("value", ValueForm::Any),
            key("data", ValueForm::Data),
            key("outcome", ValueForm::Choice(|| vec!["ok", "aborted", "any"], "choice")),
            key("abort", ValueForm::Abort),
            key("sequence", ValueForm::Text),
            key("count", ValueForm::Whole(1, 1_000_000)),
            key("never", ValueForm::Truth),
            key("within_s", SECONDS),
        ],
        shared: &[],
        normal: sdo,
    },
    TableKind {
        name: "state",
        own: &[
            needed("node", ValueForm::Node),
            key("state", ValueForm::Choice(|| state_names().collect(), "choice")),
            key("drive", ValueForm::Choice(|| DriveState::ALL.map(DriveState::name).to_vec(), "choice")),
            key("axis", ValueForm::Whole(1, 8)),
            key("by_s", SECONDS),
            key("since", ValueForm::Choice(|| vec!["start", "boot-up"], "choice")),
            key("stays", ValueForm::Truth),
        ],
        shared: &[],
        normal: state,
    },
    TableKind {
        name: "signal",
        own: &[needed("select", ValueForm::Selection), key("min", ValueForm::Number), key("max", ValueForm::Number)],
        shared: PERIOD,
        normal: signal,
    },
    TableKind { name: "heartbeat", own: &[needed("node", ValueForm::Node)], shared: PERIOD, normal: heartbeat },
    TableKind { name: "sync", own: &[], shared: PERIOD, normal: |found| Ok(Json::Object(period(found, true)?)) },
    TableKind {
        name: "emcy",
        own: &[
            key("node", ValueForm::Node),
            key("code", ValueForm::EmcyCode),
            needed("occurs", ValueForm::Choice(|| vec!["must", "may", "never"], "choice")),
        ],
        shared: &[],
        normal: |found| {
            Ok(json!({"node": found.json("node"), "code": found.json("code"), "occurs": found.json("occurs")}))
        },
    },
    TableKind {
        name: "problem",
        own: &[
            key("kind", ValueForm::Kinds),
            key("node", ValueForm::Node),
            key("occurs", ValueForm::Often),
            key("ends_within_s", SECONDS),
            key("cause", ValueForm::Kinds),
        ],
        shared: &[],
        normal: problem,
    },
    TableKind {
        name: "latency",
        own: &[
            needed("of", ValueForm::Choice(|| vec!["sdo", "sync", "nmt"], "choice")),
            key("node", ValueForm::Node),
            key("object", ValueForm::Object),
            key("pdo", ValueForm::Tpdo),
            key("max_ms", ValueForm::AboveZero(4_000_000, MS)),
            key("max_us", ValueForm::AboveZero(4_000_000_000, US)),
        ],
        shared: &[],
        normal: latency,
    },
    TableKind {
        name: "load",
        own: &[
            needed("max_percent", ValueForm::Percent(100, true)),
            key("bitrate", ValueForm::BitRate),
            key("window_ms", ValueForm::AboveZero(3_600_000, MS)),
        ],
        shared: &[],
        normal: load,
    },
];

/// The former names of tables, which are still accepted, each before the name of today.
const FORMER: [(&str, &str); 1] = [("incident", "problem")];

/// All of them.
pub(super) fn schema() -> Schema {
    KINDS_OF.iter().map(|kind| row(kind.name, &kind.keys())).collect()
}

/// Reads the content of a file of expectations of this name, and checks every key. Returns the input of
/// [`normalized`](crate::views::expectation::Expectations::normalized): `file`, and a list for each kind.
pub fn expectations(content: &[u8], file: &str) -> Result<Json, Mistake> {
    let root = parse(content, file)?;
    names(&root, file)?;
    let mut all = Map::from_iter([("file".to_owned(), Json::from(file))]);
    for kind in &KINDS_OF {
        let keys = kind.keys();
        let former = FORMER.iter().filter(|(_, today)| *today == kind.name).map(|(name, _)| *name);
        let mut entries = Vec::new();
        for name in iter::once(kind.name).chain(former) {
            let read = |table| FoundKeys::read(file, name, table, &keys, &[]);
            entries.extend(tables(file, &root, name, name)?.into_iter().map(read).collect::<Result<Vec<_>, _>>()?);
        }
        let normal = |found: &FoundKeys<'_>| {
            let mut entry = (kind.normal)(found)?;
            if let Some(entry) = entry.as_object_mut() {
                entry.insert("line".to_owned(), Json::from(found.given.line));
                entry.insert("bus".to_owned(), found.json("bus"));
            }
            Ok(entry)
        };
        all.insert(kind.name.to_owned(), entries.iter().map(normal).collect::<Result<_, Mistake>>()?);
    }
    Ok(Json::Object(all))
}

/// Checks the names at the top.
fn names(root: &TomlTable, file: &str) -> Result<(), Mistake> {
    let allowed: Vec<_> = KINDS_OF.iter().map(|kind| (kind.name, format!("[[{}]]", kind.name))).collect();
    let is_known = |name: &str| allowed.iter().any(|one| one.0 == name) || FORMER.iter().any(|one| one.0 == name);
    match root.keys.iter().find(|(name, _)| !is_known(&name.text)) {
        Some((name, _)) => Err(unknown(&at(file, name.line), "", &name.text, &allowed)),
        None => Ok(()),
    }
}

/// The mistake about a key of the file, with the sentence `expect.WHY`.
fn refuse(found: &FoundKeys<'_>, key: &str, why: &str, other: String) -> Mistake {
    let facts = [
        ("file", at(found.file, found.given.line_of(key))),
        ("key", found.full(key)),
        ("value", found.given.get(key).map(Value::shown).unwrap_or_default()),
        ("other", other),
    ];
    Mistake::new(format!("expect.{why}"), facts)
}

/// The mistake that one of these keys is needed and none is there.
fn lacks(found: &FoundKeys<'_>, keys: &[&str]) -> Mistake {
    let facts =
        [("file", at(found.file, found.given.line)), ("table", found.name.to_owned()), ("keys", keys.join(", "))];
    Mistake::new("expect.lacks_one", facts)
}

/// Returns the one of these keys that is there; two are refused.
fn only(found: &FoundKeys<'_>, keys: &[&str]) -> Result<Option<&'static str>, Mistake> {
    let mut there = found.keys.iter().map(|(name, _)| *name).filter(|name| keys.contains(name));
    match (there.next(), there.next()) {
        (Some(one), Some(other)) => Err(refuse(found, other, "exclusive", one.to_owned())),
        (one, _) => Ok(one),
    }
}

/// Refuses a key together with any of the others.
fn apart(found: &FoundKeys<'_>, key: &str, others: &[&str]) -> Result<(), Mistake> {
    if found.get(key).is_some() {
        for other in others {
            only(found, &[key, other])?;
        }
    }
    Ok(())
}

/// Refuses a key without another one that it needs, which is shown in the form in which it would be written.
fn goes(found: &FoundKeys<'_>, key: &str, allowed: bool, other: &str) -> Result<(), Mistake> {
    if allowed || found.get(key).is_none() { Ok(()) } else { Err(refuse(found, key, "goes_with", other.to_owned())) }
}

/// Returns a period and its tolerance; null for both if there is none.
fn period(found: &FoundKeys<'_>, needed: bool) -> Result<Map<String, Json>, Mistake> {
    let names = ["period_ms", "period_us"];
    let period = only(found, &names)?;
    if needed && period.is_none() {
        return Err(lacks(found, &names));
    }
    let tolerance = only(found, &["tolerance_ms", "tolerance_us", "tolerance_percent"])?;
    let Some(period) = period else {
        return match tolerance {
            Some(key) => Err(refuse(found, key, "goes_with", names.join(", "))),
            None => Ok(periodic(Json::Null, Json::Null)),
        };
    };
    let period_ns = found.json(period);
    let percent = match tolerance {
        Some("tolerance_percent") => found.get("tolerance_percent").and_then(Json::as_f64),
        Some(key) => return Ok(periodic(period_ns, found.json(key))),
        None => None,
    };
    let part = period_ns.as_f64().unwrap_or(0.0) * percent.unwrap_or(TOLERANCE_PERCENT) / 100.0;
    Ok(periodic(period_ns, Json::from(part.round_ties_even() as i64)))
}

fn periodic(period_ns: Json, tolerance_ns: Json) -> Map<String, Json> {
    Map::from_iter([("period_ns".to_owned(), period_ns), ("tolerance_ns".to_owned(), tolerance_ns)])
}

/// Returns index and sub-index of the key `object`.
fn object(found: &FoundKeys<'_>) -> (Json, Json) {
    let part = |place| found.get("object").and_then(|object| object.get(place)).cloned().unwrap_or_default();
    (part(0), part(1))
}

fn sdo(found: &FoundKeys<'_>) -> Result<Json, Mistake> {
    only(found, &["value", "data"])?;
    let never = found.get("never").is_some();
    if found.get("never") == Some(&Json::Bool(false)) {
        return Err(refuse(found, "never", "only_true", String::new()));
    }
    apart(found, "never", &["count", "sequence", "within_s"])?;
    apart(found, "sequence", &["count"])?;
    let otherwise = if found.get("abort").is_some() {
        "aborted"
    } else if never {
        "any"
    } else {
        "ok"
    };
    let outcome = found.get("outcome").and_then(Json::as_str).unwrap_or(otherwise);
    goes(found, "abort", outcome == "aborted", "outcome = \"aborted\"")?;
    goes(found, "value", outcome != "aborted", "outcome = \"ok\"")?;
    goes(found, "data", outcome != "aborted", "outcome = \"ok\"")?;
    let (index, sub) = object(found);
    Ok(json!({
        "node": found.json("node"),
        "index": index,
        "sub": sub,
        "direction": found.json("direction"),
        "value": found.get("value").or_else(|| found.get("data")),
        "outcome": outcome,
        "abort": found.json("abort"),
        "sequence": found.json("sequence"),
        "count": if never { Json::from(0) } else { found.get("count").cloned().unwrap_or_else(|| Json::from(1)) },
        "within_ns": found.json("within_s"),
    }))
}

fn state(found: &FoundKeys<'_>) -> Result<Json, Mistake> {
    let names = ["state", "drive"];
    if only(found, &names)?.is_none() {
        return Err(lacks(found, &names));
    }
    let drive = found.get("drive").is_some();
    goes(found, "axis", drive, "drive")?;
    let stays = found.get("stays") == Some(&Json::Bool(true));
    if stays && found.json("state") == "boot-up" {
        return Err(refuse(found, "stays", "boot_up_passes", String::new()));
    }
    Ok(json!({
        "node": found.json("node"),
        "state": found.json("state"),
        "drive": found.json("drive"),
        "axis": found.get("axis").cloned().or(drive.then(|| Json::from(1))),
        "by_ns": found.json("by_s"),
        "since": found.get("since").and_then(Json::as_str).unwrap_or("start"),
        "stays": stays,
    }))
}

fn signal(found: &FoundKeys<'_>) -> Result<Json, Mistake> {
    let limit = |key: &str| found.get(key).and_then(Json::as_f64);
    if limit("min").zip(limit("max")).is_some_and(|(min, max)| min > max) {
        let min = found.given.get("min").map(Value::shown).unwrap_or_default();
        return Err(refuse(found, "max", "below_min", min));
    }
    let mut entry = period(found, false)?;
    entry.extend(["select", "min", "max"].map(|key| (key.to_owned(), found.json(key))));
    Ok(Json::Object(entry))
}

fn heartbeat(found: &FoundKeys<'_>) -> Result<Json, Mistake> {
    let mut entry = period(found, true)?;
    entry.insert("node".to_owned(), found.json("node"));
    Ok(Json::Object(entry))
}

fn problem(found: &FoundKeys<'_>) -> Result<Json, Mistake> {
    let names = ["occurs", "ends_within_s", "cause"];
    if names.iter().all(|key| found.get(key).is_none()) {
        return Err(lacks(found, &names));
    }
    kinds(found, "kind")?;
    kinds(found, "cause")?;
    let never = found.json("occurs") == json!([0, 0]);
    if let Some(key) = ["ends_within_s", "cause"].into_iter().find(|key| never && found.get(key).is_some()) {
        return Err(refuse(found, key, "exclusive", "occurs = 0".to_owned()));
    }
    Ok(json!({
        "node": found.json("node"),
        "kind": found.json("kind"),
        "occurs": found.json("occurs"),
        "ends_within_ns": found.json("ends_within_s"),
        "cause": found.json("cause"),
    }))
}

/// Refuses a glob that matches no kind of problem, since it could never be found.
fn kinds(found: &FoundKeys<'_>, key: &str) -> Result<(), Mistake> {
    let Some(glob) = found.get(key).and_then(Json::as_str) else { return Ok(()) };
    let fits = Select::parse(glob);
    if KINDS.iter().any(|kind| fits.takes([kind.name])) {
        return Ok(());
    }
    let likest = near(glob, KINDS.iter().map(|kind| kind.name), 3, 0.5);
    let why = if likest.is_empty() { "no_problem" } else { "no_problem_near" };
    Err(refuse(found, key, why, likest.join(", ")))
}

fn latency(found: &FoundKeys<'_>) -> Result<Json, Mistake> {
    let of = found.json("of");
    goes(found, "object", of == "sdo", "of = \"sdo\"")?;
    goes(found, "pdo", of == "sync", "of = \"sync\"")?;
    let names = ["max_ms", "max_us"];
    let most = only(found, &names)?.ok_or_else(|| lacks(found, &names))?;
    let (index, sub) = object(found);
    Ok(json!({
        "node": found.json("node"),
        "of": of,
        "index": index,
        "sub": sub,
        "pdo": found.json("pdo"),
        "max_ns": found.json(most),
    }))
}

fn load(found: &FoundKeys<'_>) -> Result<Json, Mistake> {
    Ok(json!({
        "max_percent": found.json("max_percent"),
        "bit_rate": found.json("bitrate"),
        "window_ns": found.get("window_ms").cloned().unwrap_or_else(|| Json::from(WINDOW_MS * MS)),
    }))
}

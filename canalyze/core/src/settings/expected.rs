//! Files of expectations: their tables and keys, and the permitted combinations of keys.
//!
//! The result is the normalized form that [`crate::views::expectation`] takes: hexadecimal values as numbers, times in ns.
//! Captures are not judged here, and the meaning of an expectation beyond its own table is not known.

use serde_json::{Map, Value as Json, json};

use super::Mistake;
use super::near::near;
use super::schema::{Form, Found, Key, Schema, at, key, needed, row, tables, unknown};
use super::toml::parse;
use super::value::{Table, Value};
use crate::bytes::select::Select;
use crate::stories::kinds::KINDS;
use crate::views::expectation::state_names;
use crate::world::drive::State;

const NS: i64 = 1_000_000_000;
const MS: i64 = 1_000_000;
const US: i64 = 1_000;
const SECONDS: Form = Form::AboveZero(1_000_000_000, NS);
/// The default tolerance of a period.
const TOLERANCE_PERCENT: f64 = 10.0;
/// The default window of the load in ms.
const WINDOW_MS: i64 = 100;

/// The last key of every table.
const BUS: Key = key("bus", Form::Text);
/// Keys of tables with a period.
const PERIOD: &[Key] = &[
    key("period_ms", Form::AboveZero(4_000_000, MS)),
    key("period_us", Form::AboveZero(4_000_000_000, US)),
    key("tolerance_ms", Form::FromZero(4_000_000, MS)),
    key("tolerance_us", Form::FromZero(4_000_000_000, US)),
    key("tolerance_percent", Form::Percent(1_000, false)),
];

/// A table of the file, which may occur several times.
struct Kind {
    name: &'static str,
    own: &'static [Key],
    /// Keys that other tables share.
    shared: &'static [Key],
    /// Makes the form for the core.
    normal: fn(&Found<'_>) -> Result<Json, Mistake>,
}

impl Kind {
    fn keys(&self) -> Vec<Key> {
        [self.own, self.shared, &[BUS]].concat()
    }
}

const KINDS_OF: [Kind; 9] = [
    Kind {
        name: "sdo",
        own: &[
            needed("node", Form::Node),
            needed("object", Form::Object),
            key("direction", Form::Choice(|| vec!["upload", "download"], "choice")),
            key("value", Form::Any),
            key("data", Form::Data),
            key("outcome", Form::Choice(|| vec!["ok", "aborted", "any"], "choice")),
            key("abort", Form::Abort),
            key("sequence", Form::Text),
            key("count", Form::Whole(1, 1_000_000)),
            key("never", Form::Truth),
            key("within_s", SECONDS),
        ],
        shared: &[],
        normal: sdo,
    },
    Kind {
        name: "state",
        own: &[
            needed("node", Form::Node),
            key("state", Form::Choice(|| state_names().collect(), "choice")),
            key("drive", Form::Choice(|| State::ALL.map(State::name).to_vec(), "choice")),
            key("axis", Form::Whole(1, 8)),
            key("by_s", SECONDS),
            key("since", Form::Choice(|| vec!["start", "boot-up"], "choice")),
            key("stays", Form::Truth),
        ],
        shared: &[],
        normal: state,
    },
    Kind {
        name: "signal",
        own: &[needed("select", Form::Selection), key("min", Form::Number), key("max", Form::Number)],
        shared: PERIOD,
        normal: signal,
    },
    Kind { name: "heartbeat", own: &[needed("node", Form::Node)], shared: PERIOD, normal: heartbeat },
    Kind { name: "sync", own: &[], shared: PERIOD, normal: |found| Ok(Json::Object(period(found, true)?)) },
    Kind {
        name: "emcy",
        own: &[
            key("node", Form::Node),
            key("code", Form::EmcyCode),
            needed("occurs", Form::Choice(|| vec!["must", "may", "never"], "choice")),
        ],
        shared: &[],
        normal: |found| {
            Ok(json!({"node": found.json("node"), "code": found.json("code"), "occurs": found.json("occurs")}))
        },
    },
    Kind {
        name: "incident",
        own: &[
            key("kind", Form::Kinds),
            key("node", Form::Node),
            key("occurs", Form::Often),
            key("ends_within_s", SECONDS),
            key("cause", Form::Kinds),
        ],
        shared: &[],
        normal: incident,
    },
    Kind {
        name: "latency",
        own: &[
            needed("of", Form::Choice(|| vec!["sdo", "sync", "nmt"], "choice")),
            key("node", Form::Node),
            key("object", Form::Object),
            key("pdo", Form::Tpdo),
            key("max_ms", Form::AboveZero(4_000_000, MS)),
            key("max_us", Form::AboveZero(4_000_000_000, US)),
        ],
        shared: &[],
        normal: latency,
    },
    Kind {
        name: "load",
        own: &[
            needed("max_percent", Form::Percent(100, true)),
            key("bitrate", Form::BitRate),
            key("window_ms", Form::AboveZero(3_600_000, MS)),
        ],
        shared: &[],
        normal: load,
    },
];

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
        let given = tables(file, &root, kind.name, kind.name)?;
        let read = |table| Found::read(file, kind.name, table, &keys, &[]);
        let entries: Vec<Found<'_>> = given.into_iter().map(read).collect::<Result<_, _>>()?;
        let normal = |found: &Found<'_>| {
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
fn names(root: &Table, file: &str) -> Result<(), Mistake> {
    let allowed: Vec<_> = KINDS_OF.iter().map(|kind| (kind.name, format!("[[{}]]", kind.name))).collect();
    match root.keys.iter().find(|(name, _)| !allowed.iter().any(|one| one.0 == name.text)) {
        Some((name, _)) => Err(unknown(&at(file, name.line), "", &name.text, &allowed)),
        None => Ok(()),
    }
}

/// The mistake about a key of the file, with the sentence `expect.WHY`.
fn refuse(found: &Found<'_>, key: &str, why: &str, other: String) -> Mistake {
    let facts = [
        ("file", at(found.file, found.given.line_of(key))),
        ("key", found.full(key)),
        ("value", found.given.get(key).map(Value::shown).unwrap_or_default()),
        ("other", other),
    ];
    Mistake::new(format!("expect.{why}"), facts)
}

/// The mistake that one of these keys is needed and none is there.
fn lacks(found: &Found<'_>, keys: &[&str]) -> Mistake {
    let facts =
        [("file", at(found.file, found.given.line)), ("table", found.name.to_owned()), ("keys", keys.join(", "))];
    Mistake::new("expect.lacks_one", facts)
}

/// Returns the one of these keys that is there; two are refused.
fn only(found: &Found<'_>, keys: &[&str]) -> Result<Option<&'static str>, Mistake> {
    let mut there = found.keys.iter().map(|(name, _)| *name).filter(|name| keys.contains(name));
    match (there.next(), there.next()) {
        (Some(one), Some(other)) => Err(refuse(found, other, "exclusive", one.to_owned())),
        (one, _) => Ok(one),
    }
}

/// Refuses a key together with any of the others.
fn apart(found: &Found<'_>, key: &str, others: &[&str]) -> Result<(), Mistake> {
    if found.get(key).is_some() {
        for other in others {
            only(found, &[key, other])?;
        }
    }
    Ok(())
}

/// Refuses a key without another one that it needs, which is shown in the form in which it would be written.
fn goes(found: &Found<'_>, key: &str, allowed: bool, other: &str) -> Result<(), Mistake> {
    if allowed || found.get(key).is_none() { Ok(()) } else { Err(refuse(found, key, "goes_with", other.to_owned())) }
}

/// Returns a period and its tolerance; null for both if there is none.
fn period(found: &Found<'_>, needed: bool) -> Result<Map<String, Json>, Mistake> {
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
fn object(found: &Found<'_>) -> (Json, Json) {
    let part = |place| found.get("object").and_then(|object| object.get(place)).cloned().unwrap_or_default();
    (part(0), part(1))
}

fn sdo(found: &Found<'_>) -> Result<Json, Mistake> {
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

fn state(found: &Found<'_>) -> Result<Json, Mistake> {
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

fn signal(found: &Found<'_>) -> Result<Json, Mistake> {
    let limit = |key: &str| found.get(key).and_then(Json::as_f64);
    if limit("min").zip(limit("max")).is_some_and(|(min, max)| min > max) {
        let min = found.given.get("min").map(Value::shown).unwrap_or_default();
        return Err(refuse(found, "max", "below_min", min));
    }
    let mut entry = period(found, false)?;
    entry.extend(["select", "min", "max"].map(|key| (key.to_owned(), found.json(key))));
    Ok(Json::Object(entry))
}

fn heartbeat(found: &Found<'_>) -> Result<Json, Mistake> {
    let mut entry = period(found, true)?;
    entry.insert("node".to_owned(), found.json("node"));
    Ok(Json::Object(entry))
}

fn incident(found: &Found<'_>) -> Result<Json, Mistake> {
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

/// Refuses a glob that matches no kind of incident, since it could never be found.
fn kinds(found: &Found<'_>, key: &str) -> Result<(), Mistake> {
    let Some(glob) = found.get(key).and_then(Json::as_str) else { return Ok(()) };
    let fits = Select::parse(glob);
    if KINDS.iter().any(|kind| fits.takes([kind.name])) {
        return Ok(());
    }
    let likest = near(glob, KINDS.iter().map(|kind| kind.name), 3, 0.5);
    let why = if likest.is_empty() { "no_incident" } else { "no_incident_near" };
    Err(refuse(found, key, why, likest.join(", ")))
}

fn latency(found: &Found<'_>) -> Result<Json, Mistake> {
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

fn load(found: &Found<'_>) -> Result<Json, Mistake> {
    Ok(json!({
        "max_percent": found.json("max_percent"),
        "bit_rate": found.json("bitrate"),
        "window_ns": found.get("window_ms").cloned().unwrap_or_else(|| Json::from(WINDOW_MS * MS)),
    }))
}

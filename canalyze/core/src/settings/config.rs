//! The tables, keys and values of `canalyze.toml`.
//!
//! Their use is not known here, nor whether a named file or rule exists.

use serde::Deserialize;
use serde_json::Value as Json;

use super::Mistake;
use super::schema::{FoundKeys, Schema, SchemaKey, ValueForm, at, key, needed, no_table, row, tables, unknown};
use super::toml::parse;
use super::value::{TomlTable, Value};
use crate::bytes::ns::Ns;
use crate::rules::SEVERITIES;

const TOP: [SchemaKey; 3] = [
    key("lang", ValueForm::Choice(|| vec!["zh", "en"], "choice")),
    key("jitter_us", ValueForm::Microseconds(false)),
    key("bitrate", ValueForm::BitRate),
];
const SYNC: [SchemaKey; 2] =
    [key("period_us", ValueForm::Microseconds(true)), key("window_us", ValueForm::Microseconds(true))];
const CHECK: [SchemaKey; 6] = [
    key("fail_on", ValueForm::Choice(|| severities().rev().chain(["never"]).collect(), "threshold")),
    key("problems", ValueForm::Choice(|| vec!["open", "ended", "never"], "choice")),
    // The former spelling of `problems`.
    key("incidents", ValueForm::Choice(|| vec!["stands", "over", "never"], "choice")),
    key("select", ValueForm::Codes),
    key("ignore", ValueForm::Codes),
    key("baseline", ValueForm::Text),
];
const OVERRIDE: [SchemaKey; 6] = [
    needed("codes", ValueForm::Codes),
    needed("severity", ValueForm::Choice(|| std::iter::once("ignore").chain(severities()).collect(), "ruling")),
    needed("reason", ValueForm::Text),
    key("files", ValueForm::Globs),
    key("nodes", ValueForm::SeveralNodes),
    key("bus", ValueForm::Text),
];
/// Tables that may occur several times.
const ENTRIES: [(&str, &[SchemaKey]); 3] = [("eds", &EDS), ("cob", &COB), ("sdo", &SDO)];
const EDS: [SchemaKey; 3] =
    [needed("file", ValueForm::Text), key("node", ValueForm::Nodes), key("bus", ValueForm::Text)];
const COB: [SchemaKey; 4] = [
    needed("id", ValueForm::CanId),
    needed("node", ValueForm::Node),
    needed("pdo", ValueForm::Pdo),
    key("bus", ValueForm::Text),
];
const SDO: [SchemaKey; 4] = [
    needed("client", ValueForm::CanId),
    needed("server", ValueForm::CanId),
    needed("node", ValueForm::Node),
    key("bus", ValueForm::Text),
];

fn severities() -> impl DoubleEndedIterator<Item = &'static str> {
    SEVERITIES.iter().map(|one| one.name())
}

/// All of them.
pub(super) fn schema() -> Schema {
    let once: [(&str, &[SchemaKey]); 4] =
        [("", &TOP), ("sync", &SYNC), ("check", &CHECK), ("check.override", &OVERRIDE)];
    once.into_iter().chain(ENTRIES).map(|(name, keys)| row(name, keys)).collect()
}

/// The content of `canalyze.toml`; what it does not set is `None` or empty.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Config {
    /// zh or en.
    pub lang: Option<String>,
    /// Files that describe devices.
    pub descriptions: Vec<Description>,
    /// COB-IDs of PDOs.
    pub cobs: Vec<CobSetting>,
    /// SDO channels.
    pub sdos: Vec<SdoIds>,
    /// 1006h and 1007h, above zero.
    pub sync_period_ns: Option<Ns>,
    /// 1007h.
    pub sync_window_ns: Option<Ns>,
    /// Tolerance for errors of timestamps.
    pub jitter_ns: Option<Ns>,
    /// In bit/s.
    pub bit_rate: Option<u32>,
    /// The table `[check]`, if there is one.
    pub check: Option<CheckSettings>,
}

/// A file that describes devices.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct Description {
    /// `None`: every bus.
    pub bus: Option<String>,
    /// Empty: the node that the file names.
    #[serde(default, rename = "node")]
    pub nodes: Vec<u8>,
    /// As written, relative to the file that names it.
    pub file: String,
}

/// The PDO that an identifier carries.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct CobSetting {
    /// `None`: every bus.
    pub bus: Option<String>,
    /// The identifier; true if it has 29 bits.
    pub id: (u32, bool),
    /// Node-ID.
    pub node: u8,
    /// True for a TPDO; the PDO number.
    pub pdo: (bool, u16),
}

/// The two identifiers of an SDO channel.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct SdoIds {
    /// `None`: every bus.
    pub bus: Option<String>,
    /// Client to server; true if it has 29 bits.
    pub client: (u32, bool),
    /// Server to client.
    pub server: (u32, bool),
    /// Node-ID of the server.
    pub node: u8,
}

/// The findings of a capture that count.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct CheckSettings {
    /// The least severity that fails, or never.
    pub fail_on: Option<String>,
    /// The problems that fail: open, ended or never.
    pub problems: Option<String>,
    /// The same in the former spelling: stands, over or never.
    pub incidents: Option<String>,
    /// Codes, or their beginnings, of the findings that are judged.
    #[serde(default)]
    pub select: Vec<String>,
    /// Codes, or their beginnings, of the findings that are not.
    #[serde(default)]
    pub ignore: Vec<String>,
    /// The file of known findings, as written.
    pub baseline: Option<String>,
    /// FILE:LINE of `select` and of `ignore`.
    #[serde(skip)]
    pub at: (String, String),
    /// Findings with another severity.
    #[serde(skip)]
    pub overrides: Vec<Override>,
}

/// Findings that get another severity for a reason.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct Override {
    /// Codes, or their beginnings.
    pub codes: Vec<String>,
    /// A severity, or ignore.
    pub severity: String,
    /// The reason.
    pub reason: String,
    /// Globs; empty: every file.
    #[serde(default)]
    pub files: Vec<String>,
    /// Empty: every node.
    #[serde(default)]
    pub nodes: Vec<u8>,
    /// `None`: every bus.
    pub bus: Option<String>,
    /// FILE:LINE of its codes.
    #[serde(skip)]
    pub at: String,
}

/// Reads the content of a `canalyze.toml` of this name, and checks every key.
pub fn settings(content: &[u8], file: &str) -> Result<Config, Mistake> {
    let root = parse(content, file)?;
    names(&root, file)?;
    let others: Vec<&str> = ENTRIES.iter().map(|entry| entry.0).chain(["sync", "check"]).collect();
    let top = FoundKeys::read(file, "", &root, &TOP, &others)?;
    let sync = match one(&root, "sync", file)? {
        Some(table) => FoundKeys::read(file, "sync", table, &SYNC, &[])?.keys,
        None => Vec::new(),
    };
    let sync = |key: &str| sync.iter().find(|(name, _)| *name == key).and_then(|(_, ns)| ns.as_i64()).map(Ns);
    let entries = |name, keys| -> Result<Vec<Json>, Mistake> {
        let given = tables(file, &root, name, name)?;
        given.into_iter().map(|table| Ok(FoundKeys::read(file, name, table, keys, &[])?.into_json())).collect()
    };
    let descriptions = typed(entries("eds", &EDS)?);
    let cobs = typed(entries("cob", &COB)?);
    let sdos: Vec<SdoIds> = typed(entries("sdo", &SDO)?);
    for (channel, table) in sdos.iter().zip(tables(file, &root, "sdo", "sdo")?) {
        if channel.client == channel.server {
            let value = table.get("server").map(Value::shown).unwrap_or_default();
            let facts =
                [("file", at(file, table.line_of("server"))), ("key", "sdo.server".to_owned()), ("value", value)];
            return Err(Mistake::new("config.one_id", facts));
        }
    }
    Ok(Config {
        lang: top.get("lang").and_then(Json::as_str).map(str::to_owned),
        descriptions,
        cobs,
        sdos,
        sync_period_ns: sync("period_us"),
        sync_window_ns: sync("window_us"),
        jitter_ns: top.get("jitter_us").and_then(Json::as_i64).map(Ns),
        bit_rate: top.get("bitrate").and_then(Json::as_u64).and_then(|rate| u32::try_from(rate).ok()),
        check: check(&root, file)?,
    })
}

/// Checks the names at the top.
fn names(root: &TomlTable, file: &str) -> Result<(), Mistake> {
    let keys = TOP.iter().map(|key| (key.name, key.name.to_owned()));
    let once = ["sync", "check"].map(|name| (name, format!("[{name}]")));
    let several = ENTRIES.iter().map(|(name, _)| (*name, format!("[[{name}]]")));
    let allowed: Vec<_> = keys.chain(once).chain(several).collect();
    match root.keys.iter().find(|(name, _)| !allowed.iter().any(|one| one.0 == name.text)) {
        Some((name, _)) => Err(unknown(&at(file, name.line), "", &name.text, &allowed)),
        None => Ok(()),
    }
}

/// Returns a table that may occur once.
fn one<'a>(root: &'a TomlTable, name: &str, file: &str) -> Result<Option<&'a TomlTable>, Mistake> {
    match root.get(name) {
        Some(Value::Table(table)) => Ok(Some(table)),
        Some(_) => Err(no_table(at(file, root.line_of(name)), name, format!("[{name}]"))),
        None => Ok(None),
    }
}

fn check(root: &TomlTable, file: &str) -> Result<Option<CheckSettings>, Mistake> {
    let Some(table) = one(root, "check", file)? else { return Ok(None) };
    let own = FoundKeys::read(file, "check", table, &CHECK, &["override"])?.into_json();
    let place = |table: &TomlTable, key: &str| at(file, table.line_of(key));
    let given = tables(file, table, "override", "check.override")?;
    let read = |table: &&TomlTable| Ok(FoundKeys::read(file, "check.override", table, &OVERRIDE, &[])?.into_json());
    let overrides: Vec<Override> = typed(given.iter().map(read).collect::<Result<_, Mistake>>()?);
    let placed = |(one, table): (Override, &&TomlTable)| Override { at: place(table, "codes"), ..one };
    Ok(typed(vec![own]).pop().map(|own| CheckSettings {
        at: (place(table, "select"), place(table, "ignore")),
        overrides: overrides.into_iter().zip(&given).map(placed).collect(),
        ..own
    }))
}

/// Converts checked values; the keys guarantee their types.
fn typed<T: for<'de> Deserialize<'de>>(read: Vec<Json>) -> Vec<T> {
    let typed: Vec<T> = read.iter().filter_map(|one| T::deserialize(one).ok()).collect();
    debug_assert_eq!(typed.len(), read.len(), "{read:?}");
    typed
}

//! The keys of a table, the syntax of their values, and the reports about unreadable ones.
//!
//! A value becomes JSON: hexadecimal values are numbers, times are in ns. The relations between the keys of a table are
//! not known here.

use serde_json::{Value as Json, json};

use super::Mistake;
use super::near::near;
use super::spelled::{self, once};
use super::value::{TomlTable, Value, short};
use crate::bytes::select::Select;

/// Maximum length of a glob of file names in characters; file names are hardly longer.
const GLOB: usize = 500;
/// Maximum length of a name that is compared with others, in characters.
const COMPARED: usize = 128;
/// Maximum number of occurrences.
const OFTEN: u32 = 1_000_000;

/// Words to choose from.
pub(super) type Choices = fn() -> Vec<&'static str>;

/// The syntax of a value.
#[derive(Clone, Copy, Debug)]
pub(super) enum ValueForm {
    Text,
    /// A selection of signals.
    Selection,
    /// One of some words, and the sentence about it.
    Choice(Choices, &'static str),
    Truth,
    Number,
    /// A whole number between two limits.
    Whole(i128, i128),
    /// A time above zero: the maximum in units, and the length of a unit in ns.
    AboveZero(u32, i64),
    /// Likewise, or zero.
    FromZero(u32, i64),
    /// A percentage up to this; true if it must be above zero.
    Percent(u32, bool),
    /// Microseconds in the range of an object; true if they must be above zero.
    Microseconds(bool),
    Node,
    Nodes,
    SeveralNodes,
    Codes,
    Globs,
    BitRate,
    CanId,
    Pdo,
    Tpdo,
    Object,
    Any,
    Data,
    Abort,
    EmcyCode,
    Kinds,
    Often,
}

/// A key.
#[derive(Clone, Copy, Debug)]
pub(super) struct SchemaKey {
    pub(super) name: &'static str,
    pub(super) form: ValueForm,
    pub(super) needed: bool,
}

/// A key that may be left out.
pub(super) const fn key(name: &'static str, form: ValueForm) -> SchemaKey {
    SchemaKey { name, form, needed: false }
}

/// A key that is required.
pub(super) const fn needed(name: &'static str, form: ValueForm) -> SchemaKey {
    SchemaKey { name, form, needed: true }
}

/// Every table of a kind of file by its name, with its keys; each key with its sentence and its permitted values. Keys
/// outside of tables belong to a table without a name.
pub type Schema = Vec<(&'static str, Vec<(&'static str, &'static str, String)>)>;

/// A table and its keys as a row of [`Schema`].
pub(super) fn row(name: &'static str, keys: &[SchemaKey]) -> (&'static str, Vec<(&'static str, &'static str, String)>) {
    (name, keys.iter().map(|key| (key.name, key.form.name(), key.form.allowed())).collect())
}

/// The values of a table, in the order of the file.
#[derive(Debug)]
pub(super) struct FoundKeys<'a> {
    /// The name of the file, and of the table.
    pub(super) file: &'a str,
    pub(super) name: &'static str,
    /// The table as written.
    pub(super) given: &'a TomlTable,
    pub(super) keys: Vec<(&'static str, Json)>,
}

impl<'a> FoundKeys<'a> {
    /// Reads the keys of a table, except `but`, which the caller reads.
    pub(super) fn read(
        file: &'a str,
        name: &'static str,
        given: &'a TomlTable,
        keys: &[SchemaKey],
        but: &[&str],
    ) -> Result<Self, Mistake> {
        let mut found = Self { file, name, given, keys: Vec::new() };
        for (written, value) in given.keys.iter().filter(|(written, _)| !but.contains(&written.text.as_str())) {
            let Some(key) = keys.iter().find(|key| key.name == written.text) else {
                let allowed: Vec<_> = keys.iter().map(|key| (key.name, key.name.to_owned())).collect();
                return Err(unknown(&at(file, written.line), name, &written.text, &allowed));
            };
            let read = key.form.read(value).ok_or_else(|| {
                let facts = [
                    ("file", at(file, written.line)),
                    ("key", found.full(key.name)),
                    ("value", value.shown()),
                    ("allowed", key.form.allowed()),
                ];
                Mistake::new(format!("config.{}", key.form.name()), facts)
            })?;
            found.keys.push((key.name, read));
        }
        match keys.iter().find(|key| key.needed && found.get(key.name).is_none()) {
            Some(key) => {
                let facts = [("file", at(file, given.line)), ("key", found.full(key.name))];
                Err(Mistake::new("config.lacks", facts))
            }
            None => Ok(found),
        }
    }

    /// The name of a key with that of its table.
    pub(super) fn full(&self, key: &str) -> String {
        full(self.name, key)
    }

    /// Returns the value of a key.
    pub(super) fn get(&self, key: &str) -> Option<&Json> {
        self.keys.iter().find(|(name, _)| *name == key).map(|(_, value)| value)
    }

    /// Returns the value of a key, or null.
    pub(super) fn json(&self, key: &str) -> Json {
        self.get(key).cloned().unwrap_or_default()
    }

    /// Returns all values as an object.
    pub(super) fn into_json(self) -> Json {
        self.keys.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
    }
}

fn full(table: &str, key: &str) -> String {
    if table.is_empty() { key.to_owned() } else { format!("{table}.{key}") }
}

/// Formats FILE:LINE; line 0 is the file as a whole.
pub(super) fn at(file: &str, line: usize) -> String {
    if line == 0 { file.to_owned() } else { format!("{file}:{line}") }
}

/// The mistake that there is no such key, with similar names. `allowed`: names, and the syntax of each.
pub(super) fn unknown(at: &str, table: &str, name: &str, allowed: &[(&str, String)]) -> Mistake {
    let lowered: String = name.chars().take(COMPARED).collect::<String>().to_lowercase();
    let likest = near(&lowered, allowed.iter().map(|one| one.0), 1, 0.7).into_iter().next();
    let listed: Vec<&str> = allowed.iter().map(|one| one.1.as_str()).collect();
    let facts = [("file", at.to_owned()), ("key", short(&full(table, name))), ("allowed", listed.join(", "))];
    match allowed.iter().find(|one| Some(one.0) == likest) {
        Some((_, written)) => {
            let [file, key, listed] = facts;
            Mistake::new("config.unknown_near", [file, key, ("near", written.clone()), listed])
        }
        None => Mistake::new("config.unknown", facts),
    }
}

/// The mistake that a value is not a table of this kind.
pub(super) fn no_table(at: String, key: &str, table: String) -> Mistake {
    Mistake::new("config.table", [("file", at), ("key", key.to_owned()), ("table", table)])
}

/// Returns all tables of one name, `[[NAME]]`, of a table that has them under `key`.
pub(super) fn tables<'a>(
    file: &str,
    within: &'a TomlTable,
    key: &str,
    name: &'static str,
) -> Result<Vec<&'a TomlTable>, Mistake> {
    let given = within.get(key);
    let list = match given {
        Some(Value::List(list)) => list.as_slice(),
        Some(_) => return Err(no_table(at(file, within.line_of(key)), name, format!("[[{name}]]"))),
        None => &[],
    };
    let table = |one: &'a Value| match one {
        Value::Table(table) => Ok(table),
        _ => Err(no_table(at(file, within.line_of(key)), name, format!("[[{name}]]"))),
    };
    list.iter().map(table).collect()
}

impl ValueForm {
    /// The key of the sentence about a value that does not have this form, `config.NAME`.
    fn name(self) -> &'static str {
        match self {
            Self::Text | Self::Selection => "text",
            Self::Choice(_, sentence) => sentence,
            Self::Truth => "truth",
            Self::Number => "number",
            Self::Whole(..) => "whole",
            Self::AboveZero(..) | Self::Percent(_, true) => "above_zero",
            Self::FromZero(..) | Self::Percent(_, false) => "from_zero",
            Self::Microseconds(true) => "period",
            Self::Microseconds(false) => "tolerance",
            Self::Node => "node",
            Self::Nodes => "nodes",
            Self::SeveralNodes => "several_nodes",
            Self::Codes => "codes",
            Self::Globs => "globs",
            Self::BitRate => "bit_rate",
            Self::CanId => "can_id",
            Self::Pdo => "pdo",
            Self::Tpdo => "tpdo",
            Self::Object => "object",
            Self::Any => "value",
            Self::Data => "data",
            Self::Abort => "abort",
            Self::EmcyCode => "emcy_code",
            Self::Kinds => "problem_kind",
            Self::Often => "often",
        }
    }

    /// The permitted values, for a sentence that does not name them.
    fn allowed(self) -> String {
        match self {
            Self::Choice(words, _) => words().iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(", "),
            Self::Whole(least, most) => format!("{least}-{most}"),
            Self::AboveZero(most, _) | Self::FromZero(most, _) | Self::Percent(most, _) => most.to_string(),
            _ => String::new(),
        }
    }

    /// Reads a value; `None` if it is not permitted.
    fn read(self, value: &Value) -> Option<Json> {
        match self {
            Self::Text => written(value).map(Json::from),
            Self::Selection => written(value).filter(|text| !Select::parse(text).is_everything()).map(Json::from),
            Self::Choice(words, _) => written(value).filter(|text| words().contains(text)).map(Json::from),
            Self::Truth => match value {
                Value::Truth(truth) => Some(Json::from(*truth)),
                _ => None,
            },
            Self::Number => number(value),
            Self::Whole(least, most) => match value {
                Value::Whole(number) if (least..=most).contains(number) => number_of(*number),
                _ => None,
            },
            Self::AboveZero(most, unit_ns) => time(value, most, unit_ns).filter(|ns| *ns > 0).map(Json::from),
            Self::FromZero(most, unit_ns) => time(value, most, unit_ns).map(Json::from),
            Self::Percent(most, above) => number(value).filter(|percent| {
                let percent = percent.as_f64().unwrap_or(f64::NAN);
                (0.0..=f64::from(most)).contains(&percent) && (!above || percent > 0.0)
            }),
            Self::Microseconds(above) => {
                time(value, spelled::LONGEST_US, 1_000).filter(|ns| !above || *ns > 0).map(Json::from)
            }
            Self::Node => node(value).map(Json::from),
            Self::Nodes => nodes(value).map(Json::from),
            Self::SeveralNodes => {
                let all: Option<Vec<Vec<u8>>> = each(value).map(nodes).collect();
                some(once(all?.into_iter().flatten()))
            }
            Self::Codes => {
                let texts: Option<Vec<&str>> = each(value).map(written).collect();
                texts
                    .filter(|texts| !texts.is_empty())
                    .and_then(|texts| spelled::codes(&texts.join(",")))
                    .map(Json::from)
            }
            Self::Globs => {
                let fits = |text: &&str| text.chars().count() <= GLOB;
                some(each(value).map(|one| written(one).filter(fits)).collect::<Option<Vec<_>>>()?)
            }
            Self::BitRate => match value {
                Value::Whole(number) => spelled::bit_rate(&number.to_string()),
                Value::Text(text) => spelled::bit_rate(text),
                _ => None,
            }
            .map(Json::from),
            Self::CanId => spelled::can_id(written(value)?).map(|(id, extended)| json!([id, extended])),
            Self::Pdo => spelled::pdo(written(value)?).map(|(transmit, number)| json!([transmit, number])),
            Self::Tpdo => spelled::pdo(written(value)?).filter(|pdo| pdo.0).map(|pdo| Json::from(pdo.1)),
            Self::Object => match spelled::address(written(value)?)? {
                (index, Some(sub)) => Some(json!([index, sub])),
                (_, None) => None,
            },
            Self::Any => any(value),
            Self::Data => match value {
                Value::Text(text) => bytes(text).map(|digits| json!({ "data": digits })),
                _ => None,
            },
            Self::Abort => {
                let text = written(value)?;
                spelled::hexadecimal(text, 8..=8).or_else(|| spelled::hexadecimal(text, 2..=2)).map(Json::from)
            }
            Self::EmcyCode => emcy_code(written(value)?).map(|(code, mask)| json!([code, mask])),
            Self::Kinds => written(value).filter(|text| is_kind(text)).map(Json::from),
            Self::Often => often(value),
        }
    }
}

/// Returns a text that is not empty.
fn written(value: &Value) -> Option<&str> {
    match value {
        Value::Text(text) if !text.is_empty() => Some(text),
        _ => None,
    }
}

/// Returns the values of a list, or the single value.
fn each(value: &Value) -> std::slice::Iter<'_, Value> {
    match value {
        Value::List(list) => list.iter(),
        _ => std::slice::from_ref(value).iter(),
    }
}

/// Returns a list that is not empty.
fn some<T: Into<Json>>(list: Vec<T>) -> Option<Json> {
    (!list.is_empty()).then(|| Json::from(list))
}

fn number_of(number: i128) -> Option<Json> {
    u64::try_from(number).map(Json::from).or_else(|_| i64::try_from(number).map(Json::from)).ok()
}

/// Returns a finite number.
fn number(value: &Value) -> Option<Json> {
    match value {
        Value::Whole(number) => number_of(*number).or_else(|| some_real(*number as f64)),
        Value::Real(number) | Value::Huge(_, number) => some_real(*number),
        _ => None,
    }
}

fn some_real(number: f64) -> Option<Json> {
    serde_json::Number::from_f64(number).map(Json::Number)
}

/// Returns a number of units from zero on, in ns.
fn time(value: &Value, most: u32, unit_ns: i64) -> Option<i64> {
    match value {
        Value::Whole(number) if (0..=i128::from(most)).contains(number) => {
            i64::try_from(*number).ok()?.checked_mul(unit_ns)
        }
        Value::Real(number) if (0.0..=f64::from(most)).contains(number) => {
            Some((number * unit_ns as f64).round_ties_even() as i64)
        }
        _ => None,
    }
}

fn node(value: &Value) -> Option<u8> {
    match value {
        Value::Whole(number) => u8::try_from(*number).ok().filter(|node| (1..=127).contains(node)),
        _ => None,
    }
}

/// Returns node-IDs: one, a list, or a text of them.
fn nodes(value: &Value) -> Option<Vec<u8>> {
    if let Value::Text(text) = value {
        return spelled::nodes(text);
    }
    let all: Option<Vec<u8>> = each(value).map(node).collect();
    all.map(once).filter(|nodes| !nodes.is_empty())
}

/// Returns a value of an object: any that TOML has a simple type for.
fn any(value: &Value) -> Option<Json> {
    match value {
        Value::Truth(truth) => Some(json!({ "bool": truth })),
        Value::Text(text) => Some(json!({ "text": text })),
        Value::Whole(number) => number_of(*number).map(|number| json!({ "number": number })),
        Value::Real(number) => some_real(*number).map(|number| json!({ "number": number })),
        _ => None,
    }
}

/// Returns the digits of pairs of hexadecimal digits, which may have blanks between them.
fn bytes(text: &str) -> Option<String> {
    let mut digits = String::new();
    for word in text.split(|c: char| c.is_ascii_whitespace() || c == '\u{B}').filter(|word| !word.is_empty()) {
        if word.len() % 2 != 0 || !word.bytes().all(|byte| byte.is_ascii_hexdigit()) {
            return None;
        }
        digits.push_str(&word.to_ascii_uppercase());
    }
    Some(digits)
}

/// Returns the value and the mask of an error code: `81xx` is any of 8100h to 81FFh.
fn emcy_code(text: &str) -> Option<(u16, u16)> {
    let read = |text: &str| {
        let text = text.strip_suffix(['h', 'H']).unwrap_or(text);
        let digits = text.trim_end_matches(['x', 'X']);
        let open = text.len() - digits.len();
        let fits = text.len() == 4 && open < 4 && digits.bytes().all(|byte| byte.is_ascii_hexdigit());
        let value = fits.then(|| u16::from_str_radix(digits, 16).ok()).flatten()?;
        let shift = 4 * u32::try_from(open).ok()?;
        Some((value << shift, u16::MAX << shift))
    };
    // 0xxx is a complete code, not a prefix.
    read(text).or_else(|| read(spelled::without(text, "0x")?))
}

/// Returns true if a text is a kind of problem or a glob.
fn is_kind(text: &str) -> bool {
    text.len() <= 64 && text.bytes().all(|byte| byte.is_ascii_lowercase() || matches!(byte, b'?' | b'*' | b'-'))
}

/// Returns a number of occurrences: a number, or a range in quotes with an end that may be open.
fn often(value: &Value) -> Option<Json> {
    let count = |text: &str| {
        let fits = (1..=7).contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_digit());
        fits.then(|| text.parse::<u32>().ok()).flatten()
    };
    match value {
        Value::Whole(number) if (0..=i128::from(OFTEN)).contains(number) => {
            number_of(*number).map(|number| json!([number, number]))
        }
        Value::Text(text) => {
            let (least, most) = text.trim().split_once('-')?;
            let (least, most) = (count(least.trim_end())?, most.trim_start());
            let most = if most.is_empty() { None } else { Some(count(most)?) };
            (least <= most.unwrap_or(OFTEN) && most.unwrap_or(OFTEN) <= OFTEN).then(|| json!([least, most]))
        }
        _ => None,
    }
}

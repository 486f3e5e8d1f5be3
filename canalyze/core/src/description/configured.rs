//! The values of a configured device put into a description: a DCF with ParameterValue and a node-ID.
//!
//! The text of the description stays as it is: lines are put beside its own.

use std::collections::{BTreeMap, BTreeSet};

use super::encoding::decode;
use super::ini::{Section, Sections, lines, parse};
use super::number::spelled;
use super::objects::place;
use super::{Defects, FiledObject, Unusable, read};
use crate::world::od::DataType;

/// As CiA 306 spells it.
const COMMISSIONING: &str = "DeviceComissioning";
const DOMAIN: u8 = 2;
const VAR: u8 = 7;

/// A DCF.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Dcf {
    /// The text.
    pub text: String,
    /// Index and sub-index of values that the description has no object for, or cannot hold.
    pub left_out: Vec<(u16, u8)>,
}

/// Puts transferred values into a description. `keys` are those of FileInfo.
pub fn configured(
    description: &[u8],
    values: &BTreeMap<(u16, u8), Vec<u8>>,
    node: u8,
    keys: &[(String, String)],
) -> Result<Dcf, Unusable> {
    let objects = read(description, String::new())?.objects;
    let text = decode(description).text;
    let mut sheet = Sheet::new(&text);
    let mut left_out = Vec::new();
    for (address, data) in values {
        if sheet.value(&objects, *address, data).is_none() {
            left_out.push(*address);
        }
    }
    sheet.keep(COMMISSIONING, &[("NodeID".to_owned(), node.to_string())]);
    sheet.keep("FileInfo", keys);
    sheet.lists();
    let ending = if text.contains("\r\n") { "\r\n" } else { "\n" };
    Ok(Dcf { text: sheet.lines().join(ending), left_out })
}

/// Index, sub-index, and the part in small letters of a section.
type SectionKey = (u16, Option<u8>, String);

/// The lines of a description, and the places of its keys.
struct Sheet {
    lines: Vec<String>,
    sections: Sections,
    places: BTreeMap<SectionKey, String>,
    /// Lines behind a line, by its number.
    behind: BTreeMap<usize, Vec<String>>,
    /// Keys of sections that are not there.
    further: Vec<(String, Vec<String>)>,
    /// Values of arrays without sections of their own, by index.
    listed: BTreeMap<u16, BTreeMap<u8, String>>,
}

impl Sheet {
    fn new(text: &str) -> Self {
        let mut all: Vec<String> = lines(text).map(str::to_owned).collect();
        while all.len() > 1 && all.last().is_some_and(String::is_empty) {
            all.pop();
        }
        let sections = parse(text, &mut Defects::default());
        let mut places = BTreeMap::new();
        for section in sections.iter() {
            if let Some(found) = place(&section.name) {
                let part = (found.index, found.sub, found.part.to_ascii_lowercase());
                places.insert(part, section.name.to_lowercase());
            }
        }
        Self { lines: all, sections, places, behind: BTreeMap::new(), further: Vec::new(), listed: BTreeMap::new() }
    }

    fn section(&self, index: u16, sub: Option<u8>, part: &str) -> Option<&Section> {
        self.sections.get(self.places.get(&(index, sub, part.to_owned()))?)
    }

    /// Gives an object a ParameterValue; `None` if there is no place for it.
    fn value(&mut self, objects: &[FiledObject], (index, sub): (u16, u8), data: &[u8]) -> Option<()> {
        let object = objects.get(objects.binary_search_by_key(&index, |object| object.index).ok()?)?;
        let entry = object.entries.iter().find(|entry| entry.sub == sub)?;
        let value = spelled(data, DataType::from_code(entry.data_type)?)?;
        let is_alone = matches!(object.code, VAR | DOMAIN);
        let head = self.section(index, None, "");
        let section = if is_alone { head } else { self.section(index, Some(sub), "") };
        if let Some(name) = section.map(|section| section.name.to_lowercase()) {
            self.set(&name, "ParameterValue", &value);
        } else {
            head?.get("compactsubobj")?;
            self.listed.entry(index).or_default().insert(sub, value);
        }
        Some(())
    }

    /// Adds the values of arrays without sections of their own.
    fn lists(&mut self) {
        for (index, values) in std::mem::take(&mut self.listed) {
            let given = self.section(index, None, "value");
            let name = given.map_or_else(|| format!("{index:04X}Value"), |section| section.name.clone());
            let pairs = given.map_or(&[][..], Section::pairs);
            let known = pairs.iter().filter(|pair| pair.name.bytes().all(|digit| digit.is_ascii_digit()));
            let mut all: BTreeSet<String> = known.map(|pair| pair.name.clone()).collect();
            all.extend(values.keys().map(u8::to_string));
            let mut keys = vec![("NrOfEntries".to_owned(), all.len().to_string())];
            keys.extend(values.into_iter().map(|(sub, value)| (sub.to_string(), value)));
            self.keep(&name, &keys);
        }
    }

    /// Gives a section these keys; one that is not there comes at the end.
    fn keep(&mut self, name: &str, keys: &[(String, String)]) {
        let small = name.to_lowercase();
        if self.sections.get(&small).is_none() && !keys.is_empty() {
            let lines = keys.iter().map(|(key, value)| format!("{key}={value}"));
            self.further.push((name.to_owned(), lines.collect()));
            return;
        }
        for (key, value) in keys {
            self.set(&small, key, value);
        }
    }

    fn set(&mut self, section: &str, key: &str, value: &str) {
        let Some(section) = self.sections.get(section) else { return };
        let line = format!("{key}={value}");
        let given = section.any(&key.to_lowercase()).and_then(|given| given.line.checked_sub(1));
        if let Some(held) = given.and_then(|place| self.lines.get_mut(place)) {
            *held = line;
            return;
        }
        let last = section.pairs().iter().map(|pair| pair.line).fold(section.line, usize::max);
        self.behind.entry(last).or_default().push(line);
    }

    /// Returns all lines, the last of them empty.
    fn lines(mut self) -> Vec<String> {
        let mut lines = Vec::new();
        for (number, line) in (1..).zip(self.lines) {
            lines.push(line);
            lines.extend(self.behind.remove(&number).unwrap_or_default());
        }
        for (name, keys) in self.further {
            lines.extend([String::new(), format!("[{name}]")]);
            lines.extend(keys);
        }
        lines.push(String::new());
        lines
    }
}

//! The sections of objects as objects, with the entries that CompactSubObj and CompactPDO imply, and every needed key.
//!
//! A key that is missing or impossible gets its most likely value, and a defect. The meaning of a mapping or a COB-ID
//! is not known here.

use std::collections::{BTreeMap, BTreeSet};

use super::compact::implied;
use super::ini::{Given, Section, Sections, is_space};
use super::{Defects, Entry, FiledObject, MOST_SHOWN, cut, number};
use crate::world::od::DataType;

/// Maximum number of sub-objects. CompactSubObj lets a small file claim millions; no device has a third of it.
const MOST_ENTRIES: usize = 30_000;
const FIRST_OBJECT: u16 = 0x1000;
const LISTS: [&str; 3] = ["mandatoryobjects", "optionalobjects", "manufacturerobjects"];
const ACCESSES: [&str; 6] = ["ro", "wo", "rw", "rwr", "rww", "const"];
/// Other spellings.
const ALMOST: [(&str, &str); 7] =
    [("r", "ro"), ("w", "wo"), ("r/w", "rw"), ("wr", "rw"), ("read", "ro"), ("write", "wo"), ("readonly", "ro")];
/// Object codes (CiA 301, 7.4.3).
const NULL: u8 = 0;
const DOMAIN: u8 = 2;
const DEFTYPE: u8 = 5;
const DEFSTRUCT: u8 = 6;
const VAR: u8 = 7;
const ARRAY: u8 = 8;
const RECORD: u8 = 9;

/// The name of a section of an object.
pub(super) struct SectionPlace<'a> {
    pub(super) index: u16,
    pub(super) sub: Option<u8>,
    /// Name, Value, Denotation or ObjectLinks; empty for none.
    pub(super) part: &'a str,
}

/// Returns the place of a section of an object; `None` for another section.
pub(super) fn place(section: &str) -> Option<SectionPlace<'_>> {
    let small = section.to_ascii_lowercase();
    let index = |text: &str| {
        let digits = text.strip_prefix("0x").unwrap_or(text);
        let fits = digits.len() <= 4 && digits.bytes().all(|digit| digit.is_ascii_hexdigit());
        u16::from_str_radix(digits, 16).ok().filter(|_| fits)
    };
    let at =
        ["name", "value", "denotation", "objectlinks"].iter().find_map(|part| Some(small.strip_suffix(part)?.len()));
    if let Some(at) = at {
        let (before, part) = (small.get(..at)?, section.get(at..)?);
        return Some(SectionPlace { index: index(before.trim_end_matches(is_space))?, sub: None, part });
    }
    if let Some((before, digits)) = small.split_once("sub") {
        let digits = digits.trim_start_matches(is_space);
        let least = digits.trim_start_matches('0');
        let fits = !digits.is_empty() && digits.bytes().all(|digit| digit.is_ascii_hexdigit());
        let sub = if least.is_empty() { Some(0) } else { u8::from_str_radix(least, 16).ok() };
        return Some(SectionPlace {
            index: index(before.trim_end_matches(is_space))?,
            sub: Some(sub.filter(|_| fits)?),
            part: "",
        });
    }
    (small.len() >= 4).then(|| index(&small)).flatten().map(|index| SectionPlace { index, sub: None, part: "" })
}

/// Returns true if the name of a section begins like that of an object.
fn looks_like_an_object(name: &str) -> bool {
    let Some((index, rest)) = name.split_at_checked(4) else { return false };
    let begins_sub = rest.get(..3).is_some_and(|begin| begin.eq_ignore_ascii_case("sub"));
    index.bytes().all(|digit| digit.is_ascii_hexdigit())
        && (begins_sub || !rest.starts_with(|next: char| next.is_ascii_alphanumeric()))
}

/// All sections of one index.
#[derive(Default)]
struct IndexSections {
    head: Option<Section>,
    subs: BTreeMap<u8, Section>,
    /// The sub-index whose section comes first.
    first: u8,
    names: Option<Section>,
    values: Option<Section>,
}

impl IndexSections {
    /// Adds a section.
    fn add(&mut self, sub: Option<u8>, part: &str, section: Section, defects: &mut Defects) {
        let held = match (sub, part.to_ascii_lowercase().as_str()) {
            (Some(sub), _) => {
                if self.subs.is_empty() {
                    self.first = sub;
                }
                match self.subs.get_mut(&sub) {
                    Some(earlier) => return join(earlier, section, defects),
                    None => return drop(self.subs.insert(sub, section)),
                }
            }
            (None, "") => &mut self.head,
            (None, "name") => &mut self.names,
            (None, "value") => &mut self.values,
            _ => return,
        };
        match held {
            Some(earlier) => join(earlier, section, defects),
            None => *held = Some(section),
        }
    }
}

/// Joins two spellings of one section, such as sub1 and sub01; of keys in both the later one counts.
fn join(earlier: &mut Section, later: Section, defects: &mut Defects) {
    let facts = vec![("section", later.name.as_str().into()), ("first", earlier.line.into())];
    defects.note(later.line, "duplicate-section", facts);
    earlier.join(later);
}

/// The keys of one entry: those of its section, and those that stand elsewhere.
struct Keys<'a> {
    name: &'a str,
    /// 0 if nothing is to be noted of its keys.
    line: usize,
    section: &'a Section,
    own: Vec<(&'static str, Given<'a>)>,
}

impl<'a> Keys<'a> {
    fn of(section: &'a Section) -> Self {
        Self { name: &section.name, line: section.line, section, own: Vec::new() }
    }

    /// Returns a key that is not empty.
    fn get(&self, name: &str) -> Option<Given<'a>> {
        let own = self.own.iter().rev().find(|(of, _)| *of == name).map(|(_, given)| *given);
        let line = |given: Given<'a>| Given { line: if self.line == 0 { 0 } else { given.line }, ..given };
        own.or_else(|| self.section.get(name).map(line))
    }
}

/// The sections of objects and of types, by index.
#[derive(Default)]
pub(super) struct Parts {
    objects: BTreeMap<u16, IndexSections>,
    types: BTreeMap<u16, IndexSections>,
}

impl Parts {
    /// Divides the sections into those of objects and the rest, which comes first.
    pub(super) fn divide(sections: Sections, defects: &mut Defects) -> (Sections, Self) {
        let (mut rest, mut parts) = (Sections::default(), Self::default());
        for section in sections.into_iter() {
            let Some(SectionPlace { index, sub, part }) = place(&section.name) else {
                if looks_like_an_object(&section.name) {
                    let name = cut(&section.name, MOST_SHOWN);
                    defects.note(section.line, "section-unused", vec![("section", name.into())]);
                }
                rest.put(section);
                continue;
            };
            if section.name.contains(['x', 'X']) || section.name.contains(is_space) {
                let read = sub.map_or_else(|| format!("{index:04X}{part}"), |sub| format!("{index:04X}sub{sub:X}"));
                let facts = vec![("section", cut(&section.name, MOST_SHOWN).into()), ("read", read.into())];
                defects.note(section.line, "section-name", facts);
            }
            let part = part.to_owned();
            let table = if index >= FIRST_OBJECT { &mut parts.objects } else { &mut parts.types };
            table.entry(index).or_default().add(sub, &part, section, defects);
        }
        (rest, parts)
    }

    /// Reads all objects, by index. `has_lists`: the form of the file has lists of its objects. `mask` and `numbers` are
    /// CompactPDO and the numbers of RPDOs and TPDOs that exist by it.
    pub(super) fn read(
        &self,
        rest: &Sections,
        has_lists: bool,
        mask: i128,
        numbers: (i128, i128),
        defects: &mut Defects,
    ) -> Vec<FiledObject> {
        let listed = self.listed(rest, has_lists, defects);
        let mut reading = Reading { parts: self, defects, count: 0, found: Vec::new() };
        for (index, part) in &self.objects {
            reading.object(*index, part, listed.as_ref());
        }
        for (index, name, subs) in implied(mask, numbers, |index| self.objects.contains_key(&index)) {
            let entries = subs.iter().map(|(sub, section)| reading.entry(index, *sub, &Keys::of(section), 0)).collect();
            reading.put(index, name, RECORD, entries, 0);
        }
        let mut found = reading.found;
        found.sort_by_key(|object| object.index);
        found
    }

    /// Returns the indices in the lists, `None` if the file has no list. Those without a section are noted.
    fn listed(&self, rest: &Sections, has_lists: bool, defects: &mut Defects) -> Option<BTreeSet<i128>> {
        let lists: Vec<_> = LISTS.iter().filter_map(|name| rest.get(name)).collect();
        let mut found = BTreeMap::new();
        for list in &lists {
            let mut entries = 0;
            for pair in list.pairs().iter().filter(|pair| pair.name.bytes().all(|digit| digit.is_ascii_digit())) {
                entries += 1;
                if let Some(index) = number::whole(Some(pair.given()), defects) {
                    found.insert(index, (list.name.as_str(), pair.line));
                }
            }
            count(list.any("supportedobjects"), &list.name, entries, defects);
        }
        let is_there = |index: i128| u16::try_from(index).is_ok_and(|index| self.objects.contains_key(&index));
        for (index, (name, line)) in found.iter().filter(|(index, _)| !is_there(**index)) {
            let sign = if *index < 0 { "-" } else { "" };
            let object = format!("{sign}{:0width$X}h", index.unsigned_abs(), width = 4 - sign.len());
            defects.note(*line, "not-there", vec![("object", object.into()), ("section", (*name).into())]);
        }
        if lists.is_empty() && !self.objects.is_empty() && has_lists {
            defects.note(0, "no-lists", Vec::new());
        }
        (!lists.is_empty()).then(|| found.into_keys().collect())
    }

    /// Returns the data type that a type of the file's own is made of.
    fn made_of(&self, code: u16) -> Option<DataType> {
        let part = self.types.get(&code).or_else(|| self.objects.get(&code))?;
        let number = number::integer(part.subs.get(&1)?.get("defaultvalue")?.value)?;
        u16::try_from(number.value).ok().and_then(DataType::from_code)
    }
}

/// Notes a number of entries that is not the number found.
fn count(given: Option<Given<'_>>, section: &str, found: usize, defects: &mut Defects) {
    let said = number::whole(given, defects).filter(|said| *said != found as i128);
    if let (Some(given), Some(said)) = (given, said) {
        let facts = vec![
            ("section", section.into()),
            ("key", given.name.into()),
            ("said", said.into()),
            ("found", found.into()),
        ];
        defects.note(given.line, "count", facts);
    }
}

/// Returns the keys of [xxxxName] and [xxxxValue], which are sub-indices in decimal; gaps are allowed.
fn numbered(section: Option<&Section>) -> BTreeMap<u8, Given<'_>> {
    let pairs = section.map_or(&[][..], Section::pairs).iter();
    let decimal = |name: &str| name.len() <= 3 && name.bytes().all(|digit| digit.is_ascii_digit());
    pairs.filter(|pair| decimal(&pair.name)).filter_map(|pair| Some((pair.name.parse().ok()?, pair.given()))).collect()
}

/// The objects so far.
struct Reading<'a> {
    parts: &'a Parts,
    defects: &'a mut Defects,
    count: usize,
    found: Vec<FiledObject>,
}

impl Reading<'_> {
    fn put(&mut self, index: u16, name: String, code: u8, entries: Vec<Entry>, line: usize) {
        self.count += entries.len();
        self.found.push(FiledObject { index, name, code, entries, line });
    }

    fn too_many(&mut self, index: u16, line: usize) {
        let facts = vec![("object", format!("{index:04X}h").into()), ("most", MOST_ENTRIES.into())];
        self.defects.note(line, "too-many", facts);
    }

    fn object(&mut self, index: u16, part: &IndexSections, listed: Option<&BTreeSet<i128>>) {
        let object = || format!("{index:04X}h").into();
        let made;
        let head = match (&part.head, part.subs.get(&part.first)) {
            (Some(head), _) => head,
            // Names or values of nothing; the list that has it is noted.
            (None, None) => return,
            (None, Some(first)) => {
                self.defects.note(first.line, "no-index-section", vec![("object", object())]);
                let name = format!("{index:04X}");
                made = Section::of(&name, first.line, &[("ParameterName", &name), ("ObjectType", "9")]);
                &made
            }
        };
        if listed.is_some_and(|listed| !listed.contains(&i128::from(index))) {
            self.defects.note(head.line, "unlisted", vec![("object", object())]);
        }
        let compact = number::whole(head.get("compactsubobj"), self.defects).unwrap_or(0).clamp(0, 254) as u8;
        let code = self.code(index, head, !part.subs.is_empty() || compact != 0);
        if matches!(code, NULL | DEFTYPE | DEFSTRUCT) {
            return;
        }
        if self.count >= MOST_ENTRIES {
            return self.too_many(index, head.line);
        }
        if matches!(code, VAR | DOMAIN) {
            let (entry, of) = self.typed(&format!("{index:04X}h"), (index, 0), &Keys::of(head), head.line, code);
            let code = if code == DOMAIN && of == DataType::Domain { DOMAIN } else { VAR };
            return self.put(index, entry.name.clone(), code, vec![entry], head.line);
        }
        let name = self.name(&Keys::of(head));
        if compact == 0 {
            count(head.get("subnumber"), &format!("{index:04X}"), part.subs.len(), self.defects);
        }
        let entries = self.entries(index, head, part, compact);
        self.put(index, name, code, entries, head.line);
    }

    /// Reads the sub-objects of an array or record.
    fn entries(&mut self, index: u16, head: &Section, part: &IndexSections, compact: u8) -> Vec<Entry> {
        let lists = [("parametername", &part.names), ("parametervalue", &part.values)]
            .map(|(key, section)| (key, section, numbered(section.as_ref())));
        let last = compact.to_string();
        let keys = [
            ("ParameterName", "Number of entries"),
            ("DataType", "5"),
            ("AccessType", "ro"),
            ("DefaultValue", last.as_str()),
        ];
        let number = Section::of(&head.name, head.line, &keys);
        let mut subs: BTreeSet<u8> = part.subs.keys().copied().collect();
        subs.extend((0..=compact).filter(|_| compact != 0));
        let mut entries = Vec::new();
        for sub in subs.iter().copied() {
            if self.count + entries.len() >= MOST_ENTRIES {
                self.too_many(index, head.line);
                return entries;
            }
            let name = format!("{}_{sub:x}", head.text("parametername").unwrap_or_default());
            let mut keys = Keys::of(part.subs.get(&sub).unwrap_or(if sub == 0 { &number } else { head }));
            if sub > 1 && !part.subs.contains_key(&sub) {
                // Defects of the section's keys are noted once, of sub-index 1.
                keys.line = 0;
                keys.own.push(("parametername", Given { name: "ParameterName", value: &name, line: 0 }));
            }
            for (key, _, list) in &lists {
                if let Some(given) = list.get(&sub).filter(|given| !given.value.is_empty()) {
                    keys.own.push((key, *given));
                }
            }
            entries.push(self.entry(index, sub, &keys, head.line));
        }
        for (_, section, list) in &lists {
            for (sub, given) in list.iter().filter(|(sub, _)| !subs.contains(sub)) {
                let name = section.as_ref().map_or("", |section| &section.name);
                let facts = vec![("section", name.into()), ("sub", format!("{sub:02X}h").into())];
                self.defects.note(given.line, "no-such-sub", facts);
            }
        }
        entries
    }

    fn code(&mut self, index: u16, head: &Section, has_subs: bool) -> u8 {
        let given = head.get("objecttype");
        let code = number::whole(given, self.defects);
        let known = code.and_then(|code| u8::try_from(code).ok());
        let read = match known {
            _ if code.is_none() && !has_subs => VAR,
            _ if code.is_none() => {
                if head.get("subnumber").is_some() {
                    RECORD
                } else {
                    ARRAY
                }
            }
            Some(VAR | DOMAIN) if has_subs => {
                if head.get("compactsubobj").is_some() {
                    ARRAY
                } else {
                    RECORD
                }
            }
            Some(known @ (NULL | DOMAIN | DEFTYPE | DEFSTRUCT | VAR | ARRAY | RECORD)) => known,
            _ if has_subs => RECORD,
            _ => VAR,
        };
        if let (Some(given), Some(code)) = (given, code.filter(|code| *code != i128::from(read))) {
            let object = format!("{index:04X}h");
            let facts = vec![("object", object.into()), ("value", code.into()), ("read", i128::from(read).into())];
            self.defects.note(given.line, "object-type", facts);
        }
        read
    }

    /// Reads one entry of an array or record, whose own section begins on `line`.
    fn entry(&mut self, index: u16, sub: u8, keys: &Keys<'_>, line: usize) -> Entry {
        self.typed(&format!("{index:04X}h:{sub:02X}"), (index, sub), keys, line, VAR).0
    }

    /// Reads one entry. Returns it with the type of its values, which is none of the file's own.
    fn typed(
        &mut self,
        object: &str,
        (index, sub): (u16, u8),
        keys: &Keys<'_>,
        line: usize,
        code: u8,
    ) -> (Entry, DataType) {
        let data_type = self.data_type(object, sub, keys, code);
        let of = self.resolved(object, data_type, keys);
        // Nothing more is noted of the values of an unknown type.
        let muted = of == DataType::Domain && data_type != OPAQUE;
        let filled =
            |name: &str| keys.get(name).map(|given| Given { line: if muted { 0 } else { given.line }, ..given });
        let low = number::limit(filled("lowlimit"), of, self.defects);
        let high = number::limit(filled("highlimit"), of, self.defects);
        let name = self.name(keys);
        let access = self.access(object, keys);
        let default = number::value(filled("defaultvalue"), of, self.defects);
        let parameter = number::value(filled("parametervalue"), of, self.defects);
        let mappable = number::whole(keys.get("pdomapping"), self.defects).is_some_and(|mappable| mappable != 0);
        let factor = number::real(keys.get("factor"), self.defects).unwrap_or(1.0);
        let unit = keys.section.text("unit").unwrap_or_default().to_owned();
        let line = if keys.line == 0 { line } else { keys.line };
        let entry =
            Entry { index, sub, name, data_type, access, default, parameter, mappable, low, high, unit, factor, line };
        (entry, of)
    }

    /// Returns the name; without one, that of the section.
    fn name(&mut self, keys: &Keys<'_>) -> String {
        let name = keys.get("parametername").map_or(keys.name, |given| given.value);
        if keys.get("parametername").is_none() {
            self.missing(keys, "ParameterName", keys.name);
        }
        name.to_owned()
    }

    fn missing(&mut self, keys: &Keys<'_>, key: &'static str, read: &str) {
        if keys.line != 0 {
            let facts = vec![("section", keys.name.into()), ("key", key.into()), ("read", read.into())];
            self.defects.note(keys.line, "missing-key", facts);
        }
    }

    /// Returns the code of the data type; 0 if there is none.
    fn data_type(&mut self, object: &str, sub: u8, keys: &Keys<'_>, code: u8) -> u16 {
        let given = keys.get("datatype");
        let number = number::whole(given, self.defects).and_then(|code| u16::try_from(code).ok());
        if let Some(number) = number {
            return number;
        }
        if code == DOMAIN {
            return OPAQUE;
        }
        let guess = if sub == 0 && object.contains(':') { UNSIGNED8 } else { 0 };
        if given.is_none() {
            self.missing(keys, "DataType", &format!("{:04X}h", if guess == 0 { OPAQUE } else { guess }));
        }
        guess
    }

    /// Returns a type of CiA 301; of one that the file defines, the type that it is made of.
    fn resolved(&mut self, object: &str, code: u16, keys: &Keys<'_>) -> DataType {
        if let Some(known) = DataType::from_code(code).or_else(|| self.parts.made_of(code)) {
            return known;
        }
        if let Some(given) = keys.get("datatype").filter(|given| given.line != 0) {
            let facts = vec![("object", object.into()), ("type", format!("{code:04X}h").into())];
            self.defects.note(given.line, "unknown-type", facts);
        }
        DataType::Domain
    }

    fn access(&mut self, object: &str, keys: &Keys<'_>) -> &'static str {
        let Some(given) = keys.get("accesstype") else {
            self.missing(keys, "AccessType", "rw");
            return "rw";
        };
        let small = given.value.to_lowercase();
        let known = |word: &str| ACCESSES.into_iter().find(|access| *access == word);
        if let Some(access) = known(&small) {
            return access;
        }
        let bare = number::without_comment(&small).replace(|c: char| is_space(c) || matches!(c, '_' | '-'), "");
        let almost = || ALMOST.iter().find(|(word, _)| *word == bare).map(|(_, access)| *access);
        let read = known(&bare).or_else(almost).unwrap_or("rw");
        if given.line != 0 {
            let value = cut(given.value, MOST_SHOWN);
            let facts = vec![("object", object.into()), ("value", value.into()), ("read", read.into())];
            self.defects.note(given.line, "access", facts);
        }
        read
    }
}

/// The code of DOMAIN, which stands for any bytes.
const OPAQUE: u16 = 0x0F;
const UNSIGNED8: u16 = 0x05;

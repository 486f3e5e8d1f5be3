//! Text of a description as sections with keys and their lines. Knows no key of CiA 306.
//!
//! Sections and keys are found without regard to case; of two that are alike the later one counts. A comment is a line
//! that begins with `;` or `#`. Text behind a value on its line is left to the reader of numbers.

use std::collections::HashMap;

use super::{Defects, short};

/// A value with the name of its key, where it is to be read.
#[derive(Clone, Copy)]
pub(super) struct Given<'a> {
    pub(super) name: &'a str,
    pub(super) value: &'a str,
    /// 0 for a copy, whose defects belong to the original.
    pub(super) line: usize,
}

/// One `name=value`.
pub(super) struct KeyLine {
    pub(super) name: String,
    pub(super) value: String,
    pub(super) line: usize,
}

impl KeyLine {
    pub(super) fn given(&self) -> Given<'_> {
        Given { name: &self.name, value: &self.value, line: self.line }
    }
}

/// One `[name]` with its keys.
pub(super) struct Section {
    pub(super) name: String,
    pub(super) line: usize,
    pairs: Vec<KeyLine>,
    places: HashMap<String, usize>,
}

impl Section {
    pub(super) fn new(name: &str, line: usize) -> Self {
        Self { name: name.to_owned(), line, pairs: Vec::new(), places: HashMap::new() }
    }

    /// Creates a section from keys that are on no line.
    pub(super) fn of(name: &str, line: usize, keys: &[(&str, &str)]) -> Self {
        let mut section = Self::new(name, line);
        for (name, value) in keys {
            section.put(KeyLine { name: (*name).to_owned(), value: (*value).to_owned(), line: 0 });
        }
        section
    }

    /// Returns a key, by its name in small letters, that is not empty.
    pub(super) fn get(&self, name: &str) -> Option<Given<'_>> {
        self.any(name).filter(|given| !given.value.is_empty())
    }

    /// Returns a key, by its name in small letters, that may be empty.
    pub(super) fn any(&self, name: &str) -> Option<Given<'_>> {
        self.places.get(name).and_then(|place| self.pairs.get(*place)).map(KeyLine::given)
    }

    /// Returns the text of a key; `None` if it is missing.
    pub(super) fn text(&self, name: &str) -> Option<&str> {
        self.any(name).map(|given| given.value)
    }

    /// All keys, in order.
    pub(super) fn pairs(&self) -> &[KeyLine] {
        &self.pairs
    }

    /// Adds a key, or replaces the one of its name, which is returned.
    pub(super) fn put(&mut self, pair: KeyLine) -> Option<KeyLine> {
        let place = *self.places.entry(pair.name.to_lowercase()).or_insert(self.pairs.len());
        match self.pairs.get_mut(place) {
            Some(held) => Some(std::mem::replace(held, pair)),
            None => {
                self.pairs.push(pair);
                None
            }
        }
    }

    /// Adds a key unless there is one of its name.
    pub(super) fn complete(&mut self, name: &str, value: &str) {
        if self.any(&name.to_lowercase()).is_none() {
            self.put(KeyLine { name: name.to_owned(), value: value.to_owned(), line: self.line });
        }
    }

    /// Adds the keys of another section.
    pub(super) fn join(&mut self, later: Self) {
        for pair in later.pairs {
            self.put(pair);
        }
    }
}

/// The sections of a text, in order.
#[derive(Default)]
pub(super) struct Sections {
    all: Vec<Section>,
    places: HashMap<String, usize>,
}

impl Sections {
    /// Returns a section by its name in small letters.
    pub(super) fn get(&self, name: &str) -> Option<&Section> {
        self.places.get(name).and_then(|place| self.all.get(*place))
    }

    /// Returns the place of a section, adding it if there is none of its name; and true if it was there.
    pub(super) fn open(&mut self, name: &str, line: usize) -> (usize, bool) {
        let next = self.all.len();
        let place = *self.places.entry(name.to_lowercase()).or_insert(next);
        if place == next {
            self.all.push(Section::new(name, line));
        }
        (place, place != next)
    }

    /// Returns the section at a place.
    pub(super) fn at(&mut self, place: usize) -> Option<&mut Section> {
        self.all.get_mut(place)
    }

    /// Adds a section, or replaces the one of its name.
    pub(super) fn put(&mut self, section: Section) {
        let place = self.open(&section.name, section.line).0;
        if let Some(held) = self.all.get_mut(place) {
            *held = section;
        }
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Section> {
        self.all.iter()
    }

    pub(super) fn into_iter(self) -> impl Iterator<Item = Section> {
        self.all.into_iter()
    }
}

/// Reads all lines.
pub(super) fn parse(text: &str, defects: &mut Defects) -> Sections {
    let mut sections = Sections::default();
    let mut current = None;
    for (line, number) in lines(text).zip(1..) {
        let line = line.trim_matches(is_blank);
        if line.is_empty() || line.starts_with([';', '#']) {
            continue;
        }
        if let Some(inside) = line.strip_prefix('[') {
            current = Some(open(&mut sections, inside, line, number, defects));
            continue;
        }
        let (name, value) = line
            .split_once('=')
            .map_or(("", ""), |(name, value)| (name.trim_matches(is_space), value.trim_matches(is_space)));
        if name.is_empty() {
            defects.note(number, "no-equals", vec![("text", short(line).into())]);
        } else if let Some(section) = current.and_then(|place| sections.at(place)) {
            put(section, KeyLine { name: name.to_owned(), value: value.to_owned(), line: number }, defects);
        } else {
            defects.note(number, "no-section", vec![("text", short(line).into())]);
        }
    }
    sections
}

/// Returns the lines as any system ends them: a line feed with the carriage returns before it, or one carriage return.
pub(super) fn lines(text: &str) -> impl Iterator<Item = &str> {
    let last = text.rfind('\n').map_or(0, |at| at + 1);
    let (ended, rest) = text.split_at_checked(last).unwrap_or(("", text));
    let ended = ended.split_terminator('\n').flat_map(|line| line.trim_end_matches('\r').split('\r'));
    ended.chain(rest.split('\r'))
}

/// Returns the number of the line of a position.
pub(super) fn line_at(data: &[u8], position: usize) -> usize {
    let before = String::from_utf8_lossy(data.get(..position).unwrap_or(data));
    lines(&before).count()
}

/// Returns true for white space and separators of information.
pub(super) fn is_space(c: char) -> bool {
    c.is_whitespace() || matches!(c, '\u{1C}'..='\u{1F}')
}

/// Returns true for characters around a line that mean nothing: also a DOS end-of-file mark and NULs.
fn is_blank(c: char) -> bool {
    matches!(c, ' ' | '\t' | '\u{B}' | '\u{C}' | '\0' | '\u{1A}' | '\u{FEFF}' | '\u{A0}' | '\u{3000}')
}

/// Returns the place of the section that a line begins.
fn open(sections: &mut Sections, inside: &str, line: &str, number: usize, defects: &mut Defects) -> usize {
    let (name, closed) = inside.split_once(']').map_or((inside, false), |(name, _)| (name, true));
    let name = name.trim_matches(is_space);
    if !closed {
        let read = format!("[{}]", short(name));
        defects.note(number, "section-bracket", vec![("text", short(line).into()), ("read", read.into())]);
    }
    let (place, found) = sections.open(name, number);
    if found {
        let first = sections.at(place).map_or(0, |section| section.line);
        defects.note(number, "duplicate-section", vec![("section", short(name).into()), ("first", first.into())]);
    }
    place
}

fn put(section: &mut Section, pair: KeyLine, defects: &mut Defects) {
    let (line, name, used) = (pair.line, short(&pair.name), short(&pair.value));
    if let Some(other) = section.put(pair) {
        let facts = vec![
            ("section", short(&section.name).into()),
            ("key", name.into()),
            ("first", other.line.into()),
            ("used", used.into()),
            ("other", short(&other.value).into()),
        ];
        defects.note(line, "duplicate-key", facts);
    }
}

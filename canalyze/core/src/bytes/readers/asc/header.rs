//! The header of a file: base, kind of stamps, date, version, previous file; and the counts of other content.
//!
//! Header lines may be anywhere or missing.

use super::words::{Fail, LineWords};
use super::{AscChannel, date};
use crate::bytes::readers::{Contents, Unreadable};

/// Maximum number of separately counted kinds of lines.
const MAX_KINDS: usize = 63;
/// Maximum length of a kind's name, and of a kept value, in bytes.
const MAX_NAME: usize = 32;
const MAX_VALUE: usize = 256;

/// The facts about the file.
#[derive(Clone, Debug, Default)]
pub(super) struct Header {
    /// True if numbers are decimal.
    pub(super) decimal: bool,
    dialect: Vec<(&'static str, Vec<u8>)>,
    kinds: Vec<(Vec<u8>, u64)>,
    other_kinds: u64,
}

/// The content of a header line that the header does not keep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Said {
    /// Nothing.
    Nothing,
    /// True if stamps count from the previous event, false if from the start.
    Relative(bool),
    /// A date in ns since 1970-01-01.
    Date(i64),
}

impl Header {
    /// Parses a line without a stamp that is not a comment.
    pub(super) fn line(&mut self, text: &[u8]) -> Result<Said, Fail> {
        let mut words = LineWords::new(text);
        let first = words.next().unwrap_or_default().to_ascii_lowercase();
        let value = words.rest();
        let second = words.peek().to_ascii_lowercase();
        match (first.as_slice(), second.as_slice()) {
            (b"date", [_, ..]) => {
                self.set("date", value);
                return Ok(date::read(value).map_or(Said::Nothing, Said::Date));
            }
            (b"base", b"hex" | b"dec" | b"dez") => {
                words.next();
                self.decimal = second != b"hex";
                self.set("base", if self.decimal { b"dec" } else { b"hex" });
                return Ok(self.stamps(words));
            }
            (b"begin", b"triggerblock") => {
                words.next();
                let date = date::read(words.rest());
                if date.is_some() && !self.dialect.iter().any(|(name, _)| *name == "date") {
                    self.set("date", words.rest());
                }
                return Ok(date.map_or(Said::Nothing, Said::Date));
            }
            (b"end", b"triggerblock") => return Ok(Said::Nothing),
            (b"internal", b"events") | (b"no", b"internal") => return Ok(Said::Nothing),
            _ => {}
        }
        // A stamp or a word that the end of the file may have cut.
        let number = first.iter().all(|byte| byte.is_ascii_digit() || matches!(byte, b'.' | b'-'));
        let begun = |name: &[u8]| name.starts_with(&text.trim_ascii().to_ascii_lowercase());
        let names: [&[u8]; 6] =
            [b"date ", b"base hex", b"base dec", b"begin triggerblock", b"end triggerblock", b"internal events"];
        let end = number && value.is_empty() || names.into_iter().any(begun);
        Err(Fail { reason: Unreadable::NoFrame, end })
    }

    /// Sets decimal numbers without a header line.
    pub(super) fn set_decimal(&mut self) {
        self.decimal = true;
        self.set("base", b"dec");
    }

    /// Parses `timestamps absolute`, which BusMaster omits.
    fn stamps(&mut self, mut words: LineWords<'_>) -> Said {
        while let Some(word) = words.next() {
            if word.eq_ignore_ascii_case(b"timestamps") {
                let relative = words.peek().eq_ignore_ascii_case(b"relative");
                self.set("timestamps", if relative { b"relative" } else { b"absolute" });
                return Said::Relative(relative);
            }
        }
        Said::Nothing
    }

    /// Parses a comment: `// version 9.0.0`, `//0.000000 previous log file: x.asc`.
    pub(super) fn comment(&mut self, text: &[u8]) {
        const PREVIOUS: &[u8] = b"previous log file:";
        let text = text.strip_prefix(b"//").unwrap_or(text).trim_ascii();
        let value = |name: &[u8]| text.get(name.len()..).filter(|_| text.starts_with(name)).map(<[u8]>::trim_ascii);
        if let Some(version) = value(b"version ") {
            self.set("version", version);
        } else if let Some(at) = memchr::memmem::find(text, PREVIOUS) {
            self.set("previous log file", text.get(at + PREVIOUS.len()..).unwrap_or_default().trim_ascii());
        }
    }

    /// Keeps a property unless one of that name is known; the first one applies to the file.
    fn set(&mut self, name: &'static str, value: &[u8]) {
        if !self.dialect.iter().any(|(known, _)| *known == name) {
            self.dialect.push((name, value.get(..MAX_VALUE).unwrap_or(value).to_vec()));
        }
    }

    /// Adds a channel and its bus to the row of channels, in order of appearance.
    pub(super) fn channel(&mut self, channel: AscChannel, bus: &[u8]) {
        if !self.dialect.iter().any(|(known, _)| *known == "channels") {
            self.dialect.push(("channels", Vec::new()));
        }
        let Some((_, row)) = self.dialect.iter_mut().find(|(known, _)| *known == "channels") else { return };
        if row.len() < MAX_VALUE {
            let comma = if row.is_empty() { "" } else { ", " };
            row.extend_from_slice(format!("{comma}{channel} = ").as_bytes());
            row.extend_from_slice(bus);
        }
    }

    /// Counts a line that is not a frame, by the word that names its kind.
    pub(super) fn pass(&mut self, word: &[u8]) {
        // `Status:chip`, `SV:`
        let end = word.iter().position(|&byte| byte == b':').filter(|&end| end > 0).unwrap_or(word.len());
        let name = word.get(..end.min(MAX_NAME)).unwrap_or(word);
        if let Some((_, count)) = self.kinds.iter_mut().find(|(known, _)| known == name) {
            *count += 1;
        } else if self.kinds.len() < MAX_KINDS {
            self.kinds.push((name.to_vec(), 1));
        } else {
            self.other_kinds += 1;
        }
    }

    /// Returns all facts.
    pub(super) fn contents(&self) -> Contents {
        let mut passed_over = self.kinds.clone();
        if self.other_kinds > 0 {
            passed_over.push((b"...".to_vec(), self.other_kinds));
        }
        Contents { dialect: self.dialect.clone(), passed_over, ..Contents::default() }
    }
}

//! The header of a trace: version, date and columns, else what the form of its rows shows.

use super::words;
use crate::bytes::calendar;

/// Units of ten microseconds in a day: the date has ten digits behind the point, 8.6 µs, and means ms.
const DAY: i128 = 8_640_000_000;
/// Maximum distance of a date from 1970, in those units.
const FAR: i128 = 900_000_000_000_000;

/// The columns of a version by their letters, with D for the data.
const V1_0: &str = "N,O,I,L";
const V1_1: &str = "N,O,T,I,L";
const V1_2: &str = "N,O,B,T,I,L";
const V1_3: &str = "N,O,B,T,I,R,L";
const V2_0: &str = "N,O,T,I,d,l,D";
const V2_1: &str = "N,O,T,B,I,d,R,L,D";

/// Number of columns at most that a row may have before its data.
pub(super) const COLUMNS: usize = 16;

/// The column of each letter; [`COLUMNS`] for one that is missing.
#[derive(Debug)]
struct Places([u8; 64]);

impl Default for Places {
    fn default() -> Self {
        Self([COLUMNS as u8; 64])
    }
}

impl Places {
    fn of(columns: &[u8]) -> Self {
        let mut all = Self::default();
        for (place, letter) in (0..COLUMNS as u8).zip(columns).rev() {
            if let Some(slot) = all.0.get_mut(usize::from(letter & 63)) {
                *slot = place;
            }
        }
        all
    }
}

/// The knowledge of a trace before its rows are read.
#[derive(Debug, Default)]
pub(super) struct TrcHeader {
    /// The version as the file has it; empty if it names none.
    version: Vec<u8>,
    date_ns: Option<i64>,
    /// The letters of the columns in their order, and the column of each letter.
    columns: Vec<u8>,
    places: Places,
    complete: bool,
    decided: bool,
}

impl TrcHeader {
    /// Takes a comment before the first row; `None` if it is a damaged key.
    pub(super) fn take(&mut self, line: &[u8]) -> Option<()> {
        let Some(key) = line.strip_prefix(b";$") else { return Some(()) };
        let end = key.iter().position(|byte| *byte == b'=').unwrap_or(key.len());
        let (key, value) = key.split_at_checked(end)?;
        let value = value.get(1..).unwrap_or_default().trim_ascii();
        match key {
            b"FILEVERSION" => self.version = value.to_vec(),
            b"STARTTIME" => {
                self.date_ns = date_ns(value);
                let number = value.iter().all(|byte| byte.is_ascii_digit() || matches!(byte, b'.' | b','));
                return (self.date_ns.is_some() || number).then_some(());
            }
            b"COLUMNS" => self.columns = value.iter().copied().filter(u8::is_ascii_alphabetic).collect(),
            _ => return None,
        }
        Some(())
    }

    /// Takes the end of the header.
    pub(super) fn complete(&mut self) {
        self.complete = true;
    }

    /// Returns true behind the first row.
    pub(super) fn is_complete(&self) -> bool {
        self.complete
    }

    /// Takes a row as evidence of the version.
    pub(super) fn decide(&mut self, line: &[u8]) {
        if !self.version.is_empty() && (!self.columns.is_empty() || !self.is_second()) {
            self.decided = true;
        }
        if self.decided {
            return;
        }
        let known = |found: &'static [u8]| self.version.is_empty() || self.version == found;
        let (version, columns) = match version_of(line) {
            Some((version, columns)) if known(version) => (version, columns),
            _ => return,
        };
        if version != b"1.0" {
            self.version = version.to_vec();
        }
        self.columns = letters(columns);
        self.decided = true;
    }

    /// Settles the columns of the version.
    pub(super) fn settle(&mut self) {
        match self.version.as_slice() {
            b"" | b"1.0" => self.columns = letters(V1_0),
            b"1.1" => self.columns = letters(V1_1),
            b"1.2" => self.columns = letters(V1_2),
            b"1.3" => self.columns = letters(V1_3),
            // Of another version only the header tells the columns.
            _ => {}
        }
        self.places = Places::of(&self.columns);
    }

    /// Returns true once the version is known.
    pub(super) fn is_decided(&self) -> bool {
        self.decided
    }

    /// Returns true if the columns of a version are known.
    pub(super) fn is_readable(&self) -> bool {
        self.at(b'O').is_some() && self.at(b'I').is_some()
    }

    /// Returns true for version 2 and later ones, whose header names the columns.
    pub(super) fn is_second(&self) -> bool {
        !matches!(self.version.as_slice(), b"" | b"1.0" | b"1.1" | b"1.2" | b"1.3")
    }

    /// Returns true if rows have directions.
    pub(super) fn has_directions(&self) -> bool {
        !matches!(self.version.as_slice(), b"" | b"1.0")
    }

    /// Returns true if each row begins with its number.
    pub(super) fn is_numbered(&self) -> bool {
        self.at(b'N').is_some()
    }

    /// Returns the version as shown.
    pub(super) fn version(&self) -> &[u8] {
        if self.version.is_empty() { b"1.0" } else { &self.version }
    }

    /// Returns the start of the trace in ns, civil time counted as if it were UTC.
    pub(super) fn date_ns(&self) -> Option<i64> {
        self.date_ns
    }

    /// Returns the place of a column, once the version is known.
    #[inline]
    pub(super) fn at(&self, letter: u8) -> Option<usize> {
        let place = self.places.0.get(usize::from(letter & 63)).map_or(COLUMNS, |place| usize::from(*place));
        (place < COLUMNS).then_some(place)
    }
}

fn letters(columns: &str) -> Vec<u8> {
    columns.bytes().filter(|byte| *byte != b',').collect()
}

/// Returns version and columns by the form of a row.
fn version_of(line: &[u8]) -> Option<(&'static [u8], &'static str)> {
    let row: Vec<&[u8]> = words(line).take(9).collect();
    let word = |at: usize| row.get(at).copied().unwrap_or_default();
    let digits = |at: usize| !word(at).is_empty() && word(at).iter().all(u8::is_ascii_digit);
    let digit = |at: usize| word(at).len() == 1 && digits(at);
    let id = |at: usize| (3..=8).contains(&word(at).len()) && word(at).iter().all(u8::is_ascii_hexdigit);
    let way = |at: usize| matches!(word(at), b"Rx" | b"Tx" | b"Warng" | b"Error");
    let kind = |at: usize| word(at).len() == 2 && word(at).iter().all(u8::is_ascii_uppercase);
    let stamp = word(1).iter().all(|byte| byte.is_ascii_digit() || *byte == b'.') && !word(1).is_empty();
    let first = word(0).strip_suffix(b")").is_some_and(|number| number.iter().all(u8::is_ascii_digit));
    if !stamp {
        return None;
    }
    if first {
        let found: (&[u8], &str) = match () {
            () if id(2) && digit(3) && !way(2) => (b"1.0", V1_0),
            () if way(2) && id(3) && digit(4) => (b"1.1", V1_1),
            () if digit(2) && way(3) && id(4) && word(5) == b"-" && digit(6) => (b"1.3", V1_3),
            () if digit(2) && way(3) && id(4) && digit(5) => (b"1.2", V1_2),
            () => return None,
        };
        return Some(found);
    }
    if !digits(0) || !kind(2) {
        return None;
    }
    let bus = digits(3) && word(3).len() <= 2;
    if bus && (way(4) && word(5) == b"-" || id(4) && way(5) && word(6) == b"-") {
        return Some((b"2.1", V2_1));
    }
    (way(3) || id(3) && way(4)).then_some((b"2.0", V2_0))
}

/// Returns a start time, in days since the end of 1899, in ns; `None` for 0, which a program writes that knows no date.
fn date_ns(days: &[u8]) -> Option<i64> {
    let point = days.iter().position(|byte| *byte == b'.').unwrap_or(days.len());
    let (whole, fraction) = days.split_at_checked(point)?;
    let fraction = fraction.get(1..).unwrap_or_default();
    let number = |digits: &[u8]| {
        let valid = digits.len() <= 18 && digits.iter().all(u8::is_ascii_digit);
        valid.then(|| digits.iter().fold(0_i128, |sum, digit| sum * 10 + i128::from(digit - b'0')))
    };
    if whole.is_empty() && fraction.is_empty() {
        return None;
    }
    let scale = 10_i128.checked_pow(u32::try_from(fraction.len()).ok()?)?;
    let part = number(fraction)? * DAY;
    let units = number(whole)? * DAY + (part + scale / 2) / scale;
    let since = units + i128::from(calendar::days_to(1899, 12, 30)) * DAY;
    (since != 0 && since.abs() < FAR).then(|| i64::try_from(since * 10_000).ok())?
}

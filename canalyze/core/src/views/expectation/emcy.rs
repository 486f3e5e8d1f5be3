//! Emergencies that must, may and must not occur.
//!
//! An expectation that something must not occur is overruled by one that it may or must occur, if that is as specific
//! or more so: "none but 8130h". The meaning of an error code does not matter here, except that 00xxh clears errors.

use crate::words::profiles::Profile;
use serde::Deserialize;

use super::{Closing, EntryPlace, Scene, check_node};
use crate::rules::expectation::{Exp011, Exp012};
use crate::rules::finding::{Quantity, Said};

/// Required occurrence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Occurs {
    Must,
    May,
    Never,
}

/// An expectation in the form of the file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EmcyEntry {
    line: u32,
    bus: Option<String>,
    node: Option<u8>,
    /// Value and mask.
    code: Option<(u16, u16)>,
    occurs: Occurs,
}

impl EmcyEntry {
    pub(super) fn check(&self) -> Result<(), String> {
        check_node(self.line, self.node)
    }

    fn fits(&self, code: u16) -> bool {
        self.code.is_none_or(|(value, mask)| code & mask == value & mask)
    }

    /// The number of conditions that it names: more specific expectations overrule others.
    fn weight(&self) -> u32 {
        let bits = self.code.map_or(0, |(_, mask)| mask.count_ones());
        4 * bits + 2 * u32::from(self.node.is_some()) + u32::from(self.bus.is_some())
    }
}

/// An expectation and whether it was met.
#[derive(Debug)]
struct WatchedEmcy {
    entry: EmcyEntry,
    place: EntryPlace,
    seen: bool,
}

/// All expectations of emergencies.
#[derive(Debug)]
pub(super) struct EmcyExpectations {
    all: Vec<WatchedEmcy>,
}

impl EmcyExpectations {
    pub(super) fn new(file: &str, entries: &[EmcyEntry]) -> Self {
        let all = entries.iter().map(|entry| WatchedEmcy {
            place: EntryPlace::new(file, entry.line, entry.bus.as_ref(), entry.node),
            entry: entry.clone(),
            seen: false,
        });
        Self { all: all.collect() }
    }

    /// Takes an EMCY.
    pub(super) fn emcy(&mut self, node: u8, (code, profile): (u16, Profile), scene: &mut Scene<'_>) {
        let name = scene.name;
        let fitting = |one: &&mut WatchedEmcy| one.place.holds(name, Some(node)) && one.entry.fits(code);
        let mut allowed = None;
        for one in self.all.iter_mut().filter(fitting).filter(|one| one.entry.occurs != Occurs::Never) {
            one.seen = true;
            allowed = allowed.max(Some(one.entry.weight()));
        }
        let reset = code & 0xFF00 == 0;
        let forbidden = self.all.iter_mut().filter(fitting).filter(|one| one.entry.occurs == Occurs::Never);
        let strictest = forbidden
            .filter(|one| Some(one.entry.weight()) > allowed && !(reset && one.entry.code.is_none()))
            .max_by_key(|one| one.entry.weight());
        if let Some(one) = strictest {
            let breach = scene.breach(Exp012::Occurred { found: (code, profile) }).of(node);
            scene.raise(&one.place, breach);
        }
    }

    /// Reports missing emergencies at the end of the capture.
    pub(super) fn finish(&self, closing: &mut Closing<'_>) {
        for one in self.all.iter().filter(|one| one.entry.occurs == Occurs::Must && !one.seen) {
            let expected = one.entry.code.map(|(value, mask)| match mask {
                0xFFFF => Said::Quantity(Quantity::Emcy(value, Profile::UNKNOWN)),
                _ => Said::Text(pattern(value, mask).into()),
            });
            let missing = expected.map_or(Exp011::None, |expected| Exp011::NoneOf { expected });
            closing.raise(&one.place, closing.breach(&one.place, missing));
        }
    }
}

/// Formats a masked code: digits with masked bits are `x`, as in `81xx`.
fn pattern(value: u16, mask: u16) -> String {
    let digit = |shift: u16| match mask >> shift & 0xF {
        0xF => char::from_digit(u32::from(value >> shift & 0xF), 16).unwrap_or('x').to_ascii_uppercase(),
        _ => 'x',
    };
    [12, 8, 4, 0].into_iter().map(digit).collect()
}

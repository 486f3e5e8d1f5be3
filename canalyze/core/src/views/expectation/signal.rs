//! Signals in PDOs: their presence, their rate and the limits of their values.
//!
//! Values are physical, as `canalyze signals` prints them; names are those of `--select`. The source of a mapping does
//! not matter here.

use std::sync::Arc;

use serde::Deserialize;

use super::{Breach, Closing, EntryPlace, Scene, check_times, mistake, raise};
use crate::bytes::frame::{BusId, Frame, FrameRef};
use crate::bytes::ns::Ns;
use crate::bytes::select::Select;
use crate::evidence::period::expected::{AllowedPeriod, Rhythm};
use crate::rules::expectation::{Exp007, Exp008, Exp015, Exp016};
use crate::sdo::wire::Mux;
use crate::wire::error_control::OPERATIONAL;
use crate::wire::nmt::START;
use crate::wire::pdo::mapping::{Mapped, Mapping};
use crate::words::signal;
use crate::world::change::Change;
use crate::world::event::{Addressed, Event, ProcessData, Signals as Content, Unmapped};

/// Maximum number of mappings whose selection is remembered.
const REMEMBERED: usize = 4096;
/// Maximum number of PDOs whose rate is followed for one expectation, and of PDOs without a mapping that are
/// remembered.
const PDOS: usize = 1024;
/// Tolerance of a limit, as a fraction of it: a decimal number is not exact.
const PRECISION: f64 = 1e-9;

/// An expectation in the form of the file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SignalEntry {
    line: u32,
    bus: Option<String>,
    select: String,
    min: Option<f64>,
    max: Option<f64>,
    period_ns: Option<Ns>,
    tolerance_ns: Option<Ns>,
}

impl SignalEntry {
    pub(super) fn check(&self) -> Result<(), String> {
        check_times(self.line, &[self.period_ns], &[self.tolerance_ns])?;
        if Select::parse(&self.select).is_everything() {
            return mistake(self.line, "select");
        }
        if self.period_ns.is_some() != self.tolerance_ns.is_some() {
            return mistake(self.line, "period_ns and tolerance_ns");
        }
        if self.min.zip(self.max).is_some_and(|(min, max)| min > max) {
            return mistake(self.line, "min above max");
        }
        Ok(())
    }
}

/// A PDO of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct PdoChoice {
    /// The node that has the PDO.
    pub node: u8,
    /// Transmit or receive, seen from the node.
    pub transmit: bool,
    /// PDO number, from 1.
    pub number: u16,
}

impl PdoChoice {
    /// Its form in a finding.
    fn named(self) -> (bool, u16) {
        (self.transmit, self.number)
    }
}

/// An expectation and its progress.
#[derive(Debug)]
struct WatchedSignal {
    place: EntryPlace,
    select: Select,
    /// The expression in the file.
    expression: String,
    min: Option<f64>,
    max: Option<f64>,
    period: Option<AllowedPeriod>,
    seen: bool,
    rhythms: Vec<(BusId, PdoChoice, Rhythm)>,
}

/// The expected signals of a mapping.
#[derive(Debug)]
struct Chosen {
    mapping: Arc<Mapping>,
    pdo: PdoChoice,
    /// The expectation, and the index in the mapping, in order of the expectations.
    picks: Vec<(usize, usize)>,
}

/// All expectations of signals.
#[derive(Debug)]
pub(super) struct SignalExpectations {
    all: Vec<WatchedSignal>,
    chosen: Vec<Chosen>,
    /// PDOs that came without a known mapping.
    unmapped: Vec<PdoChoice>,
}

impl SignalExpectations {
    pub(super) fn new(file: &str, entries: &[SignalEntry]) -> Self {
        let all = entries.iter().map(|entry| WatchedSignal {
            place: EntryPlace::new(file, entry.line, entry.bus.as_ref(), None),
            select: Select::parse(&entry.select),
            expression: entry.select.clone(),
            min: entry.min,
            max: entry.max,
            period: entry
                .period_ns
                .zip(entry.tolerance_ns)
                .map(|(ns, tolerance_ns)| AllowedPeriod { ns, tolerance_ns }),
            seen: false,
            rhythms: Vec::new(),
        });
        Self { all: all.collect(), chosen: Vec::new(), unmapped: Vec::new() }
    }

    /// Takes a PDO.
    pub(super) fn process_data(&mut self, data: &ProcessData, frame: &Frame, scene: &mut Scene<'_>) {
        if self.all.is_empty() {
            return;
        }
        let pdo = PdoChoice { transmit: data.transmit, number: data.number, node: data.node };
        match &data.content {
            Content::Mapped(mapping, from) | Content::ByConsumer(mapping, from, ..) if !from.is_unconfirmed() => {
                let known = self.chosen.iter().position(|one| Arc::ptr_eq(&one.mapping, mapping) && one.pdo == pdo);
                let place = known.unwrap_or_else(|| {
                    if self.chosen.len() >= REMEMBERED {
                        self.chosen.clear();
                    }
                    let picks = self.picks(pdo, mapping);
                    self.chosen.push(Chosen { mapping: Arc::clone(mapping), pdo, picks });
                    self.chosen.len() - 1
                });
                // The mapping just used is likely to be used again soon.
                self.chosen.swap(0, place);
                let Self { all, chosen, .. } = self;
                if let Some(one) = chosen.first() {
                    take(all, &one.picks, pdo, mapping, frame, scene);
                }
            }
            Content::None(Unmapped::Disabled | Unmapped::Multiplex) => {}
            _ if self.unmapped.len() < PDOS && !self.unmapped.contains(&pdo) => {
                self.unmapped.push(pdo);
            }
            _ => {}
        }
    }

    /// Takes a multiplex PDO, which has one signal that may differ in every frame.
    pub(super) fn multiplexed(&mut self, data: &Addressed, frame: &Frame, scene: &mut Scene<'_>) {
        let pdo = PdoChoice { transmit: data.transmit, number: data.number, node: data.node };
        let picks = self.picks(pdo, &data.mapping);
        take(&mut self.all, &picks, pdo, &data.mapping, frame, scene);
    }

    fn picks(&self, pdo: PdoChoice, mapping: &Mapping) -> Vec<(usize, usize)> {
        let PdoChoice { transmit, number, node } = pdo;
        let mut picks = Vec::new();
        for (place, mapped) in mapping.entries.iter().enumerate().filter(|(_, mapped)| !mapped.dummy) {
            let names = signal::names(transmit, number, node, mapped);
            for (expected, one) in self.all.iter().enumerate() {
                if one.select.takes(names.iter().map(String::as_str)) {
                    picks.push((expected, place));
                }
            }
        }
        picks.sort_unstable();
        picks
    }

    /// Takes a boot-up, a report of a state or an NMT command, which may stop a node's PDOs.
    pub(super) fn change(&mut self, change: &Change, scene: &Scene<'_>) {
        if let Some(node) = stopped(change) {
            self.interrupt(scene.bus, Some(node).filter(|node| *node != 0));
        }
    }

    /// Restarts the measurement of rates, since frames of a bus are missing.
    pub(super) fn lost(&mut self, bus: BusId) {
        self.interrupt(bus, None);
    }

    /// Restarts the measurement of a node whose PDOs have changed.
    pub(super) fn reconfigured(&mut self, bus: BusId, node: u8) {
        self.interrupt(bus, Some(node));
    }

    fn interrupt(&mut self, of: BusId, node: Option<u8>) {
        let rhythms = self.all.iter_mut().flat_map(|one| &mut one.rhythms);
        let concerned = |bus: BusId, pdo: &PdoChoice| bus == of && node.is_none_or(|node| node == pdo.node);
        for (_, _, rhythm) in rhythms.filter(|(bus, pdo, _)| concerned(*bus, pdo)) {
            rhythm.interrupt();
        }
    }

    /// Reports PDOs that are overdue at `now_ns`. Findings are at `at`.
    pub(super) fn overdue(&mut self, now_ns: Ns, at: FrameRef, found: &mut Vec<Event>) {
        for WatchedSignal { place, period, rhythms, .. } in &mut self.all {
            let Some(period) = *period else { continue };
            for (bus, pdo, rhythm) in rhythms {
                let Some((gap, last)) = rhythm.overdue(now_ns, period) else { continue };
                let AllowedPeriod { ns: expected, tolerance_ns: tolerance } = period;
                let what = Exp008::Overdue { pdo: pdo.named(), expected, found: gap, tolerance };
                raise(found, place, Breach::new(what, at, *bus).of(pdo.node).about(last));
            }
        }
    }

    /// Reports at the end of the capture.
    pub(super) fn finish(&mut self, closing: &mut Closing<'_>) {
        if let Some(end_ns) = closing.end_ns {
            self.overdue(end_ns, closing.last, closing.found);
        }
        for one in &self.all {
            if !one.seen && self.unmapped.iter().any(|pdo| one.may_mean(*pdo)) {
                closing.unchecked(&one.place, Exp015::NoMapping);
            } else if !one.seen {
                let breach = closing.breach(&one.place, Exp016::None { expected: one.expression.as_str().into() });
                closing.raise(&one.place, breach);
            } else if one.period.is_some() && closing.end_ns.is_none() {
                closing.unchecked(&one.place, Exp015::NoStamps);
            }
        }
    }
}

impl WatchedSignal {
    /// Returns true if a signal of a PDO of unknown mapping could be meant.
    fn may_mean(&self, pdo: PdoChoice) -> bool {
        self.expression.split(',').any(|pattern| {
            let pattern = pattern.trim();
            let Some((node, rest)) = pattern.split_once('.') else { return true };
            let Ok(node) = node.parse::<u8>() else { return true };
            let named = rest.split_once('.').filter(|(name, _)| is_pdo(name));
            let pdo_name = || format!("{}{}", if pdo.transmit { "TPDO" } else { "RPDO" }, pdo.number);
            node == pdo.node && named.is_none_or(|(name, _)| name.eq_ignore_ascii_case(&pdo_name()))
        })
    }
}

/// Returns true if a part of a pattern names a PDO, as in `TPDO4`.
fn is_pdo(name: &str) -> bool {
    let digits = name.get(4..).filter(|digits| !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit()));
    let kind = name.get(..4).unwrap_or("");
    digits.is_some() && (kind.eq_ignore_ascii_case("TPDO") || kind.eq_ignore_ascii_case("RPDO"))
}

/// Takes the expected signals of a PDO.
fn take(
    all: &mut [WatchedSignal],
    picks: &[(usize, usize)],
    pdo: PdoChoice,
    mapping: &Mapping,
    frame: &Frame,
    scene: &mut Scene<'_>,
) {
    let mut before = None;
    for (expected, place) in picks {
        let Some(one) = all.get_mut(*expected).filter(|one| one.place.is_on(scene.name)) else { continue };
        if before.replace(*expected) != Some(*expected) {
            one.seen = true;
            one.beat(pdo, scene);
        }
        if let Some(mapped) = mapping.entries.get(*place)
            && let Some(value) = value(mapping, mapped, frame)
        {
            one.judge(value, pdo, mapped, scene);
        }
    }
}

impl WatchedSignal {
    fn beat(&mut self, pdo: PdoChoice, scene: &mut Scene<'_>) {
        let Some(period) = self.period else { return };
        let known = self.rhythms.iter().position(|(bus, one, _)| *bus == scene.bus && *one == pdo);
        let index = match known {
            Some(index) => index,
            None if self.rhythms.len() >= PDOS => return,
            None => {
                self.rhythms.push((scene.bus, pdo, Rhythm::default()));
                self.rhythms.len() - 1
            }
        };
        let Some((_, _, rhythm)) = self.rhythms.get_mut(index) else { return };
        let before = rhythm.last;
        if let Some(gap) = rhythm.beat(scene.at, false, period) {
            let AllowedPeriod { ns: expected, tolerance_ns: tolerance } = period;
            let what = Exp008::Interval { pdo: pdo.named(), expected, found: gap, tolerance };
            scene.raise(&self.place, Breach { cause: before, ..scene.breach(what).of(pdo.node) });
        }
    }

    fn judge(&self, value: f64, pdo: PdoChoice, mapped: &Mapped, scene: &mut Scene<'_>) {
        let beyond = |limit: f64, by: f64| by > limit.abs().max(value.abs()) * PRECISION;
        let (node, pdo, found) = (pdo.node, pdo.named(), value);
        let below = self.min.filter(|min| beyond(*min, min - value));
        let above = self.max.filter(|max| beyond(*max, value - max));
        let what = match (below, above) {
            (Some(expected), _) => Exp007::Below { pdo, limit: "min", expected, found },
            (None, Some(expected)) => Exp007::Above { pdo, limit: "max", expected, found },
            (None, None) => return,
        };
        let object = Mux { index: mapped.index, sub: mapped.sub };
        scene.raise(&self.place, scene.breach(what).of(node).object(object));
    }
}

/// Returns the node whose PDOs a change stops; 0: all nodes.
pub(super) fn stopped(change: &Change) -> Option<u8> {
    match *change {
        Change::BootUp { node } => Some(node),
        Change::State { node, state, .. } if state != OPERATIONAL => Some(node),
        Change::Command { command, node } if command != START => Some(node),
        _ => None,
    }
}

/// Returns the physical value of a signal, if it is a finite number.
pub(super) fn value(mapping: &Mapping, mapped: &Mapped, frame: &Frame) -> Option<f64> {
    let raw = mapping.raw(mapped, frame.payload())?;
    signal::physical(mapped, raw).filter(|value| value.is_finite())
}

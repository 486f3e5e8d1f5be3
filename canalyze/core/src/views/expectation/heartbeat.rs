//! The period of heartbeats.
//!
//! A heartbeat that shows another state may come at any time, and the next one too soon after it. Responses to node
//! guarding are not heartbeats.

use serde::Deserialize;

use super::{Breach, Closing, EntryPlace, Scene, check_node, check_times, raise};
use crate::bytes::frame::{BusId, FrameRef};
use crate::bytes::ns::Ns;
use crate::evidence::period::expected::{AllowedPeriod, Rhythm};
use crate::rules::expectation::{Exp009, Exp015};
use crate::wire::nmt::{RESET_COMMUNICATION, RESET_NODE};
use crate::world::change::Change;
use crate::world::event::Event;

/// An expectation in the form of the file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct HeartbeatEntry {
    line: u32,
    bus: Option<String>,
    node: u8,
    period_ns: Ns,
    tolerance_ns: Ns,
}

impl HeartbeatEntry {
    pub(super) fn check(&self) -> Result<(), String> {
        check_node(self.line, Some(self.node))?;
        check_times(self.line, &[Some(self.period_ns)], &[Some(self.tolerance_ns)])
    }
}

/// An expectation and the heartbeats that it is about.
#[derive(Debug)]
struct WatchedHeartbeats {
    place: EntryPlace,
    node: u8,
    period: AllowedPeriod,
    rhythms: Vec<(BusId, Rhythm)>,
}

/// All expectations of heartbeats.
#[derive(Debug)]
pub(super) struct Heartbeats {
    all: Vec<WatchedHeartbeats>,
}

impl Heartbeats {
    pub(super) fn new(file: &str, entries: &[HeartbeatEntry]) -> Self {
        let all = entries.iter().map(|entry| WatchedHeartbeats {
            place: EntryPlace::new(file, entry.line, entry.bus.as_ref(), Some(entry.node)),
            node: entry.node,
            period: AllowedPeriod { ns: entry.period_ns, tolerance_ns: entry.tolerance_ns },
            rhythms: Vec::new(),
        });
        Self { all: all.collect() }
    }

    /// Takes a report of a state, a boot-up or an NMT command.
    pub(super) fn change(&mut self, change: &Change, scene: &mut Scene<'_>) {
        match *change {
            Change::State { node, guarding: false, .. } => {
                let extra = change.is_another_state();
                for one in self.all.iter_mut().filter(|one| one.place.holds(scene.name, Some(node))) {
                    one.beat(extra, scene);
                }
            }
            Change::BootUp { node } => self.reconfigured(scene.bus, node),
            Change::Command { command: RESET_NODE | RESET_COMMUNICATION, node } => {
                for one in self.all.iter_mut().filter(|one| node == 0 || node == one.node) {
                    one.interrupt(scene.bus);
                }
            }
            _ => {}
        }
    }

    /// Restarts the measurement, since the node has another period or begins anew.
    pub(super) fn reconfigured(&mut self, bus: BusId, node: u8) {
        for one in self.all.iter_mut().filter(|one| node == one.node) {
            one.interrupt(bus);
        }
    }

    /// Restarts the measurement, since frames of a bus are missing.
    pub(super) fn lost(&mut self, bus: BusId) {
        for one in &mut self.all {
            one.interrupt(bus);
        }
    }

    /// Reports heartbeats that are overdue at `now_ns`. Findings are at `at`.
    pub(super) fn overdue(&mut self, now_ns: Ns, at: FrameRef, found: &mut Vec<Event>) {
        for one in &mut self.all {
            let WatchedHeartbeats { place, period, rhythms, .. } = one;
            for (bus, rhythm) in rhythms {
                let Some((gap, last)) = rhythm.overdue(now_ns, *period) else { continue };
                let AllowedPeriod { ns: expected, tolerance_ns: tolerance } = *period;
                let what = Exp009::Overdue { expected, found: gap, tolerance };
                raise(found, place, Breach::new(what, at, *bus).about(last));
            }
        }
    }

    /// Reports at the end of the capture.
    pub(super) fn finish(&mut self, closing: &mut Closing<'_>) {
        if let Some(end_ns) = closing.end_ns {
            self.overdue(end_ns, closing.last, closing.found);
        }
        for one in &self.all {
            if one.rhythms.is_empty() {
                let breach = closing.breach(&one.place, Exp009::None { expected: one.period.ns });
                closing.raise(&one.place, breach);
            } else if closing.end_ns.is_none() {
                closing.unchecked(&one.place, Exp015::NoStamps);
            }
        }
    }
}

impl WatchedHeartbeats {
    fn beat(&mut self, extra: bool, scene: &mut Scene<'_>) {
        let known = self.rhythms.iter().position(|(bus, _)| *bus == scene.bus);
        let index = known.unwrap_or_else(|| {
            self.rhythms.push((scene.bus, Rhythm::default()));
            self.rhythms.len() - 1
        });
        let Some((_, rhythm)) = self.rhythms.get_mut(index) else { return };
        let before = rhythm.last;
        if let Some(gap) = rhythm.beat(scene.at, extra, self.period) {
            let AllowedPeriod { ns: expected, tolerance_ns: tolerance } = self.period;
            let breach = scene.breach(Exp009::Interval { expected, found: gap, tolerance });
            scene.raise(&self.place, Breach { cause: before, ..breach });
        }
    }

    fn interrupt(&mut self, of: BusId) {
        for (_, rhythm) in self.rhythms.iter_mut().filter(|(bus, _)| *bus == of) {
            rhythm.interrupt();
        }
    }
}

//! The period of heartbeats.
//!
//! A heartbeat that shows another state may come at any time, and the next one too soon after it. Answers to node
//! guarding are no heartbeats.

use serde::Deserialize;

use super::rhythm::{Period, Rhythm};
use super::{Breach, Closing, Place, Scene, check_node, check_times, raise, unchecked};
use crate::event::Event;
use crate::finding::{Code, Quantity};
use crate::frame::{BusId, FrameRef};
use crate::message::Message;
use crate::services::nmt::{RESET_COMMUNICATION, RESET_NODE};

/// One expectation as it stands in the file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Entry {
    line: u32,
    bus: Option<String>,
    node: u8,
    period_ns: i64,
    tolerance_ns: i64,
}

impl Entry {
    pub(super) fn check(&self) -> Result<(), String> {
        check_node(self.line, Some(self.node))?;
        check_times(self.line, &[Some(self.period_ns)], &[Some(self.tolerance_ns)])
    }
}

/// An expectation and the heartbeats that it is about.
#[derive(Debug)]
struct Watched {
    place: Place,
    node: u8,
    period: Period,
    rhythms: Vec<(BusId, Rhythm)>,
}

/// All expectations of heartbeats.
#[derive(Debug)]
pub(super) struct Heartbeats {
    all: Vec<Watched>,
}

impl Heartbeats {
    pub(super) fn new(file: &str, entries: &[Entry]) -> Self {
        let all = entries.iter().map(|entry| Watched {
            place: Place::new(file, entry.line, entry.bus.as_ref(), Some(entry.node)),
            node: entry.node,
            period: Period { ns: entry.period_ns, tolerance_ns: entry.tolerance_ns },
            rhythms: Vec::new(),
        });
        Self { all: all.collect() }
    }

    /// Takes error control or an NMT command.
    pub(super) fn message(&mut self, message: &Message, scene: &mut Scene<'_>) {
        match *message {
            Message::Heartbeat { node, state, guarding: false, previous, .. } => {
                let extra = previous.is_some_and(|before| before != state);
                for one in self.all.iter_mut().filter(|one| one.place.holds(scene.name, Some(node))) {
                    one.beat(extra, scene);
                }
            }
            Message::BootUp { node } => self.interrupt(Some(node), scene),
            Message::Nmt { command: RESET_NODE | RESET_COMMUNICATION, node } => {
                self.interrupt(Some(node).filter(|node| *node != 0), scene);
            }
            _ => {}
        }
    }

    fn interrupt(&mut self, node: Option<u8>, scene: &Scene<'_>) {
        for one in self.all.iter_mut().filter(|one| node.is_none_or(|node| node == one.node)) {
            one.interrupt(scene.bus);
        }
    }

    /// Frames of a bus are missing.
    pub(super) fn lost(&mut self, bus: BusId) {
        for one in &mut self.all {
            one.interrupt(bus);
        }
    }

    /// It is `now_ns`: who is overdue. Findings stand at `at`.
    pub(super) fn overdue(&mut self, now_ns: i64, at: FrameRef, found: &mut Vec<Event>) {
        for one in &mut self.all {
            let Watched { place, period, rhythms, .. } = one;
            for (bus, rhythm) in rhythms {
                let Some((gap, last)) = rhythm.overdue(now_ns, *period) else { continue };
                raise(found, place, late(Breach::new(Code::Exp009, 1, at, *bus), gap, *period).about(last));
            }
        }
    }

    /// The capture is over.
    pub(super) fn finish(&mut self, closing: &mut Closing<'_>) {
        if let Some(end_ns) = closing.end_ns {
            self.overdue(end_ns, closing.last, closing.found);
        }
        for one in &self.all {
            if one.rhythms.is_empty() {
                let breach = closing.breach(&one.place, Code::Exp009, 2);
                closing.raise(&one.place, breach.quantity("expected", Quantity::Ns(one.period.ns)));
            } else if closing.end_ns.is_none() {
                closing.unchecked(&one.place, unchecked::NO_STAMPS);
            }
        }
    }
}

impl Watched {
    fn beat(&mut self, extra: bool, scene: &mut Scene<'_>) {
        let known = self.rhythms.iter().position(|(bus, _)| *bus == scene.bus);
        let index = known.unwrap_or_else(|| {
            self.rhythms.push((scene.bus, Rhythm::default()));
            self.rhythms.len() - 1
        });
        let Some((_, rhythm)) = self.rhythms.get_mut(index) else { return };
        let before = rhythm.last;
        if let Some(gap) = rhythm.beat(scene.at, extra, self.period) {
            let breach = late(scene.breach(Code::Exp009, 0), gap, self.period);
            scene.raise(&self.place, Breach { cause: before, ..breach });
        }
    }

    fn interrupt(&mut self, of: BusId) {
        for (_, rhythm) in self.rhythms.iter_mut().filter(|(bus, _)| *bus == of) {
            rhythm.interrupt();
        }
    }
}

/// What is said of an interval.
pub(super) fn late(breach: Breach, gap: i64, period: Period) -> Breach {
    let breach = breach.quantity("expected", Quantity::Ns(period.ns)).quantity("found", Quantity::Ns(gap));
    breach.quantity("tolerance", Quantity::Ns(period.tolerance_ns))
}

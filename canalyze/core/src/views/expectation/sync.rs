//! The period of SYNC, independent of its producer and of PDOs.

use serde::Deserialize;

use super::{Breach, Closing, EntryPlace, Scene, check_times, raise};
use crate::bytes::frame::{BusId, FrameRef};
use crate::bytes::ns::Ns;
use crate::evidence::period::expected::{AllowedPeriod, Rhythm};
use crate::rules::expectation::{Exp010, Exp015};
use crate::world::event::Event;

/// An expectation in the form of the file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SyncEntry {
    line: u32,
    bus: Option<String>,
    period_ns: Ns,
    tolerance_ns: Ns,
}

impl SyncEntry {
    pub(super) fn check(&self) -> Result<(), String> {
        check_times(self.line, &[Some(self.period_ns)], &[Some(self.tolerance_ns)])
    }
}

/// An expectation and the SYNCs that it is about.
#[derive(Debug)]
struct WatchedSync {
    place: EntryPlace,
    period: AllowedPeriod,
    rhythms: Vec<(BusId, Rhythm)>,
}

/// All expectations of SYNC.
#[derive(Debug)]
pub(super) struct Syncs {
    all: Vec<WatchedSync>,
}

impl Syncs {
    pub(super) fn new(file: &str, entries: &[SyncEntry]) -> Self {
        let all = entries.iter().map(|entry| WatchedSync {
            place: EntryPlace::new(file, entry.line, entry.bus.as_ref(), None),
            period: AllowedPeriod { ns: entry.period_ns, tolerance_ns: entry.tolerance_ns },
            rhythms: Vec::new(),
        });
        Self { all: all.collect() }
    }

    /// Takes a SYNC.
    pub(super) fn sync(&mut self, scene: &mut Scene<'_>) {
        for WatchedSync { place, period, rhythms } in self.all.iter_mut().filter(|one| one.place.is_on(scene.name)) {
            let known = rhythms.iter().position(|(bus, _)| *bus == scene.bus);
            let index = known.unwrap_or_else(|| {
                rhythms.push((scene.bus, Rhythm::default()));
                rhythms.len() - 1
            });
            let Some((_, rhythm)) = rhythms.get_mut(index) else { continue };
            let before = rhythm.last;
            if let Some(gap) = rhythm.beat(scene.at, false, *period) {
                let AllowedPeriod { ns: expected, tolerance_ns: tolerance } = *period;
                let breach = scene.breach(Exp010::Interval { expected, found: gap, tolerance });
                scene.raise(place, Breach { cause: before, ..breach });
            }
        }
    }

    /// Restarts the measurement, since frames of a bus are missing.
    pub(super) fn lost(&mut self, of: BusId) {
        let rhythms = self.all.iter_mut().flat_map(|one| &mut one.rhythms);
        for (_, rhythm) in rhythms.filter(|(bus, _)| *bus == of) {
            rhythm.interrupt();
        }
    }

    /// Reports SYNCs that are overdue at `now_ns`. Findings are at `at`.
    pub(super) fn overdue(&mut self, now_ns: Ns, at: FrameRef, found: &mut Vec<Event>) {
        for WatchedSync { place, period, rhythms } in &mut self.all {
            for (bus, rhythm) in rhythms {
                let Some((gap, last)) = rhythm.overdue(now_ns, *period) else { continue };
                let AllowedPeriod { ns: expected, tolerance_ns: tolerance } = *period;
                let what = Exp010::Overdue { expected, found: gap, tolerance };
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
                let breach = closing.breach(&one.place, Exp010::None { expected: one.period.ns });
                closing.raise(&one.place, breach);
            } else if closing.end_ns.is_none() {
                closing.unchecked(&one.place, Exp015::NoStamps);
            }
        }
    }
}

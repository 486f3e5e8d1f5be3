//! The maximum load of a bus.
//!
//! Bits are counted as in `summary`. Exceeding a limit is reported once, until the load has been below it for a whole
//! window.

use serde::Deserialize;

use super::{Closing, EntryPlace, Scene, check_times, mistake};
use crate::bytes::frame::{BusId, Frame};
use crate::bytes::ns::Ns;
use crate::rules::expectation::{Exp014, Exp015};
use crate::views::summary::bits;
use crate::views::summary::load::Window;

/// The default length of a window in ns: a longer overload delays time-critical frames.
const WINDOW_NS: Ns = Ns::from_ms(100);
/// A timestamp that is earlier by this much means that the clock was set back.
const SET_BACK_NS: Ns = Ns::from_s(1);

/// An expectation in the form of the file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LoadEntry {
    line: u32,
    bus: Option<String>,
    max_percent: f64,
    bit_rate: Option<u32>,
    window_ns: Option<Ns>,
}

impl LoadEntry {
    pub(super) fn check(&self) -> Result<(), String> {
        check_times(self.line, &[self.window_ns], &[])?;
        if self.bit_rate == Some(0) || !(0.0..=100.0).contains(&self.max_percent) {
            return mistake(self.line, "bit_rate or max_percent");
        }
        Ok(())
    }
}

/// The load of one bus.
#[derive(Debug)]
struct MeasuredLoad {
    bus: BusId,
    window: Window,
    /// The start of its time, and the greatest timestamp, in ns.
    start_ns: Ns,
    high_ns: Ns,
    /// The last time with the load above the limit, in ns, unless it has been below it for a whole window since.
    above_ns: Option<Ns>,
}

/// An expectation and its measurement.
#[derive(Debug)]
struct WatchedLoad {
    place: EntryPlace,
    max_percent: f64,
    bit_rate: Option<u32>,
    window_ns: Ns,
    buses: Vec<MeasuredLoad>,
}

/// All expectations of the load.
#[derive(Debug)]
pub(super) struct Loads {
    all: Vec<WatchedLoad>,
}

impl Loads {
    /// `bit_rate`, in bit/s, is the default for expectations without one.
    pub(super) fn new(file: &str, entries: &[LoadEntry], bit_rate: Option<u32>) -> Self {
        let all = entries.iter().map(|entry| WatchedLoad {
            place: EntryPlace::new(file, entry.line, entry.bus.as_ref(), None),
            max_percent: entry.max_percent,
            bit_rate: entry.bit_rate.or(bit_rate).filter(|rate| *rate > 0),
            window_ns: entry.window_ns.unwrap_or(WINDOW_NS),
            buses: Vec::new(),
        });
        Self { all: all.collect() }
    }

    /// Takes a frame.
    pub(super) fn frame(&mut self, frame: &Frame, mut scene: Scene<'_>) {
        let Some(now_ns) = frame.t_ns.filter(|_| !self.all.is_empty()) else { return };
        let bits = u64::from(bits::on_the_wire(frame));
        for one in self.all.iter_mut().filter(|one| one.place.is_on(scene.name)) {
            one.take(bits, now_ns, &mut scene);
        }
    }

    /// Reports at the end of the capture.
    pub(super) fn finish(&self, closing: &mut Closing<'_>) {
        for one in &self.all {
            if one.bit_rate.is_none() {
                closing.unchecked(&one.place, Exp015::NoBitRate);
            } else if closing.end_ns.is_none() {
                closing.unchecked(&one.place, Exp015::NoStamps);
            } else if one.buses.is_empty() {
                closing.unchecked(&one.place, Exp015::NothingMeasured);
            }
        }
    }
}

impl WatchedLoad {
    fn take(&mut self, bits: u64, now_ns: Ns, scene: &mut Scene<'_>) {
        let Some(bit_rate) = self.bit_rate else { return };
        let fresh = |window_ns| MeasuredLoad {
            bus: scene.bus,
            window: Window::new(window_ns),
            start_ns: now_ns,
            high_ns: now_ns,
            above_ns: None,
        };
        let known = self.buses.iter().position(|one| one.bus == scene.bus);
        let place = known.unwrap_or_else(|| {
            self.buses.push(fresh(self.window_ns));
            self.buses.len() - 1
        });
        let Some(measured) = self.buses.get_mut(place) else { return };
        if measured.high_ns - now_ns >= SET_BACK_NS {
            *measured = fresh(self.window_ns);
        }
        measured.high_ns = measured.high_ns.max(now_ns);
        measured.window.add(measured.high_ns - measured.start_ns, bits, scene.at);
        let room = f64::from(bit_rate) * self.window_ns.as_ns() as f64 / 1e9;
        let percent = measured.window.bits_now() as f64 / room * 100.0;
        if percent <= self.max_percent {
            measured.above_ns = measured.above_ns.filter(|since| measured.high_ns - *since < self.window_ns);
        } else if measured.above_ns.replace(measured.high_ns).is_none() {
            // Uses as many digits as are needed to show a difference to the limit.
            let found = [1e2, 1e4, 1e6].map(|scale| (percent * scale).round() / scale);
            let found = found.into_iter().find(|found| *found > self.max_percent).unwrap_or(percent);
            let breach = scene.breach(Exp014::Above { window: self.window_ns, expected: self.max_percent, found });
            scene.raise(&self.place, breach);
        }
    }
}

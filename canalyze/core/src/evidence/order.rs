//! The order in which frames were on the bus, where a capture lists some of them late.
//!
//! A recorder that empties several queues in turn lists a frame up to some ms behind later ones, with its true stamp.
//! Frames are therefore taken in the order of their stamps within [`WINDOW_NS`]. The frames of a bus exchange the places
//! that they have in the capture; the places of other buses stay. A step back of the stamps by more is a set clock, across
//! which nothing is moved.
//!
//! Stamps of two clocks show another order than that of the bus, which the capture then lists. SDO tells which order is
//! right: its requests and responses take turns.
//!
//! Frames wait for later ones only at the beginning of a capture, and for good once one is listed late. A capture in
//! order costs a comparison for each frame from then on.

use std::collections::VecDeque;

use super::recording::CLOCK_STEP_NS;
use crate::bytes::frame::{BusId, Frame, FrameRef, Kind};

/// Time by which a frame may be listed late, in ns: a step back of the stamps by more is a set clock.
const WINDOW_NS: i64 = CLOCK_STEP_NS;
/// Number of frames at the beginning of a capture that wait although none was listed late: where one row in twenty is
/// late, several tens of them are among so many.
const LEARNING: u32 = 1024;
/// Maximum number of waiting frames (invariant 6): more than a bus carries within the window, and those of other buses.
const MOST: usize = 1024;

/// Maximum weight of what SDO has shown so far, in frames.
const CERTAIN: i32 = 16;
/// The time before the first stamp of a bus.
const NEVER: i64 = i64::MIN;

/// Frames that wait for those that are listed late. `T` is what travels with a frame.
#[derive(Debug)]
pub struct Order<T> {
    /// The places of the waiting frames in the capture.
    places: VecDeque<Place>,
    buses: Vec<Waiting<T>>,
    /// Number of frames until the end of the beginning.
    learning: u32,
    /// True once a frame was listed late.
    late: bool,
    /// The time that has come without a frame, in ns.
    now_ns: i64,
}

/// A place in the capture.
#[derive(Clone, Copy, Debug)]
struct Place {
    bus: BusId,
    no: u64,
    /// The frame listed before it on its bus, if their stamps are comparable.
    before: Option<FrameRef>,
}

/// The waiting frames of a bus.
#[derive(Debug)]
struct Waiting<T> {
    /// In the order of their keys.
    frames: VecDeque<(Key, Frame, T)>,
    newest: Key,
    /// The frame released last.
    released: Option<FrameRef>,
    /// The open SDO request of each node; empty until the first one.
    asked: Vec<Option<[u8; 3]>>,
    /// By how many SDO frames the order of the stamps is better than that of the capture; less than 0: frames are
    /// released in that of the capture.
    better: i32,
}

/// The number of steps of the clock before a frame, and its time in ns.
type Key = (u32, i64);

/// A released frame: its number is that of its place now. With it come the frame before it on its bus, if their stamps
/// are comparable, and what travels with it.
pub type Released<T> = (Frame, Option<FrameRef>, T);

impl<T> Default for Order<T> {
    fn default() -> Self {
        Self { places: VecDeque::new(), buses: Vec::new(), learning: LEARNING, late: false, now_ns: NEVER }
    }
}

impl<T> Order<T> {
    /// Returns true if no frame waits.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Frames pass until one is listed late, also at the beginning: on a live bus nothing may wait without need.
    pub fn pass_first(&mut self) {
        self.learning = 0;
    }

    /// Returns true if the next frame need not wait. All frames are given to this.
    #[inline]
    pub fn passes(&mut self, frame: &Frame) -> bool {
        if self.late || self.learning > 0 {
            return false;
        }
        let Some(now) = frame.t_ns else { return true };
        match self.buses.get_mut(usize::from(frame.bus.0)) {
            Some(waiting) if now >= waiting.newest.1 => {
                waiting.newest.1 = now;
                true
            }
            _ => self.is_step(frame),
        }
    }

    /// Returns true if a frame whose stamp falls back, or of a further bus, is not listed late.
    #[cold]
    fn is_step(&mut self, frame: &Frame) -> bool {
        self.late = self.bus(frame.bus).is_some_and(|waiting| waiting.key(frame.t_ns).1);
        if self.late {
            // The frames in between have not waited.
            self.buses.iter_mut().for_each(|waiting| waiting.released = None);
        }
        !self.late
    }

    /// Keeps a frame that does not pass. `before`: the frame listed before it on its bus, if their stamps are comparable.
    pub fn hold(&mut self, frame: &Frame, before: Option<FrameRef>, beside: T) {
        self.learning = self.learning.saturating_sub(1);
        self.places.push_back(Place { bus: frame.bus, no: frame.no, before });
        let Some(waiting) = self.bus(frame.bus) else { return };
        let (key, late) = waiting.key(frame.t_ns);
        let place = match late && waiting.better >= 0 {
            true => waiting.frames.partition_point(|(other, ..)| *other <= key),
            false => waiting.frames.len(),
        };
        waiting.frames.insert(place, (key, *frame, beside));
        self.late |= late;
    }

    /// Advances to `now_ns` without a frame.
    pub fn pass(&mut self, now_ns: i64) {
        self.now_ns = self.now_ns.max(now_ns);
    }

    /// Returns the next frame of which no earlier one can follow. `over`: none follows at all.
    pub fn next(&mut self, over: bool) -> Option<Released<T>> {
        let over = over || self.places.len() > MOST || !self.late && self.learning == 0;
        let place = self.places.front().copied()?;
        let waiting = self.buses.get_mut(usize::from(place.bus.0))?;
        let (step, now) = waiting.newest;
        let waited = |(_, t_ns): Key| now.max(self.now_ns).saturating_sub(t_ns) >= WINDOW_NS;
        let due = |key: Key| key.0 < step || now == NEVER || waited(key);
        waiting.frames.front().filter(|(key, ..)| over || due(*key))?;
        if self.late {
            waiting.compare();
        }
        let (_, mut frame, beside) = waiting.frames.pop_front()?;
        self.places.pop_front();
        frame.moved = (frame.no as i64).saturating_sub(place.no as i64) as i32;
        frame.no = place.no;
        let before = place.before.map(|before| waiting.released.unwrap_or(before));
        waiting.released = Some(frame.reference());
        waiting.follow(&frame);
        Some((frame, before, beside))
    }

    fn bus(&mut self, bus: BusId) -> Option<&mut Waiting<T>> {
        let index = usize::from(bus.0);
        if self.buses.len() <= index {
            self.buses.resize_with(index + 1, Waiting::default);
        }
        self.buses.get_mut(index)
    }
}

impl<T> Default for Waiting<T> {
    fn default() -> Self {
        Self { frames: VecDeque::new(), newest: (0, NEVER), released: None, asked: Vec::new(), better: 0 }
    }
}

impl<T> Waiting<T> {
    /// Returns the key of the next frame of the capture, and true if it is listed late.
    fn key(&mut self, t_ns: Option<i64>) -> (Key, bool) {
        let (step, newest) = self.newest;
        match t_ns {
            Some(now) if now >= newest => self.newest.1 = now,
            Some(now) if newest.saturating_sub(now) < WINDOW_NS => return ((step, now), true),
            Some(now) => self.newest = (step.saturating_add(1), now),
            None => {}
        }
        (self.newest, false)
    }

    /// Compares the order of the stamps with that of the capture at the next SDO frame: only one of them may have it in
    /// turn.
    fn compare(&mut self) {
        let Some((node, _)) = self.frames.front().and_then(|(_, frame, _)| SdoStep::of(frame)) else { return };
        let steps = || {
            let step = |(key, frame, _): &(Key, Frame, T)| Some((*key, frame.no, SdoStep::of(frame)?));
            self.frames.iter().filter_map(step).filter(|(.., (of, _))| *of == node)
        };
        let by_stamp = steps().min_by_key(|(key, no, _)| (*key, *no));
        let by_capture = steps().min_by_key(|(_, no, _)| *no);
        let Some(((_, stamped, (_, one)), (_, listed, (_, other)))) = by_stamp.zip(by_capture) else { return };
        let asked = self.asked.get(node).copied().flatten();
        if stamped == listed || one.is_in_turn(asked) == other.is_in_turn(asked) {
            return;
        }
        let better = (self.better + if one.is_in_turn(asked) { 1 } else { -1 }).clamp(-CERTAIN, CERTAIN);
        if (better < 0) != (self.better < 0) {
            let frames = self.frames.make_contiguous();
            match better < 0 {
                true => frames.sort_by_key(|(_, frame, _)| frame.no),
                false => frames.sort_by_key(|(key, frame, _)| (*key, frame.no)),
            }
        }
        self.better = better;
    }

    /// Takes note of an SDO frame that is released.
    fn follow(&mut self, frame: &Frame) {
        let Some((node, step)) = SdoStep::of(frame) else { return };
        if self.asked.is_empty() {
            self.asked = vec![None; 128];
        }
        if let Some(asked) = self.asked.get_mut(node) {
            *asked = Some(step.content).filter(|_| step.request);
        }
    }
}

/// An SDO frame.
#[derive(Clone, Copy, Debug)]
struct SdoStep {
    request: bool,
    /// The bytes that name the object in most frames that begin a transfer.
    content: [u8; 3],
}

impl SdoStep {
    /// Returns the node of a frame of a default SDO, and what it is.
    fn of(frame: &Frame) -> Option<(usize, Self)> {
        let id = frame.id.raw();
        let is_sdo = matches!(id, 0x581..=0x5FF | 0x601..=0x67F) && !frame.id.is_extended() && frame.kind == Kind::Data;
        let [_, low, high, sub, ..] = frame.data;
        is_sdo.then_some((id as usize & 0x7F, Self { request: id > 0x600, content: [low, high, sub] }))
    }

    /// Returns true for a request while none is open, and for the response to the one that is.
    fn is_in_turn(self, asked: Option<[u8; 3]>) -> bool {
        if self.request { asked.is_none() } else { asked == Some(self.content) }
    }
}

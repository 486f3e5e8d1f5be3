//! The order in which frames were on the bus, where a capture lists some of them late.
//!
//! A recorder that empties several queues in turn lists a frame up to some ms behind later ones, with its true stamp.
//! Frames are therefore taken in the order of their stamps within [`WINDOW_NS`]. The frames of a bus exchange the places
//! that they have in the capture; the places of other buses stay. A step back of the stamps by more is a set clock, across
//! which nothing is moved.
//!
//! Stamps of two clocks show another order than that of the bus. SDO tells which order is right, as its requests and
//! responses take turns, and frames behind later ones of their own sender. Where the stamps of the host are off by the
//! same time in all exchanges ([`super::clocks`]), they are corrected by it for judging; frames are printed with the
//! stamps of the capture.
//!
//! Frames wait for later ones only at the beginning of a capture, and for good once one is listed late. A capture in
//! order costs a comparison for each frame from then on.

use std::collections::VecDeque;

use super::clocks::Clocks;
use super::recording::CLOCK_STEP_NS;
use crate::bytes::frame::{BusId, Frame, FrameRef, Kind};
use crate::bytes::ns::Ns;

/// Time by which a frame may be listed late, in ns: a step back of the stamps by more is a set clock.
const WINDOW_NS: Ns = CLOCK_STEP_NS;
/// Number of frames at the beginning of a capture that wait although none was listed late: where one row in twenty is
/// late, these contain about fifty of them.
const LEARNING: u32 = 1024;
/// Maximum number of waiting frames (invariant 6): those of the beginning, and more than a bus carries within the window.
const MOST: usize = 2 * LEARNING as usize;

/// Number of frames that are late one after the other, in the order of their stamps, if not the frames are late but the
/// clock was set back by less than [`WINDOW_NS`]. Half of them follow later ones of their own CAN-ID then.
const SET_BACK: u32 = 8;
/// Number of SDO frames more that are out of turn by their stamps from which these are of two clocks: each exchange has two
/// then. One may be by the loss of another frame.
const TWO_CLOCKS: u32 = 2;
/// The time before the first stamp of a bus.
const NEVER: Ns = Ns::MIN;

/// Frames that wait for those that are listed late. `T` is what travels with a frame.
#[derive(Debug)]
pub struct Order<T> {
    /// The places of the waiting frames in the capture.
    places: VecDeque<Slot>,
    buses: Vec<Waiting<T>>,
    /// Number of frames until the end of the beginning.
    learning: u32,
    /// True if the waiting frames were learnt from.
    learnt: bool,
    /// True once a frame was listed late.
    late: bool,
    /// The time that has come without a frame, in ns.
    now_ns: Ns,
}

/// A place in the capture.
#[derive(Clone, Copy, Debug)]
struct Slot {
    bus: BusId,
    no: u64,
    /// The frame listed before it on its bus, if their stamps are comparable.
    before: Option<FrameRef>,
}

/// The waiting frames of a bus.
#[derive(Debug)]
struct Waiting<T> {
    /// In the order of their keys.
    frames: VecDeque<(OrderKey, Frame, T)>,
    newest: OrderKey,
    /// The frame released last.
    released: Option<FrameRef>,
    /// The last SDO frames in the order of their keys, before they are followed in this order.
    steps: VecDeque<(OrderKey, SdoStep)>,
    by_capture: Turns,
    by_stamp: Turns,
    /// Number of frames listed behind a later one of their own CAN-ID, as they are not by two clocks.
    behind_own: u32,
    row: LateRow,
    /// The correction of the host's stamps, once it is learnt.
    clocks: Option<Clocks>,
}

/// The last frames of a bus in the capture, if all are listed late, and in the order of their stamps.
#[derive(Clone, Copy, Debug, Default)]
struct LateRow {
    first: u64,
    count: u32,
    last: OrderKey,
    /// Number of those that are listed behind a later one of their own CAN-ID.
    behind_own: u32,
}

impl LateRow {
    fn next(self, key: OrderKey, no: u64, behind_own: bool) -> Self {
        let before = if self.count > 0 && self.last <= key { self } else { Self { first: no, ..Self::default() } };
        let behind_own = before.behind_own + u32::from(behind_own);
        Self { count: before.count + 1, last: key, behind_own, ..before }
    }

    /// Returns true if the clock was set back before the first of them.
    fn is_set_back(self) -> bool {
        self.count == SET_BACK && self.behind_own >= SET_BACK / 2
    }
}

/// The number of steps of the clock before a frame, and its time in ns.
type OrderKey = (u32, Ns);

/// A released frame: its number is that of its place now. With it come the frame before it on its bus, if their stamps
/// are comparable, and what travels with it.
pub type Released<T> = (Frame, Option<FrameRef>, T);

impl<T> Default for Order<T> {
    fn default() -> Self {
        Self {
            places: VecDeque::new(),
            buses: Vec::new(),
            learning: LEARNING,
            learnt: false,
            late: false,
            now_ns: NEVER,
        }
    }
}

impl<T> Order<T> {
    /// Returns true if no frame waits.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Frames pass until one is listed late, also at the beginning: on a live bus or a pipe nothing may wait without need.
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
        let learns = self.learning == 1;
        self.learning = self.learning.saturating_sub(1);
        self.learnt = false;
        self.places.push_back(Slot { bus: frame.bus, no: frame.no, before });
        let Some(waiting) = self.bus(frame.bus) else { return };
        self.late |= waiting.hold(frame, beside);
        if learns {
            self.learn();
        }
    }

    /// Learns from the frames of the beginning by how much the clock of the host is off.
    fn learn(&mut self) {
        self.learnt = true;
        for waiting in &mut self.buses {
            self.late |= waiting.learn();
        }
    }

    /// Advances to `now_ns` without a frame.
    pub fn pass(&mut self, now_ns: Ns) {
        self.now_ns = self.now_ns.max(now_ns);
    }

    /// Returns the next frame once no earlier one can follow. `over`: none follows at all.
    pub fn next(&mut self, over: bool) -> Option<Released<T>> {
        if self.learning > 0 && !over {
            return None;
        }
        if self.learning > 0 && !self.learnt {
            self.learn();
        }
        let over = over || self.places.len() > MOST || !self.late;
        let place = self.places.front().copied()?;
        let waiting = self.buses.get_mut(usize::from(place.bus.0))?;
        if over {
            waiting.compare(true, waiting.by_stamp());
        }
        let (step, now) = waiting.newest;
        let waited = |(_, t_ns): OrderKey| now.max(self.now_ns) - t_ns >= WINDOW_NS;
        let due = |key: OrderKey| key.0 < step || now == NEVER || waited(key);
        waiting.frames.front().filter(|(key, ..)| over || due(*key))?;
        let (_, mut frame, beside) = waiting.frames.pop_front()?;
        self.places.pop_front();
        frame.moved = (frame.no as i64).saturating_sub(place.no as i64) as i32;
        frame.no = place.no;
        let before = place.before.map(|before| waiting.released.unwrap_or(before));
        waiting.released = Some(frame.reference());
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
        Self {
            frames: VecDeque::new(),
            newest: (0, NEVER),
            released: None,
            steps: VecDeque::new(),
            by_capture: Turns::default(),
            by_stamp: Turns::default(),
            behind_own: 0,
            row: LateRow::default(),
            clocks: None,
        }
    }
}

impl<T> Waiting<T> {
    /// Keeps a frame; returns true if it is listed late.
    fn hold(&mut self, frame: &Frame, beside: T) -> bool {
        let corrected;
        let frame = match &self.clocks {
            Some(clocks) => {
                corrected = clocks.corrected(frame);
                &corrected
            }
            None => frame,
        };
        let (key, late) = self.key(frame.t_ns);
        let by_stamp = self.by_stamp();
        let behind = |(other, later, _): &(OrderKey, Frame, T)| *other > key && later.id == frame.id;
        let behind_own = late && self.frames.iter().any(behind);
        self.row = if late { self.row.next(key, frame.no, behind_own) } else { LateRow::default() };
        // Several in a row count once: they may follow a clock that was set back a little.
        self.behind_own = self.behind_own.saturating_add(u32::from(behind_own && self.row.behind_own == 1));
        let place = match late && by_stamp {
            true => self.frames.partition_point(|(other, ..)| *other <= key),
            false => self.frames.len(),
        };
        self.frames.insert(place, (key, *frame, beside));
        if let Some(step) = SdoStep::of(frame) {
            self.by_capture.follow(step);
            let place = self.steps.partition_point(|(other, _)| *other <= key);
            self.steps.insert(place, (key, step));
        }
        if self.row.is_set_back() {
            self.set_back();
        }
        self.compare(false, by_stamp);
        late
    }

    /// Learns by how much the clock of the host is off, and takes the waiting frames again with corrected stamps. Returns
    /// true if it was learnt.
    fn learn(&mut self) -> bool {
        let frames = self.frames.iter().map(|(_, frame, _)| frame);
        let Some(clocks) = Clocks::learn(frames).filter(|_| self.clocks.is_none()) else { return false };
        let mut listed = Vec::from(std::mem::take(&mut self.frames));
        listed.sort_by_key(|(_, frame, _)| frame.no);
        *self = Self { released: self.released, clocks: Some(clocks), ..Self::default() };
        for (_, frame, beside) in listed {
            self.hold(&frame, beside);
        }
        true
    }

    /// Returns the key of the next frame of the capture, and true if it is listed late.
    fn key(&mut self, t_ns: Option<Ns>) -> (OrderKey, bool) {
        let (step, newest) = self.newest;
        match t_ns {
            Some(now) if now >= newest => self.newest.1 = now,
            Some(now) if newest - now < WINDOW_NS => return ((step, now), true),
            Some(now) => self.newest = (step.saturating_add(1), now),
            None => {}
        }
        (self.newest, false)
    }

    /// Returns the order in which frames are released: that of the stamps, unless SDO fits the other one better.
    fn by_stamp(&self) -> bool {
        self.by_stamp.broken < self.by_capture.broken.saturating_add(self.behind_own).saturating_add(TWO_CLOCKS)
    }

    /// The clock was set back before the row of late frames.
    fn set_back(&mut self) {
        let LateRow { first, last, .. } = self.row;
        let by_stamp = self.by_stamp();
        let step = self.newest.0.saturating_add(1);
        self.newest = (step, last.1);
        let frames = self.frames.make_contiguous();
        frames.iter_mut().filter(|(_, frame, _)| frame.no >= first).for_each(|(key, ..)| key.0 = step);
        if by_stamp {
            frames.sort_by_key(|(key, frame, _)| (*key, frame.no));
        }
        let steps = self.steps.make_contiguous();
        steps.iter_mut().filter(|(_, one)| one.no >= first).for_each(|(key, _)| key.0 = step);
        steps.sort_by_key(|(key, one)| (*key, one.no));
        self.row = LateRow::default();
    }

    /// Follows SDO by the stamps as far as no frame can be missing, and sorts the frames again if they are in the wrong
    /// order by that. `over`: no frame follows. `by_stamp`: the order in which they are.
    fn compare(&mut self, over: bool, by_stamp: bool) {
        let (step, now) = self.newest;
        let waits = |key: OrderKey| !over && now != NEVER && key.0 == step && now - key.1 < WINDOW_NS;
        while let Some((_, step)) = self.steps.front().copied().filter(|(key, _)| !waits(*key)) {
            self.by_stamp.follow(step);
            self.steps.pop_front();
        }
        if by_stamp != self.by_stamp() {
            let frames = self.frames.make_contiguous();
            match by_stamp {
                true => frames.sort_by_key(|(_, frame, _)| frame.no),
                false => frames.sort_by_key(|(key, frame, _)| (*key, frame.no)),
            }
        }
    }
}

/// SDO in one order of the frames.
#[derive(Debug, Default)]
struct Turns {
    /// The open request of each node; empty until the first frame.
    open: Vec<Option<[u8; 3]>>,
    /// Number of frames out of turn.
    broken: u32,
}

impl Turns {
    fn follow(&mut self, step: SdoStep) {
        if self.open.is_empty() {
            self.open = vec![None; 128];
        }
        let Some(open) = self.open.get_mut(step.node) else { return };
        let in_turn = if step.request { open.is_none() } else { *open == Some(step.content) };
        self.broken = self.broken.saturating_add(u32::from(!in_turn));
        *open = Some(step.content).filter(|_| step.request);
    }
}

/// A frame of the default SDO of a node.
#[derive(Clone, Copy, Debug)]
struct SdoStep {
    no: u64,
    node: usize,
    request: bool,
    /// The bytes that name the object where a transfer begins. Segments are out of turn in both orders.
    content: [u8; 3],
}

impl SdoStep {
    fn of(frame: &Frame) -> Option<Self> {
        let id = frame.id.raw();
        let is_sdo = matches!(id, 0x581..=0x5FF | 0x601..=0x67F) && !frame.id.is_extended() && frame.kind == Kind::Data;
        let [_, low, high, sub, ..] = frame.data;
        is_sdo.then_some(Self {
            no: frame.no,
            node: id as usize & 0x7F,
            request: id > 0x600,
            content: [low, high, sub],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bytes::frame::CanId;

    /// Returns the released frames, each as its place and its number in the capture, of CAN-IDs at times in µs. Each
    /// two have an object of their own.
    fn released(listed: &[(u16, i64)], first: u32) -> Vec<(u64, u64)> {
        let mut order = Order { learning: first, ..Order::default() };
        let mut out = Vec::new();
        for (place, (id, us)) in listed.iter().enumerate() {
            let (no, t_ns, data) = (place as u64 + 1, Some(Ns::from_us(*us)), [0x40, place as u8 / 2, 0x10, 0]);
            let frame = Frame { no, t_ns, ..Frame::classic(CanId::standard(*id), &data) };
            if order.passes(&frame) {
                out.push((frame.no, frame.no));
                continue;
            }
            order.hold(&frame, None, ());
            out.extend(
                std::iter::from_fn(|| order.next(false)).map(|(frame, ..)| (frame.no, frame.reference().listed().no)),
            );
        }
        out.extend(
            std::iter::from_fn(|| order.next(true)).map(|(frame, ..)| (frame.no, frame.reference().listed().no)),
        );
        out
    }

    #[test]
    fn a_late_frame_takes_its_place() {
        let listed = [(0x181, 0), (0x182, 5_000), (0x183, 2_000), (0x184, 30_000)];
        assert_eq!(released(&listed, LEARNING), [(1, 1), (2, 3), (3, 2), (4, 4)]);
    }

    #[test]
    fn later_ones_do_so_without_a_beginning() {
        let ms = [(0x181, 0), (0x182, 5), (0x183, 2), (0x181, 20), (0x182, 25), (0x183, 22), (0x181, 60)];
        let found = released(&ms.map(|(id, ms)| (id, ms * 1_000)), 0);
        assert_eq!(found, [(1, 1), (2, 2), (3, 3), (4, 4), (5, 6), (6, 5), (7, 7)]);
    }

    #[test]
    fn nothing_crosses_a_set_clock() {
        let listed = [(0x181, 100_000), (0x182, 105_000), (0x181, 50_000), (0x182, 55_000), (0x183, 52_000)];
        assert_eq!(released(&listed, LEARNING), [(1, 1), (2, 2), (3, 3), (4, 5), (5, 4)]);
    }

    #[test]
    fn a_clock_set_back_by_little_is_no_disorder() {
        let listed: Vec<_> = (0..100).chain(50..200).map(|at| (0x181, at * 100)).collect();
        assert!(released(&listed, LEARNING).iter().all(|(place, no)| place == no));
    }

    #[test]
    fn exchanges_show_two_clocks() {
        let listed: Vec<_> =
            (0..8).flat_map(|at| [(0x605, at * 20_000 + 3_000), (0x585, at * 20_000 + 1_000)]).collect();
        assert!(released(&listed, LEARNING).iter().all(|(place, no)| place == no));
    }
}

//! Frames that are in a file twice: as sent to a driver, and as the driver then received them itself.
//!
//! `ros2_socketcan` sends the frames of `to_can_bus`; if its sockets receive each other's frames, each appears on
//! `from_can_bus` as well, a moment later. It was on the bus once: one frame is emitted, at the time of reception, with
//! direction Tx. An equal frame of another node is never taken for an echo, so
//!
//! - a sent frame has at most one echo, an equal frame within [`LATEST_NS`], which belongs to the last sent frame;
//! - a bus has echoes only if most of its first [`JUDGED`] sent frames have one; otherwise the driver does not receive
//!   its own frames. Frames wait for that decision;
//! - a sent frame without an echo remains.
//!
//! Frames keep their order, and only held frames are examined.

use super::held::Held;
use crate::bytes::frame::Direction;

/// Maximum delay of an echo, since a frame may wait for the bus.
const LATEST_NS: i64 = 20_000_000;
/// Maximum time by which an echo may seem to come first, since the times may be of two clocks.
const EARLIEST_NS: i64 = 2_000_000;
/// Number of sent frames that show if a driver receives its own frames.
const JUDGED: u32 = 16;
/// Maximum number of sent frames that wait for their echo.
const MOST_PENDING: usize = 1024;

/// The evidence about echoes. Places are indexes of held frames.
#[derive(Debug, Default)]
pub(super) struct Echoes {
    /// True if a bus has topics of both directions.
    pub(super) sought: bool,
    buses: Vec<EchoBus>,
    /// The first frame that has not been examined.
    pub(super) next: usize,
}

/// One bus.
#[derive(Debug, Default)]
struct EchoBus {
    /// True if the driver receives its own frames; `None` until known.
    echoes: Option<bool>,
    /// Sent frames without an echo so far.
    pending: Vec<usize>,
    /// Sent frames with their possible echoes, until the decision.
    pairs: Vec<(usize, usize)>,
    /// The first time of a received frame.
    heard_ns: Option<i64>,
    judged: u32,
    found: u32,
}

impl Echoes {
    /// Examines the frames before `end`, which stay in place.
    pub(super) fn look(&mut self, held: &mut [Held], end: usize) {
        for place in self.next..end {
            self.one(held, place);
        }
        self.next = self.next.max(end);
        let now_ns = end.checked_sub(1).and_then(|last| held.get(last)).map(|frame| frame.t_ns);
        if now_ns.is_some() {
            self.buses.iter_mut().for_each(|bus| bus.judge(held, now_ns));
        }
    }

    /// Returns the number of examined frames that may be released.
    pub(super) fn free(&self, held: &[Held]) -> usize {
        let Some(last) = self.next.checked_sub(1).and_then(|last| held.get(last)) else { return 0 };
        let since = last.t_ns.saturating_sub(EARLIEST_NS);
        let looked = held.get(..self.next).unwrap_or_default();
        let old = looked.iter().rposition(|frame| frame.t_ns < since).map_or(0, |place| place + 1);
        let waits =
            self.buses.iter().flat_map(|bus| bus.pending.first().into_iter().chain(bus.pairs.iter().map(first)));
        waits.fold(old, |count, place| count.min(*place))
    }

    /// Decides by the evidence so far. `last`: no more frames follow.
    pub(super) fn decide(&mut self, held: &mut [Held], last: bool) {
        for bus in &mut self.buses {
            if last {
                bus.judge(held, None);
            }
            if bus.judged > 0 {
                bus.decide(held);
            }
            bus.pairs.clear();
        }
    }

    /// Adjusts to `count` frames released from the beginning.
    pub(super) fn gone(&mut self, count: usize) {
        self.next = self.next.saturating_sub(count);
        for bus in &mut self.buses {
            bus.pending.retain_mut(|place| shift(place, count));
            bus.pairs.retain_mut(|(sent, echo)| shift(sent, count) && shift(echo, count));
        }
    }

    fn one(&mut self, held: &mut [Held], place: usize) {
        let Some(frame) = held.get(place) else { return };
        let index = usize::from(frame.bus.0);
        if self.buses.len() <= index {
            self.buses.resize_with(index + 1, EchoBus::default);
        }
        let Some(bus) = self.buses.get_mut(index) else { return };
        match frame.dir {
            _ if bus.echoes == Some(false) => {}
            Some(Direction::Tx) => bus.sent(held, place),
            Some(Direction::Rx) => bus.heard(held, place),
            None => {}
        }
    }
}

impl EchoBus {
    fn sent(&mut self, held: &mut [Held], place: usize) {
        self.judge(held, held.get(place).map(|frame| frame.t_ns));
        let Some(frame) = held.get(place) else { return };
        let since = frame.t_ns.saturating_sub(EARLIEST_NS);
        let before = held.get(..place).unwrap_or_default();
        let near = before.iter().enumerate().rev().take_while(|(_, other)| other.t_ns >= since);
        let mut fits = near.filter(|(_, other)| other.dir == Some(Direction::Rx) && other.same(frame));
        let early = fits.find(|(at, _)| !self.pairs.iter().any(|(_, echo)| echo == at)).map(|(at, _)| at);
        if let Some(echo) = early {
            return self.pair(held, place, echo);
        }
        if self.pending.len() >= MOST_PENDING {
            self.pending.remove(0);
        }
        self.pending.push(place);
    }

    fn heard(&mut self, held: &mut [Held], place: usize) {
        self.judge(held, held.get(place).map(|frame| frame.t_ns));
        let Some(frame) = held.get(place) else { return };
        let sent = self.pending.iter().rposition(|sent| held.get(*sent).is_some_and(|sent| sent.same(frame)));
        self.heard_ns.get_or_insert(frame.t_ns);
        if let Some(sent) = sent {
            let sent = self.pending.remove(sent);
            self.pair(held, sent, place);
        }
    }

    /// Counts sent frames that are too old for an echo, except those before the first received frame, since the two
    /// recordings may begin at different times.
    fn judge(&mut self, held: &mut [Held], now_ns: Option<i64>) {
        let heard_ns = self.heard_ns;
        let (mut silent, time) = (0, |place: &usize| held.get(*place).map_or(i64::MIN, |sent| sent.t_ns));
        self.pending.retain(|place| {
            let stays = now_ns.is_some_and(|now_ns| now_ns.saturating_sub(time(place)) <= LATEST_NS);
            silent += u32::from(!stays && heard_ns.is_some_and(|heard_ns| heard_ns < time(place)));
            stays
        });
        self.count(held, silent, 0);
    }

    fn pair(&mut self, held: &mut [Held], sent: usize, echo: usize) {
        if self.echoes == Some(true) {
            return merge(held, sent, echo);
        }
        self.pairs.push((sent, echo));
        self.count(held, 1, 1);
    }

    fn count(&mut self, held: &mut [Held], judged: u32, found: u32) {
        self.judged = self.judged.saturating_add(judged);
        self.found = self.found.saturating_add(found);
        if self.judged >= JUDGED {
            self.decide(held);
        }
    }

    fn decide(&mut self, held: &mut [Held]) {
        let echoes =
            *self.echoes.get_or_insert(self.found > 0 && u64::from(self.found) * 4 >= u64::from(self.judged) * 3);
        let pairs = std::mem::take(&mut self.pairs);
        if echoes {
            pairs.into_iter().for_each(|(sent, echo)| merge(held, sent, echo));
        } else {
            self.pending.clear();
        }
    }
}

/// Turns the two frames into one.
fn merge(held: &mut [Held], sent: usize, echo: usize) {
    if let Some(frame) = held.get_mut(sent) {
        frame.gone = true;
    }
    if let Some(frame) = held.get_mut(echo) {
        frame.dir = Some(Direction::Tx);
    }
}

fn first((sent, echo): &(usize, usize)) -> &usize {
    sent.min(echo)
}

/// Moves a place; returns true if the frame is still held.
fn shift(place: &mut usize, count: usize) -> bool {
    let stays = *place >= count;
    *place = place.saturating_sub(count);
    stays
}

#[cfg(test)]
mod tests {
    use super::super::order::Order;
    use super::*;
    use crate::bytes::frame::{BusId, CanId, Frame};
    use crate::bytes::ns::Ns;
    use Direction::{Rx, Tx};

    const MS: i64 = 1_000_000;

    /// Returns the released frames: time in µs, direction, identifier; and the number of removed ones.
    fn given(frames: &[(i64, Direction, u16)]) -> (Vec<(i64, Direction, u32)>, u64) {
        let mut whole = Vec::new();
        // All at once or in small parts: the same result.
        for part in [frames.len().max(1), 3] {
            let (mut order, mut out) = (Order::new(), Vec::new());
            order.seek_echoes();
            let mut to = |frame: Frame| {
                out.push((frame.t_ns.map_or(0, Ns::as_ns) / 1000, frame.dir.unwrap_or(Rx), frame.id.raw()))
            };
            for part in frames.chunks(part) {
                order.release(part.iter().map(|(t_us, ..)| t_us * 1000).min().unwrap_or(0), &mut to);
                for (t_us, dir, id) in part {
                    let mut frame = Held::classic(t_us * 1000, CanId::standard(*id), BusId(0), None, 0, [0; 8]);
                    frame.dir = Some(*dir);
                    order.push(frame, &mut to);
                }
            }
            order.release_all(&mut to);
            whole.push((out, order.echoes()));
        }
        assert_eq!(whole.first(), whole.last());
        whole.pop().unwrap_or_default()
    }

    #[test]
    fn a_driver_that_hears_itself() {
        let frames = [(0, Rx, 0x701), (1000, Tx, 0x601), (1300, Rx, 0x601), (1600, Rx, 0x581), (9000, Rx, 0x701)];
        let out = vec![(0, Rx, 0x701), (1300, Tx, 0x601), (1600, Rx, 0x581), (9000, Rx, 0x701)];
        assert_eq!(given(&frames), (out, 1));
        // Two clocks: the echo seems to come first.
        let out = vec![(0, Rx, 0x701), (1000, Tx, 0x601), (1600, Rx, 0x581)];
        assert_eq!(given(&[(0, Rx, 0x701), (1000, Rx, 0x601), (1100, Tx, 0x601), (1600, Rx, 0x581)]), (out, 1));
    }

    #[test]
    fn a_driver_that_does_not() {
        // Every tenth SYNC of another producer happens to be near.
        let mut frames = Vec::new();
        for number in 0..40 {
            frames.push((number * 50_000, Tx, 0x80));
            frames.push((number * 50_000 + 25_000, Rx, 0x701));
            if number % 10 == 0 {
                frames.push((number * 50_000 + 30_000, Rx, 0x80));
                frames.push((number * 50_000 + 49_900, Rx, 0x80));
            }
        }
        frames.sort_by_key(|frame| frame.0);
        assert_eq!(given(&frames), (frames.iter().map(|(t, dir, id)| (*t, *dir, u32::from(*id))).collect(), 0));
    }

    #[test]
    fn what_another_node_sends_stays() {
        let (mut frames, mut other) = (Vec::new(), 0);
        for number in 0..100 {
            let at = number * 10_000;
            frames.extend([(at, Tx, 0x80), (at + 200, Rx, 0x80)]);
            // A second producer.
            if number % 3 == 0 {
                frames.push((at + 5000, Rx, 0x80));
                other += 1;
            }
        }
        let (out, gone) = given(&frames);
        assert_eq!((out.len(), gone), (100 + other, 100));
        assert_eq!(out.iter().filter(|(_, dir, _)| *dir == Tx).count(), 100);
    }

    #[test]
    fn a_sent_frame_without_an_echo_stays() {
        let mut frames: Vec<_> =
            (0..40).flat_map(|no| [(no * 10_000, Tx, 0x80), (no * 10_000 + 200, Rx, 0x80)]).collect();
        frames.remove(41);
        let (out, gone) = given(&frames);
        assert_eq!((out.len(), gone), (40, 39));
        assert_eq!(out.get(20), Some(&(200_000, Tx, 0x80)));
    }

    #[test]
    fn too_late_is_no_echo() {
        let frames = [(0, Rx, 0x701), (1000, Tx, 0x601), (1000 + LATEST_NS / 1000 + 1, Rx, 0x601), (90_000, Rx, 0x701)];
        assert_eq!(given(&frames).1, 0);
        assert_eq!(LATEST_NS / MS, 20);
    }
}

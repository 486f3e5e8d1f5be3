//! Stamps of two clocks in one capture: the frames of the host are stamped by another clock than those of the bus, which
//! is behind it. Where it is ahead, the host's frames are late, as with echoes ([`super::recording`]).
//!
//! Each SDO or LSS exchange bounds the difference: its request was sent before its response, and the next request after
//! it. A difference that all exchanges bound alike, and that is needed to bring them in order, is that of the clocks. A
//! client that does not wait for responses breaks the order as well, but not by the same time in every exchange.

use crate::bytes::frame::{Direction, Frame, Kind};
use crate::bytes::ns::Ns;

/// Maximum difference of the clocks, in ns.
const MOST_APART_NS: Ns = Ns::from_us(10_500);
/// Number of exchanges more that are in order with corrected stamps, from which the clocks differ.
const EXCHANGES: usize = 3;
/// Part of the exchanges, in tenths, that must be in order with corrected stamps.
const MOST_TENTHS: usize = 9;
/// Usual time between a request and its response, or between a response and the next request, in ns.
const USUAL_NS: Ns = Ns::from_us(500);

/// The difference of the host's clock from that of the other frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Clocks {
    /// Time by which the host's stamps are early, in ns.
    early_ns: Ns,
    /// True if SYNC is of the host.
    sync: bool,
}

impl Clocks {
    /// Learns the difference from the frames of one bus; `None` if its stamps fit one clock.
    pub(super) fn learn<'a>(frames: impl Iterator<Item = &'a Frame> + Clone) -> Option<Self> {
        let bounds = Bounds::of(frames.clone());
        let early_ns = difference(&bounds)?;
        Some(Self { early_ns, sync: is_sync_of_host(frames, early_ns) })
    }

    /// Returns a frame with the stamp that the other clock would have given it.
    pub(super) fn corrected(&self, frame: &Frame) -> Frame {
        let Some(t_ns) = frame.t_ns.filter(|_| frame.corrected_ns == 0 && self.is_of_host(frame)) else {
            return *frame;
        };
        Frame { t_ns: Some(t_ns + self.early_ns), corrected_ns: self.early_ns.as_ns() as i32, ..*frame }
    }

    fn is_of_host(&self, frame: &Frame) -> bool {
        match frame.dir {
            Some(direction) => direction == Direction::Tx,
            None if frame.id.is_extended() || frame.kind == Kind::Error => false,
            None if frame.kind == Kind::Remote => true,
            None => match frame.id.raw() {
                0x080 => self.sync,
                // NMT, TIME, RPDOs, SDO requests, LSS requests.
                0 | 0x100 | 0x201..=0x27F | 0x301..=0x37F | 0x401..=0x47F | 0x501..=0x57F | 0x601..=0x67F | 0x7E5 => {
                    true
                }
                _ => false,
            },
        }
    }
}

/// Returns true if SYNC is of the host: corrected, it is not carried past PDOs that answer it.
fn is_sync_of_host<'a>(frames: impl Iterator<Item = &'a Frame>, early_ns: Ns) -> bool {
    let mut listed: Vec<_> = frames
        .filter(|frame| !frame.id.is_extended() && frame.kind == Kind::Data)
        .filter_map(|frame| Some((frame.t_ns?, frame.id.raw())))
        .filter(|(_, id)| matches!(id, 0x080 | 0x181..=0x1FF | 0x281..=0x2FF | 0x381..=0x3FF | 0x481..=0x4FF))
        .collect();
    listed.sort_unstable();
    let followed = listed.iter().zip(listed.iter().skip(1)).filter(|(one, next)| one.1 == 0x080 && next.1 != 0x080);
    let passed = followed.filter(|(one, next)| next.0 - one.0 < early_ns).count();
    passed * 2 < listed.iter().filter(|(_, id)| *id == 0x080).count()
}

/// The least and the greatest difference by one exchange, in ns.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    least_ns: Ns,
    greatest_ns: Ns,
}

impl Bounds {
    fn hold(self, early_ns: Ns) -> bool {
        self.least_ns <= early_ns && early_ns <= self.greatest_ns
    }

    /// Returns those of the exchanges of all nodes.
    fn of<'a>(frames: impl Iterator<Item = &'a Frame>) -> Vec<Self> {
        let mut halves: Vec<_> = frames.filter_map(ExchangeFrame::of).collect();
        halves.sort_by_key(|half| (half.node, half.t_ns));
        let mut found = Vec::new();
        for of_node in halves.chunk_by(|one, next| one.node == next.node) {
            let mut requests = of_node.iter().filter(|half| half.request).peekable();
            for response in of_node.iter().filter(|half| !half.request && half.repeated.is_some()) {
                let mut rest = requests.clone();
                let Some(request) = rest.find(|request| request.repeated == response.repeated) else { continue };
                let waited = response.t_ns - request.t_ns;
                if waited <= -MOST_APART_NS {
                    continue;
                }
                let next = rest.peek().map_or(Ns::MIN, |next| response.t_ns - next.t_ns);
                found.push(Self { least_ns: next, greatest_ns: waited });
                requests = rest;
            }
        }
        found
    }
}

/// Returns the time by which the requests are early, in ns, if the exchanges show one.
fn difference(bounds: &[Bounds]) -> Option<Ns> {
    let held = |early_ns: Ns| bounds.iter().filter(|one| one.hold(early_ns)).count();
    let now = held(Ns::ZERO);
    if bounds.len() < now + EXCHANGES {
        return None;
    }
    // The difference is beside one of the bounds.
    let candidates = bounds.iter().map(|one| one.least_ns).filter(|early| (Ns(1)..=MOST_APART_NS).contains(early));
    let early = candidates.max_by_key(|early| held(*early))?;
    let all = held(early);
    if all < now + EXCHANGES || all * 10 < bounds.len() * MOST_TENTHS {
        return None;
    }
    let greatest = bounds.iter().filter(|one| one.hold(early)).map(|one| one.greatest_ns).min()?;
    Some(early + ((greatest - early) / 2).min(USUAL_NS))
}

/// A request or a response of a default SDO or of LSS.
#[derive(Clone, Copy, Debug)]
struct ExchangeFrame {
    t_ns: Ns,
    /// The SDO server; 0 for LSS.
    node: u32,
    request: bool,
    /// The content that a response repeats: the object, where an SDO transfer begins, or the LSS command.
    repeated: Option<[u8; 3]>,
}

impl ExchangeFrame {
    fn of(frame: &Frame) -> Option<Self> {
        let t_ns = frame.t_ns.filter(|_| !frame.id.is_extended() && frame.kind == Kind::Data)?;
        let [command, low, high, sub, ..] = frame.data;
        let (node, request, repeated) = match frame.id.raw() {
            0x7E5 => (0, true, Some([command, 0, 0])),
            // The response to the last part of an LSS address is by the node that has it.
            0x7E4 => (0, false, Some([if command == 0x44 { 0x43 } else { command }, 0, 0])),
            id @ (0x581..=0x5FF | 0x601..=0x67F) => {
                let request = id > 0x600;
                let begins = match (request, command >> 5) {
                    (true, 1 | 2) | (false, 2..=4) => true,
                    // Block transfers: initiate has bit 0 clear in both directions.
                    (_, 5 | 6) => command & 1 == 0,
                    _ => false,
                };
                (id & 0x7F, request, begins.then_some([low, high, sub]))
            }
            _ => return None,
        };
        Some(Self { t_ns, node, request, repeated })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bytes::frame::CanId;

    /// Returns the difference that exchanges show: times of requests and responses, in µs.
    fn learnt(exchanges: &[(i64, i64)]) -> Option<i64> {
        let half = |id, (number, us): (usize, i64)| Frame {
            t_ns: Some(Ns::from_us(us)),
            ..Frame::classic(CanId::standard(id), &[if id > 0x600 { 0x40 } else { 0x43 }, number as u8, 0x20, 0])
        };
        let requests = exchanges.iter().map(|one| one.0).enumerate().map(|one| half(0x605, one));
        let responses = exchanges.iter().map(|one| one.1).enumerate().map(|one| half(0x585, one));
        let frames: Vec<_> = requests.chain(responses).collect();
        Clocks::learn(frames.iter()).map(|clocks| clocks.early_ns.as_ns() / 1_000)
    }

    /// Exchanges one after the other: each response takes its time, and the next request 300 µs more, in µs.
    fn exchanges(delays: &[i64], early: i64) -> Vec<(i64, i64)> {
        let mut now = 0;
        let mut found = Vec::new();
        for delay in delays {
            found.push((now - early, now + delay));
            now += delay + 300;
        }
        found
    }

    const DELAYS: [i64; 8] = [400, 700, 2_500, 900, 450, 4_000, 600, 500];

    #[test]
    fn the_difference_is_learnt_over_its_magnitudes() {
        for early in [500, 1_000, 2_000, 5_000, 10_000] {
            let found = learnt(&exchanges(&DELAYS, early)).unwrap_or_default();
            assert!((found - early).abs() <= 500, "{early}: {found}");
        }
    }

    #[test]
    fn one_clock_needs_no_correction() {
        assert_eq!(learnt(&exchanges(&DELAYS, 0)), None);
        assert_eq!(learnt(&exchanges(&DELAYS, 200)), None);
        assert_eq!(learnt(&exchanges(&DELAYS, -2_000)), None);
    }

    #[test]
    fn a_client_that_gives_up_is_no_second_clock() {
        // It waits for 5 ms; every other response takes longer, by its own time.
        let late = [(0, 400), (900, 11_900), (5_900, 6_400), (6_900, 9_900), (20_000, 31_000), (25_000, 25_400)];
        assert_eq!(learnt(&late), None);
    }

    #[test]
    fn two_exchanges_out_of_order_are_too_few() {
        assert_eq!(learnt(&exchanges(&DELAYS[..2], 5_000)), None);
    }
}

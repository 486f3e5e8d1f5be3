//! The load of a bus: an identifier that floods it, more frames than it can carry, and PDOs that multiply after a
//! repeated start.
//!
//! The bit rate is given, or derived from frames without an idle gap between them; the shortest gaps of the capture are a
//! lower bound. Bits are estimated (`summary` counts exactly). SDO is not judged, since block transfers fill a bus by design.

use crate::bytes::frame::{CanId, Frame, FrameRef};
use crate::bytes::ns::Ns;
use crate::evidence::period::recent::UsualGap;
use crate::problems::kinds::ProblemKind;
use crate::problems::ledger::LedgerPlace;
use crate::problems::problem::{Grade, StepRole, Subject};
use crate::problems::sayings::Saying;
use crate::problems::scene::Scene;
use crate::rules::finding::Quantity;
use crate::wire::cob_id::Role as Carries;
use crate::world::bus::Bus;

/// Number of 11-bit identifiers.
const IDENTIFIERS: usize = 0x800;
/// Window for measuring the load, in ns.
const WINDOW_NS: Ns = Ns::from_ms(100);
/// Load in percent of the bit rate from which on frames of low priority wait, and below which that is over.
const OVERLOAD: i64 = 80;
const RELIEVED: i64 = 60;
/// Number of consecutive windows that begin or end an overload.
const WINDOWS: u32 = 3;
/// Minimum ratio of a flood's rate to the rate before, ...
const TIMES: i64 = 5;
/// ... its minimum number of frames, minimum duration in ns, and maximum mean gap in ns.
const RUN: u32 = 50;
const RUN_NS: Ns = Ns::from_ms(200);
const RUN_GAP_NS: Ns = Ns::from_ms(10);
/// Number of frames of a new identifier from which it may flood the bus, and number of frames of others that were due since
/// then at their rate before, of which less than a quarter came.
const NEW: u32 = 128;
const DUE: i64 = 8;
/// Time without a frame after which a flood is over, in ns.
const DRY_NS: Ns = Ns::from_ms(500);
/// Maximum time from a write or command to traffic that it caused, in ns, which is no flood.
const ASKED_NS: Ns = Ns::from_s(1);
/// Number of frames after a repeated start that show the new period of a PDO.
const AFTER_START: u32 = 12;
/// The bit rates of CANopen (CiA 301, table 1), in kbit/s.
const RATES: [i64; 8] = [10, 20, 50, 125, 250, 500, 800, 1000];
/// Part of the frames, and number of them, that may be stamped closer than they were on the bus.
const UNEVEN: u64 = 20;
const FEW: u64 = 4;

/// The known traffic of an identifier.
#[derive(Clone, Copy, Debug, Default)]
struct Stream {
    last: FrameRef,
    usual: UsualGap,
    /// Number of frames in a run of a far higher rate, and its beginning.
    run: u32,
    since: FrameRef,
    /// Number of frames of the bus before it.
    before: u64,
    /// The first frame, the number of frames of the bus up to it, and the number of its frames.
    first: FrameRef,
    ahead: u64,
    count: u32,
    /// True if it has flooded the bus since its first frame.
    new: bool,
    flood: Option<LedgerPlace>,
    /// Mean gap before a repeated start in ns, its frame, and the number of frames since.
    started: Option<(Ns, FrameRef, u32)>,
}

impl Stream {
    /// Returns true if no other frames have come since its first one, although they were due. `frames`: number of frames
    /// of the bus so far, which `began` with one.
    fn silences(&self, at: FrameRef, frames: u64, began: FrameRef) -> bool {
        let (Some(before), Some(lasts)) = (self.first.since(began), at.since(self.first)) else { return false };
        let due = lasts / 1_000 * self.ahead as i64 / (before / 1_000).max(Ns(1));
        let others = (frames - self.ahead).saturating_sub(u64::from(self.count));
        let dense = lasts / i64::from(self.count.max(1)) <= RUN_GAP_NS;
        dense && before >= lasts && due >= DUE && others.saturating_mul(4) < due.unsigned_abs()
    }
}

/// The contents of a window.
#[derive(Clone, Copy, Debug, Default)]
struct Window {
    begin: FrameRef,
    bits: i64,
    frames: u32,
    /// Number of gaps too short for a frame at the assumed rate, and of gaps that just fit one.
    short: u32,
    tight: u32,
    /// Lengths of frames right behind another one, one bit each.
    lengths: u64,
}

/// The load of a bus.
#[derive(Clone, Debug, Default)]
pub(in crate::problems) struct LoadProblem {
    streams: Vec<Stream>,
    /// Number of floods so far.
    flooded: u32,
    /// Number of frames so far, and the first one.
    frames: u64,
    began: Option<FrameRef>,
    last_ns: Option<Ns>,
    /// Number of frames that came too soon for the rate below, by [`RATES`].
    faster: [u64; RATES.len()],
    /// The identifier of the last frame, and the number of [`RATES`] at which an SDO response came too soon.
    last_id: u32,
    answered: usize,
    window: Window,
    /// The rate that the previous window would fill, in kbit/s, and the number of consecutive windows that were full or
    /// relieved.
    assumed: i64,
    full: u32,
    relieved: u32,
    /// Beginning of the row of full windows.
    since: FrameRef,
    open: Option<LedgerPlace>,
    /// The last full window.
    last_full: FrameRef,
}

/// Returns the approximate number of bits of a frame on the wire, including stuffing and the interframe space.
fn bits(frame: &Frame) -> i64 {
    let bare = if frame.id.is_extended() { 54 } else { 34 } + 8 * i64::from(frame.len);
    bare + 13 + bare / 12
}

impl LoadProblem {
    /// Processes a frame of the bus, with its node.
    #[inline]
    pub(in crate::problems) fn frame(&mut self, frame: &Frame, node: Option<u8>, scene: &mut Scene<'_>) {
        let Some(now) = frame.t_ns else { return };
        self.frames += 1;
        let size = bits(frame);
        if let Some(last) = self.last_ns.replace(now) {
            let gap = now - last;
            // What follows asks for no more than 1.28 times the frame's own time: most gaps are longer, without a division.
            let near = gap * self.assumed.max(1) < Ns::from_us(size * 1_300);
            let least_ns = if near { Ns::from_ms(size) / self.assumed.max(1) * 8 / 10 } else { Ns::ZERO };
            self.window.short += u32::from(gap < least_ns);
            let carried = RATES.iter().take_while(|rate| Ns::from_ms(size) > gap.max(Ns::ZERO) * (**rate * 5 / 4));
            if let Some(rate) = carried.count().checked_sub(1)
                && let Some(count) = self.faster.get_mut(rate)
            {
                *count += 1;
                // A response is sent once its request was received, however unevenly others are stamped.
                let answers = (0x581..0x600).contains(&frame.id.raw()) && self.last_id == frame.id.raw() + 0x80;
                self.answered = self.answered.max(if answers { rate + 1 } else { 0 });
            }
            if near && self.assumed > 0 && (least_ns..=least_ns * 8 / 5).contains(&gap) {
                self.window.tight += 1;
                self.window.lengths |= 1 << (frame.len & 63);
            }
        }
        self.last_id = frame.id.raw();
        let over =
            frame.reference().since(self.window.begin).is_none_or(|since| !(Ns::ZERO..WINDOW_NS).contains(&since));
        if over || self.window.frames == 0 {
            self.window_over(frame.reference(), scene);
        }
        self.window.bits += size;
        self.window.frames += 1;
        let identifier = frame.id.raw() as usize;
        let sdo = (0x580..0x680).contains(&identifier);
        if !frame.id.is_extended() && !sdo && identifier < IDENTIFIERS {
            self.stream(identifier, frame.reference(), node, scene);
        }
    }

    #[inline]
    fn stream(&mut self, identifier: usize, at: FrameRef, node: Option<u8>, scene: &mut Scene<'_>) {
        if self.streams.is_empty() {
            self.streams.resize(IDENTIFIERS, Stream::default());
        }
        let (frames, began) = (self.frames, *self.began.get_or_insert(at));
        let Some(one) = self.streams.get_mut(identifier) else { return };
        let last = std::mem::replace(&mut one.last, at);
        if last.no == 0 {
            (one.first, one.ahead) = (at, frames);
        }
        let Some(gap) = at.since(last).filter(|gap| last.no > 0 && *gap >= Ns::ZERO) else { return };
        if one.new && gap <= RUN_GAP_NS {
            return;
        }
        one.new = false;
        one.count = one.count.saturating_add(1);
        if one.count >= NEW && one.count.is_power_of_two() && one.flood.is_none() && one.silences(at, frames, began) {
            one.new = true;
            self.flooded += 1;
            one.flood = scene.ledger.open(ProblemKind::Flood, scene.id, Subject::of(node), one.first, at);
            if let Some(flood) = one.flood.and_then(|place| scene.ledger.get_mut(place)) {
                flood.fact("id", Quantity::Id(CanId::standard(identifier as u16)));
                flood.fact("gap", Quantity::Ns(at.since(one.first).unwrap_or(Ns::ZERO) / i64::from(one.count)));
            }
            return;
        }
        if let Some((before, since, count)) = one.started {
            let since = if count == 0 { at } else { since };
            one.started = Some((before, since, count + 1)).filter(|_| count + 1 < AFTER_START);
            if one.started.is_none() {
                let now = at.since(since).unwrap_or(Ns::ZERO) / i64::from(count.max(1));
                multiplied(identifier, (before, now), (since, at), scene);
            }
        }
        let Some(one) = self.streams.get_mut(identifier) else { return };
        if !one.usual.is_known() || gap * TIMES > one.usual.ns {
            one.usual.learn(gap);
            one.run = 0;
            if let Some(place) = one.flood.take() {
                over(place, last, scene);
            }
            return;
        }
        if one.run == 0 {
            (one.since, one.before) = (at, frames);
        }
        one.run += 1;
        let lasts = at.since(one.since).unwrap_or(Ns::ZERO);
        let dense = lasts / i64::from(one.run) <= RUN_GAP_NS;
        let share = u64::from(one.run) * 2 > frames - one.before;
        if one.flood.is_some() || one.run < RUN || lasts < RUN_NS || !dense || !share {
            return;
        }
        let asked = node.and_then(|node| scene.heard.asked(node));
        if asked.is_some_and(|asked| one.since.since(asked).is_some_and(|since| since.abs() <= ASKED_NS)) {
            return;
        }
        self.flooded += 1;
        one.flood = scene.ledger.open(ProblemKind::Flood, scene.id, Subject::of(node), one.since, at);
        if let Some(flood) = one.flood.and_then(|place| scene.ledger.get_mut(place)) {
            flood.fact("id", Quantity::Id(CanId::standard(identifier as u16)));
            flood.fact("period", Quantity::Ns(one.usual.ns));
            flood.fact("gap", Quantity::Ns(lasts / i64::from(one.run)));
            flood.step(
                one.since,
                StepRole::Sign,
                Saying::Floods { gap: lasts / i64::from(one.run), period: one.usual.ns },
                None,
            );
        }
    }

    /// Ends floods without a frame for long enough.
    fn dry(&mut self, at: FrameRef, scene: &mut Scene<'_>) {
        for one in self.streams.iter_mut().filter(|one| one.flood.is_some()) {
            let rest = at.since(one.last).unwrap_or(Ns::ZERO);
            if rest > one.usual.ns.max(DRY_NS)
                && let Some(place) = one.flood.take()
            {
                one.run = 0;
                over(place, one.last, scene);
            }
        }
    }

    /// Concludes at the end of the capture.
    pub(in crate::problems) fn finish(&mut self, scene: &mut Scene<'_>) {
        self.dry(scene.at, scene);
    }

    /// Ends the multiplied PDOs of a node that booted.
    pub(in crate::problems) fn booted(&mut self, node: u8, scene: &mut Scene<'_>) {
        let sent = scene.ledger.last(scene.id, |one| {
            one.kind == ProblemKind::PdoMultiplied && one.subject.node == Some(node) && one.end.is_none()
        });
        if let Some(place) = sent {
            over(place, scene.at, scene);
        }
    }

    /// Evaluates a window; `at` begins the next one.
    fn window_over(&mut self, at: FrameRef, scene: &mut Scene<'_>) {
        let Window { begin, bits, frames, short, tight, lengths } =
            std::mem::replace(&mut self.window, Window { begin: at, ..Window::default() });
        let Some(lasted) = at.since(begin).filter(|lasted| frames > 0 && *lasted > Ns::ZERO) else { return };
        // Bits per millisecond are kbit/s.
        let used = Ns::from_ms(bits) / lasted.max(WINDOW_NS);
        let (rate, sure) = match scene.heard.bit_rate {
            Some(rate) => (i64::from(rate) / 1000, true),
            None => {
                let rate =
                    RATES.into_iter().find(|rate| used * 100 <= rate * 103 && self.is_possible(*rate)).unwrap_or(0);
                let same = std::mem::replace(&mut self.assumed, rate) == rate;
                // Frames of a single length may come evenly without filling the bus.
                let behind = tight * 2 > frames && lengths.count_ones() > 1;
                (rate, same && frames >= 20 && short * 20 < frames && behind)
            }
        };
        if rate > 0 && sure && used * 100 >= rate * OVERLOAD {
            if self.full == 0 {
                self.since = begin;
            }
            (self.full, self.relieved, self.last_full) = (self.full + 1, 0, at);
        } else if rate == 0 || used * 100 < rate * RELIEVED || !sure {
            (self.full, self.relieved) = (0, self.relieved + 1);
        }
        if self.flooded > 0 {
            self.dry(at, scene);
        }
        if self.full >= WINDOWS && self.open.is_none() {
            self.open = scene.ledger.open(ProblemKind::Overload, scene.id, Subject::default(), self.since, at);
            if let Some(one) = self.open.and_then(|place| scene.ledger.get_mut(place)) {
                let load = (used * 100 / rate).clamp(0, 100) as u64;
                one.fact("load_percent", Quantity::Count(load));
                one.fact("kbit_s", Quantity::Count(rate as u64));
                if scene.heard.bit_rate.is_none() {
                    one.grade = Grade::Likely;
                }
                one.step(self.since, StepRole::Sign, Saying::Loaded { load, rate: rate as u64 }, None);
            }
        }
        if self.relieved >= WINDOWS {
            self.relieve(self.last_full, scene);
        }
    }

    /// Returns true if the bus can have a bit rate, in kbit/s, by the shortest gaps of the capture.
    fn is_possible(&self, rate: i64) -> bool {
        let too_soon = RATES.iter().zip(self.faster).filter(|(other, _)| **other >= rate);
        let slow = RATES.iter().take(self.answered).any(|other| *other >= rate);
        !slow && too_soon.map(|(_, count)| count).sum::<u64>() <= (self.frames / UNEVEN).max(FEW)
    }

    fn relieve(&mut self, at: FrameRef, scene: &mut Scene<'_>) {
        if let Some(one) = self.open.take().and_then(|place| scene.ledger.get_mut(place)) {
            one.step(at, StepRole::Recovery, Saying::Recovered, None);
            one.ends(at);
        }
    }

    /// Records a start command of the NMT master to a running node.
    pub(in crate::problems) fn started_again(&mut self, node: u8, bus: &Bus) {
        for (identifier, one) in self.streams.iter_mut().enumerate() {
            let of_node = matches!(bus.carries(identifier as u16), Carries::Tpdo { node: other, .. } if other == node);
            if of_node && one.usual.is_even() {
                one.started = Some((one.usual.ns, FrameRef::default(), 0));
            }
        }
    }
}

/// Ends a problem.
fn over(place: LedgerPlace, at: FrameRef, scene: &mut Scene<'_>) {
    if let Some(one) = scene.ledger.get_mut(place) {
        one.step(at, StepRole::Recovery, Saying::Recovered, None);
        one.ends(at);
    }
}

/// Records a PDO that comes two or three times as often since a repeated start.
fn multiplied(identifier: usize, (before, now): (Ns, Ns), (since, at): (FrameRef, FrameRef), scene: &mut Scene<'_>) {
    let Carries::Tpdo { node, number } = scene.bus.carries(identifier as u16) else { return };
    let fits = [2, 3].into_iter().any(|times| (before - now * times).abs() <= before / 8);
    if !fits {
        return;
    }
    let subject = Subject { pdo: Some((true, number)), ..Subject::node(node) };
    if let Some(place) = scene.ledger.open(ProblemKind::PdoMultiplied, scene.id, subject, since, at)
        && let Some(one) = scene.ledger.get_mut(place)
    {
        one.fact("period", Quantity::Ns(before));
        one.fact("gap", Quantity::Ns(now));
    }
}

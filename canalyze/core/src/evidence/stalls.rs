//! Where the recorder stood still: silences of the whole bus behind which it lists what it kept.
//!
//! A recorder that stands still keeps frames in a buffer and stamps them all when it goes on. What it then lists is a
//! *burst*: after a silence of the whole bus that is longer than any lately, frames come without a pause until the
//! buffer is empty, and among them what should have come during the silence. Until that has shown, the burst is open. A
//! burst that is confirmed has no times of its own: each frame may have been sent at any time since the
//! silence began. One that is refuted was ordinary traffic.
//!
//! It must not know what a frame means.

use crate::frame::{Frame, Kind};

use super::duplicates::{Duplicates, PATIENCE_NS};
use super::senders::Senders;

/// A silence shorter than this is no stall, in ns: it moves no verdict.
pub(super) const SHORTEST_STALL_NS: i64 = 10_000_000;
/// Frames from a buffer follow each other within this time, in ns.
pub(super) const DRAIN_NS: i64 = 1_500_000;
/// By how much a silence must exceed the longest of late, in tenths, to be unusual.
pub(super) const UNUSUAL_TENTHS: i64 = 13;
/// The bit rate of the fastest bus, in ns a bit: no frame follows another in less than it takes itself.
const BIT_NS: i64 = 1_000;
/// The bits of a frame without data, without stuff bits.
const FRAME_BITS: i64 = 44;
/// Frames that were due at times further apart than this, and come at once, waited for the recorder, in ns.
const APART_NS: i64 = 3_000_000;
/// Frames of a burst by which it has shown that it is one; where it has not, it is ordinary traffic.
const SHOWN: u32 = 256;
/// Frames in which little is known of a bus yet.
const FIRST: u64 = 64;
/// Bursts remembered.
const BURSTS: usize = 8;
/// A silence that exceeds the longest of late so many times may be the recorder's, whoever ends it.
const ODD: i64 = 4;

/// What became of a burst.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Verdict {
    /// It still runs.
    #[default]
    Open,
    /// The recorder had stood still: its frames have no times of their own.
    Confirmed,
    /// Ordinary traffic after a silence.
    Refuted,
}

/// Frames without a pause after an unusual silence.
#[derive(Clone, Copy, Debug, Default)]
struct Burst {
    /// Its number, from 1, and that of its first frame.
    number: u32,
    first: u64,
    /// When the silence before it began, and when it ended, in ns.
    from_ns: i64,
    to_ns: i64,
    /// The silence was longer than those of late, or several senders were overdue in it: else only frames that cannot
    /// have been on the bus when they are stamped tell that it is one.
    unusual: bool,
    /// Frames in it.
    frames: u32,
    /// By how much its frames came later than they were due, at least and at most, in ns.
    late_ns: Option<(i64, i64)>,
    /// A CAN-ID came again in it.
    again: bool,
    /// It has shown that it is one, unless the capture shows frames twice.
    shown: bool,
    verdict: Verdict,
}

/// The silences of a bus, and what became of the bursts behind them.
#[derive(Debug, Default)]
pub(super) struct Stalls {
    senders: Senders,
    /// Mean gap between frames, in 64ths of ns.
    mean_gap_64: i64,
    /// The longest gap of late, in ns.
    usual_gap_ns: i64,
    bursts: Vec<Burst>,
    /// The last burst still runs: no pause has come since it began.
    running: bool,
    /// Frames, and those that stand closer to the one before than they can be on a bus.
    frames: u64,
    gaps: u64,
    close: u64,
}

impl Stalls {
    /// Takes a frame's time (the last one's, and its own, in ns). `original`: it is no duplicate; what may be one shows
    /// nothing until that is decided. `grain_ns`: the resolution of the stamps.
    pub(super) fn follow(&mut self, frame: &Frame, (last, now): (Option<i64>, i64), original: bool, grain_ns: i64) {
        self.frames += 1;
        let Some(last) = last else {
            self.senders.see(frame, now, 4 * DRAIN_NS);
            return;
        };
        let gap = now.saturating_sub(last).max(0);
        if gap > DRAIN_NS || self.has_caught_up(now) {
            self.end_burst();
        }
        let overdue = if gap > SHORTEST_STALL_NS { self.senders.overdue(last, now, APART_NS) } else { 0 };
        let unusual = overdue > 1 || self.is_unusual(gap);
        if unusual || overdue > 0 {
            self.begin_burst(Burst { from_ns: last, to_ns: now, first: frame.no, unusual, ..Burst::default() });
        }
        let late_ns = self.lateness(frame, now);
        let before_ns = self.senders.came_before(frame, now);
        let compressed = self.senders.see(frame, now, 4 * DRAIN_NS);
        self.compare_later(before_ns);
        let too_close = self.is_too_close(frame, gap, grain_ns);
        if !self.running {
            return self.know_gap(gap);
        }
        let mean = self.mean_gap_64 / 64;
        let Some(burst) = self.bursts.last_mut() else { return };
        burst.frames += 1;
        if burst.verdict != Verdict::Open {
            return;
        }
        if let Some(late_ns) = late_ns {
            let (least, most) = burst.late_ns.unwrap_or((late_ns, late_ns));
            burst.late_ns = Some((least.min(late_ns), most.max(late_ns)));
        }
        if let Some((id, gap_ns)) = before_ns.filter(|(_, gap_ns)| *gap_ns <= now.saturating_sub(burst.to_ns))
            && self.senders.squeeze(id, gap_ns)
        {
            burst.again = true;
        }
        let at_once = burst.late_ns.is_some_and(|(least, most)| most.saturating_sub(least) > APART_NS);
        let expected = now.saturating_sub(burst.from_ns) / mean.max(1);
        let many = burst.frames > 2 && i64::from(burst.frames) * 10 >= expected.saturating_mul(6);
        let dense = burst.unusual && (compressed || many);
        if burst.frames > 1 && (dense || at_once || too_close) {
            burst.shown = true;
            if original {
                burst.verdict = Verdict::Confirmed;
            }
        } else if burst.frames > SHOWN && !burst.shown {
            self.end_burst();
        }
    }

    /// By how much a frame of a burst comes later than it was due, in ns.
    fn lateness(&self, frame: &Frame, now: i64) -> Option<i64> {
        let from = self.bursts.last().filter(|_| self.running)?.from_ns;
        self.senders.lateness(frame, from, now)
    }

    /// Whether a frame follows the one before in less time than it takes on the fastest bus, where that is rare: it was
    /// kept in a buffer.
    fn is_too_close(&mut self, frame: &Frame, gap: i64, grain_ns: i64) -> bool {
        let close = gap < wire_ns(frame);
        if !self.running {
            self.gaps += 1;
            self.close += u64::from(close);
        }
        close && self.close * 16 <= self.gaps && grain_ns < wire_ns(frame)
    }

    /// At the beginning of a capture nothing is known of its CAN-IDs: a burst in which one came again is decided by how
    /// often that one comes behind it.
    fn compare_later(&mut self, before_ns: Option<(usize, i64)>) {
        let Some(burst) = self.bursts.last_mut().filter(|burst| burst.verdict == Verdict::Open) else { return };
        if self.running {
            return;
        }
        burst.frames += 1;
        if burst.frames > SHOWN {
            burst.verdict = Verdict::Refuted;
        }
        let Some((id, gap_ns)) = before_ns else { return };
        let squeezed_ns = self.senders.squeezed_ns(id);
        if squeezed_ns > 0 && gap_ns > 4 * squeezed_ns.max(DRAIN_NS) {
            burst.verdict = Verdict::Confirmed;
        }
    }

    fn begin_burst(&mut self, burst: Burst) {
        self.refute();
        let number = self.bursts.last().map_or(0, |burst| burst.number) + 1;
        if self.bursts.len() == BURSTS {
            self.bursts.remove(0);
        }
        self.bursts.push(Burst { number, ..burst });
        self.running = true;
    }

    /// Whether the buffer must be empty by now: it fills no faster than it is emptied.
    fn has_caught_up(&self, now: i64) -> bool {
        let burst = self.bursts.last().filter(|_| self.running);
        burst.is_some_and(|burst| now.saturating_sub(burst.to_ns) > burst.to_ns.saturating_sub(burst.from_ns))
    }

    /// The frames after a silence have come to a pause: they were ordinary traffic unless they have shown otherwise.
    pub(super) fn end_burst(&mut self) {
        if !std::mem::take(&mut self.running) {
            return;
        }
        let first = self.frames <= FIRST;
        let Some(burst) = self.bursts.last_mut().filter(|burst| burst.verdict == Verdict::Open) else { return };
        if burst.shown || first && burst.again {
            return;
        }
        burst.verdict = Verdict::Refuted;
        let silence = burst.to_ns.saturating_sub(burst.from_ns);
        self.know_gap(silence);
    }

    /// Whether the capture shows frames twice is decided: so is what frames have shown that might have been duplicates.
    pub(super) fn decide_shown(&mut self, duplicates: &Duplicates) {
        if duplicates.undecided_since().is_some() {
            return;
        }
        let twice = duplicates.are_proven();
        if let Some(burst) = self.bursts.last_mut().filter(|burst| burst.verdict == Verdict::Open && burst.shown) {
            burst.verdict = if twice { Verdict::Refuted } else { Verdict::Confirmed };
        }
    }

    /// No further frame tells: what is open is decided by what was seen.
    pub(super) fn settle(&mut self, duplicates: &Duplicates) {
        self.end_burst();
        self.decide_shown(duplicates);
        self.refute();
    }

    /// It is `now_ns` on a live bus, and the last frame came at `last_ns`.
    pub(super) fn advance(&mut self, last_ns: Option<i64>, now_ns: i64, duplicates: &Duplicates) {
        if last_ns.is_some_and(|last| now_ns.saturating_sub(last) > DRAIN_NS) {
            self.end_burst();
        }
        self.decide_shown(duplicates);
        // Nobody who watches a live bus waits long for what comes behind a burst.
        if self.bursts.last().is_some_and(|burst| now_ns.saturating_sub(burst.to_ns) > PATIENCE_NS) {
            self.end_burst();
            self.refute();
        }
    }

    /// The number of the first frame of which it is not known yet whether it is in a burst.
    pub(super) fn undecided_since(&self) -> Option<u64> {
        self.bursts.last().filter(|burst| burst.verdict == Verdict::Open).map(|burst| burst.first)
    }

    /// The number of the burst that runs; 0: none.
    pub(super) fn running(&self) -> u32 {
        self.bursts.last().filter(|_| self.running).map_or(0, |burst| burst.number)
    }

    /// What became of a burst; `None` where it is none, or forgotten: then it was settled long ago.
    pub(super) fn verdict(&self, burst: u32) -> Option<Verdict> {
        self.burst(burst).map(|burst| burst.verdict)
    }

    /// Whether a frame is the first of a burst that is confirmed.
    pub(super) fn is_first_of_confirmed(&self, burst: u32, number: u64) -> bool {
        self.confirmed(burst).is_some_and(|burst| burst.first == number)
    }

    /// When the silence began before a burst that is confirmed, in ns.
    pub(super) fn since_ns(&self, burst: u32) -> Option<i64> {
        self.confirmed(burst).map(|burst| burst.from_ns)
    }

    /// The last silence that was the recorder's: when it began and when it ended, in ns.
    pub(super) fn last_stall(&self) -> Option<(i64, i64)> {
        let burst = self.bursts.iter().rev().find(|burst| burst.verdict == Verdict::Confirmed)?;
        Some((burst.from_ns, burst.to_ns))
    }

    /// The nodes, one bit each, of which a frame had been expected, by so many tenths of its usual gap, during a silence,
    /// if it is longer than any of late.
    pub(super) fn missing(&self, from: i64, to: i64, tenths: i64) -> u128 {
        if self.is_unusual(to.saturating_sub(from)) { self.senders.missing(from, to, tenths) } else { 0 }
    }

    /// Whether a silence exceeds the longest of late several times.
    pub(super) fn is_odd(&self, silence_ns: i64) -> bool {
        self.usual_gap_ns > 0 && silence_ns / ODD > self.usual_gap_ns
    }

    /// Whether a silence is longer than those of late.
    fn is_unusual(&self, gap: i64) -> bool {
        gap > SHORTEST_STALL_NS && gap / UNUSUAL_TENTHS > self.usual_gap_ns / 10
    }

    fn confirmed(&self, number: u32) -> Option<&Burst> {
        self.burst(number).filter(|burst| burst.verdict == Verdict::Confirmed)
    }

    fn burst(&self, number: u32) -> Option<&Burst> {
        if number == 0 { None } else { self.bursts.iter().rev().find(|burst| burst.number == number) }
    }

    /// A burst that is still open was ordinary traffic.
    fn refute(&mut self) {
        if let Some(burst) = self.bursts.last_mut().filter(|burst| burst.verdict == Verdict::Open) {
            burst.verdict = Verdict::Refuted;
        }
    }

    /// Takes an ordinary gap between frames.
    fn know_gap(&mut self, gap: i64) {
        let gap = gap.min(i64::MAX / 128);
        self.usual_gap_ns = (self.usual_gap_ns - self.usual_gap_ns / 256).max(gap);
        self.mean_gap_64 += if self.mean_gap_64 == 0 { gap * 64 } else { gap - self.mean_gap_64 / 64 };
    }
}

/// How long a frame takes at least, in ns: on the fastest bus, without stuff bits.
pub(super) fn wire_ns(frame: &Frame) -> i64 {
    match frame.kind {
        Kind::Data => (FRAME_BITS + 8 * i64::from(frame.len)) * BIT_NS,
        _ => FRAME_BITS * BIT_NS,
    }
}
